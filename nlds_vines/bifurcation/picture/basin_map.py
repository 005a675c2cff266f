"""Basins of attraction: a color for each attractor, over a plane of starts and along a parameter.

The color is that of the attractor's regime, the same in every picture.  Of several attractors of
one regime the later ones are darker, then paler.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.regime_map import (
    add_map_legend,
    fill_cells,
    label_axes,
    name_regions,
)
from nlds_vines.bifurcation.request import begins_at_sections
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import INITIAL, component_of
from nlds_vines.plotting.bands import inner_edges
from nlds_vines.plotting.page import TWO_COLUMNS, Page, finish, new_figure, styled, write_letters
from nlds_vines.plotting.palette import (
    HATCHED,
    OTHERS,
    color_of,
    drawn_as,
    example_of,
    in_order,
    mixed,
    patch_look,
)
from nlds_vines.plotting.style import axis_label

_SHADES = (("#000000", 0.0), ("#000000", 0.35), ("#ffffff", 0.45), ("#000000", 0.6))
"""What is mixed into the color of a regime, by how much: of its first attractor, the second ..."""

_NOT_KNOWN = "not known"


class _Look(NamedTuple):
    """The name of an attractor, its color and its regime; the regime is empty if not known."""

    name: str
    color: str
    label: str


_UNKNOWN = _Look(_NOT_KNOWN, OTHERS[HATCHED], "")


def drawable(view: ArchiveView) -> bool:
    """Return True if an archive has basins to be drawn: planes, or shares over a parameter."""
    return not _why_not(view)


def _why_not(view: ArchiveView) -> str:
    if "attractor" not in view:
        return "scan with --record attractor"
    if "attractor_share" not in view:
        return "no attractor was found"
    varied = _parameters(view)
    if len(varied) == 1 or (len(view.axes) == 2 and not varied):
        return ""
    return "vary two initial conditions, or one parameter"


def _parameters(view: ArchiveView) -> list[str]:
    return [name for name in view.axes if name not in INITIAL]


@styled()
def basin_picture(view: ArchiveView, page: Page = TWO_COLUMNS) -> Figure:
    """Return the figure of a scan's basins.

    Over two initial conditions it is a map, along a parameter the shares of the attractors; over
    one of each both, one above the other.  Raises `RequestError` for any other scan.
    """
    if why := _why_not(view):
        raise RequestError(f"{view.path}: show = 'basins': {why}")
    varied, has_map = _parameters(view), len(view.axes) == 2
    figure, grid = new_figure(page, [page.map_height] * (has_map + len(varied)))
    panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
    if has_map:
        handles = fill_basins(panels[0], view)
    if varied:
        handles = fill_shares(panels[-1], view)
    add_map_legend(panels[-1], handles, "attractor")
    if len(panels) > 1 and view.axes[0] == varied[0]:
        panels[1].set_xlim(panels[0].get_xlim())
    write_letters(panels)
    finish(figure, grid, view.text("title"))
    if has_map:
        name_basins(panels[0], view)
    return figure


def fill(axes: Axes, view: ArchiveView) -> None:
    """Draw the map, or else the shares, into axes; errors as `basin_picture`."""
    if why := _why_not(view):
        raise RequestError(f"{view.path}: show = 'basins': {why}")
    has_map = len(view.axes) == 2
    handles = fill_basins(axes, view) if has_map else fill_shares(axes, view)
    add_map_legend(axes, handles, "attractor")
    if has_map:
        name_basins(axes, view)


def fill_basins(axes: Axes, view: ArchiveView) -> list[Any]:
    """Color the cells of a map by attractor, mark the attractors' points; return the handles."""
    looks, classes = _looks_of_cells(view)
    norm = BoundaryNorm(np.arange(len(looks) + 1) - 0.5, len(looks))
    fill_cells(axes, view, classes, cmap=ListedColormap([x.color for x in looks]), norm=norm)
    label_axes(axes, view)
    handles: list[Any] = _patches(looks)
    if begins_at_sections(view) and not _parameters(view):
        handles += _mark_points(axes, view)
    return handles


def name_basins(axes: Axes, view: ArchiveView) -> None:
    looks, classes = _looks_of_cells(view)
    names = np.array([look.name for look in looks], object)[classes]
    name_regions(axes, view, names, {x.name: x.color for x in looks if x != _UNKNOWN})


def fill_shares(axes: Axes, view: ArchiveView) -> list[Any]:
    """Draw the attractors' shares along the parameter as stacked bars; return legend handles."""
    (name,), (looks, table), shares = _parameters(view), _looks(view), view["attractor_share"]
    edges, floor = inner_edges(view[name]), np.zeros(len(shares))
    style: dict[str, Any] = {"align": "edge", "lw": 0}
    for column, codes in zip(np.nan_to_num(shares).T, table.T, strict=True):
        colors = [looks[code].color if code else "none" for code in codes]
        axes.bar(edges[:-1], column, np.diff(edges), floor, color=colors, **style)
        floor += column
    axes.bar(edges[:-1], 1 - floor, np.diff(edges), floor, color=_UNKNOWN.color, **style)
    axes.set(xlim=(edges[0], edges[-1]), ylim=(0, 1))
    axes.set(xlabel=axis_label(name), ylabel="share of the starts")
    return _patches(looks if (floor < 1 - 1e-12).any() else looks[1:])


def _looks(view: ArchiveView) -> tuple[list[_Look], np.ndarray]:
    """Return the different looks, `_UNKNOWN` first, and the look (index) of each row of the table.

    A name has the attractor's number if several have one regime; long periods share name and color.
    """
    labels = view["attractor_label"]
    looks, table = [_UNKNOWN], np.zeros(labels.shape, int)
    for label in sorted({str(label) for label in labels.flat if label}):
        numbers = [k for k in range(labels.shape[-1]) if (labels[..., k] == label).any()]
        is_long = drawn_as(label) != label
        for i, k in enumerate(numbers):
            name = drawn_as(label) if is_long or len(numbers) == 1 else f"{label} ({k})"
            shade = _SHADES[0 if is_long else i % len(_SHADES)]
            look = _Look(name, mixed(color_of(label), *shade), drawn_as(label))
            looks += [look] * (look not in looks)
            table[..., k][labels[..., k] == label] = looks.index(look)
    return looks, table


def _looks_of_cells(view: ArchiveView) -> tuple[list[_Look], np.ndarray]:
    """Return the looks that occur in a map, and the look (index) of each cell."""
    looks, table = _looks(view)
    numbers, varied = view["attractor"][..., 0], _parameters(view)
    places = zip(view.axes, np.indices(numbers.shape), strict=True)
    where = [place for name, place in places if name in varied]
    codes = np.where(numbers >= 0, table[(*where, np.maximum(numbers, 0))], 0)
    present, classes = np.unique(codes, return_inverse=True)
    return [looks[code] for code in present], classes.reshape(numbers.shape)


def _patches(looks: Iterable[_Look]) -> list[Any]:
    """Return the handles of a legend, by period, cells without a known attractor last."""
    order = in_order({look.label for look in looks if look.label})
    ordered = sorted(looks, key=lambda x: (order.index(x.label) if x.label else len(order), x.name))
    styles = [
        patch_look(example_of(look.label), look.color)
        if look.label
        else {"facecolor": look.color, "linewidth": 0}
        for look in ordered
    ]
    return [Patch(label=x.name, **style) for x, style in zip(ordered, styles, strict=True)]


def _mark_points(axes: Axes, view: ArchiveView) -> list[Line2D]:
    """Mark the attractors' section points, projected into the plane; return the legend's handle."""
    style: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgecolor": "black"}
    style |= {"markersize": 5.0, "markeredgewidth": 0.9}
    names, (looks, table) = view["component"].tolist(), _looks(view)
    columns = [names.index(component_of(name)) for name in view.axes]
    spans = np.array([view[name][[0, -1]] for name in view.axes]).T
    points = view["attractor_point"][:, columns]
    inside = np.flatnonzero(((points >= spans[0]) & (points <= spans[1])).all(axis=1))
    for k in inside.tolist():
        color = mixed(looks[table[k]].color, "#ffffff", 0.5)
        axes.plot(*points[k], markerfacecolor=color, zorder=5, **style)
    text = "points of attractors" + (",\nprojected" if len(names) > 2 else "")
    handle = Line2D([], [], markerfacecolor="white", label=text, **style)
    return [handle] * bool(inside.size)
