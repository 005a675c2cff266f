"""Compute one cell of a map: prepare its grid and walls, follow its orbit, set up its section map.

Also orbits that begin at any phase of the forcing (`enter`). Cells of a grid are intervals of a
flight.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..events.contact import Steps
from ..events.fixed_step import fixed_grid_from
from ..impact.arc import Arc
from ..motion.flight import PERIOD, REACH, SHORT, Begun, cells_of, grid_from
from ..motion.load_cells import Stretch, grid_under
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, says
from ..orbit.orbit import bounded, on_ground, run, set_mode
from ..orbit.variations import flow_of, new_state
from ..scene.by_law import by_wall
from ..scene.codes import BAD_PARAMETERS, DIVERGED, FLYING, OK, TOO_STIFF
from ..scene.law import SCRATCH, wall_like
from ..scene.scene import (
    OrbitBuffers,
    Prepared,
    Span,
    allowed,
    damper_of,
    finite,
    near_constants,
    structure_under,
)
from ..watch.observe import (
    EXCESS,
    FIRST_VIOLATION,
    LIMIT,
    NUMBER,
    note_energy,
    note_violation,
)
from ..watch.response import begin_tally, report

STABLE = 2.5  # longest step of rk4 in units of 1/rate: RK4 is unstable beyond 2.8


# ---- a prepared cell -----------------------------------------------------------------------------


@by_wall
def held_at(wall, ps, damper, begun):
    """Return the prepared motion on a wall, if its law has one; begun: as in `prepared_cell`.

    In general there is none; a law that has one replaces this kernel by its own (`by_wall`).
    """
    return None


@by_wall
def too_stiff(motion, period):
    """Return True if the prepared motion on a wall is too fast to be followed for a period [s]."""
    return False


@jit
def cells_for(parts, n, stops):
    """Return the number of cells of the method's grid.

    That is n of exact flight, or the steps of rk4, rounded up to a multiple of `stops`. If contacts
    are linear, too, cells are so short that their truncation is below round-off.
    """
    if parts.rk4 is not None:
        n = int(parts.period_steps)
    elif says(parts.near, "LINEAR") or says(parts.far, "LINEAR"):
        n = math.ceil(REACH / SHORT * n)
    return stops * ((n + stops - 1) // stops)


@jit
def prepared_cell(parts, cell, ps, damper, n, stops, begun):
    """Return a cell `Prepared` for orbits with `stops` section points a period.

    parts, cell: as of `run_cell`; ps, damper: the cell's `Structure` and its `Damper`, `Ground` or
    None; begun: the `flight.Begun` of the periods, or the `load_cells.Stretch` of a load; n: the
    number of exact cells that a period needs, or of cells of the stretch. Section points are ends
    of cells.
    """
    near = wall_like(parts.near, cell.near, damper, near_constants(parts.apart, cell))
    far = wall_like(parts.far, cell.far, damper, cell)
    if is_a(begun, Stretch):
        grid: Any = grid_under(ps, damper, begun.h, n, begun)
    elif parts.rk4 is not None:
        grid = fixed_grid_from(ps, damper, cells_for(parts, n, stops), begun)
    else:
        grid = grid_from(ps, damper, cells_for(parts, n, stops), begun)
    scratch = None if parts.near is None and parts.far is None else np.zeros(SCRATCH)
    base = parts.arc  # its table has scratch rows, so each orbit gets a copy
    arc = (
        None if base is None else Arc(base.tolerance, base.settled, base.levels, base.table.copy())
    )
    return Prepared(
        parts.rk4, ps, damper, near, far, arc, grid,
        Steps(parts.contact_steps, parts.contact_tolerance), scratch,
        held_at(near, ps, damper, begun), held_at(far, ps, damper, begun),
    )  # fmt: skip


@jit
def checked_cell(parts, cell, stops, begun):
    """Return (status, the `Prepared` cell); the cell is valid only if the status is OK."""
    ps, damper = structure_under(parts, cell), damper_of(parts.damper, cell)
    n, period = cells_of(ps, damper), 2.0 * math.pi / ps.omega
    prepared = prepared_cell(parts, cell, ps, damper, max(n, 1), stops, begun)
    if not allowed(parts, cell):
        return BAD_PARAMETERS, prepared
    if n < 0 or too_stiff(prepared.held_near, period) or too_stiff(prepared.held_far, period):
        return TOO_STIFF, prepared
    if parts.rk4 is not None and not prepared.grid.h * prepared.grid.rate <= STABLE:
        return TOO_STIFF, prepared
    return OK, prepared


# ---- an orbit ------------------------------------------------------------------------------------


@jit
def run_cell(parts, cell, state, span, buffers):
    """Advance `state` (STATE_SIZE,) over the transient and a `Span` of periods; return a status.

    From the last state of an earlier run of the cell, the orbit goes on as that run would have.
    parts: `Parts`; cell: a record of `model.presets.cell_type`; span.first: periods of the
    transient, None if there never is one, so that nothing is compiled for it; buffers:
    `CellBuffers`.
    """
    status, prepared = checked_cell(parts, cell, span.stops, PERIOD)
    if status == BAD_PARAMETERS or lacks_limit(buffers.violation, cell.limit):
        return BAD_PARAMETERS
    if not bounded(state[0], state[1], state[2], state[3]):
        return DIVERGED
    if status != OK:
        return status
    ps, damper, peak = prepared.ps, prepared.damper, buffers.peak
    on_ground(damper, state)
    if state[5] == FLYING:  # a state inside a contact is complete, with the impact under way
        set_mode(prepared.near, prepared.far, prepared.damper, state)
    limit_log = begin_limit_log(buffers.violation, cell.limit, state)
    start_energy(ps, damper, peak, state)
    # the transient: periods without sections, then those whose sections are recorded
    first = 0
    if span.first is not None:
        first = span.first
        noted = 0 if buffers.early is None else len(buffers.early)
        # (a section without room has the type of other ones: the time loop is compiled once)
        none = None if buffers.section is None else buffers.section[:0]
        before = OrbitBuffers(limit_log, none, None, None, peak, None, None, None, None)
        status = run(prepared, before, Span(0, first - noted, 1), state, None, None)
        if status == OK and buffers.early is not None:
            early = buffers.early
            before = OrbitBuffers(limit_log, early, None, None, peak, None, None, None, None)
            seen = Span(first - noted, noted, 1)
            status = run(prepared, before, seen, state, None, None)
    # the sampled periods
    if status == OK:
        start_energy(ps, damper, buffers.energy, state)
        tally = begin_tally(buffers.response, parts.ground, parts.ground, ps, state)
        energy = peak if buffers.energy is None else buffers.energy
        wanted = OrbitBuffers(
            limit_log, buffers.section, buffers.by_period, buffers.impacts, energy,
            buffers.clearance, None, tally, None,
        )  # fmt: skip
        sampled = Span(first, span.periods, span.stops)
        status = run(prepared, wanted, sampled, state, None, None)
        time = span.periods * (2.0 * math.pi / ps.omega)
        report(buffers.response, tally, ps, damper, time)
        # the largest energies of the whole run include those of the sampled periods
        if buffers.energy is not None and peak is not None:
            peak[0], peak[1] = max(peak[0], buffers.energy[0]), max(peak[1], buffers.energy[1])
        report_violation(buffers.violation, limit_log)
        if overflowed(buffers.energy) or overflowed(peak):
            return DIVERGED
        if span.periods > 0 and overflowed(buffers.response):
            return DIVERGED
    return status


# ---- energies and the limit ----------------------------------------------------------------------


@jit
def start_energy(ps, damper, energy, state):
    """Reset the largest energies to those of the first state."""
    if energy is not None:
        energy[0], energy[1] = 0.0, 0.0
        note_energy(ps, damper, energy, state[0], state[1], state[2], state[3])


@jit
def overflowed(record):
    if record is None:
        return False
    fine = True
    for i in range(len(record)):
        fine = fine and finite(record[i])
    return not fine


@jit
def lacks_limit(violation, limit):
    """Return True if a scene has a limit, but the limit is not a finite number."""
    if violation is None:
        return False
    return not finite(limit)


@jit
def begin_limit_log(violation, limit, state):
    """Return the log of a limit, None if the scene has none.

    A start beyond the limit, to which a sweep may lead, is a violation at time zero.
    """
    if violation is None:
        return None
    log = np.zeros(6)
    log[LIMIT], log[FIRST_VIOLATION] = limit, np.nan
    if state[2] > limit:
        note_violation(log, 0.0)
        log[EXCESS] = state[2] - limit
    return log


@jit
def report_violation(violation, limit_log):
    """Fill the violations (3,) of an orbit: time of the first [s], greatest depth [m], number."""
    if violation is not None:
        violation[0], violation[1] = limit_log[FIRST_VIOLATION], limit_log[EXCESS]
        violation[2] = limit_log[NUMBER]


# ---- the section map -----------------------------------------------------------------------------


@jit
def cell_flow(parts, cell, begun):
    """Return the `variations.Flow` of a cell, and a status; the flow is valid only if it is OK.

    begun: `flight.Begun` of share 1, the phase of the sections. Variations use the cell's
    grid, or one of their own if the method is rk4 or contacts are linear.
    """
    status, prepared = checked_cell(parts, cell, 1, begun)
    if parts.rk4 is not None or says(parts.near, "LINEAR") or says(parts.far, "LINEAR"):
        n = max(cells_of(prepared.ps, prepared.damper), 1)
        return flow_of(prepared, grid_from(prepared.ps, prepared.damper, n, begun)), status
    return flow_of(prepared, prepared.grid), status


# --------------------------------------------------------------------------------------------------
# Orbits that begin at any phase of the forcing.
#
# A part of a forcing period, such as that up to the next section, gets a second grid, which divides
# it into as many cells as the first grid divides a period. The time loop is the same; it is
# compiled for this only if an orbit begins so.


@jit(entry=True)
def enter(begin, end, parts, cells, begun, starts, status):
    """Advance starts `begin` to `end` - 1 over parts of a period.

    cells (n,); begun (n, 2): the share of the forcing's period before each start, and that over
    which it is advanced, up to the next section at most; starts (n, 4): (x1, v1, r, s), which
    change in place unless that fails; status (n,).
    """
    for lane in range(begin, end):
        status[lane], y, share = OK, starts[lane], begun[lane, 1]
        if not bounded(y[0], y[1], y[2], y[3]):
            status[lane] = DIVERGED
        elif share > 0.0:
            cell_status, prepared = checked_cell(
                parts, cells[lane], 1, Begun(begun[lane, 0], share)
            )
            if cell_status == OK:
                state = new_state()
                for i in range(4):
                    state[i] = y[i]
                on_ground(prepared.damper, state)
                set_mode(prepared.near, prepared.far, prepared.damper, state)
                noted = OrbitBuffers(None, None, None, None, None, None, None, None, None)
                cell_status = run(prepared, noted, Span(0, 1, 1), state, None, None)
                if cell_status == OK:
                    for i in range(4):
                        y[i] = state[i]
            status[lane] = cell_status
