"""Files that appear whole: the order of the calls; chunks of datasets; what makes a result."""

import os
import stat
from unittest.mock import Mock

import numpy as np
import pytest

from nlds_vines.archives import files, provenance
from nlds_vines.archives.hdf5 import chunk_shape


@pytest.fixture
def path(tmp_path):
    return tmp_path / "file"


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
    with files.whole(path) as temporary:
        temporary.write_bytes(b"a piece, another")
    assert calls == ["force the file", "rename", "force the folder"]
    assert path.read_bytes() == b"a piece, another"
    assert os.listdir(path.parent) == [path.name]


def test_a_write_that_fails_leaves_the_file_and_nothing_else(path, monkeypatch):
    path.write_bytes(b"before")
    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"), files.whole(path) as temporary:
        temporary.write_bytes(b"after")
    assert path.read_bytes() == b"before"
    assert os.listdir(path.parent) == [path.name]


def test_chunks_are_small_and_cover_a_short_array_whole():
    assert chunk_shape((10, 20), 8) == (10, 20)
    for shape in ((1000, 1000), (3, 100000, 4), (1, 1, 10**7)):
        chunk = chunk_shape(shape, 8)
        assert np.prod(chunk) * 8 <= 1 << 18
        assert all(1 <= side <= whole for side, whole in zip(chunk, shape, strict=True))


def test_every_source_and_its_name_count(tmp_path, monkeypatch):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "one.py").write_text("1")
    (inner / "two.py").write_text("2")
    monkeypatch.setattr(provenance, "_PACKAGE", tmp_path)
    hashes = {provenance._source_hash()}
    for change in (
        lambda: (inner / "two.py").write_text("3"),
        lambda: (inner / "two.py").rename(inner / "three.py"),
        lambda: (inner / "three.py").rename(tmp_path / "three.py"),
    ):
        change()
        hashes.add(provenance._source_hash())
    assert len(hashes) == 4


def test_what_may_change_a_bit_is_named():
    makers = provenance.makers()
    assert {"source_hash", "python_version", "machine"} < makers.keys()
    assert {f"{library}_version" for library in provenance.LIBRARIES} < makers.keys()
    assert "unknown" not in makers.values()
