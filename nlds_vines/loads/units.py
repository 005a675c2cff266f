"""The units in which reports and pictures show numbers: g, per cent, kN.

Archives, tables and Python have SI units.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nlds_vines.model.loads.courses import G
from nlds_vines.model.quantities import DRIFT_RATIOS, of_load

LARGE = 1e4  # N or N s from which on they are shown in kN or kN s


class Shown(NamedTuple):
    """A unit and the factor that brings a number in SI units to it."""

    factor: float
    unit: str


def shown_in(name: str, values: object, shaken: bool) -> Shown:
    """Return the unit of a quantity of a response for all its `values`.

    Accelerations are in g if the ground is `shaken`; drift ratios are in per cent; forces and
    impulses are in kN and kN s if one of the values is large.
    """
    unit = of_load(name).unit
    if name.rpartition(".")[2] in DRIFT_RATIOS:
        return Shown(100.0, "%")
    if unit == "m/s^2" and shaken:
        return Shown(1.0 / G, "g")
    if unit in ("N", "N s"):
        numbers = np.abs(np.asarray(values, dtype=float))
        finite = numbers[np.isfinite(numbers)]
        if finite.size and finite.max() >= LARGE:
            return Shown(1e-3, f"k{unit}")
    return Shown(1.0, unit)
