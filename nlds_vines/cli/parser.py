"""The argument parser of all commands, and the options in the form NAME=VALUE."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn, TypeVar

from nlds_vines.errors import RequestError, shown, unknown

Number = TypeVar("Number", int, float)


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
