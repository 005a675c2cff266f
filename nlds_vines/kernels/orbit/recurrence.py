"""Period n and impacts k of an nT,k orbit by recurrence of its section and of its impact counts."""

from __future__ import annotations

from ..numerics.compiling import jit

TOLERANCE = 1.0e-6  # of a return, relative to the largest value of each component: settled to that
REPEATS = 3  # times a period must fit into the window


@jit
def repeats(section, length, n, count, tolerance):
    """Return True if the last `count` of so many rows of a section repeat after n periods."""
    first = max(length - count, n)
    for c in range(section.shape[1]):
        scale = 0.0
        for p in range(first - n, length):
            scale = max(scale, abs(section[p, c]))
        for p in range(first, length):
            if not abs(section[p, c] - section[p - n, c]) <= tolerance * scale:
                return False
    return True


@jit
def period_of(section, tolerance):
    """Return the smallest n for which half the section (periods, components) repeats, or 0."""
    length = len(section)
    for n in range(1, length // REPEATS + 1):
        if repeats(section, length, n, max(2 * n, length // 2), tolerance):
            return n
    return 0


@jit
def count(by_period, wall, first, last):
    total = 0
    for p in range(first, last):
        total += by_period[p, wall]
    return total


@jit
def impacts_of(by_period, wall, n):
    """Return the impacts k per nT at one wall; for n = 0 those of the whole window.

    by_period: counts (periods, 2); wall: 0 near, 1 far. The mean over as many cycles as the last
    half of the window holds, rounded. An impact on the very instant of a section, now before it
    and now after, changes the sum by 1 at most: from three cycles on, k is right all the same.
    """
    periods = len(by_period)
    if n == 0:
        return count(by_period, wall, 0, periods)
    cycles = max(1, periods // (2 * n))
    return round(count(by_period, wall, periods - cycles * n, periods) / cycles)
