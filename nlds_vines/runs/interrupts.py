"""Ctrl-C and SIGTERM end a run within two seconds, SIGUSR1 after the piece of work under way.

Compiled loops and the compiler see no signals.  So work runs in a thread beside the main one
(`stoppable`), which waits for it and looks at the clock.  After Ctrl-C or SIGTERM the work has
`GRACE` to end; then it is abandoned.  No signal is lost: whatever the work does after a signal, the
`with` block that took it ends in an exception.
"""

from __future__ import annotations

import atexit
import contextvars
import functools
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, ParamSpec, TypeVar

_ANSWER = b"stopping: what is under way has a second to end; press Ctrl-C again to stop at once\n"
_NOTICE = b"stopping: this block is finished first\n"

GRACE = 1.0  # seconds that work has to end after Ctrl-C or SIGTERM before it is abandoned
AGAIN = 0.05  # seconds until a signal whose exception Python has dropped is sent again
NOTICE = getattr(signal, "SIGUSR1", None)  # by which SLURM gives notice of the end of a job
INTERRUPTED, TERMINATED = 130, 143  # exit statuses: of Ctrl-C; of SIGTERM and of SIGUSR1

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Stopped(BaseException):
    """A signal has asked to stop, or nobody waits for the result of this thread any more."""


class Interrupted(KeyboardInterrupt):
    """A run was stopped by a signal.  The message says what is kept, and how to go on."""

    def __init__(self, message: str, status: int = INTERRUPTED) -> None:
        super().__init__(message)
        self.status = status


class Terminated(KeyboardInterrupt):
    """SIGTERM has come where nothing else takes it; like Ctrl-C but for the exit status."""


_raised: list[type[KeyboardInterrupt]] = []  # by signals, and not seen outside a block yet


@contextmanager
def raise_on_signals() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise during the `with` block, unless somebody takes them already.

    Python drops an exception that is raised in a destructor or in a callback of a C library.  Then
    the signal is sent again, without a word, and at the end of the block it raises at the latest.
    """
    exceptions: dict[int, type[KeyboardInterrupt]] = {
        signal.SIGINT: KeyboardInterrupt,
        signal.SIGTERM: Terminated,
    }
    nobody = (signal.SIG_DFL, signal.default_int_handler)
    numbers = []
    if _in_main_thread():
        numbers = [number for number in exceptions if signal.getsignal(number) in nobody]

    def handle(number: int, frame: FrameType | None) -> None:
        _raised.append(exceptions[number])
        raise exceptions[number]

    again: list[threading.Timer] = []
    report = sys.unraisablehook

    def send_again(dropped: sys.UnraisableHookArgs) -> None:
        for number, exception in exceptions.items():
            if dropped.exc_type is exception and _raised:
                again.append(threading.Timer(AGAIN, os.kill, (os.getpid(), number)))
                again[-1].daemon = True
                again[-1].start()
                return
        report(dropped)

    if numbers:
        _raised.clear()  # of an earlier command that has ended in an error
        sys.unraisablehook = send_again
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield
    except KeyboardInterrupt:
        _raised.clear()
        raise
    except BaseException:
        if not _raised:  # otherwise a C library has made the error of the signal's exception
            raise
    finally:
        for timer in again:
            timer.cancel()
        if numbers:
            sys.unraisablehook = report
        _restore(before)
    if _raised:
        dropped = _raised[-1]
        _raised.clear()
        raise dropped


def _restore(handlers: dict[int, Any]) -> None:
    """Restore the handlers of signals, that of SIGINT last: the others do not raise by default."""
    for number, handler in reversed(handlers.items()):
        signal.signal(number, handler)


class Stop:
    """Whether a signal has asked to stop, until when the work may end, and the exit status."""

    asked, deadline, status = False, math.inf, INTERRUPTED

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Take a signal; the second one raises `KeyboardInterrupt` at once."""
        self.status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
        if number != NOTICE:
            self.deadline = time.monotonic() + GRACE
        # the signal may have come within a call of `print`
        os.write(2, _NOTICE if number == NOTICE else _ANSWER)


_taking: list[Stop] = []


def check() -> None:
    """Raise `Stopped` if a signal has asked to stop, or if this thread has been abandoned."""
    if any(stop.asked for stop in _taking) or abandoned()():
        raise Stopped


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


@contextmanager
def stop_on_signals(stop: Stop | None = None) -> Iterator[Stop]:
    """Return a `Stop` that takes the signals in the `with` block; outside the main thread, none.

    A block that ends after a signal without an exception raises `Stopped`.
    """
    stop = Stop() if stop is None else stop
    if not _in_main_thread():
        yield stop
        return
    numbers = [signal.SIGINT, signal.SIGTERM, *([] if NOTICE is None else [NOTICE])]
    before = {number: signal.signal(number, stop.handle) for number in numbers}
    _taking.append(stop)
    try:
        yield stop
    finally:
        _taking.remove(stop)
        _restore(before)
    if stop.asked:
        raise Stopped


_given_up: contextvars.ContextVar[threading.Event | None] = contextvars.ContextVar(
    "the event that says that nobody waits for the results of this thread", default=None
)


def abandoned() -> Callable[[], bool]:
    """Return a function that tells whether the work of this thread has been abandoned."""
    event = _given_up.get()
    return (lambda: False) if event is None else event.is_set


def stoppable(work: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Let signals end a function that computes and compiles: of files, it may write blocks alone.

    Called in the main thread, it runs in a thread beside it.  If a signal has asked to stop and
    `GRACE` is over, the call raises `Stopped`; if no run takes signals, `KeyboardInterrupt` ends it
    at once.  The thread is then abandoned: it ends at the next `check`, or with the process.
    """

    @functools.wraps(work)
    def beside(*args: Arguments.args, **keywords: Arguments.kwargs) -> Result:
        if not _in_main_thread():
            return work(*args, **keywords)
        ended, given_up = threading.Event(), threading.Event()
        results: list[Result] = []
        errors: list[BaseException] = []

        def carry_out() -> None:
            _given_up.set(given_up)
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
                if any(time.monotonic() > stop.deadline for stop in _taking):
                    raise Stopped
        except BaseException:
            given_up.set()
            _alive.append(thread.is_alive)
            raise
        if errors:
            raise errors[0]
        return results[0]

    return beside


_alive: list[Callable[[], bool]] = []  # of each thread that was abandoned, whether it is alive
exit_status: int | None = None  # the exit status of this process, if it carries out a command


def end_with(status: int) -> None:
    """Note the exit status of a command whose work is over; a signal makes its process exit."""
    global exit_status
    exit_status = status
    if _in_main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, frame: _exit_now(status))


def _exit_now(status: int) -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError, RuntimeError):
            stream.flush()
    os._exit(status)


def exit_without_destructors() -> None:
    """Let this process end as if a thread were abandoned that compiles."""
    _alive.append(lambda: True)


@atexit.register
def _leave() -> None:
    """End this process without C++ destructors where an abandoned thread may still compile.

    They destroy what LLVM is working on: 2 of 4 calls of C's `exit` during a compilation crashed.
    A command leaves at once.  Elsewhere the exit status is not known here, so what is being
    compiled is waited for, and nothing else can be compiled from then on.

    A signal while the process of a command ends does not change its exit status.
    """
    if exit_status is not None and _in_main_thread():
        # Python gives signals their default action while it ends, unless they are ignored
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    if not any(is_alive() for is_alive in _alive):
        return
    if exit_status is not None:
        _exit_now(exit_status)
    if compiling := sys.modules.get("nlds_vines.kernels.numerics.compiling"):
        compiling.global_compiler_lock.acquire()
