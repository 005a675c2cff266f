"""What an orbit is, with the evidence: periodic, quasi-periodic, chaotic or undetermined.

An orbit is periodic if shooting closes a stable orbit of minimal period to round-off and the orbit
at hand is drawn to it as the monodromy matrix predicts. It is chaotic if the interval of its
largest exponent lies above zero. It is quasi-periodic if that exponent is zero, time averages
converge as only those of a smooth torus do, and the orbit does not return. Everything else is
undetermined, after as many further periods as the effort allows: each stage looks at what the one
before left undetermined, so that more effort never changes a label.
"""

from __future__ import annotations

import numpy as np

from .codes import (
    CHAOTIC,
    OK,
    PERIODIC,
    QUASIPERIODIC,
    TRANSIENT_CHAOS,
    UNDETERMINED,
)
from .compiling import jit
from .eigenvalues import spectral_radius
from .elementary import log
from .growth import digits_of, mean_and_width
from .observe import note_section
from .recurrence import TOLERANCE, period_of
from .scene import scale_of
from .shooting import is_minimal, matrix_of, polish, span_of
from .variations import (
    advance,
    distance,
    new_state,
    norm,
    orthonormalise,
    place_state,
    set_identity,
)

# Columns of the evidence, a row for each orbit; NaN where a number does not apply:
#
#   0 KIND            of `codes`                     8 LARGEST        Lyapunov exponent [1/s]
#   1 PERIOD          n of nT, 0 if not periodic     9 WIDTH          half its 99 % interval [1/s]
#   2 NEAR            k at the near wall per nT     10 DIGITS         to which time averages agree
#   3 FAR             k at the far wall per nT      11 SETTLING       period, -1 if it never settles
#   4 RESIDUAL        of the orbit, relative        12 WATCHED        periods looked at
#   5 RADIUS          largest |multiplier|          13 PASSING        exponent while settling [1/s]
#   6 CLEARANCE       nearest miss [m]              14 PASSING_WIDTH  half its 99 % interval [1/s]
#   7 SLOWEST         impact [m/s]
#
#   15 EXPONENTS      4 Lyapunov exponents [1/s]
#   19 MATRIX         16 of the monodromy matrix, column by column
#   35 POINT          4 of a section point (x1, v1, r, s) of the periodic orbit
KIND, PERIOD, NEAR, FAR, RESIDUAL, RADIUS, CLEARANCE, SLOWEST = range(8)
LARGEST, WIDTH, DIGITS, SETTLING, WATCHED, PASSING, PASSING_WIDTH = range(8, 15)
EXPONENTS, MATRIX, POINT = 15, 19, 35
COLUMNS = 39

MARGIN = 1.0e-6  # distance of the largest multiplier's modulus from one: its error may be as large,
#                  and so may that of a mean growth per period, however little the growth varies
NEAR_RETURN = 0.05  # distance of a return, relative to the orbit, that proposes a period
MOST_PROPOSED = 4  # periods proposed by near returns that are tried: each costs a few orbits
MOST_TRIED_PERIODS = 96  # the sum of these periods, for the same reason
PREDICTION_ERROR = 0.25  # error of a predicted return, as a share of the deviation: it is linear
TINY = 1.0e-7  # deviation, relative to the orbit, in which rounding and method errors show
SMOOTH = 7.0  # digits to which averages agree only on a torus
BLUR = 2.0e-15  # round-off of an r computed from a section's x1 - x2, relative to the rest offset
LONG_TRANSIENT = 50  # periods before settling; a shorter time is too short for an exponent


@jit
def state_in_row(flow, record, p, y):
    """Let y (4,) be the state in row p of a section in the user's coordinates."""
    y[:] = 0.0
    y[0], y[1] = record[p, 0], record[p, 1]
    if flow.size == 4:
        y[2], y[3] = y[0] - record[p, 2] + flow.rest, y[1] - record[p, 3]


@jit
def image_of(flow, tangent, x, y):
    """Return M (x - y), M the matrix of the variations."""
    image = np.zeros(4)
    for c in range(flow.size):
        for i in range(flow.size):
            image[i] += tangent[4 * c + i] * (x[c] - y[c])
    return image


@jit
def resolvable(flow, span):
    """Return the least deviation, a `norm`, that shows on a section of an orbit of size `span`.

    Sections hold positions: of a motion that is tiny beside the damper's rest offset they keep few
    digits.
    """
    ps, damper = flow.prepared.ps, flow.prepared.damper
    return TINY * span + scale_of(ps, damper, 0.0, 0.0, BLUR * flow.rest, 0.0)


@jit
def returns_as_predicted(flow, tangent, y, now, then, span):
    """Tell whether the state `now` returns to `then` after the orbit's n periods as predicted.

    True where the deviation from the orbit's point y is mapped by its monodromy matrix, or is too
    small to tell.
    """
    far, tiny = distance(flow, now, y), resolvable(flow, span)
    if far <= tiny and distance(flow, then, y) <= tiny:
        return True
    image = image_of(flow, tangent, now, y)
    for i in range(4):
        image[i] += y[i]
    return far <= span and distance(flow, image, then) <= PREDICTION_ERROR * far


@jit
def settling_period(flow, record, length, tangent, y, n, span):
    """Return the first period from which on the section obeys the final orbit's own law.

    Walking backwards from the end in steps of n, for as long as every return is as predicted.
    """
    now, then = np.zeros(4), np.zeros(4)
    p = length - 1
    state_in_row(flow, record, p, then)
    while p >= n:
        state_in_row(flow, record, p - n, now)
        if not returns_as_predicted(flow, tangent, y, now, then, span):
            return p + 1
        for i in range(4):
            then[i] = now[i]
        p -= n
    return 0


@jit(dissolved=True)
def attracted(flow, tangent, y, last, n, span):
    """Tell whether the state `last` returns to the stable orbit through y as predicted."""
    state, variations = new_state(), np.zeros(16)
    if distance(flow, last, y) <= TINY * span:
        return True
    place_state(flow, last, state)
    for _ in range(n):
        set_identity(variations)
        if advance(flow.prepared.arc, flow, variations, state) != OK:
            return False
    return returns_as_predicted(flow, tangent, y, last, state, span)


@jit(dissolved=True)
def try_period(flow, record, length, last, n, evidence):
    """Try to find a stable orbit of minimal period n at the end of a section; fill the evidence.

    last: the state (4,) there, sharper than the section holds it.
    """
    y = last.copy()
    points, counts, tangent = np.empty((n, 4)), np.zeros(2, np.int64), np.zeros(16)
    residual, clearance, slowest = polish(flow, y, points, counts, tangent)
    if not residual < np.inf:
        return False
    matrix, span = matrix_of(tangent, flow.size), span_of(flow, points)
    radius = spectral_radius(matrix)
    if not radius < 1.0 - MARGIN or not is_minimal(flow, y, points):
        return False
    copy = tangent.copy()
    if not attracted(flow, copy, y, last, n, span):
        return False
    evidence[KIND], evidence[PERIOD] = PERIODIC, n
    evidence[NEAR], evidence[FAR] = counts[0], counts[1]
    evidence[RESIDUAL], evidence[RADIUS] = residual, radius
    evidence[CLEARANCE], evidence[SLOWEST] = clearance, slowest
    evidence[SETTLING] = settling_period(flow, record, length, copy, y, n, span)
    for i in range(16):
        evidence[MATRIX + i] = copy[i]
    for i in range(4):
        evidence[POINT + i] = y[i]
    return True


@jit(dissolved=True)
def find_period(flow, record, length, last, hint, evidence):
    """Try the period that a recurrence found, then those of near returns."""
    tried, followed = 0, 0
    y = np.zeros(4)
    span = 0.0
    for p in range(max(0, length - MOST_TRIED_PERIODS), length):
        state_in_row(flow, record, p, y)
        span = max(span, norm(flow, y))
    for i in range(min(MOST_TRIED_PERIODS, length - 1) + 1):
        known = i == 0
        n = hint if known else i
        if n == 0 or (n == hint and not known):
            continue
        state_in_row(flow, record, length - 1 - n, y)
        if known or distance(flow, last, y) <= NEAR_RETURN * span:
            if not known:
                tried, followed = tried + 1, followed + n
            if tried > MOST_PROPOSED or followed > MOST_TRIED_PERIODS:
                return False
            if try_period(flow, record, length, last, n, evidence):
                return True
    return False


@jit
def follow_growth(flow, state, tangent, logs, growth, record, first):
    """Follow an orbit and its variations for len(logs) periods; return a status.

    The section is noted from row `first` on; logs take the growth of the first variation in each
    period, growth (4,) that of all.
    """
    for p in range(len(logs)):
        before = growth[0]
        status = advance(flow.prepared.arc, flow, tangent, state)
        if status != OK:
            return status
        orthonormalise(tangent, flow.size, growth)
        logs[p] = growth[0] - before
        if len(record) > first + p:
            note_section(
                flow.prepared.damper, record, first + p, state[0], state[1], state[2], state[3]
            )
    return OK


@jit
def with_room(record, more):
    """Return a copy of a section with room for more periods."""
    grown = np.empty((len(record) + more, record.shape[1]))
    for p in range(len(record)):
        for c in range(record.shape[1]):
            grown[p, c] = record[p, c]
    return grown


@jit
def growth_of(logs):
    """Return `mean_and_width` of the growth per period, the width no less than MARGIN."""
    mean, width = mean_and_width(logs)
    return mean, max(width, MARGIN)


@jit
def note_exponents(evidence, growth, periods, period, size):
    """Write all exponents [1/s]."""
    for i in range(size):
        evidence[EXPONENTS + i] = growth[i] / (periods * period)


@jit
def note_cycle_exponent(flow, evidence, period):
    """Write the largest exponent of a periodic orbit, ln |mu| / nT, which needs no average."""
    radius = evidence[RADIUS]
    largest = log(radius) if radius > 0.0 else -np.inf
    evidence[LARGEST], evidence[WIDTH] = largest / (evidence[PERIOD] * period), 0.0


@jit(dissolved=True)
def note_chaotic_transient(flow, origin, evidence, period):
    """Note whether the orbit was chaotic for long before it settled on a periodic orbit."""
    periods = int(evidence[SETTLING])
    if flow.prepared.arc is None or periods < LONG_TRANSIENT:
        return
    state, tangent, growth = new_state(), np.zeros(16), np.zeros(4)
    place_state(flow, origin, state)
    set_identity(tangent)
    logs, nowhere = np.zeros(periods), np.empty((0, flow.size))
    if follow_growth(flow, state, tangent, logs, growth, nowhere, 0) != OK:
        return
    mean, width = growth_of(logs)
    evidence[PASSING], evidence[PASSING_WIDTH] = mean / period, width / period
    if mean - width > 0.0:
        evidence[KIND] = TRANSIENT_CHAOS


@jit(dissolved=True)
def judge(flow, ends, record, hint, stages, evidence):
    """Say what an orbit is; see the columns of `evidence` (COLUMNS,).

    ends: the states (2, SIZE) at its beginning and end; record (periods, components) its section
    all the way; hint: a period found by recurrence or 0; stages: further periods allowed, stage
    by stage. Returns a status.
    """
    length = len(record)
    evidence[:] = np.nan
    evidence[KIND], evidence[PERIOD], evidence[SETTLING] = UNDETERMINED, 0.0, -1.0
    period = flow.exact_grid.h * flow.exact_grid.n
    now, tangent, growth = ends[1].copy(), np.zeros(16), np.zeros(4)
    set_identity(tangent)
    for stage in range(len(stages) + 1):
        # a stable periodic orbit explains what has been seen
        if find_period(flow, record, length, now[:4], hint, evidence):
            note_cycle_exponent(flow, evidence, period)
            evidence[WATCHED] = length
            note_chaotic_transient(flow, ends[0], evidence, period)
            return OK
        # what the last stage has seen is decided by exponent and averages
        if stage > 0 and decide(flow, record, length, stages[stage - 1], evidence):
            return OK
        if stage == len(stages):
            return OK
        # otherwise it is followed further, with its variations
        logs = np.zeros(stages[stage])
        record = with_room(record, stages[stage])
        growth[:] = 0.0
        status = follow_growth(flow, now, tangent, logs, growth, record, length)
        if status != OK:
            return status
        hint, length = 0, length + len(logs)
        mean, width = growth_of(logs)
        evidence[LARGEST], evidence[WIDTH] = mean / period, width / period
        evidence[WATCHED] = length
        note_exponents(evidence, growth, len(logs), period, flow.size)
    return OK


@jit
def decide(flow, record, length, watched, evidence):
    """Decide by the exponent and the averages of the last stage; True if that says something."""
    digits = 15.0
    for c in range(0, flow.size, 2):
        digits = min(digits, digits_of(record[length - watched : length, c].copy()))
    evidence[DIGITS] = digits
    largest, width = evidence[LARGEST], evidence[WIDTH]
    if largest - width > 0.0 and digits < SMOOTH:
        evidence[KIND] = CHAOTIC
        return True
    if abs(largest) <= max(width, MARGIN * abs(flow.trace)) and digits >= SMOOTH:
        if period_of(record[length - watched : length], TOLERANCE) > 0:
            return False  # periodic, or at rest, and nothing is known to draw other orbits to it
        evidence[KIND] = QUASIPERIODIC
        return True
    return False
