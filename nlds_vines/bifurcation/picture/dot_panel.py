"""A panel of a diagram: a quantity over one parameter in dots or curves, a spectrum in colors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from nlds_vines.bifurcation.picture.attractor_styles import Look, looks_of
from nlds_vines.bifurcation.picture.ordinates import Quantity, Slice
from nlds_vines.model.labels import final
from nlds_vines.model.quantities import QUANTITIES, drawn_in, scale_of
from nlds_vines.model.quantity import ERROR, TOUCHED
from nlds_vines.plotting.bands import bands, edges, logarithmic, one_regime
from nlds_vines.plotting.notation import raised, signal_symbol
from nlds_vines.plotting.page import size_of
from nlds_vines.plotting.palette import PASSED, period_and_impacts
from nlds_vines.plotting.style import DOT, GRAY, GREEN, HUES, NAVY, NO_VALUE, ROUND_OFF, SHADES

_WIDTHS = {entry.name: entry.width for entry in QUANTITIES if entry.width}

PASSES = "passes the limit"
"""What a legend says of hatched cells and crossed marks."""

REDUCTION = "reduction"
"""The share of the energy E1max that a damper takes away: axes count it in percent."""

_SECTION_DOTS, _NUMBER_DOTS = (0.75, 1.5), (1.3, 2.0)  # points, of many columns and of few
_EXPONENT_DOT, _LEGEND_DOT = 1.4, 3.0  # points
_COVERED, _FAINTEST = 3.0, 0.04  # times that opaque dots may cover a panel; opacity of others
_HATCH: dict[str, Any] = {"facecolor": "none", "edgecolor": "#d0a0a0", "linewidth": 0}
_CROSSES = 40  # along a curve, at most: more of them hide it
_CROSS: dict[str, Any] = {"marker": "x", "linestyle": "none", "markeredgewidth": 0.7}
_WALL = "impact_wall"
_WALL_COLORS = (NAVY, HUES["vermillion"])  # of impacts at the near and at the far wall
_LIGHTEST = 0.82  # of the shades of curves: lighter ones are too pale on white paper


def fill_panel(
    panel: Axes, cuts: Sequence[Slice], known: Mapping[str, Quantity], name: str
) -> None:
    """Draw a quantity along slices: dots of one slice, a curve for each of several."""
    quantity = known[name]
    if quantity.dataset == WATERFALL:
        draw_waterfall(panel, cuts[0], quantity)
        return
    if len(cuts) > 1:
        _draw_curves(panel, cuts, quantity)
    elif name in _WIDTHS:
        _draw_exponent(panel, cuts[0], quantity, known.get(_WIDTHS[name]))
    else:
        _draw_dots(panel, cuts[0], quantity)
    if len(cuts) == 1:
        _hatch_violated(panel, cuts[0])
    panel.set_ylabel(quantity.label)
    if name == REDUCTION:
        panel.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    if quantity.units == "rad" and quantity.dataset in drawn_in(TOUCHED):
        panel.set_ylim(0.0, 2.0 * np.pi)
    if logarithmic(cuts[0].values):
        panel.set_xscale("log")


def legend_of_panel(cuts: Sequence[Slice], rows: Sequence[str]) -> list[Any]:
    """Return the entries of a legend for panels of these slices and quantities."""
    found: list[Any] = []
    if len(cuts) > 1 and rows:
        line: dict[str, Any] = {"linewidth": 1.2}
        found = [
            Line2D([], [], color=color, label=cut.held, **line)
            for cut, color in zip(cuts, curve_colors(len(cuts)), strict=True)
        ]
    elif rows:
        dot: dict[str, Any] = {"marker": "o", "markersize": _LEGEND_DOT, "linestyle": "none"}
        looks = [look for look in looks_of(cuts[0]) if look.name and look.which.any()]
        found = [Line2D([], [], color=look.color, label=look.name, **dot) for look in looks]
        if any(_tells_walls(cuts[0], name) for name in rows):
            names = [name.replace("_", " ") for name in cuts[0].view.flags(_WALL).values()]
            pairs = zip(names, _WALL_COLORS, strict=True)
            found += [
                Line2D([], [], color=hue, label=f"at the {name}", **dot) for name, hue in pairs
            ]
    if any(cut.violated().any() for cut in cuts):
        text = PASSES if len(cuts) == 1 else f"{PASSES} (crosses)"
        found.append(Patch(hatch=PASSED, label=text, **_HATCH))
    return found


def curve_colors(count: int) -> list[Any]:
    """Return the colors of so many curves, from dark to light, along even steps of lightness."""
    return list(matplotlib.colormaps[SHADES](np.linspace(0.0, _LIGHTEST, count)))


def overlay_energy(panel: Axes, cut: Slice, energy: Quantity) -> None:
    """Draw the structure's maximum energy over a panel, on an axis of its own."""
    axes = panel.twinx()
    _draw_curve(axes, cut, cut.of(energy)[:, 0, 0], GREEN, 0.9)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(energy.label, color=GREEN)
    axes.tick_params(axis="y", colors=GREEN)
    axes.spines["right"].set_color(GREEN)


def _draw_curve(axes: Axes, cut: Slice, found: np.ndarray, color: Any, width: float) -> None:
    """Draw a number (cells,) of the first start: a curve within a regime, dots between others.

    Orbits that are not periodic are dots as well.  Without labels all are joined.
    """
    labels = cut.labels()
    if labels is None:
        axes.plot(cut.values, found, color=color, linewidth=width)
        return
    ends = np.array([final(str(label)) for label in labels[:, 0]])
    periodic = np.array([period_and_impacts(end) is not None for end in ends])
    curve, alone = one_regime(cut.values, found, np.where(periodic, ends, ""))
    axes.plot(*curve, color=color, linewidth=width)
    axes.plot(*alone, color=color, markersize=1.3 * width, **DOT)


def _dots_of(cut: Slice, look: Look, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return abscissae and ordinates of the dots of some orbits of (cells, starts, many)."""
    cells, _ = np.nonzero(look.which)
    shown = found[look.which]
    return np.repeat(cut.values[cells], shown.shape[1]), shown.ravel()


def _draw_dots(panel: Axes, cut: Slice, quantity: Quantity) -> None:
    """Draw orbits as unconnected dots, those of one attractor in one color.

    Few columns have larger dots.  Where dots cover the panel more than once, they let others shine
    through, so that chaos shows how often it is where; periodic orbits fall on themselves.
    """
    found = cut.of(quantity)
    if scale_of(quantity.dataset) == ERROR:
        found = np.maximum(found, ROUND_OFF)
        panel.set_yscale("log")
    wide, tall = size_of(panel)
    least, widest = _NUMBER_DOTS if quantity.single else _SECTION_DOTS
    size = min(max(wide / cut.values.size, least), widest)
    covered = np.count_nonzero(np.isfinite(found)) * size**2 / (wide * tall)
    style: dict[str, Any] = {"markersize": size, "rasterized": True, **DOT}
    if not quantity.single and covered > _COVERED:
        style["alpha"] = max(_COVERED / covered, _FAINTEST)
    if _tells_walls(cut, quantity.dataset):
        walls = cut.view.take(_WALL, **cut.at)
        for code, color in enumerate(_WALL_COLORS):
            cells, starts, many = np.nonzero(walls == code)
            panel.plot(cut.values[cells], found[cells, starts, many], color=color, **style)
        return
    for look in looks_of(cut, found if quantity.single else None):
        across, up = _dots_of(cut, look, found)
        panel.plot(across, up, color=look.color, **style)


def _tells_walls(cut: Slice, name: str) -> bool:
    """Tell whether the dots of a quantity are colored by what is struck: of one start, impacts."""
    return len(cut.starts) == 1 and _WALL in cut.view and name in drawn_in(TOUCHED)


def _draw_exponent(panel: Axes, cut: Slice, quantity: Quantity, half: Quantity | None) -> None:
    """Draw exponents as dots over a line at zero.

    Each has its 99 % interval as a bar; the interval of a periodic orbit has no width.
    """
    panel.axhline(0.0, color=GRAY, linewidth=0.6, zorder=0.5)
    found = cut.of(quantity)
    width = np.zeros_like(found) if half is None else cut.of(half)
    for look in looks_of(cut, found):
        (across, up), (_, reach) = _dots_of(cut, look, found), _dots_of(cut, look, width)
        kept = np.isfinite(up) & np.isfinite(reach)
        across, up, reach = across[kept], up[kept], reach[kept]
        bar: dict[str, Any] = {"alpha": 0.35, "linewidth": 1.0, "rasterized": True}
        panel.vlines(across, up - reach, up + reach, color=look.color, **bar)
        dot = {"markersize": _EXPONENT_DOT, "rasterized": True, **DOT}
        panel.plot(across, up, color=look.color, **dot)


def _draw_curves(panel: Axes, cuts: Sequence[Slice], quantity: Quantity) -> None:
    """Draw a quantity along several slices: as curves, or of several starts as dots.

    Crosses mark the orbits that pass a limit.
    """
    if quantity.name in _WIDTHS:
        panel.axhline(0.0, color=GRAY, linewidth=0.6, zorder=0.5)
    if scale_of(quantity.dataset) == ERROR:
        panel.set_yscale("log")
    for cut, color in zip(cuts, curve_colors(len(cuts)), strict=True):
        found = cut.of(quantity)
        many = found.shape[1] * found.shape[2]
        if many == 1:
            _draw_curve(panel, cut, found[:, 0, 0], color, 1.0)
        else:
            across = np.repeat(cut.values, many)
            panel.plot(across, found.ravel(), color=color, markersize=1.4, **DOT)
        cells, starts = np.nonzero(_thinned(cut.violated()))
        if cells.size:
            up = found[cells, starts, 0]
            panel.plot(cut.values[cells], up, color=color, markersize=2.5, **_CROSS)


def _thinned(flagged: np.ndarray) -> np.ndarray:
    """Return which of the flagged cells (n, starts) bear a cross: ends of runs, few in between."""
    before, after = np.zeros_like(flagged), np.zeros_like(flagged)
    before[1:], after[:-1] = flagged[:-1], flagged[1:]
    few = np.arange(len(flagged)) % max(1, len(flagged) // _CROSSES) == 0
    return flagged & (~before | ~after | few[:, np.newaxis])


def _hatch_violated(panel: Axes, cut: Slice) -> None:
    """Hatch the cells in which an orbit passes the limit."""
    passed = cut.violated().any(axis=1)
    if not passed.any():
        return
    for band in bands(cut.values, np.where(passed, PASSES, "")):
        if band.label:
            panel.axvspan(band.low, band.high, hatch=PASSED, zorder=0.2, **_HATCH)


# ---- spectra -------------------------------------------------------------------------------------


WATERFALL = "spectrum"
"""The dataset that is drawn so."""

DECADES = 6.0
"""Below the largest amplitude that colors tell apart."""

_BAR = (1.012, 0.0, 0.014, 1.0)  # of the panel: the bar's left edge, foot, width, height


def draw_waterfall(panel: Axes, cut: Slice, quantity: Quantity) -> None:
    """Draw amplitudes of the first start over the parameter and the frequency."""
    found = cut.of(quantity)[:, 0, :]
    order = cut.view["frequency"]
    largest = float(np.nanmax(found[:, 1:], initial=0.0)) or 1.0
    floor = largest * 10.0**-DECADES
    panel.set_facecolor(NO_VALUE)
    mesh = panel.pcolormesh(
        edges(cut.values),
        edges(order[1:]),
        np.maximum(found[:, 1:], floor).T,
        norm=LogNorm(floor, largest),
        cmap=SHADES,
        rasterized=True,
    )
    bar = panel.figure.colorbar(mesh, cax=panel.inset_axes(_BAR), extend="min")
    bar.set_label(f"amplitude [{raised(quantity.units)}]")
    panel.set_ylabel(
        rf"spectrum of {signal_symbol(quantity.name.partition(':')[2])}, $\Omega/\omega$"
    )
    if logarithmic(cut.values):
        panel.set_xscale("log")
