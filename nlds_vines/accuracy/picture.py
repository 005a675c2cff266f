"""The picture of error against CPU time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nlds_vines.accuracy.measure import Reference, Result
from nlds_vines.plotting.page import ONE_COLUMN, styled
from nlds_vines.plotting.style import CM, STYLE

_LOOKS: dict[str, dict[str, Any]] = {
    "exact": {"color": "#000000", "marker": "o", "linewidth": 1.8},
    "rk4": {"color": "#0072b2", "marker": "s", "linewidth": 1.8},
    "SciPy DOP853": {"color": "#e69f00", "marker": "h", "linewidth": 0.9},
}


@styled()
def draw(truth: Reference, results: Sequence[Result]) -> Figure:
    """Draw each method's settings that no other of its settings beats in both error and time."""
    figure = Figure(figsize=(ONE_COLUMN.width, 8.0 * CM), layout="constrained")
    axes = figure.subplots()
    for method, look in _LOOKS.items():
        mine = (r for r in results if r.method == method and not r.failure)
        points = sorted((r.seconds, max(r.error, truth.uncertainty)) for r in mine)
        best = np.minimum.accumulate([error for _, error in points])
        front = [p for i, p in enumerate(points) if i == 0 or best[i] < best[i - 1]]
        if front:
            axes.loglog(*np.array(front).T, markersize=3.2, label=method, **look)
    if truth.uncertainty > 0.0:
        look = {"color": "#bbbbbb", "linewidth": 0.6, "zorder": 0}
        axes.axhline(truth.uncertainty, label="uncertainty of the reference", **look)
    axes.set_title(truth.system.name, fontsize=STYLE["axes.labelsize"], loc="left")
    axes.set_xlabel("CPU time per forcing period [s]")
    axes.set_ylabel("error of the state [m, m/s]")
    figure.legend(loc="outside lower center", ncols=2)
    return figure
