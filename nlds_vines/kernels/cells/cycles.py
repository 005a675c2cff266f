"""An nT orbit as a point of a branch: its defect, the derivatives of that, and its extremes.

The defect is image - y, the image being the state n periods after y. Its derivative by y is M - I;
the monodromy matrix M is from variations. Its derivatives by parameters, those of the image, are
from variations that the parameters drive (`driven`). Also orbits that stop near a known cycle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.driven import RATE_COLUMNS, Driven, fill_rates
from ..motion.flight import PERIOD, Begun
from ..numerics.compiling import jit
from ..numerics.matrices import eigenvalues, solve
from ..orbit.orbit import STATE_SIZE
from ..orbit.variations import (
    TOGETHER,
    advance_flow,
    distance,
    matrix_of,
    new_state,
    no_section,
    place_state,
    run_on,
    span_of,
    trace_cycle,
)
from ..scene.codes import OK
from ..scene.law import SHRUNK
from ..scene.scene import CellBuffers, Span, damper_of, structure_under
from ..watch.observe import IMPACT_COLUMNS, IMPACT_FORCE, RELEASE, SPEED, Impacts
from .cells import cell_flow, run_cell

# Columns of the numbers of a cycle:
#   0 DEFECT   energy norm of image - y over EXTENT   3 GENTLEST  slowest impact [m/s], inf: none
#   1 EXTENT   largest energy norm of its sections    4 LOG_DETERMINANT    ln det M, as it has to be
#   2 MISS     nearest miss [m], inf: none
DEFECT, EXTENT, MISS, GENTLEST, LOG_DETERMINANT = range(5)
NUMBERS_OF_CYCLE = 5
MOST_NOTED = 4096  # impacts of a cycle whose speeds and forces count


class Traced(NamedTuple):
    """An orbit of n periods with states of (size,) numbers, and its derivatives by m parameters."""

    points: Any  # (n, 4) the sections; of a host (n, size)
    counts: Any  # (walls,) impacts by wall
    matrix: Any  # (size, size) the monodromy matrix
    slopes: Any  # (m, 4) derivatives of the image by the parameters
    multipliers: Any  # (size, 2) real and imaginary parts
    numbers: Any  # (NUMBERS_OF_CYCLE,)


class Extremes(NamedTuple):
    energy: Any  # (orbits, 2) the largest E1 and E2 [J]
    strokes: Any  # (orbits, 2) the largest approach speed [m/s] and contact force [N]
    violation: Any  # (orbits, 3) as `cells.report_violation`, or None
    touches: Any  # (orbits, room, 4) the columns WALL to SPEED of the first impacts


@jit
def set_shrinking(scratch, value):
    """Set the logarithm by which contacts have shrunk volumes; return it as it was before."""
    if scratch is None:  # decided by its type: without walls there is no such number
        return 0.0
    before = scratch[SHRUNK]
    scratch[SHRUNK] = value
    return before


@jit
def follow_cycle(flow, y, traced, state):
    """Follow an orbit from y for as many periods as `Traced` has points; return a status.

    Fills `traced` but for the slopes and LOG_DETERMINANT; state: room for a state of the flow.
    """
    points, matrix, numbers = traced.points, traced.matrix, traced.numbers
    size, width = len(matrix), points.shape[1]
    tangent = np.zeros(width * width)
    status, clearance, slowest = trace_cycle(flow, y, points, traced.counts, tangent, state)
    if status != OK:
        return status
    span = span_of(flow.space, points)
    numbers[DEFECT], numbers[EXTENT] = distance(flow.space, state, y), span
    if span > 0.0:
        numbers[DEFECT] /= span
    numbers[MISS], numbers[GENTLEST] = clearance, slowest
    monodromy = matrix_of(tangent, size, width)
    for i in range(size):
        for j in range(size):
            matrix[i, j] = monodromy[i, j]
    values_of = eigenvalues(monodromy)
    for i in range(size):
        for c in range(2):
            traced.multipliers[i, c] = values_of[i, c]
    return OK


@jit(entry=True)
def trace(parts, cell, changes, phase, y, traced):
    """Follow an orbit from y (4,) for as many periods as `Traced` has points; return a status.

    phase: the phase of y and of all sections, as a share of the period; cell (1,); changes (m,):
    derivatives of the cell's numbers by m free parameters, 4 at most. Fills `traced`.
    """
    flow, status = cell_flow(parts, cell[0], Begun(phase, 1.0))
    if status != OK:
        return status
    n, state = len(traced.points), new_state()
    set_shrinking(flow.prepared.scratch, 0.0)
    status = follow_cycle(flow, y, traced, state)
    if status != OK:
        return status
    volume = set_shrinking(flow.prepared.scratch, 0.0)
    volume += flow.trace * n * flow.exact_grid.h * flow.exact_grid.n
    traced.numbers[LOG_DETERMINANT] = volume
    # the derivatives of the image of y by the parameters
    ps, damper = structure_under(parts, cell[0]), damper_of(parts.damper, cell[0])
    slopes, rows = traced.slopes, np.zeros(16)
    rates = np.zeros((len(slopes), RATE_COLUMNS))
    for m in range(len(slopes)):
        fill_rates(parts, ps, damper, changes[m], rates[m])
    driven, nothing = Driven(rows, rates), no_section(flow.space)
    place_state(flow, y, state)
    for p in range(0, n, TOGETHER):
        status = advance_flow(flow, nothing, min(TOGETHER, n - p), driven, state)
        if status != OK:
            return status
    for m in range(len(slopes)):
        for i in range(4):
            slopes[m, i] = rows[4 * m + i]
    return OK


@jit(entry=True)
def solve_bordered(matrix, columns, rows, right, system):
    """Solve ((matrix, columns), (rows)) x = right in place; return the determinant, 0: singular.

    matrix (n, n); columns (m, n), one column each; rows (m, n + m); right (n + m, k); system
    (n + m, n + m): scratch.
    """
    n, m = len(matrix), len(columns)
    for i in range(n):
        for j in range(n):
            system[i, j] = matrix[i, j]
        for j in range(m):
            system[i, n + j] = columns[j, i]
    for i in range(m):
        for j in range(n + m):
            system[n + i, j] = rows[i, j]
    return solve(system, right)


@jit(entry=True)
def measure_cycles(begin, end, parts, cells, starts, periods, extremes):
    """Fill the `Extremes` of nT orbits `begin` to `end` - 1, each over its `periods` (orbits,).

    cells (orbits,); starts (orbits, 4) at phase zero. A contact under way at phase zero has its
    touch at the end of the n periods and its release at their beginning: impact row 0 takes what
    happens before that release.
    """
    strokes, touches = extremes.strokes, extremes.touches
    for lane in range(begin, end):
        state, rows = np.zeros(STATE_SIZE), np.zeros((MOST_NOTED + 1, IMPACT_COLUMNS))
        for i in range(4):
            state[i] = starts[lane, i]
        rows[0, RELEASE] = np.nan
        impacts = Impacts(rows, np.ones(1, np.int64), 0)
        violation = None if extremes.violation is None else extremes.violation[lane]
        buffers = CellBuffers(
            None, None, None, impacts, extremes.energy[lane], None, None, violation, None, None,
        )  # fmt: skip
        run_cell(parts, cells[lane], state, Span(None, periods[lane], 1), buffers)
        filled = min(impacts.filled[0], MOST_NOTED + 1)
        if filled > 1 and math.isnan(rows[filled - 1, RELEASE]):
            period = 2.0 * math.pi / structure_under(parts, cells[lane]).omega
            rows[filled - 1, RELEASE] = rows[0, RELEASE] + periods[lane] * period
        for i in range(min(filled - 1, touches.shape[1])):
            for c in range(4):
                touches[lane, i, c] = rows[i + 1, c]
        for i in range(filled):
            strokes[lane, 0] = max(strokes[lane, 0], rows[i, SPEED])
            strokes[lane, 1] = max(strokes[lane, 1], rows[i, IMPACT_FORCE])


# --------------------------------------------------------------------------------------------------
# Orbits that are followed until they come near a known cycle, as in a plane of starts.
#
# An orbit stops at a section within the cycle's radius of one of its points if it is nearer at each
# of the next RETURNS, n periods apart. That it then stays is likely, not proven.

NO_CYCLE = -1  # the cycle of an orbit that has come near none
RETURNS = 2  # in a row that must be nearer; after one, chaos has left a cycle again
RETURN_ROUND_OFF = 1.0e-6  # distance of a return, in radii, below which it need not be nearer


class Cycles(NamedTuple):
    """Section points of known cycles; those of one system are adjacent rows."""

    periods: Any  # (m,) n of nT of the cycle, integers
    points: Any  # (m, 4) section points (x1, v1, r, s)
    weights: Any  # (m, 4) of the components of a distance, which is 1 at the cycle's radius


class Drawn(NamedTuple):
    """Where orbits stopped."""

    row: Any  # (orbits,) the row of `Cycles` that they came near, `NO_CYCLE` for none
    arrival: Any  # (orbits,) forcing periods until then, -1 for none
    status: Any  # (orbits,) of `codes`


@jit
def distance_to(cycles, row, state):
    """Return the distance of a state from a point of a cycle, in radii."""
    square = 0.0
    for i in range(4):
        d = cycles.weights[row, i] * (state[i] - cycles.points[row, i])
        square += d * d
    return math.sqrt(square)


@jit(entry=True)
def follow_to_cycles(begin, end, parts, cells, starts, search, drawn):
    """Follow orbits `begin` to `end` - 1 until they come near a cycle; fill `Drawn`.

    cells (orbits,); starts (orbits, 4) at phase zero; search: (rows, cycles, most), where rows
    (orbits, 2) are the first row of `cycles` of the orbit's system and the one after the last, and
    `most` is the number of periods after which an orbit stops anyway.
    """
    rows, cycles, _ = search
    for lane in range(begin, end):
        flow, code = cell_flow(parts, cells[lane], PERIOD)
        state, p = new_state(), 0
        drawn.row[lane], drawn.arrival[lane] = int(NO_CYCLE), -1
        if code == OK:
            place_state(flow, starts[lane], state)
        most = search[2] if rows[lane, 0] < rows[lane, 1] else -1
        while code == OK and p <= most:
            # the nearest row, `NO_CYCLE` if all are farther than their radius
            row, distance = int(NO_CYCLE), 1.0
            for other in range(rows[lane, 0], rows[lane, 1]):
                apart = distance_to(cycles, other, state)
                if apart <= distance:
                    row, distance = other, apart
            if row == int(NO_CYCLE):
                code = run_on(flow, no_section(flow.space), 1, state)
                p += 1
                continue
            arrival = p
            for _ in range(RETURNS):
                code = run_on(flow, no_section(flow.space), cycles.periods[row], state)
                p += cycles.periods[row]
                before, distance = distance, distance_to(cycles, row, state)
                if code != OK or distance > max(before, RETURN_ROUND_OFF):
                    break
            else:
                drawn.row[lane], drawn.arrival[lane] = row, arrival
                break
        drawn.status[lane] = code
