"""The spectral records of scans: amplitudes, lines of periodic orbits, the broadband share.

They use equidistant states over the sampled periods, a whole number per period, so that each
multiple of 1 / periods of the forcing frequency is a bin.  `spectral_values` computes them; it
loads Numba, which this module does not.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError, checked_words, choice
from nlds_vines.model.quantities import OF_SIGNALS
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.spectrum import SIGNALS, TAPERS

LINES = 24
"""Number of recorded lines of an nT orbit, at m / n of the forcing frequency, m = 1, 2, ..."""

USUAL = ("x1", "u", "x")
"""The default signals, of which a scene has some."""


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
