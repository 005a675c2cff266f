"""The largest energies of a piece of a cell, against many samples of its polynomial.

(Run by `contract/test_plain.py`.)
"""

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from support import NOTHING, kernel_cell

from nlds_vines.kernels.events.exact import fly
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.flight import (
    OF_E2,
    ORDER,
    PERIOD,
    TERMS,
    at,
    bounds_of,
    cell_polynomial,
    cells_of,
    expand,
    grid_from,
)
from nlds_vines.kernels.scene.codes import SECTION
from nlds_vines.kernels.scene.scene import Flight, damper_in, scale_of, structure_under
from nlds_vines.kernels.watch.observe import energies, note_energy, powers_at
from nlds_vines.kernels.watch.response import (
    damper_bound,
    factor_at,
    factor_polynomial,
    may_set_a_record,
    note_peaks,
    record_breakers,
    work_at,
)

USUAL = {"m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0}
FORCED = {**USUAL, "P": 800.0, "omega": 6.28}
SAMPLES = np.linspace(0.0, 1.0, 2001)
BOTH = 3  # bodies


def random_cell(rng):
    """Return structure, damper, grid with an expanded cell, (cos, sin) at its start, its state."""
    numbers = {name: value * 10.0 ** rng.uniform(-1, 1) for name, value in FORCED.items()}
    cell = kernel_cell(**numbers)
    ps, damper = structure_under(None, cell), damper_in(cell)
    grid = grid_from(ps, damper, cells_of(ps, damper), PERIOD)
    phase = rng.uniform(0, 2 * np.pi)
    y = rng.normal(size=4) / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
    y *= rng.choice([0.05, 1.0], 4)  # a slow body may turn round
    y[3] = y[1] - y[3]
    cell_polynomial(grid, *y, math.cos(phase), math.sin(phase))
    return ps, damper, grid, (math.cos(phase), math.sin(phase)), y


@pytest.mark.parametrize("seed", range(40))
def test_the_largest_of_a_piece_are_those_of_its_samples(seed):
    rng = np.random.default_rng(seed)
    ps, damper, grid, _, y = random_cell(rng)
    end = rng.uniform(0.1, 1.0)
    sampled = [energies(ps, damper, *at(grid.table, x)) for x in end * SAMPLES]
    largest = np.max(sampled, axis=0)
    energy = np.array(energies(ps, damper, *y))
    note_energy(ps, damper, energy, *at(grid.table, end))
    note_peaks(ps, damper, energy, grid, end, BOTH)
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
    bend = factor_polynomial(ps, damper, grid, which)
    turn = ps.omega * grid.h
    values = []
    for x in SAMPLES:
        drive = cosine * math.cos(turn * x) - sine * math.sin(turn * x)
        values.append(powers_at(ps, damper, *at(grid.table, x), drive)[which])
    factors = [factor_at(grid.table, x) for x in SAMPLES]
    np.testing.assert_allclose(factors, values, rtol=0, atol=1e-12 * np.abs(values).max())
    second = np.diff(values, 2) / (SAMPLES[1] - SAMPLES[0]) ** 2
    assert np.abs(second).max() <= bend * (1 + 1e-3)


def breakers(*arguments):
    """Return `record_breakers` where it is asked, otherwise 0, as `fly` does."""
    return record_breakers(*arguments) if may_set_a_record(*arguments) else 0


def suspected(ps, damper, grid, y, length=1.0):
    """Check which energies are searched in the first cell of a period; return those that must be.

    They exceed what they are at the ends of the piece of so many cells, and the record is just
    less. What only rises or only falls is never searched, whatever the record.
    """
    cell_polynomial(grid, *y, 1.0, 0.0)
    bounds = bounds_of(ps, grid, scale_of(ps, damper, *y) + grid.push * grid.h)
    states = [at(grid.table, x) for x in length * SAMPLES]
    ends = (
        work_at(ps, damper, states[0], 1.0),
        work_at(ps, damper, states[-1], math.cos(ps.omega * grid.h * length)),
    )
    sampled = np.array([energies(ps, damper, *w) for w in states])
    must = 0
    for body in range(2):
        top = int(sampled[:, body].argmax())
        energy = np.full(2, 1e300)
        energy[body] = sampled[top, body] * (1 - 1e-12)
        bodies = breakers(damper, energy, grid, bounds, length, *ends)
        assert bodies & 2 - body == 0
        if 0 < top < len(SAMPLES) - 1:
            assert bodies == 1 + body
            must |= bodies
    high = np.full(2, 1e300)
    assert breakers(damper, high, grid, bounds, length, *ends) == 0
    return must


def test_what_rises_between_the_ends_of_a_cell_is_suspected():
    """Cells from the start of a period, whole and in part: a record inside is searched for."""
    seen = 0
    for seed in range(60):
        ps, damper, grid, _, y = random_cell(np.random.default_rng(seed))
        seen |= suspected(ps, damper, grid, y)
        seen |= suspected(ps, damper, grid, y, 0.2 + 0.01 * seed)
    # the structure turns round in the middle of the cell, or the force on it vanishes there
    cell = kernel_cell(**FORCED)
    ps, damper = structure_under(None, cell), damper_in(cell)
    grid = grid_from(ps, damper, cells_of(ps, damper), PERIOD)
    half, p = 0.5 * grid.h, FORCED
    back = (p["P"] - p["k1"] * 0.05) / p["m1"]
    seen |= suspected(ps, damper, grid, np.array([0.05, -half * back, 0.0, 0.0]))
    r = (p["P"] - p["c1"] * 0.3 - p["c2"] * 0.5) / p["k2"] - half * 0.5
    seen |= suspected(ps, damper, grid, np.array([0.0, 0.3, r, 0.5]))
    assert seen == BOTH


@pytest.mark.parametrize("length", [1.0, 0.5])
def test_the_error_of_the_cubic_counts_for_each_body(length):
    """Level at both ends, an energy may rise by M / 384 in between: the damper's M is another."""
    ps, damper, grid, _, y = random_cell(np.random.default_rng(5))
    bounds, ends = bounds_of(ps, grid, scale_of(ps, damper, *y)), (3.0, 3.0, 0.0, 0.0)
    fourths = bounds.energy, damper_bound(grid, bounds.scale, 3.0)
    assert fourths[1] < bounds.energy * grid.table[OF_E2]
    for body in range(2):
        for part, expected in ((0.99, 1 + body), (1.01, 0)):
            energy = np.full(2, 1e300)
            energy[body] = 3.0 + part * fourths[body] * length**4 / 384
            assert breakers(damper, energy, grid, bounds, length, ends, ends) == expected


@pytest.mark.parametrize("length", [1.0, 0.5])
def test_powers_count_with_the_time_that_they_have(length):
    """As large as to make the error small: energies may rise by a third of power times time."""
    ps, damper, grid, _, y = random_cell(np.random.default_rng(5))
    bounds = bounds_of(ps, grid, scale_of(ps, damper, *y))
    power = 1e6 * bounds.energy
    ends = (3.0, 3.0, power, power), (3.0, 3.0, -power, -power)
    for body in range(2):
        for part, expected in ((0.99, 1 + body), (1.01, 0)):
            energy = np.full(2, 1e300)
            energy[body] = 3.0 + part * power * length * grid.h / 3
            assert breakers(damper, energy, grid, bounds, length, *ends) == expected


@pytest.mark.parametrize("softer", [1e2, 1e4, 1e6])
def test_a_rise_of_the_dampers_energy_on_a_soft_structure_is_suspected(softer):
    """k2 (x1 - r)^2 / 2 rises by far more than the energy scale would allow a body of its own."""
    cell = kernel_cell(**{**FORCED, "P": 0.0, "c1": 0.0, "c2": 0.0, "k1": FORCED["k2"] / softer})
    ps, damper = structure_under(None, cell), damper_in(cell)
    grid = grid_from(ps, damper, cells_of(ps, damper), PERIOD)
    x1, r = 0.7 / math.sqrt(ps.k1), -0.7 / math.sqrt(damper.k2)
    v2 = -0.5 * grid.h * damper.k2 * r / damper.m2  # it turns round in the middle
    assert suspected(ps, damper, grid, np.array([x1, 0.0, r, -v2])) & 2


# ---- whole flights -------------------------------------------------------------------------------


def largest_in(ps, damper, grid, y, angle, length):
    """Return the largest E1 and E2 over a flight of `length` cells from the state y, and its end.

    E1 and E2 are polynomials of twice the order: their largest values stand at roots of their
    derivatives.
    """
    out = np.zeros(TERMS)
    expand(ps, damper, grid.h, np.array([*y, math.cos(angle), math.sin(angle)]), out, 0)
    x1, v1, r, s = (Polynomial(c) for c in out.reshape(ORDER + 1, 4).T)
    values = []
    for e in (
        ps.m1 * v1**2 + ps.k1 * x1**2,
        damper.m2 * (v1 - s) ** 2 + damper.k2 * (x1 - r) ** 2,
    ):
        turns = e.deriv().roots()
        turns = turns[np.abs(turns.imag) < 1e-6].real
        places = np.clip([0.0, length, *turns], 0.0, length)
        values.append(0.5 * e(places).max())
    return np.array(values), tuple(p(length) for p in (x1, v1, r, s))


def flights(seed):
    """Yield pieces of a random orbit behind a rigid wall: as `fly` notes them, and as they are."""
    rng = np.random.default_rng(seed)
    numbers = {name: value * 10.0 ** rng.uniform(-1, 1) for name, value in FORCED.items()}
    cell = kernel_cell(**numbers, K=1e7)
    ps, damper = structure_under(None, cell), damper_in(cell)
    grid = grid_from(ps, damper, cells_of(ps, damper), PERIOD)
    y = rng.normal(size=4) / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
    y = (y[0], y[1], -abs(y[2]), y[1] - y[3])
    wall = hertz_wall_at(0.3 * abs(y[2]), damper_in(cell).inv_mu, cell)
    energy, truth = np.zeros(2), np.zeros(2)
    j, x, cells = 0, 0.0, 0
    while cells < 25:
        begin = j + x
        flight, watch = Flight(None, ps, damper, wall, None, grid), NOTHING._replace(energy=energy)
        event, j, x, *end = fly(flight, watch, (j, x), min(grid.n, j + 25), y)
        # the same flight cell by cell
        place = begin
        while place < j + x:
            length = min(math.floor(place) + 1.0, j + x) - place
            turn = 2 * math.pi * place * grid.turn
            highest, y = largest_in(ps, damper, grid, y, turn, length)
            truth, place, cells = np.maximum(truth, highest), place + length, cells + 1
        yield energy, truth
        np.testing.assert_allclose(end, y, rtol=0, atol=1e-9 * np.abs(end).max())
        y = tuple(end)
        if event == SECTION:
            j %= grid.n
        else:
            y = (y[0], y[1] - 0.1 * y[3], wall.gap, -0.9 * y[3])


@pytest.mark.parametrize("seed", range(300))
def test_the_largest_energies_of_flights_from_touch_to_touch(seed):
    """After each piece of an orbit, of any proportions. Notices: a peak that is not looked for."""
    for energy, truth in flights(seed):
        np.testing.assert_allclose(energy, truth, rtol=2e-13)
