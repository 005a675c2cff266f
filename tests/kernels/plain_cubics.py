"""Bounds of a motion from its values and slopes at two ends: they hold, and they are reached."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from nlds_vines.kernels.numerics.roots import SLOPE_ERROR, VALUE_ERROR, highest, only_rises

X = Polynomial([0.0, 1.0])
PLACES = np.linspace(0.0, 1.0, 2001)


def ends(p):
    """Return the values and slopes of a polynomial at 0 and 1, and the size of its p''''."""
    d = p.deriv()
    return p(0.0), p(1.0), d(0.0), d(1.0), np.abs(p.deriv(4)(PLACES)).max()


def test_the_errors_of_the_cubic_are_those_of_a_quartic():
    """x^2 (1 - x)^2 has zero values and slopes at the ends: it is all error. Its p'''' is 24."""
    rest = X**2 * (1 - X) ** 2
    assert ends(rest)[4] == 24.0
    assert rest(PLACES).max() == pytest.approx(24.0 * VALUE_ERROR, rel=1e-12)
    assert rest.deriv()(PLACES).max() == pytest.approx(24.0 * SLOPE_ERROR, rel=1e-6)
    assert pytest.approx(SLOPE_ERROR, rel=1e-15) == np.sqrt(3.0) / 216.0


@pytest.mark.kernels
def test_the_highest_value_is_bounded_and_reached():
    """Level at both ends, with a quartic on top. Notices: a smaller error of the cubic."""
    for level in (0.0, -3.0, 7.0):
        p = level + X**2 * (1 - X) ** 2
        assert highest(*ends(p)) == pytest.approx(p(0.5), rel=1e-14)
    for seed in range(300):
        p = Polynomial(np.random.default_rng(seed).normal(size=3 + seed % 9))
        assert highest(*ends(p)) >= p(PLACES).max() - 1e-13


def test_a_straight_line_has_its_end_for_bound():
    """Notices: coefficients with the slope's sign or third part wrong."""
    for slope in (2.0, -2.0):
        p = 1.0 + slope * X
        assert highest(*ends(p)) == max(p(0.0), p(1.0))
    p = (X - 0.5) ** 2
    assert highest(*ends(p)) == pytest.approx(0.25)
    p = -((X - 0.5) ** 2)
    assert highest(*ends(p)) == pytest.approx(1.0 / 12.0)  # Bernstein's coefficient of the middle


@pytest.mark.kernels
def test_what_only_rises_is_told_just_so():
    """A quartic of every size on a slope, which falls from some size on, and no sooner."""
    falls_from = 1.0 / np.abs((X**2 * (1 - X) ** 2).deriv()(PLACES)).max()
    for sign in (1.0, -1.0):
        for size in (0.0, 0.5, 0.999):
            assert only_rises(*ends(X + sign * size * falls_from * X**2 * (1 - X) ** 2))
        assert not only_rises(*ends(X + sign * 1.001 * falls_from * X**2 * (1 - X) ** 2))
    assert not only_rises(*ends(-X))
    assert not only_rises(*ends(X**3 - 0.5 * X**2 + 0.05 * X))  # falls in the middle alone
    assert not only_rises(*ends((X - 0.01) ** 2))
    assert not only_rises(*ends(-((X - 0.99) ** 2)))


@pytest.mark.parametrize("degree", [3, 4, 5, 7, 9])
def test_what_is_told_to_rise_does(degree):
    rises = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        p = Polynomial(rng.normal(size=degree + 1) / 3.0 ** np.arange(degree + 1)) + 0.7 * X
        least = p.deriv()(PLACES).min()
        is_rising = only_rises(*ends(p))
        rises += is_rising
        assert not is_rising or least > 0.0
    assert rises > 40
