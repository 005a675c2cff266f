"""Response histories read from an archive: a history of each system, or the values of a scan."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.files import Csv
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.engine.records import OK, STATUS
from nlds_vines.errors import RequestError, choice, library
from nlds_vines.loads.datasets import SENSITIVE, names_of_numbers, owners_of
from nlds_vines.loads.request import HistoryRequest, load_response_history
from nlds_vines.loads.units import shown_in
from nlds_vines.model.linear_response import energy_after_blow
from nlds_vines.model.quantities import HISTORIES, SHARES, TOUCH_COLUMNS, WAYS, of_load
from nlds_vines.plotting.drawable import Drawable


@dataclass(frozen=True, repr=False)
class ResponseHistory(Outlined):
    """The response of one system to a load.

    Values that the system does not have (without a damper, without walls) are NaN, and so is
    everything if the orbit failed; numbers of impacts are then -1.

    Attributes
    ----------
    time : (n,) ndarray
        From 0 to the duration [s].
    E1 : (n,) ndarray
        Energy of the structure [J].
    E2 : (n,) ndarray or mapping of str to it
        Energy of the damper [J]; by name, if the dampers have names.
    x1, x2 : (n,) ndarray
        Displacements of structure and damper [m] of the paper's kinds, relative to the ground.
    work : (n,) ndarray
        Energy supplied so far [J].
    dissipated : mapping of str to (n,) ndarray
        Energy dissipated so far [J] by `c1`, `c2` and `contact`.
    numbers : mapping of str to float
        The quantities of the response, such as `x1_max` [m] and `a1_max` [m/s^2]; of displacements
        and of dampers with names `roof.x_max`, `cell.impact_count`.  All names are in the tables of
        `loads-in-time`.
    status : int
        0 unless the orbit failed.
    x, a : mapping of str to (n,) ndarray
        By name, displacements [m], relative to the ground, and absolute accelerations [m/s^2].
    stroke : mapping of str to (n,) ndarray
        By damper, the displacement r of its spring [m].
    impacts : mapping of str to (impacts,) ndarray
        Columns of the impacts in the order of touches: times `touch` and `release` [s], approach
        `speed` [m/s], largest `force` [N] and `depth` [m], `impulse` [N s] of a rigid wall, the
        `damper`, and its `wall`: the side, "+" or "-", or what is struck of the paper's kinds.
    """

    time: np.ndarray
    E1: np.ndarray
    E2: Any
    x1: np.ndarray
    x2: np.ndarray
    work: np.ndarray
    dissipated: Mapping[str, np.ndarray]
    numbers: Mapping[str, float]
    status: int = OK
    x: Mapping[str, np.ndarray] = field(default_factory=dict)
    a: Mapping[str, np.ndarray] = field(default_factory=dict)
    stroke: Mapping[str, np.ndarray] = field(default_factory=dict)
    impacts: Mapping[str, np.ndarray] = field(default_factory=dict)
    is_sensitive: bool = False

    @property
    def last(self) -> np.ndarray:
        """The last times (3,) [s] at which E1 exceeds 1, 10 and 50 % of its largest value.

        NaN if E1 exceeds it at the end.
        """
        return np.array([self.numbers[f"last_{100 * share:g}"] for share in SHARES])

    def heading(self) -> str:
        of_dampers = [n for name, n in self.numbers.items() if _quantity(name) == "impact_count"]
        counts = [count for count in of_dampers if count >= 0]
        impacts = f"{sum(counts)} impacts in " if counts else ""
        return f"{impacts}{self.time[-1]:g} s"

    def outline(self) -> Rows:
        yield "numbers", numbers({k: v for k, v in self.numbers.items() if not _is_missing(v)})


def _quantity(name: str) -> str:
    """Return the name of a quantity without its owner."""
    return name.rpartition(".")[2]


def _is_missing(value: float) -> bool:
    """Return True for the fill values of quantities and counts."""
    return math.isnan(value) or (isinstance(value, int) and value < 0)


_ONE_OF_MANY = (
    "loads larger by 1e-12 of themselves give another number of impacts: the history is chaotic, "
    "and its numbers are one sample; a suite or --vary scale=0.98:1.02:21 shows their spread"
)

PEAKS = (
    "x1_max", "x_max", "drift_ratio_max", "drift_ratio", "a1_max", "a_max", "stroke_max",
    "force_max", "impulse_max", "shear_max",
)  # fmt: skip
"""The largest responses that are compared."""


def compared_names(request: HistoryRequest, names: Iterable[str]) -> list[str]:
    """Return the names of the largest responses that are compared, in the order of `PEAKS`.

    Accelerations of one floor relative to another are left out where heights make that a storey.
    """
    compared = []
    for peak in PEAKS:
        for name in names:
            owner, _, quantity = name.rpartition(".")
            is_between = owner in request.heights and "-" in owner
            if quantity == peak and not (peak == "a_max" and is_between):
                compared.append(name)
    return compared


def aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table, the first column to the left and the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([first.ljust(widths[0]), *cells])


class Peak(NamedTuple):
    """A largest response: whose, of what, in its unit, and 1 - value / value without a damper."""

    system: str
    quantity: str
    value: float
    unit: str
    reduction: float


@dataclass(frozen=True, repr=False)
class ResponseHistories(Csv, Drawable):
    """The responses of systems to a load.

    Attributes
    ----------
    path : ArchivePath
        Archive of the results.
    request : HistoryRequest
        Request that computes them again.
    results : mapping of str to ResponseHistory
        The response of each system by its name; `histories["tmd"]` is one of them.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> histories = nv.response_history("tmd", impulse=300.0, duration=2.0, quiet=True)
    >>> round(histories["tmd"].numbers["x1_max"], 4)
    0.0441
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    results: Mapping[str, ResponseHistory]

    def __getitem__(self, name: str) -> ResponseHistory:
        """Return the response of one system by its name."""
        return self.results[choice("system", name, self.results)]

    @property
    def failed(self) -> int:
        """The number of orbits that failed."""
        return sum(history.status != OK for history in self.results.values())

    @property
    def times(self) -> dict[float, float]:
        """The last times [s] at which E1 exceeds fractions of its largest value; one system only.

        NaN if E1 exceeds it at the end.
        """
        return dict(zip(SHARES, self._only().last.tolist(), strict=True))

    @property
    def dissipated(self) -> dict[str, float]:
        """The fractions of the supplied energy dissipated by dashpots and contacts; one system."""
        return shares_of(self._only())

    def _only(self) -> ResponseHistory:
        first, *others = self.results
        if others:
            raise RequestError(f"name the system: [{first!r}], of {[*self.results]}")
        return self.results[first]

    def comparison(self) -> list[Peak]:
        """Return the largest responses that an engineer compares, of each system.

        Returns
        -------
        list of Peak
            Displacement (drift), absolute acceleration, stroke, contact force or impulse, and base
            shear of each system that has them, with the reduction against the first system without
            a damper that has them.  The contact force of a general system's rigid walls is
            infinite, and so is the acceleration where their impulses act.
        """
        alone = [system.name for system in self.request.systems if not system.damper_names]
        every = names_of_numbers(self.request)
        names = compared_names(self.request, every)
        peaks = []
        for name in names:
            values = {system: one.numbers[name] for system, one in self.results.items()}
            bases = [values[system] for system in alone if not math.isnan(values[system])]
            base = bases[0] if bases else math.nan
            for system, value in values.items():
                reduction = math.nan
                if 0.0 < base < math.inf and system not in alone and math.isfinite(value):
                    reduction = 1.0 - value / base
                if not math.isnan(value):
                    peaks.append(Peak(system, name, value, of_load(name).unit, reduction))
        return peaks

    def csv_rows(self) -> list[Any]:
        """Return the `comparison` under the names of its columns."""
        return [Peak._fields, *self.comparison()]

    def rows(self) -> list[list[str]]:
        """Return the comparison as a table of texts: a row for each quantity, a column a system."""
        peaks = self.comparison()
        systems = [system.name for system in self.request.systems]
        rows = [["", *systems]]
        for name in dict.fromkeys(peak.quantity for peak in peaks):
            of_name = {peak.system: peak for peak in peaks if peak.quantity == name}
            values = [peak.value for peak in of_name.values()]
            factor, unit = shown_in(name, values, self.request.load.shaken)
            cells = [f"{name} [{unit}]" if unit != "1" else name]
            for system in systems:
                if system not in of_name:
                    cells.append("-")
                    continue
                peak = of_name[system]
                change = f" ({-peak.reduction:+.1%})" if np.isfinite(peak.reduction) else ""
                cells.append(f"{factor * peak.value:.4g}{change}")
            rows.append(cells)
        return rows

    def _table(self) -> Iterator[str]:
        yield from aligned(self.rows())
        for system, history in zip(self.request.systems, self.results.values(), strict=True):
            instant = [law.name for law in system.contact_laws if law.instant]
            has_no_acceleration = math.isnan(history.numbers.get("a1_max", 0.0))
            if instant and has_no_acceleration and math.isfinite(history.numbers["x1_max"]):
                yield (
                    f"-: under law {instant[0]} a contact has an impulse and no force, and a1_max "
                    "does not exist: law linear or hertz gives both"
                )
                break
        yield from remarks_on_rigid_walls(self.comparison())

    def lines(self) -> Iterator[str]:
        """Yield the title, the records, a line for each system, and of several the comparison."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        each = zip(self.request.systems, self.request.words, self.results.values(), strict=True)
        for system, words, history in each:
            if history.status != OK:
                status = STATUS[history.status]
                yield f"{words}: {status.name}. {status.remedy}"
                continue
            if history.numbers["E1max"] == 0.0:
                yield f"{words}: at rest for {self.request.duration:g} s"
                continue
            yield f"{words}: {'; '.join(self._facts(history))}"
            if history.is_sensitive:
                yield f"{words}: {_ONE_OF_MANY}"
            exact = {} if self.request.state else system.closed_form(self.request.load)
            comparisons = [
                f"{name} {exact[name]:.6g} (here {history.numbers[name]:.6g})"
                for name in ("E1max", "x1_max", "x1_rms", "share_c1", "share_c2")
                if name in exact
            ]
            if "E1max" in exact:
                some = slice(None, None, 1 + history.time.size // 500)
                energy = energy_after_blow(system, self.request.load, history.time[some])
                error = abs(history.E1[some] - energy).max() / exact["E1max"]
                comparisons.append(f"E1 over time (here but for {error:.0e} of E1max)")
            if comparisons:
                yield f"  in closed form: {', '.join(comparisons)}"
        if len(self.results) > 1 and self.failed < len(self.results):
            yield from self._table()

    def _facts(self, history: ResponseHistory) -> Iterator[str]:
        """Yield how far a system moves, how long it does, and what dissipates or strikes."""
        largest = history.numbers.get("x1_max", math.nan)
        if math.isfinite(largest):
            frame = " relative to the ground" if self.request.load.shaken else ""
            yield f"x1{frame} up to {largest:.4g} m"
        last = ", ".join(
            f"{share:.0%} " + (f"until {time:.4g} s" if np.isfinite(time) else "to the end")
            for share, time in zip(SHARES[::-1], history.last[::-1], strict=True)
        )
        yield f"E1 above {last}"
        if shares := shares_of(history):
            sinks = ", ".join(f"{sink} {share:.1%}" for sink, share in shares.items())
            yield f"dissipated by {sinks}"
        struck = []
        for name, count in history.numbers.items():
            owner, _, quantity = name.rpartition(".")
            if owner and quantity == "impact_count" and count >= 0:
                struck.append(f"{count} of {owner}")
        if struck:
            yield f"impacts: {', '.join(struck)}"


def remarks_on_rigid_walls(numbers: Sequence[Peak | Statistic]) -> Iterator[str]:
    """Yield a line that says why accelerations are infinite, and which number says how hard."""
    infinite = []
    for one in numbers:
        largest = one.value if isinstance(one, Peak) else one.largest
        if one.quantity.endswith("a_max") and math.isinf(largest):
            infinite.append(one.quantity)
    if infinite:
        names = ", ".join(dict.fromkeys(infinite))
        yield (
            f"{names}: infinite where the impulse of a rigid wall acts, for an instant; "
            "impulse_max says how hard, and law hertz or linear gives a finite acceleration"
        )


QUANTILE = 0.84  # of a suite, beside the median: one standard deviation above, if it is normal
STATISTICS = "statistics"  # names the table of them for `to_dataframe`


class Statistic(NamedTuple):
    """A quantity of a system over the records of a suite: median, 84 % quantile, extremes."""

    system: str
    quantity: str
    unit: str
    median: float
    quantile_84: float
    smallest: float
    largest: float
    records: int


def quantile_of(values: np.ndarray, share: float) -> float:
    """Return a quantile of values, interpolated linearly, as `numpy.quantile` has it.

    But between two infinite values, which are the largest ones, it is infinite and not NaN.
    """
    ascending = np.sort(values)
    place = share * (len(ascending) - 1)
    below = ascending[math.floor(place)]
    above = ascending[math.ceil(place)]
    if below == above:
        return float(below)
    return float(below + (place - math.floor(place)) * (above - below))


@dataclass(frozen=True, repr=False)
class LoadScan(Csv, Drawable):
    """Quantities of the responses of systems over records, parameters and numbers of the load.

    Attributes
    ----------
    path : ArchivePath
        Archive of the results.
    request : HistoryRequest
        Request that computes them again; its `vary` has the axes.
    numbers : mapping of str to ndarray
        Quantities by name, each with a dimension for the systems, one for the records of a suite
        and one for each axis; `scan["x1_max"]` is one of them.  NaN, of numbers of impacts -1,
        where a system has none.
    status : ndarray of int
        Of the same shape; 0 unless the orbit failed.
    is_sensitive : ndarray of bool, optional
        Of a suite: where loads larger by 1e-12 of themselves give other numbers of impacts.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> blows = {"impulse": {"values": [100.0, 200.0]}}
    >>> scan = nv.response_history("tmd", vary=blows, duration=2.0, quiet=True)
    >>> scan["x1_max"].round(4).tolist()
    [[0.0147, 0.0294]]
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    numbers: Mapping[str, np.ndarray]
    status: np.ndarray
    is_sensitive: np.ndarray | None = None

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a quantity of all orbits by its name."""
        return self.numbers[choice("number", name, self.numbers)]

    @property
    def failed(self) -> int:
        """The number of orbits that failed."""
        return int(np.count_nonzero(self.status != OK))

    @property
    def loads(self) -> tuple[str, ...]:
        """The names of the records of a suite, in the order of their dimension."""
        return self.request.load.names

    def over_records(self, name: str, share: float = 0.5) -> np.ndarray:
        """Return a quantile over the records of a suite of a quantity, by default the median.

        Parameters
        ----------
        name : str
            The quantity.
        share : float, optional
            The share of records that do not exceed the quantile, 0 to 1.

        Returns
        -------
        ndarray
            With a dimension for the systems and one for each axis; orbits that failed are left out,
            and NaN stands where none is left.

        Raises
        ------
        RequestError
            If there is no suite, or no such quantity.
        """
        if not self.loads:
            raise RequestError("there is no suite; load=[...] of several records is one")
        if not 0.0 <= share <= 1.0:
            raise RequestError(f"share = {share:g}; allowed: 0 to 1")
        values = self._present(name)
        rows = np.moveaxis(values, 1, -1).reshape(-1, len(self.loads))
        quantiles = np.full(len(rows), np.nan)
        for place, row in enumerate(rows):
            present = row[~np.isnan(row)]
            if present.size:
                quantiles[place] = quantile_of(present, share)
        return quantiles.reshape(values.shape[0], *values.shape[2:])

    def _present(self, name: str) -> np.ndarray:
        """Return a quantity as floats: NaN where it is missing, inf for a last time yet to come."""
        values = self[name]
        present = np.where(values == of_load(name).fill, np.nan, values)
        if name.startswith("last_"):
            present = np.where(np.isnan(present) & (self.status == OK), np.inf, present)
        return present

    def statistics(self) -> list[Statistic]:
        """Return median, 84 % quantile and extremes over the records of a suite.

        Returns
        -------
        list of Statistic
            For each quantity and each system that has it, over all records whose orbits did not
            fail.  A last time that has not come is infinite.

        Raises
        ------
        RequestError
            If there is no suite, or if parameters vary: `over_records` has quantiles along axes.
        """
        if self.request.vary:
            names = " and ".join(self.request.dims[1:])
            raise RequestError(f"statistics along {names}: over_records(name, share) has them")
        medians = {name: self.over_records(name) for name in self.numbers}
        quantiles = {name: self.over_records(name, QUANTILE) for name in self.numbers}
        rows = []
        for name in self.numbers:
            present = self._present(name)
            for place, system in enumerate(self.request.systems):
                values = present[place][~np.isnan(present[place])]
                if not values.size:
                    continue
                row = Statistic(
                    system=system.name,
                    quantity=name,
                    unit=of_load(name).unit,
                    median=float(medians[name][place]),
                    quantile_84=float(quantiles[name][place]),
                    smallest=float(values.min()),
                    largest=float(values.max()),
                    records=int(values.size),
                )
                rows.append(row)
        return rows

    def csv_rows(self) -> list[Any]:
        """Return the `statistics` of a suite under the names of their columns."""
        return [Statistic._fields, *self.statistics()]

    def to_dataframe(self, *names: str) -> Any:
        """Return a `pandas.DataFrame`, by default of all datasets with one value for each orbit.

        `to_dataframe("statistics")` has the rows of `statistics`.
        """
        if names == (STATISTICS,):
            return library("pandas").DataFrame(self.statistics(), columns=Statistic._fields)
        return super().to_dataframe(*names)

    def rows(self) -> list[list[str]]:
        """Return the largest responses as a table of texts: median and 84 % quantile by system.

        The change of the median is that from the first structure without dampers.
        """
        statistics = {(one.quantity, one.system): one for one in self.statistics()}
        systems = [system.name for system in self.request.systems]
        alone = [system.name for system in self.request.systems if not system.damper_names]
        rows = [["median (84 %)", *systems]]
        for name in compared_names(self.request, self.numbers):
            of_name = {system: statistics.get((name, system)) for system in systems}
            present = [one for one in of_name.values() if one is not None]
            if not present:
                continue
            bases = [one.median for one in present if one.system in alone]
            base = bases[0] if bases else math.nan
            extremes = [one.largest for one in present]
            factor, unit = shown_in(name, extremes, self.request.load.shaken)
            cells = [f"{name} [{unit}]" if unit != "1" else name]
            for system, one in of_name.items():
                if one is None:
                    cells.append("-")
                    continue
                text = f"{factor * one.median:.4g} ({factor * one.quantile_84:.4g})"
                if system not in alone and 0.0 < base < math.inf and one.median < math.inf:
                    text += f" {one.median / base - 1.0:+.1%}"
                cells.append(text)
            rows.append(cells)
        return rows

    def _table(self) -> Iterator[str]:
        """Yield the table of the largest responses, and what its numbers do not say."""
        yield from aligned(self.rows())
        compared = compared_names(self.request, self.numbers)
        yield from remarks_on_rigid_walls(
            [one for one in self.statistics() if one.quantity in compared]
        )
        if self.is_sensitive is not None:
            sensitive = self.is_sensitive.sum(axis=1).tolist()
            for words, count in zip(self.request.words, sensitive, strict=True):
                if count:
                    yield f"{words}: under {count} of {len(self.loads)} records {_ONE_OF_MANY}"

    def lines(self) -> Iterator[str]:
        """Yield the title, records, axes, statistics or the range of a number, and failures."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        yield from (axis.heading() for axis in self.request.vary)
        if self.loads and not self.request.vary:
            yield from self._table()
            yield from self._failures()
            return
        finite = [name for name, values in self.numbers.items() if np.isfinite(values).any()]
        for name in finite[:1]:
            values = self.numbers[name]
            for words, row in zip(self.request.words, values, strict=True):
                finite = row[np.isfinite(row)]
                span = f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "none"
                orbits = f"{finite.size} of {row.size} orbits"
                yield f"{words}: {name} from {span} in {orbits}"
        yield from self._failures()

    def _failures(self) -> Iterator[str]:
        codes, counts = np.unique(self.status[self.status != OK], return_counts=True)
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True):
            status = STATUS[code]
            yield f"{count} of {self.status.size} orbits: {status.name}. {status.remedy}"


def shares_of(history: ResponseHistory) -> dict[str, float]:
    """Return the fractions of the supplied energy that each existing sink dissipated."""
    shares = {sink: history.numbers.get(f"share_{sink}", math.nan) for sink in WAYS}
    return {sink: share for sink, share in shares.items() if np.isfinite(share)}


def histories_in(path: str | os.PathLike[str]) -> ResponseHistories | LoadScan:
    with read(path) as view:
        request = view.request(RESPONSE_HISTORY, load_response_history)
        place, codes, names = ArchivePath.of(view.path), view["status"], names_of_numbers(request)
        values = {
            name: view[dataset] if column is None else view[dataset][..., column]
            for name, (dataset, column) in names.items()
            if dataset in view
        }
        if request.is_scan:
            sensitive = view[SENSITIVE] == 1 if SENSITIVE in view else None
            return LoadScan(place, request, values, codes, sensitive)
        results: dict[str, ResponseHistory] = {}
        for i, system in enumerate(request.systems):
            of_system = {name: _number(values.get(name), of_load(name).fill, i) for name in names}
            histories = {name: _history(view, request, name, i) for name in HISTORIES}
            dissipated = {sink: histories.pop(f"dissipated_{sink}") for sink in WAYS}
            results[system.name] = ResponseHistory(
                time=request.times,
                **histories,
                dissipated=dissipated,
                numbers=of_system,
                status=int(codes[i]),
                impacts=_impacts(view, request, i),
                is_sensitive=SENSITIVE in view and bool(view[SENSITIVE][i] == 1),
            )
        return ResponseHistories(place, request, results)


def _number(values: np.ndarray | None, fill: Any, number: int) -> Any:
    """Return a quantity of a system by its number; the `fill` where it is NaN or not recorded."""
    if values is None:
        return fill
    value = values[number].item()
    return fill if math.isnan(value) else value


def _history(view: ArchiveView, request: HistoryRequest, name: str, number: int) -> Any:
    """Return a history of a system by its number: an array, or arrays by owner.

    An array is NaN if the archive has no such history.
    """
    system = request.systems[number]
    missing = np.full(len(request.times), np.nan)
    rows = view[name][number] if name in view else missing
    dims = HISTORIES[name].dims
    if not dims:
        return rows
    owners = owners_of(request)[dims[0]]
    if name == "E2" and system.scene.has_symbols:
        if not system.damper_names:
            return missing
        return rows[owners.index(system.damper_names[0])] if owners else rows
    if name not in view:
        return dict.fromkeys(owners, missing)
    return dict(zip(owners, rows, strict=True))


def _impacts(view: ArchiveView, request: HistoryRequest, number: int) -> dict[str, np.ndarray]:
    """Return the columns of the recorded impacts of a system by its number in the request."""
    if "impact_system" not in view:
        return dict.fromkeys(TOUCH_COLUMNS, np.zeros(0))
    system = request.systems[number]
    own = view["impact_system"] == number
    columns = {name: view[f"impact_{name}"][own] for name in TOUCH_COLUMNS}
    # a structure that strikes walls itself has no damper
    dampers = np.array(owners_of(request)["damper"] or system.damper_names or [""], dtype=str)
    columns["damper"] = dampers[columns["damper"].astype(int)]
    columns["wall"] = np.array(system.scene.sides, dtype=str)[(columns["wall"] < 0.0).astype(int)]
    return columns
