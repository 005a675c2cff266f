"""A contact that is stepped, as the time loop asks for it: mirrored, with what goes along.

A wall that pushes towards -x2 sees state, phase and load mirrored: eq. (5) is odd.
"""

from __future__ import annotations

import math

from ..motion.driven import Driven, constants_of
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.arguments import Watch, side_with
from ..scene.by_law import by_wall
from ..scene.codes import RELEASED
from ..scene.drive import mirrored
from ..scene.law import by_root_of, smoothed
from ..scene.scene import mirrored_load
from .contact import contact


@jit
def as_seen(side, now, phase):
    """Return a side, a state (q, s, x1, v1) and a phase as the wall sees them.

    A wall that pushes towards -x2 sees them mirrored, and the constant load.
    """
    ps, sign = mirrored_load(side.ps.load, side.ps, side.sign), side.sign
    seen = side_with(side, ps, side.damper, side.wall, side.steps)
    return seen, turned(sign, now), mirrored(phase, sign)


@jit
def turned(sign, now):
    """Return a state (q, s, x1, v1) mirrored by a sign."""
    return now[0], sign * now[1], sign * now[2], sign * now[3]


@by_wall
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    phase: (cos, sin) of the forcing's; place: share of the period that is over; `Watch` and result
    (event, q, s, x1, v1, elapsed, depth) as of `contact`.
    """
    if is_a(watch.tangent, Driven):
        return step_driven(side, watch, phase, left, now)
    seen, start, wave = as_seen(side, now, phase)
    result = contact(seen, watch, wave, start, left)
    tally_stepped(seen, watch.tally, wave, start, result)
    return mirrored_back(side, result)


@jit
def mirrored_back(side, result):
    """Return a result of `contact` with the state as it is, not as the wall sees it."""
    event, q, s, x1, v1, took, depth = result
    return event, q, side.sign * s, side.sign * x1, side.sign * v1, took, depth


@jit
def step_driven(side, watch, phase, left, now):
    """Step a contact whose variations are driven by parameters; arguments and result of `follow`.

    What a parameter changes of the force may be less smooth at the touch than the force itself. So
    the contact is stepped with another root p of z = q^p, which makes both smooth: q is turned into
    that of the other root before, and back behind.
    """
    seen, start, wave = as_seen(side, now, phase)
    smooth = smoothed(side.wall, watch.tangent, constants_of(side.sign))
    seen = side_with(seen, seen.ps, seen.damper, smooth, seen.steps)
    start = by_root_of(smooth, side.wall, start[0]), start[1], start[2], start[3]
    event, q, s, x1, v1, took, depth = contact(seen, watch, wave, start, left)
    q = by_root_of(side.wall, smooth, q)
    return mirrored_back(side, (event, q, s, x1, v1, took, depth))


@jit
def tally_stepped(seen, tally, phase, start, result):
    """Step a contact once more, for a response, where one is wanted; all as the wall sees it.

    start: (q, s, x1, v1); result: that of `contact`.
    """
    if tally is None:
        return
    left = math.inf if result[0] == RELEASED else result[5]
    contact(seen, Watch(None, tally, None, None, tally, None), phase, start, left)
