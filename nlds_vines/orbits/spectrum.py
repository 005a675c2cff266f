"""Fourier spectra, phase-locked to the forcing: lines, decibels, and the broadband share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, choice, number, shown, whole
from nlds_vines.orbits.signals import SIGNALS, checked_signal
from nlds_vines.orbits.tapers import TAPERS, weights_of

if TYPE_CHECKING:
    from nlds_vines.orbits.simulation import Orbit


NEIGHBORS = 8
"""Bins to either side of one whose median is the background there (`Spectrum.background_share`)."""

SILENCE = 1.0e-15
"""Standard deviation, relative to the largest value, below which a signal counts as constant."""


@dataclass(frozen=True, repr=False)
class Spectrum(Outlined):
    """The one-sided amplitude spectrum of a signal over whole forcing periods.

    Attributes:
        order: frequency of each bin in multiples of the forcing frequency, k / periods.
        amplitude: of the line in each bin, in the signal's `unit`: a line A cos on a bin gives A,
            with either window; the first is the modulus of the mean.
        power: share of each bin in the variance, [unit^2]; its sum is the variance exactly
            (Parseval; that of the tapered signal, normalized by the window's mean square).
        omega: the forcing frequency [rad/s].
        samples: in each forcing period; periods: how many; window: one of `TAPERS`.
        quantity, unit: what it is a spectrum of.
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
        """Return what it is a spectrum of."""
        return f"of {self.quantity} [{self.unit}]" if self.quantity else ""

    def outline(self) -> Rows:
        """Return its lengths and its largest line."""
        how = f"{self.periods} periods of {self.samples} samples, {self.window} window"
        yield "taken from", f"{how}; {self.order.size} bins, resolution {self.resolution:.4g}"
        if self.order.size > 1:
            i = 1 + int(np.argmax(self.amplitude[1:]))
            yield "largest line", f"{self.amplitude[i]:.6g} at {self.order[i]:.6g} omega"

    @property
    def frequency(self) -> np.ndarray:
        """The angular frequency of each bin [rad/s]."""
        return self.order * self.omega

    @property
    def resolution(self) -> float:
        """Distance of two bins in multiples of the forcing frequency: 1 / periods."""
        return 1.0 / self.periods

    @property
    def bandwidth(self) -> float:
        """Equivalent noise bandwidth in multiples of the forcing frequency.

        One bin for the rectangular window, one and a half for Hann.
        """
        taper = weights_of(self.window, self.samples * self.periods)
        return self.resolution * float(np.mean(taper**2) / np.mean(taper) ** 2)

    def decibels(self, reference: float = 1.0) -> np.ndarray:
        """Return 20 log10 of the amplitude over a `reference` in the signal's unit (> 0).

        A bin that is exactly zero becomes -inf.
        """
        if number("reference", reference) <= 0:
            raise RequestError(f"reference = {reference!r}; allowed: > 0")
        with np.errstate(divide="ignore"):
            return 20 * np.log10(self.amplitude / reference)

    def most_lines(self) -> int:
        """Return the largest n for which `broadband_share` has enough bins between its lines."""
        return self.periods // (2 * self._width())

    def broadband_share(self, n: int = 0) -> float:
        """Return the share of the power that lies outside the lines of an nT orbit, 0 to 1.

        The mean does not count.  With N periods, the lines of the comb are the bins j N / n,
        j = 1, 2, ..., that is the frequencies j omega / n, each with as many bins to either side
        as the window spreads it over (none for rectangular, one for Hann); n = 0 stands for "no
        period known" and means the harmonics of the forcing, like n = 1.  The share is

            1 - (power in the comb) / (power in all bins but the mean's).

        It is zero to round-off for an nT orbit, T-periodic ones included, with either window.
        White noise gives 1 - n (2 reach + 1) / N: the comb may cover half of all bins at most.
        Sampling in step with the force folds harmonics onto harmonics, so that aliasing does not
        count as broadband.  A constant signal has the share 0.

        Raises `RequestError` unless N is a multiple of n, and at least `2 n (2 reach + 1)`.
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
        return float(power[~self._comb(n)[1:]].sum() / total)

    def background_share(self, bins: int) -> float:
        """Return the share of the power that is background and no line, 0 to 1.

        Of the first `bins`, without the mean: the sum of min(P_k, median of P around k) over that
        of P.  A line is what stands above the median of the `NEIGHBORS` bins to either side.
        Lines of any frequencies, those of a quasiperiodic motion too, leave next to nothing;
        continuous spectra leave most.  With Hann's window lines may be as near as `NEIGHBORS`
        bins: of an nT orbit there must be ten n periods or more.
        """
        power = self.power[1:bins]
        total = float(power.sum())
        if total == 0.0:
            return 0.0
        padded = np.pad(power, NEIGHBORS, mode="reflect")
        around = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBORS + 1)
        return float(np.minimum(power, np.median(around, axis=1)).sum() / total)

    def bins_holding(self, share: float = 0.99) -> int:
        """Return how few bins hold a `share` (0 to 1) of the power, the mean not counted.

        It needs no comb: an orbit of a long or unknown period has few such bins, and as many in a
        window twice as long; where the spectrum is broad, they grow with the window.
        """
        if not 0 < number("share", share) <= 1:
            raise RequestError(f"share = {share!r}; allowed: above 0, up to 1")
        sums = np.cumsum(np.sort(self.power[1:])[::-1])
        if sums[-1] == 0:
            return 0
        return int(np.searchsorted(sums, share * sums[-1])) + 1

    def _width(self) -> int:
        return 2 * TAPERS[self.window].reach + 1

    def _comb(self, n: int) -> np.ndarray:
        """Tell of every bin whether it belongs to the lines of an nT orbit."""
        spacing, reach = self.periods // n, TAPERS[self.window].reach
        place = np.arange(self.order.size)
        nearest = spacing * np.round(place / spacing)
        return (np.abs(place - nearest) <= reach) & (place > reach)


def spectrum(orbit: Orbit, signal: str = "x1", *, window: str = "rectangular") -> Spectrum:
    """Return the spectrum of a signal along an orbit.

    Arguments:
        orbit: from `simulate` with "trajectory" among `record`; for an nT orbit, record a
            multiple of n periods: then every line stands on a bin and nothing leaks.
        signal: a component of the state x1, v1, x2, v2 [m, m/s], u = x2 - x1 [m], the contact
            `force` on the damper [N], or an energy E1, E2 [J].
        window: `rectangular` or `hann`.

    States need no more than the 512 samples a period that `simulate` takes by default: what is
    folded back onto their lines is below 1e-9 m.  A contact is short (16 to 24 ms, a fiftieth of
    a period) and the spectrum of its force wide: 512 samples leave an error of 2e-3 of its largest
    line, 1024 of 4e-4, 4096 of 1e-5 (SSul Set 6, 7.375 rad/s).

    Raises `RequestError` for an orbit without trajectory and a signal that its scene lacks.
    """
    if not hasattr(orbit, "trajectory"):
        raise RequestError(f"orbit = {shown(orbit)} must be an Orbit, as simulate returns it")
    checked_signal(signal, orbit.system.scene)
    if orbit.trajectory is None or orbit.time is None:
        raise RequestError("the orbit holds no trajectory: simulate with record=['trajectory']")
    if len(orbit.time) < 2:
        raise RequestError("a trajectory of one state has no spectrum: record more periods")
    step = (orbit.time[-1] - orbit.time[0]) / (len(orbit.time) - 1)
    return spectrum_of(
        SIGNALS[signal].of(orbit.system, orbit.trajectory),
        round(orbit.system.period / step),
        orbit.system.parameters["omega"],
        window=window,
        quantity=signal,
        unit=SIGNALS[signal].unit,
    )


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

    Arguments: `values`, `samples` of them a period; the forcing frequency `omega` [rad/s]; the
    rest as in `Spectrum`.

    With weights w_j and the mean taken off, X_k = sum_j w_j x_j exp(-2 pi i j k / M); amplitude
    2 |X_k| / sum w, power 2 |X_k|^2 / (M sum w^2), each without the 2 at the Nyquist frequency.

    Raises `RequestError` for values that are not finite or no whole number of periods.
    """
    x = _checked_values(values, whole("samples", samples, 2))
    choice("window", window, TAPERS)
    weights, mean, count = weights_of(window, x.size), x.mean(), x.size
    rest = x - mean
    if rest.std() <= SILENCE * np.abs(x).max():
        rest = np.zeros_like(x)  # what round-off leaves of a constant is no spectrum
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


def _checked_values(values: Any, samples: int) -> np.ndarray:
    x = np.asarray(values, dtype=np.float64)
    if x.ndim != 1 or x.size == 0 or x.size % samples:
        raise RequestError(
            f"values of shape {x.shape} are no whole number of periods of {samples} samples"
        )
    if not np.isfinite(x).all():
        raise RequestError("values must be finite numbers")
    return x
