"""The pictures of surveys: error against run time by case; error and cost against stiffness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nlds_vines.accuracy.comparison_page import family_of
from nlds_vines.accuracy.comparison_table import Measured, read_comparison
from nlds_vines.accuracy.curves import front
from nlds_vines.accuracy.stiffness_table import SHAPE as STIFFNESS
from nlds_vines.accuracy.stiffness_table import Stiff, read_stiffness, representatives
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled
from nlds_vines.plotting.style import CM, STYLE, axis_label

_PANEL, _HEAD, _ENTRY = 6.2 * CM, 0.8 * CM, 0.42 * CM
_LOOKS: dict[str, dict[str, Any]] = {
    "exact": {"color": "#000000", "marker": "o", "linewidth": 1.8},
    "rk4": {"color": "#0072b2", "marker": "s", "linewidth": 1.8},
    "naive": {"color": "#777777", "marker": "x"},
    "numbalsoda": {"color": "#009e73", "marker": "^"},
    "heyoka": {"color": "#d55e00", "marker": "D"},
    "SUNDIALS": {"color": "#cc79a7", "marker": "v"},
    "diffrax": {"color": "#56b4e9", "marker": "P"},
    "SciPy": {"color": "#e69f00", "marker": "h"},
    "Octave": {"color": "#7a4b00", "marker": "*"},
}
_SECONDS = "CPU time per forcing period [s]"
_ERROR = "error of the state [m, m/s]"
_HOLLOW: dict[str, Any] = {"color": "#444444", "marker": "o", "fillstyle": "none", "linestyle": ""}
_DOUBT: dict[str, Any] = {"color": "#bbbbbb", "linewidth": 0.6, "zorder": 0}
_NO_DOUBT = 1e-16  # of the reference, below which no line shows it
_ROUND_OFF, _ASTRAY = 1e-16, 1e2  # errors beyond which how small or large they are says nothing


@styled()
def draw_comparison(cases: Sequence[Measured], page: Page = TWO_COLUMNS) -> Figure:
    """Return a panel for each case: error against CPU time on logarithmic scales.

    Solid lines split contacts by events, broken ones do not; of each family of solvers only the
    cheapest settings are drawn.  Hollow: touches were missed or invented.
    """
    columns = min(len(cases), 2) if page.beside else 1
    rows = -(-len(cases) // columns)
    figure = Figure(figsize=(page.width, rows * _PANEL + _HEAD), layout="constrained")
    frames = figure.subplots(rows, columns, squeeze=False).ravel()
    seen: dict[str, dict[str, Any]] = {}
    for frame, case in zip(frames, cases, strict=False):
        seen |= _draw(frame, case)
    handles = _handles(cases, seen)
    if len(cases) < frames.size:  # the place of a panel is free
        frames[-1].axis("off")
        frames[-1].legend(handles=handles, loc="center", frameon=False, ncols=2)
    elif page.beside:
        figure.legend(handles=handles, loc="outside right center", frameon=False)
    else:
        _add_legend_below(figure, handles)
    return figure


def _handles(cases: Sequence[Measured], seen: Mapping[str, dict[str, Any]]) -> list[Line2D]:
    """Return the entries of the legend: the families that were `seen`, and marks."""
    handles = [Line2D([], [], label=family, **look) for family, look in seen.items()]
    if any(curve.blind for case in cases for curve in case.curves):
        handles.append(Line2D([], [], label="touches missed or invented", **_HOLLOW))
    if any(case.doubt > _NO_DOUBT for case in cases):
        handles.append(Line2D([], [], label="doubt of the reference", **_DOUBT))
    return handles


def _add_legend_below(figure: Figure, handles: Sequence[Any]) -> None:
    """Add a legend below a narrow figure, which grows by it."""
    figure.set_figheight(figure.get_figheight() + _ENTRY * len(handles))
    figure.legend(handles=handles, loc="outside lower left", frameon=False)


@styled()
def draw_stiffness(
    found: Stiff, page: Page = TWO_COLUMNS, shown: Sequence[str] = ("error", "time")
) -> Figure:
    """Return error and CPU time against K: of each family the method that fares best.

    Gaps are failures; points beyond the frame have diverged.  Beside the errors stands how far
    the true orbit is from the rigid limit.
    """
    figure = Figure(figsize=(page.width, (1.3 * len(shown)) * _PANEL), layout="constrained")
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, shown, strict=True):
        _fill_stiffness(axes, found, name)
        axes.label_outer()
    handles, labels = panels[0].get_legend_handles_labels()
    if page.beside:
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    else:
        _add_legend_below(figure, handles)
    return figure


def _fill_stiffness(axes: Axes, found: Stiff, name: str) -> None:
    """Draw errors or times against K into axes."""
    for method in representatives(found):
        rows, look = found.of(method), {**_look(family_of(method)), "label": method}
        values = rows["seconds"] if name == "time" else np.maximum(rows["error"], rows["doubt"])
        axes.loglog(rows["K"], values, **look)
    axes.set_xlabel(axis_label("K"))
    axes.set_ylabel(_SECONDS if name == "time" else _ERROR)
    if name == "error":
        rigid = found.of("exact")
        words = "the true orbit's distance from the rigid limit"
        axes.loglog(rigid["K"], rigid["rigid"], color="#555555", linestyle=":", label=words)
        bottom, top = axes.get_ylim()
        axes.set_ylim(max(bottom, _ROUND_OFF), min(top, _ASTRAY))


def _is_stiffness(view: ArchiveView) -> bool:
    return view.attrs.get("survey") == STIFFNESS


def _panels(view: ArchiveView) -> dict[str, str]:
    """Return what the panels of a survey's picture show: its cases, or errors and times."""
    if _is_stiffness(view):
        return {"error": "error of the state against K", "time": "CPU time against K"}
    return {case.name: f"error against CPU time: {case.title}" for case in read_comparison(view)}


def _picture(view: ArchiveView, names: Sequence[str], page: Page) -> Figure:
    """Return the picture of a survey: error against run time, or against stiffness."""
    if _is_stiffness(view):
        return draw_stiffness(read_stiffness(view), page, names)
    return draw_comparison([case for case in read_comparison(view) if case.name in names], page)


def _fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel of a survey into axes, with its legend."""
    if _is_stiffness(view):
        _fill_stiffness(axes, read_stiffness(view), name)
        axes.legend()
        return
    cases = [case for case in read_comparison(view) if case.name == name]
    axes.legend(handles=_handles(cases, _draw(axes, cases[0])))


PICTURE = Picture(_panels, _picture, _fill)
"""What draws the archive of a survey."""


def _draw(frame: Axes, case: Measured) -> dict[str, dict[str, Any]]:
    """Draw one case; returns the looks of the families that are in it."""
    looks = {}
    for family in dict.fromkeys(family_of(curve.method) for curve in case.curves):
        curves = [curve for curve in case.curves if family_of(curve.method) == family]
        best = np.array(front([point for curve in curves for point in curve.points]))
        blind = [(found.seconds, found.error) for curve in curves for found in curve.blind]
        if best.size or blind:
            looks[family] = _look(family)
        if best.size:
            frame.loglog(best[:, 1], best[:, 0], **looks[family])
        if blind:
            hollow = {**looks[family], "linestyle": "", "fillstyle": "none", "alpha": 0.6}
            frame.loglog(*np.array(blind).T, **hollow)
    if case.doubt > _NO_DOUBT:
        frame.axhline(case.doubt, **_DOUBT)
    frame.set_title(case.name, fontsize=STYLE["axes.labelsize"], loc="left")
    frame.set_xlabel(_SECONDS)
    frame.set_ylabel(_ERROR)
    return looks


def _look(family: str) -> dict[str, Any]:
    name = family.split(",")[0]
    look = {"linewidth": 0.9, "markersize": 3.2, **_LOOKS.get(name, {"color": "#444444"})}
    solid = name in ("exact", "rk4") or family.endswith("events")
    return {**look, "linestyle": "-" if solid else "--"}
