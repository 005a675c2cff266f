"""Sections of an orbit in planes of their own: stroboscopic, and at impact."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm

from nlds_vines.plotting.style import DOT, SHADES
from nlds_vines.portrait.page_layout import Place
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

CROWDED = 1500
"""Points of a section from which their color tells how many are near: single ones overlap."""

_CELLS = 160  # along each side of the plane, in which points are counted
_PALEST = 0.9  # of the color map: its yellow end is too pale for dots
_LARGE, _SMALL, _SMALLEST = 3.4, 1.7, 0.9  # points, sizes of dots of few, more and many points
_FEW = 40  # points that are drawn large


def draw_section(place: Place, request: PortraitRequest, body: int, color: str) -> None:
    """Draw the stroboscopic section of a body, 0 or 1, at the phase that the request says."""
    view = place.view
    sample = round(request.section_phase * view.samples) % view.samples
    points = view.section_at(sample)[:, 2 * body : 2 * body + 2]
    n = view.period
    if n:
        points = points[-n:]
    _scatter(place.axes, points, color, _label(sample, view))
    place.axes.margins(0.06)


def _label(sample: int, view: View) -> str:
    """Return what the legend says of the instants of a section; phi in turns."""
    if sample == 0:
        return "$t=nT$"
    return rf"$\phi={sample / view.samples:.3g}$"


def draw_impact_section(
    place: Place, request: PortraitRequest, looks: Mapping[str, Mapping[str, str]]
) -> None:
    """Draw phase of the force and approach speed of each touch, of a cycle where there is one.

    looks: colors and labels of walls, by name.
    """
    view, axes = place.view, place.axes
    for name, points in view.impact_section.items():
        if len(points):
            _scatter(axes, points, looks[name]["color"], looks[name]["label"], shaded=False)
    if not len(view.contacts):
        axes.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=axes.transAxes)
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_ylim(0.0, 1.08 * max(axes.dataLim.y1, 0.0) or 1.0)
    axes.set_xlabel(r"phase at touch $\varphi$ [rad]")
    axes.set_ylabel("approach speed [m/s]")


def _scatter(axes: Axes, points: np.ndarray, color: str, label: str, shaded: bool = True) -> None:
    """Draw points (n, 2); of many, if they are `shaded`, the color tells how many are near."""
    many = len(points)
    size = _LARGE if many < _FEW else _SMALL if many < CROWDED else _SMALLEST
    if many < CROWDED or not shaded:
        look = {"color": color, "markersize": size, "label": label, **DOT}
        axes.plot(points[:, 0], points[:, 1], rasterized=many > CROWDED, **look)
        return
    near = _neighbors(points)
    order = np.argsort(near, kind="stable")  # the dense ones above
    axes.scatter(
        points[order, 0], points[order, 1], s=size**2, c=near[order], cmap=_shades(),
        rasterized=True,
        norm=LogNorm(1.0, max(2.0, float(near.max()))), linewidths=0,
    )  # fmt: skip
    axes.plot([], [], color=_shades()(0.5), label=label, **DOT)


def _neighbors(points: np.ndarray) -> np.ndarray:
    """Return how many points stand in the cell of each, of a grid over their range."""
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    places = ((points - low) / np.where(span > 0, span, 1.0) * _CELLS).astype(int)
    cells = np.minimum(places, _CELLS - 1) @ np.array([1, _CELLS])
    return np.bincount(cells)[cells]


def _shades() -> LinearSegmentedColormap:
    """Return the color map of counts: dark where points are few, lighter where many overlap."""
    return LinearSegmentedColormap.from_list(
        "counts", colormaps[SHADES](np.linspace(0.0, _PALEST, 64))
    )
