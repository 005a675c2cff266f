"""The request file of a figure (TOML), read and checked."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from nlds_vines.bifurcation.request_file import FORM as SCAN_FORM
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError, at, choice, shown, string, table, unknown, whole
from nlds_vines.model.layers import Document, Form, Layer
from nlds_vines.packaged_files import figure_files
from nlds_vines.reproduce.request import COLOURS, LINES, Curve, FigureRequest, Panel, short_name
from nlds_vines.toml import read_toml

_MOST_COLUMNS = 4  # panels side by side: more of them are too narrow to read
_HEX = re.compile(r"#[0-9a-f]{6}")


def _truth(key: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise RequestError(f"{key} = {shown(value)} must be true or false")
    return value


FORM = Form(
    kind="figure",
    tables={
        **SCAN_FORM.tables,
        "figure": {
            "columns": lambda value: whole("columns", value, 1, _MOST_COLUMNS),
            "damper_energy": lambda value: _truth("damper_energy", value),
        },
    },
    lists=("panels", "curves"),
    names=False,
)
"""What may stand in the request file of a figure with curves: that of a scan, and more."""

_PANEL_KEYS = ("title", "system", "set", "base")
_CURVE_KEYS = ("label", "system", "set", "base", "colour", "line", "shade")


def packaged_figures() -> dict[str, FigureRequest]:
    """Return the requests of all packaged files, by short name, figures before studies."""
    found = {short_name(path.stem): path for path in sorted(figure_files(), key=_order)}
    return {name: load_figure(path) for name, path in found.items()}


def load_figure(path: Path) -> FigureRequest:
    """Return the request in a TOML file, checked throughout.

    Raises `RequestError`, one line that names file, place and key.
    """
    document = read_toml(path)
    if "portrait" in document:  # its own command reads and checks it
        return FigureRequest(path, "portrait", _title(path, document))
    if "curves" in document:
        return _with_curves(path, Layer(FORM, str(path), document))
    scan = load_scan(path)
    return FigureRequest(path, "scan", scan.title, (Panel((Curve(scan),)),))


def _order(path: Path) -> tuple[bool, int, str]:
    """Return what to sort by: figures by their numbers, then everything else."""
    number = re.match(r"figure(\d+)", path.stem)
    return number is None, int(number[1]) if number else 0, path.stem


def _title(path: Path, document: Document) -> str:
    with at(str(path)):
        return string("title", document.get("title", path.stem))


def _with_curves(path: Path, layer: Layer) -> FigureRequest:
    """Return the request of a page of curves."""
    document, look = layer.document, layer.values("figure")
    shared = {key: document[key] for key in SCAN_FORM.keys if key in document and key != "title"}
    with at(layer.where):
        frames = _entries(document, "panels", _PANEL_KEYS) or [{}]
        curves = _entries(document, "curves", _CURVE_KEYS)
        panels = tuple(_panel(shared, frame, curves) for frame in frames)
    return FigureRequest(path, "curves", _title(path, document), panels, **look)


def _entries(document: Document, key: str, allowed: Collection[str]) -> list[Document]:
    """Return the tables of an array `[[key]]`, their keys checked."""
    found = document.get(key, [])
    if not isinstance(found, list) or (not found and key in document):
        raise RequestError(f"{key} = {shown(found)} must be one or more tables [[{key}]]")
    with at(f"[[{key}]]"):
        return [table(f"entry {i}", entry, allowed) for i, entry in enumerate(found, start=1)]


def _panel(shared: Document, frame: Document, curves: list[Document]) -> Panel:
    """Return a panel with its curves; `shared` is what stands at the top of the file."""
    found = []
    for number, entry in enumerate(curves, start=1):
        with at(f"[[curves]] {number}"):
            found.append(_curve(shared, frame, entry))
    names = [curve.name for curve in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise RequestError(f"[[curves]]: {twice} stands twice in one panel")
    with at("[[panels]]"):
        title = string("title", frame.get("title", ""))
        return Panel(tuple(found), title, _settings(frame), _flag(frame, "base"))


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
    return _truth(key, entry.get(key, False))


def _colour(value: object) -> str:
    if isinstance(value, str) and _HEX.fullmatch(value):
        return value
    if isinstance(value, str) and value in COLOURS:
        return COLOURS[value]
    raise unknown("colour", value, [*COLOURS, "#rrggbb"])
