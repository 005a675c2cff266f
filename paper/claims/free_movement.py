"""The design that the paper leaves open, Figure 1c: what free movement behind a damper is worth.

Where a damper may pass the structure by L, it moves as one without that limit does as long as it
does not get there.  So one map of dampers without a limit has the answer for every L: how far each
passes the structure, which is the depth of its violation with L = 0, and its energy.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from paper.claims.claim import listed, tuning_frequency
from paper.claims.measured import Data, Evidence

LIMITS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8)
"""Values of L [m], chosen here: from none to more than the best damper takes."""


def passage(data: Data) -> np.ndarray:
    """Return how far each damper passes the structure [m], the transient included; 0 for never."""
    return np.where(data["violations"] > 0, data["violation_depth"], 0.0)


def best_within(evidence: Evidence) -> Iterator[tuple[str, ...]]:
    """Yield rows: L, the least energy where tuned of all dampers that keep it, and that damper."""
    data = evidence("model-1c")
    far = passage(data)
    for L in LIMITS:
        kept = far <= L
        energy = np.where(kept, data["E1max"], np.inf)
        place = np.unravel_index(int(energy.argmin()), energy.shape)
        pairs = zip(data.axes.items(), place, strict=True)
        values = [f"{axis[i]:g}" for (_, axis), i in pairs]
        yield f"{L:g}", f"{energy[place]:.1f}", *values, f"{kept.sum()} of {kept.size}"


def taken_by_set_6(evidence: Evidence) -> Iterator[tuple[str, ...]]:
    """Yield rows: k1, peak, its frequency, and the L taken where tuned, at the peak, at most."""
    data = evidence("free-movement")
    omega, far, tuned = data.omega, passage(data), data.place(tuning_frequency())
    for i, k1 in enumerate(data.axes["k1"]):
        top = int(data["E1max"][:, i].argmax())
        taken = (far[tuned, i], far[top, i], far[:, i].max())
        yield (
            f"{k1:g}",
            f"{data['E1max'][top, i]:.1f}",
            f"{omega[top]:g}",
            *listed(taken, ".3f").split(", "),
        )
