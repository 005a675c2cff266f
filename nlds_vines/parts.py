"""A scan under way: one sealed part file for every finished block, beside the archive to be.

Each block of cells becomes a part file in the scan's folder (`folder`) the moment it is computed,
and nothing computed is ever lost again.  At the end the parts become one archive, which is checked
before it takes its name; then they go.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nlds_vines import archive, durable
from nlds_vines.cut import Block
from nlds_vines.errors import RequestError
from nlds_vines.folder import RunFolder, folder_of
from nlds_vines.manifest import SCAN, Manifest
from nlds_vines.partfile import UNSOUND, Part, PartFiles
from nlds_vines.provenance import Value

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

Arrays = dict[str, np.ndarray]

FRESH_BYTES = 1 << 26
"""Results up to this size stay in memory until they are consolidated, and are not read back."""


@dataclass
class Parts(RunFolder):
    """The part files of one scan; use `Parts.open`, and as a context manager."""

    content: ClassVar[str] = SCAN

    scan: Scan
    _fresh: dict[int, Part] = field(default_factory=dict)
    _fresh_bytes: int = 0

    @classmethod
    def begun(cls, path: Path) -> Parts:
        """Open the parts beside the archive-to-be `path` as they are, to join them.

        Raises `RequestError` if there are none, or if a run or a shard is at work on them.
        """
        manifest = Manifest.read(folder_of(path))
        if manifest is None:
            raise RequestError(f"there are no parts of {path}: nothing was begun, or all is done")
        return cls.open(path, manifest.scan, resume=True)

    def sound(self, blocks: Iterable[Block]) -> Iterator[tuple[Block, Part]]:
        """Yield the blocks whose parts verify: seal, scan, rectangle, arrays and makers.

        Existence proves nothing.  A part that does not verify is removed, and noted in
        `discarded`.
        """
        with durable.in_one_line(f"read the parts in {self.folder}"):
            for block in self.files.there(blocks):
                try:
                    part = self.load(block)
                except UNSOUND as error:
                    path = self.files.path(block)
                    self.discarded.append(f"{path.name} is computed again: {error}")
                    path.unlink(missing_ok=True)
                else:
                    yield block, part

    def finished(self, blocks: Iterable[Block]) -> set[int]:
        """Return the indices of the blocks whose parts verify, as `sound`."""
        return {block.index for block, _ in self.sound(blocks)}

    def load(self, block: Block) -> Part:
        """Return the verified part of a block; one of `UNSOUND` says what is wrong with it."""
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

        `provenance` joins the archive's attributes; its `command` is what the history tells.
        `check` is called for every part: what it raises ends the work.  Memory is that of one part.
        Raises `RequestError` if a block is missing, or as `deliver`.
        """
        missing = len(blocks) - len(self.files.there(blocks))
        if missing:
            raise RequestError(f"{self.path}: {missing} blocks are missing, use --resume")

        def make(path: Path) -> None:
            told = {"seconds": 0.0, "threads": 0} | self.begun_by() | dict(provenance or {})
            archive.write(path, self.scan, self._pieces(blocks, told, check), told)

        self.deliver(make)
        return self.path

    @cached_property
    def files(self) -> PartFiles:
        """The part files themselves, without locks."""
        return PartFiles(self.folder, self.scan)

    def _pieces(
        self, blocks: Iterable[Block], told: dict[str, Any], check: Callable[[], object]
    ) -> Iterator[archive.Piece]:
        """Yield what the parts hold; `told` learns how long they took, on how many threads."""
        for block in blocks:
            check()
            try:
                part = self._fresh.pop(block.index, None) or self.load(block)
            except UNSOUND as error:
                text = f"{self.files.path(block)} cannot be used ({error}): use --resume"
                raise RequestError(text) from error
            told["seconds"] = round(told["seconds"] + part.made.seconds, 6)
            told["threads"] = max(told["threads"], part.made.threads)
            for name, array in part.arrays.items():
                yield name, block.selection, array
