"""Sections 4.2, 4.3 and 7: the damping of the structure changes, or the amplitude of the force."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nlds_vines.model.catalog import catalog
from paper.claims.claim import (
    Check,
    Claim,
    Finding,
    by_name,
    listed,
    tuning_frequency,
    weighed,
)
from paper.claims.measured import Data, Evidence
from paper.claims.parameter_sets import SET6, SIMILAR, simple_region
from paper.claims.retention import (
    ALONE,
    DAMPERS,
    MUCH,
    STIFFNESSES,
    name,
)

HIGH = 0.5  # of the peak without damper, least reduction that counts as high
SAME = 0.9  # of the frequencies, least share with unchanged motion where dynamics is unchanged
MOVED = 0.05  # rad/s, by how much the end of T,1 may move further than with the other parameter


class Changed(NamedTuple):
    """A parameter that changes: its figure of energies, its study of regimes, its values [SI]."""

    parameter: str
    figure: str
    study: str
    values: tuple[float, ...]

    @property
    def base(self) -> int:
        """The place of the value of the tuning."""
        return self.values.index(catalog()[SET6].parameters[self.parameter])

    def curve(self, evidence: Evidence, damper: str, value: float) -> Data:
        """Return the data of a damper at one of the values."""
        return evidence(self.figure, name(damper, self.parameter, value))

    def reductions(self, evidence: Evidence) -> dict[str, np.ndarray]:
        """Return by damper the shares taken off (2, values): of the peak, and where tuned."""
        tuned, found = tuning_frequency(), {}
        for damper in DAMPERS:
            pairs = [
                (self.curve(evidence, damper, v), self.curve(evidence, ALONE, v))
                for v in self.values
            ]
            peaks = [1 - data.peak()[0] / alone.peak()[0] for data, alone in pairs]
            there = [1 - data.at(tuned) / alone.at(tuned) for data, alone in pairs]
            found[damper] = np.array([peaks, there])
        return found

    def peaks(self, evidence: Evidence, damper: str) -> np.ndarray:
        """Return a damper's peaks over that of the tuning, a value for each of the values."""
        peaks = [self.curve(evidence, damper, v).peak()[0] for v in self.values]
        return np.array(peaks) / peaks[self.base]


DAMPING = Changed("c1", "6", "damping", (352.0, 452.0, 552.0))
FORCE = Changed("P", "7", "force", (600.0, 800.0, 1000.0))


def _of(found: dict[str, np.ndarray], row: int) -> str:
    """Return one row of the reductions by damper, in words."""
    return by_name({damper: list(values[row]) for damper, values in found.items()})


def _remains(changed: Changed) -> Check:
    """Return the check that the reductions stay high and similar, and the peaks do too."""

    def check(evidence: Evidence) -> Finding:
        found = changed.reductions(evidence)
        growth = {d: changed.peaks(evidence, d) for d in (*DAMPERS, ALONE)}
        cut = np.array([values[0] for values in found.values()])
        text = (
            f"part of the peak taken off at {changed.parameter} = {listed(changed.values)}: "
            f"{_of(found, 0)}; peaks over those of the tuning: "
            f"{by_name({d: list(row) for d, row in growth.items()})}"
        )
        kept = cut.min() >= HIGH and np.ptp(cut, axis=1).max() <= SIMILAR
        steady = all(np.abs(growth[d] - 1).max() <= MUCH for d in DAMPERS)
        return weighed(text, kept, steady)

    return check


def _negligible(changed: Changed) -> Check:
    """Return the check that each damper's reductions hardly change, by peak and where tuned."""

    def check(evidence: Evidence) -> Finding:
        found = changed.reductions(evidence)
        text = (
            f"share taken off at {changed.parameter} = {listed(changed.values)}: of the peak "
            f"{_of(found, 0)}; at {tuning_frequency():g} rad/s {_of(found, 1)}"
        )
        moves = (
            np.abs(values - values[:, [changed.base]]).max() <= SIMILAR for values in found.values()
        )
        return weighed(text, *moves)

    return check


def _best(changed: Changed) -> Check:
    """Return the check that the SSul NES has the least energy at each of the values."""

    def check(evidence: Evidence) -> Finding:
        curves = {d: [changed.curve(evidence, d, v) for v in changed.values] for d in DAMPERS}
        peaks = {d: [data.peak()[0] for data in row] for d, row in curves.items()}
        there = {d: [data.at(tuning_frequency()) for data in row] for d, row in curves.items()}
        text = (
            f"{changed.parameter} = {listed(changed.values)}: peaks {by_name(peaks, '.0f')} J; at "
            f"{tuning_frequency():g} rad/s {by_name(there, '.0f')} J"
        )
        best = (np.argmin(list(row.values()), axis=0) == 0 for row in (peaks, there))
        return weighed(text, *(bool(column.all()) for column in best))

    return check


def regimes(data: Data) -> np.ndarray:
    """Return one number for each regime nT,k along the frequency; -1 without a period."""
    period, impacts = data["periodicity"], data["impact_count"]
    return np.where(period > 0, 1000 * period + impacts, -1)


def _columns(evidence: Evidence, changed: Changed) -> list[Data]:
    data = evidence(changed.study)
    return [data.column(index) for index in range(len(changed.values))]


def _same_dynamics(changed: Changed) -> Check:
    """Return the check that the same regimes stand at the same frequencies."""

    def check(evidence: Evidence) -> Finding:
        columns = _columns(evidence, changed)
        ours, simple = regimes(columns[changed.base]), 1001
        calm, rest, words = [], [], []
        for value, data in zip(changed.values, columns, strict=True):
            same, where = regimes(data) == ours, ours == simple
            calm.append(float(np.mean(same[where])) if where.any() else 0.0)
            rest.append(float(np.mean(same[~where])) if (~where).any() else 1.0)
            words.append(f"{value:g}: {simple_region(data)[1]:.3f}")
        text = (
            f"where the tuning has T,1 it stays at {listed(100 * np.array(calm), '.0f')} % of the "
            f"frequencies for {changed.parameter} = {listed(changed.values)}; elsewhere the regime "
            f"is the same at {listed(100 * np.array(rest), '.0f')} %; T,1 ends at "
            f"{', '.join(words)} rad/s"
        )
        return weighed(text, min(calm) >= SAME, min(rest) >= SAME)

    return check


def _force_as_damping(evidence: Evidence) -> Finding:
    cuts = [
        np.array([values[0] for values in changed.reductions(evidence).values()])
        for changed in (DAMPING, FORCE)
    ]
    ends = [
        np.array([simple_region(data)[1] for data in _columns(evidence, changed)])
        for changed in (DAMPING, FORCE)
    ]
    moves = [end - end[changed.base] for end, changed in zip(ends, (DAMPING, FORCE), strict=True)]
    apart, further = float(np.abs(cuts[1] - cuts[0]).max()), np.abs(moves[1]) - np.abs(moves[0])
    ranks = [np.argsort(np.argsort(cut, axis=0), axis=0) for cut in cuts]
    same = int(np.sum((ranks[0] == ranks[1]).all(axis=0)))
    text = (
        f"reductions of Figure 7 at most {100 * apart:.0f} points from those of Figure 6, the "
        f"dampers in the same order in {same} of {len(FORCE.values)} panels; the end of T,1 moves "
        f"by {listed(moves[0], '.3f')} rad/s with c1, by {listed(moves[1], '.3f')} rad/s with P"
    )
    return weighed(text, apart <= SIMILAR, same == len(FORCE.values), further.max() <= MOVED)


def _alike(evidence: Evidence) -> Finding:
    softness = Changed("k1", "4", "", STIFFNESSES)
    spreads = {}
    for changed in (softness, DAMPING, FORCE):
        cut = np.array([values[0] for values in changed.reductions(evidence).values()])
        change = cut - cut[:, [changed.base]]
        spreads[changed.parameter] = [100 * float(np.ptp(change, axis=0).max())]
    text = (
        "reductions of the peak change differently from damper to damper, by up to "
        f"{by_name(spreads, '.0f')} points"
    )
    return weighed(text, *(spread <= 100 * SIMILAR for (spread,) in spreads.values()))


_STAYS = (
    f"at least {100 * HIGH:g} % off each peak, within {100 * SIMILAR:g} points of each damper's "
    f"own; peaks within {100 * MUCH:g} %"
)
_HARDLY = f"reductions within {100 * SIMILAR:g} points, by peak and where tuned, all three"
_LEAST = "by peak and where tuned"
_UNCHANGED = f"the same regime at {100 * SAME:g} % of the frequencies, where T,1 is and elsewhere"

DAMPING_AND_FORCE = (
    Claim("4.2, 7", "Changing c1 hardly matters.", "6", _negligible(DAMPING), _HARDLY),
    Claim(
        "4.2", "With c1 changed, the reduction stays high and similar.", "6", _remains(DAMPING),
        _STAYS,
    ),
    Claim(
        "4.2", "The SSul NES stays the best of the three as c1 changes.", "6", _best(DAMPING),
        _LEAST,
    ),
    Claim(
        "4.3", "Changing c1 leaves the dynamics as it is.", "damping", _same_dynamics(DAMPING),
        _UNCHANGED,
    ),
    Claim("4.3, 7", "Changing P hardly matters.", "7", _negligible(FORCE), _HARDLY),
    Claim(
        "4.3", "With P changed, the reduction stays high and similar.", "7", _remains(FORCE),
        _STAYS,
    ),
    Claim(
        "4.3", "The SSul NES stays the best of the three as P changes.", "7", _best(FORCE), _LEAST,
    ),
    Claim(
        "4.3", "Changing P leaves the dynamics as it is.", "force", _same_dynamics(FORCE),
        _UNCHANGED,
    ),
    Claim(
        "4.3",
        "A change of P acts as one of c1 does.",
        "7",
        _force_as_damping,
        f"reductions within {100 * SIMILAR:g} points, the same order, the end of T,1 moves at most "
        f"{MOVED:g} rad/s more",
    ),
    Claim(
        "7",
        "The three dampers keep their tuning alike.",
        "4",
        _alike,
        f"changes of the reduction within {100 * SIMILAR:g} points of each other, for k1, c1 and P",
    ),
)  # fmt: skip
"""The claims of Sections 4.2 and 4.3, and of Section 7 about retention."""
