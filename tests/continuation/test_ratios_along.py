"""Continuations along ratios: f [Hz] and omega / omega0 in place of omega."""

from math import pi, sqrt

import pytest

import nlds_vines as nv
from nlds_vines.continuation.command import Job
from nlds_vines.continuation.request import load_continuation

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


def test_it_is_that_of_the_parameters_that_are_set():
    table = {"set": {"k1": 4e4}, "along": {"omega_ratio": {"start": 0.9, "stop": 1.1}}}
    request = load_continuation({"system": "ssul-set6", **table})
    assert request.along.low == 0.9 * sqrt(4e4 / SIX["m1"])
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
    plane = {"along": {"P": {"start": 700, "stop": 900}}, "plane": {"f": {"start": 1, "stop": 2}}}
    request = load_continuation("ssul-set6", plane | {"set": {"omega": 7.0}})
    assert request.plane.heading().startswith("f from 1 to 2 Hz")
    assert load_continuation(request.document()) == request


def test_the_second_parameter_may_be_one():
    planes = {
        "along": {"omega": {"start": 6.0, "stop": 7.0}},
        "plane": {"zeta1": {"start": 0.01, "stop": 0.1}},
    }
    request = load_continuation("ssul-set6", planes)
    assert request.plane.name == "c1"
    assert request.plane.high == 0.1 * 2 * sqrt(SIX["k1"] * SIX["m1"])


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
