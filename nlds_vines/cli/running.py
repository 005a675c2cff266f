"""A command from its arguments to its exit status: what all commands have in common."""

from __future__ import annotations

import argparse
import atexit
import gc
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from nlds_vines.cli.parser import Parser
from nlds_vines.errors import LeftAside, RequestError, printable
from nlds_vines.runs.interrupts import INTERRUPTED, Interrupted

DONE, LANES_FAILED, DAMAGED, DIFFERENT, WRONG_REQUEST = 0, 1, 1, 1, 2
"""Exit statuses, beside those of `interrupts`."""


@dataclass(frozen=True)
class Command:
    """One command of the console script.

    Arguments:
        name: as it is called, `nlds-vines NAME`.
        description: one sentence for the top of its help.
        examples: the end of its help: examples that work, and the exit statuses.
        declare: declares its options on a parser.
        carry_out: does what the options ask for and returns the exit status; `options.argv` is
            the list of the arguments as they were given.
        program: how it is called, where that is not `nlds-vines NAME`.
    """

    name: str
    description: str
    examples: str
    declare: Callable[[Parser], None]
    carry_out: Callable[[argparse.Namespace], int]
    program: str = ""

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
        try:
            options = self._options(list(sys.argv[1:] if argv is None else argv))
            with _told_aside(self.name, getattr(options, "quiet", False)):
                return self.carry_out(options)
        except RequestError as error:
            complain(self.name, f"error: {error}")
            return WRONG_REQUEST
        except OSError as error:
            complain(self.name, f"error: {_in_words(error)}")
            return WRONG_REQUEST
        except MemoryError as error:
            reason = f": {error}" if str(error) else ""
            complain(self.name, f"error: the memory does not suffice{reason}")
            return WRONG_REQUEST
        except Interrupted as stop:
            complain(self.name, str(stop))
            return stop.status
        except KeyboardInterrupt:
            complain(self.name, "interrupted")
            return INTERRUPTED
        except SystemExit as stop:  # argparse after --help
            return int(stop.code or DONE)

    def _options(self, arguments: list[str]) -> argparse.Namespace:
        """Return the options that the arguments mean; `argv` among them is the arguments."""
        prog = self.program or f"nlds-vines {self.name}"
        parser = Parser(prog=prog, description=self.description, epilog=self.examples)
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
    who = f"nlds-vines {name}".strip()
    print(f"{who}: {printable(' '.join(message.split()))}", file=sys.stderr)
