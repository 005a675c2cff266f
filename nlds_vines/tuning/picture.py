"""Pictures of a tuning: the objective over two parameters or along the only one, and the optima."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.plotting.bands import drawable, evenly_spaced, inner_edges
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    logarithmic_ticks,
    new_figure,
    styled,
    write_out_ticks,
)
from nlds_vines.plotting.style import (
    NAVY,
    NO_VALUE,
    SHADES,
    axis_label,
    body_of,
    latex_symbol,
    quantity_label,
    raised,
)

_WIDE = 8.0  # ratio of the largest to the smallest value from which shades are logarithmic
_SMALL = 7.5  # points, numbers on contours
_APART = 0.3  # inches, the least distance of two of them
_OUTLINE = "#202020"
_FEW_LINES = 8  # contours where shades are linear
_OPTIMUM = "optimum_"
_MARK = "#d7191c"  # a red that neither the shades nor the contours have


@styled()
def tuning_picture(view: ArchiveView, page: Page = TWO_COLUMNS) -> Figure:
    """Return the picture of a tuning: its surface, or the curve along its only free parameter.

    Inadmissible designs are gray.  The other parameters are those of the best optimum.
    """
    figure, grid = new_figure(page, [page.map_height])
    _fill(figure.add_subplot(grid[0]), view)
    constant = ", ".join(
        f"${latex_symbol(n)}$ = {_with_unit(view[_OPTIMUM + n][0], DESCRIBED[n].unit)}"
        for n in _free(view)
        if "surface" in view and f"surface_{n}" not in view.dims("surface")
    )
    finish(figure, grid, view.text("title"), constant and f"with {constant} as in the best")
    return figure


def _fill(axes: Axes, view: ArchiveView, name: str = "") -> None:
    free = _free(view)
    if "surface" in view:
        _draw_surface(axes, view)
    elif len(free) == 1:
        _draw_curve(axes, view, free[0])
    elif free:
        _draw_designs(axes, view, free[0], free[1])
    else:
        raise RequestError(f"{view.path} has no free parameter that can be drawn")
    add_legend(axes, axes.get_legend_handles_labels()[0], "above")


def _free(view: ArchiveView) -> list[str]:
    """Return the parameters that are free and enter the dynamics."""
    names = (name.removeprefix(_OPTIMUM) for name in view.names if name.startswith(_OPTIMUM))
    return [name for name in names if name in DESCRIBED and name != "V"]


def _draw_curve(axes: Axes, view: ArchiveView, name: str) -> None:
    codes = {word: code for code, word in view.flags("stage").items()}
    plain = view["stage"] != codes["robustness"]
    values, objectives = view[name][plain], drawable(view["objective"])[plain]
    order = np.argsort(values)
    x, y = values[order], objectives[order]
    axes.plot(x, y, "o-", markersize=2.5, linewidth=0.6, color=NAVY, label="designs")
    best, optima = view["optimum_objective"], view[f"{_OPTIMUM}{name}"]
    axes.plot(optima[:1], best[:1], "*", markersize=11, zorder=5, color=_MARK, label=_best(view))
    finite = objectives[np.isfinite(objectives)]
    if finite.size and 0 < finite.min() * _WIDE < finite.max():
        axes.set_yscale("log")
        write_out_ticks(axes.yaxis)
    if values.min() > 0 and values.max() > _WIDE * values.min():
        axes.set_xscale("log")
        write_out_ticks(axes.xaxis)
    axes.tick_params(top=True, right=True, which="both")
    axes.set_xlabel(axis_label(name))
    axes.set_ylabel(_objective(view))


def _draw_designs(axes: Axes, view: ArchiveView, first: str, second: str) -> None:
    """Draw the designs of the search over two parameters, in the color of their objective."""
    codes = {word: code for code, word in view.flags("stage").items()}
    searched = np.isin(view["stage"], [codes["global"], codes["polish"]])
    objectives = drawable(view["objective"])[searched]
    x, y = view[first][searched], view[second][searched]
    finite = np.isfinite(objectives)
    look: dict[str, Any] = {"s": 9.0, "linewidths": 0.0}
    if not finite.all():
        axes.scatter(x[~finite], y[~finite], color=NO_VALUE, label="inadmissible", **look)
    order = np.argsort(-objectives[finite])  # the best on top
    values = objectives[finite][order]
    norm: Normalize = Normalize()
    if values.size and 0 < values.min() * _WIDE < values.max():
        norm = LogNorm(values.min(), values.max())
    dots = axes.scatter(
        x[finite][order], y[finite][order], c=values, cmap=SHADES, norm=norm, **look
    )
    best_x, best_y = view[f"{_OPTIMUM}{first}"], view[f"{_OPTIMUM}{second}"]
    star: dict[str, Any] = {"markersize": 11, "mfc": _MARK, "mec": "white", "mew": 0.6}
    axes.plot(best_x[:1], best_y[:1], "*", zorder=5, label=_best(view), **star)
    for values_of_axis, axis, scale in (
        (x, axes.xaxis, axes.set_xscale),
        (y, axes.yaxis, axes.set_yscale),
    ):
        if values_of_axis.min() > 0.0 and values_of_axis.max() > _WIDE * values_of_axis.min():
            scale("log")
            write_out_ticks(axis)
    axes.set(xlabel=axis_label(first), ylabel=axis_label(second))
    size: dict[str, Any] = {"pad": 0.02, "fraction": 0.06, "aspect": 24}
    axes.figure.colorbar(dots, ax=axes, label=_objective(view), **size)


def _best(view: ArchiveView) -> str:
    return f"best: {_with_unit(view['optimum_objective'][0], view.units('optimum_objective'))}"


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.4g}" if unit == "1" else f"{value:.4g} {raised(unit)}"


def _draw_surface(axes: Axes, view: ArchiveView) -> None:
    dims, unit = view.dims("surface"), view.units("surface")
    across, up = (view[dim] for dim in dims)
    names = [dim.removeprefix("surface_") for dim in dims]
    objective = np.ma.masked_invalid(drawable(view["surface"])).T
    norm: Normalize = Normalize()
    levels: Any = _FEW_LINES
    if objective.count() and 0 < objective.min() * _WIDE < objective.max():
        norm = LogNorm(objective.min(), objective.max())
        levels = logarithmic_ticks().tick_values(objective.min(), objective.max())
    shades = matplotlib.colormaps[SHADES].with_extremes(bad=NO_VALUE)
    style: dict[str, Any] = {"cmap": shades, "norm": norm, "shading": "flat", "rasterized": True}
    mesh = axes.pcolormesh(inner_edges(across), inner_edges(up), objective, **style)
    for values, axis, scale in (
        (across, axes.xaxis, axes.set_xscale),
        (up, axes.yaxis, axes.set_yscale),
    ):
        if not evenly_spaced(values):
            scale("log")
            write_out_ticks(axis)
    # contours have an outline, so that they show on any shade; a value that would hide the best
    # optimum or another value is left out
    lines = axes.contour(across, up, objective, levels=levels, colors="white", linewidths=0.5)
    lines.set_path_effects([Stroke(linewidth=1.3, foreground=_OUTLINE), Normal()])
    x, y = (view[_OPTIMUM + name] for name in names)
    occupied = [axes.transData.transform((x[0], y[0]))]
    written = f"{{:g}} {unit}" if unit != "1" else "{:g}"
    for text in axes.clabel(lines, fmt=written.format, fontsize=_SMALL, inline=False):
        place = axes.transData.transform(text.get_position())
        if min(np.hypot(*(place - other)) for other in occupied) < _APART * axes.figure.dpi:
            text.remove()
            continue
        text.set_path_effects([Stroke(linewidth=1.6, foreground=_OUTLINE), Normal()])
        occupied.append(place)
    # a star for the best optimum, circles for those nearly as good
    look: dict[str, Any] = {"clip_on": False, "zorder": 5, "label": _best(view)}
    axes.plot(x[:1], y[:1], "*", markersize=11, mfc=_MARK, mec="white", mew=0.6, **look)
    if x.size > 1:
        look["label"] = "nearly as good, perhaps off the surface"
        axes.plot(x[1:], y[1:], "o", markersize=6, mfc="none", mec=_MARK, mew=1.1, **look)
    axes.set(xlabel=axis_label(names[0]), ylabel=axis_label(names[1]))
    size: dict[str, Any] = {"pad": 0.02, "fraction": 0.06, "aspect": 24}
    bar = axes.figure.colorbar(mesh, ax=axes, label=_objective(view), **size)
    if isinstance(norm, LogNorm):
        write_out_ticks(bar.ax.yaxis)


def _objective(view: ArchiveView) -> str:
    judged, unit = view.long_name("optimum_objective").partition(":")[0], view.units("objective")
    name = judged.removeprefix("largest ").removesuffix(" of all cases")
    if name in BY_NAME:
        cases = "" if name == judged else ", largest of all cases"
        return quantity_label(name, unit, body=body_of(view.attrs.get("kind"))) + cases
    return f"{judged} [{raised(unit)}]" if unit != "1" else judged


PICTURE = Picture(
    panels=lambda view: {"objective": view.long_name("optimum_objective")},
    draw=lambda view, names, page: tuning_picture(view, page),
    fill=_fill,
)
