"""Taylor coefficients of loads over cells of time, by strict arithmetic: the same bits everywhere.

A row has TERMS coefficients, of the powers of x = (t - begin) / length; 0 <= x <= 1 in its cell.
"""

from __future__ import annotations

import numpy as np

ORDER = 14
"""Of the polynomials, as of a flight's."""

TERMS = ORDER + 1

REACH = 0.5
"""Longest cell in units of 1/rate of a load: what a series leaves out is below 0.5^15 / 15!."""

SPLITTER = 134217729.0
"""2^27 + 1: cuts a number into two halves of 26 digits each (Veltkamp)."""


def cos_sin(turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cos and sin of 2 pi `turns` (n,)."""
    from nlds_vines.kernels.numerics.elementary import fill_cos_sin

    parts = np.ascontiguousarray(turns - np.floor(turns))  # exact: a difference of near numbers
    cos, sin = np.empty_like(parts), np.empty_like(parts)
    fill_cos_sin(parts, cos, sin)
    return cos, sin


def exponential(x: np.ndarray) -> np.ndarray:
    """Return e^x of `x` (n,)."""
    from nlds_vines.kernels.numerics.elementary import fill_exp

    found = np.empty(len(x))
    fill_exp(np.ascontiguousarray(x), found)
    return found


def relative_growth(y: np.ndarray) -> np.ndarray:
    """Return (e^y - 1) / y of `y` (n,), 1 at y = 0.

    Below |y| = 1/2 it is the sum of y^k / (k + 1)!, k < 16, which no difference spoils.
    """
    small = np.where(np.abs(y) < 0.5, y, 0.0)
    series = np.ones_like(y)
    for k in range(16, 1, -1):
        series = 1.0 + series * small / k
    large = np.where(np.abs(y) < 0.5, 1.0, y)
    return np.where(np.abs(y) < 0.5, series, (exponential(large) - 1.0) / large)


def logarithm(x: float) -> float:
    """Return ln x."""
    from nlds_vines.kernels.numerics.elementary import log

    return float(log(x))


def turns_at(frequency: float, times: np.ndarray) -> np.ndarray:
    """Return `frequency` [1/s] `times` (n,) [s] in turns, less whole ones; its rounding is added.

    Of a large product little of its fraction is left; what rounding has taken is the difference of
    the products of halves (Dekker).
    """
    product = frequency * times
    f = SPLITTER * frequency - (SPLITTER * frequency - frequency)
    t = SPLITTER * times - (SPLITTER * times - times)
    g, u = frequency - f, times - t
    lost = ((f * t - product) + f * u + g * t) + g * u
    return np.asarray((product - np.floor(product)) + lost)


def cosine(turns: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of cos(2 pi turns + angle x); both arguments (n,)."""
    c, s = cos_sin(turns)
    rows = np.empty((len(c), TERMS))
    rows[:, 0] = c
    for k in range(1, TERMS):
        c, s = -angle / k * s, angle / k * c
        rows[:, k] = c
    return rows


def cosine_of(phase: np.ndarray) -> np.ndarray:
    """Return the rows of cos(p), p given by its rows (n, TERMS) in turns: c' = -p' s, s' = p' c."""
    rates = 2 * np.pi * phase * np.arange(TERMS)
    c, s = np.zeros_like(phase), np.zeros_like(phase)
    c[:, 0], s[:, 0] = cos_sin(phase[:, 0])
    for k in range(1, TERMS):
        for j in range(1, k + 1):
            c[:, k] -= rates[:, j] * s[:, k - j]
            s[:, k] += rates[:, j] * c[:, k - j]
        c[:, k] /= k
        s[:, k] /= k
    return c


def tones(
    frequencies: np.ndarray, phases: np.ndarray, begins: np.ndarray, lengths: np.ndarray
) -> np.ndarray:
    """Return the rows of the sum of cos(2 pi (f t + p)), frequencies f (N,) [1/s], phases p (N,).

    Arguments: where the cells begin (n,), from 0 on, and how long they are (n,) [s].
    """
    from nlds_vines.kernels.numerics.tones import fill_tones

    rows = np.empty((len(begins), TERMS))
    fill_tones(
        frequencies, phases, np.ascontiguousarray(begins), np.ascontiguousarray(lengths), rows
    )
    return rows


def growth(exponents: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of exp(exponents + rises x); both arguments (n,)."""
    rows = np.empty((len(exponents), TERMS))
    rows[:, 0] = exponential(exponents)
    for k in range(1, TERMS):
        rows[:, k] = rows[:, k - 1] * rises / k
    return rows


def times_line(rows: np.ndarray, level: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the rows of the product of a series and of level + slope x."""
    found = rows * level[:, None]
    found[:, 1:] += rows[:, :-1] * slope[:, None]
    return found


def polynomial(coefficients: np.ndarray, at: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of polynomials over cells.

    Arguments: `coefficients` (n, m) of the powers of a time [s]; `at` (n,), that time where each
    cell begins; `lengths` (n,) of the cells [s].

    Cost: m (m - 1) / 2 products of arrays, synthetic divisions (Horner).
    """
    shifted = coefficients.astype(np.float64)
    most = shifted.shape[1]
    for first in range(most - 1):
        for k in range(most - 2, first - 1, -1):
            shifted[:, k] += at * shifted[:, k + 1]
    rows, scale = np.zeros((len(at), TERMS)), np.ones(len(at))
    for k in range(most):
        rows[:, k] = shifted[:, k] * scale
        scale = scale * lengths
    return rows


def values_of(rows: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the values (n,) of rows at the places x (n,) in their cells (Horner)."""
    found = rows[:, -1].copy()
    for k in range(TERMS - 2, -1, -1):
        found = found * x + rows[:, k]
    return found
