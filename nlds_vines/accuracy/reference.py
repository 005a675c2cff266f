"""What is true of a case: by refinement, confirmed by the other method and by another program."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nlds_vines.accuracy import scipy_solver
from nlds_vines.accuracy.measured_cases import Case, Known, SolverFailure
from nlds_vines.errors import RequestError
from nlds_vines.orbits.classification import classify
from nlds_vines.orbits.simulation import IntegrationError, Orbit, simulate

FINEST: dict[str, Any] = {"nodes": 24, "contact_steps": 160.0}
"""Of `exact`: the reference."""

CONFIRMING = 16384.0
"""Steps of a period of `rk4`: the first witness; it shares no formula with the exact flight."""

WITNESS, LOOKS = 1e-13, 512
"""Of SciPy's solver, the independent witness: its tolerance, and steps of a period at least.

It shares nothing with our methods.  Near grazing a contact lasts a thousandth of a period, and the
solver's own steps would pass over it; of twelve stages of so short a step some lie within."""

DISTURBANCE = 1e-8
"""Of the start [m, m/s], to see how much it grows."""

BELIEVED = 1e-8
"""How far witnesses may be apart, in units of the growth of a disturbance."""


@dataclass(frozen=True)
class Truth:
    """A case, and the truth about it as well as it is `known`.

    Attributes:
        section: states at t = T, 2T, ... (periods, 4) [m, m/s], (periods, 2) without a damper.
        touches: times of touch [s]; None without walls.
    """

    case: Case
    known: Known
    section: np.ndarray
    touches: np.ndarray | None

    @property
    def later(self) -> Case:
        """A case that begins where this one ends, for times that no transient belongs to."""
        scene = self.case.system.scene
        state = None if scene.limit else tuple(float(value) for value in self.section[-1])
        return replace(self.case, start=state)


def truth_of(case: Case) -> Truth:
    """Return what is true of a case.

    Raises `RequestError` where the witnesses contradict each other by more than `BELIEVED` times
    the growth: in long chaos there is nothing to measure an error against; and where the orbit
    cannot be followed.
    """
    try:
        finest = followed(case, **FINEST)
        confirming = followed(case, method="rk4", period_steps=CONFIRMING)
        grown = growth(case, finest.state)
        witness = scipy_solver.follow(
            case.system, case.periods, case.state, WITNESS, case.system.period / LOOKS
        )
    except (IntegrationError, SolverFailure) as error:
        raise RequestError(f"{case.name}: there is no reference: {error}") from None
    assert finest.section is not None
    touches = finest.impacts["touch"] if finest.impacts is not None else None
    known = Known(
        name=case.name,
        title=case.title,
        truth=_label(case),
        periods=case.periods,
        source="exact, refined",
        doubt=_apart(finest.section, confirming.section),
        independent=_apart(finest.section, witness.section),
        witness=f"{scipy_solver.NAME}, {WITNESS:g}",
        growth=grown,
    )
    worst = max(known.independent, known.doubt)
    if not worst <= BELIEVED * grown:
        raise RequestError(
            f"{case.name}: two references differ by {worst:.1e} after {case.periods} periods "
            f"(a disturbance grows by {grown:.1e}): measure over fewer periods"
        )
    if touches is not None and confirming.impacts is not None:
        others = confirming.impacts["touch"]
        same = len(touches) == len(others)
        if not same or not np.abs(touches - others).max(initial=0.0) <= BELIEVED * grown:
            raise RequestError(
                f"{case.name}: exact and rk4 do not find the same touches ({len(touches)} and "
                f"{len(others)}): there is no reference; measure over fewer periods"
            )
    return Truth(case, known, finest.section, touches)


def _label(case: Case) -> str:
    """Return the regime that the orbit of a case ends in."""
    try:
        return classify(case.system, start=case.start, quiet=True).label
    except IntegrationError:
        return "unknown: it ends later on"


def followed(case: Case, **settings: Any) -> Orbit:
    """Follow a case by one of our methods; section and impacts are recorded."""
    record = ["section", "impacts"] if case.system.scene.walls else ["section"]
    return simulate(case.system, case.periods, start=case.start, record=record, **settings)


def growth(case: Case, state: np.ndarray) -> float:
    """Return by how much a disturbance of the start has grown at the end, at least 1.

    By differences: each component of the start in turn is moved by `DISTURBANCE`; the largest.
    """
    largest = 1.0
    for direction in np.eye(len(case.state)):
        start = tuple(case.state + DISTURBANCE * direction)
        moved = simulate(case.system, case.periods, start=start, record=["section"], **FINEST)
        largest = max(largest, float(np.abs(moved.state - state).max()) / DISTURBANCE)
    return largest


def _apart(one: np.ndarray, other: Any) -> float:
    return float(np.abs(one[-1] - other[-1]).max())
