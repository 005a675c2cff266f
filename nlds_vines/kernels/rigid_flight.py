"""Flight between rigid walls, where impacts take no time, so that flights are what an orbit costs.

From cell to cell a state waits for the one before. Over a span of some cells the powers of a
cell's matrix give all the states from the first one, and a processor works on them at once. And
after an impact the cell ends as it would have without one, but for what becomes of the jump of v1
and s: no new polynomial is needed.

From `Grid.powers` on the table of such a grid has for each power: the matrix (16 numbers), column
by column, and what cos and sin of the phase at the start of the span, and a load, add (4 each).
From UNSTRUCK on it has of the last touch how its cell would have ended without it (4), v1 and s
there, and 1 while that holds.
"""

from __future__ import annotations

import numpy as np

from .compiling import jit
from .elementary import cos_sin_of_turn
from .flight import CELLS, STEP, TAYLOR, TERMS, grid_from, response_to, with_table
from .fours import four_at, number_of
from .once_rounded import after_cell, put_sum, put_sum_of_load

SPAN, LONG_SPAN = 4, 12  # cells of a span, in general and between rigid walls
POWER = 28  # numbers of a power
UNSTRUCK = LONG_SPAN * POWER  # after the powers: what is noted of the last touch, 7 numbers


# ---- the grid ------------------------------------------------------------------------------------


@jit
def with_powers(grid):
    """Return a grid as it is, with the powers of its cells' matrix."""
    first = len(grid.table)
    w, push, y = np.zeros(first + UNSTRUCK + 8), np.zeros(12), np.zeros(4)
    w[:first] = grid.table
    put_sum(grid.table, TAYLOR + 4 * TERMS, push, 0)
    put_sum(grid.table, TAYLOR + 5 * TERMS, push, 4)
    put_sum_of_load(grid.load, grid.table, push, 8)
    turned, across = cos_sin_of_turn(grid.turn)
    for i in range(7):
        # what becomes of one of x1, v1, r, s, cos, sin and the load
        for c in range(4):
            y[c] = 1.0 if i == c else 0.0
        cosine, sine = 1.0 if i == 4 else 0.0, 1.0 if i == 5 else 0.0
        load = 1.0 if i == 6 else 0.0
        for k in range(LONG_SPAN):
            x1, v1, r, s = y[0], y[1], y[2], y[3]
            for c in range(4):
                free = (w[STEP + c] * x1 + w[STEP + 4 + c] * v1) + (
                    w[STEP + 8 + c] * r + w[STEP + 12 + c] * s
                )
                y[c] = free + (push[c] * cosine + push[4 + c] * sine + push[8 + c] * load)
                w[first + POWER * k + 4 * i + c] = y[c]
            cosine, sine = cosine * turned - sine * across, sine * turned + cosine * across
    return with_table(grid, w, None, first)


@jit
def grid_of_spans(ps, damper, n, begun):
    """Prepare one period of flight in `n` cells, whose spans are computed from their starts."""
    return with_powers(grid_from(ps, damper, n, begun))


# ---- a cell of a span ----------------------------------------------------------------------------


@jit
def span_of(powers):
    """Return for how many cells one bound of the motion is used: it costs a square root."""
    if powers is None:
        return SPAN
    return LONG_SPAN


@jit
def in_span(powers, low, load, damper, w, start, j, y):
    """Return the state at the end of cell j, at whose beginning it is y.

    start: the first cell of its span, and the state at that one's beginning.
    """
    if powers is None:
        return after_cell(low, damper, w, j, y)
    return from_start(powers, low, load, damper, w, start, j, y)


@jit
def from_start(powers, low, load, damper, w, start, j, y):
    """Return the state at the end of cell j from that at the start of its span."""
    first, (x1, v1, r, s) = start
    k, at_cell = powers + POWER * (j - first), CELLS + 6 * first
    forced = four_at(w, k + 16) * w[at_cell + 4] + four_at(w, k + 20) * w[at_cell + 5]
    y = (four_at(w, k) * x1 + four_at(w, k + 4) * v1) + (
        four_at(w, k + 8) * r + four_at(w, k + 12) * s
    )
    y = y + with_load(load, w, k, forced)
    return number_of(y, 0), number_of(y, 1), number_of(y, 2), number_of(y, 3)


@jit
def with_load(load, w, k, forced):
    """Add what a constant load does in a power, where there is one."""
    if load is None:
        return forced
    return forced + four_at(w, k + 24)


# ---- the cell of an impact -----------------------------------------------------------------------


@jit
def note_end(powers, w, y):
    """Note with which state y a cell would have ended whose flight touches."""
    if powers is None:
        return None
    i = powers + UNSTRUCK
    w[i], w[i + 1], w[i + 2], w[i + 3] = y


@jit
def note_speeds(powers, w, y):
    """Note the speeds of the state y of a touch whose `note_end` is done."""
    if powers is None:
        return None
    i = powers + UNSTRUCK
    w[i + 4], w[i + 5], w[i + 6] = y[1], y[3], 1.0


@jit
def unless_at_once(powers, w, took):
    """Forget how the cell would have ended where a contact took time [s]."""
    if powers is None:
        return None
    if took > 0.0:
        w[powers + UNSTRUCK + 6] = 0.0


@jit
def knows_end(powers, w):
    """Tell whether it is known how the cell would have ended without the impact just before."""
    if powers is None:
        return False
    return w[powers + UNSTRUCK + 6] > 0.0


@jit
def after_jump(powers, w, x, y):
    """Return the state at the end of the cell, x cells after the state y that an impact left."""
    if powers is None:
        return y
    return with_jump(powers, w, x, y)


@jit
def with_jump(powers, w, x, y):
    """Return the end without the impact, and what has become of the jump of v1 and s."""
    i = powers + UNSTRUCK
    jump = response_to(w, x, 1) * (y[1] - w[i + 4]) + response_to(w, x, 3) * (y[3] - w[i + 5])
    y = four_at(w, i) + jump
    return number_of(y, 0), number_of(y, 1), number_of(y, 2), number_of(y, 3)
