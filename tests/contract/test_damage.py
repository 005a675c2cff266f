"""Damage: one flipped bit anywhere is found, named and refused."""

import random

import h5py
import pytest
from made_up import fill, finished, flip, make_scan, results, write

from nlds_vines.__main__ import main
from nlds_vines.archives import archive
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.errors import RequestError


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


@pytest.mark.parametrize("name", ["section", "label", "E1max", "omega"])
def test_damage_is_named_by_dataset(path, name):
    scan = make_scan()
    write(path, scan)
    if name == "label":  # its bytes lie in a heap of the file, beyond the reach of any filter
        place = path.read_bytes().index("πéà".encode())
    else:
        with h5py.File(path) as file:
            place = file[name].id.get_chunk_info(0).byte_offset + 5
    flip(path, place)
    problems = archive.verify(path)
    assert "seal" in problems[0]
    assert [problem.split(" is damaged")[0] for problem in problems[1:]] == [f"dataset {name}"]
    with archive.read(path) as view, pytest.raises(RequestError, match=f"dataset {name}"):
        view[name]


def test_a_changed_attribute_breaks_the_seal(path):
    write(path, make_scan())
    with h5py.File(path, "r+") as file:
        file.attrs["k2"] = 1.0
    assert archive.verify(path) == ["the seal is broken: the file is not as it was written"]


# ---- the command ---------------------------------------------------------------------------------


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """Return the folder of the parts of a scan, all computed and not yet joined."""
    scan, path = make_scan(), tmp_path / "scan.h5"
    monkeypatch.setattr(cutting, "_block_cells", lambda _: 5)
    with Parts.open(path, scan) as parts:
        fill(parts, scan, blocks_of(scan))
    return parts.folder


@pytest.mark.slow("three hundred archives are verified")
def test_three_hundred_flipped_bits_are_all_found_and_told(path, begun, capsys, answer):
    """Anywhere in an archive, in parts, in the manifest."""
    rng = random.Random(3)
    archive_path = write(path.with_name("whole.h5"), make_scan())
    parts = [*sorted(begun.glob("block-*")), begun / "manifest.json"]
    assert answer("verify", archive_path, begun) == f"{archive_path}: sound\n{begun}: sound\n"
    for i in range(300):
        file = archive_path if i % 2 else parts[i // 2 % len(parts)]
        sound = file.read_bytes()
        flip(file, rng.randrange(len(sound)), rng.randrange(8))
        assert main(["verify", str(archive_path if i % 2 else begun)]) == 1, (file, i)
        out, err = capsys.readouterr()
        assert err == ""
        assert i % 2 or file.name in out
        file.write_bytes(sound)
    assert answer("verify", "--quiet", archive_path, begun) == ""


def test_parts_without_their_manifest_or_in_excess_are_told(begun, answer):
    (begun / "block-000099.part").write_bytes(b"")
    assert "block-000099.part belongs to no block of this scan" in answer("verify", begun, status=1)
    (begun / "manifest.json").unlink()
    assert "manifest.json is missing" in answer("verify", begun, status=1)


def test_a_damaged_part_is_computed_again(path, begun):
    scan, blocks = make_scan(), list(blocks_of(make_scan()))
    flip(begun / "block-000001.part", 900)
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, blocks) == {0, 2}
        assert parts.discarded == ["block-000001.part is computed again: its seal is broken"]
        assert not (begun / "block-000001.part").exists()
        parts.write(blocks[1], results(scan, blocks[1]))
        parts.consolidate(blocks)
    assert archive.verify(path) == []


def test_parts_of_another_version_of_the_program_are_computed_again(path, begun, monkeypatch):
    blocks = list(blocks_of(make_scan()))
    monkeypatch.setattr("nlds_vines.runs.partfile.makers", lambda: {"source": "nlds_vines 0.0"})
    with Parts.open(path, make_scan(), resume=True) as parts:
        with pytest.raises(RequestError, match="another version"):
            parts.consolidate(blocks)
        assert finished(parts, blocks) == set()
        assert "another version" in parts.discarded[0]


@pytest.mark.parametrize("size", [0, 1 << 63, (1 << 64) - 1])
@pytest.mark.parametrize("number", [0, 1])
def test_a_heap_in_which_hdf5_would_run_in_a_circle_is_told(path, number, size, ask):
    """HDF5 does not come back from the first of these, which a flipped bit is enough for."""
    whole = write(path.with_name("whole.h5"), make_scan())
    data = bytearray(whole.read_bytes())
    entry = data.index(b"GCOL") + 16
    data[entry : entry + 2] = number.to_bytes(2, "little")
    data[entry + 8 : entry + 16] = size.to_bytes(8, "little")
    whole.write_bytes(data)
    if size == 0 and number == 1:  # an entry of no bytes: the ones after it are out of place
        assert main(["verify", str(whole)]) == 1
        return
    with pytest.raises(RequestError, match=r"whole\.h5 cannot be opened: .*damaged"):
        archive.read(whole)
    assert "cannot be opened" in "".join(ask("verify", whole, status=1))
