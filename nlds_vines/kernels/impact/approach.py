"""An impact at touch: its free arc, the motion common to both masses, and five small numbers.

What is common is a Taylor polynomial of the time, as the contact does not act on it. With the free
arc of the approach speed it tells what springs, dashpots and the forcing change of the impact (a in
`impact`): all but exactly a force, a drag, a drift, a spring and a curvature. Products of these
numbers are the terms of its series.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.elementary import fifth_root
from ..numerics.fours import four, four_at, four_of, put_four
from ..scene.drive import apart, bending, drive_now, falling, together, twisting
from ..scene.scene import under, with_shaking, without_shaking
from .arc_table import (
    AT_CURVATURE,
    AT_DRAG,
    AT_DRIFT,
    AT_FORCE,
    AT_SPRING,
    CHANGES,
    FACTORS,
    MISSED,
    PRODUCTS,
)


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
    push = without_shaking(ps, push, drive)
    acceleration = with_shaking(ps, other * push, drive)
    slope = apart(ps, falls) + ps.stiffness * v
    jerk = -other * (slope + ps.damping * acceleration) - together(ps, falls)
    bend = apart(ps, bends) + ps.stiffness * acceleration
    snap = -other * (bend + ps.damping * jerk) - together(ps, bends)
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


@jit
def fill_products(w, approach):
    """Fill the terms of the series, of which each is a former one times a small number."""
    w[PRODUCTS] = 1.0
    w[PRODUCTS + AT_FORCE], w[PRODUCTS + AT_DRAG] = approach.force, approach.drag
    w[PRODUCTS + AT_DRIFT], w[PRODUCTS + AT_SPRING] = approach.drift, approach.spring
    w[PRODUCTS + AT_CURVATURE] = approach.curvature
    for k in range(4, MISSED, 4):  # four at once: their factors stand before them
        put_four(w, PRODUCTS + k, gathered(w, k) * gathered(w, MISSED + k))


# ---- what four variations change of it -----------------------------------------------------------


@jit
def pushes_varied(ps, damper, approach, late, x, v):
    """Return e of `impact_variations` at touch and four derivatives by time, apart from b and t.

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
    """Return what variations change of (A, D, R, Z, Q), a four of each.

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


@jit
def fill_changes(w, numbers):
    """Fill what variations change of each term of a series: a product of two (`fill_products`)."""
    force, drag, drift, spring, curvature = numbers
    put_four(w, CHANGES, four(0.0))
    put_four(w, CHANGES + 4 * AT_FORCE, force)
    put_four(w, CHANGES + 4 * AT_DRAG, drag)
    put_four(w, CHANGES + 4 * AT_DRIFT, drift)
    put_four(w, CHANGES + 4 * AT_SPRING, spring)
    put_four(w, CHANGES + 4 * AT_CURVATURE, curvature)
    for k in range(1, MISSED):
        fewer, once = FACTORS[k], FACTORS[MISSED + k]
        change = w[PRODUCTS + fewer] * four_at(w, CHANGES + 4 * once)
        change = change + w[PRODUCTS + once] * four_at(w, CHANGES + 4 * fewer)
        put_four(w, CHANGES + 4 * k, change)
