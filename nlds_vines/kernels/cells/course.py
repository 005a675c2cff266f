"""The course of an orbit under judgement: its sections as far as they are kept, and more of them.

However an orbit is followed, with its variations or without, it is the same to the last bit as
if it had been run in one go: the variations go along and change nothing. So no verdict depends on
where the periods of a request end and those of the verdict begin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..orbit.growth import BATCHES
from ..orbit.variations import TOGETHER, advance_flow, lost_of, orthonormalize, run_on
from ..scene.codes import OK

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
    """Return the number of the last section."""
    return course.first + course.length


@jit
def oldest_of(course):
    """Return the number of the oldest section that is kept."""
    if course.first == 0:
        return 0
    return course.first + 1


@jit
def section_at(space, course, m, y):
    """Let y (4,) be section m, which is kept."""
    y[:] = 0.0
    if m == 0:
        for i in range(4):
            y[i] = course.origin[i]
        return
    record, row = course.record, m - course.first - 1
    y[0], y[1] = record[row, 0], record[row, 1]
    if space.size == 4:
        y[2], y[3] = y[0] - record[row, 2] + space.rest, y[1] - record[row, 3]


@jit
def course_with_room(course, more):
    """Return the course with room for `more` sections."""
    record = np.empty((course.length + more, course.record.shape[1]))
    for p in range(course.length):
        for c in range(record.shape[1]):
            record[p, c] = course.record[p, c]
    return Course(record, course.length, course.first, course.origin)


@jit
def longer(course, more):
    """Return the course with `more` of its rows filled."""
    return Course(course.record, course.length + more, course.first, course.origin)


@jit
def follow_course(flow, course, more, state):
    """Follow an orbit for `more` periods; fill the next rows of its record; return a status."""
    rows = course.record[course.length : course.length + more]
    return run_on(flow, rows, more, state)


@jit
def periods_together(flow, periods):
    """Return after how many of so many periods variations are made orthonormal again.

    In between they turn towards the fastest; no volume may shrink by more than exp(-MOST_SHRUNK).
    And the batches whose means tell the uncertainty of a growth are to be long against it.
    """
    shrinks = abs(flow.trace) * flow.exact_grid.h * flow.exact_grid.n
    most = min(MOST_SHRUNK / max(shrinks, MOST_SHRUNK / TOGETHER), periods / (BATCHES * SEVERAL))
    return max(1, int(most))


@jit
def follow_growth(flow, rows, state, tangent, logs, growth):
    """Follow an orbit and its variations for len(logs) periods; return a status.

    rows take its sections, as far as there is room. logs take the logarithm by which the first
    variation grows in a period (the mean of a few), growth (4,) that of all.
    """
    flow.clearance[0] = 0.0  # no near miss is looked for
    together = periods_together(flow, len(logs))
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
