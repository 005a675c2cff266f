"""The blocks of a scan, rectangles of cells that are computed as one; whether there is room.

The blocks depend on the scan alone, not on the machine.  So a run can be resumed on another
machine, and many machines can share one scan without communication.
"""

from __future__ import annotations

from dataclasses import dataclass
from glob import escape
from itertools import pairwise, product
from math import ceil, prod
from pathlib import Path
from typing import Any

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.bifurcation.request import Scan
from nlds_vines.engine.records import JUDGED, noted, touches_noted
from nlds_vines.errors import RequestError
from nlds_vines.kernels.scene.codes import TOUCH_COLUMNS
from nlds_vines.runs import progress
from nlds_vines.runs.executors import Shard, free_disk, free_memory

BLOCK_PERIODS = 200_000  # forcing periods: tenths of a second, which an interruption may lose
MOST_BLOCKS = 4000  # blocks of a scan: with many more, a folder of as many files becomes slow
BLOCK_BYTES = 1 << 27  # of a block while it is computed: small beside the memory of any machine
_LANE_BYTES = 1024  # bytes of one orbit without its section: counts, energies, evidence, status


@dataclass(frozen=True)
class Block:
    """A rectangle of cells, computed and stored as one."""

    index: int
    # the first cell, and the cell after the last one, along the case of a curve and each axis
    slices: tuple[tuple[int, int], ...]

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(stop - first for first, stop in self.slices)

    @property
    def cells(self) -> int:
        return prod(self.shape)

    @property
    def selection(self) -> tuple[slice, ...]:
        return tuple(slice(first, stop) for first, stop in self.slices)


def blocks_of(request: Any, shard: Shard | None = None) -> list[Block]:
    """Return the blocks of a `Scan`, of one shard of it, or of a `CurveRequest` case by case."""
    blocks: list[Block] = []
    for case, scan in enumerate(request.scans):
        sides = [] if scan is request else [[(case, case + 1)]]
        for length, size in zip(scan.shape, _block_sides(scan)[-len(scan.shape) :], strict=True):
            pieces = ceil(length / size)  # as equal as possible
            edges = [length * i // pieces for i in range(pieces + 1)]
            sides.append(list(pairwise(edges)))
        first = len(blocks)
        for i, slices in enumerate(product(*sides)):
            blocks.append(Block(first + i, slices))
    return blocks if shard is None else blocks[shard.blocks]


def counted(number: int, what: str) -> str:
    return f"{number} {what}" + "s" * (number != 1)


def share_in_words(scan: Scan, shard: Shard) -> str:
    """Return a line on the blocks of a shard, which may be none."""
    all_blocks, count = len(blocks_of(scan)), len(blocks_of(scan, shard))
    of_all = f"{count} of {counted(all_blocks, 'block')}"
    if count:
        return f"shard {shard}: {of_all}"
    return f"shard {shard} is empty: {of_all}; shards 1 to {all_blocks} have them all"


def lane_bytes(scan: Scan) -> int:
    """Return the bytes of one orbit's buffers; a verdict needs a longer section than is stored."""
    rows = noted(scan.want, scan.transient, scan.periods)
    touches = touches_noted(scan.want, scan.system.scene, scan.periods)
    if scan.spectral is not None:  # and the buffers of the transform, of as many numbers
        rows += 2 * scan.periods * scan.spectral.samples
    size = len(scan.system.scene.components)
    if size > 4 and not JUDGED.isdisjoint(scan.want):  # for up to 4 `_LANE_BYTES` has room
        rows += size + 2  # the monodromy matrix, the exponents and the point
    return 8 * (rows * size + TOUCH_COLUMNS * touches) + _LANE_BYTES


def block_bytes(scan: Scan) -> int:
    """Return the bytes of the results of the largest block, 16 for a string."""
    return scan.table.bytes(text=16) * _largest(scan) // prod(scan.shape)


def work_bytes(scan: Scan) -> int:
    """Return the bytes of the buffers of the largest block while it is computed."""
    return lane_bytes(scan) * scan.starts * _largest(scan)


def _largest(scan: Scan) -> int:
    return min(prod(scan.shape), prod(_block_sides(scan)))


def _block_sides(scan: Scan) -> tuple[int, int]:
    """Return the most cells of a block along the first of two axes, and along the last one.

    They are those of about `BLOCK_PERIODS`, within `BLOCK_BYTES`.
    """
    per_cell = scan.starts * (scan.transient + scan.periods)
    per_cell *= scan.system.scene.cost
    by_time = max(BLOCK_PERIODS // per_cell, ceil(prod(scan.shape) / MOST_BLOCKS))
    by_size = BLOCK_BYTES // (scan.starts * lane_bytes(scan))
    cells = max(1, min(by_time, by_size))
    last = scan.shape[-1]
    columns = last if scan.start.sweeps else min(last, cells)
    rows = 1
    if columns == last:
        rows = max(1, cells // last)
    return rows, columns


_BLOCKS = 2  # in memory
_CELL_COPIES = 2  # of the grid of cells: the grid itself, and the chains cut from it
_ARCHIVE_COPIES = 2  # of an archive in memory: its blocks, and the arrays made of them
_PROGRAM = 300_000_000  # bytes of the program with its kernels; compiling needs more


def memory_needed(scan: Scan, archive: Path) -> int:
    """Return the bytes of memory that a scan takes at most.

    Without a name an archive is in memory, as are all its blocks while it is put together.
    """
    grid = prod(scan.shape) * scan.system.cells().dtype.itemsize
    needed = _BLOCKS * work_bytes(scan) + block_bytes(scan) + _CELL_COPIES * grid + _PROGRAM
    if _is_in_memory(archive):
        needed += _ARCHIVE_COPIES * scan.table.most_bytes
    return needed


def _is_in_memory(archive: Path) -> bool:
    return ArchivePath.of(archive).named is None


def refuse_without_room(scan: Scan, archive: Path) -> None:
    """Raise `RequestError` if a scan does not fit into what memory and disk have free."""
    whose, remedy = "a block of orbits", "begin fewer orbits"
    if _is_in_memory(archive):
        whose, remedy = "its results", "name an archive (to=)"
    needed, free = memory_needed(scan, archive), free_memory()
    if free is not None and needed > free:
        raise RequestError(
            f"the scan needs {_size(needed)} of memory for {whose}, "
            f"{_size(free)} are free: record less, sample fewer periods or {remedy}"
        )
    if _is_in_memory(archive):
        return
    saved = sum(
        file.stat().st_size
        for file in archive.parent.glob(f"{escape(archive.name)}.*.blocks/*.npz")
    )
    needed, free = 2 * scan.table.most_bytes - saved, free_disk(archive.parent)
    if free is not None and needed > free:
        raise RequestError(
            f"the scan needs up to {_size(needed)} on the disk of {str(archive)!r}, blocks "
            f"and archive, {_size(free)} are free: record less, or take another disk"
        )


def _size(count: int) -> str:
    return progress.size(max(count, 0))
