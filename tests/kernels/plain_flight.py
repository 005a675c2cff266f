"""The bounds that every proof of a flight rests on, against the matrix of equation (5)."""

import math

import mpmath
import numpy as np
import pytest
from support import NOTHING, kernel_cell

from nlds_vines.kernels.events.exact import fly
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.flight import (
    PERIOD,
    at,
    bend_of,
    bounds_of,
    cell_polynomial,
    grid_from,
    phase_at,
    rate_of,
)
from nlds_vines.kernels.scene.codes import SECTION, TOUCH_NEAR
from nlds_vines.kernels.scene.scene import (
    Flight,
    accelerations,
    damper_in,
    scale_of,
    structure_under,
)

USUAL = {"m1": 1000.0, "k1": 3.95e4, "c1": 452.0, "m2": 60.0, "k2": 669.0, "c2": 50.8}
FORCED = {**USUAL, "P": 800.0, "omega": 6.28}


def parts_of(**changes):
    cell = kernel_cell(**{**FORCED, **changes})
    return structure_under(None, cell), damper_in(cell)


def unit_states(ps, damper):
    """Return the four states (x1, v1, r, s) of energy scale 1 with one of x1, v1, r, v2 alone."""
    x1, v1 = 1 / math.sqrt(ps.k1), 1 / math.sqrt(ps.m1)
    r, v2 = 1 / math.sqrt(damper.k2), 1 / math.sqrt(damper.m2)
    return [(x1, 0.0, 0.0, 0.0), (0.0, v1, 0.0, v1), (0.0, 0.0, r, 0.0), (0.0, 0.0, 0.0, -v2)]


def matrix(ps, damper):
    columns = []
    for x1, v1, r, s in unit_states(ps, damper):
        a1, ds = accelerations(ps, damper, x1, v1, r, s, 0.0, 0.0)
        roots = [math.sqrt(k) for k in (ps.k1, ps.m1, damper.k2, damper.m2)]
        columns.append(np.multiply(roots, (v1, a1, s, a1 - ds)))
    return np.array(columns).T


@pytest.mark.kernels
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
    sums = np.abs(matrix(ps, damper)).sum(1)
    if largest is None:
        assert ps.omega > sums.max()
    else:
        assert sums[largest] >= 0.999999 * sums.max()
    assert rate_of(ps, damper) == pytest.approx(max(sums.max(), ps.omega), rel=1e-14)


@pytest.mark.kernels
@pytest.mark.parametrize("changes", [{}, {"c1": 0.0}, {"c2": 4e3}, {"m2": 1.0, "k2": 1e4}])
def test_the_bend_is_the_largest_second_derivative_at_energy_scale_one(changes):
    """Notices: any of its terms left out, the last one (of v2) among them."""
    ps, damper = parts_of(**changes)
    units = unit_states(ps, damper)
    second = [accelerations(ps, damper, *y, 0.0, 0.0)[1] for y in units]
    assert bend_of(ps, damper) == pytest.approx(np.linalg.norm(second), rel=1e-14)
    steepest = np.dot(second, units) / np.linalg.norm(second)
    assert scale_of(ps, damper, *steepest) == pytest.approx(1.0, rel=1e-14)
    assert accelerations(ps, damper, *steepest, 0.0, 0.0)[1] == pytest.approx(bend_of(ps, damper))


# ---- bounds of a cell ----------------------------------------------------------------------------


def derivatives(p, y, phase, cells):
    """Return the largest second, third and fourth derivative of r over some cells."""
    ps, damper = parts_of(**p)
    grid = grid_from(ps, damper, 64, PERIOD)
    largest = np.zeros(3)
    for j in range(cells):
        angle = phase + j * grid.h * ps.omega
        cell_polynomial(grid, *y, math.cos(angle), math.sin(angle))
        series = np.polynomial.Polynomial(grid.table[42:102:4])
        x = np.linspace(0, 1, 41)
        largest = np.maximum(largest, [np.abs(series.deriv(n)(x)).max() for n in (2, 3, 4)])
        y = at(grid.table, 1.0)
    return largest


CASES = [
    {},
    {"c1": 0.0, "c2": 0.0},
    {"c1": 2e4, "omega": 40.0},
    {"c2": 2e3, "omega": 20.0},
    {"k1": 1e6, "omega": 3.0},
]


@pytest.mark.kernels
@pytest.mark.parametrize("changes", CASES)
@pytest.mark.parametrize("phase", [0.0, 0.7, 1.5707963, 2.6])
def test_bounds_from_rest_hold_over_four_cells(changes, phase):
    """From rest the forcing alone bends the motion. Notices: its push, or its part, left out."""
    ps, damper = parts_of(**changes)
    grid = grid_from(ps, damper, 64, PERIOD)
    for cells in (1, 4):
        scale = grid.push * grid.h * cells
        bounds = bounds_of(ps, grid, scale)
        largest = derivatives(changes, (0.0, 0.0, 0.0, 0.0), phase, cells)
        assert (largest <= np.array(bounds[:3]) * (1 + 1e-12)).all()


def test_each_part_of_the_bounds_is_needed():
    """The bounds of the forcing are reached: with less of it they would not hold."""
    ps, damper = parts_of(c1=0.0, c2=0.0)
    grid = grid_from(ps, damper, 64, PERIOD)
    bend, jerk, fourth, *_ = bounds_of(ps, grid, 0.0)
    by_force = ps.omega**2 * ps.force
    h2 = grid.h * grid.h
    assert derivatives({"c1": 0.0, "c2": 0.0}, (0.0,) * 4, 0.0, 1)[0] == pytest.approx(bend)
    assert bend == pytest.approx(ps.force * h2, rel=1e-14)
    assert jerk == pytest.approx((grid.bend * grid.push + ps.omega * ps.force) * h2 * grid.h)
    second = 2 * grid.rate * grid.push
    assert fourth == pytest.approx((grid.bend * second + by_force) * h2 * h2)
    bend, jerk, fourth, energy, _ = bounds_of(ps, grid, 3.0)
    first = 3.0 * grid.rate + grid.push
    second = grid.rate * (first + grid.push)
    assert bend == pytest.approx((3.0 * grid.bend + ps.force) * h2)
    assert jerk == pytest.approx((grid.bend * first + ps.omega * ps.force) * h2 * grid.h)
    assert fourth == pytest.approx((grid.bend * second + by_force) * h2 * h2)
    third = grid.rate * (second + grid.rate * grid.push)
    last = grid.rate * (third + grid.rate**2 * grid.push)
    leibniz = 3.0 * last + 4.0 * first * third + 3.0 * second**2
    assert energy == pytest.approx(leibniz * h2 * h2)


@pytest.mark.kernels
@pytest.mark.parametrize(("clearance", "event"), [(1e-9, SECTION), (-1e-9, TOUCH_NEAR)])
def test_a_touch_that_the_forcing_brings_about_after_some_cells(clearance, event):
    """A free damper on a structure in resonance: r = P t sin(omega t) / (2 m1 omega) from rest.

    It turns in the middle of the fourth cell, and bends there more than the force alone could bend
    it. Notices: what the forcing may add until then left out of the bound.
    """
    omega = 6.28
    changes = {"k1": 1000.0 * omega**2, "c1": 0.0, "k2": 0.0, "c2": 0.0, "omega": omega}
    ps, damper = parts_of(**changes)
    grid = grid_from(ps, damper, 11, PERIOD)
    top = 2.028757838110434  # tan x = -x
    highest = ps.force / (2 * omega**2) * top * math.sin(top)
    cell = kernel_cell(**{**FORCED, "K": 1e7})
    wall = hertz_wall_at(highest * (1 + clearance), damper_in(cell).inv_mu, cell)
    flight = Flight(None, ps, damper, wall, None, grid)
    flown = fly(flight, NOTHING, (0, 0.0), 5, (0.0, 0.0, 0.0, 0.0))
    assert flown[0] == event
    if event == TOUCH_NEAR:
        assert (flown[1] + flown[2]) * grid.h * omega == pytest.approx(top, abs=1e-4)


# ---- places inside a cell ------------------------------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize("n", [9, 10, 64])
def test_the_phase_inside_a_cell(n):
    """Turned on from that at the start of the cell, by up to 0.7. Notices: a term left out."""
    ps, damper = parts_of()
    grid = grid_from(ps, damper, n, PERIOD)
    for j in range(n):
        for x in np.linspace(0.0, 1.0, 23):
            with mpmath.workdps(30):
                angle = 2 * mpmath.pi * (j + mpmath.mpf(x)) / n
                exact = float(mpmath.cos(angle)), float(mpmath.sin(angle))
            assert np.abs(np.subtract(phase_at(grid, j, x), exact)).max() <= 5e-16


def test_the_polynomial_is_summed_to_round_off():
    """At places of a cell, against its terms in longer arithmetic. Notices: a pair forgotten."""
    ps, damper = parts_of()
    grid = grid_from(ps, damper, 10, PERIOD)
    rng = np.random.default_rng(1)
    for _ in range(50):
        y = rng.normal(size=4)
        cell_polynomial(grid, *y, *rng.normal(size=2))
        rows = grid.table[40:100].reshape(15, 4)
        x = rng.uniform()
        exact = [math.fsum(row * x**k for k, row in enumerate(rows[:, c])) for c in range(4)]
        sizes = np.abs(rows).T @ x ** np.arange(15)
        assert (np.abs(np.subtract(at(grid.table, x), exact)) <= 6e-16 * sizes).all()
