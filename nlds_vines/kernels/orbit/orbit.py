"""The one time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it; it is never summed up, so that the phase of
the section is as sharp after a million periods as after one.
"""

from __future__ import annotations

from ..events.exact import fly
from ..events.fixed_step import FixedGrid, fly_fixed, phase_in_step
from ..events.sides import (
    follow_at,
    leave_wall,
    leaves,
    may_leave,
    structure_at,
)
from ..impact.arc import Arc
from ..motion.driven import Linear, carry
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
from .repetition import periods_to_run, reference_for, renew, repeat, sum_up_period

HUGE = 1.0e150  # beyond any state of a damped system; NaN is caught by the same comparison
MOST_TOUCHES = 100_000  # touches in one period: beyond it the status is STEP_BUDGET
STATE_SIZE = (
    15  # numbers of the state kept between calls: x1, v1, r, s, q = sqrt(z), mode, and from
)
STATE_AHEAD = 6  # STATE_AHEAD on what is `Ahead` inside a short impact


@jit
def set_mode(near, far, state):
    """Set q and the mode of a state (x1, v1, r, s) at phase zero: in flight, or inside a contact.

    A start on the wall that moves or is pressed into it is a touch of the first instant, which the
    first flight finds; a start beyond the wall is a contact already under way. Into a rigid wall
    nothing comes: a start beyond it is one on it, and one at rest on it a contact under way.
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


@jit
def on_ground(damper, state):
    """Set r and s of a state to x1 and v1 if walls limit the structure itself."""
    if is_a(damper, Ground):
        state[2], state[3] = state[0], state[1]


@jit
def phase_on(rk4, grid, j, x):
    """Return the instant (`drive`) at place x of cell j, by the method's grid."""
    if rk4 is None:
        return phase_of(grid, j, x) if is_a(grid.begun, Loaded) else phase_at(grid, j, x)
    return phase_in_step(grid, j, x)


@jit
def bounded(x1, v1, r, s):
    """Return True if a state is finite and not absurdly large."""
    return abs(x1) + abs(v1) + abs(r) + abs(s) < HUGE


@jit
def begin_log(limit_log, began):
    """Count the log of a limit from the time [s] at which the period began."""
    if limit_log is not None:
        limit_log[ORIGIN] = began


@jit
def impact_rows(impacts):
    """Return the rows to which a contact adds what it has been, None where there are none."""
    if is_a(impacts, Touches):
        return None
    return impacts


@jit
def keep_slowest(slowest, s):
    """Lower the smallest approach speed to that of a touch."""
    if slowest is not None:
        slowest[0] = min(slowest[0], abs(s))


@jit
def fly_on(flight, watch, begun, stop, y):
    if flight.rk4 is None:
        return fly(flight, watch, begun, stop, y)
    return fly_fixed(flight, watch, begun, stop, y)


@jit
def after_contact(ps, damper, impacts, event, felt, began, time, y):
    """Note a contact, and, at its release, that it has ended in the state y = (x1, v1, r, s).

    felt: its depth [m] and its greatest force [N]; began, time: as of `note_release`.
    """
    if impacts is not None:
        note_depth(impacts, felt[0])
        note_force(impacts, felt[1])
        if event == RELEASED:
            note_release(ps, damper, impacts, began, time, y)


@jit
def at_section(damper, section, row, x1, v1, r, s):
    if section is not None and row < len(section):
        note_section(damper, section, row, x1, v1, r, s)


@jit
def bare_arc(arc):
    if arc is None:
        return None
    return Arc(arc.tolerance, arc.settled, arc.levels, bare(arc.table))


@jit
def bare_if_any(row):
    if row is None:
        return None
    return bare(row)


@jit
def bare_impacts(impacts):
    if impacts is None:
        return None
    data, filled, room = bare(impacts.data.reshape(-1)), bare(impacts.filled), len(impacts.data)
    if is_a(impacts, Touches):
        return Touches(data, filled, room)
    return Impacts(data, filled, room)


@by_wall
def bare_held(held):
    return held


@jit
def grid_in_loop(rk4, grid):
    if rk4 is None:
        return bare_grid(grid)
    cosine, middle = bare(grid.cosine), bare(grid.middle)
    w = bare(grid.table)
    return FixedGrid(grid.n, grid.h, grid.turn, grid.rate, cosine, middle, w, grid.begun)


@jit
def side_of(prepared, wall, sign, held):
    """Return the `Side` of a wall of a cell, None where it is."""
    if wall is None:
        return None
    arc = bare_arc(prepared.arc) if says(wall, "SHORT_IMPACTS") else None
    return Side(
        prepared.rk4, prepared.ps, prepared.damper, wall, sign, arc, bare_held(held),
        prepared.contact_steps, prepared.grid.rate, bare(prepared.scratch),
    )  # fmt: skip


@jit
def orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance `state` (STATE_SIZE,) over a `Span` and note what has a buffer; return a status.

    prepared: a `Prepared` cell with walls; span.stops must divide the cells of its grid. buffers:
    `OrbitBuffers`. tangent: (16,) four variations one after the other, or None; `exact_grid`, that
    of the exact flight, propagates them whatever the method.
    """
    # Named once: a field with arrays costs reference counts each time that it is read; and bare:
    # each array that is handed on in the loop costs them again.
    rk4, ps, damper = prepared.rk4, prepared.ps, prepared.damper
    near, far, k = prepared.near, prepared.far, bare(prepared.scratch)
    grid = grid_in_loop(rk4, prepared.grid)
    near_side = side_of(prepared, near, 1.0, prepared.held_near)
    far_side = side_of(prepared, far, -1.0, prepared.held_far)
    flight = Flight(rk4, ps, damper, near, far, grid)
    through_air = Linear(None, ps, damper, 1.0, exact_grid)
    limit_log, slowest, section = bare_if_any(buffers.limit_log), buffers.slowest, buffers.section
    impacts, by_period = bare_impacts(buffers.impacts), buffers.by_period
    rows, tally = impact_rows(impacts), bare_tally(buffers.tally)
    energy, clearance = bare_if_any(buffers.energy), bare_if_any(buffers.clearance)
    watch = Watch(limit_log, energy, clearance, rows, tangent, tally)
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
    for i in range(STATE_SIZE - STATE_AHEAD):
        k[AHEAD + i] = state[STATE_AHEAD + i]
    arc = bare_arc(prepared.arc)
    room = reference_for(tangent, buffers, prepared.grid.begun, arc)
    reference = bare_if_any(room)
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
                    begin_log(limit_log, began)
                    event = CLEARED
                    if mode != FLYING:
                        event, j, x, q, x1, v1, r, s = leave_wall(
                            near_side, far_side, mode, watch, grid,
                            end_of_cells(grid, j, stop), begun, (q, x1, v1, r, s),
                        )  # fmt: skip
                    if event == CLEARED:
                        mode = FLYING
                        event, j, x, x1, v1, r, s = fly_on(
                            flight, watch, (j, x), stop, (x1, v1, r, s)
                        )
                    if tangent is not None:
                        time = (j + x - place) * grid.h
                        carry(tangent, through_air, place / grid.n, before, time)
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
                    keep_slowest(slowest, s)
                    if touches > MOST_TOUCHES:
                        return STEP_BUDGET
                # Follow the contact, to its release or to the section.
                end, time = end_of_cells(grid, j, stop), began + (j + x) * grid.h
                left = (end - j - x) * grid.h
                touched = time, phase_on(rk4, grid, j, x), (j + x) / grid.n
                event, q, now, took, felt = follow_at(
                    near_side, far_side, mode, watch, touched, left, (q, s, x1, v1)
                )
                x1, v1, r, s = now
                place = j + x + took / grid.h
                after_contact(ps, damper, rows, event, felt, began, place * grid.h, now)
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
            at_section(joined(damper), section, p * span.stops + i, x1, v1, r, s)
            note_sums(ps, damper, buffers.sums, p * span.stops + i, tally)
        if not bounded(x1, v1, r, s):
            return DIVERGED
        p += 1
        y = x1, v1, r, s, q, float(mode)
        sum_up_period(reference, tally)
        last = periods_to_run(reference, arc, watch, impacts, k, p, last, y)
    repeat(room, buffers, grid, tally, impacts, span, last)
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
    for i in range(STATE_SIZE - STATE_AHEAD):
        state[STATE_AHEAD + i] = k[AHEAD + i]
    return OK


@jit
def share_of(flight, watch, maps, share, y):
    """Advance a scene without walls from the state y by a share (i, stops) of a period.

    By `maps` (`maps_of`) if there are, otherwise cell by cell, as what is summed up always is.
    """
    i, stops = share
    first, stop = flight.grid.n * i // stops, flight.grid.n * (i + 1) // stops
    if maps is None:
        return fly_on(flight, watch, (first, 0.0), stop, y)[3:]
    if watch.tally is not None:
        fly_on(flight, watch, (first, 0.0), stop, y)
    return step(flight.damper, maps, i, y[0], y[1], y[2], y[3])


@jit
def linear_orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance a scene without walls (arguments and result as those of `orbit`)."""
    rk4, ps, damper, grid = prepared.rk4, prepared.ps, prepared.damper, prepared.grid
    section, energy, stops = buffers.section, buffers.energy, span.stops
    y = state[0], state[1], state[2], state[3]
    # One map from stop to stop, if nothing is noted in between and the force is periodic.
    maps = (
        None
        if rk4 is not None or energy is not None or is_a(grid.begun, Loaded)
        else coarse_map(ps, damper, grid, stops)
    )
    watch = Watch(None, energy, None, None, None, bare_tally(buffers.tally))
    flight = Flight(rk4, ps, damper, None, None, grid)
    through_air = Linear(None, ps, damper, 1.0, exact_grid)
    for p in range(span.periods):
        start = y
        for i in range(stops):
            y = share_of(flight, watch, maps, (i, stops), y)
            at_section(damper, section, p * stops + i, y[0], y[1], y[2], y[3])
            note_sums(ps, damper, buffers.sums, p * stops + i, watch.tally)
        if tangent is not None:
            carry(tangent, through_air, 0.0, start, grid.h * grid.n)
        if not bounded(y[0], y[1], y[2], y[3]):
            return DIVERGED
    state[0], state[1], state[2], state[3] = y
    return OK


@jit
def run(prepared, buffers, span, state, tangent, exact_grid):
    """Advance a scene with walls (`orbit`), or one without: neither knows of the other."""
    if prepared.near is None and prepared.far is None:
        return linear_orbit(prepared, buffers, span, state, tangent, exact_grid)
    return orbit(prepared, buffers, span, state, tangent, exact_grid)
