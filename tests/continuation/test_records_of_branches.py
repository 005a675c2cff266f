"""Branches: intervals along ratios, and records beside an independent integrator."""

from math import pi, sqrt

import numpy as np
import pytest
import twin

import nlds_vines as nv
from nlds_vines.continuation.command import Job
from nlds_vines.continuation.request import load_continuation


def assert_records_are_those_of_the_twin(system, branch):
    """Compare every record of every orbit with those of its second n periods by the twin.

    A contact under way at phase zero began in the first n periods, so the twin sees it whole.
    """
    n, omegas = branch.period, branch.parameter
    models = [
        twin.model_of({**system.parameters, "K": system.K, "omega": omega}) for omega in omegas
    ]
    lanes = twin.follow_all(models, branch.states, 2 * n)
    for i, (course, omega) in enumerate(zip(lanes, omegas, strict=True)):
        period = 2.0 * np.pi / omega
        touch, depth = course.contacts[:, 1], course.contacts[:, 4]
        force = system.K * float(depth.max()) ** 1.5 if len(depth) else 0.0
        assert branch.largest_force[i] == pytest.approx(force, rel=1e-9)
        cycle = course.touches[course.touches[:, 1] >= n * period]
        assert branch.impacts[i].sum() == len(cycle) == (touch < n * period).sum()
        speeds = cycle[:, 3].astype(float)
        assert branch.fastest_impact[i] == pytest.approx(speeds.max(initial=0.0), rel=1e-9)
        assert branch.softest_impact[i] == pytest.approx(speeds.min(initial=np.inf), rel=1e-9)
        misses = -course.misses[:, 2].astype(float)
        assert branch.clearance[i] == pytest.approx(misses.min(initial=np.inf), rel=1e-9)
        assert branch.E1max[i] == pytest.approx(float(course.E1max), rel=1e-9)
        assert branch.E2max[i] == pytest.approx(float(course.E2max), rel=1e-9)


def test_a_contact_that_straddles_phase_zero_counts_whole():
    """Its first part alone gave 289 N for 30,680 N at 6.2305 rad/s."""
    system = nv.load_system("ssul-set6", omega=6.23)
    path = nv.continue_branch(system, parameter="omega", bounds=(6.22, 6.24), step=0.2, quiet=True)
    (branch,) = path.branches
    inside = branch.states[:, 2] - branch.states[:, 0] < system.parameters["V"]
    assert 1 < inside.sum() < len(inside) - 1
    assert_records_are_those_of_the_twin(system, branch)


def test_a_contact_that_never_ends_has_a_force():
    """A pressed damper rests on the obstacle for whole periods, without an impact."""
    system = nv.load_system("ssul-set6", omega=6.28, C=-0.01, P=1.0)
    (branch,) = nv.continue_branch(
        system, parameter="omega", bounds=(6.2, 6.3), step=0.5, quiet=True
    ).branches
    assert (branch.impacts == 0).all()
    omegas = branch.parameter
    models = [twin.model_of({**system.parameters, "K": system.K, "omega": w}) for w in omegas]
    for course, force in zip(
        twin.follow_all(models, branch.states, 1), branch.largest_force, strict=True
    ):
        (contact,) = course.contacts
        assert force == pytest.approx(system.K * float(contact[4]) ** 1.5, rel=1e-9)


SIX = nv.load_system("ssul-set6").parameters
OMEGA0 = sqrt(SIX["k1"] / SIX["m1"])


@pytest.mark.parametrize(
    ("name", "low", "high", "gives", "unit"),
    [
        ("f", 0.9, 1.2, "omega", 2 * pi),
        ("omega_ratio", 0.9, 1.1, "omega", OMEGA0),
        ("zeta1", 0.01, 0.05, "c1", 2 * sqrt(SIX["k1"] * SIX["m1"])),
    ],
)
def test_the_interval_is_that_of_the_parameter(name, low, high, gives, unit, monkeypatch):
    table = {"along": {name: {"start": low, "stop": high}}}
    of_file = load_continuation({"system": "ssul-set6", **table}).along
    of_options = load_continuation("ssul-set6", table, "command line").along
    monkeypatch.setattr(Job, "compute", lambda request, *_: request)
    of_python = nv.continue_branch("ssul-set6", name, (low, high)).along
    assert of_file == of_options == of_python
    assert of_file.name == gives
    assert (of_file.low, of_file.high) == (low * unit, high * unit)


def test_the_interval_follows_parameters_that_are_set_and_the_second_may_be_a_ratio():
    table = {"set": {"k1": 4e4}, "along": {"omega_ratio": {"start": 0.9, "stop": 1.1}}}
    request = load_continuation({"system": "ssul-set6", **table})
    assert request.along.low == 0.9 * sqrt(4e4 / SIX["m1"])
    assert load_continuation(request.document()) == request
    # the second parameter may be a ratio
    plane = {"zeta1": {"start": 0.01, "stop": 0.1}}
    planes = {"along": {"omega": {"start": 6.0, "stop": 7.0}}, "plane": plane}
    request = load_continuation("ssul-set6", planes)
    assert request.plane.name == "c1"
    assert request.plane.high == 0.1 * 2 * sqrt(SIX["k1"] * SIX["m1"])


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
    plane = {"along": {"P": {"start": 700, "stop": 900}}, "plane": {"f": {"start": 1, "stop": 2}}}
    request = load_continuation("ssul-set6", plane | {"set": {"omega": 7.0}})
    assert request.plane.heading().startswith("f from 1 to 2 Hz")
    assert load_continuation(request.document()) == request


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"along": {"f": {"start": 0.0, "stop": 1.0}}}, r"\[along\].*f.*0"),
        ({"along": {"f": {"start": "x", "stop": 1.0}}}, "start of f = 'x' must be a number"),
        ({"along": {"zeta": {"start": 0.1, "stop": 1.0}}}, "zeta"),
        (
            {"along": {"omega_ratio": {"start": 0.9, "stop": 1.0}},
             "plane": {"k1": {"start": 3e4, "stop": 5e4}}},
            "omega_ratio follows from k1, which is free, too: give omega",
        ),
        (
            {"along": {"f": {"start": 0.9, "stop": 1.0}},
             "plane": {"omega": {"start": 6.0, "stop": 7.0}}},
            "omega is free already",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_refused(tables, words):
    with pytest.raises(nv.RequestError, match=words):
        load_continuation("ssul-set6", tables, "a test")
