"""Where a step of a contact ends, and what is found within it: all on the step's own polynomial.

Its end is the release, an instant that is asked for, or the place where the force becomes another
function (`law.switching`). Within it is the deepest point.
"""

from __future__ import annotations

from ..motion.taylor import advance, part_of, restore, set_aside, to_release
from ..numerics.compiling import jit
from ..numerics.roots import guarded, narrowed, secant
from ..scene.arguments import Step
from ..scene.contact_series import NEW, OLD
from ..scene.drive import after, drive_now
from ..scene.law import (
    depth_of,
    force_of,
    rate_of_switching,
    switching,
    weight_of,
)
from ..scene.scene import accelerations

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
    low, high, found = 0.0, 1.0, 0.0
    x = k[OLD + 1] / (k[OLD + 1] - k[NEW + 1])
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
    way = 1.0 if positive else -1.0
    reach = 2.0 * a * max(abs(f0), abs(f1)) * k[NEW + 4]
    least = min(margin(side, positive, int(OLD)), margin(side, positive, int(NEW)))
    if not (way * f0 < 0.0 and way * f1 > 0.0 and least < reach):
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
