"""Archives in use: how a scan stands, room for it, where it is from, repeated and compared."""

import json
import os
import subprocess
import sys
import time
import tracemalloc
from dataclasses import replace
from itertools import islice
from pathlib import Path
from types import ModuleType

import h5py
import numpy as np
import pytest
from commands import printed
from made_up import make_scan, results, write

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives import provenance
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation import blocks as memory_and_disk
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import (
    block_bytes,
    blocks_of,
    lane_bytes,
    result_bytes,
    work_bytes,
)
from nlds_vines.bifurcation.compute import Computer, wanted_of
from nlds_vines.bifurcation.orbit_counts import Tally
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.orbits.batch import Outputs
from nlds_vines.orbits.status_words import DIVERGED, OK
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.shard import Shard
from nlds_vines.upkeep.status import Standing, standing

REAL = {
    "title": "a real one",
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.3, "stop": 7.6, "num": 13}},
    "sampling": {"transient": 16, "periods": 24},
    "record": {"want": ["section", "impacts", "energy", "regime"]},
}


@pytest.fixture
def folder(here, monkeypatch):
    monkeypatch.setattr(cutting, "_block_cells", lambda _: 5)
    return here


# ---- how a scan stands ---------------------------------------------------------------------------


def everything(folder):
    return {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in folder.rglob("*.*")}


def test_the_standing_of_a_scan_is_told_and_nothing_is_touched(folder, answer):
    scan = make_scan()
    blocks = list(blocks_of(scan))
    with Parts.open("a.h5", scan) as parts:
        for block in blocks[:2]:
            parts.write(block, results(scan, block), seconds=0.1)
            time.sleep(0.02)
        before = everything(parts.folder)
        running = answer("status", "a.h5")
        assert everything(parts.folder) == before
    assert "blocks:   2 of 3" in running
    assert "orbits:   8 of 13" in running
    assert "at work:  a run" in running
    assert " to go" in running
    assert "T,1" in running
    assert "no run that can be seen from here" in answer("status", "a.h5.parts")
    with Parts.open("a.h5", scan, shard=Shard(2, 3)):
        assert standing(Path("a.h5.parts")).workers == ["shard 2/3"]


def test_the_standing_of_a_finished_scan_and_of_none(folder, answer):
    write("a.h5", make_scan())
    assert "13, complete" in answer("status", "a.h5")
    assert main(["status", "b.h5"]) == 2
    os.mkdir("b.h5.parts")
    assert main(["status", "b.h5"]) == 2


def test_the_pace_does_not_count_pauses():
    stored = [
        (0.0, 10, 1.0),
        (1.0, 10, 1.0),
        (1000.0, 10, 1.0),
        (1001.0, 10, 1.0),
        (1002.0, 10, 1.0),
    ]
    standing = Standing(make_scan(), "", 9, stored=stored)
    assert standing.rate() == 10.0
    assert Standing(make_scan(), "", 9, stored=stored[:1]).rate() is None


def test_a_line_of_progress_tells_regimes_and_failures(capsys, monkeypatch):
    monkeypatch.setattr("nlds_vines.runs.progress.LINE_EVERY", 0.0)
    found = {
        "status": np.array([OK, OK, DIVERGED]),
        "label": np.array(["T,1", "3T,2", "failed"], dtype=object),
    }
    tally = Tally()
    with Progress(9, "orbit", quiet=False) as progress:
        tally.follow(progress, found)
        tally.follow(progress, found)
    said = capsys.readouterr().err
    assert said.startswith("6 of 9 orbits, ")
    assert said.endswith("to go; 2 T,1, 2 3T,2, 2 failed; 2 failed\n")


# ---- whether there is room -----------------------------------------------------------------------


def test_what_does_not_fit_is_refused_with_its_size(monkeypatch, tmp_path):
    scan = make_scan()
    memory_and_disk.refuse_without_room(scan, tmp_path / "a.h5")
    with monkeypatch.context() as patch:
        patch.setattr(memory_and_disk, "free_disk", lambda _: 1000)
        with pytest.raises(RequestError, match=r"on the disk .* GB are free"):
            memory_and_disk.refuse_without_room(scan, tmp_path / "a.h5")
    monkeypatch.setattr(memory_and_disk, "free_memory", lambda: 1000)
    with pytest.raises(RequestError, match=r"0.3 GB of memory .* 1e-06 GB are free"):
        memory_and_disk.refuse_without_room(scan, tmp_path / "a.h5")


def test_a_limit_on_memory_is_seen(tmp_path):
    program = "import resource as r; r.setrlimit(r.RLIMIT_AS, (5 * 10**9, r.RLIM_INFINITY));"
    program += "from nlds_vines.runs.threads import free_memory; print(free_memory() <= 5 * 10**9)"
    assert printed("-c", program) == "True\n"


def test_the_largest_block_is_as_large_as_it_is_said():
    for vary in (None, {"P": {"values": [1.0, 2.0, 3.0]}, "omega": {"values": list(range(1, 9))}}):
        for policy in ("rest", "up"):
            scan = make_scan(vary=vary, start={"policy": policy})
            cells = max(block.cells for block in blocks_of(scan))
            assert block_bytes(scan) >= result_bytes(scan) * cells // (scan.lanes // scan.starts)


@pytest.mark.parametrize("system", ["none", "tmd", "ssul-set6", "ssbl"])
@pytest.mark.parametrize("want", [["section"], ["energy"], ["regime", "energy"], ["settling"]])
def test_what_a_block_takes_is_not_more_than_is_said(system, want):
    scan = replace(make_scan(want, system=system), transient=5000)
    outputs = Outputs.of(wanted_of(scan), (7, 1), scan.transient, scan.periods)
    taken = sum(array.nbytes for array in vars(outputs).values() if array is not None)
    assert taken <= 7 * lane_bytes(scan) <= taken + 7 * 1024


@pytest.mark.parametrize("want", ["speeds", "impact_section"])
@pytest.mark.parametrize("system", ["ssul-set6", "ssbl"])
def test_room_for_touches_is_room_that_counts(system, want):
    scan = replace(make_scan([want], system=system), periods=5000)
    outputs = Outputs.of(wanted_of(scan), (7, 1), scan.transient, scan.periods)
    taken = sum(array.nbytes for array in vars(outputs).values() if array is not None)
    assert outputs.touches is not None
    assert taken <= 7 * lane_bytes(scan) <= taken + 7 * 1024


@pytest.mark.kernels
@pytest.mark.parametrize("want", [["error"], ["section", "energy", "regime", "error"]])
@pytest.mark.parametrize("periods", [20, 500])
def test_what_an_error_takes_is_not_more_than_is_said(want, periods):
    vary = {"omega": {"start": 6.0, "stop": 7.0, "num": 60}}
    scan = replace(make_scan(want, vary=vary), transient=300, periods=periods, effort="quick")
    computer, chains = Computer(scan), scan.cells()[:, np.newaxis]
    computer.lanes(chains[:1], np.zeros((1, 4)))  # compiles
    tracemalloc.start()
    try:
        computer.lanes(chains, np.zeros((60, 4)))
        taken = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert 0.5 * 60 * lane_bytes(scan) < taken < 60 * lane_bytes(scan)
    without = replace(scan, want=tuple(word for word in want if word != "error") or ("section",))
    assert lane_bytes(scan) > 2 * lane_bytes(without)


def test_a_verdict_makes_smaller_blocks():
    omega, force = ({"start": low, "stop": 9.0, "num": 3000} for low in (5.0, 1.0))
    cells = []
    for want in ("energy", "regime"):
        scan = replace(make_scan([want], vary={"omega": omega, "P": force}), transient=5000)
        cells.append(max(block.cells for block in islice(blocks_of(scan), 100)))
        assert cells[-1] * lane_bytes(scan) <= work_bytes(scan) <= 1 << 27
    assert cells[1] < cells[0]


# ---- where it comes from -------------------------------------------------------------------------


def test_an_archive_tells_where_it_comes_from(folder):
    with h5py.File(nv.scan(REAL, to="a.h5")) as file:
        attrs = dict(file.attrs)
    assert load_scan(REAL).to_toml() == attrs["scan"]
    assert load_scan(REAL).hash == attrs["scan_hash"]
    assert isinstance(json.loads(attrs["argv"]), list)
    assert attrs["seed"] == 0
    assert attrs["seconds"] > 0
    assert attrs["threads"] >= 1
    for library in ("numba", "llvmlite", "numpy", "h5py", "hdf5", "python"):
        assert attrs[f"{library}_version"][0].isdigit(), library
    assert attrs.get("commit", "") == provenance.commit()


def test_the_commit_is_that_of_the_clone(monkeypatch, tmp_path):
    def git(*arguments):
        settings = ["-c", "user.name=n", "-c", "user.email=e", "-C", str(tmp_path)]
        done = subprocess.run(["git", *settings, *arguments], capture_output=True, text=True)
        return done.stdout.strip()

    package = tmp_path / "nlds_vines"
    package.mkdir()
    (package / "a.py").write_text("1")
    monkeypatch.setattr(provenance, "_PACKAGE", package)
    asked = provenance.commit.__wrapped__
    assert asked() == ""  # not known: an archive says nothing
    (package / "_data").mkdir()
    (package / "_data" / "commit.txt").write_text("of the wheel")
    assert asked() == "of the wheel"
    for arguments in (["init"], ["add", "."], ["commit", "-m", "a"]):
        git(*arguments)
    assert asked() == git("rev-parse", "HEAD")
    (package / "a.py").write_text("2")
    assert asked() == git("rev-parse", "HEAD") + "+"


@pytest.fixture
def hook(monkeypatch):
    """Return the hook of the build, whose library need not be installed."""
    interface = ModuleType("hatchling.builders.hooks.plugin.interface")
    interface.BuildHookInterface = object
    for name in ("", ".builders", ".builders.hooks", ".builders.hooks.plugin"):
        monkeypatch.setitem(sys.modules, f"hatchling{name}", ModuleType("made up"))
    monkeypatch.setitem(sys.modules, interface.__name__, interface)
    path = Path(nv.__path__[0]).parent / "hatch_build.py"
    found = ModuleType("hatch_build")
    exec(compile(path.read_text(), str(path), "exec"), vars(found))
    return found


@pytest.mark.parametrize("target", ["wheel", "sdist"])
def test_what_is_built_knows_its_commit_and_what_is_built_of_that(hook, tmp_path, target):
    made = hook.CustomBuildHook()
    made.root, made.target_name = str(tmp_path), target
    asked = {"force_include": {}}
    made.initialize("standard", asked)
    assert asked == {"force_include": {}}  # neither a clone nor a source archive with a note
    (tmp_path / "commit.txt").write_text("0123abc\n")
    made.initialize("standard", asked)
    ((source, place),) = asked["force_include"].items()
    assert Path(source).read_text() == "0123abc"
    assert place == {"wheel": "nlds_vines/_data/commit.txt", "sdist": "commit.txt"}[target]
    made.finalize("standard", asked, "")
    assert not Path(source).exists()
    asked = {"force_include": {}}
    made.initialize("editable", asked)
    assert asked == {"force_include": {}}


# ---- repeated and compared -----------------------------------------------------------------------


def test_a_scan_is_repeated_from_its_archive_and_is_the_same(folder, answer, refusal):
    nv.scan(REAL, to="a.h5")
    assert "parameters and results are the same" in answer("rerun", "a.h5")
    assert "a-rerun.h5' exists" in refusal("rerun", "a.h5")
    assert answer("rerun", "a.h5", "-o", "b.h5", "--threads", "1", "--quiet") == ""
    assert "are the same" in answer("diff", "a.h5", "b.h5")
    with h5py.File("a.h5", "r+") as file:
        file["E1max"][3, 0] += 0.25
    assert "result: E1max: 1 of 13 values differ by up to 0.25" in answer(
        "rerun", "a.h5", "-o", "c.h5", "--quiet", status=1
    )


@pytest.mark.kernels
def test_errors_are_repeated_and_compared_too(folder, answer, ask):
    want = [*REAL["record"]["want"], "error"]
    nv.scan({**REAL, "record": {"want": want}}, to="a.h5")
    ask("rerun", "a.h5", "--quiet")
    with h5py.File("a.h5", "r+") as file:
        file["refined_label"][2, 0] = "7T,7"
        file["error"][5, 0] *= 2
    said = answer("diff", "a.h5", "a-rerun.h5", status=1)
    assert "result: error: 1 of 13 values differ by up to" in said
    assert "result: refined_label: 1 of 13 values differ" in said


def test_what_differs_is_told(folder, answer):
    write("a.h5", make_scan())
    write("b.h5", make_scan(P=801.0))
    with h5py.File("b.h5", "r+") as file:
        file["section"][4, 0, 2, 1] = 1e9
        file["label"][7, 0] = "5T,5"
        file["status"][2:4] = 9
    said = answer("diff", "a.h5", "b.h5", status=1).splitlines()
    assert said[0] == "parameter: system.parameters.P: 800.0 -> 801.0"
    assert len(said) == 4
    (section,) = [line for line in said if "section: 1 of" in line]
    assert "first at omega = 6.0, start = rest, cycle = 3, component = v1" in section
    assert any("label: 1 of 13 values differ, first at omega = 6.75" in line for line in said)
    assert any("status: 2 of 13" in line for line in said)


def test_other_grids_and_other_records_are_told(folder, answer):
    write("a.h5", make_scan(("energy",)))
    write("b.h5", make_scan(("regime",), vary={"omega": {"start": 5.0, "stop": 6.0, "num": 3}}))
    said = answer("diff", "a.h5", "b.h5", status=1)
    assert "record.want: ['energy'] -> ['regime']" in said
    assert "result: E1max is only in a.h5" in said
    assert "status has 13 omega x 1 start in one and 3 omega x 1 start in the other" in said
    assert "vary.omega.values: 13 values from 5.0 to 8.0" in said


def test_a_scan_that_means_something_else_by_now_is_refused(folder, refusal):
    write("a.h5", make_scan())
    with h5py.File("a.h5", "r+") as file:
        file.attrs["scan"] = file.attrs["scan"].replace("800.0", "801.0")
    assert "its scan is damaged" in refusal("rerun", "a.h5")
