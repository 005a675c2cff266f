"""What becomes of one structure under a load: histories, last times, where the energy goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.model.load_quantities import SHARES
from nlds_vines.model.representation import Outlined
from nlds_vines.orbits.status_words import OK


@dataclass(frozen=True, repr=False)
class Fall(Outlined):
    """What becomes of one structure under a load.

    Arrays over `time` (n,) [s]: energies E1, E2 [J], displacements x1, x2 [m], `work`, the energy
    [J] that came in so far, and `dissipated`, what is gone so far, by `WAYS`.  What there is not
    without a damper, or without walls, is NaN.  `numbers`: those of `OF_LOADS`; `status`: how the
    orbit ended, a code of `STATUS`; all else is NaN where it failed.
    """

    time: np.ndarray
    E1: np.ndarray
    E2: np.ndarray
    x1: np.ndarray
    x2: np.ndarray
    work: np.ndarray
    dissipated: Mapping[str, np.ndarray]
    numbers: Mapping[str, float]
    status: int = OK

    @property
    def last(self) -> np.ndarray:
        """The last times (3,) [s] at which E1 exceeds `SHARES` of its largest; NaN: it does."""
        return np.array([self.numbers[f"last_{100 * share:g}"] for share in SHARES])


HISTORIES = {
    "E1": ("J", "energy of the structure, its velocity relative to the ground"),
    "E2": ("J", "energy of the damper, its velocity relative to the ground"),
    "x1": ("m", "displacement of the structure, relative to the ground"),
    "x2": ("m", "displacement of the damper, relative to the ground"),
    "work": ("J", "energy that came in so far, by the start and by the load"),
}
"""What is told over time, with its unit and its meaning."""
