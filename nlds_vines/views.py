"""Orbits for a portrait: what each column of a page shows, computed from its recipe."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.kernels.recurrence import REPEATS, TOLERANCE, period_of
from nlds_vines.recipe import Column, Recipe, span
from nlds_vines.regimes import name_of
from nlds_vines.signals import SIGNALS, signals_of
from nlds_vines.simulation import Orbit, simulate
from nlds_vines.spectra import Spectrum, spectrum_of

MOST = 0.99
"""Of the power: in how few bins it lies, is told."""


@dataclass(frozen=True)
class View:
    """A window of an orbit.

    Attributes:
        column: which system, which forcing periods.
        time: of the states [s], from the start of the orbit.
        states: `samples` for each period, the last at its end, x1, v1, x2, v2 [m, m/s].
        samples: in each period.
        touches: when the damper touched a wall [s].
        period: n of nT by recurrence of the section, 0 where none was found.
        spectrum: of the recipe's signal, over as many last periods as nT divides.
    """

    column: Column
    time: np.ndarray
    states: np.ndarray
    samples: int
    touches: np.ndarray
    period: int
    spectrum: Spectrum

    @property
    def section(self) -> np.ndarray:
        """The states at the integer forcing periods."""
        return self.states[self.samples - 1 :: self.samples]

    @property
    def cycle(self) -> int:
        """How many periods hold the whole orbit: n of nT, or all of the window."""
        return self.period or len(self.section)

    @property
    def impacts(self) -> int:
        """Impacts k per nT, counted over the whole cycles of the window; in all if n is 0."""
        if not self.period:
            return len(self.touches)
        cycles = len(self.section) // self.period
        first = (self.column.window.end - cycles * self.period) * self.column.system.period
        return round(np.count_nonzero(self.touches > first) / cycles)

    @property
    def label(self) -> str:
        """The regime as recurrence shows it: `3T,3`, or `undetermined`."""
        return name_of(self.period, self.impacts)

    @property
    def share(self) -> float | None:
        """The broadband share of the spectrum, None where it has too few periods to tell."""
        n = max(self.period, 1)
        return self.spectrum.broadband_share(n) if n <= self.spectrum.most_lines() else None

    def lines(self) -> Iterator[str]:
        """Yield what was seen, in words."""
        begin, end = self.column.window
        name = f"{self.column.name}: " if self.column.name else ""
        yield f"{name}periods {begin} to {end} of {self.column.system.period:.6g} s each"
        yield f"  recurrence: {self._recurrence()}"
        if self.column.system.scene.walls:
            rate = len(self.touches) / len(self.section)
            yield f"  impacts per period: {rate:.4g} ({len(self.touches)} in the window)"
        for name in ("E1", "E2"):
            if name in signals_of(self.column.system.scene):
                highest = SIGNALS[name].of(self.column.system, self.states).max()
                yield f"  largest {name} of the samples: {highest:.6g} J"
        yield f"  spectrum of {self.spectrum.quantity}: {self._spectrum()}"

    def _recurrence(self) -> str:
        if self.period:
            times = f"{self.period} period{'s' if self.period > 1 else ''}"
            return f"{self.label}: the section repeats after {times} to {TOLERANCE:g}"
        longest = len(self.section) // REPEATS
        if longest == 0:
            return f"the window is too short to tell: it has less than {REPEATS} periods"
        return f"no period of up to {longest} found; that alone proves no chaos"

    def _spectrum(self) -> str:
        found, n = self.spectrum, max(self.period, 1)
        text = f"{found.periods} periods, {found.window} window, resolution {found.resolution:.4g}"
        outside = "the harmonics of the force" if n == 1 else f"the lines of {n}T"
        share = "(too few periods to tell)" if self.share is None else f"{self.share:.2g}"
        few = f"{MOST:.0%} of its power in {found.bins_holding(MOST)} bins"
        return f"{text} of the forcing frequency; {share} of its power outside {outside}, {few}"


def views_of(recipe: Recipe) -> list[View]:
    """Return the views of a recipe's columns, in their order; one run for each system.

    Sampling an orbit cuts its steps: the states of a chaotic orbit, and with them the length of a
    chaotic transient, change with `samples` as with any round-off.  So all windows of a system
    are taken from one run.

    Raises `IntegrationError` where an orbit ends early.
    """
    found: dict[int, View] = {}
    for run in recipe.runs():
        orbit = _orbit(recipe, run)
        found |= {id(column): _view(recipe, run, orbit, column) for column in run}
    return [found[id(column)] for column in recipe.columns]


def _orbit(recipe: Recipe, run: Sequence[Column]) -> Orbit:
    """Return the orbit from the first to the last period that the columns of a run show."""
    system, (begin, end) = run[0].system, span(run)
    return simulate(
        system,
        end - begin,
        transient=begin,
        start=recipe.start,
        method=recipe.method,
        samples=recipe.samples,
        record=["trajectory", "impacts"] if system.scene.walls else ["trajectory"],
    )


def _view(recipe: Recipe, run: Sequence[Column], orbit: Orbit, column: Column) -> View:
    """Return a window of an orbit."""
    assert orbit.trajectory is not None
    assert orbit.time is not None
    begin, end = (count - span(run).begin for count in column.window)
    part = slice(begin * recipe.samples, end * recipe.samples)
    states, time = orbit.trajectory[part], orbit.time[part]
    section = np.ascontiguousarray(states[recipe.samples - 1 :: recipe.samples])
    n = int(period_of(section, TOLERANCE))
    touches = np.empty(0) if orbit.impacts is None else orbit.impacts["touch"]
    T = column.system.period
    first, last = (count * T for count in column.window)
    inside = (touches > first) & (touches <= last)
    usable = len(section) - len(section) % max(n, 1)
    signal = SIGNALS[recipe.signal]
    values = signal.of(column.system, states[-usable * recipe.samples :])
    return View(
        column=column,
        time=time,
        states=states,
        samples=recipe.samples,
        touches=touches[inside],
        period=n,
        spectrum=spectrum_of(
            values,
            recipe.samples,
            column.system.parameters["omega"],
            window=recipe.taper,
            quantity=recipe.signal,
            unit=signal.unit,
        ),
    )
