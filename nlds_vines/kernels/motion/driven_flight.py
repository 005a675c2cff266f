"""Variations that parameters drive, along a flight or a motion on a wall that is linear, too.

Motion and variation are Taylor polynomials over cells, as those of `flight`: of their coefficients
each pair follows from the one before.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import cos_sin_of_turn
from ..scene.by_law import by_wall
from ..scene.scene import accelerations, unloaded
from .driven import Driven, source_of
from .flight import ORDER, propagate, turned


class Linear(NamedTuple):
    """A motion that is linear: a flight, or one on a wall with a linear law or a rigid one."""

    wall: Any  # None in flight
    ps: Any  # `scene.Structure`, this and the next as the wall sees them
    damper: Any
    sign: float  # of the wall, 1 in flight
    grid: Any  # whose cells are short enough for Taylor polynomials


@by_wall
def push_of(wall, constant, r, s, c, d):
    """Return the force of what is linear on a wall, r and s as it sees them; and of a variation."""
    return (0.0, 0.0)


@by_wall
def push_changed(wall, by, sign, constant, r, s):
    """Return what changes of that force by the parameter itself."""
    return 0.0


@jit
def under_once(load, constant, alone):
    """Return an acceleration with that of a constant load, as far as it is constant."""
    if load is None:
        return alone
    return alone + constant * load


@by_wall
def terms_on(linear, by, constant, state, drive, variation):
    """Return (dv1/dt, ds/dt) of a motion, and of a variation driven along it, by terms of both.

    The motion is a flight, or on a wall that pushes by `push_of`. constant: 1, or 0 for Taylor
    coefficients but the first.
    """
    wall, ps, damper, sign = linear.wall, linear.ps, linear.damper, linear.sign
    free = unloaded(ps)
    x1, v1, r, s = state
    a, b, c, d = variation
    push, push_varied = push_of(wall, constant, r, s, c, d)
    dv, ds = accelerations(free, damper, x1, v1, r, s, drive, push)
    dv = under_once(ps.load, constant, dv)
    if damper is not None:
        ds = under_once(ps.load, constant, ds)
    db, dd = accelerations(free, damper, a, b, c, d, 0.0, push_varied)
    pushed = push_changed(wall, by, sign, constant, r, s)
    motion = state, (dv, ds)
    adds = source_of(ps, damper, by, sign, constant, motion, drive, (push, pushed))
    return dv, ds, adds[0] + b, adds[1] + db, adds[2] + d, adds[3] + dd


@jit
def drive_cell(linear, by, h, phase, state, variation):
    """Return a motion and a variation driven along it, a time h later, by Taylor polynomials.

    phase: (cos, sin) of the forcing's at the beginning; h as for the cells of `flight`.
    """
    omega = linear.ps.omega
    x1, v1, r, s = state
    a, b, c, d = variation
    cosine, sine = phase
    y0, y1, y2, y3, w0, w1, w2, w3 = x1, v1, r, s, a, b, c, d
    for k in range(ORDER):
        constant = 1.0 if k == 0 else 0.0
        dv, ds, da, db, dc, dd = terms_on(
            linear, by, constant, (x1, v1, r, s), cosine, (a, b, c, d)
        )
        g = h / (k + 1.0)
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        a, b, c, d = da * g, db * g, dc * g, dd * g
        cosine, sine = -omega * sine * g, omega * cosine * g
        y0, y1, y2, y3 = y0 + x1, y1 + v1, y2 + r, y3 + s
        w0, w1, w2, w3 = w0 + a, w1 + b, w2 + c, w3 + d
    return (y0, y1, y2, y3), (w0, w1, w2, w3)


@jit
def drive_along(driven, linear, place, state, time):
    """Carry driven variations along a flight, or a motion on a wall, of `time` [s].

    state (x1, v1, r, s) at its beginning, as the wall sees it; place: share of the period of the
    `grid` that is over then.
    """
    grid, sign = linear.grid, linear.sign
    if not time > 0.0:
        return
    n, begin = math.ceil(time / grid.h), turned(grid.begun, place)
    h, turn = time / n, time / n * (linear.ps.omega / (2.0 * math.pi))
    for i in range(len(driven.rates)):
        by, k, rows, y = driven.rates[i], 4 * i, driven.rows, state
        w = rows[k], rows[k + 1], rows[k + 2], rows[k + 3]
        for cell in range(n):
            cosine, sine = cos_sin_of_turn(begin + cell * turn)
            y, w = drive_cell(linear, by, h, (sign * cosine, sign * sine), y, w)
        rows[k], rows[k + 1], rows[k + 2], rows[k + 3] = w


@jit
def carry(tangent, linear, place, state, time):
    """Carry variations along a `Linear` motion of `time` [s], driven ones as `drive_along`."""
    if is_a(tangent, Driven):
        drive_along(tangent, linear, place, state, time)
    else:
        propagate(linear.grid, tangent, time)
