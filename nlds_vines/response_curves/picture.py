"""A page of response curves drawn: largest energies against frequency (Figures 2 to 7)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import ceil, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.archives.view import ArchiveView
from nlds_vines.plotting.bands import bands
from nlds_vines.plotting.notation import setting_label, typeset
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.panels import (
    add_panel,
    letter,
    text_width,
    write_letters,
    write_title,
)
from nlds_vines.plotting.save import save_drawn
from nlds_vines.plotting.style import CM, STYLE, WIDTH, axis_label, quantity_label
from nlds_vines.response_curves.request import Curve, CurvePage, Panel, label_of
from nlds_vines.response_curves.result import CurveValues, curves_of

IMPACTS = "#fff7c2"
"""The colour of frequencies with impacts: light yellow, as in Figure 2b."""

RESONANCE = "#444444"
"""The colour of the structure's own frequency."""

BASE = "#b03a00"
"""The colour of the title of the panel that shows the tuning."""

_DOTTED = (0, (1, 1.6))  # the line of E2max: lengths of dot and gap
_HEIGHTS = {1: 7.2 * CM, 2: 4.9 * CM, 3: 5.4 * CM, 4: 4.2 * CM}  # inches, of a panel, by columns
_LEFT, _RIGHT, _GAP = 1.45 * CM, 0.35 * CM, 0.6 * CM  # inches: left, right, between two columns
_HEAD, _FOOT, _NAME, _LEGEND = 0.65 * CM, 1.05 * CM, 0.5 * CM, 0.42 * CM
"""Heights [inches] of the title, of the labels below, of a panel's title, of a legend's row."""

_REDUCTION, _SEAM = 3.6 * CM, 0.5 * CM
"""Height [inches] of the panel of the reduction, and of the gap above it, where a letter stands."""

_LEAST_REDUCTION = -100.0  # percent: where a damper harms more, it leaves the panel
_HANDLE = 36  # points that the line of a legend's entry and the space around it take
_VISIBLE = 0.008  # of the axis: a narrower window has one line in place of two bounds
_ABOVE = 1.1  # upper end of the axis of energies over the highest curve
_BOUND: dict[str, Any] = {
    "color": "#666666", "linewidth": 0.6, "linestyle": (0, (4, 2)), "zorder": 1,
}  # fmt: skip
_NARROW: dict[str, Any] = {**_BOUND, "linewidth": 0.45, "linestyle": "solid"}


def save(archive_path: str | os.PathLike[str], plot_path: str | os.PathLike[str]) -> Path:
    """Draw the curves in an archive, save the picture and return its path, as `save_drawn`."""
    return save_drawn(archive_path, plot_path, curves_picture)


def curves_picture(view: ArchiveView) -> Figure:
    """Return the picture of an archive of response curves."""
    found = curves_of(view)
    return draw_page(found.request, found.curves)


@styled()
def draw_page(page: CurvePage, found: Sequence[CurveValues]) -> Figure:
    """Return the figure of a page of curves.

    Arguments: the `page`; what was `found` along each of its curves, in their order.

    E1max is drawn as the page says, E2max (where asked for) dotted in the same colour.  A
    vertical line marks the structure's own frequency omega0 = sqrt(k1 / m1).  The frequencies
    at which a shaded curve has impacts are light yellow, its windows without impacts white
    between dashed lines; one that is too narrow for them is a thin line.  Where the page says so,
    the reduction by each damper stands below.
    """
    figure, frames = _make_frames(page)
    by_panel: list[list[tuple[Curve, CurveValues]]] = [[] for _ in page.panels]
    for (place, curve), values in zip(page.places, found, strict=True):
        by_panel[place].append((curve, values))
    for frame, content in zip(frames, by_panel, strict=False):
        _draw_panel(frame, content, page)
    frames[0].set_ylim(0, _ABOVE * max(frame.dataLim.y1 for frame in frames))
    if page.reduction:
        _draw_reduction(frames[1], by_panel[0], page)
        write_letters(frames)
    _label_axes(frames, page)
    if len(page.panels) > 1:
        for index, (frame, panel) in enumerate(zip(frames, page.panels, strict=True)):
            _write_panel_title(frame, panel, index)
    return figure


def _make_frames(request: CurvePage) -> tuple[Figure, list[Axes]]:
    """Return a figure with the panels, which share both axes; title and legend stand above.

    The panel of the reduction, which is the last one, shares the frequency alone.
    """
    columns = min(request.columns, len(request.panels))
    rows = ceil(len(request.panels) / columns)
    below = _REDUCTION + _SEAM if request.reduction else 0.0
    handles = _handles(request)
    per_row = _per_row([str(handle.get_label()) for handle in handles])
    head = _HEAD + ceil(len(handles) / per_row) * _LEGEND + (_SEAM if below else 0.15 * CM)
    row_height = _HEIGHTS[columns] + (_NAME if len(request.panels) > 1 else 0.0)
    figure = Figure(figsize=(WIDTH, head + rows * row_height + below + _FOOT))
    frames: list[Axes] = []
    across = (WIDTH - _LEFT - _RIGHT - (columns - 1) * _GAP) / columns
    for index in range(len(request.panels)):
        row, column = divmod(index, columns)
        left = _LEFT + column * (across + _GAP)
        bottom = _FOOT + below + (rows - 1 - row) * row_height
        shared: dict[str, Any] = {"sharex": frames[0], "sharey": frames[0]} if frames else {}
        frames.append(add_panel(figure, (left, bottom, across, _HEIGHTS[columns]), **shared))
    if request.reduction:
        frames.append(add_panel(figure, (_LEFT, _FOOT, across, _REDUCTION), sharex=frames[0]))
    write_title(figure, request.title, _LEFT / WIDTH)
    _add_legend(figure, handles, per_row)
    return figure, frames


def _add_legend(figure: Figure, handles: Sequence[Any], per_row: int) -> None:
    """Add the legend of all panels below the title, `per_row` entries side by side."""
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(_LEFT / WIDTH, 1 - _HEAD / figure.get_figheight()),
        ncols=per_row,
        borderaxespad=0,
        borderpad=0,
        columnspacing=1.4,
        handlelength=2.2,
        labelspacing=0.35,
    )


def _per_row(labels: Sequence[str]) -> int:
    """Return how many entries of a legend stand side by side; they fill it column by column."""
    size = STYLE["legend.fontsize"]
    widths = np.array([_HANDLE + text_width(label, size) for label in labels])
    for rows in range(1, len(labels)):
        columns = ceil(len(labels) / rows)
        needed = sum(column.max() for column in np.array_split(widths, columns))
        if needed <= 72 * (WIDTH - _LEFT - _RIGHT):
            return columns
    return 1


def _handles(request: CurvePage) -> list[Any]:
    """Return the entries of the legend: the curves of the first panel, then everything else."""
    first = request.panels[0]
    found: list[Any] = [
        Line2D([], [], label=_curve_label(curve), **_look(curve)) for curve in first.curves
    ]
    if request.damper_energy:
        text = r"$E_2^{\,\mathrm{max}}$ of a damper"
        found.append(Line2D([], [], color=RESONANCE, linestyle=_DOTTED, label=text))
    if any(curve.shade for curve in request.curves):
        found.append(Patch(facecolor=IMPACTS, edgecolor="#c9bd78", linewidth=0.4, label="impacts"))
        bound = {**_BOUND, "linestyle": (0, (3, 2))}  # short enough for the legend
        found.append(Line2D([], [], label="bound of a window without", **bound))
    if request.axis == "omega" and any(_own_frequency(curve) for curve in request.curves):
        found.append(Line2D([], [], label=r"$\omega_0=\sqrt{k_1/m_1}$", **_resonance_look(request)))
    return found


def _resonance_look(request: CurvePage) -> dict[str, Any]:
    """Return how a legend shows omega0: as a line, or as the tick of a curve."""
    if all(len(_own_frequencies(panel.curves)) < 2 for panel in request.panels):
        return {"color": RESONANCE, "linewidth": 0.7}
    return {"color": RESONANCE, "linestyle": "none", "marker": "|", "markersize": 7}


def _curve_label(curve: Curve) -> str:
    """Return what the legend calls a curve: its label, what is set, or its system's title."""
    settings = [setting_label(name, value) for name, value in curve.settings.items()]
    return typeset(curve.label) or ", ".join(settings) or typeset(label_of(curve))


def _look(curve: Curve) -> dict[str, Any]:
    """Return how a curve is drawn: the base stronger, and over the others."""
    return {
        "color": curve.colour,
        "linestyle": curve.line,
        "linewidth": 1.5 if curve.base else 1.0,
        "zorder": 3.5 if curve.base else 3.0,
    }


def _draw_panel(
    frame: Axes, content: Sequence[tuple[Curve, CurveValues]], request: CurvePage
) -> None:
    """Draw one panel: shading, then resonances, then the curves, the base last."""
    for curve, found in content:
        if curve.shade:
            _shade(frame, found)
    if request.axis == "omega":
        _mark_resonances(frame, [curve for curve, _ in content])
    for curve, found in content:
        look = _look(curve)
        frame.plot(found.values, found.E1max, **look)
        if request.damper_energy and curve.scan.system.scene.damper:
            frame.plot(found.values, found.E2max, **{**look, "linestyle": _DOTTED})
    _limit(frame, request)


def _draw_reduction(
    frame: Axes, content: Sequence[tuple[Curve, CurveValues]], request: CurvePage
) -> None:
    """Draw the reduction by each damper in percent, from -100 % on; zero is marked."""
    frame.axhline(0, color=RESONANCE, linewidth=0.7, zorder=2)
    for curve, found in content:
        if curve.scan.system.scene.damper:
            frame.plot(found.values, 100 * found.reduction, **_look(curve))
    low, high = frame.get_ylim()
    frame.set_ylim(max(low, _LEAST_REDUCTION), min(high, 105))
    frame.set_ylabel("reduction [%]")
    _limit(frame, request)


def _limit(frame: Axes, request: CurvePage) -> None:
    """Let a panel reach from the first to the last value, and have ticks on all sides."""
    if request.values.size > 1:
        frame.set_xlim(*request.values[[0, -1]])
    frame.tick_params(top=True, right=True)


def _shade(frame: Axes, curve: CurveValues) -> None:
    """Fill where there are impacts; mark every window without any, by its bounds or one line."""
    values, impacts = curve.values, curve.impacts
    found = bands(values, np.where(impacts > 0, "impacts", "none"))
    for band in found:
        if band.label == "impacts":
            frame.axvspan(band.low, band.high, color=IMPACTS, linewidth=0, zorder=0)
        elif band.width >= _VISIBLE * (values[-1] - values[0]):
            for bound in (band.low, band.high):
                frame.axvline(bound, **_BOUND)
        else:
            frame.axvline(band.centre, **_NARROW)


def _mark_resonances(frame: Axes, curves: Sequence[Curve]) -> None:
    """Mark omega0 = sqrt(k1 / m1): by a line, or by a short one for each of several values."""
    places = _own_frequencies(curves)
    if len(places) == 1:
        frame.axvline(next(iter(places)), color=RESONANCE, linewidth=0.7, zorder=2)
        return
    for place, colour in places.items():
        frame.axvline(place, ymin=0.94, color=colour, linewidth=1.2, zorder=2)


def _own_frequencies(curves: Sequence[Curve]) -> dict[float, str]:
    """Return the structures' own frequencies [rad/s] of curves, each with a colour."""
    found = {_own_frequency(curve): curve.colour for curve in curves}
    return {place: colour for place, colour in found.items() if place}


def _own_frequency(curve: Curve) -> float:
    """Return omega0 = sqrt(k1 / m1) of the structure in a curve's system [rad/s]; 0 for none."""
    p = curve.scan.system.parameters
    return sqrt(p["k1"] / p["m1"]) if "k1" in p else 0.0


def _write_panel_title(frame: Axes, panel: Panel, index: int) -> None:
    """Write a panel's letter and title above it; the title of the tuning has a colour."""
    settings = [setting_label(name, value) for name, value in panel.settings.items()]
    title = typeset(panel.title) or ", ".join(settings)
    text = f"{letter(index)}  {title}" + (" (tuning)" if panel.base else "")
    frame.set_title(text, fontsize=8.5, loc="left", pad=3, color=BASE if panel.base else "black")


def _label_axes(frames: Sequence[Axes], request: CurvePage) -> None:
    """Label the outer axes of a figure; in narrow panels by the frequency's symbol alone."""
    columns = min(request.columns, len(request.panels))
    across = axis_label(request.axis)
    if columns > 1:
        across = across.rpartition("force ")[2]
    up = quantity_label("E1max", "J")
    if request.damper_energy:
        up = r"largest energies $E_1^{\,\mathrm{max}}, E_2^{\,\mathrm{max}}$ [J]"
    for index, frame in enumerate(frames):
        if index + columns >= len(frames):
            frame.set_xlabel(across)
        else:
            frame.tick_params(labelbottom=False)
        if index % columns:
            frame.tick_params(labelleft=False)
        elif index < len(request.panels):
            frame.set_ylabel(up)
