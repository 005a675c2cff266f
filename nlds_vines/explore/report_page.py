"""A map as one page (.html) that needs no server: figures, numbers, words, a script, branches.

Over a diagram lie displacements or energies along the branches of a continuation, solid where they
are stable; over a map curves of special points or, without curves, the special points.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.events import DocumentReady
from bokeh.layouts import row as beside
from bokeh.models import ColumnDataSource, CustomJS, Select
from bokeh.resources import Resources

import nlds_vines as nv
from nlds_vines.explore import figures, map_view
from nlds_vines.explore.map_data import Curve, Stored
from nlds_vines.explore.sent_page import special_points

MOST_BYTES = 5_000_000  # the most bytes of a page, which a mail takes

POINTS = (1000, 240, 120, 48, 24, 12, 6, 3, 1)  # states of each section: the most that fit
MOST_DOTS = 100_000  # the most dots of a diagram that a browser draws at once
BITS = 12  # bits of a number after the leading one
_LAST, _NONE = 65534, 65535  # codes of the largest value of a component, and of no state
_SECTION_SHARE = 0.4  # of the room, for sections before numbers
_PROVENANCE = (
    ("source", "made by"), ("commit", "commit"), ("scan_hash", "hash"), ("system", "system"),
    ("kind", "kind"), ("python_version", "Python"), ("numba_version", "Numba"),
    ("numpy_version", "NumPy"),
)  # fmt: skip
_POLICY = (
    '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; script-src '
    "'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:\">"
)


class Report(NamedTuple):
    """A page, and in words what its size left no room for."""

    html: str
    left_out: str

    @property
    def size(self) -> int:
        return len(self.html.encode())


class Section(NamedTuple):
    """The last states of all sections as codes (orbits, points, components): low + code step."""

    codes: np.ndarray
    low: np.ndarray
    step: np.ndarray


def report_page(
    results: Stored, branches: nv.Continued | None = None, tables: Sequence[Table] = ()
) -> Report:
    """Return the page of a map, with as many states and numbers as `MOST_BYTES` allow."""
    special = [] if branches is None else [special_table(branches, results)]
    tables = [table for table in (*special, *tables) if table.rows]
    empty = Section(np.empty((results.scan.lanes, 0, 0), "<u2"), np.empty(0), np.empty(0))
    bare = _page(results, branches, tables, empty, [])
    room = MOST_BYTES - bare.size
    numbers = {
        name: _bytes(rounded(map_view.column(results, name))) * 3 // 2 for name in results.numbers
    }
    section, for_section = empty, max(room - sum(numbers.values()), int(_SECTION_SHARE * room))
    most = MOST_DOTS // results.scan.lanes if len(results.scan.axes) == 1 else POINTS[0]
    states = section_points(results)
    every = coded(states) if states.size else empty
    for count in POINTS:
        codes = every.codes[:, -min(count, max(1, most)) :]
        if codes.size < 50 * max(for_section, 0) and _bytes(codes) <= for_section:
            section = every._replace(codes=codes)
            break
    room -= _bytes(section.codes)
    names = []
    for name, size in numbers.items():
        if size * (1.1 if len(results.scan.axes) == 2 else 1) <= room:
            names.append(name)
            room -= size
    return _page(results, branches, tables, section, names)


def _bytes(values: np.ndarray) -> int:
    """Return the bytes of an array on a page: compressed, and in base64."""
    return len(gzip.compress(np.ascontiguousarray(values).tobytes(), 6)) * 4 // 3 + 200


def section_points(results: Stored) -> np.ndarray:
    """Return the states of each section, or else the points of the periodic orbits, if any.

    They have the displacement and the rate of each curve with a phase plane.
    """
    if "section" in results:
        states = results.lanes("section")
    elif "orbit_point" in results:
        states = results.lanes("orbit_point")[:, :, np.newaxis]
    else:
        return np.empty((0, 0, 0))
    parts = [curve.of(states, part) for curve in results.planes for part in (0, 1)]
    values = np.stack(parts, axis=-1)
    return values.reshape(-1, *values.shape[2:])


def rounded(values: np.ndarray) -> np.ndarray:
    """Return float32 rounded to `BITS` bits after the leading one."""
    bits = np.ascontiguousarray(values, "<f4").view("<u4")
    drop = 23 - BITS
    with np.errstate(over="ignore"):
        near = (bits + np.uint32(1 << (drop - 1))) >> np.uint32(drop) << np.uint32(drop)
    result = np.where(np.isfinite(values), near, bits).astype("<u4").view("<f4")
    return np.where(np.isnan(result), np.float32(np.nan), result)  # equal NaN compress best


def coded(states: np.ndarray) -> Section:
    """Return states as 16-bit codes, `_NONE` for states that are not finite."""
    finite = np.isfinite(states)
    low = np.where(finite, states, np.inf).min(axis=(0, 1))
    high = np.where(finite, states, -np.inf).max(axis=(0, 1))
    low, high = np.where(low <= high, low, 0.0), np.where(low <= high, high, 1.0)
    step = np.where(high > low, high - low, 1.0) / _LAST
    codes = np.rint((np.where(finite, states, low) - low) / step)
    return Section(np.where(finite, codes, _NONE).astype("<u2"), low, step)


# ---- the page ------------------------------------------------------------------------------------


def _page(
    results: Stored, branches: nv.Continued | None, tables: Sequence[Table], section: Section,
    names: Sequence[str],
) -> Report:  # fmt: skip
    points = section.codes.shape[1]
    components = [name for curve in results.planes for name in curve.names]
    shows = [
        show for show in map_view.shows_of(results)
        if (points and show.name in components if show.points else show.column in names)
        or (show.classes and show.column != "computed")
    ] or [map_view.STATUS_SHOW]  # fmt: skip
    document, figure = Document(), figures.MapFigure(results, False)
    figure.show_axes(map_view.places_of(results))
    figure.put_strip(results)
    arguments = _arguments(results, figure, shows, section, names)
    lines = {} if branches is None else draw_branches(figure.main, branches, results)
    source, planes = ColumnDataSource({name: [] for name in components}, name="section"), []
    spans = section.step * _LAST / 10 if points else np.ones(len(components))
    for i, curve in enumerate(results.planes):
        x, v = curve.names
        plane = figures.phase_plane(f"plane {x}", 250, curve.symbols)
        plane.scatter(x, v, source=source, size=6, line_color=None, fill_color=figures.WALL)
        for one, span in zip((plane.x_range, plane.y_range), spans[2 * i : 2 * i + 2], strict=True):
            one.default_span, one.range_padding = float(span), 0.2  # around a single point
        planes.append(plane)
    show = Select(title="show", value=shows[0].name, width=260, **figures.LOOK)
    show.options = [(one.name, one.title) for one in shows]
    start = Select(title="start", value="0", visible=len(results.starts) > 1, **figures.LOOK)
    start.options = [(str(k), name) for k, name in enumerate(results.starts)]
    verdict, tip = figures.text("verdict"), figures.text("tip", visible=False)
    key, legend = figures.text(visible=False), figures.text("legend")
    described = figures.text("unseen")
    hints = ["Click a cell or use the arrow keys, with Shift ten cells further."]
    if branches is not None:
        hints.append("Lines: branches of a continuation, dashed if they are unstable.")
        kinds = {
            *map(str, branches.special_points.kind),
            *(curve.kind for curve in branches.curves),
        }
        if marks := [f"{kind} {words}" for kind, words in branches.kinds.items() if kind in kinds]:
            hints.append(f"Marks: special points, {', '.join(marks)}.")
    parts = {
        "map": [
            beside(show, start, figures.theme_button(), **figures.WIDE), *figure.figures[:-1], tip,
            figure.main, described,
            legend, figures.text("hint", text=" ".join(hints)), key,
        ],
        "orbit": [verdict, *(planes if points else [])],
    }  # fmt: skip
    arguments |= {
        "show": show, "start": start, "legend": legend, "verdict": verdict, "tip": tip, "key": key,
        "described": described,
        "branches": lines, "section": source,
    }  # fmt: skip
    missing = []
    if "section" in results and points < results.scan.periods:
        missing.append(f"{points} of the {results.scan.periods} recorded states of each section")
    if numbers := [name for name in results.numbers if name not in names]:
        missing.append(f"not {', '.join(numbers)}")
    left_out = "Numbers are rounded to about four digits"
    left_out += f"; this page holds {'; '.join(missing)}." if missing else "."
    below = "".join(map(_table, tables)) + _provenance(results, left_out)
    figures.frame(document, results.scan.title, parts, policy=_POLICY, more=below)
    keys = CustomJS(args={"target": key}, code=figures.page_file("keys.js"))
    act = CustomJS(args=arguments, code=figures.page_file("report.js"))
    document.js_on_event(DocumentReady, keys, act)
    html = file_html(
        document, Resources(mode="inline"),
        title=results.scan.title, template=document.template,
        template_variables=document.template_variables,
    )  # fmt: skip
    return Report(html, left_out)


def _arguments(
    results: Stored,
    figure: figures.MapFigure,
    shows: Sequence[map_view.Show],
    section: Section,
    names: Sequence[str],
) -> dict[str, Any]:
    is_map, count = figure.is_map, len(results.starts)
    components = [name for curve in results.planes for name in curve.names]
    columns = {name: rounded(map_view.column(results, name)).ravel() for name in names}
    if "multipliers" in results:
        columns["multiplier"] = rounded(map_view.column(results, "multiplier")).ravel()
    labels: list[str] = []
    if "label" in results:
        labels, codes, _ = map_view.label_codes(results)
        columns["label"] = codes.ravel()
    if shows[0] == map_view.STATUS_SHOW and not is_map:
        columns["status"] = map_view.column(results, "computed").ravel()
    images: dict[str, list[np.ndarray]] = {}
    entries = []
    for show in shows:
        each = show.of_start and count > 1
        label = map_view.in_brackets(show.title, show.unit)
        entry: dict[str, Any] = {"name": show.name, "each": each and is_map, "label": label}
        if is_map:
            pictures = [map_view.painted(results, show, k) for k in range(count if each else 1)]
            for k, picture in enumerate(pictures):
                images[f"{show.name}:{k}" if each else show.name] = [picture.codes]
            entry["legends"] = [picture.legend for picture in pictures]
            entry["palette"] = pictures[0].palette
            figure.put(pictures[0])
            entry["hatch"] = [figure.hatched(picture) for picture in pictures]
        else:
            figure.show_values(map_view.diagram_values(results, show), "")
            entry["span"] = [figure.main.y_range.start, figure.main.y_range.end]
            entry["component"] = components.index(show.name) if show.points else -1
            entry["legends"] = [
                map_view.painted_diagram(results, show, (0, 1, 0, 1), (1, 1)).legend
            ]
        is_by_start = show.of_start or not is_map
        entry["described"] = [
            map_view.picture_in_words(results, show, k) for k in range(count if is_by_start else 1)
        ]
        entries.append(entry)
    dots = []
    for color in () if is_map else map_view.diagram_colors(results):
        dots.append(ColumnDataSource({"x": [], "y": []}))
        glyphs = figure.main.scatter(
            "x", "y", source=dots[-1], size=2, line_color=None, fill_color=color
        )
        glyphs.nonselection_glyph = None
    first, *second = figure.places
    _, points, parts = section.codes.shape
    return {
        "shows": entries, "images": ColumnDataSource(images), "columns": ColumnDataSource(columns),
        "labels": labels, "numbers": map_view.numbers_of(results),
        "names": [*results.starts], "starts": count,
        "codes": section.codes.ravel(), "points": points, "parts": parts,
        "low": section.low.tolist(), "step": section.step.tolist(), "components": components,
        "first": first.at.tolist(), "second": second[0].at.tolist() if second else [0.0],
        "places": [map_view.values_in_words(one.axis) for one in figure.places],
        "box": [*figure.box()] if is_map else [first.low, first.high, 0, 0],
        "lines": figure.lines, "homes": figure.figures, "dots": dots,
        "picture": figure.picture.source, "mapper": figure.picture.mapper, "hatch": figure.hatch,
        "mark": figure.mark,
        "span": figure.main.y_range, "ordinate": figure.main.yaxis[0],
    }  # fmt: skip


def _table(table: Table) -> str:
    def row(cells: Iterable[str], tag: str) -> str:
        return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"

    rows = "".join(row(cells, "td") for cells in table.rows)
    body = f"<thead>{row(table.head, 'th')}</thead><tbody>{rows}</tbody>"
    return f'<section class="full"><h2>{escape(table.title)}</h2><table>{body}</table></section>'


def _provenance(results: Stored, left_out: str) -> str:
    rows = [] if results.path is None else [("archive", results.path.name)]
    rows += [(words, str(results.about[key])) for key, words in _PROVENANCE if key in results.about]
    cells = (f"<tr><th>{escape(one)}</th><td>{escape(value)}</td></tr>" for one, value in rows)
    request = escape(results.scan.to_toml())
    return (
        '<section class="full"><h2>Where this comes from</h2><table>'
        f"{''.join(cells)}</table><p>{escape(left_out)}</p><details><summary>The request (TOML)"
        f"</summary><pre>{request}</pre></details></section>"
    )


# ---- branches --------------------------------------------------------------------------------


_MARKERS = {
    "o": "circle", "^": "triangle", "s": "square", "X": "x", "D": "diamond",
    "v": "inverted_triangle", "*": "star",
}  # fmt: skip
_OTHER = "#000000", "circle"  # the color and the marker of a kind that has none
_ENERGIES = ("E1max", "E2max")


def _look_of(kind: str) -> tuple[str, str]:
    """Return the color and the marker of a kind of special points."""
    look = nv.Continued.marks.get(kind)
    return _OTHER if look is None else (look["color"], _MARKERS[look["marker"]])


class Table(NamedTuple):
    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def branches_of(path: Path, scan: nv.Scan) -> nv.Continued:
    """Return the continuation in an archive; `RequestError` if it does not lie in a scan's map."""
    result = nv.open_archive(path)
    if not isinstance(result, nv.Continued):
        with nv.read(path) as view:
            raise nv.RequestError(f"{path} holds a {view.content}, not a continuation")
    names, axes = [item.name for item in result.request.free], [a.name for a in scan.axes]
    if not set(names) & set(axes):
        raise nv.RequestError(
            f"{path} continues along {', '.join(names)}, the map varies {', '.join(axes)}: "
            "the branches do not lie in the map"
        )
    if result.request.system.kind != scan.system.kind:
        raise nv.RequestError(
            f"{path} continues kind {result.request.system.kind!r}, the map is of kind "
            f"{scan.system.kind!r}"
        )
    return result


def special_table(result: nv.Continued, results: Stored) -> Table:
    head, *rows = special_points(result, results.shown)
    return Table("Special points of the branches", head, rows)


def draw_branches(figure: Any, result: nv.Continued, results: Stored) -> dict[str, list[Any]]:
    """Draw a continuation; return its renderers by the quantity they belong to, "" for always."""
    special = result.special_points
    places, along = map_view.places_of(results), result.request.along.name
    if len(places) == 1:
        shows = {curve.names[0]: curve for curve in results.planes}
        return {
            show: _draw_values(figure, result, show, shows.get(show), places[0])
            for show in (*shows, *_ENERGIES)
        }
    axes = [axis.name for axis in results.scan.axes]
    if not result.curves:
        # the special points stand on the line of the map along which the branches were continued
        fixed = result.request.system.parameters
        at = [
            one.of(special.value if name == along else np.full(len(special), fixed[name]))
            for one, name in zip(places, axes, strict=True)
        ]
        return {"": _mark(figure, special.kind, *at)}
    names = [item.name for item in result.request.free]
    if sorted(names) != sorted(axes):
        raise nv.RequestError(
            f"the curves lie in the plane of {', '.join(names)}, the map in that of "
            f"{', '.join(axes)}"
        )
    order, drawn = [names.index(name) for name in axes], []
    for curve in result.curves:
        shade, _ = _look_of(curve.kind)
        at = [one.of(curve.values[:, k]) for one, k in zip(places, order, strict=True)]
        for width, color in ((4.5, "#ffffff"), (2.2, shade)):  # seen on any color
            look = {"line_color": color, "line_width": width, "legend_label": curve.kind}
            drawn.append(figure.line(*at, **look))
        for name, *values in curve.meetings:
            at = [one.of([values[k]]) for one, k in zip(places, order, strict=True)]
            drawn += _mark(figure, [name], *at)
    return {"": drawn}


def _draw_values(
    figure: Any, result: nv.Continued, energy: str, curve: Curve | None, places: map_view.Places
) -> list[Any]:
    """Draw a curve, or else an energy, of all branches; solid where they are stable."""

    def values(branch: Any) -> np.ndarray:
        """Return the quantity along a branch, shape (periods, points)."""
        if curve is None:
            return np.atleast_2d(getattr(branch, energy))
        return curve.of(branch.sections).T

    drawn = []
    for stable, dash in ((True, "solid"), (False, (5, 3))):
        xs, ys = [], []
        for branch in result.branches:
            at, is_drawn = places.of(branch.parameter), branch.stable == stable
            edges = np.flatnonzero(np.diff(is_drawn.astype(int), prepend=0, append=0))
            for one in values(branch):
                for first, stop in zip(edges[::2], edges[1::2], strict=True):
                    xs.append(at[first : stop + 1])  # so that the lines meet
                    ys.append(one[first : stop + 1])
        color = figures.WALL
        drawn.append(figure.multi_line(xs, ys, line_width=1.6, line_dash=dash, line_color=color))
    rows = [
        row for row in result.special_points if row.index + 1 < len(result.branches[row.branch])
    ]
    kinds, x, y = list[str](), list[float](), list[float]()
    for row, place in zip(rows, places.of([row.value for row in rows]), strict=True):
        for one in values(result.branches[row.branch]):
            kinds.append(row.kind)
            x.append(place)
            y.append(one[row.index : row.index + 2].mean())
    return drawn + _mark(figure, kinds, x, y)


def _mark(figure: Any, kinds: Iterable[Any], x: Iterable[float], y: Iterable[float]) -> list[Any]:
    """Mark special points (x, y) by the marker and the name of their kind."""
    kinds = [*map(str, kinds)]
    looks = [_look_of(kind) for kind in kinds]
    shades, markers = zip(*looks, strict=True) if looks else ((), ())
    source = ColumnDataSource(
        {"x": [*x], "y": [*y], "name": kinds, "shade": shades, "marker": markers}
    )
    dots = figure.scatter(
        "x", "y", marker="marker", size=9, fill_color="shade", line_color="#ffffff", source=source
    )
    words = figure.text(
        "x", "y", text="name", x_offset=6, y_offset=-4, source=source, text_color="#000000",
        text_font_size="11px", text_font_style="bold", background_fill_color="#ffffff",
        background_fill_alpha=0.8, padding=2,  # read on any color
    )  # fmt: skip
    return [dots, words]
