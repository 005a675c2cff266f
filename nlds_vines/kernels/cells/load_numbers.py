"""What is told of an orbit under a load in numbers: last times, energies, captures.

They are found from the states and the energies at the edges of the load's cells and from the
impacts, when the orbit is over. Where E1 is last above a level is a root of the motion's polynomial
in the cell after the last such edge; where a contact lies there, the cell is flown once more, in
parts.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import DRIVE, ORDER
from ..motion.load_cells import LOAD_ROW, fill_drive_from, sums_of
from ..numerics.compiling import jit
from ..numerics.roots import ROOT_STEPS, narrowed, secant
from ..orbit.orbit import STATE_SIZE
from ..scene.arguments import CellBuffers
from ..scene.codes import OK, RESPONSE_COLUMNS
from ..scene.drive import Moment
from ..scene.scene import accelerations, damper_of, joined, unloaded
from ..watch.observe import IMPACT_COLUMNS, RELEASE, TOUCH, WALL, Impacts
from .load_orbit import EDGE_SUMS, Load, fly_under, structure_moved
from .load_passages import STATISTICS, fill_passages

CYCLE = 1.5  # natural periods in which a wall is struck again while the motion is captured
PARTS = 64  # of a cell in which a last time lies, each time that it is looked at more closely
LOOKS = 2  # how often that is, where there is a contact
MOST_AGAIN = 64  # impacts of such a cell that are noted

# Places of the numbers of an orbit:
#   LAST_TIMES 3 last times [s] at which E1 exceeds shares of its largest; NaN: at the end, it does
#   FELL         time [s] from the edge with the largest E1 to the second of them
#   IMPACTS      how many
#   CAME         energy [J] brought in by the start and by the load
#   GONE     3   that c1, c2 and contacts have dissipated [J]
#   BALANCE      the largest of |in - stored - dissipated| by the largest energy brought in
#   CAPTURE  3   how long the longest capture lasts, when it begins and when it ends [s]
#   START        energy of the start [J]
#   PASSAGE      first of those of `load_passages`
LAST_TIMES, FELL, IMPACTS, CAME, GONE, BALANCE = 0, 3, 4, 5, 6, 9
CAPTURE, START, PASSAGE = 10, 13, 14
ORBIT_NUMBERS = PASSAGE + STATISTICS


class Asked(NamedTuple):
    """What is asked of an orbit."""

    shares: Any  # (3,) of the largest E1
    level: float  # of |x1| [m], 0 where none is asked for
    settle: float  # time [s] that the statistics leave out


# ---- energies and contacts at edges --------------------------------------------------------------


@jit
def structure_energy(ps, section, i):
    """Return E1 [J] at an edge."""
    x1, v1 = section[i, 0], section[i, 1]
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)


@jit
def damper_energy(damper, section, i):
    """Return the energy [J] of the damper's motion and of its spring, which is no E2."""
    if damper is None:
        return 0.0
    return moving_damper(damper, section[i])


@jit
def moving_damper(damper, y):
    """Return that of a state (x1, v1, x2, v2)."""
    r = y[0] - y[2] + damper.rest
    return 0.5 * (damper.m2 * y[3] * y[3] + damper.k2 * r * r)


@jit
def contact_at(impacts, first, time):
    """Return the number of the first contact that is not over, and whether it has begun.

    first: it at an earlier time.
    """
    if impacts is None:
        return first, False
    data, count = impacts.data, impacts.filled[0]
    while first < count and data[first, RELEASE] <= time:
        first += 1
    return first, first < count and data[first, TOUCH] <= time


@jit
def contact_between(impacts, begin, end):
    """Tell whether a contact meets the times from `begin` to `end` [s], both included.

    impacts: `observe.Impacts`, with room for all of them, or None without walls. The release of a
    contact that still lasts is NaN, hence `not ... < begin`.
    """
    if impacts is None:
        return False
    data = impacts.data
    for i in range(impacts.filled[0]):
        if data[i, TOUCH] <= end and not data[i, RELEASE] < begin:
            return True
    return False


@jit
def fill_balance(ps, damper, load, begin, buffers, numbers):
    """Fill in the energies; return the edge with the largest E1.

    begin: the energy [J] of the start. Within a contact its energy is neither body's, and nothing
    is compared.
    """
    section, sums, edges = buffers.section, buffers.sums, load.edges
    most, place, scale, error, first = -1.0, 0, abs(begin), 0.0, 0
    for i in range(len(edges)):
        e1, came = structure_energy(ps, section, i), begin + sums[i, 0]
        if e1 > most:
            most, place = e1, i
        scale = max(scale, abs(came))
        first, touching = contact_at(buffers.impacts, first, edges[i])
        if not touching:
            gone = sums[i, 1] + sums[i, 2] + sums[i, 3]
            left = e1 + damper_energy(damper, section, i)
            error = max(error, abs(came - left - gone))
    end = len(edges) - 1
    numbers[START], numbers[CAME] = begin, begin + sums[end, 0]
    for way in range(3):
        numbers[GONE + way] = sums[end, 1 + way]
    numbers[BALANCE] = error / scale if scale > 0.0 else 0.0
    return place


# ---- last times ----------------------------------------------------------------------------------


@jit
def last_edge_above(ps, section, level):
    """Return the last edge at which E1 is above a level, -1 where there is none."""
    i = len(section) - 1
    while i >= 0 and not structure_energy(ps, section, i) > level:
        i -= 1
    return i


@jit
def energy_in_cell(ps, motion, x):
    """Return E1 [J] at a place x of a cell by Taylor coefficients of x1 and v1 (LOAD_ROW, 2)."""
    x1, v1 = motion[ORDER, 0], motion[ORDER, 1]
    for k in range(ORDER - 1, -1, -1):
        x1, v1 = x1 * x + motion[k, 0], v1 * x + motion[k, 1]
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)


@jit
def fill_motion(ps, damper, state, rows, row, h, motion):
    """Fill (LOAD_ROW, 2) Taylor coefficients of x1 and v1 over a cell without a contact.

    state: (x1, v1, r, s) at its beginning; row: the place of its load in `rows`; h: its length [s].
    """
    x1, v1, r, s = state[0], state[1], state[2], state[3]
    motion[0, 0], motion[0, 1] = x1, v1
    dv, ds = accelerations(ps, damper, x1, v1, r, s, rows[row], 0.0)
    for k in range(1, LOAD_ROW):
        g = h / k
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        motion[k, 0], motion[k, 1] = x1, v1
        if k < ORDER:
            dv, ds = accelerations(unloaded(ps), damper, x1, v1, r, s, rows[row + k], 0.0)


@jit
def last_place_above(ps, motion, level):
    """Return the last place of a cell at which E1, above a level where it begins, is above it."""
    i = PARTS
    while i > 0 and not energy_in_cell(ps, motion, i / PARTS) > level:
        i -= 1
    if i == PARTS:
        return 1.0
    low, high = i / PARTS, (i + 1) / PARTS
    f0 = energy_in_cell(ps, motion, low) - level
    f1 = energy_in_cell(ps, motion, high) - level
    x = low
    for _ in range(ROOT_STEPS):
        before, x = x, secant(low, high, f0, f1)
        f = energy_in_cell(ps, motion, x) - level
        if f == 0.0 or x == before:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    return x


@jit
def state_at(damper, section, i, state):
    """Write the state (x1, v1, r, s) at an edge."""
    x1, v1 = section[i, 0], section[i, 1]
    state[:] = 0.0
    state[0], state[1] = x1, v1
    if damper is not None:
        state[2], state[3] = x1 - section[i, 2] + damper.rest, v1 - section[i, 3]


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
def flown_in(parts, cell, load, state, buffers):
    """Fly a load from a state; return the status and the states at its edges."""
    again = buffers_for(buffers.impacts, buffers.violation, len(load.edges), MOST_AGAIN)
    status = fly_under(parts, cell, load, state, again)
    return status, again.section


@jit
def last_in_contact(parts, cell, load, i, level, buffers):
    """Return the place of the cell after edge i where E1 is last above a level, and a status.

    It is flown again, in parts, and then the part in which that is so, too.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    length = load.edges[i + 1] - load.edges[i]
    section, edge, begin, width = buffers.section, i, 0.0, 1.0
    state, table = np.zeros(STATE_SIZE), np.zeros(DRIVE + LOAD_ROW)
    for _ in range(LOOKS):
        state_at(joined(damper), section, edge, state)
        finer = parts_of_cell(load, LOAD_ROW * i, (begin, length), width * length, table)
        status, section = flown_in(parts, cell, finer, state, buffers)
        if status != OK:
            return begin, status
        edge = last_edge_above(ps, section, level)
        if edge == PARTS:
            return begin + width, OK
        width /= PARTS
        begin += edge * width
    over = structure_energy(ps, section, edge) - level
    under = level - structure_energy(ps, section, edge + 1)
    return begin + width * (over / (over + under)), OK


@jit
def last_above(parts, cell, load, level, buffers):
    """Return the last time [s] at which E1 exceeds a level, and a status; NaN: it does at the end.

    Or never does.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    section, edges = buffers.section, load.edges
    i = last_edge_above(ps, section, level)
    if i < 0 or i == len(edges) - 1:
        return math.nan, OK
    h = edges[i + 1] - edges[i]
    if contact_between(buffers.impacts, edges[i], edges[i + 1]):
        place, status = last_in_contact(parts, cell, load, i, level, buffers)
    else:
        state, motion, status = np.zeros(STATE_SIZE), np.empty((LOAD_ROW, 2)), OK
        state_at(joined(damper), section, i, state)
        fill_motion(ps, joined(damper), state, load.rows, LOAD_ROW * i, h, motion)
        place = last_place_above(ps, motion, level)
    return edges[i] + h * place, status


# ---- captures ------------------------------------------------------------------------------------


@jit
def fill_capture(impacts, walls, period, end, capture):
    """Fill in how long [s] the longest 1:1 resonance lasts, when it begins and when it ends.

    It is a stretch in which no wall is left alone for more than `CYCLE` natural periods [s]: each
    is struck in every cycle, which the damper's mass makes longer than that period. It has no end
    where it lasts to that of the orbit, and no beginning where there is none.
    """
    capture[0], capture[1], capture[2] = 0.0, math.nan, math.nan
    data, count, longest = impacts.data, impacts.filled[0], CYCLE * period
    begin, last = 0, np.full(walls, -1)  # the stretch's first impact; the last one of each wall
    for j in range(count):
        begin = begin_of_stretch(data, data[j, TOUCH], longest, begin, last)
        last[int(data[j, WALL]) if walls == 2 else 0] = j
        lasted = data[j, TOUCH] - data[begin, TOUCH]
        if last.min() >= begin and j - begin >= walls and lasted > capture[0]:
            capture[0], capture[1], capture[2] = lasted, data[begin, TOUCH], data[j, TOUCH]
    still = begin_of_stretch(data, end, longest, begin, last) == begin
    if still and capture[0] > 0.0 and capture[1] == data[begin, TOUCH]:
        capture[2] = math.nan


@jit
def begin_of_stretch(data, time, longest, begin, last):
    """Return the first impact from which on no wall is left alone for too long up to a time [s].

    begin, last: that up to an earlier time, and the last impact on each wall before `time`. A wall
    that is not struck after the stretch's first impact is left alone from there on.
    """
    while begin <= last.max() and time - data[max(begin, last.min()), TOUCH] > longest:
        begin = max(begin, last.min()) + 1
    return begin


@jit
def fill_captures(parts, impacts, ps, end, numbers):
    """Fill in the number of impacts and the longest capture, if there are walls."""
    if impacts is None:
        return None
    numbers[IMPACTS] = impacts.filled[0]
    walls = (0 if parts.near is None else 1) + (0 if parts.far is None else 1)
    period = 2.0 * math.pi / math.sqrt(ps.stiffness) if ps.stiffness > 0.0 else math.inf
    fill_capture(impacts, walls, period, end, numbers[CAPTURE:])


# ---- all of them ---------------------------------------------------------------------------------


@jit
def impacts_for(impacts, room):
    """Return fresh room for impacts, None where there are no walls."""
    if impacts is None:
        return None
    return Impacts(np.empty((room, IMPACT_COLUMNS)), np.zeros(1, np.int64))


@jit
def violation_for(violation):
    """Return fresh room for a violation of a limit, None where there is none to keep."""
    if violation is None:
        return None
    return np.zeros(3)


@jit
def buffers_for(impacts, violation, edges, room):
    """Return the buffers of an orbit from which its numbers are found.

    impacts, violation: None where there is nothing of that kind; room: for impacts.
    """
    return CellBuffers(
        None, np.empty((edges, 4)), None, impacts_for(impacts, room), None, np.zeros(2), None,
        violation_for(violation), np.empty(RESPONSE_COLUMNS), None, np.empty((edges, EDGE_SUMS)),
    )  # fmt: skip


@jit
def start_energy_of(parts, cell, state):
    """Return the energy [J] of a state (x1, v1, r, s) at a start."""
    x1, v1 = state[0], state[1]
    energy = 0.5 * (cell.m1 * v1 * v1 + cell.k1 * x1 * x1)
    return energy + joint_energy(joined(damper_of(parts.damper, cell)), state)


@jit
def joint_energy(damper, state):
    """Return what of it is the damper's and its spring's."""
    if damper is None:
        return 0.0
    v2 = state[1] - state[3]
    return 0.5 * (damper.m2 * v2 * v2 + damper.k2 * state[2] * state[2])


@jit
def fill_numbers(parts, cell, load, asked, begin, buffers, numbers):
    """Fill in the numbers (ORBIT_NUMBERS,) of an orbit that `load_orbit.fly_under` has flown.

    asked: `Asked`; begin: the energy [J] of its start; buffers: of `buffers_for`. Returns a status.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    numbers[:] = math.nan
    most, edges = buffers.peak[0], load.edges
    top = fill_balance(ps, joined(damper), load, begin, buffers, numbers)
    for i in range(len(asked.shares)):
        numbers[LAST_TIMES + i], status = last_above(
            parts, cell, load, asked.shares[i] * most, buffers
        )  # fmt: skip
        if status != OK:
            return status
    numbers[FELL] = numbers[LAST_TIMES + 1] - edges[top]
    fill_captures(parts, buffers.impacts, ps, edges[len(edges) - 1], numbers)
    fill_passages(load, buffers, asked, numbers[PASSAGE:])
    return OK
