"""The ends of orbits, one kernel at a time: budgets, numbers beyond all bounds, linear algebra.

Constants are changed here as only plain Python allows. (Run by `contract/test_plain.py`.)
"""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from support import NOTHING, kernel_cell, linear_flow

from nlds_vines.kernels.cells.cells import cells_for, run_cell
from nlds_vines.kernels.events import contact
from nlds_vines.kernels.events.exact import fly
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.flight import PERIOD, cells_of, grid_from
from nlds_vines.kernels.numerics import matrices
from nlds_vines.kernels.orbit import orbit
from nlds_vines.kernels.orbit.orbit import HUGE, STATE_SIZE, bounded, set_mode
from nlds_vines.kernels.scene.codes import (
    BAD_PARAMETERS,
    DIVERGED,
    FLYING,
    OK,
    SECTION,
    TOUCH_FAR,
    TOUCH_NEAR,
)
from nlds_vines.kernels.scene.scene import (
    CellBuffers,
    Flight,
    Parts,
    Span,
    damper_in,
    structure_under,
)
from nlds_vines.model.catalog import load_system
from nlds_vines.model.scenes import SCENES
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.simulation import IntegrationError, simulate

# ---- budgets -------------------------------------------------------------------------------------


def test_a_contact_that_spends_its_steps_is_not_gone_on_with(monkeypatch):
    system = load_system("ssul-set6", K=1e4)
    assert len(simulate(system, 4).impacts) > 0
    monkeypatch.setattr(contact, "MOST_STEPS", 3)
    with pytest.raises(IntegrationError, match="step_budget"):
        simulate(system, 4)


def test_touches_without_end_are_stopped(monkeypatch):
    system = load_system("ssul-set6")
    assert len(simulate(system, 4).impacts) > 0
    monkeypatch.setattr(orbit, "MOST_TOUCHES", 0)
    with pytest.raises(IntegrationError, match="step_budget"):
        simulate(system, 4)


# ---- numbers beyond all bounds -------------------------------------------------------------------


@pytest.mark.parametrize("place", range(4))
def test_states_are_bounded(place):
    state = np.zeros(4)
    for value, fine in ((0.9 * HUGE, True), (1.1 * HUGE, False), (-1.1 * HUGE, False)):
        state[place] = value
        assert bounded(*state) == fine
    for value in (math.inf, -math.inf, math.nan):
        state[place] = value
        assert not bounded(*state)
    assert math.isfinite(HUGE * HUGE)  # its energy is a number


@pytest.mark.parametrize("wanted", ["energy", "peak"])
@pytest.mark.parametrize("kind", ["none", "ssul"])
def test_an_energy_beyond_all_numbers_is_no_result(kind, wanted):
    p = {"m1": 1e12, "k1": 1e12, "m2": 1.0, "k2": 1.0, "omega": 1.0, "K": 1.0, "near": 1.0}
    cell, parts = kernel_cell(**p), parts_of("exact", SCENES[kind])
    for speed, status in ((1e140, OK), (1e149, DIVERGED)):
        state = np.zeros(STATE_SIZE)
        state[1] = state[3] = speed if kind == "none" else -speed
        outcome = run_cell(parts, cell, state, Span(0, 0, 1), CellBuffers(**{wanted: np.zeros(2)}))
        assert outcome == status


def test_a_limit_that_is_no_number_is_refused():
    parts = parts_of("exact", SCENES["ssvi-b"])
    cell = load_system("ssbl").cell.copy()
    for limit, status in ((1.0, OK), (math.nan, BAD_PARAMETERS), (math.inf, BAD_PARAMETERS)):
        cell.limit = limit
        buffers = CellBuffers(violation=np.zeros(3))
        assert run_cell(parts, cell, np.zeros(STATE_SIZE), Span(0, 1, 1), buffers) == status


# ---- flights -------------------------------------------------------------------------------------


@pytest.mark.parametrize("x", [0.0, 0.25, 0.9])
def test_a_flight_may_begin_anywhere_in_a_cell(x):
    """Far from its walls, which both ends of the cell prove clear."""
    system = load_system("ssbl", C=5.0, D=5.0)
    cell = system.cell
    ps, damper = structure_under(None, cell), damper_in(cell)
    grid = grid_from(ps, damper, cells_of(ps, damper), PERIOD)
    inv_mu = damper_in(cell).inv_mu
    near, far = hertz_wall_at(cell.near, inv_mu, cell), hertz_wall_at(cell.far, inv_mu, cell)
    y, place = np.array([0.01, -0.2, 0.03, 0.4]), grid.h * (2 + x)
    flight = Flight(None, ps, damper, near, far, grid)
    event, j, left, *end = fly(flight, NOTHING, (2, x), 5, tuple(y))
    assert (event, j, left) == (SECTION, 5, 0.0)
    angle = ps.omega * place
    user = [y[0], y[1], y[0] - y[2], y[1] - y[3], math.cos(angle), math.sin(angle)]
    x1, v1, x2, v2, *_ = expm(linear_flow(system.parameters) * (5 * grid.h - place)) @ user
    np.testing.assert_allclose(end, [x1, v1, x1 - x2, v1 - v2], rtol=0, atol=1e-12)


# ---- beginnings ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("r", "q", "mode"),
    [
        (0.0, 0.0, FLYING),
        (0.1, 0.0, FLYING),  # on the wall: a touch that the first flight finds
        (0.14, 0.2, TOUCH_NEAR),
        (-0.2, 0.0, FLYING),
        (-0.29, 0.3, TOUCH_FAR),
    ],
)
def test_a_state_beyond_a_wall_is_inside_a_contact(r, q, mode):
    cell, state = kernel_cell(m1=1.0, m2=1.0, K=1.0), np.zeros(STATE_SIZE)
    state[2], state[4], state[5] = r, 9.0, 9.0
    set_mode(hertz_wall_at(0.1, 1.0, cell), hertz_wall_at(0.2, 1.0, cell), state)
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
    assert run_cell(parts, cell, state, Span(0, 1, 1), buffers) == OK
    if not number:
        assert violation[2] == 0.0
        return
    assert (violation[0], violation[2]) == (0.0, 1.0)
    if s < 0.0:
        assert violation[1] == pytest.approx(beyond, rel=1e-12)
    else:
        assert violation[1] > 1.5 * beyond


def test_cells_are_a_multiple_of_the_stops():
    parts = Parts(*[None] * len(Parts._fields))
    for n in range(1, 40):
        for stops in range(1, 20):
            count = cells_for(parts, n, stops)
            assert count % stops == 0
            assert n <= count < n + stops


# ---- variations ----------------------------------------------------------------------------------


def test_elimination_exchanges_rows_for_a_small_pivot():
    """Without, 1e-20 as pivot would leave no digit of the first unknown."""
    right = np.array([[1.0], [3.0]])
    assert matrices.solve(np.array([[1e-20, 1.0], [1.0, 2.0]]), right)
    np.testing.assert_allclose(right, [[1.0], [1.0]], rtol=1e-12)
