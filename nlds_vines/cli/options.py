"""The options of commands: the parser, options for tables of parameters, and how texts are read.

Every function that reads a text raises `RequestError` for one of another form; the message names
the option, the text and the form.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, NoReturn

from nlds_vines.errors import Number, RequestError, at, from_text, refuse_bytes, shown, unknown
from nlds_vines.model.axis import FILE
from nlds_vines.model.catalog import load_system
from nlds_vines.model.dampers import PLACE
from nlds_vines.model.look import Look
from nlds_vines.model.setting import Document, Truth, settings_of

Group = argparse._ArgumentGroup

# an option with `--` for its value, of which argparse makes an empty list
_NO_VALUE = re.compile(r"(-[a-z]=?|--[a-z-]+=)--")

# a link in Markdown, which becomes its words, or a mark of code, which is dropped
_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)|`")


class Parser(argparse.ArgumentParser):
    """An argument parser that raises `RequestError` where others print their usage and exit."""

    def __init__(
        self, common: Collection[str] = (), add_help: bool = True, **settings: Any
    ) -> None:
        """Take argparse's own settings; --help lists the options in `common`, --help-all all."""
        form = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=form, add_help=False, **settings)
        self.common = {"--help", "--help-all", *common} if common else set()
        if add_help:
            self.add_argument("-h", "--help", action=_Help, nargs=0, help="show this help and exit")
        if add_help and common:
            self.add_argument("--help-all", action="help", help="show all options and exit")
        for kind in (int, float):  # what Python reads as a number is more than what users write
            self.register("type", kind, partial(_number, kind))
        # a value such as -0.03,0.1 or -1:1:9 is no option; argparse by itself knows -0.03 alone
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    def error(self, message: str) -> NoReturn:
        raise RequestError(message)

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Return the options; `RequestError` for arguments that are left, with the nearest one."""
        for text in arguments:  # the archive records every argument
            if not text.isprintable():
                refuse_bytes("the argument", text)
            if _NO_VALUE.fullmatch(text):
                name = text.removesuffix("--").removesuffix("=")
                raise RequestError(f"argument {name}: expected one argument, not '--'")
        options, rest = self.parse_known_args(arguments)
        if rest and rest[0].startswith("-"):
            names = [name for name in self._option_string_actions if name.startswith("--")]
            raise unknown("option", rest[0].partition("=")[0], names)
        if rest:
            raise RequestError(f"one argument too many: {shown(rest[0])}")
        return options


def _number(kind: type[Number], text: str) -> Number:
    """Return the number that an argument means; argparse names the option in front of an error."""
    try:
        return from_text(kind, "", text)
    except RequestError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix(" = ")) from None


class _Help(argparse.Action):
    def __call__(self, parser: Any, *_: Any, **__: Any) -> None:
        for action in parser._actions if parser.common else ():
            if action.option_strings and parser.common.isdisjoint(action.option_strings):
                action.help = argparse.SUPPRESS
        parser.print_help()
        parser.exit()


def add_settings(
    group: Parser | Group,
    *owners: Any,
    but: Collection[str] = (),
    usual: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Declare the options of requests and tables, `but` some keys; `usual` are other defaults."""
    flags: set[str] = set()  # a table may be that of several owners
    for owner in owners:
        for setting in settings_of(owner).values():
            if setting.has_option and setting.key not in but and setting.flag not in flags:
                flags.add(setting.flag)
                default = usual.get(setting.key, setting.default)
                words = replace(setting, default=default).default_in_words
                text = setting.words + (f" [{words}]" if words else "")
                text = _LINK.sub(lambda link: link[1] or "", text).replace("%", "%%")
                form: dict[str, Any] = {"metavar": setting.form}
                if isinstance(setting.check, Truth):
                    form = {"action": "store_true", "default": None}
                dest = f"{setting.table}.{setting.key}"
                group.add_argument(setting.flag, dest=dest, help=text, **form)


@dataclass(frozen=True)
class Option:
    """An option for a table of a request file whose keys are names, or for a whole key of it.

    `read` returns the document of a request file that its text means, of all its texts if it may be
    `repeated`; without it, the option is for the job, which has a field of its name.
    """

    flag: str
    form: str
    words: str
    read: Callable[[Any], Document] | None = None
    repeated: bool = False

    @property
    def name(self) -> str:  # among the parsed options
        return self.flag.strip("-").replace("-", "_")

    def add(self, group: Parser | Group) -> None:
        form: dict[str, Any] = {"metavar": self.form} if self.form else {"action": "store_true"}
        if self.repeated:
            form |= {"action": "append", "default": []}
        group.add_argument(self.flag, dest=self.name, help=self.words, **form)


def named(
    flag: str,
    form: str,
    words: str,
    key: str,
    read: Callable[[str, str], Any],
    repeated: bool = True,
) -> Option:
    """Return an option NAME=VALUE for entries of the table `key`, read by `read(option, text)`."""

    def document(texts: Any) -> Document:
        pairs = assignments(flag, texts if repeated else [texts], form)
        return {key: {name: read(f"{flag} {name}", text) for name, text in pairs.items()}}

    return Option(flag, form, words, document, repeated)


def _parameter(option: str, text: str) -> float | str:
    is_text = option.split()[1] in ("law", "law_2") or option.endswith(f".{PLACE}")
    return text if is_text else from_text(float, option, text)


def _system(text: str) -> Document:
    with at("--system"):
        return {"system": load_system(text)}


SYSTEM = Option("--system", "NAME", "of the catalog, or a TOML file", _system)
SET = named("--set", "NAME=VALUE", "a parameter, in SI units", "set", _parameter)


def spaced(option: str, text: str, form: str = "START:STOP:NUM") -> dict[str, Any]:
    """Return the table `start, stop, num` of an axis that START:STOP:NUM means, perhaps `:log`."""
    scale = {"scale": "log"} if text.endswith(":log") else {}
    first, last, count = between_colons(option, text.removesuffix(":log"), form)
    start, stop = from_text(float, option, first), from_text(float, option, last)
    return {"start": start, "stop": stop, "num": from_text(int, option, count), **scale}


VARY = named("--vary", "NAME=START:STOP:NUM", "an axis; NUM:log: equal ratios", "vary", spaced)
SAMPLES = Option(
    "--samples", "FILE.csv", "sets of parameters, one a row", lambda text: {"samples": {FILE: text}}
)
FREQUENCY = Option(
    "--frequency",
    "UNIT",
    "of the frequency axis: rad/s, Hz, or ratio to the structure's [as stated]",
)

LOOK = (
    Option("--columns", "N", "the picture's width: 1 or 2 columns of a paper [2]"),
    Option("--width", "CM", "the picture's width in cm, in place of that of the columns"),
    Option("--title", "TEXT", "the picture's title; empty: none [that of the request]"),
)


def look_of(options: argparse.Namespace) -> Look:
    """Return the look that the options `LOOK` state; `RequestError` for what is not allowed."""
    width = None if options.width is None else from_text(float, "--width", options.width)
    with at("picture"):
        return Look(options.columns or 2, width, options.title)


def assignments(option: str, texts: Sequence[str], form: str) -> dict[str, str]:
    """Return the values by name of an option NAME=VALUE, which errors describe by its `form`."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise RequestError(f"{option} {shown(text)} must be {form}")
        if name in values:
            raise RequestError(f"{option} {name} is given twice: {values[name]} and {value}")
        values[name] = value
    return values


def numbers_by_name(option: str, text: str | None) -> dict[str, float]:
    """Return the numbers by name that a text NAME=VALUE,NAME=VALUE means; none for None."""
    pairs = assignments(option, comma_separated(text or ""), "NAME=VALUE,NAME=VALUE")
    return {name: from_text(float, f"{option} {name}", value) for name, value in pairs.items()}


def comma_separated(text: str) -> list[str]:
    return [word for word in map(str.strip, text.split(",")) if word]


def numbers(option: str, text: str) -> list[float]:
    return [from_text(float, option, word) for word in text.split(",")]


def between_colons(option: str, text: str, form: str) -> list[str]:
    """Return the texts between the colons of `text`, which must be as many as in `form`."""
    pieces = text.split(":")
    if len(pieces) != form.count(":") + 1:
        raise RequestError(f"{option} = {shown(text)} must be {form}")
    return pieces


def ends(option: str, text: str, *names: str) -> dict[str, float]:
    texts = between_colons(option, text, ":".join(names).upper())
    return {name: from_text(float, option, end) for name, end in zip(names, texts, strict=True)}
