"""Pseudo-arclength: along a branch of nT orbits step by step, through folds and grazing alike.

The unknowns are the state at phase zero and the free parameter, scaled.  A step goes along the
tangent, and Newton's method brings it back to the branch in the plane across the tangent.  Nothing
is extrapolated from earlier points: where an impact appears or vanishes the tangent has a kink, and
steps shorten until they resolve it.

Source: Allgower and Georg, Introduction to Numerical Continuation Methods, chapters 2 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nlds_vines.continuation.section_map import Cycle, SectionMap, bordered, closing

CLOSED, GOOD_ENOUGH = 1.0e-13, 1.0e-9
"""Relative defect of an orbit that closes; and of one that no further step brings nearer."""


class Newton(NamedTuple):
    """When Newton's method ends: after the `most` steps, or one that is so `short`, round-off.

    A first step as long as `tells` tells of contraction: where multipliers are large, so is the
    defect of the nearest state that there is.
    """

    most: int
    short: float
    tells: float


OF_BRANCH, OF_CURVE = Newton(8, 1.0e-12, 1.0e-8), Newton(10, 1.0e-11, 1.0e-7)
"""Along a branch, and along a curve of special points, whose slopes are differences: from so near,
it converges in two or three steps."""

Equation = Callable[[Cycle], tuple[float, np.ndarray] | None]
"""What vanishes on a curve beside the gap of its orbits: the value, and the derivatives by state
and parameters; None where they are not known."""

FIRST_STEP, LEAST_STEP, LONGEST_STEP = 1.0e-2, 1.0e-9, 2.0e-2
"""Steps, relative to the orbit and to the interval of the parameter together."""

CONTRACTION, ANGLE = 1.0e-2, 0.1
"""What Newton's second step may be of its first, and the angle of two tangents, that are wished."""

SHARPEST = 3.0
"""How many times ANGLE two tangents may differ before a step is done again, and shorter."""

NEARER = 0.5
"""Part of the way to a grazing of rigid bodies, where the map is not differentiable, of a step."""


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch, or of a curve: its orbit, and the direction there.

    Attributes:
        cycle: the orbit.
        tangent: (size + parameters,) of length one by the weights.
        weights: likewise, by which lengths are measured, `SectionMap.weights`.
        border: of a branch, determinant of the closing equations and the tangent.
    """

    cycle: Cycle
    tangent: np.ndarray
    weights: np.ndarray
    border: float = 0.0

    @property
    def value(self) -> float:
        """The free parameter, of two the first."""
        return float(self.cycle.values[0])

    @cached_property
    def tests(self) -> dict[str, float]:
        """The test functions of special points by kind: each changes its sign at one.

        LP: the tangent's part along the parameter.  BP: the determinant of the closing equations
        with the tangent.  PD: det(M + I).  NS: the product of mu_i mu_j - 1 over all pairs, the
        determinant of M's bialternate product less one.
        """
        mu = self.cycle.multipliers.tolist()
        pairs = [mu[i] * mu[j] - 1.0 for i in range(len(mu)) for j in range(i)]
        return {
            "LP": float(self.tangent[-1]),
            "BP": self.border,
            "PD": _product([m + 1.0 for m in mu]),
            "NS": _product(pairs),
        }


def _product(factors: list[complex]) -> float:
    product = 1.0 + 0.0j
    for factor in factors:
        product *= factor
    return product.real


def length(weights: np.ndarray, step: np.ndarray) -> float:
    """Return the weighted length of a step (size + 1,)."""
    scaled = weights * step
    return math.sqrt(float((scaled * scaled).sum()))


def close(
    section_map: SectionMap, place: np.ndarray, n: int, row: np.ndarray, weights: np.ndarray
) -> tuple[Cycle | None, float]:
    """Return the nT orbit near a place, in the plane through it across `row` (size + 1,).

    Returns None where Newton's method does not converge, and by how much its second step was
    shorter than the first, 0 where there was no second.
    """
    cycle, _, ratio = corrected(section_map, place, n, row, weights)
    return cycle, ratio


def corrected(
    section_map: SectionMap,
    place: np.ndarray,
    n: int,
    row: np.ndarray,
    weights: np.ndarray,
    equation: Equation | None = None,
) -> tuple[Cycle | None, np.ndarray, float]:
    """Return the nT orbit near a place, in the plane through it across `row`, by Newton's method.

    Arguments: `equation`, what vanishes there as well, of a curve.

    Returns also the last row or rows, by which the orbit is told from those beside it, and the
    contraction, as `close`.
    """
    anchor, before, first, ratio = place, math.inf, 0.0, 0.0
    rows, ends = row[np.newaxis], OF_BRANCH if equation is None else OF_CURVE
    for iteration in range(ends.most):
        cycle = section_map.at(place, n)
        if cycle is None:
            break
        right = np.append(-cycle.gap, -float((row * (place - anchor)).sum()))
        if equation is not None:
            told = equation(cycle)
            if told is None:
                break
            value, slope = told
            rows, right = np.array([slope, row]), np.insert(right, -1, -value)
        elif cycle.defect <= CLOSED or (
            cycle.defect <= GOOD_ENOUGH and cycle.defect > 0.25 * before
        ):
            return cycle, rows, ratio
        step, _ = bordered(closing(cycle), cycle.slopes, rows, right)
        if step is None or not np.isfinite(step).all():
            break
        far = length(weights, step)
        if far <= ends.short:
            return cycle, rows, ratio
        if iteration == 0:
            first = far
        elif iteration == 1 and first > ends.tells:
            ratio = far / first
        if far > 2.0 * first:
            break
        place, before = place + step, cycle.defect
    return None, rows, math.inf


def tangent_of(
    cycle: Cycle, rows: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, float] | None:
    """Return the direction, of length one, at an orbit, turned toward the last of the `rows`.

    And the determinant of the closing equations and the rows.  None where there is no single one.
    """
    right = np.zeros(len(weights))
    right[-1] = 1.0
    found, product = bordered(closing(cycle), cycle.slopes, rows, right)
    if found is None or not np.isfinite(found).all():
        return None
    return found / length(weights, found), product


def point_of(
    section_map: SectionMap, cycle: Cycle, toward: np.ndarray, lengths: np.ndarray
) -> Point | None:
    """Return the point of a branch at an orbit, its tangent turned `toward` a direction.

    Arguments: `lengths` (1,) of the parameter's interval.  None where there is no single tangent.
    """
    weights = section_map.weights(cycle, lengths)
    found = tangent_of(cycle, (weights * weights * toward)[np.newaxis], weights)
    return found and Point(cycle, found[0], weights, found[1] / length(weights, toward))


def along(section_map: SectionMap, point: Point, step: float) -> tuple[Point | None, float]:
    """Return the point of the branch a step ahead (behind, where it is negative) of a point.

    Returns also the contraction of Newton's method; None where that does not converge.
    """
    place = point.cycle.place + step * point.tangent
    row = point.weights * point.weights * point.tangent
    cycle, contraction = close(section_map, place, point.cycle.n, row, point.weights)
    if cycle is None:
        return None, contraction
    return point_of(section_map, cycle, point.tangent, 1.0 / point.weights[-1:]), contraction


def angle_of(a: Point, b: Point) -> float:
    """Return the angle between the tangents of two points."""
    weights = a.weights * a.weights
    cosine = float((weights * a.tangent * b.tangent).sum()) / length(a.weights, b.tangent)
    return math.acos(max(-1.0, min(1.0, cosine)))


@dataclass
class Stepper:
    """Steps along one branch in one direction, each as long as contraction and angle allow."""

    section_map: SectionMap
    point: Point
    step: float = FIRST_STEP
    longest: float = LONGEST_STEP

    def advance(self, most: float = math.inf) -> Point | None:
        """Return the next point, at most so far away; None where no step, however short, converges.

        `self.taken` is then the step that was taken.
        """
        step = min(self.step, most)
        while True:
            found, contraction = along(self.section_map, self.point, step)
            shortest = step <= 2.0 * LEAST_STEP
            if found is not None:
                worst = max(
                    math.sqrt(contraction / CONTRACTION),
                    angle_of(self.point, found) / ANGLE,
                )
                if worst <= SHARPEST or shortest:
                    self._accept(found, step, worst)
                    return found
            if shortest:
                return None
            step = max(LEAST_STEP, step * (0.5 if found is None else 1.0 / min(worst, 8.0)))

    def _accept(self, found: Point, step: float, worst: float) -> None:
        self.taken, self.point = step, found
        self.step = min(self.longest, step * min(2.0, max(0.5, 1.0 / max(worst, 1.0e-3))))
        self.step = max(self.step, LEAST_STEP)
