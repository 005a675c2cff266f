"""Pictures of a scan over samples: histograms, exceedance, scatter against parameters, regimes.

The panels of a quantity are named `E1max`, `E1max:exceedance` and `E1max:k1`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import (
    EXCEEDANCE,
    REGIMES,
    quantities_in,
    sample_panels,
    usual_sample_panels,
)
from nlds_vines.model.labels import by_frequency, finals
from nlds_vines.model.samples import SAMPLE
from nlds_vines.orbits.spectrum import SIGNALS
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    new_figure,
    styled,
    write_letters,
)
from nlds_vines.plotting.palette import color_of, ink_of, ordered, patch_look, short
from nlds_vines.plotting.style import CM, DOT, HUES, NAVY, axis_label

_HEIGHT = 4.6 * CM  # inches, of a panel
_MOST_BINS = 60
_QUANTILES = (0.5, 0.95)  # marked in histograms
_MOST_REGIMES = 8  # bars; the rarer ones share one


def panels_of(view: ArchiveView) -> dict[str, str]:
    """Return the meaning of each panel by name."""
    return sample_panels(quantities_in(view), _columns(view), "label" in view)


@styled()
def draw(view: ArchiveView, names: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the figure with these panels, three in a row on a wide page."""
    columns = min(len(names), 3 if page.beside else 1)
    figure, grid = new_figure(page, [_HEIGHT] * ceil(len(names) / columns), columns)
    panels = [figure.add_subplot(grid[divmod(i, columns)]) for i in range(len(names))]
    for axes, name in zip(panels, names, strict=True):
        fill(axes, view, name)
    labels = _labels(view)
    has_dots = any(_parts(name)[1] in _columns(view) for name in names)
    if labels is not None and has_dots and REGIMES not in names:  # whose bars name the colors
        handles = [
            Line2D([], [], color=ink_of(word), label=short(word), markersize=3.0, **DOT)
            for word in ordered(labels.tolist())
        ]
        add_legend(panels[0], handles, "above", LETTER_ROOM)
    if len(panels) > 1:
        write_letters(panels)
    finish(figure, grid, view.text("title"))
    return figure


def fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel into axes."""
    if name == REGIMES:
        _draw_regimes(axes, view)
        return
    quantity, other = _parts(name)
    drawn = quantities_in(view)[quantity]
    values = drawn.of(view)[..., 0]  # (samples, starts)
    finite = values[np.isfinite(values)]
    if other in _columns(view):
        labels = _labels(view)
        across = np.repeat(view[other], values.shape[1])
        words = np.full(across.size, "") if labels is None else labels
        for word in ordered(np.unique(words).tolist()) if labels is not None else [""]:
            chosen = words == word
            color = ink_of(word) if word else NAVY
            look = {"color": color, "rasterized": True, "markersize": 1.6, **DOT}
            axes.plot(across[chosen], values.ravel()[chosen], alpha=0.6, **look)
        axes.set_xlabel(_symbol(axis_label(other)))
        axes.set_ylabel(_symbol(drawn.label))
        return
    axes.set_xlabel(_symbol(drawn.label))
    if other == EXCEEDANCE:
        ascending = np.sort(finite)
        share = 1.0 - np.arange(finite.size) / max(1, finite.size)
        axes.step(ascending, share, where="post", color=NAVY, linewidth=1.0)
        axes.set_yscale("log")
        axes.set_ylabel("share of samples above")
        return
    bins = np.histogram_bin_edges(finite, "auto") if finite.size else np.array([0.0, 1.0])
    if bins.size > _MOST_BINS:
        bins = np.linspace(bins[0], bins[-1], _MOST_BINS + 1)
    counts, _ = np.histogram(finite, bins)
    axes.stairs(counts / max(1, finite.size), bins, fill=True, color=NAVY, alpha=0.55)
    for q, style in zip(_QUANTILES, ("-", "--"), strict=True):
        if finite.size:
            value = float(np.quantile(finite, q))
            look = {"color": HUES["vermillion"], "linewidth": 0.9, "linestyle": style}
            axes.axvline(value, label=f"{q:.0%} below {value:.4g}", **look)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_ylabel("share of samples")
    axes.margins(y=0.25)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper right", frameon=True, framealpha=0.85, edgecolor="none")


def _draw_regimes(axes: Axes, view: ArchiveView) -> None:
    labels = _labels(view)
    assert labels is not None
    counts = by_frequency(finals(labels.astype(object)))
    rest = sum(count for _, count in counts[_MOST_REGIMES:])
    rows = counts[:_MOST_REGIMES]
    for place, (word, count) in enumerate(rows):
        axes.barh(place, count / labels.size, height=0.7, **patch_look(word, color_of(word)))
    names = [short(word) for word, _ in rows]
    if rest:
        axes.barh(len(rows), rest / labels.size, height=0.7, color="#999999")
        names.append("others")
    axes.set_yticks(range(len(names)), names)
    for tick, (word, _) in zip(axes.get_yticklabels(), rows, strict=False):
        tick.set_color(ink_of(word))  # as the dots of other panels
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("share of samples")


def _parts(name: str) -> tuple[str, str]:
    """Split `E1max:k1` at its last colon, and `broadband:x1` nowhere; regimes have no parts."""
    quantity, _, other = name.rpartition(":")
    return (quantity, other) if quantity and other not in SIGNALS else (name, "")


def _symbol(label: str) -> str:
    """Return the symbol and the unit of a label that may be too long for a small panel."""
    return label[label.index("$") :] if "$" in label else label


def _columns(view: ArchiveView) -> list[str]:
    return [name for name in view.names if view.dims(name) == (SAMPLE,)]


def _labels(view: ArchiveView) -> np.ndarray | None:
    """Return the final regimes (orbits,), if they are recorded."""
    return finals(view["label"].ravel()).astype(str) if "label" in view else None


PICTURE = Picture(
    panels=panels_of,
    draw=draw,
    fill=fill,
    usual=lambda view: usual_sample_panels(panels_of(view)),
)
"""Draws the archive of a scan over samples."""
