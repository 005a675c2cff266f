"""The pictures of surveys: error against run time by case; error and cost against stiffness."""

from __future__ import annotations

from collections.abc import Sequence
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
from nlds_vines.errors import RequestError
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.style import CM, STYLE, WIDTH, axis_label

_PANEL, _HEAD = 6.2 * CM, 0.8 * CM
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


def draw_survey(view: ArchiveView) -> Figure:
    """Return the picture of a survey's archive: error against run time, or against stiffness."""
    if view.attrs.get("survey") == STIFFNESS:
        return draw_stiffness(read_stiffness(view))
    return draw_comparison(read_comparison(view))


@styled()
def draw_comparison(cases: Sequence[Measured]) -> Figure:
    """Return a panel for each case: error against CPU time on logarithmic scales.

    Solid lines split contacts by events, broken ones do not; of each family of solvers only the
    cheapest settings are drawn.  Hollow: touches were missed or invented.
    """
    columns = min(len(cases), 2)
    rows = -(-len(cases) // columns)
    figure = Figure(figsize=(WIDTH, rows * _PANEL + _HEAD), layout="constrained")
    frames = figure.subplots(rows, columns, squeeze=False).ravel()
    seen: dict[str, dict[str, Any]] = {}
    for frame, case in zip(frames, cases, strict=False):
        seen |= _draw(frame, case)
    handles = [Line2D([], [], label=family, **look) for family, look in seen.items()]
    if any(curve.blind for case in cases for curve in case.curves):
        handles.append(Line2D([], [], label="touches missed or invented", **_HOLLOW))
    if any(case.doubt > _NO_DOUBT for case in cases):
        handles.append(Line2D([], [], label="doubt of the reference", **_DOUBT))
    if len(cases) < frames.size:  # the place of a panel is free
        frames[-1].axis("off")
        frames[-1].legend(handles=handles, loc="center", frameon=False, ncols=2)
    else:
        figure.legend(handles=handles, loc="outside right center", frameon=False)
    return figure


@styled()
def draw_stiffness(found: Stiff) -> Figure:
    """Return error and CPU time against K: of each family the method that fares best.

    Gaps are failures; points beyond the frame have diverged.  Beside the errors stands how far
    the true orbit is from the rigid limit.
    """
    figure = Figure(figsize=(WIDTH, 2.6 * _PANEL), layout="constrained")
    errors, costs = figure.subplots(2, 1, sharex=True)
    for method in representatives(found):
        rows, look = found.of(method), {**_look(family_of(method)), "label": method}
        errors.loglog(rows["K"], np.maximum(rows["error"], rows["doubt"]), **look)
        costs.loglog(rows["K"], rows["seconds"], **look)
    rigid = found.of("exact")
    words = "the true orbit's distance from the rigid limit"
    errors.loglog(rigid["K"], rigid["rigid"], color="#555555", linestyle=":", label=words)
    errors.set_ylabel(_ERROR)
    bottom, top = errors.get_ylim()
    errors.set_ylim(max(bottom, _ROUND_OFF), min(top, _ASTRAY))
    costs.set_ylabel(_SECONDS)
    costs.set_xlabel(axis_label("K"))
    figure.legend(*errors.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def case_into(axes: Axes, view: ArchiveView) -> None:
    """Draw error against CPU time of a survey of one case into axes.

    Raises `RequestError` for a survey of several cases, and for one of stiffness.
    """
    cases = [] if view.attrs.get("survey") == STIFFNESS else read_comparison(view)
    if len(cases) != 1:
        raise RequestError(f"{view.path} needs several panels: draw it without axes")
    looks = _draw(axes, cases[0])
    axes.legend(handles=[Line2D([], [], label=family, **look) for family, look in looks.items()])


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
