"""The page of a portrait: its rows of panels, and how each kind is drawn (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

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
from nlds_vines.errors import choice
from nlds_vines.model.ratios import HZ
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.signals import (
    SIGNALS,
    contact_forces,
    energy_of_damper,
    energy_of_structure,
    harmonic_force,
    relative_displacement,
)
from nlds_vines.plotting.bands import drawable
from nlds_vines.plotting.chosen_panels import Picture, several_panels
from nlds_vines.plotting.notation import power_of_ten, typeset
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    into,
    letter,
    new_figure,
    size_of,
    styled,
)
from nlds_vines.plotting.save import let_figures_be_shown
from nlds_vines.plotting.style import CM, DOT, GRAY, GREEN, HUES, SHADES
from nlds_vines.portrait.request import (
    EXPONENTS,
    PANELS,
    PLANES,
    PortraitRequest,
    described,
    panels_of,
)
from nlds_vines.portrait.result import portrait_in
from nlds_vines.portrait.window_view import View

if TYPE_CHECKING:
    from nlds_vines.orbits.simulation import Orbit

STRUCTURE, DAMPER, OBSTACLE = "#7a7a7a", HUES["black"], HUES["vermillion"]
"""Colors of the bodies and the walls, near the paper's gray, black and red."""

FORCE = DAMPER_ENERGY = HUES["blue"]
"""The color of the harmonic force and, in another panel, of the damper's energy."""

SECTION = HUES["blue"]
"""The color of the stroboscopic section, unlike that of any boundary."""

BOUNDARIES: Mapping[str, dict[str, Any]] = {
    "obstacle": {"color": OBSTACLE, "linewidth": 0.9},
    "structure": {"color": STRUCTURE, "linewidth": 0.9},
    "limit": {"color": OBSTACLE, "linewidth": 0.8, "linestyle": (0, (4, 2))},
    "stop": {"color": OBSTACLE, "linewidth": 0.9},
    "second stop": {"color": OBSTACLE, "linewidth": 0.9, "linestyle": (0, (5, 1.5, 1, 1.5))},
    "table": {"color": OBSTACLE, "linewidth": 0.9},
}
"""Lines of the walls and of the limit that the damper must not reach, by name."""

MOST_VECTOR = 40_000
"""States beyond which a curve is an image in vector formats, too."""

MOST_THICK = 8_000
"""States beyond which a curve is drawn thinner."""

LONGEST_PLAIN = 6
"""The longest period n of an orbit whose moving boundaries are plain lines.

With longer periods they are thin lines below the orbit, as the curves would hide each other."""

MOST_CYCLES = 160
"""The most forcing periods of a phase trajectory; more of a chaotic one blacken the plane."""

_IN_PIECES: dict[Any, Any] = {"agg.path.chunksize": 10_000}
"""The raster engine draws a long path in pieces."""

_TIMES = 0.033  # intervals between ticks of time, per point of width
_NUMBER, _NARROW = 33, 150  # points: width of a number; width below which labels are short
_LINE = 0.8  # points, width of a curve

OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
"""The panels whose horizontal axis is time."""

_OF_SECTIONS = (
    *("displacement", "velocity", "relative", "energy", "energy1", "energy2"),
    *("section", "section1", "impact-section"),
)  # panels that need states at t = nT alone

_CROWD = 2  # the most columns with headings of one line and full labels
_TIME, _SPECTRUM = 2.5, 3.4  # cm, heights of a panel over time and of a spectrum
_PLANE, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and in cm at most
_LABELS, _LEGEND = 1.4, 1.85  # cm, about the widths of labels and ticks, and of a legend
_CROWDED = 0.88  # of these heights, if several columns make more rows
_OWN_SCALE = 5.0  # ratio of two ranges of force beyond which each has its own scale
_LETTER = 5  # points between the corner of a panel and its letter
_LETTER_BOX = 23.0, 19.0  # points, size of the corner that a letter takes


class Place(NamedTuple):
    """A panel on the page: its kind, its view, its axes, whether it is first or last in its row.

    `alone` means that it has its own heading and scales.
    """

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool
    alone: bool = False


def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the page of an archive with the panels `shown`."""
    result = portrait_in(view.path)
    return portrait(replace(result.drawn_from, panels=tuple(shown)), result.views, page)


def fill(axes: Axes, view: ArchiveView, panel: str) -> None:
    """Draw one panel of an archive's first window into axes."""
    result = portrait_in(view.path)
    _fill(axes, result.drawn_from, result.views[0], panel)


def _fill(axes: Axes, request: PortraitRequest, view: View, panel: str) -> None:
    place = Place(panel, view, axes, first=True, last=True)
    _PANELS[panel](place, request)
    _finish(place, [place], request)
    if panel == "spectrum":
        _limit_spectra([place])


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return the panels that an archive can fill, with their meanings."""
    columns = portrait_in(view.path).drawn_from.columns
    allowed = panels_of([column.system.scene for column in columns])
    return {n: PANELS[n] for n in allowed if any(column.fills(n) for column in columns)}


def usual(view: ArchiveView) -> Sequence[str]:
    """Return the panels of the archive's own page."""
    return portrait_in(view.path).drawn_from.panels


@styled()
def portrait(request: PortraitRequest, views: Sequence[View], page: Page = TWO_COLUMNS) -> Figure:
    """Return the page of a request, drawn from the views of its columns.

    Time histories begin with the window and are at most `request.show` periods long.  Phase planes
    show one cycle of a periodic orbit, up to `MOST_CYCLES` periods of any other.  The panels of a
    row share their ordinates, phase planes of one kind both axes.  On a page for one column of a
    paper, all panels stand below one another.
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


def draw_orbit(orbit: Orbit, show: str | None = None, ax: Axes | None = None) -> Figure:
    """Return the picture of an orbit; arguments and errors as `Orbit.plot`."""
    from nlds_vines.portrait.run import view_of_orbit  # imports kernels

    view = view_of_orbit(orbit)
    scene, is_sampled = orbit.system.scene, view.samples > 1
    allowed = [name for name in panels_of([scene]) if is_sampled or name in _OF_SECTIONS]
    allowed = [name for name in allowed if name != EXPONENTS]
    if orbit.impacts is None and "impact-section" in allowed:
        allowed.remove("impact-section")
    if show is None:
        usual = ("displacement", "relative", "section", "impact-section")
        names = [name for name in usual if name in allowed]
    else:
        names = [choice("show", word.strip(), allowed) for word in show.split(",")]
    shown = PortraitRequest.show if is_sampled else len(view.section)
    request = PortraitRequest(
        described(orbit.system), (view.column,), tuple(dict.fromkeys(names)), show=shown
    )
    let_figures_be_shown()
    if ax is None:
        return portrait(request, [view])
    if show is not None and len(names) > 1:
        raise several_panels(show, dict.fromkeys(allowed))
    return into(ax, lambda: _fill(ax, request, view, names[0]))


# ---- the page ------------------------------------------------------------------------------------


Row = Sequence[tuple[str, View]]
"""The kinds of the panels in a row, from left to right, and their views."""


def rows_of(
    panels: Sequence[str], views: Sequence[View], beside: bool = True
) -> list[list[tuple[str, View]]]:
    """Return the rows of a page: one kind of panel for all columns.

    Of several columns, panels that only one of them fills stand side by side, as many as there are
    columns.  With a single column, two consecutive planes share a row.  Unless panels may stand
    `beside` each other, each has its own row, column after column.
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
    """Return True if the `entries` of a panel stand in the same row as the panel before."""
    if len(views) > 1:
        return len(entries) == 1 and _mixed([*row, *entries]) and len(row) < len(views)
    return len(row) < 2 and all(panel in PLANES for panel, _ in (*row, *entries))


def _mixed(row: Row) -> bool:
    """Return True if all panels of a row are of different kinds."""
    kinds = [panel for panel, _ in row]
    return len(set(kinds)) == len(kinds)


def make_page(
    panels: Sequence[str], views: Sequence[View], page: Page = TWO_COLUMNS
) -> tuple[Figure, GridSpec, list[list[Place]]]:
    """Return a figure, its grid, and its empty panels row by row, which share axes."""
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
    """Return the height [cm] of a row of panels of such a width [cm]."""
    plane = min(_PLANE * width, _TALLEST)
    tall = dict.fromkeys(PLANES, plane) | {"spectrum": _SPECTRUM, EXPONENTS: _SPECTRUM}
    heights = [tall.get(panel, _TIME) for panel, _ in row]
    return max(heights) * (_CROWDED if len({id(view) for _, view in row}) > 1 else 1.0)


def _share_axes(places: Sequence[Sequence[Place]]) -> None:
    """Let panels over time share their times, and panels of one kind their ordinates.

    Phase planes of one kind share both axes, so that orbits can be compared.  Forces may differ by
    orders of magnitude, so `fit_forces` scales them after they are drawn.
    """
    first: dict[str, Place] = {}
    for place in (place for row in places for place in row):
        if first.setdefault(place.panel, place) is not place and place.panel != "force":
            place.axes.sharey(first[place.panel].axes)
            if place.panel in PLANES:
                place.axes.sharex(first[place.panel].axes)
    for above, below in pairwise(places):
        kinds = [{place.panel for place in row} for row in (above, below)]
        is_over_time = all(len(panels) == 1 and panels <= set(OVER_TIME) for panels in kinds)
        windows = [[id(place.view) for place in row] for row in (above, below)]
        if is_over_time and windows[0] == windows[1]:
            for upper, lower in zip(above, below, strict=True):
                lower.axes.sharex(upper.axes)
                upper.axes.tick_params(labelbottom=False)


def write_letters(places: Sequence[Sequence[Place]], several: bool) -> None:
    """Write a letter into each panel; with several columns, panels of one kind share it.

    In a phase plane it stands in the emptiest corner, elsewhere above the curves.
    """
    panels = [place for row in places for place in row]
    kinds = list(dict.fromkeys(place.panel for place in panels))
    if len(panels) < 2:
        return
    for i, place in enumerate(panels):
        text = letter(kinds.index(place.panel) if several else i)
        corner = _free_corner(place.axes) if place.panel in PLANES else (0, 1)
        x, y = corner
        place.axes.annotate(
            text, corner, (_LETTER * (1 - 2 * x), _LETTER * (1 - 2 * y)),
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


def _free_corner(axes: Axes) -> tuple[int, int]:
    """Return the corner (right, top), each 0 or 1, with the fewest points of curves.

    Of equal ones the first: upper left, upper right, lower left, lower right.
    """
    curves = [np.asarray(line.get_xydata()) for line in axes.lines]
    curves += [np.asarray(cloud.get_offsets()) for cloud in axes.collections]
    if not sum(map(len, curves)):
        return 0, 1
    axes.get_xlim()  # settles the limits on which the transformation depends
    to_axes = axes.transData + axes.transAxes.inverted()
    points = np.concatenate([to_axes.transform(places) for places in curves])
    corners = ((0, 1), (1, 1), (0, 0), (1, 0))
    size = np.array(_LETTER_BOX) / size_of(axes)
    crowds = [np.count_nonzero((np.abs(points - one) < size).all(axis=1)) for one in corners]
    return corners[int(np.argmin(crowds))]


# ---- panels ------------------------------------------------------------------------------------


def _fills(place: Place) -> bool:
    """Return True if the column of a place fills its panel."""
    column = place.view.column
    return column.fills(place.panel) and place.panel in panels_of([column.system.scene])


def _heading(view: View, joint: str) -> str:
    """Return the name of a column, or its label, its window, and how far it passed the limit."""
    begin, end = view.column.window
    label = view.label if view.period else "no repetition"
    text = f"{typeset(view.column.name) or label}{joint}periods {begin} to {end}"
    if view.violation is None or not view.violation.number:
        return text
    return f"{text}{joint}limit passed by {view.violation.depth:.2g} m"


def _finish(place: Place, row: Sequence[Place], request: PortraitRequest) -> None:
    """Add the axis of time, the legend and the ticks of a panel."""
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
        add_legend(axes, entries, "right", handlelength=1.1)


def _entries(row: Sequence[Place]) -> list[Line2D]:
    """Return the legend of a row: every label in it once, as wide and opaque as a short curve."""
    entries: dict[str, Line2D] = {}
    for place in row:
        line: Any
        handles, labels = place.axes.get_legend_handles_labels()
        for line, label in zip(handles, labels, strict=True):
            if label not in entries:
                entries[label] = entry = Line2D([], [])
                entry.update_from(line)
                entry.set(alpha=1.0, linewidth=max(line.get_linewidth(), _LINE), rasterized=False)
                entry.set(markersize=max(line.get_markersize(), _LARGE), label=label)
    return [*entries.values()]


def _ticks(most: int, integer: bool = False) -> MaxNLocator:
    """Return a locator of round numbers with at `most` so many intervals."""
    return MaxNLocator(most, integer=integer, steps=[1, 2, 5, 10])


def _shown(view: View, request: PortraitRequest) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times [forcing periods], times [s] and states (n, 4) of the shown periods."""
    count = request.show * view.samples
    time = view.time[:count]
    return time / view.column.system.period, time, view.states[:count]


def _over_time(place: Place, label: str, curves: Iterable[tuple[Any, Any, dict[str, Any]]]) -> None:
    """Draw curves (times, values, settings of the line) and label the ordinate.

    Values at t = nT alone are dots.
    """
    usual: dict[str, Any] = {"linewidth": _LINE}
    if place.view.samples == 1:
        usual = {**DOT, "markersize": _SMALL}
    for across, values, look in curves:
        place.axes.plot(across, values, **{**usual, **look})
    place.axes.set_ylabel(label)


def _bodies(
    place: Place, request: PortraitRequest, column: int, symbol: str, ordinate: str
) -> None:
    """Draw one component of structure and damper over time."""
    across, _, states = _shown(place.view, request)
    scene = place.view.column.system.scene
    label = f"${symbol}_1$" if "x1" in scene.components else f"${symbol}$"
    curves = [(across, states[:, column], {"color": STRUCTURE, "label": label})]
    if scene.damper:
        curves.append((across, states[:, column + 2], {"color": DAMPER, "label": f"${symbol}_2$"}))
    _over_time(place, ordinate, curves)


def _boundaries(view: View) -> Mapping[str, float]:
    """Return the places x2 - x1 [m] of the walls and of the limit, by name."""
    system = view.column.system
    return {name: float(u) for name, u in system.scene.obstacle(system.parameters).items()}


def _words(boundary: str) -> str:
    """Return the name of a boundary in a legend."""
    return {"stop": "stop $C$", "second stop": "stop $-C_2$"}.get(boundary, boundary)


def _displacement(place: Place, request: PortraitRequest) -> None:
    _bodies(place, request, 0, "x", "displacement [m]")
    across, _, states = _shown(place.view, request)
    for name, u in _boundaries(place.view).items():
        if place.view.column.system.scene.grounded:
            place.axes.axhline(u, label=_words(name), **BOUNDARIES[name])
        elif name != "structure" and place.view.samples > 1:  # the structure is drawn as a body
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
    forces = contact_forces(system, states)
    for name, values in forces.items():
        label = _words(name) if len(forces) > 1 else "contact"
        curves.append((across, values / 1000, {**BOUNDARIES[name], "label": label}))
    _over_time(place, "force [kN]", curves)


def _energies(place: Place, request: PortraitRequest, ordinate: str, bodies: str) -> None:
    """Draw the energies of the `bodies`, "1", "2" or "12", over time."""
    across, _, states = _shown(place.view, request)
    system, curves = place.view.column.system, []
    if "1" in bodies:
        energy = energy_of_structure(system, states)
        curves.append((across, energy, {"color": GREEN, "label": "$E_1$"}))
    if "2" in bodies and system.scene.damper:
        energy = energy_of_damper(system, states)
        curves.append((across, energy, {"color": DAMPER_ENERGY, "label": "$E_2$"}))
    _over_time(place, ordinate, curves)
    place.axes.set_ylim(bottom=0)


def _cycle_states(view: View) -> np.ndarray:
    """Return the states of one cycle and the one before, so that the curve of a period closes."""
    return view.states[-(min(view.cycle, MOST_CYCLES) * view.samples + 1) :]


def _curve(axes: Axes, across: np.ndarray, values: np.ndarray, color: str, label: str) -> None:
    """Draw a phase trajectory, a long one thinner, as an image beyond `MOST_VECTOR` states."""
    long = across.size > MOST_VECTOR
    width, alpha = (0.25, 0.6) if long else (_LINE if across.size < MOST_THICK else 0.4, 1.0)
    with matplotlib.rc_context(_IN_PIECES):
        axes.plot(
            across, values, color=color, linewidth=width, alpha=alpha, rasterized=long, label=label
        )


def _points(place: Place, body: int) -> None:
    """Draw the stroboscopic section of a body: n points of an nT orbit, all of any other."""
    section, n = place.view.section, place.view.period
    size = _LARGE if 0 < n < _FEW else _SMALL
    points = section[-n:, 2 * body], section[-n:, 2 * body + 1]  # all where n is 0
    place.axes.plot(*points, color=SECTION, markersize=size, zorder=5, label="$t=nT$", **DOT)


def _label_plane(axes: Axes, symbol: str) -> None:
    """Label the axes of a phase plane with the symbol of its displacement."""
    axes.set_xlabel(f"${symbol}$ [m]")
    axes.set_ylabel(rf"$\dot{{{symbol[0]}}}{symbol[1:]}$ [m/s]")
    axes.xaxis.set_major_locator(_ticks(min(6, int(size_of(axes)[0] / _NUMBER))))


def _symbol_1(scene: Scene) -> str:
    """Return the symbol of the displacement of the forced body."""
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
    """Return the word for the forced body."""
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
    _draw_section(place, request, 1)
    _label_plane(place.axes, "x_2")


def _section1(place: Place, request: PortraitRequest) -> None:
    _draw_section(place, request, 0)
    _label_plane(place.axes, _symbol_1(place.view.column.system.scene))


def _draw_boundaries(place: Place, states: np.ndarray) -> None:
    """Draw the motion of the walls, x1 + u, in the damper's phase plane; grounded walls stand."""
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
    """Leave room above the curves of panels over time for their letters."""
    is_own = row[0].alone or row[0].panel == "force"
    for place in row if is_own else row[:1]:  # the others share its values
        if place.panel in OVER_TIME:
            low, high = place.axes.get_ylim()
            place.axes.set_ylim(low, high + 0.28 * (high - low))


# ---- sections ------------------------------------------------------------------------------------


CROWDED = 1500  # points beyond which colors show the density, as single points overlap
_CELLS = 160  # along each side of the plane, in which points are counted
_PALEST = 0.9  # of the color map, whose yellow end is too pale for dots
_LARGE, _SMALL, _SMALLEST = 3.4, 1.7, 0.9  # points, sizes of few, more and many dots
_FEW = 40  # the number of dots below which they are large


def _draw_section(place: Place, request: PortraitRequest, body: int) -> None:
    """Draw the stroboscopic section of a body, 0 or 1, at the phase in the request."""
    view = place.view
    sample = round(request.section_phase * view.samples) % view.samples
    points = view.section_at(sample)[:, 2 * body : 2 * body + 2]
    n = view.period
    if n:
        points = points[-n:]
    label = rf"$\phi={sample / view.samples:.3g}$" if sample else "$t=nT$"  # phi in turns
    _scatter(place.axes, points, SECTION, label)
    place.axes.margins(0.06)


def _impact_section(place: Place, request: PortraitRequest) -> None:
    """Draw the phase of the force and the approach speed of each touch, of one cycle if any."""
    view, axes = place.view, place.axes
    for name, points in view.impact_section.items():
        if len(points):
            _scatter(axes, points, BOUNDARIES[name]["color"], _words(name), is_shaded=False)
    if not len(view.contacts):
        axes.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=axes.transAxes)
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_ylim(0.0, 1.08 * max(axes.dataLim.y1, 0.0) or 1.0)
    axes.set_xlabel(r"phase at touch $\varphi$ [rad]")
    axes.set_ylabel("approach speed [m/s]")


def _scatter(
    axes: Axes, points: np.ndarray, color: str, label: str, is_shaded: bool = True
) -> None:
    """Draw points (n, 2); if `is_shaded`, the color of many points shows their density."""
    many = len(points)
    size = _LARGE if many < _FEW else _SMALL if many < CROWDED else _SMALLEST
    if many < CROWDED or not is_shaded:
        look = {"color": color, "markersize": size, "label": label, **DOT}
        axes.plot(points[:, 0], points[:, 1], rasterized=many > CROWDED, **look)
        return
    near = _neighbors(points)
    order = np.argsort(near, kind="stable")  # dense ones on top
    shades = colormaps[SHADES](np.linspace(0.0, _PALEST, 64))
    shading = LinearSegmentedColormap.from_list("counts", shades)
    axes.scatter(
        points[order, 0], points[order, 1], s=size**2, c=near[order], cmap=shading,
        norm=LogNorm(1.0, max(2.0, float(near.max()))), linewidths=0, rasterized=True,
    )  # fmt: skip
    axes.plot([], [], color=shading(0.5), label=label, **DOT)


def _neighbors(points: np.ndarray) -> np.ndarray:
    """Return for each point the number of points in its cell of a grid over all points."""
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    places = ((points - low) / np.where(span > 0, span, 1.0) * _CELLS).astype(int)
    cells = np.minimum(places, _CELLS - 1) @ np.array([1, _CELLS])
    return np.bincount(cells)[cells]


# ---- spectra -------------------------------------------------------------------------------------


DEPTH = 100.0
"""The range of a spectrum, in decibels below the highest line of its row."""

LEAST = 1.0e-4
"""The relative amplitude above which a line must be visible."""

SHORTEST, LONGEST = 4, 8
"""The bounds of the highest frequency, in multiples of the force's."""

FINE = 240
"""Periods above which the curve of a spectrum is thinner, as its bins are close."""

ZERO = -400.0
"""The decibels at which an amplitude of exactly zero is drawn."""


def _draw_spectrum(place: Place, request: PortraitRequest) -> None:
    """Draw a spectrum in decibels, and write its broadband share."""
    view, axes, spectrum = place.view, place.axes, place.view.spectrum
    with np.errstate(divide="ignore"):
        heights = np.maximum(spectrum.decibels(), ZERO)
    width = 0.5 if spectrum.periods <= FINE else 0.3
    axes.plot(spectrum.order[1:], heights[1:], color="black", linewidth=width)
    omega = view.column.system.parameters["omega"]
    is_hz = request.frequency == HZ
    force = f"$f$ = {omega / (2 * np.pi):g} Hz" if is_hz else rf"$\omega$ = {omega:g} rad/s"
    is_narrow = size_of(axes)[0] < _NARROW
    ratio = "$F/f$" if is_hz else r"$\Omega/\omega$"
    words = f"{ratio}, {force}" if is_narrow else f"frequency [multiples of {force}]"
    axes.set_xlabel(words)
    name, unit = spectrum.quantity, SIGNALS[spectrum.quantity].unit
    plain = name if len(name) == 1 else f"{name[0]}_{name[1:]}"
    symbol = {"force": "F", "u": "x_2-x_1"}.get(name, plain)
    axes.set_ylabel(f"$|{symbol}|$ [dB re 1 {unit}]")
    if (share := view.share) is None:
        return
    is_tiny = 0 < share < 5e-4
    value = f"${power_of_ten(f'{share:.0e}')}$" if is_tiny else f"{share:.1%}"
    lines = f"{view.comb if view.comb > 1 else ''}T lines:"
    words = f"off {lines}\n{value}" if is_narrow else f"power outside {lines} {value}"
    look: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7.5}
    axes.text(0.985, 0.95, words, transform=axes.transAxes, **look)


def _limit_spectra(row: Sequence[Place]) -> None:
    """Give the spectra of a row the same limits: `DEPTH` below the highest line, one end."""
    spectra = [place.view.spectrum for place in row]
    highest = max(float(spectrum.decibels()[1:].max()) for spectrum in spectra)
    if highest > ZERO:
        row[0].axes.set_ylim(highest - DEPTH, highest + 0.2 * DEPTH)
    end = SHORTEST
    for spectrum in spectra:  # to the last line above LEAST
        amplitude = spectrum.amplitude[1:]
        strong = spectrum.order[1:][amplitude > LEAST * amplitude.max()]
        end = max(end, ceil(strong[-1] + 0.2) if strong.size else 0)
    for place in row:
        place.axes.set_xlim(0, min(end, LONGEST))


def _exponents(place: Place, request: PortraitRequest) -> None:
    """Draw the running means of the Lyapunov exponents, and their intervals at the end."""
    axes, spectrum = place.axes, place.view.exponents
    if spectrum is None:
        return
    periods = np.arange(1, len(spectrum.times) + 1)
    running = drawable(spectrum.running)
    shades = (HUES["blue"], HUES["vermillion"], HUES["green"], HUES["gray"])
    axes.axhline(0.0, color=GRAY, linewidth=0.5)
    for i, (width, shade) in enumerate(zip(spectrum.widths, shades, strict=False)):
        axes.plot(periods, running[:, i], color=shade, linewidth=_LINE, label=rf"$\lambda_{i + 1}$")
        end = running[-1, i]
        axes.fill_between(periods, end - width, end + width, color=shade, alpha=0.2, linewidth=0)
    settled = running[len(running) // 20 :]
    low, high = np.nanmin(settled, initial=0.0), np.nanmax(settled, initial=0.0)
    room = 0.1 * (high - low)
    axes.set_ylim(low - room, high + room)
    axes.set_xscale("log")
    axes.set_xlim(1, len(periods))
    axes.set_xlabel("forcing periods after the window")
    axes.set_ylabel("exponents [1/s]")


_PANELS: Mapping[str, Callable[[Place, PortraitRequest], None]] = {
    "displacement": _displacement,
    "velocity": _velocity,
    "relative": _relative,
    "force": _force,
    "energy": partial(_energies, ordinate="energy [J]", bodies="12"),
    "energy1": partial(_energies, ordinate="$E_1$ [J]", bodies="1"),
    "energy2": partial(_energies, ordinate="$E_2$ [J]", bodies="2"),
    "phase": _phase,
    "phase1": _phase1,
    "phase2": _phase2,
    "section": _section,
    "section1": _section1,
    "impact-section": _impact_section,
    "spectrum": _draw_spectrum,
    EXPONENTS: _exponents,
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
