"""Checks of this program itself: simulations against closed forms."""

from __future__ import annotations

import numpy as np

from paper.claims.claim import (
    Check,
    Claim,
    Finding,
    decided,
    spans,
    tuning_frequency,
)
from paper.claims.measured import Evidence
from paper.linear import response

EXACT = 1e-6
"""The largest relative difference of a settled orbit's energy from the closed form."""


def _same_as_linear(name: str) -> Check:
    """Return the check that a linear system's simulated energies are those of the closed form."""

    def check(evidence: Evidence) -> Finding:
        data = evidence("3", name)
        exact = response(data.system, data.omega).E1max
        apart = float(np.abs(data["E1max"] / exact - 1).max())
        peak, where = data.peak()
        text = (
            f"{data.at(tuning_frequency()):.3f} J at {tuning_frequency():g} rad/s, peak "
            f"{peak:.3f} J at {where:g} rad/s; at most {apart:.0e} from the closed form"
        )
        return decided(apart < EXACT, text)

    return check


def _possible(figure: str, name: str) -> Check:
    """Return the check that no orbit is free of impacts where the linear response hits a wall.

    Arguments: the short name of a request and the name of one of its curves.
    """

    def check(evidence: Evidence) -> Finding:
        data = evidence(figure, name)
        fine = np.linspace(data.omega[0], data.omega[-1], 300_001)
        free = response(data.system, fine).clears
        shown = ", ".join(f"{low:.4f} to {high:.4f}" for low, high in spans(fine, free))
        settled = ~data.is_struck
        wrong = settled & ~response(data.system, data.omega).clears
        missed = ~settled & response(data.system, data.omega).clears
        text = (
            f"possible at {shown} rad/s; simulated without impacts elsewhere at "
            f"{int(wrong.sum())} frequencies, with impacts there at {int(missed.sum())}"
        )
        return decided(not wrong.any(), text)

    return check


FACTS = (
    Claim(
        "-",
        "Structure alone: the simulated curve is the closed form.",
        "3",
        _same_as_linear("none"),
    ),
    Claim("-", "TMD: the simulated curve is the closed form.", "3", _same_as_linear("tmd")),
    Claim(
        "-",
        "SSul NES, Set 6: no motion without impacts where it cannot be.",
        "8",
        _possible("8", "ssul-set6"),
    ),
    Claim(
        "-",
        "SSbl NES: no motion without impacts where it cannot be.",
        "ssbl",
        _possible("ssbl", "ssbl"),
    ),
)
"""The checks against closed forms, which do not depend on the paper."""
