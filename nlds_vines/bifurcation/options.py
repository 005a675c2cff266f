"""The options that override a scan file: how they are declared, and what they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from nlds_vines.cli.parser import Parser, assignments, parsed
from nlds_vines.errors import RequestError, at, shown
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.settings import EFFORTS, METHODS
from nlds_vines.orbits.wants import WANTS


def add_scan_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("options that override the scan file")
    group.add_argument("--system", metavar="NAME", help="of the catalogue, or a TOML file")
    group.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="SI units")
    group.add_argument(
        "--vary", action="append", default=[], metavar="NAME=START:STOP:NUM", help="once or twice"
    )
    group.add_argument("--start", metavar="POLICY", help="rest, up, down, both or random:N")
    group.add_argument("--transient", type=int, metavar="PERIODS", help="discarded")
    group.add_argument("--periods", type=int, metavar="PERIODS", help="sampled")
    group.add_argument("--record", metavar="A,B,C", help=f"of {', '.join(WANTS)}")
    group.add_argument("--method", metavar="METHOD", help=" or ".join(METHODS))
    group.add_argument("--effort", metavar="EFFORT", help=f"of verdicts: {', '.join(EFFORTS)}")


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a scan file, as a document of the same form.

    Raises `RequestError` for an option that cannot be read as its form demands.
    """
    sampling = {
        name: getattr(options, name) for name in ("transient", "periods", "method", "effort")
    }
    found: dict[str, Any] = {
        "set": _settings(options.set),
        "vary": _axes(options.vary),
        "sampling": {name: value for name, value in sampling.items() if value is not None},
    }
    if options.system is not None:
        with at("--system"):
            found["system"] = load_system(options.system)
    if options.start is not None:
        found["start"] = _start(options.start)
    if options.record is not None:
        words = (word.strip() for word in options.record.split(","))
        found["record"] = {"want": [word for word in words if word]}
    return {key: value for key, value in found.items() if value}


def _settings(texts: Sequence[str]) -> dict[str, float]:
    """Return the parameters in a list of NAME=VALUE."""
    pairs = assignments("--set", texts, "NAME=VALUE")
    return {name: parsed(float, f"--set {name}", text) for name, text in pairs.items()}


def _axes(texts: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the entries of `[vary]` in a list of NAME=START:STOP:NUM."""
    return {
        name: _range(f"--vary {name}", text)
        for name, text in assignments("--vary", texts, "NAME=START:STOP:NUM").items()
    }


def _range(where: str, text: str) -> dict[str, float]:
    """Return the range in START:STOP:NUM."""
    parts = text.split(":")
    if len(parts) != 3:
        raise RequestError(f"{where} = {shown(text)} must be START:STOP:NUM")
    start, stop = (parsed(float, where, part) for part in parts[:2])
    return {"start": start, "stop": stop, "num": parsed(int, where, parts[2])}


def _start(text: str) -> dict[str, Any]:
    """Return the `[start]` table that rest, up, down or random:N means."""
    policy, _, count = text.partition(":")
    if policy != "random":
        return {"policy": text}
    return {"policy": policy, "count": parsed(int, "N of --start random:N", count)}
