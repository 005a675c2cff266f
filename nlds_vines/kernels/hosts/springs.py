"""Springs of dampers that are not linear: their forces, and the series of these in a step.

Beside the linear k r, which belongs to the body, the spring of a link acts along r with the force

    g(r) = k2 r^2 + k3 r^3 + k5 r^5

and stores G(r) = k2 r^3 / 3 + k3 r^4 / 4 + k5 r^6 / 6. Each coefficient may have either sign.

In a step, whose motion is a polynomial in theta, the coefficients of g follow from those of r by
Cauchy's products, one power after the other (as in Jorba and Zou, Experimental Mathematics 14
(2005) 99), and so do those of its derivative g'(r), by which variations move.

`Body.springs` is None without such springs: no kernel then holds any code of them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST, exp, log
from ..scene.law import HIGHEST
from .body import along, push_link

LAST_POWERS_OF_R = 5  # whose terms tell the radius of convergence: r alone may be even or odd


class Springs(NamedTuple):
    """The nonlinear springs of a body and scratch for them; each array is one row."""

    number: int
    links: Any  # (number,) the links along which they act
    k2: Any  # (number,) [N/m^2]
    k3: Any  # (number,) [N/m^3]
    k5: Any  # (number,) [N/m^5]
    series: Any  # number * (HIGHEST + 1) * COLUMNS_OF_SPRING: coefficients in a step
    fast: Any  # (number,) scale of s in a step [m/s]
    constants: Any  # `cell_constants.CellConstants`


# columns of a power of theta in `series`: r, its powers, s, g, g'(r), and dr of a variation
AT_STROKE, AT_SQUARE, AT_CUBE, AT_STROKE_RATE, AT_PUSH, AT_STIFFNESS, AT_VARIED = range(7)
COLUMNS_OF_SPRING = 7


# ---- at an instant -------------------------------------------------------------------------------


@jit
def spring_force(springs, spring, r):
    """Return g(r) [N]."""
    square = r * r
    return square * (springs.k2[spring] + r * (springs.k3[spring] + square * springs.k5[spring]))


@jit
def spring_slope(springs, spring, r):
    """Return g'(r) [N/m]."""
    square = r * r
    inner = 3.0 * springs.k3[spring] + 5.0 * square * springs.k5[spring]
    return r * (2.0 * springs.k2[spring] + r * inner)


@jit
def push_springs(body, y, out, to):
    """Add the accelerations by all springs in a state y to out[to : to + size]."""
    springs = body.springs
    for spring in range(springs.number):
        link = springs.links[spring]
        r, _ = along(body, link, y, 0)
        push_link(body, link, spring_force(springs, spring, r), out, to)


@jit
def kick_by_springs(body, before, time, y):
    """Add to y what springs do in a `time` [s] so short that a linear motion keeps their forces.

    before: the state at its beginning. The forces are those in the middle, so that the error is of
    the third power of the time.
    """
    springs, size = body.springs, body.size
    for spring in range(springs.number):
        link = springs.links[spring]
        r, s = along(body, link, before, 0)
        force = spring_force(springs, spring, r + 0.5 * time * s)
        push_link(body, link, force * (0.5 * time * time), y, 0)
        push_link(body, link, force * time, y, size)


@jit
def kick_variation(body, y, time, rows, at):
    """Add to the variation that begins at rows[at] what springs do as in `kick_by_springs`."""
    springs = body.springs
    for spring in range(springs.number):
        link = springs.links[spring]
        r, _ = along(body, link, y, 0)
        varied, _ = along(body, link, rows, at)
        push = spring_slope(springs, spring, r) * varied
        push_link(body, link, push * time, rows, at + body.size)


# ---- series in a step ----------------------------------------------------------------------------


@jit
def place_of_spring(spring, n):
    """Return the place in `series` of the coefficients n of a spring."""
    return (spring * (HIGHEST + 1) + n) * COLUMNS_OF_SPRING


@jit
def product_of_columns(series, spring, a, b, n):
    """Return coefficient n of the product of two columns of a spring."""
    even = 0.0
    odd = 0.0
    i = place_of_spring(spring, 0) + a
    j = place_of_spring(spring, n) + b
    for _ in range((n + 1) // 2):  # two sums, neither of which waits for the other
        even += series[i] * series[j]
        odd += series[i + COLUMNS_OF_SPRING] * series[j - COLUMNS_OF_SPRING]
        i += 2 * COLUMNS_OF_SPRING
        j -= 2 * COLUMNS_OF_SPRING
    if n % 2 == 0:
        even += series[i] * series[j]
    return even + odd


@jit
def push_springs_in_step(body, S, row, n):
    """Fill coefficient n of all springs, and add what they push to the accelerations of S.

    row: the place of coefficient n of the motion in S.
    """
    springs, series = body.springs, body.springs.series
    for spring in range(springs.number):
        link = springs.links[spring]
        at = place_of_spring(spring, n)
        r, s = along(body, link, S, row)
        series[at + AT_STROKE] = r
        series[at + AT_STROKE_RATE] = s
        square = product_of_columns(series, spring, int(AT_STROKE), int(AT_STROKE), n)
        series[at + AT_SQUARE] = square
        cube = product_of_columns(series, spring, int(AT_STROKE), int(AT_SQUARE), n)
        series[at + AT_CUBE] = cube
        force = springs.k2[spring] * square + springs.k3[spring] * cube
        if springs.k5[spring] != 0.0:
            fifth = product_of_columns(series, spring, int(AT_SQUARE), int(AT_CUBE), n)
            force += springs.k5[spring] * fifth
        series[at + AT_PUSH] = force
        push_link(body, link, force, S, row + 2 * body.size)


@jit
def steepen_springs(body, n):
    """Fill coefficient n of g'(r) of all springs, whose r and r^2 are filled."""
    springs, series = body.springs, body.springs.series
    for spring in range(springs.number):
        at = place_of_spring(spring, n)
        stiffness = 2.0 * springs.k2[spring] * series[at + AT_STROKE]
        stiffness += 3.0 * springs.k3[spring] * series[at + AT_SQUARE]
        if springs.k5[spring] != 0.0:
            fourth = product_of_columns(series, spring, int(AT_SQUARE), int(AT_SQUARE), n)
            stiffness += 5.0 * springs.k5[spring] * fourth
        series[at + AT_STIFFNESS] = stiffness


@jit
def push_variation(body, S, row, n):
    """Add to the accelerations of a variation in S what springs push by its dr, coefficient n."""
    springs, series = body.springs, body.springs.series
    for spring in range(springs.number):
        link = springs.links[spring]
        varied, _ = along(body, link, S, row)
        series[place_of_spring(spring, n) + AT_VARIED] = varied
        push = product_of_columns(series, spring, int(AT_STIFFNESS), int(AT_VARIED), n)
        push_link(body, link, push, S, row + 2 * body.size)


# ---- the length of a step, and its error ---------------------------------------------------------


@jit
def scale_springs(body, rate, y, accelerations):
    """Fill the scales of s [m/s]: speeds of a motion at `rate` with this state and acceleration."""
    springs = body.springs
    for spring in range(springs.number):
        link = springs.links[spring]
        r, s = along(body, link, y, 0)
        a, _ = along(body, link, accelerations, 0)
        springs.fast[spring] = max(abs(s), rate * abs(r), abs(a) / rate)


@jit
def length_by_springs(body, tolerance, longest):
    """Return the length of a step in units of theta whose last terms are within the tolerance.

    The radius of convergence is read from the last terms of s of each spring.
    """
    springs, series = body.springs, body.springs.series
    shortest = longest
    granted = log(tolerance) / HIGHEST
    for spring in range(springs.number):
        for n in range(HIGHEST - LAST_POWERS_OF_R + 1, HIGHEST + 1):
            last = abs(series[place_of_spring(spring, n) + AT_STROKE_RATE])
            if last > TINIEST and springs.fast[spring] > 0.0:
                radius = -log(last / springs.fast[spring]) / n
                shortest = min(shortest, exp(radius + granted))
    return shortest


@jit
def defect_of_springs(body, x, pace, accelerations):
    """Return the sum of the defects of s' along the springs at theta = x units, over their scales.

    pace: unit times dt/dtheta there; accelerations: those by the forces, not by the series.
    """
    springs, series, missing = body.springs, body.springs.series, 0.0
    for spring in range(springs.number):
        slope = 0.0
        for n in range(HIGHEST, 0, -1):
            slope = slope * x + n * series[place_of_spring(spring, n) + AT_STROKE_RATE]
        a, _ = along(body, springs.links[spring], accelerations, 0)
        if springs.fast[spring] > 0.0:
            missing += abs(slope - pace * a) / springs.fast[spring]
    return missing


# ---- energy --------------------------------------------------------------------------------------


@jit
def add_potential(body, link, x, c, degree):
    """Add the energy k r^2 / 2 + G(r) of a link's springs over [0, x] of a step to a polynomial.

    c: its coefficients by powers of the place / x, up to `degree` = 2 HIGHEST. From
    d/dtheta of it = (k r + g) dr/dtheta, with the series of g.
    """
    springs, series = body.springs, body.springs.series
    for spring in range(springs.number):
        if springs.links[spring] != link:
            continue
        k = body.stiffness[link]
        first = place_of_spring(spring, 0)
        r = series[first + AT_STROKE]
        square = r * r
        inner = springs.k3[spring] / 4.0 + square * (springs.k5[spring] / 6.0)
        c[0] += 0.5 * k * square + r * square * (springs.k2[spring] / 3.0 + r * inner)
        power = x
        for n in range(1, degree + 1):
            rate = 0.0  # coefficient n - 1
            for m in range(max(1, n - HIGHEST), min(n, HIGHEST) + 1):
                at = place_of_spring(spring, m)
                other = place_of_spring(spring, n - m)
                force = k * series[other + AT_STROKE] + series[other + AT_PUSH]
                rate += m * series[at + AT_STROKE] * force
            c[n] += power * rate / n
            power *= x
