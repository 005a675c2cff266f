"""What is known without a simulation: steady states, energies, symmetries, admissibility."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from support import (
    BOTH,
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

from nlds_vines.engine.simulation import simulate
from nlds_vines.model.catalog import load_system
from nlds_vines.model.linear_response import energy_alone
from scans import computed, scan_of

SET6 = references()["ssul-set6"].numbers
SSBL = references()["ssbl-omega6.05"].numbers
DAMPERS = {"ssul": SET6, "ssbl": SSBL}
STEEL = references()["ssul-set6-steel"].numbers["K"]
LINEAR = ("section", "energy")


# ---- linear steady states ------------------------------------------------------------------------


def largest_energy(mass, stiffness, omega, amplitude):
    return max(stiffness, mass * omega**2) * abs(amplitude) ** 2 / 2


PUBLISHED = {("none", 6.28): (1568.00, 2), ("tmd", 6.28): (635.107, 3), ("tmd", 6.21): (660.435, 3)}
"""E1max [J] to so many digits."""


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
    joules, digits = PUBLISHED.get((name, omega), (orbit.E1max, None))
    assert digits is None or round(orbit.E1max, digits) == joules
    if name == "tmd":
        expected = largest_energy(p["m2"], p["k2"], omega, X[1])
        assert orbit.E2max == pytest.approx(expected, rel=bound)


@pytest.mark.plain
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("samples", [8, 7])
@pytest.mark.parametrize("name", ["none", "tmd"])
def test_sections_within_a_period(name, samples, method):
    """Each share of a period has its own phase of the forcing."""
    system, options = load_system(name), {} if method == "exact" else {"period_steps": 1024.0}
    p = system.parameters
    options |= {"method": method, "samples": samples, "record": ("trajectory",)}
    orbit = simulate(system, 2, start=steady_state(p), **options)
    turned = np.exp(1j * p["omega"] * orbit.time)[:, np.newaxis] * amplitudes(p)
    expected = np.stack([turned.real, (1j * p["omega"] * turned).real], axis=-1)
    expected = expected.reshape(2 * samples, -1)
    np.testing.assert_allclose(orbit.trajectory, expected, rtol=0, atol=1e-9)


@pytest.mark.kernels
def test_phase_of_the_section_after_100000_periods():
    system = load_system("none")
    orbit = simulate(system, 1, transient=100_000, record=LINEAR)
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
    period = np.linalg.matrix_power(expm(flow * system.period / 64), 64)
    y = np.array([*start, 1, 0])
    for section in orbit.section:
        y = period @ y
        np.testing.assert_allclose(section, y[:4], rtol=0, atol=1e-10)


# ---- the impact-free orbit -----------------------------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("kind", "omega"),
    [("ssul", 7.97), ("ssul", 9.0), *(("ssbl", omega) for omega in (5.0, 5.2, 7.15, 8.0))],
)
def test_rest_leads_to_the_impact_free_orbit(kind, omega):
    p = {**DAMPERS[kind], "omega": omega}
    system = system_of(kind, p)
    orbit = simulate(system, 100, transient=300, record=FULL if kind == "ssul" else BOTH)
    assert len(orbit.impacts) == 0
    expected = np.tile(steady_state(p, system.rest), (100, 1))
    np.testing.assert_allclose(orbit.section, expected, rtol=0, atol=1e-10)
    if kind == "ssul":
        energies = [
            largest_energy(p[f"m{i}"], p[f"k{i}"], omega, amplitudes(p)[i - 1]) for i in (1, 2)
        ]
        assert [orbit.E1max, orbit.E2max] == pytest.approx(energies, rel=1e-10)
        assert orbit.clearance == pytest.approx(p["C"] - shortening(p), abs=1e-12)


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("kind", "boundary", "bracket", "inward", "wall"),
    [
        ("ssul", 7.4596, (7.4, 7.6), -1, "obstacle"),
        ("ssbl", 5.2658, (5.0, 5.6), 1, "structure"),
        ("ssbl", 7.0981, (6.8, 7.3), -1, "structure"),
    ],
)
def test_where_the_impact_free_orbit_is_admissible(kind, boundary, bracket, inward, wall):
    """The amplitude of x2 - x1, from linear algebra, must be below the smallest clearance."""
    numbers = DAMPERS[kind]
    gap = min(numbers["C"], numbers.get("D", np.inf))
    exact = brentq(lambda omega: shortening({**numbers, "omega": omega}) - gap, *bracket)
    assert round(exact, 4) == boundary
    for side, walls in ((1, {wall}), (-1, set())):
        p = {**numbers, "omega": exact * (1 + side * inward * 1e-7)}
        system = system_of(kind, p)
        record = FULL if kind == "ssul" else BOTH  # kernels of the test above
        orbit = simulate(system, 20, start=steady_state(p, system.rest), record=record)
        assert set(orbit.impacts["wall"]) == walls


def mechanical_energy(p, states):
    """Return the energy [J] of both masses, both springs and the contact."""
    x1, v1, x2, v2 = np.atleast_2d(states).T
    z = np.maximum(p["V"] - (x2 - x1), 0)
    stretch = x2 - x1 - p["V"] - p["C"]
    kinetic = p["m1"] * v1**2 + p["m2"] * v2**2
    return (kinetic + p["k1"] * x1**2 + p["k2"] * stretch**2) / 2 + 0.4 * p["K"] * z**2.5


@pytest.mark.parametrize("K", [1e6, SET6["K"], STEEL])  # stepped contacts, then short impacts
def test_energy_is_constant_without_damping_and_forcing(K):
    p = {**SET6, "c1": 0.0, "c2": 0.0, "P": 0.0, "K": K}
    start = np.array([0.0, 0.3, p["V"] + p["C"], 0.0])
    orbit = follow_ssul(p, start, 10_000, contact_steps=60.0, nodes=20)
    assert len(orbit.impacts) > 5000
    drift = mechanical_energy(p, orbit.section) / mechanical_energy(p, start) - 1
    assert np.abs(drift).max() <= 1e-9


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_mirrored_walls_mirror_the_orbit_bit_by_bit(method):
    """Unforced, with the walls exchanged: equation (5) is odd."""
    numbers = {**SSBL, "P": 0.0, "c1": 0.0, "c2": 0.0}
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
    numbers = {**SSBL, "C": 10.0, "D": 10.0}
    section, rows = follow_ssbl(numbers, 20)
    free = simulate(load_system("tmd", k2=215.0, c2=232.0, omega=6.05), 20, record=LINEAR)
    assert len(rows) == 0
    np.testing.assert_allclose(section - [0, 0, 10.0, 0], free.section, rtol=0, atol=1e-13)


FREE = {"c1": 0.0, "c2": 0.0, "P": 0.0}
PEAKS = ("energy", "peak")
FINEST = {"nodes": 24, "contact_steps": 64.0}


def energies(p, state, rest):
    """Return E1 and E2 [J] of equation (6)."""
    x1, v1, x2, v2 = state
    e1 = (p["m1"] * v1**2 + p["k1"] * x1**2) / 2
    return np.array([e1, (p["m2"] * v2**2 + p["k2"] * (x2 - rest) ** 2) / 2])


# ---- what an impact passes on --------------------------------------------------------------------


@pytest.mark.parametrize("K", [1e5, SET6["K"], STEEL, 1e10 * SET6["K"]])
@pytest.mark.parametrize(("v1", "s"), [(0.4, 1.5), (-0.4, 1.5), (0.1, 0.05)])
def test_gains_are_differences_of_the_energies(K, v1, s):
    """The start lies on the wall, and the second run has its section at the release."""
    p, rest = {**SET6, **FREE, "K": K, "omega": 1.0}, SET6["V"] + SET6["C"]
    touch = np.array([0.0, v1, p["V"], v1 - s])
    row = simulate(system_of("ssul", p), 1, start=touch, record=BOTH, **FINEST).impacts[0]
    assert row["touch"] == 0.0
    system = system_of("ssul", {**p, "omega": 2 * np.pi / row["release"]})
    (release,) = simulate(system, 1, start=touch, record=BOTH, **FINEST).section
    before, after = energies(p, touch, rest), energies(p, release, rest)
    scale = before.sum()
    gains = np.array([row["gain1"], row["gain2"]])
    np.testing.assert_allclose(gains, after - before, rtol=0, atol=1e-11 * scale)
    # E2 takes the absolute displacement w, not the stretch, which is the same at both ends:
    # but for that, what the one gains the other loses
    w = touch[2] - rest, release[2] - rest
    share = p["k2"] * (w[1] ** 2 - w[0] ** 2) / 2
    assert gains.sum() == pytest.approx(share, abs=1e-11 * scale)


def test_an_impact_under_way_has_no_gain_yet():
    hits = simulate(system_of("ssul", SET6), 4, record=BOTH).impacts
    assert np.isnan(hits["release"][-1])
    assert np.isnan([hits["gain1"][-1], hits["gain2"][-1]]).all()
    assert np.isfinite([hits["gain1"][:-1], hits["gain2"][:-1]]).all()


# ---- maxima with and without the transient -------------------------------------------------------


@pytest.mark.plain
def test_peaks_and_maxima():
    system = system_of("ssul", SET6)
    whole = simulate(system, 30, record=PEAKS)
    assert (whole.E1peak, whole.E2peak) == (whole.E1max, whole.E2max)
    late = simulate(system, 10, transient=20, record=PEAKS)
    assert late.E1peak == pytest.approx(whole.E1peak, rel=1e-9)
    assert late.E2peak == pytest.approx(whole.E2peak, rel=1e-9)
    assert late.E1max < 0.9 * late.E1peak  # the transient is the larger here
    sweep = [simulate(system, 2, transient=n, record=PEAKS) for n in range(0, 12, 3)]
    for one, next_one in pairwise(sweep):
        assert one.E1peak <= next_one.E1peak * (1 + 1e-9)
        assert one.E1max <= one.E1peak
        assert one.E2max <= one.E2peak


METHODS = (
    pytest.param("exact", marks=pytest.mark.plain),
    pytest.param("rk4", marks=pytest.mark.kernels),
)


@pytest.mark.parametrize("method", METHODS)
def test_the_peak_of_a_linear_transient(method):
    """Against matrix exponentials on a fine grid, a parabola through its highest samples."""
    system, n = load_system("tmd"), 4000
    options = {} if method == "exact" else {"method": method, "period_steps": 2048.0}
    orbit = simulate(system, 3, transient=40, record=PEAKS, **options)
    step = expm(linear_flow(system.parameters) * system.period / n)
    y, values = np.array([0.0, 0, 0, 0, 1, 0]), []
    for _ in range(43 * n):
        values.append(energies(system.parameters, y[:4], 0.0))
        y = step @ y
    for peak, course in zip((orbit.E1peak, orbit.E2peak), np.array(values).T, strict=True):
        i = course.argmax()
        before, top, after = course[i - 1 : i + 2]
        highest = top - (after - before) ** 2 / (8 * (after - 2 * top + before))
        assert peak == pytest.approx(highest, rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_start_may_be_the_peak(method):
    """From 3 m/s the dashpot takes more than the force gives: 4500 J, then the steady 1568.00."""
    system, options = load_system("none"), {"record": PEAKS, "method": method}
    orbit = simulate(system, 3, transient=200, start=(0.0, 3.0), **options)
    assert orbit.E1peak == 4500.0
    assert round(orbit.E1max, 2) == 1568.00
    assert orbit.E2peak is None


@pytest.mark.plain
def test_a_scan_stores_both():
    arrays = computed(scan_of("tmd", PEAKS, {"omega": [6.0, 6.28]}, transient=40, periods=3))
    for i, omega in enumerate((6.0, 6.28)):
        orbit = simulate(load_system("tmd", omega=omega), 3, transient=40, record=PEAKS)
        for name in ("E1max", "E2max", "E1peak", "E2peak"):
            assert arrays[name][i, 0] == getattr(orbit, name)
    assert (arrays["E1peak"] >= arrays["E1max"]).all()


@pytest.mark.plain
def test_the_reduction_is_measured_by_the_structure_alone():
    vary = {"omega": [6.21, 6.28], "P": [0.0, 800.0]}
    scan = scan_of("tmd", ["energy"], vary, transient=100, periods=2)
    arrays = computed(scan)["reduction"][..., 0]
    assert arrays[1, 1] == pytest.approx(1.0 - 635.107 / 1568.00, abs=1e-6)
    assert np.isnan(arrays[:, 0]).all()  # nothing moves: there is nothing to reduce
    alone = energy_alone(scan.cells())
    assert alone[1, 1] == pytest.approx(1568.00, abs=0.01)
    assert arrays[0, 1] == pytest.approx(1.0 - 660.435 / alone[0, 1], abs=1e-6)
