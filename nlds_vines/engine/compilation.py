"""Messages about compiling, and a second process that compiles half of it.

Compiling takes as long as thousands of orbits.  If there is a second processor, another process
compiles the verdict while this one compiles the orbit, and leaves it on the disk, from where this
process loads it.  If the other process fails, this one compiles the verdict itself.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from nlds_vines.engine.records import JUDGED
from nlds_vines.errors import RequestError
from nlds_vines.runs import interrupts, progress
from nlds_vines.runs.executors import free_memory, processors, threads_in_use
from nlds_vines.runs.progress import Clock, Tell

# time [s] to compile each kernel of an SSul NES, and one of the functions of a kernel, for messages
SECONDS = {"orbit": 12, "verdict": 12, "branches": 12, "entry": 5}
TIMES = {"a host": 2.5}  # as long, by the key of a scene
EACH = 0.045
LONGEST = 600.0  # longest time [s] to wait for the other process
MEMORY = 700_000_000  # bytes of a process that compiles the kernels of a scan

Process = subprocess.Popen[bytes]


class Needed(NamedTuple):
    """What determines the kernels: the `key` of a scene, a method, and a record."""

    scene: str
    method: str
    want: tuple[str, ...]


def kernels_of(want: Collection[str]) -> tuple[str, ...]:
    """Return the kernels of a record in the order of their use: "orbit", then "verdict"."""
    judged = not JUDGED.isdisjoint(want)
    return ("orbit", *["verdict"] * judged)


_silent = False


@contextmanager
def silent(quiet: bool) -> Iterator[None]:
    """Suppress the messages of `notice` within the block if `quiet`."""
    global _silent
    before, _silent = _silent, _silent or quiet
    try:
        yield
    finally:
        _silent = before


def notice(quiet: bool = False) -> Tell | None:
    """Return a function that prints messages in Python; None if quiet, or in a worker of a pool."""
    is_worker = multiprocessing.parent_process() is not None
    return None if quiet or _silent or is_worker else progress.notice()


class Compilation:
    """Reports what is compiled; `helped` lets another process compile the verdict."""

    waited = 0.0  # seconds that this process has compiled, or waited for the other one, in all

    def __init__(self, needed: Needed, tell: Tell | None, helped: bool) -> None:
        self._needed, self._tell, self._helped = needed, tell, helped
        self._began: float | None = None  # time of the first compilation
        self._clock: Clock | None = None
        self._seconds, self._done = 0.0, 0  # estimate of the time; number of compiled functions
        self._other: Process | None = None

    @contextmanager
    def followed(self, kernels: Mapping[Callable[..., Any], str]) -> Iterator[None]:
        """Report what is compiled within the block, until all `kernels` are or the block ends.

        `kernels` are compiled functions with the names that `kernels_of` gives them.  Raises
        `RequestError` if memory does not suffice, `Stopped` if a signal has asked to stop.
        """
        from nlds_vines.kernels.numerics.compiling import told_of_compilations

        is_abandoned, left = interrupts.abandoned(), set(kernels)

        def begins(kernel: Any) -> None:
            interrupts.check()
            # an abandoned call, whose thread a kernel still holds, hears of later compilations
            if self._began is None and kernel in kernels and not is_abandoned():
                self._begin(kernels[kernel])

        def ends(kernel: Any) -> None:
            self._done += 1
            left.discard(kernel)
            if not left:  # what follows within the block computes
                self._end()

        try:
            with told_of_compilations(begins, ends):
                yield
        finally:
            self._end()

    def await_verdict(self) -> None:
        other, until = self._other, time.perf_counter() + LONGEST
        while other is not None and time.perf_counter() < until:
            interrupts.check()
            with suppress(subprocess.TimeoutExpired):
                other.wait(0.2)
                break

    def _begin(self, name: str) -> None:
        """Report that the kernel `name` and those after it are about to be compiled."""
        free = free_memory()
        if free is not None and free < MEMORY:
            raise RequestError(
                f"compiling the kernels takes {progress.size(MEMORY)} of memory, "
                f"{progress.size(max(free, 0))} are free: a run where there is more fills the cache"
            )
        self._began = time.perf_counter()
        names = kernels_of(self._needed.want)
        left = list(names[names.index(name) :] if name in names else (name,))
        if "verdict" in left[1:] and self._helped and may_help():
            self._other = begin(self._needed)
            left.remove("verdict")
        tell, is_abandoned = self._tell, interrupts.abandoned()
        self._done = 0
        self._seconds = TIMES.get(self._needed.scene, 1.0) * sum(SECONDS[name] for name in left)
        if tell is not None:
            self._clock = Clock(lambda *args: None if is_abandoned() else tell(*args), self._words)

    def _words(self, elapsed: float) -> str:
        """Return the message, with the time left at the pace of this machine so far."""
        pace = max(elapsed / (EACH * self._done), 0.2) if self._done > 10 else 1.0
        left = max(self._seconds * pace - elapsed, 1.0)
        return (
            f"compiling the equations of {self._needed.scene} into machine code, which is kept for "
            f"later runs: about {left:.0f} s" + (" to go" if elapsed else "")
        )

    def _end(self) -> None:
        """Report the end; end the other process."""
        if self._began is not None:
            Compilation.waited += time.perf_counter() - self._began
        if self._clock is not None:
            self._clock.stop()
        if self._other is not None:
            self._other.kill()
            self._other.communicate()
        self._began = self._clock = self._other = None


def begin(needed: Needed) -> Process | None:
    """Start the process that compiles the verdict; None if that fails."""
    call = "import sys; from nlds_vines.engine import batch; batch.compile_verdict(*sys.argv[1:])"
    wanted = needed.scene, needed.method, ",".join(needed.want)
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-W", "ignore", "-c", call, *wanted],
            stdin=subprocess.PIPE,  # with which it ends, also if this process is killed
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for this process, which ends the other
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
    except (OSError, ValueError):
        return None


def may_help() -> bool:
    """Return True if another process may compile beside this one."""
    free = free_memory()
    return (
        min(processors(), threads_in_use()) > 1
        and multiprocessing.parent_process() is None  # the siblings of a worker compile, too
        and (free is None or free > 2 * MEMORY)
    )
