"""The request file of a portrait (TOML), read and checked."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from nlds_vines.errors import RequestError, at, choice, number, shown, string, table, whole
from nlds_vines.model.catalogue import load_system, system_from
from nlds_vines.model.system import System
from nlds_vines.portrait.request import (
    PERIODS,
    SYSTEM,
    TRANSIENT,
    Column,
    PortraitRequest,
    Window,
    checked_window,
    described,
)
from nlds_vines.toml import read_toml

_KEYS: Mapping[str, tuple[str, ...] | None] = {
    "set": None,  # the system knows which parameters it has
    "start": ("policy", "state"),
    "sampling": ("transient", "periods", "windows", "samples", "method"),
    "portrait": ("panels", "show", "signal", "taper", "comb"),
}
_TOP = ("title", "system", *_KEYS, "column")


def load_portrait(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | None = None,
    changes: Mapping[str, Any] | None = None,
) -> PortraitRequest:
    """Return the request that a source means, checked throughout.

    Arguments:
        source: path of a TOML file (.toml), name of a system, the document in a file as nested
            tables, a `System`, or None for SSul NES Set 6 as it stands in the catalogue.
        changes: a document of the same form that overrides it entry by entry.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    where, document = _open(source)
    with at(where):
        below = _checked(document)
    above = _checked(changes or {})
    merged = {key: {**below.get(key, {}), **above.get(key, {})} for key in _KEYS}
    if above.get("sampling", {}).keys() & {"transient", "periods"}:
        merged["sampling"].pop("windows", None)  # what was asked for last is meant
        _refuse_both(above["sampling"])
    with at(where):
        columns = _columns(below, above, merged)
        return PortraitRequest(
            _title(below, above, columns),
            columns,
            start=_start(merged["start"]),
            **{k: merged["sampling"][k] for k in ("samples", "method") if k in merged["sampling"]},
            **merged["portrait"],
        )


def _open(source: object) -> tuple[str, Mapping[str, Any]]:
    """Return the name of a source's place, empty if there is none, and the document in it."""
    if source is None:
        return "", {"system": SYSTEM}
    if isinstance(source, System):
        return "", {"system": source}
    if isinstance(source, Mapping):
        return "portrait", source
    if isinstance(source, str) and not source.endswith(".toml"):
        return "", {"system": load_system(source)}
    if isinstance(source, str | os.PathLike):
        return str(source), read_toml(Path(source))
    raise RequestError(f"portrait = {shown(source)} must be a path, a name, a table or a System")


def _checked(document: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a document whose tables hold none but known keys."""
    table("the portrait", document, _TOP)
    for key, allowed in _KEYS.items():
        table(f"[{key}]", document.get(key, {}), allowed)
    columns = document.get("column", [])
    if not isinstance(columns, Sequence) or isinstance(columns, str):
        raise RequestError(f"column = {shown(columns)} must be a list of tables [[column]]")
    for entry in columns:
        table("[[column]]", entry, ("name", "set", "window"))
    _refuse_both(document.get("sampling", {}))
    return document


def _refuse_both(sampling: Mapping[str, Any]) -> None:
    if "windows" in sampling and sampling.keys() & {"transient", "periods"}:
        raise RequestError("windows beside transient or periods: give windows, or the other two")


def _columns(
    below: Mapping[str, Any], above: Mapping[str, Any], merged: Mapping[str, Any]
) -> tuple[Column, ...]:
    """Return the columns: each of [[column]], in each of the windows or in its own."""
    system = system_from(above.get("system", below.get("system")))
    asked = above.get("sampling", {}).keys() & {"windows", "transient", "periods"}
    windows, found = _windows(merged["sampling"]), []
    for entry in below.get("column", []) or [{}]:
        own = {**below.get("set", {}), **table("set", entry.get("set", {})), **above.get("set", {})}
        one = system.with_(**own)
        given = "window" in entry and not asked
        for window in [checked_window("window", entry["window"])] if given else windows:
            name = string("name", entry.get("name", ""))
            found.append(Column(one, window, name))
    return tuple(found)


def _windows(sampling: Mapping[str, Any]) -> list[Window]:
    """Return the windows of a run, in the order of time."""
    if "windows" not in sampling:
        transient = whole("transient", sampling.get("transient", TRANSIENT), 0)
        return [
            Window(transient, transient + whole("periods", sampling.get("periods", PERIODS), 1))
        ]
    value = sampling["windows"]
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise RequestError(f"windows = {shown(value)} must be a list of pairs [begin, end]")
    found = [checked_window("windows", pair) for pair in value]
    for first, second in pairwise(found):
        if second.begin < first.end:
            raise RequestError(
                f"windows {first.begin}:{first.end} and {second.begin}:{second.end} "
                "must follow each other in time"
            )
    return found


def _start(entry: Mapping[str, Any]) -> tuple[float, ...] | None:
    if "state" not in entry:
        choice("policy", entry.get("policy", "rest"), ("rest",))
        return None
    if "policy" in entry:
        raise RequestError("[start] policy beside state: give one of them")
    values = entry["state"]
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise RequestError(f"state = {shown(values)} must be a list of numbers")
    return tuple(number("state", value) for value in values)


def _title(below: Mapping[str, Any], above: Mapping[str, Any], columns: Sequence[Column]) -> str:
    """Return the title given, or one made of the system where none is or it is true no more."""
    for document in (above, below):
        outdated = document is below and above.keys() & {"system", "set"}
        if "title" in document and not outdated:
            return string("title", document["title"])
    system = columns[0].system
    same = all(column.system == system for column in columns)
    return described(system) if same else (system.title or system.name)
