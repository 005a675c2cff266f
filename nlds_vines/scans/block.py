"""Blocks: rectangles of cells that are computed and stored as one.

They depend on the request alone, not on the machine.  So a run can be resumed on another machine,
and many machines can share one request without communication.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import ceil, prod

from nlds_vines.archives.dataset import Table
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.store import Expected

MOST_BLOCKS = 4000  # of a request: with many more, a folder of as many files becomes slow

Slices = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Block:
    """A rectangle of cells, computed and stored as one."""

    index: int
    # the first cell, and the cell after the last one, along each dimension of cells
    slices: Slices

    def __str__(self) -> str:
        return str(self.index)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(stop - first for first, stop in self.slices)

    @property
    def cells(self) -> int:
        return prod(self.shape)

    @property
    def selection(self) -> tuple[slice, ...]:
        return tuple(slice(first, stop) for first, stop in self.slices)

    def expected(self, table: Table) -> Expected:
        """Return the types and shapes of the block's part of each dataset."""
        sides = len(self.slices)
        return {
            name: (entry.dtype, (*self.shape, *table.shape(name)[sides:]))
            for name, entry in table.datasets.items()
        }


def sides_of_blocks(shape: Sequence[int], most: int, *, keeps_last: bool = False) -> list[int]:
    """Return the largest sides of rectangles of up to `most` cells, and of one cell at least.

    A rectangle extends along the last dimension first, and along another one only if it is whole
    along all that follow.  With `keeps_last` it is always whole along the last one.
    """
    room = max(1, most)
    sides: list[int] = []
    for place, length in enumerate(reversed(shape)):
        is_whole = room >= length or (keeps_last and place == 0)
        sides.insert(0, length if is_whole else room)
        room = max(1, room // length) if is_whole else 1
    return sides


def rectangles(shape: Sequence[int], sides: Sequence[int]) -> Iterator[Slices]:
    """Yield the rectangles of cells of a grid, at most as long as `sides` and as equal as can be.

    The last dimension varies first.
    """
    along: list[list[tuple[int, int]]] = []
    for length, side in zip(shape, sides, strict=True):
        pieces = ceil(length / side)
        edges = [length * i // pieces for i in range(pieces + 1)]
        along.append(list(pairwise(edges)))
    yield from product(*along)


def counted(number: int, what: str) -> str:
    return f"{number} {what}" + "s" * (number != 1)


def share_in_words(blocks: Sequence[Block], shard: Shard) -> str:
    """Return a line on the blocks of a shard, which may be none."""
    count = len(blocks[shard.blocks])
    of_all = f"{count} of {counted(len(blocks), 'block')}"
    if count:
        return f"shard {shard}: {of_all}"
    return f"shard {shard} is empty: {of_all}; shards 1 to {len(blocks)} have them all"
