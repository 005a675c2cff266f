"""The bounds that proofs of flight rest on: they hold, and are no larger than they need to be.

Derivatives are taken from the Taylor coefficients of flights. (Run by `contract/test_plain.py`.)
"""

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from support import kernel_cell

from nlds_vines.kernels.events.exact import may_hold_a_miss, proves_no_touch, touch_in
from nlds_vines.kernels.laws.hertz import HertzWall
from nlds_vines.kernels.motion.flight import (
    COEF,
    OF_E2,
    ORDER,
    PERIOD,
    TAYLOR,
    TERMS,
    Bounds,
    Grid,
    bounds_of,
    cells_of,
    expand,
    grid_from,
    rate_of,
)
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.scene import Parts, allowed, damper_in, scale_of, structure_under
from nlds_vines.kernels.watch import touch as walks
from nlds_vines.kernels.watch.observe import energies
from nlds_vines.kernels.watch.response import damper_bound
from nlds_vines.kernels.watch.touch import LOST, NOWHERE, tightened

PLACES = np.linspace(0.0, 1.0, 201)
USUAL = {"m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0}
FORCED = {**USUAL, "P": 800.0, "omega": 6.28, "K": 3e7}
PUSHED = {"m1": 1000.0, "m2": 60.0, "P": 800.0, "omega": 6.28}  # no spring, no dashpot


# ---- of the polynomial of a cell -----------------------------------------------------------------


def cell_of(p):
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


# ---- what they prove of a cell -------------------------------------------------------------------


NEAR, FAR = HertzWall(0.1, 1e7, 1e5, 1.0), HertzWall(0.05, 1e7, 1e5, 1.0)


@pytest.mark.parametrize(
    ("near", "far", "r0", "r1", "slack", "proven"),
    [
        (NEAR, None, 0.05, 0.07, 0.02, True),
        (NEAR, None, 0.05, 0.07, 0.04, False),
        (NEAR, None, 0.07, 0.05, 0.04, False),
        (NEAR, None, -0.5, -0.5, 0.04, True),
        (None, FAR, -0.02, -0.03, 0.01, True),
        (None, FAR, -0.02, -0.03, 0.03, False),
        (None, FAR, -0.03, -0.02, 0.03, False),
        (None, FAR, 0.5, 0.5, 0.03, True),
        (NEAR, FAR, 0.07, 0.0, 0.02, True),
        (NEAR, FAR, 0.07, 0.0, 0.04, False),
        (NEAR, FAR, 0.0, -0.03, 0.03, False),
        (NEAR, FAR, 0.07, -0.03, 0.01, True),
    ],
)
def test_a_cell_is_clear_where_its_ends_and_the_bend_say_so(near, far, r0, r1, slack, proven):
    """A miss closer than any so far is possible where a touch at a nearer wall would be."""
    assert proves_no_touch(near, far, r0, r1, slack) == proven
    for seen in (0.0, 0.007):
        walls = (w and w._replace(gap=w.gap - seen) for w in (near, far))
        cleared = not proves_no_touch(*walls, r0, r1, slack)
        assert may_hold_a_miss(near, far, np.array([seen]), r0, r1, slack) == cleared


def grid_with(p):
    """Return a grid whose expanded cell holds the polynomial p as r."""
    cell = cell_of(p)
    cell[COEF + 3 : COEF + 3 + 4 * (len(p.coef) - 1) : 4] = p.deriv().coef / 0.1
    return Grid(8, 0.1, 0.125, 1.0, 1.0, 1.0, cell, None)


def end_of(p):
    return 0.0, 0.0, p(1.0), p.deriv()(1.0) / 0.1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_first_of_two_walls_is_touched(sign):
    """r = 2 x (x - 0.6) (x - 1.2) rises beyond the near wall and falls beyond the far one."""
    p = sign * 2.0 * Polynomial.fromroots((0.0, 0.6, 1.2))
    bounds = Bounds(*(np.abs(p.deriv(n)(PLACES)).max() for n in (2, 3, 4)), 0.0, 0.0)
    both = {
        codes.TOUCH_NEAR: (p - NEAR.gap).roots().real,
        codes.TOUCH_FAR: (p + FAR.gap).roots().real,
    }
    firsts = {event: min(x for x in roots if 0.0 < x <= 1.0) for event, roots in both.items()}
    first = min(firsts, key=lambda event: firsts[event])
    assert first == (codes.TOUCH_NEAR if sign > 0.0 else codes.TOUCH_FAR)
    place, event = touch_in(NEAR, FAR, grid_with(p), 1.0, end_of(p), bounds)
    assert event == first
    assert place == pytest.approx(firsts[first], abs=1e-12)
    p = 0.01 * p
    touch = touch_in(NEAR, FAR, grid_with(p), 1.0, end_of(p), bounds)
    assert touch == (NOWHERE, codes.SECTION)


def test_a_touch_that_cannot_be_told_is_not_passed_over(monkeypatch):
    """A walk towards a graze, and steps towards a touch, that are not allowed to arrive."""
    graze, touch = Polynomial([0.0, 0.3996, -0.3996]), Polynomial([0.0, 0.1, 0.1])
    bounds = Bounds(1.0, 1.0, 1e-3, 0.0, 0.0)
    for p, expected in ((graze, (NOWHERE, codes.SECTION)), (touch, (None, codes.TOUCH_NEAR))):
        place, event = touch_in(NEAR, None, grid_with(p), 1.0, end_of(p), bounds)
        assert (place if event == codes.SECTION else None, event) == expected
    monkeypatch.setattr(walks, "LONGEST_WALK", 1)
    for p in (graze, touch):
        place, event = touch_in(NEAR, None, grid_with(p), 1.0, end_of(p), bounds)
        assert (place, event) == (LOST, codes.ASTRAY)


# ---- of the energy -------------------------------------------------------------------------------


def prepared(numbers):
    cell = kernel_cell(**numbers)
    ps, damper = structure_under(None, cell), damper_in(cell)
    return ps, damper, grid_from(ps, damper, cells_of(ps, damper), PERIOD)


def derivatives(ps, damper, h, y, phase):
    """Return the state and its first four derivatives by the place in a cell, (5, 4)."""
    out = np.zeros(TERMS)
    expand(ps, damper, h, np.array([*y, math.cos(phase), math.sin(phase)]), out, 0)
    return out.reshape(ORDER + 1, 4)[:5] * [[1.0], [1.0], [2.0], [6.0], [24.0]]


def derivatives_of(ps, damper, grid, y, phase):
    """Return the sizes of derivatives by the place in a cell.

    The second, third and fourth of r, the fourth of E1, the fourth of E2.
    """
    x1, v1, r, s = derivatives(ps, damper, grid.h, y, phase).T

    def fourth(a):  # derivative of a^2 / 2, by Leibniz' rule
        return a[0] * a[4] + 4 * a[1] * a[3] + 3 * a[2] ** 2

    e1 = ps.m1 * fourth(v1) + ps.k1 * fourth(x1)
    e2 = damper.m2 * fourth(v1 - s) + damper.k2 * fourth(x1 - r)
    return *np.abs(r[2:]), abs(e1), abs(e2)


def test_the_energy_scale_is_that_of_both_bodies():
    ps, damper, _ = prepared(FORCED)
    p, (x1, v1, r, s) = FORCED, (0.01, -0.2, 0.03, 0.4)
    square = p["k1"] * x1**2 + p["m1"] * v1**2 + p["k2"] * r**2 + p["m2"] * (v1 - s) ** 2
    assert scale_of(ps, damper, x1, v1, r, s) == pytest.approx(np.sqrt(square), rel=1e-15)
    assert scale_of(ps, None, x1, v1, 0.0, 0.0) ** 2 == pytest.approx(
        p["k1"] * x1**2 + p["m1"] * v1**2, rel=1e-14
    )


@pytest.mark.parametrize("seed", range(20))
def test_bounds_from_the_energy_hold(seed):
    """Along the energy's directions in turn, for parameters of every proportion."""
    rng = np.random.default_rng(seed)
    numbers = {name: value * 10.0 ** rng.uniform(-2, 2) for name, value in FORCED.items()}
    for name in rng.choice(["c1", "c2", "P", "k2"], 2):
        numbers[name] = 0.0
    ps, damper, grid = prepared(numbers)
    for _ in range(50):
        units = rng.normal(size=4) * rng.integers(0, 2, 4)  # of sqrt(2 E), body by body
        x1, v1, r = units[:3] / np.sqrt([ps.k1, ps.m1, max(damper.k2, 1e-300)])
        r, s = (r if damper.k2 > 0.0 else 0.0), v1 - units[3] / np.sqrt(damper.m2)
        y, phase = (x1, v1, r, s), rng.uniform(0, 2 * np.pi)
        scale = scale_of(ps, damper, *y)
        bounds = Bounds(*(b * (1 + 1e-9) for b in bounds_of(ps, grid, scale)))
        derivatives = derivatives_of(ps, damper, grid, y, phase)
        assert derivatives[0] <= bounds.bend
        assert derivatives[1] <= bounds.jerk
        assert derivatives[2] <= bounds.fourth
        assert derivatives[3] <= bounds.energy
        assert derivatives[4] <= bounds.energy * grid.table[OF_E2]


def test_bounds_of_what_only_the_force_moves_are_reached():
    """From rest without springs and dashpots r'' = P/m1 cos, r''' = -omega P/m1 sin.

    The fourth derivative of E1 is 3 u'' u'' there where u'' is largest; its bound takes each
    derivative of the forcing for largest at once.
    """
    ps, damper, grid = prepared(PUSHED)
    bounds, rest = bounds_of(ps, grid, 0.0), (0.0, 0.0, 0.0, 0.0)
    crest = derivatives_of(ps, damper, grid, rest, 0.0)
    slope = derivatives_of(ps, damper, grid, rest, np.pi / 2)
    assert crest[0] == pytest.approx(bounds.bend, rel=1e-12)
    assert slope[1] == pytest.approx(bounds.jerk, rel=1e-12)
    assert crest[2] == pytest.approx(bounds.fourth, rel=1e-12)
    assert grid.rate == ps.omega  # each derivative of the forcing is that much larger
    push, omega, h = ps.force * math.sqrt(ps.m1), ps.omega, grid.h
    first, second, third = push, 2 * omega * push, 3 * omega**2 * push  # derivatives of u at u = 0
    assert bounds.energy == pytest.approx((4 * first * third + 3 * second**2) * h**4)
    assert slope[3] == pytest.approx(3 * (omega * push) ** 2 * h**4)


@pytest.mark.parametrize("seed", range(40))
def test_the_damper_has_a_bound_of_its_own(seed):
    """Over a cell from random states, the structure at rest or not, for all proportions."""
    rng = np.random.default_rng(seed)
    numbers = {name: value * 10.0 ** rng.uniform(-1.5, 1.5) for name, value in FORCED.items()}
    for name in rng.choice(["c1", "c2", "P"], 2):
        numbers[name] *= 1e-6
    ps, damper, grid = prepared(numbers)
    for _ in range(10):
        units = rng.normal(size=4) * rng.choice([1e-3, 1.0], 4)
        x1, v1, r, v2 = units / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
        y, phase = (x1, v1, r, v1 - v2), rng.uniform(0, 2 * np.pi)
        scale = scale_of(ps, damper, *y) + grid.h * grid.push
        bound = damper_bound(grid, scale, energies(ps, damper, *y)[1]) * (1 + 1e-9)
        out = np.zeros(TERMS)
        expand(ps, damper, grid.h, np.array([*y, math.cos(phase), math.sin(phase)]), out, 0)
        for x in (0.0, 0.3, 0.7, 1.0):
            there = out.reshape(ORDER + 1, 4).T @ x ** np.arange(ORDER + 1)
            angle = phase + x * grid.h * ps.omega
            assert derivatives_of(ps, damper, grid, there, angle)[4] <= bound


def test_the_bound_of_the_damper_is_reached_where_it_is_alone():
    """A damper without dashpot on a structure at rest: u turns with sqrt(k2 / m2), |u| stays."""
    ps, damper, grid = prepared({**FORCED, "c2": 0.0, "P": 0.0, "m1": 1e12})
    e2 = energies(ps, damper, 0.0, 0.0, 0.01, 0.0)[1]
    turn = math.sqrt(damper.k2 / damper.m2) * grid.h
    alone = damper_bound(grid, 0.0, e2)
    assert alone == pytest.approx(8 * 2 * e2 * turn**4)  # 1 + 4 + 3, as Leibniz' rule has it
    # what the structure does to it counts once, with its own rates
    drive, pull = grid.table[OF_E2 + 1], grid.table[OF_E2 + 2]
    assert drive * grid.h == pytest.approx(turn)
    assert pull == pytest.approx(damper.k2 / math.sqrt(ps.k1 * damper.m2))
    ps, damper, grid = prepared({**FORCED, "k2": 0.0, "P": 0.0})
    assert grid.table[OF_E2 + 1] == pytest.approx(damper.c2 / damper.m2)
    assert grid.table[OF_E2 + 2] == pytest.approx(damper.c2 / math.sqrt(ps.m1 * damper.m2))
    drive, pull = grid.table[OF_E2 + 1 : OF_E2 + 3]
    u = [pull * 3.0 * grid.h]  # what the structure gives it in the time of a cell
    for size in 3.0 * grid.rate ** np.arange(4):
        u.append(drive * u[-1] + pull * size)
    bound = damper_bound(grid, 3.0, 0.0)
    expected = u[0] * u[4] + 4 * u[1] * u[3] + 3 * u[2] ** 2
    assert bound == pytest.approx(expected * grid.h**4)


@pytest.mark.parametrize("softer", [1e-2, 1.0, 1e2, 1e4])
def test_the_dampers_energy_is_bounded_by_the_scale(softer):
    """E2 takes the absolute displacement: k2 (x1 - r)^2 of k1 x1^2 + k2 r^2 is 1 + k2 / k1."""
    ps, damper, grid = prepared({**FORCED, "P": 0.0, "k1": FORCED["k2"] / softer})
    x1, r = 1.0 / ps.k1, -1.0 / damper.k2
    square = scale_of(ps, damper, x1, 0.0, r, 0.0) ** 2
    share = 2.0 * energies(ps, damper, x1, 0.0, r, 0.0)[1] / square
    assert share == pytest.approx(1.0 + softer, rel=1e-12)
    assert share <= grid.table[OF_E2] * (1 + 1e-12)
    v2 = 1.0 / math.sqrt(damper.m2)
    assert energies(ps, damper, 0.0, 0.0, 0.0, -v2)[1] <= 0.5 * grid.table[OF_E2]


# ---- of the rates, and what is refused -----------------------------------------------------------


def test_a_cell_is_short_beside_the_rate():
    """0.7 / rate is what the polynomials of order 14 reach; a period has 8 cells at least."""
    for omega in (0.01, 0.1, 1.0, 10.0, 100.0):
        cell = kernel_cell(**{**FORCED, "omega": omega})
        ps, damper = structure_under(None, cell), damper_in(cell)
        n, rate = cells_of(ps, damper), rate_of(ps, damper)
        assert n == max(8, math.ceil(2 * np.pi / omega * rate / 0.7))


@pytest.mark.parametrize("seed", range(10))
def test_the_rate_is_the_largest_row_sum(seed):
    """Of the matrix in the coordinates sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2."""
    rng = np.random.default_rng(seed)
    p = {name: value * 10.0 ** rng.uniform(-2, 2) for name, value in FORCED.items()}
    root1, root2 = np.sqrt(p["m1"]), np.sqrt(p["m2"])
    a, b = np.sqrt([p["k1"], p["k2"]])
    rows = [
        [0, a / root1, 0, 0],
        [a / root1, (p["c1"] + p["c2"]) / p["m1"], b / root1, p["c2"] / (root1 * root2)],
        [0, b / root1, 0, b / root2],
        [0, p["c2"] / (root1 * root2), b / root2, p["c2"] / p["m2"]],
    ]
    cell = kernel_cell(**p)
    expected = max(p["omega"], np.sum(rows, axis=1).max())
    assert rate_of(structure_under(None, cell), damper_in(cell)) == pytest.approx(
        expected, rel=1e-12
    )


def test_more_cells_than_memory_are_refused():
    cell = kernel_cell(**{**FORCED, "omega": 1e-6})
    assert cells_of(structure_under(None, cell), damper_in(cell)) == -1


@pytest.mark.parametrize(
    ("changes", "rk4", "fine"),
    [
        ({}, None, True),
        ({"P": -1.0}, None, False),
        ({"P": -1.0}, True, True),
        ({"near": 0.1, "far": -0.1}, None, True),
        ({"near": 0.1, "far": -0.2}, None, False),
        ({"c2": -1.0}, None, False),
        ({"k2": -1.0}, None, False),
        ({"m2": 0.0}, None, False),
        ({"K": 0.0}, None, False),
        ({"omega": 0.0}, None, False),
        ({"rest": math.inf}, None, False),
        ({"k1": math.nan}, None, False),
    ],
)
def test_numbers_that_are_allowed(changes, rk4, fine):
    cell = kernel_cell(**{**FORCED, "near": 0.1, "far": 0.1, **changes})
    parts = Parts(rk4, True, NEAR, FAR, None, None, None, 0.0, 0.0, 0.0)
    assert bool(allowed(parts, cell)) is fine
