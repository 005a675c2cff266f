"""The HDF5 archive: written once and whole, read by name.

Only this module imports h5py, and only inside functions: `--help` does not wait for it.

The layout is that of netCDF-4: every dimension of every dataset has its scale attached, so that
`xarray.open_dataset(FILE, engine="h5netcdf")` opens it.  Every dataset has HDF5's Fletcher-32
checksum; strings have a fixed length, as the checksum does not cover strings of variable length.
HDF5's metadata carry checksums of their own.  So damage is an error where it is read.
"""

from __future__ import annotations

import io
import math
import os
import secrets
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import open_regular, parse_toml, write_csv
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, at, library, shown, unknown
from nlds_vines.errors import whole as whole_number

if TYPE_CHECKING:
    import h5py

# name of a dataset, a rectangle of its cells, values
Piece = tuple[str, tuple[slice, ...], np.ndarray]
Read = TypeVar("Read")

# the errors that h5py raises for damaged files
_DAMAGE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)
_CHUNK_BYTES = 1 << 18  # small enough to read a few cells, large enough to compress and to seek
_OVERHEAD = 1 << 19  # bytes for headers, attributes and what HDF5 leaves unused
_COMPONENT = "component"  # the dimension whose values, x1, v1, x2, v2, become columns of a table


# ---- writing -------------------------------------------------------------------------------------


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path` and force it to the disk; without a name it stays in memory.

    The `pieces` of results come in any order; cells without a piece have their fill value.  The
    `attributes` are made after the last piece.  While a file is written, one numeric piece is in
    memory at a time, and all strings: the longest sets their stored length.
    """
    import h5py

    unnamed = path.unnamed if isinstance(path, ArchivePath) else None
    target: Any = path if unnamed is None else io.BytesIO()
    if unnamed is None:
        with path.open("wb") as trial:  # check that there is room: HDF5 may crash if the disk fills
            if hasattr(os, "posix_fallocate"):  # not on every system
                os.posix_fallocate(trial.fileno(), 0, table.most_bytes + _OVERHEAD)
    used = {dim for entry in table.datasets.values() for dim in entry.dims}
    # v110 checksums the metadata; pieces need not end where chunks do, so that half-written chunks
    # wait in a cache of 64 MiB with a prime number of slots
    how = {"libver": ("v110", "v110"), "rdcc_nbytes": 1 << 26, "rdcc_nslots": 10007}
    with h5py.File(target, "w", **how) as file:
        for scale in scales:
            if scale.name in used:
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
    if unnamed is not None:
        unnamed.image = target.getvalue()
        return
    with path.open("rb") as written:
        os.fsync(written.fileno())


def whole(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield each dataset as one piece; numbers are converted to its type."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored


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


def read(path: str | os.PathLike[str]) -> ArchiveView:
    """Open an archive for reading, with or without a `with` statement.

    Datasets are read from the disk when they are asked for.

    Parameters
    ----------
    path : str or os.PathLike
        The archive (.h5).

    Returns
    -------
    ArchiveView
        The open archive: datasets by name, `attrs`, `dims`, `units`, `take`, `to_csv`,
        `to_dataframe`, `to_xarray`.

    Raises
    ------
    RequestError
        If the file does not exist, is not an archive of this program, or has a format that this
        version does not know.

    See Also
    --------
    open_archive : The results as the function that computed them returned them.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> vary = {"omega": {"values": [6.0, 6.4]}}
    >>> scan = nv.scan("ssul-set6", vary=vary, sampling={"transient": 100}, quiet=True)
    >>> with nv.read(scan) as archive:
    ...     print(archive.dims("E1max"), archive["E1max"].round(2).ravel(), archive.units("E1max"))
    ('omega', 'start') [140.4  105.79] J
    """
    if not isinstance(path, str | os.PathLike):
        raise RequestError(f"archive = {shown(path)} must be the path of a file")
    path = ArchivePath.of(path)
    source: Any = path
    try:
        if path.unnamed is not None and path.unnamed.image is not None:
            source = io.BytesIO(path.unnamed.image)
        else:
            open_regular(path).close()  # HDF5 would wait for a pipe
    except FileNotFoundError:
        raise RequestError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path} cannot be opened: {reason}") from error
    import h5py

    try:
        file = h5py.File(source, "r")
        refuse_links(path, file)
        return ArchiveView(path, file)
    except RequestError:
        file.close()
        raise
    except _DAMAGE as error:
        text = "it is no HDF5 file, damaged, or not readable"
        raise RequestError(f"{path} cannot be opened: {text}") from error


class ArchiveView(Outlined):
    """An open archive; its datasets are read from the disk when they are asked for.

    `view["section"]` is the whole array, `view.take("section", start=0, component=2)` a part of
    it.  It is closed at the end of a `with` block, by `close`, or when nothing refers to it any
    more.

    Attributes
    ----------
    path : ArchivePath
        The path of the file.
    names : tuple of str
        The names of the recorded datasets, without the scales of their dimensions.

    Raises
    ------
    RequestError
        For a damaged dataset, with its name, when it is read.
    """

    def __init__(self, path: ArchivePath, file: h5py.File) -> None:
        """Raise `RequestError` unless `file` is an archive of this program and this format."""
        self.path, self._file = path, file
        schema = file.attrs.get("schema")
        if schema is None or "scan_hash" not in file.attrs or "status" not in file:
            raise RequestError(f"{path} is not an archive of nlds_vines")
        if schema != SCHEMA:
            raise RequestError(f"{path} has schema {schema}: this version reads {SCHEMA}")
        self.names = tuple(name for name in file if not file[name].is_scale)
        self._entries: dict[str, Dataset] = {}

    def __enter__(self) -> ArchiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; what was read stays."""
        self._file.close()

    def heading(self) -> str:
        place = f"{self.path}: " if self.path.named else ""
        return place + self.text("title") if self._file else f"{self.path}, closed"

    def outline(self) -> Rows:
        if self._file:
            dims = dict.fromkeys(dim for name in self.names for dim in self.dims(name))
            yield "dimensions", ", ".join(dims)
            yield "datasets", ", ".join(self.names)

    def __contains__(self, name: object) -> bool:
        """Return True if a dataset or a scale of this name is in the archive."""
        return isinstance(name, str) and name in self._file

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a whole dataset or scale; strings as an array of `str` objects."""
        return self.take(name)

    def take(self, name: str, **index: int | slice) -> np.ndarray:
        """Return part of a dataset.

        Parameters
        ----------
        name : str
            A dataset or scale.
        **index : int or slice
            An integer or a slice for each dimension to select from, by name; all of the others.

        Returns
        -------
        numpy.ndarray
            The values; a dimension with an integer is dropped.

        Raises
        ------
        RequestError
            For an unknown dataset or dimension, an integer out of range, or a damaged dataset.
        """
        entry, shape = self.describe(name), self.shape(name)
        for dim, i in index.items():
            if dim not in entry.dims:
                raise unknown(f"dimension of {name}:", dim, entry.dims)
            if not isinstance(i, slice):
                length = shape[entry.dims.index(dim)]
                index[dim] = whole_number(f"{dim} of {name}", i, -length, length - 1)
        return self._values(entry, tuple(index.get(dim, slice(None)) for dim in entry.dims))

    def _values(self, entry: Dataset, where: tuple[int | slice, ...]) -> np.ndarray:
        with self._damage(f"dataset {entry.name}"):
            dataset = self._file[entry.name]
            return dataset.asstr()[where] if entry.dtype == "str" else dataset[where]

    @cached_property
    def attrs(self) -> dict[str, Any]:
        """The attributes of the file: title, history, request, parameters, versions ..."""
        with self._damage("an attribute"):
            attributes = self._file.attrs.items()
            return {k: v.item() if isinstance(v, np.generic) else v for k, v in attributes}

    @contextmanager
    def _damage(self, place: str) -> Iterator[None]:
        """Turn h5py's error for a damaged file into a `RequestError` that names the place."""
        try:
            yield
        except _DAMAGE as error:
            reason = _first_line(error)
            raise RequestError(f"{self.path}: {place} is damaged: {reason}") from error

    def text(self, name: str) -> str:
        """Return an attribute of the file that is a text: `title`, `scan`, `scan_hash`."""
        return str(self.attrs[name])

    @property
    def content(self) -> str:
        """The kind of request whose results it holds: `scan`, `tuning`, `portrait`."""
        return str(self.attrs.get("content", "scan"))

    @property
    def axes(self) -> tuple[str, ...]:
        """The dimensions of `status` but the last, which is `start` in scans and response curves.

        They are the varied parameters, `sample`, or `case` and the parameter.
        """
        return self.dims("status")[:-1]

    def request(self, content: str, load: Callable[[dict[str, Any]], Read]) -> Read:
        """Return the archive's request, made by `load` from the stored TOML.

        Raises `RequestError` if the archive's content is not `content`.
        """
        if self.content != content:
            raise RequestError(f"{self.path} holds a {self.content}, not a {content}")
        if self.path.unnamed is not None and self.path.unnamed.request is not None:
            request: Read = self.path.unnamed.request
            return request
        with at(f"{self.path}: its request"):
            return load(parse_toml(self.text("scan"), "the attribute scan"))

    def describe(self, name: str) -> Dataset:
        """Return the description of a dataset or scale: dimensions, type, unit, meaning, fill."""
        if name not in self:
            raise unknown(f"dataset of {self.path}:", name, self.names)
        if name not in self._entries:
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
                entry = Dataset(name, tuple(dims), kind, units, meaning, fill, flags)
                self._entries[name] = entry
        return self._entries[name]

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the lengths of a dataset's dimensions."""
        return tuple(self._file[self.describe(name).name].shape)

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of a dataset's dimensions."""
        return self.describe(name).dims

    def units(self, name: str) -> str:
        """Return the units of a dataset or scale."""
        return self.describe(name).units

    def long_name(self, name: str) -> str:
        """Return the meaning of a dataset or scale, in words."""
        return self.describe(name).long_name

    def flags(self, name: str) -> dict[int, str]:
        """Return the words of an enumeration by their codes; empty for any other dataset."""
        return {code: word for word, code in (self.describe(name).flags or {}).items()}

    def to_xarray(self) -> Any:
        """Return all of it as an `xarray.Dataset`, in memory; needs the extra `xarray`."""
        with library("xarray").open_dataset(
            os.fspath(self.path), engine="h5netcdf", decode_times=False
        ) as dataset:
            return dataset.load()

    def to_dataframe(self, *names: str) -> Any:
        """Return datasets as a `pandas.DataFrame`: one row for each orbit.

        Parameters
        ----------
        *names : str
            Dataset names; by default all with one value for each orbit, and the parameters of
            samples.

        Returns
        -------
        pandas.DataFrame
            The varied parameters and the start, then the datasets: enumerations as words, `section`
            as x1, v1, x2, v2 with a row for each period.  `attrs` holds the units.

        Raises
        ------
        RequestError
            If the dimensions of the datasets do not fit one table, or a dataset does not exist.
        """
        frame = library("pandas").DataFrame(self._columns(names))
        units = {name: self.units(name) for name in frame.columns if name in self}
        frame.attrs = {"title": self.text("title"), "units": units}
        return frame

    def to_csv(self, path: str | os.PathLike[str], *names: str, overwrite: bool = False) -> None:
        """Write datasets as comma-separated values, in the rows and columns of `to_dataframe`.

        Parameters
        ----------
        path : str or os.PathLike
            The file to write.
        *names : str
            Dataset names, as in `to_dataframe`.
        overwrite : bool
            Whether a file of this name is replaced; an archive never is.

        Raises
        ------
        RequestError
            If the file exists and is not to be replaced, or cannot be written; for datasets that
            `to_dataframe` refuses.
        """
        columns = self._columns(names)
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        write_csv(path, chain([columns], rows), overwrite)

    def _columns(self, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Return the columns of a table by name: first the dimensions, then the datasets."""
        dims = self.dims("status")
        if not names:  # of random sets, the parameters of each set first
            columns_of_sets = [name for name in self.names if self.dims(name) == ("sample",)]
            others = [name for name in self.names if self.dims(name) == dims]
            names = (*dict.fromkeys([*columns_of_sets, *others]),)
        longest = max((self.dims(name) for name in names), key=len)
        rows = tuple(dim for dim in longest if dim != _COMPONENT)
        grid = np.meshgrid(*(self[dim] for dim in rows), indexing="ij")
        columns = {dim: values.ravel() for dim, values in zip(rows, grid, strict=True)}
        for name in names:
            dims, values, words = self.dims(name), self[name], self.flags(name)
            if not {*dims} <= {*rows, _COMPONENT}:
                raise RequestError(
                    f"{name} has the dimensions {', '.join(dims)}: it cannot stand in a table over "
                    f"{', '.join(rows)}; take it alone"
                )
            if words:
                short = {code: word.partition(".")[0] for code, word in words.items()}
                values = np.vectorize(short.get, otypes=[object])(values)
            parts = {name: values}
            if _COMPONENT in dims:
                last, prefix = np.moveaxis(values, dims.index(_COMPONENT), -1), f"{name}_"
                parts = {
                    f"{prefix * (name != 'section')}{part}": last[..., i]
                    for i, part in enumerate(self[_COMPONENT])
                }
            wide = tuple(slice(None) if dim in dims else np.newaxis for dim in rows)
            for column, part in parts.items():
                columns[column] = np.broadcast_to(part[wide], grid[0].shape).ravel()
        return columns


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


# ---- paths of archives ---------------------------------------------------------------------------


class Unnamed:
    """An archive without a name: in memory, and in a temporary file once its path is used."""

    def __init__(self, stem: str, image: bytes | None = None) -> None:
        folder = Path(tempfile.gettempdir(), f"nlds_vines-{secrets.token_hex(8)}")
        self.path, self.image = folder / f"{stem}.h5", image
        self.request: Any = None  # that of the archive, unless it has been pickled

    def file(self) -> str:
        """Return the path of the file, which is removed with the last reference to this object."""
        if self.image is not None and not self.path.exists():
            self.path.parent.mkdir(mode=0o700)
            weakref.finalize(self, shutil.rmtree, self.path.parent, ignore_errors=True)
            self.path.write_bytes(self.image)
        return str(self.path)


class ArchivePath(type(Path())):  # type: ignore[misc]  # the concrete class: Path alone is abstract
    """The path of an archive; it can be used like any other path.

    An archive without a name (no `to=`) is in memory.  If something opens its path, it is written
    to a temporary file, which is removed with the last path that refers to it.  Pickling such a
    path includes the content of the archive.
    """

    unnamed: Unnamed | None = None

    @classmethod
    def of(cls, path: str | os.PathLike[str]) -> ArchivePath:
        result = cls(path)
        result.unnamed = getattr(path, "unnamed", None)
        return result

    @classmethod
    def for_result(
        cls, to: str | os.PathLike[str] | None, stem: str, *options: bool
    ) -> ArchivePath:
        """Return the path `to`, or one in memory; `options`, resume and overwrite, need `to`."""
        if isinstance(to, str | os.PathLike):
            return cls.of(to)
        if to is not None:
            raise RequestError(f"to = {shown(to)} must be the path of an archive (.h5)")
        if any(option is True for option in options):  # anything else is refused as no truth
            raise RequestError("resume and overwrite belong to an archive: name it by to=")
        return cls._in_memory(stem)

    @classmethod
    def _in_memory(cls, stem: str, image: bytes | None = None) -> ArchivePath:
        unnamed = Unnamed(stem, image)
        result = cls(unnamed.path)
        result.unnamed = unnamed
        return result

    def __fspath__(self) -> str:
        return str(self) if self.unnamed is None else self.unnamed.file()

    @property
    def named(self) -> ArchivePath | None:
        """The path itself; None for an archive without a name."""
        return self if self.unnamed is None else None

    def read(self) -> ArchiveView:
        """Open it, as `nlds_vines.read` does."""
        return read(self)

    def to_xarray(self) -> Any:
        """Return all of it as an `xarray.Dataset` in memory, with units and flag meanings."""
        with self.read() as view:
            return view.to_xarray()

    def to_dataframe(self, *names: str) -> Any:
        """Return a `pandas.DataFrame`, by default of all datasets with one value for each orbit."""
        with self.read() as view:
            return view.to_dataframe(*names)

    def __reduce__(self) -> tuple[Any, ...]:
        if self.unnamed is None:
            return type(self), (str(self),)
        return self._in_memory, (self.stem, self.unnamed.image)


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
