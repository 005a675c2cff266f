"""A limit of the spring's shortening r, and how it is kept: in flight and in contact alike.

In a contact with the far wall r is at most -gap: wherever that is within the limit, there is
nothing to watch. A contact in which the limit may be passed is stepped (`may_pass`).
"""

from __future__ import annotations

import math

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.arguments import StepPiece
from ..scene.contact_series import TAU, column_at
from ..scene.drive import most_push
from ..scene.law import contact_energy
from ..scene.scene import moved_mass, scale_of
from .observe import BEYOND, EXCESS, LIMIT, ORIGIN, note_violation
from .touch import LONGEST_WALK, derivatives_at, first_touch, nearest_miss, tightened


@jit
def time_at(piece, begin, x):
    """Return the time [s] of place x of a piece, from where the log of the limit counts.

    begin: cells from there to the piece; where that is a step of a contact, the time [s].
    """
    if is_a(piece, StepPiece):
        return begin + column_at(piece.table, int(TAU), x)
    return (begin + x) * piece.h


@jit
def note_limit(piece, limit_log, begin, end, bend, jerk):
    """Note in `limit_log` how the limit of r is kept over [0, end] of a piece.

    begin: as of `time_at`. Each passage is counted at its place, each excursion beyond measured at
    its summits and where the piece ends.
    """
    w, level, x = piece.table, limit_log[LIMIT], 0.0
    bend, jerk = tightened(w, bend, jerk)
    for _ in range(LONGEST_WALK):
        if limit_log[BEYOND] == 0.0:
            x = first_touch(w, x, end, 1.0, level, bend, jerk)
            if not 0.0 <= x <= end:
                return
            note_violation(limit_log, limit_log[ORIGIN] + time_at(piece, begin, x))
        fall = first_touch(w, x, end, -1.0, -level, bend, jerk)
        stays = not 0.0 <= fall <= end
        best = level + limit_log[EXCESS]
        top = nearest_miss(w, x, 1.0, end if stays else fall, best, bend, jerk, False)
        if stays:
            top = max(top, derivatives_at(w, end, 1.0)[0])
        if top > best:
            limit_log[EXCESS] = top - level
        if stays:
            return
        x, limit_log[BEYOND] = fall, 0.0


# ---- a contact -----------------------------------------------------------------------------------


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
    return room <= 0.0 or 2.0 * contact_energy(wall, room) <= scale * scale
