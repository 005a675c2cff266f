"""The same scan gives the same bits: any threads, blocks, shards, executors and clusters.

Also stopped and resumed, beside failures, with workers killed.  All scans here record the same of
the same scene, so that one compilation serves them all.
"""

import json
import multiprocessing
import os
import pickle
import re
import signal
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from importlib.util import find_spec
from pathlib import Path
from threading import Timer as Later

import numpy as np
import pytest
from commands import ended, printed, started
from made_up import arrays, content

import nlds_vines as nv
from nlds_vines.__main__ import main as console
from nlds_vines.archives.provenance import makers
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.run import Computer, run
from nlds_vines.engine import batch
from nlds_vines.engine.records import DIVERGED, OK, STATUS, STEP_BUDGET, TOO_STIFF
from nlds_vines.runs import executors
from nlds_vines.runs.executors import Shard, threads_in_use
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.scans import run as scan_run
from nlds_vines.scans.block import Block

ONE_AXIS = {"omega": {"start": 7.3, "stop": 7.6, "num": 13}}
TWO_AXES = {"C": {"values": [0.05, 0.06233, 0.07]}, "omega": {"start": 7.3, "stop": 7.6, "num": 5}}
STARTS = {
    "rest": {"policy": "rest"},
    "up": {"policy": "up"},
    "down": {"policy": "down"},
    "both": {"policy": "both"},
    "random:3": {"policy": "random", "count": 3, "seed": 7},
}
SAMPLING = {"transient": 16, "periods": 24}
EVERY = {f"{len(vary)} {start}": (vary, start) for vary in (ONE_AXIS, TWO_AXES) for start in STARTS}


def document(vary=ONE_AXIS, start="rest", **changes):
    return {
        "system": "ssul-set6",
        "vary": vary,
        "start": STARTS[start],
        "sampling": SAMPLING,
        "record": {"want": ["section", "impacts", "energy", "regime"]},
        **changes,
    }


def compute(path, scan, **options):
    return content(nv.scan(scan, to=path, **options))


@pytest.fixture(scope="module", params=EVERY)
def every(request, tmp_path_factory):
    """Return scans one by one, each with what it gives on one thread in one block."""
    scan = nv.load_scan(document(*EVERY[request.param]))
    return scan, compute(tmp_path_factory.mktemp("whole") / "a.h5", scan, threads=1)


@pytest.fixture(autouse=True)
def _pieces(monkeypatch):
    """Let every lane be a piece, however short: the threads then take turns."""
    monkeypatch.setattr(batch, "PIECE_PERIODS", 1)


@pytest.fixture
def cut(monkeypatch):
    """Return a function that lets blocks have so many cells of `document()`."""

    def into(cells, starts=1):
        periods = starts * sum(SAMPLING.values())
        monkeypatch.setattr(cutting, "BLOCK_PERIODS", cells * periods)

    return into


def test_threads_blocks_and_shards_do_not_matter(every, tmp_path, cut):
    scan, whole = every
    assert {"section", "periodicity", "E1max", "label", "status"} <= whole.keys()
    assert compute(tmp_path / "two.h5", scan, threads=2) == whole
    counts = {len(list(cutting.blocks_of(scan)))}
    for cells in (1, 2, 7):
        cut(cells, scan.starts)
        counts.add(len(list(cutting.blocks_of(scan))))
        assert compute(tmp_path / f"{cells}.h5", scan, threads=2) == whole
    assert len(counts) > 1 or len(scan.axes) == 1  # an axis that is followed stays whole
    for shard in (Shard(1, 2), Shard(2, 2)):
        assert not (tmp_path / "shared.h5").exists() or counts == {1}
        run(scan, tmp_path / "shared.h5", RunOptions(shard=shard, quiet=True))
    assert content(tmp_path / "shared.h5") == whole


def test_the_orbits_compared_are_not_all_alike():
    compared = arrays(nv.scan(document(TWO_AXES, "random:3")))
    assert np.isfinite(compared["section"]).all()
    assert len(np.unique(compared["section"][..., -1, 0])) == compared["status"].size


@pytest.mark.parametrize("vary", [ONE_AXIS, TWO_AXES], ids=["1", "2"])
def test_both_is_up_and_down_in_one_archive(vary, cut):
    alone = [arrays(nv.scan(document(vary, policy))) for policy in ("up", "down")]
    assert not np.array_equal(alone[0]["section"], alone[1]["section"])
    cut(2, starts=2)
    path = nv.scan(document(vary, "both"))
    with nv.read(path) as archive:
        assert list(archive["start"]) == ["up", "down"]
    for name, both in arrays(path).items():
        for start, one in enumerate(alone):
            part = np.take(both, [start], axis=len(vary))
            np.testing.assert_array_equal(part, one[name], err_msg=name)


def test_more_threads_than_processors_do_not_matter(tmp_path):
    scan = nv.load_scan(document())
    (tmp_path / "scan.toml").write_text(scan.to_toml())
    words = ["-m", "nlds_vines.bifurcation", "scan.toml", "--threads", "5"]
    printed(*words, cwd=tmp_path, NUMBA_NUM_THREADS="5")
    with nv.read(tmp_path / "scan.h5") as archive:
        assert archive.attrs["threads"] == 5
    assert content(tmp_path / "scan.h5") == compute(tmp_path / "here.h5", scan, threads=1)


def stopped_after(blocks, scan, path):
    """Let Ctrl-C strike when so many blocks of a scan have been computed; return what is said."""
    computed, left = Computer.block, [None] * blocks

    def block(self, which):
        if not left:
            raise KeyboardInterrupt
        left.pop()
        return computed(self, which)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Computer, "block", block)
        with pytest.raises(Interrupted) as stop:
            run(scan, path)
    return str(stop.value)


def test_a_resumed_scan_reports_what_failed_before_the_interruption(tmp_path, cut):
    scan = nv.load_scan(document({"omega": {"values": [1e-6, 6.0, 6.28, 6.5]}}))
    cut(1)
    stopped_after(2, scan, tmp_path / "a.h5")
    for _ in ("resumed", "complete"):
        report = run(scan, tmp_path / "a.h5", RunOptions(resume=True))
        assert report.failures.total() == 1
        assert (report.labels.total(), report.labels["failed"]) == (4, 1)


SLOW = {"C": -0.06, "omega": 0.01, "K": 3.2e7}
"""A preloaded damper that rests on its obstacle for ten minutes between two sections."""

FAILURES = {
    "diverged": ("P", 1e200, {}, DIVERGED),
    "out of steps": ("K", 1e13, SLOW, STEP_BUDGET),
    "too stiff": ("c2", 1e12, {}, TOO_STIFF),
}


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("failure", "start"),
    [(failure, s) for failure in FAILURES for s in STARTS if failure != "out of steps"]
    # an orbit that is out of steps takes seconds; from above it is the first to be followed
    + [
        pytest.param("out of steps", s, marks=() if s == "down" else pytest.mark.long)
        for s in STARTS
    ],
)
def test_a_failed_lane_is_marked_and_leaves_its_neighbors_alone(failure, start, monkeypatch):
    name, bad, settings, code = FAILURES[failure]
    system = nv.load_system("ssul-set6", **settings)
    usual = system.K if name == "K" else system.parameters[name]
    good = [usual * factor for factor in (0.75, 1.0, 1.125)]
    settings = {key: value for key, value in settings.items() if key != name}

    def computed(values):
        sampling = {"transient": 2, "periods": 6}
        vary = {name: {"values": values}}
        return arrays(nv.scan(document(vary, start, set=settings, sampling=sampling)))

    alone, beside = computed(good), computed([*good, bad])
    monkeypatch.setattr(cutting, "BLOCK_PERIODS", 1)
    apart = computed([*good, bad])
    assert (alone["status"] == OK).all()
    assert (beside["status"][-1] == code).all()
    for name in alone:
        numbers = "label" not in name
        assert np.array_equal(beside[name][:-1], alone[name], equal_nan=numbers), name
        assert np.array_equal(beside[name], apart[name], equal_nan=numbers), name
    for name in ("section", "E1max", "impact_rate"):
        assert np.isnan(beside[name][-1]).all(), name
    for name, value in (("label", "failed"), ("impact_count", -1), ("periodicity", 0)):
        assert set(beside[name][-1]) == {value}, name


def test_failed_lanes_give_status_1_and_a_remedy(here, ask):
    (here / "scan.toml").write_text(nv.load_scan(document()).to_toml())
    out, err = ask("bifurcation", "scan.toml", "--vary", "P=800:1e200:2", "--quiet", status=1)
    assert out == ""
    assert "1 of 2 orbits failed" in err
    for option in ("--overwrite", "--resume"):  # computed again, and only looked at
        ask("bifurcation", "scan.toml", "--vary", "P=800:1e200:2", "--quiet", option, status=1)
    with nv.read("scan.h5") as archive:
        words = archive.flags("status")
        assert archive["status"].ravel().tolist() == [OK, DIVERGED]
    assert words[DIVERGED] == STATUS[DIVERGED].meaning


# ---- shards --------------------------------------------------------------------------------------

SCAN = document(
    {"omega": {"start": 6.0, "stop": 7.6, "num": 400}}, sampling={"transient": 5000, "periods": 24}
)
"""A few seconds in some ten blocks."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return compute(tmp_path_factory.mktemp("whole") / "a.h5", SCAN, threads=1)


@pytest.fixture
def folder(here):
    (here / "scan.toml").write_text(nv.load_scan(SCAN).to_toml())
    return here


def start(*arguments):
    return started("-m", "nlds_vines", "bifurcation", "scan.toml", *arguments)


def finish(running):
    """Wait for a run, which must end well; return what it prints."""
    status, out, err = ended(running)
    assert status == 0, err
    return out


@pytest.mark.kernels
def test_three_shards_side_by_side_end_in_the_same_bits(folder, whole):
    running = [start("--shard", f"{i}/3", "--threads", "1") for i in (1, 2, 3)]
    for each in running:
        assert "the last shard to end writes" in finish(each) or Path("scan.h5").exists()
    assert content("scan.h5") == whole
    assert sorted(os.listdir()) == ["scan.h5", "scan.toml"]


def test_shards_share_all_blocks_and_none_twice():
    blocks = [Block(i, ((i, i + 1),)) for i in range(23)]
    for count in (1, 2, 7, 23, 40):
        shares = [blocks[Shard(i, count).blocks] for i in range(1, count + 1)]
        assert sorted((b for share in shares for b in share), key=lambda b: b.index) == blocks
        assert max(map(len, shares)) - min(map(len, shares)) <= 1


@pytest.mark.kernels
def test_a_shard_without_blocks_says_so(here, answer):
    scan = ["bifurcation", "--system", "none", "--vary", "omega=6:7:3", "--transient", "1"]
    scan += ["--periods", "2", "--record", "section", "-o", "a.h5"]
    words = "shard 3/7 is empty: 0 of 1 block; shards 1 to 1 have them all"
    assert words in answer(*scan, "--shard", "3/7").splitlines()
    assert answer(*scan, "--shard", "3/7", "--dry-run").splitlines()[-1] == words
    first = answer(*scan, "--shard", "1/7", "--dry-run")
    assert first.splitlines()[-1] == "shard 1/7: 1 of 1 block"
    assert "empty" not in answer(*scan, "--shard", "1/7")


def test_a_task_of_a_slurm_array_knows_its_shard_or_is_refused(error_of):
    def array(ID=7, MIN=7, MAX=7):
        numbers = {"ID": ID, "MIN": MIN, "MAX": MAX, "COUNT": 7}
        return {f"SLURM_ARRAY_TASK_{name}": str(number) for name, number in numbers.items()}

    assert Shard.parse("slurm", array(0, 0, 6)) == Shard(1, 7)
    assert Shard.parse("slurm", array(7, 1, 7)) == Shard(7, 7)
    assert Shard.parse("2/7", {}) == Shard(2, 7)
    assert str(Shard(2, 7)) == "2/7"
    for environment in ({}, array(MIN="x"), array(3, 1, 13), array(9, 1, 7)):
        assert "--shard slurm: " in error_of(Shard.parse, "slurm", environment)


# ---- executors -----------------------------------------------------------------------------------


@pytest.fixture
def small(cut):
    """Return a scan of seven blocks, of two cells but for the last."""
    cut(2)
    return nv.load_scan(document())


class Elsewhere(Executor):
    """Computes what it is sent as bytes alone, and sends back what can be sent as bytes."""

    def __init__(self):
        self.sent = []

    def submit(self, work, /, *arguments):
        self.sent.append(pickle.dumps((work, arguments)))
        work, arguments = pickle.loads(self.sent[-1])
        future = Future()
        try:
            future.set_result(pickle.loads(pickle.dumps(work(*arguments))))
        except Exception as error:
            future.set_exception(error)
        return future


def test_workers_need_nothing_of_the_client_s_disk(small, tmp_path):
    whole = compute(tmp_path / "whole.h5", small)
    threads, elsewhere = threads_in_use(), Elsewhere()
    assert compute(tmp_path / "a.h5", small, executor=elsewhere) == whole
    assert len(elsewhere.sent) == len(cutting.blocks_of(small))
    assert not any(str(tmp_path).encode() in text for text in elsewhere.sent)
    assert threads_in_use() == threads
    with ThreadPoolExecutor(3) as pool:
        assert compute(tmp_path / "b.h5", small, executor=pool) == whole


def test_a_worker_of_another_version_is_refused_before_it_computes(
    small, here, monkeypatch, error_of
):
    monkeypatch.setattr(scan_run, "_prepared", lambda *_: pytest.fail("it computes"))
    other = {**makers(), "source_hash": "another", "numpy_version": "1.0"}
    with monkeypatch.context() as patch:
        patch.setattr("nlds_vines.archives.provenance.makers", lambda: other)

        class Worker(Elsewhere):
            def submit(self, work, /, *arguments):
                patch.undo()  # the worker has what is installed here
                return super().submit(work, *arguments)

        line = error_of(nv.scan, small, to="a.h5", executor=Worker())
    assert re.search(r"another version: .*numpy_version .*, not 1\.0", line)
    assert os.listdir() == []


@pytest.mark.kernels
def test_processes_of_a_pool_end_in_the_same_bits_and_a_dead_one_is_one_line(here, whole, error_of):
    scan = nv.load_scan(SCAN)
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        assert compute("b.h5", scan, executor=pool) == whole
        for process in pool._processes.values():
            process.kill()
        line = error_of(nv.scan, scan, to="c.h5", executor=pool)
    assert re.search("a worker has died: .*; resume=True goes on", line)


@pytest.mark.parametrize("knows", ["when an item is submitted", "when its result is asked for"])
def test_a_dead_worker_is_one_line_whenever_the_executor_knows(knows, error_of):
    class Dead(Executor):
        def submit(self, work, /, *arguments):
            error = BrokenProcessPool("a child process terminated abruptly")
            if knows == "when an item is submitted":
                raise error
            future = Future()
            future.set_exception(error)
            return future

    line = error_of(list, executors.as_finished(Dead(), abs, [3, 5], 1))
    assert re.search("a worker has died: a child .*; resume=True goes on", line)


def test_what_fails_now_and_then_is_tried_again(error_of):
    tries = []

    def work(item):
        tries.append(item)
        if len(tries) % 4:
            raise OSError("the network is down")
        return item**2

    def refused(item):
        raise KeyError("no")

    with ThreadPoolExecutor(1) as pool:
        assert list(executors.as_finished(pool, work, [3, 5], 1)) == [(3, 9), (5, 25)]
        line = error_of(list, executors.as_finished(pool, refused, [3], 5))
    assert "block 3 has failed 4 times, at last: KeyError" in line


# ---- a Dask cluster ------------------------------------------------------------------------------

dask = pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")


def workers_of(process):
    """Return the process ids of the workers that a run has started, by its grandchildren."""
    import psutil

    pids = []
    for child in psutil.Process(process.pid).children(recursive=True):
        try:
            if "spawn_main" in " ".join(child.cmdline()):
                pids.append(child.pid)
        except psutil.NoSuchProcess:
            continue
    return pids


@pytest.mark.kernels
@dask
def test_workers_killed_three_times_end_in_the_same_bits(folder, whole):
    running = start("--scheduler", "local:2")
    kills, seen = 0, 0
    while kills < 3 and running.poll() is None:
        parts = len(list(folder.glob("scan.h5.*.blocks/*.npz")))
        workers = workers_of(running)
        if workers and parts >= seen:
            os.kill(workers[kills % len(workers)], signal.SIGKILL)
            kills, seen = kills + 1, parts + 1
        time.sleep(0.05)
    finish(running)
    assert kills == 3
    assert content("scan.h5") == whole
    assert sorted(os.listdir()) == ["scan.h5", "scan.toml"]


@dask
def test_a_cluster_that_is_not_there_is_one_line(folder, monkeypatch, refusal):
    monkeypatch.setattr("nlds_vines.scans.cluster.CONNECT_SECONDS", 0.2)
    err = refusal("bifurcation", "scan.toml", "--scheduler", "tcp://127.0.0.1:9")
    assert "--scheduler 'tcp://127.0.0.1:9' cannot be reached" in err


@pytest.mark.kernels
@dask
def test_a_stopped_cluster_run_can_be_resumed_without_a_cluster(folder, whole):
    running = start("--scheduler", "local:1")
    while not list(folder.glob("scan.h5.*.blocks/*.npz")):
        assert running.poll() is None, running.stderr.read()
        time.sleep(0.05)
    running.send_signal(signal.SIGTERM)
    status, _, err = ended(running)
    assert status == 143, err
    assert "--resume" in err
    finish(start("--resume"))
    assert content("scan.h5") == whole


@pytest.fixture
def scheduling(tmp_path):
    """Start a scheduler without workers; return its process and its address."""
    file = tmp_path / "scheduler.json"
    options = ["--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", file]
    with started("-m", "distributed.cli.dask_scheduler", *options) as running:
        while not file.exists() or not file.read_text():
            assert running.poll() is None
            time.sleep(0.05)
        yield running, json.loads(file.read_text())["address"]
        running.terminate()


@pytest.mark.slow("a scheduler")
@dask
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_scheduler_that_dies_is_one_line(folder, scheduling, how, capfd, monkeypatch):
    running, address = scheduling
    submitted = scan_run.as_finished

    def doomed(*arguments):
        Later(0.5, running.send_signal, [how]).start()
        return submitted(*arguments)

    monkeypatch.setattr(scan_run, "as_finished", doomed)
    assert console(["bifurcation", "scan.toml", "--scheduler", address, "--quiet"]) == 2
    err = capfd.readouterr().err
    assert err.count("\n") == 1
    assert f"--scheduler {address!r} is gone; --resume goes on" in err


@pytest.mark.kernels
@dask
def test_a_cluster_without_workers_is_waited_for(folder, scheduling, whole):
    _, scheduler = scheduling
    running = start("--scheduler", scheduler, "--quiet")
    time.sleep(3.0)
    (folder / "elsewhere").mkdir()
    command = ["-m", "distributed.cli.dask_worker", scheduler, "--nthreads", "2"]
    options = ["--no-dashboard", "--no-nanny"]
    with started(*command, *options, cwd=folder / "elsewhere") as worker:
        try:
            finish(running)
        finally:
            worker.terminate()
    assert content("scan.h5") == whole


def test_waiting_is_said_again_and_again(monkeypatch, capsys):
    monkeypatch.setattr(executors, "POLL_SECONDS", 0.02)
    monkeypatch.setattr(executors, "STALL_SECONDS", 0.1)
    with ThreadPoolExecutor(1) as pool:
        list(executors.as_finished(pool, time.sleep, [0.5], 1))
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "no block has been finished for 0 s"
    assert 2 <= len(lines) <= 5
