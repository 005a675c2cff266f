"""A ride along an orbit with its variations: the map from section to section and its derivative.

The vector field is continuously differentiable at touch and release, so that the variational
equation needs no jumps there: exact matrices in flight, the linearised contact in between
(`contact_field.slope`). The derivative of n periods is the monodromy matrix of an nT orbit; its
determinant is known beforehand, exp(n T tr A), whatever the orbit does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .compiling import chosen, jit
from .observe import COLUMNS, SPEED, Rows
from .orbit import SIZE, begin, linear_orbit, orbit
from .runge_kutta import SCRATCH
from .scene import scale_of

KEPT = 64  # impacts of one advance whose speed is looked at


class Ride(NamedTuple):
    """One cell made ready: its parts (None where absent), its grids and scratch of its own."""

    classical: Any
    ps: Any
    damper: Any
    near: Any
    far: Any
    arc: Any
    jets: Any  # exact grid, which carries variations in flight
    grid: Any  # of the method
    steps: float  # of a free impact
    size: int  # numbers of a state: 4, or 2 without a damper
    rest: float  # x2 - x1 of the unstretched spring [m]
    trace: float  # tr A [1/s]: the sum of all Lyapunov exponents
    k: np.ndarray  # (SCRATCH,)
    rows: Rows
    beats: np.ndarray  # (1, 2) impacts of the last period by wall
    misses: np.ndarray  # (1,) smallest clearance so far [m]


@jit
def trace_of(ps, damper):
    """Return tr A [1/s], the constant divergence of the flow: contacts do not add to it."""
    if damper is None:
        return -ps.damping
    return -ps.damping - damper.c2 * damper.inv_mu


@jit
def size_of(damper):
    """Return how many numbers make a state."""
    if damper is None:
        return 2
    return 4


@chosen
def rest_of(damper):
    """Return the rest offset x2 - x1 [m] of the damper's spring, 0 without a damper."""
    if damper is None:
        return lambda damper: 0.0
    return lambda damper: damper.rest


@jit
def ride_of(classical, ps, damper, near, far, arc, jets, grid, steps):
    """Return the `Ride` of one cell."""
    rows = Rows(np.zeros((KEPT, COLUMNS)), np.zeros(1, np.int64))
    return Ride(
        classical, ps, damper, near, far, arc, jets, grid, steps, size_of(damper), rest_of(damper),
        trace_of(ps, damper), np.zeros(SCRATCH), rows, np.zeros((1, 2), np.int64),
        np.full(1, np.inf),
    )  # fmt: skip


@chosen
def advance(arc, ride, tangent, state):
    """Advance `state` (SIZE,) and four variations `tangent` (16,) by one period: a status.

    ride.beats, ride.rows and ride.misses then tell of its impacts and near misses.
    """

    def linear(arc, ride, tangent, state):
        return linear_orbit(
            ride.classical, ride.ps, ride.damper, None, None, tangent, ride.jets,
            ride.grid, 1, state, 1,
        )  # fmt: skip

    def walled(arc, ride, tangent, state):
        ride.beats[:] = 0
        ride.rows.filled[0] = 0
        return orbit(
            ride.classical, ride.ps, ride.damper, ride.near, ride.far, ride.arc, None, None,
            ride.beats, ride.rows, None, ride.misses, tangent, ride.jets,
            ride.grid, 1, ride.steps, state, ride.k, 0, 1,
        )  # fmt: skip

    return linear if arc is None else walled


@jit
def seat(ride, y, state):
    """Let `state` (SIZE,) be y (4,) at phase zero, in flight or inside a contact."""
    state[:] = 0.0
    for i in range(4):
        state[i] = y[i]
    begin(ride.near, ride.far, state)


@jit
def unit(tangent):
    """Let the variations be the unit vectors."""
    tangent[:] = 0.0
    for i in range(0, 16, 5):
        tangent[i] = 1.0


@jit
def norm(ride, x):
    """Return the energy norm of a state or a difference of states: sqrt(2 E) of it."""
    return scale_of(ride.ps, ride.damper, x[0], x[1], x[2], x[3])


@jit
def gap_between(ride, x, y):
    """Return the energy norm of x - y."""
    return scale_of(ride.ps, ride.damper, x[0] - y[0], x[1] - y[1], x[2] - y[2], x[3] - y[3])


@jit
def softest(ride):
    """Return the smallest approach speed [m/s] of the last period's impacts; inf without any."""
    slowest = np.inf
    for i in range(min(ride.rows.filled[0], KEPT)):
        slowest = min(slowest, ride.rows.data[i, SPEED])
    return slowest


@jit
def orthonormalise(tangent, size, growth):
    """Make the first `size` variations orthonormal (Gram and Schmidt, twice); add to `growth`.

    growth (4,) takes the logarithms of the lengths: their sums are the exponents times the time.
    """
    for i in range(size):
        a = 4 * i
        total = 0.0
        for _ in range(2):
            for j in range(i):
                b = 4 * j
                dot = 0.0
                for c in range(4):
                    dot += tangent[a + c] * tangent[b + c]
                for c in range(4):
                    tangent[a + c] -= dot * tangent[b + c]
            length = 0.0
            for c in range(4):
                length += tangent[a + c] * tangent[a + c]
            length = math.sqrt(length)
            total += math.log(length)
            for c in range(4):
                tangent[a + c] /= length
        growth[i] += total


@jit
def solve(matrix, right, size):
    """Solve matrix x = right in place by elimination with pivots; False where it is singular."""
    for i in range(size):
        pivot = i
        for j in range(i + 1, size):
            if abs(matrix[j, i]) > abs(matrix[pivot, i]):
                pivot = j
        if not abs(matrix[pivot, i]) > 0.0:
            return False
        for c in range(size):
            matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
        right[i], right[pivot] = right[pivot], right[i]
        for j in range(i + 1, size):
            f = matrix[j, i] / matrix[i, i]
            for c in range(i, size):
                matrix[j, c] -= f * matrix[i, c]
            right[j] -= f * right[i]
    for i in range(size - 1, -1, -1):
        for c in range(i + 1, size):
            right[i] -= matrix[i, c] * right[c]
        right[i] /= matrix[i, i]
    return True


@jit
def radius_of(matrix):
    """Return the largest modulus of the eigenvalues of a matrix."""
    if not np.isfinite(matrix).all():
        return np.inf
    return np.abs(np.linalg.eigvals(matrix.astype(np.complex128))).max()


@jit
def fresh_state():
    """Return an empty state for `seat`."""
    return np.zeros(SIZE)
