"""How fast the linear motion may change: bounds on which the cells and their certificates rest.

In energy coordinates (sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2) the motion without forcing
never grows, so that what the energy is tells how far derivatives may go (`scene.scale_of`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..numerics.compiling import jit
from ..scene.scene import greatest_push, joined

REACH = 0.7  # longest cell in units of 1/rate: 0.7^15 / 15! = 4e-15, and the rate is a bound
SHORT = 0.4  # the same in a scene where all is linear, below round-off: 0.4^15 / 15! = 8e-19
FEWEST_CELLS = 8  # in a period: cheap, and short enough for the proofs of `touch` to succeed often
MOST_CELLS = 1 << 19  # in a period: 6 numbers each, 25 MB; beyond it the status is TOO_STIFF


@jit
def rate_of(ps, damper):
    """Return a bound [1/s] on the rates of the linear motion and of the forcing.

    In energy coordinates (sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2) the system's matrix is
    symmetric but for signs, so that its largest row sum bounds its norm.
    """
    on_v1 = math.sqrt(ps.stiffness) + ps.damping
    if damper is None:
        return max(on_v1, ps.omega)
    drag1 = damper.c2 * damper.inv_m1
    drag2 = damper.c2 / damper.m2
    across = math.sqrt(drag1 * drag2)
    pull1, pull2 = math.sqrt(damper.k2 * damper.inv_m1), math.sqrt(damper.k2 / damper.m2)
    on_v1 += drag1 + pull1 + across
    on_v2 = pull2 + drag2 + across
    return max(max(on_v1, on_v2), max(pull1 + pull2, ps.omega))


@jit
def bend_of(ps, damper):
    """Return the factor b with |d2r/dt2| <= b S + P/m1, S the energy scale of `scale_of`.

    The dual norm of the row of eq. (5) that gives d2r/dt2, in energy coordinates.
    """
    if damper is None:
        return 0.0
    on_v2 = damper.c2 * damper.inv_mu
    on_v1 = ps.damping + on_v2
    squares = ps.stiffness / ps.m1
    squares += on_v1 * on_v1 / ps.m1
    squares += damper.k2 * damper.inv_mu * damper.inv_mu
    if on_v2 > 0.0:  # there may be no m2
        squares += on_v2 * on_v2 / damper.m2
    return math.sqrt(squares)


@jit
def dampers_share(ps, damper):
    """Return the largest 2 E2 / S^2, S being the energy scale of `scale_of`.

    E2 takes the absolute displacement of the damper, S that of the structure and the shortening of
    the spring: sqrt(k2) |x1 - r| <= (sqrt(k2 / k1) + 1) S.
    """
    if damper is None:
        return 0.0
    soft = 0.0  # sqrt(k2) |x1| per S: no energy holds a structure without a spring
    if damper.k2 > 0.0:
        soft = math.sqrt(damper.k2 / ps.k1)
    absolute = 1.0 + soft
    return 1.0 + absolute * absolute


@jit
def damper_rates(ps, damper):
    """Return (a, b) with |du/dt| <= a |u| + b S, u = (sqrt(m2) v2, sqrt(k2) x2), E2 = u u / 2.

    m2 dv2/dt = -k2 x2 - c2 v2 + (k2 x1 + c2 v1) by eq. (5): what the structure does to the damper,
    the last part, is at most b S, S being the energy scale of `scale_of`. x2 counts from the rest.
    """
    if damper is None:
        return 0.0, 0.0
    pulls = damper.c2 * damper.c2 / ps.m1
    if damper.k2 > 0.0:  # a structure without a spring may be anywhere
        pulls += damper.k2 * damper.k2 / ps.k1
    own = math.sqrt(damper.k2 / damper.m2) + damper.c2 / damper.m2
    return own, math.sqrt(pulls / damper.m2)


@jit
def cells_of(ps, damper):
    """Return the number of cells in a period: enough for the Taylor polynomials, or -1."""
    period = 2.0 * math.pi / ps.omega
    need = period * rate_of(ps, joined(damper)) / REACH
    if not need <= MOST_CELLS:  # infinite or NaN too, which no integer could tell
        return -1
    return max(FEWEST_CELLS, math.ceil(need))


class Bounds(NamedTuple):
    """Bounds of motions over some cells: derivatives by the place in a cell."""

    bend: float  # of the second derivative of r [m]
    jerk: float  # of the third of r [m]
    fourth: float  # of the fourth of r [m]
    energy: float  # of the fourth derivative of E1 [J]
    scale: float  # of the energy scale S [J^0.5], which the others rest on


@jit
def bounds_of(ps, grid, scale):
    """Return the `Bounds` of motions of at most the energy scale S.

    E1 is half the square of a part of the scaled state u; by Leibniz' rule its fourth derivative is
    u u + 4 u + 3 u'' u''. Each derivative of u is at most `rate` times the one before and
    what the forcing adds.
    """
    first = grid.rate * scale + grid.push
    push = grid.rate * grid.push  # bounds the derivative of the forcing: omega <= rate
    second = grid.rate * first + push
    third = grid.rate * (second + push)
    fourth = grid.rate * (third + grid.rate * push)
    h2 = grid.h * grid.h
    return Bounds(
        (grid.bend * scale + greatest_push(ps.load, ps.force)) * h2,
        (grid.bend * first + ps.omega * ps.force) * h2 * grid.h,
        (grid.bend * second + ps.omega * ps.omega * ps.force) * h2 * h2,
        (scale * fourth + 4.0 * first * third + 3.0 * second * second) * h2 * h2,
        scale,
    )
