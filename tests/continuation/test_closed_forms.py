"""Branches and curves of rigid bodies against closed forms, and where impacts pass phase zero."""

import numpy as np
import plain_phases
import pytest
from rigid import CASES, RIGID, oscillator, start_of

from nlds_vines import System, continue_branch, load_system, open_archive, simulate, slow_manifold
from nlds_vines.__main__ import main
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.engine.solver_settings import Settings
from paper.linear import response, steady_state

pytestmark = pytest.mark.kernels


def named(case):
    return f"{case['omega']}-{case['e']}"


def located(path, kind, branch=None):
    """Return the special points of a kind, of one branch or of all."""
    rows = path.special_points
    return rows[(rows.kind == kind) & (branch is None or rows.branch == branch)]


def assert_folds_and_flips(path, branch, case):
    for kind, exact in [("LP", case["fold_A"]), *(("PD", flip["A"]) for flip in case["flips"])]:
        if exact:
            assert np.abs(located(path, kind, branch).value - exact).min() < 1e-9


@pytest.mark.parametrize("case", CASES, ids=named)
def test_special_points_of_a_rigid_oscillator(case):
    """Folds, flips and grazing lie where closed forms have them, on the branch of one orbit."""
    orbit = case["orbits"][0]
    system = oscillator(case, orbit["A"])
    path = continue_branch(system, "P", (0.05, 6.0), start_of(case, orbit), period=case["n"])
    assert path.branches[0].period == case["n"]
    assert_folds_and_flips(path, 0, case)
    labels = {one for branch in path.branches for one in branch.labels.tolist()}
    assert "2T,0" not in labels  # beyond the grazing of 2T,1 lies T,0
    grazing = located(path, "GR")
    grazing = grazing[grazing.periodicity == 1].value
    assert np.abs(grazing - case["grazing_A"]).min() < 1e-9


@pytest.mark.parametrize("case", CASES, ids=named)
def test_a_rigid_stop_is_grazed_and_the_orbit_with_an_impact_is_found(case):
    """Beyond the grazing of rigid bodies, the branch of T,1 is followed without a hint."""
    between = 0.01, max(3.0, 2.0 * case["grazing_A"])
    system = oscillator(case, 0.5 * case["grazing_A"])
    path = continue_branch(system, "P", between, steady_state(system), period=1)
    assert path.branches[0].ends[1] == "grazing"
    (row,) = path.special_points[path.special_points.branch == 0]
    assert (row.kind, row.before, row.after) == ("GR", "T,0", "T,1")
    assert abs(row.value - case["grazing_A"]) < 1e-9
    if case["n"] == 1:
        (number,) = [i for i, branch in enumerate(path.branches) if "T,1" in branch.labels]
        assert_folds_and_flips(path, number, case)


@pytest.mark.parametrize("case", [case for case in CASES if case["n"] == 1][:2], ids=named)
def test_curves_of_grazing_of_a_rigid_stop_are_closed_forms(case):
    """In the plane of both, the motion without impacts grazes where its amplitude is the gap."""
    system, omega = oscillator(case, 0.5 * case["grazing_A"]), case["omega"]
    between = (0.01, 2.0 * case["grazing_A"])
    path = continue_branch(system, "P", between, plane=("omega", 0.98 * omega, 1.02 * omega))
    curve = path.curves[0]
    assert (curve.kind, curve.period, curve.ends) == ("GR", 1, ("bound", "bound"))
    bounds = np.sort(curve.values[[0, -1], 1])
    assert bounds == pytest.approx([0.98 * omega, 1.02 * omega], rel=1e-15)
    for P, there in curve.values:
        amplitude = abs(complex(response(system.with_(P=P, C=1e6), np.array(there)).X1))
        assert amplitude == pytest.approx(RIGID["d"], abs=1e-9)
    start = np.argmin(np.abs(curve.values[:, 1] - omega))
    assert curve.values[start] == pytest.approx([case["grazing_A"], omega], abs=1e-2)


def test_an_orbit_with_an_impact_grazes_another_rigid_stop():
    """Along the curve of T,1 to T,2: without the second stop, the orbit turns where that was."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.6, "C": 1.0, "C_2": 1.05, "omega": 0.7, "P": 0.3}
    system = System("oscillator-2", {**numbers, "e": 0.6}, law="restitution")
    plane = ("omega", 0.65, 0.75)
    path = continue_branch(system, "P", (0.05, 0.9), steady_state(system), period=1, plane=plane)
    curves = [curve for curve in path.curves if curve.kind == "GR"]
    assert len(curves) == 2  # T,0 to T,1, and T,1 to T,2, each found from both of its sides
    alone = SectionMap(system.with_(C_2=2.0), ("P", "omega"), Settings(1e-12))
    for state, values in zip(curves[1].states, curves[1].values, strict=True):
        cycle = alone.at(np.concatenate([state, values]), 1)
        assert cycle.counts == (1, 0)
        assert cycle.defect < 1e-9
        assert cycle.clearance == pytest.approx(0.95, abs=1e-9)


TWO_STOPS = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 1.2, "C_2": 1.0, "omega": 0.8, "P": 0.1}
GRAZES = {
    "ssul": (load_system("ssul-set6", omega=9.0), "omega", (7.3, 9.0)),
    "ssbl": (load_system("ssbl", P=2.0), "P", (1.0, 400.0)),
    "linear": (load_system("impact-oscillator", law="linear", kc=50.0, P=0.01), "P", (0.005, 0.3)),
    "two stops": (System("oscillator-2", {**TWO_STOPS, "K": 1e3}), "P", (0.05, 1.0)),
}


@pytest.mark.parametrize(
    "name",
    [
        "ssul",
        "two stops",
        *(pytest.param(one, marks=pytest.mark.long) for one in ("ssbl", "linear")),
    ],
)
def test_the_motion_without_impacts_grazes_where_the_linear_response_fills_the_gap(name):
    """From that motion, and with one damper from rest: then orbits are judged first."""
    system, along, between = GRAZES[name]
    begin = {} if name == "ssul" else {"start": steady_state(system), "period": 1}
    path = continue_branch(system, along, between, **begin)
    row = next(row for row in located(path, "GR", 0) if "T,0" in (row.before, row.after))
    there = system.with_(**{along: row.value})
    amplitude = float(response(there, np.array(there.parameters["omega"])).shortening)
    gaps = [g(there.parameters) for g in (there.scene.gap_near, there.scene.gap_far) if g]
    assert amplitude == pytest.approx(min(gaps), rel=1e-10)


@pytest.mark.parametrize("kind", ["ssvi-b", "ssvi-c"])
def test_a_branch_ends_where_its_orbit_touches_the_limit(kind):
    """The linear response fills the way to the limit, or to the wall, whichever is nearer."""
    p = dict(load_system("ssbl").parameters) | {"D": 0.02, "C": 0.05, "L": 0.005, "P": 1.0}
    if kind == "ssvi-b":
        del p["L"]
    system = System(kind, p)
    path = continue_branch(system, "P", (1.0, 5000.0), steady_state(system), period=1)
    (row,) = located(path, "LIM")
    assert path.branches[0].ends[1] == "limit"
    there = system.with_(P=row.value)
    amplitude = float(response(there, np.array(p["omega"])).shortening)
    assert amplitude == pytest.approx(system.scene.limit(p), rel=1e-9)


def test_hertz_contacts_approach_the_rigid_ones_as_they_stiffen():
    """Fold and flip of a Hertz stop converge as K^-0.4, the duration of its impacts."""
    fold = next(case for case in CASES if case["fold_A"] and case["e"] == 1.0 and case["n"] == 1)
    flip = next(case for case in CASES if case["flips"] and case["e"] == 1.0 and case["n"] == 1)
    for case, kind, exact in ((fold, "LP", fold["fold_A"]), (flip, "PD", flip["flips"][0]["A"])):
        orbit, errors = case["orbits"][0], []
        for K in (1e14, 1e16):
            own = oscillator(case, orbit["A"], law="hertz", K=K).parameters
            system = System("oscillator-2", own | {"C_2": 1e3})  # which other tests compile
            path = continue_branch(system, "P", (0.1, 1.2), start_of(case, orbit), period=1)
            errors.append(np.abs(located(path, kind, 0).value - exact).min())
        assert np.log(errors[0] / errors[1]) / np.log(100.0) == pytest.approx(0.4, abs=0.02)
        assert errors[-1] < 1e-5


def test_the_largest_clearance_of_a_free_mass_lies_a_percent_below_its_slow_manifold(tmp_path):
    """The curve of folds of T,2 turns there; the manifold keeps one harmonic of the motion."""
    main(["continuation", "published-vi-nes.toml", "-o", f"{tmp_path}/a.h5", "--quiet"])
    branches = open_archive(tmp_path / "a.h5")
    (fold,) = branches.curves
    least = fold.values[:, 0].argmin()
    assert 0 < least < len(fold.values) - 1
    force, omega = map(float, fold.values[least])
    system = branches.request.system.with_(P=force, omega=omega)
    p, best = system.parameters, slow_manifold(system).best
    orbit = simulate(system, 1, start=fold.states[least], record=("trajectory",))
    ours = p["C"] * p["c1"] * p["k1"] / force, np.abs(orbit.trajectory[:, 0]).max() / p["C"], omega
    published = np.array([0.33866, 0.5703, 0.98846])
    assert (best.Gamma, best.xi, best.r) == pytest.approx(published, rel=5e-5)
    assert 1.0 - ours / published == pytest.approx([9.5e-3, 2.0e-3, -8.5e-5], rel=0.05)


BETWEEN_WALLS = plain_phases.SYSTEM.with_(omega=1.0464736163637947)
T_6 = [-5.904600292051143, 1.6653780336231168, -5.836300239743613, 3.9872046900516933]
"""An orbit T,6 beside its folds at omega = 1.046565."""


def folds_of(system, low, high, start, **options):
    path = continue_branch(system, "omega", (low, high), start, period=1, quiet=True, **options)
    return path, located(path, "LP")


def test_a_curve_goes_on_where_an_impact_passes_phase_zero():
    path, points = folds_of(BETWEEN_WALLS, 1.042, 1.051, T_6, plane=("c1", 0.02, 0.06))
    (curve,) = path.curves
    assert curve.ends == ("bound", "bound")
    at_own = np.abs(curve.values[:, 1] - 0.04).argmin()
    assert curve.values[at_own, 0] == pytest.approx(points[0].value, abs=1e-5)
    assert np.abs(curve.multipliers - 1.0).min(axis=1).max() < 1e-5
    # at c1 = 0.0368 the impact passes phase zero: beyond it, a branch has the same folds
    i = int(np.abs(curve.values[:, 1] - 0.025).argmin())
    omega, c1 = curve.values[i]
    there = BETWEEN_WALLS.with_(c1=float(c1), omega=float(omega))
    state = curve.states[i] * (1.0 + 1e-7)
    path, points = folds_of(there, omega - 2e-3, omega + 2e-3, state)
    assert np.abs(points.value - omega).min() < 1e-8


def test_the_orbit_between_states_on_both_sides_of_an_impact_is_found():
    """That of T,2 strikes a wall at phase zero at omega = 1.212808."""
    omega, state = plain_phases.BEFORE
    path, _ = folds_of(BETWEEN_WALLS.with_(omega=omega), 1.2, 1.23, state)
    (branch,) = path.branches
    speed = branch.states[:, 3]  # of the damper, which an impact turns round
    (i,) = np.flatnonzero(np.abs(np.diff(speed)) > 10.0 * np.median(np.abs(np.diff(speed))))
    assert branch.parameter[i : i + 2].min() < 1.212808 < branch.parameter[i : i + 2].max()
    for share in (0.01, 0.5, 0.99):
        value = (1.0 - share) * branch.parameter[i] + share * branch.parameter[i + 1]
        (orbit,) = path.orbits_at(float(value))
        assert (orbit.label, orbit.stable) == ("T,2", False)
        assert min(abs(orbit.state[3] - speed[i]), abs(orbit.state[3] - speed[i + 1])) < 0.2
