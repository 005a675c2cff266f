"""Variations along a contact that is stepped: they change nothing of the orbit that they go with.

Their polynomials (`taylor`) have the radius of convergence of the orbit's, but not its last terms:
near the touch a force K z^n does little to an orbit, and its stiffness n K z^(n - 1) much to
variations. So they take the orbit's step in parts, where their own last terms ask for that, from
states that its polynomial has in between; the orbit goes on from where it was.
"""

from __future__ import annotations

import math

from ..motion.driven import constants_of, count_of, drive_start, rows_of
from ..motion.taylor import advance, expand_contact, order_of, restore, set_aside
from ..numerics.compiling import jit
from ..numerics.elementary import exp, log, whole_power
from ..scene.arguments import Step
from ..scene.contact_series import (
    COLUMNS,
    NEW,
    OLD,
    ROW,
    SERIES,
    SHRUNK,
    UNIT,
    VARIED,
    VOLUME,
    WIDTH,
)
from ..scene.drive import after
from ..scene.law import rate_of_q, smooth_up_to

MOST_PARTS = 100  # of a step; a few are needed where a force begins with a fractional power
MORE = 10.0  # what the last terms may be, in units of what an orbit is granted


@jit
def vary_on(side, tangent, start, c, t):
    """Move the variations of row Y on by a short time t [s].

    start: the state (x1, v1, r, s) at its beginning.
    """
    for i in range(WIDTH + OLD, WIDTH + OLD + count_of(tangent), 4):
        side.k[i] += t * side.k[i + 1]
        side.k[i + 2] += t * side.k[i + 3]
    drive_start(side, tangent, start, c, t, int(WIDTH + OLD))


@jit
def begin_along(tangent, k):
    """Write variations into row Y, where they go along."""
    if tangent is not None:
        for i in range(count_of(tangent)):
            k[OLD + WIDTH + i] = rows_of(tangent)[i]


@jit
def last_of_variations(k, row, pace):
    """Return the largest share that terms of a row of series are of a variation's own size."""
    most, first = 0.0, SERIES + VARIED
    for j in range(4):
        size = abs(k[first + 4 + j]) + abs(k[first + 12 + j])
        size += pace * (abs(k[first + j]) + abs(k[first + 8 + j]))
        last = max(abs(k[row + VARIED + 4 + j]), abs(k[row + VARIED + 12 + j]))
        if last > most * size and size > 0.0:
            most = last / size
    return most


@jit
def part_for(side, tangent, h, granted, pace):
    """Return how far variations may go along a polynomial, at most h; granted: of an orbit."""
    k, n, less, x = side.k, order_of(side.rk4), 0.0, h / side.k[UNIT]
    for m in range(n - 1, n + 1):
        last = last_of_variations(k, SERIES + COLUMNS * m, pace) * whole_power(x, m)
        if last > MORE * granted:
            less = min(less, log(MORE * granted / last) / m)
    return exp(less) * h


@jit
def ride(side, tangent, step, granted, scales):
    """Carry variations over the step from row Y to row NEW, of which the series stand in k.

    granted: of its last terms to an orbit, infinite where its steps are as they are; scales of
    speed, depth and q. Row Y and the series are lost.
    """
    k, wall, (fast, deep, root) = side.k, side.wall, scales
    left, phase = step.h, step.phase
    set_aside(k)
    for part in range(MOST_PARTS):
        h = left
        if granted < math.inf and part < MOST_PARTS - 1:
            h = part_for(side, tangent, h, granted, fast / deep)
            if k[OLD] == 0.0 and k[OLD + 1] > 0.0:
                far = smooth_up_to(wall, tangent, constants_of(side.sign), granted)
                h = min(h, root * far / rate_of_q(wall, k[OLD + 1]))
        last = not h < left
        advance(side, tangent, Step(phase, step.landing and last, h))
        k[SHRUNK] += k[NEW + VOLUME]
        for i in range(count_of(tangent)):
            rows_of(tangent)[i] = k[NEW + WIDTH + i]
        if last:
            break
        phase = after(side.ps, phase, k[NEW + 4])
        for i in range(ROW):
            k[OLD + i] = k[NEW + i]
        left -= h
        expand_contact(side, tangent, phase, left)
    restore(k)
    for i in range(count_of(tangent)):
        k[NEW + WIDTH + i] = rows_of(tangent)[i]
