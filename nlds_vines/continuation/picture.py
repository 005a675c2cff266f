"""The diagram of branches: stable orbits solid, unstable ones dashed, special points marked.

It may lie over the diagram of a scan, whose orbits are dots.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.bifurcation.picture.regime_strip import STRIP, draw_strip
from nlds_vines.continuation.marks import MARKS, WORDS
from nlds_vines.continuation.plane_picture import fill_plane, plane_diagram
from nlds_vines.continuation.regime_borders import borders_of
from nlds_vines.continuation.result import Branch, Continued, continued
from nlds_vines.errors import RequestError
from nlds_vines.plotting.bands import Band, bands, drawable
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    new_figure,
    styled,
    write_letters,
)
from nlds_vines.plotting.palette import colors
from nlds_vines.plotting.style import (
    DOT,
    GRAY,
    NAVY,
    axis_label,
    quantity_label,
)

_STABLE: dict[str, Any] = {"color": NAVY, "linewidth": 1.1}
_UNSTABLE: dict[str, Any] = {"color": "#6b6b6b", "linewidth": 0.6, "dashes": (4, 2)}
_PANEL = 1.27  # of the height of a panel of other diagrams
_MARK, _DOT = 4.0, 1.7  # points: dots are wider than the lines that lie over them
_PALE = "#8fd0f4"  # of dots: beneath lines and marks, and seen beside them
_POINT: dict[str, Any] = {
    "linestyle": "none",
    "markersize": _MARK,
    "markeredgewidth": 0.4,
    "markeredgecolor": "white",
    "zorder": 5,
}
_ENERGY = "E1max"
_TICK = 0.06  # height of a border's tick, of the panel's


def picture(over: str | os.PathLike[str] | None = None) -> Picture:
    """Return what draws the archive of a continuation: its branches, or its curves in a plane.

    Arguments: `over`, the archive of a scan along the same parameters, which is drawn beneath.
    """

    def draw(view: ArchiveView, names: Sequence[str], page: Page) -> Figure:
        found = continued(view.path)
        with nullcontext() if over is None else read(over) as scan:
            if found.request.plane is not None:
                return plane_diagram(found, scan, page)
            return branch_diagram(found, scan, page, names)

    return Picture(_panels, draw, _fill_axes)


def _panels(view: ArchiveView) -> dict[str, str]:
    """Return what the panels of an archive's picture show, by name."""
    found = continued(view.path)
    if found.request.plane is None:
        return panels_of(found)
    return {"plane": "curves of special points in the plane of two parameters"}


def _fill_axes(axes: Axes, view: ArchiveView, name: str) -> None:
    found = continued(view.path)
    if found.request.plane is None:
        fill_branches(axes, found, name)
    else:
        fill_plane(axes, found)


PICTURE = picture()
"""What draws the archive of a continuation."""


@styled()
def branch_diagram(
    found: Continued,
    scan: ArchiveView | None = None,
    page: Page = TWO_COLUMNS,
    shown: Sequence[str] = (),
) -> Figure:
    """Return the diagram of branches: a coordinate of the section, and the energy E1max.

    Arguments: what was `found`; a `scan` along the same parameter, as an open archive; the `page`;
    the panels that are `shown`, of `panels_of`, by default all.

    Raises `RequestError` for a scan along another parameter.
    """
    name, shown = found.request.along.name, shown or list(panels_of(found))
    if scan is not None and scan.axes != (name,):
        raise RequestError(f"{scan.path} varies {', '.join(scan.axes)}, not {name} alone")
    regimes = [] if scan is None or "label" not in scan else _regimes(found, scan)
    heights = [STRIP] * bool(regimes) + [_PANEL * page.panel] * len(shown)
    figure, grid = new_figure(page, heights)
    panels: list[Axes] = []
    for quantity in shown:
        place = grid[len(panels) + bool(regimes)]
        panels.append(figure.add_subplot(place, sharex=panels[0] if panels else None))
        _fill(panels[-1], found, quantity, scan)
        panels[-1].tick_params(top=True, labelbottom=len(panels) == len(shown))
    panels[-1].set_xlabel(axis_label(name))
    panels[0].set_xlim(found.request.along.low, found.request.along.high)
    figure.align_ylabels(panels)
    if scan is not None and regimes:
        strip = figure.add_subplot(grid[0], sharex=panels[0])
        draw_strip(strip, regimes, colors(band.label for band in regimes))
        panels[0].set_xlim(found.request.along.low, found.request.along.high)
        _mark_borders(panels[-1], found, scan)
    add_legend(panels[-1], _handles(found, scan is not None, bool(regimes)), "below")
    write_letters(panels)
    finish(figure, grid, found.request.title)
    return figure


def panels_of(found: Continued) -> dict[str, str]:
    """Return what the panels of a diagram show, by name: a displacement, and the energy."""
    component = _component(found)
    return {component: f"{component} at the section [m]", _ENERGY: "largest energy [J]"}


def fill_branches(axes: Axes, found: Continued, name: str) -> None:
    """Draw one panel of a diagram of branches into axes, with its legend."""
    _fill(axes, found, name)
    axes.set_xlabel(axis_label(found.request.along.name))
    axes.set_xlim(found.request.along.low, found.request.along.high)
    axes.legend(handles=_handles(found))


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


def _fill(panel: Axes, found: Continued, name: str, scan: ArchiveView | None = None) -> None:
    """Draw all branches with their special points into a panel, over the dots of a scan."""
    unit, body = "J" if name == _ENERGY else "m", found.request.system.scene.body
    panel.set_ylabel(quantity_label(name, unit, body=body))
    if scan is not None:
        _draw_scan(panel, found, scan, name)
    energy = name == _ENERGY
    index = 0 if energy else found.request.system.scene.components.index(name)
    for branch in found.branches:
        for phase in range(1 if energy else branch.period):
            values = branch.E1max if energy else branch.sections[:, phase, index]
            _draw_curve(panel, branch, values)
    for row, largest in zip(found.special_points, found.tables["special_E1max"], strict=True):
        look = {**_POINT, **MARKS[row.kind]}
        panel.plot(row.value, largest if energy else row.state[index], **look)


def _draw_scan(panel: Axes, found: Continued, scan: ArchiveView, name: str) -> None:
    """Draw the orbits of a scan as dots."""
    inside = _inside(found, scan)
    values = scan[found.request.along.name][inside]
    if name == _ENERGY and name in scan:
        states = scan[name][inside]
    elif name != _ENERGY and "section" in scan:
        component = list(scan["component"]).index(name)
        states = scan.take("section", component=component)[inside]
    else:
        return
    rows = drawable(states).reshape(len(values), -1)
    look: dict[str, Any] = {"color": _PALE, "markersize": _DOT, "rasterized": True, **DOT}
    panel.plot(np.repeat(values, rows.shape[1]), rows.ravel(), zorder=1, **look)


def _draw_curve(panel: Axes, branch: Branch, values: np.ndarray) -> None:
    """Draw one number along a branch: solid between stable points, dashed elsewhere."""
    shown, unstable = drawable(values), ~branch.stable
    dashed = unstable.copy()
    dashed[1:] |= unstable[:-1]
    dashed[:-1] |= unstable[1:]
    panel.plot(branch.parameter, np.where(dashed, shown, np.nan), zorder=2, **_UNSTABLE)
    panel.plot(branch.parameter, np.where(branch.stable, shown, np.nan), zorder=3, **_STABLE)


def _regimes(found: Continued, scan: ArchiveView) -> list[Band]:
    """Return the regimes of a scan, of its first start, along the interval."""
    inside = _inside(found, scan)
    return bands(scan[scan.axes[0]][inside], scan.take("label", start=0)[inside])


def _mark_borders(panel: Axes, found: Continued, scan: ArchiveView) -> None:
    """Mark along the foot of a panel what makes the borders of a scan's regimes: a tick for each.

    It has the color of the special point that ends or begins a regime there, and is gray where
    both orbits live on and the start has only changed basins.
    """
    low, high = panel.get_ylim()
    for border in borders_of(found, scan):
        kinds = [kind for kind, _ in border.events]
        at = [value for _, value in border.events] or [0.5 * (border.low + border.high)]
        colors_here = [MARKS[kind]["color"] for kind in kinds] or [GRAY]
        for value, color in zip(at, colors_here, strict=True):
            panel.vlines(value, low, low + _TICK * (high - low), color=color, linewidth=0.8)
    panel.set_ylim(low, high)


def _handles(found: Continued, over: bool = False, borders: bool = False) -> list[Line2D]:
    """Return the entries of the legend: curves, marks of the kinds found, dots, borders of a scan.

    Arguments: what was `found`; whether it lies `over` a scan, and whether `borders` are marked.
    """
    curves = (("stable", _STABLE, False), ("unstable", _UNSTABLE, True))
    handles = [
        Line2D([], [], label=label, **look)
        for label, look, lost in curves
        if any((branch.stable != lost).any() for branch in found.branches)
    ]
    mark: dict[str, Any] = {"linestyle": "none", "markersize": _MARK, "markeredgewidth": 0}
    kinds = [kind for kind in MARKS if kind in found.special_points.kind]
    handles += [Line2D([], [], label=f"{k} {WORDS[k]}", **mark, **MARKS[k]) for k in kinds]
    if over:
        handles.append(Line2D([], [], label="scan", color=_PALE, markersize=3.5, **DOT))
    if borders:
        tick: dict[str, Any] = {"marker": "|", "linestyle": "none", "markersize": 6}
        handles.append(Line2D([], [], label="its regime changes", color=GRAY, **tick))
    return handles
