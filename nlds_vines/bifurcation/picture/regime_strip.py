"""The strip above a diagram that names the regimes along the axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from nlds_vines.plotting.bands import Band, bands, spread
from nlds_vines.plotting.palette import colors, hatch_of, is_dark, ordered, patch_look, short
from nlds_vines.plotting.panels import size_of, text_width

_SIZE = 7  # pt, of the names
_PITCH = 1.25 * _SIZE  # pt from one upright name to the next
_PADDING = 3  # pt on either side of a name inside its band
_NARROWEST = 0.5  # pt, least width of a band that is named: a narrower one is invisible
_LINES = 14  # pt between the strip and the names above it
_FARTHEST = 45  # pt between a name and the band that it names
_TALLEST = 96  # pt, of a name above a strip for which room is made


class Strip:
    """Where the names of a strip stand: inside their bands, or upright above it.

    A name stands in its band where it fits.  A regime whose name fits into none of its bands is
    named once, above the widest of them; its other bands are known by their color.  Where names
    would stand far from their bands, the narrowest are `left_out`, for a legend.

    Arguments: the bands; the `ends` of the axis; `points`, its width; whether it is logarithmic,
    and whether names may stand `inside`.
    """

    def __init__(
        self,
        found: Sequence[Band],
        ends: tuple[float, float],
        points: float,
        log: bool = False,
        inside: bool = True,
    ) -> None:
        """Find the places of the names."""
        self._ends, self._points, self._log = ends, points, log
        labels = {band.label for band in found} if inside else ()
        rooms = {label: text_width(short(label), _SIZE) + 2 * _PADDING for label in labels}
        self.inside = [band for band in found if inside and rooms[band.label] <= self._extent(band)]
        named = {band.label for band in self.inside}
        beside = [
            band for band in found if band.label not in named and self._extent(band) >= _NARROWEST
        ]
        widest = list({b.label: b for b in sorted(beside, key=self._extent)}.values())
        self.above, self.left_out = self._near(sorted(widest, key=lambda band: band.center))

    def place(self, value: float) -> float:
        """Return where a value stands, as a fraction of the axis."""
        low, high, at = np.log((*self._ends, value)) if self._log else (*self._ends, value)
        return float((at - low) / (high - low))

    @property
    def room(self) -> float:
        """The height in points that the names above take."""
        widths = [text_width(short(band.label), _SIZE) for band in self.above]
        return min(max(widths) + _LINES, _TALLEST) if widths else 0.0

    @property
    def pitch(self) -> float:
        """The distance of names above, as a fraction of the axis."""
        return _PITCH / self._points

    def _near(self, found: list[Band]) -> tuple[list[Band], list[str]]:
        """Return the bands whose names find room near them, and the labels of all others.

        Of too many for the axis, or for their places, the narrowest are left out.
        """
        out: list[str] = []
        while found and self._farthest(found) > _FARTHEST:
            narrowest = min(found, key=self._extent)
            found = [band for band in found if band is not narrowest]
            out.append(narrowest.label)
        return found, out

    def _farthest(self, found: Sequence[Band]) -> float:
        """Return the largest distance in points of a name from its band; infinite without room."""
        if len(found) * self.pitch > 1.0:
            return inf
        centers = np.array([self.middle(band) for band in found])
        return float(np.abs(self.places(found) - centers).max()) * self._points

    def places(self, found: Sequence[Band]) -> np.ndarray:
        """Return where the names of bands stand, from the left, as fractions of the axis."""
        centers = [self.middle(band) for band in found]
        return spread(centers, self.pitch, self.pitch / 2, 1.0 - self.pitch / 2)

    def middle(self, band: Band) -> float:
        """Return the middle of a band, as a fraction of the axis."""
        return (self.place(band.low) + self.place(band.high)) / 2

    def _extent(self, band: Band) -> float:
        return self._points * (self.place(band.high) - self.place(band.low))


def draw_strip(axes: Axes, found: list[Band], color: Mapping[str, str]) -> None:
    """Draw bands of regimes as a strip in their colors, and name them (`Strip`).

    The limits of the axes are those of the strip, or within it.
    """
    _clear(axes)
    for band in found:
        _fill(axes, band, color[band.label], 0.0, 1.0)
    strip = _strip_of(axes, found)
    for band in strip.inside:
        _name_inside(axes, strip, band, color[band.label])
    _name_above(axes, strip)


def draw_stack(axes: Axes, values: np.ndarray, labels: np.ndarray) -> None:
    """Draw the labels (cells, starts) of several starts: each cell a stack of their regimes.

    In each cell the regimes stand in the order of legends, with heights as are their shares.
    """
    _clear(axes)
    found = stacked_bands(values, labels)
    color = colors(band.label for row in found for band in row)
    for place, row in enumerate(found):
        for band in row:
            _fill(axes, band, color[band.label], place / len(found), 1 / len(found))
    _name_above(axes, _strip_of(axes, _widest(found), inside=False))


def stack_room(values: np.ndarray, labels: np.ndarray) -> list[Band]:
    """Return the bands that `draw_stack` names, for the room above it."""
    return _widest(stacked_bands(values, labels))


def stacked_bands(values: np.ndarray, labels: np.ndarray) -> list[list[Band]]:
    """Return the rows of bands of labels (cells, starts), sorted in each cell."""
    words = ordered(labels.ravel().tolist())
    rank = {word: place for place, word in enumerate(words)}
    ranks = np.sort(np.vectorize(rank.__getitem__, otypes=[int])(labels), axis=1)
    names = np.array(words, dtype=object)[ranks]
    return [bands(values, names[:, row]) for row in range(names.shape[1])]


def _widest(rows: Sequence[Sequence[Band]]) -> list[Band]:
    """Return the widest band of each regime in some rows."""
    every = sorted((band for row in rows for band in row), key=lambda band: band.width)
    return sorted({band.label: band for band in every}.values(), key=lambda band: band.low)


def _strip_of(axes: Axes, found: Sequence[Band], inside: bool = True) -> Strip:
    return Strip(found, axes.get_xlim(), size_of(axes)[0], axes.get_xscale() == "log", inside)


def _clear(axes: Axes) -> None:
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(which="both", bottom=False, labelbottom=False)


def _fill(axes: Axes, band: Band, color: str, bottom: float, height: float) -> None:
    look = patch_look(band.label, color)
    axes.add_patch(Rectangle((band.low, bottom), band.width, height, **look))


def _name_inside(axes: Axes, strip: Strip, band: Band, color: str) -> None:
    """Write the name of a band into its middle, on a ground of its own where it is hatched."""
    middle = strip.middle(band)
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": _SIZE}
    if hatch_of(band.label):
        look["bbox"] = {"facecolor": color, "edgecolor": "none", "pad": 1.0}
    ink = "white" if is_dark(color) else "black"
    axes.text(middle, 0.5, short(band.label), color=ink, transform=axes.transAxes, **look)


def _name_above(axes: Axes, strip: Strip) -> None:
    """Write names upright above the strip, side by side, each joined to its band by a line."""
    height = size_of(axes)[1]
    for band, place in zip(strip.above, strip.places(strip.above), strict=True):
        center = strip.middle(band)
        heights = [1.0, *(1.0 + share * _LINES / height for share in (0.2, 0.8, 0.95))]
        look: dict[str, Any] = {"transform": axes.transAxes, "clip_on": False}
        axes.plot([center, center, place, place], heights, color="#555555", linewidth=0.4, **look)
        style: dict[str, Any] = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
        axes.text(place, 1.0 + _LINES / height, short(band.label), **style, **look)
