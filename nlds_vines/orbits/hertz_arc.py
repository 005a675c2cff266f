"""The Hertz arc at collocation nodes: constants of nature, computed once per process.

The arc u(phi), S(phi) of `kernels.impact` solves u' = S, S' = -(5/2) u^4 from u = 0, S = 1, so
that S^2 + u^5 = 1 and phi = integral of du / sqrt(1 - u^5), an incomplete beta function; scipy
inverts it to round-off.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy import special

from nlds_vines.kernels import impact
from nlds_vines.orbits.settings import NODES

HALF = special.beta(0.2, 0.5) / 5  # phase from touch to the deepest point
LOST = special.beta(0.4, 1.5) / 5  # integral of S^2 u / 2 from touch to release
STRETCH = 0.57  # of the map x = d sinh(a xi): a little inside the singularity at 0.727
FINEST = 1e-16  # change of a sweep that is round-off


def hertz_arc(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (u, S) of the free Hertz impact at phases `phi`, 0 at touch, 2 HALF at release.

    Either of u^5 and S^2 = 1 - u^5 is taken from the inverse beta function that is well
    conditioned there, so that both are good to round-off all along.
    """
    left = np.minimum(phi, 2 * HALF - phi) / HALF  # 0 at touch or release, 1 at the deepest point
    fifth = special.betaincinv(0.2, 0.5, left)
    square = special.betaincinv(0.5, 0.2, 1 - left)
    low = fifth < 0.5
    u = np.where(low, fifth, 1 - square) ** 0.2
    S = np.sqrt(np.where(low, 1 - fifth, square))
    return u, np.where(phi > HALF, -S, S)


def _integration(xi: np.ndarray, upto: np.ndarray) -> np.ndarray:
    """Return the matrix that integrates values at the Gauss points `xi` from -1 to `upto`."""
    n = len(xi)
    values_to_series = np.linalg.inv(legendre.legvander(xi, n - 1))
    antiderivatives = legendre.legint(np.eye(n), lbnd=-1, axis=0)
    return legendre.legvander(upto, n) @ antiderivatives @ values_to_series


@lru_cache(maxsize=8)
def _tables(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices and the rows of `Arc` for n nodes, of the whole arc and of its half.

    The map keeps the nodes of the whole away from the singularities beside its middle; the half,
    which ends between them, needs none.
    """
    xi, _ = legendre.leggauss(n)
    steep = np.arcsinh(1 / STRETCH)
    whole = HALF * (1 + STRETCH * np.sinh(steep * xi))
    density = HALF * STRETCH * steep * np.cosh(steep * xi)
    parts = _part(xi, whole, density), _part(xi, HALF * (1 + xi) / 2, np.full(n, HALF / 2))
    integrations, tables = zip(*parts, strict=True)
    return np.concatenate(integrations), np.concatenate(tables)


def _part(xi: np.ndarray, phi: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix and the rows for nodes at the phases `phi`, dphi = `density` dxi."""
    n = len(xi)
    u, S = hertz_arc(phi)
    integration = _integration(xi, xi) * density
    (weight,) = _integration(xi, np.array([1.0])) * density
    time = integration @ u
    rows = {
        impact.U: u,
        impact.S: S,
        impact.BY_DRAG: integration @ (0.5 * S**2 * u),
        impact.BY_DRIFT: integration @ (0.5 * S * u * time),
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
    tolerance = max(0.3 * 10.0**-nodes, FINEST)
    loss_missed = LOST - float(weight @ (0.5 * S**2 * u))
    return impact.Arc(nodes, float(weight @ u), tolerance, loss_missed, integration, table.copy())
