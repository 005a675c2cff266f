"""A motion on a wall that is linear, followed piece by piece to what ends it.

A wall that is pressed, one that is left without a force, a damper that sticks: each is exact like
a flight, on a grid of its own, and each ends where something that is a polynomial in every piece
rises to a level. That place is certified as a touch is.
"""

from __future__ import annotations

import math

from ..motion.bounds import SHORT, rate_of
from ..motion.flight import at, grid_with
from ..motion.load_cells import Stretch, grid_under, phase_during, polynomial_from
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.by_law import by_wall
from ..scene.codes import EXHAUSTED, STOPPED
from ..scene.scene import joined
from .response import watch_piece
from .touch import LOST, first_touch, tightened


@by_wall(needed=True)
def ending(motion, side, w, phase, end):
    """Return (event, place) of what first ends a motion in [0, end] of a piece, NOWHERE, or LOST.

    w: the table with the polynomial of the piece; phase: the instant of its start. What is found
    needs only so much of the polynomial as the law of the wall knows of.
    """


@by_wall
def note_piece(motion, side, watch, grid, phase, begin, end):
    """Note what is watched of [0, end] of a piece (arguments of `watch_piece`)."""
    watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)


@jit
def walk(motion, side, watch, phase, place, left, y):
    """Follow a motion from the state y = (x1, v1, r, s) to its end, or for a time `left` [s].

    motion: a tuple of the law of the wall, with a `grid` of bare rows; phase and place: the instant
    of y, and the share of the period that is over. Returns (event, y, time [s]): the event of
    `ending`, STOPPED, or EXHAUSTED.
    """
    grid, w, took = motion.grid, motion.grid.table, 0.0
    while True:
        # the next piece, to the end of a cell or of the time
        end = min(1.0, (left - took) / grid.h)
        then = phase_during(side.ps, grid, phase, place, took)
        polynomial_from(grid, y, then)
        event, where = ending(motion, side, w, then, end)
        if where == LOST:
            return EXHAUSTED, y, took
        piece = min(where, end)
        z = at(w, piece)
        note_piece(motion, side, watch, grid, then, took / grid.h, piece)
        y, took = z, min(took + piece * grid.h, left)
        if where <= end and took < left:
            return event, y, took
        if end < 1.0 or took >= left:
            return STOPPED, y, left


@jit
def first_rise(rows, end, level):
    """Return the first place up to `end` where the r of some rows rises to a level (`touch`)."""
    bend, jerk = tightened(rows, math.inf, math.inf)
    return first_touch(rows, 0.0, end, 1.0, level, bend, jerk)


@jit
def local_grid(ps, damper, begun):
    """Return a grid of which only the motion over a cell is known, not the phases of a period."""
    rate = rate_of(ps, joined(damper))
    if is_a(begun, Stretch):
        h = SHORT / max(rate, SHORT / begun.h)
        return grid_under(ps, damper, h, 1, begun)
    return grid_with(ps, damper, SHORT / rate, 1, 0, begun)
