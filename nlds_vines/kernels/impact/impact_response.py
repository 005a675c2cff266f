"""A response over a short impact, summed up at its own nodes.

Products of states are as smooth in the arc's phase as the states themselves, but unlike these they
are no small correction to what is known: so the nodes are as many as integrate those of the free
arc to the tolerance, and the impact is solved once more where it had fewer.

What is largest is so at an end of the impact, which flights have noted, where its rate vanishes
between two nodes, or, depth, force and acceleration, about the deepest point. There the force falls
to both sides by its own curvature, so that the acceleration is largest a little beside it, by a
parabola. Where that may not be enough, or another quantity may set a record, nothing is added:
then the impact is to be stepped.
"""

from __future__ import annotations

from ..motion.response_sums import (
    OF_A,
    OF_FORCE,
    OF_R,
    OF_V,
    OF_X,
    absolute,
    beside,
    in_absolute,
    place_of_largest,
    raise_to,
)
from ..numerics.compiling import jit
from ..numerics.fours import bare, four, four_at, put_four, sum_of
from ..scene.drive import apart, bending, drive_later, drive_now, falling, later
from ..scene.scene import accelerations, accelerations_of, unloaded
from ..watch.observe import opposite
from .approach import approach_of
from .arc_table import (
    AMPLITUDES,
    ARC_WEIGHT,
    COMMON_V,
    COMMON_X,
    HALF,
    HALF_ERROR,
    LEVEL,
    LEVELS,
    NODE_ROW,
    SUMMED,
    TIMES,
    USED,
    VARIATIONS,
    WHOLE,
    Nodes,
    nodes_of,
)
from .impact import settle, slopes_at, solve_arc

# Rows at the nodes, in the scratch of variations: x1, v1 and its rate, the absolute
# acceleration and its rate.
AT_X1, AT_V1, AT_DV, AT_A1, AT_JERK = (VARIATIONS + NODE_ROW * i for i in range(5))


@jit
def level_of_sums(arc):
    """Return the first level whose sums over the free arc are within the tolerance, or the last."""
    for level in range(arc.levels - 1):
        if arc.table[LEVELS + LEVEL * level + SUMMED] <= arc.tolerance:
            return level
    return arc.levels - 1


@jit
def motion_of_touch(ps, damper, ground, y, phase):
    """Return what the rows hold of a state (x1, v1, r, s) without depth; ground: of a `Tally`."""
    x1, v1, r, s = y
    drive = drive_now(phase)
    dv, ds = accelerations(ps, damper, x1, v1, r, s, drive, 0.0)
    jerk, _ = accelerations(unloaded(ps), damper, v1, dv, s, ds, 0.0, 0.0)
    jerk -= in_absolute(ground, falling(ps, phase))
    return x1, v1, dv, absolute(ground, dv, drive), jerk


@jit
def sums_at_nodes(side, nodes, approach, ground):
    """Fill the rows at the nodes; return the first sums of a tally (`response_sums`)."""
    ps, damper, wall, w, at = side.ps, side.damper, side.wall, nodes.w, nodes.at
    of_x, of_v, of_a, of_r = four(0.0), four(0.0), four(0.0), four(0.0)
    of_s, work, other = four(0.0), four(0.0), four(0.0)
    for i in range(0, nodes.m, 4):
        _, _, per, _, _ = slopes_at(ps, damper, wall, nodes, approach, i)
        dt = per * four_at(w, at + ARC_WEIGHT * nodes.m + i)
        b, u, S_u = four_at(w, AMPLITUDES + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
        time, b2 = four_at(w, TIMES + i), b * b
        b4, root = b2 * b2, b2 * u
        z, s = root * root, (wall.speed * (b4 * b)) * S_u
        x1 = four_at(w, COMMON_X + i) + damper.share * z
        v1 = four_at(w, COMMON_V + i) + damper.share * s
        r, drive = wall.gap + z, drive_later(ps, approach.phase, time)
        dv, ds = accelerations_of(ps, damper, x1, v1, r, s, drive, wall.K * z * root)
        push = 1.5 * wall.K * root * s
        jerk, _ = accelerations_of(unloaded(ps), damper, v1, dv, s, ds, 0.0, push)
        a1 = absolute(ground, dv, drive)
        falls = falling(ps, later(ps, approach.phase, time))
        put_four(w, AT_X1 + i, x1)
        put_four(w, AT_V1 + i, v1)
        put_four(w, AT_DV + i, dv)
        put_four(w, AT_A1 + i, a1)
        put_four(w, AT_JERK + i, jerk - in_absolute(ground, falls))
        of_x, of_v, of_a = of_x + dt * x1 * x1, of_v + dt * v1 * v1, of_a + dt * a1 * a1
        of_r, of_s, work = of_r + dt * r * r, of_s + dt * s * s, work + dt * drive * v1
        other = other + dt * drive * beside(approach.phase, x1, s)
    return (
        sum_of(of_x), sum_of(of_v), sum_of(of_a), sum_of(of_r), sum_of(of_s), sum_of(work),
        sum_of(other),
    )  # fmt: skip


@jit
def may_rise(row, which, values, rates, time):
    """Tell whether a quantity may exceed its largest where its rate changes sign in a `time` [s].

    values, rates: those at both ends.
    """
    if not opposite(rates[0], rates[1]):
        return False
    before, after = abs(values[0]) + abs(rates[0]) * time, abs(values[1]) + abs(rates[1]) * time
    return min(before, after) > row[place_of_largest(which, 1.0)]


@jit
def rises_between(tally, before, after, time, deepest):
    """Tell whether a largest value may be exceeded between two nodes, a `time` [s] apart.

    before, after: what the rows hold; deepest: whether the deepest point is in between,
    about which a1 is looked at by `about_deepest`.
    """
    row = tally.row
    x0, v0, dv0, a0, j0 = before
    x1, v1, dv1, a1, j1 = after
    found = may_rise(row, int(OF_X), (x0, x1), (v0, v1), time)
    found = found or may_rise(row, int(OF_V), (v0, v1), (dv0, dv1), time)
    return found or (not deepest and may_rise(row, int(OF_A), (a0, a1), (j0, j1), time))


@jit
def rises_inside(tally, nodes, begin, end, took):
    """Tell whether a largest value may be exceeded anywhere between touch and release.

    begin, end: as of `motion_of_touch`; took [s].
    """
    w, n, before, time = nodes.w, nodes.n, begin, 0.0
    for i in range(n):
        after = w[AT_X1 + i], w[AT_V1 + i], w[AT_DV + i], w[AT_A1 + i], w[AT_JERK + i]
        falls = w[nodes.at + nodes.m + i] <= 0.0
        deepest = falls and (i == 0 or w[nodes.at + nodes.m + i - 1] > 0.0)
        if rises_between(tally, before, after, w[TIMES + i] - time, deepest):
            return True
        before, time = after, w[TIMES + i]
    return rises_between(tally, before, end, took - time, False)


@jit
def about_deepest(side, approach, ground):
    """Return (a1, r, force) where they are largest, about the deepest point, and the error of a1.

    The error is relative to the contact's own part of it.
    """
    ps, damper, wall = side.ps, side.damper, side.wall
    _, ratio, took, x, v1 = solve_arc(side, int(HALF), int(HALF_ERROR), approach)
    b = approach.b * ratio
    root = b * b
    z, phase = root * root, later(ps, approach.phase, took)
    x1, r, force, drive = x + damper.share * z, wall.gap + z, wall.K * z * root, drive_now(phase)
    dv, ds = accelerations(ps, damper, x1, v1, r, 0.0, drive, force)
    falls = falling(ps, phase)
    jerk, twist = accelerations(unloaded(ps), damper, v1, dv, 0.0, ds, 0.0, 0.0)
    push = 1.5 * wall.K * root * ds
    snap, _ = accelerations(
        unloaded(ps), damper, dv, jerk - falls, ds, twist - apart(ps, falls), 0.0, push
    )
    jerk -= in_absolute(ground, falls)
    snap -= in_absolute(ground, bending(ps, phase))
    a1, turn = absolute(ground, dv, drive), jerk / snap
    beside_it = abs(turn) / approach.tick
    off = beside_it * beside_it * beside_it * (approach.size + beside_it)
    return a1 - 0.5 * turn * jerk, r, force, 10.0 * off


@jit
def tally_nodes(side, tally, phase, now, after):
    """Add an impact that has been solved to a tally, or nothing of it; tell which.

    phase: the instant of its touch; now: (q, s, x1, v1) there; after: (s, x1, v1, duration [s]) at
    the release. Its unknowns at the nodes are overwritten.
    """
    ps, damper, wall, arc = side.ps, side.damper, side.wall, side.arc
    (_, s, x1, v1), row, ground = now, tally.row, tally.ground
    approach = approach_of(ps, damper, wall, phase, (s, x1, v1))
    level = level_of_sums(arc)
    n, m, at, w = nodes_of(arc, max(level, int(arc.table[USED])), int(WHOLE))
    nodes = Nodes(n, m, at, bare(w))
    if level > arc.table[USED] and not settle(ps, damper, wall, nodes, approach, arc.settled):
        return False
    sums = sums_at_nodes(side, nodes, approach, ground)
    begin = motion_of_touch(ps, damper, ground, (x1, v1, wall.gap, s), phase)
    s, x1, v1, took = after
    end = motion_of_touch(ps, damper, ground, (x1, v1, wall.gap, s), later(ps, phase, took))
    if rises_inside(tally, nodes, begin, end, took):
        return False
    a1, r, force, error = about_deepest(side, approach, ground)
    if (
        error > arc.tolerance
        and abs(a1) * (1.0 + error) > row[place_of_largest(int(OF_A), side.sign)]
    ):
        return False
    raise_to(row, place_of_largest(int(OF_A), side.sign), a1)
    raise_to(row, place_of_largest(int(OF_R), side.sign), r)
    raise_to(row, place_of_largest(int(OF_FORCE), side.sign), force)
    for i in range(7):
        row[i] += sums[i]
    return True
