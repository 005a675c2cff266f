"""The search for the stable periodic orbit that an orbit ends in.

Sections that repeat propose a period, and so do near returns; Newton's method and the monodromy
matrix decide. A return after n periods is near if it is nearer than every one before: the points of
an orbit of n periods lie farther apart. On a torus such returns are rare, the denominators of the
continued fraction of its rotation number.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiling import jit
from ..numerics.matrices import eigenvalues, is_saddle, spectral_radius
from ..orbit.recurrence import TOLERANCE, repeats
from ..orbit.shooting import is_minimal, matrix_of, polish, span_of
from ..orbit.variations import distance
from ..scene import evidence_rows as ev
from ..scene.codes import PERIODIC
from .course import last_of, oldest_of, section_at
from .settling import MARGIN, attracted, settling_period

MOST_PERIODS = 1024  # periods n that are looked for
FEWEST_REPEATED = 16  # sections that must have repeated: fewer may do so by chance
SLOW_RETURN = 4.0  # times by which near returns on the way to a periodic orbit shrink, at most
# periods that are tried, and their sum, where little speaks for an orbit
FEW_TRIED, SUM_TRIED = 4, 96
MANY_TRIED = 32  # periods that are tried where much does

# What a search found
NOTHING, NEIGHBOR, FOUND = 0, 1, 2


@jit
def recent_period(record, length):
    """Return the least n of which the last 2n sections, or more, repeat, or 0."""
    for n in range(1, min(MOST_PERIODS, length // 3) + 1):
        if repeats(record, length, n, max(2 * n, FEWEST_REPEATED), TOLERANCE):
            return n
    return 0


@jit
def near_returns(space, course, chaotic):
    """Return by n the energy norm [J^0.5] of section m, the last, less section m - n, if near.

    inf for n = 0, and where a return of fewer periods is as near. n ends at MOST_PERIODS, or where
    section m - 2n is not kept. In chaos many returns are near by chance: there, m - n must lie as
    far or farther from m - 2n, but at most SLOW_RETURN times, a guess of how fast an orbit settles.
    """
    m = last_of(course)
    last, other, earlier, nearest_yet = np.zeros(4), np.zeros(4), np.zeros(4), math.inf
    section_at(space, course, m, last)
    found = np.full(min(MOST_PERIODS, (m - oldest_of(course)) // 2) + 1, math.inf)
    for n in range(1, len(found)):
        section_at(space, course, m - n, other)
        far = distance(space, last, other)
        if not far < nearest_yet:
            continue
        nearest_yet = far
        section_at(space, course, m - 2 * n, earlier)
        if not chaotic or far <= distance(space, other, earlier) <= SLOW_RETURN * far:
            found[n] = far
    return found


@jit
def best_of(returns):
    """Return the n of the near return of least distance times n, its cost; 0 if there is none."""
    best = 0
    for n in range(1, len(returns)):
        if returns[n] < math.inf and (best == 0 or n * returns[n] < best * returns[best]):
            best = n
    return best


@jit
def spacing(space, course, n):
    """Return how far the last section lies from the nearest of the n - 1 before it."""
    m = last_of(course)
    last, other, nearest_yet = np.zeros(4), np.zeros(4), math.inf
    section_at(space, course, m, last)
    for p in range(m - n + 1, m):
        section_at(space, course, p, other)
        nearest_yet = min(nearest_yet, distance(space, last, other))
    return nearest_yet


@jit
def try_period(flow, course, n, apart, evidence):
    """Try to find a stable orbit of minimal period n that the orbit is drawn to.

    FOUND fills the evidence. NEIGHBOR means an orbit of period n beside the sections that draws
    it not, or that is a saddle: such a one lies beside each stable orbit on a closed curve. The
    steps of Newton's method are at most `apart`, the distance to the nearest of the sections before
    that are fewer periods away.
    """
    x = np.zeros(4)
    section_at(flow.space, course, last_of(course) // n * n, x)
    y = x.copy()
    points, counts, tangent = np.empty((n, 4)), np.zeros(2, np.int64), np.zeros(16)
    residual, clearance, slowest = polish(flow, y, points, counts, tangent, apart)
    if not residual < np.inf or not is_minimal(flow.space, y, points):
        return NOTHING
    span = span_of(flow.space, points)
    multipliers = eigenvalues(matrix_of(tangent, flow.space.size))
    radius = spectral_radius(multipliers)
    stable = radius < 1.0 - MARGIN
    if not stable or not attracted(flow, tangent, y, x, n, span):
        beside = distance(flow.space, x, y) <= apart
        return NEIGHBOR if beside and (stable or is_saddle(multipliers)) else NOTHING
    evidence[ev.KIND], evidence[ev.CYCLE_PERIOD] = PERIODIC, n
    evidence[ev.NEAR_IMPACTS], evidence[ev.FAR_IMPACTS] = counts[0], counts[1]
    evidence[ev.RESIDUAL], evidence[ev.RADIUS] = residual, radius
    evidence[ev.CLEARANCE], evidence[ev.SLOWEST] = clearance, slowest
    evidence[ev.SETTLING] = settling_period(flow, course, tangent, y, n, span)
    for i in range(16):
        evidence[ev.MONODROMY + i] = tangent[i]
    for i in range(4):
        evidence[ev.POINT + i] = y[i]
    return FOUND


@jit
def find_period(flow, course, most, periods, chaotic, evidence):
    """Try the period of a recurrence, then those of near returns, the best first.

    At most `most` of these, of so many `periods` in all. Returns FOUND or NOTHING; NEIGHBOR where
    the sections repeat, an orbit lies beside them, or not all near returns were tried.
    """
    n = recent_period(course.record, course.length)
    known, tried, spent = n > 0, 0, 0
    result = NEIGHBOR if known else NOTHING
    returns = np.empty(0)
    while True:
        if not known:
            if tried == 0:  # most orbits are known by then
                returns = near_returns(flow.space, course, chaotic)
                returns[n] = math.inf
            n = best_of(returns)
            if n == 0:
                return result
            tried, spent = tried + 1, spent + n
            if tried > most or spent > periods:
                return NEIGHBOR
        apart = math.inf if known else spacing(flow.space, course, n)
        known = False
        found = try_period(flow, course, n, apart, evidence)
        if found == FOUND:
            return FOUND
        result = max(result, found)
        if n < len(returns):
            returns[n] = math.inf
