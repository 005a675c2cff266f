"""Basins of attraction: a color for each attractor, over a plane of starts and along a parameter.

The color is that of the attractor's regime, the same in every picture.  Of several attractors of
one regime the later ones are darker, then paler.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.datasets import begins_at_sections
from nlds_vines.bifurcation.picture.regime_map import (
    add_map_legend,
    fill_cells,
    label_axes,
    name_regions,
)
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
    """What an attractor is called, and its color."""

    name: str
    color: str


def drawable(view: ArchiveView) -> bool:
    """Tell whether an archive has basins that can be drawn: planes, or shares along a parameter."""
    return not _why_not(view)


def _why_not(view: ArchiveView) -> str:
    if "attractor" not in view:
        return "scan with --record attractor"
    if "attractor_share" not in view:
        return "no attractor was found"
    varied = [name for name in view.axes if name not in INITIAL]
    if len(varied) == 1 or (len(view.axes) == 2 and not varied):
        return ""
    return "vary two initial conditions, or one parameter"


@styled()
def basin_picture(
    view: ArchiveView,
    page: Page = TWO_COLUMNS,
) -> Figure:
    """Return the basins of a scan: over two initial conditions, or their shares along a parameter.

    Over a parameter and an initial condition there are both, one above the other.
    Raises `RequestError` for any other scan.
    """
    if why := _why_not(view):
        raise RequestError(f"{view.path}: show = 'basins': {why}")
    varied = [name for name in view.axes if name not in INITIAL]
    map_, shares = len(view.axes) == 2, len(varied) == 1
    figure, grid = new_figure(page, [page.map_height] * (map_ + shares))
    panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
    if map_:
        fill_basins(panels[0], view, page, legend=not shares)
    if shares:
        handles = fill_shares(panels[-1], view)
        add_map_legend(panels[0 if page.beside else -1], handles, "attractor", page)
    if len(panels) > 1 and view.axes[0] == varied[0]:
        panels[1].set_xlim(panels[0].get_xlim())
    write_letters(panels)
    finish(figure, grid, view.text("title"))
    if map_:
        name_basins(panels[0], view)
    return figure


def fill(
    axes: Axes,
    view: ArchiveView,
    page: Page,
) -> None:
    """Draw one panel of it into axes: the map, or else the shares; errors as `basin_picture`."""
    if why := _why_not(view):
        raise RequestError(f"{view.path}: show = 'basins': {why}")
    if len(view.axes) == 2:
        fill_basins(axes, view, page)
        name_basins(axes, view)
    else:
        add_map_legend(axes, fill_shares(axes, view), "attractor", page)


def fill_basins(
    axes: Axes,
    view: ArchiveView,
    page: Page,
    *,
    legend: bool = True,
) -> None:
    """Fill every cell of a map with the color of its attractor; mark their points."""
    looks = _looks(view)
    labels, numbers = _labels_of_cells(view), view["attractor"][..., 0]
    keys = [(int(k), str(label)) for k, label in zip(numbers.flat, labels.flat, strict=True)]
    present = sorted(set(keys))
    place = {key: i for i, key in enumerate(present)}
    classes = np.array([place[key] for key in keys]).reshape(numbers.shape)
    shades = [looks[key].color for key in present]
    norm = BoundaryNorm(np.arange(len(present) + 1) - 0.5, len(present))
    fill_cells(axes, view, classes, cmap=ListedColormap(shades), norm=norm)
    label_axes(axes, view)
    handles: list[Any] = [*_patches([looks[key] for key in present])]
    if begins_at_sections(view) and not [name for name in view.axes if name not in INITIAL]:
        handles += _mark_points(axes, view, looks)
    if legend:
        add_map_legend(axes, handles, "attractor", page)


def name_basins(axes: Axes, view: ArchiveView) -> None:
    """Write the names of attractors into a map whose size is final."""
    looks = _looks(view)
    labels, numbers = _labels_of_cells(view), view["attractor"][..., 0]
    cells = np.empty(numbers.shape, object)
    for place, k in np.ndenumerate(numbers):
        cells[place] = looks[int(k), str(labels[place])]
    names = np.vectorize(lambda look: look.name, otypes=[object])(cells)
    known = {look.name: look.color for look in {*cells.flat} if look.name != _NOT_KNOWN}
    name_regions(axes, view, names, known)


def fill_shares(axes: Axes, view: ArchiveView) -> list[Patch]:
    """Draw the shares of the attractors along the one parameter, one upon the other.

    Returns the entries of a legend.
    """
    (name,) = (axis for axis in view.axes if axis not in INITIAL)
    looks, labels, shares = _looks(view), view["attractor_label"], view["attractor_share"]
    edges = inner_edges(view[name])
    floor = np.zeros(len(labels))
    for k in range(labels.shape[1]):
        height = np.nan_to_num(shares[:, k])
        colors = [looks[k, str(label)].color if label else "none" for label in labels[:, k]]
        axes.bar(edges[:-1], height, np.diff(edges), floor, color=colors, align="edge", lw=0)
        floor += height
    unknown = OTHERS[HATCHED]
    axes.bar(edges[:-1], 1 - floor, np.diff(edges), floor, color=unknown, align="edge", lw=0)
    axes.set_xlim(edges[0], edges[-1])
    axes.set_ylim(0, 1)
    axes.set_xlabel(axis_label(name))
    axes.set_ylabel("share of the starts")
    seen = {looks[k, str(labels[i, k])] for i, k in np.argwhere(labels != "")}
    rest = [_Look(_NOT_KNOWN, unknown)] if (floor < 1 - 1e-12).any() else []
    return _patches([*seen, *rest])


def _labels_of_cells(view: ArchiveView) -> np.ndarray:
    """Return the regime of each cell's attractor, empty where it is not known."""
    numbers, labels = view["attractor"][..., 0], view["attractor_label"]
    varied = [place for place, name in enumerate(view.axes) if name not in INITIAL]
    where = [np.indices(numbers.shape)[place] for place in varied]
    found = labels[(*where, np.maximum(numbers, 0))]
    return np.where(numbers >= 0, found, "")


def _looks(view: ArchiveView) -> Mapping[tuple[int, str], _Look]:
    """Return name and color by number and regime; with the number where one regime has several."""
    labels = view["attractor_label"]
    table = labels.reshape(-1, labels.shape[-1])
    numbers: dict[str, list[int]] = {}
    for k in range(table.shape[1]):
        for label in dict.fromkeys(str(label) for label in table[:, k] if label):
            numbers.setdefault(label, []).append(k)
    found = {(-1, ""): _Look(_NOT_KNOWN, OTHERS[HATCHED])}
    for label, own in numbers.items():
        long = drawn_as(label) != label  # these share one color, and one name
        for i, k in enumerate(own):
            name = drawn_as(label) if long or len(own) == 1 else f"{label} ({k})"
            shade = _SHADES[0 if long else i % len(_SHADES)]
            found[k, label] = _Look(name, mixed(color_of(label), *shade))
    return found


def _patches(looks: Iterable[_Look]) -> list[Patch]:
    """Return the entries of a legend, by period; what is not known stands last."""
    by_name = {look.name: look.color for look in looks}
    places = {
        word: i for i, word in enumerate(in_order(map(_label, by_name.keys() - {_NOT_KNOWN})))
    }

    def place(name: str) -> tuple[int, str]:
        return places.get(_label(name), len(places)), name

    return [
        Patch(label=name, **patch_look(example_of(_label(name)), by_name[name]))
        if name != _NOT_KNOWN
        else Patch(label=name, facecolor=by_name[name], linewidth=0)
        for name in sorted(by_name, key=place)
    ]


def _label(name: str) -> str:
    """Return the regime of a name: T,1 of `T,1 (3)`."""
    return name.partition(" (")[0]


def _mark_points(
    axes: Axes, view: ArchiveView, looks: Mapping[tuple[int, str], _Look]
) -> list[Line2D]:
    """Mark the points of attractors in the plane, or above it; return the entry of the legend."""
    style: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgecolor": "black"}
    style |= {"markersize": 5.0, "markeredgewidth": 0.9}
    found = False
    for k, label in enumerate(view["attractor_label"]):
        for point in _within(view, view["attractor_point"][k : k + 1]):
            color = mixed(looks[k, str(label)].color, "#ffffff", 0.5)
            axes.plot(*point, markerfacecolor=color, zorder=5, **style)
            found = True
    text = "points of attractors" + _projected(view)
    return [Line2D([], [], markerfacecolor="white", label=text, **style)] if found else []


def _within(view: ArchiveView, points: np.ndarray) -> list[np.ndarray]:
    """Return points (count, components) as they lie in the plane of a map, where it has them."""
    names = view["component"].tolist()
    columns = [names.index(component_of(name)) for name in view.axes]
    spans = [(view[name][0], view[name][-1]) for name in view.axes]
    return [
        point
        for point in points[:, columns]
        if all(a <= value <= b for value, (a, b) in zip(point, spans, strict=True))
    ]


def _projected(view: ArchiveView) -> str:
    """Return what is said of points that need not lie in the plane of a map."""
    return "" if view["component"].size == 2 else ",\nprojected"
