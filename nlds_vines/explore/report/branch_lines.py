"""Branches and special points of a continuation, as lines over a map or a diagram.

Over a diagram along the parameter of the branches: their displacements or energies, full where they
are stable; special points by name.  Over a map: the curves of special points in its plane; without
curves, the special points on the line of the continuation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource

from nlds_vines.continuation.result import MARKS, WORDS, Branch, Continued, continued
from nlds_vines.errors import RequestError
from nlds_vines.explore.map_data import Stored
from nlds_vines.plotting.style import GRAY, HUES

_MARKERS = {"o": "circle", "^": "triangle", "s": "square", "X": "x", "D": "diamond"}
_MARKERS["v"] = "inverted_triangle"

KINDS = {kind: (look["color"], _MARKERS[look["marker"]]) for kind, look in MARKS.items()}
"""Color and marker of each kind of special point: those of pictures."""

ENERGIES = ("E1max", "E2max")


class Table(NamedTuple):
    """A table of a page: title, names of the columns, rows of as many words."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def branches_of(path: Path, found: Stored) -> Continued:
    """Return the continuation in an archive that belongs to a map.

    Raises `RequestError` for any other file, and where its parameter is no axis of the map.
    """
    result = continued(path)
    names, axes = [item.name for item in result.request.free], [a.name for a in found.scan.axes]
    if not set(names) & set(axes):
        raise RequestError(
            f"{path} continues along {', '.join(names)}, the map varies {', '.join(axes)}: "
            "no line of the one lies in the other"
        )
    if result.request.system.kind != found.scan.system.kind:
        raise RequestError(
            f"{path} continues kind {result.request.system.kind!r}, the map is of kind "
            f"{found.scan.system.kind!r}"
        )
    return result


def special_table(result: Continued) -> Table:
    """Return the special points in words, and where curves meet."""
    name = result.request.along.name
    rows: list[tuple[str, ...]] = []
    for row in result.special_points:
        change = f"{row.before} → {row.after}" if row.before != row.after else str(row.before)
        rows.append((str(row.kind), f"{name} = {row.value:.8g}", change))
    names = [item.name for item in result.request.free]
    for curve in result.curves:
        for kind, first, second in curve.meetings:
            place = f"{names[0]} = {first:.6g}, {names[1]} = {second:.6g}"
            rows.append((kind, place, f"on the curve of {curve.kind}, {curve.period}T"))
    head = "kind", "at", "regime along the branch"
    return Table("Special points of the branches", head, rows)


def words_of_kinds(result: Continued) -> str:
    """Return the kinds of special points that there are: `LP fold, PD period doubling`."""
    kinds = {*map(str, result.special_points.kind), *(curve.kind for curve in result.curves)}
    return ", ".join(f"{kind} {words}" for kind, words in WORDS.items() if kind in kinds)


def draw_branches(figure: Any, result: Continued, found: Stored) -> dict[str, list[Any]]:
    """Draw a continuation over the figure of a map or a diagram.

    Returns what belongs to each number that a diagram shows; under "" what is always seen.
    """
    if len(found.scan.axes) == 1:
        components = found.scan.system.scene.components
        shows = [show for show in ("x2", "x1", "x") if show in components]
        return {show: _draw_values(figure, result, show) for show in (*shows, *ENERGIES)}
    if result.curves:
        return {"": _draw_curves(figure, result, [axis.name for axis in found.scan.axes])}
    return {"": _draw_points(figure, result, found)}


def _draw_values(figure: Any, result: Continued, show: str) -> list[Any]:
    """Draw the values of all branches over their parameter, full where they are stable."""
    components = result.request.system.scene.components

    def values(branch: Branch) -> np.ndarray:
        if show in ENERGIES:
            return branch.E1max if show == "E1max" else branch.E2max
        return branch.sections[:, :, components.index(show)]

    drawn = []
    for stable, dash in ((True, "solid"), (False, (5, 3))):
        xs, ys = [], []
        for branch in result.branches:
            for one in np.atleast_2d(values(branch).T):
                for part in _runs(branch.stable == stable):
                    xs.append(branch.parameter[part])
                    ys.append(one[part])
        color = HUES["vermillion"]
        drawn.append(figure.multi_line(xs, ys, line_width=1.6, line_dash=dash, line_color=color))
    rows = [
        row for row in result.special_points if row.index + 1 < len(result.branches[row.branch])
    ]
    at = [_at(values(result.branches[row.branch]), int(row.index)) for row in rows]
    return drawn + _mark(figure, [r.kind for r in rows], [r.value for r in rows], at)


def _at(values: np.ndarray, index: int) -> float:
    """Return a value half-way between two points of a branch: the last of each period."""
    last = values if values.ndim == 1 else values[:, -1]
    return float((last[index] + last[index + 1]) / 2)


def _runs(chosen: np.ndarray) -> Iterator[slice]:
    """Yield the runs of chosen points, each with the point after it, so that lines meet."""
    edges = np.flatnonzero(np.diff(chosen.astype(int), prepend=0, append=0))
    for first, stop in pairwise(edges):
        if chosen[first]:
            yield slice(int(first), int(stop) + 1)


def _draw_curves(figure: Any, result: Continued, axes: list[str]) -> list[Any]:
    """Draw the curves of special points in the plane of the map."""
    names = [item.name for item in result.request.free]
    if sorted(names) != sorted(axes):
        raise RequestError(
            f"the curves lie in the plane of {', '.join(names)}, the map in that of "
            f"{', '.join(axes)}"
        )
    first, second = (names.index(name) for name in axes)
    drawn = []
    for curve in result.curves:
        shade, _ = KINDS.get(curve.kind, (HUES["black"], "circle"))
        for width, color in ((4.5, "#ffffff"), (2.2, shade)):  # seen on any color
            drawn.append(
                figure.line(
                    curve.values[:, first], curve.values[:, second], line_color=color,
                    line_width=width, legend_label=curve.kind,
                )
            )  # fmt: skip
        for name, *place in curve.meetings:
            drawn += _mark(figure, [name], [place[first]], [place[second]])
    return drawn


def _draw_points(figure: Any, result: Continued, found: Stored) -> list[Any]:
    """Draw the special points of branches on the line of the map along which they were found."""
    axes, name = [axis.name for axis in found.scan.axes], result.request.along.name
    other = next(axis for axis in axes if axis != name)
    across = float(result.request.system.parameters[other])
    values = [float(value) for value in result.special_points.value]
    places = [values, [across] * len(values)]
    first, second = places if axes[0] == name else places[::-1]
    return _mark(figure, list(result.special_points.kind), first, second)


def _mark(figure: Any, kinds: list[Any], x: list[Any], y: list[Any]) -> list[Any]:
    """Mark special points by the marker and the name of their kind."""
    look = [KINDS.get(str(kind), (HUES["black"], "circle")) for kind in kinds]
    source = ColumnDataSource(
        {
            "x": x, "y": y, "name": [str(kind) for kind in kinds],
            "shade": [shade for shade, _ in look], "marker": [marker for _, marker in look],
        }
    )  # fmt: skip
    dots = figure.scatter(
        "x", "y", marker="marker", size=9, fill_color="shade", line_color="#ffffff", source=source
    )
    words = figure.text(
        "x", "y", text="name", x_offset=6, y_offset=-4, source=source, text_color=GRAY,
        text_font_size="11px", text_font_style="bold",
    )  # fmt: skip
    return [dots, words]
