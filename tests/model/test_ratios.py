"""Ratios in place of parameters: what they mean, where they are taken, what is refused."""

from math import pi, sqrt

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.tuning.request_file import load_tuning

SIX = nv.load_system("ssul-set6").parameters


def six(**given):
    return nv.load_system("ssul-set6", **given).parameters


def test_each_ratio_stands_for_its_parameter():
    assert six(zeta1=0.02)["c1"] == 0.02 * (2 * sqrt(SIX["k1"] * SIX["m1"]))
    assert six(zeta2=0.1)["c2"] == 0.1 * (2 * sqrt(SIX["k2"] * SIX["m2"]))
    assert six(mass_ratio=0.05)["m2"] == 50.0
    assert six(f=1.0)["omega"] == 2 * pi
    assert six(omega_ratio=1.1)["omega"] == 1.1 * sqrt(SIX["k1"] / SIX["m1"])
    oscillator = nv.load_system("impact-oscillator", zeta=0.05, omega_ratio=2.0).parameters
    assert oscillator["c"] == 0.05 * (2 * sqrt(oscillator["k"] * oscillator["m"]))
    assert oscillator["omega"] == 2.0 * sqrt(oscillator["k"] / oscillator["m"])


def test_a_unit_follows_from_what_is_given_beside_it():
    found = six(m1=1500.0, k1=6e4, zeta1=0.015, mass_ratio=0.02, zeta2=0.1)
    assert found["m2"] == 30.0
    assert found["c1"] == pytest.approx(0.015 * 2 * sqrt(6e4 * 1500.0), rel=1e-15)
    assert found["c2"] == pytest.approx(0.1 * 2 * sqrt(found["k2"] * 30.0), rel=1e-15)


def test_a_system_tells_its_ratios_and_they_give_it_back():
    system = nv.load_system("ssul-set6", c2=90.0)
    ratios = system.ratios
    assert set(ratios) == {"mass_ratio", "zeta1", "zeta2", "f", "omega_ratio"}
    ratios.pop("omega_ratio")
    again = nv.load_system("ssul-set6", **ratios).parameters
    for name, value in system.parameters.items():
        assert again[name] == pytest.approx(value, rel=1e-15)
    assert set(nv.load_system("bouncing-ball").ratios) == {"f"}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"zeta1": 0.1, "c1": 3.0}, "c1 beside zeta1"),
        ({"f": 1.0, "omega_ratio": 1.0}, "f beside omega_ratio"),
        ({"zeta": 0.1}, "unknown parameter 'zeta'"),
        ({"zeta1": -1.0}, "zeta1 = -1.0 is not allowed"),
        ({"zeta1": "a"}, "zeta1 = 'a' must be a number"),
        ({"f": 0.0}, "f = 0.0 is not allowed"),
        ({"mass_ratio": float("nan")}, "mass_ratio"),
        ({"omega_ratio": 1.0, "k1": 0.0}, "means nothing with k1 = 0.0"),
        ({"zetta1": 0.1}, "did you mean 'zeta1'"),
    ],
)
def test_what_is_no_ratio_is_refused(given, said):
    with pytest.raises(RequestError, match=said):
        six(**given)


def test_a_ratio_stands_in_a_system_of_a_file(tmp_path):
    (tmp_path / "own.toml").write_text(
        '[system]\nkind = "tmd"\nm1 = 1500.0\nk1 = 6e4\nzeta1 = 0.015\nmass_ratio = 0.02\n'
        "k2 = 1200.0\nzeta2 = 0.1\nP = 800.0\nf = 1.0\n"
    )
    found = nv.load_system(tmp_path / "own.toml").parameters
    assert found["m2"] == 30.0
    assert found["omega"] == 2 * pi
    (tmp_path / "own.toml").write_text('[system]\nkind = "none"\nm1 = 1.0\nzeta1 = 0.1\n')
    with pytest.raises(RequestError, match="zeta1 needs k1, which is missing"):
        nv.load_system(tmp_path / "own.toml")


def scan_over(vary, **more):
    return load_scan("ssul-set6", {"vary": vary, **more})


def test_an_axis_along_a_ratio_is_one_along_its_parameter():
    hertz = scan_over({"f": {"start": 0.8, "stop": 1.2, "num": 3}})
    rad = scan_over({"omega": {"values": list(2 * pi * np.array([0.8, 1.0, 1.2]))}})
    assert hertz.axes[0].name == "omega"
    assert hertz.axes[0].values == pytest.approx(rad.axes[0].values, rel=1e-15)
    assert hertz.hash == scan_over({"omega": {"values": hertz.axes[0].values.tolist()}}).hash
    assert (
        "ω = 6.28319 rad/s: c₁"
        in scan_over({"zeta1": {"values": [0.01, 0.02]}}, set={"f": 1.0}).title
    )
    assert load_scan(hertz.document()).hash == hertz.hash


@pytest.mark.parametrize(
    ("vary", "settings", "said"),
    [
        ({"omega_ratio": {"values": [1.0]}, "k1": {"values": [3e4]}}, {}, "follows from k1"),
        ({"zeta1": {"values": [0.1]}}, {"c1": 3.0}, "c1 is varied"),
        ({"c1": {"values": [0.1]}}, {"zeta1": 3.0}, "c1 is varied"),
        ({"f": {"values": [0.0]}}, {}, "f = 0.0 is not allowed"),
        ({"f": {"values": [1.0]}, "omega": {"values": [6.0]}}, {}, "omega"),
    ],
)
def test_an_axis_that_means_nothing_is_refused(vary, settings, said):
    with pytest.raises(RequestError, match=said):
        scan_over(vary, set=settings)


def test_what_the_command_line_varies_need_not_be_removed_from_a_file():
    file = {"system": "ssul-set6", "set": {"f": 1.0}, "vary": {"k2": {"values": [500.0]}}}
    assert load_scan(file, {"vary": {"omega": {"values": [6.0]}}}).axes[0].name == "omega"


def test_a_tuning_is_over_a_band_in_hertz():
    tuning = load_tuning("tmd", {"over": {"f": {"start": 0.9, "stop": 1.1, "num": 3}}})
    assert tuning.over[0].name == "omega"
    assert tuning.over[0].values == pytest.approx(2 * pi * np.array([0.9, 1.0, 1.1]))
