"""One contact from touch to release, stepped: any depth, any duration, any external force.

Step sizes come from the Hertz time scale of the motion at hand and from the rates of everything
else, so that soft rubber, steel, a slow pressed touch and a damper resting on its obstacle for many
periods are covered alike.
"""

from __future__ import annotations

import math

from . import runge_kutta as rk
from .codes import EXHAUSTED, RELEASED, STOPPED
from .compiling import jit
from .contact_field import LONGEST_ANGLE, cos_sin, rotated
from .elementary import exp, fifth_root, hypotenuse, log
from .limit import note_limit_step
from .observe import note_step
from .roots import guarded
from .scene import accelerations

WHOLE = 5.607  # theta from touch to release of a free impact, times sqrt(kappa) q_m^(3/2)
MOST_STEPS = 1_000_000  # steps of one contact between two sections: beyond it, EXHAUSTED
MOST_HALVINGS = 60  # of a step that left the contact; numbers beyond all bounds need more
FAINT = 1.0e-16  # Hertz acceleration, as a share of the external one, that is round-off
SOON = 1.0e-5  # time in units of 1/rate for which an external acceleration is constant


@jit
def start_at_rest(tangent, ps, damper, wall, rate, c, k):
    """Move row Y past a touch without speed, which theta alone could not leave; return the time.

    Under an external acceleration a the depth grows as a t^2 / 2; until the Hertz force or a change
    of a is felt at round-off, that is exact. c: cos of the phase.
    """
    q, s, x1, v1 = k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3]
    dv, external = accelerations(ps, damper, x1, v1, wall.gap + q * q, s, c, 0.0)
    if external <= 0.0 or s < 0.0:
        return 0.0
    depth = exp(2.0 / 3.0 * log(FAINT * external / wall.kappa))  # to the power of two thirds
    soon = SOON / rate
    depth = min(depth, 0.5 * external * soon * soon)
    if q * q + 0.5 * s * s / external >= depth:
        return 0.0
    speed = math.sqrt(2.0 * external * depth)
    t = (speed - s) / external
    k[rk.Y], k[rk.Y + 1] = math.sqrt(depth), speed
    k[rk.Y + 2], k[rk.Y + 3] = x1 + t * (v1 + 0.5 * t * dv), v1 + t * dv
    if tangent is not None:
        for i in range(rk.WIDTH + rk.Y, rk.WIDTH + rk.Y + rk.TANGENT, 4):
            k[i] += t * k[i + 1]
            k[i + 2] += t * k[i + 3]
    return t


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
        guess = size + miss / q if q > 0.0 else low
        size = guarded(guess, low, high)
    return size


@jit
def deepest(rk4, ps, damper, wall, c, d, h, k):
    """Return the greatest depth [m] within a step h over which s changes sign from + to -.

    A secant finds s = 0 but for an error e, and a parabola from there the depth but for e^3, which
    is less than the step errs by. Row NEW is lost.
    """
    s0 = k[rk.Y + 1]
    rk.step(rk4, None, ps, damper, wall, c, d, False, h * s0 / (s0 - k[rk.NEW + 1]), k)
    q, s, x1, v1 = k[rk.NEW], k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3]
    cosine, sine = cos_sin(ps.omega * k[rk.NEW + 4])
    z, drive = q * q, c * cosine - d * sine
    _, ds = accelerations(ps, damper, x1, v1, wall.gap + z, s, drive, wall.K * z * q)
    return z - 0.5 * s * s / ds if ds < 0.0 else z


@jit
def external_acceleration(ps, damper, wall, c, k):
    """Return d2r/dt2 [m/s^2] of row Y without the Hertz force, at phase cosine c."""
    q = k[rk.Y]
    r = wall.gap + q * q
    _, ds = accelerations(ps, damper, k[rk.Y + 2], k[rk.Y + 3], r, k[rk.Y + 1], c, 0.0)
    return ds


@jit
def near_release(external, h, k):
    """Tell whether the release is near and certain enough for a step in q that lands on z = 0."""
    q, s = k[rk.Y], k[rk.Y + 1]
    return s < 0.0 and -2.0 * q >= 1.2 * h * s and s * s > 4.0 * external * q * q


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
        note_step(rk4, ps, damper, wall, energy, c, d, landing, h, k)
    if impacts is not None and k[rk.Y + 1] > 0.0 and k[rk.NEW + 1] <= 0.0:
        for i in range(rk.WIDTH):
            k[rk.SAVE + i] = k[rk.NEW + i]
        depth = max(depth, deepest(rk4, ps, damper, wall, c, d, h, k))
        for i in range(rk.WIDTH):
            k[rk.NEW + i] = k[rk.SAVE + i]
    return depth


@jit(dissolved=True)
def contact(
    rk4, ps, damper, wall, sign, limit_log, energy, impacts, tangent, steps, rate, c, d,
    q, s, x1, v1, stop, k,
):  # fmt: skip
    """Follow a contact from (q = sqrt(z), s, x1, v1) to its release or for the time `stop` [s].

    c, d: cos and sin of the forcing's phase at the start; `steps` per free impact; `limit_log`,
    `energy`, `impacts` and `tangent` are buffers or None; `sign` is -1 for a wall that pushes
    towards -x2, for which state and phase are mirrored. Returns (event, q, s, x1, v1, elapsed [s],
    depth [m]) with event RELEASED, STOPPED or EXHAUSTED (too many steps); the depth is that
    reached only if `impacts` is there.
    """
    # hot: once per impact, and part of the text of `orbit`
    k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], k[rk.Y + 4] = q, s, x1, v1, 0.0
    elapsed, depth, seen, cube, root = 0.0, 0.0, -1.0, 0.0, 0.0
    if tangent is not None:
        for i in range(rk.TANGENT):
            k[rk.Y + rk.WIDTH + i] = tangent[i]
    for count in range(MOST_STEPS):
        if count == 0:
            elapsed = start_at_rest(tangent, ps, damper, wall, rate, c, k)
            c, d = rotated(c, d, ps.omega * elapsed)
        # The step h of theta resolves the free impact of this depth and speed, the external
        # acceleration, and the rates of all other motion over the way that q can go.
        external = external_acceleration(ps, damper, wall, c, k)
        q, s = k[rk.Y], k[rk.Y + 1]
        reach = hypotenuse(q * q * math.sqrt(q), s / wall.speed)  # q^2.5 where the contact turns
        if not 0.95 * seen < reach < 1.05 * seen:  # powers are dear: a new one if it has changed
            fifth = fifth_root(reach)
            seen, cube, root = reach, reach * fifth, fifth * fifth  # reach^1.2, reach^0.4
        span = min(root, 2.0 * max(q, math.sqrt(abs(s) / rate)))  # of q: others may stop it first
        rate_squared = wall.kappa * cube + abs(external) + rate * rate * span * span
        h = WHOLE / steps / math.sqrt(rate_squared)
        h = min(h, LONGEST_ANGLE / (rate * span))
        # A step in q that lands on z = 0 ends the contact, if its release is near.
        landing = near_release(external, h, k)
        if landing:
            rk.step(rk4, tangent, ps, damper, wall, c, d, True, -q, k)
            landing = elapsed + k[rk.NEW + 4] <= stop
        # Otherwise a step in theta, halved until it ends inside the contact ...
        if not landing:
            rk.step(rk4, tangent, ps, damper, wall, c, d, False, h, k)
            for _ in range(MOST_HALVINGS):
                if k[rk.NEW] > 0.0:
                    break
                h *= 0.5
                rk.step(rk4, tangent, ps, damper, wall, c, d, False, h, k)
            if not k[rk.NEW] > 0.0:
                break
        # ... and cut short where the time is over.
        stopped = elapsed + k[rk.NEW + 4] > stop
        if stopped:
            h = step_to_stop(rk4, tangent, ps, damper, wall, c, d, h, stop - elapsed, k)
        # Note what the step has shown.
        taken = -q if landing else h
        depth = noted(
            sign, limit_log, energy, impacts, rk4, ps, damper, wall, c, d, landing, taken,
            k, elapsed, depth,
        )  # fmt: skip
        elapsed += k[rk.NEW + 4]
        if tangent is not None:
            for i in range(rk.TANGENT):
                tangent[i] = k[rk.Y + rk.WIDTH + i] = k[rk.NEW + rk.WIDTH + i]
        # End here, or go on from row NEW.
        if landing:
            return RELEASED, 0.0, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        if stopped:
            q = k[rk.NEW]
            depth = max(depth, q * q)
            return STOPPED, q, k[rk.NEW + 1], k[rk.NEW + 2], k[rk.NEW + 3], elapsed, depth
        c, d = rotated(c, d, ps.omega * k[rk.NEW + 4])
        for i in range(rk.WIDTH):
            k[rk.Y + i] = k[rk.NEW + i]
        k[rk.Y + 4] = 0.0
    return EXHAUSTED, k[rk.Y], k[rk.Y + 1], k[rk.Y + 2], k[rk.Y + 3], elapsed, depth
