"""What draws the archive of a scan: diagrams, maps, basins, and pictures of samples.

Those are histograms, exceedance, scatter against parameters; the panels of a quantity are named
`E1max`, `E1max:exceedance` and `E1max:k1`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture import choices
from nlds_vines.bifurcation.picture.diagram import diagram, draw_into
from nlds_vines.bifurcation.picture.maps import draw_basins, regime_map, why_no_basins
from nlds_vines.errors import RequestError
from nlds_vines.model.axis import SAMPLE
from nlds_vines.model.labels import by_frequency, finals
from nlds_vines.model.quantities import OF_SIGNALS_BY_NAME
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.plotting.chosen_panels import Drawing, Picture
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    into,
    new_figure,
    styled,
    styled_for,
    write_letters,
)
from nlds_vines.plotting.palette import ink_of, ordered, patch_look, short
from nlds_vines.plotting.style import CM, DOT, HUES, NAVY, axis_label

_HEIGHT = 4.6 * CM  # inches, of a panel
_MOST_BINS = 60
_QUANTILES = (0.5, 0.95)  # marked in histograms
_MOST_REGIMES = 8  # bars; the rarer ones share one


def sample_panels_of(view: ArchiveView) -> dict[str, str]:
    return choices.sample_panels(choices.quantities_in(view), _columns(view), "label" in view)


@styled()
def draw_samples(view: ArchiveView, names: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    columns = min(len(names), 3 if page.beside else 1)
    figure, grid = new_figure(page, [_HEIGHT] * ceil(len(names) / columns), columns)
    panels = [figure.add_subplot(grid[divmod(i, columns)]) for i in range(len(names))]
    for axes, name in zip(panels, names, strict=True):
        fill_sample_panel(axes, view, name)
    labels, has_dots = _labels(view), any(_parts(name)[1] in _columns(view) for name in names)
    if labels is not None and has_dots and choices.REGIMES not in names:  # bars name the colors
        handles = [
            Line2D([], [], color=ink_of(word), label=short(word), markersize=3.0, **DOT)
            for word in ordered(labels.tolist())
        ]
        add_legend(panels[0], handles, "above", LETTER_ROOM)
    write_letters(panels)
    finish(figure, grid, view.text("title"))
    return figure


def fill_sample_panel(axes: Axes, view: ArchiveView, name: str) -> None:
    labels = _labels(view)
    if name == choices.REGIMES and labels is not None:
        ends = by_frequency(finals(labels.astype(object)))
        shown, rest = ends[:_MOST_REGIMES], sum(count for _, count in ends[_MOST_REGIMES:])
        for place, (word, count) in enumerate(shown):
            axes.barh(place, count / labels.size, height=0.7, **patch_look(word))
        if rest:
            axes.barh(len(shown), rest / labels.size, height=0.7, color="#999999")
        names = [short(word) for word, _ in shown] + ["others"] * bool(rest)
        axes.set_yticks(range(len(names)), names)
        for tick, (word, _) in zip(axes.get_yticklabels(), shown, strict=False):
            tick.set_color(ink_of(word))  # as the dots of other panels
        axes.set_ylim(len(names) - 0.4, -0.6)
        axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        axes.set_xlabel("share of samples")
        return
    quantity, other = _parts(name)
    drawn = choices.quantities_in(view)[quantity]
    values = drawn.of(view)[..., 0]  # (samples, starts)
    finite = values[np.isfinite(values)]
    if other in _columns(view):
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
    if other == choices.EXCEEDANCE:
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


def _parts(name: str) -> tuple[str, str]:
    """Split `E1max:k1` at its last colon, and `broadband:x1` nowhere; regimes have no parts."""
    quantity, _, other = name.rpartition(":")
    return (quantity, other) if quantity and quantity not in OF_SIGNALS_BY_NAME else (name, "")


def _symbol(label: str) -> str:
    """Return the symbol and the unit of a label that may be too long for a small panel."""
    return label[label.index("$") :] if "$" in label else label


def _columns(view: ArchiveView) -> list[str]:
    return [name for name in view.names if view.dims(name) == (SAMPLE,)]


def _labels(view: ArchiveView) -> np.ndarray | None:
    return finals(view["label"].ravel()).astype(str) if "label" in view else None


SAMPLES = Picture(
    panels=sample_panels_of,
    draw=draw_samples,
    fill=fill_sample_panel,
    usual=lambda view: choices.usual_sample_panels(sample_panels_of(view)),
)
"""Draws the archive of a scan over samples."""


@dataclass(frozen=True)
class ScanPicture(Drawing):
    """Draws scans; `manifold` draws bounds of 1:1 motion in closed form over maps of omega."""

    manifold: bool = False

    def names(self, view: ArchiveView) -> Mapping[str, str]:
        """Return the recorded numbers, and the codes of maps, with their units."""
        if SAMPLE in view.axes:
            return SAMPLES.names(view)
        maps = choices.is_map([view[name] for name in view.axes])
        shown = {n: one for n, one in choices.quantities_in(view).items() if maps or not one.coded}
        units = {n: f" [{one.units}]" if one.units != "1" else "" for n, one in shown.items()}
        return {name: f"{one.long_name}{units[name]}" for name, one in shown.items()}

    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        if SAMPLE in view.axes:
            return SAMPLES.figure(view, show, page, ax)
        for name in view.axes:
            refuse_undrawable(name, view[name])
        values = [view[name] for name in view.axes]
        labeled, recorded = "label" in view, choices.quantities_in(view)
        if show is not None:
            choices.check_show(show, values, view["start"].size, recorded, labeled)
        plain = len(values) == 1 or choices.is_map(values)
        without = why_no_basins(view)
        if show == choices.BASINS and without:
            raise RequestError(f"{view.path}: show = {show!r}: {without}")
        if show == choices.BASINS or (show is None and plain and not without):
            with styled_for(ax):
                return draw_basins(view, page, ax)
        if not choices.is_map(values):
            if self.manifold:
                raise RequestError(
                    f"{view.path}: the manifold is drawn over maps; "
                    "curves: response-curves --manifold"
                )
            if ax is None:
                return diagram(view, show, page)
            return into(ax, lambda: draw_into(ax, view, show))
        chosen = choices.usual_show(recorded, labeled) if show is None else show
        if chosen is None:
            raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
        with styled_for(ax):
            return regime_map(view, chosen, page, self.manifold, ax)


PICTURE = ScanPicture()  # what draws the archive of a scan
