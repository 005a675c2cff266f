"""The manners that all commands share: one line for an error, exit statuses, paths that work."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from nlds_vines.errors import RequestError, shown, unknown
from nlds_vines.interrupts import INTERRUPTED

Number = TypeVar("Number", int, float)

DONE, LANES_FAILED, DAMAGED, DIFFERENT, WRONG_REQUEST = 0, 1, 1, 1, 2
"""Exit statuses, beside those of `interrupts`."""

PLOT_SUFFIXES = (".png", ".pdf", ".svg")
"""The kinds of pictures, by the end of their names."""


class Parser(argparse.ArgumentParser):
    """An argument parser that raises `RequestError` where others print their usage and exit."""

    def __init__(self, **settings: Any) -> None:
        """Take argparse's own settings; options are not abbreviated, the text keeps its lines."""
        form = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=form, **settings)

    def error(self, message: str) -> NoReturn:
        """Raise `RequestError` with the message."""
        raise RequestError(message)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return the options; an unknown one is named together with the nearest that exists."""
        found, rest = self.parse_known_args(args, namespace)
        if rest and rest[0].startswith("-"):
            options = [name for name in self._option_string_actions if name.startswith("--")]
            raise unknown("option", rest[0].partition("=")[0], options)
        if rest:
            raise RequestError(f"one argument too many: {shown(rest[0])}")
        return found


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


def check_writable(what: str, path: Path) -> None:
    """Raise `RequestError` unless a file of this path can be written; nothing is left behind."""
    if os.path.isdir(path):  # unlike `Path.is_dir`, never raises
        raise RequestError(f"{what} {shown(str(path))} is a folder: name a file")
    if not path.parent.is_dir():
        raise RequestError(f"{what} {shown(str(path))}: there is no folder {str(path.parent)!r}")
    try:  # neither permission bits nor the length of a name tell the truth on every file system
        tempfile.NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.").close()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{what} {shown(str(path))} cannot be written: {reason}") from None


def refuse_existing(archive: Path, *, resume: bool, overwrite: bool) -> None:
    """Raise `RequestError` where an archive exists and it was not said what to do with it."""
    if os.path.lexists(archive) and not (resume or overwrite):
        raise RequestError(
            f"output {shown(str(archive))} exists: --resume continues it, "
            "--overwrite replaces it, -o names another file"
        )


def check_plot(path: Path) -> None:
    """Raise `RequestError` unless a picture of this path can be drawn and written."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise RequestError(
            f"--plot {shown(str(path))} must end in one of {', '.join(PLOT_SUFFIXES)}"
        )
    check_writable("--plot", path)


def assignments(option: str, texts: Sequence[str], form: str) -> dict[str, str]:
    """Return the texts NAME=... of an option that may be given several times, by name.

    Raises `RequestError` for a text of another `form` and for a name given twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise RequestError(f"{option} {shown(text)} must be {form}")
        if name in found:
            raise RequestError(f"{option} {name} is given twice: {found[name]} and {value}")
        found[name] = value
    return found


def parsed(kind: type[Number], what: str, text: str) -> Number:
    """Return the number of a `kind`, int or float, that `text` means; `what` names it.

    Raises `RequestError` where it means none.
    """
    try:
        return kind(text)
    except ValueError:
        words = "a whole number" if kind is int else "a number"
        raise RequestError(f"{what} = {shown(text)} must be {words}") from None
