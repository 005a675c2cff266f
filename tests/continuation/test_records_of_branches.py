"""Branches: intervals along ratios, and records beside an independent integrator."""

from math import pi, sqrt

import numpy as np
import pytest
import twin

import nlds_vines as nv
from nlds_vines.continuation.command import Job
from nlds_vines.continuation.request import load_continuation


def by_the_twin(system, branch, periods):
    """Return (orbit number, largest force, course) of each orbit of a branch, by the twin."""
    numbers = {**system.parameters, "K": system.K}
    models = [twin.model_of({**numbers, "omega": omega}) for omega in branch.parameter]
    for i, course in enumerate(twin.follow_all(models, branch.states, periods)):
        depths = course.contacts[:, 4].astype(float)
        yield i, system.K * depths.max(initial=0.0) ** 1.5, course


def test_a_contact_that_straddles_phase_zero_counts_whole():
    """Its first part alone gave 289 N for 30,680 N at 6.2305 rad/s.

    Every record is that of the second n periods of the twin, which sees the contact whole.
    """
    system = nv.load_system("ssul-set6", omega=6.23)
    path = nv.continue_branch(system, parameter="omega", bounds=(6.22, 6.24), step=0.2, quiet=True)
    (branch,) = path.branches
    inside = branch.states[:, 2] - branch.states[:, 0] < system.parameters["V"]
    assert 1 < inside.sum() < len(inside) - 1
    n = branch.period
    for i, force, course in by_the_twin(system, branch, 2 * n):
        before = n * 2.0 * np.pi / branch.parameter[i]
        cycle = course.touches[course.touches[:, 1] >= before]
        began = (course.contacts[:, 1] < before).sum()
        assert branch.impacts[i].sum() == len(cycle) == began
        speeds, misses = cycle[:, 3].astype(float), -course.misses[:, 2].astype(float)
        expected = {
            "largest_force": force,
            "fastest_impact": speeds.max(initial=0.0),
            "softest_impact": speeds.min(initial=np.inf),
            "clearance": misses.min(initial=np.inf),
            "E1max": float(course.E1max),
            "E2max": float(course.E2max),
        }
        for name, value in expected.items():
            assert getattr(branch, name)[i] == pytest.approx(value, rel=1e-9), name


def test_a_contact_that_never_ends_has_a_force():
    """A pressed damper rests on the obstacle for whole periods, without an impact."""
    system = nv.load_system("ssul-set6", omega=6.28, C=-0.01, P=1.0)
    path = nv.continue_branch(system, parameter="omega", bounds=(6.2, 6.3), step=0.5, quiet=True)
    (branch,) = path.branches
    assert (branch.impacts == 0).all()
    for i, force, course in by_the_twin(system, branch, 1):
        assert len(course.contacts) == 1
        assert branch.largest_force[i] == pytest.approx(force, rel=1e-9)


SIX = nv.load_system("ssul-set6").parameters


def between(**ends):
    return {name: {"start": low, "stop": high} for name, (low, high) in ends.items()}


@pytest.mark.parametrize(
    ("name", "low", "high", "gives", "unit"),
    [
        ("f", 0.9, 1.2, "omega", 2 * pi),
        ("omega_ratio", 0.9, 1.1, "omega", sqrt(SIX["k1"] / SIX["m1"])),
        ("zeta1", 0.01, 0.05, "c1", 2 * sqrt(SIX["k1"] * SIX["m1"])),
    ],
)
def test_the_interval_is_that_of_the_parameter(name, low, high, gives, unit, monkeypatch):
    table = {"along": between(**{name: (low, high)})}
    of_file = load_continuation({"system": "ssul-set6", **table}).along
    of_options = load_continuation("ssul-set6", table, "command line").along
    monkeypatch.setattr(Job, "compute", lambda request, *_: request)
    of_python = nv.continue_branch("ssul-set6", name, (low, high)).along
    assert of_file == of_options == of_python
    assert of_file.name == gives
    assert (of_file.low, of_file.high) == (low * unit, high * unit)


def test_the_interval_follows_parameters_that_are_set_and_the_second_may_be_a_ratio():
    table = {"along": between(omega_ratio=(0.9, 1.1)), "plane": between(zeta1=(0.01, 0.1))}
    request = load_continuation("ssul-set6", {"set": {"k1": 4e4}, **table})
    assert request.along.low == 0.9 * sqrt(4e4 / SIX["m1"])
    assert request.plane.name == "c1"
    assert request.plane.high == 0.1 * 2 * sqrt(4e4 * SIX["m1"])
    assert load_continuation(request.document()) == request


def test_a_frequency_that_is_stated_in_hz_is_drawn_and_told_in_hz(tmp_path):
    """The request keeps f, from which the bits of omega follow again."""
    path = tmp_path / "hertz.h5"
    nv.continue_branch("ssul-set6", "f", (0.98, 1.0), step=0.5, to=path, quiet=True)
    archive = nv.open_archive(path)
    assert (archive.request.along.low, archive.request.along.high) == (2 * pi * 0.98, 2 * pi)
    assert archive.request.along.heading() == "f from 0.98 to 1 Hz (6.158 to 6.283 rad/s)"
    assert archive.request.document()["along"] == {"f": {"start": 0.98, "stop": 1.0}}
    assert archive.request.title.endswith("along f")
    labels = [axes.get_xlabel() for axes in nv.plot(path).axes]
    assert "frequency of the force $f$ [Hz]" in labels
    table = {"along": between(P=(700, 900)), "plane": between(f=(1, 2))}
    request = load_continuation("ssul-set6", {"set": {"omega": 7.0}, **table})
    assert request.plane.heading().startswith("f from 1 to 2 Hz")
    assert load_continuation(request.document()) == request


@pytest.mark.parametrize(
    ("along", "plane", "words"),
    [
        (between(f=(0.0, 1.0)), {}, r"\[along\].*f.*0"),
        (between(f=("x", 1.0)), {}, "start of f = 'x' must be a number"),
        (between(zeta=(0.1, 1.0)), {}, "zeta"),
        (
            between(omega_ratio=(0.9, 1.0)), between(k1=(3e4, 5e4)),
            "omega_ratio follows from k1, which is free, too: give omega",
        ),
        (between(f=(0.9, 1.0)), between(omega=(6.0, 7.0)), "omega is free already"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_refused(along, plane, words):
    with pytest.raises(nv.RequestError, match=words):
        load_continuation("ssul-set6", {"along": along, "plane": plane}, "a test")
