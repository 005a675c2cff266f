"""Cells that are rounded once, beside the motion in rational numbers."""

import math
from fractions import Fraction

import numpy as np
import pytest
from support import kernel_cell

from nlds_vines.kernels.motion.bounds import cells_of
from nlds_vines.kernels.motion.flight import PERIOD, cell_polynomial, phase_at
from nlds_vines.kernels.motion.once_rounded import (
    after_cell,
    after_piece,
    grid_once_rounded,
    plus,
    quotient,
    times,
    whole_at_phase,
)
from nlds_vines.kernels.scene.scene import damper_in, ground_under, structure_of, with_load

pytestmark = pytest.mark.kernels

NUMBERS = {"m1": 1000.0, "k1": 3.95e4, "c1": 45.2, "m2": 60.0, "k2": 669.0, "c2": 5.08}
FREE, DRIVEN = {"P": 0.0, "omega": 6.28}, {"P": 800.0, "omega": 6.28}
STATES = 60


def bodies(kind, forcing):
    cell = kernel_cell(**NUMBERS, **forcing)
    return structure_of(cell), damper_in(cell) if kind == "damper" else ground_under(cell)


def moved(ps, damper, y, drive, time):
    """Return the motion from y, a time later, by its Taylor series in rational numbers."""
    y, whole = [Fraction(x) for x in y], [Fraction(x) for x in y]
    cosine, sine, omega = Fraction(drive[0]), Fraction(drive[1]), Fraction(ps.omega)
    load = Fraction(ps.load or 0.0)
    p = {name: Fraction(value) for name, value in damper._asdict().items()}
    for k in range(1, 26):
        pull = p["k2"] * y[2] + p["c2"] * y[3]
        alone = Fraction(ps.force) * cosine - Fraction(ps.stiffness) * y[0]
        alone += load - Fraction(ps.damping) * y[1]
        g, load = time / k, Fraction(0)
        y = [y[1] * g, (alone - p["inv_m1"] * pull) * g, y[3] * g, (alone - p["inv_mu"] * pull) * g]
        cosine, sine = -omega * sine * g, omega * cosine * g
        whole = [a + b for a, b in zip(whole, y, strict=True)]
    return whole


def errors(found, expected):
    """Return by how many units in the last place each number errs."""
    pairs = zip(found, expected, strict=True)
    return [abs(float(Fraction(a) - b)) / math.ulp(float(b)) for a, b in pairs]


def states(kind):
    rng = np.random.default_rng(7)
    for y in rng.uniform(-1, 1, (STATES, 4)):
        yield tuple(float(x) for x in (y if kind == "damper" else (y[2], y[3], y[2], y[3])))


@pytest.mark.parametrize("kind", ["damper", "structure"])
def test_a_cell_is_rounded_once(kind):
    """Notices: a tail that is left out, a loss of a sum, or a power of the series."""
    ps, damper = bodies(kind, FREE)
    grid = grid_once_rounded(ps, damper, 2 * cells_of(ps, damper), PERIOD)
    for y in states(kind):
        found = after_cell(grid.low, damper, grid.table, 3, y)
        expected = moved(ps, damper, y, (0.0, 0.0), Fraction(grid.h))
        assert max(errors(found, expected)) <= 0.5 + 1e-6


@pytest.mark.parametrize("x", [1e-3, 0.3, 0.77, 1.0])
@pytest.mark.parametrize("kind", ["damper", "structure"])
def test_so_is_a_piece_of_one(kind, x):
    """But for powers of the fourth order, which are plain."""
    ps, damper = bodies(kind, FREE)
    grid = grid_once_rounded(ps, damper, 2 * cells_of(ps, damper), PERIOD)
    for y in states(kind):
        cell_polynomial(grid, *y, 1.0, 0.0)
        found = after_piece(grid.low, damper, grid.load, grid.table, x, y, (1.0, 0.0))
        expected = moved(ps, damper, y, (0.0, 0.0), Fraction(x) * Fraction(grid.h))
        # a number much less than the others errs by their rounding
        for a, b in zip(found, expected, strict=True):
            assert abs(Fraction(a) - b) <= Fraction(0.5 * math.ulp(float(b)) + 1e-18)


@pytest.mark.parametrize("load", [None, 0.7])
@pytest.mark.parametrize("kind", ["damper", "structure"])
def test_forces_are_felt(kind, load):
    ps, damper = bodies(kind, DRIVEN)
    ps = with_load(ps, load)
    grid = grid_once_rounded(ps, damper, 2 * cells_of(ps, damper), PERIOD)
    phase = phase_at(grid, 3, 0.0)
    for y in states(kind):
        cell_polynomial(grid, *y, *phase)
        found = after_cell(grid.low, damper, grid.table, 3, y)
        expected = moved(ps, damper, y, phase, Fraction(grid.h))
        np.testing.assert_allclose(found, [float(b) for b in expected], rtol=0, atol=5e-16)
        found = whole_at_phase(grid.low, damper, grid.table, y, phase)
        np.testing.assert_allclose(found, [float(b) for b in expected], rtol=0, atol=5e-16)
        found = after_piece(grid.low, damper, grid.load, grid.table, 0.3, y, phase)
        expected = moved(ps, damper, y, phase, Fraction(0.3) * Fraction(grid.h))
        np.testing.assert_allclose(found, [float(b) for b in expected], rtol=0, atol=5e-16)


def test_pairs_have_twice_the_precision():
    rng = np.random.default_rng(8)
    for first, second in rng.uniform(-2, 2, (200, 2)):
        a, b = quotient(first, 3.0), quotient(second, 7.0)
        exact = Fraction(first) / 3, Fraction(second) / 7
        for found, expected in (
            (a, exact[0]), (plus(a, b), sum(exact)), (times(a, b), exact[0] * exact[1])
        ):  # fmt: skip
            error = abs(Fraction(found[0]) + Fraction(found[1]) - expected)
            assert error <= Fraction(1e-30)
