"""The spectrum in a portrait: amplitudes in decibels over multiples of the forcing frequency."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np

from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.spectrum import Spectrum
from nlds_vines.plotting.notation import power_of_ten
from nlds_vines.portrait.page_layout import Place
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

DEPTH = 100.0
"""How far down a spectrum is drawn, in decibels below the highest line of its row."""

LEAST = 1.0e-4
"""The amplitude of a line, relative to the largest, above which the line is to be visible."""

SHORTEST, LONGEST = 4, 8
"""The least and the greatest upper end of the frequencies, in multiples of the force's."""

FINE = 240
"""Periods above which the bins of a spectrum are so close that its curve has to be thinner."""

ZERO = -400.0
"""The decibels at which an amplitude of exactly zero is drawn."""


def draw_spectrum(place: Place, request: PortraitRequest) -> None:
    """Draw the lines of a spectrum in decibels, and write its broadband share beside them."""
    found = place.view.spectrum
    with np.errstate(divide="ignore"):
        heights = np.maximum(found.decibels(), ZERO)
    width = 0.5 if found.periods <= FINE else 0.3
    place.axes.plot(found.order[1:], heights[1:], color="black", linewidth=width)
    omega = place.view.column.system.parameters["omega"]
    place.axes.set_xlabel(rf"frequency [multiples of $\omega$ = {omega:g} rad/s]")
    name, unit = found.quantity, SIGNALS[found.quantity].unit
    plain = name if len(name) == 1 else f"{name[0]}_{name[1:]}"
    symbol = {"force": "F", "u": "x_2-x_1"}.get(name, plain)
    place.axes.set_ylabel(f"$|{symbol}|$ [dB re 1 {unit}]")
    if place.view.share is not None:
        look: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7.5}
        place.axes.text(0.985, 0.95, _share(place.view), transform=place.axes.transAxes, **look)


def _share(view: View) -> str:
    """Return the broadband share in words; a tiny one by its order of magnitude."""
    share, n = view.share or 0.0, view.comb
    value = f"{share:.1%}" if share >= 5e-4 or share == 0 else f"${power_of_ten(f'{share:.0e}')}$"
    return f"power outside {n if n > 1 else ''}T lines: {value}"


def limit_spectra(row: Sequence[Place]) -> None:
    """Give the spectra of a row the same scales: `DEPTH` below the highest line, one end."""
    found = [place.view.spectrum for place in row]
    highest = max(float(s.decibels()[1:].max()) for s in found)
    if highest > ZERO:
        row[0].axes.set_ylim(highest - DEPTH, highest + 0.2 * DEPTH)
    for place in row:
        place.axes.set_xlim(0, max(_highest_order(s) for s in found))


def _highest_order(found: Spectrum) -> int:
    """Return the frequency, in whole multiples of the force's, up to which a spectrum is shown."""
    strong = found.order[1:][found.amplitude[1:] > LEAST * found.amplitude[1:].max()]
    return min(max(SHORTEST, ceil(strong[-1] + 0.2) if strong.size else 0), LONGEST)
