"""Records along an orbit. A buffer that is not wanted is None, and its code is not compiled.

`energy`     (2,) largest E1 and E2 so far [J]
`clearance`  (1,) smallest near miss so far [m]
`slowest`    (1,) smallest approach speed of an impact so far [m/s]
`impacts`    impacts one by one, see `Impacts`
`limit_log`  (6,) a limit of the spring's shortening and its violations, see LIMIT
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.codes import AT_PHASE, AT_SPEED, AT_WALL, TOUCH_COLUMNS
from ..scene.scene import shared, under


class Impacts(NamedTuple):
    """Impacts one by one, a row of the columns WALL ... GAIN2 for each."""

    data: np.ndarray  # (capacity, IMPACT_COLUMNS); in the time loop one bare row
    filled: np.ndarray  # (1,) rows begun, also beyond the capacity
    room: int = 0  # the capacity, in the time loop


class Touches(NamedTuple):
    """The touches of impacts, a row of the columns `codes.AT_WALL` ... for each."""

    data: np.ndarray  # (capacity, TOUCH_COLUMNS), this and the others as in `Impacts`
    filled: np.ndarray
    room: int = 0


# Columns of `Impacts.data`:
#   0 WALL     0 near, 1 far                        4 IMPACT_FORCE    greatest force [N]
#   1 TOUCH    time [s]                             5 IMPACT_DEPTH    greatest depth [m]
#   2 RELEASE  time [s], NaN while it lasts         6 GAIN1    gain of E1 until release [J]
#   3 SPEED    of approach [m/s]                    7 GAIN2    gain of E2 until release [J]
#   8 TOUCH_IN_PERIOD, 9 RELEASE_IN_PERIOD    the two times since their period began [s]
WALL, TOUCH, RELEASE, SPEED, IMPACT_FORCE, IMPACT_DEPTH, GAIN1, GAIN2 = range(8)
TOUCH_IN_PERIOD, RELEASE_IN_PERIOD = 8, 9
IMPACT_COLUMNS = 10

# Places of the limit log:
#   0 LIMIT            of r [m]                       3 EXCESS  greatest r beyond the limit [m]
#   1 ORIGIN           from which motion counts [s]   4 NUMBER  passages of the limit
#   2 FIRST_VIOLATION  its time [s]                   5 BEYOND  1 while r is beyond, otherwise 0
LIMIT, ORIGIN, FIRST_VIOLATION, EXCESS, NUMBER, BEYOND = range(6)


@jit
def alike(f, g):
    """Return True if two numbers have one sign and neither is zero; their product may underflow."""
    return (f > 0.0 and g > 0.0) or (f < 0.0 and g < 0.0)


@jit
def opposite(f, g):
    return alike(f, -g)


@jit
def energies(ps, damper, x1, v1, r, s):
    """Return (E1, E2) [J], eq. (6); E2 is 0 without a damper."""
    e1 = 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)
    if damper is None:
        return e1, 0.0
    v2, w = v1 - s, x1 - r
    return e1, 0.5 * (damper.m2 * v2 * v2 + damper.k2 * w * w)


@jit
def note_energy(ps, damper, energy, x1, v1, r, s):
    raise_energies(energy, energies(ps, damper, x1, v1, r, s))


@jit
def note_touch(ps, damper, impacts, touch, y):
    """Record a touch: its row of `Touches`, or the beginning of a row of `Impacts`.

    touch: (wall, beginning of its period [s], time since then [s], phase in turns); y: (x1, v1, r,
    s). The release is NaN until `note_release`.
    """
    i = impacts.filled[0]
    impacts.filled[0] = i + 1
    if i >= impacts.room:
        return
    data = impacts.data
    if is_a(impacts, Touches):
        i *= TOUCH_COLUMNS
        data[i + AT_WALL], data[i + AT_PHASE], data[i + AT_SPEED] = touch[0], touch[3], abs(y[3])
    else:
        i *= IMPACT_COLUMNS
        data[i + WALL], data[i + TOUCH], data[i + RELEASE] = touch[0], touch[1] + touch[2], np.nan
        data[i + TOUCH_IN_PERIOD], data[i + RELEASE_IN_PERIOD] = touch[2], np.nan
        data[i + SPEED], data[i + IMPACT_FORCE], data[i + IMPACT_DEPTH] = abs(y[3]), 0.0, 0.0
        e1, e2 = energies(ps, damper, y[0], y[1], y[2], y[3])
        data[i + GAIN1], data[i + GAIN2] = -e1, -e2


@jit
def raise_last(impacts, column, value):
    """Raise a number of the impact under way to a value, if it has a row."""
    i = impacts.filled[0] - 1
    if 0 <= i < impacts.room:
        i = IMPACT_COLUMNS * i + column
        impacts.data[i] = max(impacts.data[i], value)


@jit
def note_depth(impacts, depth):
    raise_last(impacts, int(IMPACT_DEPTH), depth)


@jit
def note_force(impacts, force):
    raise_last(impacts, int(IMPACT_FORCE), force)


@jit
def note_release(ps, damper, impacts, began, time, y):
    """Complete the row of the impact under way.

    began: beginning of the period [s]; time: since then [s]; y: (x1, v1, r, s).
    """
    i = impacts.filled[0] - 1
    if 0 <= i < impacts.room:
        i *= IMPACT_COLUMNS
        impacts.data[i + RELEASE], impacts.data[i + RELEASE_IN_PERIOD] = began + time, time
        e1, e2 = energies(ps, damper, y[0], y[1], y[2], y[3])
        impacts.data[i + GAIN1] += e1
        impacts.data[i + GAIN2] += e2


@jit
def note_violation(limit_log, time):
    """Count a passage of the limit; the first one with its time [s]."""
    if limit_log[NUMBER] == 0.0:
        limit_log[FIRST_VIOLATION] = time
    limit_log[NUMBER] += 1.0
    limit_log[BEYOND] = 1.0


@jit
def note_section(damper, section, row, x1, v1, r, s):
    """Write one section point in the user's coordinates (x1, v1, x2, v2) [m, m/s]."""
    section[row, 0], section[row, 1] = x1, v1
    if damper is not None:
        section[row, 2], section[row, 3] = x1 - r + damper.rest, v1 - s


@jit
def powers_at(ps, damper, x1, v1, r, s, drive):
    """Return the factors (v1, n1, v2, n2) of dE1/dt = v1 n1 and dE2/dt = v2 n2 in flight.

    n1 and n2 are the forces on the two bodies without those of the springs in their energies.
    """
    n1 = ps.m1 * under(ps.load, ps.force * drive - ps.damping * v1)
    if damper is None:
        return v1, n1, 0.0, 0.0
    pull = damper.c2 * s
    n2 = damper.k2 * x1 + pull + damper.m2 * shared(ps, ps.force * drive)
    return v1, n1 - damper.k2 * r - pull, v1 - s, n2


@jit
def raise_energies(energy, values):
    energy[0] = max(energy[0], values[0])
    energy[1] = max(energy[1], values[1])
