"""Section 2: the mass of the damper, and the contact stiffness, which the paper does not fix."""

from __future__ import annotations

import numpy as np

from paper.claims.claim import Claim, Finding, Verdict, decided, weighed
from paper.claims.measured import Data, Evidence

SPECIAL = (7.375, 7.4, 7.575)
"""The frequencies of the special regimes in Section 5 [rad/s]."""


def _stiffness(evidence: Evidence) -> Finding:
    system = evidence("stiffness", "ssul-set6").system
    p = system.parameters
    text = (
        f"A, B and q1 are not printed; with A = {p['A']:g}, B = {p['B']:g} 1/m, q1 = {p['q1']:g} "
        f"K = {system.K:.6g} N/m^1.5"
    )
    return Finding(Verdict.OPEN, text)


def _mass(evidence: Evidence) -> Finding:
    p = evidence("8", "ssul-set6").system.parameters
    share = p["m2"] / p["m1"]
    own = np.sqrt(p["k1"] / p["m1"])
    text = f"m2 / m1 = {100 * share:g} %; the structure's own frequency is {own:.4f} rad/s"
    return decided(abs(share - 0.06) < 1e-9 and abs(own - p["omega"]) < 0.01 * own, text)


def stiffnesses_with_all(data: Data) -> tuple[list[float], list[float]]:
    """Return the K [N/m^1.5] of a study at which all three special regimes are found.

    Returns two lists.  The first: final regime 3T,3 at the first frequency of `SPECIAL`, chaos at
    the second, final regime T,0 at the third.  The second: those of them
    whose labels are the published words, 3T,3, chaos and transient chaos.
    """
    three, chaos, settled = (data.place(omega) for omega in SPECIAL)
    period, impacts, label = data["periodicity"], data["impact_count"], data["label"].astype(str)
    found = (period[three] == 3) & (impacts[three] == 3)
    found &= label[chaos] == "chaos"
    found &= (period[settled] == 1) & (impacts[settled] == 0)
    worded = found & (label[three] == "3T,3")
    worded &= np.char.startswith(label[settled], "transient chaos")
    return data.axes["K"][found].tolist(), data.axes["K"][worded].tolist()


def _together(evidence: Evidence) -> Finding:
    data = evidence("stiffness", "ssul-set6")
    found, worded = stiffnesses_with_all(data)
    if not found:
        return Finding(Verdict.DIFFER, "for no K of the grid")
    exact = ", ".join(f"{K:.3g}" for K in worded) or "none"
    text = (
        f"for {len(found)} values of K from {min(found):.3g} to {max(found):.3g} N/m^1.5; "
        f"with the published words for all three at {exact}; the assumed K is {data.system.K:.3g}"
    )
    return weighed(text, True, min(found) <= data.system.K <= max(found))


CONTACT = (
    Claim("2", "A damper of 6 % of the structure's mass, tuned at resonance.", "8", _mass),
    Claim(
        "2, eq. 4",
        "The moduli, the surfaces' geometry and equation (4) fix the contact stiffness K.",
        "stiffness",
        _stiffness,
    ),
    Claim(
        "2 and 5",
        "One K gives 3T,3 at 7.375, chaos at 7.400 and in the end T,0 at 7.575 rad/s.",
        "stiffness",
        _together,
        "in part where the assumed K is none of them",
    ),
)
