"""The blocks of a scan, and whether there is room for them."""

from __future__ import annotations

from glob import escape
from math import ceil, prod
from pathlib import Path
from typing import Any

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.bifurcation.request import Scan
from nlds_vines.engine.records import JUDGED, noted, touches_noted
from nlds_vines.errors import RequestError
from nlds_vines.kernels.scene.codes import TOUCH_COLUMNS
from nlds_vines.runs import progress
from nlds_vines.runs.executors import free_disk, free_memory
from nlds_vines.scans.block import MOST_BLOCKS, Block, Slices, rectangles, sides_of_blocks

BLOCK_PERIODS = 200_000  # forcing periods: tenths of a second, which an interruption may lose
BLOCK_BYTES = 1 << 27  # of a block while it is computed: small beside the memory of any machine
_LANE_BYTES = 1024  # bytes of one orbit without its section: counts, energies, evidence, status


def blocks_of(request: Any) -> list[Block]:
    """Return the blocks of a `Scan`, or of a `CurveRequest` case by case."""
    rectangles_of_cells: list[Slices] = []
    for case, scan in enumerate(request.scans):
        sides = _block_sides(scan)
        for slices in rectangles(scan.shape, sides):
            of_case = () if scan is request else ((case, case + 1),)
            rectangles_of_cells.append((*of_case, *slices))
    return [Block(index, slices) for index, slices in enumerate(rectangles_of_cells)]


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
    return prod(_block_sides(scan))


def _block_sides(scan: Scan) -> list[int]:
    """Return the largest sides of a block: about `BLOCK_PERIODS`, within `BLOCK_BYTES`."""
    per_cell = scan.starts * (scan.transient + scan.periods)
    per_cell *= scan.system.scene.cost
    by_time = max(BLOCK_PERIODS // per_cell, ceil(prod(scan.shape) / MOST_BLOCKS))
    by_size = BLOCK_BYTES // (scan.starts * lane_bytes(scan))
    most = min(by_time, by_size)
    return sides_of_blocks(scan.shape, most, keeps_last=bool(scan.start.sweeps))


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
