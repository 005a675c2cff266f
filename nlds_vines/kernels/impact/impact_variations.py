"""Variations through a short impact: its collocation, linearized at the nodes.

Four small differences from an orbit ride through the impact that `impact` has solved. They are
differences at one time; the collocation has differences at one phase phi of the arc. At the touch
the wall is met later by t0 = -r / s, r and s being a variation's and the orbit's own, and a
variation y becomes y + y' t0; at the release, which comes later by t0 and by what the impact lasts
longer, it turns back. (y' is continuous there: the contact's force begins and ends with zero.)

In between, the differences (b, t, x, v) of amplitude, time and common motion obey, a dash being the
derivative by phi, X and V the common motion itself,

    b' = B_E e + B_B b     t' = T_E e + T_B b     v' = V_E e + V_B b     x' = V t' + (dt/dphi) v

    e = P/m1 d(cos)/dt (t0 + t) - k1/m1 x - c1/m1 v

with factors at the nodes that the impact fixes (`linearize`). e, what accelerates x1 apart from the
damper, is all that the motion does to b and to itself; so b and e are the unknowns. As V' is small
and (T v)' = (dt/dphi) v + T v', the displacement is x = x0 + T v + integral of V t' - T v', which
needs no v at the nodes; at the end of the arc, that is what Gauss points would give anyway.

This is a linear fixed point, and contracts as that of the impact does, by about one per cent a
sweep. It starts from the series of the impact, differentiated by the small numbers; so is what the
nodes miss in the end. The variations err as the impact does, by its tolerance, relative to their
largest.

A vector of four holds the four variations, which cost little more than one so.
"""

from __future__ import annotations

import math

from ..motion.driven import carried, columns_of, put_columns
from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST
from ..numerics.fours import bare, four, four_at, larger_of, largest_of, put_four
from ..scene.drive import cos_sin, drive_now, later
from ..scene.scene import accelerations, under
from .approach import approach_of, fill_changes, numbers_varied, pushes_varied
from .arc_table import (
    AMPLITUDES,
    ARC_WEIGHT,
    CHANGES,
    COMMON_V,
    COMMON_X,
    CUBE,
    DOUBLE,
    GB,
    GT,
    GUESSED,
    MATRIX,
    MISSED,
    NODE_ROW,
    SETTLED,
    TIMES,
    USED,
    VARIATIONS,
    WHOLE,
    Nodes,
    nodes_of,
)
from .impact import MOST_SWEEPS, missed

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

    pushes: of `approach.pushes_varied`; faster: what varies of the approach speed, relative. What
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
    """Fill the derivative of b at all nodes."""
    w = nodes.w
    for i in range(nodes.n):
        k = NODE_NUMBERS * i
        e, b = four_at(w, PUSHES + k), four_at(w, AMPLITUDE + k)
        put_four(w, OF_B + k, w[B_E + i] * e + w[B_B + i] * b)


@jit
def slopes_of_motion(nodes):
    """Fill the derivatives of time and common motion at all nodes."""
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
    """Return what variations change of b [m^(1/4)] and of the time [s] that the nodes miss.

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
    fill_changes(nodes.w, numbers_varied(approach, pushes, faster))
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
