"""The layout of a portrait: rows of panels with fixed room for labels, so that nothing collides.

Lengths are in centimetres; the figure is as wide as every picture (16 cm).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.plotting.panels import add_panel, write_letters
from nlds_vines.plotting.style import CM, WIDTH
from nlds_vines.portrait.result import View

LEFT, RIGHT, GAP = 1.45, 1.85, 1.3
"""Room [cm] for the labels on the left, the legends on the right, the ticks between columns."""

HEAD, NAMES, FOOT, SEAM = 0.6, 0.5, 1.05, 0.2
"""Room [cm] for the title, for the names of the columns, below a row that has an axis of its own,
and between two rows that share their axis."""

CROWD = 2
"""The most columns with names of one line and full labels; more have less room for each."""

OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
"""The panels whose horizontal axis is time."""

_TIME, _SPECTRUM = 2.5, 3.4  # cm, heights of a panel over time and of a spectrum
_PLANE, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and in cm at most
_CROWDED = 0.88  # of these heights, where several columns make more rows
_TWO_LINES = 2.2  # height of a name of two lines over that of one


class Place(NamedTuple):
    """A panel on the page: its kind, what it shows, whether it is first or last in its row."""

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool


def rows_of(panels: Sequence[str], views: Sequence[View]) -> list[list[tuple[str, View]]]:
    """Return what stands in each row: one kind of panel for all columns.

    With a single column, two phase planes that follow one another share a row.
    """
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
    """Return a figure and its panels, row by row, with their letters and shared axes."""
    rows = rows_of(panels, views)
    heights = [_height(row) for row in rows]
    feet = [_foot(row, following) for row, following in pairwise([*rows, []])]
    head = HEAD + NAMES * (1 if len(views) <= CROWD else _TWO_LINES)
    tall = head + sum(heights) + sum(feet)
    figure = Figure(figsize=(WIDTH, tall * CM))
    top, places = tall - head, []
    for row, height, foot in zip(rows, heights, feet, strict=True):
        places.append(_make_row(figure, row, top - height, height))
        top -= height + foot
    _share_axes(places)
    write_letters([place.axes for row in places for place in row])
    return figure, places


def _make_row(
    figure: Figure, row: Sequence[tuple[str, View]], bottom: float, height: float
) -> list[Place]:
    """Return the panels of one row, side by side."""
    width, last = _width(len(row)), len(row) - 1
    found = []
    for i, (panel, view) in enumerate(row):
        box = (LEFT + i * (width + GAP), bottom, width, height)
        axes = add_panel(figure, [length * CM for length in box])
        found.append(Place(panel, view, axes, i == 0, i == last))
    return found


def _width(columns: int) -> float:
    """Return the width of each of so many columns."""
    return (WIDTH / CM - LEFT - RIGHT - (columns - 1) * GAP) / columns


def _height(row: Sequence[tuple[str, View]]) -> float:
    """Return the height of a row of panels."""
    panel, view = row[0]
    several = len(row) > 1 and row[1][1] is not view
    if panel.startswith("phase"):
        height = min(_PLANE * _width(len(row)), _TALLEST)
    else:
        height = _SPECTRUM if panel == "spectrum" else _TIME
    return _CROWDED * height if several else height


def _foot(row: Sequence[tuple[str, View]], below: Sequence[tuple[str, View]]) -> float:
    """Return the room below a row: little where the row below it has the same axis of time."""
    joined = below and row[0][0] in OVER_TIME and below[0][0] in OVER_TIME
    return SEAM if joined else FOOT


def _share_axes(places: Sequence[Sequence[Place]]) -> None:
    """Let panels over time share their times, and the panels of a row their values.

    Phase planes share nothing: their axes are as wide as their own orbit.
    """
    for row in places:
        if not row[0].panel.startswith("phase"):
            for place in row[1:]:
                place.axes.sharey(row[0].axes)
    for above, below in pairwise(places):
        if above[0].panel in OVER_TIME and below[0].panel in OVER_TIME:
            for upper, lower in zip(above, below, strict=True):
                lower.axes.sharex(upper.axes)
                upper.axes.tick_params(labelbottom=False)
