"""The option of the command line that means a load, of response histories and of tunings."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from nlds_vines.cli.options import Option, assignments
from nlds_vines.errors import from_text, unknown
from nlds_vines.model.loads.loading import ALL


def _loads(texts: Sequence[str]) -> dict[str, Any]:
    """Return the document of loads, each KIND:KEY=VALUE,... or the path of a record."""
    load: dict[str, list[Any]] = {}
    for text in texts:
        kind, entry = _load(text)
        load.setdefault(kind, []).append(entry)
    return {"load": load}


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


LOAD = Option(
    "--load",
    "LOAD",
    "a record (CSV, HDF5), or KIND:KEY=VALUE,...; once for each of a sum",
    _loads,
    repeated=True,
)
