"""The argument parser of all commands."""

from __future__ import annotations

import argparse
import re
from functools import partial
from typing import Any, NoReturn

from nlds_vines.errors import Number, RequestError, from_text, refuse_bytes, shown, unknown

_NO_VALUE = re.compile(r"(-[a-z]=?|--[a-z-]+=)--")
"""An option with `--` for its value, of which argparse makes an empty list."""


class Parser(argparse.ArgumentParser):
    """An argument parser that raises `RequestError` where others print their usage and exit."""

    def __init__(self, **settings: Any) -> None:
        """Take argparse's own settings; options are not abbreviated, the text keeps its lines."""
        form = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=form, **settings)
        # a value such as -0.03,0.1 or -1:1:9 is no option; argparse by itself knows -0.03 alone
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")
        for kind in (int, float):  # what Python reads as a number is more than what users write
            self.register("type", kind, partial(_number, kind))

    def error(self, message: str) -> NoReturn:
        """Raise `RequestError` with the message."""
        raise RequestError(message)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return the options; an unknown one is named together with the nearest that exists.

        Every argument may end in an archive, so none may hold what no archive can.
        """
        for text in args or ():
            refuse_bytes("the argument", text)
            if option := _NO_VALUE.fullmatch(text):
                name = option[1].rstrip("=")
                raise RequestError(f"argument {name}: expected one argument, not '--'")
        found, rest = self.parse_known_args(args, namespace)
        if rest and rest[0].startswith("-"):
            name = rest[0].partition("=")[0]
            options = [name for name in self._option_string_actions if name.startswith("--")]
            raise unknown("option", name, options)
        if rest:
            raise RequestError(f"one argument too many: {shown(rest[0])}")
        return found


def _number(kind: type[Number], text: str) -> Number:
    """Return the number that an argument means; argparse names the option in front of an error."""
    try:
        return from_text(kind, "", text)
    except RequestError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix(" = ")) from None
