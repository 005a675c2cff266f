"""The next touch of a flight, certified: no impact is missed, grazing included.

Two proofs, both resting on bounds of derivatives that energy provides (`parts.scale_of`):

* between samples f0 and f1 a step h apart, f stays below max(f0, f1) + M h^2 / 8 with M >= f'';
  the loop over cells uses it and costs one comparison;
* from a point with clearance c = level - f and slope f', the level cannot be reached within the
  step d that solves f' d + M d^2 / 2 = c. Steps of that length creep up to the first touch from
  below, never beyond it, and faster than quadratically, M being taken for the piece at hand.

The same walk finds the maxima of an energy and the smallest clearance of a near miss: the level is
then the largest value seen so far, and reaching it starts a climb to the local maximum.
"""

from __future__ import annotations

import math

from .._jit import jit
from .flight import ORDER

NEAR, FAR, ENERGY1, ENERGY2 = 0, 1, 2, 3  # what is followed along a flight
NOWHERE = 2.0  # no touch in this cell: beyond any place in it, which runs from 0 to 1
MOST_STEPS = 1000  # a walk needs 3 to 8 steps, a grazing one some tens
ROUND_OFF = 4.0e-16


@jit
def reach(clearance, slope, bend):
    """Return how far the level is safe: the d > 0 with slope d + bend d^2 / 2 = clearance."""
    square = slope * slope + 2.0 * bend * clearance
    if square < 0.0:
        return math.inf
    root = math.sqrt(square)
    if slope > 0.0:
        return 2.0 * clearance / (slope + root)
    if bend <= 0.0:
        return math.inf
    return (root - slope) / bend


@jit
def gap_jet(coef, x, sign):
    """Return (f, f', f'') of f = sign r [m] at place x of the cell."""
    k = 4 * ORDER + 2
    f, d, c = coef[k], 0.0, 0.0
    while k > 2:
        k -= 4
        c = c * x + d
        d = d * x + f
        f = f * x + coef[k]
    return sign * f, sign * d, sign * (c + c)


@jit
def first_touch(coef, x, end, sign, level, bend, jerk):
    """Return the first place in [x, end] where sign r rises to `level`, or NOWHERE.

    `coef` holds the Taylor coefficients of the cell, `bend` and `jerk` bound the second and third
    derivative of r by the place. A start on the level that moves away is not a touch.
    """
    tolerance = ROUND_OFF * (abs(level) + abs(coef[2]) + abs(coef[6]))
    for _ in range(MOST_STEPS):
        f, slope, curve = gap_jet(coef, x, sign)
        clearance = level - f
        if clearance <= tolerance:
            if slope > 0.0 or (slope == 0.0 and curve > 0.0):
                return x
            clearance = 0.0
        piece = end - x
        if slope > 0.0:
            piece = min(piece, 2.0 * clearance / slope)
        safe = reach(clearance, slope, min(bend, curve + jerk * piece))
        if slope <= 0.0:  # a step over which the depth stays below round-off is always allowed
            safe = max(safe, math.sqrt(8.0 * tolerance / bend))
        if safe >= piece:
            if x + piece >= end:
                return NOWHERE
            safe = piece
        x += safe
    return x


@jit
def energy_jet(ps, damper, coef, h, x, what):
    """Return (f, f', f'') of E1 or E2 [J] (eq. 6) at place x of the cell, derivatives by x."""
    k = 4 * ORDER
    y0, y1, y2, y3 = 0.0, 0.0, 0.0, 0.0  # displacement, its derivatives over factorials
    while k >= 0:
        y3 = y3 * x + y2
        y2 = y2 * x + y1
        y1 = y1 * x + y0
        y0 = y0 * x + coef[k]
        if damper is not None and what == ENERGY2:
            y0 -= coef[k + 2]  # x2 - rest = x1 - r
        k -= 4
    stiffness, mass = ps.k1, ps.m1 / (h * h)
    if damper is not None and what == ENERGY2:
        stiffness, mass = damper.k2, damper.m2 / (h * h)
    y2 += y2
    y3 *= 6.0
    f = 0.5 * (mass * y1 * y1 + stiffness * y0 * y0)
    slope = y1 * (mass * y2 + stiffness * y0)
    curve = y2 * (mass * y2 + stiffness * y0) + y1 * (mass * y3 + stiffness * y1)
    return f, slope, curve


@jit
def jet(ps, damper, coef, h, x, what):
    """Return (f, f', f'') of what is followed: r, -r, E1 or E2."""
    if what == NEAR:
        return gap_jet(coef, x, 1.0)
    if what == FAR:
        return gap_jet(coef, x, -1.0)
    return energy_jet(ps, damper, coef, h, x, what)


@jit
def summit(ps, damper, coef, h, x, end, what):
    """Return the place of a local maximum reached by climbing from x, at most `end`."""
    low, high = x, end
    for _ in range(60):
        _, slope, curve = jet(ps, damper, coef, h, x, what)
        if slope > 0.0:
            low = x
        else:
            high = x
        move = -slope / curve if curve < 0.0 else math.copysign(end, slope)
        if not low < x + move < high:
            untried = slope > 0.0 and high == end and x < end  # it may rise up to the end
            move = end - x if untried else 0.5 * (low + high) - x
        if abs(move) < 1.0e-9 or (x == end and slope >= 0.0):
            return x
        x += move
    return x


@jit
def highest(ps, damper, coef, h, x, end, what, best, bend, jerk, ends):
    """Return the larger of `best` and the maximum over [x, end] of what is followed.

    With `ends` false only local maxima count: an approach that has not turned round yet is not a
    near miss. `bend` and `jerk` bound the second and third derivative by the place.
    """
    for _ in range(MOST_STEPS):
        f, slope, curve = jet(ps, damper, coef, h, x, what)
        if f >= best and slope > 0.0:
            x = summit(ps, damper, coef, h, x, end, what)
            f, slope, curve = jet(ps, damper, coef, h, x, what)
            turned = x < end
            if turned or ends:
                best = max(best, f)
            if not turned:
                return best
            slope = 0.0
        elif ends and f > best:
            best = f
        tolerance = ROUND_OFF * abs(f) + 1.0e-300
        safe = reach(max(best - f, 0.0), slope, bend)
        safe = max(safe, math.sqrt(8.0 * tolerance / bend))
        if slope <= 0.0 and curve < 0.0:  # falls at least as long as it stays concave
            safe = max(safe, -0.5 * curve / jerk)
        if x + safe >= end:
            return best
        x += safe
    return best
