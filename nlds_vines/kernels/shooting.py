"""Periodic orbits as fixed points of the n-fold section map, by Newton's method (shooting).

A recurrence only proposes n. What is then believed rests on the orbit itself: a residual at
round-off, the smallest n that closes it, and the eigenvalues of its monodromy matrix.
"""

from __future__ import annotations

import numpy as np

from .compiling import jit
from .orbit import OK
from .ride import advance, fresh_state, gap_between, norm, seat, softest, solve, unit

MOST_TURNS = 12  # of Newton's method
CLOSED = 1.0e-9  # residual below which an orbit is closed, if it can be made no smaller
ROUND_OFF = 2.0e-15
STRAY = 1.0  # a correction larger than the orbit itself leads elsewhere
SAME = 1.0e-8  # distance of two section points that are one


@jit(dissolved=True)
def around(ride, y, points, counts, tangent, state):
    """Ride once around from y for len(points) periods; the matrix of it ends up in `tangent`.

    points (n, 4) take the sections, counts (2,) the impacts by wall. Returns (status, smallest
    clearance [m], softest impact [m/s]).
    """
    seat(ride, y, state)
    unit(tangent)
    counts[:] = 0
    ride.misses[0], slowest = np.inf, np.inf
    for p in range(len(points)):
        status = advance(ride.arc, ride, tangent, state)
        if status != OK:
            return status, np.nan, np.nan
        slowest = min(slowest, softest(ride))
        for i in range(4):
            points[p, i] = state[i]
        for wall in range(2):
            counts[wall] += ride.beats[0, wall]
    return OK, ride.misses[0], slowest


@jit
def matrix_of(tangent, size):
    """Return the matrix (size, size) whose columns are the variations."""
    matrix = np.empty((size, size))
    for column in range(size):
        for row in range(size):
            matrix[row, column] = tangent[4 * column + row]
    return matrix


@jit
def span_of(ride, points):
    """Return the largest energy norm of the section points: what is small is small beside it."""
    span = 0.0
    for p in range(len(points)):
        span = max(span, norm(ride, points[p]))
    return span


@jit
def correction(ride, matrix, y, image):
    """Return Newton's correction (I - M)^-1 (image - y), and whether there is one."""
    right, system = np.zeros(4), np.eye(ride.size) - matrix
    for i in range(ride.size):
        right[i] = image[i] - y[i]
    return right, solve(system, right, ride.size)


@jit(dissolved=True)
def polish(ride, y, points, counts, tangent):
    """Move y (4,) onto an orbit of n = len(points) periods.

    Returns (residual, clearance, softest): the residual is the energy norm of what does not close,
    relative to the orbit's; it is inf where Newton's method does not converge. The other arguments
    then tell of the orbit as in `around`.
    """
    state, before = fresh_state(), np.inf
    for _ in range(MOST_TURNS):
        status, clearance, slowest = around(ride, y, points, counts, tangent, state)
        if status != OK:
            break
        span = span_of(ride, points)
        residual = gap_between(ride, state, y)
        if span > 0.0:
            residual /= span
        if residual <= ROUND_OFF or (residual <= CLOSED and residual > 0.25 * before):
            return residual, clearance, slowest
        if not residual < 2.0 * before:
            break
        step, found = correction(ride, matrix_of(tangent, ride.size), y, state)
        if not found or not norm(ride, step) <= STRAY * span:
            break
        for i in range(ride.size):
            y[i] += step[i]
        before = residual
    return np.inf, np.inf, np.inf


@jit
def minimal(ride, y, points):
    """Tell whether no smaller number of periods closes the orbit through y."""
    n, span = len(points), span_of(ride, points)
    for d in range(1, n // 2 + 1):
        if n % d == 0 and gap_between(ride, points[d - 1], y) <= SAME * span:
            return False
    return True
