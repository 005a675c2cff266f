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
from ..numerics.quadrature import gauss_points, integration_matrix, matrix_times
from . import arc_table
from .impact_series import ALL_TERMS, HALF_ORDERS, ONE, Series, impact_series

HALF_ARC = 1.2537306248172073  # B(1/5, 1/2) / 5: phase from touch to the deepest point
EQUAL = 0.9175012193496621  # phase at which u^5 = S^2 = 1/2
MAP_STRETCH = 0.57  # of the map x = d sinh(a xi): a little inside the singularity at 0.727
MAP_RATE = 1.3280717613951345  # a = arsinh(1 / MAP_STRETCH)
FINEST_ERROR = 1e-15  # what sweeps may leave where the nodes are given: round-off

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

FEW_NODES, COARSE = 8, 1e-8
"""Nodes whose errors add up over many impacts, as they have a sign; for coarse tolerances alone."""

_FINE = 32  # nodes whose integrals are true to round-off
_TERMS = 60  # of the power series, whose terms fall by more than a half each
_NEWTON = 8  # steps that invert them


def hertz_arc(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (u, S) of the free Hertz impact at phases `phi`, 0 at touch, 2 HALF_ARC at release.

    Either of u^5 and S^2 = 1 - u^5 comes from the series that is well conditioned there, so that
    both are good to round-off all along.
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
    if part == arc_table.WHOLE:
        sinh, cosh = _sinh_cosh(MAP_RATE * xi)
        phi, density = HALF_ARC * (1 + MAP_STRETCH * sinh), HALF_ARC * MAP_STRETCH * MAP_RATE * cosh
    else:
        phi, density = HALF_ARC * (1 + xi) / 2, np.full(n, HALF_ARC / 2)
    (weight,) = integration_matrix(xi, np.array([1.0])) * density
    return _Grid(*hertz_arc(phi), integration_matrix(xi, xi) * density, weight)


def _blocks(choices: tuple[int, ...], part: int) -> list[np.ndarray]:
    """Return the constants of an arc with these numbers of nodes (`impact`), one by one."""
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
    found = []
    for grid, end in zip(grids[:-1], ends, strict=False):
        here = slice(end - len(grid.u), end)
        rows = [grid.u, grid.S, grid.weight, cube[here], double[here]]
        rows += [beta.at(term)[here] for term in ALL_TERMS[: arc_table.GUESSED]]
        rows += [tau.at(term)[here] for term in ALL_TERMS[: arc_table.GUESSED]]
        beyond = np.zeros((3, len(ALL_TERMS)))
        for row, series in enumerate((by_beta, by_tau, by_energy)):
            for column, term in enumerate(ALL_TERMS):
                values = np.split(series.at(term), ends[:-1])
                true = matrix_times(grids[-1].weight, values[-1])
                beyond[row, column] = true - matrix_times(grid.weight, series.at(term)[here])
        found.append(_constants(rows, grid.matrix, beyond))
    return found


def _error_of_sums(n: int) -> float:
    """Return the larger error of n nodes for squares of force and of speed, relative."""
    sums = []
    for grid in (_grid(n, arc_table.WHOLE), _grid(_FINE, arc_table.WHOLE)):
        cube = grid.u * grid.u * grid.u
        sums.append([matrix_times(grid.weight, f * grid.u) for f in (cube * cube, grid.S * grid.S)])
    return max(abs(float(mine / true) - 1) for mine, true in zip(*sums, strict=True))


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


@lru_cache(maxsize=8)
def _table(choices: tuple[tuple[int, tuple[float, float]], ...]) -> np.ndarray:
    """Return the table of an arc (`impact`) with these choices of nodes and errors."""
    numbers = tuple(n for n, _ in choices)
    whole, half = (_blocks(numbers, part) for part in (arc_table.WHOLE, arc_table.HALF))
    head, place, blocks = np.zeros(arc_table.CONSTANTS), arc_table.CONSTANTS, []
    for level, (n, errors) in enumerate(choices):
        row = arc_table.LEVELS + arc_table.LEVEL * level
        ends = place, place + len(whole[level])
        head[row : row + arc_table.LEVEL] = n, *ends, *errors, _error_of_sums(n)
        blocks += [whole[level], half[level]]
        place = ends[1] + len(half[level])
    return np.concatenate([head, *blocks])


def choices_for(tolerance: float) -> dict[int, tuple[float, float]]:
    """Return the `CHOICES` from which impacts of a tolerance take their nodes."""
    return {n: e for n, e in CHOICES.items() if n > FEW_NODES or tolerance >= COARSE}


def make_arc(tolerance: float = 1e-9, nodes: int | None = None) -> arc_table.Arc:
    """Return the `Arc` with scratch rows of its own: one for each thread that uses it.

    Arguments: the relative `tolerance` of an impact, which chooses its nodes; or one number of
    `nodes`, 2 to 60, for all impacts, whose errors are what they are.
    """
    if nodes is None:
        choices = choices_for(tolerance)
        levels, settled = len(choices), arc_table.SETTLED * tolerance
    elif 2 <= nodes <= arc_table.NODE_ROW - 4:
        choices, levels, tolerance = {nodes: (0.0, 0.0)}, 1, math.inf
        settled = FINEST_ERROR
    else:
        raise ValueError(
            f"nodes = {nodes}: an arc takes 2 to {arc_table.NODE_ROW - 4} collocation nodes"
        )
    table = _table(tuple(choices.items())).copy()
    return arc_table.Arc(tolerance, settled, levels, table)
