"""Series in theta of a contact's motion, one power after the other.

The motion over a step and all that it is made of are Taylor polynomials in theta (`taylor`), of
which each coefficient follows from those of lower powers. Here is where they stand, and how those
of products, powers and logarithms follow.

They are polynomials in theta over a UNIT near the length of the step, so that their terms are of
the size of what they sum to, whatever units lengths and times have; it is a power of two, which
changes no bit.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..numerics.elementary import exp, exponent_of, log, power_of_two

# The scratch array k of a contact: the table of a step as a piece of motion (`flight`: FACTOR and
# COEF); rows of ROW numbers, each a state, before a step, after it, and one to keep; from SERIES on
# a row of COLUMNS for each power of theta; AHEAD, what is ahead of an orbit inside an impact that
# is solved (`inside.Ahead`); SHRUNK, the logarithm by which contacts have shrunk volumes of
# variations; UNIT; and from LENGTHS on, those of a step's length in that unit.
#
#   in a row of a state    0  1  2   3   4    5    6    7    8     9 ... 20
#                          q  s  x1  v1  tau  (x1  v1   r    s)    (...) (...) (...)
#                                             four variations, where they are wanted
#   and in VOLUME by how much their volumes shrink
#
# A name is the place of a row's first number, so that k[NEW + 1] is s after a step.
WIDTH = 5  # numbers of a state: q, s, x1, v1, tau
ROW = 24  # distance of the rows
TABLE = 100  # `flight`'s COEF + TERMS
OLD, NEW, SAVE = TABLE, TABLE + ROW, TABLE + 2 * ROW
VOLUME = 23
HIGHEST, ORDER_OF_RK4 = 14, 4  # highest powers
# Columns: what a step changes; what is multiplied by dt/dtheta, COSINE and SINE being those of
# the forcing's phase; the contact's terms, by powers of q from POWERS_OF_Q + 1 on; variations, each
# column a four of one component of all, and their rates; and of a load (`drive`) what is left of
# its polynomial in time, divided by the powers of that.
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
def unit_near(h):
    """Return the `UNIT` of a step of a length h."""
    return power_of_two(min(max(exponent_of(h), LEAST_UNIT), LARGEST_UNIT))


@jit
def fill_lengths(k, h):
    """Fill LENGTHS for a step h."""
    power = 1.0
    for n in range(HIGHEST + 1):
        k[LENGTHS + n] = power
        power *= h / k[UNIT]


@jit
def term_of(k, column, n):
    """Return coefficient n of a column by the place in the step whose LENGTHS stand in k."""
    return k[LENGTHS + n] * k[SERIES + COLUMNS * n + column]


@jit
def column_at(k, column, x):
    """Return the value of a column at a place of that step, from 0 to 1."""
    found = 0.0
    for n in range(HIGHEST, -1, -1):
        found = found * x + term_of(k, column, n)
    return found


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
    """Return coefficient n of the square of a column."""
    found, i, j = 0.0, SERIES + a, SERIES + COLUMNS * n + a
    for _ in range((n + 1) // 2):
        found += k[i] * k[j]
        i, j = i + COLUMNS, j - COLUMNS
    found += found
    if n % 2 == 0:
        found += k[i] * k[j]
    return found


@jit
def power_term(k, a, e, out, n):
    """Return coefficient n of a column to the power e, whose lower ones stand in the column `out`.

    From a^e' a = e a' a^e. Where the column begins with 0 it is 0, as if q^(p e) had no power of
    theta that is looked at.
    """
    first = k[SERIES + a]
    if not first > 0.0:
        return 0.0
    if n == 0:
        return exp(e * log(first))
    found, i, j = 0.0, SERIES + a + COLUMNS, SERIES + COLUMNS * (n - 1) + out
    for m in range(1, n + 1):
        found += (e * m - (n - m)) * k[i] * k[j]
        i, j = i + COLUMNS, j - COLUMNS
    return found / (n * first)


@jit
def logarithm_term(k, a, out, n):
    """Return coefficient n of the logarithm of a column, whose lower ones stand in `out`.

    0 where the column begins with 0: what it is multiplied by begins with no power that counts.
    """
    first = k[SERIES + a]
    if not first > 0.0:
        return 0.0
    if n == 0:
        return log(first)
    found = n * k[SERIES + COLUMNS * n + a]
    for m in range(1, n):
        found -= m * k[SERIES + COLUMNS * m + out] * k[SERIES + COLUMNS * (n - m) + a]
    return found / (n * first)
