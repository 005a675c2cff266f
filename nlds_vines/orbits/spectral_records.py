"""The spectral records of scans: amplitudes, lines of periodic orbits, the broadband share.

They use equidistant states over the sampled periods, a whole number per period, so that each
multiple of 1 / periods of the forcing frequency is a bin.  A spectrum of 240 periods with 64 states
each takes 0.4 ms; its background takes as long.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError, checked_words, choice
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.model.quantities import OF_SIGNALS
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.spectrum import SIGNALS, TAPERS, spectrum_of

LINES = 24
"""Number of recorded lines of an nT orbit, at m / n of the forcing frequency, m = 1, 2, ..."""

USUAL = ("x1", "u", "x")
"""The default signals, of which a scene has some."""


UNCLEAR = "unclear"
"""The spectral label if the broadband share, or too few sampled periods, does not decide."""

LINES_BELOW, BROADBAND_ABOVE = 1e-4, 1e-3
"""A smaller broadband share means lines alone; a share above the second, a continuous spectrum.

From 19 quasiperiodic and 13 chaotic motions of Set 6 between 7.363 and 7.425 rad/s: see
`docs/portrait.md#spectra-along-a-scan`."""

FEWEST_PERIODS = 120
"""Least number of sampled periods for which the broadband share separates regimes.  With 60, lines
are so close that 14 of 19 quasiperiodic motions have shares above `BROADBAND_ABOVE`, with 90 two of
18, with 120 none (at most 7.3e-4)."""


def recordable(scene: Scene) -> tuple[str, ...]:
    return (*scene.components, *(["u"] if scene.damper else []))


def checked_signals(value: object) -> tuple[str, ...]:
    if isinstance(value, list | tuple) and not value:
        return ()
    return checked_words("signals", value, SIGNALS, "signal")


@dataclass(frozen=True)
class SpectralRecords:
    """The spectral records of a scan."""

    want: Collection[str]  # words of `records.SPECTRAL`
    scene: Scene
    signals: tuple[str, ...]  # of `recordable`; by default those of `USUAL` that the scene has
    periods: int  # sampled, of `samples` states each
    samples: int
    highest: float  # frequency of a bin in multiples of the forcing frequency
    window: str  # of `spectrum.TAPERS`, for amplitudes; the broadband share uses Hann

    def __post_init__(self) -> None:
        """Check everything."""
        signals = recordable(self.scene)
        usual = tuple(name for name in USUAL if name in signals)
        object.__setattr__(self, "signals", self.signals or usual)
        for name in self.signals:
            choice("signal", name, signals)
        choice("window", self.window, TAPERS)
        if not self.highest <= self.samples / 2:
            raise RequestError(
                f"highest = {self.highest!r} with samples = {self.samples}; allowed: up to half "
                "of the samples of a period"
            )

    @property
    def bins(self) -> int:
        return int(self.highest * self.periods) + 1

    @property
    def order(self) -> np.ndarray:
        """The frequency of each bin in multiples of that of the force."""
        return np.arange(self.bins) / self.periods

    def lengths(self) -> dict[str, int]:
        sizes = {"signal": len(self.signals)}
        sizes |= {"frequency": self.bins} if "spectrum" in self.want else {}
        return sizes | ({"line": LINES} if "lines" in self.want else {})

    def scales(self) -> Iterator[Scale]:
        yield Scale("signal", np.array(self.signals), "1", "signal of the spectrum")
        if "spectrum" in self.want:
            text = f"frequency over that of the force; {self.window} window"
            yield Scale("frequency", self.order, "1", text)
        if "lines" in self.want:
            text = "number m of the line at m / n of the frequency of the force, n of `line_period`"
            yield Scale.counted("line", LINES, text, 1)

    def in_units(self, dataset: Dataset) -> Dataset:
        """Return a dataset with the units of the signals in place of `OF_SIGNALS`."""
        units = ", ".join(dict.fromkeys(SIGNALS[name].unit for name in self.signals))
        return replace(dataset, units=units) if dataset.units == OF_SIGNALS else dataset


# ---- values, from equidistant states ----


def spectral_label(n: int, share: float, periods: int) -> str:
    """Return the label of an orbit by its spectra alone, sampled over `periods`.

    It is `nT` if the section recurs.  Otherwise the broadband `share` decides, if there are enough
    periods.
    """
    if n:
        return f"{n}T" if n > 1 else "T"
    if periods < FEWEST_PERIODS:
        return UNCLEAR
    if share < LINES_BELOW:
        return "lines"
    return "broadband" if share > BROADBAND_ABOVE else UNCLEAR


def agreement(
    regime: np.ndarray, period: np.ndarray, spectral_labels: np.ndarray, periods: int
) -> np.ndarray:
    """Return whether verdicts and spectra agree: codes of `labels.KEPT`, -1 if undecided.

    Arguments: codes of the `regime`, the `period` n of nT and the spectral labels, of one shape;
    the number of sampled `periods`.
    An nT orbit agrees with nT, a quasiperiodic one with lines, chaos with a broadband spectrum.
    It is undecided if n exceeds a third of `periods`: `period_of` finds no such recurrence.
    """
    from nlds_vines.kernels.orbit.repetition import REPEATS

    words = {FLAGS["quasiperiodic"]: "lines", FLAGS["chaotic"]: "broadband"}
    agreed = np.full(regime.shape, -1, np.int8)
    for place in np.ndindex(regime.shape):
        n, says = int(period[place]), str(spectral_labels[place])
        expected = spectral_label(n, 0.0, periods) if n else words.get(int(regime[place]), "")
        if REPEATS * n > periods:
            continue
        if expected and says not in ("", UNCLEAR):
            agreed[place] = KEPT["yes" if says == expected else "no"]
    return agreed


def arrays_of(
    records: SpectralRecords, states: np.ndarray, sound: np.ndarray, transient: int
) -> dict[str, np.ndarray]:
    """Return the datasets by name, (sweeps, cells, ...) each. Orbits that failed have NaN,
    `line_period` 0 and `spectral_label` "".

    Arguments: the `records`; `states` (sweeps, cells, periods samples, components), the last of
    each period at its end; `sound` (sweeps, cells), False for orbits that failed; the `transient`
    before.
    """
    from nlds_vines.kernels.orbit.repetition import TOLERANCE, period_of

    shape, arrays = sound.shape, dict[str, np.ndarray]()
    of_each = (*shape, len(records.signals))
    if "spectrum" in records.want:
        arrays["spectrum"] = np.full((*of_each, records.bins), np.nan)
    if "lines" in records.want:
        arrays["line_period"] = np.zeros(shape, np.int32)
        for name in ("line_amplitude", "line_phase"):
            arrays[name] = np.full((*of_each, LINES), np.nan)
    if "broadband" in records.want:
        arrays["broadband"] = np.full(of_each, np.nan)
        arrays["spectral_label"] = np.full(shape, "", "<U16")
    for lane in zip(*np.nonzero(sound), strict=True):
        of_orbit = states[lane]
        section = np.ascontiguousarray(of_orbit[records.samples - 1 :: records.samples])
        n = int(period_of(section, TOLERANCE))
        if "lines" in records.want:
            arrays["line_period"][lane] = n
        for i, name in enumerate(records.signals):
            here = (*lane, i)
            if name == "u":
                values = of_orbit[:, 2] - of_orbit[:, 0]
            else:
                column = records.scene.components.index(name)
                values = np.ascontiguousarray(of_orbit[:, column])
            if "spectrum" in records.want:
                whole = spectrum_of(values, records.samples, 1.0, window=records.window)
                arrays["spectrum"][here] = whole.amplitude[: records.bins]
            if "broadband" in records.want:
                tapered = spectrum_of(values, records.samples, 1.0, window="hann")
                arrays["broadband"][here] = tapered.background_share(records.bins)
            if "lines" in records.want and n:
                amplitude, phase = _lines(records, values, n, transient)
                arrays["line_amplitude"][here], arrays["line_phase"][here] = amplitude, phase
        if "broadband" in records.want:
            arrays["spectral_label"][lane] = spectral_label(
                n, arrays["broadband"][lane].max(), len(section)
            )
    return arrays


def _lines(
    records: SpectralRecords, values: np.ndarray, n: int, transient: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes and phases (LINES,) of a signal of an nT orbit.

    They are taken over the last whole cycles of n periods, so that each line lies on a bin and
    none leaks.
    """
    cycles = records.periods // n
    last = values[-cycles * n * records.samples :]
    spectrum = np.fft.rfft(last) * (2.0 / last.size)
    numbers = np.arange(1, LINES + 1)
    bins = numbers * cycles
    is_below_nyquist = bins < spectrum.size - 1
    lines = np.where(is_below_nyquist, spectrum[np.minimum(bins, spectrum.size - 1)], np.nan)
    first = (transient + records.periods - cycles * n) * records.samples + 1
    turns = numbers * first / (n * records.samples)  # of the line, from t = 0 to its first sample
    angle = np.angle(lines) - 2.0 * np.pi * (turns % 1.0)
    phases = -((np.pi - angle) % (2.0 * np.pi) - np.pi)  # in (-pi, pi]
    return np.abs(lines), np.where(is_below_nyquist, phases, np.nan)
