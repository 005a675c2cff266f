"""The diagram of branches: stable orbits solid, unstable ones dashed, special points marked.

It may lie over the diagram of a scan, whose orbits are dots.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.bifurcation.picture.regime_strip import draw_strip
from nlds_vines.continuation.borders import borders_of
from nlds_vines.continuation.marks import MARKS, WORDS
from nlds_vines.continuation.plane_picture import plane_diagram
from nlds_vines.continuation.result import Branch, Continued, continued
from nlds_vines.errors import RequestError
from nlds_vines.plotting.bands import bands, drawable
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.palette import colours
from nlds_vines.plotting.panels import write_letters, write_title
from nlds_vines.plotting.save import save_drawn
from nlds_vines.plotting.style import (
    CM,
    DOT,
    GREY,
    HUES,
    LEFT,
    NAVY,
    RIGHT,
    WIDTH,
    axis_label,
    quantity_label,
)

_STABLE: dict[str, Any] = {"color": NAVY, "linewidth": 1.1}
_UNSTABLE: dict[str, Any] = {"color": "#6b6b6b", "linewidth": 0.6, "dashes": (4, 2)}
_PANEL, _FOOT, _HEAD = 5.6 * CM, 1.15 * CM, 1.5 * CM  # heights in inches
_NAMES, _STRIP = 2.2 * CM, 0.42 * CM  # of a strip of regimes, and of the names above it
_LEGEND, _LINE = 0.55 * CM, 0.45 * CM  # inches from the upper edge to the legend; a line of it
_COLUMNS = 5  # of the legend
_MARK, _DOT = 4.0, 0.7  # points
_TICK = 0.06  # height of a border's tick, of the panel's


def save(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    over: str | os.PathLike[str] | None = None,
) -> Path:
    """Draw the branches of an archive, save the picture and return the picture's path.

    Arguments: the paths of archive and picture (`plotting.save.save_drawn`); `over`, the archive of
    a scan along the same parameter, whose diagram is drawn beneath.
    """

    return save_drawn(archive_path, plot_path, lambda _: draw_continuation(archive_path, over))


def draw_continuation(
    archive_path: str | os.PathLike[str], over: str | os.PathLike[str] | None = None
) -> Figure:
    """Return the picture of the branches of an archive, or of its curves in a plane; see `save`."""
    found = continued(archive_path)
    draw = branch_diagram if found.request.plane is None else plane_diagram
    if over is None:
        return draw(found)
    with read(over) as scan:
        return draw(found, scan)


@styled()
def branch_diagram(found: Continued, scan: ArchiveView | None = None) -> Figure:
    """Return the diagram of branches: a coordinate of the section, and the energy E1max.

    Arguments: what was `found`; a `scan` along the same parameter, as an open archive.

    Raises `RequestError` for a scan along another parameter.
    """
    name = found.request.along.name
    if scan is not None and scan.axes != (name,):
        raise RequestError(f"{scan.path} varies {', '.join(scan.axes)}, not {name} alone")
    named = scan is not None and "label" in scan
    kinds = [kind for kind in MARKS if kind in found.special.kind]
    handles = _handles(kinds, scan is not None)
    lines = -(-len(handles) // _COLUMNS)  # of the legend; above names of regimes is room for two
    head = _HEAD + (_NAMES + _STRIP if named else _LINE * (lines - 1))
    height = head + 2 * _PANEL + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    grid = {"left": LEFT, "right": RIGHT, "bottom": _FOOT / height, "top": 1 - head / height}
    axes = figure.subplots(2, sharex=True, squeeze=False, gridspec_kw={**grid, "hspace": 0.07})
    panels = list(axes[:, 0])
    component = _component(found)
    for panel in panels:
        panel.tick_params(top=True)
    if scan is not None:
        _draw_scan(panels, found, scan, component)
    _draw_branches(panels, found, component)
    panels[0].set_ylabel(quantity_label(component, "m"))
    panels[1].set_ylabel(quantity_label("E1max", "J"))
    panels[1].set_xlabel(axis_label(name))
    panels[0].set_xlim(found.request.along.low, found.request.along.high)
    if scan is not None and named:
        _draw_strip(figure, panels[0], found, scan)
        _mark_borders(panels[1], found, scan)
    _add_legend(figure, handles)
    write_letters(panels)
    write_title(figure, found.request.title)
    return figure


def _component(found: Continued) -> str:
    """Return the displacement that is drawn: of what meets a wall, if there is one."""
    names = found.request.system.scene.components
    return next(name for name in ("x2", "x", "x1") if name in names)


def _inside(found: Continued, scan: ArchiveView) -> np.ndarray:
    """Tell which cells of a scan lie in the interval; raise `RequestError` where none does."""
    along = found.request.along
    values = scan[along.name]
    inside = (values >= along.low) & (values <= along.high)
    if not inside.any():
        raise RequestError(
            f"{scan.path}: no cell lies within {along.name} from {along.low!r} to {along.high!r}"
        )
    return np.asarray(inside)


def _draw_scan(panels: list[Axes], found: Continued, scan: ArchiveView, component: str) -> None:
    """Draw the orbits of a scan as dots."""
    name = found.request.along.name
    inside = _inside(found, scan)
    values = scan[name][inside]
    dot: dict[str, Any] = {
        "color": HUES["sky"],
        "markersize": _DOT,
        "rasterized": True,
        "zorder": 1,
        **DOT,
    }
    if "section" in scan:
        index = list(scan["component"]).index(component)
        states = scan.take("section", component=index)[inside].reshape(len(values), -1)
        panels[0].plot(np.repeat(values, states.shape[1]), drawable(states).ravel(), **dot)
    if "E1max" in scan:
        energy = drawable(scan["E1max"][inside]).reshape(len(values), -1)
        across = np.repeat(values, energy.shape[1])
        panels[1].plot(across, energy.ravel(), **{**dot, "markersize": 2 * _DOT})


def _draw_branches(panels: list[Axes], found: Continued, component: str) -> None:
    """Draw all branches with their special points."""
    index = found.request.system.scene.components.index(component)
    for branch in found.branches:
        for phase in range(branch.period):
            _draw_curve(panels[0], branch, branch.sections[:, phase, index])
        _draw_curve(panels[1], branch, branch.E1max)
    for row, energy in zip(found.special, found.tables["special_E1max"], strict=True):
        look: dict[str, Any] = {
            "markersize": _MARK,
            "linestyle": "none",
            "markeredgewidth": 0.4,
            "zorder": 5,
        }
        look |= {"markeredgecolor": "white", **MARKS[row.kind]}
        panels[0].plot(row.value, row.state[index], **look)
        panels[1].plot(row.value, energy, **look)


def _draw_curve(panel: Axes, branch: Branch, values: np.ndarray) -> None:
    """Draw one number along a branch: solid between stable points, dashed elsewhere."""
    shown, unstable = drawable(values), ~branch.stable
    dashed = unstable.copy()
    dashed[1:] |= unstable[:-1]
    dashed[:-1] |= unstable[1:]
    panel.plot(branch.parameter, np.where(dashed, shown, np.nan), zorder=2, **_UNSTABLE)
    panel.plot(branch.parameter, np.where(branch.stable, shown, np.nan), zorder=3, **_STABLE)


def _draw_strip(figure: Figure, panel: Axes, found: Continued, scan: ArchiveView) -> None:
    """Draw the strip of a scan's regimes, of its first start, above a panel."""
    height = figure.get_figheight()
    bottom = panel.get_position().y1 + 0.1 * CM / height
    axes = figure.add_axes((LEFT, bottom, RIGHT - LEFT, _STRIP / height), sharex=panel)
    limits, inside = panel.get_xlim(), _inside(found, scan)
    labels = scan.take("label", start=0)[inside]
    draw_strip(axes, bands(scan[scan.axes[0]][inside], labels), colours(labels.tolist()))
    panel.set_xlim(limits)


def _mark_borders(panel: Axes, found: Continued, scan: ArchiveView) -> None:
    """Mark along the foot of a panel what makes the borders of a scan's regimes: a tick for each.

    It has the colour of the special point that ends or begins a regime there, and is grey where
    both orbits live on and the start has only changed basins.
    """
    low, high = panel.get_ylim()
    for border in borders_of(found, scan):
        kinds = [kind for kind, _ in border.events]
        at = [value for _, value in border.events] or [0.5 * (border.low + border.high)]
        colours_here = [MARKS[kind]["color"] for kind in kinds] or [GREY]
        for value, colour in zip(at, colours_here, strict=True):
            panel.vlines(value, low, low + _TICK * (high - low), color=colour, linewidth=0.8)
    panel.set_ylim(low, high)


def _handles(kinds: list[str], over: bool) -> list[Line2D]:
    """Return the entries of the legend: curves, marks of these kinds, the dots of a scan."""
    handles = [
        Line2D([], [], label="stable", **_STABLE),
        Line2D([], [], label="unstable", **_UNSTABLE),
    ]
    mark: dict[str, Any] = {"linestyle": "none", "markersize": _MARK, "markeredgewidth": 0}
    handles += [Line2D([], [], label=f"{k} {WORDS[k]}", **mark, **MARKS[k]) for k in kinds]
    if over:
        dot: dict[str, Any] = {
            "marker": "o",
            "markersize": 2.5,
            "color": HUES["sky"],
            "linestyle": "none",
        }
        handles.append(Line2D([], [], label="scan", **dot))
    return handles


def _add_legend(figure: Figure, handles: list[Line2D]) -> None:
    """Add the legend below the title."""
    place: dict[str, Any] = {
        "loc": "upper left",
        "bbox_to_anchor": (LEFT, 1 - _LEGEND / figure.get_figheight()),
    }
    figure.legend(handles=handles, ncols=_COLUMNS, columnspacing=1.2, handletextpad=0.4, **place)
