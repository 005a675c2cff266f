"""Section 5, Figures 9 and 10: single orbits in full."""

from __future__ import annotations

import numpy as np

from paper.claims.claim import Claim, Finding, decided, listed, weighed
from paper.claims.measured import POWER, Evidence

DISTINCT = 0.1  # of the largest force of a cycle, least difference of two that are different
BROAD = 0.5  # of the power, least share outside the lines of a periodic orbit
GROWING = 1.5  # least ratio of the bins that hold most power to those in a window half as long
SMEARED = 0.95  # of the points of a section, least share that are different
FINE = 1e-4  # of the width of a section, distance up to which two points are the same


def _forces(evidence: Evidence) -> Finding:
    (motion,) = evidence.motions("9")
    forces = np.sort(motion.forces)
    text = (
        f"{motion.label or 'no period'} with K = {motion.system.K:.3g} N/m^1.5: largest forces of "
        f"a cycle {listed(forces, '.0f') or 'none'} N"
    )
    three = motion.label == "3T,3" and forces.size == 3
    return decided(three and np.diff(forces).min() >= DISTINCT * forces.max(), text)


def _broad(evidence: Evidence) -> Finding:
    (motion,) = evidence.motions("10")
    words, holds = [], []
    for signal, meaning in (("x2", "of x2"), ("force", "of the contact force")):
        found = motion.breadths[signal]
        words.append(
            f"{meaning} {100 * found.share:.1f} % of the power lies beside the lines of "
            f"{found.comb}T, {100 * POWER:g} % in {found.bins} bins, in a window half as long in "
            f"{found.bins_of_half}"
        )
        grown = 0 < GROWING * found.bins_of_half <= found.bins
        holds += [found.share >= BROAD, grown]
    text = f"with K = {motion.system.K:.3g} N/m^1.5: {'; '.join(words)}"
    return weighed(text, *holds)


def _smear(evidence: Evidence) -> Finding:
    (motion,) = evidence.motions("10")
    section = motion.section
    width = np.ptp(section, axis=0)
    cells = np.round((section - section.min(axis=0)) / np.where(width > 0, FINE * width, 1))
    different = len(np.unique(cells, axis=0))
    text = (
        f"with K = {motion.system.K:.3g} N/m^1.5 {different} of {len(section)} points "
        f"differ by more than {FINE:g} of their range"
    )
    return decided(not motion.label and different >= SMEARED * len(section), text)


SINGLE_ORBITS = (
    Claim(
        "5, Fig. 9",
        "The three impacts of a cycle of 3T,3 have different forces.",
        "9",
        _forces,
        f"at least {100 * DISTINCT:g} % of the largest apart",
    ),
    Claim(
        "5, Fig. 10",
        "The section of the chaotic motion is a smear.",
        "10",
        _smear,
        f"{100 * SMEARED:g} % of its points are different",
    ),
    Claim(
        "5, Fig. 10",
        "Its spectrum is broad and continuous.",
        "10",
        _broad,
        f"{100 * BROAD:g} % of the power beside the lines, and in {GROWING:g} times as many bins "
        "if the window is twice as long, for x2 and the contact force",
    ),
)
"""The claims about Figures 9 and 10."""
