"""Maps of shares: how many of the starts of a cell ended in a regime."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from matplotlib.transforms import Bbox

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import SHARE
from nlds_vines.bifurcation.picture.map_panel import fill_cells, single_map
from nlds_vines.errors import RequestError
from nlds_vines.model.coexistence import UNKNOWN, by_frequency, finals, share_of
from nlds_vines.plotting.notation import literal
from nlds_vines.plotting.page import TWO_COLUMNS, Page
from nlds_vines.plotting.panels import add_colour_bar
from nlds_vines.plotting.style import CM, SHADES, axis_label

_MOST, _COLUMNS = 6, 2  # small maps of one picture, and of one row
_PANEL, _BETWEEN, _FOOT, _HEAD = 5.2 * CM, 0.75 * CM, 1.15 * CM, 1.5 * CM  # heights in inches
_BAR = 0.8 * CM  # inches, room for the bar of all maps


def draw_shares(view: ArchiveView, show: str, page: Page = TWO_COLUMNS) -> Figure:
    """Return maps of the share of the starts that ended in a regime.

    Arguments: `show` is `share:LABEL` for one map, `shares` for those of the most frequent known
    regimes, side by side; the `page`.

    Raises `RequestError` where no start ended in a known regime.
    """
    labels = view["label"]
    wanted = [show.removeprefix(SHARE)]
    if not show.startswith(SHARE):
        found = [label for label, _ in by_frequency(finals(labels)) if label not in UNKNOWN]
        wanted = found[:_MOST]
    if not wanted:
        raise RequestError(f"{view.path}: no start ended in a known regime, so there is no share")
    text = f"share of {labels.shape[-1]} starts"
    if len(wanted) == 1:
        figure, axes = single_map(view, page)
        mesh, text = _draw_share(axes, view, labels, wanted[0]), f"{text} in {literal(wanted[0])}"
        place = axes.get_position()
    else:
        figure, panels = _small_maps(view, wanted, page)
        meshes = [_draw_share(panels[i], view, labels, name) for i, name in enumerate(wanted)]
        mesh, place = meshes[-1], Bbox.union([axes.get_position() for axes in panels])
    percent = PercentFormatter(1.0, decimals=0)
    add_colour_bar(figure, mesh, place, text, format=percent)
    return figure


def _small_maps(view: ArchiveView, names: list[str], page: Page) -> tuple[Figure, list[Axes]]:
    """Return a figure with a small panel for each name, and the panels in reading order."""
    columns = _COLUMNS if page.beside else 1
    rows = -(-len(names) // columns)
    height = _HEAD + rows * _PANEL + (rows - 1) * _BETWEEN + _FOOT
    figure = Figure(figsize=(page.width, height))
    grid = {"left": page.left / page.width, "right": 1 - (page.right + _BAR) / page.width}
    grid |= {"bottom": _FOOT / height, "wspace": 0.08}
    grid |= {"top": 1 - _HEAD / height, "hspace": _BETWEEN / _PANEL}
    panels = figure.subplots(
        rows, columns, sharex=True, sharey=True, squeeze=False, gridspec_kw=grid
    )
    for axes in panels.flat[len(names) :]:
        axes.set_axis_off()
    for axes, name in zip(panels.flat, names, strict=False):
        axes.set_title(name, fontsize=rcParams["font.size"], pad=3)
    # the lowest panel of each column, which is in the row above where the last row is not full
    for axes in panels.flat[max(0, len(names) - columns) : len(names)]:
        axes.set_xlabel(axis_label(view.axes[0]))
        axes.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel(axis_label(view.axes[1]))
    return figure, list(panels.flat)


def _draw_share(axes: Axes, view: ArchiveView, labels: np.ndarray, label: str) -> QuadMesh:
    """Fill every cell by the share of its starts in one regime, from none to all."""
    return fill_cells(axes, view, share_of(labels, label), cmap=SHADES, norm=Normalize(0, 1))
