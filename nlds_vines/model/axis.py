"""Axes and intervals: a parameter with its values, or with its bounds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import Reordered, RequestError, choice, number, shown, string, table, whole
from nlds_vines.model.parameters import PARAMETERS, RATIOS, described, ends_in_words

LINEAR, LOG = "linear", "log"
"""Scales of a range: values at equal distances, or at equal ratios."""

MOST_VALUES = 10**7
"""The largest number of values: more than can be computed, fewer than fill the memory."""

_DIGITS = 50  # of a common ratio: its powers are exact to far more digits than a float has


@dataclass(frozen=True, eq=False, repr=False)
class Axis(Outlined):
    """One varied parameter and its values.

    Attributes:
        name: of the parameter, the initial condition or the ratio.
        values: one or more different values (n,) [SI], which are sorted and made read-only.
        stated: the axis of a ratio from which this one follows, as f [Hz] for omega.

    Raises `RequestError` for no values, too many, equal ones, and anything but finite numbers.
    """

    name: str
    values: np.ndarray
    stated: Axis | None = None

    def __post_init__(self) -> None:
        string("name of an axis", self.name)
        unsorted = _numbers(self.name, self.values)
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
        """Return the entry of a request file, along the ratio if one was stated."""
        return {self.as_stated.name: {"values": self.as_stated.values.tolist()}}

    @classmethod
    def spaced(
        cls, name: str, start: object, stop: object, num: object, scale: object = LINEAR
    ) -> Axis:
        """Return an axis of `num` values from `start` to `stop`, both included."""
        first, last = number("start", start), number("stop", stop)
        count = whole("num", num, 1, MOST_VALUES)
        if first > last:
            raise RequestError(f"start = {first!r} must not be greater than stop = {last!r}")
        if choice("scale", scale, (LINEAR, LOG)) == LOG:
            if first <= 0.0:
                raise RequestError(f"start = {first!r} must be > 0 where scale = {LOG!r}")
            return cls(name, _at_equal_ratios(first, last, count))
        with np.errstate(all="ignore"):
            return cls(name, np.linspace(first, last, count))

    @classmethod
    def of(cls, name: str, entry: Any) -> Axis:
        """Return the axis of an `entry` of a request file's table `[vary]`.

        The entry is a table with start, stop, num and perhaps scale, or with values alone; or it
        is a sequence or an array of values.
        """
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


def _is_sequence(values: Any) -> bool:
    """Return True for a list, an array, or another one-dimensional object such as a column."""
    if hasattr(values, "__array__"):
        return bool(np.ndim(values) == 1)
    return isinstance(values, Sequence) and not isinstance(values, str | bytes)


def _at_equal_ratios(first: float, last: float, count: int) -> np.ndarray:
    """Return values (count,) from first to last > 0 with equally spaced logarithms.

    They are powers of the common ratio, rounded from `_DIGITS` digits: the same bits on every
    machine, which no library's exponential guarantees, and exactly 1e6 between 1e5 and 1e7.
    """
    if count == 1:
        return np.array([first])
    with localcontext() as context:
        context.prec = _DIGITS
        value, ratio = Decimal(first), (Decimal(last) / Decimal(first)) ** (1 / Decimal(count - 1))
        spaced = [first]
        for _ in range(count - 2):
            value *= ratio
            spaced.append(float(value))
    return np.array([*spaced, last])


def _numbers(name: str, values: Any) -> np.ndarray:
    """Return `values` as a new one-dimensional array of finite floats."""
    if hasattr(values, "__array__"):
        values = np.asarray(values)
    if not _is_sequence(values):
        raise RequestError(f"values = {shown(values)} must be a list of numbers")
    if not 1 <= len(values) <= MOST_VALUES:
        raise RequestError(f"{name} has {len(values)} values; allowed: from 1 to {MOST_VALUES}")
    if isinstance(values, np.ndarray):
        if values.dtype.kind in "iuf" and np.isfinite(values).all():
            return values.astype(np.float64) + 0.0  # -0.0 becomes 0.0, as `number` has it
        values = values.tolist()
    return np.array([number(name, value) for value in values])


@dataclass(frozen=True)
class Interval:
    """A parameter and its interval; raises `RequestError` unless low < high.

    `stated` is the interval of a ratio from which this one follows, as f [Hz] for omega.
    """

    name: str
    low: float
    high: float
    stated: Interval | None = None

    def __post_init__(self) -> None:
        choice("parameter", self.name, (*PARAMETERS, *RATIOS))
        for end in ("low", "high"):
            value = number(f"{end} of {self.name}", getattr(self, end))
            described(self.name).check(np.asarray(value))
            object.__setattr__(self, end, value)
        if not self.low < self.high:
            raise RequestError(
                f"{self.name} from {self.low!r} to {self.high!r}: the first must be the lesser"
            )

    def heading(self) -> str:
        one = self.stated or self
        return f"{one.name} from {ends_in_words(one.name, one.low, one.high)}"

    def entry(self) -> dict[str, dict[str, float]]:
        one = self.stated or self
        return {one.name: {"start": one.low, "stop": one.high}}

    def nearest(self, value: float) -> float:
        return min(max(value, self.low), self.high)
