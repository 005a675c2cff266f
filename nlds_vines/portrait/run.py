"""Orbits for a portrait: a recipe's runs, cut into the views of its columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nlds_vines.kernels.recurrence import REPEATS, TOLERANCE, period_of
from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.simulation import Orbit, simulate
from nlds_vines.orbits.spectrum import Spectrum, spectrum_of
from nlds_vines.portrait.request import Column, Recipe, Window, span
from nlds_vines.portrait.result import View


def views_of(recipe: Recipe) -> list[View]:
    """Return the views of a recipe's columns, in their order, from one run for each system.

    Samples end steps of the integration, so a chaotic orbit, and the length of a chaotic transient,
    depend on `samples` as on any round-off.  All windows of a system therefore come from one run.

    Raises `IntegrationError` where an orbit ends early.
    """
    found: dict[int, View] = {}
    for run in recipe.runs():
        orbit = _orbit(recipe, run)
        found |= {id(column): _view(recipe, run, orbit, column) for column in run}
    return [found[id(column)] for column in recipe.columns]


def _orbit(recipe: Recipe, run: Sequence[Column]) -> Orbit:
    """Return the orbit from the first to the last period in the columns of a run."""
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
    """Return the window of an orbit that a column shows, with its period and its spectrum."""
    assert orbit.trajectory is not None
    assert orbit.time is not None
    begin, end = (count - span(run).begin for count in column.window)
    part = slice(begin * recipe.samples, end * recipe.samples)
    states = orbit.trajectory[part]
    section = np.ascontiguousarray(states[recipe.samples - 1 :: recipe.samples])
    n = int(period_of(section, TOLERANCE))
    comb = recipe.comb or max(n, 1)
    return View(
        column=column,
        time=orbit.time[part],
        states=states,
        samples=recipe.samples,
        touches=_touches(orbit, column.window),
        period=n,
        tolerance=TOLERANCE,
        longest=len(section) // REPEATS,
        comb=comb,
        spectrum=_spectrum(recipe, column, states, comb),
        violation=orbit.violation,
    )


def _touches(orbit: Orbit, window: Window) -> np.ndarray:
    """Return the times [s] at which walls were touched in a window of an orbit."""
    if orbit.impacts is None:
        return np.empty(0)
    touches = orbit.impacts["touch"]
    first, last = (count * orbit.system.period for count in window)
    return touches[(touches > first) & (touches <= last)]


def _spectrum(recipe: Recipe, column: Column, states: np.ndarray, comb: int) -> Spectrum:
    """Return the spectrum over the last periods of a window, as many as the comb divides."""
    usable = len(states) - len(states) % (comb * recipe.samples)
    signal, system = SIGNALS[recipe.signal], column.system
    return spectrum_of(
        signal.of(system, states[len(states) - usable :]),
        recipe.samples,
        system.parameters["omega"],
        window=recipe.taper,
        quantity=recipe.signal,
        unit=signal.unit,
    )
