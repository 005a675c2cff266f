"""An axis of a scan: one parameter and the values that it takes; or the interval that it is in."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import Reordered, RequestError, choice, number, shown, string, table, whole
from nlds_vines.model.parameters import PARAMETERS, RATIOS, described

LINEAR, LOG = "linear", "log"
"""How the values of a range are spaced: at equal distances, at equal ratios."""

MOST_VALUES = 10**7
"""The most values of one axis: far more than can be computed, far fewer than fill the memory."""

_DIGITS = 50  # of a common ratio: its powers are exact to far more digits than a float has


@dataclass(frozen=True, eq=False, repr=False)
class Axis(Outlined):
    """One varied parameter and its values.

    Arguments:
        name: the parameter, one of `parameters.PARAMETERS`.
        values: its values in SI units, one or more, all different; kept in ascending order, as a
            read-only array of shape (n,).

    Raises `RequestError` for no values, too many, equal ones, and anything but finite numbers.
    """

    name: str
    values: np.ndarray

    def __post_init__(self) -> None:
        """Check, sort and freeze the values."""
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

    def heading(self) -> str:
        """Return the parameter, the ends and the number of its values."""
        values = self.values
        return f"{self.name} = {values[0]:g} to {values[-1]:g} ({values.size} values)"

    def outline(self) -> Rows:
        """Return nothing else."""
        return ()

    @classmethod
    def spaced(
        cls, name: str, start: object, stop: object, num: object, scale: object = LINEAR
    ) -> Axis:
        """Return an axis of `num` values from `start` to `stop`, both included.

        They stand at equal distances, or with the `scale` log at equal ratios.

        Raises `RequestError` for a start beyond the stop, for ends that are not positive where the
        scale is log and, as `Axis`, for faulty numbers.
        """
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
    def of(cls, name: str, entry: object) -> Axis:
        """Return the axis that an `entry` of a request file's table `[vary]` describes.

        The entry holds start, stop, num and perhaps scale, or values alone.

        Raises `RequestError` for other keys and, as `Axis`, for faulty numbers.
        """
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
        """Return whether the other axis has the same name and equal values."""
        if not isinstance(other, Axis):
            return NotImplemented
        return self.name == other.name and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        """Hash by name and values."""
        return hash((self.name, self.values.tobytes()))


def announced(entries: Mapping[str, object]) -> tuple[int, ...]:
    """Return how many values each entry of a table `[vary]` announces, before any is made.

    A faulty entry counts for one value: `Axis.of` tells what is wrong with it.
    """
    return tuple(map(_announced, entries.values()))


def _announced(entry: object) -> int:
    entries = entry if isinstance(entry, Mapping) else {}
    num, values = entries.get("num", 1), entries.get("values")
    if isinstance(values, list | tuple):
        return max(1, len(values))
    return max(1, num) if isinstance(num, int) else 1


def _at_equal_ratios(first: float, last: float, count: int) -> np.ndarray:
    """Return values (count,) from first to last > 0 whose logarithms stand at equal distances.

    They are powers of the common ratio, rounded from `_DIGITS` digits: the same bits on every
    machine, which no library's exponential promises, and 1e6 between 1e5 and 1e7 is 1e6.
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


def _numbers(name: str, values: object) -> np.ndarray:
    """Return `values` as a new one-dimensional array of finite floats."""
    if isinstance(values, np.ndarray) and values.ndim == 1:
        if values.dtype == np.float64 and 1 <= values.size <= MOST_VALUES:
            return _finite(name, values)
        values = values.tolist()
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise RequestError(f"values = {shown(values)} must be a list of numbers")
    if not 1 <= len(values) <= MOST_VALUES:
        raise RequestError(f"{name} has {len(values)} values; allowed: from 1 to {MOST_VALUES}")
    return np.array([number(name, value) for value in values])


def _finite(name: str, values: np.ndarray) -> np.ndarray:
    """Return a copy of floats, of which there may be millions, if all of them are finite."""
    wrong = values[~np.isfinite(values)]
    if wrong.size:
        number(name, float(wrong[0]))
    return values + 0.0  # -0.0 becomes 0.0, as `number` has it


@dataclass(frozen=True)
class Interval:
    """A parameter and the interval in which it is free; `RequestError` unless low < high."""

    name: str
    low: float
    high: float

    def __post_init__(self) -> None:
        """Check everything; integers become floats."""
        choice("parameter", self.name, (*PARAMETERS, *RATIOS))
        for end in ("low", "high"):
            value = number(f"{end} of {self.name}", getattr(self, end))
            described(self.name).check(np.asarray(value))
            object.__setattr__(self, end, value)
        if not self.low < self.high:
            raise RequestError(
                f"{self.name} from {self.low!r} to {self.high!r}: the first must be the lesser"
            )

    def nearest(self, value: float) -> float:
        """Return a value if it lies in the interval, otherwise the nearest end."""
        return min(max(value, self.low), self.high)
