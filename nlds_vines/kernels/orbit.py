"""The one time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it; it is never summed up, so that the phase of
the section is as sharp after a million periods as after one.
"""

from __future__ import annotations

import math

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
from .compiling import chosen, jit
from .contact import contact
from .exact import fly
from .fixed_step import fly_fixed
from .flight import coarse_map, phase_at, propagate, step
from .impact import short_impact
from .impact_variations import vary
from .limit import begin_contact, may_pass
from .observe import (
    ORIGIN,
    energies,
    note_depth,
    note_release,
    note_section,
    note_speed,
    note_touch,
    powers_at,
)

HUGE = 1.0e150  # beyond any state of a damped system; NaN is caught by the same comparison
MOST_TOUCHES = 100_000  # touches in one period: beyond it the status is STEP_BUDGET
SIZE = 6  # numbers of the state kept between calls: x1, v1, r, s, q = sqrt(z), mode


@jit
def set_mode(near, far, state):
    """Set q and the mode of a state (x1, v1, r, s) at phase zero: in flight, or inside a contact.

    A start on the wall that moves or is pressed into it is a touch of the first instant, which the
    first flight finds; a start beyond the wall is a contact already under way.
    """
    state[4], state[5] = 0.0, FLYING
    if near is not None and state[2] > near.gap:
        state[4], state[5] = math.sqrt(state[2] - near.gap), TOUCH_NEAR
    if far is not None and -state[2] > far.gap:
        state[4], state[5] = math.sqrt(-state[2] - far.gap), TOUCH_FAR


@chosen
def fly_on(
    rk4, ps, damper, near, far, limit_log, energy, clearance, grid, stop, j, x, x1, v1, r, s
):
    """Fly to the next event by the method."""
    # hot: the arguments of `fly`
    return fly if rk4 is None else fly_fixed


@jit
def may_hide_a_peak(ps, damper, wall, energy, c, d, before, after, duration):
    """Tell whether an energy could peak inside a short impact above the largest so far.

    The contact force alone can only make an energy dip between touch and release; a rise above the
    ends is due to the other forces, bounded here by twice their largest power at the two ends.
    """
    # hot: once per impact
    for body in range(2):
        top = 0.0
        gain = 0.0
        for y in (before, after):
            v1, n1, v2, n2 = powers_at(ps, damper, y[0], y[1], wall.gap, y[2], c, 0.0)
            e = energies(ps, damper, y[0], y[1], wall.gap, y[2])
            top = max(top, e[body])
            gain = max(gain, abs(v1 * n1) if body == 0 else abs(v2 * n2))
        if top + 2.0 * gain * duration > energy[body]:
            return True
    return False


@jit
def hides(ps, damper, wall, sign, limit_log, energy, c, d, before, after, took):
    """Tell whether a short impact may hide a peak of an energy, or a passage of a limit."""
    # hot: once per impact
    found = False
    if energy is not None:
        found = may_hide_a_peak(ps, damper, wall, energy, c, d, before, after, took)
    if limit_log is not None:
        x1, v1, s = before
        found = found or may_pass(ps, damper, wall, sign, limit_log, took, x1, v1, s)
    return found


@chosen
def note_hidden(
    rk4, ps, damper, wall, sign, limit_log, energy, steps, rate, c, d, left, q, s, x1, v1, k
):
    """Step a short impact, for what is noted of it; without an energy or a limit, nothing is."""

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
def try_short_impact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, q, s, x1, v1, k,
):  # fmt: skip
    """Try the short impact; it is accepted if it ends in time.

    Where it may hide a peak of an energy, or a passage of a limit, it is stepped as well, for these
    alone: nothing that is noted changes the orbit. Neither do variations, which go through it last.
    """
    # hot: once per impact
    solved, out, a1, b1, took, depth = short_impact(
        ps, damper, wall, arc, impacts, rate, c, d, q, s, x1, v1
    )
    solved = solved and took <= left
    if solved and hides(
        ps, damper, wall, sign, limit_log, energy, c, d, (x1, v1, s), (a1, b1, out), took
    ):
        note_hidden(
            rk4, ps, damper, wall, sign, limit_log, energy, steps, rate, c, d, left, q, s, x1, v1, k
        )
    if solved and tangent is not None:
        vary(ps, damper, wall, arc, rate, (c, d), (s, x1, v1), (out, a1, b1, took), tangent)
    return solved, out, a1, b1, took, depth


@jit
def no_short_impact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, q, s, x1, v1, k,
):  # fmt: skip
    """Return as `try_short_impact` that it is not solved."""
    # hot: once per impact
    return False, s, x1, v1, 0.0, 0.0


@chosen
def short_impact_if_exact(
    rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
    left, q, s, x1, v1, k,
):  # fmt: skip
    """Return `try_short_impact`; by rk4 every contact is stepped."""
    # hot: once per impact
    return try_short_impact if rk4 is None else no_short_impact


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
    phase, left, now, k,
):  # fmt: skip
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    `phase`: (cos, sin) of the forcing's; the rest as for `contact`. For a wall that pushes towards
    -x2 (`sign` -1) the motion is mirrored on the way in and out. Returns (event, q, s, x1, v1,
    elapsed, depth) as `contact`.
    """
    # hot: once per impact, in the loop of `orbit`, where `Prepared` as one argument costs 3 %
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    c, d = sign * phase[0], sign * phase[1]
    solved, out, a1, b1, took, depth = short_impact_if_exact(
        rk4, tangent, ps, damper, wall, sign, arc, limit_log, energy, impacts, steps, rate, c, d,
        left, q, s, x1, v1, k,
    )  # fmt: skip
    if solved:
        return RELEASED, 0.0, sign * out, sign * a1, sign * b1, took, depth
    event, q, s, x1, v1, took, depth = contact(
        rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate, c, d,
        q, s, x1, v1, left, k,
    )  # fmt: skip
    return event, q, sign * s, sign * x1, sign * v1, took, depth


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
def after_contact(ps, damper, impacts, event, stiffness, depth, time, x1, v1, r, s):
    """Note the depth [m] of a contact, and, at its release, that it has ended."""
    # hot: once per impact
    if impacts is not None:
        note_depth(impacts, stiffness, depth)
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
    steps, k = prepared.contact_steps, prepared.scratch
    limit_log, energy, clearance = buffers.limit_log, buffers.energy, buffers.clearance
    slowest = buffers.slowest
    impacts, by_period, section = buffers.impacts, buffers.by_period, buffers.section
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
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
                    note_speed(slowest, s)
                    if touches > MOST_TOUCHES:
                        return STEP_BUDGET
                # Follow the contact, to its release or to the section.
                sign = 1.0 if mode == TOUCH_NEAR else -1.0
                wall = wall_of(near, far, mode)
                left = (stop - j - x) * grid.h
                begin_contact(limit_log, sign, wall, began + (j + x) * grid.h)
                event, q, s, x1, v1, took, depth = follow_contact(
                    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent,
                    steps, grid.rate, phase_at(grid, j, x), left, (q, s, x1, v1), k,
                )  # fmt: skip
                r = sign * (wall.gap + q * q)
                place = j + x + took / grid.h
                time = began + place * grid.h
                after_contact(ps, damper, impacts, event, wall.K, depth, time, x1, v1, r, s)
                if not bounded(x1, v1, r, s):
                    return DIVERGED
                if event == EXHAUSTED:
                    return STEP_BUDGET
                if event == STOPPED:
                    j, x = stop, 0.0
                    break
                # Fly on from the release.
                mode, j = FLYING, min(int(place), stop - 1)
                x = place - j
            # Note the section.
            at_section(damper, section, p * span.stops + i, x1, v1, r, s)
        if not bounded(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
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
