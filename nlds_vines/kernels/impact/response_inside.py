"""The response over a short impact: on its two halves, as its energies are (`inside`).

Integrals over time are sums over the collocation's nodes, by its own weights. What is largest is so
at a place, at the deepest point (the force, the stroke), or where a rate vanishes between two
places: such roots are located on the polynomial through all of them. States are taken forward in
time in both halves.
"""

from __future__ import annotations

import math

from ..motion.response_sums import (
    BEGIN,
    KEPT,
    MOTIONS,
    OF_FOOT,
    OF_FORCE,
    PLACES,
    add,
    motion_of,
    place_of,
    raise_to,
)
from ..numerics.compiling import jit
from ..numerics.roots import narrowed, secant
from ..scene.drive import cos_sin, rotated
from ..watch.response_steps import may_rise
from .impact import FT, LARGEST, LENGTH, LONGEST, WEIGHT, B, G, H, S, T, approach_of
from .inside import PRECISE, ROOT_STEPS, WEIGHED, backward, half_impact, weigh

SAME = 1.0e-6  # relative difference of an impact's duration from that of its halves, at most


@jit
def state_of_place(half, wall, i, way):
    """Return (z, (x1, v1, r, s), (cos, sin)) at place i of a half, forward in time.

    Place 0 is the touch or the release, the last one the deepest point; way: 1 where the half
    begins at touch, -1 at release.
    """
    w, n, share, approach = half.nodes.w, half.nodes.n, half.damper.share, half.approach
    z, s, x1, v1, time = 0.0, approach.s, approach.x, approach.v + share * approach.s, 0.0
    if i > 0:
        b, u, speed = w[B + i - 1], 1.0, 0.0
        if i <= n:
            u, speed = w[half.nodes.at + i - 1], w[half.nodes.at + S * half.nodes.m + i - 1]
        b4 = (b * b) * (b * b)
        z, s, time = b4 * (u * u), wall.speed * (b4 * b) * speed, w[T + i - 1]
        x1, v1 = w[G + i - 1] + share * z, w[H + i - 1] + share * s
    cosine, sine = cos_sin(half.ps.omega * time)
    phase = approach.c * cosine - approach.d * sine, way * (approach.d * cosine + approach.c * sine)
    return z, (x1, way * v1, wall.gap + z, way * s), phase


@jit
def fill_motions(ps, damper, wall, tally, half, way):
    """Fill the rows MOTIONS with quantities and rates at the places; add the integrals."""
    w, n, row = half.nodes.w, half.nodes.n, tally.row
    weight = half.nodes.at + WEIGHT * half.nodes.m
    whole = 0.0
    for i in range(n):
        whole += w[weight + i] * w[FT + i]
    for i in range(n + 2):
        z, y, phase = state_of_place(half, wall, i, way)
        q = math.sqrt(z)
        force, push = wall.K * z * q, 1.5 * wall.K * q * y[3]
        values, rates = motion_of(tally, ps, damper, y, phase, force, push)
        for which in range(OF_FORCE + 1):
            row[MOTIONS + 2 * PLACES * which + i] = values[which]
            row[MOTIONS + 2 * PLACES * which + PLACES + i] = rates[which]
        if 0 < i <= n:
            dt = w[weight + i - 1] * w[FT + i - 1] * (half.time / whole)
            add(tally, dt, y, values[2], phase[0], (values[OF_FOOT], rates[OF_FOOT]))


@jit
def value_of(half, row, first, total):
    """Return a quantity where `weigh` returned `total`; first: its row."""
    found = 0.0
    for i in range(half.nodes.n + 2):
        found += half.nodes.w[WEIGHED + i] * row[first + i]
    return found / total


@jit
def raise_in_half(tally, half, which, place):
    """Raise a maximum to that of a quantity over a half."""
    w, row = half.nodes.w, tally.row
    first = MOTIONS + 2 * PLACES * which
    for i in range(half.nodes.n + 2):
        raise_to(row, place, row[first + i])
    for i in range(half.nodes.n + 1):
        time = w[T + i] - (w[T + i - 1] if i > 0 else 0.0)
        f0, f1 = row[first + i], row[first + i + 1]
        g0, g1 = row[first + PLACES + i], row[first + PLACES + i + 1]
        if may_rise(row[place], f0, f1, g0, g1, time):
            low, high = w[half.places + i], w[half.places + i + 1]
            for _ in range(ROOT_STEPS):
                x = secant(low, high, g0, g1)
                total = weigh(half, x)
                g = value_of(half, row, first + PLACES, total)
                raise_to(row, place, value_of(half, row, first, total))
                if g == 0.0 or min(x - low, high - x) < PRECISE:
                    break
                low, high, g0, g1 = narrowed(low, high, g0, g1, x, g)


@jit
def tally_half(ps, damper, wall, sign, tally, half, way):
    """Add a half that is solved; ps, damper: forward in time."""
    fill_motions(ps, damper, wall, tally, half, way)
    for which in range(OF_FORCE + 1):
        if which != OF_FOOT or tally.foot is not None:
            raise_in_half(tally, half, which, place_of(which, sign))


@jit
def tally_halves(side, tally, phase, took, before, after):
    """Try to add an impact by its halves; return whether it is a short one.

    before, after: (q, s, x1, v1) at touch and release, and phase (cos, sin) at touch, all as at a
    near wall; took: its duration [s].
    """
    ps, damper, wall, sign = side.ps, side.damper, side.wall, side.sign
    q, s, x1, v1 = before
    if not (q == 0.0 and s > 0.0):
        return False
    approach = approach_of(side.ps, side.damper, side.wall, phase, (s, x1, v1))
    if not (approach.size < LARGEST and side.rate * (approach.tick * LENGTH) < LONGEST):
        return False
    row = tally.row
    for i in range(BEGIN):
        row[KEPT + i] = row[i]
    half = half_impact(side, phase, (s, x1, v1))
    time = half.time
    tally_half(ps, damper, wall, sign, tally, half, 1.0)
    _, s, x1, v1 = after
    cosine, sine = rotated(phase[0], phase[1], ps.omega * took)
    half = half_impact(backward(side), (cosine, -sine), (-s, x1, -v1))
    tally_half(ps, damper, wall, sign, tally, half, -1.0)
    if abs(time + half.time - took) <= SAME * took:
        return True
    for i in range(BEGIN):  # it was stepped, although it looks like a short one
        row[i] = row[KEPT + i]
    return False
