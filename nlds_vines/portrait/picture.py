"""The picture of one orbit in full: what each panel of a portrait shows (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.signals import (
    contact_forces,
    energy_of_damper,
    energy_of_structure,
    harmonic_force,
    relative_displacement,
)
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.page import TWO_COLUMNS, Page, size_of, styled
from nlds_vines.plotting.panels import write_title
from nlds_vines.plotting.style import CM, DOT, GREEN, HUES
from nlds_vines.portrait.page_layout import (
    CROWD,
    LEFT,
    OVER_TIME,
    Place,
    fit_forces,
    make_page,
    write_letters,
)
from nlds_vines.portrait.request import PANELS, PLANES, PortraitRequest, panels_of
from nlds_vines.portrait.result import portrait_in
from nlds_vines.portrait.section_panels import draw_impact_section, draw_section
from nlds_vines.portrait.spectrum_panel import draw_spectrum, limit_spectra
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
_LINE = 0.8  # points, width of a curve
_FEW_POINTS = 3.4  # points, size of the points of a section
_MANY_POINTS = 40  # points of a section from which they are drawn smaller


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
        limit_spectra([place])


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
    figure, rows = make_page(request.panels, views, page)
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
            limit_spectra(row)
    write_letters(rows, len(views) > 1)
    write_title(figure, request.title, LEFT * CM / page.width)
    many = page.beside and len(views) > CROWD
    named = [place for place in rows[0] if place.first or len(views) > 1]
    for place in [*named, *(place for row in rows[1:] for place in row if place.alone)]:
        box, gap = place.axes.get_position(), 0.12 * CM / figure.get_figheight()
        heading = _heading(place.view, "\n" if many else ", ")
        figure.text(box.x0, box.y1 + gap, heading, va="bottom", fontsize=8)
    return figure


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
        if axes.xaxis.get_tick_params()["labelbottom"]:
            words = "" if len(row) > CROWD else "time "
            axes.set_xlabel(f"{words}$t/T$ [forcing periods]")
        begin, end = place.view.column.window
        axes.set_xlim(begin, min(end, begin + request.show))
        axes.xaxis.set_major_locator(_ticks(ceil(_TIMES * size_of(axes)[0]), integer=True))
    if not (place.first or place.alone or place.panel in PLANES):
        axes.set_ylabel("")
    entries = _entries(row)
    if place.last and entries:
        axes.legend(
            entries.values(), entries, loc="upper left", bbox_to_anchor=(1.0, 1.04),
            handlelength=1.1, handletextpad=0.5, borderaxespad=0.4, borderpad=0.2,
            labelspacing=0.35,
        )  # fmt: skip


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
    shown.set(markersize=max(line.get_markersize(), _FEW_POINTS))
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
    axes.xaxis.set_major_locator(_ticks(6))


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
    draw_section(place, request, 1, SECTION)
    _label_plane(place.axes, "x_2")


def _section1(place: Place, request: PortraitRequest) -> None:
    draw_section(place, request, 0, SECTION)
    _label_plane(place.axes, _symbol_1(place.view.column.system.scene))


def _impact_section(place: Place, request: PortraitRequest) -> None:
    struck = place.view.column.system.scene.struck.values()
    looks = {name: {"color": BOUNDARIES[name]["color"], "label": _words(name)} for name in struck}
    draw_impact_section(place, request, looks)


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
    "spectrum": draw_spectrum,
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
