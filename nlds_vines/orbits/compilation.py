"""What must be compiled before orbits can be run: told in words, and half of it done elsewhere.

Compiling takes as long as thousands of orbits.  Where there is a second processor, another
process compiles the verdict while this one compiles the orbit, and leaves it in the cache on the
disk, where this process finds it.  Whatever goes wrong there, this process compiles it itself.
"""

from __future__ import annotations

import multiprocessing
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

from nlds_vines.kernels import eigenvalues, lanes
from nlds_vines.kernels.compiling import told_of_compilations
from nlds_vines.orbits import elsewhere
from nlds_vines.runs.progress import Clock, Notice, Tell

OF_LANES: Mapping[Callable[..., Any], str] = {
    eigenvalues.fill_multipliers: "orbit",  # needed for a verdict, and compiled before the orbit
    lanes.run_lanes: "orbit",
    lanes.judge_lanes: "verdict",
}
"""What is called from Python to run many orbits, and the name of the kernel that it is part of."""

SECONDS = {"orbit": 12, "verdict": 18, "error": 8, "branches": 15, "entry": 8}
"""Time [s] that compiling each kernel takes, of an SSul NES; for a message."""

LONGEST = 600.0
"""Seconds to wait for the other process, after which it must have lost its way."""


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


class Compilation:
    """Follows what is compiled for orbits of one scene, one record and one method."""

    def __init__(self, needed: elsewhere.Needed, tell: Tell | None, helped: bool) -> None:
        """Take what kernels are `needed` for, who is told, and whether another process may help."""
        self._needed, self._tell, self._helped = needed, tell, helped
        self._names = elsewhere.kernels_of(needed.want)
        self._left: tuple[str, ...] = ()  # to be compiled, when the first of them began
        self._clock: Clock | None = None  # while something is compiled, or waited for
        self._other: elsewhere.Process | None = None

    @contextmanager
    def followed(self, parts: Mapping[Callable[..., Any], str] = OF_LANES) -> Iterator[None]:
        """Follow what is compiled within the block; no other process outlives it.

        Arguments: `parts`, what is called from Python, with the name of the kernel it is part of.

        Raises `RequestError` where memory does not suffice to compile.
        """

        def begins(kernel: Any) -> None:
            if kernel in parts:
                self._begins(parts[kernel])

        def ends(kernel: Any) -> None:
            if kernel in parts:
                self._stop_clock()

        try:
            with told_of_compilations(begins, ends):
                yield
        finally:
            self._stop_clock()
            self._leave()

    def await_verdict(self) -> None:
        """Wait for the process that compiles the verdict, if there is one."""
        if self._other is not None:
            self._start_clock("verdict")
            with suppress(subprocess.TimeoutExpired):
                self._other.wait(LONGEST)
            self._stop_clock()
            self._leave()

    def _begins(self, name: str) -> None:
        """Note that a part of a kernel is about to be compiled, as the cache does not have it."""
        elsewhere.refuse_without_memory()
        if name not in self._left:
            self._left = self._names[self._names.index(name) :] if name in self._names else (name,)
            later = "verdict" in self._left[1:]
            if later and self._helped and elsewhere.may_help():
                self._other = elsewhere.begin(["verdict"], self._needed, writes=False)
        self._start_clock(name)

    def _start_clock(self, name: str) -> None:
        """Tell again and again that a kernel is being compiled, until the clock is stopped."""
        if self._tell is not None:
            seconds = sum(SECONDS[name] for name in self._left)
            seconds -= 0 if self._other is None else SECONDS["orbit"]
            count = f"{self._left.index(name) + 1} of {len(self._left)}: {name}"
            text = (
                f"compiling the kernels of {self._needed.scene} (once for this kind and these "
                f"records, about {seconds} s; {count})"
            )
            self._clock = Clock(self._tell, text)

    def _stop_clock(self) -> None:
        """Tell that nothing is being compiled any more, if something was."""
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.stop()

    def _leave(self) -> None:
        """End the other process, if there is one."""
        other, self._other = self._other, None
        if other is not None:
            elsewhere.end(other)
