"""The frequencies of a 1:1 response in closed form, over a map of frequency and something else."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import Normal, Stroke

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.slow_manifold import slow_manifold

IN_TITLE = "dashed: bounds of 1:1 motion in closed form"
"""What the title of such a map says of the lines."""

_HALVED = 14  # times, the step between two values, to find where the response ends
_MOST = 120  # values of the other parameter at which the bounds are computed


def draw_manifold(panels: list[Axes], view: ArchiveView) -> None:
    """Draw the least and the largest frequency of the 1:1 response into the panels of a map.

    Raises `RequestError` for a map without omega, and for a system that has no closed form.
    """
    values, low, high = manifold_bounds(view)
    upwards = view.axes[0] == "omega"
    look: dict[str, Any] = {"color": "white", "linewidth": 0.9, "linestyle": (0, (5, 2))}
    look |= {"path_effects": [Stroke(linewidth=1.9, foreground="black"), Normal()]}
    for axes in panels:
        for bound in (low, high):
            across, up = (bound, values) if upwards else (values, bound)
            axes.plot(across, up, scalex=False, scaley=False, **look)


def manifold_bounds(view: ArchiveView) -> np.ndarray:
    """Return values of a map's other parameter and the two bounds of omega [rad/s] there, (3, n).

    NaN where there is no 1:1 response.  Raises `RequestError` as `draw_manifold`.
    """
    if "omega" not in view.axes or not all(name in PARAMETERS for name in view.axes):
        over = " and ".join(view.axes)
        raise RequestError(f"manifold: for maps of omega and another parameter; this is of {over}")
    (other,) = (name for name in view.axes if name != "omega")
    values = view[other]
    if values.size > _MOST:
        values = np.interp(np.linspace(0, 1, _MOST), np.linspace(0, 1, values.size), values)
    system = view.request(SCAN, load_scan).system

    def bounds(value: float) -> tuple[float, float]:
        outline, _ = slow_manifold(system.with_(**{other: float(value)})).response().outline
        found = outline[np.isfinite(outline)]
        return (found.min(), found.max()) if found.size else (np.nan, np.nan)

    found = [(value, *bounds(value)) for value in values]
    ends = [_end(bounds, one, next_) for one, next_ in pairwise(found) if _differ(one, next_)]
    return np.array(sorted([*found, *ends])).T


_Bounds = tuple[float, float, float]
"""A value of the other parameter, and the bounds of omega there; NaN for none."""


def _differ(one: _Bounds, other: _Bounds) -> bool:
    """Tell whether there is a response at one of two values alone."""
    return np.isnan(one[1]) != np.isnan(other[1])


def _end(bounds: Callable[[float], tuple[float, float]], one: _Bounds, other: _Bounds) -> _Bounds:
    """Return where, between two values, the response ends: the last place at which there is one."""
    inside, outside = (other, one[0]) if np.isnan(one[1]) else (one, other[0])
    for _ in range(_HALVED):
        middle = 0.5 * (inside[0] + outside)
        found = (middle, *bounds(middle))
        if np.isnan(found[1]):
            outside = middle
        else:
            inside = found
    return inside
