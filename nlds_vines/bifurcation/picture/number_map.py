"""Maps of a recorded number over two parameters."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.map_cells import fill_cells, mark_cells, single_map
from nlds_vines.plotting.bands import drawable
from nlds_vines.plotting.palette import OTHERS
from nlds_vines.plotting.panels import add_colour_bar
from nlds_vines.plotting.style import ERRORS, NO_VALUE, ROUND_OFF, SHADES, quantity_label

_TWO_SIDED = "PuOr_r"  # matplotlib's name of shades with a zero in their middle; colour-blind-safe
_SIGNED = ("lyapunov", "transient_lyapunov")  # the numbers that are drawn in those
_EXTREME = 0.5  # per cent of the cells at either end that do not stretch a two-sided scale
_NARROWEST = 1e-12  # 1/s, least reach of a two-sided scale to either side
_VIOLATED = "comes where it must not"
_SETTLED_LATE = 10.0  # forcing periods, least upper end of the scale of settling times


def draw_number(view: ArchiveView, name: str) -> Figure:
    """Return a map of a recorded number: of several starts the largest, grey where there is none.

    On a map of settling times, cells in which a start did not settle are black.  Where a scene has
    a limit, a dot marks the cells in which it is violated.
    """
    figure, axes = single_map(view)
    values = _largest(drawable(view[name]))
    unsettled = np.zeros(values.shape, dtype=bool)
    if name == "settling":
        unsettled |= (view[name] < 0).any(axis=-1)
    shown = np.ma.masked_where(unsettled | ~np.isfinite(values), values)
    shades = matplotlib.colormaps[_TWO_SIDED if name in _SIGNED else SHADES]
    style = {"cmap": shades.with_extremes(bad=NO_VALUE), "norm": _norm(name, shown)}
    mesh = fill_cells(axes, view, shown, **style)
    marks: list[Any] = [_blacken(axes, view, unsettled)] if unsettled.any() else []
    if "violations" in view and np.any(view["violations"] > 0):
        violated = np.asarray(np.any(view["violations"] > 0, axis=-1))
        marks.append(mark_cells(axes, view, violated, _VIOLATED))
    if marks:
        look: dict[str, Any] = {"borderaxespad": 0.2, "handlelength": 1.2, "ncols": len(marks)}
        axes.legend(handles=marks, loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)
    several = f", largest of {view['start'].size} starts" if view["start"].size > 1 else ""
    label = quantity_label(name, view.units(name)) + several
    extend = "both" if name in _SIGNED else "neither"
    bar = add_colour_bar(figure, mesh, axes.get_position(), label, extend=extend)
    if not isinstance(mesh.norm, LogNorm):
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
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
        return LogNorm(1, max(_SETTLED_LATE, values.max(initial=0.0)), clip=True)
    if name in _SIGNED and values.size:
        low, high = np.percentile(values, [_EXTREME, 100 - _EXTREME])
        return TwoSlopeNorm(0.0, min(low, -_NARROWEST), max(high, _NARROWEST))
    return Normalize()


def _blacken(axes: Axes, view: ArchiveView, where: np.ndarray) -> Patch:
    """Draw cells black, and return the entry of the legend that names the reason."""
    colour = OTHERS["chaos"]
    covered = np.ma.masked_where(~where, np.ones(where.shape))
    fill_cells(axes, view, covered, cmap=ListedColormap([colour]))
    return Patch(facecolor=colour, label="not settled, or no orbit to settle on")
