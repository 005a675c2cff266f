"""When an orbit settled on the periodic orbit that it ends in, and what it was before.

An orbit has settled from the first section on from which every return, n periods later, is as the
monodromy matrix predicts. Only the sections whose number is a multiple of n are asked, so that the
answer does not depend on how long the orbit was watched. What is not kept of its course is run
again from its beginning.
"""

from __future__ import annotations

import numpy as np

from ..numerics.compiling import jit
from ..orbit.growth import mean_and_width
from ..orbit.variations import distance, new_state, no_section, place_state, run_on, set_identity
from ..scene import evidence_rows as ev
from ..scene.codes import OK, TRANSIENT_CHAOS
from ..scene.scene import scale_of
from .course import follow_growth, last_of, oldest_of, section_at

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


@jit
def image_of(space, tangent, x, y):
    """Return M (x - y), M the matrix of the variations."""
    image = np.zeros(4)
    for c in range(space.size):
        for i in range(space.size):
            image[i] += tangent[4 * c + i] * (x[c] - y[c])
    return image


@jit
def resolvable(space, span):
    """Return the least deviation, a `norm`, that shows on a section of an orbit of size `span`.

    Sections hold positions: of a motion that is tiny beside the damper's rest offset they keep few
    digits.
    """
    ps, damper = space.ps, space.damper
    return TINY * span + scale_of(ps, damper, 0.0, 0.0, BLUR * space.rest, 0.0)


@jit
def returns_as_predicted(space, tangent, y, now, then, span):
    """Tell whether the state `now` returns to `then` after the orbit's n periods as predicted.

    True where the deviation from the orbit's point y is mapped by its monodromy matrix, or is too
    small to tell.
    """
    far, tiny = distance(space, now, y), resolvable(space, span)
    if far <= tiny and distance(space, then, y) <= tiny:
        return True
    image = image_of(space, tangent, now, y)
    for i in range(4):
        image[i] += y[i]
    return far <= UNPREDICTED * span and distance(space, image, then) <= PREDICTION_ERROR * far


@jit
def attracted(flow, tangent, y, x, n, span):
    """Tell whether the state x is drawn to the stable orbit through y.

    Each return must be as predicted, until the deviation is too small to tell, or for so long that
    no chance explains it: one flight without impact always obeys the law of an impact-free orbit.
    """
    state, now = new_state(), x.copy()
    place_state(flow, x, state)
    for _ in range(0, CONVINCING, n):
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return False
        if not returns_as_predicted(flow.space, tangent, y, now, state, span):
            return False
        for i in range(4):
            now[i] = state[i]
        if distance(flow.space, now, y) <= resolvable(flow.space, span):
            return True
    return True


@jit
def settled_before(flow, course, tangent, y, n, span, m):
    """Return the section from which on returns are as predicted, all those from section m on being.

    The orbit is run again from its beginning, n periods at a time.
    """
    state, now, settled = new_state(), np.zeros(4), 0
    place_state(flow, course.origin, state)
    for p in range(n, m + 1, n):
        for i in range(4):
            now[i] = state[i]
        if run_on(flow, no_section(flow.space), n, state) != OK:
            return m
        if not returns_as_predicted(flow.space, tangent, y, now, state, span):
            settled = p
    return settled


@jit
def settling_period(flow, course, tangent, y, n, span):
    """Return the number of the first section from which on all returns are as predicted.

    tangent, y: matrix and point of the periodic orbit, of n periods, at the sections that are
    multiples of n; span: its size. The last section where not even the last return is.
    """
    now, then = np.zeros(4), np.zeros(4)
    m = last_of(course) // n * n
    section_at(flow.space, course, m, then)
    while m - n >= oldest_of(course):
        section_at(flow.space, course, m - n, now)
        if not returns_as_predicted(flow.space, tangent, y, now, then, span):
            return m
        for i in range(4):
            then[i] = now[i]
        m -= n
    if course.first == 0:
        return 0
    return settled_before(flow, course, tangent, y, n, span, m)


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
