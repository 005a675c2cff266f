"""A limit of the spring's shortening r at a contact, inside which it is watched as in flight.

In a contact with the far wall r is at most -gap: wherever that is within the limit, there is
nothing to watch. A contact in which the limit may be passed is stepped (`may_pass`).
"""

from __future__ import annotations

import math

from ..numerics.compiling import jit
from ..scene.drive import most_push
from ..scene.law import root_of, stored
from ..scene.scene import moved_mass, scale_of
from .observe import BEYOND, LIMIT, ORIGIN


@jit
def begin_contact(limit_log, sign, gap, time):
    """Let the log count from the `time` [s] of a contact; at the far wall r is at most -gap."""
    if limit_log is not None:
        limit_log[ORIGIN] = time
        if sign < 0.0 and -gap <= limit_log[LIMIT]:
            limit_log[BEYOND] = 0.0


@jit
def may_pass(side, limit_log, phase, duration, touch):
    """Tell whether r may be beyond the limit in a contact of a `duration` [s] from its touch.

    phase: an instant of it (`drive`); touch: (s, x1, v1), as the wall sees it; the energy there
    bounds the depth.
    """
    ps, wall = side.ps, side.wall
    s, x1, v1 = touch
    if side.sign < 0.0:
        return -wall.gap > limit_log[LIMIT]
    scale = scale_of(ps, side.damper, x1, v1, wall.gap, s)
    scale += most_push(ps, phase) * math.sqrt(moved_mass(ps, side.damper)) * duration
    room = limit_log[LIMIT] - wall.gap
    return room <= 0.0 or 2.0 * stored(wall, wall.K, room, root_of(wall, room)) <= scale * scale
