"""Ctrl-C and SIGTERM end a run within two seconds, SIGUSR1 after the piece of work under way.

After Ctrl-C or SIGTERM the work under way has `GRACE` to end; then an alarm raises `Stopped` in the
main thread, wherever that is.  Compiled loops and the compiler see no signals, so they run in a
thread beside the main one (`stoppable`), which is abandoned if it does not end.
"""

from __future__ import annotations

import atexit
import contextvars
import ctypes
import functools
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
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


class Stopped(BaseException):
    """A signal has asked to stop, or nobody waits for the result of this thread any more."""


class Interrupted(KeyboardInterrupt):
    """A run was stopped by a signal.  The message says what is kept, and how to go on."""

    def __init__(self, message: str, status: int = INTERRUPTED) -> None:
        """Take the message and the exit status."""
        super().__init__(message)
        self.status = status


class Terminated(KeyboardInterrupt):
    """SIGTERM has come where nothing else takes it; like Ctrl-C but for the exit status."""


@contextmanager
def terminated_like_interrupted() -> Iterator[None]:
    """Let SIGTERM raise `Terminated` during the `with` block, unless somebody takes it already."""
    if not _in_main_thread() or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
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
        self._is_stopping = False  # in the main thread: what follows puts things away

    def check(self) -> None:
        """Raise `Stopped` if a signal has asked to stop."""
        if self.asked:
            self._is_stopping |= _in_main_thread()
            raise Stopped

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Take a signal; the second one raises `KeyboardInterrupt` at once."""
        self.status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        if self.asked:
            self._is_stopping = True
            raise KeyboardInterrupt
        self.asked = True
        if number != signal.SIGUSR1:
            signal.signal(signal.SIGALRM, self._end_grace)
            signal.setitimer(signal.ITIMER_REAL, GRACE)
        # the signal may have come within a call of `print`
        os.write(2, _NOTICE if number == signal.SIGUSR1 else _ANSWER)

    def _end_grace(self, number: int, frame: FrameType | None) -> None:
        """Raise `Stopped`, unless the main thread is stopping already or the run has ended."""
        if self in _taking and not self._is_stopping:
            self.check()


_taking: list[Stop] = []


def check() -> None:
    """Raise `Stopped` if a signal has asked to stop, or if this thread has been abandoned."""
    for stop in _taking:
        stop.check()
    if abandoned()():
        raise Stopped


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Return a `Stop` that takes the signals during the `with` block; then all is as before.

    Python allows this in the main thread only: elsewhere the signals keep their meaning.
    """
    stop = Stop()
    if not _in_main_thread():
        yield stop
        return
    before = {number: signal.signal(number, stop.handle) for number in _SIGNALS}
    before[signal.SIGALRM] = signal.getsignal(signal.SIGALRM)
    _taking.append(stop)
    try:
        yield stop
    finally:
        _taking.remove(stop)
        if stop.asked:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
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

    Called in the main thread, it runs in a thread beside it.  If a signal has asked to stop and
    `GRACE` is over, the call raises `Stopped`; if no run takes signals, `KeyboardInterrupt` ends it
    at once.  The thread is then abandoned: its result is lost, and it ends at the next `check`,
    which is after the kernel or the compilation of a function that it is in, or with the process.
    """

    @functools.wraps(work)
    def beside(*args: Arguments.args, **keywords: Arguments.kwargs) -> Result:
        if not _in_main_thread():
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
        thread = threading.Thread(target=context.run, args=(carry_out,), daemon=True)
        thread.start()
        try:
            while not ended.wait(0.1):  # another thread may have got the signal: look again
                pass
        except BaseException:
            given_up.set()
            atexit.register(lambda: exit_without_destructors() if thread.is_alive() else None)
            raise
        if errors:
            raise errors[0]
        return results[0]

    return beside


def exit_without_destructors() -> None:
    """Let this process end without C++ destructors, because a thread may still compile then.

    They destroy what LLVM is working on: 2 of 4 calls of C's `exit` during a compilation crashed.
    Python finalizes as usual, and the exit status is the same.
    """
    with suppress(AttributeError):  # glibc alone has on_exit
        libc = ctypes.CDLL(None)
        libc.on_exit(libc._exit, None)
