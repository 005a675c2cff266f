"""The picture of an archive: error against run time by case; error and cost against stiffness."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.accuracy.measured_cases import SHAPE, Measured, read_cases
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled
from nlds_vines.plotting.style import CM, STYLE, axis_label

_PANEL, _ENTRY = 6.2 * CM, 0.42 * CM
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
_DOUBT: dict[str, Any] = {"color": "#bbbbbb", "linewidth": 0.6, "zorder": 0}
_NO_DOUBT = 1e-16  # of the reference, below which no line shows it
_ROUND_OFF, _ASTRAY = 1e-16, 1e2  # errors beyond which how small or large they are says nothing


def family_of(method: str) -> str:
    """Return the library that a method belongs to, and whether contacts are split by events."""
    if method in ("exact", "rk4"):
        return method
    name = method.split()[0]
    return f"{name}, events" if method.endswith("events") else name


def front(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the points (error, seconds) of which no other has less of both, coarse ones first."""
    best: list[tuple[float, float]] = []
    for error, seconds in sorted(points, key=lambda point: (point[1], point[0])):
        if not best or error < best[-1][0]:
            best.append((error, seconds))
    return best


def _panels(view: ArchiveView) -> dict[str, str]:
    """Return what the panels of the picture show: cases, or errors and times."""
    if view.attrs.get("survey") != SHAPE:
        return {"error": "error of the state against K", "time": "CPU time against K"}
    return {case.name: f"error against CPU time: {case.title}" for case in read_cases(view)}


@styled()
def draw(
    view: ArchiveView,
    names: Sequence[str] | None = None,
    page: Page = TWO_COLUMNS,
    methods: Sequence[str] = (),
) -> Figure:
    """Return the picture of an archive, some panels or all; against stiffness of some `methods`.

    Solid lines split contacts by events, broken ones do not; of each family of solvers only the
    cheapest settings are drawn.  Hollow: touches were missed or invented.
    """
    chosen = list(_panels(view)) if names is None else names
    across = view.attrs.get("survey") == SHAPE and page.beside
    columns = min(len(chosen), 2) if across else 1
    rows = -(-len(chosen) // columns)
    figure = Figure(figsize=(page.width, rows * _PANEL), layout="constrained")
    frames = figure.subplots(rows, columns, squeeze=False).ravel()
    legend: dict[str, Any] = {}
    for frame, name in zip(frames, chosen, strict=False):
        _fill(frame, view, name, methods)
        handles, labels = frame.get_legend_handles_labels()
        legend |= dict(zip(labels, handles, strict=True))
    for frame in frames[len(chosen) :]:
        frame.axis("off")
    beside = 3 if page.beside else 1
    figure.set_figheight(rows * _PANEL + _ENTRY * (1 + -(-len(legend) // beside)))
    figure.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=beside)
    return figure


def _fill(axes: Axes, view: ArchiveView, name: str, methods: Sequence[str] = ()) -> None:
    """Draw one panel into axes, whose lines have labels."""
    if view.attrs.get("survey") == SHAPE:
        _fill_comparison(axes, next(case for case in read_cases(view) if case.name == name))
    else:
        _fill_stiffness(axes, view, name, methods)


def _fill_comparison(axes: Axes, case: Measured) -> None:
    """Draw error against CPU time of one case."""
    families: dict[str, list[Any]] = {}
    for found in case.results:
        families.setdefault(family_of(found.setting.method), []).append(found)
    for family, results in families.items():
        look = _look(family)
        done = (found for found in results if found.complete and found.seconds > 0.0)
        best = front((max(found.error, case.doubt), found.seconds) for found in done)
        blind = [found for found in results if not (found.failure or found.complete)]
        if best:
            axes.loglog(*np.array(best).T[::-1], **look, label=family)
        if blind:
            points = np.array([(found.seconds, found.error) for found in blind]).T
            hollow = {**look, "linestyle": "", "fillstyle": "none", "alpha": 0.6}
            axes.loglog(*points, **hollow, label=f"{family}: touches missed or invented")
    if case.doubt > _NO_DOUBT:
        axes.axhline(case.doubt, **_DOUBT, label="doubt of the reference")
    axes.set_title(case.name, fontsize=STYLE["axes.labelsize"], loc="left")
    axes.set_xlabel(_SECONDS)
    axes.set_ylabel(_ERROR)


def _fill_stiffness(axes: Axes, view: ArchiveView, name: str, methods: Sequence[str]) -> None:
    """Draw errors or times against K, and beside errors how far the rigid limit is.

    Gaps are failures; points beyond the frame have diverged.
    """
    for method in methods or dict.fromkeys(view["method"].tolist()):
        mine = np.flatnonzero(view["method"] == method)
        mine = mine[np.argsort(view["K"][mine], kind="stable")]
        K, error, seconds = (view[word][mine] for word in ("K", "error", "seconds"))
        values = seconds if name == "time" else np.maximum(error, view["doubt"][mine])
        axes.loglog(K, values, **_look(family_of(method)), label=method)
        if name == "error" and method == "exact":
            words = "the true orbit's distance from the rigid limit"
            axes.loglog(K, view["rigid"][mine], color="#555555", linestyle=":", label=words)
    axes.set_xlabel(axis_label("K"))
    axes.set_ylabel(_SECONDS if name == "time" else _ERROR)
    if name == "error":
        bottom, top = axes.get_ylim()
        axes.set_ylim(max(bottom, _ROUND_OFF), min(top, _ASTRAY))


def _fill_alone(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel into axes, with its legend."""
    _fill(axes, view, name)
    axes.legend()


def _look(family: str) -> dict[str, Any]:
    name = family.split(",")[0]
    look = {"linewidth": 0.9, "markersize": 3.2, **_LOOKS.get(name, {"color": "#444444"})}
    solid = name in ("exact", "rk4") or family.endswith("events")
    return {**look, "linestyle": "-" if solid else "--"}


PICTURE = Picture(_panels, draw, _fill_alone)
"""What draws the archive of a survey."""
