"""An open archive: datasets by name, attributes, dimensions; damage is told where it is met.

`archive.read` opens the HDF5 file and hands it over.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from nlds_vines.archives import frames
from nlds_vines.archives.dataset import Dataset, slabs
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.archives.toml import parse_toml
from nlds_vines.errors import RequestError, at, shown, unknown, whole

DAMAGE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)
"""The errors that h5py raises for damaged files."""

Read = TypeVar("Read")


@dataclass(frozen=True, repr=False)
class ArchiveView(Outlined):
    """An open archive; its datasets are read from the disk when they are asked for.

    `view["section"]` is the whole array, `view.take("section", start=0, component=2)` a part of
    it.  Reading a damaged dataset raises `RequestError` with its name.  It is closed at the end of
    a `with` block, by `close`, or when nothing refers to it any more.
    """

    path: Path
    _file: Any

    def __enter__(self) -> ArchiveView:
        """Return the archive, which the block's end closes."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def close(self) -> None:
        """Close the file; what was read stays."""
        self._file.close()

    def heading(self) -> str:
        """Return the file and the title."""
        return f"{self.path}: {self.text('title')}" if self._file else f"{self.path}, closed"

    def outline(self) -> Rows:
        """Return its dimensions and its datasets."""
        if self._file:
            dims = dict.fromkeys(dim for name in self.names for dim in self.dims(name))
            lengths = (f"{dim} ({self.shape(dim)[0]})" for dim in dims)
            yield "dimensions", ", ".join(lengths)
            yield "datasets", ", ".join(self.names)
            yield "made by", str(self.attrs.get("source", "unknown"))

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
        """The kind of request whose results it holds: `scan`, `tuning`, `portrait`."""
        return self.text("content") if "content" in self.attrs else "scan"

    def request(self, content: str, load: Callable[[dict[str, Any]], Read]) -> Read:
        """Return the request whose results it holds, which `load` makes of the file in it.

        Raises `RequestError` for a content other than this one.
        """
        if self.content != content:
            raise RequestError(f"{self.path} holds a {self.content}, not a {content}")
        with at(f"{self.path}: its request"):
            return load(parse_toml(self.text("scan"), "the attribute scan"))

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
        return isinstance(name, str) and name in self._file

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a whole dataset or scale; strings as an array of `str` objects."""
        return self.take(name)

    def take(self, name: str, **index: int) -> np.ndarray:
        """Return a part of a dataset: at the `index` of some dimensions, all of the others.

        Raises `RequestError` for a dataset or a dimension that there is not, and an index out of
        range.
        """
        dims = self.dims(name)
        for dim, i in index.items():
            if dim not in dims:
                raise unknown(f"dimension of {name}:", dim, dims)
            length = self.shape(dim)[0]
            index[dim] = whole(f"{dim} of {name}", i, -length, length - 1)
        where = tuple(index.get(dim, slice(None)) for dim in dims)
        with _reading(self.path, f"dataset {name}"):
            return values_of(self._dataset(name), where)

    def to_xarray(self) -> Any:
        """Return all of it as an `xarray.Dataset`, in memory; needs the extra `xarray`."""
        return frames.labeled(self)

    def to_pandas(self, *names: str) -> Any:
        """Return datasets as a `pandas.DataFrame`: one row for each orbit, its place in front.

        Arguments: `names` of datasets; none for all that have one value for each orbit.  Those of
        an enumeration come as words; `section` as x1, v1, x2, v2, a row for each period.
        """
        return frames.frame_of(self, names)

    def to_csv(self, path: str | os.PathLike[str], *names: str, overwrite: bool = False) -> None:
        """Write datasets as comma-separated values, in the rows and columns of `to_pandas`.

        Raises `RequestError` for a file that exists, unless `overwrite`, and always for an archive.
        """
        frames.write_csv(self, path, names, overwrite)

    def slabs(self, name: str) -> Iterator[np.ndarray]:
        """Yield a dataset in parts along its first dimension, each of which fits into memory."""
        with _reading(self.path, f"dataset {name}"):
            for slab in slabs(self.shape(name)):
                yield values_of(self._dataset(name), slab)

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the lengths of a dataset's dimensions."""
        with _reading(self.path, f"dataset {name}"):
            return tuple(self._dataset(name).shape)

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of a dataset's dimensions."""
        with _reading(self.path, f"dataset {name}"):
            dataset = self._dataset(name)
            if dataset.is_scale:
                return (name,)
            return tuple(dim[0].name.removeprefix("/") for dim in dataset.dims)

    def is_text(self, name: str) -> bool:
        """Return whether a dataset or scale holds strings."""
        with _reading(self.path, f"dataset {name}"):
            return is_text(self._dataset(name))

    def describe(self, name: str) -> Dataset:
        """Return what a dataset is: its dimensions, type, unit, meaning and fill value."""
        flags = self.flags(name) if self.is_flag(name) else None
        kind = "str" if self.is_text(name) else str(self._file[name].dtype)
        fill = "" if kind == "str" else self._file[name].fillvalue.item()
        about = self.units(name), self.long_name(name), fill
        codes = None if flags is None else {word: code for code, word in flags.items()}
        return Dataset(name, self.dims(name), kind, *about, codes)

    def units(self, name: str) -> str:
        """Return the units of a dataset or scale."""
        return str(self._attribute(name, "units"))

    def long_name(self, name: str) -> str:
        """Return the meaning of a dataset or scale, in words."""
        return str(self._attribute(name, "long_name"))

    def is_flag(self, name: str) -> bool:
        """Return whether a dataset is an enumeration, whose words `flags` returns."""
        with _reading(self.path, f"dataset {name}"):
            return "flag_values" in self._dataset(name).attrs

    def flags(self, name: str) -> dict[int, str]:
        """Return the words of an enumeration by their codes."""
        with _reading(self.path, f"the enumeration of dataset {name}"):
            notes = self._dataset(name).attrs
            return flags_of({key: _plain(notes[key]) for key in notes if key.startswith("flag_")})

    def _attribute(self, name: str, attribute: str) -> Any:
        with _reading(self.path, f"dataset {name}"):
            return _plain(self._dataset(name).attrs[attribute])

    def _dataset(self, name: str) -> Any:
        """Return a dataset or scale of the file; `RequestError` for one that was not recorded."""
        if name not in self:
            raise unknown(f"dataset of {self.path}:", name, self.names)
        return self._file[name]


@contextmanager
def _reading(path: Path, what: str) -> Iterator[None]:
    """Turn h5py's error for a damaged file into a `RequestError` that names the place."""
    try:
        yield
    except RequestError:
        raise
    except DAMAGE as error:
        raise RequestError(f"{path}: {what} is damaged: {first_line(error)}") from error


def first_line(error: Exception) -> str:
    """Return the first line of an error's message, or the error's name if it has none."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def values_of(dataset: Any, where: Any) -> np.ndarray:
    """Return a part of a dataset; strings as an array of `str` objects."""
    return dataset.asstr()[where] if is_text(dataset) else dataset[where]


def is_text(dataset: Any) -> bool:
    """Return whether a dataset of an archive, which holds numbers or strings, holds strings."""
    return dataset.dtype.kind in "OS"


def _plain(value: Any) -> Any:
    """Return an attribute as a Python number or string; what is no UTF-8 in it is replaced."""
    if isinstance(value, str):
        return value.encode(errors="surrogateescape").decode(errors="replace")
    return value.item() if isinstance(value, np.generic) else value


def flags_of(attributes: Mapping[str, Any]) -> dict[int, str]:
    """Return the words of an enumeration by their codes, from the attributes of its dataset.

    Raises ValueError, or what HDF5 raises, where they do not belong together.
    """
    codes, meanings = np.asarray(attributes["flag_values"]), attributes["flag_meanings"]
    if codes.ndim != 1 or codes.dtype.kind not in "iu":
        raise ValueError("its codes are no whole numbers")
    words = meanings.split(" ") if isinstance(meanings, str) else []
    if len(words) != len(codes):
        raise ValueError(f"it has {len(codes)} codes, but {len(words)} words")
    return dict(zip(map(int, codes), words, strict=True))
