"""Sums of many tones as Taylor polynomials over cells of time: the same bits everywhere.

Over a cell of length h, cos(2 pi (f t + p)) = sum_k a^k / k! (c, -s, -c, s)[k % 4] x^k, with the
angle a = 2 pi f h and c, s at its beginning. For cells of one length the powers are tabulated once,
and c, s are rotated by a from each cell to the next, and computed anew after every `ANEW` cells.
"""

from __future__ import annotations

import numpy as np

from .compiling import jit
from .elementary import SPLITTER, TURN, cos_sin_of_turn
from .fours import bare, four, four_at, put_four

ANEW = 8  # cells; a rotation errs by 2e-16, so that c and s err by less than 3e-15
SAME_CELL = 2.0e-15  # round-off of lengths and ends of cells, relative to the last time

# Columns of the table of a tone:
#   SIGNED   16   even powers a^k / k! with their signs, k = 0, 2, ... 14; odd ones, 1, 3, ... 15
#   TURNED       4   c, s; cos a, sin a
SIGNED, TURNED, TONE = 0, 16, 20
COEFFICIENTS = 15


@jit(entry=True)
def fill_tones(frequencies, phases, begins, lengths, rows):
    """Fill the rows (n, COEFFICIENTS) of the sum of cos(2 pi (f t + p)) over cells.

    A row has the Taylor coefficients by the place in the cell, 0 to 1. They omit the powers of a
    tone from a^15 / 15! on, 4e-15 for an angle a of 0.7 over the cell. frequencies (N,) [1/s] and
    phases (N,) [turns], from 0 to 1, of the tones; begins (n,), none negative, and lengths (n,) of
    the cells [s].
    """
    # made here, as a bare row does not keep its array
    table, sums = np.empty(TONE * len(frequencies)), np.empty(COEFFICIENTS + 1)
    fill_cells(frequencies, phases, begins, lengths, rows, table, sums)


@jit
def fill_cells(frequencies, phases, begins, lengths, rows, table, sums):
    """Fill the rows of `fill_tones`; table (TONE N,) and sums (COEFFICIENTS + 1,): scratch."""
    count, n = len(frequencies), len(begins)
    w, sums = bare(table), bare(sums)
    slack = SAME_CELL * (begins[n - 1] + lengths[n - 1]) if n > 0 else 0.0
    h, since = -1.0, 0
    for j in range(n):
        fits = abs(lengths[j] - h) <= slack
        on = fits and since < ANEW and abs(begins[j] - (begins[j - 1] + lengths[j - 1])) <= slack
        if not fits:
            h = lengths[j]
            for i in range(count):
                turn, value = frequencies[i] * h, 1.0
                for k in range(COEFFICIENTS + 1):
                    at = TONE * i + SIGNED + (k // 2 if k % 2 == 0 else 8 + k // 2)
                    w[at] = -value if (k + 1) // 2 % 2 == 1 else value
                    value *= TURN * turn / (k + 1.0)
                at = TONE * i + TURNED
                w[at + 2], w[at + 3] = cos_sin_of_turn(turn)
        for i in range(count):
            at = TONE * i + TURNED
            if on:  # turn c and s on by a cell
                c, s, cosine, sine = w[at], w[at + 1], w[at + 2], w[at + 3]
                w[at], w[at + 1] = c * cosine - s * sine, s * cosine + c * sine
            else:
                # The fraction of frequency times time by Dekker's product: the rounding error of
                # the product is added, as it is large in the fraction of a large product.
                f, t = SPLITTER * frequencies[i], SPLITTER * begins[j]
                f, t = f - (f - frequencies[i]), t - (t - begins[j])
                g, u, product = frequencies[i] - f, begins[j] - t, frequencies[i] * begins[j]
                lost = ((f * t - product) + f * u + g * t) + g * u
                turn = ((product - int(product)) + lost) + phases[i]
                w[at], w[at + 1] = cos_sin_of_turn(turn + 1.0)  # which may be just below zero
        since = since + 1 if on else 1
        even_low, even_high, odd_low, odd_high = four(0.0), four(0.0), four(0.0), four(0.0)
        for i in range(count):
            at = TONE * i
            c, s = w[at + TURNED], w[at + TURNED + 1]
            even_low = even_low + four_at(w, at + SIGNED) * c
            even_high = even_high + four_at(w, at + SIGNED + 4) * c
            odd_low = odd_low + four_at(w, at + SIGNED + 8) * s
            odd_high = odd_high + four_at(w, at + SIGNED + 12) * s
        put_four(sums, 0, even_low)
        put_four(sums, 4, even_high)
        put_four(sums, 8, odd_low)
        put_four(sums, 12, odd_high)
        for k in range(COEFFICIENTS):
            rows[j, k] = sums[k // 2 if k % 2 == 0 else 8 + k // 2]
