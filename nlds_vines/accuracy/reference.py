"""What is true of a case: by refinement, by independent witnesses, by stored digits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.results import Known
from nlds_vines.accuracy.rivals import RIVALS, RivalFailure
from nlds_vines.errors import RequestError
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import IntegrationError, Orbit, simulate
from nlds_vines.packaged_files import resource_text

FINEST: dict[str, Any] = {"nodes": 24, "contact_steps": 160.0}
"""Of `exact`: the reference where no digits are stored."""

CONFIRMING = 16384.0
"""Steps of a period of `rk4`: the first witness; it shares no formula with the exact flight."""

WITNESSES = {"SciPy DOP853, events": 1e-13, "naive RK4": 65536.0}
"""Independent witnesses, with their settings: they share nothing at all with our methods.

One of them must agree.  The first is the sharper one and finds touches near grazing too, where the
approach turns within a step; the second is blunt, and misses no contact that is a step long."""

DISTURBANCE = 1e-8
"""Of the start [m, m/s], to see how much it grows."""

BELIEVED = 1e-8
"""How far witnesses may be apart, in units of the growth of a disturbance."""

_SAME = 1e-14  # relative, of parameters: K is computed from moduli, in some order


@dataclass(frozen=True)
class Reference(Known):
    """The truth about a case, as well as it is known.

    Attributes:
        section: states at t = T, 2T, ... (periods, 4) [m, m/s], (periods, 2) without a damper.
        touches: times of touch [s]; None without walls.
        E1max: largest E1 over the last half of the periods [J].
    """

    section: np.ndarray
    touches: np.ndarray | None
    E1max: float


UNKNOWN = Reference(
    section=np.full((1, 4), np.nan),
    touches=None,
    E1max=np.nan,
    growth=np.nan,
    doubt=np.nan,
    independent=np.nan,
    witness="",
    source="",
)
"""Of a case about which nothing is known."""


def reference_of(case: Case) -> Reference:
    """Return what is true of a case.

    Raises `RequestError` where the witnesses contradict each other by more than `BELIEVED` times
    the growth: in long chaos there is nothing to measure an error against; and where the orbit
    cannot be followed.
    """
    try:
        finest = watched(case, **FINEST)
        confirming = watched(case, method="rk4", period_steps=CONFIRMING)
        grown = growth(case, finest.section)
    except IntegrationError as error:
        raise RequestError(f"{case.name}: there is no reference: {error}") from None
    assert finest.section is not None
    assert confirming.section is not None
    stored = stored_section(case)
    section = finest.section if stored is None else stored
    distances = {name: _apart(section, other) for name, other in _witnessed(case)}
    if not distances:
        raise RequestError(f"{case.name}: every independent witness broke down")
    witness = min(distances, key=lambda name: distances[name])
    found = Reference(
        section=section,
        touches=finest.impacts["touch"] if finest.impacts is not None else None,
        E1max=float(finest.E1max or 0.0),
        growth=grown,
        doubt=_apart(section, confirming.section)
        if stored is None
        else float(np.spacing(np.abs(section[-1])).max()),
        independent=distances[witness],
        witness=f"{witness}, {WITNESSES[witness]:g}",
        source="stored, 25 digits" if stored is not None else "exact, refined",
    )
    worst = max(found.independent, _apart(section, finest.section), found.doubt)
    if not worst <= BELIEVED * found.growth:
        raise RequestError(
            f"{case.name}: two references differ by {worst:.1e} after {case.periods} periods "
            f"(a disturbance grows by {found.growth:.1e}): measure over fewer periods"
        )
    _confirm_impacts(case, finest, confirming, BELIEVED * found.growth)
    return found


def _confirm_impacts(case: Case, one: Orbit, other: Orbit, bound: float) -> None:
    """Raise `RequestError` where two orbits do not have the same touches and largest energy.

    `bound` holds for times [s], and for the energy relative to it.
    """
    energies = float(one.E1max or 0.0), float(other.E1max or 0.0)
    if not abs(energies[0] - energies[1]) <= bound * max(energies):
        raise RequestError(
            f"{case.name}: exact and rk4 find E1max = {energies[0]:.9g} and {energies[1]:.9g} J: "
            "there is no reference; measure over fewer periods"
        )
    if one.impacts is None or other.impacts is None:
        return
    first, second = one.impacts["touch"], other.impacts["touch"]
    if len(first) != len(second) or not np.abs(first - second).max(initial=0.0) <= bound:
        raise RequestError(
            f"{case.name}: exact and rk4 do not find the same touches ({len(first)} and "
            f"{len(second)}): there is no reference; measure over fewer periods"
        )


def watched(case: Case, **settings: Any) -> Orbit:
    """Follow a case with everything recorded that is compared; energies over the last half."""
    record = ["section", "impacts"] if case.system.scene.walls else ["section"]
    whole = simulate(case.system, case.periods, start=case.start, record=record, **settings)
    half = case.periods // 2
    late = simulate(
        case.system,
        case.periods - half,
        start=case.start,
        transient=half,
        record=["energy"],
        **settings,
    )
    return Orbit(**{**vars(whole), "E1max": late.E1max})


def growth(case: Case, section: Any) -> float:
    """Return by how much a disturbance of the start has grown at the end, at least 1.

    By differences: each component of the start in turn is moved by `DISTURBANCE`; the largest.
    """
    largest = 1.0
    for direction in np.eye(len(case.state)):
        start = tuple(case.state + DISTURBANCE * direction)
        moved = simulate(case.system, case.periods, start=start, record=["section"], **FINEST)
        largest = max(largest, float(np.abs(moved.state - section[-1]).max()) / DISTURBANCE)
    return largest


def stored_section(case: Case) -> np.ndarray | None:
    """Return the stored 25-digit states of a case (periods, 4), rounded; None where there are none.

    They are known for some systems, from rest.
    """
    if case.start is not None:
        return None
    for entry in _stored().values():
        states = entry["states"]
        if _same(case.system, entry["parameters"]) and len(states) >= case.periods:
            rows = [states[str(n)]["y"] for n in range(1, case.periods + 1)]
            return np.array([[float(text) for text in row] for row in rows])
    return None


@cache
def _stored() -> dict[str, Any]:
    return json.loads(resource_text("states.json"))["cases"]


def _same(system: System, numbers: dict[str, Any]) -> bool:
    """Tell whether a system has the kind and the values of a stored entry; K stands for moduli."""
    if system.kind != numbers["kind"]:
        return False
    names = [name for name in numbers if name in system.scene.own or name == "K"]
    given = {**system.parameters, **({"K": system.K} if system.scene.walls else {})}
    return all(abs(given[name] - numbers[name]) <= _SAME * abs(numbers[name]) for name in names)


def _witnessed(case: Case) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the section that each independent witness finds, by its name; some break down."""
    for rival in RIVALS:
        if rival.name in WITNESSES:
            flow = rival.prepare(case.system, case.state)
            with suppress(RivalFailure):
                yield rival.name, flow(WITNESSES[rival.name], case.periods, False).section


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one[-1] - other[-1]).max())
