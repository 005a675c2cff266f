"""Records: samples of a force or of the ground's acceleration, and the columns of their files."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass
from functools import cached_property, partial
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nlds_vines.archives.files import open_regular
from nlds_vines.errors import RequestError, at, choice, from_text, number, shown, string, unknown
from nlds_vines.model.loads.courses import ACCELERATIONS, FORCES, TERMS, TIME, Course, polynomial
from nlds_vines.model.setting import OneOf, Text, Truth, setting

LINEAR, CUBIC = "linear", "cubic"

GAP = 1.5
"""A step this many times the median one is a gap."""


@dataclass(frozen=True)
class Numbers:
    """Two or more finite numbers, kept as a tuple."""

    def __call__(self, name: str, value: Any, /) -> tuple[float, ...]:
        if not isinstance(value, list | tuple) or not 2 <= len(value) <= MOST_SAMPLES:
            allowed = f"a list of 2 to {MOST_SAMPLES} numbers"
            raise RequestError(f"{name} = {shown(value)} must be {allowed}")
        return tuple(number(f"{name}, sample {i},", one) for i, one in enumerate(value, 1))


@dataclass(frozen=True, kw_only=True)
class Record(Course):
    """Samples; straight lines between them, or a natural cubic spline; 0 before and after.

    A table names a `file` in place of times and values; the file's samples are then part of the
    request, which says in `source` where they come from.
    """

    times: tuple[float, ...] = setting(MISSING, Numbers(), "", "of the samples [s], ascending")
    values: tuple[float, ...] = setting(MISSING, Numbers(), "", "the samples, in `unit`")
    at: float = setting(0.0, TIME, "", "when the first sample is [s]")
    interpolation: str = setting(
        LINEAR, OneOf((LINEAR, CUBIC), "interpolation"), "",
        "`linear` between samples, or `cubic`: a natural spline",
    )  # fmt: skip
    uneven: bool = setting(False, Truth(), "", "whether steps may differ: what else is a gap")
    source: str = setting("", Text(), "", "where the samples come from")

    kind: ClassVar[str] = "record"

    OF_FILE: ClassVar[tuple[str, ...]] = ("file", "column", "time_unit")
    """Keys of a table that names a file."""

    @classmethod
    def of(cls, given: object) -> Record:
        """Return the record in a file, or in the table itself."""
        if not isinstance(given, Mapping) or "file" not in given:
            return super().of(given)
        with at(f"[{cls.table}]"):
            of_file = {
                key: string(key, given[key]) for key in (*cls.OF_FILE, "unit") if key in given
            }
            if twice := next((key for key in ("times", "values") if key in given), None):
                raise RequestError(f"{twice} stands beside file = {shown(given['file'])}")
            path = Path(of_file["file"])
            found = samples_in(
                path, of_file.get("column", ""), of_file.get("unit", ""),
                of_file.get("time_unit", ""),
            )  # fmt: skip
        rest = {key: value for key, value in given.items() if key not in cls.OF_FILE}
        with at(str(path)):
            return super().of({"source": path.name, **rest, **found._asdict()})

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
        """The largest step between samples [s]."""
        return float(np.diff(self._times).max())

    def summary(self, duration: float) -> str:
        """Return its size, its peak, and how much of it acts within a duration [s], in words."""
        steps, lasts = np.diff(self._times), float(self._times[-1])
        low, high = f"{steps.min():g}", f"{steps.max():g}"
        acts = min(max(duration - self.at, 0.0), lasts)
        found = [
            f"record {self.source}".rstrip(),
            f"{len(self.values)} samples",
            f"step {low} s" if low == high else f"steps {low} to {high} s",
            f"{lasts:g} s long",
            f"peak {max(map(abs, self.values)):g} {self.unit}",
            "all of it acts" if acts == lasts else f"{acts:g} s of it act ({acts / lasts:.1%})",
        ]
        if self.times[0] != self.at:
            found.append(f"moved from {self.times[0]:g} s to {self.at:g} s")
        return ", ".join(found)

    @cached_property
    def _times(self) -> np.ndarray:
        """The times (n,) from the first sample on [s]."""
        return np.array(self.times) - self.times[0]

    @cached_property
    def _pieces(self) -> np.ndarray:
        """The coefficients (n - 1, 4) of the powers of the time from each sample on."""
        y, h = np.array(self.values), np.diff(self._times)
        slopes, found = np.diff(y) / h, np.zeros((len(h), 4))
        found[:, 0], found[:, 1] = y[:-1], slopes
        if self.interpolation == CUBIC:
            m = _curvatures(h, slopes)
            found[:, 1] -= h * (2.0 * m[:-1] + m[1:]) / 6.0
            found[:, 2], found[:, 3] = 0.5 * m[:-1], np.diff(m) / (6.0 * h)
        return found

    @property
    def kinks(self) -> np.ndarray:
        return self.at + self._times

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return zeros: a row holds a polynomial whole."""
        return np.zeros(len(times))

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        rows = np.zeros((len(begins), TERMS))
        piece = np.searchsorted(self.at + self._times, begins + 0.5 * lengths, side="right") - 1
        acts = (piece >= 0) & (piece < len(self._pieces))
        piece = piece[acts]
        since = begins[acts] - (self.at + self._times[piece])
        rows[acts] = polynomial(self._pieces[piece], since, lengths[acts])
        return rows


def _curvatures(h: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the second derivatives (n,) of a natural spline at its samples.

    h_i m_i + 2 (h_i + h_(i+1)) m_(i+1) + h_(i+1) m_(i+2) = 6 (slope_(i+1) - slope_i), m = 0 at both
    ends: eliminated from the first on (Thomas), number by number.
    """
    steps, right = h.tolist(), (6.0 * np.diff(slopes)).tolist()
    above: list[float] = []
    beside: list[float] = []
    upper = value = 0.0
    for i, known in enumerate(right):
        pivot = 2.0 * (steps[i] + steps[i + 1]) - steps[i] * upper
        upper, value = steps[i + 1] / pivot, (known - steps[i] * value) / pivot
        above.append(upper)
        beside.append(value)
    found = [0.0]
    for upper, value in zip(reversed(above), reversed(beside), strict=True):
        found.append(value - upper * found[-1])
    return np.array([*found, 0.0][::-1])


# ---- files ---------------------------------------------------------------------------------------


TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
"""Units of time, in s."""

MOST_SAMPLES = 10**6
"""Samples of a record: hours of an accelerogram."""

_MOST_BYTES = 1 << 27
_MOST_LETTERS = 10_000  # of a line
_HDF5 = (".h5", ".hdf5", ".nc")
_HEADING = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\[(\])]*[\])])?")
"""A heading between blanks: a name, and its unit in brackets, which may stand apart from it."""


class Samples(NamedTuple):
    """What a file holds: times [s], values, and the unit of these."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    unit: str


class Column(NamedTuple):
    """A column of a file: its name and unit, empty if it has none, and a reader of its numbers."""

    name: str
    unit: str
    read: Callable[[], list[float]]


def samples_in(path: Path, column: str, unit: str, time_unit: str) -> Samples:
    """Return the samples in a file.

    Arguments: `column`, the name of that of the values, empty for the first beside the time; `unit`
    of the values and `time_unit`, empty for what the file says.

    The time is the column `time` or `t`; without one, the first column of a text, and the only
    ascending dataset of an HDF5 file, which has no order.  No other column is read.

    Raises `RequestError`, one line with the file and the line, for what cannot be read.
    """
    is_hdf5 = path.suffix.lower() in _HDF5
    columns = _of_archive(path) if is_hdf5 else _of_text(path)
    if len(columns) < 2:
        raise RequestError(f"{path}: needs two columns, time and force or acceleration")
    named_time = (one for one in columns if one.name.lower() in ("time", "t"))
    time = next(named_time, None) or (_ascending(path, columns) if is_hdf5 else columns[0])
    others = [one for one in columns if one is not time]
    if column:
        named = {one.name: one for one in others}
        if column not in named:
            raise unknown(f"column of {path}", column, named)
        found = named[column]
    else:
        found = others[0]
    of_values, of_time = unit or found.unit, time_unit or time.unit or "s"
    if not of_values:
        raise RequestError(
            f"{path}: give the unit of column {found.name or 2!r}, in its heading as "
            f"`acceleration [g]` or as unit; allowed: {', '.join((*FORCES, *ACCELERATIONS))}"
        )
    choice(f"unit of {path}", of_values, (*FORCES, *ACCELERATIONS))
    scale = TIMES[choice(f"unit of time of {path}", of_time, TIMES)]
    times, values = time.read(), found.read()
    if len(times) != len(values):
        raise RequestError(f"{path}: {len(times)} times for {len(values)} values of {found.name!r}")
    return Samples(tuple(scale * t for t in times), tuple(values), of_values)


def _ascending(path: Path, columns: list[Column]) -> Column:
    """Return the only column whose numbers ascend; raise `RequestError` if none or several do."""
    ascending = [one for one in columns if _ascends(one.read())]
    if len(ascending) != 1:
        raise RequestError(
            f"{path}: {len(ascending)} of the datasets {', '.join(one.name for one in columns)} "
            "ascend; allowed: one alone, or a dataset `time` or `t`"
        )
    return ascending[0]


def _ascends(numbers: list[float]) -> bool:
    return len(numbers) > 1 and all(a < b < math.inf for a, b in pairwise(numbers))


def _of_archive(path: Path) -> list[Column]:
    """Return the columns of an HDF5 file: its datasets of one dimension, with their `units`."""
    from nlds_vines.archives import archive

    def read(name: str) -> list[float]:
        return list(archive.column(path, name, MOST_SAMPLES).tolist())

    return [Column(name, unit, partial(read, name)) for name, unit in archive.columns(path)]


def _of_text(path: Path) -> list[Column]:
    """Return the columns of a text file: with or without a line of headings, `#` before notes."""
    lines = _lines(path)
    if not lines:
        raise RequestError(f"{path}: holds no numbers")
    (first, text), *_ = lines
    cut = next((mark for mark in (",", ";", "\t") if mark in text), None)
    words = _split(text, cut)
    headed = not _is_number(words[0])
    if headed and not cut:
        words = _HEADING.findall(text)
    rows = lines[headed:]
    if len(rows) > MOST_SAMPLES:
        raise RequestError(f"{path}: more than {MOST_SAMPLES} samples, which are allowed")

    def read(i: int) -> list[float]:
        numbers = []
        for place, line in rows:
            cells = _split(line, cut)
            if len(cells) != len(words):
                raise RequestError(
                    f"{path}, line {place}: {len(cells)} columns; line {first} has {len(words)}"
                )
            numbers.append(_number(f"{path}, line {place}: value", cells[i]))
        return numbers

    headings = [_heading(word) if headed else ("", "") for word in words]
    return [Column(name, unit, partial(read, i)) for i, (name, unit) in enumerate(headings)]


def _heading(word: str) -> tuple[str, str]:
    """Return a column's name, and its unit in brackets: `acceleration [g]`."""
    name, _, rest = word.replace("(", "[").partition("[")
    return name.strip(), rest.replace(")", "]").partition("]")[0].strip()


def _lines(path: Path) -> list[tuple[int, str]]:
    """Return the lines of a text file with their numbers, without empty ones and notes."""
    try:
        with open_regular(path) as file:
            content = file.read(_MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path}: cannot be read: {reason}") from None
    if len(content) > _MOST_BYTES:
        raise RequestError(f"{path}: has more than {_MOST_BYTES} bytes")
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RequestError(f"{path}: not UTF-8 text at byte {error.start}") from None
    found: list[tuple[int, str]] = []
    lines = io.TextIOWrapper(io.BytesIO(content), encoding="utf-8-sig")  # one at a time
    for i, line in enumerate(lines, 1):
        if len(line) > _MOST_LETTERS:
            raise RequestError(f"{path}, line {i}: has more than {_MOST_LETTERS} letters")
        if stripped := line.partition("#")[0].strip():
            found.append((i, stripped))
        if len(found) > MOST_SAMPLES + 1:  # and a heading
            break
    return found


def _split(line: str, cut: str | None) -> list[str]:
    return [word.strip() for word in line.split(cut)]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _number(what: str, text: str) -> float:
    """Return a number; `RequestError` for a text that is none, and for an empty one."""
    if not text:
        raise RequestError(f"{what} is missing")
    return from_text(float, what, text)
