"""Variations through an impact that a section cuts in two.

The orbit is solved from touch to release, and its variations with it (`impact_variations`). Where a
section lies in between, they are wanted there, too: on the half of the impact in which it lies,
which begins at the touch, or backward in time at the release (`inside`), the same linear equations
hold, and the integrals of their solution end at the section instead of the half's end.

Variations are linear: the impact is a matrix R, a row for each unit variation, and the section cuts
it into R = F S. One of F and 1 / S is solved for, the other follows.
"""

from __future__ import annotations

import numpy as np

from ..motion import runge_kutta as rk
from ..motion.driven import carried, put_columns
from ..numerics.compiling import jit
from ..numerics.fours import bare, four, four_at, put_four
from ..numerics.matrices import solve
from ..scene.drive import rotated
from ..scene.scene import accelerations
from .impact import MATRIX, WEIGHT, B, Nodes, short_impact
from .impact_variations import TO_PLACE, at_release, solve_variations, vary
from .inside import WEIGHED, backward, half_impact, read_ahead
from .state_inside import state_at, value_at


@jit
def integrate_to_place(half):
    """Fill the weights of integrals up to the place whose weights `inside.weigh` has left.

    Returns the sum of those. An integral there is the interpolation of those to nodes and end.
    """
    w, n, m = half.nodes.w, half.nodes.n, half.nodes.m
    matrix, weight = half.nodes.at + MATRIX * m, half.nodes.at + WEIGHT * m
    total = w[WEIGHED]
    for i in range(n + 1):
        total += w[WEIGHED + 1 + i]
    for j in range(n):
        found = w[WEIGHED + 1 + n] * w[weight + j]
        for i in range(n):
            found += w[WEIGHED + 1 + i] * w[matrix + j * m + i]
        w[TO_PLACE + j] = found / total
    return total


@jit
def vary_to(side, phase, state, time, tangent):
    """Carry four variations (16,) from the beginning of a half to a `time` [s] after it.

    phase: (cos, sin) of the forcing's and state (s, x1, v1) there.
    """
    ps, damper, wall = side.ps, side.damper, side.wall
    half = half_impact(side, phase, state)
    q, s, x1, v1 = state_at(wall, half, time)
    total = integrate_to_place(half)
    ratio = 1.0 / value_at(half, int(B), half.approach.b, total)
    # The differences at the place, as in `vary` at the release.
    nodes = Nodes(half.nodes.n, half.nodes.m, half.nodes.at, bare(half.nodes.w))
    start, _, _ = solve_variations(side, nodes, half.approach, half.time, tangent)
    b, t, x, v = at_release(nodes, start, time, int(TO_PLACE))
    b = ratio * b
    z, speed = (4.0 * (q * q)) * b, (5.0 * s) * b
    # At one time.
    c, _ = rotated(phase[0], phase[1], ps.omega * time)
    force = wall.K * (q * q * q)
    dv, ds = accelerations(ps, damper, x1, v1, wall.gap + q * q, s, c, force)
    back = start[0] + t
    x, v = x + damper.share * z, v + damper.share * speed
    put_columns(tangent, carried((x, v, z, speed), (v1, dv, s, ds), 0.0 - back))


@jit
def turn(tangent):
    """Change the signs of v1 and s of four variations: of time."""
    for i in range(1, 16, 2):
        tangent[i] = -tangent[i]


@jit
def unit_variations():
    """Return the unit variations (16,)."""
    found = np.zeros(16)
    for i in range(0, 16, 5):
        found[i] = 1.0
    return found


@jit
def product(first, second):
    """Return what becomes of variations `first` (16,), where the unit ones become `second`."""
    found = np.empty(16)
    for i in range(0, 16, 4):
        sums = four(0.0)
        for j in range(4):
            sums = sums + first[i + j] * four_at(second, 4 * j)
        put_four(found, i, sums)
    return found


@jit
def divided(whole, first):
    """Return the `second` (16,) with which the `product` of `first` and it is `whole`."""
    matrix, right = np.empty((4, 4)), np.empty((4, 4))
    for i in range(4):
        for j in range(4):
            matrix[i, j], right[i, j] = first[4 * i + j], whole[4 * i + j]
    solve(matrix, right)
    found = np.empty(16)
    for i in range(4):
        for j in range(4):
            found[4 * i + j] = right[i, j]
    return found


@jit
def cut_in_two(side, phase, ahead):
    """Return F and S (16,) of an impact that a section cuts, `ahead.elapsed` > 0.

    phase: (cos, sin) at the touch.
    """
    s, x1, v1 = ahead.touch
    out, a1, b1 = ahead.release
    whole, part = unit_variations(), unit_variations()
    short_impact(side, None, phase, (0.0, s, x1, v1))
    vary(side, phase, ahead.touch, (out, a1, b1, ahead.took), whole)
    # The half in which the section lies: as it is, or backward in time.
    early = ahead.elapsed + ahead.elapsed <= ahead.took
    state, time = ahead.touch, ahead.elapsed
    if not early:
        c, d = rotated(phase[0], phase[1], side.ps.omega * ahead.took)
        side = backward(side)
        phase, state, time = (c, -d), (-out, a1, -b1), ahead.took - ahead.elapsed
        turn(part)
    vary_to(side, phase, state, time, part)
    if early:
        return part, divided(whole, part)
    turn(part)
    return product(whole, part), divided(unit_variations(), part)


@jit
def vary_cut(side, phase, tangent, to_section):
    """Carry four variations (16,) from touch to the section in an impact, or from there on.

    phase: (cos, sin) of the forcing's at the section. The scratch holds the impact that is `Ahead`;
    what follows the section is kept there, too, until it is asked for.
    """
    k = side.k
    ahead, kept = read_ahead(k, int(rk.AHEAD)), rk.SECOND
    known = k[kept + 16] == ahead.took and k[kept + 17] == ahead.elapsed
    known = known and k[kept + 18] == ahead.touch[0] and k[kept + 19] == ahead.touch[2]
    map_on = np.empty(16)
    for i in range(16):
        map_on[i] = k[kept + i]
    if to_section or not known:
        touch = rotated(phase[0], phase[1], -side.ps.omega * ahead.elapsed)
        first, second = cut_in_two(side, touch, ahead)
        for i in range(16):
            k[kept + i] = second[i]
            map_on[i] = first[i] if to_section else second[i]
        k[kept + 16], k[kept + 17] = ahead.took, ahead.elapsed
        k[kept + 18], k[kept + 19] = ahead.touch[0], ahead.touch[2]
    found = product(tangent, map_on)
    for i in range(16):
        tangent[i] = found[i]
