"""A scan under way: one sealed part file for every finished block, beside the archive to be.

While a scan runs, its archive does not exist; the folder `FILE.parts` does.  Each block of cells
becomes a part file there the moment it is computed, and nothing computed is ever lost again.  At
the end the parts become one archive, which is checked before it takes its name; then they go.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines import archive, durable
from nlds_vines.errors import RequestError
from nlds_vines.folder import RunFolder
from nlds_vines.record import Dataset, datasets, sizes

if TYPE_CHECKING:
    from nlds_vines.scan import Scan


_HEADER = "block"  # the entry of a part file that says whose it is


@dataclass(frozen=True)
class Block:
    """A rectangle of cells, computed and stored as one.

    `slices` has one pair per axis of the scan: the first cell, and the cell after the last one.
    """

    index: int
    slices: tuple[tuple[int, int], ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of cells along each axis."""
        return tuple(stop - first for first, stop in self.slices)

    @property
    def selection(self) -> tuple[slice, ...]:
        """The rectangle as slices into an array of the whole grid."""
        return tuple(slice(first, stop) for first, stop in self.slices)


class Parts(RunFolder):
    """The part files of one scan; use `Parts.open`, and as a context manager.

    `discarded` collects one line for each part that did not verify and must be computed again.
    """

    scan: Scan

    def finished(self, blocks: Iterable[Block]) -> set[int]:
        """Return the indices of the blocks whose parts verify: seal, scan, rectangle and arrays.

        Existence proves nothing.  A part that does not verify is removed, and noted in
        `discarded`.
        """
        done = set()
        with durable.in_one_line(f"read the parts in {self.folder}"):
            for block in blocks:
                path = self._part_path(block)
                if not path.exists():
                    continue
                try:
                    self.load(block)
                except (ValueError, KeyError) as error:
                    self.discarded.append(f"{path.name} is computed again: {error}")
                    path.unlink()
                else:
                    done.add(block.index)
        return done

    def load(self, block: Block) -> dict[str, np.ndarray]:
        """Return the verified arrays of a block; ValueError says what is wrong with its part."""
        with np.load(io.BytesIO(durable.read(self._part_path(block)))) as part:
            arrays = {name: part[name] for name in part.files}
        if str(arrays.pop(_HEADER)) != str(self._header(block)):
            raise ValueError("it is of another scan or another block")
        self._check(block, arrays)
        return arrays

    def write(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        """Store what was computed for a block: after this returns, it survives a power cut.

        `arrays` has exactly the datasets of the scan, each of shape rectangle + (starts,) + tail.
        Raises `RequestError` if the disk is full or the folder is gone (earlier parts are
        intact), ValueError if names or shapes are not those of the scan.
        """
        content = {name: self._as_stored(name, array) for name, array in arrays.items()}
        self._check(block, content)
        buffer = io.BytesIO()
        entries: dict[str, Any] = {_HEADER: self._header(block), **content}
        np.savez(buffer, **entries)
        with durable.in_one_line(f"write a part in {self.folder}"):
            durable.write(self._part_path(block), buffer.getvalue())

    def consolidate(
        self, blocks: Sequence[Block], provenance: Mapping[str, str | int | float]
    ) -> Path:
        """Make one archive of all the parts, check it, put it in place and remove the parts.

        `provenance` joins the archive's attributes; its `command` is what the history tells.
        Memory is that of one part.  Raises `RequestError` if a block is missing or the disk is
        full: then the parts are intact, and an archive of that name is as it was.
        """
        missing = sum(not self._part_path(block).exists() for block in blocks)
        if missing:
            raise RequestError(f"{self.path}: {missing} blocks are missing, use --resume")
        temporary = self.folder / "archive.tmp"
        with durable.in_one_line(f"write {self.path} (the parts are intact, use --resume)"):
            archive.write(temporary, self.scan, self._pieces(blocks), provenance)
            durable.replace(temporary, self.path)
            self._remove()
        return self.path

    def _part_path(self, block: Block) -> Path:
        return self.folder / f"block-{block.index:06d}.npz"

    def _header(self, block: Block) -> np.ndarray:
        """Return what makes a part the part of this block of this scan, as a string scalar."""
        rectangle = [[int(first), int(stop)] for first, stop in block.slices]
        return np.array(json.dumps([self._hash, int(block.index), rectangle]))

    def _as_stored(self, name: str, array: np.ndarray) -> np.ndarray:
        dtype = self._table[name].dtype if name in self._table else None
        return np.asarray(array, dtype=np.str_ if dtype == "str" else dtype)

    @cached_property
    def _table(self) -> dict[str, Dataset]:
        return {dataset.name: dataset for dataset in datasets(self.scan)}

    def _check(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        """Raise ValueError unless `arrays` are those of this scan, in this block's shape."""
        if arrays.keys() != self._table.keys():
            raise ValueError(f"it holds {sorted(arrays)}, not {sorted(self._table)}")
        length = sizes(self.scan)
        for name, array in arrays.items():
            tail = (length[dim] for dim in self._table[name].tail)
            shape = (*block.shape, self.scan.starts, *tail)
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, not {shape}")

    def _pieces(self, blocks: Iterable[Block]) -> Iterator[archive.Piece]:
        for block in blocks:
            try:
                arrays = self.load(block)
            except (ValueError, KeyError) as error:
                text = f"{self._part_path(block)} is damaged ({error}): use --resume"
                raise RequestError(text) from error
            for name, array in arrays.items():
                yield name, block.selection, array
