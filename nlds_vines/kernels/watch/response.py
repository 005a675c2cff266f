"""The response over the sampled periods: what of it is largest, its rms, and mean powers.

It is summed up piece by piece while an orbit is followed, and nothing of that changes the orbit.
A piece, be it a cell of a flight or a step of a contact, is a Taylor polynomial: products of states
are integrated at Gauss points, so many that the error is below round-off in the longest cell
(1.4^12 / 6e15: products turn twice as fast). A quantity is largest where its rate, a polynomial
too, vanishes: such roots are looked for where bends allow the largest value so far to be exceeded,
and proven to be all of them (`peaks.note_roots`).

Power comes in by the force P cos(omega t), or, where the foot moves, by what moves it. It is
dissipated by the dashpots and by contacts: by the force that is not elastic, or as rigid bodies
lose it. The rest is a change of the energy stored.
"""

from __future__ import annotations

import math

import numpy as np

from ..motion.flight import COEF, DRIVE, FACTOR, ORDER, at
from ..motion.load_cells import force_term
from ..motion.response_sums import (
    A2,
    BEGIN,
    CV,
    CX,
    IMPULSE,
    JUMPS,
    LOSS,
    MOST,
    MOST_FORCE,
    OF_A,
    OF_FOOT,
    OF_FORCE,
    OF_R,
    OF_V,
    PLACE,
    POINTS,
    R2,
    S2,
    SIZE,
    U2,
    V2,
    WEIGHTS,
    X2,
    Y2,
    Tally,
    absolute,
    add_from_foot,
    add_state,
    foot_of,
    from_foot,
    ground_of,
    place_of_largest,
    raise_to,
)
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.fours import bare, four, four_at, larger_of, number_of
from ..scene.arguments import StepPiece
from ..scene.codes import OF_FORCES, OF_IMPULSES, POWERS
from ..scene.contact_series import (
    AT_S,
    COSINE,
    ELASTIC,
    FORCE,
    LENGTHS,
    SINE,
    UNIT,
    WEIGHT,
    column_at,
    term_of,
)
from ..scene.drive import drive_now
from ..scene.scene import joined
from .limit import note_limit
from .peaks import accelerations_in, bend_in, factor_at, note_energies, note_roots

# ---- a piece -------------------------------------------------------------------------------------


@jit
def fill_rate(row, w):
    """Fill FACTOR of the table `w` with the derivative, by the place, of what is in the `row`'s.

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
def fill_state(row, w, component):
    """Fill the rows FACTOR of a tally with a component of the state over the expanded cell."""
    for k in range(ORDER + 1):
        row[FACTOR + k] = w[COEF + 4 * k + component]


@jit
def drive_in(piece, phase, n):
    """Return coefficient n of the force over a piece; phase: the instant of its start."""
    if is_a(piece, StepPiece):
        return piece.sign * term_of(piece.table, int(COSINE), n)
    return force_term(piece.table, phase, n)


@jit
def pace_at(piece, x):
    """Return the derivative of the time by the place in a piece [s]."""
    if is_a(piece, StepPiece):
        k = piece.table
        return k[UNIT] * k[LENGTHS + 1] * column_at(k, int(WEIGHT), x)
    return piece.h


@jit
def fill_acceleration(tally, piece, phase):
    """Fill the rows FACTOR of a tally with the structure's absolute acceleration."""
    for n in range(ORDER + 1):
        a1, _ = accelerations_in(piece, n)
        tally.row[FACTOR + n] = absolute(tally.ground, a1, drive_in(piece, phase, n))


@jit
def motion_of_foot(foot, piece, phase, n):
    """Return coefficient n of the motion of the foot over a piece."""
    if is_a(piece, StepPiece):
        k = piece.table
        cosine, sine = term_of(k, int(COSINE), n), term_of(k, int(SINE), n)
        return piece.sign * (foot.cosine * cosine + foot.sine * sine)
    turned = foot.cosine * phase[0] + foot.sine * phase[1]
    if n % 2 == 1:
        turned = foot.cosine * phase[1] - foot.sine * phase[0]
    return piece.table[DRIVE + n] * turned


@jit
def raise_within(tally, w, place, end):
    """Raise a maximum to that in [0, end] of the quantity in the tally's rows FACTOR.

    w: the table of the piece.
    """
    row = tally.row
    f, g = row[FACTOR], factor_at(row, end)
    raise_to(row, place, f)
    raise_to(row, place, g)
    if max(abs(f), abs(g)) + 0.125 * bend_in(row) * end * end > row[place]:
        row[PLACE] = place
        note_roots(tally, w, fill_rate(row, w), end)


@jit
def raise_state(tally, w, y, z, end):
    """Raise the maxima of x1, v1 and r to those in [0, end] of the expanded cell.

    y, z: (x1, v1, r, s) at its ends.
    """
    row, none = tally.row, four(0.0)
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
            fill_state(row, w, component)
            raise_within(tally, w, place, end)


@jit
def tally_foot(foot, tally, piece, phase, end):
    """Add what concerns the motion from the foot, if it moves."""
    if foot is None:
        return None
    row, w = tally.row, piece.table
    for n in range(ORDER + 1):
        row[FACTOR + n] = w[COEF + 4 * n] - motion_of_foot(foot, piece, phase, n)
    fill_rate(row, w)
    for i in range(6):
        x = end * POINTS[i]
        pace = pace_at(piece, x)
        add_from_foot(row, WEIGHTS[i] * (end * pace), factor_at(row, x), factor_at(w, x) / pace)
    raise_within(tally, w, place_of_largest(int(OF_FOOT), 1.0), end)


@jit
def tally_piece(tally, piece, phase, end):
    """Add [0, end] of a piece: a grid with an expanded cell, or a step of a contact.

    Its tables are bare; phase: the instant of its start.
    """
    row, w = tally.row, piece.table
    fill_acceleration(tally, piece, phase)
    raise_within(tally, w, place_of_largest(int(OF_A), 1.0), end)
    for n in range(ORDER + 1):
        w[FACTOR + n] = drive_in(piece, phase, n)
    for i in range(6):
        x = end * POINTS[i]
        a1, drive, dt = factor_at(row, x), factor_at(w, x), WEIGHTS[i] * (end * pace_at(piece, x))
        add_state(row, dt, at(w, x), a1, drive, phase)
    raise_state(tally, w, at(w, 0.0), at(w, end), end)
    tally_foot(tally.foot, tally, piece, phase, end)


@jit
def tally_push(wall, tally, piece):
    """Add what only a contact has over its step: the force, and what of it is not elastic."""
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
def tally_rest(tally, y, a1, phase, dt):
    """Add a short time dt [s] in which a state (x1, v1, r, s) rests; a1: dv1/dt."""
    drive = drive_now(phase)
    add_state(tally.row, dt, y, absolute(tally.ground, a1, drive), drive, phase)
    gone, rate = from_foot(tally.foot, y[0], y[1], phase)
    add_from_foot(tally.row, dt, gone, rate)


@jit
def watch_piece(ps, damper, watch, piece, phase, begin, end):
    """Note all that is watched of [0, end] of a piece: energies, a limit, a response.

    phase: the instant of its start; begin: as of `limit.time_at`.
    """
    if watch.energy is not None:
        note_energies(ps, damper, watch.energy, piece, end)
    if watch.limit_log is not None:
        note_limit(piece, watch.limit_log, begin, end, math.inf, math.inf)
    if watch.tally is not None:
        tally_piece(watch.tally, piece, phase, end)


# ---- begun and ended -----------------------------------------------------------------------------


@jit
def tally_for(response, foot, ground, ps):
    """Return a fresh `Tally` if a response is wanted; foot, ground: as in `CellBuffers`."""
    if response is None:
        return None
    return Tally(np.zeros(SIZE), foot_of(foot, ps), ground_of(ground, ps))


@jit
def bare_tally(tally):
    """Return the tally, if there is one, with its row as a bare one."""
    if tally is None:
        return None
    return Tally(bare(tally.row), tally.foot, tally.ground)


@jit
def begin_tally(tally, state):
    """Note the state at which a tally begins."""
    if tally is None:
        return None
    tally.row[BEGIN] = state[0]
    raise_to(tally.row, int(MOST), state[0])
    raise_to(tally.row, int(MOST) + OF_V, state[1])
    raise_to(tally.row, int(MOST) + OF_R, state[2])


@jit
def report(response, tally, ps, damper, state, time):
    """Fill a response (see `codes`) from the tally of a `time` [s] that ends with a state."""
    if response is None:
        return None
    return fill_response(response, tally, ps, damper, state, time)


@jit
def fill_response(response, tally, ps, damper, state, time):
    """Fill in largest values, their rms, forces, impulses and mean powers."""
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
    shaken(tally.foot, response, row, ps, state, time)


@jit
def brought_in(ps, damper, row):
    """Return the work of the force [J]."""
    if ps.shaken is None:
        return ps.m1 * ps.force * row[CV]
    return (ps.m1 * row[CV] + damper.m2 * (row[CV] - row[CX])) * ps.force


@jit
def note_sums(ps, damper, sums, row, tally):
    """Note in a row of `sums`, if they are wanted, the energies [J] that have come in and gone.

    What force and jumps have brought in; what c1, c2 and contacts have dissipated; and the integral
    of x1^2 [m^2 s].
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


@jit
def shaken(foot, response, row, ps, state, time):
    """Mend the powers of a structure whose foot moves: c1 is between both, and the foot does work.

    (k1 (y - x1) + c1 (dy/dt - v1)) dy/dt; the means of y dy/dt, sin v1 and sin x1 over whole
    periods are 0, -omega times that of cos x1, and that of cos v1 less the change of x1, by omega.
    """
    if foot is None:
        return None
    a, b, omega = foot.cosine, foot.sine, foot.omega
    c1, k1 = ps.m1 * ps.damping, ps.m1 * ps.stiffness
    with_x = omega * (b * row[CX] - a * ((row[CV] - (state[0] - row[BEGIN])) / omega)) / time
    with_v = omega * (b * row[CV] + a * omega * row[CX]) / time
    own = 0.5 * omega * omega * (a * a + b * b)
    response[POWERS] = c1 * row[U2] / time
    response[POWERS + 3] = c1 * (own - with_v) - k1 * with_x
