"""Loads as functions of time: Taylor coefficients over cells, pulses and waves.

A load tells its kinks, how fast it changes, and over cells without a kink the coefficients of the
powers of x = (t - begin) / length, 0 <= x <= 1: a row of `TERMS` numbers, by strict arithmetic,
the same bits everywhere.
"""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from nlds_vines.errors import RequestError, at, number, table
from nlds_vines.model.setting import (
    OneOf,
    Real,
    Truth,
    Whole,
    check_settings,
    entries,
    setting,
    settings_of,
)

ORDER = 14
"""Of the polynomials, as of a flight's."""

TERMS = ORDER + 1

REACH = 0.5
"""Longest cell in units of 1/rate of a load: what a series leaves out is below 0.5^15 / 15!."""

SPLITTER = 134217729.0
"""2^27 + 1: cuts a number into two halves of 26 digits each (Veltkamp)."""


def cos_sin(turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cos and sin of 2 pi `turns` (n,)."""
    from nlds_vines.kernels.numerics.elementary import fill_cos_sin

    parts = np.ascontiguousarray(turns - np.floor(turns))  # exact: a difference of near numbers
    cos, sin = np.empty_like(parts), np.empty_like(parts)
    fill_cos_sin(parts, cos, sin)
    return cos, sin


def exponential(x: np.ndarray) -> np.ndarray:
    from nlds_vines.kernels.numerics.elementary import fill_exp

    found = np.empty(len(x))
    fill_exp(np.ascontiguousarray(x), found)
    return found


def relative_growth(y: np.ndarray) -> np.ndarray:
    """Return (e^y - 1) / y of `y` (n,), 1 at y = 0.

    Below |y| = 1/2 it is the sum of y^k / (k + 1)!, k < 16, which no difference spoils.
    """
    small = np.where(np.abs(y) < 0.5, y, 0.0)
    series = np.ones_like(y)
    for k in range(16, 1, -1):
        series = 1.0 + series * small / k
    large = np.where(np.abs(y) < 0.5, 1.0, y)
    return np.where(np.abs(y) < 0.5, series, (exponential(large) - 1.0) / large)


def logarithm(x: float) -> float:
    from nlds_vines.kernels.numerics.elementary import log

    return float(log(x))


def turns_at(frequency: float, times: np.ndarray) -> np.ndarray:
    """Return `frequency` [1/s] `times` (n,) [s] in turns, less whole ones; its rounding is added.

    Of a large product little of its fraction is left; what rounding has taken is the difference of
    the products of halves (Dekker).
    """
    product = frequency * times
    f = SPLITTER * frequency - (SPLITTER * frequency - frequency)
    t = SPLITTER * times - (SPLITTER * times - times)
    g, u = frequency - f, times - t
    lost = ((f * t - product) + f * u + g * t) + g * u
    return np.asarray((product - np.floor(product)) + lost)


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
    """Return the rows of cos(p), p given by its rows (n, TERMS) in turns: c' = -p' s, s' = p' c."""
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


def tones(
    frequencies: np.ndarray, phases: np.ndarray, begins: np.ndarray, lengths: np.ndarray
) -> np.ndarray:
    """Return the rows of the sum of cos(2 pi (f t + p)), frequencies f (N,) [1/s], phases p (N,).

    Arguments: where the cells begin (n,), from 0 on, and how long they are (n,) [s].
    """
    from nlds_vines.kernels.numerics.tones import fill_tones

    rows = np.empty((len(begins), TERMS))
    fill_tones(
        frequencies, phases, np.ascontiguousarray(begins), np.ascontiguousarray(lengths), rows
    )
    return rows


def growth(exponents: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of exp(exponents + rises x); both arguments (n,)."""
    rows = np.empty((len(exponents), TERMS))
    rows[:, 0] = exponential(exponents)
    for k in range(1, TERMS):
        rows[:, k] = rows[:, k - 1] * rises / k
    return rows


def times_line(rows: np.ndarray, level: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the rows of the product of a series and of level + slope x."""
    found = rows * level[:, None]
    found[:, 1:] += rows[:, :-1] * slope[:, None]
    return found


def polynomial(coefficients: np.ndarray, at: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the rows (n, TERMS) of polynomials over cells.

    Arguments: `coefficients` (n, m) of the powers of a time [s]; `at` (n,), that time where each
    cell begins; `lengths` (n,) of the cells [s].

    Cost: m (m - 1) / 2 products of arrays, synthetic divisions (Horner).
    """
    shifted = coefficients.astype(np.float64)
    most = shifted.shape[1]
    for first in range(most - 1):
        for k in range(most - 2, first - 1, -1):
            shifted[:, k] += at * shifted[:, k + 1]
    rows, scale = np.zeros((len(at), TERMS)), np.ones(len(at))
    for k in range(most):
        rows[:, k] = shifted[:, k] * scale
        scale = scale * lengths
    return rows


def values_of(rows: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the values (n,) of rows at the places x (n,) in their cells (Horner)."""
    found = rows[:, -1].copy()
    for k in range(TERMS - 2, -1, -1):
        found = found * x + rows[:, k]
    return found


# ---- every load ----------------------------------------------------------------------------------


G = 9.80665
"""Standard gravity [m/s^2]."""

FORCES = {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605}
"""Units of a force on m1, in N."""

ACCELERATIONS = {
    "m/s^2": 1.0,
    "cm/s^2": 0.01,
    "gal": 0.01,
    "mm/s^2": 0.001,
    "in/s^2": 0.0254,
    "g": G,
}
"""Units of an acceleration of the ground, in m/s^2."""

UNIT = OneOf((*FORCES, *ACCELERATIONS), "unit")

UNIT_WORDS = (
    "`N`, `kN` or `lbf`: a force on m1; `m/s^2`, `cm/s^2`, `gal`, `mm/s^2`, `in/s^2` or `g`: "
    "the ground's acceleration"
)

Given = TypeVar("Given", bound="Load")

TIME = Real(0.0, 1e9)
LENGTH = Real(0.0, 1e9, inside=True)


@dataclass(frozen=True)
class Size:
    """A number other than zero, of either sign."""

    def __call__(self, name: str, value: Any, /) -> float:
        size = number(name, value)
        if not 0.0 < abs(size) <= 1e15:
            raise RequestError(f"{name} = {size!r}; allowed: up to 1e15 to either side, and not 0")
        return size


@dataclass(frozen=True, kw_only=True)
class Load:
    """What acts on a structure; frozen and checked when made."""

    kind: ClassVar[str]
    """The key of `[load]`."""

    table: ClassVar[str]
    """`load.` and the kind."""

    def __init_subclass__(cls) -> None:
        """Name the table of its settings."""
        cls.table = f"load.{getattr(cls, 'kind', '')}"

    def __post_init__(self) -> None:
        """Check all fields by themselves, then together."""
        check_settings(self)
        self.check()

    def check(self) -> None:
        """Raise `RequestError` where fields contradict each other."""

    def kinks(self, end: float) -> np.ndarray:
        """Return the times [s] up to `end` at which it is not smooth, ascending."""
        return np.zeros(0)

    def entry(self) -> dict[str, Any]:
        """Return its table of a request file."""
        return entries(self, self.table)

    @classmethod
    def of(cls: type[Given], entry: object) -> Given:
        """Return the load that a table means; `RequestError` for anything else."""
        settings = {setting.key: setting for setting in settings_of(cls).values()}
        with at(f"[{cls.table}]"):
            entries = table(cls.kind, entry, settings)
            for key, setting in settings.items():
                if setting.default is MISSING and key not in entries:
                    raise RequestError(f"{key} is missing: {setting.words}")
            return cls(**entries)


@dataclass(frozen=True, kw_only=True)
class Course(Load):
    """A force on m1, or an acceleration of the ground, over time."""

    unit: str = setting("N", UNIT, "", UNIT_WORDS)

    @property
    def shakes(self) -> bool:
        """Whether it is an acceleration of the ground."""
        return self.unit in ACCELERATIONS

    @property
    def factor(self) -> float:
        """Of its unit, in N or m/s^2."""
        return {**FORCES, **ACCELERATIONS}[self.unit]

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return bounds [1/s], at times without a kink, on the growth of its derivatives there.

        The n-th is at most its size times rate^n, up to the next kink.
        """
        raise NotImplementedError

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the Taylor coefficients (n, TERMS) in its unit, over cells without a kink within.

        Arguments: where the cells begin (n,) and how long they are (n,) [s].
        """
        raise NotImplementedError

    def value(self, times: np.ndarray) -> np.ndarray:
        """Return its values at times (n,) in its unit; of two at a jump, the later one."""
        return values_of(self.rows(times, np.zeros(len(times))), np.zeros(len(times)))


# ---- pulses --------------------------------------------------------------------------------------


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
        return np.pi / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return those of the sine, a cosine a quarter of a turn later."""
        return cosine(0.5 * since / self.length - 0.25, np.pi * lengths / self.length)


@dataclass(frozen=True, kw_only=True)
class Rectangular(Pulse):
    """F."""

    kind: ClassVar[str] = "rectangular"

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        return polynomial(np.ones((len(since), 1)), since, lengths)


@dataclass(frozen=True, kw_only=True)
class Triangular(Pulse):
    """Up to F in a share of the length, and down to 0; a share of 0 is a jump."""

    rise: float = setting(0.5, Real(0.0, 1.0), "", "share of its length up to the peak")

    kind: ClassVar[str] = "triangular"

    def corners(self) -> np.ndarray:
        return np.array([0.0, self.rise * self.length, self.length])

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
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
        return self.suction

    def corners(self) -> np.ndarray:
        """Return its ends; the negative phase has none."""
        return np.array([0.0]) if self.suction else np.array([0.0, self.length])

    @property
    def rate(self) -> float:
        """Of line and exponential: derivatives of their product grow by at most 1 + decay."""
        return (1.0 + self.decay) / self.length

    def shape(self, since: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        x, dx = since / self.length, lengths / self.length
        return times_line(growth(-self.decay * x, -self.decay * dx), 1.0 - x, -dx)


# ---- waves ---------------------------------------------------------------------------------------


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
        return np.full(len(times), self.omega)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
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
        return self.low + (np.arange(self.tones) + 0.5) * (self.high - self.low) / self.tones

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.full(len(times), self.high)

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the sum over the tones, from the first on.

        Cost: 3 ns a cell and tone.
        """
        return tones(self.omegas / TURN, self.phases, begins, lengths) * (
            self.rms * np.sqrt(2.0 / self.tones)
        )
