"""A page of response curves drawn: largest energies against frequency (Figures 2 to 7)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import CARETDOWN

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.response_curves.curve_picture import (
    BASE,
    BOUND,
    DOTTED,
    IMPACTS,
    MANIFOLD,
    NARROW,
    RESONANCE,
    WINDOW,
    legend_of,
    look_of,
    own_frequencies,
)
from nlds_vines.bifurcation.response_curves.curves_table import DOWN
from nlds_vines.bifurcation.response_curves.request import ENERGY, Curve, CurvePage, Panel
from nlds_vines.bifurcation.response_curves.result import CurveValues, curves_of
from nlds_vines.model.labels import FLAGS
from nlds_vines.model.linear_response import harmonic_energy
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.plotting.bands import bands, one_regime
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import setting_label, typeset
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled
from nlds_vines.plotting.panels import (
    add_panel,
    letter,
    text_width,
    write_letters,
    write_out_ticks,
    write_title,
)
from nlds_vines.plotting.style import CM, DOT, STYLE, axis_label, quantity_label

_HEIGHTS = {1: 7.2 * CM, 2: 4.9 * CM, 3: 5.4 * CM, 4: 4.2 * CM}  # inches, of a panel, by columns
_NARROW_PANEL = 4.6 * CM  # inches, of a panel in one column of a paper
_LEFT, _RIGHT, _GAP = 1.45 * CM, 0.35 * CM, 0.6 * CM  # inches: left, right, between two columns
_HEAD, _FOOT, _NAME, _LEGEND = 0.65 * CM, 1.05 * CM, 0.5 * CM, 0.42 * CM
"""Heights [inches] of the title, of the labels below, of a panel's title, of a legend's row."""

_REDUCTION, _SEAM = 3.6 * CM, 0.5 * CM
"""Height [inches] of the panel of the reduction, and of the gap above it, where a letter stands."""

_LEAST_REDUCTION = -100.0  # percent: where a damper harms more, it leaves the panel
_HANDLE = 36  # points that the line of a legend's entry and the space around it take
_VISIBLE = 0.008  # of the axis: a narrower window has one line in place of two bounds
_THIN = 0.5  # of the width of a curve: that of its sweep down
_ALIKE = 0.01  # of the largest value: the difference of two sweeps that count as one
_MOST_MARKS = 40  # of values below an axis, along a curve
_MODULATED = [FLAGS[word] for word in ("quasiperiodic", "chaotic")]
_OF_HARMONIC: Mapping[str, Callable[..., Any]] = {
    "E1max": harmonic_energy,
    "x1_max": lambda m1, k1, omega, x: x,
    "v1_max": lambda m1, k1, omega, x: omega * x,
}  # of a harmonic motion of m1 on k1 with the frequency omega and the amplitude x
_ABOVE = 1.1  # upper end of the axis of energies over the highest curve
_BEYOND = 1.5  # both ends of a logarithmic one


def curves_picture(view: ArchiveView, page: Page = TWO_COLUMNS) -> Figure:
    """Return the picture of an archive of response curves."""
    found = curves_of(view)
    return draw_page(found.request, found.curves, page)


@styled()
def draw_page(
    request: CurvePage,
    found: Sequence[CurveValues],
    page: Page = TWO_COLUMNS,
    shown: Sequence[str] = (),
) -> Figure:
    """Return the figure of a page of curves.

    Arguments: the `request`; what was `found` along each of its curves, in their order; the `page`;
    the panels that are `shown`, of `panels_of`, by default all.

    Each panel has the quantity that the page says, E2max (where asked for) dotted in the same
    color.  A line joins orbits of one regime alone, the others are dots.  A second sweep is a
    thinner line; where it differs from the first, and where a response is quasiperiodic or chaotic,
    the panel is shaded in the curve's color.  What lies below an axis is marked at its lower end.
    A vertical line marks the structure's own frequency omega0 = sqrt(k1 / m1).  The frequencies
    at which a shaded curve has impacts are light yellow, its windows without impacts white
    between dashed lines; one that is too narrow for them is a thin line.  Where the page says so,
    the reduction by each damper stands below.
    """
    known = list(panels_of(request))
    places = [known.index(name) for name in shown or known]
    layout = _Layout(request, page, places)
    figure, frames = layout.frames()
    for place, frame in zip(places, frames, strict=True):
        _fill_panel(frame, request, found, place)
    energies = [
        frame for place, frame in zip(places, frames, strict=True) if place < len(request.frames)
    ]
    if energies and not request.several:
        _limit_energies(energies[0], energies, request)
    if len(energies) < len(frames) or request.several:
        write_letters(frames)
    layout.label(frames)
    if len(request.panels) > 1:
        for place, frame in zip(places, frames, strict=True):
            _write_panel_title(frame, request.panels[place], place)
    return figure


def panels_of(request: CurvePage) -> dict[str, str]:
    """Return what the panels of a page show, by name: the only one, or a, b ...; the reduction."""
    words = {name: BY_NAME[name].title(request.body) for name in request.show}
    if len(request.panels) > 1:
        title = words[request.show[0]]
        found = {letter(i)[1:-1]: one.title or title for i, one in enumerate(request.panels)}
    elif request.show == (ENERGY,):
        found = {"energies": "largest energies"}
    else:
        found = words
    reduced = request.reduction and any(curve.scan.system.scene.damper for curve in request.curves)
    return {**found, **({"reduction": "reduction by each damper"} if reduced else {})}


def _fill_panel(frame: Axes, request: CurvePage, found: Sequence[CurveValues], place: int) -> None:
    """Draw the panel of a page at a `place`, the reduction being the last."""
    reduction = place == len(request.frames)
    chosen, name = (0, "reduction") if reduction else request.frames[place]
    content = [
        (curve, values)
        for (panel, curve), values in zip(request.places, found, strict=True)
        if panel == chosen
    ]
    if reduction:
        _draw_reduction(frame, content, request)
    else:
        _draw_panel(frame, content, request, name)


@dataclass(frozen=True)
class _Layout:
    """Where the panels of a page of curves stand, those at some `places` of the `request`."""

    request: CurvePage
    page: Page
    places: Sequence[int]

    @property
    def columns(self) -> int:
        """Panels side by side."""
        return min(self.request.columns if self.page.beside else 1, len(self.energies) or 1)

    @property
    def energies(self) -> list[int]:
        """The places of panels of energies."""
        return [place for place in self.places if place < len(self.request.frames)]

    @property
    def height(self) -> float:
        """Height in inches of a panel of energies."""
        return _HEIGHTS[self.columns] if self.page.beside else _NARROW_PANEL

    def frames(self) -> tuple[Figure, list[Axes]]:
        """Return a figure with the panels, which share both axes; title and legend stand above.

        The panel of the reduction, which is the last one, shares the frequency alone.
        """
        reduced, several = len(self.energies) < len(self.places), len(self.request.panels) > 1
        rows, below = ceil(len(self.energies) / self.columns), 0.0
        if reduced:
            below = _REDUCTION + (_SEAM if rows else 0.0)
        handles = legend_of(self.request)
        across = self.page.width - _LEFT - _RIGHT
        per_row = _per_row([str(handle.get_label()) for handle in handles], across)
        head = _HEAD + ceil(len(handles) / per_row) * _LEGEND + (_SEAM if reduced else 0.15 * CM)
        row_height = self.height + (_NAME if several or self.request.several else 0.0)
        figure = Figure(figsize=(self.page.width, head + rows * row_height + below + _FOOT))
        frames: list[Axes] = []
        width = (across - (self.columns - 1) * _GAP) / self.columns
        for index in range(len(self.energies)):
            row, column = divmod(index, self.columns)
            left = _LEFT + column * (width + _GAP)
            bottom = _FOOT + below + (rows - 1 - row) * row_height
            shared: dict[str, Any] = {"sharex": frames[0]} if frames else {}
            if frames and not self.request.several:
                shared["sharey"] = frames[0]
            frames.append(add_panel(figure, (left, bottom, width, self.height), **shared))
        if reduced:
            first = frames[0] if frames else None
            frames.append(add_panel(figure, (_LEFT, _FOOT, width, _REDUCTION), sharex=first))
        _add_legend(figure, handles, per_row)
        write_title(figure, self.request.title, _LEFT / self.page.width)
        return figure, frames

    def label(self, frames: Sequence[Axes]) -> None:
        """Label the outer axes; in narrow panels by the frequency's symbol alone."""
        across = axis_label(self.request.axis)
        if self.columns > 1:
            across = across.rpartition("force ")[2]
        for index, frame in enumerate(frames):
            if index + self.columns >= len(frames):
                frame.set_xlabel(across)
            else:
                frame.tick_params(labelbottom=False)
            if index % self.columns and not self.request.several:
                frame.tick_params(labelleft=False)
                frame.set_ylabel("")


def _add_legend(figure: Figure, handles: Sequence[Any], per_row: int) -> None:
    """Add the legend of all panels below the title, `per_row` entries side by side."""
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(_LEFT / figure.get_figwidth(), 1 - _HEAD / figure.get_figheight()),
        ncols=per_row,
        borderaxespad=0,
        borderpad=0,
        columnspacing=1.4,
        handlelength=2.2,
        labelspacing=0.35,
    )


def _per_row(labels: Sequence[str], across: float) -> int:
    """Return how many entries of a legend stand side by side in so many inches."""
    size = STYLE["legend.fontsize"]
    widths = np.array([_HANDLE + text_width(label, size) for label in labels])
    for rows in range(1, len(labels)):
        columns = ceil(len(labels) / rows)
        needed = sum(column.max() for column in np.array_split(widths, columns))
        if needed <= 72 * across:
            return columns
    return 1


def _draw_panel(
    frame: Axes, content: Sequence[tuple[Curve, CurveValues]], request: CurvePage, name: str
) -> None:
    """Draw one panel: shading, then resonances, then the curves, the base last."""
    for curve, found in content:
        if curve.shade:
            _shade(frame, found)
        _shade_windows(frame, curve, found, name)
    if request.axis == "omega":
        _mark_resonances(frame, [curve for curve, _ in content])
    for curve, found in content:
        look = look_of(curve)
        if name in found.numbers:
            _draw_curve(frame, found, found.numbers[name], look)
        if name + DOWN in found.numbers:
            thin = {**look, "linewidth": _THIN * look["linewidth"]}
            _draw_curve(frame, found, found.numbers[name + DOWN], thin, DOWN)
        if name == ENERGY and request.damper_energy and curve.scan.system.scene.damper:
            _draw_curve(frame, found, found.E2max, {**look, "linestyle": DOTTED})
    up = quantity_label(name, BY_NAME[name].unit, BY_NAME[name].words, request.body)
    if name == ENERGY and request.damper_energy:
        up = r"largest energies $E_1^{\,\mathrm{max}}, E_2^{\,\mathrm{max}}$ [J]"
    frame.set_ylabel(up)
    _limit_energies(frame, [frame], request)
    if request.log:
        below = [
            _mark_below(frame, curve, found.values[found.numbers[name] <= 0.0])
            for curve, found in content
            if name in found.numbers
        ]
        _say_below(frame, any(below), "zero")
    if request.manifold:
        for curve, _ in content:
            _draw_manifold(frame, curve, name)
    _limit(frame, request)


def _draw_curve(
    frame: Axes, found: CurveValues, up: np.ndarray, look: Mapping[str, Any], ending: str = ""
) -> None:
    """Draw a number (n,) along a curve: a line within a regime, dots where there is none.

    Arguments: what was `found` along the curve; the `look` of its line; the `ending` of the names
    of the start.  If the periods of the orbits are not recorded, all points are joined.
    """
    if not (periods := found.periods(ending)).size:
        frame.plot(found.values, up, **look)
        return
    curve, alone = one_regime(found.values, up, periods)
    frame.plot(*curve, **look)
    if alone.size:
        dots = {key: look[key] for key in ("color", "zorder")}
        frame.plot(*alone, markersize=2 * look["linewidth"], **DOT | dots)


def _limit_energies(frame: Axes, alike: Sequence[Axes], request: CurvePage) -> None:
    """Let the energies of a panel reach from zero, or from the least, to above the highest."""
    high = max(one.dataLim.y1 for one in alike)
    if not request.log:
        frame.set_ylim(0, _ABOVE * high)
        return
    frame.set_yscale("log")
    low = min(one.dataLim.minposy for one in alike)
    if np.isfinite(low) and high > 0:
        frame.set_ylim(low / _BEYOND, high * _BEYOND)
        write_out_ticks(frame.yaxis)


def _draw_manifold(frame: Axes, curve: Curve, name: str) -> None:
    """Draw the 1:1 response in closed form, a harmonic motion, over what follows of it."""
    manifold = curve.manifold
    if manifold is not None and name in _OF_HARMONIC:
        frequency, amplitude = manifold.response().outline
        m1, k1, _ = curve.scan.system.structure
        look = {"color": curve.color, "scalex": False, "scaley": False}
        found = _OF_HARMONIC[name](m1, k1, frequency, amplitude)
        frame.plot(frequency, found, **MANIFOLD | look)


def _mark_below(frame: Axes, curve: Curve, below: np.ndarray) -> bool:
    """Mark the values at which a curve lies below a panel, and tell whether it does anywhere."""
    few = below[:: max(1, below.size // _MOST_MARKS)]
    look: dict[str, Any] = {"color": curve.color, "markersize": 3.0, "clip_on": False, "zorder": 5}
    look |= {"linestyle": "none", "marker": CARETDOWN, "transform": frame.get_xaxis_transform()}
    if few.size:
        frame.plot(few, np.zeros(few.size), **look)
    return bool(few.size)


def _say_below(frame: Axes, anything: bool, words: str) -> None:
    """Say what the marks at the lower end of a panel are, if there are any."""
    if anything:
        look: dict[str, Any] = {"fontsize": 7, "va": "bottom", "zorder": 5}
        frame.text(
            0.01,
            0.05,
            f"\N{BLACK DOWN-POINTING TRIANGLE} {words}",
            transform=frame.transAxes,
            **look,
        )


def _shade_windows(frame: Axes, curve: Curve, found: CurveValues, name: str) -> None:
    """Shade, in the color of a curve, where its two sweeps differ and where none is periodic.

    Sweeps differ if their numbers do, or if their orbits nT,k do.
    """
    windows = np.zeros(found.values.size, dtype=bool)
    if "regime" in found.numbers:
        windows |= np.isin(found.numbers["regime"], _MODULATED)
    if name + DOWN in found.numbers:
        up, down = found.numbers[name], found.numbers[name + DOWN]
        reach = _ALIKE * float(np.nanmax(np.fmax(up, down), initial=0.0))
        windows |= np.abs(up - down) > reach
        if (of_up := found.periods()).size:
            windows |= of_up != found.periods(DOWN)
    for band in bands(found.values, np.where(windows, "shaded", "")):
        if band.label:
            frame.axvspan(band.low, band.high, color=curve.color, **WINDOW)


def _draw_reduction(
    frame: Axes, content: Sequence[tuple[Curve, CurveValues]], request: CurvePage
) -> None:
    """Draw the reduction by each damper in percent, from -100 % on; zero is marked."""
    frame.axhline(0, color=RESONANCE, linewidth=0.7, zorder=2)
    for curve, found in content:
        if curve.scan.system.scene.damper:
            _draw_curve(frame, found, 100 * found.reduction, look_of(curve))
    low, high = frame.get_ylim()
    frame.set_ylim(max(low, _LEAST_REDUCTION), min(high, 105))
    below = [
        _mark_below(frame, curve, found.values[100 * found.reduction < _LEAST_REDUCTION])
        for curve, found in content
        if curve.scan.system.scene.damper
    ]
    words = f"below {_LEAST_REDUCTION:g} %".replace("-", "\N{MINUS SIGN}")
    _say_below(frame, any(below), words)
    frame.set_ylabel("reduction [%]")
    _limit(frame, request)


def _limit(frame: Axes, request: CurvePage) -> None:
    """Let a panel reach from the first to the last value, and have ticks on all sides."""
    if request.values.size > 1:
        frame.set_xlim(*request.values[[0, -1]])
    frame.tick_params(top=True, right=True)


def _shade(frame: Axes, curve: CurveValues) -> None:
    """Fill where there are impacts; mark every window without any, by its bounds or one line."""
    values, impacts = curve.values, curve.impacts
    found = bands(values, np.where(impacts > 0, "impacts", "none"))
    for band in found:
        if band.label == "impacts":
            frame.axvspan(band.low, band.high, color=IMPACTS, linewidth=0, zorder=0)
        elif band.width >= _VISIBLE * (values[-1] - values[0]):
            for bound in (band.low, band.high):
                frame.axvline(bound, **BOUND)
        else:
            frame.axvline(band.center, **NARROW)


def _mark_resonances(frame: Axes, curves: Sequence[Curve]) -> None:
    """Mark omega0 = sqrt(k1 / m1): by a line, or by a short one for each of several values."""
    places = own_frequencies(curves)
    if len(places) == 1:
        frame.axvline(next(iter(places)), color=RESONANCE, linewidth=0.7, zorder=2)
        return
    for place, color in places.items():
        frame.axvline(place, ymin=0.94, color=color, linewidth=1.2, zorder=2)


def _write_panel_title(frame: Axes, panel: Panel, index: int) -> None:
    """Write a panel's letter and title above it; the title of the tuning has a color."""
    settings = [setting_label(name, value) for name, value in panel.settings.items()]
    title = typeset(panel.title) or ", ".join(settings)
    text = f"{letter(index)}  {title}" + (" (tuning)" if panel.base else "")
    frame.set_title(text, fontsize=8.5, loc="left", pad=3, color=BASE if panel.base else "black")


def _read(view: ArchiveView) -> tuple[CurvePage, Sequence[CurveValues]]:
    found = curves_of(view)
    return found.request, found.curves


def _fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel of an archive of response curves into axes, with the legend."""
    request, found = _read(view)
    _fill_panel(axes, request, found, list(panels_of(request)).index(name))
    axes.set_xlabel(axis_label(request.axis))
    axes.legend(handles=legend_of(request))


PICTURE = Picture(
    panels=lambda view: panels_of(_read(view)[0]),
    draw=lambda view, names, page: draw_page(*_read(view), page, names),
    fill=_fill,
)
"""What draws an archive of response curves."""
