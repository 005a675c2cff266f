"""Orbits of portraits followed again, and what claims need to know of them."""

from __future__ import annotations

import numpy as np

from nlds_vines.engine.one_orbit import IntegrationError
from nlds_vines.engine.spectrum import Spectrum, spectrum_of
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.result import View
from nlds_vines.portrait.run import views_of
from paper.claims.measured import POWER, Breadth, Missing, Motion
from paper.request import FigureRequest

BROKEN_DOWN = ("x2", "force")
"""The signals whose spectra are measured."""


def motions_of(request: FigureRequest) -> list[Motion]:
    """Return the motions in the columns of a portrait; its orbits are followed for that.

    Raises `Missing` where an orbit ends early.
    """
    try:
        return [motion_of(view) for view in views_of(load_portrait(request.path))]
    except IntegrationError as error:
        raise Missing(f"{request.name}: {error}") from error


def motion_of(view: View) -> Motion:
    """Return what claims need to know of a window of an orbit with a damper and a wall."""
    system = view.column.system
    assert system.rest is not None
    last = view.contacts[-view.impacts :] if view.impacts else view.contacts[:0]
    way = system.signal("u").of(view.states) - system.rest
    return Motion(
        system=system,
        label=view.label if view.period else "",
        forces=last["force"],
        durations=last["release"] - last["touch"],
        section=view.section,
        least=float(way.min()),
        greatest=float(way.max()),
        breadths={signal: _breadth(view, signal) for signal in BROKEN_DOWN},
    )


def _breadth(view: View, signal: str) -> Breadth:
    """Return how broad the spectrum of a signal is over the window, and over half of it."""
    whole = len(view.section) - len(view.section) % (2 * view.comb)
    full, half = (_spectrum(view, signal, count) for count in (whole, whole // 2))
    share = full.broadband_share(view.comb) if view.comb <= full.most_lines() else np.nan
    return Breadth(view.comb, share, full.bins_holding(POWER), half.bins_holding(POWER))


def _spectrum(view: View, signal: str, periods: int) -> Spectrum:
    """Return the spectrum of a signal over the last periods of a view, tapered by Hann."""
    system = view.column.system
    values = system.signal(signal).of(view.states[-periods * view.samples :])
    return spectrum_of(values, view.samples, system.parameters["omega"], window="hann")
