"""Variations that parameters drive: the derivatives of an orbit by the numbers of its cell.

A variation w obeys w' = A w. The derivative of the state at a given phase by a parameter p obeys

    w' = A w + df/dp,    f = (v1, dv1/dt, s, ds/dt) of eq. (5)

The rates by phase are f / omega, so that df/domega = -f / omega. A change gap' of the gap acts as a
change -gap' of r: a variation touches later by (gap' - r) / s. Where f jumps at the touch (with a
dashpot), or the state does (at a rigid wall), the jump of the variation contains this delay.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import cos_sin_of_turn
from ..numerics.fours import four_of, number_of
from ..scene.by_law import by_wall
from ..scene.law import (
    AT_S,
    AT_V,
    AT_X,
    COLUMNS,
    COSINE,
    DEPTH,
    DS,
    DV,
    SERIES,
    STIFF,
    fill_constants,
    pushed_term,
)
from ..scene.law import FORCE as CONTACT
from ..scene.law import RATES as VARIED_RATES
from ..scene.scene import Ground, accelerations, near_constants, shared, unloaded
from .flight import ORDER, propagate, turned

# Columns of the rates of a parameter, its derivatives of the numbers of a cell:
#   SLOWER         -1/omega for the frequency        INV_M1, INV_MU, SHARE     of `scene.Damper`
#   STIFFNESS ... LOAD, K2, C2   as their names say   NEAR, FAR  from there on those of a wall:
#   its GAP, then the constants of its law
SLOWER, STIFFNESS, DAMPING, FORCING, LOAD, K2, C2, INV_M1, INV_MU, SHARE = range(10)
GAP, MOST_CONSTANTS = 0, 6  # MOST_CONSTANTS: of a law
NEAR, FAR, RATE_COLUMNS = 10, 11 + MOST_CONSTANTS, 12 + 2 * MOST_CONSTANTS


class Driven(NamedTuple):
    """Room for four variations; parameter i drives variation i, further ones have no meaning."""

    rows: Any  # (16,) one variation after the other
    rates: Any  # (parameters, RATE_COLUMNS)


@jit
def rows_of(tangent):
    if is_a(tangent, Driven):
        return tangent.rows
    return tangent


@jit
def count_of(tangent):
    """Return the number of values of the variations that are carried along."""
    if is_a(tangent, Driven):
        return 4 * len(tangent.rates)
    return 16


# ---- the rates of a parameter --------------------------------------------------------------------


@jit
def fill_rates(parts, ps, damper, change, rates):
    """Fill the rates (RATE_COLUMNS,) of a parameter; change: derivatives of the cell's numbers."""
    rates[SLOWER] = -change.omega / ps.omega
    rates[STIFFNESS] = (change.k1 - ps.stiffness * change.m1) / ps.m1
    rates[DAMPING] = (change.c1 - ps.damping * change.m1) / ps.m1
    rates[FORCING] = (change.P - ps.force * change.m1) / ps.m1
    rates[LOAD] = 0.0 if parts.load is None else change.load
    if damper is not None:
        rates[INV_M1] = rates[INV_MU] = -change.m1 / (ps.m1 * ps.m1)
        if not is_a(damper, Ground):
            rates[K2], rates[C2] = change.k2, change.c2
            rates[INV_MU] -= change.m2 / (damper.m2 * damper.m2)
            rates[SHARE] = (rates[INV_M1] - damper.share * rates[INV_MU]) / damper.inv_mu
    fill_wall(parts.near, near_constants(parts.apart, change), change.near, rates, int(NEAR))
    fill_wall(parts.far, change, change.far, rates, int(FAR))


@jit
def fill_wall(sort, change, gap, rates, at):
    """Fill the rates of a wall of a sort, from column `at` on; gap: derivative of its gap."""
    if sort is None:
        return None
    rates[at + GAP] = gap
    fill_constants(sort, change, rates, at + 1)


@jit
def wall_at(sign):
    return NEAR if sign > 0.0 else FAR


@jit
def constants_of(sign):
    return wall_at(sign) + 1


# ---- the source of a variation, df/dp ------------------------------------------------------------


@jit
def source_of(ps, damper, by, constant, motion, drive, pushes):
    """Return df/dp of eq. (5) in the components (x1, v1, r, s).

    by: the rates (RATE_COLUMNS,) of p; motion: the state (x1, v1, r, s) and its (dv1/dt, ds/dt);
    pushes: the force [N] of a wall on r, and its derivative by p itself; constant: 1, but 0 for all
    Taylor coefficients of a motion except the first.
    """
    ((x1, v1, r, s), (dv, ds)), (push, pushed), pace = motion, pushes, by[SLOWER]
    alone = by[FORCING] * drive - by[STIFFNESS] * x1 - by[DAMPING] * v1 + constant * by[LOAD]
    if damper is None:
        return pace * v1, alone + pace * dv, pace * s, pace * ds
    pull = damper.k2 * r + damper.c2 * s + push
    pulled = by[K2] * r + by[C2] * s + pushed
    b = alone - (pulled * damper.inv_m1 + pull * by[INV_M1])
    d = alone - shared(ps, by[FORCING] * drive) - (pulled * damper.inv_mu + pull * by[INV_MU])
    return pace * v1, b + pace * dv, pace * s, d + pace * ds


@jit
def drive_terms(side, tangent, n):
    """Add df/dp to coefficient n of the rates of variations in a stepped contact."""
    ps, damper, wall, k, row = side.ps, side.damper, side.wall, side.k, SERIES + COLUMNS * n
    sign, at, constant = side.sign, wall_at(side.sign), 1.0 if n == 0 else 0.0
    r, s = sign * (constant * wall.gap + k[row + DEPTH]), sign * k[row + AT_S]
    motion = (k[row + AT_X], k[row + AT_V], r, s), (k[row + DV], sign * k[row + DS])
    for i in range(len(tangent.rates)):
        by, place = tangent.rates[i], row + VARIED_RATES + i
        pushed = pushed_term(wall, k, by, at + 1, n) - k[row + STIFF] * by[at + GAP]
        pushes = sign * k[row + CONTACT], sign * pushed
        a, b, c, d = source_of(ps, damper, by, constant, motion, k[row + COSINE], pushes)
        k[place] += a
        k[place + 4] += b
        k[place + 8] += c
        k[place + 12] += d


# ---- at a wall -----------------------------------------------------------------------------------


@jit
def columns_of(tangent):
    """Return x1, v1, r and s of four variations, each as a four."""
    return (
        four_of(tangent[0], tangent[4], tangent[8], tangent[12]),
        four_of(tangent[1], tangent[5], tangent[9], tangent[13]),
        four_of(tangent[2], tangent[6], tangent[10], tangent[14]),
        four_of(tangent[3], tangent[7], tangent[11], tangent[15]),
    )


@jit
def put_columns(tangent, columns):
    """Write x1, v1, r and s, each as a four, into four variations."""
    x1, v1, r, s = columns
    for k in range(4):
        tangent[4 * k], tangent[4 * k + 1] = number_of(x1, k), number_of(v1, k)
        tangent[4 * k + 2], tangent[4 * k + 3] = number_of(r, k), number_of(s, k)


@jit
def carried(columns, field, late):
    """Return variations (x1, v1, r, s), each a four, `late` [s] further along the orbit.

    field: the rates of the orbit's x1, v1, r and s; late: a four, one time for each variation.
    At a wall, which a variation meets later by t0 = -r / s, the motion before carries it by t0 to
    the wall, its jump acts, and the motion after carries it back by t0.
    """
    x1, v1, r, s = columns
    a, b, c, d = field
    return x1 + a * late, v1 + b * late, r + c * late, s + d * late


@jit
def seen_from_wall(tangent, sign, direction):
    """Count r of driven variations from the wall, `direction` 1, or again from its origin, -1."""
    if is_a(tangent, Driven):
        for i in range(len(tangent.rates)):
            tangent.rows[4 * i + 2] -= direction * sign * tangent.rates[i, wall_at(sign) + GAP]


# --------------------------------------------------------------------------------------------------
# Driven variations along a flight, or along a linear motion on a wall.
#
# Motion and variation are Taylor polynomials over cells, as in `flight`; each pair of coefficients
# follows from the one before.


class Linear(NamedTuple):
    """A linear motion: a flight, or a contact with a linear or a rigid wall."""

    wall: Any  # None in flight
    ps: Any  # `scene.Structure`
    damper: Any
    sign: float  # of the wall, 1 in flight
    grid: Any  # with cells short enough for Taylor polynomials


@by_wall
def push_of(wall, outward, r, s, c, d):
    """Return the linear force of a wall on a motion (r, s) and on a variation of it.

    outward: the `sign` of the wall, but 0 for all Taylor coefficients except the first.
    """
    return (0.0, 0.0)


@by_wall
def push_changed(wall, by, sign, constant, r, s):
    """Return the derivative of that force by the parameter at a fixed motion."""
    return 0.0


@jit
def under_once(load, constant, alone):
    """Return an acceleration with that of a constant load; constant: 1 or 0, as below."""
    if load is None:
        return alone
    return alone + constant * load


@by_wall
def terms_on(linear, by, constant, state, drive, variation):
    """Return (dv1/dt, ds/dt) of a motion and the rates of a variation driven along it.

    The motion is a flight, or one on a wall that pushes by `push_of`. constant: 1, but 0 for all
    Taylor coefficients except the first.
    """
    wall, ps, damper, sign = linear.wall, linear.ps, linear.damper, linear.sign
    free = unloaded(ps)
    x1, v1, r, s = state
    a, b, c, d = variation
    push, push_varied = push_of(wall, constant * sign, r, s, c, d)
    dv, ds = accelerations(free, damper, x1, v1, r, s, drive, push)
    dv = under_once(ps.load, constant, dv)
    if damper is not None:
        ds = under_once(ps.load, constant, ds)
    db, dd = accelerations(free, damper, a, b, c, d, 0.0, push_varied)
    pushed = push_changed(wall, by, sign, constant, r, s)
    motion = state, (dv, ds)
    adds = source_of(ps, damper, by, constant, motion, drive, (push, pushed))
    return dv, ds, adds[0] + b, adds[1] + db, adds[2] + d, adds[3] + dd


@jit
def drive_along(driven, linear, place, state, time):
    """Carry driven variations along a `Linear` motion of `time` [s], by Taylor polynomials.

    state: (x1, v1, r, s) at its beginning; place: its beginning, as a share of the period of the
    grid.
    """
    grid, omega = linear.grid, linear.ps.omega
    if not time > 0.0:
        return
    n, begin = math.ceil(time / grid.h), turned(grid.begun, place)
    h, turn = time / n, time / n * (omega / (2.0 * math.pi))
    for i in range(len(driven.rates)):
        by, at, rows = driven.rates[i], 4 * i, driven.rows
        y0, y1, y2, y3 = state
        w0, w1, w2, w3 = rows[at], rows[at + 1], rows[at + 2], rows[at + 3]
        for cell in range(n):
            cosine, sine = cos_sin_of_turn(begin + cell * turn)
            x1, v1, r, s, a, b, c, d = y0, y1, y2, y3, w0, w1, w2, w3
            for k in range(ORDER):
                constant, g = 1.0 if k == 0 else 0.0, h / (k + 1.0)
                dv, ds, da, db, dc, dd = terms_on(
                    linear, by, constant, (x1, v1, r, s), cosine, (a, b, c, d)
                )
                x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
                a, b, c, d = da * g, db * g, dc * g, dd * g
                cosine, sine = -omega * sine * g, omega * cosine * g
                y0, y1, y2, y3 = y0 + x1, y1 + v1, y2 + r, y3 + s
                w0, w1, w2, w3 = w0 + a, w1 + b, w2 + c, w3 + d
        rows[at], rows[at + 1], rows[at + 2], rows[at + 3] = w0, w1, w2, w3


@jit
def carry(tangent, linear, place, state, time):
    """Carry variations along a `Linear` motion of `time` [s] (arguments as of `drive_along`)."""
    if is_a(tangent, Driven):
        drive_along(tangent, linear, place, state, time)
    else:
        propagate(linear.grid, tangent, time)
