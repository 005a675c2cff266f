"""The next touch of a flight, certified: no impact is missed, grazing included.

Three proofs, which rest on bounds of derivatives that energy provides (`scene.scale_of`):

* Between samples f0 and f1 a step h apart, f stays below max(f0, f1) + M h^2 / 8 with M >= f''. The
  loop over cells uses this bound, which costs one comparison.
* With the slopes at the two ends and M >= f'''', the cubic through them (`roots`) proves that f
  stays below the level, or rises monotonically and passes it once, or falls monotonically
  (`outlook`). A single passage is located by Newton's method.
* From a point with clearance c = level - f and slope f', the level cannot be reached within the
  step d that solves f' d + M d^2 / 2 = c. Steps of that length approach the first touch from below
  without passing it, and converge faster than quadratically, as M is that of the remaining piece.
  This walk is taken if the two ends prove nothing, a few times in a hundred touches.

The same walk finds the smallest clearance of a near miss: the level is then the closest approach so
far, and reaching it starts a search for the local maximum.
"""

from __future__ import annotations

import math

from ..motion.flight import COEF, ORDER, at
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import TINIEST, exp, log
from ..numerics.roots import guarded, highest, only_rises
from ..scene.drive import most_push
from ..scene.law import TAU, column_at, contact_energy
from ..scene.scene import StepPiece, moved_mass, scale_of
from .observe import BEYOND, EXCESS, LIMIT, ORIGIN, note_violation

AT_R = COEF + 2  # place of r in the table
NOWHERE = 2.0  # no touch in this cell, in which places run from 0 to 1
LOST = -1.0  # no result: the walk took LONGEST_WALK steps
NEAR_MAXIMUM = 1.0e-9  # error of the place of a maximum in a cell; its height errs by the square
LONGEST_WALK = 1000  # steps of a walk, which needs 3 to 8, and some tens at a grazing touch
ROUND_OFF = 4.0e-16  # relative error of a place computed in a cell
CLEAR, CROSSED, UNSURE = range(3)  # results of `outlook`


@jit
def safe_distance(clearance, slope, bend):
    """Return the d > 0 with slope d + bend d^2 / 2 = clearance, infinite if there is none."""
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
def derivatives_at(w, x, sign):
    """Return (f, f', f'') of f = sign r [m] at place x of the cell."""
    if x == 0.0:
        return sign * w[AT_R], sign * w[AT_R + 4], sign * (w[AT_R + 8] + w[AT_R + 8])
    k = 4 * ORDER + AT_R
    f, d, c = w[k], 0.0, 0.0
    while k > AT_R:
        k -= 4
        c = c * x + d
        d = d * x + f
        f = f * x + w[k]
    return sign * f, sign * d, sign * (c + c)


@jit
def tightened(w, bend, jerk):
    """Return bounds of the second and third derivative of r by the place in the expanded cell.

    The smaller ones of `bend` and `jerk`, which follow from the energy, and those of the cell's
    polynomial: a slow motion of a stiff system bends far less than its energy allows.
    """
    second, third = 0.0, 0.0
    for k in range(2, ORDER + 1):
        part = k * (k - 1.0) * abs(w[AT_R + 4 * k])
        second += part
        third += (k - 2.0) * part
    return min(bend, second), min(jerk, third)


@jit
def tolerance_of(w, level):
    """Return the error of r in the expanded cell [m], within which r is taken to be at `level`."""
    return ROUND_OFF * (abs(level) + abs(w[AT_R]) + abs(w[AT_R + 4])) + TINIEST


@jit
def from_rest(w, end, sign):
    """Return (place, whether f rises) for f = sign r, whose slope at the start is zero.

    The first Taylor coefficient c above round-off decides. If it is positive, f at the place has
    risen by the round-off of the motion over the cell, so that a contact that begins there has a
    speed. If it is negative, f stays below its value at the start up to the place, at most `end`,
    as c x^k + d x^(k+1) + ... <= x^k (c + x max(d + ..., 0)).
    """
    size, k = 0.0, 2
    for i in range(2, ORDER + 1):
        size += abs(w[AT_R + 4 * i])
    while k <= ORDER and abs(w[AT_R + 4 * k]) <= ROUND_OFF * size:
        k += 1
    if k > ORDER:  # nothing moves
        return end, False
    c = sign * w[AT_R + 4 * k]
    if c > 0.0:
        return exp(log(ROUND_OFF * (size / c)) / k), True
    place = end
    while True:
        most = 0.0
        for i in range(ORDER, k - 1, -1):
            most = sign * w[AT_R + 4 * i] + place * max(most, 0.0)
        if most < 0.0:
            return place, False
        place *= 0.5


@jit
def first_touch(w, x, end, sign, level, bend, jerk):
    """Return the first place in [x, end] where sign r rises to `level`, NOWHERE, or LOST.

    `w` holds the Taylor coefficients of the cell in COEF; `bend` and `jerk` bound the second and
    third derivative of r by the place. A start at the level that moves away is not a touch.
    """
    tolerance = tolerance_of(w, level)
    bend, jerk = bend + TINIEST, jerk + TINIEST  # a scene at rest without forcing has neither
    for _ in range(LONGEST_WALK):
        f, slope, curve = derivatives_at(w, x, sign)
        clearance = level - f
        if clearance <= tolerance:
            if slope > 0.0 or (slope == 0.0 and curve > 0.0):
                return x
            if x == 0.0 and slope == 0.0:
                x, rises = from_rest(w, end, sign)
                if rises and x <= end:
                    return x
                if x >= end:
                    return NOWHERE
                continue
            clearance = 0.0
        piece = end - x
        if slope > 0.0:
            piece = min(piece, 2.0 * clearance / slope)
        safe = safe_distance(clearance, slope, min(bend, curve + jerk * piece))
        # while r falls, a step is also safe over which r can rise above the wall by round-off only,
        # and one over which r'' stays negative
        if slope <= 0.0:
            safe = max(safe, math.sqrt(8.0 * tolerance / bend))
            safe = max(safe, -curve / jerk)
        if safe >= piece:
            if x + piece >= end:
                return NOWHERE
            safe = piece
        x += safe
    return LOST


@jit
def touch_of(grid, end, sign, level, y, bounds):
    """Return the place in [0, end] of the expanded cell where sign r first rises to `level`.

    y: the state at `end`; bounds: `flight.Bounds`; result as of `first_touch`, which is called if
    the two ends prove nothing.
    """
    w = grid.table
    f0, f1 = sign * w[AT_R], sign * y[2]
    g0, g1 = sign * w[AT_R + 4] * end, sign * y[3] * grid.h * end
    foreseen = outlook(level, f0, f1, g0, g1, bounds.fourth * (end * end) * (end * end))
    place = NOWHERE
    if foreseen == CROSSED:
        place = 0.0  # it starts at the level, or passes it later
        if level - f0 > tolerance_of(w, level):
            place = crossing(grid, end, sign, level, (f1, g0, g1), bounds.bend)
    elif foreseen == UNSURE:
        bend, jerk = tightened(w, bounds.bend, bounds.jerk)
        place = first_touch(w, 0.0, end, sign, level, bend, jerk)
    return place


@jit
def outlook(level, f0, f1, g0, g1, fourth):
    """Return CLEAR, CROSSED or UNSURE: whether f rises to `level` in a piece, from its ends.

    Arguments as of `roots`. CROSSED: f rises monotonically through the level. A start at the level
    that moves away is CLEAR.
    """
    if only_rises(f0, f1, g0, g1, fourth):
        if f0 < level:
            return CROSSED if f1 >= level else CLEAR
    elif f0 <= level and only_rises(-f0, -f1, -g0, -g1, fourth):
        return CLEAR
    return CLEAR if highest(f0, f1, g0, g1, fourth) < level else UNSURE


@jit
def crossing(grid, end, sign, level, ends, bend):
    """Return the place in [0, end] of the expanded cell where sign r passes `level`.

    It rises monotonically and passes it. ends: (f, f', f') at the end, the start and the end, the
    slopes times `end`. A step of Newton's method errs by bend change^2 / (2 slope), bend >= |r''|;
    the last is that whose error is below round-off. LOST after LONGEST_WALK steps.
    """
    low, high = 0.0, end
    f1, g0, g1 = ends
    # The initial guess: the cubic of the inverse function with its values and slopes at the ends.
    f0 = sign * grid.table[AT_R]
    whole = f1 - f0
    u = (level - f0) / whole
    v = 1.0 - u
    x = end * u * (u * (3.0 - 2.0 * u) + v * (whole / g0 * v - whole / g1 * u))
    place = LOST
    for _ in range(LONGEST_WALK):
        x = guarded(x, low, high)
        y = at(grid.table, x)
        excess, slope = sign * y[2] - level, sign * y[3] * grid.h
        if excess > 0.0:
            high = x
        else:
            low = x
        change = excess / slope
        x -= change
        if bend * change * change <= ROUND_OFF * slope:
            place = min(max(x, 0.0), end)
            break
    return place


@jit
def first_maximum(w, x, end, sign, jerk):
    """Return the first place from x on where sign r does not rise, at most `end`.

    With slope f' > 0 and curve f'' it rises at least up to the d with f' + f'' d = jerk d^2 / 2.
    Steps of that length do not pass a maximum, and converge to it as Newton's method.
    """
    jerk = jerk + TINIEST
    for _ in range(LONGEST_WALK):
        _, slope, curve = derivatives_at(w, x, sign)
        if slope <= 0.0:
            return x
        root = math.sqrt(curve * curve + 2.0 * jerk * slope)
        safe = 2.0 * slope / (root - curve) if curve < 0.0 else (curve + root) / jerk
        if x + safe >= end:
            return end
        x += safe
        if not safe > NEAR_MAXIMUM:
            return x
    return x


@jit
def nearest_miss(w, x, sign, end, best, bend, jerk, touches):
    """Return the larger of `best` and the local maxima of sign r over [x, end].

    An approach that still rises at `end` is not a miss. One whose slope at `end` is round-off is a
    miss, as the next cell may begin with a fall, unless the piece ends because it `touches`. `bend`
    and `jerk` bound the second and third derivative by the place.
    """
    bend, jerk = bend + TINIEST, jerk + TINIEST
    level = ROUND_OFF * (abs(w[COEF]) + abs(w[COEF + 4]) + abs(w[AT_R]) + abs(w[AT_R + 4]))
    if touches:
        level = 0.0
    for _ in range(LONGEST_WALK):
        f, slope, curve = derivatives_at(w, x, sign)
        if f >= best and slope > 0.0:
            x = first_maximum(w, x, end, sign, jerk)
            f, slope, curve = derivatives_at(w, x, sign)
            if x >= end and slope > level:
                return best
            best, slope = max(best, f), 0.0
        tolerance = ROUND_OFF * abs(f) + TINIEST
        safe = safe_distance(max(best - f, 0.0), slope, bend)
        safe = max(safe, math.sqrt(8.0 * tolerance / bend))
        if slope <= 0.0 and curve < 0.0:  # falls at least as long as it stays concave
            safe = max(safe, -0.5 * curve / jerk)
        if x + safe >= end:
            return best
        x += safe
    return best


# --------------------------------------------------------------------------------------------------
# Violations of a limit of the spring's shortening r, in flight and in contact.
#
# In a contact with the far wall r is at most -gap: if that is within the limit, the limit holds. A
# contact in which the limit may be passed is stepped (`may_pass`).


@jit
def note_limit(piece, limit_log, begin, end, bend, jerk):
    """Record the violations of the limit of r over [0, end] of a piece.

    begin: of the piece since the origin of the log, in cells, or in seconds if it is a step of a
    contact. Each passage is counted at its place; the excess is that of the maxima and of the end
    of the piece.
    """
    w, level, x = piece.table, limit_log[LIMIT], 0.0
    bend, jerk = tightened(w, bend, jerk)
    for _ in range(LONGEST_WALK):
        if limit_log[BEYOND] == 0.0:
            x = first_touch(w, x, end, 1.0, level, bend, jerk)
            if not 0.0 <= x <= end:
                return
            if is_a(piece, StepPiece):
                time = begin + column_at(w, int(TAU), x)
            else:
                time = (begin + x) * piece.h
            note_violation(limit_log, limit_log[ORIGIN] + time)
        fall = first_touch(w, x, end, -1.0, -level, bend, jerk)
        stays = not 0.0 <= fall <= end
        best = level + limit_log[EXCESS]
        top = nearest_miss(w, x, 1.0, end if stays else fall, best, bend, jerk, False)
        if stays:
            top = max(top, derivatives_at(w, end, 1.0)[0])
        if top > best:
            limit_log[EXCESS] = top - level
        if stays:
            return
        x, limit_log[BEYOND] = fall, 0.0


# ---- a contact -----------------------------------------------------------------------------------


@jit
def may_pass(side, limit_log, phase, duration, touch):
    """Return True if r may be beyond the limit in a contact of a `duration` [s] from its touch.

    phase: an instant of it (`drive`); touch: (s, x1, v1), as the wall sees it, whose energy bounds
    the depth.
    """
    ps, wall = side.ps, side.wall
    s, x1, v1 = touch
    if side.sign < 0.0:
        return -wall.gap > limit_log[LIMIT]
    scale = scale_of(ps, side.damper, x1, v1, wall.gap, s)
    scale += most_push(ps, phase) * math.sqrt(moved_mass(ps, side.damper)) * duration
    room = limit_log[LIMIT] - wall.gap
    return room <= 0.0 or 2.0 * contact_energy(wall, room) <= scale * scale
