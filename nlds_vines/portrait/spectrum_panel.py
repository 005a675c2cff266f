"""The spectrum in a portrait: amplitudes in decibels over multiples of the forcing frequency."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np

from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.portrait.page_layout import Place
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.result import View

LINE = "#000000"

DEPTH = 100.0
"""The lowest line of a spectrum that is drawn, in decibels below the highest of the page."""

AUDIBLE = 1.0e-4
"""The amplitude, relative to the largest, above which a line should be on the page."""

SHORTEST, LONGEST = 4, 8
"""Up to which multiple of the forcing frequency spectra are shown: at least, at most."""

FINE = 240
"""Periods above which the bins of a spectrum stand so close that its line has to be thinner."""

SILENT = 400.0
"""Decibels below one unit that stand for an amplitude of exactly zero."""


def draw_spectrum(place: Place, request: PortraitRequest) -> None:
    """Draw the lines of a spectrum in decibels, and write its broadband share beside them."""
    found = place.view.spectrum
    with np.errstate(divide="ignore"):
        heights = np.maximum(found.decibels(), -SILENT)
    width = 0.5 if found.periods <= FINE else 0.3
    place.axes.plot(found.order[1:], heights[1:], color=LINE, linewidth=width)
    omega = place.view.column.system.parameters["omega"]
    place.axes.set_xlabel(rf"frequency [multiples of $\omega$ = {omega:g} rad/s]")
    name, unit = found.quantity, SIGNALS[found.quantity].unit
    symbol = {"force": "F", "u": "x_2-x_1"}.get(name, f"{name[0]}_{name[1:]}")
    place.axes.set_ylabel(f"$|{symbol}|$ [dB re 1 {unit}]")
    if place.view.share is not None:
        look: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7.5}
        place.axes.text(0.985, 0.95, _share(place.view), transform=place.axes.transAxes, **look)


def _share(view: View) -> str:
    """Return the broadband share in words; one of round-off by its order of magnitude."""
    share, n = view.share or 0.0, view.comb
    value = f"{share:.1%}" if share >= 5e-4 or share == 0 else f"{share:.0e}"
    return f"power outside {n if n > 1 else ''}T lines: {value}"


def limit_spectra(row: Sequence[Place]) -> None:
    """Cut the spectra of a row off at one depth below their highest line, at one frequency."""
    found = [place.view.spectrum for place in row]
    highest = max(float(s.decibels()[1:].max()) for s in found)
    if highest > -SILENT:
        row[0].axes.set_ylim(highest - DEPTH, highest + 0.2 * DEPTH)
    for place in row:
        place.axes.set_xlim(0, max(_audible(s) for s in found))


def _audible(found: Spectrum) -> int:
    """Return the frequency, in whole multiples of the force's, up to which a spectrum is shown."""
    loud = found.order[1:][found.amplitude[1:] > AUDIBLE * found.amplitude[1:].max()]
    return min(max(SHORTEST, ceil(loud[-1] + 0.2) if loud.size else 0), LONGEST)
