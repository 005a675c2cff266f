"""Loads as functions of time: pulses, tones, sweeps and noise; `record` has samples.

A load lists its kinks and bounds its rate of change.  Over a cell without a kink it returns the
coefficients of the powers of x = (t - begin) / length, 0 <= x <= 1: a row of `TERMS` numbers.  The
arithmetic is strict, so that rows have the same bits on every processor.
"""

from __future__ import annotations

import re
from dataclasses import MISSING, dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from nlds_vines.errors import RequestError, at, number, table, unknown
from nlds_vines.model.setting import (
    Checked,
    OneOf,
    Real,
    Truth,
    Whole,
    check_settings,
    entries,
    setting,
    settings_of,
)

ORDER = 14  # the order of the polynomials, which is that of a flight
TERMS = ORDER + 1
REACH = 0.5  # longest cell, in units of 1/rate of a load: truncated by less than 0.5^15 / 15!
SPLITTER = 134217729.0  # 2^27 + 1: splits a float64 into two halves of 26 bits each (Veltkamp)


def cos_sin(turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosine and the sine of 2 pi `turns` (n,)."""
    from nlds_vines.kernels.numerics.elementary import fill_cos_sin

    fractions = np.ascontiguousarray(turns - np.floor(turns))  # exact, by Sterbenz's lemma
    cos, sin = np.empty_like(fractions), np.empty_like(fractions)
    fill_cos_sin(fractions, cos, sin)
    return cos, sin


def exponential(x: np.ndarray) -> np.ndarray:
    from nlds_vines.kernels.numerics.elementary import fill_exp

    values = np.empty(len(x))
    fill_exp(np.ascontiguousarray(x), values)
    return values


def relative_growth(y: np.ndarray) -> np.ndarray:
    """Return (e^y - 1) / y of `y` (n,), 1 at y = 0.

    For |y| < 1/2 the series of y^k / (k + 1)!, k < 16, avoids the cancellation in e^y - 1.
    """
    is_small, series = np.abs(y) < 0.5, np.ones_like(y)
    for k in range(16, 1, -1):
        series = 1.0 + series * np.where(is_small, y, 0.0) / k
    large = np.where(is_small, 1.0, y)
    return np.where(is_small, series, (exponential(large) - 1.0) / large)


def turns_at(frequency: float, times: np.ndarray) -> np.ndarray:
    """Return the fractional part of `frequency` [1/s] times `times` (n,) [s], in turns.

    A large product keeps few digits of its fraction.  Its rounding error, from the products of the
    halves of both factors (Dekker), is therefore added.
    """
    product = frequency * times
    f = SPLITTER * frequency - (SPLITTER * frequency - frequency)
    t = SPLITTER * times - (SPLITTER * times - times)
    g, u = frequency - f, times - t
    rounding = ((f * t - product) + f * u + g * t) + g * u
    return np.asarray((product - np.floor(product)) + rounding)


def cosine(turns: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of cos(2 pi turns + angle x); both arguments (n,)."""
    c, s = cos_sin(turns)
    rows = np.empty((len(c), TERMS))
    rows[:, 0] = c
    for k in range(1, TERMS):
        c, s = -angle / k * s, angle / k * c
        rows[:, k] = c
    return rows


def cosine_of(phase: np.ndarray) -> np.ndarray:
    """Return the rows of cos(p) for a phase p with the rows `phase` (n, TERMS) [turns].

    They follow from c' = -p' s and s' = p' c, power by power.
    """
    rates = 2 * np.pi * phase * np.arange(TERMS)
    c, s = np.zeros_like(phase), np.zeros_like(phase)
    c[:, 0], s[:, 0] = cos_sin(phase[:, 0])
    for k in range(1, TERMS):
        for j in range(1, k + 1):
            c[:, k] -= rates[:, j] * s[:, k - j]
            s[:, k] += rates[:, j] * c[:, k - j]
        c[:, k] /= k
        s[:, k] /= k
    return c


def growth(exponents: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of exp(exponents + rises x); both arguments (n,)."""
    rows = np.empty((len(exponents), TERMS))
    rows[:, 0] = exponential(exponents)
    for k in range(1, TERMS):
        rows[:, k] = rows[:, k - 1] * rises / k
    return rows


def polynomial(coefficients: np.ndarray, at: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the rows (n, m) of polynomials with `coefficients` (n, m) of the powers of a time [s].

    The cells begin `at` that time (n,); repeated synthetic division (Horner) shifts polynomials.
    """
    shifted = coefficients.astype(np.float64)
    terms = shifted.shape[1]
    for first in range(terms - 1):
        for k in range(terms - 2, first - 1, -1):
            shifted[:, k] += at * shifted[:, k + 1]
    scale = np.ones(len(at))
    for k in range(1, terms):
        scale = scale * lengths
        shifted[:, k] *= scale
    return shifted


# ---- every load ----------------------------------------------------------------------------------

G = 9.80665  # standard gravity [m/s^2]
FORCES = {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605}  # units of a force on m1, in N

ACCELERATIONS = {  # units of an acceleration of the ground, in m/s^2
    "m/s^2": 1.0,
    "cm/s^2": 0.01,
    "gal": 0.01,
    "mm/s^2": 0.001,
    "in/s^2": 0.0254,
    "ft/s^2": 0.3048,
    "g": G,
    "%g": 0.01 * G,
    "mg": 0.001 * G,
}
UNITS = (*FORCES, *ACCELERATIONS)

_SPELLINGS = {**{unit.lower(): unit for unit in UNITS}, **{"gals": "gal", "gs": "g", "lbs": "lbf"}}


def canonical(text: str) -> str | None:
    """Return the unit that a text means, one of `UNITS`; None for other texts.

    Accelerations have many spellings: m/s2, m/s², m/s/s, m/s**2, cm/sec^2, Gal, G.
    """
    word = re.sub(r"\*\*|[\s^(){}]", "", text.lower().replace("²", "2")).replace("sec", "s")
    if match := re.fullmatch(r"(m|cm|mm|in|ft)\.?(?:/s2|/s/s|[.*·]?s-2|[.*·]?s⁻2)", word):
        return f"{match[1]}/s^2"
    return _SPELLINGS.get(word)


def unit_in(name: str, value: Any, /) -> str:
    unit = canonical(value) if isinstance(value, str) else None
    if unit is None:
        raise unknown(name, value, UNITS)
    return unit


TURN = 2.0 * np.pi
TIME = Real(0.0, 1e9)
LENGTH = Real(0.0, 1e9, inside=True)
RATE = Real(1e-9, 1e9)
LINEAR, LOGARITHMIC = "linear", "logarithmic"


def nonzero(name: str, value: Any, /) -> float:
    size = number(name, value)
    if not 0.0 < abs(size) <= 1e15:
        raise RequestError(f"{name} = {size!r}; allowed: up to 1e15 to either side, and not 0")
    return size


@dataclass(frozen=True, kw_only=True)
class Load:
    kind: ClassVar[str]  # its key in `[load]`: `half_sine` of the class HalfSine
    table: ClassVar[str]  # the name of its table, `load.KIND`

    def __init_subclass__(cls) -> None:
        cls.kind = re.sub("(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower()
        cls.table = f"load.{cls.kind}"

    def __post_init__(self) -> None:
        check_settings(self)
        self.check()

    def check(self) -> None:
        """Raise `RequestError` if fields contradict each other."""

    @property
    def kinks(self) -> np.ndarray:
        """The times (n,) [s] at which the load is not smooth."""
        return np.zeros(0)

    def words(self) -> str:
        numbers = [f"{k} {v:g}" for k, v in self.entry().items() if isinstance(v, float) and v]
        return f"{self.kind.replace('_', ' ')} ({', '.join(numbers)})"

    def entry(self) -> dict[str, Any]:
        return entries(self, self.table)

    @classmethod
    def of(cls, entry: object) -> Self:
        settings = {setting.key: setting for setting in settings_of(cls).values()}
        with at(f"[{cls.table}]"):
            entries = table(cls.kind, entry, settings)
            for key, setting in settings.items():
                if setting.default is MISSING and key not in entries:
                    raise RequestError(f"{key} is missing: {setting.words}")
            return cls(**entries)


@dataclass(frozen=True, kw_only=True)
class Course(Load):
    """A load over time: a force on m1 or an acceleration of the ground."""

    unit: str = setting(
        "N",
        Checked(lambda value: unit_in("unit", value)),
        "",
        "`N`, `kN` or `lbf`: a force on m1; `m/s^2`, `cm/s^2`, `gal`, `mm/s^2`, `in/s^2`, "
        "`ft/s^2`, `g`, `%g` or `mg`: the ground's acceleration",
    )

    @property
    def is_acceleration(self) -> bool:
        return self.unit in ACCELERATIONS

    @property
    def factor(self) -> float:
        """Its unit in N or m/s^2."""
        return (FORCES | ACCELERATIONS)[self.unit]

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return its rates [1/s] at `times` (n,), none of which is a kink.

        Up to the next kink, its n-th derivative is bounded by its size times rate^n.  The rate of
        polynomials of degree `ORDER` is 0: one row holds them exactly.
        """
        raise NotImplementedError

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return Taylor coefficients (n, m), m <= TERMS, in its unit, over cells without a kink."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class Pulse(Course):
    """One or several equal pulses, one after the other."""

    peak: float = setting(MISSING, nonzero, "", "largest value, in `unit`; either sign")
    length: float = setting(MISSING, LENGTH, "", "how long it lasts [s]")
    at: float = setting(0.0, TIME, "", "when it begins [s]")
    repeat: int = setting(1, Whole(1, 10**5), "", "how many there are")
    every: float = setting(0.0, TIME, "", "time from one to the next [s]; at least `length`")

    def check(self) -> None:
        if self.repeat > 1 and self.every < self.length:
            raise RequestError(
                f"every = {self.every:g} s between {self.repeat} pulses of {self.length:g} s: "
                "allowed: at least their length"
            )

    @property
    def begins(self) -> np.ndarray:
        return self.at + self.every * np.arange(self.repeat)

    @property
    def end(self) -> float:  # of a pulse, after its beginning
        return self.length

    @property
    def corners(self) -> tuple[float, ...]:
        return 0.0, self.end

    @property
    def kinks(self) -> np.ndarray:
        return (self.begins[:, None] + self.corners).ravel()

    @property
    def rate(self) -> float:
        """The rate [1/s] of one pulse; 0 for polynomials."""
        return 0.0

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.where(self._at(times) >= 0, self.rate, 0.0)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        which = self._at(begins + 0.5 * lengths)
        acting = which >= 0
        shapes = self.shape(begins[acting] - self.begins[which[acting]], lengths[acting])
        rows = np.zeros((len(begins), shapes.shape[1]))
        rows[acting] = self.peak * shapes
        return rows

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the rows of a pulse of size 1 over cells that begin `since` (n,) [s] after it."""
        raise NotImplementedError

    def _at(self, times: np.ndarray) -> np.ndarray:
        """Return the number (n,) of the pulse that acts at `times` (n,); -1 for none."""
        which = np.searchsorted(self.begins, times, side="right") - 1
        return np.where((which >= 0) & (times < self.begins[which] + self.end), which, -1)


@dataclass(frozen=True, kw_only=True)
class HalfSine(Pulse):
    """F sin(pi t / length)."""

    @property
    def rate(self) -> float:
        return np.pi / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        return cosine(0.5 * since / self.length - 0.25, np.pi * lengths / self.length)


@dataclass(frozen=True, kw_only=True)
class Rectangular(Pulse):
    """F."""

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        return polynomial(np.ones((len(since), 1)), since, lengths)


@dataclass(frozen=True, kw_only=True)
class Triangular(Pulse):
    """A line up to F within the fraction `rise` of the length, then a line down to 0."""

    rise: float = setting(0.5, Real(0.0, 1.0), "", "share of its length up to the peak")

    @property
    def corners(self) -> tuple[float, ...]:
        return 0.0, self.rise * self.length, self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        up, down = self.rise * self.length, (1.0 - self.rise) * self.length
        lines = np.empty((len(since), 2))
        rising = since + 0.5 * lengths < up
        lines[rising] = (0.0, 1.0 / up) if up else 0.0
        lines[~rising] = (self.length / down, -1.0 / down) if down else 0.0
        return polynomial(lines, since, lengths)


@dataclass(frozen=True, kw_only=True)
class Friedlander(Pulse):
    """The pressure of a blast in air: F (1 - t / length) exp(-decay t / length), Friedlander's."""

    decay: float = setting(1.0, Real(0.0, 100.0), "", "exponent of the decay over its length")
    suction: bool = setting(
        False, Truth(), "", "whether the negative phase after its length acts as well"
    )

    def check(self) -> None:
        super().check()
        if self.suction and self.repeat > 1:
            raise RequestError("suction = true: the negative phase has no end; allowed: repeat = 1")
        if self.suction and self.decay == 0.0:
            raise RequestError("suction = true: with decay = 0 the negative phase grows for ever")

    @property
    def end(self) -> float:
        return np.inf if self.suction else self.length

    @property
    def rate(self) -> float:
        """(1 + decay) / length: the sum of the rates of its two factors."""
        return (1.0 + self.decay) / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        x, dx = since / self.length, lengths / self.length
        decay = growth(-self.decay * x, -self.decay * dx)
        rows = decay * (1.0 - x)[:, None]
        rows[:, 1:] += decay[:, :-1] * -dx[:, None]
        return rows


@dataclass(frozen=True, kw_only=True)
class Tone(Course):
    """A cos(omega t + phase), from t = 0 on."""

    amplitude: float = setting(MISSING, nonzero, "", "A, in `unit`")
    omega: float = setting(MISSING, RATE, "", "frequency [rad/s]")
    phase: float = setting(0.0, Real(-1e6, 1e6), "", "at t = 0 [rad]")

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.full(len(times), self.omega)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        turns = turns_at(self.omega / TURN, begins) + self.phase / TURN
        return self.amplitude * cosine(turns, self.omega * lengths)


@dataclass(frozen=True, kw_only=True)
class Sweep(Course):
    """A sine of varying frequency: A sin(phase), d(phase)/dt = omega(t), from `at` for `length`.

    With tau = t - at, omega = first + (last - first) tau / length if the spacing is linear, and
    omega = first (last / first)^(tau / length) if it is logarithmic.
    """

    amplitude: float = setting(MISSING, nonzero, "", "A, in `unit`")
    first: float = setting(MISSING, RATE, "", "frequency where it begins [rad/s]")
    last: float = setting(MISSING, RATE, "", "where it ends [rad/s]: below `first`, it goes down")
    length: float = setting(MISSING, LENGTH, "", "how long it lasts [s]")
    at: float = setting(0.0, TIME, "", "when it begins [s]")
    spacing: str = setting(
        LINEAR, OneOf((LINEAR, LOGARITHMIC), "spacing"), "",
        "how the frequency goes with time: `linear`, or `logarithmic`, at a constant ratio",
    )  # fmt: skip

    @cached_property
    def _log_ratio(self) -> float:
        """ln(last / first); 0 for a linear sweep."""
        from nlds_vines.kernels.numerics.elementary import log

        if self.spacing == LINEAR or self.first == self.last:
            return 0.0
        return float(log(self.last / self.first))

    def words(self) -> str:
        span = f"{self.first:g} to {self.last:g} rad/s in {self.length:g} s"
        return f"sweep ({span}, amplitude {self.amplitude:g} {self.unit})"

    @property
    def kinks(self) -> np.ndarray:
        return np.array([self.at, self.at + self.length])

    def _acts(self, times: np.ndarray) -> np.ndarray:
        return (times >= self.at) & (times < self.at + self.length)

    def rates(self, times: np.ndarray) -> np.ndarray:
        # the largest frequency, with a margin for its change
        rate = max(self.first, self.last) + 1.0 / self.length + abs(self._log_ratio) / self.length
        rate += np.sqrt(abs(self.last - self.first) / self.length)
        return np.where(self._acts(times), rate, 0.0)

    def omegas(self, times: np.ndarray) -> np.ndarray:
        """Return its frequency (n,) [rad/s] at `times` (n,) [s]; NaN before and after it."""
        share = (times - self.at) / self.length
        within = np.clip(share, 0.0, 1.0)
        if self._log_ratio:
            omegas = self.first * exponential(self._log_ratio * within)
        else:
            omegas = self.first + (self.last - self.first) * within
        return np.where(share == within, omegas, np.nan)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
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
            phase = np.zeros((len(since), TERMS))
            phase[:, :3] = polynomial(np.repeat(line, len(since), axis=0), since, lengths)
        phase[:, 0] -= 0.25  # sin = cos a quarter of a turn before
        rows[acts] = self.amplitude * cosine_of(phase)
        return rows


@dataclass(frozen=True, kw_only=True)
class Noise(Course):
    """Band-limited white noise: a sum of tones with random phases.

        f(t) = rms sqrt(2 / N) sum of cos(omega_i t + phase_i), i = 1 ... N

    omega_i = low + (i - 1/2) (high - low) / N.  The two-sided density is
    S0 = rms^2 / (2 (high - low)).  The values are nearly normally distributed (central limit
    theorem) and repeat after 2 pi N / (high - low).

    Source: M. Shinozuka and G. Deodatis, Simulation of stochastic processes by spectral
    representation, Applied Mechanics Reviews 44 (1991).
    """

    rms: float = setting(MISSING, Real(0.0, 1e15, inside=True), "", "root mean square, in `unit`")
    low: float = setting(0.0, Real(0.0, 1e9), "", "where its band begins [rad/s]")
    high: float = setting(MISSING, RATE, "", "where its band ends [rad/s]")
    seed: int = setting(0, Whole(0, 2**31), "", "of its phases: the same seed, the same bits")
    tones: int = setting(1000, Whole(2, 10**5), "", "N: how many tones it is the sum of")

    def check(self) -> None:
        if self.high <= self.low:
            raise RequestError(f"high = {self.high:g} rad/s must be above low = {self.low:g}")

    @property
    def recurrence(self) -> float:
        return TURN * self.tones / (self.high - self.low)

    @cached_property
    def phases(self) -> np.ndarray:
        """The phases (N,) [turns], from the upper 53 bits of the generator's raw numbers."""
        # NumPy guarantees the raw numbers of PCG64, but not the floats that `Generator` makes
        raw = np.random.PCG64(self.seed).random_raw(self.tones)
        return (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53

    @cached_property
    def omegas(self) -> np.ndarray:
        return self.low + (np.arange(self.tones) + 0.5) * (self.high - self.low) / self.tones

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.full(len(times), self.high)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        from nlds_vines.kernels.numerics.tones import fill_tones  # 3 ns for each cell and tone

        begins, lengths = np.ascontiguousarray(begins), np.ascontiguousarray(lengths)
        rows = np.empty((len(begins), TERMS))
        fill_tones(self.omegas / TURN, self.phases, begins, lengths, rows)
        return rows * (self.rms * np.sqrt(2.0 / self.tones))
