"""The options that override a tuning file: how they are declared, and what they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from nlds_vines.cli.option_values import (
    add_system_options,
    assignments,
    interval,
    spaced,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, from_text
from nlds_vines.tuning.request import Search, Surface, Tuning


def add_tuning_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("what to tune")
    add_system_options(group, settings="SI units; what is set is not tuned")
    _repeated(group, "--free", "NAME[=LOW:HIGH]", "tune this too, or within other bounds")
    group.add_argument("--band", metavar="LOW:HIGH:NUM", help="the peak over these omega [rad/s]")
    _repeated(group, "--over", "NAME=A,B,...", "the worst over these values; several combine")
    add_settings(group, Tuning)
    add_settings(parser.add_argument_group("how to search"), Search)
    add_settings(parser.add_argument_group("the objective over two free parameters"), Surface)


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a tuning file, as a document of the same form.

    Raises `RequestError` for an option that cannot be read as its form demands.
    """
    found: dict[str, Any] = {
        **system_changes(options),
        "free": _free(options.free),
        "over": _over(options.over, options.band),
        **changed(options, Tuning, Search, Surface),
    }
    return {key: value for key, value in found.items() if value}


def _repeated(group: Any, option: str, form: str, text: str) -> None:
    group.add_argument(option, action="append", default=[], metavar=form, help=text)


def _free(texts: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the entries of `[free]` in a list of NAME or NAME=LOW:HIGH."""
    complete = [text if "=" in text else f"{text}=:" for text in texts]
    pairs = assignments("--free", complete, "NAME or NAME=LOW:HIGH")
    return {
        name: {} if text == ":" else interval(f"--free {name}", text)
        for name, text in pairs.items()
    }


def _over(texts: Sequence[str], band: str | None) -> dict[str, dict[str, Any]]:
    """Return the entries of `[over]` in a list of NAME=A,B,... and a band LOW:HIGH:NUM of omega."""
    found: dict[str, dict[str, Any]] = {
        name: {"values": [from_text(float, f"--over {name}", item) for item in text.split(",")]}
        for name, text in assignments("--over", texts, "NAME=A,B,...").items()
    }
    if band is None:
        return found
    if "omega" in found:
        raise RequestError("--band and --over omega exclude each other: give one of them")
    return found | {"omega": spaced("--band", band, "LOW:HIGH:NUM")}
