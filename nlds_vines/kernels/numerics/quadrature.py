"""Gauss-Legendre points and the integration of values there, by strict arithmetic.

Every array operation rounds number by number in one way only, and sums are taken in one order, so
that the results have the same bits with any BLAS.
"""

from __future__ import annotations

import numpy as np

from .elementary import cos_sin_of_turn

NEWTON = 8  # steps for the points: the guess has three digits, and each step doubles them


def legendre(x: np.ndarray, n: int) -> list[np.ndarray]:
    """Return the Legendre polynomials P_0 ... P_n at x."""
    found = [np.ones_like(x), x]
    for k in range(1, n):
        found.append(((2 * k + 1) * x * found[k] - k * found[k - 1]) / (k + 1))
    return found[: n + 1]


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
    total = np.zeros(matrix.shape[:-1])
    for j in range(len(values)):
        total = total + matrix[..., j] * values[j]
    return total
