"""Kernels compiled by a process of their own, which leaves them in the cache on the disk.

The kernels of a scan are two, or three where it records errors: `orbit` runs orbits, `verdict`
says what they are, `error` retraces periods.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
from collections.abc import Collection, Iterable
from typing import NamedTuple

from nlds_vines.errors import RequestError
from nlds_vines.orbits.wants import JUDGED
from nlds_vines.runs.machine import free_memory, processors
from nlds_vines.runs.threads import threads_in_use

MEMORY = 1_000_000_000
"""Bytes that a process takes to compile the kernels of one scan, with what it has loaded."""

Process = subprocess.Popen[str]


class Needed(NamedTuple):
    """What kernels are compiled for: a scene, by its `key`, a method, and a record."""

    scene: str
    method: str
    want: tuple[str, ...]


def kernels_of(want: Collection[str]) -> tuple[str, ...]:
    """Return the names of the kernels that a record needs, in the order of their use."""
    judged = not JUDGED.isdisjoint(want)
    return ("orbit", *["verdict"] * judged, *["error"] * ("error" in want))


def begin(kernels: Iterable[str], needed: Needed, *, writes: bool) -> Process | None:
    """Begin to compile kernels in a process of its own (`ahead`); None where there can be none.

    Arguments: the names of the `kernels`, and what they are `needed` for.  One process at a time
    `writes` the files of inner kernels; others only read them, and write those of their own.

    The process writes a line for each kernel to its standard output.  It ends when its standard
    input does, so also when this process is killed.
    """
    scene, method, want = needed
    words = ["writes" if writes else "reads", ",".join(kernels), scene, method, ",".join(want)]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-W", "ignore", "-m", "nlds_vines.orbits.ahead", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,  # Ctrl-C is for this process, which then ends that one
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
    except (OSError, ValueError):
        return None


def end(process: Process) -> None:
    """End a process that was begun, unless it has ended, and leave nothing of it."""
    process.kill()
    process.communicate()


def may_help() -> bool:
    """Tell whether another process may compile beside this one.

    Not on one processor, nor where one thread is asked for; not beside other processes of a pool,
    which compile, too; and not where memory is short.
    """
    free = free_memory()
    return (
        min(processors(), threads_in_use()) > 1
        and multiprocessing.parent_process() is None
        and (free is None or free > 2 * MEMORY)
    )


def refuse_without_memory() -> None:
    """Raise `RequestError` where memory does not suffice to compile."""
    free = free_memory()
    if free is not None and free < MEMORY:
        raise RequestError(
            f"compiling the kernels takes {MEMORY / 1e9:.2g} GB of memory, "
            f"{max(free, 0) / 1e9:.2g} GB are free: `nlds-vines compile` fills the cache where "
            "there is more"
        )
