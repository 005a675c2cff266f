"""The Hertz arc at collocation nodes: constants of nature, computed once per process.

The arc u(phi), S(phi) of `kernels.impact` solves u' = S, S' = -(5/2) u^4 from u = 0, S = 1, so
that S^2 + u^5 = 1 and phi = integral of du / sqrt(1 - u^5). Its power series, in u near the touch
and in S near the deepest point, are inverted by Newton's method. All is strict arithmetic in one
order, so that every machine finds the same bits (`kernels.elementary`).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nlds_vines.kernels import impact
from nlds_vines.kernels.elementary import fifth_root
from nlds_vines.orbits.quadrature import gauss_points, integration_matrix, times
from nlds_vines.orbits.settings import NODES

HALF = 1.2537306248172073  # B(1/5, 1/2) / 5: phase from touch to the deepest point
LOST = 0.40878822004509785  # B(2/5, 3/2) / 5: integral of S^2 u / 2 from touch to release
EQUAL = 0.9175012193496621  # phase at which u^5 = S^2 = 1/2
STRETCH = 0.57  # of the map x = d sinh(a xi): a little inside the singularity at 0.727
STEEP = 1.3280717613951345  # a = arsinh(1 / STRETCH)
FINEST = 1e-16  # change of a sweep that is round-off

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


@lru_cache(maxsize=8)
def _tables(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices and the rows of `Arc` for n nodes, of the whole arc and of its half.

    The map keeps the nodes of the whole away from the singularities beside its middle; the half,
    which ends between them, needs none.
    """
    xi = gauss_points(n)
    sinh, cosh = _sinh_cosh(STEEP * xi)
    whole, density = HALF * (1 + STRETCH * sinh), HALF * STRETCH * STEEP * cosh
    parts = _part(xi, whole, density), _part(xi, HALF * (1 + xi) / 2, np.full(n, HALF / 2))
    integrations, tables = zip(*parts, strict=True)
    return np.concatenate(integrations), np.concatenate(tables)


def _part(xi: np.ndarray, phi: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix and the rows for nodes at the phases `phi`, dphi = `density` dxi."""
    n = len(xi)
    u, S = hertz_arc(phi)
    integration = integration_matrix(xi, xi) * density
    (weight,) = integration_matrix(xi, np.array([1.0])) * density
    time = times(integration, u)
    rows = {
        impact.U: u,
        impact.S: S,
        impact.BY_DRAG: times(integration, 0.5 * S * S * u),
        impact.BY_DRIFT: times(integration, 0.5 * S * u * time),
        impact.TIME: time,
        impact.WEIGHT: weight,
    }
    table = np.zeros(impact.TABLE)
    for row, values in rows.items():
        table[row : row + n] = values
    return np.ascontiguousarray(integration.T).ravel(), table


def make_arc(nodes: int = NODES) -> impact.Arc:
    """Return the `Arc` with scratch rows of its own: one for each thread that uses it.

    The error of an impact falls by a factor of five or more with each node added. At most 64.
    """
    if not 2 <= nodes <= impact.ROW:
        raise ValueError(f"nodes = {nodes}: an arc takes 2 to {impact.ROW} collocation nodes")
    integration, table = _tables(nodes)
    u, S, weight = (table[row : row + nodes] for row in (impact.U, impact.S, impact.WEIGHT))
    tolerance = max(0.3 / 10**nodes, FINEST)
    loss_missed = LOST - float(times(weight, 0.5 * S * S * u))
    return impact.Arc(
        nodes, float(times(weight, u)), tolerance, loss_missed, integration, table.copy()
    )
