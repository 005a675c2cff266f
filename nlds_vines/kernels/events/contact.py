"""One contact from touch to release, stepped: any depth, any duration, any external force.

Each step is a Taylor polynomial (`taylor`), taken as far as its last terms allow, and never
farther than some part of a free impact of the motion at hand, so that soft rubber, steel, a slow
pressed touch and a damper resting on its obstacle for many periods are covered alike.

Then it is verified: what it misses of the equation of motion at its end is, in parts of the scales
of the motion at hand, its doubt. Doubt is granted in proportion to the way through a free impact:
`tolerance` for the first one, less for each further oscillation of a damper that stays in contact,
whose errors add up. What a step leaves of its share, later ones may use. A step of which more is
doubted is taken less far along the same polynomial.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion.taylor import (
    advance,
    defect_of,
    expand,
    length_of,
    part_of,
    restore,
    save,
    to_release,
)
from ..numerics.compiling import jit
from ..numerics.elementary import exp, log
from ..numerics.roots import guarded, narrowed, secant
from ..scene.arguments import Step, side_with
from ..scene.codes import EXHAUSTED, RELEASED, STOPPED
from ..scene.contact_series import NEW, ORDER, ROW, Y
from ..scene.drive import after, drive_now
from ..scene.law import (
    acting,
    depth_of,
    faint,
    force_of,
    pressed,
    rate_of_switching,
    reach_of,
    rise_of,
    root_of,
    switching,
    turn_of,
    weight_of,
)
from ..scene.scene import accelerations
from ..watch.limit import note_limit_step
from ..watch.observe import note_force, note_step
from ..watch.response_steps import add_row, tally_step
from .contact_variations import begin_along, ride, vary_on

MOST_STEPS = 1_000_000  # steps of one contact between two sections: beyond it, EXHAUSTED
MOST_ATTEMPTS = 60  # of a step that leaves the contact; numbers beyond all bounds need more
MOST_REPEATS = 20  # of a step that is doubted: what is doubted of a smaller one is round-off
LEAST = 1.0e-14  # of a tolerance: below it is round-off
LONG = 1.0  # free impacts after which a contact is granted half as much doubt for each further one
MOST_TURNS = 60  # of a search in a step: some five find a deepest point, some thirty a switch
NEAR_TURN = 1.0e-6  # error of the place of a turn in a step
DEEPEST = 1.0e-10  # part of the depth that a parabola may add to it, which errs by its power 3/2
NEAR_SWITCH = 1.0e-13  # error of the place of a switch in a step, where largest values have corners
SLIGHT = 1.0e-14  # of `switching`: it has not changed its sign
ROUND_OFF = 1.0e-15  # doubt of a step that means nothing
FAINT = 1.0e-16  # Hertz acceleration, as a share of the external one, that is round-off
SOON = 1.0e-7  # time in units of 1/rate for which an external acceleration is constant


class Steps(NamedTuple):
    """How finely a contact is stepped."""

    per_impact: float  # least steps of a free impact
    tolerance: float  # relative error of a contact; infinite: steps are as they are


@jit
def start_at_rest(side, watch, phase):
    """Move row Y past a touch without speed, which theta alone could not leave; return the time.

    Under an external acceleration a the depth grows as a t^2 / 2; until the Hertz force or a change
    of a is felt at round-off, that is exact. phase: the instant (`drive`).
    """
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q, s, x1, v1 = k[Y], k[Y + 1], k[Y + 2], k[Y + 3]
    z, c = depth_of(wall, q), drive_now(phase)
    dv, external = accelerations(ps, damper, x1, v1, wall.gap + z, s, c, 0.0)
    if external <= 0.0 or s < 0.0:
        return 0.0
    depth = faint(wall, FAINT * external / wall.kappa)
    soon = SOON / side.rate
    depth = min(depth, 0.5 * external * soon * soon)
    if z + 0.5 * s * s / external >= depth:
        return 0.0
    speed = math.sqrt(2.0 * external * depth)
    t = (speed - s) / external
    k[Y], k[Y + 1] = root_of(wall, depth), speed
    k[Y + 2], k[Y + 3] = x1 + t * (v1 + 0.5 * t * dv), v1 + t * dv
    if watch.tangent is not None:
        vary_on(side, watch.tangent, (x1, v1, wall.gap + z, s), c, t)
    if watch.tally is not None:
        add_row(side, watch.tally, phase, int(Y), t)
    return t


@jit
def step_to_stop(side, step, left):
    """Write row NEW at the instant `left` after row Y, within a step; return the step to it."""
    k, h = side.k, step.h
    low, high, size = 0.0, h, h
    for _ in range(80):
        advance(side, None, Step(step.phase, False, size))
        miss = left - k[NEW + 4]
        if abs(miss) <= 1.0e-16 * left or high - low <= 1.0e-16 * h:
            break
        if miss > 0.0:
            low = size
        else:
            high = size
        q = k[NEW]
        guess = size + miss / weight_of(side.wall, q) if q > 0.0 else low
        size = guarded(guess, low, high)
    return size


@jit
def motion_at(side, phase, row):
    """Return (z, dt/dtheta, ds/dt) of a row within a step, phase being that at row Y."""
    wall, k = side.wall, side.k
    q, s = k[row], k[row + 1]
    z = depth_of(wall, q)
    drive, force = drive_now(after(side.ps, phase, k[row + 4])), force_of(wall, q, z, s)
    _, ds = accelerations(
        side.ps, side.damper, k[row + 2], k[row + 3], wall.gap + z, s, drive, force
    )
    return z, weight_of(wall, q), ds


@jit
def deepest(side, step):
    """Return the greatest depth [m] within a step over which s changes sign from + to -.

    Where s vanishes but for an error e it is greater by a parabola, and but for e^3. Row NEW is
    lost.
    """
    k = side.k
    low, high, found = 0.0, 1.0, 0.0
    x = k[Y + 1] / (k[Y + 1] - k[NEW + 1])
    for _ in range(MOST_TURNS):
        advance(side, None, part_of(step, x))
        z, weight, ds = motion_at(side, step.phase, int(NEW))
        s = k[NEW + 1]
        more = -0.5 * s * s / ds if ds < 0.0 else 0.0
        found = z + more
        if s == 0.0 or (ds < 0.0 and more <= DEEPEST * z):
            break
        if s > 0.0:
            low = x
        else:
            high = x
        x = guarded(x - s / (step.h * weight * ds) if ds < 0.0 else low, low, high)
    return found


@jit
def external_acceleration(side, c):
    """Return d2r/dt2 [m/s^2] of row Y without the Hertz force, at phase cosine c."""
    wall, k = side.wall, side.k
    r = wall.gap + depth_of(wall, k[Y])
    x1, v1, s = k[Y + 2], k[Y + 3], k[Y + 1]
    _, ds = accelerations(side.ps, side.damper, x1, v1, r, s, c, 0.0)
    return ds


@jit
def up_to_turn(side, step):
    """Cut a step short where the contact is least deep, unless it is in contact there."""
    k = side.k
    part = part_of(step, -k[Y + 1] / (k[NEW + 1] - k[Y + 1]))
    for _ in range(MOST_TURNS):
        advance(side, None, part)
        if not k[NEW] > 0.0 or abs(k[NEW + 1]) <= NEAR_TURN * abs(k[Y + 1]):
            break
        _, _, ds = motion_at(side, step.phase, int(NEW))
        change = k[NEW + 1] / (ds * weight_of(side.wall, k[NEW]))
        if not 0.0 < part.h - change < step.h:
            break
        part = Step(step.phase, False, part.h - change)
    if not k[NEW] > 0.0:
        return part
    advance(side, None, step)
    return step


@jit
def to_end(side, phase, left, h):
    """Step from row Y to row NEW, which need not lie in the contact; return (step, stopped).

    By h, or to the release (the `Step` is landing, then), or to the instant `left` if that comes
    first (`stopped`).
    """
    k = side.k
    step = Step(phase, False, h)
    advance(side, None, step)
    if k[NEW] > 0.0 and k[Y + 1] < 0.0 and k[NEW + 1] > 0.0:  # back by now: was it out?
        step = up_to_turn(side, step)
    if not k[NEW] > 0.0 and k[Y] > 0.0 and k[NEW + 1] <= 0.0:
        step = to_release(side, step)
    if (step.landing or k[NEW] > 0.0) and k[NEW + 4] > left:
        return Step(phase, False, step_to_stop(side, step, left)), True
    return step, False


@jit
def shrunk_by(doubt, share):
    """Return by how much a step is shrunk of which more is doubted than its share."""
    return max(0.3, 0.9 * exp(log(share / doubt) / ORDER))


@jit
def is_positive(wall, q, s):
    """Tell on which side of its switch a wall acts, if it has one."""
    if wall.switch is None:
        return True
    return switching(wall, depth_of(wall, q), s) > 0.0


@jit
def margin(side, positive, row):
    """Return `switching` at a row, or minus it where it has not been positive: negative behind."""
    q, s = side.k[row], side.k[row + 1]
    found = switching(side.wall, depth_of(side.wall, q), s)
    return found if positive else -found


@jit
def up_to_switch(side, now, positive, step):
    """Cut a step short where the force of a wall becomes another function; row NEW is there.

    positive: what `switching` is at row Y, and the wall of `now` takes for granted in all of the
    step. Returns (switches, step).
    """
    if side.wall.switch is None:
        return False, step
    low, high, f0 = 0.0, 1.0, max(margin(side, positive, int(Y)), 0.0)
    f1 = margin(side, positive, int(NEW))
    if not f1 < -SLIGHT:
        high, f1 = least_margin(side, now, positive, step)
        if not f1 < -SLIGHT:
            return False, step
    x = high
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        advance(now, None, part_of(step, x))
        f = margin(side, positive, int(NEW))
        if f == 0.0 or min(x - low, high - x) < NEAR_SWITCH:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    step = part_of(step, x)
    advance(now, None, step)
    return True, step


@jit
def swing(side, now, phase, row):
    """Return `rate_of_switching` at a row within a step, phase being that at row Y."""
    _, _, ds = motion_at(now, phase, row)
    return rate_of_switching(side.wall, side.k[row + 1], ds)


@jit
def least_margin(side, now, positive, step):
    """Return (place, `margin`) where that is least within a step, or (1, 0): row NEW is kept.

    Only where the margin may become negative by its rates at the ends, twice as large.
    """
    k = now.k
    f0, a = swing(side, now, step.phase, int(Y))
    f1, _ = swing(side, now, step.phase, int(NEW))
    way = 1.0 if positive else -1.0
    reach = 2.0 * a * max(abs(f0), abs(f1)) * k[NEW + 4]
    least = min(margin(side, positive, int(Y)), margin(side, positive, int(NEW)))
    if not (way * f0 < 0.0 and way * f1 > 0.0 and least < reach):
        return 1.0, 0.0
    save(k)
    low, high, x = 0.0, 1.0, 0.0
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        advance(now, None, part_of(step, x))
        f, _ = swing(side, now, step.phase, int(NEW))
        least = margin(side, positive, int(NEW))
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    restore(k)
    return x, least


@jit
def push_at(side, phase, row):
    """Return (F, its rate but for a positive factor) of a row within a step."""
    wall, k = side.wall, side.k
    q, s = k[row], k[row + 1]
    z, _, ds = motion_at(side, phase, row)
    return force_of(wall, q, z, s), rise_of(wall, q, z, s, ds)


@jit
def note_push(side, impacts, step):
    """Raise the greatest force to its maximum in the step from row Y to row NEW, which is kept.

    Of a damped contact: otherwise it is at the greatest depth. It is where the sign of
    its rate changes from + to -.
    """
    k = side.k
    low, high = 0.0, 1.0
    push, f0 = push_at(side, step.phase, int(Y))
    note_force(impacts, push)
    push, f1 = push_at(side, step.phase, int(NEW))
    note_force(impacts, push)
    if not (f0 > 0.0 and f1 < 0.0):
        return
    save(k)
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        advance(side, None, part_of(step, x))
        push, f = push_at(side, step.phase, int(NEW))
        note_force(impacts, push)
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    restore(k)


@jit
def noted(side, watch, step, elapsed, depth):
    """Note what is wanted of the step from row Y to row NEW; return the greatest depth so far [m].

    Energies are raised to their maxima over the step. `depth`, that of the steps before, is raised
    to the greatest depth within the step, if s changes sign there from + to -.
    """
    k = side.k
    if watch.limit_log is not None:
        note_limit_step(side, watch.limit_log, step, elapsed)
    if watch.energy is not None:
        note_step(side, watch.energy, step)
    if watch.tally is not None:
        tally_step(side, watch.tally, step)
    if watch.impacts is not None:
        if side.wall.damping is not None:
            note_push(side, watch.impacts, step)
        if k[Y + 1] > 0.0 and k[NEW + 1] <= 0.0:
            save(k)
            depth = max(depth, deepest(side, step))
            restore(k)
    return depth


@jit
def contact(side, watch, phase, now, stop):
    """Follow a contact from `now` = (q = sqrt(z), s, x1, v1) to its release or for `stop` [s].

    phase: (cos, sin) of the forcing's at the start; all is as the wall of the `Side` sees it.
    Returns (event, q, s, x1, v1, elapsed [s], depth [m]) with event RELEASED, STOPPED or EXHAUSTED
    (too many steps); the depth is that reached only if impacts are watched (`Watch`).
    """
    ps, wall, k, tangent, steps = side.ps, side.wall, side.k, watch.tangent, side.steps
    k[Y], k[Y + 1], k[Y + 2], k[Y + 3] = now
    k[Y + 4] = 0.0
    elapsed, depth, seen, cube, root = 0.0, 0.0, -1.0, 0.0, 0.0
    way, saved = 0.0, 0.0  # so far in free impacts; what is left of its shares of doubt
    positive = is_positive(wall, now[0], now[1])
    begin_along(tangent, k)
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(side, watch, phase)
            phase = after(ps, phase, elapsed)
        # The longest step: a part of the free impact of this depth and speed, as the external
        # acceleration and the rates of all other motion have it over the way that q can go.
        external = external_acceleration(side, drive_now(phase))
        q, s = k[Y], k[Y + 1]
        reach = reach_of(wall, q, depth_of(wall, q), s)  # of Hertz' law, q^2.5 where it turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers are dear: a new one if it has changed
            cube, root = turn_of(wall, reach)
            seen = reach
        span = min(root, 2.0 * max(q, root_of(wall, abs(s) / side.rate)))  # others may stop it
        swing = max(ps.omega, side.rate) * weight_of(wall, span)
        rate_squared = wall.kappa * cube + pressed(wall, external) + swing * swing
        per_theta = math.sqrt(rate_squared) / wall.whole  # free impacts
        late, h = 1.0 + way / LONG, 1.0 / (per_theta * steps.per_impact)
        # What the last terms of the polynomial allow of that.
        at = side_with(side, ps, side.damper, acting(wall, positive), steps)
        if side.rk4 is None or tangent is not None:
            expand(at, tangent, phase)
        fast, deep = max(wall.speed * seen, abs(s)), depth_of(wall, root)
        granted = max(steps.tolerance, LEAST) / late
        if steps.tolerance < math.inf:
            h = length_of(at, h, granted, fast)
        # Step to the release, to the end of the time or by h, until it ends inside the contact and
        # no more of it is doubted than is granted.
        step, stopped, inside, doubt, share = Step(phase, False, h), False, False, 0.0, 0.0
        end = phase
        for attempt in range(MOST_ATTEMPTS):
            step, stopped = to_end(at, phase, stop - elapsed, h)
            inside = step.landing or k[NEW] > 0.0
            if not inside:
                h *= 0.5
            elif steps.tolerance < math.inf:
                share = max(saved + steps.tolerance * (step.h * per_theta) / late, ROUND_OFF)
                end = after(ps, phase, k[NEW + 4])
                doubt = defect_of(at, drive_now(end), step.h, (fast, deep, root))
                if not doubt > share or attempt > MOST_REPEATS:
                    break
                h = step.h * shrunk_by(doubt, share)
            else:
                break
        if not inside:
            break
        way, saved = way + step.h * per_theta, max(share - doubt, 0.0)
        switches, step = up_to_switch(side, at, positive, step)
        # Note what the step has shown.
        depth = noted(at, watch, step, elapsed, depth)
        elapsed += k[NEW + 4]
        if tangent is not None:
            ride(at, tangent, step, granted, (fast, deep, root))
        # End here, or go on from row NEW.
        positive = positive != switches
        if step.landing and not switches:
            return RELEASED, 0.0, k[NEW + 1], k[NEW + 2], k[NEW + 3], elapsed, depth
        if stopped and not switches:
            q = k[NEW]
            depth = max(depth, depth_of(wall, q))
            return STOPPED, q, k[NEW + 1], k[NEW + 2], k[NEW + 3], elapsed, depth
        checked = steps.tolerance < math.inf and not switches
        phase = end if checked else after(ps, phase, k[NEW + 4])
        for i in range(ROW):
            k[Y + i] = k[NEW + i]
        k[Y + 4] = 0.0
    return EXHAUSTED, k[Y], k[Y + 1], k[Y + 2], k[Y + 3], elapsed, depth
