"""The HDF5 archive of a scan: written once and whole, read by name, verified end to end.

The only module that imports h5py.  The layout is that of netCDF-4: every dimension of every dataset
has its scale attached, so that `xarray.open_dataset(FILE, engine="h5netcdf")` opens it.  Numbers
carry HDF5's Fletcher checksum, strings (whose bytes HDF5 keeps out of any filter's reach) a CRC-32
attribute: both name the dataset that is damaged.  A seal over the whole file finds the rest.
"""

from __future__ import annotations

import math
import os
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from nlds_vines.archives import durable
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.errors import RequestError

if TYPE_CHECKING:
    pass

Piece = tuple[str, tuple[slice, ...], np.ndarray]
"""A dataset's name, a rectangle of cells, and the values there."""

_HDF5 = {"hdf5_version": h5py.version.hdf5_version}
_STRING = h5py.string_dtype()  # variable-length UTF-8
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused
_CHUNK_BYTES = 1 << 18  # small enough to read a few cells, large enough to compress and to seek
# rectangles need not end where chunks do: half-written chunks wait in this cache
_CACHE = {"rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}
_SLAB_ITEMS = 1 << 22  # values read at a time when everything is read
_DAMAGE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)  # says h5py


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path`, sealed and forced to the disk, and check it.

    Arguments: the `table` of its datasets; the `scales` of all dimensions that these have;
    `pieces` yields the results, and cells without a piece keep their fill value; `attributes`
    returns those of the file, and is called when the last piece has been taken.

    Memory is that of one piece.  Raises `RequestError` if what is read back is not what was given,
    OSError or (from HDF5) RuntimeError if it cannot be written.
    """
    durable.reserve(path, table.most_bytes + _OVERHEAD)
    # v110 checksums the metadata too, and is read by every netCDF-4 library of this decade
    with h5py.File(path, "w", libver=("v110", "v110"), **_CACHE) as file:
        _create(file, table, scales)
        given = []
        for name, where, values in pieces:
            file[name][where] = _storable(values)
            given.append((name, where, _crc(values)))
        file.attrs.update({**_HDF5, **attributes()})
        _note_checksums(file)
    durable.seal(path)
    _compare(path, given)


def whole(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield the pieces of an archive whose datasets are there as whole arrays."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored


def _note_checksums(file: h5py.File) -> None:
    """Give every dataset of strings its CRC-32: no filter of HDF5 reaches their bytes."""
    for dataset in filter(_is_text, file.values()):
        dataset.attrs["crc32"] = np.uint32(_whole_crc(dataset))


@dataclass(frozen=True)
class ArchiveView:
    """An open archive: its datasets by name, read from the disk when asked for.

    `view["section"]` is the whole array, `view.take("section", start=0, component=2)` a part of
    it.  A dataset that cannot be read as it was written raises `RequestError` with its name.
    """

    path: Path
    _file: h5py.File

    @property
    def attrs(self) -> dict[str, Any]:
        """The attributes of the file: title, history, scan, parameters, assumptions, versions."""
        with _reading(self.path, "an attribute"):
            return {name: _plain(value) for name, value in self._file.attrs.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """The recorded datasets, without the scales of their dimensions."""
        with _reading(self.path, "the list of its datasets"):
            return tuple(name for name in self._file if not self._file[name].is_scale)

    @property
    def axes(self) -> tuple[str, ...]:
        """The varied parameters, in the order of the dimensions."""
        return self.dims("status")[:-1]

    def __contains__(self, name: str) -> bool:
        """Tell whether a dataset (or a scale) of this name is in the archive."""
        return name in self._file

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a whole dataset or scale; strings as an array of `str` objects."""
        return self.take(name)

    def take(self, name: str, **index: int) -> np.ndarray:
        """Return a dataset at the given index of some of its dimensions, whole along the others."""
        if name not in self._file:
            raise RequestError(f"{self.path} holds no {name}, only {', '.join(self.names)}")
        where = tuple(index.get(dim, slice(None)) for dim in self.dims(name))
        with _reading(self.path, f"dataset {name}"):
            dataset = self._file[name]
            _check_crc(dataset)
            return _values(dataset, where)

    def slabs(self, name: str) -> Iterator[np.ndarray]:
        """Yield a dataset in slices along its first dimension that fit into memory."""
        with _reading(self.path, f"dataset {name}"):
            for slab in _slabs(self._file[name]):
                yield _values(self._file[name], slab)

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the lengths of a dataset's dimensions."""
        with _reading(self.path, f"dataset {name}"):
            return tuple(self._file[name].shape)

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of a dataset's dimensions."""
        with _reading(self.path, f"dataset {name}"):
            dataset = self._file[name]
            if dataset.is_scale:
                return (name,)
            return tuple(dim[0].name.removeprefix("/") for dim in dataset.dims)

    def units(self, name: str) -> str:
        """Return the units of a dataset or scale."""
        return str(self._attribute(name, "units"))

    def long_name(self, name: str) -> str:
        """Return what a dataset or scale means, in words."""
        return str(self._attribute(name, "long_name"))

    def flags(self, name: str) -> dict[int, str]:
        """Return the words of an enumeration by their codes."""
        codes = (int(code) for code in self._attribute(name, "flag_values"))
        words = self._attribute(name, "flag_meanings").split(" ")
        return dict(zip(codes, words, strict=True))

    def _attribute(self, name: str, attribute: str) -> Any:
        with _reading(self.path, f"dataset {name}"):
            return self._file[name].attrs[attribute]


@contextmanager
def read(path: str | os.PathLike[str]) -> Iterator[ArchiveView]:
    """Open an archive for reading; use it in a `with` statement.

    Raises `RequestError` if there is no such file, if it is not an archive of this program, or if
    its schema is newer than this version knows.
    """
    path = Path(path)
    try:
        file = h5py.File(path, "r")
    except FileNotFoundError as error:
        raise RequestError(f"{path}: there is no such file") from error
    except OSError as error:
        text = "it is no HDF5 file, damaged, or not readable"
        raise RequestError(f"{path} cannot be opened: {text}") from error
    with file:
        schema = _schema(file)
        if schema is None:
            raise RequestError(f"{path} is not an archive of nlds_vines")
        if schema > SCHEMA:
            raise RequestError(f"{path} has schema {schema}: this version reads up to {SCHEMA}")
        yield ArchiveView(path, file)


def verify(path: str | os.PathLike[str]) -> list[str]:
    """Read an archive from end to end and return its problems, one line each; empty if sound.

    A damaged dataset is named.  Damage anywhere else, be it one bit of a header, of an attribute
    or of padding, breaks the seal.  Raises `RequestError` if there is no such file.
    """
    path = Path(path)
    with durable.in_one_line(f"read {path}"):
        sealed = durable.sealed(path)
    problems = [] if sealed else ["the seal is broken: the file is not as it was written"]
    try:
        with read(path) as view:
            problems += [line for name in view._file for line in _problems(view._file, name)]
    except _DAMAGE as error:
        problems.append(_first_line(error))
    return problems


def _schema(file: h5py.File) -> int | None:
    """Return the number of the archive's layout; None if the file is no archive."""
    try:
        known = "scan_hash" in file.attrs and "status" in file
        return int(file.attrs["schema"]) if known else None
    except _DAMAGE:
        return None


def _create(file: h5py.File, table: Table, scales: Iterable[Scale]) -> None:
    """Create the datasets of a table, empty, and the scales of those dimensions that they have."""
    present = {dim for dataset in table.datasets.values() for dim in dataset.dims}
    for name, values, units, long_name in scales:
        if name in present:
            values = _storable(values)
            scale = _dataset(file, name, values.shape, values.dtype)
            scale[...] = values
            scale.attrs.update(units=units, long_name=long_name)
            scale.make_scale(name)
    for entry in table.datasets.values():
        shape = table.shape(entry.name)
        dtype = _STRING if entry.dtype == "str" else np.dtype(entry.dtype)
        sampled = "cycle" in entry.dims
        dataset = _dataset(file, entry.name, shape, dtype, entry.fill, compress=sampled)
        dataset.attrs.update(_attributes(entry))
        for axis, dim in zip(dataset.dims, entry.dims, strict=True):
            axis.attach_scale(file[dim])


def _dataset(
    file: h5py.File,
    name: str,
    shape: tuple[int, ...],
    dtype: np.dtype,
    fill: Any = None,
    compress: bool = False,
) -> h5py.Dataset:
    """Create an empty dataset; numbers are chunked, each chunk with its checksum."""
    options: dict[str, Any] = {"dtype": dtype, "fillvalue": fill, "track_times": False}
    if h5py.check_string_dtype(dtype) is None:
        options |= {"chunks": _chunks(shape, dtype.itemsize), "fletcher32": True}
    if compress:
        # a settled orbit repeats itself: a third of the bytes for a hundredth of the run time
        options |= {"shuffle": True, "compression": "gzip", "compression_opts": 1}
    return file.create_dataset(name, shape, **options)


def _chunks(shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Halve the longer of the first two sides until a chunk is small, and then the other sides.

    So a lane's samples stay together as long as they can, and the layout does not depend on how
    the scan was cut into blocks.
    """
    chunk = list(shape)
    while math.prod(chunk) * itemsize > _CHUNK_BYTES:
        side = max(range(len(chunk)), key=lambda i: (i < 2 and chunk[i] > 1, chunk[i]))
        chunk[side] = -(-chunk[side] // 2)
    return tuple(chunk)


def _attributes(entry: Dataset) -> dict[str, Any]:
    attributes: dict[str, Any] = {"units": entry.units, "long_name": entry.long_name}
    if entry.flags is not None:
        attributes["flag_values"] = np.array(entry.flag_values, dtype=entry.dtype)
        attributes["flag_meanings"] = entry.flag_meanings
    return attributes


def _storable(values: np.ndarray) -> np.ndarray:
    """Return strings as h5py takes them, and anything else as it is."""
    if values.dtype.kind not in "UO":
        return values
    return values.astype(object).astype(_STRING)


def _compare(path: Path, given: Iterable[tuple[str, tuple[slice, ...], int]]) -> None:
    """Read back every piece; `RequestError` if its CRC-32 is not that of what was given."""
    if not durable.sealed(path):
        raise RequestError(f"{path} did not reach the disk as it was written")
    with h5py.File(path, "r", **_CACHE) as file:
        for name, cells, crc in given:
            if _crc(_values(file[name], cells)) != crc:
                raise RequestError(f"{path}: {name} did not reach the disk as it was computed")


def _problems(file: h5py.File, name: str) -> Iterator[str]:
    """Read one dataset from end to end and say what is wrong with it."""
    try:
        dataset = file[name]
        for slab in _slabs(dataset):
            dataset[slab]
        _check_crc(dataset)
    except _DAMAGE as error:
        yield f"dataset {name} is damaged: {_first_line(error)}"


def _slabs(dataset: h5py.Dataset) -> Iterator[slice]:
    """Cut a dataset along its first dimension into slices that fit into memory."""
    length = dataset.shape[0]
    step = max(1, _SLAB_ITEMS // max(1, math.prod(dataset.shape[1:])))
    for first in range(0, length, step):
        yield slice(first, min(first + step, length))


@contextmanager
def _reading(path: Path, what: str) -> Iterator[None]:
    """Turn what h5py says of a damaged file into one line that names the place."""
    try:
        yield
    except _DAMAGE as error:
        raise RequestError(f"{path}: {what} is damaged: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _values(dataset: h5py.Dataset, where: Any) -> np.ndarray:
    return dataset.asstr()[where] if _is_text(dataset) else dataset[where]


def _is_text(dataset: h5py.Dataset) -> bool:
    return h5py.check_string_dtype(dataset.dtype) is not None


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _crc(values: np.ndarray, crc: int = 0) -> int:
    """Return the CRC-32, continued from `crc`, of values; each string is closed by a zero byte."""
    if values.dtype.kind not in "UO":
        return zlib.crc32(np.ascontiguousarray(values).data, crc)
    return zlib.crc32("".join(f"{text}\0" for text in values.flat).encode(), crc)


def _whole_crc(dataset: h5py.Dataset) -> int:
    crc = 0
    for slab in _slabs(dataset):
        crc = _crc(_values(dataset, slab), crc)
    return crc


def _check_crc(dataset: h5py.Dataset) -> None:
    if _is_text(dataset) and _whole_crc(dataset) != dataset.attrs.get("crc32"):
        raise ValueError("its checksum is not that of its strings")
