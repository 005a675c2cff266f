"""Pictures of branches, and of curves of special points in a plane, also over those of a scan."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, Stroke

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.bifurcation.picture.choices import REGIMES
from nlds_vines.bifurcation.picture.diagram import STRIP, draw_strip
from nlds_vines.bifurcation.picture.maps import fill_map, name_regimes
from nlds_vines.continuation.regime_borders import borders_of
from nlds_vines.continuation.result import MARKS, WORDS, Continued, read_continuation
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
from nlds_vines.plotting.style import DOT, GRAY, NAVY, axis_label, quantity_label

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
    """Return the picture of a continuation's archive, over that of a scan along its parameters."""

    def draw(view: ArchiveView, names: Sequence[str], page: Page) -> Figure:
        result = read_continuation(view.path)
        with nullcontext() if over is None else read(over) as scan:
            if result.request.plane is not None:
                return plane_diagram(result, scan, page)
            return branch_diagram(result, scan, page, names)

    return Picture(lambda view: panels_of(read_continuation(view.path)), draw, _fill_axes)


def _fill_axes(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel of a diagram, or the plane, into axes, with its legend."""
    result = read_continuation(view.path)
    if result.request.plane is None:
        _fill(axes, result, name)
        axes.set_xlabel(axis_label(result.request.along.name))
        axes.set_xlim(result.request.along.low, result.request.along.high)
        axes.legend(handles=_handles(result))
        return
    _fill_plane(axes, result)
    axes.legend(handles=_plane_handles(result))


PICTURE = picture()  # of a continuation without a scan


@styled()
def branch_diagram(
    result: Continued,
    scan: ArchiveView | None = None,
    page: Page = TWO_COLUMNS,
    shown: Sequence[str] = (),
) -> Figure:
    """Return the diagram of branches over an open `scan`, with the panels `shown` or all."""
    name, shown = result.request.along.name, shown or list(panels_of(result))
    borders = [] if scan is None else borders_of(result, scan)
    regimes: list[Band] = []
    if scan is not None and "label" in scan:
        inside = _inside(result, scan)
        regimes = bands(scan[name][inside], scan.take("label", start=0)[inside])
    heights = [STRIP] * bool(regimes) + [_PANEL * page.panel] * len(shown)
    figure, grid = new_figure(page, heights)
    panels: list[Axes] = []
    for quantity in shown:
        place = grid[len(panels) + bool(regimes)]
        panels.append(figure.add_subplot(place, sharex=panels[0] if panels else None))
        _fill(panels[-1], result, quantity, scan)
        panels[-1].tick_params(top=True, labelbottom=len(panels) == len(shown))
    panels[-1].set_xlabel(axis_label(name))
    panels[0].set_xlim(result.request.along.low, result.request.along.high)
    figure.align_ylabels(panels)
    if scan is not None and regimes:
        strip = figure.add_subplot(grid[0], sharex=panels[0])
        draw_strip(strip, [regimes])
        panels[0].set_xlim(result.request.along.low, result.request.along.high)
        # Ticks at the foot mark the borders of regimes, in the color of the special point that ends
        # or begins a regime there; gray if both orbits stay stable and the start changes basins.
        low, high = panels[-1].get_ylim()
        for border in borders:
            ticks = [(value, MARKS[kind]["color"]) for kind, value in border.events]
            for value, color in ticks or [(0.5 * (border.low + border.high), GRAY)]:
                top = low + _TICK * (high - low)
                panels[-1].vlines(value, low, top, color=color, linewidth=0.8)
        panels[-1].set_ylim(low, high)
    add_legend(panels[-1], _handles(result, scan is not None, bool(regimes)), "below")
    write_letters(panels)
    finish(figure, grid, result.request.title)
    return figure


def panels_of(result: Continued) -> dict[str, str]:
    if result.request.plane is not None:
        return {"plane": "curves of special points in the plane of two parameters"}
    names = result.request.system.scene.components
    # of the body that impacts; of a host, the last one
    component = next((one for one in ("x2", "x", "x1") if one in names), names[-2])
    return {component: f"{component} at the section [m]", _ENERGY: "largest energy [J]"}


def _inside(result: Continued, scan: ArchiveView) -> np.ndarray:
    """Return which cells of a scan lie in the interval; `RequestError` if none does."""
    along = result.request.along
    values = scan[along.name]
    inside = (values >= along.low) & (values <= along.high)
    if not inside.any():
        raise RequestError(
            f"{scan.path}: no cell lies within {along.name} from {along.low!r} to {along.high!r}"
        )
    return np.asarray(inside)


def _fill(panel: Axes, result: Continued, name: str, scan: ArchiveView | None = None) -> None:
    """Draw all branches with their special points, over the dots of a scan, into a panel."""
    unit, body = "J" if name == _ENERGY else "m", result.request.system.scene.body
    panel.set_ylabel(quantity_label(name, unit, body=body))
    energy = name == _ENERGY
    if scan is not None and (name if energy else "section") in scan:
        inside = _inside(result, scan)
        if energy:
            states = scan[name][inside]
        else:
            component = list(scan["component"]).index(name)
            states = scan.take("section", component=component)[inside]
        rows = drawable(states).reshape(len(states), -1)
        values = np.repeat(scan[result.request.along.name][inside], rows.shape[1])
        dots: dict[str, Any] = {"color": _PALE, "markersize": _DOT, "rasterized": True, **DOT}
        panel.plot(values, rows.ravel(), zorder=1, **dots)
    index = 0 if energy else result.request.system.scene.components.index(name)
    for branch in result.branches:
        # solid between stable points, dashed elsewhere
        unstable = ~branch.stable
        dashed = unstable.copy()
        dashed[1:] |= unstable[:-1]
        dashed[:-1] |= unstable[1:]
        for phase in range(1 if energy else branch.period):
            values = drawable(branch.E1max if energy else branch.sections[:, phase, index])
            for look, is_drawn, order in ((_UNSTABLE, dashed, 2), (_STABLE, branch.stable, 3)):
                parts = np.where(is_drawn, values, np.nan)
                panel.plot(branch.parameter, parts, zorder=order, **look)
    for row, largest in zip(result.special_points, result.tables["special_E1max"], strict=True):
        look = {**_POINT, **MARKS[row.kind]}
        panel.plot(row.value, largest if energy else row.state[index], **look)


def _handles(result: Continued, over: bool = False, borders: bool = False) -> list[Line2D]:
    """Return the entries of the legend, with those of a scan `over` which the branches lie."""
    curves = (("stable", _STABLE, False), ("unstable", _UNSTABLE, True))
    handles = [
        Line2D([], [], label=label, **look)
        for label, look, lost in curves
        if any((branch.stable != lost).any() for branch in result.branches)
    ]
    mark: dict[str, Any] = {"linestyle": "none", "markersize": _MARK, "markeredgewidth": 0}
    kinds = [kind for kind in MARKS if kind in result.special_points.kind]
    handles += [Line2D([], [], label=f"{k} {WORDS[k]}", **mark, **MARKS[k]) for k in kinds]
    if over:
        handles.append(Line2D([], [], label="scan", color=_PALE, markersize=3.5, **DOT))
    if borders:
        tick: dict[str, Any] = {"marker": "|", "linestyle": "none", "markersize": 6}
        handles.append(Line2D([], [], label="its regime changes", color=GRAY, **tick))
    return handles


# ---- curves in the plane of two parameters ----

# The dashes of a curve by n of nT; of any other n, those of 8.
_DASHES = {1: (), 2: (4, 1.5), 4: (4, 1.5, 1, 1.5), 8: (1, 1.5)}

# A white outline, so that curves are legible over a map.
_HALO = [Stroke(linewidth=2.2, foreground="white"), Normal()]

_SIZE = 7  # points, of the names of meetings


@styled()
def plane_diagram(
    result: Continued, scan: ArchiveView | None = None, page: Page = TWO_COLUMNS
) -> Figure:
    """Return the curves of a continuation in their plane, over the map of an open `scan`."""
    assert result.request.plane is not None
    names = (result.request.along.name, result.request.plane.name)
    if scan is not None and set(scan.axes) != set(names):
        raise RequestError(f"{scan.path} varies {', '.join(scan.axes)}, not {names[0]}, {names[1]}")
    figure, grid = new_figure(page, [page.map_height])
    axes = figure.add_subplot(grid[0])
    _fill_plane(axes, result, scan)
    if handles := _plane_handles(result):
        add_legend(axes, handles, "above", handlelength=2.2)
    finish(figure, grid, result.request.title)
    if scan is not None:
        name_regimes(axes, scan)
    return figure


def _fill_plane(axes: Axes, result: Continued, scan: ArchiveView | None = None) -> None:
    """Draw all curves and the meetings on them, over the map of a scan, into axes."""
    along, plane = result.request.free
    if scan is None:
        across = 0  # the number of the horizontal parameter
        axes.set(xlim=(along.low, along.high), xlabel=axis_label(along.name))
        axes.set(ylim=(plane.low, plane.high), ylabel=axis_label(plane.name))
    else:
        across = [along.name, plane.name].index(scan.axes[0])
        fill_map(axes, scan, REGIMES)
    limits = axes.get_xlim(), axes.get_ylim()
    halo = [Stroke(linewidth=1.8, foreground="white"), Normal()]
    for curve in result.curves:
        x, y = curve.values[:, across], curve.values[:, 1 - across]
        axes.plot(x, y, path_effects=_HALO, zorder=4, **_look(curve.kind, curve.period))
        for name, *values in curve.meetings:
            place = values[across], values[1 - across]
            axes.plot(*place, **{**_POINT, "marker": "o", "color": "black", "zorder": 6})
            look: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": True}
            look |= {"fontsize": _SIZE, "path_effects": halo, "zorder": 7}
            axes.annotate(name, place, (3, 3), **look)
    axes.set(xlim=limits[0], ylim=limits[1])


def _look(kind: str, n: int) -> dict[str, Any]:
    look: dict[str, Any] = {"color": MARKS[kind]["color"], "linewidth": 1.1}
    dashes = _DASHES.get(n, _DASHES[8])
    return look | ({"dashes": dashes} if dashes else {})


def _plane_handles(result: Continued) -> list[Line2D]:
    handles = []
    for kind, n in dict.fromkeys((curve.kind, curve.period) for curve in result.curves):
        label = f"{kind} of {'T' if n == 1 else f'{n}T'} ({WORDS[kind]})"
        handles.append(Line2D([], [], label=label, **_look(kind, n)))
    return handles
