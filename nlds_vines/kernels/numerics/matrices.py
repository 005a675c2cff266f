"""Small real matrices by strict arithmetic and without LAPACK: the same bits everywhere.

Linear systems and determinants by Gaussian elimination with partial pivoting. Eigenvalues by
balancing, reduction to Hessenberg form by reflections and Francis' double shifts in real arithmetic
(Golub and Van Loan, Matrix Computations, chapter 7). Errors of eigenvalues are of the order of
round-off times the norm of the balanced matrix, as in LAPACK; relative errors of solutions are of
the order of round-off times the condition number of the matrix.
"""

from __future__ import annotations

import math

import numpy as np

from .compiling import jit
from .elementary import exponent_of, hypotenuse, log, power_of_two

EPSILON = 2.220446049250313e-16
MOST_FRANCIS = (
    300  # Francis steps for an eigenvalue; two or three are usual, thirty if it is triple
)
MOST_SCALED = 1000  # exponent of a matrix that is scaled: those of its numbers stay in range
RE, IM, LOG = range(3)  # columns of `fill_multipliers`


@jit
def scaled(matrix):
    """Return a matrix divided by 2^k, so that its largest entry is between 1 and 2, and k.

    The result is zero if the matrix is (nearly) zero, and NaN if an entry is not finite.
    """
    most = 0.0
    for i in range(len(matrix)):
        for j in range(len(matrix)):
            if not abs(matrix[i, j]) < math.inf:
                return np.full(matrix.shape, np.nan), 0
            most = max(most, abs(matrix[i, j]))
    copy = np.zeros(matrix.shape)
    if most < power_of_two(-MOST_SCALED):
        return copy, 0
    k = min(exponent_of(most), MOST_SCALED)
    for i in range(len(matrix)):
        for j in range(len(matrix)):
            copy[i, j] = matrix[i, j] * power_of_two(-k)
    return copy, k


@jit
def balance(a):
    """Multiply column i by a power of two and divide row i by it, until both have similar norms.

    A norm is the sum of moduli off the diagonal. The sweeps over all i end when none lowers one by
    5 %. Works in place; the eigenvalues stay, without round-off.
    """
    n, settled = len(a), False
    while not settled:
        settled = True
        for i in range(n):
            row = column = 0.0
            for j in range(n):
                if j != i:
                    row, column = row + abs(a[i, j]), column + abs(a[j, i])
            if row == 0.0 or column == 0.0:
                continue
            f, before = 1.0, row + column
            while column < 0.5 * row:
                f, column, row = 2.0 * f, 2.0 * column, 0.5 * row
            while column > 2.0 * row:
                f, column, row = 0.5 * f, 0.5 * column, 2.0 * row
            if row + column < 0.95 * before:
                settled = False
                for j in range(n):
                    a[j, i] *= f
                for j in range(n):
                    a[i, j] /= f


@jit
def reflect(a, k, u, size):
    """Reflect `size` rows and columns from k on by the map of u to a multiple of (1, 0, 0 ...).

    From both sides, so that the eigenvalues stay. u (size or more,) is overwritten.
    """
    most, others, square = abs(u[0]), 0.0, 0.0
    for i in range(1, size):
        others = max(others, abs(u[i]))
    if others == 0.0:
        return
    most = max(most, others)
    for i in range(size):
        u[i] /= most
        square += u[i] * u[i]
    length = math.sqrt(square)
    u[0] += length if u[0] >= 0.0 else -length
    square = 0.0
    for i in range(size):
        square += u[i] * u[i]
    p = 2.0 / square
    for j in range(len(a)):
        s = 0.0
        for i in range(size):
            s += u[i] * a[k + i, j]
        for i in range(size):
            a[k + i, j] -= s * p * u[i]
    for j in range(len(a)):
        s = 0.0
        for i in range(size):
            s += u[i] * a[j, k + i]
        for i in range(size):
            a[j, k + i] -= s * p * u[i]


@jit
def make_hessenberg(a, low, last, u, most):
    """Reduce the rows `low` to `last` to Hessenberg form; u: scratch.

    most: how many numbers below the diagonal a column may have.
    """
    for k in range(low, last - 1):
        size = min(most, last - k)
        for i in range(size):
            u[i] = a[k + 1 + i, k]
        reflect(a, k + 1, u, size)
        for i in range(k + 2, last + 1):
            a[i, k] = 0.0


@jit
def first_of_block(a, last):
    """Return the first row of the block that ends at row `last`; zero a negligible subdiagonal."""
    low = last
    while low > 0:
        size = abs(a[low - 1, low - 1]) + abs(a[low, low])
        if abs(a[low, low - 1]) <= EPSILON * (size if size > 0.0 else 1.0):
            a[low, low - 1] = 0.0
            return low
        low -= 1
    return 0


@jit
def francis_step(a, low, last, odd, u):
    """Apply one implicit double shift to the rows `low` to `last`; `odd` shifts break cycles."""
    total = a[last - 1, last - 1] + a[last, last]
    product = a[last - 1, last - 1] * a[last, last] - a[last - 1, last] * a[last, last - 1]
    if odd:
        size = abs(a[last, last - 1]) + abs(a[last - 1, last - 2])
        total, product = 1.5 * size, size * size
    x = a[low, low] * a[low, low] + a[low, low + 1] * a[low + 1, low]
    x += product - total * a[low, low]
    y = a[low + 1, low] * (a[low, low] + a[low + 1, low + 1] - total)
    z = a[low + 1, low] * a[low + 2, low + 1]
    u[0], u[1], u[2] = x, y, z
    reflect(a, low, u, 3)
    make_hessenberg(a, low, last, u, 3)


@jit
def pair_of_roots(a, b, c, d):
    """Return (re, im, re, im) of the eigenvalues of ((a, b), (c, d)), im > 0 first."""
    p, product = 0.5 * (a - d), b * c
    square = p * p + product
    if square < 0.0:
        im = math.sqrt(-square)
        return d + p, im, d + p, -im
    z = p + (math.sqrt(square) if p >= 0.0 else -math.sqrt(square))
    return d + z, 0.0, d - (product / z if z != 0.0 else 0.0), 0.0


@jit
def eigenvalues(matrix):
    """Return the eigenvalues (n, 2) of a matrix (n, n): real and imaginary parts.

    By falling modulus, of a complex pair the one with im > 0 first; NaN if the matrix is not
    finite.
    """
    roots = np.full((len(matrix), 2), np.nan)
    a, k = scaled(matrix)
    if math.isnan(a[0, 0]):
        return roots
    balance(a)
    u = np.zeros(max(len(a), 3))
    make_hessenberg(a, 0, len(a) - 1, u, len(a))
    last, steps = len(a) - 1, 0
    while last >= 0:
        low = first_of_block(a, last)
        if low < last - 1:
            if steps == MOST_FRANCIS:
                roots[:] = np.nan
                return roots
            steps += 1
            francis_step(a, low, last, steps % 10 == 0, u)
            continue
        if low == last:
            roots[last, RE], roots[last, IM] = a[last, last], 0.0
        else:
            roots[low, RE], roots[low, IM], roots[last, RE], roots[last, IM] = pair_of_roots(
                a[low, low], a[low, last], a[last, low], a[last, last]
            )
        last, steps = low - 1, 0
    for i in range(len(roots)):
        roots[i, RE] *= power_of_two(k)
        roots[i, IM] *= power_of_two(k)
    # Sort by falling modulus; values of one modulus keep their order.
    for i in range(1, len(roots)):
        re, im = roots[i, RE], roots[i, IM]
        size, j = hypotenuse(re, im), i
        while j > 0 and hypotenuse(roots[j - 1, RE], roots[j - 1, IM]) < size:
            roots[j, RE], roots[j, IM] = roots[j - 1, RE], roots[j - 1, IM]
            j -= 1
        roots[j, RE], roots[j, IM] = re, im
    return roots


@jit
def spectral_radius(values):
    """Return the largest modulus of `eigenvalues`, inf if their matrix is not finite."""
    if math.isnan(values[0, RE]):
        return math.inf
    return hypotenuse(values[0, RE], values[0, IM])


@jit
def is_saddle(values):
    """Return True if an odd number of `eigenvalues` are real and greater than one."""
    count = 0
    for i in range(len(values)):
        if values[i, IM] == 0.0 and values[i, RE] > 1.0:
            count += 1
    return count % 2 == 1


@jit(entry=True)
def fill_multipliers(matrices, multipliers):
    """Fill `multipliers` (m, n, 3) with eigenvalues of `matrices` (m, n, n): RE, IM and ln |mu|."""
    for i in range(len(matrices)):
        one = eigenvalues(matrices[i])
        for c in range(len(one)):
            multipliers[i, c, RE], multipliers[i, c, IM] = one[c, RE], one[c, IM]
            multipliers[i, c, LOG] = log(hypotenuse(one[c, RE], one[c, IM]))


# ---- systems of linear equations -----------------------------------------------------------------


@jit
def solve(matrix, right):
    """Solve matrix (n, n) x = right (n or more, m) by Gaussian elimination.

    x replaces the first n rows of `right`; the matrix is overwritten. Returns the determinant. It
    is 0 if a pivot is 0 or NaN (`right` then has no meaning), or if the product underflows.
    """
    size, product = len(matrix), 1.0
    for i in range(size):
        pivot = i
        for j in range(i + 1, size):
            if abs(matrix[j, i]) > abs(matrix[pivot, i]):
                pivot = j
        if not abs(matrix[pivot, i]) > 0.0:
            return 0.0
        product *= matrix[pivot, i] if pivot == i else -matrix[pivot, i]
        for c in range(size):
            matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
        for c in range(right.shape[1]):
            right[i, c], right[pivot, c] = right[pivot, c], right[i, c]
        for j in range(i + 1, size):
            f = matrix[j, i] / matrix[i, i]
            for c in range(i, size):
                matrix[j, c] -= f * matrix[i, c]
            for c in range(right.shape[1]):
                right[j, c] -= f * right[i, c]
    for i in range(size - 1, -1, -1):
        for c in range(right.shape[1]):
            for j in range(i + 1, size):
                right[i, c] -= matrix[i, j] * right[j, c]
            right[i, c] /= matrix[i, i]
    return product
