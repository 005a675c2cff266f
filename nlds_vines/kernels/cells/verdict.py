"""What an orbit is, with the evidence: periodic, quasi-periodic, chaotic or undetermined.

An orbit is periodic if shooting closes a stable orbit of minimal period to round-off and the orbit
at hand is drawn to it as the monodromy matrix predicts. It is chaotic if the interval of its
largest exponent lies above zero. It is quasi-periodic if that exponent is zero, time averages
converge as only those of a smooth torus do, the motion is steady and has had the time to forget its
start, and neither the orbit nor a near return of it belongs to a periodic one. Everything else is
undetermined.

A verdict is reached stage by stage, each of so many further periods. A periodic orbit ends the
search; chaos and a torus may be transient, and are followed for as long as the effort allows. So
more effort can only find more.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import exp, log, log10
from ..numerics.fours import bare, four, four_at, four_of, number_of
from ..numerics.matrices import eigenvalues, is_saddle, spectral_radius
from ..orbit.recurrence import TOLERANCE, repeats
from ..orbit.variations import (
    TOGETHER,
    advance_flow,
    distance,
    is_minimal,
    lost_of,
    matrix_of,
    new_state,
    no_section,
    orthonormalize,
    place_state,
    polish,
    run_on,
    set_identity,
    shrunk_in_contacts,
    span_of,
)
from ..scene import codes as ev
from ..scene.codes import CHAOTIC, OK, PERIODIC, QUASIPERIODIC, TRANSIENT_CHAOS, UNDETERMINED
from ..scene.scene import scale_of

# ---- Growth rates with their uncertainty, and how fast time averages converge --------------------
#
# The numbers here are sequences; where they come from does not matter. An orbit hands in logarithms
# of growth per period, a map those per iteration.


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


# --------------------------------------------------------------------------------------------------
# The course of an orbit under judgement: its sections as far as they are kept, and more of them.
#
# However an orbit is followed, with its variations or without, it is the same to the last bit as
# if it had been run in one go: the variations go along and change nothing. So no verdict depends on
# where the periods of a request end and those of the verdict begin.


MOST_SHRUNK = 6.0  # logarithm of what a volume may shrink by before variations are projected
SEVERAL = 8  # times that variations are projected in a batch, at least


class Course(NamedTuple):
    """The sections of an orbit; section m is the state at the time m T, section 0 the start."""

    record: np.ndarray  # (rows, components) in the user's coordinates; row 0 is section first + 1
    length: int  # rows that are filled
    first: int  # periods before those of the record, whose sections are not kept
    origin: np.ndarray  # (SIZE,) section 0


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
    return Course(record, course.length, course.first, bare(course.origin))


@jit
def state_of(y):
    return y[0], y[1], y[2], y[3]


@jit
def section_at(space, course, m):
    """Return the state (x1, v1, r, s) at section m of a bare course."""
    if m == 0:
        return state_of(course.origin)
    record, i = course.record, space.size * (m - course.first - 1)
    x1, v1 = record[i], record[i + 1]
    if space.size == 2:
        return x1, v1, 0.0, 0.0
    return x1, v1, x1 - record[i + 2] + space.rest, v1 - record[i + 3]


@jit
def course_with_room(course, more):
    record = np.empty((course.length + more, course.record.shape[1]))
    for p in range(course.length):
        for c in range(record.shape[1]):
            record[p, c] = course.record[p, c]
    return Course(record, course.length, course.first, course.origin)


@jit
def longer(course, more):
    return Course(course.record, course.length + more, course.first, course.origin)


@jit
def follow_growth(flow, rows, state, tangent, logs, growth):
    """Follow an orbit and its variations for len(logs) periods; return a status.

    rows take its sections, as far as there is room. logs take the logarithm by which the first
    variation grows in a period (the mean of a few), growth (4,) that of all.
    """
    flow.clearance[0] = 0.0  # no near miss is looked for
    # Variations are made orthonormal after so many periods: in between they turn towards the
    # fastest. No volume may shrink by more than exp(-MOST_SHRUNK), and the batches whose means
    # give the uncertainty of a growth must be SEVERAL times as long.
    shrinks = abs(flow.trace) * flow.exact_grid.h * flow.exact_grid.n
    most = min(MOST_SHRUNK / max(shrinks, MOST_SHRUNK / TOGETHER), len(logs) / (BATCHES * SEVERAL))
    together = max(1, int(most))
    for p in range(0, len(logs), together):
        before, n = growth[0], min(together, len(logs) - p)
        status = advance_flow(flow, rows[p : p + n], n, tangent, state)
        if status != OK:
            return status
        orthonormalize(
            tangent, flow.space.size, growth, lost_of(flow.prepared.near, flow.prepared.far)
        )
        lost = growth[0] == -np.inf  # no variation is left: a damper that sticks forgets all
        logs[p : p + n] = -np.inf if lost else (growth[0] - before) / n
    return OK


# ---- When an orbit settled on the periodic orbit that it ends in, and what it was before ---------
#
# An orbit has settled from the first section on from which every return, n periods later, is as the
# monodromy matrix predicts. Only the sections whose number is a multiple of n are asked, so that
# the answer does not depend on how long the orbit was watched. What is not kept of its course is
# run again from its beginning.


MARGIN = 1.0e-6  # distance of the largest multiplier's modulus from one: its error may be as large,
#                  and so may that of a mean growth per period, however little the growth varies
PREDICTION_ERROR = 0.25  # error of a predicted return, as a share of the deviation: it is linear
# deviation, relative to the orbit, beyond which nothing is predicted; at rest it is one
UNPREDICTED = 2.0
CONVINCING = 1000  # periods for which returns are as predicted only near a stable orbit
TINY = 1.0e-7  # deviation, relative to the orbit, in which rounding and method errors show
BLUR = 2.0e-15  # round-off of an r computed from a section's x1 - x2, relative to the rest offset
LONG_TRANSIENT = 50  # periods before settling; a shorter time is too short for an exponent
LONGEST_LOOK = 2400  # periods of a transient whose exponent is measured: the first ones


class Cycle(NamedTuple):
    """A stable orbit of n periods, and what its returns are predicted with."""

    n: int
    point: Any  # (4,) its state (x1, v1, r, s) at the sections that are multiples of n, a bare row
    tangent: Any  # (16,) its monodromy matrix there, column by column, a bare row
    span: float  # its largest energy norm at a section [J^0.5]
    resolvable: float  # the least deviation that shows on a section, in the energy norm [J^0.5]


@jit
def cycle_through(space, y, tangent, points):
    """Return the `Cycle` through y whose sections are `points` (n, 4).

    Sections hold positions: of a motion that is tiny beside the damper's rest offset they keep few
    digits.
    """
    span = span_of(space, points)
    blur = scale_of(space.ps, space.damper, 0.0, 0.0, BLUR * space.rest, 0.0)
    return Cycle(len(points), bare(y), bare(tangent), span, TINY * span + blur)


@jit
def returns_as_predicted(space, cycle, now, far, then, far_then):
    """Return True if the state `now` returns to `then`, n periods later, as a cycle predicts.

    Its monodromy matrix maps the deviation of `now` from the cycle's point to that of `then`. far,
    far_then: the energy norms of both deviations. Those that do not show on a section agree.
    """
    if far <= cycle.resolvable and far_then <= cycle.resolvable:
        return True
    image = four(0.0)
    for c in range(space.size):
        image = image + four_at(cycle.tangent, 4 * c) * (now[c] - cycle.point[c])
    image = image + four_at(cycle.point, 0)
    off = image - four_of(then[0], then[1], then[2], then[3])
    error = scale_of(
        space.ps, space.damper, number_of(off, 0), number_of(off, 1), number_of(off, 2),
        number_of(off, 3),
    )  # fmt: skip
    return far <= UNPREDICTED * cycle.span and error <= PREDICTION_ERROR * far


@jit
def attracted(flow, cycle, x):
    """Return True if the state x is drawn to a stable cycle.

    Each return must be as predicted, until the deviation is too small to tell, or for so long that
    no chance explains it: one flight without impact always obeys the law of an impact-free orbit.
    """
    state, then, n = new_state(), state_of(x), cycle.n
    far_then = distance(flow.space, then, cycle.point)
    place_state(flow, x, state)
    for _ in range(0, CONVINCING, n):
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return False
        now, far, then = then, far_then, state_of(state)
        far_then = distance(flow.space, then, cycle.point)
        if not returns_as_predicted(flow.space, cycle, now, far, then, far_then):
            return False
        if far_then <= cycle.resolvable:
            return True
    return True


@jit
def settling_period(flow, course, cycle):
    """Return the number of the first section from which on all returns are as predicted.

    Of the sections whose numbers are multiples of n; the last one if not even the last return is.
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
    state, settled = new_state(), 0
    place_state(flow, course.origin, state)
    then = state_of(state)
    far_then = distance(flow.space, then, cycle.point)
    for p in range(n, m + 1, n):
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return m
        now, far, then = then, far_then, state_of(state)
        far_then = distance(flow.space, then, cycle.point)
        if not returns_as_predicted(flow.space, cycle, now, far, then, far_then):
            settled = p
    return settled


@jit
def growth_of(logs):
    """Return `mean_and_width` of the growth per period, the width no less than MARGIN."""
    mean, width = mean_and_width(logs)
    return mean, max(width, MARGIN)


@jit
def note_chaotic_transient(flow, course, evidence, period):
    """Note whether the orbit was chaotic for long before it settled on a periodic orbit."""
    periods = int(evidence[ev.SETTLING])
    if flow.prepared.scratch is None or periods < LONG_TRANSIENT:
        return
    state, tangent, growth = new_state(), np.zeros(16), np.zeros(4)
    place_state(flow, course.origin, state)
    set_identity(tangent)
    logs = np.zeros(min(periods, LONGEST_LOOK))
    if follow_growth(flow, no_section(flow.space), state, tangent, logs, growth) != OK:
        return
    mean, width = growth_of(logs)
    evidence[ev.PASSING], evidence[ev.PASSING_WIDTH] = mean / period, width / period
    if mean - width > 0.0:
        evidence[ev.KIND] = TRANSIENT_CHAOS


# ---- The search for the stable periodic orbit that an orbit ends in ------------------------------
#
# Sections that repeat propose a period, and so do near returns; Newton's method and the monodromy
# matrix decide. A return after n periods is near if it is nearer than every one before: the points
# of an orbit of n periods lie farther apart. On a torus such returns are rare, the denominators of
# the continued fraction of its rotation number.


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
    """Return by n the energy norm [J^0.5] of section m, the last, less section m - n, if near.

    inf for n = 0, and where a return of fewer periods is as near. n ends at MOST_PERIODS, or where
    section m - 2n is not kept. In chaos many returns are near by chance: there, m - n must lie as
    far or farther from m - 2n, but at most SLOW_RETURN times, a guess of how fast an orbit settles.
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
def spacing(space, course, n):
    """Return the distance of the last section from the nearest of the n - 1 before it."""
    m, nearest_yet = last_of(course), math.inf
    sections = bare_course(course)
    last = section_at(space, sections, m)
    for p in range(m - n + 1, m):
        nearest_yet = min(nearest_yet, distance(space, last, section_at(space, sections, p)))
    return nearest_yet


@jit
def try_period(flow, course, n, apart, evidence):
    """Try to find a stable orbit of minimal period n that the orbit is drawn to.

    FOUND fills the evidence. NEIGHBOR means an orbit of period n beside the sections that draws
    it not, or that is a saddle: such a one lies beside each stable orbit on a closed curve. The
    steps of Newton's method are at most `apart`, the distance to the nearest of the sections before
    that are fewer periods away.
    """
    x, y = section_at(flow.space, bare_course(course), last_of(course) // n * n), np.empty(4)
    for i in range(4):
        y[i] = x[i]
    points, counts, tangent = np.empty((n, 4)), np.zeros(2, np.int64), np.zeros(16)
    residual, clearance, slowest = polish(flow, y, points, counts, tangent, apart)
    if not residual < np.inf or not is_minimal(flow.space, y, points):
        return NOTHING
    cycle = cycle_through(flow.space, y, tangent, points)
    multipliers = eigenvalues(matrix_of(tangent, flow.space.size))
    radius = spectral_radius(multipliers)
    stable = radius < 1.0 - MARGIN
    if not stable or not attracted(flow, cycle, x):
        beside = distance(flow.space, x, y) <= apart
        return NEIGHBOR if beside and (stable or is_saddle(multipliers)) else NOTHING
    evidence[ev.KIND], evidence[ev.CYCLE_PERIOD] = PERIODIC, n
    evidence[ev.NEAR_IMPACTS], evidence[ev.FAR_IMPACTS] = counts[0], counts[1]
    evidence[ev.RESIDUAL], evidence[ev.RADIUS] = residual, radius
    evidence[ev.CLEARANCE], evidence[ev.SLOWEST] = clearance, slowest
    evidence[ev.SETTLING] = settling_period(flow, course, cycle)
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
            # the near return of least distance times n, its cost
            best = 0
            for m in range(1, len(returns)):
                if returns[m] < math.inf and (best == 0 or m * returns[m] < best * returns[best]):
                    best = m
            n = best
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


# ---- the verdict ---------------------------------------------------------------------------------


SMOOTH_DIGITS = 7.0  # digits to which averages agree only on a torus
STEADY = 0.01  # largest relative change of a mean square where the size of the motion is steady
FORGOTTEN = 4.0  # -ln of the factor by which areas must have shrunk; see `forgets`
RESOLVED = -18.0  # ln det M, 1.5e-8: with round-off of 1e-16 in M, eight digits of it are left
ALIGNING = 2  # cycles after which variations have the directions of a long orbit


@jit
def note_exponents(evidence, growth, logs, period, size):
    """Write the largest exponent with its width, and all of them [1/s]."""
    mean, width = growth_of(logs)
    evidence[ev.LYAPUNOV], evidence[ev.INTERVAL] = mean / period, width / period
    for i in range(size):
        evidence[ev.EXPONENTS + i] = growth[i] / (len(logs) * period)


@jit
def note_cycle(flow, evidence, period):
    """Write the largest exponent of a periodic orbit, ln |mu| / nT, which needs no average.

    PERIOD n, RADIUS and POINT are filled; period: T [s]. EXPONENTS stay NaN where the matrix
    resolves all multipliers: a reader takes ln |mu| / nT from MATRIX. That of a long orbit does
    not: there they are the growth over a cycle, once ALIGNING cycles have aligned the variations.
    """
    radius, n = evidence[ev.RADIUS], int(evidence[ev.CYCLE_PERIOD])
    largest = log(radius) if radius > 0.0 else -np.inf
    evidence[ev.LYAPUNOV], evidence[ev.INTERVAL] = largest / (n * period), 0.0
    evidence[ev.DIGITS] = np.nan
    evidence[ev.EXPONENTS : ev.EXPONENTS + 4] = np.nan
    volume = flow.trace * n * period  # ln |det M|, the sum of ln |mu|; contacts add theirs
    near, far = flow.prepared.near, flow.prepared.far
    volume += shrunk_in_contacts(near, far, flow, evidence[ev.POINT : ev.POINT + 4], n)
    if volume > RESOLVED:
        return
    state, tangent, growth = new_state(), np.zeros(16), np.zeros(4)
    place_state(flow, evidence[ev.POINT : ev.POINT + 4], state)
    set_identity(tangent)
    for _ in range(ALIGNING + 1):
        growth[:] = 0.0
        logs = np.zeros(n)
        if follow_growth(flow, no_section(flow.space), state, tangent, logs, growth) != OK:
            return
    for i in range(flow.space.size):
        evidence[ev.EXPONENTS + i] = growth[i] / (n * period)
    # LARGEST is better than the growth of one variation, which aligns slowly where the first two
    # multipliers are nearly as large, or not at all: a complex pair. The area of two does not
    # suffer from that, so the sum of the first two is kept
    if evidence[ev.LYAPUNOV] > -np.inf:
        off = evidence[ev.EXPONENTS] - evidence[ev.LYAPUNOV]
        evidence[ev.EXPONENTS] -= off
        evidence[ev.EXPONENTS + 1] += off


@jit
def note_digits(space, record, length, count, evidence):
    """Write to how many digits averages of the last `count` sections agree, the worst of them."""
    digits = 15.0
    for c in range(0, space.size, 2):
        digits = min(digits, digits_of(record[length - count : length, c].copy()))
    evidence[ev.DIGITS] = digits


@jit
def seems_chaotic(evidence):
    """Return True if the largest exponent is above zero and averages are not those of a torus."""
    above = evidence[ev.LYAPUNOV] - evidence[ev.INTERVAL] > 0.0
    return above and evidence[ev.DIGITS] < SMOOTH_DIGITS


@jit
def seems_quasiperiodic(trace, evidence):
    """Return True if exponent and averages are those of a torus."""
    zero = abs(evidence[ev.LYAPUNOV]) <= max(evidence[ev.INTERVAL], MARGIN * abs(trace))
    return zero and evidence[ev.DIGITS] >= SMOOTH_DIGITS


@jit
def is_steady(space, record, length, count):
    """Return True if the motion has the same size in both halves of the last `count` sections.

    A free oscillation whose areas shrink by FORGOTTEN meanwhile does not: its mean squares differ
    by a factor of e^2. The mean squares are weighted, and about the mean.
    """
    for c in range(0, space.size, 2):
        squares, mean = record[length - count : length, c].copy(), 0.0
        for value in squares:
            mean += value / count
        for i in range(count):
            squares[i] = (squares[i] - mean) * (squares[i] - mean)
        early = weighted_mean(squares, 0, count // 2)
        late = weighted_mean(squares, count // 2, count)
        if abs(early - late) > STEADY * max(early, late):
            return False
    return True


@jit
def forgets(size, trace, evidence, period, time):
    """Return True if the motion forgot its start within `time` [s], or if nothing dissipates.

    On an attracting torus one exponent is zero and the second is negative. A free oscillation that
    has not decayed has two that are nearly zero, a pair. Their sum is the growth of areas, which
    unlike that of lengths does not vary from period to period on an invariant plane.
    """
    total = 0.0
    for i in range(size):
        total += evidence[ev.EXPONENTS + i]
    if trace == 0.0 and total * period > -MARGIN:
        return True
    return (evidence[ev.EXPONENTS] + evidence[ev.EXPONENTS + 1]) * time < -FORGOTTEN


@jit
def judge(flow, ends, record, first, stages, evidence):
    """Say what an orbit is; see `codes` for the columns of `evidence` (COLUMNS,).

    ends: the states (2, SIZE) at its beginning and end; record (periods, components): its section
    after the `first` periods, to the end; stages: further periods allowed, stage by stage. Returns
    a status.
    """
    course = Course(record, len(record), first, ends[0].copy())
    evidence[:] = np.nan
    evidence[ev.KIND], evidence[ev.CYCLE_PERIOD], evidence[ev.SETTLING] = UNDETERMINED, 0.0, -1.0
    period = flow.exact_grid.h * flow.exact_grid.n
    now, tangent, growth = ends[1].copy(), np.zeros(16), np.zeros(4)
    set_identity(tangent)
    followed = 0  # periods with variations
    for stage in range(len(stages) + 1):
        evidence[ev.WATCHED] = course.first + course.length
        # a stable periodic orbit explains what has been seen; what is not chaotic may be a long one
        chaotic = evidence[ev.KIND] == CHAOTIC
        long = stage > 0 and not chaotic
        most, periods = (MANY_TRIED, stages[stage - 1]) if long else (FEW_TRIED, SUM_TRIED)
        found = find_period(flow, course, most, periods, chaotic, evidence)
        if found == FOUND:
            note_cycle(flow, evidence, period)
            note_chaotic_transient(flow, course, evidence, period)
            return OK
        # a torus has no periodic orbit beside it
        unknown = evidence[ev.KIND] == UNDETERMINED
        if unknown and long and found == NOTHING and seems_quasiperiodic(flow.trace, evidence):
            time = stages[stage - 1] * period
            if forgets(flow.space.size, flow.trace, evidence, period, time) and is_steady(
                flow.space, course.record, course.length, followed
            ):
                evidence[ev.KIND] = QUASIPERIODIC
        if stage == len(stages):
            return OK
        # it is followed further; if it is not known what it seems, with its variations
        more = stages[stage]
        course = course_with_room(course, more)
        if evidence[ev.KIND] == UNDETERMINED:
            followed += more
            growth[:] = 0.0
            logs, rows = np.zeros(more), course.record[course.length :]
            status = follow_growth(flow, rows, now, tangent, logs, growth)
            if status == OK:
                note_exponents(evidence, growth, logs, period, flow.space.size)
                note_digits(flow.space, course.record, course.length + more, followed, evidence)
                if seems_chaotic(evidence):
                    evidence[ev.KIND] = CHAOTIC
        else:
            rows = course.record[course.length : course.length + more]
            status = run_on(flow, rows, more, now)
        if status != OK:
            return status
        course = longer(course, more)
    return OK
