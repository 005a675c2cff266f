"""A contact of elastic bodies: a short impact where it is one, otherwise stepped.

What is noted of a short impact, and where a section cuts it, is read off its solution (`inside`,
`state_inside`).
"""

from __future__ import annotations

from . import runge_kutta as rk
from .codes import (
    RELEASED,
    STOPPED,
)
from .compiling import chosen, jit
from .contact import Steps, contact
from .contact_field import rotated
from .driven import at_wall, by_root_of, smoothed
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


@chosen
def note_by_steps(
    rk4, ps, damper, wall, sign, limit_log, energy, steps, rate, c, d, left, q, s, x1, v1, k
):
    """Step a contact that is solved, for what is noted of it; without an energy or a limit, not."""

    # hot: once per impact
    def step(
        rk4, ps, damper, wall, sign, limit_log, energy, steps, rate, c, d, left, q, s, x1, v1, k
    ):
        # hot: once per impact
        contact(
            rk4, ps, damper, wall, sign, limit_log, energy, None, None, steps, rate, c, d,
            q, s, x1, v1, left, k,
        )  # fmt: skip

    def nothing(
        rk4, ps, damper, wall, sign, limit_log, energy, steps, rate, c, d, left, q, s, x1, v1, k
    ):
        # hot: as `step`
        return None

    return nothing if energy is None and limit_log is None else step


@jit
def note_part(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, steps, rate, c, d, lasting, now, k
):
    """Note the energies, and passages of a limit, of `lasting` [s] of the impact that is ahead.

    now: (q, s, x1, v1) at its beginning; c, d: of the phase there. Passages are noted by steps,
    where there may be one: nothing that is noted changes the orbit.
    """
    # hot: once per impact
    q, s, x1, v1 = now
    ahead = read_ahead(k, int(rk.AHEAD))
    if energy is not None:
        phase = rotated(c, d, -ps.omega * ahead.elapsed)
        note_inside(ps, damper, wall, arc, energy, rate, phase, ahead, lasting)
    if limit_log is not None and may_pass(
        ps, damper, wall, sign, limit_log, ahead.took, ahead.touch
    ):
        note_by_steps(
            rk4, ps, damper, wall, sign, limit_log, None, steps, rate, c, d, lasting,
            q, s, x1, v1, k,
        )  # fmt: skip


@chosen
def note_part_if_wanted(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, steps, rate, c, d, lasting, now, k
):
    """Note what is wanted of an impact (`note_part`), if anything is."""
    # hot: once per impact
    if energy is None and limit_log is None:
        return nothing_to_note
    return note_part


@jit
def nothing_to_note(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, steps, rate, c, d, lasting, now, k
):
    """Note nothing of an impact."""
    # hot: as `note_part`
    return None


@jit
def up_to_section(ps, damper, wall, arc, energy, rate, c, d, left, k):
    """Return as `contact` how the impact that is ahead is at a section, `left` [s] from now."""
    # hot: once per section inside an impact
    before = k[rk.AHEAD + 1]
    phase = rotated(c, d, -ps.omega * before) if before > 0.0 else (c, d)
    k[rk.AHEAD + 1] = before + left
    ahead = read_ahead(k, int(rk.AHEAD))
    q, s, x1, v1 = state_at_section(ps, damper, wall, arc, rate, phase, ahead)
    if energy is not None:
        note_energy(ps, damper, energy, x1, v1, wall.gap + q * q, s)
    depth = q * q if s > 0.0 else ahead.depth
    return STOPPED, q, s, x1, v1, left, depth


@jit
def released(k):
    """Return as `contact` that the impact which is ahead has ended; it is ahead no more."""
    ahead = read_ahead(k, int(rk.AHEAD))
    k[rk.AHEAD] = 0.0
    s, x1, v1 = ahead.release
    return RELEASED, 0.0, s, x1, v1, ahead.took - ahead.elapsed, ahead.depth


@chosen
def only_ends(limit_log, energy, tangent, k, left):
    """Tell whether an impact is ahead of which nothing but its release remains to be known."""
    if limit_log is None and energy is None and tangent is None:
        return lambda limit_log, energy, tangent, k, left: (
            k[rk.AHEAD] > 0.0 and not k[rk.AHEAD] - k[rk.AHEAD + 1] > left
        )
    return lambda limit_log, energy, tangent, k, left: False


@jit
def follow_short_impact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, now, k,
):  # fmt: skip
    """Try to follow a contact as a short impact, to its release or for the time `left` [s].

    Returns whether it is one, and the result as of `contact`. An impact is solved once, as a whole,
    and kept as `Ahead` in `k`, whence it goes on behind a section. Variations go with the orbit.
    """
    # hot: once per impact
    begins = k[rk.AHEAD] == 0.0
    if begins:
        q, s, x1, v1 = now
        solved, out, a1, b1, took, depth = short_impact(
            ps, damper, wall, arc, impacts, rate, c, d, q, s, x1, v1
        )
        if not solved:
            return False, (RELEASED, 0.0, s, x1, v1, 0.0, 0.0)
        if tangent is not None and took <= left:
            vary(ps, damper, wall, arc, rate, (c, d), (s, x1, v1), (out, a1, b1, took), tangent)
        ahead = Ahead(took, 0.0, depth, (s, x1, v1), (out, a1, b1))
        keep_ahead(k, int(rk.AHEAD), ahead)
    remains = k[rk.AHEAD] - k[rk.AHEAD + 1]
    note_part_if_wanted(
        rk4, ps, damper, wall, sign, arc, limit_log, energy, steps, rate, c, d,
        min(left, remains), now, k,
    )  # fmt: skip
    stops = remains > left
    result = STOPPED, 0.0, 0.0, 0.0, 0.0, left, 0.0
    if stops:
        result = up_to_section(ps, damper, wall, arc, energy, rate, c, d, left, k)
    if tangent is not None and (stops or not begins):
        phase = rotated(c, d, ps.omega * left) if stops else (c, d)
        vary_cut(ps, damper, wall, arc, rate, phase, tangent, k, begins)
    if stops:
        return True, result
    return True, released(k)


@jit
def no_short_impact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, now, k,
):  # fmt: skip
    """Return as `follow_short_impact` that it is none."""
    # hot: once per impact
    return False, (RELEASED, 0.0, now[1], now[2], now[3], 0.0, 0.0)


@chosen
def short_impact_if_exact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, now, k,
):  # fmt: skip
    """Follow a short impact; by rk4, or by another law than Hertz', every contact is stepped."""
    # hot: once per impact
    return no_short_impact if rk4 is not None or arc is None else follow_short_impact


@jit
def follow_contact(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held, place,
):  # fmt: skip
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    `phase`: (cos, sin) of the forcing's; place: share of the period that is over; the rest as for
    `contact`. For a wall that pushes towards -x2 (`sign` -1) the motion is mirrored on the way in
    and out. Returns (event, q, s, x1, v1, elapsed, depth) as `contact`.
    """
    # hot: once per impact, in the loop of `orbit`, where `Prepared` as one argument costs 3 %
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    c, d = sign * phase[0], sign * phase[1]
    ps = mirrored_load(ps.load, ps, sign)
    if only_ends(limit_log, energy, tangent, k, left):
        result = released(k)
    else:
        solved, result = short_impact_if_exact(
            rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate,
            c, d, left, (q, s, x1, v1), k,
        )  # fmt: skip
        if not solved:
            result = contact(
                rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate,
                c, d, q, s, x1, v1, left, k,
            )  # fmt: skip
    event, q, s, x1, v1, took, depth = result
    return event, q, sign * s, sign * x1, sign * v1, took, depth


# ---- with variations that parameters drive -------------------------------------------------------


@jit
def step_driven(
    rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k,
):  # fmt: skip
    """Step a contact with driven variations; return as `follow_contact`."""
    # hot: once per impact
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    ps, driven = mirrored_load(ps.load, ps, sign), at_wall(tangent, sign)
    smooth = smoothed(driven, wall)
    q = by_root_of(smooth, wall, q)
    event, q, s, x1, v1, took, depth = contact(
        rk4, ps, damper, smooth, sign, limit_log, energy, impacts, driven, steps, rate,
        sign * phase[0], sign * phase[1], q, s, x1, v1, left, k,
    )  # fmt: skip
    q = by_root_of(wall, smooth, q)
    return event, q, sign * s, sign * x1, sign * v1, took, depth


@jit
def follow_driven(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held, place,
):  # fmt: skip
    """Follow a contact with driven variations: they are stepped even where the orbit is solved.

    Arguments and result as those of `follow_contact`.
    """
    # hot: once per impact
    if arc is None:
        return step_driven(
            rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate,
            phase, left, now, k,
        )  # fmt: skip
    step_driven(
        rk4, ps, damper, wall, sign, None, None, None, tangent, Steps(OF_DRIVEN, VERIFIED), rate,
        phase, left, now, k,
    )  # fmt: skip
    return follow_contact(
        rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, None, steps, rate,
        phase, left, now, k, held, place,
    )  # fmt: skip
