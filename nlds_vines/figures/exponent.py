"""The largest Lyapunov exponent along a diagram: below zero order, above it chaos."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nlds_vines.archive import ArchiveView
from nlds_vines.figures.style import quantity_label, start_colours

EXPONENT = "lyapunov"
"""The dataset that is drawn this way."""

_ZERO: dict[str, Any] = {"color": "#8a8a8a", "linewidth": 0.6, "zorder": 0.5}
_DOT: dict[str, Any] = {
    "marker": "o",
    "markersize": 1.4,
    "markeredgewidth": 0,
    "linestyle": "none",
}


def draw_exponent(panel: Axes, view: ArchiveView, row: str) -> None:
    """Draw the exponents against the parameter, every start in its colour, over a line at zero.

    Each is a dot with its 99 % interval as a bar; the interval of a periodic orbit has no width.
    """
    values = view[view.axes[0]]
    panel.axhline(0.0, **_ZERO)
    for start, colour in enumerate(start_colours(list(view["start"]))):
        found = view.take(row, start=start)
        width = view.take(f"{row}_width", start=start)
        drawn = np.isfinite(found) & np.isfinite(width)
        panel.vlines(
            values[drawn],
            (found - width)[drawn],
            (found + width)[drawn],
            color=colour,
            alpha=0.35,
            linewidth=1.0,
            rasterized=True,
        )
        panel.plot(values[drawn], found[drawn], color=colour, rasterized=True, **_DOT)
    panel.set_ylabel(quantity_label(row, view.units(row)))
