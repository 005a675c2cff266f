"""The command `accuracy`, as a user meets it: files, words, refusals, a run that goes on."""

import re
import tomllib
from pathlib import Path

import matplotlib.image
import pytest

from nlds_vines.accuracy import measure
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.simulation import simulate
from nlds_vines.orbits.solver_settings import Settings

pytestmark = pytest.mark.kernels

VARY = {"omega": {"values": [6.28]}}
SHORT = ["--no-peers", "--periods", "3", "--quiet"]


@pytest.fixture
def folder(here, monkeypatch):
    """Work in an empty folder, with three settings of each method."""
    monkeypatch.setattr(measure, "EXACT", (1e-4, 1e-9, 1e-12))
    monkeypatch.setattr(measure, "RK4", (256, 512, 1024))
    return here


@pytest.fixture
def measured(folder, answer):
    """The output of a short run that draws a picture."""
    return answer("accuracy", *SHORT, "--want", "1e-6")


def test_one_command_leaves_picture_and_table(measured, folder, refusal):
    rows = [line.split(" | ") for line in measured.splitlines() if "| exact |" in line]
    errors = [float(row[2].strip(" <|")) for row in rows]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)
    assert measured.count("\n| rk4 |") == 3
    assert [path.name for path in folder.iterdir()] == ["accuracy.png"]
    picture = matplotlib.image.imread("accuracy.png")
    assert picture.std() > 0.01  # something is drawn
    assert "picture 'accuracy.png' exists" in refusal("accuracy", *SHORT)


def test_the_advice_is_a_setting_that_was_measured_good_enough(measured):
    (line,) = re.findall(
        r"^The cheapest setting with an error of at most 1e-06: .*$", measured, re.M
    )
    error = float(re.search(r"\((\S+) at ", line).group(1))
    assert error <= 1e-6
    assert 'method = "exact"' in line


def test_what_is_advised_is_what_a_scan_and_python_take(measured):
    """Notices: advice in words of which a scan knows nothing."""
    advised = re.findall(r"`(method = .*?)`", measured)
    assert len(advised) == 1
    for text in advised:
        settings = tomllib.loads(text.replace(", ", "\n"))
        scan = load_scan({"system": "ssul-set6", "vary": VARY, "sampling": settings})
        assert scan.settings == Settings(tolerance=settings["tolerance"])
        assert simulate(load_system("ssul-set6"), 1, **settings).section.shape == (1, 4)


def test_of_a_scan_the_middle_is_taken(folder, answer):
    Path("own.toml").write_text(
        'title = "own"\nsystem = "tmd"\n[vary]\nomega = { start = 5.0, stop = 7.0, num = 3 }\n'
        '[record]\nwant = ["section"]\n'
    )
    assert "6 rad/s" in answer("accuracy", "own.toml", *SHORT)


def test_a_structure_alone_is_measured_too(folder, answer):
    assert "rk4" in answer("accuracy", "--system", "none", *SHORT)
