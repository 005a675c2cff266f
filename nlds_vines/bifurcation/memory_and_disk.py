"""Whether memory and disk suffice for a scan, checked before its first orbit."""

from __future__ import annotations

import os
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.bifurcation.blocks import block_bytes, work_bytes
from nlds_vines.errors import RequestError
from nlds_vines.model.system import cell_type
from nlds_vines.runs.threads import free_disk, free_memory

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan

_BLOCKS = 2  # blocks in memory: one is computed while the one before is stored
_CELL_COPIES = 2  # of the grid of cells: the grid itself, and the chains cut from it
_PROGRAM = 300_000_000  # bytes of the program itself, once compiled (`orbits.compilation.MEMORY`)


def refuse_without_room(scan: Scan, archive: Path) -> None:
    """Raise `RequestError` where a scan does not fit into this machine's memory or disk.

    The disk must hold the parts and the archive that is made of them.  Parts that exist already
    need no room; where the system does not say how much is free, nothing is refused.
    """
    needed, free = _memory(scan), free_memory()
    if free is not None and needed > free:
        raise RequestError(
            f"the scan needs {_gigabytes(needed)} of memory for a block of orbits, "
            f"{_gigabytes(free)} are free: record less, sample fewer periods or begin fewer orbits"
        )
    needed, free = 2 * scan.table.most_bytes - _kept(archive), free_disk(archive.parent)
    if free is not None and needed > free:
        raise RequestError(
            f"the scan needs up to {_gigabytes(needed)} on the disk of {str(archive)!r}, parts and "
            f"archive, {_gigabytes(free)} are free: record less, or -o names another disk"
        )


def _memory(scan: Scan) -> int:
    """Return how many bytes a run needs at most: the program, the blocks and the grid.

    A block counts while it is computed, which for a verdict is more than what is stored of it.
    """
    grid = prod(scan.shape) * cell_type(scan.system.scene).itemsize
    blocks = _BLOCKS * work_bytes(scan) + block_bytes(scan)
    return blocks + _CELL_COPIES * grid + _PROGRAM


def _kept(archive: Path) -> int:
    """Return the bytes of the parts that exist already."""
    folder = archive.with_name(f"{archive.name}.parts")
    try:
        return sum(entry.stat().st_size for entry in os.scandir(folder))
    except OSError:
        return 0


def _gigabytes(count: int) -> str:
    return f"{max(count, 0) / 1e9:.3g} GB"
