"""The manners that all commands share: one line for an error, exit statuses, paths that work."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from nlds_vines.errors import RequestError
from nlds_vines.runs.interrupts import INTERRUPTED

DONE, LANES_FAILED, DAMAGED, DIFFERENT, WRONG_REQUEST = 0, 1, 1, 1, 2
"""Exit statuses, beside those of `interrupts`."""


def run_command(
    name: str, command: Callable[[Sequence[str]], int], argv: Sequence[str] | None
) -> int:
    """Run a command and return its exit status.

    Arguments: its `name`, its function of the arguments, and `argv` (the process's own if None).
    A wrong request becomes one line on standard error and status 2, and so does what the operating
    system refuses (a full disk, a file that vanished); Ctrl-C becomes status 130.
    """
    try:
        return command(sys.argv[1:] if argv is None else argv)
    except RequestError as error:
        complain(name, f"error: {error}")
        return WRONG_REQUEST
    except OSError as error:
        complain(name, f"error: {_in_words(error)}")
        return WRONG_REQUEST
    except KeyboardInterrupt:
        complain(name, "interrupted")
        return INTERRUPTED
    except SystemExit as stop:  # argparse after --help
        return int(stop.code or DONE)


def _in_words(error: OSError) -> str:
    """Return what the operating system said, after the file that it spoke of."""
    reason = error.strerror or str(error) or type(error).__name__
    return f"{error.filename}: {reason}" if error.filename is not None else reason


def complain(name: str, message: str) -> None:
    """Print a message of the command `name` to standard error, as one line whatever is in it."""
    who = f"nlds-vines {name}".strip()
    print(f"{who}: {' '.join(message.split())}", file=sys.stderr)
