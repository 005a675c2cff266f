"""The layout of a portrait: rows of panels with fixed room for labels, so that nothing collides.

Lengths are in centimetres; figures are as wide as every picture (16 cm).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.plotting.style import CM, WIDTH
from nlds_vines.portrait.result import View

LEFT, RIGHT, GAP = 1.45, 1.85, 1.3
"""Room for the labels on the left, the legends on the right, the ticks between two columns."""

HEAD, NAMES, FOOT, SEAM = 0.6, 0.5, 1.05, 0.2
"""Room for the title, for the names of the columns, below a row that has an axis of its own, and
between two rows that share it."""

CROWD = 2
"""Columns beyond which their names need two lines, and labels have to be short."""

OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
"""The panels over time."""

_TIME, _SPECTRUM = 2.5, 3.4  # heights
_FLATTEST, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and at most
_CROWDED = 0.88  # of these, where several columns make more rows


class Place(NamedTuple):
    """A panel on the page: which, of what, and whether it stands first or last in its row."""

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool


def rows_of(panels: Sequence[str], views: Sequence[View]) -> list[list[tuple[str, View]]]:
    """Return what stands in each row: one panel of all columns; of one column two phase planes."""
    if len(views) > 1:
        return [[(panel, view) for view in views] for panel in panels]
    rows: list[list[tuple[str, View]]] = []
    for panel in panels:
        phase = panel.startswith("phase")
        if phase and rows and rows[-1][0][0].startswith("phase") and len(rows[-1]) < 2:
            rows[-1].append((panel, views[0]))
        else:
            rows.append([(panel, views[0])])
    return rows


def make_page(panels: Sequence[str], views: Sequence[View]) -> tuple[Figure, list[list[Place]]]:
    """Return a figure and its panels, row by row, with their letters."""
    rows = rows_of(panels, views)
    heights = [_height(row) for row in rows]
    feet = [_foot(row, following) for row, following in pairwise([*rows, []])]
    head = HEAD + (NAMES if len(views) <= CROWD else 2.2 * NAMES)
    tall = head + sum(heights) + sum(feet)
    figure = Figure(figsize=(WIDTH, tall * CM))
    top, places = tall - head, []
    for row, height, foot in zip(rows, heights, feet, strict=True):
        places.append(_row(figure, row, top - height, height, tall))
        top -= height + foot
    _share(places)
    _letters(places)
    return figure, places


def _row(
    figure: Figure, row: Sequence[tuple[str, View]], bottom: float, height: float, tall: float
) -> list[Place]:
    """Return the panels of one row, side by side."""
    wide, width = WIDTH / CM, _width(len(row))
    found = []
    for i, (panel, view) in enumerate(row):
        left = LEFT + i * (width + GAP)
        box = (left / wide, bottom / tall, width / wide, height / tall)
        found.append(Place(panel, view, figure.add_axes(box), i == 0, i == len(row) - 1))
    return found


def _width(columns: int) -> float:
    return (WIDTH / CM - LEFT - RIGHT - (columns - 1) * GAP) / columns


def _height(row: Sequence[tuple[str, View]]) -> float:
    panel, view = row[0]
    several = len(row) > 1 and row[1][1] is not view
    if panel.startswith("phase"):
        height = min(_FLATTEST * _width(len(row)), _TALLEST)
    else:
        height = _SPECTRUM if panel == "spectrum" else _TIME
    return _CROWDED * height if several else height


def _foot(row: Sequence[tuple[str, View]], below: Sequence[tuple[str, View]]) -> float:
    joined = below and row[0][0] in OVER_TIME and below[0][0] in OVER_TIME
    return SEAM if joined else FOOT


def _share(places: Sequence[Sequence[Place]]) -> None:
    """Let the panels over time share their times, and all but phase planes their values."""
    for row in places:
        if not row[0].panel.startswith("phase"):
            for place in row[1:]:
                place.axes.sharey(row[0].axes)
    for above, below in pairwise(places):
        if above[0].panel in OVER_TIME and below[0].panel in OVER_TIME:
            for upper, lower in zip(above, below, strict=True):
                lower.axes.sharex(upper.axes)
                upper.axes.tick_params(labelbottom=False)


def _letters(places: Sequence[Sequence[Place]]) -> None:
    """Write (a), (b) ... into the corners of the panels; none where there is only one."""
    flat = [place for row in places for place in row]
    if len(flat) < 2:
        return
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    for i, place in enumerate(flat):
        letter = f"({chr(ord('a') + i % 26) * (1 + i // 26)})"
        place.axes.annotate(letter, (0, 1), (4, -4), va="top", bbox=paper, zorder=9, **look)
