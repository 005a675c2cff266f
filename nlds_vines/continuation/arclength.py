"""Pseudo-arclength continuation of nT orbits: predictor, Newton corrector, step control.

The unknowns are the state at one phase and the free parameter, both scaled.  The predictor is the
tangent: earlier points are not extrapolated, because where an impact appears or vanishes the
tangent has a kink, which the step control resolves.

Source: Allgower and Georg, Introduction to Numerical Continuation Methods, chapters 2 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nlds_vines.engine.section_map import Cycle, SectionMap, bordered

# Relative defect at which Newton's method has converged; and at which it may stop if the last step
# did not reduce the defect by a factor of four.
CLOSED, GOOD_ENOUGH = 1.0e-13, 1.0e-9


class Newton(NamedTuple):
    """Stopping rules of Newton's method."""

    most_steps: int
    round_off: float  # weighted length of a step that counts as converged
    # The contraction is measured only if the first step is longer than this: where multipliers are
    # large, round-off alone leaves a defect of that size.
    least_first: float


# The rules on a branch, and on a curve of special points, whose derivatives are differences.
OF_BRANCH, OF_CURVE = Newton(8, 1.0e-12, 1.0e-8), Newton(10, 1.0e-11, 1.0e-7)

# The further equation of a curve of special points: its residual and the derivatives of that with
# respect to state and parameters; None if they cannot be evaluated.
Equation = Callable[[Cycle], tuple[float, np.ndarray] | None]

# Weighted lengths of steps: relative to the orbit and to the parameter's interval.
FIRST_STEP, LEAST_STEP, LONGEST_STEP = 1.0e-2, 1.0e-9, 2.0e-2

# The step control aims at this ratio of Newton's second to its first step, and at this angle [rad]
# between successive tangents; it repeats a step that exceeds one of them by more than a factor.
CONTRACTION, ANGLE, SHARPEST = 1.0e-2, 0.1, 3.0


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch or of a curve of special points."""

    cycle: Cycle
    tangent: np.ndarray  # (size + m,) of weighted length one
    weights: np.ndarray  # (size + m,) of `SectionMap.weights`
    border: float = 0.0  # on a branch: determinant of the closing equations bordered by the tangent

    @property
    def value(self) -> float:  # of the first free parameter
        return float(self.cycle.values[0])

    @property
    def normal(self) -> np.ndarray:  # of the plane in which Newton's method corrects a prediction
        return self.weights * self.weights * self.tangent

    @cached_property
    def tests(self) -> dict[str, float]:
        """The test functions by kind of special point, each of which changes its sign there.

        LP: the parameter's component of the tangent.  BP: the determinant of the closing equations
        bordered by the tangent.  PD: det(M + I).  NS: the product of mu_i mu_j - 1 over all pairs,
        det(M . M - I) with the bialternate product.
        """
        mu = self.cycle.multipliers.tolist()
        pairs = [mu[i] * mu[j] - 1.0 for i in range(len(mu)) for j in range(i)]
        return {
            "LP": float(self.tangent[-1]),
            "BP": self.border,
            "PD": real_product([m + 1.0 for m in mu]),
            "NS": real_product(pairs),
        }


def real_product(factors: list[complex]) -> float:
    return math.prod(factors, start=1.0 + 0.0j).real


def length(weights: np.ndarray, step: np.ndarray) -> float:
    scaled = weights * step
    return math.sqrt(float((scaled * scaled).sum()))


def close(
    section_map: SectionMap,
    place: np.ndarray,
    n: int,
    row: np.ndarray,
    weights: np.ndarray,
    equation: Equation | None = None,
) -> tuple[Cycle | None, float, np.ndarray]:
    """Return the nT orbit in the plane through `place` normal to `row`; None if none is found.

    Also returned are the contraction, the ratio of Newton's second to its first step, 0 if there
    was no second; and the rows (m, size + m) that border the closing equations: the derivatives of
    `equation`, the further one of a curve of special points, and `row`.
    """
    anchor, before, first, ratio = place, math.inf, 0.0, 0.0
    rows, rules = row[np.newaxis], OF_BRANCH if equation is None else OF_CURVE
    for iteration in range(rules.most_steps):
        cycle = section_map.at(place, n)
        if cycle is None:
            break
        right = np.append(-cycle.residual, -float((row * (place - anchor)).sum()))
        if equation is not None:
            linearized = equation(cycle)
            if linearized is None:
                break
            value, slope = linearized
            rows, right = np.array([slope, row]), np.insert(right, -1, -value)
        elif cycle.defect <= CLOSED or (
            cycle.defect <= GOOD_ENOUGH and cycle.defect > 0.25 * before
        ):
            return cycle, ratio, rows
        step, _ = bordered(cycle.closing, cycle.slopes, rows, right)
        if step is None or not np.isfinite(step).all():
            break
        far = length(weights, step)
        if far <= rules.round_off:
            return cycle, ratio, rows
        if iteration == 0:
            first = far
        elif iteration == 1 and first > rules.least_first:
            ratio = far / first
        if far > 2.0 * first:
            break
        place, before = place + step, cycle.defect
    return None, math.inf, rows


def with_tangent(cycle: Cycle, rows: np.ndarray, weights: np.ndarray) -> Point | None:
    """Return the point at an orbit, its tangent turned toward the last of `rows`, if unique."""
    unit = np.eye(len(weights))[-1]
    tangent, determinant = bordered(cycle.closing, cycle.slopes, rows, unit)
    if tangent is None or not np.isfinite(tangent).all():
        return None
    return Point(cycle, tangent / length(weights, tangent), weights, determinant)


def point_of(
    section_map: SectionMap, cycle: Cycle, toward: np.ndarray, lengths: np.ndarray
) -> Point | None:
    """Return the point of a branch at an orbit, its tangent turned `toward` a direction."""
    weights = section_map.weights(cycle, lengths)
    point = with_tangent(cycle, (weights * weights * toward)[np.newaxis], weights)
    if point is None:
        return None
    return replace(point, border=point.border / length(weights, toward))


def along(section_map: SectionMap, point: Point, step: float) -> tuple[Point | None, float]:
    """Return the point, if any, at a signed distance along a tangent, and the contraction."""
    place = point.cycle.place + step * point.tangent
    cycle, contraction, _ = close(section_map, place, point.cycle.n, point.normal, point.weights)
    if cycle is None:
        return None, contraction
    return point_of(section_map, cycle, point.tangent, 1.0 / point.weights[-1:]), contraction


def angle_of(a: Point, b: Point) -> float:
    cosine = float((a.normal * b.tangent).sum()) / length(a.weights, b.tangent)
    return math.acos(max(-1.0, min(1.0, cosine)))


@dataclass
class Stepper:
    """Steps along one branch in one direction, as long as contraction and angle allow."""

    section_map: SectionMap
    point: Point
    step: float = FIRST_STEP
    longest: float = LONGEST_STEP

    def advance(self, most: float = math.inf) -> Point | None:
        """Return the next point, at most `most` away; None if not even the shortest converges."""
        step = min(self.step, most)
        while True:
            point, contraction = along(self.section_map, self.point, step)
            shortest = step <= 2.0 * LEAST_STEP
            if point is not None:
                bent = angle_of(self.point, point) / ANGLE
                worst = max(math.sqrt(contraction / CONTRACTION), bent)
                if worst <= SHARPEST or shortest:
                    self.last_step, self.point = step, point
                    self.step = step * min(2.0, max(0.5, 1.0 / max(worst, 1.0e-3)))
                    self.step = max(LEAST_STEP, min(self.longest, self.step))
                    return point
            if shortest:
                return None
            step = max(LEAST_STEP, step * (0.5 if point is None else 1.0 / min(worst, 8.0)))


# ---- the phase at which rigid impacts are solved ----
#
# The state jumps when a rigid impact passes its phase, and the section map has no derivative there.
# Newton's method therefore solves for a state in the middle of the longest flight, which is chosen
# anew along the branch before an impact comes near.  Archives hold states at phase zero.

# The flight is chosen anew if an impact is nearer to the phase than this fraction of half the
# longest flight.
NEAR = 0.25

SHARPNESS = 1024  # phases are multiples of 1 / SHARPNESS of a period, so that adding 1 is exact
ASIDE = 1.0e-6  # difference step that carries a tangent to another phase


def better_map(section_map: SectionMap, cycle: Cycle) -> SectionMap | None:
    """Return the map from the middle of the orbit's longest flight; None to stay at this phase."""
    if not section_map.is_rigid:
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
    """Return the best map for the orbit near `place`, a place of the map at phase zero."""
    cycle = zero.at(place, n)
    return (None if cycle is None else better_map(zero, cycle)) or zero


def place_at(
    section_map: SectionMap, place: np.ndarray, n: int, since: float = 0.0
) -> np.ndarray | None:
    """Return an nT orbit's place at phase `since` [periods] from its place in `section_map`."""
    time = (since - section_map.since) % n
    return section_map.later(place, time) if time else place


def seen_by(
    before: SectionMap, after: SectionMap, cycle: Cycle, direction: np.ndarray
) -> tuple[Cycle, np.ndarray] | None:
    """Return an orbit and a direction at it, given in map `before`, in the map `after`."""
    there = place_at(before, cycle.place, cycle.n, after.since)
    beside = place_at(before, cycle.place + ASIDE * direction, cycle.n, after.since)
    image = None if there is None else after.at(there, cycle.n)
    if image is None or there is None or beside is None:
        return None
    # round-off at a grazing must not change the impacts of the orbit
    names = ("counts", "shares", "multipliers", "clearance", "nearest", "slowest", "volume")
    invariant = {name: getattr(cycle, name) for name in names}
    return replace(image, **invariant), (beside - there) / ASIDE


def moved(before: SectionMap, after: SectionMap, point: Point) -> Point | None:
    """Return a point of a branch in map `before` as one in the map `after`."""
    seen = seen_by(before, after, point.cycle, point.tangent)
    if seen is None:
        return None
    cycle, direction = seen
    lengths = 1.0 / point.weights[-1:]
    # where two branches cross, the border is 0 and the tangent is not unique: it is transported
    exact = point_of(after, cycle, direction, lengths) if point.border != 0.0 else None
    if exact is not None:
        return exact
    weights = after.weights(cycle, lengths)
    return Point(cycle, direction / length(weights, direction), weights, point.border)


def point_at_zero(zero: SectionMap, point: Point) -> Point:
    if not point.cycle.since:
        return point
    at_zero = moved(zero.shot(point.cycle.since), zero, point)
    if at_zero is None:
        raise RuntimeError(f"an orbit at {point.value!r} is lost on its way to phase zero")
    return at_zero
