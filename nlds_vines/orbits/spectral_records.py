"""What a scan records of spectra: amplitudes, the lines of periodic orbits, the broadband share.

All of them rest on states at equal steps over the sampled periods, so that a whole period is a
whole number of samples and every multiple of 1 / periods of the forcing frequency is a bin.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError, choice, shown
from nlds_vines.kernels.recurrence import TOLERANCE, period_of
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.spectrum import TAPERS, spectrum_of

LINES = 24
"""Lines of a periodic orbit that are recorded: m / n of the forcing frequency, m from 1 on."""

USUAL = ("x1", "u", "x")
"""Signals that are recorded unless others are asked for, as far as a scene has them."""


LINES_BELOW, BROADBAND_ABOVE = 1e-4, 1e-3
"""Broadband shares of lines alone and of continuous spectra.

In the default diagram, 240 periods sampled: quasiperiodic motions up to 1e-4, chaos from 6e-4, half
of it above 5e-3."""


def spectral_label(n: int, share: float) -> str:
    """Return what spectra say of an orbit: its period, or what the broadband share tells."""
    if n:
        return f"{n}T" if n > 1 else "T"
    if share < LINES_BELOW:
        return "lines"
    return "broadband" if share > BROADBAND_ABOVE else "unclear"


def recordable(scene: Scene) -> tuple[str, ...]:
    """Return the signals of which scans record spectra: the state, and u = x2 - x1."""
    return (*scene.components, *(["u"] if scene.damper else []))


def checked_signals(value: object) -> tuple[str, ...]:
    """Return different names of signals; `RequestError` for anything else."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RequestError(f"signals = {shown(value)} must be a list of words")
    words = tuple(choice("signal", word, SIGNALS) for word in value)
    if len(set(words)) < len(words):
        raise RequestError(f"signals = {shown(list(words))} names something twice")
    return words


@dataclass(frozen=True)
class SpectralRecords:
    """What is recorded of the spectra of a scan's orbits.

    Attributes:
        want: of `wants.SPECTRAL`.
        scene: of the scan.
        signals: of `recordable`; by default those of `USUAL` that the scene has.
        periods: sampled, `samples` states each.
        highest: multiple of the forcing frequency up to which bins are kept.
        window: one of `spectrum.TAPERS`, for amplitudes; the broadband share takes Hann's.

    Raises `RequestError` for a signal that the scene lacks, and for bins beyond the samples.
    """

    want: Collection[str]
    scene: Scene
    signals: tuple[str, ...]
    periods: int
    samples: int
    highest: float
    window: str

    def __post_init__(self) -> None:
        """Check everything."""
        known = recordable(self.scene)
        usual = tuple(name for name in USUAL if name in known)
        object.__setattr__(self, "signals", self.signals or usual)
        for name in self.signals:
            choice("signal", name, known)
        choice("window", self.window, TAPERS)
        if not self.highest <= self.samples / 2:
            raise RequestError(
                f"highest = {self.highest!r} with samples = {self.samples}; allowed: up to half "
                "of the samples of a period"
            )

    @property
    def bins(self) -> int:
        """How many bins are kept, that of the mean included."""
        return int(self.highest * self.periods) + 1

    @property
    def order(self) -> np.ndarray:
        """The frequency of each bin in multiples of that of the force."""
        return np.arange(self.bins) / self.periods

    # ---- the datasets ----------------------------------------------------------------------------

    def lengths(self) -> dict[str, int]:
        """Return the lengths of the dimensions that there are."""
        found = {"signal": len(self.signals)}
        found |= {"frequency": self.bins} if "spectrum" in self.want else {}
        return found | ({"line": LINES} if "lines" in self.want else {})

    def scales(self) -> Iterator[Scale]:
        """Yield the dimensions that there are, with their values."""
        yield Scale("signal", np.array(self.signals), "1", "what the spectrum is of")
        if "spectrum" in self.want:
            text = f"frequency over that of the force; {self.window} window"
            yield Scale("frequency", self.order, "1", text)
        if "lines" in self.want:
            text = "number m of the line at m / n of the frequency of the force, n of `line_period`"
            yield Scale("line", np.arange(1, LINES + 1, dtype=np.int32), "1", text)

    def datasets(self, lanes: tuple[str, ...]) -> Iterator[Dataset]:
        """Yield what is recorded along `lanes`, the dimensions of all orbits."""
        units = list(dict.fromkeys(SIGNALS[name].unit for name in self.signals))
        unit, of_each = ", ".join(units), (*lanes, "signal")
        if "spectrum" in self.want:
            text = "amplitude of the line in each bin; that of the mean is its size"
            dims = (*of_each, "frequency")
            yield Dataset("spectrum", dims, "float64", unit, text, np.nan)
        if "lines" in self.want:
            text = "n of the nT orbit by recurrence, whose lines are told; 0 where none was found"
            yield Dataset("line_period", lanes, "int32", "1", text, 0)
            text = "amplitude A of the line A cos(m omega t / n + phase)"
            yield Dataset("line_amplitude", (*of_each, "line"), "float64", unit, text, np.nan)
            text = "phase of the line, t from the start of the orbit"
            yield Dataset("line_phase", (*of_each, "line"), "float64", "rad", text, np.nan)
        if "broadband" in self.want:
            text = "share of the power that is no line: of the background of the spectrum"
            yield Dataset("broadband", of_each, "float64", "1", text, np.nan)
            text = "what the spectra alone say: nT by recurrence, lines, broadband or unclear"
            yield Dataset("spectral_label", lanes, "str", "1", text, "")

    # ---- their values ----------------------------------------------------------------------------

    def arrays_of(
        self, states: np.ndarray, sound: np.ndarray, transient: int
    ) -> dict[str, np.ndarray]:
        """Return the datasets by name, (chains, links, ...) each; NaN where orbits failed.

        Arguments: `states` (chains, links, periods samples, components), the last of each period at
        its end; `sound` (chains, links), which of them mean something; the `transient` before.
        """
        shape, of_each = sound.shape, (*sound.shape, len(self.signals))
        tails = {
            "spectrum": (self.bins,),
            "line_amplitude": (LINES,),
            "line_phase": (LINES,),
            "broadband": (),
        }
        found = {name: np.full((*of_each, *tail), np.nan) for name, tail in tails.items()}
        found["line_period"] = np.zeros(shape, np.int32)
        found["spectral_label"] = np.full(shape, "", "<U16")
        for lane in zip(*np.nonzero(sound), strict=True):
            own = states[lane]
            section = np.ascontiguousarray(own[self.samples - 1 :: self.samples])
            n = int(period_of(section, TOLERANCE))
            found["line_period"][lane] = n
            for i, name in enumerate(self.signals):
                values, here = self._signal(name, own), (*lane, i)
                if "spectrum" in self.want:
                    whole = spectrum_of(values, self.samples, 1.0, window=self.window)
                    found["spectrum"][here] = whole.amplitude[: self.bins]
                if "broadband" in self.want:
                    tapered = spectrum_of(values, self.samples, 1.0, window="hann")
                    found["broadband"][here] = tapered.background_share(self.bins)
                if "lines" in self.want and n:
                    amplitude, phase = self._lines(values, n, transient)
                    found["line_amplitude"][here], found["line_phase"][here] = amplitude, phase
            if "broadband" in self.want:
                found["spectral_label"][lane] = spectral_label(n, found["broadband"][lane].max())
        return found

    def _signal(self, name: str, own: np.ndarray) -> np.ndarray:
        if name == "u":
            return own[:, 2] - own[:, 0]
        return np.ascontiguousarray(own[:, self.scene.components.index(name)])

    def _lines(self, values: np.ndarray, n: int, transient: int) -> tuple[np.ndarray, np.ndarray]:
        """Return amplitudes and phases (LINES,) of a signal of an nT orbit.

        Of as many of the last periods as make whole cycles: then each line stands on a bin, and
        nothing leaks.
        """
        cycles = self.periods // n
        last = values[-cycles * n * self.samples :]
        found = np.fft.rfft(last) * (2.0 / last.size)
        numbers = np.arange(1, LINES + 1)
        bins = numbers * cycles
        there = bins < found.size - 1  # below the Nyquist frequency
        lines = np.where(there, found[np.minimum(bins, found.size - 1)], np.nan)
        first = (transient + self.periods - cycles * n) * self.samples + 1
        turns = numbers * first / (n * self.samples)  # of the line, from t = 0 to its first sample
        angle = np.angle(lines) - 2.0 * np.pi * (turns % 1.0)
        return np.abs(lines), np.where(there, -((np.pi - angle) % (2.0 * np.pi) - np.pi), np.nan)
