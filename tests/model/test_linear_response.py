"""The steady state without contact, against a solution by matrices and the exponential."""

import numpy as np
import pytest
from scipy.linalg import expm
from support import amplitudes, linear_flow
from support import steady_state as expected_state

from nlds_vines.model.catalog import load_system
from nlds_vines.model.linear_response import (
    energy_alone,
    flow_matrix,
    response,
    steady_state,
)

NAMES = ("none", "tmd", "ssul-set6", "ssbl")
OMEGA = np.array([0.5, 3.0, 6.28, 6.5, 9.0, 40.0])


@pytest.mark.parametrize("name", NAMES)
def test_amplitudes_at_any_frequency(name):
    system = load_system(name)
    linear = response(system, OMEGA)
    for i, omega in enumerate(OMEGA):
        X = amplitudes({**system.parameters, "omega": omega})
        assert linear.X1[i] == pytest.approx(X[0], rel=1e-12)
        p, square = system.parameters, abs(X[0]) ** 2
        assert linear.E1max[i] == pytest.approx(max(p["k1"], p["m1"] * omega**2) * square / 2)
        if name == "none":
            assert linear.X2 is None
            assert linear.shortening[i] == 0.0
        else:
            assert linear.X2[i] == pytest.approx(X[1], rel=1e-12)
            assert linear.shortening[i] == pytest.approx(abs(X[0] - X[1]), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_the_steady_state_returns_after_a_period(name):
    system = load_system(name)
    state = steady_state(system)
    np.testing.assert_allclose(state, expected_state(system.parameters, system.rest or 0.0))
    if len(state) == 4:
        y = np.array([*state, 1.0, 0.0])
        y[2] -= system.rest
        flow = flow_matrix(system)
        np.testing.assert_allclose(flow, linear_flow(system.parameters), rtol=1e-14)
        np.testing.assert_allclose(expm(flow * system.period) @ y, y, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("C", "D"), [(0.02, 0.06), (0.06, 0.02), (0.06, 0.06)])
def test_the_nearer_wall_decides_whether_it_clears(C, D):
    system = load_system("ssbl", C=C, D=D)
    linear = response(system, np.linspace(1.0, 60.0, 600))
    expected = linear.shortening <= min(C, D)
    np.testing.assert_array_equal(linear.clears, expected)
    assert 0 < np.count_nonzero(expected) < expected.size
    assert response(load_system("tmd"), OMEGA).clears.all()


def test_a_resonance_without_damping_has_no_steady_state():
    omega = 2.0
    system = load_system("none", c1=0.0, m1=1000.0, k1=4000.0)
    linear = response(system, np.array([omega, 2 * omega]))
    assert np.isinf(linear.X1[0])
    assert np.isfinite(linear.X1[1])
    silent = response(system.with_(P=0.0), np.array([omega]))
    assert silent.X1[0] == 0.0


def test_the_structure_alone_is_the_reference():
    systems = [load_system("tmd", omega=omega) for omega in OMEGA]
    energy = energy_alone(np.array([system.cells() for system in systems]))
    np.testing.assert_allclose(energy.ravel(), response(load_system("none"), OMEGA).E1max)
