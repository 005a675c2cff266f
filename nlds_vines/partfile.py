"""Part files: the sealed results of one block each, in the folder of a scan under way.

A part is one line of JSON (which block of which scan, made by what, which arrays), the bytes of the
arrays one after the other, and a seal.  Existence proves nothing: a part counts when its seal, its
scan, its rectangle, its arrays and its makers are right.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines import durable
from nlds_vines.cut import Block
from nlds_vines.provenance import makers
from nlds_vines.record import Dataset, datasets, sizes

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

PATTERN = "block-*.part"
"""The names of part files."""


@dataclass(frozen=True)
class Made:
    """How a part came to be: by what (`provenance.makers`), in how long [s], on how many threads.

    The seconds are those that passed from block to block: of computing and of storing.
    """

    by: Mapping[str, str]
    seconds: float
    threads: int


@dataclass(frozen=True)
class Part:
    """What a part file holds: the arrays of a block by name, and how they were made."""

    arrays: dict[str, np.ndarray]
    made: Made


class PartFiles:
    """The part files of one scan in one folder; no lock is held, whoever writes them."""

    def __init__(self, folder: Path, scan: Scan) -> None:
        """Look into `folder`, which need not exist, for parts of `scan`."""
        self.folder = folder
        self.scan = scan

    @cached_property
    def hash(self) -> str:
        """The hash of the scan, which hashes every value of every axis: once will do."""
        return self.scan.hash

    def path(self, block: Block) -> Path:
        """Return the path of the part of a block."""
        return self.folder / f"block-{block.index:06d}.part"

    def there(self, blocks: Iterable[Block]) -> list[Block]:
        """Return the blocks that have a part, sound or not."""
        try:
            names = set(os.listdir(self.folder))
        except FileNotFoundError:
            names = set()
        return [block for block in blocks if self.path(block).name in names]

    def load(self, block: Block) -> Part:
        """Return the verified part of a block; ValueError says what is wrong with it."""
        data = memoryview(durable.read(self.path(block)))
        head, start = _header(data)
        if head["block"] != self._identity(block):
            raise ValueError("it is of another scan or another block")
        arrays = dict(_arrays(data, head["arrays"], start))
        self._check(block, arrays)
        return Part(arrays, Made(**head["made"]))

    def peek(self, block: Block, wanted: Iterable[str]) -> Part:
        """Return the `wanted` arrays of a part as they stand, without looking at the seal.

        For a look from outside at a scan under way: it reads no more than it must.
        """
        data = np.memmap(self.path(block), mode="r").data
        head, start = _header(data)
        arrays = {name: a.copy() for name, a in _arrays(data, head["arrays"], start, set(wanted))}
        return Part(arrays, Made(**head["made"]))

    def write(
        self, block: Block, arrays: Mapping[str, np.ndarray], *, seconds: float, threads: int
    ) -> Part:
        """Store what was computed for a block: after this returns, it survives a power cut.

        `arrays` has exactly the datasets of the scan, each of shape rectangle + (starts,) + tail.
        Returns the part as it stands in the file.  Raises OSError if it cannot be written,
        ValueError if names or shapes are not the scan's.
        """
        content = {name: self._as_stored(name, array) for name, array in arrays.items()}
        self._check(block, content)
        made = Made(makers(), round(seconds, 6), threads)
        head = {
            "block": self._identity(block),
            "made": vars(made),
            "arrays": [[name, a.dtype.str, a.shape] for name, a in content.items()],
        }
        line = json.dumps(head).encode() + b"\n"
        durable.write(self.path(block), line, *(_bytes(array) for array in content.values()))
        return Part(content, made)

    def _identity(self, block: Block) -> list[Any]:
        """Return what makes a part the part of this block of this scan."""
        return [self.hash, block.index, [[int(first), int(stop)] for first, stop in block.slices]]

    def _as_stored(self, name: str, array: np.ndarray) -> np.ndarray:
        dtype = self._table[name].dtype if name in self._table else None
        return np.ascontiguousarray(array, dtype=np.str_ if dtype == "str" else dtype)

    @cached_property
    def _table(self) -> dict[str, Dataset]:
        return {dataset.name: dataset for dataset in datasets(self.scan)}

    @cached_property
    def _length(self) -> dict[str, int]:
        return sizes(self.scan)

    def _check(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        """Raise ValueError unless `arrays` are those of this scan, in this block's shape."""
        if arrays.keys() != self._table.keys():
            raise ValueError(f"it holds {sorted(arrays)}, not {sorted(self._table)}")
        for name, array in arrays.items():
            tail = (self._length[dim] for dim in self._table[name].tail)
            shape = (*block.shape, self.scan.starts, *tail)
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, not {shape}")


def _header(data: memoryview) -> tuple[dict[str, Any], int]:
    """Return the first line of a part, and where its arrays begin."""
    size = 1 << 12
    while (end := bytes(data[:size]).find(b"\n")) < 0:
        if size >= len(data):
            raise ValueError("it is no part file")
        size *= 2
    return json.loads(bytes(data[:end])), end + 1


def _arrays(
    data: memoryview, table: Iterable[Any], start: int, wanted: set[str] | None = None
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of a part by name, all of them or those wanted; they share its memory."""
    for name, dtype, shape in table:
        count = math.prod(shape)
        if wanted is None or name in wanted:
            yield name, np.frombuffer(data, dtype, count, start).reshape(shape)
        start += count * np.dtype(dtype).itemsize


def _bytes(array: np.ndarray) -> memoryview:
    """Return the memory of a contiguous array, which for strings has no buffer of its own."""
    return array.reshape(-1).view(np.uint8).data
