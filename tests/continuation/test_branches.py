"""Branches of the paper's dampers: what is stored, what is located, when they end."""

import numpy as np
import pytest
from test_closed_forms import located

from benchmarks.boundary_values import Motion, doubling_by_shooting
from nlds_vines import System, classify, continue_branch, load_system, simulate
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.engine.solver_settings import Settings
from paper.linear import response

pytestmark = pytest.mark.kernels


@pytest.fixture(scope="module")
def set6():
    """Return the T,1 branch of Set 6 from 5 to 9 rad/s, with the branches of 2T."""
    return continue_branch("ssul-set6", "omega", (5.0, 9.0), doublings=1)


def test_the_branch_of_set_6_is_whole_and_its_special_points_are_sharp(set6):
    branch = set6.branches[0]
    assert branch.ends == ("bound", "bound")
    assert (branch.parameter[0], branch.parameter[-1]) == (5.0, 9.0)
    assert list(dict.fromkeys(branch.labels.tolist())) == ["T,1", "T,0"]
    kinds = set6.special_points[set6.special_points.branch == 0].kind.tolist()
    assert kinds == ["PD", "PD", "GR"]
    # from T,1, grazing is where the motion without impacts fills the gap
    (row,) = located(set6, "GR", 0)
    assert ({row.before, row.after}, row.wall) == ({"T,0", "T,1"}, "near")
    there = load_system("ssul-set6", omega=row.value)
    gap = float(response(there, np.array(row.value)).shortening)
    assert gap == pytest.approx(there.parameters["C"], rel=1e-10)
    # every special point is sharp
    assert len(set6.special_points) > 10
    assert {"LP", "PD", "NS", "GR"} <= {*set6.special_points.kind.tolist()}
    assert (set6.special_points.bracket <= 1e-10 * set6.special_points.value).all()
    assert (set6.special_points.defect < 1e-11).all()
    # determinants are what the damping makes them
    for branch in set6.branches:
        assert branch.determinant_error.max() < 1e-6
    # multipliers tell each kind
    pairs = set6.tables["special_multipliers"]
    mu = pairs[..., 0] + 1j * pairs[..., 1]
    for row, values in zip(set6.special_points, mu, strict=True):
        if row.kind == "LP":
            assert np.abs(values - 1.0).min() < 1e-6
        if row.kind == "PD":
            assert np.abs(values + 1.0).min() < 1e-8
        if row.kind == "NS":
            on_circle = np.abs(np.abs(values) - 1.0) < 1e-8
            assert (on_circle & (np.abs(values.imag) > 1e-6)).sum() == 2


def test_points_are_orbits(set6):
    """A start on a point comes back after n periods, with its impacts and its energy."""
    for branch in set6.branches:
        for i in range(0, len(branch), max(1, len(branch) // 7)):
            if i in (0, len(branch) - 1) and branch.parent >= 0:
                continue  # it begins with the orbit of half the period
            there = load_system("ssul-set6", omega=branch.parameter[i])
            n, record = branch.period, ("section", "impacts", "energy")
            orbit = simulate(there, n, start=branch.states[i], record=record, tolerance="fine")
            size = np.abs(branch.states[i]).max()
            assert np.abs(orbit.state - branch.states[i]).max() < 1e-10 * size
            assert np.allclose(orbit.section, branch.sections[i], rtol=0, atol=1e-10 * size)
            assert len(orbit.impacts) == branch.impacts[i].sum()
            assert orbit.E1max == pytest.approx(branch.E1max[i], rel=1e-9)
            if len(orbit.impacts):
                assert orbit.impacts["speed"].max() == pytest.approx(branch.fastest_impact[i])
                assert orbit.impacts["speed"].min() == pytest.approx(branch.softest_impact[i])


def test_shooting_finds_a_doubling_where_it_is_and_not_where_it_is_said_to_be(set6):
    row = located(set6, "PD", 0)[0]
    motion = Motion.of(load_system("ssul-set6"))
    for value in (row.value, row.value + 1e-6):
        there = doubling_by_shooting(motion, value, row.state)
        assert there == pytest.approx(row.value, rel=1e-10)


def test_stable_points_are_what_the_classifier_finds(set6):
    for branch in set6.branches[:2]:
        stable = np.flatnonzero(branch.stable & (np.abs(branch.multipliers[:, 0]) < 0.97))
        for i in stable[:: max(1, len(stable) // 6)]:
            there = load_system("ssul-set6", omega=branch.parameter[i])
            regime = classify(there, start=branch.states[i])
            assert regime.label == branch.labels[i]
            assert np.allclose(regime.multipliers, branch.multipliers[i], atol=1e-6)


def test_a_closed_loop_is_recognized():
    """The orbits 3T,2 and 3T,3 of Set 6 are an isola: they join no other branch."""
    regime = classify(load_system("ssul-set6", omega=7.45))
    path = continue_branch("ssul-set6", "omega", (5.0, 9.0), regime)
    (branch,) = path.branches
    assert branch.ends == ("closed", "closed")
    assert set(branch.labels.tolist()) == {"3T,2", "3T,3"}
    kinds = path.special_points.kind.tolist()
    assert kinds.count("LP") == 4
    assert kinds.count("GR") == 2


def continued_from_rest(system, parameter, bounds):
    """Continue the orbit of one period on which the motion from rest settles.

    It is neither judged nor simulated: to compile that takes longer than all that is computed here.
    """
    rest = np.array([0.0, 0.0, system.parameters[parameter]])
    start = SectionMap(system, (parameter,)).at(rest, 720).points[-1, :2]
    return continue_branch(system, parameter, bounds, start, period=1)


EQUAL_STOPS = {"m": 1.0, "k": 1.0, "c": 0.2, "C": 1.0, "C_2": 1.0, "omega": 0.5, "P": 0.05}


def test_a_symmetric_orbit_branches():
    """Between two equal stops: at a branch point a pair of unsymmetric orbits leaves, a loop."""
    numbers = {**EQUAL_STOPS, "K": 20.0}
    path = continued_from_rest(System("oscillator-2", numbers), "P", (0.05, 5.0))
    main, other = path.branches[:2]
    assert (other.origin, other.parent, other.ends) == ("BP", 0, ("closed", "closed"))
    for row in located(path, "BP", 1):
        assert np.abs(located(path, "BP", 0).value - row.value).min() < 1e-8
    # an orbit and its mirror image
    first, second = (orbit for orbit in path.orbits_at(3.0) if orbit.branch == 1)
    section_map = SectionMap(System("oscillator-2", {**numbers, "P": 3.0}), ("P",))
    half = section_map.later(np.append(first.state, 3.0), 0.5)[:2]
    assert np.allclose(half, -second.state, atol=1e-6)
    assert main.stable.any()


TWO_STOPS = {"m": 1.0, "k": 1.0, "P": 1.0}


@pytest.mark.long
@pytest.mark.parametrize("between", [(0.4, 3.0), (0.4, 0.7)])
def test_the_branches_found_do_not_depend_on_the_interval(between):
    """Between two branch points there are stable T,4 orbits that are not symmetric."""
    numbers = {**TWO_STOPS, "c": 0.05, "C": 0.5, "C_2": 0.5, "kc": 60.0, "omega": 0.4}
    path = continued_from_rest(System("oscillator-2", numbers, law="linear"), "omega", between)
    orbits = sorted((orbit.label, orbit.stable) for orbit in path.orbits_at(0.55))
    assert orbits == [("T,4", False), *[("T,4", True)] * 2, *[("T,5", False)] * 4]
    points, folds = located(path, "BP"), located(path, "LP").value
    assert (points.switch != "failed").all()
    assert np.abs(folds[:, None] - points.value).min() > 1e-8  # a turn at a branch point is none
    for value in (0.48382267619, 0.61642649536):
        assert (np.abs(points.value - value) < 1e-10).sum() == 2  # on both branches


@pytest.mark.parametrize("between", [(0.4, 3.0), (0.4, 1.0)])
def test_branch_points_are_located_and_shared(between):
    """They were 7e-7 and 3e-7 off, with other digits on each branch, and one branch twice."""
    numbers = {**TWO_STOPS, "c": 0.02, "C": 0.8, "C_2": 0.8, "K": 20.0, "omega": 0.4}
    path = continued_from_rest(System("oscillator-2", numbers), "omega", between)
    assert len(path.branches) == 2
    values = located(path, "BP").value.tolist()
    assert len(values) == 4
    assert len(set(values)) == 2
    assert sorted(set(values)) == pytest.approx([0.796847281754, 0.857919740425], abs=1e-11)
    assert path.special_points.resolved.all()
    assert not any("unresolved" in line for line in path.lines())


@pytest.mark.parametrize(
    ("kind", "c"), [pytest.param("oscillator-2", 0.05, marks=pytest.mark.long), ("oscillator", 0.1)]
)
def test_no_branch_of_rigid_bodies_steps_over_a_grazing(kind, c):
    """A step across one gave a doubling that is none, and points located to 1e-4 only."""
    numbers = {**TWO_STOPS, "c": c, "C": 0.5, "e": 0.8, "omega": 0.7}
    numbers |= {"C_2": 0.5} if kind == "oscillator-2" else {}
    path = continued_from_rest(System(kind, numbers, law="restitution"), "omega", (0.4, 3.0))
    assert path.special_points.resolved.all()
    assert all(len(set(branch.labels.tolist())) == 1 for branch in path.branches)
    assert not any("lost" in branch.ends for branch in path.branches)
    doublings = located(path, "PD").value
    assert np.abs(doublings - 0.56792184).min() > 1e-6


def test_a_switch_that_fails_is_reported(monkeypatch):
    monkeypatch.setattr(
        "nlds_vines.continuation.exploration.other_branch", lambda section_map, point: None
    )
    path = continued_from_rest(System("oscillator-2", {**EQUAL_STOPS, "K": 20.0}), "P", (0.05, 3.0))
    assert "failed" in located(path, "BP").switch
    assert any(line.endswith("the branch that leaves there was not found") for line in path.lines())


def test_orbits_at_a_value_are_all_there_and_a_saddle_divides_two_basins(set6):
    """Starts on both sides of it, along its unstable direction, end in different attractors."""
    orbits = set6.orbits_at(7.8)
    labels = sorted((orbit.label, orbit.stable) for orbit in orbits)
    assert labels == [("2T,1", False), ("2T,1", True), ("T,0", True)]
    (saddle,) = (orbit for orbit in orbits if not orbit.stable)
    assert saddle.unstable == 1
    there = load_system("ssul-set6", omega=7.8)
    section_map = SectionMap(there, ("omega",), Settings(1e-12))
    cycle = section_map.at(section_map.place_of(7.8, saddle.state), 2)
    values, vectors = np.linalg.eig(cycle.matrix)
    push = vectors[:, np.argmax(np.abs(values))].real * 1e-4
    labels = set()
    for sign in (1.0, -1.0):
        x1, v1, r, s = cycle.state + sign * push
        labels.add(classify(there, start=(x1, v1, x1 - r + there.rest, v1 - s)).label)
    assert labels == {"T,0", "2T,1"}


def test_any_point_of_a_branch_is_a_start(set6):
    branch = set6.branches[1]
    i = len(branch) // 2  # unstable: from its state alone, the orbit would end elsewhere
    value = float(branch.parameter[i])
    there = load_system("ssul-set6", omega=value)
    path = continue_branch(there, "omega", (7.4, 9.0), branch.states[i], period=2)
    near = path.orbits_at(value)
    assert any(np.allclose(orbit.state, branch.states[i], atol=1e-9) for orbit in near)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ssul-set6", "omega", (5,)), "two numbers"),
        (("ssul-set6", "omega", ()), "two numbers"),
        (("ssul-set6", "omega", np.array([9.0, 9.0])), "the ends must differ"),
        (("ssul-set6", "omega", (7.38, 7.385)), "only a periodic orbit can be followed"),
        (("ssul-set6", "omega", (6.0, 7.0), "5T,5"), "no start at omega = 6.28 ends in 5T,5"),
    ],
)
def test_a_wrong_request_is_one_line(arguments, words, error_of):
    assert words in error_of(continue_branch, *arguments)
