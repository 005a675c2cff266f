"""The picture of an ensemble: how many starts have not settled yet, and where the others ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, PercentFormatter

from nlds_vines.errors import RequestError
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.palette import OTHERS, colours, patch_look
from nlds_vines.plotting.panels import add_panel, write_letters, write_title
from nlds_vines.plotting.style import CM, HUES, NAVY, RIGHT, STYLE, WIDTH
from nlds_vines.transients.ensemble import Ensemble, Share
from nlds_vines.transients.survival import Decay, Survival

_LEFT, _RIGHT = 0.135, RIGHT + 0.05  # of the width: room for the names of regimes on the left
_PANEL, _BAR, _BETWEEN, _FOOT, _HEAD = 7.2 * CM, 0.58 * CM, 1.55 * CM, 1.1 * CM, 1.1 * CM  # inches
_CURVE, _LAW = NAVY, HUES["vermillion"]
_WIDEST = 1.5  # upper end of the axis of shares: room for words beside a full bar


@styled()
def draw_ensemble(found: Ensemble, title: str) -> Figure:
    """Return the survival curve of an ensemble, with its law, above the shares of its regimes.

    The curve is the Kaplan-Meier estimate with its interval; ticks mark the times up to which
    starts that had not settled were watched.  Without any lifetime only the shares are drawn.
    """
    bars = (len(found.shares) + 0.2) * _BAR
    curve = _PANEL + _BETWEEN if found.counted.any() else 0.0
    height = _HEAD + curve + bars + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    left, across = _LEFT * WIDTH, (_RIGHT - _LEFT) * WIDTH
    panels = []
    if curve:
        panels.append(add_panel(figure, (left, _FOOT + bars + _BETWEEN, across, _PANEL)))
        _draw_survival(panels[0], found)
    panels.append(add_panel(figure, (left, _FOOT, across, bars)))
    _draw_shares(panels[-1], found.shares, found.level)
    write_letters(panels)
    write_title(figure, title, _LEFT)
    return figure


def survival_into(axes: Axes, found: Ensemble) -> None:
    """Draw the survival curve of an ensemble into axes; `RequestError` where nothing settled."""
    if not found.counted.any():
        raise RequestError("no start of this ensemble has a lifetime: there is no curve to draw")
    _draw_survival(axes, found)


def _draw_survival(axes: Axes, found: Ensemble) -> None:
    """Draw the share that has not settled yet against time, on a logarithmic scale."""
    estimate, last = found.survival, float(found.times.max())
    time, share, low, high = _steps(estimate, last)
    shown = np.where(share > 0.0, share, np.nan)  # zero has no place on the scale
    axes.step(time, shown, where="post", color=_CURVE, linewidth=1.1, label="not settled yet")
    axes.fill_between(
        time, low, high, step="post", color=_CURVE, alpha=0.18, linewidth=0,
        label=f"its {found.level:.0%} interval (Kaplan and Meier)",
    )  # fmt: skip
    _mark_censored(axes, found, time, share)
    floor = min(0.5, max(0.5 / found.times.size, float(low.min()) / 3))
    if found.decay is not None and found.decay.ended:
        _draw_law(axes, found.decay, float(np.interp(found.delay, time, share)), last)
    axes.set_yscale("log")
    axes.set_ylim(floor, 1.35)
    axes.set_xlim(0, max(1.0, last))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g}"))
    axes.set_xlabel("time $t/T$ [forcing periods]")
    axes.set_ylabel("share of starts not settled [%]")
    axes.legend(loc="lower left", frameon=True, framealpha=0.85, edgecolor="none")


def _steps(estimate: Survival, last: float) -> tuple[np.ndarray, ...]:
    """Return time, share, low and high of the curve, from 0 to the last time watched.

    Where the interval is not defined, at shares of 1 and 0, it keeps its last values.
    """
    time = np.concatenate([[0.0], estimate.times, [last]])
    curves = (estimate.share, estimate.low, estimate.high)
    return time, *(_held(np.concatenate([[1.0], values, [np.nan]])) for values in curves)


def _held(values: np.ndarray) -> np.ndarray:
    """Return values with each NaN replaced by the last number before it; the first is a number."""
    known = np.where(np.isfinite(values), np.arange(values.size), 0)
    return values[np.maximum.accumulate(known)]


def _mark_censored(axes: Axes, found: Ensemble, time: np.ndarray, share: np.ndarray) -> None:
    """Mark on the curve of `share` over `time` where the watching of unsettled starts ended."""
    times = np.unique(found.times[~found.ended])
    if times.size:
        at = share[np.searchsorted(time, times, side="right") - 1]
        look: dict[str, Any] = {"marker": "|", "markersize": 6, "linestyle": "none"}
        label = "no longer watched, not settled"
        axes.plot(times, at, color=_CURVE, clip_on=False, label=label, **look)


def _draw_law(axes: Axes, law: Decay, share: float, last: float) -> None:
    """Draw the exponential law from the delay, where it begins at the `share`, to `last`."""
    time = np.linspace(law.delay, last, 200)
    low, middle, high = (
        share * np.exp(-rate * (time - law.delay)) for rate in (law.high, law.rate, law.low)
    )
    ends = f"{1 / law.high:.3g} to {1 / law.low:.3g}"
    label = rf"$\exp(-t/\tau)$, $\tau={law.mean:.3g}\,T$ (interval: {ends})"
    axes.fill_between(time, low, high, color=_LAW, alpha=0.22, linewidth=0)
    axes.plot(time, middle, color=_LAW, linewidth=1.0, linestyle="--", label=label)


def _draw_shares(axes: Axes, shares: Sequence[Share], level: float) -> None:
    """Draw the share of every final regime as a bar, its part through chaos as a narrow bar."""
    places = np.arange(len(shares))
    colour = colours(entry.label for entry in shares)
    for place, entry in zip(places, shares, strict=True):
        look = patch_look(entry.label, colour[entry.label])
        axes.barh(place, entry.share, height=0.62, **look)
        through = entry.through_chaos / entry.total
        axes.barh(place, through, height=0.16, color=OTHERS["transient chaos"], linewidth=0)
        axes.hlines(place, entry.low, entry.high, color="black", linewidth=0.9)
        text = f"{entry.count}" + (f", {entry.through_chaos} through chaos" * bool(through))
        look = {"textcoords": "offset points", "va": "center", "fontsize": STYLE["xtick.labelsize"]}
        axes.annotate(text, (max(entry.share, entry.high), place), (5, 0), **look)
    axes.set_yticks(places, [entry.label for entry in shares])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(shares) - 0.4, -0.6)
    axes.set_xlim(0, _WIDEST)
    axes.set_xticks(np.linspace(0, 1, 6))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=None))
    axes.set_xlabel(f"share of the starts [%], with its {level:.0%} interval; brown: through chaos")
