"""A scan under way: one sealed part file for every finished block, beside the archive to be.

While a scan runs, its archive does not exist; the folder `FILE.parts` does.  Each block of cells
becomes a part file there the moment it is computed, and nothing computed is ever lost again.  At
the end the parts become one archive, which is checked before it takes its name; then they go.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines import archive, durable
from nlds_vines.errors import RequestError
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


@dataclass
class Parts:
    """The part files of one scan; use `Parts.open`, and as a context manager.

    Only one process holds a folder of parts at a time.  `complete` says that the archive asked for
    exists already and is sound, so that there is nothing to do; `discarded` collects one line for
    each part that did not verify and must be computed again.
    """

    path: Path
    scan: Scan
    complete: bool = False
    discarded: list[str] = field(default_factory=list)
    _lock: int | None = None

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        scan: Scan,
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> Parts:
        """Begin a scan whose archive is to be `path`, or continue it.

        With `resume`, verified parts of the same scan are kept.  With `overwrite`, parts are
        discarded, and an archive of that name stays as it is until the new one replaces it.

        Raises `RequestError`, leaving everything as it was, if an archive or parts exist and
        neither option is given, if what is to be resumed belongs to another scan, if another
        process is at work on it, or if the folder cannot be written.
        """
        if resume and overwrite:
            raise RequestError("--resume and --overwrite exclude each other: give one of them")
        parts = cls(Path(path), scan)
        with durable.in_one_line(f"write {path}"):
            if parts._archive_is_complete(resume, overwrite) and not parts.folder.exists():
                parts.complete = True
                return parts
            parts._take_lock()
            try:
                parts._settle(resume, overwrite)
            except BaseException:
                parts.close()
                raise
        return parts

    @property
    def folder(self) -> Path:
        """Where the parts are: `FILE.parts`."""
        return self.path.with_name(self.path.name + ".parts")

    def __enter__(self) -> Parts:
        """Return the parts themselves."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let go of the folder, whatever happened; the parts stay."""
        self.close()

    def close(self) -> None:
        """Let go of the folder.  A folder in which nothing was ever begun is removed."""
        if self._lock is None:
            return
        if self._manifest_path.exists():
            self._unlock()
        else:
            self._remove()

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

    @property
    def _manifest_path(self) -> Path:
        return self.folder / "manifest.json"

    def _part_path(self, block: Block) -> Path:
        return self.folder / f"block-{block.index:06d}.npz"

    def _archive_is_complete(self, resume: bool, overwrite: bool) -> bool:
        """Tell whether the archive is there and this scan's; refuse to touch any other."""
        if overwrite or not self.path.exists():
            return False
        if not resume:
            raise RequestError(f"{self.path} exists: --overwrite replaces it, -o names another")
        with archive.read(self.path) as view:
            same = view.attrs["scan_hash"] == self._hash
        if not same and self._manifest().get("overwrite"):
            return False  # the run to be resumed was told to replace it
        if not same:
            raise RequestError(f"{self.path} holds another scan: --resume cannot continue it")
        if problems := archive.verify(self.path):
            raise RequestError(f"{self.path} is damaged ({problems[0]}): use --overwrite")
        return True

    def _take_lock(self) -> None:
        self.folder.mkdir(exist_ok=True)
        self._lock = durable.lock(self.folder / "lock")
        if self._lock is None:
            raise RequestError(f"another run is writing {self.path}: wait for it, or stop it")

    def _settle(self, resume: bool, overwrite: bool) -> None:
        """Decide, alone with the folder, what its content means for this run."""
        if self._archive_is_complete(resume, overwrite):  # again: another run may just have ended
            self.complete = True
            self._remove()
            return
        found = {} if overwrite else self._manifest()
        if overwrite:
            self._clear()
        elif found and not resume:
            text = "--resume continues it, --overwrite discards it"
            raise RequestError(f"{self.folder} holds an unfinished run: {text}")
        elif found and found["scan_hash"] != self._hash:
            whose = f"{found['title']!r}, scan {found['scan_hash'][:12]}"
            raise RequestError(f"{self.folder} holds the parts of another scan ({whose})")
        self._write_manifest(overwrite or bool(found.get("overwrite")))

    def _manifest(self) -> dict[str, Any]:
        """Return whose parts these are; empty if nothing was begun here."""
        try:
            return json.loads(durable.read(self._manifest_path))
        except FileNotFoundError:
            return {}
        except ValueError as error:
            text = f"{self._manifest_path} is damaged ({error}): use --overwrite"
            raise RequestError(text) from error

    def _write_manifest(self, overwrite: bool) -> None:
        whose = {"scan_hash": self._hash, "title": self.scan.title, "overwrite": overwrite}
        durable.write(self._manifest_path, json.dumps(whose).encode())

    @cached_property
    def _hash(self) -> str:
        return self.scan.hash  # which hashes every value of every axis: once will do

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

    def _clear(self) -> None:
        """Remove the parts, the manifest last, so that parts never stand without it."""
        for pattern in ("block-*.npz", "*.tmp", self._manifest_path.name):
            for path in self.folder.glob(pattern):
                path.unlink()

    def _remove(self) -> None:
        """Remove the folder, and with its lock let go of it: from then on it may be another's."""
        self._clear()
        (self.folder / "lock").unlink(missing_ok=True)
        with suppress(OSError):  # it holds something that is not ours, or another run has begun
            self.folder.rmdir()
        self._unlock()

    def _unlock(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
