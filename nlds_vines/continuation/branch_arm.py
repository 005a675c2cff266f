"""One branch from a point on, in one direction: its points, its special points, why it ends."""

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
    NEARER,
    Point,
    Stepper,
    along,
    close,
    length,
    point_of,
)
from nlds_vines.continuation.section_map import Cycle, SectionMap, shoots_from_flights
from nlds_vines.continuation.shooting_phase import (
    SAME_ORBIT,
    better_map,
    is_symmetric,
    moved,
    place_at,
    point_at_zero,
)
from nlds_vines.continuation.special_points import (
    Special,
    doubling_near,
    label_of_cycle,
    limit_of,
    specials_between,
    step_between,
    unexplained,
)
from nlds_vines.model.labels import name_of

MOST_POINTS = 3_000
"""Points of one branch in one direction."""

UNSEEN = 1.0e-6
"""Step below which multipliers that cross the circle together are not looked at more closely."""

END_OF_WAY, MOST_KNOTS = 1.0e-11, 7
"""Error of the orbit that grazes, by polynomials through so many points; where a branch ends."""

NEAR_GRAZING = 1.0e-4
"""Distance from a grazing, relative to the orbit and the interval, within which a branch ends there
where no step leads on; and the largest error of a grazing that is located at all."""

TURN = 1.0e-8
"""Distance in the parameter, relative to it or to 1, within which fold and branch point are one."""

RECENT = MOST_KNOTS + 1
"""Points that are looked back at."""

APART = 1.5
"""Ratio of the speeds, or misses, of two such points, at least: nearer ones tell their errors."""

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
"""Why a branch ends, by a word."""

Known = Callable[[Point], bool]


@dataclass
class Arm:
    """One direction of a branch: its points, the special points, and why it ends (of `ENDS`).

    `best_grazing` is the grazing ahead that is located best so far.

    While it is followed, `begin` is its first point as the map at hand has it, and so are the last
    RECENT points; those before may be at other phases.
    """

    points: list[Point] = field(default_factory=list)
    specials: list[Special] = field(default_factory=list)
    end: str = ""
    best_grazing: Special | None = None

    @cached_property
    def begin(self) -> Point:
        """The first point."""
        return self.points[0]


@dataclass(frozen=True)
class Bounds:
    """The interval of the free parameter."""

    low: float
    high: float

    @property
    def lengths(self) -> np.ndarray:
        """The unit in which the parameter counts (1,)."""
        return np.array([self.high - self.low])

    def contains(self, value: float) -> bool:
        """Tell whether a value lies in it."""
        return self.low <= value <= self.high


def at_value(section_map: SectionMap, place: np.ndarray, n: int, value: float) -> Cycle | None:
    """Return the nT orbit near a place whose parameter has a value; None where there is none."""
    row = np.zeros(len(place))
    row[-1] = 1.0
    start = place.copy()
    start[-1] = value
    weights = np.ones(len(place))
    return close(section_map, start, n, row, weights)[0]


def first_point(section_map: SectionMap, cycle: Cycle, bounds: Bounds, sign: float) -> Point | None:
    """Return the first point of a branch whose parameter rises (sign 1) or falls (-1) from it on.

    At a fold, where the parameter does neither, the branch goes along any of its tangents.
    """
    size = section_map.size
    for i in range(size, -1, -1):  # the parameter first
        toward = np.zeros(size + 1)
        toward[i] = sign
        found = point_of(section_map, cycle, toward, bounds.lengths)
        if found is not None:
            return found
    return None


def follow(
    section_map: SectionMap,
    start: Point,
    bounds: Bounds,
    *,
    known: Known | None = None,
    first: float = FIRST_STEP,
    longest: float = LONGEST_STEP,
    unstable: int = MOST_POINTS,
) -> Arm:
    """Follow a branch from a point on, along its tangent, until it ends.

    Arguments: the `bounds` of the parameter; `known` tells whether a point lies on a branch that is
    known; the `first` and the `longest` step; `unstable` points that are followed one after another
    after a stable one.
    """
    arm, zero, rigid = Arm([start]), section_map, shoots_from_flights(section_map.scene)
    stepper = Stepper(section_map, start, first, longest)
    in_a_row = int(start.cycle.unstable > 0)
    while not arm.end:
        a = stepper.point
        b = stepper.advance(_way_to_grazing(section_map, arm))
        if b is None:
            _end_of_lost(arm)
            break
        leaps = rigid and b.cycle.counts != a.cycle.counts
        if (unexplained(a, b) and stepper.taken > UNSEEN) or (leaps and stepper.taken > LEAST_STEP):
            stepper.point, stepper.step = a, max(LEAST_STEP, 0.25 * stepper.taken)
            continue
        if leaps:
            _end_of_lost(arm)
            break
        _go_on(section_map, arm, b, bounds, known)
        stepper.point = arm.points[-1]
        in_a_row = in_a_row + 1 if stepper.point.cycle.unstable else 0
        if not arm.end and in_a_row > unstable:
            arm.end = "unstable"
        section_map = _from_longest_flight(section_map, arm, stepper)
    arm.points = [point_at_zero(zero, point) for point in arm.points]
    arm.specials = [replace(s, point=point_at_zero(zero, s.point)) for s in arm.specials]
    return arm


def _from_longest_flight(section_map: SectionMap, arm: Arm, stepper: Stepper) -> SectionMap:
    """Return the map of the next step; where it is another, take the last points over to it."""
    better = None if arm.end else better_map(section_map, arm.points[-1].cycle)
    if better is None:
        return section_map
    points = [moved(section_map, better, point) for point in (arm.begin, *arm.points[-RECENT:])]
    found = [point for point in points if point is not None]
    if len(found) < len(points):
        return section_map
    arm.begin, arm.points[-RECENT:] = found[0], found[1:]
    stepper.section_map, stepper.point = better, arm.points[-1]
    return better


def _go_on(
    section_map: SectionMap, arm: Arm, b: Point, bounds: Bounds, known: Known | None
) -> None:
    """Add a point and the special points before it; note whether the branch ends there."""
    a = arm.points[-1]
    if not bounds.contains(b.value):
        value = bounds.low if b.value < bounds.low else bounds.high
        cycle = at_value(section_map, _between(a, b, value), b.cycle.n, value)
        end = None if cycle is None else point_of(section_map, cycle, a.tangent, bounds.lengths)
        arm.end = "bound"
        if end is None:
            return
        b = end
    elif len(arm.points) >= MOST_POINTS:
        arm.end = "long"
    elif _is_back(arm, b):
        arm.end = "closed"
    elif _passes_shorter(section_map, arm, b):
        arm.end = "shorter"
    elif known is not None and known(b):
        arm.end = "known"
    if arm.end == "shorter":
        b = _shorter_orbit(section_map, arm, b)
    else:
        for special in specials_between(section_map, a, b):
            arm.specials.append(replace(special, index=len(arm.points) - 1))
            _drop_turn_at_branch_point(arm)
    arm.points.append(b)
    if not arm.end:
        _end_at_grazing(section_map, arm)
    if not arm.end and _is_beyond(section_map, b):
        _end_at_limit(section_map, arm)


def _drop_turn_at_branch_point(arm: Arm) -> None:
    """Drop a fold that is the branch point beside it.

    A branch that leaves symmetric orbits turns at its branch point.  If a point of the branch lies
    there, the fold is found in the one step, and the branch point in the next.
    """
    last = arm.specials[-2:]
    if {special.kind for special in last} != {"LP", "BP"}:
        return
    if abs(last[0].value - last[1].value) < TURN * max(1.0, abs(last[0].value)):
        arm.specials[-2:] = [special for special in last if special.kind == "BP"]


def _between(a: Point, b: Point, value: float) -> np.ndarray:
    """Return the place between two points, in a straight line, where the parameter has a value."""
    share = (value - a.value) / (b.value - a.value)
    return a.cycle.place + share * (b.cycle.place - a.cycle.place)


# ---- why a branch ends ---------------------------------------------------------------------------


def _is_back(arm: Arm, b: Point) -> bool:
    """Tell whether a branch has come back to its first orbit, at whatever phase of it."""
    if len(arm.points) < 4:
        return False
    a, first = arm.points[-1], arm.begin
    step = step_between(a, b)
    size = first.cycle.state.size
    for point in first.cycle.points:
        place = np.append(point[:size], first.value)
        way = a.weights * a.weights * a.tangent * (place - a.cycle.place)
        if 0.0 < float(way.sum()) <= step:
            aside = place - a.cycle.place - float(way.sum()) * a.tangent
            if length(a.weights, aside) < 0.1 * step:
                return True
    return False


def half_of(cycle: Cycle) -> np.ndarray:
    """Return how an orbit of even n differs, at phase zero, from itself half its period later."""
    return cycle.points[cycle.n // 2 - 1, : cycle.state.size] - cycle.state


def _passes_shorter(section_map: SectionMap, arm: Arm, b: Point) -> bool:
    """Tell whether an orbit of even n becomes one of n / 2 on the way to b."""
    a = arm.points[-1]
    if b.cycle.n % 2 or len(arm.points) < 2:
        return False
    weights = a.weights[:-1] * a.weights[:-1]
    far = length(b.weights[:-1], half_of(b.cycle))
    turned = float((weights * half_of(a.cycle) * half_of(b.cycle)).sum()) < 0.0
    return far < SAME_ORBIT or (turned and far < 4.0 * step_between(a, b))


def _shorter_orbit(section_map: SectionMap, arm: Arm, b: Point) -> Point:
    """Return, in place of b, the orbit of half the period that doubles there; b if none is located.

    Newton's method has no sharp solution for the whole orbit there, but for the half of it.  That
    is roughly where what the two halves differ by, with its sign, vanishes: a polynomial through
    the last points tells.
    """
    a, points = arm.points[-1], [*arm.points[-3:], b]
    weights, toward = b.weights[:-1] * b.weights[:-1], half_of(a.cycle)
    knots = [(float((weights * half_of(p.cycle) * toward).sum()), p.cycle.place) for p in points]
    if len({f for f, _ in knots}) < len(knots):
        return b
    half, most = b.cycle.n // 2, step_between(a, b)
    found = doubling_near(section_map, limit_of(knots), half, 1.0 / b.weights[-1:], most)
    cycle = None if found is None else section_map.at(found.cycle.place, b.cycle.n)
    return b if cycle is None else replace(b, cycle=cycle)


def _ways(a: Point, b: Point) -> list[float]:
    """Return how far from b the nearest miss and the softest impact vanish, if they go on so."""
    step, found = step_between(a, b), []
    for name in ("clearance", "slowest"):
        before, now = getattr(a.cycle, name), getattr(b.cycle, name)
        if math.isfinite(before) and math.isfinite(now) and before > now and step > 0.0:
            found.append(step * now / (before - now))
    return found


def _way_to_grazing(section_map: SectionMap, arm: Arm) -> float:
    """Return the longest step where rigid bodies may graze: part of the way until they do."""
    if not shoots_from_flights(section_map.scene) or len(arm.points) < 2:
        return math.inf
    ways = _ways(*arm.points[-2:])
    return max(NEARER * min(ways, default=math.inf), LEAST_STEP * 1.0e-3)


def _end_at_grazing(section_map: SectionMap, arm: Arm) -> None:
    """End a branch where rigid bodies are about to graze, and note where they do.

    A softest impact of speed v, or a nearest miss, is what the last points are smooth functions of;
    the derivatives of the map are not, they grow as 1 / v.  So the orbit that grazes is what a
    polynomial in v through these points is at v = 0.
    """
    if not shoots_from_flights(section_map.scene):
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
        # of an orbit that is its own mirror, impacts at both walls graze
        both = is_symmetric(section_map, point.cycle)
        more = (2 if both else 1) * (-1 if name == "slowest" else 1)
        there = section_map.at(place, point.cycle.n) or point.cycle
        grazes: dict[str, Any] = {name: 0.0}
        cycle = replace(
            point.cycle, state=place[:-1], values=place[-1:], points=there.points, **grazes
        )
        wall = "both" if both else _wall(section_map)
        label, beyond = label_of_cycle(cycle), name_of(cycle.n, sum(cycle.counts) + more)
        end, index = replace(point, cycle=cycle), len(arm.points) - 1
        arm.best_grazing = Special("GR", end, label, beyond, error, width, wall, index)
        if error <= END_OF_WAY:
            _end_at(arm, arm.best_grazing)
            return


def _end_at(arm: Arm, grazing: Special) -> None:
    """End a branch at the orbit that grazes; points behind the one that it was located from go."""
    arm.points = [*arm.points[: grazing.index + 1], grazing.point]
    arm.specials = [s for s in arm.specials if s.index < grazing.index]
    arm.specials.append(grazing)
    arm.end = "grazing"


def _end_of_lost(arm: Arm) -> None:
    """End a branch where no step leads on: at the grazing nearby, if one was located, or lost.

    The speed of the softest impact errs by the root of what a state errs.  So polynomials become
    worse beyond some point, and the best of them counts.
    """
    grazing, last = arm.best_grazing, arm.points[-1]
    arm.end = "lost"
    if grazing is None or grazing.point.cycle.since != last.cycle.since:
        return
    if length(last.weights, grazing.point.cycle.place - last.cycle.place) < NEAR_GRAZING:
        _end_at(arm, grazing)


def end_beside(arm: Arm, grazing: Special) -> None:
    """End a lost branch at a grazing that another branch has located, if it is lost beside it."""
    last, place = arm.points[-1], grazing.point.cycle.place
    if arm.end != "lost" or length(last.weights, place - last.cycle.place) > NEAR_GRAZING:
        return
    there = grazing.point.cycle
    cycle = replace(last.cycle, state=there.state, values=there.values, points=there.points)
    labels = label_of_cycle(cycle), label_of_cycle(there)
    end, index = replace(last, cycle=cycle), len(arm.points) - 1
    _end_at(arm, replace(grazing, point=end, before=labels[0], after=labels[1], index=index))


def _knots(name: str, points: list[Point]) -> list[tuple[float, np.ndarray]]:
    """Return the last speeds, or misses, with their places: as they fall, each APART of the next.

    Of points that one map has found, with the same impacts; steps may be far shorter than that.
    """
    last, now = points[-1].cycle, 0.0
    found: list[tuple[float, np.ndarray]] = []
    for cycle in (point.cycle for point in reversed(points)):
        before, now = now, getattr(cycle, name)
        alike = (cycle.since, cycle.counts) == (last.since, last.counts)
        if not (alike and before < now < math.inf) or len(found) == MOST_KNOTS:
            break
        if not found or now > APART * found[-1][0]:
            found.append((now, cycle.place))
    return found[::-1]


def _wall(section_map: SectionMap) -> str:
    """Return the wall of a grazing if there is only one that it can be."""
    walls = section_map.scene.walls
    return walls[0] if len(walls) == 1 else ""


def _is_beyond(section_map: SectionMap, point: Point) -> bool:
    """Tell whether an orbit passes the limit of its scene."""
    if section_map.scene.limit is None:
        return False
    n = point.cycle.n
    place = place_at(section_map, point.cycle.place, n)
    measured = None if place is None else section_map.measure(place[np.newaxis], np.array([n]))
    return measured is None or bool(measured.beyond[0] > 0.0)


def _end_at_limit(section_map: SectionMap, arm: Arm) -> None:
    """End a branch at the orbit that touches the limit, which is looked for by halving."""
    a, b = arm.points[-2:]
    low, high, at = 0.0, step_between(a, b), b
    while high - low > END_OF_WAY:
        middle = 0.5 * (low + high)
        point, _ = along(section_map, a, middle)
        if point is None:
            break
        if _is_beyond(section_map, point):
            high, at = middle, point
        else:
            low = middle
    label = label_of_cycle(at.cycle)
    width = (high - low) * abs(float(at.tangent[-1]))
    index = len(arm.points) - 2
    arm.specials.append(Special("LIM", at, label, label, high - low, width, index=index))
    arm.points[-1], arm.end = at, "limit"
