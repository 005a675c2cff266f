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

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import log
from ..orbit.growth import digits_of, weighted_mean
from ..orbit.variations import new_state, no_section, place_state, set_identity, shrunk_in_contacts
from ..scene import evidence_rows as ev
from ..scene.codes import CHAOTIC, OK, QUASIPERIODIC, UNDETERMINED
from .course import Course, course_with_room, follow_course, follow_growth, longer
from .period_search import FEW_TRIED, FOUND, MANY_TRIED, NOTHING, SUM_TRIED, find_period
from .settling import MARGIN, growth_of, note_chaotic_transient

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
    """Tell whether the largest exponent lies above zero, and averages are not those of a torus."""
    above = evidence[ev.LYAPUNOV] - evidence[ev.INTERVAL] > 0.0
    return above and evidence[ev.DIGITS] < SMOOTH_DIGITS


@jit
def seems_quasiperiodic(trace, evidence):
    """Tell whether exponent and averages are those of a torus."""
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
    """Say what an orbit is; see `evidence_rows` for the columns of `evidence` (COLUMNS,).

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
            status = follow_course(flow, course, more, now)
        if status != OK:
            return status
        course = longer(course, more)
    return OK
