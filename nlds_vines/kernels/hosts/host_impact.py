"""A short impact of a host, solved at once by the collocation of `impact` from scalars of the gap.

While one wall pushes with Hertz' force f and no other one is touched, the state and the depth are

    y(t) = free motion - sum over k of J_k(t) A^k b      J_0' = f      J_k' = J_(k - 1)
    z''  = a_free(t) - g_0 f - sum over k >= 1 of g_k J_(k - 1)(t)

with the rates b of a unit impulse of the wall and g_k = c A^(k + 1) b, z = c y. With D for the
derivative this is z'' = a_free - G f, G = sum of g_k D^-k. Multiplied by g_0 / G = 1 - sum of
w_k D^-k, it holds the force once:

    z'' = a - g_0 f      a = P(t) + w_1 s + w_2 z + w_3 Z_1 + w_4 Z_2 + ...      Z_k = D^-k z

with P = (1 - sum of w_k D^-k) z_free'' and the free depth z_free, which begins with the approach
speed s_0. So the collocation of `impact` applies. The memory w_3 Z_1 + w_4 Z_2 + ... is the
integral of z(t') m(t - t') with the polynomial m(t) = sum of w_(k + 3) t^k / k!.

z_free is known: it is r, of which a polynomial holds from the beginning of the cell of the touch
on. And the impact acts as a jump of the state at the beginning of the cell of its release,

    y <- y - sum over k of M_k A^k b      M_k = integral of f (t_cell - t)^k / k! dt

so that no state is moved to the touch, nor from the release on. Both series, and P, are in units of
the free arc in the collocation: `tick` for times, s_0 for speeds, z_0 = s_0 tick / 2 for depths and
2.5 s_0 / tick for accelerations.

The series end with the power K of time. P is the sum of z_free and of its integrals, and the rest
of a Taylor polynomial with K powers is at most T^K / K! times a bound of the derivative K. With
bounds Z_j of |z_free^(j)| over the impact's time T and w_0 = -1 its rest is at most

    T^K / K! (sum over m of |w_m| Z_(K + 2 - m), m from 0 to K + 2)                         (1)

and |w_m| <= q^m bounds what the terms with greater m do to z and z_free. K is the first power, in
fours, for which both are below the error that sweeps may leave.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..impact.arc import ARC, FINEST_ERROR, GUESSED, LEVEL, LEVEL_ROW, MISSED, NODES, TERM
from ..impact.impact import BY_TIME, DOUBTED, LENGTH, MOST_SWEEPS, gathered, nodes_of
from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST, exp, fifth_root, log
from ..numerics.fours import (
    four,
    four_at,
    four_of,
    from_place,
    larger_of,
    largest_of,
    number_of,
    put_four,
    sum_of,
)
from ..numerics.matrices import solve
from .body import accelerate, along
from .grid import LONG_TERMS, WINDOW
from .host_flight import (
    AT_TOUCH,
    carry,
    derive,
    expand_long,
    place_at,
    put_columns,
    r_and_slope,
)
from .walls import IS_HERTZ

LEAST_POWERS, MOST_POWERS = 8, 28  # K; an impact that takes more of them is stepped
LONGER = 1.1  # bound of the duration of a short impact over that of its free arc
LARGEST_OF_HOST = 0.5  # greatest sum of the relative forces beside the contact's
MOST_IMPULSE = 2.0 + 4.0 * LARGEST_OF_HOST  # over s_0: 2 of the free arc, and a for LENGTH ticks
BESIDE = 1.0e-3  # share of an impact's change of state that is more than the error of any r
VARIED_TO = 1.0e-13  # relative rest of the series of a variation
ERROR_OF_R = 4.0e-15  # of r, relative to the sum of its parts
SHARE_OF_REST = 0.125  # of the error that sweeps may leave, for each rest of a series
STALE = 0.5  # share of it, for the memory of nodes that have moved
FELT_AGAIN = 10.0  # largest next change of the memory by nodes, relative to that by the last ones
DEPTHS = 2.0  # bound of 0.2 (z + z_free) / z_0: w z_0 is 0.2 w tick^2 in units of the free arc
SUMMED = 64  # w_k that are computed; the others are bounded
SUM_OF_WEIGHTS = 8.0  # largest bound of |w_m|^(1 / m) T beyond SUMMED: 8^65 / 63! is 3e-29
FASTER, MOST_GROWTH = 1.5, 1e3  # q from SUMMED on, in units of the rate, and of 1 / L
PROMISING = 3.0  # largest of the last two terms for which the rest of P is bounded
LEAST_KICK = 1.0e-16  # bound of the change of state by A^k b from LONG_TERMS on, relative to b

# Parts of `numbers`: series, and the sizes of series; there are zeros before those that take them
OF_DERIVATIVES, OF_PUSH, OF_WEIGHTS, OF_MEMORY, OF_MOMENTS = 32, 72, 104, 144, 176
OF_SHIFTS, OF_SUMS, OF_SIZES, OF_PARTS, OF_LATER, ROOM_OF_IMPACT = 224, 256, 288, 328, 368, 400
ROOM = MOST_POWERS + 2

LONGEST_SHORT = LONGER * LENGTH  # bound of T / tick
FACTORIAL = np.array([float(math.factorial(k)) for k in range(40)])
PER_FACTORIAL = np.array([1.0 / math.factorial(k) for k in range(40)])
TIMES = np.array([LONGEST_SHORT**k for k in range(40)])
# bound of the term of w_(k + 3) in units of the free arc, over |w_(k + 3)| tick^(k + 3)
REMEMBERED = np.array([0.2 * LONGEST_SHORT ** (k + 1) / math.factorial(k + 1) for k in range(40)])


class ShortImpacts(NamedTuple):
    """What short impacts need of a host; arrays are rows, in inner kernels bare ones.

    L is the length of a long cell (`grid`).
    """

    arc: Any  # `impact.Arc`
    length: float  # L [s]
    rows: int  # numbers of a state, in whole fours
    kicks: Any  # (walls * LONG_TERMS * rows,) L^k A^k b / g_0
    weights: Any  # (walls * SUMMED,) L^k w_k
    norms: Any  # (walls * LONG_TERMS,) L^k |A^k b| / |b|
    growths: Any  # (walls,) q L
    # (walls,) largest T / L for which |w_k| from SUMMED on are nothing, and M_k from LONG_TERMS on
    reaches: Any
    spans: Any
    jet: Any  # ((ROOM + 1) * size,) derivatives of X of a variation
    numbers: Any  # ROOM_OF_IMPACT, see OF_DERIVATIVES
    jump: Any  # (rows,)


class ShortArc(NamedTuple):
    """A short impact at touch; P and m are in units of its free arc."""

    s: float  # approach speed [m/s]
    tick: float  # [s]
    part: float  # tick / L
    depth: float  # z_0 [m]
    powers: int  # of P, an even number; 0: the impact is not short
    memory: int  # of m, an even number
    shrinks: float  # bound of |a|
    remembered: float  # bound of the memory
    missed: float  # the errors of n nodes are at most C_n times this


@jit
def pair_norm(body, grid, state):
    """Return the largest norm of a pair (`grid`) of a state."""
    n, size, largest = body.modes, body.size, 0.0
    for i in range(size):
        x, v = state[i], state[size + i]
        if i >= n:
            x, v = along(body, i - n, state, 0)
        x *= grid.scales[i]
        largest = max(largest, x * x + v * v)
    return math.sqrt(largest)


@jit
def short_impacts(body, grid, walls, arc):
    """Return the `ShortImpacts` of a host."""
    size, count = body.size, walls.number
    rows, length = (2 * size + 3) // 4 * 4, grid.h * (1 << (grid.levels - grid.long))
    short = ShortImpacts(
        arc, length, rows, np.zeros(count * LONG_TERMS * rows), np.zeros(count * SUMMED),
        np.zeros(count * LONG_TERMS), np.zeros(count), np.zeros(count), np.zeros(count),
        np.zeros((ROOM + 1) * size), np.zeros(ROOM_OF_IMPACT), np.zeros(rows),
    )  # fmt: skip
    for wall in range(count):
        if walls.law[wall] == IS_HERTZ:
            fill_kicks(body, grid, walls, short, wall)
    return short


@jit
def fill_kicks(body, grid, walls, short, wall):
    """Fill what `ShortImpacts` holds for a wall; |g_k| <= C rate^k g_0 by the norms of pairs."""
    size, link, sign, length = body.size, walls.links[wall], walls.signs[wall], short.length
    first, row, of_norms = wall * LONG_TERMS * short.rows, wall * SUMMED, wall * LONG_TERMS
    state, rates = np.zeros(2 * size), np.zeros(size)
    g, inverse, reach = np.zeros(SUMMED), np.zeros(SUMMED), 0.0
    for i in range(size):
        state[size + i] = sign * body.answers[link * size + i]
        reach += abs(body.rows[link * size + i])
    if body.modes + link < size:  # s is the rate of one pair, otherwise a sum of rates
        reach = 1.0
    largest = pair_norm(body, grid, state)
    for k in range(SUMMED):
        g[k] = sign * along(body, link, state, 0)[1]
        if k < LONG_TERMS:
            short.norms[of_norms + k] = pair_norm(body, grid, state) / largest
            for i in range(2 * size):
                short.kicks[first + k * short.rows + i] = state[i] * (1.0 / g[0])
        accelerate(body, state, 0, 0.0, rates, 0)
        for i in range(size):
            state[i] = length * state[size + i]
            state[size + i] = length * rates[i]
    per = 1.0 / g[0]
    for k in range(SUMMED):
        g[k] *= per
    power, known = 1.0, LEAST_POWERS + 3  # of q; w_m from there on are below q^m
    for k in range(SUMMED):
        total = 1.0 if k == 0 else 0.0
        for i in range(k):
            total -= g[k - i] * inverse[i]
        inverse[k] = total
        short.weights[row + k] = -total
        power *= short.growths[wall]
        if k >= known and abs(total) > power:
            short.growths[wall] = exp(log(abs(total)) / k)
            power = abs(total)
    # beyond SUMMED |w_m| <= q^m if the sum of |g_k / g_0| q^-k is at most 1; the rest of the sum
    # is that of C (rate / q)^k
    rate = grid.rate * length
    growth, total = FASTER * rate, math.inf
    rest = reach * largest * per
    for _ in range(SUMMED):
        rest *= 1.0 / FASTER
    rest /= 1.0 - 1.0 / FASTER
    while total + rest > 1.0 and growth < MOST_GROWTH:
        total, growth = 0.0, 1.25 * growth
        back = 1.0 / growth
        for k in range(SUMMED - 1, 0, -1):
            total = (total + abs(g[k])) * back
    short.reaches[wall] = SUM_OF_WEIGHTS / growth
    # span^32 / 32! times the norm of A^32 b, and a factor for those of more powers
    last = max(2.0 * rate * short.norms[of_norms + LONG_TERMS - 1], TINIEST)
    short.spans[wall] = exp(log(LEAST_KICK * FACTORIAL[LONG_TERMS] / last) / LONG_TERMS)


# ---- an impact at touch --------------------------------------------------------------------------


@jit
def no_arc():
    return ShortArc(0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, 0.0, 0.0)


@jit
def approach_at(host, wall, place, fourth, left):
    """Return the `ShortArc` of a touch, and fill P, m and the weights of both.

    place: of the touch, in the polynomial `ShortImpacts.r`; fourth: the bound of |r''''| from its
    beginning on; left [s]: the time in which the impact must end.
    """
    short, walls, d = host.short, host.walls, host.short.numbers
    r, settled, sign = host.scratch.r, short.arc.settled, walls.signs[wall]
    nothing = no_arc()
    s = sign * r_and_slope(r, place)[1] / short.length
    if walls.law[wall] != IS_HERTZ or not s > 0.0:
        return nothing
    kappa = walls.constants[wall].K * walls.inverse[wall]
    b = fifth_root(s / math.sqrt(0.8 * kappa))
    b2 = b * b
    depth, peak = b2 * b2, kappa * (b2 * b2 * b2)
    tick = 2.5 * s / peak
    part = tick / short.length
    span = LONGEST_SHORT * part  # of the impact, in long cells
    end, reach = place + span, min(short.reaches[wall], short.spans[wall])
    if not (LONGEST_SHORT * tick < left and end < WINDOW and span < reach):
        return nothing
    # what the polynomial of r omits of a
    end2 = end * end
    end4 = end2 * end2
    end8 = end4 * end4
    omitted = host.grid.rests[walls.links[wall]] * fourth / (peak * short.length * short.length)
    omitted *= (end8 * end8) * (end8 * end4) * end2 * PER_FACTORIAL[LONG_TERMS - 2]
    negligible = SHARE_OF_REST * settled
    if not omitted < negligible:
        return nothing
    for k in range(0, LONG_TERMS, 4):
        put_four(d, OF_SIZES + k, larger_of(four(0.0), four_at(r, k)))
    # four powers of P at a time; D_j = z_free^(j) in units of the free arc
    scale, by, known, filled, powers = sign * part / (5.0 * depth), 1.0, 1, 0, 0
    part2 = part * part
    step, growth, grown = part2 * part2, short.growths[wall] * span, 1.0
    while True:
        if powers == MOST_POWERS:
            return nothing
        while known <= powers + 5:
            first = scale * FACTORIAL[known]
            second = first * part * (known + 1.0)
            third = second * part * (known + 2.0)
            units = four_of(first, second, third, third * part * (known + 3.0))
            put_four(d, OF_DERIVATIVES + known, derive(r, known, place) * units)
            scale *= step
            known += 4
        while filled < powers + 8:
            units = four_of(by, by * part, by * part2, by * (part2 * part))
            weights = four_at(short.weights, wall * SUMMED + filled)
            put_four(d, OF_WEIGHTS + filled, weights * units)
            by *= step
            filled += 4
        at = OF_DERIVATIVES + powers + 2
        odd, even = four_at(d, at), four(0.0)
        for m in range(1, powers + 5, 2):
            odd = odd - four_at(d, at - m) * d[OF_WEIGHTS + m]
            even = even - four_at(d, at - m - 1) * d[OF_WEIGHTS + m + 1]
        push = (odd + even) * four_at(PER_FACTORIAL, powers)
        put_four(d, OF_PUSH + powers, push)
        put_four(d, OF_PARTS + powers, larger_of(four(0.0), push) * four_at(TIMES, powers))
        powers += 4
        grown *= (growth * growth) * (growth * growth)
        # a push e (t / T)^K changes the speed, relative to s_0, by 2.5 e T / (K + 1) ticks
        enough = negligible * (powers + 1.0) / (2.5 * LONGEST_SHORT)
        last = max(d[OF_PARTS + powers - 1], d[OF_PARTS + powers - 2])
        if powers >= LEAST_POWERS and last < PROMISING * enough and growth < 0.5 * powers:
            # twice the first term of w_m, m > K + 2, over T^(m - 2) / (m - 2)!
            beyond = 2.0 * DEPTHS / (LONGEST_SHORT * LONGEST_SHORT) * PER_FACTORIAL[powers + 1]
            beyond *= grown * (growth * growth) * growth
            units = abs(scale) * FACTORIAL[powers + 2] / (part2 * part)
            bound = number_of(derive(from_place(d, OF_SIZES), powers + 2, end), 0) * units
            omitted = TIMES[powers] * PER_FACTORIAL[powers] * rest_of_push(d, powers, bound)
            if max(omitted, beyond) < enough:
                return without_small_terms(
                    short, wall, ShortArc(s, tick, part, depth, powers, 0, 0.0, 0.0, 0.0)
                )


@jit
def rest_of_push(d, powers, bound):
    """Return the sum in (1); bound: Z_(K + 2)."""
    total, last = bound, powers + 2
    for m in range(1, last + 1):
        bound *= LONGEST_SHORT
        if m < last:
            bound += abs(d[OF_DERIVATIVES + last - m])
        total += abs(d[OF_WEIGHTS + m]) * bound
    return total


@jit
def without_small_terms(short, wall, arc):
    """Return a `ShortArc` without what is negligible of P and of m; fill m."""
    d, negligible, powers = short.numbers, SHARE_OF_REST * short.arc.settled, arc.powers
    put_four(d, OF_PARTS + powers, four(0.0))
    rests, remembers = four(0.0), four(0.0)
    for k in range(0, powers, 4):
        rests = rests + four_at(d, OF_PARTS + 3 + k)  # of P from its third power on
        weights = four_at(d, OF_WEIGHTS + k + 3)
        put_four(d, OF_MEMORY + k, 0.2 * weights * four_at(PER_FACTORIAL, k))
        remembered = larger_of(four(0.0), weights) * four_at(REMEMBERED, k)
        put_four(d, OF_LATER + k, remembered)
        remembers = remembers + remembered
    remembered, memory, omitted = sum_of(remembers), powers, 0.0
    while memory > 0:
        omitted += d[OF_LATER + memory - 1] + d[OF_LATER + memory - 2]
        if not omitted < negligible:
            break
        memory -= 2
    omitted = 0.0
    while powers > 4:
        omitted += d[OF_PARTS + powers - 1] + d[OF_PARTS + powers - 2]
        if not omitted < negligible:
            break
        powers -= 2
    size = abs(d[OF_PUSH]) + 0.4 * abs(d[OF_WEIGHTS + 1]) + 2.0 * abs(d[OF_PUSH + 1])
    size += 0.2 * abs(d[OF_WEIGHTS + 2]) + 4.0 * abs(d[OF_PUSH + 2])
    rest, length = sum_of(rests) + remembered, LENGTH * arc.part
    # The errors of n nodes are at most C_n e^(3/2) for the five numbers, C_n times `rest`, which
    # the series omits, and C_n / 12 for J_2, whose share of the release is T^2 |A^2 b| / (8 |b|).
    of_moments = length * length * short.norms[wall * LONG_TERMS + 2] / 96.0
    missed = max(size * math.sqrt(size) + rest + of_moments, TINIEST)
    return ShortArc(
        arc.s, arc.tick, arc.part, arc.depth, powers, memory, size + rest, remembered, missed
    )


@jit
def distance_to_others(host, wall, place, arc):
    """Return the least distance [m] that other walls are proven to keep during the impact.

    Walls of the same link are not touched. place: of the touch in the long cell whose beginning is
    `Scratch.columns`, with the bounds of |r''''| in `Scratch.gaps`.
    """
    body, walls, short, scratch = host.body, host.walls, host.short, host.scratch
    lasting, least, impulse = LONGEST_SHORT * arc.tick, math.inf, MOST_IMPULSE * arc.s
    span = lasting / short.length
    square = short.length * short.length
    for other in range(walls.number):
        link = walls.links[other]
        if link == walls.links[wall]:
            continue
        expand_long(body, host.grid, link, scratch.columns, scratch.r)
        later, time, reach = derive(scratch.r, 1, place), 1.0, BESIDE * lasting * impulse
        for k in range(3):
            time *= span
            reach += time * abs(number_of(later, k))
        fourth = scratch.gaps[AT_TOUCH * body.links + link]
        reach += fourth * (square * square) * (time * span) / 24.0
        time = 1.0
        for k in range(1, LONG_TERMS):
            time *= span / k
            kick = from_place(short.kicks, (wall * LONG_TERMS + k) * short.rows)
            reach += time * impulse * abs(along(body, link, kick, 0)[0])
        depth = walls.signs[other] * r_and_slope(scratch.r, place)[0] - walls.gaps[other]
        least = min(least, -depth - 1.01 * reach)
    return least


# ---- the impact itself, in units of its free arc -------------------------------------------------


@jit
def guess(d, nodes, arc):
    """Fill the unknowns at the nodes by the series (`impact.first_guess`)."""
    w, m, at = nodes.w, nodes.m, nodes.at
    w[ARC.products] = 1.0
    w[ARC.products + TERM.force] = d[OF_PUSH]
    w[ARC.products + TERM.drag] = -0.4 * d[OF_WEIGHTS + 1]
    w[ARC.products + TERM.drift] = d[OF_PUSH + 1]
    w[ARC.products + TERM.spring] = 0.2 * d[OF_WEIGHTS + 2]
    w[ARC.products + TERM.curvature] = d[OF_PUSH + 2]
    for k in range(4, MISSED, 4):  # four at once: their factors stand before them
        put_four(w, ARC.products + k, gathered(w, k) * gathered(w, MISSED + k))
    for i in range(0, m, 4):
        # sums of odd and of even terms, which do not wait for each other; b has no term 1
        row = at + NODES.b * m + i
        beta, beta_even, t_even = four(0.0), four(0.0), four(0.0)
        t = four_at(w, row + (NODES.t - NODES.b) * m)
        for k in range(1, GUESSED, 2):
            row += m
            beta = beta + four_at(w, row) * w[ARC.products + k]
            t = t + four_at(w, row + (NODES.t - NODES.b) * m) * w[ARC.products + k]
            row += m
            beta_even = beta_even + four_at(w, row) * w[ARC.products + k + 1]
            t_even = t_even + four_at(w, row + (NODES.t - NODES.b) * m) * w[ARC.products + k + 1]
        put_four(w, ARC.amplitudes + i, 1.0 + (beta + beta_even))
        put_four(w, ARC.times + i, t + t_even)
        once, twice = four_at(w, at + NODES.cube * m + i), four_at(w, at + NODES.double * m + i)
        remembered = (0.2 * d[OF_WEIGHTS + 3]) * once + (0.2 * d[OF_WEIGHTS + 4]) * twice
        if arc.memory == 0:
            remembered = four(0.0)
        put_four(w, ARC.common_x + i, remembered)


@jit(inlined=True)
def slopes(d, nodes, arc, i):
    """Return (a, db/dphi, dt/dphi, z, s) at the four nodes from i on."""
    w, m, at = nodes.w, nodes.m, nodes.at
    b, u, S = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + m + i)
    t, b2, u2 = four_at(w, ARC.times + i), b * b, u * u
    b4, t2, even, odd = b2 * b2, t * t, four(0.0), four(0.0)
    b5 = b4 * b
    z, s = b4 * u2, b5 * S
    for k in range(OF_PUSH + arc.powers - 2, OF_PUSH - 1, -2):
        even, odd = even * t2 + d[k], odd * t2 + d[k + 1]
    a = (even + odd * t) + ((0.4 * d[OF_WEIGHTS + 1]) * s + (0.2 * d[OF_WEIGHTS + 2]) * z)
    a = a + four_at(w, ARC.common_x + i)
    per = u / (b4 * b2 - a * u2)
    return a, 0.5 * S * a * b * per, b5 * per, z, s


@jit
def sweep(d, nodes, arc):
    """Integrate the slopes to the nodes; return the largest change of s / s_0.

    z dt/dphi at the nodes before stays in slope_x.
    """
    w, m, matrix = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m
    for i in range(0, m, 4):
        _, of_b, of_t, z, _ = slopes(d, nodes, arc, i)
        put_four(w, ARC.slope_b + i, of_b)
        put_four(w, ARC.slope_t + i, of_t)
        put_four(w, ARC.slope_x + i, z * of_t)
    changed = four(0.0)
    for i in range(0, m, 4):
        b, t = four(1.0), four(0.0)
        for j in range(nodes.n):
            q = four_at(w, matrix + j * m + i)
            b, t = b + q * w[ARC.slope_b + j], t + q * w[ARC.slope_t + j]
        changed = larger_of(changed, b - four_at(w, ARC.amplitudes + i))
        put_four(w, ARC.amplitudes + i, b)
        put_four(w, ARC.times + i, t)
    return 5.0 * largest_of(changed)


@jit
def remember_depths(d, nodes, arc):
    """Fill the memory at the nodes, whose z dt/dphi are there; return its largest change.

    m is summed by even and by odd powers, for two nodes at once: four sums that do not wait for
    each other. The numbers of nodes are even.
    """
    w, m, matrix = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m
    last, changed = OF_MEMORY + arc.memory - 2, four(0.0)
    for i in range(0, m, 4):
        t, total, total_next = four_at(w, ARC.times + i), four(0.0), four(0.0)
        for j in range(0, nodes.n, 2):
            row = matrix + j * m + i
            x, y = t - w[ARC.times + j], t - w[ARC.times + j + 1]
            x2, y2 = x * x, y * y
            even, odd, even_next, odd_next = four(0.0), four(0.0), four(0.0), four(0.0)
            for k in range(last, OF_MEMORY - 1, -2):
                even, odd = even * x2 + d[k], odd * x2 + d[k + 1]
                even_next, odd_next = even_next * y2 + d[k], odd_next * y2 + d[k + 1]
            total = total + (four_at(w, row) * w[ARC.slope_x + j]) * (even + x * odd)
            share = four_at(w, row + m) * w[ARC.slope_x + j + 1]
            total_next = total_next + share * (even_next + y * odd_next)
        total = total + total_next
        changed = larger_of(changed, total - four_at(w, ARC.common_x + i))
        put_four(w, ARC.common_x + i, total)
    return largest_of(changed)


@jit
def settle(d, nodes, arc, tolerance):
    """Sweep until the unknowns at the nodes settle (`impact.settle`); return True if they do.

    A relative change of the nodes changes the memory by at most that share of its bound, later by
    at most FELT_AGAIN times the share that was seen. The memory is summed again if that matters.
    The guess may err by all of it.
    """
    guess(d, nodes, arc)
    shrinks, error, felt, since = arc.shrinks / 3.0, arc.remembered, 1.0, 0.0
    for _ in range(MOST_SWEEPS):
        change, moved = sweep(d, nodes, arc), 0.0
        if error > STALE * tolerance:
            moved = remember_depths(d, nodes, arc)
            if since > 0.0:
                felt = min(felt, FELT_AGAIN * moved / (arc.remembered * since))
            since = 0.0
        since += change
        error = felt * arc.remembered * since
        is_settled = (change + moved) * shrinks * max(shrinks, BY_TIME) <= tolerance
        if is_settled and error <= tolerance:
            return True
    return False


@jit
def at_end(d, nodes, arc):
    """Return (b / b_0, duration / tick, doubt) at the end of the interval (`impact.at_end`).

    The integral of a, that of a (T - t) and the slopes for the moments of f stay in the table.
    """
    w, m, at = nodes.w, nodes.m, nodes.at
    errors = at + (NODES.matrix + nodes.n) * m
    missed_b, missed_t, missed_energy = four(0.0), four(0.0), four(0.0)
    for k in range(0, MISSED, 4):
        term = four_at(w, ARC.products + k)
        missed_b = missed_b + term * four_at(w, errors + k)
        missed_t = missed_t + term * four_at(w, errors + MISSED + k)
        missed_energy = missed_energy + term * four_at(w, errors + 2 * MISSED + k)
    sum_b, sum_t, energy = four(0.0), four(0.0), four(0.0)
    for i in range(0, m, 4):
        a, of_b, of_t, _, s = slopes(d, nodes, arc, i)
        q = four_at(w, at + NODES.weight * m + i)
        dt = q * of_t
        sum_b, sum_t, energy = sum_b + q * of_b, sum_t + dt, energy + s * a * dt
        put_four(w, ARC.slope_t + i, of_t)
        put_four(w, ARC.common_v + i, a)
    ratio, took = 1.0 + (sum_of(sum_b) + sum_of(missed_b)), sum_of(sum_t) + sum_of(missed_t)
    ratio2 = ratio * ratio
    ratio4 = ratio2 * ratio2
    gained = 5.0 * sum_of(energy) + sum_of(missed_energy)
    return ratio, took, DOUBTED * abs(ratio4 * ratio4 * ratio2 - (1.0 + gained))


@jit
def solve_short(short, part, error, arc):
    """Solve an impact to its release or, on the half arc, to its deepest point.

    part, error: LEVEL.whole and LEVEL.error, or those of the half. Returns (solved, b / b_0,
    duration / tick) at the end; the number of nodes rises as long as the doubt exceeds the
    tolerance.
    """
    table, d = short.arc.table, short.numbers
    for level in range(short.arc.levels):
        most = table[ARC.levels + LEVEL_ROW * level + error] * arc.missed
        if level < short.arc.levels - 1 and most > short.arc.tolerance:
            continue
        table[ARC.used] = level
        nodes = nodes_of(short.arc, level, part)
        if settle(d, nodes, arc, short.arc.settled):
            ratio, took, doubt = at_end(d, nodes, arc)
            if doubt <= short.arc.tolerance:
                return True, ratio, took
    return False, 1.0, 0.0


@jit
def deepest(short, arc):
    """Return the greatest depth [m], z_0 (b / b_0)^4 at the end of the half arc, or 0."""
    solved, ratio, _ = solve_short(short, LEVEL.half, LEVEL.half_error, arc)
    return arc.depth * (ratio * ratio) * (ratio * ratio) if solved else 0.0


# ---- the jump ------------------------------------------------------------------------------------


@jit
def fill_moments(short, wall, arc, ends):
    """Fill g_0 J_k / L^k [m/s] at the release; return the number of powers.

    ends: (b / b_0, duration / tick). J_0 and J_1 follow from the balance of the gap's motion, the
    others by the nodes: J_k is the integral of f (T - t)^k / k!.
    """
    d, (ratio, took), table = short.numbers, ends, short.arc.table
    nodes = nodes_of(short.arc, int(table[ARC.used]), LEVEL.whole)
    w, m, weight = nodes.w, nodes.m, nodes.at + NODES.weight * nodes.m
    # the first power without effect, as |J_k| <= J_0 T^k / k!
    count, power, span = 0, 1.0, took * arc.part
    while count < LONG_TERMS and power * short.norms[wall * LONG_TERMS + count] > short.arc.settled:
        for _ in range(4):
            count += 1
            power *= span / count
    gained, shifted = four(0.0), four(0.0)
    for i in range(0, m, 4):
        rest = took - four_at(w, ARC.times + i)
        dt = four_at(w, weight + i) * four_at(w, ARC.slope_t + i)
        push = four_at(w, ARC.common_v + i) * dt
        gained, shifted = gained + push, shifted + push * rest
        b, u = four_at(w, ARC.amplitudes + i), four_at(w, nodes.at + i)
        force, b2 = (u * u * u) * dt, b * b
        put_four(w, ARC.slope_v + i, (b2 * b2 * b2) * force * rest)
        put_four(w, ARC.slope_b + i, rest)
    outward = (ratio * ratio) * (ratio * ratio) * ratio
    d[OF_MOMENTS] = arc.s * (1.0 + 2.5 * sum_of(gained) + outward)
    d[OF_MOMENTS + 1] = arc.s * arc.part * (took + 2.5 * sum_of(shifted))
    scale, square = 2.5 * arc.s * (arc.part * arc.part), arc.part * arc.part
    for k in range(2, count, 2):
        even, odd = four(0.0), four(0.0)
        for i in range(0, m, 4):
            rest = four_at(w, ARC.slope_b + i)
            force = four_at(w, ARC.slope_v + i) * rest
            even = even + force
            force = force * rest
            odd = odd + force
            put_four(w, ARC.slope_v + i, force)
        d[OF_MOMENTS + k] = scale * PER_FACTORIAL[k] * sum_of(even)
        d[OF_MOMENTS + k + 1] = scale * arc.part * PER_FACTORIAL[k + 1] * sum_of(odd)
        scale *= square
    return count


@jit
def jump(short, wall, place, count, length, y):
    """Change the state at the beginning of a cell by an impact that is left at a place in it.

    M_i is the sum of J_k (-place)^(i - k) / (i - k)! over the `count` powers k; length: of y.
    """
    d, rows, out = short.numbers, short.rows, short.jump
    square = place * place
    powers = four_of(1.0, -place, square, -square * place)
    for k in range(0, LONG_TERMS, 4):
        put_four(d, OF_SHIFTS + k, powers * four_at(PER_FACTORIAL, k))
        powers = powers * (square * square)
    for i in range(0, LONG_TERMS, 4):
        even, odd = four(0.0), four(0.0)
        for k in range(0, min(count, i + 4), 2):
            even = even + four_at(d, OF_SHIFTS + i - k) * d[OF_MOMENTS + k]
            odd = odd + four_at(d, OF_SHIFTS + i - k - 1) * d[OF_MOMENTS + k + 1]
        put_four(d, OF_SUMS + i, even + odd)
    for i in range(0, rows, 4):
        even, odd, at = four(0.0), four(0.0), wall * LONG_TERMS * rows + i
        for k in range(0, LONG_TERMS, 2):
            even = even + four_at(short.kicks, at) * d[OF_SUMS + k]
            odd = odd + four_at(short.kicks, at + rows) * d[OF_SUMS + k + 1]
            at += 2 * rows
        put_four(out, i, even + odd)
    for i in range(length):
        y[i] -= out[i]


@jit
def bounce(host, wall, touch, limit, y):
    """Take the impact of a touch at once, if it is short: advance y to its base after the release.

    touch: (j, x, place) as of `fly`; limit: the cell at whose beginning it must have ended. Returns
    (its `ShortArc`, b / b_0 at the release, duration / tick, distance [m] of other walls, (j, x) of
    the release, then of the base). `powers` of the arc are 0 if it is not short; then y is as it
    was.
    """
    body, grid, walls, short, scratch = host.body, host.grid, host.walls, host.short, host.scratch
    (j, x, place), link, out = touch, walls.links[wall], scratch.after
    begun, begun_x = place_at(grid, j, x, place)
    left, fourth = (limit - begun - begun_x) * grid.h, scratch.gaps[AT_TOUCH * body.links + link]
    arc, nowhere = approach_at(host, wall, place, fourth, left), (0, 0.0, 0, 0.0)
    nothing = no_arc()
    if arc.powers == 0:
        return nothing, 0.0, 0.0, nowhere
    distance = distance_to_others(host, wall, place, arc)
    if not (arc.shrinks < LARGEST_OF_HOST and distance > 0.0):
        return nothing, 0.0, 0.0, nowhere
    solved, ratio, took = solve_short(short, LEVEL.whole, LEVEL.error, arc)
    if not (solved and took < LONGEST_SHORT):
        return nothing, 0.0, 0.0, nowhere
    count = fill_moments(short, wall, arc, (ratio, took))
    ended, ended_x = place_at(grid, begun, begun_x, took * arc.part)
    # the base: the beginning of the long cell of the release, or at least not before the state
    cells = 1 << (grid.levels - grid.long)
    base, shift = max(ended // cells * cells, j), 0.0
    if base == j and x > 0.0:
        base, shift = ended, (x if ended == j else 0.0)
    for i in range(2 * body.size):
        out[i] = y[i]
    if base > j:
        carry(body, grid, scratch, (j, x), (base, shift), out)
    share = ((ended - base) + (ended_x - shift)) / cells
    jump(short, wall, share, count, 2 * body.size, out)
    # the arc's end must be that of the whole state, but for round-off
    put_columns(body, grid, (base, shift), out, scratch.columns)
    expand_long(body, grid, link, scratch.columns, scratch.r)
    r, slope = r_and_slope(scratch.r, share)
    sizes = four(0.0)
    for k in range(0, LONG_TERMS, 4):
        sizes = sizes + larger_of(four(0.0), four_at(scratch.r, k))
    places = abs(walls.gaps[wall]) + sum_of(sizes)
    for i in range(body.size):
        places += abs(body.rows[link * body.size + i] * out[i])
    off = max(abs(walls.signs[wall] * r - walls.gaps[wall]) - ERROR_OF_R * places, 0.0)
    outward = arc.s * ((ratio * ratio) * (ratio * ratio) * ratio)
    duration = took * arc.tick
    off += duration * abs(walls.signs[wall] * slope / short.length + outward)
    if not off <= duration * arc.s * short.arc.tolerance:
        return nothing, 0.0, 0.0, nowhere
    for i in range(2 * body.size):
        y[i] = out[i]
    return arc, took, distance, (ended, ended_x, base, shift)


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
# settled to round-off, as a variation of the speed may be a small difference of its parts. Times
# are in units of L.


@jit
def vary_short(host, varied, wall, arc, took):
    """Carry variations from a touch through its impact; return False if they take more powers.

    took: the duration / tick. The nodes of the impact are overwritten.
    """
    body, short, walls, d = host.body, host.short, host.walls, host.short.numbers
    jet, size, span = short.jet, body.size, took * arc.part
    sign, link, x = walls.signs[wall], walls.links[wall], host.grid.rate * short.length * span
    powers, left = 1, 0.5 * x * x
    while powers < MOST_POWERS and not left < VARIED_TO:
        powers += 1
        left *= x / (powers + 1.0)
    nodes = nodes_of(short.arc, short.arc.levels - 1, LEVEL.whole)
    if not left < VARIED_TO or not settle(d, nodes, arc, FINEST_ERROR):
        return False
    at_end(d, nodes, arc)
    w, n, m, at = nodes.w, nodes.n, nodes.m, nodes.at
    gains, free = np.zeros(powers + 1), np.zeros(powers + 1)  # g_k / g_0, and of a variation
    for k in range(powers + 1):
        kick = from_place(short.kicks, (wall * LONG_TERMS + k) * short.rows)
        gains[k] = sign * along(body, link, kick, 0)[1]
    # f' L^2 times g_0, as the kicks are per g_0
    stiffness = 1.5 * walls.constants[wall].K * walls.inverse[wall] * math.sqrt(arc.depth)
    stiffness *= short.length * short.length
    matrix, gap = np.zeros((n, n)), np.zeros((n, powers + 1))
    linear = np.zeros((powers + 1, powers + 1))  # dJ_k by derivatives of the free gap
    for j in range(n):
        b, t = w[ARC.amplitudes + j], arc.part * w[ARC.times + j]
        push = stiffness * (b * b * w[at + j]) * (arc.part * w[ARC.slope_t + j])
        for i in range(n):
            back, h = arc.part * w[ARC.times + i] - t, 0.0
            for k in range(powers, -1, -1):
                h = (h + gains[k]) * (back / (k + 1.0))
            matrix[i, j] = w[at + (NODES.matrix + j) * m + i] * push * h
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
            w[ARC.slope_b + j] *= (span - arc.part * w[ARC.times + j]) / (k + 1.0)
    for c in range(varied.number):
        row = from_place(varied.rows, 2 * size * c)
        for i in range(2 * size):
            jet[i] = row[i]
        power = sign
        for k in range(powers + 1):
            accelerate(body, jet, k * size, 0.0, jet, (k + 2) * size)
            free[k] = power * along(body, link, jet, k * size)[0]
            power *= short.length
        for i in range(2 * size):
            row[i] = 0.0
        time, duration = 1.0, span * short.length
        for k in range(powers + 1):
            moment, kick = 0.0, (wall * LONG_TERMS + k) * short.rows
            for p in range(powers + 1):
                moment += linear[k, p] * free[p]
            moment /= short.length
            for i in range(2 * size):
                row[i] += time * jet[k * size + i] - moment * short.kicks[kick + i]
            time *= duration / (k + 1.0)
    return True
