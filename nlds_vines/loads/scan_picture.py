"""Pictures of a scan of loads: a number over one axis, of each damper; or a map of each."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.loads.closed_form import closed_form
from nlds_vines.loads.result import LoadScan
from nlds_vines.loads.run import axis_words
from nlds_vines.model.load_quantities import BY_NAME, OF_LOADS
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantity import ERROR
from nlds_vines.model.words import system_in_words
from nlds_vines.plotting.bands import edges, logarithmic
from nlds_vines.plotting.notation import in_latex, raised, typeset
from nlds_vines.plotting.page import Page, write_letters
from nlds_vines.plotting.style import CM, GRAY, HUES, NO_VALUE, SHADES, axis_label

_LINES = ("solid", "dashed", "dashdot", "dotted")
_COLORS = [HUES[name] for name in ("black", "vermillion", "blue", "green", "orange", "pink")]
EXACT: dict[str, Any] = {"color": GRAY, "linewidth": 0.6, "zorder": 0}
"""How a closed form is drawn."""

_HEIGHT = 6.0 * CM  # inches, of a panel
_ACROSS = 2  # maps side by side
_LINE = 95  # characters of a line of a title


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return the numbers that a scan holds, with their meanings."""
    return {entry.name: entry.words for entry in OF_LOADS if entry.name in view}


def usual(view: ArchiveView) -> list[str]:
    """Return the first number that changes over the scan."""
    told = (name for name in panels(view) if np.ptp(view[name][np.isfinite(view[name])]) > 0.0)
    return [next(told, next(iter(panels(view))))]


def entitle(figure: Figure, title: str) -> None:
    """Write a title, on several lines where it is long."""
    lines = textwrap.wrap(title, _LINE) or [""]
    figure.suptitle("\n".join(map(typeset, lines)), x=0.01, ha="left", fontsize=9)
    figure.set_figheight(figure.get_figheight() + (len(lines) - 1) * 0.45 * CM)


def look(number: int) -> dict[str, Any]:
    """Return color and line of a damper, by its place among them."""
    return {
        "color": _COLORS[number % len(_COLORS)],
        "linestyle": _LINES[number % len(_LINES)],
    }


def draw(found: LoadScan, shown: Sequence[str], page: Page) -> Figure:
    """Return the figure of a scan: a panel for each number, of two axes a map for each damper."""
    request = found.request
    maps = len(request.vary) == 2
    count = len(shown) * (len(request.systems) if maps else 1)
    across = min(_ACROSS, count) if maps else 1
    down = -(-count // across)
    figure = Figure(figsize=(page.width, down * _HEIGHT + 1.0 * CM), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    places = list(grid.flat)
    for axes in places[count:]:
        axes.set_axis_off()
    if maps:
        for number, name in enumerate(shown):
            row = places[number * len(request.systems) :][: len(request.systems)]
            meshes = [_map(axes, found, name, i) for i, axes in enumerate(row)]
            figure.colorbar(meshes[0], ax=row, label=_label(name))
    else:
        for name, axes in zip(shown, places, strict=False):
            _lines(axes, found, name)
    write_letters(places[:count])
    entitle(figure, request.title)
    return figure


def fill(axes: Axes, found: LoadScan, name: str) -> None:
    """Draw one number into given axes; of a map that of the first damper."""
    if len(found.request.vary) == 2:
        _map(axes, found, name, 0)
    else:
        _lines(axes, found, name)


def _lines(axes: Axes, found: LoadScan, name: str) -> None:
    request = found.request
    (axis,) = request.vary
    words: str | None = "in closed form"
    for i, (system, values) in enumerate(zip(request.systems, found.numbers[name], strict=True)):
        label = typeset(system_in_words(system))
        axes.plot(axis.values, values, label=label, linewidth=1.0, **look(i))
        cases = (request.case(i * axis.values.size + j) for j in range(axis.values.size))
        exact = [closed_form(*case).get(name, np.nan) for case in cases if not request.state]
        if np.isfinite(exact).any():
            axes.plot(axis.values, exact, label=words, **EXACT)
            words = None
    axes.set(xlabel=_axis(found, 0), ylabel=_label(name))
    if logarithmic(axis.values):
        axes.set_xscale("log")
    if BY_NAME[name].scale == ERROR:
        axes.set_yscale("log")
    axes.legend()


def _map(axes: Axes, found: LoadScan, name: str, damper: int) -> QuadMesh:
    """Fill a map of a damper; all of a number have the same shades."""
    x, y = found.request.vary
    values, every = found.numbers[name][damper], found.numbers[name]
    told = every[np.isfinite(every)]
    low, high = (told.min(), told.max()) if told.size else (0.0, 1.0)
    norm: dict[str, Any] = {"vmin": low, "vmax": high}
    if BY_NAME[name].scale == ERROR and low > 0.0:
        norm = {"norm": LogNorm(low, high)}
    axes.set_facecolor(NO_VALUE)
    mesh = axes.pcolormesh(
        edges(x.values), edges(y.values), np.ma.masked_invalid(values.T), cmap=SHADES,
        rasterized=True, **norm,
    )  # fmt: skip
    for axis, values_of_it in (("x", x.values), ("y", y.values)):
        if logarithmic(values_of_it):
            getattr(axes, f"set_{axis}scale")("log")
    axes.set(xlabel=_axis(found, 0), ylabel=_axis(found, 1))
    axes.set_title(typeset(system_in_words(found.request.systems[damper])), fontsize=9)
    return mesh


def _axis(found: LoadScan, number: int) -> str:
    """Return what stands along an axis."""
    name = found.request.vary[number].name
    if name in DESCRIBED:
        return axis_label(name)
    unit, words = axis_words(found.request, name)
    return words + (f" [{raised(unit)}]" if unit != "1" else "")


def _label(name: str) -> str:
    """Return label, symbol and unit of a number."""
    entry = BY_NAME[name]
    symbol = f" ${in_latex(entry.symbol)}$" if entry.symbol else ""
    return entry.label + symbol + (f" [{raised(entry.unit)}]" if entry.unit != "1" else "")
