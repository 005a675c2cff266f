"""The Hertz arc at collocation nodes: constants of nature, computed once per process.

The arc u(phi), S(phi) of `impact` solves u' = S, S' = -(5/2) u^4 from u = 0, S = 1, so
that S^2 + u^5 = 1 and phi = integral of du / sqrt(1 - u^5). Its power series, in u near the touch
and in S near the deepest point, are inverted by Newton's method. All is strict arithmetic in one
order, so that every machine finds the same bits (`elementary`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..numerics.elementary import fifth_root
from ..numerics.fours import FOUR
from ..numerics.quadrature import gauss_points, integration_matrix, times
from . import impact
from .impact_series import ONE, ORDER, TERMS, Series, impact_series

HALF = 1.2537306248172073  # B(1/5, 1/2) / 5: phase from touch to the deepest point
EQUAL = 0.9175012193496621  # phase at which u^5 = S^2 = 1/2
STRETCH = 0.57  # of the map x = d sinh(a xi): a little inside the singularity at 0.727
STEEP = 1.3280717613951345  # a = arsinh(1 / STRETCH)
FINEST = 1e-15  # what sweeps may leave where the nodes are given: round-off

CHOICES = {
    8: (6e-6, 6e-8),
    12: (6e-8, 4e-12),
    16: (1e-9, 1e-14),
    20: (1e-12, 1e-14),
    24: (1e-14, 1e-14),
}
"""Numbers of nodes n, and C_n: errors of an impact are at most C_n e^(3/2) (`impact`).

To its release, and to its deepest point on the half arc.  What impacts of all kinds were found to
err by at most (tests/kernels/test_impact_error.py)."""

FEW, COARSE = 8, 1e-8
"""Nodes whose errors add up over many impacts, as they have a sign; for coarse tolerances alone."""

INSIDE = {12: 1e-6, 16: 5e-9, 20: 3e-11, 24: 5e-13}
"""Numbers of nodes, and errors of what is interpolated inside an impact, energies, variations.

In units of its depth and speed. The free arc's own S between the nodes is the worst of it."""

WITHIN = {8: 6e-4, 12: 1e-5, 16: 1e-7, 20: 1.5e-9, 24: 1e-11}
"""Numbers of nodes, and errors of a state inside an impact by e, in units of depth and speed.

Twice what impacts of all kinds were found to err by at most (tests/kernels/plain_inside.py)."""

FARTHEST = 1.1  # time up to which the free arc's polynomials hold, in units of that to the deepest
NOWHERE = 7.0  # a place that is none
_FINE = 32  # nodes whose integrals are true to round-off
_TERMS = 60  # of the power series, whose terms fall by more than a half each
_NEWTON = 8  # steps that invert them


def hertz_arc(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (u, S) of the free Hertz impact at phases `phi`, 0 at touch, 2 HALF at release.

    Either of u^5 and S^2 = 1 - u^5 comes from the series that is well conditioned there, so that
    both are good to round-off all along.
    """
    left = np.minimum(phi, 2 * HALF - phi)  # 0 at touch or release
    low = left < EQUAL
    u, S = np.empty(len(phi)), np.empty(len(phi))
    u[low] = _inverted(left[low], 0.5, 5)  # phi = integral of (1 - u^5)^(-1/2) du
    S[~low] = _inverted(2.5 * (HALF - left[~low]), 0.8, 2)  # 2/5 integral of (1 - S^2)^(-4/5) dS
    S[low] = np.sqrt(1 - u[low] * u[low] * u[low] * u[low] * u[low])
    u[~low] = [fifth_root(1 - s * s) for s in S[~low].tolist()]
    return u, np.where(phi > HALF, -S, S)


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
    """Return (sinh, cosh) of numbers of at most 1.4 by their Taylor series."""
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
    """Return n nodes of the WHOLE arc or its HALF.

    The map keeps the nodes of the whole away from the singularities beside its middle; the half,
    which ends between them, needs none.
    """
    xi = gauss_points(n)
    if part == impact.WHOLE:
        sinh, cosh = _sinh_cosh(STEEP * xi)
        phi, density = HALF * (1 + STRETCH * sinh), HALF * STRETCH * STEEP * cosh
    else:
        phi, density = HALF * (1 + xi) / 2, np.full(n, HALF / 2)
    (weight,) = integration_matrix(xi, np.array([1.0])) * density
    return _Grid(*hertz_arc(phi), integration_matrix(xi, xi) * density, weight)


def _blocks(choices: tuple[int, ...], part: int) -> list[np.ndarray]:
    """Return the constants of an arc with these numbers of nodes (`impact`), one by one."""
    grids = [_grid(n, part) for n in (*choices, _FINE)]
    ends = np.cumsum([len(grid.u) for grid in grids])

    def integrate(values: np.ndarray) -> np.ndarray:
        pieces = np.split(values, ends[:-1])
        return np.concatenate([times(g.matrix, p) for g, p in zip(grids, pieces, strict=True)])

    u, S = (np.concatenate([getattr(grid, name) for grid in grids]) for name in ("u", "S"))
    beta, tau, by_beta, by_tau = impact_series(u, S, integrate)
    ones = Series({ONE: np.ones_like(u)}, ORDER)
    by_energy = ((ones + beta).power(9) * by_beta).times(10.0)
    cube = integrate(u * u * u)
    double = integrate(u * cube)
    found = []
    for grid, end in zip(grids[:-1], ends, strict=False):
        here = slice(end - len(grid.u), end)
        rows = [grid.u, grid.S, grid.weight, cube[here], double[here]]
        rows += [beta.at(term)[here] for term in TERMS[: impact.GUESSED]]
        rows += [tau.at(term)[here] for term in TERMS[: impact.GUESSED]]
        beyond = np.zeros((3, len(TERMS)))
        for row, series in enumerate((by_beta, by_tau, by_energy)):
            for column, term in enumerate(TERMS):
                values = np.split(series.at(term), ends[:-1])
                true = times(grids[-1].weight, values[-1])
                beyond[row, column] = true - times(grid.weight, series.at(term)[here])
        found.append(_constants(rows, grid.matrix, beyond))
    return found


def _constants(rows: list[np.ndarray], matrix: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Return rows, matrix and what is missed, one after the other, in whole fours of nodes."""
    n = len(matrix)
    wide = np.zeros((len(rows) + n, _in_fours(n)))
    wide[: len(rows), :n] = rows
    wide[len(rows) :, :n] = matrix.T
    return np.concatenate([wide.ravel(), beyond.ravel()])


def _in_fours(n: int) -> int:
    """Return the least multiple of four that is n or more."""
    return -(-n // FOUR) * FOUR


def _inside(n: int) -> np.ndarray:
    """Return the constants of `inside` for n nodes of the half arc, row by row.

    Places of touch, nodes and deepest point, the weights of the barycentric formula there, and
    these weights from the first node on. Behind them, places of no weight.
    """
    x = np.array([-1.0, *gauss_points(n), 1.0])
    weights = [1 / math.prod((2 * (one - x[x != one])).tolist()) for one in x]
    rows = np.zeros((3, _in_fours(n + 2)))
    rows[0] = NOWHERE
    rows[:2, : n + 2] = x, weights / np.max(np.abs(weights))
    rows[2, :-1] = rows[1, 1:]
    return rows.ravel()


def arc_in_time(count: int) -> tuple[list[float], list[float]]:
    """Return the first coefficients of u / sqrt(2 tau) and of S as power series in tau^(5/2).

    tau is the time of the free arc, dtau = u dphi, in which d(u^2 / 2)/dtau = S and
    dS/dtau = -(5/2) u^3.
    """
    S = [1.0]
    square: list[float] = []  # u^2 / (2 tau)
    root: list[float] = []  # its square root
    for k in range(count):
        square.append(S[k] / (1 + 2.5 * k))
        mixed = sum(root[i] * root[k - i] for i in range(1, k))
        root.append((square[k] - mixed) / 2 if k else 1.0)
        cube = sum(root[i] * square[k - i] for i in range(k + 1))
        S.append(-math.sqrt(8) * cube / (k + 1))
    return root, S[:count]


def economized(c: list[float], count: int, end: float) -> list[float]:
    """Return `count` coefficients that are as good on [0, end] as the many of a polynomial.

    Its highest power is taken away with the Chebyshev polynomial of that degree, time and again.
    """
    powers = [1.0]
    for _ in c[1:]:
        powers.append(powers[-1] * end)
    c = [one * power for one, power in zip(c, powers, strict=True)]
    for degree in range(len(c) - 1, count - 1, -1):
        before, now = [1.0], [-1.0, 2.0]
        for _ in range(degree - 1):
            doubled = [4 * a - 2 * b for a, b in zip([0.0, *now], [*now, 0.0], strict=True)]
            after = [a - b for a, b in zip(doubled, [*before, 0.0, 0.0], strict=True)]
            before, now = now, after
        share = c[-1] / now[-1]
        c = [a - share * b for a, b in zip(c[:-1], now, strict=False)]
    return [one / power for one, power in zip(c, powers, strict=False)]


def _shape() -> np.ndarray:
    """Return the constants of `state_inside.shape_at`: even and odd powers of u's and of S's."""
    time = FARTHEST * impact.LENGTH / 2
    end = time * time * math.sqrt(time)
    u, S = (economized(c, 2 * impact.DEGREES, end) for c in arc_in_time(_TERMS // 2))
    return np.array([u[0::2], u[1::2], S[0::2], S[1::2]]).T.ravel()


@lru_cache(maxsize=8)
def _table(choices: tuple[tuple[int, tuple[float, float]], ...]) -> np.ndarray:
    """Return the table of an arc (`impact`) with these choices of nodes and errors."""
    numbers = tuple(n for n, _ in choices)
    whole, half = (_blocks(numbers, part) for part in (impact.WHOLE, impact.HALF))
    head, place, blocks = np.zeros(impact.CONSTANTS), impact.CONSTANTS, []
    for level, (n, errors) in enumerate(choices):
        row = impact.LEVELS + impact.LEVEL * level
        ends = place, place + len(whole[level])
        head[row : row + impact.LEVEL] = n, *ends, *errors, WITHIN.get(n, math.nan)
        blocks += [whole[level], half[level], _inside(n)]
        place += sum(map(len, blocks[-3:]))
    head[impact.SHAPE : impact.CONSTANTS] = _shape()
    return np.concatenate([head, *blocks])


def choices_for(tolerance: float) -> dict[int, tuple[float, float]]:
    """Return the `CHOICES` from which impacts of a tolerance take their nodes."""
    return {n: e for n, e in CHOICES.items() if n > FEW or tolerance >= COARSE}


def make_arc(tolerance: float = 1e-9, nodes: int | None = None) -> impact.Arc:
    """Return the `Arc` with scratch rows of its own: one for each thread that uses it.

    Arguments: the relative `tolerance` of an impact, which chooses its nodes; or one number of
    `nodes`, 2 to 60, for all impacts, whose errors are what they are.
    """
    if nodes is None:
        choices = choices_for(tolerance)
        levels, settled = len(choices), impact.SETTLED * tolerance
        fine = min((n for n, error in INSIDE.items() if error <= tolerance), default=max(INSIDE))
    elif 2 <= nodes <= impact.ROW - 4:
        fine = max(nodes, 20)
        choices, levels, tolerance = {nodes: (0.0, 0.0), fine: (0.0, 0.0)}, 1, math.inf
        settled = FINEST
    else:
        raise ValueError(f"nodes = {nodes}: an arc takes 2 to {impact.ROW - 4} collocation nodes")
    table = _table(tuple(choices.items())).copy()
    return impact.Arc(tolerance, settled, levels, list(choices).index(fine), table)
