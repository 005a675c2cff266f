"""Flight from one event to the next by exact cells and certified touches."""

from __future__ import annotations

from .._jit import jit
from .flight import at, look, phase_at, step
from .observe import energies
from .parts import scale_of
from .touch import ENERGY1, ENERGY2, FAR, NEAR, NOWHERE, first_touch, highest

SECTION, TOUCH_NEAR, TOUCH_FAR = 0, 1, 2  # events that end a flight
SPAN = 16  # cells for which one bound of the motion is used


@jit
def bounds_of(ps, grid, scale):
    """Return bounds of f'' and f''' by the place in a cell: of r [m], then of E1 [J]."""
    first = grid.rate * scale + grid.push  # of the energy coordinates' rate of change, and so on
    second = grid.rate * (first + grid.push)
    third = grid.rate * (second + grid.rate * grid.push)
    h2, h3 = grid.h * grid.h, grid.h * grid.h * grid.h
    return (
        (grid.bend * scale + ps.force) * h2,
        (grid.bend * first + ps.omega * ps.force) * h3,
        (first * first + scale * second) * h2,
        (3.0 * first * second + scale * third) * h3,
    )


@jit
def touch_in(near, far, grid, end, bend, jerk):
    """Return (place, event) of the first touch in [0, end] of the cell looked at."""
    place, event = NOWHERE, SECTION
    if near is not None:
        place = first_touch(grid.coef, 0.0, end, 1.0, near.gap, bend, jerk)
        if place <= end:
            event = TOUCH_NEAR
    if far is not None:
        other = first_touch(grid.coef, 0.0, end, -1.0, far.gap, bend, jerk)
        if other <= end and other < place:
            place, event = other, TOUCH_FAR
    return place, event


@jit
def clear(near, far, r0, r1, bend):
    """Prove from its two ends that a cell holds no touch (False: look closer)."""
    proven = True
    if near is not None:
        proven = max(r0, r1) + 0.125 * bend < near.gap
    if far is not None:
        proven = proven and max(-r0, -r1) + 0.125 * bend < far.gap
    return proven


@jit
def peaks(ps, damper, energy, grid, end, bounds):
    """Raise the largest energies to their maxima over [0, end] of the cell looked at."""
    coef, h = grid.coef, grid.h
    bend, jerk = bounds[2], bounds[3]
    energy[0] = highest(ps, damper, coef, h, 0.0, end, ENERGY1, energy[0], bend, jerk, True)
    if damper is not None:
        bend, jerk = grid.mix * bend, grid.mix * jerk
        energy[1] = highest(ps, damper, coef, h, 0.0, end, ENERGY2, energy[1], bend, jerk, True)


@jit
def may_peak(ps, damper, energy, grid, bounds, y, z):
    """Tell whether an energy could exceed its largest value so far between states y and z."""
    a1, a2 = energies(ps, damper, y[0], y[1], y[2], y[3])
    b1, b2 = energies(ps, damper, z[0], z[1], z[2], z[3])
    slack = 0.125 * bounds[2]
    if max(a1, b1) + slack > energy[0]:
        return True
    return damper is not None and max(a2, b2) + grid.mix * slack > energy[1]


@jit
def misses(ps, damper, near, far, clearance, grid, r0, r1, bounds):
    """Lower the smallest near miss to those of the cell looked at (which holds no touch)."""
    coef, h, slack = grid.coef, grid.h, 0.125 * bounds[0]
    bend, jerk = bounds[0], bounds[1]
    if near is not None:
        best = near.gap - clearance[0]
        if max(r0, r1) + slack > best:
            best = highest(ps, damper, coef, h, 0.0, 1.0, NEAR, best, bend, jerk, False)
            clearance[0] = min(clearance[0], near.gap - best)
    if far is not None:
        best = far.gap - clearance[0]
        if max(-r0, -r1) + slack > best:
            best = highest(ps, damper, coef, h, 0.0, 1.0, FAR, best, bend, jerk, False)
            clearance[0] = min(clearance[0], far.gap - best)


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
def fly(ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s):
    """Fly from place x of cell j to the next touch or to the end of the period.

    Returns (event, j, x, x1, v1, r, s) with event SECTION, TOUCH_NEAR or TOUCH_FAR.
    """
    while j < grid.n:
        last = min(j + SPAN, grid.n)
        ahead = grid.push * grid.h * (last - j)
        bounds = bounds_of(ps, grid, scale_of(ps, damper, x1, v1, r, s) + ahead)
        while j < last:
            y = step(damper, grid.step, grid.forced, j, x1, v1, r, s)
            close = x > 0.0 or not clear(near, far, r, y[2], bounds[0])
            peak, miss = False, False
            if energy is not None:
                peak = close or may_peak(ps, damper, energy, grid, bounds, (x1, v1, r, s), y)
            if clearance is not None:
                miss = close or may_miss(near, far, clearance, r, y[2], 0.125 * bounds[0])
            if close or peak or miss:
                cosine, sine = phase_at(ps, grid, j, x)
                look(grid, x1, v1, r, s, cosine, sine)
                end = 1.0 - x
                if x > 0.0:
                    y = at(grid.coef, end)
                place, event = end, SECTION
                if close:
                    place, event = touch_in(near, far, grid, end, bounds[0], bounds[1])
                if energy is not None:
                    peaks(ps, damper, energy, grid, min(place, end), bounds)
                if event != SECTION:
                    x1, v1, r, s = at(grid.coef, place)
                    return event, j, x + place, x1, v1, r, s
                if clearance is not None and x == 0.0:
                    misses(ps, damper, near, far, clearance, grid, r, y[2], bounds)
            x1, v1, r, s = y
            j, x = j + 1, 0.0
    return SECTION, j, 0.0, x1, v1, r, s
