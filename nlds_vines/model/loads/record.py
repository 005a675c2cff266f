"""Records: samples of a force or of the ground's acceleration, joined by lines or a spline.

`RecordFile.read` returns the samples in a file: an accelerogram as networks write it (`formats`), a
table of text, numbers at a constant step `dt` (`record_text`), or HDF5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.files import read_bytes
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import (
    RequestError,
    at,
    from_text,
    listed,
    number,
    shown,
    table,
    unknown,
    whole,
)
from nlds_vines.model.loads.courses import (
    ACCELERATIONS,
    FORCES,
    TIME,
    UNITS,
    Course,
    canonical,
    polynomial,
    unit_in,
)
from nlds_vines.model.loads.formats import content_of
from nlds_vines.model.loads.record_text import (
    MOST_BYTES,
    MOST_COLUMNS,
    MOST_SAMPLES,
    TIME_UNITS,
    Column,
    Content,
    ascends,
    is_time,
    lines_in,
    read_table,
)
from nlds_vines.model.setting import (
    OneOf,
    Real,
    Text,
    Truth,
    Whole,
    check_settings,
    setting,
    settings_of,
)

LINEAR, CUBIC = "linear", "cubic"
GAP = 1.5  # a step this many times the median one is a gap
MOST_GUESSED = 20  # datasets of an HDF5 file among which times are looked for
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}  # units of time, in s
_HDF5 = (".h5", ".hdf5", ".nc")
_OF_OBSPY = (".sac", ".mseed", ".miniseed", ".ms")
_VERTICAL = (
    "v",
    "z",
    "u",
    "up",
    "down",
    "ud",
    "u-d",
    "ver",
    "vert",
    "vertical",
    "hnz",
    "hgz",
    "hlz",
)


def _column(name: str, value: Any, /) -> int | str:
    if isinstance(value, str):
        is_number = value.isascii() and value.isdigit()
        return from_text(int, name, value) if is_number else value
    return whole(name, value, 0)


@dataclass(frozen=True, kw_only=True)
class RecordFile:
    """A file of samples, and what it does not say of itself."""

    table: ClassVar[str] = "load.record"

    file: str = setting(MISSING, Text(), "", "path of a file, in place of `times` and `values`")
    dt: float = setting(0.0, Real(0.0, 1e6), "", "step between the samples of a file [s]")
    skip: int = setting(0, Whole(0, 10**6), "", "lines to leave out at the beginning of a file")
    column: int | str = setting(
        "", _column, "",
        "name or number of the column of the values; 0: all numbers of a file, row by row",
    )  # fmt: skip
    time_unit: str = setting("", OneOf(("", *TIMES), "time_unit"), "", "`s`, `ms` or `min`")
    decimal: str = setting("", OneOf(("", ".", ","), "decimal"), "", "decimal sign: `.` or `,`")

    def __post_init__(self) -> None:
        check_settings(self)

    def read(self, unit: str) -> dict[str, Any]:
        """Return the settings of the record in the file, of which `unit` gives that of the values.

        A file that can be read in several ways is refused, and so is a key that contradicts it; the
        message names the key that chooses.
        """
        content = self._content(Path(self.file), unit)
        columns = content.columns
        is_indexed = content.is_ordered and _has_index(columns)
        no_index = columns[1:] if is_indexed else columns
        notes = [content.format] if content.format else []
        if content.dt and self.dt and not math.isclose(self.dt, content.dt, rel_tol=1e-6):
            raise RequestError(f"dt = {self.dt:g} s, but the file has steps of {content.dt:g} s")
        dt = content.dt or self.dt
        has_unit = unit or any(one.unit for one in columns)
        also = "" if has_unit else f"; give unit, too, of its values: {', '.join(UNITS)}"
        time = None if dt else _time_of(content._replace(columns=no_index), also)
        stamps = [one for one in columns if is_time(one.name, one.unit)]
        if self.dt and stamps:
            name = _name_of(stamps[0], columns)
            raise RequestError(f"dt = {self.dt:g} s stands beside {name}, which has times")
        others = [one for one in no_index if one is not time and one not in stamps]
        column = self._chosen(content, others or columns)
        if time is not None and stamps:  # the last one before the values, if each has its own
            before = [one for one in stamps if columns.index(one) < columns.index(column)]
            time = before[-1] if before else stamps[0]
        name = _name_of(column, columns)
        if self.dt and not content.dt and column is not columns[0] and content.is_ordered:
            self._refuse_steps_of(columns[0])
        unit = _unit_of(name, column, unit)
        values = column.read()
        if time is None:
            times = [dt * i for i in range(len(values))]
        else:
            time_unit = TIME_UNITS.get((self.time_unit or time.unit or "s").lower())
            if time_unit is None:
                words = ", ".join(TIMES)
                raise RequestError(f"unit of time {time.unit!r}; allowed as time_unit: {words}")
            times = [TIMES[time_unit] * t for t in time.read()]
            if len(times) != len(values):
                text = f"{len(times)} times for {len(values)} values of {column.name!r}"
                raise RequestError(text)
            if not is_time(time.name, time.unit):
                notes.append(f"times [{time_unit}] in {_name_of(time, columns)}")
        unused = [_name_of(one, columns) for one in others if one is not column]
        if unused and self.column == "":
            notes.append(f"values in {name}, not in {', '.join(unused[:20])}")
        elif content.are_components and column.name:
            notes.append(f"component {column.name}")
        return {"times": times, "values": values, "unit": unit, "reading": "; ".join(notes)[:200]}

    def _chosen(self, content: Content, others: list[Column]) -> Column:
        """Return the column of the values: the one that is given, otherwise the first of `others`.

        Of a network's components it is the first one that is not vertical.
        """
        columns = content.columns
        if self.column in ("", 0):
            level = [one for one in others if one.name.lower() not in _VERTICAL]
            return level[0] if content.are_components and level else others[0]
        names = {one.name.lower(): one for one in reversed(others) if one.name}
        chosen = names.get(str(self.column).lower())
        if chosen is None and isinstance(self.column, int):
            numbered = others if content.are_components else columns
            chosen = numbered[self.column - 1] if self.column <= len(numbered) else None
        if chosen is None or chosen not in others:
            allowed = [one.name or str(columns.index(one) + 1) for one in others]
            raise unknown("column", str(self.column), allowed)
        return chosen

    def _refuse_steps_of(self, column: Column) -> None:
        """Refuse `dt` beside a first column that ascends in other steps, unless it counts rows."""
        numbers = np.array(column.read())
        steps = np.diff(numbers)
        is_even = bool(len(steps)) and bool((np.abs(steps - steps[0]) <= 0.01 * steps[0]).all())
        step = float(steps.mean()) if is_even else 0.0
        if step > 0.0 and step != 1.0 and not math.isclose(step, self.dt, rel_tol=1e-3):
            raise RequestError(
                f"dt = {self.dt:g} s, but column 1 ascends in steps of {step:g}: leave out dt"
            )

    def _content(self, path: Path, unit: str) -> Content:
        is_hdf5 = path.suffix.lower() in _HDF5
        data = read_bytes(path, MOST_BYTES, first=8 if is_hdf5 else None)
        if is_hdf5 or data.startswith(b"\x89HDF\r\n\x1a\n"):
            return _content_of_hdf5(path)
        if data.startswith(b"\x93NUMPY"):
            raise RequestError("is an array of NumPy: np.savetxt writes it as text")
        try:
            lines = lines_in(data, self.skip)
        except RequestError as error:
            hint = "; obspy reads SAC and miniSEED" if path.suffix.lower() in _OF_OBSPY else ""
            raise RequestError(f"{error}{hint}") from None
        del data  # which may be 64 MB
        if not lines:
            raise RequestError("holds no numbers")
        content = content_of(lines)
        if content is not None:
            return content
        return read_table(lines, dt=self.dt, column=self.column, decimal=self.decimal, unit=unit)


def _content_of_hdf5(path: Path) -> Content:
    from nlds_vines.archives import hdf5

    def read(name: str) -> list[float]:
        return list(hdf5.column(path, name, MOST_SAMPLES).tolist())

    # datasets of one dimension, of which none is read before it is chosen
    names = hdf5.columns(path)
    if len(names) > MOST_COLUMNS:
        raise RequestError(f"has {len(names)} datasets; allowed: up to {MOST_COLUMNS}")
    columns = [Column(name, unit, cache(partial(read, name))) for name, unit in names]
    if not columns:
        raise RequestError("has no datasets of numbers with one dimension")
    return Content(columns, is_ordered=False)


def _unit_of(name: str, column: Column, given: str) -> str:
    """Return the unit of the values: that of the file, or the one that is given if it has none."""
    if not column.unit:
        if given:
            return given
        raise RequestError(
            f"give the unit of {name}, in its heading as `acceleration [g]` or as unit; "
            f"allowed: {', '.join(UNITS)}"
        )
    stated = canonical(column.unit)
    sizes = {**FORCES, **ACCELERATIONS}
    if given and (stated is None or (given in FORCES) != (stated in FORCES)):
        is_equal = False
    else:
        is_equal = not given or sizes[given] == sizes[stated or given]
    if not is_equal:
        raise RequestError(
            f"unit = {given!r}, but the file states {column.unit!r} of {name}: leave out unit, or "
            "skip the lines that state it"
        )
    return unit_in(f"unit of {name}", column.unit)


def _time_of(content: Content, also: str) -> Column:
    """Return the column of the times: a named one, or the first if it ascends."""
    columns = content.columns
    if len(columns) < 2:
        text = "needs two columns, time and force or acceleration; one column needs dt, its step"
        raise RequestError(f"{text}{also}")
    if named := [one for one in columns if is_time(one.name, one.unit)]:
        return named[0]
    if not content.is_ordered and len(columns) > MOST_GUESSED:
        raise RequestError(
            f"has {len(columns)} datasets; allowed: a dataset `time` or `t`, dt, the step of the "
            f"samples, or up to {MOST_GUESSED} datasets of which one ascends{also}"
        )
    candidates = columns[:1] if content.is_ordered else columns
    ascending = [one for one in candidates if ascends(one.read())]
    if len(ascending) == 1:
        return ascending[0]
    if content.is_ordered:
        raise RequestError(
            "its first column has no ascending times: give dt, the step of its samples, or a "
            f"heading with `time`{also}"
        )
    names = listed(one.name for one in columns)
    raise RequestError(
        f"{len(ascending)} of the datasets {names} ascend; allowed: one alone, a dataset `time` or "
        f"`t`, or dt, the step of the samples{also}"
    )


def _has_index(columns: Sequence[Column]) -> bool:
    """Return True if the first column, without a name beside named ones, counts the rows from 0.

    That is the index of a table of pandas.
    """
    is_named = [bool(one.name) for one in columns]
    if is_named[0] or len(columns) < 2 or not all(is_named[1:]):
        return False
    numbers = columns[0].read()
    return numbers == list(range(len(numbers)))


def _name_of(column: Column, columns: Sequence[Column]) -> str:
    name = column.name or columns.index(column) + 1
    return f"column {name}" if len(columns) > 1 else "its values"


# ---- records as loads ----------------------------------------------------------------------------


def _samples(name: str, value: Any, /) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not 2 <= len(value) <= MOST_SAMPLES:
        raise RequestError(f"{name} = {shown(value)} must be a list of 2 to {MOST_SAMPLES} numbers")
    if set(map(type, value)) == {float} and np.isfinite(samples := np.array(value)).all():
        return tuple((samples + 0.0).tolist())  # -0.0 becomes 0.0, as in `number`
    return tuple(number(f"{name}, sample {i},", one) for i, one in enumerate(value, 1))


@dataclass(frozen=True, kw_only=True, repr=False)
class Record(Outlined, Course):
    """Samples joined by straight lines or a natural cubic spline; 0 before and after."""

    times: tuple[float, ...] = setting(MISSING, _samples, "", "of the samples [s], ascending")
    values: tuple[float, ...] = setting(MISSING, _samples, "", "the samples, in `unit`")
    at: float = setting(0.0, TIME, "", "when the first sample is [s]")
    interpolation: str = setting(
        LINEAR, OneOf((LINEAR, CUBIC), "interpolation"), "",
        "`linear` between samples, or `cubic`: a natural spline",
    )  # fmt: skip
    uneven: bool = setting(False, Truth(), "", "whether steps may differ: what else is a gap")
    source: str = setting("", Text(), "", "where the samples come from")
    reading: str = setting("", Text(), "", "how their file was read, where it does not say so")

    def heading(self) -> str:
        return self.source

    def outline(self) -> Rows:
        yield "samples", ", ".join(self._facts(math.inf))
        if self.reading:
            yield "read as", self.reading

    @classmethod
    def of(cls, entry: object) -> Record:
        if isinstance(entry, str):
            entry = {"file": entry}
        if not isinstance(entry, Mapping) or "file" not in entry:
            return super().of(entry)
        of_file = settings_of(RecordFile)  # keys that a table with a file has as well
        with at(f"[{cls.table}]"):
            if twice := next((key for key in ("times", "values") if key in entry), None):
                raise RequestError(f"{twice} stands beside file = {shown(entry['file'])}")
            keys = [one.key for one in settings_of(cls).values()]
            entry = table(cls.kind, entry, [*of_file, *keys])
            unit = unit_in("unit", entry["unit"]) if "unit" in entry else ""
            if isinstance(entry["file"], list | tuple):
                raise RequestError(
                    f"file = {shown(entry['file'])}: several files are a suite, [load.suite]"
                )
            file = RecordFile(**{key: entry[key] for key in of_file if key in entry})
            path = Path(file.file)
            with at(str(path)):
                samples = file.read(unit)
        rest = {key: value for key, value in entry.items() if key not in of_file}
        with at(str(path)):
            return super().of({"source": path.name, **rest, **samples})

    def check(self) -> None:
        if len(self.times) != len(self.values):
            raise RequestError(f"{len(self.times)} times for {len(self.values)} values")
        steps = np.diff(self._times)
        if (steps <= 0.0).any():
            i = int(np.flatnonzero(steps <= 0.0)[0])
            raise RequestError(
                f"times must ascend: sample {i + 2} at {self.times[i + 1]:g} s follows one at "
                f"{self.times[i]:g} s"
            )
        usual = float(np.median(steps))
        if not self.uneven and (steps > GAP * usual).any():
            i = int(np.flatnonzero(steps > GAP * usual)[0])
            raise RequestError(
                f"a gap of {steps[i]:g} s after {self.times[i]:g} s, where steps are of {usual:g} "
                "s; allowed with uneven = true"
            )

    @property
    def step(self) -> float:
        return float(np.diff(self._times).max())

    def words(self) -> str:
        return f"record {self.source or len(self.values)}"

    def summary(self, duration: float) -> str:
        words = [f"record {self.source}".rstrip(), *self._facts(duration)]
        if self.times[0] != self.at:
            words.append(f"moved from {self.times[0]:g} s to {self.at:g} s")
        return ", ".join(words) + (f" ({self.reading})" if self.reading else "")

    def _facts(self, duration: float) -> list[str]:
        """Return samples, step, length and peak in words, of a run of `duration` [s]."""
        steps = np.diff(self._times)
        length = float(self._times[-1])
        low, high = f"{steps.min():g}", f"{steps.max():g}"
        within = min(max(duration - self.at, 0.0), length)
        values = np.array(self.values)
        peak = int(np.argmax(np.abs(values)))
        return [
            f"{len(values)} samples",
            f"step {low} s" if low == high else f"steps {low} to {high} s",
            f"{length:g} s" + ("" if within == length else f", of which {within:g} s are computed"),
            f"peak {abs(values[peak]):g} {self.unit} at {self._times[peak]:g} s",
        ]

    @cached_property
    def _times(self) -> np.ndarray:
        """The times (n,) [s] from the first sample on."""
        return np.array(self.times) - self.times[0]

    @cached_property
    def _pieces(self) -> np.ndarray:
        """The coefficients (n + 1, 2 or 4) of the powers of the time from each sample on.

        The first row, before the first sample, and the last one are 0.  The second derivatives m of
        a natural spline are 0 at both ends, and follow from h_i m_i + 2 (h_i + h_(i+1)) m_(i+1)
        + h_(i+1) m_(i+2) = 6 (slope_(i+1) - slope_i) between them.
        """
        y, h = np.array(self.values), np.diff(self._times)
        is_cubic, slopes = self.interpolation == CUBIC, np.diff(y) / h
        pieces = np.zeros((len(y) + 1, 4 if is_cubic else 2))
        pieces[1:-1, 0], pieces[1:-1, 1] = y[:-1], slopes
        if not is_cubic:
            return pieces
        # elimination from the first sample on (Thomas), number by number
        steps, eliminated = h.tolist(), list[tuple[float, float]]()
        upper = value = 0.0
        for i, side in enumerate((6.0 * np.diff(slopes)).tolist()):
            pivot = 2.0 * (steps[i] + steps[i + 1]) - steps[i] * upper
            upper, value = steps[i + 1] / pivot, (side - steps[i] * value) / pivot
            eliminated.append((upper, value))
        curvatures = [0.0]
        for upper, value in reversed(eliminated):
            curvatures.append(value - upper * curvatures[-1])
        m = np.array([*curvatures, 0.0][::-1])
        pieces[1:-1, 1] -= h * (2.0 * m[:-1] + m[1:]) / 6.0
        pieces[1:-1, 2], pieces[1:-1, 3] = 0.5 * m[:-1], np.diff(m) / (6.0 * h)
        return pieces

    @property
    def kinks(self) -> np.ndarray:
        return self.at + self._times

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.zeros(len(times))

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        kinks = self.kinks
        piece = np.searchsorted(kinks, begins + 0.5 * lengths, side="right")
        return polynomial(self._pieces[piece], begins - kinks[piece - 1], lengths)
