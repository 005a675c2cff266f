"""The request file of response curves (TOML), read and checked.

It is a scan file with tables `[[curves]]`, and `[[panels]]` for several panels; every curve stands
in every panel, or in the one that it names, and each of the two may name a system and set
parameters.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from nlds_vines.archives.toml import read_toml
from nlds_vines.bifurcation.request_file import FORM as SCAN_FORM
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.bifurcation.response_curves.request import COLOURS, LINES, Curve, CurvePage, Panel
from nlds_vines.errors import RequestError, at, choice, shown, string, table, unknown, whole
from nlds_vines.model.layers import Document, Form, Layer
from nlds_vines.model.setting import Truth, checks

_HEX = re.compile(r"#[0-9a-f]{6}")


FORM = Form(
    kind="page of curves",
    tables={**SCAN_FORM.tables, **checks(CurvePage)},
    lists=("panels", "curves"),
    names=False,
    sources="a path, a table or a CurvePage",
)
"""What may stand in the request file of a page of curves: that of a scan, and more."""

_PANEL_KEYS = ("title", "system", "set", "base")
_CURVE_KEYS = ("label", "system", "set", "base", "colour", "line", "shade", "panel")


def load_page(
    source: str | os.PathLike[str] | Mapping[str, Any],
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> CurvePage:
    """Return the page of curves in a TOML file, or in the document of one, checked throughout.

    Arguments: the `source`; `changes`, a document of the same form that overrides tables of it
    entry by entry, `vary` and `start` as a whole, and `curves` and `panels` as a whole;
    `changes_from` names it in the message of an error.

    Raises `RequestError`, one line that names file, place and key.
    """
    is_path = isinstance(source, str | os.PathLike)
    where = str(source) if is_path else changes_from if changes else FORM.kind
    document = read_toml(Path(str(source))) if is_path else source
    if not isinstance(document, Mapping):
        raise RequestError(f"{FORM.kind} = {shown(source)} must be {FORM.sources}")
    Layer(FORM, changes_from, changes or {})
    layer = Layer(FORM, where, _laid_over(document, changes or {}))
    return page_of(layer, Path(where).stem if is_path else "response curves")


def _laid_over(below: Document, above: Document) -> dict[str, Any]:
    """Return a document with changes laid over it."""
    found = dict(below)
    for key, value in above.items():
        merges = isinstance(value, Mapping) and key in ("set", "sampling", "record", "figure")
        kept = below.get(key, {})
        found[key] = {**kept, **value} if merges and isinstance(kept, Mapping) else value
    return found


def page_of(layer: Layer, title: str) -> CurvePage:
    """Return the page that a layer means; `title` where it has none."""
    document, look = layer.document, layer.values("figure")
    shared = {key: document[key] for key in SCAN_FORM.keys if key in document and key != "title"}
    with at(layer.where):
        frames = _entries(document, "panels", _PANEL_KEYS) or [{}]
        curves = _entries(document, "curves", _CURVE_KEYS)
        panels = tuple(_panel(shared, i, frame, curves) for i, frame in enumerate(frames, start=1))
        _refuse_lost(curves, len(frames))
        return CurvePage(string("title", document.get("title", title)), panels, **look)


def _entries(document: Document, key: str, allowed: Collection[str]) -> list[Document]:
    """Return the tables of an array `[[key]]`, their keys checked."""
    found = document.get(key, [])
    if not isinstance(found, list) or (not found and key in document):
        raise RequestError(f"{key} = {shown(found)} must be one or more tables [[{key}]]")
    with at(f"[[{key}]]"):
        return [table(f"entry {i}", entry, allowed) for i, entry in enumerate(found, start=1)]


def _panel(shared: Document, place: int, frame: Document, curves: list[Document]) -> Panel:
    """Return a panel with its curves; `shared` is what stands at the top of the file."""
    found = []
    for number, entry in enumerate(curves, start=1):
        with at(f"[[curves]] {number}"):
            if entry.get("panel", place) == place:
                found.append(_curve(shared, frame, entry))
    if not found:
        raise RequestError(f"[[panels]] {place} has no curve")
    names = [curve.name for curve in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise RequestError(f"[[curves]]: {twice} stands twice in one panel")
    with at("[[panels]]"):
        title = string("title", frame.get("title", ""))
        return Panel(tuple(found), title, _settings(frame), _flag(frame, "base"))


def _refuse_lost(curves: list[Document], panels: int) -> None:
    """Raise `RequestError` where a curve names a panel that there is not."""
    for number, entry in enumerate(curves, start=1):
        with at(f"[[curves]] {number}"):
            whole("panel", entry.get("panel", 1), 1, panels)


def _curve(shared: Document, frame: Document, entry: Document) -> Curve:
    """Return the curve that an entry means in the panel `frame`."""
    _refuse_twice(frame, entry)
    settings = {**_settings(frame), **_settings(entry)}
    system = frame.get("system", entry.get("system", shared.get("system")))
    everywhere = table("set", shared.get("set", {}))
    scan = load_scan({**shared, "system": system, "set": {**everywhere, **settings}})
    if len(scan.axes) != 1:
        raise RequestError(f"{len(scan.axes)} parameters are varied; allowed: one")
    return Curve(
        scan,
        string("label", entry.get("label", "")),
        settings,
        _colour(entry.get("colour", "black")),
        choice("line", entry.get("line", "solid"), LINES),
        _flag(entry, "base"),
        _flag(entry, "shade"),
    )


def _refuse_twice(frame: Document, entry: Document) -> None:
    """Raise `RequestError` where panel and curve both name a system or set the same parameter."""
    if "system" in frame and "system" in entry:
        raise RequestError("system is named by [[panels]] as well: name it in one of the two")
    both = sorted(_settings(frame).keys() & _settings(entry).keys())
    if both:
        raise RequestError(f"{both[0]} is set by [[panels]] as well: set it in one of the two")


def _settings(entry: Document) -> Mapping[str, Any]:
    return table("set", entry.get("set", {}))


def _flag(entry: Document, key: str) -> bool:
    return Truth()(key, entry.get(key, False))


def _colour(value: object) -> str:
    if isinstance(value, str) and _HEX.fullmatch(value):
        return value
    if isinstance(value, str) and value in COLOURS:
        return COLOURS[value]
    raise unknown("colour", value, [*COLOURS, "#rrggbb"])
