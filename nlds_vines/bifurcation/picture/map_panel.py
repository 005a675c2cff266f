"""The panel of a map: its axes, its cells filled, hatched, marked with dots, regions named."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.bands import inner_edges, logarithmic
from nlds_vines.plotting.page import TWO_COLUMNS, Page, size_of, text_width
from nlds_vines.plotting.palette import is_dark, short
from nlds_vines.plotting.panels import add_panel
from nlds_vines.plotting.style import CM, axis_label

HEAD, FOOT = 0.95 * CM, 1.25 * CM
"""Heights [inches] of a map's title and of the labels below it."""

_DOT_SHARE, _LARGEST_DOT = 0.4, 3.0  # of a cell's smaller side; points
_DOT_EDGE, _WIDEST_EDGE = 0.1, 0.5  # likewise


def single_map(
    view: ArchiveView, page: Page = TWO_COLUMNS, below: float = 0.0
) -> tuple[Figure, Axes]:
    """Return a figure with one map, its axes labeled, beside room for a legend or a bar.

    Arguments: the archive; the page; `below`, the inches for a legend that is to stand there.
    """
    figure = Figure(figsize=(page.width, HEAD + page.map_height + FOOT + below))
    axes = map_panel(figure, FOOT + below, page)
    label_axes(axes, view)
    return figure, axes


def map_panel(figure: Figure, bottom: float, page: Page = TWO_COLUMNS) -> Axes:
    """Return axes for a map, their lower edge at `bottom` inches."""
    return add_panel(figure, (page.left, bottom, page.map_width, page.map_height))


def label_axes(axes: Axes, view: ArchiveView) -> None:
    """Write what the axes of a map are, and give them the scales of their values."""
    axes.set_xlabel(axis_label(view.axes[0]))
    axes.set_ylabel(axis_label(view.axes[1]))


def fill_cells(axes: Axes, view: ArchiveView, values: np.ndarray, **style: Any) -> QuadMesh:
    """Draw `values` (first parameter, second parameter) without smoothing, and return the mesh.

    The cells end where the values end.  Values at equal ratios stand on a logarithmic axis.
    """
    across, up = (inner_edges(view[name]) for name in view.axes)
    mesh = axes.pcolormesh(across, up, values.T, shading="flat", rasterized=True, **style)
    for name, set_scale in zip(view.axes, (axes.set_xscale, axes.set_yscale), strict=True):
        if logarithmic(view[name]):
            set_scale("log")
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(up[0], up[-1])
    return mesh


def fill_classes(
    axes: Axes, view: ArchiveView, names: np.ndarray, words: Sequence[object], shades: Sequence[str]
) -> None:
    """Fill every cell with the shade of its class, one of `words`."""
    number = {word: i for i, word in enumerate(words)}
    classes = np.vectorize(number.__getitem__, otypes=[np.int64])(names)
    norm = BoundaryNorm(np.arange(len(words) + 1) - 0.5, len(words))
    fill_cells(axes, view, classes, cmap=ListedColormap(list(shades)), norm=norm)


def hatch_cells(
    axes: Axes, view: ArchiveView, where: np.ndarray, look: tuple[str, str], text: str
) -> Patch:
    """Hatch the cells in which `where`, of the shape of the cells, is true.

    Arguments: `look`, the hatch and its color.  Returns such a patch for the legend, named `text`.
    """
    across, up = (inner_edges(view[name]) for name in view.axes)
    boxes = [
        [
            (across[a], up[row]),
            (across[b], up[row]),
            (across[b], up[row + 1]),
            (across[a], up[row + 1]),
        ]
        for row, a, b in _runs(where)
    ]
    style: dict[str, Any] = {"facecolor": "none", "edgecolor": look[1], "linewidth": 0}
    axes.add_collection(PolyCollection(boxes, hatch=look[0], **style), autolim=False)
    return Patch(hatch=look[0], label=text, **style)


def _runs(where: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """Yield row, first column and the column after the last of each run of true cells."""
    for row in range(where.shape[1]):
        steps = np.diff(np.concatenate([[False], where[:, row], [False]]).astype(np.int8))
        for first, stop in zip(np.flatnonzero(steps > 0), np.flatnonzero(steps < 0), strict=True):
            yield row, int(first), int(stop)


def add_map_legend(
    axes: Axes, handles: Sequence[Any], title: str, page: Page = TWO_COLUMNS
) -> None:
    """Add a legend to the right of a map, or on a page of one column below it."""
    look: dict[str, Any] = {"borderaxespad": 0, "handlelength": 1.2, "labelspacing": 0.35}
    place: dict[str, Any] = {"loc": "upper left", "alignment": "left", "title": title}
    if not page.beside:
        place["title"] = title.replace("\n", " ")
    if page.beside:
        axes.legend(handles=list(handles), bbox_to_anchor=(1.02, 1.0), **place, **look)
        return
    below = 72 * (FOOT - 0.1 * CM) / size_of(axes)[1]
    look |= {"columnspacing": 1.0, "ncols": page.columns + 1}
    axes.legend(handles=list(handles), bbox_to_anchor=(-0.1, -below), **place, **look)


# ---- names of regions ----------------------------------------------------------------------------


_SIZE = 7  # pt
_PADDING = 4  # pt between a name and the border of its region
_LONGEST = 14  # characters of a name that is written inside


def name_regions(
    axes: Axes, view: ArchiveView, names: np.ndarray, shades: Mapping[str, str]
) -> None:
    """Write each name once into the largest circle of cells of that name, if it fits there.

    Arguments: the axes of the map; its archive; the `names` (first parameter, second parameter) of
    its cells; the colors of those that are to be written, by name.
    """
    from scipy.ndimage import distance_transform_edt

    wide, tall = size_of(axes)
    sides = wide / names.shape[0], tall / names.shape[1]
    for word, color in shades.items():
        text = short(word)
        if len(text) > _LONGEST:
            continue
        inside = np.pad(names == word, 1)
        depth = distance_transform_edt(inside, sampling=sides)[1:-1, 1:-1]
        place = np.unravel_index(np.argmax(depth), depth.shape)
        if text_width(text, _SIZE) / 2 + _PADDING > depth[place]:
            continue
        x, y = (view[name][index] for name, index in zip(view.axes, place, strict=True))
        ink = "white" if is_dark(color) else "black"
        axes.text(x, y, text, color=ink, fontsize=_SIZE, ha="center", va="center")
