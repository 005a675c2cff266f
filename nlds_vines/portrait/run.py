"""The orbits of a portrait, computed and cut into the views of its columns, and their archive."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.engine.classification import lyapunov_spectrum
from nlds_vines.engine.one_orbit import Orbit
from nlds_vines.engine.records import impact_type
from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.spectrum import Spectrum, spectrum_of
from nlds_vines.errors import RequestError
from nlds_vines.kernels.orbit.repetition import REPEATS, TOLERANCE, period_of
from nlds_vines.portrait.request import EXPONENTS, Column, PortraitRequest, Window, described, span
from nlds_vines.portrait.result import View, contents
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore, Write


def run(request: PortraitRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute a portrait into the archive `output`; `IntegrationError` if an orbit ends early."""
    how, began = RunOptions() if how is None else how, time.monotonic()
    if not request.is_of_one_kind:
        raise RequestError(
            "columns of several kinds, laws or hosts stand in no request file, and in no archive; "
            "allowed: a page, by to=PICTURE"
        )
    store = BlockStore(output, request)

    def work() -> Write:
        views = views_of(request, quiet=how.quiet)
        seconds = round(time.monotonic() - began, 3)
        return store.writer(*contents(request, views), seconds=seconds)

    store.carry_out(how, work)


@stoppable
def views_of(request: PortraitRequest, *, quiet: bool = False) -> list[View]:
    """Return the views of a request's columns, in their order, from one run for each system.

    Samples end integration steps, so a chaotic orbit, and the length of a chaotic transient, depend
    on `samples` as on any round-off.  All windows of a system therefore come from one run.  The
    orbit of an archive's cell is that of the scan for any samples.

    Raises `IntegrationError` if an orbit ends early.
    """
    views: dict[int, View] = {}
    for run in request.runs():
        check()
        orbit = followed(request, run, quiet=quiet)
        for column in run:
            view = _view(request, orbit, column, request.samples)
            if EXPONENTS in request.panels and column.fills(EXPONENTS):
                spectrum = lyapunov_spectrum(column.system, view.section[-1], quiet=quiet)
                view = replace(view, exponents=spectrum)
            views[id(column)] = view
    return [views[id(column)] for column in request.columns]


def followed(request: PortraitRequest, run: Sequence[Column], *, quiet: bool = False) -> Orbit:
    begin, end = span(run)
    system: Any = run[0].system
    if request.cell is not None:
        return request.cell.traced(begin, end, request.samples, quiet=quiet)
    return simulate(
        system,
        end - begin,
        transient=begin,
        start=request.start,
        method=request.method,
        tolerance=request.tolerance,
        samples=request.samples,
        quiet=quiet,
        record=["trajectory", "impacts"] if system.scene.walls else ["trajectory"],
    )


def view_of_orbit(orbit: Orbit) -> View:
    """Return all recorded periods of an orbit; without a trajectory, its states at t = nT."""
    system, samples = orbit.system, 1
    states, time = orbit.trajectory, orbit.time
    if states is not None and time is not None and len(time):
        samples = round(system.period / (time[0] - orbit.transient * system.period))
    elif orbit.section is not None and len(orbit.section):
        states, count = orbit.section, len(orbit.section)
        time = system.period * (orbit.transient + 1 + np.arange(count))
    else:
        raise RequestError(
            "the orbit has nothing to draw: simulate it with section or trajectory in record"
        )
    window = Window(orbit.transient, orbit.transient + len(states) // samples)
    request = PortraitRequest(described(system), (Column(system, window),))
    orbit = replace(orbit, trajectory=states, time=time)
    return _view(request, orbit, request.columns[0], samples)


def _view(request: PortraitRequest, orbit: Orbit, column: Column, samples: int) -> View:
    """Return the window of an orbit, which has `samples` states a period, that a column shows."""
    assert orbit.trajectory is not None
    assert orbit.time is not None
    system = column.system
    begin, end = (count - orbit.transient for count in column.window)
    part = slice(begin * samples, end * samples)
    states = orbit.trajectory[part]
    section = np.ascontiguousarray(states[samples - 1 :: samples])
    n = int(period_of(section, TOLERANCE))
    impacts = np.zeros(0, impact_type(system.scene))
    if orbit.impacts is not None:
        first, last = (count * system.period for count in column.window)
        touches = orbit.impacts["touch"]
        impacts = orbit.impacts[(touches > first) & (touches <= last)]
    comb, none = request.comb or max(n, 1), np.empty(0)
    omega, spectra = system.parameters["omega"], []
    for name in request.signal:
        signal = system.signal(name)
        about = {"window": request.taper, "quantity": name, "unit": signal.unit}
        if samples > 1:  # of the last periods, as many as the comb divides
            usable = len(states) - len(states) % (comb * samples)
            values = signal.of(states[len(states) - usable :])
            spectra.append(spectrum_of(values, samples, omega, **about))
        else:
            spectra.append(Spectrum(none, none, none, omega, samples, 0, **about))
    return View(
        column,
        orbit.time[part],
        states,
        samples,
        contacts=impacts,
        period=n,
        tolerance=TOLERANCE,
        longest=len(section) // REPEATS,
        comb=comb,
        spectra=tuple(spectra),
        violation=orbit.violation,
    )
