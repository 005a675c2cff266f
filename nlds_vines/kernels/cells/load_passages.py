"""Statistics of x1 under a load: passages of a level, time above it, rms, and how sure they are.

Between two edges x1 is the cubic by its values and velocities there, whose error is a 384th of the
fourth derivative: 2.4e-7 of the amplitude of a natural motion of which there are 64 cells in a
period, and more in a cell with an impact. Integrals of x1^2 are exact.

Means over BATCHES equal times are nearly independent where each is much longer than the motion
remembers. Their spread tells how far the mean over all of it may be off: the ends of its 95 %
confidence interval are those of Student's distribution of BATCHES - 1 degrees of freedom.

Source: A. M. Law, Simulation Modeling and Analysis, method of batch means.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiling import jit
from ..numerics.roots import ROOT_STEPS, narrowed, secant
from ..orbit.growth import BATCHES

SURE = 2.131449545559323  # 97.5 % of Student's t with BATCHES - 1 degrees of freedom
NEVER = 2.0  # a place beyond each cell

# Places of the statistics: when |x1| first exceeds the level [s], NaN: never; then each with the
# ends of its interval the rms of x1 [m], the share of the time with |x1| above the level, and how
# often in a second it rises above it
FIRST_PASSAGE, RMS, ABOVE, CROSSINGS = 0, 1, 4, 7
STATISTICS = 10

# Columns of a batch: how long it lasts [s], the integral of x1^2 [m^2 s], the time above [s], how
# often it rises above
LASTS, SQUARES, OVER, RISES = range(4)


@jit
def cubic_at(c, x):
    """Return the value of a cubic by its four coefficients."""
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


@jit
def cubic_root(c, low, high):
    """Return where a cubic that is monotone between two places changes its sign there."""
    f0, f1, x = cubic_at(c, low), cubic_at(c, high), low
    for _ in range(ROOT_STEPS):
        before, x = x, secant(low, high, f0, f1)
        f = cubic_at(c, x)
        if f == 0.0 or x == before:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    return x


@jit
def turns_of(c):
    """Return the places in (0, 1), in order, where a cubic turns; 1 for what there is not."""
    first, second = 1.0, 1.0
    inside = c[2] * c[2] - 3.0 * c[3] * c[1]
    if inside > 0.0:
        root = math.sqrt(inside)
        q = -(c[2] + (root if c[2] > 0.0 else -root))
        if q != 0.0:
            x = c[1] / q
            first = x if 0.0 < x < 1.0 else 1.0
        if c[3] != 0.0:
            x = q / (3.0 * c[3])
            second = x if 0.0 < x < 1.0 else 1.0
    return min(first, second), max(first, second)


@jit
def above_in_cell(f0, f1, g0, g1):
    """Return (share, rises, place) of a cell of which f > 0: how much, how often, where first.

    f0, f1: the values at its ends; g0, g1: the slopes by the place.
    """
    a, b = f0 + g0 * (1.0 / 3.0), f1 - g1 * (1.0 / 3.0)  # f lies between these four (`roots`)
    if max(max(f0, f1), max(a, b)) <= 0.0:
        return 0.0, 0, NEVER
    if min(min(f0, f1), min(a, b)) > 0.0:
        return 1.0, 0, NEVER
    c = (f0, g0, 3.0 * (f1 - f0) - 2.0 * g0 - g1, 2.0 * (f0 - f1) + g0 + g1)
    share, rises, first = 0.0, 0, NEVER
    turn, other = turns_of(c)
    low, f_low = 0.0, f0
    for i in range(3):
        high = turn if i == 0 else (other if i == 1 else 1.0)
        f_high = f1 if high == 1.0 else cubic_at(c, high)
        if f_low > 0.0 and f_high > 0.0:
            share += high - low
        elif f_high > 0.0:
            x = cubic_root(c, low, high)
            share, rises, first = share + (high - x), rises + 1, min(first, x)
        elif f_low > 0.0:
            share += cubic_root(c, low, high) - low
        low, f_low = high, f_high
        if high == 1.0:
            break
    return share, rises, first


@jit
def fill_batches(load, buffers, asked, batches):
    """Fill the batches (BATCHES, 4) behind the time to settle; return the first passage [s]."""
    edges, section, sums, level = load.edges, buffers.section, buffers.sums, asked.level
    first, end = math.nan, edges[len(edges) - 1]
    if level > 0.0 and abs(section[0, 0]) > level:
        first = edges[0]
    per_batch = (end - asked.settle) / BATCHES
    for i in range(len(edges) - 1):
        h = edges[i + 1] - edges[i]
        over, rises, place = 0.0, 0, NEVER
        if level > 0.0:
            x0, x1 = section[i, 0], section[i + 1, 0]
            g0, g1 = h * section[i, 1], h * (section[i + 1, 1] - load.jumps[i + 1])
            for side in range(2):
                sign = 1.0 - 2.0 * side
                share, more, x = above_in_cell(
                    sign * x0 - level, sign * x1 - level, sign * g0, sign * g1
                )  # fmt: skip
                over, rises, place = over + share, rises + more, min(place, x)
        if place <= 1.0 and math.isnan(first):
            first = edges[i] + place * h
        middle = edges[i] + 0.5 * h
        if middle > asked.settle:
            b = min(int((middle - asked.settle) / per_batch), BATCHES - 1)
            batches[b, LASTS] += h
            batches[b, SQUARES] += sums[i + 1, 4] - sums[i, 4]
            batches[b, OVER] += over * h
            batches[b, RISES] += rises
    return first


@jit
def interval(batches, column):
    """Return the mean of a quantity by time, and the ends of its 95 % confidence interval.

    The ends are NaN where a batch is empty.
    """
    lasts, total = 0.0, 0.0
    for b in range(BATCHES):
        lasts += batches[b, LASTS]
        total += batches[b, column]
    mean, spread = total / lasts, 0.0
    for b in range(BATCHES):
        off = batches[b, column] / batches[b, LASTS] - mean
        spread += off * off
    half = SURE * math.sqrt(spread / (BATCHES * (BATCHES - 1.0)))
    return mean, mean - half, mean + half


@jit
def not_below_zero(low):
    """Return the lower end of an interval of what is never negative; NaN stays."""
    return 0.0 if low < 0.0 else low


@jit
def fill_passages(load, buffers, asked, found):
    """Fill in the statistics (STATISTICS,) of an orbit (arguments as `load_numbers`)."""
    batches = np.zeros((BATCHES, 4))
    first = fill_batches(load, buffers, asked, batches)
    mean, low, high = interval(batches, int(SQUARES))
    found[RMS] = math.sqrt(mean)
    found[RMS + 1] = math.sqrt(not_below_zero(low))
    found[RMS + 2] = math.sqrt(high)
    if asked.level > 0.0:
        found[FIRST_PASSAGE] = first
        for column, place in ((OVER, ABOVE), (RISES, CROSSINGS)):
            mean, low, high = interval(batches, column)
            found[place] = mean
            found[place + 1] = not_below_zero(low)
            found[place + 2] = high
