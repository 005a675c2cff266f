"""What differs by the laws of the walls, for the time loop: each scene has but its own.

The two walls of a scene may be of different sorts; the `mode` tells which one is touched.
"""

from __future__ import annotations

import math

from .codes import (
    ASTRAY,
    CLEARED,
    EXHAUSTED,
    FLYING,
    LEAVING_FAR,
    LEAVING_NEAR,
    RETURNED,
    SECTION,
    STOPPED,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from .compiling import chosen, is_a, jit, same_sort
from .driven import Driven
from .elastic_contact import follow_contact, follow_driven
from .force_law import at_depth, damping_of, depth_of, root_of
from .linear_contact import leave, press
from .restitution import rebound
from .scene import Ground, LinearWall, RigidWall, Wall

ROUND_OFF = 4.0e-15  # of a place that was computed from two positions


@chosen
def pushes(wall, q, s):
    """Tell whether a wall pushes a damper that is beyond the place of touch."""
    if not is_a(wall, LinearWall):
        return lambda wall, q, s: True
    return lambda wall, q, s: pulls_too(wall.pulls) or wall.kc * q + wall.cc * s > 0.0


@chosen
def rests(wall, r, s, scale):
    """Tell whether a damper rests on a rigid wall, but for round-off of positions of a `scale`."""
    if is_a(wall, RigidWall):
        return lambda wall, r, s, scale: s == 0.0 and wall.gap - r <= ROUND_OFF * scale
    return lambda wall, r, s, scale: False


@chosen
def pulls_too(pulls):
    """Tell whether a wall holds a damper also by pulling."""
    if pulls is None:
        return lambda pulls: False
    return lambda pulls: True


@chosen
def into(wall, r):
    """Return (q, r) of a state at r > gap: q = sqrt(z), but at a rigid wall it is on the wall."""
    if is_a(wall, RigidWall):
        return lambda wall, r: (0.0, wall.gap)
    return lambda wall, r: (root_of(wall, r - wall.gap), r)


@chosen
def wall_of(near, far, mode):
    """Return the wall that is being touched."""
    if far is None:
        return lambda near, far, mode: near
    if near is None:
        return lambda near, far, mode: far
    return lambda near, far, mode: near if mode == TOUCH_NEAR else far


@chosen
def held_of(near, far, held_near, held_far, mode):
    """Return what is known of the motion on the wall that is touched."""
    if far is None:
        return lambda near, far, held_near, held_far, mode: held_near
    if near is None:
        return lambda near, far, held_near, held_far, mode: held_far
    if held_near is None:
        return lambda near, far, held_near, held_far, mode: None
    return lambda near, far, held_near, held_far, mode: (
        held_near if mode == TOUCH_NEAR else held_far
    )


@jit
def sign_of(mode):
    """Return 1 at the near wall, -1 at the far one."""
    return 1.0 if mode in (TOUCH_NEAR, LEAVING_NEAR) else -1.0


@chosen
def gap_of(near, far, mode):
    """Return the gap [m] of the wall that is touched."""
    if far is None:
        return lambda near, far, mode: near.gap
    if near is None:
        return lambda near, far, mode: far.gap
    return lambda near, far, mode: near.gap if sign_of(mode) > 0.0 else far.gap


@chosen
def depth_at(near, far, mode, q):
    """Return the depth [m] at the wall that is touched."""
    if far is None:
        return lambda near, far, mode, q: depth_of(near, q)
    if near is None:
        return lambda near, far, mode, q: depth_of(far, q)
    return lambda near, far, mode, q: depth_of(near, q) if mode == TOUCH_NEAR else depth_of(far, q)


@chosen
def force_at(wall, depth):
    """Return the greatest force of a contact that was so deep [m]; 0 where it has been noted."""
    if is_a(wall, RigidWall):
        return lambda wall, depth: math.inf
    if is_a(wall, LinearWall):
        return lambda wall, depth: 0.0
    return lambda wall, depth: force_unless_damped(damping_of(wall), wall, depth)


@chosen
def force_unless_damped(damping, wall, depth):
    """Return the elastic force [N] at a depth [m]; 0 where damping makes another the greatest."""
    if damping is None:
        return lambda damping, wall, depth: at_depth(wall, wall.K, depth)
    return lambda damping, wall, depth: 0.0


@chosen
def force_in(near, far, mode, depth):
    """Return `force_at` at the wall that is touched."""
    if far is None:
        return lambda near, far, mode, depth: force_at(near, depth)
    if near is None:
        return lambda near, far, mode, depth: force_at(far, depth)
    return lambda near, far, mode, depth: (
        force_at(near, depth) if mode == TOUCH_NEAR else force_at(far, depth)
    )


@chosen
def structure_at(damper, x1, v1, r, s):
    """Return (x1, v1), which are r and s where walls limit the structure itself."""
    # of two that are integrated side by side, round-off must not make two
    if is_a(damper, Ground):
        return lambda damper, x1, v1, r, s: (r, s)
    return lambda damper, x1, v1, r, s: (x1, v1)


# ---- a contact -----------------------------------------------------------------------------------


@chosen
def follow_by_law(
    rk4, ps, damper, wall, sign, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held, place,
):  # fmt: skip
    """Follow a contact by the law of its wall."""
    # hot: as `follow_contact`
    if is_a(wall, RigidWall):
        return rebound
    if is_a(wall, LinearWall):
        return press
    return follow_driven if is_a(tangent, Driven) else follow_contact


@chosen
def arc_of(wall, arc):
    """Return the arc of Hertz impacts for a wall of that law, None for any other."""
    if is_a(wall, Wall):
        return lambda wall, arc: arc
    return lambda wall, arc: None


@jit
def follow_at_one(
    rk4, ps, damper, near, far, mode, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held_near, held_far, place,
):  # fmt: skip
    """Follow a contact at a wall, where all are of one sort."""
    # hot: as `follow_contact`
    wall, held = wall_of(near, far, mode), held_of(near, far, held_near, held_far, mode)
    return follow_by_law(
        rk4, ps, damper, wall, sign_of(mode), arc_of(wall, arc), limit_log, energy, impacts,
        tangent, steps, rate, phase, left, now, k, held, place,
    )  # fmt: skip


@jit
def follow_at_two(
    rk4, ps, damper, near, far, mode, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held_near, held_far, place,
):  # fmt: skip
    """Follow a contact at a wall, where the two are of different sorts."""
    # hot: as `follow_contact`
    if mode == TOUCH_NEAR:
        return follow_by_law(
            rk4, ps, damper, near, 1.0, arc_of(near, arc), limit_log, energy, impacts,
            tangent, steps, rate, phase, left, now, k, held_near, place,
        )  # fmt: skip
    return follow_by_law(
        rk4, ps, damper, far, -1.0, arc_of(far, arc), limit_log, energy, impacts,
        tangent, steps, rate, phase, left, now, k, held_far, place,
    )  # fmt: skip


@chosen
def follow_at(
    rk4, ps, damper, near, far, mode, arc, limit_log, energy, impacts, tangent, steps, rate,
    phase, left, now, k, held_near, held_far, place,
):  # fmt: skip
    """Follow a contact at the wall of the `mode`."""
    # hot: as `follow_contact`
    if near is None or far is None or same_sort(near, far):
        return follow_at_one
    return follow_at_two


# ---- leaving a wall whose force has vanished -----------------------------------------------------


@chosen
def leaves(near, far, mode):
    """Tell whether an orbit that is not FLYING leaves a wall whose force has vanished."""
    if is_a(near, LinearWall) or is_a(far, LinearWall):
        return lambda near, far, mode: mode in (LEAVING_NEAR, LEAVING_FAR)
    return lambda near, far, mode: False


@chosen
def depth_of_touch(near, far, mode, q):
    """Return q of a touch: 0, but where a wall pushes again that has been left."""
    if is_a(near, LinearWall) or is_a(far, LinearWall):
        return lambda near, far, mode, q: 0.0 if mode == FLYING else q
    return lambda near, far, mode, q: 0.0


@chosen
def after_release(near, far, mode, q):
    """Return what an orbit does after the contact of a `mode`: fly, or first leave its place."""
    if not (is_a(near, LinearWall) or is_a(far, LinearWall)):
        return lambda near, far, mode, q: FLYING
    return leaving_if_deep


@jit
def leaving_if_deep(near, far, mode, q):
    """Return the mode after a release; q is 0 where the damper is at the place of touch."""
    if q > 0.0:
        return LEAVING_NEAR if mode == TOUCH_NEAR else LEAVING_FAR
    return FLYING


@chosen
def leave_wall(
    ps, damper, near, far, limit_log, energy, held_near, held_far, mode, grid, stop, j, x, now
):
    """Leave the place of a contact whose force has vanished, if the orbit is there.

    now: (q, x1, v1, r, s). Returns (event, j, x, q, x1, v1, r, s): CLEARED where no wall is in the
    way any more, otherwise as a flight.
    """
    # hot: the arguments of `fly`
    if is_a(near, LinearWall) or is_a(far, LinearWall):
        return leave_if_deep
    return already_clear


@jit
def already_clear(
    ps, damper, near, far, limit_log, energy, held_near, held_far, mode, grid, stop, j, x, now
):
    """Return that no wall is in the way."""
    # hot: the arguments of `fly`
    return CLEARED, j, x, now[0], now[1], now[2], now[3], now[4]


@chosen
def leave_one(ps, damper, wall, sign, limit_log, energy, held, place, left, now):
    """Leave a wall that may let go before the damper is out (`linear_contact.leave`)."""
    # hot: the arguments of `leave`
    if is_a(wall, LinearWall):
        return lambda ps, damper, wall, sign, limit_log, energy, held, place, left, now: leave(
            ps, damper, wall, sign, limit_log, energy, held.loose, held.watched, place, left, now
        )
    return lambda ps, damper, wall, sign, limit_log, energy, held, place, left, now: (
        CLEARED, now[0], now[1], now[2], now[3], 0.0,
    )  # fmt: skip


@jit
def leave_if_deep(
    ps, damper, near, far, limit_log, energy, held_near, held_far, mode, grid, stop, j, x, now
):
    """Leave the wall of the `mode`, if it is one of leaving."""
    # hot: the arguments of `fly`
    if mode == FLYING:
        return CLEARED, j, x, now[0], now[1], now[2], now[3], now[4]
    q, x1, v1, r, s = now
    place, left, inner = (j + x) / grid.n, (stop - j - x) * grid.h, (q, s, x1, v1)
    if mode == LEAVING_NEAR:
        event, q, s, x1, v1, took = leave_one(
            ps, damper, near, 1.0, limit_log, energy, held_near, place, left, inner
        )
    else:
        event, q, s, x1, v1, took = leave_one(
            ps, damper, far, -1.0, limit_log, energy, held_far, place, left, inner
        )
    sign, at_place = sign_of(mode), j + x + took / grid.h
    r = sign * (gap_of(near, far, mode) + q)
    x1, v1 = structure_at(damper, x1, v1, r, s)
    j = min(int(at_place), stop - 1)
    x = at_place - j
    if event == EXHAUSTED:
        return ASTRAY, j, x, q, x1, v1, r, s
    if event == STOPPED:
        return SECTION, stop, 0.0, q, x1, v1, r, s
    if event == RETURNED:
        event = TOUCH_NEAR if mode == LEAVING_NEAR else TOUCH_FAR
    return event, j, x, q, x1, v1, r, s
