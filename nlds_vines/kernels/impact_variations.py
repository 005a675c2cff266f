"""Variations through a short impact: its collocation, linearised at the nodes.

Four small differences from an orbit ride through the impact that `impact` has solved. They are
differences at one time; the collocation has differences at one phase phi of the arc. At the touch
the wall is met later by t0 = -r / s, r and s being a variation's and the orbit's own, and a
variation y becomes y + y' t0; at the release, which comes later by t0 and by what the impact lasts
longer, it turns back. (y' is continuous there: the contact's force begins and ends with zero.)

In between, the differences (b, t, x, v) of amplitude, time and common motion obey, a dot being the
derivative by phi along the impact and e what accelerates them apart from b,

    e = P/m1 d(cos)/dt (t0 + t) - k1/m1 x - c1/m1 v
    b' = B_E e + B_B b      t' = T_E e + T_B b      x' = V t' + (dt/dphi) v      v' = V_E e + V_B b

with factors at the nodes that the impact fixes (`linearise`). That is a linear fixed point which
contracts as that of the impact does, by about one per cent a sweep. The sweeps start from the series
of the impact, differentiated by its five small numbers; so is what the nodes miss in the end.

A vector of four holds the four variations, so that they cost little more than one.
"""

from __future__ import annotations

from .compiling import jit
from .contact_field import cos_sin, rotated
from .elementary import fifth_root
from .fours import four, four_at, four_of, larger_of, largest_of, number_of, put_four
from .impact import (
    BY_TIME,
    CUBE,
    GB,
    LENGTH,
    MATRIX,
    MOST_SWEEPS,
    ROW,
    USED,
    VARIED,
    WEIGHT,
    WHOLE,
    B,
    G,
    H,
    T,
    approach_of,
    nodes_of,
)
from .scene import accelerations

# The scratch of variations in the table of an arc, from VARIED on.
#
#   from         numbers    what
#   E_T ... V_B  8 ROW      factors at the nodes: of time in e; of e and of b in the derivatives
#   DT           ROW        dt/dphi
#   BY           5 ROW      b / b0 by the five small numbers, of the series
#   NODE         32 ROW     node by node, four variations each: b, t, x, v, and their derivatives
E_T, B_E, B_B, T_E, T_B, V_E, V_B, DT = (VARIED + ROW * i for i in range(8))
BY = VARIED + 8 * ROW
NODE, EACH = VARIED + 13 * ROW, 32
DB, TIME, X, V, FB, FT, FX, FV = (NODE + 4 * i for i in range(8))
LEFT = 4.0  # what the sweeps may leave of a variation, in units of what those of the impact may
TINIEST = 1.0e-300  # size of a variation, so that nothing is divided by zero


@jit
def linearise(ps, damper, wall, nodes, approach):
    """Fill the factors of the linearised equations at the nodes.

    All follow from d(ln per) = u^2 per/u da - 6 (1 + a u per) db / b, per = u / den.
    """
    w, at = nodes.w, nodes.at
    other, a1, a2 = 1.0 - damper.share, ps.stiffness * damper.share, ps.damping * damper.share
    for i in range(0, nodes.m, 4):
        # The impact, as in `slopes_at`.
        b, u, S_u = four_at(w, B + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
        b2 = b * b
        b4 = b2 * b2
        u2 = u * u
        z, s = b4 * u2, (wall.speed * (b4 * b)) * S_u
        cosine, sine = cos_sin(ps.omega * four_at(w, T + i))
        push = ps.force * (approach.c * cosine - approach.d * sine)
        push = push - (ps.stiffness * four_at(w, G + i) + ps.damping * four_at(w, H + i))
        push = push - (a1 * z + a2 * s)
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
        put_four(w, E_T + i, (0.0 - ps.force * ps.omega) * (approach.d * cosine + approach.c * sine))
        put_four(w, B_E + i, b_e)
        put_four(w, B_B + i, b_b)
        put_four(w, T_E + i, t_e)
        put_four(w, T_B + i, t_b)
        put_four(w, V_E + i, other * (push * t_e + dt))
        put_four(w, V_B + i, other * (push * t_b + dt * push_b))
        put_four(w, DT + i, dt)


@jit
def forces_varied(ps, damper, approach, late, x, v):
    """Return what variations change of the forces at touch: push, slope and bend of `approach_of`.

    late: t0 [s]; x, v: of the common motion at the touch.
    """
    other, omega = 1.0 - damper.share, ps.omega
    push = 0.0 - (ps.force * omega * approach.d) * late - (ps.stiffness * x + ps.damping * v)
    slope = (ps.force * omega * omega * approach.c) * late + ps.stiffness * v
    slope = slope + (ps.damping * other) * push
    bend = (ps.stiffness * other) * push - (ps.force * omega * omega * omega * approach.d) * late
    return push, slope, bend - (ps.damping * other) * slope


@jit
def numbers_varied(approach, forces, faster):
    """Return what variations change of (A, D, R, Z, Q), a four of each.

    forces: by `forces_varied`; faster: of the approach speed, relative. (As b^5 is s, the tick goes
    with s^(-1/5), the contact's own acceleration with s^(6/5).)
    """
    push, slope, bend = forces
    tick = approach.tick
    per = 0.4 * tick / approach.s
    force = per * push - (1.2 * approach.force) * faster
    drag = (-0.2 * approach.drag) * faster
    drift = (-tick * per) * slope - (1.4 * approach.drift) * faster
    spring = (-0.4 * approach.spring) * faster
    curvature = (-0.5 * tick * tick * per) * bend - (1.6 * approach.curvature) * faster
    return force, drag, drift, spring, curvature


@jit
def amplitudes_by_numbers(nodes, approach):
    """Fill the rows BY, the derivatives of b / b0 by the five numbers, from its series."""
    w, m = nodes.w, nodes.m
    a, d, r = approach.force, approach.drag, approach.drift
    for i in range(0, m, 4):
        k = nodes.at + GB * m + i
        ad, ar, dr = four_at(w, k + 4 * m), four_at(w, k + 7 * m), four_at(w, k + 8 * m)
        by_a = four_at(w, k) + ((2.0 * a) * four_at(w, k + 3 * m) + (d * ad + r * ar))
        by_d = four_at(w, k + m) + ((2.0 * d) * four_at(w, k + 5 * m) + (a * ad + r * dr))
        put_four(w, BY + i, by_a)
        put_four(w, BY + ROW + i, by_d)
        put_four(w, BY + 2 * ROW + i, four_at(w, k + 2 * m) + (a * ar + d * dr))
        put_four(w, BY + 3 * ROW + i, four_at(w, k + 6 * m))
        put_four(w, BY + 4 * ROW + i, four_at(w, k + 9 * m))


@jit
def guess(ps, damper, nodes, approach, forces, numbers, x, v, faster):
    """Fill the variations at the nodes, as `impact.first_guess`: b by the series, others by Taylor."""
    w, b0, other = nodes.w, approach.b, 1.0 - damper.share
    force, drag, drift, spring, curvature = numbers
    as_fast, slower = 0.2 * faster, -0.2 * faster
    push, slope, _ = forces
    acceleration, jerk = other * push, (-0.5 * other) * slope
    pull = other * damper.share * ((b0 * b0) * (b0 * b0))
    on_v, sink = 0.8 * ps.damping * pull, 0.6 * ps.stiffness * pull * approach.tick
    for i in range(nodes.n):
        k, at = NODE + EACH * i, BY + i
        b = w[at] * force + w[at + ROW] * drag + w[at + 2 * ROW] * drift
        b = b + (w[at + 3 * ROW] * spring + w[at + 4 * ROW] * curvature)
        time, u, cube = w[T + i], w[nodes.at + i], w[nodes.at + CUBE * nodes.m + i]
        t = time * slower
        change = time * (acceleration + time * jerk)
        change = change + (approach.acceleration + time * approach.jerk) * t
        put_four(w, k, w[B + i] * as_fast + b0 * b)
        put_four(w, k + 4, t)
        put_four(w, k + 8, x + (time * (v + (0.5 * time) * acceleration) + w[H + i] * t))
        put_four(w, k + 12, v + (change - (on_v * u * u + sink * cube) * faster))


@jit
def pushes(ps, nodes, late, i):
    """Return e at node i."""
    w, k = nodes.w, NODE + EACH * i
    apart = ps.stiffness * four_at(w, k + 8) + ps.damping * four_at(w, k + 12)
    return w[E_T + i] * (late + four_at(w, k + 4)) - apart


@jit
def slopes_by_push(ps, nodes, late):
    """Fill the derivatives of time and common velocity at all nodes."""
    w = nodes.w
    for i in range(nodes.n):
        k = NODE + EACH * i
        e, b = pushes(ps, nodes, late, i), four_at(w, k)
        put_four(w, k + 20, w[T_E + i] * e + w[T_B + i] * b)
        put_four(w, k + 28, w[V_E + i] * e + w[V_B + i] * b)


@jit
def slopes_by_speed(ps, nodes, late):
    """Fill the derivatives of amplitude and common displacement at all nodes."""
    w = nodes.w
    for i in range(nodes.n):
        k = NODE + EACH * i
        e, b = pushes(ps, nodes, late, i), four_at(w, k)
        put_four(w, k + 16, w[B_E + i] * e + w[B_B + i] * b)
        put_four(w, k + 24, w[H + i] * four_at(w, k + 20) + w[DT + i] * four_at(w, k + 12))


@jit
def integrate_two(nodes, at, start, other):
    """Integrate two derivatives from touch to every node; return the largest changes of both.

    They are those of the unknowns at places `at` and at + 8 of a node, which begin with `start` and
    `other`.
    """
    w, n, m, matrix = nodes.w, nodes.n, nodes.m, nodes.at + MATRIX * nodes.m
    one, two = four(0.0), four(0.0)
    for i in range(n):
        y, z = start, other
        for j in range(n):
            q, k = w[matrix + j * m + i], NODE + EACH * j + at + 16
            y = y + q * four_at(w, k)
            z = z + q * four_at(w, k + 8)
        k = NODE + EACH * i + at
        one = larger_of(one, y - four_at(w, k))
        two = larger_of(two, z - four_at(w, k + 8))
        put_four(w, k, y)
        put_four(w, k + 8, z)
    return one, two


@jit
def missed_varied(nodes, approach, numbers, faster):
    """Return what variations change of `impact.missed`: of b / b0 and of time / tick."""
    w, k = nodes.w, nodes.at + MATRIX * nodes.m + nodes.n * nodes.m
    force, drag, drift, spring, curvature = numbers
    a, d, r = approach.force, approach.drag, approach.drift
    z, q = approach.spring, approach.curvature
    ad, ar, dr = four_at(w, k + 20), four_at(w, k + 32), four_at(w, k + 36)
    by_a = four_at(w, k + 4) + ((2.0 * a) * four_at(w, k + 16) + (d * ad + r * ar))
    by_d = four_at(w, k + 8) + ((2.0 * d) * four_at(w, k + 24) + (a * ad + r * dr))
    by_r = four_at(w, k + 12) + (a * ar + d * dr)
    by_z, by_q = four_at(w, k + 28), four_at(w, k + 40)
    missed = four_at(w, k) + (a * four_at(w, k + 4) + d * four_at(w, k + 8))
    missed = missed + (r * four_at(w, k + 12) + z * four_at(w, k + 28))
    so_late = number_of(missed, 1)
    # third and fourth order
    aaa, aad, add = four_at(w, k + 44), four_at(w, k + 48), four_at(w, k + 52)
    az, ddd, dz = four_at(w, k + 56), four_at(w, k + 60), four_at(w, k + 64)
    rr = four_at(w, k + 68)
    by_a = by_a + (((3.0 * a * a) * aaa + (2.0 * a * d) * aad) + ((d * d) * add + z * az))
    by_d = by_d + (((a * a) * aad + (2.0 * a * d) * add) + ((3.0 * d * d) * ddd + z * dz))
    by_r = by_r + (2.0 * r) * rr
    by_z = by_z + (a * az + d * dz)
    ratio = number_of(by_a, 0) * force + number_of(by_d, 0) * drag + number_of(by_r, 0) * drift
    ratio = ratio + (number_of(by_z, 0) * spring + number_of(by_q, 0) * curvature)
    time = number_of(by_a, 1) * force + number_of(by_d, 1) * drag + number_of(by_r, 1) * drift
    time = time + (number_of(by_z, 1) * spring + number_of(by_q, 1) * curvature)
    ratio = ratio + (0.2 * number_of(missed, 0)) * faster
    return ratio, time - (0.2 * so_late) * faster, so_late


@jit
def vary(ps, damper, wall, arc, rate, phase, before, after, tangent):
    """Carry four variations `tangent` (16,) from touch to release of an impact just solved.

    The table of the arc holds its unknowns. before: (s, x1, v1) at the touch; after: (s, x1, v1,
    duration [s]) at the release; phase: (c, d) and rate as for `short_impact`.
    """
    c, d = phase
    s, x1, v1 = before
    approach = approach_of(ps, damper, wall, s, x1, v1, c, d)
    nodes = nodes_of(arc, int(arc.table[USED]), int(WHOLE))
    linearise(ps, damper, wall, nodes, approach)
    # The differences where the wall is met, t0 later.
    dv, ds = accelerations(ps, damper, x1, v1, wall.gap, s, c, 0.0)
    r = four_of(tangent[2], tangent[6], tangent[10], tangent[14])
    late = (-1.0 / s) * r
    speed = four_of(tangent[3], tangent[7], tangent[11], tangent[15])
    x = four_of(tangent[0], tangent[4], tangent[8], tangent[12])
    v = four_of(tangent[1], tangent[5], tangent[9], tangent[13])
    size = larger_of(larger_of(four(TINIEST), rate * r), v)
    speed = speed + ds * late
    x = x + v1 * late
    v = v + dv * late - damper.share * speed
    faster = (1.0 / s) * speed
    size = larger_of(larger_of(larger_of(size, speed), v), rate * x)
    # The sweeps, as in `settle`.
    forces = forces_varied(ps, damper, approach, late, x, v)
    numbers = numbers_varied(approach, forces, faster)
    amplitudes_by_numbers(nodes, approach)
    guess(ps, damper, nodes, approach, forces, numbers, x, v, faster)
    shrinks = approach.size + BY_TIME * rate * (approach.tick * LENGTH)
    enough, of_speed = LEFT * arc.settled / (shrinks * shrinks), 5.0 * s / approach.b
    b0 = (0.2 * approach.b) * faster
    for _ in range(MOST_SWEEPS):
        slopes_by_push(ps, nodes, late)
        _, of_v = integrate_two(nodes, 4, four(0.0), v)
        slopes_by_speed(ps, nodes, late)
        of_b, of_x = integrate_two(nodes, 0, b0, x)
        if largest_of((of_speed * of_b + (of_v + rate * of_x)) / size) <= enough:
            break
    # To the release.
    w, weight = nodes.w, nodes.at + WEIGHT * nodes.m
    slopes_by_push(ps, nodes, late)
    slopes_by_speed(ps, nodes, late)
    b, t = b0, four(0.0)
    for i in range(nodes.n):
        k, q = NODE + EACH * i, w[weight + i]
        b = b + q * four_at(w, k + 16)
        t = t + q * four_at(w, k + 20)
        x = x + q * four_at(w, k + 24)
        v = v + q * four_at(w, k + 28)
    ratio, longer, so_late = missed_varied(nodes, approach, numbers, faster)
    b = b + approach.b * ratio
    longer, so_late = approach.tick * longer, approach.tick * so_late
    x = x + (approach.v * longer + so_late * v)
    v = v + (approach.acceleration * longer + ((1.0 - damper.share) * so_late) * forces[0])
    # The differences at one time.
    s, x1, v1, took = after
    c, d = rotated(c, d, ps.omega * took)
    dv, ds = accelerations(ps, damper, x1, v1, wall.gap, s, c, 0.0)
    late = late + (t + longer)
    root = fifth_root(-s / wall.speed)
    speed = (5.0 * s / root) * b
    v = v + damper.share * speed - dv * late
    x = x - v1 * late
    r = (-s) * late
    speed = speed - ds * late
    put_four(w, NODE, x)
    put_four(w, NODE + 4, v)
    put_four(w, NODE + 8, r)
    put_four(w, NODE + 12, speed)
    for i in range(4):
        for j in range(4):
            tangent[4 * i + j] = w[NODE + 4 * j + i]
