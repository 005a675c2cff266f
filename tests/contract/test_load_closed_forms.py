"""Closed forms beside what is computed under loads: of blows and of noise, on linear systems."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.loads.picture import envelope
from nlds_vines.model.linear_response import closed_form, energy_after_blow
from nlds_vines.model.loads.loading import Loading

NOISE = {"rms": 0.5, "low": 2.0, "high": 40.0, "tones": 60, "unit": "m/s^2", "seed": 3}


def equation(system):
    """Return mass, damping and stiffness matrices, as a textbook has them."""
    p = {"m2": 1.0, "c2": 0.0, "k2": 0.0, **system.parameters}
    pairs = ((p["c1"], p["c2"]), (p["k1"], p["k2"]))
    damping, stiffness = (np.array([[one + two, -two], [-two, two]]) for one, two in pairs)
    return np.diag([p["m1"], p["m2"]]), damping, stiffness


@pytest.mark.parametrize("name", ["none", "tmd"])
def test_energies_after_a_blow_against_another_integrator(name):
    system, speed = nv.load_system(name, c1=300.0), 0.8
    (M, C, K), p = equation(system), system.parameters
    c2 = p.get("c2", 0.0)

    def rates(_, y):
        x, v = y[:2], y[2:4]
        acceleration = np.linalg.solve(M, -C @ v - K @ x)
        return [*v, *acceleration, p["c1"] * v[0] ** 2, c2 * (v[0] - v[1]) ** 2]

    options = {"rtol": 1e-11, "atol": 1e-14, "max_step": 0.05}
    solution = solve_ivp(rates, (0, 120), [0, 0, speed, 0, 0, 0], **options)
    energy = 0.5 * p["m1"] * speed**2
    load = Loading(impulse=speed * p["m1"])
    exact, (x1, _, v1, _) = closed_form(system, load), solution.y[:4, ::100]
    over_time = energy_after_blow(system, load, solution.t[::100])
    assert over_time == pytest.approx(0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2), abs=1e-8 * energy)
    assert exact["E1max"] == exact["energy_in"] == pytest.approx(energy, rel=1e-14)
    assert exact["share_c1"] == pytest.approx(solution.y[4, -1] / energy, abs=1e-8)
    assert exact.get("share_c2", 0.0) == pytest.approx(solution.y[5, -1] / energy, abs=1e-8)
    assert ("x1_max" in exact) == ("share_c2" not in exact) == (name == "none")
    if name == "none":
        assert exact["x1_max"] == pytest.approx(np.abs(solution.y[0]).max(), rel=1e-4)


@pytest.mark.parametrize("name", ["none", "tmd"])
@pytest.mark.parametrize("unit", ["N", "m/s^2"])
def test_the_rms_under_noise_is_that_of_its_tones(name, unit):
    system = nv.load_system(name)
    M, C, K = equation(system)
    load = Loading(**{"noise": {**NOISE, "unit": unit}, "scale": 2.0})
    square = 0.0
    for omega in 2.0 + (np.arange(60) + 0.5) * 38.0 / 60:
        force = -M @ [1.0, 1.0] if unit == "m/s^2" else [1.0, 0.0]
        x1 = np.linalg.solve(K - omega**2 * M + 1j * omega * C, force)[0]
        square += (2.0 * 0.5) ** 2 / 60 * abs(x1) ** 2
    assert closed_form(system, load) == {"x1_rms": pytest.approx(math.sqrt(square), rel=1e-12)}


@pytest.mark.parametrize(
    ("system", "table"),
    [
        (nv.load_system("ssul-set6"), {"impulse": 1.0}),
        (nv.load_system("tmd"), {"impulse": 1.0, "harmonic": True}),
        (nv.load_system("tmd"), {"impulse": 1.0, "noise": {"rms": 1.0, "high": 9.0}}),
        (nv.load_system("tmd"), {"blow": {"impulse": 1.0, "at": 1.0}}),
        (nv.load_system("tmd"), {"tone": {"amplitude": 1.0, "omega": 1.0}}),
        (nv.load_system("none", c1=0.0), {"impulse": 1.0}),
    ],
)
def test_nothing_is_told_where_there_is_no_closed_form(system, table):
    assert closed_form(system, Loading(**table)) == {}


@pytest.mark.kernels
def test_a_report_has_them_beside_what_was_computed():
    systems = ["none", "tmd", "ssbl"]
    histories = nv.response_history(systems, impulse=1000.0, duration=30.0, quiet=True)
    lines = list(histories.lines())[:6]
    assert [line.startswith("  in closed form: E1max") for line in lines] == [0, 0, 1, 0, 1, 0]
    for name, line in (("none", lines[2]), ("tmd", lines[4])):
        assert float(re.search(r"but for (\S+) of E1max", line)[1]) < 1e-12
        exact = closed_form(nv.load_system(name), histories.request.load)
        for key, value in exact.items():
            assert histories[name].numbers[key] == pytest.approx(value, abs=3e-6), (name, key)


def test_an_envelope_is_what_is_largest_in_each_period():
    table = {"amplitude": 1.0, "first": 5.0, "last": 7.0, "length": 20.0, "at": 2.0}
    (sweep,) = Loading(**{"sweep": table}).sweep
    time = np.linspace(0.0, 30.0, 3001)
    omega, largest = envelope(sweep, time, time, 4.0)
    assert omega == pytest.approx([5.2, 5.6, 6.0, 6.4])
    assert largest == pytest.approx([6, 10, 14, 18], abs=0.02)
