"""What an orbit is, with the evidence: periodic, quasi-periodic, chaotic, or not to be told yet.

Periodic is what shooting closes to round-off on a stable orbit of minimal period that the orbit at
hand is drawn to as the monodromy matrix foretells. Chaotic is a largest exponent whose interval
lies above zero. Quasi-periodic is an exponent of zero together with time averages that converge as
only those of a smooth torus do, on an orbit that does not return. Everything else is undetermined,
after as many further periods as the effort allows: each stage looks at what the one before could
not tell, so that more effort never changes a label.
"""

from __future__ import annotations

import math

import numpy as np

from .compiling import jit
from .growth import digits_of, mean_and_width
from .observe import note_section
from .orbit import OK
from .recurrence import TOLERANCE, period_of
from .ride import advance, fresh_state, gap_between, norm, orthonormalise, radius_of, seat, unit
from .scene import scale_of
from .shooting import matrix_of, minimal, polish, span_of

UNDETERMINED, PERIODIC, QUASIPERIODIC, CHAOTIC, TRANSIENT = range(5)  # `record.FLAGS`

# Columns of the evidence
KIND, PERIOD, NEAR, FAR, RESIDUAL, RADIUS, CLEARANCE, SOFTEST = range(8)
LARGEST, WIDTH, DIGITS, SETTLING, WATCHED, PASSING, PASSING_WIDTH = range(8, 15)
EXPONENTS, MATRIX, POINT = 15, 19, 35  # 4 exponents [1/s], 16 of the monodromy matrix, 4 of a point
COLUMNS = 39

MARGIN = 1.0e-6  # of the largest multiplier's modulus from one: what its error may be, and so
#                  that of a mean growth per period, however little the growth varies
NEAR_RETURN = 0.05  # distance of a return, relative to the orbit, that proposes a period
MOST_PROPOSED = 4  # periods tried ...
MOST_RIDDEN = 96  # ... and their sum
FORETOLD = 0.25  # share of a deviation by which its foretold return may be wrong
TINY = 1.0e-7  # deviation, relative to the orbit, in which rounding and method errors show
SMOOTH = 7.0  # digits to which averages agree only on a torus
BLURRED = 2.0e-15  # of the rest offset: what r cannot tell that was read from a section
LATE = 50  # periods that an orbit must wander before one asks whether that was chaos


@jit
def place(ride, record, p, y):
    """Let y (4,) be the state in row p of a section in the user's coordinates."""
    y[:] = 0.0
    y[0], y[1] = record[p, 0], record[p, 1]
    if ride.size == 4:
        y[2], y[3] = y[0] - record[p, 2] + ride.rest, y[1] - record[p, 3]


@jit
def image_of(ride, tangent, x, y):
    """Return M (x - y), M the matrix of the variations."""
    image = np.zeros(4)
    for c in range(ride.size):
        for i in range(ride.size):
            image[i] += tangent[4 * c + i] * (x[c] - y[c])
    return image


@jit
def least_told(ride, span):
    """Return the deviation, as `ride.norm`, from which on a section of an orbit of `span` tells.

    Sections hold positions: of a motion that is tiny beside the damper's rest offset they keep few
    digits.
    """
    return TINY * span + scale_of(ride.ps, ride.damper, 0.0, 0.0, BLURRED * ride.rest, 0.0)


@jit
def foretold(ride, tangent, y, now, then, span):
    """Tell whether the state `now` returns after the orbit's n periods to `then` as foretold.

    True where the deviation from the orbit's point y is mapped by its monodromy matrix, or is too
    small to tell.
    """
    far, tiny = gap_between(ride, now, y), least_told(ride, span)
    if far <= tiny and gap_between(ride, then, y) <= tiny:
        return True
    image = image_of(ride, tangent, now, y)
    for i in range(4):
        image[i] += y[i]
    return far <= span and gap_between(ride, image, then) <= FORETOLD * far


@jit
def settled(ride, record, length, tangent, y, n, span):
    """Return the first period from which on the section obeys the final orbit's own law.

    Walking backwards from the end in steps of n, for as long as every return is `foretold`.
    """
    now, then = np.zeros(4), np.zeros(4)
    p = length - 1
    place(ride, record, p, then)
    while p >= n:
        place(ride, record, p - n, now)
        if not foretold(ride, tangent, y, now, then, span):
            return p + 1
        then[:] = now
        p -= n
    return 0


@jit(dissolved=True)
def attracted(ride, tangent, y, last, n, span):
    """Tell whether a state returns to the stable orbit through y as foretold."""
    state, variations = fresh_state(), np.zeros(16)
    if gap_between(ride, last, y) <= TINY * span:
        return True
    seat(ride, last, state)
    for _ in range(n):
        unit(variations)
        if advance(ride.arc, ride, variations, state) != OK:
            return False
    return foretold(ride, tangent, y, last, state, span)


@jit(dissolved=True)
def try_period(ride, record, length, last, n, evidence):
    """Try to find a stable orbit of minimal period n at the end of a section; fill the evidence.

    last: the state (4,) there, sharper than the section holds it.
    """
    y = last.copy()
    points, counts, tangent = np.empty((n, 4)), np.zeros(2, np.int64), np.zeros(16)
    residual, clearance, slowest = polish(ride, y, points, counts, tangent)
    if not residual < np.inf:
        return False
    matrix, span = matrix_of(tangent, ride.size), span_of(ride, points)
    radius = radius_of(matrix)
    if not radius < 1.0 - MARGIN or not minimal(ride, y, points):
        return False
    copy = tangent.copy()
    if not attracted(ride, copy, y, last, n, span):
        return False
    evidence[KIND], evidence[PERIOD] = PERIODIC, n
    evidence[NEAR], evidence[FAR] = counts[0], counts[1]
    evidence[RESIDUAL], evidence[RADIUS] = residual, radius
    evidence[CLEARANCE], evidence[SOFTEST] = clearance, slowest
    evidence[SETTLING] = settled(ride, record, length, copy, y, n, span)
    for i in range(16):
        evidence[MATRIX + i] = copy[i]
    for i in range(4):
        evidence[POINT + i] = y[i]
    return True


@jit(dissolved=True)
def find_period(ride, record, length, last, hint, evidence):
    """Try the period that a recurrence found, then those of near returns."""
    tried, ridden = 0, 0
    y = np.zeros(4)
    span = 0.0
    for p in range(max(0, length - MOST_RIDDEN), length):
        place(ride, record, p, y)
        span = max(span, norm(ride, y))
    for i in range(min(MOST_RIDDEN, length - 1) + 1):
        known = i == 0
        n = hint if known else i
        if n == 0 or (n == hint and not known):
            continue
        place(ride, record, length - 1 - n, y)
        if known or gap_between(ride, last, y) <= NEAR_RETURN * span:
            if not known:
                tried, ridden = tried + 1, ridden + n
            if tried > MOST_PROPOSED or ridden > MOST_RIDDEN:
                return False
            if try_period(ride, record, length, last, n, evidence):
                return True
    return False


@jit
def wander(ride, state, tangent, logs, growth, record, first):
    """Ride len(logs) periods on, noting the section from row `first` on; returns a status.

    logs take the growth of the first variation in each period, growth (4,) that of all.
    """
    for p in range(len(logs)):
        before = growth[0]
        status = advance(ride.arc, ride, tangent, state)
        if status != OK:
            return status
        orthonormalise(tangent, ride.size, growth)
        logs[p] = growth[0] - before
        if len(record) > first + p:
            note_section(ride.damper, record, first + p, state[0], state[1], state[2], state[3])
    return OK


@jit
def longer(record, more):
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
def of_cycle(ride, evidence, period):
    """Write the largest exponent of a periodic orbit, ln |mu| / nT, which needs no average."""
    radius = evidence[RADIUS]
    largest = math.log(radius) if radius > 0.0 else -np.inf
    evidence[LARGEST], evidence[WIDTH] = largest / (evidence[PERIOD] * period), 0.0


@jit(dissolved=True)
def passed_through_chaos(ride, origin, evidence, period):
    """Ask whether the way to a periodic orbit was chaotic for long; note it."""
    periods = int(evidence[SETTLING])
    if ride.arc is None or periods < LATE:
        return
    state, tangent, growth = fresh_state(), np.zeros(16), np.zeros(4)
    seat(ride, origin, state)
    unit(tangent)
    logs, nowhere = np.zeros(periods), np.empty((0, ride.size))
    if wander(ride, state, tangent, logs, growth, nowhere, 0) != OK:
        return
    mean, width = growth_of(logs)
    evidence[PASSING], evidence[PASSING_WIDTH] = mean / period, width / period
    if mean - width > 0.0:
        evidence[KIND] = TRANSIENT


@jit(dissolved=True)
def judge(ride, origin, state, record, hint, stages, evidence):
    """Say what an orbit is; see the columns of `evidence` (COLUMNS,).

    origin, state: the states (SIZE,) at its begin and end; record (periods, components) its section
    all the way; hint: a period found by recurrence or 0; stages: further periods allowed, stage by
    stage. Returns a status.
    """
    length = len(record)
    evidence[:] = np.nan
    evidence[KIND], evidence[PERIOD], evidence[SETTLING] = UNDETERMINED, 0.0, -1.0
    period = ride.jets.h * ride.jets.n
    now, tangent, growth = state.copy(), np.zeros(16), np.zeros(4)
    unit(tangent)
    for stage in range(len(stages) + 1):
        if find_period(ride, record, length, now[:4], hint, evidence):
            of_cycle(ride, evidence, period)
            evidence[WATCHED] = length
            passed_through_chaos(ride, origin, evidence, period)
            return OK
        if stage > 0 and decide(ride, record, length, stages[stage - 1], evidence):
            return OK
        if stage == len(stages):
            return OK
        logs = np.zeros(stages[stage])
        record = longer(record, stages[stage])
        growth[:] = 0.0
        status = wander(ride, now, tangent, logs, growth, record, length)
        if status != OK:
            return status
        hint, length = 0, length + len(logs)
        mean, width = growth_of(logs)
        evidence[LARGEST], evidence[WIDTH] = mean / period, width / period
        evidence[WATCHED] = length
        note_exponents(evidence, growth, len(logs), period, ride.size)
    return OK


@jit
def decide(ride, record, length, watched, evidence):
    """Decide by the exponent and the averages of the last stage; True if that says something."""
    digits = 15.0
    for c in range(0, ride.size, 2):
        digits = min(digits, digits_of(record[length - watched : length, c].copy()))
    evidence[DIGITS] = digits
    largest, width = evidence[LARGEST], evidence[WIDTH]
    if largest - width > 0.0 and digits < SMOOTH:
        evidence[KIND] = CHAOTIC
        return True
    if abs(largest) <= max(width, MARGIN * abs(ride.trace)) and digits >= SMOOTH:
        if period_of(record[length - watched : length], TOLERANCE) > 0:
            return False  # periodic, or at rest, and nothing is known to draw other orbits to it
        evidence[KIND] = QUASIPERIODIC
        return True
    return False
