"""Periodic orbits as fixed points of the n-fold section map, by Newton's method (shooting).

A recurrence only proposes n. What is then believed rests on the orbit itself: a residual at
round-off, the smallest n that closes it, and the eigenvalues of its monodromy matrix.
"""

from __future__ import annotations

import numpy as np

from ..numerics.compiling import jit
from ..numerics.matrices import solve
from ..scene.codes import OK
from .variations import (
    advance_flow,
    distance,
    new_state,
    no_section,
    norm,
    place_state,
    set_identity,
)

MOST_ITERATIONS = 12  # steps of Newton's method: it converges in five, or not at all
CLOSED = 1.0e-9  # relative residual of a closed orbit, if a further step hardly lowers it
LEAST_RESIDUAL = 2.0e-15  # relative residual that no further step can lower
LONGEST_CORRECTION = 1.0  # relative to the orbit: a longer one leads to another orbit
SAME_POINT = 1.0e-8  # relative distance of two section points that are one


@jit
def trace_cycle(flow, y, points, counts, tangent, state):
    """Follow an orbit from y for len(points) periods; its matrix ends up in `tangent`.

    points (n, 4) take the sections, counts (2,) the impacts by wall. Returns (status, smallest
    clearance [m], slowest impact [m/s]).
    """
    place_state(flow, y, state)
    set_identity(tangent)
    counts[:] = 0
    flow.clearance[0], flow.slowest[0] = np.inf, np.inf
    nothing = no_section(flow.space)
    for p in range(len(points)):
        status = advance_flow(flow, nothing, 1, tangent, state)
        if status != OK:
            return status, np.nan, np.nan
        for i in range(4):
            points[p, i] = state[i]
        for wall in range(2):
            counts[wall] += flow.by_period[0, wall]
    return OK, flow.clearance[0], flow.slowest[0]


@jit
def matrix_of(tangent, size):
    """Return the matrix (size, size) whose columns are the variations."""
    matrix = np.empty((size, size))
    for column in range(size):
        for row in range(size):
            matrix[row, column] = tangent[4 * column + row]
    return matrix


@jit
def span_of(space, points):
    """Return the largest energy norm of the section points: what is small is small beside it."""
    span = 0.0
    for p in range(len(points)):
        span = max(span, norm(space, points[p]))
    return span


@jit
def less_identity(matrix):
    """Turn a matrix M into I - M, in place, and return it."""
    # (written out: an expression of arrays takes the compiler as long as the whole of `polish`)
    for i in range(len(matrix)):
        for j in range(len(matrix)):
            matrix[i, j] = (1.0 if i == j else 0.0) - matrix[i, j]
    return matrix


@jit
def correction(space, matrix, y, image):
    """Return Newton's correction (I - M)^-1 (image - y), and whether there is one; M is lost."""
    right, system = np.zeros((4, 1)), less_identity(matrix)
    for i in range(space.size):
        right[i, 0] = image[i] - y[i]
    regular = solve(system, right) != 0.0
    return right[:, 0], regular


@jit
def polish(flow, y, points, counts, tangent, longest=np.inf):
    """Move y (4,) onto an orbit of n = len(points) periods, by steps of at most the norm `longest`.

    Returns (residual, clearance [m], slowest impact [m/s]): the residual is the energy norm of what
    does not close, relative to the orbit's; it is inf where Newton's method does not converge.
    The other arguments are filled as by `trace_cycle`.
    """
    state, before = new_state(), np.inf
    for _ in range(MOST_ITERATIONS):
        status, clearance, slowest = trace_cycle(flow, y, points, counts, tangent, state)
        if status != OK:
            break
        span = span_of(flow.space, points)
        residual = distance(flow.space, state, y)
        if span > 0.0:
            residual /= span
        if residual <= LEAST_RESIDUAL or (residual <= CLOSED and residual > 0.25 * before):
            return residual, clearance, slowest
        if not residual < 2.0 * before:
            break
        step, found = correction(flow.space, matrix_of(tangent, flow.space.size), y, state)
        if not found or not norm(flow.space, step) <= min(LONGEST_CORRECTION * span, longest):
            break
        for i in range(flow.space.size):
            y[i] += step[i]
        before = residual
    return np.inf, np.inf, np.inf


@jit
def is_minimal(space, y, points):
    """Tell whether no smaller number of periods closes the orbit through y."""
    n, span = len(points), span_of(space, points)
    for d in range(1, n // 2 + 1):
        if n % d == 0 and distance(space, points[d - 1], y) <= SAME_POINT * span:
            return False
    return True
