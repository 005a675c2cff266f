"""A map as one page: figures, numbers, words and script in one file."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.models import ColumnDataSource, CustomJS, Range1d
from bokeh.resources import Resources

from nlds_vines.continuation.result import Continued
from nlds_vines.explore.cell_columns import columns, meta_of, section_points
from nlds_vines.explore.map_choices import STATUS_SHOW
from nlds_vines.explore.map_data import NUMBERS, Stored
from nlds_vines.explore.map_figure import map_figures
from nlds_vines.explore.page_elements import frame, page_file, plain_figure, roled
from nlds_vines.explore.report.branch_lines import (
    Table,
    draw_branches,
    marks_of,
    special_table,
)
from nlds_vines.explore.shared_map import middle

MOST_BYTES = 5_000_000
"""The most bytes of a page, so that it can be sent by mail."""

POINTS = (1000, 240, 120, 48, 24, 12, 6, 3, 1)
"""How many states of each section a page holds: the most for which it is small enough."""

_SECTION_SHARE = 0.4  # of the room, which sections may take from numbers
_MOST_PACKED = 100  # times smaller than its numbers is a column at best
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
    found: Stored, branches: Continued | None = None, tables: Sequence[Table] = ()
) -> Report:
    """Return the page of a map, with branches and further tables where there are any.

    It holds as many states of the sections, and as many of the recorded numbers, as `MOST_BYTES`
    allow, the most telling first.
    """
    special = [] if branches is None else [special_table(branches)]
    tables = [table for table in (*special, *tables) if table.rows]
    bare = _page(found, branches, tables, _Content([], 0, []))
    return _page(found, branches, tables, _chosen(found, MOST_BYTES - bare.size))


class _Content(NamedTuple):
    """The columns of a page, how many states of each section, the ranges of their components."""

    columns: list[Packed]
    points: int
    ranges: list[list[float]]


def _chosen(found: Stored, room: int) -> _Content:
    """Return what of an archive fits into so many bytes."""
    every = [packed(name, values) for name, values in columns(found).items()]
    numbers = [one for one in every if one.name in NUMBERS]
    chosen = [one for one in every if one.name not in NUMBERS]
    room -= sum(map(_bytes, chosen))
    spare = room - sum(map(_bytes, numbers))
    section = _sections(found, max(spare, int(_SECTION_SHARE * room)))
    room -= sum(map(_bytes, section.columns))
    for one in numbers:
        if _bytes(one) <= room:
            chosen.append(one)
            room -= _bytes(one)
    return section._replace(columns=[*chosen, *section.columns])


def _sections(found: Stored, room: int) -> _Content:
    """Return the most states of all sections that fit into so many bytes."""
    for count in POINTS:
        states = section_points(found, count)
        if states.size and 2 * states.size < _MOST_PACKED * max(room, 0):
            codes, ranges = coded(states)
            one = packed("section", codes)
            if _bytes(one) <= room:
                return _Content([one], states.shape[1], ranges)
    return _Content([], 0, [])


def _bytes(one: Packed) -> int:
    """Return the bytes of a column on a page, with its entry."""
    return len(one.text) + 80


def _page(
    found: Stored, branches: Continued | None, tables: Sequence[Table], content: _Content
) -> Report:
    """Return the page of a map with so much content."""
    kept = [one.name for one in content.columns]
    meta = meta_of(found, content.points)
    points = content.points > 0
    components = found.scan.system.scene.components  # of touches the page holds nothing
    held = [s for s in meta["shows"] if not s["points"] or s["name"] in components]
    shows = [s for s in held if (points if s["points"] else s["column"] in kept)]
    meta |= {
        "shows": shows or [STATUS_SHOW.plain()],
        "cell": list(middle(found)),
        "ranges": content.ranges,
    }
    meta["components"] = list(components)
    meta |= {"entries": [one.entry for one in content.columns], "rows": found.scan.lanes}
    left_out = _left_out(found, content.points, kept)
    variables = {
        "css": page_file("page.css"),
        "script": page_file("page.js") + page_file("report.js"),
        "meta": _script_json(meta),
        "packed": "\n".join(one.text for one in content.columns),
        "provenance": _provenance(found),
        "request": found.scan.to_toml(),
        "left_out": left_out,
        "branches": branches is not None,
        "marks": [] if branches is None else marks_of(branches),
        "tables": tables,
        "planes": ("plane 1", "plane 2"),
    }
    html = file_html(
        _document(found, branches), Resources(mode="inline"), title=found.scan.title,
        template=frame("report.html"), template_variables=variables,
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


def _left_out(found: Stored, points: int, kept: Sequence[str]) -> str:
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
    return json.dumps(value).replace("<", "\\u003c")


# ---- numbers in few bytes ------------------------------------------------------------------------


BITS = 12
"""Bits that a number keeps after the leading one."""

_LAST = 65534  # the code of a component's largest value; the next one means that there is no state
_NONE = 65535
_LEVEL = 6  # of `deflate`: beyond, a page takes far longer and becomes little smaller


class Packed(NamedTuple):
    """A column packed: its name, its kind (f4, u2, u1, i1), how many values, the text in base64."""

    name: str
    kind: str
    length: int
    text: str

    @property
    def entry(self) -> dict[str, Any]:
        """What a browser must know to unpack it."""
        return {"name": self.name, "kind": self.kind, "length": self.length}


def packed(name: str, values: np.ndarray) -> Packed:
    """Pack a column of float32, int8, uint8 or uint16, of any shape."""
    kind = values.dtype.str.lstrip("|<")
    if kind == "f4":
        values = rounded(values)
    text = base64.b64encode(zlib.compress(_shuffled(values), _LEVEL)).decode()
    return Packed(name, kind, int(values.size), text)


def rounded(values: np.ndarray) -> np.ndarray:
    """Return float32 with `BITS` bits after the leading one, rounded to the nearest."""
    bits = np.ascontiguousarray(values, "<f4").view("<u4")
    drop = 23 - BITS
    with np.errstate(over="ignore"):
        near = (bits + np.uint32(1 << (drop - 1))) >> np.uint32(drop) << np.uint32(drop)
    special = ~np.isfinite(values.ravel())
    found = np.where(special, bits, near).astype("<u4").view("<f4")
    return np.where(np.isnan(found), np.float32(np.nan), found)  # one NaN: it packs best


def coded(states: np.ndarray) -> tuple[np.ndarray, list[list[float]]]:
    """Return states (lanes, points, components) as 16-bit codes, and the range of each component.

    A code c means low + c (high - low) / 65534; 65535 means that there is no state.
    """
    codes = np.full(states.shape, _NONE, "<u2")
    ranges = []
    for i in range(states.shape[-1]):
        values = states[..., i]
        known = np.isfinite(values)
        low, high = (
            (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 1.0)
        )
        size = high - low or 1.0
        places = np.rint((values[known] - low) * (_LAST / size))
        codes[..., i][known] = places.astype("<u2")
        ranges.append([low, low + size])
    return codes, ranges


def _shuffled(values: np.ndarray) -> bytes:
    """Return the first bytes of all values, then the second ones, and so on."""
    flat = np.ascontiguousarray(values).ravel()
    return flat.view(np.uint8).reshape(flat.size, flat.itemsize).T.tobytes()
