"""Hertz's law, the paper's: force K z^(3/2), equations (2) and (4).

With z = q^2 the equations are polynomial (`taylor`). A short impact is solved at once (`impact`),
and stepped in between if a record asks for it (`inside`). All other contacts are stepped: slow,
pressed and soft ones, and all contacts by rk4.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..events.contact import contact
from ..impact.impact import LASTING, short_impact
from ..impact.inside import (
    note_inside,
    read_ahead,
    state_at_section,
    tally_inside,
    variations_finely,
    vary,
    vary_inside,
)
from ..motion.driven import Driven
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import exp, fifth_root, hypotenuse, log
from ..scene.codes import RELEASED, STOPPED
from ..scene.drive import later
from ..scene.law import AHEAD, AT_Q, COLUMNS, DEPTH, ELASTIC, SERIES, WEIGHT, product, square
from ..scene.scene import Watch
from ..watch.observe import note_energy
from ..watch.touch import may_pass

SHORT_IMPACTS = True
FREE_THETA = 5.607  # theta from touch to release of a free impact, times sqrt(kappa) q_m^(3/2)
HERTZ_K = 0  # column of the rates of constants


class HertzWall(NamedTuple):
    """Obstacle with Hertz contact: depth z = r - gap (or -r - gap), force K z^(3/2)."""

    gap: float  # [m]
    K: float  # [N/m^1.5]
    kappa: float  # K / mu [m^-0.5 s^-2]
    speed: float  # sqrt(4 kappa / 5): approach speed = speed * (greatest depth)^(5/4)
    whole: float = FREE_THETA
    lasting: float = LASTING
    damping: Any = None  # `power` has Hertz's law with damping
    switch: Any = None


SORTS = {("hertz", False): HertzWall(0.0, 0.0, 0.0, 0.0)}


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    return hertz_wall_at(gap, damper.inv_mu, cell)


@jit
def hertz_wall_at(gap, inv_mu, cell):
    """Return the `HertzWall` at r = `gap` [m]; inv_mu: of the bodies."""
    kappa = cell.K * inv_mu
    return HertzWall(gap, cell.K, kappa, math.sqrt(0.8 * kappa), FREE_THETA, LASTING, None, None)


@jit
def in_range(sort, cell):
    return 0.0 < cell.K < math.inf


# ---- depth, force and energy ---------------------------------------------------------------------


@jit
def depth_of(wall, q):
    return q * q


@jit
def root_of(wall, z):
    return math.sqrt(z)


@jit
def weight_of(wall, q):
    return q


@jit
def rate_of_q(wall, s):
    return 0.5 * s


@jit
def contact_terms(wall, k, n):
    """Fill coefficient n of dt/dtheta = q, z = q^2 and z^(3/2) = z q."""
    row = SERIES + COLUMNS * n
    k[row + WEIGHT], k[row + DEPTH] = k[row + AT_Q], square(k, int(AT_Q), n)
    k[row + ELASTIC] = product(k, int(DEPTH), int(AT_Q), n)


@jit
def elastic_term(wall, k, n):
    return product(k, int(DEPTH), int(AT_Q), n)


@jit
def steep_term(wall, k, n):
    return 1.5 * wall.K * k[SERIES + COLUMNS * n + AT_Q]


@jit
def elastic(wall, stiffness, q, z):
    return stiffness * z * q


@jit
def at_depth(wall, stiffness, depth):
    return stiffness * depth * math.sqrt(depth)


@jit
def stored(wall, stiffness, z, q):
    return 0.4 * stiffness * z * z * q


# ---- scales: n = 3/2, p = 2, N = 5 ---------------------------------------------------------------


@jit
def reach_of(wall, q, z, s):
    return hypotenuse(q * q * math.sqrt(q), s / wall.speed)


@jit
def turn_of(wall, reach):
    fifth = fifth_root(reach)
    return reach * fifth, fifth * fifth


@jit
def pressed(wall, external):
    return abs(external)


@jit
def faint(wall, ratio):
    return exp(2.0 / 3.0 * log(ratio))


# ---- derivatives by parameters -------------------------------------------------------------------


@jit
def fill_constants(sort, change, rates, at):
    rates[at + HERTZ_K] = change.K


@jit
def pushed_term(wall, k, by, at, n):
    return by[at + HERTZ_K] * k[SERIES + COLUMNS * n + ELASTIC]


# ---- a contact -----------------------------------------------------------------------------------


@jit
def released(k):
    """Return, as `contact` does, the release of the solved impact; none is under way then."""
    ahead = read_ahead(k)
    k[AHEAD] = 0.0
    s, x1, v1 = ahead.release
    return RELEASED, 0.0, s, x1, v1, ahead.took - ahead.elapsed, ahead.depth


@jit
def follow_short_impact(side, watch, phase, left, now):
    """Follow a contact as a short impact, if it is one, to its release or for `left` [s].

    Returns (is_short, result as of `contact`). An impact is solved once, from touch to release, and
    kept as `Ahead` in the scratch, from which it continues after a section.
    """
    k, tangent = side.k, watch.tangent
    only_ends = watch.limit_log is None and watch.energy is None and watch.tangent is None
    if only_ends and k[AHEAD] > 0.0 and not k[AHEAD] - k[AHEAD + 1] > left:
        return True, released(k)
    begins = k[AHEAD] == 0.0
    if begins:
        _, s, x1, v1 = now
        solved, out, a1, b1, took, depth = short_impact(side, watch.impacts, phase, now)
        if not solved:
            return False, (RELEASED, 0.0, s, x1, v1, 0.0, 0.0)
        if tangent is not None and took <= left:
            vary(side, phase, (s, x1, v1), (out, a1, b1, took), tangent)
        k[AHEAD], k[AHEAD + 1], k[AHEAD + 2] = took, 0.0, depth
        k[AHEAD + 3], k[AHEAD + 4], k[AHEAD + 5] = s, x1, v1
        k[AHEAD + 6], k[AHEAD + 7], k[AHEAD + 8] = out, a1, b1
    remains = k[AHEAD] - k[AHEAD + 1]
    stops = remains > left
    # Record energies and passages of a limit, up to the release or for the time `left`.
    ahead = read_ahead(k)
    if watch.energy is not None:
        touch = later(side.ps, phase, -ahead.elapsed)
        note_inside(side, watch.energy, touch, ahead, now, min(left, remains))
    if watch.limit_log is not None and may_pass(
        side, watch.limit_log, phase, ahead.took, ahead.touch
    ):  # the contact is stepped in addition, without effect on the orbit
        alone = Watch(watch.limit_log, None, None, None, None, None)
        contact(side, alone, phase, now, min(left, remains))
    # The state at a section inside the impact.
    result = STOPPED, 0.0, 0.0, 0.0, 0.0, left, 0.0
    if stops:
        before = k[AHEAD + 1]
        touch = later(side.ps, phase, -before) if before > 0.0 else phase
        k[AHEAD + 1] = before + left
        ahead = read_ahead(k)
        q, s, x1, v1 = state_at_section(side, touch, ahead)
        if watch.energy is not None:
            r = side.sign * (side.wall.gap + q * q)
            note_energy(side.ps, side.damper, watch.energy, x1, v1, r, side.sign * s)
        result = STOPPED, q, s, x1, v1, left, q * q if s > 0.0 else ahead.depth
    if tangent is not None and (stops or not begins):
        if stops and not begins:  # from one section to the next
            only = Watch(None, None, None, None, tangent, None)
            contact(variations_finely(side), only, phase, now, left)
        else:
            ahead = read_ahead(k)
            back = 0.0 if begins else -ahead.elapsed
            vary_inside(side, later(side.ps, phase, back), tangent, ahead, begins)
    if stops:
        return True, result
    return True, released(k)


@jit
def follow(side, watch, phase, place, left, now):
    """Follow a contact, at once if it is a short impact (arguments and result of `contact.follow`).

    Driven variations are stepped even if the orbit is solved.
    """
    if is_a(watch.tangent, Driven):
        fine = variations_finely(side)
        contact(fine, Watch(None, None, None, None, watch.tangent, None), phase, now, left)
        others = Watch(watch.limit_log, watch.energy, watch.clearance, watch.impacts, None, None)
        return solve_or_step(side, others, phase, left, now)
    return solve_or_step(side, watch, phase, left, now)


@jit
def solve_or_step(side, watch, phase, left, now):
    """Follow a contact as a short impact if it is one, otherwise by steps."""
    solved, result = False, (RELEASED, 0.0, now[1], now[2], now[3], 0.0, 0.0)
    if side.rk4 is None and side.arc is not None:
        solved, result = follow_short_impact(side, watch, phase, left, now)
    if not solved:
        result = contact(side, watch, phase, now, left)
    elif watch.tally is not None:
        if now[0] == 0.0 and now[1] > 0.0 and result[0] == RELEASED:
            _, _, s, x1, v1, took, _ = result
            tally_inside(side, watch.tally, phase, now, (s, x1, v1, took))
        else:  # a part of it
            contact(side, Watch(None, None, None, None, None, watch.tally), phase, now, left)
    return result
