"""Flight by classical Runge-Kutta steps on a regular grid (method rk4).

A step that would cross a wall is repeated with the length that lands on r = gap; so is a step that
touches and turns back between its ends. `contact` steps the contacts at the same order. So orbits
are of order four, and share no formula with the exact flight, which they check independently.
Records of a step are those of the Taylor polynomial from its first state, found as in the exact
flight, with the error of the step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import (
    CELLS,
    COEF,
    PERIOD,
    Begun,
    expand,
    fill_drive,
    length_of_cell,
    rate_of,
    turned,
)
from ..numerics.compiling import jit
from ..numerics.elementary import cos_sin_of_turn
from ..numerics.roots import guarded, narrowed, secant
from ..scene.codes import SECTION, TOUCH_FAR, TOUCH_NEAR
from ..scene.scene import accelerations, joined
from ..watch.observe import opposite
from ..watch.response import watch_piece


class FixedGrid(NamedTuple):
    """A period in equal Runge-Kutta steps."""

    n: int  # steps in a period
    h: float  # length of a step [s]
    turn: float  # 1 / n: the turn of the forcing's phase over a step
    rate: float  # bound on the rates of the linear motion [1/s]
    cosine: np.ndarray  # (n + 1,) cos of the phase at the start of each step and at the end
    middle: np.ndarray  # (n,) cos of the phase half a step later
    table: np.ndarray  # (CELLS,) a table as of `flight.Grid`, for the records of a step
    begun: Begun = PERIOD


@jit
def fixed_grid_from(ps, damper, n, begun):
    """Return the grid of n steps over the share of a period that is `begun`."""
    h = length_of_cell(ps, n, begun)
    cosine, middle = np.empty(n + 1), np.empty(n)
    for j in range(n):
        cosine[j] = cos_sin_of_turn(turned(begun, j / n))[0]
        middle[j] = cos_sin_of_turn(turned(begun, (j + 0.5) / n))[0]
    cosine[n] = cos_sin_of_turn(turned(begun, 1.0))[0]
    w = np.zeros(CELLS)
    fill_drive(ps, h, w)
    return FixedGrid(n, h, 1.0 / n, rate_of(ps, joined(damper)), cosine, middle, w, begun)


@jit
def phase_in_step(grid, j, x):
    """Return (cos, sin) of the forcing's phase at place x of step j."""
    return cos_sin_of_turn(turned(grid.begun, (j + x) * grid.turn))


@jit
def step_to(ps, damper, grid, j, x, length, y):
    """Return the state `length` steps after the state y at place x of step j."""
    if x == 0.0 and length == 1.0:
        c0, c1, c2 = grid.cosine[j], grid.middle[j], grid.cosine[j + 1]
    else:
        c0 = phase_in_step(grid, j, x)[0]
        c1 = phase_in_step(grid, j, x + 0.5 * length)[0]
        c2 = phase_in_step(grid, j, x + length)[0]
    # c0, c1, c2: the force at the stages
    h = length * grid.h
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
    return step_to(step.ps, step.damper, step.grid, step.j, step.x, at, step.y)


@jit
def length_to_turn(step):
    """Return the length at which s = dr/dt vanishes within a step."""
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
    """Return the length, in steps of the grid, at which a step touches a wall; -1: it does not.

    sign: 1 for the near wall, -1 for the far one. The shortened step ends on the wall to round-off.
    r is assumed to turn back at most once within the step: the states at its ends decide. A step
    that begins on the wall or beyond it, and moves on outward, has the length 0.
    """
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
def note_miss(step, near, far, clearance):
    """Lower the smallest near miss if r turns back within a step."""
    y = step.y
    if opposite(y[3], step.z[3]):
        top = length_to_turn(step)
        r = within(step, top)[2]
        if near is not None and y[3] > 0.0:
            clearance[0] = min(clearance[0], near.gap - r)
        if far is not None and y[3] < 0.0:
            clearance[0] = min(clearance[0], far.gap + r)


@jit
def fly_fixed(flight, watch, begun, stop, y):
    """Fly from `begun` = (step j, place x in it) to the next touch or the start of the step `stop`.

    Returns (event, j, x, x1, v1, r, s) as `exact.fly`.
    """
    ps, damper, near, far = flight.ps, flight.damper, flight.near, flight.far
    clearance = watch.clearance
    grid, (j, x) = flight.grid, begun
    while j < stop:
        length, event = 1.0 - x, SECTION
        z = step_to(ps, damper, grid, j, x, length, y)
        step = FlightStep(ps, damper, grid, j, x, length, y, z)
        # Repeat the step with the length that ends at the first touch in it, if there is one.
        if near is not None:
            at = length_to_touch(step, 1.0, near)
            if at >= 0.0:
                length, event = at, TOUCH_NEAR
        if far is not None:
            at = length_to_touch(step, -1.0, far)
            if at >= 0.0 and (event == SECTION or at < length):
                length, event = at, TOUCH_FAR
        if event != SECTION:
            z = within(step, length)
        step = FlightStep(ps, damper, grid, j, x, length, y, z)
        # Record the step.
        if watch.energy is not None or watch.limit_log is not None or watch.tally is not None:
            c, d = phase_in_step(grid, j, x)
            begin = y[0], y[1], y[2], y[3], c, d
            expand(ps, damper, grid.h, begin, grid.table, int(COEF))
            watch_piece(ps, damper, watch, grid, (c, d), j + x, length)
        # (a step that ends at a wall may have turned back before the other wall)
        if clearance is not None and (event == SECTION or (event == TOUCH_NEAR) == (y[3] < 0.0)):
            note_miss(step, near, far, clearance)
        y = z
        if event != SECTION:
            return event, j, x + length, y[0], y[1], y[2], y[3]
        j, x = j + 1, 0.0
    return SECTION, j, 0.0, y[0], y[1], y[2], y[3]
