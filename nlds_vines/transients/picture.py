"""The picture of an ensemble: how many still wander, and where the others ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, PercentFormatter

from nlds_vines.plotting.palette import HATCHED, OTHERS, colours
from nlds_vines.plotting.style import CM, RIGHT, STYLE, WIDTH
from nlds_vines.transients.ensemble import Ensemble, Share
from nlds_vines.transients.survival import Decay, Survival

_LEFT = 0.135  # room for the names of regimes
_PANEL, _BAR, _BETWEEN, _FOOT, _HEAD = 7.2 * CM, 0.58 * CM, 1.55 * CM, 1.1 * CM, 0.9 * CM  # inches
_CURVE, _LAW = "#1b2a49", "#d55e00"
_SMALL = STYLE["xtick.labelsize"]
_WIDEST = 1.38  # of the axis of shares: room for words beside a full bar


@matplotlib.rc_context(STYLE)
def draw_ensemble(found: Ensemble, title: str) -> Figure:
    """Return the survival curve of an ensemble, with its law, over the shares of its regimes.

    The curve is Kaplan and Meier's with its interval; ticks mark where the watching of starts that
    had not settled ended.  Without any lifetime only the shares are drawn.
    """
    bars = (len(found.shares) + 0.7) * _BAR
    curve = _PANEL + _BETWEEN if found.counted.any() else 0.0
    height = _HEAD + curve + bars + _FOOT
    figure = Figure(figsize=(WIDTH, height))

    def panel(bottom: float, tall: float) -> Axes:
        return figure.add_axes((_LEFT, bottom / height, RIGHT + 0.05 - _LEFT, tall / height))

    axes = []
    if curve:
        axes.append(panel(_FOOT + bars + _BETWEEN, _PANEL))
        _draw_survival(axes[0], found)
    axes.append(panel(_FOOT, bars))
    _draw_shares(axes[-1], found.shares, found.level)
    for letter, place in zip("ab", axes if curve else [], strict=False):
        look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
        place.annotate(f"({letter})", (1, 1), (-5, -4), va="top", ha="right", **look)
    figure.text(_LEFT, 1 - 0.15 * CM / height, title, va="top")
    return figure


def _draw_survival(axes: Axes, found: Ensemble) -> None:
    """Draw the share that has not settled yet against time, on a scale of logarithms."""
    estimate, last = found.survival, float(found.times.max())
    time, share, low, high = _steps(estimate, last)
    shown = np.where(share > 0.0, share, np.nan)  # the logarithm of none is nowhere
    axes.step(time, shown, where="post", color=_CURVE, linewidth=1.1, label="not settled yet")
    axes.fill_between(
        time, low, high, step="post", color=_CURVE, alpha=0.18, linewidth=0,
        label=f"its {found.level:.0%} interval (Kaplan and Meier)",
    )  # fmt: skip
    _mark_censored(axes, found, time, share)
    floor = min(0.5, max(0.5 / found.times.size, float(low.min()) / 3))
    if found.decay is not None and found.decay.ended:
        _draw_law(axes, found.decay, float(np.interp(found.delay, time, share)), last, found.level)
    axes.set_yscale("log")
    axes.set_ylim(floor, 1.35)
    axes.set_xlim(0, max(1.0, last))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g}%"))
    axes.set_xlabel("forcing periods")
    axes.set_ylabel("starts not settled")
    axes.legend(loc="lower left", frameon=True, framealpha=0.85, edgecolor="none")


def _steps(estimate: Survival, last: float) -> tuple[np.ndarray, ...]:
    """Return time, share, low and high of the curve, from 0 to the last time watched.

    Where the interval is not defined, at shares of 1 and 0, it keeps what it was before.
    """
    time = np.concatenate([[0.0], estimate.times, [last]])
    share = _held(np.concatenate([[1.0], estimate.share, [np.nan]]))
    low = _held(np.concatenate([[1.0], estimate.low, [np.nan]]))
    high = _held(np.concatenate([[1.0], estimate.high, [np.nan]]))
    return time, share, low, high


def _held(values: np.ndarray) -> np.ndarray:
    """Return values with each NaN replaced by what stands before it; the first is a number."""
    known = np.where(np.isfinite(values), np.arange(values.size), 0)
    return values[np.maximum.accumulate(known)]


def _mark_censored(axes: Axes, found: Ensemble, time: np.ndarray, share: np.ndarray) -> None:
    times = np.unique(found.times[~found.ended])
    if times.size:
        at = share[np.searchsorted(time, times, side="right") - 1]
        look: dict[str, Any] = {"marker": "|", "markersize": 6, "linestyle": "none"}
        label = "no longer watched, not settled"
        axes.plot(times, at, color=_CURVE, clip_on=False, label=label, **look)


def _draw_law(axes: Axes, law: Decay, share: float, last: float, level: float) -> None:
    """Draw the exponential law from the delay on, where it takes up the curve's share."""
    time = np.linspace(law.delay, last, 200)
    low, middle, high = (
        share * np.exp(-rate * (time - law.delay)) for rate in (law.high, law.rate, law.low)
    )
    label = f"exp(−t/τ), τ = {law.mean:.4g} ({1 / law.high:.4g} to {1 / law.low:.4g}) periods"
    axes.fill_between(time, low, high, color=_LAW, alpha=0.22, linewidth=0)
    axes.plot(time, middle, color=_LAW, linewidth=1.0, linestyle="--", label=label)


def _draw_shares(axes: Axes, shares: Sequence[Share], level: float) -> None:
    """Draw the share of every final regime as a bar, its part through chaos hatched."""
    places = np.arange(len(shares))
    colour = colours(entry.label for entry in shares)
    for place, entry in zip(places, shares, strict=True):
        unknown = {"hatch": "//////", "edgecolor": "#8a8a8a", "linewidth": 0}
        look: dict[str, Any] = unknown if entry.label == HATCHED else {"linewidth": 0}
        axes.barh(place, entry.share, height=0.62, color=colour[entry.label], **look)
        through = entry.through_chaos / entry.total
        axes.barh(place, through, height=0.16, color=OTHERS["transient chaos"], linewidth=0)
        axes.hlines(place, entry.low, entry.high, color="black", linewidth=0.9)
        text = f"{entry.count}" + (f", {entry.through_chaos} through chaos" * bool(through))
        look = {"textcoords": "offset points", "va": "center", "fontsize": _SMALL}
        axes.annotate(text, (max(entry.share, entry.high), place), (5, 0), **look)
    axes.set_yticks(places, [entry.label for entry in shares])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(shares) - 0.4, -1.0)
    axes.set_xlim(0, _WIDEST)
    axes.set_xticks(np.linspace(0, 1, 6))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel(f"share of the starts, with its {level:.0%} interval")
