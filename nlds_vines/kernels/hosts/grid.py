"""The tables of a flight: exact propagators over cells, and bounds that certify touches.

A period has `cells` smallest cells, 2^levels of which are a coarse one; the propagator of each
level is the square of that below it. A flight takes the coarsest cell in which no touch is
possible.

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
from ..numerics.elementary import cos_sin_of_turn, hypotenuse
from .body import accelerate, along

MOST_HALVINGS = 14
TERMS_OF_R = (ORDER + 4) // 4 * 4  # coefficients of a polynomial, in whole fours
BLOCK = 12  # rows of a propagator that `advance` computes at once
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
def pairs_of(body, a):
    """Return (scales, matrix, back): w of each pair, A by pairs, and coordinates by pairs.

    Pairs are (w x, v) of modes and (w r, s) of the links of masses. Link j of a mass is that of
    coordinate modes + j: r = (its part of the host) - u. A pair without stiffness has w = 0; its
    place has no effect on any rate. The numbers of the drive stay as they are.
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
                squares[mass] += stiffness
            elif j < n:
                squares[j] += stiffness
        if has_mass:
            for j in range(n):
                back[mass, j] = back[size + mass, size + j] = body.rows[row + j]
            back[mass, mass] = back[size + mass, size + mass] = -1.0
    scales = np.sqrt(squares)
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
def host_grid(body, stops):
    """Return the `HostGrid` of a body in periods of `stops` parts, and False if it is too fine.

    Under a load in time a period is a coarse cell, whatever the pairs.
    """
    size, omega, period = body.size, body.omega, body.period
    N, D = 2 * size, body.drives
    is_harmonic = body.paces[D - 1] != 0.0
    a = matrix_of(body)
    scales, paired, back = pairs_of(body, a)
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

    # Taylor coefficients of r over a smallest cell
    polynomials = np.zeros(links * (N + D) * TERMS_OF_R)
    pairs = size + D // 2
    fourth = np.zeros(links * pairs)
    bounded = exponential(growth * (period / coarse))
    for link in range(links):
        row = np.zeros((1, N + D))
        for i in range(size):
            row[0, i] = body.rows[link * size + i]
        power, per = row[0].copy(), 1.0
        fourth_row = power
        for k in range(ORDER + 1):
            for j in range(N + D):
                polynomials[(link * (N + D) + j) * TERMS_OF_R + k] = per * power[j]
            if k == 4:
                fourth_row = power.copy()
            following, sizes = np.zeros(N + D), np.zeros(N + D)
            for i in range(N + D):
                if power[i] != 0.0:
                    for j in range(N + D):
                        following[j] += power[i] * a[i, j]
                        sizes[j] += abs(power[i] * a[i, j])
            for j in range(N + D):  # a force elsewhere does not accelerate r: its modes cancel
                if abs(following[j]) <= CANCELED * sizes[j]:
                    following[j] = 0.0
            power = following
            per *= h / (k + 1.0)
        # |r''''| by the norms of pairs at the beginning of a coarse cell
        by_pair = np.zeros(pairs)
        for b in range(size):
            place = rate = 0.0
            for i in range(size):
                place += fourth_row[i] * back[i, b]
                rate += fourth_row[size + i] * back[size + i, b]
            place *= 1.0 / scales[b] if scales[b] > 0.0 else 0.0
            by_pair[b] = hypotenuse(place, rate)
        for b in range(size, pairs):
            by_pair[b] = hypotenuse(fourth_row[2 * b], fourth_row[2 * b + 1])
        for j in range(pairs):
            for b in range(pairs):
                fourth[link * pairs + j] += by_pair[b] * bounded[b, j]
    grid = HostGrid(
        count, levels, h, fastest, D, columns, propagators, ahead, is_harmonic, body.begun,
        body.turns, phases, scales, fourth, polynomials,
    )  # fmt: skip
    return grid, is_fine
