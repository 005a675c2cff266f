"""Ctrl-C and SIGTERM end a run within two seconds, SIGUSR1 after the piece of work under way.

Compiled loops, and the compiler, hold the thread they run in for as long as they take.  Work of
that sort is therefore done in a thread beside the main one, which waits and sees signals.
"""

from __future__ import annotations

import contextvars
import functools
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import ParamSpec, TypeVar

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
_ANSWER = b"stopping: what is under way has a second to end; press Ctrl-C again to stop at once\n"
_NOTICE = b"stopping: this block is finished first\n"

GRACE = 1.0
"""Seconds [s] that the work under way has to end after Ctrl-C or SIGTERM before it is abandoned."""

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

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
        self._until = float("inf")  # when the work under way is abandoned

    def check_grace(self) -> None:
        """Raise `Stopped` if the work under way has had its time to end."""
        if time.monotonic() > self._until:
            raise Stopped

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
        if number != signal.SIGUSR1:
            self._until = time.monotonic() + GRACE
        # the signal may have come within a call of `print`
        os.write(2, _NOTICE if number == signal.SIGUSR1 else _ANSWER)


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


# ---- work that signals end -----------------------------------------------------------------------


class _Thread(threading.local):
    """Of each thread, the event that says that nobody waits for its results any more."""

    abandoned: threading.Event | None = None


_thread = _Thread()


def abandoned() -> Callable[[], bool]:
    """Return a function that tells whether the work of this thread has been abandoned."""
    event = _thread.abandoned
    return (lambda: False) if event is None else event.is_set


def stoppable(work: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Let signals end a function that computes and compiles: it may write no file.

    Called in the main thread, it runs in a thread beside it.  Where a signal has asked to stop and
    `GRACE` is over, the call raises `Stopped`; `KeyboardInterrupt`, where no run takes signals,
    ends it at once.  The thread is then left to itself: its results are lost, and it ends with the
    call of a kernel that it is in, or with the process.
    """

    @functools.wraps(work)
    def beside(*args: Arguments.args, **keywords: Arguments.kwargs) -> Result:
        if threading.current_thread() is not threading.main_thread():
            return work(*args, **keywords)
        ended, given_up = threading.Event(), threading.Event()
        results: list[Result] = []
        errors: list[BaseException] = []

        def carry_out() -> None:
            _thread.abandoned = given_up
            try:
                results.append(work(*args, **keywords))
            except BaseException as error:
                errors.append(error)
            finally:
                ended.set()

        context = contextvars.copy_context()
        threading.Thread(target=context.run, args=(carry_out,), daemon=True).start()
        try:
            while not ended.wait(0.1):
                for stop in _taking:
                    stop.check_grace()
        except BaseException:
            given_up.set()
            raise
        if errors:
            raise errors[0]
        return results[0]

    return beside
