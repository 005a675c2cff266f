"""The numbers of every cell as a browser takes them: columns of plain numbers, row after row.

A row is one start of one cell; the starts of a cell stand side by side, and the cells of the last
axis.  Codes are integers; what does not apply is NaN.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nlds_vines.explore.shows import columns_of_shows, label_places
from nlds_vines.explore.stored import Stored
from nlds_vines.model.parameters import described
from nlds_vines.orbits.status_words import NOT_COMPUTED, OK

NUMBERS = (
    "E1max", "E2max", "reduction", "E1peak", "E2peak", "period", "impacts", "impact_rate",
    "settling", "lyapunov", "lyapunov_width", "residual", "watched", "clearance",
    "orbit_clearance", "softest_impact", "averaging", "transient_lyapunov", "violation_depth",
    "violations", "error", "error_at_end", "E1max_error",
)  # fmt: skip
"""The datasets of one number for each start, the most telling first."""

_NEVER = -1  # of `settling`, and of counts that are not known


def columns(found: Stored) -> dict[str, np.ndarray]:
    """Return the columns by name: codes as they are, numbers as float32.

    `label` holds codes of `shows.label_words`, `status` those of the archive; `multiplier` is the
    modulus of the largest Floquet multiplier; `computed`, codes of `shows.COMPUTED`, is there where
    nothing else is.  Columns of `shows` have a row for each cell only.
    """
    columns: dict[str, np.ndarray] = {"status": found.lanes("status").ravel().astype(np.int8)}
    if "label" in found:
        _, columns["label"] = label_places(found)
    for name in NUMBERS:
        if name in found:
            columns[name] = _number(name, found.lanes(name))
    if len(columns) == 1:
        status = columns["status"]
        places = [status == NOT_COMPUTED, status == OK]
        columns["computed"] = np.select(places, [0, 1], 2).astype(np.uint8)
    if "multipliers" in found:
        largest = found.lanes("multipliers")[:, :, 0]
        columns["multiplier"] = np.hypot(largest[..., 0], largest[..., 1]).ravel().astype("f4")
    for name, values in columns_of_shows(found).items():
        coded = name in ("most", "coexisting")
        columns[name] = values.astype(np.uint16 if coded else np.float32)
    return columns


def section_points(found: Stored, count: int) -> np.ndarray:
    """Return the last `count` states of each section, (cells starts, count, components).

    Where no section was recorded, the point of the periodic orbit; without either, an empty array.
    """
    if "section" in found:
        states = found.lanes("section")
        return states[:, :, -count:].reshape(-1, min(count, states.shape[2]), states.shape[-1])
    if "orbit_point" in found:
        states = found.lanes("orbit_point")
        return states.reshape(-1, 1, states.shape[-1])
    return np.empty((0, 0, 0))


def axes_of(found: Stored) -> list[dict[str, Any]]:
    """Return the axes as a browser takes them: name, symbol, unit, meaning, values."""
    entries = ((axis, described(axis.name)) for axis in found.scan.axes)
    return [
        {
            "name": axis.name,
            "symbol": entry.symbol,
            "unit": "" if entry.unit == "1" else entry.unit,
            "meaning": entry.meaning,
            "values": axis.values.tolist(),
        }
        for axis, entry in entries
    ]


def _number(name: str, values: np.ndarray) -> np.ndarray:
    """Return numbers as float32, NaN in place of those that mean `never` or `none`."""
    numbers = values.ravel().astype(np.float64)
    if name in ("settling", "impacts", "violations"):
        numbers[numbers == _NEVER] = np.nan
    if name == "period":
        numbers[numbers == 0] = np.nan
    with np.errstate(over="ignore"):
        return numbers.astype(np.float32)
