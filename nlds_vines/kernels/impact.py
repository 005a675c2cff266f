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

At the end of the interval such an integral is far better than at any place within it. So the depth,
where it is wanted, is solved as an end: once more, on nodes between touch and deepest point alone.

The complex singularities of the arc lie beside its middle; the nodes follow a map x = d sinh(a xi)
that moves them away, and 12 nodes do the work of 25. What is not a short impact (slow or pressed
touches, soft contacts, a section inside) is left to `contact`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiling import jit
from .contact_field import cos_sin
from .elementary import fifth_root
from .scene import accelerations

# The table of an arc: 16 rows of 64 numbers, of which the first n are in use, one for each node.
#
#   unknowns    B          amplitude b, in which z = b^4 u^2 and s = v(b) S
#               T          time since touch [s]
#               G, H       x1 and v1 without the share of r and s: the motion common to both masses
#   slopes      FB FT FG FH, the derivatives of B T G H by phi;  OLD, the row B of the last sweep
#   constants   U          sqrt(z / z_m)
#               S          s / v
#               BY_DRAG    integral of S^2 u / 2, the first effect of damping
#               BY_DRIFT   integral of S u / 2 times that of u, the effect of a force that grows
#               TIME       integral of u
#               WEIGHT     of an integral from touch to release
#
# A name is the place of a row's first number, so that w[B + i] is b at node i. Behind the rows of
# the whole arc follow those of its half, from touch to the deepest point (`half_of`).
ROW = 64
B, T, G, H, FB, FT, FG, FH, OLD = (ROW * i for i in range(9))
U, S, BY_DRAG, BY_DRIFT, TIME, WEIGHT = (ROW * i for i in range(9, 15))
TABLE = ROW * 16

LARGEST_SHARE = 0.1  # of the external acceleration in the contact's own: above it, it is stepped
LONGEST = 0.2  # duration of a short impact in units of 1/rate: a longer one is stepped
MOST_SWEEPS = 12  # a sweep gains two digits; some five are needed


class Arc(NamedTuple):
    """The Hertz arc at the collocation nodes, prepared by `nlds_vines.orbits.hertz_arc`.

    Two arrays hold it all, and the half arc too: each array of a tuple costs every call that hands
    it on.
    """

    n: int  # nodes
    length: float  # integral of u from touch to the arc's end: release, or deepest point
    tolerance: float  # relative change of b that a further sweep may still make
    loss_missed: float  # what the nodes miss of BY_DRAG up to the arc's end
    integration: np.ndarray  # (2 n n,) from touch to each node, one integrand after another
    table: np.ndarray  # (2 TABLE,) see above; unknowns and slopes are scratch


@jit
def accelerations_at(ps, damper, wall, arc, c, d, i):
    """Return (b, alone, a) at node i: accelerations [m/s^2] of x1 and r without damper and wall."""
    w = arc.table
    b = w[B + i]
    b2 = b * b
    b4 = b2 * b2
    z = b4 * w[U + i] * w[U + i]
    s = wall.speed * b4 * b * w[S + i]
    x1 = w[G + i] + damper.share * z
    v1 = w[H + i] + damper.share * s
    cosine, sine = cos_sin(ps.omega * w[T + i])
    alone = ps.force * (c * cosine - d * sine) - ps.stiffness * x1 - ps.damping * v1
    return b, alone, alone - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu


@jit
def common_slopes(ps, damper, wall, arc, c, d):
    """Fill the rows FT, FG, FH with the derivatives of time and of the common motion."""
    w = arc.table
    for i in range(arc.n):
        b, alone, a = accelerations_at(ps, damper, wall, arc, c, d, i)
        b2 = b * b
        b4 = b2 * b2
        dt = 2.5 * wall.speed * b4 * b * w[U + i] / (wall.kappa * b4 * b2 - a * w[U + i] * w[U + i])
        w[FT + i] = dt
        w[FG + i] = w[H + i] * dt
        w[FH + i] = alone * (1.0 - damper.share) * dt


@jit
def amplitude_slope(ps, damper, wall, arc, c, d):
    """Fill the row FB with the derivative of the amplitude b."""
    w = arc.table
    for i in range(arc.n):
        b, _, a = accelerations_at(ps, damper, wall, arc, c, d, i)
        b2 = b * b
        w[FB + i] = (
            0.5
            * w[S + i]
            * a
            * b
            * w[U + i]
            / (wall.kappa * b2 * b2 * b2 - a * w[U + i] * w[U + i])
        )


@jit
def first_guess(ps, damper, wall, arc, b, s, x1, v1, c, d):
    """Fill the unknowns at the nodes, good to first order in the external acceleration.

    That acceleration is taken as a constant, a part that goes with s and one that grows with time;
    their effects on the free arc are integrals known beforehand.
    """
    # hot: once per impact
    w = arc.table
    peak = wall.kappa * b * b * b * b * b * b
    _, outside = accelerations(ps, damper, x1, v1, wall.gap, s, c, 0.0)
    rest = v1 - damper.share * s
    drag = (damper.c2 * damper.inv_mu + ps.damping * damper.share) * s
    tick = 2.5 * s / peak
    drift = -(ps.stiffness * rest + ps.force * ps.omega * d) * tick
    common = ps.force * c - ps.stiffness * x1 - ps.damping * rest
    for i in range(arc.n):
        t = tick * w[TIME + i]
        steady = 0.25 * (outside + drag) * w[U + i] * w[U + i]
        w[B + i] = b * (1.0 + (steady - drag * w[BY_DRAG + i] + drift * w[BY_DRIFT + i]) / peak)
        w[T + i] = t
        w[H + i] = rest + common * (1.0 - damper.share) * t
        w[G + i] = x1 + 0.5 * (rest + w[H + i]) * t


@jit
def integrate_common(arc, x, v):
    """Integrate the rows FT, FG, FH from touch to every node."""
    w, n = arc.table, arc.n
    for i in range(n):
        w[T + i], w[G + i], w[H + i] = 0.0, x, v
    for j in range(n):
        ft, fg, fh = w[FT + j], w[FG + j], w[FH + j]
        row = j * n
        for i in range(n):
            q = arc.integration[row + i]
            w[T + i] += q * ft
            w[G + i] += q * fg
            w[H + i] += q * fh


@jit
def integrate_amplitude(arc, b):
    """Integrate the row FB from touch to every node; return the largest change of b."""
    w, n = arc.table, arc.n
    for i in range(n):
        w[OLD + i] = w[B + i]
        w[B + i] = b
    for j in range(n):
        fb = w[FB + j]
        row = j * n
        for i in range(n):
            w[B + i] += arc.integration[row + i] * fb
    change = 0.0
    for i in range(n):
        change = max(change, abs(w[B + i] - w[OLD + i]))
    return change


@jit
def integral(arc, weight, row):
    """Return the integral of a row of slopes with the weights of another row."""
    total = 0.0
    for i in range(arc.n):
        total += arc.table[weight + i] * arc.table[row + i]
    return total


@jit
def settle(ps, damper, wall, arc, b, s, x1, v1, c, d):
    """Sweep until the unknowns at the nodes settle; tell whether they do.

    The slopes in the rows FB, FT, FG, FH are then those of the settled unknowns.
    """
    # hot: once per impact
    rest = v1 - damper.share * s
    first_guess(ps, damper, wall, arc, b, s, x1, v1, c, d)
    before = 0.0
    for _ in range(MOST_SWEEPS):
        common_slopes(ps, damper, wall, arc, c, d)
        integrate_common(arc, x1, rest)
        amplitude_slope(ps, damper, wall, arc, c, d)
        change = integrate_amplitude(arc, b)
        if before == 0.0:  # what the guess missed is of second order, and a sweep gains one
            before = math.sqrt(change * b)
        if change * change <= arc.tolerance * b * before:  # each gains as much as the one before
            common_slopes(ps, damper, wall, arc, c, d)
            amplitude_slope(ps, damper, wall, arc, c, d)
            return True
        before = change
    return False


@jit
def amplitude_at_end(ps, damper, wall, arc, b, s):
    """Return the amplitude b at the end of an arc that has settled.

    What the dashpots take is nearly what they take of the free arc, which is known exactly.
    """
    drag = (damper.c2 * damper.inv_mu + ps.damping * damper.share) * s
    missed = drag * arc.loss_missed / (wall.kappa * b * b * b * b * b * b)
    return b * (1.0 - missed) + integral(arc, int(WEIGHT), int(FB))


@jit
def half_of(arc):
    """Return the arc from touch to the deepest point, whose end is S = 0, u = 1."""
    n = arc.n
    integration, table = arc.integration[n * n :], arc.table[TABLE:]
    return Arc(n, 0.5 * arc.length, arc.tolerance, 0.0, integration, table)


@jit
def depth_of(ps, damper, wall, arc, b, s, x1, v1, c, d):
    """Return the greatest depth [m] of a short impact, which is b^4 at the end of the half arc."""
    # hot: once per impact that is recorded
    half = half_of(arc)
    settle(ps, damper, wall, half, b, s, x1, v1, c, d)
    deep = amplitude_at_end(ps, damper, wall, half, b, s)
    return deep * deep * deep * deep


@jit
def short_impact(ps, damper, wall, arc, impacts, rate, c, d, q, s, x1, v1):
    """Solve one impact from touch (q = 0, r = gap, approach speed s > 0) to release.

    c, d are cos and sin of the forcing's phase at touch, `rate` the bound of `flight.rate_of`.
    Returns (solved, s, x1, v1, duration [s], depth [m]) at release; solved is False where the
    impact is not short or has begun already, and nothing else may be used then. The depth is 0
    where `impacts` is None.
    """
    # hot: once per impact
    if not (q == 0.0 and s > 0.0):
        return False, s, x1, v1, 0.0, 0.0
    b = fifth_root(s / wall.speed)
    peak = wall.kappa * b * b * b * b * b * b
    duration = 2.5 * s / peak * arc.length
    _, outside = accelerations(ps, damper, x1, v1, wall.gap, s, c, 0.0)
    if not (abs(outside) < LARGEST_SHARE * peak and rate * duration < LONGEST):
        return False, s, x1, v1, 0.0, 0.0
    if not settle(ps, damper, wall, arc, b, s, x1, v1, c, d):
        return False, s, x1, v1, 0.0, 0.0
    out = amplitude_at_end(ps, damper, wall, arc, b, s)
    speed = wall.speed * out * out * out * out * out
    took = integral(arc, int(WEIGHT), int(FT))
    a1 = x1 + integral(arc, int(WEIGHT), int(FG))
    b1 = v1 - damper.share * s + integral(arc, int(WEIGHT), int(FH)) - damper.share * speed
    depth = 0.0
    if impacts is not None:
        depth = depth_of(ps, damper, wall, arc, b, s, x1, v1, c, d)
    return True, -speed, a1, b1, took, depth
