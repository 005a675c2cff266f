"""An orbit of a host under a load in time: a polynomial over each cell, and jumps of the rates.

A cell of the load is a period of its own (`body`), with the smaller cells of the grid inside it.
Cells of equal length in a row share a grid.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.fours import bare
from ..orbit.orbit import HUGE
from ..scene.codes import DIVERGED, OK
from .body import Body
from .host_contact import release
from .host_flight import drive_of
from .host_orbit import host_flow, new_host_state, place_host_state, run_part
from .host_watch import host_watch
from .walls import IS_RIGID, outward_at, push_all

ALIKE_CELLS = 1.0e-14  # round-off of a cell's length, in units of the largest time
MOST_PACE = 0.5  # of a load in units of 1 / length of its cell (`model.loads`)


class HostLoad(NamedTuple):
    """A load f in time on the `push` of a body."""

    edges: Any  # (n + 1,) [s], ascending
    rows: Any  # (drives n,) coefficients of f by the place in a cell, cell by cell
    jumps: Any  # (n + 1,) of the integral of f at the edges
    tops: (
        Any  # (n,) a level of E1 [J] in each cell, raised to its largest value there; or no numbers
    )


@jit
def under(body, h):
    """Return a body whose period is a cell of h [s] of its load."""
    paces = np.zeros(body.drives)
    for k in range(body.drives - 1):
        paces[k] = (k + 1.0) / h
    return Body(
        body.modes, body.size, body.links, min(body.omega, MOST_PACE / h), h, 0.0, 1.0, body.drives,
        paces, body.squares, body.damping, body.coupling, body.coupled, body.push, body.rows,
        body.answers, body.stiffness, body.dashpots, body.springs,
    )  # fmt: skip


@jit(entry=True)
def run_host_under(body, walls, contacts, load, state, section, impacts, records):
    """Advance y (2 size,) in `state` from the first edge of a load to the last; return a status.

    section: (n + 1, 3 size) takes X, X' and X'' at the edges, after the jumps there; records:
    `HostRecords` or None.
    """
    edges, n, first = load.edges, len(load.edges) - 1, 0
    slack = ALIKE_CELLS * (abs(edges[0]) + abs(edges[n]))
    whole = np.zeros(0)
    while first < n:
        h, last = edges[first + 1] - edges[first], first + 1
        while last < n and abs(edges[last + 1] - edges[last] - h) <= slack:
            last += 1
        h = (edges[last] - edges[first]) / (last - first)
        flow, status = host_flow(under(body, h), walls, contacts, impacts, 1)
        if status == OK and first == 0:
            put_load(flow.host.grid, load, 0)
            whole = new_host_state(flow)
            place_host_state(flow, state, whole)
        if status == OK:
            status = run_cells(flow, load, (first, last), whole, section, records)
        if status != OK:
            return status
        first = last
    for i in range(2 * body.size):
        state[i] = whole[i]
    return OK


@jit
def put_load(grid, load, p):
    """Make the load of cell p that of the grid."""
    for k in range(grid.drives):
        grid.phases[k] = load.rows[grid.drives * p + k]


@jit
def run_cells(flow, load, ends, state, section, records):
    """Advance a state through cells of equal length, with the walls in contact as they are."""
    host, y, (first, last) = bare(flow.host), bare(state), ends
    prepared = host_watch(flow.host.body, flow.host.grid, flow.host.walls, records)
    watch = bare(prepared)
    if records is not None:
        watch.is_on[0] = 1.0
    grid, size = host.grid, host.body.size
    for p in range(first, last):
        put_load(grid, load, p)
        host.impacts.began[0] = load.edges[p]
        if load.jumps[p] != 0.0:
            strike_all(host, load.jumps[p], y)
        note_edge(host, 0, y, section, p)
        if records is not None and len(load.tops) > 0:
            records.peaks[0] = load.tops[p]
        status = run_part(host, None, watch, (0, grid.cells), y)
        if records is not None and len(load.tops) > 0:
            load.tops[p] = records.peaks[0]
        if status != OK:
            return status
        total = 0.0
        for i in range(2 * size):
            total += abs(y[i])
        if not total < HUGE:
            return DIVERGED
    if last == len(load.edges) - 1:
        if load.jumps[last] != 0.0:
            host.impacts.began[0] = load.edges[last]
            strike_all(host, load.jumps[last], y)
        note_edge(host, grid.cells, y, section, last)
    if records is not None:
        prepared.is_on[0] = 0.0  # its arrays are in use up to here
    return OK


@jit
def strike_all(host, by, y):
    """Let the rates jump by `by` times the push, at the beginning of a cell.

    Rigid walls no longer hold what jumps; one that it jumps into is touched at this instant.
    """
    body, walls, contacts = host.body, host.walls, host.contacts
    for place in range(contacts.active[0], 0, -1):
        wall = contacts.active[place]
        if walls.law[wall] == IS_RIGID and outward_at(body, walls, wall, body.push, 0) != 0.0:
            release(host, None, place, 0.0, y)
    for i in range(body.size):
        y[body.size + i] += by * body.push[i]


@jit
def note_edge(host, j, y, section, edge):
    """Write X, X' and X'' at the beginning of smallest cell j to the row of an edge."""
    size, work, drive = host.body.size, host.scratch.work, host.scratch.drive
    drive_of(host.grid, j, 0.0, drive)
    push_all(host.body, host.walls, host.contacts, drive, y, work)
    for i in range(size):
        section[edge, i], section[edge, size + i] = y[i], y[size + i]
        section[edge, 2 * size + i] = work[i]
