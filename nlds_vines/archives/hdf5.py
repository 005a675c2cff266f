"""HDF5 files: archives, written once and whole, and the numbers in files of others.

Only this module imports h5py, and only inside functions: `--help` does not wait for it.

The layout is that of netCDF-4: every dimension of every dataset has its scale attached, so that
`xarray.open_dataset(FILE, engine="h5netcdf")` opens it.  Every dataset has HDF5's Fletcher-32
checksum; strings have a fixed length, as the checksum does not cover strings of variable length.
HDF5's metadata carry checksums of their own.  So damage is an error where it is read.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.contents import InMemory, Piece, whole_pieces
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import open_regular
from nlds_vines.archives.provenance import Value
from nlds_vines.errors import RequestError, shown

if TYPE_CHECKING:
    import h5py

# the errors that h5py raises for damaged files
_DAMAGE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)
_CHUNK_BYTES = 1 << 18  # small enough to read a few cells, large enough to compress and to seek
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused


# ---- writing -------------------------------------------------------------------------------------


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path` and force it to the disk.

    The `pieces` of results come in any order; cells without a piece have their fill value.  The
    `attributes` are made after the last piece.  One numeric piece is in memory at a time, and all
    strings: the longest sets their stored length.
    """
    import h5py

    with path.open("wb") as trial:  # check that there is room: HDF5 may crash if the disk fills
        if hasattr(os, "posix_fallocate"):  # not on every system
            os.posix_fallocate(trial.fileno(), 0, table.most_bytes + _OVERHEAD)
    # v110 checksums the metadata; pieces need not end where chunks do, so that half-written chunks
    # wait in a cache of 64 MiB with a prime number of slots
    how = {"libver": ("v110", "v110"), "rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}
    with h5py.File(path, "w", **how) as file:
        for scale in scales:
            if scale.name in table.dims:
                entry, values = replace(scale.dataset, dims=()), scale.values
                values = values.astype(object) if values.dtype.kind == "U" else values
                _create(file, entry, values.shape, _strings(values))[...] = values
                file[scale.name].make_scale(scale.name)
        texts = {}
        for entry in table.datasets.values():
            if entry.dtype == "str":
                texts[entry.name] = np.full(table.shape(entry.name), "", dtype=object)
            else:
                _create(file, entry, table.shape(entry.name), np.dtype(entry.dtype))
        for name, where, values in pieces:
            (texts if name in texts else file)[name][where] = values
        for name, words in texts.items():
            _create(file, table.datasets[name], words.shape, _strings(words))[...] = words
        file.attrs.update(hdf5_version=h5py.version.hdf5_version, **attributes())
    with path.open("rb") as written:
        os.fsync(written.fileno())


def write_contents(path: Path, contents: InMemory) -> None:
    """Write contents in memory as the archive `path`."""
    arrays = [(contents.describe(name), contents.arrays[name]) for name in contents.names]
    write(path, contents.table, contents.scales, whole_pieces(arrays), lambda: contents.about)


def _create(
    file: h5py.File, entry: Dataset, shape: tuple[int, ...], dtype: np.dtype
) -> h5py.Dataset:
    """Create a dataset in chunks, each with its checksum, and attach its scales."""
    options: dict[str, Any] = {"chunks": chunk_shape(shape, dtype.itemsize), "fletcher32": True}
    if entry.dtype == "str" or not {"forcing_period", "impact"}.isdisjoint(entry.dims):
        # settled orbits repeat themselves: a third of the bytes, for a hundredth of the run time
        options |= {"shuffle": True, "compression": "gzip", "compression_opts": 1}
    if entry.dtype != "str":
        options["fillvalue"] = entry.fill
    dataset = file.create_dataset(entry.name, shape, dtype, track_times=False, **options)
    dataset.attrs.update(units=entry.units, long_name=entry.long_name)
    if entry.dtype == "str":
        dataset.attrs["_Encoding"] = "utf-8"  # as netCDF has it; xarray decodes by it
    if entry.flags is not None:
        dataset.attrs["flag_values"] = np.array([*entry.flags.values()], entry.dtype)
        dataset.attrs["flag_meanings"] = " ".join(entry.flags)
    for axis, dim in zip(dataset.dims, entry.dims):  # noqa: B905 - a scale's entry has no dims
        axis.attach_scale(file[dim])
    return dataset


def _strings(values: np.ndarray) -> np.dtype:
    """Return the dtype of the stored values; for strings, UTF-8 with the length of the longest."""
    import h5py

    if values.dtype != object:
        return values.dtype
    return h5py.string_dtype("utf-8", max([1, *(len(text.encode()) for text in {*values.flat})]))


def chunk_shape(shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Return the shape of the chunks of an array whose values take `itemsize` bytes.

    The longer of the first two sides is halved until a chunk takes at most 256 KiB; other sides are
    halved only once both are 1, so that the samples of one orbit stay together as long as possible.
    """
    chunk = list(shape)
    while math.prod(chunk) * itemsize > _CHUNK_BYTES:
        side = max(range(len(chunk)), key=lambda i: (i < 2 and chunk[i] > 1, chunk[i]))
        chunk[side] = -(-chunk[side] // 2)
    return tuple(chunk)


# ---- reading -------------------------------------------------------------------------------------


class InFile:
    """The contents of an open archive, read from the disk when they are asked for.

    All that is damaged is a `RequestError` that names the place.
    """

    def __init__(self, path: Path) -> None:
        """Open a file; raise `RequestError` unless it is HDF5 that lies in the file itself."""
        self._path = path
        try:
            open_regular(path).close()  # HDF5 would wait for a pipe
        except FileNotFoundError:
            raise RequestError(f"{path}: there is no such file") from None
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RequestError(f"{path} cannot be opened: {reason}") from error
        import h5py

        unreadable = f"{path} cannot be opened: it is no HDF5 file, damaged, or not readable"
        try:
            self._file = h5py.File(path, "r")
        except _DAMAGE as error:
            raise RequestError(unreadable) from error
        try:
            refuse_links(path, self._file)
            self.names = tuple(name for name in self._file if not self._file[name].is_scale)
        except RequestError:
            self.close()
            raise
        except _DAMAGE as error:
            self.close()
            raise RequestError(unreadable) from error

    @contextmanager
    def _damage(self, place: str) -> Iterator[None]:
        """Turn h5py's error for a damaged file into a `RequestError` that names the place."""
        try:
            yield
        except _DAMAGE as error:
            reason = _first_line(error)
            raise RequestError(f"{self._path}: {place} is damaged: {reason}") from error

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._file

    def attributes(self) -> dict[str, Any]:
        with self._damage("an attribute"):
            attributes = self._file.attrs.items()
            return {k: v.item() if isinstance(v, np.generic) else v for k, v in attributes}

    def describe(self, name: str) -> Dataset:
        with self._damage(f"dataset {name}"):
            dataset, flags = self._file[name], None
            is_text, attrs = dataset.dtype.kind in "OS", dataset.attrs
            if "flag_values" in attrs:
                words = attrs["flag_meanings"].split(" ")
                flags = dict(zip(words, attrs["flag_values"].tolist(), strict=True))
            dims = [name] if dataset.is_scale else [dim[0].name[1:] for dim in dataset.dims]
            kind = "str" if is_text else str(dataset.dtype)
            fill = "" if is_text else dataset.fillvalue.item()
            units, meaning = str(attrs["units"]), str(attrs["long_name"])
            return Dataset(name, tuple(dims), kind, units, meaning, fill, flags)

    def shape(self, name: str) -> tuple[int, ...]:
        return tuple(self._file[name].shape)

    def values(self, name: str, where: tuple[int | slice, ...]) -> np.ndarray:
        with self._damage(f"dataset {name}"):
            dataset = self._file[name]
            return dataset.asstr()[where] if dataset.dtype.kind in "OS" else dataset[where]

    def close(self) -> None:
        self._file.close()


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


# ---- any other HDF5 file -------------------------------------------------------------------------


def columns(path: Path) -> list[tuple[str, str]]:
    """Return name and `units` of the numeric datasets of one dimension in any HDF5 file."""
    with _any_hdf5(path) as file:
        entries = ((name, file.get(name)) for name in file)  # None: a link to nowhere
        flat = [(name, e) for name, e in entries if getattr(e, "ndim", None) == 1]
        units = [(name, e.attrs.get("units", "")) for name, e in flat if e.dtype.kind in "iuf"]
        return [(n, u.decode() if isinstance(u, bytes) else str(u)) for n, u in units]


def column(path: Path, name: str, most: int) -> np.ndarray:
    """Return the numbers of a column; refuse it if it or one chunk holds more than `most`."""
    with _any_hdf5(path) as file:
        size = max(file[name].size, *(file[name].chunks or (0,)))
        if size <= most:
            return np.asarray(file[name][...], dtype=np.float64)
    raise RequestError(f"{path}: dataset {name!r} holds {size} numbers; allowed: up to {most}")


@contextmanager
def _any_hdf5(path: Path) -> Iterator[h5py.File]:
    """Open any HDF5 file; raise `RequestError`, one line, if it cannot be read in the block."""
    import h5py

    try:
        open_regular(path).close()
        with h5py.File(path, "r") as file:
            refuse_links(path, file)
            yield file
    except RequestError:
        raise
    except _DAMAGE as error:
        raise RequestError(f"{path}: cannot be read as HDF5: {_first_line(error)}") from None


def refuse_links(path: Path, file: h5py.File) -> None:
    """Raise `RequestError` unless every dataset of an HDF5 file lies in the file itself.

    An external link, a virtual dataset or external storage lets HDF5 open any file of the user,
    whose content would then be shown and stored, or a pipe, for which it would wait for ever.
    Nothing is opened here that could do so: links are looked at before they are followed.
    """
    import h5py

    words = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "an external link"}
    groups = [h5py.h5g.open(file.id, b"/")]
    visited = {h5py.h5o.get_info(groups[0]).addr}
    while groups:
        group = groups.pop()
        for name in group:
            kind = group.links.get_info(name).type
            if kind != h5py.h5l.TYPE_HARD:
                raise _leads_away(path, name, words.get(kind, "a link of a foreign kind"))
            entry = h5py.h5o.open(group, name)
            address = h5py.h5o.get_info(entry).addr
            if address in visited:
                continue
            visited.add(address)
            if isinstance(entry, h5py.h5g.GroupID):
                groups.append(entry)
            elif isinstance(entry, h5py.h5d.DatasetID):
                creation = entry.get_create_plist()
                if creation.get_layout() == h5py.h5d.VIRTUAL:
                    raise _leads_away(path, name, "a virtual dataset")
                if creation.get_external_count():
                    raise _leads_away(path, name, "a dataset with external storage")


def _leads_away(path: Path, name: bytes, what: str) -> RequestError:
    return RequestError(
        f"{path}: {shown(name.decode('utf-8', 'replace'))} is {what}, which may lead to any file; "
        "allowed: datasets that lie in the file itself"
    )
