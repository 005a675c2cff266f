"""The document of a page: figures, sources, sliders in their frame, empty until told numbers."""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS

from nlds_vines.bifurcation.request import Scan
from nlds_vines.explore.histories import HISTORIES
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.map_figure import map_figures
from nlds_vines.explore.orbit_figures import WIDE, orbit_figures, orbit_sources, walls_of
from nlds_vines.explore.page_elements import frame, page_file
from nlds_vines.model.parameter import Parameter
from nlds_vines.model.parameters import CONTACT, described

_DATA = ("asked", "told", "values", "lanes", "cells", "points", "touched")


class Filled(NamedTuple):
    """What a page changes in its document: sources by name, the lines of what is struck."""

    data: dict[str, ColumnDataSource]
    walls: list[list[Any]]


def fill(document: Document, found: Stored) -> Filled:
    """Put the figures and sources of a map into a document.

    The page's script asks through the source `asked`, hears through `told`, and takes numbers from
    the others.
    """
    system = found.scan.system
    figures = orbit_figures(system, orbit_sources(system))
    maps = map_figures(len(found.scan.axes), len(found.starts), "label" in found, True)
    data = {name: ColumnDataSource(name=name) for name in _DATA}
    for name in ("asked", "told"):
        data[name].data = {"message": []}
    with document.models.freeze():  # each root alone would make all models be counted again
        for root in (*maps, *figures, *data.values()):
            document.add_root(root)
    document.title = found.scan.title
    document.template = frame("explore.html")
    script = page_file("page.js") + page_file("explore.js")
    document.template_variables.update(
        css=page_file("page.css"), script=script, figures=WIDE, data=_DATA, histories=HISTORIES
    )
    sliders = CustomJS(args={"sliders": sliders_of(found.scan)}, code="EXPLORE.start(sliders)")
    document.js_on_event("document_ready", sliders)
    return Filled(data, walls_of(figures))


# ---- sliders -------------------------------------------------------------------------------------


LOGARITHMIC = ("K", "E1", "E2", "A", "B", "kc", "k2", "c1", "c2", "cc", "hunt_crossley")
"""The parameters, and those of a second wall, that are known to an order of magnitude or spread
over several."""

_DECADES = 100.0  # factor to either side of a logarithmic slider
_WIDE = 2.5  # times the value, where a plain slider ends


def sliders_of(scan: Scan) -> list[dict[str, Any]]:
    """Return the sliders of a scan: first those of its axes, then all other parameters.

    Each has name, symbol, unit, meaning, low, high, value [SI units], and whether it is an axis and
    logarithmic.
    """
    varied = {axis.name: axis.values for axis in scan.axes}
    known = {name: float(values[values.size // 2]) for name, values in varied.items()}
    known |= scan.system.parameters
    if "K" in varied:  # in place of the constants that it would follow from
        known = {name: value for name, value in known.items() if name not in CONTACT}
    entries = []
    for name, value in known.items():
        entry = described(name)
        if name in varied and varied[name].size > 1:
            low, high, logarithmic = float(varied[name][0]), float(varied[name][-1]), False
            value = min(max(value, low), high)
        else:
            low, high, logarithmic = _range(entry, value)
        entries.append(
            {
                "name": name,
                "symbol": entry.symbol,
                "unit": "" if entry.unit == "1" else entry.unit,
                "meaning": entry.meaning,
                "low": low,
                "high": high,
                "value": value,
                "axis": name in varied,
                "logarithmic": logarithmic,
            }
        )
    return sorted(entries, key=lambda entry: not entry["axis"])


def _range(entry: Parameter, value: float) -> tuple[float, float, bool]:
    """Return where the slider of a parameter begins and ends, and whether it is logarithmic."""
    if entry.name.removesuffix("_2") in LOGARITHMIC and value > 0:
        return value / _DECADES, value * _DECADES, True
    if isfinite(entry.low) and isfinite(entry.high):
        return entry.low, entry.high, False
    size = abs(value) or 1.0
    if isfinite(entry.low):
        low = entry.low if not entry.above else entry.low + size / 100
        return low, _WIDE * size, False
    return -_WIDE * size, _WIDE * size, False
