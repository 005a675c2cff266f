"""What a cell may hold, by its polynomial: touches of two walls, near misses, peaks of energies."""

import math

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, Polynomial
from support import NOTHING, expanded, flight_parts, grid_with, kernel_cell, system_of

from nlds_vines.engine.simulation import simulate
from nlds_vines.kernels.events.exact import fly, note_misses
from nlds_vines.kernels.laws.hertz import HertzWall, hertz_wall_at
from nlds_vines.kernels.motion.flight import OF_E2, Bounds, at, bounds_of, cell_polynomial
from nlds_vines.kernels.scene.codes import SECTION
from nlds_vines.kernels.scene.scene import Flight, scale_of
from nlds_vines.kernels.watch import response
from nlds_vines.kernels.watch.observe import energies, powers_at
from nlds_vines.kernels.watch.touch import (
    CLEAR,
    CROSSED,
    UNSURE,
    crossing,
    nearest_miss,
    outlook,
    touch_of,
)

NEAR, FAR = HertzWall(0.4, 1e7, 1e5, 300.0), HertzWall(0.3, 1e7, 1e5, 300.0)
X = Polynomial([0.0, 1.0])
H = 0.1  # length of a cell [s]


def cell_of(p):
    """Return a grid with the polynomial r(x) in its table, and the `Bounds` of r."""
    places = np.linspace(0.0, 1.0, 2001)
    bounds = (1.001 * max(np.abs(p.deriv(n)(places)).max(), 1e-9) for n in (2, 3, 4))
    return grid_with(p, H), Bounds(*bounds, 0.0, 0.0)


def state(p, x):
    return 0.0, 0.0, float(p(x)), float(p.deriv()(x)) / H


def outlooks(p, level, end=1.0):
    """Return the verdict of the ends of [0, end] on a level, and where p first rises to it."""
    _, bounds = cell_of(p)
    (f0, g0), (f1, g1) = ((float(p(x)), end * float(p.deriv()(x))) for x in (0.0, end))
    verdict = outlook(level, f0, f1, g0, g1, bounds.fourth * end**4)
    roots = (p - level).roots()
    slopes = p.deriv()
    up = [x.real for x in roots if abs(x.imag) < 1e-9 and 0.0 < x.real < end and slopes(x.real) > 0]
    return verdict, min(up, default=None)


def test_what_the_ends_of_a_piece_tell_is_so():
    """Of many polynomials and levels. Notices: a proof that does not hold; none ever found."""
    seen = {CLEAR: 0, CROSSED: 0, UNSURE: 0}
    for seed in range(600):
        rng = np.random.default_rng(seed)
        p = Polynomial(rng.normal(size=9) / rng.choice([1.5, 3.0, 6.0]) ** np.arange(9))
        level = p(0.0) + abs(rng.normal()) * rng.choice([1e-6, 0.1, 1.0])
        verdict, place = outlooks(p, level, rng.choice([1.0, 0.4]))
        seen[verdict] += 1
        if verdict == CLEAR:
            assert place is None
        if verdict == CROSSED:
            assert place is not None
    assert min(seen.values()) > 40


def test_a_release_that_moves_away_is_clear_and_one_that_comes_back_is_not():
    """From the level itself, downwards. Notices: a start on the level taken for a touch."""
    assert outlooks(0.4 - X + 0.3 * X**2, 0.4)[0] == CLEAR
    assert outlooks(0.4 - X + 0.9 * X**2, 0.4)[0] != CROSSED
    assert outlooks(0.4 - X + 1.1 * X**2, 0.4)[0] == UNSURE
    assert outlooks(0.4 + X, 0.4)[0] == UNSURE  # it moves in: the walk knows


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_certain_touch_is_found_to_round_off(sign):
    """Polynomials that rise all along, some hardly at one end. Notices: the last step too early."""
    certain = 0
    for seed in range(200):
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
    assert certain > 50


def test_a_touch_within_round_off_of_the_start_is_at_the_start():
    for ahead, place in ((0.0, 0.0), (1e-17, 0.0), (5e-17, 0.0), (1e-12, 1e-12)):
        p = 0.4 - ahead + X
        touch = touch_of(cell_of(p)[0], 1.0, 1.0, 0.4, state(p, 1.0), cell_of(p)[1])
        assert touch == pytest.approx(place, rel=1e-3, abs=0.0)


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


def noted(p, near, far, clearance=np.inf):
    grid, bounds = cell_of(p)
    clearances = np.array([clearance])
    note_misses(near, far, clearances, grid, 1.0, bounds, False)
    return clearances[0]


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


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("degree", "within"), [(5, 1e-14), (9, 1e-10), (12, 1e-7)])
def test_the_closest_of_many_misses(degree, within, sign):
    """As good as sums of its powers are, some as narrow as bounds allow. Notices: unsafe steps."""
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
        assert best == pytest.approx(max(tops), rel=within)


def test_no_root_is_proven_only_where_there_is_none():
    """Quadratics, whose second derivative is the bound. Notices: a bound ten times too small."""
    bend = 1.0
    for change in np.linspace(0.0, 0.99, 34):  # f(1) - f(0)
        steep = 0.5 * bend - change
        lowest = steep**2 / (2 * bend) if steep > 0 else 0.0  # f(0) minus the lowest value
        for sign in (1.0, -1.0):
            f0 = 0.999 * lowest
            if f0 > 0.0:
                assert not response.proves_no_root(sign * f0, sign * (f0 + change), bend)
                assert not response.proves_no_root(sign * (f0 + change), sign * f0, bend)
    # f(x) = 4 (x - 1/2)^2 - e has f'' = 8: its ends are 1 - e, and its least value is -e
    for f0, f1, most, proven in (
        (0.1251, 0.1251, bend, True), (1e-9, 1.0 + 1e-6, bend, True), (0.2, -0.2, bend, False),
        (0.0, 2.0, bend, False), (0.5, 0.5, 8.0, False), (0.999, 0.999, 8.0, False),
        (1.0, 1.0, 7.9, True), (0.1, 9.0, 8.0, True),  # it changes by more than its bend allows
        (0.1, 9.0, 9.0, False), (-1.0, 1.0, 0.0, False), (0.0, 1.0, 0.0, False),
    ):  # fmt: skip
        assert bool(response.proves_no_root(f0, f1, most)) == proven


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


FORCED = {
    "m1": 1000.0, "k1": 39500.0, "c1": 450.0, "m2": 60.0, "k2": 700.0, "c2": 50.0, "P": 800.0,
    "omega": 6.28,
}  # fmt: skip
SAMPLES = np.linspace(0.0, 1.0, 401)
BOTH = 3  # bodies


def random_cell(rng, slow=0.05):
    """Return structure, damper, grid with an expanded cell, (cos, sin) at its start, its state."""
    numbers = {name: value * 10.0 ** rng.uniform(-1, 1) for name, value in FORCED.items()}
    ps, damper, grid = flight_parts(**numbers)
    phase = rng.uniform(0, 2 * np.pi)
    y = rng.normal(size=4) / np.sqrt([ps.k1, ps.m1, damper.k2, damper.m2])
    y *= rng.choice([slow, 1.0], 4)  # a slow body may turn round
    y[3] = y[1] - y[3]
    cell_polynomial(grid, *y, math.cos(phase), math.sin(phase))
    return ps, damper, grid, (math.cos(phase), math.sin(phase)), y


@pytest.mark.parametrize("which", range(4))
def test_the_polynomial_of_a_factor_is_the_factor(which):
    ps, damper, grid, (cosine, sine), _ = random_cell(np.random.default_rng(3))
    bend = response.factor_polynomial(ps, damper, grid, which)
    turn = ps.omega * grid.h
    values = []
    for x in SAMPLES:
        drive = cosine * math.cos(turn * x) - sine * math.sin(turn * x)
        values.append(powers_at(ps, damper, *at(grid.table, x), drive)[which])
    factors = [response.factor_at(grid.table, x) for x in SAMPLES]
    np.testing.assert_allclose(factors, values, rtol=0, atol=1e-12 * np.abs(values).max())
    second = np.diff(values, 2) / (SAMPLES[1] - SAMPLES[0]) ** 2
    assert np.abs(second).max() <= bend * (1 + 1e-3)


def breakers(*arguments):
    """Return `record_breakers` where it is asked, otherwise 0, as `fly` does."""
    return response.record_breakers(*arguments) if response.may_set_a_record(*arguments) else 0


def suspected(ps, damper, grid, y, length=1.0):
    """Check which energies are searched in the first cell of a period; return those that must be.

    They exceed what they are at the ends of the piece of so many cells, and the record is just
    less. What only rises or only falls is never searched, whatever the record.
    """
    cell_polynomial(grid, *y, 1.0, 0.0)
    bounds = bounds_of(ps, grid, scale_of(ps, damper, *y) + grid.push * grid.h)
    states = [at(grid.table, x) for x in length * SAMPLES]
    ends = (
        response.work_at(ps, damper, states[0], 1.0),
        response.work_at(ps, damper, states[-1], math.cos(ps.omega * grid.h * length)),
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
    for seed in range(40):
        ps, damper, grid, _, y = random_cell(np.random.default_rng(seed))
        seen |= suspected(ps, damper, grid, y)
        seen |= suspected(ps, damper, grid, y, 0.2 + 0.01 * seed)
    # the structure turns round in the middle of the cell, or the force on it vanishes there
    ps, damper, grid = flight_parts(**FORCED)
    half, p = 0.5 * grid.h, FORCED
    back = (p["P"] - p["k1"] * 0.05) / p["m1"]
    seen |= suspected(ps, damper, grid, np.array([0.05, -half * back, 0.0, 0.0]))
    r = (p["P"] - p["c1"] * 0.3 - p["c2"] * 0.5) / p["k2"] - half * 0.5
    seen |= suspected(ps, damper, grid, np.array([0.0, 0.3, r, 0.5]))
    assert seen == BOTH


@pytest.mark.parametrize("length", [1.0, 0.5])
def test_how_far_an_energy_may_rise_between_its_ends(length):
    """Level at both ends by M / 384, where the damper's M is another; by a third of power times
    time if powers are so large that this error is small.
    """
    ps, damper, grid, _, y = random_cell(np.random.default_rng(5))
    bounds = bounds_of(ps, grid, scale_of(ps, damper, *y))
    fourths = bounds.energy, response.damper_bound(grid, bounds.scale, 3.0)
    assert fourths[1] < bounds.energy * grid.table[OF_E2]
    for power, rises in (
        (0.0, [fourth * length**4 / 384 for fourth in fourths]),
        (1e6 * bounds.energy, [1e6 * bounds.energy * length * grid.h / 3] * 2),
    ):
        ends = (3.0, 3.0, power, power), (3.0, 3.0, -power, -power)
        for body, rise in enumerate(rises):
            for part, expected in ((0.99, 1 + body), (1.01, 0)):
                energy = np.full(2, 1e300)
                energy[body] = 3.0 + part * rise
                assert breakers(damper, energy, grid, bounds, length, *ends) == expected


@pytest.mark.parametrize("softer", [1e2, 1e4, 1e6])
def test_a_rise_of_the_dampers_energy_on_a_soft_structure_is_suspected(softer):
    """k2 (x1 - r)^2 / 2 rises by far more than the energy scale would allow a body of its own."""
    changes = {"P": 0.0, "c1": 0.0, "c2": 0.0, "k1": FORCED["k2"] / softer}
    ps, damper, grid = flight_parts(**{**FORCED, **changes})
    x1, r = 0.7 / math.sqrt(ps.k1), -0.7 / math.sqrt(damper.k2)
    v2 = -0.5 * grid.h * damper.k2 * r / damper.m2  # it turns round in the middle
    assert suspected(ps, damper, grid, np.array([x1, 0.0, r, -v2])) & 2


def largest_in(ps, damper, grid, y, angle, length):
    """Return the largest E1 and E2 over a flight of `length` cells from y, and its end."""
    x1, v1, r, s = map(Polynomial, expanded(ps, damper, grid, y, angle))
    values = []
    for e in (ps.m1 * v1**2 + ps.k1 * x1**2, damper.m2 * (v1 - s) ** 2 + damper.k2 * (x1 - r) ** 2):
        turns = e.deriv().roots()
        turns = turns[np.abs(turns.imag) < 1e-6].real
        places = np.clip([0.0, length, *turns], 0.0, length)
        values.append(0.5 * e(places).max())
    return np.array(values), tuple(p(length) for p in (x1, v1, r, s))


def flights(seed):
    """Yield pieces of a random orbit behind a rigid wall: as `fly` notes them, and as they are."""
    ps, damper, grid, _, y = random_cell(np.random.default_rng(seed), 1.0)
    y = (y[0], y[1], -abs(y[2]), y[3])
    wall = hertz_wall_at(0.3 * abs(y[2]), damper.inv_mu, kernel_cell(K=1e7))
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


@pytest.mark.parametrize("seed", range(60))
def test_the_largest_energies_of_flights_from_touch_to_touch(seed):
    """After each piece of an orbit, of any proportions. Notices: a peak that is not looked for."""
    for energy, truth in flights(seed):
        np.testing.assert_allclose(energy, truth, rtol=2e-13)
