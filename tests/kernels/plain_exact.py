"""What a cell may hold, by its polynomial: touches of two walls, near misses, peaks of energies."""

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, Polynomial
from support import system_of

from nlds_vines.kernels.events.exact import may_hold_a_miss, note_misses, touch_in
from nlds_vines.kernels.laws.hertz import HertzWall
from nlds_vines.kernels.motion.flight import COEF, TAYLOR, Bounds, Grid
from nlds_vines.kernels.scene.codes import SECTION, TOUCH_FAR, TOUCH_NEAR
from nlds_vines.kernels.watch.response import proves_no_root
from nlds_vines.kernels.watch.touch import (
    CLEAR,
    CROSSED,
    UNSURE,
    crossing,
    nearest_miss,
    outlook,
    touch_of,
)
from nlds_vines.orbits.simulation import simulate

NEAR, FAR = HertzWall(0.4, 1e7, 1e5, 300.0), HertzWall(0.3, 1e7, 1e5, 300.0)
X = Polynomial([0.0, 1.0])


H = 0.1  # length of a cell [s]


def cell_of(p):
    """Return a grid with the polynomial r(x) in its table, and the `Bounds` of r."""
    table, speeds = np.zeros(TAYLOR), p.deriv().coef / H
    table[COEF + 2 : COEF + 2 + 4 * len(p.coef) : 4] = p.coef
    table[COEF + 3 : COEF + 3 + 4 * len(speeds) : 4] = speeds
    places = np.linspace(0.0, 1.0, 2001)
    bounds = (1.001 * max(np.abs(p.deriv(n)(places)).max(), 1e-9) for n in (2, 3, 4))
    return Grid(8, H, 0.125, 1.0, 1.0, 1.0, table, None), Bounds(*bounds, 0.0, 0.0)


def state(p, x):
    return 0.0, 0.0, float(p(x)), float(p.deriv()(x)) / H


# ---- touches -------------------------------------------------------------------------------------


def first(p, near=NEAR, far=FAR, end=1.0):
    grid, bounds = cell_of(p)
    place, event = touch_in(near, far, grid, end, state(p, end), bounds)
    return (round(place, 9), event) if event != SECTION else None


TO_NEAR_THEN_FAR = 0.1 + 2.0 * X - 3.0 * X**2
TO_FAR_THEN_NEAR = -2.0 * X + 3.0 * X**2


@pytest.mark.kernels
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


def outlooks(p, level, end=1.0):
    """Return the verdict of the ends of [0, end] on a level, and where p first rises to it."""
    _, bounds = cell_of(p)
    (f0, g0), (f1, g1) = ((float(p(x)), end * float(p.deriv()(x))) for x in (0.0, end))
    verdict = outlook(level, f0, f1, g0, g1, bounds.fourth * end**4)
    roots = (p - level).roots()
    slopes = p.deriv()
    up = [x.real for x in roots if abs(x.imag) < 1e-9 and 0.0 < x.real < end and slopes(x.real) > 0]
    return verdict, min(up, default=None)


@pytest.mark.kernels
def test_what_the_ends_of_a_piece_tell_is_so():
    """Of many polynomials and levels. Notices: a proof that does not hold; none ever found."""
    seen = {CLEAR: 0, CROSSED: 0, UNSURE: 0}
    for seed in range(3000):
        rng = np.random.default_rng(seed)
        p = Polynomial(rng.normal(size=9) / rng.choice([1.5, 3.0, 6.0]) ** np.arange(9))
        level = p(0.0) + abs(rng.normal()) * rng.choice([1e-6, 0.1, 1.0])
        verdict, place = outlooks(p, level, rng.choice([1.0, 0.4]))
        seen[verdict] += 1
        if verdict == CLEAR:
            assert place is None
        if verdict == CROSSED:
            assert place is not None
    assert min(seen.values()) > 200


def test_a_release_that_moves_away_is_clear_and_one_that_comes_back_is_not():
    """From the level itself, downwards. Notices: a start on the level taken for a touch."""
    assert outlooks(0.4 - X + 0.3 * X**2, 0.4)[0] == CLEAR
    assert outlooks(0.4 - X + 0.9 * X**2, 0.4)[0] != CROSSED
    assert outlooks(0.4 - X + 1.1 * X**2, 0.4)[0] == UNSURE
    assert outlooks(0.4 + X, 0.4)[0] == UNSURE  # it moves in: the walk knows


@pytest.mark.kernels
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_certain_touch_is_found_to_round_off(sign):
    """Polynomials that rise all along, some hardly at one end. Notices: the last step too early."""
    certain = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        p = 0.3 + Polynomial(rng.normal(size=10) / 4.0 ** np.arange(10)) + X * rng.uniform(0, 2)
        level = p(rng.uniform(0.0, 1.0))
        verdict, place = outlooks(p, level)
        if verdict != CROSSED:
            continue
        certain += 1
        grid, bounds = cell_of(sign * p)
        touch = touch_of(grid, 1.0, sign, float(level), state(sign * p, 1.0), bounds)
        assert touch == pytest.approx(
            place, abs=1e-14 + 4e-16 * (1 + abs(level)) / p.deriv()(place)
        )
    assert certain > 100


def test_a_touch_within_round_off_of_the_start_is_at_the_start():
    for ahead in (0.0, 1e-17, 5e-17):
        p = 0.4 - ahead + X
        grid, bounds = cell_of(p)
        assert touch_of(grid, 1.0, 1.0, 0.4, state(p, 1.0), bounds) == 0.0
    p = 0.4 - 1e-12 + X
    grid, bounds = cell_of(p)
    assert touch_of(grid, 1.0, 1.0, 0.4, state(p, 1.0), bounds) == pytest.approx(1e-12, rel=1e-3)


@pytest.mark.kernels
def test_steps_towards_a_touch_stay_in_the_piece():
    """A rise that is steep at one end and nearly level at the other throws Newton's steps far."""
    swell = 1e-3 * X + 3 * X**2 - 2 * X**3  # falls before and behind the piece
    for p in ((X + 0.02) ** 2, -((1.02 - X) ** 2), (X + 0.2) ** 6, 1e-3 * X + X**9, swell):
        for place in (1e-9, 0.01, 0.2, 0.5, 0.8, 0.99, 1.0 - 1e-12):
            grid, bounds = cell_of(p)
            crossed = crossing(
                grid, 1.0, 1.0, float(p(place)),
                (float(p(1.0)), float(p.deriv()(0.0)), float(p.deriv()(1.0))), bounds.bend,
            )  # fmt: skip
            slope = p.deriv()(place)
            assert crossed == pytest.approx(place, abs=2e-15 * (1 + abs(p(place))) / slope)


# ---- near misses ---------------------------------------------------------------------------------


def noted(p, near, far, clearance=np.inf):
    grid, bounds = cell_of(p)
    clearances = np.array([clearance])
    note_misses(near, far, clearances, grid, 1.0, bounds, False)
    return clearances[0]


HUMP = 0.2 - (X - 0.4) ** 2  # turns at r = 0.2
HOLLOW = -0.2 + (X - 0.4) ** 2  # turns at r = -0.2


@pytest.mark.kernels
def test_a_near_miss_of_either_wall():
    """Notices: the far wall's miss with the wrong sign, or never looked for."""
    assert noted(HUMP, NEAR, FAR) == pytest.approx(0.2, abs=1e-12)
    assert noted(HOLLOW, NEAR, FAR) == pytest.approx(0.1, abs=1e-12)
    assert noted(HOLLOW, None, FAR) == pytest.approx(0.1, abs=1e-12)
    assert noted(HUMP, NEAR, None) == pytest.approx(0.2, abs=1e-12)
    assert noted(HUMP, None, FAR) == np.inf
    assert noted(HOLLOW, NEAR, None) == np.inf
    assert noted(HOLLOW, NEAR, FAR, 0.05) == 0.05


@pytest.mark.kernels
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
        bend, jerk = bounds.bend, bounds.jerk
        best = nearest_miss(grid.table, 0.0, sign, 1.0, -np.inf, bend, jerk, False)
        assert best == pytest.approx(max(tops), rel=1e-7)


# ---- peaks ---------------------------------------------------------------------------------------


@pytest.mark.kernels
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


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_a_wall_is_missed_on_the_way_to_the_other(method):
    """In one cell the damper leaves a wall, turns before the other and is back."""
    numbers = {
        "m1": 11996.447665643467, "m2": 80.05394989386546, "k1": 5216905.250616235,
        "k2": 325.00987620872576, "c1": 284.92241503039844, "c2": 0.20011757306559308,
        "P": 32199.262614876625, "omega": 24.851225440642498, "K": 119310.22819402875,
        "C": -0.0013474864143378591, "D": 0.0031806510063548442, "L": 0.038997190807040095,
        "V": 0.015122426559822278,
    }  # fmt: skip
    start = [-0.00731849, 0.06152789, 0.00308797, 0.12920101]
    orbit = simulate(
        system_of("ssbl", numbers), 8, start=start, record=["clearance"], method=method
    )
    assert orbit.clearance == pytest.approx(0.0011299, rel=1e-4)
