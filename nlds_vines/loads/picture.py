"""Pictures of response histories (energy, motion, dissipation, sweeps) and of scans of loads.

A scan is drawn as curves over one axis, one for each system, or as one map for each system.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
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
from nlds_vines.engine.records import STATUS
from nlds_vines.errors import RequestError
from nlds_vines.loads.datasets import named_owners, names_of_numbers
from nlds_vines.loads.request import (
    HistoryRequest,
    axis_words,
    load_response_history,
)
from nlds_vines.loads.response_spectrum import ResponseSpectrum
from nlds_vines.loads.result import (
    PEAKS,
    QUANTILE,
    LoadScan,
    Peak,
    ResponseHistories,
    ResponseHistory,
    histories_in,
    shares_of,
)
from nlds_vines.loads.units import Shown, shown_in
from nlds_vines.model.loads.courses import G, Sweep
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantities import ERROR, HISTORIES, SHARES, WAYS, of_load
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import edges, logarithmic
from nlds_vines.plotting.chosen_panels import Picture, let_figures_be_shown
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    TWO_COLUMNS,
    Page,
    add_legend,
    figure_of,
    finish,
    new_figure,
    styled,
    styled_for,
    write_letters,
)
from nlds_vines.plotting.palette import damper_colors
from nlds_vines.plotting.style import (
    CM,
    GRAY,
    HUES,
    NO_VALUE,
    SHADES,
    axis_label,
    in_latex,
    labeled,
    raised,
    typeset,
)

_PANEL, _BARS = 4.8 * CM, 0.75 * CM  # inches, heights of a panel and of the bar of a damper
_MAP = 5.0 * CM  # inches
_GROUP = 0.8  # share of bars in the length of a group of them and the gap behind it
_NAME = 18  # characters of a line of a name beside a bar
_MOST_BINS = 60
_MOST_NAMES = 12  # records of a suite whose names stand along an axis
_LINES = ("solid", "dashed", "dashdot", "dotted")
# in the legend; gray is the structure alone
_STATISTIC: dict[str, Any] = {"color": "black", "linewidth": 1.0}
_EXACT: dict[str, Any] = {"color": GRAY, "linewidth": 0.6, "zorder": 0}  # closed forms
_SINKS = dict(zip(WAYS, ("blue", "sky", "vermillion"), strict=True))
_DOTS: dict[str, Any] = {"marker": "o", "markersize": 3.2, "linestyle": "none", "mfc": "white"}
_OVER_TIME = {"energy", "motion", "damper"}  # panels with a common axis
_LEAST = 1e-4  # lower end of the axis, in units of the largest E1
SWEEP_ENERGY = "sweep_energy"  # the panel over which `--mark` draws branches
EXCEEDANCE = "exceedance"  # in the names of panels of samples: `x1_max:exceedance`


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return the panels of an archive with their meanings; those of a scan are its quantities."""
    request = view.request(RESPONSE_HISTORY, load_response_history)
    if request.is_scan:
        places = names_of_numbers(request).items()
        meanings = {k: of_load(k).words for k, (name, _) in places if name in view}
        if request.sampled is not None:
            for name, words in [*meanings.items()]:
                meanings[f"{name}:{EXCEEDANCE}"] = f"share of samples above each value of {words}"
                for column in request.columns:
                    meanings[f"{name}:{column}"] = f"{words}, against {column}"
        return meanings
    meanings = {"energy": "energy of the structure over time"}
    if "x1" in view:
        meanings |= {
            "motion": "displacement of the structure over time",
            "damper": "share of the energy that damper and contacts have dissipated, over time",
            "shares": "where the energy went",
        }
    for entry in HISTORIES.values():
        if entry.dims and entry.name in view:
            for owner in named_owners(request)[entry.dims[0]]:
                meanings[f"{owner}.{entry.name}"] = f"{entry.label} of {owner} over time"
    meanings["peaks"] = "largest responses, in their units and beside the structure alone"
    if request.load.sweep and "x1" in view:
        meanings["sweep"] = "displacement over the frequency of a sweep"
        meanings[SWEEP_ENERGY] = "energy of the structure over the frequency of a sweep"
    return meanings


def usual(view: ArchiveView) -> list[str]:
    """Return the panels that are drawn by default; of a scan the first quantity that varies."""
    names, results = [*panels(view)], _drawable(view)
    request = results.request
    if isinstance(results, LoadScan):
        finite = {name: _present(results, name) for name in results.numbers}
        quantities = [name for name in names if ":" not in name]
        changing = [n for n in quantities if finite[n].size and np.ptp(finite[n]) > 0.0]
        if results.loads:
            compared = [n for n in changing if n.rpartition(".")[2] in PEAKS]
            by_peak = sorted(compared, key=lambda n: PEAKS.index(n.rpartition(".")[2]))
            changing = by_peak[:1] + changing
        name = next(iter(changing), names[0])
        return [name] if request.sampled is None else [f"{name}:{EXCEEDANCE}", name]
    if "sweep" in names:
        return ["sweep"]
    displacement = [name for name in names if name.endswith(".x")][:1]
    if "motion" not in names:
        return [*displacement, "energy"]
    if displacement:  # of systems that have no x1
        return ["energy", "motion", *displacement, "shares"]
    return ["energy", "shares"]


@styled()
def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    results = _drawable(view)
    request = results.request
    if isinstance(results, LoadScan) and len(request.vary) == 2:
        return _maps(results, shown, page)
    bars = _BARS * (len(request.systems) + 0.4)
    heights = {}
    if isinstance(results, ResponseHistories):
        heights["shares"] = _BARS * (max(1, len(_with_shares(results))) + 0.4)
        length = _length_of_peaks(results.comparison(), len(request.systems))
        heights["peaks"] = max(_PANEL, 0.8 * bars * length)
    figure, grid = new_figure(page, [heights.get(name, _PANEL) for name in shown])
    places = [figure.add_subplot(grid[i], label=name) for i, name in enumerate(shown)]
    lift = LETTER_ROOM if len(places) > 1 else 0
    for axes, name in zip(places, shown, strict=True):
        _draw_panel(axes, results, name)
    for above, below in pairwise(places):
        if all(_is_over_time(str(place.get_label())) for place in (above, below)):
            below.sharex(above)
            above.tick_params(labelbottom=False)
            above.set_xlabel("")
    layout = figure.get_layout_engine()
    assert layout is not None
    layout.execute(figure)  # names beside bars narrow all panels, and legends with them
    for axes, name in zip(places, shown, strict=True):
        if axes is places[0] or name == "shares":
            others = [] if name == "shares" else [place for place in places if place is not axes]
            _add_legend(axes, name, lift, others)
    write_letters(places)
    finish(figure, grid, request.title)
    return figure


def fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel into `axes`; of several maps, that of the first system."""
    results = _drawable(view)
    if isinstance(results, LoadScan) and len(results.request.vary) == 2:
        axes.figure.colorbar(_map(axes, results, name, 0), ax=axes, label=_label(results, name))
    else:
        _draw_panel(axes, results, name)
        if name == "shares":
            _add_legend(axes, name)
        elif axes.get_legend() is None:
            axes.legend()


def _add_legend(axes: Axes, name: str, offset: float = 0.0, others: Sequence[Axes] = ()) -> None:
    """Add the legend of a panel, with the lines of other panels that it does not have."""
    handles, labels = axes.get_legend_handles_labels()
    for other in others:
        if other.get_label() == "shares":
            continue
        for handle, label in zip(*other.get_legend_handles_labels(), strict=True):
            if label not in labels:
                handles.append(handle)
                labels.append(label)
    length = 1.4 if name == "shares" else 2.2
    add_legend(axes, handles, "above", offset, handlelength=length)


def _draw_panel(axes: Axes, results: ResponseHistories | LoadScan, name: str) -> None:
    if isinstance(results, LoadScan) and results.request.sampled is not None:
        _samples(axes, results, name)
    elif isinstance(results, LoadScan) and not results.request.vary:
        _records(axes, results, name)
    elif isinstance(results, LoadScan):
        _curves(axes, results, name)
    else:
        _FILL.get(name, partial(_history, name=name))(axes, results)
        if _is_over_time(name):
            axes.set(xlim=(0, results.request.duration), xlabel="time $t$ [s]")


def _is_over_time(name: str) -> bool:
    return name in _OVER_TIME or name.rpartition(".")[2] in HISTORIES


def _drawable(view: ArchiveView) -> ResponseHistories | LoadScan:
    results = histories_in(view.path)
    if results.failed == results.request.cases:
        status = STATUS[int(view["status"].flat[0])]
        raise RequestError(f"{view.path}: every orbit failed: {status.name}. {status.remedy}")
    return results


def _looks(request: HistoryRequest) -> Iterator[tuple[System, dict[str, Any]]]:
    colors = damper_colors([system.name for system in request.systems])
    each = zip(request.systems, colors, request.words, strict=True)
    for i, (system, color, words) in enumerate(each):
        look = {"color": color, "linestyle": _LINES[i % len(_LINES)], "linewidth": 1.0}
        yield system, {"label": typeset(words), **look}


def _each(
    histories: ResponseHistories,
) -> Iterator[tuple[System, ResponseHistory, dict[str, Any]]]:
    looks = _looks(histories.request)
    for (system, look), history in zip(looks, histories.results.values(), strict=True):
        yield system, history, look


def _energy(axes: Axes, histories: ResponseHistories) -> None:
    """Draw E1 on a logarithmic axis, with dots at its last times at `SHARES` of its largest."""
    largest = 0.0
    for _, history, look in _each(histories):
        axes.semilogy(history.time, history.E1, **look)
        E1max = history.numbers["E1max"]
        largest = max(largest, E1max)
        dots = {**_DOTS, "color": look["color"], "label": None}
        axes.plot(history.last, E1max * np.array(SHARES), **dots)
    shares = ", ".join(f"{100 * share:g}" for share in reversed(SHARES))
    axes.plot([], [], color=GRAY, **{**_DOTS, "label": f"last time at {shares} % of its largest"})
    axes.set(ylim=(_LEAST * largest, 2.0 * largest), ylabel="energy $E_1$ [J]")


def _motion(axes: Axes, histories: ResponseHistories) -> None:
    for _, history, look in _each(histories):
        if np.isfinite(history.x1).any():
            axes.plot(history.time, history.x1, **look)
    frame = " relative to the ground" if histories.request.load.shaken else ""
    axes.set_ylabel(f"displacement $x_1${frame} [m]")


def _history(axes: Axes, histories: ResponseHistories, name: str) -> None:
    """Draw a history of a displacement or of a damper by its name."""
    owner, _, kind = name.rpartition(".")
    entry = HISTORIES[kind]
    factor, unit = 1.0, entry.unit
    if unit == "m/s^2" and histories.request.load.shaken:
        factor, unit = 1.0 / G, "g"
    for _, history, look in _each(histories):
        by_owner = getattr(history, kind)
        if isinstance(by_owner, Mapping) and np.isfinite(by_owner[owner]).any():
            axes.plot(history.time, by_owner[owner] * factor, **look)
    axes.set_ylabel(labeled(f"{entry.label} of {owner}", "", unit))


def _damper(axes: Axes, histories: ResponseHistories) -> None:
    for _, history, look in _each(histories):
        energy = sum(np.nan_to_num(history.dissipated[sink]) for sink in ("c2", "contact"))
        if np.any(energy):
            axes.plot(history.time, energy / history.numbers["energy_in"], **look)
    axes.set(ylim=(0, 1), ylabel="by damper and contacts")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


def _sweep(axes: Axes, histories: ResponseHistories, energy: bool = False) -> None:
    """Draw the largest displacement or energy in each natural period over a sweep's frequency."""
    request = histories.request
    for system, history, look in _each(histories):
        values = history.E1 if energy else np.abs(history.x1)
        if not np.isfinite(values).any():
            continue
        for sweep in request.load.sweep:
            omega, largest = envelope(sweep, history.time, values, system.natural_period)
            style = {"linestyle": ":"} if sweep.last < sweep.first else {}
            axes.plot(omega, largest, **{**look, **style})
            look["label"] = None
    if any(sweep.last < sweep.first for sweep in request.load.sweep):
        axes.plot([], [], color=GRAY, linestyle=":", linewidth=1.0, label="sweep down")
    words: str | None = "steady, in closed form"
    sweep = request.load.sweep[0]
    omega = np.linspace(min(sweep.first, sweep.last), max(sweep.first, sweep.last), 400)
    for system in request.systems:
        steady = system.steady_state(request.load.force_of(sweep), omega)
        if steady is not None and not request.load.shaken:
            axes.plot(omega, steady[energy], label=words, **_EXACT)
            words = None
    axes.set(xlabel="frequency $\\omega$ of the sweep [rad/s]", ylim=(0, None))
    axes.set_ylabel("largest $E_1$ [J]" if energy else "largest $|x_1|$ [m]")


def envelope(
    sweep: Sweep, time: np.ndarray, values: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the frequency [rad/s] and the largest value in each natural period of a sweep."""
    edges = np.arange(sweep.at, min(sweep.at + sweep.length, time[-1]), period)
    largest = np.maximum.reduceat(values, np.searchsorted(time, edges))[:-1]
    return sweep.omegas(0.5 * (edges[:-1] + edges[1:])), largest


def _shares(axes: Axes, histories: ResponseHistories) -> None:
    """Draw a bar for each system: the shares of the supplied energy by what dissipated them."""
    systems = _with_shares(histories)
    of_system = dict(zip(histories.results, histories.request.words, strict=True))
    words = [of_system[system.name] for system in systems]
    names = ["\n".join(map(typeset, textwrap.wrap(name, _NAME))) for name in words]
    shares = [shares_of(histories[system.name]) for system in systems]
    left = [0.0] * len(names)
    for sink, label in zip(WAYS, ("dashpot $c_1$", "dashpot $c_2$", "contacts"), strict=True):
        widths = [max(0.0, one.get(sink, 0.0)) for one in shares]
        if any(width > 0.0005 for width in widths):
            axes.barh(names, widths, left=left, color=HUES[_SINKS[sink]], label=label)
            left = [a + b for a, b in zip(left, widths, strict=True)]
    remaining = [max(0.0, 1.0 - end) for end in left]
    if any(share > 0.0005 for share in remaining):
        axes.barh(names, remaining, left=left, color=NO_VALUE, label="still there")
    axes.invert_yaxis()
    axes.set(xlim=(0, 1), xlabel="share of the energy that came in")
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


def _with_shares(histories: ResponseHistories) -> list[System]:
    """Return the systems of which it is known what dissipated the supplied energy."""
    systems = histories.request.systems
    return [system for system in systems if shares_of(histories[system.name])]


def _length_of_peaks(peaks: Sequence[Peak], systems: int) -> float:
    """Return the length of the axis of groups of bars: 1 for each with a bar of every system."""
    groups = {peak.quantity for peak in peaks}
    return _GROUP * len(peaks) / systems + (1.0 - _GROUP) * len(groups)


def _peaks(axes: Axes, histories: ResponseHistories) -> None:
    """Draw a group of bars for each quantity of the comparison, relative to its first bar.

    An infinite value has no bar, but its number.
    """
    peaks = histories.comparison()
    names = list(dict.fromkeys(peak.quantity for peak in peaks))
    looks = {system.name: look for system, look in _looks(histories.request)}
    height = _GROUP / len(looks)
    place = 0.0
    middles = []
    for name in names:
        one = [peak for peak in peaks if peak.quantity == name]
        base = next((peak.value for peak in one if 0.0 < peak.value < math.inf), 1.0)
        values = [peak.value for peak in one]
        factor, unit = shown_in(name, values, histories.request.load.shaken)
        middles.append(place + 0.5 * height * (len(one) - 1))
        for peak in one:
            look = looks[peak.system]
            length = peak.value / base if peak.value < math.inf else 0.0
            axes.barh(place, length, height, color=look["color"], label=look["label"])
            look["label"] = None
            text = f" {factor * peak.value:.3g} {raised(unit)}"
            axes.annotate(text, (length, place), va="center", fontsize=7)
            place += height
        place += 1.0 - _GROUP
    labels = [textwrap.fill(of_load(name).label, _NAME) for name in names]
    axes.set_yticks(middles, labels)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.25 * axes.get_xlim()[1])
    axes.set_xlabel("relative to the first bar of each group")
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


def draw_spectrum(spectrum: ResponseSpectrum, ax: Axes | None = None) -> Figure:
    let_figures_be_shown()
    with styled_for(ax):
        return _draw_spectrum(spectrum, ax)


def _draw_spectrum(spectrum: ResponseSpectrum, ax: Axes | None) -> Figure:
    if ax is None:
        figure, grid = new_figure(TWO_COLUMNS, [_PANEL])
        axes = figure.add_subplot(grid[0], label="spectrum")
    else:
        axes = ax
    axes.plot(spectrum.periods, spectrum.pseudo_acceleration, color=HUES["blue"], label="pseudo")
    axes.plot(
        spectrum.periods, spectrum.absolute_acceleration,
        color=HUES["vermillion"], linestyle="dashed", label="absolute",
    )  # fmt: skip
    axes.set(xscale="log", xlabel="natural period $T$ [s]", ylim=(0.0, None))
    axes.set_ylabel("largest acceleration [m/s$^2$]")
    axes.legend()
    if ax is None:
        finish(figure, grid, typeset(spectrum.heading()))
    return figure_of(axes)


# ---- scans ---------------------------------------------------------------------------------------


def _shown(scan: LoadScan, name: str) -> Shown:
    return shown_in(name, scan.numbers[name], scan.request.load.shaken)


def _values(scan: LoadScan, name: str) -> np.ndarray:
    """Return a quantity of all orbits as floats in its shown unit, NaN where it is missing."""
    values = scan.numbers[name]
    return np.where(values == of_load(name).fill, np.nan, values * _shown(scan, name).factor)


def _present(scan: LoadScan, name: str) -> np.ndarray:
    values = _values(scan, name)
    present: np.ndarray = values[np.isfinite(values)]
    return present


def _medians(scan: LoadScan, name: str) -> np.ndarray:
    """Return a quantity over systems and axes: of a suite the median over its records."""
    if not scan.loads:
        return _values(scan, name)
    medians = scan.over_records(name) * _shown(scan, name).factor
    return np.where(np.isfinite(medians), medians, np.nan)


def _records(axes: Axes, scan: LoadScan, name: str) -> None:
    """Draw a quantity under each record of a suite as dots, with median and 84 % quantile."""
    values = _values(scan, name)
    factor = _shown(scan, name).factor
    medians = factor * scan.over_records(name)
    quantiles = factor * scan.over_records(name, QUANTILE)
    count = len(scan.loads)
    looks = [look for _, look in _looks(scan.request)]
    step = 0.5 / len(looks)
    for place, look in enumerate(looks):
        if not np.isfinite(values[place]).any():
            continue
        offset = step * (place - 0.5 * (len(looks) - 1))
        dots = {**look, **_DOTS, "mfc": look["color"], "label": None}
        axes.plot(np.arange(count) + offset, values[place], **dots)
        line = {**look, "linestyle": "solid"}
        axes.plot([-0.5, count - 0.5], [medians[place]] * 2, **line)
        line |= {"linestyle": "dotted", "label": None}
        axes.plot([-0.5, count - 0.5], [quantiles[place]] * 2, **line)
    axes.plot([], [], **_STATISTIC, label="median")
    axes.plot([], [], **_STATISTIC, linestyle="dotted", label="84 % quantile")
    axes.set_xlim(-0.5, count - 0.5)
    if count <= _MOST_NAMES:
        names = [typeset(textwrap.shorten(one, _NAME, placeholder="...")) for one in scan.loads]
        axes.set_xticks(range(count), names, rotation=30.0, ha="right", fontsize=8)
    else:
        axes.set_xlabel("record")
    axes.set_ylabel(_label(scan, name))
    axes.set_ylim(0.0 if np.nanmin(values) >= 0.0 else None, None)


def _maps(scan: LoadScan, shown: Sequence[str], page: Page) -> Figure:
    """Draw a map of each shown quantity for each system that has one of them."""
    drawn = [
        number
        for number in range(len(scan.request.systems))
        if any(np.isfinite(_values(scan, name)[number]).any() for name in shown)
    ]
    count = len(drawn)
    across = min(count, 2 if page.beside else 1)
    rows = -(-count // across)
    figure, grid = new_figure(page, [_MAP] * (rows * len(shown)), across)
    places: list[Axes] = []
    for number, name in enumerate(shown):
        cells = [divmod(place, across) for place in range(count)]
        row = [figure.add_subplot(grid[number * rows + r, c]) for r, c in cells]
        meshes = [_map(axes, scan, name, i) for i, axes in zip(drawn, row, strict=True)]
        for place, axes in enumerate(row):
            if place + across < count:
                axes.tick_params(labelbottom=False)
                axes.set_xlabel("")
            if place % across:
                axes.tick_params(labelleft=False)
                axes.set_ylabel("")
        figure.colorbar(
            meshes[0], ax=row, label=_label(scan, name), pad=0.02, fraction=0.06, aspect=20 * rows
        )
        places += row
    write_letters(places)
    finish(figure, grid, scan.request.title)
    return figure


def _curves(axes: Axes, scan: LoadScan, name: str) -> None:
    request = scan.request
    (axis,) = request.vary
    words: str | None = "in closed form"
    factor = _shown(scan, name).factor
    pairs = zip(_looks(request), _values(scan, name), strict=True)
    for i, ((_, look), values) in enumerate(pairs):
        if scan.loads:
            _quantiles(axes, scan, name, i, look)
            continue
        if np.isfinite(values).any():
            axes.plot(axis.values, values, **look)
        exact = []
        for j in range(0 if request.state else axis.values.size):
            system, load = request.case(i * axis.values.size + j)
            exact.append(system.closed_form(load).get(name, np.nan) * factor)
        if np.isfinite(exact).any():
            axes.plot(axis.values, exact, label=words, **_EXACT)
            words = None
    if scan.loads:
        axes.plot([], [], **_STATISTIC, label="median")
        axes.plot([], [], **_STATISTIC, linestyle="dotted", label="84 % quantile")
    axes.set(xlabel=_axis(request, axis.name), ylabel=_label(scan, name))
    if logarithmic(axis.values):
        axes.set_xscale("log")
    if of_load(name).scale == ERROR:
        axes.set_yscale("log")


def _quantiles(axes: Axes, scan: LoadScan, name: str, number: int, look: Mapping[str, Any]) -> None:
    """Draw a quantity of a system over an axis: each record pale, median and 84 % quantile."""
    (axis,) = scan.request.vary
    for row in _values(scan, name)[number]:
        axes.plot(axis.values, row, color=look["color"], linewidth=0.5, alpha=0.3)
    factor = _shown(scan, name).factor
    median = factor * scan.over_records(name)[number]
    if np.isfinite(median).any():
        axes.plot(axis.values, median, **{**look, "linestyle": "solid"})
        above = factor * scan.over_records(name, QUANTILE)[number]
        axes.plot(axis.values, above, **{**look, "linestyle": "dotted", "label": None})


def _samples(axes: Axes, scan: LoadScan, name: str) -> None:
    """Draw a quantity of samples for each system: a histogram, an exceedance, or dots."""
    name, _, other = name.partition(":")
    numbers = _values(scan, name)
    columns = scan.request.columns
    bins = np.histogram_bin_edges(numbers[np.isfinite(numbers)], "auto")
    if bins.size > _MOST_BINS:
        bins = np.linspace(bins[0], bins[-1], _MOST_BINS + 1)
    sources = {name: np.broadcast_to(column, numbers.shape[1:]) for name, column in columns.items()}
    for (_, look), values in zip(_looks(scan.request), numbers, strict=True):
        ascending = np.sort(values[np.isfinite(values)])
        size = ascending.size
        if not size:
            continue
        if other == EXCEEDANCE:
            axes.step(ascending, 1.0 - np.arange(ascending.size) / size, where="post", **look)
        elif other:
            dots = {**look, **_DOTS, "mfc": look["color"], "markersize": 1.6, "rasterized": True}
            axes.plot(sources[other].ravel(), values.ravel(), **dots)
        else:
            axes.stairs(np.histogram(ascending, bins)[0] / size, bins, **look)
    if other in columns:
        axes.set(xlabel=_axis(scan.request, other), ylabel=_label(scan, name))
    else:
        axes.set(
            xlabel=_label(scan, name),
            ylabel="share of samples above" if other else "share of samples",
        )
        if other:
            axes.set_yscale("log")


def _map(axes: Axes, scan: LoadScan, name: str, number: int) -> QuadMesh:
    """Fill the map of a system by its number; all maps of a quantity have the same color scale."""
    x, y = scan.request.vary
    medians = _medians(scan, name)
    values = medians[number]
    finite = medians[np.isfinite(medians)]
    low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
    norm: dict[str, Any] = {"vmin": low, "vmax": high}
    if of_load(name).scale == ERROR and low > 0.0:
        norm = {"norm": LogNorm(low, high)}
    axes.set_facecolor(NO_VALUE)
    mesh = axes.pcolormesh(
        edges(x.values), edges(y.values), np.ma.masked_invalid(values.T), cmap=SHADES,
        rasterized=True, **norm,
    )  # fmt: skip
    if logarithmic(x.values):
        axes.set_xscale("log")
    if logarithmic(y.values):
        axes.set_yscale("log")
    axes.set(xlabel=_axis(scan.request, x.name), ylabel=_axis(scan.request, y.name))
    axes.set_title(typeset(scan.request.words[number]), fontsize=9)
    return mesh


def _axis(request: HistoryRequest, name: str) -> str:
    if name in DESCRIBED:
        return axis_label(name)
    unit, words = axis_words(request, name)
    return labeled(words, "", unit)


def _label(scan: LoadScan, name: str) -> str:
    entry = of_load(name)
    return labeled(entry.label, in_latex(entry.symbol), _shown(scan, name).unit)


_FILL: Mapping[str, Callable[[Axes, ResponseHistories], None]] = {
    "energy": _energy,
    "motion": _motion,
    "damper": _damper,
    "shares": _shares,
    "peaks": _peaks,
    "sweep": _sweep,
    SWEEP_ENERGY: partial(_sweep, energy=True),
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
