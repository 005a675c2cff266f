"""The largest energies of a flight, without sampling error.

dE1/dt = v1 n1 and dE2/dt = v2 n2, where each factor is linear in the motion and its derivative: the
force n1 on a body beside the spring of its energy is m1 dv1/dt + k1 x1, in flight as on a wall. So
any *piece* will do, a motion whose polynomial stands in COEF (`flight`). Between the ends of a
cell, or of the piece of it before a touch or behind a release, the energies and powers at the two
ends bound an energy by a cubic and its error (`roots`). Few cells can hold more than the largest
energy so far. There the roots of the factors' Taylor polynomials are located piece by piece: that a
piece holds none is proven from the values at its two ends and a bound of the second derivative.
"""

from __future__ import annotations

import math

from ..motion.flight import COEF, FACTOR, OF_E2, ORDER, at
from ..motion.load_cells import Loaded
from ..motion.response_sums import PLACE, Tally, raise_to
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.roots import ROOT_STEPS, highest, narrowed, only_rises, secant
from .observe import NEAR_PEAK, alike, energies, note_energy, powers_at

SHORTEST_PIECE = 1.0e-6  # piece of a cell over which a factor that stays at zero changes no energy


@jit
def proves_no_root(f, g, bend):
    """Prove that a factor has no root between its values f and g.

    They have one sign, and the factor either changes too little to reach zero in between or, by
    the mean value theorem, so much that it is monotone.
    """
    return alike(f, g) and (min(abs(f), abs(g)) > 0.125 * bend or abs(g - f) > bend)


@jit
def work_at(ps, damper, y, drive):
    """Return (E1, E2, dE1/dt, dE2/dt) of a state y in flight; drive: cos of the forcing's phase."""
    e1, e2 = energies(ps, damper, y[0], y[1], y[2], y[3])
    v1, n1, v2, n2 = powers_at(ps, damper, y[0], y[1], y[2], y[3], drive, 0.0)
    return e1, e2, v1 * n1, v2 * n2


@jit
def may_peak(record, e0, e1, p0, p1, fourth):
    """Tell whether an energy may peak above a record inside a piece (arguments as for `roots`)."""
    return (
        highest(e0, e1, p0, p1, fourth) > record
        and not only_rises(e0, e1, p0, p1, fourth)
        and not only_rises(-e0, -e1, -p0, -p1, fourth)
    )


@jit
def push_on_damper(grid):
    """Return a bound of what a force gives the damper in units of S: of a ground that moves."""
    if is_a(grid.begun, Loaded) and grid.begun.shaking != 0.0:
        return grid.push
    return 0.0


@jit
def damper_bound(grid, scale, e2):
    """Return a bound of the fourth derivative of E2 by the place over a cell [J].

    scale: a bound of S over it; e2: E2 at its beginning. E2 is half the square of a vector u; its
    length grows by what the structure gives alone, as the rest only turns or shortens it. So the
    damper's energy is bounded by its own, which may be far less than that of the structure.
    """
    own, pull = grid.table[OF_E2 + 1], grid.table[OF_E2 + 2]
    push = grid.rate * grid.push
    s1 = grid.rate * scale + grid.push  # bounds of the first to third derivatives by time of the
    s2 = grid.rate * s1 + push  # scaled state, whose norm is S, as in `bounds.bounds_of`
    s3 = grid.rate * s2 + grid.rate * push
    shaken = push_on_damper(grid)
    u0 = math.sqrt(2.0 * e2) + (pull * scale + shaken) * grid.h
    u1 = own * u0 + (pull * scale + shaken)
    u2 = own * u1 + (pull * s1 + grid.rate * shaken)
    u3 = own * u2 + (pull * s2 + grid.rate * (grid.rate * shaken))
    u4 = own * u3 + (pull * s3 + grid.rate * (grid.rate * (grid.rate * shaken)))
    h2 = grid.h * grid.h
    return (u0 * u4 + 4.0 * u1 * u3 + 3.0 * u2 * u2) * h2 * h2


@jit
def may_set_a_record(damper, energy, grid, bounds, length, before, after):
    """Tell whether an energy may exceed the largest so far inside a piece of a cell.

    length: of the piece in cells; bounds: `bounds.Bounds` over the cell; before, after: `work_at`
    the ends of the piece.
    """
    h, square = grid.h * length, length * length
    fourth = bounds.energy * (square * square)
    possible = highest(before[0], after[0], h * before[2], h * after[2], fourth) > energy[0]
    if damper is not None:
        fourth *= grid.table[OF_E2]
        top = highest(before[1], after[1], h * before[3], h * after[3], fourth)
        possible = possible or top > energy[1]
    return possible


@jit
def record_breakers(damper, energy, grid, bounds, length, before, after):
    """Return whose energy may peak above the largest so far inside a piece, as the sum of two bits.

    1: the structure's, 2: the damper's. Either has a maximum where a cubic bound exceeds the record
    and the energy is not proven to rise or fall all along.
    The arguments of `may_set_a_record`, which has found it possible.
    """
    h, square = grid.h * length, length * length
    shorter, found = square * square, 0
    p0, p1, fourth = h * before[2], h * after[2], bounds.energy * shorter
    if may_peak(energy[0], before[0], after[0], p0, p1, fourth):
        found = 1
    if damper is not None:
        p0, p1 = h * before[3], h * after[3]
        fourth = damper_bound(grid, bounds.scale, before[1]) * shorter
        if may_peak(energy[1], before[1], after[1], p0, p1, fourth):
            found += 2
    return found


@jit
def body_of(ps, damper, body):
    """Return the mass [kg] of a body and the stiffness [N/m] of its spring; zeros of none."""
    if body == 0:
        return ps.m1, ps.k1
    if damper is None:
        return 0.0, 0.0
    return damper.m2, damper.k2


@jit
def factor_polynomial(ps, damper, grid, which):
    """Fill the rows FACTOR with the Taylor coefficients of one factor over a piece.

    The factors are v1, m1 dv1/dt + k1 x1, v2 and m2 dv2/dt + k2 (x1 - r): of the motion alone,
    whatever forces make it. Returns a bound of the second derivative.
    """
    w, bend = grid.table, 0.0
    mass, spring = body_of(ps, damper, which // 2)
    for k in range(ORDER + 1):
        i = COEF + 4 * k
        rise, f = (k + 1.0) / grid.h, w[i + 1]
        if which == 1:
            f = spring * w[i] + (mass * rise * w[i + 5] if k < ORDER else 0.0)
        elif which == 2:
            f -= w[i + 3]
        elif which == 3:
            f = spring * (w[i] - w[i + 2])
            f += mass * rise * (w[i + 5] - w[i + 7]) if k < ORDER else 0.0
        w[FACTOR + k] = f
        bend += k * (k - 1.0) * abs(f)
    return bend


@jit
def terms(w, k, x, x2):
    """Return four terms of the polynomial in the rows FACTOR, from power k on, per x^k."""
    k += FACTOR
    return (w[k] + w[k + 1] * x) + (w[k + 2] + w[k + 3] * x) * x2


@jit
def factor_at(w, x):
    """Return the value at x of the polynomial in the rows FACTOR of the table `w`."""
    x2 = x * x
    x4 = x2 * x2
    last = (w[FACTOR + 12] + w[FACTOR + 13] * x) + w[FACTOR + 14] * x2
    return (terms(w, 0, x, x2) + terms(w, 4, x, x2) * x4) + (terms(w, 8, x, x2) + last * x4) * (
        x4 * x4
    )


@jit
def note_at(ps, damper, energy, grid, x):
    """Raise the largest energies, or that of a tally's quantities which is looked at, at place x.

    Of the expanded cell; the tally's rows FACTOR hold the quantity (`response`).
    """
    if is_a(energy, Tally):
        return raise_to(energy.row, int(energy.row[PLACE]), factor_at(energy.row, x))
    return note_energy_at(ps, damper, energy, grid, x)


@jit
def note_energy_at(ps, damper, energy, grid, x):
    """Raise the largest energies to those at place x of the expanded cell."""
    y = at(grid.table, x)
    note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])


@jit
def root(w, low, high, f0, f1):
    """Return the place between low and high where the polynomial in the rows FACTOR is zero."""
    x = low
    for _ in range(ROOT_STEPS):
        x = secant(low, high, f0, f1)
        f = factor_at(w, x)
        if f == 0.0 or min(x - low, high - x) < NEAR_PEAK:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    return x


@jit
def note_roots(ps, damper, energy, grid, bend, end):
    """Raise the energies at all roots in [0, end] of the polynomial in the rows FACTOR."""
    x, width = 0.0, end
    f, g = grid.table[FACTOR], factor_at(grid.table, end)
    while x < end:
        sag = bend * width * width
        if not alike(f, g) and abs(g - f) > sag:  # monotone: one root
            note_at(ps, damper, energy, grid, root(grid.table, x, x + width, f, g))
        elif not proves_no_root(f, g, sag):
            if (
                width > SHORTEST_PIECE * end and 0.0 < sag < math.inf
            ):  # not zero throughout, nor overflown
                width *= 0.5
                g = factor_at(grid.table, x + width)
                continue
            note_at(ps, damper, energy, grid, x + width)
        x, f = x + width, g
        width = min(2.0 * width, end - x)
        g = factor_at(grid.table, x + width)


@jit
def note_peaks(ps, damper, energy, grid, end, bodies):
    """Raise the largest energies to their maxima inside [0, end] of a piece.

    bodies: whose energies may set a record (`record_breakers`).
    """
    for which in range(4):
        if bodies & (1 << which // 2):
            bend = factor_polynomial(ps, damper, grid, which)
            note_roots(ps, damper, energy, grid, bend, end)


@jit
def note_energies(ps, damper, energy, grid, end):
    """Raise the largest energies to those in [0, end] of a piece, both ends included."""
    note_peaks(ps, damper, energy, grid, end, 3)
    note_energy_at(ps, damper, energy, grid, 0.0)
    note_energy_at(ps, damper, energy, grid, end)
