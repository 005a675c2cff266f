"""The constants of cells under nonlinear springs: matrices of Gauss nodes, once in a process."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..impact.arc import gauss_points, gauss_weights, legendre

CELL_NODES = 16  # Gauss nodes of a cell
FEW = 4  # nodes of the first solution
CELL_SAMPLES = 32  # Gauss nodes at which the linear motion of a cell is sampled


class CellConstants(NamedTuple):
    """Matrices of Gauss nodes on [0, 1], each one row of numbers (`cell_constants`)."""

    nodes: Any  # (CELL_NODES,)
    samples: Any  # (CELL_SAMPLES,)
    at_nodes: Any  # CELL_SAMPLES rows of CELL_NODES: values at the nodes by those at the samples
    at_few: Any  # CELL_SAMPLES rows of FEW: those at the four nodes
    # CELL_SAMPLES tables of CELL_NODES^2: W of a kappa that is 1 at a sample and 0 at others
    folded: Any
    folded_few: Any  # CELL_SAMPLES tables FEW x FEW
    to_end: Any  # CELL_SAMPLES rows of CELL_NODES: M of an answer that is 1 at a sample
    refined: Any  # FEW rows of CELL_NODES: values at the nodes of a polynomial given at the four
    tails: Any  # 2 rows of CELL_NODES: the two last Legendre coefficients of values at the nodes
    rough: Any  # 2 rows of FEW: the last and the first coefficient of values at the four nodes


def lagrange(nodes: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the polynomials (count, ...) that are 1 at one of the Gauss nodes, at `places`.

    nodes: in [-1, 1]; places: in [0, 1]. By discrete orthogonality, in sums of one order.
    """
    count = len(nodes)
    weights = gauss_weights(nodes)
    at_nodes = legendre(nodes, count - 1)
    at_places = legendre(2.0 * places - 1.0, count - 1)
    total = np.zeros((count, *places.shape))
    for k in range(count):
        factors = (k + 0.5) * weights * at_nodes[k]
        total += factors.reshape(-1, *[1] * places.ndim) * at_places[k]
    return total


def folded_at(nodes: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Return the integrals of l_q(c_i - tau) l_j(tau) over (0, c_i), by q, j and i.

    nodes, fine: in [-1, 1], Gauss nodes of the forces and of the samples q; c are those of the
    forces in [0, 1]. The result is an array (samples, nodes, nodes).
    """
    c = on_unit(nodes)
    total = np.zeros((len(fine), len(c), len(c)))
    for u, weight in zip(on_unit(fine), 0.5 * gauss_weights(fine), strict=True):
        of_kappa = lagrange(fine, c * (1.0 - u))
        of_force = lagrange(nodes, c * u)
        total += weight * c * of_kappa[:, None, :] * of_force[None, :, :]
    return total


def on_unit(nodes: np.ndarray) -> np.ndarray:
    """Return places in [-1, 1] as places in [0, 1]."""
    return 0.5 * (nodes + 1.0)


def coefficient_of(nodes: np.ndarray, degree: int) -> np.ndarray:
    """Return the row by which values at Gauss nodes give a Legendre coefficient."""
    row: np.ndarray = (degree + 0.5) * gauss_weights(nodes) * legendre(nodes, degree)[degree]
    return row


def cell_constants() -> CellConstants:
    """Return the constants of cells; the same bits on every processor."""
    nodes = gauss_points(CELL_NODES)
    few = gauss_points(FEW)
    fine = gauss_points(CELL_SAMPLES)
    samples = on_unit(fine)
    weights = 0.5 * gauss_weights(fine)
    tails = [coefficient_of(nodes, degree) for degree in (CELL_NODES - 2, CELL_NODES - 1)]
    rough = [coefficient_of(few, degree) for degree in (FEW - 1, 0)]
    to_end = weights[:, np.newaxis] * lagrange(nodes, 1.0 - samples).T
    return CellConstants(
        nodes=on_unit(nodes),
        samples=samples,
        at_nodes=lagrange(fine, on_unit(nodes)).ravel(),
        at_few=lagrange(fine, on_unit(few)).ravel(),
        folded=folded_at(nodes, fine).ravel(),
        folded_few=folded_at(few, fine).ravel(),
        to_end=to_end.ravel(),
        refined=lagrange(few, on_unit(nodes)).ravel(),
        tails=np.concatenate(tails),
        rough=np.concatenate(rough),
    )
