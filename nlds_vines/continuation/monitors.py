"""Monitors: functions of the orbits along branches, whose zeros are located like special points.

They are evaluated when the branches have been followed, and change no point of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.continuation.arclength import (
    Point,
    along,
    best_map,
    moved,
    point_at_zero,
    seen_by,
)
from nlds_vines.continuation.branch_panels import LARGEST_MULTIPLIER, panels_of
from nlds_vines.continuation.exploration import Track
from nlds_vines.continuation.request import Continuation, Monitored
from nlds_vines.continuation.result import Tables, crossing_of
from nlds_vines.continuation.special_points import (
    Located,
    Special,
    narrowed_down,
    step_between,
)
from nlds_vines.engine.section_map import Cycle, SectionMap
from nlds_vines.errors import RequestError, number
from nlds_vines.model.parameters import with_unit

# A number of an orbit of a branch, by its cycle at phase zero and the number of the branch.
Number = Callable[[Cycle, int], float]


@dataclass(frozen=True)
class Monitor:
    """A number of orbits and the value at which they are located."""

    words: str  # `largest_force = 10000 N`, or the name of a function
    of: Number
    value: float

    def excess(self, cycle: Cycle, branch: int) -> float:
        return self.of(cycle, branch) - self.value


def monitors_of(request: Continuation, section_map: SectionMap) -> list[Monitor]:
    """Return the monitors of a request, one for each value; `RequestError` without a function."""
    monitors: list[Monitor] = []
    for one in request.monitors:
        if one.is_function:
            monitors.append(Monitor(one.name, _function_of(request, section_map, one), 0.0))
            continue
        of, unit = _quantity_of(request, section_map, one)
        for value in one.values:
            words = f"{one.name} = {value:g}"
            monitors.append(Monitor(words if unit == "1" else f"{words} {unit}", of, value))
    return monitors


def _function_of(request: Continuation, section_map: SectionMap, one: Monitored) -> Number:
    """Return the user's function as one of cycles; it raises `RequestError` for no number."""
    function = request.functions.get(one.name)
    if function is None:
        raise RequestError(
            f"monitor {one.name!r} is a function of Python, which no file holds: call "
            f"continue_branch(..., monitors={{{one.name!r}: function}})"
        )
    name = request.along.name

    def value(cycle: Cycle, branch: int) -> float:
        there = request.system.with_(**{name: float(cycle.values[0])})
        orbit = crossing_of(section_map, there, branch, cycle)
        result = function(orbit)
        if isinstance(result, np.ndarray) and result.ndim == 0:
            result = result.item()
        if isinstance(result, float) and not math.isfinite(result):
            return math.nan  # a number that this orbit does not have
        where = f"{name} = {with_unit(name, repr(orbit.value))}"
        return number(f"monitor {one.name!r} at {where}", result)

    return value


def _quantity_of(
    request: Continuation, section_map: SectionMap, one: Monitored
) -> tuple[Number, str]:
    """Return a named quantity as a function of cycles, and its unit."""
    if one.name == LARGEST_MULTIPLIER:
        return lambda cycle, branch: float(abs(cycle.multipliers[0])), "1"
    panel = panels_of(request)[one.name]

    def value(cycle: Cycle, branch: int) -> float:
        orbit = crossing_of(section_map, request.system, branch, cycle)
        return panel.of_orbit(orbit)

    return value, panel.unit


def add_zeros(
    section_map: SectionMap, tracks: Sequence[Track], monitors: Sequence[Monitor]
) -> None:
    """Add the zeros of monitors to the special points of tracks, in order along each track."""
    renumbered: list[dict[int, int]] = []
    for branch, track in enumerate(tracks):
        entries = [
            (_place_of(track, special), i, special) for i, special in enumerate(track.specials)
        ]
        for monitor in monitors:
            for zero in _zeros_on(section_map, track, branch, monitor):
                entries.append((_place_of(track, zero), -1, zero))
        entries.sort(key=lambda entry: entry[0])
        numbers = {before: now for now, (_, before, _) in enumerate(entries)}
        track.specials = [special for _, _, special in entries]
        track.switches = {numbers[at]: switch for at, switch in track.switches.items()}
        renumbered.append(numbers)
    for track in tracks:
        if track.parent >= 0:
            track.at = renumbered[track.parent][track.at]


def _place_of(track: Track, special: Special) -> tuple[int, float]:
    """Return the segment of a special point, and its distance from the segment's first point."""
    return special.index, step_between(track.points[special.index], special.point)


def _zeros_on(
    section_map: SectionMap, track: Track, branch: int, monitor: Monitor
) -> Iterator[Special]:
    values = [monitor.excess(point.cycle, branch) for point in track.points]
    for i in range(len(values) - 1):
        first, last = values[i], values[i + 1]
        are_finite = math.isfinite(first) and math.isfinite(last)
        if are_finite and (first < 0.0) != (last < 0.0):
            yield _zero_between(section_map, track, branch, i, monitor)


def _zero_between(
    section_map: SectionMap, track: Track, branch: int, index: int, monitor: Monitor
) -> Special:
    """Return the sign change of a monitor between two neighboring points of a track."""
    pair = track.points[index : index + 2]
    excesses = [monitor.excess(point.cycle, branch) for point in pair]
    size = max(map(abs, excesses))
    # at a phase in flight, as a rigid impact may pass phase zero between the two points
    there = best_map(section_map, pair[0].cycle.place, track.n)
    a, b = (moved(section_map, there, point) if there.since else point for point in pair)

    def test(point: Point) -> float:
        seen = seen_by(there, section_map, point.cycle, point.tangent) if there.since else None
        cycle = point.cycle if seen is None else seen[0]
        return monitor.excess(cycle, branch) / size

    located: Located | None = None
    if a is not None and b is not None:
        located = _located(there, a, (a, b), (0.0, step_between(a, b)), test)
        if located is None:  # no step may converge from the first orbit of a branch that doubles
            located = _located(there, b, (a, b), (step_between(b, a), 0.0), test)
    if located is None:
        nearer = pair[0] if abs(excesses[0]) <= abs(excesses[1]) else pair[1]
        residual, bracket = 1.0, abs(pair[1].value - pair[0].value)
    else:
        _, nearer, residual, bracket = located
        nearer = point_at_zero(section_map, nearer)
    label, words = nearer.cycle.label, monitor.words
    return Special("UZ", nearer, label, label, residual, bracket, index=index, monitor=words)


def _located(
    there: SectionMap,
    start: Point,
    ends: tuple[Point, Point],
    between: tuple[float, float],
    test: Callable[[Point], float],
) -> Located | None:
    return narrowed_down(lambda step: along(there, start, step)[0], ends, between, test)


def numbers_along(
    request: Continuation, section_map: SectionMap, tracks: Sequence[Track]
) -> Tables:
    """Return the values of the user's functions at all points, and at all special points."""
    tables: Tables = {}
    for one in request.monitors:
        if not one.is_function:
            continue
        of = _function_of(request, section_map, one)
        values, at_specials = list[float](), list[float]()
        for branch, track in enumerate(tracks):
            values += [of(point.cycle, branch) for point in track.points]
            at_specials += [of(special.point.cycle, branch) for special in track.specials]
        tables[one.dataset] = np.array(values)
        tables[f"special_{one.dataset}"] = np.array(at_specials)
    return tables
