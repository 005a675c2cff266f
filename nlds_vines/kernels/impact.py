"""The short impact: a nearly free Hertz bump, solved as a small correction to its exact arc.

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

The complex singularities of the arc lie beside its middle; the nodes follow the map x = d sinh(a xi)
that moves them away, and 12 nodes do the work of 25. Whatever is not a short bump (slow or pressed
touches, soft contacts, a section inside) is left to `contact`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import jit
from .contact_field import turn
from .parts import accelerations

ROW = 64  # distance of the rows of the scratch array; bounds the number of nodes
B, T, G, H, FB, FT, FG, FH, OLD = (ROW * i for i in range(9))
SCRATCH = ROW * 9
LARGEST_SHARE = 0.1  # of the external acceleration in the contact's own: beyond it, step
LONGEST = 0.2  # duration in units of 1/rate
MOST_SWEEPS = 12
SETTLED = 1.0e-9  # relative change of b in the last sweep but one; the next is a hundred times less


class Arc(NamedTuple):
    """The Hertz arc at the collocation nodes, prepared once (`nlds_vines.arc`)."""

    n: int
    u: np.ndarray  # (n,) sqrt(z / z_m)
    S: np.ndarray  # (n,) s / v
    loss: np.ndarray  # (n,) integral of S^2 u / 2: the first effect of damping
    cover: np.ndarray  # (n n,) integration from touch to each node, one integrand after another
    weight: np.ndarray  # (n,) integration from touch to release
    middle: np.ndarray  # (n,) integration from touch to the deepest point
    time: np.ndarray  # (n,) integral of u from touch to each node
    length: float  # integral of u from touch to release
    work: np.ndarray  # (SCRATCH,)


@jit
def slopes(ps, damper, wall, arc, c, d):
    """Fill the rows FB, FT, FG, FH with the derivatives at all nodes."""
    w, u, S = arc.work, arc.u, arc.S
    for i in range(arc.n):
        b = w[B + i]
        b2 = b * b
        b4 = b2 * b2
        speed = wall.speed * b4 * b
        z = b4 * u[i] * u[i]
        s = speed * S[i]
        x1 = w[G + i] + damper.share * z
        v1 = w[H + i] + damper.share * s
        cosine, sine = turn(ps.omega * w[T + i])
        drive = c * cosine - d * sine
        alone = ps.force * drive - ps.stiffness * x1 - ps.damping * v1
        a = alone - (damper.k2 * (wall.gap + z) + damper.c2 * s) * damper.inv_mu
        per = u[i] / (wall.kappa * b4 * b2 - a * u[i] * u[i])
        dt = 2.5 * speed * per
        w[FB + i] = 0.5 * S[i] * a * b * per
        w[FT + i] = dt
        w[FG + i] = w[H + i] * dt
        w[FH + i] = alone * (1.0 - damper.share) * dt


@jit
def first_guess(ps, damper, wall, arc, b, s, x1, v1, drive):
    """Fill the unknowns at the nodes to first order in the external acceleration."""
    w = arc.work
    b2 = b * b
    _, outside = accelerations(ps, damper, x1, v1, wall.gap, s, drive, 0.0)
    drag = (damper.c2 * damper.inv_mu + ps.damping * damper.share) * s
    per = 1.0 / (wall.kappa * b2 * b2 * b2)
    tick = 2.5 * wall.speed * per * b2 * b2 * b
    rest = v1 - damper.share * s
    for i in range(arc.n):
        steady = 0.25 * (outside + drag) * arc.u[i] * arc.u[i]
        w[B + i] = b * (1.0 + (steady - drag * arc.loss[i]) * per)
        w[T + i] = tick * arc.time[i]
        w[G + i] = x1 + rest * w[T + i]
        w[H + i] = rest


@jit
def sweep(arc, b, x, v):
    """Integrate the slopes from touch to every node; return the largest change of b."""
    w, n = arc.work, arc.n
    for i in range(n):
        w[OLD + i] = w[B + i]
        w[B + i] = b
        w[T + i] = 0.0
        w[G + i] = x
        w[H + i] = v
    for j in range(n):
        fb, ft, fg, fh = w[FB + j], w[FT + j], w[FG + j], w[FH + j]
        row = j * n
        for i in range(n):
            q = arc.cover[row + i]
            w[B + i] += q * fb
            w[T + i] += q * ft
            w[G + i] += q * fg
            w[H + i] += q * fh
    change = 0.0
    for i in range(n):
        change = max(change, abs(w[B + i] - w[OLD + i]))
    return change


@jit
def integral(arc, weight, row):
    """Return the integral of a row of slopes with the given weights."""
    total = 0.0
    for i in range(arc.n):
        total += weight[i] * arc.work[row + i]
    return total


@jit
def short_impact(ps, damper, wall, arc, rate, c, d, q, s, x1, v1):
    """Solve one impact from touch (q = 0, r = gap, approach speed s > 0) to release.

    c, d are cos and sin of the forcing's phase at touch, `rate` the bound of `flight.rate_of`.
    Returns (solved, s, x1, v1, duration [s], depth [m]) at release; solved is False where the
    impact is not a short bump or has begun already, and nothing else may be used then.
    """
    if not (q == 0.0 and s > 0.0):
        return False, s, x1, v1, 0.0, 0.0
    b = (s / wall.speed) ** 0.2
    peak = wall.kappa * b * b * b * b * b * b
    duration = 2.5 * s / peak * arc.length
    _, outside = accelerations(ps, damper, x1, v1, wall.gap, s, c, 0.0)
    if not (abs(outside) < LARGEST_SHARE * peak and rate * duration < LONGEST):
        return False, s, x1, v1, 0.0, 0.0
    w = arc.work
    rest = v1 - damper.share * s
    first_guess(ps, damper, wall, arc, b, s, x1, v1, c)
    for _ in range(MOST_SWEEPS):
        slopes(ps, damper, wall, arc, c, d)
        change = sweep(arc, b, x1, rest)
        if change < SETTLED * b:
            slopes(ps, damper, wall, arc, c, d)
            deep = b + integral(arc, arc.middle, FB)
            out = b + integral(arc, arc.weight, FB)
            duration = integral(arc, arc.weight, FT)
            x1 += integral(arc, arc.weight, FG)
            rest += integral(arc, arc.weight, FH)
            speed = wall.speed * out * out * out * out * out
            depth = deep * deep * deep * deep
            return True, -speed, x1, rest - damper.share * speed, duration, depth
    return False, s, x1, v1, 0.0, 0.0
