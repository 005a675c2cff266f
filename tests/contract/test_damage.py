"""Damage: a flipped byte of a dataset is found, named and refused."""

import h5py
import pytest
from made_up import make_scan, write

from nlds_vines.archives import archive
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
