"""A run may die at any moment: after --resume its archive is that of an undisturbed one.

With `-m long`, 105 runs of all tasks are killed, and one is cut at every file operation and (by
strace) at every system call: some twenty minutes on two processors.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from commands import ended, started
from made_up import arrays, content, make_scan, write

import nlds_vines as nv
from nlds_vines.__main__ import main as console
from nlds_vines.runs.store import BlockStore

DOCUMENT = {
    "title": "a scan to be killed",
    "system": "ssul-set6",
    "vary": {"omega": {"start": 6.0, "stop": 7.6, "num": 500}},
    "sampling": {"transient": 2000, "periods": 24},
    "record": {"want": ["section", "impacts", "energy", "regime"]},
}
"""A second or two in six blocks, of the scene and record that other tests have compiled."""


def begun(folder, *words):
    """Begin a run, or go on with it; return its process."""
    return started("-m", "nlds_vines", *words, "--resume", "--quiet", cwd=folder)


CHAOS = "--set omega=7.385"  # where no state returns: settled orbits are copied, not run
TASKS = {
    "bifurcation": "--vary omega=7.384:7.386:120 --transient 6000 --periods 60",
    "transients": f"{CHAOS} --starts 200 --transient 1000 --plot a.png",
    "response-curves": "--system tmd --vary omega=5:8:900 --transient 3000",
    "response-history": "--system ssul-set6 --vary impulse=100:1000:3000 --duration 200",
    "tuning": "--system tmd --population 8 --generations 30 --polish 12",
    "continuation": "--along omega=7.2:7.5 --doublings 2",
    "portrait": f"{CHAOS} --windows 100000:100020 --plot a.png",
}
"""Options of each task with which it computes for a second or two."""

FEW_BLOCKS = ("portrait", "transients", "response-curves")
"""Tasks that are one or two blocks here, so that few moments find one saved."""


@pytest.mark.kernels
@pytest.mark.parametrize("task", [task for task in TASKS if task != "portrait"])
def test_a_task_that_ends_after_a_block_goes_on_from_it(task, here, monkeypatch):
    """Each asks the store for its blocks, which outlive any end (below); a portrait has none."""
    words = (task, *TASKS[task].split(), "-o", "a.h5", "--resume", "--quiet")
    assert console([*words]) in (0, 1)
    whole = content("a.h5")
    Path("a.h5").unlink()
    save, load, kept, used = BlockStore.save, BlockStore.load, [], []

    def save_and_end(store, key, *arguments):
        save(store, key, *arguments)
        kept.append(key)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(BlockStore, "save", save_and_end)
        assert console([*words]) == 130
    assert not Path("a.h5").exists()

    def load_and_note(store, key, *arguments):
        arrays = load(store, key, *arguments)
        if arrays is not None:
            used.append(key)
        return arrays

    monkeypatch.setattr(BlockStore, "load", load_and_note)
    assert console([*words]) in (0, 1)
    assert {*kept} <= {*used}
    assert content("a.h5") == whole
    assert not list(here.glob("*.blocks"))


KILLS = 15


@pytest.mark.long
@pytest.mark.parametrize("task", TASKS)
def test_a_task_killed_at_random_moments_ends_in_the_same_archive(task, tmp_path):
    words, rng = (task, *TASKS[task].split(), "-o", "a.h5"), random.Random(KILLS)
    folder, unfinished = tmp_path, 0

    def finish(running):
        status, _, err = ended(running)
        assert status in (0, 1), err
        assert not list(folder.glob("*.blocks"))
        resumed = content(folder / "a.h5")
        (folder / "a.h5").unlink()
        return resumed

    for _ in range(2):  # the first one may compile
        began = time.monotonic()
        whole = finish(begun(folder, *words))
        length = time.monotonic() - began
    for _ in range(KILLS):
        running = begun(folder, *words)
        try:
            running.wait(rng.uniform(0.2, 1.0) * length)
        except subprocess.TimeoutExpired:
            running.send_signal(signal.SIGKILL)
            running.communicate()
            unfinished += bool(list(folder.glob("*.blocks/*.npz")))
        else:
            assert finish(running) == whole
    assert finish(begun(folder, *words)) == whole
    assert unfinished > 0 or task in FEW_BLOCKS


FILES = {
    "open", "write", "flush", "fsync", "close", "truncate", "posix_fallocate", "replace", "unlink",
    "mkdir", "rmdir", "remove", "rename", "link",
}  # fmt: skip
"""C functions through which Python changes files."""

HDF5 = {"__setitem__", "create_dataset", "create", "make_scale", "attach_scale", "close"}
"""Functions of h5py that do so."""

SCAN = make_scan(("energy", "regime"))


def die_at(call):
    """Let this process die right before its `call`-th call that changes a file."""
    count = [0]

    def watch(frame, event, what):
        if event == "c_call":
            changes = what.__name__ in FILES and not isinstance(what.__self__, str)
        else:
            code = frame.f_code
            changes = event == "call" and code.co_name in HDF5 and "h5py" in code.co_filename
        count[0] += changes
        if count[0] == call:
            os._exit(9)

    sys.setprofile(watch)


def run_to(path):
    """Do as a run does, with results that cost nothing; return what is compared."""
    return content(write(path, SCAN, resume=True))


# the children do nothing with threads, and end without cleaning up
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")
@pytest.mark.parametrize(
    ("stride", "least"),
    [
        pytest.param(11, 10, marks=pytest.mark.slow("a run for every operation on a file")),
        pytest.param(1, 150, marks=pytest.mark.long),
    ],
)
def test_a_run_cut_between_any_two_file_operations_can_be_resumed(stride, least, tmp_path):
    """Before each `stride`-th call, which are at least so many."""
    reference = run_to(tmp_path / "reference.h5")
    path, call, died = tmp_path / "cut" / "scan.h5", 1, True
    while died:
        path.parent.mkdir()
        process = os.fork()
        if process == 0:
            try:
                die_at(call)
                run_to(path)
            finally:
                sys.setprofile(None)
                os._exit(0)
        died = os.waitpid(process, 0)[1]
        assert run_to(path) == reference, call
        assert arrays(path)
        assert os.listdir(path.parent) == [path.name], call
        shutil.rmtree(path.parent)
        call += stride
    assert call // stride > least + 1


TRACED = """
import sys
from pathlib import Path
from nlds_vines.runs import interrupts
from test_resumed_after_kill import run_to
interrupts.stoppable = lambda work: work  # strace follows one thread
run_to(Path(sys.argv[1]))
"""


@pytest.mark.long
@pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed")
def test_a_run_killed_at_every_system_call_that_changes_a_file_can_be_resumed(tmp_path):
    """Unlike the cuts above, these lie inside HDF5 as well."""
    reference, log = run_to(tmp_path / "reference.h5"), tmp_path / "calls.log"
    path, cuts = tmp_path / "cut" / "scan.h5", 0
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "OMP_NUM_THREADS": "1"}
    for name in ("write", "pwrite64", "fsync", "ftruncate", "fallocate", "rename", "unlink"):
        for count in range(1, 10_000):
            path.parent.mkdir()
            killed = ["-e", f"trace={name}", "-e", f"inject={name}:signal=KILL:when={count}"]
            done = subprocess.run(
                ["strace", "-qq", "-o", log, *killed, sys.executable, "-c", TRACED, path],
                env=os.environ | environment, stderr=subprocess.DEVNULL, check=False,
            )  # fmt: skip
            assert run_to(path) == reference, (name, count)
            shutil.rmtree(path.parent)
            if done.returncode == 0:
                break
            cuts += 1
            assert log.read_text()
    assert cuts > 100


# ---- asked to stop -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole():
    return content(nv.scan(DOCUMENT))


@pytest.mark.slow("a run is ended, and goes on")
@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGUSR1, 143)]
)
def test_a_signal_ends_a_run_between_blocks_and_says_how_to_go_on(number, status, whole, here):
    (here / "scan.toml").write_text(nv.load_scan(DOCUMENT).to_toml())
    running = begun(here, "bifurcation", "scan.toml")
    while not list(here.glob("scan.h5.*.blocks/*.npz")):
        assert running.poll() is None, running.stderr.read()
        time.sleep(0.005)
    running.send_signal(number)
    ended_with, _, err = ended(running)
    assert ended_with == status, err
    assert "--resume" in err
    assert "Traceback" not in err
    assert not list(here.glob("scan.h5.*.blocks/*.tmp"))
    # as an undisturbed run, when which is over signals mean what they did before
    numbers = signal.SIGINT, signal.SIGTERM, signal.SIGUSR1
    before = [*map(signal.getsignal, numbers)]
    assert console(["bifurcation", "scan.toml", "--resume", "--quiet"]) == 0
    assert [*map(signal.getsignal, numbers)] == before
    assert sorted(os.listdir(here)) == ["scan.h5", "scan.toml"]
    assert content("scan.h5") == whole
    assert arrays("scan.h5")


TWICE = """
import os, signal
from nlds_vines.runs import interrupts
try:
    with interrupts.stop_on_signals() as stop:
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop.asked and stop.status == 143
        os.kill(os.getpid(), signal.SIGINT)
except KeyboardInterrupt:
    print("at once", stop.status)
"""


def test_the_second_signal_does_not_wait_for_the_block():
    status, output, errors = ended(started("-c", TWICE))
    assert (status, output) == (0, "at once 130\n")
    assert errors.count("\n") == 1
    assert "press Ctrl-C again to stop at once" in errors


def test_the_content_compared_tells_archives_apart(tmp_path):
    one, other = (write(tmp_path / f"{P}.h5", make_scan(P=P)) for P in (800.0, 801.0))
    assert content(one) != content(other)
    np.testing.assert_equal(arrays(one), arrays(other))  # made-up results know nothing of P
    assert np.isfinite(arrays(one)["status"]).all()
