"""Damage: a flipped byte of a dataset is found, named and refused."""

import h5py
import pytest
from made_up import arrays, fill, finished, flip, make_scan, results, write

from nlds_vines.archives import archive
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.errors import RequestError


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


@pytest.mark.parametrize(
    ("name", "step"), [("section", 7), ("label", 1), ("E1max", 3), ("omega", 3)]
)
def test_each_flipped_byte_of_a_dataset_is_named(path, name, step):
    write(path, make_scan())
    with h5py.File(path) as file:
        dataset = file[name].id
        assert dataset.get_num_chunks() == 1
        chunk = dataset.get_chunk_info(0)
    whole = path.read_bytes()
    for place in range(chunk.byte_offset, chunk.byte_offset + chunk.size, step):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 255]) + whole[place + 1 :])
        with archive.read(path) as view, pytest.raises(RequestError, match=f"dataset {name} is"):
            view[name]


# ---- parts ---------------------------------------------------------------------------------------


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """Return the folder of the parts of a scan, all computed and not yet joined."""
    scan, path = make_scan(), tmp_path / "scan.h5"
    monkeypatch.setattr(cutting, "_block_cells", lambda _: 5)
    with Parts.open(path, scan) as parts:
        fill(parts, scan, blocks_of(scan))
    return parts.folder


def test_a_damaged_part_is_computed_again(path, begun):
    scan, blocks = make_scan(), list(blocks_of(make_scan()))
    flip(begun / "block-000001.part", 900)
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, blocks) == {0, 2}
        assert parts.discarded == ["block-000001.part is computed again: its checksum is wrong"]
        assert not (begun / "block-000001.part").exists()
        parts.write(blocks[1], results(scan, blocks[1]))
        parts.consolidate(blocks)
    assert arrays(path)


def test_parts_of_another_version_of_the_program_are_computed_again(path, begun, monkeypatch):
    blocks = list(blocks_of(make_scan()))
    monkeypatch.setattr("nlds_vines.runs.partfile.makers", lambda: {"source": "nlds_vines 0.0"})
    with Parts.open(path, make_scan(), resume=True) as parts:
        with pytest.raises(RequestError, match="another version"):
            parts.consolidate(blocks)
        assert finished(parts, blocks) == set()
        assert "another version" in parts.discarded[0]
