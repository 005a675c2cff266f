"""The picture of one orbit in full: what each panel of a portrait shows (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import ceil
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.signals import (
    SIGNALS,
    contact_forces,
    energy_of_damper,
    energy_of_structure,
    harmonic_force,
    relative_displacement,
)
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import power_of_ten, typeset
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    letter,
    new_figure,
    size_of,
    styled,
)
from nlds_vines.plotting.style import CM, DOT, GREEN, HUES, SHADES
from nlds_vines.portrait.request import PANELS, PLANES, PortraitRequest, panels_of
from nlds_vines.portrait.result import portrait_in
from nlds_vines.portrait.window_view import View

STRUCTURE, DAMPER, OBSTACLE = "#7a7a7a", HUES["black"], HUES["vermillion"]
"""Colors of the bodies, near the paper's gray, black and red."""

FORCE = DAMPER_ENERGY = HUES["blue"]
"""The color of the harmonic force, and in another panel of the damper's energy."""

SECTION = HUES["blue"]
"""The color of the stroboscopic section, which no boundary has."""

BOUNDARIES: Mapping[str, dict[str, Any]] = {
    "obstacle": {"color": OBSTACLE, "linewidth": 0.9},
    "structure": {"color": STRUCTURE, "linewidth": 0.9},
    "limit": {"color": OBSTACLE, "linewidth": 0.8, "linestyle": (0, (4, 2))},
    "stop": {"color": OBSTACLE, "linewidth": 0.9},
    "second stop": {"color": OBSTACLE, "linewidth": 0.9, "linestyle": (0, (5, 1.5, 1, 1.5))},
    "table": {"color": OBSTACLE, "linewidth": 0.9},
}
"""Lines for what the damper strikes and for the limit that it must not reach, by name."""

MOST_VECTOR = 40_000
"""The most states of a curve that is a path in vector formats; a longer one becomes an image."""

MOST_THICK = 8_000
"""The number of states from which a curve is drawn thinner."""

LONGEST_PLAIN = 6
"""The longest period n of an orbit beside which the motion of the boundaries is a plain line.

With a longer period it is a thin one below the orbit's: the curves would hide each other."""

MOST_CYCLES = 160
"""The most forcing periods of a phase trajectory: more of a chaotic one only blackens the plane."""

_IN_PIECES: dict[Any, Any] = {"agg.path.chunksize": 10_000}
"""A long path is too much for the raster engine in one piece."""

_TIMES = 0.033  # of the width of a panel over time in points: how many intervals of time it has
_NUMBER, _NARROW = 33, 150  # points, of a number along a plane, of panels with shorter words
_LINE = 0.8  # points, width of a curve
_FEW_POINTS = 3.4  # points, size of the points of a section
_MANY_POINTS = 40  # points of a section from which they are drawn smaller


OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
"""The panels whose horizontal axis is time."""

_CROWD = 2  # the most columns with names of one line and full labels; more have less room for each
_TIME, _SPECTRUM = 2.5, 3.4  # cm, heights of a panel over time and of a spectrum
_PLANE, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and in cm at most
_LABELS, _LEGEND = 1.4, 1.85  # cm, about the widths of labels and ticks, and of a legend
_CROWDED = 0.88  # of these heights, if several columns make more rows
_OWN_SCALE = 5.0  # ratio of two ranges of force beyond which the smaller would be hard to read
_LETTER = 5  # points between the corner of a panel and its letter
_LETTER_BOX = 23.0, 19.0  # points, room that a letter takes in its corner


class Place(NamedTuple):
    """A panel on the page: its kind, what it shows, whether it is first or last in its row.

    `alone` is true if it has a heading and scales of its own.
    """

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool
    alone: bool = False


def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the page of an archive with the panels that are `shown`."""
    found = portrait_in(view.path)
    return portrait(replace(found.drawn_from, panels=tuple(shown)), found.views, page)


def fill(axes: Axes, view: ArchiveView, panel: str) -> None:
    """Draw one panel of an archive's first window into given axes."""
    found = portrait_in(view.path)
    place = Place(panel, found.views[0], axes, first=True, last=True)
    _PANELS[panel](place, found.drawn_from)
    _finish(place, [place], found.drawn_from)
    if panel == "spectrum":
        _limit_spectra([place])


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return what can be drawn of an archive, by the names of panels."""
    columns = portrait_in(view.path).drawn_from.columns
    allowed = panels_of([column.system.scene for column in columns])
    return {n: PANELS[n] for n in allowed if any(column.fills(n) for column in columns)}


def usual(view: ArchiveView) -> Sequence[str]:
    """Return the panels of an archive's page."""
    return portrait_in(view.path).drawn_from.panels


@styled()
def portrait(request: PortraitRequest, views: Sequence[View], page: Page = TWO_COLUMNS) -> Figure:
    """Return the page of a request, drawn from the views of its columns.

    Time histories begin with the window and are at most `request.show` periods long.  Phase planes
    show one cycle of a periodic orbit, up to `MOST_CYCLES` periods of any other.  The panels of a
    row share their scales, phase planes of one kind both of them.  In one column of a paper all
    stands below one another.
    """
    figure, grid, rows = make_page(request.panels, views, page)
    for row in rows:
        for place in row:
            if _fills(place):
                _PANELS[place.panel](place, request)
                _finish(place, row, request)
            else:
                place.axes.set_axis_off()
        fit_forces(row)
        _leave_room(row)
        if row[0].panel == "spectrum":
            _limit_spectra(row)
    write_letters(rows, len(views) > 1)
    joint = "\n" if page.beside and len(views) > _CROWD else ", "
    named = [place for place in rows[0] if place.first or len(views) > 1]
    for place in [*named, *(place for row in rows[1:] for place in row if place.alone)]:
        place.axes.set_title(_heading(place.view, joint), loc="left", fontsize=8, pad=3)
    finish(figure, grid, request.title)
    return figure


# ---- the page ------------------------------------------------------------------------------------


Row = Sequence[tuple[str, View]]
"""The kinds of panels in a row, from left to right, and what each of them shows."""


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
) -> tuple[Figure, GridSpec, list[list[Place]]]:
    """Return a figure, its grid, and its panels row by row, with their shared axes."""
    rows = rows_of(panels, views, page.beside)
    columns = max(len(views) if page.beside else 1, *map(len, rows))
    width = (page.width / CM - _LEGEND) / columns - _LABELS
    figure, grid = new_figure(page, [CM * _height(row, width) for row in rows], columns)
    places: list[list[Place]] = []
    for i, row in enumerate(rows):
        alone = len(views) > 1 and _mixed(row)
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
    _share_axes(places)
    return figure, grid, places


def _height(row: Row, width: float) -> float:
    """Return the height [cm] of a row of panels of such a width [cm], that of the highest."""
    plane = min(_PLANE * width, _TALLEST)
    heights = [plane if p in PLANES else _SPECTRUM if p == "spectrum" else _TIME for p, _ in row]
    return max(heights) * (_CROWDED if len({id(view) for _, view in row}) > 1 else 1.0)


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
    """Give the panels of forces in a row the same limits, or their own if they differ widely."""
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
    size = np.array(_LETTER_BOX) / size_of(axes)

    def crowd(corner: tuple[int, int]) -> int:
        return int(np.count_nonzero((np.abs(points - corner) < size).all(axis=1)))

    return min(corners, key=crowd)


# ---- panels ------------------------------------------------------------------------------------


def _fills(place: Place) -> bool:
    """Return whether the column of a place shows its kind of panel."""
    column = place.view.column
    return column.fills(place.panel) and place.panel in panels_of([column.system.scene])


def _heading(view: View, joint: str) -> str:
    """Return the name of a column, or its regime, and its window, with `joint` between them.

    An orbit that the scene's limit forbids is told as such.
    """
    begin, end = view.column.window
    label = view.label if view.period else "no repetition"
    text = f"{typeset(view.column.name) or label}{joint}periods {begin} to {end}"
    if view.violation is None or not view.violation.number:
        return text
    return f"{text}{joint}limit passed by {view.violation.depth:.2g} m"


def _finish(place: Place, row: Sequence[Place], request: PortraitRequest) -> None:
    """Add the axis of time, the legend and the ticks that all panels have in common."""
    axes = place.axes
    axes.tick_params(top=True, right=True)
    axes.yaxis.set_major_locator(_ticks(5))
    if place.panel in OVER_TIME:
        if axes.xaxis.get_major_ticks(1)[0].label1.get_visible():
            words = "" if len(row) > _CROWD else "time "
            axes.set_xlabel(f"{words}$t/T$ [forcing periods]")
        begin, end = place.view.column.window
        axes.set_xlim(begin, min(end, begin + request.show))
        axes.xaxis.set_major_locator(_ticks(ceil(_TIMES * size_of(axes)[0]), integer=True))
    if not (place.first or place.alone or place.panel in PLANES):
        axes.set_ylabel("")
    entries = _entries(row)
    if place.last and entries:
        add_legend(axes, [*entries.values()], "right", handlelength=1.1)


def _entries(row: Sequence[Place]) -> dict[str, Any]:
    """Return the entries of the legend of a row: what is drawn in any of its panels, by label."""
    found: dict[str, Any] = {}
    for place in row:
        handles, labels = place.axes.get_legend_handles_labels()
        found |= {s: _visible(h) for h, s in zip(handles, labels, strict=True) if s not in found}
    return found


def _visible(line: Any) -> Line2D:
    """Return what a legend shows of a line: as wide and as opaque as that of a short curve."""
    shown = Line2D([], [])
    shown.update_from(line)
    shown.set(alpha=1.0, linewidth=max(line.get_linewidth(), _LINE), rasterized=False)
    shown.set(markersize=max(line.get_markersize(), _FEW_POINTS), label=line.get_label())
    return shown


def _ticks(most: int, integer: bool = False) -> MaxNLocator:
    """Return the rule for ticks at round numbers, which make at `most` so many intervals."""
    return MaxNLocator(most, integer=integer, steps=[1, 2, 5, 10])


def _shown(view: View, request: PortraitRequest) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times [forcing periods], times [s] and states (n, 4) of a time history."""
    count = request.show * view.samples
    time = view.time[:count]
    return time / view.column.system.period, time, view.states[:count]


def _over_time(place: Place, label: str, curves: Iterable[tuple[Any, Any, dict[str, Any]]]) -> None:
    """Draw curves over time, each of times, values and look, and label the axis of values."""
    for across, values, look in curves:
        place.axes.plot(across, values, **{"linewidth": _LINE, **look})
    place.axes.set_ylabel(label)


def _bodies(place: Place, request: PortraitRequest, column: int, symbol: str, label: str) -> None:
    """Draw one component of structure and damper over time."""
    across, _, states = _shown(place.view, request)
    label_1 = (
        f"${symbol}_1$" if "x1" in place.view.column.system.scene.components else f"${symbol}$"
    )
    curves = [(across, states[:, column], {"color": STRUCTURE, "label": label_1})]
    if place.view.column.system.scene.damper:
        curves.append((across, states[:, column + 2], {"color": DAMPER, "label": f"${symbol}_2$"}))
    _over_time(place, label, curves)


def _boundaries(view: View) -> Mapping[str, float]:
    """Return where what the damper strikes, or must not reach, is drawn: x2 - x1 [m] by name."""
    system = view.column.system
    return {name: float(u) for name, u in system.scene.obstacle(system.parameters).items()}


def _words(boundary: str) -> str:
    """Return what a legend calls a boundary: stops by their places, in the room that there is."""
    return {"stop": "stop $C$", "second stop": "stop $-C_2$"}.get(boundary, boundary)


def _displacement(place: Place, request: PortraitRequest) -> None:
    _bodies(place, request, 0, "x", "displacement [m]")
    across, _, states = _shown(place.view, request)
    for name, u in _boundaries(place.view).items():
        if place.view.column.system.scene.grounded:
            place.axes.axhline(u, label=_words(name), **BOUNDARIES[name])
        elif name != "structure":  # which is drawn as a body
            place.axes.plot(across, states[:, 0] + u, label=_words(name), **BOUNDARIES[name])


def _velocity(place: Place, request: PortraitRequest) -> None:
    _bodies(place, request, 1, r"\dot{x}", "velocity [m/s]")


def _relative(place: Place, request: PortraitRequest) -> None:
    across, _, states = _shown(place.view, request)
    u = relative_displacement(place.view.column.system, states)
    look = {"color": DAMPER, "label": "$x_2-x_1$"}
    _over_time(place, "$x_2-x_1$ [m]", [(across, u, look)])
    for name, height in _boundaries(place.view).items():
        place.axes.axhline(height, label=_words(name), **BOUNDARIES[name])


def _force(place: Place, request: PortraitRequest) -> None:
    across, time, states = _shown(place.view, request)
    system = place.view.column.system
    outer = harmonic_force(system, time) / 1000  # kN
    harmonic = {"color": FORCE, "linestyle": (0, (3, 1.5)), "label": r"$P\,\cos\,\omega t$"}
    curves: list[tuple[Any, Any, dict[str, Any]]] = [(across, outer, harmonic)]
    found = contact_forces(system, states)
    for name, values in found.items():
        label = _words(name) if len(found) > 1 else "contact"
        curves.append((across, values / 1000, {**BOUNDARIES[name], "label": label}))
    _over_time(place, "force [kN]", curves)


def _energy(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "energy [J]", (1, 2))


def _energy1(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "$E_1$ [J]", (1,))


def _energy2(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "$E_2$ [J]", (2,))


def _energies(place: Place, request: PortraitRequest, label: str, bodies: tuple[int, ...]) -> None:
    """Draw the energies of the bodies, of 1 and 2, over time."""
    across, _, states = _shown(place.view, request)
    system, curves = place.view.column.system, []
    if 1 in bodies:
        found = energy_of_structure(system, states)
        curves.append((across, found, {"color": GREEN, "label": "$E_1$"}))
    if 2 in bodies and system.scene.damper:
        found = energy_of_damper(system, states)
        curves.append((across, found, {"color": DAMPER_ENERGY, "label": "$E_2$"}))
    _over_time(place, label, curves)
    place.axes.set_ylim(bottom=0)


def _cycle_states(view: View) -> np.ndarray:
    """Return the states of one cycle and the state before it, so that a periodic curve closes."""
    return view.states[-(min(view.cycle, MOST_CYCLES) * view.samples + 1) :]


def _curve(axes: Axes, across: np.ndarray, values: np.ndarray, color: str, label: str) -> None:
    """Draw a phase trajectory, thinner the longer it is; as an image beyond `MOST_VECTOR`."""
    long = across.size > MOST_VECTOR
    width, alpha = (0.25, 0.6) if long else (_LINE if across.size < MOST_THICK else 0.4, 1.0)
    with matplotlib.rc_context(_IN_PIECES):
        axes.plot(
            across, values, color=color, linewidth=width, alpha=alpha, rasterized=long, label=label
        )


def _points(place: Place, body: int) -> None:
    """Draw the stroboscopic section of a body: n points of an nT orbit, all of any other."""
    section, n = place.view.section, place.view.period
    size = _FEW_POINTS if 0 < n < _MANY_POINTS else 1.7
    points = section[-n:, 2 * body], section[-n:, 2 * body + 1]  # all where n is 0
    place.axes.plot(*points, color=SECTION, markersize=size, zorder=5, label="$t=nT$", **DOT)


def _label_plane(axes: Axes, symbol: str) -> None:
    """Label the axes of a phase plane by the symbol of its coordinate."""
    axes.set_xlabel(f"${symbol}$ [m]")
    axes.set_ylabel(rf"$\dot{{{symbol[0]}}}{symbol[1:]}$ [m/s]")
    axes.xaxis.set_major_locator(_ticks(min(6, int(size_of(axes)[0] / _NUMBER))))


def _symbol_1(scene: Scene) -> str:
    """Return the symbol of the displacement of the body that is forced."""
    return "x_1" if "x1" in scene.components else "x"


def _phase(place: Place, request: PortraitRequest) -> None:
    states, axes = _cycle_states(place.view), place.axes
    _curve(axes, states[:, 0], states[:, 1], STRUCTURE, _body_of(place))
    if place.view.column.system.scene.damper:
        _curve(axes, states[:, 2], states[:, 3], DAMPER, "damper")
    _draw_boundaries(place, states)
    for body in range(2 if place.view.column.system.scene.damper else 1):
        _points(place, body)
    axes.set_xlabel("displacement [m]")
    axes.set_ylabel("velocity [m/s]")


def _body_of(place: Place) -> str:
    """Return the word for the body that is forced: where there is no damper, what it is."""
    scene = place.view.column.system.scene
    return scene.body if scene.grounded else "structure"


def _phase1(place: Place, request: PortraitRequest) -> None:
    states = _cycle_states(place.view)
    scene = place.view.column.system.scene
    _curve(place.axes, states[:, 0], states[:, 1], STRUCTURE, _body_of(place))
    if scene.grounded:
        _draw_boundaries(place, states)
    _points(place, 0)
    _label_plane(place.axes, _symbol_1(scene))


def _phase2(place: Place, request: PortraitRequest) -> None:
    states = _cycle_states(place.view)
    _curve(place.axes, states[:, 2], states[:, 3], DAMPER, "damper")
    _draw_boundaries(place, states)
    _points(place, 1)
    _label_plane(place.axes, "x_2")


def _section(place: Place, request: PortraitRequest) -> None:
    scene = place.view.column.system.scene
    if not scene.damper:
        _section1(place, request)
        return
    _draw_section(place, request, 1, SECTION)
    _label_plane(place.axes, "x_2")


def _section1(place: Place, request: PortraitRequest) -> None:
    _draw_section(place, request, 0, SECTION)
    _label_plane(place.axes, _symbol_1(place.view.column.system.scene))


def _impact_section(place: Place, request: PortraitRequest) -> None:
    struck = place.view.column.system.scene.struck.values()
    looks = {name: {"color": BOUNDARIES[name]["color"], "label": _words(name)} for name in struck}
    _draw_impact_section(place, looks)


def _draw_boundaries(place: Place, states: np.ndarray) -> None:
    """Draw the motion of what the damper strikes, x1 + u, in the damper's phase plane.

    Of walls that stand on the ground, their places.
    """
    if place.view.column.system.scene.grounded:
        for name, u in _boundaries(place.view).items():
            place.axes.axvline(u, label=_words(name), **BOUNDARIES[name])
        return
    plain = 0 < place.view.period <= LONGEST_PLAIN
    look: dict[str, Any] = {} if plain else {"linewidth": 0.25, "alpha": 0.35, "zorder": 1}
    look["rasterized"] = len(states) > MOST_VECTOR
    for name, u in _boundaries(place.view).items():
        with matplotlib.rc_context(_IN_PIECES):
            place.axes.plot(
                states[:, 0] + u, states[:, 1], label=_words(name), **{**BOUNDARIES[name], **look}
            )


def _leave_room(row: Sequence[Place]) -> None:
    """Leave room for the letters above the curves of panels over time."""
    own = row[0].alone or row[0].panel == "force"
    for place in row if own else row[:1]:  # the others share its values
        if place.panel in OVER_TIME:
            low, high = place.axes.get_ylim()
            place.axes.set_ylim(low, high + 0.28 * (high - low))


# ---- sections ------------------------------------------------------------------------------------


CROWDED = 1500  # points from which colors tell how many are near: single ones overlap
_CELLS = 160  # along each side of the plane, in which points are counted
_PALEST = 0.9  # of the color map: its yellow end is too pale for dots
_LARGE, _SMALL, _SMALLEST = 3.4, 1.7, 0.9  # points, sizes of dots of few, more and many points
_FEW = 40  # points that are drawn large


def _draw_section(place: Place, request: PortraitRequest, body: int, color: str) -> None:
    """Draw the stroboscopic section of a body, 0 or 1, at the phase that the request says."""
    view = place.view
    sample = round(request.section_phase * view.samples) % view.samples
    points = view.section_at(sample)[:, 2 * body : 2 * body + 2]
    n = view.period
    if n:
        points = points[-n:]
    label = rf"$\phi={sample / view.samples:.3g}$" if sample else "$t=nT$"  # phi in turns
    _scatter(place.axes, points, color, label)
    place.axes.margins(0.06)


def _draw_impact_section(place: Place, looks: Mapping[str, Mapping[str, str]]) -> None:
    """Draw phase of the force and approach speed of each touch, of a cycle where there is one.

    Arguments: the `looks`, color and label of each wall by its name.
    """
    view, axes = place.view, place.axes
    for name, points in view.impact_section.items():
        if len(points):
            _scatter(axes, points, looks[name]["color"], looks[name]["label"], shaded=False)
    if not len(view.contacts):
        axes.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=axes.transAxes)
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_ylim(0.0, 1.08 * max(axes.dataLim.y1, 0.0) or 1.0)
    axes.set_xlabel(r"phase at touch $\varphi$ [rad]")
    axes.set_ylabel("approach speed [m/s]")


def _scatter(axes: Axes, points: np.ndarray, color: str, label: str, shaded: bool = True) -> None:
    """Draw points (n, 2); of many, if they are `shaded`, the color tells how many are near."""
    many = len(points)
    size = _LARGE if many < _FEW else _SMALL if many < CROWDED else _SMALLEST
    if many < CROWDED or not shaded:
        look = {"color": color, "markersize": size, "label": label, **DOT}
        axes.plot(points[:, 0], points[:, 1], rasterized=many > CROWDED, **look)
        return
    near = _neighbors(points)
    order = np.argsort(near, kind="stable")  # the dense ones above
    axes.scatter(
        points[order, 0], points[order, 1], s=size**2, c=near[order], cmap=_shades(),
        rasterized=True,
        norm=LogNorm(1.0, max(2.0, float(near.max()))), linewidths=0,
    )  # fmt: skip
    axes.plot([], [], color=_shades()(0.5), label=label, **DOT)


def _neighbors(points: np.ndarray) -> np.ndarray:
    """Return how many points stand in the cell of each, of a grid over their range."""
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    places = ((points - low) / np.where(span > 0, span, 1.0) * _CELLS).astype(int)
    cells = np.minimum(places, _CELLS - 1) @ np.array([1, _CELLS])
    return np.bincount(cells)[cells]


def _shades() -> LinearSegmentedColormap:
    """Return the color map of counts: dark where points are few, lighter where many overlap."""
    return LinearSegmentedColormap.from_list(
        "counts", colormaps[SHADES](np.linspace(0.0, _PALEST, 64))
    )


# ---- spectra -------------------------------------------------------------------------------------


DEPTH = 100.0
"""How far down a spectrum is drawn, in decibels below the highest line of its row."""

LEAST = 1.0e-4
"""The amplitude of a line, relative to the largest, above which the line is to be visible."""

SHORTEST, LONGEST = 4, 8
"""The least and the greatest upper end of the frequencies, in multiples of the force's."""

FINE = 240
"""Periods above which the bins of a spectrum are so close that its curve has to be thinner."""

ZERO = -400.0
"""The decibels at which an amplitude of exactly zero is drawn."""


def _draw_spectrum(place: Place, request: PortraitRequest) -> None:
    """Draw the lines of a spectrum in decibels, and write its broadband share beside them."""
    found = place.view.spectrum
    with np.errstate(divide="ignore"):
        heights = np.maximum(found.decibels(), ZERO)
    width = 0.5 if found.periods <= FINE else 0.3
    place.axes.plot(found.order[1:], heights[1:], color="black", linewidth=width)
    omega = place.view.column.system.parameters["omega"]
    force = rf"$\omega$ = {omega:g} rad/s"
    narrow = size_of(place.axes)[0] < _NARROW
    words = rf"$\Omega/\omega$, {force}" if narrow else f"frequency [multiples of {force}]"
    place.axes.set_xlabel(words)
    name, unit = found.quantity, SIGNALS[found.quantity].unit
    plain = name if len(name) == 1 else f"{name[0]}_{name[1:]}"
    symbol = {"force": "F", "u": "x_2-x_1"}.get(name, plain)
    place.axes.set_ylabel(f"$|{symbol}|$ [dB re 1 {unit}]")
    if place.view.share is not None:
        look: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7.5}
        place.axes.text(
            0.985, 0.95, _share(place.view, narrow), transform=place.axes.transAxes, **look
        )


def _share(view: View, narrow: bool) -> str:
    """Return the broadband share in words, a tiny one by its order; if `narrow` in two lines."""
    share, n = view.share or 0.0, view.comb
    value = f"{share:.1%}" if share >= 5e-4 or share == 0 else f"${power_of_ten(f'{share:.0e}')}$"
    lines = f"{n if n > 1 else ''}T lines:"
    return f"off {lines}\n{value}" if narrow else f"power outside {lines} {value}"


def _limit_spectra(row: Sequence[Place]) -> None:
    """Give the spectra of a row the same scales: `DEPTH` below the highest line, one end."""
    found = [place.view.spectrum for place in row]
    highest = max(float(s.decibels()[1:].max()) for s in found)
    if highest > ZERO:
        row[0].axes.set_ylim(highest - DEPTH, highest + 0.2 * DEPTH)
    for place in row:
        place.axes.set_xlim(0, max(_highest_order(s) for s in found))


def _highest_order(found: Spectrum) -> int:
    """Return the frequency, in whole multiples of the force's, up to which a spectrum is shown."""
    strong = found.order[1:][found.amplitude[1:] > LEAST * found.amplitude[1:].max()]
    return min(max(SHORTEST, ceil(strong[-1] + 0.2) if strong.size else 0), LONGEST)


_PANELS: Mapping[str, Callable[[Place, PortraitRequest], None]] = {
    "displacement": _displacement,
    "velocity": _velocity,
    "relative": _relative,
    "force": _force,
    "energy": _energy,
    "energy1": _energy1,
    "energy2": _energy2,
    "phase": _phase,
    "phase1": _phase1,
    "phase2": _phase2,
    "section": _section,
    "section1": _section1,
    "impact-section": _impact_section,
    "spectrum": _draw_spectrum,
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
