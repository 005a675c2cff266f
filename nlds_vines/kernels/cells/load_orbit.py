"""An orbit under a load: stretches of equal cells, with jumps of the velocity in between.

Also what its numbers need at the edges of cells: energies, bounds over a cell, contacts.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import REACH, rate_of
from ..motion.load_cells import END, HIGHEST_POWER, LOAD_ROW, OF_CELL, Stretch
from ..motion.response_sums import JUMPS, MOST, OF_V, raise_to
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, says
from ..numerics.fours import bare
from ..orbit.orbit import bounded, on_ground, run, set_mode
from ..scene.codes import (
    BAD_PARAMETERS,
    DIVERGED,
    FLYING,
    OK,
    RESPONSE_COLUMNS,
    TOO_STIFF,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from ..scene.law import contact_energy, wall_like
from ..scene.scene import (
    CellBuffers,
    Ground,
    OrbitBuffers,
    Span,
    Structure,
    allowed,
    damper_of,
    greatest_push,
    joined,
    moved_mass,
    near_constants,
    shaken_by,
    shared,
    structure_under,
)
from ..watch.observe import (
    IMPACT_COLUMNS,
    RELEASE,
    TOUCH,
    Impacts,
    note_energy,
    note_section,
)
from ..watch.response import begin_tally, note_sums, report, work_at
from .cells import (
    begin_limit_log,
    lacks_limit,
    overflowed,
    prepared_cell,
    report_violation,
    start_energy,
    too_stiff,
)

ALIKE = 1.0e-14  # round-off of a cell's length, in units of the largest time
EDGE_SUMS = 5  # columns of the sums (`response.note_sums`)
ROUNDED_UP = 1.0 + 1.0e-9  # by how much round-off may lengthen a cell beyond REACH


class PolynomialLoad(NamedTuple):
    """A force on the structure, a polynomial in each cell, and jumps of its velocity."""

    edges: np.ndarray  # (n + 1,) times [s] of the ends of the cells
    rows: np.ndarray  # (ROW n,) coefficients by the place in a cell [N], cell by cell
    jumps: np.ndarray  # (n + 1,) [m/s]
    sums: np.ndarray  # (OF_CELL n,) of the rows, `load_cells.sums_of`
    shaken: Any  # True where the ground moves: rows are -m1 times its acceleration; else None


@jit
def structure_moved(parts, shaken, cell):
    """Return the `Structure` of a cell under a load in N; shaken: as in `PolynomialLoad`."""
    ps = structure_under(parts, cell)
    return Structure(
        ps.m1, ps.k1, ps.stiffness, ps.damping, 1.0 / ps.m1, 0.0, ps.load,
        shaken_by(shaken, parts.damper),
    )  # fmt: skip


@jit
def touches_on(wall, s):
    """Return True if a contact of depth zero goes on at an approach speed s."""
    if wall is None or says(wall, "AT_ONCE"):
        return False
    return s > 0.0


@jit
def jump(prepared, tally, by, state):
    """Let v1 jump by `by` [m/s]. A contact that began at this instant goes on, without a new touch.

    The jump does the work m1 by (v1 before + v1 after) / 2.
    """
    ps, before, mode = prepared.ps, state[1], state[5]
    state[1] += by
    state[3] += by - shared(ps, by)
    set_mode(prepared.near, prepared.far, prepared.damper, state)
    if state[5] == FLYING and (
        (mode == TOUCH_NEAR and touches_on(prepared.near, state[3]))
        or (mode == TOUCH_FAR and touches_on(prepared.far, -state[3]))
    ):
        state[5] = mode
    if tally is not None:
        tally.row[JUMPS] += 0.5 * ps.m1 * by * (before + state[1])
        tally.row[JUMPS] += (
            0.0
            if ps.shaken is None
            else 0.5 * prepared.damper.m2 * by * (before + state[1] - 2.0 * state[3])
        )
        raise_to(tally.row, int(MOST) + OF_V, state[1])


@jit
def at_edge(prepared, buffers, tally, edge, state):
    """Note the energies, the section and the sums at an edge, after the jump there."""
    ps, damper = prepared.ps, prepared.damper
    if buffers.peak is not None:
        note_energy(ps, damper, buffers.peak, state[0], state[1], state[2], state[3])
    if buffers.section is not None:
        x1, v1, r, s = state[0], state[1], state[2], state[3]
        note_section(joined(damper), buffers.section, edge, x1, v1, r, s)
    note_sums(ps, damper, buffers.sums, edge, tally)


@jit
def rows_behind(rows, edge, count):
    if rows is None:
        return None
    return rows[edge + 1 : edge + 1 + count]


@jit
def buffers_for(impacts, violation, edges, room):
    """Return the buffers of an orbit that `load_numbers` needs, with room for so many impacts.

    impacts, violation: None in a scene without walls or without a limit.
    """
    broken = None if violation is None else np.zeros(3)
    if impacts is None:
        rows: Any = None
    else:
        rows = Impacts(np.empty((room, IMPACT_COLUMNS)), np.zeros(1, np.int64))
    return CellBuffers(
        None, np.empty((edges, 4)), None, rows, None, np.zeros(2), None,
        broken, np.empty(RESPONSE_COLUMNS), np.empty((edges, EDGE_SUMS)),
    )  # fmt: skip


@jit
def fly_under(parts, cell, load, state, buffers):
    """Advance `state` (STATE_SIZE,) from the first edge of a load to the last; return a status.

    parts, cell: as of `cells.run_cell`. buffers: `CellBuffers`, whose section takes the states at
    all edges, after the jumps there.
    """
    if not allowed(parts, cell):
        return BAD_PARAMETERS
    if lacks_limit(buffers.violation, cell.limit):
        return BAD_PARAMETERS
    if not bounded(state[0], state[1], state[2], state[3]):
        return DIVERGED
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    edges, rate = load.edges, rate_of(ps, joined(damper))
    for j in range(len(edges) - 1):
        length = edges[j + 1] - edges[j]
        if not (length > 0.0 and rate * length <= REACH * ROUNDED_UP):
            return TOO_STIFF
    on_ground(damper, state)
    limit_log = begin_limit_log(buffers.violation, cell.limit, state)
    tally = begin_tally(buffers.response, load.shaken, None, ps, state)
    start_energy(ps, damper, buffers.peak, state)
    first, status = 0, OK
    while first < len(edges) - 1 and status == OK:
        # The next stretch: cells of equal length from `first` on, up to a jump.
        jumps = load.jumps
        n, last = len(edges) - 1, first + 1
        h, slack = edges[last] - edges[first], ALIKE * (abs(edges[0]) + abs(edges[len(edges) - 1]))
        while last < n and jumps[last] == 0.0:
            if abs(edges[last + 1] - edges[first] - (last + 1 - first) * h) > slack:
                break
            last += 1
        degree = 0
        for j in range(first, last):
            degree = max(degree, int(load.sums[OF_CELL * j + HIGHEST_POWER]))
        h = (edges[last] - edges[first]) / (last - first)
        rows, sums = bare(load.rows[LOAD_ROW * first :]), bare(load.sums[OF_CELL * first :])
        stretch, count = Stretch(rows, sums, degree, h, edges[first]), last - first
        prepared = prepared_cell(parts, cell, ps, damper, count, 1, stretch)
        lasting = count * stretch.h
        if too_stiff(prepared.held_near, lasting) or too_stiff(prepared.held_far, lasting):
            return TOO_STIFF
        if first == 0:
            set_mode(prepared.near, prepared.far, prepared.damper, state)
            if load.jumps[0] != 0.0:
                jump(prepared, tally, load.jumps[0], state)
            at_edge(prepared, buffers, tally, 0, state)
        wanted = OrbitBuffers(
            limit_log, rows_behind(buffers.section, first, count), None, buffers.impacts,
            buffers.peak, buffers.clearance, None, tally, rows_behind(buffers.sums, first, count),
        )  # fmt: skip
        span = Span(0, 1, (1 if buffers.section is None and buffers.sums is None else count))
        status = run(prepared, wanted, span, state, None, None)
        first += count
        if status == OK and load.jumps[first] != 0.0:
            jump(prepared, tally, load.jumps[first], state)
            at_edge(prepared, buffers, tally, first, state)
    if status == OK:
        report(buffers.response, tally, ps, damper, edges[len(edges) - 1] - edges[0])
        report_violation(buffers.violation, limit_log)
        if overflowed(buffers.peak) or overflowed(buffers.response):
            return DIVERGED
    return status


# ---- The orbit at the edges of the cells: energies, bounds over a cell, contacts -----------------


@jit
def energy_of(ps, x1, v1):
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)


@jit
def structure_energy(ps, section, i):
    return energy_of(ps, section[i, 0], section[i, 1])


@jit
def joint_energy(damper, y):
    """Return the energy [J] of the damper's mass and spring in a state y = (x1, v1, r, s)."""
    if damper is None:
        return 0.0
    v2 = y[1] - y[3]
    return 0.5 * (damper.m2 * v2 * v2 + damper.k2 * y[2] * y[2])


@jit
def elastic_energy(wall, r):
    """Return the elastic energy [J] of the contact with a wall at r; 0 without a wall."""
    if wall is None:
        return 0.0
    return contact_energy(wall, max(r - wall.gap, 0.0))


@jit
def energy_stored(ps, damper, walls, section, i, by):
    """Return the total energy [J] at an edge before v1 jumped by `by` [m/s].

    damper: of `damper_of`; walls: the near and the far one. The potential energy of a constant load
    is 0 at x1 = 0.
    """
    x1, v1, r, s = state_at(ps, joined(damper), section, i, by)
    if is_a(damper, Ground):
        r = x1
    in_contacts = elastic_energy(walls[0], r) + elastic_energy(walls[1], -r)
    energy = energy_of(ps, x1, v1) + joint_energy(joined(damper), (x1, v1, r, s))
    return energy + (0.0 if ps.load is None else -ps.m1 * ps.load * x1) + in_contacts


@jit
def state_at(ps, damper, section, i, by):
    """Return the state (x1, v1, r, s) at an edge before v1 jumped by `by` [m/s]."""
    x1, v1 = section[i, 0], section[i, 1] - by
    if damper is None:
        return x1, v1, 0.0, 0.0
    s = section[i, 1] - section[i, 3]
    return x1, v1, x1 - section[i, 2] + damper.rest, s - (by - shared(ps, by))


@jit
def ends_of_cell(ps, damper, load, section, i):
    """Return `work_at` both ends of a cell, before a jump at its end, and two bounds over the cell.

    The bounds are of the total energy [J], with the work that the load may do, and of the fourth
    derivative of E1 by the place in the cell. The energy scale S = sqrt(2 E) grows by the force
    alone, so each derivative of the scaled state is at most REACH times the one before plus that of
    the force (`sums_of`). A contact adds no energy.
    """
    h, at = load.edges[i + 1] - load.edges[i], OF_CELL * i
    y = state_at(ps, damper, section, i, 0.0)
    z = state_at(ps, damper, section, i + 1, load.jumps[i + 1])
    begin = work_at(ps, damper, y, load.rows[LOAD_ROW * i])
    end = work_at(ps, damper, z, load.sums[at + END])
    unit = h * math.sqrt(moved_mass(ps, damper))
    push = unit * greatest_push(ps.load, ps.force * load.sums[at])
    most = math.sqrt(2.0 * (begin[0] + joint_energy(damper, y))) + push
    first = REACH * most + push
    second = REACH * first + unit * ps.force * load.sums[at + 1]
    third = REACH * second + unit * ps.force * load.sums[at + 2]
    fourth = REACH * third + unit * ps.force * load.sums[at + 3]
    bend = most * fourth + 4.0 * first * third + 3.0 * second * second
    return begin, end, 0.5 * most * most, bend


@jit
def on_wall(near, far, damper, section, i):
    """Return True if an orbit touches a wall at an edge, or is beyond it."""
    x1 = section[i, 0]
    r = x1 if damper is None else x1 - section[i, 2] + damper.rest
    return beyond(near, r) or beyond(far, -r)


@jit
def beyond(wall, r):
    if wall is None:
        return False
    return r >= wall.gap


@jit
def walls_of(parts, cell, damper):
    near = wall_like(parts.near, cell.near, damper, near_constants(parts.apart, cell))
    return near, wall_like(parts.far, cell.far, damper, cell)


@jit
def touch_by(impacts, j, time):
    """Return the index of the last impact that began by a time [s], searched from j; -1 if none."""
    if impacts is None:
        return -1
    while j + 1 < impacts.filled[0] and impacts.data[j + 1, TOUCH] <= time:
        j += 1
    while j >= 0 and impacts.data[j, TOUCH] > time:
        j -= 1
    return j


@jit
def lasts_until(impacts, j, time):
    """Return True if impact j exists and is not over before a time [s]; no release yet is NaN."""
    if impacts is None:
        return False
    return j >= 0 and not impacts.data[j, RELEASE] < time
