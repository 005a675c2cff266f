"""When E1 under a load last exceeds a level, and when it is largest: places between the edges.

The numbers do not depend on where the edges are. From the energies and their rates at its two ends
a cell is bounded by a cubic (`roots`); where it may exceed the level, it is looked at by the
motion's own polynomial. Where a contact meets it, it is flown once more, in parts: between its two
ends and the contact E1 changes by what its rates tell, and within one it is largest at touch or
release, as the speed changes there one way.
"""

from __future__ import annotations

import math

import numpy as np

from ..motion.bounds import REACH
from ..motion.flight import DRIVE, ORDER
from ..motion.load_cells import END, LOAD_ROW, OF_CELL, fill_drive_from, sums_of
from ..numerics.compiling import jit
from ..numerics.roots import ROOT_STEPS, highest, narrowed, secant
from ..orbit.orbit import STATE_SIZE
from ..scene.codes import OK
from ..scene.drive import Moment
from ..scene.scene import accelerations, damper_of, joined, unloaded
from ..watch.observe import RELEASE, TOUCH
from ..watch.peaks import work_at
from .load_orbit import Load, apart_after, buffers_for, fly_under, structure_moved

PARTS = 64  # of a cell that is looked at, each time that it is looked at more closely
LOOKS = 3  # how often that is, where there is a contact
MOST_AGAIN = 64  # impacts of such a cell that are noted
NO_PLACE = -1.0  # the place where E1 exceeds no level
# Of both bodies' energy at the ends of a cell, a bound of the fourth derivative of E1 by the place:
# 16 rate^4 h^4 times that energy, and as much again for what comes in within the cell.
BENT = 32.0 * REACH * REACH * REACH * REACH


# ---- edges and contacts --------------------------------------------------------------------------


@jit
def structure_energy(ps, section, i):
    """Return E1 [J] at an edge."""
    x1, v1 = section[i, 0], section[i, 1]
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)


@jit
def joint_energy(damper, y):
    """Return the energy [J] of the damper's motion and of its spring in a state (x1, v1, r, s)."""
    if damper is None:
        return 0.0
    v2 = y[1] - y[3]
    return 0.5 * (damper.m2 * v2 * v2 + damper.k2 * y[2] * y[2])


@jit
def state_at(ps, damper, section, i, by):
    """Return the state (x1, v1, r, s) at an edge before v1 jumped by so much."""
    x1, v1 = section[i, 0], section[i, 1] - by
    if damper is None:
        return x1, v1, 0.0, 0.0
    s = section[i, 1] - section[i, 3]
    return x1, v1, x1 - section[i, 2] + damper.rest, s - apart_after(ps, by)


@jit
def ends_of_cell(ps, damper, load, section, i):
    """Return `work_at` both ends of a cell, before a jump at its end, and the energy [J] of all.

    That is the larger one of both ends.
    """
    y = state_at(ps, damper, section, i, 0.0)
    z = state_at(ps, damper, section, i + 1, load.jumps[i + 1])
    begin = work_at(ps, damper, y, load.rows[LOAD_ROW * i])
    end = work_at(ps, damper, z, load.sums[OF_CELL * i + END])
    return begin, end, max(begin[0] + joint_energy(damper, y), end[0] + joint_energy(damper, z))


@jit
def impacts_noted(impacts):
    """Return the number of impacts. impacts: `observe.Impacts`, or None without walls."""
    if impacts is None:
        return 0
    return impacts.filled[0]


@jit
def touch_by(impacts, j, time):
    """Return the last impact that has begun by a time [s], counted back from j; -1: none has."""
    if impacts is None:
        return -1
    while j >= 0 and impacts.data[j, TOUCH] > time:
        j -= 1
    return j


@jit
def lasts_until(impacts, j, time):
    """Tell whether impact j, if there is one, is not over before a time [s].

    The release of a contact that still lasts is NaN.
    """
    if impacts is None:
        return False
    return j >= 0 and not impacts.data[j, RELEASE] < time


@jit
def meets_contact(impacts, begin, end):
    """Tell whether a contact meets the times from `begin` to `end` [s], both included."""
    return lasts_until(impacts, touch_by(impacts, impacts_noted(impacts) - 1, end), begin)


# ---- a cell by its polynomial --------------------------------------------------------------------


@jit
def fill_motion(ps, damper, state, rows, row, h, motion):
    """Fill (LOAD_ROW, 2) Taylor coefficients of x1 and v1 over a cell without a contact.

    state: (x1, v1, r, s) at its beginning; row: the place of its load in `rows`; h: its length [s].
    """
    x1, v1, r, s = state
    motion[0, 0], motion[0, 1] = x1, v1
    dv, ds = accelerations(ps, damper, x1, v1, r, s, rows[row], 0.0)
    for k in range(1, LOAD_ROW):
        g = h / k
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        motion[k, 0], motion[k, 1] = x1, v1
        if k < ORDER:
            dv, ds = accelerations(unloaded(ps), damper, x1, v1, r, s, rows[row + k], 0.0)


@jit
def motion_in(ps, damper, load, section, i):
    """Return these of cell i."""
    motion, h = np.empty((LOAD_ROW, 2)), load.edges[i + 1] - load.edges[i]
    state = state_at(ps, damper, section, i, 0.0)
    fill_motion(ps, damper, state, load.rows, LOAD_ROW * i, h, motion)
    return motion


@jit
def excess_in_cell(ps, motion, level, x):
    """Return by how much E1 exceeds a level [J] at a place; without a level its rate by x."""
    x1, v1 = motion[ORDER, 0], motion[ORDER, 1]
    dx, dv = 0.0, 0.0
    for k in range(ORDER - 1, -1, -1):
        dx, dv = dx * x + x1, dv * x + v1
        x1, v1 = x1 * x + motion[k, 0], v1 * x + motion[k, 1]
    if level is None:
        return ps.m1 * v1 * dv + ps.k1 * x1 * dx
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1) - level


@jit
def root_in_cell(ps, motion, level, low, high):
    """Return where that changes its sign between two places."""
    f0, f1 = excess_in_cell(ps, motion, level, low), excess_in_cell(ps, motion, level, high)
    x = low
    for _ in range(ROOT_STEPS):
        before, x = x, secant(low, high, f0, f1)
        f = excess_in_cell(ps, motion, level, x)
        if f == 0.0 or x == before:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    return x


@jit
def last_place_above(ps, motion, level):
    """Return the last place of a cell at which E1 is above a level, or NO_PLACE."""
    i = PARTS
    while i >= 0 and not excess_in_cell(ps, motion, level, i / PARTS) > 0.0:
        i -= 1
    if i < 0:
        return NO_PLACE
    if i == PARTS:
        return 1.0
    return root_in_cell(ps, motion, level, i / PARTS, (i + 1) / PARTS)


@jit
def place_of_most(ps, motion):
    """Return the place of a cell at which E1 is largest."""
    best, most = 0, -math.inf
    for i in range(PARTS + 1):
        e1 = excess_in_cell(ps, motion, 0.0, i / PARTS)
        if e1 > most:
            best, most = i, e1
    low, high = max(best - 1, 0) / PARTS, min(best + 1, PARTS) / PARTS
    rising = excess_in_cell(ps, motion, None, low) > 0.0
    if rising and excess_in_cell(ps, motion, None, high) < 0.0:
        return root_in_cell(ps, motion, None, low, high)
    return best / PARTS


# ---- a cell in parts -----------------------------------------------------------------------------


@jit
def parts_of_cell(load, row, begin, h, table):
    """Return a load of PARTS cells that make up a part of a cell.

    begin: where it begins, as (place in the cell, length of the cell [s]); h: its length [s]. The
    edges count from 0. table: scratch (DRIVE + LOAD_ROW,).
    """
    place, length = begin
    part = h / PARTS
    edges, rows = np.empty(PARTS + 1), np.empty(LOAD_ROW * PARTS)
    edges[0] = 0.0
    for i in range(PARTS):
        at = Moment(load.rows, row, ORDER, place + i * part / length, length, 1.0)
        fill_drive_from(table, at, part)
        edges[i + 1] = (i + 1) * part
        for k in range(LOAD_ROW):
            rows[LOAD_ROW * i + k] = table[DRIVE + k]
    return Load(edges, rows, np.zeros(PARTS + 1), sums_of(rows), load.shaken)


@jit
def flown_in_parts(parts, cell, load, i, within, start, buffers):
    """Fly a part of cell i again; return the status and the states at the ends of its own parts.

    within: (place, length in cells) of the part; start: the state (x1, v1, r, s) there.
    """
    length = load.edges[i + 1] - load.edges[i]
    table, state = np.zeros(DRIVE + LOAD_ROW), np.zeros(STATE_SIZE)
    finer = parts_of_cell(load, LOAD_ROW * i, (within[0], length), within[1] * length, table)
    for j in range(4):
        state[j] = start[j]
    again = buffers_for(buffers.impacts, buffers.violation, len(finer.edges), MOST_AGAIN)
    return fly_under(parts, cell, finer, state, again), again.section


@jit
def last_edge_above(ps, section, level):
    """Return the last edge at which E1 is above a level, -1 where there is none."""
    i = len(section) - 1
    while i >= 0 and not structure_energy(ps, section, i) > level:
        i -= 1
    return i


@jit
def largest_edge(ps, section):
    """Return the first edge at which E1 is largest."""
    best = 0
    for i in range(1, len(section)):
        if structure_energy(ps, section, i) > structure_energy(ps, section, best):
            best = i
    return best


@jit
def last_in_contact(parts, cell, load, i, level, buffers):
    """Return the last place of cell i, which a contact meets, where E1 is above a level; a status.

    It is flown again, in parts, and then the part in which that is so, and again.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    section, edge, begin, width = buffers.section, i, 0.0, 1.0
    for _ in range(LOOKS):
        start = state_at(ps, joined(damper), section, edge, 0.0)
        status, section = flown_in_parts(parts, cell, load, i, (begin, width), start, buffers)
        if status != OK:
            return NO_PLACE, status
        edge = last_edge_above(ps, section, level)
        if edge < 0:
            return NO_PLACE, OK
        if edge == PARTS:
            return begin + width, OK
        width /= PARTS
        begin += edge * width
    over = structure_energy(ps, section, edge) - level
    under = level - structure_energy(ps, section, edge + 1)
    return begin + width * (over / (over + under)), OK


# ---- times ---------------------------------------------------------------------------------------


@jit
def may_exceed(level, h, ends, touched):
    """Tell whether E1 may exceed a level within a cell of h [s], or at its ends (`ends_of_cell`).

    touched: whether a contact meets it.
    """
    begin, end, whole = ends
    if touched:
        change = h * max(abs(begin[2]), abs(end[2]))
        return highest(begin[0] + change, end[0] + change, 0.0, 0.0, BENT * whole) > level
    return highest(begin[0], end[0], h * begin[2], h * end[2], BENT * whole) > level


@jit
def last_above(parts, cell, load, level, buffers):
    """Return the last time [s] at which E1 exceeds a level, and a status; NaN: it does at the end.

    Or never does.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    section, edges, impacts = buffers.section, load.edges, buffers.impacts
    j = impacts_noted(impacts) - 1
    if structure_energy(ps, section, len(edges) - 1) > level:
        return math.nan, OK
    for i in range(len(edges) - 2, -1, -1):
        h, ends = edges[i + 1] - edges[i], ends_of_cell(ps, joined(damper), load, section, i)
        j = touch_by(impacts, j, edges[i + 1])
        touched = lasts_until(impacts, j, edges[i])
        if may_exceed(level, h, ends, touched):
            if touched:
                place, status = last_in_contact(parts, cell, load, i, level, buffers)
            else:
                motion, status = motion_in(ps, joined(damper), load, section, i), OK
                place = last_place_above(ps, motion, level)
            if status != OK or place != NO_PLACE:
                return edges[i] + h * place, status
    return math.nan, OK


@jit
def cell_of_largest(ps, damper, load, section, top):
    """Return the cell beside edge `top`, where E1 is largest, in which it is larger; -1: none."""
    if load.jumps[top] == 0.0:
        if top < len(load.edges) - 1:
            begin, _, _ = ends_of_cell(ps, damper, load, section, top)
            if begin[2] > 0.0:
                return top
        if top > 0:
            _, end, _ = ends_of_cell(ps, damper, load, section, top - 1)
            if end[2] < 0.0:
                return top - 1
    return -1


@jit
def time_of_largest(parts, cell, load, top, buffers):
    """Return the time [s] at which E1 is largest, beside the edge `top` where it is, and a status.

    Where a contact meets that cell, to a part of it.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    section, edges = buffers.section, load.edges
    i = cell_of_largest(ps, joined(damper), load, section, top)
    if i < 0:
        return edges[top], OK
    if meets_contact(buffers.impacts, edges[i], edges[i + 1]):
        start = state_at(ps, joined(damper), section, i, 0.0)
        status, section = flown_in_parts(parts, cell, load, i, (0.0, 1.0), start, buffers)
        place = largest_edge(ps, section) / PARTS
    else:
        status = OK
        place = place_of_most(ps, motion_in(ps, joined(damper), load, section, i))
    return edges[i] + place * (edges[i + 1] - edges[i]), status
