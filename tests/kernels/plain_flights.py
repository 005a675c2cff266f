"""The bounds of rates and derivatives that proofs of flight rest on: they hold, and are reached."""

import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from support import NOTHING, contact_parts, expanded, flight_parts, grid_with, kernel_cell

from nlds_vines.kernels.events.exact import fly, may_hold_a_miss, proves_no_touch, touch_in
from nlds_vines.kernels.laws.hertz import HertzWall, hertz_wall_at
from nlds_vines.kernels.motion import flight as flights
from nlds_vines.kernels.numerics.roots import SLOPE_ERROR, VALUE_ERROR, highest, only_rises
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.scene import Flight, Parts, accelerations, allowed, scale_of
from nlds_vines.kernels.watch import observe
from nlds_vines.kernels.watch import touch as walks
from nlds_vines.kernels.watch.observe import energies
from nlds_vines.kernels.watch.response import damper_bound
from nlds_vines.kernels.watch.touch import NOWHERE, first_touch, nearest_miss, note_limit, tightened

PLACES = np.linspace(0.0, 1.0, 201)
X = Polynomial([0.0, 1.0])
FORCED = {
    "m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0, "P": 800.0,
    "omega": 6.28, "K": 3e7,
}  # fmt: skip


@pytest.mark.parametrize("k", range(2, 15))
def test_bounds_from_the_polynomial_hold(k):
    """Those of a power are reached at the end; those from the energy stay where they are less."""
    second, third = tightened(grid_with(X**k).table, np.inf, np.inf)
    assert (second, third) == (k * (k - 1.0), k * (k - 1.0) * (k - 2.0))
    assert tightened(grid_with(X**k).table, 0.5, 0.25) == (0.5, min(0.25, third))
    mixed = Polynomial(np.random.default_rng(k).normal(size=k + 1))
    second, third = tightened(grid_with(mixed).table, np.inf, np.inf)
    assert np.abs(mixed.deriv(2)(PLACES)).max() <= second * (1 + 1e-12)
    if k > 2:
        assert np.abs(mixed.deriv(3)(PLACES)).max() <= third * (1 + 1e-12)


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


def end_of(p, x=1.0):
    return 0.0, 0.0, p(x), p.deriv()(x) / 0.1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_first_of_two_walls_is_touched(sign):
    """r = 2 x (x - 0.6) (x - 1.2) rises beyond the near wall and falls beyond the far one."""
    p = sign * 2.0 * Polynomial.fromroots((0.0, 0.6, 1.2))
    bounds = flights.Bounds(*(np.abs(p.deriv(n)(PLACES)).max() for n in (2, 3, 4)), 0.0, 0.0)
    both = {
        codes.TOUCH_NEAR: (p - NEAR.gap).roots().real,
        codes.TOUCH_FAR: (p + FAR.gap).roots().real,
    }
    firsts = {event: min(x for x in roots if 0.0 < x <= 1.0) for event, roots in both.items()}
    first = codes.TOUCH_NEAR if sign > 0.0 else codes.TOUCH_FAR
    assert first == min(firsts, key=lambda event: firsts[event])
    for near, far, event in (
        (NEAR, FAR, first), (NEAR, None, codes.TOUCH_NEAR), (None, FAR, codes.TOUCH_FAR)
    ):  # fmt: skip
        place, touched = touch_in(near, far, grid_with(p), 1.0, end_of(p), bounds)
        assert touched == event
        assert place == pytest.approx(firsts[event], abs=1e-12)
    for motion, end in ((p, 0.9 * firsts[first]), (0.01 * p, 1.0)):
        touch = touch_in(NEAR, FAR, grid_with(motion), end, end_of(motion, end), bounds)
        assert touch == (NOWHERE, codes.SECTION)


def test_a_touch_that_cannot_be_told_is_not_passed_over(monkeypatch):
    """A walk towards a graze, and steps towards a touch, that are not allowed to arrive."""
    graze, touch = Polynomial([0.0, 0.3996, -0.3996]), Polynomial([0.0, 0.1, 0.1])
    bounds = flights.Bounds(1.0, 1.0, 1e-3, 0.0, 0.0)
    for p, expected in ((graze, (NOWHERE, codes.SECTION)), (touch, (None, codes.TOUCH_NEAR))):
        place, event = touch_in(NEAR, None, grid_with(p), 1.0, end_of(p), bounds)
        assert (place if event == codes.SECTION else None, event) == expected
    monkeypatch.setattr(walks, "LONGEST_WALK", 1)
    for p in (graze, touch):
        place, event = touch_in(NEAR, None, grid_with(p), 1.0, end_of(p), bounds)
        assert (place, event) == (walks.LOST, codes.ASTRAY)


def parts_of(**changes):
    return contact_parts(**{**FORCED, **changes})[:2]


def prepared(**changes):
    """Return structure, damper and the grid of a period."""
    return flight_parts(**{**FORCED, **changes})


def derivatives_of(*cell):
    """Return the second, third and fourth derivative of r, and the fourth of E1 and of E2."""
    ps, damper, *_ = cell
    x1, v1, r, s = expanded(*cell)[:, :5] * [1.0, 1.0, 2.0, 6.0, 24.0]

    def fourth(a):  # derivative of a^2 / 2, by Leibniz' rule
        return a[0] * a[4] + 4 * a[1] * a[3] + 3 * a[2] ** 2

    e1 = ps.m1 * fourth(v1) + ps.k1 * fourth(x1)
    e2 = damper.m2 * fourth(v1 - s) + damper.k2 * fourth(x1 - r)
    return *np.abs(r[2:]), abs(e1), abs(e2)


def test_the_energy_scale_is_that_of_both_bodies():
    ps, damper, _ = prepared()
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
    ps, damper, grid = prepared(**numbers)
    for _ in range(50):
        units = rng.normal(size=4) * rng.integers(0, 2, 4)  # of sqrt(2 E), body by body
        x1, v1, r = units[:3] / np.sqrt([ps.k1, ps.m1, max(damper.k2, 1e-300)])
        r, s = (r if damper.k2 > 0.0 else 0.0), v1 - units[3] / np.sqrt(damper.m2)
        y, phase = (x1, v1, r, s), rng.uniform(0, 2 * np.pi)
        scale = scale_of(ps, damper, *y)
        bounds = flights.Bounds(*(b * (1 + 1e-9) for b in flights.bounds_of(ps, grid, scale)))
        derivatives = derivatives_of(ps, damper, grid, y, phase)
        assert derivatives[0] <= bounds.bend
        assert derivatives[1] <= bounds.jerk
        assert derivatives[2] <= bounds.fourth
        assert derivatives[3] <= bounds.energy
        assert derivatives[4] <= bounds.energy * grid.table[flights.OF_E2]


def test_bounds_of_what_only_the_force_moves_are_reached():
    """From rest without springs and dashpots r'' = P/m1 cos, r''' = -omega P/m1 sin.

    The fourth derivative of E1 is 3 u'' u'' there where u'' is largest; its bound takes each
    derivative of the forcing for largest at once.
    """
    ps, damper, grid = prepared(k1=0.0, c1=0.0, k2=0.0, c2=0.0)
    bounds, rest = flights.bounds_of(ps, grid, 0.0), (0.0, 0.0, 0.0, 0.0)
    crest = derivatives_of(ps, damper, grid, rest, 0.0)
    slope = derivatives_of(ps, damper, grid, rest, np.pi / 2)
    assert crest[0] == pytest.approx(bounds.bend, rel=1e-12)
    assert slope[1] == pytest.approx(bounds.jerk, rel=1e-12)
    assert crest[2] == pytest.approx(bounds.fourth, rel=1e-12)
    assert grid.rate == ps.omega  # each derivative of the forcing is that much larger
    push = ps.force * math.sqrt(ps.m1)
    assert slope[3] == pytest.approx(3 * (ps.omega * push) ** 2 * grid.h**4)


@pytest.mark.parametrize("seed", range(40))
def test_the_damper_has_a_bound_of_its_own(seed):
    """Over a cell from random states, the structure at rest or not, for all proportions."""
    rng = np.random.default_rng(seed)
    numbers = {name: value * 10.0 ** rng.uniform(-1.5, 1.5) for name, value in FORCED.items()}
    for name in rng.choice(["c1", "c2", "P"], 2):
        numbers[name] *= 1e-6
    ps, damper, grid = prepared(**numbers)
    for _ in range(10):
        units = rng.normal(size=4) * rng.choice([1e-3, 1.0], 4)
        x1, v1, r, v2 = units / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
        y, phase = (x1, v1, r, v1 - v2), rng.uniform(0, 2 * np.pi)
        scale = scale_of(ps, damper, *y) + grid.h * grid.push
        bound = damper_bound(grid, scale, energies(ps, damper, *y)[1]) * (1 + 1e-9)
        terms = expanded(ps, damper, grid, y, phase)
        for x in (0.0, 0.3, 0.7, 1.0):
            there = terms @ x ** np.arange(flights.ORDER + 1)
            angle = phase + x * grid.h * ps.omega
            assert derivatives_of(ps, damper, grid, there, angle)[4] <= bound


def test_the_bound_of_the_damper_is_reached_where_it_is_alone():
    """A damper without dashpot on a structure at rest: u turns with sqrt(k2 / m2), |u| stays."""
    ps, damper, grid = prepared(c2=0.0, P=0.0, m1=1e12)
    e2 = energies(ps, damper, 0.0, 0.0, 0.01, 0.0)[1]
    turn = math.sqrt(damper.k2 / damper.m2) * grid.h
    alone = damper_bound(grid, 0.0, e2)
    assert alone == pytest.approx(8 * 2 * e2 * turn**4)  # 1 + 4 + 3, as Leibniz' rule has it
    # what the structure does to it counts once, with its own rates
    drive, pull = grid.table[flights.OF_E2 + 1], grid.table[flights.OF_E2 + 2]
    assert drive * grid.h == pytest.approx(turn)
    assert pull == pytest.approx(damper.k2 / math.sqrt(ps.k1 * damper.m2))
    ps, damper, grid = prepared(k2=0.0, P=0.0)
    assert grid.table[flights.OF_E2 + 1] == pytest.approx(damper.c2 / damper.m2)
    assert grid.table[flights.OF_E2 + 2] == pytest.approx(damper.c2 / math.sqrt(ps.m1 * damper.m2))
    drive, pull = grid.table[flights.OF_E2 + 1 : flights.OF_E2 + 3]
    u = [pull * 3.0 * grid.h]  # what the structure gives it in the time of a cell
    for size in 3.0 * grid.rate ** np.arange(4):
        u.append(drive * u[-1] + pull * size)
    bound = damper_bound(grid, 3.0, 0.0)
    expected = u[0] * u[4] + 4 * u[1] * u[3] + 3 * u[2] ** 2
    assert bound == pytest.approx(expected * grid.h**4)


@pytest.mark.parametrize("softer", [1e-2, 1.0, 1e2, 1e4])
def test_the_dampers_energy_is_bounded_by_the_scale(softer):
    """E2 takes the absolute displacement: k2 (x1 - r)^2 of k1 x1^2 + k2 r^2 is 1 + k2 / k1."""
    ps, damper, grid = prepared(P=0.0, k1=FORCED["k2"] / softer)
    x1, r = 1.0 / ps.k1, -1.0 / damper.k2
    square = scale_of(ps, damper, x1, 0.0, r, 0.0) ** 2
    share = 2.0 * energies(ps, damper, x1, 0.0, r, 0.0)[1] / square
    assert share == pytest.approx(1.0 + softer, rel=1e-12)
    assert share <= grid.table[flights.OF_E2] * (1 + 1e-12)
    v2 = 1.0 / math.sqrt(damper.m2)
    assert energies(ps, damper, 0.0, 0.0, 0.0, -v2)[1] <= 0.5 * grid.table[flights.OF_E2]


def test_cells_are_short_beside_the_rate_and_no_more_than_memory_holds():
    """0.7 / rate is what the polynomials of order 14 reach; a period has 8 cells at least."""
    for omega in (0.01, 0.1, 1.0, 10.0, 100.0):
        ps, damper = parts_of(omega=omega)
        n, rate = flights.cells_of(ps, damper), flights.rate_of(ps, damper)
        assert n == max(8, math.ceil(2 * np.pi / omega * rate / 0.7))
    assert flights.cells_of(*parts_of(omega=1e-6)) == -1


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
    parts = Parts(rk4, True, NEAR, FAR, None, None, None, None, 0.0, 0.0, 0.0)
    assert bool(allowed(parts, cell)) is fine


@pytest.mark.parametrize(("P", "fine"), [(-1.0, True), (-math.inf, False)])
def test_the_force_of_a_moving_ground_may_be_negative(P, fine):
    cell = kernel_cell(**{**FORCED, "near": 0.1, "far": 0.1, "P": P})
    parts = Parts(None, True, NEAR, FAR, None, None, True, None, 0.0, 0.0, 0.0)
    assert bool(allowed(parts, cell)) is fine


def unit_states(ps, damper):
    """Return the four states (x1, v1, r, s) of energy scale 1 with one of x1, v1, r, v2 alone."""
    x1, v1 = 1 / math.sqrt(ps.k1), 1 / math.sqrt(ps.m1)
    r, v2 = 1 / math.sqrt(damper.k2), 1 / math.sqrt(damper.m2)
    return [(x1, 0.0, 0.0, 0.0), (0.0, v1, 0.0, v1), (0.0, 0.0, r, 0.0), (0.0, 0.0, 0.0, -v2)]


@pytest.mark.parametrize(
    ("largest", "changes"),
    [
        (1, {}),
        (1, {"c1": 4e4, "k2": 4e4}),
        (2, {"m2": 1000.0, "k1": 1.0, "k2": 4e4, "c1": 0.0, "c2": 0.0}),
        (3, {"k1": 10.0, "c1": 0.0, "c2": 500.0}),
        (3, {"k1": 10.0, "c1": 0.0, "c2": 5e3, "k2": 4e4}),
        (None, {"omega": 50.0}),
    ],
)
def test_the_rate_is_the_largest_row_sum_or_the_forcing(largest, changes):
    """Notices: one pull of a spring left out, the forcing left out."""
    ps, damper = parts_of(**changes)
    roots, columns = [math.sqrt(k) for k in (ps.k1, ps.m1, damper.k2, damper.m2)], []
    for x1, v1, r, s in unit_states(ps, damper):
        a1, ds = accelerations(ps, damper, x1, v1, r, s, 0.0, 0.0)
        columns.append(np.multiply(roots, (v1, a1, s, a1 - ds)))
    sums = np.abs(columns).sum(axis=0)
    if largest is None:
        assert ps.omega > sums.max()
    else:
        assert sums[largest] >= 0.999999 * sums.max()
    assert flights.rate_of(ps, damper) == pytest.approx(max(sums.max(), ps.omega), rel=1e-14)


@pytest.mark.parametrize("changes", [{}, {"c1": 0.0}, {"c2": 4e3}, {"m2": 1.0, "k2": 1e4}])
def test_the_bend_is_the_largest_second_derivative_at_energy_scale_one(changes):
    """Notices: any of its terms left out, the last one (of v2) among them."""
    ps, damper = parts_of(**changes)
    second = [accelerations(ps, damper, *y, 0.0, 0.0)[1] for y in unit_states(ps, damper)]
    assert flights.bend_of(ps, damper) == pytest.approx(np.linalg.norm(second), rel=1e-14)


@pytest.mark.parametrize(
    "changes",
    [{}, {"c1": 0.0, "c2": 0.0}, {"c1": 2e4, "omega": 40.0}, {"c2": 2e3, "omega": 20.0},
     {"k1": 1e6, "omega": 3.0}],
)  # fmt: skip
@pytest.mark.parametrize("phase", [0.0, 0.7, 1.5707963, 2.6])
def test_bounds_from_rest_hold_over_four_cells(changes, phase):
    """From rest the forcing alone bends the motion. Notices: its push, or its part, left out."""
    ps, damper = parts_of(**changes)
    grid = flights.grid_from(ps, damper, 64, flights.PERIOD)
    largest, y = np.zeros(3), (0.0,) * 4
    for j in range(4):
        angle = phase + j * grid.h * ps.omega
        flights.cell_polynomial(grid, *y, math.cos(angle), math.sin(angle))
        series = Polynomial(grid.table[42:102:4])
        largest = np.maximum(largest, [np.abs(series.deriv(n)(PLACES)).max() for n in (2, 3, 4)])
        y = flights.at(grid.table, 1.0)
        bounds = flights.bounds_of(ps, grid, grid.push * grid.h * (j + 1))
        assert (largest <= np.array(bounds[:3]) * (1 + 1e-12)).all()


@pytest.mark.parametrize("scale", [0.0, 3.0])
def test_each_part_of_the_bounds_is_needed(scale):
    """From rest, those of the forcing are reached: with less of it they would not hold."""
    ps, damper = parts_of(c1=0.0, c2=0.0)
    grid = flights.grid_from(ps, damper, 64, flights.PERIOD)
    bend, jerk, fourth, energy, _ = flights.bounds_of(ps, grid, scale)
    first = scale * grid.rate + grid.push
    second = grid.rate * (first + grid.push)
    third = grid.rate * (second + grid.rate * grid.push)
    last = grid.rate * (third + grid.rate**2 * grid.push)
    h2 = grid.h * grid.h
    assert bend == pytest.approx((scale * grid.bend + ps.force) * h2, rel=1e-14)
    assert jerk == pytest.approx((grid.bend * first + ps.omega * ps.force) * h2 * grid.h)
    assert fourth == pytest.approx((grid.bend * second + ps.omega**2 * ps.force) * h2 * h2)
    leibniz = scale * last + 4.0 * first * third + 3.0 * second**2
    assert energy == pytest.approx(leibniz * h2 * h2)


@pytest.mark.parametrize(("clearance", "event"), [(1e-9, codes.SECTION), (-1e-9, codes.TOUCH_NEAR)])
def test_a_touch_that_the_forcing_brings_about_after_some_cells(clearance, event):
    """A free damper on a structure in resonance: r = P t sin(omega t) / (2 m1 omega) from rest.

    It turns in the fourth cell, and bends there more than the force alone could bend it.
    """
    omega = 6.28
    changes = {"k1": 1000.0 * omega**2, "c1": 0.0, "k2": 0.0, "c2": 0.0, "omega": omega}
    ps, damper = parts_of(**changes)
    grid = flights.grid_from(ps, damper, 11, flights.PERIOD)
    top = 2.028757838110434  # tan x = -x
    highest = ps.force / (2 * omega**2) * top * math.sin(top)
    wall = hertz_wall_at(highest * (1 + clearance), damper.inv_mu, kernel_cell(K=1e7))
    flight = Flight(None, ps, damper, wall, None, grid)
    flown = fly(flight, NOTHING, (0, 0.0), 5, (0.0, 0.0, 0.0, 0.0))
    assert flown[0] == event
    if event == codes.TOUCH_NEAR:
        assert (flown[1] + flown[2]) * grid.h * omega == pytest.approx(top, abs=1e-4)


@pytest.mark.parametrize("n", [9, 10, 64])
def test_the_phase_inside_a_cell(n):
    """Turned on from that at the start of the cell, by up to 0.7. Notices: a term left out."""
    ps, damper = parts_of()
    grid = flights.grid_from(ps, damper, n, flights.PERIOD)
    for j in range(n):
        for x in np.linspace(0.0, 1.0, 23):
            with mpmath.workdps(30):
                angle = 2 * mpmath.pi * (j + mpmath.mpf(x)) / n
                exact = float(mpmath.cos(angle)), float(mpmath.sin(angle))
            assert np.abs(np.subtract(flights.phase_at(grid, j, x), exact)).max() <= 5e-16


def test_the_polynomial_is_summed_to_round_off():
    """At places of a cell, against its terms in longer arithmetic. Notices: a pair forgotten."""
    ps, damper = parts_of()
    grid = flights.grid_from(ps, damper, 10, flights.PERIOD)
    rng = np.random.default_rng(1)
    for _ in range(50):
        y = rng.normal(size=4)
        flights.cell_polynomial(grid, *y, *rng.normal(size=2))
        rows = grid.table[40:100].reshape(15, 4)
        x = rng.uniform()
        exact = [math.fsum(row * x**k for k, row in enumerate(rows[:, c])) for c in range(4)]
        sizes = np.abs(rows).T @ x ** np.arange(15)
        assert (np.abs(np.subtract(flights.at(grid.table, x), exact)) <= 6e-16 * sizes).all()


# ---- polynomials whose roots and turns are known -------------------------------------------------

LEVEL = 0.06


def cell_with(p):
    """Return the cell of a polynomial r(x), and bounds of its second and third derivative."""
    bounds = (max(np.abs(p.deriv(n).coef).sum(), 1e-9) for n in (2, 3))
    return grid_with(p).table, *bounds


def touch(excess, x=0.0, end=1.0, sign=1.0):
    """Return the first touch of sign r = LEVEL + excess(x)."""
    cell, bend, jerk = cell_with(sign * (Polynomial([LEVEL]) + excess))
    return first_touch(cell, x, end, sign, LEVEL, bend, jerk)


def from_roots(*roots):
    """Return the excess with these roots, negative before the first of them."""
    p = Polynomial.fromroots(roots)
    return p if p(min(roots) - 1) < 0 else -p


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


TOUCHES = {  # an excess, and where it is first zero, to how much
    "that is cleared by a hair": (-((X - 0.5) ** 2) - 1e-12, NOWHERE),
    "by a hair": (-((X - 0.5) ** 2) + 1e-12, 0.5 - 1e-6, 1e-8),
    "within the end of the cell": (X - 1 + 1e-9, 1 - 1e-9, 1e-14),
    "beyond the end of the cell": (X - 1 - 1e-9, NOWHERE),
    **{
        f"ever faster, {b:g} x^2": (b * X**2 + X - 1, 2.0 / (1.0 + np.sqrt(1 + 4 * b)), 1e-12)
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


@pytest.mark.parametrize("place", TOUCHES)
def test_touch(place):
    excess, wanted, *within = TOUCHES[place]
    assert touch(excess) == pytest.approx(wanted, abs=sum(within), rel=0)


def test_a_cell_is_searched_from_where_and_up_to_where_it_is_told():
    assert touch(X - 0.5, end=0.4) == NOWHERE
    roots = from_roots(0.2, 0.4, 0.6)
    assert touch(roots, x=0.45) == pytest.approx(0.6, abs=1e-12)


def nearest(p, best, end=1.0):
    cell, bend, jerk = cell_with(p)
    return nearest_miss(cell, 0.0, 1.0, end, best, bend, jerk, False)


def test_only_a_miss_that_has_turned_and_is_closer_counts():
    assert nearest(-((X - 0.5) ** 2), -1.0, end=0.4) == -1.0
    assert nearest(X, -1.0) == -1.0
    assert nearest(-((X - 0.5) ** 2), 0.01) == 0.01


def watched(*pieces):
    """Return the note of excesses over LEVEL, in consecutive cells of 0.5 s."""
    log = np.zeros(6)
    log[[observe.LIMIT, observe.FIRST_VIOLATION, observe.ORIGIN]] = LEVEL, np.nan, 10.0
    for j, excess in enumerate(pieces):
        cell, bend, jerk = cell_with(Polynomial([LEVEL]) + excess)
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
