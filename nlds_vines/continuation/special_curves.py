"""Curves of special points in the plane of two parameters: where they start, and both ways.

Under `restitution` no orbit is smooth across its grazing, but one without the impact is up to it.
So the orbits whose nearest miss is a small LEVEL are followed.  From each of them, others that miss
by less, in the plane across the curve, tell by a polynomial in the miss which orbit grazes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.continuation.arclength import CLOSED, OF_CURVE, Point, corrected, length
from nlds_vines.continuation.curve_tracer import Curve, Meeting, Tracer, told_by
from nlds_vines.continuation.defining_systems import Function
from nlds_vines.continuation.section_map import Cycle, SectionMap, bordered, closing
from nlds_vines.continuation.shooting_phase import best_map, place_at
from nlds_vines.continuation.special_points import limit_of

BESIDE = 1.0e-7
"""Distance from a GR, relative to the parameter, of the orbits that calibrate its function."""

LEVEL, NEARER = 1.0e-3, (0.75, 0.5, 0.25)
"""Nearest miss of orbits that stand for one that grazes rigid bodies, relative to the orbit; and
parts of it, of the orbits nearer to that one."""

SMOOTH = 1.0e-3
"""By how much, relative to the orbit, polynomials of two degrees may differ at the grazing."""


@dataclass
class RigidTracer(Tracer):
    """Follows a curve of grazing of rigid bodies, from the side without the impact.

    Attributes:
        level: the nearest miss [m] of the orbits that are followed.
    """

    level: float = 0.0

    def function(self, cycle: Cycle) -> Function:
        """Return what vanishes where an orbit misses by the level; NaN with other impacts."""
        return self._miss(self.level)

    def _miss(self, level: float) -> Function:
        return lambda other: other.clearance - level if other.counts == self.without else math.nan

    def finished(self, point: Point) -> Point | None:
        """Return the orbit that grazes, in the plane across the curve at one that all but does."""
        cycle, row = point.cycle, point.weights * point.weights * point.tangent
        here, n, knots = self.map_of(point), point.cycle.n, list[tuple[float, np.ndarray]]()
        for share in (1.0, *NEARER):
            if knots:
                told = told_by(here, self._miss(share * self.level), point.weights)
                found, *_ = corrected(here, cycle.place, n, row, point.weights, told)
                if found is None:
                    return None
                cycle = found
            place = place_at(here, cycle.place, n)
            if place is None:
                return None
            knots.append((cycle.clearance, place))
        place, size = limit_of(knots), self.section_map.size
        if length(point.weights, place - limit_of(knots[1:])) > SMOOTH:
            return None  # between them, an impact passes phase zero
        grazes = replace(cycle, state=place[:size], values=place[size:], clearance=0.0, since=0.0)
        return Point(grazes, point.tangent, point.weights)

    def meetings(self, a: Point, b: Point, step: float) -> list[Meeting]:
        """Return nothing: on the other side, other kinds end where an orbit grazes."""
        return []


# ---- where a curve starts ------------------------------------------------------------------------


def calibrated(tracer: Tracer, place: np.ndarray, n: int) -> Tracer | None:
    """Return the tracer of a curve of grazing from the orbits on both sides of a GR.

    They tell which impacts come and go, and how deep a soft one would go on a free course, against
    the square of its speed; None where only one side is found.
    """
    size = tracer.section_map.size
    sides: list[Cycle] = []
    for sign in (1.0, -1.0):
        start = place.copy()
        start[size] += sign * BESIDE * max(abs(place[size]), 1.0e-3)
        cycle = _closed_at(tracer.section_map, start, n)
        if cycle is None:
            return None
        sides.append(cycle)
    without, touching = sorted(sides, key=lambda cycle: sum(cycle.counts))
    gained = [j - i for i, j in zip(without.counts, touching.counts, strict=True)]
    if sorted(gained) != [0, 1]:
        return None
    softness = without.clearance / (touching.slowest * touching.slowest)
    return replace(tracer, without=without.counts, wall=gained.index(1), softness=softness)


def _closed_at(section_map: SectionMap, place: np.ndarray, n: int) -> Cycle | None:
    """Return the orbit near a place at its own parameters; None where there is none."""
    size = section_map.size
    row = np.zeros((2, size + 2))
    row[0, size] = row[1, size + 1] = 1.0
    for _ in range(OF_CURVE.most):
        cycle = section_map.at(place, n)
        if cycle is None or cycle.defect < CLOSED:
            return cycle
        right = np.concatenate([-cycle.gap, [0.0, 0.0]])
        step, _ = bordered(closing(cycle), cycle.slopes, row, right)
        if step is None or not np.isfinite(step).all():
            return None
        place = place + step
    return None


def beside(tracer: Tracer, place: np.ndarray, n: int, impacts: int) -> RigidTracer | None:
    """Return the tracer of a curve of grazing of rigid bodies, and let `place` be beside it.

    Arguments: the `impacts` of the orbit without the one that grazes.  On one side of the parameter
    that orbit is there; None where it is not found.
    """
    section_map, size = tracer.section_map, tracer.section_map.size
    unit = max(abs(place[size]), 1.0e-3)
    for step in (BESIDE * unit * 10.0**i for i in range(5)):
        for sign in (1.0, -1.0):
            start = place.copy()
            start[size] += sign * step
            cycle = _closed_at(section_map, start, n)
            if cycle is None or sum(cycle.counts) != impacts or not cycle.clearance > 0.0:
                continue
            weights = section_map.weights(cycle, tracer.high - tracer.low)
            place[:] = cycle.place
            return RigidTracer(
                section_map, tracer.kind, tracer.low, tracer.high, without=cycle.counts,
                level=LEVEL / float(weights[2 if size == 4 else 0]),
            )  # fmt: skip
    return None


def trace_curve(tracer: Tracer, place: np.ndarray, n: int, impacts: int) -> Curve | None:
    """Return the curve through a special point, both ways; None where there is none.

    Arguments: its `place` (size + 2,), with both parameters; n; the `impacts` of its orbit, at a
    grazing those of the orbit without the impact.
    """
    if tracer.kind == "GR":
        place = place.copy()
        rigid = any(law.instant for law in tracer.section_map.scene.laws)
        known = beside(tracer, place, n, impacts) if rigid else calibrated(tracer, place, n)
        if known is None:
            return None
        tracer = known
    start = _start(tracer, place, n)
    if start is None:
        return None
    ahead, meetings, end = tracer.follow(start)
    behind, others, other_end = [start], list[Meeting](), end
    if end != "closed":
        back = Point(start.cycle, -start.tangent, start.weights)
        behind, others, other_end = tracer.follow(back)
    points = [tracer.finished(point) for point in (*reversed(behind[1:]), *ahead)]
    whole = [point for point in points if point is not None]
    return Curve(tracer.kind, whole, [*reversed(others), *meetings], (other_end, end))


def _start(tracer: Tracer, place: np.ndarray, n: int) -> Point | None:
    """Return the first point of a curve, along which one of the parameters rises."""
    zero, size = tracer.section_map, tracer.section_map.size
    here = best_map(zero, place, n)
    there = place_at(zero, place, n, here.since)
    cycle = None if there is None else here.at(there, n)
    if cycle is None:
        return None
    for axis in (size + 1, size):  # the second parameter first: the curve crosses the branch
        toward = np.zeros(size + 2)
        toward[axis] = 1.0
        start = tracer.point(cycle, toward)
        if start is not None:
            return start
    return None
