"""Other people's solvers: each agrees with ours as far as its setting promises, or says why not."""

import importlib
import json
import re
import runpy
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from commands import printed

from benchmarks.accuracy.cases import near_grazing
from benchmarks.rivals import RIVALS, installed, octave
from benchmarks.rivals import rival as base
from benchmarks.rivals.rival import Asked, SolverFailure
from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.accuracy.reference import FINEST
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.simulation import simulate

SET6 = load_system("ssul-set6", omega=6.28)
BOTH = load_system("ssbl", omega=6.05)
TMD = load_system("tmd", omega=6.28)
ALONE = load_system("none", omega=6.28)
PERIODS = 3

ROOT = Path(__file__).parents[2]
OURS = tuple(rival for rival in RIVALS if not rival.needs)
OTHERS = tuple(rival for rival in RIVALS if rival.needs)

MODULES = ("numbalsoda", "heyoka", "sksundae", "diffrax", "jax", "optimistix")
"""What the extra `peers` brings, by the names that are imported."""

COARSE = {"steps": 1024, "rtol": 1e-5, "Octave": 1e-4}
FINE = {"steps": 16384, "rtol": 1e-9, "Octave": 1e-6}
BOUND = {"steps": 1e-6, "rtol": 1e-6, "Octave": 1e-4}
"""At the fine setting after `PERIODS`: of the state [m, m/s], and of E1max, relative."""

SPLIT = tuple(rival for rival in RIVALS if rival.events)
QUICK = tuple(rival for rival in RIVALS if rival.needs not in ("octave", "diffrax"))
NAIVE = RIVALS[0]
OCTAVE = next(rival for rival in RIVALS if rival.needs == "octave")

GRAZING = {1e-6: 1e-3, 1e-8: 1e-4, 1e-10: 1e-4, 1e-12: 1e-7}
"""Error of the times of touch near grazing [periods] by tolerance: a slow approach is blunt."""

# Octave takes long, and diffrax to compile: of these only some do all that there is to do
LONGER = tuple(p for p in RIVALS if p.name in ("diffrax Tsit5", "Octave ode23s, Jacobian"))
ONCE = tuple(p for p in RIVALS if p.name == "diffrax Tsit5, events")

BLUNT = ("SciPy Radau, events", "SciPy BDF, events")
"""Near grazing they take long, or at 1e-6 err by more than the depth of a touch."""

LIMITS = {
    "scipy_solvers": [("BUDGET_IN_PYTHON", 20)],
    "numbalsoda_solvers": [("BUDGET", 20)],
    "heyoka_taylor": [("BUDGET", 2)],
    "sundials": [("BUDGET_IN_PYTHON", 20)],
    "diffrax_solvers": [("BUDGET", 4)],
    "octave": [("PATIENCE", 0.01), ("PATIENCE_FOR_PERIOD", 0.0)],
}
"""What ends an orbit that would last for ever, by module, and a value that ends any orbit."""


def each(chosen):
    """Run a test for each of some rivals that is installed."""
    here = [rival for rival in chosen if rival.available()]
    return pytest.mark.parametrize("rival", here, ids=lambda rival: rival.name)


def of(values, rival):
    """Return the value for a rival; Octave's solver is of low order and has its own."""
    return values["Octave" if rival.needs == "octave" else rival.setting]


@cache
def prepared(rival):
    """Return the flow of a rival from rest: what it compiles serves several tests."""
    return rival.prepare(SET6, Case.of(SET6).state)


@cache
def fine(rival):
    """Return the course of a rival at its fine setting, with touches and, of most, with E1max."""
    asked = Asked.ALL if rival in QUICK + LONGER else Asked.TOUCHES
    return prepared(rival)(of(FINE, rival), PERIODS, asked)


@pytest.fixture(scope="module")
def truth():
    """Return the true orbit, with its energies over the last half of the periods."""
    half = PERIODS // 2
    late = simulate(SET6, PERIODS - half, transient=half, record=["energy"], **FINEST)
    whole = simulate(SET6, PERIODS, record=["section", "impacts"], **FINEST)
    return replace(whole, E1max=late.E1max)


@pytest.fixture(scope="module")
def grazing():
    """Return a case whose contacts last a thousandth of a period, and the times of its touches."""
    case = replace(near_grazing(SET6), periods=PERIODS)
    orbit = simulate(
        case.system, PERIODS, start=case.start, record=["section", "impacts"], **FINEST
    )
    touches = orbit.impacts["touch"]
    assert len(touches) == PERIODS
    return case, touches


def distance(course, orbit):
    return float(np.abs(course.section - orbit.section).max())


# ---- agreement -----------------------------------------------------------------------------------


@pytest.mark.kernels
@each(RIVALS)
def test_a_rival_agrees_with_ours(rival, truth):
    found = fine(rival)
    assert distance(found, truth) < of(BOUND, rival)


@pytest.mark.kernels
@each(QUICK + LONGER)
def test_the_largest_energy_is_ours(rival, truth):
    assert fine(rival).E1max == pytest.approx(truth.E1max, rel=of(BOUND, rival))


@pytest.mark.kernels
@each(SPLIT)
def test_events_are_the_touches(rival, truth):
    assert len(truth.impacts) == 2
    np.testing.assert_allclose(fine(rival).touches, truth.impacts["touch"], rtol=0, atol=1e-8)


@pytest.mark.kernels
@each([rival for rival in QUICK + ONCE if rival.events and rival.name not in BLUNT])
def test_near_grazing_no_touch_is_missed(rival, grazing):
    """The contacts are shorter than a step, and the ends of the steps show nothing of them."""
    case, touches = grazing
    flow = rival.prepare(case.system, case.state)
    for rtol, bound in GRAZING.items():
        found = flow(rtol, PERIODS, Asked.TOUCHES).touches
        np.testing.assert_allclose(found, touches, rtol=0, atol=bound * case.system.period)


@pytest.mark.kernels
@each([rival for rival in RIVALS if rival.needs == "" and not rival.events])
def test_who_has_no_events_sees_touches_among_the_states(rival, truth):
    found = fine(rival)
    assert len(found.touches) == 2
    assert np.abs(found.touches - truth.impacts["touch"]).max() < 1e-6


@pytest.mark.kernels
@each(RIVALS)
def test_a_tighter_setting_errs_less(rival, truth):
    coarse = prepared(rival)(of(COARSE, rival), PERIODS, False)
    assert coarse.touches is None
    assert coarse.E1max is None
    assert 1e-8 < distance(coarse, truth) < 1e-2
    assert distance(fine(rival), truth) < distance(coarse, truth) / 10


@pytest.mark.kernels
@each([rival for rival in SPLIT if rival.needs != "numbalsoda"])
def test_steps_in_contact_are_counted_where_they_can_be(rival):
    steps = fine(rival).steps_in_contact
    assert steps is None if rival.needs == "scikit-sundae" else 10 < steps < 1000


@pytest.mark.kernels
@each([rival for rival in QUICK + ONCE if rival.events])
def test_both_walls_are_met_from_within_a_contact(rival):
    """The start is a contact already: no touch, but it must be left, and the far wall met."""
    p, scene = BOTH.parameters, BOTH.scene
    start = (0.0, 0.0, scene.rest(p) - scene.gap_near(p) - 1e-3, 6.0)
    truth = simulate(BOTH, 1, start=start, record=["section", "impacts"], **FINEST)
    hits = truth.impacts[truth.impacts["touch"] > 0.0]
    assert set(hits["wall"]) == {"structure", "obstacle"}
    found = rival.prepare(BOTH, np.array(start))(1e-9, 1, Asked.TOUCHES)
    assert distance(found, truth) < 1e-6
    np.testing.assert_allclose(found.touches, hits["touch"], rtol=0, atol=1e-6)
    assert found.E1max is None


@pytest.mark.kernels
@each([rival for rival in QUICK if rival.events])
@pytest.mark.parametrize("speed", [-1.0, 1.0])
def test_a_start_on_the_wall_is_no_touch(rival, speed):
    """Into the wall or away from it: neither is an event that is found again at once."""
    p, scene = BOTH.parameters, BOTH.scene
    start = (0.0, 0.0, scene.rest(p) - scene.gap_near(p), speed)
    truth = simulate(BOTH, 1, start=start, record=["section", "impacts"], **FINEST)
    found = rival.prepare(BOTH, np.array(start))(1e-9, 1, Asked.TOUCHES)
    assert distance(found, truth) < 1e-6
    assert len(found.touches) == np.count_nonzero(truth.impacts["touch"] > 0.0)


@pytest.mark.kernels
@each(QUICK)
@pytest.mark.parametrize("system", [TMD, ALONE], ids=["tmd", "none"])
def test_without_a_wall_or_a_damper(rival, system):
    case = Case.of(system)
    truth = simulate(system, PERIODS, record=["section"])
    found = rival.prepare(system, case.state)(of(FINE, rival), PERIODS, Asked.TOUCHES)
    assert found.section.shape == truth.section.shape
    assert distance(found, truth) < 1e-6
    assert found.touches.size == 0


@pytest.mark.kernels
def test_naive_steps_are_of_fourth_order_without_contact():
    truth = simulate(TMD, PERIODS, record=["section"])
    flow = NAIVE.prepare(TMD, Case.of(TMD).state)
    errors = [distance(flow(steps, PERIODS, False), truth) for steps in (64, 128, 256, 512)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, NAIVE.order, atol=0.1)


# ---- failure -------------------------------------------------------------------------------------


def limited(rival, monkeypatch):
    """Give a rival next to nothing to spend."""
    (prepare,) = rival.prepare.args
    module = importlib.import_module(getattr(prepare, "func", prepare).__module__)
    for name, value in LIMITS[module.__name__.split(".")[-1]]:
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr(base, "EVENTS", 0)
    if program := getattr(module, "_program", None):  # what is compiled knows what it may spend
        monkeypatch.setattr(module, "_program", cache(program.__wrapped__))


@pytest.mark.kernels
@each([rival for rival in QUICK + LONGER + ONCE if rival != NAIVE])
def test_a_spent_budget_ends_the_orbit(rival, monkeypatch):
    limited(rival, monkeypatch)
    flow = rival.prepare(SET6, Case.of(SET6).state)
    with pytest.raises(SolverFailure, match=r"more than|gave up|killed|limit|steps|max_num_steps"):
        flow(of(FINE, rival), PERIODS, False)


@each(RIVALS)
def test_a_start_that_is_no_number_is_refused(rival):
    with pytest.raises(SolverFailure, match="not finite"):
        rival.prepare(SET6, np.array([0.0, np.nan, 0.0, 0.0]))


@pytest.mark.kernels
@each(QUICK + ONCE)
def test_a_state_beyond_all_numbers_is_a_failure(rival):
    flow = rival.prepare(SET6, np.array([0.0, 0.0, -1e300, 0.0]))
    with pytest.raises(SolverFailure):
        flow(of(COARSE, rival), 1, False)


def test_octave_that_prints_nothing_has_failed(monkeypatch):
    monkeypatch.setattr(octave, "_executed", lambda script, limit: "")
    with pytest.raises(SolverFailure):
        OCTAVE.prepare(SET6, Case.of(SET6).state)(1e-3, 1, False)


# ---- what is installed ---------------------------------------------------------------------------

_ASKED = """
import json, sys
from benchmarks.rivals import installed
names = [rival.name for rival in installed()]
print(json.dumps([names, sorted(sys.modules)]))
"""


def test_asking_what_is_installed_imports_none_of_it():
    names, modules = json.loads(printed("-c", _ASKED))
    assert names == [rival.name for rival in installed()]
    assert not set(MODULES) & set(modules)


def test_no_rival_is_left_out():
    """One test is skipped for all that are: most of them come with the extra `peers`."""
    missing = {rival.needs for rival in RIVALS if not rival.available()}
    if missing:
        pytest.skip(f"not installed, and not compared: {', '.join(sorted(missing))}")
    assert {rival.name for rival in installed()} == {rival.name for rival in RIVALS}


def test_what_is_missing_is_listed_as_unavailable(monkeypatch):
    monkeypatch.setattr(base.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(octave.shutil, "which", lambda name: None)
    assert installed() == OURS
    assert len(OURS) == 11
    assert {rival.needs for rival in OTHERS} == {
        "numbalsoda",
        "heyoka",
        "scikit-sundae",
        "diffrax",
        "octave",
    }


def test_octave_that_cannot_be_asked_has_no_version(monkeypatch):
    monkeypatch.setattr(octave, "_PROGRAM", "no-such-octave")
    assert OCTAVE.version() == "unknown"


def test_what_is_installed_has_a_version():
    versions = {rival.needs: rival.version() for rival in OTHERS if rival.available()}
    assert all(re.match(r"\d+\.\d+", version) for version in versions.values())
    assert re.fullmatch(r"\d+\.\d+\.\d+", versions.get("octave", "9.2.0"))


def test_the_command_measures_every_rival_that_is_installed(capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["accuracy", "--dry-run"])
    with pytest.raises(SystemExit) as stop:
        runpy.run_module("benchmarks.accuracy.__main__", run_name="__main__")
    assert stop.value.code == 0
    names = {line.partition(": ")[2] for line in capsys.readouterr().out.splitlines()}
    assert names == {"exact", "rk4"} | {rival.name for rival in installed()}


def test_names_are_unique_and_settings_go_from_coarse_to_fine():
    assert len({rival.name for rival in RIVALS}) == len(RIVALS)
    for rival in RIVALS:
        order = sorted(rival.settings, reverse=rival.setting == "rtol")
        assert list(rival.settings) == order
        assert rival.events == rival.name.endswith(", events")
