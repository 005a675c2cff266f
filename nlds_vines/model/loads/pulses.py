"""Pulses: half-sine, triangular, rectangular, of a blast (Friedlander); any of them repeated."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from typing import ClassVar

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.model.loads.load import LENGTH, TIME, Course, Size
from nlds_vines.model.loads.series import TERMS, cosine, growth, polynomial, times_line
from nlds_vines.model.setting import Real, Truth, Whole, setting


@dataclass(frozen=True, kw_only=True)
class Pulse(Course):
    """One or several pulses of a shape, one after the other."""

    peak: float = setting(MISSING, Size(), "", "largest value, in `unit`; either sign")
    length: float = setting(MISSING, LENGTH, "", "how long it lasts [s]")
    at: float = setting(0.0, TIME, "", "when it begins [s]")
    repeat: int = setting(1, Whole(1, 10**5), "", "how many there are")
    every: float = setting(0.0, TIME, "", "time from one to the next [s]; at least `length`")

    tail: ClassVar[bool] = False
    """Whether a pulse goes on after its length."""

    def check(self) -> None:
        """Refuse pulses that would overlap."""
        if self.repeat > 1 and self.every < self.length:
            raise RequestError(
                f"every = {self.every:g} s between {self.repeat} pulses of {self.length:g} s: "
                "allowed: at least their length"
            )

    @property
    def begins(self) -> np.ndarray:
        """When each of them begins (repeat,) [s]."""
        return self.at + self.every * np.arange(self.repeat)

    def corners(self) -> np.ndarray:
        """Return the times after its beginning at which a pulse is not smooth [s]."""
        return np.array([0.0, self.length])

    def kinks(self, end: float) -> np.ndarray:
        """Return where pulses begin and end, and their corners."""
        found = np.unique(self.begins[:, None] + self.corners())
        return found[(found > 0.0) & (found < end)]

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return those of the pulse that acts; 0 between pulses."""
        return np.where(self._at(times) >= 0, self.rate, 0.0)

    @property
    def rate(self) -> float:
        """Of one pulse [1/s]; 0 for polynomials, which a row holds whole."""
        return 0.0

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the coefficients of the pulse that acts in each cell."""
        which = self._at(begins + 0.5 * lengths)
        rows, acting = np.zeros((len(begins), TERMS)), which >= 0
        since = begins[acting] - self.begins[which[acting]]
        rows[acting] = self.peak * self.shape(since, lengths[acting])
        return rows

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the rows of a pulse of size 1, over cells that begin so long after it."""
        raise NotImplementedError

    def _at(self, times: np.ndarray) -> np.ndarray:
        """Return which pulse acts at times without a kink; -1 for none."""
        which = np.searchsorted(self.begins, times, side="right") - 1
        over = times >= self.begins[which] + self.length
        return np.where((which >= 0) & (self.tail | ~over), which, -1)


@dataclass(frozen=True, kw_only=True)
class HalfSine(Pulse):
    """F sin(pi t / length)."""

    kind: ClassVar[str] = "half_sine"

    @property
    def rate(self) -> float:
        """Of the sine."""
        return np.pi / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return those of the sine, a cosine a quarter of a turn later."""
        return cosine(0.5 * since / self.length - 0.25, np.pi * lengths / self.length)


@dataclass(frozen=True, kw_only=True)
class Rectangular(Pulse):
    """F."""

    kind: ClassVar[str] = "rectangular"

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return ones."""
        return polynomial(np.ones((len(since), 1)), since, lengths)


@dataclass(frozen=True, kw_only=True)
class Triangular(Pulse):
    """Up to F in a share of the length, and down to 0; a share of 0 is a jump."""

    rise: float = setting(0.5, Real(0.0, 1.0), "", "share of its length up to the peak")

    kind: ClassVar[str] = "triangular"

    def corners(self) -> np.ndarray:
        """Return its ends and the peak."""
        return np.array([0.0, self.rise * self.length, self.length])

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the line that a cell has."""
        up, down = self.rise * self.length, (1.0 - self.rise) * self.length
        lines = np.empty((len(since), 2))
        rising = since + 0.5 * lengths < up
        lines[rising] = (0.0, 1.0 / up) if up else 0.0
        lines[~rising] = (self.length / down, -1.0 / down) if down else 0.0
        return polynomial(lines, since, lengths)


@dataclass(frozen=True, kw_only=True)
class Friedlander(Pulse):
    """That of a blast: F (1 - t / length) exp(-decay t / length).

    Source: the modified Friedlander equation of explosions in air.
    """

    decay: float = setting(1.0, Real(0.0, 100.0), "", "exponent of the decay over its length")
    suction: bool = setting(
        False, Truth(), "", "whether the negative phase after its length acts as well"
    )

    kind: ClassVar[str] = "friedlander"

    def check(self) -> None:
        """Refuse several with a negative phase, which would overlap, and one that never ends."""
        super().check()
        if self.suction and self.repeat > 1:
            raise RequestError("suction = true: the negative phase has no end; allowed: repeat = 1")
        if self.suction and self.decay == 0.0:
            raise RequestError("suction = true: with decay = 0 the negative phase grows for ever")

    @property
    def tail(self) -> bool:  # type: ignore[override]
        """Whether it goes on after its length."""
        return self.suction

    def corners(self) -> np.ndarray:
        """Return its ends; the negative phase has none."""
        return np.array([0.0]) if self.suction else np.array([0.0, self.length])

    @property
    def rate(self) -> float:
        """Of line and exponential: derivatives of their product grow by at most 1 + decay."""
        return (1.0 + self.decay) / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the product of line and exponential."""
        x, dx = since / self.length, lengths / self.length
        return times_line(growth(-self.decay * x, -self.decay * dx), 1.0 - x, -dx)
