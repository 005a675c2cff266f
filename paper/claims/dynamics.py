"""Section 5: the regimes of the SSul NES at different frequencies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from paper.claims.claim import (
    Claim,
    Finding,
    Verdict,
    decided,
    spans,
    weighed,
)
from paper.claims.contact_constants import SPECIAL
from paper.claims.measured import Data, Evidence
from paper.claims.parameter_sets import SET6, simple_region
from paper.linear import response

SOFTER = 2.5e7  # N/m^1.5, a K at which all three special regimes are found
MOST, ALMOST_ALL = (
    0.5,
    0.9,
)  # of the range of frequencies, least shares that count as most and as almost all of it
NEXT = 0.15  # largest share by which it may exceed that of the regular motions next to it


def _regimes(data: Data) -> set[tuple[int, int]]:
    """Return the different (n, k) of nT,k; (0, 0) stands for all motion without a period."""
    pairs = zip(data["periodicity"].tolist(), data["impact_count"].tolist(), strict=True)
    return {(n, k if n else 0) for n, k in pairs}


def _less_varied(evidence: Evidence) -> Finding:
    ours, other = evidence("8", SET6), evidence("ssbl", "ssbl")
    text = []
    shares = []
    for data in (ours, other):
        plain = (data["periodicity"] == 1) & (data["impact_count"] <= 1)
        shares.append(float(np.mean(plain)))
        kinds = len(_regimes(data))
        irregular = int(np.sum(data["periodicity"] == 0))
        text.append(
            f"{data.system.name} T,0 or T,1 at {100 * shares[-1]:.0f} % of the frequencies, "
            f"{kinds} different regimes, {irregular} frequencies without a period"
        )
    return decided(shares[0] > shares[1], "; ".join(text))


def _widest_range(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    low, high = simple_region(data)
    share = (high - low) / float(data.omega[-1] - data.omega[0])
    text = f"{low:.3f} to {high:.4f} rad/s, {100 * share:.0f} % of 5 to 8 rad/s"
    return weighed(text, share > MOST, share > ALMOST_ALL)


def _above_only(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    above = data.omega > 7.3
    calm_below = bool(
        np.all((data["periodicity"][~above] == 1) & (data["impact_count"][~above] == 1))
    )
    others = len(_regimes(Data(data.system, data.axes, _cut(data, above))))
    text = f"below 7.3 rad/s only T,1; above {others} different regimes"
    return decided(calm_below and others >= 4, text)


def _cut(data: Data, chosen: np.ndarray) -> dict[str, np.ndarray]:
    """Return periods and impacts of the chosen cells."""
    return {name: data[name][chosen] for name in ("periodicity", "impact_count")}


def _labeled(
    omega: float, holds: Callable[[str], bool], unclear: Callable[[str], bool]
) -> Callable[[Evidence], Finding]:
    """Return the check of the regime at one frequency [rad/s] and of its dependence on K.

    It agrees with the assumed K, in part with another K alone, and stays open where labels do.

    Arguments: the frequency; `holds` returns whether a label is the published one, `unclear`
    whether a label leaves that open.
    """

    def check(evidence: Evidence) -> Finding:
        data, study = evidence("8", SET6), evidence("stiffness", SET6)
        label, K = str(data["label"][data.place(omega)]), study.axes["K"]
        words = [str(word) for word in study["label"][study.place(omega)]]
        soft = words[int(np.argmin(np.abs(K - SOFTER)))]
        fitting, possible = sum(map(holds, words)), sum(map(unclear, words))
        text = (
            f"{label} with the assumed K, {soft} with K = {SOFTER:.3g}; as published at "
            f"{fitting} of {K.size} K from {K.min():.3g} to {K.max():.3g}, "
            f"not excluded at {possible} more"
        )
        if holds(label):
            return Finding(Verdict.AGREE, text)
        if fitting:
            return Finding(Verdict.PART, text)
        return Finding(Verdict.OPEN if possible or unclear(label) else Verdict.DIFFER, text)

    return check


def _window_width(evidence: Evidence) -> Finding:
    study = evidence("stiffness", SET6)
    widths = []
    for column in range(study.axes["K"].size):
        three = (study["periodicity"][:, column] == 3) & (study["impact_count"][:, column] == 3)
        widths += [high - low for low, high in spans(study.omega, three)]
    if not widths:
        return Finding(Verdict.DIFFER, "no 3T,3 at any K")
    step = float(study.omega[1] - study.omega[0])
    text = f"over all K the 3T,3 window is at most {max(widths) + step:.4f} rad/s wide"
    return decided(max(widths) + step < 0.025, text)


def _then_chaos(evidence: Evidence) -> Finding:
    study = evidence("stiffness", SET6)
    below, above = [], []
    for column in range(study.axes["K"].size):
        three = (study["periodicity"][:, column] == 3) & (study["impact_count"][:, column] == 3)
        for low, high in spans(study.omega, three):
            first, last = study.place(low), study.place(high)
            below.append(str(study["label"][max(first - 1, 0), column]))
            above.append(str(study["label"][min(last + 1, three.size - 1), column]))
    if not above:
        return Finding(Verdict.DIFFER, "no 3T,3 at any K")
    step = float(study.omega[1] - study.omega[0])
    text = (
        f"of {len(above)} windows over all K, {step:g} rad/s above {_counted(above)}; as far below "
        f"{_counted(below)}"
    )
    return weighed(text, *(all(word == "chaos" for word in words) for words in (below, above)))


def _counted(words: list[str]) -> str:
    """Return how often each of the labels stands in a list."""
    return ", ".join(f"{count} {word}" for word, count in Counter(words).most_common())


def _final_motion(evidence: Evidence) -> Finding:
    data, omega = evidence("8", SET6), SPECIAL[2]
    place = data.place(omega)
    n, k = int(data["periodicity"][place]), int(data["impact_count"][place])
    found = response(data.system, np.array([omega]))
    expected = float(found.E1max[0])
    text = (
        f"n = {n}, {k} impacts, E1max {data['E1max'][place]:.3f} J; the linear response without "
        f"impacts has {expected:.3f} J"
    )
    same = abs(data["E1max"][place] / expected - 1) < 1e-6
    return decided(n == 1 and k == 0 and same, text)


def _slow_damper(evidence: Evidence) -> Finding:
    found = response(evidence("8", SET6).system, np.array([SPECIAL[2]]))
    assert found.X2 is not None
    v1, v2 = (float(SPECIAL[2] * np.abs(X[0])) for X in (found.X1, found.X2))
    text = f"speeds up to {v2:.4f} m/s against {v1:.4f} m/s"
    return decided(v2 < 0.5 * v1, text)


def _irregular_energy(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    irregular = (
        data["periodicity"] == 0
    )  # a transient that has settled is regular where E1max is taken
    if not irregular.any():
        return Finding(Verdict.OPEN, "no irregular regime was found")
    worst, peak = float(data["E1max"][irregular].max()), data.peak()[0]
    above = _above_neighbors(data["E1max"], irregular)
    left = 1 - data["reduction"][irregular]
    text = (
        f"at most {worst:.0f} J where motion is irregular, at {int(irregular.sum())} frequencies, "
        f"the peak is {peak:.0f} J; up to {above:.2f} times that of the regular motion next to it, "
        f"and {left.min():.2f} to {left.max():.2f} times that without a damper"
    )
    return weighed(text, left.max() <= 1, above <= 1 + NEXT)


def _above_neighbors(energy: np.ndarray, irregular: np.ndarray) -> float:
    """Return the largest ratio of an irregular motion's energy to that of regular ones next to it.

    Arguments: `energy` and whether motion is `irregular`, both (n,) along the frequency.  Of the
    next regular motions on both sides the one with more energy counts; infinite if there are none.
    """
    regular = np.flatnonzero(~irregular)
    if not regular.size:
        return float("inf")
    after = np.searchsorted(regular, np.flatnonzero(irregular))
    sides = (regular[np.clip(after - step, 0, regular.size - 1)] for step in (1, 0))
    return float((energy[irregular] / np.maximum(*(energy[side] for side in sides))).max())


def _may_be_chaos(label: str) -> bool:
    """Return whether a label leaves open that the motion is chaos."""
    return label == "undetermined"


def _may_end_free(label: str) -> bool:
    """Return whether a label leaves open a transient that ends without impacts."""
    return label in ("T,0", "undetermined")


DYNAMICS = (
    Claim(
        "5",
        "The SSul NES is calm where the SSbl NES has rich dynamics.",
        "ssbl",
        _less_varied,
        "more often T,0 or T,1",
    ),
    Claim(
        "5",
        "T,1 covers almost the whole range of frequencies.",
        "8",
        _widest_range,
        f"{100 * ALMOST_ALL:g} % of 5 to 8 rad/s; in part from {100 * MOST:g} %",
    ),
    Claim(
        "5",
        "Only high frequencies bring other regimes, in quick succession.",
        "8",
        _above_only,
    ),
    Claim(
        "5",
        "3T,3 at 7.375 rad/s.",
        "stiffness",
        _labeled(SPECIAL[0], lambda label: label == "3T,3", _may_be_chaos),
    ),
    Claim(
        "5",
        "The slightest change of that frequency destroys it.",
        "stiffness",
        _window_width,
        "windows below 0.025 rad/s",
    ),
    Claim(
        "5",
        "What follows is chaos.",
        "stiffness",
        _then_chaos,
        "the next frequencies on both sides",
    ),
    Claim(
        "5",
        "Chaos at 7.400 rad/s.",
        "stiffness",
        _labeled(SPECIAL[1], lambda label: label == "chaos", _may_be_chaos),
    ),
    Claim(
        "5",
        "Transient chaos at 7.575 rad/s.",
        "stiffness",
        _labeled(SPECIAL[2], lambda label: label.startswith("transient chaos"), _may_end_free),
    ),
    Claim("5", "It ends in T-periodic motion without impacts.", "8", _final_motion),
    Claim(
        "5",
        "In that motion the damper is much slower than the structure.",
        "8",
        _slow_damper,
        "less than half as fast",
    ),
    Claim(
        "7",
        "Irregular motion does not spoil the effect.",
        "8",
        _irregular_energy,
        f"less energy than without a damper, and at most {100 * NEXT:g} % above regular motion "
        "next to it",
    ),
)
"""The claims of Section 5, and of Section 7 about the same motions."""
