"""Cells whose end is rounded once, so that errors hardly add up over a long orbit.

The numbers of a cell's matrix are rounded. The motion then grows or shrinks by some 1e-16 in every
cell, always the same way: an undamped oscillator at a linear stop gained 3e-10 of its energy in
100,000 periods. Where contacts are linear, too, nothing else errs so much. There a cell's matrices
have twice the precision, and so has the sum that is the next state, until it is rounded: as likely
up as down.

A number c of a matrix is a head of 26 bits and a tail, a number x of the state x' + x'', each of 26
bits. In c x = head x' + (head x'' + tail x) the first product is exact, and the others are so small
that their rounding does not matter. What a sum of the first ones loses is kept (`two_sum`).

From `Grid.low` on the table of such a grid has four matrices, each of MATRIX_NUMBERS: that of a
whole cell, and what the powers 1 to KEPT_POWERS of the Taylor polynomial are, given the state at
its start. They are stored column by column, four heads and then four tails. Where walls limit the
structure itself, r and s are x1 and v1, and the columns of x1 and v1 are not used. After them, in
plain numbers: what cos, sin and load, four each, have added to the state at the end of a cell.

Numbers of twice the precision are pairs whose second is what the first has lost by rounding: what
a sum or a product of two numbers loses is a number, too (T. J. Dekker, Numer. Math. 18, 224, 1971).
No processor's fused product is asked for: the bits are the same everywhere.
"""

from __future__ import annotations

import numpy as np

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import SPLITTER
from ..numerics.fours import four, four_at, four_of, number_of
from ..scene.scene import Ground
from .flight import CELLS, COEF, ORDER, TAYLOR, TERMS, at, grid_from, pair, step, with_table

MATRIX_NUMBERS = 32  # numbers of a matrix: four columns of eight
# of twice the precision: the fourth is less than 0.4^4 / 4! = 1e-3 of the state
KEPT_POWERS = 3
OF_PUSHES = (KEPT_POWERS + 1) * MATRIX_NUMBERS  # place of what forces add, after the matrices
WHOLE_POWERS = 18  # powers in the matrix of a whole cell: 0.4^19 / 19! = 2e-25


# ---- numbers of twice the precision --------------------------------------------------------------


@jit(inlined=True)
def two_sum(a, b):
    """Return (a + b, what it has lost by rounding) of single numbers or fours."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@jit(inlined=True)
def split(a):
    """Return (head, rest) of a number or a four: a is their sum, and each has 26 bits."""
    large = SPLITTER * a
    head = large - (large - a)
    return head, a - head


@jit(inlined=True)
def two_product(a, b):
    """Return (a b, what it has lost by rounding); a, b: numbers, or one or both of them fours."""
    product = a * b
    (a0, a1), (b0, b1) = split(a), split(b)
    return product, ((a0 * b0 - product) + a0 * b1 + a1 * b0) + a1 * b1


@jit
def plus(a, b):
    """Return the sum of two pairs."""
    total, lost = two_sum(a[0], b[0])
    return two_sum(total, lost + (a[1] + b[1]))


@jit
def times(a, b):
    """Return the product of two pairs."""
    product, lost = two_product(a[0], b[0])
    return two_sum(product, lost + (a[0] * b[1] + a[1] * b[0]))


@jit
def quotient(a, n):
    """Return a / n of single numbers as a pair."""
    first = a / n
    product, lost = two_product(first, n)
    return two_sum(first, ((a - product) - lost) / n)


@jit
def of_bodies(damper, y):
    """Return a state (x1, v1, r, s); where walls limit the structure, (r, s, r, s)."""
    if is_a(damper, Ground):
        return (y[2], y[3], y[2], y[3])
    return y


# ---- the matrices --------------------------------------------------------------------------------


@jit
def next_power(ps, damper, y, g):
    """Return g dy/dt of the motion without forcing and load; y: four pairs, g: a pair.

    The equation is that of `scene.accelerations`.
    """
    x1, v1, r, s = y
    alone = plus(times((-ps.stiffness, 0.0), x1), times((-ps.damping, 0.0), v1))
    push = plus(times((-damper.k2, 0.0), r), times((-damper.c2, 0.0), s))
    dv = plus(alone, times((damper.inv_m1, 0.0), push))
    ds = plus(alone, times((damper.inv_mu, 0.0), push))
    return times(g, v1), times(g, dv), times(g, s), times(g, ds)


@jit
def put_column(w, i, y):
    """Write four pairs into column i of a table."""
    for c in range(4):
        first, second = y[c]
        head, rest = split(first)
        w[i + c], w[i + 4 + c] = head, rest + second


@jit
def put_sum(w, first, out, place):
    """Add to out[place : place + 4] the value at the end of a cell of the polynomial at `first`."""
    for k in range(ORDER, -1, -1):
        for c in range(4):
            out[place + c] += w[first + 4 * k + c]


@jit
def put_sum_of_load(load, w, out, place):
    """Add that of a constant load, where there is one."""
    if load is None:
        return None
    return put_sum(w, load, out, place)


@jit
def rounded_once(ps, damper, grid):
    """Return a grid as it is, but whose cells are rounded once; ps, damper: its bodies."""
    low = len(grid.table)
    w = np.zeros(low + OF_PUSHES + 12)
    w[:low] = grid.table
    for i in range(4):
        # the Taylor series of the motion that begins with one of x1, v1, r, s
        unit = np.zeros(4)
        unit[i] = 1.0
        begin = (unit[0], 0.0), (unit[1], 0.0), (unit[2], 0.0), (unit[3], 0.0)
        y = of_bodies(damper, begin)
        a, b, c, d = y
        for k in range(1, WHOLE_POWERS + 1):
            y = next_power(ps, damper, y, quotient(grid.h, float(k)))
            a, b, c, d = plus(a, y[0]), plus(b, y[1]), plus(c, y[2]), plus(d, y[3])
            if k <= KEPT_POWERS:
                put_column(w, low + MATRIX_NUMBERS * k + 8 * i, y)
        put_column(w, low + 8 * i, (a, b, c, d))
    put_sum(w, TAYLOR + 4 * TERMS, w, low + OF_PUSHES)
    put_sum(w, TAYLOR + 5 * TERMS, w, low + OF_PUSHES + 4)
    put_sum_of_load(grid.load, w, w, low + OF_PUSHES + 8)
    return with_table(grid, w, low)


@jit
def grid_once_rounded(ps, damper, n, begun):
    """Prepare one period of flight in `n` cells that are rounded once (`flight.grid_of`)."""
    return rounded_once(ps, damper, grid_from(ps, damper, n, begun))


# ---- their products with a state -----------------------------------------------------------------


@jit(inlined=True)
def column(w, i, x):
    """Return (an exact part, a small part) of column i of a table times x."""
    head, rest = split(x)
    heads = four_at(w, i)
    return heads * head, heads * rest + four_at(w, i + 4) * x


@jit(inlined=True)
def two_columns(w, i, x, y):
    """Return column i of a table times x plus the next times y: two fours, of which it is the sum.

    The second is what the first has lost by rounding.
    """
    a, b = column(w, i, x)
    c, d = column(w, i + 8, y)
    total, lost = two_sum(a, c)
    return total, (b + d) + lost


@jit(inlined=True)
def four_columns(damper, w, i, y):
    """Return the matrix at i of a table times a state, as a pair of fours."""
    a, b = two_columns(w, i, y[0], y[1])
    c, d = two_columns(w, i + 16, y[2], y[3])
    total, lost = two_sum(a, c)
    return total, (b + d) + lost


@jit(inlined=True)
def last_columns(damper, w, i, y):
    """Return the same where r and s are the whole state."""
    return two_columns(w, i + 16, y[2], y[3])


@jit
def product_with(damper, w, i, y):
    """Return the matrix at i of a table times a state, as a pair of fours."""
    if is_a(damper, Ground):
        return last_columns(damper, w, i, y)
    return four_columns(damper, w, i, y)


# ---- a cell, and a piece of one ------------------------------------------------------------------


@jit
def numbers_of(y):
    """Return a four as four numbers."""
    return number_of(y, 0), number_of(y, 1), number_of(y, 2), number_of(y, 3)


@jit
def whole_once_rounded(low, damper, w, j, y):
    """Return the state one cell after the state y at the beginning of cell j."""
    free, small = product_with(damper, w, low, y)
    total, lost = two_sum(free, four_at(w, CELLS + 6 * j))
    return numbers_of(total + (small + lost))


@jit
def whole_at_phase(low, damper, w, y, phase):
    """Return the state one cell after the state y and (cos, sin) of the phase there."""
    free, small = product_with(damper, w, low, y)
    i = low + OF_PUSHES
    push = four_at(w, i) * phase[0] + four_at(w, i + 4) * phase[1]
    total, lost = two_sum(free, push + four_at(w, i + 8))
    return numbers_of(total + (small + lost))


@jit(inlined=True)
def push_in(load, w, k, phase):
    """Return what forcing and load are in power k of the polynomial."""
    i = TAYLOR + 4 * TERMS + 4 * k
    return loaded(load, w, k, four_at(w, i) * phase[0] + four_at(w, i + TERMS) * phase[1])


@jit
def loaded(load, w, k, forced):
    """Return what forcing is in power k, with a constant load where there is one."""
    if load is None:
        return forced
    return forced + four_at(w, load + 4 * k)


@jit
def piece_once_rounded(low, damper, load, w, x, y, phase):
    """Return the state x cells after the state y and (cos, sin) of the phase there, 0 <= x <= 1.

    COEF holds the polynomial of the flight: of its powers above KEPT_POWERS plain numbers will do.
    """
    x2 = x * x
    x4 = x2 * x2
    last = pair(w, 12, x) + four_at(w, COEF + 4 * ORDER) * x2
    total = (pair(w, 4, x) + pair(w, 6, x) * x2) + (
        (pair(w, 8, x) + pair(w, 10, x) * x2) + last * x4
    ) * x4
    small = four(0.0)
    # Horner's rule for the powers that are kept with twice the precision
    for k in range(KEPT_POWERS, 0, -1):
        moved, lost = two_product(total, x)
        free, less = product_with(damper, w, low + MATRIX_NUMBERS * k, y)
        total, more = two_sum(free, moved)
        small = small * x + (lost + (less + more))
        total, more = two_sum(total, push_in(load, w, k, phase))
        small = small + more
    # and for the state at the start
    a, b, c, d = of_bodies(damper, y)
    moved, lost = two_product(total, x)
    total, more = two_sum(four_of(a, b, c, d), moved)
    return numbers_of(total + (small * x + (lost + more)))


# ---- where errors would add up -------------------------------------------------------------------


@jit
def after_cell(low, damper, w, j, y):
    """Return the state one cell after the state y at the beginning of cell j."""
    if low is None:
        return step(damper, w, j, y[0], y[1], y[2], y[3])
    return whole_once_rounded(low, damper, w, j, y)


@jit
def after_whole(low, damper, w, y, phase):
    """Return the state one cell after the state y, at which the polynomial in COEF starts."""
    if low is None:
        return at(w, 1.0)
    return whole_at_phase(low, damper, w, y, phase)


@jit
def after_piece(low, damper, load, w, x, y, phase):
    """Return the state x cells after the state y, at which the polynomial in COEF starts."""
    if low is None:
        return at(w, x)
    return piece_once_rounded(low, damper, load, w, x, y, phase)
