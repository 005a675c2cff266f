"""Files that cannot be read, or not at once: the reason in words, and nothing is lost."""

import errno
import os

import pytest
from made_up import cut, fill, finished, make_scan, results, write

import nlds_vines as nv
from nlds_vines.bifurcation.block_files import Parts


@pytest.fixture
def path(here):
    return write(here / "scan.h5", make_scan())


def test_permission_denied_is_said_as_such(path, monkeypatch, refusal):
    really = os.open

    def refused(place, *arguments, **keywords):
        if str(place) == "scan.h5":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))
        return really(place, *arguments, **keywords)

    monkeypatch.setattr(os, "open", refused)
    for words in (["export"], ["plot", "--show", "?"], ["rerun"]):
        err = refusal(*words, "scan.h5")
        assert err.count("\n") == 1
        assert "Permission denied" in err
        assert "damaged" not in err


# ---- a manifest of which a bit has changed -------------------------------------------------------


@pytest.fixture
def begun(tmp_path):
    """Some blocks of a scan, whose manifest is damaged."""
    scan, path = make_scan(), tmp_path / "begun.h5"
    with Parts.open(path, scan) as parts:
        fill(parts, scan, cut(scan)[:2])
    manifest = path.with_name("begun.h5.parts") / "manifest.json"
    content = bytearray(manifest.read_bytes())
    content[20] ^= 1
    manifest.write_bytes(content)
    return path


def test_sound_blocks_are_kept_without_their_manifest(begun):
    scan = make_scan()
    with pytest.raises(nv.RequestError, match=r"damaged .*--resume .* keeps"):
        Parts.open(begun, scan)
    with Parts.open(begun, scan, resume=True) as parts:
        assert "manifest.json is made again" in parts.discarded[0]
        assert finished(parts, cut(scan)) == {0, 1}
        parts.write(cut(scan)[2], results(scan, cut(scan)[2]))
        parts.consolidate(cut(scan), {})


def test_blocks_of_another_scan_are_not_touched_without_their_manifest(begun):
    folder = begun.with_name("begun.h5.parts")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    with pytest.raises(nv.RequestError, match="damaged"):
        Parts.open(begun, make_scan(P=700.0), resume=True)
    after = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert {name: after[name] for name in before} == before
