"""Largest energies of a piece of motion, and the response: maxima, rms values and mean powers.

Both are recorded piece by piece while an orbit is followed, without effect on the orbit. A piece,
a cell of a flight or a step of a contact, is a Taylor polynomial. Products of states are integrated
at Gauss points; the error is below round-off in the longest cell (1.4^12 / 6e15, as products turn
twice as fast). A quantity has its maximum where its rate, a polynomial too, vanishes. Such roots
are searched if bounds of the second derivative allow a new maximum, and proven to be complete
(`note_roots`).

Power comes in by the force P cos(omega t), which acts on both bodies if the ground moves, since
energies are relative to it. It is dissipated by the
dashpots and by contacts: by the inelastic part of the force, or by rigid impacts. The rest is the
change of the stored energy.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import COEF, FACTOR, OF_E2, ORDER, SHORT, at, grid_with, rate_of, turned
from ..motion.load_cells import (
    Stretch,
    force_term,
    grid_under,
    polynomial_from,
)
from ..motion.response_sums import (
    A2,
    CS,
    CV,
    IMPULSE,
    JUMPS,
    LOSS,
    MOST,
    MOST_FORCE,
    OF_A,
    OF_DISPLACED,
    OF_FORCE,
    OF_R,
    OF_V,
    PLACE,
    POINTS,
    R2,
    S2,
    SIZE,
    V2,
    WEIGHTS,
    X2,
    Y2,
    Tally,
    absolute,
    add_displaced,
    add_state,
    place_of_largest,
    raise_to,
)
from ..motion.taylor import advance, part_of, restore, set_aside
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import cos_sin_of_turn
from ..numerics.fours import bare, four, four_at, larger_of, number_of
from ..numerics.roots import ROOT_STEPS, highest, narrowed, only_rises, secant
from ..scene.by_law import by_wall
from ..scene.codes import EXHAUSTED, OF_FORCES, OF_IMPULSES, POWERS, STOPPED
from ..scene.drive import Moment, moved
from ..scene.law import (
    AT_S,
    COSINE,
    DS,
    DV,
    ELASTIC,
    FORCE,
    LENGTHS,
    NEW,
    UNIT,
    WEIGHT,
    column_at,
    depth_of,
    force_of,
    term_of,
)
from ..scene.scene import StepPiece, joined
from .observe import alike, energies, note_energy, note_force, powers_at
from .touch import LOST, first_touch, note_limit, tightened

# ---- The largest energies of a piece of motion, without sampling error ---------------------------
#
# dE1/dt = v1 n1 and dE2/dt = v2 n2, where each factor is linear in the motion and its derivative:
# the force n1 without that of the energy's spring is m1 dv1/dt + k1 x1, in flight as on a wall. A
# *piece* is a motion whose polynomial stands in COEF (`flight`): a cell by the time, a step of a
# contact by theta. In a cell of a flight, or the part of it before a touch or after a release, the
# energies and powers at the two ends bound an energy by a cubic and its error (`roots`); in other
# pieces the coordinates are bounded. Few pieces may exceed the largest energy so far. There the
# roots of the factors' Taylor polynomials are located interval by interval. That an interval holds
# none is proven by the values at its ends and a bound of the second derivative.


NEAR_PEAK = 1.0e-7  # error of the place of a peak in a piece; its height errs by the square
SHORTEST_PIECE = 1.0e-6  # shortest interval, relative; over it a factor near 0 changes no energy


class OfEnergies(NamedTuple):
    """A noter (`note_at`) of the largest energies."""

    ps: Any
    damper: Any
    energy: Any  # (2,) the largest so far [J]
    table: Any  # of the piece


class OfPush(NamedTuple):
    """A noter (`note_at`) of the greatest force in a step of a contact."""

    impacts: Any
    side: Any
    step: Any


@jit
def proves_no_root(f, g, bend):
    """Return True if a factor has no root between its values f and g; bend: h^2 max |f''|.

    f and g have one sign, and the factor either changes too little to reach zero in between or, by
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
    """Return True if an energy may peak above a record in a piece; arguments as of `roots`."""
    return (
        highest(e0, e1, p0, p1, fourth) > record
        and not only_rises(e0, e1, p0, p1, fourth)
        and not only_rises(-e0, -e1, -p0, -p1, fourth)
    )


@jit
def damper_bound(grid, scale, e2):
    """Return a bound of the fourth derivative of E2 by the place over a cell [J].

    scale: a bound of S over it; e2: E2 at its beginning. E2 is half the square of a vector u, whose
    length grows by the structure's action alone (`flight.damper_bounds`). So the bound rests on the
    damper's own energy, which may be far less than that of the structure.
    """
    rate, pull = grid.table[OF_E2 + 1], grid.table[OF_E2 + 2]
    push = grid.rate * grid.push
    s1 = grid.rate * scale + grid.push  # bounds of the first to third derivatives by time of the
    s2 = grid.rate * s1 + push  # scaled state, whose norm is S, as in `flight.bounds_of`
    s3 = grid.rate * s2 + grid.rate * push
    # the force on the damper in units of S, 0 unless the ground moves
    shaken = grid.push if grid.table[OF_E2 + 3] != 0.0 else 0.0
    u0 = math.sqrt(2.0 * e2) + (pull * scale + shaken) * grid.h
    u1 = rate * u0 + (pull * scale + shaken)
    u2 = rate * u1 + (pull * s1 + grid.rate * shaken)
    u3 = rate * u2 + (pull * s2 + grid.rate * (grid.rate * shaken))
    u4 = rate * u3 + (pull * s3 + grid.rate * (grid.rate * (grid.rate * shaken)))
    h2 = grid.h * grid.h
    return (u0 * u4 + 4.0 * u1 * u3 + 3.0 * u2 * u2) * h2 * h2


@jit
def may_set_a_record(damper, energy, grid, bounds, length, before, after):
    """Return True if an energy may exceed the largest so far inside a piece of a cell.

    length: of the piece in cells; bounds: `flight.Bounds` of the cell; before, after: `work_at` the
    ends of the piece.
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
    """Return the bodies whose energy may set a record inside a piece: 1 structure + 2 damper.

    It may if a cubic bound exceeds the record and the energy is not proven to be monotone.
    Arguments as of `may_set_a_record`, which is True.
    """
    h, square = grid.h * length, length * length
    shorter, breakers = square * square, 0
    p0, p1, fourth = h * before[2], h * after[2], bounds.energy * shorter
    if may_peak(energy[0], before[0], after[0], p0, p1, fourth):
        breakers = 1
    if damper is not None:
        p0, p1 = h * before[3], h * after[3]
        fourth = damper_bound(grid, bounds.scale, before[1]) * shorter
        if may_peak(energy[1], before[1], after[1], p0, p1, fourth):
            breakers += 2
    return breakers


@jit
def body_of(ps, damper, body):
    """Return the mass [kg] of a body and the stiffness [N/m] of its spring; (0, 0) of none."""
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
        return term_of(w, int(DV), n), piece.sign * term_of(w, int(DS), n)
    if n == ORDER:
        return 0.0, 0.0
    rise, i = (n + 1.0) / piece.h, COEF + 4 * n + 4
    return rise * w[i + 1], rise * w[i + 3]


@jit
def factor_polynomial(ps, damper, piece, which):
    """Fill the rows FACTOR with the Taylor coefficients of one factor over a piece.

    The factors are v1, m1 dv1/dt + k1 x1, v2 and m2 dv2/dt + k2 (x1 - r), for any forces. Returns a
    bound of the second derivative.
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
    """Return four terms of the polynomial in the rows FACTOR, from power k on, over x^k."""
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
    """Raise the maxima of a noter to their values at place x of the piece.

    noter: `OfEnergies`, `OfPush`, or a tally with a quantity in its rows FACTOR.
    """
    if is_a(noter, Tally):
        return raise_to(noter.row, int(noter.row[PLACE]), factor_at(noter.row, x))
    if is_a(noter, OfPush):
        # (row NEW stays as it is)
        k = noter.side.k
        set_aside(k)
        advance(noter.side, None, part_of(noter.step, x))
        note_force(noter.impacts, push_now(noter.side))
        restore(k)
        return
    return note_energy_at(noter, x)


@jit
def note_energy_at(noter, x):
    y = at(noter.table, x)
    note_energy(noter.ps, noter.damper, noter.energy, y[0], y[1], y[2], y[3])


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
    """Call `note_at` at all roots in [0, end] of the polynomial in the rows FACTOR.

    bend: a bound of its second derivative.
    """
    x, width = 0.0, end
    f, g = w[FACTOR], factor_at(w, end)
    while x < end:
        sag = bend * width * width
        if not alike(f, g) and abs(g - f) > sag:  # monotone: one root
            note_at(noter, root(w, x, x + width, f, g))
        elif not proves_no_root(f, g, sag):
            if width > SHORTEST_PIECE * end and 0.0 < sag < math.inf:
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
def note_energies(ps, damper, energy, piece, end):
    """Raise the largest energies to those in [0, end] of a piece, both ends included."""
    noter, w = OfEnergies(ps, damper, energy, piece.table), piece.table
    note_energy_at(noter, 0.0)
    note_energy_at(noter, end)
    # The bodies whose energy may set a record inside: a coordinate or velocity exceeds its larger
    # end value by at most end^2 / 8 max |second derivative|.
    x, v, p, u, sag = 0.0, 0.0, 0.0, 0.0, 0.125 * end * end
    for n in range(2, ORDER + 1):
        i, part = COEF + 4 * n, n * (n - 1.0) * sag
        x, v = x + part * abs(w[i]), v + part * abs(w[i + 1])
        p, u = p + part * abs(w[i] - w[i + 2]), u + part * abs(w[i + 1] - w[i + 3])
    y, z = at(w, 0.0), at(w, end)
    x, v = x + max(abs(y[0]), abs(z[0])), v + max(abs(y[1]), abs(z[1]))
    p += max(abs(y[0] - y[2]), abs(z[0] - z[2]))
    u += max(abs(y[1] - y[3]), abs(z[1] - z[3]))
    breakers = 0
    mass, spring = body_of(ps, damper, 0)
    if 0.5 * (mass * v * v + spring * x * x) > energy[0]:
        breakers = 1
    mass, spring = body_of(ps, damper, 1)
    if 0.5 * (mass * u * u + spring * p * p) > energy[1]:
        breakers += 2
    note_peaks(ps, damper, energy, piece, end, breakers)


# ---- the response: a piece -----------------------------------------------------------------------


@jit
def fill_rate(row, w):
    """Fill FACTOR of the table `w` with the derivative of the polynomial in FACTOR of `row`.

    Returns a bound of its second derivative.
    """
    bend = 0.0
    for k in range(ORDER):
        f = (k + 1.0) * row[FACTOR + k + 1]
        w[FACTOR + k] = f
        bend += k * (k - 1.0) * abs(f)
    w[FACTOR + ORDER] = 0.0
    return bend


@jit
def drive_in(piece, phase, n):
    """Return coefficient n of the force over a piece; phase: the instant of its beginning."""
    if is_a(piece, StepPiece):
        return term_of(piece.table, int(COSINE), n)
    return force_term(piece.table, phase, n)


@jit
def pace_at(piece, x):
    """Return the derivative of the time by the place in a piece [s]."""
    if is_a(piece, StepPiece):
        k = piece.table
        return k[UNIT] * k[LENGTHS + 1] * column_at(k, int(WEIGHT), x)
    return piece.h


@jit
def raise_within(tally, w, place, end):
    """Raise a maximum to that in [0, end] of the quantity in the tally's rows FACTOR.

    place: of the maximum in the tally's row; w: the table of the piece.
    """
    row = tally.row
    f, g = row[FACTOR], factor_at(row, end)
    raise_to(row, place, f)
    raise_to(row, place, g)
    if max(abs(f), abs(g)) + 0.125 * bend_in(row) * end * end > row[place]:
        row[PLACE] = place
        note_roots(tally, w, fill_rate(row, w), end)


@jit
def raise_displaced(tally, piece, phase, end):
    """Raise the largest absolute displacement where that of the ground is known."""
    if tally.moved is None:
        return None
    row, w = tally.row, piece.table
    for n in range(ORDER + 1):
        row[FACTOR + n] = w[COEF + 4 * n] + tally.moved * drive_in(piece, phase, n)
    raise_within(tally, w, place_of_largest(int(OF_DISPLACED), 1.0), end)


@jit
def tally_piece(tally, piece, phase, end):
    """Add [0, end] of a piece to a tally; phase: the instant of its beginning.

    piece: a grid with an expanded cell, or a `StepPiece`, with bare tables.
    """
    row, w = tally.row, piece.table
    for n in range(ORDER + 1):
        a1, _ = accelerations_in(piece, n)
        row[FACTOR + n] = absolute(tally.ground, a1, drive_in(piece, phase, n))
    raise_within(tally, w, place_of_largest(int(OF_A), 1.0), end)
    for n in range(ORDER + 1):
        w[FACTOR + n] = drive_in(piece, phase, n)
    for i in range(6):
        x = end * POINTS[i]
        a1, drive, dt = factor_at(row, x), factor_at(w, x), WEIGHTS[i] * (end * pace_at(piece, x))
        now = at(w, x)
        add_state(row, dt, now, a1, drive)
        add_displaced(tally, dt, now[0], drive)
    # The maxima of x1, v1 and r, from the states y and z at the ends.
    y = at(w, 0.0)
    z = at(w, end)
    none = four(0.0)
    bends = none
    for k in range(2, ORDER + 1):
        bends = bends + (k * (k - 1.0)) * larger_of(none, four_at(w, COEF + 4 * k))
    for component in range(3):
        place = place_of_largest(OF_R if component == 2 else component, 1.0)
        bend = number_of(bends, 0)
        if component > 0:
            bend = number_of(bends, 1) if component == 1 else number_of(bends, 2)
        raise_to(row, place, y[component])
        raise_to(row, place, z[component])
        top = max(abs(y[component]), abs(z[component])) + 0.125 * bend * end * end
        if top > row[place]:
            for k in range(ORDER + 1):
                row[FACTOR + k] = w[COEF + 4 * k + component]
            raise_within(tally, w, place, end)
    raise_displaced(tally, piece, phase, end)


@jit
def tally_push(wall, tally, piece):
    """Add the contact force over a step, and the work of its inelastic part."""
    row, k = tally.row, piece.table
    for n in range(ORDER + 1):
        row[FACTOR + n] = term_of(k, int(FORCE), n)
    raise_within(tally, k, place_of_largest(int(OF_FORCE), piece.sign), 1.0)
    if wall.damping is not None:
        for i in range(6):
            x = POINTS[i]
            loses = column_at(k, int(FORCE), x) - wall.K * column_at(k, int(ELASTIC), x)
            row[LOSS] += WEIGHTS[i] * pace_at(piece, x) * loses * column_at(k, int(AT_S), x)


@jit
def watch_piece(ps, damper, watch, piece, phase, begin, end):
    """Record [0, end] of a piece: energies, a limit, a response.

    phase: the instant of its beginning; begin: as of `touch.note_limit`.
    """
    if watch.energy is not None:
        note_energies(ps, damper, watch.energy, piece, end)
    if watch.limit_log is not None:
        note_limit(piece, watch.limit_log, begin, end, math.inf, math.inf)
    if watch.tally is not None:
        tally_piece(watch.tally, piece, phase, end)


# ---- the beginning and the end of a response -----------------------------------------------------


@jit
def bare_tally(tally):
    if tally is None:
        return None
    return Tally(bare(tally.row), tally.ground, tally.moved)


@jit
def begin_tally(response, ground, known, ps, state):
    """Return the `Tally` of a response from a state on, None if there is no response.

    ground: True if it moves, known: True if its displacement is that of a harmonic motion; or None.
    """
    if response is None:
        return None
    row = np.zeros(SIZE)
    raise_to(row, int(MOST), state[0])
    raise_to(row, int(MOST) + OF_V, state[1])
    raise_to(row, int(MOST) + OF_R, state[2])
    # A moving ground acts as a force per mass of minus its acceleration, which is omega^2 times its
    # displacement.
    moved = None if known is None else ps.force / (ps.omega * ps.omega)
    return Tally(row, (None if ground is None else ps.force), moved)


@jit
def report(response, tally, ps, damper, time):
    """Fill a response (`codes`) from a tally; time: its duration [s]."""
    if response is None:
        return None
    row = tally.row
    for i in range(5):
        response[2 * i] = row[MOST + i]
    for i, place in ((0, X2), (1, V2), (2, A2), (3, R2), (4, Y2)):
        response[2 * i + 1] = math.sqrt(row[place] / time)
    for wall in range(2):
        response[OF_FORCES + wall] = row[MOST_FORCE + wall]
        response[OF_IMPULSES + wall] = row[IMPULSE + wall]
    c1 = ps.m1 * ps.damping
    response[POWERS] = c1 * row[V2] / time
    response[POWERS + 1] = dashpot_of(joined(damper)) * row[S2] / time
    response[POWERS + 2] = row[LOSS] / time
    response[POWERS + 3] = (brought_in(ps, damper, row) + row[JUMPS]) / time


@jit
def brought_in(ps, damper, row):
    if ps.shaken is None:
        return ps.m1 * ps.force * row[CV]
    return (ps.m1 * row[CV] + damper.m2 * (row[CV] - row[CS])) * ps.force


@jit
def note_sums(ps, damper, sums, row, tally):
    """Fill a row of `sums` with five integrals of a tally.

    The work of force and jumps, the energies dissipated by c1, by c2 and by contacts [J], and the
    integral of x1^2 [m^2 s].
    """
    if sums is None:
        return None
    done = tally.row
    sums[row, 0] = brought_in(ps, damper, done) + done[JUMPS]
    sums[row, 1] = ps.m1 * ps.damping * done[V2]
    sums[row, 2] = dashpot_of(joined(damper)) * done[S2]
    sums[row, 3] = done[LOSS]
    sums[row, 4] = done[X2]


@jit
def dashpot_of(damper):
    """Return c2 [N s/m], 0 without a damper."""
    if damper is None:
        return 0.0
    return damper.c2


# ---- A linear motion on a wall, followed piece by piece to its end -------------------------------
#
# A pressed linear wall, a linear wall that is left without a force, a damper that sticks: each
# motion is exact like a flight, on a grid of its own, and ends where a polynomial over each piece
# rises to a level. That place is certified like a touch.


@by_wall(needed=True)
def ending(motion, side, w, phase, end):
    """Return (event, place) of the first end of a motion in [0, end] of a piece.

    The place may be NOWHERE or LOST. w: the table with the polynomial of the piece; phase: the
    instant of its beginning.
    """


@by_wall
def note_piece(motion, side, watch, grid, phase, begin, end):
    """Record [0, end] of a piece (arguments of `watch_piece`)."""
    watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)


@jit
def walk(motion, side, watch, phase, place, left, y):
    """Follow a motion from the state y = (x1, v1, r, s) to its end, or for a time `left` [s].

    motion: a tuple of the wall's law with a `grid` of bare rows; phase and place: the instant of y,
    and the share of the period that is over. Returns (event, y, time [s]) with the event of
    `ending`, STOPPED or EXHAUSTED.
    """
    grid, w, took = motion.grid, motion.grid.table, 0.0
    while True:
        # the next piece, to the end of a cell or of the time
        end = min(1.0, (left - took) / grid.h)
        if is_a(phase, Moment):
            then = moved(phase, phase.x + took / phase.length)
        else:
            turn = turned(grid.begun, place) + took / (2.0 * math.pi / side.ps.omega)
            then = cos_sin_of_turn(turn)
        polynomial_from(grid, y, then)
        event, where = ending(motion, side, w, then, end)
        if where == LOST:
            return EXHAUSTED, y, took
        piece = min(where, end)
        z = at(w, piece)
        note_piece(motion, side, watch, grid, then, took / grid.h, piece)
        y, took = z, min(took + piece * grid.h, left)
        if where <= end and took < left:
            return event, y, took
        if end < 1.0 or took >= left:
            return STOPPED, y, left


@jit
def first_rise(rows, end, level):
    """Return the first place up to `end` where r in some rows rises to a level (`first_touch`)."""
    bend, jerk = tightened(rows, math.inf, math.inf)
    return first_touch(rows, 0.0, end, 1.0, level, bend, jerk)


@jit
def local_grid(ps, damper, begun):
    """Return a grid for motions over single cells, without the phases of a period."""
    rate = rate_of(ps, joined(damper))
    if is_a(begun, Stretch):
        h = SHORT / max(rate, SHORT / begun.h)
        return grid_under(ps, damper, h, 1, begun)
    return grid_with(ps, damper, SHORT / rate, 1, 0, begun)
