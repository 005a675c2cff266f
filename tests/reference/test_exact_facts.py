"""What is known without a simulation: steady states, energies, symmetries, admissibility."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from support import (
    FULL,
    amplitudes,
    follow_ssbl,
    follow_ssul,
    kernel_cell,
    linear_flow,
    references,
    run_cell_rows,
    shortening,
    steady_state,
    system_of,
)

from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.simulation import simulate

SET6 = references()["ssul-set6"].numbers
STEEL = references()["ssul-set6-steel"].numbers["K"]
LINEAR = ("section", "energy")


# ---- linear steady states ------------------------------------------------------------------------


def largest_energy(mass, stiffness, omega, amplitude):
    return max(stiffness, mass * omega**2) * abs(amplitude) ** 2 / 2


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("name", ["none", "tmd"])
@pytest.mark.parametrize("omega", [6.21, 6.28, 9.0])
def test_steady_state(name, omega, method):
    system = load_system(name, omega=omega)
    p = system.parameters
    bound = 1e-10 if method == "exact" else 1e-8
    options = {} if method == "exact" else {"period_steps": 1024.0}
    orbit = simulate(system, 3, transient=300, record=LINEAR, method=method, **options)
    X = amplitudes(p)
    np.testing.assert_allclose(orbit.section, np.tile(steady_state(p), (3, 1)), rtol=0, atol=bound)
    assert orbit.E1max == pytest.approx(largest_energy(p["m1"], p["k1"], omega, X[0]), rel=bound)
    if name == "tmd":
        expected = largest_energy(p["m2"], p["k2"], omega, X[1])
        assert orbit.E2max == pytest.approx(expected, rel=bound)


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("samples", [8, 7])
@pytest.mark.parametrize("name", ["none", "tmd"])
def test_sections_within_a_period(name, samples, method):
    """Each share of a period has its own phase of the forcing."""
    system, options = load_system(name), {} if method == "exact" else {"period_steps": 1024.0}
    p = system.parameters
    orbit = simulate(
        system, 2, start=steady_state(p), record=("trajectory",), samples=samples, method=method,
        **options,
    )  # fmt: skip
    turned = np.exp(1j * p["omega"] * orbit.time)[:, np.newaxis] * amplitudes(p)
    expected = np.stack([turned.real, (1j * p["omega"] * turned).real], axis=-1)
    np.testing.assert_allclose(
        orbit.trajectory, expected.reshape(2 * samples, -1), rtol=0, atol=1e-9
    )


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("name", "omega", "joules", "digits"),
    [("none", 6.28, 1568.00, 2), ("tmd", 6.28, 635.107, 3), ("tmd", 6.21, 660.435, 3)],
)
def test_published_energies(name, omega, joules, digits):
    orbit = simulate(load_system(name, omega=omega), 3, transient=300, record=LINEAR)
    assert round(orbit.E1max, digits) == joules


@pytest.mark.kernels
def test_phase_of_the_section_after_100000_periods():
    system = load_system("none")
    orbit = simulate(system, 1, transient=100_000, record=("section",))
    expected = steady_state(system.parameters)
    np.testing.assert_allclose(orbit.section[0], expected, rtol=0, atol=1e-10)


@pytest.mark.kernels
def test_undamped_resonance_grows_without_end():
    """x1 = P t sin(omega t) / (2 m1 omega), at t = nT x1 = 0 and v1 = P t / (2 m1)."""
    system = load_system("none", c1=0.0, omega=np.sqrt(39.5))
    orbit = simulate(system, 200, record=LINEAR)
    speed = system.parameters["P"] / (2 * system.parameters["m1"])
    times = system.period * np.arange(1, 201)
    np.testing.assert_allclose(orbit.section[:, 1], speed * times, rtol=1e-10)
    np.testing.assert_allclose(orbit.section[:, 0], 0, atol=1e-10)


@pytest.mark.kernels
@pytest.mark.parametrize(
    "changes",
    [
        {"k2": 215.0, "c2": 232.0},
        {"k2": 215.0, "c2": 2 * np.sqrt(215.0 * 60 * 1000 / 1060)},  # critically damped
        {"k2": 0.0, "c2": 0.0},  # a free mass: the double rate 0 has one eigenvector
        {"k2": 0.0, "c2": 262.0},
        {"k1": 0.0, "c1": 0.0},
    ],
)
def test_defective_and_degenerate_flights(changes):
    system = load_system("tmd", **changes)
    start = np.array([0.01, -0.2, 0.03, 0.4])
    orbit = simulate(system, 5, start=start, record=LINEAR)
    flow = linear_flow(system.parameters)
    period = expm(flow * system.period / 64)
    y = np.array([*start, 1, 0])
    for section in orbit.section:
        for _ in range(64):
            y = period @ y
        np.testing.assert_allclose(section, y[:4], rtol=0, atol=1e-10)


# ---- the impact-free orbit of the SSul damper ----------------------------------------------------


def on_steady_state(omega, periods, record=FULL):
    p = {**SET6, "omega": omega}
    start = steady_state(p, p["V"] + p["C"])
    return p, start, simulate(system_of("ssul", p), periods, start=start, record=record)


@pytest.mark.kernels
@pytest.mark.parametrize("omega", [7.97, 9.0])
def test_impact_free_orbit(omega):
    p, expected, orbit = on_steady_state(omega, 100)
    assert len(orbit.impacts) == 0
    np.testing.assert_allclose(orbit.section, np.tile(expected, (100, 1)), rtol=0, atol=1e-10)
    X = amplitudes(p)
    assert orbit.E1max == pytest.approx(largest_energy(p["m1"], p["k1"], omega, X[0]), rel=1e-10)
    assert orbit.E2max == pytest.approx(largest_energy(p["m2"], p["k2"], omega, X[1]), rel=1e-10)
    assert orbit.clearance == pytest.approx(p["C"] - shortening(p), abs=1e-12)


@pytest.mark.parametrize("omega", [7.97, 9.0])
def test_rest_leads_to_the_impact_free_orbit(omega):
    p = {**SET6, "omega": omega}
    orbit = follow_ssul(p, None, 3, transient=300)
    assert len(orbit.impacts) == 0
    expected = steady_state(p, p["V"] + p["C"])
    np.testing.assert_allclose(orbit.section, np.tile(expected, (3, 1)), rtol=0, atol=1e-10)


@pytest.mark.kernels
def test_admissible_above_and_not_below():
    boundary = brentq(lambda omega: shortening({**SET6, "omega": omega}) - SET6["C"], 7.4, 7.6)
    assert round(boundary, 4) == 7.4596
    assert len(on_steady_state(boundary * (1 + 1e-7), 20)[2].impacts) == 0
    assert len(on_steady_state(boundary * (1 - 1e-7), 20)[2].impacts) > 0


# ---- energy --------------------------------------------------------------------------------------


def mechanical_energy(p, states):
    """Return the energy [J] of both masses, both springs and the contact."""
    x1, v1, x2, v2 = np.atleast_2d(states).T
    z = np.maximum(p["V"] - (x2 - x1), 0)
    stretch = x2 - x1 - p["V"] - p["C"]
    kinetic = p["m1"] * v1**2 + p["m2"] * v2**2
    return (kinetic + p["k1"] * x1**2 + p["k2"] * stretch**2) / 2 + 0.4 * p["K"] * z**2.5


@pytest.mark.parametrize(
    "K",
    [
        1e6,  # stepped contacts
        SET6["K"],  # short impacts
        STEEL,
    ],
)
def test_energy_is_constant_without_damping_and_forcing(K):
    p = {**SET6, "c1": 0.0, "c2": 0.0, "P": 0.0, "K": K}
    start = np.array([0.0, 0.3, p["V"] + p["C"], 0.0])
    orbit = follow_ssul(p, start, 10_000, contact_steps=60.0, nodes=20)
    assert len(orbit.impacts) > 5000
    drift = mechanical_energy(p, orbit.section) / mechanical_energy(p, start) - 1
    assert np.abs(drift).max() <= 1e-9


# ---- symmetries ----------------------------------------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_mirrored_walls_mirror_the_orbit_bit_by_bit(method):
    """Unforced, with the walls exchanged: equation (5) is odd."""
    numbers = {**references()["ssbl-omega6.05"].numbers, "P": 0.0, "c1": 0.0, "c2": 0.0}
    start = np.array([0.01, 1.0, -0.02, 1.5])
    one = kernel_cell(**numbers, near=0.03, far=0.05)
    other = kernel_cell(**numbers, near=0.05, far=0.03)
    section, rows = run_cell_rows(one, start, 30, method)
    mirrored, mirrored_rows = run_cell_rows(other, -start, 30, method)
    assert {0.0, 1.0} == set(rows[:, 0])
    np.testing.assert_array_equal(mirrored, -section)
    np.testing.assert_array_equal(mirrored_rows[:, 1:], rows[:, 1:])
    np.testing.assert_array_equal(mirrored_rows[:, 0], 1 - rows[:, 0])


@pytest.mark.kernels
def test_two_distant_walls_are_no_walls():
    numbers = {**references()["ssbl-omega6.05"].numbers, "C": 10.0, "D": 10.0}
    section, rows = follow_ssbl(numbers, 20)
    free = simulate(load_system("tmd", k2=215.0, c2=232.0, omega=6.05), 20, record=("section",))
    assert len(rows) == 0
    np.testing.assert_allclose(section - [0, 0, 10.0, 0], free.section, rtol=0, atol=1e-13)
