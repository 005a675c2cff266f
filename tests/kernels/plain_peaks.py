"""The largest energies of a piece of a cell, against many samples of its polynomial.

(Run by `contract/test_plain.py`.)
"""

import math

import numpy as np
import pytest
from support import kernel_cell

from nlds_vines.kernels.exact import bounds_of
from nlds_vines.kernels.flight import at, cell_polynomial, cells_of, grid_of
from nlds_vines.kernels.observe import energies, powers_at
from nlds_vines.kernels.peaks import (
    ALL,
    factor_bends,
    factor_polynomial,
    horner,
    note_peaks,
    suspects,
)
from nlds_vines.kernels.scene import damper_in, scale_of, structure_of

USUAL = {"m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0}
FORCED = {**USUAL, "P": 800.0, "omega": 6.28}
SAMPLES = np.linspace(0.0, 1.0, 2001)


def random_cell(rng):
    """Return structure, damper, grid with an expanded cell, (cos, sin) at its start, its state."""
    numbers = {name: value * 10.0 ** rng.uniform(-1, 1) for name, value in FORCED.items()}
    cell = kernel_cell(**numbers)
    ps, damper = structure_of(cell), damper_in(cell)
    grid = grid_of(ps, damper, cells_of(ps, damper))
    phase = rng.uniform(0, 2 * np.pi)
    y = rng.normal(size=4) / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
    y *= rng.choice([0.05, 1.0], 4)  # a slow body may turn round
    y[3] = y[1] - y[3]
    cell_polynomial(grid, *y, math.cos(phase), math.sin(phase))
    return ps, damper, grid, (math.cos(phase), math.sin(phase)), y


@pytest.mark.parametrize("seed", range(40))
def test_the_largest_of_a_piece_are_those_of_its_samples(seed):
    rng = np.random.default_rng(seed)
    ps, damper, grid, (cosine, sine), y = random_cell(rng)
    end = rng.uniform(0.1, 1.0)
    sampled = [energies(ps, damper, *at(grid.table, x)) for x in end * SAMPLES]
    largest = np.max(sampled, axis=0)
    energy = np.array(energies(ps, damper, *y))
    note_peaks(ps, damper, energy, grid, cosine, sine, end, ALL)
    assert (energy >= largest * (1 - 1e-13)).all()
    assert (energy <= largest * (1 + 1e-5)).all()


def test_some_of_these_peaks_are_inside_and_some_at_the_end():
    inside, rising = np.zeros(2), np.zeros(2)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        ps, damper, grid, _, _ = random_cell(rng)
        end = rng.uniform(0.1, 1.0)
        sampled = np.array([energies(ps, damper, *at(grid.table, x)) for x in end * SAMPLES])
        inside += sampled.max(axis=0) > sampled[[0, -1]].max(axis=0) * (1 + 1e-6)
        rising += sampled.argmax(axis=0) == len(SAMPLES) - 1
    assert (inside >= 1).all()
    assert (rising >= 3).all()


@pytest.mark.parametrize("which", range(4))
def test_the_polynomial_of_a_factor_is_the_factor(which):
    ps, damper, grid, (cosine, sine), _ = random_cell(np.random.default_rng(3))
    bend = factor_polynomial(ps, damper, grid, cosine, sine, which)
    turn = ps.omega * grid.h
    values = []
    for x in SAMPLES:
        drive = cosine * math.cos(turn * x) - sine * math.sin(turn * x)
        values.append(powers_at(ps, damper, *at(grid.table, x), drive, 0.0)[which])
    found = [horner(grid.table, x) for x in SAMPLES]
    np.testing.assert_allclose(found, values, rtol=0, atol=1e-12 * np.abs(values).max())
    second = np.diff(values, 2) / (SAMPLES[1] - SAMPLES[0]) ** 2
    assert np.abs(second).max() <= bend * (1 + 1e-3)


@pytest.mark.parametrize("seed", range(20))
def test_what_rises_between_the_ends_of_a_cell_is_suspected(seed):
    """Whole cells from the start of a period: a record inside has a factor that is suspected."""
    rng = np.random.default_rng(seed)
    ps, damper, grid, _, y = random_cell(rng)
    cell_polynomial(grid, *y, 1.0, 0.0)
    scale = scale_of(ps, damper, *y) + grid.push * grid.h
    _, _, second, energy_bend = bounds_of(ps, grid, scale)
    bends, z = factor_bends(ps, grid, second), at(grid.table, 1.0)
    sampled = np.array([energies(ps, damper, *at(grid.table, x)) for x in SAMPLES])
    for body in range(2):
        energy = sampled[[0, -1]].max(axis=0)
        if sampled[:, body].max() > energy[body] * (1 + 1e-12):
            found = suspects(ps, damper, energy, grid, bends, energy_bend, 0, tuple(y), z)
            assert found & (3 << 2 * body)
    high = np.full(2, 1e300)
    assert suspects(ps, damper, high, grid, bends, energy_bend, 0, tuple(y), z) == 0
