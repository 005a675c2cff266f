"""The options that override a tuning file: how they are declared, and what they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from nlds_vines.cli.option_values import (
    add_system_options,
    add_tolerance,
    assignments,
    comma_separated,
    given,
    interval,
    number_or_word,
    spaced,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, from_text
from nlds_vines.tuning.request import SEARCHES

_SEARCH = ("objective", "population", "generations", "polish", "optima", "seed", "seeds")


def add_tuning_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("what to tune")
    add_system_options(group, settings="SI units; what is set is not tuned")
    _repeated(group, "--free", "NAME[=LOW:HIGH]", "tune this too, or within other bounds")
    group.add_argument("--band", metavar="LOW:HIGH:NUM", help="the peak over these omega [rad/s]")
    _repeated(group, "--over", "NAME=A,B,...", "the worst over these values; several combine")
    group.add_argument("--transient", type=int, metavar="PERIODS", help="discarded [300]")
    group.add_argument("--periods", type=int, metavar="PERIODS", help="sampled [60; no walls: 2]")
    add_tolerance(group)
    group = parser.add_argument_group("how to search")
    group.add_argument(
        "--objective", metavar="NAME", help="what is to be small: E2max, a1_rms, ... [E1max]"
    )
    group.add_argument("--search", metavar="METHOD", help=f"{' or '.join(SEARCHES)} [de]")
    group.add_argument("--population", type=int, metavar="N", help="designs in a generation [60]")
    group.add_argument("--generations", type=int, metavar="N", help="at most [80]")
    group.add_argument("--polish", type=int, metavar="N", help="evaluations of local search [150]")
    group.add_argument("--optima", type=int, metavar="N", help="near-equal designs, at most [5]")
    group.add_argument("--seed", type=int, metavar="N", help="the same seed, the same bits [0]")
    group.add_argument("--seeds", type=int, metavar="N", help="repeat with so many seeds [1]")
    group = parser.add_argument_group("the objective over two free parameters")
    group.add_argument("--surface", metavar="A,B", help="compute a grid through the optimum")
    group.add_argument("--surface-size", type=int, metavar="N", help="values of each [41]")


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a tuning file, as a document of the same form.

    Raises `RequestError` for an option that cannot be read as its form demands.
    """
    search = {name: getattr(options, name) for name in _SEARCH} | {"method": options.search}
    sampling: dict[str, Any] = {"transient": options.transient, "periods": options.periods}
    sampling["tolerance"] = number_or_word("--tolerance", options.tolerance)
    names = comma_separated(options.surface)
    found: dict[str, Any] = {
        **system_changes(options),
        "free": _free(options.free),
        "over": _over(options.over, options.band),
        "search": given(search),
        "sampling": given(sampling),
        "surface": given({"parameters": names, "size": options.surface_size}),
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
