"""Time histories of an orbit, settled or from its start, with as many points as a page can show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from nlds_vines.model.system import System
from nlds_vines.orbits.signals import contact_forces, harmonic_force, relative_displacement
from nlds_vines.portrait.request import Column, PortraitRequest, Window
from nlds_vines.portrait.window_view import View

Arrays = dict[str, np.ndarray]

SHOW = 12
"""Forcing periods of the history of a settled orbit, and of a short one from the start."""

LONG = 100
"""Forcing periods of a longer one from the start."""

MOST_PERIODS = 2000
"""The most periods from the start: they take 0.05 s."""

MOST_POINTS = 1000
"""Points of a curve over time: more than a wide panel has pixels."""

SETTLED = "settled"

HISTORIES: Mapping[str, str] = {
    SETTLED: f"{SHOW} periods, settled",
    "short": f"the first {SHOW} periods",
    "long": f"the first {LONG} periods",
    "whole": "all periods from the start",
}
"""The histories that a page can show, by name, in words."""


def history_of(request: PortraitRequest, view: View, name: str = SETTLED) -> Arrays:
    """Return a history of the orbit of a request, one of `HISTORIES`.

    Arguments: the `request` of a portrait with one column, and its `view`.

    Returns t [forcing periods], x1, v1, x2, u = x2 - x1 [m, m/s], force of the contact and harmonic
    force [N], all of one length.  Samples end steps of the integration, so a chaotic orbit from the
    start is another one than the settled periods show, after its first periods.
    """
    system = view.column.system
    if name == SETTLED:
        count = SHOW * view.samples
        return _drawn(system, view.states[:count], view.time[:count])
    from nlds_vines.portrait.run import followed

    end = {"short": SHOW, "long": LONG}.get(name, view.column.window.begin + SHOW)
    columns = (Column(system, Window(0, min(end, MOST_PERIODS))),)
    orbit = followed(replace(request, columns=columns), columns, quiet=True)
    assert orbit.trajectory is not None
    assert orbit.time is not None
    return _drawn(system, orbit.trajectory, orbit.time)


def _drawn(system: System, states: np.ndarray, time: np.ndarray) -> Arrays:
    """Return displacements and forces, as many of them as can be seen."""
    force = sum(contact_forces(system, states).values(), np.zeros(len(states)))
    found = {"t": time / system.period, "x1": states[:, 0], "v1": states[:, 1]}
    if system.scene.damper:
        found |= {"x2": states[:, 2], "u": relative_displacement(system, states)}
    found |= {"force": force, "harmonic": harmonic_force(system, time)}
    if len(states) > 4 * MOST_POINTS:
        return _extremes(found)
    kept = _kept(len(states), force != 0)
    return {name: values[kept] for name, values in found.items()}


def _kept(count: int, always: np.ndarray) -> np.ndarray:
    """Return which of `count` samples are drawn: every n-th, and all of a contact."""
    kept = np.zeros(count, bool)
    kept[:: max(1, -(-count // MOST_POINTS))] = True
    touching = always.copy()
    touching[1:] |= always[:-1]
    touching[:-1] |= always[1:]
    return kept | touching


def _extremes(found: Arrays) -> Arrays:
    """Return the smallest and the largest value in each of `MOST_POINTS` equal pieces of time.

    A line through them covers what the curve covers, however dense it is.
    """
    count = len(found["t"])
    size = -(-count // MOST_POINTS)
    firsts = np.arange(0, count, size)
    times = found["t"][np.stack([firsts, np.minimum(firsts + size // 2, count - 1)], axis=-1)]
    return {"t": times.ravel()} | {
        name: np.stack(
            [np.minimum.reduceat(values, firsts), np.maximum.reduceat(values, firsts)], axis=-1
        ).ravel()
        for name, values in found.items()
        if name != "t"
    }
