"""A short impact of a host, solved at once by `impact` from scalars of the gap.

While one wall pushes with Hertz' force f and no other one is touched, the state and the depth are

    y(t) = free motion - sum over k of J_k(t) A^k b      J_0' = f      J_k' = J_(k - 1)
    z''  = a_free(t) - g_0 f - sum over k >= 1 of g_k J_(k - 1)(t)

with the rates b of a unit impulse of the wall and g_k = c A^(k + 1) b, z = c y. With D for the
derivative this is z'' = a_free - G f, G = sum of g_k D^-k. Multiplied by g_0 / G = 1 - sum of
w_k D^-k, it holds the force once:

    z'' = a - g_0 f      a = P(t) + w_1 s + w_2 z + w_3 Z_1 + w_4 Z_2 + ...      Z_k = D^-k z

with the polynomial P = (1 - sum of w_k D^-k) a_free - s_0 sum of w_k t^(k - 1) / (k - 1)! and the
approach speed s_0. So the collocation of `impact` applies. The memory w_3 Z_1 + w_4 Z_2 + ... is
the integral of z(t') m(t - t') with the polynomial m(t) = sum of w_(k + 3) t^k / k!. Only the
derivatives of the free motion at the touch, and the state at the release, take all N numbers.

The series end with the power K of time. Over a time T the rest of the free motion is at most

    T^K / K! |y^(K)| x / (K + 1) / (1 - x / (K + 2))^2      x = T times a bound of |A|

in the norm of pairs (`grid`), and that of the contact's share likewise, with A^K b. K is the first
power for which both are below the error that sweeps may leave, relative to the change by the
impact. High modes count by their share of the motion, whatever their frequencies.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..impact.arc import ARC, FINEST_ERROR, LEVEL, NODES
from ..impact.impact import LENGTH, Approach, greatest_depth, nodes_of, settle, solve_arc
from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST, exp, fifth_root, log
from ..numerics.fours import (
    four,
    four_at,
    from_place,
    larger_of,
    largest_of,
    put_four,
    sum_of,
)
from ..numerics.matrices import solve
from .body import accelerate, along, differentiate
from .walls import IS_HERTZ

LEAST_POWERS, MOST_POWERS = 3, 24  # K; an impact that takes more of them is stepped
LONGER = 1.1  # bound of the duration of a short impact over that of its free arc
LARGEST_OF_HOST = 0.5  # greatest sum of the relative forces beside the contact's
BESIDE = 1.0e-3  # share of an impact's change of state that is more than the error of any r
VARIED_TO = 1.0e-13  # relative rest of the series of a variation
ERROR_OF_R = 4.0e-15  # of r, relative to the sum of its parts
# parts of `numbers`, each with room for all powers: of P and m, divided by k!; J_k; of a_free
OF_FREE, OF_MEMORY, OF_MOMENTS, OF_GAP = range(4)
ROOM = MOST_POWERS + 2


class ShortImpacts(NamedTuple):
    """What short impacts need of a host; arrays are rows, in inner kernels bare ones."""

    arc: Any  # `impact.Arc`
    answers: Any  # (walls * (ROOM + 1) * size,) derivatives of X from a unit impulse on
    norms: Any  # (walls * ROOM,) of A^k b
    inverse: Any  # (walls * ROOM,) 1, -w_1, -w_2 ...
    jet: Any  # ((ROOM + 1) * size,) derivatives of X in free motion from a touch on
    drive: Any  # (drives,)
    numbers: Any  # 4 ROOM, see OF_FREE
    push: float  # norm of the rates that a force f = 1 gives in unit time


class HostSide(NamedTuple):
    """A wall in a short impact, in place of a `scene.Side`."""

    arc: Any
    kappa: float  # K / mu
    speed: float  # sqrt(4 kappa / 5)
    by_speed: float  # w_1
    by_depth: float  # w_2
    powers: int  # of P
    memory: int  # powers of m
    shrinks: float  # sum of the sizes of all parts of a, in units of kappa b^6
    numbers: Any


@jit
def pair_norm(body, grid, jet, at):
    """Return the largest norm of a pair of the state that begins at jet[at]."""
    n, size, largest = body.modes, body.size, 0.0
    for i in range(size):
        x, v = jet[at + i], jet[at + size + i]
        if i >= n:
            x, v = along(body, i - n, jet, at)
        x *= grid.scales[i]
        largest = max(largest, x * x + v * v)
    return math.sqrt(largest)


@jit
def short_impacts(body, grid, walls, arc):
    """Return the `ShortImpacts` of a host."""
    size, count = body.size, walls.number
    answers, norms = np.zeros(count * (ROOM + 1) * size), np.zeros(count * ROOM)
    inverse, jet = np.zeros(count * ROOM), np.zeros((ROOM + 1) * size)
    for i in range(size):
        jet[size + i] = body.push[i]
    short = ShortImpacts(
        arc, answers, norms, inverse, jet, np.zeros(body.drives), np.zeros(4 * ROOM),
        pair_norm(body, grid, jet, 0),
    )  # fmt: skip
    for wall in range(count):
        if walls.law[wall] != IS_HERTZ:
            continue
        first, row, g = wall * (ROOM + 1) * size, wall * ROOM, np.zeros(ROOM)
        sign, link = walls.signs[wall], walls.links[wall]
        for i in range(size):
            answers[first + size + i] = sign * body.answers[link * size + i]
        for k in range(ROOM):
            at = first + k * size
            if k < ROOM - 1:
                accelerate(body, answers, at, 0.0, answers, at + 2 * size)
            norms[row + k] = pair_norm(body, grid, answers, at)
            g[k] = sign * along(body, link, answers, at)[1]
            total = 1.0 if k == 0 else 0.0
            for i in range(k):
                total -= g[k - i] / g[0] * inverse[row + i]
            inverse[row + k] = total
    return short


# ---- an impact at touch --------------------------------------------------------------------------


@jit
def expand_free(body, grid, short, wall, longest, change, y):
    """Fill the derivatives of X in free motion; return K, or 0 if MOST_POWERS are too few.

    The drive at touch is that of `short`. longest [s]: T; change: a bound of |b| J_0.
    """
    size, jet, drive, norms = body.size, short.jet, short.drive, short.norms
    x, power, enough = grid.rate * longest, 1.0, short.arc.settled
    for i in range(2 * size):
        jet[i] = y[i]
    for k in range(MOST_POWERS + 1):
        at = k * size
        accelerate(body, jet, at, drive[0], jet, at + 2 * size)
        if k >= max(body.drives, LEAST_POWERS) and x < 0.9 * (k + 2.0):
            left = 1.0 - x / (k + 2.0)
            left = power * x / ((k + 1.0) * left * left)
            if left * norms[wall * ROOM + k] <= enough * norms[wall * ROOM]:
                forced = 0.0
                for i in range(body.drives):
                    forced += abs(drive[i])
                forced *= short.push / grid.rate
                if left * (pair_norm(body, grid, jet, at) + forced) <= enough * change:
                    return k
        differentiate(body, drive, 0)
        power *= longest / (k + 1.0)
    return 0


@jit
def approach_at(body, short, wall, touch, powers):
    """Return (`Approach`, powers of m, `shrinks`) of a touch, and fill the numbers of P and m.

    touch: (b, s, tick, kappa b^6, sign, link).
    """
    (b, s, tick, peak, sign, link), row, size = touch, wall * ROOM, body.size
    inverse, numbers, lasting = short.inverse, short.numbers, tick * LENGTH
    factorial, time, rest, memory, z0 = 1.0, 1.0, 0.0, 0, (b * b) * (b * b)
    for k in range(powers):
        numbers[ROOM * OF_GAP + k] = sign * along(body, link, short.jet, (k + 1) * size)[1]
        total = inverse[row + k + 1] * s
        for i in range(k + 1):
            total += inverse[row + i] * numbers[ROOM * OF_GAP + k - i]
        numbers[k] = total / factorial
        if k > 2:
            rest += abs(numbers[k]) * time
        part = inverse[row + k + 3] / factorial if k + 3 <= powers else 0.0
        numbers[ROOM * OF_MEMORY + k] = -part
        part = abs(part) * z0 * time * lasting / (k + 1.0)
        rest += part
        if part > short.arc.settled * peak:
            memory = k + 1 + (k + 1) % 2  # an even number, for `remember_depths`
        factorial *= k + 1.0
        time *= lasting
    per = 1.0 / peak
    force, drag = numbers[0] * per, inverse[row + 1] * s * per
    drift, spring = numbers[1] * tick * per, -inverse[row + 2] * z0 * per
    curvature = numbers[2] * tick * tick * per
    size_of_five = abs(force) + abs(drag) + 2.0 * abs(drift) + abs(spring) + 4.0 * abs(curvature)
    rest *= per
    # The errors of n nodes are at most C_n e^(3/2) for the five numbers, C_n times `rest`, which
    # the series omits, and C_n / 12 for J_2, whose share of the release is T^2 |A^2 b| / (8 |b|).
    of_moments = lasting * lasting * short.norms[row + 2] / (96.0 * short.norms[row])
    missed = max(size_of_five * math.sqrt(size_of_five) + rest + of_moments, TINIEST)
    approach = Approach(
        b, s, tick, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, force, drag, drift, spring, curvature,
        exp(2.0 / 3.0 * log(missed)),
    )  # fmt: skip
    return approach, memory, size_of_five + rest


@jit
def nears(body, walls, short, wall, span):
    """Return the least distance [m] that other walls are proven to keep during the impact.

    span: (T, K, impulse of the wall, |b| times it). Walls of the same link are not touched.
    """
    (longest, powers, impulse, change), size, least = span, body.size, math.inf
    first = wall * (ROOM + 1) * size
    for other in range(walls.number):
        link = walls.links[other]
        if link == walls.links[wall]:
            continue
        reach, time = BESIDE * longest * change, 1.0
        for k in range(1, powers + 1):
            time *= longest / k
            reach += time * abs(along(body, link, short.jet, k * size)[0])
            reach += time * impulse * abs(along(body, link, short.answers, first + k * size)[0])
        r, _ = along(body, link, short.jet, 0)
        least = min(least, walls.gaps[other] - walls.signs[other] * r - 1.01 * reach)
    return least


@jit
def solve_short(host, varied, wall, left, y, out):
    """Solve the impact of a wall that is being touched at y, and write its release to `out`.

    left [s]: the time in which it must end. Returns (duration [s], depth [m], whether variations
    are carried); the duration is 0 if the impact is not short. The depth is 0 if it is not
    recorded. The drive of the touch is `host.scratch.drive`. Variations are left to steps if they
    take more powers, or if other walls may come nearer than so far.
    """
    body, walls, short, impacts = host.body, host.walls, host.short, host.impacts
    size, sign, link, inverse = body.size, walls.signs[wall], walls.links[wall], walls.inverse[wall]
    s = sign * along(body, link, y, 0)[1]
    if walls.law[wall] != IS_HERTZ or not s > 0.0:
        return 0.0, 0.0, False
    kappa = walls.constants[wall].K * inverse
    speed = math.sqrt(0.8 * kappa)
    b = fifth_root(s / speed)
    peak = kappa * (b * b) * (b * b) * (b * b)
    tick = 2.5 * s / peak
    # J_0 is that of the free arc, 2 s / inverse, and of a up to 2.5 LENGTH s times its size
    longest, impulse = LONGER * tick * LENGTH, (2.0 + 4.0 * LARGEST_OF_HOST) * s / inverse
    if not longest < left:
        return 0.0, 0.0, False
    for i in range(body.drives):
        short.drive[i] = host.scratch.drive[i]
    change = impulse * short.norms[wall * ROOM]
    powers = expand_free(body, host.grid, short, wall, longest, change, y)
    if powers == 0:
        return 0.0, 0.0, False
    touch = b, s, tick, peak, sign, link
    approach, memory, shrinks = approach_at(body, short, wall, touch, powers)
    distance = nears(body, walls, short, wall, (longest, powers, impulse, change))
    if not (shrinks < LARGEST_OF_HOST and distance > 0.0):
        return 0.0, 0.0, False
    at = wall * ROOM
    side = HostSide(
        short.arc, kappa, speed, -short.inverse[at + 1], -short.inverse[at + 2], powers, memory,
        shrinks, short.numbers,
    )  # fmt: skip
    solved, ratio, took, _, _ = solve_arc(side, LEVEL.whole, LEVEL.error, approach)
    if not (solved and took < longest):
        return 0.0, 0.0, False
    last = b * ratio
    outward = speed * ((last * last) * (last * last) * last)
    fill_moments(side, took, (s, outward, inverse))
    release_state(body, short, wall, powers, took, out)
    # the arc's end must be that of the whole state, but for round-off
    (r, rate), places = along(body, link, out, 0), abs(walls.gaps[wall])
    for i in range(size):
        places += abs(body.rows[link * size + i] * out[i])
    off = abs(sign * r - walls.gaps[wall]) - ERROR_OF_R * places
    if not max(off, 0.0) + took * abs(sign * rate + outward) <= took * s * short.arc.tolerance:
        return 0.0, 0.0, False
    is_varied = False
    if varied is not None:
        is_varied = not distance < varied.clearance[0]
        is_varied = is_varied and vary_short(host, varied, side, approach, (wall, took))
    row, depth = host.contacts.rows[wall], 0.0
    if 0 <= row < impacts.room:
        depth = greatest_depth(side, approach)
    return took, depth, is_varied


# ---- the state at the release --------------------------------------------------------------------


@jit
def fill_moments(side, took, ends):
    """Fill J_k at the release; ends: (speed of approach, of release, 1 / mu).

    J_0 and J_1 follow from the balance of the gap's motion, the others by the nodes: J_k is the
    integral of f (T - t)^k / k!.
    """
    arc, numbers, (s, outward, inverse) = side.arc, side.numbers, ends
    _, m, at, w = nodes_of(arc, int(arc.table[ARC.used]), LEVEL.whole)
    gained, shifted = four(0.0), four(0.0)
    for i in range(0, m, 4):
        b, u = four_at(w, ARC.amplitudes + i), four_at(w, at + i)
        rest = took - four_at(w, ARC.times + i)
        dt = four_at(w, at + NODES.weight * m + i) * four_at(w, ARC.slope_t + i)
        a = four_at(w, ARC.common_v + i) * dt
        gained, shifted = gained + a, shifted + a * rest
        b2 = b * b
        put_four(w, ARC.slope_v + i, (b2 * b2 * b2) * (u * u * u) * dt)
        put_four(w, ARC.slope_b + i, rest)
    at = ROOM * OF_MOMENTS
    numbers[at] = (s + sum_of(gained) + outward) / inverse
    numbers[at + 1] = (s * took + sum_of(shifted)) / inverse
    for k in range(1, side.powers + 1):
        total, per = four(0.0), 1.0 / k
        for i in range(0, m, 4):
            part = four_at(w, ARC.slope_v + i) * (four_at(w, ARC.slope_b + i) * per)
            put_four(w, ARC.slope_v + i, part)
            total = total + part
        if k > 1:
            numbers[at + k] = side.kappa / inverse * sum_of(total)


@jit
def release_state(body, short, wall, powers, took, out):
    """Write the state at the release: the free motion less the sum of J_k A^k b."""
    size, jet, answers, numbers = body.size, short.jet, short.answers, short.numbers
    first, time = wall * (ROOM + 1) * size, 1.0
    for i in range(2 * size):
        out[i] = 0.0
    for k in range(powers + 1):
        moment, at = numbers[ROOM * OF_MOMENTS + k], k * size
        for i in range(2 * size):
            out[i] += time * jet[at + i] - moment * answers[first + at + i]
        time *= took / (k + 1.0)


# ---- variations ----------------------------------------------------------------------------------
#
# A variation at a fixed time is the free motion of its beginning less the sum of dJ_k A^k b, with
# f'(z) dz in place of f. At the nodes
#
#     dz(t) + integral of h(t - t') f'(z(t')) dz(t') = free gap of the variation
#     h(t) = sum of g_k t^(k + 1) / (k + 1)!
#
# is one linear system for all variations, as the free gap is a polynomial. It is solved once, for
# each power, with the most nodes: they integrate a free impact's variations to 1e-15. They are
# settled to round-off, as a variation of the speed may be a small difference of its parts.


@jit
def vary_short(host, varied, side, approach, impact):
    """Carry variations through a solved impact; return False if they take more powers.

    impact: (wall, duration [s]).
    """
    body, short, walls, (wall, took) = host.body, host.short, host.walls, impact
    jet, numbers, size, x = short.jet, short.numbers, body.size, host.grid.rate * took
    first, sign, link = wall * (ROOM + 1) * size, walls.signs[wall], walls.links[wall]
    powers, left = 1, 0.5 * x * x
    while powers < MOST_POWERS and not left < VARIED_TO:
        powers += 1
        left *= x / (powers + 1.0)
    nodes = nodes_of(short.arc, short.arc.levels - 1, LEVEL.whole)
    if not left < VARIED_TO or not settle(side, nodes, approach, FINEST_ERROR):
        return False
    sums_of_slopes(side, nodes, approach)
    w, n, m, at = nodes.w, nodes.n, nodes.m, nodes.at
    for k in range(powers + 1):
        _, numbers[ROOM * OF_GAP + k] = along(body, link, short.answers, first + k * size)
    stiffness = 1.5 * walls.constants[wall].K
    matrix, gap = np.zeros((n, n)), np.zeros((n, powers + 1))
    linear = np.zeros((powers + 1, powers + 1))  # dJ_k by derivatives of the free gap
    for j in range(n):
        b, t = w[ARC.amplitudes + j], w[ARC.times + j]
        push = stiffness * (b * b * w[at + j]) * w[ARC.slope_t + j]
        for i in range(n):
            back, h = w[ARC.times + i] - t, 0.0
            for k in range(powers, -1, -1):
                h = (h + numbers[ROOM * OF_GAP + k]) * (back / (k + 1.0))
            matrix[i, j] = w[at + (NODES.matrix + j) * m + i] * push * (sign * h)
        matrix[j, j] += 1.0
        factor = 1.0
        for k in range(powers + 1):
            gap[j, k] = factor
            factor *= t / (k + 1.0)
        w[ARC.slope_b + j] = w[at + NODES.weight * m + j] * push
    if solve(matrix, gap) == 0.0:
        return False
    for k in range(powers + 1):
        for p in range(powers + 1):
            for j in range(n):
                linear[k, p] += w[ARC.slope_b + j] * gap[j, p]
        for j in range(n):
            w[ARC.slope_b + j] *= (took - w[ARC.times + j]) / (k + 1.0)
    for c in range(varied.number):
        row = from_place(varied.rows, 2 * size * c)
        for i in range(2 * size):
            jet[i] = row[i]
        for k in range(powers + 1):
            accelerate(body, jet, k * size, 0.0, jet, (k + 2) * size)
        for k in range(powers + 1):
            numbers[ROOM * OF_GAP + k] = sign * along(body, link, jet, k * size)[0]
        for k in range(powers + 1):
            total = 0.0
            for p in range(powers + 1):
                total += linear[k, p] * numbers[ROOM * OF_GAP + p]
            numbers[ROOM * OF_MOMENTS + k] = total
        release_state(body, short, wall, powers, took, row)
    return True


# ---- the kernels of `impact` that are marked `by_flow` -------------------------------------------


@jit
def slopes_of_host(side, w, at, m, i):
    """Return (a, db/dphi, dt/dphi, z, s) at the four nodes from i on."""
    b, u, S_u = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + m + i)
    t, b2, numbers = four_at(w, ARC.times + i), b * b, side.numbers
    b4, u2 = b2 * b2, u * u
    z, s, a = b4 * u2, (side.speed * (b4 * b)) * S_u, four(0.0)
    for k in range(side.powers - 1, -1, -1):
        a = a * t + numbers[k]
    a = a + (side.by_speed * s + (side.by_depth * z + four_at(w, ARC.common_x + i)))
    per = u / (side.kappa * (b4 * b2) - a * u2)
    return a, 0.5 * S_u * a * b * per, (2.5 * side.speed) * (b4 * b) * per, z, s


@jit
def guess_slow(side, nodes, approach):
    w, at = nodes.w, nodes.at
    for i in range(0, nodes.m, 4):
        b, u = four_at(w, ARC.amplitudes + i), four_at(w, at + i)
        b2 = b * b
        put_four(w, ARC.slope_x + i, (b2 * b2) * (u * u) * (approach.tick * u))
    remember_depths(side, nodes)


@jit
def remember_depths(side, nodes):
    """Fill the memory at the nodes, whose z dt/dphi are there.

    m is summed by even and by odd powers, at two fours of nodes at once: four sums that do not wait
    for each other. The last two fours may be one.
    """
    w, m, matrix, numbers = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m, side.numbers
    at = ROOM * OF_MEMORY
    for i in range(0, m, 8):
        other = min(i + 4, m - 4)
        t, t_other = four_at(w, ARC.times + i), four_at(w, ARC.times + other)
        total, total_other = four(0.0), four(0.0)
        if side.memory > 0:
            for j in range(nodes.n):
                row, time, z = matrix + j * m, w[ARC.times + j], w[ARC.slope_x + j]
                x, y = t - time, t_other - time
                x2, y2 = x * x, y * y
                even, odd, even_other, odd_other = four(0.0), four(0.0), four(0.0), four(0.0)
                for k in range(at + side.memory - 2, at - 1, -2):
                    even, odd = even * x2 + numbers[k], odd * x2 + numbers[k + 1]
                    even_other = even_other * y2 + numbers[k]
                    odd_other = odd_other * y2 + numbers[k + 1]
                total = total + (four_at(w, row + i) * z) * (even + x * odd)
                even_other = even_other + y * odd_other
                total_other = total_other + (four_at(w, row + other) * z) * even_other
        put_four(w, ARC.common_x + i, total)
        put_four(w, ARC.common_x + other, total_other)


@jit
def shrinking(side, approach):
    """Return the factor of the next sweep's change: a third of the relative forces (`inside`)."""
    return side.shrinks / 3.0


@jit
def sweep(side, nodes, approach):
    w, m, matrix = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m
    for i in range(0, m, 4):
        _, of_b, of_t, z, _ = slopes_of_host(side, w, nodes.at, m, i)
        put_four(w, ARC.slope_b + i, of_b)
        put_four(w, ARC.slope_t + i, of_t)
        put_four(w, ARC.slope_x + i, z * of_t)
    changed = four(0.0)
    for i in range(0, m, 4):
        b, t = four(approach.b), four(0.0)
        for j in range(nodes.n):
            q = four_at(w, matrix + j * m + i)
            b = b + q * w[ARC.slope_b + j]
            t = t + q * w[ARC.slope_t + j]
        changed = larger_of(changed, b - four_at(w, ARC.amplitudes + i))
        put_four(w, ARC.amplitudes + i, b)
        put_four(w, ARC.times + i, t)
    remember_depths(side, nodes)
    return 5.0 * largest_of(changed) / approach.b


@jit
def sums_of_slopes(side, nodes, approach):
    """Return the integrals; the slopes of t and `a` stay in the table."""
    w, m, at = nodes.w, nodes.m, nodes.at
    sb, st, energy, per = four(0.0), four(0.0), four(0.0), 1.0 / approach.b
    for i in range(0, m, 4):
        a, fb, ft, _, s = slopes_of_host(side, w, at, m, i)
        put_four(w, ARC.slope_t + i, ft)
        put_four(w, ARC.common_v + i, a)
        q = four_at(w, at + NODES.weight * m + i)
        sb, st, energy = sb + q * (fb * per), st + q * ft, energy + q * (s * a * ft)
    return sum_of(sb), sum_of(st), 0.0, 0.0, sum_of(energy), 0.0
