"""The HDF5 archive: written once and whole, read by name, verified from end to end.

The only module that imports h5py.  The layout is that of netCDF-4: every dimension of every dataset
has its scale attached, so that `xarray.open_dataset(FILE, engine="h5netcdf")` opens it.

Numbers have HDF5's Fletcher checksum.  Strings have a CRC-32 in an attribute, because HDF5 stores
their bytes where no checksum of its own covers them.  Both tell which dataset is damaged; a seal
over the whole file detects any other damage.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from nlds_vines.archives import durable
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.layout import chunk_shape, crc32_of, slabs
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.archives.structure import Member, problems_of
from nlds_vines.errors import RequestError, shown

Piece = tuple[str, tuple[slice, ...], np.ndarray]
"""The name of a dataset, a rectangle of its cells, and the values there."""

_HDF5 = {"hdf5_version": h5py.version.hdf5_version}
_STRING = h5py.string_dtype()  # variable-length UTF-8
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused
# pieces need not end where chunks do: half-written chunks are kept in this cache (64 MiB, and a
# prime number of slots, as HDF5 advises)
_CACHE = {"rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}
_DAMAGE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)
"""The errors that h5py raises for damaged files."""


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path`, seal it, force it to the disk, and read it back.

    Arguments:
        path: the file; an existing one is replaced.
        table: the datasets.
        scales: the scales of all dimensions of the datasets.
        pieces: the results, in any order; cells without a piece keep their fill value.
        attributes: returns the attributes of the file; called after the last piece was taken.

    Holds one piece in memory at a time.  Raises `RequestError` if the values that are read back
    differ from those given, OSError or (from HDF5) RuntimeError if the file cannot be written.
    """
    durable.reserve(path, table.most_bytes + _OVERHEAD)
    # v110 checksums the metadata too, and is read by every netCDF-4 library of this decade
    with h5py.File(path, "w", libver=("v110", "v110"), **_CACHE) as file:
        _create(file, table, scales)
        given = []
        for name, where, values in pieces:
            file[name][where] = _storable(values)
            given.append((name, where, crc32_of(values)))
        file.attrs.update({**_HDF5, **attributes()})
        _note_checksums(file)
    durable.seal(path)
    _compare(path, given)


def whole(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield each dataset, given as a whole array of any numeric type, as one piece."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored


def _note_checksums(file: h5py.File) -> None:
    """Give every dataset of strings its CRC-32 as an attribute."""
    for dataset in filter(_is_text, file.values()):
        dataset.attrs["crc32"] = np.uint32(_whole_crc(dataset))


@dataclass(frozen=True)
class ArchiveView:
    """An open archive; its datasets are read from the disk when they are asked for.

    `view["section"]` is the whole array, `view.take("section", start=0, component=2)` a part of
    it.  Reading a damaged dataset raises `RequestError` with its name.
    """

    path: Path
    _file: h5py.File

    @property
    def attrs(self) -> dict[str, Any]:
        """The attributes of the file: title, history, request, parameters, versions ..."""
        with _reading(self.path, "an attribute"):
            return {name: _plain(value) for name, value in self._file.attrs.items()}

    def text(self, name: str) -> str:
        """Return an attribute of the file that is a text: `title`, `scan`, `scan_hash`.

        Raises `RequestError` where it is missing, or is no text.
        """
        with _reading(self.path, f"attribute {name}"):
            value = _plain(self._file.attrs[name]) if name in self._file.attrs else None
        if value is None:
            raise RequestError(f"{self.path} has no attribute {name!r}: it is damaged")
        if not isinstance(value, str):
            raise RequestError(f"{self.path}: attribute {name} = {shown(value)} must be a text")
        return value

    @property
    def content(self) -> str:
        """The kind of request whose results it holds: `scan`, `tuning`, `survey`."""
        return self.text("content") if "content" in self.attrs else "scan"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the recorded datasets, without the scales of their dimensions."""
        with _reading(self.path, "the list of its datasets"):
            return tuple(name for name in self._file if not self._file[name].is_scale)

    @property
    def axes(self) -> tuple[str, ...]:
        """The names of the varied parameters, in the order of the dimensions."""
        return self.dims("status")[:-1]

    def __contains__(self, name: str) -> bool:
        """Return whether a dataset or a scale of this name is in the archive."""
        return name in self._file

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a whole dataset or scale; strings as an array of `str` objects."""
        return self.take(name)

    def take(self, name: str, **index: int) -> np.ndarray:
        """Return a part of a dataset: at the `index` of some dimensions, all of the others."""
        if name not in self._file:
            raise RequestError(f"{self.path} holds no {name}, only {', '.join(self.names)}")
        where = tuple(index.get(dim, slice(None)) for dim in self.dims(name))
        with _reading(self.path, f"dataset {name}"):
            dataset = self._file[name]
            _check_crc(dataset)
            return _values(dataset, where)

    def slabs(self, name: str) -> Iterator[np.ndarray]:
        """Yield a dataset in parts along its first dimension, each of which fits into memory."""
        with _reading(self.path, f"dataset {name}"):
            for slab in slabs(self._file[name].shape):
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

    def is_text(self, name: str) -> bool:
        """Return whether a dataset or scale holds strings."""
        with _reading(self.path, f"dataset {name}"):
            return _is_text(self._file[name])

    def units(self, name: str) -> str:
        """Return the units of a dataset or scale."""
        return str(self._attribute(name, "units"))

    def long_name(self, name: str) -> str:
        """Return the meaning of a dataset or scale, in words."""
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
    """Open an archive for reading, in a `with` statement.

    Raises `RequestError` if the file does not exist, if it is not an archive of this program, if
    its format is newer than this version knows, and if it is not laid out as an archive is: nothing
    in it may lead to another file.
    """
    path = Path(path)
    with _opened(path) as file:
        found = _problems_of_layout(file)
        if found:
            raise RequestError(f"{path} is damaged: {found[0]}")
        yield ArchiveView(path, file)


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """Open an archive whose layout is not checked yet."""
    try:
        durable.open_regular(path).close()
        file = h5py.File(path, "r")
    except FileNotFoundError as error:
        raise RequestError(f"{path}: there is no such file") from error
    except (OSError, ValueError) as error:
        text = "it is no HDF5 file, damaged, or not readable"
        raise RequestError(f"{path} cannot be opened: {text}") from error
    with file:
        schema = _schema(file)
        if schema is None:
            raise RequestError(f"{path} is not an archive of nlds_vines")
        if schema > SCHEMA:
            raise RequestError(f"{path} has schema {schema}: this version reads up to {SCHEMA}")
        yield file


def verify(path: str | os.PathLike[str]) -> list[str]:
    """Read an archive from end to end and return its problems, one line each; empty if sound.

    A damaged dataset is named.  Damage anywhere else, even of one bit of a header, an attribute or
    padding, breaks the seal.  What leads to another file, which no seal covers, is a problem, too.
    Raises `RequestError` if the file does not exist.
    """
    path = Path(path)
    try:
        with durable.in_one_line(f"read {path}"):
            sealed = durable.sealed(path)
    except RequestError:
        raise
    except ValueError as error:
        return [str(error)]
    problems = [] if sealed else ["the seal is broken: the file is not as it was written"]
    try:
        with _opened(path) as file:
            problems += _all_problems(path, file)
    except _DAMAGE as error:
        problems.append(_first_line(error))
    return problems


def _all_problems(path: Path, file: h5py.File) -> list[str]:
    """Return what is wrong in an open archive; values are read only where nothing leads outside."""
    problems = _problems_of_layout(file)
    if problems:
        return problems
    view = ArchiveView(path, file)
    for name in ("title", "scan", "scan_hash"):
        try:
            view.text(name)
        except RequestError as error:
            problems.append(str(error).removeprefix(f"{path}: "))
    return problems + [line for name in file for line in _problems(file, name)]


def _problems_of_layout(file: h5py.File) -> list[str]:
    """Return what is wrong with the layout of a file, one line each; nothing in it is followed."""
    try:
        return list(problems_of({name: _member(file, name) for name in file}))
    except _DAMAGE as error:
        return [f"its layout cannot be read: {_first_line(error)}"]


def _member(file: h5py.File, name: str) -> Member:
    """Return what is known of an entry of a file without following or reading it."""
    link = file.get(name, getlink=True)
    if not isinstance(link, h5py.HardLink):
        return Member(f"is a link to {getattr(link, 'filename', link.path)!r}: it may lead outside")
    entry = file[name]
    if not isinstance(entry, h5py.Dataset):
        return Member("is not a dataset")
    if entry.is_virtual or entry.external or entry.shape is None:
        return Member("has its values elsewhere")
    text, numbers = _is_text(entry), entry.dtype.kind in "iuf"
    return Member(
        numbers=numbers,
        text=text,
        shape=entry.shape,
        bytes=entry.size * entry.dtype.itemsize,
        stored=entry.id.get_storage_size(),
        scales=tuple(tuple(s.name.removeprefix("/") for s in d.values()) for d in entry.dims),
        is_scale=entry.is_scale,
        values=partial(_readable, entry) if numbers and entry.is_scale else None,
    )


def _readable(dataset: h5py.Dataset) -> np.ndarray | None:
    """Return the values of a dataset; None where they are damaged, which reading them tells."""
    try:
        return dataset[...]
    except _DAMAGE:
        return None


def _schema(file: h5py.File) -> int | None:
    """Return the number of the archive's format; None if the file is no archive."""
    try:
        known = "scan_hash" in file.attrs and "status" in set(file)  # which follows no link
        return int(file.attrs["schema"]) if known else None
    except (*_DAMAGE, ArithmeticError):
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
        options |= {"chunks": chunk_shape(shape, dtype.itemsize), "fletcher32": True}
    if compress:
        # settled orbits repeat themselves: a third of the bytes, for a hundredth of the run time
        options |= {"shuffle": True, "compression": "gzip", "compression_opts": 1}
    return file.create_dataset(name, shape, **options)


def _attributes(entry: Dataset) -> dict[str, Any]:
    """Return the attributes of a dataset: unit, meaning, the words of an enumeration."""
    attributes: dict[str, Any] = {"units": entry.units, "long_name": entry.long_name}
    if entry.flags is not None:
        attributes["flag_values"] = np.array(entry.flag_values, dtype=entry.dtype)
        attributes["flag_meanings"] = entry.flag_meanings
    return attributes


def _storable(values: np.ndarray) -> np.ndarray:
    """Return strings in the type that h5py stores, other values as they are."""
    if values.dtype.kind not in "UO":
        return values
    return values.astype(object).astype(_STRING)


def _compare(path: Path, given: Iterable[tuple[str, tuple[slice, ...], int]]) -> None:
    """Read every piece back; raise `RequestError` if its CRC-32 is not the `given` one."""
    if not durable.sealed(path):
        raise RequestError(f"{path} did not reach the disk as it was written")
    with h5py.File(path, "r", **_CACHE) as file:
        for name, cells, crc in given:
            if crc32_of(_values(file[name], cells)) != crc:
                raise RequestError(f"{path}: {name} did not reach the disk as it was computed")


def _problems(file: h5py.File, name: str) -> Iterator[str]:
    """Read one dataset from end to end and yield what is wrong with it."""
    try:
        dataset = file[name]
        for slab in slabs(dataset.shape):
            dataset[slab]
        _check_crc(dataset)
    except _DAMAGE as error:
        yield f"dataset {name} is damaged: {_first_line(error)}"


@contextmanager
def _reading(path: Path, what: str) -> Iterator[None]:
    """Turn h5py's error for a damaged file into a `RequestError` that names the place."""
    try:
        yield
    except _DAMAGE as error:
        raise RequestError(f"{path}: {what} is damaged: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    """Return the first line of an error's message, or the error's name if it has none."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def _values(dataset: h5py.Dataset, where: Any) -> np.ndarray:
    """Return a part of a dataset; strings as an array of `str` objects."""
    return dataset.asstr()[where] if _is_text(dataset) else dataset[where]


def _is_text(dataset: h5py.Dataset) -> bool:
    """Return whether a dataset holds strings."""
    return h5py.check_string_dtype(dataset.dtype) is not None


def _plain(value: Any) -> Any:
    """Return an attribute as a Python number or string."""
    return value.item() if isinstance(value, np.generic) else value


def _whole_crc(dataset: h5py.Dataset) -> int:
    """Return the CRC-32 of all values of a dataset, in the order of the disk."""
    crc = 0
    for slab in slabs(dataset.shape):
        crc = crc32_of(_values(dataset, slab), crc)
    return crc


def _check_crc(dataset: h5py.Dataset) -> None:
    """Raise ValueError if the strings of a dataset have another CRC-32 than its attribute says."""
    if _is_text(dataset) and _whole_crc(dataset) != dataset.attrs.get("crc32"):
        raise ValueError("its checksum is not that of its strings")
