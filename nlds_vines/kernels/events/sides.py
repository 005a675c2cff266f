"""The two walls of a scene, of one law or of two: the `mode` tells which one is touched."""

from __future__ import annotations

from ..motion.load_cells import Loaded, phase_of
from ..numerics.compiling import jit
from ..numerics.deciding import is_a, same_sort, says
from ..scene.by_law import by_wall
from ..scene.codes import (
    ASTRAY,
    CLEARED,
    EXHAUSTED,
    LEAVING_FAR,
    LEAVING_NEAR,
    RETURNED,
    SECTION,
    STOPPED,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from ..scene.law import depth_of, force_at
from ..scene.scene import Ground
from ..watch.observe import BEYOND, LIMIT, ORIGIN
from .contact import follow


@jit
def structure_at(damper, x1, v1, r, s):
    """Return (x1, v1), which are r and s where walls limit the structure itself."""
    # of two that are integrated side by side, round-off must not make two
    if is_a(damper, Ground):
        return (r, s)
    return (x1, v1)


# ---- a contact -----------------------------------------------------------------------------------


@jit
def follow_at(near, far, mode, watch, begun, left, now):
    """Follow a contact at the side of the `mode`, near or far; a side that is not there is None.

    Arguments and result as of `follow_side`.
    """
    if near is None:
        return follow_side(far, watch, begun, left, now)
    if far is None:
        return follow_side(near, watch, begun, left, now)
    if same_sort(near, far):  # one text for both
        side = near if mode == TOUCH_NEAR else far
        return follow_side(side, watch, begun, left, now)
    if mode == TOUCH_NEAR:
        return follow_side(near, watch, begun, left, now)
    return follow_side(far, watch, begun, left, now)


@jit
def follow_side(side, watch, begun, left, now):
    """Follow a contact to its release or for the time `left` [s].

    begun: its time [s], the instant (`drive`), and the share of the period that is over; now: (q,
    s, x1, v1). Returns (event, q, (x1, v1, r, s), time [s], (depth [m], greatest force [N])).
    """
    wall, (time, phase, place) = side.wall, begun
    # The log of a limit counts from the touch; at the far wall r is at most -gap.
    if watch.limit_log is not None:
        watch.limit_log[ORIGIN] = time
        if side.sign < 0.0 and -wall.gap <= watch.limit_log[LIMIT]:
            watch.limit_log[BEYOND] = 0.0
    event, q, s, x1, v1, took, depth = follow(side, watch, phase, place, left, now)
    r = side.sign * (wall.gap + depth_of(wall, q))
    x1, v1 = structure_at(side.damper, x1, v1, r, s)
    return event, q, (x1, v1, r, s), took, (depth, force_at(wall, depth))


# ---- leaving a wall whose force has vanished -----------------------------------------------------


@jit
def may_leave(near, far):
    """Return True if there is a wall that may let go of a damper before it is out."""
    return says(near, "LINEAR") or says(far, "LINEAR")


@jit
def leaves(near, far, mode):
    """Return True if an orbit that is not FLYING leaves a wall whose force has vanished."""
    return may_leave(near, far) and mode in (LEAVING_NEAR, LEAVING_FAR)


@by_wall
def leave(side, watch, phase, place, left, now):
    """Fly from a depth at which the wall does not push, to z = 0 or for the time `left` [s].

    Arguments as of `follow_at`. Returns (event, q, s, x1, v1, time [s]): CLEARED at z = 0, RETURNED
    where the wall pushes again before, STOPPED or EXHAUSTED.
    """
    return CLEARED, now[0], now[1], now[2], now[3], 0.0


@jit
def leave_wall(near, far, mode, watch, grid, stop, begun, now):
    """Leave the place of a contact whose force has vanished, at the side of the `mode`.

    begun: (cell, place in it); now: (q, x1, v1, r, s). Returns (event, j, x, q, x1, v1, r, s):
    CLEARED where no wall is in the way any more, otherwise as a flight.
    """
    (q, x1, v1, r, s), (j, x) = now, begun
    place, left, inner = (j + x) / grid.n, (stop - j - x) * grid.h, (q, s, x1, v1)
    event, took, gap, sign = CLEARED, 0.0, 0.0, 1.0
    phase = phase_of(grid, j, x) if is_a(grid.begun, Loaded) else None
    if near is not None and mode == LEAVING_NEAR:
        event, q, s, x1, v1, took = leave(near, watch, phase, place, left, inner)
        gap = near.wall.gap
    if far is not None and mode == LEAVING_FAR:
        event, q, s, x1, v1, took = leave(far, watch, phase, place, left, inner)
        gap, sign = far.wall.gap, -1.0
    at_place = j + x + took / grid.h
    r = sign * (gap + q)
    if near is not None:
        x1, v1 = structure_at(near.damper, x1, v1, r, s)
    else:
        x1, v1 = structure_at(far.damper, x1, v1, r, s)
    j = min(int(at_place), stop - 1)
    x = at_place - j
    if event == EXHAUSTED:
        return ASTRAY, j, x, q, x1, v1, r, s
    if event == STOPPED:
        return SECTION, stop, 0.0, q, x1, v1, r, s
    if event == RETURNED:
        event = TOUCH_NEAR if mode == LEAVING_NEAR else TOUCH_FAR
    return event, j, x, q, x1, v1, r, s
