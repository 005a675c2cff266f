"""The picture of response curves: quantities along a parameter, case by case (Figures 2 to 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import ceil, sqrt
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import CARETDOWN
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.response_curves import (
    ENERGY,
    REDUCTION,
    Case,
    CurveRequest,
    ResponseCurve,
    ResponseCurves,
    curves_of,
)
from nlds_vines.model.catalog import without_hosts
from nlds_vines.model.labels import FLAGS, is_struck
from nlds_vines.model.linear_response import harmonic_energy
from nlds_vines.model.parameters import flat
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.plotting.bands import bands, one_regime
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    letter,
    new_figure,
    styled,
    write_letters,
    write_out_ticks,
)
from nlds_vines.plotting.style import CM, DOT, axis_label, quantity_label, setting_label, typeset

IMPACTS = "#fff7c2"  # the color of values with impacts: light yellow, as in Figure 2b
RESONANCE = "#444444"  # the color of the structure's natural frequency
BASE = "#b03a00"  # the color of the title of the panel that shows the original tuning

_HEIGHTS = {1: 7.2 * CM, 2: 4.9 * CM, 3: 5.4 * CM, 4: 4.2 * CM}  # inches, of a panel, by columns
_NARROW, _LOWER = 4.6 * CM, 3.6 * CM  # inches: a panel in one column of a paper; the reduction
_DOTTED = (0, (1, 1.6))  # the line of E2max: lengths of dot and gap
_BOUND: dict[str, Any] = {
    "color": "#666666", "linewidth": 0.6, "linestyle": (0, (4, 2)), "zorder": 1,
}  # fmt: skip
_NARROW_BOUND = _BOUND | {"linewidth": 0.45, "linestyle": "solid"}
_MANIFOLD: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 4}
_WINDOW: dict[str, Any] = {"alpha": 0.13, "linewidth": 0, "zorder": 0.5}
_LEAST_REDUCTION = -100.0  # percent: the lower end of the panel of reductions
_VISIBLE = 0.008  # of the axis: a narrower window has one line in place of two bounds
_THIN = 0.5  # of the width of a curve: that of its sweep down
_ALIKE = 0.01  # of the largest value: the difference of two sweeps that count as one
_MOST_MARKS = 40  # of values below an axis, along a curve
_HEADROOM, _MARGIN = 1.1, 1.5  # factors from the curves to the ends of a linear, a logarithmic axis
_MODULATED = [FLAGS[word] for word in ("quasiperiodic", "chaotic")]
_OF_HARMONIC: Mapping[str, Callable[..., Any]] = {
    "E1max": harmonic_energy,
    "x1_max": lambda m1, k1, omega, x: x,
    "v1_max": lambda m1, k1, omega, x: omega * x,
}  # of a harmonic motion of m1 on k1 with the frequency omega and the amplitude x


@styled()
def draw_curves(
    results: ResponseCurves, page: Page = TWO_COLUMNS, show: Sequence[str] = ()
) -> Figure:
    """Return the figure of response curves; `show` are panels of `panels_of`, None: `usual_of`.

    A second sweep is a thinner line.  Where it differs from the first, and where a response is
    quasiperiodic or chaotic, the panel is shaded in the curve's color.  Where a shaded case has
    impacts, the panel is light yellow, and windows without impacts are white.
    """
    request = results.request
    names = list(show or usual_of(request))
    upper = [name for name in names if name != REDUCTION]
    several, alike = len(request.panels) > 1, len(request.show) == 1
    columns = min(request.columns if page.beside else 1, len(upper) or 1)
    heights = [_HEIGHTS[columns] if page.beside else _NARROW] * ceil(len(upper) / columns)
    figure, grid = new_figure(page, heights + [_LOWER] * (REDUCTION in names), columns)
    frames: list[Axes] = []
    for index, name in enumerate(names):
        place = grid[-1, :] if name == REDUCTION else grid[divmod(index, columns)]
        first = frames[0] if frames else None
        shares = first if alike and name != REDUCTION else None
        frame = figure.add_subplot(place, sharex=first, sharey=shares)
        _fill_panel(frame, results, name)
        if index + columns < len(names) or REDUCTION in names[index + 1 :]:
            frame.tick_params(labelbottom=False)
        else:
            label = axis_label(request.axis)
            frame.set_xlabel(label if columns == 1 else label.rpartition("force ")[2])
        if alike and index % columns:
            frame.tick_params(labelleft=False)
            frame.set_ylabel("")
        if several:
            panel = request.panels[list(panels_of(request)).index(name)]
            title = typeset(panel.title) or _in_latex(panel.settings)
            title = f"{letter(index)}  {title}" + (" (tuning)" if panel.base else "")
            color = BASE if panel.base else "black"
            frame.set_title(title, loc="left", pad=3, fontsize=8.5, color=color)
        frames.append(frame)
    if alike and upper:
        _limit_ordinate(frames[0], frames[: len(upper)], request)
    if not several:
        write_letters(frames)
    top = frames[0]
    if columns > 1:  # the legend is as wide as all panels side by side
        top = figure.add_subplot(grid[0, :])
        top.set_axis_off()
    room = LETTER_ROOM if several or len(names) > 1 else 0.0
    add_legend(top, [*legend_of(request)], "above", room, handlelength=2.2)
    finish(figure, grid, request.title)
    return figure


def panels_of(request: CurveRequest) -> dict[str, str]:
    """Return the meaning of each panel by name: quantities, or a, b ...; the reduction."""
    words = {name: _title(name, request.body) for name in request.show}
    if len(request.panels) > 1:
        title = words[request.show[0]]
        return {letter(i)[1:-1]: one.title or title for i, one in enumerate(request.panels)}
    if request.show == (ENERGY,):
        words = {"energies": "largest energies"}
    is_damped = any(case.scan.system.scene.damper for case in request.cases)
    return words | ({REDUCTION: "reduction by each damper"} if is_damped else {})


def _title(shown: str, body: str) -> str:
    part, _, name = shown.rpartition(".")
    return ", ".join(filter(None, (BY_NAME[name].title(body), part)))


def usual_of(request: CurveRequest) -> list[str]:
    return [name for name in panels_of(request) if name != REDUCTION or request.reduction]


def _fill_panel(frame: Axes, results: ResponseCurves, name: str) -> None:
    request = results.request
    place = list(panels_of(request)).index(name)
    panel = place + 1 if len(request.panels) > 1 else 1
    curves = [curve for curve in results.curves if curve.case.panel == panel]
    if request.values.size > 1:
        frame.set_xlim(*request.values[[0, -1]])
    frame.tick_params(top=True, right=True)
    if name == REDUCTION:  # by each damper in percent, from -100 % on; zero is marked
        frame.axhline(0, color=RESONANCE, linewidth=0.7, zorder=2)
        curves = [curve for curve in curves if REDUCTION in curve.numbers]
        curves = [curve for curve in curves if curve.case.scan.system.scene.damper]
        for curve in curves:
            _draw_curve(frame, curve, 100 * curve.numbers[REDUCTION], _look_of(curve.case))
        low, high = frame.get_ylim()
        frame.set_ylim(max(low, _LEAST_REDUCTION), min(high, 105))
        below = [(c, c.values[100 * c[REDUCTION] < _LEAST_REDUCTION]) for c in curves]
        _mark_below(frame, below, f"below \N{MINUS SIGN}{-_LEAST_REDUCTION:g} %")
        frame.set_ylabel("reduction [%]")
        return
    shown = request.show[place if len(request.show) > 1 else 0]
    for curve in curves:
        _shade(frame, curve, shown)
    natural = _natural_frequencies([curve.case for curve in curves], request)
    for frequency, color in natural.items():  # one line, or a tick for each of several
        line: dict[str, Any] = {"color": RESONANCE, "linewidth": 0.7}
        if len(natural) > 1:
            line = {"color": color, "linewidth": 1.2, "ymin": 0.94}
        frame.axvline(frequency, zorder=2, **line)
    with_damper = shown == ENERGY and request.damper_energy
    for curve in curves:
        look, numbers = _look_of(curve.case), curve.numbers
        for start in range(curve.case.scan.starts if shown in numbers else 0):
            width = look["linewidth"] * (_THIN if start else 1.0)
            _draw_curve(frame, curve, numbers[shown], look | {"linewidth": width}, start)
        has_damper = with_damper and curve.case.scan.system.scene.damper
        for name in numbers if has_damper else ():
            if name.rpartition(".")[2] == "E2max":  # of each damper
                _draw_curve(frame, curve, numbers[name], look | {"linestyle": _DOTTED})
    quantity = BY_NAME[shown.rpartition(".")[2]]
    up = quantity_label(shown, quantity.unit, quantity.words, request.body)
    if with_damper:
        up = r"largest energies $E_1^{\,\mathrm{max}}, E_2^{\,\mathrm{max}}$ [J]"
    frame.set_ylabel(up)
    _limit_ordinate(frame, [frame], request)
    if request.log:
        recorded = [curve for curve in curves if shown in curve.numbers]
        _mark_below(frame, [(c, c.values[c[shown] <= 0.0]) for c in recorded], "zero")
    for case in (curve.case for curve in curves if request.manifold and shown in _OF_HARMONIC):
        if (manifold := case.manifold) is not None:
            across, amplitude = manifold.response().outline
            m1, k1, _ = without_hosts(case.scan.system).structure
            look = _MANIFOLD | {"color": case.color, "scalex": False, "scaley": False}
            frame.plot(across, _OF_HARMONIC[shown](m1, k1, across, amplitude), **look)


def _draw_curve(
    frame: Axes, curve: ResponseCurve, ups: np.ndarray, look: Mapping[str, Any], start: int = 0
) -> None:
    """Draw numbers (n, starts): lines within regimes, dots for single orbits."""
    cycles = curve.cycles(start)
    if not cycles.size:
        frame.plot(curve.values, ups[:, start], **look)
        return
    line, single = one_regime(curve.values, ups[:, start], cycles)
    frame.plot(*line, **look)
    if single.size:
        dots = {key: look[key] for key in ("color", "zorder")}
        frame.plot(*single, markersize=2 * look["linewidth"], **DOT | dots)


def _limit_ordinate(frame: Axes, alike: Sequence[Axes], request: CurveRequest) -> None:
    """Let the ordinate of a panel start at zero, or at the least value if it is logarithmic."""
    high = max(one.dataLim.y1 for one in alike)
    if not request.log:
        frame.set_ylim(0, _HEADROOM * high)
        return
    frame.set_yscale("log")
    low = min(one.dataLim.minposy for one in alike)
    if np.isfinite(low) and high > 0:
        frame.set_ylim(low / _MARGIN, high * _MARGIN)
        write_out_ticks(frame.yaxis)


def _mark_below(frame: Axes, below: Sequence[tuple[ResponseCurve, np.ndarray]], words: str) -> None:
    """Mark the values at which curves lie below a panel; `words` say so in the panel."""
    look: dict[str, Any] = {"markersize": 3.0, "clip_on": False, "zorder": 5, "marker": CARETDOWN}
    look |= {"linestyle": "none", "transform": frame.get_xaxis_transform()}
    for curve, values in below:
        if values.size:
            few = values[:: max(1, values.size // _MOST_MARKS)]
            frame.plot(few, np.zeros(few.size), color=curve.case.color, **look)
    if any(values.size for _, values in below):
        text = f"\N{BLACK DOWN-POINTING TRIANGLE} {words}"
        at: dict[str, Any] = {"transform": frame.transAxes, "va": "bottom", "zorder": 5}
        frame.text(0.01, 0.05, text, fontsize=7, **at)


def _shade(frame: Axes, curve: ResponseCurve, name: str) -> None:
    """Shade impacts, sweeps that differ in value or nT,k, and irregular responses."""
    values = curve.values
    if curve.case.shade and "impact_count" in curve.numbers:
        words = np.where(is_struck(curve.numbers)[:, 0], "impacts", "none")
        for band in bands(values, words):
            if band.label == "impacts":
                frame.axvspan(band.low, band.high, color=IMPACTS, linewidth=0, zorder=0)
            elif band.width >= _VISIBLE * (values[-1] - values[0]):
                frame.axvline(band.low, **_BOUND)
                frame.axvline(band.high, **_BOUND)
            else:
                frame.axvline(band.center, **_NARROW_BOUND)
    windows = np.zeros(values.size, dtype=bool)
    if "regime" in curve.numbers:
        windows |= np.isin(curve["regime"], _MODULATED)
    if name in curve.numbers and curve.case.scan.starts > 1:
        up, down = curve.numbers[name].T
        windows |= np.abs(up - down) > _ALIKE * float(np.nanmax(np.fmax(up, down), initial=0.0))
        if (cycles := curve.cycles()).size:
            windows |= cycles != curve.cycles(1)
    for band in bands(values, np.where(windows, "shaded", "")):
        if band.label:
            frame.axvspan(band.low, band.high, color=curve.case.color, **_WINDOW)


def _natural_frequencies(cases: Sequence[Case], request: CurveRequest) -> dict[float, str]:
    """Return the different sqrt(k1 / m1) [rad/s] on an axis of omega, each with a case's color."""
    parameters = [(case.scan.system.parameters, case.color) for case in cases]
    frequencies = {sqrt(p["k1"] / p["m1"]): color for p, color in parameters if p.get("k1")}
    return frequencies if request.axis == "omega" else {}


def _in_latex(settings: Mapping[str, Any] | None) -> str:
    return ", ".join(setting_label(name, value) for name, value in flat(settings or {}).items())


def _look_of(case: Case) -> dict[str, Any]:
    width, order = (1.5, 3.5) if case.base else (1.0, 3.0)
    return {"color": case.color, "linestyle": case.line, "linewidth": width, "zorder": order}


def legend_of(request: CurveRequest) -> Iterator[Any]:
    cases = request.cases
    for case in cases:
        if case.panel == 1:
            label = typeset(case.label) or _in_latex(case.settings) or typeset(case.title)
            yield Line2D([], [], label=label, **_look_of(case))
    if request.damper_energy:
        text = r"$E_2^{\,\mathrm{max}}$ of a damper"
        yield Line2D([], [], color=RESONANCE, linestyle=_DOTTED, label=text)
    if request.manifold:
        look = _MANIFOLD | {"color": RESONANCE}
        yield Line2D([], [], label="1:1 motion in closed form", **look)
    two_sweeps = cases[0].scan.starts > 1
    modulated = any("regime" in case.scan.want for case in cases)
    words = ["sweeps differ"] * two_sweeps + ["quasiperiodic or chaotic"] * modulated
    if words:
        look = _WINDOW | {"alpha": 0.25}
        yield Patch(facecolor=RESONANCE, label=f"shaded: {', or '.join(words)}", **look)
    if two_sweeps:
        yield Line2D([], [], color=RESONANCE, linewidth=0.5, label="sweep down")
    if any(case.shade for case in cases):
        yield Patch(facecolor=IMPACTS, edgecolor="#c9bd78", linewidth=0.4, label="impacts")
        bound = _BOUND | {"linestyle": (0, (3, 2))}  # short enough for the legend
        yield Line2D([], [], label="bound of a window without", **bound)
    if _natural_frequencies(cases, request):
        numbers = range(1, len(request.panels) + 1)
        panels = [[case for case in cases if case.panel == i] for i in numbers]
        look = {"linewidth": 0.7}
        if any(len(_natural_frequencies(panel, request)) > 1 for panel in panels):
            look = {"linestyle": "none", "marker": "|", "markersize": 7}
        yield Line2D([], [], label=r"$\omega_0=\sqrt{k_1/m_1}$", color=RESONANCE, **look)


def _fill(axes: Axes, view: ArchiveView, name: str) -> None:
    results = curves_of(view)
    _fill_panel(axes, results, name)
    axes.set_xlabel(axis_label(results.request.axis))
    axes.legend(handles=[*legend_of(results.request)])


PICTURE = Picture(
    panels=lambda view: panels_of(curves_of(view).request),
    draw=lambda view, names, page: draw_curves(curves_of(view), page, names),
    fill=_fill,
    usual=lambda view: usual_of(curves_of(view).request),
)
"""Draws an archive of response curves."""
