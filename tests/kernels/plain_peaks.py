"""The largest energies of a piece of a cell, against many samples of its polynomial.

(Run by `contract/test_plain.py`.)
"""

import math

import numpy as np
import pytest
from support import kernel_cell

from nlds_vines.kernels.exact import bounds_of
from nlds_vines.kernels.flight import at, cell_polynomial, cells_of, grid_of
from nlds_vines.kernels.observe import energies, note_energy, powers_at
from nlds_vines.kernels.peaks import factor_at, factor_polynomial, note_peaks, suspects
from nlds_vines.kernels.scene import damper_in, scale_of, structure_of

USUAL = {"m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0}
FORCED = {**USUAL, "P": 800.0, "omega": 6.28}
SAMPLES = np.linspace(0.0, 1.0, 2001)
ALL = 15  # every factor is suspected


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
    note_energy(ps, damper, energy, *at(grid.table, end))
    note_peaks(ps, damper, energy, grid, (cosine, sine), end, ALL)
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
    bend = factor_polynomial(ps, damper, grid, (cosine, sine), which)
    turn = ps.omega * grid.h
    values = []
    for x in SAMPLES:
        drive = cosine * math.cos(turn * x) - sine * math.sin(turn * x)
        values.append(powers_at(ps, damper, *at(grid.table, x), drive, 0.0)[which])
    found = [factor_at(grid.table, x) for x in SAMPLES]
    np.testing.assert_allclose(found, values, rtol=0, atol=1e-12 * np.abs(values).max())
    second = np.diff(values, 2) / (SAMPLES[1] - SAMPLES[0]) ** 2
    assert np.abs(second).max() <= bend * (1 + 1e-3)


def suspected(ps, damper, grid, y, length=1.0):
    """Check which factors are suspected in the first cell of a period; return those that must be.

    They vanish where their energy passes what it is at the ends of the piece of so many cells, and
    the record is just less.
    """
    cell_polynomial(grid, *y, 1.0, 0.0)
    bounds = bounds_of(ps, grid, scale_of(ps, damper, *y) + grid.push * grid.h)
    states = [at(grid.table, x) for x in length * SAMPLES]
    turn = ps.omega * grid.h * length
    factors = np.array(
        [
            powers_at(ps, damper, *w, math.cos(turn * x), 0.0)
            for x, w in zip(SAMPLES, states, strict=True)
        ]
    )
    drives = 1.0, math.cos(turn)
    sampled = np.array([energies(ps, damper, *w) for w in states])
    must = 0
    for body in range(2):
        top = int(sampled[:, body].argmax())
        if 0 < top < len(SAMPLES) - 1:
            energy = np.full(2, 1e300)
            energy[body] = sampled[top, body] * (1 - 1e-12)
            found = suspects(ps, damper, energy, grid, bounds, length, drives, tuple(y), states[-1])
            for i in (2 * body, 2 * body + 1):
                if factors[top - 1, i] * factors[top + 1, i] < 0.0:
                    assert found & (1 << i)
                    must |= 1 << i
    high = np.full(2, 1e300)
    found = suspects(ps, damper, high, grid, bounds, length, drives, tuple(y), states[-1])
    assert found == 0
    return must


def test_what_rises_between_the_ends_of_a_cell_is_suspected():
    """Whole cells from the start of a period: a record inside has a factor that is suspected."""
    seen = 0
    for seed in range(60):
        ps, damper, grid, _, y = random_cell(np.random.default_rng(seed))
        seen |= suspected(ps, damper, grid, y)
        seen |= suspected(ps, damper, grid, y, 0.2 + 0.01 * seed)
    # the structure turns round in the middle of the cell, or the force on it vanishes there
    cell = kernel_cell(**FORCED)
    ps, damper = structure_of(cell), damper_in(cell)
    grid = grid_of(ps, damper, cells_of(ps, damper))
    half, p = 0.5 * grid.h, FORCED
    back = (p["P"] - p["k1"] * 0.05) / p["m1"]
    seen |= suspected(ps, damper, grid, np.array([0.05, -half * back, 0.0, 0.0]))
    r = (p["P"] - p["c1"] * 0.3 - p["c2"] * 0.5) / p["k2"] - half * 0.5
    seen |= suspected(ps, damper, grid, np.array([0.0, 0.3, r, 0.5]))
    assert seen == ALL


@pytest.mark.parametrize("softer", [1e2, 1e4, 1e6])
def test_a_rise_of_the_dampers_energy_on_a_soft_structure_is_suspected(softer):
    """k2 (x1 - r)^2 / 2 rises by far more than the energy scale would allow a body of its own."""
    cell = kernel_cell(**{**FORCED, "P": 0.0, "c1": 0.0, "c2": 0.0, "k1": FORCED["k2"] / softer})
    ps, damper = structure_of(cell), damper_in(cell)
    grid = grid_of(ps, damper, cells_of(ps, damper))
    x1, r = 0.7 / math.sqrt(ps.k1), -0.7 / math.sqrt(damper.k2)
    v2 = -0.5 * grid.h * damper.k2 * r / damper.m2  # it turns round in the middle
    assert suspected(ps, damper, grid, np.array([x1, 0.0, r, -v2])) & 12
