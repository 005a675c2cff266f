"""The figures of one orbit: histories, force, phase planes, sections, spectrum, multipliers.

Each reads one of the arrays of `live_orbit.panels`, held in a source of the same name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    CustomJSTickFormatter,
    DataRange1d,
    Range1d,
    Span,
)

from nlds_vines.explore.histories import Arrays
from nlds_vines.explore.live_orbit import has
from nlds_vines.explore.page_elements import plain_figure, roled
from nlds_vines.model.system import System

WIDE = {
    "displacement": True, "relative": True, "force": True, "phase1": False, "phase2": False,
    "touches": False, "spectrum": False, "multipliers": False,
}  # fmt: skip
"""The figures in their order, and whether each is as wide as the page."""

_TIME, _PLANE, _LOW = 132, 230, 196  # heights in pixels
_CIRCLE = 140  # pixels, of the plane of multipliers, which is square

Sources = Mapping[str, ColumnDataSource]


def orbit_sources(system: System) -> dict[str, ColumnDataSource]:
    """Return the sources of all figures by name, empty; the models are called `history data` ..."""
    history = ["t", "x1", "v1", "force", "harmonic"]
    section = ["x1", "v1"]
    if system.scene.damper:
        history += ["x2", "u"]
        section += ["x2", "v2"]
    names = {
        "history": history, "phase1": ["x", "v"], "phase2": ["x", "v"], "section": section,
        "touches": ["phase", *system.scene.walls],
        "spectrum": ["order", "amplitude"], "multipliers": ["re", "im"],
    }  # fmt: skip
    return {
        source: ColumnDataSource({name: np.empty(0) for name in columns}, name=f"{source} data")
        for source, columns in names.items()
    }


def joined(panels: Mapping[str, Arrays]) -> tuple[list[list[Any]], np.ndarray]:
    """Return all arrays of an orbit as one, so that a browser gets them in one message.

    Returns where each stands, (source, column, first, stop), and the values as float32.
    """
    layout: list[list[Any]] = []
    pieces = []
    place = 0
    for source, columns in panels.items():
        for name, values in columns.items():
            layout.append([f"{source} data", name, place, place + len(values)])
            pieces.append(values)
            place += len(values)
    with np.errstate(over="ignore"):
        return layout, np.concatenate(pieces).astype(np.float32)


def orbit_figures(system: System, sources: Sources) -> list[Any]:
    """Return the figures that a system can fill, in the order of `WIDE`.

    Arguments: the system; the `sources` of `orbit_sources`.
    """
    known, walls = has(system), system.scene.obstacle(system.parameters).values()
    figures = [_displacement(system, sources, walls)]
    if "relative" in known:
        figures.append(_relative(sources, walls))
    if "force" in known:
        figures.append(_force(sources))
    for other in figures[1:]:
        other.x_range = figures[0].x_range
    figures.append(_phase(system, sources, "phase1"))
    if "phase2" in known:
        figures.append(_phase(system, sources, "phase2"))
    if "impact-section" in known:
        figures.append(_touches(system, sources))
    return [*figures, _spectrum(sources), _multipliers(sources)]


def symbols(system: System) -> tuple[str, str]:
    """Return how the displacement and the velocity of the structure are called."""
    return ("x₁", "ẋ₁") if "x1" in system.scene.components else ("x", "ẋ")


def _displacement(system: System, sources: Sources, walls: Iterable[float]) -> Any:
    made = plain_figure("displacement", _TIME, x_range=DataRange1d(range_padding=0))
    first = symbols(system)[0]
    line = made.line("t", "x1", source=sources["history"], line_width=1.3)
    roled(line, "body" if system.scene.damper else "ink")
    label = f"{first} [m]"
    if system.scene.damper:
        roled(made.line("t", "x2", source=sources["history"], line_width=1.3), "ink")
        label = f"{first}, x₂ [m]"
    if system.scene.grounded:
        _add_walls(made, walls)
    made.yaxis.axis_label = label
    if "force" not in has(system):
        made.xaxis.axis_label = "t / T [forcing periods]"
    return made


def _relative(sources: Sources, walls: Iterable[float]) -> Any:
    made = plain_figure("relative", _TIME)
    roled(made.line("t", "u", source=sources["history"], line_width=1.3), "ink")
    _add_walls(made, walls)
    made.yaxis.axis_label = "x₂ − x₁ [m]"
    return made


def _add_walls(made: Any, walls: Iterable[float]) -> None:
    """Add a line for each thing that is struck; its place follows the parameters."""
    for i, u in enumerate(walls):
        line = Span(location=float(u), dimension="width", line_width=1.5, name=f"wall {i}")
        made.add_layout(roled(line, "wall"))


def walls_of(figures: Iterable[Any]) -> list[list[Any]]:
    """Return the lines of each thing that is struck, in the order of the scene's obstacles."""
    found: dict[str, list[Any]] = {}
    for line in (line for made in figures for line in made.center if line.name):
        found.setdefault(line.name, []).append(line)
    return list(found.values())


def _force(sources: Sources) -> Any:
    made = plain_figure("force", _TIME)
    roled(made.line("t", "harmonic", source=sources["history"], line_width=1.0), "blue")
    roled(made.line("t", "force", source=sources["history"], line_width=1.3), "ink")
    made.yaxis.axis_label = "force [kN]"
    made.yaxis.formatter = CustomJSTickFormatter(code="return String(tick / 1000)")
    made.xaxis.axis_label = "t / T [forcing periods]"
    return made


def _phase(system: System, sources: Sources, name: str) -> Any:
    """Return a phase plane with the section; a click there begins a new orbit."""
    made = plain_figure(name, _PLANE, tools="tap,pan,wheel_zoom,reset,save")
    x, v = ("x1", "v1") if name == "phase1" else ("x2", "v2")
    line = made.line("x", "v", source=sources[name], line_width=0.9, line_alpha=0.8)
    roled(line, "body" if name == "phase1" and system.scene.damper else "ink")
    line.nonselection_glyph = None
    dots = made.scatter(x, v, source=sources["section"], size=5, line_color=None)
    roled(dots, "wall").nonselection_glyph = None
    first = symbols(system) if name == "phase1" else ("x₂", "ẋ₂")
    made.xaxis.axis_label, made.yaxis.axis_label = f"{first[0]} [m]", f"{first[1]} [m/s]"
    made.xaxis.ticker.desired_num_ticks = 4
    code = f"EXPLORE.ask('plane', {{plane: '{name}', x: cb_obj.x, v: cb_obj.y}})"
    made.js_on_event("tap", CustomJS(code=code))
    return made


def _touches(system: System, sources: Sources) -> Any:
    """Return the section at impact: the speed over the phase of the force, by wall."""
    made = plain_figure("touches", _PLANE, x_range=Range1d(0.0, 2 * np.pi))
    names, walls = system.scene.bodies_struck, system.scene.walls
    for wall, role in zip(reversed(walls), ("wall", "blue"), strict=False):
        dots = made.scatter("phase", wall, source=sources["touches"], size=5, line_color=None)
        roled(dots, role)
    first = f"; {names[0]} in blue" if len(names) > 1 else ""
    made.xaxis.axis_label = f"phase at touch φ [rad]{first}"
    made.yaxis.axis_label = "approach speed [m/s]"
    return made


def _spectrum(sources: Sources) -> Any:
    made = plain_figure("spectrum", _LOW, y_axis_type="log")
    made.x_range = DataRange1d(range_padding=0)
    roled(made.line("order", "amplitude", source=sources["spectrum"], line_width=1.0), "ink")
    made.xaxis.axis_label, made.yaxis.axis_label = "frequency / ω", "amplitude"
    made.yaxis.ticker.desired_num_ticks = 4
    return made


def _multipliers(sources: Sources) -> Any:
    """Return the unit circle with the multipliers in it."""
    ends = (-1.25, 1.25)
    made = plain_figure(
        "multipliers", _LOW, x_range=Range1d(*ends), y_range=Range1d(*ends), sizing_mode="fixed",
        frame_width=_CIRCLE, frame_height=_CIRCLE,
    )  # fmt: skip
    angle = np.linspace(0, 2 * np.pi, 181)
    roled(made.line(np.cos(angle), np.sin(angle), line_width=1.2), "muted")
    dots = made.scatter("re", "im", source=sources["multipliers"], size=8, line_color=None)
    roled(dots, "wall")
    made.xaxis.axis_label, made.yaxis.axis_label = "Re μ", "Im μ"
    return made
