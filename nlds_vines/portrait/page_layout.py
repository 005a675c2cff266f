"""The layout of a portrait: rows of panels with fixed room for labels, so that nothing collides.

Lengths are in centimeters.  In one column of a paper nothing stands side by side: the columns of
the page follow one below the other, each with its heading.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.plotting.page import TWO_COLUMNS, Page, letter
from nlds_vines.plotting.panels import add_panel
from nlds_vines.plotting.style import CM
from nlds_vines.portrait.request import PLANES
from nlds_vines.portrait.window_view import View

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
_OWN_SCALE = 5.0  # ratio of two ranges of force beyond which the smaller would be hard to read
_LETTER = 5  # points between the corner of a panel and its letter
_LETTER_BOX = 0.32, 0.26  # inches, room that a letter takes in its corner
_LINES = {1: 1.0, 2: 2.2, 3: 3.3}  # height of a name of so many lines over that of one


class Place(NamedTuple):
    """A panel on the page: its kind, what it shows, whether it is first or last in its row.

    `alone` tells that it has a heading and scales of its own.
    """

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool
    alone: bool = False


Row = Sequence[tuple[str, View]]
"""What stands in a row, from left to right: kinds of panels, and what each of them shows."""


def rows_of(
    panels: Sequence[str], views: Sequence[View], beside: bool = True
) -> list[list[tuple[str, View]]]:
    """Return what stands in each row: one kind of panel for all columns.

    Of several columns, panels that only one of them fills stand side by side, as many as there are
    columns.  With a single column, two planes that follow one another share a row.  Where nothing
    stands `beside` anything, each panel has a row, column after column.
    """
    if not beside:
        return [[(panel, v)] for v in views for panel in panels if v.column.fills(panel)]
    rows: list[list[tuple[str, View]]] = []
    for panel in panels:
        filling = [view for view in views if view.column.fills(panel)]
        entries = [(panel, view) for view in (views if len(filling) > 1 else filling)]
        if rows and _joins(rows[-1], entries, views):
            rows[-1].extend(entries)
        else:
            rows.append(entries)
    return rows


def _joins(row: Row, entries: Row, views: Sequence[View]) -> bool:
    """Return whether a panel, `entries`, stands in the same row as the one before it."""
    if len(views) > 1:
        return len(entries) == 1 and _mixed([*row, *entries]) and len(row) < len(views)
    planes = all(panel in PLANES for panel, _ in (*row, *entries))
    return planes and len(row) < 2


def _mixed(row: Row) -> bool:
    """Return whether the panels of a row are all of different kinds."""
    kinds = [panel for panel, _ in row]
    return len(set(kinds)) == len(kinds)


def make_page(
    panels: Sequence[str], views: Sequence[View], page: Page = TWO_COLUMNS
) -> tuple[Figure, list[list[Place]]]:
    """Return a figure and its panels, row by row, with their letters and shared axes."""
    rows, columns = rows_of(panels, views, page.beside), max(len(views), 1) if page.beside else 1
    headed = [len(views) > 1 and _mixed(row) for row in rows]
    if not page.beside:
        headed = [len(views) > 1 and _begins(row, above) for above, row in pairwise([[], *rows])]
    heights = [_height(row, _width(len(row), page)) for row in rows]
    feet = [_foot(row, following) for row, following in pairwise([*rows, []])]
    head = HEAD + NAMES * (_lines_of_names(views) if page.beside else 1.0)
    names = [NAMES if i and own else 0.0 for i, own in enumerate(headed)]
    tall = head + sum(heights) + sum(feet) + sum(names)
    figure = Figure(figsize=(page.width, tall * CM))
    top, places = tall - head, []
    for i, row in enumerate(rows):
        bottom = top - names[i] - heights[i]
        width = _width(max(columns, len(row)), page)
        places.append(_make_row(figure, row, (bottom, width, heights[i]), headed[i]))
        top = bottom - feet[i]
    _share_axes(places)
    return figure, places


def _begins(row: Row, above: Row) -> bool:
    """Return whether a row shows another window than the one above it."""
    return not above or above[0][1] is not row[0][1]


def _lines_of_names(views: Sequence[View]) -> float:
    """Return the height of the names of columns, in lines: the limit that is passed takes one."""
    passed = any(view.violation is not None and view.violation.number for view in views)
    return _LINES[1 if len(views) <= CROWD else 2 + passed]


def _make_row(
    figure: Figure, row: Row, place: tuple[float, float, float], alone: bool
) -> list[Place]:
    """Return the panels of one row, side by side; `place`: its lower edge, their width, height."""
    bottom, width, height = place
    last = len(row) - 1
    found = []
    for i, (panel, view) in enumerate(row):
        box = (LEFT + i * (width + GAP), bottom, width, height)
        axes = add_panel(figure, [length * CM for length in box], label=panel)
        found.append(Place(panel, view, axes, i == 0, i == last, alone))
    return found


def write_letters(places: Sequence[Sequence[Place]], several: bool) -> None:
    """Write a letter into each panel; those of one kind in a row of several columns share it.

    In a phase plane it stands in the corner that the curves leave free; elsewhere above them.
    """
    found = [place for row in places for place in row]
    kinds = list(dict.fromkeys(place.panel for place in found))
    if len(found) < 2:
        return
    for i, place in enumerate(found):
        text = letter(kinds.index(place.panel) if several else i)
        corner = _free_corner(place.axes) if place.panel in PLANES else (0, 1)
        x, y = corner
        place.axes.annotate(
            text, corner, (_LETTER * (1 - 2 * x), _LETTER * (1 - 2 * y)),
            xycoords="axes fraction", textcoords="offset points",
            ha="right" if x else "left", va="top" if y else "bottom", zorder=9,
        )  # fmt: skip


def fit_forces(row: Sequence[Place]) -> None:
    """Give the panels of forces in a row the same limits, or their own where they differ widely."""
    places = [place for place in row if place.panel == "force"]
    ends = np.array([place.axes.get_ylim() for place in places]).reshape(-1, 2)
    spans = ends[:, 1] - ends[:, 0]
    if spans.max(initial=0.0) > _OWN_SCALE * spans.min(initial=np.inf):
        return
    for place in places:
        place.axes.set_ylim(ends.min(), ends.max())


def _free_corner(axes: Axes) -> tuple[int, int]:
    """Return the corner (right, top), each 0 or 1, with the fewest points of curves in it.

    Of equal ones the first: upper left, upper right, lower left, lower right.
    """
    found = [np.asarray(line.get_xydata()) for line in axes.lines]
    found += [np.asarray(cloud.get_offsets()) for cloud in axes.collections]
    if not sum(map(len, found)):
        return 0, 1
    axes.get_xlim()  # which settles the limits that the transformation takes
    to_axes = axes.transData + axes.transAxes.inverted()
    points = np.concatenate([to_axes.transform(places) for places in found])
    corners = ((0, 1), (1, 1), (0, 0), (1, 0))
    size = np.array([_LETTER_BOX[0] / axes.bbox.width, _LETTER_BOX[1] / axes.bbox.height])
    size *= axes.figure.dpi

    def crowd(corner: tuple[int, int]) -> int:
        return int(np.count_nonzero((np.abs(points - corner) < size).all(axis=1)))

    return min(corners, key=crowd)


def _width(columns: int, page: Page) -> float:
    """Return the width of each of so many columns."""
    return (page.width / CM - LEFT - RIGHT - (columns - 1) * GAP) / columns


def _height(row: Row, width: float) -> float:
    """Return the height of a row of panels of such a width, that of the highest."""
    several = len({id(view) for _, view in row}) > 1
    height = max(_height_of(panel, width) for panel, _ in row)
    return _CROWDED * height if several else height


def _height_of(panel: str, width: float) -> float:
    """Return the height of a panel of such a width."""
    if panel in PLANES:
        return min(_PLANE * width, _TALLEST)
    return _SPECTRUM if panel == "spectrum" else _TIME


def _foot(row: Row, below: Row) -> float:
    """Return the room below a row: little where the row below it has the same axes of time."""
    return SEAM if _same_times(row, below) else FOOT


def _same_times(row: Row, below: Row) -> bool:
    """Return whether two rows show histories of the same windows."""
    kinds = [{panel for panel, _ in entries} for entries in (row, below)]
    histories = all(len(found) == 1 and found <= set(OVER_TIME) for found in kinds)
    return histories and [id(view) for _, view in row] == [id(view) for _, view in below]


def _share_axes(places: Sequence[Sequence[Place]]) -> None:
    """Let panels over time share their times, and panels of one kind their values.

    Phase planes of one kind share both axes: so orbits of several windows can be compared.  Forces
    may differ by orders of magnitude: `fit_forces` decides when they are drawn.
    """
    first: dict[str, Place] = {}
    for place in (place for row in places for place in row):
        if first.setdefault(place.panel, place) is not place and place.panel != "force":
            place.axes.sharey(first[place.panel].axes)
            if place.panel in PLANES:
                place.axes.sharex(first[place.panel].axes)
    for above, below in pairwise(places):
        if _same_times([place[:2] for place in above], [place[:2] for place in below]):
            for upper, lower in zip(above, below, strict=True):
                lower.axes.sharex(upper.axes)
                upper.axes.tick_params(labelbottom=False)
