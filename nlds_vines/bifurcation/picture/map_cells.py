"""The panel of a map: its axes, its cells filled with colours, dots that mark some of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.bands import edges, evenly_spaced
from nlds_vines.plotting.panels import MAP_WIDTH
from nlds_vines.plotting.style import CM, LEFT, WIDTH, axis_label

_HEIGHT = 11 * CM  # inches, of the figure of a single map
_BOTTOM, _TALL = 0.115, 0.8  # of a single map, as fractions of that height
_FEW = 8  # the most values at unequal distances that stand side by side as in a list
_DOT_SHARE, _LARGEST_DOT = 0.4, 3.0  # of a cell's smaller side; points
_DOT_EDGE, _WIDEST_EDGE = 0.1, 0.5  # likewise


def single_map(view: ArchiveView) -> tuple[Figure, Axes]:
    """Return a figure with one map, its axes labelled, beside room for a legend or a bar."""
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axes = map_panel(figure, _BOTTOM, _TALL)
    axes.set_xlabel(axis_label(view.axes[0]))
    axes.set_ylabel(axis_label(view.axes[1]))
    return figure, axes


def map_panel(figure: Figure, bottom: float, height: float) -> Axes:
    """Return axes for a map beside room for a legend; fractions of the figure's height."""
    return figure.add_axes((LEFT, bottom, MAP_WIDTH, height))


def fill_cells(axes: Axes, view: ArchiveView, values: np.ndarray, **style: Any) -> QuadMesh:
    """Draw `values` (first parameter, second parameter) without smoothing, and return the mesh.

    A few values at unequal distances stand side by side, and each is named on the axis.
    """
    across, up = (edges(_places(view[name])) for name in view.axes)
    for axis, name in zip((axes.xaxis, axes.yaxis), view.axes, strict=True):
        if _is_list(view[name]):
            axis.set_ticks(_places(view[name]), [f"{value:g}" for value in view[name]])
    return axes.pcolormesh(across, up, values.T, shading="flat", rasterized=True, **style)


def mark_cells(axes: Axes, view: ArchiveView, where: np.ndarray, text: str) -> Line2D:
    """Put a dot into each cell in which `where`, of the shape of the cells, is true.

    Returns such a dot for the legend, named `text`.
    """
    places: Sequence[np.ndarray] = [_places(view[name]) for name in view.axes]
    point = 72 / axes.figure.dpi  # points in a pixel
    cell = point * min(axes.bbox.width / where.shape[0], axes.bbox.height / where.shape[1])
    across, up = (place[index] for place, index in zip(places, np.nonzero(where), strict=True))
    look: dict[str, Any] = {"marker": "o", "linestyle": "none", "markerfacecolor": "white"}
    look |= {"markeredgecolor": "black", "markeredgewidth": min(_DOT_EDGE * cell, _WIDEST_EDGE)}
    axes.plot(across, up, markersize=min(_DOT_SHARE * cell, _LARGEST_DOT), rasterized=True, **look)
    return Line2D([], [], markersize=_LARGEST_DOT, label=text, **look)


def _is_list(values: np.ndarray) -> bool:
    """Return whether values are a few at unequal distances: a list rather than a scale."""
    return 2 < values.size <= _FEW and not evenly_spaced(values)


def _places(values: np.ndarray) -> np.ndarray:
    """Return where values stand along their axis: at themselves, or one after the other."""
    return np.arange(values.size) if _is_list(values) else values
