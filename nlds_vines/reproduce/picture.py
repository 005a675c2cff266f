"""Pages of curves: largest energies against frequency, one archive a curve (Figures 2 to 7)."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from hashlib import sha256
from math import ceil, sqrt
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.textpath import TextPath

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.errors import RequestError
from nlds_vines.plotting.bands import bands
from nlds_vines.plotting.save import check_format, save_figure
from nlds_vines.plotting.style import CM, STYLE, WIDTH, axis_label, quantity_label, setting_label
from nlds_vines.reproduce.request import Curve, FigureRequest, Panel

IMPACTS = "#fff7c2"
"""Light yellow, as in Figure 2b: where there are impacts."""

RESONANCE = "#444444"
"""The line of the structure's own frequency."""

BASE = "#b03a00"
"""The title of the panel of the tuning."""

_DOTS = (0, (1, 1.6))  # E2max
_SHARES = {1: 7.2 * CM, 2: 4.9 * CM, 3: 5.4 * CM, 4: 4.2 * CM}  # panel height by columns, inches
_SIDE, _EDGE, _GAP = 1.45 * CM, 0.35 * CM, 0.6 * CM  # inches
_HEAD, _FOOT, _ROW, _LEGEND = 0.65 * CM, 1.05 * CM, 0.5 * CM, 0.42 * CM
_HANDLE = 36  # points that the line of an entry takes, and the space around it
_VISIBLE = 0.008  # of the axis: a narrower window gets no dashed bounds, which would hide it
_ABOVE = 1.1  # room above the highest curve
_BOUND: dict[str, Any] = {"color": "#666666", "lw": 0.6, "ls": (0, (4, 2)), "zorder": 1}


@matplotlib.rc_context(STYLE)
def draw_page(request: FigureRequest, archive_of: Callable[[Curve], Path]) -> Figure:
    """Return the page of a request of curves, drawn from the archives that `archive_of` names.

    E1max is drawn as the request says, E2max (where asked for) dotted in the same colour; a
    vertical line marks the structure's own frequency omega0 = sqrt(k1 / m1).  The frequencies
    at which a shaded curve has impacts are light yellow, its windows without impacts white
    between dashed lines.

    Raises `RequestError` for a request of another kind and for archives without the energies.
    """
    if request.kind != "curves":
        raise RequestError(
            f"{request.path}: a request of kind {request.kind!r} is no page of curves"
        )
    figure, frames = _frames(request)
    with ExitStack() as stack:
        views = [
            [(curve, stack.enter_context(read(archive_of(curve)))) for curve in panel.curves]
            for panel in request.panels
        ]
        for frame, panel, content in zip(frames, request.panels, views, strict=True):
            _draw(frame, content, request.damper_energy)
            _name(frame, panel, len(frames))
        _label_axes(frames, request, views[0][0][1])
    frames[0].set_ylim(0, _ABOVE * max(frame.dataLim.y1 for frame in frames))
    return figure


def _frames(request: FigureRequest) -> tuple[Figure, list[Axes]]:
    """Return a figure with the panels, which share both axes; title and legend stand above."""
    columns = min(request.columns, len(request.panels))
    rows = ceil(len(request.panels) / columns)
    handles = _handles(request)
    per_row = _per_row([str(handle.get_label()) for handle in handles])
    head = _HEAD + ceil(len(handles) / per_row) * _LEGEND + 0.15 * CM
    named = _ROW if len(request.panels) > 1 else 0.0
    body = rows * (_SHARES[columns] + named)
    height = head + body + _FOOT
    figure = Figure(figsize=(WIDTH, height))
    frames: list[Axes] = []
    across = (WIDTH - _SIDE - _EDGE - (columns - 1) * _GAP) / columns
    for index in range(len(request.panels)):
        row, column = divmod(index, columns)
        left = _SIDE + column * (across + _GAP)
        bottom = _FOOT + (rows - 1 - row) * (_SHARES[columns] + named)
        box = (left / WIDTH, bottom / height, across / WIDTH, _SHARES[columns] / height)
        shared: dict[str, Any] = {"sharex": frames[0], "sharey": frames[0]} if frames else {}
        frames.append(figure.add_axes(box, **shared))
    figure.text(_SIDE / WIDTH, 1 - 0.15 * CM / height, request.title, va="top")
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(_SIDE / WIDTH, 1 - _HEAD / height),
        ncols=per_row,
        frameon=False,
        borderaxespad=0,
        borderpad=0,
        columnspacing=1.4,
        handlelength=2.2,
        labelspacing=0.35,
    )
    return figure, frames


def _per_row(labels: Sequence[str]) -> int:
    """Return how many entries of a legend stand side by side; they fill it column by column."""
    widths = np.array([_HANDLE + _text_width(label) for label in labels])
    for rows in range(1, len(labels)):
        columns = ceil(len(labels) / rows)
        needed = sum(column.max() for column in np.array_split(widths, columns))
        if needed <= 72 * (WIDTH - _SIDE - _EDGE):
            return columns
    return 1


def _text_width(text: str) -> float:
    """Return the width of a text of the legend in points."""
    font = FontProperties(family=STYLE["font.family"], size=STYLE["legend.fontsize"])
    return float(TextPath((0, 0), text, prop=font).get_extents().width)


def _handles(request: FigureRequest) -> list[Any]:
    """Return the entries of the legend: the curves of the first panel, and what else is drawn."""
    first = request.panels[0]
    found: list[Any] = [
        Line2D([], [], label=_curve_label(curve), **_look(curve)) for curve in first.curves
    ]
    if request.damper_energy:
        text = r"$E_2^{\,\mathrm{max}}$ of the damper"
        found.append(Line2D([], [], color=RESONANCE, linestyle=_DOTS, label=text))
    if any(curve.shade for curve in request.curves):
        found.append(Patch(facecolor=IMPACTS, edgecolor="#c9bd78", linewidth=0.4, label="impacts"))
    resonance: dict[str, Any] = {"color": RESONANCE, "linewidth": 0.7}
    found.append(Line2D([], [], label=r"$\omega_0=\sqrt{k_1/m_1}$", **resonance))
    return found


def _curve_label(curve: Curve) -> str:
    """Return what the legend calls a curve: its label, what is set, or its system's title."""
    settings = [setting_label(name, value) for name, value in curve.settings.items()]
    system = curve.scan.system
    return curve.label or ", ".join(settings) or system.title or system.name


def _look(curve: Curve) -> dict[str, Any]:
    return {
        "color": curve.colour,
        "linestyle": curve.line,
        "linewidth": 1.5 if curve.base else 1.0,
        "zorder": 3.5 if curve.base else 3.0,
    }


def _draw(frame: Axes, content: Sequence[tuple[Curve, ArchiveView]], damper_energy: bool) -> None:
    """Draw one panel: shading, then resonances, then the curves, the base last."""
    for curve, view in content:
        if curve.shade:
            _shade(frame, view)
    _mark_resonances(frame, [curve for curve, _ in content])
    for curve, view in content:
        values, look = view[view.axes[0]], _look(curve)
        frame.plot(values, view.take("E1max", start=0), **look)
        if damper_energy and "E2max" in view:
            frame.plot(values, view.take("E2max", start=0), **{**look, "linestyle": _DOTS})
    frame.set_xlim(*content[0][1][content[0][1].axes[0]][[0, -1]])
    frame.tick_params(top=True, right=True)


def _shade(frame: Axes, view: ArchiveView) -> None:
    """Fill where there are impacts; dashed lines bound the windows without any."""
    values, impacts = view[view.axes[0]], view.take("impacts", start=0)
    found = bands(values, np.where(impacts > 0, "impacts", "none"))
    for band in found:
        if band.label == "impacts":
            frame.axvspan(band.low, band.high, color=IMPACTS, linewidth=0, zorder=0)
        elif band.width >= _VISIBLE * (values[-1] - values[0]):
            for bound in (band.low, band.high):
                frame.axvline(
                    bound, color="#666666", linewidth=0.6, linestyle=(0, (4, 2)), zorder=1
                )


def _mark_resonances(frame: Axes, curves: Sequence[Curve]) -> None:
    """Mark omega0 = sqrt(k1 / m1): by a line, or where it differs by a mark for each curve."""
    places = {_own_frequency(curve): curve.colour for curve in curves}
    if len(places) == 1:
        frame.axvline(next(iter(places)), color=RESONANCE, linewidth=0.7, zorder=2)
        return
    for place, colour in places.items():
        frame.axvline(place, ymin=0.94, color=colour, linewidth=1.2, zorder=2)


def _own_frequency(curve: Curve) -> float:
    p = curve.scan.system.parameters
    return sqrt(p["k1"] / p["m1"])


def _name(frame: Axes, panel: Panel, count: int) -> None:
    """Write a panel's letter and title above it; that of the tuning is marked."""
    if count == 1:
        return
    letter = "abcdefghijklmnop"[frame.figure.axes.index(frame)]
    settings = [setting_label(name, value) for name, value in panel.settings.items()]
    title = panel.title or ", ".join(settings)
    text = f"({letter})  {title}" + (" (tuning)" if panel.base else "")
    frame.set_title(text, fontsize=8.5, loc="left", pad=3, color=BASE if panel.base else "black")


def _label_axes(frames: Sequence[Axes], request: FigureRequest, view: ArchiveView) -> None:
    """Label the outer axes of a page; in narrow panels the frequency's words are left out."""
    columns = min(request.columns, len(frames))
    across = axis_label(view.axes[0])
    if columns > 1:
        across = across.rpartition("force ")[2]
    up = quantity_label("E1max", view.units("E1max"))
    if request.damper_energy:
        up = r"largest energies $E_1^{\,\mathrm{max}}, E_2^{\,\mathrm{max}}$ [J]"
    for index, frame in enumerate(frames):
        if index + columns >= len(frames):
            frame.set_xlabel(across)
        else:
            frame.tick_params(labelbottom=False)
        if index % columns == 0:
            frame.set_ylabel(up)
        else:
            frame.tick_params(labelleft=False)


def save_page(
    request: FigureRequest, archive_of: Callable[[Curve], Path], plot_path: str | os.PathLike[str]
) -> Path:
    """Draw a page of curves as `save` draws an archive; returns the picture's path.

    Arguments: `archive_of` returns the path of a curve's archive.  The hash in the picture is
    that of all its scans.
    """
    path = Path(plot_path)
    check_format(path)
    figure = draw_page(request, archive_of)
    hashes = "".join(curve.scan.hash for curve in request.curves)
    origin = ("scan_hash", sha256(hashes.encode()).hexdigest())
    return save_figure(figure, path, request.title, origin)
