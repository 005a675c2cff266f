"""The ends of orbits, numbers under a load, growth rates and recurrences, one kernel at a time."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import lfilter
from support import NOTHING, flight_parts, kernel_cell, linear_flow

from nlds_vines import IntegrationError, load_system, simulate
from nlds_vines.engine.batch import parts_of
from nlds_vines.kernels.cells import load_numbers
from nlds_vines.kernels.cells.cells import cells_for, run_cell
from nlds_vines.kernels.cells.load_orbit import PolynomialLoad, ends_of_cell, lasts_until, touch_by
from nlds_vines.kernels.cells.verdict import digits_of, mean_and_width
from nlds_vines.kernels.events import contact
from nlds_vines.kernels.events.exact import fly
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.flight import REACH
from nlds_vines.kernels.motion.load_cells import LOAD_ROW, sums_of
from nlds_vines.kernels.orbit import orbit
from nlds_vines.kernels.orbit.orbit import HUGE, STATE_SIZE, bounded, set_mode
from nlds_vines.kernels.orbit.repetition import TOLERANCE, period_of
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.scene import CellBuffers, Flight, Parts, Span, Structure
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, RELEASE, TOUCH, Impacts
from nlds_vines.model.scenes import SCENES


@pytest.mark.parametrize(
    ("module", "budget", "most", "changes"),
    [(contact, "MOST_STEPS", 3, {"K": 1e4}), (orbit, "MOST_TOUCHES", 0, {})],
)
def test_an_orbit_that_spends_its_budget_is_stopped(module, budget, most, changes, monkeypatch):
    system = load_system("ssul-set6", **changes)
    assert len(simulate(system, 4).impacts) > 0
    monkeypatch.setattr(module, budget, most)
    with pytest.raises(IntegrationError, match="step_budget"):
        simulate(system, 4)


@pytest.mark.parametrize("place", range(4))
def test_states_are_bounded(place):
    state = np.zeros(4)
    for value in (0.9 * HUGE, 1.1 * HUGE, -1.1 * HUGE, math.inf, -math.inf, math.nan):
        state[place] = value
        assert bounded(*state) == (value == 0.9 * HUGE)
    assert math.isfinite(HUGE * HUGE)  # its energy is a number


@pytest.mark.parametrize("wanted", ["energy", "peak"])
@pytest.mark.parametrize("kind", ["none", "ssul"])
def test_an_energy_beyond_all_numbers_is_no_result(kind, wanted):
    p = {"m1": 1e12, "k1": 1e12, "m2": 1.0, "k2": 1.0, "omega": 1.0, "K": 1.0, "near": 1.0}
    cell, parts = kernel_cell(**p), parts_of("exact", SCENES[kind])
    for speed, status in ((1e140, codes.OK), (1e149, codes.DIVERGED)):
        state = np.zeros(STATE_SIZE)
        state[1] = state[3] = speed if kind == "none" else -speed
        outcome = run_cell(parts, cell, state, Span(0, 0, 1), CellBuffers(**{wanted: np.zeros(2)}))
        assert outcome == status


def test_a_limit_that_is_no_number_is_refused():
    parts = parts_of("exact", SCENES["ssvi-b"])
    cell = load_system("ssbl").cell.copy()
    for limit in (1.0, math.nan, math.inf):
        cell.limit, buffers = limit, CellBuffers(violation=np.zeros(3))
        status = run_cell(parts, cell, np.zeros(STATE_SIZE), Span(0, 1, 1), buffers)
        assert status == (codes.OK if limit == 1.0 else codes.BAD_PARAMETERS)


def test_cells_are_a_multiple_of_the_stops():
    parts = Parts(*[None] * len(Parts._fields))
    for n, stops in itertools.product(range(1, 40), range(1, 20)):
        count = cells_for(parts, n, stops)
        assert count % stops == 0
        assert n <= count < n + stops


@pytest.mark.parametrize("x", [0.0, 0.25, 0.9])
def test_a_flight_may_begin_anywhere_in_a_cell(x):
    """Far from its walls, which both ends of the cell prove clear."""
    system = load_system("ssbl", C=5.0, D=5.0)
    cell = system.cell
    ps, damper, grid = flight_parts(**system.parameters)
    near, far = (hertz_wall_at(gap, damper.inv_mu, cell) for gap in (cell.near, cell.far))
    y, place = np.array([0.01, -0.2, 0.03, 0.4]), grid.h * (2 + x)
    flight = Flight(None, ps, damper, near, far, grid)
    event, j, left, *end = fly(flight, NOTHING, (2, x), 5, tuple(y))
    assert (event, j, left) == (codes.SECTION, 5, 0.0)
    angle = ps.omega * place
    user = [y[0], y[1], y[0] - y[2], y[1] - y[3], math.cos(angle), math.sin(angle)]
    x1, v1, x2, v2, *_ = expm(linear_flow(system.parameters) * (5 * grid.h - place)) @ user
    np.testing.assert_allclose(end, [x1, v1, x1 - x2, v1 - v2], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("r", "q", "mode"),
    [
        (0.0, 0.0, codes.FLYING),
        (0.1, 0.0, codes.FLYING),  # on the wall: a touch that the first flight finds
        (0.14, 0.2, codes.TOUCH_NEAR),
        (-0.2, 0.0, codes.FLYING),
        (-0.29, 0.3, codes.TOUCH_FAR),
    ],
)
def test_a_state_beyond_a_wall_is_inside_a_contact(r, q, mode):
    cell, state = kernel_cell(m1=1.0, m2=1.0, K=1.0), np.zeros(STATE_SIZE)
    state[2], state[4], state[5] = r, 9.0, 9.0
    set_mode(hertz_wall_at(0.1, 1.0, cell), hertz_wall_at(0.2, 1.0, cell), None, state)
    assert state[4] == pytest.approx(q, abs=1e-12)
    assert state[5] == mode


@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize(
    ("beyond", "s", "number"), [(0.01, -2.0, 1), (0.01, 2.0, 1), (-0.01, -2.0, 0)]
)
def test_a_start_beyond_a_limit_is_a_violation_of_the_first_instant(beyond, s, number, method):
    """Also where it moves back at once, where a sweep may carry a state."""
    system = load_system("ssbl", P=0.0, C=0.5, omega=40.0)
    parts, cell = parts_of(method, SCENES["ssvi-b"]), system.cell.copy()
    cell.limit = system.parameters["D"]
    state, violation = np.zeros(STATE_SIZE), np.zeros(3)
    state[2], state[3] = cell.limit + beyond, s
    buffers = CellBuffers(violation=violation)
    assert run_cell(parts, cell, state, Span(0, 1, 1), buffers) == codes.OK
    if not number:
        assert violation[2] == 0.0
        return
    assert (violation[0], violation[2]) == (0.0, 1.0)
    if s < 0.0:
        assert violation[1] == pytest.approx(beyond, rel=1e-12)
    else:
        assert violation[1] > 1.5 * beyond


def test_a_contact_lasts_from_its_touch_to_its_release():
    impacts, j, seen = Impacts(np.zeros((2, IMPACT_COLUMNS)), np.array([2])), -1, []
    impacts.data[:, TOUCH], impacts.data[:, RELEASE] = [1.0, 2.0], [1.5, 2.5]
    times = (0.9, 1.0, 1.4, 1.6, 2.2, 3.0, 1.2)  # the last one is looked for backward
    for time in times:
        j = touch_by(impacts, j, time)
        seen.append((j, lasts_until(impacts, j, time)))
    assert seen == [
        (-1, False), (0, True), (0, True), (0, False), (1, True), (1, False), (0, True),
    ]  # fmt: skip
    impacts.data[0, RELEASE] = math.nan  # ended by a jump: over when the next one begins
    assert lasts_until(impacts, touch_by(impacts, -1, 1.9), 1.9)
    assert not lasts_until(impacts, touch_by(impacts, -1, 2.6), 2.6)


def test_the_rms_leaves_out_what_is_before_the_time_to_settle():
    edges, sums = np.array([0.0, 1.0, 3.0, 4.0]), np.zeros((4, 5))
    sums[:, 4] = 0.0, 2.0, 6.0, 20.0
    for settle, rms in ((0.0, 5.0), (0.5, 6.0), (1.0, 6.0), (3.0, 14.0), (3.9, 14.0)):
        assert load_numbers.rms_of_x1(edges, sums, settle) == math.sqrt(rms)


def test_no_cell_holds_more_than_its_bound_says():
    """The largest of 801 places, of 80 random forces; the first would be missed without them."""
    rng, h = np.random.default_rng(6), REACH
    ps = Structure(1.0, 1.0, 1.0, 0.0, 1.0, 0.0, None, None)
    for i in range(80):
        rows, section = np.zeros(LOAD_ROW), np.zeros((2, 4))
        rows[: 1 + i % 4] = rng.normal(size=1 + i % 4)
        section[0, :2] = rng.normal(size=2) * 10.0 ** rng.uniform(-6.0, 0.5)
        if i == 0:  # from rest by 1 - 2 x
            rows[:2], section[0] = (1.0, -2.0), 0.0
        jumps = np.array([0.0, rng.normal()])  # of which the motion in the cell knows nothing
        load = PolynomialLoad(np.array([0.0, h]), rows, jumps, sums_of(rows), None)
        motion = load_numbers.motion_in(ps, None, load, section, 0)
        section[1, :2] = motion.sum(axis=0)
        section[1, 1] += jumps[1]
        places = np.linspace(0.0, 1.0, 801)
        most = max(load_numbers.excess_in_cell(ps, motion, 0.0, x) for x in places)
        ends = ends_of_cell(ps, None, load, section, 0)
        assert load_numbers.may_exceed(most * (1.0 - 1e-12), h, ends, False, False)
        assert ends[2] >= most


def test_the_ends_of_a_cell_are_before_a_jump_at_its_end():
    ps = Structure(2.0, 3.0, 0.0, 0.0, 1.0, 0.0, None, None)
    rows, jumps = np.zeros(2 * LOAD_ROW), np.array([7.0, 5.0, 0.0])
    section = np.array([[0.1, 0.2, 0.0, 0.0], [0.3, 5.4, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    load = PolynomialLoad(np.array([0.0, 0.5, 1.0]), rows, jumps, sums_of(rows), None)
    begin, end, _, _ = ends_of_cell(ps, None, load, section, 0)
    twice = ps.m1 * np.array([0.2, 5.4 - 5.0]) ** 2 + ps.k1 * np.array([0.1, 0.3]) ** 2
    assert (begin[0], end[0]) == pytest.approx(tuple(0.5 * twice))
    # a contact may bring all energy of its cell, and more if it has begun before
    h, begin, end = 0.5, (3.0, 0.0, -1.0), (2.0, 0.0, 4.0)
    for order in ((begin, end), (end, begin)):
        assert load_numbers.may_exceed(9.99, h, (*order, 10.0, 0.0), True, False)
        assert not load_numbers.may_exceed(9.99, h, (*order, 9.9, 0.0), True, False)
        # what it holds is unknown
        assert load_numbers.may_exceed(9.99, h, (*order, 0.0, 0.0), True, True)


def test_an_energy_is_last_above_a_level_at_the_root_of_its_polynomial():
    ps = SimpleNamespace(m1=2.0, k1=0.0)
    motion = np.zeros((15, 2))
    motion[0, 1], motion[1, 1] = 1.0, -1.0  # v1 = 1 - x, E1 = (1 - x)^2
    assert load_numbers.last_place_above(ps, motion, 0.25) == pytest.approx(0.5, abs=1e-15)
    assert load_numbers.last_place_above(ps, motion, -1.0) == 1.0
    assert load_numbers.last_place_above(ps, motion, 1.5) == load_numbers.NO_PLACE
    motion[1, 1], motion[2, 1] = 1.2, -1.0  # v1 = 1 + 1.2 x - x^2, below 1.3 at both ends
    root = 0.6 + math.sqrt(0.06)
    assert load_numbers.last_place_above(ps, motion, 1.3**2) == pytest.approx(root, abs=1e-15)
    assert load_numbers.place_of_most(ps, motion) == pytest.approx(0.6, abs=1e-15)


GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def logistic(r, count, skip=500):
    """Return an orbit of x -> r x (1 - x) and the logarithms of its growth per iteration."""
    x, orbit = 0.3, np.empty(count)
    for i in range(skip + count):
        x = r * x * (1.0 - x)
        if i >= skip:
            orbit[i - skip] = x
    return orbit, np.log(np.abs(r * (1.0 - 2.0 * orbit)))


def torus(count):
    """Return a smooth function along a rotation by the golden mean."""
    angle = 2.0 * math.pi * GOLDEN * np.arange(count)
    return np.exp(np.cos(angle)) * np.sin(angle + 0.3)


def noise(count):
    return np.random.default_rng(1).normal(size=count)


def as_section(values):
    return np.stack([values, values**2], axis=-1)


def test_a_mean_is_as_wide_as_the_means_of_sixteen_pieces_tell():
    """All but the first twentieth, in pieces of equal length that end with the sequence."""
    values = noise(1000)
    pieces = values[1000 - 16 * (950 // 16) :].reshape(16, -1).mean(axis=1)
    mean, width = mean_and_width(values)
    assert mean == pytest.approx(pieces.mean(), rel=1e-12)
    assert width == pytest.approx(2.947 * pieces.std(ddof=1) / 4.0, rel=1e-12)
    for count, is_finite in ((33, True), (32, False)):  # 32 and 31 values: two a piece, or fewer
        assert math.isfinite(mean_and_width(values[:count])[1]) == is_finite
    # the exponent of the logistic map is ln 2
    mean, width = mean_and_width(logistic(4.0, 6000)[1])
    assert abs(mean - math.log(2.0)) <= width < 0.05
    # growth that ends is minus infinity, and sure
    logs = np.append(np.zeros(500), np.full(500, -np.inf))
    assert mean_and_width(logs) == (-np.inf, 0.0)
    # too short a sequence has no interval
    assert mean_and_width(np.ones(20)) == pytest.approx((math.nan, math.inf), nan_ok=True)
    # A variation aligns there; afterwards every value does, the last one included
    logs = np.full(1600, 0.5)
    assert mean_and_width(logs) == (0.5, 0.0)
    logs[:79] = 1e6
    assert mean_and_width(logs) == (0.5, 0.0)
    logs[-1] = 1e6
    assert mean_and_width(logs)[0] > 1.0


@pytest.mark.parametrize(("r", "n"), [(3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3)])
def test_the_exponent_of_a_periodic_window_is_that_of_its_multiplier(r, n):
    orbit, logs = logistic(r, 4800)
    mean, width = mean_and_width(logs)
    multiplier = np.prod(r * (1.0 - 2.0 * orbit[-n:]))
    assert abs(mean - math.log(abs(multiplier)) / n) <= max(width, 1e-9) + 0.01
    assert mean + width < 0.0
    assert period_of(as_section(orbit[:200]), TOLERANCE) == n


def test_the_interval_holds_the_mean_in_as_many_cases_as_it_claims():
    generator, hits = np.random.default_rng(7), 0
    for _ in range(400):  # a sequence whose values depend on their predecessors
        values = lfilter([1.0], [1.0, -0.7], generator.normal(size=1600))
        mean, width = mean_and_width(values)
        hits += abs(mean) <= width
    assert 0.975 <= hits / 400 < 1.0  # 99 % but for three standard errors


def test_averages_on_a_torus_have_many_digits_in_any_unit_and_others_do_not():
    assert digits_of(torus(600)) > 7.0
    assert digits_of(torus(2400)) > 10.0
    assert digits_of(logistic(4.0, 2400)[0]) < 4.0
    assert digits_of(noise(2400)) < 4.0
    assert digits_of(torus(2400) + 1e-3 * noise(2400)) < 7.0
    assert digits_of(np.ones(100)) == 15.0
    for values in (torus(600), noise(600)):
        for unit in (1e-9, 1e9):
            assert digits_of(unit * values) == pytest.approx(digits_of(values), abs=1e-3)


def test_a_period_is_that_of_all_components_and_found_where_there_is_one():
    for n in (1, 2, 3, 7, 40):
        base = np.random.default_rng(n).uniform(size=n)
        assert period_of(as_section(np.resize(base, 120)), TOLERANCE) == n
    one, other = np.resize([1.0, 2.0], 120), np.resize([1.0, 2.0, 3.0], 120)
    for pair, n in (((one, other), 6), ((other, one), 6), ((one, noise(120)), 0)):
        assert period_of(np.stack(pair, axis=-1), TOLERANCE) == n
    for values in (torus(120), noise(120), logistic(4.0, 120)[0]):
        assert period_of(as_section(values), TOLERANCE) == 0
        assert period_of(as_section(np.resize(values[:50], 120)), TOLERANCE) == 0  # too long
