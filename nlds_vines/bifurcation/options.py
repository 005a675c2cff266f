"""The options that override a scan file: how they are declared, and what they mean."""

from __future__ import annotations

import argparse
from typing import Any

from nlds_vines.bifurcation.request import Scan
from nlds_vines.cli.option_values import (
    add_system_options,
    assignments,
    spaced,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, from_text
from nlds_vines.orbits.starts import STATE


def add_scan_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("options that override the scan file")
    add_system_options(group)
    group.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NAME=START:STOP:NUM",
        help="once or twice, x2_0 too; NUM:log for equal ratios",
    )
    group.add_argument(
        "--start",
        metavar="POLICY",
        help="rest, up, down, both, random:N or x1,v1,x2,v2; @PHASE after it",
    )
    add_settings(group, Scan)


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a scan file, as a document of the same form.

    Raises `RequestError` for an option that cannot be read as its form demands.
    """
    vary = assignments("--vary", options.vary, "NAME=START:STOP:NUM")
    found: dict[str, Any] = {
        **system_changes(options),
        "vary": {name: spaced(f"--vary {name}", text, log=True) for name, text in vary.items()},
        **changed(options, Scan),
    }
    if options.start is not None:
        found["start"] = _start(options.start)
    return {key: value for key, value in found.items() if value}


def _start(text: str) -> dict[str, Any]:
    """Return the `[start]` table that rest, up, down, random:N or a state means.

    After an @ stands the phase of the force there.
    """
    text, at, phase = text.partition("@")
    if at:
        if not text:
            raise RequestError(f"--start @{phase}: a state or rest stands before the @")
        return {**_start(text), "phase": from_text(float, f"--start {text}@{phase}", phase)}
    if "," in text:
        state = [from_text(float, f"--start {text}", word) for word in text.split(",")]
        return {"policy": STATE, "state": state}
    policy, _, count = text.partition(":")
    if policy != "random":
        return {"policy": text}
    return {"policy": policy, "count": from_text(int, "N of --start random:N", count)}
