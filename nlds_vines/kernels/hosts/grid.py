"""The tables of a flight: exact propagators over cells, and bounds that certify touches.

A period has `cells` smallest cells, 2^levels of which are a coarse one; the propagator of each
level is the square of that below it. A flight takes the coarsest cell in which no touch is
possible. The cells of one level are the long ones, in which a polynomial of r of degree 31 holds:
a touch by a motion that only rises is located there, and short impacts are solved with it.

The bound of |r''''| over a cell is a sum over pairs (w x, v) of coordinates and rates. By modes it
is small for all that are quiet, however fast they are: a bound by the energy would be useless for a
host whose highest mode is 50 times as fast as its lowest. In the scaled coordinates the rates of a
pair consist of a rotation, which changes no norm, and of the coupling to other pairs, whose norms
are the matrix G; over a time h norms grow by at most exp(G h).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import FEWEST_CELLS, ORDER, REACH
from ..numerics.compiling import jit
from ..numerics.elementary import cos_sin_of_turn, hypotenuse, power_of_two
from .body import accelerate, along

MOST_HALVINGS = 14
TERMS_OF_R = (ORDER + 4) // 4 * 4  # coefficients of a polynomial, in whole fours
LONG_TERMS = 32  # of one over a long cell
LONG_REACH = 3.0  # longest long cell in units of 1 / rate: 3^32 / 32! = 7e-21
WINDOW = 3.0  # long cells for which the polynomials' rests are bounded
BLOCK = 12  # rows of a propagator that `advance` computes at once
MOST_GROWN = 1000  # terms of a series; some 3 |growth| time are needed
CANCELED = 1.0e-15  # a sum over modes, relative to the sum of their moduli, that is round-off


class HostGrid(NamedTuple):
    """The tables of a cell; each array is one row of numbers, in inner kernels a bare row."""

    cells: int  # smallest ones in a period
    levels: int  # of halving a coarse cell
    h: float  # of a smallest cell [s]
    rate: float  # bound of the rates of the motion [1/s]
    drives: int  # D numbers of the drive (`body`)
    columns: int  # numbers of y and of the drive behind it, in whole fours
    # propagators of y from the coarsest level on, by columns of BLOCK rows, the rest of four rows
    propagators: Any
    ahead: Any  # and of r and s of links, row by row
    is_harmonic: bool
    begun: float  # turns of a harmonic force before a period
    turns: float  # and within it
    # drives at the beginning of smallest cells, 2 (cells + 1); of a load in time, the coefficients
    # (D,) of the period
    phases: Any
    scales: Any  # (size,) w of pairs [1/s]: modes, then links of masses
    fourth: Any  # links * (size + D / 2): bounds of |r''''| by norms of pairs, then of the drive's
    polynomials: Any  # links * (N + D) * TERMS_OF_R: Taylor coefficients of r in a smallest cell
    long: int  # the level of long cells
    long_polynomials: Any  # links * (N + D) * LONG_TERMS: those in a long cell, whose length is L
    # (links,) L^32 |r^(32)| over WINDOW long cells, relative to the bound of |r''''| at their start
    rests: Any


@jit
def times(a, b):
    """Return the product of two square matrices, each sum in one order."""
    n = len(a)
    out = np.zeros((n, n))
    for i in range(n):
        for k in range(n):
            if a[i, k] != 0.0:
                for j in range(n):
                    out[i, j] += a[i, k] * b[k, j]
    return out


@jit
def exponential(a):
    """Return exp(a) of a matrix whose norm is of order one, by its Taylor series."""
    n, k = len(a), 0
    term, total = np.eye(n), np.eye(n)
    largest = 1.0
    while largest > 0.0 and k < 200:
        k += 1
        term = times(term, a) / k
        largest = 0.0
        for i in range(n):
            for j in range(n):
                before = total[i, j]
                total[i, j] += term[i, j]
                if total[i, j] != before:
                    largest = 1.0
    return total


@jit
def matrix_of(body):
    """Return A of (y, e)' = A (y, e) with the drive e, (N + D, N + D)."""
    size, D = body.size, body.drives
    a, y, out = np.zeros((2 * size + D, 2 * size + D)), np.zeros(2 * size), np.zeros(size)
    for j in range(2 * size + 1):
        y[:] = 0.0
        if j < 2 * size:
            y[j] = 1.0
        accelerate(body, y, 0, 0.0 if j < 2 * size else 1.0, out, 0)
        for i in range(size):
            a[size + i, j] = out[i]
    for i in range(size):
        a[i, size + i] = 1.0
    for k in range(D):
        a[2 * size + k, 2 * size + (k + 1) % D] = body.paces[k]
    return a


@jit
def pairs_of(body, a, least):
    """Return (scales, matrix, back): w of each pair, A by pairs, and coordinates by pairs.

    least: w [1/s] of a pair without stiffness.

    Pairs are (w x, v) of modes and (w r, s) of the links of masses. Link j of a mass is that of
    coordinate modes + j: r = (its part of the host) - u. The place of a pair without stiffness has
    no effect on any rate: with w = 0 it counts for nothing. A negative stiffness counts as a
    positive one, and the pair grows (`growth_of`). The numbers of the drive stay as they are.
    """
    n, size = body.modes, body.size
    squares = np.zeros(size)
    # the coordinates by those of pairs: a mass moves with the host if its r does not change
    back = np.eye(len(a))
    for i in range(n):
        squares[i] = body.squares[i]
    for link in range(body.links):
        row, mass = link * size, n + link  # links of masses come first
        has_mass = mass < size
        for j in range(size):
            stiffness = body.stiffness[link] * body.rows[row + j] * body.answers[row + j]
            if has_mass:  # in all k / mu
                squares[mass] += abs(stiffness)
            elif j < n:
                squares[j] += abs(stiffness)
        if has_mass:
            for j in range(n):
                back[mass, j] = back[size + mass, size + j] = body.rows[row + j]
            back[mass, mass] = back[size + mass, size + mass] = -1.0
    scales = np.sqrt(squares)
    for i in range(size):
        if scales[i] == 0.0:
            scales[i] = least
    # `back` is its own inverse: u = w q - r and r = w q - u
    paired = times(times(back, a), back)
    for i in range(size):
        for j in range(len(a)):
            # a place is in units of its rate; one without stiffness counts for nothing
            paired[i, j] *= scales[i]
        for j in range(2 * size):
            paired[j, i] *= 1.0 / scales[i] if scales[i] > 0.0 else 0.0
    return scales, paired, back


@jit
def growth_of(paired, size):
    """Return G: the coupling of the norms of pairs, and on its diagonal their own growth.

    Two numbers of the drive are a pair, behind the others.
    """
    count = len(paired) // 2
    growth = np.zeros((count, count))
    for i in range(count):
        x, v = (i, size + i) if i < size else (2 * i, 2 * i + 1)
        for j in range(count):
            y, w = (j, size + j) if j < size else (2 * j, 2 * j + 1)
            a, b, c, d = paired[x, y], paired[x, w], paired[v, y], paired[v, w]
            if i == j:  # the largest eigenvalue of the symmetric part, if it is positive
                half = 0.5 * (a + d)
                growth[i, i] = max(half + hypotenuse(0.5 * (a - d), 0.5 * (b + c)), 0.0)
            else:
                growth[i, j] = math.sqrt((a * a + b * b) + (c * c + d * d))
    return growth


@jit
def derivative_of(a, row):
    """Return row A: the row of the rate of what `row` gives."""
    size = len(row)
    following, sizes = np.zeros(size), np.zeros(size)
    for i in range(size):
        if row[i] != 0.0:
            for j in range(size):
                following[j] += row[i] * a[i, j]
                sizes[j] += abs(row[i] * a[i, j])
    for j in range(size):  # a force elsewhere does not accelerate r: its modes cancel
        if abs(following[j]) <= CANCELED * sizes[j]:
            following[j] = 0.0
    return following


@jit
def norms_by_pair(body, row, scales, back):
    """Return the norms of a row by the pairs, and by those of the drive's numbers."""
    size = body.size
    norms = np.zeros(size + body.drives // 2)
    for b in range(size):
        place = rate = 0.0
        for i in range(size):
            place += row[i] * back[i, b]
            rate += row[size + i] * back[size + i, size + b]
        place *= 1.0 / scales[b] if scales[b] > 0.0 else 0.0
        norms[b] = hypotenuse(place, rate)
    for b in range(size, len(norms)):
        norms[b] = hypotenuse(row[2 * b], row[2 * b + 1])
    return norms


@jit
def grown(weights, growth, time):
    """Return weights exp(growth time), of numbers that are not negative, by the Taylor series."""
    count, k = len(weights), 0
    term, total, largest = weights.copy(), weights.copy(), 1.0
    while largest > 0.0 and k < MOST_GROWN:
        k += 1
        following, largest = np.zeros(count), 0.0
        for i in range(count):
            if term[i] != 0.0:
                factor = term[i] * (time / k)
                for j in range(count):
                    following[j] += factor * growth[i, j]
        term = following
        for j in range(count):
            before = total[j]
            total[j] += term[j]
            if total[j] != before:
                largest = 1.0
    return total


@jit
def host_grid(body, stops):
    """Return the `HostGrid` of a body in periods of `stops` parts, and False if it is too fine.

    Under a load in time a period is a coarse cell, whatever the pairs.
    """
    size, omega, period = body.size, body.omega, body.period
    N, D = 2 * size, body.drives
    is_harmonic = body.paces[D - 1] != 0.0
    a = matrix_of(body)
    scales, paired, back = pairs_of(body, a, 0.0)
    growth = growth_of(paired, size)
    fastest = omega
    for i in range(size):
        # the rotation of a pair, its damping, and the coupling to the others
        total = scales[i]
        total += abs(paired[size + i, size + i])
        for j in range(size):
            total += growth[i, j]
        fastest = max(fastest, total)
    # coarse cells by the second slowest pair, or by the force
    order = np.sort(scales)
    low = min(max(omega, order[min(1, size - 1)]), 2.0 * omega)
    coarse = max(FEWEST_CELLS, math.ceil(period * low / REACH))
    coarse = stops * math.ceil(coarse / stops) if is_harmonic else stops
    levels = 0
    while levels < MOST_HALVINGS and period / (coarse << levels) * fastest > REACH:
        levels += 1
    is_fine = period / (coarse << levels) * fastest <= REACH
    count = coarse << levels
    h = period / count

    # propagators, from the smallest cell to the coarsest
    links = body.links
    rows, columns = (N + 3) // 4 * 4, (N + D + 3) // 4 * 4
    in_blocks = rows // BLOCK * BLOCK
    propagators = np.zeros((levels + 1) * rows * (N + D))
    ahead = np.zeros((levels + 1) * links * 2 * columns)
    step, column = exponential(a * h), np.zeros(N)
    for level in range(levels, -1, -1):
        for j in range(N + D):
            for i in range(N):
                column[i] = step[i, j]
                width = BLOCK if i < in_blocks else 4
                at = (level * rows + i - i % width) * (N + D)
                propagators[at + j * width + i % width] = column[i]
            for link in range(links):
                at = (level * links + link) * 2 * columns + j
                ahead[at], ahead[at + columns] = along(body, link, column, 0)
        if level > 0:
            step = times(step, step)
    phases = np.zeros(2 * count + 2 if is_harmonic else D)
    if is_harmonic:
        for j in range(count + 1):
            turn = body.begun + body.turns * (j / count)
            phases[2 * j], phases[2 * j + 1] = cos_sin_of_turn(turn)

    long = 0
    while long < levels and period / (coarse << long) * fastest > LONG_REACH:
        long += 1
    length = h * (1 << (levels - long))

    # Taylor coefficients of r over a smallest and a long cell
    polynomials = np.zeros(links * (N + D) * TERMS_OF_R)
    long_polynomials = np.zeros(links * (N + D) * LONG_TERMS)
    pairs = size + D // 2
    fourth, rests = np.zeros(links * pairs), np.zeros(links)
    for link in range(links):
        power, per = np.zeros(N + D), 1.0
        for i in range(size):
            power[i] = body.rows[link * size + i]
        fourth_row = power
        for k in range(LONG_TERMS):
            ratio = power_of_two(k * (long - levels))  # of the smallest cell's powers
            for j in range(N + D):
                at = link * (N + D) + j
                long_polynomials[at * LONG_TERMS + k] = per * power[j]
                if k <= ORDER:
                    polynomials[at * TERMS_OF_R + k] = ratio * per * power[j]
            if k == 4:
                fourth_row = power.copy()
            power = derivative_of(a, power)
            per *= length / (k + 1.0)
        # |r''''| by the norms of pairs at the beginning of a coarse cell
        by_pair = norms_by_pair(body, fourth_row, scales, back)
        bounds = grown(by_pair, growth, period / coarse)
        scale = 1.0
        for _ in range(LONG_TERMS):
            scale *= length
        by_pair = norms_by_pair(body, power, scales, back)
        beyond = grown(by_pair, growth, WINDOW * length)
        for j in range(pairs):
            fourth[link * pairs + j] = bounds[j]
            if beyond[j] > 0.0:
                rest = scale * beyond[j] / bounds[j] if bounds[j] > 0.0 else math.inf
                rests[link] = max(rests[link], rest)
    grid = HostGrid(
        count, levels, h, fastest, D, columns, propagators, ahead, is_harmonic, body.begun,
        body.turns, phases, scales, fourth, polynomials, long, long_polynomials, rests,
    )  # fmt: skip
    return grid, is_fine
