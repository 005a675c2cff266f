"""An nT orbit as a point of a branch: what does not close, its derivatives, what happens on it.

The derivative with respect to the state is the monodromy matrix, from the variations; those with
respect to parameters are from variations that these drive (`driven`).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.driven import RATE_COLUMNS, Driven, fill_rates
from ..motion.flight import PERIOD, Begun, cells_of, grid_from
from ..numerics.compiling import jit
from ..numerics.matrices import eigenvalues, solve
from ..orbit.orbit import STATE_SIZE
from ..orbit.variations import (
    TOGETHER,
    advance_flow,
    distance,
    flow_of,
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
from ..scene.scene import CellBuffers, Span, damper_of, joined, scale_of, structure_under
from ..watch.observe import IMPACT_COLUMNS, IMPACT_FORCE, RELEASE, SPEED, Impacts
from .cells import checked_cell, run_cell
from .verdict import TINY

# Columns of what is found of a cycle beside its arrays:
#   0 DEFECT   energy norm of image - y over EXTENT   3 GENTLEST  slowest impact [m/s], inf: none
#   1 EXTENT   largest energy norm of its sections    4 LOG_DETERMINANT    ln det M, as it has to be
#   2 MISS     nearest miss [m], inf: none
DEFECT, EXTENT, MISS, GENTLEST, LOG_DETERMINANT = range(5)
NUMBERS_OF_CYCLE = 5
MOST_NOTED = 4096  # impacts of a cycle whose speeds and forces are looked at


class Traced(NamedTuple):
    """What is found of an orbit of n periods of (size,) components and of its m parameters."""

    points: Any  # (n, 4) its sections
    counts: Any  # (2,) impacts by wall
    matrix: Any  # (size, size) the monodromy matrix
    slopes: Any  # (m, 4) derivatives of the image by the parameters
    multipliers: Any  # (size, 2) real and imaginary parts
    numbers: Any  # (NUMBERS_OF_CYCLE,)


class Extremes(NamedTuple):
    """What is measured on orbits."""

    energy: Any  # (orbits, 2) the largest E1 and E2 [J]
    strokes: Any  # (orbits, 2) the largest approach speed [m/s] and contact force [N]
    violation: Any  # (orbits, 3) as `cells.report_violation`, or None
    touches: Any  # (orbits, room, 4) the columns WALL to SPEED of impacts, as far as there is room


@jit
def cell_flow(parts, cell, begun):
    """Return the `variations.Flow` of a cell, and a status; unless that is OK, it is of no use.

    begun: `flight.Begun` of share 1, the phase of the sections.
    """
    status, prepared = checked_cell(parts, cell, 1, begun)
    n = max(cells_of(prepared.ps, prepared.damper), 1)
    return flow_of(prepared, grid_from(prepared.ps, prepared.damper, n, begun)), status


@jit
def shrunk_so_far(scratch):
    """Return by what contacts have shrunk volumes, as a logarithm."""
    if scratch is None:
        return 0.0
    return scratch[SHRUNK]


@jit
def forget_shrinking(scratch):
    """Let nothing have been shrunk so far."""
    if scratch is None:
        return None
    scratch[SHRUNK] = 0.0


@jit
def follow_slopes(parts, cell, changes, flow, y, n, slopes):
    """Fill slopes (m, 4) with the derivatives of the image of y after n periods by m parameters.

    changes (m,): the derivatives of the numbers of the cell. Returns a status.
    """
    ps, damper = structure_under(parts.load, cell), damper_of(parts.damper, cell)
    rates, rows, state = np.zeros((len(slopes), RATE_COLUMNS)), np.zeros(16), new_state()
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
def trace(parts, cell, changes, phase, y, traced):
    """Follow an orbit from y (4,) for as many periods as `Traced` has points; fill that.

    phase: the share of the forcing's period at which y and all sections are. cell (1,) and changes
    (m,): its derivatives by m free parameters, 4 at most. Returns a status.
    """
    points, matrix, found = traced.points, traced.matrix, traced.numbers
    flow, status = cell_flow(parts, cell[0], Begun(phase, 1.0))
    if status != OK:
        return status
    state, tangent, size = new_state(), np.zeros(16), len(matrix)
    forget_shrinking(flow.prepared.scratch)
    status, clearance, slowest = trace_cycle(flow, y, points, traced.counts, tangent, state)
    if status != OK:
        return status
    n = len(points)
    span = span_of(flow.space, points)
    found[DEFECT], found[EXTENT] = distance(flow.space, state, y), span
    if span > 0.0:
        found[DEFECT] /= span
    found[MISS], found[GENTLEST] = clearance, slowest
    volume = shrunk_so_far(flow.prepared.scratch)
    found[LOG_DETERMINANT] = volume + flow.trace * n * flow.exact_grid.h * flow.exact_grid.n
    monodromy = matrix_of(tangent, size)
    for i in range(size):
        for j in range(size):
            matrix[i, j] = monodromy[i, j]
    values_of = eigenvalues(monodromy)
    for i in range(size):
        for c in range(2):
            traced.multipliers[i, c] = values_of[i, c]
    return follow_slopes(parts, cell[0], changes, flow, y, n, traced.slopes)


@jit(entry=True)
def fill_norms(parts, cell, norms):
    """Fill norms (size,) with the energy norms of states of which one number is 1."""
    ps, damper = structure_under(parts.load, cell), damper_of(parts.damper, cell)
    y = np.zeros(4)
    for i in range(len(norms)):
        y[i] = 1.0
        norms[i] = scale_of(ps, joined(damper), y[0], y[1], y[2], y[3])
        y[i] = 0.0


@jit(entry=True)
def solve_bordered(matrix, columns, rows, right, lost):
    """Solve ((matrix, columns), (rows)) x = right in place; return the determinant, 0: singular.

    matrix (n, n), columns (m, n), each a column, rows (m, n + m), right (n + m, k); lost
    (n + m, n + m) takes the system.
    """
    n, m = len(matrix), len(columns)
    for i in range(n):
        for j in range(n):
            lost[i, j] = matrix[i, j]
        for j in range(m):
            lost[i, n + j] = columns[j, i]
    for i in range(m):
        for j in range(n + m):
            lost[n + i, j] = rows[i, j]
    return solve(lost, right)


@jit
def broken_limit(violation, lane):
    """Return where a lane's violations of its limit go, or None where there is no limit."""
    if violation is None:
        return None
    return violation[lane]


@jit(entry=True)
def measure_cycles(begin, end, parts, cells, starts, periods, extremes):
    """Measure nT orbits `begin` to `end` - 1, each over its `periods` (orbits,); fill `Extremes`.

    cells (orbits,) and starts (orbits, 4) at phase zero. A contact that is under way there has its
    touch at the end of the n periods and its release at their beginning. Row 0 takes what happens
    before that release, so that the largest force of both parts counts.
    """
    strokes, touches = extremes.strokes, extremes.touches
    for lane in range(begin, end):
        state, rows = np.zeros(STATE_SIZE), np.zeros((MOST_NOTED + 1, IMPACT_COLUMNS))
        for i in range(4):
            state[i] = starts[lane, i]
        rows[0, RELEASE] = np.nan
        impacts = Impacts(rows, np.ones(1, np.int64))
        buffers = CellBuffers(
            None, None, None, impacts, extremes.energy[lane], None, None,
            broken_limit(extremes.violation, lane), None, None, None, None,
        )  # fmt: skip
        run_cell(parts, cells[lane], state, Span(0, periods[lane], 1), buffers)
        filled = min(impacts.filled[0], MOST_NOTED + 1)
        if filled > 1 and math.isnan(rows[filled - 1, RELEASE]):
            period = 2.0 * math.pi / structure_under(parts.load, cells[lane]).omega
            rows[filled - 1, RELEASE] = rows[0, RELEASE] + periods[lane] * period
        for i in range(min(filled - 1, touches.shape[1])):
            for c in range(4):
                touches[lane, i, c] = rows[i + 1, c]
        for i in range(filled):
            strokes[lane, 0] = max(strokes[lane, 0], rows[i, SPEED])
            strokes[lane, 1] = max(strokes[lane, 1], rows[i, IMPACT_FORCE])


# --------------------------------------------------------------------------------------------------
# Orbits followed until it is certain to which of the known periodic attractors they are drawn.
#
# Around the section point y of a stable nT orbit lies a region, d' P d <= radius^2 for deviations d
# from y, in which every n-fold return was seen to come nearer (`approaches`). P is chosen such that
# the monodromy matrix M shortens all lengths: |M d| <= rate |d| with |d| = sqrt(d' P d). An orbit
# that enters the region must still return as M foretells. No orbit is taken to belong to an
# attractor because it is near.


NO_ATTRACTOR = -1  # the attractor of an orbit that has come to no known one


class Known(NamedTuple):
    """The known periodic attractors, a row each; those of one system stand together."""

    periods: Any  # (m,) n of nT, integers
    points: Any  # (m, 4) section points (x1, v1, r, s)
    matrices: Any  # (m, 16) monodromy matrices, column by column
    forms: Any  # (m, 16) the symmetric matrices P
    radii: Any  # (m,) of the regions; 0: none
    rates: Any  # (m,) by which M shortens lengths, less than 1
    spans: Any  # (m,) the greatest length sqrt(y' P y) of the section points


class Drawn(NamedTuple):
    """To which known attractor orbits are drawn."""

    attractor: Any  # (orbits,) its row, -1: to none within the periods
    arrival: Any  # (orbits,) the periods until the orbit was in its region, -1: never
    status: Any  # (orbits,) of `codes`


@jit
def norm_of(form, d):
    """Return sqrt(d' P d) of a deviation d (4,)."""
    square = 0.0
    for i in range(4):
        for j in range(4):
            square += form[4 * i + j] * d[i] * d[j]
    return math.sqrt(max(square, 0.0))


@jit
def less(state, point, d):
    """Let d (4,) be the deviation of a state from a point."""
    for i in range(4):
        d[i] = state[i] - point[i]


@jit
def region_with(known, first, stop, state, d):
    """Return which of the attractors `first` to `stop` - 1 has the state in its region, or -1."""
    for a in range(first, stop):
        less(state, known.points[a], d)
        if norm_of(known.forms[a], d) <= known.radii[a]:
            return a
    return int(NO_ATTRACTOR)


@jit
def foretold(known, a, before, after):
    """Tell whether a deviation `before` (4,) returned to `after` as the monodromy matrix foretells.

    The error may be half of what the matrix shortens, so that the return is nearer in any case.
    """
    far = norm_of(known.forms[a], before)
    if far <= TINY * known.spans[a]:
        return norm_of(known.forms[a], after) <= TINY * known.spans[a]
    missed = np.empty(4)
    for i in range(4):
        missed[i] = after[i]
        for j in range(4):
            missed[i] -= known.matrices[a, 4 * j + i] * before[j]
    return norm_of(known.forms[a], missed) <= 0.5 * (1.0 - known.rates[a]) * far


@jit(entry=True)
def approaches(parts, cell, known, a, directions, radius):
    """Tell whether all returns from a sphere around attractor `a` are as its matrix foretells.

    directions (count, 4) of length 1 by its P: deviations of the `radius` in each of them are
    followed for n periods.
    """
    flow, status = cell_flow(parts, cell, PERIOD)
    if status != OK:
        return False
    state, y, before, after = new_state(), np.zeros(4), np.zeros(4), np.zeros(4)
    for k in range(len(directions)):
        for i in range(4):
            y[i] = known.points[a, i] + radius * directions[k, i]
        place_state(flow, y, state)
        less(state, known.points[a], before)  # what is beyond a rigid wall is put on it
        if run_on(flow, no_section(flow.space), known.periods[a], state) != OK:
            return False
        less(state, known.points[a], after)
        if not foretold(known, a, before, after):
            return False
    return True


@jit(entry=True)
def follow_to_known(begin, end, parts, cells, starts, search, drawn):
    """Follow orbits `begin` to `end` - 1 until they belong to a known attractor of their system.

    cells (orbits,) and starts (orbits, 4) at phase zero; search: (rows, known, most), where rows
    (orbits, 2) says which rows of `known` are the attractors of that system, the first one and the
    one after the last, and an orbit is given up after `most` periods. Fills `Drawn`.
    """
    rows, known, most = search
    found, arrival, status = drawn
    now, d, after = np.zeros(4), np.zeros(4), np.zeros(4)
    for lane in range(begin, end):
        flow, code = cell_flow(parts, cells[lane], PERIOD)
        state, p = new_state(), 0
        found[lane], arrival[lane] = int(NO_ATTRACTOR), -1
        if code == OK:
            place_state(flow, starts[lane], state)
        while code == OK and p <= most:
            a = region_with(known, rows[lane, 0], rows[lane, 1], state, d)
            if a == int(NO_ATTRACTOR):
                code = run_on(flow, no_section(flow.space), 1, state)
                p += 1
                continue
            for i in range(4):
                now[i] = d[i]
            code = run_on(flow, no_section(flow.space), known.periods[a], state)
            less(state, known.points[a], after)
            if code == OK and foretold(known, a, now, after):
                found[lane], arrival[lane] = a, p
                break
            p += known.periods[a]
        status[lane] = code
