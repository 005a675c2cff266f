"""The one time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it; it is never summed up, so that the phase of
the section is as sharp after a million periods as after one.
"""

from __future__ import annotations

import math

from .._jit import chosen, jit
from .contact import EXHAUSTED, RELEASED, STOPPED, contact
from .exact import ASTRAY, SECTION, TOUCH_NEAR, fly
from .fixed_step import fly_fixed
from .flight import period_map, phase_at, step
from .impact import short_impact
from .observe import (
    energies,
    note_depth,
    note_energy,
    note_release,
    note_section,
    note_touch,
    powers_at,
)

OK, DIVERGED, BUDGET = 0, 2, 3  # `nlds_vines.record.STATUS` has the words
HUGE = 1.0e150  # beyond any state of a damped system; NaN is caught by the same comparison
MOST_TOUCHES = 100_000  # in one period
FLYING = 0  # mode of an orbit; otherwise the event of the touch that began its contact
SIZE = 6  # of the state kept between calls: x1, v1, r, s, q = sqrt(z), mode


@jit
def begin(near, far, state):
    """Settle the mode of a state (x1, v1, r, s) at phase zero: in flight, or inside a contact.

    A start on the wall that moves or is pressed into it is a touch of the first instant, which the
    first flight finds; a start beyond the wall is a contact already under way.
    """
    state[4], state[5] = 0.0, FLYING
    if near is not None and state[2] > near.gap:
        state[4], state[5] = math.sqrt(state[2] - near.gap), TOUCH_NEAR
    if far is not None and -state[2] > far.gap:
        state[4], state[5] = math.sqrt(-state[2] - far.gap), TOUCH_NEAR + 1


@chosen
def fly_on(classical, ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s):
    """Fly to the next event by the method asked for."""

    def exact(classical, ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s):
        return fly(ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s)

    def fixed(classical, ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s):
        return fly_fixed(ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s)

    return exact if classical is None else fixed


@jit
def outshines(ps, damper, wall, energy, c, d, before, after, duration):
    """Tell whether an energy could peak inside a short impact above what was seen.

    The contact force alone can only make an energy dip between touch and release; whatever rises
    above the ends is due to the other forces, bounded here twice over.
    """
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
def bump(ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
    """Try the short impact; it stands if it ends in time and hides no peak of an energy."""
    solved, out, a1, b1, took, depth = short_impact(ps, damper, wall, arc, rate, c, d, q, s, x1, v1)
    solved = solved and took <= left
    if energy is not None and solved:
        before, after = (x1, v1, s), (a1, b1, out)
        solved = not outshines(ps, damper, wall, energy, c, d, before, after, took)
    return solved, out, a1, b1, took, depth


@chosen
def shortcut(classical, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
    """Return `bump`, or that there is none where every contact is stepped."""

    def exact(classical, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
        return bump(ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1)

    def fixed(classical, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
        return False, s, x1, v1, 0.0, 0.0

    return exact if classical is None else fixed


@jit
def meet(classical, ps, damper, wall, sign, arc, energy, depths, steps, rate, c, d, left, now, k):
    """Follow a contact from `now` = (q, s, x1, v1) to release or for the time `left`.

    For a wall that pushes towards -x2 (sign -1) everything is mirrored on the way in and out.
    Returns (event, q, s, x1, v1, elapsed, depth) as `contact`.
    """
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    c, d = sign * c, sign * d
    solved, out, a1, b1, took, depth = shortcut(
        classical, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1
    )
    if solved:
        return RELEASED, 0.0, sign * out, sign * a1, sign * b1, took, depth
    event, q, s, x1, v1, took, depth = contact(
        classical, ps, damper, wall, energy, depths, steps, rate, c, d, q, s, x1, v1, left, k
    )
    return event, q, sign * s, sign * x1, sign * v1, took, depth


@chosen
def wall_of(near, far, mode):
    """Return the wall that is being touched."""
    if far is None:
        return lambda near, far, mode: near
    if near is None:
        return lambda near, far, mode: far
    return lambda near, far, mode: near if mode == TOUCH_NEAR else far


@jit
def sane(x1, v1, r, s):
    """Tell whether a state is finite and not absurdly large."""
    return abs(x1) + abs(v1) + abs(r) + abs(s) < HUGE


@jit
def orbit(
    classical,
    ps,
    damper,
    near,
    far,
    arc,
    section,
    beats,
    rows,
    energy,
    clearance,
    grid,
    steps,
    state,
    k,
    first,
    periods,
):
    """Advance `state` by `periods` forcing periods and note what has a buffer.

    `classical` None is the exact method, otherwise fixed steps; `section` (periods, components),
    `beats` (periods, 2) impacts per period and wall; `first` is the number of the first period,
    for the times in `rows`. Returns a status: OK, DIVERGED or BUDGET.
    """
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
    for p in range(periods):
        j, x, count = 0, 0.0, 0
        while True:
            if mode == FLYING:
                event, j, x, x1, v1, r, s = fly_on(
                    classical, ps, damper, near, far, energy, clearance, grid, j, x, x1, v1, r, s
                )
                if event == SECTION:
                    break
                if event == ASTRAY:
                    return BUDGET
                mode, q, count = event, 0.0, count + 1
                if beats is not None:
                    beats[p, mode - TOUCH_NEAR] += 1
                if rows is not None:
                    time = (first + p) * (grid.h * grid.n) + (j + x) * grid.h
                    note_touch(rows, mode - TOUCH_NEAR, time, abs(s))
                if count > MOST_TOUCHES:
                    return BUDGET
            sign = 1.0 if mode == TOUCH_NEAR else -1.0
            wall = wall_of(near, far, mode)
            c, d = phase_at(ps, grid, j, x)
            left = (grid.n - j - x) * grid.h
            event, q, s, x1, v1, took, depth = meet(
                classical,
                ps,
                damper,
                wall,
                sign,
                arc,
                energy,
                rows,
                steps,
                grid.rate,
                c,
                d,
                left,
                (q, s, x1, v1),
                k,
            )
            r = sign * (wall.gap + q * q)
            if energy is not None:
                note_energy(ps, damper, energy, x1, v1, r, s)
            if rows is not None:
                note_depth(rows, wall.K, depth)
            if not sane(x1, v1, r, s):
                return DIVERGED
            if event == EXHAUSTED:
                return BUDGET
            if event == STOPPED:
                break
            place = j + x + took / grid.h
            mode, j = FLYING, min(int(place), grid.n - 1)
            x = place - j
            if rows is not None:
                note_release(rows, (first + p) * (grid.h * grid.n) + place * grid.h)
        if section is not None:
            note_section(damper, section, p, x1, v1, r, s)
        if not sane(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
    return OK


@chosen
def maps_of(classical, energy, ps, damper, grid):
    """Return the map of a whole period where nobody looks inside it, otherwise nothing."""
    if classical is None and energy is None:
        return lambda classical, energy, ps, damper, grid: period_map(ps, damper, grid)
    return lambda classical, energy, ps, damper, grid: None


@chosen
def fly_period(classical, ps, damper, energy, maps, grid, x1, v1, r, s):
    """Advance a scene without walls by one period: by its map where nobody looks inside."""

    def mapped(classical, ps, damper, energy, maps, grid, x1, v1, r, s):
        return step(damper, maps, 0, x1, v1, r, s)

    def flown(classical, ps, damper, energy, maps, grid, x1, v1, r, s):
        return fly_on(classical, ps, damper, None, None, energy, None, grid, 0, 0.0, x1, v1, r, s)[
            3:
        ]

    return flown if maps is None else mapped


@jit
def linear_orbit(classical, ps, damper, section, energy, grid, state, periods):
    """Advance a scene without walls (arguments and result as those of `orbit`)."""
    x1, v1, r, s = state[0], state[1], state[2], state[3]
    maps = maps_of(classical, energy, ps, damper, grid)
    for p in range(periods):
        x1, v1, r, s = fly_period(classical, ps, damper, energy, maps, grid, x1, v1, r, s)
        if section is not None:
            note_section(damper, section, p, x1, v1, r, s)
        if not sane(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3] = x1, v1, r, s
    return OK
