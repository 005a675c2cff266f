"""Variations of a host's orbit: in flight, in stepped contacts, and where the motion jumps.

A variation (dX, dV) is the derivative of a state at a fixed time. In flight it moves as the host
does without a force. In a step of a contact

    d(dX)/dtheta = w dV      d(dV)/dtheta = w (linear part - sum of answers (F_z dr + F_s ds))

with the orbit's dt = w dtheta, so that the derivatives F_z and F_s of a wall's force have series in
theta, and each variation follows by one linear recursion. Where the field or the state jumps, a
variation meets the wall later by t0 = -dz / s: the motion before carries it there, the impact acts,
and the motion after carries it back (a saltation matrix). This is so at rigid walls, and where a
wall with a dashpot is touched, or a joint that may pull is released, whose force jumps by cc s.

Rigid walls that hold keep dr = ds = 0.

If several rigid walls are struck at one instant, a variation meets each at a time of its own, in
an order of its own. If they do not interact, their impacts follow one another in any order: each
has its own saltation matrix, and these commute. Walls that limit the same motion are struck at one
time by all variations. Otherwise there is no derivative (`depends_on_order`), and the variations,
the logarithm of their volume and all that follows from them are NaN.

Volumes of variations shrink by exp(t tr A), in contacts besides by the derivatives F_s of the
forces, and at rigid impacts. The logarithm of what contacts add is summed apart from the
variations: they must obey it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.elementary import log
from ..numerics.fours import from_place
from ..scene.law import COLUMNS, DRAG, HIGHEST, SERIES, STIFF, VARIED, product
from .body import accelerate, along, integrate, move, push_link, put_at_theta
from .host_flight import advance
from .springs import push_variation, steepen_springs
from .walls import (
    APART,
    INDEPENDENT,
    IS_PULLING,
    IS_RIGID,
    IS_SPRING,
    LEFT,
    PARALLEL,
    PLACES,
    STRUCK,
    apply_impulses,
    at_theta,
    cosine,
    hold,
    interpolate,
    is_at,
    push_all,
    q_and_s,
    scratch_of,
    slopes_of_rough,
    steepen,
)

UNCHANGED = 1.0e-11  # round-off of an acceleration towards a wall, relative to its parts
# columns of dr and ds of the variation under way, and of w F_z of a rough wall
VARIED_S, WEIGHED = VARIED + 1, VARIED + 2


class Varied(NamedTuple):
    """Variations and scratch for them; each array is one row, in inner kernels a bare row."""

    rows: Any  # (number * N,) one variation after the other
    number: int
    series: Any  # (HIGHEST + 1) powers of 3 size numbers: dX, dV and the accelerations; one more
    free: Any  # (drives,) zeros: a variation has no force
    before: Any  # (2 size,) V and V' of the orbit before an impact
    late: Any  # (number,) t0 of the variations [s]
    clearance: Any  # (2,) smallest near miss so far [m], and its wall
    shrunk: Any  # (1,) logarithm of the factor by which contacts have changed volumes so far


@jit
def varied_of(body, tangent, clearance, shrunk):
    N = 2 * body.size
    number = len(tangent) // N
    series, free = np.zeros(3 * body.size * (HIGHEST + 1) + 1), np.zeros(body.drives)
    return Varied(tangent, number, series, free, np.zeros(N), np.zeros(number), clearance, shrunk)


# ---- flight --------------------------------------------------------------------------------------


@jit
def vary_shortly(body, rate, varied, time, work):
    for c in range(varied.number):
        move(body, rate, varied.free, time, from_place(varied.rows, 2 * body.size * c), work)


@jit
def vary_flight(body, grid, scratch, varied, begun, ended):
    """Carry variations along a flight from one (cell, place) to another, by the coarsest cells."""
    (j, x), (last, end), N = begun, ended, 2 * body.size
    if x > 0.0:
        share = (end if j == last else 1.0) - x
        vary_shortly(body, grid.rate, varied, share * grid.h, scratch.work)
        if j == last:
            return
        j += 1
    columns = scratch.columns
    for k in range(body.drives):
        columns[N + k] = 0.0
    while j < last:
        level, cells = 0, 1 << grid.levels
        while j & (cells - 1) != 0 or j + cells > last:
            level, cells = level + 1, cells >> 1
        for c in range(varied.number):
            row = from_place(varied.rows, N * c)
            for i in range(N):
                columns[i] = row[i]
            advance(body, grid, level, columns, scratch.end)
            for i in range(N):
                row[i] = scratch.end[i]
        j += cells
    if end > 0.0:
        vary_shortly(body, grid.rate, varied, end * grid.h, scratch.work)


# ---- contacts ------------------------------------------------------------------------------------


@jit
def vary_step(body, walls, contacts, varied, weights, x):
    """Carry variations through a step to theta = x units.

    weights: (place of the coefficient 0 of w in the series of contacts, distance of the next one).
    """
    active, S, size = contacts.active, varied.series, body.size
    width, (total, far) = 3 * size, weights
    is_rough = False
    if body.springs is not None:
        for n in range(HIGHEST):
            steepen_springs(body, n)
    for c in range(active[0]):
        wall = active[1 + c]
        k = scratch_of(contacts, wall)
        for n in range(HIGHEST):
            steepen(walls, wall, k, n)
        if walls.law[wall] != IS_RIGID and contacts.rough[wall] != 0.0:
            is_rough = True
            smooth_slopes(walls, contacts, wall, weights, x)
        if walls.law[wall] != IS_RIGID and contacts.pushes[wall] != 0.0:
            drag = integral_of_drag(contacts, wall, weights, x)
            varied.shrunk[0] -= walls.inverse[wall] * drag
    for column in range(varied.number):
        y = from_place(varied.rows, 2 * size * column)
        for i in range(2 * size):
            S[i] = y[i]
        for n in range(HIGHEST):
            row, at = width * n, SERIES + COLUMNS * n
            accelerate(body, S, row, 0.0, S, row + 2 * size)
            if body.springs is not None:
                push_variation(body, S, row, n)
            for c in range(active[0]):
                wall = active[1 + c]
                if walls.law[wall] == IS_RIGID:
                    continue
                k, link = scratch_of(contacts, wall), walls.links[wall]
                k[at + VARIED], k[at + VARIED_S] = along(body, link, S, row)
                force = product(k, int(DRAG), int(VARIED_S), n)
                if contacts.rough[wall] == 0.0:
                    force += product(k, int(STIFF), int(VARIED), n)
                push_link(body, link, force * contacts.pushes[wall], S, row + 2 * size)
            hold(body, walls, contacts, row + 2 * size, S)
            after, per = row + width, contacts.unit[0] / (n + 1.0)
            integrate(S, (width, size, 0, 2 * size), (contacts.series, total, far), n, per)
            if is_rough:
                push_roughly(body, walls, contacts, per, n, after + size, S)
        put_at_theta(S, (width, size), int(HIGHEST), x, y)


@jit
def integral_of_drag(contacts, wall, weights, x):
    """Return the integral [kg] of F_s over the time of a step to theta = x units."""
    k, w, (total, far) = scratch_of(contacts, wall), contacts.series, weights
    integral, power = 0.0, contacts.unit[0]
    for n in range(HIGHEST):
        coefficient = 0.0
        for m in range(n + 1):
            coefficient += k[SERIES + COLUMNS * m + DRAG] * w[total + far * (n - m)]
        power *= x
        integral += coefficient * power / (n + 1.0)
    return integral


@jit
def smooth_slopes(walls, contacts, wall, weights, x):
    """Fill w F_z and F_s of a rough wall (`smooth_forces`) up to theta = x units.

    F_z = n K z^(n - 1) alone is too rough for a polynomial; w F_z is smooth as q^(n p - 1).
    """
    k, push, (total, far) = scratch_of(contacts, wall), contacts.pushes[wall], weights
    values, line = contacts.values, from_place(contacts.values, HIGHEST + 1)
    for column in range(2):
        for i in range(HIGHEST + 1):
            place = x * PLACES[i]
            q, s = q_and_s(k, place)
            slopes = slopes_of_rough(walls, wall, q, s)
            weight = at_theta(contacts.series, total, far, place) if column == 0 else 1.0
            values[i] = push * slopes[column] * weight
        interpolate(values, x, line)
        for n in range(HIGHEST + 1):
            k[SERIES + COLUMNS * n + (WEIGHED if column == 0 else DRAG)] = line[n]


@jit
def push_roughly(body, walls, contacts, per, n, at, out):
    """Add to coefficient n + 1 of dV, at out[at : at + size], what rough walls push by dr."""
    active = contacts.active
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] != IS_RIGID and contacts.rough[wall] != 0.0:
            k = scratch_of(contacts, wall)
            push_link(
                body, walls.links[wall], per * product(k, int(WEIGHED), int(VARIED), n), out, at
            )
    hold(body, walls, contacts, at, out)


# ---- jumps ---------------------------------------------------------------------------------------


@jit
def vary_jump(body, walls, contacts, varied, wall, direction):
    """Apply the jump cc s of a linear wall's force: `direction` 1 at touch, -1 at release."""
    if walls.law[wall] not in (IS_SPRING, IS_PULLING):
        return
    N, size, link = 2 * body.size, body.size, walls.links[wall]
    for c in range(varied.number):
        r, _ = along(body, link, varied.rows, N * c)
        force = direction * walls.constants[wall].cc * r
        push_link(body, link, force, varied.rows, N * c + size)
        hold(body, walls, contacts, N * c + size, varied.rows)


@jit
def remember(body, walls, contacts, varied, drive, y, work):
    """Keep the orbit's velocities and accelerations before an impact."""
    push_all(body, walls, contacts, drive, y, work)
    for i in range(body.size):
        varied.before[i], varied.before[body.size + i] = y[body.size + i], work[i]


@jit
def vary_at_impact(body, walls, contacts, varied, wall, y):
    """Carry variations to a rigid wall that is struck, and through the impact to the state y."""
    N, size, before, link = 2 * body.size, body.size, varied.before, walls.links[wall]
    s = 0.0
    for i in range(size):
        s += body.rows[link * size + i] * before[i]
    for c in range(varied.number):
        r, _ = along(body, link, varied.rows, N * c)
        late = -r / s if s != 0.0 else 0.0
        varied.late[c] = late
        for i in range(N):
            varied.rows[N * c + i] += late * before[i]
        apply_impulses(body, walls, contacts, N * c + size, varied.rows)
    varied.shrunk[0] += log(shrinking_of_impact(walls, contacts))
    if s != 0.0:
        _, after = along(body, link, y, 0)
        varied.shrunk[0] += log(abs(after / s))


@jit
def shrinking_of_impact(walls, contacts):
    """Return |det D| of the map D of velocities by `apply_impulses`.

    With the rates f and f' of the state before and after the impact, and r' = n f, the derivative
    of an impact is D + (f' - D f) n^T / (n f), whose determinant is det D s' / s. D brings k walls
    to rest and returns e times their impulses, so that det D is the product of their -e; walls
    that bodies would enter afterwards are brought to rest.
    """
    active, factor = contacts.active, 1.0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID and contacts.compressed[wall] != 0.0:
            factor *= contacts.rebounds[wall]
        if walls.law[wall] == IS_RIGID and contacts.expanded[wall] != 0.0:
            factor = 0.0
    return factor


@jit
def vary_after_impact(body, walls, contacts, varied, wall, drive, y, work):
    """Carry variations back along the motion after an impact, if it has a derivative."""
    N, size = 2 * body.size, body.size
    push_all(body, walls, contacts, drive, y, work)
    if depends_on_order(body, walls, contacts, varied.before, wall, y, work):
        varied.shrunk[0] = math.nan
        for i in range(N * varied.number):
            varied.rows[i] = math.nan
    for c in range(varied.number):
        late = varied.late[c]
        for i in range(size):
            varied.rows[N * c + i] -= late * y[size + i]
            varied.rows[N * c + size + i] -= late * work[i]
    vary_on_hold(body, walls, contacts, varied)


@jit
def depends_on_order(body, walls, contacts, before, wall, y, work):
    """Return True if the motion depends on the order in which bodies touch walls at an impact.

    Bodies near y touch the walls at times that differ by dt, in an order that depends on dy. The
    motions after two orders differ

    - by a finite amount if another wall that interacts with `wall` is struck, or receives an
      impulse though bodies leave it, unless both limit the same motion: the impulses of one change
      the approach speed of the other. The motion after the impact jumps in dy.
    - by a multiple of dt if the impact changes the force of a dashpot that is being touched, or by
      dashpots between the bodies the acceleration towards another wall that is struck: the motion
      is continuous in dy, with a kink.

    before, y, work: velocities and accelerations (2 size,) before the impact, the state and the
    accelerations after it.
    """
    size = body.size
    for other in range(walls.number):
        part, law = contacts.joins[other], walls.law[other]
        receives = contacts.compressed[other] != 0.0 or contacts.expanded[other] != 0.0
        if part == STRUCK or (part == LEFT and receives):
            if abs(cosine(body, walls, wall, other)) <= PARALLEL:
                return True
        elif part == APART and is_at(body, walls, other, y):
            link = walls.links[other]
            _, s = along(body, link, y, 0)
            is_struck = law == IS_RIGID and walls.signs[other] * s > 0.0
            if is_struck and differs(body, link, (work, 0), (before, size), UNCHANGED):
                return True
            has_dashpot = law in (IS_SPRING, IS_PULLING) and walls.constants[other].cc > 0.0
            if has_dashpot and differs(body, link, (y, size), (before, 0), INDEPENDENT):
                return True
    return False


@jit
def differs(body, link, one, two, round_off):
    """Return True if a link's r by two sets of numbers of X, each (array, place), differs.

    round_off: relative to the sum of the sizes of its parts.
    """
    (a, i), (b, j), row = one, two, link * body.size
    total = parts = 0.0
    for k in range(body.size):
        w = body.rows[row + k]
        total += w * (a[i + k] - b[j + k])
        parts += abs(w) * (abs(a[i + k]) + abs(b[j + k]))
    return abs(total) > round_off * parts


@jit
def vary_on_hold(body, walls, contacts, varied):
    """Project variations onto the motions that rigid walls in contact leave: momentum is kept."""
    active = contacts.active
    for c in range(active[0]):
        if walls.law[active[1 + c]] == IS_RIGID and contacts.pushes[active[1 + c]] != 0.0:
            varied.shrunk[0] -= math.inf
    for at in range(0, 2 * body.size * varied.number, body.size):
        hold(body, walls, contacts, at, varied.rows)
