"""Maps: what two parameters do to the orbits."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nlds_vines.archive import ArchiveView
from nlds_vines.errors import RequestError
from nlds_vines.figures.bands import edges
from nlds_vines.figures.diagram import CURVES
from nlds_vines.figures.palette import colours, ordered, short
from nlds_vines.figures.style import CM, LEFT, STYLE, WIDTH, axis_label, quantity_label

_HEIGHT = 11 * CM
_MOST_NAMED = 24  # regimes in the legend


@matplotlib.rc_context(STYLE)
def regime_map(view: ArchiveView) -> Figure:
    """Return the map of a scan of two parameters: a colour for each regime, and its name.

    The first parameter runs to the right, the second up.  Without recorded regimes the map shows
    the first number there is, by preference the structure's energy.  Of several starts it shows
    the first, and says so.

    Raises `RequestError` for a scan of one parameter and where nothing is recorded to draw.
    """
    if len(view.axes) != 2:
        raise RequestError(f"{view.path} varies one parameter: draw it as a diagram")
    names = [name for name in CURVES if name in view]
    if "label" not in view and not names:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axes = figure.add_axes((LEFT, 0.115, 0.665, 0.8))
    if "label" in view:
        _draw_regimes(axes, view)
    else:
        _draw_number(figure, axes, view, names[0])
    axes.set_xlabel(axis_label(view.axes[0]))
    axes.set_ylabel(axis_label(view.axes[1]))
    figure.text(LEFT, 0.985, _title(view), va="top")
    return figure


def _title(view: ArchiveView) -> str:
    starts = view["start"]
    several = f"; start: {starts[0]}, one of {starts.size}" if starts.size > 1 else ""
    return f"{view.attrs['title']}{several}"


def _draw_regimes(axes: Axes, view: ArchiveView) -> None:
    """Fill every cell with the colour of its regime; the legend names the most frequent ones."""
    labels = view.take("label", start=0)
    words, classes, counts = np.unique(
        labels.astype(np.str_), return_inverse=True, return_counts=True
    )
    colour = colours(words)
    norm = BoundaryNorm(np.arange(words.size + 1) - 0.5, words.size)
    shades = ListedColormap([colour[word] for word in words])
    _fill(axes, view, classes.reshape(labels.shape), cmap=shades, norm=norm)
    frequent = words[np.argsort(-counts, kind="stable")[:_MOST_NAMED]]
    handles = [Patch(color=colour[word], label=short(word)) for word in ordered(frequent)]
    if words.size > _MOST_NAMED:
        handles.append(Patch(color="none", label=f"and {words.size - _MOST_NAMED} more"))
    axes.legend(
        handles=handles,
        title="regime",
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0,
        frameon=False,
        handlelength=1.2,
        labelspacing=0.35,
    )


def _draw_number(figure: Figure, axes: Axes, view: ArchiveView, name: str) -> None:
    """Fill every cell with the shade of a recorded number; grey where there is none."""
    found = view.take(name, start=0)
    shades = matplotlib.colormaps["viridis"].with_extremes(bad="#c8c8c8")
    mesh = _fill(axes, view, np.ma.masked_invalid(found), cmap=shades)
    frame = axes.get_position()
    bar_axes = figure.add_axes((frame.x1 + 0.02, frame.y0, 0.023, frame.height))
    bar = figure.colorbar(mesh, cax=bar_axes)
    bar.set_label(quantity_label(name, view.units(name)))


def _fill(axes: Axes, view: ArchiveView, values: np.ndarray, **style: Any) -> QuadMesh:
    """Draw one value for each cell, without any smoothing, and return the mesh."""
    across, up = (edges(view[name]) for name in view.axes)
    return axes.pcolormesh(across, up, values.T, shading="flat", rasterized=True, **style)
