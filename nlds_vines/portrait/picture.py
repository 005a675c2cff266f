"""The page of a portrait: its rows of panels (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.chosen_panels import Picture, chosen, let_figures_be_shown
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    finish,
    into,
    letter,
    new_figure,
    size_of,
    styled,
)
from nlds_vines.plotting.style import CM, typeset
from nlds_vines.portrait.panels import (
    CROWD,
    OF_SECTIONS,
    OVER_TIME,
    Place,
    draw_panel,
    finish_panel,
    limit_spectra,
)
from nlds_vines.portrait.request import (
    EXPONENTS,
    PANELS,
    PLANES,
    PortraitRequest,
    described,
    panels_of,
    word_of,
)
from nlds_vines.portrait.result import View, portrait_in

if TYPE_CHECKING:
    from nlds_vines.engine.one_orbit import Orbit

_TIME, _SPECTRUM = 2.5, 3.4  # cm, heights of a panel over time and of a spectrum
_PLANE, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and in cm at most
_LABELS, _LEGEND = 1.4, 1.85  # cm, about the widths of labels and ticks, and of a legend
_CROWDED = 0.88  # of these heights, if several columns make more rows
_OWN_SCALE = 5.0  # ratio of two ranges of force beyond which each has its own scale
_LETTER = 5  # points between the corner of a panel and its letter
_LETTER_BOX = 23.0, 19.0  # points, size of the corner that a letter takes


def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    result = portrait_in(view.path)
    return portrait(replace(result.drawn_from, panels=tuple(shown)), result.views, page)


def fill(axes: Axes, view: ArchiveView, panel: str) -> None:
    result = portrait_in(view.path)
    _fill(axes, result.drawn_from, result.views[0], panel)


def _fill(axes: Axes, request: PortraitRequest, view: View, panel: str) -> None:
    place = Place(panel, view, axes, first=True, last=True)
    draw_panel(place, request)
    finish_panel(place, [place], request)
    if panel == "spectrum":
        limit_spectra([place])


def panels(view: ArchiveView) -> Mapping[str, str]:
    request = portrait_in(view.path).drawn_from
    columns = request.columns
    allowed = panels_of([column.system for column in columns], request.of)
    filled = [name for name in allowed if any(column.fills(name) for column in columns)]
    return {name: PANELS[word_of(name)] for name in filled}


@styled()
def portrait(request: PortraitRequest, views: Sequence[View], page: Page = TWO_COLUMNS) -> Figure:
    """Return the page of a request, drawn from the views of its columns.

    Time histories show the first `request.show` periods of the window at most, phase planes one
    cycle, or the periods of an orbit without one, and the last `MOST_PHASE_PERIODS` at most.  The
    panels of a row share their ordinates, phase planes of one kind both axes.
    """
    figure, grid, rows = make_page(request.panels, views, page)
    for row in rows:
        for place in row:
            fits = place.panel in panels_of([place.system], request.of)
            if fits and place.view.column.fills(place.panel):
                draw_panel(place, request)
                finish_panel(place, row, request)
            else:
                place.axes.set_axis_off()
        fit_forces(row)
        is_own = row[0].alone or row[0].panel == "force"
        for place in row if is_own else row[:1]:  # the others share its values
            if place.word in OVER_TIME:  # leave room above the curves for the letters
                low, high = place.axes.get_ylim()
                place.axes.set_ylim(low, high + 0.28 * (high - low))
        if row[0].panel == "spectrum":
            limit_spectra(row)
    write_letters(rows, len(views) > 1)
    joint = "\n" if page.beside and len(views) > CROWD else ", "
    named = [place for place in rows[0] if place.first or len(views) > 1]
    for place in [*named, *(place for row in rows[1:] for place in row if place.alone)]:
        place.axes.set_title(_heading(place.view, joint), loc="left", fontsize=8, pad=3)
    finish(figure, grid, request.title)
    return figure


def draw_orbit(orbit: Orbit, show: str | None = None, ax: Axes | None = None) -> Figure:
    """Return the picture of an orbit; arguments and errors as `Orbit.plot`."""
    from nlds_vines.portrait.run import view_of_orbit  # imports kernels

    view = view_of_orbit(orbit)
    is_sampled = view.samples > 1
    without = {EXPONENTS} | (set() if orbit.impacts is not None else {"impact-section"})
    without |= set() if is_sampled else {*PANELS} - OF_SECTIONS
    allowed = [name for name in panels_of([orbit.system]) if word_of(name) not in without]
    words = ("displacement", "relative", "section", "impact-section")
    usual = [name for name in allowed if word_of(name) in words]
    names = chosen(show, allowed, usual, ax is None)
    shown = PortraitRequest.show if is_sampled else len(view.section)
    request = PortraitRequest(described(orbit.system), (view.column,), tuple(names), show=shown)
    let_figures_be_shown()
    if ax is None:
        return portrait(request, [view])
    return into(ax, lambda: _fill(ax, request, view, names[0]))


# ---- the page ------------------------------------------------------------------------------------


def rows_of(
    panels: Sequence[str], views: Sequence[View], beside: bool = True
) -> list[list[tuple[str, View]]]:
    """Return the rows of a page: one kind of panel for all columns.

    Of several columns, panels that only one of them fills stand side by side; of a single one, two
    consecutive planes share a row.  Unless panels may stand `beside` each other, each has its own.
    """
    if not beside:
        return [[(panel, v)] for v in views for panel in panels if v.column.fills(panel)]
    rows: list[list[tuple[str, View]]] = []
    for panel in panels:
        filling = [view for view in views if view.column.fills(panel)]
        entries = [(panel, view) for view in (views if len(filling) > 1 else filling)]
        row = rows[-1] if rows else []
        if len(views) > 1:
            joins = len(entries) == 1 and len(row) < len(views) and _are_different(row)
        else:
            joins = len(row) == 1 and all(word_of(name) in PLANES for name, _ in (*row, *entries))
        if row and joins:
            row.extend(entries)
        else:
            rows.append(entries)
    return rows


def _are_different(row: Sequence[tuple[str, View]]) -> bool:
    return len({panel for panel, _ in row}) == len(row)


def make_page(
    panels: Sequence[str], views: Sequence[View], page: Page = TWO_COLUMNS
) -> tuple[Figure, GridSpec, list[list[Place]]]:
    """Return a figure, its grid, and its empty panels row by row, which share axes."""
    rows = rows_of(panels, views, page.beside)
    columns = max(len(views) if page.beside else 1, *map(len, rows))
    width = (page.width / CM - _LEGEND) / columns - _LABELS
    tall = dict.fromkeys(PLANES, min(_PLANE * width, _TALLEST))
    tall |= {"spectrum": _SPECTRUM, EXPONENTS: _SPECTRUM}
    heights = [
        max(tall.get(word_of(panel), _TIME) for panel, _ in row)
        * (_CROWDED if len({id(view) for _, view in row}) > 1 else 1.0)
        for row in rows
    ]
    figure, grid = new_figure(page, [CM * height for height in heights], columns)
    places: list[list[Place]] = []
    for i, row in enumerate(rows):
        alone = len(views) > 1 and _are_different(row)
        if not page.beside:
            alone = len(views) > 1 and (i == 0 or rows[i - 1][0][1] is not row[0][1])
        last, whole = len(row) - 1, len(row) == 1 and (len(views) == 1 or not page.beside)
        boxes = [grid[i, :]] if whole else [grid[i, k] for k in range(len(row))]
        places.append(
            [
                Place(panel, view, figure.add_subplot(box, label=panel), k == 0, k == last, alone)
                for k, ((panel, view), box) in enumerate(zip(row, boxes, strict=True))
            ]
        )
    # panels of one kind share their ordinates, phase planes both axes; forces may differ by orders
    # of magnitude, so `fit_forces` scales them after they are drawn
    first: dict[str, Place] = {}
    for place in (place for row in places for place in row):
        if first.setdefault(place.panel, place) is not place and place.panel != "force":
            place.axes.sharey(first[place.panel].axes)
            if place.word in PLANES:
                place.axes.sharex(first[place.panel].axes)
    # panels over time share their times with those below them
    for above, below in pairwise(places):
        kinds = [{place.word for place in row} for row in (above, below)]
        is_over_time = all(len(panels) == 1 and panels <= set(OVER_TIME) for panels in kinds)
        windows = [[id(place.view) for place in row] for row in (above, below)]
        if is_over_time and windows[0] == windows[1]:
            for upper, lower in zip(above, below, strict=True):
                lower.axes.sharex(upper.axes)
                upper.axes.tick_params(labelbottom=False)
    return figure, grid, places


def write_letters(places: Sequence[Sequence[Place]], several: bool) -> None:
    """Write a letter into each panel; with several columns, panels of one kind share it.

    In a phase plane it stands in the corner with the fewest points of curves, of equal ones in the
    first of upper left, upper right, lower left and lower right; elsewhere above the curves.
    """
    panels = [place for row in places for place in row]
    kinds = list(dict.fromkeys(place.panel for place in panels))
    if len(panels) < 2:
        return
    for i, place in enumerate(panels):
        axes, corner = place.axes, (0, 1)
        curves = [np.asarray(line.get_xydata()) for line in axes.lines]
        curves += [np.asarray(cloud.get_offsets()) for cloud in axes.collections]
        if place.word in PLANES and any(len(curve) for curve in curves):
            axes.get_xlim()  # settles the limits on which the transformation depends
            to_axes = axes.transData + axes.transAxes.inverted()
            points = np.concatenate([to_axes.transform(curve) for curve in curves])
            corners = ((0, 1), (1, 1), (0, 0), (1, 0))
            near = np.array(_LETTER_BOX) / size_of(axes)
            corner = min(corners, key=lambda one: (np.abs(points - one) < near).all(axis=1).sum())
        x, y = corner
        axes.annotate(
            letter(kinds.index(place.panel) if several else i), corner,
            (_LETTER * (1 - 2 * x), _LETTER * (1 - 2 * y)),
            xycoords="axes fraction", textcoords="offset points",
            ha="right" if x else "left", va="top" if y else "bottom", zorder=9,
        )  # fmt: skip


def fit_forces(row: Sequence[Place]) -> None:
    """Give the panels of forces in a row the same limits unless these differ widely."""
    places = [place for place in row if place.panel == "force"]
    ends = np.array([place.axes.get_ylim() for place in places]).reshape(-1, 2)
    spans = ends[:, 1] - ends[:, 0]
    if spans.max(initial=0.0) > _OWN_SCALE * spans.min(initial=np.inf):
        return
    for place in places:
        place.axes.set_ylim(ends.min(), ends.max())


def _heading(view: View, joint: str) -> str:
    begin, end = view.column.window
    label = view.label if view.period else "no repetition"
    text = f"{typeset(view.column.name) or label}{joint}periods {begin} to {end}"
    if view.violation is None or not view.violation.number:
        return text
    return f"{text}{joint}limit passed by {view.violation.depth:.2g} m"


PICTURE = Picture(panels, draw, fill, usual=lambda view: portrait_in(view.path).drawn_from.panels)
