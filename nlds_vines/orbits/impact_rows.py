"""What an orbit tells of each impact, and of a limit that its damper must keep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nlds_vines.model.scenes.base import LONGEST_NAME

IMPACT = np.dtype(
    [
        ("wall", f"U{LONGEST_NAME}"),
        ("touch", float),
        ("release", float),
        ("speed", float),
        ("force", float),
        ("depth", float),
        ("gain1", float),
        ("gain2", float),
    ]
)
"""A row of `Orbit.impacts`: what is struck, obstacle or structure; times [s]; approach speed
[m/s]; peak force [N]; depth [m]; what E1 and E2 gain from touch to release [J]."""


class Violation(NamedTuple):
    """How the limit of a scene was broken that its damper must keep, the transient included."""

    number: int  # of passages
    time: float  # of the first [s]
    depth: float  # of the deepest [m]
