"""The strips of regimes above the panels of a diagram: how many, and their legend."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from nlds_vines.bifurcation.observation_time import in_legend
from nlds_vines.bifurcation.picture.ordinates import Slice
from nlds_vines.bifurcation.picture.regime_strip import (
    Strip,
    draw_stack,
    draw_strip,
    stack_room,
)
from nlds_vines.model.labels import CHAOS
from nlds_vines.plotting.bands import Band, bands, edges, logarithmic
from nlds_vines.plotting.page import Page
from nlds_vines.plotting.palette import (
    OTHERS,
    color_of,
    colors,
    drawn_as,
    example_of,
    in_order,
    patch_look,
    short,
)
from nlds_vines.plotting.style import CM

MOST_STRIPS = 2
"""The most starts with a strip of their own; more are stacked in one."""

_MOST_LEFT_OUT = 11  # entries of a legend for regimes that no strip names
_HELD_WIDTH = 0.4  # of a strip: the room for the value at which another parameter is held

_STRIP, _STACK, _MARGIN, _HELD = 0.42 * CM, 0.75 * CM, 0.18 * CM, 0.45 * CM  # inches


@dataclass(frozen=True)
class Tier:
    """Axes of a diagram: the room above them and their height in inches, and what draws them.

    `quantity` is what a panel shows, empty for a strip; panels of one quantity share its scale.
    """

    above: float
    height: float
    draw: Callable[[Axes], None]
    quantity: str = ""


def strips_of(cut: Slice, page: Page) -> list[Tier]:
    """Return the strips of a slice: of one start, of each of two, or a stack of more.

    Above the first one stands the value at which another parameter is held, if there is one.
    """
    held = _HELD if cut.held else 0.0
    labels = cut.marked_labels()
    if labels is None:
        return [Tier(held, 0.0, partial(_write_held, cut=cut))] if held else []
    stacked = len(cut.starts) > MOST_STRIPS
    found = []
    for start in range(_count(cut)):
        names, beside = _names(_strip(cut, labels, start, page))
        lift = 0.0 if beside or start else names
        room = max(names, lift + (0.0 if start else held)) + _MARGIN
        draw = partial(draw_strip_of, cut=cut, start=start, lift=72 * lift)
        found.append(Tier(room, _STACK if stacked else _STRIP, draw))
    return found


def draw_strip_of(axes: Axes, cut: Slice, start: int = 0, lift: float = 0.0) -> None:
    """Draw a strip of a slice into axes: of one start, or the stack of many.

    The value at which another parameter is held stands `lift` points above it.
    """
    labels = cut.marked_labels()
    if labels is None:
        return
    if logarithmic(cut.values):
        axes.set_xscale("log")
    if len(cut.starts) > MOST_STRIPS:
        draw_stack(axes, cut.values, labels)
    else:
        draw_strip(axes, _bands(cut, labels, start), colors(labels.ravel().tolist()))
        if len(cut.starts) > 1:
            axes.set_ylabel(cut.starts[start], rotation=0, ha="right", va="center")
    if start == 0:
        _write_held(axes, cut, lift)


def legend_of_strips(cuts: Sequence[Slice], page: Page) -> list[Any]:
    """Return entries of a legend: how long chaos was watched; what no strip names."""
    found: list[Any] = []
    shown = [cut for cut in cuts if cut.labels() is not None]
    several = len(cuts) == 1 and len(cuts[0].starts) > MOST_STRIPS  # their dots are in the legend
    if not several and any(np.any(cut.labels() == CHAOS) for cut in shown):
        text = in_legend(CHAOS, shown[0].view)
        found.append(Patch(facecolor=OTHERS[CHAOS], label=text))
    out = [word for cut in shown for strip in _strips(cut, page) for word in strip.left_out]
    words = in_order({drawn_as(word) for word in out})
    for word in words[:_MOST_LEFT_OUT]:
        label = example_of(word)
        found.append(Patch(label=short(word), **patch_look(label, color_of(label))))
    if len(words) > _MOST_LEFT_OUT:
        found.append(Patch(color="none", label=f"and {len(words) - _MOST_LEFT_OUT} more"))
    return found


def _bands(cut: Slice, labels: np.ndarray, start: int) -> list[Band]:
    return bands(cut.values, labels[:, start])


def _strips(cut: Slice, page: Page) -> list[Strip]:
    """Return the strips of a slice that has labels."""
    labels = cut.marked_labels()
    assert labels is not None
    return [_strip(cut, labels, start, page) for start in range(_count(cut))]


def _count(cut: Slice) -> int:
    """Return how many strips a slice has."""
    return len(cut.starts) if len(cut.starts) <= MOST_STRIPS else 1


def _strip(cut: Slice, labels: np.ndarray, start: int, page: Page) -> Strip:
    """Return where the names of a strip stand: of one start, or of the stack of many."""
    low, high = edges(cut.values)[[0, -1]]
    stacked = len(cut.starts) > MOST_STRIPS
    found = stack_room(cut.values, labels) if stacked else _bands(cut, labels, start)
    ends, log = (float(low), float(high)), logarithmic(cut.values)
    return Strip(found, ends, 72 * page.across, log, inside=not stacked)


def _names(strip: Strip) -> tuple[float, bool]:
    """Return the height in inches of the names above a strip, and whether its left end is free."""
    beside = all(strip.place(band.low) > _HELD_WIDTH for band in strip.above)
    return strip.room / 72, beside


def _write_held(axes: Axes, cut: Slice, lift: float = 0.0) -> None:
    """Write above the left end of a strip at which value another parameter is held."""
    if not cut.held:
        return
    if cut.labels() is None:
        axes.set_axis_off()
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate(cut.held, (0, 1), (0, 3 + lift), ha="left", va="bottom", **look)
