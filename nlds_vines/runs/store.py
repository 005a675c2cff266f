"""A run under way: a folder of finished blocks beside the archive that is made of them.

The name of the folder holds a hash of the request and of all that may change a bit of a result, so
blocks of two requests or of two versions never mix.  A block is an .npz file that appears whole or
not at all.  It holds this hash, its key, and the names, types and shapes of its arrays; one that
cannot be read, or holds anything else, is computed again.  No process locks anything: several may
compute the same blocks, and whoever finds the archive in its place has nothing left to do.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import re
import secrets
import shutil
import sys
import time
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from glob import escape
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import archive, files
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.contents import whole_pieces
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.archives.provenance import Value, attributes, makers, now
from nlds_vines.errors import RequestError, is_command, option, printable, shown
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import threads_in_use

Arrays = Mapping[str, np.ndarray]  # what a block holds, by name
Expected = Mapping[str, tuple[str, tuple[int, ...]]]  # type and shape of arrays by name
Write = Callable[[Path], object]  # writes an archive to a path

FORCE_EVERY = 1.0  # seconds until a block is forced to the disk again, which takes some 10 ms
_ABOUT = "about"  # the entry of a block that says in JSON what it holds
_TEMPORARY = re.compile(r"[0-9a-f]{16}\.tmp")  # the name of a file that is being written
_MOST_DIFFERENCES = 4  # named in a line


class BlockStore:
    """The finished blocks of a request whose archive is to be `path`, each under a key."""

    def __init__(self, path: Path, request: Any) -> None:
        """Choose the folder; nothing is written before the first block is saved."""
        self.path, self.request = ArchivePath.of(path), request
        self._in_memory: dict[object, Arrays] | None = {} if self.path.named is None else None
        self.keys: Sequence[object] | None = None  # that the run needs, if known
        self._seconds: dict[object, float] = {}
        self._forced = -math.inf
        self._outdated: list[str] = []  # what differs in the version of the archive in its place
        self._is_put = False  # whether this run has put its archive in its place

    @cached_property
    def _digest(self) -> str:
        """A hash of all that may change a bit of the blocks."""
        identity = json.dumps([self.request.content, self.request.hash, makers()], sort_keys=True)
        return hashlib.sha256(identity.encode()).hexdigest()[:16]

    @cached_property
    def folder(self) -> Path:
        return Path(self.path.parent, f"{self.path.name}.{self._digest}.blocks")

    @property
    def is_in_memory(self) -> bool:
        """Whether blocks are kept in memory, because the archive has no name."""
        return self._in_memory is not None

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
        about = {"run": self._digest, "key": str(key), "seconds": seconds}
        about |= {"arrays": _described(arrays)}
        temporary, now = _temporary(self.folder), time.monotonic()
        is_due = now - self._forced > FORCE_EVERY
        with files.in_one_line(f"write a block in {self.folder}"):
            try:
                self.folder.mkdir(exist_ok=True)
                with temporary.open("xb") as file:
                    np.savez(file, **arrays, **{_ABOUT: np.array(json.dumps(about))})  # type: ignore[arg-type]
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

    def load(self, key: object, expected: Expected | None = None) -> dict[str, np.ndarray] | None:
        """Return the arrays of a block; None if there is no such block, or a wrong one.

        Wrong is one that is damaged, of another key or run, or without one of the arrays that were
        saved or are `expected`; a line says so.
        """
        if self._in_memory is not None:
            return dict(self._in_memory[key]) if key in self._in_memory else None
        try:
            arrays, about = _read_block(self.file(key))
            if (about["run"], about["key"]) != (self._digest, str(key)):
                raise ValueError(f"it is block {about['key']} of the run {about['run']}")
            _check_arrays(_described(arrays), about["arrays"])
            for name, description in (expected or {}).items():
                if not _is_described(arrays.get(name), *description):
                    raise ValueError(f"{name} is not what this run saves")
            self._seconds[key] = float(about["seconds"])
        except FileNotFoundError:
            return None
        except Exception as error:  # what a damaged file lets zipfile and NumPy raise is not listed
            self.refuse(key, str(error).partition("\n")[0])
            return None
        return arrays

    def refuse(self, key: object, reason: str) -> None:
        """Say in a line that a block is computed again."""
        _say(f"{self.file(key)} is computed again: {reason}")

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
        """Return True if the archive is there, complete and made by this version.

        That of another version is computed again, as numbers may differ.  Raises `RequestError` for
        a file that `how` does not resume or replace.
        """
        self._outdated = []
        if self._in_memory is not None:
            return False
        if self.folder.is_symlink():
            text = "is a symbolic link, through which no blocks are written or removed"
            raise RequestError(f"{self.folder} {text}: move it away")
        goes_on = how.resume or how.shard is not None
        with files.in_one_line(f"write {self.path}"):
            if not (goes_on or how.overwrite) and os.path.lexists(self.path):
                raise RequestError(
                    f"output {shown(str(self.path))} exists: {option('resume')} continues it, "
                    f"{option('overwrite')} replaces it, or name another file"
                )
            if not how.overwrite and self.path.exists():
                with archive.read(self.path) as view:
                    other = self._differences(view)
                    self._outdated = _other_versions(view)
                    if view.text("scan_hash") != self.request.hash:
                        raise RequestError(
                            f"{self.path} holds another {self.request.content}: "
                            f"{option('resume')} cannot continue it; it has {other}"
                        )
                if other and not self._outdated:
                    _say(f"{self.path} is left as it is; it has {other}")
                return not self._outdated
            if not (goes_on or how.overwrite) and any(self.folder.glob("*.npz")):
                text = f"holds an unfinished run: {option('resume')} goes on with it"
                raise RequestError(f"{self.folder} {text}")
        return False

    def carry_out(self, how: Any, work: Callable[[], Write | None]) -> bool:
        """Do the `work` of a run and put its archive in place; return False if it is there already.

        The work saves blocks as they are finished, and returns what writes the archive, or None if
        blocks are missing that others compute.  Raises `Interrupted` on any signal before the end
        and `RequestError` if the archive cannot be written; finished blocks are kept for --resume.
        """
        if self.begin(how):
            self._remove()
            return False
        if self._outdated:
            words = f"{self.path} is of another version, and is computed again"
            _say(f"{words}: {_first(self._outdated)}")
        if how.resume and not self.folder.exists():
            for other in self.path.parent.glob(f"{escape(self.path.name)}.*.blocks"):
                _say(f"{other} is of another request or version: nothing in it is used")
        stop = interrupts.Stop()
        try:
            with interrupts.stop_on_signals(stop):
                write = interrupts.stoppable(work)()
                interrupts.check()
                if write is not None:
                    self._deliver(write, how.overwrite or bool(self._outdated))
                elif self.is_delivered():
                    self._remove()
        except (interrupts.Stopped, KeyboardInterrupt):
            raise interrupts.Interrupted(f"interrupted: {self._kept(how)}", stop.status) from None
        return True

    def _kept(self, how: Any) -> str:
        """Return the message about the blocks of an interrupted run, and how to resume it."""
        if self._in_memory is not None:
            return "what was computed is lost, because no archive was named (to=)"
        if self._is_put:
            return f"{self.path} is complete"
        count, of = len(list(self.folder.glob("*.npz"))), ""
        if self.keys is not None:
            of = f" of {len(self.keys)}"
            count = len(self.keys) - len(self.missing(self.keys))
        again = "the same command" if is_command() else "the same call"
        if not (how.overwrite or how.shard):
            again += f" with {option('resume')}"
        return f"{count}{of} blocks are kept in {self.folder}; {again} goes on from there"

    def is_delivered(self) -> bool:
        """Return True if the archive of this request and version is in its place."""
        with suppress(RequestError), archive.read(self.path) as view:
            is_ours = view.text("scan_hash") == self.request.hash
            return is_ours and not _other_versions(view)
        return False

    def _differences(self, view: archive.ArchiveView) -> str:
        """Return the entries of the request in an archive that differ from this one's, in words.

        Titles and sources of systems differ without a difference in numbers.
        """
        name = "the request in it"
        stored = dict(_entries(parse_toml(view.text("scan"), name)))
        asked = dict(_entries(parse_toml(self.request.to_toml(), name)))
        names = [name for name in {**stored, **asked} if stored.get(name) != asked.get(name)]
        if numbers := [name for name in names if ".sources." not in name]:
            names = numbers  # a source differs with its value
        return _first(
            f"{name} = {shown(stored[name])}" if name in stored else f"no {name}" for name in names
        )

    def _deliver(self, write: Write, overwrite: bool) -> None:
        """Write the archive, put it in its place unless another is there, and remove the blocks."""
        if self._in_memory is not None and self.path.unnamed is not None:
            write(self.path)
            self.path.unnamed.request = self.request
            self._in_memory.clear()
            return
        temporary = _temporary(self.folder)
        intact = ""
        if any(self.folder.glob("*.npz")):
            intact = f" (the blocks are intact, use {option('resume')})"
        with files.in_one_line(f"write {self.path}{intact}"):
            try:
                self.folder.mkdir(exist_ok=True)
                write(temporary)
                interrupts.check()
                (replace_target if overwrite else publish)(temporary, self.path)
                self._is_put = True
            except (FileExistsError, FileNotFoundError) as error:  # the other removes the blocks
                if not self.is_delivered():
                    if not isinstance(error, FileExistsError):
                        raise
                    raise RequestError(
                        f"{self.path} has come into being meanwhile and is left as it is; all "
                        f"results are kept in {self.folder}: move that file away, then "
                        f"{option('resume')} makes the archive"
                    ) from None
            finally:
                with suppress(OSError):
                    temporary.unlink()
        self._remove()

    def _remove(self) -> None:
        """Remove the blocks of this run and what it left half-written, then the folder if empty.

        Other files stay, and nothing outside the folder is touched.
        """
        if self._in_memory is not None or self.folder.is_symlink():
            return
        names = {self.file(key).name for key in (*(self.keys or ()), *self._seconds)}
        with suppress(FileNotFoundError):
            for file in [*self.folder.iterdir()]:
                is_own = file.name in names or _TEMPORARY.fullmatch(file.name) is not None
                if is_own or (file.suffix == ".npz" and self._is_own(file)):
                    file.unlink(missing_ok=True)
        with suppress(OSError):
            self.folder.rmdir()

    def _is_own(self, file: Path) -> bool:
        """Return True if a file says that it is a block of this run, which no key here names."""
        try:
            _, about = _read_block(file)
            return bool((about["run"], f"{about['key']}.npz") == (self._digest, file.name))
        except Exception:  # as of `load`
            return False

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

        return lambda path: archive.write(path, table, scales, whole_pieces(filled), attrs)


def _say(text: str) -> None:
    print(printable(text), file=sys.stderr)


def _described(arrays: Arrays) -> dict[str, list[Any]]:
    """Return the type and the shape of each array by name, as JSON holds them."""
    return {
        name: [array.dtype.str, list(array.shape)]
        for name, array in ((name, np.asarray(values)) for name, values in arrays.items())
    }


def _check_arrays(present: Mapping[str, Any], saved: Mapping[str, Any]) -> None:
    """Raise ValueError with the first array that a block lacks, or has beyond what was saved."""
    for name in {**saved, **present}:
        if name not in present:
            raise ValueError(f"{name} is missing")
        if name not in saved:
            raise ValueError(f"{name} does not belong in it")
        if present[name] != saved[name]:
            (kind, shape), (saved_kind, saved_shape) = present[name], saved[name]
            raise ValueError(f"{name} is {kind} {shape}, not {saved_kind} {saved_shape}")


def _is_described(array: np.ndarray | None, kind: str, shape: tuple[int, ...]) -> bool:
    """Return True for an array of this type and shape; "str" stands for strings of any length."""
    if array is None or array.shape != shape:
        return False
    return array.dtype.kind == "U" if kind == "str" else array.dtype == np.dtype(kind)


def _read_block(file: Path) -> tuple[dict[str, np.ndarray], Any]:
    """Return the arrays of a block, and what it says about itself; any error if it is damaged."""
    with files.open_regular(file) as opened:
        if zipfile.ZipFile(opened).testzip() is not None:
            raise ValueError("its checksum is wrong")
        opened.seek(0)
        arrays = dict(np.load(opened))
    if _ABOUT not in arrays:
        raise ValueError("it does not say what it is")
    return arrays, json.loads(str(arrays.pop(_ABOUT)))


def _other_versions(view: archive.ArchiveView) -> list[str]:
    """Return the versions that made an archive where they differ from those of this process."""
    versions = {name: view.attrs.get(name) for name in makers()}
    return [
        f"{name} {str(versions[name])[:20]}, not {value[:20]}"
        for name, value in makers().items()
        if versions[name] != value
    ]


def _entries(document: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the entries of nested tables with dotted keys."""
    for key, value in document.items():
        if isinstance(value, Mapping):
            yield from _entries(value, f"{place}{key}.")
        else:
            yield f"{place}{key}", value


def _first(words: Iterable[str]) -> str:
    """Return the first few of a list of words, separated by commas."""
    texts = [*words]
    left_out = len(texts) - _MOST_DIFFERENCES
    if left_out > 0:
        texts[_MOST_DIFFERENCES:] = [f"and {left_out} more"]
    return ", ".join(texts)


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
