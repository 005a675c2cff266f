"""One orbit as arrays for the panels of the page, in words, and as files that repeat it.

`simulate` gives the orbit and `classify` its label, which equals the archive's for the same start
and sampling.  The first orbit imports the kernels.
"""

from __future__ import annotations

import base64
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import nlds_vines as nv
from nlds_vines.explore.map_data import MOST_CURVES, Curve, curves_of

Arrays = dict[str, np.ndarray]

SHOW, LONG = 12, 100  # forcing periods of a settled or short history, and of a longer one
MOST_PERIODS = 2000  # the most periods of a history from the start, which take 0.05 s
MOST_POINTS = 1000  # points of a curve over time, more than a wide panel has pixels

RAD, HZ = "rad/s", "Hz"  # units of frequencies

SETTLED = "settled"

HISTORIES: Mapping[str, str] = {
    SETTLED: f"{SHOW} periods, settled",
    "short": f"the first {SHOW} periods",
    "long": f"the first {LONG} periods",
    "whole": f"from the start, up to {MOST_PERIODS} periods",
}
"""The time histories that a page can show, with their names in words."""

SAMPLES = 256  # states per period, about five in a contact; the list of impacts has the exact peak

MOST_PHASE_PERIODS = 24  # of a phase trajectory; more of a chaotic one would fill the plane
HIGHEST = 12.0  # the highest frequency of the spectrum, in multiples of the forcing frequency
_FLOOR = 1e-12  # of a spectrum, relative to its largest line; smaller lines are round-off
# the names of saved files
PORTRAIT_FILE, SCAN_FILE, PICTURE_FILE = "portrait.toml", "part.toml", "portrait.png"


@dataclass(frozen=True)
class LiveOrbit:
    """An orbit, and the request of its portrait.

    If `classify` failed, `regime` is None and `trouble` gives the reason.
    """

    orbit: Any  # of `simulate`, with its trajectory
    regime: nv.Regime | None
    trouble: str
    panels: Mapping[str, Arrays]
    request: nv.PortraitRequest

    @property
    def label(self) -> str:
        """The label of the regime; without a regime, the period by recurrence alone."""
        if self.regime is not None:
            return self.regime.label
        n = self.orbit.recurrence
        if not n:
            return "undetermined"
        return "T" if n == 1 else f"{n}T"


def live_orbit(
    system: nv.System,
    start: Sequence[float] | None,
    scan: nv.Scan,
    history: str = SETTLED,
    unit: str | None = RAD,
) -> LiveOrbit:
    """Follow and classify an orbit with the sampling of a `scan`.

    Raises `RequestError` for an impossible start and for an orbit that ends early.  Once compiled,
    a periodic orbit of an SSul NES takes 4 ms, chaos up to 0.1 s, and a history from the start 0.02
    s more per thousand periods.
    """
    begin, end = scan.transient, scan.transient + max(scan.periods, SHOW)
    tolerance = scan.tolerance if scan.method == "exact" else None
    how: dict[str, Any] = {"start": start, "method": scan.method, "tolerance": tolerance}
    records = ("trajectory", "impacts") if system.scene.walls else ("trajectory",)

    def follow(begin: int, end: int) -> Any:
        periods = end - begin
        return nv.simulate(system, periods, transient=begin, samples=SAMPLES, record=records, **how)

    regime, trouble = None, ""
    shown = {"long": LONG, "whole": min(begin + SHOW, MOST_PERIODS)}.get(history, SHOW)
    try:
        orbit = follow(begin, end)
        try:
            regime = nv.classify(
                system, transient=scan.transient, periods=scan.periods, effort=scan.effort, **how
            )
        except (nv.IntegrationError, nv.RequestError) as error:
            trouble = str(error)
        seen = orbit if history == SETTLED else follow(0, shown)
    except nv.IntegrationError as error:
        raise nv.RequestError(str(error)) from None
    curves = curves_of(system, scan.of)
    panels = {"history": history_of(seen, curves, shown), **panels_without_time(orbit, curves)}
    multipliers = np.empty(0, complex)
    if regime is not None and regime.multipliers is not None:
        multipliers = regime.multipliers
    panels["multipliers"] = {"re": multipliers.real, "im": multipliers.imag}
    request = _portrait_request(system, start, scan, (begin, end), unit)
    return LiveOrbit(orbit, regime, trouble, panels, request)


def _portrait_request(
    system: nv.System,
    start: Sequence[float] | None,
    scan: nv.Scan,
    window: tuple[int, int],
    unit: str | None,
) -> nv.PortraitRequest:
    sampling: dict[str, Any] = {"windows": [window], "samples": SAMPLES, "method": scan.method}
    if scan.method == "exact":
        sampling["tolerance"] = scan.tolerance
    shown: dict[str, Any] = {"frequency": HZ if unit == HZ else RAD}
    if scan.of:
        shown["of"] = list(scan.of[:MOST_CURVES])
    document = {
        "title": system.in_words(),
        "system": system,
        "start": {"policy": "rest"} if start is None else {"state": list(start)},
        "sampling": sampling,
        "portrait": shown,
    }
    return nv.load_portrait(document)


def history_of(orbit: Any, curves: Sequence[Curve], periods: int) -> Arrays:
    """Return the first periods of an orbit: t [forcing periods], displacements [m], forces [N].

    Samples end integration steps, so a chaotic orbit from the start soon differs from the one in
    the settled periods.
    """
    system, count = orbit.system, periods * SAMPLES
    states, time = orbit.trajectory[:count], orbit.time[:count]
    history = {"t": time / system.period}
    history |= {curve.names[0]: curve.of(states) for curve in curves}
    history |= {name: system.signal(name).of(states) for name in system.force_signals}
    for name, values in system.harmonic_forces(time).items():
        history[f"harmonic {name}"] = values
    count = len(states)
    if count > 4 * MOST_POINTS:
        # the extreme values in `MOST_POINTS` equal pieces of time: a line through them covers the
        # same pixels as the curve
        size = -(-count // MOST_POINTS)
        firsts = np.arange(0, count, size)
        middles = np.minimum(firsts + size // 2, count - 1)
        ends = {
            column: np.stack([end.reduceat(values, firsts) for end in (np.minimum, np.maximum)], -1)
            for column, values in history.items()
        }
        ends["t"] = history["t"][np.stack([firsts, middles], axis=-1)]
        return {column: values.ravel() for column, values in ends.items()}
    # every n-th sample, every sample during a contact, and the one on either side of it
    drawn = np.zeros(count, bool)
    drawn[:: max(1, -(-count // MOST_POINTS))] = True
    for impact in () if orbit.impacts is None else orbit.impacts:
        first, last = np.searchsorted(time, (impact["touch"], impact["release"]))
        drawn[max(first - 1, 0) : last + 1] = True
    return {column: values[drawn] for column, values in history.items()}


def panels_without_time(orbit: Any, curves: Sequence[Curve]) -> dict[str, Arrays]:
    """Return the arrays of phase planes, section, touches and spectrum by name.

    A phase plane holds one cycle of a periodic orbit, or the periods of any other, of both at most
    `MOST_PHASE_PERIODS`.  The section at impact has phases [rad] and for each wall speeds [m/s].
    The spectrum is that of the last body's displacement.
    """
    system = orbit.system
    states = orbit.trajectory
    section = np.ascontiguousarray(states[SAMPLES - 1 :: SAMPLES])
    n = orbit.recurrence
    cycle, usable = n or len(section), len(states) - len(states) % (max(n, 1) * SAMPLES)
    *_, last_body = (curve for curve in curves if not curve.is_apart)
    sampled = slice(len(states) - usable, None)
    whole_cycles = replace(orbit, trajectory=states[sampled], time=orbit.time[sampled])
    spectrum = nv.spectrum(whole_cycles, last_body.of(whole_cycles.trajectory))
    wanted = (spectrum.order > 0) & (spectrum.order <= HIGHEST)
    amplitude = spectrum.amplitude[wanted]
    floor = _FLOOR * max(float(amplitude.max(initial=0.0)), 1e-300)
    states = states[-min(cycle, MOST_PHASE_PERIODS) * SAMPLES :]
    states = np.concatenate([states[:: max(1, len(states) // (6 * MOST_POINTS))], states[-1:]])
    planes = [curve for curve in curves if curve.has_plane]
    panels = {
        f"phase{i}": {"x": curve.of(states), "v": curve.of(states, 1)}
        for i, curve in enumerate(planes, start=1)
    }
    panels["section"] = {
        name: curve.of(section, part) for curve in planes for part, name in enumerate(curve.names)
    }
    amplitudes = np.maximum(amplitude, floor)
    panels["spectrum"] = {"order": spectrum.order[wanted], "amplitude": amplitudes}
    panels["touches"] = {"phase": np.empty(0)}
    if orbit.impacts is not None:
        is_last = orbit.impacts["touch"] > orbit.time[-1] - cycle * system.period
        last = orbit.impacts[is_last]
        panels["touches"]["phase"] = 2.0 * np.pi * (last["touch"] / system.period % 1.0)
        for wall, is_there in system.scene.touches_at(last).items():
            panels["touches"][wall] = np.where(is_there, last["speed"], np.nan)
    return panels


def words_of(regime: nv.Regime) -> str:
    n, k = regime.period, regime.impacts
    each = "forcing period" if n == 1 else f"{n} forcing periods"
    impacts = f"{k} impact{'s' * (k > 1)} in this time" if k else "no impact"
    return {
        "periodic": f"repeats every {each} with {impacts}",
        "transient_chaos": f"chaos that ended: now repeats every {each} with {impacts}",
        "quasiperiodic": "a motion on a torus",
        "chaotic": "neighboring orbits diverge over all the periods that were followed",
        "undetermined": "no test identified the regime",
    }.get(regime.kind, regime.kind)


def evidence_of(regime: nv.Regime) -> Iterator[tuple[str, str]]:
    """Yield the evidence for a label as pairs (quantity, value in words)."""
    if regime.period and regime.multipliers is not None:
        yield "closes to", f"{regime.residual:.1e} (relative)"
        largest = float(np.abs(regime.multipliers[0]))
        yield "largest multiplier", f"|μ| = {largest:.4g}: {'un' * (largest >= 1)}stable"
    if isfinite(regime.lyapunov):
        width = f" ± {regime.lyapunov_width:.1g}" if regime.lyapunov_width else ""
        yield "exponent λ₁", f"{regime.lyapunov:.4g}{width} 1/s"
        if isfinite(regime.transient_lyapunov):
            width = f" ± {regime.transient_lyapunov_width:.1g}"
            yield "before it settled", f"{regime.transient_lyapunov:.4g}{width} 1/s"
    if regime.settling >= 0:
        since = f"from period {regime.settling} on" if regime.settling else "from the start on"
        yield "obeys its multipliers", since
    if isfinite(regime.clearance):
        yield "nearest miss", f"{regime.clearance:.3g} m"
    if isfinite(regime.softest):
        yield "softest impact", f"{regime.softest:.3g} m/s"
    if not regime.period and isfinite(regime.averaging):
        yield "time averages agree to", f"{regime.averaging:.1f} digits"
    yield "followed for", f"{regime.watched} periods"
    if isfinite(regime.least_lifetime):
        yield "if transient", f"a mean life of {regime.least_lifetime:.0f} periods at least (95 %)"


def portrait_command(request: nv.PortraitRequest) -> str:
    """Return the command that draws a portrait: of a changed catalog system, or else of a file."""
    (column,) = request.columns
    system = column.system
    if system.name not in nv.system_names():
        return f"nlds-vines portrait {PORTRAIT_FILE}"
    base = nv.load_system(system.name)
    if not system.has_parts_of(base):
        return f"nlds-vines portrait {PORTRAIT_FILE}"
    changed = system.changes_from(base)
    try:
        is_repeated = base.with_(**changed).parameters == system.parameters
    except nv.RequestError:
        is_repeated = False
    if not is_repeated:
        return f"nlds-vines portrait {PORTRAIT_FILE}"
    words = ["nlds-vines", "portrait", "--system", system.name]
    for name, value in changed.items():
        words += ["--set", f"{name}={value!r}"]
    if request.start is not None:
        words.append(f"--start={','.join(map(repr, request.start))}")
    words += ["--windows", f"{column.window.begin}:{column.window.end}"]
    words += ["--samples", str(request.samples)]
    if request.method != "exact":
        words += ["--method", request.method]
    elif request.tolerance not in (None, 1e-9):
        words += ["--tolerance", repr(request.tolerance)]
    if request.frequency != RAD:
        words += ["--frequency", request.frequency]
    return shlex.join(words)


def picture(orbit: LiveOrbit) -> str:
    """Return the portrait as a PNG in base64."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / PICTURE_FILE
        nv.orbit_portrait(orbit.request, to=path, quiet=True)
        return base64.b64encode(path.read_bytes()).decode()
