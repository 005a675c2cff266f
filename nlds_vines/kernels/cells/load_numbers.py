"""The response quantities of orbits under loads: last times, energies, the rms of x1.

They follow from the states and energies at the edges of the load's cells and from the impacts, once
the orbit has been computed. `fly_orbits` computes many orbits with their quantities.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import DRIVE, ORDER, rate_of
from ..motion.load_cells import LOAD_ROW, OF_CELL, fill_drive_from, sums_of
from ..numerics.compiling import jit
from ..numerics.roots import ROOT_STEPS, highest, narrowed, secant
from ..orbit.variations import new_state
from ..scene.codes import OK
from ..scene.drive import Moment
from ..scene.scene import accelerations, damper_of, joined, unloaded
from ..watch.observe import TOUCH
from .load_orbit import (
    ALIKE,
    PolynomialLoad,
    buffers_for,
    ends_of_cell,
    energy_of,
    energy_stored,
    fly_under,
    lasts_until,
    on_wall,
    state_at,
    structure_energy,
    structure_moved,
    touch_by,
    walls_of,
)

# --------------------------------------------------------------------------------------------------
# When E1 last exceeds a level, and when it is largest: places between the edges.
#
# The results do not depend on where the edges are. The energies and their rates at the two ends of
# a cell and a bound of the fourth derivative bound E1 over the cell by a cubic (`roots.highest`).
# Where E1 may exceed the level, the cell's own Taylor polynomial is sampled at the edges of
# SUBCELLS equal parts; a shorter excursion between two of them is not seen. A cell that a contact
# meets is flown again in SUBCELLS cells, unless the contact begins in it and the bound of its
# energy is at most the level. A place of a cell runs from 0 to 1.


SUBCELLS = 64  # equal parts of a cell, or of an interval of one, that are compared
LOOKS = 3  # times that a cell with a contact is divided
MOST_LOOKS = 7  # the same at a touch, where E1 may jump: it is then known to 64^-7 of a cell
UNREAD_ROOM = 1  # room for the impacts of a cell that is flown again; they are not read
SAME_PLACE = 1.0e-12  # of a cell: places nearer than this count as one
NO_PLACE = -1.0  # E1 exceeds the level nowhere in a cell
NEARLY = 1.0 - 1e-12  # share of the largest E1 that counts as the largest, for round-off


# ---- a cell by its polynomial --------------------------------------------------------------------


@jit
def motion_in(ps, damper, load, section, i):
    """Return the Taylor coefficients (LOAD_ROW, 2) of x1 and v1 over cell i without a contact."""
    motion, h = np.empty((LOAD_ROW, 2)), load.edges[i + 1] - load.edges[i]
    state = state_at(ps, damper, section, i, 0.0)
    row = LOAD_ROW * i
    x1, v1, r, s = state
    motion[0, 0], motion[0, 1] = x1, v1
    dv, ds = accelerations(ps, damper, x1, v1, r, s, load.rows[row], 0.0)
    for k in range(1, LOAD_ROW):
        g = h / k
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        motion[k, 0], motion[k, 1] = x1, v1
        if k < ORDER:
            dv, ds = accelerations(unloaded(ps), damper, x1, v1, r, s, load.rows[row + k], 0.0)
    return motion


@jit
def excess_in_cell(ps, motion, level, x):
    """Return E1 at a place x of a cell less a level [J]; dE1/dx if the level is None."""
    x1, v1 = motion[ORDER, 0], motion[ORDER, 1]
    dx, dv = 0.0, 0.0
    for k in range(ORDER - 1, -1, -1):
        dx, dv = dx * x + x1, dv * x + v1
        x1, v1 = x1 * x + motion[k, 0], v1 * x + motion[k, 1]
    if level is None:
        return ps.m1 * v1 * dv + ps.k1 * x1 * dx
    return energy_of(ps, x1, v1) - level


@jit
def root_in_cell(ps, motion, level, low, high):
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
    """Return the last place of a cell at which E1 exceeds a level, or NO_PLACE.

    SUBCELLS + 1 samples are searched from the end, and the place is refined by a root. It is 1 if
    E1 exceeds the level at the end.
    """
    i = SUBCELLS
    while i >= 0 and not excess_in_cell(ps, motion, level, i / SUBCELLS) > 0.0:
        i -= 1
    if i < 0:
        return NO_PLACE
    if i == SUBCELLS:
        return 1.0
    return root_in_cell(ps, motion, level, i / SUBCELLS, (i + 1) / SUBCELLS)


@jit
def place_of_most(ps, motion):
    """Return the place of a cell at which E1 is largest: a root of dE1/dt, or a sample."""
    best, most = 0, -math.inf
    for i in range(SUBCELLS + 1):
        e1 = excess_in_cell(ps, motion, 0.0, i / SUBCELLS)
        if e1 > most:
            best, most = i, e1
    low, high = max(best - 1, 0) / SUBCELLS, min(best + 1, SUBCELLS) / SUBCELLS
    rising = excess_in_cell(ps, motion, None, low) > 0.0
    if rising and excess_in_cell(ps, motion, None, high) < 0.0:
        return root_in_cell(ps, motion, None, low, high)
    return best / SUBCELLS


# ---- a cell in subcells --------------------------------------------------------------------------


@jit
def flown_in_subcells(parts, cell, load, i, within, start, buffers):
    """Fly an interval of cell i again in SUBCELLS; return the status and the states at their edges.

    within: (place, length in cells) of the interval; start: the state (x1, v1, r, s) there.
    """
    # the load of SUBCELLS equal cells, with edges from 0 on
    length = load.edges[i + 1] - load.edges[i]
    sub_length, table = within[1] * length / SUBCELLS, np.zeros(DRIVE + LOAD_ROW)
    edges, rows = np.empty(SUBCELLS + 1), np.empty(LOAD_ROW * SUBCELLS)
    edges[0] = 0.0
    for m in range(SUBCELLS):
        place = within[0] + m * sub_length / length
        at = Moment(load.rows, LOAD_ROW * i, ORDER, place, length)
        fill_drive_from(table, at, sub_length)
        edges[m + 1] = (m + 1) * sub_length
        for k in range(LOAD_ROW):
            rows[LOAD_ROW * m + k] = table[DRIVE + k]
    finer = PolynomialLoad(edges, rows, np.zeros(SUBCELLS + 1), sums_of(rows), load.shaken)
    state = new_state()
    for j in range(4):
        state[j] = start[j]
    again = buffers_for(buffers.impacts, buffers.violation, len(finer.edges), UNREAD_ROOM)
    return fly_under(parts, cell, finer, state, again), again.section


@jit
def touch_within(load, i, begin, width, buffers):
    """Return the time [s] of the last touch in an interval of cell i, NaN if there is none."""
    if buffers.impacts is None:
        return math.nan
    first, h, data = load.edges[i], load.edges[i + 1] - load.edges[i], buffers.impacts.data
    j = touch_by(buffers.impacts, -1, first + h * (begin + width))
    return data[j, TOUCH] if j >= 0 and data[j, TOUCH] >= first + h * begin else math.nan


@jit
def time_at(load, i, place, buffers):
    """Return the time [s] of a place of cell i; that of a touch, if one is there."""
    time = touch_within(load, i, place - SAME_PLACE, 2.0 * SAME_PLACE, buffers)
    if math.isnan(time):
        time = load.edges[i] + (load.edges[i + 1] - load.edges[i]) * place
    return time


@jit
def place_in_contact(parts, cell, load, i, level, buffers):
    """Return (place, E1 [J], status) of cell i, which a contact meets.

    The place is the last one at which E1 exceeds a level, or NO_PLACE; if the level is None, that
    of the largest E1. The cell is flown again in SUBCELLS, then the one or the two subcells about
    the place, LOOKS times in all, and MOST_LOOKS times if a touch lies there.
    """
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    section, edge, begin, width = buffers.section, i, 0.0, 1.0
    place, e1 = NO_PLACE, 0.0
    for look in range(MOST_LOOKS):
        if look >= LOOKS and math.isnan(touch_within(load, i, begin, width, buffers)):
            break
        start = state_at(ps, joined(damper), section, edge, 0.0)
        status, section = flown_in_subcells(parts, cell, load, i, (begin, width), start, buffers)
        if status != OK:
            return place, e1, status
        if level is None:
            best = 0
            for k in range(1, len(section)):
                if structure_energy(ps, section, k) > structure_energy(ps, section, best):
                    best = k
            place, e1 = begin + width * (best / SUBCELLS), structure_energy(ps, section, best)
            edge, stop = max(best - 1, 0), min(best + 1, SUBCELLS)
        else:
            edge = len(section) - 1
            while edge >= 0 and not structure_energy(ps, section, edge) > level:
                edge -= 1
            if edge < 0:
                return NO_PLACE, level, OK
            if edge == SUBCELLS:
                return begin + width, level, OK
            stop = edge + 1
        begin += width * (edge / SUBCELLS)
        width *= (stop - edge) / SUBCELLS
    if level is not None:
        over = structure_energy(ps, section, edge) - level
        under = level - structure_energy(ps, section, edge + 1)
        place, e1 = begin + width * (over / (over + under)), level
    return place, e1, OK


# ---- times ---------------------------------------------------------------------------------------


@jit
def may_exceed(level, h, ends, touched, begun):
    """Return True if E1 may exceed a level in a cell of h [s] with `ends_of_cell`.

    touched: whether a contact meets the cell; begun: whether it began before the cell, so that the
    energy at the beginning lacks its elastic energy.
    """
    begin, end, whole, bend = ends
    if touched:
        return begun or whole > level
    return highest(begin[0], end[0], h * begin[2], h * end[2], bend) > level


@jit
def last_above(parts, cell, load, level, buffers, last):
    """Return (time [s], cell, status) where E1 last exceeds a level.

    The time is NaN if E1 exceeds the level at the end, or never exceeds a level of 0. It is that of
    the first edge if E1 exceeds the level only before a jump there. last: the cell in which E1 last
    exceeds a lower level, or the last cell.
    """
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    section, edges, impacts = buffers.section, load.edges, buffers.impacts
    near, far = walls_of(parts, cell, damper)
    j = -1
    if not structure_energy(ps, section, len(edges) - 1) <= level:
        return math.nan, last, OK
    for i in range(last, -1, -1):
        h, ends = edges[i + 1] - edges[i], ends_of_cell(ps, joined(damper), load, section, i)
        j = touch_by(impacts, j, edges[i + 1])
        begun = on_wall(near, far, joined(damper), section, i)
        touched = begun or lasts_until(impacts, j, edges[i])
        if may_exceed(level, h, ends, touched, begun):
            if touched:
                place, _, status = place_in_contact(parts, cell, load, i, level, buffers)
            else:
                motion, status = motion_in(ps, joined(damper), load, section, i), OK
                place = last_place_above(ps, motion, level)
            if status != OK or place != NO_PLACE:
                return time_at(load, i, place, buffers), i, status
    return edges[0] if level > 0.0 else math.nan, 0, OK


@jit
def time_of_largest(parts, cell, load, buffers):
    """Return the first time [s] at which E1 is NEARLY its largest value, and a status.

    That value is buffers.peak[0]; it may occur at the first edge, before or after a jump there. In
    a cell without a contact the time is a root of dE1/dt or a sample. In one with a contact it is
    known to 2e-5 of the cell, at a touch to 2e-11.
    """
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    section, edges, impacts = buffers.section, load.edges, buffers.impacts
    near, far = walls_of(parts, cell, damper)
    x1, v1, _, _ = state_at(ps, joined(damper), section, 0, load.jumps[0])
    most = max(energy_of(ps, x1, v1), structure_energy(ps, section, 0))
    time, level, j = edges[0], NEARLY * buffers.peak[0], -1
    for i in range(len(edges) - 1):
        if most >= level:
            break
        h, ends = edges[i + 1] - edges[i], ends_of_cell(ps, joined(damper), load, section, i)
        begun = on_wall(near, far, joined(damper), section, i)
        j = touch_by(impacts, j, edges[i + 1])
        touched = begun or lasts_until(impacts, j, edges[i])
        if may_exceed(level, h, ends, touched, begun):
            if touched:
                place, e1, status = place_in_contact(parts, cell, load, i, None, buffers)
                if status != OK:
                    return time, status
            else:
                motion = motion_in(ps, joined(damper), load, section, i)
                place = place_of_most(ps, motion)
                e1 = excess_in_cell(ps, motion, 0.0, place)
            if e1 > most:
                time, most = time_at(load, i, place, buffers), e1
        after = structure_energy(ps, section, i + 1)
        if after > most:
            time, most = edges[i + 1], after
    return time, OK


# ---- the response quantities of an orbit ---------------------------------------------------------


# Columns of an orbit's quantities:
#   LAST_TIMES 3 last times [s] at which E1 exceeds shares of its largest; NaN: it does at the end
#   DECAY_TIME   time [s] from the largest E1 to the second of them
#   IMPACTS      number of impacts
#   ENERGY_IN    energy [J] of the start and of the load
#   DISSIPATED 3 energy [J] that c1, c2 and contacts have dissipated
#   BALANCE      largest |in - stored - dissipated| over the largest energy that came in
#   START        energy of the start [J], with that of contacts and of a constant load
#   RMS          of x1 [m], without the time to settle
LAST_TIMES, DECAY_TIME, IMPACTS, ENERGY_IN, DISSIPATED, BALANCE = 0, 3, 4, 5, 6, 9
START, RMS, ORBIT_NUMBERS = 10, 11, 12


class Asked(NamedTuple):
    """The levels of E1 and the settling time of the quantities."""

    shares: Any  # (3,) of the largest E1, rising; (0,): no quantities are wanted
    settle: float  # time [s] that the rms of x1 leaves out


@jit
def rms_of_x1(edges, sums, settle):
    """Return the rms of x1 [m] from the first edge at or after `settle` [s] to the end."""
    first, last = 0, len(edges) - 1
    begin = settle - ALIKE * edges[last]
    while first < last - 1 and edges[first] < begin:
        first += 1
    return math.sqrt((sums[last, 4] - sums[first, 4]) / (edges[last] - edges[first]))


@jit
def fill_numbers(parts, cell, load, asked, buffers, numbers):
    """Fill the quantities (ORBIT_NUMBERS,) of an orbit of `load_orbit.fly_under`; return a status.

    asked: `Asked`; buffers: of `buffers_for`.
    """
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    numbers[:] = math.nan
    most, edges = buffers.peak[0], load.edges
    # the energy balance at all edges
    walls = walls_of(parts, cell, damper)
    section, sums, end = buffers.section, buffers.sums, len(load.edges) - 1
    begin = energy_stored(ps, damper, walls, section, 0, load.jumps[0])
    scale, error = abs(begin), 0.0
    for i in range(end + 1):
        energy_in, dissipated = begin + sums[i, 0], sums[i, 1] + sums[i, 2] + sums[i, 3]
        scale = max(scale, abs(energy_in))
        stored = energy_stored(ps, damper, walls, section, i, 0.0)
        error = max(error, abs(energy_in - stored - dissipated))
    numbers[START], numbers[ENERGY_IN] = begin, begin + sums[end, 0]
    for k in range(3):
        numbers[DISSIPATED + k] = sums[end, 1 + k]
    numbers[BALANCE] = error / scale if scale > 0.0 else 0.0
    last = len(edges) - 2
    for i in range(len(asked.shares)):
        level = asked.shares[i] * most
        numbers[LAST_TIMES + i], last, status = last_above(parts, cell, load, level, buffers, last)
        if status != OK:
            return status
    largest, status = time_of_largest(parts, cell, load, buffers)
    if status != OK:
        return status
    numbers[DECAY_TIME] = numbers[LAST_TIMES + 1] - largest
    if buffers.impacts is not None:
        numbers[IMPACTS] = buffers.impacts.filled[0]
    numbers[RMS] = rms_of_x1(edges, buffers.sums, asked.settle)
    return OK


# ---- Many orbits under loads, each with its quantities -------------------------------------------
#
# Orbits share nothing but the loads, which none of them changes, so that results do not depend on
# how a scan is cut into blocks and pieces.


SPARE_ROOM = 64  # for impacts beside one for each cell; an orbit with more is computed again


class Loads(NamedTuple):
    """The loads of many orbits; what several have in common stands once."""

    edges: Any  # of all loads, one load after the other
    rows: Any  # coefficients, one row for each edge; the last of each load has no meaning
    sums: Any  # of the rows, `load_cells.sums_of`
    jumps: Any  # of all orbits, one orbit after the other
    first: Any  # (orbits,) index of an orbit's first edge in `edges`
    after: Any  # (orbits,) index after its last one
    blow: Any  # (orbits,) index of its first jump in `jumps`
    shaken: Any  # as of `PolynomialLoad`


class LoadResults(NamedTuple):
    numbers: Any  # (orbits, `load_numbers.ORBIT_NUMBERS`)
    response: Any  # (orbits, `codes.RESPONSE_COLUMNS`)
    peak: Any  # (orbits, 2) largest E1 and E2 [J]
    violation: Any  # (orbits, 3), None in a scene without a limit
    impacts: Any  # `Impacts` of the first orbit, as many as there is room for; None without walls
    states: Any  # (orbits or 0, edges, 4) at the edges, in the user's coordinates
    sums: Any  # (orbits or 0, edges, `load_orbit.EDGE_SUMS`)
    status: Any  # (orbits,)


@jit
def flown(parts, cell, load, start, results):
    """Follow an orbit from a start (x1, v1, r, s); return its status and its buffers.

    If there are more impacts than room, the orbit is computed again with room for all.
    """
    state, room = new_state(), SPARE_ROOM + len(load.edges)
    while True:
        buffers = buffers_for(results.impacts, results.violation, len(load.edges), room)
        state[:] = 0.0
        for i in range(4):
            state[i] = start[i]
        status = fly_under(parts, cell, load, state, buffers)
        if results.impacts is None:
            return status, buffers
        if status != OK or buffers.impacts.filled[0] <= room:
            return status, buffers
        room = buffers.impacts.filled[0]


@jit
def copy(row, into):
    for i in range(len(row)):
        into[i] = row[i]


@jit
def copy_impacts(impacts, into):
    """Copy the impacts of an orbit as far as there is room, and note how many there are."""
    count = impacts.filled[0]
    into.filled[0] = count
    for j in range(min(count, len(into.data))):
        copy(impacts.data[j], into.data[j])


@jit(entry=True)
def fill_rates(parts, cells, rates):
    """Fill bounds (orbits,) [1/s] on the rates of the linear motion of each orbit's system."""
    for i in range(len(cells)):
        ps, damper = structure_moved(parts, None, cells[i]), damper_of(parts.damper, cells[i])
        rates[i] = rate_of(ps, joined(damper))


@jit(entry=True)
def fly_orbits(begin, end, parts, cells, loads, starts, asked, results):
    """Follow orbits `begin` to `end` - 1 of `cells` (orbits,) from starts (orbits, 4).

    starts: (x1, v1, r, s); parts: `Parts`; loads: `Loads`; asked: `Asked`; results: `LoadResults`.
    If the status of an orbit is not OK, its results have no meaning.
    """
    for i in range(begin, end):
        first, after, blow = loads.first[i], loads.after[i], loads.blow[i]
        load = PolynomialLoad(
            loads.edges[first:after],
            loads.rows[LOAD_ROW * first : LOAD_ROW * (after - 1)],
            loads.jumps[blow : blow + (after - first)],
            loads.sums[OF_CELL * first : OF_CELL * (after - 1)],
            loads.shaken,
        )
        cell = cells[i]
        status, buffers = flown(parts, cell, load, starts[i], results)
        if status == OK and len(asked.shares) > 0:
            status = fill_numbers(parts, cell, load, asked, buffers, results.numbers[i])
        results.status[i] = status
        copy(buffers.response, results.response[i])
        copy(buffers.peak, results.peak[i])
        if results.violation is not None:
            copy(buffers.violation, results.violation[i])
        if results.impacts is not None and i == 0 and status == OK:
            copy_impacts(buffers.impacts, results.impacts)
        if status == OK and i < len(results.states):
            for k in range(len(load.edges)):
                copy(buffers.section[k], results.states[i, k])
                copy(buffers.sums[k], results.sums[i, k])
