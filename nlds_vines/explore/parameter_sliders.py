"""A slider for every parameter of a system: its range, and whether it is logarithmic."""

from __future__ import annotations

from math import isfinite
from typing import Any

from nlds_vines.bifurcation.request import Scan
from nlds_vines.model.parameter import Parameter
from nlds_vines.model.parameters import CONTACT, described

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
