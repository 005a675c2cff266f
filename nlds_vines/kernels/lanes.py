"""The only parallel loops: one lane per chain of cells, each writing its own output rows.

A chain is a single cell, or, where a scan follows an attractor, the cells of an axis in the order
of the sweep, each starting from the last state of the one before. Nothing is shared between lanes,
so that results do not depend on the number of threads or on how a scan is cut into blocks.

Running and judging are two loops: what a verdict needs does not depend on what else is recorded,
and is compiled once for all of it.
"""

from __future__ import annotations

import numba
import numpy as np

from .cells import judge_cell, run_cell
from .compiling import chosen, jit
from .orbit import OK, SIZE
from .recurrence import TOLERANCE, impacts_of, period_of


@chosen
def early_rows(section, periods, chain, link):
    """Return the rows for the section of the transient: as many as there is room for, or None."""
    if section is None:
        return lambda section, periods, chain, link: None
    return lambda section, periods, chain, link: section[chain, link, : section.shape[2] - periods]


@chosen
def section_rows(section, cycle, damper, periods, chain, link):
    """Return the rows for the section points of one lane: its output, scratch, or None."""
    if section is not None:
        return lambda section, cycle, damper, periods, chain, link: section[
            chain, link, section.shape[2] - periods :
        ]
    if cycle is None:
        return lambda section, cycle, damper, periods, chain, link: None
    if damper is None:
        return lambda section, cycle, damper, periods, chain, link: np.empty((periods, 2))
    return lambda section, cycle, damper, periods, chain, link: np.empty((periods, 4))


@chosen
def beat_rows(counts, cycle, arc, periods):
    """Return scratch for the impacts of each period and wall, or None where nobody asks."""
    if arc is None or (counts is None and cycle is None):
        return lambda counts, cycle, arc, periods: None
    return lambda counts, cycle, arc, periods: np.zeros((periods, 2), np.int64)


@chosen
def lane_of(values, chain, link):
    """Return the row of an optional output that belongs to one lane."""
    if values is None:
        return lambda values, chain, link: None
    return lambda values, chain, link: values[chain, link]


@jit
def summarise(section, beats, counts, cycle):
    """Fill the impact counts (2,) by wall and the cycle (n, k near, k far) of one lane."""
    if counts is not None:
        for wall in range(2):
            counts[wall] = 0
            for p in range(len(beats)):
                counts[wall] += beats[p, wall]
    if cycle is not None:
        cycle[0], cycle[1], cycle[2] = period_of(section, TOLERANCE), 0, 0
        if beats is not None:
            for wall in range(2):
                cycle[1 + wall] = impacts_of(beats, wall, cycle[0])


@jit
def note_end(ends, chain, link, which, state):
    """Keep the state at one end of an orbit, where asked for."""
    if ends is not None:
        ends[chain, link, which] = state


@jit(parallel=True)
def run_lanes(
    classical,
    has_damper,
    has_near,
    has_far,
    arc,
    resolution,
    cells,
    starts,
    transient,
    periods,
    section,
    counts,
    cycle,
    energy,
    peak,
    clearance,
    violation,
    ends,
    status,
):
    """Run all chains of a block of cells (chains, links), each from its start (chains, 4).

    Outputs have the shape (chains, links, ...) or are None: `section` (periods, components), or
    (transient + periods, components) to hold the transient's too, `counts` (2,) impacts by wall,
    `cycle` (3,) n and k at either wall, `energy` and `peak` (2,) [J], `clearance` (1,) [m],
    `violation` (3,) [s, m, 1]; `ends` (2, SIZE), the states at begin and end; `status` always.
    A lane that fails keeps its fill values, starts the next link of its chain from rest, and
    touches nothing of its neighbours.
    """
    chains, links = cells.shape
    for chain in numba.prange(chains):
        state = np.zeros(SIZE)
        state[:4] = starts[chain]
        for link in range(links):
            rows = section_rows(section, cycle, has_damper, periods, chain, link)
            beats = beat_rows(counts, cycle, arc, periods)
            cell = cells[chain, link]
            if link > 0 and status[chain, link - 1] == OK:
                # the displacement is carried over, wherever the new rest may be
                state[2] += cell.rest - cells[chain, link - 1].rest
            note_end(ends, chain, link, 0, state)
            code = run_cell(
                classical, has_damper, has_near, has_far, arc, resolution, cell, state,
                early_rows(section, periods, chain, link), rows,
                beats, None, lane_of(energy, chain, link), lane_of(peak, chain, link),
                lane_of(clearance, chain, link), lane_of(violation, chain, link),
                transient, transient, periods, 1,
            )  # fmt: skip
            note_end(ends, chain, link, 1, state)
            status[chain, link] = code
            if code == OK:
                summarise(rows, beats, lane_of(counts, chain, link), lane_of(cycle, chain, link))
            else:
                state[:] = 0.0


@jit(parallel=True)
def judge_lanes(
    classical,
    has_damper,
    has_near,
    has_far,
    arc,
    resolution,
    cells,
    ends,
    section,
    cycle,
    stages,
    evidence,
    status,
):
    """Say what the orbits are that `run_lanes` has run with a section of their whole course.

    `stages`: further periods that a verdict may take, stage by stage. Fills `evidence` (chains,
    links, `verdict.COLUMNS`); a lane that fails in a further stage gets another `status`.
    """
    chains, links = cells.shape
    for lane in numba.prange(chains * links):
        chain, link = lane // links, lane % links
        if status[chain, link] == OK:
            status[chain, link] = judge_cell(
                classical, has_damper, has_near, has_far, arc, resolution, cells[chain, link],
                ends[chain, link, 0], ends[chain, link, 1], section[chain, link],
                cycle[chain, link, 0], stages, evidence[chain, link],
            )  # fmt: skip
