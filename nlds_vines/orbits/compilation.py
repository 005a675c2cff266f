"""What must be compiled before orbits can be run: told in words, and half of it done elsewhere.

Compiling takes as long as thousands of orbits.  Where there is a second processor, another
process compiles the verdict while this one compiles the orbit, and leaves it in the cache on the
disk, where this process finds it.  Whatever goes wrong there, this process compiles it itself.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from nlds_vines.kernels import eigenvalues, lanes
from nlds_vines.kernels.compiling import told_of_compilations
from nlds_vines.orbits import elsewhere

FIRST = lanes.run_lanes, lanes.judge_lanes, eigenvalues.fill_multipliers
"""What is called from Python: where one of them must be compiled, more must be."""

SECONDS = {"orbit": 12, "verdict": 18, "error": 8}
"""Time [s] that compiling each kernel takes, of an SSul NES; for a message."""

LONGEST = 600.0
"""Seconds to wait for the other process, after which it must have lost its way."""

Tell = Callable[[str], object]
"""Takes a line of text for the user."""


class Compilation:
    """Follows what is compiled for orbits of one scene, one record and one method."""

    def __init__(self, needed: elsewhere.Needed, tell: Tell | None, helped: bool) -> None:
        """Take what kernels are `needed` for, who is told, and whether another process may help."""
        self._needed, self._tell, self._helped = needed, tell, helped
        self._told: set[str] = set()  # kernels
        self._other: elsewhere.Process | None = None

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
        """Note that a kernel is about to be compiled, as the cache does not have it."""
        if kernel not in FIRST:
            return
        elsewhere.refuse_without_memory()
        judges = kernel is lanes.judge_lanes
        left = ("verdict",) if judges else elsewhere.kernels_of(self._needed.want)
        if self._told.issuperset(left):
            return
        self._told.update(left)
        if self._helped and not judges and "verdict" in left and elsewhere.may_help():
            self._other = elsewhere.begin(["verdict"], self._needed, writes=False)
        if self._tell is not None:
            seconds = sum(SECONDS[name] for name in left)
            seconds -= 0 if self._other is None else SECONDS["orbit"]
            scene, names = self._needed.scene, ", ".join(left)
            self._tell(f"compiling the kernels of {scene}: {names} (once; about {seconds} s)")

    def _leave(self) -> None:
        """End the other process, if there is one."""
        other, self._other = self._other, None
        if other is not None:
            elsewhere.end(other)
