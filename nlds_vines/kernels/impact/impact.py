"""The short impact: a nearly free Hertz impact, solved as a small correction to its exact arc.

Without external forces a contact that begins with speed v is the arc z = z_m u(phi)^2,
s = v S(phi), where u' = S, S' = -(5/2) u^4, u(0) = 0, S(0) = 1: one function for all impacts, with
z_m = b^4 and v = sqrt(4 kappa / 5) b^5. The springs, dashpots and the forcing change it by a
relative amount a / (kappa z_m^(3/2)), about one per cent here. Variation of constants writes that
down exactly, with the arc's own phase phi as the independent variable:

    db/dphi = S a b u / (2 den)      dt/dphi = (5/2) c b^5 u / den      den = kappa b^6 - a u^2

and two slow unknowns for the motion common to both masses, on which the contact does not act. The
right-hand sides are small and smooth, the touch is phi = 0, the deepest point S = 0 and the release
u = 0 again: nothing has to be searched for. Collocation at Gauss points turns the equations into a
fixed point that contracts by that one per cent a sweep.

a is five small numbers, all but exactly: a force, a drag, a drift, a spring and a curvature
(`Approach`). Power series in them, prepared once (`impact_series`), are the guess from which
the sweeps start, and the error of the collocation, which is subtracted. What remains is at most
C_n e^(3/2), e the sum of their sizes: so many nodes are taken as the tolerance asks for. Afterwards
energy and virial must add up, with all forces taken from eq. (5) anew: the integral of their work
and the speed of release must agree to the tolerance (`at_end`); otherwise the impact is solved with
more nodes, and in the end it is stepped.

At the end of the interval such an integral is far better than at any place within it. So the depth,
where it is wanted, is solved as an end: once more, on nodes between touch and deepest point alone.

The complex singularities of the arc lie beside its middle; the nodes follow a map x = d sinh(a xi)
that moves them away, and 12 nodes do the work of 25. What is not a short impact (slow or pressed
touches, soft contacts) is left to `contact`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import fifth_root
from ..numerics.fours import four, four_at, four_of, larger_of, largest_of, put_four, sum_of
from ..scene.drive import (
    Moment,
    bending,
    drive_later,
    drive_now,
    falling,
    twisting,
)
from ..scene.scene import accelerations, shared, under
from .arc import (
    AMPLITUDES,
    ARC_WEIGHT,
    AT_CURVATURE,
    AT_DRAG,
    AT_DRIFT,
    AT_FORCE,
    AT_SPRING,
    COMMON_V,
    COMMON_X,
    CUBE,
    DOUBLE,
    ERROR,
    FACTORS,
    FB,
    FG,
    FH,
    FT,
    GB,
    GT,
    GUESSED,
    HALF,
    HALF_ERROR,
    LEVEL,
    LEVELS,
    MATRIX,
    MISSED,
    NODES,
    PRODUCTS,
    TIMES,
    USED,
    WHOLE,
)

# --------------------------------------------------------------------------------------------------
# An impact at touch: its free arc, the motion common to both masses, and five small numbers.
#
# What is common is a Taylor polynomial of the time, as the contact does not act on it. With the
# free arc of the approach speed it tells what springs, dashpots and the forcing change of the
# impact (a in `impact`): all but exactly a force, a drag, a drift, a spring and a curvature.
# Products of these numbers are the terms of its series.


class Nodes(NamedTuple):
    """The nodes of one choice, on the whole arc or its half."""

    n: int
    m: int  # n in whole fours
    at: int  # place of the constants
    w: Any  # the table


@jit
def nodes_of(arc, level, part):
    row = LEVELS + LEVEL * level
    n = int(arc.table[row + NODES])
    return Nodes(n, (n + 3) // 4 * 4, int(arc.table[row + part]), arc.table)


@jit
def level_for(arc, error, size):
    """Return the first level with C_n e^(3/2) within the tolerance, or the finest.

    error: ERROR or HALF_ERROR, the column of C_n; size: e of the impact.
    """
    scale = size * math.sqrt(size)
    for level in range(arc.levels - 1):
        if arc.table[LEVELS + LEVEL * level + error] * scale <= arc.tolerance:
            return level
    return arc.levels - 1


class Approach(NamedTuple):
    """An impact at touch: its free arc, the common motion, and its five small numbers."""

    b: float  # amplitude of the free arc [m^(1/4)]
    s: float  # approach speed [m/s]
    tick: float  # unit of time: dt = tick u dphi in the free arc [s]
    phase: Any  # the instant (`drive`)
    x: float  # x1 [m], and its derivatives by time without the share of s and of z's
    v: float
    acceleration: float
    jerk: float
    snap: float
    force: float  # A: a at touch, without what goes with s, in units of kappa b^6
    drag: float  # D: what goes with -s
    drift: float  # R: what goes with the time
    spring: float  # Z: what goes with z
    curvature: float  # Q: what goes with the square of the time
    size: float  # e: at least the size of all of a during the impact, more where a load twists


@jit
def approach_of(ps, damper, wall, phase, touch):
    """Return the `Approach` of a touch with (s > 0, x1, v1) at an instant (`drive`)."""
    s, x1, v1 = touch
    # The free arc.
    b = fifth_root(s / wall.speed)
    b4 = (b * b) * (b * b)
    peak = wall.kappa * b4 * (b * b)
    tick = 2.5 * s / peak
    # The common motion x'' = (1 - share) (f/m1 - k1/m1 x - c1/m1 x' + load), by Taylor; of what
    # shakes both bodies it has all.
    other, drive = 1.0 - damper.share, drive_now(phase)
    falls, bends = falling(ps, phase), bending(ps, phase)
    v = v1 - damper.share * s
    push = under(ps.load, ps.force * drive - ps.stiffness * x1 - ps.damping * v)
    push = push - shared(ps, ps.force * drive)
    acceleration = other * push + shared(ps, ps.force * drive)
    slope = (falls - shared(ps, falls)) + ps.stiffness * v
    jerk = -other * (slope + ps.damping * acceleration) - shared(ps, falls)
    bend = (bends - shared(ps, bends)) + ps.stiffness * acceleration
    snap = -other * (bend + ps.damping * jerk) - shared(ps, bends)
    # The small numbers.
    pull = damper.share * ps.damping * other * ps.damping  # what z does by the common dashpot
    stiffness = damper.k2 * damper.inv_mu + damper.share * ps.stiffness - pull
    per = 1.0 / peak
    force = (push - damper.k2 * wall.gap * damper.inv_mu) * per
    drag = (damper.c2 * damper.inv_mu + ps.damping * damper.share) * s * per
    drift = -(slope + ps.damping * acceleration) * tick * per
    spring = -stiffness * b4 * per
    curvature = -0.5 * (bend + ps.damping * jerk) * tick * tick * per
    size = abs(force) + abs(drag) + 2.0 * abs(drift) + abs(spring) + 4.0 * abs(curvature)
    # What the series leave out of a load is C_n 4 x at most (`CHOICES`): with 2 sqrt(x) more of e
    # C_n e^(3/2) covers that, too, as (e + 2 sqrt(x))^(3/2) is more than e^(3/2) + 4 x for x < 1/4.
    size += 2.0 * math.sqrt((8.0 / 6.0) * twisting(ps, phase) * tick * tick * tick * per)
    return Approach(
        b, s, tick, phase, x1, v, acceleration, jerk, snap, force, drag, drift, spring, curvature,
        size,
    )  # fmt: skip


@jit(inlined=True)
def gathered(w, k):
    """Return the four terms of the series that are FACTORS number k to k + 3."""
    i, j, m, n = FACTORS[k], FACTORS[k + 1], FACTORS[k + 2], FACTORS[k + 3]
    return four_of(w[PRODUCTS + i], w[PRODUCTS + j], w[PRODUCTS + m], w[PRODUCTS + n])


# ---- what four variations change of it -----------------------------------------------------------


@jit
def pushes_varied(ps, damper, approach, late, x, v):
    """Return e of `inside` at touch and four derivatives by time, apart from b and t.

    late: t0 [s]; x, v: of the common motion at the touch.
    """
    other, omega = 1.0 - damper.share, ps.omega
    drag, pull = ps.damping * other, ps.stiffness * other
    c, d = approach.phase
    sine, cosine = (ps.force * omega * d) * late, (ps.force * omega * c) * late
    push = 0.0 - sine - (ps.stiffness * x + ps.damping * v)
    first = (0.0 - omega) * cosine - (ps.stiffness * v + drag * push)
    second = (omega * omega) * sine - (pull * push + drag * first)
    third = (omega * omega * omega) * cosine - (pull * first + drag * second)
    fourth = 0.0 - (omega * omega * omega * omega) * sine - (pull * second + drag * third)
    return push, first, second, third, fourth


@jit
def numbers_varied(approach, pushes, faster):
    """Return the changes of (A, D, R, Z, Q) by four variations, a four of each.

    pushes: by `pushes_varied`; faster: of the approach speed, relative. (As b^5 is s, the tick goes
    with s^(-1/5), the contact's own acceleration with s^(6/5).)
    """
    push, first, second, _, _ = pushes
    tick = approach.tick
    per = 0.4 * tick / approach.s
    force = per * push - (1.2 * approach.force) * faster
    drag = (-0.2 * approach.drag) * faster
    drift = (tick * per) * first - (1.4 * approach.drift) * faster
    spring = (-0.4 * approach.spring) * faster
    curvature = (0.5 * tick * tick * per) * second - (1.6 * approach.curvature) * faster
    return force, drag, drift, spring, curvature


# ---- the impact itself ---------------------------------------------------------------------------


LENGTH = 1.4716375921623523  # integral of u from touch to release: B(2/5, 1/2) 2/5
LASTING = 2.943  # time from touch to release of a free impact, times speed / depth
LARGEST = 0.15  # of e, the external acceleration in units of the contact's own: above it, stepped
LONGEST = 0.25  # duration of a short impact in units of 1/rate: a longer one is stepped
MOST_SWEEPS = 12  # a sweep gains one digit or two; from the guess, some two are needed
# error of the speed for a difference of the two energies, relative: five times its half
DOUBTED = 5.0
NODE_ERROR = 2.0e-15  # relative, of a velocity at the nodes
BY_TIME = 0.2  # least share of a change that integrals over the whole interval are said to keep


@jit
def first_guess(ps, damper, nodes, approach):
    """Fill the unknowns at the nodes by the series, good to third order in the small numbers."""
    w, m, at = nodes.w, nodes.m, nodes.at
    b, tick = approach.b, approach.tick
    # The terms of the series: each is a former one times a small number.
    w[PRODUCTS] = 1.0
    w[PRODUCTS + AT_FORCE], w[PRODUCTS + AT_DRAG] = approach.force, approach.drag
    w[PRODUCTS + AT_DRIFT], w[PRODUCTS + AT_SPRING] = approach.drift, approach.spring
    w[PRODUCTS + AT_CURVATURE] = approach.curvature
    for k in range(4, MISSED, 4):  # four at once: their factors stand before them
        put_four(w, PRODUCTS + k, gathered(w, k) * gathered(w, MISSED + k))
    # what the shares of s and z in x1' and x1 do to the common motion
    other = 1.0 - damper.share
    z0 = (b * b) * (b * b)
    on_v = ps.damping * other * damper.share
    once = (ps.stiffness * damper.share - ps.damping * on_v) * other * z0 * tick
    back = ps.damping * once + ps.stiffness * on_v * z0 * tick
    twice = other * tick * back
    on_x, on_x_twice = on_v * z0 * tick, once * tick
    half, sixth, last = 0.5 * approach.acceleration, approach.jerk / 6.0, approach.snap / 24.0
    for i in range(0, m, 4):
        # of odd and even terms apart: no sum waits for the other; that of 1 is 0 for b
        row = at + GB * m + i
        beta, t, more, later = four(0.0), four_at(w, row + (GT - GB) * m), four(0.0), four(0.0)
        for k in range(1, GUESSED, 2):
            row += m
            beta = beta + four_at(w, row) * w[PRODUCTS + k]
            t = t + four_at(w, row + (GT - GB) * m) * w[PRODUCTS + k]
            row += m
            more = more + four_at(w, row) * w[PRODUCTS + k + 1]
            later = later + four_at(w, row + (GT - GB) * m) * w[PRODUCTS + k + 1]
        now, t = b + b * (beta + more), tick * (t + later)
        u, cube = four_at(w, at + i), four_at(w, at + CUBE * m + i)
        double = four_at(w, at + DOUBLE * m + i)
        now2 = now * now
        change = t * (approach.acceleration + t * (3.0 * sixth + t * (4.0 * last)))
        way = t * (approach.v + t * (half + t * (sixth + t * last)))
        put_four(w, AMPLITUDES + i, now)
        put_four(w, TIMES + i, t)
        dip = on_v * (now2 * now2 * (u * u)) + (once * cube - twice * double)
        put_four(w, COMMON_V + i, (approach.v + change) - dip)
        put_four(w, COMMON_X + i, (approach.x + way) - (on_x * cube + on_x_twice * double))


@jit(inlined=True)
def slopes_at(ps, damper, wall, nodes, approach, i):
    """Return (a, FB, FT, FG, FH) at the four nodes from i on, a as in the text above."""
    w, at = nodes.w, nodes.at
    b, u, S_u = four_at(w, AMPLITUDES + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
    v = four_at(w, COMMON_V + i)
    b2 = b * b
    b4 = b2 * b2
    u2 = u * u
    z = b4 * u2
    s = (wall.speed * (b4 * b)) * S_u
    # accelerations of x1 and r without damper and wall, and without the wall
    drive = drive_later(ps, approach.phase, four_at(w, TIMES + i))
    x1 = four_at(w, COMMON_X + i) + damper.share * z
    push = ps.force * drive
    push = under(ps.load, push - (ps.stiffness * x1 + ps.damping * (v + damper.share * s)))
    push = push - shared(ps, ps.force * drive)
    a = push - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
    per = u / (wall.kappa * (b4 * b2) - a * u2)
    dt = (2.5 * wall.speed) * (b4 * b) * per
    common = (1.0 - damper.share) * push + shared(ps, ps.force * drive)
    return a, 0.5 * S_u * a * b * per, dt, v * dt, common * dt


@jit
def all_slopes(ps, damper, wall, nodes, approach):
    """Fill the rows FB, FT, FG, FH with the derivatives of the unknowns by phi."""
    for i in range(0, nodes.m, 4):
        _, fb, ft, fg, fh = slopes_at(ps, damper, wall, nodes, approach, i)
        put_four(nodes.w, FB + i, fb)
        put_four(nodes.w, FT + i, ft)
        put_four(nodes.w, FG + i, fg)
        put_four(nodes.w, FH + i, fh)


@jit
def integrate(nodes, approach):
    """Integrate the slopes from touch to every node; return the largest relative change.

    Of the speed of r and of the common velocity, both relative to the approach speed; what rounding
    does to a common velocity that is far larger is no change.
    """
    w, n, m, matrix = nodes.w, nodes.n, nodes.m, nodes.at + MATRIX * nodes.m
    of_b, of_h = four(0.0), four(0.0)
    for i in range(0, m, 4):
        b, t = four(approach.b), four(0.0)
        g, h = four(approach.x), four(approach.v)
        for j in range(n):
            q = four_at(w, matrix + j * m + i)
            b = b + q * w[FB + j]
            t = t + q * w[FT + j]
            g = g + q * w[FG + j]
            h = h + q * w[FH + j]
        of_b = larger_of(of_b, b - four_at(w, AMPLITUDES + i))
        of_h = larger_of(of_h, h - four_at(w, COMMON_V + i))
        put_four(w, AMPLITUDES + i, b)
        put_four(w, TIMES + i, t)
        put_four(w, COMMON_X + i, g)
        put_four(w, COMMON_V + i, h)
    slow = max(largest_of(of_h) - NODE_ERROR * abs(approach.v), 0.0)
    return 5.0 * largest_of(of_b) / approach.b + slow / approach.s


@jit
def settle(ps, damper, wall, nodes, approach, tolerance):
    """Sweep until the unknowns at the nodes settle to a tolerance; tell whether they do.

    The next sweep changes the unknowns by at most `shrinks` times the last change, b by its small
    numbers and the common motion by its own rates times the duration; and integrals over the whole
    interval by that times `shrinks` again, but for time and place, of which it is a part.
    """
    took = approach.tick * LENGTH
    slow = took * (ps.damping + 0.5 * ps.stiffness * took)
    shrinks = approach.size + (1.0 - damper.share) * abs(slow)
    first_guess(ps, damper, nodes, approach)
    for _ in range(MOST_SWEEPS):
        all_slopes(ps, damper, wall, nodes, approach)
        if integrate(nodes, approach) * shrinks * max(shrinks, BY_TIME) <= tolerance:
            return True
    return False


@jit
def missed(nodes):
    """Return the nodes' errors in b / b0, t / tick and (b / b0)^10 at the end of the interval.

    To fourth order in the small numbers: the series' terms with true integrals less those with the
    nodes' own.
    """
    w, at = nodes.w, nodes.at + (MATRIX + nodes.n) * nodes.m
    b, t, energy = four(0.0), four(0.0), four(0.0)
    for k in range(0, MISSED, 4):
        term = four_at(w, PRODUCTS + k)
        b = b + term * four_at(w, at + k)
        t = t + term * four_at(w, at + MISSED + k)
        energy = energy + term * four_at(w, at + 2 * MISSED + k)
    return sum_of(b), sum_of(t), sum_of(energy)


@jit(inlined=True)
def balances_at(ps, damper, wall, nodes, approach, i, a, dt):
    """Return the integrands of the balances of energy and virial at the four nodes from i on.

    s ds/dt and z (ds/dt - a), ds/dt being the acceleration of r by all forces but the wall's: that
    of eq. (5) itself, by none of the formulas for the `a` that solves the impact. dt: dt/dphi.
    """
    w, at = nodes.w, nodes.at
    b, u, S_u = four_at(w, AMPLITUDES + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
    b2 = b * b
    b4 = b2 * b2
    z, s = b4 * (u * u), (wall.speed * (b4 * b)) * S_u
    drive = drive_later(ps, approach.phase, four_at(w, TIMES + i))
    x1, v1 = (
        four_at(w, COMMON_X + i) + damper.share * z,
        four_at(w, COMMON_V + i) + damper.share * s,
    )
    _, ds = accelerations(ps, damper, x1, v1, wall.gap + z, s, drive, 0.0)
    return s * ds * dt, z * (ds - a) * dt


@jit
def at_end(ps, damper, wall, nodes, approach):
    """Return (b / b0, time, x, v, doubt) at the end of the interval, settled unknowns at its nodes.

    x, v: of the common motion. doubt: how far the energy of the motion in r, by the work of all
    forces but the wall's, is from that of b, which goes with b^10: it has a collocation error of
    its own, about as large. And how far the virial z s is from 0, where it begins and ends: a force
    that is conservative does no work from touch to release, but changes the time.
    """
    w, m, weight = nodes.w, nodes.m, nodes.at + ARC_WEIGHT * nodes.m
    sb, st, sg, sh = four(0.0), four(0.0), four(0.0), four(0.0)
    energy, virial = four(0.0), four(0.0)
    per = 1.0 / approach.b
    for i in range(0, m, 4):
        a, fb, ft, fg, fh = slopes_at(ps, damper, wall, nodes, approach, i)
        work, more = balances_at(ps, damper, wall, nodes, approach, i, a, ft)
        q = four_at(w, weight + i)
        sb = sb + q * (fb * per)
        st = st + q * ft
        sg = sg + q * fg
        sh = sh + q * fh
        energy = energy + q * work
        virial = virial + q * more
    of_b, of_t, of_energy = missed(nodes)
    late = approach.tick * of_t
    ratio, time = 1.0 + (sum_of(sb) + of_b), sum_of(st) + late
    ratio2 = ratio * ratio
    ratio4 = ratio2 * ratio2
    s, deep = approach.s, (approach.b * approach.b) * (approach.b * approach.b)
    gained = 2.0 * sum_of(energy) / (s * s) + of_energy
    doubt = DOUBTED * abs(ratio4 * ratio4 * ratio2 - (1.0 + gained))
    doubt += abs(sum_of(virial)) / (LASTING * deep * s)
    x = approach.x + (sum_of(sg) + approach.v * late)
    v = approach.v + (sum_of(sh) + approach.acceleration * late)
    return ratio, time, x, v, doubt


@jit
def solve_arc(side, part, error, approach):
    """Solve an impact to its release (WHOLE, ERROR) or its deepest point (HALF, HALF_ERROR).

    With the nodes that the tolerance asks for; with more, as long as the doubt exceeds it. Returns
    (solved, b / b0, time [s], x, v) at the end; where it is not solved, as near as the most nodes
    come.
    """
    ps, damper, wall, arc = side.ps, side.damper, side.wall, side.arc
    found = 1.0, 0.0, approach.x, approach.v, 0.0
    for level in range(level_for(arc, error, approach.size), arc.levels):
        nodes = nodes_of(arc, level, part)
        arc.table[USED] = level
        settled = settle(ps, damper, wall, nodes, approach, arc.settled)
        found = at_end(ps, damper, wall, nodes, approach)
        if settled and found[4] <= arc.tolerance:
            return True, found[0], found[1], found[2], found[3]
    return False, found[0], found[1], found[2], found[3]


@jit
def greatest_depth(side, approach):
    """Return the greatest depth [m] of a short impact, which is b^4 at the end of the half arc."""
    _, ratio, _, _, _ = solve_arc(side, int(HALF), int(HALF_ERROR), approach)
    deep = approach.b * ratio
    return (deep * deep) * (deep * deep)


@jit
def short_impact(side, impacts, phase, now):
    """Solve one impact from touch, `now` = (q = 0, approach speed s > 0, x1, v1), to release.

    phase: the instant of the touch (`drive`). Returns (solved, s, x1, v1, duration [s], depth [m])
    at release; solved is False where the impact is not short, has begun already or lasts longer
    than a load is known for, and nothing else may be used then. The depth is 0 where `impacts` is
    None. The unknowns at the nodes of the whole arc are left in the table.
    """
    q, s, x1, v1 = now
    if not (q == 0.0 and s > 0.0):
        return False, s, x1, v1, 0.0, 0.0
    approach = approach_of(side.ps, side.damper, side.wall, phase, (s, x1, v1))
    lasting, known = (
        approach.tick * LENGTH,
        ((1.0 - phase.x) * phase.length if is_a(phase, Moment) else math.inf),
    )
    if not (approach.size < LARGEST and side.rate * lasting < LONGEST and lasting < known):
        return False, s, x1, v1, 0.0, 0.0
    depth = 0.0
    if impacts is not None:
        depth = greatest_depth(side, approach)
    solved, ratio, took, x, v = solve_arc(side, int(WHOLE), int(ERROR), approach)
    if not (solved and took < known):
        return False, s, x1, v1, 0.0, 0.0
    ratio2 = ratio * ratio
    speed = s * (ratio2 * ratio2 * ratio)
    return True, -speed, x, v - side.damper.share * speed, took, depth
