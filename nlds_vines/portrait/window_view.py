"""A window of an orbit, as one column of a portrait shows it: states, impacts, period, spectrum."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.archives.representation import Outlined
from nlds_vines.model.labels import name_of
from nlds_vines.orbits.records import Violation
from nlds_vines.orbits.signals import SIGNALS, signals_of
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.portrait.request import Column

if TYPE_CHECKING:
    from nlds_vines.orbits.classification import LyapunovSpectrum

POWER_SHARE = 0.99
"""The share of the power of a spectrum whose bins the report counts, the strongest first."""


@dataclass(frozen=True, repr=False)
class View(Outlined):
    """A window of an orbit.

    Attributes:
        column: the system and the window, a range of forcing periods.
        time: times [s] of the states from the start of the orbit, shape (n,).
        states: x1, v1, x2, v2 [m, m/s], shape (n, 4), or (n, 2) without a damper; `samples` of
            each period, the last at its end.
        samples: states in each period.
        contacts: the impacts that begin in the window, rows of dtype `orbits.simulation.IMPACT`;
            empty for a scene without walls.
        period: n of nT, by recurrence of the section to a `tolerance`; 0 if no period of up to
            `longest` recurs.
        comb: n of the nT whose lines do not count as broadband.
        spectrum: of the request's signal, over as many last periods as the comb divides.
        violation: of the scene's limit, in the whole run; None without a limit.
        exponents: the Lyapunov spectrum from the last state on; None if no panel shows it.
    """

    column: Column
    time: np.ndarray
    states: np.ndarray
    samples: int
    contacts: np.ndarray
    period: int
    tolerance: float
    longest: int
    comb: int
    spectrum: Spectrum
    violation: Violation | None = None
    exponents: LyapunovSpectrum | None = None

    @property
    def section(self) -> np.ndarray:
        """The states at the whole forcing periods, shape (periods, 4)."""
        return self.section_at(0)

    def section_at(self, sample: int) -> np.ndarray:
        """Return the states (periods, 4) at a sample of each period, 0 being its end, t = nT."""
        return self.states[(sample - 1) % self.samples :: self.samples]

    @property
    def impact_section(self) -> Mapping[str, np.ndarray]:
        """The section at impact by wall, (touches, 2): phase omega t mod 2 pi [rad], speed [m/s].

        Of a periodic orbit it has one cycle.
        """
        period = self.column.system.period
        last = self.contacts[self.touches > (self.column.window.end - self.cycle) * period]
        points = np.column_stack([2.0 * np.pi * (last["touch"] / period % 1.0), last["speed"]])
        return {
            name: points[last["wall"] == name] for name in self.column.system.scene.bodies_struck
        }

    @property
    def touches(self) -> np.ndarray:
        """The times [s] at which the damper touched a wall."""
        return self.contacts["touch"]

    @property
    def cycle(self) -> int:
        """The number of periods of one cycle: n of nT, or all of the window."""
        return self.period or len(self.section)

    @property
    def impacts(self) -> int:
        """Impacts k per nT, averaged over the whole cycles of the window; all impacts if n is 0."""
        if not self.period:
            return len(self.touches)
        cycles = len(self.section) // self.period
        first = (self.column.window.end - cycles * self.period) * self.column.system.period
        return round(np.count_nonzero(self.touches > first) / cycles)

    @property
    def label(self) -> str:
        """The regime by recurrence alone: `3T,3`, or `undetermined`."""
        return name_of(self.period, self.impacts) if self.period else "undetermined"

    @property
    def share(self) -> float | None:
        """The broadband share of the spectrum, from 0 to 1; None if its periods are too few."""
        if self.comb > self.spectrum.most_lines():
            return None
        return self.spectrum.broadband_share(self.comb)

    def lines(self) -> Iterator[str]:
        """Yield the report of the window, a line at a time."""
        begin, end = self.column.window
        name = f"{self.column.name}: " if self.column.name else ""
        yield f"{name}periods {begin} to {end} of {self.column.system.period:.6g} s each"
        if self.period:
            times = f"{self.period} period{'s' if self.period > 1 else ''}"
            words = f"{self.label}: the section repeats after {times} to {self.tolerance:g}"
        elif self.longest == 0:
            words = "the window is too short to tell"
        else:
            words = f"no period of up to {self.longest} found; that alone proves no chaos"
        yield f"  recurrence: {words}"
        if self.column.system.scene.walls:
            rate = len(self.touches) / len(self.section)
            yield f"  impacts per period: {rate:.4g} ({len(self.touches)} in the window)"
        if (passed := self.violation) is not None:
            times = f"{passed.number} time{'s' if passed.number > 1 else ''}"
            words = f"violated {times}, by up to {passed.depth:.4g} m, first at {passed.time:.6g} s"
            yield f"  limit of the scene, in the whole run: {words if passed.number else 'kept'}"
        for name in ("E1", "E2"):
            if name in signals_of(self.column.system.scene):
                highest = SIGNALS[name].of(self.column.system, self.states).max()
                yield f"  largest {name} of the samples: {highest:.6g} J"
        spectrum, n = self.spectrum, self.comb
        outside = "the harmonics of the force" if n == 1 else f"the lines of {n}T"
        share = "(too few periods to tell)" if self.share is None else f"{self.share:.2g}"
        yield (
            f"  spectrum of {spectrum.quantity}: {spectrum.periods} periods, {spectrum.window} "
            f"window, resolution {spectrum.resolution:.4g} of the forcing frequency; {share} of "
            f"its power outside {outside}, {POWER_SHARE:.0%} of its power in "
            f"{spectrum.bins_holding(POWER_SHARE)} bins"
        )
        if self.exponents is not None:
            words = "; ".join(f"{name} {value}" for name, value in self.exponents.outline())
            yield f"  Lyapunov {words}"
