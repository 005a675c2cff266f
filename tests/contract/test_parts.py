"""Archives whole or absent: what exists, what is begun, two runs, killed runs, full disks."""

import os
import signal
import subprocess

import pytest
from made_up import arrays, cut, fill, finished, make_scan, results, run_python, same, write

from nlds_vines.archives import archive, durable
from nlds_vines.bifurcation.block_files import Block, Parts
from nlds_vines.errors import RequestError


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


def test_an_existing_archive_is_refused_and_untouched(path):
    write(path, make_scan())
    before = path.read_bytes()
    with pytest.raises(RequestError, match="--overwrite"):
        Parts.open(path, make_scan())
    with pytest.raises(RequestError, match="another scan"):
        Parts.open(path, make_scan(P=801.0), resume=True)
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_overwrite_keeps_the_old_archive_until_the_new_one_is_there(path):
    old, new = make_scan(), make_scan(P=801.0)
    write(path, old)
    before = path.read_bytes()
    with Parts.open(path, new, overwrite=True) as parts:
        parts.write(cut(new)[0], results(new, cut(new)[0]))
    assert path.read_bytes() == before
    with Parts.open(path, new, resume=True) as parts:  # the interrupted run may go on replacing
        assert finished(parts, cut(new)) == {0}
        fill(parts, new, cut(new)[1:])
        parts.consolidate(cut(new), {})
    with archive.read(path) as view:
        assert view.attrs["scan_hash"] == new.hash


def test_resume_of_a_complete_archive_has_nothing_to_do(path):
    write(path, make_scan())
    before = path.read_bytes()
    with Parts.open(path, make_scan(), resume=True) as parts:
        assert parts.complete
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_resume_of_a_damaged_archive_is_refused(path):
    write(path, make_scan())
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(RequestError, match=r"cannot be opened.*damaged"):
        Parts.open(path, make_scan(), resume=True)


def test_resume_takes_verified_parts_and_ends_in_the_same_arrays(tmp_path, path):
    scan = make_scan()
    blocks = cut(scan)
    with Parts.open(path, scan) as parts:
        parts.write(blocks[0], results(scan, blocks[0]))
        parts.write(blocks[2], results(scan, blocks[2]))
    with pytest.raises(RequestError, match=r"unfinished run.*--resume.*--overwrite"):
        Parts.open(path, scan)
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, blocks) == {0, 2}
        with pytest.raises(RequestError, match="1 block"):
            parts.consolidate(blocks, {})
        parts.write(blocks[1], results(scan, blocks[1]))
        parts.consolidate(blocks, {})
    assert same(arrays(path), arrays(write(tmp_path / "straight.h5", scan)))
    assert sorted(os.listdir(tmp_path)) == ["scan.h5", "straight.h5"]


def test_parts_cut_otherwise_are_not_taken(path):
    scan = make_scan()
    with Parts.open(path, scan) as parts:
        fill(parts, scan, cut(scan, 5))
        assert finished(parts, cut(scan, 4)) == set()
        assert len(parts.discarded) == 3


def test_a_part_of_other_cells_in_the_same_shape_is_not_taken(path):
    scan = make_scan()
    one, other = Block(0, ((0, 5),)), Block(0, ((5, 10),))
    with Parts.open(path, scan) as parts:
        parts.write(one, results(scan, one))
        assert finished(parts, [one]) == {0}
        assert finished(parts, [other]) == set()
        assert "another block" in parts.discarded[0]


def test_parts_of_another_scan_are_refused_by_name_until_overwritten(path):
    scan, other = make_scan(), make_scan(P=801.0)
    with Parts.open(path, scan) as parts:
        parts.write(cut(scan)[0], results(scan, cut(scan)[0]))
    with pytest.raises(RequestError, match=r"another scan.*a test"):
        Parts.open(path, other, resume=True)
    with Parts.open(path, other, overwrite=True) as parts:
        assert finished(parts, cut(other)) == set()
        assert not parts.discarded


def test_a_part_smuggled_in_from_another_scan_is_found(path):
    scan, other = make_scan(), make_scan(P=801.0)
    with Parts.open(path.with_name("other.h5"), other) as parts:
        parts.write(cut(other)[0], results(other, cut(other)[0]))
        stolen = next(parts.folder.glob("block-*")).read_bytes()
    with Parts.open(path, scan) as parts:
        (parts.folder / "block-000000.part").write_bytes(stolen)
        assert finished(parts, cut(scan)) == set()
        assert "another request" in parts.discarded[0]


def test_a_folder_in_which_nothing_was_begun_is_no_hindrance(path):
    parts = Parts.open(path, make_scan())
    (parts.folder / "manifest.json").unlink()  # killed before it said whose parts these are
    parts.close()
    assert not parts.folder.exists()
    parts.folder.mkdir()
    (parts.folder / "notes.txt").write_text("of the user")
    with Parts.open(path, make_scan()) as parts:
        pass
    write(path, make_scan(), resume=True)
    assert (parts.folder / "notes.txt").exists()


def test_results_of_another_shape_are_a_mistake_of_the_caller(path):
    scan = make_scan()
    block = cut(scan)[0]
    found = results(scan, block)
    with Parts.open(path, scan) as parts:
        with pytest.raises(ValueError, match="shape"):
            parts.write(block, found | {"status": found["status"][1:]})
        with pytest.raises(ValueError, match="holds"):
            parts.write(block, {"status": found["status"]})
        assert finished(parts, [block]) == set()


HOLD = """
import sys
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.request import load_scan
scan = load_scan(sys.stdin.readline().strip())
parts = Parts.open({path!r}, scan)
print("held", flush=True)
sys.stdin.readline()
"""


def test_a_second_run_is_refused_and_a_dead_ones_lock_is_gone(path):
    scan = make_scan()
    file = path.with_name("scan.toml")
    file.write_text(scan.to_toml())
    other = run_python(HOLD.format(path=str(path)), stdin=subprocess.PIPE)
    try:
        other.stdin.write(f"{file}\n")
        other.stdin.flush()
        assert other.stdout.readline() == "held\n", other.stderr.read()
        for how in ({}, {"resume": True}, {"overwrite": True}):
            with pytest.raises(RequestError, match="another run"):
                Parts.open(path, scan, **how)
    finally:
        other.send_signal(signal.SIGKILL)
        other.communicate()
    write(path, scan, resume=True)


@pytest.mark.parametrize("moment", ["archive.write", "durable.replace"])
@pytest.mark.parametrize("before", [False, True])
def test_an_interrupted_consolidation_leaves_what_was_there(path, monkeypatch, moment, before):
    scan, old = make_scan(), make_scan(P=801.0)
    if before:
        write(path, old)
    was = path.read_bytes() if before else None
    blocks = cut(scan)
    with Parts.open(path, scan, overwrite=True) as parts:
        fill(parts, scan, blocks)

        def die(*_):
            raise KeyboardInterrupt

        module, name = moment.split(".")
        with monkeypatch.context() as patch:
            patch.setattr({"archive": archive, "durable": durable}[module], name, die)
            with pytest.raises(KeyboardInterrupt):
                parts.consolidate(blocks, {})
    assert (path.read_bytes() if path.exists() else None) == was
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, blocks) == {0, 1, 2}
        parts.consolidate(blocks, {})
    assert arrays(path)


def test_a_run_killed_after_the_archive_took_its_name_leaves_a_complete_one(path, monkeypatch):
    scan = make_scan()
    blocks = cut(scan)
    with Parts.open(path, scan) as parts:
        fill(parts, scan, blocks)
        monkeypatch.setattr(Parts, "_remove", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            parts.consolidate(blocks, {})
        monkeypatch.undo()
    assert parts.folder.exists()
    with Parts.open(path, scan, resume=True) as parts:
        assert parts.complete
    assert not parts.folder.exists()


FULL = """
import resource, signal, sys
sys.path.insert(0, {tests!r})
from made_up import *
from nlds_vines.errors import RequestError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
scan = make_scan()
blocks = cut(scan)
with Parts.open({path!r}, scan) as parts:
    fill(parts, scan, blocks)
    size = max(file.stat().st_size for file in parts.folder.iterdir())
    for limit, act in (
        (size + 9, lambda: parts.consolidate(blocks, dict())),
        (100, lambda: parts.write(blocks[0], results(scan, blocks[0]))),
    ):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        try:
            act()
        except RequestError as error:
            assert str(error).startswith("cannot write"), error
            assert "\\n" not in str(error)
            print("one line", flush=True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
"""


def test_a_full_disk_is_one_line_and_the_parts_are_intact(path):
    """A limit on the size of files stands in for the disk: writing fails half-way."""
    tests = os.path.dirname(__file__)
    run = run_python(FULL.format(path=str(path), tests=tests))
    output, errors = run.communicate()
    assert (output, errors) == ("one line\none line\n", "")
    assert not path.exists()
    scan = make_scan()
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, cut(scan)) == {0, 1, 2}
        parts.consolidate(cut(scan), {})
    assert arrays(path)


def test_a_vanished_or_missing_folder_is_one_line(path):
    scan = make_scan()
    with pytest.raises(RequestError, match="cannot write"):
        Parts.open(path.parent / "nowhere" / "scan.h5", scan)
    parts = Parts.open(path, scan)
    for file in parts.folder.iterdir():
        file.unlink()
    parts.folder.rmdir()
    with pytest.raises(RequestError, match="No such file"):
        parts.write(cut(scan)[0], results(scan, cut(scan)[0]))
    parts.close()
