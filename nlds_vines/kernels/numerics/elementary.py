"""Sine, cosine, exponential, logarithm and a root by strict arithmetic: the same bits everywhere.

The functions of C and vector libraries differ between versions and processors. These consist of
+, -, *, / and sqrt, whose rounding IEEE 754 prescribes. Arguments are reduced without rounding, the
series are Taylor's, and the rounding error of the leading term is added to the others, so that
errors are below one unit in the last place unless a function states otherwise.
"""

from __future__ import annotations

import math

import numpy as np

from .compiling import jit

TURN = 6.283185307179586  # 2 pi, rounded, as TURN_HIGH + TURN_LOW of 26 digits each
TURN_HIGH, TURN_LOW = 6.283185362815857, -5.563627070159782e-08
TURN_REST = 2.4492935982947064e-16  # 2 pi - TURN
TINIEST = 1.0e-300  # added to bounds that are divisors
SPLITTER = 134217729.0  # 2^27 + 1: cuts a number into two halves of 26 digits each (Veltkamp)

LN2_HIGH = 0.6931471803691238  # ln 2 to 32 digits: its products with exponents are exact
LN2_LOW = 1.9082149292705877e-10  # the rest
PER_LN2 = 1.4426950408889634
PER_LN10 = 0.4342944819032518
ROOT_TWO = 1.4142135623730951

GREATEST = 709.782712893384  # exp of more is infinite
LEAST = -745.1332191019412  # exp of less is zero

FAR_DOWN, FAR_UP = 1.0e-280, 1.0e280  # beyond them a number is scaled first
LIFT = 2.0**60
UNLIFT = 2.0**-60

ROOTS = np.array(
    [1.0, 1.148698354997035, 1.3195079107728942, 1.515716566510398, 1.7411011265922482]
)  # 2^(j/5)
TEN_DIGITS = 2.0**43  # added to a number from 1 to 2 it leaves nine binary places


@jit
def power_of_two(k):
    """Return 2^k, -1022 <= k <= 1023: its bits are those of k + 1023, above 52 of a fraction."""
    return np.int64((np.int64(k) + 1023) << 52).view(np.float64)


@jit
def exponent_of(x):
    """Return the integer e with 2^e <= x < 2^(e + 1) of a number x >= 2^-1022."""
    return (np.float64(x).view(np.int64) >> 52) - 1023


@jit
def hypotenuse(a, b):
    """Return sqrt(a^2 + b^2) without underflow or overflow of the squares."""
    a, b = abs(a), abs(b)
    most = max(a, b)
    if most == 0.0:
        return 0.0
    share = min(a, b) / most
    return most * math.sqrt(1.0 + share * share)


@jit
def cos_sin_of_turn(turn):
    """Return (cos, sin) of 2 pi `turn`, 0 <= turn <= 1e6.

    The nearest quarter of a turn is subtracted; the rest is the angle a + b, b the rounding error
    of a.
    """
    quarter = int(4.0 * turn + 0.5)
    f = turn - 0.25 * quarter
    # a + b = 2 pi f, |a| <= pi / 4
    a = TURN * f
    high = SPLITTER * f
    high = high - (high - f)
    low = f - high
    b = ((high * TURN_HIGH - a) + high * TURN_LOW + low * TURN_HIGH) + low * TURN_LOW
    b += TURN_REST * f
    # (a^3 / 3! - a^5 / 5! + ...) / a^3 and (a^4 / 4! - a^6 / 6! + ...) / a^4
    z = a * a
    z2 = z * z
    z4 = z2 * z2
    odd = (1.0 / 39916800.0 - z * (1.0 / 6227020800.0)) + z2 * (
        1.0 / 1307674368000.0 - z * (1.0 / 355687428096000.0)
    )
    odd = (1.0 / 6.0 - z * (1.0 / 120.0)) + (z2 * (1.0 / 5040.0 - z * (1.0 / 362880.0)) + z4 * odd)
    even = (1.0 / 479001600.0 - z * (1.0 / 87178291200.0)) + z2 * (1.0 / 20922789888000.0)
    even = (1.0 / 24.0 - z * (1.0 / 720.0)) + (
        z2 * (1.0 / 40320.0 - z * (1.0 / 3628800.0)) + z4 * even
    )
    half = 0.5 * z
    d = a + ((b - half * b) - a * z * odd)
    c = 1.0 - half
    c += ((1.0 - c) - half) + (z2 * even - a * b)
    x, y = (-d, c) if quarter & 1 else (c, d)
    return (-x, -y) if quarter & 2 else (x, y)


@jit(entry=True)
def fill_cos_sin(turns, cos, sin):
    """Fill arrays (n,) with cos and sin of 2 pi `turns` (n,)."""
    for i in range(len(turns)):
        cos[i], sin[i] = cos_sin_of_turn(turns[i])


@jit
def exp(x):
    """Return e^x = 2^k e^r, r = x - k ln 2, |r| <= 0.35."""
    if not LEAST <= x <= GREATEST:
        return 0.0 if x < 0.0 else x * math.inf  # NaN stays
    k = int(x * PER_LN2 + (0.5 if x > 0.0 else -0.5))
    high, low = x - k * LN2_HIGH, k * LN2_LOW
    r = high - low
    lost = (high - r) - low
    # r^2 / 2! + r^3 / 3! + ...
    r2 = r * r
    r4 = r2 * r2
    tail = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (
        (1.0 / 479001600.0 + r * (1.0 / 6227020800.0)) + r2 * (1.0 / 87178291200.0)
    )
    tail = (1.0 / 720.0 + r * (1.0 / 5040.0)) + (
        r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0)) + r4 * tail
    )
    tail = r2 * ((0.5 + r * (1.0 / 6.0)) + (r2 * (1.0 / 24.0 + r * (1.0 / 120.0)) + r4 * tail))
    value = 1.0 + (r + (lost + tail))
    first = k // 2  # 2^k itself may be no number
    return value * power_of_two(first) * power_of_two(k - first)


@jit(entry=True)
def fill_exp(x, values):
    """Fill an array (n,) with e^x of `x` (n,)."""
    for i in range(len(x)):
        values[i] = exp(x[i])


@jit
def log(x):
    """Return the natural logarithm; -inf at 0, NaN below.

    x = 2^k (1 + f), 1 + f within a factor of sqrt(2) of 1, and ln(1 + f) = 2 artanh(f / (2 + f)).
    """
    if not 0.0 < x < math.inf:
        return x if x > 0.0 else (-math.inf if x == 0.0 else math.nan)
    k = 0
    if x < FAR_DOWN:
        x, k = x * LIFT, -60
    elif x > FAR_UP:
        x, k = x * UNLIFT, 60
    e = exponent_of(x)
    m = x * power_of_two(-e)
    k += e
    if m > ROOT_TWO:
        m, k = 0.5 * m, k + 1
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    # 2 (s^3 / 3 + s^5 / 5 + ...) / s; 2 s itself is f - f^2 / 2 + s f^2 / 2
    z2 = z * z
    z4 = z2 * z2
    tail = (2.0 / 19.0 + z * (2.0 / 21.0)) + z2 * (2.0 / 23.0 + z * (2.0 / 25.0))
    tail = (2.0 / 11.0 + z * (2.0 / 13.0)) + (z2 * (2.0 / 15.0 + z * (2.0 / 17.0)) + z4 * tail)
    tail = (2.0 / 3.0 + z * (2.0 / 5.0)) + (z2 * (2.0 / 7.0 + z * (2.0 / 9.0)) + z4 * tail)
    tail = z * tail
    half = 0.5 * f * f
    return k * LN2_HIGH - ((half - (s * (half + tail) + k * LN2_LOW)) - f)


@jit
def log10(x):
    """Return the logarithm to base 10, with an error of at most two units in the last place."""
    return PER_LN10 * log(x)


@jit
def fifth_root(x):
    """Return x^(1/5), x >= 0; NaN below.

    The fifth power of a guess y of ten binary digits is exact, and so is x - y^5; x^(1/5) is y
    times a short series in (x - y^5) / y^5.
    """
    if not 0.0 < x < math.inf:
        return x if x >= 0.0 else math.nan
    back = 1.0
    if x < FAR_DOWN:
        x, back = x * LIFT, 2.0**-12
    elif x > FAR_UP:
        x, back = x * UNLIFT, 2.0**12
    e = exponent_of(x)
    fifth = ((e + 1025) * 6554 >> 15) - 205  # e // 5
    m = x * power_of_two(-5 * fifth)  # from 1 to 32
    # f^(1/5) with a relative error of 1e-4, f from 1 to 2, times 2^(j/5)
    j = e - 5 * fifth
    f = x * power_of_two(-e)
    y = ROOTS[j] * ((0.72128 + f * 0.37667) - (f * f) * (0.11427 - f * 0.0164))
    y = (y + TEN_DIGITS) - TEN_DIGITS
    y5 = y * ((y * y) * (y * y))
    g = (m - y5) * (1.0 / y5)
    g2 = g * g
    tail = (0.025536 - g * 0.0204288) + g2 * (0.01692672 - g * 0.014387712)
    tail = g * ((0.2 - g * 0.08) + g2 * ((0.048 - g * 0.0336) + g2 * tail))
    return (y + y * tail) * (power_of_two(fifth) * back)


@jit
def whole_power(q, m):
    """Return q^m, m >= 0 an integer, by squaring: the product of q^(2^i) over the bits i of m.

    About 2 log2(m) products; the relative error is at most some (m - 1) 2^-53.
    """
    result = 1.0
    while m > 0:
        if m % 2 == 1:
            result *= q
        q *= q
        m //= 2
    return result


@jit
def power(q, m, fraction):
    """Return q^(m + fraction) for q >= 0; its error is that of `whole_power`, and |ln q| 2^-53."""
    result = whole_power(q, m)
    if fraction > 0.0:
        result = result * exp(fraction * log(q)) if q > 0.0 else 0.0
    return result
