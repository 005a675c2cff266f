"""Files that survive a power cut: they appear whole or not at all.  Seals, and locks.

A writer may be killed, or the power cut, between any two system calls.  So no file is written in
place: the bytes go to a temporary file, are forced to the disk (fsync), and take their name by a
rename, which is forced to the disk as well (fsync of the folder).

A seal is the SHA-256 of all bytes before it, appended to the file.  It detects every flipped bit,
in data, headers and padding alike.  HDF5 ignores bytes after its own end of file, so a sealed
archive is an ordinary archive.
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
_SLAB = 1 << 20  # bytes hashed at a time, so that a file may be larger than the memory
_RETRY = 0.02  # s between two attempts to take a lock


@contextmanager
def in_one_line(doing: str) -> Iterator[None]:
    """Turn an error of the operating system or of HDF5 into a `RequestError` of one line.

    Arguments: `doing`, what is attempted inside: the message is "cannot <doing>: <reason>".

    HDF5 reports a full disk as OSError or, while closing, as RuntimeError, both over many lines.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise RequestError(f"cannot {doing}: {reason}") from error


def write(path: Path, *pieces: Buffer) -> None:
    """Write `pieces` one after the other and a seal to the file `path`, and force it to the disk.

    Each of two writers of the same name has a temporary file of its own, and the last rename wins.
    Raises OSError, and then leaves the file as it was.
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
        with suppress(OSError):  # the file may not exist yet
            temporary.unlink()
        raise


def read(path: Path) -> bytes:
    """Return the bytes that `write` wrote, without the seal; ValueError if any bit has changed."""
    sealed = path.read_bytes()
    data = sealed[:-_SEAL_BYTES]
    if sealed[-_SEAL_BYTES:] != _seal(hashlib.sha256(data)):
        raise ValueError("its seal is broken")
    return data


def replace(temporary: Path, path: Path) -> None:
    """Rename a file that is on the disk to `path`, and force the rename to the disk."""
    os.replace(temporary, path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def reserve(path: Path, size: int) -> None:
    """Raise OSError unless the disk has room for a file `path` of `size` bytes.

    HDF5 may lose data silently, or crash, when the disk fills while it writes: it is not begun.
    """
    trial = path.with_name(path.name + ".room.tmp")
    try:
        with trial.open("wb") as file:
            if hasattr(os, "posix_fallocate"):  # not on every system
                os.posix_fallocate(file.fileno(), 0, size)
    finally:
        trial.unlink(missing_ok=True)


def seal(path: Path) -> None:
    """Append a seal to a finished file and force the file to the disk."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(_seal(digest))
        file.flush()
        os.fsync(file.fileno())


def sealed(path: Path) -> bool:
    """Return whether a file ends in the seal of all the bytes before it."""
    size = path.stat().st_size - _SEAL_BYTES
    if size < 0:
        return False
    digest = _digest(path, size)
    with path.open("rb") as file:
        file.seek(size)
        return file.read() == _seal(digest)


def lock(path: Path, *, shared: bool = False, patience: float = 0.3) -> int | None:
    """Lock the file `path`, created if need be, for this process.

    Arguments:
        shared: whether other processes may hold the same lock, shared as well.
        patience: seconds to wait for processes that hold the lock only for a moment, as `held`.

    Returns the descriptor, which `os.close` unlocks; None where another process keeps the lock.
    The operating system releases the lock of a process that ends, so no lock outlives its holder.
    """
    kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    until = time.monotonic() + patience
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        if not _try_lock(descriptor, kind):
            os.close(descriptor)
            if time.monotonic() > until:
                return None
            time.sleep(_RETRY)
        elif _is_open_as(path, descriptor):
            return descriptor
        else:
            os.close(descriptor)  # the holder removed the file meanwhile: others would not see it


def held(path: Path) -> bool:
    """Return whether a process holds the lock `path` unshared."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return False
    try:
        return not _try_lock(descriptor, fcntl.LOCK_SH)
    finally:
        os.close(descriptor)


def _try_lock(descriptor: int, kind: int) -> bool:
    """Lock an open file without waiting; return whether that succeeded."""
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_open_as(path: Path, descriptor: int) -> bool:
    """Return whether the open file is the one that has the name `path` now."""
    try:
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _seal(digest: hashlib._Hash) -> bytes:
    """Return the bytes of a seal."""
    return _MARK + digest.hexdigest().encode() + b"\n"


def _digest(path: Path, size: int) -> hashlib._Hash:
    """Return the SHA-256 of the first `size` bytes of a file."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while slab := file.read(min(_SLAB, size)):
            digest.update(slab)
            size -= len(slab)
    return digest
