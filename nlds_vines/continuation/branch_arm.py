"""One direction of a branch: its points, its special points, and why it ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.continuation.arclength import (
    FIRST_STEP,
    LEAST_STEP,
    LONGEST_STEP,
    Point,
    Stepper,
    along,
    better_map,
    close,
    length,
    moved,
    place_at,
    point_at_zero,
    point_of,
)
from nlds_vines.continuation.special_points import (
    Special,
    doubling_near,
    half_of,
    limit_of,
    specials_between,
    step_between,
    unexplained,
    walls_in_words,
)
from nlds_vines.engine.section_map import SAME_ORBIT, Cycle, SectionMap

MOST_POINTS = 3_000  # of a branch in one direction, by default

# Steps are not shortened below this to separate multipliers that cross the circle together.
LEAST_SPLIT = 1.0e-6

# Error at which an extrapolated grazing counts as located, and the knots of its polynomial.
GRAZING_ERROR, MOST_KNOTS = 1.0e-11, 7

# A branch that no step continues ends at a grazing within this weighted distance; also the largest
# error of a grazing that is recorded.
NEAR_GRAZING = 1.0e-4

# Relative distance in the parameter below which a fold and a branch point are the same point.
SAME_TURN = 1.0e-8

RECENT = MOST_KNOTS + 1  # the last points that are kept at the current phase
NEARER = 0.5  # longest step to a rigid grazing, as a fraction of the distance to it

# Least ratio of the speeds, or clearances, of successive knots: between closer knots, errors of
# the points dominate the extrapolation.
KNOT_RATIO = 1.5

# reasons why a branch ends
ENDS = {
    "bound": "the end of the interval",
    "closed": "a closed loop: it is back at its first orbit",
    "known": "it goes on as a branch that is known",
    "shorter": "it has become the orbit of half the period that it doubles",
    "grazing": "an impact of rigid bodies grazes: no smooth branch goes on",
    "limit": "the limit of the scene is passed",
    "lost": "Newton's method does not converge, or the orbit has too many impacts",
    "unstable": "it was to be followed no further where it is unstable",
    "long": "it has more points than one branch may have",
}


@dataclass
class Arm:
    """One direction of a branch.

    While it is followed, `begin` (its first point) and the last RECENT points are at the phase of
    the current section map; earlier points may be at other phases.
    """

    points: list[Point]
    specials: list[Special] = field(default_factory=list)
    end: str = ""  # why it ends, a key of `ENDS`
    best_grazing: Special | None = None  # the most accurate one ahead so far
    most: int = MOST_POINTS

    @cached_property
    def begin(self) -> Point:
        return self.points[0]


@dataclass(frozen=True)
class Bounds:
    """The interval of the free parameter; its length (1,) is the unit of the parameter."""

    low: float
    high: float

    @property
    def lengths(self) -> np.ndarray:
        return np.array([self.high - self.low])

    def contains(self, value: float) -> bool:
        return self.low <= value <= self.high


def at_value(section_map: SectionMap, place: np.ndarray, n: int, value: float) -> Cycle | None:
    """Return the nT orbit near a place at a value of the parameter; None if no orbit closes."""
    start = place.copy()
    start[-1] = value
    return close(section_map, start, n, np.eye(len(place))[-1], np.ones(len(place)))[0]


def first_point(section_map: SectionMap, cycle: Cycle, bounds: Bounds, sign: float) -> Point | None:
    """Return the first point of a branch along which the parameter rises (sign 1) or falls (-1)."""
    # at a fold, where the parameter is stationary, a component of the state takes its place
    axes = np.eye(section_map.size + 1)[::-1]
    points = (point_of(section_map, cycle, sign * axis, bounds.lengths) for axis in axes)
    return next((point for point in points if point is not None), None)


def follow(
    section_map: SectionMap,
    start: Point,
    bounds: Bounds,
    *,
    followed: Callable[[Point], bool] = lambda point: False,
    first: float = FIRST_STEP,
    longest: float = LONGEST_STEP,
    unstable: int = MOST_POINTS,
    most: int = MOST_POINTS,
) -> Arm:
    """Follow a branch from a point along its tangent until it ends.

    `followed` returns True for a point of a branch that has been followed before; `first` and
    `longest` are weighted lengths of steps, `unstable` the most successive unstable points, `most`
    the most points.
    """
    arm, zero, rigid = Arm([start], most=most), section_map, section_map.is_rigid
    stepper = Stepper(section_map, start, first, longest)
    in_a_row = int(start.cycle.unstable > 0)
    while not arm.end:
        a = stepper.point
        farthest = math.inf
        if rigid and len(arm.points) > 1:
            # a fraction of the distance to a grazing, where the map has no derivative, by linear
            # extrapolation of clearance and softest approach speed
            one, two = arm.points[-2:]
            for name in ("clearance", "slowest"):
                f, g = getattr(one.cycle, name), getattr(two.cycle, name)
                step = step_between(one, two)
                if math.isfinite(f) and math.isfinite(g) and f > g and step > 0.0:
                    farthest = min(farthest, step * g / (f - g))
            farthest = max(NEARER * farthest, LEAST_STEP * 1.0e-3)
        b = stepper.advance(farthest)
        if b is None:
            _end_of_lost(arm)
            break
        leaps = rigid and b.cycle.counts != a.cycle.counts
        if (unexplained(a, b) and stepper.last_step > LEAST_SPLIT) or (
            leaps and stepper.last_step > LEAST_STEP
        ):
            stepper.point, stepper.step = a, max(LEAST_STEP, 0.25 * stepper.last_step)
            continue
        if leaps:
            _end_of_lost(arm)
            break
        _append(section_map, arm, b, bounds, followed)
        stepper.point = arm.points[-1]
        in_a_row = in_a_row + 1 if stepper.point.cycle.unstable else 0
        if not arm.end and in_a_row > unstable:
            arm.end = "unstable"
        better = None if arm.end else better_map(section_map, arm.points[-1].cycle)
        if better is not None:  # the last points are transported to its phase
            recent = (arm.begin, *arm.points[-RECENT:])
            seen = [moved(section_map, better, point) for point in recent]
            transported = [point for point in seen if point is not None]
            if len(transported) == len(seen):
                arm.begin, arm.points[-RECENT:] = transported[0], transported[1:]
                section_map = stepper.section_map = better
                stepper.point = arm.points[-1]
    arm.points = [point_at_zero(zero, point) for point in arm.points]
    arm.specials = [replace(s, point=point_at_zero(zero, s.point)) for s in arm.specials]
    return arm


def _append(
    section_map: SectionMap, arm: Arm, b: Point, bounds: Bounds, followed: Callable[[Point], bool]
) -> None:
    """Append a point and the special points before it; set the reason if the branch ends there."""
    a, shorter = arm.points[-1], None
    if not bounds.contains(b.value):
        value = bounds.low if b.value < bounds.low else bounds.high
        if a.value == value:  # the branch begins on the bound
            arm.end = "bound"
            return
        share = (value - a.value) / (b.value - a.value)
        place = a.cycle.place + share * (b.cycle.place - a.cycle.place)
        cycle = at_value(section_map, place, b.cycle.n, value)
        end = None if cycle is None else point_of(section_map, cycle, a.tangent, bounds.lengths)
        arm.end = "bound"
        if end is None:
            return
        b = end
    elif len(arm.points) >= arm.most:
        arm.end = "long"
    elif _is_back(arm, b):
        arm.end = "closed"
    elif (shorter := _shorter_orbit(section_map, arm, b)) is not None:
        arm.end, b = "shorter", shorter
    elif followed(b):
        arm.end = "known"
    if shorter is None:
        for special in specials_between(section_map, a, b):
            arm.specials.append(replace(special, index=len(arm.points) - 1))
            # a branch that leaves symmetric orbits turns at its branch point: if a point of it lies
            # there, the fold is located in one step and the branch point in the next
            last = arm.specials[-2:]
            far = abs(last[0].value - last[-1].value)
            if {one.kind for one in last} == {"LP", "BP"} and far < SAME_TURN * max(
                1.0, abs(last[0].value)
            ):
                arm.specials[-2:] = [one for one in last if one.kind == "BP"]
    arm.points.append(b)
    if not arm.end:
        _end_at_grazing(section_map, arm)
    if not arm.end and _is_beyond(section_map, b):
        _end_at_limit(section_map, arm)


# ---- why a branch ends ----


def _is_back(arm: Arm, b: Point) -> bool:
    """Return True if the branch is back at its first orbit, at any phase of it."""
    if len(arm.points) < 4:
        return False
    a, first = arm.points[-1], arm.begin
    step = step_between(a, b)
    size = first.cycle.state.size
    for point in first.cycle.points:
        place = np.append(point[:size], first.value)
        ahead = float((a.normal * (place - a.cycle.place)).sum())
        if 0.0 < ahead <= step:
            aside = place - a.cycle.place - ahead * a.tangent
            if length(a.weights, aside) < 0.1 * step:
                return True
    return False


def _shorter_orbit(section_map: SectionMap, arm: Arm, b: Point) -> Point | None:
    """Return the orbit of half the period that an orbit of even n becomes before b.

    Newton's method has no sharp solution for the orbit of n periods there, but for that of n / 2.
    Its first guess is where the signed difference of the two halves vanishes, by a polynomial
    through the last points.  None if the orbit keeps its period; b if the other is not located.
    """
    a = arm.points[-1]
    if b.cycle.n % 2 or len(arm.points) < 2:
        return None
    far, most = length(b.weights[:-1], half_of(b.cycle)), step_between(a, b)
    weights, toward = a.weights[:-1] * a.weights[:-1], half_of(a.cycle)
    turned = float((weights * toward * half_of(b.cycle)).sum()) < 0.0
    if far >= SAME_ORBIT and not (turned and far < 4.0 * most):
        return None
    weights, points = b.weights[:-1] * b.weights[:-1], [*arm.points[-3:], b]
    knots = [(float((weights * half_of(p.cycle) * toward).sum()), p.cycle.place) for p in points]
    if len({f for f, _ in knots}) < len(knots):
        return b
    half = b.cycle.n // 2
    doubling = doubling_near(section_map, limit_of(knots), half, 1.0 / b.weights[-1:], most)
    cycle = None if doubling is None else section_map.at(doubling.cycle.place, b.cycle.n)
    return b if cycle is None else replace(b, cycle=cycle)


def _end_at_grazing(section_map: SectionMap, arm: Arm) -> None:
    """End a branch where rigid bodies are about to graze, at the extrapolated grazing orbit.

    The derivatives of the map grow as 1 / v with the softest approach speed v, but the branch is a
    smooth function of v, or of the clearance: a polynomial in it is extrapolated to 0.
    """
    if not section_map.is_rigid:
        return
    point = arm.points[-1]
    for name in ("slowest", "clearance"):
        knots = _knots(name, arm.points)
        if len(knots) < MOST_KNOTS:
            continue
        place, before = limit_of(knots), limit_of(knots[1:])
        far = length(point.weights, place - point.cycle.place)
        error, width = length(point.weights, place - before), abs(float((place - before)[-1]))
        best = NEAR_GRAZING if arm.best_grazing is None else arm.best_grazing.residual
        if error >= best or far > LONGEST_STEP:
            continue
        walls = section_map.grazing_walls(point.cycle, name)
        there = section_map.at(place, point.cycle.n) or point.cycle
        grazes: dict[str, Any] = {name: 0.0}
        cycle = replace(
            point.cycle, state=place[:-1], values=place[-1:], points=there.points, **grazes
        )
        wall = walls_in_words(section_map, walls)
        change = -1 if name == "slowest" else 1
        label, beyond = cycle.label, section_map.label_beyond(cycle, walls, change)
        end, index = replace(point, cycle=cycle), len(arm.points) - 1
        arm.best_grazing = Special("GR", end, label, beyond, error, width, wall, index)
        if error <= GRAZING_ERROR:
            _end_at(arm, arm.best_grazing)
            return


def _end_at(arm: Arm, grazing: Special) -> None:
    """End a branch at a grazing orbit; drop points behind the last knot of its extrapolation."""
    arm.points = [*arm.points[: grazing.index + 1], grazing.point]
    arm.specials = [s for s in arm.specials if s.index < grazing.index]
    arm.specials.append(grazing)
    arm.end = "grazing"


def _end_of_lost(arm: Arm) -> None:
    """End a branch that no step continues: at the grazing nearby, if there is one, or as lost.

    The error of the softest approach speed is the square root of the error of the state, so that
    the polynomials become worse beyond some point, and the best of them counts.
    """
    grazing, last = arm.best_grazing, arm.points[-1]
    arm.end = "lost"
    if grazing is None or grazing.point.cycle.since != last.cycle.since:
        return
    if length(last.weights, grazing.point.cycle.place - last.cycle.place) < NEAR_GRAZING:
        _end_at(arm, grazing)


def end_beside(arm: Arm, grazing: Special) -> None:
    """End a lost branch at a grazing that another branch has located, if it is close enough."""
    last, place = arm.points[-1], grazing.point.cycle.place
    if arm.end != "lost" or length(last.weights, place - last.cycle.place) > NEAR_GRAZING:
        return
    there = grazing.point.cycle
    points = there.points[: last.cycle.n]  # it may repeat an orbit of a shorter period
    cycle = replace(last.cycle, state=there.state, values=there.values, points=points)
    labels = cycle.label, there.label
    end, index = replace(last, cycle=cycle), len(arm.points) - 1
    _end_at(arm, replace(grazing, point=end, before=labels[0], after=labels[1], index=index))


def _knots(name: str, points: list[Point]) -> list[tuple[float, np.ndarray]]:
    """Return knots (speed or clearance, place): the last points with equal impacts and phase."""
    last, now = points[-1].cycle, 0.0
    knots: list[tuple[float, np.ndarray]] = []
    for cycle in (point.cycle for point in reversed(points)):
        before, now = now, getattr(cycle, name)
        alike = (cycle.since, cycle.counts) == (last.since, last.counts)
        if not (alike and before < now < math.inf) or len(knots) == MOST_KNOTS:
            break
        if not knots or now > KNOT_RATIO * knots[-1][0]:
            knots.append((now, cycle.place))
    return knots[::-1]


def _is_beyond(section_map: SectionMap, point: Point) -> bool:
    if section_map.scene.limit is None:
        return False
    n = point.cycle.n
    place = place_at(section_map, point.cycle.place, n)
    if place is None:
        return True
    violation = section_map.measure(place[np.newaxis], np.array([n])).violation
    return bool(violation[0, 1] > 0.0)


def _end_at_limit(section_map: SectionMap, arm: Arm) -> None:
    """End a branch at the orbit that touches the limit, located by bisection."""
    a, b = arm.points[-2:]
    low, high, at = 0.0, step_between(a, b), b
    while high - low > GRAZING_ERROR:
        middle = 0.5 * (low + high)
        point, _ = along(section_map, a, middle)
        if point is None:
            break
        if _is_beyond(section_map, point):
            high, at = middle, point
        else:
            low = middle
    label = at.cycle.label
    width = (high - low) * abs(float(at.tangent[-1]))
    index = len(arm.points) - 2
    arm.specials.append(Special("LIM", at, label, label, high - low, width, index=index))
    arm.points[-1], arm.end = at, "limit"
