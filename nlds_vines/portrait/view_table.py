"""The archive of a portrait: its views as datasets, and back.

Each column of the page is an entry along `row`.  Windows differ in length, so their contents are
concatenated: states along `state`, sections along `section_point`, impacts along `impact`, spectra
along `bin` (contiguous ragged arrays of the CF conventions); the row holds their numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError
from nlds_vines.orbits.records import IMPACT, OK, STATUS_FLAGS, Violation
from nlds_vines.orbits.signals import SIGNALS, signals_of
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

if TYPE_CHECKING:
    from nlds_vines.orbits.classification import LyapunovSpectrum

_SPECTRUM = ("order", "amplitude", "power")
_DERIVED = ("force", "E1", "E2")  # of the states
_IMPACTS: Mapping[str, tuple[str, str]] = {
    "touch": ("s", "time of the touch since the orbit began"),
    "release": ("s", "time of the release"),
    "speed": ("m/s", "approach speed"),
    "force": ("N", "largest contact force of the impact"),
    "depth": ("m", "largest depth of the impact"),
    "gain1": ("J", "what E1 gains from touch to release"),
    "gain2": ("J", "what E2 gains from touch to release"),
}


_EXPONENTS = (
    ("running", ("row", "exponent_period", "exponent"), "Lyapunov exponents up to this period"),
    ("widths", ("row", "exponent"), "half widths of their 99 % intervals"),
    ("divergence", ("row",), "mean divergence of the motion, the sum of the exponents"),
)
"""The datasets of Lyapunov spectra: fields, dimensions, meanings."""

_ROW: tuple[tuple[Dataset, Callable[[View], Any]], ...] = (
    (Dataset.text("name", ("row",), "what stands above the column"), lambda v: v.column.name),
    (Dataset.text("system", ("row",), "name of the system"), lambda v: v.column.system.name),
    (
        Dataset.whole("begin", ("row",), "forcing period with which the window begins"),
        lambda v: v.column.window.begin,
    ),
    (
        Dataset.whole("end", ("row",), "forcing period with which it ends"),
        lambda v: v.column.window.end,
    ),
    (Dataset.text("label", ("row",), "regime by recurrence alone"), lambda v: v.label),
    (
        Dataset.whole("periodicity", ("row",), "n of nT by recurrence; 0: none found"),
        lambda v: v.period,
    ),
    (
        Dataset.real("recurs_within", ("row",), "1", "to which the section recurs"),
        lambda v: v.tolerance,
    ),
    (
        Dataset.whole("longest_periodicity", ("row",), "longest n that was looked for"),
        lambda v: v.longest,
    ),
    (
        Dataset.whole("comb", ("row",), "n of the nT whose lines do not count as broadband"),
        lambda v: v.comb,
    ),
    (
        Dataset.real("broadband", ("row",), "1", "share of the power beside the lines"),
        lambda v: np.nan if v.share is None else v.share,
    ),
    (Dataset.whole("states", ("row",), "states in the window"), lambda v: len(v.time)),
    (
        Dataset.whole("impact_count", ("row",), "impacts that begin in the window"),
        lambda v: len(v.contacts),
    ),
    (
        Dataset.whole("spectrum_periods", ("row",), "periods in the spectrum"),
        lambda v: v.spectrum.periods,
    ),
    (
        Dataset.whole("spectrum_bins", ("row",), "bins of the spectrum"),
        lambda v: v.spectrum.order.size,
    ),
    (
        Dataset.whole("passages", ("row",), "passages of the limit; -1: there is none"),
        lambda v: _limit(v).number,
    ),
    (Dataset.real("first_passage", ("row",), "s", "time of the first"), lambda v: _limit(v).time),
    (
        Dataset.real("deepest_passage", ("row",), "m", "depth of the deepest"),
        lambda v: _limit(v).depth,
    ),
)
"""The datasets with one value per column of the page, and the value of a view."""


def _limit(view: View) -> Violation:
    return view.violation or Violation(-1, np.nan, np.nan)


def contents(
    request: PortraitRequest, views: Sequence[View]
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive of views, and its datasets with their values."""
    periods = [np.arange(w.begin + 1, w.end + 1) for w in (view.column.window for view in views)]
    impacts = np.concatenate([view.contacts for view in views])
    components = request.columns[0].system.scene.components  # of all: they are of one kind
    time = np.concatenate([view.time for view in views])
    bins = sum(view.spectrum.order.size for view in views)
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
    spectrum, unit = f"of {request.signal}, {request.taper} window", SIGNALS[request.signal].unit
    status = Dataset.code("status", ("row",), "how the orbit ended", STATUS_FLAGS)
    period = Dataset.whole("forcing_period", ("section_point",), "n of t = nT")
    section = Dataset.real("section", ("section_point", "component"), "m, m/s", "state at t = nT")
    entries = [
        *(
            (e, np.array([of(view) for view in views], object if e.dtype == "str" else e.dtype))
            for e, of in _ROW
        ),
        (status, np.full(len(views), OK)),  # of any other there is no portrait
        (Dataset.real("time", ("state",), "s", "time since the orbit began"), time),
        *_histories(views),
        (period, np.concatenate(periods).astype(np.int32)),
        (section, np.concatenate([view.section for view in views])),
    ]
    for name, units, words in (
        ("order", "1", "frequency by that of the force"),
        ("amplitude", unit, f"spectrum {spectrum}"),
        ("power", f"({unit})^2", f"power {spectrum}"),
    ):
        values = np.concatenate([getattr(view.spectrum, name) for view in views])
        entries.append((Dataset.real(name, ("bin",), units, words), values))
    if impacts.size:
        wall = Dataset.text("wall", ("impact",), "what is struck")
        entries.append((wall, impacts["wall"].astype(object)))
        for name, (units, words) in _IMPACTS.items():
            entry = Dataset.real(_of_impact(name), ("impact",), units, words)
            entries.append((entry, impacts[name].copy()))
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
    impacts, spectra = _impacts_in(view), {name: view[name] for name in _SPECTRUM}
    time, at = view["time"], dict.fromkeys(("time", "impact", "order"), 0)

    def part(name: str, count: int) -> slice:
        begin, at[name] = at[name], at[name] + count
        return slice(begin, at[name])

    for i, column in enumerate(request.columns):
        row = {name: values[i] for name, values in table.items()}
        here, bins = part("time", row["states"]), part("order", row["spectrum_bins"])
        scene = column.system.scene
        yield View(
            column=column,
            time=time[here],
            states=np.column_stack([view[name][here] for name in scene.components]),
            samples=request.samples,
            contacts=impacts[part("impact", row["impact_count"])],
            period=row["periodicity"],
            tolerance=row["recurs_within"],
            longest=row["longest_periodicity"],
            comb=row["comb"],
            spectrum=Spectrum(
                **{name: values[bins] for name, values in spectra.items()},
                omega=column.system.parameters["omega"],
                samples=request.samples,
                periods=row["spectrum_periods"],
                window=request.taper,
                quantity=request.signal,
                unit=SIGNALS[request.signal].unit,
            ),
            violation=None
            if row["passages"] < 0
            else Violation(row["passages"], row["first_passage"], row["deepest_passage"]),
            exponents=_exponents_in(view, i, column.system.period),
        )


def _histories(views: Sequence[View]) -> Iterator[tuple[Dataset, np.ndarray]]:
    """Yield the components of the state over time, and the force and energies that follow."""
    scene = views[0].column.system.scene
    for name in signals_of(scene):
        if name in (*scene.components, *_DERIVED):
            unit, words, of = SIGNALS[name]
            parts = [of(view.column.system, view.states) for view in views]
            yield Dataset.real(name, ("state",), unit, words), np.concatenate(parts)


def _impacts_in(view: ArchiveView) -> np.ndarray:
    """Return the impacts in an archive, rows of dtype `IMPACT`."""
    rows = np.empty(len(view["wall"]) if "wall" in view else 0, IMPACT)
    if rows.size:
        rows["wall"] = view["wall"]
        for name in _IMPACTS:
            rows[name] = view[_of_impact(name)]
    return rows


def _of_impact(name: str) -> str:
    """Return the dataset of a field of `IMPACT`; a history has the name `force` already."""
    return "force_max" if name == "force" else name


def _exponents_in(view: ArchiveView, row: int, period: float) -> LyapunovSpectrum | None:
    """Return the Lyapunov spectrum of a row in an archive, None if it has none."""
    if "lyapunov_running" not in view:
        return None
    from nlds_vines.orbits.classification import LyapunovSpectrum  # imports kernels

    running, widths, divergence = (view[f"lyapunov_{name}"][row] for name, *_ in _EXPONENTS)
    if np.isnan(running).all():
        return None
    times = period * np.arange(1, len(running) + 1)
    return LyapunovSpectrum(running[-1], widths, times, running, float(divergence))
