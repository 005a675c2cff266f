"""Flight under a load: any force on the structure that is a polynomial over each cell.

With f = sum_k f_k x^k over a cell, x from 0 to 1, the Taylor coefficients of the state are
c_(k+1) = h (A c_k + b f_k) / (k + 1). The motion from rest under a force x^m is tabulated for all
cells of equal length, so that the polynomial of a cell is a sum of products, as under a harmonic
force, and so is the state at its end.

Certificates of touches use bounds of the force and of its derivatives over some cells: those of a
harmonic force at the rate of the bodies, which replaces the load there (`pushed_over`).

Equal cells in a row are a `Stretch` with one grid. Its table is that of a grid without forcing
(`flight`) and, from the indices in `grid.begun` on,

    powers    ORDER TERMS       the polynomials of the motion from rest by x^m, m = 0, 1, ...
    ends      4 (ORDER + 2)     their values at the end of a cell, and that by a constant load
    weights   4                 factors of a cell's bounds of the force and three of its derivatives

The load's certificates and energies use numbers of each cell that are the same for every system
(`sums_of`): OF_CELL numbers, of which the first four are the sums of |f_k| k! / (k - i)!,
i = 0 ... 3, number END is the force at the end, and number HIGHEST_POWER its degree.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.fours import four, four_at, larger_of, largest_of, number_of, put_four
from ..scene.drive import Moment
from ..scene.scene import Structure, accelerations, greatest_push, moved_mass, unloaded
from .flight import (
    CELLS,
    COEF,
    DRIVE,
    ORDER,
    PERIOD,
    STEP,
    TAYLOR,
    TERMS,
    Grid,
    cell_polynomial,
    grid_with,
    move_on,
    phase_at,
    put_sum,
    step,
)

LOAD_ROW = ORDER + 1  # numbers of a cell: the coefficients of the force [N]
OF_CELL, END, HIGHEST_POWER = 8, 4, 5
LEAST_RATE = 0.1  # least rate of the replacing harmonic force, in units of 1/h


class Stretch(NamedTuple):
    """Equal cells in a row."""

    rows: Any  # (LOAD_ROW n,) coefficients of the force [N] cell by cell, a bare row
    sums: Any  # (OF_CELL n,) of `sums_of`, a bare row
    degree: int  # of the polynomials, the highest
    h: float  # length of a cell [s]
    begin: float  # [s]


class Loaded(NamedTuple):
    """The load of a grid, in place of a `flight.Begun`."""

    begin: float  # [s], from which times count
    rows: Any  # this and the next two as of the stretch
    sums: Any
    degree: int
    powers: int  # this and the next two are indices in the table
    ends: int
    weights: int
    root: float  # square root of the mass that the force accelerates [kg^0.5]


# ---- a load --------------------------------------------------------------------------------------


@jit
def sums_of(rows):
    """Return the OF_CELL numbers of each cell of the rows (LOAD_ROW n,) of a load, see above."""
    n = len(rows) // LOAD_ROW
    sums = np.zeros(OF_CELL * n)
    for j in range(n):
        at, end = OF_CELL * j, 0.0
        for k in range(LOAD_ROW):
            f, weight = rows[LOAD_ROW * j + k], 1.0
            end += f
            if f != 0.0:
                sums[at + HIGHEST_POWER] = k
            for i in range(4):
                sums[at + i] += weight * abs(f)
                weight *= k - i
        sums[at + END] = end
    return sums


# ---- a grid --------------------------------------------------------------------------------------


@jit
def grid_under(ps, damper, h, n, stretch):
    """Return the `Grid` of n cells of h [s] under a load, with `powers`, `ends` and `weights`.

    h may be less than that of the stretch: `polynomial_from` rescales the force, `end_of_cell`
    holds for equal h alone. c_(k+1) takes f_k, so f_ORDER moves nothing and has to be round-off.
    `push` is for a force of 1 N: `pushed_over` returns that of the load.
    """
    free, degree = grid_with(ps, damper, h, 1, 0, PERIOD), stretch.degree
    powers = len(free.table)
    ends = powers + ORDER * TERMS
    weights = ends + 4 * (ORDER + 2)
    w = np.zeros(weights + 4)
    w[:powers] = free.table
    for k in range(ORDER + 1):
        w[DRIVE + k] = 0.0  # stays 0 above the degree
    for m in range(min(degree + 1, ORDER)):
        # the Taylor coefficients of the motion from rest by a force x^m [N], as in `expand`
        dv, ds = accelerations(unloaded(ps), damper, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
        g = h / (m + 1.0)
        x1, v1, r, s = 0.0, dv * g, 0.0, ds * g
        for k in range(m + 1, ORDER + 1):
            at = powers + m * TERMS + 4 * k
            w[at], w[at + 1], w[at + 2], w[at + 3] = x1, v1, r, s
            dv, ds = accelerations(unloaded(ps), damper, x1, v1, r, s, 0.0, 0.0)
            g = h / (k + 1.0)
            x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        put_sum(w, powers + m * TERMS, w, ends + 4 * m)
    if ps.load is not None:
        put_sum(w, free.load, w, ends + 4 * (ORDER + 1))
    rate = max(free.rate, LEAST_RATE / h)
    # The i-th derivative of the force by the place is at most the sum of |f_k| k! / (k - i)!, as x
    # is at most 1; that of a harmonic force is its amplitude times (rate h)^i.
    weight = 1.0
    for i in range(4):
        w[weights + i] = weight
        weight /= rate * h
    begun = Loaded(
        stretch.begin, stretch.rows, stretch.sums, degree, powers, ends, weights,
        math.sqrt(moved_mass(ps, damper)),
    )  # fmt: skip
    return Grid(n, h, 0.0, rate, free.push, free.bend, w, free.load, begun)


@jit
def pushed_over(ps, grid, j, last):
    """Return (structure, grid) whose bounds hold over the cells from j to before `last`.

    Under a load, their force is harmonic, with an amplitude that bounds the load and three of its
    derivatives.
    """
    if is_a(grid.begun, Loaded):
        begun, w, most = grid.begun, grid.table, four(0.0)
        for i in range(j, last):
            most = larger_of(most, four_at(begun.sums, OF_CELL * i))
        force = ps.force * largest_of(most * four_at(w, begun.weights))
        push = begun.root * greatest_push(ps.load, force)
        return (
            Structure(ps.m1, ps.k1, ps.stiffness, ps.damping, force, grid.rate, ps.load, ps.shaken),
            Grid(
                grid.n, grid.h, grid.turn, grid.rate, push, grid.bend, grid.table, grid.load,
                grid.begun,
            ),
        )  # fmt: skip
    return ps, grid


# ---- an instant ----------------------------------------------------------------------------------


@jit
def phase_of(grid, j, x):
    """Return the instant at place x of cell j: `phase_at`, or the tabulated one at its ends."""
    if is_a(grid.begun, Loaded):
        begun, last = grid.begun, min(j, grid.n - 1)  # its end is that of the last cell
        return Moment(begun.rows, LOAD_ROW * last, begun.degree, x + (j - last), grid.h)
    whole = int(x)
    at_cell = CELLS + 6 * (j + whole)
    phase = grid.table[at_cell + 4], grid.table[at_cell + 5]
    if x != whole:
        phase = phase_at(grid, j, x)
    return phase


@jit
def began_at(grid, period):
    """Return the time [s] at which a period began, or a stretch."""
    if is_a(grid.begun, Loaded):
        return grid.begun.begin
    return period * (grid.h * grid.n)


@jit
def end_of_cells(grid, j, stop):
    """Return the cell before which the force is the same function as in cell j."""
    if is_a(grid.begun, Loaded):
        return j + 1
    return stop


# ---- a cell --------------------------------------------------------------------------------------


@jit
def end_of_cell(grid, damper, j, y):
    """Return the state at the end of cell j from the state y at its beginning."""
    if is_a(grid.begun, Loaded):
        w, begun, row = grid.table, grid.begun, LOAD_ROW * j
        ends = begun.ends
        even, odd = four_at(w, ends + 4 * (ORDER + 1)), four(0.0)
        for m in range(0, begun.degree, 2):
            even = even + four_at(w, ends + 4 * m) * begun.rows[row + m]
            odd = odd + four_at(w, ends + 4 * m + 4) * begun.rows[row + m + 1]
        if begun.degree % 2 == 0:
            even = even + four_at(w, ends + 4 * begun.degree) * begun.rows[row + begun.degree]
        free = (four_at(w, STEP) * y[0] + four_at(w, STEP + 4) * y[1]) + (
            four_at(w, STEP + 8) * y[2] + four_at(w, STEP + 12) * y[3]
        )
        end = free + (even + odd)
        return number_of(end, 0), number_of(end, 1), number_of(end, 2), number_of(end, 3)
    return step(damper, grid.table, j, y[0], y[1], y[2], y[3])


@jit
def polynomial_from(grid, y, phase):
    """Fill COEF with the Taylor coefficients of the flight from a state y at an instant.

    Under a load, also DRIVE with those of the force.
    """
    if is_a(phase, Moment):
        w, powers, degree = grid.table, grid.begun.powers, phase.degree
        fill_drive_from(w, phase, grid.h)
        f0, f1, f2, f3 = w[DRIVE], w[DRIVE + 1], w[DRIVE + 2], w[DRIVE + 3]
        for k in range(ORDER + 1):
            i, j = TAYLOR + 4 * k, powers + 4 * k
            free = (four_at(w, i) * y[0] + four_at(w, i + TERMS) * y[1]) + (
                four_at(w, i + 2 * TERMS) * y[2] + four_at(w, i + 3 * TERMS) * y[3]
            )
            # the first four powers of x at once: most loads have no others
            forced = (four_at(w, j) * f0 + four_at(w, j + TERMS) * f1) + (
                four_at(w, j + 2 * TERMS) * f2 + four_at(w, j + 3 * TERMS) * f3
            )
            for m in range(4, min(k, degree + 1)):
                forced = forced + four_at(w, j + TERMS * m) * w[DRIVE + m]
            put_four(w, COEF + 4 * k, free + forced)
        move_on(grid.load, w)
        return
    return cell_polynomial(grid, y[0], y[1], y[2], y[3], phase[0], phase[1])


@jit
def fill_drive_from(w, moment, h):
    """Fill DRIVE up to the degree of the force: its Taylor coefficients from a moment on.

    A Taylor shift by repeated synthetic division, and powers of the ratio of h [s], the length of
    the table's cells, to that of the moment.
    """
    degree, x, row = moment.degree, moment.x, moment.row
    for k in range(degree + 1):
        w[DRIVE + k] = moment.w[row + k]
    if x != 0.0:
        for i in range(degree):
            for k in range(degree - 1, i - 1, -1):
                w[DRIVE + k] += x * w[DRIVE + k + 1]
    if h != moment.length:
        ratio = h / moment.length
        power = ratio
        for k in range(1, degree + 1):
            w[DRIVE + k] *= power
            power *= ratio


@jit
def force_term(w, phase, k):
    """Return the Taylor coefficient k of the force over the expanded cell."""
    if is_a(phase, Moment):
        return w[DRIVE + k]
    return w[DRIVE + k] * phase[k % 2]
