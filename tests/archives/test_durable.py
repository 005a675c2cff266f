"""Durable files, one call at a time: order of the calls, checksums, locks."""

import os
import stat

import numpy as np
import pytest

from nlds_vines.archives import dataset as chunk_layout
from nlds_vines.archives import durable, provenance


@pytest.fixture
def path(tmp_path):
    return tmp_path / "file"


# ---- what reaches the disk, and when -------------------------------------------------------------


def test_a_file_is_on_the_disk_before_it_takes_its_name_and_the_name_follows(path, monkeypatch):
    calls, path_before = [], b"of the last run"
    path.write_bytes(path_before)
    fsync, replace = os.fsync, os.replace

    def noted_fsync(descriptor):
        kind = "folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file"
        calls.append(f"force the {kind}")
        if kind == "file":
            assert path.read_bytes() == path_before
            assert os.fstat(descriptor).st_size > 9  # all of it has left the program
        fsync(descriptor)

    def noted_replace(one, other):
        calls.append("rename")
        replace(one, other)

    monkeypatch.setattr(os, "fsync", noted_fsync)
    monkeypatch.setattr(os, "replace", noted_replace)
    durable.write(path, b"a piece, ", b"another")
    assert calls == ["force the file", "rename", "force the folder"]
    assert durable.read(path) == b"a piece, another"
    assert os.listdir(path.parent) == [path.name]


def test_a_write_that_fails_leaves_the_file_and_nothing_else(path, monkeypatch):
    durable.write(path, b"before")

    def refuse(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OSError, match="No space"):
        durable.write(path, b"after")
    assert durable.read(path) == b"before"
    assert os.listdir(path.parent) == [path.name]


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="not on this system")
def test_room_is_asked_for_to_the_last_byte(path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        os, "posix_fallocate", lambda file, first, size: asked.append((first, size))
    )
    durable.reserve(path, 12345)
    assert asked == [(0, 12345)]
    assert not os.listdir(path.parent)


# ---- checksums -----------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [0, 1, 1000])
def test_a_checksum_is_of_all_bytes(path, size):
    durable.write(path, bytes(size))
    whole = path.read_bytes()
    assert durable.read(path) == bytes(size)
    for place in range(len(whole)):
        broken = bytearray(whole)
        broken[place] ^= 1
        path.write_bytes(broken)
        with pytest.raises(ValueError, match="checksum"):
            durable.read(path)
    for left in range(len(whole)):
        path.write_bytes(b"x" * left)
        with pytest.raises(ValueError, match="checksum"):
            durable.read(path)


# ---- locks ---------------------------------------------------------------------------------------


def test_a_lock_is_held_alone_and_a_shared_one_together(path):
    one = durable.lock(path)
    assert durable.held(path)
    assert durable.lock(path, patience=0.0) is None
    assert durable.lock(path, shared=True, patience=0.0) is None
    os.close(one)
    both = [durable.lock(path, shared=True) for _ in range(2)]
    assert None not in both
    assert durable.lock(path, patience=0.0) is None
    for descriptor in both:
        os.close(descriptor)


def test_a_lock_on_a_file_that_was_removed_meanwhile_does_not_count(path, monkeypatch):
    """Its holder removed it between opening and locking: others would lock another file."""
    attempts, try_lock = [], durable._try_lock

    def removed_once(descriptor, kind):
        if not attempts:
            path.unlink()
        attempts.append(descriptor)
        return try_lock(descriptor, kind)

    monkeypatch.setattr(durable, "_try_lock", removed_once)
    descriptor = durable.lock(path)
    assert descriptor is not None
    assert len(attempts) == 2
    assert os.path.samestat(os.fstat(descriptor), path.stat())
    os.close(descriptor)


# ---- chunks --------------------------------------------------------------------------------------


def test_slabs_are_all_of_an_array(monkeypatch):
    monkeypatch.setattr(chunk_layout, "_SLAB_VALUES", 10)
    for shape in ((7,), (25,), (25, 3), (4, 100), (0, 3)):
        rows = [i for slab in chunk_layout.slabs(shape) for i in range(shape[0])[slab]]
        assert rows == list(range(shape[0]))
    assert len(list(chunk_layout.slabs((25, 3)))) == 9


def test_chunks_are_small_and_cover_a_short_array_whole():
    assert chunk_layout.chunk_shape((10, 20), 8) == (10, 20)
    for shape in ((1000, 1000), (3, 100000, 4), (1, 1, 10**7)):
        chunk = chunk_layout.chunk_shape(shape, 8)
        assert np.prod(chunk) * 8 <= 1 << 18
        assert all(1 <= side <= whole for side, whole in zip(chunk, shape, strict=True))


# ---- what made a result --------------------------------------------------------------------------


def test_every_source_and_its_name_count(tmp_path, monkeypatch):
    package = tmp_path / "package"
    (package / "inner").mkdir(parents=True)
    (package / "one.py").write_text("1")
    (package / "inner" / "two.py").write_text("2")
    monkeypatch.setattr(provenance, "_PACKAGE", package)
    hashes = [provenance._source_hash()]
    (package / "inner" / "two.py").write_text("3")
    hashes.append(provenance._source_hash())
    (package / "inner" / "two.py").rename(package / "inner" / "three.py")
    hashes.append(provenance._source_hash())
    (package / "inner" / "three.py").rename(package / "three.py")
    hashes.append(provenance._source_hash())
    assert len(set(hashes)) == 4


def test_what_may_change_a_bit_is_named():
    makers = provenance.makers()
    assert {"source_hash", "python_version", "machine"} < makers.keys()
    assert {f"{library}_version" for library in provenance.LIBRARIES} < makers.keys()
    assert "unknown" not in makers.values()
