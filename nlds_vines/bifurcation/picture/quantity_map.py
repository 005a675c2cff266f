"""Maps of a recorded number over two parameters, or of the share of starts in a regime."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import (
    BoundaryNorm,
    Colormap,
    LinearSegmentedColormap,
    ListedColormap,
    LogNorm,
    Normalize,
)
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter, PercentFormatter
from matplotlib.transforms import Bbox

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import LOG, SHARE, way_and_number
from nlds_vines.bifurcation.picture.dot_panel import PASSES
from nlds_vines.bifurcation.picture.map_panel import fill_cells, hatch_cells, single_map
from nlds_vines.bifurcation.picture.ordinates import quantities_in, violated_in
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import UNKNOWN, by_frequency, finals, share_of
from nlds_vines.model.quantities import scale_of
from nlds_vines.model.quantity import ERROR, PERIOD, SIGNED, WAIT
from nlds_vines.plotting.notation import literal
from nlds_vines.plotting.page import TWO_COLUMNS, Page, write_out_ticks
from nlds_vines.plotting.palette import OTHERS, PASSED, RAMP
from nlds_vines.plotting.panels import add_color_bar
from nlds_vines.plotting.style import CM, NO_VALUE, ROUND_OFF, SHADES, axis_label

_TWO_SIDED = "PuOr_r"  # matplotlib's name of shades with a zero in their middle; color-blind-safe
_EXTREME = 0.5  # per cent of the cells at either end that do not stretch a two-sided scale
_NARROWEST = 1e-12  # least reach of a two-sided scale to either side
_UNEVEN = 3.0  # how much farther one side of it may reach than the other: colors have equal steps
_LIGHTER = 0.36  # of the shades above zero: their end is lighter than that below, in gray as well
_DEEPEST = 1e-4  # of the largest number: smaller ones have the darkest shade by logarithm
_WIDE = 8.0  # ratio of the largest to a small value from which shades are logarithmic by themselves
_SETTLED_LATE = 10.0  # forcing periods, least upper end of the scale of settling times
_NONE = "none found"


def draw_number(view: ArchiveView, show: str, page: Page = TWO_COLUMNS) -> Figure:
    """Return a map of a recorded number, as `fill_number` draws it, with its bar."""
    figure, axes = single_map(view, page)
    mesh, label, extend = fill_number(axes, view, show)
    bar = add_color_bar(figure, mesh, axes.get_position(), label, extend=extend)
    if scale_of(way_and_number(show)[1]) == PERIOD:
        _name_periods(bar.ax)
    elif isinstance(mesh.norm, LogNorm):
        write_out_ticks(bar.ax.yaxis)
    else:
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
    low, high = mesh.get_clim()
    if low is not None and high is not None and low < 0.0 < high:
        bar.ax.axhline(0.0, color="black", linewidth=0.8)
    return figure


def fill_number(axes: Axes, view: ArchiveView, show: str) -> tuple[QuadMesh, str, str]:
    """Fill cells by a recorded number: of several starts the largest, gray where there is none.

    Arguments: axes; the archive; what to `show`, a number that may follow one of `choices.WAYS`.
    A number of both signs has two-sided shades around zero.  On a map of settling times, cells in
    which a start did not settle are black.  Hatched are cells in which the limit is passed.

    Returns the mesh, and label and ends (`extend`) of its bar.
    """
    way, name = way_and_number(show)
    quantity = quantities_in(view)[name]
    values = _largest(quantity.of(view)[..., 0])
    unsettled = np.zeros(values.shape, dtype=bool)
    if scale_of(name) == WAIT:
        unsettled |= (view[name] < 0).any(axis=-1)
    shown = np.ma.masked_where(unsettled | ~np.isfinite(values), values)
    shades, norm = _scale(quantity.dataset, shown, way)
    mesh = fill_cells(axes, view, shown, cmap=shades.with_extremes(bad=NO_VALUE), norm=norm)
    marks: list[Any] = [_blacken(axes, view, unsettled)] if unsettled.any() else []
    if np.any(~np.isfinite(values) & ~unsettled):
        marks.append(Patch(facecolor=NO_VALUE, label=_NONE))
    passed = np.asarray(violated_in(view).any(axis=-1))
    if passed.any():
        marks.append(hatch_cells(axes, view, passed, (PASSED, "#8b0000"), PASSES))
    if marks:
        look: dict[str, Any] = {"borderaxespad": 0.2, "handlelength": 1.2, "ncols": len(marks)}
        axes.legend(handles=marks, loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)
    several = f", largest of {view['start'].size} starts" if view["start"].size > 1 else ""
    return mesh, quantity.label + several, _extend(shown, norm)


def _largest(values: np.ndarray) -> np.ndarray:
    """Return the largest finite value of the starts (..., starts); NaN where there is none."""
    found = np.where(np.isfinite(values), values, -np.inf).max(axis=-1)
    return np.where(np.isfinite(found), found, np.nan)


def _scale(name: str, shown: np.ma.MaskedArray, way: str) -> tuple[Colormap, Normalize]:
    """Return how values become shades: settling and errors by logarithm, signed ones around 0.

    Others become shades by logarithm where they span decades; `way`, one of `WAYS`, decides.
    """
    values, plain, scale = shown.compressed(), matplotlib.colormaps[SHADES], scale_of(name)
    if scale == PERIOD:
        return ListedColormap(list(RAMP)), BoundaryNorm(
            np.arange(len(RAMP) + 1) + 0.5, len(RAMP), extend="neither", clip=True
        )
    if scale == ERROR:
        low = max(values[values > 0].min(initial=np.inf), ROUND_OFF)
        high = values.max(initial=0.0)
        low, high = (low, high) if low < high else (ROUND_OFF, 1.0)
        return plain, LogNorm(low, high, clip=True)
    if scale == WAIT:
        return plain, LogNorm(1, max(_SETTLED_LATE, values.max(initial=0.0)), clip=True)
    low, high = values.min(initial=0.0), values.max(initial=0.0)
    least = values.min(initial=np.inf)
    small = max(least, high * _DEEPEST) if least > 0.0 else 0.0
    if way == LOG and not 0.0 < small < high:
        raise RequestError(f"show = '{LOG}{name}': it takes numbers above 0 that differ")
    signed = scale == SIGNED or low < 0.0 < high
    if way == LOG or (not way and not signed and 0.0 < small * _WIDE < high):
        return plain, LogNorm(small, high)
    if values.size and signed:
        return _around_zero(values)
    return plain, Normalize()


def _extend(shown: np.ma.MaskedArray, norm: Normalize) -> str:
    """Return at which ends of a scale there are values beyond it, as color bars call them."""
    if norm.vmin is None or norm.vmax is None or norm.clip or not shown.count():
        return "neither"
    beyond = bool(shown.min() < norm.vmin), bool(shown.max() > norm.vmax)
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get(beyond, "neither")


def _around_zero(values: np.ndarray) -> tuple[Colormap, Normalize]:
    """Return two-sided shades whose middle is zero; of one sign alone, that half of them.

    A step of the number is the same step of color on either side.  What lies beyond either end of
    the scale has the color of that end.
    """
    two_sided = matplotlib.colormaps[_TWO_SIDED]
    low, high = np.percentile(values, [_EXTREME, 100 - _EXTREME])
    if low < 0.0 < high:
        reach = max(min(max(-low, high), _UNEVEN * min(-low, high)), _NARROWEST)
        ends = max(low, -reach), min(high, reach)
        part = np.linspace(*ends, 256) / reach
        places = 0.5 + np.where(part < 0.0, 0.5, _LIGHTER) * part
        return LinearSegmentedColormap.from_list("signed", two_sided(places)), Normalize(*ends)
    shades = np.linspace(0.5, 1.0, 256) if high > 0.0 else np.linspace(0.0, 0.5, 256)
    half = LinearSegmentedColormap.from_list("half", two_sided(shades))
    return half, Normalize(min(low, 0.0), max(high, 0.0) or _NARROWEST)


def _name_periods(bar: Axes) -> None:
    """Name the colors of a bar of periods."""
    count = len(RAMP)
    names = [*(str(n) for n in range(1, count)), f"{count} or more"]
    bar.set_yticks(range(1, count + 1), names)
    bar.tick_params(which="both", length=0)


def _blacken(axes: Axes, view: ArchiveView, where: np.ndarray) -> Patch:
    """Draw cells black, and return the entry of the legend that names the reason."""
    color = OTHERS["chaos"]
    covered = np.ma.masked_where(~where, np.ones(where.shape))
    fill_cells(axes, view, covered, cmap=ListedColormap([color]))
    return Patch(facecolor=color, label="not settled, or no orbit to settle on")


# ---- shares --------------------------------------------------------------------------------------


_MOST, _COLUMNS = 6, 2  # small maps of one picture, and of one row
_PANEL, _BETWEEN, _FOOT, _HEAD = 5.2 * CM, 0.75 * CM, 1.15 * CM, 1.5 * CM  # heights in inches
_BAR = 0.8 * CM  # inches, room for the bar of all maps


def draw_shares(view: ArchiveView, show: str, page: Page = TWO_COLUMNS) -> Figure:
    """Return maps of the share of the starts that ended in a regime.

    Arguments: `show` is `share:LABEL` for one map, `shares` for those of the most frequent known
    regimes, side by side; the `page`.

    Raises `RequestError` where no start ended in a known regime.
    """
    labels = view["label"]
    wanted = [show.removeprefix(SHARE)]
    if not show.startswith(SHARE):
        found = [label for label, _ in by_frequency(finals(labels)) if label not in UNKNOWN]
        wanted = found[:_MOST]
    if not wanted:
        raise RequestError(f"{view.path}: no start ended in a known regime, so there is no share")
    text = f"share of {labels.shape[-1]} starts"
    if len(wanted) == 1:
        figure, axes = single_map(view, page)
        mesh, text = _draw_share(axes, view, labels, wanted[0]), f"{text} in {literal(wanted[0])}"
        place = axes.get_position()
    else:
        figure, panels = _small_maps(view, wanted, page)
        meshes = [_draw_share(panels[i], view, labels, name) for i, name in enumerate(wanted)]
        mesh, place = meshes[-1], Bbox.union([axes.get_position() for axes in panels])
    percent = PercentFormatter(1.0, decimals=0)
    add_color_bar(figure, mesh, place, text, format=percent)
    return figure


def _small_maps(view: ArchiveView, names: list[str], page: Page) -> tuple[Figure, list[Axes]]:
    """Return a figure with a small panel for each name, and the panels in reading order."""
    columns = _COLUMNS if page.beside else 1
    rows = -(-len(names) // columns)
    height = _HEAD + rows * _PANEL + (rows - 1) * _BETWEEN + _FOOT
    figure = Figure(figsize=(page.width, height))
    grid = {"left": page.left / page.width, "right": 1 - (page.right + _BAR) / page.width}
    grid |= {"bottom": _FOOT / height, "wspace": 0.08}
    grid |= {"top": 1 - _HEAD / height, "hspace": _BETWEEN / _PANEL}
    panels = figure.subplots(
        rows, columns, sharex=True, sharey=True, squeeze=False, gridspec_kw=grid
    )
    for axes in panels.flat[len(names) :]:
        axes.set_axis_off()
    for axes, name in zip(panels.flat, names, strict=False):
        axes.set_title(name, fontsize=rcParams["font.size"], pad=3)
    # the lowest panel of each column, which is in the row above where the last row is not full
    for axes in panels.flat[max(0, len(names) - columns) : len(names)]:
        axes.set_xlabel(axis_label(view.axes[0]))
        axes.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel(axis_label(view.axes[1]))
    return figure, list(panels.flat)


def _draw_share(axes: Axes, view: ArchiveView, labels: np.ndarray, label: str) -> QuadMesh:
    """Fill every cell by the share of its starts in one regime, from none to all."""
    return fill_cells(axes, view, share_of(labels, label), cmap=SHADES, norm=Normalize(0, 1))
