"""The state space of a host: its norm, and the sections of a record.

These kernels are chosen for hosts in place of those marked `by_flow` of the same name (`by_law`).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.fours import from_place

QUIET = 1.0e-9  # share of the norm of a motion that may be round-off


class HostSpace(NamedTuple):
    """The state space of a host; arrays are rows."""

    size: int  # components of y: the displacements, then their rates
    displacements: int
    modes: int  # the first displacements; the others are those of masses
    rows: Any  # (links * displacements,) w of r = w X; links of masses come first, in their order
    scales: Any  # (displacements,) w of the pairs (w x, v) of modes and (w r, s) of masses [1/s]
    masses: Any  # (displacements,) of the pairs [kg]
    blur: float  # 0: sections hold the numbers of the state


@jit
def width_of(space):
    return space.size


@jit
def column_of(space, i):
    return i


@jit
def difference(x, y, i):
    if y is None:
        return x[i]
    return x[i] - y[i]


@jit
def distance(space, x, y):
    """Return the norm of x - y, or of x if y is None [J^0.5].

    Its square is the sum of m (v^2 + w^2 x^2) over pairs, (w x, v) of modes and (w r, s) of masses:
    twice the energy if the pairs were not coupled. w is omega or more, so that a motion without
    stiffness counts, too.
    """
    size, square = space.displacements, 0.0
    for i in range(size):
        place, rate = difference(x, y, i), difference(x, y, size + i)
        if i >= space.modes:
            place = rate = 0.0
            row = (i - space.modes) * size
            for j in range(size):
                w = space.rows[row + j]
                if w != 0.0:
                    place += w * difference(x, y, j)
                    rate += w * difference(x, y, size + j)
        place *= space.scales[i]
        square += space.masses[i] * (place * place + rate * rate)
    return math.sqrt(square)


@jit
def norm(space, x):
    return distance(space, x, None)


@jit
def least_extent(space, record, length, i):
    """Return an extent of displacement i that is round-off of the motion."""
    scale = space.scales[i] * math.sqrt(space.masses[i])
    return QUIET * norm(space, record[length - 1]) / scale


@jit
def state_of(space, y):
    numbers = np.empty(space.size)
    for i in range(space.size):
        numbers[i] = y[i]
    return numbers


@jit
def section_at(space, course, m):
    """Return the state at section m of a bare course, a bare row."""
    if m == 0:
        return from_place(course.origin, 0)
    return from_place(course.record, space.size * (m - course.first - 1))
