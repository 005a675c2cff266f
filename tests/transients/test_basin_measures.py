"""Measures of basins on planes whose values are known in closed form."""

import numpy as np
import pytest

from nlds_vines.transients.basins import basin_entropy, uncertainty_exponent


def half_planes(size, slope=0.37, place=0.6):
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    return (x + slope * y > place * size).astype(np.int64)


def tent_basins(size, lines):
    """Whether a start leaves [0, 1] after an even number of steps of x -> 3 min(x, 1 - x).

    The boundary is the middle-third Cantor set, of dimension ln 2 / ln 3 (Ott, Chaos in Dynamical
    Systems, 2nd ed., section 3.1), so that the exponent is 1 - ln 2 / ln 3.
    """
    x = (np.arange(size) + 0.5) / size
    steps, inside = np.zeros(size, np.int64), np.ones(size, bool)
    for step in range(40):
        x = np.where(inside, 3 * np.minimum(x, 1 - x), x)
        steps[inside & (x > 1)] = step
        inside &= x <= 1
    return np.broadcast_to((steps % 2)[:, np.newaxis], (size, lines))


def newton_basins(size, roots):
    """The roots of z^n = 1 that Newton's method finds: n basins with one common boundary."""
    x = np.linspace(-1.5, 1.5, size)
    z = x[np.newaxis, :] + 1j * x[:, np.newaxis] + 1e-9
    for _ in range(200):
        z = z - (z**roots - 1) / (roots * z ** (roots - 1))
    roots = np.exp(2j * np.pi * np.arange(roots) / roots)
    return np.argmin(np.abs(z[..., np.newaxis] - roots), axis=-1)


def test_a_straight_boundary_has_exponent_one():
    exponent = uncertainty_exponent(half_planes(800))
    assert exponent.exponent == pytest.approx(1.0, abs=0.005)
    assert abs(exponent.exponent - 1.0) < 3 * exponent.error
    assert exponent.distances.tolist() == [1, 2, 4, 8, 16, 32, 64]
    # of the pairs in rows as many differ as the boundary is wide, in columns 0.37 of these at most
    assert exponent.shares[3] == pytest.approx(8 * exponent.shares[0], rel=0.01)


def test_a_fractal_boundary_has_the_exponent_of_its_dimension():
    exponent = uncertainty_exponent(tent_basins(3**8, 2056))
    expected = 1 - np.log(2) / np.log(3)
    assert exponent.exponent == pytest.approx(expected, abs=0.02)
    assert abs(exponent.exponent - expected) < 3 * exponent.error < 0.05


def test_riddled_basins_have_exponent_zero_and_the_greatest_entropy():
    plane = np.random.default_rng(5).integers(0, 3, (600, 600))
    assert uncertainty_exponent(plane).exponent == pytest.approx(0.0, abs=0.001)
    entropy = basin_entropy(plane)
    # 400 draws from three: ln 3, less (3 - 1) / (2 * 400) for so few draws
    assert entropy.basin == entropy.boundary == pytest.approx(np.log(3) - 1 / 400, abs=2e-4)
    assert entropy.fractal


def test_entropy_of_a_straight_boundary_is_below_ln_2():
    plane = np.zeros((400, 400), np.int64)
    plane[:, 190:] = 7  # parts the boxes of the tenth column of boxes in halves
    entropy = basin_entropy(plane)
    assert (entropy.boxes, entropy.boundary_boxes) == (400, 20)
    assert entropy.boundary == pytest.approx(np.log(2))
    assert entropy.basin == pytest.approx(np.log(2) / 20)
    slanted = basin_entropy(half_planes(800))
    assert 0.3 < slanted.boundary < np.log(2)
    assert not slanted.fractal


def test_a_boundary_of_eight_basins_at_once_is_seen_to_be_fractal():
    plane = newton_basins(600, roots=8)
    assert basin_entropy(plane).boundary > np.log(2)
    assert basin_entropy(plane).fractal
    assert 0.0 < uncertainty_exponent(plane).exponent < 0.9


def test_one_basin_has_no_boundary():
    plane = np.zeros((64, 64), np.int64)
    assert np.isnan(basin_entropy(plane).boundary)
    assert basin_entropy(plane).basin == 0.0
    assert np.isnan(uncertainty_exponent(plane).exponent)


def test_unknown_cells_count_nowhere():
    plane = half_planes(400)
    holes = plane.copy()
    holes[np.random.default_rng(1).random(plane.shape) < 0.3] = -1
    assert basin_entropy(holes).boundary == pytest.approx(basin_entropy(plane).boundary, rel=0.05)
    assert uncertainty_exponent(holes).exponent == pytest.approx(1.0, abs=0.02)
    assert np.isnan(basin_entropy(np.full((40, 40), -1)).basin)
