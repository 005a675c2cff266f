"""What a page is told: an orbit in words, a map with its columns, how a computation stands."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nlds_vines.bifurcation.cell_start import CellStart
from nlds_vines.explore import recipes
from nlds_vines.explore.cell_columns import columns
from nlds_vines.explore.evidence_words import evidence_of, words_of
from nlds_vines.explore.live_orbit import LiveOrbit
from nlds_vines.explore.map_computation import Job
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.map_meta import diagram_points, meta_of, touch_points

Answer = dict[str, Any]


class Payload(NamedTuple):
    """A map for a page: what must be known of it, and its sources by name."""

    meta: Answer
    sources: dict[str, dict[str, np.ndarray]]


def payload(found: Stored) -> Payload:
    """Return a map as a page takes it."""
    every, points, rows = columns(found), diagram_points(found), found.scan.lanes
    lanes = {name: values for name, values in every.items() if len(values) == rows}
    cells = {name: values for name, values in every.items() if name not in lanes}
    count = next((len(values) // rows for values in points.values()), 0)
    sources = {"lanes": lanes, "cells": cells, "points": points, "touched": touch_points(found)}
    return Payload(meta_of(found, count), sources)


def in_words(number: int, start: CellStart, orbit: LiveOrbit | None) -> Answer:
    """Return what a page says of an orbit, or that there is none."""
    found: Answer = {"number": number, "where": f"from {start.words}", "layout": []}
    if orbit is None:
        return found | {"label": "no orbit", "words": "", "evidence": [], "command": ""}
    regime = orbit.regime
    return found | {
        "label": orbit.label,
        "words": "by recurrence alone" if regime is None else words_of(regime),
        "evidence": [] if regime is None else [list(pair) for pair in evidence_of(regime)],
        "command": recipes.portrait_command(orbit.request),
    }


def job_state(job: Job | None, found: Stored) -> Answer:
    """Return how a computation stands, beside the map that is seen."""
    if job is None:
        return {"running": False, "share": 0.0, "text": ""}
    running = job.share < 1 and not job.cancelled and not job.error
    text = job.error
    if running:
        text = job.note or f"{job.done} of {job.total} orbits"
    elif job.cancelled and job.share < 1 and job.found is found:
        text = f"cancelled at {job.share:.0%}"
    return {"running": running, "share": job.share, "text": text}
