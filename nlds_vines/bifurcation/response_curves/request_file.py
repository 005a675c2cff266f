"""The request file of response curves (TOML), read and checked.

It is a scan file with tables `[[curves]]`, and `[[panels]]` for several panels; every curve stands
in every panel, or in the one that it names, and each of the two may name a system and set
parameters.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nlds_vines.archives.files import read_toml
from nlds_vines.bifurcation.request_file import FORM as SCAN_FORM
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.bifurcation.response_curves.request import (
    COLORS,
    LINES,
    Curve,
    CurvePage,
    Panel,
    records_of,
)
from nlds_vines.errors import RequestError, at, shown, string, table, unknown, whole
from nlds_vines.model.request_layers import Document, Form, Layer, unchecked
from nlds_vines.model.setting import (
    Checked,
    OneOf,
    ParameterTable,
    Text,
    Truth,
    Whole,
    checks,
    reader,
    setting,
)
from nlds_vines.orbits.records import USUAL

_HEX = re.compile(r"#[0-9a-f]{6}")


def _color(value: object) -> str:
    """Return a color as #rrggbb."""
    if isinstance(value, str) and _HEX.fullmatch(value):
        return value
    if isinstance(value, str) and value in COLORS:
        return COLORS[value]
    raise unknown("color", value, [*COLORS, "#rrggbb"])


@dataclass(frozen=True)
class PanelEntry:
    """A panel of the page in a file."""

    title: str = setting("", Text(), "[panels]", "what stands above it")
    system: Any = setting(None, Checked(unchecked), "[panels]", "of all its curves")
    settings: Mapping[str, Any] | None = setting(
        None, ParameterTable(), "[panels]", "parameters of all its curves", key="set"
    )
    base: bool = setting(False, Truth(), "[panels]", "whether it is that of the original tuning")


@dataclass(frozen=True)
class CurveEntry:
    """A curve in a file, which stands in every panel, or in one."""

    label: str = setting(
        "", Text(), "[curves]", "in the legend", usual="what it sets, or its system"
    )
    system: Any = setting(None, Checked(unchecked), "[curves]", "its system", usual="the page's")
    settings: Mapping[str, Any] | None = setting(
        None, ParameterTable(), "[curves]", "parameters of it", key="set"
    )
    base: bool = setting(False, Truth(), "[curves]", "whether it is drawn stronger")
    color: str = setting(
        COLORS["black"], Checked(_color), "[curves]",
        f"{', '.join(f'`{name}`' for name in COLORS)} or `#rrggbb`", usual="black",
    )  # fmt: skip
    line: str = setting("solid", OneOf(LINES), "[curves]", ", ".join(f"`{name}`" for name in LINES))
    shade: bool = setting(False, Truth(), "[curves]", "whether its impacts are shown")
    panel: int | None = setting(
        None, Whole(1), "[curves]", "number of the only panel that has it, from 1"
    )


FORM = Form(
    kind="page of curves",
    tables={**SCAN_FORM.tables, **checks(CurvePage)},
    rows={"panels": reader(PanelEntry), "curves": reader(CurveEntry)},
    names=False,
    sources="a path, a table or a CurvePage",
)
"""What may stand in the request file of a page of curves: that of a scan, and more."""


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
    if "show" in look:
        shared = recording(shared, records_of(look["show"]))
    frames, curves = layer.rows("panels") or [PanelEntry()], layer.rows("curves")
    with at(layer.where):
        for number, entry in enumerate(curves, start=1):
            with at(f"[[curves]] {number}"):
                whole("panel", entry.panel or 1, 1, len(frames))
        panels = tuple(_panel(shared, i, frame, curves) for i, frame in enumerate(frames, start=1))
        return CurvePage(string("title", document.get("title", title)), panels, **look)


def recording(shared: Document, words: Sequence[str]) -> dict[str, Any]:
    """Return the tables of a scan that records these words, too."""
    record = table("record", shared.get("record", {}))
    want = record.get("want", USUAL)
    missing = [word for word in words if word not in want] if isinstance(want, Sequence) else []
    return {**shared, "record": {**record, "want": [*want, *missing]}} if missing else {**shared}


def _panel(shared: Document, place: int, frame: PanelEntry, curves: list[CurveEntry]) -> Panel:
    """Return a panel with its curves; `shared` is what stands at the top of the file."""
    found = []
    for number, entry in enumerate(curves, start=1):
        with at(f"[[curves]] {number}"):
            if entry.panel in (None, place):
                found.append(_curve(shared, frame, entry))
    if not found:
        raise RequestError(f"[[panels]] {place} has no curve")
    names = [curve.name for curve in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise RequestError(f"[[curves]]: {twice} stands twice in one panel")
    return Panel(tuple(found), frame.title, frame.settings or {}, frame.base)


def _curve(shared: Document, frame: PanelEntry, entry: CurveEntry) -> Curve:
    """Return the curve that an entry means in the panel `frame`."""
    if frame.system is not None and entry.system is not None:
        raise RequestError("system is named by [[panels]] as well: name it in one of the two")
    shared_by_panel, own = frame.settings or {}, entry.settings or {}
    both = sorted(shared_by_panel.keys() & own.keys())
    if both:
        raise RequestError(f"{both[0]} is set by [[panels]] as well: set it in one of the two")
    settings = {**shared_by_panel, **own}
    named = [one for one in (frame.system, entry.system) if one is not None]
    system = named[0] if named else shared.get("system")
    everywhere = table("set", shared.get("set", {}))
    scan = load_scan({**shared, "system": system, "set": {**everywhere, **settings}})
    if len(scan.axes) != 1:
        raise RequestError(f"{len(scan.axes)} parameters are varied; allowed: one")
    return Curve(scan, entry.label, settings, entry.color, entry.line, entry.base, entry.shade)
