"""The page of a portrait: its rows of panels, and how each kind is drawn (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
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
from nlds_vines.model.ratios import HZ
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.responses import contact_forces, harmonic_force, relative_displacement
from nlds_vines.orbits.spectrum import SIGNALS, energy_of_damper, energy_of_structure
from nlds_vines.plotting.bands import drawable
from nlds_vines.plotting.chosen_panels import Picture, chosen, let_figures_be_shown
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
from nlds_vines.plotting.style import CM, DOT, GRAY, GREEN, HUES, SHADES, power_of_ten, typeset
from nlds_vines.portrait.request import (
    EXPONENTS,
    PANELS,
    PLANES,
    PortraitRequest,
    described,
    panels_of,
)
from nlds_vines.portrait.result import View, portrait_in

if TYPE_CHECKING:
    from nlds_vines.orbits.simulation import Orbit

STRUCTURE, DAMPER, OBSTACLE = "#7a7a7a", HUES["black"], HUES["vermillion"]
"""Colors of the bodies and the walls, near the paper's gray, black and red."""

# of the harmonic force, of the damper's energy and of the stroboscopic section
FORCE = ENERGY = SECTION = HUES["blue"]
_WALL = {"color": OBSTACLE, "linewidth": 0.9}
BOUNDARIES: Mapping[str, dict[str, Any]] = {
    "obstacle": _WALL,
    "structure": {**_WALL, "color": STRUCTURE},
    "limit": {**_WALL, "linewidth": 0.8, "linestyle": (0, (4, 2))},
    "stop": _WALL,
    "second stop": {**_WALL, "linestyle": (0, (5, 1.5, 1, 1.5))},
    "table": _WALL,
}
"""Lines of the walls and of the limit that the damper must not reach, by name."""

# states beyond which a curve is an image in vector formats, too, and thinner in all
MOST_VECTOR, MOST_THICK = 40_000, 8_000
# the longest period n of an orbit whose moving boundaries are plain lines; others are thin lines
# below the orbit, as the curves would hide each other
LONGEST_PLAIN = 6

MOST_PHASE_PERIODS = 160  # of a phase trajectory; more of a chaotic one blacken the plane

# the panels whose horizontal axis is time
OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
_OF_SECTIONS = {*OVER_TIME, "section", "section1", "impact-section"} - {"force"}
# the panels that need states at t = nT alone

_IN_PIECES: dict[Any, Any] = {"agg.path.chunksize": 10_000}  # the raster engine draws long paths so
_TIMES = 0.033  # intervals between ticks of time, per point of width
_NUMBER, _NARROW = 33, 150  # points: width of a number; width below which labels are short
_LINE = 0.8  # points, width of a curve
_CROWD = 2  # the most columns with headings of one line and full labels
_TIME, _SPECTRUM = 2.5, 3.4  # cm, heights of a panel over time and of a spectrum
_PLANE, _TALLEST = 0.7, 4.8  # height of a phase plane over its width, and in cm at most
_LABELS, _LEGEND = 1.4, 1.85  # cm, about the widths of labels and ticks, and of a legend
_CROWDED = 0.88  # of these heights, if several columns make more rows
_OWN_SCALE = 5.0  # ratio of two ranges of force beyond which each has its own scale
_LETTER = 5  # points between the corner of a panel and its letter
_LETTER_BOX = 23.0, 19.0  # points, size of the corner that a letter takes


class Place(NamedTuple):
    """A panel of a row; `alone` means that it has its own heading and scales."""

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool
    alone: bool = False

    @property
    def system(self) -> System:
        return self.view.column.system

    @property
    def scene(self) -> Scene:
        return self.system.scene


def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    result = portrait_in(view.path)
    return portrait(replace(result.drawn_from, panels=tuple(shown)), result.views, page)


def fill(axes: Axes, view: ArchiveView, panel: str) -> None:
    result = portrait_in(view.path)
    _fill(axes, result.drawn_from, result.views[0], panel)


def _fill(axes: Axes, request: PortraitRequest, view: View, panel: str) -> None:
    place = Place(panel, view, axes, first=True, last=True)
    _PANELS[panel](place, request)
    _finish(place, [place], request)
    if panel == "spectrum":
        _limit_spectra([place])


def panels(view: ArchiveView) -> Mapping[str, str]:
    columns = portrait_in(view.path).drawn_from.columns
    allowed = panels_of([column.system.scene for column in columns])
    return {n: PANELS[n] for n in allowed if any(column.fills(n) for column in columns)}


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
            fits = place.panel in panels_of([place.scene])
            if fits and place.view.column.fills(place.panel):
                _PANELS[place.panel](place, request)
                _finish(place, row, request)
            else:
                place.axes.set_axis_off()
        fit_forces(row)
        is_own = row[0].alone or row[0].panel == "force"
        for place in row if is_own else row[:1]:  # the others share its values
            if place.panel in OVER_TIME:  # leave room above the curves for the letters
                low, high = place.axes.get_ylim()
                place.axes.set_ylim(low, high + 0.28 * (high - low))
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
    without = {EXPONENTS} | (set() if orbit.impacts is not None else {"impact-section"})
    without |= set() if is_sampled else {*PANELS} - _OF_SECTIONS
    allowed = [name for name in panels_of([scene]) if name not in without]
    usual = ("displacement", "relative", "section", "impact-section")
    names = chosen(show, allowed, [name for name in usual if name in allowed], ax is None)
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
            joins = len(row) == 1 and all(name in PLANES for name, _ in (*row, *entries))
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
        max(tall.get(panel, _TIME) for panel, _ in row)
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
            if place.panel in PLANES:
                place.axes.sharex(first[place.panel].axes)
    # panels over time share their times with those below them
    for above, below in pairwise(places):
        kinds = [{place.panel for place in row} for row in (above, below)]
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
        if place.panel in PLANES and any(len(curve) for curve in curves):
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


# ---- panels ------------------------------------------------------------------------------------


def _heading(view: View, joint: str) -> str:
    begin, end = view.column.window
    label = view.label if view.period else "no repetition"
    text = f"{typeset(view.column.name) or label}{joint}periods {begin} to {end}"
    if view.violation is None or not view.violation.number:
        return text
    return f"{text}{joint}limit passed by {view.violation.depth:.2g} m"


def _finish(place: Place, row: Sequence[Place], request: PortraitRequest) -> None:
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
    # the legend of a row has every label once, as wide and opaque as a short curve
    entries: dict[str, Line2D] = {}
    for one in row if place.last else ():
        line: Any
        handles, labels = one.axes.get_legend_handles_labels()
        for line, label in zip(handles, labels, strict=True):
            if label not in entries:
                entries[label] = entry = Line2D([], [])
                entry.update_from(line)
                entry.set(alpha=1.0, linewidth=max(line.get_linewidth(), _LINE), rasterized=False)
                entry.set(markersize=max(line.get_markersize(), _LARGE), label=label)
    if entries:
        add_legend(axes, [*entries.values()], "right", handlelength=1.1)


def _ticks(most: int, integer: bool = False) -> MaxNLocator:
    return MaxNLocator(most, integer=integer, steps=[1, 2, 5, 10])


def _over_time(place: Place, request: PortraitRequest) -> None:
    view, axes, system, scene = place.view, place.axes, place.system, place.scene
    count = request.show * view.samples
    time, states = view.time[:count], view.states[:count]
    across = time / system.period
    usual: dict[str, Any] = {"linewidth": _LINE}
    if view.samples == 1:
        usual = {**DOT, "markersize": _SMALL}

    def draw(values: np.ndarray, color: str, label: str, **look: Any) -> None:
        axes.plot(across, values, **{**usual, "color": color, "label": label, **look})

    match place.panel:
        case "displacement" | "velocity":
            k, symbol = (0, "x") if place.panel == "displacement" else (1, r"\dot{x}")
            axes.set_ylabel("displacement [m]" if k == 0 else "velocity [m/s]")
            index = "_1" if "x1" in scene.components else ""
            draw(states[:, k], STRUCTURE, f"${symbol}{index}$")
            if scene.damper:
                draw(states[:, k + 2], DAMPER, f"${symbol}_2$")
            for name, u in _boundaries(place).items() if k == 0 else ():
                look = {"label": _words(name), **BOUNDARIES[name]}
                if scene.grounded:
                    axes.axhline(u, **look)
                elif name != "structure" and view.samples > 1:  # the structure is drawn as a body
                    axes.plot(across, states[:, 0] + u, **look)
        case "relative":
            axes.set_ylabel("$x_2-x_1$ [m]")
            draw(relative_displacement(system, states), DAMPER, "$x_2-x_1$")
            for name, u in _boundaries(place).items():
                axes.axhline(u, label=_words(name), **BOUNDARIES[name])
        case "force":
            axes.set_ylabel("force [kN]")
            dashed = (0, (3, 1.5))
            force = harmonic_force(system, time) / 1000
            draw(force, FORCE, r"$P\,\cos\,\omega t$", linestyle=dashed)
            forces = contact_forces(system, states)
            for name, values in forces.items():
                label = _words(name) if len(forces) > 1 else "contact"
                axes.plot(across, values / 1000, **{**usual, **BOUNDARIES[name], "label": label})
        case bodies:
            body = bodies.removeprefix("energy")
            axes.set_ylabel(f"$E_{body}$ [J]" if body else "energy [J]")
            if body != "2":
                draw(energy_of_structure(system, states), GREEN, "$E_1$")
            if body != "1" and scene.damper:
                draw(energy_of_damper(system, states), ENERGY, "$E_2$")
            axes.set_ylim(bottom=0)


def _boundaries(place: Place) -> Mapping[str, float]:
    """Return the places x2 - x1 [m] of the walls and of the limit, by name."""
    return {name: float(u) for name, u in place.scene.obstacle(place.system.parameters).items()}


def _words(boundary: str) -> str:
    return {"stop": "stop $C$", "second stop": "stop $-C_2$"}.get(boundary, boundary)


def _plane(place: Place, request: PortraitRequest) -> None:
    """Draw phase trajectories of one cycle, their sections, and the walls.

    Trajectories are thin if they are long, and images beyond `MOST_VECTOR` states.  In the plane of
    the damper the walls move with the structure unless they stand on the ground.
    """
    view, axes, scene, panel = place.view, place.axes, place.scene, place.panel
    # with the state before, so that the curve of a period closes
    states = view.states[-(min(view.cycle, MOST_PHASE_PERIODS) * view.samples + 1) :]
    bodies = [0] if panel != "phase2" else []
    bodies += [1] if panel != "phase1" and scene.damper else []
    is_long = len(states) > MOST_VECTOR
    width, alpha = (0.25, 0.6) if is_long else (_LINE if len(states) < MOST_THICK else 0.4, 1.0)
    for body in bodies:
        color, word = (DAMPER, "damper") if body else (STRUCTURE, "structure")
        if not body and scene.grounded:
            word = scene.body
        with matplotlib.rc_context(_IN_PIECES):
            axes.plot(
                states[:, 2 * body], states[:, 2 * body + 1], color=color, linewidth=width,
                alpha=alpha, rasterized=is_long, label=word,
            )  # fmt: skip
    look: dict[str, Any] = {}
    if not 0 < view.period <= LONGEST_PLAIN:
        look = {"linewidth": 0.25, "alpha": 0.35, "zorder": 1}
    for name, u in _boundaries(place).items():
        if scene.grounded:
            axes.axvline(u, label=_words(name), **BOUNDARIES[name])
        elif panel != "phase1":
            with matplotlib.rc_context(_IN_PIECES):
                axes.plot(
                    states[:, 0] + u, states[:, 1], label=_words(name),
                    **{**BOUNDARIES[name], **look, "rasterized": is_long},
                )  # fmt: skip
    n = view.period
    size = _LARGE if 0 < n < _FEW else _SMALL
    for body in bodies:
        points = view.section[-n:, 2 * body : 2 * body + 2].T  # all where n is 0
        axes.plot(*points, color=SECTION, markersize=size, zorder=5, label="$t=nT$", **DOT)
    if panel == "phase":
        axes.set_xlabel("displacement [m]")
        axes.set_ylabel("velocity [m/s]")
    else:
        _label_plane(place, bodies[0])


def _label_plane(place: Place, body: int) -> None:
    axes, symbol = place.axes, "x_2" if body else "x_1" if "x1" in place.scene.components else "x"
    axes.set_xlabel(f"${symbol}$ [m]")
    axes.set_ylabel(rf"$\dot{{{symbol[0]}}}{symbol[1:]}$ [m/s]")
    axes.xaxis.set_major_locator(_ticks(min(6, int(size_of(axes)[0] / _NUMBER))))


# ---- sections ------------------------------------------------------------------------------------


CROWDED = 1500  # points beyond which colors show the density, as single points overlap
_CELLS = 160  # along each side of the plane, in which points are counted
_PALEST = 0.9  # of the color map, whose yellow end is too pale for dots
_LARGE, _SMALL, _SMALLEST = 3.4, 1.7, 0.9  # points, sizes of few, more and many dots
_FEW = 40  # the number of dots below which they are large


def _section(place: Place, request: PortraitRequest) -> None:
    """Draw the stroboscopic section of the damper or the structure at the phase in the request."""
    view, body = place.view, int(place.panel == "section" and place.scene.damper)
    sample = round(request.section_phase * view.samples) % view.samples
    points = view.section_at(sample)[-view.period :, 2 * body : 2 * body + 2]  # all where it is 0
    label = rf"$\phi={sample / view.samples:.3g}$" if sample else "$t=nT$"  # phi in turns
    _scatter(place.axes, points, SECTION, label)
    place.axes.margins(0.06)
    _label_plane(place, body)


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
    many = len(points)
    size = _LARGE if many < _FEW else _SMALL if many < CROWDED else _SMALLEST
    if many < CROWDED or not is_shaded:
        look = {"color": color, "markersize": size, "label": label, **DOT}
        axes.plot(points[:, 0], points[:, 1], rasterized=many > CROWDED, **look)
        return
    # for each point the number of points in its cell of a grid over all points
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    places = ((points - low) / np.where(span > 0, span, 1.0) * _CELLS).astype(int)
    cells = np.minimum(places, _CELLS - 1) @ np.array([1, _CELLS])
    near = np.bincount(cells)[cells]
    order = np.argsort(near, kind="stable")  # dense ones on top
    shades = colormaps[SHADES](np.linspace(0.0, _PALEST, 64))
    shading = LinearSegmentedColormap.from_list("counts", shades)
    axes.scatter(
        points[order, 0], points[order, 1], s=size**2, c=near[order], cmap=shading,
        norm=LogNorm(1.0, max(2.0, float(near.max()))), linewidths=0, rasterized=True,
    )  # fmt: skip
    axes.plot([], [], color=shading(0.5), label=label, **DOT)


# ---- spectra -------------------------------------------------------------------------------------


DEPTH = 100.0  # the range of a spectrum, in decibels below the highest line of its row
LEAST = 1.0e-4  # the relative amplitude above which a line must be visible
SHORTEST, LONGEST = 4, 8  # the bounds of the highest frequency, in multiples of the force's
FINE = 240  # periods above which the curve of a spectrum is thinner, as its bins are close
ZERO = -400.0  # the decibels at which an amplitude of exactly zero is drawn


def _draw_spectrum(place: Place, request: PortraitRequest) -> None:
    view, axes, spectrum = place.view, place.axes, place.view.spectrum
    with np.errstate(divide="ignore"):
        heights = np.maximum(spectrum.decibels(), ZERO)
    width = 0.5 if spectrum.periods <= FINE else 0.3
    axes.plot(spectrum.order[1:], heights[1:], color="black", linewidth=width)
    omega, is_narrow = place.system.parameters["omega"], size_of(axes)[0] < _NARROW
    ratio, force = r"$\Omega/\omega$", rf"$\omega$ = {omega:g} rad/s"
    if request.frequency == HZ:
        ratio, force = "$F/f$", f"$f$ = {omega / (2 * np.pi):g} Hz"
    axes.set_xlabel(f"{ratio}, {force}" if is_narrow else f"frequency [multiples of {force}]")
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
    **dict.fromkeys(OVER_TIME, _over_time),
    **dict.fromkeys(("phase", "phase1", "phase2"), _plane),
    **dict.fromkeys(("section", "section1"), _section),
    "impact-section": _impact_section,
    "spectrum": _draw_spectrum,
    EXPONENTS: _exponents,
}

PICTURE = Picture(panels, draw, fill, usual=lambda view: portrait_in(view.path).drawn_from.panels)
