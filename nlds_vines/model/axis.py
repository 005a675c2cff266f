"""Axes, intervals and tables of samples: parameters with their values or their bounds."""

from __future__ import annotations

import csv
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.files import decoded, read_bytes
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import (
    Reordered,
    RequestError,
    at,
    choice,
    from_text,
    number,
    refuse_bytes,
    shown,
    string,
    table,
    whole,
)
from nlds_vines.model.parameters import (
    DESCRIBED,
    INITIAL,
    PARAMETERS,
    RATIOS,
    ends_in_words,
    with_unit,
)

LINEAR, LOG = "linear", "log"  # scales of a range: values at equal distances, or at equal ratios
MOST_BYTES = 1 << 28  # of a file of samples
MOST_VALUES = 10**7  # more than can be computed, fewer than fill the memory
_DIGITS = 50  # of a common ratio: its powers are exact to far more digits than a float has


@dataclass(frozen=True, eq=False, repr=False)
class Axis(Outlined):
    """One varied parameter, initial condition or ratio, and its values."""

    name: str
    values: np.ndarray  # (n,) [SI]: different, finite, sorted, read-only
    stated: Axis | None = None  # that of a ratio from which this one follows, as f for omega

    def __post_init__(self) -> None:
        string("name of an axis", self.name)
        sequence: Any = self.values
        refuse_masked(self.name, sequence)
        if hasattr(sequence, "__array__"):
            sequence = np.asarray(sequence)
        if not _is_sequence(sequence):
            raise RequestError(f"values = {shown(sequence)} must be a list of numbers")
        if not 1 <= len(sequence) <= MOST_VALUES:
            text = f"{self.name} has {len(sequence)} values; allowed: from 1 to {MOST_VALUES}"
            raise RequestError(text)
        is_array = isinstance(sequence, np.ndarray)
        if is_array and sequence.dtype.kind in "iuf" and np.isfinite(sequence).all():
            unsorted = sequence.astype(np.float64) + 0.0  # -0.0 becomes 0.0, as `number` has it
        else:
            entries = sequence.tolist() if is_array else sequence
            unsorted = np.array([number(self.name, value) for value in entries])
        values = np.sort(unsorted)
        equal = values[1:][np.diff(values) == 0]
        if equal.size:
            raise RequestError(f"{self.name} takes the value {float(equal[0])!r} more than once")
        if not np.array_equal(values, unsorted):
            text = f"{self.name}: its values are sorted, {values[0]:g} to {values[-1]:g}"
            warnings.warn(text, Reordered, stacklevel=3)
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @property
    def as_stated(self) -> Axis:
        """The axis that the request states: f [Hz] if omega follows from it, else this one."""
        return self.stated or self

    def heading(self) -> str:
        name, values = self.as_stated.name, self.as_stated.values
        ends = ends_in_words(name, float(values[0]), float(values[-1]))
        return f"{name} = {ends}, {values.size} value{'s' * (values.size > 1)}"

    def outline(self) -> Rows:
        return ()

    def entry(self) -> dict[str, dict[str, list[float]]]:
        return {self.as_stated.name: {"values": self.as_stated.values.tolist()}}

    @classmethod
    def spaced(
        cls, name: str, start: object, stop: object, num: object, scale: object = LINEAR
    ) -> Axis:
        first, last = number("start", start), number("stop", stop)
        count = whole("num", num, 1, MOST_VALUES)
        if first > last:
            raise RequestError(f"start = {first!r} must not be greater than stop = {last!r}")
        if choice("scale", scale, (LINEAR, LOG)) == LINEAR:
            with np.errstate(all="ignore"):
                return cls(name, np.linspace(first, last, count))
        if first <= 0.0:
            raise RequestError(f"start = {first!r} must be > 0 where scale = {LOG!r}")
        if count == 1:
            return cls(name, np.array([first]))
        # powers of the common ratio, rounded from `_DIGITS` digits: the same bits on every machine,
        # which no library's exponential guarantees, and exactly 1e6 between 1e5 and 1e7
        with localcontext() as context:
            context.prec = _DIGITS
            value = Decimal(first)
            ratio = (Decimal(last) / value) ** (1 / Decimal(count - 1))
            values = [first]
            for _ in range(count - 2):
                value *= ratio
                values.append(float(value))
        return cls(name, np.array([*values, last]))

    @classmethod
    def of(cls, name: str, entry: Any) -> Axis:
        """Return the axis of an entry of `[vary]`: a table, or a sequence or an array of values."""
        if _is_sequence(entry):
            return cls(name, entry)
        entries = table(name, entry, ("start", "stop", "num", "scale", "values"))
        if entries.keys() == {"values"}:
            return cls(name, entries["values"])
        if entries.keys() - {"scale"} == {"start", "stop", "num"}:
            return cls.spaced(name, **entries)
        raise RequestError(
            f"{', '.join(entries) or 'nothing'} given; allowed: start, stop and num (and scale), "
            "or values alone"
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Axis):
            return NotImplemented
        return self.name == other.name and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash((self.name, self.values.tobytes()))


def refuse_masked(name: str, values: Any) -> None:
    """Refuse an array with masked entries, whose mask would be lost and the entries taken."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise RequestError(f"{name} has masked entries, which have no value: fill them first")


def real_array(what: str, values: Any) -> np.ndarray:
    """Return an array of finite floats; `RequestError` for texts, masked and complex values."""
    refuse_masked(what, values)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "US":  # numbers beside text became text, too
            array = np.asarray(values, dtype=object)
    except ValueError:  # lists of different lengths
        raise RequestError(f"{what} = {shown(values)} must be numbers") from None
    if array.dtype.kind in "iuf" and np.isfinite(array).all():
        return array.astype(np.float64)
    return np.array([number(what, value) for value in array.ravel().tolist()]).reshape(array.shape)


def _is_sequence(values: Any) -> bool:
    if hasattr(values, "__array__"):
        return bool(np.ndim(values) == 1)
    return isinstance(values, Sequence) and not isinstance(values, str | bytes)


@dataclass(frozen=True)
class Interval:
    """A parameter and its interval [SI]; raises `RequestError` unless low < high."""

    name: str
    low: float
    high: float
    stated: Interval | None = None  # that of a ratio from which this one follows, as f for omega
    falls: bool = False  # whether the request states it from `high` to `low`

    def __post_init__(self) -> None:
        if self.name not in DESCRIBED or self.name in INITIAL:
            choice("parameter", self.name, (*PARAMETERS, *RATIOS))
        for end in ("low", "high"):
            value = number(f"{end} of {self.name}", getattr(self, end))
            DESCRIBED[self.name].check(np.asarray(value))
            object.__setattr__(self, end, value)
        if not self.low < self.high:
            raise RequestError(
                f"{self.name} from {self.low!r} to {self.high!r}: the first must be the lesser"
            )

    def heading(self) -> str:
        one = self.stated or self
        return f"{one.name} from {ends_in_words(one.name, *one._ends)}"

    def entry(self) -> dict[str, dict[str, float]]:
        one = self.stated or self
        start, stop = one._ends
        return {one.name: {"start": start, "stop": stop}}

    @property
    def _ends(self) -> tuple[float, float]:
        """The ends in the order of the request."""
        return (self.high, self.low) if self.falls else (self.low, self.high)

    def nearest(self, value: float) -> float:
        return min(max(value, self.low), self.high)

    def as_stated(self, value: float) -> float:
        """Return a value as the request states it: f in Hz, to which omega is proportional."""
        return value if self.stated is None else value * self.stated.high / self.high

    def value_in_words(self, value: float, digits: int) -> str:
        """Return `f = 1.1717 Hz`, as the request states the parameter, with so many digits."""
        name = (self.stated or self).name
        return f"{name} = {with_unit(name, f'{self.as_stated(value):.{digits}g}')}"

    def range_in_words(self, low: float, high: float) -> str:
        """Return `f 0.8 to 1.4 Hz`, as the request states the parameter."""
        name = (self.stated or self).name
        numbers = f"{self.as_stated(low):.6g} to {self.as_stated(high):.6g}"
        return f"{name} {with_unit(name, numbers)}"


# ---- tables of samples --------------------------------------------------------------------------

SAMPLE = "sample"  # the dimension of results of samples
FILE = "file"  # the key of a table `[samples]` that names a CSV file in place of columns


@dataclass(frozen=True, eq=False)
class Samples:
    """A table of samples; `columns` are read-only arrays (n,) of finite numbers by name."""

    columns: Mapping[str, np.ndarray]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.columns)

    @property
    def count(self) -> int:
        return next(iter(self.columns.values())).size

    def document(self) -> dict[str, list[float]]:
        return {name: values.tolist() for name, values in self.columns.items()}

    def ranges(self) -> list[str]:
        return [
            f"{name} = {ends_in_words(name, float(values.min()), float(values.max()))}"
            for name, values in self.columns.items()
        ]

    def contents(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        for name, values in self.columns.items():
            yield DESCRIBED[name].dataset((SAMPLE,)), values

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Samples) and list(self.document().items()) == list(
            other.document().items()
        )

    def __hash__(self) -> int:
        return hash(tuple((name, values.tobytes()) for name, values in self.columns.items()))


def sample_scale(count: int) -> Scale:
    return Scale.counted(SAMPLE, count, "row of the table of samples, from 1", 1)


def samples_of(source: Any) -> Samples:
    """Return the table in a table, in arrays by name, in a DataFrame, or in a CSV file.

    The cells of a file, given as a path or `{"file": path}`, are separated by commas, tabs or
    semicolons (which permit decimal commas); # begins a comment.
    """
    if isinstance(source, Samples):
        return source
    if isinstance(source, Mapping) and source.keys() == {FILE}:
        source = source[FILE]
    place = "samples"
    if isinstance(source, str | os.PathLike):
        refuse_bytes("samples", str(source))
        place = f"samples {str(source)!r}"
        with at(place):
            source = _read_csv(Path(source))
    if hasattr(source, "columns") and not isinstance(source, Mapping):
        source = {name: np.asarray(source[name]) for name in source.columns}
    if not isinstance(source, Mapping):
        text = "must be arrays by name, a DataFrame or the path of a CSV file"
        raise RequestError(f"samples = {shown(source)} {text}")
    with at(place):
        return Samples(_checked(source))


def _checked(table: Mapping[Any, Any]) -> dict[str, np.ndarray]:
    if not table:
        raise RequestError("the table has no column")
    columns: dict[str, np.ndarray] = {}
    for name, values in table.items():
        if not isinstance(name, str):
            raise RequestError(f"column {shown(name)} must be named by a string")
        refuse_masked(name, values)
        try:
            array = np.asarray(values)
            if array.dtype.kind in "US":  # numbers beside text became text, too
                array = np.asarray(values, dtype=object)
        except ValueError:  # lists of different lengths
            array = np.zeros((0, 0))
        if array.ndim != 1:
            raise RequestError(f"column {name} must be a list of numbers")
        if array.dtype.kind not in "iuf" or not np.isfinite(array).all():
            for row, value in enumerate(array.tolist(), start=1):
                with at(f"row {row}"):
                    number(name, value)
        columns[name] = array.astype(np.float64) + 0.0  # -0.0 becomes 0.0; a copy
        columns[name].setflags(write=False)
    counts = {name: column.size for name, column in columns.items()}
    if len({*counts.values()}) > 1:
        words = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise RequestError(f"columns of different lengths: {words}; all must have as many values")
    if not 1 <= (count := min(counts.values())) <= MOST_VALUES:
        raise RequestError(f"the table has {count} rows; allowed: 1 to {MOST_VALUES}")
    return columns


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    lines = enumerate(decoded(read_bytes(path, MOST_BYTES)).split("\n"), start=1)
    numbered = {i: line for i, line in lines if line.strip() and not line.startswith("#")}
    if not numbered:
        raise RequestError("the file is empty; its first line must name the columns")
    separator = max(",;\t", key=next(iter(numbered.values())).count)
    try:
        heading, *rows = csv.reader(numbered.values(), delimiter=separator)
    except csv.Error as error:
        raise RequestError(f"is no table of comma-separated values: {error}") from None
    names = [name.strip() for name in heading]
    if "" in names:
        raise RequestError(
            f"column {names.index('') + 1} has no name; pandas writes its index so: "
            "to_csv(..., index=False)"
        )
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise RequestError(f"column {shown(twice)} occurs twice")
    places = [*numbered][1:]
    for line, row in zip(places, rows, strict=False):
        if len(row) != len(names):
            raise RequestError(f"line {line} has {len(row)} cells, the heading {len(names)}")
    values = np.empty((len(rows), len(names)))
    for i, (line, row) in enumerate(zip(places, rows, strict=False)):
        for j, cell in enumerate(row):
            text = cell.replace(",", ".") if separator == ";" else cell
            with at(f"line {line}"):
                values[i, j] = from_text(float, names[j], text)
    return dict(zip(names, values.T, strict=True))
