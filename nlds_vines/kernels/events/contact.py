"""One contact from touch to release, stepped: any depth, any duration, any external force.

Each step is a Taylor polynomial (`taylor`). Its length follows from the last terms, and is at most
a part of a free impact with the present depth, speed and external acceleration, so that soft
rubber, steel, a slow pressed touch and a damper that rests on its obstacle for many periods are
covered alike.

Each step is verified: its doubt is the defect of the equation of motion at its end, relative to the
scales of the motion. The tolerated doubt is proportional to the part of a free impact that the step
covers: `tolerance` in all for the first free impact, less for each further oscillation of a damper
that stays in contact, whose errors add up. What a step leaves of its share, later steps may use. A
step with a larger doubt is shortened along the same polynomial.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion.driven import Driven, constants_of, count_of, rows_of, source_of
from ..motion.flight import FACTOR, ORDER
from ..motion.load_cells import Loaded, phase_of
from ..motion.response_sums import absolute, add_displaced, add_state
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
)
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, same_sort, says
from ..numerics.elementary import exp, log, whole_power
from ..numerics.roots import guarded, narrowed, secant
from ..scene.by_law import by_wall
from ..scene.codes import (
    ASTRAY,
    CLEARED,
    EXHAUSTED,
    LEAVING_FAR,
    LEAVING_NEAR,
    RELEASED,
    RETURNED,
    SECTION,
    STOPPED,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from ..scene.drive import after, drive_now
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
    force_at,
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
from ..scene.scene import Ground, Step, accelerations_at, side_with
from ..watch.observe import BEYOND, LIMIT, ORIGIN, note_force
from ..watch.response import OfPush, bend_in, note_roots, push_now, tally_push, watch_piece

# --------------------------------------------------------------------------------------------------
# Places within a step of a contact, found on its polynomial.
#
# A step ends at the release, at a prescribed instant, or where the force becomes another function
# (`law.switching`). Within it lies the deepest point.


MOST_TURNS = 60  # iterations in a step: a deepest point needs about 5, a switch about 30
MOST_NEWTON = 80  # iterations for a release or an instant: they need some five
NEAREST = 2.0e-16  # relative error of the place of a release
NEAR_TURN = 1.0e-6  # error of the place of a turn in a step
DEEPEST = 1.0e-10  # largest correction of a depth by a parabola, relative; it errs by its power 3/2
NEAR_SWITCH = 1.0e-13  # error of the place of a switch, where maxima have corners
SLIGHT = 1.0e-14  # round-off of `switching`


@jit
def motion_at(side, phase, row):
    """Return (z, dt/dtheta, d2z/dt2) at a row within a step, phase being that at row OLD."""
    wall, k = side.wall, side.k
    q, s = k[row], k[row + 1]
    z = depth_of(wall, q)
    drive, force = drive_now(after(side.ps, phase, k[row + 4])), force_of(wall, q, z, s)
    y = k[row + 2], k[row + 3], wall.gap + z, s
    _, ds = accelerations_at(side, side.ps, y, drive, force)
    return z, weight_of(wall, q), ds


@jit
def deepest(side, step):
    """Return the greatest depth [m] within a step over which s changes sign from + to -.

    At a place where s is not quite 0 a parabola gives the maximum, with an error of third order in
    s. Row NEW is overwritten.
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
def to_end(side, phase, left, h):
    """Step from row OLD to row NEW, which may lie outside the contact; return (step, stopped).

    The step ends after h, at the release (then the `Step` is landing), or at the instant `left`
    (then `stopped` is True), whichever comes first.
    """
    k = side.k
    step = Step(phase, False, h)
    advance(side, None, step)
    if k[NEW] > 0.0 and k[OLD + 1] < 0.0 and k[NEW + 1] > 0.0:
        # It may have been out in between: cut it short at the minimum of q if that is not positive.
        part = part_of(step, -k[OLD + 1] / (k[NEW + 1] - k[OLD + 1]))
        for _ in range(MOST_TURNS):
            advance(side, None, part)
            if not k[NEW] > 0.0 or abs(k[NEW + 1]) <= NEAR_TURN * abs(k[OLD + 1]):
                break
            _, _, ds = motion_at(side, phase, int(NEW))
            change = k[NEW + 1] / (ds * weight_of(side.wall, k[NEW]))
            if not 0.0 < part.h - change < h:
                break
            part = Step(phase, False, part.h - change)
        if not k[NEW] > 0.0:
            step = part
        else:
            advance(side, None, step)
    if not k[NEW] > 0.0 and k[OLD] > 0.0 and k[NEW + 1] <= 0.0:
        # Newton's method for the root of q, at which row NEW lands.
        low, high, x = 0.0, step.h, step.h
        for _ in range(MOST_NEWTON):
            advance(side, None, Step(phase, False, x))
            q, slope = k[NEW], rate_of_q(side.wall, k[NEW + 1])
            if q > 0.0:
                low = x
            else:
                high = x
            if q == 0.0 or not high - low > NEAREST * high:
                break
            guess = x - q / slope if slope < 0.0 else low
            if guess == x:
                break
            x = guarded(guess, low, high)
        k[NEW] = 0.0
        step = Step(phase, True, x)
    if (step.landing or k[NEW] > 0.0) and k[NEW + 4] > left:
        # Newton's method for the length at which the time is over.
        low, high, size = 0.0, step.h, step.h
        for _ in range(MOST_NEWTON):
            advance(side, None, Step(phase, False, size))
            miss = left - k[NEW + 4]
            if abs(miss) <= 1.0e-16 * left or high - low <= 1.0e-16 * step.h:
                break
            if miss > 0.0:
                low = size
            else:
                high = size
            q = k[NEW]
            guess = size + miss / weight_of(side.wall, q) if q > 0.0 else low
            size = guarded(guess, low, high)
        return Step(phase, False, size), True
    return step, False


@jit
def margin(side, positive, row):
    """Return `switching` at a row, times its former sign: negative after a switch."""
    q, s = side.k[row], side.k[row + 1]
    value = switching(side.wall, depth_of(side.wall, q), s)
    return value if positive else -value


@jit
def up_to_switch(side, now, positive, step):
    """Cut a step short where the force of a wall becomes another function, at row NEW.

    positive: the sign of `switching` at row OLD, for which the wall of `now`, the side in the step,
    acts in all of it. Returns (switches, step).
    """
    if side.wall.switch is None:
        return False, step
    low, high, f0 = 0.0, 1.0, max(margin(side, positive, int(OLD)), 0.0)
    f1 = margin(side, positive, int(NEW))
    if not f1 < -SLIGHT:
        # The least margin within the step, unless it cannot become negative at twice the rates of
        # the ends; row NEW is kept.
        k, begin, end, sense = now.k, 0.0, 1.0, 1.0 if positive else -1.0
        rate0, a = swing(side, now, step.phase, int(OLD))
        rate1, _ = swing(side, now, step.phase, int(NEW))
        reach = 2.0 * a * max(abs(rate0), abs(rate1)) * k[NEW + 4]
        least = min(margin(side, positive, int(OLD)), f1)
        if not (sense * rate0 < 0.0 and sense * rate1 > 0.0 and least < reach):
            return False, step
        set_aside(k)
        for _ in range(MOST_TURNS):
            high = secant(begin, end, rate0, rate1)
            advance(now, None, part_of(step, high))
            rate, _ = swing(side, now, step.phase, int(NEW))
            f1 = margin(side, positive, int(NEW))
            if rate == 0.0 or min(high - begin, end - high) < NEAR_TURN:
                break
            begin, end, rate0, rate1 = narrowed(begin, end, rate0, rate1, high, rate)
        restore(k)
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
    _, _, ds = motion_at(now, phase, row)
    return rate_of_switching(side.wall, side.k[row + 1], ds)


# --------------------------------------------------------------------------------------------------
# Variations along a contact that is stepped. They do not change the orbit.
#
# Their polynomials (`taylor`) have the radius of convergence of the orbit's, but larger last terms:
# near the touch a force K z^n has little effect on an orbit, and its stiffness n K z^(n - 1) a
# large one on variations. So they take the orbit's step in parts if their last terms ask for it,
# each from the state that the orbit's polynomial has there.


MOST_PARTS = 100  # of a step; a few are needed where a force begins with a fractional power
MORE = 10.0  # largest last terms, in units of those granted to the orbit


@jit
def ride(side, tangent, step, granted, scales):
    """Carry variations over the step from row OLD to row NEW, whose series are in k.

    granted: tolerance of the orbit's last terms, infinite if steps are not checked; scales: of
    speed, depth and q. Row OLD and the series are overwritten.
    """
    k, wall, (fast, deep, root) = side.k, side.wall, scales
    left, phase = step.h, step.phase
    set_aside(k)
    for part in range(MOST_PARTS):
        h = left
        if granted < math.inf and part < MOST_PARTS - 1:
            # the last two terms may be MORE times `granted`, relative to the size of each
            # variation, where fast / deep [1/s] turns displacements into velocities
            n, less, x, first = order_of(side.rk4), 0.0, h / k[UNIT], SERIES + VARIED
            for m in range(n - 1, n + 1):
                row, most = SERIES + COLUMNS * m, 0.0
                for j in range(4):
                    size = abs(k[first + 4 + j]) + abs(k[first + 12 + j])
                    size += fast / deep * (abs(k[first + j]) + abs(k[first + 8 + j]))
                    end = max(abs(k[row + VARIED + 4 + j]), abs(k[row + VARIED + 12 + j]))
                    if end > most * size and size > 0.0:
                        most = end / size
                term = most * whole_power(x, m)
                if term > MORE * granted:
                    less = min(less, log(MORE * granted / term) / m)
            h = exp(less) * h
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


MOST_STEPS = 1_000_000  # of one contact between two sections: beyond it, EXHAUSTED
MOST_ATTEMPTS = 60  # at a step that leaves the contact; only an overflow needs more
MOST_REPEATS = 20  # of a step with too large a doubt, after which the doubt is round-off
LEAST_GRANTED = 1.0e-14  # least tolerance, round-off
LONG = 1.0  # free impacts after which the doubt granted to a further one is halved
LAST_TERMS = 0.25  # of a step, in units of the tolerance: errors of contacts have a sign and add up
LEAST_DOUBT = 1.0e-15  # doubt of a step that is round-off
FAINT = 1.0e-16  # acceleration by the contact, relative to the external one, that is round-off
SOON = 1.0e-7  # time in units of 1/rate for which an external acceleration is constant


class Steps(NamedTuple):
    """How finely a contact is stepped."""

    per_impact: float  # least steps of a free impact
    tolerance: float  # relative error of a contact; infinite: steps are as they are


@jit
def start_at_rest(side, tangent, tally, phase):
    """Move row OLD past a touch without speed, which steps in theta cannot leave; return the time.

    Under an external acceleration a the depth grows as a t^2 / 2, exact to round-off until the
    contact's force or a change of a exceeds round-off. phase: the instant (`drive`).
    """
    wall, k, sign = side.wall, side.k, side.sign
    q, s, x1, v1 = k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3]
    z, c = depth_of(wall, q), drive_now(phase)
    dv, external = accelerations_at(side, side.ps, (x1, v1, wall.gap + z, s), c, 0.0)
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
    y = x1, v1, sign * (wall.gap + z), sign * s
    if tangent is not None:
        # The variations of row OLD move on by the time t.
        for i in range(WIDTH + OLD, WIDTH + OLD + count_of(tangent), 4):
            side.k[i] += t * side.k[i + 1]
            side.k[i + 2] += t * side.k[i + 3]
        if is_a(tangent, Driven):  # df/dp is constant for so short a time
            for i in range(len(tangent.rates)):
                by, at = tangent.rates[i], WIDTH + OLD + 4 * i
                motion = y, (dv, sign * external)
                adds = source_of(side.ps, side.damper, by, 1.0, motion, c, (0.0, 0.0))
                for j in range(4):
                    k[at + j] += t * adds[j]
    if tally is not None:
        # The tally takes the time t, in which the state rests.
        add_state(tally.row, t, y, absolute(tally.ground, dv, c), c)
        add_displaced(tally, t, x1, c)
    return t


@jit
def noted(side, watch, step, elapsed, depth):
    """Record the step from row OLD to row NEW; return the greatest depth so far [m].

    `depth`, that of the steps before, is raised to the greatest depth within the step if s changes
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
def contact(side, watch, phase, now, stop):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for `stop` [s].

    z = q^p is the depth, p = `wall.root` (2 for Hertz). phase: the instant of the start (`drive`).
    Returns (event, q, s, x1, v1, elapsed [s], depth [m]) with event RELEASED, STOPPED or EXHAUSTED
    (too many steps); the depth is the greatest only if the `Watch` has impacts.
    """
    ps, wall, k, tangent, steps = side.ps, side.wall, side.k, watch.tangent, side.steps
    k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3] = now
    k[OLD + 4] = 0.0
    elapsed, depth = 0.0, 0.0
    # cube, root: q^(N - 2) and q where a free impact turns, for the `reach` seen: they are computed
    # anew if it has changed by 5 %
    seen, cube, root = -1.0, 0.0, 0.0
    passed, saved = 0.0, 0.0  # free impacts so far; doubt that steps have left of their shares
    positive = (
        True if wall.switch is None else switching(wall, depth_of(wall, now[0]), now[1]) > 0.0
    )
    if tangent is not None:
        for i in range(count_of(tangent)):
            k[OLD + WIDTH + i] = rows_of(tangent)[i]
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(side, tangent, watch.tally, phase)
            phase = after(ps, phase, elapsed)
        # The longest step: a part of the free impact of this depth and speed, with the external
        # acceleration and the rates of all other motion over the distance that q can go.
        q, s = k[OLD], k[OLD + 1]
        y = k[OLD + 2], k[OLD + 3], wall.gap + depth_of(wall, q), s
        _, external = accelerations_at(side, ps, y, drive_now(phase), 0.0)
        reach = reach_of(wall, q, depth_of(wall, q), s)  # of Hertz' law, q^2.5 where it turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers cost much: only if it has changed
            if reach == 0.0 and external <= 0.0:  # the force underflows
                return RELEASED, 0.0, s, k[OLD + 2], k[OLD + 3], elapsed, depth
            cube, root = turn_of(wall, reach)
            seen = reach
        span = min(root, 2.0 * max(q, root_of(wall, abs(s) / side.rate)))  # of q
        swing = max(ps.omega, side.rate) * weight_of(wall, span)
        rate_squared = wall.kappa * cube + pressed(wall, external) + swing * swing
        per_theta = math.sqrt(rate_squared) / wall.whole  # free impacts per unit of theta
        # late: divides the tolerated doubt of later oscillations
        late, h = 1.0 + passed / LONG, 1.0 / (per_theta * steps.per_impact)
        # The length that the last terms of the polynomial allow.
        at = side_with(side, ps, side.damper, acting(wall, positive), steps)
        # (by rk4 the series serve records and variations alone)
        if (
            side.rk4 is None
            or watch.energy is not None
            or watch.limit_log is not None
            or watch.tally is not None
            or watch.tangent is not None
            or (watch.impacts is not None and side.wall.damping is not None)
        ):
            expand_contact(at, tangent, phase, h)
        fast, deep = max(wall.speed * seen, abs(s)), depth_of(wall, root)
        granted = max(steps.tolerance, LEAST_GRANTED) / late
        if steps.tolerance < math.inf:
            h = length_of(at, h, LAST_TERMS * granted, fast)
        # Step to the release, to the end of the time or by h; shorten the step until it ends inside
        # the contact with a doubt within its share.
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
                h = step.h * max(0.3, 0.9 * exp(log(share / doubt) / HIGHEST))
            else:
                break
        if not inside:
            break
        passed, saved = passed + step.h * per_theta, max(share - doubt, 0.0)
        switches, step = up_to_switch(side, at, positive, step)
        # Record the step.
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


# ---- a contact as the time loop follows it ------------------------------------------------------


@by_wall
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    phase: the instant (`drive`); place: share of the period that is over; `Watch` and result
    (event, q, s, x1, v1, elapsed, depth) as of `contact`.
    """
    return contact(side, watch, phase, now, left)


@jit
def structure_at(damper, x1, v1, r, s):
    """Return (x1, v1), which are r and s if the walls limit the structure itself.

    Both pairs are integrated; taking one keeps round-off from separating them.
    """
    if is_a(damper, Ground):
        return (r, s)
    return (x1, v1)


@jit
def follow_side(side, watch, begun, left, now):
    """Follow a contact to its release or for the time `left` [s].

    begun: its time [s], the instant (`drive`), and the share of the period that is over; now: (q,
    s, x1, v1). Returns (event, q, (x1, v1, r, s), time [s], (depth [m], greatest force [N])).
    """
    wall, sign, (time, phase, place), (q, s, x1, v1) = side.wall, side.sign, begun, now
    # The log of a limit counts from the touch; at the far wall r is at most -gap.
    if watch.limit_log is not None:
        watch.limit_log[ORIGIN] = time
        if sign < 0.0 and -wall.gap <= watch.limit_log[LIMIT]:
            watch.limit_log[BEYOND] = 0.0
    start = q, sign * s, x1, v1
    event, q, s, x1, v1, took, depth = follow(side, watch, phase, place, left, start)
    r, s = sign * (wall.gap + depth_of(wall, q)), sign * s
    x1, v1 = structure_at(side.damper, x1, v1, r, s)
    return event, q, (x1, v1, r, s), took, (depth, force_at(wall, depth))


@jit
def follow_at(near, far, mode, watch, begun, left, now):
    """Follow a contact at the near or the far side, by its `mode`; an absent side is None.

    Arguments and result as of `follow_side`.
    """
    if near is None:
        return follow_side(far, watch, begun, left, now)
    if far is None:
        return follow_side(near, watch, begun, left, now)
    if same_sort(near, far):  # one call for both
        side = near if mode == TOUCH_NEAR else far
        return follow_side(side, watch, begun, left, now)
    if mode == TOUCH_NEAR:
        return follow_side(near, watch, begun, left, now)
    return follow_side(far, watch, begun, left, now)


# ---- leaving a wall whose force has vanished -----------------------------------------------------


@jit
def may_leave(near, far):
    """Return True if a wall may let go of a damper that is still beyond the place of touch."""
    return says(near, "LINEAR") or says(far, "LINEAR")


@jit
def leaves(near, far, mode):
    return may_leave(near, far) and mode in (LEAVING_NEAR, LEAVING_FAR)


@by_wall
def leave(side, watch, phase, place, left, now):
    """Fly from a depth at which the wall does not push, to z = 0 or for the time `left` [s].

    Arguments as of `follow`. Returns (event, q, s, x1, v1, time [s]) with event CLEARED at z = 0,
    RETURNED if the wall pushes again before, STOPPED or EXHAUSTED.
    """
    return CLEARED, now[0], now[1], now[2], now[3], 0.0


@jit
def leave_wall(near, far, mode, watch, grid, stop, begun, now):
    """Leave the place of a contact whose force has vanished, at the near or the far side.

    begun: (cell, place in it); now: (q, x1, v1, r, s). Returns (event, j, x, q, x1, v1, r, s):
    CLEARED if the damper is out, otherwise as `exact.fly`.
    """
    (q, x1, v1, r, s), (j, x) = now, begun
    place, left, sign = (j + x) / grid.n, (stop - j - x) * grid.h, 1.0
    event, took, gap = CLEARED, 0.0, 0.0
    phase = phase_of(grid, j, x) if is_a(grid.begun, Loaded) else None
    if near is not None and mode == LEAVING_NEAR:
        event, q, s, x1, v1, took = leave(near, watch, phase, place, left, (q, s, x1, v1))
        gap = near.wall.gap
    if far is not None and mode == LEAVING_FAR:
        event, q, s, x1, v1, took = leave(far, watch, phase, place, left, (q, -s, x1, v1))
        gap, sign = far.wall.gap, -1.0
    at_place = j + x + took / grid.h
    r, s = sign * (gap + q), sign * s
    x1, v1 = structure_at(far.damper if near is None else near.damper, x1, v1, r, s)
    j = min(int(at_place), stop - 1)
    x = at_place - j
    if event == EXHAUSTED:
        return ASTRAY, j, x, q, x1, v1, r, s
    if event == STOPPED:
        return SECTION, stop, 0.0, q, x1, v1, r, s
    if event == RETURNED:
        event = TOUCH_NEAR if mode == LEAVING_NEAR else TOUCH_FAR
    return event, j, x, q, x1, v1, r, s
