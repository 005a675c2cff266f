"""The time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it. It is never summed up, so that the phase of
a section has the same error after a million periods as after one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..events.contact import follow_at, leave_wall, leaves, may_leave, structure_at
from ..events.exact import fly
from ..events.fixed_step import FixedGrid, fly_fixed, phase_in_step
from ..impact.arc import Arc
from ..impact.inside import RECALLED_NUMBERS
from ..motion.driven import Driven, Linear, carry
from ..motion.flight import bare_grid, coarse_map, phase_at, step
from ..motion.load_cells import Loaded, began_at, end_of_cells, phase_of
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, says
from ..numerics.fours import bare
from ..scene.by_law import by_wall
from ..scene.codes import (
    ASTRAY,
    CLEARED,
    DIVERGED,
    EXHAUSTED,
    FLYING,
    LEAVING_FAR,
    LEAVING_NEAR,
    OK,
    RELEASED,
    SECTION,
    STEP_BUDGET,
    STOPPED,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from ..scene.law import AHEAD, into, pushes, rests
from ..scene.scene import Flight, Ground, Side, Watch, joined
from ..watch.observe import (
    ORIGIN,
    Impacts,
    Touches,
    note_depth,
    note_force,
    note_release,
    note_section,
    note_touch,
)
from ..watch.response import bare_tally, note_sums
from .repetition import AT, periods_to_run, renew, repeat, sum_up_period

# bound of |x1| + |v1| + |r| + |s|, whose squares stay finite; a comparison with NaN fails, too
HUGE = 1.0e150
MOST_TOUCHES = 100_000  # touches in one period: beyond it the status is STEP_BUDGET
# The state kept between calls: x1, v1, r, s, q = sqrt(z), mode, and from STATE_AHEAD on the
# numbers of `inside.Ahead`.
STATE_SIZE, STATE_AHEAD = 15, 6


@jit
def set_mode(near, far, damper, state):
    """Set q and the mode of a state (x1, v1, r, s): in flight, or inside a contact.

    A state beyond a wall is a contact under way. A state on the wall is in flight, and the first
    flight finds its touch. A rigid wall is not penetrated: a state beyond it is put on it, and a
    state at rest on it is a contact under way. If the walls limit the structure, it is put there.
    """
    state[4], state[5] = 0.0, FLYING
    state[STATE_AHEAD] = 0.0
    scale = abs(state[0]) + abs(state[2])
    if near is not None and (state[2] > near.gap or rests(near, state[2], state[3], scale)):
        state[4], state[2] = into(near, state[2])
        state[5] = TOUCH_NEAR if pushes(near, state[4], state[3]) else LEAVING_NEAR
    if far is not None and (-state[2] > far.gap or rests(far, -state[2], state[3], scale)):
        state[4], r = into(far, -state[2])
        state[2] = -r
        state[5] = TOUCH_FAR if pushes(far, state[4], -state[3]) else LEAVING_FAR
    if is_a(damper, Ground):
        state[0], state[1] = state[2], state[3]


@jit
def on_ground(damper, state):
    """Set r and s of a state to x1 and v1 if the walls limit the structure itself."""
    if is_a(damper, Ground):
        state[2], state[3] = state[0], state[1]


@jit
def bounded(x1, v1, r, s):
    return abs(x1) + abs(v1) + abs(r) + abs(s) < HUGE


@by_wall
def bare_motion(motion):
    return motion


@jit
def side_of(prepared, wall, sign, motion, arc):
    """Return the `Side` of a wall of a cell, None if there is no wall; arc: with a bare table."""
    if wall is None:
        return None
    solved_on = arc if says(wall, "SHORT_IMPACTS") else None
    return Side(
        prepared.rk4, prepared.ps, prepared.damper, wall, sign, solved_on, bare_motion(motion),
        prepared.contact_steps, prepared.grid.rate, bare(prepared.scratch),
    )  # fmt: skip


@jit
def orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance `state` (STATE_SIZE,) over a `Span` and fill the buffers; return a status.

    prepared: a `Prepared` cell with walls; span.stops must divide the cells of its grid. buffers:
    `OrbitBuffers`. tangent: (16,) four variations one after the other, a `Driven`, or None;
    `exact_grid`, the grid of the exact flight, propagates them with either method.
    """
    # Fields with arrays get names and become bare rows: every read of such a field, and every
    # array handed on in the loop, costs counts of references.
    rk4, ps, damper = prepared.rk4, prepared.ps, prepared.damper
    near, far, k = prepared.near, prepared.far, bare(prepared.scratch)
    if rk4 is None:
        grid = bare_grid(prepared.grid)
    else:
        steps = prepared.grid
        grid = FixedGrid(
            steps.n, steps.h, steps.turn, steps.rate, bare(steps.cosine), bare(steps.middle),
            bare(steps.table), steps.begun,
        )  # fmt: skip
    base = prepared.arc
    arc = None if base is None else Arc(base.tolerance, base.settled, base.levels, bare(base.table))
    near_side = side_of(prepared, near, 1.0, prepared.held_near, arc)
    far_side = side_of(prepared, far, -1.0, prepared.held_far, arc)
    fly_on, flight = fly if rk4 is None else fly_fixed, Flight(rk4, ps, damper, near, far, grid)
    through_air = Linear(None, ps, damper, 1.0, exact_grid)
    slowest, section, by_period = buffers.slowest, buffers.section, buffers.by_period
    limit_log, energy = bare(buffers.limit_log), bare(buffers.energy)
    clearance, tally = bare(buffers.clearance), bare_tally(buffers.tally)
    if buffers.impacts is None:
        impacts: Any = None
    else:
        data, filled = buffers.impacts.data, bare(buffers.impacts.filled)
        if is_a(buffers.impacts, Touches):
            impacts = Touches(bare(data.reshape(-1)), filled, len(data))
        else:
            impacts = Impacts(bare(data.reshape(-1)), filled, len(data))
    if tangent is None:
        varied: Any = None
    elif is_a(tangent, Driven):
        varied = Driven(bare(tangent.rows), tangent.rates)
    else:
        varied = bare(tangent)
    rows = impacts if is_a(buffers.impacts, Impacts) else None  # to which contacts add
    # Flights and contacts get the records that they fill and no other ones: what they call is then
    # compiled once for all choices of the others.
    in_flight = Watch(limit_log, energy, clearance, None, None, tally)
    in_contact = Watch(limit_log, energy, None, rows, varied, tally)
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
    for i in range(STATE_SIZE - STATE_AHEAD):
        k[AHEAD + i] = state[STATE_AHEAD + i]
    # Periods that repeat are copied, unless a record depends on more than the state, or counts from
    # the orbit's beginning.
    if tangent is not None or slowest is not None or buffers.limit_log is not None:
        room: Any = None
    elif is_a(prepared.grid.begun, Loaded):
        room = None
    else:
        room = np.zeros(AT.recalled + (0 if arc is None else RECALLED_NUMBERS))
    reference = bare(room)  # while `room` is in use
    if room is not None:
        renew(reference, tally, impacts, k, 0, (x1, v1, r, s, q, float(mode)))
    p, last = 0, span.periods
    while p < last:
        j, x, touches = 0, 0.0, 0
        began = began_at(grid, span.first + p)
        for i in range(span.stops):
            stop = grid.n * (i + 1) // span.stops
            while True:
                if mode == FLYING or leaves(near, far, mode):
                    # Fly to the next event.
                    place, begun, before = j + x, (j, x), (x1, v1, r, s)
                    if buffers.limit_log is not None:
                        limit_log[ORIGIN] = began
                    event = CLEARED
                    if mode != FLYING:
                        event, j, x, q, x1, v1, r, s = leave_wall(
                            near_side, far_side, mode, in_flight, grid,
                            end_of_cells(grid, j, stop), begun, (q, x1, v1, r, s),
                        )  # fmt: skip
                    if event == CLEARED:
                        mode = FLYING
                        event, j, x, x1, v1, r, s = fly_on(
                            flight, in_flight, (j, x), stop, (x1, v1, r, s)
                        )
                    if tangent is not None:
                        time = (j + x - place) * grid.h
                        carry(varied, through_air, place / grid.n, before, time)
                    if event == SECTION:
                        if j < stop:  # a load goes on as another function
                            continue
                        break
                    if event == ASTRAY:
                        return STEP_BUDGET
                    # Note the touch.
                    if not may_leave(near, far) or mode == FLYING:
                        q = 0.0  # unless a wall that has been left pushes again
                    mode, touches = event, touches + 1
                    if by_period is not None:
                        by_period[p, mode - TOUCH_NEAR] += 1
                    if buffers.impacts is not None:
                        touch = mode - TOUCH_NEAR, began, (j + x) * grid.h, (j + x) / grid.n
                        note_touch(ps, damper, impacts, touch, (x1, v1, r, s))
                    if buffers.slowest is not None:
                        slowest[0] = min(slowest[0], abs(s))
                    if touches > MOST_TOUCHES:
                        return STEP_BUDGET
                # Follow the contact, to its release or to the section.
                end, time = end_of_cells(grid, j, stop), began + (j + x) * grid.h
                left = (end - j - x) * grid.h
                if rk4 is not None:
                    phase = phase_in_step(grid, j, x)
                elif is_a(prepared.grid.begun, Loaded):
                    phase = phase_of(grid, j, x)
                else:
                    phase = phase_at(grid, j, x)
                touched = time, phase, (j + x) / grid.n
                event, q, now, took, felt = follow_at(
                    near_side, far_side, mode, in_contact, touched, left, (q, s, x1, v1)
                )
                x1, v1, r, s = now
                place = j + x + took / grid.h
                if is_a(buffers.impacts, Impacts):
                    note_depth(rows, felt[0])
                    note_force(rows, felt[1])
                    if event == RELEASED:
                        note_release(ps, damper, rows, began, place * grid.h, now)
                if not bounded(x1, v1, r, s):
                    return DIVERGED
                if event == EXHAUSTED:
                    return STEP_BUDGET
                if event == STOPPED:
                    j, x = end, 0.0
                    if j < stop:
                        continue
                    break
                # Fly on from the release, or first leave the depth at which the force has vanished.
                if may_leave(near, far) and q > 0.0:
                    mode = LEAVING_NEAR if mode == TOUCH_NEAR else LEAVING_FAR
                else:
                    mode = FLYING
                if took > 0.0:
                    j = min(int(place), end - 1)
                    x = place - j
            # Note the section.
            x1, v1 = structure_at(damper, x1, v1, r, s)
            row = p * span.stops + i
            if section is not None and row < len(section):
                note_section(joined(damper), section, row, x1, v1, r, s)
            note_sums(ps, damper, buffers.sums, row, tally)
        if not bounded(x1, v1, r, s):
            return DIVERGED
        p += 1
        if room is not None:
            y = x1, v1, r, s, q, float(mode)
            sum_up_period(reference, tally)
            last = periods_to_run(reference, arc, in_flight, impacts, k, p, last, y)
    if room is not None:
        repeat(room, buffers, grid, tally, impacts, span, last)
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
    for i in range(STATE_SIZE - STATE_AHEAD):
        state[STATE_AHEAD + i] = k[AHEAD + i]
    return OK


@jit
def linear_orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance a scene without walls; arguments and result as those of `orbit`."""
    rk4, ps, damper, grid = prepared.rk4, prepared.ps, prepared.damper, prepared.grid
    section, energy, stops = buffers.section, buffers.energy, span.stops
    y = state[0], state[1], state[2], state[3]
    # One matrix from stop to stop, if no energy is recorded and the force is periodic.
    cell_by_cell = rk4 is not None or energy is not None or is_a(grid.begun, Loaded)
    maps = None if cell_by_cell else coarse_map(ps, damper, grid, stops)
    watch = Watch(None, energy, None, None, None, bare_tally(buffers.tally))
    fly_on, flight = fly if rk4 is None else fly_fixed, Flight(rk4, ps, damper, None, None, grid)
    through_air = Linear(None, ps, damper, 1.0, exact_grid)
    for p in range(span.periods):
        start = y
        for i in range(stops):
            first, stop = grid.n * i // stops, grid.n * (i + 1) // stops
            if cell_by_cell:
                y = fly_on(flight, watch, (first, 0.0), stop, y)[3:]
            else:
                if buffers.tally is not None:  # sums are taken cell by cell
                    fly_on(flight, watch, (first, 0.0), stop, y)
                y = step(damper, maps, i, y[0], y[1], y[2], y[3])
            row = p * stops + i
            if section is not None and row < len(section):
                note_section(damper, section, row, y[0], y[1], y[2], y[3])
            note_sums(ps, damper, buffers.sums, row, watch.tally)
        if tangent is not None:
            carry(tangent, through_air, 0.0, start, grid.h * grid.n)
        if not bounded(y[0], y[1], y[2], y[3]):
            return DIVERGED
    state[0], state[1], state[2], state[3] = y
    return OK


@jit
def run(prepared, buffers, span, state, tangent, exact_grid):
    """Advance a scene with walls by `orbit`, one without walls by `linear_orbit`."""
    if prepared.near is None and prepared.far is None:
        return linear_orbit(prepared, buffers, span, state, tangent, exact_grid)
    return orbit(prepared, buffers, span, state, tangent, exact_grid)
