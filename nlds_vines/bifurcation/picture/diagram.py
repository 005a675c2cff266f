"""The bifurcation diagram: what one parameter does to the orbits (Figure 8)."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.regime_strip import FLAG_WIDTH, draw_strip, mark_flagged
from nlds_vines.bifurcation.watched import in_legend
from nlds_vines.errors import RequestError
from nlds_vines.orbits.coexistence import CHAOS
from nlds_vines.orbits.labels import KEPT
from nlds_vines.plotting.bands import bands, drawable, edges
from nlds_vines.plotting.palette import OTHERS, colours
from nlds_vines.plotting.panels import write_letters, write_title
from nlds_vines.plotting.style import (
    CM,
    DOT,
    ERRORS,
    FLAG_COLOUR,
    FLAGGED,
    GREEN,
    GREY,
    LEFT,
    RIGHT,
    ROUND_OFF,
    STYLE,
    WIDTH,
    axis_label,
    quantity_label,
    start_colours,
)

EXPONENT = "lyapunov"
"""The dataset that is drawn with its interval, below everything else."""

CURVES = ("E1max", "E2max", "impact_rate", "clearance", "period", "error")
"""The recorded numbers that are drawn, from the top, where no section is recorded."""

_PANEL, _FOOT, _HEAD = 4.4 * CM, 1.1 * CM, 0.75 * CM  # heights in inches
_NAMES, _STRIP = 2.45 * CM, 0.42 * CM  # inches; a strip stands at the foot of the room for names
_MOST_STRIPS = 2  # starts with a strip of their own; of more, only the first has one
_MOST_NAMED = 8  # starts in the legend
_SECTION_DOT, _NUMBER_DOT, _EXPONENT_DOT, _LEGEND_DOT = 0.75, 2.0, 1.4, 3.0  # points


@matplotlib.rc_context(STYLE)
def diagram(view: ArchiveView) -> Figure:
    """Return the diagram of a scan along one parameter.

    With a recorded section: the stroboscopic coordinates of damper and structure as unconnected
    dots, the structure's maximum energy in green over the first.  Without one: the numbers that
    are recorded.  Below them the largest Lyapunov exponent with its interval, where it is recorded.
    Above the panels a strip names the regimes: one strip for each of two starts, of more starts
    only for the first.  Marks at its foot are labels that change under refinement.

    Raises `RequestError` where nothing is recorded to draw.
    """
    rows, strips = _rows(view), _strips(view)
    head = _HEAD + strips * _NAMES + max(0, strips - 1) * _STRIP
    figure, panels = _make_panels(len(rows), head)
    for panel, row in zip(panels, rows, strict=True):
        if row == EXPONENT:
            _draw_exponent(panel, view)
        else:
            _draw_dots(panel, view, row)
    if "section" in view and "E1max" in view:
        _overlay_energy(panels[0], view)
    panels[0].set_xlim(*edges(view[view.axes[0]])[[0, -1]])
    panels[-1].set_xlabel(axis_label(view.axes[0]))
    if strips:
        _draw_strips(figure, panels[0], view, strips)
    flagged = bool(_flagged(view)[:, :strips].any())
    _add_legend(panels[-1], list(view["start"]), flagged, _watched(view) if strips else [])
    write_title(figure, view.text("title"))
    return figure


def _rows(view: ArchiveView) -> list[str]:
    """Return what the panels show, from the top: displacements of a section, or plain numbers."""
    below = [EXPONENT] if EXPONENT in view else []
    if "section" in view:
        return [name for name in ("x2", "x1", "x") if name in view["component"]] + below
    if rows := [name for name in CURVES if name in view] + below:
        return rows
    raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")


def _make_panels(count: int, head: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels above one another, and `head` inches of room above them."""
    height = head + count * _PANEL + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    grid = {"left": LEFT, "right": RIGHT, "bottom": _FOOT / height, "top": 1 - head / height}
    axes = figure.subplots(count, sharex=True, squeeze=False, gridspec_kw={**grid, "hspace": 0.07})
    panels = list(axes[:, 0])
    for panel in panels:
        panel.tick_params(top=True)
    write_letters(panels)
    return figure, panels


def _draw_dots(panel: Axes, view: ArchiveView, row: str) -> None:
    """Draw one row against the parameter as unconnected dots, every start in its colour."""
    values, section = view[view.axes[0]], "section" in view
    for start, colour in enumerate(start_colours(list(view["start"]))):
        if section:
            component = list(view["component"]).index(row)
            found, unit = view.take("section", start=start, component=component), "m"
        else:
            found, unit = view.take(row, start=start)[:, np.newaxis], view.units(row)
        across = np.repeat(values, found.shape[1])
        shown = drawable(found).ravel()
        if row in ERRORS:
            shown = np.maximum(shown, ROUND_OFF)
            panel.set_yscale("log")
        size = _SECTION_DOT if section else _NUMBER_DOT
        panel.plot(across, shown, color=colour, rasterized=True, markersize=size, **DOT)
    panel.set_ylabel(quantity_label(row, unit))


def _draw_exponent(panel: Axes, view: ArchiveView) -> None:
    """Draw the exponents against the parameter, every start in its colour, over a line at zero.

    Each is a dot with its 99 % interval as a bar; the interval of a periodic orbit has no width.
    """
    values = view[view.axes[0]]
    panel.axhline(0.0, color=GREY, linewidth=0.6, zorder=0.5)
    for start, colour in enumerate(start_colours(list(view["start"]))):
        found = drawable(view.take(EXPONENT, start=start))
        width = drawable(view.take(f"{EXPONENT}_width", start=start))
        known = np.isfinite(found) & np.isfinite(width)
        low, high = (found - width)[known], (found + width)[known]
        bar: dict[str, Any] = {"alpha": 0.35, "linewidth": 1.0, "rasterized": True}
        panel.vlines(values[known], low, high, color=colour, **bar)
        dot = {"markersize": _EXPONENT_DOT, "rasterized": True, **DOT}
        panel.plot(values[known], found[known], color=colour, **dot)
    panel.set_ylabel(quantity_label(EXPONENT, view.units(EXPONENT)))


def _overlay_energy(panel: Axes, view: ArchiveView) -> None:
    """Draw the structure's maximum energy over a panel, on an axis of its own."""
    axes = panel.twinx()
    for start in range(view["start"].size):
        energy = drawable(view.take("E1max", start=start))
        axes.plot(view[view.axes[0]], energy, color=GREEN, linewidth=0.9)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(quantity_label("E1max", view.units("E1max")), color=GREEN)
    axes.tick_params(axis="y", colors=GREEN)
    axes.spines["right"].set_color(GREEN)


def _strips(view: ArchiveView) -> int:
    """Return how many strips of regimes there are: for as many starts, the first ones."""
    if "label" not in view:
        return 0
    return view["start"].size if view["start"].size <= _MOST_STRIPS else 1


def _draw_strips(figure: Figure, panel: Axes, view: ArchiveView, count: int) -> None:
    """Draw the strips of the first starts, the first on top; one colour is one regime in all."""
    labels, flagged = view["label"][:, :count], _flagged(view)
    colour = colours(labels.ravel().tolist())
    for start in range(count):
        axes = _strip_axes(figure, panel, count - 1 - start)
        draw_strip(axes, bands(view[view.axes[0]], labels[:, start]), colour)
        if flagged[:, start].any():
            mark_flagged(axes, view[view.axes[0]], flagged[:, start])
        if count > 1:
            axes.set_ylabel(view["start"][start], rotation=0, ha="right", va="center")


def _strip_axes(figure: Figure, panel: Axes, place: int) -> Axes:
    """Return the axes of a strip above the panels, the lowest of them with `place` 0."""
    height = figure.get_figheight()
    bottom = panel.get_position().y1 + (0.1 * CM + place * (_NAMES + _STRIP)) / height
    return figure.add_axes((LEFT, bottom, RIGHT - LEFT, _STRIP / height), sharex=panel)


def _flagged(view: ArchiveView) -> np.ndarray:
    """Return of which orbits (cells, starts) the label is not kept under refinement."""
    if "label_kept" not in view:
        return np.zeros(view.shape("status"), dtype=bool)
    return np.asarray(view["label_kept"] == KEPT["no"])


def _watched(view: ArchiveView) -> list[Patch]:
    """Return the entry of a legend that says for how long chaos was watched, if there is any."""
    if not np.any(view["label"] == CHAOS):
        return []
    return [Patch(facecolor=OTHERS[CHAOS], label=in_legend(CHAOS, view))]


def _add_legend(panel: Axes, starts: list[str], flagged: bool, others: list[Patch]) -> None:
    """Add a legend of starts not at rest, of the flags if there are any, and of `others`."""
    dot: dict[str, Any] = {"marker": "o", "markersize": _LEGEND_DOT, "linestyle": "none"}
    handles = [
        Line2D([], [], color=colour, label=f"start: {name}", **dot)
        for name, colour in zip(starts, start_colours(starts), strict=True)
        if starts != ["rest"]
    ][:_MOST_NAMED]
    if flagged:
        tick: dict[str, Any] = {"marker": "|", "linestyle": "none", "markeredgewidth": FLAG_WIDTH}
        handles.append(Line2D([], [], color=FLAG_COLOUR, label=FLAGGED, **tick))
    if handles or others:
        pad = {"handletextpad": 0.0} if handles else {"handlelength": 1.0}
        panel.legend(handles=[*handles, *others], loc="upper right", ncols=4, **pad)
