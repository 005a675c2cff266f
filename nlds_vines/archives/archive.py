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
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from nlds_vines.archives import durable
from nlds_vines.archives.dataset import Dataset, Scale, Table, chunk_shape, crc32_of, slabs
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.archives.structure_check import (
    Member,
    heaps_are_whole,
    problems_of,
    problems_of_values,
)
from nlds_vines.archives.toml import parse_toml
from nlds_vines.archives.view import (
    DAMAGE,
    ArchiveView,
    check_crc,
    first_line,
    is_text,
    values_of,
    whole_crc,
)
from nlds_vines.errors import RequestError, shown

Piece = tuple[str, tuple[slice, ...], np.ndarray]
"""The name of a dataset, a rectangle of its cells, and the values there."""

_HDF5 = {"hdf5_version": h5py.version.hdf5_version}
_STRING = h5py.string_dtype()  # variable-length UTF-8
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused
# pieces need not end where chunks do: half-written chunks are kept in this cache (64 MiB, and a
# prime number of slots, as HDF5 advises)
_NOTES = {"CLASS", "NAME", "DIMENSION_LIST"}
"""The attributes in which HDF5 notes that a dataset is a scale, and which scales it has."""

_CACHE = {"rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}


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
        for dataset in filter(is_text, file.values()):
            dataset.attrs["crc32"] = np.uint32(whole_crc(dataset))
    durable.seal(path)
    _compare(path, given)


def whole(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield each dataset, given as a whole array of any numeric type, as one piece."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored


def read(path: str | os.PathLike[str]) -> ArchiveView:
    """Open an archive for reading, with or without a `with` statement.

    Raises `RequestError` if the file does not exist, if it is not an archive of this program, if
    its format is newer than this version knows, and if it is not laid out as an archive is: nothing
    in it may lead to another file.
    """
    path = _as_path(path)
    file = _opened(path)
    found = _problems_of_layout(file)
    if found:
        file.close()
        raise RequestError(f"{path} is damaged: {found[0]}")
    return ArchiveView(path, file)


def _as_path(path: object) -> Path:
    """Return the path of an archive; `RequestError` for anything that is none."""
    if isinstance(path, Path):
        return path
    if isinstance(path, str | os.PathLike):
        return Path(path)
    raise RequestError(f"archive = {shown(path)} must be the path of a file")


def _opened(path: Path) -> h5py.File:
    """Open an archive whose layout is not checked yet."""
    try:
        durable.open_regular(path).close()
    except FileNotFoundError as error:
        raise RequestError(f"{path}: there is no such file") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path} cannot be opened: {reason}") from error
    try:
        if not heaps_are_whole(path):
            raise ValueError("HDF5 might read it for ever")
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


def columns(path: Path) -> list[tuple[str, str, np.ndarray]]:
    """Return the datasets of one dimension in any HDF5 file: name, `units` and numbers of each.

    Raises `RequestError`, one line, for a file that cannot be read as HDF5.
    """
    try:
        durable.open_regular(path).close()
        if not heaps_are_whole(path):
            raise ValueError("its heaps are damaged")
        with h5py.File(path, "r") as file:
            own = (name for name in file if not _outside(file, name))
            flat = [(name, file[name]) for name in own if file[name].ndim == 1]
            return [
                (name, _words(entry.attrs.get("units", "")), entry[...].astype(np.float64))
                for name, entry in flat
                if entry.dtype.kind in "iuf"
            ]
    except DAMAGE as error:
        raise RequestError(f"{path}: cannot be read as HDF5: {first_line(error)}") from None


def _words(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def verify(path: str | os.PathLike[str]) -> list[str]:
    """Read an archive from end to end and return its problems, one line each; empty if sound.

    A damaged dataset is named.  Damage anywhere else, even of one bit of a header, an attribute or
    padding, breaks the seal.  What leads to another file, which no seal covers, is a problem, too.
    Raises `RequestError` if the file does not exist.
    """
    path = _as_path(path)
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
    except DAMAGE as error:
        problems.append(first_line(error))
    return problems


def _all_problems(path: Path, file: h5py.File) -> list[str]:
    """Return what is wrong in an open archive; values are read only where nothing leads outside."""
    problems = _problems_of_layout(file)
    if problems:
        return problems
    view = ArchiveView(path, file)
    for name in ("title", "scan", "scan_hash"):
        try:
            text = view.text(name)
            if name == "scan":
                parse_toml(text, "attribute scan")
        except RequestError as error:
            problems.append(str(error).removeprefix(f"{path}: "))
    return problems + [line for name in file for line in _problems(file, name)]


def _problems_of_layout(file: h5py.File) -> list[str]:
    """Return what is wrong with the layout of a file, one line each; nothing in it is followed.

    Scales are only looked for where all entries are such that HDF5 can.
    """
    try:
        outside = {name: Member(words) for name in file if (words := _outside(file, name))}
        return list(problems_of(outside or {name: _member(file[name]) for name in file}))
    except DAMAGE as error:
        return [f"its layout cannot be read: {first_line(error)}"]


def _outside(file: h5py.File, name: str) -> str:
    """Return in words what makes an entry none of an archive; empty for a dataset of its own."""
    link = file.get(name, getlink=True)
    if not isinstance(link, h5py.HardLink):
        return f"is a link to {getattr(link, 'filename', link.path)!r}: it may lead outside"
    entry = file[name]
    if not isinstance(entry, h5py.Dataset):
        return "is not a dataset"
    if entry.is_virtual or entry.external or entry.shape is None:
        return "has its values elsewhere"
    return "" if _has_sound_notes(entry) else "has notes on its dimensions that are of another type"


def _member(entry: h5py.Dataset) -> Member:
    """Return what is known of a dataset before its values are read."""
    text = h5py.check_string_dtype(entry.dtype) is not None
    numbers = entry.dtype.kind in "iuf"
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


def _has_sound_notes(dataset: h5py.Dataset) -> bool:
    """Tell whether what HDF5 notes of dimensions and scales is of the types that it reads it as.

    It looks at no type itself, and reads or writes beyond the end of anything else.
    """
    notes = {name: h5py.h5a.open(dataset.id, name.encode()) for name in _NOTES & {*dataset.attrs}}
    for name, note in notes.items():
        kind, shape = note.get_type(), (dataset.ndim,) if name == "DIMENSION_LIST" else ()
        if name == "DIMENSION_LIST":
            sound = kind.get_class() == h5py.h5t.VLEN and kind.get_super() == h5py.h5t.STD_REF_OBJ
        else:
            sound = kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str()
        if not sound or note.shape != shape:
            return False
    return True


def _readable(dataset: h5py.Dataset) -> np.ndarray | None:
    """Return the values of a dataset; None where they are damaged, which reading them tells."""
    try:
        return dataset[...]
    except DAMAGE:
        return None


def _schema(file: h5py.File) -> int | None:
    """Return the number of the archive's format; None if the file is no archive."""
    try:
        known = "scan_hash" in file.attrs and "status" in set(file)  # which follows no link
        return int(file.attrs["schema"]) if known else None
    except (*DAMAGE, ArithmeticError):
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
        sampled = not {"forcing_period", "impact"}.isdisjoint(entry.dims)
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
            if crc32_of(values_of(file[name], cells)) != crc:
                raise RequestError(f"{path}: {name} did not reach the disk as it was computed")


def _problems(file: h5py.File, name: str) -> Iterator[str]:
    """Read one dataset from end to end and yield what is wrong with it."""
    try:
        dataset = file[name]
        check_crc(dataset)
        values = (values_of(dataset, slab) for slab in slabs(dataset.shape))
        found = list(problems_of_values(dataset.attrs, dataset.fillvalue, values))
    except DAMAGE as error:
        found = [first_line(error)]
    for problem in found:
        yield f"dataset {name} is damaged: {problem}"
