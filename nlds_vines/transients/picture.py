"""The picture of an ensemble: how many starts have not settled yet, and where the others ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    new_figure,
    size_of,
    styled,
    write_letters,
)
from nlds_vines.plotting.palette import OTHERS, colors, patch_look
from nlds_vines.plotting.style import CM, HUES, NAVY, STYLE
from nlds_vines.transients.ensemble import Ensemble, ensemble_of
from nlds_vines.transients.survival import DELAY, Decay, Survival

_PANEL, _NARROW_PANEL, _BAR = 7.2 * CM, 5.4 * CM, 0.58 * CM  # inches, heights
_CURVE, _LAW = NAVY, HUES["vermillion"]
_WIDEST, _NARROW_WIDEST = 1.5, 2.1  # upper end of the axis of shares: words beside a full bar
_NARROW = 260  # points, width of axes below which bars and labels are those of one column
_SURVIVAL, _SHARES = "survival", "shares"


@styled()
def draw_ensemble(
    ensemble: Ensemble, title: str, page: Page = TWO_COLUMNS, shown: Sequence[str] = ()
) -> Figure:
    """Return the survival curve of an ensemble, with its law, above the shares of its regimes.

    The curve is the Kaplan-Meier estimate with its interval; ticks mark the times up to which
    starts that had not settled were watched.  Without any lifetime only the shares are drawn.

    Arguments: the ensemble, the title, the `page`, the panels that are `shown` (by default all).
    """
    names = shown or list(panels_of(ensemble))
    heights = {_SURVIVAL: _PANEL if page.beside else _NARROW_PANEL}
    heights[_SHARES] = (len(ensemble.shares) + 0.2) * _BAR
    figure, grid = new_figure(page, [heights[name] for name in names])
    panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
    for name, panel in zip(names, panels, strict=True):
        _PANELS[name](panel, ensemble, page)
    write_letters(panels)
    finish(figure, grid, title)
    return figure


def panels_of(ensemble: Ensemble) -> dict[str, str]:
    """Return the meaning of each panel by name."""
    curve = {_SURVIVAL: "share of the starts that have not settled yet, over time"}
    shares = {_SHARES: "share of the starts that ended in each regime"}
    return {**(curve if ensemble.counted.any() else {}), **shares}


def _draw_survival(axes: Axes, ensemble: Ensemble, page: Page = TWO_COLUMNS) -> None:
    """Draw the share that has not settled yet against time, on a logarithmic scale."""
    estimate, last = ensemble.survival, float(ensemble.times.max())
    time, share, low, high = _steps(estimate, last)
    shown = np.where(share > 0.0, share, np.nan)  # zero has no place on the scale
    axes.step(time, shown, where="post", color=_CURVE, linewidth=1.1, label="not settled yet")
    axes.fill_between(
        time, low, high, step="post", color=_CURVE, alpha=0.18, linewidth=0,
        label=f"its {ensemble.level:.0%} interval (Kaplan and Meier)",
    )  # fmt: skip
    _mark_censored(axes, ensemble, time, share)
    floor = min(0.5, max(0.5 / ensemble.times.size, float(low.min()) / 3))
    if ensemble.decay is not None and ensemble.decay.ended:
        _draw_law(axes, ensemble.decay, float(np.interp(ensemble.delay, time, share)), last)
    axes.set_yscale("log")
    axes.set_ylim(floor, 1.35)
    axes.set_xlim(0, max(1.0, last))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g}"))
    axes.set_xlabel("time $t/T$ [forcing periods]")
    axes.set_ylabel("share of starts not settled [%]")
    if page.beside:
        axes.legend(loc="lower left", frameon=True, framealpha=0.85, edgecolor="none")
        return
    add_legend(axes, axes.get_legend_handles_labels()[0], "below", handlelength=2.2)


def _steps(estimate: Survival, last: float) -> tuple[np.ndarray, ...]:
    """Return time, share, low and high of the curve, from 0 to the last time watched.

    Where the interval is not defined, at shares of 1 and 0, its last values continue.
    """
    time = np.concatenate([[0.0], estimate.times, [last]])
    curves = (estimate.share, estimate.low, estimate.high)
    return time, *(_held(np.concatenate([[1.0], values, [np.nan]])) for values in curves)


def _held(values: np.ndarray) -> np.ndarray:
    """Replace each NaN by the last number before it; the first value is a number."""
    places = np.where(np.isfinite(values), np.arange(values.size), 0)
    return values[np.maximum.accumulate(places)]


def _mark_censored(axes: Axes, ensemble: Ensemble, time: np.ndarray, share: np.ndarray) -> None:
    """Mark on the curve where the watching of unsettled starts ended."""
    times = np.unique(ensemble.times[~ensemble.ended])
    if times.size:
        at = share[np.searchsorted(time, times, side="right") - 1]
        look: dict[str, Any] = {"marker": "|", "markersize": 6, "linestyle": "none"}
        label = "no longer watched, not settled"
        axes.plot(times, at, color=_CURVE, clip_on=False, label=label, **look)


def _draw_law(axes: Axes, law: Decay, share: float, last: float) -> None:
    """Draw the exponential law from the delay, beginning at `share`, to the time `last`."""
    time = np.linspace(law.delay, last, 200)
    low, middle, high = (
        share * np.exp(-rate * (time - law.delay)) for rate in (law.high, law.rate, law.low)
    )
    ends = f"{1 / law.high:.3g} to {1 / law.low:.3g}"
    label = rf"$\exp(-t/\tau)$, $\tau={law.mean:.3g}\,T$ (interval: {ends})"
    axes.fill_between(time, low, high, color=_LAW, alpha=0.22, linewidth=0)
    axes.plot(time, middle, color=_LAW, linewidth=1.0, linestyle="--", label=label)


def _draw_shares(axes: Axes, ensemble: Ensemble, _page: Page = TWO_COLUMNS) -> None:
    """Draw the share of every final regime as a bar, with its part through chaos."""
    shares = ensemble.shares
    places = np.arange(len(shares))
    color = colors(entry.label for entry in shares)
    for place, entry in zip(places, shares, strict=True):
        look = patch_look(entry.label, color[entry.label])
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
    narrow = size_of(axes)[0] < _NARROW
    axes.set_xlim(0, _NARROW_WIDEST if narrow else _WIDEST)
    axes.set_xticks(np.linspace(0, 1, 6))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=None))
    words = f"share of the starts [%], with its {ensemble.level:.0%} interval"
    axes.set_xlabel(f"{words};{chr(10) if narrow else ' '}brown: through chaos")


_PANELS = {_SURVIVAL: _draw_survival, _SHARES: _draw_shares}


def picture(delay: float = DELAY) -> Picture:
    """Return the picture of an ensemble, with the law fitted beyond a `delay` [periods]."""

    def read(view: ArchiveView) -> Ensemble:
        return ensemble_of(view, delay=delay)

    return Picture(
        panels=lambda view: panels_of(read(view)),
        draw=lambda view, names, page: draw_ensemble(read(view), view.text("title"), page, names),
        fill=lambda axes, view, name: _PANELS[name](axes, read(view)),
    )


PICTURE = picture()
"""What draws the archive of an ensemble."""
