"""The loops over cells of a map: one that runs orbits, one that judges them.

Cells are chains: a single cell, or, if a scan follows an attractor, the cells of an axis in the
order of the sweep, each starting from the last state of the one before. Chains share nothing, so
that results do not depend on blocks, pieces and threads (`runs.executors`). A
separate loop computes verdicts: it does not depend on the records and is compiled once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..motion.flight import PERIOD
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..orbit.orbit import STATE_SIZE
from ..orbit.repetition import TOLERANCE, impacts_of, period_of
from ..scene.codes import OK
from ..scene.scene import CellBuffers, Ground
from ..watch.observe import Touches
from .cells import cell_flow, run_cell
from .verdict import evidence_in, judge

# indices of `LaneBuffers.ends`
FIRST_STATE, LAST_STATE = 0, 1


@jit
def lane_of(values, chain, link):
    if values is None:
        return None
    return values[chain, link]


@jit
def buffers_of(parts, buffers, span, chain, link):
    """Return the `CellBuffers` of a cell: its rows of the `LaneBuffers`, and scratch."""
    section, points = buffers.section, span.periods * span.stops
    room = buffers.touches
    touches = None if room is None else Touches(room[chain, link], np.zeros(1, np.int64))
    early = None if section is None else section[chain, link, : section.shape[2] - points]
    # rows for the section points: of the output, or scratch if a cycle is read from them
    if buffers.section is not None:
        rows: Any = section[chain, link, section.shape[2] - points :]
    elif buffers.cycle is None:
        rows = None
    elif parts.damper is None or is_a(parts.damper, Ground):
        rows = np.empty((points, 2))
    else:
        rows = np.empty((points, 4))
    # scratch for the impacts of each period and wall
    if parts.near is None and parts.far is None:
        by_period: Any = None
    elif buffers.counts is None and buffers.cycle is None:
        by_period = None
    else:
        by_period = np.zeros((span.periods, 2), np.int64)
    return CellBuffers(
        early,
        rows,
        by_period,
        touches,
        lane_of(buffers.energy, chain, link),
        lane_of(buffers.peak, chain, link),
        lane_of(buffers.clearance, chain, link),
        lane_of(buffers.violation, chain, link),
        lane_of(buffers.response, chain, link),
        None,
    )


@jit(entry=True)
def run_lanes(begin, end, parts, cells, starts, span, buffers, status):
    """Run chains `begin` to `end` - 1 of a block of cells (chains, links) from starts (chains, 4).

    parts: `Parts`; span: `Span`, with one stop a period if a cycle is recorded; buffers:
    `LaneBuffers`, whose section has a row for each stop; status (chains, links). If a cell fails,
    its counts and cycle keep their fill values, its other rows have no meaning, and the next cell
    of the chain starts from rest.
    """
    for chain in range(begin, end):
        state = np.zeros(STATE_SIZE)
        for i in range(4):
            state[i] = starts[chain, i]
        for link in range(cells.shape[1]):
            cell = cells[chain, link]
            if link > 0 and status[chain, link - 1] == OK:
                # the displacement is carried over, wherever the new rest may be
                state[2] += cell.rest - cells[chain, link - 1].rest
                for i in range(4, STATE_SIZE):  # the contact follows from r and s in this cell
                    state[i] = 0.0
            cell_buffers = buffers_of(parts, buffers, span, chain, link)
            if buffers.ends is not None:
                for i in range(STATE_SIZE):
                    buffers.ends[chain, link, FIRST_STATE, i] = state[i]
            code = run_cell(parts, cell, state, span, cell_buffers)
            if buffers.ends is not None:
                for i in range(STATE_SIZE):
                    buffers.ends[chain, link, LAST_STATE, i] = state[i]
            status[chain, link] = code
            if code != OK:
                state[:] = 0.0
                continue
            if buffers.counts is not None:
                counts, by_period = buffers.counts[chain, link], cell_buffers.by_period
                counts[0], counts[1], counts[2] = 0, 0, 0
                for p in range(len(by_period)):
                    counts[0] += by_period[p, 0]
                    counts[1] += by_period[p, 1]
                    if by_period[p, 0] + by_period[p, 1] == 2:
                        counts[2] += 1
            if buffers.cycle is not None:
                cycle = buffers.cycle[chain, link]
                cycle[0], cycle[1], cycle[2] = period_of(cell_buffers.section, TOLERANCE), 0, 0
                if parts.near is not None or parts.far is not None:
                    for wall in range(2):
                        cycle[1 + wall] = impacts_of(cell_buffers.by_period, wall, cycle[0])


@jit(entry=True)
def judge_lanes(begin, end, parts, cells, finished, stages, evidence, status):
    """Judge the orbits of cells `begin` to `end` - 1 that `run_lanes` has run.

    Cells (chains, links) are counted along the links. parts: `Parts`; finished: `Finished`; stages:
    further periods of each stage of a verdict; evidence (chains, links, `codes.LENGTH_OF_ROW`). If
    a cell fails in a further stage, its status changes.
    """
    links = cells.shape[1]
    for lane in range(begin, end):
        chain, link = lane // links, lane % links
        if status[chain, link] == OK:
            flow, _ = cell_flow(parts, cells[chain, link], PERIOD)
            status[chain, link] = judge(
                flow, finished.ends[chain, link], finished.section[chain, link], finished.first,
                stages, evidence_in(evidence[chain, link]),
            )  # fmt: skip
