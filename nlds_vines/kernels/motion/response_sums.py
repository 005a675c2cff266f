"""The row of numbers from which a response is computed: sums and maxima over the sampled periods.

Sums are integrals over time of products of the state. Maxima are of absolute values, at any
instant and not at samples (`response`). The damper's position is the shortening r of its spring.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..numerics.compiling import jit
from .flight import FACTOR

# Places of a tally's row:
#   X2 ... S2   integrals of x1^2, v1^2, a1^2 (a1 absolute), r^2 and s^2
#   CV, CS      of f v1 and f s, f being cos(omega t) or a load
#   LOSS        what contacts have dissipated [J]
#   Y2          of (x1 + y)^2, y being the displacement of the ground, where it is known
#   MOST        largest |x1|, |v1|, |a1|, |r|, |x1 + y|
#   MOST_FORCE       largest force [N] at the near and the far wall
#   IMPULSE     largest impulse [N s] there, of rigid bodies
#   PLACE       place of the maximum that is searched for
#   JUMPS       work of jumps of v1 [J], under a load
#   FACTOR      scratch: Taylor coefficients of a quantity over a cell, as in a grid's table
#   BEFORE      scratch: the NUMBERS before an impact
X2, V2, A2, R2, S2, CV, CS, LOSS, Y2 = range(9)
SUMS = 9
MOST, MOST_FORCE, IMPULSE, PLACE, JUMPS = 9, 14, 16, 18, 19
NUMBERS = PLACE  # the sums and maxima, to which each impact adds
OF_X, OF_V, OF_A, OF_R, OF_DISPLACED, OF_FORCE = range(6)  # the quantities of maxima
BEFORE = FACTOR + 16
SIZE = BEFORE + NUMBERS

# Gauss points of [0, 1] and their weights: the error of a cell is 6!^4 / (13 12!^3) f^(12)
POINTS = (
    0.033765242898423986, 0.16939530676686775, 0.3806904069584015,
    0.6193095930415985, 0.8306046932331322, 0.966234757101576,
)  # fmt: skip
WEIGHTS = (
    0.08566224618958517, 0.18038078652406930, 0.23395696728634552,
    0.23395696728634552, 0.18038078652406930, 0.08566224618958517,
)  # fmt: skip


class Tally(NamedTuple):
    """The sums and maxima of an orbit."""

    row: Any  # (SIZE,), see above
    ground: Any  # force per mass [m/s^2] if positions count from a moving ground, else None
    moved: Any  # displacement [m] of the ground per unit of the force, or None if it is not known


@jit
def absolute(ground, relative, drive):
    """Return the structure's absolute acceleration; relative: dv1/dt."""
    if ground is None:
        return relative
    return relative - ground * drive


@jit
def in_absolute(ground, rate):
    """Return the part of the force's rate per mass in that of the absolute acceleration."""
    if ground is None:
        return rate
    return 0.0


@jit
def raise_to(row, place, value):
    row[place] = max(row[place], abs(value))


@jit
def place_of_largest(which, sign):
    """Return the place of the maximum of a quantity; sign: of the wall, for a force."""
    if which == OF_FORCE:
        return MOST_FORCE + (0 if sign > 0.0 else 1)
    return MOST + which


@jit
def add_state(row, dt, y, a1, drive):
    """Add `dt` [s] in a state y = (x1, v1, r, s) to the integrals.

    a1: the absolute acceleration; drive: the force.
    """
    x1, v1, r, s = y
    row[X2] += dt * x1 * x1
    row[V2] += dt * v1 * v1
    row[A2] += dt * a1 * a1
    row[R2] += dt * r * r
    row[S2] += dt * s * s
    row[CV] += dt * drive * v1
    row[CS] += dt * drive * s


@jit
def add_displaced(tally, dt, x1, drive):
    """Add dt (x1 + y)^2 to Y2 where the displacement y of the ground is known."""
    if tally.moved is None:
        return None
    displaced = x1 + tally.moved * drive
    tally.row[Y2] += dt * displaced * displaced
