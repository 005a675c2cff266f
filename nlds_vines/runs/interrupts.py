"""Asked to stop: Ctrl-C, SIGTERM and SIGUSR1 end a run between two blocks, not within one."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from nlds_vines.runs import interrupts

_ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
_HEARD = b"stopping after this block; once more, and at once\n"

INTERRUPTED, TERMINATED = 130, 143
"""Exit statuses: of Ctrl-C; of SIGTERM and of SIGUSR1, by which SLURM gives notice of it."""


class Stopped(Exception):
    """Somebody asked to stop."""


class Stop:
    """Whether somebody has asked to stop, and the exit status that answers."""

    def __init__(self) -> None:
        """Nobody has asked."""
        self.asked = False
        self.status = INTERRUPTED

    def check(self) -> None:
        """Raise `Stopped` if somebody has asked."""
        if self.asked:
            raise Stopped

    def hear(self, number: int, frame: FrameType | None) -> None:
        """Note a signal; the second one raises `KeyboardInterrupt`."""
        self.status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
        os.write(2, _HEARD)  # `print` might be at work below this very call


@contextmanager
def heard() -> Iterator[Stop]:
    """Return what hears the signals during the `with` block; then they mean what they did.

    Only the main thread may listen: elsewhere, nothing changes.
    """
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, stop.hear) for number in _ASKING}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Interrupted(Exception):
    """A scan was stopped from outside; what is finished is kept.  The message says how to go on."""

    def __init__(self, message: str, status: int = interrupts.INTERRUPTED) -> None:
        """Take the message and the exit status."""
        super().__init__(message)
        self.status = status
