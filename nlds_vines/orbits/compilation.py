"""What must be compiled before orbits can be run: told in words, and half of it done beside.

Compiling takes as long as thousands of orbits.  Where there is a second processor, another process
(`beside`) compiles the verdict while this one compiles the orbit, and leaves it on the disk, where
this process finds it.  Whatever goes wrong there, this process compiles it itself.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from nlds_vines.errors import RequestError
from nlds_vines.orbits.records import JUDGED
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import free_memory, processors, threads_in_use
from nlds_vines.runs.progress import Clock, Notice, Tell

SECONDS = {"orbit": 12, "verdict": 12, "branches": 12, "entry": 5}
"""Time [s] that compiling each kernel takes, of an SSul NES; for a message."""

EACH = 0.045
"""Time [s] of one of the functions that a kernel consists of; likewise."""

LONGEST = 600.0
"""Seconds to wait for the other process, after which it must have lost its way."""

MEMORY = 700_000_000
"""Bytes that a process takes to compile the kernels of one scan, with what it has loaded."""

Process = subprocess.Popen[str]


class Needed(NamedTuple):
    """What kernels are compiled for: a scene, by its `key`, a method, and a record."""

    scene: str
    method: str
    want: tuple[str, ...]


def kernels_of(want: Collection[str]) -> tuple[str, ...]:
    """Return the names of the kernels that a record needs, in the order of their use.

    `orbit` runs orbits, `verdict` says what they are.
    """
    judged = not JUDGED.isdisjoint(want)
    return ("orbit", *["verdict"] * judged)


def of_lanes() -> Mapping[Callable[..., Any], str]:
    """Return what is called from Python to run many orbits, and the kernel that it is part of."""
    from nlds_vines.kernels.cells import lanes
    from nlds_vines.kernels.numerics import matrices

    return {
        matrices.fill_multipliers: "orbit",  # needed for a verdict, and compiled before it
        lanes.run_lanes: "orbit",
        lanes.judge_lanes: "verdict",
    }


def refuse_without_memory() -> None:
    """Raise `RequestError` where memory does not suffice to compile."""
    free = free_memory()
    if free is not None and free < MEMORY:
        raise RequestError(
            f"compiling the kernels takes {MEMORY / 1e9:.2g} GB of memory, "
            f"{max(free, 0) / 1e9:.2g} GB are free: a run where there is more fills the "
            "cache"
        )


# ---- what is said --------------------------------------------------------------------------------

_silent = False


@contextmanager
def silent(quiet: bool) -> Iterator[None]:
    """Let nothing be told by `notice` within the block, where a command is to be `quiet`."""
    global _silent
    before, _silent = _silent, _silent or quiet
    try:
        yield
    finally:
        _silent = before


def notice(quiet: bool = False) -> Tell | None:
    """Return what tells a user in Python that something is compiled; None when quiet.

    Beside others, the processes of a pool tell nothing.
    """
    beside = multiprocessing.parent_process() is not None
    return None if quiet or _silent or beside else Notice()


class _Told:
    """Tells again and again that something is compiled, and how long it will still take."""

    def __init__(self, tell: Tell, scene: str, seconds: float) -> None:
        """Begin to tell: of a scene, and of so many `seconds` by what is known beforehand."""
        self._scene, self._seconds, self._done = scene, seconds, 0
        is_abandoned = interrupts.abandoned()
        self._clock = Clock(lambda *args: None if is_abandoned() else tell(*args), self._words)

    def note(self, kernel: Any) -> None:
        """Count a function that is compiled."""
        self._done += 1

    def stop(self) -> None:
        """Tell that it has ended."""
        self._clock.stop()

    def _words(self, elapsed: float) -> str:
        """Return what is done, and the rest of the time at the pace of this machine so far."""
        pace = max(elapsed / (EACH * self._done), 0.2) if self._done > 10 else 1.0
        left = max(self._seconds * pace - elapsed, 1.0)
        return (
            f"compiling the equations of {self._scene} into machine code, which is kept for later "
            f"runs: about {left:.0f} s" + (" to go" if elapsed else "")
        )


# ---- this process --------------------------------------------------------------------------------


class Compilation:
    """Follows what is compiled for orbits of one scene, one record and one method."""

    waited = 0.0  # seconds that this process has compiled, or waited for another, all in all

    def __init__(self, needed: Needed, tell: Tell | None, helped: bool) -> None:
        """Take what kernels are `needed` for, who is told, and whether another process may help."""
        self._needed, self._tell, self._helped = needed, tell, helped
        self._began: float | None = None  # when the first kernel was compiled
        self._told: _Told | None = None
        self._other: Process | None = None

    @contextmanager
    def followed(self, parts: Mapping[Callable[..., Any], str] | None = None) -> Iterator[None]:
        """Follow what is compiled within the block; no other process outlives it.

        Arguments: `parts`, what is called from Python, with the name of the kernel it is part of;
        by default `of_lanes`.

        Raises `RequestError` where memory does not suffice to compile, and `Stopped` where a signal
        has asked to stop: at the next of the functions that are compiled.
        """

        from nlds_vines.kernels.numerics.compiling import told_of_compilations

        known = of_lanes() if parts is None else parts
        is_abandoned = interrupts.abandoned()

        def begins(kernel: Any) -> None:
            interrupts.check()
            # of an abandoned call that a kernel still holds, while a later call compiles
            if self._began is None and kernel in known and not is_abandoned():
                self._begin(known[kernel])

        def ends(kernel: Any) -> None:
            if self._told is not None:
                self._told.note(kernel)

        try:
            with told_of_compilations(begins, ends):
                yield
        finally:
            self._end()

    def await_verdict(self) -> None:
        """Wait for the process that compiles the verdict, if there is one."""
        other, until = self._other, time.perf_counter() + LONGEST
        while other is not None and time.perf_counter() < until:
            interrupts.check()
            with suppress(subprocess.TimeoutExpired):
                other.wait(0.2)
                break

    def _begin(self, name: str) -> None:
        """Note that kernels are about to be compiled, from the one of this name on."""
        refuse_without_memory()
        self._began = time.perf_counter()
        names = kernels_of(self._needed.want)
        left = list(names[names.index(name) :] if name in names else (name,))
        if "verdict" in left[1:] and self._helped and may_help():
            self._other = begin(["verdict"], self._needed)
            left.remove("verdict")
        if self._tell is not None:
            seconds = sum(SECONDS[name] for name in left)
            self._told = _Told(self._tell, self._needed.scene, seconds)

    def _end(self) -> None:
        """Tell that nothing is compiled any more; end the other process, if there is one."""
        if self._began is not None:
            Compilation.waited += time.perf_counter() - self._began
        if self._told is not None:
            self._told.stop()
        if self._other is not None:
            end(self._other)
        self._began = self._told = self._other = None


# ---- the other process ---------------------------------------------------------------------------


def begin(kernels: Iterable[str], needed: Needed) -> Process | None:
    """Begin to compile kernels in a process of its own; None where there can be none.

    Arguments: the names of the `kernels`, and what they are `needed` for.

    It ends when its standard input does, so also when this process is killed.
    """
    scene, method, want = needed
    words = [",".join(kernels), scene, method, ",".join(want)]
    try:
        return subprocess.Popen(
            [
                sys.executable,
                "-P",
                "-W",
                "ignore",
                "-m",
                "nlds_vines.orbits.compiler_process",
                *words,
            ],
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
