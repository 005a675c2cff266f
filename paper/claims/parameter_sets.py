"""Section 3.1: six parameter sets of the SSul NES."""

from __future__ import annotations

from collections import Counter

import numpy as np

from nlds_vines.model.labels import TRANSIENT
from paper.claims.claim import (
    Claim,
    Finding,
    Verdict,
    decided,
    listed,
    maxima,
    spans,
    tuning_frequency,
    weighed,
)
from paper.claims.measured import Data, Evidence

SETS = tuple(f"ssul-set{number}" for number in range(1, 7))
SET6 = "ssul-set6"
SAME_CURVE = 0.03  # of the peak, difference of two curves that cannot be told apart in print
SIMILAR = 0.1  # of the energy without damper, difference of reductions that count as similar
PEAK = 0.3  # of the highest maximum, least height of a maximum that counts as a peak
NARROW = 0.3  # rad/s, largest width of a window that counts as narrow
OFTEN = 2  # frequencies of a grid at which a motion is found that takes turns with others
FAR = 2.0  # of its largest way towards the obstacle, least way of the damper away from it
ALIKE = f"reductions within {100 * SIMILAR:g} points of each other, by peak and where tuned"


def _sets_1_and_2(evidence: Evidence) -> Finding:
    first, second = (evidence("2a", name)["E1max"] for name in SETS[:2])
    apart = float(np.abs(first - second).max() / first.max())
    return decided(apart <= SAME_CURVE, f"at most {100 * apart:.1f} % of the peak apart")


def _sets_3_to_6(evidence: Evidence) -> Finding:
    cut, there = reductions(evidence, "2a", SETS[2:])
    text = (
        f"Sets 3, 4, 5, 6: {listed(100 * cut, '.0f')} % off the peak, {listed(100 * there, '.0f')} "
        f"% off at {tuning_frequency():g} rad/s"
    )
    return weighed(text, *(np.ptp(part) <= SIMILAR for part in (cut, there)))


def reductions(
    evidence: Evidence, figure: str, names: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of the energy that dampers take off: of the peak, and where tuned."""
    bare, tuned = evidence(figure, "none"), tuning_frequency()
    curves = [evidence(figure, name) for name in names]
    cut = [1 - data.peak()[0] / bare.peak()[0] for data in curves]
    return np.array(cut), np.array([1 - data.at(tuned) / bare.at(tuned) for data in curves])


def _set6_best(evidence: Evidence) -> Finding:
    peaks = [evidence("2a", name).peak()[0] for name in SETS]
    there = [evidence("2a", name).at(tuning_frequency()) for name in SETS]
    text = (
        f"Sets 1 to 6: peaks {listed(peaks, '.4g')} J; at {tuning_frequency():g} rad/s, where they "
        f"were tuned, {listed(there, '.4g')} J, Set 6 the {_rank(there[2:])} of Sets 3 to 6"
    )
    return weighed(text, *(values[5] == min(values) for values in (peaks, there)))


def _rank(values: list[float]) -> str:
    """Return the place of the last value among all, the least first, in words."""
    place = sorted(values).index(values[-1])
    return ("best", "second", "third", "last")[place]


def _two_peaks(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    tops = maxima(data["E1max"], PEAK)
    shown = " and ".join(f"{data['E1max'][i]:.0f} J at {data.omega[i]:.3f}" for i in tops)
    return decided(len(tops) == 2, f"{shown} rad/s")


def _damper_energy(evidence: Evidence) -> Finding:
    data, tuned = evidence("2b", SET6), tuning_frequency()
    most, where = data.peak("E2max")
    E1, E2 = data.at(tuned), data.at(tuned, "E2max")
    share = float(np.mean(data["E2max"] > data["E1max"]))
    text = (
        f"{most:.0f} J at {where:.3f} rad/s, of the structure {data.peak()[0]:.0f} J at its peak; "
        f"at {tuned:g} rad/s {E2:.0f} J, of the structure {E1:.0f} J; above the structure's at "
        f"{100 * share:.0f} % of the frequencies"
    )
    return weighed(text, most > data.peak()[0], E2 > E1)


def _away(evidence: Evidence) -> Finding:
    motion = min(evidence.motions("impact"), key=lambda motion: motion.system.K)
    away, towards = motion.greatest, -motion.least
    text = (
        f"at {tuning_frequency():g} rad/s up to {away:.3f} m away from the obstacle, "
        f"{towards:.3f} m towards it, from where the spring rests"
    )
    return decided(away >= FAR * towards, text)


def _wide_impacts(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    share = float(np.mean(data.is_struck))
    first, last = next(iter(spans(data.omega, data.is_struck)), (0.0, 0.0))
    text = (
        f"without a gap from {first:.3f} to {last:.3f} rad/s; {100 * share:.0f} % of 5 to 8 rad/s"
    )
    return decided(share > 0.5, text)


def simple_region(data: Data) -> tuple[float, float]:
    """Return the widest range of frequencies with T,1 throughout [rad/s]; (0, 0) for none."""
    simple = (data["periodicity"] == 1) & (data["impact_count"] == 1)
    return max(spans(data.omega, simple), key=lambda span: span[1] - span[0], default=(0.0, 0.0))


def _simple_motion(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    low, high = simple_region(data)
    share = (high - low) / float(data.omega[-1] - data.omega[0])
    text = (
        f"T,1 at every frequency from {low:.3f} to {high:.4f} rad/s: {100 * share:.0f} % of 5 to 8"
    )
    return decided(share > 0.5, text)


def _alternation(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    above = data.omega > simple_region(data)[1]
    pairs = zip(
        data["periodicity"][above].tolist(), data["impact_count"][above].tolist(), strict=True
    )
    counted = Counter((n, k) for n, k in pairs if n > 0)
    found = sorted(counted)
    shown = ", ".join(f"{n if n > 1 else ''}T,{k}" for n, k in found)
    study = evidence("stiffness", SET6)
    three = np.any((study["periodicity"] == 3) & (study["impact_count"] == 3), axis=0)
    text = (
        f"{shown}; three impacts (3T,3) at {counted[3, 3]} of {data.omega.size} frequencies with "
        f"the assumed K, somewhere at {three.sum()} of {three.size} K"
    )
    often = [pair for pair in found if counted[pair] >= OFTEN]
    somewhere = [*found, (3, 3)] if three.any() else found
    return weighed(text, _all_of(often), _all_of(somewhere))


def _all_of(motions: list[tuple[int, int]]) -> bool:
    """Return whether motions nT,k have each of n = 2, 3, 4 and, up to there, of k = 1, 2, 3."""
    periods, impacts = {n for n, _ in motions}, {k for n, k in motions if n <= 4}
    return periods >= {2, 3, 4} and impacts >= {1, 2, 3}


def _irregular(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    above = data.omega > simple_region(data)[1]
    labels = data["label"][above].tolist()
    chaos, unclear = labels.count("chaos"), labels.count("undetermined")
    transient = sum(label.startswith(TRANSIENT) for label in labels)
    text = (
        f"of {len(labels)} frequencies {chaos} chaotic, {transient} chaotic before they settle, "
        f"{unclear} undetermined"
    )
    if not (chaos or transient) and unclear:
        return Finding(Verdict.OPEN, text)
    return weighed(text, chaos > 0, transient > 0)


def _windows(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    free = spans(data.omega, ~data.is_struck)
    widest = sorted(free, key=lambda span: span[0] - span[1])[:3]
    shown = ", ".join(f"{low:.4f} to {high:.4f}" for low, high in sorted(widest))
    inside = [span for span in free if span[1] < data.omega[-1]]
    text = f"{len(free)} from rest on this grid, the widest {shown} rad/s"
    narrow = all(high - low < NARROW for low, high in inside)
    return decided(bool(inside) and narrow and free[0][0] > 7, text)


PARAMETER_SETS = (
    Claim(
        "3.1",
        "Sets 1 and 2 give the same curve of the structure's energy.",
        "2a",
        _sets_1_and_2,
        f"within {100 * SAME_CURVE:g} % of the peak",
    ),
    Claim("3.1", "Sets 3 to 6 reduce the energy similarly.", "2a", _sets_3_to_6, ALIKE),
    Claim(
        "3.1",
        "Set 6 is slightly the most effective.",
        "2a",
        _set6_best,
        "lowest, by peak and where tuned",
    ),
    Claim(
        "6",
        "With Set 6 the energy has two resonance peaks.",
        "2b",
        _two_peaks,
        f"maxima above {PEAK:g} of the highest",
    ),
    Claim(
        "3.1",
        "The damper's own energy is large.",
        "2b",
        _damper_energy,
        "above the structure's, by peak and where tuned",
    ),
    Claim(
        "3.1, 6",
        "The damper moves far away from the obstacle.",
        "impact",
        _away,
        f"at least {FAR:g} times as far as towards it",
    ),
    Claim(
        "3.1",
        "Impacts occur over a wide range of frequencies.",
        "2b",
        _wide_impacts,
        "more than half",
    ),
    Claim("3.1", "There the motion is T,1.", "8", _simple_motion, "more than half"),
    Claim(
        "3.1",
        "At high frequency 2T, 3T, 4T with 1, 2, 3 impacts take turns.",
        "8",
        _alternation,
        f"each of the periods and of the numbers of impacts at {OFTEN} frequencies or more",
    ),
    Claim("3.1", "Among them are chaotic motions and transient chaos.", "8", _irregular),
    Claim(
        "3.1",
        "Narrow windows there are free of impacts.",
        "2b",
        _windows,
        f"none but the last wider than {NARROW:g} rad/s",
    ),
)
"""The claims of Section 3.1, and of Section 6 about the same curves."""
