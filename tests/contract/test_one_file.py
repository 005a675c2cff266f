"""One request file in every command: what it lends, what is left aside, and that this is told."""

import warnings
from importlib import import_module
from pathlib import Path

import pytest

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.errors import LeftAside
from nlds_vines.model.setting import LENT, MARKS, SAMPLING, SHARED

SCANS = Path(__file__).parents[2] / "scans"
FORMS = {
    wing: import_module(f"nlds_vines.{wing}").FORM
    for wing in (
        "bifurcation.request",
        "bifurcation.response_curves.request",
        "tuning.request",
        "continuation.request",
        "portrait.request",
        "loads.request",
    )
}
SCAN = """
title = "My damper"
system = "ssul-set6"
set = { P = 850 }
vary = { omega = { start = 7.0, stop = 7.5, num = 3 } }
start = { policy = "random", count = 4, seed = 1 }
sampling = { transient = 333, periods = 77, nodes = 6 }
record = { want = ["energy"] }
"""


@pytest.fixture
def scan(here):
    Path("scan.toml").write_text(SCAN)
    return "scan.toml"


def test_all_that_some_file_may_hold_is_known():
    keys = {key for form in FORMS.values() for key in form.keys}
    assert keys == {*MARKS, *SHARED, *LENT}
    samplings = [form.tables.get("sampling", {}) for form in FORMS.values()]
    assert {name for entries in samplings for name in entries} == SAMPLING


@pytest.mark.parametrize("command", ["portrait", "tuning", "continuation"])
def test_a_file_with_vary_lends_its_system_and_its_title(command, scan, ask):
    said = ask(command, scan, "--dry-run")
    assert said.out.startswith("My damper\n")
    assert said.err.count("\n") == 1
    assert "scan.toml: left aside here: [vary], [start], [record]" in said.err


def test_and_its_sampling(scan):
    with pytest.warns(LeftAside, match="nodes of"):
        portrait = import_module("nlds_vines.portrait.request").load_portrait(scan)
    assert portrait.columns[0].window == (333, 410)
    assert portrait.columns[0].system.parameters["P"] == 850
    with pytest.warns(LeftAside):
        tuning = nv.load_tuning(scan)
    assert (tuning.transient, tuning.periods) == (333, 77)


def test_quiet_says_nothing(scan, ask):
    assert ask("portrait", scan, "--dry-run", "--quiet").err == ""


@pytest.mark.parametrize("path", sorted(SCANS.glob("*.toml")), ids=lambda path: path.stem)
@pytest.mark.parametrize("command", ["portrait", "tuning", "continuation"])
def test_all_files_serve_all_commands(command, path, capsys, here):
    status = main([command, str(path), "--dry-run"])
    said = capsys.readouterr().err
    assert "unknown key" not in said
    # a page of curves has a system in each curve, and some systems have no damper to tune
    assert status == 0 or "system" in said or "damper" in said


def test_tables_of_its_own_are_taken(scan):
    lines = [line for line in SCAN.splitlines() if not line.startswith("start")]
    Path(scan).write_text("\n".join([*lines, 'portrait = { panels = ["energy"] }']))
    with pytest.warns(LeftAside, match="vary"):
        found = import_module("nlds_vines.portrait.request").load_portrait(scan)
    assert found.panels == ("energy",)


def test_a_misspelt_table_is_refused(scan, refusal):
    Path(scan).write_text(SCAN.replace("record", "recrod"))
    assert "unknown key 'recrod'" in refusal("portrait", scan, "--dry-run")


def test_a_title_stays_whatever_is_overridden(scan):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LeftAside)
        assert nv.load_scan(scan, {"set": {"P": 900.0}}).title == "My damper"
        assert nv.load_tuning(scan, {"set": {"P": 900.0}}).title == "My damper"
        assert nv.load_continuation(scan, {"set": {"P": 900.0}}).title == "My damper"


def test_that_of_the_default_does_not():
    assert "Figure 8" not in nv.load_scan(None, {"set": {"P": 900.0}}).title
