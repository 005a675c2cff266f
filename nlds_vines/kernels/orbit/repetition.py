"""Repetition of an orbit: to the bit, so that periods are copied, and to a tolerance.

Under a harmonic force the records of a period are a function of what the reference (below) holds at
its beginning. If all of it returns after n periods, equal in every bit, then all later periods
repeat those n, and their rows are copied instead of computed. The first return of the state only
begins the comparison of the rest. The state is compared with a reference, which is renewed after
max(RENEWAL_STRIDE, p / RENEWAL_SHARE) periods (Brent's cycle detection; his powers of two wait too
long for orbits that settle after 100 to 200 periods). The reference holds everything that a period
depends on: the state, the impact under way, the largest values and the smallest clearance so far (a
search for a larger one begins there), and the results that are recalled for nearly equal impacts.
Orbits run to their end if a record counts from the orbit's beginning (the log of a limit) or
depends on more than the state (variations, loads): they have no reference.

Rows of impacts are copied with their times within a period, to which the beginning of the later
period is added: the same bits. The integrals of a response are summed period by period with
compensation (Neumaier's sum), so that a cycle counted c times differs from c sums by round-off of
the result, 1e-16, however many periods there are.

The length of an exact repetition is that of a cycle of round-off, often a multiple of the orbit's
period. n and k of an nT,k orbit come from the recurrence of its section and of its impact counts
to a tolerance instead.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..impact.arc import ARC
from ..impact.inside import RECALLED_NUMBERS
from ..motion.load_cells import began_at
from ..motion.response_sums import MOST, NUMBERS, SUMS
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

FIRST = 32  # periods for which the first reference stays: sampled orbits have settled before
RENEWAL_STRIDE, RENEWAL_SHARE = 8, 8  # a later one stays for so many periods, or 1/8 of all


class PlaceOfReference(NamedTuple):
    state: int = 0  # x1, v1, r, s, q, mode
    ahead: int = 6  # the 9 numbers of `inside.Ahead`
    since: int = 15  # the period that it precedes
    renewed: int = 16  # the period at which it is renewed
    returned: int = 17  # 1 if the state had returned when it became the reference
    cycle: int = 18  # periods of the repetition, 0 before there is one
    touches: int = 19  # touches before the reference, later those of the repetition
    # if the state had returned: the largest energies and the smallest clearance, the maxima of a
    # response
    extremes: int = 20
    maxima: int = 23
    # integrals of a response since the orbit began, what rounding has lost of them, and both as
    # they were at the reference, later those of one cycle
    totals: int = 23 + NUMBERS - MOST
    lost: int = 23 + NUMBERS - MOST + SUMS
    cycle_sums: int = 23 + NUMBERS - MOST + 2 * SUMS
    recalled: int = 23 + NUMBERS - MOST + 4 * SUMS  # the impacts that the table of the arc recalls


AT = PlaceOfReference()


@jit
def touches_so_far(impacts):
    if impacts is None:
        return 0
    return impacts.filled[0]


@jit
def sum_up_period(reference, tally):
    """Add a period's integrals to the totals and reset them to 0."""
    if tally is not None:
        for i in range(SUMS):
            add_to_total(reference, i, tally.row[i])
            tally.row[i] = 0.0


@jit
def add_to_total(reference, i, part):
    """Add to integral i of a response; the rounding error of a sum is exact (Knuth's two-sum)."""
    before = reference[AT.totals + i]
    total = before + part
    added = total - before
    reference[AT.totals + i] = total
    reference[AT.lost + i] += (before - (total - added)) + (part - added)


@jit
def renew(reference, tally, impacts, k, p, y):
    """Make the state before period p the reference.

    y: (x1, v1, r, s, q, mode); k: the scratch of contacts.
    """
    for i in range(6):
        reference[AT.state + i] = y[i]
    for i in range(9):
        reference[AT.ahead + i] = k[AHEAD + i]
    reference[AT.since] = p
    reference[AT.renewed] = p + max(RENEWAL_STRIDE, p // RENEWAL_SHARE) if p > 0 else FIRST
    reference[AT.returned], reference[AT.touches] = 0.0, touches_so_far(impacts)
    if tally is not None:
        for i in range(2 * SUMS):
            reference[AT.cycle_sums + i] = reference[AT.totals + i]


@jit
def same_bits(a, b):
    """Return True if two numbers are the same: NaN equals itself, and 0 is not -0."""
    if a == b:
        return a != 0.0 or math.copysign(1.0, a) == math.copysign(1.0, b)
    return math.isnan(a) and math.isnan(b)


@jit
def keep(reference, at, value):
    """Put a number into the reference; return True if it was there."""
    is_same = same_bits(reference[at], value)
    reference[at] = value
    return is_same


@jit
def periods_to_run(reference, arc, watch, impacts, k, p, last, y):
    """Return how many of `last` periods must be computed, of which p have been.

    If the state and all that a period depends on have returned, these are as many as lead to the
    state at the end of the last period. The first return of the state only begins the comparison
    of the rest. Rows of impacts need one cycle more: the impact under way now began in the cycle
    before, of which only the states are known to be equal.
    """
    if reference[AT.cycle] > 0.0:
        return last
    returned = same_bits(reference[AT.ahead], k[AHEAD])
    for i in range(6):
        returned = returned and same_bits(reference[AT.state + i], y[i])
    if k[AHEAD] > 0.0:  # inside a solved impact; otherwise the other numbers have no meaning
        for i in range(1, 9):
            returned = returned and same_bits(reference[AT.ahead + i], k[AHEAD + i])
    if returned:
        n, same = p - int(reference[AT.since]), reference[AT.returned] > 0.0
        # Put extremes and recalled impacts into the reference, and compare them with those there.
        if watch.energy is not None:
            for i in range(2):
                same = keep(reference, AT.extremes + i, watch.energy[i]) and same
        if watch.clearance is not None:
            same = keep(reference, AT.extremes + 2, watch.clearance[0]) and same
        if watch.tally is not None:
            for i in range(NUMBERS - MOST):
                same = keep(reference, AT.maxima + i, watch.tally.row[MOST + i]) and same
        if arc is not None:
            for i in range(RECALLED_NUMBERS):
                same = keep(reference, AT.recalled + i, arc.table[ARC.recalled + i]) and same
        if same:
            reference[AT.cycle] = n
            reference[AT.touches] = touches_so_far(impacts) - reference[AT.touches]
            # the integrals of a response over one cycle
            if watch.tally is not None:
                for i in range(SUMS):
                    sums = reference[AT.totals + i] - reference[AT.cycle_sums + i]
                    lost = reference[AT.lost + i] - reference[AT.cycle_sums + SUMS + i]
                    reference[AT.cycle_sums + i] = sums + lost
            remaining = n + (last - p) % n if is_a(impacts, Impacts) else (last - p) % n
            return min(p + remaining, last)
        renew(reference, watch.tally, impacts, k, p, y)
        reference[AT.returned], reference[AT.renewed] = 1.0, max(reference[AT.renewed], p + n)
    elif p >= reference[AT.renewed]:
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
    """Fill row i of impacts with row j, shifted by a number of periods."""
    row, former = i * IMPACT_COLUMNS, j * IMPACT_COLUMNS
    for c in range(IMPACT_COLUMNS):
        data[row + c] = data[former + c]
    for c, within in ((TOUCH, TOUCH_IN_PERIOD), (RELEASE, RELEASE_IN_PERIOD)):
        time, since = data[former + c], data[former + within]
        if time == time:  # NaN: it lasts
            period = int((time - since) / began_at(grid, 1) + 0.5) + periods
            data[row + c] = began_at(grid, period) + since


@jit
def repeat(reference, buffers, grid, tally, impacts, span, computed):
    """Copy the last cycle into the rows of all periods after the first `computed` ones.

    Copied rows have the bits that the time loop would compute. The row of a `tally` gets the sums
    over all periods, with an error of round-off.
    """
    n, cycles = 0, 0
    if computed < span.periods:
        n, stops = int(reference[AT.cycle]), span.stops
        cycles = (span.periods - computed) // n
        repeat_rows(buffers.section, computed * stops, span.periods * stops, n * stops)
        repeat_rows(buffers.by_period, computed, span.periods, n)
        # touches or impacts of the last cycle, once for each cycle, as far as there is room
        count = int(reference[AT.touches])
        if is_a(impacts, Touches):
            data, first = impacts.data, impacts.filled[0]
            impacts.filled[0] = first + count * cycles
            last = min(impacts.filled[0], impacts.room)
            for i in range(first * TOUCH_COLUMNS, last * TOUCH_COLUMNS):
                data[i] = data[i - count * TOUCH_COLUMNS]
        if is_a(impacts, Impacts) and count > 0:
            data, latest = impacts.data, impacts.filled[0] - 1
            impacts.filled[0] += count * cycles
            first, end = latest + 1, impacts.filled[0]
            # The row of an impact under way is completed from the cycle before; its unfinished copy
            # becomes the last row.
            if latest < impacts.room and math.isnan(data[latest * IMPACT_COLUMNS + RELEASE]):
                first = latest
                if end <= impacts.room:
                    end -= 1
                    repeat_impact(grid, data, end, latest, cycles * n)
            for i in range(first, min(end, impacts.room)):
                repeat_impact(grid, data, i, i - count, n)
    if tally is not None:
        for i in range(SUMS):
            add_to_total(reference, i, cycles * reference[AT.cycle_sums + i])
            tally.row[i] = reference[AT.totals + i] + reference[AT.lost + i]


# ---- period and impacts of an orbit by recurrence ------------------------------------------------


TOLERANCE = 1.0e-6  # of a return, relative to the largest value of each component
REPEATS = 3  # times a period must fit into the section


@jit
def repeats(section, length, n, count, tolerance):
    """Return True if the last `count` of the first `length` rows repeat after n periods."""
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
def impacts_of(by_period, wall, n):
    """Return the impacts k per nT at one wall; for n = 0 those of all periods.

    by_period: counts (periods, 2); wall: 0 near, 1 far. k is the mean, rounded, over as many cycles
    as fit into the last half of the periods. An impact at the very instant of a section, counted
    before it or after it, changes the sum by 1 at most, and so not k if there are three cycles.
    """
    periods, cycles = len(by_period), 1
    first = 0
    if n > 0:
        cycles = max(1, periods // (2 * n))
        first = periods - cycles * n
    total = 0
    for p in range(first, periods):
        total += by_period[p, wall]
    return round(total / cycles)
