"""A map as a browser takes it: columns of plain numbers, row after row; titles, words, colors.

A row is one start of one cell; the starts of a cell stand side by side, and the cells of the last
axis.  Codes are integers; what does not apply is NaN.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.palettes import Viridis256

from nlds_vines.explore.map_choices import (
    classes_of,
    columns_of_shows,
    label_places,
    label_words,
    shows_of,
)
from nlds_vines.explore.map_data import NUMBERS, TOUCHES, Stored
from nlds_vines.model.parameters import described
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.status_words import NOT_COMPUTED, OK, STATUS
from nlds_vines.plotting.palette import HATCHED
from nlds_vines.plotting.style import NAVY, NO_VALUE, start_colors


def columns(found: Stored) -> dict[str, np.ndarray]:
    """Return the columns by name: codes as they are, numbers as float32.

    `capture` counts the codes of the archive from 1, 0 where there is none; `label` holds codes of
    `map_choices.label_words`, `status` those of the archive; `multiplier` is the modulus of the
    largest Floquet multiplier; `computed` holds codes of `map_choices.COMPUTED`.  Columns of
    `map_choices` have a row for each cell only.
    """
    columns: dict[str, np.ndarray] = {"status": found.lanes("status").ravel().astype(np.int8)}
    if "label" in found:
        _, columns["label"] = label_places(found)
    if "capture" in found:
        columns["capture"] = (found.lanes("capture").ravel() + 1).astype(np.uint8)
    for name in NUMBERS:
        if name in found:
            columns[name] = _number(name, found.lanes(name))
    places = [columns["status"] == NOT_COMPUTED, columns["status"] == OK]
    columns["computed"] = np.select(places, [0, 1], 2).astype(np.uint8)
    if "multipliers" in found:
        largest = found.lanes("multipliers")[:, :, 0]
        columns["multiplier"] = np.hypot(largest[..., 0], largest[..., 1]).ravel().astype("f4")
    for name, values in columns_of_shows(found).items():
        coded = name in ("most", "coexisting")
        columns[name] = values.astype(np.uint16 if coded else np.float32)
    return columns


def told(found: Stored) -> list[list[str]]:
    """Return what is told of a cell, (column, words, unit, column of its half width) each."""
    body = found.scan.system.scene.body
    widths = {BY_NAME[name].width for name in NUMBERS}
    rows = [
        [name, one.title(body), one.unit, one.width]
        for name, one in ((name, BY_NAME[name]) for name in NUMBERS if name in found)
        if name not in widths
    ]
    if "multipliers" in found:
        rows.append(["multiplier", "largest multiplier |μ|", "1", ""])
    return rows


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
    numbers[numbers == BY_NAME[name].fill] = np.nan
    with np.errstate(over="ignore"):
        return numbers.astype(np.float32)


# ---- what else the page's script must know -------------------------------------------------------


MOST_POINTS = 2_000_000
"""The most points of a diagram: of a longer section, the last periods."""


def meta_of(found: Stored, points: int) -> dict[str, Any]:
    """Return titles, axes, starts, words and colors of a map, `points` of each section shown."""
    regimes = "label" in found
    sides = " × ".join(str(n) for n in found.scan.shape)
    several = f", {len(found.starts)} starts" if len(found.starts) > 1 else ""
    return {
        "title": found.scan.title,
        "head": f"{'Map' if len(found.scan.axes) == 2 else 'Diagram'}, {sides} cells{several}",
        "axes": axes_of(found),
        "starts": list(found.starts),
        "start_colors": start_colors(found.starts),
        "ink": NAVY,
        "labels": label_words(found) if regimes else [],
        "classes": [list(pair) for pair in classes_of(found)] if regimes else [],
        "shows": [show.plain() for show in shows_of(found)],
        "told": told(found),
        "status": {str(code): status.name for code, status in STATUS.items()},
        "ramp": list(Viridis256),
        "novalue": NO_VALUE,
        "hatched": HATCHED,
        "points": points,
    }


def diagram_points(found: Stored) -> dict[str, np.ndarray]:
    """Return the displacements of all sections of a diagram, by component; none for a map."""
    if len(found.scan.axes) == 2 or "section" not in found:
        return {}
    lanes = found.scan.lanes
    states = section_points(found, max(1, MOST_POINTS // lanes))
    names = found.scan.system.scene.components
    return {
        name: np.ascontiguousarray(states[..., names.index(name)], np.float32).ravel()
        for name in ("x2", "x1", "x")
        if name in names
    }


def touch_points(found: Stored) -> dict[str, np.ndarray]:
    """Return phases and speeds of all touches of a diagram; none for a map."""
    most = max(1, MOST_POINTS // found.scan.lanes)
    return {
        name: np.ascontiguousarray(found.lanes(name)[..., :most], np.float32).ravel()
        for name in TOUCHES
        if name in found
    }
