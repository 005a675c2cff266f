"""The surface of a tuning: its objective over two parameters, and where the optima lie."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.plotting.bands import edges
from nlds_vines.plotting.save import save_drawn
from nlds_vines.plotting.style import (
    CM,
    LEFT,
    STYLE,
    WIDTH,
    axis_label,
    latex_symbol,
    quantity_label,
)

_HEIGHT = 11.6 * CM
_FRAME = (LEFT + 0.02, 0.115, 0.665, 0.735)
_WIDE = 8.0  # ratio of the largest to the smallest value from which shades go by the logarithm
_INK = "#d7191c"


def save(archive_path: str | os.PathLike[str], plot_path: str | os.PathLike[str]) -> Path:
    """Draw the surface of a tuning's archive as `save_drawn`; returns the picture's path."""
    return save_drawn(archive_path, plot_path, tuning_surface)


@matplotlib.rc_context(STYLE)
def tuning_surface(view: ArchiveView) -> Figure:
    """Return the surface of a tuning: shades and contours of E1max over two free parameters.

    The other parameters are those of the best optimum, which a star marks; circles mark the
    near-equal ones, which may lie off the surface.  Inadmissible designs are grey.

    Raises `RequestError` for a tuning without a surface.
    """
    if "surface" not in view:
        raise RequestError(f"{view.path} holds no surface: tune with --surface A,B")
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axes = figure.add_axes(_FRAME)
    _shade(figure, axes, view)
    _mark(axes, view)
    for name, axis in zip(_names(view), (axes.xaxis, axes.yaxis), strict=True):
        axis.set_label_text(axis_label(name))
    figure.text(_FRAME[0], 0.985, _title(view), va="top")
    return figure


def _names(view: ArchiveView) -> list[str]:
    return [dim.removeprefix("surface_") for dim in view.dims("surface")]


def _title(view: ArchiveView) -> str:
    """Return the title, and below it the parameters that are held."""
    prefix, shown = "optimum_", _names(view)
    free = [n.removeprefix(prefix) for n in view.names if n.startswith(prefix)]
    held = [
        f"${latex_symbol(n)}$ = {view[prefix + n][0]:.4g} {PARAMETERS[n].unit}"
        for n in free
        if n in PARAMETERS and n not in shown
    ]
    text = f"with {', '.join(held)} as in the best" if held else ""
    return "\n".join(filter(None, [str(view.attrs["title"]), text]))


def _shade(figure: Figure, axes: Axes, view: ArchiveView) -> None:
    """Draw the objective in shades, a few contours over them, and the bar that explains them."""
    across, up = (view[dim] for dim in view.dims("surface"))
    found = np.ma.masked_invalid(view["surface"]).T
    norm = _norm(found)
    shades = matplotlib.colormaps["viridis"].with_extremes(bad="#c8c8c8")
    style: dict[str, Any] = {"cmap": shades, "norm": norm, "shading": "flat", "rasterized": True}
    mesh = axes.pcolormesh(_edges(across), _edges(up), found, **style)
    if isinstance(norm, LogNorm):
        levels = LogLocator(subs=(1.0, 2.0, 5.0)).tick_values(found.min(), found.max())
        axes.contour(across, up, found, levels=levels, colors="white", linewidths=0.4)
    else:
        axes.contour(across, up, found, 8, colors="white", linewidths=0.4)
    if not _evenly(across):
        axes.set_xscale("log")
        _in_plain_numbers(axes.xaxis)
    if not _evenly(up):
        axes.set_yscale("log")
        _in_plain_numbers(axes.yaxis)
    left, bottom, width, height = _FRAME
    bar = figure.colorbar(mesh, cax=figure.add_axes((left + width + 0.02, bottom, 0.023, height)))
    bar.set_label(quantity_label("E1max", view.units("surface")))
    if isinstance(norm, LogNorm):
        _in_plain_numbers(bar.ax.yaxis)


def _in_plain_numbers(axis: Axis) -> None:
    """Mark 1, 2, 5, 10, ... on a logarithmic axis, written out."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _norm(found: np.ma.MaskedArray) -> Normalize:
    """Return the scale of the shades: logarithmic where the values span a wide range."""
    if found.count() and 0 < found.min() * _WIDE < found.max():
        return LogNorm(found.min(), found.max())
    return Normalize()


def _mark(axes: Axes, view: ArchiveView) -> None:
    """Mark the optima: a star for the best, circles for those nearly as good."""
    x, y = (view[f"optimum_{name}"] for name in _names(view))
    style: dict[str, Any] = {"linestyle": "none", "clip_on": False, "zorder": 5}
    ring: dict[str, Any] = {"mfc": "none", "mec": _INK, "mew": 1.1}
    star: dict[str, Any] = {"mfc": _INK, "mec": "white", "mew": 0.6}
    best = f"best: {view['optimum_objective'][0]:.4g} J"
    axes.plot(x[:1], y[:1], marker="*", markersize=11, label=best, **star, **style)
    if x.size > 1:
        label = "nearly as good, perhaps off the surface"
        axes.plot(x[1:], y[1:], marker="o", markersize=6, label=label, **ring, **style)
    # above the frame, where it hides nothing
    place: dict[str, Any] = {"bbox_to_anchor": (0.0, 1.0), "borderpad": 0, "borderaxespad": 0.4}
    axes.legend(loc="lower left", ncols=2, frameon=False, handletextpad=0.2, **place)


def _evenly(values: np.ndarray) -> bool:
    steps = np.diff(values)
    return bool(np.allclose(steps, steps[0], rtol=1e-6))


def _edges(values: np.ndarray) -> np.ndarray:
    """Return where the cells around values begin and end, on the scale that they are even on."""
    return edges(values) if _evenly(values) else np.exp(edges(np.log(values)))
