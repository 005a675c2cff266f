"""The short impact: a nearly free Hertz impact, solved as a small correction to its exact arc.

Without external forces a contact that begins with speed v is the arc z = z_m u(phi)^2,
s = v S(phi), where u' = S, S' = -(5/2) u^4, u(0) = 0, S(0) = 1: one function for all impacts, with
z_m = b^4 and v = sqrt(4 kappa / 5) b^5. Springs, dashpots and forcing change it by a relative
amount a / (kappa z_m^(3/2)), about one per cent, a being the acceleration of r by all forces but
the contact's. Variation of constants, with the arc's phase phi as the independent variable, gives
without approximation

    db/dphi = S a b u / (2 den)      dt/dphi = (5/2) c b^5 u / den      den = kappa b^6 - a u^2

with c = sqrt(4 kappa / 5), and two slow unknowns for the motion common to both masses, on which the
contact does not act. The right-hand sides are small and smooth, the touch is phi = 0, the deepest
point S = 0 and the release u = 0 again, so that no root has to be found. Collocation at Gauss
points turns the equations into a fixed-point iteration that contracts by about one per cent a
sweep.

To high accuracy a consists of five small numbers: a force, a drag, a drift, a spring and a
curvature (`Approach`). Power series in them, prepared once (`impact_series`), give the initial
guess of the sweeps and the error of the collocation, which is subtracted. The remaining error is at
most C_n e^(3/2), e being the sum of their sizes with the weights of `approach_of`; the number n of
nodes follows from the tolerance. Then the balances of energy and virial, with all forces taken anew
from eq. (5), must hold to the tolerance (`at_end`). If they do not, the impact is solved with more
nodes, and finally stepped.

At the end of the interval the integrals converge far faster than inside it. So the depth, if it is
recorded, is computed as the end of a second solution, on nodes between touch and deepest point.

The complex singularities of the arc lie beside its middle. The nodes follow a map x = d sinh(a xi)
that moves them away, so that 12 nodes are as accurate as 25. Other contacts (slow or pressed
touches, soft contacts) are left to `contact`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import fifth_root
from ..numerics.fours import four, four_at, four_of, larger_of, largest_of, put_four, sum_of
from ..scene.by_law import by_flow
from ..scene.drive import Moment, bending, drive_later, drive_now, falling, twisting
from ..scene.scene import accelerations_at, shared, under
from .arc import ARC, FACTORS, GUESSED, LEVEL, LEVEL_ROW, MISSED, NODES, TERM

# --------------------------------------------------------------------------------------------------
# An impact at touch: its free arc, the motion common to both masses, and five small numbers.
#
# The common motion is a Taylor polynomial of the time, as the contact does not act on it. Together
# with the free arc of the approach speed it gives the acceleration a of the text above: up to
# higher orders a force, a drag, a drift, a spring and a curvature. Products of these numbers are
# the terms of the series.


class Nodes(NamedTuple):
    """The nodes of one choice, on the whole arc or its half."""

    n: int
    m: int  # n in whole fours
    at: int  # place of their constants (`arc.NodeRows`)
    w: Any  # the table (`arc.ArcTable`)


@jit
def nodes_of(arc, level, part):
    row = ARC.levels + LEVEL_ROW * level
    n = int(arc.table[row + LEVEL.nodes])
    return Nodes(n, (n + 3) // 4 * 4, int(arc.table[row + part]), arc.table)


@jit
def level_for(arc, error, size):
    """Return the first level with C_n e^(3/2) within the tolerance, or the finest.

    error: LEVEL.error or LEVEL.half_error, the place of C_n; size: e of the impact.
    """
    scale = size * math.sqrt(size)
    for level in range(arc.levels - 1):
        if arc.table[ARC.levels + LEVEL_ROW * level + error] * scale <= arc.tolerance:
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
    # towards the wall:
    force: float  # A: a at touch without the part in s, in units of kappa b^6
    drag: float  # D: coefficient of -s
    drift: float  # R: coefficient of the time
    spring: float  # Z: coefficient of z
    curvature: float  # Q: coefficient of the square of the time
    size: float  # e: a bound of |a| during the impact, larger if the load has a third derivative


@jit
def approach_of(side, phase, touch):
    """Return the `Approach` of a touch with (s > 0, x1, v1) at an instant (`drive`)."""
    ps, damper, wall, sign, (s, x1, v1) = side.ps, side.damper, side.wall, side.sign, touch
    # The free arc.
    b = fifth_root(s / wall.speed)
    b4 = (b * b) * (b * b)
    peak = wall.kappa * b4 * (b * b)
    tick = 2.5 * s / peak
    # The Taylor polynomial of the common motion x'' = (1 - share) (f/m1 - k1/m1 x - c1/m1 x' +
    # load); a force that shakes both bodies acts on it in full.
    other, drive = 1.0 - damper.share, drive_now(phase)
    falls, bends = falling(ps, phase), bending(ps, phase)
    v = v1 - sign * damper.share * s
    push = under(ps.load, ps.force * drive - ps.stiffness * x1 - ps.damping * v)
    push = push - shared(ps, ps.force * drive)
    acceleration = other * push + shared(ps, ps.force * drive)
    slope = (falls - shared(ps, falls)) + ps.stiffness * v
    jerk = -other * (slope + ps.damping * acceleration) - shared(ps, falls)
    bend = (bends - shared(ps, bends)) + ps.stiffness * acceleration
    snap = -other * (bend + ps.damping * jerk) - shared(ps, bends)
    # The small numbers.
    pull = damper.share * ps.damping * other * ps.damping  # of z through the common dashpot
    stiffness = damper.k2 * damper.inv_mu + damper.share * ps.stiffness - pull
    per = 1.0 / peak
    force = (sign * push - damper.k2 * wall.gap * damper.inv_mu) * per
    drag = (damper.c2 * damper.inv_mu + ps.damping * damper.share) * s * per
    drift = -sign * (slope + ps.damping * acceleration) * tick * per
    spring = -stiffness * b4 * per
    curvature = -0.5 * sign * (bend + ps.damping * jerk) * tick * tick * per
    size = abs(force) + abs(drag) + 2.0 * abs(drift) + abs(spring) + 4.0 * abs(curvature)
    # The series omits the third derivative of a load, whose error is at most 4 C_n x (`CHOICES`).
    # Adding 2 sqrt(x) to e covers it, since (e + 2 sqrt(x))^(3/2) > e^(3/2) + 4 x for x < 1/4.
    size += 2.0 * math.sqrt((8.0 / 6.0) * twisting(ps, phase) * tick * tick * tick * per)
    return Approach(
        b, s, tick, phase, x1, v, acceleration, jerk, snap, force, drag, drift, spring, curvature,
        size,
    )  # fmt: skip


@jit(inlined=True)
def gathered(w, k):
    """Return the terms of the series at the places FACTORS[k] to FACTORS[k + 3], as a four."""
    i, j, m, n = FACTORS[k], FACTORS[k + 1], FACTORS[k + 2], FACTORS[k + 3]
    return four_of(
        w[ARC.products + i], w[ARC.products + j], w[ARC.products + m], w[ARC.products + n]
    )


# ---- the impact itself ---------------------------------------------------------------------------


LENGTH = 1.4716375921623523  # integral of u from touch to release: B(2/5, 1/2) 2/5
LASTING = 2.943  # time from touch to release of a free impact, times speed / depth
LARGEST = 0.15  # greatest e of a short impact; one with a larger e is stepped
LONGEST = 0.25  # longest short impact, in units of 1/rate; a longer one is stepped
MOST_SWEEPS = 12  # a sweep gains one or two digits; from the guess, about two are needed
DOUBTED = 5.0  # weight of the relative residual of the energy in the doubt
NODE_ERROR = 2.0e-15  # relative rounding error of a velocity at the nodes
BY_TIME = 0.2  # least factor assumed between changes at nodes and of integrals over the interval


@jit
def first_guess(side, nodes, approach):
    """Fill the unknowns at the nodes by the series, to third order in the small numbers."""
    w, m, at, b, tick = nodes.w, nodes.m, nodes.at, approach.b, approach.tick
    # The terms of the series: each is a former one times a small number.
    w[ARC.products] = 1.0
    w[ARC.products + TERM.force], w[ARC.products + TERM.drag] = approach.force, approach.drag
    w[ARC.products + TERM.drift], w[ARC.products + TERM.spring] = approach.drift, approach.spring
    w[ARC.products + TERM.curvature] = approach.curvature
    for k in range(4, MISSED, 4):  # four at once: their factors stand before them
        put_four(w, ARC.products + k, gathered(w, k) * gathered(w, MISSED + k))
    for i in range(0, m, 4):
        # sums of odd and of even terms, which do not wait for each other; b has no term 1
        row = at + NODES.b * m + i
        beta, beta_even, t_even = four(0.0), four(0.0), four(0.0)
        t = four_at(w, row + (NODES.t - NODES.b) * m)
        for k in range(1, GUESSED, 2):
            row += m
            beta = beta + four_at(w, row) * w[ARC.products + k]
            t = t + four_at(w, row + (NODES.t - NODES.b) * m) * w[ARC.products + k]
            row += m
            beta_even = beta_even + four_at(w, row) * w[ARC.products + k + 1]
            t_even = t_even + four_at(w, row + (NODES.t - NODES.b) * m) * w[ARC.products + k + 1]
        put_four(w, ARC.amplitudes + i, b + b * (beta + beta_even))
        put_four(w, ARC.times + i, tick * (t + t_even))
    guess_slow(side, nodes, approach)


@by_flow
def guess_slow(side, nodes, approach):
    """Fill the guess of the common motion, whose b and t at the nodes are there."""
    ps, damper, w, m, at = side.ps, side.damper, nodes.w, nodes.m, nodes.at
    b, tick = approach.b, approach.tick
    # the effect on the common motion of the shares of s and z in x1' and x1
    other, share = 1.0 - damper.share, side.sign * damper.share
    z0 = (b * b) * (b * b)
    on_v = ps.damping * other * share
    first = (ps.stiffness * share - ps.damping * on_v) * other * z0 * tick
    second = ps.damping * first + ps.stiffness * on_v * z0 * tick
    twice = other * tick * second
    on_x, on_x_twice = on_v * z0 * tick, first * tick
    half, sixth, last = 0.5 * approach.acceleration, approach.jerk / 6.0, approach.snap / 24.0
    for i in range(0, m, 4):
        now, t = four_at(w, ARC.amplitudes + i), four_at(w, ARC.times + i)
        u, cube = four_at(w, at + i), four_at(w, at + NODES.cube * m + i)
        double = four_at(w, at + NODES.double * m + i)
        now2 = now * now
        change = t * (approach.acceleration + t * (3.0 * sixth + t * (4.0 * last)))
        distance = t * (approach.v + t * (half + t * (sixth + t * last)))
        dip = on_v * (now2 * now2 * (u * u)) + (first * cube - twice * double)
        put_four(w, ARC.common_v + i, (approach.v + change) - dip)
        put_four(w, ARC.common_x + i, (approach.x + distance) - (on_x * cube + on_x_twice * double))


@jit(inlined=True)
def slopes_at(side, nodes, approach, i):
    """Return a and the derivatives of b, t, x and v by phi at the four nodes from i on."""
    ps, damper, wall, w, at = side.ps, side.damper, side.wall, nodes.w, nodes.at
    b, u, S_u = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + nodes.m + i)
    v = four_at(w, ARC.common_v + i)
    b2 = b * b
    b4 = b2 * b2
    u2 = u * u
    z = b4 * u2
    s = (wall.speed * (b4 * b)) * S_u
    # the accelerations of x1 without damper and wall, and of r without the wall
    drive, share = (
        drive_later(ps, approach.phase, four_at(w, ARC.times + i)),
        side.sign * damper.share,
    )
    x1 = four_at(w, ARC.common_x + i) + share * z
    push = ps.force * drive
    push = under(ps.load, push - (ps.stiffness * x1 + ps.damping * (v + share * s)))
    push = push - shared(ps, ps.force * drive)
    a = side.sign * push - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
    per = u / (wall.kappa * (b4 * b2) - a * u2)
    dt = (2.5 * wall.speed) * (b4 * b) * per
    common = (1.0 - damper.share) * push + shared(ps, ps.force * drive)
    return a, 0.5 * S_u * a * b * per, dt, v * dt, common * dt


@jit
def integrate(nodes, approach):
    """Integrate the slopes from touch to every node; return the largest change of the unknowns.

    It is the sum of the changes of s and of the common velocity, relative to the approach speed,
    less the rounding error of a large common velocity.
    """
    w, n, m, matrix = nodes.w, nodes.n, nodes.m, nodes.at + NODES.matrix * nodes.m
    of_b, of_h = four(0.0), four(0.0)
    for i in range(0, m, 4):
        b, t = four(approach.b), four(0.0)
        g, h = four(approach.x), four(approach.v)
        for j in range(n):
            q = four_at(w, matrix + j * m + i)
            b = b + q * w[ARC.slope_b + j]
            t = t + q * w[ARC.slope_t + j]
            g = g + q * w[ARC.slope_x + j]
            h = h + q * w[ARC.slope_v + j]
        of_b = larger_of(of_b, b - four_at(w, ARC.amplitudes + i))
        of_h = larger_of(of_h, h - four_at(w, ARC.common_v + i))
        put_four(w, ARC.amplitudes + i, b)
        put_four(w, ARC.times + i, t)
        put_four(w, ARC.common_x + i, g)
        put_four(w, ARC.common_v + i, h)
    slow = max(largest_of(of_h) - NODE_ERROR * abs(approach.v), 0.0)
    return 5.0 * largest_of(of_b) / approach.b + slow / approach.s


@jit
def settle(side, nodes, approach, tolerance):
    """Sweep until the unknowns at the nodes settle; return True if MOST_SWEEPS sweeps suffice.

    tolerance: relative error that may remain in the integrals over the whole interval. The next
    sweep would change the nodes by about `shrinks` times this change; `shrinks` is the sum of the
    small numbers' sizes and of the common motion's rates times the duration. A change at the nodes
    changes the integrals of b and v by `shrinks` times it, those of time and place by BY_TIME times
    it. The larger factor counts.
    """
    shrinks = shrinking(side, approach)
    first_guess(side, nodes, approach)
    for _ in range(MOST_SWEEPS):
        if sweep(side, nodes, approach) * shrinks * max(shrinks, BY_TIME) <= tolerance:
            return True
    return False


@by_flow
def shrinking(side, approach):
    """Return `shrinks` of `settle`."""
    ps, took = side.ps, approach.tick * LENGTH
    slow = took * (ps.damping + 0.5 * ps.stiffness * took)
    return approach.size + (1.0 - side.damper.share) * abs(slow)


@by_flow
def sweep(side, nodes, approach):
    """Take the slopes at the nodes and integrate them; return the largest change (`integrate`)."""
    for i in range(0, nodes.m, 4):
        _, of_b, of_t, of_x, of_v = slopes_at(side, nodes, approach, i)
        put_four(nodes.w, ARC.slope_b + i, of_b)
        put_four(nodes.w, ARC.slope_t + i, of_t)
        put_four(nodes.w, ARC.slope_x + i, of_x)
        put_four(nodes.w, ARC.slope_v + i, of_v)
    return integrate(nodes, approach)


@jit
def missed(nodes):
    """Return the collocation errors of b / b0, t / tick and (b / b0)^10 at the end of the interval.

    To fourth order in the small numbers: the series with exact integrals less that with the nodes'.
    """
    w, at = nodes.w, nodes.at + (NODES.matrix + nodes.n) * nodes.m
    b, t, energy = four(0.0), four(0.0), four(0.0)
    for k in range(0, MISSED, 4):
        term = four_at(w, ARC.products + k)
        b = b + term * four_at(w, at + k)
        t = t + term * four_at(w, at + MISSED + k)
        energy = energy + term * four_at(w, at + 2 * MISSED + k)
    return sum_of(b), sum_of(t), sum_of(energy)


@jit
def at_end(side, nodes, approach):
    """Return (b / b0, time, x, v, doubt) at the end of the interval, from settled unknowns.

    x, v: of the common motion. doubt is the sum of two relative residuals. The energy of the motion
    in r, proportional to b^10, must grow by the work of all forces but the wall's. The virial z s,
    which is 0 at touch and release, must have a vanishing change; it detects an error of a
    conservative force, which does no work from touch to release, but changes the time.
    """
    sb, st, sg, sh, energy, virial = sums_of_slopes(side, nodes, approach)
    of_b, of_t, of_energy = missed(nodes)
    late = approach.tick * of_t
    ratio, time = 1.0 + (sb + of_b), st + late
    ratio2 = ratio * ratio
    ratio4 = ratio2 * ratio2
    fast, deep = approach.s, (approach.b * approach.b) * (approach.b * approach.b)
    gained = 2.0 * energy / (fast * fast) + of_energy
    doubt = DOUBTED * abs(ratio4 * ratio4 * ratio2 - (1.0 + gained))
    doubt += abs(virial) / (LASTING * deep * fast)
    x = approach.x + (sg + approach.v * late)
    v = approach.v + (sh + approach.acceleration * late)
    return ratio, time, x, v, doubt


@by_flow
def sums_of_slopes(side, nodes, approach):
    """Return the integrals of the slopes of b / b0, t, x and v, of the work and of the virial.

    The integrands of the last two are s ds/dt and z (ds/dt - a), ds/dt being the acceleration of r
    by all forces but the wall's, taken from eq. (5) and not from the formulas of the `a` of the
    solution.
    """
    ps, wall, share = side.ps, side.wall, side.sign * side.damper.share
    w, m, at, weight = nodes.w, nodes.m, nodes.at, nodes.at + NODES.weight * nodes.m
    sb, st, sg, sh = four(0.0), four(0.0), four(0.0), four(0.0)
    energy, virial = four(0.0), four(0.0)
    per = 1.0 / approach.b
    for i in range(0, m, 4):
        a, fb, ft, fg, fh = slopes_at(side, nodes, approach, i)
        b, u, S_u = four_at(w, ARC.amplitudes + i), four_at(w, at + i), four_at(w, at + m + i)
        b2 = b * b
        b4 = b2 * b2
        z, s = b4 * (u * u), (wall.speed * (b4 * b)) * S_u
        drive = drive_later(ps, approach.phase, four_at(w, ARC.times + i))
        x1 = four_at(w, ARC.common_x + i) + share * z
        v1 = four_at(w, ARC.common_v + i) + share * s
        _, ds = accelerations_at(side, ps, (x1, v1, wall.gap + z, s), drive, 0.0)
        q = four_at(w, weight + i)
        sb = sb + q * (fb * per)
        st = st + q * ft
        sg = sg + q * fg
        sh = sh + q * fh
        energy = energy + q * (s * ds * ft)
        virial = virial + q * (z * (ds - a) * ft)
    return sum_of(sb), sum_of(st), sum_of(sg), sum_of(sh), sum_of(energy), sum_of(virial)


@jit
def solve_arc(side, part, error, approach):
    """Solve an impact to its release or, on the half arc, to its deepest point.

    part, error: LEVEL.whole and LEVEL.error, or those of the half. The number of nodes is that of
    `level_for`, and rises as long as the doubt exceeds the tolerance. Returns (solved, b / b0,
    time [s], x, v) at the end; if it is not solved, by the largest number of nodes.
    """
    arc = side.arc
    at_last = 1.0, 0.0, approach.x, approach.v, 0.0
    for level in range(level_for(arc, error, approach.size), arc.levels):
        nodes = nodes_of(arc, level, part)
        arc.table[ARC.used] = level
        settled = settle(side, nodes, approach, arc.settled)
        at_last = at_end(side, nodes, approach)
        if settled and at_last[4] <= arc.tolerance:
            return True, at_last[0], at_last[1], at_last[2], at_last[3]
    return False, at_last[0], at_last[1], at_last[2], at_last[3]


@jit
def greatest_depth(side, approach):
    """Return the greatest depth [m] of a short impact, b^4 at the end of the half arc."""
    _, ratio, _, _, _ = solve_arc(side, LEVEL.half, LEVEL.half_error, approach)
    deep = approach.b * ratio
    return (deep * deep) * (deep * deep)


@jit
def short_impact(side, impacts, phase, now):
    """Solve one impact from touch, `now` = (q = 0, approach speed s > 0, x1, v1), to release.

    phase: the instant of the touch (`drive`). Returns (solved, s, x1, v1, duration [s], depth [m])
    at release. solved is False, and the rest has no meaning, if the impact is not short, has begun
    before, or ends after the cell of a load. The depth is 0 if `impacts` is None. The unknowns at
    the nodes of the whole arc stay in the table.
    """
    q, s, x1, v1 = now
    if not (q == 0.0 and s > 0.0):
        return False, s, x1, v1, 0.0, 0.0
    approach = approach_of(side, phase, (s, x1, v1))
    lasting, horizon = approach.tick * LENGTH, math.inf
    if is_a(phase, Moment):
        horizon = (1.0 - phase.x) * phase.length
    if not (approach.size < LARGEST and side.rate * lasting < LONGEST and lasting < horizon):
        return False, s, x1, v1, 0.0, 0.0
    depth = 0.0
    if impacts is not None:
        depth = greatest_depth(side, approach)
    solved, ratio, took, x, v = solve_arc(side, LEVEL.whole, LEVEL.error, approach)
    if not (solved and took < horizon):
        return False, s, x1, v1, 0.0, 0.0
    ratio2 = ratio * ratio
    speed = s * (ratio2 * ratio2 * ratio)
    return True, -speed, x, v - side.sign * side.damper.share * speed, took, depth
