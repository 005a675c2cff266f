"""The description of an archive: datasets with unit and meaning, and their dimensions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any, NamedTuple

import numpy as np

TEXT_BYTES = 64  # bytes that a string counts for: more than the label of any orbit takes


@dataclass(frozen=True)
class Dataset:
    """One dataset of an archive.

    Attributes:
        dims: the names of its dimensions: the varied parameters, then `start`, then the dimensions
            of a single orbit (`forcing_period`, `component`).
        dtype: the name of a NumPy type, or "str" for UTF-8 strings.
        units: SI, in the notation of CF; "1" for a number without a unit.
        fill: the value of cells that were not computed.
        flags: the codes of an enumeration by word, as in CF; None for any other dataset.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    fill: float | int | str
    flags: Mapping[str, int] | None = None

    @classmethod
    def real(
        cls, name: str, dims: tuple[str, ...], units: str, long_name: str, fill: float = math.nan
    ) -> Dataset:
        return cls(name, dims, "float64", units, long_name, fill)

    @classmethod
    def whole(cls, name: str, dims: tuple[str, ...], long_name: str, fill: int = 0) -> Dataset:
        return cls(name, dims, "int32", "1", long_name, fill)

    @classmethod
    def code(
        cls, name: str, dims: tuple[str, ...], long_name: str, flags: Mapping[str, int]
    ) -> Dataset:
        """Return an enumeration, whose fill value is the code 0."""
        return cls(name, dims, "int8", "1", long_name, 0, flags)

    @classmethod
    def text(cls, name: str, dims: tuple[str, ...], long_name: str) -> Dataset:
        return cls(name, dims, "str", "1", long_name, "")

    @property
    def memory_type(self) -> Any:
        """The type of its values in memory, where strings are objects."""
        return object if self.dtype == "str" else self.dtype

    @property
    def tail(self) -> tuple[str, ...]:
        """The dimensions after `start`: those of a single orbit."""
        return self.dims[self.dims.index("start") + 1 :]


class Scale(NamedTuple):
    """A dimension: its name, its values (n,), numbers or strings, their unit and meaning."""

    name: str
    values: np.ndarray
    units: str
    long_name: str

    @property
    def dataset(self) -> Dataset:
        """The description of the dataset that stores its values."""
        kind = "str" if self.values.dtype.kind in "OU" else str(self.values.dtype)
        fill = "" if kind == "str" else self.values.dtype.type(0).item()
        return Dataset(self.name, (self.name,), kind, self.units, self.long_name, fill)

    @classmethod
    def counted(cls, name: str, count: int, long_name: str, first: int = 0) -> Scale:
        return cls(name, np.arange(first, first + count, dtype=np.int32), "1", long_name)


@dataclass(frozen=True)
class Table:
    """The datasets of an archive, and lengths of dimensions, also of those that no dataset has."""

    datasets: Mapping[str, Dataset]
    length: Mapping[str, int]

    @classmethod
    def of(cls, datasets: Iterable[Dataset], length: Mapping[str, int]) -> Table:
        return cls({dataset.name: dataset for dataset in datasets}, length)

    @cached_property
    def dims(self) -> frozenset[str]:
        """The dimensions that a dataset has."""
        return frozenset(dim for entry in self.datasets.values() for dim in entry.dims)

    def shape(self, name: str) -> tuple[int, ...]:
        return tuple(self.length[dim] for dim in self.datasets[name].dims)

    def bytes(self, text: int = TEXT_BYTES) -> int:
        """Return the size of all datasets without compression [bytes]; a string takes `text`."""
        return sum(
            (text if dataset.dtype == "str" else np.dtype(dataset.dtype).itemsize)
            * prod(self.shape(name))
            for name, dataset in self.datasets.items()
        )

    @property
    def most_bytes(self) -> int:
        """An upper bound of the archive's uncompressed size [bytes], scales included."""
        return self.bytes() + TEXT_BYTES * sum(self.length.values())
