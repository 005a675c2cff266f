"""The HDF5 archive: written once and whole, read by name.

The only module that imports h5py.  The layout is that of netCDF-4: every dimension of every dataset
has its scale attached, so that `xarray.open_dataset(FILE, engine="h5netcdf")` opens it.

Every dataset has HDF5's Fletcher-32 checksum, so reading a damaged one raises an error that names
it.  Strings have a fixed length, as the checksum does not cover strings of variable length.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from nlds_vines.archives import durable
from nlds_vines.archives.dataset import Dataset, Scale, Table, chunk_shape
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.archives.view import DAMAGE, ArchiveView, first_line
from nlds_vines.errors import RequestError, shown

Piece = tuple[str, tuple[slice, ...], np.ndarray]
"""The name of a dataset, a rectangle of its cells, and the values there."""

_HDF5 = {"hdf5_version": h5py.version.hdf5_version}
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused
# pieces need not end where chunks do: half-written chunks are kept in this cache (64 MiB, and a
# prime number of slots, as HDF5 advises)
_CACHE = {"rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path` and force it to the disk.

    Arguments:
        path: the file; an existing one is replaced.
        table: the datasets.
        scales: the scales of all dimensions of the datasets.
        pieces: the results, in any order; cells without a piece keep their fill value.
        attributes: returns the attributes of the file; called after the last piece was taken.

    Holds one piece of numbers in memory at a time, and all strings: their length is that of the
    longest.  Raises OSError or (from HDF5) RuntimeError if the file cannot be written.
    """
    durable.reserve(path, table.most_bytes + _OVERHEAD)
    # v110 checksums the metadata too, and is read by every netCDF-4 library of this decade
    with h5py.File(path, "w", libver=("v110", "v110"), **_CACHE) as file:
        _create_scales(file, table, scales)
        texts = {}
        for entry in table.datasets.values():
            shape = table.shape(entry.name)
            if entry.dtype == "str":
                texts[entry.name] = np.full(shape, "", dtype=object)
            else:
                _create(file, entry, shape, np.dtype(entry.dtype), entry.fill)
        for name, where, values in pieces:
            if name in texts:
                texts[name][where] = values
            else:
                file[name][where] = values
        for name, words in texts.items():
            _create(file, table.datasets[name], words.shape, _dtype_of(words))[...] = words
        file.attrs.update({**_HDF5, **attributes()})
    with path.open("rb") as written:
        os.fsync(written.fileno())


def whole(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield each dataset, given as a whole array of any numeric type, as one piece."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored


def read(path: str | os.PathLike[str]) -> ArchiveView:
    """Open an archive for reading, with or without a `with` statement.

    Raises `RequestError` if the file does not exist, is not an archive of this program, or has a
    format that this version does not know.
    """
    path = _as_path(path)
    return ArchiveView(path, _opened(path))


def _as_path(path: object) -> Path:
    """Return the path of an archive; `RequestError` for anything that is none."""
    if isinstance(path, Path):
        return path
    if isinstance(path, str | os.PathLike):
        return Path(path)
    raise RequestError(f"archive = {shown(path)} must be the path of a file")


def _opened(path: Path) -> h5py.File:
    """Open an archive with h5py; `RequestError` if it is none."""
    try:
        durable.open_regular(path).close()
    except FileNotFoundError as error:
        raise RequestError(f"{path}: there is no such file") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path} cannot be opened: {reason}") from error
    try:
        file = h5py.File(path, "r")
    except (OSError, ValueError) as error:
        text = "it is no HDF5 file, damaged, or not readable"
        raise RequestError(f"{path} cannot be opened: {text}") from error
    schema = _schema(file)
    if schema is not None and schema <= SCHEMA:
        return file
    file.close()
    if schema is None:
        raise RequestError(f"{path} is not an archive of nlds_vines")
    raise RequestError(f"{path} has schema {schema}: this version reads up to {SCHEMA}")


def columns(path: Path) -> list[tuple[str, str]]:
    """Return the numeric datasets of one dimension in any HDF5 file: name and `units` of each.

    Raises `RequestError`, one line, for a file that cannot be read as HDF5.
    """
    with _any_hdf5(path) as file:
        entries = ((name, file.get(name)) for name in file)  # None: a link to nowhere
        flat = [(name, e) for name, e in entries if isinstance(e, h5py.Dataset) and e.ndim == 1]
        return [
            (name, _words(entry.attrs.get("units", "")))
            for name, entry in flat
            if entry.dtype.kind in "iuf"
        ]


def column(path: Path, name: str, most: int) -> np.ndarray:
    """Return the numbers of one of `columns`.

    Raises `RequestError`, one line, before anything is read, if the dataset or one of its chunks,
    which HDF5 unpacks as a whole, holds more than `most` numbers.
    """
    with _any_hdf5(path) as file:
        size = max(file[name].size, *(file[name].chunks or (0,)))
        if size <= most:
            return np.asarray(file[name][...], dtype=np.float64)
    raise RequestError(f"{path}: dataset {name!r} holds {size} numbers; allowed: up to {most}")


@contextmanager
def _any_hdf5(path: Path) -> Iterator[h5py.File]:
    """Open any HDF5 file; raise `RequestError`, one line, if it cannot be read in the block."""
    try:
        durable.open_regular(path).close()
        with h5py.File(path, "r") as file:
            yield file
    except DAMAGE as error:
        raise RequestError(f"{path}: cannot be read as HDF5: {first_line(error)}") from None


def _words(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _schema(file: h5py.File) -> int | None:
    """Return the number of the archive's format; None if the file is no archive."""
    try:
        known = "scan_hash" in file.attrs and "status" in set(file)  # which follows no link
        return int(file.attrs["schema"]) if known else None
    except (*DAMAGE, ArithmeticError):
        return None


def _create_scales(file: h5py.File, table: Table, scales: Iterable[Scale]) -> None:
    """Write the scales of those dimensions that the datasets of a table have."""
    present = {dim for dataset in table.datasets.values() for dim in dataset.dims}
    for name, values, units, long_name in scales:
        if name in present:
            values = values.astype(object) if values.dtype.kind == "U" else values
            scale = _dataset(file, name, values.shape, _dtype_of(values))
            scale[...] = values
            scale.attrs.update(units=units, long_name=long_name)
            scale.make_scale(name)


def _create(
    file: h5py.File, entry: Dataset, shape: tuple[int, ...], dtype: np.dtype, fill: Any = None
) -> h5py.Dataset:
    """Create the dataset of an entry, and attach its scales."""
    compress = entry.dtype == "str" or not {"forcing_period", "impact"}.isdisjoint(entry.dims)
    dataset = _dataset(file, entry.name, shape, dtype, fill, compress)
    dataset.attrs.update(_attributes(entry))
    for axis, dim in zip(dataset.dims, entry.dims, strict=True):
        axis.attach_scale(file[dim])
    return dataset


def _dataset(
    file: h5py.File,
    name: str,
    shape: tuple[int, ...],
    dtype: np.dtype,
    fill: Any = None,
    compress: bool = False,
) -> h5py.Dataset:
    """Create an empty dataset of chunks, each with its checksum."""
    options: dict[str, Any] = {"dtype": dtype, "fillvalue": fill, "track_times": False}
    options |= {"chunks": chunk_shape(shape, dtype.itemsize), "fletcher32": True}
    if compress:
        # settled orbits repeat themselves: a third of the bytes, for a hundredth of the run time
        options |= {"shuffle": True, "compression": "gzip", "compression_opts": 1}
    dataset = file.create_dataset(name, shape, **options)
    if h5py.check_string_dtype(dtype) is not None:
        dataset.attrs["_Encoding"] = "utf-8"  # as netCDF has it; xarray decodes by it
    return dataset


def _attributes(entry: Dataset) -> dict[str, Any]:
    """Return the attributes of a dataset: unit, meaning, the words of an enumeration."""
    attributes: dict[str, Any] = {"units": entry.units, "long_name": entry.long_name}
    if entry.flags is not None:
        attributes["flag_values"] = np.array(entry.flag_values, dtype=entry.dtype)
        attributes["flag_meanings"] = entry.flag_meanings
    return attributes


def _dtype_of(values: np.ndarray) -> np.dtype:
    """Return the type as which values are stored: of strings UTF-8 as long as the longest."""
    if values.dtype.kind != "O":
        return values.dtype
    return h5py.string_dtype("utf-8", max([1, *(len(text.encode()) for text in {*values.flat})]))
