"""Monitors: where a quantity, or a function of the user, has a value along a branch."""

import numpy as np
import pytest
from scipy.optimize import brentq

import nlds_vines as nv
from nlds_vines.continuation.request import load_continuation

BOUNDS = (7.2, 7.38)
QUICK = {"unstable": 9, "step": 0.1, "quiet": True}


def force_less(orbit):
    return orbit.largest_force / 1e4 - 1.0


@pytest.fixture(scope="module")
def monitored(tmp_path_factory):
    """Return T,1 of Set 6 with the places of a force, of two energies and of a function."""
    monitors = {"largest_force": 1e4, "E1max": [100, 150], "less": force_less}
    path = tmp_path_factory.mktemp("monitors") / "monitored.h5"
    return nv.continue_branch("ssul-set6", "omega", BOUNDS, monitors=monitors, to=path, **QUICK)


def at(branches, words):
    """Return the values of the parameter at the zeros of one monitor."""
    rows = branches.special_points
    return rows.value[rows.monitor == words]


def of_attractor(omega):
    """Return the largest energy and force of the attractor, by classification and simulation."""
    there = nv.load_system("ssul-set6", omega=omega)
    regime = nv.classify(there)
    assert regime.label == "T,1"
    orbit = nv.simulate(
        there, 2, start=regime.point, record=("impacts", "energy"), tolerance="fine"
    )
    return orbit.E1max, orbit.impacts["force"][0]


@pytest.mark.kernels
def test_a_value_is_where_brentq_finds_it(monitored):
    """Classification and simulation know nothing of branches."""
    for words, column, value in (
        ("largest_force = 10000 N", 1, 1e4),
        ("E1max = 150 J", 0, 150.0),
        ("E1max = 100 J", 0, 100.0),
    ):
        (there,) = at(monitored, words)

        def excess(omega, column=column, value=value):
            return of_attractor(omega)[column] - value

        root = brentq(excess, there - 2e-3, there + 2e-3, xtol=1e-12, rtol=1e-12)
        assert there == pytest.approx(root, rel=1e-9)
    (by_function,) = at(monitored, "less")
    assert by_function == pytest.approx(at(monitored, "largest_force = 10000 N")[0], rel=1e-12)


def test_zeros_are_sharp_in_order_and_change_no_point(monitored):
    rows = monitored.special_points
    zeros = rows[rows.kind == "UZ"]
    assert len(zeros) == 4
    assert zeros.resolved.all()
    assert (zeros.residual < 1e-9).all()
    assert (zeros.defect < 1e-11).all()
    assert (np.diff(rows.value) >= 0).all()
    plain = nv.continue_branch("ssul-set6", "omega", BOUNDS, **QUICK)
    for name, values in plain.tables.items():
        if values.shape == monitored.tables[name].shape:
            np.testing.assert_array_equal(values, monitored.tables[name], err_msg=name)
    others = rows[rows.kind != "UZ"]
    np.testing.assert_array_equal(others.value, plain.special_points.value)


def test_an_archive_keeps_functions_by_name_and_values(monitored, refusal, tmp_path):
    again = nv.open_archive(monitored.path)
    assert again.special_points.monitor.tolist() == monitored.special_points.monitor.tolist()
    branch = again.branches[0]
    np.testing.assert_array_equal(branch.monitors["less"], branch.largest_force / 1e4 - 1.0)
    assert again.request.document()["monitors"] == {
        "largest_force": 1e4,
        "E1max": [100.0, 150.0],
        "less": "function",
    }
    rerun = refusal("rerun", monitored.path, "-o", tmp_path / "again.h5")
    assert "monitor 'less' is a function of Python, which no file holds" in rerun
    lines = [line for line in monitored.lines() if line.startswith("  UZ")]
    assert lines[0].endswith(" rad/s  T,1; largest_force = 10000 N")
    (axes,) = monitored.plot("less").axes
    stars = [line for line in axes.get_lines() if line.get_marker() == "*"]
    assert len(stars) == 4
    heights = sorted(abs(float(line.get_ydata()[0])) for line in stars)
    assert heights[1] < 1e-9 < heights[2]


def test_an_orbit_at_a_zero_has_the_value(monitored):
    for words, name, value in (("E1max = 150 J", "E1max", 150.0), ("less", "largest_force", 1e4)):
        (there,) = at(monitored, words)
        (orbit,) = monitored.orbits_at(there)
        assert getattr(orbit, name) == pytest.approx(value, rel=1e-9)
        branch = monitored.branches[0]
        i = int(np.abs(branch.parameter - there).argmin())
        (orbit,) = monitored.orbits_at(float(branch.parameter[i]))
        for column in ("E1max", "E2max", "clearance", "softest_impact", "fastest_impact"):
            assert getattr(orbit, column) == pytest.approx(getattr(branch, column)[i], rel=1e-9)


def test_the_command_lists_them(tmp_path, answer, refusal):
    asked = ["--along", "omega=7.2:7.3", "--step", "0.2", "-o", tmp_path / "a.h5", "--overwrite"]
    lines = answer("continuation", *asked, "--monitor", "E1max=150,160", "--monitor", "x2=0.4")
    assert "T,1; E1max = 150 J\n" in lines
    assert "T,1; E1max = 160 J\n" in lines
    for words, texts in {
        "unknown quantity 'E9max'": ["E9max=3"],
        "E1max = [1.0, 1.0] must be different numbers": ["E1max=1,1"],
        "--monitor E1max = 'much' must be a number": ["E1max=much"],
        "--monitor E1max is given twice": ["E1max=1", "E1max=2"],
    }.items():
        options = [word for text in texts for word in ("--monitor", text)]
        assert words in refusal("continuation", *asked, *options)


def test_a_function_must_return_a_number(error_of):
    near = ("ssul-set6", "omega", (7.2, 7.21))
    words = error_of(nv.continue_branch, *near, monitors={"odd": lambda orbit: "much"}, **QUICK)
    assert "monitor 'odd' at omega = 7.2 rad/s = 'much' must be a number" in words
    for name in ("E1max", "two words"):
        monitors = {name: force_less}
        words = error_of(nv.continue_branch, *near, monitors=monitors, **QUICK)
        assert f"{name} is no name for a function" in words
    table = {"monitors": {"mine": "function"}}
    assert load_continuation("ssul-set6", table).monitors[0].is_function


def test_where_a_function_is_not_finite_or_jumps(tmp_path):
    """No zero is made of a number that some orbits do not have; a jump is told."""
    near = ("ssul-set6", "omega", (7.2, 7.3))

    def broken(orbit):
        return np.nan if orbit.value < 7.25 else 1.0

    def step(orbit):
        return -1.0 if orbit.value < 7.25 else 1.0

    path = nv.continue_branch(*near, monitors={"broken": broken, "step": step}, **QUICK)
    (row,) = path.special_points
    assert (row.monitor, row.value) == ("step", pytest.approx(7.25, abs=1e-9))
    assert any(line.endswith("T,1; step, across which it jumps") for line in path.lines())


@pytest.mark.kernels
def test_zeros_of_rigid_impacts_lie_where_simulation_has_them():
    """The state at phase zero jumps where an impact passes it; the zero is located in flight."""
    system = nv.load_system("impact-oscillator", omega=1.5)
    monitors = {"fastest_impact": [0.8, 1.2]}
    path = nv.continue_branch(system, "P", (0.1, 2.0), monitors=monitors, quiet=True)
    zeros = path.special_points[path.special_points.kind == "UZ"]
    assert len(zeros) >= 2
    assert zeros.resolved.all()
    for row in zeros:
        there = system.with_(P=float(row.value))
        orbit = nv.simulate(there, 2, start=row.state, record=("impacts",), tolerance="fine")
        value = float(row.monitor.split()[2])
        assert orbit.impacts["speed"][0] == pytest.approx(value, rel=1e-8)
