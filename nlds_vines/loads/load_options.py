"""Options of the command line that mean a load: --impulse, --load and their like."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection
from typing import Any

from nlds_vines.cli.option_values import assignments
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import from_text, unknown
from nlds_vines.loads.request import HistoryRequest
from nlds_vines.model.loads.loading import ALL, Loading


def add_load_options(group: argparse._ArgumentGroup, but: Collection[str] = ()) -> None:
    """Declare them, `but` those of keys for which the command has options of its own."""
    group.add_argument(
        "--load", action="append", default=[], metavar="LOAD",
        help="a record (CSV, HDF5), or KIND:KEY=VALUE,...; once for each of a sum",
    )  # fmt: skip
    add_settings(group, Loading, HistoryRequest, but=but)


def load_changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what they change in a request file, as a document of the same form."""
    above: dict[str, Any] = changed(options, HistoryRequest, Loading)
    for text in options.load:
        kind, entry = _load(text)
        above.setdefault("load", {}).setdefault(kind, []).append(entry)
    return above


def _load(text: str) -> tuple[str, dict[str, Any]]:
    """Return the kind and the table that KIND:KEY=VALUE,... or the path of a record means."""
    kind, colon, rest = text.partition(":")
    if not colon or kind not in ALL:
        if colon and kind.isidentifier() and not os.path.exists(text):
            raise unknown("load", kind, ALL)
        return "record", {"file": text}
    pairs = assignments(f"--load {kind}:", rest.split(","), "KEY=VALUE")
    words = {"true": True, "false": False}
    return kind, {
        key: words.get(value, _number_in(f"--load {kind}: {key}", value))
        for key, value in pairs.items()
    }


def _number_in(what: str, text: str) -> int | float | str:
    """Return the number that a text means, a whole one as such; another text as it is."""
    if text.isascii() and text.isdigit():
        return from_text(int, what, text)
    return text if text[:1].isalpha() else from_text(float, what, text)
