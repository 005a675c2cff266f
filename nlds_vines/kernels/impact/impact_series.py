"""A short impact as a power series in its five small numbers.

With the amplitude b = b0 (1 + beta) and the time t = tick tau, an impact obeys

    beta' = S u w a / (2 den)      tau' = u w^5 / den      w = 1 + beta    den = w^6 - a u^2
    a = A - D w^5 S + R tau + Z w^4 u^2 + Q tau^2

in the free arc u(phi), S(phi): a is what accelerates r beside the contact, in units of the
contact's own kappa b0^6, written as a force A, a drag D, a drift R, a spring Z and a curvature Q
(`approach.Approach`). Of an impact that lasts theta, in units of the other motion's time, A
and D are of the order theta^2 or less, R is A theta, Z is theta^4 and Q is A theta^2 at most: terms
are kept by the sum of their TERM_WEIGHTS, which are orders in halves.

The series is exact: beta and tau obey it whatever integrates them. So it is solved twice, with the
integrals of a collocation of n nodes and with true ones: the first is a guess from which the sweeps
need not start afresh, the difference at the arc's end is the error of the collocation.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

SMALL_NUMBERS = 5  # A, D, R, Z, Q
TERM_WEIGHTS = (2, 2, 3, 4, 5)
HALF_ORDERS = 8  # of the terms that are kept, in halves
ONE = (0,) * SMALL_NUMBERS

Term = tuple[int, ...]
"""The powers of A, D, R, Z and Q in a term."""
Integrate = Callable[[np.ndarray], np.ndarray]
"""Values at nodes -> their integrals from touch to each node."""


def weight_of_term(term: Term) -> int:
    """Return the order of a term in halves."""
    return sum(power * weight for power, weight in zip(term, TERM_WEIGHTS, strict=True))


def terms_up_to(order: int) -> list[Term]:
    """Return the terms up to an order (in halves), by order and then with the most of A first."""
    ranges = (range(order // weight + 1) for weight in TERM_WEIGHTS)
    found = (term for term in product(*ranges) if weight_of_term(term) <= order)
    return sorted(found, key=lambda term: (weight_of_term(term), tuple(-power for power in term)))


ALL_TERMS = terms_up_to(HALF_ORDERS)


def factors_of(terms: list[Term]) -> tuple[list[int], list[int]]:
    """Return the places of two terms whose product is each of `terms`.

    The second is one of the five numbers alone, the first has one less of it; of such a number
    itself, that is 1, the first term. Of 1 both are itself.
    """
    fewer, once = [0], [0]
    for term in terms[1:]:
        which = next(i for i, power in enumerate(term) if power)
        number = tuple(int(i == which) for i in range(SMALL_NUMBERS))
        rest = tuple(a - b for a, b in zip(term, number, strict=True))
        fewer.append(terms.index(rest))
        once.append(terms.index(number))
    return fewer, once


class Series:
    """A truncated power series whose coefficients are arrays of one shape."""

    def __init__(self, coefficients: dict[Term, np.ndarray], order: int) -> None:
        """Take the coefficients that are not zero, up to an order."""
        self.coefficients, self.order = coefficients, order

    def __add__(self, other: Series) -> Series:
        """Return the sum."""
        found = dict(self.coefficients)
        for term, values in other.coefficients.items():
            found[term] = found[term] + values if term in found else values
        return Series(found, self.order)

    def __sub__(self, other: Series) -> Series:
        """Return the difference."""
        return self + other.scaled(-1.0)

    def __mul__(self, other: Series) -> Series:
        """Return the product, its terms beyond the order left out."""
        found: dict[Term, np.ndarray] = {}
        for one, values in self.coefficients.items():
            for another, others in other.coefficients.items():
                term = tuple(a + b for a, b in zip(one, another, strict=True))
                if weight_of_term(term) <= self.order:
                    part = values * others
                    found[term] = found[term] + part if term in found else part
        return Series(found, self.order)

    def scaled(self, factor: np.ndarray | float) -> Series:
        """Return the series with all coefficients multiplied by a factor."""
        return self.each(lambda values: values * factor)

    def each(self, change: Integrate) -> Series:
        """Return the series of the changed coefficients."""
        changed = {term: change(values) for term, values in self.coefficients.items()}
        return Series(changed, self.order)

    def power(self, n: int) -> Series:
        """Return the n-th power."""
        found = self
        for _ in range(n - 1):
            found = found * self
        return found

    def inverse(self) -> Series:
        """Return 1 / (1 + x) = 1 - x + x^2 - ... of a series 1 + x."""
        one = Series({ONE: np.ones_like(self.coefficients[ONE])}, self.order)
        x = {term: -values for term, values in self.coefficients.items() if term != ONE}
        found = power = one
        for _ in range(self.order // min(TERM_WEIGHTS)):
            power = power * Series(x, self.order)
            found = found + power
        return found

    def at(self, term: Term) -> np.ndarray:
        """Return the coefficient of a term, which may be zero."""
        zero = np.zeros_like(next(iter(self.coefficients.values())))
        return self.coefficients.get(term, zero)


def impact_series(
    u: np.ndarray, S: np.ndarray, integrate: Integrate, order: int = HALF_ORDERS
) -> tuple[Series, Series, Series, Series]:
    """Return the series of beta, tau and of their derivatives by phi, at nodes of the arc u, S.

    Every pass of the fixed point adds a whole order, which is all that it computes anew.
    """
    beta = Series({}, 0)
    tau = Series({ONE: integrate(u)}, 0)
    by_phi = beta, tau
    ones = np.ones_like(u)
    for reached in range(2, order + 2, 2):
        now = min(reached, order)

        def number(i: int, now: int = now) -> Series:
            term = tuple(int(j == i) for j in range(SMALL_NUMBERS))
            return Series({term: ones} if TERM_WEIGHTS[i] <= now else {}, now)

        force, drag, drift, spring, curvature = (number(i) for i in range(SMALL_NUMBERS))
        tau = Series(tau.coefficients, now)
        w = Series({ONE: ones}, now) + beta
        w2 = w * w
        w4 = w2 * w2
        w5 = w4 * w
        a = force - drag * w5.scaled(S) + drift * tau
        a = a + spring * w4.scaled(u * u) + curvature * (tau * tau)
        inverse = (w4 * w2 - a.scaled(u * u)).inverse()
        by_phi = (w * a * inverse).scaled(0.5 * S * u), (w5 * inverse).scaled(u)
        beta, tau = (slope.each(integrate) for slope in by_phi)
    return beta, tau, *by_phi
