"""How the computation of an orbit ended: each status by its code, with the remedy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from nlds_vines.kernels.scene.codes import (
    BAD_PARAMETERS,
    DIVERGED,
    NOT_COMPUTED,
    OK,
    STEP_BUDGET,
    TOO_STIFF,
)


class Status(NamedTuple):
    """How the computation of one lane ended: a CF word, and the sentence that helps a user on."""

    name: str
    remedy: str

    @property
    def meaning(self) -> str:
        """Name and remedy as one CF word, `diverged.check_the_damping`: split at the dot."""
        words = self.remedy.rstrip(".").replace(",", "").replace(";", "").replace(":", "")
        return f"{self.name}.{words.replace(' ', '_')}"


STATUS: Mapping[int, Status] = {
    OK: Status("ok", "Nothing to do."),
    NOT_COMPUTED: Status("not_computed", "Finish the scan with --resume."),
    DIVERGED: Status("diverged", "Check masses, damping and forcing: the state grows unbounded."),
    STEP_BUDGET: Status("step_budget", "Raise omega or lower K: a period took too many steps."),
    BAD_PARAMETERS: Status("bad_parameters", "Vary within the ranges that the system allows."),
    TOO_STIFF: Status(
        "too_stiff", "Raise omega, masses or the steps of rk4, or lower stiffness or damping."
    ),
}
"""Status of a lane by code. New codes need no other place."""

STATUS_FLAGS = {status.meaning: code for code, status in STATUS.items()}
"""The CF flags of the dataset `status`."""


def failures_in(status: np.ndarray) -> Counter[int]:
    """Return how many orbits failed, by code; `status` of any shape."""
    return Counter(status[status != OK].tolist())


def failures_in_words(failures: Counter[int], orbits: int) -> str:
    """Return how many of so many `orbits` failed, why, and what helps; empty where none did.

    Arguments: `failures`, as `failures_in` counts them.
    """
    if not failures:
        return ""
    why = (
        f"{count} {STATUS[code].name} ({STATUS[code].remedy.rstrip('.')})"
        for code, count in sorted(failures.items())
    )
    return f"{failures.total()} of {orbits} orbits failed: {'; '.join(why)}"
