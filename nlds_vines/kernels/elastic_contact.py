"""A contact of elastic bodies: a short impact where it is one, otherwise stepped.

What is noted of a short impact, and where a section cuts it, is read off its solution (`inside`,
`state_inside`).
"""

from __future__ import annotations

from . import runge_kutta as rk
from .arguments import Watch, side_with
from .codes import (
    RELEASED,
    STOPPED,
)
from .compiling import jit
from .contact import Steps, contact
from .contact_field import rotated
from .driven import by_root_of, smoothed
from .impact import short_impact
from .impact_variations import vary
from .inside import Ahead, keep_ahead, note_inside, read_ahead
from .inside_variations import vary_cut
from .limit import may_pass
from .observe import note_energy
from .scene import mirrored_load
from .state_inside import state_at_section

# How driven variations are stepped through an impact that is solved: what K drives, all of which is
# made in impacts, errs by 1e-9 then, other derivatives by 1e-11.
OF_DRIVEN, VERIFIED = 33.0, 2.5e-11  # steps of a free impact, and what is verified of it


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
    if limit_log is not None and may_pass(side, limit_log, ahead.took, ahead.touch):
        contact(side, Watch(limit_log, None, None, None, None), phase, now, lasting)


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
def as_seen(side, now, phase):
    """Return a side, a state (q, s, x1, v1) and a phase as the wall sees them.

    A wall that pushes towards -x2 sees them mirrored, and the constant load.
    """
    ps, sign = mirrored_load(side.ps.load, side.ps, side.sign), side.sign
    seen = side_with(side, ps, side.damper, side.wall, side.steps)
    return seen, turned(sign, now), (sign * phase[0], sign * phase[1])


@jit
def turned(sign, now):
    """Return a state (q, s, x1, v1) mirrored by a sign."""
    return now[0], sign * now[1], sign * now[2], sign * now[3]


@jit
def follow_contact(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    phase: (cos, sin) of the forcing's; place: share of the period that is over; `Watch` and result
    (event, q, s, x1, v1, elapsed, depth) as of `contact`. What is no short impact is stepped: by
    rk4, or by another law than Hertz', all.
    """
    seen, start, wave = as_seen(side, now, phase)
    solved, result = False, (RELEASED, 0.0, start[1], start[2], start[3], 0.0, 0.0)
    if side.rk4 is None and side.arc is not None:
        solved, result = follow_short_impact(seen, watch, wave, left, start)
    if not solved:
        result = contact(seen, watch, wave, start, left)
    return mirrored_back(side, result)


@jit
def mirrored_back(side, result):
    """Return a result of `contact` with the state as it is, not as the wall sees it."""
    event, q, s, x1, v1, took, depth = result
    return event, q, side.sign * s, side.sign * x1, side.sign * v1, took, depth


# ---- with variations that parameters drive -------------------------------------------------------


@jit
def step_driven(side, watch, phase, left, now):
    """Step a contact with driven variations; return as `follow_contact`."""
    seen, start, wave = as_seen(side, now, phase)
    smooth = smoothed(watch.tangent, side.wall, side.sign)
    seen = side_with(seen, seen.ps, seen.damper, smooth, seen.steps)
    start = by_root_of(smooth, side.wall, start[0]), start[1], start[2], start[3]
    event, q, s, x1, v1, took, depth = contact(seen, watch, wave, start, left)
    q = by_root_of(side.wall, smooth, q)
    return mirrored_back(side, (event, q, s, x1, v1, took, depth))


@jit
def follow_driven(side, watch, phase, place, left, now):
    """Follow a contact with driven variations: they are stepped even where the orbit is solved.

    Arguments and result as those of `follow_contact`.
    """
    if side.arc is None:
        return step_driven(side, watch, phase, left, now)
    fine = side_with(side, side.ps, side.damper, side.wall, Steps(OF_DRIVEN, VERIFIED))
    step_driven(fine, Watch(None, None, None, None, watch.tangent), phase, left, now)
    others = Watch(watch.limit_log, watch.energy, watch.clearance, watch.impacts, None)
    return follow_contact(side, others, phase, place, left, now)
