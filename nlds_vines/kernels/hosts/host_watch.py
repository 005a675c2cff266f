"""Largest energies of a host and of its dampers' masses, and the response of rows.

Without rows flights and short impacts are the work of `host_energies`.

The energy of the host is E1 = (V V + squares X X) / 2 over its modes, that of a mass with its
displacement u is E2 = (m u'^2 + k u^2) / 2, as in eq. (6), and with a spring that is not linear
m u'^2 / 2 + k r^2 / 2 + G(r) (`springs`). A row w is a displacement w X + g f with
the acceleration w X'' + h f under a force f: g is 0 where it counts from moving ground, of an
absolute displacement that of the ground; the accelerations are absolute. Recorded are the largest
energies and the largest moduli of displacements and accelerations, at any instant and not at
samples, and the integrals of the squares of displacements. They leave the orbit as it is.

A flight is noted after it was flown. The values and rates of a quantity at the two ends of a cell
and a bound of its fourth derivative prove by cubics (`roots`) that it breaks no record inside; if
they do not, the next level is tried, and in a smallest cell its Taylor polynomial decides. The same
holds for a step of a contact, a polynomial in theta.

The bound is one by the derivatives of all coordinates at the beginning of a cell. They move as the
state does, so that the norms of their pairs grow within the cell by at most exp(G h) (`grid`). Fast
modes that follow slow forces have small derivatives, whatever their frequencies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..motion.response_sums import POINTS, WEIGHTS
from ..numerics.compiling import jit
from ..numerics.elementary import hypotenuse
from ..numerics.fours import from_place
from ..scene.law import HIGHEST
from ..watch.response import may_peak
from .body import accelerate, along, differentiate
from .grid import exponential, growth_of, matrix_of, pairs_of, times
from .host_energies import coordinates_of, host_energies
from .springs import add_potential

DERIVATIVES = 6  # of V that are bounded, from V itself to the 4th derivative of X''
DEGREE = 2 * HIGHEST  # of an energy's polynomial
SHORTEST = 2.0**-12  # interval with a peak: its height errs by less than SHORTEST^3 max |f'''|
GRAM_TERMS = 28  # of a series over a smallest cell, whose terms are below 1.4^k / k!


class HostRecords(NamedTuple):
    """What is recorded of a host; each array is one row of numbers."""

    masses: Any  # (size,) in the energies of coordinates [kg]; no numbers: without energies
    springs: Any  # (size,) [N/m]
    rows: Any  # rows * size: w
    # what the ground adds where f = 1 to the displacements of all rows [m], then to those
    # accelerations of the first rows that are recorded [m/s^2]
    grounds: Any
    peaks: Any  # the largest E1 and E2 of masses [J], then of the quantities of `grounds`
    squares: Any  # (rows,) integrals of squares of displacements [m^2 s]


class HostWatch(NamedTuple):
    """The records of a host, prepared, and scratch; in inner kernels all arrays are bare rows."""

    records: HostRecords
    energies: int
    rows: int
    quantities: int  # energies, displacements and accelerations
    growth: Any  # pairs * pairs: exp(G h) of a coarse cell; the numbers of the force are pairs, too
    grams: Any  # (levels + 1) * rows * (N + D)^2: of integrals of squares over a cell, lower halves
    is_on: Any  # (1,) 1 while records are kept
    alone: Any  # `host_energies.Energies`: without rows, the largest energies along flights
    jet: Any  # (DERIVATIVES + 1) * size: X and its derivatives at an instant
    force: Any  # (drives,) a derivative of the force there
    values: Any  # 4 count: quantities and rates at the beginning and end of a cell
    norms: Any  # (pairs,) of the pairs of a derivative
    bounds: Any  # DERIVATIVES * pairs: of the derivatives of V, and of the force, in a coarse cell
    table: Any  # (DEGREE + HIGHEST + 2,) two polynomials


@jit
def host_watch(body, grid, walls, records):
    """Return the `HostWatch` of records, or None if there are none."""
    if records is None:
        return None
    size, rows, a = body.size, len(records.squares), matrix_of(body)
    energies = 1 + size - body.modes if len(records.masses) > 0 else 0
    _, paired, _ = pairs_of(body, a, 0.0)
    growth = exponential(growth_of(paired, size) * (grid.h * (1 << grid.levels)))
    pairs, total, D = len(growth), len(a), body.drives
    grams = np.zeros((grid.levels + 1) * rows * total * total)
    count = energies + len(records.grounds)
    row = np.zeros(total)  # of the state and the force
    for which in range(rows):
        for i in range(size):
            row[i] = records.rows[which * size + i]
        row[2 * size] = records.grounds[which]
        # over a smallest cell by the series of dW/dt = A^T W + W A, then over two cells each time
        term = np.zeros((total, total))
        for i in range(total):
            for j in range(total):
                w = row[i] * row[j]
                term[i, j] = grid.h * w
        gram, step = term.copy(), exponential(a * grid.h)
        for k in range(2, GRAM_TERMS):
            half = times(term, a) * (grid.h / k)
            term = half + half.T
            gram += term
        for level in range(grid.levels, -1, -1):
            at = (level * rows + which) * total * total
            for i in range(total):
                for j in range(i + 1):
                    grams[at + i * total + j] = (2.0 if j < i else 1.0) * gram[i, j]
            gram += times(times(np.ascontiguousarray(step.T), gram), step)
            step = times(step, step)
    alone = host_energies(body, grid, walls, records.masses, records.springs, records.peaks)
    return HostWatch(
        records, energies, rows, count, growth.ravel(), grams, np.zeros(1), alone,
        np.zeros((DERIVATIVES + 1) * size), np.zeros(D), np.zeros(4 * count),
        np.zeros(pairs), np.zeros(DERIVATIVES * pairs), np.zeros(DEGREE + HIGHEST + 2),
    )  # fmt: skip


# ---- quantities at an instant, and their bounds in a cell ----------------------------------------


@jit
def note_instant(body, watch, y, drive, at):
    """Write all quantities to values[at:], and behind them their rates; raise the records."""
    size, jet, values, records = body.size, watch.jet, watch.values, watch.records
    count, rate = watch.quantities, body.paces[0] * drive[1]
    for i in range(2 * size):
        jet[i] = y[i]
    accelerate(body, jet, 0, drive[0], jet, 2 * size)
    accelerate(body, jet, size, rate, jet, 3 * size)
    for q in range(count):
        f = g = 0.0
        if q < watch.energies:
            first, behind = coordinates_of(body, q)
            for i in range(first, behind):
                m, k, x, v = records.masses[i], records.springs[i], jet[i], jet[size + i]
                f += 0.5 * (m * v * v + k * x * x)
                g += v * (m * jet[2 * size + i] + k * x)
        else:
            which, order = q - watch.energies, 0
            f, g = records.grounds[which] * drive[0], records.grounds[which] * rate
            if which >= watch.rows:
                which, order = which - watch.rows, 2 * size
            for i in range(size):
                f += records.rows[which * size + i] * jet[order + i]
                g += records.rows[which * size + i] * jet[order + size + i]
        values[at + q], values[at + count + q] = f, g
        records.peaks[q] = max(records.peaks[q], abs(f))


@jit
def bound_rates(body, grid, watch, y, drive):
    """Fill `bounds` from y and the force at the beginning of a coarse cell."""
    n, size, jet, force, norms = body.modes, body.size, watch.jet, watch.force, watch.norms
    pairs = size + body.drives // 2
    for i in range(2 * size):
        jet[i] = y[i]
    for i in range(body.drives):
        force[i] = drive[i]
    for k in range(DERIVATIVES):
        for i in range(size):
            x, v = (jet[k * size + i], jet[(k + 1) * size + i])
            if i >= n:
                x, v = along(body, i - n, jet, k * size)
            norms[i] = hypotenuse(grid.scales[i] * x, v)
        for i in range(size, pairs):
            norms[i] = hypotenuse(force[2 * (i - size)], force[2 * (i - size) + 1])
        for i in range(pairs):
            total = 0.0
            for j in range(pairs):
                total += watch.growth[i * pairs + j] * norms[j]
            watch.bounds[k * pairs + i] = total
        for i in range(n, size):  # u' = w q' - s
            for j in range(n):
                row = abs(body.rows[(i - n) * size + j])
                watch.bounds[k * pairs + i] += row * watch.bounds[k * pairs + j]
        if k < DERIVATIVES - 1:
            accelerate(body, jet, k * size, force[0], jet, (k + 2) * size)
            differentiate(body, force, 0)


@jit
def fourth_of(body, watch, q, y, coarse):
    """Return the bound of a quantity's fourth derivative in a cell; coarse: of a coarse one [s]."""
    size, records, total = body.size, watch.records, 0.0
    pairs, d = size + body.drives // 2, watch.bounds
    if q < watch.energies:
        first, behind = coordinates_of(body, q)
        for i in range(first, behind):
            v0, v1, v2 = d[i], d[i + pairs], d[i + 2 * pairs]
            v3, v4 = d[i + 3 * pairs], d[i + 4 * pairs]
            x = abs(y[i]) + coarse * v0
            total += records.masses[i] * (v0 * v4 + 4.0 * v1 * v3 + 3.0 * v2 * v2)
            total += records.springs[i] * (x * v3 + 4.0 * v0 * v2 + 3.0 * v1 * v1)
        return total
    which, at = q - watch.energies, 3 * pairs
    total = abs(records.grounds[which]) * d[4 * pairs + size]
    if which >= watch.rows:
        which, at = which - watch.rows, 5 * pairs
    for i in range(size):
        total += abs(records.rows[which * size + i]) * d[at + i]
    return total


@jit
def may_exceed(record, f0, f1, g0, g1, fourth):
    """Return True if |f| may exceed a record in a piece whose ends do not; arguments of `roots`."""
    return may_peak(record, f0, f1, g0, g1, fourth) or may_peak(record, -f0, -f1, -g0, -g1, fourth)


@jit
def is_quiet(body, watch, h, coarse, y):
    """Return True if no quantity exceeds its record in a cell of h [s]."""
    count, w = watch.quantities, watch.values
    for q in range(count):
        fourth = fourth_of(body, watch, q, y, coarse) * ((h * h) * (h * h))
        f1, g0, g1 = w[2 * count + q], h * w[count + q], h * w[3 * count + q]
        if may_exceed(watch.records.peaks[q], w[q], f1, g0, g1, fourth):
            return False
    return True


@jit
def add_squares(body, watch, level, y, drive):
    """Add the integrals of squares over a cell of some level from y and the force on."""
    N, D = 2 * body.size, body.drives
    at = level * watch.rows * (N + D) * (N + D)
    for which in range(watch.rows):
        for i in range(N + D):
            part = 0.0
            for j in range(i + 1):
                part += watch.grams[at + j] * (y[j] if j < N else drive[j - N])
            watch.records.squares[which] += part * (y[i] if i < N else drive[i - N])
            at += N + D


# ---- polynomials over a piece --------------------------------------------------------------------


@jit
def value_and_slope(c, degree, x):
    f = d = 0.0
    for k in range(degree, -1, -1):
        d = d * x + f
        f = f * x + c[k]
    return f, d


@jit
def largest_in(c, degree, record):
    """Return the larger of a record and of f in [0, 1]; c: the coefficients of f."""
    fourth, x, width, f0, g0 = 0.0, 0.0, 1.0, c[0], c[1]
    for k in range(4, degree + 1):
        fourth += k * (k - 1.0) * (k - 2.0) * (k - 3.0) * abs(c[k])
    record = max(record, f0)
    while x < 1.0:
        f1, g1 = value_and_slope(c, degree, x + width)
        record = max(record, f1)
        h4 = (width * width) * (width * width)
        if may_peak(record, f0, f1, width * g0, width * g1, fourth * h4):
            if width > SHORTEST:
                width *= 0.5
                continue
            if g0 > 0.0 and g1 < 0.0:
                f, _ = value_and_slope(c, degree, x + width * (g0 / (g0 - g1)))
                record = max(record, f)
        x, f0, g0 = x + width, f1, g1
        width = min(4.0 * width, 1.0 - x)
    return record


@jit
def read_line(S, width, column, x, line):
    """Write the coefficients of a column over [0, x], by powers of the place / x, to a line."""
    power = 1.0
    for k in range(HIGHEST + 1):
        line[k] = power * S[width * k + column]
        power *= x


@jit
def note_series(body, watch, S, layout, x):
    """Raise the records to those over [0, x] of a series of the motion.

    layout: (width, column of the force f, column of dt/dtheta, unit of theta).
    """
    if watch.is_on[0] == 0.0:
        return
    (width, of_force, of_pace, unit), size, c = layout, body.size, watch.table
    line = from_place(c, DEGREE + 1)
    records, peaks = watch.records, watch.records.peaks
    for e in range(watch.energies):
        first, behind = coordinates_of(body, e)
        for k in range(DEGREE + 1):
            c[k] = 0.0
        for i in range(first, behind):
            for column, factor in ((i, records.springs[i]), (size + i, records.masses[i])):
                read_line(S, width, column, x, line)
                for k in range(HIGHEST + 1):
                    term = factor * line[k]
                    c[2 * k] += 0.5 * term * line[k]
                    for m in range(k + 1, HIGHEST + 1):
                        c[k + m] += term * line[m]
        if body.springs is not None and e > 0:
            add_potential(body, e - 1, x, c, int(DEGREE))
        peaks[e] = largest_in(c, int(DEGREE), peaks[e])
    for q in range(watch.quantities - watch.energies):
        which, at, ground = q, 0, records.grounds[q]
        if q >= watch.rows:
            which, at = q - watch.rows, 2 * size
        read_line(S, width, of_force, x, line)
        for k in range(HIGHEST + 1):
            c[k] = ground * line[k]
        for i in range(size):
            read_line(S, width, at + i, x, line)
            for k in range(HIGHEST + 1):
                c[k] += records.rows[which * size + i] * line[k]
        if q < watch.rows:
            read_line(S, width, of_pace, x, line)
            for g in range(6):
                f, _ = value_and_slope(c, int(HIGHEST), POINTS[g])
                pace, _ = value_and_slope(line, int(HIGHEST), POINTS[g])
                records.squares[which] += WEIGHTS[g] * (unit * x * pace) * (f * f)
        for _ in range(2):  # the largest f, and the largest -f
            peaks[watch.energies + q] = largest_in(c, int(HIGHEST), peaks[watch.energies + q])
            for k in range(HIGHEST + 1):
                c[k] = -c[k]
