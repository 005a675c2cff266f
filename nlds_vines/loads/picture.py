"""Pictures of response histories: energy, motion, where the energy went, sweeps; and of scans.

A scan of loads is drawn as a number over one axis, of each damper, or as a map for each damper.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.errors import RequestError
from nlds_vines.loads.request import (
    HistoryRequest,
    axis_words,
    load_response_history,
    natural_period,
)
from nlds_vines.loads.result import (
    Fall,
    LoadScan,
    ResponseHistories,
    closed_form,
    histories_in,
    shares_of,
)
from nlds_vines.model.linear_response import harmonic_energy, response
from nlds_vines.model.load_quantities import BY_NAME, OF_LOADS, SHARES, WAYS
from nlds_vines.model.loads.courses import Sweep
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantity import ERROR
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.records import STATUS
from nlds_vines.plotting.bands import edges, logarithmic
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import in_latex, raised, typeset
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    new_figure,
    styled,
    write_letters,
)
from nlds_vines.plotting.palette import damper_colors
from nlds_vines.plotting.style import CM, GRAY, HUES, NO_VALUE, SHADES, axis_label

_PANEL, _BARS = 4.8 * CM, 0.75 * CM  # inches, heights of a panel and of the bar of a damper
_MAP = 5.0 * CM  # inches
_NAME = 18  # characters of a line of a name beside a bar
_LINES = ("solid", "dashed", "dashdot", "dotted")
_EXACT: dict[str, Any] = {"color": GRAY, "linewidth": 0.6, "zorder": 0}  # of a closed form
_WAYS = dict(zip(WAYS, ("blue", "sky", "vermillion"), strict=True))
SWEEP_ENERGY = "sweep_energy"
"""The panel beside whose sweeps branches are drawn: archives of branches have E1max."""

_DOTS: dict[str, Any] = {"marker": "o", "markersize": 3.2, "linestyle": "none", "mfc": "white"}
_OVER_TIME = {"energy", "motion", "damper"}  # panels
_LEAST = 1e-4  # of the largest E1 of all dampers: the lower end of the axis


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return what the panels show, by name; of a scan its numbers."""
    request = view.request(RESPONSE_HISTORY, load_response_history)
    if request.vary:
        return {entry.name: entry.words for entry in OF_LOADS if entry.name in view}
    found = {
        "energy": "energy of the structure over time",
        "motion": "displacement of the structure over time",
        "damper": "share of the energy that damper and contacts have dissipated, over time",
        "shares": "where the energy went",
    }
    if request.load.sweep:
        found["sweep"] = "displacement over the frequency of a sweep"
        found[SWEEP_ENERGY] = "energy of the structure over the frequency of a sweep"
    return found


def usual(view: ArchiveView) -> list[str]:
    """Return the panels of the usual picture; of a scan the first number that changes over it."""
    names = [*panels(view)]
    if _drawable(view).request.vary:
        changing = (n for n in names if np.ptp(view[n][np.isfinite(view[n])]) > 0.0)
        return [next(changing, names[0])]
    return ["sweep"] if "sweep" in names else ["energy", "shares"]


@styled()
def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the figure of an archive with the panels that are `shown`."""
    found = _drawable(view)
    request = found.request
    if isinstance(found, LoadScan) and len(request.vary) == 2:
        return _maps(found, shown, page)
    bars = _BARS * (len(request.systems) + 0.4)
    figure, grid = new_figure(page, [bars if name == "shares" else _PANEL for name in shown])
    places = [figure.add_subplot(grid[i], label=name) for i, name in enumerate(shown)]
    lift = LETTER_ROOM if len(places) > 1 else 0
    for axes, name in zip(places, shown, strict=True):
        _draw_panel(axes, found, name)
    for above, below in pairwise(places):
        if {above.get_label(), below.get_label()} <= _OVER_TIME:
            below.sharex(above)
            above.tick_params(labelbottom=False)
            above.set_xlabel("")
    if places[0].get_legend() is None:
        handles, _ = places[0].get_legend_handles_labels()
        add_legend(places[0], handles, "above", lift, handlelength=2.2)
    write_letters(places)
    finish(figure, grid, request.title)
    return figure


def fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel into given axes; of maps that of the first damper."""
    found = _drawable(view)
    if isinstance(found, LoadScan) and len(found.request.vary) == 2:
        axes.figure.colorbar(_map(axes, found, name, 0), ax=axes, label=_label(name))
    else:
        _draw_panel(axes, found, name)
        if axes.get_legend() is None:
            axes.legend()


def _draw_panel(axes: Axes, found: ResponseHistories | LoadScan, name: str) -> None:
    if isinstance(found, ResponseHistories):
        _FILL[name](axes, found)
    else:
        _curves(axes, found, name)


def _drawable(view: ArchiveView) -> ResponseHistories | LoadScan:
    """Return what an archive holds; `RequestError` where every orbit failed."""
    found = histories_in(view.path)
    if found.failed == found.request.cases:
        status = STATUS[int(view["status"].flat[0])]
        raise RequestError(f"{view.path}: every orbit failed: {status.name}. {status.remedy}")
    return found


def _looks(request: HistoryRequest) -> Iterator[tuple[System, dict[str, Any]]]:
    """Yield each system and how it is drawn."""
    colors = damper_colors([system.name for system in request.systems])
    for i, (system, color) in enumerate(zip(request.systems, colors, strict=True)):
        look = {"color": color, "linestyle": _LINES[i % len(_LINES)], "linewidth": 1.0}
        yield system, {"label": typeset(system_in_words(system)), **look}


def _each(found: ResponseHistories) -> Iterator[tuple[System, Fall, dict[str, Any]]]:
    """Yield each system, its response, and how it is drawn."""
    for (system, look), fall in zip(_looks(found.request), found.results.values(), strict=True):
        yield system, fall, look


def _energy(axes: Axes, found: ResponseHistories) -> None:
    """Draw E1 on a logarithmic axis, with dots at the last times at shares of its largest."""
    shares = ", ".join(f"{100 * share:g}" for share in reversed(SHARES))
    words = f"last time at {shares} % of its largest"
    largest = 0.0
    for _, fall, look in _each(found):
        axes.semilogy(fall.time, fall.E1, **look)
        top = fall.numbers["E1max"]
        largest = max(largest, top)
        dots = {**_DOTS, "color": look["color"], "label": None}
        axes.plot(fall.last, top * np.array(SHARES), **dots)
    axes.plot([], [], color=GRAY, **{**_DOTS, "label": words})
    axes.set(ylim=(_LEAST * largest, 2.0 * largest), ylabel="energy $E_1$ [J]")
    _over_time(axes, found.request)


def _motion(axes: Axes, found: ResponseHistories) -> None:
    """Draw the displacement of the structure."""
    for _, fall, look in _each(found):
        axes.plot(fall.time, fall.x1, **look)
    _over_time(axes, found.request)
    frame = " relative to the ground" if found.request.load.shaken else ""
    axes.set_ylabel(f"displacement $x_1${frame} [m]")


def _damper(axes: Axes, found: ResponseHistories) -> None:
    """Draw what the damper's dashpot and the contacts have dissipated, of all that came in."""
    for _, fall, look in _each(found):
        gone = np.nan_to_num(fall.dissipated["c2"]) + np.nan_to_num(fall.dissipated["contact"])
        if gone.any():
            axes.plot(fall.time, gone / fall.numbers["energy_in"], **look)
    _over_time(axes, found.request)
    axes.set(ylim=(0, 1), ylabel="by damper and contacts")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


def _over_time(axes: Axes, request: HistoryRequest) -> None:
    axes.set(xlim=(0, request.duration), xlabel="time $t$ [s]")


def _sweep(axes: Axes, found: ResponseHistories) -> None:
    """Draw the largest displacement in each natural period over the frequency of each sweep."""
    _over_frequency(axes, found, energy=False)
    axes.set_ylabel("largest $|x_1|$ [m]")


def _sweep_energy(axes: Axes, found: ResponseHistories) -> None:
    """Draw the largest energy in each natural period over the frequency of each sweep."""
    _over_frequency(axes, found, energy=True)
    axes.set_ylabel("largest $E_1$ [J]")


def _over_frequency(axes: Axes, found: ResponseHistories, energy: bool) -> None:
    """Draw what is largest in each natural period over the frequency of each sweep at that time.

    A sweep that goes down is dotted.  Of systems without walls the steady response stands beside
    it, in closed form.
    """
    request = found.request
    steady_words: str | None = "steady, in closed form"
    for system, fall, look in _each(found):
        values = fall.E1 if energy else np.abs(fall.x1)
        for sweep in request.load.sweeps:
            omega, largest = envelope(sweep, fall.time, values, natural_period(system))
            down = sweep.last < sweep.first
            axes.plot(omega, largest, **{**look, **({"linestyle": ":"} if down else {})})
            look["label"] = None
    if len({sweep.last < sweep.first for sweep in request.load.sweeps}) > 1:
        axes.plot([], [], color=GRAY, linestyle=":", linewidth=1.0, label="sweep down")
    for system, _, _ in _each(found):
        if not system.scene.walls and not request.load.shaken:
            sweep = request.load.sweeps[0]
            omega = np.linspace(min(sweep.first, sweep.last), max(sweep.first, sweep.last), 400)
            steady = np.abs(response(system.with_(P=request.load.force_of(sweep)), omega).X1)
            m1, k1, _ = system.structure
            values = harmonic_energy(m1, k1, omega, steady) if energy else steady
            axes.plot(omega, values, label=steady_words, **_EXACT)
            steady_words = None
    axes.set(xlabel="frequency $\\omega$ of the sweep [rad/s]", ylim=(0, None))


def envelope(
    sweep: Sweep, time: np.ndarray, values: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency [rad/s] and largest value of each natural period of a sweep."""
    edges = np.arange(sweep.at, min(sweep.at + sweep.length, time[-1]), period)
    largest = np.maximum.reduceat(values, np.searchsorted(time, edges))[:-1]
    return sweep.omegas(0.5 * (edges[:-1] + edges[1:])), largest


def _shares(axes: Axes, found: ResponseHistories) -> None:
    """Draw a bar for each damper: the shares of the energy by what has dissipated them."""
    words = map(system_in_words, found.request.systems)
    names = ["\n".join(map(typeset, textwrap.wrap(name, _NAME))) for name in words]
    shares = [shares_of(fall) for fall in found.results.values()]
    left = [0.0] * len(names)
    for way in WAYS:
        widths = [max(0.0, one.get(way, 0.0)) for one in shares]
        if any(width > 0.0005 for width in widths):
            kind = {"c1": "dashpot $c_1$", "c2": "dashpot $c_2$", "contact": "contacts"}[way]
            axes.barh(names, widths, left=left, color=HUES[_WAYS[way]], label=kind)
            left = [a + b for a, b in zip(left, widths, strict=True)]
    still = [max(0.0, 1.0 - done) for done in left]
    if any(share > 0.0005 for share in still):
        axes.barh(names, still, left=left, color=NO_VALUE, label="still there")
    axes.invert_yaxis()
    axes.set(xlim=(0, 1), xlabel="share of the energy that came in")
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    add_legend(axes, axes.get_legend_handles_labels()[0], "above", LETTER_ROOM)


# ---- scans ---------------------------------------------------------------------------------------


def _maps(found: LoadScan, shown: Sequence[str], page: Page) -> Figure:
    """Return a figure with a map for each number and damper, those of a number side by side."""
    count = len(found.request.systems)
    across = min(count, 2 if page.beside else 1)
    rows = -(-count // across)
    figure, grid = new_figure(page, [_MAP] * (rows * len(shown)), across)
    places: list[Axes] = []
    for number, name in enumerate(shown):
        cells = [divmod(place, across) for place in range(count)]
        row = [figure.add_subplot(grid[number * rows + r, c]) for r, c in cells]
        meshes = [_map(axes, found, name, damper) for damper, axes in enumerate(row)]
        for place, axes in enumerate(row):
            if place + across < count:
                axes.tick_params(labelbottom=False)
                axes.set_xlabel("")
            if place % across:
                axes.tick_params(labelleft=False)
                axes.set_ylabel("")
        figure.colorbar(
            meshes[0], ax=row, label=_label(name), pad=0.02, fraction=0.06, aspect=20 * rows
        )
        places += row
    write_letters(places)
    finish(figure, grid, found.request.title)
    return figure


def _curves(axes: Axes, found: LoadScan, name: str) -> None:
    """Draw a number over the axis of a scan, of each damper; in closed form if there is one."""
    request = found.request
    (axis,) = request.vary
    words: str | None = "in closed form"
    pairs = zip(_looks(request), found.numbers[name], strict=True)
    for i, ((_, look), values) in enumerate(pairs):
        axes.plot(axis.values, values, **look)
        cases = (request.case(i * axis.values.size + j) for j in range(axis.values.size))
        exact = [closed_form(*case).get(name, np.nan) for case in cases if not request.state]
        if np.isfinite(exact).any():
            axes.plot(axis.values, exact, label=words, **_EXACT)
            words = None
    axes.set(xlabel=_axis(found, 0), ylabel=_label(name))
    if logarithmic(axis.values):
        axes.set_xscale("log")
    if BY_NAME[name].scale == ERROR:
        axes.set_yscale("log")


def _map(axes: Axes, found: LoadScan, name: str, damper: int) -> QuadMesh:
    """Fill a map of a damper; all maps of a number have the same shades."""
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


_FILL: Mapping[str, Callable[[Axes, ResponseHistories], None]] = {
    "energy": _energy,
    "motion": _motion,
    "damper": _damper,
    "shares": _shares,
    "sweep": _sweep,
    SWEEP_ENERGY: _sweep_energy,
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
