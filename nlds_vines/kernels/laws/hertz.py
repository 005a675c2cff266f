"""Hertz's law, the paper's: force K z^(3/2), equations (2) and (4).

With z = q^2 all is a polynomial (`contact_field`). A short impact is solved at once (`impact`);
what is noted of it, and where a section cuts it, is read off its solution (`inside`,
`state_inside`). All other contacts are stepped: slow, pressed and soft ones, and by rk4 all.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..events.contact import Steps, contact
from ..events.elastic_contact import as_seen, mirrored_back, step_driven, tally_stepped
from ..impact.impact import LASTING, short_impact
from ..impact.impact_variations import vary
from ..impact.inside import Ahead, keep_ahead, note_inside, read_ahead
from ..impact.inside_variations import vary_cut
from ..impact.response_inside import tally_halves
from ..impact.state_inside import state_at_section
from ..motion import runge_kutta as rk
from ..motion.driven import Driven
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import exp, fifth_root, hypotenuse, log
from ..scene.arguments import Watch, side_with
from ..scene.codes import RELEASED, STOPPED
from ..scene.drive import rotated
from ..watch.limit import may_pass
from ..watch.observe import note_energy

SHORT_IMPACTS = True
WHOLE = 5.607  # theta from touch to release of a free Hertz impact, times sqrt(kappa) q_m^(3/2)
# How driven variations are stepped through an impact that is solved: what K drives, all of which is
# made in impacts, errs by 1e-9 then, other derivatives by 1e-11.
OF_DRIVEN, VERIFIED = 33.0, 2.5e-11  # steps of a free impact, and what is verified of it
OF_K = 0  # column of what parameters change


class HertzWall(NamedTuple):
    """Obstacle with Hertz contact: depth z = r - gap (or -r - gap), force K z^(3/2)."""

    gap: float  # [m]
    K: float  # [N/m^1.5]
    kappa: float  # K / mu [m^-0.5 s^-2]
    speed: float  # sqrt(4 kappa / 5): approach speed = speed * (greatest depth)^(5/4)
    whole: float = WHOLE
    lasting: float = LASTING
    damping: Any = None  # none: `power` has Hertz's law with damping
    switch: Any = None


SORTS = {("hertz", False): HertzWall(0.0, 0.0, 0.0, 0.0)}


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    """Return the wall at a limit `gap` [m] of r."""
    return hertz_wall_at(gap, damper.inv_mu, cell)


@jit
def hertz_wall_at(gap, inv_mu, cell):
    """Return the `HertzWall` at a limit `gap` of the spring's shortening; inv_mu: of the bodies."""
    kappa = cell.K * inv_mu
    return HertzWall(gap, cell.K, kappa, math.sqrt(0.8 * kappa), WHOLE, LASTING, None, None)


@jit
def in_range(sort, cell):
    """Tell whether the constants are in range."""
    return 0.0 < cell.K < math.inf


# ---- depth, force and energy ---------------------------------------------------------------------


@jit
def depth_of(wall, q):
    """Return the depth z = q^2 [m]."""
    return q * q


@jit
def root_of(wall, z):
    """Return q = sqrt(z)."""
    return math.sqrt(z)


@jit
def weight_of(wall, q):
    """Return dt/dtheta = q."""
    return q


@jit
def rate_of_q(wall, s):
    """Return dq/dtheta = s / 2."""
    return 0.5 * s


@jit
def way_of_step(wall, h, s):
    """Return by how much q changes in two steps h at the rate s, but for the sign."""
    return h * s


@jit
def elastic(wall, stiffness, q, z):
    """Return stiffness z^(3/2)."""
    return stiffness * z * q


@jit
def at_depth(wall, stiffness, depth):
    """Return stiffness z^(3/2) at a depth [m]."""
    return stiffness * depth * math.sqrt(depth)


@jit
def steepness(wall, q):
    """Return 3/2 K sqrt(z)."""
    return 1.5 * wall.K * q


@jit
def stored(wall, stiffness, z, q):
    """Return 2/5 of stiffness z^(5/2)."""
    return 0.4 * stiffness * z * z * q


@jit
def gained(wall, y, p, z, q):
    """Return by how much 2/5 kappa z^(5/2) rises from z = q^2 to y = p^2."""
    return 0.4 * wall.kappa * (y * y * p - z * z * q)


# ---- scales: n = 3/2, p = 2, N = 5 ---------------------------------------------------------------


@jit
def reach_of(wall, q, z, s):
    """Return q^(5/2) where the free contact through (q, s) turns."""
    return hypotenuse(q * q * math.sqrt(q), s / wall.speed)


@jit
def turn_of(wall, reach):
    """Return (q^3, q) where a free contact turns, whose q^(5/2) there is `reach`."""
    fifth = fifth_root(reach)
    return reach * fifth, fifth * fifth


@jit
def pressed(wall, external):
    """Return the square of the rate by theta of a contact that an acceleration [m/s^2] presses."""
    return abs(external)


@jit
def faint(wall, ratio):
    """Return the depth [m] at which kappa z^(3/2) is `ratio` kappa [m^1.5]."""
    return exp(2.0 / 3.0 * log(ratio))


# ---- what parameters change ----------------------------------------------------------------------


@jit
def fill_constants(sort, change, rates, at):
    """Fill what changes of K."""
    rates[at + OF_K] = change.K


@jit
def pushed_by_constants(wall, by, at, q, z, s):
    """Return what changes of the force [N] by K."""
    return by[at + OF_K] * elastic(wall, 1.0, q, z)


# ---- a contact -----------------------------------------------------------------------------------


@jit
def note_part(side, watch, phase, lasting, now):
    """Note the energies, and passages of a limit, of `lasting` [s] of the impact that is ahead.

    now: (q, s, x1, v1) at its beginning; phase: (cos, sin) there. Passages are noted by steps,
    where there may be one: nothing that is noted changes the orbit.
    """
    ahead, limit_log = read_ahead(side.k, int(rk.AHEAD)), watch.limit_log
    if watch.energy is not None:
        touch = rotated(phase[0], phase[1], -side.ps.omega * ahead.elapsed)
        note_inside(side, watch.energy, touch, ahead, lasting)
    if limit_log is not None and may_pass(side, limit_log, phase, ahead.took, ahead.touch):
        contact(side, Watch(limit_log, None, None, None, None, None), phase, now, lasting)


@jit
def up_to_section(side, energy, phase, left):
    """Return as `contact` how the impact that is ahead is at a section, `left` [s] from now."""
    k = side.k
    before = k[rk.AHEAD + 1]
    touch = rotated(phase[0], phase[1], -side.ps.omega * before) if before > 0.0 else phase
    k[rk.AHEAD + 1] = before + left
    ahead = read_ahead(k, int(rk.AHEAD))
    q, s, x1, v1 = state_at_section(side, touch, ahead)
    if energy is not None:
        note_energy(side.ps, side.damper, energy, x1, v1, side.wall.gap + q * q, s)
    depth = q * q if s > 0.0 else ahead.depth
    return STOPPED, q, s, x1, v1, left, depth


@jit
def released(k):
    """Return as `contact` that the impact which is ahead has ended; it is ahead no more."""
    ahead = read_ahead(k, int(rk.AHEAD))
    k[rk.AHEAD] = 0.0
    s, x1, v1 = ahead.release
    return RELEASED, 0.0, s, x1, v1, ahead.took - ahead.elapsed, ahead.depth


@jit
def only_ends(watch, k, left):
    """Tell whether an impact is ahead of which nothing but its release remains to be known."""
    if watch.limit_log is None and watch.energy is None and watch.tangent is None:
        return k[rk.AHEAD] > 0.0 and not k[rk.AHEAD] - k[rk.AHEAD + 1] > left
    return False


@jit
def follow_short_impact(side, watch, phase, left, now):
    """Try to follow a contact as a short impact, to its release or for the time `left` [s].

    Returns whether it is one, and the result as of `contact`. An impact is solved once, as a whole,
    and kept as `Ahead` in the scratch, whence it goes on behind a section. Variations go with the
    orbit.
    """
    k, tangent = side.k, watch.tangent
    if only_ends(watch, k, left):
        return True, released(k)
    begins = k[rk.AHEAD] == 0.0
    if begins:
        _, s, x1, v1 = now
        solved, out, a1, b1, took, depth = short_impact(side, watch.impacts, phase, now)
        if not solved:
            return False, (RELEASED, 0.0, s, x1, v1, 0.0, 0.0)
        if tangent is not None and took <= left:
            vary(side, phase, (s, x1, v1), (out, a1, b1, took), tangent)
        keep_ahead(k, int(rk.AHEAD), Ahead(took, 0.0, depth, (s, x1, v1), (out, a1, b1)))
    remains = k[rk.AHEAD] - k[rk.AHEAD + 1]
    note_part(side, watch, phase, min(left, remains), now)
    stops = remains > left
    result = STOPPED, 0.0, 0.0, 0.0, 0.0, left, 0.0
    if stops:
        result = up_to_section(side, watch.energy, phase, left)
    if tangent is not None and (stops or not begins):
        c, d = phase
        section = rotated(c, d, side.ps.omega * left) if stops else phase
        vary_cut(side, section, tangent, begins)
    if stops:
        return True, result
    return True, released(k)


@jit
def follow(side, watch, phase, place, left, now):
    """Follow a contact: at once if it is a short impact (`elastic_contact.follow`).

    Driven variations are stepped even where the orbit is solved.
    """
    if is_a(watch.tangent, Driven):
        fine = side_with(side, side.ps, side.damper, side.wall, Steps(OF_DRIVEN, VERIFIED))
        step_driven(fine, Watch(None, None, None, None, watch.tangent, None), phase, left, now)
        others = Watch(watch.limit_log, watch.energy, watch.clearance, watch.impacts, None, None)
        return solve_or_step(side, others, phase, left, now)
    return solve_or_step(side, watch, phase, left, now)


@jit
def solve_or_step(side, watch, phase, left, now):
    """Follow a contact, solved at once if it is a short impact, otherwise stepped."""
    seen, start, wave = as_seen(side, now, phase)
    solved, result = False, (RELEASED, 0.0, start[1], start[2], start[3], 0.0, 0.0)
    if side.rk4 is None and side.arc is not None:
        solved, result = follow_short_impact(seen, watch, wave, left, start)
    if not solved:
        result = contact(seen, watch, wave, start, left)
    tally_impact(seen, watch.tally, wave, start, result)
    return mirrored_back(side, result)


@jit
def tally_impact(seen, tally, phase, start, result):
    """Add a contact, by its halves if it is a short impact, or stepped (`tally_stepped`)."""
    if tally is None:
        return
    if result[0] == RELEASED and seen.rk4 is None and seen.arc is not None:
        after = result[1], result[2], result[3], result[4]
        if tally_halves(seen, tally, phase, result[5], start, after):
            return
    tally_stepped(seen, tally, phase, start, result)
