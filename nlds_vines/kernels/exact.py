"""Flight from one event to the next by exact cells and certified touches."""

from __future__ import annotations

from .codes import ASTRAY, SECTION, TOUCH_FAR, TOUCH_NEAR
from .compiling import chosen, jit
from .flight import CELLS, at, cell_polynomial, phase_at, step
from .observe import LEVEL, note_energy
from .peaks import ALL, factor_bends, note_peaks, suspects
from .scene import scale_of
from .touch import LOST, NOWHERE, first_touch, nearest_miss, note_limit, tightened

SPAN = 4  # cells for which one bound of the motion is used: it costs a square root


@jit
def bounds_of(ps, grid, scale):
    """Return bounds for motions of at most the energy scale S.

    (second and third derivative of r by the place in a cell [m], second derivative of S by time,
    second derivative of an energy by the place [J])
    """
    first = grid.rate * scale + grid.push
    second = grid.rate * (first + grid.push)
    h2 = grid.h * grid.h
    return (
        (grid.bend * scale + ps.force) * h2,
        (grid.bend * first + ps.omega * ps.force) * h2 * grid.h,
        second,
        (first * first + scale * second) * h2,
    )


@chosen
def bounds_near_walls(near, far, w, bend, jerk):
    """Return `touch.tightened` bounds where there are walls to come near."""
    if near is None and far is None:
        return lambda near, far, w, bend, jerk: (bend, jerk)
    return lambda near, far, w, bend, jerk: tightened(w, bend, jerk)


@jit
def touch_in(near, far, grid, end, bend, jerk):
    """Return (place, event) of the first touch in [0, end] of the expanded cell."""
    place, event = NOWHERE, SECTION
    if near is not None:
        place = first_touch(grid.table, 0.0, end, 1.0, near.gap, bend, jerk)
        if place <= end:
            event = TOUCH_NEAR
    if far is not None:
        other = first_touch(grid.table, 0.0, end, -1.0, far.gap, bend, jerk)
        if other <= end and other < place:
            place, event = other, TOUCH_FAR
    if place == LOST:
        event = ASTRAY
    return place, event


@jit
def proves_no_touch(near, far, r0, r1, slack):
    """Prove from its two ends that a cell holds no touch (False: look closer)."""
    proven = True
    if near is not None:
        proven = max(r0, r1) + slack < near.gap
    if far is not None:
        proven = proven and max(-r0, -r1) + slack < far.gap
    return proven


@jit
def may_hold_a_miss(near, far, clearance, r0, r1, slack):
    """Tell whether the cell between r0 and r1 could hold a closer miss than seen so far."""
    possible = False
    if near is not None:
        possible = max(r0, r1) + slack > near.gap - clearance[0]
    if far is not None:
        possible = possible or max(-r0, -r1) + slack > far.gap - clearance[0]
    return possible


@jit
def note_misses(near, far, clearance, grid, end, bend, jerk):
    """Lower the smallest near miss to those in [0, end] of the expanded cell, which is clear."""
    if near is not None:
        best = near.gap - clearance[0]
        top = nearest_miss(grid.table, 0.0, 1.0, end, best, bend, jerk)
        if top > best:
            clearance[0] = near.gap - top
    if far is not None:
        best = far.gap - clearance[0]
        top = nearest_miss(grid.table, 0.0, -1.0, end, best, bend, jerk)
        if top > best:
            clearance[0] = far.gap - top


@jit
def phase_of(grid, j, x):
    """Return `phase_at`, tabulated at the start of a cell."""
    if x == 0.0:
        return grid.table[CELLS + 6 * j + 4], grid.table[CELLS + 6 * j + 5]
    return phase_at(grid, j, x)


@jit
def fly(rk4, ps, damper, near, far, limit_log, energy, clearance, grid, stop, j, x, x1, v1, r, s):
    """Fly from place x of cell j to the next touch or to the start of the cell `stop`.

    Returns (event, j, x, x1, v1, r, s) with event SECTION, TOUCH_NEAR or TOUCH_FAR, or ASTRAY where
    a touch could not be told from a miss. `rk4` is None; `fly_fixed` has the same arguments.
    """
    # hot: the loop over cells; the state stays in registers
    while j < stop:
        # Bounds of the motion over the next cells.
        last = min(j + SPAN, stop)
        ahead = grid.push * grid.h * (last - j)
        scale = scale_of(ps, damper, x1, v1, r, s) + ahead
        bend, jerk, second, energy_bend = bounds_of(ps, grid, scale)
        while j < last:
            # The state at the end of the cell, as if nothing happened before.
            y = step(damper, grid.table, j, x1, v1, r, s)
            # What could happen before? A touch, a peak of an energy, a near miss, a passage.
            closer = x > 0.0 or not proves_no_touch(near, far, r, y[2], 0.125 * bend)
            doubt, suspected = closer, ALL
            if energy is not None and not closer:
                bends, now = factor_bends(ps, grid, second), (x1, v1, r, s)
                suspected = suspects(ps, damper, energy, grid, bends, energy_bend, j, now, y)
                doubt = suspected != 0
            if clearance is not None:
                doubt = doubt or may_hold_a_miss(near, far, clearance, r, y[2], 0.125 * bend)
            if limit_log is not None:
                doubt = doubt or max(r, y[2]) + 0.125 * bend >= limit_log[LEVEL]
            if doubt:
                # The polynomial of the cell, from x on, and the first touch on it.
                cosine, sine = phase_of(grid, j, x)
                cell_polynomial(grid, x1, v1, r, s, cosine, sine)
                bent, jerked = bounds_near_walls(near, far, grid.table, bend, jerk)
                end = 1.0 - x
                if x > 0.0:
                    y = at(grid.table, end)
                place, event = end, SECTION
                if closer:
                    place, event = touch_in(near, far, grid, end, bent, jerked)
                if event == ASTRAY:
                    return event, j, x, x1, v1, r, s
                # Note what is wanted up to the touch or the end of the cell.
                if energy is not None:
                    note_peaks(ps, damper, energy, grid, cosine, sine, min(place, end), suspected)
                if limit_log is not None:
                    w, reached = grid.table, min(place, end)
                    note_limit(w, limit_log, j + x, grid.h, reached, bent, jerked)
                if event != SECTION:
                    x1, v1, r, s = at(grid.table, place)
                    return event, j, x + place, x1, v1, r, s
                if clearance is not None:
                    note_misses(near, far, clearance, grid, end, bent, jerked)
            # Go on from the end of the cell.
            if energy is not None:
                note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])
            x1, v1, r, s = y
            j, x = j + 1, 0.0
    return SECTION, j, 0.0, x1, v1, r, s
