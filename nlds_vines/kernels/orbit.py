"""The one time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it; it is never summed up, so that the phase of
the section is as sharp after a million periods as after one.
"""

from __future__ import annotations

import math

from . import runge_kutta as rk
from .codes import (
    ASTRAY,
    DIVERGED,
    EXHAUSTED,
    FLYING,
    OK,
    RELEASED,
    SECTION,
    STEP_BUDGET,
    STOPPED,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from .compiling import chosen, is_a, jit
from .contact import contact
from .contact_field import rotated
from .exact import fly
from .fixed_step import fly_fixed, phase_in_step
from .flight import coarse_map, phase_at, propagate, step
from .impact import short_impact
from .impact_variations import vary
from .inside import Ahead, keep_ahead, note_inside, read_ahead, state_inside
from .inside_variations import vary_cut
from .limit import begin_contact, may_pass
from .observe import (
    ORIGIN,
    note_blow,
    note_depth,
    note_energy,
    note_release,
    note_section,
    note_touch,
)
from .restitution import rebound
from .scene import Ground, RigidWall, joined

HUGE = 1.0e150  # beyond any state of a damped system; NaN is caught by the same comparison
MOST_TOUCHES = 100_000  # touches in one period: beyond it the status is STEP_BUDGET
SIZE = 15  # numbers of the state kept between calls: x1, v1, r, s, q = sqrt(z), mode, and from
AHEAD = 6  # AHEAD on what is `Ahead` inside a short impact


@jit
def set_mode(near, far, state):
    """Set q and the mode of a state (x1, v1, r, s) at phase zero: in flight, or inside a contact.

    A start on the wall that moves or is pressed into it is a touch of the first instant, which the
    first flight finds; a start beyond the wall is a contact already under way. Into a rigid wall
    nothing comes: a start beyond it is one on it.
    """
    state[4], state[5] = 0.0, FLYING
    state[AHEAD] = 0.0
    if near is not None and state[2] > near.gap:
        state[5] = TOUCH_NEAR
        state[4], state[2] = into(near, state[2])
    if far is not None and -state[2] > far.gap:
        state[5] = TOUCH_FAR
        state[4], r = into(far, -state[2])
        state[2] = -r


@chosen
def on_ground(damper, state):
    """Let r and s of a state be x1 and v1 where walls limit the structure itself."""

    def the_same(damper, state):
        state[2], state[3] = state[0], state[1]

    return the_same if is_a(damper, Ground) else lambda damper, state: None


@chosen
def structure_at(damper, x1, v1, r, s):
    """Return (x1, v1), which are r and s where walls limit the structure itself."""
    # of two that are integrated side by side, round-off must not make two
    if is_a(damper, Ground):
        return lambda damper, x1, v1, r, s: (r, s)
    return lambda damper, x1, v1, r, s: (x1, v1)


@chosen
def into(wall, r):
    """Return (q, r) of a state at r > gap: q = sqrt(z), but at a rigid wall it is on the wall."""
    if is_a(wall, RigidWall):
        return lambda wall, r: (0.0, wall.gap)
    return lambda wall, r: (math.sqrt(r - wall.gap), r)


@chosen
def fly_on(
    rk4, ps, damper, near, far, limit_log, energy, clearance, grid, stop, j, x, x1, v1, r, s
):
    """Fly to the next event by the method."""
    # hot: the arguments of `fly`
    return fly if rk4 is None else fly_fixed


@chosen
def phase_on(rk4, grid, j, x):
    """Return (cos, sin) of the forcing's phase at place x of cell j, by the method's grid."""
    if rk4 is None:
        return lambda rk4, grid, j, x: phase_at(grid, j, x)
    return lambda rk4, grid, j, x: phase_in_step(grid, j, x)


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


@jit(dissolved=True)
def up_to_section(ps, damper, wall, arc, energy, c, d, left, k):
    """Return as `contact` how the impact that is ahead is at a section, `left` [s] from now."""
    # hot: once per section inside an impact
    ahead = read_ahead(k, int(rk.AHEAD))
    phase = rotated(c, d, -ps.omega * ahead.elapsed)
    elapsed = ahead.elapsed + left
    k[rk.AHEAD + 1] = elapsed
    q, s, x1, v1 = state_inside(ps, damper, wall, arc, phase, ahead, elapsed)
    if energy is not None:
        note_energy(ps, damper, energy, x1, v1, wall.gap + q * q, s)
    depth = q * q if s > 0.0 else ahead.depth
    return STOPPED, q, s, x1, v1, left, depth


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
        result = up_to_section(ps, damper, wall, arc, energy, c, d, left, k)
    if tangent is not None and (stops or not begins):
        phase = rotated(c, d, ps.omega * left) if stops else (c, d)
        vary_cut(ps, damper, wall, arc, rate, phase, tangent, k, begins)
    if stops:
        return True, result
    ahead = read_ahead(k, int(rk.AHEAD))
    k[rk.AHEAD] = 0.0
    s, x1, v1 = ahead.release
    return True, (RELEASED, 0.0, s, x1, v1, remains, ahead.depth)


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
    """Follow a short impact; by rk4 every contact is stepped."""
    # hot: once per impact
    return follow_short_impact if rk4 is None else no_short_impact


@chosen
def wall_of(near, far, mode):
    """Return the wall that is being touched."""
    if far is None:
        return lambda near, far, mode: near
    if near is None:
        return lambda near, far, mode: far
    return lambda near, far, mode: near if mode == TOUCH_NEAR else far


@jit(dissolved=True)
def follow_contact(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, stuck, place,
):  # fmt: skip
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    `phase`: (cos, sin) of the forcing's; place: share of the period that is over; the rest as for
    `contact`. For a wall that pushes towards -x2 (`sign` -1) the motion is mirrored on the way in
    and out. Returns (event, q, s, x1, v1, elapsed, depth) as `contact`.
    """
    # hot: once per impact, in the loop of `orbit`, where `Prepared` as one argument costs 3 %
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    c, d = sign * phase[0], sign * phase[1]
    solved, result = short_impact_if_exact(
        rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
        left, (q, s, x1, v1), k,
    )  # fmt: skip
    if not solved:
        result = contact(
            rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate, c, d,
            q, s, x1, v1, left, k,
        )  # fmt: skip
    event, q, s, x1, v1, took, depth = result
    return event, q, sign * s, sign * x1, sign * v1, took, depth


@chosen
def follow_by_law(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, stuck, place,
):  # fmt: skip
    """Follow a contact by the law of its wall."""
    # hot: as `follow_contact`
    return rebound if is_a(wall, RigidWall) else follow_contact


@jit
def bounded(x1, v1, r, s):
    """Tell whether a state is finite and not absurdly large."""
    return abs(x1) + abs(v1) + abs(r) + abs(s) < HUGE


@jit
def begin_flight(limit_log, began):
    """Let the log of a limit count from the time [s] at which the period began."""
    if limit_log is not None:
        limit_log[ORIGIN] = began


@jit
def at_touch(ps, damper, by_period, impacts, p, mode, time, x1, v1, r, s):
    """Count a touch in period p and begin its row."""
    # hot: once per impact
    if by_period is not None:
        by_period[p, mode - TOUCH_NEAR] += 1
    if impacts is not None:
        note_touch(ps, damper, impacts, mode - TOUCH_NEAR, time, x1, v1, r, s)


@jit
def keep_slowest(slowest, s):
    """Lower the smallest approach speed to that of a touch."""
    if slowest is not None:
        slowest[0] = min(slowest[0], abs(s))


@chosen
def note_force(impacts, wall, depth):
    """Note the depth [m] and the force of a contact; that of a rigid wall has no bound."""
    if is_a(wall, RigidWall):
        return lambda impacts, wall, depth: note_blow(impacts)
    return lambda impacts, wall, depth: note_depth(impacts, wall.K, depth)


@jit
def after_contact(ps, damper, impacts, event, wall, depth, time, x1, v1, r, s):
    """Note the depth [m] of a contact, and, at its release, that it has ended."""
    # hot: once per impact
    if impacts is not None:
        note_force(impacts, wall, depth)
        if event == RELEASED:
            note_release(ps, damper, impacts, time, x1, v1, r, s)


@jit
def at_section(damper, section, row, x1, v1, r, s):
    """Note a section point, if there is room for it."""
    if section is not None and row < len(section):
        note_section(damper, section, row, x1, v1, r, s)


@jit
def orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance `state` (SIZE,) over a `Span` and note what has a buffer; return a status.

    prepared: a `Prepared` cell with walls; span.stops must divide the cells of its grid. buffers:
    `OrbitBuffers`. tangent: (16,) four variations one after the other, or None; `exact_grid`, that
    of the exact flight, propagates them whatever the method.
    """
    # Named once: a field with arrays costs reference counts each time that it is read.
    rk4, ps, damper, grid = prepared.rk4, prepared.ps, prepared.damper, prepared.grid
    near, far, arc = prepared.near, prepared.far, prepared.arc
    steps, k, stuck = prepared.contact_steps, prepared.scratch, prepared.stuck
    limit_log, energy, clearance = buffers.limit_log, buffers.energy, buffers.clearance
    slowest = buffers.slowest
    impacts, by_period, section = buffers.impacts, buffers.by_period, buffers.section
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
    for i in range(SIZE - AHEAD):
        k[rk.AHEAD + i] = state[AHEAD + i]
    for p in range(span.periods):
        j, x, touches = 0, 0.0, 0
        began = (span.first + p) * (grid.h * grid.n)
        for i in range(span.stops):
            stop = grid.n * (i + 1) // span.stops
            while True:
                if mode == FLYING:
                    # Fly to the next event.
                    place = j + x
                    begin_flight(limit_log, began)
                    event, j, x, x1, v1, r, s = fly_on(
                        rk4, ps, damper, near, far, limit_log, energy, clearance,
                        grid, stop, j, x, x1, v1, r, s,
                    )  # fmt: skip
                    if tangent is not None:
                        propagate(exact_grid, tangent, (j + x - place) * grid.h)
                    if event == SECTION:
                        break
                    if event == ASTRAY:
                        return STEP_BUDGET
                    # Note the touch.
                    mode, q, touches = event, 0.0, touches + 1
                    time = began + (j + x) * grid.h
                    at_touch(ps, damper, by_period, impacts, p, mode, time, x1, v1, r, s)
                    keep_slowest(slowest, s)
                    if touches > MOST_TOUCHES:
                        return STEP_BUDGET
                # Follow the contact, to its release or to the section.
                sign = 1.0 if mode == TOUCH_NEAR else -1.0
                wall = wall_of(near, far, mode)
                left = (stop - j - x) * grid.h
                begin_contact(limit_log, sign, wall, began + (j + x) * grid.h)
                event, q, s, x1, v1, took, depth = follow_by_law(
                    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent,
                    steps, grid.rate, phase_on(rk4, grid, j, x), left, (q, s, x1, v1), k,
                    stuck, (j + x) / grid.n,
                )  # fmt: skip
                r = sign * (wall.gap + q * q)
                x1, v1 = structure_at(damper, x1, v1, r, s)
                place = j + x + took / grid.h
                time = began + place * grid.h
                after_contact(ps, damper, impacts, event, wall, depth, time, x1, v1, r, s)
                if not bounded(x1, v1, r, s):
                    return DIVERGED
                if event == EXHAUSTED:
                    return STEP_BUDGET
                if event == STOPPED:
                    j, x = stop, 0.0
                    break
                # Fly on from the release.
                mode = FLYING
                if took > 0.0:
                    j = min(int(place), stop - 1)
                    x = place - j
            # Note the section.
            x1, v1 = structure_at(damper, x1, v1, r, s)
            at_section(joined(damper), section, p * span.stops + i, x1, v1, r, s)
        if not bounded(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
    for i in range(SIZE - AHEAD):
        state[AHEAD + i] = k[rk.AHEAD + i]
    return OK


@chosen
def maps_of(rk4, energy, ps, damper, grid, stops):
    """Return the map from stop to stop where nothing is noted in between, otherwise None."""
    if rk4 is None and energy is None:
        return lambda rk4, energy, ps, damper, grid, stops: coarse_map(ps, damper, grid, stops)
    return lambda rk4, energy, ps, damper, grid, stops: None


@jit
def step_share(rk4, ps, damper, energy, maps, grid, share, y):
    """Return the state after a share (i, stops) of a period from the state y, by `maps`."""
    return step(damper, maps, share[0], y[0], y[1], y[2], y[3])


@jit
def fly_share(rk4, ps, damper, energy, maps, grid, share, y):
    """Return the same as `step_share`, cell by cell."""
    i, stops = share
    first, stop = grid.n * i // stops, grid.n * (i + 1) // stops
    return fly_on(
        rk4, ps, damper, None, None, None, energy, None, grid, stop, first, 0.0,
        y[0], y[1], y[2], y[3],
    )[3:]  # fmt: skip


@chosen
def share_of(rk4, ps, damper, energy, maps, grid, share, y):
    """Advance a scene without walls by a share of a period: by `maps` (`maps_of`) if there are."""
    return fly_share if maps is None else step_share


@jit
def linear_orbit(prepared, buffers, span, state, tangent, exact_grid):
    """Advance a scene without walls (arguments and result as those of `orbit`)."""
    rk4, ps, damper, grid = prepared.rk4, prepared.ps, prepared.damper, prepared.grid
    section, energy, stops = buffers.section, buffers.energy, span.stops
    y = state[0], state[1], state[2], state[3]
    maps = maps_of(rk4, energy, ps, damper, grid, stops)
    for p in range(span.periods):
        for i in range(stops):
            y = share_of(rk4, ps, damper, energy, maps, grid, (i, stops), y)
            at_section(damper, section, p * stops + i, y[0], y[1], y[2], y[3])
        if tangent is not None:
            propagate(exact_grid, tangent, grid.h * grid.n)
        if not bounded(y[0], y[1], y[2], y[3]):
            return DIVERGED
    state[0], state[1], state[2], state[3] = y
    return OK


@chosen
def orbit_of(near, far):
    """Return the time loop of a scene with walls, or of one without: neither knows of the other."""
    if near is None and far is None:
        return lambda near, far: linear_orbit
    return lambda near, far: orbit
