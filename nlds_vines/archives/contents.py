"""What an archive holds: described arrays and attributes by name, in memory or in a file.

`nlds_vines.archives.hdf5` has the contents of a file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import Value

# name of a dataset, a rectangle of its cells, values
Piece = tuple[str, tuple[slice, ...], np.ndarray]


class Contents(Protocol):
    """What an open archive is read from."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all datasets without the scales of dimensions, in alphabetical order."""

    def __contains__(self, name: object) -> bool:
        """Return True if a dataset or a scale has this name."""

    def attributes(self) -> dict[str, Any]:
        """Return title, request, versions and all else that describes the whole archive."""

    def describe(self, name: str) -> Dataset:
        """Return the description of a dataset or scale."""

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the lengths of a dataset's dimensions."""

    def values(self, name: str, where: tuple[int | slice, ...]) -> np.ndarray:
        """Return a copy of part of a dataset; strings as objects."""

    def close(self) -> None:
        """Let go of the file, if there is one."""


@dataclass(frozen=True)
class InMemory:
    """Contents that no file holds."""

    table: Table
    scales: tuple[Scale, ...]
    arrays: Mapping[str, np.ndarray]
    attributes_of: Callable[[], Mapping[str, Value]]

    @classmethod
    def of(
        cls,
        table: Table,
        scales: Iterable[Scale],
        pieces: Iterable[Piece],
        attributes: Callable[[], Mapping[str, Value]],
    ) -> InMemory:
        """Put the pieces of results together; cells without a piece have their fill value.

        The `attributes` are made when they are first asked for.
        """
        arrays = {}
        for entry in table.datasets.values():
            arrays[entry.name] = np.full(table.shape(entry.name), entry.fill, entry.memory_type)
        for name, where, values in pieces:
            arrays[name][where] = values
        in_use = tuple(scale for scale in scales if scale.name in table.dims)
        return cls(table, in_use, arrays, attributes)

    @cached_property
    def about(self) -> Mapping[str, Value]:
        """Title, request, versions and all else that describes the whole archive."""
        return self.attributes_of()

    def __reduce__(self) -> tuple[Any, ...]:
        about = self.about  # pickled are the attributes, not what makes them
        return _in_memory, (self.table, self.scales, self.arrays, about)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(self.arrays))

    @cached_property
    def _described(self) -> dict[str, tuple[Dataset, np.ndarray]]:
        """Description and values of each dataset and scale."""
        described = {}
        for scale in self.scales:
            entry = scale.dataset
            described[scale.name] = (entry, scale.values.astype(entry.memory_type, copy=False))
        for name, entry in self.table.datasets.items():
            described[name] = (entry, self.arrays[name])
        return described

    def __contains__(self, name: object) -> bool:
        return name in self._described

    def attributes(self) -> dict[str, Any]:
        return {name: self.about[name] for name in sorted(self.about)}

    def describe(self, name: str) -> Dataset:
        return self._described[name][0]

    def shape(self, name: str) -> tuple[int, ...]:
        return self._described[name][1].shape

    def values(self, name: str, where: tuple[int | slice, ...]) -> np.ndarray:
        part: np.ndarray = self._described[name][1][where]
        return part.copy() if isinstance(part, np.ndarray) else part

    def close(self) -> None:
        """Keep the arrays: others may read them."""


def _in_memory(table: Table, scales: Any, arrays: Any, about: Mapping[str, Value]) -> InMemory:
    return InMemory(table, scales, arrays, lambda: about)


def whole_pieces(contents: Iterable[tuple[Dataset, np.ndarray]]) -> Iterator[Piece]:
    """Yield each dataset as one piece; numbers are converted to its type."""
    for entry, values in contents:
        stored = values if entry.dtype == "str" else values.astype(entry.dtype)
        yield entry.name, (slice(None),) * values.ndim, stored
