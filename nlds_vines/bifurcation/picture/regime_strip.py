"""The strip above a diagram that names the regimes along the axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from nlds_vines.plotting.bands import Band, spread
from nlds_vines.plotting.palette import is_dark, patch_look, short
from nlds_vines.plotting.panels import text_width
from nlds_vines.plotting.style import FLAG_COLOUR, LEFT, RIGHT, WIDTH

FLAG_WIDTH = 1.5
"""Width of a flag at most [pt]."""

_THINNEST_FLAG = 0.6  # pt, where flags of neighbouring cells would overlap
_FLAG_HEIGHTS = -0.22, 0.0  # of the strip's height: between the strip and the panel below it
_STRIP = 72 * WIDTH * (RIGHT - LEFT)  # pt, width of the strip
_SIZE = 7  # pt, of the names
_PITCH = 1.25 * _SIZE  # pt from one upright name to the next
_PADDING = 3  # pt on either side of a name inside its band
_NARROWEST = 0.5  # pt, least width of a band that is named: a narrower one is invisible


def mark_flagged(axes: Axes, values: np.ndarray, flagged: np.ndarray) -> None:
    """Mark at the foot of a strip those `values` (n,) along it that are `flagged` (n,)."""
    width = min(max(_STRIP / values.size, _THINNEST_FLAG), FLAG_WIDTH)
    axes.vlines(values[flagged], *_FLAG_HEIGHTS, color=FLAG_COLOUR, linewidth=width, clip_on=False)


def draw_strip(axes: Axes, found: list[Band], colour: Mapping[str, str]) -> None:
    """Draw bands of regimes as a strip in their colours, and name as many as there is room for.

    A name stands in its band where it fits.  A regime whose name fits into none of its bands is
    named once, upright above the widest of them at the end of a line; its other bands are known by
    their colour.
    """
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(bottom=False, labelbottom=False)
    scale = _STRIP / (found[-1].high - found[0].low)  # points per unit of the parameter
    inside, beside = set(), []
    for band in found:
        look = patch_look(band.label, colour[band.label])
        axes.add_patch(Rectangle((band.low, 0), band.width, 1, **look))
        if text_width(short(band.label), _SIZE) + 2 * _PADDING <= band.width * scale:
            _name_inside(axes, band, "white" if is_dark(colour[band.label]) else "black")
            inside.add(band.label)
        elif band.width * scale >= _NARROWEST:
            beside.append(band)
    widest = {band.label: band for band in sorted(beside, key=lambda band: band.width)}
    unnamed = [band for label, band in widest.items() if label not in inside]
    _name_above(axes, unnamed, scale, found[0].low, found[-1].high)


def _name_inside(axes: Axes, band: Band, ink: str) -> None:
    """Write the name of a band into its middle."""
    place: dict[str, Any] = {"ha": "center", "va": "center_baseline"}
    axes.text(band.centre, 0.5, short(band.label), color=ink, fontsize=_SIZE, **place)


def _name_above(axes: Axes, named: list[Band], scale: float, low: float, high: float) -> None:
    """Write names upright above the strip, side by side, each joined to its band by a line.

    Arguments: the bands; `scale`, points per unit of the parameter; the ends of the strip.  Where
    there is no room for all, the widest bands are named.
    """
    pitch = _PITCH / scale
    room = int((high - low) / pitch)
    widest = sorted(named, key=lambda band: -band.width)[:room]
    chosen = sorted(widest, key=lambda band: band.centre)
    places = spread([band.centre for band in chosen], pitch, low + pitch / 2, high - pitch / 2)
    for band, place in zip(chosen, places, strict=True):
        line = [band.centre, band.centre, place, place], [1.0, 1.15, 1.65, 1.8]
        axes.plot(*line, color="#555555", linewidth=0.4, clip_on=False)
        style: dict[str, Any] = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
        axes.text(place, 1.95, short(band.label), **style)
