"""Every contact law in all records, beside a twin that is written from the equations alone.

A few of the random cases that `test_laws.py` goes through by the thousand; and whatever is noted of
an orbit both methods note the same, where it is at its most awkward: starts at and in a wall, many
impacts in a cell, samples within impacts. Run by `contract/test_plain.py`, as each is of another
sort, and would be compiled for itself.
"""

import numpy as np
import pytest
from random_laws import LOADED, Case, allowed, case_of, errors_of, worst_of
from support import references, system_of
from twin_of_laws import Law, Model, Wall

from nlds_vines.engine.simulation import simulate
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System

# One of each kind and law: by Hertz, with a limit, linear, restitution, a power, in a scene with a
# load; in case 30 a damped wall lets go.
SAMPLE = (0, 8, 9, 14, 15, 20, 25, 27, 30, 67, 82)
FIXED = (8, 13, 20, 82, 107)
ROUGH = (13, 20)  # of which


@pytest.fixture(autouse=True)
def a_scene_with_a_load(monkeypatch):
    monkeypatch.setitem(SCENES, LOADED.kind, LOADED)


@pytest.mark.parametrize("i", SAMPLE)
def test_as_the_twin_sees_it(i):
    errors = errors_of(case_of(i), 1e-9)
    assert worst_of(errors) <= allowed(1e-9), errors
    assert i != 30 or errors["let go"] > 0


@pytest.mark.parametrize("i", FIXED)
def test_fixed_steps_as_the_twin_sees_it(i):
    errors = errors_of(case_of(i), 0.0, {"method": "rk4", "period_steps": 512.0})
    assert worst_of(errors) <= (1e-4 if i in ROUGH else 1e-7), errors


def test_a_wall_that_has_let_go_pushes_again():
    """A mass leaves a stop faster than 1 / a; the spring that presses it slows it down in there."""
    p = {"m": 1.0, "k": 400.0, "c": 0.5, "P": 5.0, "omega": 40.0, "C": -0.1}
    system = System("oscillator", {**p, "K": 1e4, "hunt_crossley": 3.0})
    stop = Wall(0, 1.0, -0.1, Law("hertz", K=1e4, a=3.0))
    model = Model(1.0, 400.0, 0.5, 5.0, 40.0, walls=(stop,))
    errors = errors_of(Case(system, model, np.array([-0.05, -0.5])), 1e-12)
    assert errors["pushes again"] >= 1
    assert worst_of(errors) <= allowed(1e-12), errors


def test_an_error_is_seen():
    """The twin of another mass, by a millionth."""
    case = case_of(27)
    wrong = case._replace(model=case.model.__class__(**{**vars(case.model), "m1": 1.000001}))
    assert worst_of(errors_of(case, 1e-9)) <= allowed(1e-9)
    assert worst_of(errors_of(wrong, 1e-9)) > 100 * allowed(1e-9)


SSBL = references()["ssbl-omega6.05"].numbers
WALLED = ("trajectory", "section", "impacts", "energy", "peak", "clearance")
COLUMNS = ("touch", "release", "speed", "force", "depth", "gain1", "gain2")
BOUND = 1e-6  # of a difference, relative to the largest of its kind


def assert_near(one, other, scale):
    np.testing.assert_allclose(one, other, rtol=0, atol=BOUND * scale)


def compare(system, start, periods):
    """Compare all that both methods note; return the orbit by the exact one."""
    options = {"start": start, "record": WALLED, "samples": 4}
    exact = simulate(system, periods, contact_steps=60.0, nodes=20, **options)
    steps = simulate(system, periods, method="rk4", period_steps=1024.0, **options)
    np.testing.assert_array_equal(exact.time, steps.time)
    assert_near(exact.trajectory, steps.trajectory, np.abs(exact.trajectory).max())
    np.testing.assert_array_equal(exact.section, exact.trajectory[3::4])
    for name in ("E1max", "E2max", "E1peak", "E2peak", "clearance"):
        one, other = getattr(exact, name), getattr(steps, name)
        assert (one is None) == (other is None), name
        if one is not None and np.isfinite([one, other]).any():
            least = 0.05 * BOUND if name == "clearance" else 0.0
            assert one == pytest.approx(other, rel=BOUND, abs=least), name
    for orbit in (exact, steps):
        assert orbit.E1peak >= orbit.E1max
        assert orbit.E2peak is None or orbit.E2peak >= orbit.E2max
    law = system.K * exact.impacts["depth"] ** 1.5
    np.testing.assert_allclose(exact.impacts["force"], law, rtol=1e-12)
    assert exact.impacts["wall"].tolist() == steps.impacts["wall"].tolist()
    for name in COLUMNS:
        one, other = exact.impacts[name], steps.impacts[name]
        np.testing.assert_array_equal(np.isnan(one), np.isnan(other))
        both = ~np.isnan(one if name in ("touch", "speed") else exact.impacts["release"])
        if both.any():
            assert_near(one[both], other[both], 10 * np.abs(one[both]).max())
    if exact.violation is not None:
        one, other = exact.violation, steps.violation
        assert one.number == other.number
        assert one.depth == pytest.approx(other.depth, abs=1e-8)
        np.testing.assert_allclose(one.time, other.time, rtol=1e-7)
    return exact


@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_an_energy_may_be_largest_at_a_touch(method):
    """A damper on a spring that pulls it on hits a wall, and leaves it with what its dashpot left.

    The structure hardly moves, so that E2 = m2 v2^2 / 2 + k2 (x2 - rest)^2 / 2 in its flight.
    """
    numbers = {**SSBL, "m1": 1e9, "k1": 1e3, "c1": 0.0, "P": 0.0, "c2": 20.0, "K": 1e7}
    system = system_of("ssbl", {**numbers, "C": 0.05, "D": 0.05, "omega": 40.0})
    start = (0.1, 0.0, 0.1 + system.rest, 1.0)
    options = {} if method == "exact" else {"method": method, "period_steps": 2048.0}
    orbit = simulate(system, 1, start=start, record=WALLED, samples=8, **options)
    (hit,) = orbit.impacts
    assert hit["wall"] == "obstacle"
    work = 0.5 * numbers["k2"] * ((0.1 + 0.05) ** 2 - 0.1**2)
    touch = 0.5 * numbers["m2"] * hit["speed"] ** 2 + 0.5 * numbers["k2"] * 0.15**2
    assert 0.0 < work < touch
    assert orbit.E2max == pytest.approx(touch, rel=1e-5)


STARTS = {
    # r - gap [m] at the near or -r - gap at the far wall, and the speed towards it [m/s]
    "on it, moving in": (0.0, 0.5),
    "on it, moving away": (0.0, -0.5),
    "inside, moving in": (0.004, 0.3),
    "inside, at rest": (0.004, 0.0),
    "inside, moving away": (0.004, -0.3),
}


@pytest.mark.parametrize("wall", ["near", "far"])
@pytest.mark.parametrize("begin", STARTS)
def test_starts_at_a_wall(begin, wall):
    """On it moving in, the first touch is that of the first instant; begun inside, none is."""
    depth, speed = STARTS[begin]
    numbers = {**SSBL, "C": 0.03125, "D": 0.0625, "K": 1e6, "m1": 1000.0, "m2": 60.0}
    system = system_of("ssbl", numbers)
    r, s = (system.rest + depth, speed) if wall == "near" else (-0.03125 - depth, -speed)
    start = (0.0, 0.0, system.rest - r, -s)
    orbit = compare(system, start, 2)
    first = orbit.impacts[0]
    if begin == "on it, moving in":
        assert first["touch"] == 0.0
        assert first["speed"] == 0.5
        assert first["wall"] == ("structure" if wall == "near" else "obstacle")
    else:
        assert first["touch"] > 0.01


@pytest.mark.parametrize(
    ("kind", "s"), [("ssul", 4.0), ("ssbl", -4.0), ("ssvi-b", 4.0), ("ssvi-c", -4.0)]
)
def test_a_fast_damper_strikes_several_times_in_a_cell(kind, s):
    """A cell is an eighth of a period; the damper crosses its way in a hundredth."""
    numbers = {**SSBL, "C": 0.03, "D": 0.02, "L": 0.01, "V": 0.2, "K": 1e8, "P": 800.0}
    system = system_of(kind, {**numbers, "k2": 7000.0})
    orbit = compare(system, (0.001, 0.1, 0.001 + system.rest, 0.1 - s), 1)
    assert len(orbit.impacts) >= (3 if kind == "ssbl" else 1)
    if orbit.violation is not None:
        assert orbit.violation.number >= 1


@pytest.mark.parametrize(
    ("kind", "K", "options", "bound"),
    [(kind, K, {"contact_steps": 60.0, "nodes": 20}, 1e-9)
     for kind in ("ssul", "ssbl") for K in (1e6, 1e8)] + [("ssul", 1e8, {}, 1e-8)],
)  # fmt: skip
def test_samples_within_impacts_are_states_of_the_orbit_and_change_no_section(
    kind, K, options, bound
):
    """A short impact is one only if it ends before the next sample."""
    system = system_of(kind, {**SSBL, "K": K, "C": 0.02, "V": 0.2, "D": 0.02})
    few = simulate(system, 3, record=WALLED[1:3], **options)
    many = simulate(system, 3, record=WALLED[:3], samples=200, **options)
    np.testing.assert_allclose(many.section, few.section, rtol=0, atol=bound)
    assert len(few.impacts) > 1
    for name in COLUMNS:
        one, other = many.impacts[name], few.impacts[name]
        np.testing.assert_allclose(one, other, rtol=100 * bound, atol=bound)
    inside = [
        np.count_nonzero((hit["touch"] < many.time) & (many.time < hit["release"]))
        for hit in few.impacts
    ]
    assert sum(inside) > 0
    steps = simulate(
        system, 1, record=("trajectory",), samples=200, method="rk4", period_steps=2000.0
    ).trajectory
    scale = np.abs(many.trajectory).max(axis=0)
    np.testing.assert_allclose(many.trajectory[:200] / scale, steps / scale, atol=1e-6)
