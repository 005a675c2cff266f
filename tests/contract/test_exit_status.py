"""What the command does with what a run reports: exit statuses, words and files."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import nlds_vines as nv
from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.runs.executors import Shard

USUAL = {
    "threads": None,
    "resume": False,
    "overwrite": False,
    "shard": None,
    "scheduler": None,
    "executor": None,
    "quiet": True,
}


@pytest.fixture
def calls(here, monkeypatch):
    """Stand in for the computing and the pictures; returns what they were asked for."""
    asked = SimpleNamespace(runs=[], plots=[], failed=0, error=None)

    def run(scan, output, how):
        asked.runs.append((scan, output, vars(how)))
        if asked.error is not None:
            raise asked.error
        return SimpleNamespace(
            lanes=scan.lanes,
            tally=SimpleNamespace(labels={"T,0": 1, "chaos": 1}),
            why_failed=lambda: f"{asked.failed} of 1201 orbits failed" if asked.failed else "",
            summary=lambda: "the summary",
            remarks=lambda: ["a remark"],
        )

    stand_in(monkeypatch, "run", run=run)
    picture = SimpleNamespace(save=lambda *what: asked.plots.append(what))
    stand_in(monkeypatch, "picture.drawing", PICTURE=picture)
    return asked


def stand_in(monkeypatch, name, **content):
    fake = ModuleType(f"nlds_vines.bifurcation.{name}")
    vars(fake).update(content)
    monkeypatch.setitem(sys.modules, fake.__name__, fake)


def test_the_default_is_figure_8_with_its_picture(calls, ask):
    printed = ask("bifurcation")
    options = {**USUAL, "quiet": False}
    assert calls.runs == [(load_scan(), Path("figure8.h5"), options)]
    assert calls.plots == [(Path("figure8.h5"), Path("figure8.png"), None, None)]
    assert printed == ("the summary\na remark\nfigure8.h5\nfigure8.png\n", "")


def test_a_scan_file_gives_its_name_and_no_picture(calls, tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "mine.toml").write_text(load_scan().to_toml())
    assert main(["deep/mine.toml", "--quiet"]) == 0
    scan, output, options = calls.runs[0]
    assert (scan, output) == (load_scan(), Path("mine.h5"))
    assert options["quiet"]
    assert calls.plots == []


def test_the_picture_of_the_default_lies_beside_its_archive(calls, tmp_path):
    (tmp_path / "deep").mkdir()
    assert main(["-o", "deep/a.h5"]) == 0
    assert calls.plots == [(Path("deep/a.h5"), Path("deep/a.png"), None, None)]


def test_a_map_that_cannot_be_drawn_is_not_drawn_unasked(calls):
    assert main(["--vary", "P=1:2:5", "--vary", "C=1:2:5", "--record", "section"]) == 0
    assert calls.plots == []


def test_every_option_arrives(calls):
    arguments = (
        "--system ssul-set5 --set P=600 --set K=2.5e7 --vary omega=5:6:3 --vary C=-0.1:0.1:5 "
        "--start random:4 --transient 7 --periods 8 --record energy,section --method rk4 "
        "--threads 2 --overwrite --plot map.svg --show E1max -o map.h5"
    )
    assert main(arguments.split()) == 0
    scan, output, options = calls.runs[0]
    assert scan.system.kind == "ssul"
    assert (scan.system.parameters["P"], scan.system.K) == (600, 2.5e7)
    assert scan.system.parameters["k2"] == 784.9
    assert [(axis.name, axis.values.tolist()) for axis in scan.axes] == [
        ("omega", [5, 5.5, 6]),
        ("C", pytest.approx([-0.1, -0.05, 0, 0.05, 0.1])),
    ]
    assert (scan.start.policy, scan.start.count) == ("random", 4)
    assert (scan.transient, scan.periods, scan.method) == (7, 8, "rk4")
    assert scan.want == ("section", "energy")
    assert output == Path("map.h5")
    assert options == {**USUAL, "threads": 2, "overwrite": True, "quiet": False}
    assert calls.plots == [(Path("map.h5"), Path("map.svg"), "E1max", None)]


def test_failed_orbits_give_status_1_even_when_quiet(calls, ask):
    calls.failed = 3
    out, err = ask("bifurcation", "--quiet", status=1)
    assert out == ""
    assert "3 of 1201 orbits failed" in err
    assert calls.plots  # what succeeded is drawn


def test_a_shard_says_who_writes_the_archive_and_draws_nothing(calls, answer):
    assert "the last shard to end writes the archive" in answer("bifurcation", "--shard", "2/7")
    assert calls.runs[0][2] == {**USUAL, "shard": Shard(2, 7), "quiet": False}
    assert calls.plots == []


def test_a_dry_run_only_tells(calls, answer, refusal, tmp_path):
    text = answer("bifurcation", "--dry-run", "--threads", "2")
    assert "orbits:   1201 (1201 cells, 1 start each)" in text
    assert "results: " in text
    (tmp_path / "figure8.h5").write_bytes(b"old")
    assert "exists" in refusal("bifurcation", "--dry-run", "--threads", "2")
    assert calls.runs == calls.plots == []


@pytest.mark.parametrize("option", ["--resume", "--overwrite"])
def test_an_existing_archive_may_be_given_up(calls, option, tmp_path):
    (tmp_path / "figure8.h5").write_bytes(b"old")
    assert main([option]) == 0
    assert calls.runs[0][2][option[2:]]


def test_the_function_returns_the_archive(calls):
    scan = load_scan(None, {"sampling": {"periods": 3}})
    assert nv.scan(scan, to="a.h5", threads=1) == Path("a.h5")
    assert calls.runs[0][:2] == (scan, Path("a.h5"))
    assert not calls.runs[0][2]["quiet"]  # a long run shows where it is, from Python too
    nv.scan(scan, to="b.h5", quiet=True)
    assert calls.runs[1][2]["quiet"]
    assert calls.plots == []


@pytest.mark.parametrize("program", [main, lambda arguments: console(["bifurcation", *arguments])])
def test_help_shows_an_example_that_works(program, calls, capsys):
    assert program(["--help"]) == 0
    text = capsys.readouterr().out.replace("\\\n", " ")
    examples = [line.split()[2:] for line in text.splitlines() if "nlds-vines bifurcation" in line]
    examples = [words for words in examples if "[-h]" not in words]
    assert len(examples) == 5
    for words in examples:
        assert main(words) == 0
    assert len(calls.runs) == 5


def test_console_help_names_the_commands(answer):
    assert "bifurcation" in answer() == answer("--help")
    assert answer("--version").startswith("nlds-vines ")
