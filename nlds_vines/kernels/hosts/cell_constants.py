"""The constants of cells under nonlinear springs: matrices of Gauss nodes, once in a process."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

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


def legendre(x: np.ndarray, count: int) -> np.ndarray:
    """Return the Legendre polynomials (count, ...) of degrees 0 to count - 1 at x in [-1, 1]."""
    values = [np.ones_like(x), x]
    for n in range(1, count - 1):
        values.append(((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1))
    return np.array(values[:count])


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss nodes and weights on [-1, 1], by Newton's method in strict arithmetic."""
    nodes = np.zeros(count)
    weights = np.zeros(count)
    for i in range(count):
        x = math.cos(math.pi * (i + 0.75) / (count + 0.5))
        slope = 1.0
        for _ in range(12):
            before, value = 1.0, x
            for n in range(1, count):
                before, value = value, ((2 * n + 1) * x * value - n * before) / (n + 1)
            slope = count * (x * value - before) / (x * x - 1.0)
            x -= value / slope
        nodes[count - 1 - i] = x
        weights[count - 1 - i] = 2.0 / ((1.0 - x * x) * slope * slope)
    return nodes, weights


def lagrange(rule: tuple[np.ndarray, np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return the polynomials (count, ...) that are 1 at one of the Gauss nodes, at `places`.

    rule: nodes and weights of `gauss`; places: in [0, 1]. By discrete orthogonality, in sums of one
    order.
    """
    nodes, weights = rule
    count = len(nodes)
    at_nodes = legendre(nodes, count)
    at_places = legendre(2.0 * places - 1.0, count)
    total = np.zeros((count, *places.shape))
    for k in range(count):
        factors = (k + 0.5) * weights * at_nodes[k]
        total += factors.reshape(-1, *[1] * places.ndim) * at_places[k]
    return total


def folded_at(
    rule: tuple[np.ndarray, np.ndarray], fine: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return the integrals of l_q(c_i - tau) l_j(tau) over (0, c_i).

    rule: Gauss nodes c and their weights; fine: those of the samples q. They are an array
    (samples, nodes, nodes) by q, j and i.
    """
    nodes = 0.5 * (rule[0] + 1.0)
    places, weights = fine
    total = np.zeros((len(places), len(nodes), len(nodes)))
    for u, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
        of_kappa = lagrange(fine, nodes * (1.0 - u))
        of_force = lagrange(rule, nodes * u)
        total += weight * nodes * of_kappa[:, None, :] * of_force[None, :, :]
    return total


def cell_constants() -> CellConstants:
    """Return the constants of cells; the same bits on every processor."""
    rule = gauss(CELL_NODES)
    few_rule = gauss(FEW)
    fine = gauss(CELL_SAMPLES)
    nodes = 0.5 * (rule[0] + 1.0)
    few = 0.5 * (few_rule[0] + 1.0)
    samples = 0.5 * (fine[0] + 1.0)
    x, w = rule
    last = (CELL_NODES - 2, CELL_NODES - 1)
    tails = np.array([(k + 0.5) * w * legendre(x, CELL_NODES)[k] for k in last])
    x, w = few_rule
    rough = np.array([(k + 0.5) * w * legendre(x, FEW)[k] for k in (FEW - 1, 0)])
    to_end = 0.5 * fine[1][:, None] * lagrange(rule, 1.0 - samples).T
    return CellConstants(
        nodes=nodes,
        samples=samples,
        at_nodes=lagrange(fine, nodes).ravel(),
        at_few=lagrange(fine, few).ravel(),
        folded=folded_at(rule, fine).ravel(),
        folded_few=folded_at(few_rule, fine).ravel(),
        to_end=to_end.ravel(),
        refined=lagrange(few_rule, nodes).ravel(),
        tails=tails.ravel(),
        rough=rough.ravel(),
    )
