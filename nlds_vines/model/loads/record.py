"""Records: samples of a force or of the ground's acceleration, joined by lines or a spline.

Their files are read in `record_files`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, at, number, shown, table
from nlds_vines.model.loads.courses import TIME, Course, polynomial, unit_in
from nlds_vines.model.loads.record_files import MOST_SAMPLES, RecordFile
from nlds_vines.model.setting import OneOf, Text, Truth, setting, settings_of

LINEAR, CUBIC = "linear", "cubic"

GAP = 1.5
"""A step this many times the median one is a gap."""


def _samples(name: str, value: Any, /) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not 2 <= len(value) <= MOST_SAMPLES:
        raise RequestError(f"{name} = {shown(value)} must be a list of 2 to {MOST_SAMPLES} numbers")
    if set(map(type, value)) == {float} and np.isfinite(samples := np.array(value)).all():
        return tuple((samples + 0.0).tolist())  # -0.0 becomes 0.0, as in `number`
    return tuple(number(f"{name}, sample {i},", one) for i, one in enumerate(value, 1))


@dataclass(frozen=True, kw_only=True, repr=False)
class Record(Outlined, Course):
    """Samples joined by straight lines or a natural cubic spline; 0 before and after.

    A table with a `file` in place of times and values has also the keys of `RecordFile`.  The
    samples become part of the request; `source` and `reading` say where they come from.
    """

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

    kind: ClassVar[str] = "record"

    def heading(self) -> str:
        return self.source

    def outline(self) -> Rows:
        yield "samples", f"{len(self.times)} from {self.times[0]:g} to {self.times[-1]:g} s"

    @classmethod
    def of(cls, entry: object) -> Record:
        """Return the record in a table, or in the file that the table or a path names."""
        if isinstance(entry, str):
            entry = {"file": entry}
        if not isinstance(entry, Mapping) or "file" not in entry:
            return super().of(entry)
        of_file = settings_of(RecordFile)
        with at(f"[{cls.table}]"):
            if twice := next((key for key in ("times", "values") if key in entry), None):
                raise RequestError(f"{twice} stands beside file = {shown(entry['file'])}")
            keys = [one.key for one in settings_of(cls).values()]
            entry = table(cls.kind, entry, [*of_file, *keys])
            unit = unit_in("unit", entry["unit"]) if "unit" in entry else ""
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
        """The largest step [s]."""
        return float(np.diff(self._times).max())

    def words(self) -> str:
        return f"record {self.source or len(self.values)}"

    def summary(self, duration: float) -> str:
        """Return the line that says what was read, and how much of it is within a duration [s]."""
        steps, length = np.diff(self._times), float(self._times[-1])
        low, high = f"{steps.min():g}", f"{steps.max():g}"
        within, values = min(max(duration - self.at, 0.0), length), np.array(self.values)
        peak = int(np.argmax(np.abs(values)))
        words = [
            f"record {self.source}".rstrip(),
            f"{len(values)} samples",
            f"step {low} s" if low == high else f"steps {low} to {high} s",
            f"{length:g} s" + ("" if within == length else f", of which {within:g} s are computed"),
            f"peak {abs(values[peak]):g} {self.unit} at {self._times[peak]:g} s",
        ]
        if self.times[0] != self.at:
            words.append(f"moved from {self.times[0]:g} s to {self.at:g} s")
        return ", ".join(words) + (f" ({self.reading})" if self.reading else "")

    @cached_property
    def _times(self) -> np.ndarray:
        """The times (n,) [s] from the first sample on."""
        return np.array(self.times) - self.times[0]

    @cached_property
    def _pieces(self) -> np.ndarray:
        """The coefficients (n + 1, 2 or 4) of the powers of the time from each sample on.

        The first row, before the first sample, and the last one are 0.
        """
        y, h = np.array(self.values), np.diff(self._times)
        is_cubic, slopes = self.interpolation == CUBIC, np.diff(y) / h
        pieces = np.zeros((len(y) + 1, 4 if is_cubic else 2))
        pieces[1:-1, 0], pieces[1:-1, 1] = y[:-1], slopes
        if is_cubic:
            m = _curvatures(h, slopes)
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


def _curvatures(h: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the second derivatives (n,) of a natural spline at its samples.

    h_i m_i + 2 (h_i + h_(i+1)) m_(i+1) + h_(i+1) m_(i+2) = 6 (slope_(i+1) - slope_i), m = 0 at both
    ends, is eliminated from the first sample on (Thomas), number by number.
    """
    steps, right = h.tolist(), (6.0 * np.diff(slopes)).tolist()
    above: list[float] = []
    beside: list[float] = []
    upper = value = 0.0
    for i, side in enumerate(right):
        pivot = 2.0 * (steps[i] + steps[i + 1]) - steps[i] * upper
        upper, value = steps[i + 1] / pivot, (side - steps[i] * value) / pivot
        above.append(upper)
        beside.append(value)
    curvatures = [0.0]
    for upper, value in zip(reversed(above), reversed(beside), strict=True):
        curvatures.append(value - upper * curvatures[-1])
    return np.array([*curvatures, 0.0][::-1])
