"""Help, dry runs and refused requests load nothing heavy, so that they answer at once."""

import json

import pytest
from commands import printed, python

HEAVY = {"numba", "llvmlite", "h5py", "matplotlib", "scipy", "tqdm", "bokeh", "tornado"}

LINES = {  # status of each, in one process: whatever one loads, all that follow have
    "--help": 0, "--version": 0,
    "bifurcation --help": 0, "bifurcation --system nothing": 2, "bifurcation nothing.toml": 2,
    "bifurcation --set P=nan": 2, "bifurcation -o no/x.h5": 2, "bifurcation -o old.h5": 2,
    "bifurcation --plot x.gif": 2, "bifurcation --shard 8/7": 2,
    "bifurcation --periods 1000000000": 2,
    "bifurcation --vary omega=5:8:9 --show shares -o new.h5": 2,
    "portrait --help": 0, "portrait --panels forces": 2, "portrait good.toml --dry-run": 0,
    "tuning --help": 0, "tuning --dry-run": 0, "tuning --free k2=2:1": 2, "tuning -o old.h5": 2,
    "transients --help": 0, "transients --starts 0": 2, "transients --delay -1": 2,
    "transients -o old.h5": 2,
    "accuracy --help": 0, "accuracy --want 2": 2, "accuracy --plot no/x.png": 2,
    "explore --help": 0, "explore --dry-run": 0, "explore --port -1": 2,
    "explore --system nothing": 2, "explore no.toml": 2,
    "report --help": 0, "report no.h5": 2, "report": 2,
    "plot --help": 0, "plot no.h5": 2, "plot no.h5 -o x.gif": 2,
    "rerun --help": 0, "rerun no.h5": 2,
    "paper --help": 0, "paper --only 13": 2, "paper --dry-run": 0,
}  # fmt: skip

PROGRAM = """
import contextlib, io, json, shlex, sys
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from paper.command import main as paper

heavy, found = set(json.loads(sys.argv[1])), {}
load_scan().cells()
for line in json.loads(sys.argv[2]):
    first, *rest = words = shlex.split(line)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        status = paper(rest) if first == "paper" else main(words)
    found[line] = [status, sorted(heavy & sys.modules.keys())]
import h5py
print(json.dumps([found, sorted(heavy & sys.modules.keys())]))
"""


def test_nothing_heavy_is_loaded(tmp_path):
    (tmp_path / "old.h5").write_bytes(b"")
    (tmp_path / "good.toml").write_text('system = "tmd"\n[sampling]\nperiods = 4\n')
    argument = json.dumps(sorted(HEAVY)), json.dumps(list(LINES))
    statuses, after = json.loads(printed("-c", PROGRAM, *argument, cwd=tmp_path))
    assert statuses == {line: [status, []] for line, status in LINES.items()}
    assert after == ["h5py"]  # so that the probe sees what is loaded


def loaded(*words, **where):
    times = python("-X", "importtime", *words, **where).stderr.splitlines()
    names = [line.split("|")[-1] for line in times if line.startswith("import time:")]
    return {name.strip().split(".")[0] for name in names}


@pytest.mark.parametrize("program", [["nlds_vines.bifurcation"], ["nlds_vines", "bifurcation"]])
def test_nor_by_a_program_itself(program, tmp_path):
    modules = loaded("-m", *program, "--set", "P=nan", cwd=tmp_path)
    assert "nlds_vines" in modules
    assert not modules & HEAVY


def test_the_page_of_explore_is_made_before_kernels_are_loaded(tmp_path):
    pytest.importorskip("bokeh", reason="Bokeh is not installed")
    names = "page_state", "page_server", "live_page"
    parts = ", ".join(f"nlds_vines.explore.{name}" for name in names)
    modules = loaded("-c", f"import {parts}", cwd=tmp_path)
    assert "bokeh" in modules
    assert not modules & {"numba", "scipy", "matplotlib"}


@pytest.mark.parametrize(("window", "needed"), [("rectangular", False), ("hann", True)])
def test_a_spectrum_loads_scipy_for_a_taper_alone(window, needed, tmp_path):
    make = f"spectrum_of([1.0, 2.0, 1.0, 0.0] * 4, 4, 1.0, window={window!r})"
    program = f"from nlds_vines.orbits.spectrum import spectrum_of; {make}"
    assert ("scipy" in loaded("-c", program, cwd=tmp_path)) == needed
