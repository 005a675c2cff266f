"""A run under way: the folder beside the archive to be, and its locks.

While a run lasts, its archive does not exist yet; the folder `FILE.parts` does.  In it lie a
manifest, which names the request; a lock, which is held while the run is at work; and part files
with what has been computed.  What a part holds is known to the kinds of runs that build on this: a
block of a scan, or the next designs of a search.

A run locks the folder for itself alone.  Shards of one scan share it; each locks its own share.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from nlds_vines.archives import archive, durable
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.provenance import Request, Value
from nlds_vines.errors import RequestError
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.manifest import NAME, Manifest
from nlds_vines.runs.partfile import PATTERN, request_of


@dataclass
class RunFolder:
    """The folder of one run; use `open`, and as a context manager.

    `complete` says that the archive asked for exists already and is sound, so that there is nothing
    to do; `discarded` collects one line for each part that did not verify and must be computed
    again.
    """

    path: Path
    request: Any  # a `Request`; each kind of run says which
    shard: Shard | None = None
    complete: bool = False
    discarded: list[str] = field(default_factory=list)
    _replaces: bool = False
    _begins: bool = False
    _locks: list[int] = field(default_factory=list)

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        request: Request,
        *,
        resume: bool = False,
        overwrite: bool = False,
        shard: Shard | None = None,
    ) -> Self:
        """Begin a run whose archive is to be `path`, or continue it.

        With `resume`, verified parts of the same request are kept.  With `overwrite`, parts are
        discarded, and an archive of that name stays as it is until the new one replaces it.  A
        `shard` joins whatever has been begun of the same scan, and others may be at work beside it.

        Raises `RequestError`, leaving everything as it was, if an archive or parts exist and
        neither option is given, if what is to be resumed belongs to another request, if another
        process is at work on it, or if the folder cannot be written.
        """
        if resume and overwrite:
            raise RequestError("--resume and --overwrite exclude each other: give one of them")
        if shard and overwrite:
            raise RequestError("--shard and --overwrite exclude each other: others may be at work")
        run = cls(ArchivePath.of(path), request, shard)
        with durable.in_one_line(f"write {path}"):
            done = run._archive_is_complete(resume or shard is not None, overwrite)
            if done and not run.folder.exists():
                run.complete = True
                return run
            run.folder.mkdir(exist_ok=True)
            with run._closed_on_error():
                run._take_locks()
                run._settle(resume, overwrite)
        return run

    def refuse(self, *, resume: bool = False, overwrite: bool = False) -> None:
        """Raise `RequestError` where `open` would, and change nothing: for --dry-run."""
        with durable.in_one_line(f"write {self.path}"):
            if durable.held(self.folder / "lock"):
                raise RequestError(self._busy)
            if not (self._archive_is_complete(resume, overwrite) or overwrite):
                self._begun(resume)

    @property
    def content(self) -> str:
        """The kind of request, of `manifest`."""
        return str(self.request.content)

    @property
    def folder(self) -> Path:
        """Where the parts are: `FILE.parts`."""
        return folder_of(self.path)

    @property
    def _busy(self) -> str:
        return f"another run is writing {self.path}: wait for it, or stop it"

    def __enter__(self) -> Self:
        """Return the run itself."""
        return self

    def __exit__(self, _: object, error: BaseException | None, trace: object) -> None:
        """Release the folder; the parts stay.  A run refused before it has any leaves no folder."""
        if isinstance(error, RequestError) and self._begins and not self._has_parts():
            self._remove()
        self.close()

    def close(self) -> None:
        """Release the folder.  A folder in which nothing was begun is removed."""
        if not self._locks:
            return
        if self.shard or (self.folder / NAME).exists():
            self._unlock()
        else:
            self._remove()

    def is_alone(self) -> bool:
        """End the work of a shard; return True if no other is at work, which then cannot begin.

        The last shard to call it finds itself alone: each gives up its share of the lock.
        """
        return durable.upgrade(self._locks[0])

    def begun_by(self) -> dict[str, Value]:
        """Return the arguments of the process that began the run, as an attribute `argv`."""
        manifest = Manifest.read(self.folder)
        return {"argv": json.dumps(manifest.argv)} if manifest else {}

    def deliver(self, make: Callable[[Path], object]) -> None:
        """Put the archive in place that `make` writes to a path, and remove the folder.

        Raises `RequestError` if the disk is full, and where a file has come into being under the
        archive's name that this run is not to replace.  If it ends early for any reason, the parts
        are intact, and an archive of that name is as it was.
        """
        temporary = durable.beside(self.folder / "archive")
        intact = " (the parts are intact, use --resume)" if self._has_parts() else ""
        with durable.in_one_line(f"write {self.path}{intact}"):
            try:
                self._clear("*.tmp")  # of runs that were killed: no other is at work here
                make(temporary)
                self._put_in_place(temporary)
            finally:
                with suppress(OSError):
                    temporary.unlink()
            self._remove()

    def _put_in_place(self, temporary: Path) -> None:
        """Give the finished archive its name."""
        if self._replaces:
            durable.replace_target(temporary, self.path)
            return
        try:
            durable.publish(temporary, self.path)
        except FileExistsError:
            raise RequestError(
                f"{self.path} has come into being meanwhile and is left as it is; all results are "
                f"kept in {self.folder}: move that file away, then --resume makes the archive"
            ) from None

    def _archive_is_complete(self, resume: bool, overwrite: bool) -> bool:
        """Tell whether the archive is there and this request's; refuse to touch any other."""
        if overwrite or not self.path.exists():
            return False
        if not resume:
            raise RequestError(f"{self.path} exists: --overwrite replaces it, -o names another")
        with archive.read(self.path) as view:
            same = view.text("scan_hash") == self.request.hash
        if not same:
            manifest = Manifest.read(self.folder)
            if manifest and manifest.overwrite:
                return False  # the run to be resumed began with --overwrite
            raise RequestError(
                f"{self.path} holds another {self.content}: --resume cannot continue it"
            )
        return True

    def _take_locks(self) -> None:
        """Lock the folder: a run for itself alone, a shard together with others."""
        self._lock("lock", self._busy, shared=self.shard is not None)
        if self.shard:
            name = f"shard-{self.shard.index}-of-{self.shard.count}.lock"
            self._lock(name, f"another run is computing shard {self.shard} of {self.path}")

    def _lock(self, name: str, busy: str, **how: Any) -> None:
        descriptor = durable.lock(self.folder / name, **how)
        if descriptor is None:
            raise RequestError(busy)
        self._locks.append(descriptor)

    def _settle(self, resume: bool, overwrite: bool) -> None:
        """Keep or clear what the folder holds, and write the manifest where there is none."""
        if self.shard:  # other shards may be at this point as well: one after the other
            self._lock("settling.lock", f"{self.folder} is locked", patience=60.0)
        if self._archive_is_complete(resume, overwrite):  # again: another run may just have ended
            self.complete = True
            if not self.shard:
                self._remove()
            return
        if overwrite:
            self._clear()
        found = self._begun(resume)
        self._replaces = overwrite or (found is not None and found.overwrite)
        self._begins = not (found or self.shard)
        if not found:
            Manifest.of(self.request, overwrite).write(self.folder)
        if self.shard:
            os.close(self._locks.pop())

    def _begun(self, resume: bool) -> Manifest | None:
        """Return the manifest of what is to be continued, if any; refuse what cannot be."""
        try:
            found = Manifest.read(self.folder)
        except RequestError as error:
            if not ((resume or self.shard) and self._parts_are_ours()):
                raise
            self.discarded.append(f"{NAME} is made again: {error}")
            return None
        if found and not (resume or self.shard):
            text = "--resume continues it, --overwrite discards it"
            raise RequestError(f"{self.folder} holds an unfinished run: {text}")
        if found and found.scan_hash != self.request.hash:
            whose = f"{found.title!r}, {found.scan_hash[:12]}"
            raise RequestError(
                f"{self.folder} holds the parts of another {found.content} ({whose})"
            )
        return found

    def _parts_are_ours(self) -> bool:
        """Tell whether all parts are of this request, without a manifest that says so."""
        found = {request_of(path) for path in self.folder.glob(PATTERN)} - {None}
        return found == {self.request.hash}

    def _has_parts(self) -> bool:
        """Tell whether anything has been computed into the folder."""
        return any(self.folder.glob(PATTERN))

    def _clear(self, *patterns: str) -> None:
        """Remove what has such names, or all: the manifest last, so that no part is without it."""
        for pattern in patterns or (PATTERN, "*.tmp", NAME):
            for path in self.folder.glob(pattern):
                path.unlink()

    def _remove(self) -> None:
        """Remove the folder and its locks: from then on another run may begin."""
        self._clear()
        for path in (*self.folder.glob("*.lock"), self.folder / "lock"):
            path.unlink(missing_ok=True)
        with suppress(OSError):  # it holds files of other programs, or another run has begun
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
