"""Contact with a spring and a dashpot, F = kc z + cc dz/dt: linear, so it is exact like a flight.

While the wall is pressed, the damper hangs on two springs: with k2 + kc and c2 + cc in place of k2
and c2, and r counted from the balance of the two springs, eq. (5) is that of a flight. A second
grid divides the motion into cells, until the force has fallen to zero; that instant is certified
like a touch. The damper is then still at a depth z = -cc s / kc, and flies without a
contact force to z = 0, unless it turns and presses again. If the joint may pull (the law
`kelvin-voigt`), the contact lasts until z = 0.

At touch, and at the release of a joint that pulls, the force jumps by cc s. A variation that is
late by r / s is then moved on by cc r, independent of the speed (a saltation matrix of determinant
1).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.driven import (
    GAP,
    Linear,
    carry,
    columns_of,
    constants_of,
    put_columns,
    rows_of,
    seen_from_wall,
    wall_at,
)
from ..motion.flight import COEF, FACTOR, ORDER, TERMS, Grid, at, bare_grid
from ..motion.response_sums import LOSS, OF_FORCE, S2, place_of_largest
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.fours import bare
from ..scene import law as contact_series
from ..scene.codes import CLEARED, RELEASED, RETURNED
from ..scene.scene import Damper, Ground, Structure
from ..watch.observe import note_depth, note_force
from ..watch.response import (
    factor_at,
    first_rise,
    local_grid,
    raise_within,
    root,
    walk,
    watch_piece,
)
from ..watch.touch import AT_R

MOST_CELLS_PRESSED = 1 << 23  # in a period on the wall; beyond it the status is TOO_STIFF


LINEAR = True
KC, CC = 0, 1  # columns of the rates of constants


class LinearWall(NamedTuple):
    """Obstacle on a spring and a dashpot: force kc z + cc dz/dt."""

    gap: float  # [m]
    kc: float  # [N/m]
    cc: float  # [N s/m]
    pulls: Any  # True if it may pull until the depth is zero, otherwise None


SORTS = {
    ("linear", False): LinearWall(0.0, 0.0, 0.0, None),
    ("kelvin-voigt", False): LinearWall(0.0, 0.0, 0.0, True),
}


class Leaving(NamedTuple):
    """The flight from the depth at which the force has vanished to z = 0 (`walk`)."""

    wall: LinearWall
    grid: Grid
    watched: np.ndarray  # the polynomial whose rise ends the motion, in the places of r


class Pressed(NamedTuple):
    """The motion on a pressed wall (`walk`), and that of leaving it."""

    wall: LinearWall
    shift: float  # r of the balance of both springs [m], of a near wall
    grid: Grid  # of r that counts from there
    watched: np.ndarray  # as of `Leaving`
    leaving: Leaving


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    return LinearWall(gap, cell.kc, cell.cc, sort.pulls)


@jit
def in_range(sort, cell):
    return 0.0 < cell.kc < math.inf and 0.0 <= cell.cc < math.inf


@jit
def fill_constants(sort, change, rates, at):
    rates[at + KC], rates[at + CC] = change.kc, change.cc


@jit
def pushes(wall, q, s):
    return wall.pulls is not None or wall.kc * q + wall.cc * s > 0.0


@jit
def contact_energy(wall, z):
    return 0.5 * wall.kc * z * z


@jit
def depth_of(wall, q):
    return q


@jit
def root_of(wall, z):
    return z


@jit
def force_at(wall, depth):
    return 0.0  # the greatest force has been recorded piece by piece


# ---- preparation ---------------------------------------------------------------------------------


@jit
def held_at(wall, ps, damper, begun):
    # the bodies on both springs, and the share of the gap at which the springs are in balance
    if is_a(damper, Ground):
        joint, share = damper, wall.kc / (ps.k1 + wall.kc)
        one = Structure(
            ps.m1, ps.k1 + wall.kc, ps.stiffness + wall.kc / ps.m1, ps.damping + wall.cc / ps.m1,
            ps.force, ps.omega, ps.load, ps.shaken,
        )  # fmt: skip
    else:
        one, share = ps, wall.kc / (damper.k2 + wall.kc)
        joint = Damper(
            damper.m2, damper.k2 + wall.kc, damper.c2 + wall.cc, damper.inv_m1, damper.inv_mu,
            damper.share, damper.rest,
        )  # fmt: skip
    watched = np.zeros(COEF + TERMS)
    leaving = Leaving(wall, local_grid(ps, damper, begun), watched)
    return Pressed(wall, share * wall.gap, local_grid(one, joint, begun), watched, leaving)


@jit
def bare_motion(motion):
    wall, watched = motion.wall, bare(motion.watched)
    leaving = Leaving(wall, bare_grid(motion.leaving.grid), watched)
    return Pressed(wall, motion.shift, bare_grid(motion.grid), watched, leaving)


@jit
def too_stiff(motion, period):
    """Return True if a period [s] on the wall takes more cells than MOST_CELLS_PRESSED."""
    return not period <= MOST_CELLS_PRESSED * motion.grid.h


# ---- the end of a motion on the wall -------------------------------------------------------------


@jit
def watch_push(stiffness, drag, gap, sign, w, watched):
    """Fill the places of r in `watched` with the Taylor coefficients of minus the push.

    The push is stiffness (sign r - gap) + drag sign s; with stiffness 1 and drag 0 it is the depth.
    The first rise of minus the push through zero ends it. With -gap and -sign, the coefficients are
    those of plus the push.
    """
    for k in range(ORDER + 1):
        i = COEF + 4 * k + 2
        watched[i] = -sign * (stiffness * w[i] + drag * w[i + 1])
    watched[AT_R] += stiffness * gap


@jit
def ending(motion, side, w, phase, end):
    """Return the event and place of the release, or, when leaving, of z = 0 or a renewed push."""
    wall, watched, sign = motion.wall, motion.watched, side.sign
    if is_a(motion, Leaving):
        watch_push(1.0, 0.0, wall.gap, sign, w, watched)
        out = first_rise(watched, end, 0.0)
        watch_push(wall.kc, wall.cc, -wall.gap, -sign, w, watched)
        again = first_rise(watched, end, 0.0)
        return (RETURNED, again) if again < out else (CLEARED, out)  # LOST is less than any place
    # The contact ends where minus the force rises to zero; if the wall may pull, minus the depth.
    balance = wall.gap - motion.shift
    if motion.wall.pulls is None:
        watch_push(wall.kc, wall.cc, balance, sign, w, watched)
    else:
        watch_push(1.0, 0.0, balance, sign, w, watched)
    return RELEASED, first_rise(watched, end, 0.0)


# ---- records -------------------------------------------------------------------------------------


@jit
def note_piece(motion, side, watch, grid, phase, begin, end):
    """Record a piece: all that is watched, and depth and force of a contact."""
    if is_a(motion, Leaving):
        return watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)
    # the rows of r count from the balance
    wall, w, shift = motion.wall, grid.table, side.sign * motion.shift
    if watch.impacts is not None:
        balance, sign = wall.gap - motion.shift, side.sign
        note_depth(watch.impacts, greatest(1.0, 0.0, balance, sign, w, end))
        note_force(watch.impacts, greatest(wall.kc, wall.cc, balance, sign, w, end))
    w[AT_R] += shift
    w[COEF] += of_balance(side.damper, shift)
    watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)
    if watch.tally is not None:
        # The largest force in [0, end], whose polynomial is that of spring and dashpot.
        row = watch.tally.row
        for k in range(ORDER + 1):
            i = COEF + 4 * k + 2
            row[FACTOR + k] = side.sign * (wall.kc * grid.table[i] + wall.cc * grid.table[i + 1])
        row[FACTOR] -= wall.kc * wall.gap
        raise_within(watch.tally, grid.table, place_of_largest(int(OF_FORCE), side.sign), end)


@jit
def greatest(stiffness, drag, gap, sign, w, end):
    """Return the largest force of a spring and a dashpot from r = `gap` on in [0, end] of a cell.

    It is at an end, or where its rate falls through zero, of which there is at most one place in a
    cell. w: a table with the polynomial of r in COEF; sign: of the wall.
    """
    for k in range(ORDER):
        i = COEF + 4 * k + 6  # of the next power
        w[FACTOR + k] = (k + 1.0) * sign * (stiffness * w[i] + drag * w[i + 1])
    w[FACTOR + ORDER] = 0.0
    last = at(w, end)
    most = max(
        sign * (stiffness * w[AT_R] + drag * w[AT_R + 1]),
        sign * (stiffness * last[2] + drag * last[3]),
    )
    f0, f1 = w[FACTOR], factor_at(w, end)
    if f0 > 0.0 and f1 < 0.0:
        y = at(w, root(w, 0.0, end, f0, f1))
        most = max(most, sign * (stiffness * y[2] + drag * y[3]))
    return most - stiffness * gap


@jit
def jump_at(wall, damper, tangent, sign, direction):
    """Apply the jump cc s of the force to variations: `direction` 1 at touch, -1 at release."""
    seen_from_wall(tangent, sign, 1.0)  # a parameter may move the wall
    x, v, r, u = columns_of(rows_of(tangent))
    late = (direction * wall.cc) * r
    put_columns(rows_of(tangent), (x, v - damper.inv_m1 * late, r, u - damper.inv_mu * late))
    seen_from_wall(tangent, sign, -1.0)


# ---- the contact ---------------------------------------------------------------------------------


@jit
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (z, s, x1, v1) to its release or for the time `left` [s].

    Arguments and result as those of `contact.follow`, with z in place of q.
    """
    ps, damper, wall, sign, pressed = side.ps, side.damper, side.wall, side.sign, side.motion
    tangent, tally = watch.tangent, watch.tally
    balance, shift = wall.gap - pressed.shift, sign * pressed.shift
    depth, s, x1, v1 = now
    start = x1, v1, sign * (wall.gap + depth), sign * s
    if tangent is not None and depth == 0.0:
        jump_at(wall, damper, tangent, sign, 1.0)
    if tally is not None:
        slow = tally.row[S2]  # the integral of s^2 so far, to which the loss is proportional
    # r counts from the balance of the springs, where the depth is -`balance`
    y = x1 - of_balance(damper, shift), v1, sign * (depth + balance), sign * s
    event, y, took = walk(pressed, side, watch, phase, place, left, y)
    if tally is not None:
        tally.row[LOSS] += wall.cc * (tally.row[S2] - slow)
    x1, v1, r, s = y
    z = max(sign * r - balance, 0.0)
    if tangent is not None:
        carry(tangent, Linear(wall, ps, damper, sign, pressed.grid), place, start, took)
        side.k[contact_series.SHRUNK] -= wall.cc * damper.inv_mu * took
    if event == RELEASED and (wall.pulls is not None or wall.cc == 0.0):
        z = 0.0
        if tangent is not None and wall.pulls is not None:
            jump_at(wall, damper, tangent, sign, -1.0)
    return event, z, sign * s, x1 + of_balance(damper, shift), v1, took, max(depth, z)


@jit
def of_balance(damper, shift):
    """Return the shift [m] of x1, which is that of r if the walls limit the structure itself."""
    if is_a(damper, Ground):
        return shift
    return 0.0


# ---- leaving without a force ---------------------------------------------------------------------


@jit
def leave(side, watch, phase, place, left, now):
    wall, sign, tally = side.wall, side.sign, watch.tally
    z, s, x1, v1 = now
    y = x1, v1, sign * (z + wall.gap), sign * s
    event, y, took = walk(side.motion.leaving, side, watch, phase, place, left, y)
    x1, v1, r, s = y
    z = 0.0 if event == CLEARED else max(sign * r - wall.gap, 0.0)
    if tally is not None:  # the wall's spring relaxes without a force: kc z^2 / 2 is lost
        tally.row[LOSS] += 0.5 * wall.kc * (now[0] - z) * (now[0] + z)
    return event, z, sign * s, x1, v1, took


# ---- derivatives by parameters -------------------------------------------------------------------


@jit
def push_of(wall, outward, r, s, c, d):
    return (wall.kc * (r - outward * wall.gap) + wall.cc * s, wall.kc * c + wall.cc * d)


@jit
def push_changed(wall, by, sign, constant, r, s):
    at, outward = constants_of(sign), constant * sign
    rate = by[at + KC] * (r - outward * wall.gap) + by[at + CC] * s
    return rate - outward * wall.kc * by[wall_at(sign) + GAP]
