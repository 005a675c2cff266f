"""The values of options that several commands share: NAME=VALUE, START:STOP:NUM, A,B,C.

Every function here raises `RequestError` for a text of another form; the message names the option,
what was given and the form.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, at, from_text, shown
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import System


def assignments(option: str, texts: Sequence[str], form: str) -> dict[str, str]:
    """Return the values by name of an option that is given as NAME=VALUE, once or several times.

    Arguments: `form` is the form of the whole text, for the message of an error.  A name that is
    given twice is an error, too.
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


def numbers_by_name(
    option: str, text: str | None, form: str = "NAME=VALUE,NAME=VALUE"
) -> dict[str, float]:
    """Return the numbers that a text NAME=VALUE,NAME=VALUE means, by name; none for None."""
    pairs = assignments(option, comma_separated(text) or (), form)
    return {name: from_text(float, f"{option} {name}", value) for name, value in pairs.items()}


def varied(texts: Sequence[str], log: bool = True) -> dict[str, dict[str, Any]]:
    """Return the table of axes that --vary means, given once or several times."""
    pairs = assignments("--vary", texts, "NAME=START:STOP:NUM")
    return {name: spaced(f"--vary {name}", text, log=log) for name, text in pairs.items()}


def comma_separated(text: str | None) -> list[str] | None:
    """Return the words between the commas of a text, empty ones left out; None for None."""
    if text is None:
        return None
    return [word for word in (piece.strip() for piece in text.split(",")) if word]


def spaced(
    option: str, text: str, form: str = "START:STOP:NUM", log: bool = False
) -> dict[str, Any]:
    """Return the table `start, stop, num` of an axis that a text START:STOP:NUM means.

    Arguments: the `form`, for the message of an error; `log`, whether `:log` may follow it.
    """
    scale = {"scale": "log"} if log and text.endswith(":log") else {}
    bare = text.removesuffix(":log") if scale else text
    first, last, count = _between_colons(option, bare, form)
    start, stop = from_text(float, option, first), from_text(float, option, last)
    return {"start": start, "stop": stop, "num": from_text(int, option, count), **scale}


def number_or_word(option: str, text: str | None) -> float | str | None:
    """Return the number that the text of an option means; any other text as it is, and None."""
    if text is None or text[:1].isalpha():
        return text
    return from_text(float, option, text)


def interval(option: str, text: str) -> dict[str, float]:
    """Return the table `low, high` that a text LOW:HIGH means."""
    low, high = _between_colons(option, text, "LOW:HIGH")
    return {"low": from_text(float, option, low), "high": from_text(float, option, high)}


def _between_colons(option: str, text: str, form: str) -> list[str]:
    """Return what stands between the colons of `text`, which must be as many as in `form`."""
    pieces = text.split(":")
    if len(pieces) != form.count(":") + 1:
        raise RequestError(f"{option} = {shown(text)} must be {form}")
    return pieces


def given(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries that have a value: an option that is not given is None."""
    return {name: value for name, value in values.items() if value is not None}


def add_system_options(
    group: Parser | argparse._ArgumentGroup,
    system: str = "of the catalog, or a TOML file",
    settings: str = "SI units",
) -> None:
    """Declare --system and --set; `system` and `settings` are their help texts."""
    group.add_argument("--system", metavar="NAME", help=system)
    group.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=settings)


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters that --set gives, by name [SI units], and the laws of contacts."""
    pairs = assignments("--set", options.set, "NAME=VALUE")
    return {
        name: text if name in ("law", "law_2") else from_text(float, f"--set {name}", text)
        for name, text in pairs.items()
    }


def system_changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what --system and --set change in a request, as entries `system` and `set` of one."""
    found: dict[str, Any] = {}
    if settings := settings_of(options):
        found["set"] = settings
    if options.system is not None:
        with at("--system"):
            found["system"] = load_system(options.system)
    return found


def chosen_system(options: argparse.Namespace, default: str) -> System:
    """Return the system that --system names, by default `default`, with what --set sets."""
    settings = settings_of(options)
    with at("--system"):
        system = load_system(default if options.system is None else options.system)
    with at("--set"):
        return system.with_(**settings)
