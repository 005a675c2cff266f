"""What a command does with what a run reports, with its surroundings and with odd texts."""

import json
import os
import shlex
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import pytest
from commands import ended, printed, started
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.archives.files import toml_text
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.cli.terminal import exit_status_of
from nlds_vines.engine.records import DIVERGED
from nlds_vines.errors import MOST_CHARACTERS
from nlds_vines.model.look import USUAL_LOOK
from nlds_vines.model.system import System
from nlds_vines.runs.executors import Shard, most_threads
from nlds_vines.scans.run_report import Report
from paper.request import load_figure

USUAL = {
    **dict.fromkeys(("threads", "shard", "scheduler", "executor")),
    **{"resume": False, "overwrite": False, "quiet": False},
}


@pytest.fixture
def calls(here, monkeypatch):
    """Stand in for the computing and the pictures; returns what they were asked for."""
    asked = SimpleNamespace(runs=[], plots=[], failed=0)

    def run(scan, output, how):
        asked.runs.append((scan, output, vars(how)))
        failures = Counter({DIVERGED: asked.failed} if asked.failed else {})
        labels = Counter({"T,0": 1, "chaos": 1})
        report = Report(lanes=scan.lanes, failures=failures, labels=labels)
        report.summary, report.remarks = lambda: "the summary", lambda: ["a remark"]
        return report

    picture = SimpleNamespace(save=lambda *what: asked.plots.append(what))
    monkeypatch.setattr("nlds_vines.bifurcation.run.run", run)
    monkeypatch.setattr("nlds_vines.bifurcation.picture.drawing.PICTURE", picture)
    return asked


def test_the_default_is_figure_8_with_its_picture(calls, ask):
    printed = ask("bifurcation")
    assert calls.runs == [(load_scan(), Path("figure8.h5"), USUAL)]
    assert calls.plots == [(Path("figure8.h5"), Path("figure8.png"), None, None, USUAL_LOOK)]
    assert printed == ("the summary\na remark\nfigure8.h5\nfigure8.png\n", "")


def test_a_picture_lies_beside_the_archive_of_the_default_alone(calls):
    Path("deep").mkdir()
    Path("deep/mine.toml").write_text(load_scan().to_toml())
    assert main(["deep/mine.toml", "--quiet"]) == 0  # a scan file gives its name
    assert calls.runs == [(load_scan(), Path("mine.h5"), {**USUAL, "quiet": True})]
    # a map that cannot be drawn is not drawn unasked
    assert main(["--vary", "P=1:2:5", "--vary", "C=1:2:5", "--record", "section"]) == 0
    assert calls.plots == []
    assert main(["-o", "deep/a.h5"]) == 0
    assert calls.plots == [(Path("deep/a.h5"), Path("deep/a.png"), None, None, USUAL_LOOK)]


def test_every_option_arrives(calls):
    arguments = (
        "--system ssul-set5 --set P=600 --set K=2.5e7 --vary omega=5:6:3 --vary C=-0.1:0.1:5 "
        "--start random:4 --transient 7 --periods 8 --record energy,section --method rk4 "
        "--threads 2 --overwrite --plot map.svg --show E1max -o map.h5"
    )
    assert main(arguments.split()) == 0
    scan, output, options = calls.runs[0]
    p = scan.system.parameters
    assert (scan.system.kind, p["P"], p["k2"], scan.system.K) == ("ssul", 600, 784.9, 2.5e7)
    values = {"omega": [5, 5.5, 6], "C": pytest.approx([-0.1, -0.05, 0, 0.05, 0.1])}
    assert {axis.name: axis.values.tolist() for axis in scan.axes} == values
    assert (scan.start.policy, scan.start.count) == ("random", 4)
    assert (scan.transient, scan.periods, scan.method) == (7, 8, "rk4")
    assert scan.want == ("section", "energy")
    assert output == Path("map.h5")
    assert options == {**USUAL, "threads": 2, "overwrite": True}
    assert calls.plots == [(Path("map.h5"), Path("map.svg"), "E1max", None, USUAL_LOOK)]


def test_a_shard_says_who_writes_and_draws_nothing_and_failures_are_status_1(calls, ask):
    out, _ = ask("bifurcation", "--shard", "2/7")
    assert "the last shard to end writes the archive" in out
    assert calls.runs[0][2] == {**USUAL, "shard": Shard(2, 7)}
    assert calls.plots == []
    calls.failed = 3
    out, err = ask("bifurcation", "--quiet", status=1)  # failed orbits, even when quiet
    assert out == ""
    assert "3 of 1201 orbits failed" in err
    assert calls.plots  # what succeeded is drawn


def test_a_dry_run_only_tells(calls, answer, refusal, tmp_path):
    text = answer("bifurcation", "--dry-run", "--threads", "2")
    assert "orbits:   1201 (1201 cells, 1 start each)" in text
    assert "results: " in text
    (tmp_path / "figure8.h5").write_bytes(b"old")
    assert "exists" in refusal("bifurcation", "--dry-run", "--threads", "2")
    assert calls.runs == calls.plots == []
    assert "cannot be opened" in refusal("bifurcation", "--resume")
    for option in ("overwrite", "resume"):
        assert main([f"--{option}"]) == 0
        assert calls.runs.pop()[2][option]
        (tmp_path / "figure8.h5").unlink(missing_ok=True)


def test_the_function_returns_the_archive(calls):
    scan = load_scan(None, {"sampling": {"periods": 3}})
    assert nv.scan(scan, to="a.h5", threads=1) == Path("a.h5")
    assert calls.runs[0][:2] == (scan, Path("a.h5"))
    assert not calls.runs[0][2]["quiet"]  # a long run shows where it is, from Python too
    nv.scan(scan, to="b.h5", quiet=True)
    assert calls.runs[1][2]["quiet"]
    assert calls.plots == []


def test_help_names_the_commands_and_shows_examples_that_work(calls, answer):
    assert "bifurcation" in answer() == answer("--help")
    assert answer("--version").startswith("nlds-vines ")
    text = answer("bifurcation", "--help").replace("\\\n", " ")
    examples = [line.split()[2:] for line in text.splitlines() if "nlds-vines bifurcation" in line]
    examples = [words for words in examples if "[-h]" not in words]
    assert len(examples) == 5
    for words in examples:
        assert main(words) == 0
    assert len(calls.runs) == 5


TOLD = {
    "accuracy": ["ssul-set6: exact\nssul-set6: rk4\nssul-set6: SciPy DOP853\n"],
    "continuation --all -o b.h5": ["100 random starts"],
    "response-history --impulse 100": ["Tuned mass damper"],
    "portrait --system tmd --transient 0 --periods 4 --start rest": [
        "4 periods from rest; 4096 states", "picture: portrait.png",
    ],
    "portrait --start -0.03,0.1,.2,0": ["from (-0.03, 0.1, 0.2, 0.0)"],
    "portrait --start -.03,0.1,0,0": ["from (-0.03, 0.1, 0.0, 0.0)"],
    "tuning --band 5:8:61 --plot a.png": [
        "61 values of omega", "k2 from 10 to 10000 N/m, logarithmic",
        "omega = 5 to 8 rad/s (0.7958 to 1.273 Hz), 61 values",
    ],
    "tuning --free V": ["V from 0 to 0.5 m (does not enter the dynamics"],
    "bifurcation --vary f=5:8:3": ["f = 5 to 8 Hz (31.42 to 50.27 rad/s), 3 values"],
    "bifurcation --vary f1=1:2:3": ["f1 = 1 to 2 Hz (6.283 to 12.57 rad/s), 3 values"],
    "response-curves": ["omega = 4.5 to 8 rad/s (0.7162 to 1.273 Hz), 351 values"],
    "continuation --along f=0.8:1.2 --plane P=500:900": [
        "f from 0.8 to 1.2 Hz (5.027 to 7.54 rad/s)", "P from 500 to 900 N"
    ],
}  # fmt: skip
"""What a command line says, by its words."""


@pytest.mark.parametrize("line", TOLD)
def test_a_dry_run_says_what_would_be_done_and_writes_nothing(line, here, answer):
    text = answer(*shlex.split(line), "--dry-run")
    assert all(words in text for words in TOLD[line]), text
    assert list(here.iterdir()) == []


# ---- the environment -----------------------------------------------------------------------------


def test_threads_that_numba_refuses_are_one_line(here, monkeypatch, refusal):
    for number in ("0", "abc", "", "٣", "100000"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", number)
        assert "from 1 to 4096" in refusal("bifurcation")
    assert list(here.iterdir()) == []
    assert most_threads({}) >= 1  # usual ones are taken
    assert most_threads({"NUMBA_NUM_THREADS": " 8 "}) == 8


@pytest.mark.kernels
def test_the_threads_of_numba_do_not_matter(tmp_path):
    """The threads are our own: what Numba lacks for its own, or would refuse, is not asked for."""
    arguments = ["bifurcation", "--vary", "omega=6:7:2", "--periods", "1", "--record", "section"]
    layer = {"NUMBA_THREADING_LAYER": "quatsch", "NUMBA_DISABLE_JIT": "1"}
    printed("-m", "nlds_vines", *arguments, "-o", "a.h5", cwd=tmp_path, **layer)
    assert (tmp_path / "a.h5").exists()


def test_texts_that_people_write_are_taken_and_odd_names_of_programs(tmp_path, monkeypatch):
    for title in ("Größe β = 2 π, 減衰", "a 👩‍🔬 b", "$5 \\frac", "x" * MOST_CHARACTERS):
        assert System("tmd", nv.load_system("tmd").parameters, title=title).title == title
    note = "first line\n\tsecond line"
    system = System("tmd", nv.load_system("tmd").parameters, assumptions={"m1": note})
    assert system.assumptions["m1"] == note
    monkeypatch.setattr(sys, "argv", ["/home/a\udcff/run.py", "a\0b"])  # of the bytes a\xff
    path = write(tmp_path / "a.h5", make_scan())
    with nv.read(path) as view:
        assert json.loads(view.attrs["argv"]) == sys.argv


@pytest.mark.parametrize("name", ["../../escaped", "/tmp/escaped", "a/b", "ω" * 900, ".hidden"])
def test_a_name_in_a_figure_is_no_path(tmp_path, name):
    system = {"kind": "none", "m1": 1, "k1": 1, "c1": 1, "P": 1, "omega": 1, "name": name}
    page = {"system": system, "vary": {"omega": {"values": [6.0, 7.0]}}, "curves": [{}]}
    (tmp_path / "page.toml").write_text(toml_text(page))
    archive = load_figure(tmp_path / "page.toml").archive
    assert Path(archive).name == archive
    assert not archive.startswith(".")
    assert len(archive.encode()) < 255


def shell(line, folder):
    """Run a line of the shell; return its status, what it prints, and its errors."""
    done = subprocess.run(
        ["bash", "-c", line.replace("nlds-vines", f"{sys.executable} -m nlds_vines")],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": ""},
        capture_output=True, text=True, cwd=folder, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("streams")
    write(place / "a.h5", make_scan(("energy", "regime")))
    return place


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_changes_nothing(folder, closed):
    sound = (folder / "a.h5").read_bytes()
    for words in ("plot a.h5 --show '?'", "bifurcation --dry-run"):
        assert shell(f"nlds-vines {words} {closed}", folder)[::2] == (0, "")
    assert (folder / "a.h5").read_bytes() == sound
    assert shell(f"nlds-vines plot no.h5 {closed}", folder)[0] == 2


def test_no_file_gets_the_number_of_a_closed_stream(folder):
    program = (
        "from nlds_vines.cli.terminal import exit_status_of; exit_status_of('', lambda: 0);"
        "print(open('a.h5').fileno())"
    )
    line = f'{sys.executable} -W ignore -c "{program}"'
    assert int(shell(f"{line} <&- 2>&-", folder)[1]) > 2


@pytest.mark.parametrize("words", ["plot a.h5 --show '?'", "plot --help", "--help", "--version"])
def test_a_full_disk_for_output_is_one_line(folder, words):
    status, _, errors = shell(f"nlds-vines {words} > /dev/full", folder)
    assert status == 2
    assert errors.endswith("error: No space left on device\n")
    assert errors.count("\n") == 1


@pytest.mark.parametrize("kilobytes", [3_000_000, 1_500_000])
def test_little_memory_is_enough(folder, kilobytes):
    for words in ("bifurcation --dry-run", "plot no.h5 --help"):
        assert shell(f"ulimit -v {kilobytes}; nlds-vines {words}", folder)[::2] == (0, "")


def test_a_library_without_room_is_one_line(capsys):
    def work(text):
        raise ImportError(text)

    words = "cannot open x.so: failed to map segment from shared object"
    assert exit_status_of("", lambda: work(words)) == 2
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(ImportError, match="other"):
        exit_status_of("", lambda: work("another reason: other"))


SLOW_IMPORT = """
import builtins, sys, time
from nlds_vines import __main__ as program

plain = builtins.__import__

def slow(name, *rest):
    if name == "numpy" and builtins.__import__ is slow:
        builtins.__import__ = plain
        print("here", flush=True)
        time.sleep(60.0)
    return plain(name, *rest)

builtins.__import__ = slow
sys.exit(program.main(["bifurcation", "--dry-run"]))
"""


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_while_modules_are_loaded_is_one_line(folder, number, status):
    running = started("-c", SLOW_IMPORT, cwd=folder)
    assert running.stdout.readline() == "here\n"
    running.send_signal(number)
    assert ended(running) == (status, "", "nlds-vines: interrupted\n")
