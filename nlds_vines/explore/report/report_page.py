"""A map as one page: figures, numbers, words and script in one file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.models import ColumnDataSource, CustomJS, Range1d
from bokeh.resources import Resources

from nlds_vines.continuation.result import Continued
from nlds_vines.explore.cell_columns import NUMBERS, columns, section_points
from nlds_vines.explore.look import frame, page_file, plain_figure, roled
from nlds_vines.explore.map_figure import map_figures
from nlds_vines.explore.map_meta import meta_of
from nlds_vines.explore.opened import middle
from nlds_vines.explore.report.branch_lines import draw_branches, special_rows
from nlds_vines.explore.report.claims_rows import ClaimRow
from nlds_vines.explore.report.packing import coded, packed
from nlds_vines.explore.stored import Stored

MOST_BYTES = 5_000_000
"""The most bytes of a page, so that it can be sent by mail."""

POINTS = (120, 48, 24, 12, 6, 3, 1, 0)
"""How many states of each section a page holds: the most for which it is small enough."""

_KEPT = ("status", "label", "most", "coexisting")  # never left out
_SYMBOLS = {"x": "x", "v": "ẋ", "x1": "x₁", "v1": "ẋ₁", "x2": "x₂", "v2": "ẋ₂"}
_PLANE = 250  # pixels, height of a phase plane
_PROVENANCE = (
    ("source", "made by"), ("commit", "commit"), ("history", "history"), ("scan_hash", "hash"),
    ("system", "system"), ("kind", "kind"), ("machine", "machine"),
    ("python_version", "Python"), ("numba_version", "Numba"), ("numpy_version", "NumPy"),
)  # fmt: skip


@dataclass(frozen=True)
class Report:
    """A page and what was left out of it for the sake of its size, in words."""

    html: str
    left_out: str

    @property
    def size(self) -> int:
        """Its bytes."""
        return len(self.html.encode())


def report_page(
    found: Stored, branches: Continued | None = None, claims: Sequence[ClaimRow] = ()
) -> Report:
    """Return the page of a map, with branches and claims where there are any.

    As many states of the sections, and then as many numbers, as `MOST_BYTES` allow.
    """
    everything = columns(found)
    optional = [name for name in NUMBERS if name in everything]
    extra = [name for name in everything if name not in (*_KEPT, *optional)]
    report = None
    for points in POINTS:
        report = _page(found, branches, claims, everything, points)
        if report.size <= MOST_BYTES:
            return report
    for count in range(len(optional) - 1, -1, -1):
        kept = {
            name: everything[name]
            for name in everything
            if name in (*_KEPT, *optional[:count], *extra)
        }
        report = _page(found, branches, claims, kept, 0)
        if report.size <= MOST_BYTES:
            break
    assert report is not None
    return report


def _page(
    found: Stored,
    branches: Continued | None,
    claims: Sequence[ClaimRow],
    kept: Mapping[str, np.ndarray],
    points: int,
) -> Report:
    """Return the page with so many states of each section, and the columns that are kept."""
    states = section_points(found, points) if points else np.empty((0, 0, 0))
    codes, ranges = coded(states)
    meta = meta_of(found, states.shape[1])
    shown = [show for show in meta["shows"] if show["points"] or show["column"] in kept]
    meta |= {"shows": shown, "cell": list(middle(found)), "ranges": ranges}
    meta["components"] = list(found.scan.system.scene.components)
    box = packed({**kept, "section": codes.ravel()})
    left_out = _left_out(found, states.shape[1], kept)
    variables = {
        "css": page_file("page.css"),
        "script": page_file("page.js") + page_file("report.js"),
        "meta": _script_json({**meta, "entries": box.entries, "rows": found.scan.lanes}),
        "packed": box.text,
        "provenance": _provenance(found),
        "request": found.scan.to_toml(),
        "left_out": left_out,
        "claims": claims,
        "special": [] if branches is None else special_rows(branches),
        "planes": ("plane 1", "plane 2"),
    }
    document = _document(found, branches)
    resources = Resources(mode="inline")
    html = file_html(
        document, resources, title=found.scan.title, template=frame("report.html"),
        template_variables=variables,
    )  # fmt: skip
    return Report(html, left_out)


def _document(found: Stored, branches: Continued | None) -> Document:
    """Return the figures: the map, and the phase planes of the chosen cell's section."""
    maps = map_figures(len(found.scan.axes), len(found.starts), "label" in found, False)
    if branches is not None:
        draw_branches(maps[0], branches, found)
    document = Document()
    for root in (*maps, *_planes(found)):
        document.add_root(root)
    document.js_on_event("document_ready", CustomJS(code="REPORT.start()"))
    return document


def _planes(found: Stored) -> list[Any]:
    """Return the phase planes of structure and damper, with the section alone."""
    components = found.scan.system.scene.components
    source = ColumnDataSource({name: [] for name in components}, name="section")
    pairs = [components[i : i + 2] for i in range(0, len(components), 2)]
    figures = []
    for i, (x, v) in enumerate(pairs, start=1):
        made = plain_figure(f"plane {i}", _PLANE, x_range=Range1d(0, 1), y_range=Range1d(0, 1))
        dots = made.scatter(x, v, source=source, size=6, line_color=None)
        roled(dots, "wall")
        made.xaxis.axis_label, made.yaxis.axis_label = f"{_SYMBOLS[x]} [m]", f"{_SYMBOLS[v]} [m/s]"
        made.xaxis.ticker.desired_num_ticks = 4
        figures.append(made)
    return figures


def _left_out(found: Stored, points: int, kept: Mapping[str, np.ndarray]) -> str:
    """Return what the archive holds and the page does not, in words."""
    words = []
    if "section" in found and points < found.scan.periods:
        words.append(f"{points} of the {found.scan.periods} recorded states of each section")
    missing = [name for name in NUMBERS if name in found and name not in kept]
    if missing:
        words.append(f"not {', '.join(missing)}")
    text = "Numbers are rounded to about four digits"
    return f"{text}; this page holds {'; '.join(words)}." if words else f"{text}."


def _provenance(found: Stored) -> list[tuple[str, str]]:
    """Return where the archive comes from, (quantity, value) each."""
    name = [("archive", found.path.name)] if found.path is not None else []
    rows = [(words, str(found.about[key])) for key, words in _PROVENANCE if key in found.about]
    return [*name, *rows]


def _script_json(value: Any) -> str:
    """Return a value as JSON that may stand in a script of a page."""
    return json.dumps(value).replace("</", "<\\/").replace("<!--", "<\\!--")


def write_page(path: Path, report: Report) -> None:
    """Write a page whole: an existing file is replaced when the new one is there."""
    from nlds_vines.archives.durable import in_one_line

    temporary = path.with_name(f"{path.name}.tmp")
    with in_one_line(f"write {path}"):
        try:
            temporary.write_text(report.html, encoding="utf-8")
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
