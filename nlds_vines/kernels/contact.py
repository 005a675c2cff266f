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

from . import runge_kutta as rk
from .codes import EXHAUSTED, RELEASED, STOPPED
from .compiling import chosen, is_a, jit
from .contact_field import DRAIN, VIRIAL, WORK, cos_sin, rotated
from .driven import count_of, drive_start, rows_of
from .force_law import (
    acting,
    damping_of,
    depth_of,
    factor_of,
    faint,
    force_of,
    gained,
    lasting_of,
    pressed,
    reach_of,
    root_of,
    turn_of,
    way_of_step,
    weight_of,
    whole_of,
)
from .limit import note_limit_step
from .observe import note_force, note_step
from .response_steps import tally_step
from .response_sums import A2, CV, CX, V2, X2, Tally
from .roots import guarded, narrowed, secant
from .scene import accelerations

MOST_STEPS = 1_000_000  # steps of one contact between two sections: beyond it, EXHAUSTED
MOST_ATTEMPTS = 60  # of a step that leaves the contact; numbers beyond all bounds need more
MOST_REPEATS = 20  # of a step that is doubted: what is doubted of a smaller one is round-off
MOST_FINER = 4.0  # times the number of steps that is known beforehand, for all steps to come
VERIFIED = 0.5  # part of the bound `rate` of all other motion that verified steps are made for
LONG = 4.0  # free impacts after which a contact is granted half as much doubt for each further one
MOST_TURNS = 20  # tries to find the deepest point in a step: one does but for very long steps
NEAR_TURN = 1.0e-6  # part of the depth that a parabola may add to it
NEAR_SWITCH = 1.0e-13  # error of the place of a switch in a step, where largest values have corners
SLIGHT = 1.0e-14  # of 1 + a dz/dt: it has not changed its sign
ROUND_OFF = 1.0e-15  # doubt of a step that means nothing
FAINT = 1.0e-16  # Hertz acceleration, as a share of the external one, that is round-off
SOON = 1.0e-5  # time in units of 1/rate for which an external acceleration is constant


class Steps(NamedTuple):
    """How finely a contact is stepped."""

    per_impact: float  # Runge-Kutta steps of a free impact
    tolerance: float  # relative error of a contact; infinite: steps are as they are


@jit
def start_at_rest(tangent, ps, damper, wall, rate, c, k):
    """Move row Y past a touch without speed, which theta alone could not leave; return the time.

    Under an external acceleration a the depth grows as a t^2 / 2; until the Hertz force or a change
    of a is felt at round-off, that is exact. c: cos of the phase.
    """
    q, s, x1, v1 = k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3]
    z = depth_of(wall, q)
    dv, external = accelerations(ps, damper, x1, v1, wall.gap + z, s, c, 0.0)
    if external <= 0.0 or s < 0.0:
        return 0.0
    depth = faint(wall, FAINT * external / wall.kappa)
    soon = SOON / rate
    depth = min(depth, 0.5 * external * soon * soon)
    if z + 0.5 * s * s / external >= depth:
        return 0.0
    speed = math.sqrt(2.0 * external * depth)
    t = (speed - s) / external
    k[rk.Y], k[rk.Y + 1] = root_of(wall, depth), speed
    k[rk.Y + 2], k[rk.Y + 3] = x1 + t * (v1 + 0.5 * t * dv), v1 + t * dv
    start = x1, v1, wall.gap + z, s
    move_along(tangent, ps, damper, dv, start, c, t, k)
    return t


@chosen
def move_along(tangent, ps, damper, dv, start, c, t, k):
    """Move what goes along with row Y on by a short time t [s]: variations, or a tally's sums.

    start: the state (x1, v1, r, s) at its beginning.
    """
    if tangent is None:
        return lambda tangent, ps, damper, dv, start, c, t, k: None
    return work_on if is_a(tangent, Tally) else vary_on


@jit
def vary_on(tangent, ps, damper, dv, start, c, t, k):
    """Move variations on."""
    for i in range(rk.WIDTH + rk.Y, rk.WIDTH + rk.Y + count_of(tangent), 4):
        k[i] += t * k[i + 1]
        k[i + 2] += t * k[i + 3]
    drive_start(tangent, ps, damper, start, c, t, k, int(rk.WIDTH + rk.Y))


@jit
def work_on(tangent, ps, damper, dv, start, c, t, k):
    """Add a time that is too short for more than one term."""
    x1, v1 = k[rk.Y + 2], k[rk.Y + 3]
    row = tangent.row
    row[X2] += t * x1 * x1
    row[V2] += t * v1 * v1
    row[A2] += t * dv * dv
    row[CV] += t * c * v1
    row[CX] += t * c * x1


@jit
def step_to_stop(rk4, tangent, ps, damper, wall, c, d, h, left, k):
    """Write row NEW at the instant `left` after row Y, within a step h; return the step to it."""
    # hot: once per section inside a contact
    low, high, size = 0.0, h, h
    for _ in range(80):
        rk.step(rk4, tangent, ps, damper, wall, c, d, False, size, k)
        miss = left - k[rk.NEW + 4]
        if abs(miss) <= 1.0e-16 * left or high - low <= 1.0e-16 * h:
            break
        if miss > 0.0:
            low = size
        else:
            high = size
        q = k[rk.NEW]
        guess = size + miss / weight_of(wall, q) if q > 0.0 else low
        size = guarded(guess, low, high)
    return size


@jit
def motion_at(ps, damper, wall, c, d, k, row):
    """Return (z, dt/dtheta, ds/dt) of a row within a step whose phase is (c, d) at row Y."""
    q, s = k[row], k[row + 1]
    z = depth_of(wall, q)
    cosine, sine = cos_sin(ps.omega * k[row + 4])
    _, ds = accelerations(
        ps, damper, k[row + 2], k[row + 3], wall.gap + z, s, c * cosine - d * sine,
        force_of(wall, q, z, s),
    )  # fmt: skip
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
def deepest(rk4, ps, damper, wall, c, d, h, k):
    """Return the greatest depth [m] within a step h over which s changes sign from + to -.

    A cubic finds s = 0 but for an error e of order four, and a parabola from there the depth but
    for e^3, which is less than the step errs by. Where e is large the search goes on. Row NEW is
    lost.
    """
    s0, s1 = k[rk.Y + 1], k[rk.NEW + 1]
    _, w0, ds0 = motion_at(ps, damper, wall, c, d, k, int(rk.Y))
    _, w1, ds1 = motion_at(ps, damper, wall, c, d, k, int(rk.NEW))
    x = turn_of_cubic(s0, s1, h * w0 * ds0, h * w1 * ds1)
    low, high, found = 0.0, 1.0, 0.0
    for _ in range(MOST_TURNS):
        rk.step(rk4, None, ps, damper, wall, c, d, False, x * h, k)
        z, weight, ds = motion_at(ps, damper, wall, c, d, k, int(rk.NEW))
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
def external_acceleration(ps, damper, wall, c, k):
    """Return d2r/dt2 [m/s^2] of row Y without the Hertz force, at phase cosine c."""
    r = wall.gap + depth_of(wall, k[rk.Y])
    _, ds = accelerations(ps, damper, k[rk.Y + 2], k[rk.Y + 3], r, k[rk.Y + 1], c, 0.0)
    return ds


@jit
def near_release(wall, external, h, k):
    """Tell whether the release is near and certain enough for a step in q that lands on z = 0."""
    q, s = k[rk.Y], k[rk.Y + 1]
    soon = s < 0.0 and -2.0 * q >= 1.2 * way_of_step(wall, h, s)
    return soon and s * s > 4.0 * external * depth_of(wall, q)


@jit
def advance(rk4, tangent, ps, damper, wall, c, d, external, left, h, k):
    """Step from row Y to row NEW, which need not lie in the contact; return (landing, stopped, h).

    By h, or to the release if that is near (`landing`, h being in q), or to the instant `left` if
    that comes first (`stopped`). external: `external_acceleration` of row Y.
    """
    # hot: once per step
    if near_release(wall, external, h, k):
        q = k[rk.Y]
        rk.step(rk4, tangent, ps, damper, wall, c, d, True, -q, k)
        if k[rk.NEW + 4] <= left:
            return True, False, -q
    rk.step(rk4, tangent, ps, damper, wall, c, d, False, h, k)
    if k[rk.NEW] > 0.0 and k[rk.NEW + 4] > left:
        return False, True, step_to_stop(rk4, tangent, ps, damper, wall, c, d, h, left, k)
    return False, False, h


@jit
def missed_balance(rk4, wall, reach, deep, h, k):
    """Return by how much a step h from row Y to row NEW misses the balances, relative.

    reach: q^2.5 where the free contact turns, deep: its depth [m]; those of row NEW may be larger.
    """
    q, s, p, u = k[rk.Y], k[rk.Y + 1], k[rk.NEW], k[rk.NEW + 1]
    z, y = depth_of(wall, q), depth_of(wall, p)
    energy = 0.5 * (u - s) * (u + s) + gained(wall, y, p, z, q)
    energy -= h * rk.mean_slope(k, int(WORK))
    virial = y * u - z * s - h * rk.mean_slope(k, int(VIRIAL))
    fast = max(wall.speed * reach, abs(u))
    return (abs(energy) / fast + abs(virial) / (lasting_of(wall) * max(deep, y))) / fast


@jit
def no_doubt(rk4, wall, reach, deep, h, k):
    """Return 0: no step of rk4 is doubted."""
    return 0.0


@chosen
def doubt_of(rk4, wall, reach, deep, h, k):
    """Return how much of a step is doubted: `missed_balance` of order eight."""
    # hot: once per step
    return missed_balance if rk4 is None else no_doubt


@jit
def shrunk_by(doubt, share):
    """Return by how much a step is shrunk of which more is doubted than its share."""
    return max(0.3, 0.9 * math.sqrt(math.sqrt(math.sqrt(share / doubt))))


@chosen
def pushes_at(damping, s):
    """Tell whether a wall pushes what is in contact and moves with dz/dt = s."""
    if damping is None:
        return lambda damping, s: True
    return lambda damping, s: factor_of(damping, s) > 0.0


@chosen
def up_to_switch(damping, rk4, tangent, ps, damper, wall, pushes, c, d, landing, h, k):
    """Cut a step h short where a damped wall lets go, or pushes again; row NEW is there.

    pushes: what it does at row Y, and in all of the step as it is. Returns (switches, h).
    """
    # hot: once per step
    return never_switches if damping is None else up_to_switch_if_any


@jit
def never_switches(damping, rk4, tangent, ps, damper, wall, pushes, c, d, landing, h, k):
    """Return that the step stays."""
    # hot: once per step
    return False, h


@jit
def margin(damping, pushes, s):
    """Return 1 + a s, or minus it where the wall has let go: negative behind the switch."""
    return factor_of(damping, s) if pushes else -factor_of(damping, s)


@jit
def up_to_switch_if_any(damping, rk4, tangent, ps, damper, wall, pushes, c, d, landing, h, k):
    """Cut a step short at its first switch, if it has one."""
    # hot: once per step
    now = acting(damping, wall, pushes)
    low, high, f0 = 0.0, 1.0, max(margin(damping, pushes, k[rk.Y + 1]), 0.0)
    f1 = margin(damping, pushes, k[rk.NEW + 1])
    if not f1 < -SLIGHT:
        high, f1 = least_margin(rk4, ps, damper, now, damping, pushes, c, d, landing, h, k)
        if not f1 < -SLIGHT:
            return False, h
    x = high
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.step(rk4, None, ps, damper, now, c, d, landing, x * h, k)
        f = margin(damping, pushes, k[rk.NEW + 1])
        if f == 0.0 or min(x - low, high - x) < NEAR_SWITCH:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    rk.step(rk4, tangent, ps, damper, now, c, d, landing, x * h, k)
    return True, x * h


@jit
def least_margin(rk4, ps, damper, now, damping, pushes, c, d, landing, h, k):
    """Return (place, `margin`) where s turns within a step h, or (1, 0): row NEW is kept.

    Only where the margin may become negative by its rates at the ends, twice as large.
    """
    # hot: once per step
    s0, s1 = k[rk.Y + 1], k[rk.NEW + 1]
    _, _, f0 = motion_at(ps, damper, now, c, d, k, int(rk.Y))
    _, _, f1 = motion_at(ps, damper, now, c, d, k, int(rk.NEW))
    way = 1.0 if pushes else -1.0
    reach = 2.0 * damping.a * max(abs(f0), abs(f1)) * k[rk.NEW + 4]
    least = min(margin(damping, pushes, s0), margin(damping, pushes, s1))
    if not (way * f0 < 0.0 and way * f1 > 0.0 and least < reach):
        return 1.0, 0.0
    for i in range(rk.WIDTH):
        k[rk.SAVE + i] = k[rk.NEW + i]
    low, high, x = 0.0, 1.0, 0.0
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.step(rk4, None, ps, damper, now, c, d, landing, x * h, k)
        _, _, f = motion_at(ps, damper, now, c, d, k, int(rk.NEW))
        least = margin(damping, pushes, k[rk.NEW + 1])
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    for i in range(rk.WIDTH):
        k[rk.NEW + i] = k[rk.SAVE + i]
    return x, least


@chosen
def begin_along(tangent, k):
    """Write variations into row Y, where they go along."""

    def written(tangent, k):
        for i in range(count_of(tangent)):
            k[rk.Y + rk.WIDTH + i] = rows_of(tangent)[i]

    if tangent is None or is_a(tangent, Tally):
        return lambda tangent, k: None
    return written


@chosen
def keep_along(tangent, damping, rk4, h, k):
    """Keep what a step h has made of variations, where they go along."""

    def kept(tangent, damping, rk4, h, k):
        keep_drained(damping, rk4, h, k)
        for i in range(count_of(tangent)):
            rows_of(tangent)[i] = k[rk.Y + rk.WIDTH + i] = k[rk.NEW + rk.WIDTH + i]

    if tangent is None or is_a(tangent, Tally):
        return lambda tangent, damping, rk4, h, k: None
    return kept


@chosen
def keep_drained(damping, rk4, h, k):
    """Keep by how much a step h of a damped contact has shrunk volumes."""

    def kept(damping, rk4, h, k):
        k[rk.SHRUNK] -= h * rk.mean_of(rk4, k, int(DRAIN))

    return nothing_drained if damping is None else kept


@jit
def nothing_drained(damping, rk4, h, k):
    """Keep nothing."""


@chosen
def note_push(damping, rk4, ps, damper, wall, impacts, c, d, h, k):
    """Raise the greatest force to that of a step h, where it is not that at the greatest depth."""
    # hot: once per step
    return no_push if damping is None else note_greatest_push


@jit
def no_push(damping, rk4, ps, damper, wall, impacts, c, d, h, k):
    """Note nothing."""
    # hot: once per step
    return None


@jit
def push_at(ps, damper, wall, c, d, k, row):
    """Return (F, dF/dtheta) of a row within a step: of K z^n (1 + a s), but for what multiplies."""
    q, s = k[row], k[row + 1]
    z, _, ds = motion_at(ps, damper, wall, c, d, k, row)
    rise = wall.exponent * s * factor_of(wall.damping, s) + z * wall.damping.a * ds
    return force_of(wall, q, z, s), rise


@jit
def note_greatest_push(damping, rk4, ps, damper, wall, impacts, c, d, h, k):
    """Raise the greatest force to its maximum in the step h from row Y to row NEW, which is kept.

    It is where the sign of n s (1 + a s) + z a ds/dt changes from + to -.
    """
    # hot: once per step
    low, high = 0.0, 1.0
    push, f0 = push_at(ps, damper, wall, c, d, k, int(rk.Y))
    note_force(impacts, push)
    push, f1 = push_at(ps, damper, wall, c, d, k, int(rk.NEW))
    note_force(impacts, push)
    if not (f0 > 0.0 and f1 < 0.0):
        return
    for i in range(rk.WIDTH):
        k[rk.SAVE + i] = k[rk.NEW + i]
    for _ in range(MOST_TURNS):
        x = secant(low, high, f0, f1)
        rk.step(rk4, None, ps, damper, wall, c, d, False, x * h, k)
        push, f = push_at(ps, damper, wall, c, d, k, int(rk.NEW))
        note_force(impacts, push)
        if f == 0.0 or min(x - low, high - x) < NEAR_TURN:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    for i in range(rk.WIDTH):
        k[rk.NEW + i] = k[rk.SAVE + i]


@chosen
def note_work(rk4, ps, damper, wall, sign, energy, c, d, landing, h, k):
    """Note the largest energies of a step, or, for a tally, all that is summed up."""
    # hot: once per step
    if is_a(energy, Tally):
        return tally_step
    return lambda rk4, ps, damper, wall, sign, energy, c, d, landing, h, k: note_step(
        rk4, ps, damper, wall, energy, c, d, landing, h, k
    )


@jit
def noted(
    sign, limit_log, energy, impacts, rk4, ps, damper, wall, c, d, landing, h, k, elapsed, depth
):
    """Note what is wanted of the step from row Y to row NEW; return the greatest depth so far [m].

    Energies are raised to their maxima over the step. `depth`, that of the steps before, is raised
    to the greatest depth within the step, if s changes sign there from + to -.
    """
    # hot: once per step
    if limit_log is not None:
        note_limit_step(rk4, ps, damper, wall, sign, limit_log, c, d, landing, h, k, elapsed)
    if energy is not None:
        note_work(rk4, ps, damper, wall, sign, energy, c, d, landing, h, k)
    if impacts is not None:
        note_push(damping_of(wall), rk4, ps, damper, wall, impacts, c, d, h, k)
    if impacts is not None and k[rk.Y + 1] > 0.0 and k[rk.NEW + 1] <= 0.0:
        for i in range(rk.WIDTH):
            k[rk.SAVE + i] = k[rk.NEW + i]
        depth = max(depth, deepest(rk4, ps, damper, wall, c, d, h, k))
        for i in range(rk.WIDTH):
            k[rk.NEW + i] = k[rk.SAVE + i]
    return depth


@jit
def contact(
    rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate, c, d,
    q, s, x1, v1, stop, k,
):  # fmt: skip
    """Follow a contact from (q = sqrt(z), s, x1, v1) to its release or for the time `stop` [s].

    c, d: cos and sin of the forcing's phase at the start; steps: `Steps`; `limit_log`, `energy`,
    `impacts` and `tangent` are buffers or None; `sign` is -1 for a wall that pushes
    towards -x2, for which state and phase are mirrored. Returns (event, q, s, x1, v1, elapsed [s],
    depth [m]) with event RELEASED, STOPPED or EXHAUSTED (too many steps); the depth is that
    reached only if `impacts` is there.
    """
    # hot: once per impact, and part of the text of `orbit`
    k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], k[rk.Y + 4] = q, s, x1, v1, 0.0
    elapsed, depth, seen, cube, root = 0.0, 0.0, -1.0, 0.0, 0.0
    # The way so far in free impacts, what is left of its shares of doubt, and how much finer steps
    # are than `steps` says.
    way, saved, finer = 0.0, 0.0, 1.0
    part = VERIFIED if steps.tolerance < math.inf else 1.0
    damping = damping_of(wall)
    pushes = pushes_at(damping, s)
    begin_along(tangent, k)
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(tangent, ps, damper, wall, rate, c, k)
            c, d = rotated(c, d, ps.omega * elapsed)
        # The step h of theta resolves the free impact of this depth and speed, the external
        # acceleration, and the rates of all other motion over the way that q can go.
        external = external_acceleration(ps, damper, wall, c, k)
        q, s = k[rk.Y], k[rk.Y + 1]
        reach = reach_of(wall, q, depth_of(wall, q), s)  # of Hertz' law, q^2.5 where it turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers are dear: a new one if it has changed
            cube, root = turn_of(wall, reach)
            seen = reach
        span = min(root, 2.0 * max(q, root_of(wall, abs(s) / rate)))  # of q: others may stop it
        swing = max(ps.omega, part * rate) * weight_of(wall, span)
        rate_squared = wall.kappa * cube + pressed(wall, external) + swing * swing
        per_theta = math.sqrt(rate_squared) / whole_of(wall)  # free impacts
        late = 1.0 + way / LONG
        h = 1.0 / (per_theta * steps.per_impact * finer * math.sqrt(math.sqrt(math.sqrt(late))))
        # Step to the release, to the end of the time or by h, until it ends inside the contact and
        # no more of it is doubted than is granted.
        landing, stopped, inside, doubt, share = False, False, False, 0.0, 0.0
        now = acting(damping, wall, pushes)
        for attempt in range(MOST_ATTEMPTS):
            landing, stopped, taken = advance(
                rk4, tangent, ps, damper, now, c, d, external, stop - elapsed, h, k
            )
            inside = landing or k[rk.NEW] > 0.0
            if inside:
                share = max(saved + steps.tolerance * (h * per_theta) / late, ROUND_OFF)
                doubt = doubt_of(rk4, now, seen, depth_of(wall, root), taken, k)
                if not doubt > share or attempt > MOST_REPEATS:
                    break
                less = shrunk_by(doubt, share)
                if landing:  # by a step in theta that does not land
                    h = min(h, -q / (0.6 * way_of_step(wall, 1.0, s)))
                h *= less
                finer = min(finer / less, MOST_FINER)
            else:
                h *= 0.5
        if not inside:
            break
        if steps.tolerance < math.inf:
            way, saved = way + h * per_theta, max(share - doubt, 0.0)
        switches, taken = up_to_switch(
            damping, rk4, tangent, ps, damper, wall, pushes, c, d, landing, taken, k
        )
        # Note what the step has shown.
        depth = noted(
            sign, limit_log, energy, impacts, rk4, ps, damper, now, c, d, landing, taken,
            k, elapsed, depth,
        )  # fmt: skip
        elapsed += k[rk.NEW + 4]
        keep_along(tangent, damping, rk4, taken, k)
        # End here, or go on from row NEW.
        pushes = pushes != switches
        if landing and not switches:
            return RELEASED, 0.0, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        if stopped and not switches:
            q = k[rk.NEW]
            depth = max(depth, depth_of(wall, q))
            return STOPPED, q, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        c, d = rotated(c, d, ps.omega * k[rk.NEW + 4])
        for i in range(rk.WIDTH):
            k[rk.Y + i] = k[rk.NEW + i]
        k[rk.Y + 4] = 0.0
    return EXHAUSTED, k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], elapsed, depth
