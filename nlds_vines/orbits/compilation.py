"""What must be compiled before orbits can be run: told in words, half of it done elsewhere.

The kernels of a scan are two, or three where it records errors: `orbit` runs orbits, `verdict`
says what they are, `error` retraces periods.  Compiling them takes as long as thousands of orbits.
So where there is a second processor, another process compiles the verdict meanwhile; it leaves it
in the cache on the disk, where this process finds it.  Whatever goes wrong there, this process
compiles the verdict itself.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from nlds_vines.errors import RequestError
from nlds_vines.kernels import lanes
from nlds_vines.kernels.compiling import told_of_compilations
from nlds_vines.orbits.wants import JUDGED
from nlds_vines.runs.machine import free_memory, processors
from nlds_vines.runs.threads import threads_in_use

if TYPE_CHECKING:
    from nlds_vines.orbits.batch import Wanted

SECONDS = {"orbit": 12, "verdict": 16, "error": 7}
"""Time [s] that compiling each kernel takes, of an SSul NES with energies; for a message."""

MEMORY = 700_000_000
"""Bytes that a process takes to compile kernels, one after the other."""

LONGEST = 600.0
"""Seconds to wait for the other process: it has lost its way, or its disk."""

Tell = Callable[[str], object]
"""Takes a line of text for the user."""


def kernels_of(want: Collection[str]) -> tuple[str, ...]:
    """Return the names of the kernels that a record needs, in the order of their use."""
    judged = not JUDGED.isdisjoint(want)
    return ("orbit", *["verdict"] * judged, *["error"] * ("error" in want))


class Compilation:
    """Follows what is compiled for orbits of one scene, one record and one method."""

    def __init__(self, wanted: Wanted, tell: Tell | None, helped: bool) -> None:
        """Take what is `wanted`, who is told, and whether another process may help."""
        self._wanted, self._tell, self._helped = wanted, tell, helped
        self._known: set[str] = set()  # kernels that need not be told any more
        self._other: subprocess.Popen[bytes] | None = None

    @contextmanager
    def followed(self) -> Iterator[None]:
        """Follow what is compiled within the block; no other process outlives it.

        Raises `RequestError` where memory does not suffice to compile.
        """
        try:
            with told_of_compilations(self._begins):
                yield
        finally:
            self._leave()

    def await_verdict(self) -> None:
        """Wait for the process that compiles the verdict, if there is one."""
        if self._other is not None:
            with suppress(subprocess.TimeoutExpired):
                self._other.wait(LONGEST)
            self._leave()

    def _begins(self, kernel: Any) -> None:
        """Note that a kernel is about to be compiled, which is not in the cache."""
        if kernel not in (lanes.run_lanes, lanes.judge_lanes):
            return
        _refuse_without_memory()
        named = kernels_of(self._wanted.want)
        left = named if kernel is lanes.run_lanes else ("verdict",)
        if self._known.issuperset(left):
            return
        self._known.update(left)
        both = "orbit" in left and "verdict" in left
        if both and self._helped and may_help():
            self._other = elsewhere("verdict", self._wanted)
        if self._tell is not None:
            seconds = sum(SECONDS[name] for name in left)
            seconds -= 0 if self._other is None else SECONDS["orbit"]
            kind, names = self._wanted.scene.kind, ", ".join(left)
            self._tell(f"compiling the kernels of {kind}: {names} (once; about {seconds} s)")

    def _leave(self) -> None:
        """End the other process, if there is one."""
        other, self._other = self._other, None
        if other is not None:
            end(other)


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


def elsewhere(kernel: str, wanted: Wanted) -> subprocess.Popen[bytes] | None:
    """Begin to compile a kernel in a process of its own (`ahead`); None where there can be none.

    The process ends when its standard input does, so also when this process is killed.  It writes
    a line to its standard output.
    """
    words = [kernel, wanted.scene.kind, wanted.method, ",".join(wanted.want)]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-W", "ignore", "-m", "nlds_vines.orbits.ahead", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for this process, which then ends that one
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
    except (OSError, ValueError):
        return None


def end(process: subprocess.Popen[bytes]) -> None:
    """End a process of `elsewhere`, unless it has ended, and leave nothing of it."""
    process.kill()
    process.communicate()


def _refuse_without_memory() -> None:
    free = free_memory()
    if free is not None and free < MEMORY:
        raise RequestError(
            f"compiling the kernels takes {MEMORY / 1e9:.2g} GB of memory, "
            f"{max(free, 0) / 1e9:.2g} GB are free: `nlds-vines compile` fills the cache where "
            "there is more"
        )
