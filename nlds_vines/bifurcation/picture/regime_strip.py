"""The strips above a diagram that name the regimes along the axis; their legend."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle
from matplotlib.transforms import offset_copy

from nlds_vines.bifurcation.picture.choices import Slice, in_legend
from nlds_vines.model.labels import CHAOS
from nlds_vines.plotting.bands import Band, bands, edges, logarithmic, spread
from nlds_vines.plotting.page import Page, figure_of, size_of, text_width
from nlds_vines.plotting.palette import (
    OTHERS,
    color_of,
    colors,
    drawn_as,
    example_of,
    hatch_of,
    in_order,
    is_dark,
    ordered,
    patch_look,
    short,
)
from nlds_vines.plotting.style import CM

MOST_STRIPS = 2
"""The most starts with a strip of their own; more are stacked in one."""

STRIP, STACK, NO_STRIP = 0.42 * CM, 0.75 * CM, 0.02 * CM
"""Heights [inches] of a strip, of the stack of several starts, and of axes without a strip."""

_SIZE = 7  # pt, of the names
_PITCH = 1.25 * _SIZE  # pt from one upright name to the next
_PADDING = 3  # pt on either side of a name inside its band
_NARROWEST = 0.5  # pt, least width of a band that is named: a narrower one is invisible
_LINES = 14  # pt between the strip and the names above it
_FARTHEST = 45  # pt between a name and the band that it names
_HELD_WIDTH = 0.4  # of a strip: the room for the value at which another parameter is held
_MOST_LEFT_OUT = 11  # entries of a legend for regimes that no strip names


@dataclass(frozen=True)
class Tier:
    """A row of a diagram."""

    height: float  # inches
    draw: Callable[[Axes], None]
    quantity: str = ""  # of a panel, which share the scale of one; empty for a strip


def strips_of(cut: Slice) -> list[Tier]:
    """Return the strips of a slice: one for each of up to two starts, or a stack.

    Above the first one is the value of the parameter that is constant, if there is one.
    """
    if cut.labels() is None:
        return [Tier(NO_STRIP, partial(draw_strip_of, cut=cut))] if cut.held else []
    if _is_stacked(cut):
        return [Tier(STACK, partial(draw_strip_of, cut=cut))]
    starts = range(len(cut.starts))
    return [Tier(STRIP, partial(draw_strip_of, cut=cut, start=start)) for start in starts]


def draw_strip_of(axes: Axes, cut: Slice, start: int = 0) -> None:
    labels, lift = cut.marked_labels(), 0.0
    if labels is None:
        axes.set_axis_off()
    else:
        if logarithmic(cut.values):
            axes.set_xscale("log")
        if _is_stacked(cut):
            strip = draw_stack(axes, cut.values, labels)
        else:
            along = bands(cut.values, labels[:, start])
            strip = draw_strip(axes, along, colors(labels.ravel().tolist()))
            if len(cut.starts) > 1:
                axes.set_ylabel(cut.starts[start], rotation=0, ha="right", va="center")
        if any(strip.place(band.low) <= _HELD_WIDTH for band in strip.above):
            lift = _LINES + max(text_width(short(band.label), _SIZE) for band in strip.above)
    if cut.held and start == 0:
        look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
        axes.annotate(cut.held, (0, 1), (0, 3 + lift), ha="left", va="bottom", **look)


def legend_of_strips(cuts: Sequence[Slice], page: Page) -> list[Any]:
    """Return entries of a legend: how long chaos was watched; regimes that no strip names."""
    handles: list[Any] = []
    shown = [(cut, labels) for cut in cuts if (labels := cut.marked_labels()) is not None]
    several = len(cuts) == 1 and _is_stacked(cuts[0])  # their dots are in the legend
    if not several and any(np.any(cut.labels() == CHAOS) for cut, _ in shown):
        text = in_legend(CHAOS, shown[0][0].view)
        handles.append(Patch(facecolor=OTHERS[CHAOS], label=text))
    out = []
    for cut, labels in shown:
        low, high = edges(cut.values)[[0, -1]]
        about = (float(low), float(high)), 72 * page.across, logarithmic(cut.values)
        if _is_stacked(cut):
            out += Strip(_widest(stacked_bands(cut.values, labels)), *about, False).left_out
        else:
            for column in labels.T:
                out += Strip(bands(cut.values, column), *about).left_out
    words = in_order({drawn_as(word) for word in out})
    for word in words[:_MOST_LEFT_OUT]:
        label = example_of(word)
        handles.append(Patch(label=short(word), **patch_look(label, color_of(label))))
    if len(words) > _MOST_LEFT_OUT:
        handles.append(Patch(color="none", label=f"and {len(words) - _MOST_LEFT_OUT} more"))
    return handles


def _is_stacked(cut: Slice) -> bool:
    return len(cut.starts) > MOST_STRIPS


class Strip:
    """The positions of the names of a strip: inside their bands, or upright above it.

    A regime whose name fits into none of its bands is named once, above the widest of them.  If
    names would be far from their bands, the narrowest are `left_out`, for a legend.  `points` is
    the width of the axis, whose limits are `ends`.
    """

    def __init__(
        self,
        regimes: Sequence[Band],
        ends: tuple[float, float],
        points: float,
        log: bool = False,
        inside: bool = True,
    ) -> None:
        self._ends, self._points, self._log = ends, points, log
        labels = {band.label for band in regimes} if inside else ()
        rooms = {label: text_width(short(label), _SIZE) + 2 * _PADDING for label in labels}
        self.inside = [
            band for band in regimes if inside and rooms[band.label] <= self._extent(band)
        ]
        named = {band.label for band in self.inside}
        beside = [
            band for band in regimes if band.label not in named and self._extent(band) >= _NARROWEST
        ]
        widest = {band.label: band for band in sorted(beside, key=self._extent)}
        self.above = sorted(widest.values(), key=lambda band: band.center)
        self.left_out: list[str] = []
        while self.above:
            if len(self.above) * _PITCH <= points:
                middles = np.array([self.middle(band) for band in self.above])
                farthest = float(np.abs(self.places(self.above) - middles).max()) * points
                if farthest <= _FARTHEST:
                    break
            narrowest = min(self.above, key=self._extent)
            self.above.remove(narrowest)
            self.left_out.append(narrowest.label)

    def place(self, value: float) -> float:
        """Return the position of a value, as a fraction of the axis."""
        low, high, at = np.log((*self._ends, value)) if self._log else (*self._ends, value)
        return float((at - low) / (high - low))

    def places(self, named: Sequence[Band]) -> np.ndarray:
        """Return the positions of the names of bands, from the left, as fractions of the axis."""
        pitch = _PITCH / self._points
        return spread([self.middle(band) for band in named], pitch, pitch / 2, 1.0 - pitch / 2)

    def middle(self, band: Band) -> float:
        return (self.place(band.low) + self.place(band.high)) / 2

    def _extent(self, band: Band) -> float:
        return self._points * (self.place(band.high) - self.place(band.low))


def draw_strip(axes: Axes, named: list[Band], color: Mapping[str, str]) -> Strip:
    """Draw bands of regimes as a strip in their colors, name them, return the names' positions."""
    for band in named:
        _fill(axes, band, color[band.label], 0.0, 1.0)
    return _name(axes, named, color)


def draw_stack(axes: Axes, values: np.ndarray, labels: np.ndarray) -> Strip:
    """Draw the labels (cells, starts) as a stack for each cell, in the order of legends."""
    rows = stacked_bands(values, labels)
    color = colors(band.label for row in rows for band in row)
    for place, row in enumerate(rows):
        for band in row:
            _fill(axes, band, color[band.label], place / len(rows), 1 / len(rows))
    return _name(axes, _widest(rows))


def stacked_bands(values: np.ndarray, labels: np.ndarray) -> list[list[Band]]:
    """Return the rows of bands of labels (cells, starts), sorted within each cell."""
    words = ordered(labels.ravel().tolist())
    rank = {word: place for place, word in enumerate(words)}
    ranks = np.sort(np.vectorize(rank.__getitem__, otypes=[int])(labels), axis=1)
    names = np.array(words, dtype=object)[ranks]
    return [bands(values, names[:, row]) for row in range(names.shape[1])]


def _widest(rows: Sequence[Sequence[Band]]) -> list[Band]:
    every = sorted((band for row in rows for band in row), key=lambda band: band.width)
    return sorted({band.label: band for band in every}.values(), key=lambda band: band.low)


def _fill(axes: Axes, band: Band, color: str, bottom: float, height: float) -> None:
    look = patch_look(band.label, color)
    axes.add_patch(Rectangle((band.low, bottom), band.width, height, **look))


def _name(axes: Axes, regimes: Sequence[Band], color: Mapping[str, str] | None = None) -> Strip:
    """Clear the axes, and write names into bands of these colors, or above, joined by a line."""
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(which="both", bottom=False, labelbottom=False)
    ends, is_log = axes.get_xlim(), axes.get_xscale() == "log"
    strip = Strip(regimes, ends, size_of(axes)[0], is_log, color is not None)
    for band in strip.inside:
        ink = (color or {})[band.label]
        look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": _SIZE}
        if hatch_of(band.label):  # a plain background for the name
            look["bbox"] = {"facecolor": ink, "edgecolor": "none", "pad": 1.0}
        look["color"] = "white" if is_dark(ink) else "black"
        axes.text(strip.middle(band), 0.5, short(band.label), transform=axes.transAxes, **look)
    above = offset_copy(axes.transAxes, figure_of(axes), 0.0, _LINES, units="points")
    look = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
    look |= {"xycoords": "axes fraction", "textcoords": above, "annotation_clip": False}
    arms = "arc,angleA=-90,angleB=90,armA=3,armB=3,rad=0"  # points
    look["arrowprops"] = {"arrowstyle": "-", "connectionstyle": arms, "shrinkA": 0, "shrinkB": 0}
    look["arrowprops"] |= {"color": "#555555", "linewidth": 0.4, "relpos": (0.5, 0.0)}
    for band, place in zip(strip.above, strip.places(strip.above), strict=True):
        axes.annotate(short(band.label), (strip.middle(band), 1.0), (place, 1.0), **look)
    return strip
