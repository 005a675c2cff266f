"""From a special point of one branch onto another branch that passes through it."""

from __future__ import annotations

import math

import numpy as np

from nlds_vines.continuation.arclength import Point, close, length, point_of
from nlds_vines.continuation.branch_arm import half_of
from nlds_vines.continuation.section_map import SectionMap, bordered, closing

FIRST_ASIDE, LEAST_ASIDE = 1.0e-2, 1.0e-6
"""How far aside, relative to the orbit, the other branch is looked for; and the nearest try."""

BENT = 0.1
"""The known branch leaves its tangent by the square of the way s along it.  So at a distance `far`
beside its tangent it is met at s of the order sqrt(far) alone.  A point nearer than BENT sqrt(far)
lies on the other branch, at whatever angle that crosses the known one.  A branch of twice the
period leaves along the direction itself: it is met within far / 2, and against the direction lie
the same orbits one period later, so that only one direction is tried."""


Aside = tuple[Point, float]
"""A point of another branch, and how far beside the known one it lies."""


def null_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the vector (n,) of length one that a nearly singular matrix (n, n) hardly changes.

    By inverse iteration, bordered so that nothing is divided by zero.
    """
    size = len(matrix)
    found, column = np.ones(size), np.ones((1, size))
    for _ in range(4):
        right = np.zeros(size + 1)
        right[-1] = 1.0
        row = np.append(found, 0.0)[np.newaxis]
        solution, _ = bordered(matrix, column, row, right)
        if solution is None:  # the border lies in the range: take another
            column = column * np.arange(1.0, size + 1.0)
            continue
        found = solution[:-1] / math.sqrt(float((solution[:-1] * solution[:-1]).sum()))
    return found


def doubled(section_map: SectionMap, point: Point) -> Aside | None:
    """Return the first orbit of twice the period beside a period doubling; None if none is found.

    The orbit there, run twice, has a multiplier one, whose direction is that of the multiplier -1
    of the orbit run once: the other branch leaves along it.
    """
    cycle = point.cycle
    plus = cycle.matrix.copy()
    for i in range(len(plus)):
        plus[i, i] += 1.0
    aside = np.append(null_vector(plus), np.zeros(len(cycle.values)))
    return _beside(section_map, point, aside, 2 * cycle.n)


def other_branch(section_map: SectionMap, point: Point) -> Aside | None:
    """Return a point of the other branch that passes through a branch point; None if none is found.

    Both tangents are null vectors of (M - I, slopes); the other branch is looked for in the one of
    these that lies across the tangent of the known.
    """
    weights = point.weights
    row = weights * weights * point.tangent
    size = len(row)
    matrix = np.empty((size, size))
    matrix[:-1, :-1], matrix[:-1, -1], matrix[-1] = closing(point.cycle), point.cycle.slopes[0], row
    aside = null_vector(matrix)
    return _beside(section_map, point, aside, point.cycle.n)


def _beside(section_map: SectionMap, point: Point, aside: np.ndarray, n: int) -> Aside | None:
    """Return a point of another branch beside a point, in the direction `aside`, and how far."""
    weights = point.weights
    aside = aside / length(weights, aside)
    far, doubles = FIRST_ASIDE, n > point.cycle.n
    while far >= LEAST_ASIDE:
        nearest = 0.5 * far if doubles else BENT * math.sqrt(far)
        for direction in (aside,) if doubles else (aside, -aside):
            place = point.cycle.place + far * direction
            row = weights * weights * direction
            cycle, _ = close(section_map, place, n, row, weights)
            if cycle is None or length(weights, cycle.place - place) > nearest:
                continue
            found = point_of(section_map, cycle, direction, 1.0 / weights[-1:])
            if found is not None and not (doubles and _is_shorter(found, far)):
                return found, far
        far *= 0.25
    return None


def _is_shorter(point: Point, far: float) -> bool:
    """Tell whether an orbit of even n is one of n / 2, run twice."""
    return length(point.weights[:-1], half_of(point.cycle)) < 0.1 * far
