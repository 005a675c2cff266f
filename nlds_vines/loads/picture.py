"""The picture of a decay: the structure's energy over time, and where the energy went."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.loads.fall import SHARES, WAYS
from nlds_vines.loads.result import Decays, decays_in, shares_of
from nlds_vines.model.words import system_in_words
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled
from nlds_vines.plotting.style import CM, GREY, HUES, NO_VALUE

_HEIGHT = {"energy": 7.0 * CM, "shares": 4.2 * CM}  # inches
_LINES = ("solid", "dashed", "dashdot", "dotted")
_COLOURS = [HUES[name] for name in ("black", "vermillion", "blue", "green", "orange", "pink")]
_WAYS = dict(zip(WAYS, ("blue", "sky", "vermillion"), strict=True))
_LEAST = 1e-4  # of the largest E1: the lower end of the axis


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return what the panels show, by name."""
    return {
        "energy": "energy of the structure over time",
        "shares": "where the energy went",
    }


@styled()
def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the figure of an archive with the panels that are `shown`."""
    heights = [_HEIGHT[name] for name in shown]
    figure = Figure(figsize=(page.width, sum(heights) + 1.0 * CM), layout="constrained")
    found = decays_in(view.path)
    grid = figure.subplots(len(shown), 1, squeeze=False, height_ratios=heights)
    for name, axes in zip(shown, grid[:, 0], strict=True):
        _FILL[name](axes, found)
    figure.suptitle(typeset(found.request.title), x=0.01, ha="left")
    return figure


def _energy(axes: Axes, found: Decays) -> None:
    """Draw E1 relative to the largest of each damper, on a logarithmic axis."""
    for i, (system, fall) in enumerate(
        zip(found.request.systems, found.falls.values(), strict=True)
    ):
        look = {"color": _COLOURS[i % len(_COLOURS)], "linestyle": _LINES[i % len(_LINES)]}
        label = typeset(system_in_words(system))
        axes.semilogy(fall.time, fall.E1 / fall.E1.max(), label=label, linewidth=1.0, **look)
    for share in SHARES:
        axes.axhline(share, color=GREY, linewidth=0.6, zorder=0)
    axes.set(
        xlim=(0, found.request.duration), ylim=(_LEAST, 1.5), xlabel="time $t$ after the blow [s]",
        ylabel="$E_1$ of the structure by its largest",
    )  # fmt: skip
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g}%")
    axes.legend(loc="upper right")


def _shares(axes: Axes, found: Decays) -> None:
    """Draw a bar for each damper: the shares of the energy by what has dissipated them."""
    names = [typeset(system_in_words(system)) for system in found.request.systems]
    shares = [shares_of(fall) for fall in found.falls.values()]
    left = [0.0] * len(names)
    for way in WAYS:
        widths = [max(0.0, one.get(way, 0.0)) for one in shares]
        if any(width > 0.0005 for width in widths):
            words = {"c1": "dashpot $c_1$", "c2": "dashpot $c_2$", "contact": "contacts"}[way]
            axes.barh(names, widths, left=left, color=HUES[_WAYS[way]], label=words)
            left = [a + b for a, b in zip(left, widths, strict=True)]
    still = [max(0.0, 1.0 - done) for done in left]
    if any(share > 0.0005 for share in still):
        axes.barh(names, still, left=left, color=NO_VALUE, label="still there")
    axes.invert_yaxis()
    axes.set(xlim=(0, 1), xlabel="share of the energy that the blow brought in")
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)


_FILL: Mapping[str, Callable[[Axes, Decays], None]] = {"energy": _energy, "shares": _shares}

PICTURE = Picture(
    panels=panels,
    draw=draw,
    fill=lambda axes, view, name: _FILL[name](axes, decays_in(view.path)),
)
