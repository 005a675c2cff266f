"""The loop over orbits under loads, each with its numbers: of maps of loads.

Nothing is shared between lanes but the loads, which no lane changes: what a lane tells does not
depend on how a scan is cut into blocks and pieces.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..motion.load_cells import LOAD_ROW, OF_CELL
from ..numerics.compiling import jit
from ..orbit.orbit import STATE_SIZE
from ..scene.arguments import CellBuffers
from ..scene.codes import OK
from .load_numbers import fill_numbers
from .load_orbit import Load, buffers_for, fly_under, impacts_for, rate_under

SPARE_ROOM = 64  # for impacts, and one more for each cell; an orbit with more is followed again


class Loads(NamedTuple):
    """The loads of many lanes: what several have in common stands once."""

    edges: Any  # of all loads, one behind the other
    rows: Any  # of all, with a row for each edge, the last of each load without a meaning
    sums: Any  # of the rows, `load_cells.sums_of`
    jumps: Any  # of all lanes, one behind the other
    first: Any  # (lanes,) place of a lane's first edge in `edges`
    after: Any  # (lanes,) that behind its last one
    blow: Any  # (lanes,) place of its first jump in `jumps`
    shaken: Any  # as of `Load`


class Told(NamedTuple):
    """What lanes tell."""

    numbers: Any  # (lanes, `load_numbers.ORBIT_NUMBERS`)
    response: Any  # (lanes, `codes.RESPONSE_COLUMNS`)
    peak: Any  # (lanes, 2) largest E1 and E2 [J]
    violation: Any  # (lanes, 3), None in a scene without a limit to keep
    impacts: Any  # `Impacts` of which no number matters, None in a scene without walls
    states: Any  # (lanes or 0, edges, 4) at the edges, in the user's coordinates
    sums: Any  # (lanes or 0, edges, `load_orbit.EDGE_SUMS`)
    status: Any  # (lanes,)


@jit
def load_of(loads, lane):
    """Return the `Load` of a lane."""
    first, after, blow = loads.first[lane], loads.after[lane], loads.blow[lane]
    return Load(
        loads.edges[first:after],
        loads.rows[LOAD_ROW * first : LOAD_ROW * (after - 1)],
        loads.jumps[blow : blow + (after - first)],
        loads.sums[OF_CELL * first : OF_CELL * (after - 1)],
        loads.shaken,
    )


@jit
def flown(parts, cell, load, start, buffers):
    """Follow an orbit from a start (x1, v1, r, s); return its status and its buffers.

    Where impacts are more than there is room for, it is followed again.
    """
    state = np.zeros(STATE_SIZE)
    while True:
        state[:] = 0.0
        for i in range(4):
            state[i] = start[i]
        status = fly_under(parts, cell, load, state, buffers)
        many = overflow_of(buffers.impacts)
        if status != OK or many == 0:
            return status, buffers
        buffers = with_room(buffers, many)


@jit
def overflow_of(impacts):
    """Return how many impacts there are where they are more than there is room for, otherwise 0."""
    if impacts is None:
        return 0
    return impacts.filled[0] if impacts.filled[0] > len(impacts.data) else 0


@jit
def with_room(buffers, room):
    """Return fresh buffers with room for so many impacts."""
    return CellBuffers(
        None, buffers.section, None, impacts_for(buffers.impacts, room), None, np.zeros(2), None,
        buffers.violation, buffers.response, None, buffers.sums, None,
    )  # fmt: skip


@jit
def copy(row, into):
    """Copy a row of numbers."""
    for i in range(len(row)):
        into[i] = row[i]


@jit(entry=True)
def fill_rates(parts, cells, rates):
    """Fill in bounds (lanes,) [1/s] on the rates of the linear motion of cells."""
    for lane in range(len(cells)):
        rates[lane] = rate_under(parts, cells[lane])


@jit(entry=True)
def fly_lanes(begin, end, parts, cells, loads, starts, asked, told):
    """Follow lanes `begin` to `end` - 1 of `cells` (lanes,) from starts (lanes, 4), (x1, v1, r, s).

    parts: `Parts`; loads: `Loads`; asked: `load_numbers.Asked`; told: `Told`. A lane that fails
    has another status, and its numbers have no meaning.
    """
    for lane in range(begin, end):
        cell, load = cells[lane], load_of(loads, lane)
        own = buffers_for(
            told.impacts, told.violation, len(load.edges), SPARE_ROOM + len(load.edges)
        )
        status, own = flown(parts, cell, load, starts[lane], own)
        if status == OK:
            status = fill_numbers(parts, cell, load, asked, own, told.numbers[lane])
        told.status[lane] = status
        copy(own.response, told.response[lane])
        copy(own.peak, told.peak[lane])
        if told.violation is not None:
            copy(own.violation, told.violation[lane])
        if status == OK and lane < len(told.states):
            for i in range(len(load.edges)):
                copy(own.section[i], told.states[lane, i])
                copy(own.sums[i], told.sums[lane, i])
