"""The picture of error against run time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.accuracy.measured_cases import Measured
from nlds_vines.plotting.page import ONE_COLUMN, styled
from nlds_vines.plotting.style import CM, STYLE

_PANEL = 8.0 * CM
_LOOKS: dict[str, dict[str, Any]] = {
    "exact": {"color": "#000000", "marker": "o", "linewidth": 1.8},
    "rk4": {"color": "#0072b2", "marker": "s", "linewidth": 1.8},
    "SciPy": {"color": "#e69f00", "marker": "h"},
}
_DOUBT: dict[str, Any] = {"color": "#bbbbbb", "linewidth": 0.6, "zorder": 0}
_NO_DOUBT = 1e-16  # of the reference, below which no line shows it


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


@styled()
def draw(case: Measured) -> Figure:
    """Return the picture of error against CPU time.

    Of each family of solvers only the cheapest settings are drawn.  Hollow: touches were missed or
    invented.
    """
    figure = Figure(figsize=(ONE_COLUMN.width, _PANEL), layout="constrained")
    fill(figure.subplots(), case)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def fill(axes: Axes, case: Measured) -> None:
    """Draw error against CPU time into axes, whose lines have labels."""
    families: dict[str, list[Any]] = {}
    for result in case.results:
        families.setdefault(family_of(result.setting.method), []).append(result)
    doubt = case.known.doubt
    for family, results in families.items():
        look = _look(family)
        done = (result for result in results if result.complete and result.seconds > 0.0)
        best = front((max(result.error, doubt), result.seconds) for result in done)
        blind = [result for result in results if not (result.failure or result.complete)]
        if best:
            axes.loglog(*np.array(best).T[::-1], **look, label=family)
        if blind:
            points = np.array([(result.seconds, result.error) for result in blind]).T
            hollow = {**look, "linestyle": "", "fillstyle": "none", "alpha": 0.6}
            axes.loglog(*points, **hollow, label=f"{family}: touches missed or invented")
    if doubt > _NO_DOUBT:
        axes.axhline(doubt, **_DOUBT, label="doubt of the reference")
    axes.set_title(case.known.name, fontsize=STYLE["axes.labelsize"], loc="left")
    axes.set_xlabel("CPU time per forcing period [s]")
    axes.set_ylabel("error of the state [m, m/s]")


def _look(family: str) -> dict[str, Any]:
    name = family.split(",")[0]
    look = {"linewidth": 0.9, "markersize": 3.2, **_LOOKS.get(name, {"color": "#444444"})}
    solid = name in ("exact", "rk4") or family.endswith("events")
    return {**look, "linestyle": "-" if solid else "--"}
