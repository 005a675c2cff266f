"""Flight under springs that are not linear, in long cells: an integral equation for each.

In a cell of length h, that begins with the state and the drive z, the shortening of a link is

    r(t) = free(t) z - sum over springs of the integral of kappa(t - tau) g(r(tau)) dtau

with kappa(t) = w exp(A t) a, the answer of r to a unit impulse along the spring: exact in all that
is linear. Where g(r(t)) is the polynomial through its values at 16 Gauss nodes, this is

    r = free z + W g(r)    at the nodes        y = P z + M g(r)    at the end of the cell,

which is solved by sweeps, from the solution with four nodes. (Collocation, whose end is of order
32 in h: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.7.)

The error is told by the two last Legendre coefficients of g: r errs by about their size times
h^2 / 256 mu, the end by its square. A cell whose doubt exceeds ACCEPTED sqrt(tolerance) is halved.

Walls are certified. Between neighboring nodes at a distance d, r exceeds the larger of its values
by at most d^2 / 8 max |r''|, and with the norms of pairs (`grid`), which within the cell grow by at
most exp(G h),

    |r''| = |w A^2 y + w A a g| <= second (|y| + h max |g| |a|) + |w A a| max |g|.

A cell where that leaves a doubt is halved, and a short one is stepped (`host_contact`).

A variation moves by the derivative of these equations at the same nodes, with D = g'(r) there:

    (1 - W D) dr = free dz    at the nodes        dy = P dz + M D dr    at the end of the cell.

It is the derivative of the computed motion, so that it errs as that does. One elimination serves
all variations of a cell.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.fours import (
    four,
    four_at,
    larger_of,
    largest_of,
    put_four,
    sum_of,
)
from .body import along
from .cell_constants import CELL_NODES, CELL_SAMPLES, FEW
from .grid import (
    derivative_of,
    exponential,
    grown,
    growth_of,
    matrix_of,
    norms_by_pair,
    pairs_of,
    times,
)

LEVELS = 7  # lengths of cells, each half of the one before
WIDEST = 8.0  # longest cell in units of 1 / rate; a polynomial of degree 31 errs by 4^32 / 32!
STEPPED = 1.0  # longest cell that is stepped if a wall may be touched, in units of 1 / rate
ACCEPTED = 0.01  # doubt of a cell in units of the root of the tolerance
EASY = 1.0e-4  # doubt, relative to that, below which a cell twice as long is tried
SETTLED_SWEEP = 0.01  # change of r by the last sweep in units of the tolerance
MOST_SWEEPS_OF_CELL = 30
FEW_SWEEPS = 4
ROUGH = 0.7  # last coefficient of g at four nodes, relative to g, of a hopeless cell; of r^3 0.4
PATIENCE = 8  # cells before a longer one is tried again after one that was refused
LEAST_PIVOT = 0.05  # of 1 - W D; less is a cell in which the sweeps hardly settle
REACHED = 1.1  # bound of |r| in a cell, in units of its largest value at the nodes
MOST_TERMS = 40  # of a Taylor series over a part of a cell


class SpringCells(NamedTuple):
    """The tables of all lengths of cells, and scratch; each array is one row of numbers."""

    lengths: Any  # (LEVELS,) of cells, in smallest cells
    rows: int  # numbers of a state in whole fours
    total: int  # numbers of a state and of the drive
    free: Any  # levels, links, total: CELL_NODES numbers of r
    free_few: Any  # levels, springs, total: FEW numbers
    answers: Any  # W: levels, links, springs, CELL_NODES columns of CELL_NODES
    answers_few: Any  # levels, springs, springs, FEW columns of FEW
    whole: Any  # P: levels, total columns of `rows`
    ends: Any  # M: levels, springs, CELL_NODES columns of `rows`
    gains: Any  # springs: 1 / mu of the spring [1/kg]
    # without walls no numbers: levels, links, pairs: bounds of |r''| by the norms of pairs, and
    # levels, links, springs: those by the largest |g|
    seconds: Any
    by_force: Any
    scales: Any  # (size,) w of pairs
    forces: Any  # springs * CELL_NODES: g at the nodes
    strokes: Any  # links * CELL_NODES: r at the nodes
    unforced: Any  # springs * CELL_NODES: r without the springs
    few: Any  # springs * 3 FEW: g, r and r without springs at the four nodes
    reach: Any  # springs: bounds of |g| in a cell
    bends: Any  # links: bounds of |r''| in a cell
    norms: Any  # (pairs,)
    begin: Any  # (total + 3,) state and drive at the beginning of a cell
    end: Any  # (rows,) the state at its end
    slopes: Any  # springs * CELL_NODES: g'(r) at the nodes
    # (springs * CELL_NODES)^2 each, by columns: 1 - W D = lower upper, with zeros elsewhere
    lower: Any
    upper: Any
    varied: Any  # springs * CELL_NODES: dr at the nodes, then D dr
    varied_end: Any  # (rows,) a variation at the end of a cell


# ---- tables --------------------------------------------------------------------------------------


@jit
def spread(row, a, by_row, time):
    """Replace a row by row exp(a time), or by exp(a time) row, by the Taylor series."""
    n = len(row)
    term = row.copy()
    for k in range(1, MOST_TERMS):
        following = np.zeros(n)
        for i in range(n):
            if term[i] != 0.0:
                for j in range(n):
                    following[j] += term[i] * (a[i, j] if by_row else a[j, i])
        largest = 0.0
        for j in range(n):
            term[j] = following[j] * (time / k)
            before = row[j]
            row[j] += term[j]
            if row[j] != before:
                largest = 1.0
        if largest == 0.0:
            break


@jit
def impulse_of(body, spring, total):
    """Return the jump (total,) of the state by a unit impulse of a spring."""
    jump = np.zeros(total)
    link = body.springs.links[spring]
    for i in range(body.size):
        jump[body.size + i] = -body.answers[link * body.size + i]
    return jump


@jit
def link_row(body, link, total):
    """Return w (total,) of a link: r by the state and the drive."""
    row = np.zeros(total)
    for i in range(body.size):
        row[i] = body.rows[link * body.size + i]
    return row


@jit
def springs_of_links(body):
    """Return the spring (links,) along each link, -1 along those without one."""
    spring_of = np.full(body.links, -1)
    for spring in range(body.springs.number):
        spring_of[body.springs.links[spring]] = spring
    return spring_of


@jit
def sample_row(row, a, h, places, samples):
    """Fill samples[q] with row exp(a h places[q]), place after place; the row moves along."""
    before = 0.0
    for q in range(len(places)):
        spread(row, a, True, (places[q] - before) * h)
        before = places[q]
        for j in range(len(row)):
            samples[q, j] = row[j]


@jit
def add_at_nodes(samples, shares, count, out, at):
    """Add to out[at :] the columns of `count` values at nodes of what the samples (q, total) say.

    shares: rows of `count` for each sample, the values there by that sample.
    """
    for q in range(samples.shape[0]):
        for j in range(samples.shape[1]):
            for node in range(count):
                out[at + j * count + node] += samples[q, j] * shares[q * count + node]


@jit
def add_folded(kappa, folded, count, out, at):
    """Add to out[at : at + count^2] the table that folds a kappa given at the samples."""
    for q in range(len(kappa)):
        first = q * count * count
        for i in range(count * count):
            out[at + i] += kappa[q] * folded[first + i]


@jit
def fill_ends(body, a, constants, h, ends, at):
    """Add to ends[at :] the columns of M of all springs, in a cell of length h [s]."""
    N = 2 * body.size
    rows = (N + 3) // 4 * 4
    for spring in range(body.springs.number):
        state = impulse_of(body, spring, len(a))
        before = 0.0
        for q in range(CELL_SAMPLES):
            spread(state, a, False, (constants.samples[q] - before) * h)
            before = constants.samples[q]
            for node in range(CELL_NODES):
                weight = h * constants.to_end[q * CELL_NODES + node]
                column = at + (spring * CELL_NODES + node) * rows
                for i in range(N):
                    ends[column + i] += weight * state[i]


@jit
def fill_kappa(samples, jump, h, kappa):
    """Fill kappa[q] with h times the answer of a link at sample q to a unit impulse."""
    N = len(jump)
    for q in range(len(kappa)):
        answer = 0.0
        for j in range(N):
            answer += samples[q, j] * jump[j]
        kappa[q] = h * answer


@jit
def bound_by_force(body, spring, total, slope, bounds, h):
    """Return the bound of |r''| of a link by the largest |g| of a spring, in a cell of h [s].

    slope: w A of the link; bounds: those of |w A^2 y| by the norms of pairs, grown over the cell.
    """
    jump = impulse_of(body, spring, total)
    direct = 0.0
    for i in range(total):
        direct += slope[i] * jump[i]
    later = 0.0
    for i in range(body.size):
        norm = abs(jump[body.size + i])
        if i >= body.modes:
            _, norm = along(body, i - body.modes, jump, 0)
        later += bounds[i] * abs(norm)
    return abs(direct) + h * later


@jit
def spring_cells(body, grid, walls, stops):
    """Return the `SpringCells` of a body, or None without springs that are not linear."""
    if body.springs is None:
        return None
    links = body.links
    springs = body.springs.number
    constants = body.springs.constants
    N = 2 * body.size
    total = N + body.drives
    rows = (N + 3) // 4 * 4
    pairs = body.size + body.drives // 2
    longest = grid.cells / stops
    while longest * grid.h * grid.rate > WIDEST:
        longest *= 0.5
    lengths = np.zeros(LEVELS)
    for level in range(LEVELS):
        lengths[level] = longest
        longest *= 0.5
    has_walls = walls.number > 0
    a = matrix_of(body)
    scales, paired, back = pairs_of(body, a, 0.0)
    growth = growth_of(paired, body.size)
    free = np.zeros(LEVELS * links * total * CELL_NODES)
    free_few = np.zeros(LEVELS * springs * total * FEW)
    answers = np.zeros(LEVELS * links * springs * CELL_NODES * CELL_NODES)
    answers_few = np.zeros(LEVELS * springs * springs * FEW * FEW)
    whole = np.zeros(LEVELS * total * rows)
    ends = np.zeros(LEVELS * springs * CELL_NODES * rows)
    seconds = np.zeros(LEVELS * links * pairs if has_walls else 0)
    by_force = np.zeros(LEVELS * links * springs if has_walls else 0)
    spring_of = springs_of_links(body)
    samples = np.zeros((CELL_SAMPLES, total))
    kappa = np.zeros(CELL_SAMPLES)
    step = exponential(a * (lengths[LEVELS - 1] * grid.h))
    for level in range(LEVELS - 1, -1, -1):
        h = lengths[level] * grid.h
        for j in range(total):
            for i in range(N):
                whole[(level * total + j) * rows + i] = step[i, j]
        if level > 0:
            step = times(step, step)
        fill_ends(body, a, constants, h, ends, level * springs * CELL_NODES * rows)
        for link in range(links):
            own = spring_of[link]
            if own < 0 and not has_walls:
                continue
            sample_row(link_row(body, link, total), a, h, constants.samples, samples)
            at = (level * links + link) * total * CELL_NODES
            add_at_nodes(samples, constants.at_nodes, CELL_NODES, free, at)
            if own >= 0:
                few = (level * springs + own) * total * FEW
                add_at_nodes(samples, constants.at_few, FEW, free_few, few)
            for spring in range(springs):
                fill_kappa(samples, impulse_of(body, spring, total), h, kappa)
                at = ((level * links + link) * springs + spring) * CELL_NODES * CELL_NODES
                add_folded(kappa, constants.folded, CELL_NODES, answers, at)
                if own >= 0:
                    few = ((level * springs + own) * springs + spring) * FEW * FEW
                    add_folded(kappa, constants.folded_few, FEW, answers_few, few)
            if has_walls:
                slope = derivative_of(a, link_row(body, link, total))
                by_pair = norms_by_pair(body, derivative_of(a, slope), scales, back)
                bounds = grown(by_pair, growth, h)
                at = level * links + link
                for pair in range(pairs):
                    seconds[at * pairs + pair] = bounds[pair]
                for spring in range(springs):
                    bound = bound_by_force(body, spring, total, slope, bounds, h)
                    by_force[at * springs + spring] = bound
    gains = np.zeros(springs)
    for spring in range(springs):
        row = body.springs.links[spring] * body.size
        for i in range(body.size):
            gains[spring] += body.rows[row + i] * body.answers[row + i]
    at_nodes = np.zeros(springs * CELL_NODES)
    square = np.zeros(len(at_nodes) * len(at_nodes))
    return SpringCells(
        lengths, rows, total, free, free_few, answers, answers_few, whole, ends, gains, seconds,
        by_force, scales, at_nodes, np.zeros(links * CELL_NODES), at_nodes.copy(),
        np.zeros(springs * 3 * FEW), np.zeros(springs), np.zeros(links), np.zeros(pairs),
        np.zeros(total + 3), np.zeros(rows), at_nodes.copy(), square, square.copy(),
        at_nodes.copy(), np.zeros(rows),
    )  # fmt: skip


# ---- one cell ------------------------------------------------------------------------------------


@jit
def four_forces(springs, spring, r):
    """Return g of a four of r."""
    square = r * r
    inner = four(springs.k3[spring]) + square * springs.k5[spring]
    return square * (four(springs.k2[spring]) + r * inner)


@jit
def guess_few(body, cells, level, z):
    """Solve a cell with four nodes, and fill the forces at all nodes; False if it is hopeless."""
    springs, few, number = body.springs, cells.few, body.springs.number
    for spring in range(number):
        u = four(0.0)
        at = (level * number + spring) * cells.total * FEW
        for j in range(cells.total):
            u = u + four_at(cells.free_few, at + FEW * j) * z[j]
        place = 3 * FEW * spring
        put_four(few, place + 2 * FEW, u)
        put_four(few, place + FEW, u)
        put_four(few, place, four_forces(springs, spring, u))
    for _ in range(FEW_SWEEPS):
        for spring in range(number):
            place = 3 * FEW * spring
            r = four_at(few, place + 2 * FEW)
            for other in range(number):
                of = 3 * FEW * other
                at = ((level * number + spring) * number + other) * FEW * FEW
                low = four_at(cells.answers_few, at) * few[of]
                low = low + four_at(cells.answers_few, at + FEW) * few[of + 1]
                high = four_at(cells.answers_few, at + 2 * FEW) * few[of + 2]
                high = high + four_at(cells.answers_few, at + 3 * FEW) * few[of + 3]
                r = r + (low + high)
            put_four(few, place + FEW, r)
        for spring in range(number):
            place = 3 * FEW * spring
            put_four(few, place, four_forces(springs, spring, four_at(few, place + FEW)))
    refined = springs.constants.refined
    for spring in range(number):
        place = 3 * FEW * spring
        g = four_at(few, place)
        last = abs(sum_of(g * four_at(springs.constants.rough, 0)))
        if not (last < math.inf and last <= ROUGH * largest_of(g)):
            return False
        for i in range(0, CELL_NODES, 4):
            low = (
                four_at(refined, i) * few[place] + four_at(refined, CELL_NODES + i) * few[place + 1]
            )
            high = four_at(refined, 2 * CELL_NODES + i) * few[place + 2]
            high = high + four_at(refined, 3 * CELL_NODES + i) * few[place + 3]
            put_four(cells.forces, CELL_NODES * spring + i, low + high)
    return True


@jit
def add_columns(table, at, width, values, first, count, out, to):
    """Add table columns of `width` numbers times `count` values to out[to : to + width]."""
    for i in range(0, width, 4):
        even = four_at(out, to + i)
        odd = four(0.0)
        place = at + i
        for j in range(0, count, 2):
            even = even + four_at(table, place) * values[first + j]
            odd = odd + four_at(table, place + width) * values[first + j + 1]
            place += 2 * width
        put_four(out, to + i, even + odd)


@jit
def fill_free(cells, level, links, link, z, out, to):
    """Write r of a link at the nodes without springs."""
    at = (level * links + link) * cells.total * CELL_NODES
    for i in range(0, CELL_NODES, 4):
        put_four(out, to + i, four(0.0))
    add_columns(cells.free, at, CELL_NODES, z, 0, cells.total, out, to)


@jit
def sweep_once(body, cells, level):
    """Replace r at the nodes by free z + W g; return (largest change, largest |r|)."""
    springs, number, links = body.springs, body.springs.number, body.links
    change = four(0.0)
    largest = four(0.0)
    for spring in range(number):
        link = springs.links[spring]
        to = CELL_NODES * link
        a = four_at(cells.unforced, CELL_NODES * spring)
        b = four_at(cells.unforced, CELL_NODES * spring + 4)
        c = four_at(cells.unforced, CELL_NODES * spring + 8)
        d = four_at(cells.unforced, CELL_NODES * spring + 12)
        for other in range(number):
            at = ((level * links + link) * number + other) * CELL_NODES * CELL_NODES
            e, f, g, h = four(0.0), four(0.0), four(0.0), four(0.0)
            for j in range(0, CELL_NODES, 2):
                x = cells.forces[CELL_NODES * other + j]
                y = cells.forces[CELL_NODES * other + j + 1]
                a = a + four_at(cells.answers, at) * x
                b = b + four_at(cells.answers, at + 4) * x
                c = c + four_at(cells.answers, at + 8) * x
                d = d + four_at(cells.answers, at + 12) * x
                e = e + four_at(cells.answers, at + 16) * y
                f = f + four_at(cells.answers, at + 20) * y
                g = g + four_at(cells.answers, at + 24) * y
                h = h + four_at(cells.answers, at + 28) * y
                at += 2 * CELL_NODES
            a, b, c, d = a + e, b + f, c + g, d + h
        change = larger_of(change, a - four_at(cells.strokes, to))
        change = larger_of(change, b - four_at(cells.strokes, to + 4))
        change = larger_of(change, c - four_at(cells.strokes, to + 8))
        change = larger_of(change, d - four_at(cells.strokes, to + 12))
        largest = larger_of(larger_of(larger_of(larger_of(largest, a), b), c), d)
        put_four(cells.strokes, to, a)
        put_four(cells.strokes, to + 4, b)
        put_four(cells.strokes, to + 8, c)
        put_four(cells.strokes, to + 12, d)
    for spring in range(number):
        at = CELL_NODES * springs.links[spring]
        for i in range(0, CELL_NODES, 4):
            forces = four_forces(springs, spring, four_at(cells.strokes, at + i))
            put_four(cells.forces, CELL_NODES * spring + i, forces)
    return largest_of(change), largest_of(largest)


@jit
def solve_cell(body, cells, level, h, tolerance):
    """Solve a cell from `cells.begin` on; return its doubt, infinite if it is refused.

    The end is not computed. h: its length [s].
    """
    springs, number, z = body.springs, body.springs.number, cells.begin
    if not guess_few(body, cells, level, z):
        return math.inf
    for spring in range(number):
        link = springs.links[spring]
        fill_free(cells, level, body.links, link, z, cells.unforced, CELL_NODES * spring)
    settled = SETTLED_SWEEP * tolerance
    sweep_once(body, cells, level)
    most = 0.0  # |r| of the last sweep alone: the first ones may be far astray
    before = math.inf
    for sweep in range(MOST_SWEEPS_OF_CELL):
        change, most = sweep_once(body, cells, level)
        is_fast = change < 0.1 * before and change * change <= settled * most * before
        if change <= settled * most or (sweep > 0 and is_fast):
            break
        if sweep == MOST_SWEEPS_OF_CELL - 1 or not change <= 1.0e3 * most:
            return math.inf
        if sweep > 3 and change > 0.5 * before:
            return math.inf
        before = change
    doubt = 0.0
    for spring in range(number):
        low = four(0.0)
        high = four(0.0)
        for i in range(0, CELL_NODES, 4):
            g = four_at(cells.forces, CELL_NODES * spring + i)
            low = low + g * four_at(springs.constants.tails, i)
            high = high + g * four_at(springs.constants.tails, CELL_NODES + i)
        doubt += (abs(sum_of(low)) + abs(sum_of(high))) * cells.gains[spring]
    if not most > 0.0:  # at rest, or no numbers at all, which have no largest one
        return 0.0 if doubt == 0.0 else math.inf
    return doubt * (h * h) / (256.0 * most)


@jit
def end_cell(body, cells, level):
    """Write the state at the end of a solved cell to `cells.end`."""
    rows, number = cells.rows, body.springs.number
    for i in range(0, rows, 4):
        put_four(cells.end, i, four(0.0))
    at = level * cells.total * rows
    add_columns(cells.whole, at, rows, cells.begin, 0, cells.total, cells.end, 0)
    for spring in range(number):
        at = (level * number + spring) * CELL_NODES * rows
        add_columns(
            cells.ends, at, rows, cells.forces, CELL_NODES * spring, CELL_NODES, cells.end, 0
        )


# ---- variations ----------------------------------------------------------------------------------


@jit
def four_slopes(springs, spring, r):
    """Return g' of a four of r."""
    square = r * r
    inner = four(3.0 * springs.k3[spring]) + square * (5.0 * springs.k5[spring])
    return r * (four(2.0 * springs.k2[spring]) + r * inner)


@jit
def subtract_column(column, at, factor, values, to, first, count):
    """Subtract factor times column[at :] from values[to :], from whole fours about `first` on."""
    for i in range(first // 4 * 4, count, 4):
        put_four(values, to + i, four_at(values, to + i) - four_at(column, at + i) * factor)


@jit
def factor_cell(body, cells, level):
    """Fill `lower` and `upper` with the factors of 1 - W D of a solved cell.

    Return False if a pivot is small. Without exchanges of rows: W is nearly triangular, as what
    happens later changes nothing before, and small on its diagonal.
    """
    springs, number, links = body.springs, body.springs.number, body.links
    lower, upper, n = cells.lower, cells.upper, number * CELL_NODES
    for spring in range(number):
        link = springs.links[spring]
        for i in range(0, CELL_NODES, 4):
            slopes = four_slopes(springs, spring, four_at(cells.strokes, CELL_NODES * link + i))
            put_four(cells.slopes, CELL_NODES * spring + i, slopes)
    for j in range(n):
        other = j // CELL_NODES
        for spring in range(number):
            link = springs.links[spring]
            table = ((level * links + link) * number + other) * CELL_NODES * CELL_NODES
            table += (j - other * CELL_NODES) * CELL_NODES
            for i in range(0, CELL_NODES, 4):
                column = four_at(cells.answers, table + i) * -cells.slopes[j]
                put_four(upper, n * j + CELL_NODES * spring + i, column)
        upper[n * j + j] += 1.0
    for i in range(0, n * n, 4):
        put_four(lower, i, four(0.0))
    for k in range(n):
        pivot = upper[n * k + k]
        if not pivot > LEAST_PIVOT:
            return False
        for i in range(k + 1, n):
            lower[n * k + i] = upper[n * k + i] / pivot
            upper[n * k + i] = 0.0
        for j in range(k + 1, n):
            subtract_column(lower, n * k, upper[n * j + k], upper, n * j, k + 1, n)
    return True


@jit
def vary_cell(body, cells, level, rows, count):
    """Carry `count` variations through a solved cell; return False if they stay as they are.

    rows: one variation after the other, 2 size numbers each.
    """
    if not factor_cell(body, cells, level):
        return False
    springs, number, N = body.springs, body.springs.number, 2 * body.size
    lower, upper, n = cells.lower, cells.upper, number * CELL_NODES
    values, end = cells.varied, cells.varied_end
    for c in range(count):
        first = N * c
        for spring in range(number):
            at = (level * body.links + springs.links[spring]) * cells.total * CELL_NODES
            to = CELL_NODES * spring
            for i in range(0, CELL_NODES, 4):
                put_four(values, to + i, four(0.0))
            add_columns(cells.free, at, CELL_NODES, rows, first, N, values, to)
        for k in range(n):
            subtract_column(lower, n * k, values[k], values, 0, k + 1, n)
        for k in range(n - 1, -1, -1):
            solution = values[k] / upper[n * k + k]
            subtract_column(upper, n * k, solution, values, 0, 0, k)
            values[k] = cells.slopes[k] * solution
        for i in range(0, cells.rows, 4):
            put_four(end, i, four(0.0))
        add_columns(
            cells.whole, level * cells.total * cells.rows, cells.rows, rows, first, N, end, 0
        )
        for spring in range(number):
            at = (level * number + spring) * CELL_NODES * cells.rows
            place = CELL_NODES * spring
            add_columns(cells.ends, at, cells.rows, values, place, CELL_NODES, end, 0)
        for i in range(N):
            rows[first + i] = end[i]
    return True


# ---- walls ---------------------------------------------------------------------------------------


@jit
def bound_bends(body, cells, level, h):
    """Fill the bounds of |r''| of all links over a solved cell; False if they do not hold."""
    springs, number, links, size = body.springs, body.springs.number, body.links, body.size
    z, norms, pairs = cells.begin, cells.norms, body.size + body.drives // 2
    for i in range(size):
        x = z[i]
        v = z[size + i]
        if i >= body.modes:
            x, v = along(body, i - body.modes, z, 0)
        x *= cells.scales[i]
        norms[i] = math.sqrt(x * x + v * v)
    for i in range(size, pairs):
        x = z[2 * i]
        v = z[2 * i + 1]
        norms[i] = math.sqrt(x * x + v * v)
    for spring in range(number):
        link = springs.links[spring]
        top = largest_stroke(body, cells, link)
        reach = REACHED * top
        square = reach * reach
        inner = abs(springs.k3[spring]) + square * abs(springs.k5[spring])
        cells.reach[spring] = square * (abs(springs.k2[spring]) + reach * inner)
    for link in range(links):
        at = level * links + link
        bound = 0.0
        for pair in range(pairs):
            bound += cells.seconds[at * pairs + pair] * norms[pair]
        for spring in range(number):
            bound += cells.by_force[at * number + spring] * cells.reach[spring]
        cells.bends[link] = bound
    widest = springs.constants.nodes[CELL_NODES // 2] - springs.constants.nodes[CELL_NODES // 2 - 1]
    for spring in range(number):
        link = springs.links[spring]
        top = largest_stroke(body, cells, link)
        excess = 0.125 * (widest * h) * (widest * h) * cells.bends[link]
        if not top + excess <= REACHED * top:
            return False
    return True


@jit
def largest_stroke(body, cells, link):
    """Return the largest |r| of a link at the nodes and ends of a solved cell."""
    first, _ = along(body, link, cells.begin, 0)
    last, _ = along(body, link, cells.end, 0)
    top = max(abs(first), abs(last))
    for i in range(0, CELL_NODES, 4):
        top = max(top, largest_of(four_at(cells.strokes, CELL_NODES * link + i)))
    return top


@jit
def is_cell_clear(body, walls, cells, level, h, margin):
    """Return True if r stays `margin` [m] away from all walls in a solved cell.

    Proven by the bounds of |r''|.
    """
    number, links, nodes = body.springs.number, body.links, body.springs.constants.nodes
    for link in range(links):
        is_sprung = False
        for spring in range(number):
            is_sprung = is_sprung or body.springs.links[spring] == link
        if is_sprung:
            continue
        fill_free(cells, level, links, link, cells.begin, cells.strokes, CELL_NODES * link)
        for spring in range(number):
            at = ((level * links + link) * number + spring) * CELL_NODES * CELL_NODES
            values, first = cells.forces, CELL_NODES * spring
            to = CELL_NODES * link
            add_columns(cells.answers, at, CELL_NODES, values, first, CELL_NODES, cells.strokes, to)
    if not bound_bends(body, cells, level, h):
        return False
    for wall in range(walls.number):
        link, sign, gap = walls.links[wall], walls.signs[wall], walls.gaps[wall] - margin
        r, _ = along(body, link, cells.begin, 0)
        last, _ = along(body, link, cells.end, 0)
        before = sign * r
        place = 0.0
        for i in range(CELL_NODES + 1):
            now = sign * (cells.strokes[CELL_NODES * link + i] if i < CELL_NODES else last)
            following = nodes[i] if i < CELL_NODES else 1.0
            d = (following - place) * h
            if not max(before, now) + 0.125 * (d * d) * cells.bends[link] < gap:
                return False
            before = now
            place = following
    return True
