"""The first touch of a polynomial with known roots, and the closest of known near misses."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from nlds_vines.kernels.motion.flight import COEF, TAYLOR
from nlds_vines.kernels.watch import observe
from nlds_vines.kernels.watch.touch import NOWHERE, first_touch, nearest_miss, note_limit

LEVEL = 0.06


def prepared(p):
    """Return the cell of a polynomial r(x), and bounds of its second and third derivative."""
    cell = np.zeros(TAYLOR)
    cell[COEF + 2 : COEF + 2 + 4 * len(p.coef) : 4] = p.coef
    bounds = (max(np.abs(p.deriv(n).coef).sum(), 1e-9) for n in (2, 3))
    return cell, *bounds


def touch(excess, x=0.0, end=1.0, sign=1.0):
    """Return the first touch of sign r = LEVEL + excess(x)."""
    cell, bend, jerk = prepared(sign * (Polynomial([LEVEL]) + excess))
    return first_touch(cell, x, end, sign, LEVEL, bend, jerk)


def from_roots(*roots):
    """Return the excess with these roots, negative before the first of them."""
    p = Polynomial.fromroots(roots)
    return p if p(min(roots) - 1) < 0 else -p


X = Polynomial([0.0, 1.0])


@pytest.mark.kernels
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


@pytest.mark.parametrize("bend", [0.5, 4.0, 40.0, 400.0])
def test_an_approach_that_speeds_up(bend):
    """Newton's step from below would pass the root: (-1 + sqrt(1 + 4 b)) / 2 b of b x^2 + x = 1."""
    p = bend * X**2 + X - 1
    assert touch(p) == pytest.approx((np.sqrt(1 + 4 * bend) - 1) / (2 * bend), abs=1e-12)


PLACES = {  # an excess, and where it is first zero, to how much
    "that is cleared by a hair": (-((X - 0.5) ** 2) - 1e-12, NOWHERE),
    "by a hair": (-((X - 0.5) ** 2) + 1e-12, 0.5 - 1e-6, 1e-8),
    "within the end of the cell": (X - 1 + 1e-9, 1 - 1e-9, 1e-14),
    "beyond the end of the cell": (X - 1 - 1e-9, NOWHERE),
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


def test_a_cell_ends_where_it_is_told():
    assert touch(X - 0.5, end=0.4) == NOWHERE


def test_starts_in_the_middle():
    roots = from_roots(0.2, 0.4, 0.6)
    assert touch(roots, x=0.45) == pytest.approx(0.6, abs=1e-12)


# ---- near misses ---------------------------------------------------------------------------------


def highest(p, best=-np.inf, end=1.0, sign=1.0):
    cell, bend, jerk = prepared(sign * p)
    return nearest_miss(cell, 0.0, sign, end, best, bend, jerk, False)


@pytest.mark.kernels
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nearest_miss_of_several(sign):
    p = Polynomial.fromroots((0.1, 0.35, 0.6, 0.9))
    turns = p.deriv().roots()
    p = -p
    tops = [p(x) for x in turns if p.deriv(2)(x) < 0]
    assert len(tops) == 2
    assert highest(p, -1.0, sign=sign) == pytest.approx(max(tops), abs=1e-15)


def test_an_approach_that_has_not_turned_is_no_miss():
    assert highest(-((X - 0.5) ** 2), -1.0, end=0.4) == -1.0
    assert highest(X, -1.0) == -1.0


def test_a_closer_miss_stays():
    assert highest(-((X - 0.5) ** 2), 0.01) == 0.01


# ---- a limit -------------------------------------------------------------------------------------


def watched(*pieces):
    """Return the note of excesses over LEVEL, in consecutive cells of 0.5 s."""
    log = np.zeros(6)
    log[[observe.LIMIT, observe.FIRST_VIOLATION, observe.ORIGIN]] = LEVEL, np.nan, 10.0
    for j, excess in enumerate(pieces):
        cell, bend, jerk = prepared(Polynomial([LEVEL]) + excess)
        note_limit(SimpleNamespace(table=cell, h=0.5), log, float(j), 1.0, bend, jerk)
    return log


@pytest.mark.kernels
def test_passages_are_counted_with_the_first_and_the_deepest():
    p = from_roots(0.2, 0.3, 0.5, 0.9)
    top = max(p(x) for x in p.deriv().roots())
    log = watched(p)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (2.0, 0.0)
    assert log[observe.FIRST_VIOLATION] == pytest.approx(10.1, abs=1e-9)
    assert log[observe.EXCESS] == pytest.approx(top, abs=1e-12)


def test_an_excursion_over_several_cells_is_one():
    p = from_roots(0.4, 2.8)
    log = watched(*(p(X + shift) for shift in range(4)))
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (1.0, 0.0)
    assert log[observe.FIRST_VIOLATION] == pytest.approx(10.2, abs=1e-9)
    assert log[observe.EXCESS] == pytest.approx(p(1.6), abs=1e-12)


def test_the_depth_of_an_excursion_that_is_still_growing():
    """It turns within the last cell: first down, then up to its end."""
    p = 0.1 + (X - 0.3) ** 2
    log = watched(X - 0.5, p)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (1.0, 1.0)
    assert log[observe.EXCESS] == pytest.approx(max(p(1.0), 0.5), abs=1e-12)


def test_a_limit_that_is_cleared_by_a_hair():
    log = watched(-((X - 0.5) ** 2) - 1e-12)
    assert (log[observe.NUMBER], log[observe.EXCESS]) == (0.0, 0.0)
    assert np.isnan(log[observe.FIRST_VIOLATION])
    assert watched(-((X - 0.5) ** 2) + 1e-12)[observe.NUMBER] == 1.0
