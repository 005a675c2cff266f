"""A tuning drawn: its objective over two parameters, or along the only one, and the optima."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LogNorm, Normalize
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import DESCRIBED, described
from nlds_vines.plotting.bands import drawable, evenly_spaced, inner_edges
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import latex_symbol, raised
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    logarithmic_ticks,
    size_of,
    styled,
    write_out_ticks,
)
from nlds_vines.plotting.panels import add_color_bar, add_panel, write_title
from nlds_vines.plotting.style import (
    CM,
    NAVY,
    NO_VALUE,
    SHADES,
    axis_label,
    body_of,
    quantity_label,
)

_FOOT, _HEAD, _LINE = 1.35 * CM, 1.25 * CM, 0.45 * CM  # inches; of a line above the frame
_ASIDE = 0.3 * CM  # inches that numbers of four digits take more than others do
_WIDE = 8.0  # ratio of the largest to the smallest value from which shades are logarithmic
_SMALL = 7.5  # points, numbers on contours
_APART = 0.3  # inches, the least distance of two of them
_OUTLINE = "#202020"
_CONTOUR: dict[str, Any] = {"colors": "white", "linewidths": 0.5}
_WIDE_LEGEND = 200  # points, width of axes above which two entries stand side by side
_FEW_LINES = 8  # contours where shades are linear
_OPTIMUM = "optimum_"
_MARK = "#d7191c"  # a red that neither the shades nor the contours have


@styled()
def tuning_picture(view: ArchiveView, page: Page = TWO_COLUMNS) -> Figure:
    """Return the picture of a tuning: its surface, or the curve along its only free parameter."""
    free = _free(view)
    if "surface" in view or len(free) != 1:
        return tuning_surface(view, page)
    figure, axes = _frame(page, page.across - _ASIDE, 0)
    _draw_curve(axes, view, free[0])
    write_title(figure, view.text("title"), page.left / page.width)
    return figure


def _frame(page: Page, width: float, more: int) -> tuple[Figure, Axes]:
    """Return a figure and its axes, so many inches wide, below title, legend and `more` lines."""
    figure = Figure(figsize=(page.width, _HEAD + more * _LINE + page.map_height + _FOOT))
    return figure, add_panel(figure, (page.left + _ASIDE, _FOOT, width, page.map_height))


def _fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw the surface of a tuning into axes, or the curve along its only free parameter."""
    free = _free(view)
    if "surface" not in view and len(free) == 1:
        _draw_curve(axes, view, free[0])
    else:
        mesh, label = _fill_surface(axes, view)
        _explain(axes.figure.colorbar(mesh, ax=axes, label=label))


def _free(view: ArchiveView) -> list[str]:
    """Return the parameters that are free and enter the dynamics."""
    found = (name.removeprefix(_OPTIMUM) for name in view.names if name.startswith(_OPTIMUM))
    return [name for name in found if name in DESCRIBED and name != "V"]


def _draw_curve(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw the objective of all designs from rest, undisturbed, against the only parameter."""
    codes = {word: code for code, word in view.flags("stage").items()}
    plain = view["stage"] != codes["robustness"]
    values, found = view[name][plain], drawable(view["objective"])[plain]
    order = np.argsort(values)
    look: dict[str, Any] = {"marker": "o", "markersize": 2.5, "linewidth": 0.6, "color": NAVY}
    axes.plot(values[order], found[order], label="designs", **look)
    best, optima = view["optimum_objective"], view[f"{_OPTIMUM}{name}"]
    star: dict[str, Any] = {"marker": "*", "markersize": 11, "linestyle": "none", "zorder": 5}
    axes.plot(optima[:1], best[:1], label=_best(view), color=_MARK, **star)
    wide = found[np.isfinite(found)]
    if wide.size and 0 < wide.min() * _WIDE < wide.max():
        axes.set_yscale("log")
        write_out_ticks(axes.yaxis)
    if values.min() > 0 and values.max() > _WIDE * values.min():
        axes.set_xscale("log")
        write_out_ticks(axes.xaxis)
    axes.tick_params(top=True, right=True, which="both")
    axes.set_xlabel(axis_label(name))
    axes.set_ylabel(_objective(view))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderpad=0)


def _best(view: ArchiveView) -> str:
    """Return the least objective in words."""
    unit = view.units("optimum_objective")
    return f"best: {view['optimum_objective'][0]:.4g}{'' if unit == '1' else f' {raised(unit)}'}"


@styled()
def tuning_surface(view: ArchiveView, page: Page = TWO_COLUMNS) -> Figure:
    """Return the surface of a tuning: shades and contours of E1max over two free parameters.

    The other parameters are those of the best optimum, which a star marks.  Circles mark optima
    that are nearly as good; their other parameters may differ.  Inadmissible designs are gray.

    Raises `RequestError` for a tuning without a surface.
    """
    _refuse_without_surface(view)
    held, several = _held(view), view["optimum_objective"].size > 1
    more = bool(held) + (several and not page.beside)
    figure, axes = _frame(page, page.map_width - _ASIDE, more)
    mesh, label = _fill_surface(axes, view)
    _explain(add_color_bar(figure, mesh, axes.get_position(), label))
    write_title(figure, view.text("title"), page.left / page.width, held)
    return figure


def _fill_surface(axes: Axes, view: ArchiveView) -> tuple[QuadMesh, str]:
    """Draw surface, optima and labels into axes, and return the shades and what they are.

    Raises `RequestError` for a tuning without a surface.
    """
    _refuse_without_surface(view)
    mesh = _draw_surface(axes, view)
    _mark_optima(axes, view)
    for name, axis in zip(_names(view), (axes.xaxis, axes.yaxis), strict=True):
        axis.set_label_text(axis_label(name))
    return mesh, _objective(view)


def _refuse_without_surface(view: ArchiveView) -> None:
    if "surface" not in view:
        raise RequestError(f"{view.path} holds no surface: tune with --surface A,B")


def _explain(bar: Colorbar) -> None:
    """Write out the numbers on a bar of logarithmic shades."""
    if isinstance(bar.norm, LogNorm):
        write_out_ticks(bar.ax.yaxis)


def _names(view: ArchiveView) -> list[str]:
    """Return the two parameters of the surface."""
    return [dim.removeprefix("surface_") for dim in view.dims("surface")]


def _held(view: ArchiveView) -> str:
    """Return in one line the free parameters that are constant on the surface."""
    prefix, shown = _OPTIMUM, _names(view)
    free = [n.removeprefix(prefix) for n in view.names if n.startswith(prefix)]
    held = [
        f"${latex_symbol(n)}$ = {view[prefix + n][0]:.4g} {raised(described(n).unit)}"
        for n in free
        if n in DESCRIBED and n not in shown
    ]
    return f"with {', '.join(held)} as in the best" if held else ""


def _draw_surface(axes: Axes, view: ArchiveView) -> QuadMesh:
    """Draw the objective in shades, which are returned, and a few contours over them."""
    across, up = (view[dim] for dim in view.dims("surface"))
    found = np.ma.masked_invalid(drawable(view["surface"])).T
    norm = _norm(found)
    shades = matplotlib.colormaps[SHADES].with_extremes(bad=NO_VALUE)
    style: dict[str, Any] = {"cmap": shades, "norm": norm, "shading": "flat", "rasterized": True}
    mesh = axes.pcolormesh(inner_edges(across), inner_edges(up), found, **style)
    levels: Any = _FEW_LINES
    if isinstance(norm, LogNorm):
        levels = logarithmic_ticks().tick_values(found.min(), found.max())
    if not evenly_spaced(across):
        axes.set_xscale("log")
        write_out_ticks(axes.xaxis)
    if not evenly_spaced(up):
        axes.set_yscale("log")
        write_out_ticks(axes.yaxis)
    _draw_contours(axes, axes.contour(across, up, found, levels=levels, **_CONTOUR), view)
    return mesh


def _draw_contours(axes: Axes, lines: QuadContourSet, view: ArchiveView) -> None:
    """Outline contours, so that they show on any shade, and write their values on them.

    A value is left out where it would hide the best optimum or another value.
    """
    outline = [Stroke(linewidth=1.3, foreground=_OUTLINE), Normal()]
    lines.set_path_effects(outline)
    best = axes.transData.transform([[view[f"optimum_{name}"][0] for name in _names(view)]])
    taken, unit = [best[0]], view.units("surface")
    written = f"{{:g}} {unit}" if unit != "1" else "{:g}"
    for text in axes.clabel(lines, fmt=written.format, fontsize=_SMALL, inline=False):
        place = axes.transData.transform(text.get_position())
        if min(np.hypot(*(place - other)) for other in taken) < _APART * axes.figure.dpi:
            text.remove()
            continue
        text.set_path_effects([Stroke(linewidth=1.6, foreground=_OUTLINE), Normal()])
        taken.append(place)


def _objective(view: ArchiveView) -> str:
    """Return what stands along an axis or a bar: the objective with its unit."""
    text, unit = view.long_name("optimum_objective"), view.units("objective")
    if text == "largest E1max of all cases":
        return quantity_label("E1max", unit, body=body_of(view.attrs.get("kind")))
    return f"{text} [{raised(unit)}]" if unit != "1" else text


def _norm(found: np.ma.MaskedArray) -> Normalize:
    """Return how values become shades: by logarithm where they span a wide range."""
    if found.count() and 0 < found.min() * _WIDE < found.max():
        return LogNorm(found.min(), found.max())
    return Normalize()


def _mark_optima(axes: Axes, view: ArchiveView) -> None:
    """Mark the optima: a star for the best, circles for those nearly as good."""
    x, y = (view[f"optimum_{name}"] for name in _names(view))
    style: dict[str, Any] = {"linestyle": "none", "clip_on": False, "zorder": 5}
    ring: dict[str, Any] = {"mfc": "none", "mec": _MARK, "mew": 1.1}
    star: dict[str, Any] = {"mfc": _MARK, "mec": "white", "mew": 0.6}
    axes.plot(x[:1], y[:1], marker="*", markersize=11, label=_best(view), **star, **style)
    if x.size > 1:
        label = "nearly as good, perhaps off the surface"
        axes.plot(x[1:], y[1:], marker="o", markersize=6, label=label, **ring, **style)
    # above the frame, where it hides nothing
    place: dict[str, Any] = {"bbox_to_anchor": (0.0, 1.0), "borderpad": 0, "borderaxespad": 0.4}
    columns = 2 if size_of(axes)[0] > _WIDE_LEGEND else 1
    axes.legend(loc="lower left", ncols=columns, handletextpad=0.2, **place)


PICTURE = Picture(
    panels=lambda view: {"objective": view.long_name("optimum_objective")},
    draw=lambda view, names, page: tuning_picture(view, page),
    fill=_fill,
)
"""What draws the archive of a tuning."""
