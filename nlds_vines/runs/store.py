"""A run under way: a folder of finished blocks beside the archive that is made of them.

The name of the folder holds a hash of the request and of all that may change a bit of a result, so
blocks of two requests or of two versions never mix.  A block is an .npz file that appears whole or
not at all; one that cannot be read is computed again.  No process locks anything: several may
compute the same blocks, and whoever finds the archive in its place has nothing left to do.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import secrets
import shutil
import sys
import time
import zipfile
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from glob import escape
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import archive, files
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import Value, attributes, makers, now
from nlds_vines.errors import RequestError, printable, shown
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import threads_in_use

Arrays = Mapping[str, np.ndarray]  # what a block holds, by name
Write = Callable[[Path], object]  # writes an archive to a path

FORCE_EVERY = 1.0  # seconds until a block is forced to the disk again, which takes some 10 ms
_SECONDS = "seconds_of_block"


class Blocks:
    """The finished blocks of a request whose archive is to be `path`, each under a key."""

    def __init__(self, path: Path, request: Any) -> None:
        """Choose the folder; nothing is written before the first block is saved."""
        self.path, self.request = ArchivePath.of(path), request
        self._in_memory: dict[object, Arrays] | None = {} if self.path.named is None else None
        self.keys: Sequence[object] | None = None  # that the run needs, if known
        self._seconds: dict[object, float] = {}
        self._forced = -math.inf

    @cached_property
    def folder(self) -> Path:
        """The folder of the blocks, whose name has a hash of all that may change a bit of them."""
        identity = json.dumps([self.request.content, self.request.hash, makers()], sort_keys=True)
        digest = hashlib.sha256(identity.encode()).hexdigest()[:16]
        return Path(self.path.parent, f"{self.path.name}.{digest}.blocks")

    def file(self, key: object) -> Path:
        return self.folder / f"{key}.npz"

    def missing(self, keys: Iterable[Any]) -> list[Any]:
        if self._in_memory is not None:
            return [key for key in keys if key not in self._in_memory]
        return [key for key in keys if not self.file(key).exists()]

    def save(self, key: object, arrays: Arrays, seconds: float = 0.0) -> None:
        """Save a block, which then survives a kill; a power cut may take the last second's."""
        if interrupts.abandoned()():
            raise interrupts.Stopped
        self._seconds[key] = seconds
        if self._in_memory is not None:
            self._in_memory[key] = arrays
            return
        temporary, now = _temporary(self.folder), time.monotonic()
        is_due = now - self._forced > FORCE_EVERY
        with files.in_one_line(f"write a block in {self.folder}"):
            try:
                self.folder.mkdir(exist_ok=True)
                with temporary.open("xb") as file:
                    np.savez(file, **arrays, **{_SECONDS: np.float64(seconds)})  # type: ignore[arg-type]
                    if is_due:
                        file.flush()
                        os.fsync(file.fileno())
                os.replace(temporary, self.file(key))
                if is_due:
                    files.sync_folder(self.folder)
                    self._forced = now
            finally:
                with suppress(OSError):
                    temporary.unlink()

    def load(self, key: object) -> dict[str, np.ndarray] | None:
        """Return the arrays of a block; None without one, and, with a line, if it is damaged."""
        if self._in_memory is not None:
            return dict(self._in_memory[key]) if key in self._in_memory else None
        file = self.file(key)
        try:
            with files.open_regular(file) as opened:
                if zipfile.ZipFile(opened).testzip() is not None:
                    raise ValueError("its checksum is wrong")
                opened.seek(0)
                arrays = dict(np.load(opened))
            self._seconds[key] = float(arrays.pop(_SECONDS))
        except FileNotFoundError:
            return None
        except Exception as error:  # what a damaged file lets zipfile and NumPy raise is not listed
            reason = str(error).partition("\n")[0]
            print(printable(f"{file} is computed again: {reason}"), file=sys.stderr)
            return None
        return arrays

    def piece(self, key: object, compute: Callable[[], Arrays]) -> Arrays:
        arrays: Arrays | None = self.load(key)
        if arrays is None:
            interrupts.check()
            began = time.monotonic()
            arrays = compute()
            self.save(key, arrays, time.monotonic() - began)
        return arrays

    @property
    def spent(self) -> dict[str, Value]:
        """The attributes that say how long the blocks took, and on how many threads."""
        return {"seconds": round(sum(self._seconds.values()), 6), "threads": threads_in_use()}

    def begin(self, how: Any) -> bool:
        """Return True if the archive is there; refuse what `how` does not resume or replace."""
        if self._in_memory is not None:
            return False
        goes_on = how.resume or how.shard is not None
        with files.in_one_line(f"write {self.path}"):
            if not (goes_on or how.overwrite) and os.path.lexists(self.path):
                raise RequestError(
                    f"output {shown(str(self.path))} exists: --resume continues it, "
                    "--overwrite replaces it, -o names another file"
                )
            if not how.overwrite and self.path.exists():
                if not self._is_ours():
                    text = f"holds another {self.request.content}: --resume cannot continue it"
                    raise RequestError(f"{self.path} {text}")
                return True
            if not (goes_on or how.overwrite) and any(self.folder.glob("*.npz")):
                text = "holds an unfinished run: --resume goes on with it"
                raise RequestError(f"{self.folder} {text}")
        return False

    def carry_out(self, how: Any, work: Callable[[], Write | None]) -> bool:
        """Do the `work` of a run and put its archive in place; return False if it is there already.

        The work saves blocks as they are finished, and returns what writes the archive, or None if
        blocks are missing that others compute.  Raises `Interrupted` on a signal and `RequestError`
        if the archive cannot be written; finished blocks are there for --resume.
        """
        if self.begin(how):
            self._remove()
            return False
        if how.resume and not self.folder.exists():
            for other in self.path.parent.glob(f"{escape(self.path.name)}.*.blocks"):
                text = f"{other} is of another request or version: nothing in it is used"
                print(printable(text), file=sys.stderr)
        with interrupts.stop_on_signals() as stop:
            try:
                write = interrupts.stoppable(work)()
                if write is not None:
                    self._deliver(write, how.overwrite)
                elif self.is_delivered():
                    self._remove()
            except (interrupts.Stopped, KeyboardInterrupt):
                if self.path.named is None:
                    words = "what was computed is lost, because no archive was named (to=)"
                else:
                    count, of = len(list(self.folder.glob("*.npz"))), ""
                    if self.keys is not None:
                        of = f" of {len(self.keys)}"
                        count = len(self.keys) - len(self.missing(self.keys))
                    again = " with --resume" if not (how.overwrite or how.shard) else ""
                    words = f"{count}{of} blocks are kept in {self.folder}; "
                    words += f"the same command{again} goes on from there"
                raise interrupts.Interrupted(f"interrupted: {words}", stop.status) from None
        return True

    def _is_ours(self) -> bool:
        with archive.read(self.path) as view:
            return view.text("scan_hash") == self.request.hash

    def is_delivered(self) -> bool:
        """Return True if an archive of this request is in its place, whoever has put it there."""
        with suppress(RequestError):
            return self._is_ours()
        return False

    def _deliver(self, write: Write, overwrite: bool) -> None:
        """Write the archive, put it in its place unless another is there, and remove the blocks."""
        if self._in_memory is not None and self.path.unnamed is not None:
            write(self.path)
            self.path.unnamed.request = self.request
            self._in_memory.clear()
            return
        temporary = _temporary(self.folder)
        intact = " (the blocks are intact, use --resume)" if any(self.folder.glob("*.npz")) else ""
        with files.in_one_line(f"write {self.path}{intact}"):
            try:
                self.folder.mkdir(exist_ok=True)
                write(temporary)
                (replace_target if overwrite else publish)(temporary, self.path)
            except (FileExistsError, FileNotFoundError) as error:  # the other removes the blocks
                if not self.is_delivered():
                    if not isinstance(error, FileExistsError):
                        raise
                    raise RequestError(
                        f"{self.path} has come into being meanwhile and is left as it is; all "
                        f"results are kept in {self.folder}: move that file away, then --resume "
                        "makes the archive"
                    ) from None
            finally:
                with suppress(OSError):
                    temporary.unlink()
        self._remove()

    def _remove(self) -> None:
        """Remove the blocks, and the folder unless it holds files of other programs."""
        for pattern in ("*.npz", "*.tmp"):
            for file in self.folder.glob(pattern):
                file.unlink(missing_ok=True)
        with suppress(OSError):
            self.folder.rmdir()

    def writer(
        self,
        scales: Sequence[Scale],
        contents: Iterable[tuple[Dataset, np.ndarray]],
        free: Collection[str] = (),
        **about: Value,
    ) -> Write:
        """Return what writes an archive of arrays that are not empty; `free` have no attribute."""
        request = self.request
        filled = [(entry, values) for entry, values in contents if values.size]
        table = Table.of(
            (entry for entry, _ in filled), {scale.name: scale.values.size for scale in scales}
        )
        about, when = {**request.about, "content": request.content, **self.spent, **about}, now()

        def attrs() -> dict[str, Value]:
            return {k: v for k, v in attributes(request, about, when).items() if k not in free}

        return lambda path: archive.write(path, table, scales, archive.whole(filled), attrs)


def _temporary(folder: Path) -> Path:
    """Return the path of a temporary file, which nobody can foresee."""
    return folder / f"{secrets.token_hex(8)}.tmp"


def publish(temporary: Path, path: Path) -> None:
    """Give a file the name `path`; if something has that name by now, raise FileExistsError."""
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: the name is taken first, and then filled
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
        os.replace(temporary, path)
    files.sync_folder(path.parent)


def replace_target(temporary: Path, path: Path) -> None:
    """Put a file in the place of `path`, or of what this link points to on any file system."""
    target = Path(os.path.realpath(path))
    try:
        os.replace(temporary, target)
        files.sync_folder(target.parent)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        with files.whole(target, archive=True) as near:
            shutil.copyfile(temporary, near)
