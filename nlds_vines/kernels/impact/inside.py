"""Inside a short impact: half of it, solved, and its largest energies.

At the ends of an arc a collocation is far better than between its nodes. But on half an arc, from
touch to deepest point, the polynomials through n nodes and both ends converge like 3.6^-n, since
the singularities of the arc lie beside its deepest point. From there to the release the impact is
solved backward in time, where it is an impact again: velocities and the dashpots' forces change
their signs, and the phase runs back. The tolerance chooses the number of nodes. A state at any time
is read off such a half, too (`state_inside`).

A value at place x from -1 to 1 is read off by the barycentric formula
sum(q_i y_i) / sum(q_i), q_i = weight_i / (x - x_i)  (Berrut, Trefethen: SIAM Review 46 (2004) 501).

An energy can peak where its power falls through zero. The contact's force alone only makes it dip,
so that a peak is near the touch, where the power is positive there, or near the release, where it
is negative.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.fours import four, four_at, put_four, sum_of
from ..numerics.roots import narrowed, secant
from ..scene.arguments import side_with
from ..scene.drive import cos_sin, rotated
from ..scene.scene import Damper, Ground, Structure, finite
from ..watch.observe import energies_of, powers_of
from .impact import (
    HALF,
    INSIDE,
    MATRIX,
    MISSED,
    ROW,
    Approach,
    B,
    G,
    H,
    Nodes,
    S,
    T,
    U,
    approach_of,
    at_end,
    nodes_of,
    settle,
)

# Places are the touch, the nodes and the deepest point. Rows of k numbers, k = n + 2 in fours:
PLACE, BARYCENTRIC, ONWARD = range(3)  # constants of a half, behind all others; weights from
# the first node on
WEIGHED = INSIDE  # scratch: the weights at a place; values of five quantities there
FIRST, SECOND, THIRD, FOURTH, FIFTH = (INSIDE + ROW * (1 + i) for i in range(5))
TOUCH, RELEASE = 0, 1  # the ends; int() keeps each from its own compilation
# the last half of each end whose energies were looked for: s, v1, x1, cos, sin, and what E1 and E2
# rise above their values there, NaN if unknown
LAST = INSIDE + ROW * 6
# the last impact that a section cut: s, x1, v1, cos, sin at touch, time since; q, s, x1, v1 there
CUT = LAST + 16

ROOT_STEPS = 40  # of the search for a place: it needs some six
PRECISE = 1.0e-7  # error of the place of a peak: its height errs by the square
SETTLED = (
    0.1  # what sweeps may leave, in units of what those of an impact may: nodes keep all of it
)
SAME = 1.0e-3  # change of an impact in units of the tolerance with which it is the same
RISE = 2.0  # largest power of the other forces in an impact, in units of that at its ends


class Ahead(NamedTuple):
    """An impact that is solved while the orbit is inside it, all as at a near wall.

    took [s] is 0 where there is none.
    """

    took: float  # from touch to release [s]
    elapsed: float  # since touch [s]
    depth: float  # the greatest [m], 0 if it is not wanted
    touch: tuple[float, float, float]  # s, x1, v1
    release: tuple[float, float, float]


class Half(NamedTuple):
    """Half an impact, solved: from touch, or backward in time from release."""

    ps: Structure
    damper: Damper
    approach: Approach
    nodes: Nodes
    k: int  # places in whole fours
    places: int  # where their constants are
    time: float  # to the deepest point [s]


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
def backward(side):
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
def half_impact(side, phase, state):
    """Return the half of an impact that begins with a state (s, x1, v1), solved.

    phase: (cos, sin) of the forcing's. With nodes for all that may be asked of it.
    """
    approach = approach_of(side.ps, side.damper, side.wall, phase, state)
    arc = side.arc
    return solved_half(side, approach, arc.inside, SETTLED * arc.settled)


@jit
def solved_half(side, approach, level, settled):
    """Return the half of an impact, solved with the nodes of one level until they are settled."""
    ps, damper, wall = side.ps, side.damper, side.wall
    nodes = nodes_of(side.arc, level, int(HALF))
    settle(ps, damper, wall, nodes, approach, settled)
    ratio, time, x, v, _ = at_end(ps, damper, wall, nodes, approach)
    w, n = nodes.w, nodes.n
    # the ends of the rows: what follows node n - 1 is the deepest point
    w[B + n], w[T + n], w[G + n], w[H + n] = approach.b * ratio, time, x, v
    k, places = (n + 5) // 4 * 4, nodes.at + (MATRIX + n) * nodes.m + 3 * MISSED
    return Half(ps, damper, approach, nodes, k, places, time)


@jit
def keep(half, row, at_touch, unknown):
    """Fill a scratch row of places with an unknown at touch, at the nodes and at the end."""
    w, n = half.nodes.w, half.nodes.n
    w[row] = at_touch
    for i in range(n + 1):
        w[row + 1 + i] = w[unknown + i]


@jit
def weigh(half, x):
    """Fill the row WEIGHED with the barycentric weights of the places at x; return their sum.

    At a place itself all of the weight is its own.
    """
    w, place, weight = half.nodes.w, half.places, half.places + BARYCENTRIC * half.k
    for i in range(half.nodes.n + 2):
        if w[place + i] == x:
            for j in range(half.k):
                w[WEIGHED + j] = 0.0
            w[WEIGHED + i] = 1.0
            return 1.0
    total = four(0.0)
    for i in range(0, half.k, 4):
        q = four_at(w, weight + i) / (x - four_at(w, place + i))
        put_four(w, WEIGHED + i, q)
        total = total + q
    return sum_of(total)


@jit
def value(half, row, total):
    """Return the value of a row of places where `weigh` returned `total`."""
    w, found = half.nodes.w, four(0.0)
    for i in range(0, half.k, 4):
        found = found + four_at(w, WEIGHED + i) * four_at(w, row + i)
    return sum_of(found) / total


# ---- energies ------------------------------------------------------------------------------------


@jit
def fill_energies(wall, half):
    """Fill the rows FIRST ... FOURTH with E1, its power, E2 and its power at all places."""
    ps, damper, approach, w, n = half.ps, half.damper, half.approach, half.nodes.w, half.nodes.n
    at, m, share = half.nodes.at, half.nodes.m, damper.share
    for i in range(0, m, 4):
        b, u = four_at(w, B + i), four_at(w, at + U * m + i)
        b2 = b * b
        b4, u2 = b2 * b2, u * u
        z, s = b4 * u2, (wall.speed * (b4 * b)) * four_at(w, at + S * m + i)
        cosine, sine = cos_sin(ps.omega * four_at(w, T + i))
        drive = approach.c * cosine - approach.d * sine
        x1, v1 = four_at(w, G + i) + share * z, four_at(w, H + i) + share * s
        e1, e2 = energies_of(ps, damper, x1, v1, wall.gap + z, s)
        force = wall.K * (b4 * b2) * (u2 * u)
        v1, n1, v2, n2 = powers_of(ps, damper, x1, v1, wall.gap + z, s, drive, force)
        put_four(w, FIRST + 1 + i, e1)
        put_four(w, SECOND + 1 + i, v1 * n1)
        put_four(w, THIRD + 1 + i, e2)
        put_four(w, FOURTH + 1 + i, v2 * n2)
    keep(half, int(FIFTH), 0.0, int(T))
    v1 = approach.v + share * approach.s
    fill_place(half, wall, 0, 0.0, 0.0, approach.s, approach.x, v1)
    b = w[B + n]
    z = (b * b) * (b * b)
    fill_place(half, wall, n + 1, w[T + n], z, 0.0, w[G + n] + share * z, w[H + n])


@jit
def fill_place(half, wall, i, time, z, s, x1, v1):
    """Fill place i of the rows FIRST ... FOURTH from a state at a `time` [s] and depth z [m]."""
    ps, damper, w = half.ps, half.damper, half.nodes.w
    cosine, sine = cos_sin(ps.omega * time)
    drive = half.approach.c * cosine - half.approach.d * sine
    w[FIRST + i], w[THIRD + i] = energies_of(ps, damper, x1, v1, wall.gap + z, s)
    force = wall.K * z * math.sqrt(z)
    v1, n1, v2, n2 = powers_of(ps, damper, x1, v1, wall.gap + z, s, drive, force)
    w[SECOND + i], w[FOURTH + i] = v1 * n1, v2 * n2


@jit
def note_if_within(half, energy, body, span, time, e):
    """Raise an energy to e [J] if the time [s] since the half's beginning is in a span."""
    if span[0] <= time <= span[1]:
        energy[body] = max(energy[body], e)


@jit
def note_peaks_of(half, energy, body, span):
    """Raise an energy to its peaks at and between the places of a half that are in a span."""
    w, e, p = half.nodes.w, FIRST + 2 * ROW * body, SECOND + 2 * ROW * body
    for i in range(half.nodes.n + 1):
        note_if_within(half, energy, body, span, w[FIFTH + i], w[e + i])
        f0, f1 = w[p + i], w[p + i + 1]
        if f0 > 0.0 and f1 < 0.0:
            low, high = w[half.places + i], w[half.places + i + 1]
            total = 1.0
            for _ in range(ROOT_STEPS):
                x = secant(low, high, f0, f1)
                total = weigh(half, x)
                f = value(half, p, total)
                if f == 0.0 or min(x - low, high - x) < PRECISE:
                    break
                low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
            time, top = value(half, int(FIFTH), total), value(half, e, total)
            note_if_within(half, energy, body, span, time, top)


@jit
def peaks_in_doubt(side, energy, before, after, ahead):
    """Return in which half of an impact which energy may peak above the largest so far.

    Bit body + 2 half. before, after: cos of the phase at touch and at release. The contact's force
    alone makes an energy dip, and the other forces hardly change: a peak follows the touch if their
    power is positive there, and precedes the release if it is negative there, unless they or the
    velocity change sign in between. The rise above the end is at most RISE times their power times
    the time.
    """
    ps, damper, wall = side.ps, side.damper, side.wall
    s, x, v = ahead.touch
    took, at_touch = ahead.took, powers_of(ps, damper, x, v, wall.gap, s, before, 0.0)
    e0 = energies_of(ps, damper, x, v, wall.gap, s)
    s, x, v = ahead.release
    at_release = powers_of(ps, damper, x, v, wall.gap, s, after, 0.0)
    e1 = energies_of(ps, damper, x, v, wall.gap, s)
    found = 0
    for body in range(2):
        v0, n0 = at_touch[2 * body], at_touch[2 * body + 1]
        v1, n1 = at_release[2 * body], at_release[2 * body + 1]
        p0, p1 = v0 * n0, v1 * n1
        rise = RISE * max(abs(p0), abs(p1)) * took
        turn = max(abs(n0), abs(n1)) * took / (ps.m1 if body == 0 else damper.m2)
        unsure = not n0 * n1 > 0.0 or min(abs(v0), abs(v1)) <= turn
        if e0[body] + rise > energy[body] and (unsure or p0 > 0.0):
            found |= 1 << body
        if e1[body] + rise > energy[body] and (unsure or p1 < 0.0):
            found |= 4 << body
    return found


@jit
def is_known(side, energy, end, phase, state, bodies):
    """Tell whether a half is all but the last one of its end, and note its energies from there.

    end: TOUCH or RELEASE; bodies: those in doubt. What an energy rises above its value at
    the end changes by no more than the state there, relative: of a settled orbit nothing is solved.
    """
    s, x1, v1 = state
    arc, rate = side.arc, side.rate
    w, k = arc.table, LAST + 8 * end
    scale = abs(s) + abs(v1) + rate * abs(x1)
    apart = abs(w[k] - s) + abs(w[k + 1] - v1) + rate * abs(w[k + 2] - x1)
    apart = apart / scale + abs(w[k + 3] - phase[0]) + abs(w[k + 4] - phase[1])
    if not apart <= SAME * min(arc.tolerance, 1.0):
        return False
    for body in range(2):
        if bodies & (1 << body) and not finite(w[k + 5 + body]):
            return False
    e = energies_of(side.ps, side.damper, x1, v1, side.wall.gap, s)
    for body in range(2):
        if bodies & (1 << body):
            energy[body] = max(energy[body], e[body] + w[k + 5 + body])
    return True


@jit
def note_half(side, energy, end, phase, state, bodies, span):
    """Raise the energies of some bodies (bits) to their maxima in a span of a half.

    state: (s, x1, v1) at its end, TOUCH or RELEASE. span: from when to when [s].
    """
    whole = span[0] <= 0.0 and span[1] == math.inf
    if whole and is_known(side, energy, end, phase, state, bodies):
        return
    half = half_impact(side, phase, state)
    fill_energies(side.wall, half)
    w, k = side.arc.table, LAST + 8 * end
    w[k], w[k + 2], w[k + 1] = state
    w[k + 3], w[k + 4] = phase
    for body in range(2):
        w[k + 5 + body] = math.nan
        if bodies & (1 << body):
            top = np.zeros(2)
            note_peaks_of(half, top, body, span)
            energy[body] = max(energy[body], top[body])
            if whole:
                w[k + 5 + body] = top[body] - w[FIRST + 2 * ROW * body]


@jit
def note_inside(side, energy, phase, ahead, lasting):
    """Raise the largest energies to their maxima in the next `lasting` [s] of a solved impact.

    ahead: `Ahead`; phase: (cos, sin) at its touch.
    """
    c, d = phase
    cosine, sine = rotated(c, d, side.ps.omega * ahead.took)
    doubt = peaks_in_doubt(side, energy, c, cosine, ahead)
    since, until = ahead.elapsed, ahead.elapsed + lasting
    if until >= ahead.took:
        until = math.inf
    if doubt & 3:
        note_half(side, energy, int(TOUCH), phase, ahead.touch, doubt & 3, (since, until))
    if doubt & 12:
        (s, x1, v1), phase = ahead.release, (cosine, -sine)
        span = ahead.took - until, ahead.took - since if since > 0.0 else math.inf
        note_half(backward(side), energy, int(RELEASE), phase, (-s, x1, -v1), doubt >> 2, span)
