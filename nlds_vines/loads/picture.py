"""Pictures of response histories: energy, motion, where the energy went, and sweeps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.errors import RequestError
from nlds_vines.loads import scan_picture
from nlds_vines.loads.fall import Fall
from nlds_vines.loads.request import HistoryRequest, load_response_history, natural_period
from nlds_vines.loads.result import LoadScan, ResponseHistories, histories_in, shares_of
from nlds_vines.model.linear_response import harmonic_energy, response
from nlds_vines.model.load_quantities import SHARES, WAYS
from nlds_vines.model.loads.waves import Sweep
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.status_words import STATUS
from nlds_vines.plotting.chosen_panels import Picture
from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled, write_letters
from nlds_vines.plotting.style import CM, GRAY, HUES, NO_VALUE

_HEIGHT = {"shares": 4.2 * CM}  # inches
_USUAL = 6.2 * CM
_WAYS = dict(zip(WAYS, ("blue", "sky", "vermillion"), strict=True))
SWEEP_ENERGY = "sweep_energy"
"""The panel beside whose sweeps branches are drawn: archives of branches have E1max."""

_LEAST = 1e-4  # of the largest E1: the lower end of the axis


def panels(view: ArchiveView) -> Mapping[str, str]:
    """Return what the panels show, by name; of a scan its numbers."""
    request = view.request(RESPONSE_HISTORY, load_response_history)
    if request.vary:
        return scan_picture.panels(view)
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
    """Return the panels of the usual picture: the sweep's alone, of a scan the first number's."""
    found, known = _drawable(view), [*panels(view)]
    if found.request.vary:
        return scan_picture.usual(view)
    return ["sweep"] if "sweep" in known else ["energy", "shares"]


@styled()
def draw(view: ArchiveView, shown: Sequence[str], page: Page = TWO_COLUMNS) -> Figure:
    """Return the figure of an archive with the panels that are `shown`."""
    found = _drawable(view)
    if not isinstance(found, ResponseHistories):
        return scan_picture.draw(found, shown, page)
    heights = [_HEIGHT.get(name, _USUAL) for name in shown]
    figure = Figure(figsize=(page.width, sum(heights) + 1.0 * CM), layout="constrained")
    grid = figure.subplots(len(shown), 1, squeeze=False, height_ratios=heights)
    for name, axes in zip(shown, grid[:, 0], strict=True):
        axes.set_label(name)
        _FILL[name](axes, found)
    write_letters([*grid[:, 0]])
    scan_picture.entitle(figure, found.request.title)
    return figure


def fill(axes: Axes, view: ArchiveView, name: str) -> None:
    """Draw one panel into given axes."""
    found = _drawable(view)
    if isinstance(found, ResponseHistories):
        _FILL[name](axes, found)
    else:
        scan_picture.fill(axes, found, name)


def _drawable(view: ArchiveView) -> ResponseHistories | LoadScan:
    """Return what an archive holds; `RequestError` where every orbit failed."""
    found = histories_in(view.path)
    if found.failed == found.request.cases:
        status = STATUS[int(view["status"].flat[0])]
        raise RequestError(f"{view.path}: every orbit failed: {status.name}. {status.remedy}")
    return found


def _each(found: ResponseHistories) -> Iterator[tuple[System, Fall, dict[str, Any]]]:
    """Yield each system, what became of it, and how it is drawn."""
    pairs = zip(found.request.systems, found.results.values(), strict=True)
    for i, (system, fall) in enumerate(pairs):
        label = typeset(system_in_words(system))
        yield system, fall, {"label": label, "linewidth": 1.0, **scan_picture.look(i)}


def _energy(axes: Axes, found: ResponseHistories) -> None:
    """Draw E1 relative to the largest of each damper, on a logarithmic axis."""
    for _, fall, look in _each(found):
        axes.semilogy(fall.time, fall.E1 / fall.numbers["E1max"], **look)
    for share in SHARES:
        axes.axhline(share, color=GRAY, linewidth=0.6, zorder=0)
    axes.set(ylim=(_LEAST, 1.5), ylabel="$E_1$ by its largest")
    _over_time(axes, found.request)
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g}%")


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
    axes.legend(loc="upper right")


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
        if not system.scene.walls and not request.load.shaken:
            sweep = request.load.sweeps[0]
            omega = np.linspace(min(sweep.first, sweep.last), max(sweep.first, sweep.last), 400)
            steady = np.abs(response(system.with_(P=request.load.force_of(sweep)), omega).X1)
            m1, k1, _ = system.structure
            values = harmonic_energy(m1, k1, omega, steady) if energy else steady
            axes.plot(omega, values, label=steady_words, **scan_picture.EXACT)
            steady_words = None
    axes.set(xlabel="frequency $\\omega$ of the sweep [rad/s]", ylim=(0, None))
    axes.legend(loc="upper right")


def envelope(
    sweep: Sweep, time: np.ndarray, values: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency [rad/s] and largest value of each natural period of a sweep."""
    edges = np.arange(sweep.at, min(sweep.at + sweep.length, time[-1]), period)
    largest = np.maximum.reduceat(values, np.searchsorted(time, edges))[:-1]
    return sweep.omegas(0.5 * (edges[:-1] + edges[1:])), largest


def _shares(axes: Axes, found: ResponseHistories) -> None:
    """Draw a bar for each damper: the shares of the energy by what has dissipated them."""
    names = [typeset(system_in_words(system)) for system in found.request.systems]
    shares = [shares_of(fall) for fall in found.results.values()]
    left = [0.0] * len(names)
    for way in WAYS:
        widths = [max(0.0, one.get(way, 0.0)) for one in shares]
        if any(width > 0.0005 for width in widths):
            words = {"c1": "dashpot $c_1$", "c2": "dashpot $c_2$", "contact": "contacts"}[way]
            axes.barh(names, widths, left=left, color=HUES[_WAYS[way]], label=words)
            left = [a + b for a, b in zip(left, widths, strict=True)]
    still = [max(0.0, 1.0 - done) for done in left]
    if any(share > 0.0005 for share in still):
        axes.barh(names, still, left=left, color=NO_VALUE, label="still there")
    axes.invert_yaxis()
    axes.set(xlim=(0, 1), xlabel="share of the energy that came in")
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)


_FILL: Mapping[str, Callable[[Axes, ResponseHistories], None]] = {
    "energy": _energy,
    "motion": _motion,
    "damper": _damper,
    "shares": _shares,
    "sweep": _sweep,
    SWEEP_ENERGY: _sweep_energy,
}

PICTURE = Picture(panels=panels, draw=draw, fill=fill, usual=usual)
