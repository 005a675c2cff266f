"""A scan under way: one part file for every finished block, beside the archive to be.

Each block of cells becomes a part file in the folder of the run as soon as it is computed, so that
it is not lost when the run ends early.  At the end the parts become one archive, which is checked
before it takes its name; then they are removed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives import archive, durable
from nlds_vines.archives.files import parse_toml
from nlds_vines.archives.provenance import SCAN, Value, attributes
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.errors import RequestError
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.runs.folder import RunFolder
from nlds_vines.runs.manifest import NAME, Manifest
from nlds_vines.runs.partfile import UNSOUND, Part, fetch, path_of, store

if TYPE_CHECKING:
    from nlds_vines.bifurcation.attractor_table import AttractorTable


def scan_of(manifest: Manifest) -> Scan:
    """Return the scan in a manifest; `RequestError` where it holds another kind of request."""
    if manifest.content != SCAN:
        raise RequestError(f"{manifest.title!r} under way is a {manifest.content}, not a scan")
    return load_scan(parse_toml(manifest.toml, NAME))


class PartFiles:
    """The part files of one scan in one folder; no lock is taken."""

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
        """Return the verified part of a block; raises one of `UNSOUND` where it does not verify."""
        part = fetch(self.path(block), self._identity(block))
        self._check(block, part.arrays)
        return part

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
        table = self.scan.table.datasets
        dtype = table[name].dtype if name in table else None
        return np.ascontiguousarray(array, dtype=np.str_ if dtype == "str" else dtype)

    def _check(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        """Raise ValueError unless `arrays` are those of this scan, in this block's shape."""
        table = self.scan.table
        if arrays.keys() != table.datasets.keys():
            raise ValueError(f"it holds {sorted(arrays)}, not {sorted(table.datasets)}")
        for name, array in arrays.items():
            shape = (*block.shape, *table.shape(name)[len(block.shape) :])
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, not {shape}")


Arrays = dict[str, np.ndarray]

FRESH_BYTES = 1 << 26
"""Bytes of results that stay in memory (64 MB) until the archive is made, and are not read back."""


@dataclass
class Parts(RunFolder):
    """The part files of one scan; use `Parts.open`, and as a context manager."""

    request: Scan
    _fresh: dict[int, Part] = field(default_factory=dict)
    _fresh_bytes: int = 0

    def sound(self, blocks: Iterable[Block]) -> Iterator[tuple[Block, Part]]:
        """Yield the blocks whose parts verify: checksum, scan, rectangle, arrays and makers.

        A part that does not verify is removed, and noted in `discarded`.
        """
        with durable.in_one_line(f"read the parts in {self.folder}"):
            for block in self.files.there(blocks):
                try:
                    part = self.load(block)
                except UNSOUND as error:
                    path = self.files.path(block)
                    if path.is_dir():
                        text = "is a folder in the place of a part: move it away"
                        raise RequestError(f"{path} {text}") from None
                    self.discarded.append(f"{path.name} is computed again: {error}")
                    path.unlink(missing_ok=True)
                else:
                    yield block, part

    def load(self, block: Block) -> Part:
        """Return the verified part of a block; raises one of `UNSOUND` where it does not verify."""
        return self.files.load(block).by_us()

    def write(
        self, block: Block, arrays: Mapping[str, np.ndarray], seconds: float = 0.0, threads: int = 1
    ) -> None:
        """Store what was computed for a block, as `PartFiles.write`.

        Raises `RequestError` if the disk is full or the folder is gone: earlier parts are intact.
        """
        with durable.in_one_line(f"write a part in {self.folder}"):
            part = self.files.write(block, arrays, seconds=seconds, threads=threads)
        self._fresh_bytes += sum(array.nbytes for array in part.arrays.values())
        if self._fresh_bytes <= FRESH_BYTES:
            self._fresh[block.index] = part

    def consolidate(
        self,
        blocks: Sequence[Block],
        provenance: Mapping[str, Value] | None = None,
        check: Callable[[], object] = lambda: None,
    ) -> Path:
        """Make one archive of all the parts, check it, put it in place and remove the parts.

        Arguments: `provenance` is added to the attributes of the archive, and its `command` stands
        in their history; `check` is called for every part, and what it raises ends the work.
        Memory is that of one part.  Raises `RequestError` if a block is missing, or as `deliver`.
        """
        missing = len(blocks) - len(self.files.there(blocks))
        if missing:
            raise RequestError(f"{self.path}: {missing} blocks are missing, use --resume")

        def make(path: Path) -> None:
            made = {"seconds": 0.0, "threads": 0} | self.begun_by() | dict(provenance or {})
            scan, more = self.request, self._attractors(blocks, check)
            table, scales = scan.table, list(scan.scales())
            if more is not None:
                table, scales = more.joined(), more.scales()
            pieces = self._pieces(blocks, made, check, more)
            archive.write(path, table, scales, pieces, lambda: attributes(scan, scan.about | made))

        self.deliver(make)
        return self.path

    @cached_property
    def files(self) -> PartFiles:
        """The part files themselves, without locks."""
        return PartFiles(self.folder, self.request)

    def _attractors(
        self, blocks: Sequence[Block], check: Callable[[], object]
    ) -> AttractorTable | None:
        """Return the table of the attractors; None if they are not recorded."""
        if ATTRACTOR not in self.request.want:
            return None
        from nlds_vines.bifurcation.attractor_table import AttractorTable

        there = ((block, self._part(block).arrays) for block in blocks)
        return AttractorTable(self.request, there, check)

    def _part(self, block: Block) -> Part:
        """Return the verified part of a block; `RequestError` where it cannot be used."""
        try:
            return self._fresh.get(block.index) or self.load(block)
        except UNSOUND as error:
            text = f"{self.files.path(block)} cannot be used ({error}): use --resume"
            raise RequestError(text) from error

    def _pieces(
        self,
        blocks: Iterable[Block],
        made: dict[str, Any],
        check: Callable[[], object],
        more: AttractorTable | None,
    ) -> Iterator[archive.Piece]:
        """Yield the arrays of the parts; note the seconds they took and their threads in `made`.

        At last come `more`, the attractors.
        """
        for block in blocks:
            check()
            part = self._part(block)
            self._fresh.pop(block.index, None)
            made["seconds"] = round(made["seconds"] + part.made.seconds, 6)
            made["threads"] = max(made["threads"], part.made.threads)
            arrays = part.arrays if more is None else more.patched(block, part.arrays)
            for name, array in arrays.items():
                yield name, block.selection, array
        if more is not None:
            yield from more.pieces()
