"""Cells of a span, each computed from the state at the start of the span.

From cell to cell a state waits for the one before. Over a span of a few cells the powers of a
cell's matrix give all the states from the first one, so that a processor works on them at once.
This is done where impacts take no time; elsewhere contacts cost so much that it would not show.

From `Grid.powers` on the table of such a grid has for each power: the matrix (16 numbers), column
by column, and what cos and sin of the phase at the start of the span, and a load, add (4 each).
"""

from __future__ import annotations

import numpy as np

from .compiling import chosen, jit
from .elementary import cos_sin_of_turn
from .flight import CELLS, STEP, TAYLOR, TERMS, Grid, grid_of
from .fours import four_at, number_of
from .once_rounded import after_cell, put_sum, put_sum_of_load

SPAN = 4  # cells of a span, for which one bound of the motion is used: it costs a square root
POWER = 28  # numbers of a power


@jit
def with_powers(grid):
    """Return a grid as it is, with the powers of its cells' matrix."""
    first = len(grid.table)
    w, push, y = np.zeros(first + SPAN * POWER), np.zeros(12), np.zeros(4)
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
        for k in range(SPAN):
            x1, v1, r, s = y[0], y[1], y[2], y[3]
            for c in range(4):
                free = (w[STEP + c] * x1 + w[STEP + 4 + c] * v1) + (
                    w[STEP + 8 + c] * r + w[STEP + 12 + c] * s
                )
                y[c] = free + (push[c] * cosine + push[4 + c] * sine + push[8 + c] * load)
                w[first + POWER * k + 4 * i + c] = y[c]
            cosine, sine = cosine * turned - sine * across, sine * turned + cosine * across
    return Grid(
        grid.n, grid.h, grid.turn, grid.rate, grid.push, grid.bend, w, grid.load, None, first
    )  # fmt: skip


@jit
def grid_of_spans(ps, damper, n):
    """Prepare one period of flight in `n` cells, whose spans are computed from their starts."""
    return with_powers(grid_of(ps, damper, n))


@chosen
def in_span(powers, low, load, damper, w, start, j, y):
    """Return the state at the end of cell j, at whose beginning it is y.

    start: the first cell of its span, and the state at that one's beginning.
    """
    if powers is None:
        return lambda powers, low, load, damper, w, start, j, y: after_cell(low, damper, w, j, y)
    return from_start


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


@chosen
def with_load(load, w, k, forced):
    """Add what a constant load does in a power, where there is one."""
    if load is None:
        return lambda load, w, k, forced: forced
    return lambda load, w, k, forced: forced + four_at(w, k + 24)
