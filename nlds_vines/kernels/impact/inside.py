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
from ..motion.driven import carried, columns_of, put_columns
from ..motion.response_sums import (
    BEFORE,
    BEGIN,
    MOST,
    OF_A,
    OF_FORCE,
    OF_R,
    OF_V,
    OF_X,
    SUMS,
    absolute,
    beside,
    in_absolute,
    place_of_largest,
    raise_to,
)
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import TINIEST
from ..numerics.fours import bare, four, four_at, larger_of, largest_of, put_four, sum_of
from ..numerics.matrices import solve
from ..scene.drive import (
    Moment,
    backward,
    bending,
    cos_sin,
    drive_later,
    drive_now,
    falling,
    later,
)
from ..scene.scene import (
    Damper,
    Ground,
    Structure,
    Watch,
    accelerations,
    shared,
    side_with,
    under,
    unloaded,
)
from ..watch.observe import energies, opposite, powers_at, raise_energies
from .arc import (
    AMPLITUDES,
    ARC_WEIGHT,
    AT_CURVATURE,
    AT_DRAG,
    AT_DRIFT,
    AT_FORCE,
    AT_SPRING,
    CHANGES,
    COMMON_V,
    COMMON_X,
    CUBE,
    DOUBLE,
    FACTORS,
    GB,
    GT,
    GUESSED,
    HALF,
    HALF_ERROR,
    INSIDE,
    LEVEL,
    LEVELS,
    MATRIX,
    MISSED,
    NODE_ROW,
    PRODUCTS,
    SETTLED,
    SUMMED,
    TIMES,
    USED,
    VARIATIONS,
    WHOLE,
)
from .impact import (
    LASTING,
    MOST_SWEEPS,
    Nodes,
    approach_of,
    missed,
    nodes_of,
    numbers_varied,
    pushes_varied,
    settle,
    short_impact,
    slopes_at,
    solve_arc,
)

# ---- Variations through a short impact: its collocation, linearized at the nodes -----------------
#
# Four small differences from an orbit ride through the impact that `impact` has solved. They are
# differences at one time; the collocation has differences at one phase phi of the arc. At the touch
# the wall is met later by t0 = -r / s, r and s being a variation's and the orbit's own, and a
# variation y becomes y + y' t0; at the release, which comes later by t0 and by what the impact
# lasts longer, it turns back. (y' is continuous there: the contact's force begins and ends with
# zero.)
#
# In between, the differences (b, t, x, v) of amplitude, time and common motion obey, a dash being
# the derivative by phi, X and V the common motion itself,
#
#     b' = B_E e + B_B b     t' = T_E e + T_B b     v' = V_E e + V_B b     x' = V t' + (dt/dphi) v
#
#     e = P/m1 d(cos)/dt (t0 + t) - k1/m1 x - c1/m1 v
#
# with factors at the nodes that the impact fixes (`linearize`). e, what accelerates x1 apart from
# the damper, is all that the motion does to b and to itself; so b and e are the unknowns. As V' is
# small and (T v)' = (dt/dphi) v + T v', the displacement is x = x0 + T v + integral of V t' - T v',
# which needs no v at the nodes; at the end of the arc, that is what Gauss points would give anyway.
#
# This is a linear fixed point, and contracts as that of the impact does, by about one per cent a
# sweep. It starts from the series of the impact, differentiated by the small numbers; so is what
# the nodes miss in the end. The variations err as the impact does, by its tolerance, relative to
# their largest.
#
# A vector of four holds the four variations, which cost little more than one so.


# The scratch of variations in the table of an arc, from VARIED on.
#
#   from         numbers    what
#   E_T ... V_B  7 ROW      factors at the nodes: of time in e; of e and of b in the derivatives
#   CHANGES      3 ROW      what the four variations change of each term of the series
#   NODE         24 ROW     node by node, four variations each: b, e and derivatives of b, t, w, v
E_T, B_E, B_B, T_E, T_B, V_E, V_B = (VARIATIONS + NODE_ROW * i for i in range(7))
NODE, NODE_NUMBERS = VARIATIONS + 10 * NODE_ROW, 24
AMPLITUDE, PUSHES, OF_B, OF_T, OF_W, OF_H = (NODE + 4 * i for i in range(6))


@jit
def linearize(ps, damper, wall, nodes, approach):
    """Fill the factors of the linearized equations at the nodes.

    All follow from d(ln per) = u^2 per/u da - 6 (1 + a u per) db / b, per = u / den.
    """
    w, at = nodes.w, nodes.at
    other, a1, a2 = 1.0 - damper.share, ps.stiffness * damper.share, ps.damping * damper.share
    c, d = approach.phase
    for i in range(0, nodes.m, 4):
        # The impact, as in `slopes_at`.
        b, u, S_u = four_at(w, AMPLITUDES + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
        b2 = b * b
        b4 = b2 * b2
        u2 = u * u
        z, s = b4 * u2, (wall.speed * (b4 * b)) * S_u
        cosine, sine = cos_sin(ps.omega * four_at(w, TIMES + i))
        push = ps.force * (c * cosine - d * sine)
        push = push - (
            ps.stiffness * four_at(w, COMMON_X + i) + ps.damping * four_at(w, COMMON_V + i)
        )
        push = under(ps.load, push - (a1 * z + a2 * s))
        a = push - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
        per = u / (wall.kappa * (b4 * b2) - a * u2)
        dt = (2.5 * wall.speed) * (b4 * b) * per
        # What a change of b does to z, s and the accelerations.
        per_b = 1.0 / b
        z_b, s_b = 4.0 * z * per_b, 5.0 * s * per_b
        push_b = 0.0 - (a1 * z_b + a2 * s_b)
        a_b = push_b - (damper.k2 * z_b + damper.c2 * s_b) * damper.inv_mu
        # The factors.
        grows = 1.0 + a * u * per
        half = 0.5 * S_u * b * per
        b_e, t_e = half * grows, dt * u * per
        b_b = half * a * per_b * (1.0 - 6.0 * grows) + b_e * a_b
        t_b = dt * per_b * (5.0 - 6.0 * grows) + t_e * a_b
        put_four(w, E_T + i, (0.0 - ps.force * ps.omega) * (d * cosine + c * sine))
        put_four(w, B_E + i, b_e)
        put_four(w, B_B + i, b_b)
        put_four(w, T_E + i, t_e)
        put_four(w, T_B + i, t_b)
        put_four(w, V_E + i, other * (push * t_e + dt))
        put_four(w, V_B + i, other * (push * t_b + dt * push_b))


@jit
def guess(ps, damper, nodes, approach, pushes, faster):
    """Fill a guess of b and e at the nodes: `impact.first_guess`, differentiated.

    pushes: of `impact.pushes_varied`; faster: what varies of the approach speed, relative. What
    the shares of s and z do to the common motion changes with powers of that speed.
    """
    w, b0, tick, other = nodes.w, approach.b, approach.tick, 1.0 - damper.share
    as_fast, slower = 0.2 * faster, -0.2 * faster
    push, first, second, third, fourth = pushes
    second, third, fourth = 0.5 * second, (1.0 / 6.0) * third, (1.0 / 24.0) * fourth
    # the derivatives of the push along the impact
    per = 2.5 * approach.s / (tick * tick)
    climbs, bends = per * approach.drift, 2.0 * per / tick * approach.curvature
    twists = ps.force * ps.omega * ps.omega * ps.omega * approach.phase[1]
    twists = 0.5 * (twists - (ps.stiffness * approach.jerk + ps.damping * approach.snap))
    # the shares
    z0 = (b0 * b0) * (b0 * b0)
    on_v = ps.damping * other * damper.share
    once = (ps.stiffness * damper.share - ps.damping * on_v) * other * z0 * tick
    back = ps.damping * once + ps.stiffness * on_v * z0 * tick
    on_u = 0.8 * ps.damping * on_v * z0
    on_cube, on_double = 0.6 * back, 0.4 * tick * (ps.stiffness * once - ps.damping * other * back)
    for i in range(nodes.m):
        k, at, time = NODE_NUMBERS * i, nodes.at + i, w[TIMES + i]
        by_b, by_t, row = four(0.0), four(0.0), nodes.at + GB * nodes.m + i
        for term in range(1, GUESSED):
            row, change = row + nodes.m, four_at(w, CHANGES + 4 * term)
            by_b = by_b + w[row] * change
            by_t = by_t + w[row + (GT - GB) * nodes.m] * change
        b, t = w[AMPLITUDES + i] * as_fast + b0 * by_b, time * slower + tick * by_t
        u, cube, double = w[at], w[at + CUBE * nodes.m], w[at + DOUBLE * nodes.m]
        e = push + time * (first + time * (second + time * (third + time * fourth)))
        e = e + (climbs + time * (bends + time * twists)) * t
        e = e + (on_u * u * u + (on_cube * cube + on_double * double)) * faster
        put_four(w, AMPLITUDE + k, b)
        put_four(w, PUSHES + k, e)


@jit
def slopes_of_b(nodes):
    w = nodes.w
    for i in range(nodes.n):
        k = NODE_NUMBERS * i
        e, b = four_at(w, PUSHES + k), four_at(w, AMPLITUDE + k)
        put_four(w, OF_B + k, w[B_E + i] * e + w[B_B + i] * b)


@jit
def slopes_of_motion(nodes):
    w = nodes.w
    for i in range(nodes.n):
        k = NODE_NUMBERS * i
        e, b = four_at(w, PUSHES + k), four_at(w, AMPLITUDE + k)
        t = w[T_E + i] * e + w[T_B + i] * b
        v = w[V_E + i] * e + w[V_B + i] * b
        put_four(w, OF_T + k, t)
        put_four(w, OF_W + k, w[COMMON_V + i] * t - w[TIMES + i] * v)
        put_four(w, OF_H + k, v)


@jit
def integrate_b(nodes, start):
    """Integrate b from touch to every node; return the largest changes."""
    w, m, matrix = nodes.w, nodes.m, nodes.at + MATRIX * nodes.m
    changed = four(0.0)
    for i in range(0, m, 4):
        b0, b1, b2, b3 = start, start, start, start
        for j in range(nodes.n):
            k, slope = matrix + j * m + i, four_at(w, OF_B + NODE_NUMBERS * j)
            b0 = b0 + w[k] * slope
            b1 = b1 + w[k + 1] * slope
            b2 = b2 + w[k + 2] * slope
            b3 = b3 + w[k + 3] * slope
        k = AMPLITUDE + NODE_NUMBERS * i
        changed = larger_of(changed, b0 - four_at(w, k))
        changed = larger_of(changed, b1 - four_at(w, k + NODE_NUMBERS))
        changed = larger_of(changed, b2 - four_at(w, k + 2 * NODE_NUMBERS))
        changed = larger_of(changed, b3 - four_at(w, k + 3 * NODE_NUMBERS))
        put_four(w, k, b0)
        put_four(w, k + NODE_NUMBERS, b1)
        put_four(w, k + 2 * NODE_NUMBERS, b2)
        put_four(w, k + 3 * NODE_NUMBERS, b3)
    return changed


@jit(inlined=True)
def push_at(ps, w, i, t, x, v):
    """Put e at node i; return its change. t, v: as in the text; x: less what T v adds to it."""
    e = w[E_T + i] * t - (ps.stiffness * (x + w[TIMES + i] * v) + ps.damping * v)
    before = four_at(w, PUSHES + NODE_NUMBERS * i)
    put_four(w, PUSHES + NODE_NUMBERS * i, e)
    return e - before


@jit
def integrate_motion(ps, nodes, late, x0, v0, first):
    """Integrate time and common motion to the nodes from `first` on; return the largest changes.

    Of e, which is all that they change.
    """
    w, m, matrix = nodes.w, nodes.m, nodes.at + MATRIX * nodes.m
    changed = four(0.0)
    for i in range(first, m, 2):
        t0, t1, y0, y1, z0, z1 = late, late, x0, x0, v0, v0
        for j in range(nodes.n):
            q, k = matrix + j * m + i, NODE_NUMBERS * j
            t, x, v = four_at(w, OF_T + k), four_at(w, OF_W + k), four_at(w, OF_H + k)
            t0 = t0 + w[q] * t
            t1 = t1 + w[q + 1] * t
            y0 = y0 + w[q] * x
            y1 = y1 + w[q + 1] * x
            z0 = z0 + w[q] * v
            z1 = z1 + w[q + 1] * v
        changed = larger_of(changed, push_at(ps, w, i, t0, y0, z0))
        changed = larger_of(changed, push_at(ps, w, i + 1, t1, y1, z1))
    return changed


@jit
def missed_varied(nodes, approach, faster):
    """Return the variations of the nodes' errors in b [m^(1/4)] and in the time [s].

    And that time itself. Both change with the approach speed, too, as b and tick do.
    """
    w, at = nodes.w, nodes.at + (MATRIX + nodes.n) * nodes.m
    b, t = four(0.0), four(0.0)
    for k in range(1, MISSED):
        change = four_at(w, CHANGES + 4 * k)
        b = b + w[at + k] * change
        t = t + w[at + MISSED + k] * change
    of_b, of_t, _ = missed(nodes)
    b = approach.b * (b + (0.2 * of_b) * faster)
    late = approach.tick * of_t
    return b, approach.tick * t - (0.2 * late) * faster, late


@jit
def settle_variations(ps, nodes, approach, start, lasting, took, enough, size):
    """Sweep until b and e settle at the nodes, from their guess.

    start: (t0, b, x, v) at the touch; lasting: the duration `took` [s] times rate; size: of the
    variations [m/s]; enough: what the end may be off, relative. As the guess is right to third
    order, a sweep shrinks an error of b to a third of a at most, and so does the integral to the
    end; time at release takes a fifth of it. An error of e grows like t^3 at least: the last node
    tells the largest, and a quarter of it acts. Where that is settled, b alone goes on.
    """
    late, b, x, v = start
    shrinks = approach.size / 3.0
    of_speed = 5.0 * approach.s / approach.b * (shrinks * (shrinks + 0.2 * lasting))
    slopes_of_b(nodes)
    integrate_b(nodes, b)
    slopes_of_motion(nodes)
    left = math.inf
    for _ in range(MOST_SWEEPS):
        if left > 0.25 * enough:
            integrate_motion(ps, nodes, late, x, v, 0)
        slopes_of_b(nodes)
        of_b = integrate_b(nodes, b)
        slopes_of_motion(nodes)
        of_e = integrate_motion(ps, nodes, late, x, v, nodes.m - 2)
        left = largest_of((0.25 * took) * of_e / size)
        if left + largest_of(of_speed * of_b / size) <= enough:
            break


@jit
def at_release(nodes, start, took):
    """Return the differences (b, t, x, v) at the end of the arc, t without t0.

    x already holds what goes with the time `took` [s] that the nodes miss, v that it lasts.
    """
    w, weight = nodes.w, nodes.at + ARC_WEIGHT * nodes.m
    _, b, x, v = start
    t = four(0.0)
    slopes_of_b(nodes)
    for i in range(nodes.n):
        k, q = NODE_NUMBERS * i, w[weight + i]
        b = b + q * four_at(w, OF_B + k)
        t = t + q * four_at(w, OF_T + k)
        x = x + q * four_at(w, OF_W + k)
        v = v + q * four_at(w, OF_H + k)
    return b, t, x + took * v, v


@jit
def solve_variations(side, nodes, approach, took, tangent):
    """Solve for b and e of four variations `tangent` (16,) at the nodes of an arc or its half.

    took [s]: its duration. Returns (start, push, faster): the differences (t0, b, x, v) at the
    touch, what changes of the push there, and of the speed, relative.
    """
    ps, damper, wall, rate = side.ps, side.damper, side.wall, side.rate
    linearize(ps, damper, wall, nodes, approach)
    # The differences where the wall is met, t0 later; the common motion's are without s.
    s, share = approach.s, damper.share
    x1, v1 = approach.x, approach.v + share * s
    dv, ds = accelerations(ps, damper, x1, v1, wall.gap, s, drive_now(approach.phase), 0.0)
    x, v, r, speed = columns_of(tangent)
    late = (-1.0 / s) * r
    size = larger_of(larger_of(four(TINIEST), rate * r), v)
    x, v, _, speed = carried((x, v, r, speed), (v1, dv, s, ds), late)
    v = v - share * speed
    size = larger_of(larger_of(larger_of(size, speed), v), rate * x)
    # Their guess and the sweeps.
    faster = (1.0 / s) * speed
    pushes = pushes_varied(ps, damper, approach, late, x, v)
    # The change of each term of the series, which is a product of two (`first_guess`).
    force, drag, drift, spring, curvature = numbers_varied(approach, pushes, faster)
    put_four(nodes.w, CHANGES, four(0.0))
    put_four(nodes.w, CHANGES + 4 * AT_FORCE, force)
    put_four(nodes.w, CHANGES + 4 * AT_DRAG, drag)
    put_four(nodes.w, CHANGES + 4 * AT_DRIFT, drift)
    put_four(nodes.w, CHANGES + 4 * AT_SPRING, spring)
    put_four(nodes.w, CHANGES + 4 * AT_CURVATURE, curvature)
    for k in range(1, MISSED):
        fewer, once = FACTORS[k], FACTORS[MISSED + k]
        change = nodes.w[PRODUCTS + fewer] * four_at(nodes.w, CHANGES + 4 * once)
        change = change + nodes.w[PRODUCTS + once] * four_at(nodes.w, CHANGES + 4 * fewer)
        put_four(nodes.w, CHANGES + 4 * k, change)
    guess(ps, damper, nodes, approach, pushes, faster)
    start = late, (0.2 * approach.b) * faster, x, v
    enough = side.arc.settled / SETTLED
    settle_variations(ps, nodes, approach, start, rate * took, took, enough, size)
    return start, pushes[0], faster


@jit
def vary(side, phase, before, after, tangent):
    """Carry four variations `tangent` (16,) from touch to release of an impact just solved.

    The table of the arc holds its unknowns. before: (s, x1, v1) at the touch; after: (s, x1, v1,
    duration [s]) at the release; phase: as for `short_impact`.
    """
    ps, damper, wall, arc = side.ps, side.damper, side.wall, side.arc
    approach = approach_of(ps, damper, wall, phase, before)
    n, m, at, w = nodes_of(arc, int(arc.table[USED]), int(WHOLE))
    nodes, took = Nodes(n, m, at, bare(w)), after[3]
    start, push, faster = solve_variations(side, nodes, approach, took, tangent)
    # At the release, with what the nodes miss.
    b, t, x, v = at_release(nodes, start, took)
    more, longer, late = missed_varied(nodes, approach, faster)
    b, t = b + more, t + longer
    x = x + approach.v * longer
    v = v + (approach.acceleration * longer + ((1.0 - damper.share) * late) * push)
    # At one time: t0 + t before the wall is left. (b^5 is that of the last node, all but exactly.)
    s, x1, v1, _ = after
    last = w[AMPLITUDES + n - 1]
    last2 = last * last
    off = -s / (wall.speed * (last2 * last2 * last)) - 1.0
    last = last * (1.0 + off * (0.2 - off * (0.08 - 0.048 * off)))
    speed = (5.0 * s / last) * b
    drive = drive_now(later(ps, phase, took))
    dv, ds = accelerations(ps, damper, x1, v1, wall.gap, s, drive, 0.0)
    back = start[0] + t
    v = v + damper.share * speed
    put_columns(tangent, carried((x, v, four(0.0), speed), (v1, dv, s, ds), 0.0 - back))


# ---- A response over a short impact, summed up at its own nodes ----------------------------------
#
# Products of states are as smooth in the arc's phase as the states themselves, but unlike these
# they are no small correction to what is known: so the nodes are as many as integrate those of the
# free arc to the tolerance, and the impact is solved once more where it had fewer.
#
# What is largest is so at an end of the impact, which flights have noted, where its rate vanishes
# between two nodes, or, depth, force and acceleration, about the deepest point. There the force
# falls to both sides by its own curvature, so that the acceleration is largest a little beside it,
# by a parabola. Where that may not be enough, or another quantity may set a record, nothing is
# added: then the impact is to be stepped.


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
    """Return (x1, v1, dv1/dt, a1, jerk) of a state y without depth; ground: of a `Tally`."""
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
        dv, ds = accelerations(ps, damper, x1, v1, r, s, drive, wall.K * z * root)
        push = 1.5 * wall.K * root * s
        jerk, _ = accelerations(unloaded(ps), damper, v1, dv, s, ds, 0.0, push)
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
    """Return True if a quantity may exceed its largest where its rate changes sign in a `time` [s].

    values, rates: those at both ends.
    """
    if not opposite(rates[0], rates[1]):
        return False
    before, after = abs(values[0]) + abs(rates[0]) * time, abs(values[1]) + abs(rates[1]) * time
    return min(before, after) > row[place_of_largest(which, 1.0)]


@jit
def rises_between(tally, before, after, time, deepest):
    """Return True if a largest value may be exceeded between two nodes, a `time` [s] apart.

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
    """Return True if a largest value may be exceeded anywhere between touch and release.

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
        unloaded(ps), damper, dv, jerk - falls, ds, twist - (falls - shared(ps, falls)), 0.0, push
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


# ---- inside a short impact -----------------------------------------------------------------------


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
    i = at
    return Ahead(
        numbers[i], numbers[i + 1], numbers[i + 2],
        (numbers[i + 3], numbers[i + 4], numbers[i + 5]),
        (numbers[i + 6], numbers[i + 7], numbers[i + 8]),
    )  # fmt: skip


@jit
def keep_ahead(numbers, at, ahead):
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
    """Return the place in the table of the results of an impact; those of a new one are NaN.

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
    at = INSIDE + EACH * int(w[NEXT_KEPT])
    w[NEXT_KEPT] = w[NEXT_KEPT] + 1.0 if w[NEXT_KEPT] < KEPT - 1.0 else 0.0
    for i in range(RISES_KEPT, EACH):
        w[at + i] = math.nan
    return at


# ---- energies ------------------------------------------------------------------------------------


@jit
def where_peaks_are(side, energy, phase, ahead):
    """Return the times [s] after the touch and before the release within which an energy may peak.

    0 where none can exceed the largest so far. It is at most the time to the depth at which the
    contact pushes as hard as all other forces, a share x^(2/3) of the greatest where those are a
    share x of its largest force, which is bounded by sqrt(x) of the impact. And there is no peak
    where an energy falls from the end on and neither the velocity nor those forces change their
    sign.
    """
    ps, damper, gap = side.ps, side.damper, side.wall.gap
    took, (s, x, v), (u, y, w) = ahead.took, ahead.touch, ahead.release
    f = powers_at(ps, damper, x, v, gap, s, drive_now(phase))
    g = powers_at(ps, damper, y, w, gap, u, drive_now(later(ps, phase, took)))
    e0, e1 = energies(ps, damper, x, v, gap, s), energies(ps, damper, y, w, gap, u)
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
    e = energies(side.ps, side.damper, x1, v1, side.wall.gap, s)
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
    """Return the place in the table of an impact that a section cuts, with its state there.

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
        # an impact that does not come again
        if not tally_nodes(side, tally, phase, now, after):
            contact(side, Watch(None, None, None, None, None, tally), phase, now, math.inf)
        return
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
