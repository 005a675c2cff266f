"""Flight is linear, so it is exact.

A forcing period is cut into `n` equal cells. A constant matrix and a forced response tabulated by
phase advance the state over a cell: sixteen multiplications. Both come from
Taylor polynomials of degree 14, whose remainder over a cell is below 4e-15 (`REACH`). The matrix
errs in the same way in every cell: an undamped oscillator at a linear stop changes its energy by
1.6e-10 in 1e5 periods. The same polynomials give the state at any instant inside a cell.

Neither eigenvectors nor a steady amplitude are needed: a defective damper pair and an undamped
structure driven at resonance are no special cases.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import TURN, cos_sin_of_turn
from ..numerics.fours import bare, four, four_at, number_of, put_four
from ..scene.scene import accelerations, greatest_push, joined, moved_mass, under, unloaded

# --------------------------------------------------------------------------------------------------
# Bounds of the linear motion, on which the length of cells and the certificates of touches rest.
#
# In energy coordinates (sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2) the motion without
# forcing never grows, so that the energy bounds all derivatives (`scene.scale_of`).


REACH = 0.7  # longest cell in units of 1/rate: 0.7^15 / 15! = 4e-15, and the rate is a bound
SHORT = 0.4  # the same if contacts are linear, too, below round-off: 0.4^15 / 15! = 8e-19
FEWEST_CELLS = 8  # in a period: cheap, and short enough for the proofs of `touch` to succeed often
MOST_CELLS = 1 << 19  # in a period: 6 numbers each, 25 MB; beyond it the status is TOO_STIFF


@jit
def rate_of(ps, damper):
    """Return a bound [1/s] on the rates of the linear motion and of the forcing.

    In energy coordinates (sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2) the system's matrix is
    symmetric but for signs, so that its largest row sum bounds its norm.
    """
    on_v1 = math.sqrt(ps.stiffness) + ps.damping
    if damper is None:
        return max(on_v1, ps.omega)
    drag1 = damper.c2 * damper.inv_m1
    drag2 = damper.c2 / damper.m2
    across = math.sqrt(drag1 * drag2)
    pull1, pull2 = math.sqrt(damper.k2 * damper.inv_m1), math.sqrt(damper.k2 / damper.m2)
    on_v1 += drag1 + pull1 + across
    on_v2 = pull2 + drag2 + across
    return max(max(on_v1, on_v2), max(pull1 + pull2, ps.omega))


@jit
def bend_of(ps, damper):
    """Return the factor b with |d2r/dt2| <= b S + P/m1, S the energy scale of `scale_of`.

    The dual norm of the row of eq. (5) that gives d2r/dt2, in energy coordinates.
    """
    if damper is None:
        return 0.0
    on_v2 = damper.c2 * damper.inv_mu
    on_v1 = ps.damping + on_v2
    squares = ps.stiffness / ps.m1
    squares += on_v1 * on_v1 / ps.m1
    squares += damper.k2 * damper.inv_mu * damper.inv_mu
    if on_v2 > 0.0:  # there may be no m2
        squares += on_v2 * on_v2 / damper.m2
    return math.sqrt(squares)


@jit
def damper_bounds(ps, damper):
    """Return (c, a, b): 2 E2 <= c S^2 and |du/dt| <= a |u| + b S, S being that of `scale_of`.

    E2 = u u / 2, u = (sqrt(m2) v2, sqrt(k2) x2), takes the absolute displacement of the damper, S
    that of the structure and the shortening of the spring:
    sqrt(k2) |x1 - r| <= (sqrt(k2 / k1) + 1) S. By eq. (5) m2 dv2/dt = -k2 x2 - c2 v2
    + (k2 x1 + c2 v1): the last part, by which the structure acts on the damper, is at most
    sqrt(m2) b S. x2 counts from the rest.
    """
    if damper is None:
        return 0.0, 0.0, 0.0
    soft, pulls = 0.0, damper.c2 * damper.c2 / ps.m1
    if damper.k2 > 0.0:  # otherwise no energy holds a structure without a spring
        soft = math.sqrt(damper.k2 / ps.k1)  # sqrt(k2) |x1| per S
        pulls += damper.k2 * damper.k2 / ps.k1
    absolute = 1.0 + soft
    alone = math.sqrt(damper.k2 / damper.m2) + damper.c2 / damper.m2
    return 1.0 + absolute * absolute, alone, math.sqrt(pulls / damper.m2)


@jit
def cells_of(ps, damper):
    """Return the number of cells in a period that the Taylor polynomials need; -1: too many."""
    period = 2.0 * math.pi / ps.omega
    need = period * rate_of(ps, joined(damper)) / REACH
    if not need <= MOST_CELLS:  # or infinite, or NaN
        return -1
    return max(FEWEST_CELLS, math.ceil(need))


class Bounds(NamedTuple):
    """Bounds of derivatives by the place in a cell, over some cells."""

    bend: float  # of the second derivative of r [m]
    jerk: float  # of the third of r [m]
    fourth: float  # of the fourth of r [m]
    energy: float  # of the fourth derivative of E1 [J]
    scale: float  # of the energy scale S [J^0.5], from which the others follow


@jit
def bounds_of(ps, grid, scale):
    """Return the `Bounds` of motions of at most the energy scale S.

    E1 is u u / 2 of a part u of the scaled state; by Leibniz' rule its fourth derivative is
    u d4u + 4 du d3u + 3 d2u d2u. Each derivative of u is at most `rate` times the one before, plus
    that of the forcing.
    """
    first, force = grid.rate * scale + grid.push, abs(ps.force)
    push = grid.rate * grid.push  # bounds the derivative of the forcing: omega <= rate
    second = grid.rate * first + push
    third = grid.rate * (second + push)
    fourth = grid.rate * (third + grid.rate * push)
    h2 = grid.h * grid.h
    return Bounds(
        (grid.bend * scale + greatest_push(ps.load, force)) * h2,
        (grid.bend * first + ps.omega * force) * h2 * grid.h,
        (grid.bend * second + ps.omega * ps.omega * force) * h2 * h2,
        (scale * fourth + 4.0 * first * third + 3.0 * second * second) * h2 * h2,
        scale,
    )


# ---- exact flight --------------------------------------------------------------------------------


ORDER = 14  # of the Taylor polynomials
TERMS = 4 * (ORDER + 1)  # coefficients of the four state components


# The table w of a grid: one array, since each array in a tuple slows down calls that pass it on.
#
#   from      numbers       what
#   STEP      16            transition matrix over a cell, column by column: w[4 column + row]
#   OF_E2      4            bounds of E2 per S^2 / 2 and of its rates (`damper_bounds`); 1 if the
#                           force accelerates the damper as well, otherwise 0
#   FACTOR    ORDER + 1     scratch: Taylor coefficients of a factor over a cell (`response`)
#   COEF      TERMS         scratch: those of the state over a cell, power by power:
#                           w[COEF + 4 power + component], components x1, v1, r, s
#   TAYLOR    6 TERMS       those of the state if one of (x1, v1, r, s, cos, sin) is 1 at the cell's
#                           start and the others 0: w[TAYLOR + TERMS input + 4 power + component]
#   DRIVE     ORDER + 1     cos(a x + b) = sum_k w[DRIVE + k] x^k (cos b, sin b)[k % 2], a the angle
#                           of the forcing's phase over a cell
#   CELLS     6 (n + 1)     for each cell j, and for the start of the next period:
#                           w[CELLS + 6 j ...] = forced response over it (4), cos, sin at its start
#   grid.load  TERMS        those of the state that a constant load alone moves, if there is one
STEP = 0
OF_E2 = 16
FACTOR = 24
COEF = 40
TAYLOR = COEF + TERMS
DRIVE = TAYLOR + 6 * TERMS
CELLS = DRIVE + ORDER + 1


class Begun(NamedTuple):
    """The part of the forcing's period that the cells of a grid cover."""

    phase: float  # share of the period before the first cell
    share: float  # share of the period that the cells last


PERIOD = Begun(0.0, 1.0)
"""The whole period from phase zero on."""


class Grid(NamedTuple):
    """One period of flight: all that depends on the parameters alone."""

    n: int  # cells in a period
    h: float  # length of a cell [s]
    turn: float  # the turn of the forcing's phase over a cell
    rate: float  # bound on the growth of the scaled state per second [1/s]
    push: float  # |P| / sqrt(m1), of a ground |a| sqrt(m1 + m2): bounds the growth of the scale S
    bend: float  # |d2r/dt2| <= bend * S + |P| / m1
    table: np.ndarray  # (CELLS + 6 n + 6,), the table above; in inner kernels a bare row
    load: Any  # index in the table of the motion by a constant load, or None
    begun: Any = PERIOD  # or `load_cells.Loaded`


@jit
def bare_grid(grid):
    return Grid(
        grid.n, grid.h, grid.turn, grid.rate, grid.push, grid.bend, bare(grid.table), grid.load,
        grid.begun,
    )  # fmt: skip


@jit
def expand(ps, damper, h, inputs, out, first):
    """Write the Taylor coefficients of a flight into out[first : first + TERMS].

    inputs: x1, v1, r, s, cos and sin of the phase at its start; y(x h) = sum_k out[first + 4 k +
    component] x^k. Coefficient k + 1 is h / (k + 1) times the rate of coefficient k; cos and sin
    are two more components, and a constant load enters at k = 0 only.
    """
    x1, v1, r, s, cosine, sine = inputs[0], inputs[1], inputs[2], inputs[3], inputs[4], inputs[5]
    out[first], out[first + 1], out[first + 2], out[first + 3] = x1, v1, r, s
    for k in range(ORDER):
        dv, ds = accelerations(unloaded(ps), damper, x1, v1, r, s, cosine, 0.0)
        if k == 0:
            dv, ds = under(ps.load, dv), under(ps.load, ds)
        g = h / (k + 1.0)
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        cosine, sine = -ps.omega * sine * g, ps.omega * cosine * g
        at = first + 4 * k + 4
        out[at], out[at + 1], out[at + 2], out[at + 3] = x1, v1, r, s


@jit
def cell_polynomial(grid, x1, v1, r, s, cosine, sine):
    """Fill COEF with the Taylor coefficients of the flight from a state.

    It is the polynomial of `expand` as a product with the prepared responses, in which no
    coefficient waits for the one before.
    """
    w = grid.table
    for k in range(0, TERMS, 4):
        i = TAYLOR + k
        free = (four_at(w, i) * x1 + four_at(w, i + TERMS) * v1) + (
            four_at(w, i + 2 * TERMS) * r + four_at(w, i + 3 * TERMS) * s
        )
        forced = four_at(w, i + 4 * TERMS) * cosine + four_at(w, i + 5 * TERMS) * sine
        put_four(w, COEF + k, free + forced)
    move_on(grid.load, w)


@jit
def move_on(load, w):
    """Add the motion by a constant load to the polynomial in COEF."""
    if load is not None:
        for k in range(TERMS):
            w[COEF + k] += w[load + k]


@jit
def pair(w, k, x):
    """Return c_k + c_(k+1) x for the four components of COEF."""
    return four_at(w, COEF + 4 * k) + four_at(w, COEF + 4 * k + 4) * x


@jit
def at(w, x):
    """Return (x1, v1, r, s) at place x of the polynomial in COEF of `w`, by Estrin's scheme."""
    x2 = x * x
    x4 = x2 * x2
    low = (pair(w, 0, x) + pair(w, 2, x) * x2) + (pair(w, 4, x) + pair(w, 6, x) * x2) * x4
    last = pair(w, 12, x) + four_at(w, COEF + 4 * ORDER) * x2
    y = low + ((pair(w, 8, x) + pair(w, 10, x) * x2) + last * x4) * (x4 * x4)
    return number_of(y, 0), number_of(y, 1), number_of(y, 2), number_of(y, 3)


@jit
def grid_from(ps, damper, n, begun):
    return grid_with(ps, damper, length_of_cell(ps, n, begun), n, n, begun)


@jit
def length_of_cell(ps, n, begun):
    """Return the length [s] of a cell of n in a `Begun`."""
    return begun.share * (2.0 * math.pi / ps.omega) / n


@jit
def grid_with(ps, damper, h, n, tabulated, begun):
    """Return the `Grid` of n cells of h [s] in a `Begun`, the first of which are `tabulated`."""
    load = None if ps.load is None else (CELLS + 6 * tabulated + 6)
    w = np.zeros(CELLS + 6 * tabulated + 6 + (0 if ps.load is None else TERMS))
    unit = np.zeros(6)
    for i in range(6):
        unit[i] = 1.0
        expand(unloaded(ps), damper, h, unit, w, TAYLOR + i * TERMS)
        unit[i] = 0.0
    fill_drive(ps, h, w)
    response = np.zeros(24)  # of the six unit inputs at the end of a cell
    for i in range(6):
        put_sum(w, TAYLOR + i * TERMS, response, 4 * i)
    for i in range(16):
        w[STEP + i] = response[i]
    # cos and sin at the end, where the next period starts
    w[CELLS + 6 * tabulated + 4], w[CELLS + 6 * tabulated + 5] = cos_sin_of_turn(turned(begun, 1.0))
    for j in range(tabulated):
        at_cell = CELLS + 6 * j
        cosine, sine = cos_sin_of_turn(turned(begun, j / n))
        w[at_cell + 4], w[at_cell + 5] = cosine, sine
        for c in range(4):
            w[at_cell + c] = response[16 + c] * cosine + response[20 + c] * sine
    if ps.load is not None:
        expand(ps, damper, h, np.zeros(6), w, load)
        moved = np.zeros(4)
        put_sum(w, load, moved, 0)
        for j in range(tabulated):
            for c in range(4):
                w[CELLS + 6 * j + c] += moved[c]
    body = joined(damper)
    w[OF_E2], w[OF_E2 + 1], w[OF_E2 + 2] = damper_bounds(ps, body)
    w[OF_E2 + 3] = 0.0 if ps.shaken is None else 1.0
    push = greatest_push(ps.load, abs(ps.force)) * math.sqrt(moved_mass(ps, damper))
    turn = begun.share / n
    return Grid(n, h, turn, rate_of(ps, body), push, bend_of(ps, damper), w, load, begun)


@jit
def put_sum(w, first, out, place):
    """Add to out[place : place + 4] the value at the end of a cell of the polynomial at `first`."""
    for k in range(ORDER, -1, -1):
        for c in range(4):
            out[place + c] += w[first + 4 * k + c]


@jit
def fill_drive(ps, h, w):
    """Fill the rows DRIVE of the table of a grid whose cells are h [s] long."""
    power = 1.0  # of the angle, by the factorial, with the sign in cos(a x + b)
    for k in range(ORDER + 1):
        w[DRIVE + k] = power
        power *= (ps.omega * h if k % 2 == 1 else -ps.omega * h) / (k + 1.0)


@jit
def turned(begun, share):
    """Return the turn of the forcing's phase after a share of a grid's cells."""
    return begun.phase + begun.share * share


@jit
def step(damper, w, j, x1, v1, r, s):
    """Return the state at the end of cell j from that at its beginning; w: the table."""
    f = CELLS + 6 * j
    if damper is None:
        return (
            (w[0] * x1 + w[4] * v1) + w[f],
            (w[1] * x1 + w[5] * v1) + w[f + 1],
            0.0,
            0.0,
        )
    return (
        (w[0] * x1 + w[4] * v1) + (w[8] * r + w[12] * s) + w[f],
        (w[1] * x1 + w[5] * v1) + (w[9] * r + w[13] * s) + w[f + 1],
        (w[2] * x1 + w[6] * v1) + (w[10] * r + w[14] * s) + w[f + 2],
        (w[3] * x1 + w[7] * v1) + (w[11] * r + w[15] * s) + w[f + 3],
    )


@jit
def coarse_map(ps, damper, grid, stops):
    """Return a table of the period in `stops` cells, for `step`; `stops` divides grid.n.

    Only its matrix (STEP) and its forced responses (CELLS) are filled. In a scene without walls,
    one `step` with it leads from a section to the next, as grid.n / stops steps of the grid do.
    """
    coarse, silent, y = np.zeros(CELLS + 6 * stops), grid.table.copy(), np.zeros(4)
    silent[CELLS:] = 0.0
    share = grid.n // stops
    for i in range(4 + stops):
        y[:] = 0.0
        if i < 4:
            y[i] = 1.0
        w = silent if i < 4 else grid.table
        first = 0 if i < 4 else (i - 4) * share
        for j in range(first, first + share):
            y[0], y[1], y[2], y[3] = step(damper, w, j, y[0], y[1], y[2], y[3])
        place = STEP + 4 * i if i < 4 else CELLS + 6 * (i - 4)
        for c in range(4):
            coarse[place + c] = y[c]
    return coarse


@jit(inlined=True)
def response_to(w, x, i):
    """Return the state after a flight of x cells, x in [0, 1], from unit input i (x1, v1, r, s)."""
    k = TAYLOR + i * TERMS
    even, odd, z = four_at(w, k + 4 * ORDER), four(0.0), x * x
    for p in range(ORDER - 2, -1, -2):
        even = four_at(w, k + 4 * p) + even * z
        odd = four_at(w, k + 4 * p + 4) + odd * z
    return even + odd * x


@jit(inlined=True)
def times_matrix(a, b, c, d, tangent):
    """Multiply four variations (16,) by the matrix whose columns are a, b, c, d."""
    for i in range(0, 16, 4):
        y = (a * tangent[i] + b * tangent[i + 1]) + (c * tangent[i + 2] + d * tangent[i + 3])
        put_four(tangent, i, y)


@jit
def propagate(grid, tangent, time):
    """Propagate four variations (16,), one after the other, along a flight of `time` [s].

    A variation obeys y' = A y, wherever the flight is.
    """
    w = grid.table
    cells = int(time / grid.h)
    x = time / grid.h - cells
    a, b, c, d = four_at(w, STEP), four_at(w, STEP + 4), four_at(w, STEP + 8), four_at(w, STEP + 12)
    for _ in range(cells):
        times_matrix(a, b, c, d, tangent)
    times_matrix(
        response_to(w, x, 0), response_to(w, x, 1), response_to(w, x, 2), response_to(w, x, 3),
        tangent,
    )  # fmt: skip


@jit
def phase_at(grid, j, x):
    """Return (cos, sin) of the forcing's phase at place x of cell j, 0 <= x <= 1.

    The tabulated phase at its start is turned by an angle a, |a| <= REACH, by Taylor polynomials
    with remainders below 0.7^17 / 17! = 7e-18.
    """
    at_cell = CELLS + 6 * j
    c, d = grid.table[at_cell + 4], grid.table[at_cell + 5]
    a = TURN * grid.turn * x
    z = a * a
    z2 = z * z
    z4 = z2 * z2
    # 1 - cos a = z (1 / 2! - z / 4! + ...)
    even = (1.0 / 3628800.0 - z * (1.0 / 479001600.0)) + z2 * (
        1.0 / 87178291200.0 - z * (1.0 / 20922789888000.0)
    )
    even = (0.5 - z * (1.0 / 24.0)) + (z2 * (1.0 / 720.0 - z * (1.0 / 40320.0)) + z4 * even)
    even = z * even
    # a - sin a = a z (1 / 3! - z / 5! + ...)
    odd = (1.0 / 39916800.0 - z * (1.0 / 6227020800.0)) + z2 * (1.0 / 1307674368000.0)
    odd = (1.0 / 6.0 - z * (1.0 / 120.0)) + (z2 * (1.0 / 5040.0 - z * (1.0 / 362880.0)) + z4 * odd)
    sine = a - a * z * odd
    return c - (c * even + d * sine), d - (d * even - c * sine)
