"""Flight by classical Runge-Kutta steps on a regular grid: the method users know.

A step that would cross a wall is cut at the touch, by repeating it with the length that lands on
r = gap; so is a step that touches and turns back between its ends. The contacts are stepped by
`contact` at the same order. Everything is of order four, contacts included, and shares no formula
with the exact flight: the cross-check of everything.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiling import jit
from .exact import SECTION, TOUCH_FAR, TOUCH_NEAR
from .flight import rate_of
from .observe import BEYOND, EXCESS, LEVEL, PERIOD, note_energy, note_violation, opposite, powers_at
from .scene import accelerations


class FixedGrid(NamedTuple):
    """A period in equal Runge-Kutta steps."""

    n: int  # steps in a period
    h: float  # length of a step [s]
    rate: float  # bound on the rates of the linear motion [1/s]
    cosine: (
        np.ndarray
    )  # (n + 1,) cos of the phase at the start of each step, and of the next period
    sine: np.ndarray  # (n + 1,)
    middle: np.ndarray  # (n,) cos of the phase half a step later


@jit
def fixed_grid_of(ps, damper, n):
    """Prepare one period in n steps."""
    cosine, sine, middle = np.empty(n + 1), np.empty(n + 1), np.empty(n)
    for j in range(n):
        phase = 2.0 * math.pi * j / n
        cosine[j], sine[j] = math.cos(phase), math.sin(phase)
        middle[j] = math.cos(2.0 * math.pi * (j + 0.5) / n)
    cosine[n], sine[n] = 1.0, 0.0
    return FixedGrid(n, 2.0 * math.pi / ps.omega / n, rate_of(ps, damper), cosine, sine, middle)


@jit
def classical_step(ps, damper, h, c0, c1, c2, x1, v1, r, s):
    """Return the state after one Runge-Kutta step h; c0, c1, c2: cos of phase at its stages."""
    g = 0.5 * h
    a1, b1 = accelerations(ps, damper, x1, v1, r, s, c0, 0.0)
    v2, s2 = v1 + g * a1, s + g * b1
    a2, b2 = accelerations(ps, damper, x1 + g * v1, v2, r + g * s, s2, c1, 0.0)
    v3, s3 = v1 + g * a2, s + g * b2
    a3, b3 = accelerations(ps, damper, x1 + g * v2, v3, r + g * s2, s3, c1, 0.0)
    v4, s4 = v1 + h * a3, s + h * b3
    a4, b4 = accelerations(ps, damper, x1 + h * v3, v4, r + h * s3, s4, c2, 0.0)
    w = h / 6.0
    return (
        x1 + w * (v1 + 2.0 * (v2 + v3) + v4),
        v1 + w * (a1 + 2.0 * (a2 + a3) + a4),
        r + w * (s + 2.0 * (s2 + s3) + s4),
        s + w * (b1 + 2.0 * (b2 + b3) + b4),
    )


@jit
def step_to(ps, damper, grid, j, x, length, x1, v1, r, s):
    """Return the state `length` cells after place x of step j."""
    if x == 0.0 and length == 1.0:
        c0, c1, c2 = grid.cosine[j], grid.middle[j], grid.cosine[j + 1]
    else:
        turn = ps.omega * grid.h
        c0 = math.cos(turn * (j + x))
        c1 = math.cos(turn * (j + x + 0.5 * length))
        c2 = math.cos(turn * (j + x + length))
    return classical_step(ps, damper, length * grid.h, c0, c1, c2, x1, v1, r, s)


@jit
def turn_in(ps, damper, grid, j, x, length, x1, v1, r, s, y):
    """Return the length at which s = dr/dt vanishes within a step to y (a near turn of r)."""
    low, high, f0, f1 = 0.0, length, s, y[3]
    at = 0.5 * length
    for _ in range(60):
        at = low + (high - low) * f0 / (f0 - f1)
        f = step_to(ps, damper, grid, j, x, at, x1, v1, r, s)[3]
        if f == 0.0 or high - low < 1.0e-9 or min(at - low, high - at) < 1.0e-12:
            return at
        if (f > 0.0) == (f1 > 0.0):
            high, f1, f0 = at, f, 0.5 * f0
        else:
            low, f0, f1 = at, f, 0.5 * f1
    return at


@jit
def cut(ps, damper, grid, j, x, low, high, sign, gap, x1, v1, r, s):
    """Return the length of the step that lands on sign r = gap, which lies in (low, high]."""
    size = high
    for _ in range(80):
        y = step_to(ps, damper, grid, j, x, size, x1, v1, r, s)
        excess = sign * y[2] - gap
        if abs(excess) <= 2.0e-16 * (abs(gap) + abs(r)) or high - low < 1.0e-15:
            return size
        if excess > 0.0:
            high = size
        else:
            low = size
        speed = sign * y[3] * grid.h
        guess = size - excess / speed if speed > 0.0 else high
        size = guess if low < guess < high else 0.5 * (low + high)
    return size


@jit
def crossing(ps, damper, grid, j, x, length, sign, wall, x1, v1, r, s, y):
    """Return the length at which a step first touches a wall, or -1."""
    inside, beyond = sign * r >= wall.gap, sign * y[2] > wall.gap
    if inside and sign * s > 0.0:
        return 0.0
    low, top = 0.0, length
    if inside:
        if not (beyond and sign * y[3] > 0.0):
            return -1.0
        low = turn_in(ps, damper, grid, j, x, length, x1, v1, r, s, y)
    elif not beyond:
        if not (sign * s > 0.0 and sign * y[3] < 0.0):
            return -1.0
        top = turn_in(ps, damper, grid, j, x, length, x1, v1, r, s, y)
        if sign * step_to(ps, damper, grid, j, x, top, x1, v1, r, s)[2] <= wall.gap:
            return -1.0
    return cut(ps, damper, grid, j, x, low, top, sign, wall.gap, x1, v1, r, s)


@jit
def note_turns(ps, damper, energy, grid, j, x, length, x1, v1, r, s, y):
    """Raise the largest energies to their maxima over a step (see `observe.note_step`)."""
    turn = ps.omega * grid.h
    c0, c1 = math.cos(turn * (j + x)), math.cos(turn * (j + x + length))
    before = powers_at(ps, damper, x1, v1, r, s, c0, 0.0)
    after = powers_at(ps, damper, y[0], y[1], y[2], y[3], c1, 0.0)
    note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])
    for which in range(4):
        if opposite(before[which], after[which]):
            low, high, f0, f1 = 0.0, length, before[which], after[which]
            for _ in range(40):
                at = low + (high - low) * f0 / (f0 - f1)
                z = step_to(ps, damper, grid, j, x, at, x1, v1, r, s)
                c = math.cos(turn * (j + x + at))
                f = powers_at(ps, damper, z[0], z[1], z[2], z[3], c, 0.0)[which]
                note_energy(ps, damper, energy, z[0], z[1], z[2], z[3])
                if f == 0.0 or min(at - low, high - at) < 1.0e-9:
                    break
                if (f > 0.0) == (f1 > 0.0):
                    high, f1, f0 = at, f, 0.5 * f0
                else:
                    low, f0, f1 = at, f, 0.5 * f1


@jit
def note_miss(ps, damper, near, far, clearance, grid, j, x, length, x1, v1, r, s, y):
    """Lower the smallest near miss if the spring's shortening turns back within a step."""
    if opposite(s, y[3]):
        top = turn_in(ps, damper, grid, j, x, length, x1, v1, r, s, y)
        r = step_to(ps, damper, grid, j, x, top, x1, v1, r, s)[2]
        if near is not None and s > 0.0:
            clearance[0] = min(clearance[0], near.gap - r)
        if far is not None and s < 0.0:
            clearance[0] = min(clearance[0], far.gap + r)


@jit
def note_limit_fixed(ps, damper, watch, grid, j, x, length, x1, v1, r, s, y):
    """Note how the limit of r is kept over a step (see `touch.note_limit`)."""
    level, top, highest = watch[LEVEL], length, max(r, y[2])
    if s > 0.0 > y[3]:
        top = turn_in(ps, damper, grid, j, x, length, x1, v1, r, s, y)
        highest = step_to(ps, damper, grid, j, x, top, x1, v1, r, s)[2]
    if watch[BEYOND] == 0.0 and highest > level:
        at = cut(ps, damper, grid, j, x, 0.0, top, 1.0, level, x1, v1, r, s)
        note_violation(watch, watch[PERIOD] + (j + x + at) * grid.h)
    if watch[BEYOND] != 0.0:
        watch[EXCESS] = max(watch[EXCESS], highest - level)
        watch[BEYOND] = 1.0 if y[2] > level else 0.0


@jit
def meets(sign, wall, r, s, y):
    """Tell whether a step from (r, s) to y may touch a wall: a side beyond it, or a turn."""
    return sign * r >= wall.gap or sign * y[2] > wall.gap or (sign * s > 0.0 and sign * y[3] < 0.0)


@jit
def fly_fixed(ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s):
    """Fly from place x of step j to the next touch or to the step `stop`, as `exact.fly`."""
    while j < stop:
        length, event = 1.0 - x, SECTION
        y = step_to(ps, damper, grid, j, x, length, x1, v1, r, s)
        if near is not None and meets(1.0, near, r, s, y):
            at = crossing(ps, damper, grid, j, x, length, 1.0, near, x1, v1, r, s, y)
            if at >= 0.0:
                length, event = at, TOUCH_NEAR
        if far is not None and meets(-1.0, far, r, s, y):
            at = crossing(ps, damper, grid, j, x, length, -1.0, far, x1, v1, r, s, y)
            if at >= 0.0 and (event == SECTION or at < length):
                length, event = at, TOUCH_FAR
        if event != SECTION:
            y = step_to(ps, damper, grid, j, x, length, x1, v1, r, s)
        if energy is not None:
            note_turns(ps, damper, energy, grid, j, x, length, x1, v1, r, s, y)
        if watch is not None:
            note_limit_fixed(ps, damper, watch, grid, j, x, length, x1, v1, r, s, y)
        if clearance is not None and event == SECTION:
            note_miss(ps, damper, near, far, clearance, grid, j, x, length, x1, v1, r, s, y)
        x1, v1, r, s = y
        if event != SECTION:
            return event, j, x + length, x1, v1, r, s
        j, x = j + 1, 0.0
    return SECTION, j, 0.0, x1, v1, r, s
