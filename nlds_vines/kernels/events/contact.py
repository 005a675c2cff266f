"""One contact from touch to release, stepped: any depth, any duration, any external force.

Each step is a Taylor polynomial (`taylor`), taken as far as its last terms allow, and never
farther than some part of a free impact of the motion at hand, so that soft rubber, steel, a slow
pressed touch and a damper resting on its obstacle for many periods are covered alike.

Then it is verified: what it misses of the equation of motion at its end is, in parts of the scales
of the motion at hand, its doubt. Doubt is granted in proportion to the way through a free impact:
`tolerance` for the first one, less for each further oscillation of a damper that stays in contact,
whose errors add up. What a step leaves of its share, later ones may use. A step of which more is
doubted is taken less far along the same polynomial.

A wall that pushes towards -x2 sees state, phase and load mirrored: eq. (5) is odd.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion.driven import constants_of, count_of, drive_start, rows_of
from ..motion.flight import FACTOR, ORDER
from ..motion.response_sums import absolute, add_from_foot, add_state, from_foot
from ..motion.taylor import (
    advance,
    defect_of,
    expand_contact,
    length_of,
    order_of,
    part_of,
    piece_of,
    restore,
    set_aside,
    to_release,
)
from ..numerics.compiling import jit
from ..numerics.elementary import exp, log, whole_power
from ..numerics.roots import guarded, narrowed, secant
from ..scene.by_law import by_wall
from ..scene.codes import EXHAUSTED, RELEASED, STOPPED
from ..scene.drive import after, drive_now, mirrored
from ..scene.law import (
    COLUMNS,
    FORCE,
    HIGHEST,
    NEW,
    OLD,
    ROW,
    SERIES,
    SHRUNK,
    UNIT,
    VARIED,
    VOLUME,
    WIDTH,
    acting,
    depth_of,
    faint,
    force_of,
    pressed,
    rate_of_q,
    rate_of_switching,
    reach_of,
    root_of,
    smooth_up_to,
    switching,
    turn_of,
    weight_of,
)
from ..scene.scene import Step, accelerations, mirrored_load, side_with
from ..watch.observe import note_force
from ..watch.response import (
    OfPush,
    bend_in,
    note_roots,
    push_now,
    tally_push,
    watch_piece,
)

# --------------------------------------------------------------------------------------------------
# Where a step of a contact ends, and what is found within it: all on the step's own polynomial.
#
# Its end is the release, an instant that is asked for, or the place where the force becomes another
# function (`law.switching`). Within it is the deepest point.


MOST_TURNS = 60  # of a search in a step: some five find a deepest point, some thirty a switch
NEAR_TURN = 1.0e-6  # error of the place of a turn in a step
DEEPEST = 1.0e-10  # part of the depth that a parabola may add to it, which errs by its power 3/2
NEAR_SWITCH = 1.0e-13  # error of the place of a switch in a step, where largest values have corners
SLIGHT = 1.0e-14  # of `switching`: it has not changed its sign


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
    low, high, depth = 0.0, 1.0, 0.0
    x = k[OLD + 1] / (k[OLD + 1] - k[NEW + 1])
    for _ in range(MOST_TURNS):
        advance(side, None, part_of(step, x))
        z, weight, ds = motion_at(side, step.phase, int(NEW))
        s = k[NEW + 1]
        rise = -0.5 * s * s / ds if ds < 0.0 else 0.0
        depth = z + rise
        if s == 0.0 or (ds < 0.0 and rise <= DEEPEST * z):
            break
        if s > 0.0:
            low = x
        else:
            high = x
        x = guarded(x - s / (step.h * weight * ds) if ds < 0.0 else low, low, high)
    return depth


@jit
def up_to_turn(side, step):
    """Cut a step short where the contact is least deep, unless it is in contact there."""
    k = side.k
    part = part_of(step, -k[OLD + 1] / (k[NEW + 1] - k[OLD + 1]))
    for _ in range(MOST_TURNS):
        advance(side, None, part)
        if not k[NEW] > 0.0 or abs(k[NEW + 1]) <= NEAR_TURN * abs(k[OLD + 1]):
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
    if k[NEW] > 0.0 and k[OLD + 1] < 0.0 and k[NEW + 1] > 0.0:  # back by now: was it out?
        step = up_to_turn(side, step)
    if not k[NEW] > 0.0 and k[OLD] > 0.0 and k[NEW + 1] <= 0.0:
        step = to_release(side, step)
    if (step.landing or k[NEW] > 0.0) and k[NEW + 4] > left:
        return Step(phase, False, step_to_stop(side, step, left)), True
    return step, False


@jit
def margin(side, positive, row):
    """Return `switching` at a row, or minus it where it has not been positive: negative behind."""
    q, s = side.k[row], side.k[row + 1]
    value = switching(side.wall, depth_of(side.wall, q), s)
    return value if positive else -value


@jit
def up_to_switch(side, now, positive, step):
    """Cut a step short where the force of a wall becomes another function; row NEW is there.

    positive: what `switching` is at row Y, and the wall of `now` takes for granted in all of the
    step. Returns (switches, step).
    """
    if side.wall.switch is None:
        return False, step
    low, high, f0 = 0.0, 1.0, max(margin(side, positive, int(OLD)), 0.0)
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
    f0, a = swing(side, now, step.phase, int(OLD))
    f1, _ = swing(side, now, step.phase, int(NEW))
    sense = 1.0 if positive else -1.0
    reach = 2.0 * a * max(abs(f0), abs(f1)) * k[NEW + 4]
    least = min(margin(side, positive, int(OLD)), margin(side, positive, int(NEW)))
    if not (sense * f0 < 0.0 and sense * f1 > 0.0 and least < reach):
        return 1.0, 0.0
    set_aside(k)
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


# --------------------------------------------------------------------------------------------------
# Variations along a contact that is stepped: they change nothing of the orbit that they go with.
#
# Their polynomials (`taylor`) have the radius of convergence of the orbit's, but not its last
# terms: near the touch a force K z^n does little to an orbit, and its stiffness n K z^(n - 1) much
# to variations. So they take the orbit's step in parts, where their own last terms ask for that,
# from states that its polynomial has in between; the orbit goes on from where it was.


MOST_PARTS = 100  # of a step; a few are needed where a force begins with a fractional power
MORE = 10.0  # what the last terms may be, in units of what an orbit is granted


@jit
def last_of_variations(k, row, pace):
    """Return the largest share that terms of a row of series are of a variation's own size."""
    most, first = 0.0, SERIES + VARIED
    for j in range(4):
        size = abs(k[first + 4 + j]) + abs(k[first + 12 + j])
        size += pace * (abs(k[first + j]) + abs(k[first + 8 + j]))
        last = max(abs(k[row + VARIED + 4 + j]), abs(k[row + VARIED + 12 + j]))
        if last > most * size and size > 0.0:
            most = last / size
    return most


@jit
def part_for(side, tangent, h, granted, pace):
    """Return how far variations may go along a polynomial, at most h; granted: to the orbit."""
    k, n, less, x = side.k, order_of(side.rk4), 0.0, h / side.k[UNIT]
    for m in range(n - 1, n + 1):
        last = last_of_variations(k, SERIES + COLUMNS * m, pace) * whole_power(x, m)
        if last > MORE * granted:
            less = min(less, log(MORE * granted / last) / m)
    return exp(less) * h


@jit
def ride(side, tangent, step, granted, scales):
    """Carry variations over the step from row Y to row NEW, of which the series stand in k.

    granted: of its last terms to an orbit, infinite where its steps are as they are; scales of
    speed, depth and q. Row Y and the series are lost.
    """
    k, wall, (fast, deep, root) = side.k, side.wall, scales
    left, phase = step.h, step.phase
    set_aside(k)
    for part in range(MOST_PARTS):
        h = left
        if granted < math.inf and part < MOST_PARTS - 1:
            h = part_for(side, tangent, h, granted, fast / deep)
            if k[OLD] == 0.0 and k[OLD + 1] > 0.0:
                far = smooth_up_to(wall, tangent, constants_of(side.sign), granted)
                h = min(h, root * far / rate_of_q(wall, k[OLD + 1]))
        last = not h < left
        advance(side, tangent, Step(phase, step.landing and last, h))
        k[SHRUNK] += k[NEW + VOLUME]
        for i in range(count_of(tangent)):
            rows_of(tangent)[i] = k[NEW + WIDTH + i]
        if last:
            break
        phase = after(side.ps, phase, k[NEW + 4])
        for i in range(ROW):
            k[OLD + i] = k[NEW + i]
        left -= h
        expand_contact(side, tangent, phase, left)
    restore(k)
    for i in range(count_of(tangent)):
        k[NEW + WIDTH + i] = rows_of(tangent)[i]


# ---- a contact from touch to release -------------------------------------------------------------


MOST_STEPS = 1_000_000  # steps of one contact between two sections: beyond it, EXHAUSTED
MOST_ATTEMPTS = 60  # of a step that leaves the contact; numbers beyond all bounds need more
MOST_REPEATS = 20  # of a step that is doubted: what is doubted of a smaller one is round-off
LEAST_GRANTED = 1.0e-14  # of a tolerance: below it is round-off
LONG = 1.0  # free impacts after which a contact is granted half as much doubt for each further one
LAST_TERMS = 0.25  # of a step, in units of what is granted: errors of contacts add up, with a sign
LEAST_DOUBT = 1.0e-15  # doubt of a step that means nothing
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
    q, s, x1, v1 = k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3]
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
    k[OLD], k[OLD + 1] = root_of(wall, depth), speed
    k[OLD + 2], k[OLD + 3] = x1 + t * (v1 + 0.5 * t * dv), v1 + t * dv
    if watch.tangent is not None:
        # The variations of row Y move on by the time t.
        for i in range(WIDTH + OLD, WIDTH + OLD + count_of(watch.tangent), 4):
            side.k[i] += t * side.k[i + 1]
            side.k[i + 2] += t * side.k[i + 3]
        drive_start(side, watch.tangent, (x1, v1, wall.gap + z, s), c, t, int(WIDTH + OLD))
    if watch.tally is not None:
        # The tally takes the time t, in which the state rests.
        y = (x1, v1, wall.gap + z, s)
        drive = drive_now(phase)
        add_state(watch.tally.row, t, y, absolute(watch.tally.ground, dv, drive), drive, phase)
        gone, rate = from_foot(watch.tally.foot, y[0], y[1], phase)
        add_from_foot(watch.tally.row, t, gone, rate)
    return t


@jit
def external_acceleration(side, c):
    """Return d2r/dt2 [m/s^2] of row Y without the Hertz force, at phase cosine c."""
    wall, k = side.wall, side.k
    r = wall.gap + depth_of(wall, k[OLD])
    x1, v1, s = k[OLD + 2], k[OLD + 3], k[OLD + 1]
    _, ds = accelerations(side.ps, side.damper, x1, v1, r, s, c, 0.0)
    return ds


@jit
def shrunk_by(doubt, share):
    """Return the factor that shortens a step whose doubt exceeds its share."""
    return max(0.3, 0.9 * exp(log(share / doubt) / HIGHEST))


@jit
def noted(side, watch, step, elapsed, depth):
    """Note what is wanted of the step from row Y to row NEW; return the greatest depth so far [m].

    `depth`, that of the steps before, is raised to the greatest depth within the step, if s changes
    sign there from + to -.
    """
    k, wall = side.k, side.wall
    if watch.energy is not None or watch.limit_log is not None or watch.tally is not None:
        piece = piece_of(side, step.h)
        watch_piece(side.ps, side.damper, watch, piece, step.phase, elapsed, 1.0)
        if watch.tally is not None:
            tally_push(wall, watch.tally, piece)
    if watch.impacts is not None:
        if wall.damping is not None:  # otherwise it is greatest where it is deepest
            # Raise the greatest force of the impact to that at the end of the step and to those
            # where the force turns; row NEW stays as it is.
            power, last = 1.0, order_of(side.rk4) - 1
            note_force(watch.impacts, push_now(side))
            for n in range(ORDER + 1):  # of the rate
                k[FACTOR + n] = 0.0
                if n < last:
                    k[FACTOR + n] = (n + 1.0) * power * k[SERIES + COLUMNS * (n + 1) + FORCE]
                power *= step.h / k[UNIT]
            note_roots(OfPush(watch.impacts, side, step), k, bend_in(k), 1.0)
        if k[OLD + 1] > 0.0 and k[NEW + 1] <= 0.0:
            set_aside(k)
            depth = max(depth, deepest(side, step))
            restore(k)
    return depth


@jit
def expand_if_asked(side, watch, phase, h):
    """Fill the series of steps (`expand_contact`) if the method or what watches asks for them.

    By rk4 that of energies, a limit, a response, variations, or a force under damping.
    """
    if (
        side.rk4 is not None
        and (watch.energy is None and watch.limit_log is None and watch.tally is None)
        and watch.tangent is None
        and (watch.impacts is None or side.wall.damping is None)
    ):
        return
    expand_contact(side, watch.tangent, phase, h)


@jit
def contact(side, watch, phase, now, stop):
    """Follow a contact from `now` = (q = sqrt(z), s, x1, v1) to its release or for `stop` [s].

    phase: (cos, sin) of the forcing's at the start; all is as the wall of the `Side` sees it.
    Returns (event, q, s, x1, v1, elapsed [s], depth [m]) with event RELEASED, STOPPED or EXHAUSTED
    (too many steps); the depth is that reached only if impacts are watched (`Watch`).
    """
    ps, wall, k, tangent, steps = side.ps, side.wall, side.k, watch.tangent, side.steps
    k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3] = now
    k[OLD + 4] = 0.0
    elapsed, depth, seen, cube, root = 0.0, 0.0, -1.0, 0.0, 0.0
    passed, saved = 0.0, 0.0  # so far in free impacts; what is left of its shares of doubt
    positive = (
        True if wall.switch is None else switching(wall, depth_of(wall, now[0]), now[1]) > 0.0
    )
    if tangent is not None:
        for i in range(count_of(tangent)):
            k[OLD + WIDTH + i] = rows_of(tangent)[i]
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(side, watch, phase)
            phase = after(ps, phase, elapsed)
        # The longest step: a part of the free impact of this depth and speed, as the external
        # acceleration and the rates of all other motion have it over the distance that q can go.
        external = external_acceleration(side, drive_now(phase))
        q, s = k[OLD], k[OLD + 1]
        reach = reach_of(wall, q, depth_of(wall, q), s)  # of Hertz' law, q^2.5 where it turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers are dear: a new one if it has changed
            if reach == 0.0 and external <= 0.0:  # no number is as small as what holds it
                return RELEASED, 0.0, s, k[OLD + 2], k[OLD + 3], elapsed, depth
            cube, root = turn_of(wall, reach)
            seen = reach
        span = min(root, 2.0 * max(q, root_of(wall, abs(s) / side.rate)))  # others may stop it
        swing = max(ps.omega, side.rate) * weight_of(wall, span)
        rate_squared = wall.kappa * cube + pressed(wall, external) + swing * swing
        per_theta = math.sqrt(rate_squared) / wall.whole  # free impacts
        late, h = 1.0 + passed / LONG, 1.0 / (per_theta * steps.per_impact)
        # What the last terms of the polynomial allow of that.
        at = side_with(side, ps, side.damper, acting(wall, positive), steps)
        expand_if_asked(at, watch, phase, h)
        fast, deep = max(wall.speed * seen, abs(s)), depth_of(wall, root)
        granted = max(steps.tolerance, LEAST_GRANTED) / late
        if steps.tolerance < math.inf:
            h = length_of(at, h, LAST_TERMS * granted, fast)
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
                share = max(saved + steps.tolerance * (step.h * per_theta) / late, LEAST_DOUBT)
                end = after(ps, phase, k[NEW + 4])
                doubt = defect_of(at, drive_now(end), step.h, (fast, deep, root))
                if not doubt > share or attempt > MOST_REPEATS:
                    break
                h = step.h * shrunk_by(doubt, share)
            else:
                break
        if not inside:
            break
        passed, saved = passed + step.h * per_theta, max(share - doubt, 0.0)
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
            k[OLD + i] = k[NEW + i]
        k[OLD + 4] = 0.0
    return EXHAUSTED, k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3], elapsed, depth


# ---- as the time loop asks for it ----------------------------------------------------------------


@jit
def as_seen(side, now, phase):
    """Return a side, a state (q, s, x1, v1) and a phase as the wall sees them.

    A wall that pushes towards -x2 sees them mirrored, and the constant load.
    """
    ps, sign = mirrored_load(side.ps.load, side.ps, side.sign), side.sign
    seen = side_with(side, ps, side.damper, side.wall, side.steps)
    return seen, (now[0], sign * now[1], sign * now[2], sign * now[3]), mirrored(phase, sign)


@by_wall
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    phase: (cos, sin) of the forcing's; place: share of the period that is over; `Watch` and result
    (event, q, s, x1, v1, elapsed, depth) as of `contact`.
    """
    return stepped(side, watch, phase, left, now)


@jit
def stepped(side, watch, phase, left, now):
    """Follow a contact by steps (arguments and result of `follow`)."""
    seen, start, wave = as_seen(side, now, phase)
    return mirrored_back(side, contact(seen, watch, wave, start, left))


@jit
def mirrored_back(side, result):
    """Return a result of `contact` with the state as it is, not as the wall sees it."""
    event, q, s, x1, v1, took, depth = result
    return event, q, side.sign * s, side.sign * x1, side.sign * v1, took, depth
