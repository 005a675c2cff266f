"""Views as the datasets of an archive, and back.

The columns of a page are a row each.  Their windows may differ in length, so what belongs to them
follows one after the other: states along `state`, sections along `section_point`, impacts along
`impact`, spectra along `bin` (the contiguous ragged arrays of the CF conventions).  How many of
each belong to a column stands in its row.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.record_columns import Column, columns, record_of, row_of, table_of
from nlds_vines.archives.view import ArchiveView
from nlds_vines.errors import RequestError
from nlds_vines.orbits.impact_rows import IMPACT, Violation
from nlds_vines.orbits.signals import SIGNALS, signals_of
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.orbits.status_words import OK, STATUS_FLAGS
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

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


@dataclass(frozen=True)
class _Row:
    """What is told of a column of the page in numbers and words."""

    name: Annotated[str, Column("1", "what stands above the column")]
    system: Annotated[str, Column("1", "name of the system")]
    begin: Annotated[int, Column("1", "forcing period with which the window begins")]
    end: Annotated[int, Column("1", "forcing period with which it ends")]
    label: Annotated[str, Column("1", "regime by recurrence alone")]
    period: Annotated[int, Column("1", "n of nT by recurrence; 0: none found", "periodicity")]
    tolerance: Annotated[float, Column("1", "to which the section recurs", "recurs_within")]
    longest: Annotated[int, Column("1", "longest n that was looked for", "longest_periodicity")]
    comb: Annotated[int, Column("1", "n of the nT whose lines do not count as broadband")]
    share: Annotated[float, Column("1", "share of the power beside the lines", "broadband")]
    times: Annotated[int, Column("1", "states in the window", "states")]
    touches: Annotated[int, Column("1", "impacts that begin in the window", "impact_count")]
    periods: Annotated[int, Column("1", "periods in the spectrum", "spectrum_periods")]
    bins: Annotated[int, Column("1", "bins of the spectrum", "spectrum_bins")]
    number: Annotated[int, Column("1", "passages of the limit; -1: there is none", "passages")]
    first: Annotated[float, Column("s", "time of the first", "first_passage")]
    depth: Annotated[float, Column("m", "depth of the deepest", "deepest_passage")]


def contents(
    request: PortraitRequest, views: Sequence[View]
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of the archive of some views, and its datasets with their values."""
    rows = [row_of(_row_of(view)) for view in views]
    periods = [np.arange(w.begin + 1, w.end + 1) for w in (view.column.window for view in views)]
    impacts = np.concatenate([view.contacts for view in views])
    components = request.columns[0].system.scene.components  # of all: they are of one kind
    time = np.concatenate([view.time for view in views])
    bins = sum(view.spectrum.order.size for view in views)
    scales = [
        Scale.counted("row", len(rows), "column of the page", 1),
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
    found = [
        *((entry, table_of([entry], rows)[entry.name]) for entry in columns(_Row)),
        (status, np.full(len(rows), OK)),  # of any other there is no portrait
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
        found.append((Dataset.real(name, ("bin",), units, words), values))
    if impacts.size:
        wall = Dataset.text("wall", ("impact",), "what is struck")
        found.append((wall, impacts["wall"].astype(object)))
        for name, (units, words) in _IMPACTS.items():
            entry = Dataset.real(_of_impact(name), ("impact",), units, words)
            found.append((entry, impacts[name].copy()))
    return scales, found


def views_in(view: ArchiveView, request: PortraitRequest) -> Iterator[View]:
    """Yield the views that an archive holds; `RequestError` where its rows do not fit."""
    names = [entry.name for entry in columns(_Row)]
    table = {name: view[name] for name in names}
    if len(table["label"]) != len(request.columns):
        raise RequestError(f"{view.path} is damaged: its rows are not those of its request")
    impacts, spectra = _impacts_in(view), {name: view[name] for name in _SPECTRUM}
    time, at = view["time"], dict.fromkeys(("time", "impact", "order"), 0)

    def part(name: str, count: int) -> slice:
        begin, at[name] = at[name], at[name] + count
        return slice(begin, at[name])

    for i, column in enumerate(request.columns):
        row = record_of(_Row, {name: values[i] for name, values in table.items()})
        here, bins = part("time", row.times), part("order", row.bins)
        scene = column.system.scene
        yield View(
            column=column,
            time=time[here],
            states=np.column_stack([view[name][here] for name in scene.components]),
            samples=request.samples,
            contacts=impacts[part("impact", row.touches)],
            period=row.period,
            tolerance=row.tolerance,
            longest=row.longest,
            comb=row.comb,
            spectrum=Spectrum(
                **{name: values[bins] for name, values in spectra.items()},
                omega=column.system.parameters["omega"],
                samples=request.samples,
                periods=row.periods,
                window=request.taper,
                quantity=request.signal,
                unit=SIGNALS[request.signal].unit,
            ),
            violation=None if row.number < 0 else Violation(row.number, row.first, row.depth),
        )


def _row_of(view: View) -> _Row:
    begin, end = view.column.window
    limit = Violation(-1, np.nan, np.nan) if view.violation is None else view.violation
    return _Row(
        name=view.column.name,
        system=view.column.system.name,
        begin=begin,
        end=end,
        label=view.label,
        period=view.period,
        tolerance=view.tolerance,
        longest=view.longest,
        comb=view.comb,
        share=np.nan if view.share is None else view.share,
        times=len(view.time),
        touches=len(view.contacts),
        periods=view.spectrum.periods,
        bins=view.spectrum.order.size,
        number=limit.number,
        first=limit.time,
        depth=limit.depth,
    )


def _histories(views: Sequence[View]) -> Iterator[tuple[Dataset, np.ndarray]]:
    """Yield the components of the state over time, and what follows from them."""
    scene = views[0].column.system.scene
    for name in signals_of(scene):
        if name in (*scene.components, *_DERIVED):
            unit, words, of = SIGNALS[name]
            parts = [of(view.column.system, view.states) for view in views]
            yield Dataset.real(name, ("state",), unit, words), np.concatenate(parts)


def _impacts_in(view: ArchiveView) -> np.ndarray:
    """Return the impacts of an archive, rows of dtype `IMPACT`; empty where it has none."""
    found = np.empty(len(view["wall"]) if "wall" in view else 0, IMPACT)
    if found.size:
        found["wall"] = view["wall"]
        for name in _IMPACTS:
            found[name] = view[_of_impact(name)]
    return found


def _of_impact(name: str) -> str:
    """Return the name of the dataset: the force of a history has that name already."""
    return "force_max" if name == "force" else name
