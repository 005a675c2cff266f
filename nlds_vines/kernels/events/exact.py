"""Flight from one event to the next by exact cells and certified touches."""

from __future__ import annotations

from ..motion.flight import at, bare_grid, bounds_of
from ..motion.load_cells import (
    END,
    OF_CELL,
    Loaded,
    end_of_cell,
    phase_of,
    polynomial_from,
    pushed_over,
)
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.codes import ASTRAY, SECTION, TOUCH_FAR, TOUCH_NEAR
from ..scene.drive import drive_now
from ..scene.scene import scale_of
from ..watch.observe import LIMIT
from ..watch.response import may_set_a_record, note_peaks, record_breakers, tally_piece, work_at
from ..watch.touch import (
    CLEAR,
    LOST,
    NOWHERE,
    nearest_miss,
    note_limit,
    outlook,
    tightened,
    touch_of,
)

SPAN = 4  # cells that share one bound of the motion, which costs a square root


@jit
def touch_in(near, far, grid, end, y, bounds):
    """Return (place, event) of the first touch in [0, end] of the expanded cell.

    The event is SECTION without a touch. y: the state at `end`.
    """
    place, event = NOWHERE, SECTION
    if near is not None:
        place = touch_of(grid, end, 1.0, near.gap, y, bounds)
        if place <= end:
            event = TOUCH_NEAR
    if far is not None:
        other = touch_of(grid, end, -1.0, far.gap, y, bounds)
        if other <= end and other < place:
            place, event = other, TOUCH_FAR
    if place == LOST:
        event = ASTRAY
    return place, event


@jit
def ends_clear(wall, sign, y, z, length, bounds):
    """Return True if the states y and z at its ends prove that a piece holds no touch of a wall.

    length: of the piece [s], at most that of a cell.
    """
    if wall is None:
        return True
    s0, s1 = sign * y[3] * length, sign * z[3] * length
    return outlook(wall.gap, sign * y[2], sign * z[2], s0, s1, bounds.fourth) == CLEAR


@jit
def proves_no_touch(near, far, r0, r1, slack):
    """Return True if r at its two ends proves that a cell holds no touch.

    slack: M h^2 / 8, M >= |d2r/dt2|.
    """
    proven = True
    if near is not None:
        proven = max(r0, r1) + slack < near.gap
    if far is not None:
        proven = proven and max(-r0, -r1) + slack < far.gap
    return proven


@jit
def may_hold_a_miss(near, far, clearance, r0, r1, slack):
    """Return True if the cell between r0 and r1 may hold a closer miss than those so far."""
    possible = False
    if near is not None:
        possible = max(r0, r1) + slack > near.gap - clearance[0]
    if far is not None:
        possible = possible or max(-r0, -r1) + slack > far.gap - clearance[0]
    return possible


@jit
def note_misses(near, far, clearance, grid, end, bounds, touches):
    """Lower the smallest near miss to those in [0, end] of the expanded cell.

    touches: whether a wall is touched at the end. The other wall may have been missed, or the same
    one before.
    """
    bend, jerk = tightened(grid.table, bounds.bend, bounds.jerk)
    if near is not None:
        best = near.gap - clearance[0]
        top = nearest_miss(grid.table, 0.0, 1.0, end, best, bend, jerk, touches)
        if top > best:
            clearance[0] = near.gap - top
    if far is not None:
        best = far.gap - clearance[0]
        top = nearest_miss(grid.table, 0.0, -1.0, end, best, bend, jerk, touches)
        if top > best:
            clearance[0] = far.gap - top


@jit
def fill(grid, phase, y, filled):
    """Fill COEF with the flight from y at the instant `phase` unless `filled`; return True."""
    if not filled:
        polynomial_from(grid, y, phase)
    return True


@jit
def fly(flight, watch, begun, stop, y):
    """Fly from `begun` = (cell j, place x in it) to the next touch or the start of the cell `stop`.

    y: the state (x1, v1, r, s) at the beginning. Returns (event, j, x, x1, v1, r, s) with event
    SECTION, TOUCH_NEAR or TOUCH_FAR, or ASTRAY if a touch could not be told from a miss.
    """
    ps, damper, near, far = flight.ps, flight.damper, flight.near, flight.far
    limit_log, energy, clearance = watch.limit_log, watch.energy, watch.clearance
    tally = watch.tally
    (x1, v1, r, s), (j, x) = y, begun  # the state stays in registers
    grid, event = bare_grid(flight.grid), SECTION
    if energy is not None:
        before = work_at(ps, damper, (x1, v1, r, s), drive_now(phase_of(grid, j, x)))
        energy[0], energy[1] = max(energy[0], before[0]), max(energy[1], before[1])
    while j < stop and event == SECTION:
        # Bounds of the motion over the next cells.
        last = min(j + SPAN, stop)
        pushed, bound = pushed_over(ps, grid, j, last)
        ahead = bound.push * grid.h * (last - j)
        scale = scale_of(ps, damper, x1, v1, r, s) + ahead
        bounds = bounds_of(pushed, bound, scale)
        slack = 0.125 * bounds.bend
        while j < last and event == SECTION:
            # The state at the end of the cell without a touch.
            now, phase = (x1, v1, r, s), phase_of(grid, j, x)
            end, filled = 1.0 - x, False
            if x > 0.0:
                filled = fill(grid, phase, now, False)
                y = at(grid.table, end)
            else:
                y = end_of_cell(grid, damper, j, now)
            # The first touch, unless the two ends prove that there is none.
            place = end
            clear = x == 0.0 and proves_no_touch(near, far, r, y[2], slack)
            if not clear:
                clear = ends_clear(near, 1.0, now, y, end * grid.h, bounds)
                clear = clear and ends_clear(far, -1.0, now, y, end * grid.h, bounds)
            if not clear:
                filled = fill(grid, phase, now, filled)
                place, event = touch_in(near, far, grid, end, y, bounds)
                if event == ASTRAY:
                    break
                if event == SECTION:
                    place = end
                else:
                    y = at(grid.table, place)
            # Record the motion up to the touch or the end of the cell.
            if energy is not None:
                if is_a(flight.grid.begun, Loaded):  # a load may jump between two cells
                    before = work_at(ps, damper, now, drive_now(phase_of(grid, j, x)))
                drive = drive_now(phase_of(grid, j, 1.0 if event == SECTION else x + place))
                if is_a(flight.grid.begun, Loaded) and event == SECTION:  # that before a jump
                    drive = grid.begun.sums[OF_CELL * j + END]
                after = work_at(ps, damper, y, drive)
                energy[0], energy[1] = max(energy[0], after[0]), max(energy[1], after[1])
                if may_set_a_record(damper, energy, bound, bounds, place, before, after):
                    bodies = record_breakers(damper, energy, bound, bounds, place, before, after)
                    if bodies != 0:
                        filled = fill(grid, phase, now, filled)
                        note_peaks(ps, damper, energy, grid, place, bodies)
                before = after
            if limit_log is not None and (
                x > 0.0 or event != SECTION or max(r, y[2]) + slack >= limit_log[LIMIT]
            ):
                filled = fill(grid, phase, now, filled)
                note_limit(grid, limit_log, j + x, place, bounds.bend, bounds.jerk)
            if (
                clearance is not None
                and clearance[0] > 0.0
                and (event != SECTION or may_hold_a_miss(near, far, clearance, r, y[2], slack))
            ):
                filled = fill(grid, phase, now, filled)
                note_misses(near, far, clearance, grid, place, bounds, event != SECTION)
            if tally is not None:
                filled = fill(grid, phase, now, filled)
                tally_piece(tally, grid, phase, place)
            # Go on from the touch or the end of the cell.
            x1, v1, r, s = y
            if event == SECTION:
                j, x = j + 1, 0.0
            else:
                x += place
    return event, j, x, x1, v1, r, s
