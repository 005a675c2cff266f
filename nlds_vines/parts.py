"""A scan under way: one sealed part file for every finished block, beside the archive to be.

While a scan runs, its archive does not exist; the folder `FILE.parts` does.  Each block of cells
becomes a part file there the moment it is computed, and nothing computed is ever lost again.  At
the end the parts become one archive, which is checked before it takes its name; then they go.

A run holds the folder for itself alone.  Shards of one scan share it; each holds its own share.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines import archive, durable
from nlds_vines.cut import Block, Shard
from nlds_vines.errors import RequestError
from nlds_vines.manifest import NAME, Manifest
from nlds_vines.partfile import PATTERN, Part, PartFiles
from nlds_vines.provenance import Value, makers

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

Arrays = dict[str, np.ndarray]

FRESH_BYTES = 1 << 26
"""Results up to this size stay in memory until they are consolidated, and are not read back."""


@dataclass
class Parts:
    """The part files of one scan; use `Parts.open`, and as a context manager.

    `complete` says that the archive asked for exists already and is sound, so that there is nothing
    to do; `discarded` collects one line for each part that did not verify and must be computed
    again.
    """

    path: Path
    scan: Scan
    shard: Shard | None = None
    complete: bool = False
    discarded: list[str] = field(default_factory=list)
    _locks: list[int] = field(default_factory=list)
    _fresh: dict[int, Part] = field(default_factory=dict)
    _fresh_bytes: int = 0

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        scan: Scan,
        *,
        resume: bool = False,
        overwrite: bool = False,
        shard: Shard | None = None,
    ) -> Parts:
        """Begin a scan whose archive is to be `path`, or continue it.

        With `resume`, verified parts of the same scan are kept.  With `overwrite`, parts are
        discarded, and an archive of that name stays as it is until the new one replaces it.  A
        `shard` joins whatever has been begun of the same scan, and others may be at work beside it.

        Raises `RequestError`, leaving everything as it was, if an archive or parts exist and
        neither option is given, if what is to be resumed belongs to another scan, if another
        process is at work on it, or if the folder cannot be written.
        """
        if resume and overwrite:
            raise RequestError("--resume and --overwrite exclude each other: give one of them")
        if shard and overwrite:
            raise RequestError("--shard and --overwrite exclude each other: others may be at work")
        parts = cls(Path(path), scan, shard)
        with durable.in_one_line(f"write {path}"):
            if parts._archive_is_complete(resume, overwrite) and not parts.folder.exists():
                parts.complete = True
                return parts
            parts.folder.mkdir(exist_ok=True)
            with parts._closed_on_error():
                parts._take_locks()
                parts._settle(resume, overwrite)
        return parts

    @classmethod
    def begun(cls, path: Path) -> Parts:
        """Open the parts beside the archive-to-be `path` as they are, to join them.

        Raises `RequestError` if there are none, or if a run or a shard is at work on them.
        """
        manifest = Manifest.read(folder_of(path))
        if manifest is None:
            raise RequestError(f"there are no parts of {path}: nothing was begun, or all is done")
        return cls.open(path, manifest.scan, resume=True)

    @property
    def folder(self) -> Path:
        """Where the parts are: `FILE.parts`."""
        return folder_of(self.path)

    def __enter__(self) -> Parts:
        """Return the parts themselves."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let go of the folder, whatever happened; the parts stay."""
        self.close()

    def close(self) -> None:
        """Let go of the folder.  A folder in which nothing was ever begun is removed."""
        if not self._locks:
            return
        if self.shard or (self.folder / NAME).exists():
            self._unlock()
        else:
            self._remove()

    def sound(self, blocks: Iterable[Block]) -> Iterator[tuple[Block, Part]]:
        """Yield the blocks whose parts verify: seal, scan, rectangle, arrays and makers.

        Existence proves nothing.  A part that does not verify is removed, and noted in
        `discarded`.
        """
        with durable.in_one_line(f"read the parts in {self.folder}"):
            for block in self.files.there(blocks):
                try:
                    part = self.load(block)
                except (ValueError, KeyError, TypeError) as error:
                    path = self.files.path(block)
                    self.discarded.append(f"{path.name} is computed again: {error}")
                    path.unlink(missing_ok=True)
                else:
                    yield block, part

    def finished(self, blocks: Iterable[Block]) -> set[int]:
        """Return the indices of the blocks whose parts verify, as `sound`."""
        return {block.index for block, _ in self.sound(blocks)}

    def load(self, block: Block) -> Part:
        """Return the verified part of a block; ValueError says what is wrong with it."""
        part = self.files.load(block)
        if part.made.by != makers():
            raise ValueError("it was made by another version of the program or its libraries")
        return part

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
        Raises `RequestError` if a block is missing or the disk is full.  However it ends early, the
        parts are intact, and an archive of that name is as it was.
        """
        missing = len(blocks) - len(self.files.there(blocks))
        if missing:
            raise RequestError(f"{self.path}: {missing} blocks are missing, use --resume")
        temporary = self.folder / "archive.tmp"
        told: dict[str, Value] = {"seconds": 0.0, "threads": 0}
        with durable.in_one_line(f"write {self.path} (the parts are intact, use --resume)"):
            manifest = Manifest.read(self.folder)
            told |= {"argv": json.dumps(manifest.argv)} if manifest else {}
            told |= provenance or {}
            try:
                archive.write(temporary, self.scan, self._pieces(blocks, told, check), told)
                durable.replace(temporary, self.path)
            finally:
                with suppress(OSError):
                    temporary.unlink()
            self._remove()
        return self.path

    @cached_property
    def files(self) -> PartFiles:
        """The part files themselves, without locks."""
        return PartFiles(self.folder, self.scan)

    def _archive_is_complete(self, resume: bool, overwrite: bool) -> bool:
        """Tell whether the archive is there and this scan's; refuse to touch any other."""
        if overwrite or not self.path.exists():
            return False
        if not resume:
            raise RequestError(f"{self.path} exists: --overwrite replaces it, -o names another")
        with archive.read(self.path) as view:
            same = view.attrs["scan_hash"] == self.files.hash
        if not same:
            manifest = Manifest.read(self.folder)
            if manifest and manifest.overwrite:
                return False  # the run to be resumed was told to replace it
            raise RequestError(f"{self.path} holds another scan: --resume cannot continue it")
        if problems := archive.verify(self.path):
            raise RequestError(f"{self.path} is damaged ({problems[0]}): use --overwrite")
        return True

    def _take_locks(self) -> None:
        """Hold the folder: a run for itself alone, a shard together with others."""
        busy = f"another run is writing {self.path}: wait for it, or stop it"
        self._lock("lock", busy, shared=self.shard is not None)
        if self.shard:
            name = f"shard-{self.shard.index}-of-{self.shard.count}.lock"
            self._lock(name, f"another run is computing shard {self.shard} of {self.path}")

    def _lock(self, name: str, busy: str, **how: Any) -> None:
        descriptor = durable.lock(self.folder / name, **how)
        if descriptor is None:
            raise RequestError(busy)
        self._locks.append(descriptor)

    def _settle(self, resume: bool, overwrite: bool) -> None:
        """Decide, alone with the folder, what its content means for this run."""
        if self.shard:  # others may be about to settle as well: one after the other
            self._lock("settling.lock", f"{self.folder} is locked", patience=60.0)
        if self._archive_is_complete(resume, overwrite):  # again: another run may just have ended
            self.complete = True
            if not self.shard:
                self._remove()
            return
        if overwrite:
            self._clear()
        found = Manifest.read(self.folder)
        if found and not (resume or self.shard):
            text = "--resume continues it, --overwrite discards it"
            raise RequestError(f"{self.folder} holds an unfinished run: {text}")
        if found and found.scan_hash != self.files.hash:
            whose = f"{found.title!r}, scan {found.scan_hash[:12]}"
            raise RequestError(f"{self.folder} holds the parts of another scan ({whose})")
        if not found:
            Manifest.of(self.scan, self.files.hash, overwrite).write(self.folder)
        if self.shard:
            os.close(self._locks.pop())

    def _pieces(
        self, blocks: Iterable[Block], told: dict[str, Any], check: Callable[[], object]
    ) -> Iterator[archive.Piece]:
        """Yield what the parts hold; `told` learns how long they took, on how many threads."""
        for block in blocks:
            check()
            try:
                part = self._fresh.pop(block.index, None) or self.load(block)
            except (ValueError, KeyError, TypeError) as error:
                text = f"{self.files.path(block)} cannot be used ({error}): use --resume"
                raise RequestError(text) from error
            told["seconds"] = round(told["seconds"] + part.made.seconds, 6)
            told["threads"] = max(told["threads"], part.made.threads)
            for name, array in part.arrays.items():
                yield name, block.selection, array

    def _clear(self) -> None:
        """Remove the parts, the manifest last, so that parts never stand without it."""
        for pattern in (PATTERN, "*.tmp", NAME):
            for path in self.folder.glob(pattern):
                path.unlink()

    def _remove(self) -> None:
        """Remove the folder, and with its lock let go of it: from then on it may be another's."""
        self._clear()
        for path in (*self.folder.glob("*.lock"), self.folder / "lock"):
            path.unlink(missing_ok=True)
        with suppress(OSError):  # it holds something that is not ours, or another run has begun
            self.folder.rmdir()
        self._unlock()

    @contextmanager
    def _closed_on_error(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.close()
            raise

    def _unlock(self) -> None:
        while self._locks:
            os.close(self._locks.pop())


def folder_of(path: Path) -> Path:
    """Return where the parts of an archive-to-be lie: `FILE.parts`."""
    return path.with_name(path.name + ".parts")
