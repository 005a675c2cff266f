"""Maps of regimes over two parameters: a colour for each regime, and how many coexist."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import COEXISTING, REGIMES, SHARE, SHARES
from nlds_vines.bifurcation.picture.map_cells import (
    fill_cells,
    map_panel,
    mark_cells,
    single_map,
)
from nlds_vines.bifurcation.picture.number_map import draw_number
from nlds_vines.bifurcation.picture.share_map import draw_shares
from nlds_vines.bifurcation.watched import in_legend
from nlds_vines.orbits.coexistence import by_frequency, coexisting, final, most_frequent
from nlds_vines.orbits.labels import KEPT
from nlds_vines.plotting.palette import (
    HATCHED,
    OTHERS,
    RAMP,
    colours,
    ordered,
    period_and_impacts,
    short,
)
from nlds_vines.plotting.panels import write_letters, write_title
from nlds_vines.plotting.style import CM, FLAGGED, GREY, STYLE, WIDTH, axis_label

_PANEL, _GAP, _FOOT, _HEAD = 7.9 * CM, 0.35 * CM, 1.15 * CM, 0.95 * CM  # heights in inches
_LINE = 0.42 * CM  # inches, height of a name in a legend
_LONG = f"{len(RAMP)}T and longer"  # the name of the regimes that share the ramp's last colour
_EXAMPLE = f"{len(RAMP)}T,1"  # one of these regimes
_COUNTS = ("#f1efe9", "#f6c667", "#e07b39", "#a8324a", "#5b1a4a")
"""Colours of one regime in a cell, two, three ..., and of as many as there are colours or more."""


@matplotlib.rc_context(STYLE)
def regime_map(view: ArchiveView, show: str) -> Figure:
    """Return the map of a scan of two parameters; the first runs to the right, the second up.

    Arguments: the archive; what to `show`, as checked by `choices.check_show`:

    - `regimes`: a colour for each regime; of several starts, the regime that most ended in, and in
      a second panel how many regimes coexist;
    - `coexisting`: that panel alone;
    - `share:LABEL`: the share of the starts that ended in a regime; `shares`: those of the most
      frequent regimes, side by side;
    - a recorded number, one of `choices.NUMBERS`: of several starts the largest.
    """
    if show == SHARES or show.startswith(SHARE):
        figure = draw_shares(view, show)
    elif show == REGIMES and view["start"].size > 1:
        figure = _draw_both(view)
    elif show in (REGIMES, COEXISTING):
        figure, axes = single_map(view)
        if show == COEXISTING:
            _draw_counts(axes, view, view["label"])
        else:
            _draw_regimes(axes, view, view["label"][..., 0], "regime")
    else:
        figure = draw_number(view, show)
    starts = view["start"].size
    write_title(figure, view.text("title") + (f"; {starts} starts" if starts > 1 else ""))
    return figure


def _draw_both(view: ArchiveView) -> Figure:
    """Return a figure with the most frequent regimes above how many coexist."""
    height = _HEAD + 2 * _PANEL + _GAP + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    bottoms = (_FOOT + _PANEL + _GAP, _FOOT)
    upper, lower = (map_panel(figure, bottom / height, _PANEL / height) for bottom in bottoms)
    upper.sharex(lower)
    upper.tick_params(labelbottom=False)
    lower.set_xlabel(axis_label(view.axes[0]))
    for axes in (upper, lower):
        axes.set_ylabel(axis_label(view.axes[1]))
    write_letters((upper, lower))
    labels = view["label"]
    _draw_regimes(upper, view, most_frequent(labels), "most frequent regime")
    _draw_counts(lower, view, labels)
    return figure


def _draw_regimes(axes: Axes, view: ArchiveView, labels: np.ndarray, title: str) -> None:
    """Fill every cell with the colour of its regime; the legend names the most frequent ones.

    A dot marks a cell where the label of a start changes under refinement.
    """
    names = np.vectorize(_name, otypes=[object])(labels)
    words = [word for word, _ in by_frequency(names)]
    colour = _colours(words)
    _fill_classes(axes, view, names, words, [colour[word] for word in words])
    flags = _mark_flagged(axes, view)
    room = int(axes.bbox.height / axes.figure.dpi / _LINE) - 1 - 2 * len(flags)  # names that fit
    named = _ordered(words if len(words) <= room else words[: room - 1])
    handles = [Patch(facecolor=colour[word], label=in_legend(short(word), view)) for word in named]
    if len(words) > len(named):
        handles.append(Patch(color="none", label=f"and {len(words) - len(named)} more"))
    _add_legend(axes, [*handles, *flags], title)


def _mark_flagged(axes: Axes, view: ArchiveView) -> list[Line2D]:
    """Mark cells with a start whose label is not kept; return the entries of the legend."""
    if "label_kept" not in view:
        return []
    flagged = (view["label_kept"] == KEPT["no"]).any(axis=-1)
    if not flagged.any():
        return []
    return [mark_cells(axes, view, flagged, FLAGGED.replace(" under", "\nunder"))]


def _draw_counts(axes: Axes, view: ArchiveView, labels: np.ndarray) -> None:
    """Fill every cell with the colour of how many of the found regimes coexist there."""
    most = len(_COUNTS)
    counts = np.minimum(coexisting(labels), most)
    words = sorted(set(counts.ravel().tolist()))
    shades = {0: OTHERS[HATCHED], **dict(enumerate(_COUNTS, start=1))}
    _fill_classes(axes, view, counts, words, [shades[word] for word in words])
    names = {0: "none known", most: f"{most} or more"}
    frame: dict[str, Any] = {
        "edgecolor": GREY,
        "linewidth": 0.4,
    }  # the first colour is nearly white
    handles = [Patch(facecolor=shades[n], label=names.get(n, str(n)), **frame) for n in words]
    _add_legend(axes, handles, f"regimes found\nby {labels.shape[-1]} starts")


def _fill_classes(
    axes: Axes, view: ArchiveView, names: np.ndarray, words: Sequence[object], shades: Sequence[str]
) -> None:
    """Fill every cell with the shade of its class, one of `words`."""
    number = {word: i for i, word in enumerate(words)}
    classes = np.vectorize(number.__getitem__, otypes=[np.int64])(names)
    norm = BoundaryNorm(np.arange(len(words) + 1) - 0.5, len(words))
    fill_cells(axes, view, classes, cmap=ListedColormap(list(shades)), norm=norm)


def _name(label: str) -> str:
    """Return the name under which a label is drawn: labels of the same colour share one."""
    end = final(label)
    found = period_and_impacts(end)
    return label.replace(end, _LONG) if found and found[0] >= len(RAMP) else label


def _colours(words: Sequence[str]) -> dict[str, str]:
    """Return the colour of every name on a map."""
    found = colours(word.replace(_LONG, _EXAMPLE) for word in words)
    return {word: found[word.replace(_LONG, _EXAMPLE)] for word in words}


def _ordered(words: Sequence[str]) -> list[str]:
    """Return names in the order of a legend: by period, then those that are not periodic."""
    found = ordered(word.replace(_LONG, _EXAMPLE) for word in words)
    return [word.replace(_EXAMPLE, _LONG) for word in found]


def _add_legend(axes: Axes, handles: Sequence[Artist], title: str) -> None:
    """Add a legend to the right of a map."""
    axes.legend(
        handles=handles,
        title=title,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0,
        handlelength=1.2,
        labelspacing=0.35,
        alignment="left",
    )
