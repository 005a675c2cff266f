"""One contact from touch to release, stepped: any depth, any duration, any external force.

Step sizes come from the Hertz time scale of the motion at hand and from the rates of everything
else, so that soft rubber, steel, a slow pressed touch and a damper resting on its obstacle for many
periods are covered alike. In these units each step is so many parts of a free impact, and its error
is nearly known beforehand.

Afterwards it is verified. Over a step the energy of the contact changes by the work of the other
forces, and its virial by a known integral (`contact_field`); both integrals are one more column of
the same step, so that each balance is missed by an error of the step's own order. Relative to the
scales of the motion at hand, the one is the error of speed, the other, over 2.94, that of time;
their sum is the step's doubt. (The embedded formulas of DOP853 are of a lower order: they make 10
to 30 times its error of a step, the more the smaller it is.)

Doubt is granted in proportion to the way through a free impact: `tolerance` for the first one, less
for each further oscillation of a damper that stays in contact, whose errors add up. What a step
leaves of its share, later ones may use. A step of which more is doubted is repeated, and those
after it are as fine.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion import runge_kutta as rk
from ..motion.contact_field import DRAIN, VIRIAL, WORK
from ..motion.driven import count_of, drive_start, rows_of
from ..motion.response_sums import A2, CV, CX, V2, X2, Tally, beside
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.roots import guarded, narrowed, secant
from ..scene.arguments import Step, side_with
from ..scene.codes import EXHAUSTED, RELEASED, STOPPED
from ..scene.drive import drive_after, drive_now, later
from ..scene.law import (
    acting,
    depth_of,
    faint,
    force_of,
    gained,
    pressed,
    rate_of_switching,
    reach_of,
    rise_of,
    root_of,
    switching,
    turn_of,
    way_of_step,
    weight_of,
)
from ..scene.scene import accelerations, without_shaking
from ..watch.limit import note_limit_step
from ..watch.observe import note_force, note_step
from ..watch.response_steps import tally_step

MOST_STEPS = 1_000_000  # steps of one contact between two sections: beyond it, EXHAUSTED
MOST_ATTEMPTS = 60  # of a step that leaves the contact; numbers beyond all bounds need more
MOST_REPEATS = 20  # of a step that is doubted: what is doubted of a smaller one is round-off
MOST_FINER = 4.0  # times the number of steps that is known beforehand, for all steps to come
VERIFIED = 0.5  # part of the bound `rate` of all other motion that verified steps are made for
LONG = 4.0  # free impacts after which a contact is granted half as much doubt for each further one
MOST_TURNS = 20  # tries to find the deepest point in a step: one does but for very long steps
NEAR_TURN = 1.0e-6  # part of the depth that a parabola may add to it
NEAR_SWITCH = 1.0e-13  # error of the place of a switch in a step, where largest values have corners
SLIGHT = 1.0e-14  # of `switching`: it has not changed its sign
ROUND_OFF = 1.0e-15  # doubt of a step that means nothing
FAINT = 1.0e-16  # Hertz acceleration, as a share of the external one, that is round-off
SOON = 1.0e-5  # time in units of 1/rate for which an external acceleration is constant


class Steps(NamedTuple):
    """How finely a contact is stepped."""

    per_impact: float  # Runge-Kutta steps of a free impact
    tolerance: float  # relative error of a contact; infinite: steps are as they are


@jit
def start_at_rest(side, tangent, phase):
    """Move row Y past a touch without speed, which theta alone could not leave; return the time.

    Under an external acceleration a the depth grows as a t^2 / 2; until the Hertz force or a change
    of a is felt at round-off, that is exact. phase: the instant (`drive`).
    """
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q, s, x1, v1 = k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3]
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
    k[rk.Y], k[rk.Y + 1] = root_of(wall, depth), speed
    k[rk.Y + 2], k[rk.Y + 3] = x1 + t * (v1 + 0.5 * t * dv), v1 + t * dv
    if tangent is not None:
        if is_a(tangent, Tally):
            work_on(tangent, without_shaking(ps, dv, c), phase, t, k)
        else:
            vary_on(side, tangent, (x1, v1, wall.gap + z, s), c, t)
    return t


@jit
def vary_on(side, tangent, start, c, t):
    """Move the variations of row Y on by a short time t [s].

    start: the state (x1, v1, r, s) at its beginning.
    """
    for i in range(rk.WIDTH + rk.Y, rk.WIDTH + rk.Y + count_of(tangent), 4):
        side.k[i] += t * side.k[i + 1]
        side.k[i + 2] += t * side.k[i + 3]
    drive_start(side, tangent, start, c, t, int(rk.WIDTH + rk.Y))


@jit
def work_on(tally, a1, phase, t, k):
    """Add to a tally a time t [s] that is too short for more than one term; row Y is its end."""
    s, x1, v1, c = k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], drive_now(phase)
    row = tally.row
    row[X2] += t * x1 * x1
    row[V2] += t * v1 * v1
    row[A2] += t * a1 * a1
    row[CV] += t * c * v1
    row[CX] += t * c * beside(phase, x1, s)


@jit
def step_to_stop(side, tangent, step, left):
    """Write row NEW at the instant `left` after row Y, within a step; return the step to it."""
    k, h = side.k, step.h
    low, high, size = 0.0, h, h
    for _ in range(80):
        rk.advance(side, tangent, Step(step.phase, False, size))
        miss = left - k[rk.NEW + 4]
        if abs(miss) <= 1.0e-16 * left or high - low <= 1.0e-16 * h:
            break
        if miss > 0.0:
            low = size
        else:
            high = size
        q = k[rk.NEW]
        guess = size + miss / weight_of(side.wall, q) if q > 0.0 else low
        size = guarded(guess, low, high)
    return size


@jit
def motion_at(side, phase, row):
    """Return (z, dt/dtheta, ds/dt) of a row within a step, phase being that at row Y."""
    ps, wall, k = side.ps, side.wall, side.k
    q, s = k[row], k[row + 1]
    z = depth_of(wall, q)
    drive, force = drive_after(ps, phase, k[row + 4]), force_of(wall, q, z, s)
    _, ds = accelerations(ps, side.damper, k[row + 2], k[row + 3], wall.gap + z, s, drive, force)
    return z, weight_of(wall, q), ds


@jit
def turn_of_cubic(before, after, slope_before, slope_after):
    """Return where in [0, 1] the cubic of these values and slopes at 0 and 1 goes through zero."""
    change = after - before
    cube = slope_before + slope_after - 2.0 * change
    square = 3.0 * change - 2.0 * slope_before - slope_after
    x = -before / change
    for _ in range(3):
        value = before + x * (slope_before + x * (square + x * cube))
        steep = slope_before + x * (2.0 * square + 3.0 * x * cube)
        if not steep < 0.0:
            break
        x = min(max(x - value / steep, 0.0), 1.0)
    return x


@jit
def deepest(side, step):
    """Return the greatest depth [m] within a step over which s changes sign from + to -.

    A cubic finds s = 0 but for an error e of order four, and a parabola from there the depth but
    for e^3, which is less than the step errs by. Where e is large the search goes on. Row NEW is
    lost.
    """
    phase, h, k = step.phase, step.h, side.k
    s0, s1 = k[rk.Y + 1], k[rk.NEW + 1]
    _, w0, ds0 = motion_at(side, phase, int(rk.Y))
    _, w1, ds1 = motion_at(side, phase, int(rk.NEW))
    x = turn_of_cubic(s0, s1, h * w0 * ds0, h * w1 * ds1)
    low, high, found = 0.0, 1.0, 0.0
    for _ in range(MOST_TURNS):
        rk.advance(side, None, rk.part_of(step, x))
        z, weight, ds = motion_at(side, phase, int(rk.NEW))
        s = k[rk.NEW + 1]
        more = -0.5 * s * s / ds if ds < 0.0 else 0.0
        found = z + more
        if s == 0.0 or (ds < 0.0 and more <= NEAR_TURN * z):
            break
        if s > 0.0:
            low = x
        else:
            high = x
        x = guarded(x - s / (h * weight * ds) if ds < 0.0 else low, low, high)
    return found


@jit
def external_acceleration(side, c):
    """Return d2r/dt2 [m/s^2] of row Y without the Hertz force, at phase cosine c."""
    wall, k = side.wall, side.k
    r = wall.gap + depth_of(wall, k[rk.Y])
    x1, v1, s = k[rk.Y + 2], k[rk.Y + 3], k[rk.Y + 1]
    _, ds = accelerations(side.ps, side.damper, x1, v1, r, s, c, 0.0)
    return ds


@jit
def near_release(wall, external, h, k):
    """Tell whether the release is near and certain enough for a step in q that lands on z = 0."""
    q, s = k[rk.Y], k[rk.Y + 1]
    soon = s < 0.0 and -2.0 * q >= 1.2 * way_of_step(wall, h, s)
    return soon and s * s > 4.0 * external * depth_of(wall, q)


@jit
def advance(side, tangent, phase, external, left, h):
    """Step from row Y to row NEW, which need not lie in the contact; return (step, stopped).

    By h, or to the release if that is near (the `Step` is landing, then), or to the instant `left`
    if that comes first (`stopped`). external: `external_acceleration` of row Y.
    """
    k = side.k
    if near_release(side.wall, external, h, k):
        step = Step(phase, True, -k[rk.Y])
        rk.advance(side, tangent, step)
        if k[rk.NEW + 4] <= left:
            return step, False
    step = Step(phase, False, h)
    rk.advance(side, tangent, step)
    if k[rk.NEW] > 0.0 and k[rk.NEW + 4] > left:
        return Step(phase, False, step_to_stop(side, tangent, step, left)), True
    return step, False


@jit
def doubt_of(side, reach, deep, h):
    """Return how much of a step h is doubted: of order eight by how much it misses the balances.

    Relative. reach: q^2.5 where the free contact turns, deep: its depth [m]; those of row NEW may
    be larger. No step of rk4 is doubted.
    """
    wall, k = side.wall, side.k
    if side.rk4 is not None:
        return 0.0
    q, s, p, u = k[rk.Y], k[rk.Y + 1], k[rk.NEW], k[rk.NEW + 1]
    z, y = depth_of(wall, q), depth_of(wall, p)
    energy = 0.5 * (u - s) * (u + s) + gained(wall, y, p, z, q)
    energy -= h * rk.mean_slope(k, int(WORK))
    virial = y * u - z * s - h * rk.mean_slope(k, int(VIRIAL))
    fast = max(wall.speed * reach, abs(u))
    return (abs(energy) / fast + abs(virial) / (wall.lasting * max(deep, y))) / fast


@jit
def shrunk_by(doubt, share):
    """Return by how much a step is shrunk of which more is doubted than its share."""
    return max(0.3, 0.9 * math.sqrt(math.sqrt(math.sqrt(share / doubt))))


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
def up_to_switch(side, now, tangent, positive, step):
    """Cut a step short where the force of a wall becomes another function; row NEW is there.

    positive: what `switching` is at row Y, and the wall of `now` takes for granted in all of the
    step. Returns (switches, step).
    """
    if side.wall.switch is None:
        return False, step
    low, high, f0 = 0.0, 1.0, max(margin(side, positive, int(rk.Y)), 0.0)
    f1 = margin(side, positive, int(rk.NEW))
    if not f1 < -SLIGHT:
        high, f1 = least_margin(side, now, positive, step)
        if not f1 < -SLIGHT:
            return False, step
    x = high
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.advance(now, None, rk.part_of(step, x))
        f = margin(side, positive, int(rk.NEW))
        if f == 0.0 or min(x - low, high - x) < NEAR_SWITCH:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    step = rk.part_of(step, x)
    rk.advance(now, tangent, step)
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
    phase, k = step.phase, now.k
    f0, a = swing(side, now, phase, int(rk.Y))
    f1, _ = swing(side, now, phase, int(rk.NEW))
    way = 1.0 if positive else -1.0
    reach = 2.0 * a * max(abs(f0), abs(f1)) * k[rk.NEW + 4]
    least = min(margin(side, positive, int(rk.Y)), margin(side, positive, int(rk.NEW)))
    if not (way * f0 < 0.0 and way * f1 > 0.0 and least < reach):
        return 1.0, 0.0
    rk.save(k)
    low, high, x = 0.0, 1.0, 0.0
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.advance(now, None, rk.part_of(step, x))
        f, _ = swing(side, now, phase, int(rk.NEW))
        least = margin(side, positive, int(rk.NEW))
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    rk.restore(k)
    return x, least


@jit
def begin_along(tangent, k):
    """Write variations into row Y, where they go along."""
    if tangent is not None and not is_a(tangent, Tally):
        for i in range(count_of(tangent)):
            k[rk.Y + rk.WIDTH + i] = rows_of(tangent)[i]


@jit
def keep_along(side, tangent, h):
    """Keep what a step h has made of variations, where they go along.

    And by how much it has shrunk their volumes, where the contact is damped.
    """
    k = side.k
    if tangent is not None and not is_a(tangent, Tally):
        if side.wall.damping is not None:
            k[rk.SHRUNK] -= h * rk.mean_of(side.rk4, k, int(DRAIN))
        for i in range(count_of(tangent)):
            rows_of(tangent)[i] = k[rk.Y + rk.WIDTH + i] = k[rk.NEW + rk.WIDTH + i]


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
    k, phase = side.k, step.phase
    low, high = 0.0, 1.0
    push, f0 = push_at(side, phase, int(rk.Y))
    note_force(impacts, push)
    push, f1 = push_at(side, phase, int(rk.NEW))
    note_force(impacts, push)
    if not (f0 > 0.0 and f1 < 0.0):
        return
    rk.save(k)
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.advance(side, None, Step(phase, False, x * step.h))
        push, f = push_at(side, phase, int(rk.NEW))
        note_force(impacts, push)
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    rk.restore(k)


@jit
def noted(side, watch, step, elapsed, depth):
    """Note what is wanted of the step from row Y to row NEW; return the greatest depth so far [m].

    Energies are raised to their maxima over the step. `depth`, that of the steps before, is raised
    to the greatest depth within the step, if s changes sign there from + to -.
    """
    k = side.k
    if watch.limit_log is not None:
        note_limit_step(side, watch.limit_log, step, elapsed)
    if is_a(watch.energy, Tally):
        tally_step(side, watch.energy, step)
    elif watch.energy is not None:
        note_step(side, watch.energy, step)
    if watch.impacts is not None:
        if side.wall.damping is not None:
            note_push(side, watch.impacts, step)
        if k[rk.Y + 1] > 0.0 and k[rk.NEW + 1] <= 0.0:
            rk.save(k)
            depth = max(depth, deepest(side, step))
            rk.restore(k)
    return depth


@jit
def contact(side, watch, phase, now, stop):
    """Follow a contact from `now` = (q = sqrt(z), s, x1, v1) to its release or for `stop` [s].

    phase: (cos, sin) of the forcing's at the start; all is as the wall of the `Side` sees it.
    Returns (event, q, s, x1, v1, elapsed [s], depth [m]) with event RELEASED, STOPPED or EXHAUSTED
    (too many steps); the depth is that reached only if impacts are watched (`Watch`).
    """
    ps, wall, k, tangent = side.ps, side.wall, side.k, watch.tangent
    steps, rate = side.steps, side.rate
    k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3] = now
    k[rk.Y + 4] = 0.0
    elapsed, depth, seen, cube, root = 0.0, 0.0, -1.0, 0.0, 0.0
    # The way so far in free impacts, what is left of its shares of doubt, and how much finer steps
    # are than `steps` says.
    way, saved, finer = 0.0, 0.0, 1.0
    part = VERIFIED if steps.tolerance < math.inf else 1.0
    positive = is_positive(wall, now[0], now[1])
    begin_along(tangent, k)
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(side, tangent, phase)
            phase = later(ps, phase, elapsed)
        # The step h of theta resolves the free impact of this depth and speed, the external
        # acceleration, and the rates of all other motion over the way that q can go.
        external = external_acceleration(side, drive_now(phase))
        q, s = k[rk.Y], k[rk.Y + 1]
        reach = reach_of(wall, q, depth_of(wall, q), s)  # of Hertz' law, q^2.5 where it turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers are dear: a new one if it has changed
            cube, root = turn_of(wall, reach)
            seen = reach
        span = min(root, 2.0 * max(q, root_of(wall, abs(s) / rate)))  # of q: others may stop it
        swing = max(ps.omega, part * rate) * weight_of(wall, span)
        rate_squared = wall.kappa * cube + pressed(wall, external) + swing * swing
        per_theta = math.sqrt(rate_squared) / wall.whole  # free impacts
        late = 1.0 + way / LONG
        h = 1.0 / (per_theta * steps.per_impact * finer * math.sqrt(math.sqrt(math.sqrt(late))))
        # Step to the release, to the end of the time or by h, until it ends inside the contact and
        # no more of it is doubted than is granted.
        step, stopped, inside, doubt, share = Step(phase, False, h), False, False, 0.0, 0.0
        at = side_with(side, ps, side.damper, acting(wall, positive), steps)
        for attempt in range(MOST_ATTEMPTS):
            step, stopped = advance(at, tangent, phase, external, stop - elapsed, h)
            inside = step.landing or k[rk.NEW] > 0.0
            if inside:
                share = max(saved + steps.tolerance * (h * per_theta) / late, ROUND_OFF)
                doubt = doubt_of(at, seen, depth_of(wall, root), step.h)
                if not doubt > share or attempt > MOST_REPEATS:
                    break
                less = shrunk_by(doubt, share)
                if step.landing:  # by a step in theta that does not land
                    h = min(h, -q / (0.6 * way_of_step(wall, 1.0, s)))
                h *= less
                finer = min(finer / less, MOST_FINER)
            else:
                h *= 0.5
        if not inside:
            break
        if steps.tolerance < math.inf:
            way, saved = way + h * per_theta, max(share - doubt, 0.0)
        switches, step = up_to_switch(side, at, tangent, positive, step)
        # Note what the step has shown.
        depth = noted(at, watch, step, elapsed, depth)
        elapsed += k[rk.NEW + 4]
        keep_along(side, tangent, step.h)
        # End here, or go on from row NEW.
        positive = positive != switches
        if step.landing and not switches:
            return RELEASED, 0.0, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        if stopped and not switches:
            q = k[rk.NEW]
            depth = max(depth, depth_of(wall, q))
            return STOPPED, q, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        phase = later(ps, phase, k[rk.NEW + 4])
        for i in range(rk.WIDTH):
            k[rk.Y + i] = k[rk.NEW + i]
        k[rk.Y + 4] = 0.0
    return EXHAUSTED, k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], elapsed, depth
