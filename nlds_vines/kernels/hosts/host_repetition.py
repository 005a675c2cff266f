"""Repetition of a host's orbit to the bit, so that periods are copied instead of computed.

As in `orbit.repetition`: the records of a period are a function of what a reference holds at its
beginning, and the reference is renewed by the same rule. If all of it returns after n periods,
equal in every bit, then all later periods repeat those n. The reference holds the whole state, with
the contacts under way, and the largest values so far, as a search for a larger one begins there.

Rows of impacts are copied with their times within a period, to which the beginning of the later
period is added. Integrals are summed period by period, and copied sums are added one after the
other: so all records have the bits that the time loop would compute.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..orbit.repetition import FIRST, RENEWAL_SHARE, RENEWAL_STRIDE, same_bits
from .host_contact import (
    OF_RELEASE,
    OF_RELEASE_IN_PERIOD,
    OF_TOUCH,
    OF_TOUCH_IN_PERIOD,
    ROW_OF_IMPACT,
)


class Repetition(NamedTuple):
    """What an orbit is compared with, and the sums of its periods; in the loop bare rows."""

    state: Any  # (2 size + 2 walls,) at the beginning of a period, with the walls in contact
    largest: Any  # (quantities,) energies and responses up to there
    counts: Any  # (walls + 1,) impacts up to there by wall, and rows of impacts
    periods: Any  # (SINCE ... CYCLE) numbers of periods
    sums: Any  # periods * rows: the integrals of each recorded period
    totals: Any  # (rows,) the integrals over all


# in `periods`: that before which the reference was taken, that at which it is renewed, the length
# of the repetition, 0 before there is one
SINCE, RENEWED, CYCLE, NUMBERS_OF_PERIODS = range(4)


@jit
def repetition_for(flow, watch, periods):
    """Return the `Repetition` of an orbit with so many recorded periods."""
    size, walls = flow.space.size, flow.host.walls.number
    quantities, rows = 0, 0
    if watch is not None:
        quantities, rows = watch.quantities, watch.rows
    return Repetition(
        np.zeros(size + 2 * walls), np.zeros(quantities), np.zeros(walls + 1, np.int64),
        np.zeros(NUMBERS_OF_PERIODS, np.int64), np.zeros(periods * rows), np.zeros(rows),
    )  # fmt: skip


@jit
def renew_reference(repetition, host, watch, p, state):
    """Make the state before period p the reference."""
    numbers = 2 * host.body.size + 2 * host.walls.number
    for i in range(numbers):
        repetition.state[i] = state[i]
    if watch is not None:
        for q in range(watch.quantities):
            repetition.largest[q] = watch.records.peaks[q]
    for wall in range(host.walls.number):
        repetition.counts[wall] = host.impacts.counts[wall]
    repetition.counts[host.walls.number] = host.impacts.filled[0]
    repetition.periods[SINCE] = p
    repetition.periods[RENEWED] = p + max(RENEWAL_STRIDE, p // RENEWAL_SHARE) if p > 0 else FIRST


@jit
def begin_repetition(repetition, host, watch, p, state):
    """Take the state before period p as the first reference, from which on records are kept."""
    renew_reference(repetition, host, watch, p, state)
    repetition.periods[CYCLE] = 0


@jit
def has_state(repetition, host, state):
    """Return True if a state is that of the reference."""
    numbers = 2 * host.body.size + 2 * host.walls.number
    i = 0
    while i < numbers and same_bits(repetition.state[i], state[i]):
        i += 1
    return i == numbers


@jit
def has_largest(repetition, watch):
    """Return True if the largest values are those of the reference."""
    if watch is not None:
        for q in range(watch.quantities):
            if not same_bits(repetition.largest[q], watch.records.peaks[q]):
                return False
    return True


@jit
def next_period(repetition, host, watch, limits, p, state):
    """Return (the next period to compute, the one at which computing ends) after p periods.

    limits: (end, noted): `noted`, the first period with rows of the section. If the orbit repeats,
    periods before `noted` without records are left out, and as many are computed as lead to the
    state at the `end` and fill the rows of one cycle. Rows of contacts under way take one more: of
    the cycle in which they began, only the states are known to be equal.
    """
    end, noted = limits
    if not has_state(repetition, host, state):
        if p >= repetition.periods[RENEWED]:
            renew_reference(repetition, host, watch, p, state)
        return p, end
    n = p - repetition.periods[SINCE]
    if not has_largest(repetition, watch):  # as after the first cycle with records
        renew_reference(repetition, host, watch, p, state)
        repetition.periods[RENEWED] = max(repetition.periods[RENEWED], p + n)
        return p, end
    impacts, walls = host.impacts, host.walls
    repetition.periods[CYCLE] = n
    for wall in range(walls.number):
        repetition.counts[wall] = impacts.counts[wall] - repetition.counts[wall]
    repetition.counts[walls.number] = impacts.filled[0] - repetition.counts[walls.number]
    following = p
    is_recorded = impacts.filled[0] < impacts.room
    if watch is not None:
        is_recorded = is_recorded or watch.is_on[0] > 0.0
    if not is_recorded:
        skipped = max(0, (min(noted, end) - p) // n)
        following += skipped * n
        count_cycles(repetition, impacts, walls, skipped)
    last = following + (end - following) % n
    while noted < end and last < end and last - n < noted:
        last += n
    if host.contacts.active[0] > 0:
        last = min(last + n, end)
    return following, last


@jit
def count_cycles(repetition, impacts, walls, cycles):
    """Count the impacts of cycles that are not computed."""
    for wall in range(walls.number):
        impacts.counts[wall] += cycles * repetition.counts[wall]
    impacts.filled[0] += cycles * repetition.counts[walls.number]


@jit
def sum_up(repetition, watch, p):
    """Add the integrals of recorded period p to the totals, and begin those of the next."""
    squares, rows = watch.records.squares, watch.rows
    for i in range(rows):
        repetition.sums[p * rows + i] = squares[i]
        repetition.totals[i] += squares[i]
        squares[i] = 0.0


@jit
def put_totals(repetition, watch):
    """Write the integrals over all periods to the records."""
    for i in range(watch.rows):
        watch.records.squares[i] = repetition.totals[i]


@jit
def repeat_integrals(repetition, watch, first, end):
    """Add the integrals of recorded periods `first` to `end` - 1, which repeat earlier ones."""
    rows, n = watch.rows, repetition.periods[CYCLE]
    for p in range(first, end):
        for i in range(rows):
            part = repetition.sums[(p - n) * rows + i]
            repetition.sums[p * rows + i] = part
            repetition.totals[i] += part


@jit
def copy_impact(impacts, period, i, j, periods):
    """Fill row i of impacts with row j, shifted by a number of periods of `period` [s]."""
    data, row, former = impacts.data, ROW_OF_IMPACT * i, ROW_OF_IMPACT * j
    for c in range(ROW_OF_IMPACT):
        data[row + c] = data[former + c]
    for column, within in ((OF_TOUCH, OF_TOUCH_IN_PERIOD), (OF_RELEASE, OF_RELEASE_IN_PERIOD)):
        time = data[former + column]
        since = data[former + within]
        if time == time:  # NaN: it lasts
            began = int((time - since) / period + 0.5) + periods
            data[row + column] = began * period + since


@jit
def repeat_impacts(repetition, host, period, cycles):
    """Copy the rows of impacts of the last cycle, once for each of the `cycles` that follow.

    A contact under way has an unfinished row, which becomes that of the last cycle. It is completed
    from the row of the cycle before.
    """
    impacts, contacts, walls = host.impacts, host.contacts, host.walls
    n = int(repetition.periods[CYCLE])
    count = int(repetition.counts[walls.number])
    shift = count * cycles
    latest = impacts.filled[0]
    count_cycles(repetition, impacts, walls, cycles)
    # unfinished rows first, as they are: to the last cycle
    for c in range(1, contacts.active[0] + 1):
        row = contacts.rows[contacts.active[c]]
        if row >= latest - count and row + shift < impacts.room:
            copy_impact(impacts, period, row + shift, row, cycles * n)
    for c in range(1, contacts.active[0] + 1):
        row = contacts.rows[contacts.active[c]]
        if row >= latest - count and row < impacts.room:
            copy_impact(impacts, period, row, row - count, n)
    for i in range(latest, min(latest + shift, impacts.room)):
        is_unfinished = False
        for c in range(1, contacts.active[0] + 1):
            row = contacts.rows[contacts.active[c]]
            is_unfinished = is_unfinished or (row >= latest - count and row + shift == i)
        if not is_unfinished:
            copy_impact(impacts, period, i, i - count, n)
    for c in range(1, contacts.active[0] + 1):
        wall = contacts.active[c]
        if contacts.rows[wall] >= latest - count:
            contacts.rows[wall] += shift
