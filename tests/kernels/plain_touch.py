"""Touches, near misses and bounds of polynomials whose roots and turns are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from support import grid_with

from nlds_vines.kernels.numerics.roots import SLOPE_ERROR, VALUE_ERROR, highest, only_rises
from nlds_vines.kernels.watch import observe
from nlds_vines.kernels.watch.touch import NOWHERE, first_touch, nearest_miss, note_limit

LEVEL = 0.06


def prepared(p):
    """Return the cell of a polynomial r(x), and bounds of its second and third derivative."""
    bounds = (max(np.abs(p.deriv(n).coef).sum(), 1e-9) for n in (2, 3))
    return grid_with(p).table, *bounds


def touch(excess, x=0.0, end=1.0, sign=1.0):
    """Return the first touch of sign r = LEVEL + excess(x)."""
    cell, bend, jerk = prepared(sign * (Polynomial([LEVEL]) + excess))
    return first_touch(cell, x, end, sign, LEVEL, bend, jerk)


def from_roots(*roots):
    """Return the excess with these roots, negative before the first of them."""
    p = Polynomial.fromroots(roots)
    return p if p(min(roots) - 1) < 0 else -p


X = Polynomial([0.0, 1.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    "roots",
    [(0.3,), (0.2, 0.5, 0.8), (0.5, 0.5000001), (1e-12, 0.4), (0.999999999,), (0.1, 0.1, 0.1, 0.9)],
)
def test_first_of_the_roots(roots, sign):
    place = touch(from_roots(*roots), sign=sign)
    accuracy = 1e-5 if len(set(roots)) < len(roots) else 1e-9  # of a triple root: 1e-17^(1/3)
    assert place == pytest.approx(roots[0], abs=accuracy)


@pytest.mark.parametrize(
    ("excess", "root"),
    [
        (X**3 - X**4, 0.0),
        (X**4 + X**5, 0.0),
        (X**9, 0.0),
        (-1e-20 * X**2 + X**3, 0.0),  # the first term is round-off
        (2 * X**5 - X**4, 0.5),
        (-1e-13 * X**2 - X**4 + 4 * X**6, 0.5),
        (-(X**3) - X**4, NOWHERE),
        (0.0 * X, NOWHERE),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_start_at_rest_on_the_level(excess, root, sign):
    """It touches where it has risen by round-off, or where it comes back."""
    place = touch(excess, sign=sign)
    if root == 0.0:
        assert 0.0 < place < 0.1
        assert 0.0 < excess(place) < 1e-15
    else:
        assert place == pytest.approx(root, abs=1e-9)


@given(st.sets(st.integers(1, 19), min_size=1, max_size=5))
def test_first_of_any_roots(twentieths):
    roots = [n / 20 for n in twentieths]
    assert touch(from_roots(*roots)) == pytest.approx(min(roots), abs=1e-9)


PLACES = {  # an excess, and where it is first zero, to how much
    "that is cleared by a hair": (-((X - 0.5) ** 2) - 1e-12, NOWHERE),
    "by a hair": (-((X - 0.5) ** 2) + 1e-12, 0.5 - 1e-6, 1e-8),
    "within the end of the cell": (X - 1 + 1e-9, 1 - 1e-9, 1e-14),
    "beyond the end of the cell": (X - 1 - 1e-9, NOWHERE),
    **{
        f"ever faster, {b:g} x^2 + x = 1": (
            b * X**2 + X - 1,
            2.0 / (1.0 + np.sqrt(1 + 4 * b)),
            1e-12,
        )
        for b in (0.5, 4.0, 40.0, 400.0)  # Newton's step from below would pass the root
    },
    "on the wall, moving in ever slower": (X - X**2, 0.0),
    "on the wall, moving in": (X, 0.0),
    "on the wall, moving in ever faster": (X + X**2, 0.0),
    "on the wall, moving away": (-X + 0.5 * X**2, NOWHERE),
    "on the wall, moving away and coming back": (-X + 2 * X**2, 0.5, 1e-12),
    "on the wall, pressed in": (X**2, 0.0),
    "on the wall, drawn away": (-(X**2), NOWHERE),
    "on the wall, drawn away, then back": (-(X**2) + 2 * X**3, 0.5, 1e-12),
}


@pytest.mark.parametrize("place", PLACES)
def test_touch(place):
    excess, wanted, *within = PLACES[place]
    assert touch(excess) == pytest.approx(wanted, abs=sum(within), rel=0)


def test_a_cell_is_searched_from_where_and_up_to_where_it_is_told():
    assert touch(X - 0.5, end=0.4) == NOWHERE
    roots = from_roots(0.2, 0.4, 0.6)
    assert touch(roots, x=0.45) == pytest.approx(0.6, abs=1e-12)


def nearest(p, best=-np.inf, end=1.0, sign=1.0):
    cell, bend, jerk = prepared(sign * p)
    return nearest_miss(cell, 0.0, sign, end, best, bend, jerk, False)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nearest_miss_of_several(sign):
    p = Polynomial.fromroots((0.1, 0.35, 0.6, 0.9))
    turns = p.deriv().roots()
    p = -p
    tops = [p(x) for x in turns if p.deriv(2)(x) < 0]
    assert len(tops) == 2
    assert nearest(p, -1.0, sign=sign) == pytest.approx(max(tops), abs=1e-15)


def test_only_a_miss_that_has_turned_and_is_closer_counts():
    assert nearest(-((X - 0.5) ** 2), -1.0, end=0.4) == -1.0
    assert nearest(X, -1.0) == -1.0
    assert nearest(-((X - 0.5) ** 2), 0.01) == 0.01


def watched(*pieces):
    """Return the note of excesses over LEVEL, in consecutive cells of 0.5 s."""
    log = np.zeros(6)
    log[[observe.LIMIT, observe.FIRST_VIOLATION, observe.ORIGIN]] = LEVEL, np.nan, 10.0
    for j, excess in enumerate(pieces):
        cell, bend, jerk = prepared(Polynomial([LEVEL]) + excess)
        note_limit(SimpleNamespace(table=cell, h=0.5), log, float(j), 1.0, bend, jerk)
    return log


def test_excursions_beyond_a_limit_are_counted_with_the_first_and_the_deepest():
    p = from_roots(0.2, 0.3, 0.5, 0.9)
    top = max(p(x) for x in p.deriv().roots())
    log = watched(p)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (2.0, 0.0)
    assert log[observe.FIRST_VIOLATION] == pytest.approx(10.1, abs=1e-9)
    assert log[observe.EXCESS] == pytest.approx(top, abs=1e-12)
    # an excursion over several cells is one
    p = from_roots(0.4, 2.8)
    log = watched(*(p(X + shift) for shift in range(4)))
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (1.0, 0.0)
    assert log[observe.FIRST_VIOLATION] == pytest.approx(10.2, abs=1e-9)
    assert log[observe.EXCESS] == pytest.approx(p(1.6), abs=1e-12)
    # it turns within the last cell: first down, then up to its end
    p = 0.1 + (X - 0.3) ** 2
    log = watched(X - 0.5, p)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (1.0, 1.0)
    assert log[observe.EXCESS] == pytest.approx(max(p(1.0), 0.5), abs=1e-12)
    # a limit that is cleared by a hair
    log = watched(-((X - 0.5) ** 2) - 1e-12)
    assert (log[observe.NUMBER], log[observe.EXCESS]) == (0.0, 0.0)
    assert np.isnan(log[observe.FIRST_VIOLATION])
    assert watched(-((X - 0.5) ** 2) + 1e-12)[observe.NUMBER] == 1.0


SAMPLES = np.linspace(0.0, 1.0, 2001)


def ends(p):
    """Return the values and slopes of a polynomial at 0 and 1, and the size of its p''''."""
    d = p.deriv()
    return p(0.0), p(1.0), d(0.0), d(1.0), np.abs(p.deriv(4)(SAMPLES)).max()


def test_the_errors_of_the_cubic_are_those_of_a_quartic():
    """x^2 (1 - x)^2 has zero values and slopes at the ends: it is all error. Its p'''' is 24."""
    rest = X**2 * (1 - X) ** 2
    assert ends(rest)[4] == 24.0
    assert rest(SAMPLES).max() == pytest.approx(24.0 * VALUE_ERROR, rel=1e-12)
    assert rest.deriv()(SAMPLES).max() == pytest.approx(24.0 * SLOPE_ERROR, rel=1e-6)
    assert pytest.approx(SLOPE_ERROR, rel=1e-15) == np.sqrt(3.0) / 216.0


def test_the_highest_value_is_bounded_and_reached():
    """Level at both ends, with a quartic on top. Notices: a smaller error of the cubic."""
    for level in (0.0, -3.0, 7.0):
        p = level + X**2 * (1 - X) ** 2
        assert highest(*ends(p)) == pytest.approx(p(0.5), rel=1e-14)
    for seed in range(300):
        p = Polynomial(np.random.default_rng(seed).normal(size=3 + seed % 9))
        assert highest(*ends(p)) >= p(SAMPLES).max() - 1e-13


def test_a_straight_line_has_its_end_for_bound():
    """Notices: coefficients with the slope's sign or third part wrong."""
    for slope in (2.0, -2.0):
        p = 1.0 + slope * X
        assert highest(*ends(p)) == max(p(0.0), p(1.0))
    p = (X - 0.5) ** 2
    assert highest(*ends(p)) == pytest.approx(0.25)
    p = -((X - 0.5) ** 2)
    assert highest(*ends(p)) == pytest.approx(1.0 / 12.0)  # Bernstein's coefficient of the middle


def test_what_only_rises_is_told_just_so():
    """A quartic of every size on a slope, which falls from some size on, and no sooner."""
    falls_from = 1.0 / np.abs((X**2 * (1 - X) ** 2).deriv()(SAMPLES)).max()
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
        least = p.deriv()(SAMPLES).min()
        is_rising = only_rises(*ends(p))
        rises += is_rising
        assert not is_rising or least > 0.0
    assert rises > 40
