"""What a file must be before it is read as an archive, each bound from both sides; checksums."""

from struct import pack

import numpy as np
import pytest

from nlds_vines.archives import dataset as chunk_layout
from nlds_vines.archives import view
from nlds_vines.archives.dataset import crc32_of
from nlds_vines.archives.structure_check import Member, heaps_are_whole, problems_of

# ---- datasets and their scales -------------------------------------------------------------------


def scale(values, **changed):
    values = np.asarray(values, float)
    own = {"shape": values.shape, "bytes": values.nbytes, "stored": values.nbytes}
    return Member(numbers=True, is_scale=True, values=lambda: values, **(own | changed))


def dataset(shape, scales, **changed):
    size = 8 * int(np.prod(shape))
    own = {"shape": shape, "scales": scales, "bytes": size, "stored": size}
    return Member(numbers=True, **(own | changed))


def words(**members):
    return list(problems_of(members))


X = scale([1.0, 2.0, 3.0])


def test_an_archive_has_nothing_to_complain_of():
    assert words(x=X, y=dataset((3,), (("x",),)), z=dataset((3, 3), (("x",), ("x",)))) == []


@pytest.mark.parametrize(("more", "count"), [(0, 0), (1, 1)])
def test_a_byte_of_a_file_stands_for_1100_values_at_most(more, count):
    found = words(x=scale([1.0], bytes=11_000 + more, stored=10))
    assert len(found) == count
    assert all("has more values, of 11001 bytes, than are in the file" in line for line in found)


@pytest.mark.parametrize(
    "values", [[1.0, 1.0], [2.0, 1.0], [1.0, np.nan], [1.0, np.inf], [-np.inf, 0.0]]
)
def test_scales_are_finite_and_rise(values):
    assert words(x=scale(values)) == ["scale 'x' is not finite, or does not rise"]
    assert words(x=scale([1.0, np.nextafter(1.0, 2.0)])) == []


def test_a_scale_has_one_dimension():
    assert words(x=scale([[1.0], [2.0]])) == ["scale 'x' has 2 dimensions, not one"]
    assert words(x=scale(1.0)) == ["dataset 'x' has no dimensions"]


@pytest.mark.parametrize("length", [2, 4])
def test_a_dataset_is_as_long_as_its_scales(length):
    expected = f"dataset 'y' has {length} values along 'x', which has others"
    assert words(x=X, y=dataset((length,), (("x",),))) == [expected]


@pytest.mark.parametrize("scales", [(), ("elsewhere",), ("x", "x")])
def test_each_dimension_has_one_scale_of_its_own_file(scales):
    expected = "dataset 'y' has no scale of its own along dimension 0"
    assert words(x=X, y=dataset((3,), (scales,))) == [expected]


# ---- heaps of strings ----------------------------------------------------------------------------


def heap(*entries, free=None, length=None):
    """Return a heap of entries of so many bytes each, with the free rest told as `free`."""
    body = b""
    for number, size in enumerate(entries, 1):
        body += pack("<HHIQ", number, 1, 0, size) + bytes(-(-size // 8) * 8)
    if free is not None:
        body += pack("<HHIQ", 0, 0, 0, free) + bytes(max(0, min(free, 64) - 16))
    return b"GCOL\x01\x00\x00\x00" + pack("<Q", length or 16 + len(body)) + body


WHOLE = [heap(5, 8), heap(5, free=16), heap(free=40), heap(1, 1, 1), heap()]
DAMAGED = [
    heap(5, free=15),  # less than the entry itself
    heap(5, free=17, length=16 + 24 + 16),  # one byte beyond the end
    heap(5, 8, length=15),
    heap(5, 8)[:-1],  # the file ends before the heap
    heap(5, 8, length=16 + 24 + 16),  # the last string ends behind the heap
    b"GCOL\x01\x00\x00\x00" + bytes(7),
    heap(5, 8) + heap(5, free=15),
]


@pytest.mark.parametrize("data", WHOLE)
def test_a_heap_whose_entries_fill_it_is_whole(data, tmp_path):
    path = tmp_path / "heap"
    for before, after in ((b"", b""), (b"before" * 9, b"after" * 9)):
        path.write_bytes(before + data + after)
        assert heaps_are_whole(path)


@pytest.mark.parametrize("data", DAMAGED)
def test_a_heap_whose_entries_do_not_end_with_it_is_damaged(data, tmp_path):
    path = tmp_path / "heap"
    path.write_bytes(b"before" * 9 + data)
    assert not heaps_are_whole(path)


# ---- checksums of strings ------------------------------------------------------------------------


class Strings:
    """A dataset of strings, as HDF5 shows it."""

    def __init__(self, *values):
        self.values = np.array(values, dtype=object)
        self.shape, self.dtype = self.values.shape, self.values.dtype
        self.attrs = {}


def test_a_checksum_is_of_all_slabs_in_their_order(monkeypatch):
    monkeypatch.setattr(view, "values_of", lambda dataset, slab: dataset.values[slab])
    monkeypatch.setattr(chunk_layout, "_SLAB_VALUES", 2)
    found = Strings("T,1", "chaos", "2T,2", "T,0", "T,1")
    assert view.whole_crc(found) == crc32_of(found.values)
    assert view.whole_crc(Strings("2T,2", "T,0", "T,1", "chaos", "T,1")) != view.whole_crc(found)


@pytest.mark.parametrize("at", range(3))
def test_one_changed_string_is_noticed(at, monkeypatch):
    monkeypatch.setattr(view, "values_of", lambda dataset, slab: dataset.values[slab])
    found = Strings("T,1", "chaos", "T,0")
    found.attrs["crc32"] = np.uint32(view.whole_crc(found))
    view.check_crc(found)
    found.values[at] = "2T,2"
    with pytest.raises(ValueError, match="checksum"):
        view.check_crc(found)
    found.attrs.clear()
    with pytest.raises(ValueError, match="checksum"):
        view.check_crc(found)
