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
from nlds_vines.plotting.palette import OTHERS, patch_look
from nlds_vines.plotting.style import CM, HUES, NAVY, STYLE
from nlds_vines.transients.ensemble import DELAY, Ensemble, ensemble_of

_PANEL, _NARROW_PANEL, _BAR = 7.2 * CM, 5.4 * CM, 0.58 * CM  # inches, heights
_CURVE, _LAW = NAVY, HUES["vermillion"]
_WIDEST, _NARROW_WIDEST = 1.5, 2.1  # upper end of the axis of shares: words beside a full bar
_NARROW = 260  # points, width of axes below which bars and labels are those of one column
_SURVIVAL, _SHARES = "survival", "shares"


@styled()
def draw_ensemble(
    ensemble: Ensemble, title: str, page: Page = TWO_COLUMNS, shown: Sequence[str] = ()
) -> Figure:
    """Return the survival curve of an ensemble, with its law, above the shares of its regimes."""
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
    curve = {_SURVIVAL: "share of the starts that have not settled yet, over time"}
    shares = {_SHARES: "share of the starts that ended in each regime"}
    return {**(curve if ensemble.counted.any() else {}), **shares}


def _draw_survival(axes: Axes, ensemble: Ensemble, page: Page = TWO_COLUMNS) -> None:
    """Draw the share that has not settled yet against time, on a logarithmic scale."""
    estimate, last = ensemble.survival, float(ensemble.times.max())
    time = np.concatenate([[0.0], estimate.times, [last]])
    curves = np.ones((3, time.size))
    curves[:, 1:-1] = estimate.share, estimate.low, estimate.high
    curves[:, -1] = np.nan
    # where the interval is not defined, at shares of 1 and 0, its last values continue
    places = np.where(np.isfinite(curves), np.arange(time.size), 0)
    share, low, high = np.take_along_axis(curves, np.maximum.accumulate(places, axis=1), axis=1)
    shown = np.where(share > 0.0, share, np.nan)  # zero has no place on the scale
    axes.step(time, shown, where="post", color=_CURVE, linewidth=1.1, label="not settled yet")
    axes.fill_between(
        time, low, high, step="post", color=_CURVE, alpha=0.18, linewidth=0,
        label=f"its {ensemble.level:.0%} interval (Kaplan and Meier)",
    )  # fmt: skip
    censored = np.unique(ensemble.times[~ensemble.ended])
    if censored.size:
        at = share[np.searchsorted(time, censored, side="right") - 1]
        look: dict[str, Any] = {"marker": "|", "markersize": 6, "linestyle": "none"}
        label = "no longer watched, not settled"
        axes.plot(censored, at, color=_CURVE, clip_on=False, label=label, **look)
    floor = min(0.5, max(0.5 / ensemble.times.size, float(low.min()) / 3))
    law = ensemble.decay
    if law is not None and law.ended:
        after, begin = np.linspace(law.delay, last, 200), float(np.interp(law.delay, time, share))
        ups = [begin * np.exp(-k * (after - law.delay)) for k in (law.high, law.rate, law.low)]
        mean, least, most = (
            f"{float(f'{x:.3g}'):g}" for x in (law.mean, 1 / law.high, 1 / law.low)
        )
        label = rf"$\exp(-t/\tau)$, $\tau={mean}\,T$ (interval: {least} to {most})"
        axes.fill_between(after, ups[0], ups[2], color=_LAW, alpha=0.22, linewidth=0)
        axes.plot(after, ups[1], color=_LAW, linewidth=1.0, linestyle="--", label=label)
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


def _draw_shares(axes: Axes, ensemble: Ensemble, _page: Page = TWO_COLUMNS) -> None:
    """Draw the share of every final regime as a bar, with its part through chaos."""
    shares = ensemble.shares
    places = np.arange(len(shares))
    for place, entry in zip(places, shares, strict=True):
        axes.barh(place, entry.share, height=0.62, **patch_look(entry.label))
        through = entry.through_chaos / entry.total
        axes.barh(place, through, height=0.16, color=OTHERS["transient chaos"], linewidth=0)
        axes.hlines(place, entry.low, entry.high, color="black", linewidth=0.9)
        text = f"{entry.count}" + (f", {entry.through_chaos} through chaos" * bool(through))
        look: dict[str, Any] = {"textcoords": "offset points", "va": "center"}
        look["fontsize"] = STYLE["xtick.labelsize"]
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


PICTURE = picture()  # what draws the archive of an ensemble
