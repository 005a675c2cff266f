"""Waves: a harmonic, a sine sweep, band-limited noise."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.model.loads.load import LENGTH, TIME, Course, Size
from nlds_vines.model.loads.series import (
    TERMS,
    cosine,
    cosine_of,
    exponential,
    growth,
    logarithm,
    polynomial,
    relative_growth,
    tones,
    turns_at,
)
from nlds_vines.model.setting import OneOf, Real, Whole, setting

TURN = 2.0 * np.pi
RATE = Real(1e-9, 1e9)

LINEAR, LOGARITHMIC = "linear", "logarithmic"


@dataclass(frozen=True, kw_only=True)
class Tone(Course):
    """A cos(omega t + phase), from t = 0 on."""

    amplitude: float = setting(MISSING, Size(), "", "A, in `unit`")
    omega: float = setting(MISSING, RATE, "", "frequency [rad/s]")
    phase: float = setting(0.0, Real(-1e6, 1e6), "", "at t = 0 [rad]")

    kind: ClassVar[str] = "tone"

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return its frequency."""
        return np.full(len(times), self.omega)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return those of the cosine."""
        turns = turns_at(self.omega / TURN, begins) + self.phase / TURN
        return self.amplitude * cosine(turns, self.omega * lengths)


@dataclass(frozen=True, kw_only=True)
class Sweep(Course):
    """A sine whose frequency changes: A sin(phase(t)), d(phase)/dt = omega(t).

    With tau = t - at: linear, omega = first + (last - first) tau / length; logarithmic,
    omega = first (last / first)^(tau / length).  Zero before and after.
    """

    amplitude: float = setting(MISSING, Size(), "", "A, in `unit`")
    first: float = setting(MISSING, RATE, "", "frequency where it begins [rad/s]")
    last: float = setting(MISSING, RATE, "", "where it ends [rad/s]: below `first`, it goes down")
    length: float = setting(MISSING, LENGTH, "", "how long it lasts [s]")
    at: float = setting(0.0, TIME, "", "when it begins [s]")
    spacing: str = setting(
        LINEAR, OneOf((LINEAR, LOGARITHMIC), "spacing"), "",
        "how the frequency goes with time: `linear`, or `logarithmic`, at a constant ratio",
    )  # fmt: skip

    kind: ClassVar[str] = "sweep"

    @cached_property
    def _log_ratio(self) -> float:
        """Return ln(last / first), 0 for a linear sweep and for one frequency."""
        if self.spacing == LINEAR or self.first == self.last:
            return 0.0
        return logarithm(self.last / self.first)

    def kinks(self, end: float) -> np.ndarray:
        """Return its beginning and its end."""
        found = np.array([self.at, self.at + self.length])
        return found[(found > 0.0) & (found < end)]

    def _acts(self, times: np.ndarray) -> np.ndarray:
        return (times >= self.at) & (times < self.at + self.length)

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return its largest frequency, and what its change adds."""
        most = max(self.first, self.last) + 1.0 / self.length + abs(self._log_ratio) / self.length
        most += np.sqrt(abs(self.last - self.first) / self.length)
        return np.where(self._acts(times), most, 0.0)

    def omegas(self, times: np.ndarray) -> np.ndarray:
        """Return its frequency (n,) [rad/s] at times (n,) [s]; NaN before and after."""
        share = (times - self.at) / self.length
        within = np.clip(share, 0.0, 1.0)
        found = self.first + (self.last - self.first) * within
        if self._log_ratio:
            found = self.first * exponential(self._log_ratio * within)
        return np.where(share == within, found, np.nan)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return those of the sine of its phase, whose own rows are a polynomial or exponential."""
        rows = np.zeros((len(begins), TERMS))
        acts = self._acts(begins + 0.5 * lengths)
        since, lengths = begins[acts] - self.at, lengths[acts]
        if self._log_ratio:
            # d(phase)/dt = first e^y, y = tau ln(ratio) / length: phase = first tau (e^y - 1) / y
            rate, frequency = self._log_ratio / self.length, self.first / TURN
            omega = growth(rate * since, rate * lengths) * frequency
            phase = np.empty_like(omega)
            phase[:, 0] = frequency * since * relative_growth(rate * since)
            phase[:, 1:] = omega[:, :-1] * lengths[:, np.newaxis] / np.arange(1, TERMS)
        else:
            rise = 0.5 * (self.last - self.first) / self.length
            line = np.array([[0.0, self.first / TURN, rise / TURN]])
            phase = polynomial(np.repeat(line, len(since), axis=0), since, lengths)
        phase[:, 0] -= 0.25  # sin = cos a quarter of a turn before
        rows[acts] = self.amplitude * cosine_of(phase)
        return rows


@dataclass(frozen=True, kw_only=True)
class Noise(Course):
    """Noise whose power is spread evenly over a band: a sum of tones with random phases.

        f(t) = rms sqrt(2 / N) sum of cos(omega_i t + phase_i), i = 1 ... N

    omega_i = low + (i - 1/2) (high - low) / N.  The two-sided density is
    S0 = rms^2 / (2 (high - low)).  Its values are near to normally distributed, by the central
    limit theorem; it repeats itself after 2 pi N / (high - low).

    Source: M. Shinozuka and G. Deodatis, Simulation of stochastic processes by spectral
    representation, Applied Mechanics Reviews 44 (1991).
    """

    rms: float = setting(MISSING, Real(0.0, 1e15, inside=True), "", "root mean square, in `unit`")
    low: float = setting(0.0, Real(0.0, 1e9), "", "where its band begins [rad/s]")
    high: float = setting(MISSING, RATE, "", "where its band ends [rad/s]")
    seed: int = setting(0, Whole(0, 2**31), "", "of its phases: the same seed, the same bits")
    tones: int = setting(1000, Whole(2, 10**5), "", "N: how many tones it is the sum of")

    kind: ClassVar[str] = "noise"

    def check(self) -> None:
        """Refuse an empty band."""
        if self.high <= self.low:
            raise RequestError(f"high = {self.high:g} rad/s must be above low = {self.low:g}")

    @property
    def lasts(self) -> float:
        """After what time it repeats itself [s]."""
        return TURN * self.tones / (self.high - self.low)

    @property
    def density(self) -> float:
        """Its two-sided spectral density S0 over the band, in `unit`^2 s / rad."""
        return self.rms * self.rms / (2.0 * (self.high - self.low))

    @cached_property
    def phases(self) -> np.ndarray:
        """The phases (N,) in turns: the upper 53 bits of the generator's numbers, which stay."""
        drawn = np.random.PCG64(self.seed).random_raw(self.tones)
        return (drawn >> np.uint64(11)).astype(np.float64) * 2.0**-53

    @cached_property
    def omegas(self) -> np.ndarray:
        """The frequencies (N,) [rad/s]."""
        return self.low + (np.arange(self.tones) + 0.5) * (self.high - self.low) / self.tones

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return the end of the band."""
        return np.full(len(times), self.high)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the sum over the tones, from the first on.

        Cost: 3 ns a cell and tone.
        """
        return tones(self.omegas / TURN, self.phases, begins, lengths) * (
            self.rms * np.sqrt(2.0 / self.tones)
        )
