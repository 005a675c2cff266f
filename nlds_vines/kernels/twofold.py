"""Numbers of twice the precision: pairs whose second is what the first has lost by rounding.

What a sum or a product of two numbers loses by rounding is a number, too (T. J. Dekker, Numer.
Math. 18, 224, 1971). No processor's fused product is asked for: the bits are the same everywhere.
"""

from __future__ import annotations

from .compiling import jit

SPLITTER = 134217729.0  # 2^27 + 1, which cuts a number of 53 bits into two of 26


@jit(inlined=True)
def two_sum(a, b):
    """Return (a + b, what it has lost by rounding) of single numbers or fours."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@jit(inlined=True)
def split(a):
    """Return (head, rest) of a number or a four: a is their sum, and each has 26 bits."""
    large = SPLITTER * a
    head = large - (large - a)
    return head, a - head


@jit(inlined=True)
def two_product(a, b):
    """Return (a b, what it has lost by rounding); a, b: numbers, or one or both of them fours."""
    product = a * b
    (a0, a1), (b0, b1) = split(a), split(b)
    return product, ((a0 * b0 - product) + a0 * b1 + a1 * b0) + a1 * b1


@jit
def plus(a, b):
    """Return the sum of two pairs."""
    total, lost = two_sum(a[0], b[0])
    return two_sum(total, lost + (a[1] + b[1]))


@jit
def times(a, b):
    """Return the product of two pairs."""
    product, lost = two_product(a[0], b[0])
    return two_sum(product, lost + (a[0] * b[1] + a[1] * b[0]))


@jit
def quotient(a, n):
    """Return a / n of single numbers as a pair."""
    first = a / n
    product, lost = two_product(first, n)
    return two_sum(first, ((a - product) - lost) / n)
