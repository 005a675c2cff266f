"""A record: samples of a force or of the ground's acceleration, and what is between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.errors import RequestError, at, number, shown, string
from nlds_vines.model.loads.load import TIME, Course
from nlds_vines.model.loads.samples import MOST_SAMPLES, samples_in
from nlds_vines.model.loads.series import TERMS, polynomial
from nlds_vines.model.setting import OneOf, Text, Truth, setting

LINEAR, CUBIC = "linear", "cubic"

GAP = 1.5
"""A step this many times the median one is a gap."""


@dataclass(frozen=True)
class Numbers:
    """Two or more finite numbers, kept as a tuple."""

    def __call__(self, name: str, value: Any, /) -> tuple[float, ...]:
        """Return them."""
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
        """Refuse times that do not ascend, and gaps."""
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

    def kinks(self, end: float) -> np.ndarray:
        """Return the times of the samples."""
        found = self.at + self._times
        return found[(found > 0.0) & (found < end)]

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return zeros: a row holds a polynomial whole."""
        return np.zeros(len(times))

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return those of the polynomial between two samples."""
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
