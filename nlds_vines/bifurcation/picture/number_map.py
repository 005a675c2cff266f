"""Numbers over two parameters: a recorded one, or the shares of regimes."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter, PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import SHARE
from nlds_vines.orbits.coexistence import UNKNOWN, by_frequency, finals, share_of
from nlds_vines.plotting.bands import edges
from nlds_vines.plotting.style import (
    CM,
    ERRORS,
    LEFT,
    RIGHT,
    ROUND_OFF,
    STYLE,
    WIDTH,
    axis_label,
    quantity_label,
)

_HEIGHT = 11 * CM
_ACROSS = 0.665  # width of a single map, as a fraction of the figure's
_NOTHING = "#c8c8c8"
_NEVER = "#1a1a1a"
_SHADES = "viridis"
_TWO_SIDED = "PuOr_r"  # with a zero in its middle; colour-blind-safe
_SIGNED = ("lyapunov", "transient_lyapunov")
_MOST_SHARES = 6
_FEW = 8  # values that are a list where their distances are unequal
_COLUMNS = 2
_SMALL, _BETWEEN, _FOOT, _HEAD = 5.2 * CM, 0.75 * CM, 1.15 * CM, 1.5 * CM  # heights in inches
_EXTREME = 0.5  # per cent of the cells at either end that do not stretch a two-sided scale
_MARK, _LARGEST_MARK = 0.4, 3.0  # of a cell's smaller side; points


def frame(figure: Figure, bottom: float, height: float) -> Axes:
    """Return axes for a map beside room for a legend; fractions of the figure's height."""
    return figure.add_axes((LEFT, bottom, _ACROSS, height))


def one_frame(view: ArchiveView) -> tuple[Figure, Axes]:
    """Return a figure with one map, its axes labelled."""
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axes = frame(figure, 0.115, 0.8)
    axes.set_xlabel(axis_label(view.axes[0]))
    axes.set_ylabel(axis_label(view.axes[1]))
    return figure, axes


def fill(axes: Axes, view: ArchiveView, values: np.ndarray, **style: Any) -> QuadMesh:
    """Draw one value for each cell, without any smoothing, and return the mesh."""
    across, up = (_borders(view[name]) for name in view.axes)
    for axis, name in zip((axes.xaxis, axes.yaxis), view.axes, strict=True):
        if _is_list(view[name]):
            axis.set_ticks(np.arange(view[name].size), [f"{value:g}" for value in view[name]])
    return axes.pcolormesh(across, up, values.T, shading="flat", rasterized=True, **style)


def mark(axes: Axes, view: ArchiveView, where: np.ndarray, text: str) -> Line2D:
    """Put a dot into the cells of which `where` is true; return such a dot for a legend."""
    lists = [_is_list(view[name]) for name in view.axes]
    scales = [
        np.arange(view[name].size) if listed else view[name]
        for name, listed in zip(view.axes, lists, strict=True)
    ]
    dot = 72 / axes.figure.dpi  # points
    cell = dot * min(axes.bbox.width / where.shape[0], axes.bbox.height / where.shape[1])
    across, up = (scale[index] for scale, index in zip(scales, np.nonzero(where), strict=True))
    look: dict[str, Any] = {"marker": "o", "linestyle": "none", "markerfacecolor": "white"}
    look |= {"markeredgecolor": "black", "markeredgewidth": min(0.1 * cell, 0.5)}
    axes.plot(across, up, markersize=min(_MARK * cell, _LARGEST_MARK), rasterized=True, **look)
    return Line2D([], [], markersize=_LARGEST_MARK, label=text, **look)


def _is_list(values: np.ndarray) -> bool:
    """Tell whether values are a few at unequal distances: cells in a row, rather than a scale."""
    gaps = np.diff(values)
    return 2 < values.size <= _FEW and not np.allclose(gaps, gaps[0], rtol=1e-6)


def _borders(values: np.ndarray) -> np.ndarray:
    """Return where cells begin and end on an axis."""
    return edges(np.arange(values.size)) if _is_list(values) else edges(values)


def draw_number(view: ArchiveView, name: str) -> Figure:
    """Return a map of a recorded number: of several starts the largest, grey where there is none.

    Cells of which a start did not settle are black on a map of settling times.
    """
    figure, axes = one_frame(view)
    values = _largest(view[name].astype(float))
    never = np.zeros(values.shape, dtype=bool)
    if name == "settling":
        never |= (view[name] < 0).any(axis=-1)
    shown = np.ma.masked_where(never | ~np.isfinite(values), values)
    shades = matplotlib.colormaps[_TWO_SIDED if name in _SIGNED else _SHADES]
    mesh = fill(axes, view, shown, cmap=shades.with_extremes(bad=_NOTHING), norm=_norm(name, shown))
    if never.any():
        _cover(axes, view, never)
    box = axes.get_position()
    bar_axes = figure.add_axes((box.x1 + 0.02, box.y0, 0.023, box.height))
    extend = "both" if name in _SIGNED else "neither"
    bar = figure.colorbar(mesh, cax=bar_axes, extend=extend)
    if not isinstance(mesh.norm, LogNorm):
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
    several = f", largest of {view['start'].size} starts" if view["start"].size > 1 else ""
    bar.set_label(quantity_label(name, view.units(name)) + several)
    return figure


def _largest(values: np.ndarray) -> np.ndarray:
    """Return the largest finite value of the starts (..., starts); NaN where there is none."""
    found = np.where(np.isfinite(values), values, -np.inf).max(axis=-1)
    return np.where(np.isfinite(found), found, np.nan)


def _norm(name: str, shown: np.ma.MaskedArray) -> Normalize:
    """Return how values become shades: settling and errors by logarithm, exponents around 0."""
    values = shown.compressed()
    if name in ERRORS:
        low = max(values[values > 0].min(initial=np.inf), ROUND_OFF)
        high = values.max(initial=0.0)
        low, high = (low, high) if low < high else (ROUND_OFF, 1.0)
        return LogNorm(low, high, clip=True)
    if name == "settling":
        return LogNorm(1, max(10.0, values.max(initial=0.0)), clip=True)
    if name in _SIGNED and values.size:
        low, high = np.percentile(values, [_EXTREME, 100 - _EXTREME])
        return TwoSlopeNorm(0.0, min(low, -1e-12), max(high, 1e-12))
    return Normalize()


def _cover(axes: Axes, view: ArchiveView, where: np.ndarray) -> None:
    """Blacken cells, and say why."""
    black = matplotlib.colors.ListedColormap([_NEVER])
    fill(axes, view, np.ma.masked_where(~where, np.ones(where.shape)), cmap=black)
    patch = Patch(facecolor=_NEVER, label="not settled, or no orbit to settle on")
    look: dict[str, Any] = {"borderaxespad": 0.2, "frameon": False, "handlelength": 1.2}
    axes.legend(handles=[patch], loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)


def draw_shares(view: ArchiveView, show: str) -> Figure:
    """Return maps of the share of the starts that ended in a regime, or in each of several."""
    labels = view["label"]
    wanted = [show.removeprefix(SHARE)]
    if not show.startswith(SHARE):
        found = [label for label, _ in by_frequency(finals(labels)) if label not in UNKNOWN]
        wanted = found[:_MOST_SHARES]
    if len(wanted) == 1:
        figure, axes = one_frame(view)
        mesh = _draw_share(axes, view, labels, wanted[0])
        box = axes.get_position()
        bar_axes = figure.add_axes((box.x1 + 0.02, box.y0, 0.023, box.height))
        _bar(figure, bar_axes, mesh, f"share of {labels.shape[-1]} starts in {wanted[0]}")
        return figure
    return _multiples(view, labels, wanted)


def _multiples(view: ArchiveView, labels: np.ndarray, wanted: list[str]) -> Figure:
    """Return small maps side by side with one bar for all."""
    rows = -(-len(wanted) // _COLUMNS)
    height = _HEAD + rows * _SMALL + (rows - 1) * _BETWEEN + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    grid = {"left": LEFT, "right": RIGHT - 0.05, "bottom": _FOOT / height, "wspace": 0.08}
    grid |= {"top": 1 - _HEAD / height, "hspace": _BETWEEN / _SMALL}
    panels = figure.subplots(
        rows, _COLUMNS, sharex=True, sharey=True, squeeze=False, gridspec_kw=grid
    )
    for axes in panels.flat[len(wanted) :]:
        axes.set_axis_off()
    for axes, label in zip(panels.flat, wanted, strict=False):
        mesh = _draw_share(axes, view, labels, label)
        axes.set_title(label, fontsize=STYLE["font.size"], pad=3)
    for axes in panels.flat[max(0, len(wanted) - _COLUMNS) : len(wanted)]:
        axes.set_xlabel(axis_label(view.axes[0]))
        axes.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel(axis_label(view.axes[1]))
    bar_axes = figure.add_axes((RIGHT - 0.03, _FOOT / height, 0.02, 1 - (_HEAD + _FOOT) / height))
    _bar(figure, bar_axes, mesh, f"share of {labels.shape[-1]} starts")
    return figure


def _draw_share(axes: Axes, view: ArchiveView, labels: np.ndarray, label: str) -> QuadMesh:
    return fill(axes, view, share_of(labels, label), cmap=_SHADES, norm=Normalize(0, 1))


def _bar(figure: Figure, bar_axes: Axes, mesh: QuadMesh, text: str) -> None:
    bar = figure.colorbar(mesh, cax=bar_axes, format=PercentFormatter(1.0, decimals=0))
    bar.set_label(text)
