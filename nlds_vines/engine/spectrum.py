"""Fourier spectra of signals along an orbit, and the spectral records of scans."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, choice, number, shown, whole
from nlds_vines.model.quantities import OF_SIGNALS
from nlds_vines.model.signals import Signal

TAPERS: Mapping[str, int] = {"rectangular": 0, "hann": 1}
"""The window functions, with the bins to either side of its own that a line on a bin fills.  One
between two bins leaks far with the first, little with the second."""

# bins to either side of one whose median is the background there (`Spectrum.background_share`)
NEIGHBORS = 8

# standard deviation, relative to the largest value, below which a signal counts as constant
SILENCE = 1.0e-15


@dataclass(frozen=True, repr=False)
class Spectrum(Outlined):
    """One-sided amplitude spectrum of a signal over whole forcing periods.

    Attributes
    ----------
    order : (bins,) ndarray
        Frequency of each bin in multiples of the forcing frequency, k / periods.
    amplitude : (bins,) ndarray
        Amplitude of the line in each bin [unit]: a line A cos on a bin gives A with either window.
        The first is the modulus of the mean.
    power : (bins,) ndarray
        Contribution of each bin to the variance [unit^2], of the tapered signal normalized by the
        mean square of the window; the sum is the variance exactly (Parseval).
    omega : float
        Forcing frequency [rad/s].
    samples, periods : int
        Samples per forcing period, and number of periods.
    window : str
        "rectangular" or "hann".
    quantity, unit : str
        Name and unit of the signal.
    """

    order: np.ndarray
    amplitude: np.ndarray
    power: np.ndarray
    omega: float
    samples: int
    periods: int
    window: str
    quantity: str = ""
    unit: str = "1"

    def heading(self) -> str:
        """Return the signal with its unit."""
        return f"of {self.quantity} [{self.unit}]" if self.quantity else ""

    def outline(self) -> Rows:
        """Return lengths and the largest line."""
        how = f"{self.periods} periods of {self.samples} samples, {self.window} window"
        yield "from", f"{how}; {self.order.size} bins, resolution {self.resolution:.4g}"
        if self.order.size > 1:
            i = 1 + int(np.argmax(self.amplitude[1:]))
            yield "largest line", f"{self.amplitude[i]:.6g} at {self.order[i]:.6g} omega"

    @property
    def frequency(self) -> np.ndarray:
        """The angular frequency of each bin [rad/s]."""
        return self.order * self.omega

    @property
    def resolution(self) -> float:
        """The distance of two bins in multiples of the forcing frequency: 1 / periods."""
        return 1.0 / self.periods

    def decibels(self) -> np.ndarray:
        """Return 20 log10(amplitude), -inf where it is exactly zero."""
        with np.errstate(divide="ignore"):
            return 20 * np.log10(self.amplitude)

    def most_lines(self) -> int:
        """Return the largest n that `broadband_share` accepts."""
        return self.periods // (2 * (2 * TAPERS[self.window] + 1))

    def broadband_share(self, n: int = 0) -> float:
        """Return the share of the power outside the lines of an nT orbit, 0 to 1.

        Parameters
        ----------
        n : int
            Period of the orbit in forcing periods; 0 and 1 mean the harmonics of the forcing.

        Returns
        -------
        float
            1 - (power in the comb) / (power in all bins but that of the mean); 0 for a constant
            signal.

        Raises
        ------
        RequestError
            Unless the number N of periods is a multiple of n and at least ``2 n (2 reach + 1)``.

        Notes
        -----
        The comb holds the bins j N / n, j = 1, 2, ..., and `reach` bins to either side of each:
        none for the rectangular window, one for Hann.  The share of an nT orbit is zero to
        round-off; that of white noise is 1 - n (2 reach + 1) / N.  Sampling in step with the force
        aliases harmonics onto harmonics, so that aliasing does not count as broadband.
        """
        n = max(whole("n", n, 0), 1)
        if self.periods % n or n > self.most_lines():
            raise RequestError(
                f"n = {n} does not suit a spectrum of {self.periods} periods with the window "
                f"{self.window!r}; allowed: divisors of {self.periods} up to {self.most_lines()}"
            )
        power = self.power[1:]
        total = power.sum()
        if total == 0:
            return 0.0
        spacing, reach = self.periods // n, TAPERS[self.window]
        place = np.arange(1, self.order.size)
        nearest = spacing * np.round(place / spacing)
        in_comb = (np.abs(place - nearest) <= reach) & (place > reach)
        return float(power[~in_comb].sum() / total)

    def background_share(self, bins: int) -> float:
        """Return the share of the power in the background between lines, 0 to 1.

        Parameters
        ----------
        bins : int
            Number of bins that count; the mean does not.

        Returns
        -------
        float
            sum_k min(P_k, median of P around k) / sum_k P_k, with the median over `NEIGHBORS` bins
            to either side.  Lines at any frequencies, also those of a quasiperiodic motion, leave a
            share near 0, continuous spectra one near 1.

        Notes
        -----
        With the Hann window, lines may be as near as `NEIGHBORS` bins: an nT orbit needs at least
        10 n periods.
        """
        power = self.power[1:bins]
        total = float(power.sum())
        if total == 0.0:
            return 0.0
        padded = np.pad(power, NEIGHBORS, mode="reflect")
        around = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBORS + 1)
        return float(np.minimum(power, np.median(around, axis=1)).sum() / total)

    def bins_holding(self, share: float = 0.99) -> int:
        """Return the smallest number of bins that hold a share of the power, without the mean.

        For an orbit with lines it does not depend on the number of periods; for a continuous
        spectrum it grows with that number.
        """
        sums = np.cumsum(np.sort(self.power[1:])[::-1])
        if sums[-1] == 0:
            return 0
        return int(np.searchsorted(sums, share * sums[-1])) + 1


def spectrum_of(
    values: Any,
    samples: int,
    omega: float,
    *,
    window: str = "rectangular",
    quantity: str = "",
    unit: str = "1",
) -> Spectrum:
    """Return the spectrum of equidistant values over a whole number of forcing periods.

    Arguments: `values`, `samples` of them per period; the forcing frequency `omega` [rad/s]; the
    rest as in `Spectrum`.

    With weights w_j and after subtraction of the mean, X_k = sum_j w_j x_j exp(-2 pi i j k / M).
    The amplitude is 2 |X_k| / sum w, the power 2 |X_k|^2 / (M sum w^2), each without the factor 2
    at the Nyquist frequency.

    Raises `RequestError` if values are not finite or not a whole number of periods.
    """
    x = np.asarray(values, dtype=np.float64)
    whole("samples", samples, 2)
    if x.ndim != 1 or x.size == 0 or x.size % samples:
        raise RequestError(
            f"values of shape {x.shape} are no whole number of periods of {samples} samples"
        )
    if not np.isfinite(x).all():
        raise RequestError("values must be finite numbers")
    choice("window", window, TAPERS)
    mean, count = x.mean(), x.size
    weights = np.ones(count)
    if window == "hann":  # periodic, as a discrete transform needs it
        # only here: SciPy's signal package takes longer to import than an orbit to compute
        from scipy.signal import windows

        weights = np.asarray(windows.hann(count, sym=False))
    rest = x - mean
    if rest.std() <= SILENCE * np.abs(x).max():
        rest = np.zeros_like(x)  # round-off of a constant has no spectrum
    modulus = np.abs(np.fft.rfft(weights * rest))
    sides = np.full(modulus.size, 2.0)
    sides[0] = 1.0
    sides[-1] = 1.0 if count % 2 == 0 else 2.0
    amplitude = sides * modulus / weights.sum()
    amplitude[0] = abs(mean)
    power = sides * modulus**2 / (count * np.sum(weights**2))
    periods = count // samples
    order = np.arange(modulus.size) / periods
    rate = number("omega", omega)
    return Spectrum(order, amplitude, power, rate, samples, periods, window, quantity, unit)


# ---- the spectral records of scans: amplitudes, lines of periodic orbits, the broadband share ----
#
# They use equidistant states over the sampled periods, a whole number per period, so that each
# multiple of 1 / periods of the forcing frequency is a bin.

# number of recorded lines of an nT orbit, at m / n of the forcing frequency, m = 1, 2, ...
LINES = 24

# the spectral label if the broadband share, or too few sampled periods, does not decide
UNCLEAR = "unclear"

# A smaller broadband share means lines alone; a share above the second, a continuous spectrum.
# From 19 quasiperiodic and 13 chaotic motions of Set 6 between 7.363 and 7.425 rad/s: see
# `docs/portrait.md#spectra-along-a-scan`.
LINES_BELOW, BROADBAND_ABOVE = 1e-4, 1e-3

# Least number of sampled periods for which the broadband share separates regimes.  With 60, lines
# are so close that 14 of 19 quasiperiodic motions have shares above `BROADBAND_ABOVE`, with 90 two
# of 18, with 120 none (at most 7.3e-4).
FEWEST_PERIODS = 120


def checked_signals(value: object) -> tuple[str, ...]:
    """Return different names of signals; the system of a scan checks what they mean."""
    if not isinstance(value, list | tuple) or not all(isinstance(name, str) for name in value):
        raise RequestError(f"signals = {shown(value)} must be a list of words")
    if len({*value}) < len(value):
        raise RequestError(f"signals = {shown(list(value))} names something twice")
    return tuple(value)


@dataclass(frozen=True)
class SpectralRecords:
    """The spectral records of a scan."""

    want: Collection[str]  # words of `records.SPECTRAL`
    signals: Mapping[str, Signal]  # by name
    periods: int  # sampled, of `samples` states each
    samples: int
    highest: float  # frequency of a bin in multiples of the forcing frequency
    window: str  # of `spectrum.TAPERS`, for amplitudes; the broadband share uses Hann

    def __post_init__(self) -> None:
        choice("window", self.window, TAPERS)
        if not self.highest <= self.samples / 2:
            raise RequestError(
                f"highest = {self.highest!r} with samples = {self.samples}; allowed: up to half "
                "of the samples of a period"
            )

    @property
    def bins(self) -> int:
        return int(self.highest * self.periods) + 1

    def lengths(self) -> dict[str, int]:
        sizes = {"signal": len(self.signals)}
        sizes |= {"frequency": self.bins} if "spectrum" in self.want else {}
        return sizes | ({"line": LINES} if "lines" in self.want else {})

    def scales(self) -> Iterator[Scale]:
        yield Scale("signal", np.array([*self.signals]), "1", "signal of the spectrum")
        if "spectrum" in self.want:
            text = f"frequency over that of the force; {self.window} window"
            yield Scale("frequency", np.arange(self.bins) / self.periods, "1", text)
        if "lines" in self.want:
            text = "number m of the line at m / n of the frequency of the force, n of `line_period`"
            yield Scale.counted("line", LINES, text, 1)

    def in_units(self, dataset: Dataset) -> Dataset:
        """Return a dataset with the units of the signals in place of `OF_SIGNALS`."""
        units = ", ".join(dict.fromkeys(signal.unit for signal in self.signals.values()))
        return replace(dataset, units=units) if dataset.units == OF_SIGNALS else dataset

    def lines_of(self, values: np.ndarray, n: int, transient: int) -> tuple[np.ndarray, np.ndarray]:
        """Return amplitudes and phases (LINES,) of a signal of an nT orbit."""
        # over the last whole cycles of n periods, so that each line lies on a bin and none leaks
        cycles = self.periods // n
        last = values[-cycles * n * self.samples :]
        spectrum = np.fft.rfft(last) * (2.0 / last.size)
        numbers = np.arange(1, LINES + 1)
        bins = numbers * cycles
        is_below_nyquist = bins < spectrum.size - 1
        lines = np.where(is_below_nyquist, spectrum[np.minimum(bins, spectrum.size - 1)], np.nan)
        first = (transient + self.periods - cycles * n) * self.samples + 1
        turns = numbers * first / (n * self.samples)  # of the line, from t = 0 to its first sample
        angle = np.angle(lines) - 2.0 * np.pi * (turns % 1.0)
        phases = -((np.pi - angle) % (2.0 * np.pi) - np.pi)  # in (-pi, pi]
        return np.abs(lines), np.where(is_below_nyquist, phases, np.nan)


def spectral_label(n: int, share: float, periods: int) -> str:
    """Return the label by spectra alone: nT if the section recurs, or by the broadband `share`."""
    if n:
        return f"{n}T" if n > 1 else "T"
    if periods < FEWEST_PERIODS:
        return UNCLEAR
    if share < LINES_BELOW:
        return "lines"
    return "broadband" if share > BROADBAND_ABOVE else UNCLEAR
