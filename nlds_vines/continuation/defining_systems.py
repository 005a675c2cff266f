"""What vanishes on a curve of special points, and where another kind is met.

The defining system of LP, PD and NS is minimally augmented: beside the orbit's equations one number
g, the last unknown of a singular matrix bordered by vectors, vanishes.  That of GR: the orbit has a
pass whose gap and the rate of the gap vanish, which a pass that misses and one that touches softly
tell alike.

Sources: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, chapters 4 and 5;
Kuznetsov, Elements of Applied Bifurcation Theory, chapters 9 and 10.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nlds_vines.continuation.section_map import Cycle, bordered
from nlds_vines.continuation.switching import null_vector

CONDITIONS = {
    "LP": {"R1": "one", "LP-PD": "PD", "CP": "cusp"},
    "PD": {"R2": "minus one", "LP-PD": "LP"},
    "NS": {"R1": "0", "R2": "180", "R3": "120", "R4": "90"},
    "GR": {"GR-LP": "LP", "GR-PD": "PD", "GR-NS": "NS"},
}
"""The names of points where two kinds meet, by kind of the curve, and what vanishes there.

R1 to R4: the strong resonances 1:1 to 1:4; CP: cusp; LP-PD: fold-flip; GR-LP, GR-PD, GR-NS: where a
curve of folds, doublings or tori ends on one of grazing, or begins."""

COSINES = {"0": 1.0, "180": -1.0, "120": -0.5, "90": 0.0}

Function = Callable[[Cycle], float]


def singular_matrix(kind: str, cycle: Cycle) -> np.ndarray:
    """Return the matrix that is singular at an LP, PD or NS."""
    if kind == "NS":
        return bialternate(cycle.matrix)
    found = cycle.matrix.copy()
    for i in range(len(found)):
        found[i, i] += -1.0 if kind == "LP" else 1.0
    return found


def bialternate(matrix: np.ndarray) -> np.ndarray:
    """Return M.M - I, M's bialternate product with itself less one; its eigenvalues mu_i mu_j - 1.

    Rows and columns are the pairs i > j; M.M has the minors m_ik m_jl - m_il m_jk.
    """
    pairs = [(i, j) for i in range(len(matrix)) for j in range(i)]
    found = np.empty((len(pairs), len(pairs)))
    for a, (i, j) in enumerate(pairs):
        for b, (k, m) in enumerate(pairs):
            found[a, b] = matrix[i, k] * matrix[j, m] - matrix[i, m] * matrix[j, k]
        found[a, a] -= 1.0
    return found


def augmented(kind: str, cycle: Cycle) -> Function:
    """Return the number g that vanishes on a curve, bordered for the orbits near one of it."""
    matrix = singular_matrix(kind, cycle)
    right, left = null_vector(matrix), null_vector(matrix.T.copy())

    def function(other: Cycle) -> float:
        rows = np.append(right, 0.0)[np.newaxis]
        wanted = np.zeros(len(right) + 1)
        wanted[-1] = 1.0
        found, _ = bordered(singular_matrix(kind, other), left[np.newaxis], rows, wanted)
        return math.nan if found is None else float(found[-1])

    return function


def grazing(without: tuple[int, int], wall: int, softness: float) -> Function:
    """Return the gap of the pass that grazes: positive where it misses, negative where it touches.

    Arguments: the impacts `without` it; the number of its wall; `softness` [s^2/m], by which the
    square of an approach speed is the depth of a free course.  NaN where other impacts come or go.
    """
    touching = tuple(count + (i == wall) for i, count in enumerate(without))

    def function(cycle: Cycle) -> float:
        if cycle.counts == without:
            return cycle.clearance
        if cycle.counts == touching:
            return -softness * cycle.slowest * cycle.slowest
        return math.nan

    return function


def other_condition(kind: str, condition: str, cycle: Cycle) -> float:
    """Return the function of an orbit that vanishes where a curve of a kind meets a condition."""
    mu = cycle.multipliers.tolist()
    if condition in COSINES:  # of the pair on the circle
        pairs = [(abs(mu[i] * mu[j] - 1.0), i, j) for i in range(len(mu)) for j in range(i)]
        _, i, j = min(pairs)
        return 0.5 * (mu[i] + mu[j]).real - COSINES[condition]
    if condition in ("one", "minus one"):  # without the multiplier that the curve is about
        target = 1.0 if condition == "one" else -1.0
        rest = sorted(mu, key=lambda m: abs(m - target))[1:]
        return _product([m - target for m in rest])
    if condition == "NS":
        return _product([mu[i] * mu[j] - 1.0 for i in range(len(mu)) for j in range(i)])
    return _product([m - (1.0 if condition == "LP" else -1.0) for m in mu])


def _product(factors: list[complex]) -> float:
    product = 1.0 + 0.0j
    for factor in factors:
        product *= factor
    return product.real
