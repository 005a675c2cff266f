"""The Hertz arc at collocation nodes, computed once per process by plain Python.

The arc u(phi), S(phi) of `impact` solves u' = S, S' = -(5/2) u^4 from u = 0, S = 1, so
that S^2 + u^5 = 1 and phi = integral of du / sqrt(1 - u^5). Its power series, in u near the touch
and in S near the deepest point, are inverted by Newton's method. Sums are taken in one order by
strict arithmetic, so that every machine computes the same bits (`elementary`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from ..numerics.elementary import cos_sin_of_turn, fifth_root
from ..numerics.fours import FOUR

# ---- Gauss-Legendre points and the integration of values there -----------------------------------


NEWTON = 8  # steps for the points: the guess has three digits, and each step doubles them


def legendre(x: np.ndarray, n: int) -> list[np.ndarray]:
    values = [np.ones_like(x), x]
    for k in range(1, n):
        values.append(((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1))
    return values[: n + 1]


def gauss_points(n: int) -> np.ndarray:
    """Return the n zeros of P_n, ascending."""
    half = n // 2
    guess = [cos_sin_of_turn((i + 0.75) / (2 * n + 1))[0] for i in range(half)]
    x = np.array(guess, dtype=float)
    for _ in range(NEWTON):
        *_, below, value = legendre(x, n)
        x = x - value * (x * x - 1) / (n * (x * value - below))
    return np.concatenate([-x, np.zeros(n % 2), x[::-1]])


def gauss_weights(x: np.ndarray) -> np.ndarray:
    """Return the weights of the points `x`: 2 / sum of (2k + 1) P_k(x)^2, k < n.

    A sum of positive terms: the usual formula with P_n' magnifies the rounding of x by n.
    """
    total = np.zeros(len(x))
    for k, value in reversed(list(enumerate(legendre(x, len(x) - 1)))):
        total = total + (2 * k + 1) * value * value
    return 2 / total


def integration_matrix(x: np.ndarray, upto: np.ndarray) -> np.ndarray:
    """Return the matrix that integrates values at the Gauss points `x` from -1 to `upto`.

    Exact for polynomials of degree n - 1. By the quadrature itself the values f_j have the Legendre
    coefficients (2k + 1)/2 sum_j w_j P_k(x_j) f_j, and (2k + 1) P_k has the integral
    P_(k+1) - P_(k-1).
    """
    n = len(x)
    at_points, at_ends = legendre(x, n - 1), legendre(upto, n)
    total = np.zeros((len(upto), n))
    for k in range(n - 1, 0, -1):
        total = total + np.multiply.outer(at_ends[k + 1] - at_ends[k - 1], at_points[k])
    total = total + (upto + 1)[:, np.newaxis]
    return total * (gauss_weights(x) / 2)


def matrix_times(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the product of a matrix (..., n) and values (n,), the sums from the first on."""
    return np.cumsum(matrix * values, axis=-1)[..., -1]


# ---- A short impact as a power series in its five small numbers ----------------------------------
#
# With the amplitude b = b0 (1 + beta) and the time t = tick tau, an impact obeys
#
#     beta' = S u w a / (2 den)      tau' = u w^5 / den      w = 1 + beta    den = w^6 - a u^2
#     a = A - D w^5 S + R tau + Z w^4 u^2 + Q tau^2
#
# in the free arc u(phi), S(phi). a is the acceleration of r by all forces but the contact's, in
# units of kappa b0^6, written as a force A, a drag D, a drift R, a spring Z and a curvature Q
# (`impact.Approach`). In an impact whose duration is theta, in units of the other motion's time, A
# and D are O(theta^2), R is O(A theta), Z is O(theta^4) and Q is O(A theta^2). The series is
# truncated by the sum of TERM_WEIGHTS, which are orders in halves.
#
# The series holds for any integration rule. It is solved twice, with the integrals of a collocation
# of n nodes and with exact ones: the first is the initial guess of the sweeps, and the difference
# at the arc's end is the error of the collocation.


SMALL_NUMBERS = 5  # A, D, R, Z, Q
TERM_WEIGHTS = (2, 2, 3, 4, 5)
HALF_ORDERS = 8  # highest order of a term, in halves
ONE = (0,) * SMALL_NUMBERS

Term = tuple[int, ...]
"""The powers of A, D, R, Z and Q in a term."""
Integrate = Callable[[np.ndarray], np.ndarray]
"""Values at nodes -> their integrals from touch to each node."""


@cache
def weight_of_term(term: Term) -> int:
    return sum(power * weight for power, weight in zip(term, TERM_WEIGHTS, strict=True))


def terms_up_to(order: int) -> list[Term]:
    """Return the terms up to an order, in halves, sorted by order and by falling power of A."""
    ranges = (range(order // weight + 1) for weight in TERM_WEIGHTS)
    within = (term for term in product(*ranges) if weight_of_term(term) <= order)
    return sorted(within, key=lambda term: (weight_of_term(term), tuple(-power for power in term)))


ALL_TERMS = terms_up_to(HALF_ORDERS)


def factors_of(terms: list[Term]) -> tuple[list[int], list[int]]:
    """For each of `terms`, return the places of two terms whose product it is.

    The second factor is one of the five small numbers; the first is the quotient, which is 1, the
    first term, for a small number itself. Both factors of 1 are 1.
    """
    fewer, single = [0], [0]
    for term in terms[1:]:
        which = next(i for i, power in enumerate(term) if power)
        number = tuple(int(i == which) for i in range(SMALL_NUMBERS))
        rest = tuple(a - b for a, b in zip(term, number, strict=True))
        fewer.append(terms.index(rest))
        single.append(terms.index(number))
    return fewer, single


class Series:
    """A truncated power series whose coefficients are arrays of one shape."""

    def __init__(self, coefficients: dict[Term, np.ndarray], order: int) -> None:
        self.coefficients, self.order = coefficients, order

    def __add__(self, other: Series) -> Series:
        total = dict(self.coefficients)
        for term, values in other.coefficients.items():
            total[term] = total[term] + values if term in total else values
        return Series(total, self.order)

    def __sub__(self, other: Series) -> Series:
        return self + other.scaled(-1.0)

    def __mul__(self, other: Series) -> Series:
        """Return the product, its terms beyond the order left out."""
        products: dict[Term, np.ndarray] = {}
        for one, values in self.coefficients.items():
            most = self.order - weight_of_term(one)
            for another, others in other.coefficients.items():
                if weight_of_term(another) <= most:
                    term = tuple(a + b for a, b in zip(one, another, strict=True))
                    part = values * others
                    products[term] = products[term] + part if term in products else part
        return Series(products, self.order)

    def scaled(self, factor: np.ndarray | float) -> Series:
        return self.each(lambda values: values * factor)

    def each(self, change: Integrate) -> Series:
        changed = {term: change(values) for term, values in self.coefficients.items()}
        return Series(changed, self.order)

    def power(self, n: int) -> Series:
        result = self
        for _ in range(n - 1):
            result = result * self
        return result

    def inverse(self) -> Series:
        """Return 1 / (1 + x) = 1 - x + x^2 - ... of a series 1 + x."""
        one = Series({ONE: np.ones_like(self.coefficients[ONE])}, self.order)
        x = {term: -values for term, values in self.coefficients.items() if term != ONE}
        total = power = one
        for _ in range(self.order // min(TERM_WEIGHTS)):
            power = power * Series(x, self.order)
            total = total + power
        return total

    def at(self, term: Term) -> np.ndarray:
        """Return the coefficient of a term, which may be zero."""
        zero = np.zeros_like(next(iter(self.coefficients.values())))
        return self.coefficients.get(term, zero)


def impact_series(
    u: np.ndarray, S: np.ndarray, integrate: Integrate, order: int = HALF_ORDERS
) -> tuple[Series, Series, Series, Series]:
    """Return the series of beta, tau and of their derivatives by phi, at nodes of the arc u, S.

    Each pass of the fixed-point iteration adds a whole order.
    """
    beta = Series({}, 0)
    tau = Series({ONE: integrate(u)}, 0)
    by_phi = beta, tau
    ones = np.ones_like(u)
    for reached in range(2, order + 2, 2):
        now = min(reached, order)

        def number(i: int, now: int = now) -> Series:
            term = tuple(int(j == i) for j in range(SMALL_NUMBERS))
            return Series({term: ones} if TERM_WEIGHTS[i] <= now else {}, now)

        force, drag, drift, spring, curvature = (number(i) for i in range(SMALL_NUMBERS))
        tau = Series(tau.coefficients, now)
        w = Series({ONE: ones}, now) + beta
        w2 = w * w
        w4 = w2 * w2
        w5 = w4 * w
        a = force - drag * w5.scaled(S) + drift * tau
        a = a + spring * w4.scaled(u * u) + curvature * (tau * tau)
        inverse = (w4 * w2 - a.scaled(u * u)).inverse()
        by_phi = (w * a * inverse).scaled(0.5 * S * u), (w5 * inverse).scaled(u)
        beta, tau = (slope.each(integrate) for slope in by_phi)
    return beta, tau, *by_phi


# ---- The table of an arc, made by `make_arc`: constants of each choice of nodes, and scratch -----


NODE_ROW = 64  # numbers of a row with one for each node
LEVEL_ROW, MOST_LEVELS = 6, 8
# terms of the series in the first guess; of what the nodes miss: 36, in whole fours
GUESSED, MISSED = 17, len(ALL_TERMS)
FACTORS = np.array(factors_of(ALL_TERMS)).ravel()  # places of one for each term, then of the others


class ArcTable(NamedTuple):
    """Places in the table of an arc. From `variations` to `constants` is scratch of `inside`."""

    # at the nodes, NODE_ROW each: b, where z = b^4 u^2 and s = v(b) S; the time since touch [s];
    # x1 and v1 without the share of z and s, the common motion; the derivatives of the four by phi
    amplitudes: int = 0
    times: int = NODE_ROW
    common_x: int = 2 * NODE_ROW
    common_v: int = 3 * NODE_ROW
    slope_b: int = 4 * NODE_ROW
    slope_t: int = 5 * NODE_ROW
    slope_x: int = 6 * NODE_ROW
    slope_v: int = 7 * NODE_ROW
    recalled: int = 8 * NODE_ROW  # results of the last few impacts (`inside.Recalled`)
    levels: int = 15 * NODE_ROW  # a row `Level` for each choice of nodes, from few to many
    used: int = 15 * NODE_ROW + LEVEL_ROW * MOST_LEVELS  # level of the nodes whose values are there
    products: int = 15 * NODE_ROW + LEVEL_ROW * MOST_LEVELS + 8  # terms of the series
    variations: int = 16 * NODE_ROW + LEVEL_ROW * MOST_LEVELS + 8
    changes: int = 23 * NODE_ROW + LEVEL_ROW * MOST_LEVELS + 8  # of each term, by four variations
    constants: int = 50 * NODE_ROW + LEVEL_ROW * MOST_LEVELS + 8  # of the levels, see `NodeRows`


class Level(NamedTuple):
    """Places in the row of one choice of nodes."""

    nodes: int = 0  # n
    whole: int = 1  # places of the constants of the whole arc and of its half
    half: int = 2
    error: int = 3  # C_n of each
    half_error: int = 4
    summed: int = 5  # error of integrals over the free arc


class NodeRows(NamedTuple):
    """Rows of constants, m numbers each, m being n in whole fours.

    From `matrix` on stand n rows of the matrix that integrates from touch to each node, integrand
    by integrand, then 3 x MISSED coefficients of the nodes' errors in b, t and the energy.
    """

    u: int = 0  # sqrt(z / z_m)
    s: int = 1  # S = s / v
    weight: int = 2  # of an integral over the whole interval
    cube: int = 3  # integral of u^3
    double: int = 4  # integral of u times `cube`
    b: int = 5  # coefficients of the series of b / b0 - 1, GUESSED rows
    t: int = 5 + GUESSED  # the same of the time
    matrix: int = 5 + 2 * GUESSED


class SmallNumbers(NamedTuple):
    """Places of the five small numbers in ALL_TERMS."""

    force: int = 1
    drag: int = 2
    drift: int = 3
    spring: int = 7
    curvature: int = 10


ARC, LEVEL, NODES, TERM = ArcTable(), Level(), NodeRows(), SmallNumbers()

SETTLED = 0.03  # share of the tolerance that the sweeps may leave


class Arc(NamedTuple):
    """The Hertz arc at collocation nodes, made by `make_arc`.

    It is one array: each array of a tuple costs every call that hands it on.
    """

    tolerance: float  # relative error of an impact: of speed and time of release, and of its depth
    settled: float  # the part of it that the sweeps may leave
    levels: int  # choices of nodes
    table: np.ndarray  # `ArcTable`


# ---- the Hertz arc at the nodes ------------------------------------------------------------------


HALF_ARC = 1.2537306248172073  # B(1/5, 1/2) / 5: phase from touch to the deepest point
EQUAL = 0.9175012193496621  # phase at which u^5 = S^2 = 1/2
MAP_STRETCH = 0.57  # of the map x = d sinh(a xi): a little inside the singularity at 0.727
MAP_RATE = 1.3280717613951345  # a = arsinh(1 / MAP_STRETCH)
FINEST_ERROR = 1e-15  # that sweeps may leave with a prescribed number of nodes: round-off

CHOICES = {
    8: (6e-6, 6e-8),
    12: (6e-8, 4e-12),
    16: (1e-9, 1e-14),
    20: (1e-12, 1e-14),
    24: (1e-14, 1e-14),
}
"""Numbers of nodes n, and C_n: errors of an impact are at most C_n e^(3/2) (`impact`).

C_n at the release, and at the deepest point, the end of the half arc: the largest errors of impacts
of all kinds (tests/kernels/test_impact_error.py)."""

FEW_NODES, COARSE = 8, 1e-8
"""So few nodes are for tolerances from COARSE on: their errors have one sign and add up."""

_FINE = 32  # nodes whose integrals are true to round-off
_TERMS = 60  # of the power series, whose terms fall by more than a half each
_NEWTON = 8  # steps that invert them


def hertz_arc(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (u, S) of the free Hertz impact at phases `phi`, 0 at touch, 2 HALF_ARC at release.

    u comes from its own series where u^5 < 1/2, S from its own elsewhere, and the other one from
    S^2 + u^5 = 1, so that both are accurate to round-off.
    """
    left = np.minimum(phi, 2 * HALF_ARC - phi)  # 0 at touch or release
    low = left < EQUAL
    u, S = np.empty(len(phi)), np.empty(len(phi))
    u[low] = _inverted(left[low], 0.5, 5)  # phi = integral of (1 - u^5)^(-1/2) du
    S[~low] = _inverted(
        2.5 * (HALF_ARC - left[~low]), 0.8, 2
    )  # 2/5 integral of (1 - S^2)^(-4/5) dS
    S[low] = np.sqrt(1 - u[low] * u[low] * u[low] * u[low] * u[low])
    u[~low] = [fifth_root(1 - s * s) for s in S[~low].tolist()]
    return u, np.where(phi > HALF_ARC, -S, S)


def _inverted(values: np.ndarray, power: float, m: int) -> np.ndarray:
    """Return t with integral of (1 - t^m)^(-power) dt from 0 = `values`, for t^m <= 1/2.

    The integrand is the sum of c_k t^(m k), c_k = power (power + 1) ... (power + k - 1) / k!.
    """
    c = [1.0]
    for k in range(_TERMS):
        c.append(c[k] * (power + k) / (k + 1))
    t = values.copy()
    for _ in range(_NEWTON):
        z = t * t if m == 2 else t * t * t * t * t
        slope, mean = np.zeros(len(t)), np.zeros(len(t))
        for k in range(_TERMS, -1, -1):
            slope, mean = slope * z + c[k], mean * z + c[k] / (m * k + 1)
        t = t - (t * mean - values) / slope
    return t


def _sinh_cosh(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (sinh, cosh) of numbers up to 1.4 by their Taylor series."""
    z = x * x
    odd = even = np.ones(len(x))
    for k in range(28, 0, -2):
        odd, even = 1 + odd * z / (k * (k + 1)), 1 + even * z / (k * (k - 1))
    return x * odd, even


@dataclass(frozen=True)
class _Grid:
    """Collocation nodes on the whole arc or its half, with their integrals."""

    u: np.ndarray
    S: np.ndarray
    matrix: np.ndarray  # (n, n) from touch to each node
    weight: np.ndarray  # (n,) to the end


def _grid(n: int, part: int) -> _Grid:
    """Return n nodes of the whole arc or of its half (LEVEL.whole, LEVEL.half).

    The complex singularities lie beside the middle of the whole arc, from which the map moves the
    nodes away; the half arc ends between the singularities and needs no map.
    """
    xi = gauss_points(n)
    if part == LEVEL.whole:
        sinh, cosh = _sinh_cosh(MAP_RATE * xi)
        phi, density = HALF_ARC * (1 + MAP_STRETCH * sinh), HALF_ARC * MAP_STRETCH * MAP_RATE * cosh
    else:
        phi, density = HALF_ARC * (1 + xi) / 2, np.full(n, HALF_ARC / 2)
    (weight,) = integration_matrix(xi, np.array([1.0])) * density
    return _Grid(*hertz_arc(phi), integration_matrix(xi, xi) * density, weight)


def _blocks(choices: tuple[int, ...], part: int) -> list[np.ndarray]:
    """Return the constants of the arc (`NodeRows`) for each number of nodes."""
    grids = [_grid(n, part) for n in (*choices, _FINE)]
    ends = np.cumsum([len(grid.u) for grid in grids])

    def integrate(values: np.ndarray) -> np.ndarray:
        pieces = np.split(values, ends[:-1])
        return np.concatenate(
            [matrix_times(g.matrix, p) for g, p in zip(grids, pieces, strict=True)]
        )

    u, S = (np.concatenate([getattr(grid, name) for grid in grids]) for name in ("u", "S"))
    beta, tau, by_beta, by_tau = impact_series(u, S, integrate)
    ones = Series({ONE: np.ones_like(u)}, HALF_ORDERS)
    by_energy = ((ones + beta).power(9) * by_beta).scaled(10.0)
    cube = integrate(u * u * u)
    double = integrate(u * cube)
    blocks = []
    for grid, end in zip(grids[:-1], ends, strict=False):
        here = slice(end - len(grid.u), end)
        rows = [grid.u, grid.S, grid.weight, cube[here], double[here]]
        rows += [beta.at(term)[here] for term in ALL_TERMS[:GUESSED]]
        rows += [tau.at(term)[here] for term in ALL_TERMS[:GUESSED]]
        beyond = np.zeros((3, len(ALL_TERMS)))
        for row, series in enumerate((by_beta, by_tau, by_energy)):
            for column, term in enumerate(ALL_TERMS):
                values = np.split(series.at(term), ends[:-1])
                true = matrix_times(grids[-1].weight, values[-1])
                beyond[row, column] = true - matrix_times(grid.weight, series.at(term)[here])
        n = len(grid.u)
        wide = np.zeros((len(rows) + n, -(-n // FOUR) * FOUR))  # in whole fours of nodes
        wide[: len(rows), :n], wide[len(rows) :, :n] = rows, grid.matrix.T
        blocks.append(np.concatenate([wide.ravel(), beyond.ravel()]))
    return blocks


def _error_of_sums(n: int) -> float:
    """Return the largest relative error of n nodes in the integrals of force and speed squared."""
    sums = []
    for grid in (_grid(n, LEVEL.whole), _grid(_FINE, LEVEL.whole)):
        cube = grid.u * grid.u * grid.u
        sums.append([matrix_times(grid.weight, f * grid.u) for f in (cube * cube, grid.S * grid.S)])
    return max(abs(float(mine / true) - 1) for mine, true in zip(*sums, strict=True))


@lru_cache(maxsize=8)
def _table(choices: tuple[tuple[int, tuple[float, float]], ...]) -> np.ndarray:
    """Return the table of an arc with these choices of nodes and their C_n."""
    numbers = tuple(n for n, _ in choices)
    whole, half = (_blocks(numbers, part) for part in (LEVEL.whole, LEVEL.half))
    head, place, blocks = np.zeros(ARC.constants), ARC.constants, []
    for level, (n, errors) in enumerate(choices):
        row = ARC.levels + LEVEL_ROW * level
        ends = place, place + len(whole[level])
        head[row : row + LEVEL_ROW] = n, *ends, *errors, _error_of_sums(n)
        blocks += [whole[level], half[level]]
        place = ends[1] + len(half[level])
    return np.concatenate([head, *blocks])


def choices_for(tolerance: float) -> dict[int, tuple[float, float]]:
    return {n: e for n, e in CHOICES.items() if n > FEW_NODES or tolerance >= COARSE}


def make_arc(tolerance: float = 1e-9, nodes: int | None = None) -> Arc:
    """Return an `Arc` with its own scratch: each thread needs one.

    The relative `tolerance` of an impact determines its nodes. A number of `nodes`, 2 to 60, is
    used for all impacts, without a check of their errors.
    """
    if nodes is None:
        choices = choices_for(tolerance)
        levels, settled = len(choices), SETTLED * tolerance
    elif 2 <= nodes <= NODE_ROW - 4:
        choices, levels, tolerance = {nodes: (0.0, 0.0)}, 1, math.inf
        settled = FINEST_ERROR
    else:
        raise ValueError(f"nodes = {nodes}: an arc takes 2 to {NODE_ROW - 4} collocation nodes")
    table = _table(tuple(choices.items())).copy()
    return Arc(tolerance, settled, levels, table)
