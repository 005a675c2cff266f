"""Bytes that survive: files that appear whole or not at all, seals, a lock that leaves no trace.

A writer may be killed, or the power cut, between any two system calls.  So nothing is ever written
in place: the bytes go to a temporary name, are forced to the disk, and take their name by a rename,
which the folder is then forced to remember.  A seal (SHA-256 of all that stands before it, appended
to the file) finds every flipped bit, in data, headers and padding alike; HDF5 ignores what follows
its own end of file, so a sealed archive is an ordinary archive.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from nlds_vines.errors import RequestError

Buffer = bytes | memoryview

_MARK = b"\nnlds_vines seal sha256 "
_SEAL_BYTES = len(_MARK) + hashlib.sha256().digest_size * 2 + 1
_SLAB = 1 << 20  # bytes hashed at a time: files of any size need no more memory


@contextmanager
def in_one_line(doing: str) -> Iterator[None]:
    """Turn what the operating system or HDF5 says while `doing` something into a `RequestError`.

    HDF5 reports a full disk as OSError or, while closing, as RuntimeError, both over many lines.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise RequestError(f"cannot {doing}: {reason}") from error


def write(path: Path, *pieces: Buffer) -> None:
    """Put the bytes of `pieces`, sealed, under the name `path`: whole and on the disk, or OSError.

    Two writers of one name do not meet: each has a temporary file of its own, and the last rename
    wins.
    """
    temporary = path.with_name(f"{path.name}.{secrets.token_hex(8)}.tmp")
    digest = hashlib.sha256()
    try:
        with temporary.open("wb") as file:
            for piece in pieces:
                digest.update(piece)
                file.write(piece)
            file.write(_seal(digest))
            file.flush()
            os.fsync(file.fileno())
        replace(temporary, path)
    except BaseException:
        with suppress(OSError):  # it may never have come to be
            temporary.unlink()
        raise


def read(path: Path) -> bytes:
    """Return what `write` put there, without its seal; ValueError if a single bit has changed."""
    sealed = path.read_bytes()
    data = sealed[:-_SEAL_BYTES]
    if sealed[-_SEAL_BYTES:] != _seal(hashlib.sha256(data)):
        raise ValueError("its seal is broken")
    return data


def replace(temporary: Path, path: Path) -> None:
    """Rename a file that is on the disk, and force the folder to remember its new name."""
    os.replace(temporary, path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def reserve(path: Path, size: int) -> None:
    """Raise OSError unless a file of `size` bytes could be written beside `path`, or as it.

    For writers that cannot be stopped half-way with grace, as HDF5: ask before they begin.
    """
    trial = path.with_name(path.name + ".room.tmp")
    try:
        with trial.open("wb") as file:
            if hasattr(os, "posix_fallocate"):  # not on every system
                os.posix_fallocate(file.fileno(), 0, size)
    finally:
        trial.unlink(missing_ok=True)


def seal(path: Path) -> None:
    """Append a seal to a finished file and force the whole of it to the disk."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(_seal(digest))
        file.flush()
        os.fsync(file.fileno())


def sealed(path: Path) -> bool:
    """Tell whether a file ends in the seal of all the bytes before it."""
    size = path.stat().st_size - _SEAL_BYTES
    if size < 0:
        return False
    digest = _digest(path, size)
    with path.open("rb") as file:
        file.seek(size)
        return file.read() == _seal(digest)


def lock(path: Path, *, shared: bool = False, patience: float = 0.3) -> int | None:
    """Lock `path`, created if need be, for this process; None if others hold it against us.

    Arguments: with `shared`, others may share it; `patience` [s] outlasts those who hold it only
    for a moment, to look whether anybody does.

    Returns the descriptor to `os.close` when done.  The kernel keeps the lock, not the file: that
    of a dead process is gone with it, so there is no such thing as a stale one.
    """
    kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    until = time.monotonic() + patience
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        if not _locks(descriptor, kind):
            os.close(descriptor)
            if time.monotonic() > until:
                return None
            time.sleep(0.02)
        elif _names(path, descriptor):
            return descriptor
        else:
            os.close(descriptor)  # its owner removed the file meanwhile: this lock guards nothing


def held(path: Path) -> bool:
    """Tell whether some process holds the lock `path` for itself alone."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return False
    try:
        return not _locks(descriptor, fcntl.LOCK_SH)
    finally:
        os.close(descriptor)


def _locks(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _names(path: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _seal(digest: hashlib._Hash) -> bytes:
    return _MARK + digest.hexdigest().encode() + b"\n"


def _digest(path: Path, size: int) -> hashlib._Hash:
    """Return the SHA-256 of the first `size` bytes of a file."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while slab := file.read(min(_SLAB, size)):
            digest.update(slab)
            size -= len(slab)
    return digest
