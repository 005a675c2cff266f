"""The verdict on an orbit with its evidence: periodic, quasi-periodic, chaotic or undetermined.

An orbit is periodic if shooting closes a stable orbit of minimal period to round-off and the orbit
approaches it as the monodromy matrix predicts; transient chaos preceded it if its long transient
has a positive exponent. An orbit is chaotic if the 99 % interval of its largest Lyapunov exponent
lies above zero and time averages do not converge as on a torus. It is quasi-periodic if that
exponent is zero, time averages converge as only those of a smooth torus do, the motion is steady
and has forgotten its start, and no periodic orbit lies beside it. Everything else is undetermined.

A verdict is reached in stages of further periods. A periodic orbit ends the search; chaos and a
torus may be transient, so they are followed through all stages. More effort can only find more.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import exp, log, log10
from ..numerics.fours import bare
from ..numerics.matrices import eigenvalues, is_saddle, spectral_radius
from ..orbit.repetition import TOLERANCE, repeats
from ..orbit.variations import (
    TOGETHER,
    advance_flow,
    begin_growth,
    column_of,
    departs,
    distance,
    has_walls,
    is_minimal,
    lost_of,
    matrix_of,
    no_section,
    norm,
    orthonormalize,
    place_state,
    polish,
    run_on,
    set_identity,
    span_of,
    state_for,
    volume_of,
    width_of,
)
from ..scene import codes as ev
from ..scene.by_law import by_flow
from ..scene.codes import CHAOTIC, OK, PERIODIC, QUASIPERIODIC, TRANSIENT_CHAOS, UNDETERMINED


class Evidence(NamedTuple):
    """The evidence of a verdict: parts of a row, whose columns are in `codes`."""

    row: Any  # of scalars, KIND to PASSING_WIDTH
    impacts: Any  # (walls,) of an nT orbit by wall
    exponents: Any  # (size,) or more [1/s]
    monodromy: Any  # (width * width,) column by column
    point: Any  # (width,)


@jit
def evidence_in(row, width=4, impacts=ev.NEAR_IMPACTS, walls=2):
    """Return the evidence in a row; impacts: where those of the walls begin."""
    monodromy = ev.EXPONENTS + width
    point = monodromy + width * width
    return Evidence(
        row, row[impacts : impacts + walls], row[ev.EXPONENTS : monodromy], row[monodromy:point],
        row[point : point + width],
    )  # fmt: skip


# ---- Growth rates with their uncertainty, and how fast time averages converge --------------------


BATCHES = 16  # parts of a sequence whose means are compared
QUANTILE = 2.947  # of Student's t, two-sided 99 %, 15 degrees of freedom
UNFIT = 0.05  # share of a sequence at its beginning that is left out: the variations align there


@jit
def mean_and_width(logs):
    """Return the mean of a sequence and the half-width of its 99 % interval, by batch means.

    Consecutive values of an orbit are correlated; the means of BATCHES long parts hardly are.
    The half-width is inf if there are too few values, and 0 if the mean is -inf.
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
def digits_of(values, least=0.0):
    """Return -log10 of the difference of the weighted means of both halves over the range.

    At most 15, the value of a constant sequence, one whose range is `least` at most.
    """
    n = len(values)
    if n < 4:
        return 0.0
    low = high = values[0]
    for i in range(1, n):
        low, high = min(low, values[i]), max(high, values[i])
    extent = high - low
    if not extent > least:
        return 15.0
    off = weighted_mean(values, 0, n // 2) - weighted_mean(values, n // 2, n)
    return min(15.0, -log10(max(abs(off) / extent, 1.0e-15)))


# --------------------------------------------------------------------------------------------------
# The sections of an orbit so far, and more of them.
#
# An orbit has the same bits with variations and without, in one run and in several. So no verdict
# depends on where the periods of a request end and those of the verdict begin.


MOST_SHRUNK = 6.0  # -ln of the factor by which a volume may shrink between two projections
FEWEST_PROJECTIONS = 8  # in each of the BATCHES


class OrbitSections(NamedTuple):
    """The sections of an orbit; section m is the state at the time m T, section 0 the start."""

    record: np.ndarray  # (rows, components) in the user's coordinates; row 0 is section first + 1
    length: int  # rows that are filled
    first: int  # periods before those of the record
    origin: np.ndarray  # as `state_for`: section 0


@jit
def last_of(course):
    return course.first + course.length


@jit
def oldest_of(course):
    if course.first == 0:
        return 0
    return course.first + 1


@jit
def bare_course(course):
    """Return a course to read sections of, whose record is one bare row."""
    record = bare(course.record.reshape(-1))
    return OrbitSections(record, course.length, course.first, bare(course.origin))


@by_flow
def state_of(space, y):
    """Return the numbers of a state at a section, apart from its array."""
    return y[0], y[1], y[2], y[3]


@by_flow
def section_at(space, course, m):
    """Return the state (x1, v1, r, s) at section m of a bare course."""
    if m == 0:
        return state_of(space, course.origin)
    record, i = course.record, space.size * (m - course.first - 1)
    x1, v1 = record[i], record[i + 1]
    if space.size == 2:
        return x1, v1, 0.0, 0.0
    return x1, v1, x1 - record[i + 2] + space.rest, v1 - record[i + 3]


@jit
def periods_together(flow, periods):
    """Return the number of periods between two orthonormalizations, in a run of `periods`.

    In between variations turn towards the fastest: no volume may shrink by more than
    exp(-MOST_SHRUNK), and each of the BATCHES, whose means give the uncertainty, must hold
    FEWEST_PROJECTIONS.
    """
    shrinks = abs(flow.trace) * flow.period
    most = MOST_SHRUNK / max(shrinks, MOST_SHRUNK / TOGETHER)
    most = min(most, periods / (BATCHES * FEWEST_PROJECTIONS))
    return max(1, int(most))


@jit
def follow_growth(flow, rows, state, tangent, logs, growth):
    """Follow an orbit and its variations for len(logs) periods; return a status.

    rows: receives its sections, as far as there is room. logs: receives the logarithm by which the
    first variation grows in a period (the mean of a few); growth: the sums for all.
    """
    flow.clearance[0] = 0.0  # no near miss is looked for
    together, size = periods_together(flow, len(logs)), min(flow.space.size, len(growth))
    for p in range(0, len(logs), together):
        grown, n = growth[0], min(together, len(logs) - p)
        status = advance_flow(flow, rows[p : p + n], n, tangent, state)
        if status != OK:
            return status
        orthonormalize(tangent, size, growth, lost_of(flow))
        vanished = growth[0] == -np.inf  # a damper that sticks forgets all variations
        logs[p : p + n] = -np.inf if vanished else (growth[0] - grown) / n
    return OK


# ---- When an orbit settled on the periodic orbit that it ends in, and what it was before ---------
#
# An orbit has settled at the first section from which every return, n periods later, is as the
# monodromy matrix predicts. Only sections whose number is a multiple of n count, so that the
# settling time does not depend on how long the orbit was watched.


MARGIN = 1.0e-6  # error of the largest multiplier's modulus and of a mean growth per period
# largest error of a predicted return, as a share of the deviation: the prediction is linear
PREDICTION_ERROR = 0.25
UNPREDICTED = 2.0  # deviation beyond which nothing is predicted, in units of the cycle's `span`
CONVINCING = 1000  # periods of returns as predicted that prove the approach
TINY = 1.0e-7  # deviation, relative to the orbit, that rounding and the method's error may make
LONG_TRANSIENT = 50  # periods before settling; a shorter time is too short for an exponent
LONGEST_LOOK = 2400  # periods of a transient whose exponent is measured: the first ones


class PredictedCycle(NamedTuple):
    """A stable orbit of n periods, and what its returns are predicted with."""

    n: int
    point: Any  # (width,) its state at the sections that are multiples of n, a bare row
    tangent: Any  # (width^2,) its monodromy matrix there, column by column, a bare row
    off: Any  # (width,) scratch
    span: float  # its largest energy norm at a section [J^0.5]
    resolvable: float  # the least deviation that shows on a section, in the energy norm [J^0.5]


@jit
def cycle_through(space, y, tangent, points):
    """Return the `PredictedCycle` through y whose sections are `points` (n, width).

    Sections hold positions, so a motion that is tiny beside the damper's rest offset has few
    digits.
    """
    span = span_of(space, points)
    off, resolvable = y.copy(), TINY * span + space.blur
    return PredictedCycle(len(points), bare(y), bare(tangent), off, span, resolvable)


@jit
def returns_as_predicted(space, cycle, now, far, then, far_then):
    """Return True if `then`, n periods after `now`, is where the monodromy matrix predicts.

    The monodromy matrix maps the deviation of `now` from the cycle's point to that of `then`. far,
    far_then: the energy norms of both deviations. Two that are not resolvable count as predicted.
    """
    if far <= cycle.resolvable and far_then <= cycle.resolvable:
        return True
    off, width = cycle.off, width_of(space)
    for i in range(width):
        off[i] = 0.0
    for c in range(space.size):
        deviation = now[c] - cycle.point[c]
        for i in range(width):
            off[i] += cycle.tangent[width * c + i] * deviation
    for i in range(width):
        off[i] = (off[i] + cycle.point[i]) - then[i]
    error = norm(space, off)
    return far <= UNPREDICTED * cycle.span and error <= PREDICTION_ERROR * far


@jit
def attracted(flow, cycle, x):
    """Return True if an orbit from the state x approaches a stable cycle.

    Each return must be as predicted, until the deviation is not resolvable or for CONVINCING
    periods. One return proves nothing: a flight without impact always obeys the matrix of an orbit
    without impacts.
    """
    state, then, n = state_for(flow), state_of(flow.space, x), cycle.n
    far_then = distance(flow.space, then, cycle.point)
    place_state(flow, x, state)
    for _ in range(0, CONVINCING, n):
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return False
        now, far, then = then, far_then, state_of(flow.space, state)
        far_then = distance(flow.space, then, cycle.point)
        if not returns_as_predicted(flow.space, cycle, now, far, then, far_then):
            return False
        if far_then <= cycle.resolvable:
            return True
    return True


@jit
def settling_period(flow, course, cycle):
    """Return the number of the first section from which on all returns are as predicted.

    It is a multiple of n; the last one if not even the last return is as predicted.
    """
    n, sections, oldest = cycle.n, bare_course(course), oldest_of(course)
    m = last_of(course) // n * n
    then = section_at(flow.space, sections, m)
    far_then = distance(flow.space, then, cycle.point)
    while m - n >= oldest:
        now = section_at(flow.space, sections, m - n)
        far = distance(flow.space, now, cycle.point)
        if not returns_as_predicted(flow.space, cycle, now, far, then, far_then):
            return m
        then, far_then, m = now, far, m - n
    if course.first == 0:
        return 0
    # the sections before section m are not in the course: the orbit is run again from its beginning
    state, settled = state_for(flow), 0
    place_state(flow, course.origin, state)
    after = state_of(flow.space, state)
    far_after = distance(flow.space, after, cycle.point)
    for p in range(n, m + 1, n):
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return m
        before, far, after = after, far_after, state_of(flow.space, state)
        far_after = distance(flow.space, after, cycle.point)
        if not returns_as_predicted(flow.space, cycle, before, far, after, far_after):
            settled = p
    return settled


@jit
def note_chaotic_transient(flow, course, evidence, period):
    """Note the exponent of a long transient; above zero, the orbit is transient chaos."""
    row = evidence.row
    periods = int(row[ev.SETTLING])
    if not has_walls(flow) or periods < LONG_TRANSIENT:
        return
    state = state_for(flow)
    tangent, growth = begin_growth(flow)
    place_state(flow, course.origin, state)
    logs, nothing = np.zeros(min(periods, LONGEST_LOOK)), no_section(flow.space)
    if follow_growth(flow, nothing, state, tangent, logs, growth) != OK:
        return
    mean, width = mean_and_width(logs)
    width = max(width, MARGIN)
    row[ev.PASSING], row[ev.PASSING_WIDTH] = mean / period, width / period
    if mean - width > 0.0:
        row[ev.KIND] = TRANSIENT_CHAOS


# ---- The search for the stable periodic orbit that an orbit ends in ------------------------------
#
# A recurrence of the sections proposes a period n, and so do near returns; Newton's method and the
# monodromy matrix decide. A return after n periods is near if no return after fewer periods is
# nearer: the points of an orbit of n periods lie farther apart. On a torus near returns are rare:
# n is a denominator of the continued fraction of its rotation number.


MOST_PERIODS = 1024  # largest n that is looked for
FEWEST_REPEATED = 16  # sections that must repeat: fewer may do so by chance
SLOW_RETURN = 4.0  # largest factor per return by which the distance of a settling orbit shrinks
FEW_TRIED, SUM_TRIED = 4, 96  # candidates, and the sum of their n, if a periodic orbit is unlikely
MANY_TRIED = 32  # candidates if one is likely

# The result of a search
NOTHING, NEIGHBOR, FOUND = 0, 1, 2


@jit
def recent_period(record, length):
    """Return the least n for which the last 2n sections, at least FEWEST_REPEATED, repeat, or 0."""
    # The last section rules out nearly all n: its return is compared with the largest values of
    # the rows that `repeats` looks at.
    columns, first = record.shape[1], length
    bounds = np.zeros(columns)
    for n in range(1, min(MOST_PERIODS, length // 3) + 1):
        count = max(2 * n, FEWEST_REPEATED)
        while first > max(length - count - n, 0):
            first -= 1
            for c in range(columns):
                bounds[c] = max(bounds[c], TOLERANCE * abs(record[first, c]))
        near = True
        for c in range(columns):
            near = near and abs(record[length - 1, c] - record[length - 1 - n, c]) <= bounds[c]
        if near and repeats(record, length, n, count, TOLERANCE):
            return n
    return 0


@jit
def near_returns(space, course, chaotic):
    """Return the distances [J^0.5] of the last section m from section m - n, if near, by n.

    inf for n = 0 and if a return after fewer periods is as near. n ends at MOST_PERIODS, or where
    the course does not hold section m - 2n. In chaos many returns are near by chance: there, the
    distance of m - n from m - 2n must be 1 to SLOW_RETURN times that of m from m - n.
    """
    m, nearest_yet = last_of(course), math.inf
    sections = bare_course(course)
    last = section_at(space, sections, m)
    returns = np.full(min(MOST_PERIODS, (m - oldest_of(course)) // 2) + 1, math.inf)
    for n in range(1, len(returns)):
        other = section_at(space, sections, m - n)
        far = distance(space, last, other)
        if not far < nearest_yet:
            continue
        nearest_yet = far
        before = distance(space, other, section_at(space, sections, m - 2 * n))
        if not chaotic or far <= before <= SLOW_RETURN * far:
            returns[n] = far
    return returns


@jit
def try_period(flow, course, n, apart, evidence):
    """Search for a stable orbit of minimal period n that the orbit approaches.

    FOUND: the evidence is filled. NEIGHBOR: there is an orbit of period n within `apart` of the
    section that is stable but not approached, or a saddle, as lies beside each stable orbit on an
    invariant curve. apart: the largest step of Newton's method [J^0.5].
    """
    width, m = width_of(flow.space), last_of(course) // n * n
    x = section_at(flow.space, bare_course(course), m)
    y, points, tangent = np.empty(width), np.empty((n, width)), np.zeros(width * width)
    for i in range(width):
        y[i] = x[i]
    counts = np.zeros(len(evidence.impacts), np.int64)
    residual, clearance, slowest = polish(flow, y, points, counts, tangent, apart)
    if not residual < np.inf or not is_minimal(flow.space, y, points):
        return NOTHING
    cycle = cycle_through(flow.space, y, tangent, points)
    multipliers = eigenvalues(matrix_of(tangent, flow.space.size, width))
    radius = spectral_radius(multipliers)
    stable = radius < 1.0 - MARGIN
    if not stable or not attracted(flow, cycle, x):
        beside = distance(flow.space, x, y) <= apart
        return NEIGHBOR if beside and (stable or is_saddle(multipliers)) else NOTHING
    row = evidence.row
    row[ev.KIND], row[ev.CYCLE_PERIOD] = PERIODIC, n
    row[ev.RESIDUAL], row[ev.RADIUS] = residual, radius
    row[ev.CLEARANCE], row[ev.SLOWEST] = clearance, slowest
    row[ev.SETTLING] = settling_period(flow, course, cycle)
    for wall in range(len(counts)):
        evidence.impacts[wall] = counts[wall]
    for i in range(len(tangent)):
        evidence.monodromy[i] = tangent[i]
    for i in range(len(y)):
        evidence.point[i] = y[i]
    return FOUND


@jit
def find_period(flow, course, most, periods, chaotic, evidence):
    """Try the n of a recurrence, then those of near returns.

    The smallest n times distance is tried first. At most `most` near returns are tried, and the sum
    of their n is at most `periods`. Returns FOUND or NOTHING; NEIGHBOR if the sections recur, an
    orbit lies beside them, or not all near returns were tried.
    """
    n = recent_period(course.record, course.length)
    result, tried, spent = NOTHING, 0, 0
    if n > 0:
        if try_period(flow, course, n, math.inf, evidence) == FOUND:
            return FOUND
        result = NEIGHBOR
    returns = near_returns(flow.space, course, chaotic)
    returns[n] = math.inf
    while True:
        # the near return of least distance times n, its cost
        best = 0
        for i in range(1, len(returns)):
            if returns[i] < math.inf and (best == 0 or i * returns[i] < best * returns[best]):
                best = i
        if best == 0:
            return result
        tried, spent = tried + 1, spent + best
        if tried > most or spent > periods:
            return NEIGHBOR
        # the distance of the last section from the nearest of the n - 1 before it
        apart, sections, m = math.inf, bare_course(course), last_of(course)
        last = section_at(flow.space, sections, m)
        for p in range(m - best + 1, m):
            apart = min(apart, distance(flow.space, last, section_at(flow.space, sections, p)))
        returns[best] = math.inf
        before = section_at(flow.space, sections, m - best)
        if chaotic and departs(flow, before, last, best):
            continue
        outcome = try_period(flow, course, best, apart, evidence)
        if outcome == FOUND:
            return FOUND
        result = max(result, outcome)


# ---- the verdict ---------------------------------------------------------------------------------


SMOOTH_DIGITS = 7.0  # digits to which averages agree only on a torus
STEADY = 0.01  # largest relative change of a mean square of a steady motion
FORGOTTEN = 4.0  # -ln of the factor by which areas must have shrunk; see `forgets`
RESOLVED = -18.0  # ln det M, 1.5e-8: round-off of 1e-16 in M leaves eight digits of it
ALIGNING = 2  # cycles that align the variations with the directions of their growth


@jit
def note_exponents(evidence, growth, logs, period, count):
    """Write the largest exponent with its half-width, and the first `count` exponents [1/s]."""
    mean, width = mean_and_width(logs)
    width = max(width, MARGIN)
    evidence.row[ev.LYAPUNOV], evidence.row[ev.INTERVAL] = mean / period, width / period
    for i in range(count):
        evidence.exponents[i] = growth[i] / (len(logs) * period)


@jit
def note_cycle(flow, evidence, period):
    """Write the exponents of a periodic orbit of n periods T [s].

    The largest is ln |mu| / nT. EXPONENTS stay NaN if the monodromy matrix resolves all
    multipliers: a reader takes ln |mu| / nT from it. That of a long orbit does not: then they are
    the growth over a cycle, after ALIGNING cycles. CYCLE_PERIOD, RADIUS and POINT must have been
    filled.
    """
    row, exponents, width = evidence.row, evidence.exponents, width_of(flow.space)
    radius, n = row[ev.RADIUS], int(row[ev.CYCLE_PERIOD])
    largest = log(radius) if radius > 0.0 else -np.inf
    row[ev.LYAPUNOV], row[ev.INTERVAL] = largest / (n * period), 0.0
    row[ev.DIGITS] = np.nan
    exponents[:] = np.nan
    if volume_of(flow, evidence.point, evidence.monodromy, n) > RESOLVED:
        return
    state, tangent, growth = state_for(flow), np.zeros(width * width), np.zeros(width)
    place_state(flow, evidence.point, state)
    set_identity(tangent, width)
    for _ in range(ALIGNING + 1):
        growth[:] = 0.0
        logs, nothing = np.zeros(n), no_section(flow.space)
        if follow_growth(flow, nothing, state, tangent, logs, growth) != OK:
            return
    for i in range(flow.space.size):
        exponents[i] = growth[i] / (n * period)
    # The largest exponent from the matrix is better than the growth of one variation, which aligns
    # slowly if the first two multipliers are nearly as large, and not at all if they are a complex
    # pair. The growth of an area does not suffer from that: the sum of the first two stays.
    if row[ev.LYAPUNOV] > -np.inf:
        off = exponents[0] - row[ev.LYAPUNOV]
        exponents[0] -= off
        exponents[1] += off


@by_flow
def least_extent(space, record, length, i):
    """Return an extent of displacement i that is round-off of the motion."""
    return 0.0


@jit
def note_digits(space, record, length, count, row):
    """Write to how many digits averages of the last `count` sections agree, the worst of them."""
    digits = 15.0
    for i in range(space.size // 2):
        values = record[length - count : length, column_of(space, i)].copy()
        digits = min(digits, digits_of(values, least_extent(space, record, length, i)))
    row[ev.DIGITS] = digits


@jit
def seems_chaotic(row):
    """Return True if the largest exponent is above zero and averages are not those of a torus."""
    above = row[ev.LYAPUNOV] - row[ev.INTERVAL] > 0.0
    return above and row[ev.DIGITS] < SMOOTH_DIGITS


@jit
def seems_quasiperiodic(trace, row):
    """Return True if exponent and averages are those of a torus."""
    zero = abs(row[ev.LYAPUNOV]) <= max(row[ev.INTERVAL], MARGIN * abs(trace))
    return zero and row[ev.DIGITS] >= SMOOTH_DIGITS


@jit
def is_steady(space, record, length, count):
    """Return True if weighted mean squares about the mean agree in both halves of `count` sections.

    Those of a free oscillation whose areas shrink by FORGOTTEN meanwhile differ by a factor of e^2.
    """
    for i in range(space.size // 2):
        squares, mean = record[length - count : length, column_of(space, i)].copy(), 0.0
        for value in squares:
            mean += value / count
        for j in range(count):
            squares[j] = (squares[j] - mean) * (squares[j] - mean)
        early = weighted_mean(squares, 0, count // 2)
        late = weighted_mean(squares, count // 2, count)
        least = least_extent(space, record, length, i)
        if max(early, late) > least * least and abs(early - late) > STEADY * max(early, late):
            return False
    return True


@jit
def forgets(count, trace, exponents, period, time):
    """Return True if the motion forgets its start within `time` [s], or if nothing dissipates.

    On an attracting torus the first exponent is zero and the second negative. A free oscillation
    that has not decayed has a pair of exponents that are nearly zero. Their sum is the growth of
    areas, which unlike that of lengths does not vary from period to period on an invariant plane.
    """
    total = 0.0
    for i in range(count):
        total += exponents[i]
    if trace == 0.0 and total * period > -MARGIN:
        return True
    return (exponents[0] + exponents[1]) * time < -FORGOTTEN


@jit
def judge(flow, ends, record, first, stages, evidence):
    """Fill the `Evidence`, return a status.

    ends: the states (2, ...) at the orbit's beginning and end; record (periods, components): its
    sections after the `first` periods; stages: further periods of each stage.
    """
    course = OrbitSections(record, len(record), first, ends[0].copy())
    row, period = evidence.row, flow.period
    for values in evidence:
        values[:] = np.nan
    row[ev.KIND], row[ev.CYCLE_PERIOD], row[ev.SETTLING] = UNDETERMINED, 0.0, -1.0
    now = ends[1].copy()
    tangent, growth = begin_growth(flow)
    count = min(flow.space.size, len(growth))  # of exponents
    followed = 0  # periods with variations
    for stage in range(len(stages) + 1):
        row[ev.WATCHED] = course.first + course.length
        # a stable periodic orbit ends the search; an orbit that is not chaotic may have a long one
        chaotic = row[ev.KIND] == CHAOTIC
        long = stage > 0 and not chaotic
        most, periods = (MANY_TRIED, stages[stage - 1]) if long else (FEW_TRIED, SUM_TRIED)
        outcome = find_period(flow, course, most, periods, chaotic, evidence)
        if outcome == FOUND:
            note_cycle(flow, evidence, period)
            note_chaotic_transient(flow, course, evidence, period)
            return OK
        # a torus: no periodic orbit beside it, an exponent of zero, averages that converge fast
        smooth = seems_quasiperiodic(flow.trace, row)
        if row[ev.KIND] == UNDETERMINED and long and outcome == NOTHING and smooth:
            time, exponents = stages[stage - 1] * period, evidence.exponents
            if forgets(count, flow.trace, exponents, period, time) and is_steady(
                flow.space, course.record, course.length, followed
            ):
                row[ev.KIND] = QUASIPERIODIC
        if stage == len(stages):
            return OK
        # the next stage: with variations, unless the kind is already determined
        further = stages[stage]
        length = course.length
        record = np.empty((length + further, course.record.shape[1]))
        for p in range(length):
            for c in range(record.shape[1]):
                record[p, c] = course.record[p, c]
        rows = record[length:]
        if row[ev.KIND] == UNDETERMINED:
            followed += further
            growth[:] = 0.0
            logs = np.zeros(further)
            status = follow_growth(flow, rows, now, tangent, logs, growth)
            if status == OK:
                note_exponents(evidence, growth, logs, period, count)
                note_digits(flow.space, record, length + further, followed, row)
                if seems_chaotic(row):
                    row[ev.KIND] = CHAOTIC
        else:
            status = run_on(flow, rows, further, now)
        if status != OK:
            return status
        course = OrbitSections(record, length + further, course.first, course.origin)
    return OK
