"""A command from its arguments to its exit status: what all commands have in common."""

from __future__ import annotations

import argparse
import atexit
import gc
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from nlds_vines.cli.parser import Parser
from nlds_vines.errors import LeftAside, RequestError, printable
from nlds_vines.runs.interrupts import (
    INTERRUPTED,
    TERMINATED,
    Interrupted,
    Terminated,
    terminated_like_interrupted,
)

DONE, LANES_FAILED, DIFFERENT, WRONG_REQUEST = 0, 1, 1, 2
"""Exit statuses, beside those of `interrupts`."""


@dataclass(frozen=True)
class Command:
    """One command of the console script.

    Arguments:
        name: as it is called, `nlds-vines NAME`; or a program of its own, `python -m NAME`.
        description: one sentence for the top of its help.
        examples: the end of its help: examples that work, and the exit statuses.
        declare: declares its options on a parser.
        carry_out: does what the options ask for and returns the exit status; `options.argv` is
            the list of the arguments as they were given.
    """

    name: str
    description: str
    examples: str
    declare: Callable[[Parser], None]
    carry_out: Callable[[argparse.Namespace], int]

    def main(self, argv: Sequence[str] | None = None) -> int:
        """Run the command with the arguments `argv`, None for the process's own.

        Returns the exit status.  A wrong request becomes one line on standard error and status 2,
        and so does what the operating system refuses (a full disk, a file that vanished).  A run
        that was interrupted says how to go on; its status is 130 after Ctrl-C, 143 after SIGTERM.

        Performance: the process, when it ends, is not searched for garbage, which takes a second
        where it has compiled.
        """
        atexit.unregister(gc.freeze)  # once, however many commands a process runs
        atexit.register(gc.freeze)
        arguments = list(sys.argv[1:] if argv is None else argv)
        return ended(self.name, lambda: self._carried_out(arguments))

    def _carried_out(self, arguments: list[str]) -> int:
        """Carry out what the arguments mean; return the exit status."""
        options = self._options(arguments)
        with _told_aside(self.name, getattr(options, "quiet", False)):
            return self.carry_out(options)

    def _options(self, arguments: list[str]) -> argparse.Namespace:
        """Return the options that the arguments mean; `argv` among them is the arguments."""
        prog, top, end = _program(self.name), self.description, self.examples
        parser = Parser(prog=prog, description=top, epilog=end)
        self.declare(parser)
        options = parser.parse_args(arguments)
        options.argv = arguments
        return options


@contextmanager
def _told_aside(name: str, quiet: bool) -> Iterator[None]:
    """Say in a line what a request file has for other commands than `name`, unless it is quiet."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if quiet else "always", LeftAside)
        others = warnings.showwarning

        def show(message: Any, category: Any, *where: Any, **more: Any) -> None:
            if issubclass(category, LeftAside):
                complain(name, str(message))
            else:
                others(message, category, *where, **more)

        warnings.showwarning = show
        yield


def ended(name: str, work: Callable[[], int]) -> int:
    """Return the exit status of some work of the command `name`; an error is told in one line.

    Output that was not written, as to a full disk, is an error like any other.
    """
    _open_streams()
    try:
        try:
            with terminated_like_interrupted():
                status = work()
        except SystemExit as stop:  # argparse after --help
            status = int(stop.code or DONE)
        sys.stdout.flush()
        return status
    except RequestError as error:
        complain(name, f"error: {error}")
        return WRONG_REQUEST
    except OSError as error:
        _drop_output()
        complain(name, f"error: {_in_words(error)}")
        return WRONG_REQUEST
    except MemoryError as error:
        reason = f": {error}" if str(error) else ""
        complain(name, f"error: the memory does not suffice{reason}")
        return WRONG_REQUEST
    except ImportError as error:
        if "failed to map segment" not in str(error):
            raise
        complain(name, "error: the memory does not suffice to load the libraries")
        return WRONG_REQUEST
    except Interrupted as stop:
        complain(name, str(stop))
        return stop.status
    except KeyboardInterrupt as stop:
        complain(name, ": ".join(["interrupted", *map(str, stop.args)]))
        return TERMINATED if isinstance(stop, Terminated) else INTERRUPTED


def _open_streams() -> None:
    """Open what was closed of input, output and errors (`>&-`), to nowhere.

    An archive would otherwise get the number of one of them, and what is meant for a terminal
    would be written into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # the lowest number that is free is this one
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    for number, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", encoding="utf-8", closefd=False))


def _drop_output() -> None:
    """Drop output that cannot be written: Python would try, and complain, again at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _in_words(error: OSError) -> str:
    """Return the operating system's message, with the name of the file in front if it has one."""
    reason = error.strerror or str(error) or type(error).__name__
    return f"{error.filename}: {reason}" if error.filename is not None else reason


def say(*lines: object) -> None:
    """Print lines at once, each as one whatever is in it: titles and names come from files.

    What the terminal's encoding lacks is escaped, too: nothing fails at its last step.
    """
    for line in lines:
        text, encoding = printable(str(line)), sys.stdout.encoding or "utf-8"
        print(text.encode(encoding, "backslashreplace").decode(encoding))
    sys.stdout.flush()


def complain(name: str, message: str) -> None:
    """Print a message of the command `name` to standard error, as one line whatever is in it."""
    with suppress(OSError):  # there is no one who could be told
        text = printable(" ".join(message.split()))
        print(f"{_program(name)}: {text}", file=sys.stderr, flush=True)


def _program(name: str) -> str:
    """Return how a command is called."""
    return name if name.startswith("python ") else f"nlds-vines {name}".strip()
