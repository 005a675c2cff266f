"""Where the orbits of a scan end: with an early stop near cycles that a sample has come to.

In each system some starts are judged.  The others stop as soon as they come near a
cycle of these; what comes near none is judged, too.  So a cycle that the sample has missed costs
time and is not lost.  To which attractor an end belongs is decided later (`attractor_table`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nlds_vines.bifurcation.attractors import System, period_of
from nlds_vines.bifurcation.cell_start import own_states
from nlds_vines.kernels.cells import cycles as kernels
from nlds_vines.kernels.cells.lanes import LAST_STATE
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.labels import finals
from nlds_vines.orbits.batch import Kernels, Wanted, labels_from, on_threads, records_of
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.starts import (
    Start,
    given_states,
    length_unit,
    user_states,
)
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan
    from nlds_vines.model.scenes import Scene

SAMPLE, LEAST = 200, 20
"""Orbits that are judged before others may stop early: in all, and in each system at least."""

RADIUS, GUARD, HALVINGS = 0.02, 0.25, 8
"""Distance from a cycle at which an orbit may stop: in amplitudes, and relative to the distance of
the nearest other cycle; the smaller counts. It is halved until all trial orbits come nearer."""

TRIALS, RETURNS = 48, 8
"""Orbits that begin at this distance from a cycle, and after how many returns they are nearer."""

TOGETHER = 500
"""Orbits that are judged in one call: about a second, and 80 MB of memory at most."""

_FLOOR = 1e-6  # amplitudes below this share of the unit of length are not resolved


class Ends(NamedTuple):
    """Ends of orbits (n,): final regime, state (n, 4), and what a verdict rests on (n, COLUMNS)."""

    status: np.ndarray
    labels: np.ndarray
    states: np.ndarray
    evidence: np.ndarray


class Cycle(NamedTuple):
    """A cycle near which orbits stop: points (n, 4), weights (4,) of a distance that is 1 there."""

    label: str
    points: np.ndarray
    weights: np.ndarray


class OrbitEnds:
    """Follows the orbits of one scan to their ends."""

    def __init__(self, scan: Scan, wanted: Wanted, tell: Tell | None, *, helped: bool) -> None:
        """Prepare for a scan; arguments as those of `compute.Computer`."""
        self._scan, self._tell, self.scene = scan, tell, wanted.scene
        self._verdicts = Kernels(replace(wanted, want=("regime",)), tell, helped=helped)
        self._energies = Kernels(replace(wanted, want=("energy",)), tell, helped=False)
        self._parts = parts_of(wanted.method, wanted.scene, wanted.settings)
        self._known = dict[int, list[Cycle]]()

    def arrays(
        self, cells: np.ndarray, starts: np.ndarray, places: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the datasets of orbits by name, (n, 1, ...) each; no attractor has a number yet.

        Arguments: `cells` (n,) and `starts` (n, 4); the `places` (n,) of their cells in the scan.
        """
        systems = systems_of(self._scan, places)
        self._learn(cells, systems)
        labels, states, arrival, status = self._stopped(cells, starts, systems, self._known)
        left = np.flatnonzero((labels == "") & (status == OK))
        if left.size:
            ends = self.judged(cells[left], starts[left])
            status[left], labels[left], states[left] = ends.status, ends.labels, ends.states
            arrival[left] = self._late(cells[left], starts[left], ends)
        labels[status != OK] = "failed"
        values_by_name = {
            "attractor": np.full(len(cells), -1, np.int32),
            "arrival": arrival,
            "label": labels,
            "status": status,
            "end_state": user_states(cells, states, self.scene),
        }
        return {name: values[:, np.newaxis] for name, values in values_by_name.items()}

    def judged(self, cells: np.ndarray, starts: np.ndarray) -> Ends:
        """Return the verdicts on orbits in `cells` (n,) from `starts` (n, 4)."""
        span, parts = (self._scan.transient, self._scan.periods), []
        for first in range(0, len(cells), TOGETHER):
            some = slice(first, first + TOGETHER)
            out = self._verdicts.run(cells[some, np.newaxis], starts[some], *span)
            assert out.evidence is not None
            assert out.ends is not None
            labels = finals(labels_from(out.status, out.evidence, out.by_wall))[:, 0]
            evidence, states = out.evidence[:, 0], out.ends[:, 0, LAST_STATE, :4].copy()
            closed = np.array([period_of(label) > 0 for label in labels], bool)
            states[closed] = evidence[closed, ev.POINT : ev.POINT + 4]
            parts.append(Ends(out.status[:, 0], labels, states, evidence))
        return Ends(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def sections(self, cells: np.ndarray, states: np.ndarray, periods: int) -> np.ndarray:
        """Return the sections (n, periods, 4) of orbits in `cells` (n,) from states (n, 4)."""
        section = self._verdicts.sections(cells[:, np.newaxis], states, periods)[:, 0]
        columns = section.reshape(-1, section.shape[-1])
        converted = kernel_states(np.repeat(cells, periods), columns, self.scene)
        return converted.reshape(len(states), periods, 4)

    def energies(self, cells: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the largest E1 and E2 (n, 2) [J] over an nT orbit; over a scan's periods for 0."""
        span = (0, periods) if periods else (self._scan.transient, self._scan.periods)
        energy = self._energies.run(cells[:, np.newaxis], starts, *span).energy
        assert energy is not None
        return energy[:, 0]

    def system(self, cell: np.ndarray, states: np.ndarray) -> System:
        """Return a system without attractors, whose unit is that of its ends (n, 4)."""

        def sections(some: np.ndarray, periods: int) -> np.ndarray:
            return self.sections(np.repeat(cell, len(some)), some, periods)

        return System(sections, self._amplitudes(cell, states))

    def _amplitudes(self, cell: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the amplitudes (size,) of the components of states (n, 4) in a cell (1,)."""
        size, omega = len(self.scene.components), float(cell["omega"][0])
        floor = max(_FLOOR * float(length_unit(cell)[0]), 1e-9 * abs(float(cell["rest"][0])))
        pairs = np.hypot(states[:, ::2], states[:, 1::2] / omega)  # of x1, v1 and of r, s
        lengths = np.maximum(pairs.max(axis=0, initial=0.0), floor)
        return (lengths[:, np.newaxis] * np.array([1.0, omega])).ravel()[:size]

    def _cycle(
        self, cell: np.ndarray, label: str, points: np.ndarray, radius: float = RADIUS
    ) -> Cycle:
        """Return a cycle, given by its points (n, 4), with a radius in amplitudes."""
        unit, weights = self._amplitudes(cell, points), np.zeros(4)
        weights[: unit.size] = 1.0 / (radius * unit)
        return Cycle(label, points, weights)

    def _safe_radius(self, cell: np.ndarray, points: np.ndarray, radius: float) -> float:
        """Return the largest radius, halved from `radius`, from which all trial orbits come nearer.

        They begin in random directions from the points of a cycle, in turn.  Close to a saddle,
        the basin of a cycle is narrow: 4T,2 of Set 6 at 7.66 rad/s has 0.0025 amplitudes.
        """
        unit, size = self._amplitudes(cell, points), len(self.scene.components)
        directions = np.random.default_rng(0).normal(size=(TRIALS, size))
        directions *= unit / np.linalg.norm(directions, axis=1, keepdims=True)
        cells, begin = np.repeat(cell, TRIALS), points[np.arange(TRIALS) % len(points)]
        for _ in range(HALVINGS):
            starts = begin.copy()
            starts[:, :size] += radius * directions
            if self.scene.grounded:
                starts[:, 2:] = starts[:, :2]
            ends = self.sections(cells, starts, RETURNS * len(points))[:, -1]
            steps = (ends - begin)[:, :size] / unit
            if (np.linalg.norm(steps, axis=1) < radius).all():
                break
            radius *= 0.5
        return radius

    def _learn(self, cells: np.ndarray, systems: np.ndarray) -> None:
        """Judge the samples of systems that are not known yet, and keep their cycles."""
        size = sample_size(self._scan)
        numbers, first = np.unique(systems, return_index=True)
        is_new = np.array([number not in self._known for number in numbers.tolist()], bool)
        if not size or not is_new.any():
            return
        representatives = cells[first[is_new]]
        ends = self.judged(np.repeat(representatives, size), self._sample(representatives, size))
        for i, number in enumerate(numbers[is_new].tolist()):
            some = Ends(*(column[i * size : (i + 1) * size] for column in ends))
            self._known[number] = self._cycles(representatives[i : i + 1], some)

    def _sample(self, cells: np.ndarray, size: int) -> np.ndarray:
        """Return the starts (systems size, 4) that are judged in systems, given by one cell each.

        They are drawn from the starts of the scan, the same ones in each system.
        """
        scan = self._scan
        sides = [axis.values.size for axis in scan.axes if axis not in scan.parameters]
        chosen = np.random.default_rng(0).permutation(prod(sides) * scan.starts)[:size]
        *places, lanes = np.unravel_index(np.tile(chosen, len(cells)), (*sides, scan.starts))
        along = iter(places)
        where = [0 * lanes if axis in scan.parameters else next(along) for axis in scan.axes]
        return own_states(scan, np.repeat(cells, size), where, lanes, tell=self._tell)

    def _cycles(self, cell: np.ndarray, ends: Ends) -> list[Cycle]:
        """Return the cycles that orbits of a system have ended on."""
        closed = np.flatnonzero(_is_closed(ends))
        system = self.system(cell, ends.states[closed])
        system.add(ends.labels[closed], ends.states[closed], closed)
        cycles = list[Cycle]()
        for one in system.attractors:
            tree = one.tree(unit := self._amplitudes(cell, one.points))
            others = [a.points[:, : unit.size] for a in system.attractors if a is not one]
            gaps = [float(tree.query(points / unit)[0].min()) for points in others]
            radius = max(min([RADIUS, *(GUARD * gap for gap in gaps)]), 1e-12)
            radius = self._safe_radius(cell, one.points, radius)
            cycles.append(self._cycle(cell, one.label, one.points, radius))
        return cycles

    def _stopped(
        self,
        cells: np.ndarray,
        starts: np.ndarray,
        systems: np.ndarray,
        cycles_by_system: Mapping[int, Sequence[Cycle]],
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Follow orbits until they come near cycles of their systems.

        Returns the cycle's label (n,), "" if there is none, a point of it (n, 4), the periods until
        then, -1 if there is none, and the status.
        """
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
        most = self._scan.transient + self._scan.periods
        search = np.ascontiguousarray(rows), of_kernels, most
        arguments = self._parts, records_of(cells), np.ascontiguousarray(starts), search, drawn
        on_threads(kernels.follow_to_cycles, arguments, len(cells), 16)
        labels, states = np.full(len(cells), "", object), np.full((len(cells), 4), np.nan)
        near = np.flatnonzero(drawn.row >= 0)
        chosen = np.searchsorted(firsts, drawn.row[near], side="right") - 1
        labels[near] = np.array([cycle.label for cycle in cycles], object)[chosen]
        states[near] = points[firsts[chosen]]
        return labels, states, drawn.arrival, drawn.status

    def _late(self, cells: np.ndarray, starts: np.ndarray, ends: Ends) -> np.ndarray:
        """Return the arrivals (n,) of orbits near the cycles on which they end, -1 for others."""
        cycles, periods = dict[int, list[Cycle]](), np.array([*map(period_of, ends.labels)])
        for n in np.unique(periods[_is_closed(ends)]).tolist():
            chosen = np.flatnonzero(_is_closed(ends) & (periods == n))
            sections = self.sections(cells[chosen], ends.states[chosen], n)
            for i, points in zip(chosen.tolist(), sections, strict=True):
                cycles[i] = [self._cycle(cells[i : i + 1], ends.labels[i], points)]
        late, arrival = np.array(sorted(cycles), int), np.full(len(cells), -1)
        arrival[late] = self._stopped(cells[late], starts[late], late, cycles)[2]
        return arrival


def _is_closed(ends: Ends) -> np.ndarray:
    """Return which orbits (n,) end on a cycle."""
    closed = np.array([period_of(label) > 0 for label in ends.labels], bool)
    return closed & (ends.status == OK)


def systems_of(scan: Scan, places: np.ndarray) -> np.ndarray:
    """Return the numbers (n,) of the systems of cells, given by their places in the scan."""
    where, parameters = np.unravel_index(places, scan.shape), scan.parameters
    chosen = [at for at, axis in zip(where, scan.axes, strict=True) if axis in parameters]
    if not chosen:
        return np.zeros(len(places), np.int64)
    return np.ravel_multi_index(tuple(chosen), tuple(axis.values.size for axis in parameters))


def sample_size(scan: Scan) -> int:
    """Return how many orbits of each system are judged first; 0 where early stops save nothing."""
    systems = prod(axis.values.size for axis in scan.parameters)
    size = max(LEAST, SAMPLE // systems)
    return size if 2 * size < scan.lanes // systems else 0


def kernel_states(cells: np.ndarray, states: np.ndarray, scene: Scene) -> np.ndarray:
    """Return user's states (n, components) as kernels take them: (n, 4), x1, v1, r, s."""
    return given_states(cells, Start(), dict(zip(scene.components, states.T, strict=True)), scene)
