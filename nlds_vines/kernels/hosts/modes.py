"""The modes of a host by strict arithmetic and without LAPACK: the same bits everywhere."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import hypotenuse

MOST_JACOBI = 60  # of rotations; some ten are usual
LOW = 1.0e-10  # omega^2 over the largest one: a lower one is judged by its mode's energies
RIGID = 1.4e-14  # 64 times round-off; strain energy over the sum of K_ii phi_i^2


@jit
def cholesky(M):
    """Return the lower triangular L with L L^T = M; None of its pivots may be 0 or less."""
    n = len(M)
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = M[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            lower[i, j] = math.sqrt(total) if i == j else total / lower[j, j]
    return lower


@jit
def divide_rows(lower, a):
    """Replace a by L^-1 a."""
    n = len(lower)
    for i in range(n):
        for k in range(i):
            for j in range(n):
                a[i, j] -= lower[i, k] * a[k, j]
        for j in range(n):
            a[i, j] /= lower[i, i]


@jit(entry=True)
def fill_modes(M, K, squares, vectors):
    """Fill the squares of the frequencies, ascending, and the modes by column, of modal mass 1.

    By Jacobi's rotations of L^-1 K L^-T, M = L L^T (Golub and Van Loan, Matrix Computations,
    section 8.5). The largest component of each mode is positive.
    """
    n, lower = len(M), cholesky(M)
    a = K.copy()
    divide_rows(lower, a)
    a = a.T.copy()
    divide_rows(lower, a)
    turned = np.eye(n)  # the eigenvectors by row
    for _ in range(MOST_JACOBI):
        is_diagonal = True
        for p in range(n - 1):
            for q in range(p + 1, n):
                both = 0.5 * (a[p, q] + a[q, p])
                size = math.sqrt(abs(a[p, p]) * abs(a[q, q]))
                largest = max(abs(a[p, p]), abs(a[q, q]))
                if abs(both) <= 1.0e-17 * size or abs(both) <= 1.0e-40 * largest:
                    continue
                is_diagonal = False
                half = 0.5 * (a[q, q] - a[p, p])
                # the smaller of the two angles that make a[p, q] zero
                tangent = both / (half + math.copysign(hypotenuse(half, both), half))
                cosine = 1.0 / hypotenuse(1.0, tangent)
                sine = tangent * cosine
                for j in range(n):
                    x, y = a[p, j], a[q, j]
                    a[p, j], a[q, j] = cosine * x - sine * y, sine * x + cosine * y
                    x, y = turned[p, j], turned[q, j]
                    turned[p, j], turned[q, j] = cosine * x - sine * y, sine * x + cosine * y
                for j in range(n):
                    x, y = a[j, p], a[j, q]
                    a[j, p], a[j, q] = cosine * x - sine * y, sine * x + cosine * y
                a[p, q] = a[q, p] = 0.0
        if is_diagonal:
            break
    for i in range(n):
        squares[i] = max(a[i, i], 0.0)
    order = np.argsort(squares, kind="mergesort")
    sorted_squares = squares[order]
    largest = sorted_squares[n - 1]
    for i in range(n):
        squares[i] = sorted_squares[i]
        row = turned[order[i]].copy()
        # L^-T times the eigenvector
        for j in range(n - 1, -1, -1):
            for k in range(j + 1, n):
                row[j] -= lower[k, j] * row[k]
            row[j] /= lower[j, j]
        most = 0
        for j in range(n):
            if abs(row[j]) > abs(row[most]) * (1.0 + 1.0e-9):
                most = j
        for j in range(n):
            vectors[j, i] = row[j] if row[most] > 0.0 else -row[j]
        if squares[i] < LOW * largest:
            # a[i, i] errs by round-off times the largest omega^2, the strain energy phi^T K phi
            # by round-off times the sum of K_ii phi_i^2
            strain, springs = 0.0, 0.0
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += K[j, k] * row[k]
                strain += row[j] * total
                springs += K[j, j] * row[j] * row[j]
            squares[i] = strain if strain > RIGID * springs else 0.0
