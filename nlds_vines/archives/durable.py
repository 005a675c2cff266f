"""Part files with a checksum, and locks: what runs under way are kept by.

What `write` writes ends in the CRC-32 of all bytes before it, which `read` checks.
"""

from __future__ import annotations

import errno
import fcntl
import os
import secrets
import shutil
import time
import zlib
from contextlib import suppress
from pathlib import Path

from nlds_vines.archives.files import in_one_line as in_one_line
from nlds_vines.archives.files import open_regular as open_regular
from nlds_vines.archives.files import sync_folder
from nlds_vines.archives.files import whole as whole

Buffer = bytes | memoryview

_CRC_BYTES = 4
_RETRY = 0.02  # s between two attempts to take a lock


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
    sync_folder(path.parent)


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
    sync_folder(path.parent)


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
