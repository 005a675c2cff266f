"""Ctrl-C, SIGTERM and SIGUSR1 end a run between two pieces of its work, not within one."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
_ANSWER = b"stopping: this block is finished first; press Ctrl-C again to stop at once\n"

INTERRUPTED, TERMINATED = 130, 143
"""Exit statuses: of Ctrl-C; of SIGTERM and of SIGUSR1, by which SLURM gives notice of it."""


class Stopped(Exception):
    """A signal has asked to stop; raised between two pieces of work."""


class Interrupted(Exception):
    """A run was stopped from outside; what is finished is kept.  The message says how to go on."""

    def __init__(self, message: str, status: int = INTERRUPTED) -> None:
        """Take the message and the exit status."""
        super().__init__(message)
        self.status = status


class Terminated(KeyboardInterrupt):
    """SIGTERM has come where nothing else takes it; like Ctrl-C but for the exit status."""


@contextmanager
def terminated_like_interrupted() -> Iterator[None]:
    """Let SIGTERM raise `Terminated` during the `with` block, unless somebody takes it already."""
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def handle(number: int, frame: FrameType | None) -> None:
        raise Terminated

    signal.signal(signal.SIGTERM, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


class Stop:
    """Whether a signal has asked to stop, and the exit status that belongs to it."""

    def __init__(self) -> None:
        """Begin without a signal."""
        self.asked = False
        self.status = INTERRUPTED

    def check(self) -> None:
        """Raise `Stopped` if a signal has asked to stop."""
        if self.asked:
            raise Stopped

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Take a signal; the second one raises `KeyboardInterrupt` at once."""
        self.status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
        os.write(2, _ANSWER)  # the signal may have come within a call of `print`


_taking: list[Stop] = []


def check() -> None:
    """Raise `Stopped` if a signal has asked whatever takes signals now to stop."""
    for stop in _taking:
        stop.check()


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Return a `Stop` that takes the signals during the `with` block; then all is as before.

    Python allows this in the main thread only: elsewhere the signals keep their meaning.
    """
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, stop.handle) for number in _SIGNALS}
    _taking.append(stop)
    try:
        yield stop
    finally:
        _taking.remove(stop)
        for number, handler in before.items():
            signal.signal(number, handler)
