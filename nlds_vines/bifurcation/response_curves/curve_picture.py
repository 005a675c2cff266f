"""How response curves look, and the entries of their legend."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Any

from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nlds_vines.bifurcation.response_curves.request import Curve, CurvePage, label_of
from nlds_vines.plotting.notation import setting_label, typeset

IMPACTS = "#fff7c2"
"""The color of frequencies with impacts: light yellow, as in Figure 2b."""

RESONANCE = "#444444"
"""The color of the structure's own frequency."""

BASE = "#b03a00"
"""The color of the title of the panel that shows the tuning."""

DOTTED = (0, (1, 1.6))  # the line of E2max: lengths of dot and gap
BOUND: dict[str, Any] = {
    "color": "#666666", "linewidth": 0.6, "linestyle": (0, (4, 2)), "zorder": 1,
}  # fmt: skip
MANIFOLD: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 4}
"""The line of a closed form, over the curve that it is for and in its color."""

WINDOW: dict[str, Any] = {"alpha": 0.13, "linewidth": 0, "zorder": 0.5}
"""Windows of coexisting and of modulated responses, in the color of their curve."""

NARROW: dict[str, Any] = {**BOUND, "linewidth": 0.45, "linestyle": "solid"}


def legend_of(request: CurvePage) -> list[Any]:
    """Return the entries of the legend: the curves of the first panel, then everything else."""
    first = request.panels[0]
    found: list[Any] = [
        Line2D([], [], label=_curve_label(curve), **look_of(curve)) for curve in first.curves
    ]
    if request.damper_energy:
        text = r"$E_2^{\,\mathrm{max}}$ of a damper"
        found.append(Line2D([], [], color=RESONANCE, linestyle=DOTTED, label=text))
    if request.manifold:
        text = "1:1 motion in closed form"
        found.append(Line2D([], [], label=text, **{**MANIFOLD, "color": RESONANCE}))
    first_scan = request.curves[-1].scan
    words = ["sweeps differ"] if first_scan.starts > 1 else []
    if any("regime" in curve.scan.want for curve in request.curves):
        words.append("quasiperiodic or chaotic")
    if words:
        text, look = f"shaded: {', or '.join(words)}", {**WINDOW, "alpha": 0.25}
        found.append(Patch(facecolor=RESONANCE, label=text, **look))
    if first_scan.starts > 1:
        found.append(Line2D([], [], color=RESONANCE, linewidth=0.5, label="sweep down"))
    if any(curve.shade for curve in request.curves):
        found.append(Patch(facecolor=IMPACTS, edgecolor="#c9bd78", linewidth=0.4, label="impacts"))
        bound = {**BOUND, "linestyle": (0, (3, 2))}  # short enough for the legend
        found.append(Line2D([], [], label="bound of a window without", **bound))
    if request.axis == "omega" and any(_own_frequency(curve) for curve in request.curves):
        found.append(Line2D([], [], label=r"$\omega_0=\sqrt{k_1/m_1}$", **_resonance_look(request)))
    return found


def _resonance_look(request: CurvePage) -> dict[str, Any]:
    """Return how a legend shows omega0: as a line, or as the tick of a curve."""
    if all(len(own_frequencies(panel.curves)) < 2 for panel in request.panels):
        return {"color": RESONANCE, "linewidth": 0.7}
    return {"color": RESONANCE, "linestyle": "none", "marker": "|", "markersize": 7}


def _curve_label(curve: Curve) -> str:
    """Return what the legend calls a curve: its label, what is set, or its system's title."""
    settings = [setting_label(name, value) for name, value in curve.settings.items()]
    return typeset(curve.label) or ", ".join(settings) or typeset(label_of(curve))


def look_of(curve: Curve) -> dict[str, Any]:
    """Return how a curve is drawn: the base stronger, and over the others."""
    return {
        "color": curve.color,
        "linestyle": curve.line,
        "linewidth": 1.5 if curve.base else 1.0,
        "zorder": 3.5 if curve.base else 3.0,
    }


def own_frequencies(curves: Sequence[Curve]) -> dict[float, str]:
    """Return the structures' own frequencies [rad/s] of curves, each with a color."""
    found = {_own_frequency(curve): curve.color for curve in curves}
    return {place: color for place, color in found.items() if place}


def _own_frequency(curve: Curve) -> float:
    """Return omega0 = sqrt(k1 / m1) of the structure in a curve's system [rad/s]; 0 for none."""
    p = curve.scan.system.parameters
    return sqrt(p["k1"] / p["m1"]) if "k1" in p else 0.0
