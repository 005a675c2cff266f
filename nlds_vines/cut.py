"""How a scan is cut into blocks, and which of them are a shard's.

The cut is a function of the scan alone, never of the machine: so a run can be resumed on another
one, and many machines can share one scan without talking to each other.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from typing import TYPE_CHECKING

from nlds_vines.errors import RequestError, shown
from nlds_vines.record import RETRACED, components, datasets, noted, sizes
from nlds_vines.system import CELL

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

BLOCK_PERIODS = 200_000  # forcing periods in a block: some tenths of a second
MOST_BLOCKS = 4000
BLOCK_BYTES = 1 << 27  # of one block, while it is computed
MOST_SHARDS = 10_000
_LANE_BYTES = 1024  # of one orbit's numbers: counts, energies, evidence, ends, status
_PERIOD_BYTES = CELL.itemsize + 6 * 32  # of one traced again: its cell, and six states at a time


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
    def cells(self) -> int:
        """Number of cells in all."""
        return math.prod(self.shape)

    @property
    def selection(self) -> tuple[slice, ...]:
        """The rectangle as slices into an array of the whole grid."""
        return tuple(slice(first, stop) for first, stop in self.slices)


@dataclass(frozen=True)
class Shard:
    """One of `count` equal shares of a scan; `index` counts from 1."""

    index: int
    count: int

    def __str__(self) -> str:
        """Return it as it is given: `3/7`."""
        return f"{self.index}/{self.count}"

    def has(self, block: Block) -> bool:
        """Tell whether a block is of this share: every `count`-th, so that dear regions spread."""
        return block.index % self.count == self.index - 1

    @classmethod
    def parse(cls, text: str, environment: Mapping[str, str] = os.environ) -> Shard:
        """Return the share that `3/7` means, or `slurm`: that of this task of a job array.

        Raises `RequestError` for anything else, and for an array with gaps in its numbers.
        """
        if text == "slurm":
            return cls._of_array(environment)
        if found := re.fullmatch(r"(\d{1,9})/(\d{1,9})", text, re.ASCII):
            index, count = map(int, found.groups())
            if 1 <= index <= count <= MOST_SHARDS:
                return cls(index, count)
        allowed = f"i/n with i from 1 to n and n up to {MOST_SHARDS}, or slurm"
        raise RequestError(f"--shard {shown(text)} must be {allowed}")

    @classmethod
    def _of_array(cls, environment: Mapping[str, str]) -> Shard:
        """Return the share of the task that SLURM's variables name."""
        names = ("ID", "MIN", "MAX", "COUNT")
        found = {name: environment.get(f"SLURM_ARRAY_TASK_{name}", "") for name in names}
        for name, text in found.items():
            if not (text.isascii() and text.isdigit()):
                where = f"SLURM_ARRAY_TASK_{name} = {shown(text)}"
                raise RequestError(f"--shard slurm: {where} must be a number; is this a job array?")
        here, low, high, count = (int(found[name]) for name in names)
        if not (low <= here <= high and high - low + 1 == count <= MOST_SHARDS):
            raise RequestError(
                f"--shard slurm: task {here} of {count} from {low} to {high}: the array must be "
                f"numbered without gaps and have up to {MOST_SHARDS} tasks; else give --shard i/n"
            )
        return cls(here - low + 1, count)


def blocks_of(scan: Scan, shard: Shard | None = None) -> Iterator[Block]:
    """Cut the grid of a scan into rectangles of cells: all of them, or those of one shard.

    Where orbits follow an attractor along the last axis, that axis stays whole.
    """
    rows, along = _block_sides(scan)
    rows_of = [_spans(n, rows) for n in scan.shape[:-1]]
    spans = product(*rows_of, _spans(scan.shape[-1], along))
    blocks = (Block(index, tuple(slices)) for index, slices in enumerate(spans))
    return blocks if shard is None else filter(shard.has, blocks)


def result_bytes(scan: Scan) -> int:
    """Return the size of all results of a scan before compression."""
    length = sizes(scan)
    item = {"str": 16, "int8": 1, "int32": 4, "float64": 8}
    return sum(item[d.dtype] * math.prod(length[dim] for dim in d.dims) for d in datasets(scan))


def lane_bytes(scan: Scan) -> int:
    """Return the size of one orbit's buffers while it is computed, its section foremost.

    For a verdict that is longer than what is stored: part of the transient belongs to it.  For an
    error there are two such orbits, and the periods that are traced again.
    """
    rows = noted(scan.want, scan.transient, scan.periods)
    orbit = 8 * rows * len(components(scan)) + _LANE_BYTES
    if "error" not in scan.want:
        return orbit
    return 2 * orbit + min(scan.periods, RETRACED) * _PERIOD_BYTES


def block_bytes(scan: Scan) -> int:
    """Return the size of the results of the largest block."""
    total = math.prod(scan.shape)
    return result_bytes(scan) * _largest(scan) // total


def work_bytes(scan: Scan) -> int:
    """Return the size of the buffers of the largest block, while it is computed."""
    return lane_bytes(scan) * scan.starts * _largest(scan)


def _largest(scan: Scan) -> int:
    """Return the most cells of a block."""
    return min(math.prod(scan.shape), math.prod(_block_sides(scan)))


def _block_sides(scan: Scan) -> tuple[int, int]:
    """Return the most cells of a block along the first of two axes, and along the last one."""
    last, cells = scan.shape[-1], _block_cells(scan)
    along = last if scan.start.sweeps else min(last, cells)
    return (max(1, cells // last) if along == last else 1), along


def _block_cells(scan: Scan) -> int:
    """Return how many cells make a block of agreeable duration and size."""
    per_cell = scan.starts * (scan.transient + scan.periods)
    total = math.prod(scan.shape)
    by_time = max(BLOCK_PERIODS // per_cell, math.ceil(total / MOST_BLOCKS))
    by_size = BLOCK_BYTES // (scan.starts * lane_bytes(scan))
    return max(1, min(by_time, by_size))


def _spans(length: int, size: int) -> list[tuple[int, int]]:
    """Return (first, last + 1) of pieces of at most `size`, as equal as can be."""
    pieces = math.ceil(length / size)
    edges = [length * i // pieces for i in range(pieces + 1)]
    return list(pairwise(edges))
