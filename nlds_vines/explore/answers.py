"""What a page is told: an orbit and its evidence in words, a map, how a computation stands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nlds_vines.bifurcation.cell_start import CellStart
from nlds_vines.explore import recipes
from nlds_vines.explore.cell_columns import columns, diagram_points, meta_of, touch_points
from nlds_vines.explore.live_orbit import LiveOrbit
from nlds_vines.explore.map_computation import Job
from nlds_vines.explore.map_data import Stored

if TYPE_CHECKING:
    from nlds_vines.orbits.classification import Regime

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


# ---- orbits in words -----------------------------------------------------------------------------


def words_of(regime: Regime) -> str:
    """Return what an orbit is, in one sentence."""
    if regime.kind == "periodic":
        return f"{_cycle(regime)} with {_impacts(regime)}"
    if regime.kind == "transient_chaos":
        return f"chaos that ended: now {_cycle(regime)} with {_impacts(regime)}"
    return {
        "quasiperiodic": "a motion on a torus",
        "chaotic": "neighboring orbits part, for all the periods that were followed",
        "undetermined": "no test of a regime was met",
    }.get(regime.kind, regime.kind)


def evidence_of(regime: Regime) -> list[tuple[str, str]]:
    """Return the evidence, a (quantity, value in words) each; what does not apply is left out."""
    return list(_evidence(regime))


def _evidence(regime: Regime) -> Iterator[tuple[str, str]]:
    if regime.period:
        yield "repeats to", f"{regime.residual:.1e} (relative)"
        assert regime.multipliers is not None
        largest = float(np.abs(regime.multipliers[0]))
        stands = "stable" if largest < 1 else "unstable"
        yield "largest multiplier", f"|μ| = {largest:.4g}: {stands}"
    yield from _exponents(regime)
    if regime.settling >= 0:
        yield "settled after", f"{regime.settling} periods"
    if math.isfinite(regime.clearance):
        yield "nearest miss", f"{regime.clearance:.3g} m"
    if math.isfinite(regime.softest):
        yield "softest impact", f"{regime.softest:.3g} m/s"
    if not regime.period and math.isfinite(regime.averaging):
        yield "averages over time converge to", f"{regime.averaging:.1f} digits"
    yield "followed for", f"{regime.watched} periods"
    if math.isfinite(regime.least_lifetime):
        yield "if transient", f"a mean life of {regime.least_lifetime:.0f} periods at least (95 %)"


def _exponents(regime: Regime) -> Iterator[tuple[str, str]]:
    """Yield the largest exponent, with its interval where it is an estimate."""
    if not math.isfinite(regime.lyapunov):
        return
    width = f" ± {regime.lyapunov_width:.1g}" if regime.lyapunov_width else ""
    yield "exponent λ₁", f"{regime.lyapunov:.4g}{width} 1/s"
    if math.isfinite(regime.transient_lyapunov):
        width = f" ± {regime.transient_lyapunov_width:.1g}"
        yield "before it settled", f"{regime.transient_lyapunov:.4g}{width} 1/s"


def _cycle(regime: Regime) -> str:
    n = regime.period
    return "repeats every forcing period" if n == 1 else f"repeats every {n} forcing periods"


def _impacts(regime: Regime) -> str:
    k = regime.impacts
    return "no impact" if k == 0 else f"{k} impact{'s' * (k > 1)} in each"
