"""What a command prints, how its errors become one line each, and its exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import suppress

from nlds_vines.errors import RequestError, as_command, printable
from nlds_vines.runs import interrupts

# exit statuses, beside those of `interrupts`
DONE, ORBITS_FAILED, DIFFERENT, WRONG_REQUEST = 0, 1, 1, 2


def exit_status_of(name: str, work: Callable[[], int]) -> int:
    """Run the `work` of a command, print an error as one line, and return the exit status."""
    _open_streams()
    try:
        try:
            with interrupts.raise_on_signals(), as_command():
                status = work()
        except SystemExit as stop:  # argparse after --help
            status = int(stop.code or DONE)
        sys.stdout.flush()
        return status
    except RequestError as error:
        complain(name, f"error: {error}")
        return WRONG_REQUEST
    except OSError as error:
        try:
            sys.stdout.flush()
        except OSError:  # output that cannot be written: Python would try again at its end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        reason = error.strerror or str(error) or type(error).__name__
        place = f"{error.filename}: " if error.filename is not None else ""
        complain(name, f"error: {place}{reason}")
        return WRONG_REQUEST
    except MemoryError as error:
        reason = f": {error}" if str(error) else ""
        complain(name, f"error: not enough memory{reason}")
        return WRONG_REQUEST
    except ImportError as error:
        if "failed to map segment" not in str(error):
            raise
        complain(name, "error: not enough memory to load the libraries")
        return WRONG_REQUEST
    except interrupts.Interrupted as stop:
        complain(name, str(stop))
        return stop.status
    except KeyboardInterrupt as stop:
        complain(name, ": ".join(["interrupted", *map(str, stop.args)]))
        is_terminated = isinstance(stop, interrupts.Terminated)
        return interrupts.TERMINATED if is_terminated else interrupts.INTERRUPTED


def _open_streams() -> None:
    """Open closed standard streams (`>&-`) as the null device: no archive may get their numbers."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # the lowest number that is free is this one
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    for number, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", encoding="utf-8", closefd=False))


def say(*lines: object) -> None:
    """Print each argument as one line, escaping what the terminal's encoding lacks, and flush."""
    for line in lines:
        text, encoding = printable(str(line)), sys.stdout.encoding or "utf-8"
        print(text.encode(encoding, "backslashreplace").decode(encoding))
    sys.stdout.flush()


def complain(name: str, message: str) -> None:
    """Print a message of the command `name` to standard error, as one line whatever is in it."""
    with suppress(OSError):  # standard error itself cannot be written
        text = printable(" ".join(message.split()))
        print(f"{program(name)}: {text}", file=sys.stderr, flush=True)


def program(name: str) -> str:
    return name if name.startswith("python ") else f"nlds-vines {name}".strip()


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], right: Container[int] = ()
) -> Iterator[str]:
    """Yield the lines of a Markdown table; rows are filled up with empty cells."""
    yield f"| {' | '.join(head)} |"
    yield f"|{'|'.join('---:' if i in right else '---' for i in range(len(head)))}|"
    for row in rows:
        cells = [*row, *[""] * (len(head) - len(row))]
        yield f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
