"""Small systems of linear equations, with the same bits everywhere."""

from __future__ import annotations

from .compiling import jit


@jit
def solve(matrix, right):
    """Solve matrix (n, n) x = right (n or more, m) in place by elimination with pivots.

    Returns the determinant, 0 where the matrix is singular; the matrix is lost.
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
