"""What a scan records of spectra: amplitudes, the lines of periodic orbits, the broadband share.

All of them rest on states at equal steps over the sampled periods, so that a whole period is a
whole number of samples and every multiple of 1 / periods of the forcing frequency is a bin. Here
they are described; `spectral_values` has their values.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError, checked_words, choice
from nlds_vines.model.quantities import OF_SIGNALS
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.spectrum import TAPERS

LINES = 24
"""Lines of a periodic orbit that are recorded: m / n of the forcing frequency, m from 1 on."""

USUAL = ("x1", "u", "x")
"""Signals that are recorded unless others are asked for, as far as a scene has them."""


def recordable(scene: Scene) -> tuple[str, ...]:
    """Return the signals of which scans record spectra: the state, and u = x2 - x1."""
    return (*scene.components, *(["u"] if scene.damper else []))


def checked_signals(value: object) -> tuple[str, ...]:
    """Return different names of signals, () for the usual; `RequestError` for anything else."""
    if isinstance(value, list | tuple) and not value:
        return ()
    return checked_words("signals", value, SIGNALS, "signal")


@dataclass(frozen=True)
class SpectralRecords:
    """What is recorded of the spectra of a scan's orbits.

    Attributes:
        want: of `records.SPECTRAL`.
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
        """How many bins are kept, that of the mean included."""
        return int(self.highest * self.periods) + 1

    @property
    def order(self) -> np.ndarray:
        """The frequency of each bin in multiples of that of the force."""
        return np.arange(self.bins) / self.periods

    # ---- the datasets ----------------------------------------------------------------------------

    def lengths(self) -> dict[str, int]:
        """Return the lengths of the dimensions that there are."""
        sizes = {"signal": len(self.signals)}
        sizes |= {"frequency": self.bins} if "spectrum" in self.want else {}
        return sizes | ({"line": LINES} if "lines" in self.want else {})

    def scales(self) -> Iterator[Scale]:
        """Yield the dimensions that there are, with their values."""
        yield Scale("signal", np.array(self.signals), "1", "what the spectrum is of")
        if "spectrum" in self.want:
            text = f"frequency over that of the force; {self.window} window"
            yield Scale("frequency", self.order, "1", text)
        if "lines" in self.want:
            text = "number m of the line at m / n of the frequency of the force, n of `line_period`"
            yield Scale.counted("line", LINES, text, 1)

    def in_units(self, dataset: Dataset) -> Dataset:
        """Return a dataset with the units of the signals, where its own are these."""
        units = ", ".join(dict.fromkeys(SIGNALS[name].unit for name in self.signals))
        return replace(dataset, units=units) if dataset.units == OF_SIGNALS else dataset
