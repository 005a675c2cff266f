"""From a state to the next touch of any wall, certified, or to the end of a flight.

A period is divided into cells of several levels, of which 0 is the coarsest (`grid`). In a cell of
some level the ends and the bound of r'''' prove by cubics (`roots`) that no wall is touched; if
they do not, those of its halves may do so. Otherwise the next level is tried. If r only rises to a
wall in a long cell (`grid`), Newton's method locates the touch. In a smallest cell the Taylor
polynomial of r decides (`touch.first_touch`). A touch that is lost there ends the orbit with a
code.

After a short impact the motion goes on from a state that never was, its base: that at the beginning
of the long cell from which free flight leads to the motion after the impact (`host_impact`).
Elsewhere a state is its own base.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import ORDER
from ..numerics.compiling import jit
from ..numerics.elementary import cos_sin_of_turn
from ..numerics.fours import (
    four,
    four_at,
    four_of,
    from_place,
    larger_of,
    number_of,
    put_four,
    roots_of,
    sum_of,
)
from ..numerics.roots import guarded, highest, only_rises
from ..watch.touch import (
    AT_R,
    CLEAR,
    LONGEST_WALK,
    LOST,
    NOWHERE,
    ROUND_OFF,
    UNSURE,
    first_touch,
    nearest_miss,
    outlook,
    tightened,
)
from .body import along, move
from .grid import BLOCK, LONG_TERMS, TERMS_OF_R

SHORTEST_SEARCH = 2.0**-40  # of a cell, in which a touch is searched

FACTORS_OF_SLOPE = np.arange(float(LONG_TERMS + 1))  # k
FACTORS_OF_BEND = np.array([k * (k - 1.0) for k in range(LONG_TERMS)])
BINOMIALS = np.zeros(LONG_TERMS * (LONG_TERMS + 4))
for _p in range(LONG_TERMS):
    for _k in range(LONG_TERMS - _p):
        BINOMIALS[(LONG_TERMS + 4) * _p + _k] = math.comb(_p + _k, _k)
"""(p + k over k), a row for each p: coefficient k about x is their sum with c_(p + k) x^p."""


class Scratch(NamedTuple):
    """Scratch of an orbit; each array is one row, in inner kernels a bare row."""

    begin: Any  # (2 size,) the state at the beginning of a flight
    touch: Any  # (2 size,) that at a touch
    after: Any  # (2 size,) that after a short impact
    # (columns,) the state at the beginning of a cell, the drive behind it, then zeros
    columns: Any
    end: Any  # (columns,) the state at its end
    work: Any  # (3 size + drives,) of `body.move`
    drive: Any  # (drives,) at an instant
    # 8 links: r and s at the beginning of a cell, at its end, and in its middle; bounds of |r''''|
    # [m/s^4] over a coarse cell from there on, and from the base of the last touch (AT_BEGIN ...)
    gaps: Any
    polynomial: Any  # the table of a piece of motion, of which r alone is filled (`touch`)
    r: Any  # (LONG_TERMS + 8,) coefficients of r by the place in a long cell, then zeros


class Sides(NamedTuple):
    """What a flight needs of `Walls`: bare rows alone, whose passing on costs nothing."""

    number: int
    links: Any
    signs: Any
    gaps: Any


@jit
def advance(body, grid, level, columns, out):
    """Write the state at the end of a cell to `out`; columns: `Scratch.columns`."""
    N, count = 2 * body.size, 2 * body.size + grid.drives  # both are even
    w, rows = grid.propagators, (N + 3) // 4 * 4
    at, behind = level * rows * count, rows // BLOCK * BLOCK
    for i in range(0, behind, BLOCK):
        a, b, c = four(0.0), four(0.0), four(0.0)
        for j in range(0, count, 2):  # two columns at a time
            x, v = columns[j], columns[j + 1]
            a = a + (four_at(w, at) * x + four_at(w, at + BLOCK) * v)
            b = b + (four_at(w, at + 4) * x + four_at(w, at + BLOCK + 4) * v)
            c = c + (four_at(w, at + 8) * x + four_at(w, at + BLOCK + 8) * v)
            at += 2 * BLOCK
        put_four(out, i, a)
        put_four(out, i + 4, b)
        put_four(out, i + 8, c)
    for i in range(behind, rows, 4):
        a = four(0.0)
        for j in range(0, count, 2):
            a = a + (four_at(w, at) * columns[j] + four_at(w, at + 4) * columns[j + 1])
            at += 8
        put_four(out, i, a)


@jit
def gap_ahead(body, grid, level, link, columns):
    """Return (r, s) of a link at the end of a cell; columns: `Scratch.columns`."""
    w, count, r, s = grid.ahead, grid.columns, four(0.0), four(0.0)
    at = (level * body.links + link) * 2 * count
    for j in range(0, count, 4):
        x = four_at(columns, j)
        r, s = r + four_at(w, at + j) * x, s + four_at(w, at + count + j) * x
    return sum_of(r), sum_of(s)


# places in `gaps`, in units of links
AT_BEGIN, AT_END, AT_MIDDLE, OF_FOURTH, AT_TOUCH = 0, 2, 4, 6, 7
FLOWN, LOST_TOUCH = -1, -2  # `fly` without a touch: at its stop, or astray


@jit
def look_ahead(body, grid, level, columns, gaps, place):
    """Write r and s of all links at the end of a cell to a place of `gaps`."""
    for link in range(body.links):
        at = place * body.links + 2 * link
        gaps[at], gaps[at + 1] = gap_ahead(body, grid, level, link, columns)


@jit
def bound_of(body, grid, link, y, gaps, drive):
    """Return the bound of |r''''| of a link [m/s^4] over a coarse cell that begins with y."""
    n, D, size, sums = body.modes, grid.drives, body.size, four(0.0)
    row, whole = link * (size + D // 2), n // 4 * 4
    for i in range(0, whole, 4):
        places, rates = four_at(grid.scales, i) * four_at(y, i), four_at(y, size + i)
        norms = roots_of(places * places + rates * rates)
        sums = sums + four_at(grid.fourth, row + i) * norms
    total = sum_of(sums)
    for i in range(whole, n):
        place, rate = grid.scales[i] * y[i], y[body.size + i]
        total += grid.fourth[row + i] * math.sqrt(place * place + rate * rate)
    # links of masses come in the order of the masses, before those without
    for i in range(n, body.size):
        place, rate = grid.scales[i] * gaps[2 * (i - n)], gaps[2 * (i - n) + 1]
        total += grid.fourth[row + i] * math.sqrt(place * place + rate * rate)
    row += body.size
    for i in range(0, D, 2):
        square = drive[i] * drive[i] + drive[i + 1] * drive[i + 1]
        total += grid.fourth[row + i // 2] * math.sqrt(square)
    return total


@jit
def bound_all(body, grid, columns, gaps):
    """Fill the bounds of all links for a coarse cell from `Scratch.columns` on."""
    links, drive = body.links, from_place(columns, 2 * body.size)
    for link in range(links):
        gaps[OF_FOURTH * links + link] = bound_of(body, grid, link, columns, gaps, drive)


@jit
def is_clear(sign, gap, h, gaps, places, fourth):
    """Return True if sign r is proven not to rise to `gap` in a piece of a cell.

    h [s]: its length; places: in `gaps`, those of the link's r and s at its ends; fourth: the bound
    of r'''' times h^4. A start at the gap that moves away is clear.
    """
    at, end = places
    f0, f1 = sign * gaps[at], sign * gaps[end]
    g0, g1 = sign * gaps[at + 1] * h, sign * gaps[end + 1] * h
    if highest(f0, f1, g0, g1, fourth) < gap:
        return True
    slack = 4.0e-16 * (abs(gap) + abs(f0) + abs(g0))
    return f0 <= gap + slack and only_rises(-f0, -f1, -g0, -g1, fourth)


@jit
def are_clear(sides, clearance, level, grid, gaps, links, places):
    """Return True if all walls are proven clear in a piece of a cell, as long as one of a level.

    places: (AT_BEGIN, AT_END) or others, its ends.
    """
    (begin, end), h, proven = places, grid.h * (1 << (grid.levels - level)), True
    h2 = h * h
    for wall in range(sides.number):
        link, gap = sides.links[wall], sides.gaps[wall]
        if clearance is not None:
            gap -= clearance[0]
        at, fourth = 2 * link, gaps[OF_FOURTH * links + link] * (h2 * h2)
        ends = begin * links + at, end * links + at
        proven = proven and is_clear(sides.signs[wall], gap, h, gaps, ends, fourth)
    return proven


@jit
def expand_r(body, grid, link, columns, table):
    """Fill the table with the Taylor polynomial of r over a smallest cell, from `columns` on."""
    count = 2 * body.size + grid.drives
    w, at = grid.polynomials, link * count * TERMS_OF_R
    for first in range(0, TERMS_OF_R, 8):
        a, b = four(0.0), four(0.0)
        for j in range(0, count, 2):
            x, v = columns[j], columns[j + 1]
            row = at + TERMS_OF_R * j + first
            a = a + (four_at(w, row) * x + four_at(w, row + TERMS_OF_R) * v)
            b = b + (four_at(w, row + 4) * x + four_at(w, row + TERMS_OF_R + 4) * v)
        for k in range(4):
            table[AT_R + 4 * (first + k)] = number_of(a, k)
            if first + 4 + k <= ORDER:
                table[AT_R + 4 * (first + 4 + k)] = number_of(b, k)


@jit
def expand_long(body, grid, link, columns, r):
    """Fill the coefficients of r over a long cell, from `columns` on."""
    count = 2 * body.size + grid.drives
    w, at = grid.long_polynomials, link * count * LONG_TERMS
    for first in range(0, LONG_TERMS, 16):
        a, b, c, d = four(0.0), four(0.0), four(0.0), four(0.0)
        row = at + first
        for j in range(count):
            x = columns[j]
            a = a + four_at(w, row) * x
            b = b + four_at(w, row + 4) * x
            c = c + four_at(w, row + 8) * x
            d = d + four_at(w, row + 12) * x
            row += LONG_TERMS
        put_four(r, first, a)
        put_four(r, first + 4, b)
        put_four(r, first + 8, c)
        put_four(r, first + 12, d)


@jit
def slope_four(r, k):
    """Return the coefficients k to k + 3 of the slope of r."""
    return four_at(r, k + 1) * four_at(FACTORS_OF_SLOPE, k + 1)


@jit
def r_and_slope(r, x):
    """Return r and its slope at place x of the expanded long cell."""
    x2 = x * x
    x4 = x2 * x2
    x8 = x4 * x4
    low = (four_at(r, 0) + four_at(r, 4) * x4) + (four_at(r, 8) + four_at(r, 12) * x4) * x8
    high = (four_at(r, 16) + four_at(r, 20) * x4) + (four_at(r, 24) + four_at(r, 28) * x4) * x8
    value = low + high * (x8 * x8)
    low = (slope_four(r, 0) + slope_four(r, 4) * x4) + (
        slope_four(r, 8) + slope_four(r, 12) * x4
    ) * x8
    high = (slope_four(r, 16) + slope_four(r, 20) * x4) + (
        slope_four(r, 24) + slope_four(r, 28) * x4
    ) * x8
    slope = low + high * (x8 * x8)
    powers = four_of(1.0, x, x2, x2 * x)
    return sum_of(value * powers), sum_of(slope * powers)


@jit
def derive(r, k, x):
    """Return the Taylor coefficients k to k + 3, 0 < k < LONG_TERMS, of r about place x."""
    x2, row = x * x, LONG_TERMS + 4
    x4, last = x2 * x2, (LONG_TERMS - k) // 4 * 4
    a, b, c, d = four(0.0), four(0.0), four(0.0), four(0.0)
    for p in range(last, -1, -4):
        at = row * p + k
        a = a * x4 + four_at(BINOMIALS, at) * four_at(r, k + p)
        b = b * x4 + four_at(BINOMIALS, at + row) * four_at(r, k + p + 1)
        c = c * x4 + four_at(BINOMIALS, at + 2 * row) * four_at(r, k + p + 2)
        d = d * x4 + four_at(BINOMIALS, at + 3 * row) * four_at(r, k + p + 3)
    return (a + b * x) + (c + d * x) * x2


@jit
def crossing(r, sign, gap, ends):
    """Return the place in [0, 1] of the expanded long cell where sign r passes a gap, or LOST.

    It rises monotonically and passes it. ends: (f0, f1, f0', f1') of sign r at the ends. As
    `touch.crossing`.
    """
    low, high, (f0, f1, g0, g1), bends = 0.0, 1.0, ends, four(0.0)
    for k in range(0, LONG_TERMS, 4):
        bends = bends + larger_of(four(0.0), four_at(r, k)) * four_at(FACTORS_OF_BEND, k)
    bend, whole = sum_of(bends), f1 - f0
    u = (gap - f0) / whole
    v = 1.0 - u
    x = u * (u * (3.0 - 2.0 * u) + v * (whole / g0 * v - whole / g1 * u))
    for _ in range(LONGEST_WALK):
        x = guarded(x, low, high)
        f, slope = r_and_slope(r, x)
        if sign * f > gap:
            high = x
        else:
            low = x
        change = (sign * f - gap) / (sign * slope)
        x -= change
        if bend * change * change <= ROUND_OFF * (sign * slope):
            return min(max(x, 0.0), 1.0)
    return LOST


@jit
def first_crossing(body, grid, sides, scratch):
    """Return (wall, place) of the first touch in a long cell, or (FLOWN, place) if it is unsure.

    `Scratch.gaps` holds r and s at its ends. Each wall must be proven clear, or passed by a motion
    that only rises. The coefficients of r are those of the wall's link.
    """
    gaps, links, h = scratch.gaps, body.links, grid.h * (1 << (grid.levels - grid.long))
    touched, first, h2, expanded = FLOWN, NOWHERE, h * h, FLOWN
    for wall in range(sides.number):
        link, sign, gap = sides.links[wall], sides.signs[wall], sides.gaps[wall]
        begin, end = 2 * link, AT_END * links + 2 * link
        f0, f1 = sign * gaps[begin], sign * gaps[end]
        g0, g1 = sign * gaps[begin + 1] * h, sign * gaps[end + 1] * h
        foreseen = outlook(gap, f0, f1, g0, g1, gaps[OF_FOURTH * links + link] * (h2 * h2))
        if foreseen == CLEAR:
            continue
        if foreseen == UNSURE:
            return FLOWN, NOWHERE
        expand_long(body, grid, link, scratch.columns, scratch.r)
        place, expanded = crossing(scratch.r, sign, gap, (f0, f1, g0, g1)), wall
        if place == LOST:
            return FLOWN, NOWHERE
        if place < first:
            touched, first = wall, place
    if touched != expanded:
        expand_long(body, grid, sides.links[touched], scratch.columns, scratch.r)
    return touched, first


@jit
def touch_in(walls, wall, end, table):
    """Return the place in [0, end] of the expanded cell where a wall is touched; NOWHERE, LOST."""
    return touch_at(walls.signs[wall], walls.gaps[wall], end, table)


@jit
def touch_at(sign, level, end, table):
    """Return the place of `first_touch` in [0, end] of the expanded cell.

    A motion that begins with a high power of the place is bounded so loosely that the walk may be
    lost. Then shorter pieces are searched one by one, and the table is overwritten.
    """
    bend, jerk = tightened(table, math.inf, math.inf)
    place, begun, length = first_touch(table, 0.0, end, sign, level, bend, jerk), 0.0, 1.0
    while place == LOST or begun > 0.0 or length < 1.0:
        if place == LOST:
            if not length > SHORTEST_SEARCH:
                return LOST
            length *= 0.5
            stretch(table, 0.5)
        elif place < NOWHERE:
            return begun + length * place
        else:
            begun += length
            if not begun < end:
                return NOWHERE
            shift(table)
            length *= 2.0
            stretch(table, 2.0)
        bend, jerk = tightened(table, math.inf, math.inf)
        rest = min(1.0, (end - begun) / length)
        place = first_touch(table, 0.0, rest, sign, level, bend, jerk)
    return place


@jit
def stretch(table, by):
    """Expand r over a piece that is `by` times as long."""
    power = 1.0
    for n in range(ORDER + 1):
        table[AT_R + 4 * n] *= power
        power *= by


@jit
def shift(table):
    """Expand r over the next piece, by repeated synthetic division."""
    for first in range(ORDER):
        for k in range(ORDER - 1, first - 1, -1):
            table[AT_R + 4 * k] += table[AT_R + 4 * (k + 1)]


@jit
def note_miss(walls, wall, clearance, end, table, touches):
    """Lower the smallest near miss to that of a wall in [0, end] of the expanded cell.

    clearance: the smallest near miss [m], and its wall.
    """
    (bend, jerk), gap = tightened(table, math.inf, math.inf), walls.gaps[wall]
    best = gap - clearance[0]
    top = nearest_miss(table, 0.0, walls.signs[wall], end, best, bend, jerk, touches)
    if top > best:
        clearance[0], clearance[1] = gap - top, wall


@jit
def drive_of(grid, j, x, out):
    """Write the drive at place x of smallest cell j to out[: D]."""
    if grid.is_harmonic:
        if x == 0.0:
            out[0], out[1] = grid.phases[2 * j], grid.phases[2 * j + 1]
        else:
            turn = grid.begun + grid.turns * ((j + x) / grid.cells)
            out[0], out[1] = cos_sin_of_turn(turn)
        return
    # a Taylor shift by repeated synthetic division
    D, place = grid.drives, (j + x) / grid.cells
    for k in range(D):
        out[k] = grid.phases[k]
    for first in range(D - 1):
        for k in range(D - 2, first - 1, -1):
            out[k] += place * out[k + 1]


@jit
def put_columns(body, grid, place, y, columns):
    """Write a state y at a place (j, x), and the drive there, to `Scratch.columns`."""
    (j, x), N = place, 2 * body.size
    for i in range(N):
        columns[i] = y[i]
    drive_of(grid, j, x, from_place(columns, N))


@jit
def carry(body, grid, scratch, begun, ended, state):
    """Advance a state from one place (j, x) to another, by the coarsest cells."""
    (j, x), (last, end), y, N = begun, ended, scratch.columns, 2 * body.size
    drive = from_place(y, N)
    for i in range(N):
        y[i] = state[i]
    if x > 0.0:
        drive_of(grid, j, x, drive)
        piece = (end if j == last else 1.0) - x
        move(body, grid.rate, drive, piece * grid.h, y, scratch.work)
        j += 1
    while j < last:
        level, cells = 0, 1 << grid.levels
        while j & (cells - 1) != 0 or j + cells > last:
            level, cells = level + 1, cells >> 1
        drive_of(grid, j, 0.0, drive)
        advance(body, grid, level, y, scratch.end)
        for i in range(N):
            y[i] = scratch.end[i]
        j += cells
    if j == last and end > 0.0:
        drive_of(grid, j, 0.0, drive)
        move(body, grid.rate, drive, end * grid.h, y, scratch.work)
    for i in range(N):
        state[i] = y[i]


@jit
def is_rest_clear(body, grid, sides, scratch, place):
    """Return True if no wall is touched from a place of a long cell on, where none is passed.

    `Scratch.columns` is the base, with the drive there; r is expanded if there is but one link.
    Fills r and s at the end of the cell, and the bounds from the base on.
    """
    gaps, links, r, length = (
        scratch.gaps,
        body.links,
        scratch.r,
        grid.h * (1 << (grid.levels - grid.long)),
    )
    middle, end, columns, proven = AT_MIDDLE * links, AT_END * links, scratch.columns, True
    for link in range(links):
        if links > 1:
            expand_long(body, grid, link, columns, r)
        at = 2 * link
        gaps[at], gaps[at + 1] = r[0], r[1] / length
        value, slope = r_and_slope(r, place)
        gaps[middle + at], gaps[middle + at + 1] = value, slope / length
    bound_all(body, grid, columns, gaps)
    look_ahead(body, grid, grid.long, columns, gaps, AT_END)
    h = (1.0 - place) * length
    h2 = h * h
    for wall in range(sides.number):
        at, sign, gap = 2 * sides.links[wall], sides.signs[wall], sides.gaps[wall]
        gaps[middle + at] = sign * min(sign * gaps[middle + at], gap)
        fourth = gaps[OF_FOURTH * links + sides.links[wall]] * (h2 * h2)
        proven = proven and is_clear(sign, gap, h, gaps, (middle + at, end + at), fourth)
    return proven


@jit
def fly(body, grid, walls, scratch, clearance, begun, stop, state):
    """Fly from a place to the next touch or to the beginning of cell `stop`.

    begun: (j, x) of the place, then of the base of the state (`host_flight`). Returns (wall, j, x,
    place): `state` is advanced to (j, x), from where on the touch is at `place` in units of a long
    cell; if it is not 0, `Scratch.r` is that of the wall's link. The wall is FLOWN at `stop`. With
    a `clearance` it is a flight without touches, of which near misses are noted (`note_misses`).
    """
    j, x, base, shift = begun
    links, gaps, end, y, N = body.links, scratch.gaps, scratch.end, scratch.columns, 2 * body.size
    drive, sides = from_place(y, N), Sides(walls.number, walls.links, walls.signs, walls.gaps)
    has_gaps = False  # whether those at the beginning are of the state y
    for i in range(N):
        y[i] = state[i]
    if base != j or shift != x:
        cells = 1 << (grid.levels - grid.long)
        drive_of(grid, base, shift, drive)
        if shift == 0.0 and base & (cells - 1) == 0:
            has_gaps = is_rest_clear(body, grid, sides, scratch, ((j - base) + x) / cells)
        if has_gaps:
            advance(body, grid, grid.long, y, end)
            for i in range(N):
                y[i] = end[i]
            for i in range(2 * links):
                gaps[i] = gaps[AT_END * links + i]
            j, x = base + cells, 0.0
        else:
            carry(body, grid, scratch, (base, shift), (j, x), state)
    while j < stop:
        drive_of(grid, j, x, drive)
        if x == 0.0:
            if not has_gaps:
                for link in range(links):
                    gaps[2 * link], gaps[2 * link + 1] = along(body, link, y, 0)
            has_gaps, level = True, 0
            while level < grid.levels and j & ((1 << (grid.levels - level)) - 1) != 0:
                level += 1
            bound_all(body, grid, y, gaps)
            look_ahead(body, grid, level, y, gaps, AT_END)
            proven = are_clear(sides, clearance, level, grid, gaps, links, (AT_BEGIN, AT_END))
            while not proven:
                if level == grid.long and clearance is None:
                    wall, place = first_crossing(body, grid, sides, scratch)
                    if wall != FLOWN:
                        for i in range(N):
                            state[i] = y[i]
                        for link in range(links):
                            gaps[AT_TOUCH * links + link] = gaps[OF_FOURTH * links + link]
                        return wall, j, x, place
                if level == grid.levels:
                    break
                # a cell is clear if both halves are, otherwise its first half is the next cell
                look_ahead(body, grid, level + 1, y, gaps, AT_MIDDLE)
                half = level + 1
                first = are_clear(sides, clearance, half, grid, gaps, links, (AT_BEGIN, AT_MIDDLE))
                if first:
                    ends = AT_MIDDLE, AT_END
                    proven = are_clear(sides, clearance, half, grid, gaps, links, ends)
                if not proven:
                    level, proven = half, first
                    for i in range(2 * links):
                        gaps[AT_END * links + i] = gaps[AT_MIDDLE * links + i]
            if proven:
                advance(body, grid, level, y, end)
                for i in range(N):
                    y[i] = end[i]
                for i in range(2 * links):
                    gaps[i] = gaps[AT_END * links + i]
                j += 1 << (grid.levels - level)
                continue
        # a smallest cell, from place x on
        first, touched = 1.0 - x, FLOWN
        for wall in range(sides.number):
            expand_r(body, grid, sides.links[wall], y, scratch.polynomial)
            if clearance is not None:
                note_miss(sides, wall, clearance, first, scratch.polynomial, False)
                continue
            place = touch_in(sides, wall, first, scratch.polynomial)
            if place == LOST:
                return LOST_TOUCH, j, x, 0.0
            if place < first or (place == first and touched == FLOWN):
                first, touched = place, wall
        has_gaps = False
        if x == 0.0 and touched == FLOWN:
            advance(body, grid, grid.levels, y, end)
            for i in range(N):
                y[i] = end[i]
            j += 1
            continue
        move(body, grid.rate, drive, first * grid.h, y, scratch.work)
        if touched == FLOWN:
            j, x = j + 1, 0.0
            continue
        x += first
        if x >= 1.0:
            j, x = j + 1, 0.0
        for i in range(N):
            state[i] = y[i]
        return touched, j, x, 0.0
    for i in range(N):
        state[i] = y[i]
    return FLOWN, j, 0.0, 0.0


@jit
def place_at(grid, j, x, place):
    """Return (cell, place in it) of a `place` in units of long cells from (j, x) on."""
    at = x + place * (1 << (grid.levels - grid.long))
    return j + int(at), at - int(at)


@jit
def expand_at_touch(body, grid, link, scratch, touch, state):
    """Fill `Scratch.r` and the bounds from the state at a touch (j, x) on, as `fly` leaves them."""
    gaps, links = scratch.gaps, body.links
    put_columns(body, grid, touch, state, scratch.columns)
    for one in range(links):
        gaps[2 * one], gaps[2 * one + 1] = along(body, one, state, 0)
    bound_all(body, grid, scratch.columns, gaps)
    for one in range(links):
        gaps[AT_TOUCH * links + one] = gaps[OF_FOURTH * links + one]
    expand_long(body, grid, link, scratch.columns, scratch.r)


@jit
def note_misses(body, grid, walls, scratch, clearance, begun, ended):
    """Lower `clearance` to the near misses of a flight between two (cell, place).

    It begins at the state `scratch.begin`; if it ends within a cell it ends with a touch.
    """
    (j, x), (last, end), y = begun, ended, scratch.begin
    if j < last:
        fly(body, grid, walls, scratch, clearance, (j, x, j, x), last, y)
        x = 0.0
    if end > x:
        put_columns(body, grid, (last, x), y, scratch.columns)
        for wall in range(walls.number):
            expand_r(body, grid, walls.links[wall], scratch.columns, scratch.polynomial)
            note_miss(walls, wall, clearance, end - x, scratch.polynomial, True)
