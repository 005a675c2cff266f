"""Section 5, Figures 9 and 10: single orbits in full."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.orbits.signals import SIGNALS
from nlds_vines.orbits.spectrum import Spectrum, spectrum_of
from nlds_vines.reproduce.claims.claim import Claim, Finding, decided, listed, weighed
from nlds_vines.reproduce.claims.measured import Evidence

if TYPE_CHECKING:
    from nlds_vines.portrait.result import View

DISTINCT = 0.1  # of the largest force of a cycle, least difference of two that are different
BROAD = 0.5  # of the power, least share outside the lines of a periodic orbit
GROWING = 1.5  # least ratio of the bins that hold most power to those in a window half as long
POWER = 0.99  # the share of the power that is meant by most
SMEARED = 0.95  # of the points of a section, least share that are different
FINE = 1e-4  # of the width of a section, distance up to which two points are the same


def _forces(evidence: Evidence) -> Finding:
    (view,) = evidence.views("9")
    forces = np.sort(view.contacts["force"][-view.impacts :]) if view.impacts else np.empty(0)
    text = (
        f"{view.label} with K = {view.column.system.K:.3g} N/m^1.5: largest forces of a cycle "
        f"{listed(forces, '.0f') or 'none'} N"
    )
    three = view.label == "3T,3" and forces.size == 3
    return decided(three and np.diff(forces).min() >= DISTINCT * forces.max(), text)


def _spectrum(view: View, signal: str, periods: int) -> Spectrum:
    """Return the spectrum of a signal over the last periods of a view, tapered by Hann."""
    system = view.column.system
    values = SIGNALS[signal].of(system, view.states[-periods * view.samples :])
    return spectrum_of(values, view.samples, system.parameters["omega"], window="hann")


def _broad(evidence: Evidence) -> Finding:
    (view,) = evidence.views("10")
    whole = len(view.section) - len(view.section) % (2 * view.comb)
    words, holds = [], []
    for signal, meaning in (("x2", "of x2"), ("force", "of the contact force")):
        full, half = (_spectrum(view, signal, count) for count in (whole, whole // 2))
        share = full.broadband_share(view.comb)
        bins = half.bins_holding(POWER), full.bins_holding(POWER)
        words.append(
            f"{meaning} {100 * share:.1f} % of the power lies beside the lines of {view.comb}T, "
            f"{100 * POWER:g} % in {bins[1]} bins, in a window half as long in {bins[0]}"
        )
        holds += [share >= BROAD, bins[0] > 0 and bins[1] >= GROWING * bins[0]]
    text = f"with K = {view.column.system.K:.3g} N/m^1.5: {'; '.join(words)}"
    return weighed(text, *holds)


def _smear(evidence: Evidence) -> Finding:
    (view,) = evidence.views("10")
    section = view.section
    width = np.ptp(section, axis=0)
    cells = np.round((section - section.min(axis=0)) / np.where(width > 0, FINE * width, 1))
    different = len(np.unique(cells, axis=0))
    text = (
        f"with K = {view.column.system.K:.3g} N/m^1.5 {different} of {len(section)} points "
        f"differ by more than {FINE:g} of their range"
    )
    return decided(view.period == 0 and different >= SMEARED * len(section), text)


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
