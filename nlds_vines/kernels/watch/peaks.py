"""The largest energies of a piece of motion, without sampling error.

dE1/dt = v1 n1 and dE2/dt = v2 n2, where each factor is linear in the motion and its derivative: the
force n1 on a body beside the spring of its energy is m1 dv1/dt + k1 x1, in flight as on a wall. So
any *piece* will do, a motion whose polynomial stands in COEF (`flight`): a cell by the time, a step
of a contact by theta. Between the ends of a cell of a flight, or of the part of it before a touch
or behind a release, the energies and powers at the two ends bound an energy by a cubic and its
error (`roots`); of other pieces the coordinates are bounded. Few can hold more than the largest
energy so far. There the roots of the factors' Taylor polynomials are located part by part: that one
holds none is proven from the values at its two ends and a bound of the second derivative.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..motion.flight import COEF, FACTOR, OF_E2, ORDER, at
from ..motion.load_cells import Loaded
from ..motion.response_sums import PLACE, Tally, raise_to
from ..motion.taylor import advance, order_of, part_of, restore, set_aside
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.roots import ROOT_STEPS, highest, narrowed, only_rises, secant
from ..scene.arguments import StepPiece
from ..scene.contact_series import COLUMNS, DS, DV, FORCE, NEW, SERIES, UNIT, term_of
from ..scene.law import depth_of, force_of
from .observe import alike, energies, note_energy, note_force, powers_at

NEAR_PEAK = 1.0e-7  # error of the place of a peak in a piece: its height errs by the square
SHORTEST_PIECE = 1.0e-6  # piece of a cell over which a factor that stays at zero changes no energy


class OfEnergies(NamedTuple):
    """What looks for the largest energies at places of a piece."""

    ps: Any
    damper: Any
    energy: Any  # (2,) the largest so far [J]
    table: Any  # of the piece, with COEF


class OfPush(NamedTuple):
    """What looks for the greatest force at places of a contact's step."""

    impacts: Any
    side: Any
    step: Any


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
    v1, n1, v2, n2 = powers_at(ps, damper, y[0], y[1], y[2], y[3], drive)
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
def accelerations_in(piece, n):
    """Return coefficient n of dv1/dt and of ds/dt over a piece, by the place in it."""
    w = piece.table
    if is_a(piece, StepPiece):
        return piece.sign * term_of(w, int(DV), n), piece.sign * term_of(w, int(DS), n)
    if n == ORDER:
        return 0.0, 0.0
    rise, i = (n + 1.0) / piece.h, COEF + 4 * n + 4
    return rise * w[i + 1], rise * w[i + 3]


@jit
def factor_polynomial(ps, damper, piece, which):
    """Fill the rows FACTOR with the Taylor coefficients of one factor over a piece.

    The factors are v1, m1 dv1/dt + k1 x1, v2 and m2 dv2/dt + k2 (x1 - r): of the motion alone,
    whatever forces make it. Returns a bound of the second derivative.
    """
    w, (mass, spring) = piece.table, body_of(ps, damper, which // 2)
    for n in range(ORDER + 1):
        i, (a, ds) = COEF + 4 * n, accelerations_in(piece, n)
        x, v = w[i], w[i + 1]
        if which >= 2:
            x, v, a = x - w[i + 2], v - w[i + 3], a - ds
        w[FACTOR + n] = v if which % 2 == 0 else mass * a + spring * x
    return bend_in(w)


@jit
def bend_in(w):
    """Return a bound of the second derivative of the polynomial in the rows FACTOR."""
    bend = 0.0
    for n in range(2, ORDER + 1):
        bend += n * (n - 1.0) * abs(w[FACTOR + n])
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
def note_at(noter, x):
    """Note what a noter looks for at place x of the piece.

    `OfEnergies`, `OfPush`, or a tally, whose rows FACTOR hold one of its quantities (`response`).
    """
    if is_a(noter, Tally):
        return raise_to(noter.row, int(noter.row[PLACE]), factor_at(noter.row, x))
    if is_a(noter, OfPush):
        return note_push_at(noter, x)
    return note_energy_at(noter, x)


@jit
def note_energy_at(noter, x):
    """Raise the largest energies to those at place x of the piece."""
    y = at(noter.table, x)
    note_energy(noter.ps, noter.damper, noter.energy, y[0], y[1], y[2], y[3])


@jit
def note_push_at(noter, x):
    """Raise the greatest force to that at place x of the step. Row NEW is kept."""
    k = noter.side.k
    set_aside(k)
    advance(noter.side, None, part_of(noter.step, x))
    note_force(noter.impacts, push_now(noter.side))
    restore(k)


@jit
def push_now(side):
    """Return the force [N] of row NEW."""
    wall, q = side.wall, side.k[NEW]
    return force_of(wall, q, depth_of(wall, q), side.k[NEW + 1])


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
def note_roots(noter, w, bend, end):
    """Note what a noter looks for at all roots in [0, end] of the polynomial in the rows FACTOR."""
    x, width = 0.0, end
    f, g = w[FACTOR], factor_at(w, end)
    while x < end:
        sag = bend * width * width
        if not alike(f, g) and abs(g - f) > sag:  # monotone: one root
            note_at(noter, root(w, x, x + width, f, g))
        elif not proves_no_root(f, g, sag):
            if (
                width > SHORTEST_PIECE * end and 0.0 < sag < math.inf
            ):  # not zero throughout, nor overflown
                width *= 0.5
                g = factor_at(w, x + width)
                continue
            note_at(noter, x + width)
        x, f = x + width, g
        width = min(2.0 * width, end - x)
        g = factor_at(w, x + width)


@jit
def note_peaks(ps, damper, energy, piece, end, bodies):
    """Raise the largest energies to their maxima inside [0, end] of a piece.

    bodies: whose energies may set a record (`record_breakers`).
    """
    for which in range(4):
        if bodies & (1 << which // 2):
            bend = factor_polynomial(ps, damper, piece, which)
            note_roots(OfEnergies(ps, damper, energy, piece.table), piece.table, bend, end)


@jit
def bodies_within(ps, damper, energy, w, end):
    """Return whose energy may exceed the largest so far in [0, end] of a piece (`note_peaks`).

    A coordinate or velocity is nowhere larger than at the ends by more than an eighth of what its
    second derivative may be.
    """
    x, v, p, u, sag = 0.0, 0.0, 0.0, 0.0, 0.125 * end * end
    for n in range(2, ORDER + 1):
        i, part = COEF + 4 * n, n * (n - 1.0) * sag
        x, v = x + part * abs(w[i]), v + part * abs(w[i + 1])
        p, u = p + part * abs(w[i] - w[i + 2]), u + part * abs(w[i + 1] - w[i + 3])
    y, z = at(w, 0.0), at(w, end)
    x, v = x + max(abs(y[0]), abs(z[0])), v + max(abs(y[1]), abs(z[1]))
    p += max(abs(y[0] - y[2]), abs(z[0] - z[2]))
    u += max(abs(y[1] - y[3]), abs(z[1] - z[3]))
    found = 0
    mass, spring = body_of(ps, damper, 0)
    if 0.5 * (mass * v * v + spring * x * x) > energy[0]:
        found = 1
    mass, spring = body_of(ps, damper, 1)
    if 0.5 * (mass * u * u + spring * p * p) > energy[1]:
        found += 2
    return found


@jit
def note_energies(ps, damper, energy, piece, end):
    """Raise the largest energies to those in [0, end] of a piece, both ends included."""
    noter = OfEnergies(ps, damper, energy, piece.table)
    note_energy_at(noter, 0.0)
    note_energy_at(noter, end)
    note_peaks(ps, damper, energy, piece, end, bodies_within(ps, damper, energy, piece.table, end))


@jit
def note_push(side, impacts, step):
    """Raise the greatest force of an impact to that in the step from row Y to row NEW.

    At its end, or where it turns. Row NEW is kept.
    """
    k, power, last = side.k, 1.0, order_of(side.rk4) - 1
    note_force(impacts, push_now(side))
    for n in range(ORDER + 1):  # of the rate
        k[FACTOR + n] = 0.0
        if n < last:
            k[FACTOR + n] = (n + 1.0) * power * k[SERIES + COLUMNS * (n + 1) + FORCE]
        power *= step.h / k[UNIT]
    note_roots(OfPush(impacts, side, step), k, bend_in(k), 1.0)
