"""Other people's solvers: each agrees with ours as far as its setting promises, or says why not."""

import importlib
import json
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.rivals import octave
from nlds_vines.accuracy.cases import near_grazing, of_system
from nlds_vines.accuracy.reference import FINEST, watched
from nlds_vines.accuracy.rivals import PEERS, Asked, PeerFailure, constants, derivative, installed
from nlds_vines.accuracy.rivals import rival as base
from nlds_vines.accuracy.rivals.equation import begin, indicator, jacobian, slope, switch
from nlds_vines.accuracy.rivals.rival import Track
from nlds_vines.archives import provenance
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.simulation import simulate

SET6 = load_system("ssul-set6", omega=6.28)
BOTH = load_system("ssbl", omega=6.05)
TMD = load_system("tmd", omega=6.28)
ALONE = load_system("none", omega=6.28)
PERIODS = 3

MODULES = ("numbalsoda", "heyoka", "sksundae", "diffrax", "jax", "optimistix")
"""What the extra `peers` brings, by the names that are imported."""

COARSE = {"steps": 1024, "rtol": 1e-5, "Octave": 1e-4}
FINE = {"steps": 16384, "rtol": 1e-9, "Octave": 1e-6}
BOUND = {"steps": 1e-6, "rtol": 1e-6, "Octave": 1e-4}
"""At the fine setting after `PERIODS`: of the state [m, m/s], and of E1max, relative."""

SPLIT = tuple(peer for peer in PEERS if peer.events)
QUICK = tuple(peer for peer in PEERS if peer.needs not in ("octave", "diffrax"))
NAIVE = PEERS[0]
OCTAVE = next(peer for peer in PEERS if peer.needs == "octave")

GRAZING = {1e-6: 1e-3, 1e-8: 1e-4, 1e-10: 1e-4, 1e-12: 1e-7}
"""Error of the times of touch near grazing [periods] by tolerance: a slow approach is blunt."""

# Octave takes long, and diffrax to compile: of these only some do all that there is to do
LONGER = tuple(p for p in PEERS if p.name in ("diffrax Tsit5", "Octave ode23s, Jacobian"))
ONCE = tuple(p for p in PEERS if p.name == "diffrax Tsit5, events")

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
    return pytest.mark.parametrize("peer", chosen, ids=lambda peer: peer.name)


def needed(peer):
    """Skip the test where what a peer needs is not installed."""
    if not peer.available():
        pytest.skip(f"{peer.needs} is not installed")


def of(values, peer):
    """Return the value for a peer; Octave's solver is of low order and has its own."""
    return values["Octave" if peer.needs == "octave" else peer.setting]


@cache
def prepared(peer):
    """Return the flow of a peer from rest: what it compiles serves several tests."""
    needed(peer)
    return peer.prepare(SET6, of_system(SET6).state)


@cache
def fine(peer):
    """Return the course of a peer at its fine setting, with touches and, of most, with E1max."""
    asked = Asked.ALL if peer in QUICK + LONGER else Asked.TOUCHES
    return prepared(peer)(of(FINE, peer), PERIODS, asked)


@pytest.fixture(scope="module")
def truth():
    return watched(replace(of_system(SET6), periods=PERIODS), **FINEST)


@pytest.fixture(scope="module")
def grazing():
    """Return a case whose contacts last a thousandth of a period, and the times of its touches."""
    case = replace(near_grazing(SET6), periods=PERIODS)
    touches = watched(case, **FINEST).impacts["touch"]
    assert len(touches) == PERIODS
    return case, touches


def distance(course, orbit):
    return float(np.abs(course.section - orbit.section).max())


# ---- agreement -----------------------------------------------------------------------------------


@each(PEERS)
def test_a_peer_agrees_with_ours(peer, truth):
    needed(peer)
    found = fine(peer)
    assert distance(found, truth) < of(BOUND, peer)


@each(QUICK + LONGER)
def test_the_largest_energy_is_ours(peer, truth):
    needed(peer)
    assert fine(peer).E1max == pytest.approx(truth.E1max, rel=of(BOUND, peer))


@each(SPLIT)
def test_events_are_the_touches(peer, truth):
    needed(peer)
    assert len(truth.impacts) == 2
    np.testing.assert_allclose(fine(peer).touches, truth.impacts["touch"], rtol=0, atol=1e-8)


@each([peer for peer in QUICK + ONCE if peer.events and peer.name not in BLUNT])
def test_near_grazing_no_touch_is_missed(peer, grazing):
    """The contacts are shorter than a step, and the ends of the steps show nothing of them."""
    needed(peer)
    case, touches = grazing
    flow = peer.prepare(case.system, case.state)
    for rtol, bound in GRAZING.items():
        found = flow(rtol, PERIODS, Asked.TOUCHES).touches
        np.testing.assert_allclose(found, touches, rtol=0, atol=bound * case.system.period)


@each([peer for peer in PEERS if peer.needs == "" and not peer.events])
def test_who_has_no_events_sees_touches_among_the_states(peer, truth):
    found = fine(peer)
    assert len(found.touches) == 2
    assert np.abs(found.touches - truth.impacts["touch"]).max() < 1e-6


def flow_between(fits):
    """Return a flow that knows the truth at the times wanted; it may fit its steps to these."""
    states = simulate(SET6, PERIODS, record=["trajectory"], samples=base.LOOKS).trajectory

    def follow(setting, times, watched):
        every = round(times[0] / SET6.period * base.LOOKS)
        return Track(states[every - 1 :: every] + (1e-9 / every if fits else 0.0))

    return base.flow_of(SET6, of_system(SET6).state, follow)


def test_touches_are_placed_between_the_states(truth):
    found = flow_between(False)(0.0, PERIODS, Asked.TOUCHES)
    np.testing.assert_allclose(found.touches, truth.impacts["touch"], rtol=0, atol=1e-9)


def test_who_fits_the_steps_to_the_times_cannot_tell_touches():
    assert flow_between(True)(0.0, PERIODS, Asked.TOUCHES).touches is None


@each(PEERS)
def test_a_tighter_setting_errs_less(peer, truth):
    needed(peer)
    coarse = prepared(peer)(of(COARSE, peer), PERIODS, False)
    assert coarse.touches is None
    assert coarse.E1max is None
    assert 1e-8 < distance(coarse, truth) < 1e-2
    assert distance(fine(peer), truth) < distance(coarse, truth) / 10


@each([peer for peer in SPLIT if peer.needs != "numbalsoda"])
def test_steps_in_contact_are_counted_where_they_can_be(peer):
    needed(peer)
    steps = fine(peer).steps_in_contact
    assert steps is None if peer.needs == "scikit-sundae" else 10 < steps < 1000


@each([peer for peer in QUICK + ONCE if peer.events])
def test_both_walls_are_met_from_within_a_contact(peer):
    """The start is a contact already: no touch, but it must be left, and the far wall met."""
    needed(peer)
    p, scene = BOTH.parameters, BOTH.scene
    start = (0.0, 0.0, scene.rest(p) - scene.gap_near(p) - 1e-3, 6.0)
    truth = simulate(BOTH, 1, start=start, record=["section", "impacts"], **FINEST)
    hits = truth.impacts[truth.impacts["touch"] > 0.0]
    assert set(hits["wall"]) == {"structure", "obstacle"}
    found = peer.prepare(BOTH, np.array(start))(1e-9, 1, Asked.TOUCHES)
    assert distance(found, truth) < 1e-6
    np.testing.assert_allclose(found.touches, hits["touch"], rtol=0, atol=1e-6)
    assert found.E1max is None


@each([peer for peer in QUICK if peer.events])
@pytest.mark.parametrize("speed", [-1.0, 1.0])
def test_a_start_on_the_wall_is_no_touch(peer, speed):
    """Into the wall or away from it: neither is an event that is found again at once."""
    needed(peer)
    p, scene = BOTH.parameters, BOTH.scene
    start = (0.0, 0.0, scene.rest(p) - scene.gap_near(p), speed)
    truth = simulate(BOTH, 1, start=start, record=["section", "impacts"], **FINEST)
    found = peer.prepare(BOTH, np.array(start))(1e-9, 1, Asked.TOUCHES)
    assert distance(found, truth) < 1e-6
    assert len(found.touches) == np.count_nonzero(truth.impacts["touch"] > 0.0)


@each(QUICK)
@pytest.mark.parametrize("system", [TMD, ALONE], ids=["tmd", "none"])
def test_without_a_wall_or_a_damper(peer, system):
    needed(peer)
    case = of_system(system)
    truth = simulate(system, PERIODS, record=["section"])
    found = peer.prepare(system, case.state)(of(FINE, peer), PERIODS, Asked.TOUCHES)
    assert found.section.shape == truth.section.shape
    assert distance(found, truth) < 1e-6
    assert found.touches.size == 0


def test_naive_steps_are_of_fourth_order_without_contact():
    truth = simulate(TMD, PERIODS, record=["section"])
    flow = NAIVE.prepare(TMD, of_system(TMD).state)
    errors = [distance(flow(steps, PERIODS, False), truth) for steps in (64, 128, 256, 512)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, NAIVE.order, atol=0.1)


# ---- failure -------------------------------------------------------------------------------------


def limited(peer, monkeypatch):
    """Give a peer next to nothing to spend."""
    (prepare,) = peer.prepare.args
    module = importlib.import_module(getattr(prepare, "func", prepare).__module__)
    for name, value in LIMITS[module.__name__.split(".")[-1]]:
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr(base, "EVENTS", 0)
    if program := getattr(module, "_program", None):  # what is compiled knows what it may spend
        monkeypatch.setattr(module, "_program", cache(program.__wrapped__))


@each([peer for peer in QUICK + LONGER + ONCE if peer != NAIVE])
def test_a_spent_budget_ends_the_orbit(peer, monkeypatch):
    needed(peer)
    limited(peer, monkeypatch)
    flow = peer.prepare(SET6, of_system(SET6).state)
    with pytest.raises(PeerFailure, match=r"more than|gave up|killed|limit|steps|max_num_steps"):
        flow(of(FINE, peer), PERIODS, False)


@each(PEERS)
def test_a_start_that_is_no_number_is_refused(peer):
    needed(peer)
    with pytest.raises(PeerFailure, match="not finite"):
        peer.prepare(SET6, np.array([0.0, np.nan, 0.0, 0.0]))


@each(QUICK + ONCE)
def test_a_state_beyond_all_numbers_is_a_failure(peer):
    needed(peer)
    flow = peer.prepare(SET6, np.array([0.0, 0.0, -1e300, 0.0]))
    with pytest.raises(PeerFailure):
        flow(of(COARSE, peer), 1, False)


def broken(error):
    """Return a peer whose flow raises an exception, and one that raises it when prepared."""

    def raising(*given):
        raise error

    return (replace(NAIVE, prepare=prepare) for prepare in (lambda *orbit: raising, raising))


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (TypeError("no such thing\nas this"), "^TypeError: no such thing$"),
        (ValueError(), "^ValueError$"),
        (RuntimeError("broken"), "^RuntimeError: broken$"),
        (PeerFailure("too stiff"), "^too stiff$"),
    ],
)
def test_any_exception_is_a_failure_in_one_sentence(error, words):
    for peer in broken(error):
        with pytest.raises(PeerFailure, match=words):
            peer.prepare(SET6, np.zeros(4))(256, 1, False)


def test_an_interruption_passes():
    for peer in broken(KeyboardInterrupt()):
        with pytest.raises(KeyboardInterrupt):
            peer.prepare(SET6, np.zeros(4))(256, 1, False)


def test_octave_that_prints_nothing_has_failed(monkeypatch):
    monkeypatch.setattr(octave, "_executed", lambda script, limit: "")
    with pytest.raises(PeerFailure):
        OCTAVE.prepare(SET6, of_system(SET6).state)(1e-3, 1, False)


# ---- what is installed ---------------------------------------------------------------------------

_ASKED = """
import json, sys
from nlds_vines.peers import installed
names = [peer.name for peer in installed()]
print(json.dumps([names, sorted(sys.modules)]))
"""


def test_asking_what_is_installed_imports_none_of_it():
    done = subprocess.run(
        [sys.executable, "-c", _ASKED], capture_output=True, text=True, check=True
    )
    names, modules = json.loads(done.stdout)
    assert names == [peer.name for peer in installed()]
    assert not set(MODULES) & set(modules)


def test_what_is_missing_is_listed_as_unavailable(monkeypatch):
    monkeypatch.setattr(base.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(base.shutil, "which", lambda name: None)
    names = {peer.name for peer in installed()}
    assert names == {peer.name for peer in PEERS if not peer.needs}
    assert len(names) == 11
    assert {peer.needs for peer in PEERS if peer.name not in names} == {
        "numbalsoda",
        "heyoka",
        "scikit-sundae",
        "diffrax",
        "octave",
    }


def test_octave_tells_its_version(monkeypatch):
    needed(OCTAVE)
    assert re.fullmatch(r"\d+\.\d+\.\d+", provenance.version.__wrapped__("octave"))
    monkeypatch.setattr(provenance.shutil, "which", lambda name: None)
    assert provenance.version.__wrapped__("octave") == "unknown"


def test_names_are_unique_and_settings_go_from_coarse_to_fine():
    assert len({peer.name for peer in PEERS}) == len(PEERS)
    for peer in PEERS:
        order = sorted(peer.settings, reverse=peer.setting == "rtol")
        assert list(peer.settings) == order
        assert peer.events == peer.name.endswith(", events")


# ---- the equation --------------------------------------------------------------------------------

STATES = {
    "near": (0.03, -0.4, 0.02, 1.5),  # the damper is pressed 1 cm against the structure
    "far": (-0.3, 0.2, 0.15, -0.7),  # and 3 cm against the obstacle
    "between": (0.01, 0.3, 0.1, -0.2),
}


@pytest.mark.parametrize("where", STATES)
def test_the_derivative_is_equation_5(where):
    p, (x1, v1, x2, v2) = BOTH.parameters, STATES[where]
    gap = x2 - x1
    pressed = {"near": 0.01, "far": -0.03, "between": 0.0}[where]
    assert pressed == pytest.approx(max(0.0, -gap) - max(0.0, gap - p["D"] - p["C"]))
    contact = BOTH.K * abs(pressed) ** 1.5 * np.sign(pressed)  # on the damper, towards +x2
    joint = p["k2"] * (gap - p["D"]) + p["c2"] * (v2 - v1)
    phase = 0.7
    force = p["P"] * np.cos(phase) - p["k1"] * x1 - p["c1"] * v1 + joint - contact
    by_hand = v1, force / p["m1"], v2, (contact - joint) / p["m2"]
    found = derivative(constants(BOTH), phase, x1, v1, x2, v2)
    np.testing.assert_allclose(found, by_hand, rtol=1e-12)


@pytest.mark.parametrize("system", [TMD, ALONE], ids=["tmd", "none"])
def test_the_derivative_without_a_wall(system):
    p = {"m2": 1.0, "k2": 0.0, "c2": 0.0, **system.parameters}
    x1, v1, x2, v2 = 0.02, -0.3, -0.9, 0.8
    joint = p["k2"] * (x2 - x1) + p["c2"] * (v2 - v1)
    force = p["P"] * np.cos(0.7) - p["k1"] * x1 - p["c1"] * v1 + joint
    found = derivative(constants(system), 0.7, x1, v1, x2, v2)
    np.testing.assert_allclose(found, (v1, force / p["m1"], v2, -joint / p["m2"]), rtol=1e-12)


@pytest.mark.parametrize("where", STATES)
def test_the_jacobian_is_that_of_the_slope(where):
    p, y, h = constants(BOTH), np.array(STATES[where]), 1e-7
    columns = [(slope(0.1, y + h * e, p) - slope(0.1, y - h * e, p)) / (2 * h) for e in np.eye(4)]
    np.testing.assert_allclose(jacobian(0.1, y, p), np.array(columns).T, rtol=1e-6, atol=1e-5)


def test_a_state_without_end_stops_the_solver():
    with pytest.raises(FloatingPointError, match="no longer finite"):
        slope(0.0, np.array([np.inf, 0.0, 0.0, 0.0]), constants(SET6))


@pytest.mark.parametrize(
    ("where", "inside", "wall"), [("near", 1, 0), ("far", 1, 1), ("between", 0, 0)]
)
def test_a_piece_knows_its_wall(where, inside, wall):
    p, y, watch = constants(BOTH), np.array(STATES[where]), np.zeros(3)
    begin(p, y, watch)
    assert watch[0] == inside
    assert watch[1] == wall
    assert np.isnan(watch[2])
    assert (indicator(p, watch, 0.0, y) > 0.0) == bool(inside)


def test_a_switch_forgets_the_depth_of_its_moment():
    """On the wall the sign of the depth is round-off; the indicator has that of the speed."""
    p, watch = constants(BOTH), np.array([0.0, 0.0, np.nan])
    touch = np.array([0.02, 0.5, 0.02, -0.5])  # the structure is met at 1 m/s
    assert switch(p, 2.0, touch, watch)
    assert watch.tolist() == [1.0, 0.0, 2.0]
    assert indicator(p, watch, 2.0, touch) == pytest.approx(1.0)
    deeper = touch + np.array([1e-3, 0.0, 0.0, 0.0])
    assert indicator(p, watch, 2.5, deeper) == pytest.approx(1e-3 / 0.5)
    assert not switch(p, 3.0, touch, watch)
    assert watch.tolist() == [0.0, 0.0, 3.0]
