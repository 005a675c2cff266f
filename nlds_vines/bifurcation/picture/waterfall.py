"""Spectra over a parameter: frequency upwards, amplitude as colour in decades."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from nlds_vines.bifurcation.picture.ordinates import Quantity
from nlds_vines.bifurcation.picture.scan_slice import Slice
from nlds_vines.plotting.bands import edges, logarithmic
from nlds_vines.plotting.notation import raised, signal_symbol
from nlds_vines.plotting.style import NO_VALUE, SHADES

WATERFALL = "spectrum"
"""The dataset that is drawn so."""

DECADES = 6.0
"""Below the largest amplitude that colours tell apart."""

_BAR = (1.012, 0.0, 0.014, 1.0)  # of the panel: the bar's left edge, foot, width, height


def draw_waterfall(panel: Axes, cut: Slice, quantity: Quantity) -> None:
    """Draw amplitudes of the first start over the parameter and the frequency."""
    found = cut.of(quantity)[:, 0, :]
    order = cut.view["frequency"]
    largest = float(np.nanmax(found[:, 1:], initial=0.0)) or 1.0
    floor = largest * 10.0**-DECADES
    panel.set_facecolor(NO_VALUE)
    mesh = panel.pcolormesh(
        edges(cut.values),
        edges(order[1:]),
        np.maximum(found[:, 1:], floor).T,
        norm=LogNorm(floor, largest),
        cmap=SHADES,
        rasterized=True,
    )
    bar = panel.figure.colorbar(mesh, cax=panel.inset_axes(_BAR), extend="min")
    bar.set_label(f"amplitude [{raised(quantity.units)}]")
    panel.set_ylabel(
        rf"spectrum of {signal_symbol(quantity.name.partition(':')[2])}, $\Omega/\omega$"
    )
    if logarithmic(cut.values):
        panel.set_xscale("log")
