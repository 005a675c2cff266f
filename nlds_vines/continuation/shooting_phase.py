"""When in its period an orbit of rigid bodies is shot from: the middle of its longest flight.

The state at a given phase jumps where an impact passes that phase, and the map of such states has
no derivative there.  So the states that Newton's method changes are those in a flight, which is
chosen anew along a branch before an impact comes near.  What is kept of a branch are states at
phase zero.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nlds_vines.continuation.arclength import Point, length, point_of
from nlds_vines.continuation.section_map import Cycle, SectionMap, shoots_from_flights

NEAR = 0.25
"""How near the next impact may come, of what is the farthest, before the flight is chosen anew."""

SHARPNESS = 1024
"""Parts of a period of which a phase is a whole number: its sum with 1 is exact."""

SAME_ORBIT = 1.0e-7
"""Distance, relative to the orbit, of two states that are one."""

INVARIANT = "counts", "multipliers", "clearance", "slowest", "volume"
"""What an orbit has at any phase."""

ASIDE = 1.0e-6
"""Step along a branch whose image tells which way the branch goes at another phase."""


def better_map(section_map: SectionMap, cycle: Cycle) -> SectionMap | None:
    """Return the map from the middle of an orbit's longest flight; None if it need not change."""
    if not shoots_from_flights(section_map.scene):
        return None
    n = cycle.n
    start = place_at(section_map, cycle.place, n)
    rows = None if start is None else section_map.impacts(start, n)
    if rows is None or not len(rows) or np.isnan(rows[:, 2]).any():
        return None
    touch, release = rows[:, 1], rows[:, 2]
    flights = np.append(touch[1:], touch[0] + n) - release
    longest = int(flights.argmax())
    half = 0.5 * flights[longest]
    apart = (np.concatenate([touch, release]) - section_map.since) % n
    if min(apart.min(), n - apart.max()) > NEAR * half:
        return None
    middle = round((release[longest] + half) * SHARPNESS) / SHARPNESS
    return section_map.shot(middle % n)


def best_map(zero: SectionMap, place: np.ndarray, n: int) -> SectionMap:
    """Return the map that an orbit near a place of the map at phase zero is best shot by."""
    cycle = zero.at(place, n)
    return (None if cycle is None else better_map(zero, cycle)) or zero


def place_at(
    section_map: SectionMap, place: np.ndarray, n: int, since: float = 0.0
) -> np.ndarray | None:
    """Return the place of an nT orbit, at one of a map, so many periods after phase zero."""
    time = (since - section_map.since) % n
    return section_map.later(place, time) if time else place


def seen_by(
    before: SectionMap, after: SectionMap, cycle: Cycle, direction: np.ndarray
) -> tuple[Cycle, np.ndarray] | None:
    """Return an orbit, and a direction at it, found by a map, as another map has them."""
    there = place_at(before, cycle.place, cycle.n, after.since)
    beside = place_at(before, cycle.place + ASIDE * direction, cycle.n, after.since)
    found = None if there is None else after.at(there, cycle.n)
    if found is None or there is None or beside is None:
        return None
    # what no phase changes stays as it is: at a grazing, an impact is there or not
    same = {name: getattr(cycle, name) for name in INVARIANT}
    return replace(found, **same), (beside - there) / ASIDE


def moved(before: SectionMap, after: SectionMap, point: Point) -> Point | None:
    """Return a point of a branch, found by a map, as another map of the same branch has it.

    Where two branches cross, its border is 0, there is no single tangent: it is carried on.
    """
    seen = seen_by(before, after, point.cycle, point.tangent)
    if seen is None:
        return None
    found, way = seen
    lengths = 1.0 / point.weights[-1:]
    exact = point_of(after, found, way, lengths) if point.border != 0.0 else None
    if exact is not None:
        return exact
    weights = after.weights(found, lengths)
    return Point(found, way / length(weights, way), weights, point.border)


def cycle_at_zero(zero: SectionMap, cycle: Cycle) -> Cycle | None:
    """Return an orbit as the map at phase zero has it; None where it is lost on the way there."""
    if not cycle.since:
        return cycle
    seen = seen_by(zero.shot(cycle.since), zero, cycle, np.zeros(len(cycle.place)))
    return None if seen is None else seen[0]


def point_at_zero(zero: SectionMap, point: Point) -> Point:
    """Return a point of a branch as the map at phase zero has it."""
    if not point.cycle.since:
        return point
    found = moved(zero.shot(point.cycle.since), zero, point)
    if found is None:
        raise RuntimeError(f"an orbit at {point.value!r} is lost on its way to phase zero")
    return found


def is_symmetric(section_map: SectionMap, cycle: Cycle) -> bool:
    """Tell whether an orbit between two walls is its own mirror image half of its periods later."""
    if len(section_map.scene.walls) < 2 or cycle.n % 2 == 0:
        return False
    later = section_map.later(cycle.place, 0.5 * cycle.n)
    if later is None:
        return False
    cell = section_map.cells(cycle.values[np.newaxis])[0]
    mirrored = -cycle.state
    mirrored[-2] += float(cell.near) - float(cell.far)  # r, or x, between the walls
    weights = section_map.weights(cycle, np.ones(len(cycle.values)))[: len(mirrored)]
    return bool((np.abs(later[: len(mirrored)] - mirrored) * weights).max() < SAME_ORBIT)
