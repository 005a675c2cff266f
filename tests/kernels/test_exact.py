"""What a cell may hold, by its polynomial: touches of two walls, near misses, peaks of energies."""

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, Polynomial

from nlds_vines.kernels.codes import SECTION, TOUCH_FAR, TOUCH_NEAR
from nlds_vines.kernels.exact import Bounds, may_hold_a_miss, note_misses, touch_in
from nlds_vines.kernels.flight import COEF, TAYLOR, Grid
from nlds_vines.kernels.peaks import proves_no_root
from nlds_vines.kernels.scene import Wall
from nlds_vines.kernels.touch import nearest_miss

NEAR, FAR = Wall(0.4, 1e7, 1e5, 300.0), Wall(0.3, 1e7, 1e5, 300.0)
X = Polynomial([0.0, 1.0])


H = 0.1  # length of a cell [s]


def cell_of(p):
    """Return a grid with the polynomial r(x) in its table, and the `Bounds` of r."""
    table, speeds = np.zeros(TAYLOR), p.deriv().coef / H
    table[COEF + 2 : COEF + 2 + 4 * len(p.coef) : 4] = p.coef
    table[COEF + 3 : COEF + 3 + 4 * len(speeds) : 4] = speeds
    places = np.linspace(0.0, 1.0, 2001)
    bounds = (1.001 * max(np.abs(p.deriv(n)(places)).max(), 1e-9) for n in (2, 3, 4))
    return Grid(8, H, 0.125, 1.0, 1.0, 1.0, table), Bounds(*bounds, 0.0, 0.0)


def state(p, x):
    """Return the state (x1, v1, r, s) at place x."""
    return 0.0, 0.0, float(p(x)), float(p.deriv()(x)) / H


# ---- touches -------------------------------------------------------------------------------------


def first(p, near=NEAR, far=FAR, end=1.0):
    grid, bounds = cell_of(p)
    place, event = touch_in(near, far, grid, end, state(p, end), bounds)
    return (round(place, 9), event) if event != SECTION else None


TO_NEAR_THEN_FAR = 0.1 + 2.0 * X - 3.0 * X**2
TO_FAR_THEN_NEAR = -2.0 * X + 3.0 * X**2


def test_the_first_of_two_walls_in_one_cell():
    """Notices: the later of the two taken first, either wall not looked for, a sign."""
    up = TO_NEAR_THEN_FAR
    places = [float(x.real) for x in (up - 0.4).roots()]
    assert first(up) == (round(min(places), 9), TOUCH_NEAR)
    (far,) = [x.real for x in (up + 0.3).roots() if 0 < x.real < 1]
    assert first(up, near=None) == (round(far, 9), TOUCH_FAR)
    assert first(up, end=0.2) is None
    down = TO_FAR_THEN_NEAR
    far = min(x.real for x in (down + 0.3).roots() if 0 < x.real < 1)
    (near,) = [x.real for x in (down - 0.4).roots() if 0 < x.real < 1]
    assert far < near
    assert first(down) == (round(far, 9), TOUCH_FAR)
    assert first(down, far=None) == (round(near, 9), TOUCH_NEAR)


# ---- near misses ---------------------------------------------------------------------------------


def noted(p, near, far, clearance=np.inf):
    grid, bounds = cell_of(p)
    found = np.array([clearance])
    note_misses(near, far, found, grid, 1.0, bounds)
    return found[0]


HUMP = 0.2 - (X - 0.4) ** 2  # turns at r = 0.2
HOLLOW = -0.2 + (X - 0.4) ** 2  # turns at r = -0.2


def test_a_near_miss_of_either_wall():
    """Notices: the far wall's miss with the wrong sign, or never looked for."""
    assert noted(HUMP, NEAR, FAR) == pytest.approx(0.2, abs=1e-12)
    assert noted(HOLLOW, NEAR, FAR) == pytest.approx(0.1, abs=1e-12)
    assert noted(HOLLOW, None, FAR) == pytest.approx(0.1, abs=1e-12)
    assert noted(HUMP, NEAR, None) == pytest.approx(0.2, abs=1e-12)
    assert noted(HUMP, None, FAR) == np.inf
    assert noted(HOLLOW, NEAR, None) == np.inf
    assert noted(HOLLOW, NEAR, FAR, 0.05) == 0.05


@pytest.mark.parametrize(
    ("r0", "r1", "slack", "near", "far"),
    [
        (0.0, 0.19, 0.02, True, False),
        (0.19, 0.0, 0.02, True, False),
        (0.0, 0.19, 0.005, False, False),
        (0.0, -0.09, 0.02, False, True),
        (-0.09, 0.0, 0.02, False, True),
        (0.0, -0.09, 0.005, False, False),
    ],
)
def test_which_cells_may_hold_a_closer_miss(r0, r1, slack, near, far):
    """By their ends and how far r may go beyond them; the closest so far was 0.2."""
    clearance = np.array([0.2])
    assert may_hold_a_miss(NEAR, None, clearance, r0, r1, slack) == near
    assert may_hold_a_miss(None, FAR, clearance, r0, r1, slack) == far
    assert may_hold_a_miss(NEAR, FAR, clearance, r0, r1, slack) == (near or far)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("degree", [5, 9, 12])
def test_the_closest_of_many_misses(degree, sign):
    """Some are as narrow as the bounds allow. Notices: longer steps than are safe."""
    rng = np.random.default_rng(degree)
    waves = Chebyshev.basis(degree).convert(kind=Polynomial)(2 * X - 1)
    for _ in range(60):
        p = waves * (1.0 + rng.uniform(-0.8, 2.0) * X)
        turns = p.deriv().roots()
        turns = turns[np.abs(turns.imag) < 1e-12].real
        tops = [p(x) for x in turns if 0 < x < 1 and p.deriv(2)(x) < 0]
        grid, bounds = cell_of(sign * p)
        best = nearest_miss(grid.table, 0.0, sign, 1.0, -np.inf, bounds.bend, bounds.jerk)
        assert best == pytest.approx(max(tops), rel=1e-7)


# ---- peaks ---------------------------------------------------------------------------------------


def test_no_root_is_proven_only_where_there_is_none():
    """Quadratics, whose second derivative is the bound. Notices: a bound used ten times too small.

    Each has a root for a depth below its lowest point, and none above it.
    """
    bend = 1.0
    for change in np.linspace(0.0, 0.99, 34):  # f(1) - f(0)
        steep = 0.5 * bend - change
        lowest = steep**2 / (2 * bend) if steep > 0 else 0.0  # f(0) minus the lowest value
        for sign in (1.0, -1.0):
            f0 = 0.999 * lowest
            if f0 > 0.0:
                assert not proves_no_root(sign * f0, sign * (f0 + change), bend)
                assert not proves_no_root(sign * (f0 + change), sign * f0, bend)
    assert proves_no_root(0.1251, 0.1251, bend)
    assert proves_no_root(1e-9, 1.0 + 1e-6, bend)
    assert not proves_no_root(0.2, -0.2, bend)
    assert not proves_no_root(0.0, 2.0, bend)
