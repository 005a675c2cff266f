"""What the orbit of one system is, with the evidence: `classify`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import choice, whole
from nlds_vines.model.catalog import as_system
from nlds_vines.model.labels import FLAGS, least_lifetime
from nlds_vines.model.system import System
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.compilation import notice
from nlds_vines.orbits.records import OK, USUAL
from nlds_vines.orbits.simulation import IntegrationError, start_state
from nlds_vines.orbits.solver_settings import EFFORTS, METHODS, chosen_settings

_KINDS = {code: name for name, code in FLAGS.items()}


@dataclass(frozen=True, repr=False)
class Regime(Outlined):
    """What an orbit is, and why.

    Attributes:
        label: in the paper's words: `T,1`, `3T,2`, `chaos`, `transient chaos to T,0` ...
        kind: periodic, quasiperiodic, chaotic, transient_chaos or undetermined (`labels.FLAGS`).
        period: n of nT; 0 where there is none.
        impacts: k per nT; of what is not periodic, those of the sampled window.
        impacts_by_wall: the same at the near and at the far wall.
        multipliers: Floquet multipliers of the nT orbit, complex, the largest modulus first; None
            of what is not periodic.
        lyapunov: the largest exponent [1/s]; of a periodic orbit ln |mu| / nT.
        lyapunov_width: half the width of its 99 % interval; 0 for a periodic orbit.
            Longer runs lie in it if the motion is stationary. Chaos without damping is not: its
            energy diffuses.
        exponents: all of them [1/s]; they sum up to -(c1 + c2)/m1 - c2/m2.
        residual: by how much a periodic orbit does not close, relative to the orbit (energy norm).
        E1max, E2max: largest energies [J] of structure and damper in the sampled periods.
        point: of the periodic orbit's section (x1, v1, x2, v2) [m, m/s]: a start on the orbit.
        clearance: [m] smallest near miss of the periodic orbit, inf without any; softest: [m/s]
            slowest impact.  Both tell how far grazing is.
        settling: forcing periods until the section obeys the final orbit's own law; -1 if never.
        averaging: digits to which time averages agree, of what is not periodic: many on a torus.
        watched: forcing periods looked at, from the orbit's start.
        transient_lyapunov, transient_lyapunov_width: of the time before a late settling [1/s].

    NaN (None) where something does not apply.
    """

    system: System
    label: str
    kind: str
    period: int
    impacts: int
    impacts_by_wall: tuple[int, int]
    multipliers: np.ndarray | None
    lyapunov: float
    lyapunov_width: float
    exponents: np.ndarray
    residual: float
    E1max: float
    E2max: float
    point: np.ndarray | None
    clearance: float
    softest: float
    settling: int
    averaging: float
    watched: int
    transient_lyapunov: float
    transient_lyapunov_width: float

    def heading(self) -> str:
        """Return the label."""
        return f"{self.label} ({self.kind})"

    def outline(self) -> Rows:
        """Return the evidence in a few lines."""
        yield "system", self.system.heading()
        where = f"{self.watched} periods watched"
        settled = f"settled after {self.settling}" if self.settling >= 0 else "not settled"
        each = f"n = {self.period}, " if self.period else ""
        yield "orbit", f"{each}{self.impacts} impacts; {settled} forcing periods, {where}"
        if self.multipliers is not None:
            moduli = ", ".join(f"{abs(mu):.6g}" for mu in self.multipliers)
            yield "multipliers", f"moduli {moduli}; residual {self.residual:.2g}"
        width = f" +- {self.lyapunov_width:.2g}" if self.lyapunov_width else ""
        yield "largest exponent", f"{self.lyapunov:.6g}{width} 1/s"

    @property
    def least_lifetime(self) -> float:
        """The mean lifetime [forcing periods] that chaos has at least, if it is transient.

        NaN of what is not `chaos`.  See `labels.least_lifetime`.
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
) -> Regime:
    """Say what the orbit of a system is, from a start, and return the evidence.

    Arguments:
        system: a `System`, the name of one, or the path of a TOML file.
        start: (x1, v1, x2, v2) [m, m/s] at t = 0, by default at rest; without a damper (x1, v1).
        transient, periods: forcing periods passed over and looked at first.
        method: `exact` or `rk4`.
        effort: quick, standard or thorough: how many further periods a verdict may take.  A
            periodic orbit ends the search; chaos and a torus are followed for all of them.
        tolerance: of `exact`, as `simulate` takes it.
        quiet: whether not to say that something is compiled.

    Raises `RequestError` for a wrong argument, `IntegrationError` where the orbit ends early.
    docs/scans.md holds the decision table.  Cost: as `simulate` for a periodic orbit, once
    compiled; some 0.05 s for a chaotic one.
    """
    system = as_system(system)
    before, sampled = whole("transient", transient, 0), whole("periods", periods, 1)
    how = choice("method", method, METHODS), choice("effort", effort, EFFORTS)
    settings = chosen_settings(method, {"tolerance": tolerance})
    kernels = Kernels(Wanted(system.scene, USUAL, *how, settings), notice(quiet))
    cells = np.atleast_2d(system.cells())
    state = start_state(system, float(cells["rest"][0, 0]), start)
    outputs = kernels.run(cells, state[np.newaxis, :4], before, sampled)
    code = int(outputs.status[0, 0])
    if code != OK:
        raise IntegrationError.of(system, code)
    arrays = outputs.verdicts(cells)
    assert outputs.energy is not None
    datasets = {name: values[0, 0] for name, values in arrays.items()}
    return _regime(system, datasets, outputs.energy[0, 0])


def _regime(system: System, evidence: dict[str, Any], energy: np.ndarray) -> Regime:
    """Return the `Regime` in the datasets of one lane."""
    periodic = evidence["periodicity"] > 0
    pairs = evidence["multipliers"]
    near, far = (int(count) for count in evidence["impacts_by_wall"])
    return Regime(
        system=system,
        label=str(evidence["label"]),
        kind=_KINDS[int(evidence["regime"])],
        period=int(evidence["periodicity"]),
        impacts=int(evidence["impact_count"]),
        impacts_by_wall=(near, far),
        multipliers=pairs[:, 0] + 1j * pairs[:, 1] if periodic else None,
        lyapunov=float(evidence["lyapunov"]),
        lyapunov_width=float(evidence["lyapunov_width"]),
        exponents=evidence["exponents"],
        residual=float(evidence["residual"]),
        E1max=float(energy[0]),
        E2max=float(energy[1]),
        point=evidence["orbit_point"] if periodic else None,
        clearance=float(evidence["orbit_clearance"]),
        softest=float(evidence["softest_impact"]),
        settling=int(evidence["settling"]),
        averaging=float(evidence["averaging"]),
        watched=int(evidence["watched"]),
        transient_lyapunov=float(evidence["transient_lyapunov"]),
        transient_lyapunov_width=float(evidence["transient_lyapunov_width"]),
    )
