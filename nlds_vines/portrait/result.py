"""A computed portrait: its windows as numbers, its archive, its page.

In an archive each column of the page is an entry along `row`.  Windows differ in length, so states,
sections, impacts and spectra are concatenated (contiguous ragged arrays of the CF conventions); the
row holds their numbers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.provenance import PORTRAIT
from nlds_vines.archives.representation import Outlined
from nlds_vines.engine.records import OK, STATUS_FLAGS, Violation, impact_type
from nlds_vines.engine.spectrum import Spectrum
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import name_of
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.portrait.request import (
    CELL,
    CELL_OF,
    Column,
    PortraitRequest,
    load_portrait,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nlds_vines.engine.classification import LyapunovSpectrum

POWER_SHARE = 0.99  # of the power of a spectrum, whose bins the report counts, the strongest first


@dataclass(frozen=True, repr=False)
class View(Outlined):
    """A window of an orbit.

    Attributes:
        time: times [s] of the states from the start of the orbit, shape (n,).
        states: x1, v1, x2, v2 [m, m/s], shape (n, 4), or (n, 2) without a damper, or the components
            of a host; `samples` of each period, the last at its end.
        contacts: the impacts that begin in the window, rows of dtype `records.IMPACT` or
            `records.HOST_IMPACT`.
        period: n of nT, by recurrence of the section to a `tolerance`; 0 if no period of up to
            `longest` recurs.
        comb: n of the nT whose lines do not count as broadband.
        spectra: of the request's signals, over as many last periods as the comb divides.
        violation: of the scene's limit, in the whole run; None without a limit.
        exponents: the Lyapunov spectrum from the last state on; None if no panel shows it.
    """

    column: Column
    time: np.ndarray
    states: np.ndarray
    samples: int
    contacts: np.ndarray
    period: int
    tolerance: float
    longest: int
    comb: int
    spectra: tuple[Spectrum, ...]
    violation: Violation | None = None
    exponents: LyapunovSpectrum | None = None

    @property
    def spectrum(self) -> Spectrum:
        """The spectrum of the first signal."""
        return self.spectra[0]

    @property
    def section(self) -> np.ndarray:
        """The states at the whole forcing periods, shape (periods, components)."""
        return self.section_at(0)

    def section_at(self, sample: int) -> np.ndarray:
        """Return the states (periods, components) at a sample of each period, 0 its end t = nT."""
        return self.states[(sample - 1) % self.samples :: self.samples]

    @property
    def limit(self) -> Violation:
        """The violation of the scene's limit, with the number -1 without a limit."""
        return self.violation or Violation(-1, np.nan, np.nan)

    @property
    def impact_section(self) -> Mapping[str, np.ndarray]:
        """The section at impact by wall, (touches, 2): phase omega t mod 2 pi [rad], speed [m/s].

        Of a periodic orbit it has one cycle.
        """
        period = self.column.system.period
        last = self.contacts[self.touches > (self.column.window.end - self.cycle) * period]
        points = np.column_stack([2.0 * np.pi * (last["touch"] / period % 1.0), last["speed"]])
        touched = self.column.system.scene.touches_at(last)
        return {name: points[is_there] for name, is_there in touched.items()}

    @property
    def touches(self) -> np.ndarray:  # times [s]
        return self.contacts["touch"]

    @property
    def cycle(self) -> int:
        """The number of periods of one cycle: n of nT, or all of the window."""
        return self.period or len(self.section)

    @property
    def impacts(self) -> int:
        """Impacts k per nT, averaged over the whole cycles of the window; all impacts if n is 0."""
        return sum(self.impacts_by_damper.values())

    @property
    def impacts_by_damper(self) -> Mapping[str, int]:
        """The same by damper, if a host has several."""
        last, cycles = self.contacts, 1
        if self.period:
            cycles = len(self.section) // self.period
            first = (self.column.window.end - cycles * self.period) * self.column.system.period
            last = last[self.touches > first]
        names = self.column.system.scene.dampers
        counts = {name: int(np.sum(last["damper"] == name)) for name in names}
        return {name: round(k / cycles) for name, k in (counts or {"": len(last)}).items()}

    @property
    def label(self) -> str:
        """The regime by recurrence alone: `3T,3`, of a host `2T,3 (2+1)`, or `undetermined`."""
        if not self.period:
            return "undetermined"
        return name_of(self.period, self.impacts, *self.impacts_by_damper.values())

    @property
    def share(self) -> float | None:
        """The broadband share of the first spectrum."""
        return self.share_of(self.spectrum)

    def share_of(self, spectrum: Spectrum) -> float | None:
        """Return the broadband share of a spectrum; None if its periods are too few."""
        if self.comb > spectrum.most_lines():
            return None
        return spectrum.broadband_share(self.comb)

    def lines(self) -> Iterator[str]:
        begin, end = self.column.window
        name = f"{self.column.name}: " if self.column.name else ""
        yield f"{name}periods {begin} to {end} of {self.column.system.period:.6g} s each"
        if self.period:
            times = f"{self.period} period{'s' if self.period > 1 else ''}"
            words = f"{self.label}: the section repeats after {times} to {self.tolerance:g}"
        elif self.longest == 0:
            words = "the window is too short to tell"
        else:
            words = f"no period of up to {self.longest} found; that alone proves no chaos"
        yield f"  recurrence: {words}"
        if self.column.system.scene.walls:
            rate = len(self.touches) / len(self.section)
            yield f"  impacts per period: {rate:.4g} ({len(self.touches)} in the window)"
        if (passed := self.violation) is not None:
            times = f"{passed.number} time{'s' if passed.number > 1 else ''}"
            words = f"violated {times}, by up to {passed.depth:.4g} m, first at {passed.time:.6g} s"
            yield f"  limit of the scene, in the whole run: {words if passed.number else 'kept'}"
        for name in self.column.system.energy_signals:
            highest = self.column.system.signal(name).of(self.states).max()
            yield f"  largest {name} of the samples: {highest:.6g} J"
        for spectrum in self.spectra:
            n, share = self.comb, self.share_of(spectrum)
            outside = "the harmonics of the force" if n == 1 else f"the lines of {n}T"
            words = "(too few periods to tell)" if share is None else f"{share:.2g}"
            yield (
                f"  spectrum of {spectrum.quantity}: {spectrum.periods} periods, "
                f"{spectrum.window} window, resolution {spectrum.resolution:.4g} of the forcing "
                f"frequency; {words} of its power outside {outside}, {POWER_SHARE:.0%} of its "
                f"power in {spectrum.bins_holding(POWER_SHARE)} bins"
            )
        if self.exponents is not None:
            words = "; ".join(f"{name} {value}" for name, value in self.exponents.outline())
            yield f"  Lyapunov {words}"


@dataclass(frozen=True, repr=False)
class Portrait(Drawable):
    """The windows of one or several orbits, as a portrait shows them.

    Attributes
    ----------
    path : ArchivePath or None
        Archive of the numbers.
    views : tuple of View
        One window for each column of the page.
    drawn_from : PortraitRequest
        The request of the page, which does not repeat the orbit of a scan's cell.
    cell : str
        The options that name such a cell; empty for other orbits.
    """

    drawn_by = "nlds_vines.portrait.picture"

    path: ArchivePath | None
    views: tuple[View, ...]
    drawn_from: PortraitRequest
    cell: str = ""

    @property
    def request(self) -> PortraitRequest:
        """The request that computes the same numbers again.

        Raises `RequestError` for the orbit of a scan's cell, which needs the scan's archive.
        """
        if self.cell:
            raise RequestError(
                f"{self.path} holds the orbit of a cell: of the archive of its scan, "
                f"`nlds-vines portrait SCAN.h5 {self.cell}` computes it again"
            )
        return self.drawn_from

    @cached_property
    def page(self) -> Figure:
        """The page, a matplotlib figure."""
        page: Figure = import_module(self.drawn_by).portrait(self.drawn_from, self.views)
        return page

    def lines(self) -> Iterator[str]:
        """Yield the title and the report of each window."""
        yield self.drawn_from.title
        for view in self.views:
            yield from view.lines()

    def to_dataframe(self, *names: str) -> Any:
        """Return datasets over one dimension, by default the histories, as a `DataFrame`."""
        with self.archive.read() as view:
            return view.to_dataframe(*(names or histories_in(view)))


def histories_in(view: ArchiveView) -> tuple[str, ...]:
    """Return the datasets over time in an open archive: time, the state, then all others."""
    names = [name for name in view.names if view.dims(name) == ("state",)]
    system = view.request(PORTRAIT, load_portrait).columns[0].system
    first = [name for name in ("time", *system.histories()) if name in names]
    return (*first, *(name for name in names if name not in first))


def portrait_in(path: str | os.PathLike[str]) -> Portrait:
    """Return the portrait in an archive; `RequestError` if it holds anything else."""
    with read(path) as view:
        request = view.request(PORTRAIT, load_portrait)
        cell = view.text(CELL) if CELL_OF in view.attrs else ""
        return Portrait(ArchivePath.of(view.path), tuple(views_in(view, request)), request, cell)


# ---- archives ------------------------------------------------------------------------------------

_SPECTRUM = ("order", "amplitude", "power")
_PASSAGES = ("passages", "first_passage", "deepest_passage")
_IMPACTS = (
    ("damper", "damper", "", "damper that strikes"),
    ("wall", "wall", "", "what is struck; of a host the side of the damper's wall"),
    ("touch", "touch", "s", "time of the touch since the orbit began"),
    ("release", "release", "s", "time of the release"),
    ("speed", "speed", "m/s", "approach speed"),
    ("force", "force_max", "N", "largest contact force of the impact"),
    ("depth", "depth", "m", "largest depth of the impact"),
    ("impulse", "impulse", "N s", "largest impulse of a rigid wall, 0 of other walls"),
    ("gain1", "gain1", "J", "what E1 gains from touch to release"),
    ("gain2", "gain2", "J", "what E2 gains from touch to release"),
)
"""The fields of `IMPACT`, the datasets that hold them, their units and meanings."""

_EXPONENTS = (
    ("running", ("row", "exponent_period", "exponent"), "Lyapunov exponents up to this period"),
    ("widths", ("row", "exponent"), "half widths of their 99 % intervals"),
    ("divergence", ("row",), "mean divergence of the motion, the sum of the exponents"),
)
"""The datasets of Lyapunov spectra: fields, dimensions, meanings."""


def _of_row(name: str, kind: str, words: str, path: str) -> tuple[Dataset, Callable[[View], Any]]:
    if kind in ("text", "whole"):
        return getattr(Dataset, kind)(name, ("row",), words), attrgetter(path)
    return Dataset.real(name, ("row",), kind, words), attrgetter(path)


_ROW = (
    _of_row("name", "text", "heading above the column", "column.name"),
    _of_row("system", "text", "name of the system", "column.system.name"),
    _of_row("begin", "whole", "forcing period with which the window begins", "column.window.begin"),
    _of_row("end", "whole", "forcing period with which it ends", "column.window.end"),
    _of_row("label", "text", "regime by recurrence alone", "label"),
    _of_row("periodicity", "whole", "n of nT by recurrence; 0: none found", "period"),
    _of_row("recurs_within", "1", "to which the section recurs", "tolerance"),
    _of_row("longest_periodicity", "whole", "longest n that was looked for", "longest"),
    _of_row("comb", "whole", "n of the nT whose lines do not count as broadband", "comb"),
    _of_row("broadband", "1", "share of the power beside the lines", "share"),
    _of_row("states", "whole", "states in the window", "time.size"),
    _of_row("impact_count", "whole", "impacts that begin in the window", "contacts.size"),
    _of_row("spectrum_periods", "whole", "periods in the spectrum", "spectrum.periods"),
    _of_row("spectrum_bins", "whole", "bins of the spectrum", "spectrum.order.size"),
    _of_row("passages", "whole", "passages of the limit; -1: there is none", "limit.number"),
    _of_row("first_passage", "s", "time of the first", "limit.time"),
    _of_row("deepest_passage", "m", "depth of the deepest", "limit.depth"),
)
"""The datasets with one value per column of the page, and the value of a view."""


def contents(
    request: PortraitRequest, views: Sequence[View]
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive of views, and its datasets with their values."""
    periods = [np.arange(w.begin + 1, w.end + 1) for w in (view.column.window for view in views)]
    impacts = np.concatenate([view.contacts for view in views])
    first = request.columns[0].system
    components = first.scene.components  # of all: they are of one kind
    time = np.concatenate([view.time for view in views])
    bins, several = sum(view.spectrum.order.size for view in views), len(request.signal) > 1
    scales = [
        Scale.counted("row", len(views), "column of the page", 1),
        Scale.counted("state", time.size, "number of the state", 1),
        Scale.counted(
            "section_point", sum(map(len, periods)), "number of the point of a section", 1
        ),
        Scale("component", np.array(components, dtype=object), "1", "component of the state"),
        Scale.counted("bin", bins, "number of the bin of a spectrum", 1),
    ]
    if impacts.size:
        scales.append(Scale.counted("impact", impacts.size, "number of the impact", 1))
    if several:
        names = np.array(request.signal, dtype=object)
        scales.append(Scale("signal", names, "1", "signal of a spectrum"))
    words = f"of {'signals' if several else request.signal[0]}, {request.taper} window"
    signals = dict.fromkeys(first.signal(name).unit for name in request.signal)
    unit, squared = ", ".join(signals), ", ".join(f"({unit})^2" for unit in signals)
    # the components of the state over time, and what follows from them
    histories = []
    tables = [view.column.system.histories(request.of) for view in views]
    for name, signal in tables[0].items():
        pairs = zip(tables, views, strict=True)
        each_values = [table[name].of(view.states) for table, view in pairs]
        dataset = Dataset.real(name, ("state",), signal.unit, signal.meaning)
        histories.append((dataset, np.concatenate(each_values)))
    status = Dataset.code("status", ("row",), "how the orbit ended", STATUS_FLAGS)
    period = Dataset.whole("forcing_period", ("section_point",), "n of t = nT")
    section = Dataset.real("section", ("section_point", "component"), "m, m/s", "state at t = nT")
    entries = [
        *((entry, np.array([of(view) for view in views], entry.memory_type)) for entry, of in _ROW),
        (status, np.full(len(views), OK)),  # of any other there is no portrait
        (Dataset.real("time", ("state",), "s", "time since the orbit began"), time),
        *histories,
        (period, np.concatenate(periods).astype(np.int32)),
        (section, np.concatenate([view.section for view in views])),
    ]
    for name, units, meaning in (
        ("order", "1", "frequency by that of the force"),
        ("amplitude", unit, f"spectrum {words}"),
        ("power", squared, f"power {words}"),
    ):
        each = [[getattr(one, name) for one in view.spectra] for view in views]
        by_signal = np.concatenate(each, axis=-1)
        if several and name != "order":
            dataset = Dataset.real(name, ("signal", "bin"), units, meaning)
            entries.append((dataset, by_signal))
        else:
            entries.append((Dataset.real(name, ("bin",), units, meaning), by_signal[0]))
    for name, column, units, meaning in _IMPACTS if impacts.size else ():
        if name in (impacts.dtype.names or ()):
            if units:
                values = impacts[name].copy()
                entries.append((Dataset.real(column, ("impact",), units, meaning), values))
            else:
                values = impacts[name].astype(object)
                entries.append((Dataset.text(column, ("impact",), meaning), values))
    spectra = [view.exponents for view in views]
    if some := next(filter(None, spectra), None):
        numbered = {"exponent": len(components), "exponent_period": len(some.times)}
        for name, count in numbered.items():
            scales.append(Scale.counted(name, count, f"number of the {name}", 1))
        for name, dims, words in _EXPONENTS:
            fields = [getattr(one, name, np.nan) for one in spectra]
            values = np.stack(np.broadcast_arrays(*fields))
            entries.append((Dataset.real(f"lyapunov_{name}", dims, "1/s", words), values))
    return scales, entries


def views_in(view: ArchiveView, request: PortraitRequest) -> Iterator[View]:
    """Yield the views in an archive; `RequestError` if its rows do not match the request."""
    table = {entry.name: view[entry.name].tolist() for entry, _ in _ROW}
    if len(table["label"]) != len(request.columns):
        raise RequestError(f"{view.path} is damaged: its rows are not those of its request")
    system = request.columns[0].system
    impacts = np.zeros(len(view["wall"]) if "wall" in view else 0, impact_type(system.scene))
    for name, dataset, *_ in _IMPACTS:
        if impacts.size and name in (impacts.dtype.names or ()):
            # archives of earlier versions have no impulses
            impacts[name] = view[dataset] if name != "impulse" or dataset in view else np.nan
    order, amplitude, power = (np.atleast_2d(view[name]) for name in _SPECTRUM)
    histories = [*system.histories()][: len(system.scene.components)]
    time, at = view["time"], dict.fromkeys(("time", "impact", "order"), 0)

    def part(name: str, count: int) -> slice:
        begin, at[name] = at[name], at[name] + count
        return slice(begin, at[name])

    for i, column in enumerate(request.columns):
        row = {name: values[i] for name, values in table.items()}
        here, bins = part("time", row["states"]), part("order", row["spectrum_bins"])
        system, exponents = column.system, None
        if "lyapunov_running" in view:
            from nlds_vines.engine.classification import LyapunovSpectrum  # imports kernels

            running, widths, divergence = (view[f"lyapunov_{name}"][i] for name, *_ in _EXPONENTS)
            times = system.period * np.arange(1, len(running) + 1)
            if not np.isnan(running).all():
                exponents = LyapunovSpectrum(running[-1], widths, times, running, float(divergence))
        each = [
            Spectrum(
                order[0, bins],
                amplitude[k, bins],
                power[k, bins],
                omega=system.parameters["omega"],
                samples=request.samples,
                periods=row["spectrum_periods"],
                window=request.taper,
                quantity=name,
                unit=system.signal(name).unit,
            )
            for k, name in enumerate(request.signal)
        ]
        yield View(
            column,
            time[here],
            states=np.column_stack([view[name][here] for name in histories]),
            samples=request.samples,
            contacts=impacts[part("impact", row["impact_count"])],
            period=row["periodicity"],
            tolerance=row["recurs_within"],
            longest=row["longest_periodicity"],
            comb=row["comb"],
            spectra=tuple(each),
            violation=None if row["passages"] < 0 else Violation(*(row[n] for n in _PASSAGES)),
            exponents=exponents,
        )
