"""What is written down along an orbit. A buffer that was not asked for is None, and so is the code.

`energy`     (2,) largest E1 and E2 so far [J]
`clearance`  (1,) smallest near miss so far [m]
`touches`    (2,) impacts so far at the near and the far wall
`rows`       impacts one by one, see `Rows`
`watch`      (6,) a limit of the spring's shortening and how it was kept, see LEVEL
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import runge_kutta as rk
from .compiling import jit
from .contact_field import turn


class Rows(NamedTuple):
    """Impacts one by one, a row of the columns WALL ... GAIN2 for each."""

    data: np.ndarray  # (capacity, COLUMNS)
    filled: np.ndarray  # (1,) rows begun, also beyond the capacity


PRECISE = 1.0e-7  # place of a peak in a step or cell: its height errs by the square
# wall, times of touch and release, approach speed, peak force, depth, what E1 and E2 gain meanwhile
WALL, TOUCH, RELEASE, SPEED, FORCE, DEPTH, GAIN1, GAIN2 = range(8)
COLUMNS = 8

# limit of r [m], period under way, time of the first violation [s], depth [m], number, beyond now
LEVEL, PERIOD, FIRST, EXCESS, NUMBER, BEYOND = range(6)


@jit
def alike(f, g):
    """Tell whether two numbers have one sign and neither is zero; their product may underflow."""
    return (f > 0.0 and g > 0.0) or (f < 0.0 and g < 0.0)


@jit
def opposite(f, g):
    """Tell whether two numbers have opposite signs."""
    return alike(f, -g)


@jit
def energies(ps, damper, x1, v1, r, s):
    """Return (E1, E2) [J], eq. (6); E2 is 0 where there is no damper."""
    e1 = 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)
    if damper is None:
        return e1, 0.0
    v2, w = v1 - s, x1 - r
    return e1, 0.5 * (damper.m2 * v2 * v2 + damper.k2 * w * w)


@jit
def note_energy(ps, damper, energy, x1, v1, r, s):
    """Raise the largest energies to those of one state."""
    e1, e2 = energies(ps, damper, x1, v1, r, s)
    energy[0] = max(energy[0], e1)
    energy[1] = max(energy[1], e2)


@jit
def note_touch(ps, damper, rows, wall, time, x1, v1, r, s):
    """Begin the row of an impact; its release stays NaN until `note_release`."""
    i = rows.filled[0]
    rows.filled[0] = i + 1
    if i < len(rows.data):
        rows.data[i, WALL], rows.data[i, TOUCH], rows.data[i, RELEASE] = wall, time, np.nan
        rows.data[i, SPEED], rows.data[i, FORCE], rows.data[i, DEPTH] = abs(s), 0.0, 0.0
        e1, e2 = energies(ps, damper, x1, v1, r, s)
        rows.data[i, GAIN1], rows.data[i, GAIN2] = -e1, -e2


@jit
def note_depth(rows, K, depth):
    """Raise the greatest depth and force of the impact under way."""
    i = rows.filled[0] - 1
    if 0 <= i < len(rows.data) and depth > rows.data[i, DEPTH]:
        rows.data[i, DEPTH], rows.data[i, FORCE] = depth, K * depth * np.sqrt(depth)


@jit
def note_release(ps, damper, rows, time, x1, v1, r, s):
    """Complete the row of the impact under way."""
    i = rows.filled[0] - 1
    if 0 <= i < len(rows.data):
        rows.data[i, RELEASE] = time
        e1, e2 = energies(ps, damper, x1, v1, r, s)
        rows.data[i, GAIN1] += e1
        rows.data[i, GAIN2] += e2


@jit
def note_violation(watch, time):
    """Count a passage of the limit; the first one with its time [s]."""
    if watch[NUMBER] == 0.0:
        watch[FIRST] = time
    watch[NUMBER] += 1.0
    watch[BEYOND] = 1.0


@jit
def note_section(damper, section, row, x1, v1, r, s):
    """Write one section point in the user's coordinates (x1, v1, x2, v2) [m, m/s]."""
    section[row, 0], section[row, 1] = x1, v1
    if damper is not None:
        section[row, 2], section[row, 3] = x1 - r + damper.rest, v1 - s


@jit
def powers_at(ps, damper, x1, v1, r, s, drive, force):
    """Return the factors of dE1/dt = v1 n1 and dE2/dt = v2 n2 under a contact force [N].

    n1 and n2 are the forces on the two bodies beside those of the springs in their energies.
    """
    n1 = ps.m1 * (ps.force * drive - ps.damping * v1)
    if damper is None:
        return v1, n1, 0.0, 0.0
    pull = damper.c2 * s + force
    return v1, n1 - damper.k2 * r - pull, v1 - s, damper.k2 * x1 + pull


@jit
def powers(ps, damper, wall, c, d, k, row):
    """Return `powers_at` of a row (q, s, x1, v1, tau) of a contact."""
    q = k[row]
    cosine, sine = turn(ps.omega * k[row + 4])
    z, drive = q * q, c * cosine - d * sine
    force = wall.K * z * q
    return powers_at(ps, damper, k[row + 2], k[row + 3], wall.gap + z, k[row + 1], drive, force)


@jit
def note_row(ps, damper, wall, energy, k, row):
    """Raise the largest energies to those of a row (q, s, x1, v1) of a contact."""
    q = k[row]
    note_energy(ps, damper, energy, k[row + 2], k[row + 3], wall.gap + q * q, k[row + 1])


@jit
def seek(classical, ps, damper, wall, c, d, landing, h, k, which, f0, f1):
    """Write row NEW where the factor `which` of `powers` vanishes within a step (Illinois)."""
    low, high = 0.0, 1.0
    for _ in range(40):
        x = low + (high - low) * f0 / (f0 - f1)
        rk.step(classical, None, ps, damper, wall, c, d, landing, x * h, k)
        f = powers(ps, damper, wall, c, d, k, rk.NEW)[which]
        if f == 0.0:
            return
        if (f > 0.0) == (f1 > 0.0):
            if high - x < PRECISE:
                return
            high, f1, f0 = x, f, 0.5 * f0
        else:
            if x - low < PRECISE:
                return
            low, f0, f1 = x, f, 0.5 * f1


@jit
def note_step(classical, ps, damper, wall, energy, c, d, landing, h, k):
    """Raise the largest energies to their maxima over the contact step from row Y to row NEW.

    E1 can turn only where v1 or the force beside the spring's vanishes, E2 likewise; a turn is
    located only where it could exceed what was seen.
    """
    note_row(ps, damper, wall, energy, k, rk.NEW)
    before = powers(ps, damper, wall, c, d, k, rk.Y)
    after = powers(ps, damper, wall, c, d, k, rk.NEW)
    q = k[rk.Y]
    start = energies(ps, damper, k[rk.Y + 2], k[rk.Y + 3], wall.gap + q * q, k[rk.Y + 1])
    for i in range(rk.WIDTH):
        k[rk.SAVE + i] = k[rk.NEW + i]
    time = k[rk.NEW + 4]
    for which in range(4):
        body = which // 2
        gain = abs(before[2 * body] * before[2 * body + 1])
        gain += abs(after[2 * body] * after[2 * body + 1])
        if opposite(before[which], after[which]) and start[body] + gain * time > energy[body]:
            f0, f1 = before[which], after[which]
            seek(classical, ps, damper, wall, c, d, landing, h, k, which, f0, f1)
            note_row(ps, damper, wall, energy, k, rk.NEW)
            for i in range(rk.WIDTH):
                k[rk.NEW + i] = k[rk.SAVE + i]
