"""The same scan gives the same bits: any threads, any blocks, stopped and resumed, beside failures.

All scans here record the same of the same scene, so that one compilation serves them all.
"""

import numpy as np
import pytest
from commands import printed
from made_up import arrays, content

import nlds_vines as nv
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.run import Computer, run
from nlds_vines.cli.running import RunOptions
from nlds_vines.orbits import batch
from nlds_vines.orbits.records import DIVERGED, OK, STATUS, STEP_BUDGET, TOO_STIFF
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.store import Blocks

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
        run(scan, tmp_path / "shared.h5", RunOptions(shard=shard, quiet=True))
    assert content(tmp_path / "shared.h5") == whole


def test_the_orbits_compared_are_not_all_alike(tmp_path):
    found = arrays(nv.scan(document(TWO_AXES, "random:3"), to=tmp_path / "a.h5"))
    assert np.isfinite(found["section"]).all()
    assert len(np.unique(found["section"][..., -1, 0])) == found["status"].size


@pytest.mark.parametrize("vary", [ONE_AXIS, TWO_AXES], ids=["1", "2"])
def test_both_is_up_and_down_in_one_archive(vary, tmp_path, cut):
    alone = {
        policy: arrays(nv.scan(document(vary, policy), to=tmp_path / f"{policy}.h5"))
        for policy in ("up", "down")
    }
    assert not np.array_equal(alone["up"]["section"], alone["down"]["section"])
    cut(2, starts=2)
    path = nv.scan(document(vary, "both"), to=tmp_path / "both.h5")
    with nv.read(path) as archive:
        assert list(archive["start"]) == ["up", "down"]
    for name, array in arrays(path).items():
        for start, policy in enumerate(("up", "down")):
            one = np.take(array, [start], axis=len(vary))
            np.testing.assert_array_equal(one, alone[policy][name], err_msg=name)


def test_more_threads_than_processors_do_not_matter(tmp_path):
    scan = nv.load_scan(document())
    (tmp_path / "scan.toml").write_text(scan.to_toml())
    words = ["-m", "nlds_vines.bifurcation", "scan.toml", "--threads", "5"]
    printed(*words, cwd=tmp_path, NUMBA_NUM_THREADS="5")
    with nv.read(tmp_path / "scan.h5") as archive:
        assert archive.attrs["threads"] == 5
    assert content(tmp_path / "scan.h5") == compute(tmp_path / "here.h5", scan, threads=1)


def stop_after(monkeypatch, blocks):
    """Let Ctrl-C strike when so many blocks have been computed; return how to end that."""
    left = [blocks]
    computed = Computer.block

    def block(self, which):
        if left[0] == 0:
            raise KeyboardInterrupt
        left[0] -= 1
        return computed(self, which)

    monkeypatch.setattr(Computer, "block", block)
    return lambda: monkeypatch.setattr(Computer, "block", computed)


def test_a_resumed_scan_ends_in_the_same_bits(every, tmp_path, monkeypatch, cut):
    scan, whole = every
    cut(2, scan.starts)
    blocks = len(list(cutting.blocks_of(scan)))
    done = min(3, blocks - 1)
    go_on = stop_after(monkeypatch, done)
    path = tmp_path / "stopped.h5"
    with pytest.raises(Interrupted, match="--resume") as stop:
        nv.scan(scan, to=path)
    assert f"{done} of {blocks} blocks" in str(stop.value)
    assert not path.exists()
    folder = Blocks(path, scan).folder
    files = sorted(folder.glob("*"))
    assert len(files) == done
    for block in files[:1]:
        block.unlink()
    go_on()
    assert compute(path, scan, resume=True) == whole
    assert not folder.exists()


def test_a_resumed_scan_reports_what_failed_before_the_interruption(tmp_path, monkeypatch, cut):
    scan = nv.load_scan(document({"omega": {"values": [1e-6, 6.0, 6.28, 6.5]}}))
    path = tmp_path / "a.h5"
    cut(1)
    go_on = stop_after(monkeypatch, 2)
    with pytest.raises(Interrupted):
        run(scan, path)
    go_on()
    for _ in ("resumed", "complete"):
        report = run(scan, path, RunOptions(resume=True))
        assert report.failures.total() == 1
        assert report.labels.total() == 4
        assert report.labels["failed"] == 1


SLOW = {"C": -0.06, "omega": 0.01, "K": 3.2e7}
"""A preloaded damper that rests on its obstacle for ten minutes between two sections."""

FAILURES = {
    "diverged": ("P", 1e200, {}, DIVERGED),
    "out of steps": ("K", 1e13, SLOW, STEP_BUDGET),
    "too stiff": ("c2", 1e12, {}, TOO_STIFF),
}


@pytest.mark.kernels
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("failure", FAILURES)
def test_a_failed_lane_is_marked_and_leaves_its_neighbors_alone(
    failure, start, tmp_path, monkeypatch
):
    name, bad, settings, code = FAILURES[failure]
    system = nv.load_system("ssul-set6", **settings)
    usual = system.K if name == "K" else system.parameters[name]
    good = [usual * factor for factor in (0.75, 1.0, 1.125)]
    settings = {key: value for key, value in settings.items() if key != name}

    def found(path, values):
        sampling = {"transient": 2, "periods": 6}
        vary = {name: {"values": values}}
        scan = document(vary, start, set=settings, sampling=sampling)
        return arrays(nv.scan(scan, to=tmp_path / path))

    alone, beside = found("alone.h5", good), found("beside.h5", [*good, bad])
    monkeypatch.setattr(cutting, "BLOCK_PERIODS", 1)
    apart = found("apart.h5", [*good, bad])
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
        assert main(["scan.toml", "--vary", "P=800:1e200:2", "--quiet", option]) == 1
    with nv.read("scan.h5") as archive:
        words = archive.flags("status")
        assert archive["status"].ravel().tolist() == [OK, DIVERGED]
    assert words[DIVERGED] == STATUS[DIVERGED].meaning
