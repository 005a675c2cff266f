"""Blocks whole or absent: what exists, what is begun, two runs, killed runs, damage, full disks."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest
from made_up import arrays, cut, make_scan, results, run_python, same, write

from nlds_vines.archives import archive
from nlds_vines.bifurcation.run import writer_of
from nlds_vines.cli.running import RunOptions
from nlds_vines.errors import RequestError
from nlds_vines.runs import store as runs_store
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.store import Blocks
from scans import stored, written


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


def begin(path, scan, count=2, **how):
    def interrupted(block):
        if block.index == count:
            raise KeyboardInterrupt
        return results(scan, block)

    with pytest.raises(Interrupted) as stop:
        written(path, scan, cut(scan), interrupted, **how)
    return str(stop.value)


def computed(path, scan, **how):
    computed_blocks = []

    def note(block):
        computed_blocks.append(block.index)
        return results(scan, block)

    written(path, scan, cut(scan), note, **how)
    return computed_blocks


# ---- what exists ---------------------------------------------------------------------------------


def test_an_existing_archive_is_refused_and_untouched(path):
    write(path, make_scan())
    before = path.read_bytes()
    with pytest.raises(RequestError, match="--overwrite"):
        write(path, make_scan())
    with pytest.raises(RequestError, match="another scan"):
        write(path, make_scan(P=801.0), resume=True)
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_overwrite_keeps_the_old_archive_until_the_new_one_is_there(path):
    old, new = make_scan(), make_scan(P=801.0)
    write(path, old)
    before = path.read_bytes()
    assert "the same command goes on" in begin(path, new, overwrite=True)
    assert path.read_bytes() == before
    with pytest.raises(RequestError, match="another scan"):
        computed(path, new, resume=True)  # nobody has said that it may be replaced
    assert computed(path, new, overwrite=True) == [2]
    with archive.read(path) as view:
        assert view.attrs["scan_hash"] == new.hash
    assert os.listdir(path.parent) == [path.name]


def test_resume_of_a_complete_archive_has_nothing_to_do_and_of_a_damaged_one_is_refused(path):
    write(path, make_scan())
    before = path.read_bytes()
    store = Blocks(path, make_scan())
    store.save(0, {})  # the run was killed before it had removed all blocks
    assert computed(path, make_scan(), resume=True) == []
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]
    path.write_bytes(before[:3000])
    with pytest.raises(RequestError, match=r"cannot be opened.*damaged"):
        write(path, make_scan(), resume=True)


def test_resume_computes_what_is_missing_and_ends_in_the_same_arrays(tmp_path, path):
    scan = make_scan()
    printed = begin(path, scan)
    assert "2 blocks are kept" in printed
    assert "the same command with --resume goes on" in printed
    with pytest.raises(RequestError, match=r"unfinished run.*--resume"):
        computed(path, scan)
    assert computed(path, scan, resume=True) == [2]
    assert same(arrays(path), arrays(write(tmp_path / "straight.h5", scan)))
    assert sorted(os.listdir(tmp_path)) == ["scan.h5", "straight.h5"]


def test_a_run_that_is_stopped_before_its_first_block_leaves_nothing(path):
    assert "0 blocks are kept" in begin(path, make_scan(), 0)
    assert os.listdir(path.parent) == []


# ---- whose blocks --------------------------------------------------------------------------------


def test_blocks_of_two_requests_and_of_two_versions_never_mix(path, monkeypatch, capsys):
    scan = make_scan()
    begin(path, scan)
    assert computed(path, make_scan(P=801.0)) == [0, 1, 2]
    path.unlink()
    capsys.readouterr()
    makers = {**runs_store.makers(), "numba_version": "0.1"}  # upgraded in mid-run
    with monkeypatch.context() as patch:
        patch.setattr(runs_store, "makers", lambda: makers)
        assert computed(path, scan, resume=True) == [0, 1, 2]
        path.unlink()
    (err,) = capsys.readouterr().err.splitlines()
    assert err.endswith(".blocks is of another request or version: nothing in it is used")
    assert computed(path, scan, resume=True) == [2]


@pytest.mark.parametrize(
    "name", ["source_hash", "numba_version", "numpy_version", "scipy_version", "machine"]
)
def test_what_may_change_a_bit_is_in_the_name_of_the_folder(name, path, monkeypatch):
    before = Blocks(path, make_scan()).folder
    assert Blocks(path, make_scan()).folder == before
    other = {**runs_store.makers(), name: "another"}
    monkeypatch.setattr(runs_store, "makers", lambda: other)
    assert Blocks(path, make_scan()).folder != before


def test_a_file_of_somebody_else_in_the_folder_stays(path):
    scan = make_scan()
    begin(path, scan)
    notes = Blocks(path, scan).folder / "notes.txt"
    notes.write_text("of the user")
    assert computed(path, scan, resume=True) == [2]
    assert notes.read_text() == "of the user"


def test_a_block_of_which_a_byte_is_flipped_or_cut_is_computed_again(path, capsys):
    store = Blocks(path, make_scan())
    saved = {"a": np.arange(3.0), "label": np.array(["T,1", "3T,3"])}
    store.save(7, saved, 0.5)
    whole, results = store.file(7).read_bytes(), []
    for place in range(len(whole)):
        store.file(7).write_bytes(whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
        results.append(store.load(7))
    for size in range(0, len(whole), 7):
        store.file(7).write_bytes(whole[:size])
        assert store.load(7) is None
    lines = capsys.readouterr().err.splitlines()
    assert all("7.npz is computed again: " in line for line in lines)
    read = [one for one in results if one is not None]
    assert all(same(one, saved) for one in read)  # some bytes mean nothing, as a member's date
    assert len(read) < 0.3 * len(whole)


def test_damaged_blocks_are_computed_again_with_a_line_each(path, capsys):
    scan = make_scan()
    begin(path, scan)
    store = Blocks(path, scan)
    store.file(0).write_bytes(store.file(0).read_bytes()[:-100])
    content = bytearray(store.file(1).read_bytes())
    content[content.index(b"NUMPY") + 130] ^= 1
    store.file(1).write_bytes(content)
    assert computed(path, scan, resume=True) == [0, 1, 2]
    assert [Path(line.split(" is ")[0]).name for line in capsys.readouterr().err.splitlines()] == [
        "0.npz",
        "1.npz",
    ]
    assert same(arrays(path), arrays(write(path.with_name("straight.h5"), scan)))


# ---- several at once -----------------------------------------------------------------------------


class Meanwhile:
    """Results of a run, in the middle of which something else happens."""

    def __init__(self, scan, when, act):
        self.scan, self.when, self.act = scan, when, act

    def __call__(self, block):
        if block.index == self.when:
            self.act()
        return results(self.scan, block)


@pytest.mark.parametrize("when", [0, 2])
def test_of_two_runs_on_one_output_both_end_well(path, when):
    scan = make_scan()

    def other():
        write(path, scan, resume=True)

    for how in ({}, {"overwrite": True}):
        written(path, scan, cut(scan), Meanwhile(scan, when, other), **how)
        assert same(arrays(path), arrays(write(path.with_name("straight.h5"), scan)))
        path.with_name("straight.h5").unlink()
        assert os.listdir(path.parent) == [path.name]


@pytest.mark.parametrize("moment", ["write", "publish"])
def test_who_is_last_to_name_the_archive_leaves_the_first_one(path, monkeypatch, moment):
    """Two shards find all blocks; the other one is faster by a moment."""
    scan, first = make_scan(), []
    module = {"write": archive, "publish": runs_store}[moment]
    really = getattr(module, moment)

    def late(*arguments):
        if not first:
            first.append(True)
            write(path, scan, shard=Shard(2, 2))
            first.append(path.read_bytes())
        return really(*arguments)

    monkeypatch.setattr(module, moment, late)
    write(path, scan, shard=Shard(1, 2))
    assert path.read_bytes() == first[1]
    assert os.listdir(path.parent) == [path.name]


def test_shards_make_the_archive_when_all_blocks_are_there(path):
    scan = make_scan()
    written(path, scan, cut(scan), lambda b: results(scan, b), missing=[1], shard=Shard(1, 2))
    assert not path.exists()
    written(path, scan, cut(scan), lambda b: results(scan, b), shard=Shard(2, 2))
    assert arrays(path)
    with pytest.raises(RequestError, match="another scan"):
        write(path, make_scan(P=801.0), shard=Shard(2, 2))


# ---- the end of a run ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("moment", "before"),
    [("write", False), ("publish", False), ("write", True), ("replace_target", True)],
)
def test_an_interrupted_delivery_leaves_what_was_there(path, monkeypatch, moment, before):
    scan, old = make_scan(), make_scan(P=801.0)
    if before:
        write(path, old)
    was = path.read_bytes() if before else None

    def die(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(archive if moment == "write" else runs_store, moment, die)
        with pytest.raises(Interrupted):
            write(path, scan, overwrite=before)
    assert (path.read_bytes() if path.exists() else None) == was
    assert computed(path, scan, overwrite=before, resume=not before) == []
    assert arrays(path)
    assert os.listdir(path.parent) == [path.name]


FULL = """
import resource, signal, sys
sys.path[:0] = {tests!r}
from test_blocks import *
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
scan, path = make_scan(), Path({path!r})
begin(path, scan)
size = max(file.stat().st_size for file in Blocks(path, scan).folder.iterdir())
for limit in (100, size + 9):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        computed(path, scan, resume=True)
    except RequestError as error:
        print(error, flush=True)
"""


def test_a_full_disk_is_one_line_and_the_blocks_are_intact(path):
    """A limit on the size of files stands in for the disk: writing fails half-way."""
    here = Path(__file__).parent
    run = run_python(FULL.format(path=str(path), tests=[str(here), str(here.parent)]))
    output, errors = run.communicate()
    assert errors == ""
    block, whole = output.splitlines()
    assert block.startswith("cannot write a block in ")
    assert whole.startswith(f"cannot write {path} (the blocks are intact, use --resume): ")
    assert not path.exists()
    assert computed(path, make_scan(), resume=True) == []
    assert arrays(path)


def test_a_folder_that_cannot_be_written_is_one_line(path, monkeypatch):
    scan = make_scan()
    with pytest.raises(RequestError, match=r"cannot write a block in .*No such file"):
        write(path.parent / "nowhere" / "scan.h5", scan)

    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(RequestError, match=r"cannot write a block in .*Read-only"):
        write(path, scan)
    assert os.listdir(path.parent) == []


def test_blocks_that_vanish_are_said(path):
    scan, store = make_scan(), Blocks(path, make_scan())
    for block in cut(scan):
        store.save(block.index, stored(scan, results(scan, block)))
    write_archive = writer_of(scan, store, cut(scan))
    store.file(1).unlink()
    with pytest.raises(RequestError, match=r"use --resume.*block 1 is missing"):
        store.carry_out(RunOptions(resume=True), lambda: write_archive)


def test_a_block_is_on_the_disk_before_it_takes_its_name_and_the_name_follows(path, monkeypatch):
    calls, store = [], Blocks(path, make_scan())
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda one: (calls.append("force"), fsync(one)))
    monkeypatch.setattr(os, "replace", lambda *two: (calls.append("rename"), replace(*two)))
    store.save(0, {"a": np.arange(3)})
    assert calls == ["force", "rename", "force"]
    store.save(1, {"a": np.arange(3)})  # within a second: a kill leaves it, too
    assert calls[3:] == ["rename"]
    monkeypatch.setattr(runs_store, "FORCE_EVERY", 0.0)
    store.save(2, {"a": np.arange(3)})
    assert calls[4:] == ["force", "rename", "force"]
    assert sorted(os.listdir(store.folder)) == ["0.npz", "1.npz", "2.npz"]
