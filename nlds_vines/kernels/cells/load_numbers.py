"""The numbers of an orbit under a load: last times, energies, the rms of x1.

They are computed from the states and the energies at the edges of the load's cells and from the
impacts, when the orbit is over.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..scene.codes import OK
from ..scene.scene import damper_of
from .load_edges import energy_stored, walls_of
from .load_orbit import ALIKE, structure_moved
from .load_times import last_above, time_of_largest

# Places of the numbers of an orbit:
#   LAST_TIMES 3 last times [s] at which E1 exceeds shares of its largest; NaN: at the end, it does
#   FELL         time [s] from the largest E1 to the second of them
#   IMPACTS      how many
#   CAME         energy [J] brought in by the start and by the load
#   GONE     3   that c1, c2 and contacts have dissipated [J]
#   BALANCE      the largest of |in - stored - dissipated| by the largest energy brought in
#   START        energy of the start [J], with that of contacts and of a constant load
#   RMS          of x1 [m], without the time to settle
LAST_TIMES, FELL, IMPACTS, CAME, GONE, BALANCE = 0, 3, 4, 5, 6, 9
START, RMS, ORBIT_NUMBERS = 10, 11, 12


class Asked(NamedTuple):
    """What is asked of an orbit."""

    shares: Any  # (3,) of the largest E1, rising
    settle: float  # time [s] that the rms of x1 leaves out


# ---- energies and contacts at edges --------------------------------------------------------------


@jit
def fill_balance(ps, damper, walls, load, buffers, numbers):
    """Fill in the energies; damper: of `damper_of`; walls: the near and the far one."""
    section, sums, end = buffers.section, buffers.sums, len(load.edges) - 1
    begin = energy_stored(ps, damper, walls, section, 0, load.jumps[0])
    scale, error = abs(begin), 0.0
    for i in range(end + 1):
        came, gone = begin + sums[i, 0], sums[i, 1] + sums[i, 2] + sums[i, 3]
        scale = max(scale, abs(came))
        error = max(error, abs(came - energy_stored(ps, damper, walls, section, i, 0.0) - gone))
    numbers[START], numbers[CAME] = begin, begin + sums[end, 0]
    for way in range(3):
        numbers[GONE + way] = sums[end, 1 + way]
    numbers[BALANCE] = error / scale if scale > 0.0 else 0.0


# ---- all of them ---------------------------------------------------------------------------------


@jit
def rms_of_x1(edges, sums, settle):
    """Return the rms of x1 [m] from the first edge that is not before `settle` [s] to the end."""
    first, last = 0, len(edges) - 1
    begin = settle - ALIKE * edges[last]
    while first < last - 1 and edges[first] < begin:
        first += 1
    return math.sqrt((sums[last, 4] - sums[first, 4]) / (edges[last] - edges[first]))


@jit
def fill_numbers(parts, cell, load, asked, buffers, numbers):
    """Fill in the numbers (ORBIT_NUMBERS,) of an orbit that `load_orbit.fly_under` has flown.

    asked: `Asked`; buffers: of `buffers_for`. Returns a status.
    """
    ps, damper = structure_moved(parts, load.shaken, cell), damper_of(parts.damper, cell)
    numbers[:] = math.nan
    most, edges = buffers.peak[0], load.edges
    fill_balance(ps, damper, walls_of(parts, cell, damper), load, buffers, numbers)
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
    if buffers.impacts is not None:
        numbers[IMPACTS] = buffers.impacts.filled[0]
    numbers[RMS] = rms_of_x1(edges, buffers.sums, asked.settle)
    return OK
