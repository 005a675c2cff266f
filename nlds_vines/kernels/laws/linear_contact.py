"""Contact with a spring and a dashpot, F = kc z + cc dz/dt: linear, so it is exact like a flight.

While the wall is pressed, the damper hangs on two springs: with k2 + kc and c2 + cc in place of k2
and c2, and r counted from where the two are in balance, eq. (5) is that of a flight. It is followed
on a grid of its own, cell by cell and once rounded, until the force has fallen to zero; that place
is certified as a touch is. Then the damper is still at a depth z = -cc s / kc, from which it leaves
without a force: a flight too, to z = 0, unless it turns and presses again. Where the joint may pull
(the law `kelvin-voigt`) it lasts until z = 0.

At touch, and where the joint pulls at release, the force jumps by cc s. A variation that is late by
r / s is then moved on by cc r, whatever the speed (a saltation matrix; its determinant is 1).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion import runge_kutta as rk
from ..motion.driven import (
    GAP,
    columns_of,
    constants_of,
    put_columns,
    rows_of,
    seen_from_wall,
    wall_at,
)
from ..motion.driven_flight import Linear, carry
from ..motion.flight import (
    COEF,
    FACTOR,
    ORDER,
    SHORT,
    TERMS,
    Grid,
    at,
    bare_grid,
    grid_with,
    rate_of,
)
from ..motion.load_cells import Stretch, grid_under, phase_during, polynomial_from
from ..motion.once_rounded import after_piece, after_whole, rounded_once
from ..motion.response_sums import LOSS, OF_FORCE, S2, place_of
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.codes import CLEARED, EXHAUSTED, RELEASED, RETURNED, STOPPED
from ..scene.scene import Damper, Ground, Structure, joined, mirrored_load
from ..watch.observe import note_depth, note_force
from ..watch.peaks import factor_at, root
from ..watch.response import bend_in_rows, note_cell, raise_within
from ..watch.touch import AT_R, LOST, first_touch, tightened

MOST_CELLS = 1 << 23  # of a contact that lasts a period; beyond it the status is TOO_STIFF


LINEAR = True
KC, CC = 0, 1  # columns of what parameters change


class LinearWall(NamedTuple):
    """Obstacle on a spring and a dashpot: force kc z + cc dz/dt."""

    gap: float  # [m]
    kc: float  # [N/m]
    cc: float  # [N s/m]
    pulls: Any  # True where it may pull until the depth is zero, otherwise None


SORTS = {
    ("linear", False): LinearWall(0.0, 0.0, 0.0, None),
    ("kelvin-voigt", False): LinearWall(0.0, 0.0, 0.0, True),
}


class Pressed(NamedTuple):
    """The motion on a wall that is pressed, and beside it."""

    ps: Structure
    damper: Any  # `scene.Damper`, or `scene.Ground`, where the structure is pressed itself
    shift: float  # r of the balance of both springs [m], of a near wall
    grid: Grid
    loose: Grid  # of the motion without the wall
    watched: np.ndarray  # rows of what is watched, where a grid's table has those of r


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    """Return the wall at a limit `gap` [m] of r."""
    return LinearWall(gap, cell.kc, cell.cc, sort.pulls)


@jit
def in_range(sort, cell):
    """Tell whether the constants are in range."""
    return 0.0 < cell.kc < math.inf and 0.0 <= cell.cc < math.inf


@jit
def fill_constants(sort, change, rates, at):
    """Fill what changes of stiffness and damping."""
    rates[at + KC], rates[at + CC] = change.kc, change.cc


@jit
def pushes(wall, q, s):
    """Tell whether a wall pushes a damper that is beyond the place of touch, or may pull."""
    return wall.pulls is not None or wall.kc * q + wall.cc * s > 0.0


@jit
def depth_of(wall, q):
    """Return the depth z [m]: q is z itself."""
    return q


@jit
def root_of(wall, z):
    """Return q, the depth itself [m]."""
    return z


@jit
def force_at(wall, depth):
    """Return 0: the greatest force has been noted."""
    return 0.0


# ---- made ready ----------------------------------------------------------------------------------


@jit
def joint_of(damper, wall):
    """Return the damper on two springs and dashpots."""
    return Damper(
        damper.m2, damper.k2 + wall.kc, damper.c2 + wall.cc, damper.inv_m1, damper.inv_mu,
        damper.share, damper.rest,
    )  # fmt: skip


@jit
def pressed_bodies(ps, damper, wall):
    """Return (structure, damper, share of the gap at which the springs are in balance)."""
    if is_a(damper, Ground):
        return (
            Structure(
                ps.m1,
                ps.k1 + wall.kc,
                ps.stiffness + wall.kc / ps.m1,
                ps.damping + wall.cc / ps.m1,
                ps.force,
                ps.omega,
                ps.load,
                ps.shaken,
            ),
            damper,
            wall.kc / (ps.k1 + wall.kc),
        )
    return (ps, joint_of(damper, wall), wall.kc / (damper.k2 + wall.kc))


@jit
def local_grid(ps, damper, begun):
    """Return a grid of which only the motion over a cell is known, not the phases of a period."""
    rate = rate_of(ps, joined(damper))
    if is_a(begun, Stretch):
        h = SHORT / max(rate, SHORT / begun.h)
        return grid_under(ps, damper, h, 1, begun)
    return grid_with(ps, damper, SHORT / rate, 1, 0, begun)


@jit
def short_grid(ps, damper, begun):
    """Return such a grid whose cells are rounded once; a load does not last so long."""
    if is_a(begun, Stretch):
        return local_grid(ps, damper, begun)
    return rounded_once(ps, damper, local_grid(ps, damper, begun))


@jit
def held_at(wall, ps, damper, n, begun):
    """Return the `Pressed` of a cell at a wall; `begun` as `flight.grid_with` takes it."""
    one, joint, share = pressed_bodies(ps, damper, wall)
    return Pressed(
        one, joint, share * wall.gap, short_grid(one, joint, begun),
        local_grid(ps, damper, begun), np.zeros(COEF + TERMS),
    )  # fmt: skip


@jit
def too_stiff(held, period):
    """Tell whether a period [s] on the wall had more cells than can be followed."""
    return not period <= MOST_CELLS * held.grid.h


# ---- what is watched -----------------------------------------------------------------------------


@jit
def watch_release(pulls, wall, sign, balance, w, watched):
    """Fill the watched rows with what rises to zero at the release: minus the force, or -z."""
    if pulls is not None:
        return watch_depth(pulls, wall, sign, balance, w, watched)
    return watch_force(pulls, wall, sign, balance, w, watched)


@jit
def watch_force(pulls, wall, sign, balance, w, watched):
    """Fill the watched rows with -F."""
    for k in range(ORDER + 1):
        i = COEF + 4 * k + 2
        watched[i] = -sign * (wall.kc * w[i] + wall.cc * w[i + 1])
    watched[AT_R] += wall.kc * balance


@jit
def watch_depth(pulls, wall, sign, balance, w, watched):
    """Fill the watched rows with -z."""
    for k in range(ORDER + 1):
        watched[COEF + 4 * k + 2] = -sign * w[COEF + 4 * k + 2]
    watched[AT_R] += balance


@jit
def first_zero(watched, end):
    """Return the first place up to `end` where what is watched rises to zero, NOWHERE or LOST."""
    bend, jerk = tightened(watched, math.inf, math.inf)
    return first_touch(watched, 0.0, end, 1.0, 0.0, bend, jerk)


# ---- what is noted -------------------------------------------------------------------------------


@jit
def note_greatest(wall, sign, balance, impacts, w, end):
    """Raise depth and force of the impact under way to their maxima in [0, end] of a cell."""
    for of_force in (False, True):
        for k in range(ORDER + 1):
            i, j = COEF + 4 * k + 2, COEF + 4 * min(k + 1, ORDER) + 2
            w[FACTOR + k] = sign * w[i + 1]
            if of_force:
                rise = 0.0 if k == ORDER else k + 1.0
                w[FACTOR + k] = sign * rise * (wall.kc * w[j] + wall.cc * w[j + 1])
        f0, f1 = w[FACTOR], factor_at(w, end)
        top = end
        if f0 > 0.0 and f1 < 0.0:
            top = root(w, 0.0, end, f0, f1)
        for x in (0.0, top, end):
            y = at(w, x)
            z = sign * y[2] - balance
            if of_force:
                note_force(impacts, wall.kc * z + wall.cc * (sign * y[3]))
            else:
                note_depth(impacts, z)


@jit
def jump(wall, damper, tangent, way):
    """Move variations on where the force jumps by cc s: `way` 1 at touch, -1 at release."""
    x, v, r, u = columns_of(tangent)
    late = (way * wall.cc) * r
    put_columns(tangent, (x, v - damper.inv_m1 * late, r, u - damper.inv_mu * late))


@jit
def jump_at(wall, damper, tangent, sign, way):
    """Move variations on at a wall, of which driven ones may have changed the place."""
    seen_from_wall(tangent, sign, 1.0)
    jump(wall, damper, rows_of(tangent), way)
    seen_from_wall(tangent, sign, -1.0)


# ---- the contact ---------------------------------------------------------------------------------


@jit
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (z, s, x1, v1) to its release or for the time `left` [s].

    Arguments and result as those of `elastic_contact.follow`, with z in place of q.
    """
    ps, damper, wall, sign, held = side.ps, side.damper, side.wall, side.sign, side.held
    impacts, tangent, tally = watch.impacts, watch.tangent, watch.tally
    # r is counted from the balance of the springs, where the depth is -`balance`
    balance, shift = wall.gap - held.shift, sign * held.shift
    z, s, x1, v1 = now
    depth, took, event = z, 0.0, STOPPED
    r = sign * (z + balance)
    began = x1, v1, z, s
    if tangent is not None and z == 0.0:
        jump_at(wall, damper, tangent, sign, 1.0)
    x1 -= carried(damper, shift)
    grid = bare_grid(held.grid)
    w, watched = grid.table, held.watched
    if tally is not None:
        slow = tally.row[S2]  # the integral of s^2 so far, of which the dashpot takes its share
    while event == STOPPED:
        end = min(1.0, (left - took) / grid.h)
        then = phase_during(ps, grid, phase, place, took)
        polynomial_from(grid, (x1, v1, r, s), then)
        watch_release(wall.pulls, wall, sign, balance, w, watched)
        where = first_zero(watched, end)
        if where == LOST:
            event = EXHAUSTED
            break
        piece = end
        if where <= end:
            piece, event = where, RELEASED
        if piece == 1.0:
            y = after_whole(grid.low, damper, w, (x1, v1, r, s), then)
        else:
            y = after_piece(grid.low, damper, grid.load, w, piece, (x1, v1, r, s), then)
        if impacts is not None:
            note_greatest(wall, sign, balance, impacts, w, piece)
        w[AT_R] += shift  # the rows hold r itself
        w[COEF] += carried(damper, shift)
        note_cell(ps, damper, watch, grid, then, took / grid.h, piece)
        if tally is not None:
            tally_force(wall, sign, tally, grid, piece)
        x1, v1, r, s = y
        took = min(took + piece * grid.h, left)
        if event == STOPPED and (end < 1.0 or took >= left):
            took = left
            break
    if tally is not None:
        tally.row[LOSS] += wall.cc * (tally.row[S2] - slow)
    if event == RELEASED and took >= left:
        event, took = STOPPED, left
    z = max(sign * r - balance, 0.0)
    if tangent is not None:
        seen = mirrored_load(ps.load, ps, sign)
        start = sign * began[0], sign * began[1], wall.gap + began[2], sign * began[3]
        carry(tangent, Linear(wall, seen, damper, sign, held.grid), place, start, took)
        side.k[rk.SHRUNK] -= wall.cc * damper.inv_mu * took
    if event == RELEASED and (wall.pulls is not None or wall.cc == 0.0):
        z = 0.0
        if tangent is not None and wall.pulls is not None:
            jump_at(wall, damper, tangent, sign, -1.0)
    return event, z, s, x1 + carried(damper, shift), v1, took, max(depth, z)


@jit
def carried(damper, shift):
    """Return by how much x1 is counted from elsewhere: as r, where walls limit the structure."""
    if is_a(damper, Ground):
        return shift
    return 0.0


# ---- leaving without a force ---------------------------------------------------------------------


@jit
def leave(side, watch, phase, place, left, now):
    """Fly from a depth z > 0 at which the wall does not push, to z = 0 or for the time `left` [s].

    now: (z, s, x1, v1). Returns (event, z, s, x1, v1, time [s]): CLEARED at z = 0, RETURNED where
    the wall pushes again before, STOPPED or EXHAUSTED.
    """
    ps, damper, wall, sign = side.ps, side.damper, side.wall, side.sign
    tally = watch.tally
    watched = side.held.watched
    took = 0.0
    z, s, x1, v1 = now
    r = sign * (z + wall.gap)
    grid = bare_grid(side.held.loose)
    w = grid.table
    while True:
        end = min(1.0, (left - took) / grid.h)
        then = phase_during(ps, grid, phase, place, took)
        polynomial_from(grid, (x1, v1, r, s), then)
        watch_depth(None, wall, sign, wall.gap, w, watched)
        event, where = CLEARED, first_zero(watched, end)
        watch_force(None, wall, -sign, 0.0, w, watched)
        watched[AT_R] -= wall.kc * wall.gap
        again = first_zero(watched, end)
        if where == LOST or again == LOST:
            return EXHAUSTED, z, s, x1, v1, took
        if again < where:
            event, where = RETURNED, again
        piece = min(where, end)
        note_cell(ps, damper, watch, grid, then, took / grid.h, piece)
        x1, v1, r, s = at(w, piece)
        took = min(took + piece * grid.h, left)
        if where <= end and took < left:
            break
        if end < 1.0 or took >= left:
            event, took = STOPPED, left
            break
    z = 0.0 if event == CLEARED else max(sign * r - wall.gap, 0.0)
    if tally is not None:  # the wall springs back without a force: kc z^2 / 2 is lost
        tally.row[LOSS] += 0.5 * wall.kc * (now[0] - z) * (now[0] + z)
    return event, z, s, x1, v1, took


# ---- what parameters drive, and responses --------------------------------------------------------


@jit
def push_of(wall, constant, r, s, c, d):
    """Return the force of what is linear on a wall, r and s as it sees them; and of a variation."""
    return (wall.kc * (r - constant * wall.gap) + wall.cc * s, wall.kc * c + wall.cc * d)


@jit
def push_changed(wall, by, sign, constant, r, s):
    """Return what changes of that force by the parameter itself."""
    at = constants_of(sign)
    found = by[at + KC] * (r - constant * wall.gap) + by[at + CC] * s
    return sign * (found - constant * wall.kc * by[wall_at(sign) + GAP])


@jit
def fill_force(row, w, wall, sign):
    """Fill them with the force of a wall with a spring and a dashpot."""
    for k in range(ORDER + 1):
        i = COEF + 4 * k + 2
        row[FACTOR + k] = sign * (wall.kc * w[i] + wall.cc * w[i + 1])
    row[FACTOR] -= wall.kc * wall.gap


@jit
def tally_force(wall, sign, tally, grid, end):
    """Raise the largest force to that in [0, end] of a cell in contact, whose rows hold r."""
    row = tally.row
    fill_force(row, grid.table, wall, sign)
    raise_within(tally, grid, place_of(int(OF_FORCE), sign), bend_in_rows(row), end)
