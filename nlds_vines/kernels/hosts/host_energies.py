"""The largest energies of a host along a flight and in a short impact, proven piece by piece.

An energy E, half the sum of m v^2 + k x^2 over its coordinates, changes by the power of the forces
that are not those of its springs, n = m v' + k x: E' = sum of v n. With the bounds V_j and N_j of
the derivatives of v sqrt(m) and n / sqrt(m), vectors over the coordinates, for a while before or
after a state

    |E''''| <= V_0 N_3 + 3 V_1 N_2 + 3 V_2 N_1 + V_3 N_0                                        (1)

The derivatives of y obey the equation of motion, too, so that the norms of their pairs (`grid`)
grow by at most exp(G h); V_j and N_j are sums of these norms with weights. Fast modes that follow
slow forces have small derivatives, whatever their frequencies, and the energy of a resonance, which
is nearly constant, has small ones, too, as n is much less than k x.

A flight is noted after it was flown, in pieces that end where aligned cells end. The energies and
their rates at the two ends of a piece and (1) prove by a cubic (`roots`) that no record is broken
in it. If E'' is negative at both ends by more than h^2 / 8 of the bound (1), it is negative in
between, as a chord of E'' errs by no more. Then a peak is single, and Newton's method locates it.
Otherwise the piece is halved. The cell in which a flight ends is first judged as a whole, as if the
flight went on.

In a short impact, with u = L y = (sqrt(m) v, sqrt(k) x) so that E = |u|^2 / 2, let y_f be the
flight before it, and y_a that after it, both continued through the impact; f is the force, J = J_0
its impulse, a share of which, lambda, has acted at time t. With the rates b of a unit impulse and
g(s) = L exp(A s) b, |g'| <= H for |s| <= T,

    u = (1 - lambda) u_f + lambda u_a + d    |d| <= lambda (1 - lambda) J T H                   (2)

since d is lambda (1 - lambda) J times the difference of two means of g, which are weighted with
f and T or less apart. And |u_a - u_f| >= D = J (|L b| - T H). So with U >= |u_f|, |u_a|, K = J T H

    2 E <= max(|u_f|^2, |u_a|^2) + lambda (1 - lambda) (2 U K + K^2 / 4 - D^2)                  (3)

and lambda (1 - lambda) <= 1/4. The impulse of a brief impact is so strong a change that the last
factor is negative, and the energy exceeds nowhere the larger one of both flights. They are bounded
by Taylor polynomials of third degree about the touch and about the release, and by (1).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import power_of_two
from ..numerics.fours import four, four_at, put_four, roots_of, sum_of
from ..numerics.roots import ROOT_STEPS, guarded, highest, only_rises
from .body import accelerate, differentiate
from .grid import derivative_of, exponential, growth_of, matrix_of, norms_by_pair, pairs_of
from .host_flight import carry, drive_of, put_columns

ORDERS = 4  # of v and n that are bounded, themselves to their third derivatives
JET = 5  # of X: its derivatives up to the fourth
LOCATED = 1.0e-9  # of E: the rise from the place of a located peak to its top, which is added
# of a smallest cell; a shorter piece is taken by its ends: E' and E'' vanish almost at one place
# of it, so that E varies by some 2^-36 of the energy
HALVINGS = 12


class Energies(NamedTuple):
    """What bounds the energies of a host, and scratch; in inner kernels all arrays are bare rows.

    Pairs are those of `grid.pairs_of` and of the drive's numbers, in whole fours.
    """

    number: int
    masses: Any  # (size,) of coordinates [kg]
    springs: Any  # (size,) [N/m]
    peaks: Any  # the largest energies [J]
    fours: int  # of pairs
    # for each four of pairs and each derivative of y, by columns of y and of the drive: four places
    # in units of rates, four rates
    derivatives: Any
    after: Any  # 2 count * fours: weights of V_j, then of N_j over a coarse cell after a state
    before: Any  # and over one before it
    changes: Any  # 2 walls * count: |L b| of a unit impulse in units of g_0, then H
    values: Any  # 4 count: energies and rates at the beginning of a piece, and at its end
    bends: Any  # 2 count: E'' there
    norms: Any  # ORDERS * fours: of pairs
    bounds: Any  # 2 ORDERS: V_j and N_j
    fourths: Any  # (count,) bounds of |E''''| [W/s^3]
    jet: Any  # JET * size: X and its derivatives at an instant
    force: Any  # (drives,) a derivative of the force there
    base: Any  # (2 size,) the base of a flight
    ahead: Any  # (2 size,) the state at the end of a piece
    peak: Any  # (2 size,) that at a peak


@jit
def host_energies(body, grid, walls, masses, springs, peaks):
    """Return the `Energies` of a host; without masses there is none."""
    size, n, drives = body.size, body.modes, body.drives
    count = 1 + size - n if len(masses) > 0 else 0
    pairs = size + drives // 2
    whole, columns = (pairs + 3) // 4 * 4, 2 * size + drives
    energies = Energies(
        count, masses, springs, peaks, whole, np.zeros(ORDERS * 2 * whole * columns),
        np.zeros(2 * count * whole), np.zeros(2 * count * whole),
        np.zeros(2 * walls.number * count), np.zeros(4 * count), np.zeros(2 * count),
        np.zeros(ORDERS * whole), np.zeros(2 * ORDERS), np.zeros(count), np.zeros(JET * size),
        np.zeros(drives), np.zeros(2 * size), np.zeros(2 * size), np.zeros(2 * size),
    )  # fmt: skip
    if count == 0:
        return energies
    a = matrix_of(body)
    scales, paired, back = pairs_of(body, a, body.omega)
    coarse = grid.h * (1 << grid.levels)
    after = exponential(growth_of(paired, size) * coarse)
    before = exponential(growth_of(-paired, size) * coarse)
    for p in range(pairs):
        fill_derivatives(body, scales, a, p, energies.derivatives)
    for q in range(count):
        rates, works, parts = np.zeros(pairs), np.zeros(pairs), np.zeros(pairs)
        first, behind = coordinates_of(body, q)
        for i in range(first, behind):
            root = math.sqrt(masses[i])
            place, rate = np.zeros(columns), np.zeros(columns)
            place[i], rate[size + i] = math.sqrt(springs[i]), root
            work = root * a[size + i]
            work[i] += springs[i] / root
            add_squares_of(body, rate, scales, back, rates)
            add_squares_of(body, work, scales, back, works)
            add_squares_of(body, place, scales, back, parts)
        for p in range(pairs):
            for b in range(pairs):
                energies.after[q * whole + b] += math.sqrt(rates[p]) * after[p, b]
                energies.before[q * whole + b] += math.sqrt(rates[p]) * before[p, b]
                energies.after[(count + q) * whole + b] += math.sqrt(works[p]) * after[p, b]
                energies.before[(count + q) * whole + b] += math.sqrt(works[p]) * before[p, b]
        for wall in range(walls.number):
            kick = np.zeros(columns)
            for i in range(size):
                kick[size + i] = body.answers[walls.links[wall] * size + i] / walls.inverse[wall]
            put_norms(body, energies, kick)
            square = drift = 0.0
            for i in range(first, behind):
                square += masses[i] * kick[size + i] * kick[size + i]
            for p in range(pairs):
                for b in range(pairs):
                    weight = math.sqrt(rates[p] + parts[p]) * max(after[p, b], before[p, b])
                    drift += weight * energies.norms[whole + b]
            energies.changes[wall * count + q] = math.sqrt(square)
            energies.changes[(walls.number + wall) * count + q] = drift
    return energies


@jit
def fill_derivatives(body, scales, a, pair, derivatives):
    """Fill the rows by which y and the drive give the derivatives of a pair."""
    size, n, columns = body.size, body.modes, len(a)
    place, rate = np.zeros(columns), np.zeros(columns)
    if pair >= size:
        place[2 * pair] = rate[2 * pair + 1] = 1.0
    elif pair < n:
        place[pair], rate[size + pair] = scales[pair], 1.0
    else:
        for i in range(size):
            row = body.rows[(pair - n) * size + i]
            place[i], rate[size + i] = scales[pair] * row, row
    for k in range(ORDERS):
        at = (pair // 4 * ORDERS + k) * columns * 8 + pair % 4
        for column in range(columns):
            derivatives[at + 8 * column] = place[column]
            derivatives[at + 8 * column + 4] = rate[column]
        place, rate = derivative_of(a, place), derivative_of(a, rate)


@jit
def add_squares_of(body, row, scales, back, squares):
    """Add the squares of a row's norms by pairs."""
    norms = norms_by_pair(body, row, scales, back)
    for p in range(len(norms)):
        squares[p] += norms[p] * norms[p]


@jit
def coordinates_of(body, energy):
    """Return the first coordinate in an energy, and that behind its last one."""
    n = body.modes
    return (0, n) if energy == 0 else (n + energy - 1, n + energy)


# ---- energies at an instant, and their bounds ----------------------------------------------------


@jit
def put_energies(body, energies, y, drive, at):
    """Write the energies at a state to values[at:], and behind them their rates."""
    size, count, values, a = body.size, energies.number, energies.values, energies.jet
    accelerate(body, y, 0, drive[0], a, 0)
    for q in range(count):
        total = rate = 0.0
        first, behind = coordinates_of(body, q)
        for i in range(first, behind):
            m, k, x, v = energies.masses[i], energies.springs[i], y[i], y[size + i]
            total += m * v * v + k * x * x
            rate += v * (m * a[i] + k * x)
        values[at + q] = 0.5 * total
        values[at + count + q] = rate


@jit
def raise_energies(energies, at):
    """Raise the records to the energies in values[at:]."""
    for q in range(energies.number):
        energies.peaks[q] = max(energies.peaks[q], energies.values[at + q])


@jit
def put_jet(body, energies, y, drive):
    """Fill `jet` at a state."""
    size, jet, force = body.size, energies.jet, energies.force
    for i in range(2 * size):
        jet[i] = y[i]
    for i in range(body.drives):
        force[i] = drive[i]
    for k in range(JET - 2):
        accelerate(body, jet, k * size, force[0], jet, (k + 2) * size)
        differentiate(body, force, 0)


@jit
def slopes_of(body, energies, energy):
    """Return (E, E', E'', E''') of an energy from a jet."""
    size, jet = body.size, energies.jet
    f = g = bend = jerk = 0.0
    first, behind = coordinates_of(body, energy)
    for i in range(first, behind):
        m, k = energies.masses[i], energies.springs[i]
        x, v, a = jet[i], jet[size + i], jet[2 * size + i]
        b, c = jet[3 * size + i], jet[4 * size + i]
        f += 0.5 * (m * v * v + k * x * x)
        g += v * (m * a + k * x)
        bend += m * (v * b + a * a) + k * (x * a + v * v)
        jerk += m * (v * c + 3.0 * a * b) + k * (x * b + 3.0 * v * a)
    return f, g, bend, jerk


@jit
def put_norms(body, energies, columns):
    """Fill the norms of the pairs of y and of its derivatives; columns: y and the drive."""
    whole, norms, width = energies.fours, energies.norms, 2 * body.size + body.drives
    row = 0
    for first in range(0, whole, 4):
        for k in range(ORDERS):
            places, rates = four(0.0), four(0.0)
            for column in range(width):
                places = places + four_at(energies.derivatives, row) * columns[column]
                rates = rates + four_at(energies.derivatives, row + 4) * columns[column]
                row += 8
            put_four(norms, k * whole + first, roots_of(places * places + rates * rates))


@jit
def bound_fourths(body, energies, weights, columns):
    """Fill `fourths` with the bounds (1) over a coarse cell after or before a state.

    weights: `after` or `before`; columns: the state and the drive.
    """
    whole, norms, bounds = energies.fours, energies.norms, energies.bounds
    put_norms(body, energies, columns)
    for q in range(energies.number):
        for part in range(2):
            row = (part * energies.number + q) * whole
            for k in range(ORDERS):
                total = four(0.0)
                for p in range(0, whole, 4):
                    total = total + four_at(weights, row + p) * four_at(norms, k * whole + p)
                bounds[part * ORDERS + k] = sum_of(total)
        fourth = bounds[0] * bounds[ORDERS + 3] + 3.0 * (bounds[1] * bounds[ORDERS + 2])
        fourth += 3.0 * (bounds[2] * bounds[ORDERS + 1]) + bounds[3] * bounds[ORDERS]
        energies.fourths[q] = fourth


# ---- a flight ------------------------------------------------------------------------------------


@jit
def note_energies(host, energies, base, begun, ended):
    """Raise the records to the largest energies of a flight between two places (j, x).

    `Energies.base` is the state at the place `base`, `Scratch.begin` that at the beginning,
    `Scratch.touch` that at the end, if the flight ends within a cell.
    """
    body, grid, scratch, count = host.body, host.grid, host.scratch, energies.number
    (j, x), (last, rest), (first, shift) = begun, ended, base
    y, z, values, drive = scratch.begin, energies.ahead, energies.values, scratch.drive
    coarse = 1 << grid.levels
    is_based, level, valid = shift == 0.0, 0, -1.0
    drive_of(grid, j, x, drive)
    put_energies(body, energies, y, drive, 0)
    raise_energies(energies, 0)
    while j < last or x < rest:
        if level <= grid.levels:
            cells = coarse >> level
            to, to_x = (j // cells + 1) * cells, 0.0
        else:
            to, to_x = j, x + power_of_two(grid.levels - level)
            if not to_x < 1.0:
                to, to_x = j + 1, 0.0
        is_real = to < last or (to == last and to_x <= rest)
        if not is_real and level >= grid.levels:
            to, to_x, is_real = last, rest, True
        length = (to - j) + (to_x - x)
        if to == last and to_x == rest and rest > 0.0:
            for i in range(2 * body.size):
                z[i] = scratch.touch[i]
        elif x > 0.0 and is_based and to_x == 0.0:
            for i in range(2 * body.size):
                z[i] = energies.base[i]
            carry(body, grid, scratch, (first, shift), (to, to_x), z)
        else:
            for i in range(2 * body.size):
                z[i] = y[i]
            carry(body, grid, scratch, (j, x), (to, to_x), z)
        if to + to_x > valid:
            put_columns(body, grid, (j, x), y, scratch.columns)
            bound_fourths(body, energies, energies.after, scratch.columns)
            valid = j + x + coarse
        drive_of(grid, to, to_x, drive)
        put_energies(body, energies, z, drive, 2 * count)
        if is_real:
            raise_energies(energies, 2 * count)
        is_settled = settle_piece(host, energies, (j, x), length, is_real)
        if not is_settled and level < grid.levels + HALVINGS:
            level += 1
            continue
        if not is_real:
            return
        for i in range(2 * body.size):
            y[i] = z[i]
        for i in range(2 * count):
            values[i] = values[2 * count + i]
        j, x, level = to, to_x, max(level - 1, 0)


@jit
def settle_piece(host, energies, begun, length, is_real):
    """Return True if no energy exceeds its record in a piece of a flight, after peaks were noted.

    length: in smallest cells; is_real: False if the flight ends within the piece.
    """
    body, count, values, bends = host.body, energies.number, energies.values, energies.bends
    h, is_quiet = length * host.grid.h, True
    h2 = h * h
    h4 = h2 * h2
    for q in range(count):
        is_quiet = is_quiet and is_below(energies, q, h, h4, is_real)
    if is_quiet or not is_real:
        return is_quiet
    drive, scratch = host.scratch.drive, host.scratch
    put_jet(body, energies, energies.ahead, drive)
    for q in range(count):
        _, _, bends[count + q], _ = slopes_of(body, energies, q)
    (j, x), is_single = begun, True
    drive_of(host.grid, j, x, drive)
    put_jet(body, energies, scratch.begin, drive)
    for q in range(count):
        _, _, bends[q], _ = slopes_of(body, energies, q)
        if not is_below(energies, q, h, h4, True):
            chord = max(bends[q], bends[count + q])
            is_single = is_single and chord + 0.125 * h2 * energies.fourths[q] < 0.0
    if not is_single:
        return False
    for q in range(count):
        falls = values[count + q] > 0.0 > values[3 * count + q]
        if falls and not is_below(energies, q, h, h4, True):
            locate_peak(host, energies, q, begun, length)
    return True


@jit
def is_below(energies, q, h, h4, is_real):
    """Return True if an energy is proven not to exceed its record in a piece of h [s].

    Both ends are below it; that of a piece that is not real may be above it.
    """
    count, values = energies.number, energies.values
    f0, f1 = values[q], values[2 * count + q]
    g0, g1 = h * values[count + q], h * values[3 * count + q]
    fourth = h4 * energies.fourths[q]
    if highest(f0, f1, g0, g1, fourth) <= energies.peaks[q]:
        return True
    if only_rises(-f0, -f1, -g0, -g1, fourth):
        return True
    return is_real and only_rises(f0, f1, g0, g1, fourth)


@jit
def locate_peak(host, energies, q, begun, length):
    """Raise a record to the single peak of an energy in a piece, in which E'' is negative.

    By Newton's method for E' from the root of the cubic with the values and slopes of E' at both
    ends. The parabola of E, E' and E'' at the last place errs by a third derivative times the cube
    of the rest of the way, some LOCATED^1.5 of E.
    """
    body, grid, scratch, count = host.body, host.grid, host.scratch, energies.number
    values, y, (j, x), h, f = energies.values, energies.peak, begun, length * host.grid.h, 0.0
    g0, g1 = values[count + q], values[3 * count + q]
    place = root_of_slope(g0, g1, h * energies.bends[q], h * energies.bends[count + q])
    low, high = 0.0, 1.0
    for _ in range(ROOT_STEPS):
        at = x + place * length
        whole = int(at)
        for i in range(2 * body.size):
            y[i] = scratch.begin[i]
        carry(body, grid, scratch, begun, (j + whole, at - whole), y)
        drive_of(grid, j + whole, at - whole, scratch.drive)
        put_jet(body, energies, y, scratch.drive)
        f, g, bend, _ = slopes_of(body, energies, q)
        rise = -0.5 * g * g / bend
        if rise <= LOCATED * f:
            energies.peaks[q] = max(energies.peaks[q], f + rise)
            return
        if g > 0.0:
            low = place
        else:
            high = place
        place = guarded(place - g / (h * bend), low, high)
    energies.peaks[q] = max(energies.peaks[q], f)


@jit
def root_of_slope(g0, g1, d0, d1):
    """Return the place in [0, 1] where the cubic with values g0 > 0 > g1, slopes d0 and d1 is 0."""
    second, third = 3.0 * (g1 - g0) - 2.0 * d0 - d1, 2.0 * (g0 - g1) + d0 + d1
    low, high, place = 0.0, 1.0, g0 / (g0 - g1)
    for _ in range(4):
        g = g0 + place * (d0 + place * (second + place * third))
        slope = d0 + place * (2.0 * second + 3.0 * place * third)
        if g > 0.0:
            low = place
        else:
            high = place
        place = guarded(place - g / slope, low, high) if slope < 0.0 else 0.5 * (low + high)
    return place


# ---- a short impact ------------------------------------------------------------------------------


@jit
def is_impact_below(host, energies, wall, impulse, took, ends):
    """Return True if every energy is proven not to exceed its record in a short impact, by (3).

    impulse: g_0 J_0 [m/s]; took: its duration [s]; ends: the places (j, x) of the touch and of the
    release, of which `Scratch.touch` and `Scratch.begin` are the states.
    """
    body, grid, scratch, count = host.body, host.grid, host.scratch, energies.number
    horizon, bends, (touch, release) = grid.h * (1 << grid.levels), energies.bends, ends
    if took > horizon:
        return False
    drive_of(grid, release[0], release[1], scratch.drive)
    put_energies(body, energies, scratch.begin, scratch.drive, 0)
    raise_energies(energies, 0)  # before the flight that follows is noted
    put_columns(body, grid, release, scratch.begin, scratch.columns)
    bound_fourths(body, energies, energies.before, scratch.columns)
    put_jet(body, energies, scratch.begin, scratch.drive)
    for q in range(count):
        bends[q] = highest_within(body, energies, q, -took)
    drive_of(grid, touch[0], touch[1], scratch.drive)
    put_energies(body, energies, scratch.touch, scratch.drive, 0)
    put_columns(body, grid, touch, scratch.touch, scratch.columns)
    bound_fourths(body, energies, energies.after, scratch.columns)
    put_jet(body, energies, scratch.touch, scratch.drive)
    for q in range(count):
        largest = max(bends[q], highest_within(body, energies, q, took))
        at = wall * count + q
        change, drift = energies.changes[at], energies.changes[host.walls.number * count + at]
        u, spread = math.sqrt(2.0 * largest), impulse * took * drift
        apart = impulse * max(change - took * drift, 0.0)
        excess = 2.0 * u * spread + 0.25 * spread * spread - apart * apart
        if not largest + 0.125 * max(excess, 0.0) <= energies.peaks[q]:
            return False
    return True


@jit
def highest_within(body, energies, q, time):
    """Return a bound of an energy from an instant on to a `time` [s] later, or before if it is < 0.

    By its Taylor polynomial of third degree, of which `jet` holds the derivatives, and the bound
    (1). In the Bernstein basis the polynomial and its slope lie between their coefficients.
    """
    f, g, bend, jerk = slopes_of(body, energies, q)
    square = time * time
    first, second = time * g, 0.5 * square * bend
    third, fourth = time * square * jerk / 6.0, square * square * energies.fourths[q]
    falls = max(max(first, first + second), first + 2.0 * second + 3.0 * third)
    if falls + fourth / 6.0 < 0.0:
        return f
    top = max(first / 3.0, (2.0 * first + second) / 3.0)
    top = max(max(0.0, top), first + second + third)
    return f + top + fourth / 24.0
