"""A contact that is stepped, as the time loop asks for it: mirrored, with what goes along.

A wall that pushes towards -x2 sees state, phase and load mirrored: eq. (5) is odd.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..scene.arguments import side_with
from ..scene.by_law import by_wall
from ..scene.drive import mirrored
from ..scene.scene import mirrored_load
from .contact import contact


@jit
def as_seen(side, now, phase):
    """Return a side, a state (q, s, x1, v1) and a phase as the wall sees them.

    A wall that pushes towards -x2 sees them mirrored, and the constant load.
    """
    ps, sign = mirrored_load(side.ps.load, side.ps, side.sign), side.sign
    seen = side_with(side, ps, side.damper, side.wall, side.steps)
    return seen, mirrored_start(sign, now), mirrored(phase, sign)


@jit
def mirrored_start(sign, now):
    """Return a state (q, s, x1, v1) mirrored by a sign."""
    return now[0], sign * now[1], sign * now[2], sign * now[3]


@by_wall
def follow(side, watch, phase, place, left, now):
    """Follow a contact from `now` = (q, s, x1, v1) to its release or for the time `left` [s].

    phase: (cos, sin) of the forcing's; place: share of the period that is over; `Watch` and result
    (event, q, s, x1, v1, elapsed, depth) as of `contact`.
    """
    return stepped(side, watch, phase, left, now)


@jit
def stepped(side, watch, phase, left, now):
    """Follow a contact by steps (arguments and result of `follow`)."""
    seen, start, wave = as_seen(side, now, phase)
    return mirrored_back(side, contact(seen, watch, wave, start, left))


@jit
def mirrored_back(side, result):
    """Return a result of `contact` with the state as it is, not as the wall sees it."""
    event, q, s, x1, v1, took, depth = result
    return event, q, side.sign * s, side.sign * x1, side.sign * v1, took, depth
