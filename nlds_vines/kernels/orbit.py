"""The one time loop: flights, contacts and sections of one orbit, period by period.

Time is an integer period, a cell and a place in it; it is never summed up, so that the phase of
the section is as sharp after a million periods as after one.
"""

from __future__ import annotations

import math

from .compiling import chosen, jit
from .contact import EXHAUSTED, RELEASED, STOPPED, contact
from .exact import ASTRAY, SECTION, TOUCH_NEAR, fly
from .fixed_step import fly_fixed
from .flight import carry, coarse_map, phase_at, step
from .impact import short_impact
from .observe import (
    PERIOD,
    energies,
    note_depth,
    note_energy,
    note_release,
    note_section,
    note_touch,
    powers_at,
)

OK, DIVERGED, BUDGET = 0, 2, 3  # `orbits.status_words` has the words
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
def fly_on(
    classical, ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s
):
    """Fly to the next event by the method asked for."""

    def exact(
        classical, ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s
    ):
        return fly(ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s)

    def fixed(
        classical, ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s
    ):
        return fly_fixed(
            ps, damper, near, far, watch, energy, clearance, grid, stop, j, x, x1, v1, r, s
        )

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
def shortcut(classical, tangent, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
    """Return `bump`, or that there is none where every contact is stepped."""

    def solved(classical, tangent, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
        return bump(ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1)

    def stepped(classical, tangent, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1):
        return False, s, x1, v1, 0.0, 0.0

    return solved if classical is None and tangent is None else stepped


@jit(dissolved=True)
def meet(
    classical, ps, damper, wall, sign, arc, energy, depths, tangent, steps, rate, c, d, left, now, k
):
    """Follow a contact from `now` = (q, s, x1, v1) to release or for the time `left`.

    For a wall that pushes towards -x2 (sign -1) everything is mirrored on the way in and out.
    Returns (event, q, s, x1, v1, elapsed, depth) as `contact`.
    """
    q, s, x1, v1 = now[0], sign * now[1], sign * now[2], sign * now[3]
    c, d = sign * c, sign * d
    solved, out, a1, b1, took, depth = shortcut(
        classical, tangent, ps, damper, wall, arc, energy, rate, c, d, left, q, s, x1, v1
    )
    if solved:
        return RELEASED, 0.0, sign * out, sign * a1, sign * b1, took, depth
    event, q, s, x1, v1, took, depth = contact(
        classical, ps, damper, wall, energy, depths, tangent,
        steps, rate, c, d, q, s, x1, v1, left, k,
    )  # fmt: skip
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
    watch,
    section,
    beats,
    rows,
    energy,
    clearance,
    tangent,
    jets,
    grid,
    stops,
    steps,
    state,
    k,
    first,
    periods,
):
    """Advance `state` by `periods` forcing periods and note what has a buffer.

    `classical` None is the exact method, otherwise fixed steps; `section` (stops periods,
    components) holds `stops` equidistant states of each period, the last at its end, and grid.n
    must be a multiple of that; `beats` (periods, 2) impacts per period and wall; `tangent` (16,)
    four tangent vectors one after the other, which the exact grid `jets` helps to carry; `first` is
    the number of the first period, for times. Returns a status: OK, DIVERGED or BUDGET.
    """
    x1, v1, r, s, q, mode = state[0], state[1], state[2], state[3], state[4], int(state[5])
    for p in range(periods):
        j, x, count = 0, 0.0, 0
        began = (first + p) * (grid.h * grid.n)
        if watch is not None:
            watch[PERIOD] = began
        for i in range(stops):
            stop = grid.n * (i + 1) // stops
            while True:
                if mode == FLYING:
                    place = j + x
                    event, j, x, x1, v1, r, s = fly_on(
                        classical, ps, damper, near, far, watch, energy, clearance,
                        grid, stop, j, x, x1, v1, r, s,
                    )  # fmt: skip
                    if tangent is not None:
                        carry(jets, tangent, (j + x - place) * grid.h)
                    if event == SECTION:
                        break
                    if event == ASTRAY:
                        return BUDGET
                    mode, q, count = event, 0.0, count + 1
                    if beats is not None:
                        beats[p, mode - TOUCH_NEAR] += 1
                    if rows is not None:
                        time = began + (j + x) * grid.h
                        note_touch(ps, damper, rows, mode - TOUCH_NEAR, time, x1, v1, r, s)
                    if count > MOST_TOUCHES:
                        return BUDGET
                sign = 1.0 if mode == TOUCH_NEAR else -1.0
                wall = wall_of(near, far, mode)
                c, d = phase_at(ps, grid, j, x)
                left = (stop - j - x) * grid.h
                event, q, s, x1, v1, took, depth = meet(
                    classical, ps, damper, wall, sign, arc, energy, rows, tangent,
                    steps, grid.rate, c, d, left, (q, s, x1, v1), k,
                )  # fmt: skip
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
                    j, x = stop, 0.0
                    break
                place = j + x + took / grid.h
                mode, j = FLYING, min(int(place), stop - 1)
                x = place - j
                if rows is not None:
                    note_release(ps, damper, rows, began + place * grid.h, x1, v1, r, s)
            if section is not None and p * stops + i < len(section):
                note_section(damper, section, p * stops + i, x1, v1, r, s)
        if not sane(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3], state[4], state[5] = x1, v1, r, s, q, mode
    return OK


@chosen
def maps_of(classical, energy, ps, damper, grid, stops):
    """Return the map from stop to stop where nobody looks in between, otherwise nothing."""
    if classical is None and energy is None:
        return lambda classical, energy, ps, damper, grid, stops: coarse_map(
            ps, damper, grid, stops
        )
    return lambda classical, energy, ps, damper, grid, stops: None


@chosen
def fly_share(classical, ps, damper, energy, maps, grid, stops, i, x1, v1, r, s):
    """Advance a scene without walls by share i of a period: by its map if nobody looks inside."""

    def mapped(classical, ps, damper, energy, maps, grid, stops, i, x1, v1, r, s):
        return step(damper, maps, i, x1, v1, r, s)

    def flown(classical, ps, damper, energy, maps, grid, stops, i, x1, v1, r, s):
        first, stop = grid.n * i // stops, grid.n * (i + 1) // stops
        return fly_on(
            classical, ps, damper, None, None, None, energy, None, grid, stop, first, 0.0,
            x1, v1, r, s,
        )[3:]  # fmt: skip

    return flown if maps is None else mapped


@jit
def linear_orbit(
    classical, ps, damper, section, energy, tangent, jets, grid, stops, state, periods
):
    """Advance a scene without walls (arguments and result as those of `orbit`)."""
    x1, v1, r, s = state[0], state[1], state[2], state[3]
    maps = maps_of(classical, energy, ps, damper, grid, stops)
    for p in range(periods):
        for i in range(stops):
            x1, v1, r, s = fly_share(
                classical, ps, damper, energy, maps, grid, stops, i, x1, v1, r, s
            )
            if section is not None and p * stops + i < len(section):
                note_section(damper, section, p * stops + i, x1, v1, r, s)
        if tangent is not None:
            carry(jets, tangent, grid.h * grid.n)
        if not sane(x1, v1, r, s):
            return DIVERGED
    state[0], state[1], state[2], state[3] = x1, v1, r, s
    return OK
