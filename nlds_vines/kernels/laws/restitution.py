"""Contact of rigid bodies: an impact at once, by Newton's law, and sticking.

The approach speed s turns into -e s. The damper takes the impulse mu (1 + e) s and the structure
its opposite, so that momentum is conserved: v1 - share s, the velocity of the common motion, does
not change.

If the other forces press the damper to the wall, rebounds shrink by e each time, and infinitely
many of them end in finite time. Such a series is completed as soon as its speed is less than BRIEF
times a / rate, a being the pressing acceleration; from then on the damper stays, s = 0. The common
motion feels no impact. Only the structure's spring and dashpot notice that the damper has been away
by up to s^2 / 2a, for a time 2 s / (a (1 - e)): the error is less than BRIEF^3 / (1 - e) of the
motion.

While they stick, damper and structure are one mass. Their motion is exact like a flight, on a
second grid, and ends at the instant at which the wall would have to pull. That instant is certified
like a touch, as a is a polynomial in each cell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion.driven import (
    DAMPING,
    FORCING,
    LOAD,
    SHARE,
    SLOWER,
    STIFFNESS,
    Driven,
    Linear,
    carried,
    carry,
    columns_of,
    constants_of,
    put_columns,
    rows_of,
    seen_from_wall,
    under_once,
)
from ..motion.flight import COEF, ORDER, Grid, bare_grid
from ..motion.load_cells import force_term
from ..motion.response_sums import IMPULSE, LOSS, raise_to
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import log
from ..scene import law as contact_series
from ..scene.codes import RELEASED
from ..scene.drive import drive_now, falling, most_push
from ..scene.scene import Structure, accelerations, accelerations_at, shared, under
from ..watch.response import first_rise, local_grid, walk, watch_piece
from ..watch.touch import AT_R

BRIEF = 1.0e-5  # largest speed of a series of rebounds that is completed, in units of a / rate
STEADY_PRESSING = 0.1  # largest relative change of a, and rate times duration, of such a series
PULL = 1.0e-12  # of the wall before it lets go, relative to the forces


AT_ONCE = True
PLACE_ERROR = 4.0e-15  # relative error of the difference of two positions
OF_E = 0  # column of the rates of constants


class RigidWall(NamedTuple):
    """Obstacle of a rigid body: the approach speed s turns into -e s."""

    gap: float  # [m]
    e: float  # coefficient of restitution, 0 to 1


SORTS = {("restitution", False): RigidWall(0.0, 0.0)}


class Stuck(NamedTuple):
    """The motion of structure and damper as one mass (`walk`)."""

    wall: RigidWall
    grid: Grid  # of its flight


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    return RigidWall(gap, cell.e)


@jit
def in_range(sort, cell):
    return 0.0 <= cell.e <= 1.0


@jit
def fill_constants(sort, change, rates, at):
    rates[at + OF_E] = change.e


@jit
def rests(wall, r, s, scale):
    return s == 0.0 and wall.gap - r <= PLACE_ERROR * scale


@jit
def into(wall, r):
    return (0.0, wall.gap)  # a state beyond the wall is put on it


@jit
def contact_energy(wall, z):
    return 0.0


@jit
def depth_of(wall, q):
    return 0.0


@jit
def force_at(wall, depth):
    return math.inf


# ---- preparation of sticking ---------------------------------------------------------------------


@jit
def held_at(wall, ps, damper, begun):
    other = 1.0 - damper.share
    force = ps.force * other if ps.shaken is None else ps.force  # a moving ground shakes both
    load = None if ps.load is None else ps.load * other
    one = Structure(
        ps.m1 + damper.m2, ps.k1, ps.stiffness * other, ps.damping * other, force, ps.omega, load,
        None,
    )  # fmt: skip
    return Stuck(wall, local_grid(one, None, begun))


@jit
def bare_motion(motion):
    return Stuck(motion.wall, bare_grid(motion.grid))


# ---- the impact ----------------------------------------------------------------------------------


@jit
def pressing(side, x1, v1, c):
    """Return d2z/dt2 [m/s^2] of a damper at rest on the wall, without the wall's force."""
    return accelerations_at(side, side.ps, (x1, v1, side.wall.gap, 0.0), c, 0.0)[1]


@jit
def stays(side, state, phase):
    """Return True if rebounds from a speed s < 0 end in rest within a negligible time.

    state: (s, x1, v1), v1 of the structure after them; phase: the instant (`drive`).
    """
    (s, x1, v1), c = state, drive_now(phase)
    ps, damper, wall, rate = side.ps, side.damper, side.wall, side.rate
    a = pressing(side, x1, v1, c)
    if not a > 0.0 or rate * -s > BRIEF * a:
        return False
    if s == 0.0:
        return True
    if wall.e == 1.0:
        return False
    lasting = -2.0 * s / (a * (1.0 - wall.e))
    alone = under(ps.load, ps.force * c - ps.stiffness * x1 - ps.damping * v1)
    both = shared(ps, ps.force * c)
    dv = (1.0 - damper.share) * (alone - both) + both
    falls = falling(ps, phase)
    change = (falls - shared(ps, falls)) + ps.stiffness * v1 + ps.damping * dv
    return abs(change) * lasting <= STEADY_PRESSING * a and rate * lasting <= STEADY_PRESSING


@jit
def vary_at_impact(side, before, after, stuck, c, tangent):
    """Carry four variations `tangent` (16,) through an impact (a saltation matrix).

    before, after: (s, x1, v1), s that of r; stuck: whether the damper stays afterwards; c: the
    force (`drive_now`). A variation meets the wall later by t0 = -r / s. The motion before carries
    it there, and the motion after, with e = 0 a flight, too, if ds/dt leads off, carries it back.
    """
    ps, damper, wall, place = side.ps, side.damper, side.wall, side.sign * side.wall.gap
    s, x1, v1 = before
    dv, ds = accelerations(ps, damper, x1, v1, place, s, c, 0.0)
    x, v, r, u = columns_of(tangent)
    late = (-1.0 / s) * r
    x, v, _, u = carried((x, v, r, u), (v1, dv, s, ds), late)
    (s, x1, v1), r = after, 0.0 * late
    if stuck:
        alone = under(ps.load, ps.force * c - ps.stiffness * x1 - ps.damping * v1)
        both = shared(ps, ps.force * c)
        common = v1, (1.0 - damper.share) * (alone - both) + both, 0.0, 0.0
        v = v - damper.share * u
        put_columns(tangent, carried((x, v, r, 0.0 * u), common, 0.0 - late))
        return
    dv, ds = accelerations(ps, damper, x1, v1, place, s, c, 0.0)
    v, u = v - (damper.share * (1.0 + wall.e)) * u, (-wall.e) * u
    put_columns(tangent, carried((x, v, r, u), (v1, dv, s, ds), 0.0 - late))


@jit
def follow(side, watch, phase, place, left, now):
    """Take an impact at once, and follow sticking to its release or for the time `left` [s].

    Arguments and result as of `contact.follow`.
    """
    ps, damper, wall, sign = side.ps, side.damper, side.wall, side.sign
    tangent, k, share = watch.tangent, side.k, side.sign * side.damper.share
    (_, s, x1, v1), c = now, drive_now(phase)
    if s > 0.0:
        before, u = (s, x1, v1), v1 - share * s
        s = -wall.e * s
        v1 = u + share * s
        stuck = stays(side, (s, x1, u), phase)
        if stuck:
            s, v1 = 0.0, u
        if watch.tally is not None:
            row, mu = watch.tally.row, 1.0 / damper.inv_mu
            raise_to(row, int(IMPULSE) + (0 if sign > 0.0 else 1), mu * (before[0] - s))
            row[LOSS] += 0.5 * mu * (before[0] - s) * (before[0] + s)
        if tangent is not None:
            k[contact_series.SHRUNK] += -math.inf if stuck else 2.0 * log(wall.e)
            seen_from_wall(tangent, sign, 1.0)
            fast = sign * before[0]
            first, last = (fast, x1, before[2]), (sign * s, x1, v1)
            vary_at_impact(side, first, last, stuck, c, rows_of(tangent))
            # The derivatives by e and by the share, whose t0 depends on r alone: a rebound turns s
            # of r into -e s and v1 into v1 - share (1 + e) s, hence ds = -de s and
            # dv1 = -(dshare (1 + e) + share de) s, with e = de = 0 at rest afterwards.
            if is_a(tangent, Driven):
                for i in range(len(tangent.rates)):
                    by = tangent.rates[i]
                    de, both = by[constants_of(sign) + OF_E], 1.0 + wall.e
                    if stuck:
                        de, both = 0.0, 1.0
                    tangent.rows[4 * i + 1] -= fast * (by[SHARE] * both + damper.share * de)
                    tangent.rows[4 * i + 3] -= fast * de
            seen_from_wall(tangent, sign, -1.0)
    if s < 0.0 or not pressing(side, x1, v1, c) >= 0.0:
        return RELEASED, 0.0, s, x1, v1, 0.0, 0.0
    start = x1, v1, sign * wall.gap, 0.0
    event, y, took = walk(side.motion, side, watch, phase, place, left, start)
    if tangent is not None:
        seen_from_wall(tangent, sign, 1.0)
        # Variations are projected onto the motion of a damper that stays: displaced by r, it falls
        # back to the wall while the common motion continues; on its way the structure's dashpot
        # adds c1/m1 (1 - share) share r to v1.
        x, v, r, d = columns_of(rows_of(tangent))
        drag = ps.damping * (1.0 - damper.share) * damper.share
        v = (v - damper.share * d) + drag * r
        put_columns(rows_of(tangent), (x - damper.share * r, v, 0.0 * r, 0.0 * d))
        seen_from_wall(tangent, sign, -1.0)
        carry(tangent, Linear(wall, ps, damper, sign, side.motion.grid), place, start, took)
    return event, 0.0, 0.0, y[0], y[1], took, 0.0


# ---- sticking ------------------------------------------------------------------------------------


@jit
def ending(stuck, side, w, phase, end):
    """Return the event and the place where the wall would have to pull a damper at rest on it."""
    ps, damper = side.ps, side.damper
    # The places of r in COEF take minus the structure's acceleration towards the wall. Where it
    # rises to that of the damper by its spring, the wall would have to pull.
    for i in range(ORDER + 1):
        row, drive = COEF + 4 * i, force_term(w, phase, i)
        inertia = ps.force * drive - ps.stiffness * w[row] - ps.damping * w[row + 1]
        inertia = inertia - shared(ps, ps.force * drive)
        if i == 0:
            inertia = under(ps.load, inertia)
        w[row + 2], w[row + 3] = -side.sign * inertia, 0.0
    size, spring = (
        (most_push(ps, phase) + abs(ps.stiffness * w[COEF]) + abs(ps.damping * w[COEF + 1])),
        damper.k2 * side.wall.gap * damper.inv_mu,
    )
    return RELEASED, first_rise(w, end, PULL * (size + abs(spring)) - spring)


@jit
def note_piece(stuck, side, watch, grid, phase, begin, end):
    for i in range(ORDER + 1):
        grid.table[AT_R + 4 * i], grid.table[AT_R + 4 * i + 1] = 0.0, 0.0
    grid.table[AT_R] = side.sign * side.wall.gap
    watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)


# ---- derivatives by parameters, and responses ----------------------------------------------------


@jit
def terms_on(linear, by, constant, state, drive, variation):
    """Return `driven.terms_on` of a damper that is one mass with the structure."""
    ps, damper = linear.ps, linear.damper
    x1, v1, _, _ = state
    a, b, _, _ = variation
    other, pace = 1.0 - damper.share, by[SLOWER]
    alone = ps.force * drive - ps.stiffness * x1 - ps.damping * v1
    both, both_varied = shared(ps, ps.force * drive), shared(ps, by[FORCING] * drive)
    alone = under_once(ps.load, constant, alone) - both
    varied = by[FORCING] * drive - by[STIFFNESS] * x1 - by[DAMPING] * v1
    varied += constant * by[LOAD] - (ps.stiffness * a + ps.damping * b) - both_varied
    dv, db = other * alone + both, other * varied - by[SHARE] * alone + both_varied
    return dv, 0.0, pace * v1 + b, db + pace * dv, 0.0, 0.0
