"""One orbit in full: what each panel of a portrait shows (Figures 9 to 12)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nlds_vines.orbits.signals import (
    contact_forces,
    energy_of_damper,
    energy_of_structure,
    harmonic_force,
    relative_displacement,
)
from nlds_vines.plotting.style import CM, GREEN, STYLE, WIDTH
from nlds_vines.portrait.page_layout import CROWD, LEFT, OVER_TIME, Place, make_page
from nlds_vines.portrait.request import PortraitRequest, panels_of
from nlds_vines.portrait.result import View
from nlds_vines.portrait.spectrum_panel import draw_spectrum, limit_spectra

STRUCTURE, DAMPER, OBSTACLE, FORCE, BLUE = "#7a7a7a", "#000000", "#d55e00", "#0072b2", "#0072b2"
"""Colours of the bodies, near the paper's grey, black and red; of the harmonic force; of E2."""

STRUCK: Mapping[str, dict[str, Any]] = {
    "obstacle": {"color": OBSTACLE, "linewidth": 0.9},
    "structure": {"color": STRUCTURE, "linewidth": 0.9},
    "limit": {"color": OBSTACLE, "linewidth": 0.8, "linestyle": (0, (4, 2))},
}
"""How what the damper strikes, or must not reach, is drawn."""

MOST_VECTOR = 40_000
"""The most states of a curve that vector formats hold as a path; a longer one becomes dots."""

MOST_THICK = 8_000
"""States of a curve from which it is drawn thinner."""

PLAIN = 6
"""The longest period n whose phase plane also shows the motion of what the damper strikes: of a
longer one, the curves would hide each other."""

TANGLED = 160
"""The most forcing periods of a phase trajectory: more of a tangle is only ink."""

_THIN = 0.8


@matplotlib.rc_context(STYLE)
def portrait(request: PortraitRequest, views: Sequence[View]) -> Figure:
    """Return the page of a request, drawn from the views of its columns.

    Time histories begin with the window and are at most `request.show` periods long.  Phase planes
    hold one cycle of a periodic orbit, up to `TANGLED` periods of any other.  Values of one row
    share their scale, phase planes excepted.
    """
    figure, rows = make_page(request.panels, views)
    for row in rows:
        for place in row:
            if place.panel in panels_of([place.view.column.system.scene]):
                _PANELS[place.panel](place, request)
                _finish(place, row, request)
            else:
                place.axes.set_axis_off()
        _leave_room(row)
        if row[0].panel == "spectrum":
            limit_spectra(row)
    tall = figure.get_figheight() / CM
    figure.text(LEFT * CM / WIDTH, 1 - 0.2 / tall, request.title, va="top")
    for place in rows[0]:
        if place.first or len(views) > 1:
            left, bottom = place.axes.get_position().x0, place.axes.get_position().y1 + 0.12 / tall
            heading = _heading(place.view, "\n" if len(views) > CROWD else ", ")
            figure.text(left, bottom, heading, va="bottom", fontsize=8)
    return figure


def _heading(view: View, joint: str) -> str:
    begin, end = view.column.window
    label = view.label if view.period else "no period found"
    return f"{view.column.name or label}{joint}periods {begin} to {end}"


def _finish(place: Place, row: Sequence[Place], request: PortraitRequest) -> None:
    """Add axis of time, legend and ticks that all panels have in common."""
    axes = place.axes
    axes.tick_params(top=True, right=True)
    axes.yaxis.set_major_locator(_ticks(5))
    if place.panel in OVER_TIME:
        if axes.xaxis.get_tick_params()["labelbottom"]:
            words = "" if len(row) > CROWD else "time "
            axes.set_xlabel(f"{words}$t/T$ [forcing periods]")
        begin, end = place.view.column.window
        axes.set_xlim(begin, min(end, begin + request.show))
        axes.xaxis.set_major_locator(_ticks(12 // len(row), integer=True))
    if not place.first and not place.panel.startswith("phase"):
        axes.set_ylabel("")
    if place.last and axes.get_legend_handles_labels()[1]:
        axes.legend(
            loc="upper left", bbox_to_anchor=(1.0, 1.04), frameon=False, handlelength=1.1,
            handletextpad=0.5, borderaxespad=0.4, borderpad=0.2, labelspacing=0.35,
        )  # fmt: skip


def _ticks(most: int, integer: bool = False) -> MaxNLocator:
    """Return the rule for ticks at round numbers, at `most` so many intervals."""
    return MaxNLocator(most, integer=integer, steps=[1, 2, 5, 10])


def _shown(view: View, request: PortraitRequest) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return periods, times [s] and states of what a time history shows."""
    count = request.show * view.samples
    time = view.time[:count]
    return time / view.column.system.period, time, view.states[:count]


def _over_time(place: Place, label: str, curves: Iterable[tuple[Any, Any, dict[str, Any]]]) -> None:
    for across, values, look in curves:
        place.axes.plot(across, values, **{"linewidth": _THIN, **look})
    place.axes.set_ylabel(label)


def _bodies(place: Place, request: PortraitRequest, column: int, symbol: str, label: str) -> None:
    """Draw one component of structure and damper over time."""
    across, _, states = _shown(place.view, request)
    curves = [(across, states[:, column], {"color": STRUCTURE, "label": f"${symbol}_1$"})]
    if place.view.column.system.scene.damper:
        curves.append((across, states[:, column + 2], {"color": DAMPER, "label": f"${symbol}_2$"}))
    _over_time(place, label, curves)


def _struck(view: View) -> Mapping[str, float]:
    """Return where what the damper strikes is drawn, as x2 - x1 [m]; not the structure itself."""
    system = view.column.system
    return {name: float(u) for name, u in system.scene.obstacle(system.parameters).items()}


def _displacement(place: Place, request: PortraitRequest) -> None:
    _bodies(place, request, 0, "x", "displacement [m]")
    across, _, states = _shown(place.view, request)
    for name, u in _struck(place.view).items():
        if name != "structure":
            place.axes.plot(across, states[:, 0] + u, label=name, **STRUCK[name])


def _velocity(place: Place, request: PortraitRequest) -> None:
    _bodies(place, request, 1, r"\dot{x}", "velocity [m/s]")


def _relative(place: Place, request: PortraitRequest) -> None:
    across, _, states = _shown(place.view, request)
    u = relative_displacement(place.view.column.system, states)
    look = {"color": DAMPER, "label": "$x_2-x_1$"}
    _over_time(place, "$x_2-x_1$ [m]", [(across, u, look)])
    for name, height in _struck(place.view).items():
        place.axes.axhline(height, label=name, **STRUCK[name])


def _force(place: Place, request: PortraitRequest) -> None:
    across, time, states = _shown(place.view, request)
    system = place.view.column.system
    outer = harmonic_force(system, time) / 1000
    harmonic = {"color": FORCE, "linestyle": (0, (3, 1.5)), "label": r"$P\,\cos\,\omega t$"}
    curves: list[tuple[Any, Any, dict[str, Any]]] = [(across, outer, harmonic)]
    found = contact_forces(system, states)
    for name, values in found.items():
        label = name if len(found) > 1 else "contact"
        curves.append((across, values / 1000, {**STRUCK[name], "label": label}))
    _over_time(place, "force [kN]", curves)


def _energy(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "energy [J]", (1, 2))


def _energy1(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "$E_1$ [J]", (1,))


def _energy2(place: Place, request: PortraitRequest) -> None:
    _energies(place, request, "$E_2$ [J]", (2,))


def _energies(place: Place, request: PortraitRequest, label: str, bodies: tuple[int, ...]) -> None:
    across, _, states = _shown(place.view, request)
    system, curves = place.view.column.system, []
    if 1 in bodies:
        found = energy_of_structure(system, states)
        curves.append((across, found, {"color": GREEN, "label": "$E_1$"}))
    if 2 in bodies and system.scene.damper:
        found = energy_of_damper(system, states)
        curves.append((across, found, {"color": BLUE, "label": "$E_2$"}))
    _over_time(place, label, curves)
    place.axes.set_ylim(bottom=0)


def _closed(view: View) -> np.ndarray:
    """Return the states of one cycle, with the one before so that a periodic curve closes."""
    return view.states[-(min(view.cycle, TANGLED) * view.samples + 1) :]


def _curve(axes: Axes, across: np.ndarray, values: np.ndarray, colour: str, label: str) -> None:
    """Draw a phase trajectory, thinner the longer it is, and so long a one as dots."""
    long = across.size > MOST_VECTOR
    width, alpha = (0.25, 0.6) if long else (_THIN if across.size < MOST_THICK else 0.4, 1.0)
    # a path of this length exceeds the memory of the raster engine in one piece
    with matplotlib.rc_context({"agg.path.chunksize": 10_000}):
        axes.plot(
            across, values, color=colour, linewidth=width, alpha=alpha, rasterized=long, label=label
        )


def _points(place: Place, body: int) -> None:
    """Draw the stroboscopic section of a body: n points of an nT orbit, all of any other."""
    section, n = place.view.section, place.view.period
    size = 3.4 if 0 < n < 40 else 1.7
    look: dict[str, Any] = {"marker": "o", "markeredgewidth": 0, "linestyle": "none"}
    points = section[-n:, 2 * body], section[-n:, 2 * body + 1]  # all where n is 0
    place.axes.plot(*points, color=OBSTACLE, markersize=size, zorder=5, label="$t=nT$", **look)


def _plane(axes: Axes, symbol: str) -> None:
    axes.set_xlabel(f"${symbol}$ [m]")
    axes.set_ylabel(rf"$\dot{{{symbol[0]}}}{symbol[1:]}$ [m/s]")
    axes.xaxis.set_major_locator(_ticks(6))


def _phase(place: Place, request: PortraitRequest) -> None:
    states, axes = _closed(place.view), place.axes
    _curve(axes, states[:, 0], states[:, 1], STRUCTURE, "structure")
    if place.view.column.system.scene.damper:
        _curve(axes, states[:, 2], states[:, 3], DAMPER, "damper")
    _struck_planes(place, states)
    axes.set_xlabel("displacement [m]")
    axes.set_ylabel("velocity [m/s]")


def _phase1(place: Place, request: PortraitRequest) -> None:
    states = _closed(place.view)
    _curve(place.axes, states[:, 0], states[:, 1], STRUCTURE, "structure")
    _points(place, 0)
    _plane(place.axes, "x_1")


def _phase2(place: Place, request: PortraitRequest) -> None:
    states = _closed(place.view)
    _curve(place.axes, states[:, 2], states[:, 3], DAMPER, "damper")
    _struck_planes(place, states)
    _points(place, 1)
    _plane(place.axes, "x_2")


def _struck_planes(place: Place, states: np.ndarray) -> None:
    """Draw the motion of what the damper strikes, x1 + u, in its phase plane."""
    if not 0 < place.view.period <= PLAIN:
        return
    for name, u in _struck(place.view).items():
        place.axes.plot(states[:, 0] + u, states[:, 1], label=name, **STRUCK[name])


def _leave_room(row: Sequence[Place]) -> None:
    """Leave room for the letters above what panels over time show."""
    if row[0].panel in OVER_TIME:
        low, high = row[0].axes.get_ylim()
        row[0].axes.set_ylim(low, high + 0.28 * (high - low))


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
    "spectrum": draw_spectrum,
}
