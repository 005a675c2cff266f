"""Exact repetition: periods that follow a state which the orbit has had before are copied.

Under a harmonic force the notes of a period are a function of the state at its beginning. If that
state returns after n periods, equal in every bit, then all later periods repeat those n, and their
rows are copied instead of computed. The state is compared with a reference, which is renewed after
max(RENEWAL_STRIDE, p / RENEWAL_SHARE) periods (Brent's cycle detection; his powers of two wait too
long for orbits that settle after 100 to 200 periods).

The length of a repetition is that of a cycle of round-off, often a multiple of the orbit's period:
n of an nT orbit never comes from here. The reference holds everything on which a period depends:
the state, the impact under way, the largest values and the smallest clearance so far (a search for
a larger one begins there), and the results that are recalled for nearly equal impacts.

Rows of impacts are copied with their times within a period, to which the beginning of the later
period is added as ever: the same bits. The integrals of a response are summed up period by period
with what rounding loses (Neumaier's sum), so that a cycle counted c times differs from c sums by
round-off of the result, 1e-16, however many periods there are.

Orbits run to their end if a record counts from the orbit's beginning (the log of a limit) or
depends on more than the state (variations, loads).
"""

from __future__ import annotations

import math

import numpy as np

from ..impact.arc import INSIDE
from ..impact.inside import EACH, KEPT
from ..motion.load_cells import Loaded, began_at
from ..motion.response_sums import BEGIN, MOST, SUMS
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.codes import TOUCH_COLUMNS
from ..scene.law import AHEAD
from ..watch.observe import (
    IMPACT_COLUMNS,
    RELEASE,
    RELEASE_IN_PERIOD,
    TOUCH,
    TOUCH_IN_PERIOD,
    Impacts,
    Touches,
)

# The reference: x1, v1, r, s, q, mode; `inside.Ahead`; the period that it precedes and the one at
# which it is renewed; 1 if the state had returned then; the length of the repetition, 0 before
# there is one, and its touches. If the state had returned, also the largest energies, the smallest
# clearance and the maxima of a response so far. Integrals of a response since the orbit began, with
# what rounding has lost of them, and both as they were at the reference, in the end those of one
# cycle. From RECALLED on the impacts that the table of the arc recalls.
AT_AHEAD, LENGTH_OF_AHEAD = 6, 9
SINCE, RENEWED, STATE_RETURNED, CYCLE_LENGTH, TOUCHES = 15, 16, 17, 18, 19
EXTREMES, MAXIMA, TOTALS = 20, 23, 23 + BEGIN - MOST
ROUNDED_OFF, CYCLE_SUMS, RECALLED = TOTALS + SUMS, TOTALS + 2 * SUMS, TOTALS + 4 * SUMS
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
    if buffers.limit_log is not None:
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
def sum_up_period(reference, tally):
    """Add a period's integrals to those before, with what rounding loses; begin anew with 0."""
    if reference is None:
        return
    if tally is None:
        return
    for i in range(SUMS):
        add_to_total(reference, i, tally.row[i])
        tally.row[i] = 0.0


@jit
def add_to_total(reference, i, part):
    """Add to integral i of a response; what rounding loses of a sum is exact (Knuth's two-sum)."""
    before = reference[TOTALS + i]
    total = before + part
    added = total - before
    reference[TOTALS + i] = total
    reference[ROUNDED_OFF + i] += (before - (total - added)) + (part - added)


@jit
def renew(reference, tally, impacts, k, p, y):
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
    if tally is not None:
        for i in range(2 * SUMS):
            reference[CYCLE_SUMS + i] = reference[TOTALS + i]


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
    if watch.tally is not None:
        for i in range(BEGIN - MOST):
            same = keep(reference, MAXIMA + i, watch.tally.row[MOST + i]) and same
    if arc is not None:
        for i in range(RECALLED_NUMBERS):
            same = keep(reference, RECALLED + i, arc.table[INSIDE + i]) and same
    return same


@jit
def periods_to_run(reference, arc, watch, impacts, k, p, last, y):
    """Return how many of `last` periods must be computed, of which p have been.

    If the state and all that a period depends on have returned, as many as lead to the state at
    the end of the last one. The first return of the state only begins the comparison of the rest.
    Rows of impacts take one cycle more: the impact under way now began in the cycle before, of
    which only the states are known to be the same.
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
            # the integrals of a response over one cycle
            if watch.tally is not None:
                for i in range(SUMS):
                    sums = reference[TOTALS + i] - reference[CYCLE_SUMS + i]
                    lost = reference[ROUNDED_OFF + i] - reference[CYCLE_SUMS + SUMS + i]
                    reference[CYCLE_SUMS + i] = sums + lost
            more = n + (last - p) % n if is_a(impacts, Impacts) else (last - p) % n
            return min(p + more, last)
        renew(reference, watch.tally, impacts, k, p, y)
        reference[STATE_RETURNED], reference[RENEWED] = 1.0, max(reference[RENEWED], p + n)
    elif p >= reference[RENEWED]:
        renew(reference, watch.tally, impacts, k, p, y)
    return last


@jit
def repeat_rows(rows, first, last, n):
    if rows is not None:
        for i in range(first, min(last, len(rows))):
            for c in range(rows.shape[1]):
                rows[i, c] = rows[i - n, c]


@jit
def repeat_impact(grid, data, i, j, periods):
    """Fill row i of impacts with row j, so many periods later."""
    row, former = i * IMPACT_COLUMNS, j * IMPACT_COLUMNS
    for c in range(IMPACT_COLUMNS):
        data[row + c] = data[former + c]
    for c, within in ((TOUCH, TOUCH_IN_PERIOD), (RELEASE, RELEASE_IN_PERIOD)):
        time, since = data[former + c], data[former + within]
        if time == time:  # NaN: it lasts
            period = int((time - since) / began_at(grid, 1) + 0.5) + periods
            data[row + c] = began_at(grid, period) + since


@jit
def repeat_impacts(grid, impacts, count, cycles, n):
    """Copy the last `count` impacts once for each of so many cycles of n periods, as there is room.

    An impact under way ends as that of the cycle before; the last one of all is then under way.
    """
    if is_a(impacts, Impacts):
        if count == 0:
            return
        data, latest = impacts.data, impacts.filled[0] - 1
        impacts.filled[0] += count * cycles
        first, end = latest + 1, impacts.filled[0]
        if latest < impacts.room and math.isnan(data[latest * IMPACT_COLUMNS + RELEASE]):
            first = latest
            if end <= impacts.room:
                end -= 1
                repeat_impact(grid, data, end, latest, cycles * n)
        for i in range(first, min(end, impacts.room)):
            repeat_impact(grid, data, i, i - count, n)


@jit
def repeat(reference, buffers, grid, tally, impacts, span, computed):
    """Fill the rows of all periods behind the first `computed` ones; end the sums of a response."""
    if reference is None:
        return
    n, cycles = 0, 0
    if computed < span.periods:
        n, stops = int(reference[CYCLE_LENGTH]), span.stops
        cycles = (span.periods - computed) // n
        repeat_rows(buffers.section, computed * stops, span.periods * stops, n * stops)
        repeat_rows(buffers.by_period, computed, span.periods, n)
        # touches of the last cycle, once for each cycle, as far as there is room
        count = int(reference[TOUCHES])
        if is_a(impacts, Touches):
            data, first = impacts.data, impacts.filled[0]
            impacts.filled[0] = first + count * cycles
            last = min(impacts.filled[0], impacts.room)
            for i in range(first * TOUCH_COLUMNS, last * TOUCH_COLUMNS):
                data[i] = data[i - count * TOUCH_COLUMNS]
        repeat_impacts(grid, impacts, int(reference[TOUCHES]), cycles, n)
    if tally is not None:
        for i in range(SUMS):
            add_to_total(reference, i, cycles * reference[CYCLE_SUMS + i])
            tally.row[i] = reference[TOTALS + i] + reference[ROUNDED_OFF + i]
