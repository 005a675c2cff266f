"""The table of an archive: datasets with type, unit and meaning; lengths of dimensions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import prod
from typing import NamedTuple

import numpy as np

TEXT_BYTES = 64
"""What a string counts for: more than any label with its reference needs."""


@dataclass(frozen=True)
class Dataset:
    """One dataset of an archive.

    `dims` are the names of its dimensions: the varied parameters, then `start`, then its tail
    (`cycle`, `component`).  `dtype` is a NumPy type name, or "str" for variable-length UTF-8.
    `fill` stands where nothing was computed.  `flags` maps the CF words of an enumeration to codes.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    fill: float | int | str
    flags: Mapping[str, int] | None = None

    @property
    def tail(self) -> tuple[str, ...]:
        """The dimensions after `start`: what one lane contributes."""
        return self.dims[self.dims.index("start") + 1 :]

    @property
    def flag_values(self) -> tuple[int, ...] | None:
        """The codes of an enumeration in the order of `flag_meanings`; None for anything else."""
        return None if self.flags is None else tuple(self.flags.values())

    @property
    def flag_meanings(self) -> str | None:
        """The words of an enumeration, blank-separated as CF has it; None for anything else."""
        return None if self.flags is None else " ".join(self.flags)


class Scale(NamedTuple):
    """A dimension: its values (one-dimensional; numbers or strings), their unit and meaning."""

    name: str
    values: np.ndarray
    units: str
    long_name: str


@dataclass(frozen=True)
class Table:
    """What an archive holds: its datasets by name, the length of every dimension there may be."""

    datasets: Mapping[str, Dataset]
    length: Mapping[str, int]

    @classmethod
    def of(cls, datasets: Iterable[Dataset], length: Mapping[str, int]) -> Table:
        """Return the table of some datasets; of those with one name the last counts."""
        return cls({dataset.name: dataset for dataset in datasets}, length)

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the shape of a dataset."""
        return tuple(self.length[dim] for dim in self.datasets[name].dims)

    def bytes(self, text: int = TEXT_BYTES) -> int:
        """Return how many bytes all datasets take uncompressed; a string counts for `text`."""
        return sum(
            (text if dataset.dtype == "str" else np.dtype(dataset.dtype).itemsize)
            * prod(self.shape(name))
            for name, dataset in self.datasets.items()
        )

    @property
    def most_bytes(self) -> int:
        """How many bytes the archive takes, its dimensions included, were nothing compressed."""
        return self.bytes() + TEXT_BYTES * sum(self.length.values())
