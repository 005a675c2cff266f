"""Sections 2 and 3: are the printed dampers optima of what they were tuned for?

The objective is E1max at one frequency, that of the tuning.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nlds_vines.model.catalog import catalog
from paper.claims.claim import (
    Claim,
    Finding,
    decided,
    tuning_frequency,
    weighed,
)
from paper.claims.measured import Data, Evidence
from paper.claims.parameter_sets import SETS

NEAR = 0.1  # of each printed value, how far a better design may be
OPTIMAL = 0.03  # of the best energy nearby, how much more an optimum may have
AS_GOOD = 0.1  # of the least energy of the printed sets, how much more counts as similar
WIDE = 1.1  # least ratio of the greatest to the least k2, and C, of similar designs
TUNED = SETS[2:]
"""The sets that the optimization found."""


def near(data: Data, values: Mapping[str, float], share: float = NEAR) -> np.ndarray:
    """Return which cells of a map have all of its parameters within a share of `values`."""
    axes = np.meshgrid(*data.axes.values(), indexing="ij")
    inside = [
        np.abs(grid / values[key] - 1) <= share + 1e-9
        for key, grid in zip(data.axes, axes, strict=True)
    ]
    return np.logical_and.reduce(inside)


def _own(evidence: Evidence, name: str) -> float:
    """Return the energy of a printed set where it was tuned [J]."""
    return evidence("2a", name).at(tuning_frequency())


def _sets(evidence: Evidence) -> Finding:
    data, below = evidence("tuned-sets"), evidence("tuned-damping")
    words, optimal = [], []
    for name in TUNED:
        own = _own(evidence, name)
        around = near(data, catalog()[name].parameters)
        best = float(data["E1max"][around].min(initial=own))
        words.append(f"{name[5:]} {100 * (own / best - 1):.1f} %")
        optimal.append(own <= (1 + OPTIMAL) * best)
    least = min(catalog()[name].parameters["c2"] for name in TUNED)
    c2, energy = below.axes["c2"], below["E1max"].min(axis=0)
    inside, outside = energy[c2 >= least].min(), energy[c2 < least].min()
    text = (
        f"above the best of k2 and C within {100 * NEAR:g} %, c2 = {least:g} N s/m: "
        f"{', '.join(words)}; the paper prints no bound of c2: with "
        f"c2 = {c2[int(energy.argmin())]:g} N s/m there are {outside:.0f} J in place of "
        f"{inside:.0f} J"
    )
    return weighed(text, *optimal, inside <= (1 + OPTIMAL) * outside)


def _bilateral(evidence: Evidence) -> Finding:
    data = evidence("tuned-ssbl")
    own = evidence("3", "ssbl").at(tuning_frequency())
    around = near(data, catalog()["ssbl"].parameters)
    energy = np.where(around, data["E1max"], np.inf)
    best = min(float(energy.min()), own)
    place = np.unravel_index(int(energy.argmin()), energy.shape)
    values = ", ".join(
        f"{key} = {v[i]:.4g}" for (key, v), i in zip(data.axes.items(), place, strict=True)
    )
    text = (
        f"{own:.0f} J at {tuning_frequency():g} rad/s; {best:.0f} J with c2 and C within "
        f"{100 * NEAR:g} % ({values})"
    )
    return decided(own <= (1 + OPTIMAL) * best, text)


def _many(evidence: Evidence) -> Finding:
    data = evidence("tuned-sets")
    limit = (1 + AS_GOOD) * min(_own(evidence, name) for name in TUNED)
    good = data["E1max"] <= limit
    if not good.any():
        return decided(False, f"no design of the map has {limit:.0f} J or less")
    grids = np.meshgrid(*data.axes.values(), indexing="ij")
    ends = [(float(grid[good].min()), float(grid[good].max())) for grid in grids]
    shown = ", ".join(
        f"{key} from {low:g} to {high:g}" for key, (low, high) in zip(data.axes, ends, strict=True)
    )
    text = f"{int(good.sum())} of {good.size} designs of the map have up to {limit:.0f} J: {shown}"
    return decided(all(high >= WIDE * low for low, high in ends), text)


OPTIMA = (
    Claim(
        "2, 3.1",
        "Sets 3 to 6 are optima at the frequency of the tuning.",
        "tuned-sets",
        _sets,
        f"within {100 * OPTIMAL:g} % of the best nearby, and no better below the sets' c2",
    ),
    Claim(
        "2, Table 2",
        "So is the SSbl NES of Table 2.",
        "tuned-ssbl",
        _bilateral,
        f"within {100 * OPTIMAL:g} % of the best nearby",
    ),
    Claim(
        "3.1, 6",
        "Many sets of parameters are about as effective.",
        "tuned-sets",
        _many,
        f"within {100 * AS_GOOD:g} %, over a tenth of k2 and of C",
    ),
)
"""The claims about the optimization."""
