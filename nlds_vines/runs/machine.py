"""What this machine has for this process: processors, free memory, free disk."""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Iterator
from pathlib import Path


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
