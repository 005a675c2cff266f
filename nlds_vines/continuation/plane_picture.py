"""Curves of special points in the plane of two parameters, alone or over a scan's map."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, Stroke

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import REGIMES
from nlds_vines.bifurcation.picture.regime_map import fill_map, name_regimes
from nlds_vines.continuation.marks import MARKS, WORDS
from nlds_vines.continuation.result import Continued, SpecialCurve
from nlds_vines.errors import RequestError
from nlds_vines.plotting.page import TWO_COLUMNS, Page, add_legend, finish, new_figure, styled
from nlds_vines.plotting.style import axis_label

_DASHES = {1: (), 2: (4, 1.5), 4: (4, 1.5, 1, 1.5), 8: (1, 1.5)}
"""The dashes of a curve by n of nT; of any other n, those of 8."""

_HALO = [Stroke(linewidth=2.2, foreground="white"), Normal()]
"""What keeps a curve legible over a map."""

_SIZE, _MARK = 7, 4.0  # points


@styled()
def plane_diagram(
    found: Continued, scan: ArchiveView | None = None, page: Page = TWO_COLUMNS
) -> Figure:
    """Return the curves of a continuation in their plane, over the map of a `scan` if one is given.

    Arguments: what was `found`; the `scan`, as an open archive; the `page`.

    Where two kinds meet, a dot has the name of the meeting.

    Raises `RequestError` for a scan of other parameters.
    """
    assert found.request.plane is not None
    names = (found.request.along.name, found.request.plane.name)
    if scan is not None and set(scan.axes) != set(names):
        raise RequestError(f"{scan.path} varies {', '.join(scan.axes)}, not {names[0]}, {names[1]}")
    figure, grid = new_figure(page, [page.map_height])
    axes = figure.add_subplot(grid[0])
    if scan is None:
        across = 0
        _label(axes, found)
    else:
        across = names.index(scan.axes[0])
        fill_map(axes, scan, REGIMES, page)
    limits = axes.get_xlim(), axes.get_ylim()
    for curve in found.curves:
        _draw(axes, curve, across)
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    add_legend(axes, _handles(found), "above", handlelength=2.2)
    finish(figure, grid, found.request.title)
    if scan is not None:
        name_regimes(axes, scan)
    return figure


def fill_plane(axes: Axes, found: Continued) -> None:
    """Draw the curves of a continuation in their plane into axes, with their legend."""
    _label(axes, found)
    for curve in found.curves:
        _draw(axes, curve, 0)
    axes.legend(handles=_handles(found))


def _label(axes: Axes, found: Continued) -> None:
    """Give axes the intervals and names of both parameters."""
    (along, plane) = found.request.free
    axes.set_xlim(along.low, along.high)
    axes.set_ylim(plane.low, plane.high)
    axes.set_xlabel(axis_label(along.name))
    axes.set_ylabel(axis_label(plane.name))


def _draw(axes: Axes, curve: SpecialCurve, across: int) -> None:
    """Draw one curve and the meetings on it; `across`: which parameter runs to the right."""
    x, y = curve.values[:, across], curve.values[:, 1 - across]
    look: dict[str, Any] = {"color": MARKS[curve.kind]["color"], "linewidth": 1.1}
    dashes = _DASHES.get(curve.period, _DASHES[8])
    if dashes:
        look["dashes"] = dashes
    axes.plot(x, y, path_effects=_HALO, zorder=4, **look)
    halo = [Stroke(linewidth=1.8, foreground="white"), Normal()]
    for name, *values in curve.meetings:
        axes.plot(
            values[across], values[1 - across], marker="o", markersize=_MARK, color="black",
            markeredgecolor="white", markeredgewidth=0.5, zorder=6,
        )  # fmt: skip
        axes.annotate(
            name, (values[across], values[1 - across]), (3, 3), textcoords="offset points",
            fontsize=_SIZE, zorder=7, path_effects=halo,
            annotation_clip=True,
        )  # fmt: skip


def _handles(found: Continued) -> list[Line2D]:
    """Return the entries of a legend: the kinds and periods of the curves."""
    kinds = dict.fromkeys((curve.kind, curve.period) for curve in found.curves)
    handles = []
    for kind, n in kinds:
        look: dict[str, Any] = {"color": MARKS[kind]["color"], "linewidth": 1.1}
        if dashes := _DASHES.get(n, _DASHES[8]):
            look["dashes"] = dashes
        period = "T" if n == 1 else f"{n}T"
        handles.append(Line2D([], [], label=f"{kind} of {period} ({WORDS[kind]})", **look))
    return handles
