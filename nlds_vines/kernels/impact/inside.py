"""Inside a short impact, which is solved from touch to release: what is asked there is stepped.

The orbit goes on behind an impact as it is solved. Where a section cuts it, or an energy may be
largest in it, or a response is wanted, it is stepped beside that, from the end that is nearer:
backward in time an impact is an impact again, in which velocities and the dashpots' forces have
other signs, and the phase runs back. What was found is kept for the last few impacts: of a settled
orbit nothing is stepped.

An energy can peak where its power falls through zero. Where the contact's force is larger than all
others it only makes an energy dip, so that a peak is near the touch or near the release.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..events.contact import Steps, contact
from ..motion.response_sums import BEFORE, BEGIN, MOST, SUMS, raise_to
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.fours import four, four_at, put_four
from ..numerics.matrices import solve
from ..scene.arguments import Watch, side_with
from ..scene.drive import Moment, backward, drive_now, later
from ..scene.scene import Damper, Ground, Structure
from ..watch.observe import energies_of, powers_of, raise_energies
from .arc_table import INSIDE
from .impact import LASTING, short_impact
from .impact_response import tally_nodes
from .impact_variations import vary

# Of each of the last few impacts, in the scratch of the arc's table: (s, x1, v1, cos, sin) at
# touch; from RISES_KEPT on, by how much E1 and E2 rise above those at touch and those at release;
# from SHARE_KEPT on, its share of a response, a tally's row up to BEGIN; from CUT on, when it was
# cut and (q, s, x1, v1) there; and what unit variations (16,) become from touch TO the cut, and
# from there ON. What is not known is NaN. Behind them: which of them is the next to be forgotten,
# and variations that wait.
RISES_KEPT, SHARE_KEPT, CUT, TO, ON, EACH, KEPT = 5, 9, 29, 34, 50, 66, 4
NEXT_KEPT, WAIT = INSIDE + EACH * KEPT, INSIDE + EACH * KEPT + 1
SAME = 0.3  # change of an impact with which it is the same, in units of what sweeps may leave of it
GROWS = 2.0  # largest force beside the contact's in an impact, in units of that at its ends
# How variations are stepped, driven ones of an impact that is solved, too, in units of the orbit's
# own tolerance, and at most: what K drives, all of which is made in impacts, errs by 1e-9 then, all
# others by 1e-11, or by the tolerance if that is less.
SURER, VERIFIED = 0.1, 2.5e-11


class Ahead(NamedTuple):
    """An impact that is solved while the orbit is inside it, all as at a near wall.

    took [s] is 0 where there is none.
    """

    took: float  # from touch to release [s]
    elapsed: float  # since touch [s]
    depth: float  # the greatest [m], 0 if it is not wanted
    touch: tuple[float, float, float]  # s, x1, v1
    release: tuple[float, float, float]


@jit
def read_ahead(numbers, at):
    """Return the `Ahead` that is kept in an array from a place on."""
    i = at
    return Ahead(
        numbers[i], numbers[i + 1], numbers[i + 2],
        (numbers[i + 3], numbers[i + 4], numbers[i + 5]),
        (numbers[i + 6], numbers[i + 7], numbers[i + 8]),
    )  # fmt: skip


@jit
def keep_ahead(numbers, at, ahead):
    """Keep an `Ahead` in an array from a place on."""
    numbers[at], numbers[at + 1], numbers[at + 2] = ahead.took, ahead.elapsed, ahead.depth
    for i in range(3):
        numbers[at + 3 + i], numbers[at + 6 + i] = ahead.touch[i], ahead.release[i]


@jit
def side_backward(side):
    """Return a side backward in time: dashpots push."""
    ps = side.ps
    turned = Structure(
        ps.m1, ps.k1, ps.stiffness, -ps.damping, ps.force, ps.omega, ps.load, ps.shaken
    )
    return side_with(side, turned, joint_backward(side.damper), side.wall, side.steps)


@jit
def joint_backward(damper):
    """Return the damper backward in time; the ground, which has no dashpot, as it is."""
    if is_a(damper, Ground):
        return damper
    return Damper(
        damper.m2, damper.k2, -damper.c2, damper.inv_m1, damper.inv_mu, damper.share, damper.rest
    )


@jit
def from_release(side, phase, ahead):
    """Return (side, phase, (q, s, x1, v1)) at the release of an impact, backward in time.

    phase: the instant (`drive`) of its touch, here and below.
    """
    s, x1, v1 = ahead.release
    then = backward(later(side.ps, phase, ahead.took))
    return side_backward(side), then, (0.0, -s, x1, -v1)


@jit
def place_of(side, phase, touch):
    """Return where the table keeps what is known of an impact, of which nothing is if it is new.

    As each is under a load, which does not come again. touch: (s, x1, v1).
    """
    if is_a(phase, Moment):
        return new_place(side.arc.table)
    w, (s, x1, v1), (c, d), rate = side.arc.table, touch, phase, side.rate
    scale = abs(s) + abs(v1) + rate * abs(x1)
    for i in range(KEPT):
        at = INSIDE + EACH * i
        apart = abs(w[at] - s) + rate * abs(w[at + 1] - x1) + abs(w[at + 2] - v1)
        apart += scale * (abs(w[at + 3] - c) + abs(w[at + 4] - d))
        if apart <= SAME * side.arc.settled * scale:
            return at
    at = new_place(w)
    w[at], w[at + 1], w[at + 2], w[at + 3], w[at + 4] = s, x1, v1, c, d
    return at


@jit
def new_place(w):
    """Return the next place of the table `w`, where nothing is known."""
    at = INSIDE + EACH * int(w[NEXT_KEPT])
    w[NEXT_KEPT] = w[NEXT_KEPT] + 1.0 if w[NEXT_KEPT] < KEPT - 1.0 else 0.0
    for i in range(RISES_KEPT, EACH):
        w[at + i] = math.nan
    return at


# ---- energies ------------------------------------------------------------------------------------


@jit
def where_peaks_are(side, energy, phase, ahead):
    """Return how long after the touch, and before the release, an energy may peak in an impact [s].

    0 where none can exceed the largest so far. It is at most the time to the depth at which the
    contact pushes as hard as all other forces, a share x^(2/3) of the greatest where those are a
    share x of its largest force, which is bounded by sqrt(x) of the impact. And there is no peak
    where an energy falls from the end on and neither the velocity nor those forces change their
    sign.
    """
    ps, damper, gap = side.ps, side.damper, side.wall.gap
    took, (s, x, v), (u, y, w) = ahead.took, ahead.touch, ahead.release
    f = powers_of(ps, damper, x, v, gap, s, drive_now(phase))
    g = powers_of(ps, damper, y, w, gap, u, drive_now(later(ps, phase, took)))
    e0, e1 = energies_of(ps, damper, x, v, gap, s), energies_of(ps, damper, y, w, gap, u)
    deep = took * max(s, -u) / LASTING
    early, late, longest = False, False, 0.0
    for i in range(2):
        v, n, w, m = f[2 * i], f[2 * i + 1], g[2 * i], g[2 * i + 1]
        push, steady = GROWS * max(abs(n), abs(m)), n * m > 0.0
        soon = took * min(math.sqrt(push / (side.wall.K * deep * math.sqrt(deep))), 1.0)
        lost = push * soon / (ps.m1 if i == 0 else damper.m2)
        falls = steady and v * n < 0.0 and abs(v) > lost
        early = early or (not falls and e0[i] + push * (abs(v) + 2.0 * lost) * soon > energy[i])
        falls = steady and w * m > 0.0 and abs(w) > lost
        late = late or (not falls and e1[i] + push * (abs(w) + 2.0 * lost) * soon > energy[i])
        longest = max(longest, soon)
    return longest if early else 0.0, longest if late else 0.0


@jit
def note_end(side, energy, phase, now, soon, at):
    """Raise the largest energies to those within a time `soon` [s] of one end of an impact.

    now: (q, s, x1, v1) there, phase: the instant; at: where the rises are kept.
    """
    w, (_, s, x1, v1) = side.arc.table, now
    e = energies_of(side.ps, side.damper, x1, v1, side.wall.gap, s)
    if not w[at] >= 0.0:
        before = energy[0], energy[1]
        energy[0], energy[1] = e
        contact(side, Watch(None, energy, None, None, None, None), phase, now, soon)
        w[at], w[at + 1] = energy[0] - e[0], energy[1] - e[1]
        energy[0], energy[1] = before
    raise_energies(energy, (e[0] + w[at], e[1] + w[at + 1]))


@jit
def note_inside(side, energy, phase, ahead, now, lasting):
    """Raise the largest energies to their maxima in the next `lasting` [s] of a solved impact.

    ahead: `Ahead`; now: (q, s, x1, v1) at present.
    """
    early, late = where_peaks_are(side, energy, phase, ahead)
    if not early + late > 0.0:
        return
    if ahead.elapsed > 0.0 or lasting < ahead.took:
        then = later(side.ps, phase, ahead.elapsed)
        contact(side, Watch(None, energy, None, None, None, None), then, now, lasting)
        return
    at = place_of(side, phase, ahead.touch) + RISES_KEPT
    if early > 0.0:
        note_end(side, energy, phase, now, early, at)
    if late > 0.0:
        other, wave, then = from_release(side, phase, ahead)
        note_end(other, energy, wave, then, late, at + 2)


# ---- states and variations -----------------------------------------------------------------------


@jit
def state_inside(side, phase, ahead, time):
    """Return (q, s, x1, v1) a `time` [s] after the touch of an impact that is solved.

    phase: (cos, sin) at touch.
    """
    none = Watch(None, None, None, None, None, None)
    (s, x1, v1), sign = ahead.touch, 1.0
    now, left = (0.0, s, x1, v1), time
    if time + time > ahead.took:
        side, phase, now = from_release(side, phase, ahead)
        sign, left = -1.0, ahead.took - time
    if not left > 0.0:
        return now[0], sign * now[1], now[2], sign * now[3]
    _, q, s, x1, v1, _, _ = contact(side, none, phase, now, left)
    return q, sign * s, x1, sign * v1


@jit
def place_of_cut(side, phase, ahead):
    """Return where the table keeps an impact which a section cuts, with the state that it has then.

    phase: (cos, sin) at its touch; the section is `ahead.elapsed` later.
    """
    w, at = side.arc.table, place_of(side, phase, ahead.touch)
    if not abs(w[at + CUT] - ahead.elapsed) <= SAME * side.arc.settled * ahead.took:
        q, s, x1, v1 = state_inside(side, phase, ahead, ahead.elapsed)
        w[at + CUT], w[at + TO], w[at + ON] = ahead.elapsed, math.nan, math.nan
        w[at + CUT + 1], w[at + CUT + 2], w[at + CUT + 3], w[at + CUT + 4] = q, s, x1, v1
    return at


@jit
def state_at_section(side, phase, ahead):
    """Return (q, s, x1, v1) of a solved impact at a section, `ahead.elapsed` after its touch.

    phase: (cos, sin) at touch.
    """
    w, at = side.arc.table, place_of_cut(side, phase, ahead) + CUT + 1
    return w[at], w[at + 1], w[at + 2], w[at + 3]


@jit
def variations_finely(side):
    """Return a side with steps that are fine enough for variations."""
    steps = side.steps
    fine = Steps(steps.per_impact, min(SURER * steps.tolerance, VERIFIED))
    return side_with(side, side.ps, side.damper, side.wall, fine)


@jit
def put_unit(tangent):
    """Make four variations (16,) the unit ones."""
    for i in range(16):
        tangent[i] = 1.0 if i % 5 == 0 else 0.0


@jit
def turn(tangent):
    """Change the signs of v1 and s of four variations: of time."""
    for i in range(1, 16, 2):
        tangent[i] = -tangent[i]


@jit
def carry_by(w, at, tangent):
    """Carry four variations (16,); what the unit ones become stands in an array from `at` on."""
    for i in range(0, 16, 4):
        sums = four(0.0)
        for j in range(4):
            sums = sums + tangent[i + j] * four_at(w, at + 4 * j)
        put_four(tangent, i, sums)


@jit
def vary_to_cut(side, phase, ahead, tangent):
    """Step unit variations `tangent` (16,) from the nearer end of an impact to where it is cut.

    Returns whether that is the touch; phase: (cos, sin) there.
    """
    s, x1, v1 = ahead.touch
    now, left = (0.0, s, x1, v1), ahead.elapsed
    early = left + left <= ahead.took
    put_unit(tangent)
    if not early:
        side, phase, now = from_release(side, phase, ahead)
        left = ahead.took - left
        turn(tangent)
    watch = Watch(None, None, None, None, tangent, None)
    contact(variations_finely(side), watch, phase, now, left)
    if not early:
        turn(tangent)
    return early


@jit
def cut_in_two(side, phase, ahead, tangent, at):
    """Fill what unit variations become up to the section that cuts an impact, and from there on.

    The impact is a matrix R, a row for each unit variation, and the section cuts it into R = F S.
    One of F and the inverse of S is stepped, the other follows. tangent (16,): scratch; phase:
    (cos, sin) at touch; at: `place_of_cut`.
    """
    w, (s, x1, v1), (out, a1, b1) = side.arc.table, ahead.touch, ahead.release
    put_unit(tangent)
    short_impact(side, None, phase, (0.0, s, x1, v1))
    vary(side, phase, ahead.touch, (out, a1, b1, ahead.took), tangent)
    for i in range(16):
        w[at + ON + i] = tangent[i]  # R, for now
    early = vary_to_cut(side, phase, ahead, tangent)
    matrix, right = np.empty((4, 4)), np.empty((4, 4))
    for i in range(16):
        w[at + TO + i], matrix[i // 4, i % 4] = tangent[i], tangent[i]
        right[i // 4, i % 4] = w[at + ON + i]
    if not early:
        for i in range(16):
            tangent[i] = w[at + ON + i]
            right[i // 4, i % 4] = 1.0 if i % 5 == 0 else 0.0
        carry_by(w, at + TO, tangent)
        for i in range(16):
            w[at + TO + i] = tangent[i]
    solve(matrix, right)
    for i in range(16):
        w[at + ON + i] = right[i // 4, i % 4]


@jit
def vary_inside(side, phase, tangent, ahead, begins):
    """Carry four variations (16,) from touch to the section that cuts an impact, or on from there.

    To it where the impact `begins`. ahead: `Ahead`, the section being `ahead.elapsed` after touch;
    phase: (cos, sin) at touch. Variations are linear: what unit ones become is kept.
    """
    w, at = side.arc.table, place_of_cut(side, phase, ahead)
    if not abs(w[at + TO]) < math.inf:
        for i in range(16):
            w[WAIT + i] = tangent[i]
        cut_in_two(side, phase, ahead, tangent, at)
        for i in range(16):
            tangent[i] = w[WAIT + i]
    carry_by(w, at + (TO if begins else ON), tangent)


# ---- a response ----------------------------------------------------------------------------------


@jit
def tally_inside(side, tally, phase, now, after):
    """Add an impact that is solved to a tally.

    phase: the instant of its touch; now, after: as of `tally_nodes`. Under the harmonic force it is
    stepped once, and kept; under a load, where none comes again, it is stepped if it has to be.
    """
    if is_a(phase, Moment):
        return tally_once(side, tally, phase, now, after)
    w, row = side.arc.table, tally.row
    at = place_of(side, phase, (now[1], now[2], now[3])) + SHARE_KEPT
    if not w[at] >= 0.0:
        for i in range(BEGIN):
            row[BEFORE + i], row[i] = row[i], 0.0
        contact(side, Watch(None, None, None, None, None, tally), phase, now, math.inf)
        for i in range(BEGIN):
            w[at + i], row[i] = row[i], row[BEFORE + i]
    for i in range(SUMS):
        row[i] += w[at + i]
    for i in range(MOST, BEGIN):
        raise_to(row, i, w[at + i])


@jit
def tally_once(side, tally, phase, now, after):
    """Add an impact to a tally as one that does not come again."""
    if not tally_nodes(side, tally, phase, now, after):
        contact(side, Watch(None, None, None, None, None, tally), phase, now, math.inf)
