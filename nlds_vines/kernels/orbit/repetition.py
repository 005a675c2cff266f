"""Exact repetition: periods that follow a state which the orbit has had before are copied.

Under a harmonic force the notes of a period are a function of the state at its beginning. If that
state returns after n periods, equal in every bit, then all later periods repeat those n, and their
rows are copied instead of computed. The state is compared with a reference, which is renewed after
max(RENEWAL_STRIDE, p / RENEWAL_SHARE) periods (Brent's cycle detection; his powers of two wait too
long for orbits that settle after 100 to 200 periods).

The length of a repetition is that of a cycle of round-off, often a multiple of the orbit's period:
n of an nT orbit never comes from here. The reference holds everything on which a period depends:
the state, the impact under way, the largest energies and the smallest clearance so far (a search
for a larger one begins there), and the results that are recalled for nearly equal impacts.

Orbits run to their end if a record is a sum in rounded steps (responses), counts from the orbit's
beginning (times of impacts, the log of a limit), or depends on more than the state (variations,
loads).
"""

from __future__ import annotations

import math

import numpy as np

from ..impact.arc_table import INSIDE
from ..impact.inside import EACH, KEPT
from ..motion.load_cells import Loaded
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.codes import TOUCH_COLUMNS
from ..scene.contact_series import AHEAD
from ..watch.observe import Impacts, Touches

# The reference: x1, v1, r, s, q, mode; `inside.Ahead`; the period that it precedes and the one at
# which it is renewed; 1 if the state had returned then; the length of the repetition, 0 before
# there is one, and its touches. If the state had returned, also the largest energies and the
# smallest clearance so far, and from RECALLED on the impacts that the table of the arc recalls.
AT_AHEAD, LENGTH_OF_AHEAD = 6, 9
SINCE, RENEWED, STATE_RETURNED, CYCLE_LENGTH, TOUCHES = 15, 16, 17, 18, 19
EXTREMES, RECALLED = 20, 23
RECALLED_NUMBERS = EACH * KEPT + 1
FIRST = 32  # periods for which the first reference stays: sampled orbits have settled before
RENEWAL_STRIDE, RENEWAL_SHARE = 8, 8  # a later one stays for so many periods, or 1/8 of all


@jit
def reference_for(tangent, buffers, begun, arc):
    """Return room for the reference of an orbit, or None if its periods cannot be copied.

    begun: as of its grid; arc: None if no impact is recalled.
    """
    if tangent is not None or buffers.slowest is not None:
        return None
    if buffers.tally is not None:
        return None
    if buffers.sums is not None:
        return None
    if buffers.limit_log is not None:
        return None
    if is_a(buffers.impacts, Impacts):
        return None
    if is_a(begun, Loaded):
        return None
    return np.zeros(RECALLED + (0 if arc is None else RECALLED_NUMBERS))


@jit
def touches_so_far(impacts):
    """Return the number of noted touches, 0 if none are noted."""
    if impacts is None:
        return 0
    return impacts.filled[0]


@jit
def renew(reference, impacts, k, p, y):
    """Make the state before period p the reference.

    y: (x1, v1, r, s, q, mode); k: the scratch of contacts.
    """
    if reference is None:
        return
    for i in range(AT_AHEAD):
        reference[i] = y[i]
    for i in range(LENGTH_OF_AHEAD):
        reference[AT_AHEAD + i] = k[AHEAD + i]
    reference[SINCE] = p
    reference[RENEWED] = p + max(RENEWAL_STRIDE, p // RENEWAL_SHARE) if p > 0 else FIRST
    reference[STATE_RETURNED], reference[TOUCHES] = 0.0, touches_so_far(impacts)


@jit
def same_bits(a, b):
    """Return True if two numbers are the same: NaN equals itself, and 0 is not -0."""
    if a == b:
        return a != 0.0 or math.copysign(1.0, a) == math.copysign(1.0, b)
    return math.isnan(a) and math.isnan(b)


@jit
def has_returned(reference, k, y):
    """Return True if the state is that of the reference (arguments as `renew`)."""
    for i in range(AT_AHEAD):
        if not same_bits(reference[i], y[i]):
            return False
    if not same_bits(reference[AT_AHEAD], k[AHEAD]):
        return False
    if k[AHEAD] > 0.0:  # inside an impact that is solved; otherwise the rest has no meaning
        for i in range(1, LENGTH_OF_AHEAD):
            if not same_bits(reference[AT_AHEAD + i], k[AHEAD + i]):
                return False
    return True


@jit
def keep(reference, at, value):
    """Put a number into the reference; return True if it was there."""
    is_same = same_bits(reference[at], value)
    reference[at] = value
    return is_same


@jit
def keep_notes(reference, arc, watch):
    """Put extremes and recalled impacts into the reference; return True if they were there."""
    same = True
    if watch.energy is not None:
        for i in range(2):
            same = keep(reference, EXTREMES + i, watch.energy[i]) and same
    if watch.clearance is not None:
        same = keep(reference, EXTREMES + 2, watch.clearance[0]) and same
    if arc is not None:
        for i in range(RECALLED_NUMBERS):
            same = keep(reference, RECALLED + i, arc.table[INSIDE + i]) and same
    return same


@jit
def periods_to_run(reference, arc, watch, impacts, k, p, last, y):
    """Return how many of `last` periods must be computed, of which p have been.

    If the state and all that a period depends on have returned, as many as lead to the state at
    the end of the last one. The first return of the state only begins the comparison of the rest.
    """
    if reference is None:
        return last
    if reference[CYCLE_LENGTH] > 0.0:
        return last
    if has_returned(reference, k, y):
        n, had_returned = p - int(reference[SINCE]), reference[STATE_RETURNED] > 0.0
        if keep_notes(reference, arc, watch) and had_returned:
            reference[CYCLE_LENGTH] = n
            reference[TOUCHES] = touches_so_far(impacts) - reference[TOUCHES]
            return p + (last - p) % n
        renew(reference, impacts, k, p, y)
        reference[STATE_RETURNED], reference[RENEWED] = 1.0, max(reference[RENEWED], p + n)
    elif p >= reference[RENEWED]:
        renew(reference, impacts, k, p, y)
    return last


@jit
def repeat_rows(rows, first, last, n):
    """Copy rows `first` to `last` - 1, as far as there is room, from n rows before."""
    if rows is not None:
        for i in range(first, min(last, len(rows))):
            for c in range(rows.shape[1]):
                rows[i, c] = rows[i - n, c]


@jit
def repeat_touches(impacts, count, cycles):
    """Copy the last `count` touches once for each of so many cycles, as far as there is room."""
    if is_a(impacts, Touches):
        data, first = impacts.data, impacts.filled[0]
        impacts.filled[0] = first + count * cycles
        last = min(impacts.filled[0], impacts.room)
        for i in range(first * TOUCH_COLUMNS, last * TOUCH_COLUMNS):
            data[i] = data[i - count * TOUCH_COLUMNS]


@jit
def repeat(reference, buffers, impacts, span, computed):
    """Fill the rows of all periods behind the first `computed` ones."""
    if reference is None:
        return
    if computed < span.periods:
        n, stops = int(reference[CYCLE_LENGTH]), span.stops
        repeat_rows(buffers.section, computed * stops, span.periods * stops, n * stops)
        repeat_rows(buffers.by_period, computed, span.periods, n)
        repeat_touches(impacts, int(reference[TOUCHES]), (span.periods - computed) // n)
