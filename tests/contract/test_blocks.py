"""Blocks whole or absent: what exists, what is begun, two runs, killed runs, damage, full disks."""

import errno
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from commands import REPO, printed
from made_up import content, cut, make_scan, results, write

from nlds_vines.archives import archive
from nlds_vines.bifurcation.run import plan_of
from nlds_vines.model.system import Preset
from nlds_vines.runs import store as runs_store
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore
from nlds_vines.scans.run import writer_of
from scans import stored, written


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return what the archive of an undisturbed run holds."""
    return content(write(tmp_path_factory.mktemp("whole") / "scan.h5", make_scan()))


def run(path, scan, act=lambda index: None, **how):
    """Do a run of three blocks, of which `act` is told; return those that were computed."""
    computed = []

    def results_of(block):
        act(block.index)
        computed.append(block.index)
        return results(scan, block)

    written(path, scan, cut(scan), results_of, **how)
    return computed


def begin(path, scan, count=2, **how):
    """Interrupt a run after so many blocks; return what it says."""

    def stop(index):
        if index == count:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as interrupted:
        run(path, scan, stop, **how)
    return str(interrupted.value)


# ---- what exists ---------------------------------------------------------------------------------


def test_overwrite_keeps_the_old_archive_until_the_new_one_is_there(path, error_of):
    old, new = make_scan(), make_scan(P=801.0)
    write(path, old)
    before = path.read_bytes()
    assert "the same call goes on" in begin(path, new, overwrite=True)
    assert path.read_bytes() == before
    assert "another scan" in error_of(run, path, new, resume=True)  # it may not be replaced
    assert run(path, new, overwrite=True) == [2]
    with archive.read(path) as view:
        assert view.attrs["scan_hash"] == new.hash
    assert os.listdir(path.parent) == [path.name]


def test_an_archive_stays_where_it_is_complete_and_is_refused_otherwise(path, error_of):
    write(path, make_scan())
    before = path.read_bytes()
    assert "overwrite=True" in error_of(write, path, make_scan())
    for how in ({"resume": True}, {"shard": Shard(2, 2)}):
        assert "another scan" in error_of(write, path, make_scan(P=801.0), **how)
    BlockStore(path, make_scan()).save(0, {})  # the run was killed before it had removed all blocks
    assert run(path, make_scan(), resume=True) == []
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]
    path.write_bytes(before[:3000])
    line = error_of(write, path, make_scan(), resume=True)
    assert re.search("cannot be opened.*damaged", line)


def test_resume_computes_what_is_missing_and_ends_in_the_same_arrays(path, whole, error_of):
    scan = make_scan()
    assert "0 blocks are kept" in begin(path, scan, 0)
    assert os.listdir(path.parent) == []
    said = begin(path, scan)
    assert "2 blocks are kept" in said
    assert "the same call with resume=True goes on" in said
    assert re.search("unfinished run.*resume=True", error_of(run, path, scan))
    notes = BlockStore(path, scan).folder / "notes.txt"
    notes.write_text("of the user")
    assert run(path, scan, resume=True) == [2]
    assert content(path) == whole
    assert notes.read_text() == "of the user"
    assert os.listdir(notes.parent) == [notes.name]


# ---- whose blocks --------------------------------------------------------------------------------


def test_blocks_of_two_requests_and_of_two_versions_never_mix(path, monkeypatch, capsys):
    scan = make_scan()
    begin(path, scan)
    assert run(path, make_scan(P=801.0)) == [0, 1, 2]
    path.unlink()
    capsys.readouterr()
    before, makers = BlockStore(path, scan).folder, runs_store.makers()
    for name in ("source_hash", "numpy_version", "scipy_version", "machine", "numba_version"):
        monkeypatch.setattr(runs_store, "makers", lambda name=name: {**makers, name: "another"})
        assert BlockStore(path, scan).folder != before
    assert run(path, scan, resume=True) == [0, 1, 2]  # upgraded in mid-run
    path.unlink()
    (err,) = capsys.readouterr().err.splitlines()
    assert err.endswith(".blocks is of another request or version: nothing in it is used")
    monkeypatch.undo()
    assert run(path, scan, resume=True) == [2]


def changed_archive(path, scan, **attributes):
    """Write the archive of a scan with these attributes in place of its own."""
    write(path, scan)
    with h5py.File(path, "r+") as file:
        file.attrs.update(attributes)


def test_a_finished_archive_of_another_version_is_computed_again_and_replaced(path, whole, capsys):
    scan = make_scan()
    for name in ("source_hash", "numba_version", "machine"):
        changed_archive(path, scan, **{name: "another"})
        assert run(path, scan, resume=True) == [0, 1, 2]
        (line,) = capsys.readouterr().err.splitlines()
        assert f"{path} is of another version, and is computed again: {name} another, not " in line
        assert content(path) == whole
        assert run(path, scan, resume=True) == []
        assert capsys.readouterr().err == ""
        path.unlink()
    changed_archive(path, scan, source_hash="another")
    before = path.read_bytes()
    assert "the same call with resume=True goes on" in begin(path, scan, resume=True)
    assert path.read_bytes() == before  # until the new one is there
    assert run(path, scan, shard=Shard(1, 1)) == [2]
    assert content(path) == whole


def test_what_differs_in_the_request_of_an_archive_is_said(path, capsys, error_of):
    scan = make_scan()
    write(path, scan)
    line = error_of(write, path, make_scan(P=801.0), resume=True)
    assert line.endswith("cannot continue it; it has system.parameters.P = 800.0")
    before = path.read_bytes()
    assert run(path, replace(scan, title="another one"), resume=True) == []
    assert capsys.readouterr().err == f"{path} is left as it is; it has title = 'a test'\n"
    assert path.read_bytes() == before


def test_a_key_of_a_system_that_the_hash_does_not_know_is_refused(monkeypatch, error_of):
    scan = make_scan()
    table = Preset.to_table
    monkeypatch.setattr(Preset, "to_table", lambda system: {**table(system), "foot": "moves"})
    assert "unknown key 'foot'" in error_of(lambda: scan.hash)


def wrong_arrays():
    """Return what may stand in place of a block's arrays: functions of them, by what they do."""
    names = [*make_scan().table.datasets]
    numeric = [name for name in names if make_scan().table.datasets[name].dtype == "float64"]
    wrong = {}
    for name in names[:4]:
        wrong[f"{name} is short"] = lambda arrays, name=name: arrays | {name: arrays[name][:-1]}
        wrong[f"{name} is missing"] = lambda arrays, name=name: without(arrays, name)
        wrong[f"{name} has another axis"] = lambda arrays, name=name: (
            arrays | {name: arrays[name][..., np.newaxis]}
        )
    for name in numeric[:4]:
        wrong[f"{name} is float32"] = lambda arrays, name=name: (
            arrays | {name: arrays[name].astype(np.float32)}
        )
        wrong[f"{name} is text"] = lambda arrays, name=name: (
            arrays | {name: arrays[name].astype(str)}
        )
    wrong["there is one more"] = lambda arrays: arrays | {"more": np.zeros(3)}
    wrong["it does not say whose it is"] = lambda arrays: without(arrays, "about")
    wrong["it is empty"] = lambda arrays: {}
    return wrong


def without(arrays, name):
    """Return the arrays of a block without one."""
    return {key: value for key, value in arrays.items() if key != name}


@pytest.mark.parametrize("spoil", wrong_arrays().values(), ids=wrong_arrays())
def test_a_block_of_other_arrays_is_computed_again(path, whole, capsys, spoil):
    scan = make_scan()
    begin(path, scan)
    file = BlockStore(path, scan).file(1)
    with np.load(file) as saved:
        arrays = dict(saved)
    np.savez(file, **spoil(arrays))
    assert run(path, scan, resume=True) == [1, 2]
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{file} is computed again: ")
    assert content(path) == whole


@pytest.mark.parametrize("other_run", [False, True])
def test_a_valid_block_of_another_place_or_run_is_computed_again(path, whole, capsys, other_run):
    scan = make_scan()
    source = BlockStore(path, scan).file(0)
    if other_run:
        other = make_scan(P=801.0)
        begin(path.with_name("b.h5"), other)
        source = BlockStore(path.with_name("b.h5"), other).file(1)
    begin(path, scan)
    shutil.copy(source, BlockStore(path, scan).file(1))
    assert run(path, scan, resume=True) == [1, 2]
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(r"1\.npz is computed again: it is block \d of the run ", line)
    assert content(path) == whole


def test_a_block_that_says_what_it_holds_must_hold_what_the_run_saves(path, whole, capsys):
    """Somebody else's program might have written it."""
    scan = make_scan()
    begin(path, scan)
    store = BlockStore(path, scan)
    short = {name: values[:-1] for name, values in store.load(1).items()}
    store.save(1, short)
    assert run(path, scan, resume=True) == [1, 2]
    assert "1.npz is computed again: " in capsys.readouterr().err
    assert content(path) == whole


def test_only_blocks_of_the_run_are_removed_and_no_link_is_followed(path, tmp_path, error_of):
    scan, store = make_scan(), BlockStore(path, make_scan())
    precious = tmp_path / "precious"
    precious.mkdir()
    for name in ("0.npz", "data.npz", "0123456789abcdef.tmp"):
        (precious / name).write_text("of the user")
    begin(path, scan)
    foreign = ["data.npz", "notes.tmp", "5.npz"]
    for name in foreign:
        (store.folder / name).write_text("of the user")
    (store.folder / "link.npz").symlink_to(precious / "data.npz")
    (store.folder / "0123456789abcdee.tmp").write_text("left by a killed run")
    assert run(path, scan, resume=True) == [2]
    assert sorted(os.listdir(store.folder)) == sorted([*foreign, "link.npz"])
    shutil.rmtree(store.folder)
    path.unlink()
    store.folder.symlink_to(precious)
    assert "is a symbolic link" in error_of(run, path, scan, resume=True)
    assert {one.read_text() for one in precious.iterdir()} == {"of the user"}


def test_a_block_of_which_a_byte_is_flipped_or_cut_is_computed_again(path, capsys):
    store = BlockStore(path, make_scan())
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
    for one in read:  # some bytes mean nothing, as a member's date
        np.testing.assert_equal(one, saved, strict=True)
    assert len(read) < 0.3 * len(whole)


def test_damaged_blocks_are_computed_again_with_a_line_each(path, whole, capsys):
    scan = make_scan()
    begin(path, scan)
    cut_off, flipped, pipe = map(BlockStore(path, scan).file, range(3))
    cut_off.write_bytes(cut_off.read_bytes()[:-100])
    data = bytearray(flipped.read_bytes())
    data[data.index(b"NUMPY") + 130] ^= 1
    flipped.write_bytes(data)
    os.mkfifo(pipe)
    assert run(path, scan, resume=True) == [0, 1, 2]
    lines = capsys.readouterr().err.splitlines()
    for file, line in zip((cut_off, flipped, pipe), lines, strict=True):
        assert line.startswith(f"{file} is computed again: ")
    assert "it is no regular file" in line
    assert content(path) == whole


# ---- several at once -----------------------------------------------------------------------------


@pytest.mark.parametrize("when", [0, 2])
def test_of_two_runs_on_one_output_both_end_well(path, when, whole):
    scan = make_scan()

    def other(index):
        if index == when:
            write(path, scan, resume=True)

    for how in ({}, {"overwrite": True}):
        run(path, scan, other, **how)
        assert content(path) == whole
        assert os.listdir(path.parent) == [path.name]
    run(path, scan, lambda index: path.write_bytes(b"of another program"), overwrite=True)
    assert content(path) == whole


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


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("kind", ["file", "link", "folder"])
def test_what_comes_into_being_meanwhile_is_kept(path, whole, monkeypatch, error_of, links, kind):
    if not links:  # FAT and some network file systems have no hard links

        def refuse(*_, **__):
            raise OSError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os, "link", refuse)

    def meanwhile(index):
        if index == 2:
            if kind == "file":
                path.write_bytes(b"precious")
            elif kind == "link":
                path.symlink_to("nowhere")
            else:
                path.mkdir()

    line = error_of(run, path, make_scan(), meanwhile)
    assert re.search(r"meanwhile.*scan\.h5\..*\.blocks.*resume=True", line)
    if kind == "file":
        assert path.read_bytes() == b"precious"
    assert path.is_symlink() == (kind == "link")
    assert not (path.parent / "nowhere").exists()
    path.rename(path.with_name("moved"))
    assert run(path, make_scan(), resume=True) == []
    assert content(path) == whole
    assert sorted(os.listdir(path.parent)) == ["moved", "scan.h5"]


# ---- the end of a run ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("moment", "before"),
    [("write", False), ("publish", False), ("write", True), ("replace_target", True)],
)
def test_an_interrupted_delivery_leaves_what_was_there(path, whole, monkeypatch, moment, before):
    if before:
        write(path, make_scan(P=801.0))
    was = path.read_bytes() if before else None

    def die(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(archive if moment == "write" else runs_store, moment, die)
        with pytest.raises(Interrupted):
            write(path, make_scan(), overwrite=before)
    assert (path.read_bytes() if path.exists() else None) == was
    assert run(path, make_scan(), overwrite=before, resume=not before) == []
    assert content(path) == whole
    assert os.listdir(path.parent) == [path.name]


@pytest.mark.parametrize("apart", [False, True])
def test_overwriting_a_link_replaces_what_it_points_to(path, whole, monkeypatch, apart):
    target = path.parent / "deep" / "target.h5"
    target.parent.mkdir()
    target.write_bytes(b"old")
    path.symlink_to("deep/target.h5")
    if apart:  # the target lies on another file system
        rename = os.replace

        def across(one, other):
            if os.path.dirname(one) != os.path.dirname(other):
                raise OSError(errno.EXDEV, "Invalid cross-device link")
            rename(one, other)

        monkeypatch.setattr(os, "replace", across)
    write(path, make_scan(), overwrite=True)
    assert path.is_symlink()
    assert not target.is_symlink()
    assert content(target) == whole
    assert os.listdir(target.parent) == ["target.h5"]
    assert sorted(os.listdir(path.parent)) == ["deep", "scan.h5"]


FULL = """
import resource, signal, sys
from nlds_vines.errors import RequestError
from test_blocks import *
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
scan, path = make_scan(), Path(sys.argv[1])
begin(path, scan)
size = max(file.stat().st_size for file in BlockStore(path, scan).folder.iterdir())
for limit in (100, size + 9):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        run(path, scan, resume=True)
    except RequestError as error:
        print(error, flush=True)
"""


def test_a_full_disk_is_one_line_and_the_blocks_are_intact(path, whole):
    """A limit on the size of files stands in for the disk: writing fails half-way."""
    places = map(str, (REPO, REPO / "tests", Path(__file__).parent))
    output = printed("-c", FULL, path, PYTHONPATH=os.pathsep.join(places))
    block, archived = output.splitlines()
    assert block.startswith("cannot write a block in ")
    assert archived.startswith(f"cannot write {path} (the blocks are intact, use resume=True): ")
    assert not path.exists()
    assert run(path, make_scan(), resume=True) == []
    assert content(path) == whole


def test_a_block_that_cannot_be_written_is_one_line(path, monkeypatch, error_of):
    scan = make_scan()
    line = error_of(write, path.parent / "nowhere" / "scan.h5", scan)
    assert re.search("cannot write a block in .*No such file", line)
    # a folder in its place is named and kept
    precious = BlockStore(path, scan).file(0) / "precious"
    precious.mkdir(parents=True)
    line = error_of(write, path, scan, resume=True)
    assert re.search("cannot write a block in .*directory", line)
    assert precious.is_dir()
    shutil.rmtree(BlockStore(path, scan).folder)

    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "mkdir", refuse)
    assert re.search("cannot write a block in .*Read-only", error_of(write, path, scan))
    assert os.listdir(path.parent) == []


def test_blocks_that_vanish_are_said(path, error_of):
    scan, store = make_scan(), BlockStore(path, make_scan())
    for block in cut(scan):
        store.save(block.index, stored(scan, results(scan, block)))
    write_archive = writer_of(replace(plan_of(scan), blocks=cut(scan)), store)
    store.file(1).unlink()
    line = error_of(store.carry_out, RunOptions(resume=True), lambda: write_archive)
    assert re.search("use resume=True.*block 1 is missing", line)


def test_a_block_is_on_the_disk_before_it_takes_its_name_and_the_name_follows(path, monkeypatch):
    calls, store = [], BlockStore(path, make_scan())
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
