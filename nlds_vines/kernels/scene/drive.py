"""The force on the structure at an instant, in units of P: a harmonic one, or a load.

Of a harmonic force an instant is (cos, sin) of its phase; of a load it is a `Moment`, a place on
the polynomial of a cell (`load_cells`). Which of the two is decided when a kernel is compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from .scene import greatest_push


class Moment(NamedTuple):
    """An instant of a load, whose force is sign sum_k w[row + k] (x + t / length)^k a time t later.

    That holds within the cell to which the row belongs.
    """

    w: Any  # coefficients of cells, a bare row
    row: int  # place of those of this cell
    degree: int
    x: float  # place in the cell
    length: float  # of the cell [s], negative backward in time
    sign: float  # -1 as a wall sees it that pushes towards -x2


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
    """Return (cos, sin) = (c, d) of a phase turned on by a small angle."""
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
    return moment.sign * (even + odd * x)


@jit
def drive_now(phase):
    """Return the force at an instant."""
    if is_a(phase, Moment):
        return force_at_place(phase)
    return phase[0]


@jit
def force_at_place(moment):
    """Return the force of a load at a moment."""
    if moment.x == 0.0:
        return moment.sign * moment.w[moment.row]
    return force_there(moment, moment.x)


@jit
def drive_after(ps, phase, time):
    """Return the force a `time` [s] later, one or four at once."""
    if is_a(phase, Moment):
        return force_there(phase, phase.x + time * (1.0 / phase.length))
    cosine, sine = cos_sin(ps.omega * time)
    return phase[0] * cosine - phase[1] * sine


@jit
def later(ps, phase, time):
    """Return the instant a short `time` [s] later."""
    if is_a(phase, Moment):
        return moved(phase, phase.x + time / phase.length)
    return rotated(phase[0], phase[1], ps.omega * time)


@jit
def moved(moment, x):
    """Return the moment at another place of its cell."""
    return Moment(moment.w, moment.row, moment.degree, x, moment.length, moment.sign)


@jit
def falling(ps, phase):
    """Return minus the rate of the force per mass [m/s^3] at an instant."""
    if is_a(phase, Moment):
        return -ps.force * slope_at(phase)
    return ps.force * ps.omega * phase[1]


@jit
def falling_apart(ps, phase):
    """Return the same of what does not shake both bodies."""
    if ps.shaken is None:
        return falling(ps, phase)
    return 0.0


@jit
def slope_at(moment):
    """Return the rate by time of the force of a load."""
    k, slope = moment.degree, 0.0
    while k > 0:
        slope = slope * moment.x + k * moment.w[moment.row + k]
        k -= 1
    return moment.sign * slope / moment.length


@jit
def mirrored(phase, sign):
    """Return the instant as a wall sees it that pushes towards `sign` x2: eq. (5) is odd."""
    if is_a(phase, Moment):
        return Moment(
            phase.w, phase.row, phase.degree, phase.x, phase.length, sign * phase.sign
        )  # fmt: skip
    return (sign * phase[0], sign * phase[1])


@jit
def most_in_cell(moment):
    """Return a bound of the force of a load in the cell."""
    most = 0.0
    for k in range(moment.degree + 1):
        most += abs(moment.w[moment.row + k])
    return most


@jit
def most_push(ps, phase):
    """Return the largest acceleration [m/s^2] of the structure by force and load."""
    if is_a(phase, Moment):
        return greatest_push(ps.load, ps.force * most_in_cell(phase))
    return greatest_push(ps.load, abs(ps.force))
