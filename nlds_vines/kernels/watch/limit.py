"""A limit of the spring's shortening r, watched inside contacts as it is in flight.

Between two states a time t apart r stays within B t^2 / 8 of the larger and of the smaller value,
and its rate s has no zero if both values have one sign and sum up to more than B t. B is a bound
of |d2r/dt2| that energy provides: with S^2 twice the mechanical energy, the contact's included,
|dr/dt| <= S / sqrt(mu), so that the depth z, and with it the contact's force, is bounded, too. A
step of which neither proof says enough is halved until they do.

In a contact with the far wall r is at most -gap: wherever that is within the limit, there is
nothing to watch. A contact in which the limit may be passed is stepped (`may_pass`).
"""

from __future__ import annotations

import math

from ..motion.bounds import bend_of
from ..motion.taylor import advance, part_of, restore, save
from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST
from ..numerics.roots import ROOT_STEPS, narrowed, secant
from ..scene.contact_series import NEW, OLD, SAVE
from ..scene.drive import most_push
from ..scene.law import at_depth, damped, depth_of, root_of, stored
from ..scene.scene import moved_mass, scale_of
from .observe import BEYOND, EXCESS, LIMIT, ORIGIN, alike, note_violation
from .touch import ROUND_OFF

MOST_PIECES = 1000  # of a step: some ten are needed, and some hundred at a maximum of r
NEAR_PASSAGE = 1.0e-14  # error of the place of a passage in a step


@jit
def begin_contact(limit_log, sign, gap, time):
    """Let the log count from the `time` [s] of a contact; at the far wall r is at most -gap."""
    if limit_log is not None:
        limit_log[ORIGIN] = time
        if sign < 0.0 and -gap <= limit_log[LIMIT]:
            limit_log[BEYOND] = 0.0


@jit
def may_pass(side, limit_log, phase, duration, touch):
    """Tell whether r may be beyond the limit in a contact of a `duration` [s] from its touch.

    phase: an instant of it (`drive`); touch: (s, x1, v1), as the wall sees it; the energy there
    bounds the depth.
    """
    ps, wall = side.ps, side.wall
    s, x1, v1 = touch
    if side.sign < 0.0:
        return -wall.gap > limit_log[LIMIT]
    scale = scale_of(ps, side.damper, x1, v1, wall.gap, s)
    scale += most_push(ps, phase) * math.sqrt(moved_mass(ps, side.damper)) * duration
    room = limit_log[LIMIT] - wall.gap
    return room <= 0.0 or 2.0 * stored(wall, wall.K, room, root_of(wall, room)) <= scale * scale


@jit
def bend_in_contact(side, phase, duration):
    """Return a bound of |d2r/dt2| [m/s^2] over the `duration` [s] of a step from row Y."""
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q = k[OLD]
    z = depth_of(wall, q)
    scale = scale_of(ps, damper, k[OLD + 2], k[OLD + 3], wall.gap + z, k[OLD + 1])
    scale = math.sqrt(scale * scale + 2.0 * stored(wall, wall.K, z, q))
    scale += most_push(ps, phase) * math.sqrt(moved_mass(ps, damper)) * duration
    fast = scale * math.sqrt(damper.inv_mu)
    deepest = z + fast * duration
    pushed = at_depth(wall, wall.kappa, deepest) * damped(wall, fast)
    return bend_of(ps, damper) * scale + most_push(ps, phase) + pushed


@jit
def row_at(side, step, x):
    """Return (r, s, time) at place x of the step from row Y, of which row SAVE is the end."""
    k, sign, wall = side.k, side.sign, side.wall
    row = int(SAVE)
    if x < 1.0:
        advance(side, None, part_of(step, x))
        row = int(NEW)
    return sign * (wall.gap + depth_of(wall, k[row])), sign * k[row + 1], k[row + 4]


@jit
def passage(side, level, step, x, r, y, z):
    """Return the time after row Y at which r, between places x and y of a step, rises to `level`.

    r, z: its values there.
    """
    low, high, f0, f1, time = x, y, r - level, z - level, 0.0
    for _ in range(ROOT_STEPS):
        at = secant(low, high, f0, f1)
        r, _, time = row_at(side, step, at)
        f = r - level
        if f == 0.0 or min(at - low, high - at) < NEAR_PASSAGE:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, at, f)
    return time


@jit
def note_passage(side, limit_log, step, begun, x, r, y, z):
    """Note how the limit is kept while r goes from r to z between places x and y of a step.

    begun: time [s] of row Y since the contact began.
    """
    level = limit_log[LIMIT]
    if limit_log[BEYOND] == 0.0 and z > level:
        time = 0.0 if r > level else passage(side, level, step, x, r, y, z)
        note_violation(limit_log, limit_log[ORIGIN] + begun + time)
    if limit_log[BEYOND] != 0.0:
        limit_log[EXCESS] = max(limit_log[EXCESS], max(r, z) - level)
        limit_log[BEYOND] = 1.0 if z > level else 0.0


@jit
def is_settled(limit_log, r, z, sag):
    """Tell whether r, within `sag` of r and z, neither passes the limit nor exceeds it as never."""
    level, least, most = limit_log[LIMIT], min(r, z) - sag, max(r, z) + sag
    if limit_log[BEYOND] == 0.0:
        return most < level
    return least > level and most <= level + limit_log[EXCESS]


@jit
def note_limit_step(side, limit_log, step, begun):
    """Note in `limit_log` how the limit of r is kept over the contact step from row Y to row NEW.

    begun: time [s] of row Y since the contact began. Row NEW is kept.
    """
    level, k, wall, sign = limit_log[LIMIT], side.k, side.wall, side.sign
    if sign < 0.0 and -wall.gap <= level:
        return
    save(k)
    bend = bend_in_contact(side, step.phase, k[SAVE + 4])
    q = k[OLD]
    x, width = 0.0, 1.0
    before = sign * (wall.gap + depth_of(wall, q)), sign * k[OLD + 1], 0.0
    after = row_at(side, step, 1.0)
    for _ in range(MOST_PIECES):
        r, s, t = before
        took = after[2] - t
        sag = 0.125 * bend * took * took
        if not is_settled(limit_log, r, after[0], sag):
            # Does r turn in between? If so, halve the piece, unless the turn is of no height.
            monotone = alike(s, after[1]) and abs(s) + abs(after[1]) > bend * took
            flat = ROUND_OFF * (abs(level) + abs(r)) + TINIEST
            if not monotone and flat < sag < math.inf:
                width *= 0.5
                after = row_at(side, step, x + width)
                continue
            note_passage(side, limit_log, step, begun, x, r, x + width, after[0])
        # Go on behind this piece, by a larger one.
        x += width
        if x >= 1.0:
            break
        width = min(2.0 * width, 1.0 - x)
        before = after
        after = row_at(side, step, x + width)
    if x < 1.0:  # r stays at the limit to round-off
        end = row_at(side, step, 1.0)
        note_passage(side, limit_log, step, begun, x, before[0], 1.0, end[0])
    restore(k)
