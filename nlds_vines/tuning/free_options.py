"""The options that override a tuning file: how they are declared, and what they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from nlds_vines.cli.parser import Parser, assignments, parsed
from nlds_vines.errors import RequestError, at, shown
from nlds_vines.model.catalogue import load_system
from nlds_vines.tuning.request import SEARCHES

_SEARCH = ("population", "generations", "polish", "optima", "seed", "seeds")


def add_tuning_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("what to tune")
    group.add_argument("--system", metavar="NAME", help="of the catalogue, or a TOML file")
    _repeated(group, "--set", "NAME=VALUE", "SI units; what is set is not tuned")
    _repeated(group, "--free", "NAME[=LOW:HIGH]", "tune this too, or within other bounds")
    group.add_argument("--band", metavar="LOW:HIGH:NUM", help="the peak over these omega [rad/s]")
    _repeated(group, "--over", "NAME=A,B,...", "the worst over these values; several combine")
    group.add_argument("--transient", type=int, metavar="PERIODS", help="discarded [300]")
    group.add_argument("--periods", type=int, metavar="PERIODS", help="sampled [60; no walls: 2]")
    group = parser.add_argument_group("how to search")
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
    settings = assignments("--set", options.set, "NAME=VALUE")
    search = {name: getattr(options, name) for name in _SEARCH} | {"method": options.search}
    sampling = {name: getattr(options, name) for name in ("transient", "periods")}
    surface = {"parameters": _names(options.surface), "size": options.surface_size}
    found: dict[str, Any] = {
        "set": {name: parsed(float, f"--set {name}", text) for name, text in settings.items()},
        "free": _free(options.free),
        "over": _over(options.over, options.band),
        "search": _given(search),
        "sampling": _given(sampling),
        "surface": _given(surface),
    }
    if options.system is not None:
        with at("--system"):
            found["system"] = load_system(options.system)
    return {key: value for key, value in found.items() if value}


def _repeated(group: Any, option: str, form: str, text: str) -> None:
    group.add_argument(option, action="append", default=[], metavar=form, help=text)


def _given(table: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in table.items() if value is not None}


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name.strip() for name in text.split(",")]


def _free(texts: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the entries of `[free]` in a list of NAME or NAME=LOW:HIGH."""
    form = "NAME or NAME=LOW:HIGH"
    whole = [text if "=" in text else f"{text}=:" for text in texts]
    pairs = assignments("--free", whole, form)
    return {name: {} if text == ":" else _bounds(name, text) for name, text in pairs.items()}


def _bounds(name: str, text: str) -> dict[str, float]:
    where = f"--free {name}"
    ends = text.split(":")
    if len(ends) != 2:
        raise RequestError(f"{where} = {shown(text)} must be LOW:HIGH")
    low, high = (parsed(float, where, end) for end in ends)
    return {"low": low, "high": high}


def _over(texts: Sequence[str], band: str | None) -> dict[str, dict[str, Any]]:
    """Return the entries of `[over]` in a list of NAME=A,B,... and a band LOW:HIGH:NUM."""
    found: dict[str, dict[str, Any]] = {
        name: {"values": [parsed(float, f"--over {name}", item) for item in text.split(",")]}
        for name, text in assignments("--over", texts, "NAME=A,B,...").items()
    }
    if band is None:
        return found
    parts = band.split(":")
    if len(parts) != 3:
        raise RequestError(f"--band {shown(band)} must be LOW:HIGH:NUM")
    if "omega" in found:
        raise RequestError("--band and --over omega exclude each other: give one of them")
    start, stop = (parsed(float, "--band", part) for part in parts[:2])
    omega = {"start": start, "stop": stop, "num": parsed(int, "--band", parts[2])}
    return found | {"omega": omega}
