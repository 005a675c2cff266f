"""Archives: written once and whole, in memory or as an HDF5 file, and read by name."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from nlds_vines.archives import hdf5
from nlds_vines.archives.contents import Contents, InMemory, Piece
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import parse_toml, write_csv
from nlds_vines.archives.provenance import SCHEMA, Value
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, at, choice, library, number, shown, unknown
from nlds_vines.errors import whole as whole_number

Read = TypeVar("Read")

_COMPONENT = "component"  # the dimension whose values, x1, v1, x2, v2, become columns of a table
OWNERS = ("displacement", "damper")  # those whose values own quantities: columns are roof.x_max
_ENERGY_OF_HOST = "host.E_max"  # the paper calls it E1max


def write(
    path: Path,
    table: Table,
    scales: Iterable[Scale],
    pieces: Iterable[Piece],
    attributes: Callable[[], Mapping[str, Value]],
) -> None:
    """Write an archive to `path` as `hdf5.write` does; without a name it stays in memory."""
    if isinstance(path, ArchivePath) and path.unnamed is not None:
        path.unnamed.contents = InMemory.of(table, scales, pieces, attributes)
    else:
        hdf5.write(path, table, scales, pieces, attributes)


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
    if path.unnamed is not None and path.unnamed.contents is not None:
        return ArchiveView(path, path.unnamed.contents)
    contents = hdf5.InFile(path)
    try:
        _refuse_foreign(path, contents)
    except RequestError:
        contents.close()
        raise
    return ArchiveView(path, contents)


def _refuse_foreign(path: Path, contents: Contents) -> None:
    """Raise `RequestError` unless this is an archive of this program and this format."""
    attributes = contents.attributes()
    if "status" not in contents or not {"schema", "scan_hash"} <= {*attributes}:
        raise RequestError(f"{path} is not an archive of nlds_vines")
    schema = attributes["schema"]
    if schema != SCHEMA:
        raise RequestError(f"{path} has schema {schema}: this version reads {SCHEMA}")


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

    def __init__(self, path: ArchivePath, contents: Contents) -> None:
        self.path = path
        self.names = contents.names
        self._open: Contents | None = contents
        self._entries: dict[str, Dataset] = {}

    @property
    def _contents(self) -> Contents:
        """What it is read from; `RequestError` once it is closed."""
        if self._open is None:
            raise RequestError(f"{self.path} is closed: nlds_vines.read opens it")
        return self._open

    def __enter__(self) -> ArchiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; what was read stays."""
        if self._open is not None:
            self._open.close()
            self._open = None

    def heading(self) -> str:
        place = f"{self.path}: " if self.path.named else ""
        return place + self.text("title") if self._open is not None else f"{self.path}, closed"

    def outline(self) -> Rows:
        if self._open is not None:
            dims = dict.fromkeys(dim for name in self.names for dim in self.dims(name))
            yield "dimensions", ", ".join(dims)
            yield "datasets", ", ".join(self.names)

    def __contains__(self, name: object) -> bool:
        """Return True if a dataset or a scale of this name is in the archive."""
        return isinstance(name, str) and name in self._contents

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a whole dataset or scale; strings as an array of `str` objects."""
        return self.take(name)

    def _owned(self, name: str) -> tuple[str, dict[str, int]]:
        """Return the dataset that a name means, and the place of its owner, if it names one."""
        owner, dot, quantity = str(name).rpartition(".")  # what is no name is refused later
        if not dot or name in self:
            return name, {}
        if name == _ENERGY_OF_HOST:
            return "E1max", {}
        dataset = "E2max" if quantity == "E_max" else quantity
        dims = self.dims(dataset) if dataset in self else ()
        for dim in {*OWNERS} & {*dims}:
            owners = self[dim].tolist()
            if owner not in owners:
                raise unknown(f"{dim} of {name}:", owner, owners)
            return dataset, {dim: owners.index(owner)}
        return name, {}

    def take(self, name: str, **index: int | slice) -> np.ndarray:
        """Return part of a dataset.

        Parameters
        ----------
        name : str
            A dataset or scale.  `roof.x_max` is the part of x_max that the roof owns, and likewise
            of dampers; `host.E_max` is E1max, and `cell.E_max` the cell's part of E2max.
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
        name, place = self._owned(name)
        entry, shape = self.describe(name), self.shape(name)
        where: dict[str, int | slice] = dict.fromkeys(entry.dims, slice(None))
        for dim, i in {**index, **place}.items():
            if dim not in entry.dims:
                raise unknown(f"dimension of {name}:", dim, entry.dims)
            if not isinstance(i, slice):
                length = shape[entry.dims.index(dim)]
                i = whole_number(f"{dim} of {name}", i, -length, length - 1)
            where[dim] = i
        return self._contents.values(name, tuple(where[dim] for dim in entry.dims))

    def sel(self, **values: float | str) -> dict[str, np.ndarray]:
        """Return the part of all datasets at values of dimensions.

        Parameters
        ----------
        **values : float or str
            A value for each dimension to select from: one of its names, as in `start="up"`, or a
            number within its range, which means the nearest one there.

        Returns
        -------
        dict of str to numpy.ndarray
            The datasets by name without these dimensions; those without any of them are whole.

        Raises
        ------
        RequestError
            For an unknown dimension, a number outside of its range, or an unknown name.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> vary = {"omega": {"values": [6.0, 6.5]}}
        >>> scan = nv.scan("tmd", vary=vary, record=["energy"], start="both", quiet=True)
        >>> part = scan.sel(omega=6.4, start="up")
        >>> part["E1max"].round(1).tolist()
        413.8
        """
        dims = dict.fromkeys(dim for name in self.names for dim in self.dims(name))
        places: dict[str, int] = {}
        for dim, value in values.items():
            if dim not in dims:
                raise unknown(f"dimension of {self.path}:", dim, dims)
            places[dim] = _place(dim, self[dim], value)
        parts: dict[str, np.ndarray] = {}
        for name in self.names:
            own = {dim: place for dim, place in places.items() if dim in self.dims(name)}
            parts[name] = self.take(name, **own)
        return parts

    @cached_property
    def attrs(self) -> dict[str, Any]:
        """The attributes of the file: title, history, request, parameters, versions ..."""
        return self._contents.attributes()

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

        They are the varied parameters, `sample`, or `system` and the parameter.
        """
        return self.dims("status")[:-1]

    def request(self, content: str, load: Callable[[dict[str, Any]], Read]) -> Read:
        """Return the archive's request, made by `load` from the stored TOML.

        Raises `RequestError` if the archive's content is not `content`.
        """
        known: Any = None
        if self.path.unnamed is not None:
            known = self.path.unnamed.request
        # a request in memory tells its content, so that no attributes need be made
        held = self.content if known is None else known.content
        if held != content:
            raise RequestError(f"{self.path} holds a {held}, not a {content}")
        if known is not None:
            request: Read = known
            return request
        with at(f"{self.path}: its request"):
            return load(parse_toml(self.text("scan"), "the attribute scan"))

    def describe(self, name: str) -> Dataset:
        """Return the description of a dataset or scale: dimensions, type, unit, meaning, fill."""
        if name not in self:
            raise unknown(f"dataset of {self.path}:", name, self.names)
        if name not in self._entries:
            self._entries[name] = self._contents.describe(name)
        return self._entries[name]

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the lengths of a dataset's dimensions."""
        return self._contents.shape(self.describe(name).name)

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
            Dataset names; by default all with one value for each orbit, displacement or damper, and
            the parameters of samples.  Or one dimension other than those of a scan's cells,
            "points" of branches, "special" points, "optimum": all datasets along it.

        Returns
        -------
        pandas.DataFrame
            The varied parameters and the start, then the datasets: enumerations as words, `section`
            as x1, v1, x2, v2 with a row for each period, quantities of displacements and dampers as
            roof.x_max, cell.E2max.  Along a dimension, arrays have a column
            for each entry: state_x1, multipliers_1_real.  `attrs` holds the units.

        Raises
        ------
        RequestError
            If the dimensions of the datasets do not fit one table, or a dataset does not exist.
        """
        frame = library("pandas").DataFrame(self._columns(names))
        units = {}
        for column in frame.columns:
            dataset, _ = self._owned(column)
            if dataset in self:
                units[column] = self.units(dataset)
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
        if len(names) == 1 and (along := self._dimension(names[0])):
            return self._columns_along(along)
        dims = self.dims("status")
        if not names:  # of random sets, the parameters of each set first
            columns_of_sets = [name for name in self.names if self.dims(name) == ("sample",)]
            of_owners = [(*dims, owner) for owner in OWNERS]
            others = [name for name in self.names if self.dims(name) in (dims, *of_owners)]
            names = (*dict.fromkeys([*columns_of_sets, *others]),)
        owned = {name: self._owned(name) for name in names}
        longest = max((self.dims(dataset) for dataset, _ in owned.values()), key=len)
        of_columns = {_COMPONENT, *OWNERS}
        rows = tuple(dim for dim in longest if dim not in of_columns)
        grid = np.meshgrid(*(self[dim] for dim in rows), indexing="ij")
        columns = {dim: values.ravel() for dim, values in zip(rows, grid, strict=True)}
        for column, (name, place) in owned.items():
            dims = self.dims(name)
            if not {*dims} <= {*rows, *of_columns}:
                raise RequestError(
                    f"{name} has the dimensions {', '.join(dims)}: it cannot stand in a table over "
                    f"{', '.join(rows)}; take it alone"
                )
            wide = tuple(slice(None) if dim in dims else np.newaxis for dim in rows)
            for heading, part in self._parts(column, name, place).items():
                columns[heading] = np.broadcast_to(part[wide], grid[0].shape).ravel()
        return columns

    def _parts(self, column: str, name: str, place: Mapping[str, int]) -> dict[str, np.ndarray]:
        """Return the columns of a dataset by their headings, without components and owners.

        It is asked for as `column`, and of one owner if that has a `place` in its dimension.
        """
        values = self[name]
        dims = self.dims(name)
        if words := self.flags(name):
            values = _in_words(values, words)
        for dim in {*OWNERS} & {*dims}:
            last = np.moveaxis(values, dims.index(dim), -1)
            if place:
                return {column: last[..., place[dim]]}
            return {f"{owner}.{name}": last[..., i] for i, owner in enumerate(self[dim])}
        if _COMPONENT in dims:
            last = np.moveaxis(values, dims.index(_COMPONENT), -1)
            prefix = "" if name == "section" else f"{name}_"
            return {f"{prefix}{part}": last[..., i] for i, part in enumerate(self[_COMPONENT])}
        return {column: values}

    def _dimension(self, word: str) -> str:
        """Return the dimension that a word names, "point" or "points"; "" for any other word.

        Dimensions of a scan's cells are left out, as their datasets extend along the others, too.
        """
        of_cells = {*self.axes, "start"}
        if word in self.names:
            return ""
        for name in (word, word.removesuffix("s"), word.removesuffix("es")):
            if name in self and name not in of_cells and self.dims(name) == (name,):
                return name
        return ""

    def _columns_along(self, along: str) -> dict[str, np.ndarray]:
        """Return the columns of all datasets whose first dimension this is."""
        columns = {along: self[along]}
        for name in self.names:
            first, *others = self.dims(name)
            if first != along:
                continue
            values, words = self[name], self.flags(name)
            if words:
                values = _in_words(values, words)
            for place in np.ndindex(values.shape[1:]):
                entries = [self[dim][i] for dim, i in zip(others, place, strict=True)]
                column = "_".join([name, *map(str, entries)])
                columns[column] = values[(slice(None), *place)]
        return columns


def _place(dim: str, scale: np.ndarray, value: object) -> int:
    """Return the place of a value in a dimension: of a name, or of the nearest number."""
    if scale.dtype == object:
        names = scale.tolist()
        return names.index(choice(dim, value, names))
    wanted = number(dim, value)
    low, high = float(scale.min()), float(scale.max())
    slack = 1e-9 * max(abs(low), abs(high))
    if not low - slack <= wanted <= high + slack:
        raise RequestError(f"{dim} = {wanted:g} lies outside {low:g} to {high:g}")
    return int(np.abs(scale - wanted).argmin())


def _in_words(values: np.ndarray, words: Mapping[int, str]) -> np.ndarray:
    """Return codes of an enumeration as words, without what follows a period in them."""
    short = {code: word.partition(".")[0] for code, word in words.items()}
    inside = np.vectorize(short.get, otypes=[object])
    return np.asarray(inside(values))


# ---- paths of archives ---------------------------------------------------------------------------


class Unnamed:
    """An archive without a name: in memory, and in a temporary file once its path is used."""

    def __init__(self, stem: str, contents: InMemory | None = None) -> None:
        folder = Path(tempfile.gettempdir(), f"nlds_vines-{secrets.token_hex(8)}")
        self.path = folder / f"{stem}.h5"
        self.contents = contents
        self.request: Any = None  # that of the archive, unless it has been pickled

    def file(self) -> str:
        """Return the path of the file, which is removed with the last reference to this object."""
        if self.contents is not None and not self.path.exists():
            self.path.parent.mkdir(mode=0o700)
            weakref.finalize(self, shutil.rmtree, self.path.parent, ignore_errors=True)
            hdf5.write_contents(self.path, self.contents)
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
    def _in_memory(cls, stem: str, contents: InMemory | None = None) -> ArchivePath:
        unnamed = Unnamed(stem, contents)
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

    def sel(self, **values: float | str) -> dict[str, np.ndarray]:
        """Return the part of all datasets at values of dimensions, see `ArchiveView.sel`."""
        with self.read() as view:
            return view.sel(**values)

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
        return self._in_memory, (self.stem, self.unnamed.contents)
