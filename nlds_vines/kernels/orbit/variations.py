"""The flow from section to section, and its derivative along an orbit.

The vector field is continuously differentiable at touch and release, so that the variational
equation needs no jumps there: variations are propagated by exact matrices in flight and by the
linearized contact in between (`inside`, or `taylor` for a stepped one). The derivative over n
periods is the monodromy matrix of an nT orbit. Its determinant is exp(n T tr A) for every orbit, if
contacts dissipate nothing.

Kernels marked `by_flow` are for one structure with one damper; for hosts those of the same names in
`host_space` and `host_orbit` replace them. All others serve states of any size.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.driven import Driven, rows_of
from ..motion.flight import Grid
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, says
from ..numerics.elementary import log
from ..numerics.matrices import solve
from ..scene.by_law import by_flow
from ..scene.codes import OK
from ..scene.law import SHRUNK
from ..scene.scene import Ground, OrbitBuffers, Prepared, Span, Structure, scale_of
from .orbit import STATE_SIZE, on_ground, run, set_mode


class Space(NamedTuple):
    """The state space of one cell with its energy norm."""

    ps: Structure
    damper: Any  # `Damper` or None
    size: int  # components of a state: 4, or 2 without a damper
    rest: float  # x2 - x1 of the unstretched spring [m]
    blur: float  # norm of the round-off of an r computed from x1 - x2 of a section [J^0.5]


class Flow(NamedTuple):
    """The map of one cell from a section to the next, which `advance_flow` applies."""

    prepared: Prepared
    exact_grid: Grid  # of exact flight, which propagates variations whatever the method
    space: Space
    period: float  # [s]
    trace: float  # tr A [1/s]: the sum of all Lyapunov exponents
    by_period: np.ndarray  # (TOGETHER, 2) impacts of the last periods by wall
    clearance: np.ndarray  # (1,) smallest near miss so far [m]
    slowest: np.ndarray  # (1,) smallest approach speed of an impact so far [m/s]


TOGETHER = 4  # most periods that are advanced in one call
LEFT_OVER = 1.0e-13  # share of a length that is round-off
BLUR = 2.0e-15  # round-off of an r computed from a section's x1 - x2, relative to the rest offset
MUCH = 4.0  # ratio of squared lengths, before and after a projection, that asks for another one


@jit
def flow_of(prepared, exact_grid):
    ps, damper = prepared.ps, prepared.damper
    if damper is None or is_a(damper, Ground):
        space, trace = Space(ps, None, 2, 0.0, 0.0), -ps.damping
    else:
        blur = scale_of(ps, damper, 0.0, 0.0, BLUR * damper.rest, 0.0)
        space = Space(ps, damper, 4, damper.rest, blur)
        trace = -ps.damping - damper.c2 * damper.inv_mu
    counts, period = np.zeros((TOGETHER, 2), np.int64), exact_grid.h * exact_grid.n
    return Flow(
        prepared, exact_grid, space, period, trace, counts, np.full(1, np.inf), np.full(1, np.inf)
    )  # fmt: skip


@by_flow
def advance_flow(flow, section, periods, tangent, state):
    """Advance `state` (STATE_SIZE,) and four variations `tangent` (16,) by up to TOGETHER periods.

    The orbit is that of `run_on`, to the last bit. section: rows for its sections, as far as there
    is room. Fills flow.by_period for these periods, and flow.clearance and flow.slowest with the
    smallest values of all calls, but nothing with driven variations. Returns a status.
    """
    flow.by_period[:periods] = 0
    if flow.prepared.scratch is None or is_a(tangent, Driven):
        buffers = OrbitBuffers(None, section, None, None, None, None, None, None, None)
    else:
        buffers = OrbitBuffers(
            None, section, flow.by_period, None, None, flow.clearance, flow.slowest, None, None
        )
    # Walls that limit the structure itself see x1 and v1 as r and s, of variations, too.
    if is_a(flow.prepared.damper, Ground):
        rows = rows_of(tangent)
        for i in range(0, 16, 4):
            rows[i + 2], rows[i + 3] = rows[i], rows[i + 1]
    status = run(flow.prepared, buffers, Span(0, periods, 1), state, tangent, flow.exact_grid)
    if is_a(flow.prepared.damper, Ground):
        rows = rows_of(tangent)
        for i in range(0, 16, 4):
            rows[i], rows[i + 1] = rows[i + 2], rows[i + 3]
            rows[i + 2] = rows[i + 3] = 0.0
    return status


@by_flow
def run_on(flow, section, periods, state):
    """Advance `state` (STATE_SIZE,) without variations by so many periods; return a status.

    section: rows for the sections, as far as there is room.
    """
    buffers = OrbitBuffers(None, section, None, None, None, None, None, None, None)
    return run(flow.prepared, buffers, Span(0, periods, 1), state, None, None)


@jit
def no_section(space):
    return np.empty((0, space.size))


@by_flow
def width_of(space):
    """Return how many numbers a state at a section and a variation have; beyond `size` zeros."""
    return 4


@by_flow
def column_of(space, i):
    """Return the column of displacement i in the sections of a record."""
    return 2 * i


@by_flow
def has_walls(flow):
    return flow.prepared.scratch is not None


@by_flow
def place_state(flow, y, state):
    """Set `state` (STATE_SIZE,) to y (4,) at a section, in flight or inside a contact."""
    state[:] = 0.0
    for i in range(4):
        state[i] = y[i]
    on_ground(flow.prepared.damper, state)
    set_mode(flow.prepared.near, flow.prepared.far, flow.prepared.damper, state)


@jit
def set_identity(tangent, width=4):
    tangent[:] = 0.0
    for i in range(0, len(tangent), width + 1):
        tangent[i] = 1.0


@by_flow
def norm(space, x):
    """Return the energy norm sqrt(2 E) of a state or of a difference of states."""
    return scale_of(space.ps, space.damper, x[0], x[1], x[2], x[3])


@by_flow
def distance(space, x, y):
    return scale_of(space.ps, space.damper, x[0] - y[0], x[1] - y[1], x[2] - y[2], x[3] - y[3])


@jit
def product_of(x, i, j, width):
    """Return the sum of products of the numbers of a row from i and from j on, in four sums."""
    a = b = c = d = 0.0
    for k in range(0, width - 3, 4):
        a += x[i + k] * x[j + k]
        b += x[i + k + 1] * x[j + k + 1]
        c += x[i + k + 2] * x[j + k + 2]
        d += x[i + k + 3] * x[j + k + 3]
    for k in range(width - width % 4, width):
        a += x[i + k] * x[j + k]
    return (a + c) + (b + d)


@jit
def orthonormalize(tangent, size, growth, lost=0.0):
    """Make the first `size` variations orthonormal (Gram and Schmidt), and add to `growth`.

    The logarithms of their lengths are added: the sums are the exponents times the time. A
    variation whose squared length falls by more than a factor MUCH is projected again. One whose
    length falls below `lost` of what it was becomes zero, and its growth -inf.
    """
    width = len(tangent) // len(growth)
    for at in range(0, size * width, width):
        stretched, before = 1.0, math.inf
        while before > MUCH:
            square = product_of(tangent, at, at, width)
            for other in range(0, at, width):
                along = product_of(tangent, at, other, width)
                for c in range(width):
                    tangent[at + c] -= along * tangent[other + c]
            left = product_of(tangent, at, at, width)
            if left <= lost * lost * square:
                tangent[at : at + width] = 0.0
                stretched = 0.0
                break
            before = square / left
            length = math.sqrt(left)
            stretched *= length
            for c in range(width):
                tangent[at + c] /= length
        growth[at // width] += log(stretched)


@by_flow
def departs(flow, before, now, n):
    """Return True if an orbit that nearly returns after n periods is seen not to approach any."""
    return False  # Newton's method costs little


@by_flow
def variations_of(flow):
    """Return the number of variations by which the exponents of an orbit are measured."""
    return 4


GOLDEN = 0.6180339887498949  # whose multiples by squares, without integers, hardly repeat


@jit
def begin_growth(flow):
    """Return variations whose growth is measured, and an array for the growth.

    If there are fewer than a state has numbers, none has the symmetry of a host, as unit vectors of
    modes do, which would never grow in other directions.
    """
    count, width = variations_of(flow), width_of(flow.space)
    tangent, growth = np.empty(count * width), np.zeros(count)
    set_identity(tangent, width)
    if count < width:
        for i in range(len(tangent)):
            multiple = GOLDEN * (i + 1) * (i + 1)
            tangent[i] = multiple - int(multiple) - 0.5
        orthonormalize(tangent, count, growth)
        growth[:] = 0.0
    return tangent, growth


@by_flow
def lost_of(flow):
    """Return LEFT_OVER if a damper may stick, which loses directions, otherwise 0."""
    if says(flow.prepared.near, "AT_ONCE") or says(flow.prepared.far, "AT_ONCE"):
        return LEFT_OVER
    return 0.0


@jit
def shrinks(wall):
    """Return True if contacts with a wall shrink volumes of states: by e^2 or by damping."""
    if wall is None:
        return False
    if says(wall, "AT_ONCE") or says(wall, "LINEAR"):
        return True
    return wall.damping is not None


@jit
def shrunk_in_contacts(flow, y, n):
    """Return the logarithm of the factor by which contacts shrink volumes in n periods from y.

    For a damped contact it is the integral of what its damping adds to the trace tr A.
    """
    if flow.prepared.scratch is None:
        return 0.0
    if not (shrinks(flow.prepared.near) or shrinks(flow.prepared.far)):
        return 0.0
    state, tangent, k = state_for(flow), np.zeros(16), flow.prepared.scratch
    place_state(flow, y, state)
    k[SHRUNK] = 0.0
    for p in range(0, n, TOGETHER):
        set_identity(tangent)
        if advance_flow(flow, no_section(flow.space), min(TOGETHER, n - p), tangent, state) != OK:
            break
    return k[SHRUNK]


@by_flow
def volume_of(flow, y, monodromy, n):
    """Return ln |det M| of n periods from y, the sum of ln |mu|; M: `monodromy`."""
    return flow.trace * n * flow.period + shrunk_in_contacts(flow, y, n)


@jit
def new_state():
    return np.zeros(STATE_SIZE)


@by_flow
def state_for(flow):
    """Return room for the states that a flow advances."""
    return new_state()


# --------------------------------------------------------------------------------------------------
# Periodic orbits as fixed points of the n-fold section map, by Newton's method (shooting).
#
# A recurrence only proposes n. An orbit is accepted by its residual, which is round-off, by the
# smallest n that closes it, and by the eigenvalues of its monodromy matrix.


MOST_ITERATIONS = 12  # of Newton's method: it converges in five, or not at all
CLOSED = 1.0e-9  # relative residual of a closed orbit, if a further step hardly lowers it
LEAST_RESIDUAL = 2.0e-15  # relative residual that no further step can lower
LONGEST_CORRECTION = 1.0  # relative to the orbit: a longer one leads to another orbit
SAME_POINT = 1.0e-8  # relative distance of two section points that are equal


@jit
def trace_cycle(flow, y, points, counts, tangent, state):
    """Follow an orbit from y for n periods; fill `tangent` with its monodromy matrix.

    Fills points (n, width) with the sections and `counts` with the impacts by wall. Returns
    (status, smallest clearance [m], slowest impact [m/s]).
    """
    place_state(flow, y, state)
    set_identity(tangent, points.shape[1])
    counts[:] = 0
    flow.clearance[0], flow.slowest[0] = np.inf, np.inf
    nothing = no_section(flow.space)
    for p in range(len(points)):
        status = advance_flow(flow, nothing, 1, tangent, state)
        if status != OK:
            return status, np.nan, np.nan
        for i in range(points.shape[1]):
            points[p, i] = state[i]
        for wall in range(len(counts)):
            counts[wall] += flow.by_period[0, wall]
    return OK, flow.clearance[0], flow.slowest[0]


@jit
def matrix_of(tangent, size, width=4):
    matrix = np.empty((size, size))
    for column in range(size):
        for row in range(size):
            matrix[row, column] = tangent[width * column + row]
    return matrix


@jit
def span_of(space, points):
    """Return the largest energy norm of the section points, the scale of residuals."""
    span = 0.0
    for p in range(len(points)):
        span = max(span, norm(space, points[p]))
    return span


@jit
def newton_step(space, tangent, image, y):
    """Return the step (I - M)^-1 (image - y), M in `tangent`; its first number NaN if singular."""
    size, width = space.size, width_of(space)
    matrix, right = matrix_of(tangent, size, width), np.zeros((width, 1))
    for i in range(size):  # written out: expressions of arrays take long to compile
        right[i, 0] = image[i] - y[i]
        for j in range(size):
            matrix[i, j] = (1.0 if i == j else 0.0) - matrix[i, j]
    if solve(matrix, right) == 0.0:
        right[0, 0] = np.nan
    return right[:, 0]


@jit
def polish(flow, y, points, counts, tangent, longest=np.inf):
    """Move y (width,) onto an orbit of n = len(points) periods by Newton's method.

    A step is `newton_step`, M the monodromy matrix, and at most `longest` in norm.
    Returns (residual, clearance [m], slowest impact [m/s]). The residual is the energy norm of
    image - y, relative to `span_of`; inf if the method does not converge. The other arguments are
    filled as by `trace_cycle`.
    """
    state, before = state_for(flow), np.inf
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
        step = newton_step(flow.space, tangent, state, y)
        if not norm(flow.space, step) <= min(LONGEST_CORRECTION * span, longest):
            break
        for i in range(flow.space.size):
            y[i] += step[i]
        before = residual
    return np.inf, np.inf, np.inf


@jit
def is_minimal(space, y, points):
    """Return True if no smaller number of periods closes the orbit through y."""
    n, span = len(points), span_of(space, points)
    for d in range(1, n // 2 + 1):
        if n % d == 0 and distance(space, points[d - 1], y) <= SAME_POINT * span:
            return False
    return True
