"""Attractors of a scan: end states are grouped in each system, groups are matched between systems.

Orbits of one system end on one attractor if their ends cannot be told apart: the section point of a
closed orbit lies on the cycle of the other, or two clouds of section points cover each other.
Attractors of neighboring systems have one number if their sections are close.  Both rest on
distances: numbers are matched, not proven, and each attractor has a margin.

States are those of the kernels, (x1, v1, r, s), of which the first `size` count.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from math import prod

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree
from scipy.spatial.distance import squareform

from nlds_vines.model.labels import PERIODIC

NOT_PERIODIC = ("chaos", "quasiperiodic")  # final regimes of attractors without a closed orbit

SAME = 1e-6
"""Distance of a point from a cycle up to which it lies on it, in amplitudes.

Measured over 30,000 orbits: at most 3e-11 within one attractor, at least 4.8e-2 between two."""

APART, PART = 5.0, 0.05
"""Clouds so far apart are two attractors: times the distance of neighbors within one cloud, and in
sizes of a cloud; the greater counts."""

CLOUD = 120  # section points of a cloud
PAIRS = 30  # clouds that are compared in pairs at a time
CLOUDS = 10  # clouds of an attractor that is not periodic whose points are kept

NEAR, FAR = 0.5, 0.3
"""Largest step of an attractor between two systems: relative to the distance of the next
attractor, and in amplitudes where there is no other."""

Sections = Callable[[np.ndarray, int], np.ndarray]
"""Follows orbits of a system from states (n, 4): their sections (n, periods, 4)."""


def period_of(label: str) -> int:
    """Return n of a label nT,k; 0 for an attractor that is not periodic, -1 for no attractor."""
    if match := PERIODIC.fullmatch(label):
        return int(match[1] or 1)
    return 0 if label in NOT_PERIODIC else -1


def impacts_of(label: str) -> int:
    """Return k of a label nT,k; -1 for any other."""
    match = PERIODIC.fullmatch(label)
    return int(match[2]) if match else -1


@dataclass(eq=False)
class Attractor:
    """One attractor of one system."""

    label: str
    period: int  # n of nT; 0 if it is not periodic
    points: np.ndarray  # (m, 4) of its section: the whole cycle, or `CLOUDS` clouds
    state: np.ndarray  # (4,), from which an orbit stays on it
    lanes: np.ndarray  # numbers of the orbits that end on it
    unit: np.ndarray  # (size,), amplitudes of the components in its system, for distances
    cut: float  # distance from which an end belongs to another attractor
    within: float = 0.0  # largest distance of one of its ends, over `cut`
    margin: float = np.inf  # by which factor `cut` may change before it is divided or joined

    def tree(self, unit: np.ndarray) -> KDTree:
        return KDTree(_scaled(self.points, unit))


@dataclass
class System:
    """The attractors of one system, which `add` extends."""

    sections: Sections
    unit: np.ndarray  # (size,), amplitudes of the components
    attractors: list[Attractor] = field(default_factory=list)

    def add(self, labels: np.ndarray, states: np.ndarray, lanes: np.ndarray) -> None:
        """Group the ends of orbits: their final regimes (n,), states (n, 4) and numbers (n,)."""
        for label in sorted(set(labels.tolist()), key=lambda word: (period_of(word), word)):
            chosen = np.flatnonzero(labels == label)
            if (n := period_of(label)) > 0:
                self._add_periodic(label, n, states[chosen], lanes[chosen])
            elif n == 0:
                self._add_clouds(label, states[chosen], lanes[chosen])
        for one in self.attractors:
            one.margin = 1.0 / max(one.within, 1e-300)
            for other in self.attractors:
                is_same = other.period > 0 or other.label == one.label
                if other is not one and other.period == one.period and is_same:
                    one.margin = min(one.margin, self._gap(one, other) / one.cut)

    def _gap(self, one: Attractor, other: Attractor) -> float:
        """Return the distance of two attractors: least of cycles, smaller median of clouds."""
        measure = np.min if one.period else np.median
        return float(min(measure(each) for each in _distances(one, other, self.unit)))

    def _add_periodic(self, label: str, n: int, states: np.ndarray, lanes: np.ndarray) -> None:
        left, scaled = np.arange(lanes.size), _scaled(states, self.unit)

        def distances(attractor: Attractor) -> np.ndarray:
            return attractor.tree(self.unit).query(scaled[left])[0][:, np.newaxis]

        for attractor in self.attractors:
            if attractor.period == n:
                left = _join([attractor], distances(attractor), lanes, left)
        while left.size:
            state = states[left[0]]
            cycle = self.sections(state[np.newaxis], n)[0]
            new = Attractor(label, n, cycle, state, lanes[left[:1]], self.unit, SAME)
            gaps = distances(new)
            new.within = float(gaps[0, 0]) / SAME
            self.attractors.append(new)
            left = _join([new], gaps[1:], lanes, left[1:])

    def _add_clouds(self, label: str, states: np.ndarray, lanes: np.ndarray) -> None:
        left = np.arange(lanes.size)
        new = [attractor for attractor in self.attractors if attractor.label == label]
        while left.size:
            if new:  # the median distances of the clouds of states to attractors
                trees = [attractor.tree(self.unit) for attractor in new]
                gaps = np.empty((left.size, len(trees)))
                for first in range(0, left.size, 1000):  # so many clouds are in memory
                    some = states[left[first : first + 1000]]
                    clouds = _scaled(self.sections(some, CLOUD), self.unit)
                    for row, cloud in zip(gaps[first:], clouds, strict=False):
                        row[:] = [np.median(tree.query(cloud)[0]) for tree in trees]
                left = _join(new, gaps, lanes, left)
            if left.size:
                few = left[np.linspace(0, left.size - 1, min(PAIRS, left.size)).astype(int)]
                new = self._clustered(label, states[few], lanes[few])
                self.attractors += new
                left = np.setdiff1d(left, few)
        self._merge(label)

    def _merge(self, label: str) -> None:
        """Join attractors of a label that are nearer than `cut`, as orbits found later may show."""
        same = [attractor for attractor in self.attractors if attractor.label == label]
        for one, other in combinations(same, 2):
            gap, cut = self._gap(one, other), max(one.cut, other.cut)
            if gap <= cut:
                one.lanes = np.concatenate([one.lanes, other.lanes])
                one.points = np.concatenate([one.points, other.points])
                one.cut, one.within = cut, max(one.within, other.within, gap / cut)
                self.attractors.remove(other)
                self._merge(label)
                return

    def _clustered(self, label: str, states: np.ndarray, lanes: np.ndarray) -> list[Attractor]:
        """Return the attractors of some clouds: single linkage by the distance of their points."""
        sections = self.sections(states, CLOUD)
        clouds, half = _scaled(sections, self.unit), CLOUD // 2
        trees = [KDTree(cloud) for cloud in clouds]
        gaps = np.array([[np.median(tree.query(cloud)[0]) for tree in trees] for cloud in clouds])
        inside = np.median([KDTree(cloud[:half]).query(cloud[half:])[0] for cloud in clouds])
        size = np.median([np.linalg.norm(cloud.std(axis=0)) for cloud in clouds])
        cut, kinds, heights = max(APART * inside, PART * size, SAME), np.ones(1, int), np.zeros(0)
        if len(clouds) > 1:
            merges = linkage(squareform(np.minimum(gaps, gaps.T), checks=False), "single")
            kinds, heights = fcluster(merges, cut, "distance"), merges[:, 2]
        within = heights[heights <= cut].max(initial=0.0) / cut
        groups = [np.flatnonzero(kinds == kind) for kind in np.unique(kinds)]
        return [
            Attractor(
                label, 0, np.concatenate(sections[group[:CLOUDS]]), states[group[0]], lanes[group],
                self.unit, cut, within,
            )
            for group in groups
        ]  # fmt: skip


def _scaled(states: np.ndarray, unit: np.ndarray) -> np.ndarray:
    return states[..., : unit.size] / unit


def _distances(one: Attractor, other: Attractor, unit: np.ndarray) -> list[np.ndarray]:
    """Return the distances of the points of either attractor from the nearest ones of the other."""
    pairs = ((one, other), (other, one))
    return [a.tree(unit).query(_scaled(b.points, unit))[0] for a, b in pairs]


def _join(
    attractors: Sequence[Attractor], distances: np.ndarray, lanes: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """Assign the ends `left` to the nearest attractors, if near enough; return the remaining ends.

    `distances` has the shape (left, attractors); `lanes` are the numbers of all ends.
    """
    nearest = distances.argmin(axis=1)
    least = distances[np.arange(left.size), nearest]
    joins = least <= np.array([attractor.cut for attractor in attractors])[nearest]
    for i, attractor in enumerate(attractors):
        joining = joins & (nearest == i)
        attractor.lanes = np.concatenate([attractor.lanes, lanes[left[joining]]])
        attractor.within = max(attractor.within, least[joining].max(initial=0.0) / attractor.cut)
    return left[~joins]


def matched(before: Mapping[int, Attractor], now: Sequence[Attractor]) -> dict[int, int]:
    """Return the numbers of attractors `now`, by their index, that continue one `before`.

    It is the cheapest assignment.  A pair is accepted if its step is small beside the distances of
    the other attractors of both systems.
    """
    if not before or not now:
        return {}
    numbers = list(before)
    steps = np.empty((len(numbers), len(now)))
    for (i, number), (j, one) in product(enumerate(numbers), enumerate(now)):
        unit = np.maximum(before[number].unit, one.unit)
        steps[i, j] = max(each.mean() for each in _distances(before[number], one, unit))
    pairs = dict[int, int]()
    for i, j in zip(*linear_sum_assignment(steps), strict=True):
        others = [*np.delete(steps[i], j), *np.delete(steps[:, j], i), FAR / NEAR]
        if steps[i, j] <= NEAR * min(others):
            pairs[int(j)] = numbers[i]
    return pairs


class Numbering:
    """Numbers attractors in one system of a grid of parameters after another.

    An orbit that is carried on from the attractor of a number is the lane ~number.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._shape = shape
        self._last = dict[int, Attractor]()
        self.table = list[dict[int, Attractor]]()

    def absent(self, attractors: Sequence[Attractor]) -> dict[int, Attractor]:
        """Return the neighboring attractors that no attractor of the next system continues."""
        beside = self._beside()
        continued = matched(beside, attractors).values()
        return {number: one for number, one in beside.items() if number not in continued}

    def _beside(self) -> dict[int, Attractor]:
        """Return the attractors one step before the next system along each parameter.

        If several have one number, that of the system before along the last parameter is returned.
        """
        place = np.unravel_index(len(self.table), self._shape) if self._shape else ()
        neighbors = dict[int, Attractor]()
        for axis, index in enumerate(place):
            if index:
                neighbors |= self.table[len(self.table) - prod(self._shape[axis + 1 :])]
        return neighbors

    def give(self, attractors: Sequence[Attractor]) -> None:
        """Number the attractors of the next system.

        An attractor gets the number of a neighbor whose section is close, or from which an orbit
        came; else of one that existed earlier; else a new one.
        """
        beside = self._beside()
        earlier = {k: attractor for k, attractor in self._last.items() if k not in beside}
        numbers, left = dict[int, Attractor](), list(attractors)
        for before in (beside, {}, earlier):
            pairs = matched(before, left)
            for place, attractor in enumerate([] if before else left):
                seeds = [~lane for lane in attractor.lanes[attractor.lanes < 0].tolist()]
                seeds = [k for k in seeds if k not in numbers and k not in pairs.values()]
                if seeds:
                    pairs[place] = seeds[0]
            numbers |= {number: left[place] for place, number in pairs.items()}
            left = [attractor for place, attractor in enumerate(left) if place not in pairs]
        new = max(self._last, default=-1) + 1

        def order(one: Attractor) -> tuple[object, ...]:
            """Sort by n, k and position, which the order of the starts does not change."""
            first = one.points[:, : one.unit.size].min(axis=0).tolist()
            return one.period or np.inf, impacts_of(one.label), one.label, first

        numbers |= dict(enumerate(sorted(left, key=order), new))
        self.table.append(dict(sorted(numbers.items())))
        self._last |= numbers
