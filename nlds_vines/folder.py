"""A run under way: the folder beside the archive to be, which one process holds at a time.

While a run lasts, its archive does not exist; the folder `FILE.parts` does.  A manifest in it says
whose run it is, a lock that it is at work.  What the folder holds besides, a scan's blocks or a
search's journal, is the business of those who build on it.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol, Self

from nlds_vines import archive, durable
from nlds_vines.errors import RequestError


class Request(Protocol):
    """What is computed: a title for people, and the hash of all that determines the numbers."""

    @property
    def title(self) -> str:
        """One line for people."""

    @property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers."""


@dataclass
class RunFolder:
    """The folder of one run; use `open`, and as a context manager.

    `complete` says that the archive asked for exists already and is sound, so that there is
    nothing to do; `discarded` collects one line for each file that did not verify and whose
    content must be computed again.
    """

    path: Path
    scan: Any  # a `Request`; each kind of run narrows it
    complete: bool = False
    discarded: list[str] = field(default_factory=list)
    _lock: int | None = None

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        scan: Request,
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> Self:
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

    def __enter__(self) -> Self:
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

    @property
    def _manifest_path(self) -> Path:
        return self.folder / "manifest.json"

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
