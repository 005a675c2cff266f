"""Flight from one event to the next by exact cells and certified touches."""

from __future__ import annotations

from .compiling import chosen, jit
from .flight import CELLS, at, look, phase_at, step
from .observe import LEVEL, note_energy
from .peaks import ALL, factor_bends, note_peaks, suspects
from .scene import scale_of
from .touch import LOST, NOWHERE, first_touch, nearest_miss, note_limit, tightened

SECTION, TOUCH_NEAR, TOUCH_FAR, ASTRAY = 0, 1, 2, 3  # events that end a flight
SPAN = 4  # cells for which one bound of the motion is used


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
def bounds_in(near, far, w, bend, jerk):
    """Return `touch.tightened` bounds where there are walls to come near."""
    if near is None and far is None:
        return lambda near, far, w, bend, jerk: (bend, jerk)
    return lambda near, far, w, bend, jerk: tightened(w, bend, jerk)


@jit
def touch_in(near, far, grid, end, bend, jerk):
    """Return (place, event) of the first touch in [0, end] of the cell looked at."""
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
def clear(near, far, r0, r1, slack):
    """Prove from its two ends that a cell holds no touch (False: look closer)."""
    proven = True
    if near is not None:
        proven = max(r0, r1) + slack < near.gap
    if far is not None:
        proven = proven and max(-r0, -r1) + slack < far.gap
    return proven


@jit
def may_miss(near, far, clearance, r0, r1, slack):
    """Tell whether the cell between r0 and r1 could hold a closer miss than seen so far."""
    possible = False
    if near is not None:
        possible = max(r0, r1) + slack > near.gap - clearance[0]
    if far is not None:
        possible = possible or max(-r0, -r1) + slack > far.gap - clearance[0]
    return possible


@jit
def note_misses(near, far, clearance, grid, end, bend, jerk):
    """Lower the smallest near miss to those in [0, end] of the cell looked at, which is clear."""
    if near is not None:
        best = nearest_miss(grid.table, 1.0, end, near.gap - clearance[0], bend, jerk)
        clearance[0] = min(clearance[0], near.gap - best)
    if far is not None:
        best = nearest_miss(grid.table, -1.0, end, far.gap - clearance[0], bend, jerk)
        clearance[0] = min(clearance[0], far.gap - best)


@jit
def phase_of(ps, grid, j, x):
    """Return `phase_at`, tabulated at the start of a cell."""
    if x == 0.0:
        return grid.table[CELLS + 6 * j + 4], grid.table[CELLS + 6 * j + 5]
    return phase_at(ps, grid, j, x)


@jit
def fly(ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s):
    """Fly from place x of cell j to the next touch or to the start of the cell `stop`.

    Returns (event, j, x, x1, v1, r, s) with event SECTION, TOUCH_NEAR or TOUCH_FAR, or ASTRAY where
    a touch could not be told from a miss.
    """
    while j < stop:
        last = min(j + SPAN, stop)
        ahead = grid.push * grid.h * (last - j)
        scale = scale_of(ps, damper, x1, v1, r, s) + ahead
        bend, jerk, second, swell = bounds_of(ps, grid, scale)
        while j < last:
            y = step(damper, grid.table, j, x1, v1, r, s)
            closer = x > 0.0 or not clear(near, far, r, y[2], 0.125 * bend)
            doubt, suspected = closer, ALL
            if energy is not None and not closer:
                bends, now = factor_bends(ps, grid, second), (x1, v1, r, s)
                suspected = suspects(ps, damper, energy, grid, bends, swell, j, now, y)
                doubt = suspected != 0
            if clearance is not None:
                doubt = doubt or may_miss(near, far, clearance, r, y[2], 0.125 * bend)
            if watch is not None:
                doubt = doubt or max(r, y[2]) + 0.125 * bend >= watch[LEVEL]
            if doubt:
                cosine, sine = phase_of(ps, grid, j, x)
                look(grid, x1, v1, r, s, cosine, sine)
                bent, jerked = bounds_in(near, far, grid.table, bend, jerk)
                end = 1.0 - x
                if x > 0.0:
                    y = at(grid.table, end)
                place, event = end, SECTION
                if closer:
                    place, event = touch_in(near, far, grid, end, bent, jerked)
                if event == ASTRAY:
                    return event, j, x, x1, v1, r, s
                if energy is not None:
                    note_peaks(ps, damper, energy, grid, cosine, sine, min(place, end), suspected)
                if watch is not None:
                    w, reached = grid.table, min(place, end)
                    note_limit(w, watch, j + x, grid.h, reached, bent, jerked)
                if event != SECTION:
                    x1, v1, r, s = at(grid.table, place)
                    return event, j, x + place, x1, v1, r, s
                if clearance is not None:
                    note_misses(near, far, clearance, grid, end, bent, jerked)
            if energy is not None:
                note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])
            x1, v1, r, s = y
            j, x = j + 1, 0.0
    return SECTION, j, 0.0, x1, v1, r, s
