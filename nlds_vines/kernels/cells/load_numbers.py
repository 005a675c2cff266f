"""What is told of an orbit under a load in numbers: last times, energies, captures.

They are found from the states and the energies at the edges of the load's cells and from the
impacts, when the orbit is over.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..scene.codes import OK
from ..scene.scene import damper_of, joined
from ..watch.observe import TOUCH, WALL
from .load_edges import joint_energy, lasts_until, state_at, structure_energy, touch_by
from .load_orbit import structure_moved
from .load_passages import STATISTICS, fill_passages
from .load_times import last_above, time_of_largest

CYCLE = 1.5  # natural periods in which a wall is struck again while the motion is captured

# Places of the numbers of an orbit:
#   LAST_TIMES 3 last times [s] at which E1 exceeds shares of its largest; NaN: at the end, it does
#   FELL         time [s] from the largest E1 to the second of them
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

    shares: Any  # (3,) of the largest E1, rising
    level: float  # of |x1| [m], 0 where none is asked for
    settle: float  # time [s] that the statistics leave out


# ---- energies and contacts at edges --------------------------------------------------------------


@jit
def fill_balance(ps, damper, load, begin, buffers, numbers):
    """Fill in the energies.

    begin: the energy [J] of the start. Within a contact its energy is neither body's, and nothing
    is compared.
    """
    section, sums, edges = buffers.section, buffers.sums, load.edges
    scale, error, j = abs(begin), 0.0, -1
    for i in range(len(edges)):
        e1, came = structure_energy(ps, section, i), begin + sums[i, 0]
        scale = max(scale, abs(came))
        j = touch_by(buffers.impacts, j, edges[i])
        if not lasts_until(buffers.impacts, j, edges[i]):
            gone = sums[i, 1] + sums[i, 2] + sums[i, 3]
            left = e1 + joint_energy(damper, state_at(ps, damper, section, i, 0.0))
            error = max(error, abs(came - left - gone))
    end = len(edges) - 1
    numbers[START], numbers[CAME] = begin, begin + sums[end, 0]
    for way in range(3):
        numbers[GONE + way] = sums[end, 1 + way]
    numbers[BALANCE] = error / scale if scale > 0.0 else 0.0


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
def start_energy_of(parts, cell, state):
    """Return the energy [J] of a state (x1, v1, r, s) at a start."""
    x1, v1 = state[0], state[1]
    energy = 0.5 * (cell.m1 * v1 * v1 + cell.k1 * x1 * x1)
    return energy + joint_energy(joined(damper_of(parts.damper, cell)), state)


@jit
def fill_numbers(parts, cell, load, asked, begin, buffers, numbers):
    """Fill in the numbers (ORBIT_NUMBERS,) of an orbit that `load_orbit.fly_under` has flown.

    asked: `Asked`; begin: the energy [J] of its start; buffers: of `buffers_for`. Returns a status.
    """
    ps, damper = structure_moved(parts.load, load.shaken, cell), damper_of(parts.damper, cell)
    numbers[:] = math.nan
    most, edges = buffers.peak[0], load.edges
    fill_balance(ps, joined(damper), load, begin, buffers, numbers)
    last = len(edges) - 2
    for i in range(len(asked.shares)):
        level = asked.shares[i] * most
        numbers[LAST_TIMES + i], last, status = last_above(parts, cell, load, level, buffers, last)
        if status != OK:
            return status
    largest, status = time_of_largest(parts, cell, load, buffers)
    if status != OK:
        return status
    numbers[FELL] = numbers[LAST_TIMES + 1] - largest
    fill_captures(parts, buffers.impacts, ps, edges[len(edges) - 1], numbers)
    fill_passages(load, buffers, asked, numbers[PASSAGE:])
    return OK
