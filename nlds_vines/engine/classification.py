"""The regime of one orbit with its evidence, `classify`, and all its Lyapunov exponents."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.engine.batch import Wanted
from nlds_vines.engine.compilation import Compilation, Needed, notice
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.one_orbit import IntegrationError
from nlds_vines.engine.records import USUAL, noted
from nlds_vines.engine.simulation import refuse_without_room
from nlds_vines.engine.solver_settings import EFFORTS, chosen_settings
from nlds_vines.errors import choice, truth, whole
from nlds_vines.kernels.cells import cycles
from nlds_vines.kernels.cells.verdict import BATCHES, QUANTILE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.catalog import any_system
from nlds_vines.model.labels import FLAGS, least_lifetime
from nlds_vines.model.system import System
from nlds_vines.runs.interrupts import stoppable

_KINDS = {code: name for name, code in FLAGS.items()}

_NUMBERS = (
    "lyapunov",
    "lyapunov_width",
    "residual",
    "averaging",
    "transient_lyapunov",
    "transient_lyapunov_width",
)  # of a `Regime`, by the names of datasets

# default number of periods of a Lyapunov spectrum, and those before in which variations align
PERIODS, ALIGNING = 3200, 100

UNDEFINED = (
    "undefined if the motion depends on the order in which bodies strike several walls at one "
    "instant (docs/hosts.md)"
)


@dataclass(frozen=True, repr=False)
class Regime(Outlined):
    """The regime of an orbit with the evidence for it; NaN or None if a quantity does not apply.

    Attributes
    ----------
    system : System
        The system.
    label : str
        The label of the paper: "T,1", "3T,2", "chaos", "transient chaos to T,0" ...; of a host with
        several dampers with their shares, "2T,3 (2+1)".
    kind : str
        periodic, quasiperiodic, chaotic, transient_chaos or undetermined.
    period : int
        n of an nT orbit; 0 if it is not periodic.
    impacts : int
        Impacts per nT; -1 without a period.
    impacts_by_wall : mapping of str to int
        The same at each wall, by the body that it belongs to, "obstacle" or "structure"; of a host
        by damper and side, "cell+".
    impact_rate : float
        Impacts per forcing period, in the sampled ones.
    multipliers : (4,) complex ndarray
        Floquet multipliers of the nT orbit, the largest modulus first; None without a period.
    lyapunov : float
        Largest Lyapunov exponent [1/s]; ln |mu| / nT of a periodic orbit.
    lyapunov_width : float
        Half width of its 99 % interval, 0 of a periodic orbit.  Longer runs lie in the interval if
        the motion is stationary; chaos without damping is not, as its energy diffuses.
    exponents : (4,) ndarray
        All Lyapunov exponents [1/s].  On a damped host without a period only the first four are
        measured, and the others are NaN.
    residual : float
        Closing error of the periodic orbit in the energy norm, relative to the orbit.
    E1max, E2max : float
        Largest energies [J] of structure and damper in the sampled periods; E2max of a host has one
        number for each damper.
    point : (4,) ndarray
        A section point x1, v1, x2, v2 [m, m/s] of the periodic orbit; None without a period.  That
        of a host has its `scene.components`, and so many multipliers and exponents.
    state : (4,) ndarray
        `point`, or the state x1, v1, x2, v2 [m, m/s] at the end of the sampled periods.
    clearance : float
        Smallest distance [m] of a pass of the periodic orbit that misses a wall; inf without any.
    softest : float
        Smallest approach speed [m/s] of its impacts.
    settling : int
        The forcing period from which on every return obeys the multipliers of the final orbit, so
        that its distance shrinks as they say; -1 if none.  The distance may still be large: an
        orbit without impacts obeys them from the start, with 0.
    averaging : float
        Digits to which the averages over two halves of an orbit without a period agree.
    watched : int
        Forcing periods from the start of the orbit on which the verdict rests.
    transient_lyapunov, transient_lyapunov_width : float
        Largest exponent [1/s] before a late settling, and the half width of its interval.
    """

    system: System
    label: str
    kind: str
    period: int
    impacts: int
    impacts_by_wall: Mapping[str, int]
    impact_rate: float
    multipliers: np.ndarray | None
    lyapunov: float
    lyapunov_width: float
    exponents: np.ndarray
    residual: float
    E1max: float
    E2max: float | np.ndarray
    point: np.ndarray | None
    state: np.ndarray
    clearance: float
    softest: float
    settling: int
    averaging: float
    watched: int
    transient_lyapunov: float
    transient_lyapunov_width: float

    def heading(self) -> str:
        """Return label and kind."""
        return f"{self.label} ({self.kind})"

    def outline(self) -> Rows:
        """Return the evidence in a few lines."""
        yield "system", self.system.heading()
        per = "T" if self.period == 1 else f"{self.period}T"
        impacts = "1 impact" if self.impacts == 1 else f"{self.impacts} impacts"
        orbit = f"{impacts} per {per}" if self.period else "not periodic"
        if self.settling >= 0:
            settled = f"obeys its multipliers from period {self.settling} on; followed for"
        else:
            settled = "not settled in"
        yield "orbit", f"{orbit}; {settled} {self.watched} forcing periods"
        if self.multipliers is not None:
            moduli = ", ".join(f"{abs(mu):.6g}" for mu in self.multipliers)
            yield "Floquet multipliers", f"moduli {moduli}; residual {self.residual:.2g}"
        if math.isnan(self.lyapunov):
            yield "Lyapunov exponents [1/s]", f"not measured by the effort quick; {UNDEFINED}"
            return
        width = f" +- {self.lyapunov_width:.2g}" if self.lyapunov_width else ""
        measured = self.exponents[~np.isnan(self.exponents)]
        others = "".join(f"; {value:.4g}" for value in measured[1:].tolist())
        before = ""
        if np.isfinite(self.transient_lyapunov):
            size = f"{self.transient_lyapunov:.2g} +- {self.transient_lyapunov_width:.2g}"
            before = f"; transient {size}"
        yield "Lyapunov exponents [1/s]", f"{self.lyapunov:.6g}{width}{others}{before}"

    def lyapunov_spectrum(self, periods: int = PERIODS, *, quiet: bool = False) -> LyapunovSpectrum:
        """Follow the orbit further and return all Lyapunov exponents with their convergence.

        Parameters
        ----------
        periods : int
            Number of forcing periods, >= 16; 100 periods before align the variations.
        quiet : bool
            Whether to suppress the message about compiling.

        Returns
        -------
        LyapunovSpectrum
            Exponents, their 99 % intervals, running means, and the mean divergence.

        Raises
        ------
        RequestError
            If the number of periods is wrong.
        IntegrationError
            If the integration fails.

        Notes
        -----
        The variations are orthonormalized after each period.  Once compiled, 3200 periods of
        an SSul NES take 0.4 s.

        References
        ----------
        Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980) 9 and 21.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> regime = nv.classify("ssul-set6", omega=5.5, quiet=True)
        >>> spectrum = regime.lyapunov_spectrum(320, quiet=True)
        >>> bool(abs(spectrum.exponents - regime.exponents).max() < 1 / spectrum.times[-1])
        True
        >>> bool(abs(spectrum.exponents.sum() - spectrum.divergence) < 1e-9)
        True
        """
        return lyapunov_spectrum(self.system, self.state, periods, quiet)

    @property
    def least_lifetime(self) -> float:
        """The least mean lifetime [forcing periods] of chaos that may be transient.

        NaN unless the kind is chaotic.  See `labels.least_lifetime`.
        """
        return least_lifetime(self.watched) if self.kind == "chaotic" else float("nan")


def classify(
    system: System | str | os.PathLike[str],
    *,
    start: Sequence[float] | np.ndarray | None = None,
    transient: int = 600,
    periods: int = 120,
    method: str = "exact",
    effort: str = "standard",
    tolerance: float | str | None = None,
    quiet: bool = False,
    **overrides: float | str,
) -> Regime:
    """Classify the orbit of a system from a start, and return the evidence.

    Parameters
    ----------
    system : System, str or path-like
        A system, its name in the catalog, or the path of a TOML file.
    start : (4,) array_like, optional
        The state x1, v1, x2, v2 [m, m/s] at t = 0, by default at rest; without a damper x1, v1; of
        a host its `scene.components`.
    transient, periods : int
        Forcing periods before the sampled ones, and those.
    method : str
        "exact" or "rk4".
    effort : str
        "quick", "standard" or "thorough": the further periods that a verdict may take.  A periodic
        orbit ends the search; chaos and tori are followed for all of them.
    tolerance : float or str, optional
        Of "exact", as in `simulate`.
    quiet : bool
        Whether to suppress the message about compiling.
    **overrides : float or str
        Parameters of the system that replace its own, as in `load_system`.

    Returns
    -------
    Regime
        The label and its evidence.

    Raises
    ------
    RequestError
        If an argument is wrong.
    IntegrationError
        If the integration fails.

    Notes
    -----
    docs/scans.md holds the decision table.  Once compiled, a T,1 orbit takes some 1 ms
    (`python -m benchmarks.speed classify`, 50 calls).

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.classify("ssul-set6", omega=5.5, quiet=True).label
    'T,1'
    """
    system = any_system(system)
    if overrides:
        system = system.with_(**overrides)
    before, sampled = whole("transient", transient, 0), whole("periods", periods, 1)
    truth("quiet", quiet)
    rows = noted(USUAL, before, sampled)
    refuse_without_room(("section",), rows, 1, len(system.scene.components))
    engine = engine_for(system)
    how = choice("method", method, system.scene.methods), choice("effort", effort, EFFORTS)
    settings = chosen_settings(method, {"tolerance": tolerance})
    wanted = Wanted(system.scene, USUAL, *how, settings)
    runner = engine.runner(wanted, notice(quiet), of=(), helped=True)
    cells, state = np.atleast_2d(system.cells()), engine.start(start)
    outputs = runner.run(cells, state[np.newaxis], before, sampled)
    if (code := int(outputs.status[0, 0])) != OK:
        raise IntegrationError.of(system, code)
    evidence = {name: values[0, 0] for name, values in runner.verdicts(outputs, cells).items()}
    E1max, E2max = engine.energies(outputs.buffers.energy[0, 0])
    periodic, pairs = evidence["periodicity"] > 0, evidence["multipliers"]
    return Regime(
        system=system,
        label=str(evidence["label"]),
        kind=_KINDS[int(evidence["regime"])],
        period=int(evidence["periodicity"]),
        impacts=int(evidence["impact_count"]),
        impacts_by_wall=engine.counts(evidence["impacts_by_wall"].tolist()),
        impact_rate=float(outputs.by_wall[0, 0].sum()) / sampled,
        multipliers=pairs[:, 0] + 1j * pairs[:, 1] if periodic else None,
        exponents=evidence["exponents"],
        E1max=E1max,
        E2max=E2max,
        point=evidence["orbit_point"] if periodic else None,
        state=evidence["orbit_point"] if periodic else outputs.buffers.section[0, 0, -1].copy(),
        clearance=float(evidence["orbit_clearance"]),
        softest=float(evidence["softest_impact"]),
        settling=int(evidence["settling"]),
        watched=int(evidence["watched"]),
        **{name: float(evidence[name]) for name in _NUMBERS},
    )


# ---- the Lyapunov spectrum ----
#
# The variations of an orbit are propagated from section to section by the derivative of the
# stroboscopic map, and orthonormalized after each period.  (The verdicts of scans measure the
# largest exponent with its interval in `kernels.cells.verdict`.)


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(Outlined):
    """The Lyapunov exponents of an orbit with their convergence.

    Their order is that of Gram and Schmidt, which tends to put the largest first.

    The exponent 0 of the phase of the force is not among them.

    Attributes
    ----------
    exponents : (4,) ndarray
        Mean growth rates [1/s]; two without a damper, as many as components of the state of a
        host; -inf for variations that contacts reduce to zero.
    widths : (4,) ndarray
        Half widths of their 99 % intervals [1/s], from the means of 16 successive batches; 0 for
        exponents of -inf.
    times : (periods,) ndarray
        Times [s] at the ends of the periods, from the end of the `ALIGNING` periods.
    running : (periods, 4) ndarray
        Mean growth rates [1/s] up to these times; the last row is `exponents`.
    divergence : float
        Mean divergence [1/s] of the flow and the contacts, computed apart from the exponents. Their
        sum equals it: -(c1 + c2) / m1 - c2 / m2 if contacts dissipate nothing, of a host
        -tr(M^-1 C).  Each rigid impact adds 2 ln e over the time; -inf if one leaves no volume.
    """

    exponents: np.ndarray
    widths: np.ndarray
    times: np.ndarray
    running: np.ndarray
    divergence: float

    @property
    def dimension(self) -> float:
        """The dimension of the section by Kaplan and Yorke; that of the flow is greater by one.

        j + (sum of the first j exponents) / |exponent j + 1|, with the largest j whose sum is not
        negative.
        """
        sums = np.cumsum(self.exponents)
        j = int(np.count_nonzero(sums >= 0.0))
        if j in (0, len(sums)):
            return float(j)
        return j + float(sums[j - 1] / abs(self.exponents[j]))

    def outline(self) -> Rows:
        """Return the exponents with their intervals, and the check of their sum."""
        if np.isnan(self.exponents).any():
            yield "exponents [1/s]", UNDEFINED
            return
        pairs = zip(self.exponents.tolist(), self.widths.tolist(), strict=True)
        yield "exponents [1/s]", "; ".join(f"{e:.4g} +- {width:.1g}" for e, width in pairs)
        total = float(self.exponents.sum())
        is_known = math.isfinite(self.divergence)
        check = f"; mean divergence {self.divergence:.10g}" if is_known else ""
        yield "sum [1/s]", f"{total:.10g}{check}"
        yield "averages over", f"{len(self.times)} forcing periods, {self.times[-1]:.6g} s"


def lyapunov_spectrum(
    system: System,
    start: Sequence[float] | np.ndarray | None,
    periods: int = PERIODS,
    quiet: bool = False,
) -> LyapunovSpectrum:
    """Return the Lyapunov spectrum of the orbit from `start` over `periods`, after `ALIGNING`."""
    whole("periods", periods, BATCHES)
    truth("quiet", quiet)
    needed = Needed(system.scene.key, "exact", ())
    logs, volume = _growth(
        system, start, ALIGNING + periods, Compilation(needed, notice(quiet), False)
    )
    times = system.period * np.arange(1, periods + 1)
    running = np.cumsum(logs[ALIGNING:], axis=0) / times[:, np.newaxis]
    each = periods // BATCHES
    batches = logs[-each * BATCHES :].reshape(BATCHES, each, -1).mean(axis=1) / system.period
    with np.errstate(invalid="ignore"):  # -inf, which has no width
        widths = QUANTILE * batches.std(axis=0, ddof=1) / math.sqrt(BATCHES)
    divergence = float(volume[ALIGNING:].sum()) / float(times[-1])
    return LyapunovSpectrum(running[-1], np.nan_to_num(widths), times, running, divergence)


@stoppable
def _growth(
    system: System,
    start: Sequence[float] | np.ndarray | None,
    periods: int,
    compilation: Compilation,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the logarithms of the growth of orthonormal variations and of volumes in each period.

    Shapes (periods, size) and (periods,).  Components are in energy norms of their unit states.
    """
    size = len(system.scene.components)
    logs, volume = np.empty((periods, size)), np.empty(periods)
    variations = engine_for(system).variations(start)
    traced, norms, y = variations.traced, variations.norms, variations.state
    with compilation.followed({variations.kernel: "branches"}):
        vectors = np.eye(size)  # one row each
        for p in range(periods):
            status = variations.step(y)
            if status != OK:
                raise IntegrationError.of(system, status)
            y, volume[p] = traced.points[0].copy(), traced.numbers[cycles.LOG_DETERMINANT]
            scaled = traced.matrix * norms[:, np.newaxis] / norms
            images = (scaled * vectors[:, np.newaxis, :]).sum(axis=2)
            vectors, logs[p] = _orthonormalized(images)
    return logs, volume


def _orthonormalized(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows orthonormalized by Gram and Schmidt, and the logarithms of their lengths."""
    result, lengths = np.zeros_like(vectors), np.zeros(len(vectors))
    for i, vector in enumerate(vectors):
        for _ in range(2):  # twice suffices for orthogonality to round-off
            for other in result[:i]:
                vector = vector - (vector * other).sum() * other
        lengths[i] = math.sqrt(float((vector * vector).sum()))
        if lengths[i] > 0.0:  # otherwise it stays 0
            result[i] = vector / lengths[i]
    with np.errstate(divide="ignore"):
        return result, np.log(lengths)
