"""Moving ground in every task: closed forms, hosts beside kinds, a load of the same motion."""

import pickle

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.linear_response import amplitudes
from scans import computed, scan_of

pytestmark = pytest.mark.kernels

OMEGA, Y = 6.9, 0.01
DRIVES = ({"base_displacement": Y}, {"base_acceleration": Y * OMEGA**2})
SHAKEN = {"base_acceleration": 0.8}
TMD = {"m1": 1000.0, "k1": 39500.0, "c1": 452.0, "m2": 60.0, "k2": 600.0, "c2": 262.0}


def acceleration_of(drive, omega=OMEGA):
    """Return the acceleration of the ground at t = 0."""
    if "base_acceleration" in drive:
        return drive["base_acceleration"]
    return -(omega**2) * drive["base_displacement"]


def steady(kind, drive, omega=OMEGA):
    """Return the complex amplitudes relative to the ground, and that of the ground."""
    p, a = TMD, acceleration_of(drive, omega)
    M = np.diag([p["m1"], p["m2"]])
    C = np.array([[p["c1"] + p["c2"], -p["c2"]], [-p["c2"], p["c2"]]])
    K = np.array([[p["k1"] + p["k2"], -p["k2"]], [-p["k2"], p["k2"]]])
    if kind == "none":
        M, C, K = M[:1, :1], np.array([[p["c1"]]]), np.array([[p["k1"]]])
    X = np.linalg.solve(K - omega**2 * M + 1j * omega * C, -a * np.diag(M))
    return X, -a / omega**2


def largest_energy(m, k, X, omega=OMEGA):
    """Return the largest energy of a harmonic motion: max(m omega^2, k) |X|^2 / 2."""
    return 0.5 * max(m * omega**2, k) * abs(X) ** 2


def kind_under(kind, drive):
    names = ("m1", "k1", "c1") if kind == "none" else TMD
    return nv.System(kind, {**{name: TMD[name] for name in names}, "omega": OMEGA, **drive})


@pytest.mark.parametrize("drive", DRIVES, ids=("displacement", "acceleration"))
@pytest.mark.parametrize("kind", ["none", "tmd"])
def test_a_linear_kind_moves_as_its_closed_form(kind, drive):
    system = kind_under(kind, drive)
    X, y = steady(kind, drive)
    assert amplitudes(system, OMEGA)[0] == pytest.approx(X[0], rel=1e-14)
    record = ["section", "energy", "response"]
    orbit = nv.simulate(system, 2, transient=400, record=record, quiet=True)
    states = np.array([X, 1j * OMEGA * X]).real.T.ravel()
    np.testing.assert_allclose(orbit.section, np.tile(states, (2, 1)), rtol=1e-11)
    response = orbit.response
    expected = {
        "x1_max": abs(X[0]),
        "v1_max": OMEGA * abs(X[0]),
        "a1_max": OMEGA**2 * abs(X[0] + y),
        "x1_abs_max": abs(X[0] + y),
    }
    for name, value in expected.items():
        assert response[name] == pytest.approx(value, rel=1e-11), name
        rms = response[name.replace("_max", "_rms")]
        assert rms == pytest.approx(value / np.sqrt(2), rel=1e-11), name
    assert response["transmissibility"] == pytest.approx(abs(X[0] + y) / abs(y), rel=1e-11)
    assert orbit.E1max == pytest.approx(largest_energy(TMD["m1"], TMD["k1"], X[0]), rel=1e-11)
    if kind == "tmd":
        assert amplitudes(system, OMEGA)[1] == pytest.approx(X[1], rel=1e-14)
        assert response["stroke_max"] == pytest.approx(abs(X[1] - X[0]), rel=1e-11)
        assert orbit.E2max == pytest.approx(largest_energy(TMD["m2"], TMD["k2"], X[1]), rel=1e-11)


def test_reductions_compare_with_the_structure_alone_on_the_same_ground():
    omegas = [5.5, 6.28]
    request = scan_of(
        kind_under("tmd", DRIVES[0]), ("energy", "response"), {"omega": omegas},
        transient=300, periods=2,
    )  # fmt: skip
    scan = computed(request)
    for i, omega in enumerate(omegas):
        X, y = steady("none", DRIVES[0], omega)
        alone = {
            "x1_max": abs(X[0]),
            "a1_rms": omega**2 * abs(X[0] + y) / np.sqrt(2),
            "x1_abs_max": abs(X[0] + y),
        }
        for name, value in alone.items():
            reduction = 1.0 - scan[name][i, 0] / value
            assert scan[f"{name}_reduction"][i, 0] == pytest.approx(reduction, abs=1e-13), name
        energy = largest_energy(TMD["m1"], TMD["k1"], X[0], omega)
        reduction = 1.0 - scan["E1max"][i, 0] / energy
        assert scan["reduction"][i, 0] == pytest.approx(reduction, abs=1e-13)
        assert scan["P"][i, 0] == pytest.approx(TMD["m1"] * omega**2 * Y, rel=1e-15)


@pytest.mark.parametrize("parameter", ["omega", "base_displacement"])
def test_a_branch_is_that_of_the_closed_form(parameter):
    system, bounds = kind_under("tmd", DRIVES[0]), (6.5, 7.0)
    if parameter == "base_displacement":
        bounds = (0.005, 0.02)
    (branch,) = nv.continue_branch(system, parameter, bounds, quiet=True).branches
    for value, state in zip(branch.parameter, branch.states, strict=True):
        omega = value if parameter == "omega" else OMEGA
        drive = {"base_displacement": value} if parameter != "omega" else DRIVES[0]
        X, _ = steady("tmd", drive, omega)
        expected = np.array([X, 1j * omega * X]).real.T.ravel()
        np.testing.assert_allclose(state, expected, rtol=1e-9, atol=1e-12)


def test_the_displacement_of_a_hosts_ground_is_followed_along_the_frequency():
    """A frame of two floors along omega, beside the closed form, and named on every axis."""
    m, k, c = np.diag([900.0, 700.0]), np.array([[7e4, -3e4], [-3e4, 3e4]]), np.diag([800.0, 600.0])
    host = nv.Host(M=m, K=k, C=c, dofs=["low", "high"])
    system = nv.System.from_host(host, base={"displacement": 0.01}, omega=5.0)
    omegas = np.array([3.0, 6.0, 9.0])
    record = {"want": ["energy", "response"], "of": ["high"]}
    along = {"sampling": {"transient": 400, "periods": 2, "tolerance": 1e-11}, "quiet": True}
    scan = nv.scan(system, vary={"omega": {"values": omegas}}, record=record, **along)
    for i, omega in enumerate(omegas):
        dynamic = k - omega**2 * m + 1j * omega * c
        relative = np.linalg.solve(dynamic, 0.01 * omega**2 * np.diag(m))[1]
        expected = {"x_max": relative, "x_abs_max": relative + 0.01}
        expected["a_max"] = omega**2 * expected["x_abs_max"]
        for name, value in expected.items():
            assert scan[name][i].item() == pytest.approx(abs(value), rel=1e-9), name
        bare = system.with_(**{"ground.acceleration": -0.01 * omega**2, "omega": omega})
        other = nv.scan(bare, vary={"omega": {"values": [omega]}}, record=record, **along)
        assert other["x_max"].item() == pytest.approx(scan["x_max"][i].item(), rel=1e-13)
    again = pickle.loads(pickle.dumps(system))
    assert again.parameters == system.parameters
    twice = system.with_(**{"ground.displacement": 0.02}).parameters["ground.displacement"]
    assert twice == 0.02


@pytest.mark.parametrize("system", ["ssul-set6", "ssbl"])
def test_a_load_of_the_same_acceleration_leads_to_the_same_orbit(system):
    """From rest: the kernels of loads, in which the ground moves by polynomials."""
    harmonic = nv.load_system(system, **SHAKEN)
    periods = 12
    duration = periods * harmonic.period
    tone = {"amplitude": 0.8, "omega": harmonic.parameters["omega"], "unit": "m/s^2"}
    orbit = nv.simulate(
        harmonic, periods, record=["section", "energy", "response"], tolerance=1e-12, quiet=True
    )
    histories = nv.response_history(
        nv.load_system(system), load={"tone": tone}, duration=duration,
        sampling={"tolerance": 1e-12}, quiet=True,
    )  # fmt: skip
    history = histories.results[harmonic.name]
    size = np.abs(orbit.section).max()
    assert history.x1[-1] == pytest.approx(orbit.section[-1, 0], abs=1e-9 * size)
    assert history.x2[-1] == pytest.approx(orbit.section[-1, 2], abs=1e-9 * size)
    for name in ("x1_max", "v1_max", "a1_max", "stroke_max", "force_max"):
        largest = np.max(orbit.response[name])
        assert history.numbers[name] == pytest.approx(largest, rel=1e-7), name
    assert history.numbers["E1max"] == pytest.approx(orbit.E1max, rel=1e-9)
    assert history.numbers["E2max"] == pytest.approx(orbit.E2max, rel=1e-9)


def test_one_response_of_the_ground_is_refused_where_forces_act(error_of):
    words = "under a load the ground moves by a tone"
    shaken = nv.load_system("tmd", **SHAKEN)
    load = {"load": {"impulse": 1.0, "harmonic": True}}
    assert words in error_of(nv.response_history, shaken, **load, quiet=True)
    vary = {"base_acceleration": [0.5, 1.0]}
    assert words in error_of(nv.response_history, "tmd", impulse=1.0, vary=vary, quiet=True)
