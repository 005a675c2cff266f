"""One scan on many machines: shards side by side, workers killed, and the same bits."""

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from threading import Timer as Later
from types import SimpleNamespace

import pytest
from made_up import cut, fill, make_scan, run_python
from test_determinism import bits, document, surroundings

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives.provenance import makers
from nlds_vines.bifurcation import cluster
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.errors import RequestError
from nlds_vines.runs.executors import Shard

SCAN = document(
    {"omega": {"start": 6.0, "stop": 7.6, "num": 400}}, sampling={"transient": 5000, "periods": 24}
)
"""A few seconds in some ten blocks."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What one thread makes of the scan."""
    return bits(nv.scan(SCAN, to=tmp_path_factory.mktemp("whole") / "a.h5", threads=1))


@pytest.fixture
def folder(here):
    (here / "scan.toml").write_text(nv.load_scan(SCAN).to_toml())
    return here


def start(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "nlds_vines", "bifurcation", "scan.toml", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=surroundings(),
    )


def finish(running):
    out, err = running.communicate()
    assert running.returncode == 0, err
    return out, err


# ---- shards --------------------------------------------------------------------------------------


@pytest.mark.kernels
def test_seven_shards_side_by_side_end_in_the_same_bits(folder, whole):
    for shards in ([1, 2], [3, 4, 5], [6, 7]):
        running = [start("--shard", f"{i}/7", "--threads", "1") for i in shards]
        for each in running:
            out, _ = finish(each)
            assert ("the last shard to end writes" in out) or Path("scan.h5").exists()
    assert bits("scan.h5") == whole
    assert sorted(os.listdir()) == ["scan.h5", "scan.toml"]


def test_shards_share_all_blocks_and_none_twice():
    blocks = [Block(i, ((i, i + 1),)) for i in range(23)]
    for count in (1, 2, 7, 23, 40):
        shares = [blocks[Shard(i, count).blocks] for i in range(1, count + 1)]
        assert sorted((b for share in shares for b in share), key=lambda b: b.index) == blocks
        assert max(map(len, shares)) - min(map(len, shares)) <= 1


def test_the_last_of_several_shards_is_alone(tmp_path):
    scan, path = make_scan(), tmp_path / "a.h5"
    with (
        Parts.open(path, scan, shard=Shard(1, 2)) as one,
        Parts.open(path, scan, shard=Shard(2, 2)) as two,
    ):
        assert not one.is_alone()
        assert two.is_alone()
        assert not one.is_alone()
        with pytest.raises(RequestError, match="another run"):
            Parts.open(path, scan, shard=Shard(3, 3))


def begin(path, scan, shard):
    with Parts.open(path, scan, shard=shard) as parts:
        fill(parts, scan, cut(scan)[shard.blocks])


@pytest.mark.kernels
def test_a_shard_without_blocks_says_so(here, capsys, answer):
    scan = ["bifurcation", "--system", "none", "--vary", "omega=6:7:3", "--transient", "1"]
    scan += ["--periods", "2", "--record", "section", "-o", "a.h5"]
    assert main([*scan, "--shard", "3/7"]) == 0
    words = "shard 3/7 is empty: 0 of 1 block; shards 1 to 1 have them all"
    assert words in capsys.readouterr().out.splitlines()
    assert answer(*scan, "--shard", "3/7", "--dry-run").splitlines()[-1] == words
    assert (
        answer(*scan, "--shard", "1/7", "--dry-run").splitlines()[-1] == "shard 1/7: 1 of 1 block"
    )
    assert "empty" not in answer(*scan, "--shard", "1/7")


def test_a_shard_never_shares_its_share_nor_a_folder_held_by_a_run(tmp_path):
    scan, path = make_scan(), tmp_path / "a.h5"
    with Parts.open(path, scan, shard=Shard(1, 2)):
        with Parts.open(path, scan, shard=Shard(2, 2)):
            pass
        for how in ({"shard": Shard(1, 2)}, {"resume": True}, {"overwrite": True}):
            with pytest.raises(RequestError, match="another run"):
                Parts.open(path, scan, **how)
    with (
        Parts.open(path, scan, resume=True),
        pytest.raises(RequestError, match="another run"),
    ):
        Parts.open(path, scan, shard=Shard(1, 2))


def test_a_shard_refuses_the_parts_of_another_scan_by_name(tmp_path):
    path = tmp_path / "a.h5"
    begin(path, make_scan(), Shard(1, 2))
    with pytest.raises(RequestError, match=r"another scan.*a test"):
        Parts.open(path, make_scan(P=801.0), shard=Shard(2, 2))
    with pytest.raises(RequestError, match="exclude"):
        Parts.open(path, make_scan(), shard=Shard(2, 2), overwrite=True)


ARRAY = {f"SLURM_ARRAY_TASK_{name}": "7" for name in ("ID", "MIN", "MAX", "COUNT")}


def array(**numbers):
    return ARRAY | {f"SLURM_ARRAY_TASK_{name}": str(number) for name, number in numbers.items()}


def test_a_task_of_a_slurm_array_knows_its_shard():
    assert Shard.parse("slurm", array(ID=0, MIN=0, MAX=6)) == Shard(1, 7)
    assert Shard.parse("slurm", array(ID=7, MIN=1, MAX=7)) == Shard(7, 7)
    assert Shard.parse("2/7", {}) == Shard(2, 7)
    assert str(Shard(2, 7)) == "2/7"


@pytest.mark.parametrize(
    "environment", [{}, array(MIN="x"), array(ID=3, MIN=1, MAX=13), array(ID=9, MIN=1, MAX=7)]
)
def test_a_task_that_does_not_know_its_shard_is_refused(environment):
    with pytest.raises(RequestError, match="--shard slurm: "):
        Shard.parse("slurm", environment)


BOTH = """
import sys
sys.path.insert(0, {tests!r})
from test_shards import *
sys.stdin.readline()
begin(Path({path!r}), make_scan(P=float({P})), Shard({i}, 2))
"""


def test_shards_of_two_scans_that_begin_at_once_do_not_mix(tmp_path):
    path, tests = tmp_path / "a.h5", os.path.dirname(__file__)
    programs = [BOTH.format(tests=tests, path=str(path), P=800 + i, i=i) for i in (1, 2)]
    running = [run_python(program, stdin=subprocess.PIPE) for program in programs]
    said = [None, None]
    for each in running:
        each.stdin.write("\n")
        each.stdin.flush()
    for i, each in enumerate(running):
        said[i] = each.communicate()[1]
    assert sorted(bool(text) for text in said) == [False, True], said
    assert "another scan" in "".join(said)


# ---- a Dask cluster ------------------------------------------------------------------------------

dask = pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")


def workers_of(process):
    """Return the process ids of the workers that a run has started, by its grandchildren."""
    import psutil

    found = []
    for child in psutil.Process(process.pid).children(recursive=True):
        try:
            if "spawn_main" in " ".join(child.cmdline()):
                found.append(child.pid)
        except psutil.NoSuchProcess:
            continue
    return found


@pytest.mark.kernels
@dask
def test_workers_killed_three_times_end_in_the_same_bits(folder, whole):
    running = start("--scheduler", "local:2")
    kills, seen = 0, 0
    while kills < 3 and running.poll() is None:
        parts = len(list(folder.glob("scan.h5.parts/block-*.part")))
        workers = workers_of(running)
        if workers and parts >= seen:
            os.kill(workers[kills % len(workers)], signal.SIGKILL)
            kills, seen = kills + 1, parts + 1
        time.sleep(0.05)
    finish(running)
    assert kills == 3
    assert bits("scan.h5") == whole
    assert sorted(os.listdir()) == ["scan.h5", "scan.toml"]


@dask
def test_a_cluster_that_is_not_there_is_one_line(folder, monkeypatch, refusal):
    monkeypatch.setattr("nlds_vines.bifurcation.cluster.CONNECT_SECONDS", 0.2)
    err = refusal("bifurcation", "scan.toml", "--scheduler", "tcp://127.0.0.1:9")
    assert err.count("\n") == 1
    assert "--scheduler 'tcp://127.0.0.1:9' cannot be reached" in err


@pytest.mark.kernels
@dask
def test_a_stopped_cluster_run_can_be_resumed_without_a_cluster(folder, whole):
    running = start("--scheduler", "local:1")
    while not list(folder.glob("scan.h5.parts/block-*.part")):
        assert running.poll() is None, running.stderr.read()
        time.sleep(0.05)
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate()
    assert running.returncode == 143, err
    assert "--resume" in err
    finish(start("--resume"))
    assert bits("scan.h5") == whole


@pytest.fixture
def scheduling(tmp_path):
    """Start a scheduler without workers; return its process and its address."""
    file = tmp_path / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0"]
    options = ["--no-dashboard", "--no-show", "--scheduler-file", str(file)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = subprocess.Popen([*command, *options], **quiet)
    while not file.exists() or not file.read_text():
        assert running.poll() is None
        time.sleep(0.05)
    yield running, json.loads(file.read_text())["address"]
    running.terminate()
    running.wait()


@pytest.fixture
def scheduler(scheduling):
    """Start a scheduler without workers; return its address."""
    return scheduling[1]


@pytest.mark.slow("a scheduler")
@dask
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_scheduler_that_dies_is_one_line(folder, scheduling, how, capfd, monkeypatch):
    running, address = scheduling
    met = cluster._refuse_others

    def doomed(client):
        met(client)
        Later(0.5, running.send_signal, [how]).start()

    monkeypatch.setattr(cluster, "_refuse_others", doomed)
    assert main(["bifurcation", "scan.toml", "--scheduler", address, "--quiet"]) == 2
    err = capfd.readouterr().err
    assert err.count("\n") == 1
    assert f"--scheduler {address!r} is gone; --resume goes on" in err


@dask
def test_a_worker_of_another_version_is_refused_before_it_computes(folder):
    from nlds_vines.bifurcation import cluster

    other = {**makers(), "source_hash": "another", "numpy_version": "1.0"}
    client = SimpleNamespace(run=lambda asked: {"tcp://n1:1": asked(), "tcp://n2:1": other})
    with pytest.raises(RequestError, match=r"the worker tcp://n2:1 .* source_hash another, here"):
        cluster._refuse_others(client)
    with pytest.raises(RequestError, match=r"asked by another version: .*numpy_version 1\.0"):
        cluster.work(str(folder), "0", Block(0, ((0, 1),)), None, other)

    def without(asked):
        raise ModuleNotFoundError("No module named 'nlds_vines'")

    with pytest.raises(RequestError, match="a worker has not what it needs: No module named"):
        cluster._refuse_others(SimpleNamespace(run=without))


@pytest.mark.kernels
@dask
def test_a_cluster_without_workers_is_waited_for_and_given_up(
    folder, scheduler, whole, monkeypatch, ask
):
    for name, value in {"STALL_SECONDS": 0.3, "MOST_STALLS": 1, "POLL_SECONDS": 0.1}.items():
        monkeypatch.setattr(f"nlds_vines.bifurcation.cluster.{name}", value)
    said = ask("bifurcation", "scan.toml", "--scheduler", scheduler, status=2).err.splitlines()
    assert said[0] == "no progress: 0 workers; submitting again"
    assert "--resume goes on" in said[1]
    assert len(said) == 2
    monkeypatch.setattr(
        "nlds_vines.bifurcation.cluster.MOST_STALLS", 20
    )  # it takes a worker more to load
    command = [sys.executable, "-m", "distributed.cli.dask_worker", scheduler, "--nthreads", "2"]
    with open("worker.log", "w") as log:
        worker = subprocess.Popen(
            [*command, "--no-dashboard", "--no-nanny"], env=surroundings(), stdout=log, stderr=log
        )
    try:
        assert main(["bifurcation", "scan.toml", "--resume", "--scheduler", scheduler]) == 0
    finally:
        worker.terminate()
        worker.wait()
    assert bits("scan.h5") == whole


@dask
def test_workers_that_do_not_see_the_folder_are_told(folder, monkeypatch):
    from nlds_vines.bifurcation.cluster import work

    with pytest.raises(RequestError, match="is the folder shared"):
        work(str(folder), "0", Block(0, ((0, 1),)), None, makers())
