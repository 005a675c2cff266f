"""Files that survive a power cut: they appear whole or not at all.  And locks.

A writer may be killed, or the power cut, between any two system calls.  So no file is written in
place: the bytes go to a temporary file, are forced to the disk (fsync), and take their name by a
rename, which is forced to the disk as well (fsync of the folder).  What is computed into memory or
by another library goes through `whole`, which also says what must not be replaced.

What `write` writes ends in the CRC-32 of all bytes before it, which `read` checks.
"""

from __future__ import annotations

import errno
import fcntl
import os
import secrets
import shutil
import stat
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from nlds_vines.errors import RequestError

Buffer = bytes | memoryview

_HDF5 = b"\x89HDF\r\n\x1a\n"
"""The first bytes of every archive."""

_CRC_BYTES = 4
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


def beside(path: Path) -> Path:
    """Return a path for a temporary file beside `path`, which nobody can foresee or has prepared.

    It is short, as the name of `path` may be a long one.
    """
    return path.with_name(f"{secrets.token_hex(8)}.tmp")


def write(path: Path, *pieces: Buffer) -> None:
    """Write `pieces` and their CRC-32 to the file `path`, and force it to the disk.

    Each of two writers of the same name has a temporary file of its own, and the last rename wins.
    Raises OSError, and then leaves the file as it was.
    """
    temporary = beside(path)
    crc = 0
    try:
        with temporary.open("xb") as file:
            for piece in pieces:
                crc = zlib.crc32(piece, crc)
                file.write(piece)
            file.write(crc.to_bytes(_CRC_BYTES))
            file.flush()
            os.fsync(file.fileno())
        replace(temporary, path)
    except BaseException:
        with suppress(OSError):  # the file may not exist yet
            temporary.unlink()
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text as the file `path`, as `whole`; `RequestError` of one line where that fails."""
    with in_one_line(f"write {path}"), whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def protection(path: Path, *, archive: bool = False) -> str | None:
    """Return in words what forbids that the file `path` is replaced; None where nothing does.

    Arguments: `archive` says that it is an archive which is to take its place: nothing else
    replaces an archive, or what has an archive's name.  What may not be written is not replaced,
    although a rename could.  Raises OSError where the file cannot be looked at.
    """
    try:
        with open_regular(path) as file:
            is_archive = file.read(len(_HDF5)) == _HDF5
            mode = os.fstat(file.fileno()).st_mode
    except FileNotFoundError:
        return None
    except PermissionError:  # it cannot be read, and so may be an archive
        is_archive, mode = True, path.stat().st_mode
    except ValueError as error:
        return str(error)
    if not mode & 0o222:
        return "it is read-only"
    if is_archive and not archive:
        return "it is an archive, which nothing else replaces"
    return None


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading.

    Raises ValueError for anything else, OSError where nothing can be opened: to read a pipe or a
    device might never end.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would be waited for
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise ValueError("it is no regular file")
    return os.fdopen(descriptor, "rb")


def read(path: Path) -> bytes:
    """Return the bytes that `write` wrote, without their checksum.

    Raises ValueError if they have changed, or as `open_regular`.
    """
    with open_regular(path) as file:
        data = file.read()
    data, crc = data[:-_CRC_BYTES], data[-_CRC_BYTES:]
    if crc != zlib.crc32(data).to_bytes(_CRC_BYTES):
        raise ValueError("its checksum is wrong")
    return data


def replace(temporary: Path, path: Path) -> None:
    """Rename a file that is on the disk to `path`, and force the rename to the disk."""
    os.replace(temporary, path)
    _sync_folder(path)


def publish(temporary: Path, path: Path) -> None:
    """Give a file that is on the disk the name `path`, which nothing else may have.

    Raises FileExistsError where something has that name by now, and leaves both as they are.
    """
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: the name is taken first, and then filled
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
        os.replace(temporary, path)
    else:
        os.unlink(temporary)
    _sync_folder(path)


def replace_target(temporary: Path, path: Path) -> None:
    """Put a file that is on the disk in the place of `path`, as a shell's `>` would.

    Where `path` is a symbolic link, the link stays, and what it points to is replaced, be it on
    another file system.
    """
    target = Path(os.path.realpath(path))
    try:
        replace(temporary, target)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        with whole(target, archive=True) as near:
            shutil.copyfile(temporary, near)


@contextmanager
def whole(path: Path, *, archive: bool = False) -> Iterator[Path]:
    """Return the path of a temporary file that becomes `path` at the end of the `with` block.

    The file is forced to the disk.  A symbolic link stays, and what it points to is replaced.  If
    the block fails, everything is as it was.  Arguments: `archive` as in `protection`; raises
    `RequestError` where that forbids to replace the file.
    """
    target = Path(os.path.realpath(path))
    if reason := protection(target, archive=archive):
        raise RequestError(f"cannot write {path}: {reason}")
    temporary = beside(target)
    try:
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def _sync_folder(path: Path) -> None:
    """Force the name of a file to the disk."""
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def reserve(path: Path, size: int) -> None:
    """Raise OSError unless the disk has room for a file `path` of `size` bytes.

    HDF5 may lose data silently, or crash, when the disk fills while it writes: it is not begun.
    """
    trial = beside(path)
    try:
        with trial.open("xb") as file:
            if hasattr(os, "posix_fallocate"):  # not on every system
                os.posix_fallocate(file.fileno(), 0, size)
    finally:
        trial.unlink(missing_ok=True)


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
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
        if not _try_lock(descriptor, kind):
            os.close(descriptor)
            if time.monotonic() > until:
                return None
            time.sleep(_RETRY)
        elif _is_open_as(path, descriptor):
            return descriptor
        else:
            os.close(descriptor)  # the holder removed the file meanwhile: others would not see it


def upgrade(descriptor: int) -> bool:
    """Exchange a shared lock for an unshared one; without any if others hold it: return False."""
    return _try_lock(descriptor, fcntl.LOCK_EX)


def held(path: Path) -> bool:
    """Return whether a process holds the lock `path` unshared."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would be waited for
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
