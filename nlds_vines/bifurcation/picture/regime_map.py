"""Maps: what two parameters do to the orbits."""

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
from nlds_vines.bifurcation.picture.choices import (
    COEXISTING,
    REGIMES,
    SHARE,
    SHARES,
    check_show,
    usual_show,
)
from nlds_vines.bifurcation.picture.number_map import (
    draw_number,
    draw_shares,
    fill,
    frame,
    mark,
    one_frame,
)
from nlds_vines.errors import RequestError
from nlds_vines.orbits.coexistence import by_frequency, coexisting, final, most_frequent
from nlds_vines.orbits.labels import KEPT
from nlds_vines.plotting.palette import (
    HATCHED,
    OTHERS,
    RAMP,
    TRANSIENT,
    colours,
    ordered,
    period_and_impacts,
)
from nlds_vines.plotting.style import CM, FLAGGED, LEFT, STYLE, WIDTH, axis_label

_PANEL, _GAP, _FOOT, _HEAD = 7.9 * CM, 0.35 * CM, 1.15 * CM, 0.95 * CM  # heights in inches
_LINE = 0.42 * CM  # height of a name in a legend
_LONG = f"{len(RAMP)}T and longer"  # which share a colour
_EXAMPLE = f"{len(RAMP)}T,1"  # one of these
_COUNTS = ("#f1efe9", "#f6c667", "#e07b39", "#a8324a", "#5b1a4a")
"""Colours of one regime in a cell, two, three ..., and of as many as there are colours or more."""


@matplotlib.rc_context(STYLE)
def regime_map(view: ArchiveView, show: str | None = None) -> Figure:
    """Return the map of a scan of two parameters; the first runs to the right, the second up.

    Arguments: the archive; what to `show`, by default `regimes` or, where none are recorded, the
    first number there is, by preference the structure's energy:

    - `regimes`: a colour for each regime; of several starts, the regime that most ended in, and in
      a second panel how many regimes coexist;
    - `coexisting`: that panel alone;
    - `share:LABEL`: the share of the starts that ended in a regime; `shares`: those of the most
      frequent regimes, side by side;
    - a recorded number: of several starts the largest; see `shows.NUMBERS`.

    Raises `RequestError` for a scan of one parameter, and where nothing of the kind is recorded.
    """
    if len(view.axes) != 2:
        raise RequestError(f"{view.path} varies one parameter: draw it as a diagram")
    show = usual_show(view.names) if show is None else show
    if show is None:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    check_show(show, 2, view["start"].size, view.names)
    if show == SHARES or show.startswith(SHARE):
        figure = draw_shares(view, show)
    elif show in (REGIMES, COEXISTING):
        figure = _classes(view, show)
    else:
        figure = draw_number(view, show)
    top = 1 - 0.15 * CM / figure.get_figheight()
    figure.text(LEFT, top, _title(view), va="top")
    return figure


def _title(view: ArchiveView) -> str:
    starts = view["start"]
    return (
        f"{view.attrs['title']}; {starts.size} starts" if starts.size > 1 else view.attrs["title"]
    )


def _classes(view: ArchiveView, show: str) -> Figure:
    """Draw regimes, how many coexist, or both above one another."""
    labels = view["label"]
    if show == COEXISTING or labels.shape[-1] == 1:
        figure, axes = one_frame(view)
        if show == COEXISTING:
            _draw_counts(axes, view, labels)
        else:
            _draw_regimes(axes, view, labels[..., 0], "regime")
        return figure
    figure, panels = _two_frames(view)
    _draw_regimes(panels[0], view, most_frequent(labels), "most frequent regime")
    _draw_counts(panels[1], view, labels)
    return figure


def _two_frames(view: ArchiveView) -> tuple[Figure, list[Axes]]:
    """Return a figure with two panels above one another, lettered, that share their axes."""
    height = _HEAD + 2 * _PANEL + _GAP + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    bottoms = (_FOOT + _PANEL + _GAP, _FOOT)
    panels = [frame(figure, bottom / height, _PANEL / height) for bottom in bottoms]
    panels[0].sharex(panels[1])
    panels[0].tick_params(labelbottom=False)
    panels[1].set_xlabel(axis_label(view.axes[0]))
    paper: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
    for letter, axes in zip("ab", panels, strict=True):
        axes.set_ylabel(axis_label(view.axes[1]))
        place: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
        axes.annotate(f"({letter})", (0, 1), (5, -5), va="top", bbox=paper, **place)
    return figure, panels


def _named(label: str) -> str:
    """Return the name under which a label is drawn: those of the same colour share one."""
    end = final(label)
    found = period_and_impacts(end)
    return label.replace(end, _LONG) if found and found[0] >= len(RAMP) else label


def _colours(words: Sequence[str]) -> dict[str, str]:
    """Return the colour of every name on a map."""
    found = colours(word.replace(_LONG, _EXAMPLE) for word in words)
    return {word: found[word.replace(_LONG, _EXAMPLE)] for word in words}


def _draw_regimes(axes: Axes, view: ArchiveView, labels: np.ndarray, title: str) -> None:
    """Fill every cell with the colour of its regime; the legend names the most frequent ones.

    A dot marks a cell where the label of a start changes under refinement.
    """
    names = np.vectorize(_named, otypes=[object])(labels)
    found = by_frequency(names)
    words = [word for word, _ in found]
    colour = _colours(words)
    _fill_classes(axes, view, names, words, [colour[word] for word in words])
    flags = _mark_flagged(axes, view)
    room = int(axes.bbox.height / axes.figure.dpi / _LINE) - 1 - 2 * len(flags)
    told = _in_order(words if len(words) <= room else words[: room - 1])
    handles = [
        Patch(facecolor=colour[word], label=word.replace(TRANSIENT, "chaos → ")) for word in told
    ]
    if len(words) > len(told):
        handles.append(Patch(color="none", label=f"and {len(words) - len(told)} more"))
    _legend(axes, [*handles, *flags], title)


def _mark_flagged(axes: Axes, view: ArchiveView) -> list[Line2D]:
    """Mark cells with a start whose label is not kept; return what the legend says, if any is."""
    if "label_kept" not in view:
        return []
    flagged = (view["label_kept"] == KEPT["no"]).any(axis=-1)
    if not flagged.any():
        return []
    return [mark(axes, view, flagged, FLAGGED.replace(" under", "\nunder"))]


def _in_order(words: Sequence[str]) -> list[str]:
    """Return names in the order of a legend: by period, then what is not periodic."""
    found = ordered(word.replace(_LONG, _EXAMPLE) for word in words)
    return [word.replace(_EXAMPLE, _LONG) for word in found]


def _fill_classes(
    axes: Axes, view: ArchiveView, names: np.ndarray, words: Sequence[object], shades: Sequence[str]
) -> None:
    """Fill every cell with the shade of its class, one of `words`."""
    number = {word: i for i, word in enumerate(words)}
    classes = np.vectorize(number.__getitem__, otypes=[np.int64])(names)
    norm = BoundaryNorm(np.arange(len(words) + 1) - 0.5, len(words))
    fill(axes, view, classes, cmap=ListedColormap(list(shades)), norm=norm)


def _draw_counts(axes: Axes, view: ArchiveView, labels: np.ndarray) -> None:
    """Fill every cell with the colour of how many regimes coexist there, of those found."""
    most = len(_COUNTS)
    counts = np.minimum(coexisting(labels), most)
    words = sorted(set(counts.ravel().tolist()))
    shades = {0: OTHERS[HATCHED], **dict(enumerate(_COUNTS, start=1))}
    _fill_classes(axes, view, counts, words, [shades[word] for word in words])
    names = {0: "none known", most: f"{most} or more"}
    handles = [Patch(facecolor=shades[n], label=names.get(n, str(n))) for n in words]
    for handle in handles:
        handle.set_edgecolor("#8a8a8a")
        handle.set_linewidth(0.4)
    _legend(axes, handles, f"regimes found\nby {labels.shape[-1]} starts")


def _legend(axes: Axes, handles: Sequence[Artist], title: str) -> None:
    axes.legend(
        handles=handles,
        title=title,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0,
        frameon=False,
        handlelength=1.2,
        labelspacing=0.35,
        alignment="left",
    )
