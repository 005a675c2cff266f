"""Attractors of a scan: where orbits end, groups of ends in each system, numbers along parameters.

In each system some starts are judged.  The others stop as soon as they come near a cycle of these;
what comes near none is judged, too.  So a cycle that the sample has missed costs time and is not
lost.

Orbits of one system end on one attractor if their ends cannot be told apart: the section point of a
closed orbit lies on the cycle of the other, or two clouds of section points cover each other.
Attractors of neighboring systems have one number if their sections are close.  Both rest on
distances: numbers are matched, not proven, and each attractor has a margin.  They depend on the
results alone, not on how a scan was cut into blocks.

States are those of the kernels, (x1, v1, r, s), of which the first `size` count; of hosts the
components of the state.  Of hosts every orbit is judged, and none stops at a known cycle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise, product
from math import prod
from typing import Any, NamedTuple

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree
from scipy.spatial.distance import squareform

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.bifurcation.request import Scan, state_scales
from nlds_vines.bifurcation.result import own_states
from nlds_vines.engine.batch import Wanted, on_threads, parts_of, records_of
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.records import OK
from nlds_vines.kernels.cells import cycles as kernels
from nlds_vines.model.labels import PERIODIC, finals
from nlds_vines.model.quantities import BY_NAME, recorded
from nlds_vines.runs.progress import Tell
from nlds_vines.scans.block import Block

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
class SystemAttractors:
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
    """Assign the ends `left` to attractors that are near enough; return the remaining ones."""
    nearest = distances.argmin(axis=1)
    least = distances[np.arange(left.size), nearest]
    joins = least <= np.array([attractor.cut for attractor in attractors])[nearest]
    for i, attractor in enumerate(attractors):
        joining = joins & (nearest == i)
        attractor.lanes = np.concatenate([attractor.lanes, lanes[left[joining]]])
        attractor.within = max(attractor.within, least[joining].max(initial=0.0) / attractor.cut)
    return left[~joins]


def matched(before: Mapping[int, Attractor], now: Sequence[Attractor]) -> dict[int, int]:
    """Return the numbers of attractors `now`, by index, that continue one `before`."""
    if not before or not now:
        return {}
    numbers = list(before)
    steps = np.empty((len(numbers), len(now)))
    for (i, number), (j, one) in product(enumerate(numbers), enumerate(now)):
        unit = np.maximum(before[number].unit, one.unit)
        steps[i, j] = max(each.mean() for each in _distances(before[number], one, unit))
    pairs = dict[int, int]()
    # of the cheapest assignment, steps that are small beside the distances of other attractors
    for i, j in zip(*linear_sum_assignment(steps), strict=True):
        others = [*np.delete(steps[i], j), *np.delete(steps[:, j], i), FAR / NEAR]
        if steps[i, j] <= NEAR * min(others):
            pairs[int(j)] = numbers[i]
    return pairs


class Numbering:
    """Numbers attractors in one system of a grid of parameters after another."""

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
        """Return the attractors one step before; of equal numbers that of the last parameter."""
        place = np.unravel_index(len(self.table), self._shape) if self._shape else ()
        neighbors = dict[int, Attractor]()
        for axis, index in enumerate(place):
            if index:
                neighbors |= self.table[len(self.table) - prod(self._shape[axis + 1 :])]
        return neighbors

    def give(self, attractors: Sequence[Attractor]) -> None:
        beside = self._beside()
        earlier = {k: attractor for k, attractor in self._last.items() if k not in beside}
        numbers, left = dict[int, Attractor](), list(attractors)
        # the number of a close neighbor, of one from which an orbit was sent (the lane ~number), or
        # of an earlier one that is close
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


# ---- where orbits end ----------------------------------------------------------------------------


SAMPLE, LEAST = 200, 20  # orbits that are judged first: in all, and in each system at least

RADIUS, GUARD, HALVINGS = 0.02, 0.25, 8
"""Distance from a cycle at which an orbit may stop: in amplitudes, and relative to the distance of
the nearest other cycle; the smaller counts. It is halved until all trial orbits come nearer."""

TRIALS, RETURNS = 48, 8  # trial orbits at this distance, and after how many returns they are nearer
TOGETHER = 500  # orbits that are judged in one call: about a second, and 80 MB of memory at most


class Ends(NamedTuple):
    status: np.ndarray  # (n,)
    labels: np.ndarray  # (n,), final regimes
    states: np.ndarray  # (n, 4)
    periods: np.ndarray  # (n,), of nT; 0 for orbits without a period
    multipliers: np.ndarray  # (n, size, 2)


class KnownCycle(NamedTuple):
    label: str
    points: np.ndarray  # (n, 4)
    weights: np.ndarray  # (4,), of a distance that is 1 where orbits stop


class OrbitEnds:
    def __init__(self, scan: Scan, wanted: Wanted, tell: Tell | None, *, helped: bool) -> None:
        self.scan, self._tell, self.scene = scan, tell, wanted.scene
        self._engine = engine_for(scan.system)
        judged = replace(wanted, want=("regime",))
        self._verdicts = self._engine.runner(judged, tell, of=(), helped=helped)
        energy = replace(wanted, want=("energy",))
        self.energies = self._engine.runner(energy, tell, of=(), helped=False)
        self._known = dict[int, list[KnownCycle]]()

    def arrays(
        self, cells: np.ndarray, starts: np.ndarray, places: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the datasets of orbits, (n, 1, ...) each; attractors are not numbered yet."""
        systems = systems_of(self.scan, places)
        if not self._engine.recognizes_cycles:  # every orbit is judged
            ends = self.judged(cells, starts)
            arrival = self._arrivals(cells, starts, ends)
            return self._datasets(cells, ends.labels, ends.states, arrival, ends.status)
        self._learn(cells, systems)
        labels, states, arrival, status = self._stopped(cells, starts, systems, self._known)
        left = np.flatnonzero((labels == "") & (status == OK))
        if left.size:
            ends = self.judged(cells[left], starts[left])
            status[left], labels[left], states[left] = ends.status, ends.labels, ends.states
            # those that end on cycles are followed again, until they come near these
            cycles, closed = dict[int, list[KnownCycle]](), (ends.periods > 0) & (ends.status == OK)
            for n in np.unique(ends.periods[closed]).tolist():
                some = np.flatnonzero(closed & (ends.periods == n))
                sections = self.sections(cells[left[some]], ends.states[some], n)
                for i, points in zip(left[some].tolist(), sections, strict=True):
                    cycles[i] = [self._cycle(cells[i : i + 1], labels[i], points)]
            late = np.array(sorted(cycles), int)
            arrival[left] = -1
            arrival[late] = self._stopped(cells[late], starts[late], late, cycles)[2]
        return self._datasets(cells, labels, states, arrival, status)

    def _arrivals(self, cells: np.ndarray, starts: np.ndarray, ends: Ends) -> np.ndarray:
        """Return when orbits of hosts come near their cycles, as `_stopped` does; -1 if never."""
        arrival, closed = np.full(len(cells), -1), (ends.periods > 0) & (ends.status == OK)
        most = self.scan.transient + self.scan.periods
        for n in np.unique(ends.periods[closed]).tolist():
            chosen = np.flatnonzero(closed & (ends.periods == n))
            for some in np.split(chosen, range(TOGETHER, len(chosen), TOGETHER)):
                sections = self.sections(cells[some], starts[some], most)
                courses = np.concatenate([starts[some][:, np.newaxis], sections], axis=1)
                points = self.sections(cells[some], ends.states[some], n)
                for i, course, cycle in zip(some.tolist(), courses, points, strict=True):
                    weights = self._cycle(cells[i : i + 1], ends.labels[i], cycle).weights
                    distance = KDTree(weights * cycle).query(weights * course)[0]
                    now, *later = (
                        distance[k * n : len(distance) - (kernels.RETURNS - k) * n]
                        for k in range(kernels.RETURNS + 1)
                    )
                    is_near = now <= 1.0
                    for before, after in pairwise((now, *later)):
                        is_near &= after <= np.maximum(before, kernels.RETURN_ROUND_OFF)
                    arrival[i] = is_near.argmax() if is_near.any() else -1
        return arrival

    def _datasets(
        self,
        cells: np.ndarray,
        labels: np.ndarray,
        states: np.ndarray,
        arrival: np.ndarray,
        status: np.ndarray,
    ) -> dict[str, np.ndarray]:
        labels[status != OK] = "failed"
        values_by_name = {
            "attractor": np.full(len(cells), -1, np.int32),  # numbered when all orbits have ended
            "arrival": arrival,
            "label": labels,
            "status": status,
            "end_state": self.user_states(cells, states),
        }
        return {name: values[:, np.newaxis] for name, values in values_by_name.items()}

    def judged(self, cells: np.ndarray, starts: np.ndarray) -> Ends:
        span, parts = (self.scan.transient, self.scan.periods), []
        for first in range(0, len(cells), TOGETHER):
            some = slice(first, first + TOGETHER)
            out = self._verdicts.run(cells[some, np.newaxis], starts[some], *span)
            verdicts = self._verdicts.verdicts(out, cells[some, np.newaxis])
            names = ("periodicity", "orbit_point", "multipliers")
            periods, points, multipliers = (verdicts[name][:, 0] for name in names)
            labels = finals(verdicts["label"])[:, 0]
            on_cycle = (periods > 0)[:, np.newaxis]
            states = np.where(on_cycle, points, out.buffers.section[:, 0, -1])
            states = self.kernel_states(cells[some], states)
            parts.append(Ends(out.status[:, 0], labels, states, periods, multipliers))
        return Ends(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def user_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return states (n, components) of users of those of kernels."""
        return self._engine.user_states(cells, states)

    def kernel_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return states (n, ...) of kernels of those of users."""
        return self._engine.kernel_states(cells, states)

    def sections(self, cells: np.ndarray, states: np.ndarray, periods: int) -> np.ndarray:
        """Return the sections (n, periods, 4) of orbits in `cells` (n,) from states (n, 4)."""
        section = self._verdicts.sections(cells[:, np.newaxis], states, periods)[:, 0]
        columns = section.reshape(-1, section.shape[-1])
        converted = self.kernel_states(np.repeat(cells, periods), columns)
        return converted.reshape(len(states), periods, -1)

    def system(self, cell: np.ndarray, states: np.ndarray) -> SystemAttractors:
        """Return a system without attractors, with the unit of its ends `states` (n, 4)."""
        return SystemAttractors(
            lambda some, periods: self.sections(np.repeat(cell, len(some)), some, periods),
            self._amplitudes(cell, states),
        )

    def _amplitudes(self, cell: np.ndarray, states: np.ndarray) -> np.ndarray:
        return self._engine.amplitudes(cell, states)

    def _cycle(
        self, cell: np.ndarray, label: str, points: np.ndarray, radius: float = RADIUS
    ) -> KnownCycle:
        """Return the cycle through `points` (n, 4), with a radius in amplitudes."""
        unit, weights = self._amplitudes(cell, points), np.zeros(points.shape[1])
        weights[: unit.size] = 1.0 / (radius * unit)
        return KnownCycle(label, points, weights)

    def _learn(self, cells: np.ndarray, systems: np.ndarray) -> None:
        """Store the cycles on which a sample of starts ends, the same starts in each new system."""
        scan, size = self.scan, sample_size(self.scan)
        numbers, first = np.unique(systems, return_index=True)
        is_new = np.array([number not in self._known for number in numbers.tolist()], bool)
        if not size or not is_new.any():
            return
        new = cells[first[is_new]]
        sides = [1 if axis in scan.parameters else axis.values.size for axis in scan.axes]
        shape = (*sides, scan.starts)
        chosen = np.random.default_rng(0).permutation(prod(shape))[:size]
        *places, lanes = np.unravel_index(np.tile(chosen, len(new)), shape)
        repeated = np.repeat(new, size)
        starts = own_states(scan, repeated, scan.initial(places), lanes, self._tell)
        ends = self.judged(repeated, starts)
        closed = (ends.periods > 0) & (ends.status == OK)
        for i, number in enumerate(numbers[is_new].tolist()):
            some = np.flatnonzero(closed[i * size : (i + 1) * size]) + i * size
            cell, cycles = new[i : i + 1], list[KnownCycle]()
            system = self.system(cell, ends.states[some])
            system.add(ends.labels[some], ends.states[some], some)
            for one in system.attractors:
                tree = one.tree(unit := self._amplitudes(cell, one.points))
                others = [a.points[:, : unit.size] for a in system.attractors if a is not one]
                gaps = [float(tree.query(points / unit)[0].min()) for points in others]
                radius = max(min([RADIUS, *(GUARD * gap for gap in gaps)]), 1e-12)
                # orbits that begin so far from points of the cycle in random directions must come
                # nearer: close to a saddle, its basin is narrow (4T,2 of Set 6 at 7.66 rad/s has
                # 0.0025 amplitudes)
                directions = np.random.default_rng(0).normal(size=(TRIALS, unit.size))
                directions *= unit / np.linalg.norm(directions, axis=1, keepdims=True)
                begin = one.points[np.arange(TRIALS) % len(one.points)]
                for _ in range(HALVINGS):
                    starts = begin.copy()
                    starts[:, : unit.size] += radius * directions
                    if self.scene.grounded:
                        starts[:, 2:] = starts[:, :2]
                    trials = np.repeat(cell, TRIALS)
                    last = self.sections(trials, starts, RETURNS * len(one.points))[:, -1]
                    steps = (last - begin)[:, : unit.size] / unit
                    if (np.linalg.norm(steps, axis=1) < radius).all():
                        break
                    radius *= 0.5
                cycles.append(self._cycle(cell, one.label, one.points, radius))
            self._known[number] = cycles

    def _stopped(
        self,
        cells: np.ndarray,
        starts: np.ndarray,
        systems: np.ndarray,
        cycles_by_system: Mapping[int, Sequence[KnownCycle]],
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Follow orbits to cycles of their systems; return label, point, arrival and status."""
        owners, number = np.unique(systems, return_inverse=True)
        per_system = [cycles_by_system.get(int(owner), ()) for owner in owners]
        cycles = [cycle for group in per_system for cycle in group]
        lengths = [sum(len(cycle.points) for cycle in group) for group in per_system]
        stops = np.cumsum(lengths).astype(np.int64)
        rows = np.stack([stops - lengths, stops], axis=-1)[number]
        sizes = np.array([len(cycle.points) for cycle in cycles], np.int64)
        firsts = np.cumsum(sizes) - sizes
        points = np.concatenate([np.zeros((0, 4)), *(cycle.points for cycle in cycles)])
        weights = np.array([cycle.weights for cycle in cycles]).reshape(-1, 4)
        of_kernels = kernels.Cycles(np.repeat(sizes, sizes), points, np.repeat(weights, sizes, 0))
        drawn = kernels.Drawn(*(np.full(len(cells), -1, np.int64) for _ in range(3)))
        most = self.scan.transient + self.scan.periods
        search = np.ascontiguousarray(rows), of_kernels, most
        parts = parts_of(self.scan.method, self.scene, self.scan.settings)
        arguments = parts, records_of(cells), np.ascontiguousarray(starts), search, drawn
        on_threads(kernels.follow_to_cycles, arguments, len(cells), 16)
        labels, states = np.full(len(cells), "", object), np.full((len(cells), 4), np.nan)
        near = np.flatnonzero(drawn.row >= 0)
        chosen = np.searchsorted(firsts, drawn.row[near], side="right") - 1
        labels[near] = np.array([cycle.label for cycle in cycles], object)[chosen]
        states[near] = points[firsts[chosen]]
        return labels, states, drawn.arrival, drawn.status


def systems_of(scan: Scan, places: np.ndarray) -> np.ndarray:
    """Return the numbers (n,) of the systems to which cells belong, given by place in the scan."""
    where, parameters = np.unravel_index(places, scan.shape), scan.parameters
    chosen = [at for at, axis in zip(where, scan.axes, strict=True) if axis in parameters]
    if not chosen:
        return np.zeros(len(places), np.int64)
    return np.ravel_multi_index(tuple(chosen), tuple(axis.values.size for axis in parameters))


def sample_size(scan: Scan) -> int:
    """Return the number of orbits of each system that are judged first; 0 if stops save nothing."""
    systems = prod(axis.values.size for axis in scan.parameters)
    size = max(LEAST, SAMPLE // systems)
    return size if 2 * size < scan.lanes // systems else 0


NUMBER = "number"  # the dimension that counts attractors


class AttractorTable:
    """The `numbers` (cells ..., starts) of the attractors on which all orbits end, -1 for none.

    `contents` are the attractors as datasets, empty without any; `scales` their dimensions.
    """

    def __init__(
        self,
        ends: OrbitEnds,
        blocks: Iterable[tuple[Block, Mapping[str, np.ndarray]]],
        check: Callable[[], object] = lambda: None,
    ) -> None:
        """Group and number the ends of all orbits; `check` is called between systems."""
        self._ends, self._scan = ends, (scan := ends.scan)
        self._shape = tuple(axis.values.size for axis in scan.parameters)
        first = tuple(slice(None) if axis in scan.parameters else 0 for axis in scan.axes)
        self._cells = scan.cells()[first].ravel()
        components = scan.system.scene.components
        labels = np.full((*scan.shape, scan.starts), "", object)
        states = np.full((*labels.shape, len(components)), np.nan)
        for block, arrays in blocks:  # the regime of a failed orbit is empty
            words = finals(arrays["label"].astype(object))
            labels[block.selection] = np.where(arrays["status"] == OK, words, "")
            states[block.selection] = arrays["end_state"]
        labels, states = labels.ravel(), states.reshape(labels.size, -1)
        systems = systems_of(scan, np.arange(labels.size) // scan.starts)
        order = np.argsort(systems, kind="stable")
        edges = np.searchsorted(systems[order], np.arange(len(self._cells) + 1))
        numbering = Numbering(self._shape)
        for i in range(len(self._cells)):
            check()
            members, cell = order[edges[i] : edges[i + 1]], self._cells[i : i + 1]
            there = ends.kernel_states(np.repeat(cell, members.size), states[members])
            system = ends.system(cell, there[labels[members] != ""])
            system.add(labels[members], there, members)
            if absent := numbering.absent(system.attractors):  # no orbit reaches them: one is sent
                cells, begin = np.repeat(cell, len(absent)), [one.state for one in absent.values()]
                sent = ends.judged(cells, np.array(begin))
                words = np.where(sent.status == OK, sent.labels, "")
                system.add(words, sent.states, ~np.array(list(absent)))
            numbering.give(system.attractors)
        self._rows = [(i, *row) for i, table in enumerate(numbering.table) for row in table.items()]
        self._count = max((number for _, number, _ in self._rows), default=-1) + 1
        numbers = np.full(labels.size, -1, np.int32)
        for _, number, attractor in self._rows:
            numbers[attractor.lanes[attractor.lanes >= 0]] = number
        self.numbers = numbers.reshape(*scan.shape, scan.starts)
        self.contents = list(self._contents()) if self._count else []
        counted = Scale.counted(NUMBER, self._count, "number of an attractor")
        self.scales = [*state_scales(len(components)), counted]

    def _contents(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        scan, scene = self._scan, self._scan.system.scene
        attractors = [attractor for *_, attractor in self._rows]
        systems = np.array([system for system, *_ in self._rows])
        numbers = np.array([number for _, number, _ in self._rows])
        where = (*np.unravel_index(systems, self._shape), numbers) if self._shape else (numbers,)
        dims = (*(axis.name for axis in scan.parameters), NUMBER)
        cells, states = self._cells[systems], np.array([one.state for one in attractors])
        periods = np.array([attractor.period for attractor in attractors])

        def filled(entry: Dataset, values: Any) -> tuple[Dataset, np.ndarray]:
            values = np.asarray(values, object if entry.dtype == "str" else None)
            shape = (*self._shape, self._count, *values.shape[1:])
            table = np.full(shape, entry.fill, values.dtype)
            table[where] = values
            return entry, table

        text = "regime of the attractor; empty where it does not exist"
        yield filled(Dataset.text("attractor_label", dims, text), [one.label for one in attractors])
        text = "n of nT of the attractor; 0 where it is not periodic, -1 where it does not exist"
        yield filled(Dataset.whole("attractor_period", dims, text, -1), periods)
        if scene.walls:
            text = "impacts per nT of the attractor; -1 where it is not periodic"
            entry = Dataset.whole("attractor_impacts", dims, text, -1)
            yield filled(entry, [impacts_of(one.label) for one in attractors])
        text = "a point of the attractor's section; NaN where it is not periodic"
        entry = Dataset.real("attractor_point", (*dims, "component"), "m, m/s", text)
        points = self._ends.user_states(cells, states)
        yield filled(entry, np.where(periods[:, np.newaxis] > 0, points, np.nan))
        size, closed = len(scene.components), np.flatnonzero(periods)
        multipliers = np.full((len(periods), size, 2), np.nan)
        if closed.size:
            ends = self._ends.judged(cells[closed], states[closed])
            is_same = ends.periods == periods[closed]
            multipliers[closed[is_same]] = ends.multipliers[is_same]
        columns = (*dims, "multiplier", "part")
        entry = BY_NAME["multipliers"].dataset(columns, scene, prefix="attractor_")
        yield filled(entry, multipliers)
        # the largest energies, on irregular attractors those of one orbit from its start
        starts = states.copy()
        for i, one in enumerate(attractors):
            if not one.period and one.lanes[0] >= 0:
                place, lane = np.divmod(one.lanes[:1], scan.starts)
                at = np.unravel_index(place, scan.shape)
                starts[i] = own_states(scan, cells[i : i + 1], scan.initial(at), lane)[0]
        energies = np.empty((len(attractors), 1 + max(1, len(scene.dampers))))
        for n in np.unique(periods).tolist():
            some = np.flatnonzero(periods == n)
            span = (0, n) if n else (scan.transient, scan.periods)
            outputs = self._ends.energies.run(cells[some, np.newaxis], starts[some], *span)
            energies[some] = outputs.buffers.energy[:, 0]
        for quantity in recorded(scene, ("energy",)):
            if quantity.buffer == "energy":
                entry = quantity.dataset((*dims, *quantity.dims), scene, prefix="attractor_")
                yield filled(entry, quantity.from_buffer(energies))
        counts = np.array([np.count_nonzero(one.lanes >= 0) for one in attractors])
        text = "share of the cells and starts that are drawn to the attractor"
        entry = Dataset.real("attractor_share", dims, "1", text)
        yield filled(entry, counts * prod(self._shape) / scan.lanes)
        text = "factor by which the distance that divides attractors may change without effect"
        entry = Dataset.real("attractor_margin", dims, "1", text)
        yield filled(entry, [one.margin for one in attractors])
