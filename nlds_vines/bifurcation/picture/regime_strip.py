"""The strip above a diagram that names the regimes along the axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Rectangle
from matplotlib.textpath import TextPath

from nlds_vines.plotting.bands import Band, spread
from nlds_vines.plotting.palette import HATCHED, is_dark, short
from nlds_vines.plotting.style import FLAG_COLOUR, LEFT, RIGHT, STYLE, WIDTH

FLAG_WIDTH, _THINNEST = 1.5, 0.6
"""Width of a flag at most and at least [pt]."""

_POINTS = 72 * WIDTH * (RIGHT - LEFT)  # width of the strip
_SIZE = 7  # pt, of the names
_PITCH = 1.25 * _SIZE  # pt from one upright name to the next
_PADDING = 3  # pt on either side of a name inside its band
_FOOT = -0.22, 0.0  # of the height: flags stand between the strip and what is below it
_NARROWEST = 0.5  # pt: what is narrower cannot be seen and is not named


def mark_flagged(axes: Axes, values: np.ndarray, flagged: np.ndarray) -> None:
    """Mark at the foot of a strip those `values` along it where a label is not kept."""
    width = min(max(_POINTS / values.size, _THINNEST), FLAG_WIDTH)
    axes.vlines(values[flagged], *_FOOT, color=FLAG_COLOUR, linewidth=width, clip_on=False)


def draw_strip(axes: Axes, found: list[Band], colour: Mapping[str, str]) -> None:
    """Draw bands of regimes as a strip in their colours, and name as many as there is room for.

    A name goes into its band where it fits. A regime that has room for its name nowhere is named
    once, upright above its widest band at the end of a line: its colour tells the others.
    """
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    axes.tick_params(bottom=False, labelbottom=False)
    scale = _POINTS / (found[-1].high - found[0].low)  # points per unit of the parameter
    inside, beside = set(), []
    for band in found:
        _fill(axes, band, colour[band.label])
        if _width(_name(band)) + 2 * _PADDING <= band.width * scale:
            _name_inside(axes, band, "white" if is_dark(colour[band.label]) else "black")
            inside.add(band.label)
        elif band.width * scale >= _NARROWEST:
            beside.append(band)
    widest = {band.label: band for band in sorted(beside, key=lambda band: band.width)}
    untold = [band for label, band in widest.items() if label not in inside]
    _name_above(axes, untold, scale, found[0].low, found[-1].high)


def _name(band: Band) -> str:
    """Return what is written for a band: its label, a transient in short."""
    return short(band.label)


def _fill(axes: Axes, band: Band, colour: str) -> None:
    hatch: dict[str, Any] = (
        {"hatch": "//////", "edgecolor": "#8a8a8a"} if band.label == HATCHED else {}
    )
    box = Rectangle((band.low, 0), band.width, 1, facecolor=colour, linewidth=0, **hatch)
    axes.add_patch(box)


def _name_inside(axes: Axes, band: Band, ink: str) -> None:
    place: dict[str, Any] = {"ha": "center", "va": "center_baseline"}
    axes.text(band.centre, 0.5, _name(band), color=ink, fontsize=_SIZE, **place)


def _name_above(axes: Axes, named: list[Band], scale: float, low: float, high: float) -> None:
    """Write names upright above the strip, side by side, each joined to its band by a line."""
    pitch = _PITCH / scale
    room = int((high - low) / pitch)
    widest = sorted(named, key=lambda band: -band.width)[:room]
    chosen = sorted(widest, key=lambda band: band.centre)
    places = spread([band.centre for band in chosen], pitch, low + pitch / 2, high - pitch / 2)
    for band, place in zip(chosen, places, strict=True):
        line = [band.centre, band.centre, place, place], [1.0, 1.15, 1.65, 1.8]
        axes.plot(*line, color="#555555", linewidth=0.4, clip_on=False)
        style: dict[str, Any] = {"fontsize": _SIZE, "rotation": 90, "ha": "center", "va": "bottom"}
        axes.text(place, 1.95, _name(band), **style)


def _width(text: str) -> float:
    """Return the width of a name in points."""
    font = FontProperties(family=STYLE["font.family"], size=_SIZE)
    return float(TextPath((0, 0), text, prop=font).get_extents().width)
