"""The force on the structure at an instant, in units of P: a harmonic one, or a load.

An instant of a harmonic force is (cos, sin) of its phase. An instant of a load is a `Moment`, a
place on the polynomial of a cell (`load_cells`). The choice is made when a kernel is compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import TURN, cos_sin_of_turn
from ..numerics.fours import four, four_at, put_four
from .law import COLUMNS, COSINE, LOADED, SERIES, SINE, TAU, UNIT
from .scene import greatest_push

SMALL = 0.1  # angle up to which `cos_sin` is good to round-off


class Moment(NamedTuple):
    """An instant of a load. A time t later its force is sum_k w[row + k] (x + t / length)^k.

    This holds within the cell of the row.
    """

    w: Any  # coefficients of cells, a bare row
    row: int  # place of those of this cell
    degree: int
    x: float  # place in the cell
    length: float  # of the cell [s], negative backward in time


@jit(inlined=True)
def cos_sin(angle):
    """Return (cos, sin) of a small angle by their Taylor polynomials, which err by angle^10 / 10!.

    In a step of a contact the angle is at most 5.6 / steps: 2e-12 of 1 where the step errs by 1e-9.
    """
    a = angle * angle
    a2 = a * a
    c = (1.0 - 0.5 * a) + a2 * ((1.0 / 24.0 - a * (1.0 / 720.0)) + a2 * (1.0 / 40320.0))
    d = (1.0 - a * (1.0 / 6.0)) + a2 * ((1.0 / 120.0 - a * (1.0 / 5040.0)) + a2 * (1.0 / 362880.0))
    return c, angle * d


@jit
def rotated(c, d, angle):
    """Return (cos, sin) of the phase with (cos, sin) = (c, d) turned by a small angle."""
    cosine, sine = cos_sin(angle)
    return c * cosine - d * sine, d * cosine + c * sine


@jit
def force_there(moment, x):
    """Return the force at a place of the cell, one or four at once."""
    w, row, z = moment.w, moment.row, x * x
    k = moment.degree - moment.degree % 2
    even, odd = w[row + k] + 0.0 * x, 0.0 * x
    if moment.degree % 2 == 1:
        odd = odd + w[row + moment.degree]
    while k > 0:
        k -= 2
        even = even * z + w[row + k]
        odd = odd * z + w[row + k + 1]
    return even + odd * x


@jit
def drive_now(phase):
    """Return the force at an instant."""
    if is_a(phase, Moment):
        return phase.w[phase.row] if phase.x == 0.0 else force_there(phase, phase.x)
    return phase[0]


@jit
def later(ps, phase, time):
    if is_a(phase, Moment):
        return moved(phase, phase.x + time / phase.length)
    return rotated(phase[0], phase[1], ps.omega * time)


@jit(inlined=True)
def drive_later(ps, phase, time):
    """Return the force a short `time` [s] after an instant, one or four at once."""
    if is_a(phase, Moment):
        return force_there(phase, phase.x + time * (1.0 / phase.length))
    cosine, sine = cos_sin(ps.omega * time)
    return phase[0] * cosine - phase[1] * sine


@jit
def after(ps, phase, time):
    """Return the instant any `time` [s] later."""
    if is_a(phase, Moment):
        return moved(phase, phase.x + time / phase.length)
    angle = ps.omega * time
    if abs(angle) < SMALL:
        return rotated(phase[0], phase[1], angle)
    cosine, sine = cos_sin_of_turn(angle * (1.0 / TURN))
    c, d = phase
    return c * cosine - d * sine, d * cosine + c * sine


@jit
def drive_term(ps, phase, k, n, turned):
    """Fill coefficient n > 0 of the series of the force; those of the time are there already.

    turned: coefficient n - 1 of cos and of sin times dt/dtheta. A load f is composed with the time
    t by Horner's scheme: f_j + f_(j+1) t + ... is f_j plus t times the next of these sums.
    """
    row, (cosine, sine) = SERIES + COLUMNS * n, turned
    if is_a(phase, Moment):
        top = phase.degree // 4 * 4 + 4
        k[row + LOADED + top] = 0.0
        for j in range(0, top, 4):
            sums = four(0.0)
            for i in range(1, n + 1):
                time = k[SERIES + COLUMNS * i + TAU]
                sums = sums + time * four_at(k, row - COLUMNS * i + LOADED + j + 1)
            put_four(k, row + LOADED + j, sums)
        k[row + COSINE] = k[row + LOADED]
    else:
        turn = ps.omega * k[UNIT] / n
        k[row + COSINE], k[row + SINE] = -turn * sine, turn * cosine


@jit
def moved(moment, x):
    return Moment(moment.w, moment.row, moment.degree, x, moment.length)


@jit
def falling(ps, phase):
    """Return minus the rate of the force per mass [m/s^3] at an instant."""
    if is_a(phase, Moment):
        k, slope = phase.degree, 0.0 * phase.x
        while k > 0:
            slope = slope * phase.x + k * phase.w[phase.row + k]
            k -= 1
        return -ps.force * (slope / phase.length)
    return ps.force * ps.omega * phase[1]


@jit
def bending(ps, phase):
    """Return minus the second rate of the force per mass [m/s^4] at an instant."""
    if is_a(phase, Moment):
        k, bend = phase.degree, 0.0 * phase.x
        while k > 1:
            bend = bend * phase.x + k * (k - 1.0) * phase.w[phase.row + k]
            k -= 1
        return -ps.force * (bend / (phase.length * phase.length))
    return ps.force * ps.omega * ps.omega * phase[0]


@jit
def twisting(ps, phase):
    """Return a bound of the third rate of a load per mass [m/s^5]; 0 for a harmonic force.

    That of a harmonic force follows from its first rate.
    """
    if is_a(phase, Moment):
        # |f_k| k! / (k - 3)! bounds each term of the third derivative within the cell
        twist, h = 0.0, phase.length
        for k in range(3, phase.degree + 1):
            twist += k * (k - 1.0) * (k - 2.0) * abs(phase.w[phase.row + k])
        return ps.force * (twist / abs(h * h * h))
    return 0.0


@jit
def most_push(ps, phase):
    """Return the largest acceleration [m/s^2] of the structure by force and load."""
    if is_a(phase, Moment):
        most = 0.0  # |f_0| + |f_1| + ... bounds the force in the cell
        for k in range(phase.degree + 1):
            most += abs(phase.w[phase.row + k])
        return greatest_push(ps.load, ps.force * most)
    return greatest_push(ps.load, abs(ps.force))
