"""Threads that the kernels use; processors, free memory and disk of this machine."""

from __future__ import annotations

import os
import re
import resource
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

from nlds_vines.errors import RequestError, shown

MOST_THREADS = 4096
"""Threads that may be asked for: more than any machine has, so that a typing error is noticed."""

_used: int | None = None  # as `use_threads` was asked; None for all


def check_environment(environment: Mapping[str, str] = os.environ) -> None:
    """Raise `RequestError` for variables with which Numba could not even be loaded.

    Numba itself is not loaded: it raises errors of many lines, or passes over what it cannot read.
    """
    number = environment.get("NUMBA_NUM_THREADS")
    if number is not None and not 1 <= _whole(number) <= MOST_THREADS:
        raise RequestError(
            f"NUMBA_NUM_THREADS = {shown(number)} in the environment must be a whole number from 1 "
            f"to {MOST_THREADS}"
        )


def _whole(text: str) -> int:
    """Return the number in plain digits, 0 for anything else."""
    return int(text) if re.fullmatch(r"\s*[0-9]{1,9}\s*", text) else 0


def use_threads(threads: int | None) -> int:
    """Let the kernels use `threads` threads, at most one per processor; return how many.

    None takes one per processor.  It holds for this process, whichever thread asks.
    """
    global _used
    most = most_threads()
    _used = most if threads is None else min(threads, most)
    return _used


def threads_in_use() -> int:
    """Return how many threads the kernels use: all there are until `use_threads` says otherwise."""
    return most_threads() if _used is None else _used


def most_threads() -> int:
    """Return how many may be used: NUMBA_NUM_THREADS, or the processors for this process."""
    check_environment()
    number = os.environ.get("NUMBA_NUM_THREADS")
    if number is not None:
        return _whole(number)
    return processors()


# ---- what this machine has -----------------------------------------------------------------------


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_memory() -> int | None:
    """Return how many bytes this process may still take; None if unknown."""
    return min(_limits(), default=None)


def free_disk(folder: Path) -> int | None:
    """Return how many bytes may be written below a folder; None if unknown."""
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return None


def _limits() -> Iterator[int]:
    """Yield what limits this process [bytes]: free memory, the control group, `ulimit -v`."""
    for path, key in (("/proc/meminfo", "MemAvailable:"), ("/sys/fs/cgroup/memory.max", "")):
        try:
            lines = Path(path).read_text(encoding="ascii").splitlines()
        except OSError:
            continue
        for line in lines:
            words = line.removeprefix(key).split()
            if line.startswith(key) and words[0].isdigit():
                yield int(words[0]) * (1024 if words[1:] == ["kB"] else 1)
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY:
        yield limit
