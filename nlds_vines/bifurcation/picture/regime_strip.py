"""The strips above a diagram that name the regimes along the axis; their legend."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
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
    """A row of a diagram: its height in inches, and the function that draws it.

    `quantity` is that of a panel, empty for a strip; panels of one quantity share its scale.
    """

    height: float
    draw: Callable[[Axes], None]
    quantity: str = ""


def strips_of(cut: Slice) -> list[Tier]:
    """Return the strips of a slice: one for each of up to two starts, or a stack.

    Above the first one is the value of the parameter that is constant, if there is one.
    """
    if cut.labels() is None:
        return [Tier(NO_STRIP, partial(draw_strip_of, cut=cut))] if cut.held else []
    height = STACK if _is_stacked(cut) else STRIP
    return [Tier(height, partial(draw_strip_of, cut=cut, start=n)) for n in range(_count(cut))]


def draw_strip_of(axes: Axes, cut: Slice, start: int = 0) -> None:
    """Draw a strip of a slice into axes: of one start, or the stack of many."""
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
            for start in range(_count(cut)):
                out += Strip(bands(cut.values, labels[:, start]), *about).left_out
    words = in_order({drawn_as(word) for word in out})
    for word in words[:_MOST_LEFT_OUT]:
        label = example_of(word)
        handles.append(Patch(label=short(word), **patch_look(label, color_of(label))))
    if len(words) > _MOST_LEFT_OUT:
        handles.append(Patch(color="none", label=f"and {len(words) - _MOST_LEFT_OUT} more"))
    return handles


def _count(cut: Slice) -> int:
    return 1 if _is_stacked(cut) else len(cut.starts)


def _is_stacked(cut: Slice) -> bool:
    return len(cut.starts) > MOST_STRIPS


class Strip:
    """The positions of the names of a strip: inside their bands, or upright above it.

    A name is written inside its band if it fits.  A regime whose name fits into none of its bands
    is named once, above the widest of them; its other bands are recognized by their color.  If
    names would be far from their bands, the narrowest are `left_out`, for a legend.

    Arguments: the bands; the `ends` of the axis; `points`, its width; whether it is logarithmic,
    and whether names may be `inside`.
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
        widest = list({b.label: b for b in sorted(beside, key=self._extent)}.values())
        self.above, self.left_out = self._near(sorted(widest, key=lambda band: band.center))

    def place(self, value: float) -> float:
        """Return the position of a value, as a fraction of the axis."""
        low, high, at = np.log((*self._ends, value)) if self._log else (*self._ends, value)
        return float((at - low) / (high - low))

    @property
    def pitch(self) -> float:
        return _PITCH / self._points

    def _near(self, named: list[Band]) -> tuple[list[Band], list[str]]:
        """Return the bands whose names find room near them, and the labels of the others.

        If there are too many, the narrowest are left out.
        """
        out: list[str] = []
        while named and self._farthest(named) > _FARTHEST:
            narrowest = min(named, key=self._extent)
            named = [band for band in named if band is not narrowest]
            out.append(narrowest.label)
        return named, out

    def _farthest(self, named: Sequence[Band]) -> float:
        """Return the largest distance in points of a name from its band; inf without room."""
        if len(named) * self.pitch > 1.0:
            return inf
        centers = np.array([self.middle(band) for band in named])
        return float(np.abs(self.places(named) - centers).max()) * self._points

    def places(self, named: Sequence[Band]) -> np.ndarray:
        """Return the positions of the names of bands, from the left, as fractions of the axis."""
        centers = [self.middle(band) for band in named]
        return spread(centers, self.pitch, self.pitch / 2, 1.0 - self.pitch / 2)

    def middle(self, band: Band) -> float:
        return (self.place(band.low) + self.place(band.high)) / 2

    def _extent(self, band: Band) -> float:
        return self._points * (self.place(band.high) - self.place(band.low))


def draw_strip(axes: Axes, named: list[Band], color: Mapping[str, str]) -> Strip:
    """Draw bands of regimes as a strip in their colors, name them, return the names' positions."""
    _clear(axes)
    for band in named:
        _fill(axes, band, color[band.label], 0.0, 1.0)
    strip = _strip_of(axes, named)
    for band in strip.inside:
        _name_inside(axes, strip, band, color[band.label])
    _name_above(axes, strip)
    return strip


def draw_stack(axes: Axes, values: np.ndarray, labels: np.ndarray) -> Strip:
    """Draw the labels (cells, starts) of several starts as one stack for each cell.

    The regimes of a cell are in the order of legends, with heights in proportion to their shares.
    Returns the positions of the names.
    """
    _clear(axes)
    rows = stacked_bands(values, labels)
    color = colors(band.label for row in rows for band in row)
    for place, row in enumerate(rows):
        for band in row:
            _fill(axes, band, color[band.label], place / len(rows), 1 / len(rows))
    strip = _strip_of(axes, _widest(rows), inside=False)
    _name_above(axes, strip)
    return strip


def stacked_bands(values: np.ndarray, labels: np.ndarray) -> list[list[Band]]:
    """Return the rows of bands of labels (cells, starts), sorted within each cell."""
    words = ordered(labels.ravel().tolist())
    rank = {word: place for place, word in enumerate(words)}
    ranks = np.sort(np.vectorize(rank.__getitem__, otypes=[int])(labels), axis=1)
    names = np.array(words, dtype=object)[ranks]
    return [bands(values, names[:, row]) for row in range(names.shape[1])]


def _widest(rows: Sequence[Sequence[Band]]) -> list[Band]:
    """Return the widest band of each regime in some rows."""
    every = sorted((band for row in rows for band in row), key=lambda band: band.width)
    return sorted({band.label: band for band in every}.values(), key=lambda band: band.low)


def _strip_of(axes: Axes, regimes: Sequence[Band], inside: bool = True) -> Strip:
    return Strip(regimes, axes.get_xlim(), size_of(axes)[0], axes.get_xscale() == "log", inside)


def _clear(axes: Axes) -> None:
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(which="both", bottom=False, labelbottom=False)


def _fill(axes: Axes, band: Band, color: str, bottom: float, height: float) -> None:
    look = patch_look(band.label, color)
    axes.add_patch(Rectangle((band.low, bottom), band.width, height, **look))


def _name_inside(axes: Axes, strip: Strip, band: Band, color: str) -> None:
    """Write the name of a band into its middle; a hatched band gets a plain background there."""
    middle = strip.middle(band)
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": _SIZE}
    if hatch_of(band.label):
        look["bbox"] = {"facecolor": color, "edgecolor": "none", "pad": 1.0}
    ink = "white" if is_dark(color) else "black"
    axes.text(middle, 0.5, short(band.label), color=ink, transform=axes.transAxes, **look)


def _name_above(axes: Axes, strip: Strip) -> None:
    """Write names upright above the strip, side by side, each joined to its band by a line."""
    above = offset_copy(axes.transAxes, figure_of(axes), 0.0, _LINES, units="points")
    look: dict[str, Any] = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
    look |= {"xycoords": "axes fraction", "textcoords": above, "annotation_clip": False}
    arms = "arc,angleA=-90,angleB=90,armA=3,armB=3,rad=0"  # points
    look["arrowprops"] = {"arrowstyle": "-", "connectionstyle": arms, "shrinkA": 0, "shrinkB": 0}
    look["arrowprops"] |= {"color": "#555555", "linewidth": 0.4, "relpos": (0.5, 0.0)}
    for band, place in zip(strip.above, strip.places(strip.above), strict=True):
        axes.annotate(short(band.label), (strip.middle(band), 1.0), (place, 1.0), **look)
