"""The kernels of a contact law, the general ones of a stepped contact, and the series of its steps.

The file of a law with stepped contacts has a tuple for its walls with at least the fields

    gap, K, kappa    place [m]; stiffness, and stiffness over the reduced mass of the bodies
    root             p of z = q^p
    exponent, speed, whole, lasting    of the free contact, see below (`scales_of`)
    damping          None unless the force depends on dz/dt, too
    switch           None unless the force is another function on either side of a place or a speed

and the kernels that are `needed` below; with a switch also `switching`, `rate_of_switching` and
`acting`. For all others there is a general kernel here.

A contact is regularized (`taylor`) by z = q^p and dt = q^(p - 1) dtheta. p is the smallest number
that makes force and equations polynomial in q; if that is too large, p is such that the first steps
need not be short. A law defines its force twice: as a function of the depth, and as a series, by
which it is stepped. Each step is verified by the function.

The longest step follows from a free contact under a force K z^n, n the `exponent`, in which
s^2 / 2 + kappa z^(n + 1) / (n + 1) is constant. With N = p (n + 1):

    from touch to release    theta = 2 p I(N) q_m / v    time = 2 I(n + 1) z_m / v
    I(N) = integral of 1 / sqrt(1 - u^N) over [0, 1]     v = sqrt(2 kappa / (n + 1)) q_m^(N/2)

These serve as units only.
"""

from __future__ import annotations

import math

from ..numerics.compiling import jit
from ..numerics.elementary import exp, hypotenuse, log, whole_power
from .by_law import by_wall

# ---- Series in theta of a contact's motion, one power after the other ----------------------------
#
# The motion over a step, its rates and the contact's terms are Taylor polynomials in theta
# (`taylor`), whose coefficients follow from those of lower powers.
#
# Theta is in units of UNIT, which is near the length of the step, so that terms and sums are of one
# size, whatever the units of lengths and times are. UNIT is a power of two, which changes no bit.


# The scratch array k of a contact: the table of a step as a piece of motion (`flight`: FACTOR and
# COEF); rows of ROW numbers, each a state: before a step, after it, and one set aside; from SERIES
# on a row of COLUMNS for each power of theta; AHEAD, the numbers of `inside.Ahead`; SHRUNK, the
# logarithm by which contacts have shrunk volumes of variations; UNIT; and from LENGTHS on the
# powers of a step's length in that unit.
#
#   in a row of a state    0  1  2   3   4    5    6    7    8     9 ... 20
#                          q  s  x1  v1  tau  (x1  v1   r    s)    (...) (...) (...)
#                                             four variations
#   and in VOLUME the logarithm by which their volumes shrink in the step
#
# A name is the place of a row's first number, so that k[NEW + 1] is s after a step.
WIDTH = 5  # numbers of a state: q, s, x1, v1, tau
ROW = 24  # distance of the rows
TABLE = 100  # `flight`'s COEF + TERMS
OLD, NEW, SAVE = TABLE, TABLE + ROW, TABLE + 2 * ROW
VOLUME = 23
HIGHEST, ORDER_OF_RK4 = 14, 4  # highest powers
# Columns: the motion; the factors of dt/dtheta, COSINE and SINE being those of the forcing's
# phase; the contact's terms; powers of q from POWERS_OF_Q + 1 on; variations and their rates, each
# column a four of one component of all; the remaining polynomial of a load (`drive_term`).
AT_Q, AT_S, AT_X, TAU, DS, DV, AT_V, COSINE = range(8)
SINE, WEIGHT, DEPTH, ELASTIC, FORCE, STEEP, STIFF, DRAG, LOGARITHM, SHRINKS = range(8, 18)
POWERS_OF_Q, VARIED, RATES, LOADED, COLUMNS = 20, 40, 56, 72, 92
SERIES = TABLE + 3 * ROW
AHEAD = SERIES + COLUMNS * (HIGHEST + 1)
SHRUNK = AHEAD + 9
UNIT = SHRUNK + 1
LENGTHS = UNIT + 1
SCRATCH = LENGTHS + HIGHEST + 1
LEAST_UNIT, LARGEST_UNIT = -1000, 1000  # powers of two


@jit
def term_of(k, column, n):
    """Return coefficient n of a column, by the place in the step whose LENGTHS stand in k."""
    return k[LENGTHS + n] * k[SERIES + COLUMNS * n + column]


@jit
def column_at(k, column, x):
    total = 0.0
    for n in range(HIGHEST, -1, -1):
        total = total * x + term_of(k, column, n)
    return total


@jit
def product(k, a, b, n):
    """Return coefficient n of the product of two columns."""
    even, odd, i, j = 0.0, 0.0, SERIES + a, SERIES + COLUMNS * n + b
    for _ in range((n + 1) // 2):  # two sums at a time, neither of which waits for the other
        even += k[i] * k[j]
        odd += k[i + COLUMNS] * k[j - COLUMNS]
        i, j = i + 2 * COLUMNS, j - 2 * COLUMNS
    if n % 2 == 0:
        even += k[i] * k[j]
    return even + odd


@jit
def square(k, a, n):
    total, i, j = 0.0, SERIES + a, SERIES + COLUMNS * n + a
    for _ in range((n + 1) // 2):
        total += k[i] * k[j]
        i, j = i + COLUMNS, j - COLUMNS
    total += total
    if n % 2 == 0:
        total += k[i] * k[j]
    return total


@jit
def power_term(k, a, e, out, n):
    """Return coefficient n of a column to the power e; the lower ones are in the column `out`.

    By (a^e)' a = e a' a^e. If the column begins with 0 the result is 0, as that of q^(p e) with an
    exponent above all orders.
    """
    first = k[SERIES + a]
    if not first > 0.0:
        return 0.0
    if n == 0:
        return exp(e * log(first))
    total, i, j = 0.0, SERIES + a + COLUMNS, SERIES + COLUMNS * (n - 1) + out
    for m in range(1, n + 1):
        total += (e * m - (n - m)) * k[i] * k[j]
        i, j = i + COLUMNS, j - COLUMNS
    return total / (n * first)


# ---- a wall --------------------------------------------------------------------------------------


@by_wall(needed=True)
def made(sort, gap, damper, cell):
    """Return the wall at r = `gap` [m] with the constants of its contact in a `cell`.

    sort: a wall of this law; damper: the bodies.
    """


@jit
def wall_like(sort, gap, damper, cell):
    if sort is None:
        return None
    return made(sort, gap, damper, cell)


@by_wall(needed=True)
def in_range(sort, cell):
    """Return True if the constants of a law are in range; sort: a wall of that law."""


@by_wall(needed=True)
def fill_constants(sort, change, rates, at):
    """Fill the derivatives of a law's constants by a parameter, from column `at` on.

    change: the derivatives of the numbers of a cell. There is room for `driven.MOST_CONSTANTS`.
    """


@by_wall
def pushes(wall, q, s):
    """Return True if a wall pushes a damper that is beyond the place of touch."""
    return True


@by_wall
def rests(wall, r, s, scale):
    """Return True if a damper rests on a wall at zero depth; scale: of positions, for round-off."""
    return False


@by_wall
def into(wall, r):
    """Return (q, r) of a state at r > gap."""
    return (root_of(wall, r - wall.gap), r)


# ---- depth ---------------------------------------------------------------------------------------


@by_wall
def depth_of(wall, q):
    """Return the depth z [m] that belongs to q."""
    return whole_power(q, wall.root)


@by_wall
def root_of(wall, z):
    """Return the q that belongs to a depth z [m]."""
    if wall.root == 1:
        return z
    if wall.root == 2:
        return math.sqrt(z)
    if not z > 0.0:
        return 0.0
    return exp(log(z) / wall.root)


@by_wall
def weight_of(wall, q):
    """Return dt/dtheta."""
    return whole_power(q, wall.root - 1)


@by_wall
def rate_of_q(wall, s):
    """Return dq/dtheta at dz/dt = s."""
    return s / wall.root


@by_wall
def contact_terms(wall, k, n):
    """Fill coefficient n of the series of dt/dtheta, the depth and the elastic force over K."""
    row = SERIES + COLUMNS * n
    fill_power(k, 1, n)
    for m in range(2, wall.root + 1):
        fill_power(k, m, n)
    k[row + DEPTH] = k[row + POWERS_OF_Q + wall.root]
    k[row + WEIGHT] = 1.0 if n == 0 else 0.0
    if wall.root > 1:
        k[row + WEIGHT] = k[row + POWERS_OF_Q + wall.root - 1]
    k[row + ELASTIC] = elastic_term(wall, k, n)


@jit
def fill_power(k, m, n):
    """Fill coefficient n of q^m by those of lower powers of q."""
    row, half = SERIES + COLUMNS * n, POWERS_OF_Q + m // 2
    if m == 1:
        k[row + POWERS_OF_Q + 1] = k[row + AT_Q]
    elif m % 2 == 0:
        k[row + POWERS_OF_Q + m] = square(k, half, n)
    else:
        k[row + POWERS_OF_Q + m] = product(k, half, half + 1, n)


# ---- force ---------------------------------------------------------------------------------------


@by_wall(needed=True)
def elastic(wall, stiffness, q, z):
    """Return the elastic force [N] at a depth z = z(q); with kappa for K, an acceleration."""


@by_wall(needed=True)
def elastic_term(wall, k, n):
    """Return coefficient n of the series of the elastic force over K; q and z stand in k."""


@by_wall(needed=True)
def steep_term(wall, k, n):
    """Return coefficient n of the series of the derivative of the elastic force by z [N/m]."""


@by_wall
def damped_term(wall, k, column, n):
    """Return coefficient n of a column times the factor by which damping changes a force."""
    return k[SERIES + COLUMNS * n + column]


@by_wall
def smooth_up_to(wall, tangent, at, tolerance):
    """Return the longest step from touch, in units of the greatest q, with small missing terms.

    It is infinite if the force and its derivatives have a series in theta there. at: column of the
    constants' rates of driven variations (`driven.Driven`).
    """
    return math.inf


@by_wall
def drag_term(wall, k, n):
    """Return coefficient n of the series of dF/ds [N s/m]."""
    return 0.0


@by_wall
def damped(wall, s):
    """Return the factor of the elastic force by damping at dz/dt = s."""
    return 1.0


@jit
def force_of(wall, q, z, s):
    """Return the contact force [N] at a depth z = z(q) with s = dz/dt."""
    if wall.damping is None:
        return elastic(wall, wall.K, q, z)
    return elastic(wall, wall.K, q, z) * damped(wall, s)


@by_wall
def at_depth(wall, stiffness, depth):
    """Return the elastic force at a depth [m]."""
    return elastic(wall, stiffness, root_of(wall, depth), depth)


@by_wall
def force_at(wall, depth):
    """Return the greatest force [N] of a contact of this depth [m]; 0 if it has been recorded."""
    if wall.damping is not None:  # it is not at the greatest depth
        return 0.0
    return at_depth(wall, wall.K, depth)


# ---- a force with a switch -----------------------------------------------------------------------


@by_wall
def switching(wall, z, s):
    """Return a number of order one that changes its sign at the switch of a wall."""
    return 1.0


@by_wall
def rate_of_switching(wall, s, ds):
    """Return (f, a): the rate of `switching` is a f [1/s], a >= 0; a is 0 without a switch.

    s, ds: the first and the second derivative of the depth by time.
    """
    return s, 0.0


@by_wall
def acting(wall, positive):
    """Return the wall that acts where `switching` is positive, or where it is not.

    Its force is one smooth function, also on the other side of the switch.
    """
    return wall


# ---- energy --------------------------------------------------------------------------------------


@by_wall(needed=True)
def stored(wall, stiffness, z, q):
    """Return the integral of `elastic` by the depth up to z = z(q); with K as stiffness [J]."""


@by_wall
def contact_energy(wall, z):
    """Return the elastic energy [J] of a contact of depth z [m]."""
    return stored(wall, wall.K, z, root_of(wall, z))


# ---- scales --------------------------------------------------------------------------------------


@jit
def free_integral(N):
    """Return I(N) = sqrt(pi) Gamma(1 + 1/N) / Gamma(1/2 + 1/N) within 0.5 %, N >= 2."""
    return 1.0 + 1.3863 / (N + 0.44)


@jit
def scales_of(p, n, kappa):
    """Return (speed, whole, lasting) of a free contact with z = q^p under a force K z^n.

    The approach speed is speed (greatest depth)^((n + 1)/2); whole: theta from touch to release in
    units of its own rate; lasting: the time in units of depth / speed.
    """
    whole = 2.0 * p * free_integral(p * (n + 1.0)) / math.sqrt(2.0 / (n + 1.0))
    return math.sqrt(2.0 * kappa / (n + 1.0)), whole, 2.0 * free_integral(n + 1.0)


@by_wall
def reach_of(wall, q, z, s):
    """Return q^(N/2) where the free contact through (q, s) turns."""
    return hypotenuse(math.sqrt(z * elastic(wall, 1.0, q, z)), s / wall.speed)


@by_wall
def turn_of(wall, reach):
    """Return (q^(N - 2), q) where a free contact turns, whose q^(N/2) there is `reach`."""
    if not reach > 0.0:
        return 0.0, 0.0
    q = exp(2.0 / (wall.root * (wall.exponent + 1.0)) * log(reach))
    return (reach / q) * (reach / q), q


@by_wall
def pressed(wall, external):
    """Return the square of the rate by theta of a contact that an acceleration [m/s^2] presses.

    It is n |a| q^(p - 2) at the q where the contact carries the acceleration a.
    """
    a = abs(external)
    if wall.root == 2 or not a > 0.0:
        return wall.exponent * a
    q = exp(log(a / wall.kappa) / (wall.root * wall.exponent))
    return wall.exponent * a * (q if wall.root == 3 else exp((wall.root - 2.0) * log(q)))


@by_wall
def faint(wall, ratio):
    """Return the depth [m] at which kappa z^n is `ratio` kappa [m^n]."""
    return exp(log(ratio) / wall.exponent)


# ---- derivatives by parameters -------------------------------------------------------------------


@by_wall(needed=True)
def pushed_term(wall, k, by, at, n):
    """Return coefficient n of the derivative of the force [N] by a parameter of the constants.

    by: the rates of the parameter; those of `fill_constants` begin at column `at`.
    """
