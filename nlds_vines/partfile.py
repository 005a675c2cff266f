"""Part files: sealed results, piece by piece, in the folder of a run under way.

A part is one line of JSON (which part of what, made by what, which arrays), the bytes of the arrays
one after the other, and a seal.  Existence proves nothing: a part counts when its seal, its
identity, its arrays and its makers are right.  Those of a scan hold a block each (`PartFiles`).
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

UNSOUND = (ValueError, KeyError, TypeError)
"""What is raised by a part that does not verify; it says what is wrong with it."""


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

    def by_us(self) -> Part:
        """Return the part itself; ValueError if other versions made it."""
        if self.made.by != makers():
            raise ValueError("it was made by another version of the program or its libraries")
        return self


def path_of(folder: Path, index: int) -> Path:
    """Return the path of the part of a number."""
    return folder / f"block-{index:06d}.part"


def store(
    path: Path,
    identity: list[Any],
    arrays: Mapping[str, np.ndarray],
    *,
    seconds: float,
    threads: int,
) -> Part:
    """Store contiguous arrays as a part: after this returns, it survives a power cut.

    Arguments: `identity`, as JSON has it, is what `fetch` must ask for; the rest as in `Made`.

    Returns the part as it stands in the file.  Raises OSError if it cannot be written.
    """
    made = Made(makers(), round(seconds, 6), threads)
    head = {
        "block": identity,
        "made": vars(made),
        "arrays": [[name, a.dtype.str, a.shape] for name, a in arrays.items()],
    }
    line = json.dumps(head).encode() + b"\n"
    durable.write(path, line, *(_bytes(array) for array in arrays.values()))
    return Part(dict(arrays), made)


def fetch(path: Path, identity: list[Any]) -> Part:
    """Return a verified part; one of `UNSOUND` says what is wrong with it, OSError that it is not.

    Its arrays cannot be written to.
    """
    data = memoryview(durable.read(path))
    head, start = _header(data)
    if head["block"] != identity:
        raise ValueError("it is of another scan or another block")
    return Part(dict(_arrays(data, head["arrays"], start)), Made(**head["made"]))


class PartFiles:
    """The part files of one scan in one folder; no lock is held, whoever writes them."""

    def __init__(self, folder: Path, scan: Scan) -> None:
        """Look into `folder`, which need not exist, for parts of `scan`."""
        self.folder = folder
        self.scan = scan

    def path(self, block: Block) -> Path:
        """Return the path of the part of a block."""
        return path_of(self.folder, block.index)

    def there(self, blocks: Iterable[Block]) -> list[Block]:
        """Return the blocks that have a part, sound or not."""
        try:
            names = set(os.listdir(self.folder))
        except FileNotFoundError:
            names = set()
        return [block for block in blocks if self.path(block).name in names]

    def load(self, block: Block) -> Part:
        """Return the verified part of a block; one of `UNSOUND` says what is wrong with it."""
        part = fetch(self.path(block), self._identity(block))
        self._check(block, part.arrays)
        return part

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
        identity = self._identity(block)
        return store(self.path(block), identity, content, seconds=seconds, threads=threads)

    def _identity(self, block: Block) -> list[Any]:
        """Return what makes a part the part of this block of this scan."""
        return [
            self.scan.hash,
            block.index,
            [[int(first), int(stop)] for first, stop in block.slices],
        ]

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
