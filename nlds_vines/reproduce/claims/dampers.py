"""Section 3: six parameter sets, and the comparison with TMD and SSbl NES."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nlds_vines.model.catalogue import catalogue
from nlds_vines.model.linear_response import response
from nlds_vines.model.system import System
from nlds_vines.reproduce.claims.claim import (
    Claim,
    Data,
    Evidence,
    Finding,
    Verdict,
    decided,
    maxima,
    spans,
    tuning_frequency,
)

SETS = tuple(f"ssul-set{number}" for number in range(1, 7))
SET6, FREED = "ssul-set6", "tmd_k2=2083_c2=112"
SAME_CURVE = 0.03  # of the peak, difference of two curves that cannot be told apart in print
SIMILAR = 0.15  # of the peak without damper, difference of reductions that count as similar
PEAK = 0.3  # of the highest maximum, least height of a maximum that counts as a peak
NARROW = 0.3  # rad/s, largest width of a window that counts as narrow
_ALIKE = f"reductions within {100 * SIMILAR:g} points of each other"


def _sets_1_and_2(evidence: Evidence) -> Finding:
    first, second = (evidence("2a", name)["E1max"] for name in SETS[:2])
    apart = float(np.abs(first - second).max() / first.max())
    return decided(apart <= SAME_CURVE, f"at most {100 * apart:.1f} % of the peak apart")


def _sets_3_to_6(evidence: Evidence) -> Finding:
    bare = evidence("2a", "none").peak()[0]
    left = [evidence("2a", name).peak()[0] / bare for name in SETS[2:]]
    shown = ", ".join(f"{100 * (1 - part):.0f}" for part in left)
    text = f"reduction of the peak by {shown} % for Sets 3, 4, 5, 6"
    return decided(max(left) - min(left) <= SIMILAR, text)


def _set6_best(evidence: Evidence) -> Finding:
    peaks = {name: evidence("2a", name).peak()[0] for name in SETS}
    there = {name: evidence("2a", name).at(tuning_frequency()) for name in SETS}
    text = (
        f"by peak yes: {_listed(peaks)} J for Sets 1 to 6; "
        f"at {tuning_frequency():g} rad/s, where they were tuned, {_listed(there)} J"
    )
    return decided(min(peaks, key=lambda name: peaks[name]) == SET6, text)


def _listed(values: dict[str, float]) -> str:
    """Return the values in one line, with four digits."""
    return ", ".join(f"{value:.4g}" for value in values.values())


def _two_peaks(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    tops = maxima(data["E1max"], PEAK)
    shown = " and ".join(f"{data['E1max'][i]:.0f} J at {data.omega[i]:.3f}" for i in tops)
    return decided(len(tops) == 2, f"{shown} rad/s")


def _damper_energy(evidence: Evidence) -> Finding:
    data, tuned = evidence("2b", SET6), tuning_frequency()
    most, where = data.peak("E2max")
    E1, E2 = data.at(tuned), data.at(tuned, "E2max")
    text = f"{most:.0f} J at {where:.3f} rad/s; at {tuned:g} rad/s {E2:.0f} J, of the structure "
    text += f"{E1:.0f} J"
    return decided(E2 > E1, text)


def _wide_impacts(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    share = float(np.mean(data["impacts"] > 0))
    first, last = next(iter(spans(data.omega, data["impacts"] > 0)), (0.0, 0.0))
    text = (
        f"without a gap from {first:.3f} to {last:.3f} rad/s; {100 * share:.0f} % of 5 to 8 rad/s"
    )
    return decided(share > 0.5, text)


def simple_region(data: Data) -> tuple[float, float]:
    """Return the widest range of frequencies with T,1 throughout [rad/s]; (0, 0) for none."""
    simple = (data["period"] == 1) & (data["impacts"] == 1)
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
    pairs = zip(data["period"][above].tolist(), data["impacts"][above].tolist(), strict=True)
    found = sorted({(n, k) for n, k in pairs if n > 0})
    shown = ", ".join(f"{n if n > 1 else ''}T,{k}" for n, k in found)
    study = evidence("stiffness", SET6)
    three = np.any((study["period"] == 3) & (study["impacts"] == 3), axis=0)
    text = f"{shown}; 3T,3 is narrower than the grid, but there at {three.sum()} of {three.size} K"
    periods, impacts = {n for n, _ in found}, {k for n, k in found if n <= 4}
    impacts |= {3} if three.any() else set()
    return decided(periods >= {2, 3, 4} and impacts >= {1, 2, 3}, text)


def _irregular(evidence: Evidence) -> Finding:
    data = evidence("8", SET6)
    above = data.omega > simple_region(data)[1]
    labels = data["label"][above].tolist()
    chaos = sum("chaos" in label for label in labels)
    unclear = labels.count("undetermined")
    text = f"of {len(labels)} frequencies {chaos} chaotic or transient, {unclear} undetermined"
    if chaos:
        return Finding(Verdict.AGREE, text)
    return Finding(Verdict.OPEN if unclear else Verdict.DIFFER, text)


def _windows(evidence: Evidence) -> Finding:
    data = evidence("2b", SET6)
    free = spans(data.omega, data["impacts"] == 0)
    widest = sorted(free, key=lambda span: span[0] - span[1])[:3]
    shown = ", ".join(f"{low:.4f} to {high:.4f}" for low, high in sorted(widest))
    inside = [span for span in free if span[1] < data.omega[-1]]
    text = f"{len(free)} from rest on this grid, the widest {shown} rad/s"
    narrow = all(high - low < NARROW for low, high in inside)
    return decided(bool(inside) and narrow and free[0][0] > 7, text)


def _ranking(evidence: Evidence) -> Finding:
    names = (SET6, "ssbl", "tmd", "none")
    peaks = [evidence("3", name).peak() for name in names]
    shown = ", ".join(
        f"{name} {E:.1f} J at {w:.3f}" for name, (E, w) in zip(names, peaks, strict=True)
    )
    return decided(all(a[0] < b[0] for a, b in pairwise(peaks)), f"{shown} rad/s")


def _most_transferred(evidence: Evidence) -> Finding:
    names = (SET6, "ssbl", "tmd")
    peaks = [evidence("3", name).peak("E2max")[0] for name in names]
    shown = ", ".join(f"{name} {E:.0f}" for name, E in zip(names, peaks, strict=True))
    return decided(peaks[0] == max(peaks), f"largest E2max: {shown} J")


def _slightly_lower(evidence: Evidence) -> Finding:
    bare = evidence("3", "none").peak()[0]
    names = (SET6, "ssbl", "tmd")
    cut = [100 * (1 - evidence("3", name).peak()[0] / bare) for name in names]
    shown = ", ".join(f"{name} {part:.0f} %" for name, part in zip(names, cut, strict=True))
    return decided(
        min(cut) > 50 and max(cut) - min(cut) <= 100 * SIMILAR, f"peak reduced by: {shown}"
    )


def _rounding(evidence: Evidence) -> Finding:
    exact, rounded = (evidence("rounding", name) for name in (SET6, "ssul-set6-table2"))
    apart = np.abs(exact["E1max"] - rounded["E1max"]) / exact["E1max"]
    peaks = [data.peak()[0] for data in (exact, rounded)]
    where = float(exact.omega[int(np.argmax(apart))])
    text = (
        f"peaks {peaks[0]:.2f} and {peaks[1]:.2f} J; largest relative difference "
        f"{100 * apart.max():.0f} % at {where:.3f} rad/s, among the narrow regimes; "
        f"{100 * apart[exact.omega < 7.3].max():.1f} % below 7.3 rad/s"
    )
    return decided(abs(peaks[1] / peaks[0] - 1) < SAME_CURVE, text)


def _tmd_optimal(evidence: Evidence) -> Finding:
    printed, free = evidence("free-tmd", "tmd"), evidence("free-tmd", FREED)
    p = free.system.parameters
    text = (
        f"with k2 = {p['k2']:g} N/m, c2 = {p['c2']:g} N s/m the peak is "
        f"{free.peak()[0]:.1f} J instead of {printed.peak()[0]:.1f} J, and at "
        f"{tuning_frequency():g} rad/s {free.at(tuning_frequency()):.1f} J instead of "
        f"{printed.at(tuning_frequency()):.1f} J: Table 2 rests on bounds that are not printed"
    )
    return decided(free.peak()[0] >= printed.peak()[0], text)


def _best_of_all(evidence: Evidence) -> Finding:
    ours, free = evidence("free-tmd", SET6), evidence("free-tmd", FREED)
    tuned = tuning_frequency()
    light = _absorber(free.system, tuned)
    there = float(response(light, np.array([tuned])).E1max[0])
    text = (
        f"peak {ours.peak()[0]:.1f} J against {free.peak()[0]:.1f} J of the TMD freed of bounds; "
        f"at {tuned:g} rad/s {ours.at(tuned):.1f} J against {free.at(tuned):.1f} J, but a TMD with "
        f"k2 = m2 omega^2 = {light.parameters['k2']:.0f} N/m and the sets' least "
        f"c2 = {light.parameters['c2']:g} N s/m has {there:.1f} J there (closed form)"
    )
    return decided(ours.peak()[0] <= free.peak()[0], text)


def _absorber(tmd: System, omega: float) -> System:
    """Return a TMD in resonance with the force, as little damped as any of the published sets."""
    least = min(catalogue()[name].parameters["c2"] for name in SETS)
    return tmd.with_(k2=tmd.parameters["m2"] * omega**2, c2=least)


DAMPERS = (
    Claim(
        "3.1",
        "Sets 1 and 2 give the same curve of the structure's energy.",
        "2a",
        _sets_1_and_2,
        f"within {100 * SAME_CURVE:g} % of the peak",
    ),
    Claim("3.1", "Sets 3 to 6 reduce the energy similarly.", "2a", _sets_3_to_6, _ALIKE),
    Claim("3.1", "Set 6 is slightly the most effective.", "2a", _set6_best, "lowest peak"),
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
        "above the structure's, where tuned",
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

COMPARISON = (
    Claim("3.2", "Peaks rank: SSul NES below SSbl NES below TMD below no damper.", "3", _ranking),
    Claim("3.2", "The SSul NES takes up the most energy.", "3", _most_transferred),
    Claim(
        "3.2", "SSbl NES and TMD are only slightly less effective.", "3", _slightly_lower, _ALIKE
    ),
    Claim(
        "Table 2",
        "Table 2 shows Set 6 of Table 1, rounded.",
        "rounding",
        _rounding,
        f"peaks within {100 * SAME_CURVE:g} %",
    ),
    Claim("Table 2", "The TMD of Table 2 is the optimal one.", "free-tmd", _tmd_optimal),
    Claim(
        "3.2, 7",
        "An optimal SSul NES is more effective than an optimal TMD of its mass.",
        "free-tmd",
        _best_of_all,
    ),
)
"""The claims of Section 3.2 and of Table 2."""
