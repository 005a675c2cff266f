"""The state inside a short impact at any time, read off half of it (`inside`).

Nothing is searched for: the square root of the time since touch is a smooth function of the phase,
so that the barycentric weights of the nodes hold in it, too (Baltensperger, Berrut, Noel:
Mathematics of Computation 68 (1999) 1109). What is interpolated is only how the impact differs from
the free arc, of which u and S are polynomials in its own time.
"""

from __future__ import annotations

import math

from ..numerics.compiling import jit
from ..numerics.fours import four, four_at, number_of, put_four, roots_of, sum_of
from ..scene.drive import rotated
from ..scene.scene import finite
from .impact import DEGREES, GT, LENGTH, LEVEL, LEVELS, SHAPE, WITHIN_ERROR, B, G, H, T, approach_of
from .inside import BARYCENTRIC, CUT, FIRST, ONWARD, SECOND, WEIGHED, backward, solved_half

ASIDE, A_LITTLE = 1.0 + 4.0e-16, 1.0e-30  # factor and step aside from a node, where weights end
LAGGING = 0.6  # what sweeps may leave, by e and in units of what those of an impact may: at the
# nodes, time and place lag a sweep behind the rest
AS_GOOD = 0.3  # change of an impact with which it is the same, in units of what sweeps may leave


@jit
def weigh_at(half, root):
    """Fill the row WEIGHED with the weights at a time; return their sum.

    root: the square root of the time, in units of the impact's tick, so that a change of units by
    a power of two changes no bit.
    """
    w, n, weight = half.nodes.w, half.nodes.n, half.places + ONWARD * half.k
    per = 1.0 / half.approach.tick
    w[WEIGHED] = w[half.places + BARYCENTRIC * half.k] / root
    total = four(0.0)
    for i in range(0, n + 1, 4):
        q = four_at(w, weight + i) / (root - roots_of(per * four_at(w, T + i)))
        put_four(w, WEIGHED + 1 + i, q)
        total = total + q
    return w[WEIGHED] + sum_of(total)


@jit
def value_at(half, row, at_touch, total):
    """Return an unknown where `weigh_at` returned `total`; row: of the nodes and the end."""
    w, found = half.nodes.w, four(0.0)
    for i in range(0, half.nodes.n + 1, 4):
        found = found + four_at(w, WEIGHED + 1 + i) * four_at(w, row + i)
    return (w[WEIGHED] * at_touch + sum_of(found)) / total


@jit
def shape_at(w, tau):
    """Return u and S of the free arc at its own time tau, up to a little behind its deepest point.

    u / sqrt(2 tau) and S are power series in tau^(5/2) = y: even and odd powers side by side.
    """
    tau = max(tau, 0.0)
    y = tau * tau * math.sqrt(tau)
    y2, i = y * y, SHAPE + 4 * (DEGREES - 1)
    found = four_at(w, i)
    while i > SHAPE:
        i -= 4
        found = found * y2 + four_at(w, i)
    u = number_of(found, 0) + y * number_of(found, 1)
    return math.sqrt(2.0 * tau) * u, number_of(found, 2) + y * number_of(found, 3)


@jit
def state_at(wall, half, time):
    """Return (q = sqrt(z), s, x1, v1) at a `time` [s] after the half's beginning.

    u and S are those of the free arc at its own time, from which the impact's differs by little.
    """
    approach, nodes, share = half.approach, half.nodes, half.damper.share
    w, n, m = nodes.w, nodes.n, nodes.m
    per, v = 1.0 / approach.tick, approach.v
    root = math.sqrt(per * time)
    total = weigh_at(half, root)
    if not finite(total):
        total = weigh_at(half, root * ASIDE + A_LITTLE)
    # how much later than the free arc the impact is, in units of tick; the way but for v t
    for i in range(0, m, 4):
        t = four_at(w, T + i)
        put_four(w, FIRST + i, per * t - four_at(w, nodes.at + GT * m + i))
        put_four(w, SECOND + i, four_at(w, G + i) - v * t)
    w[FIRST + n] = per * half.time - 0.5 * LENGTH
    w[SECOND + n] = w[G + n] - v * half.time
    u, S = shape_at(w, per * time - value_at(half, int(FIRST), 0.0, total))
    b = value_at(half, int(B), approach.b, total)
    b2 = b * b
    q, s = b2 * u, wall.speed * (b2 * b2 * b) * S
    x = v * time + value_at(half, int(SECOND), approach.x, total)
    v = value_at(half, int(H), approach.v, total)
    return q, s, x + share * (q * q), v + share * s


@jit
def level_within(arc, size):
    """Return the first level with which a state within an impact of size e is in the tolerance."""
    for level in range(arc.inside):
        if arc.table[LEVELS + LEVEL * level + WITHIN_ERROR] * size <= arc.tolerance:
            return level
    return arc.inside


@jit
def state_from(side, phase, state, time):
    """Return (q, s, x1, v1) a `time` [s] after a touch with (s, x1, v1), in the impact's half."""
    approach = approach_of(side.ps, side.damper, side.wall, phase, state)
    arc = side.arc
    level, settled = level_within(arc, approach.size), LAGGING * arc.settled * approach.size
    return state_at(side.wall, solved_half(side, approach, level, settled), time)


@jit
def state_inside(side, phase, ahead, time):
    """Return (q, s, x1, v1) a `time` [s] after the touch of an impact that is solved.

    phase: (cos, sin) at touch; ahead: `Ahead`. From the end of the impact that is nearer.
    """
    if time + time <= ahead.took:
        return state_from(side, phase, ahead.touch, time)
    s, x1, v1 = ahead.release
    c, d = rotated(phase[0], phase[1], side.ps.omega * ahead.took)
    left = ahead.took - time
    q, s, x1, v1 = state_from(backward(side), (c, -d), (-s, x1, -v1), left)
    return q, -s, x1, -v1


@jit
def state_at_section(side, phase, ahead):
    """Return (q, s, x1, v1) of a solved impact at a section, `ahead.elapsed` after its touch.

    phase: (cos, sin) at touch. Of an impact that is all but the last one that a section cut, it is
    known: of a settled orbit nothing is solved.
    """
    arc, rate = side.arc, side.rate
    w, k = arc.table, CUT
    (s, x1, v1), (c, d) = ahead.touch, phase
    apart = abs(w[k] - s) + rate * abs(w[k + 1] - x1) + abs(w[k + 2] - v1)
    turned = abs(w[k + 3] - c) + abs(w[k + 4] - d) + abs(w[k + 5] - ahead.elapsed) / ahead.took
    if not apart + s * turned <= AS_GOOD * arc.settled * s:
        found = state_inside(side, phase, ahead, ahead.elapsed)
        w[k], w[k + 1], w[k + 2] = ahead.touch
        w[k + 3], w[k + 4], w[k + 5] = c, d, ahead.elapsed
        w[k + 6], w[k + 7], w[k + 8], w[k + 9] = found
    return w[k + 6], w[k + 7], w[k + 8], w[k + 9]
