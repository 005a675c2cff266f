"""The branches and special points of a continuation, drawn over a map or a diagram in a report.

A diagram shows the displacements or energies along the branches, solid where they are stable, and
the special points by name.  A map shows the curves of special points in its plane or, without
curves, the special points on the line of the continuation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource

from nlds_vines.bifurcation.request import Scan
from nlds_vines.continuation.result import MARKS, WORDS, Branch, Continued, continued
from nlds_vines.errors import RequestError
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.map_view import Places, places_of
from nlds_vines.plotting.style import HUES

_MARKERS = {
    "o": "circle", "^": "triangle", "s": "square", "X": "x", "D": "diamond",
    "v": "inverted_triangle",
}  # fmt: skip
_LOOKS = {kind: (look["color"], _MARKERS[look["marker"]]) for kind, look in MARKS.items()}
_ENERGIES = ("E1max", "E2max")


class Table(NamedTuple):
    """A table of a page: its title, the names of its columns, its rows."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def branches_of(path: Path, scan: Scan) -> Continued:
    """Return the continuation in an archive, to be drawn over the map of a scan.

    Raises `RequestError` for any other file, and if the map does not vary its parameter.
    """
    result = continued(path)
    names, axes = [item.name for item in result.request.free], [a.name for a in scan.axes]
    if not set(names) & set(axes):
        raise RequestError(
            f"{path} continues along {', '.join(names)}, the map varies {', '.join(axes)}: "
            "the branches do not lie in the map"
        )
    if result.request.system.kind != scan.system.kind:
        raise RequestError(
            f"{path} continues kind {result.request.system.kind!r}, the map is of kind "
            f"{scan.system.kind!r}"
        )
    return result


def special_table(result: Continued, results: Stored) -> Table:
    """Return the table of the special points and of the meetings of their curves."""
    rows: list[tuple[str, ...]] = []
    (name, one), *others = (results.shown(item.name) for item in result.request.free)
    for row in result.special_points:
        change = f"{row.before} → {row.after}" if row.before != row.after else str(row.before)
        rows.append((str(row.kind), f"{name} = {row.value / one:.8g}", change))
    for curve in result.curves:
        for kind, first, second in curve.meetings:
            (across, two), *_ = others
            place = f"{name} = {first / one:.6g}, {across} = {second / two:.6g}"
            rows.append((kind, place, f"on the curve of {curve.kind}, {curve.period}T"))
    head = "kind", "at", "regime along the branch"
    return Table("Special points of the branches", head, rows)


def words_of_kinds(result: Continued) -> str:
    """Return the kinds of the special points in words: `LP fold, PD period doubling`."""
    kinds = {*map(str, result.special_points.kind), *(curve.kind for curve in result.curves)}
    return ", ".join(f"{kind} {words}" for kind, words in WORDS.items() if kind in kinds)


def draw_branches(figure: Any, result: Continued, results: Stored) -> dict[str, list[Any]]:
    """Draw a continuation over the figure of a map or a diagram.

    Returns the renderers by the name of the quantity that the diagram shows with them; under "" the
    renderers that are always visible.
    """
    components, special = results.scan.system.scene.components, result.special_points
    places, along = places_of(results), result.request.along.name
    if len(places) == 1:
        shows = [show for show in ("x2", "x1", "x") if show in components]
        return {
            show: _draw_values(figure, result, show, places[0]) for show in (*shows, *_ENERGIES)
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
        raise RequestError(
            f"the curves lie in the plane of {', '.join(names)}, the map in that of "
            f"{', '.join(axes)}"
        )
    order, drawn = [names.index(name) for name in axes], []
    for curve in result.curves:
        shade, _ = _LOOKS.get(curve.kind, (HUES["black"], "circle"))
        at = [one.of(curve.values[:, k]) for one, k in zip(places, order, strict=True)]
        for width, color in ((4.5, "#ffffff"), (2.2, shade)):  # seen on any color
            look = {"line_color": color, "line_width": width, "legend_label": curve.kind}
            drawn.append(figure.line(*at, **look))
        for name, *values in curve.meetings:
            at = [one.of([values[k]]) for one, k in zip(places, order, strict=True)]
            drawn += _mark(figure, [name], *at)
    return {"": drawn}


def _draw_values(figure: Any, result: Continued, show: str, places: Places) -> list[Any]:
    """Draw a quantity of all branches over their parameter, solid where they are stable."""
    components = result.request.system.scene.components

    def values(branch: Branch) -> np.ndarray:
        """Return the quantity along a branch, shape (periods, points)."""
        if show in _ENERGIES:
            return np.atleast_2d(branch.E1max if show == "E1max" else branch.E2max)
        return branch.sections[:, :, components.index(show)].T

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
        color = HUES["vermillion"]
        drawn.append(figure.multi_line(xs, ys, line_width=1.6, line_dash=dash, line_color=color))
    rows = [
        row for row in result.special_points if row.index + 1 < len(result.branches[row.branch])
    ]
    kinds, x = [row.kind for row in rows], places.of([row.value for row in rows])
    y = [values(result.branches[row.branch])[-1][row.index : row.index + 2].mean() for row in rows]
    return drawn + _mark(figure, kinds, x, y)


def _mark(figure: Any, kinds: Iterable[Any], x: Iterable[float], y: Iterable[float]) -> list[Any]:
    """Mark special points (x, y) by the marker and the name of their kind."""
    kinds = [*map(str, kinds)]
    looks = [_LOOKS.get(kind, (HUES["black"], "circle")) for kind in kinds]
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
