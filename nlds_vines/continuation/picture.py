"""Pictures of branches, and of curves of special points in a plane, also over those of a scan."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
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
from nlds_vines.continuation.branch_panels import (
    MULTIPLIERS,
    PLANE,
    SECTION,
    Panel,
    names_of,
    panels_of,
    usual_panels,
)
from nlds_vines.continuation.regime_borders import borders_of
from nlds_vines.continuation.result import MARKS, STOPS, WORDS, Branch, Continued, read_continuation
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
from nlds_vines.plotting.style import DOT, GRAY, HUES, NAVY, axis_label

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
# the frame of a grazing, inside which there is room for a mark that coincides with it
_FRAME_WIDTH = 0.8
_FRAME: dict[str, Any] = {
    "markerfacecolor": "none", "markersize": 6.0, "markeredgewidth": _FRAME_WIDTH
}  # fmt: skip
_STAR: dict[str, Any] = {"markersize": 8, "markeredgecolor": NAVY}
_STOP: dict[str, Any] = {
    "linestyle": "none", "color": "#444444", "markersize": 5, "markeredgewidth": 1.0, "zorder": 4
}  # fmt: skip
_MULTIPLIERS: dict[str, dict[str, Any]] = {
    r"$\mu > 0$": {"color": HUES["green"], "linewidth": 0.9},
    r"$\mu < 0$": {"color": HUES["vermillion"], "linewidth": 0.9},
    r"$\mu$ complex": {"color": HUES["blue"], "linewidth": 0.9},
}
# the largest modulus up to which their axis is linear, and the least on a logarithmic one
_MOST_LINEAR, _LEAST_MODULUS = 10.0, 1e-2
_TICK = 0.06  # height of a border's tick, of the panel's


def picture(over: str | os.PathLike[str] | None = None) -> Picture:
    """Return the picture of a continuation's archive, over that of a scan along its parameters."""

    def draw(view: ArchiveView, names: Sequence[str], page: Page) -> Figure:
        result = read_continuation(view.path)
        with nullcontext() if over is None else read(over) as scan:
            if result.request.plane is not None:
                return plane_diagram(result, scan, page)
            return branch_diagram(result, scan, page, names)

    def names(view: ArchiveView) -> dict[str, str]:
        return names_of(read_continuation(view.path).request)

    def usual(view: ArchiveView) -> list[str]:
        request = read_continuation(view.path).request
        return usual_panels(request) if request.plane is None else [PLANE]

    return Picture(names, draw, _fill_axes, usual)


def _fill_axes(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel of a diagram, or the plane, into axes, with its legend."""
    result = read_continuation(view.path)
    if result.request.plane is None:
        panel = panels_of(result.request)[name]
        _fill(axes, result, panel)
        axes.set_xlabel(axis_label(result.request.along.name))
        axes.set_xlim(result.request.along.low, result.request.along.high)
        axes.legend(handles=_handles(result, [panel]))
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
    name, every = result.request.along.name, panels_of(result.request)
    drawn = [every[word] for word in shown or usual_panels(result.request)]
    borders = [] if scan is None else borders_of(result, scan)
    regimes: list[Band] = []
    if scan is not None and "label" in scan:
        inside = _inside(result, scan)
        regimes = bands(scan[name][inside], scan.take("label", start=0)[inside])
    heights = [STRIP] * bool(regimes) + [_PANEL * page.panel] * len(drawn)
    figure, grid = new_figure(page, heights)
    panels: list[Axes] = []
    for panel in drawn:
        place = grid[len(panels) + bool(regimes)]
        panels.append(figure.add_subplot(place, sharex=panels[0] if panels else None))
        _fill(panels[-1], result, panel, scan)
        panels[-1].tick_params(top=True, labelbottom=len(panels) == len(drawn))
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
    add_legend(panels[-1], _handles(result, drawn, scan is not None, bool(regimes)), "below")
    write_letters(panels)
    finish(figure, grid, result.request.title)
    return figure


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


def _fill(axes: Axes, result: Continued, panel: Panel, scan: ArchiveView | None = None) -> None:
    """Draw all branches with their special points, over the dots of a scan, into a panel."""
    axes.set_ylabel(panel.label(result.request.system.scene.body))
    if scan is not None:
        _fill_scan(axes, result, panel, scan)
    if panel.dataset == MULTIPLIERS:
        _fill_multipliers(axes, result, panel)
    else:
        for branch in result.branches:
            _fill_branch(axes, branch, panel)
    for one in result.request.monitors:
        if one.name == panel.name:
            for value in one.values or (0.0,):
                axes.axhline(value, color=GRAY, linewidth=0.6, linestyle=(0, (1, 2)), zorder=1)
    for number, row in enumerate(result.special_points):
        look = _look_of(row.kind)
        for value in drawable(panel.at_special(result, number)):
            axes.plot(row.value, value, **look)
    for branch in result.branches:
        curves = drawable(panel.along(branch))
        for point, end in ((0, branch.ends[0]), (-1, branch.ends[1])):
            if end in STOPS:
                there = np.full(len(curves), branch.parameter[point])
                axes.plot(there, curves[:, point], **_STOP, marker=STOPS[end])


def _fill_scan(axes: Axes, result: Continued, panel: Panel, scan: ArchiveView) -> None:
    """Draw the dots of a scan that has recorded the quantity of a panel."""
    is_section = panel.dataset == SECTION
    if (panel.dataset if is_section else panel.name) not in scan:
        return
    inside = _inside(result, scan)
    if is_section:
        component = list(scan["component"]).index(panel.name)
        states = scan.take("section", component=component)[inside]
    else:
        states = scan[panel.name][inside]
    rows = drawable(states).reshape(len(states), -1)
    values = np.repeat(scan[result.request.along.name][inside], rows.shape[1])
    dots: dict[str, Any] = {"color": _PALE, "markersize": _DOT, "rasterized": True, **DOT}
    axes.plot(values, rows.ravel(), zorder=1, **dots)


def _fill_branch(axes: Axes, branch: Branch, panel: Panel) -> None:
    """Draw the curves of a branch, solid between stable points, dashed elsewhere."""
    dashed = _with_neighbors(~branch.stable)
    for values in drawable(panel.along(branch)):
        for look, is_drawn, order in ((_UNSTABLE, dashed, 2), (_STABLE, branch.stable, 3)):
            parts = np.where(is_drawn, values, np.nan)
            axes.plot(branch.parameter, parts, zorder=order, **look)


def _fill_multipliers(axes: Axes, result: Continued, panel: Panel) -> None:
    """Draw the moduli of multipliers, in the color of what happens where they are one."""
    largest = 1.0
    for branch in result.branches:
        mu = branch.multipliers
        is_real = mu.imag == 0.0
        for look, which in zip(
            _MULTIPLIERS.values(),
            (is_real & (mu.real >= 0.0), is_real & (mu.real < 0.0), ~is_real),
            strict=True,
        ):
            for values, is_drawn in zip(panel.along(branch), which.T, strict=True):
                # a pair of real multipliers becomes a complex one between two points
                parts = np.where(_with_neighbors(is_drawn), drawable(values), np.nan)
                axes.plot(branch.parameter, parts, zorder=2, **look)
        largest = max(largest, float(np.abs(mu).max(initial=1.0)))
    axes.axhline(1.0, color=GRAY, linewidth=0.6, zorder=1)
    if largest > _MOST_LINEAR:
        axes.set_yscale("log")
        axes.set_ylim(bottom=_LEAST_MODULUS)
    else:
        axes.set_ylim(bottom=0.0)


def _with_neighbors(chosen: np.ndarray) -> np.ndarray:
    """Return the points of a mask (points,) and those beside them, so that lines meet."""
    wide = chosen.copy()
    wide[1:] |= chosen[:-1]
    wide[:-1] |= chosen[1:]
    return wide


def _look_of(kind: str) -> dict[str, Any]:
    """Return the look of a special point; a grazing is a frame around what coincides with it."""
    look = {**_POINT, **MARKS[kind]}
    if kind == "UZ":
        return look | _STAR
    if kind != "GR":
        return look
    color = look["color"]
    return look | {**_FRAME, "markeredgecolor": color, "zorder": 4}


def _handles(
    result: Continued, panels: Sequence[Panel], over: bool = False, borders: bool = False
) -> list[Line2D]:
    """Return the entries of the legend, with those of a scan `over` which the branches lie."""
    handles: list[Line2D] = []
    if any(panel.dataset != MULTIPLIERS for panel in panels):
        curves = (("stable", _STABLE, False), ("unstable", _UNSTABLE, True))
        handles += [
            Line2D([], [], label=label, **look)
            for label, look, lost in curves
            if any((branch.stable != lost).any() for branch in result.branches)
        ]
    if any(panel.dataset == MULTIPLIERS for panel in panels):
        handles += [Line2D([], [], label=label, **look) for label, look in _MULTIPLIERS.items()]
    for kind in MARKS:
        if kind in result.special_points.kind:
            look = _look_of(kind)
            handles.append(Line2D([], [], label=f"{kind} {WORDS[kind]}", **look))
    handles += _stop_handles(branch.ends for branch in result.branches)
    if over:
        handles.append(Line2D([], [], label="scan", color=_PALE, markersize=3.5, **DOT))
    if borders:
        tick: dict[str, Any] = {"marker": "|", "linestyle": "none", "markersize": 6}
        handles.append(Line2D([], [], label="its regime changes", color=GRAY, **tick))
    return handles


def _stop_handles(ends: Iterable[tuple[str, str]]) -> list[Line2D]:
    """Return the entries of the legend for ends before the natural one."""
    present = {end for pair in ends for end in pair}
    return [
        Line2D([], [], label=f"ends: {end}", marker=marker, **_STOP)
        for end, marker in STOPS.items()
        if end in present
    ]


# ---- curves in the plane of two parameters ----

# The dashes of a curve by n of nT; of any other n, those of 8.
_DASHES = {1: (), 2: (4, 1.5), 4: (4, 1.5, 1, 1.5), 8: (1, 1.5)}

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
        look = _look(curve.kind, curve.period)
        # white beside it, so that it is legible over a map; below all curves
        axes.plot(x, y, color="white", linewidth=look["linewidth"] + 1.1, zorder=3)
        axes.plot(x, y, zorder=3.5 if curve.kind == "GR" else 4, **look)
        for point, end in ((0, curve.ends[0]), (-1, curve.ends[1])):
            if end in STOPS:
                axes.plot(x[point], y[point], **{**_STOP, "zorder": 6}, marker=STOPS[end])
        for name, *values in curve.meetings:
            place = values[across], values[1 - across]
            axes.plot(*place, **{**_POINT, "marker": "o", "color": "black", "zorder": 6})
            of_text: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": True}
            of_text |= {"fontsize": _SIZE, "path_effects": halo, "zorder": 7}
            axes.annotate(name, place, (3, 3), **of_text)
    axes.set(xlim=limits[0], ylim=limits[1])


def _look(kind: str, n: int) -> dict[str, Any]:
    # another curve may run beside one of grazing, or on it
    width = 2.6 if kind == "GR" else 1.1
    look: dict[str, Any] = {"color": MARKS[kind]["color"], "linewidth": width}
    dashes = _DASHES.get(n, _DASHES[8])
    return look | ({"dashes": dashes} if dashes else {})


def _plane_handles(result: Continued) -> list[Line2D]:
    handles = []
    for kind, n in dict.fromkeys((curve.kind, curve.period) for curve in result.curves):
        label = f"{kind} of {'T' if n == 1 else f'{n}T'} ({WORDS[kind]})"
        handles.append(Line2D([], [], label=label, **_look(kind, n)))
    return handles + _stop_handles(curve.ends for curve in result.curves)
