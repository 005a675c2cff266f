"""What the page's script must know of a map beside the numbers of its cells, as plain values."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.palettes import Viridis256

from nlds_vines.explore.cell_columns import axes_of, section_points, told
from nlds_vines.explore.map_choices import classes_of, label_words, shows_of
from nlds_vines.explore.map_data import TOUCHES, Stored
from nlds_vines.orbits.status_words import STATUS
from nlds_vines.plotting.palette import HATCHED
from nlds_vines.plotting.style import NAVY, NO_VALUE, start_colours

MOST_POINTS = 2_000_000
"""The most points of a diagram: of a longer section, the last periods."""


def meta_of(found: Stored, points: int) -> dict[str, Any]:
    """Return titles, axes, starts, words and colours of a map, `points` of each section shown."""
    regimes = "label" in found
    sides = " × ".join(str(n) for n in found.scan.shape)
    several = f", {len(found.starts)} starts" if len(found.starts) > 1 else ""
    return {
        "title": found.scan.title,
        "head": f"{'Map' if len(found.scan.axes) == 2 else 'Diagram'}, {sides} cells{several}",
        "axes": axes_of(found),
        "starts": list(found.starts),
        "start_colours": start_colours(found.starts),
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
