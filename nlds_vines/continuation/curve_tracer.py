"""Along a curve of special points in the plane of two parameters, step by step.

The unknowns are the state, at phase zero or in a flight of rigid bodies (`shooting_phase`), and
both parameters; the equations, those of the orbit and one more (`defining_systems`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from nlds_vines.continuation.arclength import (
    ANGLE,
    CONTRACTION,
    SHARPEST,
    Equation,
    Point,
    angle_of,
    corrected,
    length,
    tangent_of,
)
from nlds_vines.continuation.defining_systems import (
    CONDITIONS,
    Function,
    augmented,
    grazing,
    other_condition,
    singular_matrix,
)
from nlds_vines.continuation.section_map import Cycle, SectionMap
from nlds_vines.continuation.shooting_phase import better_map, place_at, seen_by
from nlds_vines.continuation.special_points import is_torus, narrowed_down, step_between
from nlds_vines.continuation.switching import null_vector

FIRST_STEP, LEAST_STEP, LONGEST_STEP = 1.0e-3, 1.0e-7, 2.0e-2
"""Steps along a curve, relative to the orbit and to the intervals together."""

NEARBY = 1.0e-6
"""Weighted distance of the places whose test functions tell its gradient."""

MOST_POINTS = 400
"""Points of a curve in one direction."""

ENDS = {
    "bound": "the end of an interval",
    "closed": "a closed curve",
    "neutral": "beyond a resonance 1:1 or 1:2 there are no tori, but neutral saddles",
    "lost": "Newton's method does not converge, or another impact grazes",
    "long": "it has more points than one curve may have",
}
"""Why a curve ends, by a word."""


@dataclass(frozen=True, eq=False)
class Meeting:
    """A point where two kinds meet: its name, a key of the conditions, and the point."""

    name: str
    point: Point


@dataclass
class Curve:
    """A curve of special points of one kind."""

    kind: str
    points: list[Point] = field(default_factory=list)
    meetings: list[Meeting] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")


def told_by(section_map: SectionMap, function: Function, weights: np.ndarray) -> Equation:
    """Return what Newton's method is told by a function: its values, and differences for slopes."""

    def told(cycle: Cycle) -> tuple[float, np.ndarray] | None:
        found, here = np.empty(len(weights)), function(cycle)
        for i in range(len(weights)):
            step = NEARBY / weights[i]
            for sign in (1.0, -1.0):
                place = cycle.place
                place[i] += sign * step
                other = section_map.at(place, cycle.n)
                there = math.nan if other is None else function(other)
                if math.isfinite(there):
                    break
            found[i] = (there - here) / (sign * step)
        return (here, found) if np.isfinite(found).all() else None

    return told


@dataclass
class Tracer:
    """Follows one curve in both directions.

    Attributes:
        section_map: that at phase zero; an orbit is told by the map it is shot from, its `since`.
        low, high: (2,) of both parameters.
        softness, without, wall: of the impact that grazes (`defining_systems.grazing`).
    """

    section_map: SectionMap
    kind: str
    low: np.ndarray
    high: np.ndarray
    softness: float = 0.0
    without: tuple[int, int] = (0, 0)
    wall: int = 0

    def function(self, cycle: Cycle) -> Function:
        """Return what vanishes on the curve, for orbits near one of it."""
        if self.kind == "GR":
            return grazing(self.without, self.wall, self.softness)
        return augmented(self.kind, cycle)

    def point(self, cycle: Cycle, toward: np.ndarray) -> Point | None:
        """Return the point of the curve near an orbit, its tangent turned toward a direction."""
        here, place = self.section_map.shot(cycle.since), cycle.place
        weights = self.section_map.weights(cycle, self.high - self.low)
        row, told = weights * weights * toward, told_by(here, self.function(cycle), weights)
        found, rows, _ = corrected(here, place, cycle.n, row, weights, told)
        return None if found is None else self._with_tangent(found, rows, weights)

    def _with_tangent(self, cycle: Cycle, rows: np.ndarray, weights: np.ndarray) -> Point | None:
        found = tangent_of(cycle, rows, weights)
        return found and Point(cycle, found[0], weights)

    def map_of(self, point: Point) -> SectionMap:
        """Return the map that a point is shot by."""
        return self.section_map.shot(point.cycle.since)

    def at_best(self, point: Point) -> Point:
        """Return a point by the map that is best to go on from (`shooting_phase.better_map`)."""
        better = better_map(self.map_of(point), point.cycle)
        return point if better is None else self.seen_by(better, point) or point

    def seen_by(self, after: SectionMap, point: Point) -> Point | None:
        """Return a point of the curve as another map has it; None where the orbit is lost."""
        if after.since == point.cycle.since:
            return point
        seen = seen_by(self.map_of(point), after, point.cycle, point.tangent)
        if seen is None:
            return None
        cycle, way = seen
        weights = self.section_map.weights(cycle, self.high - self.low)
        return Point(cycle, way / length(weights, way), weights)

    def along(self, point: Point, step: float) -> tuple[Point | None, float]:
        """Return the point of the curve a step ahead, and the contraction of Newton's method."""
        place = point.cycle.place + step * point.tangent
        row, n = point.weights * point.weights * point.tangent, point.cycle.n
        there = self.map_of(point)
        told = told_by(there, self.function(point.cycle), point.weights)
        cycle, rows, ratio = corrected(there, place, n, row, point.weights, told)
        if cycle is None:
            return None, ratio
        weights = self.section_map.weights(cycle, self.high - self.low)
        return self._with_tangent(cycle, rows, weights), ratio

    def follow(self, start: Point) -> tuple[list[Point], list[Meeting], str]:
        """Follow the curve from a point on, along its tangent, until it ends."""
        points, meetings, step = [start], list[Meeting](), FIRST_STEP
        while len(points) < MOST_POINTS:
            a = points[-1]
            b, ratio = self.along(a, step)
            worst = math.inf if b is None else self._worst(a, b, ratio)
            if b is None or (worst > SHARPEST and step > 2.0 * LEAST_STEP):
                step *= 0.5
                if step < LEAST_STEP:
                    return points, meetings, "lost"
                continue
            inside = (self.low <= b.cycle.values) & (b.cycle.values <= self.high)
            if not inside.all():
                end = self._on_bound(a, b)
                if end is not None:
                    meetings.extend(self.meetings(a, end, step_between(a, end)))
                    points.append(end)
                return points, meetings, "bound"
            meetings.extend(self.meetings(a, b, step))
            points.append(self.at_best(b))
            if self.kind == "NS" and not is_torus(b.cycle):
                return points, meetings, "neutral"
            if self._is_back(points):
                return points, meetings, "closed"
            step = min(LONGEST_STEP, step * min(2.0, max(0.5, 1.0 / max(worst, 1.0e-3))))
        return points, meetings, "long"

    def _on_bound(self, a: Point, b: Point) -> Point | None:
        """Return the point of the curve on the bound that it crosses first between two points.

        Its tangent is the axis of the parameter that is bounded, so that its value stays.
        """
        size, before, after = a.cycle.state.size, a.cycle.values, b.cycle.values
        bounds = np.where(after > self.high, self.high, self.low)
        out = np.flatnonzero((after < self.low) | (after > self.high))
        share, axis = min((float((bounds - before)[i] / (after - before)[i]), int(i)) for i in out)
        place = a.cycle.place + share * (b.cycle.place - a.cycle.place)
        place[size + axis] = bounds[axis]
        row = np.zeros(len(place))
        row[size + axis] = 1.0
        here = self.map_of(a)
        told = told_by(here, self.function(a.cycle), a.weights)
        cycle, _, _ = corrected(here, place, a.cycle.n, row, a.weights, told)
        return None if cycle is None else Point(cycle, row / a.weights, a.weights)

    def finished(self, point: Point) -> Point | None:
        """Return the point of the curve, at phase zero, of one that was followed; None of none."""
        return self.seen_by(self.section_map, point)

    def _worst(self, a: Point, b: Point, ratio: float) -> float:
        """Return by what a step is too long: contraction, but of slopes with a kink, or angle."""
        bent = 0.0 if self.kind == "GR" else math.sqrt(ratio / CONTRACTION)
        return max(bent, angle_of(a, b) / ANGLE)

    def meetings(self, a: Point, b: Point, step: float) -> list[Meeting]:
        """Return the points between two where another kind is met."""
        found = [] if self.kind == "GR" else self._touches(a, b, step)
        for name, condition in CONDITIONS[self.kind].items():
            test = self._condition(condition)
            before, after = test(a), test(b)
            if not before * after < 0.0:
                continue
            place = narrowed_down(lambda s: self.along(a, s)[0], (a, b), (0.0, step), test)
            if place is not None and self._is_true(name, place[1]):
                found.append(Meeting(name, place[1]))
        return found

    def _touches(self, a: Point, b: Point, step: float) -> list[Meeting]:
        """Return where an impact of the orbit grazes between two points, if one does."""
        counts = a.cycle.counts
        if b.cycle.counts == counts:
            return []

        def test(point: Point) -> float:
            return 1.0 if point.cycle.counts == counts else -1.0

        place = narrowed_down(lambda s: self.along(a, s)[0], (a, b), (0.0, step), test)
        return [] if place is None else [Meeting(f"GR-{self.kind}", place[1])]

    def _condition(self, condition: str) -> Callable[[Point], float]:
        """Return the function of a point that vanishes where a condition is met."""
        if condition == "cusp":
            return self._bend
        return lambda point: other_condition(self.kind, condition, point.cycle)

    def _bend(self, point: Point) -> float:
        """Return the quadratic coefficient of the map along the fold's null vector."""
        cycle = point.cycle
        matrix = singular_matrix("LP", cycle)
        right, left = null_vector(matrix), null_vector(matrix.T.copy())
        size, images = len(right), []
        unit = 1.0e-4 / length(point.weights[:size], right)
        for sign in (1.0, -1.0):
            place = cycle.place
            place[:size] += sign * unit * right
            other = self.map_of(point).at(place, cycle.n)
            if other is None:
                return math.nan
            images.append(other.points[-1, :size])
        bend = images[0] + images[1] - 2.0 * cycle.points[-1, :size]
        sign = 1.0 if float((left * right).sum()) >= 0.0 else -1.0
        return sign * float((left * bend).sum()) / (unit * unit)

    def _is_true(self, name: str, point: Point) -> bool:
        """Tell whether a meeting is one: of NS with a resonance, only of a complex pair."""
        if name == "GR-NS":
            return any(abs(mu.imag) > 1.0e-6 for mu in point.cycle.multipliers.tolist())
        return True

    def _is_back(self, points: list[Point]) -> bool:
        """Tell whether a curve has come back to its first point, at whatever phase of the orbit."""
        if len(points) < 5:
            return False
        first, a, b = points[0], points[-2], points[-1]
        before, now = self._place_at(first.cycle.since, a), self._place_at(first.cycle.since, b)
        if before is None or now is None:
            return False
        size = first.cycle.state.size
        step = length(a.weights, now - before)
        for point in first.cycle.points:
            place = np.concatenate([point[:size], first.cycle.values])
            if length(a.weights, place - now) < 0.6 * step:
                return True
        return False

    def _place_at(self, since: float, point: Point) -> np.ndarray | None:
        """Return the place of a point's orbit so many periods after phase zero; None if lost."""
        return place_at(self.map_of(point), point.cycle.place, point.cycle.n, since)
