"""The bounds that proofs of flight rest on: they hold, and are no larger than they need to be."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from nlds_vines.kernels.flight import COEF, TAYLOR
from nlds_vines.kernels.touch import tightened

PLACES = np.linspace(0.0, 1.0, 201)


def cell_of(p):
    """Return the table of a cell in which r(x) is the polynomial p."""
    cell = np.zeros(TAYLOR)
    cell[COEF + 2 : COEF + 2 + 4 * len(p.coef) : 4] = p.coef
    return cell


@pytest.mark.parametrize("k", range(2, 15))
def test_bounds_from_the_polynomial_hold(k):
    """Those of a power are reached at the end of the cell; no bound is less than what is reached.

    r = x^k has r'' = k (k - 1) x^(k - 2) and r''' = k (k - 1) (k - 2) x^(k - 3).
    """
    second, third = tightened(cell_of(Polynomial([0.0] * k + [1.0])), np.inf, np.inf)
    assert (second, third) == (k * (k - 1.0), k * (k - 1.0) * (k - 2.0))
    mixed = Polynomial(np.random.default_rng(k).normal(size=k + 1))
    second, third = tightened(cell_of(mixed), np.inf, np.inf)
    assert np.abs(mixed.deriv(2)(PLACES)).max() <= second * (1 + 1e-12)
    if k > 2:
        assert np.abs(mixed.deriv(3)(PLACES)).max() <= third * (1 + 1e-12)


def test_bounds_from_the_energy_stay_where_they_are_less():
    cell = cell_of(Polynomial([0.0, 1.0, 2.0, 3.0]))
    assert tightened(cell, 0.5, 0.25) == (0.5, 0.25)
