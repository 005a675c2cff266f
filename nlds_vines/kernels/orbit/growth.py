"""Growth rates with their uncertainty, and how fast time averages converge.

The numbers here are sequences; where they come from does not matter. An orbit hands in logarithms
of growth per period, a map those per iteration.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import exp, log10

BATCHES = 16  # pieces whose means are compared: long ones that hardly depend on each other
QUANTILE = 2.947  # of Student's t for 15 degrees of freedom: 99 % of all cases are within
UNFIT = 0.05  # share of a sequence at its beginning that is left out: the variations align there


@jit
def mean_and_width(logs):
    """Return the mean of a sequence and half the width of its 99 % interval, by batch means.

    Consecutive values of an orbit depend on each other; the means of BATCHES long pieces hardly
    do. (inf where there are too few values; 0 where the mean is -inf, as one value is.)
    """
    first = int(UNFIT * len(logs))
    each = (len(logs) - first) // BATCHES
    if each < 2:
        return np.nan, np.inf
    first = len(logs) - each * BATCHES
    means = np.empty(BATCHES)
    for b in range(BATCHES):
        total = 0.0
        for i in range(first + b * each, first + (b + 1) * each):
            total += logs[i]
        means[b] = total / each
    mean = spread = 0.0
    for b in range(BATCHES):
        mean += means[b]
    mean /= BATCHES
    if mean == -np.inf:
        return mean, 0.0
    for b in range(BATCHES):
        spread += (means[b] - mean) * (means[b] - mean)
    return mean, QUANTILE * math.sqrt(spread / (BATCHES - 1) / BATCHES)


@jit
def weighted_mean(values, first, last):
    """Return the mean of values[first:last] with the smooth weight exp(-1 / (u (1 - u))).

    For a quasi-periodic sequence it converges faster than any power of its length, for a chaotic
    one like the square root (Das, Saiki, Sander, Yorke: Nonlinearity 30 (2017) 4111).
    """
    total = weights = 0.0
    for i in range(first, last):
        u = (i - first + 1.0) / (last - first + 1.0)
        w = exp(-1.0 / (u * (1.0 - u)))
        total += w * values[i]
        weights += w
    return total / weights


@jit
def digits_of(values):
    """Return to how many digits the weighted means of the two halves of a sequence agree.

    In units of its range; 15 where nothing varies.
    """
    n = len(values)
    if n < 4:
        return 0.0
    low = high = values[0]
    for i in range(1, n):
        low, high = min(low, values[i]), max(high, values[i])
    extent = high - low
    if not extent > 0.0:
        return 15.0
    off = weighted_mean(values, 0, n // 2) - weighted_mean(values, n // 2, n)
    return min(15.0, -log10(max(abs(off) / extent, 1.0e-15)))
