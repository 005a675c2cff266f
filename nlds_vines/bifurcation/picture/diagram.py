"""Diagrams: what one parameter does to the orbits (Figure 8), for one value of another or a few."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import cycle, islice
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import PercentFormatter
from matplotlib.transforms import offset_copy

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.picture import choices
from nlds_vines.bifurcation.picture.choices import SECTION, DrawnQuantity, Slice
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import CHAOS, final
from nlds_vines.model.parameters import SIDES
from nlds_vines.model.quantities import BELOW, BY_NAME, CURVES, ERROR, TOUCHED, drawn_in, scale_of
from nlds_vines.plotting import palette
from nlds_vines.plotting.bands import Band, bands, edges, logarithmic, one_regime, spread
from nlds_vines.plotting.chosen_panels import several_panels
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    figure_of,
    finish,
    new_figure,
    size_of,
    styled,
    text_width,
    write_letters,
)
from nlds_vines.plotting.style import (
    CM,
    DOT,
    GRAY,
    GREEN,
    HUES,
    NAVY,
    NO_VALUE,
    ROUND_OFF,
    SHADES,
    axis_label,
    raised,
    signal_symbol,
    start_colors,
)

_SMALL = 0.65  # of the height of a panel: one of small multiples
_ENERGY = "E1max"


@styled()
def diagram(view: ArchiveView, show: str | None = None, page: Page = TWO_COLUMNS) -> Figure:
    """Return the diagram of a scan along one parameter, at each of a few values of another.

    `show` are quantities separated by commas, `regimes` for the strips alone, None for
    `_usual_rows`, with the structure's maximum energy of a single start in green over the first
    panel.  Of a few values of another parameter each has a panel of dots; numbers are curves in one
    panel.  Above the panels strips name the regimes.  Hatched are orbits that pass the limit of
    their scene.  Raises `RequestError` where nothing is recorded to draw.
    """
    cuts, drawn = slices_of(view), choices.quantities_in(view)
    shown = _usual_rows(view, cuts, drawn) if show is None else choices.rows_of(show, drawn)
    is_one, tiers = len(cuts) == 1, list[Tier]()
    for cut in cuts:
        of_cut = [name for name in shown if is_one or not drawn[name].single]
        # a strip for each of up to two starts, or a stack; without labels, the value that is held
        is_labeled, is_stack = cut.labels() is not None, len(cut.starts) > MOST_STRIPS
        if is_labeled or (of_cut and cut.constant_setting):
            height = NO_STRIP if not is_labeled else STACK if is_stack else STRIP
            for start in range(len(cut.starts) if is_labeled and not is_stack else 1):
                tiers.append(Tier(height, partial(draw_strip_of, cut=cut, start=start)))
        for name in of_cut:
            draw = partial(fill_panel, cuts=[cut], recorded=drawn, name=name)
            tiers.append(Tier((1.0 if is_one else _SMALL) * page.panel, draw, name))
    for name in () if is_one else shown:  # numbers of all slices share a panel
        if drawn[name].single:
            draw = partial(fill_panel, cuts=cuts, recorded=drawn, name=name)
            tiers.append(Tier(page.panel, draw, name))
    if not tiers:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    figure, grid = new_figure(page, [tier.height for tier in tiers])
    axes: dict[int, Axes] = {}
    for place in sorted(range(len(tiers)), key=lambda place: not tiers[place].quantity):
        axes[place] = figure.add_subplot(grid[place], sharex=next(iter(axes.values()), None))
    rows, limits = [axes[place] for place in range(len(tiers))], edges(cuts[0].values)[[0, -1]]
    panels, left_out = dict[str, list[Axes]](), list[str]()
    for tier, row in zip(tiers, rows, strict=True):
        row.set_xlim(*limits)
        left_out += tier.draw(row) or []
        row.set_xlim(*limits)
        row.tick_params(top=bool(tier.quantity), labelbottom=row is rows[-1])
        if tier.quantity:
            panels.setdefault(tier.quantity, []).append(row)
    rows[-1].tick_params(bottom=True)
    rows[-1].set_xlabel(axis_label(cuts[0].axis))
    for same in panels.values():  # panels that show one quantity have the same limits
        ends = [end for row in same for end in row.get_ylim()]
        for row in same if len(same) > 1 else ():
            row.set_ylim(min(ends), max(ends))
    quantity_panels = [row for tier, row in zip(tiers, rows, strict=True) if tier.quantity]
    write_letters(quantity_panels)
    figure.align_ylabels([row for row in quantity_panels or rows if row.get_ylabel()])
    is_single = is_one and len(cuts[0].starts) == 1
    if show is None and _ENERGY in drawn and is_single and shown and not drawn[shown[0]].single:
        panel = quantity_panels[0].twinx()
        _draw_curve(panel, cuts[0], cuts[0].of(drawn[_ENERGY])[:, 0, 0], GREEN, 0.9)
        panel.set_ylim(bottom=0)
        panel.set_ylabel(drawn[_ENERGY].label, color=GREEN)
        panel.tick_params(axis="y", colors=GREEN)
        panel.spines["right"].set_color(GREEN)
    handles = [*legend_of_panel(cuts, shown), *legend_of_strips(cuts, left_out)]
    if handles:
        add_legend(rows[-1], handles, "below")
    finish(figure, grid, view.text("title"))
    return figure


def slices_of(view: ArchiveView) -> list[Slice]:
    """Return the slices of a scan along its longest axis, one for each value of the other axis."""
    axes = sorted(view.axes, key=lambda name: -view[name].size)
    if len(axes) == 1:
        return [Slice(view, axes[0])]
    return [Slice(view, axes[0], {axes[1]: place}) for place in range(view[axes[1]].size)]


def draw_into(axes: Axes, view: ArchiveView, show: str | None = None) -> None:
    """Draw one quantity of a diagram into axes, or the strip for `regimes`."""
    cuts, recorded = slices_of(view), choices.quantities_in(view)
    rows = (
        _usual_rows(view, cuts, recorded)[:1] if show is None else choices.rows_of(show, recorded)
    )
    if len(rows) > 1:
        raise several_panels(str(show), recorded)
    if len(cuts) > 1 and (not rows or not recorded[rows[0]].single):
        raise RequestError(f"show = {show!r} needs several panels: give no axes, or one number")
    axes.set_xlim(*edges(cuts[0].values)[[0, -1]])
    if rows:
        fill_panel(axes, cuts, recorded, rows[0])
        handles = legend_of_panel(cuts, rows)
        if handles:
            axes.legend(handles=handles)
    else:
        draw_strip_of(axes, cuts[0])
        axes.tick_params(bottom=True, labelbottom=True)
    axes.set_xlabel(axis_label(cuts[0].axis))


def _usual_rows(
    view: ArchiveView, cuts: Sequence[Slice], recorded: Mapping[str, DrawnQuantity]
) -> list[str]:
    below = choices.drawn_by(BELOW, recorded)
    places = choices.usual_places(view, recorded)
    places += choices.drawn_by(TOUCHED, recorded)
    if not places:
        numbers = choices.drawn_by(CURVES, recorded)
        if "impacts" not in view.request(SCAN, load_scan).want:  # the strips tell the impacts
            numbers = [name for name in numbers if name != "impact_rate"]
        if len(cuts) > 1 and len(numbers) > 1:  # the strips tell the periods
            numbers = [name for name in numbers if name != "periodicity"]
        return numbers + below
    if len(cuts) > 1:
        places = places[:1]
    alone = len(cuts) == 1 and view["start"].size == 1
    return places + [name for name in (_ENERGY,) if name in recorded and not alone] + below


# ---- panels: a quantity over one parameter in dots or curves, a spectrum in colors ---------------


_WIDTHS = {name: entry.width for name, entry in BY_NAME.items() if entry.width}

PASSES = "passes the limit"  # what a legend says of hatched cells and crossed marks
REDUCTION = "reduction"  # the share of E1max that a damper takes away: in percent on axes
_SECTION_DOTS, _NUMBER_DOTS = (0.75, 1.5), (1.3, 2.0)  # points, of many columns and of few
_EXPONENT_DOT, _LEGEND_DOT = 1.4, 3.0  # points
_COVERED, _FAINTEST = 3.0, 0.04  # times that opaque dots may cover a panel; opacity of others
_HATCH: dict[str, Any] = {"facecolor": "none", "edgecolor": "#d0a0a0", "linewidth": 0}
_CROSSES = 40  # along a curve, at most: more of them hide it
_CROSS: dict[str, Any] = {"marker": "x", "linestyle": "none", "markeredgewidth": 0.7}
_UP: dict[str, Any] = {"markersize": 1.6, **DOT}
_DOWN: dict[str, Any] = {
    "marker": "o", "markersize": 3.0, "linestyle": "none", "markerfacecolor": "none",
    "markeredgewidth": 0.5,
}  # fmt: skip
_WALL = "impact_wall"
# of impacts at the near and at the far wall; hosts have more walls
_WALL_COLORS = (NAVY, *(HUES[hue] for hue in ("vermillion", "sky", "orange", "pink", "gray")))
_LIGHTEST = 0.82  # of the shades of curves: lighter ones are too pale on white paper
WATERFALL = "spectrum"  # the dataset that is drawn in colors over the frequency
DECADES = 6.0  # below the largest amplitude that colors tell apart
_BAR = (1.012, 0.0, 0.014, 1.0)  # of the panel: the bar's left edge, foot, width, height


def fill_panel(
    panel: Axes, cuts: Sequence[Slice], recorded: Mapping[str, DrawnQuantity], name: str
) -> None:
    quantity, cut = recorded[name], cuts[0]
    if logarithmic(cut.values):
        panel.set_xscale("log")
    if quantity.dataset == WATERFALL:
        order, heights = cut.view["frequency"][1:], cut.of(quantity)[:, 0, 1:]
        largest = float(np.nanmax(heights, initial=0.0)) or 1.0
        floor = largest * 10.0**-DECADES
        panel.set_facecolor(NO_VALUE)
        look: dict[str, Any] = {"norm": LogNorm(floor, largest), "cmap": SHADES}
        across, up = edges(cut.values), edges(order)
        mesh = panel.pcolormesh(across, up, np.maximum(heights, floor).T, rasterized=True, **look)
        bar = panel.figure.colorbar(mesh, cax=panel.inset_axes(_BAR), extend="min")
        bar.set_label(f"amplitude [{raised(quantity.units)}]")
        signal = signal_symbol(quantity.name.partition(":")[2])
        panel.set_ylabel(rf"spectrum of {signal}, $\Omega/\omega$")
        return
    if name in _WIDTHS:
        panel.axhline(0.0, color=GRAY, linewidth=0.6, zorder=0.5)
    if len(cuts) > 1:
        _draw_curves(panel, cuts, quantity)
    elif name in _WIDTHS:  # Lyapunov exponents with their 99 % intervals
        lyapunov, half = cut.of(quantity), recorded.get(_WIDTHS[name])
        width = np.zeros_like(lyapunov) if half is None else cut.of(half)
        for hues in looks_of(cut, lyapunov):
            (across, up), (_, reach) = _dots_of(cut, hues, lyapunov), _dots_of(cut, hues, width)
            finite = np.isfinite(up) & np.isfinite(reach)
            across, up, reach = across[finite], up[finite], reach[finite]
            look = {"color": hues.color, "rasterized": True}
            panel.vlines(across, up - reach, up + reach, alpha=0.35, linewidth=1.0, **look)
            panel.plot(across, up, markersize=_EXPONENT_DOT, **look, **DOT)
    else:
        _draw_dots(panel, cut, quantity)
    if len(cuts) == 1 and (passed := cut.violated().any(axis=1)).any():
        for band in bands(cut.values, np.where(passed, PASSES, "")):
            if band.label:
                panel.axvspan(band.low, band.high, hatch=palette.PASSED, zorder=0.2, **_HATCH)
    panel.set_ylabel(quantity.label)
    if name == REDUCTION:
        panel.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    if quantity.units == "rad" and quantity.dataset in drawn_in(TOUCHED):
        panel.set_ylim(0.0, 2.0 * np.pi)


def legend_of_panel(cuts: Sequence[Slice], rows: Sequence[str]) -> list[Any]:
    handles: list[Any] = []
    if len(cuts) > 1 and rows:
        handles = [
            Line2D([], [], color=color, label=cut.constant_setting, linewidth=1.2)
            for cut, color in zip(cuts, curve_colors(len(cuts)), strict=True)
        ]
        if cuts[0].starts == SWEEPS:
            handles += [
                Line2D([], [], color=GRAY, label=name, **look)
                for name, look in zip(SWEEPS, (_UP, _DOWN), strict=True)
            ]
    elif rows:
        dot: dict[str, Any] = {"marker": "o", "markersize": _LEGEND_DOT, "linestyle": "none"}
        looks = [look for look in looks_of(cuts[0]) if look.name and look.which.any()]
        handles = [Line2D([], [], color=look.color, label=look.name, **dot) for look in looks]
        if any(_tells_walls(cuts[0], name) for name in rows):
            names = [name.replace("_", " ") for name in cuts[0].view.flags(_WALL).values()]
            for name, hue in zip(names, _wall_colors(cuts[0]), strict=True):
                is_side = name[-1] in SIDES  # of a damper, as "cell+"
                label = f"wall {name}" if is_side else f"at the {name}"
                handles.append(Line2D([], [], color=hue, label=label, **dot))
    if any(cut.violated().any() for cut in cuts):
        text = PASSES if len(cuts) == 1 else f"{PASSES} (crosses)"
        handles.append(Patch(hatch=palette.PASSED, label=text, **_HATCH))
    return handles


def curve_colors(count: int) -> list[Any]:
    return list(matplotlib.colormaps[SHADES](np.linspace(0.0, _LIGHTEST, count)))


def _draw_curve(axes: Axes, cut: Slice, ordinates: np.ndarray, color: Any, width: float) -> None:
    """Draw a number (cells,) of the first start: a curve within a periodic regime, else dots."""
    labels = cut.labels()
    if labels is None:
        axes.plot(cut.values, ordinates, color=color, linewidth=width)
        return
    ends = np.array([final(str(label)) for label in labels[:, 0]])
    periodic = np.array([palette.period_and_impacts(end) is not None for end in ends])
    curve, alone = one_regime(cut.values, ordinates, np.where(periodic, ends, ""))
    axes.plot(*curve, color=color, linewidth=width)
    axes.plot(*alone, color=color, markersize=1.3 * width, **DOT)


def _dots_of(cut: Slice, look: Look, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return abscissae and ordinates of a look's orbits; `values` (cells, starts, many)."""
    cells, _ = np.nonzero(look.which)
    shown = values[look.which]
    return np.repeat(cut.values[cells], shown.shape[1]), shown.ravel()


def _draw_dots(panel: Axes, cut: Slice, quantity: DrawnQuantity) -> None:
    """Draw orbits as dots, with a color for each attractor; where they cover much, translucent."""
    ordinates = cut.of(quantity)
    if scale_of(quantity.dataset) == ERROR:
        ordinates = np.maximum(ordinates, ROUND_OFF)
        panel.set_yscale("log")
    wide, tall = size_of(panel)
    least, widest = _NUMBER_DOTS if quantity.single else _SECTION_DOTS
    size = min(max(wide / cut.values.size, least), widest)
    covered = np.count_nonzero(np.isfinite(ordinates)) * size**2 / (wide * tall)
    style: dict[str, Any] = {"markersize": size, "rasterized": True, **DOT}
    if not quantity.single and covered > _COVERED:
        style["alpha"] = max(_COVERED / covered, _FAINTEST)
    if _tells_walls(cut, quantity.dataset):
        walls = cut.view.take(_WALL, **cut.at)
        for code, color in enumerate(_wall_colors(cut)):
            cells, starts, many = np.nonzero(walls == code)
            panel.plot(cut.values[cells], ordinates[cells, starts, many], color=color, **style)
        return
    for look in looks_of(cut, ordinates if quantity.single else None):
        across, up = _dots_of(cut, look, ordinates)
        panel.plot(across, up, color=look.color, **style)


def _tells_walls(cut: Slice, name: str) -> bool:
    """Return True if the dots are impacts of one start, which are colored by the wall."""
    return len(cut.starts) == 1 and _WALL in cut.view and name in drawn_in(TOUCHED)


def _wall_colors(cut: Slice) -> list[str]:
    return [*islice(cycle(_WALL_COLORS), len(cut.view.flags(_WALL)))]


def _draw_curves(panel: Axes, cuts: Sequence[Slice], quantity: DrawnQuantity) -> None:
    if scale_of(quantity.dataset) == ERROR:
        panel.set_yscale("log")
    for cut, color in zip(cuts, curve_colors(len(cuts)), strict=True):
        ordinates = cut.of(quantity)
        many = ordinates.shape[1] * ordinates.shape[2]
        if many == 1:
            _draw_curve(panel, cut, ordinates[:, 0, 0], color, 1.0)
        elif cut.starts == SWEEPS:
            for start, look in enumerate((_UP, _DOWN)):
                points = ordinates[:, start].ravel()
                across = np.repeat(cut.values, ordinates.shape[2])
                panel.plot(across, points, color=color, **look)
        else:
            across = np.repeat(cut.values, many)
            panel.plot(across, ordinates.ravel(), color=color, markersize=1.4, **DOT)
        # of runs of cells that pass a limit the ends are marked, and a few in between
        flagged, few = cut.violated(), max(1, cut.values.size // _CROSSES)
        inner = np.pad(flagged, ((1, 1), (0, 0)))
        inner = inner[:-2] & inner[2:] & (np.arange(len(flagged)) % few > 0)[:, np.newaxis]
        cells, starts = np.nonzero(flagged & ~inner)
        if cells.size:
            up = ordinates[cells, starts, 0]
            panel.plot(cut.values[cells], up, color=color, markersize=2.5, **_CROSS)


# ---- orbits of several starts are told apart by attractor ----------------------------------------


SWEEPS = ["up", "down"]  # the starts of a scan that shows hysteresis
BOTH = "up and down alike"  # the name in a legend of orbits on which both sweeps are
EQUAL = "up and down: equal values"  # without labels and sections: the orbits may differ
_ALIKE = 0.01  # of the range of all values: the distance of two orbits that count as one


class Look(NamedTuple):
    which: np.ndarray  # (cells, starts), True for the orbits that look alike
    color: str
    name: str


def looks_of(cut: Slice, numbers: np.ndarray | None = None) -> list[Look]:
    """Group the orbits of a slice by the look of their dots: one look for each attractor."""
    starts, shape = cut.starts, (cut.values.size, len(cut.starts))
    if len(starts) == 1:
        name = "" if starts == ["rest"] else f"start: {starts[0]}"
        return [Look(np.ones(shape, dtype=bool), start_colors(starts)[0], name)]
    if starts == SWEEPS:
        is_of_orbit = any(name in cut.view for name in ("label", SECTION, "periodicity"))
        (up, down), both = start_colors(SWEEPS), alike(cut, numbers)
        first = np.array([[True, False]])  # both have the dots of the sweep up
        groups = [
            Look(both[:, np.newaxis] & first, NAVY, BOTH if is_of_orbit else EQUAL),
            Look(~both[:, np.newaxis] & first, up, "up"),
            Look(~both[:, np.newaxis] & ~first, down, "down"),
        ]
        return [look for look in groups if look.which.any()]
    labels = cut.labels()
    if labels is None:
        return [Look(np.ones(shape, dtype=bool), NAVY, f"{len(starts)} starts")]
    words = palette.ordered(labels.ravel().tolist())
    names = [choices.in_legend(palette.short(word), cut.view) for word in words]
    looks = zip(words, names, strict=True)
    return [Look(labels == word, palette.ink_of(word), name) for word, name in looks]


def alike(cut: Slice, numbers: np.ndarray | None = None) -> np.ndarray:
    """Return True for the cells (cells,) in which two starts are on the same orbit.

    They are if nT,k and the label agree, as far as these are recorded, and if each point of either
    section lies close to one of the other; without sections E1max is compared, or else `numbers`
    (cells, starts, 1).  Equal numbers alone do not suffice: just beyond grazing T,0 and T,2 have
    nearly the same energy.  Two orbits that are not periodic and have one label count as alike.
    """
    drawn = choices.quantities_in(cut.view)
    of_section = [item for item in drawn.values() if item.dataset == SECTION]
    places = of_section or [item for item in drawn.values() if item.name == "E1max"]
    compared = [cut.of(item) for item in places]
    if not places and numbers is not None:
        compared = [numbers]
    is_alike = np.ones(cut.values.size, dtype=bool)
    for values in compared:
        finite = values[np.isfinite(values)]
        reach = _ALIKE * np.ptp(finite) if finite.size else np.inf
        for i, (one, other) in enumerate(values):
            one, other = one[np.isfinite(one)], other[np.isfinite(other)]
            if one.size and other.size:
                gaps = np.abs(one[:, np.newaxis] - other)
                is_alike[i] &= max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) <= reach
            else:
                is_alike[i] &= one.size == other.size
    if "periodicity" in cut.view and "impact_count" in cut.view:
        n, k = (cut.view.take(name, **cut.at) for name in ("periodicity", "impact_count"))
        is_alike &= (n[:, 0] == n[:, 1]) & ((k[:, 0] == k[:, 1]) | (n[:, 0] == 0))
    labels = cut.labels()
    if labels is None:
        return is_alike
    same = labels[:, 0] == labels[:, 1]
    wild = np.array([palette.period_and_impacts(label) is None for label in labels[:, 0]])
    return same & (is_alike | wild)


# ---- the strips that name the regimes above the panels -------------------------------------------


MOST_STRIPS = 2  # the most starts with a strip of their own; more are stacked in one

STRIP, STACK, NO_STRIP = 0.42 * CM, 0.75 * CM, 0.02 * CM
"""Heights [inches] of a strip, of the stack of several starts, and of axes without a strip."""

_SIZE = 7  # pt, of the names
_PITCH = 1.25 * _SIZE  # pt from one upright name to the next
_PADDING = 3  # pt on either side of a name inside its band
_NARROWEST = 0.5  # pt, least width of a band that is named: a narrower one is invisible
_LINES = 14  # pt between the strip and the names above it
_FARTHEST = 45  # pt between a name and the band that it names
_SETTING_WIDTH = 0.4  # of a strip: the room for the value at which another parameter is held
_MOST_LEFT_OUT = 11  # entries of a legend for regimes that no strip names


@dataclass(frozen=True)
class Tier:
    height: float  # inches
    draw: Callable[[Axes], list[str] | None]  # a strip returns the labels that it does not name
    quantity: str = ""  # of a panel, which share the scale of one; empty for a strip


def draw_strip_of(axes: Axes, cut: Slice, start: int = 0) -> list[str]:
    """Draw the strip of a start, or a stack of all starts, as `draw_strip` does."""
    labels, rows, starts = cut.labels(), list[list[Band]](), cut.starts
    if labels is not None:
        labels = np.where(cut.violated(), labels + palette.INADMISSIBLE, labels)
        if len(starts) <= MOST_STRIPS:
            labels = labels[:, start : start + 1]
        else:
            words = palette.ordered(labels.ravel().tolist())
            rank = {word: place for place, word in enumerate(words)}
            # sorted within each cell, in the order of legends
            ranks = np.sort(np.vectorize(rank.__getitem__, otypes=[int])(labels), axis=1)
            labels = np.array(words, dtype=object)[ranks]
        rows = [bands(cut.values, column) for column in labels.T]
        if logarithmic(cut.values):
            axes.set_xscale("log")
        if 1 < len(starts) <= MOST_STRIPS:
            axes.set_ylabel(starts[start], rotation=0, ha="right", va="center")
    return draw_strip(axes, rows, cut.constant_setting if start == 0 else "")


def legend_of_strips(cuts: Sequence[Slice], left_out: Sequence[str]) -> list[Any]:
    """Return entries of a legend: how long chaos was watched; regimes that no strip names."""
    handles: list[Any] = []
    labeled = [cut for cut in cuts if cut.labels() is not None]
    is_one_stack = len(cuts) == 1 and len(cuts[0].starts) > MOST_STRIPS  # dots are in the legend
    if not is_one_stack and any(np.any(cut.labels() == CHAOS) for cut in labeled):
        text = choices.in_legend(CHAOS, labeled[0].view)
        handles.append(Patch(facecolor=palette.OTHERS[CHAOS], label=text))
    words = palette.in_order({palette.drawn_as(word) for word in left_out})
    for word in words[:_MOST_LEFT_OUT]:
        look = palette.patch_look(palette.example_of(word))
        handles.append(Patch(label=palette.short(word), **look))
    if len(words) > _MOST_LEFT_OUT:
        handles.append(Patch(color="none", label=f"and {len(words) - _MOST_LEFT_OUT} more"))
    return handles


def draw_strip(axes: Axes, rows: Sequence[Sequence[Band]], setting: str = "") -> list[str]:
    """Draw rows of bands, from below, in the colors of their regimes, and name the regimes.

    Names stand inside the bands of a single row, or once upright above the widest of their bands.
    If these would be far from their bands, the narrowest are left out, and their labels returned.
    The value `setting` at which another parameter is held stands over all, also without rows.
    """
    for row_number, row in enumerate(rows):
        for band in row:
            look = palette.patch_look(band.label)
            corner = band.low, row_number / len(rows)
            axes.add_patch(Rectangle(corner, band.width, 1 / len(rows), **look))
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(which="both", bottom=False, labelbottom=False)
    if not rows:
        axes.set_axis_off()
    ends, points, is_log = axes.get_xlim(), size_of(axes)[0], axes.get_xscale() == "log"

    def place(value: float) -> float:
        """Return the position of a value, as a fraction of the axis."""
        low, high, at = np.log((*ends, value)) if is_log else (*ends, value)
        return float((at - low) / (high - low))

    def extent(band: Band) -> float:
        return points * (place(band.high) - place(band.low))

    def middle(band: Band) -> float:
        return (place(band.low) + place(band.high)) / 2

    every = [band for row in rows for band in row]
    single = every if len(rows) == 1 else []
    names = {band.label: palette.short(band.label) for band in single}
    rooms = {label: text_width(name, _SIZE) + 2 * _PADDING for label, name in names.items()}
    inside = [band for band in single if rooms[band.label] <= extent(band)]
    for band in inside:
        color = palette.color_of(band.label)
        look = {"ha": "center", "va": "center_baseline", "fontsize": _SIZE}
        if palette.hatch_of(band.label):  # a plain background for the name
            look["bbox"] = {"facecolor": color, "edgecolor": "none", "pad": 1.0}
        look |= {"color": "white" if palette.is_dark(color) else "black"}
        axes.text(middle(band), 0.5, names[band.label], transform=axes.transAxes, **look)
    named = {band.label for band in inside}
    beside = [b for b in every if b.label not in named and extent(b) >= _NARROWEST]
    widest = {band.label: band for band in sorted(beside, key=extent)}
    above = sorted(widest.values(), key=lambda band: band.center)
    left_out, pitch = list[str](), _PITCH / points
    while above:
        if len(above) * _PITCH <= points:
            middles = np.array([middle(band) for band in above])
            places = spread(middles.tolist(), pitch, pitch / 2, 1.0 - pitch / 2)
            if float(np.abs(places - middles).max()) * points <= _FARTHEST:
                break
        narrowest = min(above, key=extent)
        above.remove(narrowest)
        left_out.append(narrowest.label)
    high = offset_copy(axes.transAxes, figure_of(axes), 0.0, _LINES, units="points")
    look = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
    look |= {"xycoords": "axes fraction", "textcoords": high, "annotation_clip": False}
    arms = "arc,angleA=-90,angleB=90,armA=3,armB=3,rad=0"  # points
    look["arrowprops"] = {"arrowstyle": "-", "connectionstyle": arms, "shrinkA": 0, "shrinkB": 0}
    look["arrowprops"] |= {"color": "#555555", "linewidth": 0.4, "relpos": (0.5, 0.0)}
    for band, at in zip(above, places if above else (), strict=True):
        axes.annotate(palette.short(band.label), (middle(band), 1.0), (at, 1.0), **look)
    if setting:
        lift = 0.0
        if any(place(band.low) <= _SETTING_WIDTH for band in above):
            lift = _LINES + max(text_width(palette.short(band.label), _SIZE) for band in above)
        look = {"xycoords": "axes fraction", "textcoords": "offset points"}
        axes.annotate(setting, (0, 1), (0, 3 + lift), ha="left", va="bottom", **look)
    return left_out
