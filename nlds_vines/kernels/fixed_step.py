"""Flight by classical Runge-Kutta steps on a regular grid: the method users know.

A step that would cross a wall is repeated with the length that lands on r = gap; so is a step that
touches and turns back between its ends. `contact` steps the contacts at the same order. So all is
of order four and shares no formula with the exact flight: an independent check of it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .codes import SECTION, TOUCH_FAR, TOUCH_NEAR
from .compiling import jit
from .elementary import cos_sin_of_turn
from .flight import PERIOD, Begun, length_of_cell, rate_of, turned
from .observe import (
    BEYOND,
    EXCESS,
    LEVEL,
    ORIGIN,
    PRECISE,
    note_energy,
    note_violation,
    opposite,
    powers_at,
)
from .response_steps import may_rise, raise_all
from .response_sums import OF_A, OF_FORCE, add, from_foot, motion_of, place_of, raise_to
from .roots import guarded, narrowed, secant
from .scene import accelerations, joined


class FixedGrid(NamedTuple):
    """A period in equal Runge-Kutta steps."""

    n: int  # steps in a period
    h: float  # length of a step [s]
    turn: float  # 1 / n: the turn of the forcing's phase over a step
    rate: float  # bound on the rates of the linear motion [1/s]
    cosine: np.ndarray  # (n + 1,) cos of the phase at the start of each step and at the end
    middle: np.ndarray  # (n,) cos of the phase half a step later
    begun: Begun = PERIOD


@jit
def fixed_grid_from(ps, damper, n, begun):
    """Prepare the share of a period that is `begun` in n steps."""
    h = length_of_cell(ps, n, begun)
    cosine, middle = np.empty(n + 1), np.empty(n)
    for j in range(n):
        cosine[j] = cos_sin_of_turn(turned(begun, j / n))[0]
        middle[j] = cos_sin_of_turn(turned(begun, (j + 0.5) / n))[0]
    cosine[n] = cos_sin_of_turn(turned(begun, 1.0))[0]
    return FixedGrid(n, h, 1.0 / n, rate_of(ps, joined(damper)), cosine, middle, begun)


@jit
def phase_in_step(grid, j, x):
    """Return (cos, sin) of the forcing's phase at place x of step j."""
    return cos_sin_of_turn(turned(grid.begun, (j + x) * grid.turn))


@jit
def cosine_at(grid, j, x):
    """Return cos of that phase."""
    return phase_in_step(grid, j, x)[0]


@jit
def runge_kutta_step(ps, damper, h, c0, c1, c2, y):
    """Return the state after a step h from y = (x1, v1, r, s); c0, c1, c2: cos at its stages."""
    x1, v1, r, s = y
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
def step_to(ps, damper, grid, j, x, length, y):
    """Return the state `length` cells after the state y at place x of step j."""
    if x == 0.0 and length == 1.0:
        c0, c1, c2 = grid.cosine[j], grid.middle[j], grid.cosine[j + 1]
    else:
        c0 = cosine_at(grid, j, x)
        c1 = cosine_at(grid, j, x + 0.5 * length)
        c2 = cosine_at(grid, j, x + length)
    return runge_kutta_step(ps, damper, length * grid.h, c0, c1, c2, y)


class FlightStep(NamedTuple):
    """One step of a flight."""

    ps: Any  # `scene.Structure`
    damper: Any  # `scene.Damper`, `scene.Ground` or None
    grid: Any  # `FixedGrid`
    j: int  # number of the step in its period
    x: float  # place in it where this one begins
    length: float  # in steps
    y: tuple[float, float, float, float]  # (x1, v1, r, s) before and after it
    z: tuple[float, float, float, float]


@jit
def within(step, at):
    """Return the state at a length within a step."""
    return step_to(step.ps, step.damper, step.grid, step.j, step.x, at, step.y)


@jit
def length_to_turn(step):
    """Return the length at which s = dr/dt vanishes within a step: a turn of r."""
    low, high, f0, f1 = 0.0, step.length, step.y[3], step.z[3]
    at = 0.5 * step.length
    for _ in range(60):
        at = secant(low, high, f0, f1)
        f = within(step, at)[3]
        if f == 0.0 or high - low < 1.0e-9 or min(at - low, high - at) < 1.0e-12:
            return at
        low, high, f0, f1 = narrowed(low, high, f0, f1, at, f)
    return at


@jit
def length_to_level(step, low, high, sign, level):
    """Return the length in (low, high] of the step that lands on sign r = level."""
    size = high
    for _ in range(80):
        z = within(step, size)
        excess = sign * z[2] - level
        if abs(excess) <= 2.0e-16 * (abs(level) + abs(step.y[2])) or high - low < 1.0e-15:
            return size
        if excess > 0.0:
            high = size
        else:
            low = size
        speed = sign * z[3] * step.grid.h
        guess = size - excess / speed if speed > 0.0 else high
        size = guarded(guess, low, high)
    return size


@jit
def length_to_touch(step, sign, wall):
    """Return the length at which a step first touches a wall, or -1."""
    y, z = step.y, step.z
    inside, beyond = sign * y[2] >= wall.gap, sign * z[2] > wall.gap
    if inside and sign * y[3] > 0.0:
        return 0.0
    low, top = 0.0, step.length
    if inside:
        if not (beyond and sign * z[3] > 0.0):
            return -1.0
        low = length_to_turn(step)
    elif not beyond:
        if not (sign * y[3] > 0.0 and sign * z[3] < 0.0):
            return -1.0
        top = length_to_turn(step)
        if sign * within(step, top)[2] <= wall.gap:
            return -1.0
    return length_to_level(step, low, top, sign, wall.gap)


@jit
def note_turns(step, energy):
    """Raise the largest energies to their maxima over a step (as `observe.note_step`)."""
    ps, damper, grid, j, x = step.ps, step.damper, step.grid, step.j, step.x
    y, z, length = step.y, step.z, step.length
    c0, c1 = cosine_at(grid, j, x), cosine_at(grid, j, x + length)
    before = powers_at(ps, damper, y[0], y[1], y[2], y[3], c0, 0.0)
    after = powers_at(ps, damper, z[0], z[1], z[2], z[3], c1, 0.0)
    note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])  # energies jump at rigid walls
    note_energy(ps, damper, energy, z[0], z[1], z[2], z[3])
    for which in range(4):
        if opposite(before[which], after[which]):
            low, high, f0, f1 = 0.0, length, before[which], after[which]
            for _ in range(40):
                at = secant(low, high, f0, f1)
                w = within(step, at)
                c = cosine_at(grid, j, x + at)
                f = powers_at(ps, damper, w[0], w[1], w[2], w[3], c, 0.0)[which]
                note_energy(ps, damper, energy, w[0], w[1], w[2], w[3])
                if f == 0.0 or min(at - low, high - at) < 1.0e-9:
                    break
                low, high, f0, f1 = narrowed(low, high, f0, f1, at, f)


@jit
def note_miss(step, near, far, clearance):
    """Lower the smallest near miss if the spring's shortening turns back within a step."""
    y = step.y
    if opposite(y[3], step.z[3]):
        top = length_to_turn(step)
        r = within(step, top)[2]
        if near is not None and y[3] > 0.0:
            clearance[0] = min(clearance[0], near.gap - r)
        if far is not None and y[3] < 0.0:
            clearance[0] = min(clearance[0], far.gap + r)


@jit
def note_limit_fixed(step, limit_log):
    """Note how the limit of r is kept over a step (see `touch.note_limit`)."""
    y, z = step.y, step.z
    level, top, highest = limit_log[LEVEL], step.length, max(y[2], z[2])
    if y[3] > 0.0 > z[3]:
        top = length_to_turn(step)
        highest = within(step, top)[2]
    if limit_log[BEYOND] == 0.0 and highest > level:
        at = length_to_level(step, 0.0, top, 1.0, level)
        note_violation(limit_log, limit_log[ORIGIN] + (step.j + step.x + at) * step.grid.h)
    if limit_log[BEYOND] != 0.0:
        limit_log[EXCESS] = max(limit_log[EXCESS], highest - level)
        limit_log[BEYOND] = 1.0 if z[2] > level else 0.0


@jit
def tally_at(step, tally, at, dt, y):
    """Add `dt` [s] in the state y at a length within a step; return its `motion_of`."""
    ps, damper = step.ps, step.damper
    phase = phase_in_step(step.grid, step.j, step.x + at)
    values, rates = motion_of(tally, ps, damper, y, phase, 0.0, 0.0)
    gone = from_foot(tally.foot, y[0], y[1], phase[0], phase[1])
    add(tally, dt, y, values[OF_A], phase[0], gone)
    return values, rates


@jit
def tally_fixed(step, tally):
    """Add a step to a response: integrals by Simpson's rule, which is of order four, too."""
    y, z, length = step.y, step.z, step.length
    dt = length * step.grid.h / 6.0
    before, rates = tally_at(step, tally, 0.0, dt, y)
    tally_at(step, tally, 0.5 * length, 4.0 * dt, within(step, 0.5 * length))
    after, slopes = tally_at(step, tally, length, dt, z)
    raise_all(tally, 1.0, before)
    raise_all(tally, 1.0, after)
    for which in range(OF_FORCE):
        f0, f1 = rates[which], slopes[which]
        top = tally.row[place_of(which, 1.0)]
        if may_rise(top, before[which], after[which], f0, f1, length * step.grid.h):
            low, high = 0.0, length
            for _ in range(40):
                at = secant(low, high, f0, f1)
                values, turns = tally_at(step, tally, at, 0.0, within(step, at))
                raise_to(tally.row, place_of(which, 1.0), values[which])
                if turns[which] == 0.0 or min(at - low, high - at) < PRECISE:
                    break
                low, high, f0, f1 = narrowed(low, high, f0, f1, at, turns[which])


@jit
def may_touch(sign, wall, y, z):
    """Tell whether a step from y to z may touch a wall: a side beyond it, or a turn."""
    beyond = sign * y[2] >= wall.gap or sign * z[2] > wall.gap
    return beyond or (sign * y[3] > 0.0 and sign * z[3] < 0.0)


@jit
def fly_fixed(flight, watch, begun, stop, y):
    """Fly from `begun` = (step j, place x in it) to the next touch or `stop`, as `exact.fly`."""
    ps, damper, near, far = flight.ps, flight.damper, flight.near, flight.far
    limit_log, energy, clearance = watch.limit_log, watch.energy, watch.clearance
    tally = watch.tally
    grid, (j, x) = flight.grid, begun
    while j < stop:
        length, event = 1.0 - x, SECTION
        z = step_to(ps, damper, grid, j, x, length, y)
        step = FlightStep(ps, damper, grid, j, x, length, y, z)
        # The step is repeated with the length that ends at the first touch in it, if there is one.
        if near is not None and may_touch(1.0, near, y, z):
            at = length_to_touch(step, 1.0, near)
            if at >= 0.0:
                length, event = at, TOUCH_NEAR
        if far is not None and may_touch(-1.0, far, y, z):
            at = length_to_touch(step, -1.0, far)
            if at >= 0.0 and (event == SECTION or at < length):
                length, event = at, TOUCH_FAR
        if event != SECTION:
            z = within(step, length)
        step = FlightStep(ps, damper, grid, j, x, length, y, z)
        # Note what it has shown.
        if energy is not None:
            note_turns(step, energy)
        if limit_log is not None:
            note_limit_fixed(step, limit_log)
        # (a step that ends at a wall may have turned back before the other)
        if clearance is not None and (event == SECTION or (event == TOUCH_NEAR) == (y[3] < 0.0)):
            note_miss(step, near, far, clearance)
        if tally is not None:
            tally_fixed(step, tally)
        y = z
        if event != SECTION:
            return event, j, x + length, y[0], y[1], y[2], y[3]
        j, x = j + 1, 0.0
    return SECTION, j, 0.0, y[0], y[1], y[2], y[3]
