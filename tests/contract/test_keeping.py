"""Archives in use: progress, room on disk and in memory, where they are from, reruns."""

import io
import json
import re
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice, product
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from commands import printed
from made_up import make_scan
from tqdm import tqdm

import nlds_vines as nv
from nlds_vines.archives import provenance
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.run import wanted_of
from nlds_vines.engine.batch import Outputs
from nlds_vines.engine.compilation import Compilation
from nlds_vines.engine.records import DIVERGED, OK
from nlds_vines.runs.progress import Progress
from nlds_vines.scans.run import _save
from nlds_vines.scans.run_report import Report

REAL = {
    "title": "a real one",
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.3, "stop": 7.6, "num": 13}},
    "sampling": {"transient": 16, "periods": 24},
    "record": {"want": ["section", "impacts", "energy", "regime"]},
}


def test_a_line_of_progress_tells_regimes_and_failures(capsys, monkeypatch):
    monkeypatch.setattr("nlds_vines.runs.progress.LINE_EVERY", 0.0)
    labels = np.array(["T,1", "3T,2", "failed"], dtype=object)
    arrays = {"status": np.array([OK, OK, DIVERGED]), "label": labels}
    blocks = [(SimpleNamespace(index=i), arrays, 0.0) for i in range(2)]
    with Progress(9, "orbit", quiet=False) as progress:
        _save(
            SimpleNamespace(save=lambda *_: None, is_in_memory=False),
            iter(blocks),
            Report(),
            progress,
        )
    err = capsys.readouterr().err
    assert err.startswith("6 of 9 orbits, ")
    assert err.endswith("to go; 2 T,1, 2 3T,2, 2 failed; 2 failed\n")
    # waiting for the compiler does not count for the pace
    clock = iter([0.0, 10.0, 101.0])
    monkeypatch.setattr("nlds_vines.runs.progress.time.perf_counter", lambda: next(clock))
    progress = Progress(30, "orbit")  # at 0 s
    progress.note(10, "")  # at 10 s
    progress.wait("compiling", 0.0)
    progress.wait("", 90.0)
    progress.note(10, "")  # at 101 s: one second of work
    assert "10 a second, 1 s to go" in capsys.readouterr().err


def test_a_bar_forgets_the_wait_and_has_room_beside_its_words(monkeypatch):
    now = [0.0]
    shown = tqdm(total=30, file=io.StringIO(), ncols=100, mininterval=0.0)
    shown._time = lambda: now[0]
    shown.start_t = shown.last_print_t = 0.0
    monkeypatch.setattr("nlds_vines.runs.progress.bar", lambda **_: shown)
    with Progress(30, "orbit") as progress:
        now[0] = 1.0
        progress.wait("compiling", 0.0)
        now[0] = 91.0
        progress.wait("", 90.0)
        now[0] = 92.0
        progress.note(10, "10 T,1; 0 failed")
        assert shown.format_dict["elapsed"] == 2.0
        assert shown.format_dict["rate"] == pytest.approx(5.0)
        assert shown.postfix == "10 T,1; 0 failed"
        progress.note(1, ", ".join(f"{n} {n}T,{n}" for n in range(100, 120)))
    assert shown.postfix.endswith(", ...")
    assert len(shown.postfix) <= 100 - 66


COMMANDS = {
    "bifurcation": "--vary omega=7.3:7.6:9 --transient 50 --periods 20",
    "response-curves": "--system none --system tmd --vary omega=5:7:3",
    "continuation": "--along omega=5.4:5.5",
    "tuning": "--free C --population 8 --generations 3 --polish 0 --transient 20 --periods 20",
    "response-history": "--system none --system tmd --impulse 9 --duration 3",
    "accuracy": "--system ssul-set6 --no-peers --periods 2",
}


@pytest.mark.kernels
@pytest.mark.parametrize("command", COMMANDS)
def test_no_task_counts_compiling_as_pace(command, here, ask, monkeypatch):
    """All kernels take 1e6 s more to compile; no work is noted while they are compiled."""
    late, depth, note = [0.0], [0], Progress.note
    clock, followed = time.perf_counter, Compilation.followed
    monkeypatch.setattr(cutting, "_block_sides", lambda scan: [5])

    @contextmanager
    def slow(self, parts=None):
        tell, self._tell = self._tell, None
        late[0], depth[0] = late[0] + 1e6, depth[0] + 1
        began = clock()
        with followed(self, parts):
            yield
        depth[0], self._tell = depth[0] - 1, tell
        if tell is not None:
            tell("compiling", 0.0)
            tell("", 1e6 + clock() - began)

    def checked(self, count, words):
        assert depth[0] == 0
        note(self, count, words)

    monkeypatch.setattr(Compilation, "followed", slow)
    monkeypatch.setattr("nlds_vines.engine.batch._loaded", set())  # earlier tests filled it
    monkeypatch.setattr(Progress, "note", checked)
    monkeypatch.setattr("nlds_vines.runs.progress.LINE_EVERY", 0.0)
    monkeypatch.setattr(
        "nlds_vines.runs.progress.time", SimpleNamespace(perf_counter=lambda: clock() + late[0])
    )
    _, err = ask(command, *COMMANDS[command].split())
    assert late[0] > 0.0
    paces = [float(pace) for pace in re.findall(r"(\S+) a second", err)]
    assert all(pace > 1e-2 for pace in paces), err
    unknown = ("continuation", "tuning")  # whose number of orbits is not known in advance
    assert paces or command in unknown


# ---- whether there is room -----------------------------------------------------------------------


def test_what_does_not_fit_is_refused_with_its_size(monkeypatch, tmp_path, error_of):
    needed = make_scan(), tmp_path / "a.h5"
    cutting.refuse_without_room(*needed)
    for free, words in (
        ("free_disk", "on the disk .* 1 kB are free"),
        ("free_memory", "3.. MB of memory .* 1 kB are free"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(cutting, free, lambda *_: 1000)
            assert re.search(words, error_of(cutting.refuse_without_room, *needed))


def test_an_archive_without_a_name_needs_memory_for_all_results(monkeypatch, tmp_path, error_of):
    scan = make_scan()
    nameless = ArchivePath.for_result(None, "scan")
    monkeypatch.setattr(cutting, "free_disk", lambda *_: 1000)
    cutting.refuse_without_room(scan, nameless)
    needed = cutting.memory_needed(scan, nameless)
    monkeypatch.setattr(cutting, "free_memory", lambda: needed - 1)
    assert "name an archive (to=)" in error_of(cutting.refuse_without_room, scan, nameless)
    monkeypatch.undo()
    monkeypatch.setattr(cutting, "free_memory", lambda: needed - scan.table.bytes())
    cutting.refuse_without_room(scan, tmp_path / "a.h5")


def test_a_limit_on_memory_is_seen():
    program = """
import resource
from nlds_vines.runs.executors import free_memory
resource.setrlimit(resource.RLIMIT_AS, (5 * 10**9, resource.RLIM_INFINITY))
print(free_memory() <= 5 * 10**9)
"""
    assert printed("-c", program) == "True\n"


def test_block_bytes_bounds_the_largest_block():
    for vary in (None, {"P": {"values": [1.0, 2.0, 3.0]}, "omega": {"values": list(range(1, 9))}}):
        for policy in ("rest", "up"):
            scan = make_scan(vary=vary, start={"policy": policy})
            cells = max(block.cells for block in cutting.blocks_of(scan))
            largest = scan.table.bytes(text=16) * cells // (scan.lanes // scan.starts)
            assert cutting.block_bytes(scan) >= largest


WANTED = (["section"], ["energy"], ["regime", "energy"], ["settling"])
TOUCHES = (["speeds"], ["impact_section"])
WALLS = ["ssul-set6", "ssbl"]


@pytest.mark.parametrize(
    ("system", "want"), [*product(["none", "tmd", *WALLS], WANTED), *product(WALLS, TOUCHES)]
)
def test_lane_bytes_bounds_the_allocated_outputs(system, want):
    length = "periods" if want in TOUCHES else "transient"
    scan = replace(make_scan(want, system=system), **{length: 5000})
    outputs = Outputs.of(wanted_of(scan), (7, 1), scan.transient, scan.periods)
    arrays = *outputs.buffers, outputs.evidence, outputs.status
    allocated = sum(array.nbytes for array in arrays if array is not None)
    assert outputs.buffers.touches is not None or want not in TOUCHES
    assert allocated <= 7 * cutting.lane_bytes(scan) <= allocated + 7 * 1024


def test_a_verdict_makes_smaller_blocks():
    omega, force = ({"start": low, "stop": 9.0, "num": 3000} for low in (5.0, 1.0))
    cells = []
    for want in ("energy", "regime"):
        scan = replace(make_scan([want], vary={"omega": omega, "P": force}), transient=5000)
        cells.append(max(block.cells for block in islice(cutting.blocks_of(scan), 100)))
        assert cells[-1] * cutting.lane_bytes(scan) <= cutting.work_bytes(scan) <= 1 << 27
    assert cells[1] < cells[0]


def test_the_commit_is_that_of_the_clone(monkeypatch, tmp_path):
    def git(*arguments):
        settings = ["-c", "user.name=n", "-c", "user.email=e", "-C", tmp_path]
        return subprocess.check_output(["git", *settings, *arguments], text=True).strip()

    package = tmp_path / "nlds_vines"
    package.mkdir()
    (package / "a.py").write_text("1")
    monkeypatch.setattr(provenance, "_PACKAGE", package)
    asked = provenance.commit.__wrapped__
    assert asked() == ""  # not known: an archive says nothing
    (package / "_data").mkdir()
    (package / "_data" / "commit.txt").write_text("of the wheel")
    assert asked() == "of the wheel"
    for arguments in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "a"]):
        git(*arguments)
    assert asked() == git("rev-parse", "HEAD")
    (package / "a.py").write_text("2")
    assert asked() == git("rev-parse", "HEAD") + "+"


@pytest.fixture
def hook(monkeypatch):
    """Return the names of `hatch_build`; hatchling need not be installed."""
    name = "hatchling"
    for part in ("", ".builders", ".hooks", ".plugin", ".interface"):
        name += part
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(BuildHookInterface=object))
    return SimpleNamespace(**run_path(str(Path(nv.__path__[0]).parent / "hatch_build.py")))


@pytest.mark.parametrize(
    ("target", "name"), [("wheel", "nlds_vines/_data/commit.txt"), ("sdist", "commit.txt")]
)
def test_a_wheel_or_sdist_records_its_commit(hook, tmp_path, target, name):
    made = hook.CustomBuildHook()
    made.root, made.target_name = str(tmp_path), target

    def included(version):
        asked = {"force_include": {}}
        made.initialize(version, asked)
        return asked["force_include"]

    assert included("standard") == {}  # neither a clone nor a source archive with a note
    (tmp_path / "commit.txt").write_text("0123abc\n")
    ((source, place),) = included("standard").items()
    assert (Path(source).read_text(), place) == ("0123abc", name)
    made.finalize("standard", {}, "")
    assert not Path(source).exists()
    assert included("editable") == {}


# ---- repeated and compared -----------------------------------------------------------------------


def test_a_scan_is_repeated_from_its_archive_and_is_the_same(here, answer, refusal, monkeypatch):
    monkeypatch.setattr(cutting, "_block_sides", lambda scan: [5])
    nv.scan(REAL, to="a.h5")
    assert "results are the same" in answer("rerun", "a.h5")
    assert "a-rerun.h5' exists" in refusal("rerun", "a.h5")
    assert answer("rerun", "a.h5", "-o", "b.h5", "--threads", "1", "--quiet") == ""
    with h5py.File("a.h5", "r+") as file:
        assert file.attrs["seconds"] > 0
        file["E1max"][3, 0] += 0.25
        file["label"][2, 0] = "T,0"
        del file["impact_rate"]
    text = answer("rerun", "a.h5", "-o", "c.h5", "--quiet", status=1)
    assert text == "results differ: E1max, impact_rate, label\n"
    with h5py.File("a.h5", "r+") as file:  # a scan that means something else by now
        file.attrs["scan"] = file.attrs["scan"].replace("800.0", "801.0")
    assert "its scan is damaged" in refusal("rerun", "a.h5", "-o", "d.h5")


PROGRAM = """
import json, resource, sys
from pathlib import Path
import numpy as np
import nlds_vines as nv
from nlds_vines.bifurcation import blocks

LANES, LONG = 4, 150_000
blocks.BLOCK_PERIODS = 10**9  # all lanes in one block

def scan(transient):
    "Run a scan and return the greatest memory [MB] that this process has had so far."
    nv.scan("ssul-set6", vary={"omega": {"start": 6.0, "stop": 7.0, "num": LANES}},
            sampling={"transient": transient, "periods": 10},
            record=["section", "impacts", "energy", "regime"], to=f"{transient}.h5")
    return peak()

def peak():
    status = Path("/proc/self/status")  # of this process alone; `getrusage` inherits its parent's
    if status.exists():
        return int(status.read_text().split("VmHWM:")[1].split()[0]) / 2**10
    usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return usage / (2**20 if sys.platform == "darwin" else 2**10)

first = scan(100)
again, long = scan(101), scan(LONG)
stored = np.ones((LANES, LONG, 4))
print(json.dumps({"again": again - first, "long": long - again, "stored": peak() - long}))
"""


@pytest.mark.slow("a process, and a long transient")
def test_a_thousand_times_the_transient_takes_no_more_memory(tmp_path):
    nv.scan(REAL)  # compiles, if need be, which takes more memory than anything here
    megabytes = json.loads(printed("-c", PROGRAM, cwd=tmp_path, NUMBA_DISABLE_JIT="0"))
    assert megabytes["stored"] > 15.0  # storing those states would be noticed
    assert megabytes["again"] < 4.0
    assert megabytes["long"] < 4.0
