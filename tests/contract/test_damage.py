"""Damage: one flipped bit anywhere is found, named and refused."""

import random

import h5py
import pytest
from made_up import cut, flip, make_scan, results, write

from nlds_vines import archive
from nlds_vines.errors import RequestError
from nlds_vines.parts import Parts


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


def test_every_flipped_bit_of_an_archive_is_found_and_refused_in_one_line(path):
    write(path, make_scan())
    sound = path.read_bytes()
    rng = random.Random(1)
    for _ in range(60):
        path.write_bytes(sound)
        flip(path, rng.randrange(len(sound)), rng.randrange(8))
        problems = archive.verify(path)
        assert problems
        assert not any("\n" in problem for problem in problems)
    path.write_bytes(sound)
    assert archive.verify(path) == []


def test_every_flipped_bit_of_a_part_is_found_and_the_part_removed(path):
    scan = make_scan()
    block = cut(scan)[0]
    rng = random.Random(2)
    with Parts.open(path, scan) as parts:
        parts.write(block, results(scan, block))
        assert parts.finished([block]) == {0}
        file = next(parts.folder.glob("block-*"))
        sound = file.read_bytes()
        for _ in range(60):
            file.write_bytes(sound)
            flip(file, rng.randrange(len(sound)), rng.randrange(8))
            assert parts.finished([block]) == set()
            assert not file.exists()
        assert len(parts.discarded) == 60


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


def test_a_cut_file_is_found(path):
    write(path, make_scan())
    path.write_bytes(path.read_bytes()[:-1000])
    assert "seal" in archive.verify(path)[0]
