"""Variations through a short impact, and states, energies and responses inside it.

An orbit continues after a short impact from its solved release. If a section cuts the impact, an
energy may have its maximum in it, or a response is recorded, the impact is stepped in addition,
from the nearer end: backward in time an impact is an impact again, in which velocities and the
forces of dashpots have the other sign and the phase runs backward. The results are recalled for the
last few impacts, so that for a settled orbit nothing is stepped.

An energy can have its maximum where its power falls through zero. While the contact's force exceeds
all others, an energy only has minima, so that maxima are near the touch or near the release.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..events.contact import Steps, contact
from ..motion.driven import carried, columns_of, put_columns
from ..motion.response_sums import (
    BEFORE,
    MOST,
    NUMBERS,
    OF_A,
    OF_FORCE,
    OF_R,
    OF_V,
    OF_X,
    SUMS,
    absolute,
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
    bending,
    cos_sin,
    drive_later,
    drive_now,
    falling,
    later,
)
from ..scene.law import AHEAD
from ..scene.scene import (
    Damper,
    Ground,
    Structure,
    Watch,
    accelerations_at,
    shared,
    side_with,
    under,
    unloaded,
)
from ..watch.observe import energies, opposite, powers_at, raise_energies
from .arc import ARC, FACTORS, GUESSED, LEVEL, LEVEL_ROW, MISSED, NODE_ROW, NODES, SETTLED, TERM
from .impact import (
    LASTING,
    MOST_SWEEPS,
    Nodes,
    approach_of,
    missed,
    nodes_of,
    settle,
    short_impact,
    slopes_at,
    solve_arc,
)

# ---- Variations through a short impact: its collocation, linearized at the nodes -----------------
#
# Four variations are carried through the impact that `impact` has solved. A variation is a
# difference at equal time; the collocation has differences at equal phase phi of the arc. At the
# touch a variation meets the wall later by t0 = -r / s, r being that of the variation and s that of
# the orbit, and y becomes y + y' t0. At the release, which is later by t0 and by the change of the
# duration, it is converted back. (y' is continuous there: the contact's force begins and ends with
# zero.)
#
# In between, the differences (b, t, x, v) of amplitude, time and common motion obey, a dash being
# the derivative by phi, X and V the common motion of the orbit,
#
#     b' = B_E e + B_B b     t' = T_E e + T_B b     v' = V_E e + V_B b     x' = V t' + (dt/dphi) v
#
#     e = P/m1 d(cos)/dt (t0 + t) - k1/m1 x - c1/m1 v
#
# with partial derivatives at the nodes (`linearize`). e is the acceleration of x1 without the
# damper's part. The motion acts on b and on itself through e alone, so that b and e are the
# unknowns. As V' is small and (T v)' = (dt/dphi) v + T v', the displacement is
# x = x0 + T v + integral of V t' - T v', which needs no v at the nodes; at the end of the arc this
# is what Gauss points give for the integral of x'.
#
# This linear fixed-point iteration contracts as that of the impact, by about one per cent a sweep.
# Its initial guess, and the collocation error at the end, are the derivatives of the impact's
# series by the small numbers. Errors of the variations are those of the impact, its tolerance,
# relative to the largest component.
#
# On moving ground P/m1 cos(omega t) is an acceleration F of both bodies and no part of e. In an
# inertial frame nothing drives the common motion. Let f be the integral of F, and let t include t0.
# Then x - f t and v - F t obey the equations above with V - f in place of V and with
#
#     e = -k1/m1 (x - f t) - c1/m1 (v - F t) - (k1/m1 f + c1/m1 F) t
#
# (`push_by_time`). They are converted at the beginning and at the end of the arc (`swept`).
#
# A four holds the four variations, at little more cost than one.


NODE_NUMBERS = 24  # of a node in `AtNode`


class Partial(NamedTuple):
    """Rows of partial derivatives at the nodes, in the scratch of variations."""

    e_t: int = ARC.variations  # of e by time
    b_e: int = ARC.variations + NODE_ROW  # of b' by e and by b, and so on
    b_b: int = ARC.variations + 2 * NODE_ROW
    t_e: int = ARC.variations + 3 * NODE_ROW
    t_b: int = ARC.variations + 4 * NODE_ROW
    v_e: int = ARC.variations + 5 * NODE_ROW
    v_b: int = ARC.variations + 6 * NODE_ROW


class AtNode(NamedTuple):
    """Places of fours, a number for each variation, in the scratch: of node 0, of node 1 ..."""

    b: int = ARC.variations + 10 * NODE_ROW
    e: int = ARC.variations + 10 * NODE_ROW + 4
    slope_b: int = ARC.variations + 10 * NODE_ROW + 8  # derivatives by phi of b, t, x - T v and v
    slope_t: int = ARC.variations + 10 * NODE_ROW + 12
    slope_w: int = ARC.variations + 10 * NODE_ROW + 16
    slope_v: int = ARC.variations + 10 * NODE_ROW + 20


PARTIAL, AT_NODE = Partial(), AtNode()


@jit
def swept(ps, cosine, sine):
    """Return (f, F) at a phase, the velocity and the acceleration by which moving ground sweeps."""
    if ps.shaken is None:
        return 0.0, 0.0
    return (ps.force / ps.omega) * sine, ps.force * cosine


@jit
def push_by_time(ps, cosine, sine):
    """Return the derivative of e by the time."""
    if ps.shaken is None:
        return (0.0 - ps.force * ps.omega) * sine
    f, both = swept(ps, cosine, sine)
    return 0.0 - (ps.stiffness * f + ps.damping * both)


@jit
def linearize(side, nodes, approach):
    """Fill the partial derivatives of the linearized equations, and V - f, at the nodes.

    They follow from d(ln per) = u^2 per/u da - 6 (1 + a u per) db / b, per = u / den.
    """
    ps, damper, wall, sign, w, at = side.ps, side.damper, side.wall, side.sign, nodes.w, nodes.at
    other, share, (c, d) = 1.0 - damper.share, sign * damper.share, approach.phase
    a1, a2 = ps.stiffness * share, ps.damping * share
    for i in range(0, nodes.m, 4):
        # The impact, as in `slopes_at`.
        b, u, S_u = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
        b2 = b * b
        b4 = b2 * b2
        u2 = u * u
        z, s = b4 * u2, (wall.speed * (b4 * b)) * S_u
        cosine, sine = cos_sin(ps.omega * four_at(w, ARC.times + i))
        cosine, sine = c * cosine - d * sine, d * cosine + c * sine
        push = ps.force * cosine
        push = push - shared(ps, push)
        push = push - (
            ps.stiffness * four_at(w, ARC.common_x + i) + ps.damping * four_at(w, ARC.common_v + i)
        )
        push = under(ps.load, push - (a1 * z + a2 * s))
        a = sign * push - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
        per = u / (wall.kappa * (b4 * b2) - a * u2)
        dt = (2.5 * wall.speed) * (b4 * b) * per
        # The derivatives of z, s and the accelerations by b.
        per_b = 1.0 / b
        z_b, s_b = 4.0 * z * per_b, 5.0 * s * per_b
        push_b = 0.0 - (a1 * z_b + a2 * s_b)
        a_b = sign * push_b - (damper.k2 * z_b + damper.c2 * s_b) * damper.inv_mu
        # The derivatives of b', t' and v'; those of b' and t' by a are `sign` times those by e.
        grows = 1.0 + a * u * per
        half = 0.5 * S_u * b * per
        b_a, t_a = half * grows, dt * u * per
        b_e, t_e = sign * b_a, sign * t_a
        b_b = half * a * per_b * (1.0 - 6.0 * grows) + b_a * a_b
        t_b = dt * per_b * (5.0 - 6.0 * grows) + t_a * a_b
        f, _ = swept(ps, cosine, sine)
        put_four(w, ARC.slope_v + i, four_at(w, ARC.common_v + i) - f)
        put_four(w, PARTIAL.e_t + i, push_by_time(ps, cosine, sine))
        put_four(w, PARTIAL.b_e + i, b_e)
        put_four(w, PARTIAL.b_b + i, b_b)
        put_four(w, PARTIAL.t_e + i, t_e)
        put_four(w, PARTIAL.t_b + i, t_b)
        put_four(w, PARTIAL.v_e + i, other * (push * t_e + dt))
        put_four(w, PARTIAL.v_b + i, other * (push * t_b + dt * push_b))


@jit
def guess(side, nodes, approach, pushes, faster):
    """Fill the initial guess of b and e at the nodes: the derivative of `impact.first_guess`.

    pushes: of `impact.pushes_varied`; faster: relative variation of the approach speed. The effect
    of the shares of s and z on the common motion is proportional to powers of that speed.
    """
    ps, w, b0, tick = side.ps, nodes.w, approach.b, approach.tick
    other, share = 1.0 - side.damper.share, side.sign * side.damper.share
    as_fast, slower = 0.2 * faster, -0.2 * faster
    push, first, second, third, fourth = pushes
    second, third, fourth = 0.5 * second, (1.0 / 6.0) * third, (1.0 / 24.0) * fourth
    # the derivatives of the push along the impact
    per = 2.5 * side.sign * approach.s / (tick * tick)
    climbs, bends = per * approach.drift, 2.0 * per / tick * approach.curvature
    twists = ps.force * ps.omega * ps.omega * ps.omega * approach.phase[1]
    twists = twists - shared(ps, twists)
    twists = 0.5 * (twists - (ps.stiffness * approach.jerk + ps.damping * approach.snap))
    # the shares
    z0 = (b0 * b0) * (b0 * b0)
    on_v = ps.damping * other * share
    first_share = (ps.stiffness * share - ps.damping * on_v) * other * z0 * tick
    second_share = ps.damping * first_share + ps.stiffness * on_v * z0 * tick
    on_u = 0.8 * ps.damping * on_v * z0
    on_cube, on_double = (
        0.6 * second_share,
        0.4 * tick * (ps.stiffness * first_share - ps.damping * other * second_share),
    )
    for i in range(nodes.m):
        k, at, time = NODE_NUMBERS * i, nodes.at + i, w[ARC.times + i]
        by_b, by_t, row = four(0.0), four(0.0), nodes.at + NODES.b * nodes.m + i
        for term in range(1, GUESSED):
            row, change = row + nodes.m, four_at(w, ARC.changes + 4 * term)
            by_b = by_b + w[row] * change
            by_t = by_t + w[row + (NODES.t - NODES.b) * nodes.m] * change
        b, t = w[ARC.amplitudes + i] * as_fast + b0 * by_b, time * slower + tick * by_t
        u, cube, double = w[at], w[at + NODES.cube * nodes.m], w[at + NODES.double * nodes.m]
        e = push + time * (first + time * (second + time * (third + time * fourth)))
        e = e + (climbs + time * (bends + time * twists)) * t
        e = e + (on_u * u * u + (on_cube * cube + on_double * double)) * faster
        put_four(w, AT_NODE.b + k, b)
        put_four(w, AT_NODE.e + k, e)


@jit
def pushes_varied(ps, damper, approach, late, x, v):
    """Return e at touch and its first four derivatives by time, without b and t.

    The common motion is accelerated by (1 - share) e, and on moving ground by its force in full.

    late: t0 [s]; x, v: variations of the common motion at the touch.
    """
    other, omega = 1.0 - damper.share, ps.omega
    drag, pull = ps.damping * other, ps.stiffness * other
    c, d = approach.phase
    sine, cosine = (ps.force * omega * d) * late, (ps.force * omega * c) * late
    if ps.shaken is None:
        push = 0.0 - sine - (ps.stiffness * x + ps.damping * v)
        first = (0.0 - omega) * cosine - (ps.stiffness * v + drag * push)
        second = (omega * omega) * sine - (pull * push + drag * first)
        third = (omega * omega * omega) * cosine - (pull * first + drag * second)
        fourth = 0.0 - (omega * omega * omega * omega) * sine - (pull * second + drag * third)
    else:
        push = 0.0 - (ps.stiffness * x + ps.damping * v)
        rate = 0.0 - sine
        first = 0.0 - (ps.stiffness * v + drag * push + ps.damping * rate)
        second = 0.0 - (pull * push + drag * first + ps.stiffness * rate)
        rate = (0.0 - omega) * cosine
        second = second - ps.damping * rate
        third = 0.0 - (pull * first + drag * second + ps.stiffness * rate)
        rate = (omega * omega) * sine
        third = third - ps.damping * rate
        fourth = 0.0 - (pull * second + drag * third + ps.stiffness * rate)
        rate = (omega * omega * omega) * cosine
        fourth = fourth - ps.damping * rate
    return push, first, second, third, fourth


@jit
def slopes_of_b(nodes):
    w = nodes.w
    for i in range(nodes.n):
        k = NODE_NUMBERS * i
        e, b = four_at(w, AT_NODE.e + k), four_at(w, AT_NODE.b + k)
        put_four(w, AT_NODE.slope_b + k, w[PARTIAL.b_e + i] * e + w[PARTIAL.b_b + i] * b)


@jit
def slopes_of_motion(nodes):
    w = nodes.w
    for i in range(nodes.n):
        k = NODE_NUMBERS * i
        e, b = four_at(w, AT_NODE.e + k), four_at(w, AT_NODE.b + k)
        t = w[PARTIAL.t_e + i] * e + w[PARTIAL.t_b + i] * b
        v = w[PARTIAL.v_e + i] * e + w[PARTIAL.v_b + i] * b
        put_four(w, AT_NODE.slope_t + k, t)
        put_four(w, AT_NODE.slope_w + k, w[ARC.slope_v + i] * t - w[ARC.times + i] * v)
        put_four(w, AT_NODE.slope_v + k, v)


@jit
def integrate_b(nodes, start):
    """Integrate b from touch to every node; return the largest change of each variation."""
    w, m, matrix = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m
    changed = four(0.0)
    for i in range(0, m, 4):
        b0, b1, b2, b3 = start, start, start, start
        for j in range(nodes.n):
            k, slope = matrix + j * m + i, four_at(w, AT_NODE.slope_b + NODE_NUMBERS * j)
            b0 = b0 + w[k] * slope
            b1 = b1 + w[k + 1] * slope
            b2 = b2 + w[k + 2] * slope
            b3 = b3 + w[k + 3] * slope
        k = AT_NODE.b + NODE_NUMBERS * i
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
    """Write e at node i; return its change. t, v: as in the text; x: without the term T v."""
    e = w[PARTIAL.e_t + i] * t - (ps.stiffness * (x + w[ARC.times + i] * v) + ps.damping * v)
    before = four_at(w, AT_NODE.e + NODE_NUMBERS * i)
    put_four(w, AT_NODE.e + NODE_NUMBERS * i, e)
    return e - before


@jit
def integrate_motion(ps, nodes, late, x0, v0, first):
    """Integrate t, x - T v and v to the nodes from `first` (even) on, and fill e there.

    late, x0, v0: t0, x and v at the touch; the slopes are those of `slopes_of_motion`. Returns the
    largest absolute change of e over these nodes, one for each variation.
    """
    w, m, matrix = nodes.w, nodes.m, nodes.at + NODES.matrix * nodes.m
    changed = four(0.0)
    for i in range(first, m, 2):
        t0, t1, y0, y1, z0, z1 = late, late, x0, x0, v0, v0
        for j in range(nodes.n):
            q, k = matrix + j * m + i, NODE_NUMBERS * j
            t, x = four_at(w, AT_NODE.slope_t + k), four_at(w, AT_NODE.slope_w + k)
            v = four_at(w, AT_NODE.slope_v + k)
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
def solve_variations(side, nodes, approach, took, tangent):
    """Solve for b and e of four variations `tangent` (16,) at the nodes of an arc.

    took [s]: its duration. Returns (start, push, faster): the differences (t0, b, x, v) at the
    touch, as they are integrated, the variation of the push there, and that of the approach speed,
    relative.
    """
    ps, damper, sign, rate = side.ps, side.damper, side.sign, side.rate
    linearize(side, nodes, approach)
    # The differences where the wall is met, t0 later; those of the common motion without s.
    s, share = approach.s, sign * damper.share
    x1, v1 = approach.x, approach.v + share * s
    drive = drive_now(approach.phase)
    dv, ds = accelerations_at(side, ps, (x1, v1, side.wall.gap, s), drive, 0.0)
    x, v, r, speed = columns_of(tangent)
    r, speed = sign * r, sign * speed
    late = (-1.0 / s) * r
    size = larger_of(larger_of(four(TINIEST), rate * r), v)
    x, v, _, speed = carried((x, v, r, speed), (v1, dv, s, ds), late)
    v = v - share * speed
    size = larger_of(larger_of(larger_of(size, speed), v), rate * x)
    # Their guess and the sweeps.
    faster = (1.0 / s) * speed
    pushes = pushes_varied(ps, damper, approach, late, x, v)
    f, both = swept(ps, approach.phase[0], approach.phase[1])
    x, v = x - f * late, v - both * late
    # The variations of the small numbers: the tick is proportional to s^(-1/5), the contact's
    # acceleration to s^(6/5).
    push, first, second, _, _ = pushes
    tick = approach.tick
    per = 0.4 * tick / s
    force = (sign * per) * push - (1.2 * approach.force) * faster
    drag = (-0.2 * approach.drag) * faster
    drift = (sign * tick * per) * first - (1.4 * approach.drift) * faster
    spring = (-0.4 * approach.spring) * faster
    curvature = (0.5 * sign * tick * tick * per) * second - (1.6 * approach.curvature) * faster
    # The variation of each term of the series, which is a product of two (`factors_of`).
    put_four(nodes.w, ARC.changes, four(0.0))
    put_four(nodes.w, ARC.changes + 4 * TERM.force, force)
    put_four(nodes.w, ARC.changes + 4 * TERM.drag, drag)
    put_four(nodes.w, ARC.changes + 4 * TERM.drift, drift)
    put_four(nodes.w, ARC.changes + 4 * TERM.spring, spring)
    put_four(nodes.w, ARC.changes + 4 * TERM.curvature, curvature)
    for k in range(1, MISSED):
        fewer, single = FACTORS[k], FACTORS[MISSED + k]
        change = nodes.w[ARC.products + fewer] * four_at(nodes.w, ARC.changes + 4 * single)
        change = change + nodes.w[ARC.products + single] * four_at(nodes.w, ARC.changes + 4 * fewer)
        put_four(nodes.w, ARC.changes + 4 * k, change)
    guess(side, nodes, approach, pushes, faster)
    # Sweeps until the relative error at the end is `enough`. The guess is right to third order, so
    # that a sweep multiplies an error of b by approach.size / 3 or less, and so does the integral
    # to the end; the time of release takes a fifth of it. An error of e grows at least as t^3: it
    # is largest at the last node, and a quarter of it acts. When e is settled, only b is iterated.
    b, enough, shrinks = (
        (0.2 * approach.b) * faster,
        side.arc.settled / SETTLED,
        approach.size / 3.0,
    )
    of_speed = 5.0 * approach.s / approach.b * (shrinks * (shrinks + 0.2 * (rate * took)))
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
        of_e = integrate_motion(ps, nodes, late, x, v, (nodes.n - 1) // 2 * 2)
        left = largest_of((0.25 * took) * of_e / size)
        if left + largest_of(of_speed * of_b / size) <= enough:
            break
    return (late, b, x, v), pushes[0], faster


@jit
def vary(side, phase, before, after, tangent):
    """Carry four variations `tangent` (16,) from touch to release of the impact solved last.

    Its unknowns are in the table of the arc. before: (s, x1, v1) at the touch; after: (s, x1, v1,
    duration [s]) at the release; phase: as of `short_impact`.
    """
    ps, wall, arc, sign = side.ps, side.wall, side.arc, side.sign
    share, approach = side.damper.share, approach_of(side, phase, before)
    n, m, at, table = nodes_of(arc, int(arc.table[ARC.used]), LEVEL.whole)
    w, took = bare(table), after[3]
    nodes = Nodes(n, m, at, w)
    start, push, faster = solve_variations(side, nodes, approach, took, tangent)
    # The differences at the end of the arc, t without t0.
    weight = at + NODES.weight * m
    _, b, x, v = start
    t = four(0.0)
    slopes_of_b(nodes)
    for i in range(n):
        k, q = NODE_NUMBERS * i, w[weight + i]
        b = b + q * four_at(w, AT_NODE.slope_b + k)
        t = t + q * four_at(w, AT_NODE.slope_t + k)
        x = x + q * four_at(w, AT_NODE.slope_w + k)
        v = v + q * four_at(w, AT_NODE.slope_v + k)
    x = x + took * v
    # The collocation errors of b [m^(1/4)] and of the time [s] are subtracted. Their variations
    # include that of the approach speed, with which b and tick change.
    errors, error_b, error_t = at + (NODES.matrix + n) * m, four(0.0), four(0.0)
    for k in range(1, MISSED):
        change = four_at(w, ARC.changes + 4 * k)
        error_b = error_b + w[errors + k] * change
        error_t = error_t + w[errors + MISSED + k] * change
    of_b, of_t, _ = missed(nodes)
    late = approach.tick * of_t
    longer = approach.tick * error_t - (0.2 * late) * faster
    b, t = b + approach.b * (error_b + (0.2 * of_b) * faster), t + longer
    f, both = swept(ps, phase[0], phase[1])
    x = x + (approach.v - f) * longer
    v = v + ((approach.acceleration - both) * longer + ((1.0 - share) * late) * push)
    # At equal time, t0 + t before the wall is left; b^5 is nearly that of the last node.
    s, x1, v1, _ = after
    last = w[ARC.amplitudes + n - 1]
    last2 = last * last
    off = -s / (wall.speed * (last2 * last2 * last)) - 1.0
    last = last * (1.0 + off * (0.2 - off * (0.08 - 0.048 * off)))
    speed = (5.0 * s / last) * b
    released = later(ps, phase, took)
    dv, ds = accelerations_at(side, ps, (x1, v1, wall.gap, s), drive_now(released), 0.0)
    back = start[0] + t
    f, both = swept(ps, released[0], released[1])
    x, v = x + f * back, v + both * back
    v = v + (sign * share) * speed
    x, v, r, speed = carried((x, v, four(0.0), speed), (v1, dv, s, ds), 0.0 - back)
    put_columns(tangent, (x, v, sign * r, sign * speed))


# ---- A response over a short impact, summed up at its own nodes ----------------------------------
#
# Products of states are as smooth in the arc's phase as the states, but they are not small
# corrections to the free arc: the number of nodes is that which integrates the products of the free
# arc to the tolerance, and an impact with fewer nodes is solved again.
#
# A maximum is at an end of the impact, which flights record, where its rate vanishes between two
# nodes, or, for depth, force and acceleration, near the deepest point. There the force falls to
# both sides with its curvature, and the maximum of the acceleration is found by a parabola. If that
# is not accurate enough, or another quantity may exceed its maximum, nothing is added, and the
# impact is stepped.


class RowsOfMotion(NamedTuple):
    """Rows of the structure's motion at the nodes, in the scratch of variations."""

    x1: int = ARC.variations
    v1: int = ARC.variations + NODE_ROW
    dv: int = ARC.variations + 2 * NODE_ROW  # dv1/dt
    a1: int = ARC.variations + 3 * NODE_ROW  # absolute acceleration
    jerk: int = ARC.variations + 4 * NODE_ROW  # its rate


MOTION = RowsOfMotion()


@jit
def motion_of_touch(side, ground, state, phase):
    """Return (x1, v1, dv1/dt, a1, jerk) of a state (s, x1, v1) at touch; ground: of a `Tally`."""
    s, x1, v1 = state
    drive = drive_now(phase)
    dv, ds = accelerations_at(side, side.ps, (x1, v1, side.wall.gap, s), drive, 0.0)
    jerk, _ = accelerations_at(side, unloaded(side.ps), (v1, dv, s, ds), 0.0, 0.0)
    jerk -= in_absolute(ground, falling(side.ps, phase))
    return x1, v1, dv, absolute(ground, dv, drive), jerk


@jit
def sums_at_nodes(side, nodes, approach, ground):
    """Fill `RowsOfMotion`; return the first seven integrals of a tally (`response_sums`)."""
    ps, wall, sign, w, at = side.ps, side.wall, side.sign, nodes.w, nodes.at
    share = sign * side.damper.share
    of_x, of_v, of_a, of_r = four(0.0), four(0.0), four(0.0), four(0.0)
    of_s, work, other = four(0.0), four(0.0), four(0.0)
    for i in range(0, nodes.m, 4):
        _, _, per, _, _ = slopes_at(side, nodes, approach, i)
        dt = per * four_at(w, at + NODES.weight * nodes.m + i)
        b, u, S_u = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
        time, b2 = four_at(w, ARC.times + i), b * b
        b4, root = b2 * b2, b2 * u
        z, s = root * root, (wall.speed * (b4 * b)) * S_u
        x1 = four_at(w, ARC.common_x + i) + share * z
        v1 = four_at(w, ARC.common_v + i) + share * s
        r, drive = wall.gap + z, drive_later(ps, approach.phase, time)
        dv, ds = accelerations_at(side, ps, (x1, v1, r, s), drive, wall.K * z * root)
        push = 1.5 * wall.K * root * s
        jerk, _ = accelerations_at(side, unloaded(ps), (v1, dv, s, ds), 0.0, push)
        a1 = absolute(ground, dv, drive)
        falls = falling(ps, later(ps, approach.phase, time))
        put_four(w, MOTION.x1 + i, x1)
        put_four(w, MOTION.v1 + i, v1)
        put_four(w, MOTION.dv + i, dv)
        put_four(w, MOTION.a1 + i, a1)
        put_four(w, MOTION.jerk + i, jerk - in_absolute(ground, falls))
        of_x, of_v, of_a = of_x + dt * x1 * x1, of_v + dt * v1 * v1, of_a + dt * a1 * a1
        of_r, of_s, work = of_r + dt * r * r, of_s + dt * s * s, work + dt * drive * v1
        other = other + dt * drive * (sign * s)
    return (
        sum_of(of_x), sum_of(of_v), sum_of(of_a), sum_of(of_r), sum_of(of_s), sum_of(work),
        sum_of(other),
    )  # fmt: skip


@jit
def may_rise(row, which, values, rates, time):
    """Return True if a quantity may exceed its maximum so far within a `time` [s].

    values, rates: those at both ends; it may where the rate changes its sign.
    """
    if not opposite(rates[0], rates[1]):
        return False
    before, after = abs(values[0]) + abs(rates[0]) * time, abs(values[1]) + abs(rates[1]) * time
    return min(before, after) > row[place_of_largest(which, 1.0)]


@jit
def rises_between(tally, before, after, time, deepest):
    """Return True if a maximum so far may be exceeded between two nodes, a `time` [s] apart.

    before, after: (x1, v1, dv, a1, jerk) there; deepest: whether the deepest point is in between,
    where `about_deepest` finds the maximum of a1.
    """
    row = tally.row
    x0, v0, dv0, a0, j0 = before
    x1, v1, dv1, a1, j1 = after
    rises = may_rise(row, int(OF_X), (x0, x1), (v0, v1), time)
    rises = rises or may_rise(row, int(OF_V), (v0, v1), (dv0, dv1), time)
    return rises or (not deepest and may_rise(row, int(OF_A), (a0, a1), (j0, j1), time))


@jit
def about_deepest(side, approach, ground):
    """Return the maxima of a1, r and the force near the deepest point, and the error of a1.

    The error is relative to the contact's part of a1.
    """
    ps, wall, sign = side.ps, side.wall, side.sign
    _, ratio, took, x, v1 = solve_arc(side, LEVEL.half, LEVEL.half_error, approach)
    b = approach.b * ratio
    root = b * b
    z, phase = root * root, later(ps, approach.phase, took)
    x1, r, force = x + sign * side.damper.share * z, wall.gap + z, wall.K * z * root
    drive, falls = drive_now(phase), falling(ps, phase)
    dv, ds = accelerations_at(side, ps, (x1, v1, r, 0.0), drive, force)
    jerk, twist = accelerations_at(side, unloaded(ps), (v1, dv, 0.0, ds), 0.0, 0.0)
    twist -= sign * (falls - shared(ps, falls))
    push = 1.5 * wall.K * root * ds
    snap, _ = accelerations_at(side, unloaded(ps), (dv, jerk - falls, ds, twist), 0.0, push)
    jerk -= in_absolute(ground, falls)
    snap -= in_absolute(ground, bending(ps, phase))
    a1, turn = absolute(ground, dv, drive), jerk / snap
    beside_it = abs(turn) / approach.tick
    off = beside_it * beside_it * beside_it * (approach.size + beside_it)
    return a1 - 0.5 * turn * jerk, r, force, 10.0 * off


@jit
def tally_nodes(side, tally, phase, now, after):
    """Add a solved impact to a tally and return True, or return False and add nothing.

    phase: the instant of its touch; now: (q, s, x1, v1) there; after: (s, x1, v1, duration [s]) at
    the release. Overwrites the unknowns at the nodes.
    """
    arc, row, ground, (_, s, x1, v1) = side.arc, tally.row, tally.ground, now
    approach = approach_of(side, phase, (s, x1, v1))
    level = 0  # the first whose integrals over the free arc are within the tolerance, or the last
    while level < arc.levels - 1:
        if arc.table[ARC.levels + LEVEL_ROW * level + LEVEL.summed] <= arc.tolerance:
            break
        level += 1
    n, m, at, table = nodes_of(arc, max(level, int(arc.table[ARC.used])), LEVEL.whole)
    nodes = Nodes(n, m, at, bare(table))
    if level > arc.table[ARC.used] and not settle(side, nodes, approach, arc.settled):
        return False
    sums = sums_at_nodes(side, nodes, approach, ground)
    begin = motion_of_touch(side, ground, (s, x1, v1), phase)
    s, x1, v1, took = after
    end = motion_of_touch(side, ground, (s, x1, v1), later(side.ps, phase, took))
    # A maximum so far that may be exceeded between two nodes is not found here.
    w, last, time = nodes.w, begin, 0.0
    for i in range(n):
        a1, jerk = w[MOTION.a1 + i], w[MOTION.jerk + i]
        here = w[MOTION.x1 + i], w[MOTION.v1 + i], w[MOTION.dv + i], a1, jerk
        deepest = w[at + m + i] <= 0.0 and (i == 0 or w[at + m + i - 1] > 0.0)
        if rises_between(tally, last, here, w[ARC.times + i] - time, deepest):
            return False
        last, time = here, w[ARC.times + i]
    if rises_between(tally, last, end, took - time, False):
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


class Recalled(NamedTuple):
    """Places in the results of an impact, which the scratch of an arc's table recalls.

    Results that are not known are NaN.
    """

    touch: int = 0  # (s, x1, v1, cos, sin)
    rises: int = 5  # by which E1 and E2 exceed their values at touch, and those at release
    share: int = 9  # its share of a response: the NUMBERS of a tally's row
    cut: int = 29  # time [s] from touch to the section that cut it, and (q, s, x1, v1) there
    to_cut: int = 34  # unit variations (16,) carried from touch to the cut
    from_cut: int = 50  # the same from the cut to the release
    size: int = 66


RECALLED, MOST_RECALLED = Recalled(), 4
# after the results of all: the number of the impact that is forgotten next, and room for variations
NEXT_RECALLED = ARC.recalled + RECALLED.size * MOST_RECALLED
WAITING = NEXT_RECALLED + 1
RECALLED_NUMBERS = RECALLED.size * MOST_RECALLED + 1
SAME = 0.3  # largest difference of equal impacts, in units of the error that sweeps may leave
GROWS = 2.0  # bound of the forces beside the contact's in an impact, in units of those at its ends
# Tolerance of stepped variations, driven ones of solved impacts, too: SURER times that of the orbit
# and at most VERIFIED. Variations driven by K, which arise in impacts alone, then err by 1e-9, all
# others by 1e-11, or by the tolerance if that is less.
SURER, VERIFIED = 0.1, 2.5e-11


class Ahead(NamedTuple):
    """A solved impact while the orbit is inside it; took [s] is 0 if there is none."""

    took: float  # from touch to release [s]
    elapsed: float  # since touch [s]
    depth: float  # the greatest [m], 0 if it is not recorded
    touch: tuple[float, float, float]  # s, x1, v1
    release: tuple[float, float, float]


@jit
def read_ahead(k):
    touch = k[AHEAD + 3], k[AHEAD + 4], k[AHEAD + 5]
    release = k[AHEAD + 6], k[AHEAD + 7], k[AHEAD + 8]
    return Ahead(k[AHEAD], k[AHEAD + 1], k[AHEAD + 2], touch, release)


@jit
def side_backward(side):
    """Return a side backward in time: with negative damping."""
    ps, damper = side.ps, side.damper
    turned = Structure(
        ps.m1, ps.k1, ps.stiffness, -ps.damping, ps.force, ps.omega, ps.load, ps.shaken
    )
    if is_a(damper, Ground):  # it has no dashpot
        return side_with(side, turned, damper, side.wall, side.steps)
    joint = Damper(
        damper.m2, damper.k2, -damper.c2, damper.inv_m1, damper.inv_mu, damper.share, damper.rest
    )
    return side_with(side, turned, joint, side.wall, side.steps)


@jit
def from_release(side, phase, ahead):
    """Return (side, phase, (q, s, x1, v1)) at the release of an impact, backward in time.

    phase: the instant (`drive`) of its touch, here and below.
    """
    s, x1, v1 = ahead.release
    end = later(side.ps, phase, ahead.took)
    if is_a(phase, Moment):
        then: Any = Moment(end.w, end.row, end.degree, end.x, -end.length)
    else:
        then = end[0], -end[1]
    return side_backward(side), then, (0.0, -s, x1, -v1)


@jit
def place_of(side, phase, touch):
    """Return the place in the table of the results of an impact; those of a new one are NaN.

    Under a load each impact is new. touch: (s, x1, v1).
    """
    if is_a(phase, Moment):
        return new_place(side.arc.table)
    w, (s, x1, v1), (c, d), rate = side.arc.table, touch, phase, side.rate
    s *= side.sign  # the two walls have one table
    scale = abs(s) + abs(v1) + rate * abs(x1)
    for i in range(MOST_RECALLED):
        at = ARC.recalled + RECALLED.size * i
        apart = abs(w[at] - s) + rate * abs(w[at + 1] - x1) + abs(w[at + 2] - v1)
        apart += scale * (abs(w[at + 3] - c) + abs(w[at + 4] - d))
        if apart <= SAME * side.arc.settled * scale:
            return at
    at = new_place(w)
    w[at], w[at + 1], w[at + 2], w[at + 3], w[at + 4] = s, x1, v1, c, d
    return at


@jit
def new_place(w):
    """Return the place of the oldest results, set to NaN."""
    at = ARC.recalled + RECALLED.size * int(w[NEXT_RECALLED])
    w[NEXT_RECALLED] = w[NEXT_RECALLED] + 1.0 if w[NEXT_RECALLED] < MOST_RECALLED - 1.0 else 0.0
    for i in range(RECALLED.rises, RECALLED.size):
        w[at + i] = math.nan
    return at


# ---- energies ------------------------------------------------------------------------------------


@jit
def where_peaks_are(side, energy, phase, ahead):
    """Return the times [s] after the touch and before the release within which an energy may peak.

    A time is 0 if no energy can exceed its maximum so far. It is at most the time to the depth at
    which the contact's force equals that of all others. If those are x times the contact's largest
    force, that depth is x^(2/3) times the greatest, and the time at most sqrt(x) times the
    duration. There is no peak if an energy falls from the end on and neither the velocity nor the
    other forces change their sign.
    """
    ps, damper, sign, took = side.ps, side.damper, side.sign, ahead.took
    (s, x, v), (u, y, w), r = ahead.touch, ahead.release, sign * side.wall.gap
    deep = took * max(s, -u) / LASTING
    s, u = sign * s, sign * u
    f = powers_at(ps, damper, x, v, r, s, drive_now(phase))
    g = powers_at(ps, damper, y, w, r, u, drive_now(later(ps, phase, took)))
    e0, e1 = energies(ps, damper, x, v, r, s), energies(ps, damper, y, w, r, u)
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

    now: (q, s, x1, v1) there, phase: the instant; at: place of the recalled rises.
    """
    w, (_, s, x1, v1), sign = side.arc.table, now, side.sign
    e = energies(side.ps, side.damper, x1, v1, sign * side.wall.gap, sign * s)
    if not w[at] >= 0.0:
        before = energy[0], energy[1]
        energy[0], energy[1] = e
        contact(side, Watch(None, energy, None, None, None, None), phase, now, soon)
        w[at], w[at + 1] = energy[0] - e[0], energy[1] - e[1]
        energy[0], energy[1] = before
    raise_energies(energy, (e[0] + w[at], e[1] + w[at + 1]))


@jit
def note_inside(side, energy, phase, ahead, now, lasting):
    """Raise the largest energies to those in the next `lasting` [s] of a solved impact.

    ahead: `Ahead`; now: (q, s, x1, v1) at present.
    """
    early, late = where_peaks_are(side, energy, phase, ahead)
    if not early + late > 0.0:
        return
    if ahead.elapsed > 0.0 or lasting < ahead.took:
        then = later(side.ps, phase, ahead.elapsed)
        contact(side, Watch(None, energy, None, None, None, None), then, now, lasting)
        return
    at = place_of(side, phase, ahead.touch) + RECALLED.rises
    if early > 0.0:
        note_end(side, energy, phase, now, early, at)
    if late > 0.0:
        other, wave, then = from_release(side, phase, ahead)
        note_end(other, energy, wave, then, late, at + 2)


# ---- states and variations -----------------------------------------------------------------------


@jit
def state_inside(side, phase, ahead, time):
    """Return (q, s, x1, v1) a `time` [s] after the touch of a solved impact.

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
    """Return the place of the results of an impact that a section cuts; fill its state there.

    phase: (cos, sin) at its touch; the section is `ahead.elapsed` later.
    """
    w, at = side.arc.table, place_of(side, phase, ahead.touch)
    cut = at + RECALLED.cut
    if not abs(w[cut] - ahead.elapsed) <= SAME * side.arc.settled * ahead.took:
        w[cut + 1], w[cut + 2], w[cut + 3], w[cut + 4] = state_inside(
            side, phase, ahead, ahead.elapsed
        )
        w[cut], w[at + RECALLED.to_cut], w[at + RECALLED.from_cut] = (
            ahead.elapsed, math.nan, math.nan
        )  # fmt: skip
    return at


@jit
def state_at_section(side, phase, ahead):
    """Return (q, s, x1, v1) of a solved impact at a section, `ahead.elapsed` after its touch.

    phase: (cos, sin) at touch.
    """
    w, at = side.arc.table, place_of_cut(side, phase, ahead) + RECALLED.cut + 1
    return w[at], w[at + 1], w[at + 2], w[at + 3]


@jit
def variations_finely(side):
    steps = side.steps
    fine = Steps(steps.per_impact, min(SURER * steps.tolerance, VERIFIED))
    return side_with(side, side.ps, side.damper, side.wall, fine)


@jit
def put_unit(tangent):
    for i in range(16):
        tangent[i] = 1.0 if i % 5 == 0 else 0.0


@jit
def turn(tangent):
    """Change the direction of time: the signs of v1 and s of four variations."""
    for i in range(1, 16, 2):
        tangent[i] = -tangent[i]


@jit
def carry_by(w, at, tangent):
    """Carry four variations (16,) by the images of unit variations, which stand from `at` on."""
    for i in range(0, 16, 4):
        sums = four(0.0)
        for j in range(4):
            sums = sums + tangent[i + j] * four_at(w, at + 4 * j)
        put_four(tangent, i, sums)


@jit
def cut_in_two(side, phase, ahead, tangent, at):
    """Fill the images of unit variations from touch to a section inside an impact, and from there.

    The impact is a matrix R, a row for each unit variation, and R = F S with the section between F
    and S. F or the inverse of S is stepped, the other one follows. tangent (16,): scratch; phase:
    (cos, sin) at touch; at: `place_of_cut`.
    """
    w, (s, x1, v1), (out, a1, b1) = side.arc.table, ahead.touch, ahead.release
    put_unit(tangent)
    short_impact(side, None, phase, (0.0, s, x1, v1))
    vary(side, phase, ahead.touch, (out, a1, b1, ahead.took), tangent)
    for i in range(16):
        w[at + RECALLED.from_cut + i] = tangent[i]  # R, for now
    # Unit variations to the cut, from the nearer end.
    now, left, early = (0.0, s, x1, v1), ahead.elapsed, True
    put_unit(tangent)
    if not left + left <= ahead.took:
        side, phase, now = from_release(side, phase, ahead)
        left, early = ahead.took - left, False
        turn(tangent)
    only = Watch(None, None, None, None, tangent, None)
    contact(variations_finely(side), only, phase, now, left)
    if not early:
        turn(tangent)
    matrix, right = np.empty((4, 4)), np.empty((4, 4))
    for i in range(16):
        w[at + RECALLED.to_cut + i], matrix[i // 4, i % 4] = tangent[i], tangent[i]
        right[i // 4, i % 4] = w[at + RECALLED.from_cut + i]
    if not early:
        for i in range(16):
            tangent[i] = w[at + RECALLED.from_cut + i]
            right[i // 4, i % 4] = 1.0 if i % 5 == 0 else 0.0
        carry_by(w, at + RECALLED.to_cut, tangent)
        for i in range(16):
            w[at + RECALLED.to_cut + i] = tangent[i]
    solve(matrix, right)
    for i in range(16):
        w[at + RECALLED.from_cut + i] = right[i // 4, i % 4]


@jit
def vary_inside(side, phase, tangent, ahead, begins):
    """Carry four variations (16,) from touch to the section that cuts an impact, or from there.

    To the section if the impact `begins`, otherwise to the release. ahead: `Ahead`, the section
    being `ahead.elapsed` after touch; phase: (cos, sin) at touch. The images of unit variations are
    recalled.
    """
    w, at = side.arc.table, place_of_cut(side, phase, ahead)
    if not abs(w[at + RECALLED.to_cut]) < math.inf:
        for i in range(16):
            w[WAITING + i] = tangent[i]
        cut_in_two(side, phase, ahead, tangent, at)
        for i in range(16):
            tangent[i] = w[WAITING + i]
    carry_by(w, at + (RECALLED.to_cut if begins else RECALLED.from_cut), tangent)


# ---- a response ----------------------------------------------------------------------------------


@jit
def tally_inside(side, tally, phase, now, after):
    """Add a solved impact to a tally.

    phase: the instant of its touch; now, after: as of `tally_nodes`. Under a harmonic force the
    impact is stepped once, and its share recalled; under a load it is stepped if `tally_nodes`
    adds nothing.
    """
    if is_a(phase, Moment):
        if not tally_nodes(side, tally, phase, now, after):
            contact(side, Watch(None, None, None, None, None, tally), phase, now, math.inf)
        return
    w, row = side.arc.table, tally.row
    at = place_of(side, phase, (now[1], now[2], now[3])) + RECALLED.share
    if not w[at] >= 0.0:
        for i in range(NUMBERS):
            row[BEFORE + i], row[i] = row[i], 0.0
        contact(side, Watch(None, None, None, None, None, tally), phase, now, math.inf)
        for i in range(NUMBERS):
            w[at + i], row[i] = row[i], row[BEFORE + i]
    for i in range(SUMS):
        row[i] += w[at + i]
    for i in range(MOST, NUMBERS):
        raise_to(row, i, w[at + i])
