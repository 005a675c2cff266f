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

from ..numerics.compiling import jit
from ..numerics.fours import four, four_at, larger_of, largest_of, put_four, sum_of
from ..scene.drive import drive_later, known_for
from ..scene.scene import accelerations_of, under, with_shaking, without_shaking
from .approach import approach_of, fill_products
from .arc_table import (
    AMPLITUDES,
    ARC_WEIGHT,
    COMMON_V,
    COMMON_X,
    CUBE,
    DOUBLE,
    ERROR,
    FB,
    FG,
    FH,
    FT,
    GB,
    GT,
    GUESSED,
    HALF,
    HALF_ERROR,
    MATRIX,
    MISSED,
    PRODUCTS,
    TIMES,
    USED,
    WHOLE,
    level_for,
    nodes_of,
)

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
    fill_products(w, approach)
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
    push = without_shaking(ps, push, drive)
    a = push - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
    per = u / (wall.kappa * (b4 * b2) - a * u2)
    dt = (2.5 * wall.speed) * (b4 * b) * per
    common = with_shaking(ps, (1.0 - damper.share) * push, drive)
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
    """Return what the nodes miss of b / b0, t / tick and (b / b0)^10 at the end of the interval.

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
    """Return what the balances of energy and virial add up at the four nodes from i on, by phi.

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
    _, ds = accelerations_of(ps, damper, x1, v1, wall.gap + z, s, drive, 0.0)
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
    lasting, known = approach.tick * LENGTH, known_for(phase)
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
