"""An orbit and all that the page shows of it, as plain arrays; computed aside, one at a time.

One run of the orbit, as a portrait has it, and one verdict, as `classify` has it: the label is that
of the archive for the same start and the same sampling.  The kernels are imported by the first one.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError
from nlds_vines.explore.histories import MOST_POINTS, SETTLED, SHOW, Arrays, history_of
from nlds_vines.model.system import System
from nlds_vines.portrait.request import Column, PortraitRequest, Window, panels_of
from nlds_vines.portrait.window_view import View

if TYPE_CHECKING:
    from nlds_vines.orbits.classification import Regime

SAMPLES = 256
"""States of a period: some five in a contact, whose peak the list of impacts gives exactly."""

MOST_CYCLES = 24
"""Forcing periods of a phase trajectory that is not periodic: more only fill the plane."""

HIGHEST = 12.0
"""The highest frequency of the spectrum, in multiples of the forcing frequency."""

_FLOOR = 1e-12  # of a spectrum, relative to its largest line: below is round-off

_one_at_a_time = threading.Lock()  # two orbits at a time gain nothing, and slow each other


@dataclass(frozen=True)
class Sampling:
    """How long an orbit is followed, and how: the sampling of the scan."""

    transient: int = 600
    periods: int = 120
    method: str = "exact"
    effort: str = "standard"
    tolerance: float | str | None = None

    @classmethod
    def of(cls, scan: Scan) -> Sampling:
        """Return that of a scan."""
        return cls(scan.transient, scan.periods, scan.method, scan.effort, scan.tolerance)


@dataclass(frozen=True)
class LiveOrbit:
    """An orbit as the page shows it.

    Attributes:
        request: the portrait of it, which can be saved.
        view: the sampled window.
        regime: the verdict; None where it failed, and `trouble` says why.
        panels: by name, the arrays of every figure.
    """

    request: PortraitRequest
    view: View
    regime: Regime | None
    trouble: str = ""
    panels: Mapping[str, Arrays] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The label of the verdict, or of recurrence alone."""
        return self.view.label if self.regime is None else self.regime.label


def live_orbit(
    system: System,
    start: Sequence[float] | None,
    sampling: Sampling,
    history: str = SETTLED,
) -> LiveOrbit:
    """Follow the orbit of a system from a start (x1, v1, x2, v2) and return what is seen of it.

    Arguments: `history`, one of `histories.HISTORIES`.

    Raises `RequestError` for a start that is not possible and for an orbit that ends early.  Cost:
    4 ms for a periodic orbit of an SSul NES, once compiled; up to 0.1 s for chaos; a history from
    the start takes 0.02 s more for each thousand periods.
    """
    from nlds_vines.orbits.simulation import IntegrationError
    from nlds_vines.portrait.run import views_of

    request = request_of(system, start, sampling)
    try:
        with _one_at_a_time:
            (view,) = views_of(request)
            regime, trouble = _verdict(system, start, sampling)
            found = {"history": history_of(request, view, history)} | panels(view, regime)
    except IntegrationError as error:
        raise RequestError(str(error)) from None
    return LiveOrbit(request, view, regime, trouble, found)


def request_of(
    system: System, start: Sequence[float] | None, sampling: Sampling
) -> PortraitRequest:
    """Return the portrait of an orbit: the periods that the scan sampled, after its transient."""
    end = sampling.transient + max(sampling.periods, SHOW)
    column = Column(system, Window(sampling.transient, end))
    return PortraitRequest(
        system.title or system.name,
        (column,),
        start=None if start is None else tuple(start),
        samples=SAMPLES,
        method=sampling.method,
        tolerance=sampling.tolerance if sampling.method == "exact" else None,
    )


def _verdict(
    system: System, start: Sequence[float] | None, sampling: Sampling
) -> tuple[Regime | None, str]:
    """Return the verdict on an orbit, or None and why there is none."""
    from nlds_vines.orbits.classification import classify
    from nlds_vines.orbits.simulation import IntegrationError

    try:
        found = classify(
            system,
            start=start,
            transient=sampling.transient,
            periods=sampling.periods,
            method=sampling.method,
            effort=sampling.effort,
            tolerance=sampling.tolerance if sampling.method == "exact" else None,
        )
    except (IntegrationError, RequestError) as error:
        return None, str(error)
    return found, ""


def panels(view: View, regime: Regime | None) -> dict[str, Arrays]:
    """Return the arrays of figures without time by name, all of one length within a figure.

    `phase1`, `phase2` (displacement, velocity), `section`, `touches` (the section at impact),
    `spectrum`, `multipliers`; without a damper its own are empty.
    """
    return {
        **_phases(view),
        "section": _section(view),
        "touches": _touches(view),
        "spectrum": _spectrum(view),
        "multipliers": _multipliers(regime),
    }


def _phases(view: View) -> dict[str, Arrays]:
    """Return the phase trajectories: one cycle of a periodic orbit, or `MOST_CYCLES`."""
    cycles = min(view.cycle, len(view.section), MOST_CYCLES)
    states = view.states[-cycles * view.samples :]
    step = max(1, len(states) // (6 * MOST_POINTS))
    states = np.concatenate([states[::step], states[-1:]])
    damper = states[:, 2:4] if states.shape[1] == 4 else np.empty((0, 2))
    return {
        "phase1": {"x": states[:, 0], "v": states[:, 1]},
        "phase2": {"x": damper[:, 0], "v": damper[:, 1]},
    }


def _section(view: View) -> Arrays:
    """Return the stroboscopic section."""
    states = view.section
    found = {"x1": states[:, 0], "v1": states[:, 1]}
    if states.shape[1] == 4:
        found |= {"x2": states[:, 2], "v2": states[:, 3]}
    return found


def _touches(view: View) -> Arrays:
    """Return the section at impact: phase [rad], and the speed [m/s] in the column of its wall."""
    parts = list(view.impact_section.values())
    found = {"phase": np.concatenate([np.empty(0), *(points[:, 0] for points in parts)])}
    for i, wall in enumerate(view.column.system.scene.walls):
        own = [part[:, 1] if i == k else np.full(len(part), np.nan) for k, part in enumerate(parts)]
        found[wall] = np.concatenate(own)
    return found


def _spectrum(view: View) -> Arrays:
    """Return the amplitudes up to `HIGHEST`, never below the floor of round-off."""
    found = view.spectrum
    wanted = (found.order > 0) & (found.order <= HIGHEST)
    amplitude = found.amplitude[wanted]
    floor = _FLOOR * max(float(amplitude.max(initial=0.0)), 1e-300)
    return {"order": found.order[wanted], "amplitude": np.maximum(amplitude, floor)}


def _multipliers(regime: Regime | None) -> Arrays:
    """Return the Floquet multipliers; none of what is not periodic."""
    values = None if regime is None else regime.multipliers
    if values is None:
        return {"re": np.empty(0), "im": np.empty(0)}
    return {"re": values.real, "im": values.imag}


def has(system: System) -> tuple[str, ...]:
    """Return the panels that a system can fill, by the names of a portrait."""
    return panels_of([system.scene])


# ---- orbits in words -----------------------------------------------------------------------------


def words_of(regime: Regime) -> str:
    """Return what an orbit is, in one sentence."""
    if regime.kind == "periodic":
        return f"{_cycle(regime)} with {_impacts(regime)}"
    if regime.kind == "transient_chaos":
        return f"chaos that ended: now {_cycle(regime)} with {_impacts(regime)}"
    return {
        "quasiperiodic": "a motion on a torus",
        "chaotic": "neighboring orbits part, for all the periods that were followed",
        "undetermined": "no test of a regime was met",
    }.get(regime.kind, regime.kind)


def evidence_of(regime: Regime) -> list[tuple[str, str]]:
    """Return the evidence, a (quantity, value in words) each; what does not apply is left out."""
    return list(_evidence(regime))


def _evidence(regime: Regime) -> Iterator[tuple[str, str]]:
    if regime.period:
        yield "repeats to", f"{regime.residual:.1e} (relative)"
        assert regime.multipliers is not None
        largest = float(np.abs(regime.multipliers[0]))
        stands = "stable" if largest < 1 else "unstable"
        yield "largest multiplier", f"|μ| = {largest:.4g}: {stands}"
    yield from _exponents(regime)
    if regime.settling >= 0:
        yield "settled after", f"{regime.settling} periods"
    if math.isfinite(regime.clearance):
        yield "nearest miss", f"{regime.clearance:.3g} m"
    if math.isfinite(regime.softest):
        yield "softest impact", f"{regime.softest:.3g} m/s"
    if not regime.period and math.isfinite(regime.averaging):
        yield "averages over time converge to", f"{regime.averaging:.1f} digits"
    yield "followed for", f"{regime.watched} periods"
    if math.isfinite(regime.least_lifetime):
        yield "if transient", f"a mean life of {regime.least_lifetime:.0f} periods at least (95 %)"


def _exponents(regime: Regime) -> Iterator[tuple[str, str]]:
    """Yield the largest exponent, with its interval where it is an estimate."""
    if not math.isfinite(regime.lyapunov):
        return
    width = f" ± {regime.lyapunov_width:.1g}" if regime.lyapunov_width else ""
    yield "exponent λ₁", f"{regime.lyapunov:.4g}{width} 1/s"
    if math.isfinite(regime.transient_lyapunov):
        width = f" ± {regime.transient_lyapunov_width:.1g}"
        yield "before it settled", f"{regime.transient_lyapunov:.4g}{width} 1/s"


def _cycle(regime: Regime) -> str:
    n = regime.period
    return "repeats every forcing period" if n == 1 else f"repeats every {n} forcing periods"


def _impacts(regime: Regime) -> str:
    k = regime.impacts
    return "no impact" if k == 0 else f"{k} impact{'s' * (k > 1)} in each"
