"""Where the orbits of a scan end, and the attractors that follow from all ends, as datasets.

In each system some starts are judged.  The others stop as soon as they come near a cycle of these;
what comes near none is judged, too.  So a cycle that the sample has missed costs time and is not
lost.  The table of attractors depends on the results alone, not on how a scan was cut into blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nlds_vines.archives.archive import Piece, whole
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.bifurcation.attractors import Attractor, Numbering, System, impacts_of, period_of
from nlds_vines.bifurcation.request import state_scales
from nlds_vines.bifurcation.result import own_states
from nlds_vines.kernels.cells import cycles as kernels
from nlds_vines.kernels.cells.lanes import LAST_STATE
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.model.labels import finals
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.batch import (
    Kernels,
    Wanted,
    labels_from,
    multipliers_of,
    on_threads,
    records_of,
)
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.records import ATTRACTOR, OK
from nlds_vines.orbits.starts import Start, given_states, length_unit, user_states
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.blocks import Block
    from nlds_vines.bifurcation.request import Scan
    from nlds_vines.model.scenes import Scene


SAMPLE, LEAST = 200, 20  # orbits that are judged first: in all, and in each system at least

RADIUS, GUARD, HALVINGS = 0.02, 0.25, 8
"""Distance from a cycle at which an orbit may stop: in amplitudes, and relative to the distance of
the nearest other cycle; the smaller counts. It is halved until all trial orbits come nearer."""

TRIALS, RETURNS = 48, 8  # trial orbits at this distance, and after how many returns they are nearer
TOGETHER = 500  # orbits that are judged in one call: about a second, and 80 MB of memory at most
_FLOOR = 1e-6  # amplitudes below this share of the unit of length are not resolved


class Ends(NamedTuple):
    status: np.ndarray  # (n,)
    labels: np.ndarray  # (n,), final regimes
    states: np.ndarray  # (n, 4)
    evidence: np.ndarray  # (n, COLUMNS)


class Cycle(NamedTuple):
    label: str
    points: np.ndarray  # (n, 4)
    weights: np.ndarray  # (4,), of a distance that is 1 where orbits stop


class OrbitEnds:
    def __init__(self, scan: Scan, wanted: Wanted, tell: Tell | None, *, helped: bool) -> None:
        self.scan, self._tell, self.scene = scan, tell, wanted.scene
        self._verdicts = Kernels(replace(wanted, want=("regime",)), tell, helped=helped)
        self.energies = Kernels(replace(wanted, want=("energy",)), tell, helped=False)
        self._parts = parts_of(wanted.method, wanted.scene, wanted.settings)
        self._known = dict[int, list[Cycle]]()

    def arrays(
        self, cells: np.ndarray, starts: np.ndarray, places: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the datasets of orbits by name, (n, 1, ...) each; attractors are not numbered yet.

        Arguments: `cells` (n,) and `starts` (n, 4); the `places` (n,) of their cells in the scan.
        """
        systems = systems_of(self.scan, places)
        self._learn(cells, systems)
        labels, states, arrival, status = self._stopped(cells, starts, systems, self._known)
        left = np.flatnonzero((labels == "") & (status == OK))
        if left.size:
            ends = self.judged(cells[left], starts[left])
            status[left], labels[left], states[left] = ends.status, ends.labels, ends.states
            # those that end on cycles are followed again, until they come near these
            cycles, periods = dict[int, list[Cycle]](), np.array([*map(period_of, ends.labels)])
            closed = (periods > 0) & (ends.status == OK)
            for n in np.unique(periods[closed]).tolist():
                some = np.flatnonzero(closed & (periods == n))
                sections = self.sections(cells[left[some]], ends.states[some], n)
                for i, points in zip(left[some].tolist(), sections, strict=True):
                    cycles[i] = [self._cycle(cells[i : i + 1], labels[i], points)]
            late = np.array(sorted(cycles), int)
            arrival[left] = -1
            arrival[late] = self._stopped(cells[late], starts[late], late, cycles)[2]
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
        span, parts = (self.scan.transient, self.scan.periods), []
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

    def system(self, cell: np.ndarray, states: np.ndarray) -> System:
        """Return a system without attractors, with the unit of its ends `states` (n, 4)."""
        return System(
            lambda some, periods: self.sections(np.repeat(cell, len(some)), some, periods),
            self._amplitudes(cell, states),
        )

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
        """Return the cycle through `points` (n, 4), with a radius in amplitudes."""
        unit, weights = self._amplitudes(cell, points), np.zeros(4)
        weights[: unit.size] = 1.0 / (radius * unit)
        return Cycle(label, points, weights)

    def _learn(self, cells: np.ndarray, systems: np.ndarray) -> None:
        """Judge a sample of each system without cycles so far, and store the cycles.

        Samples are drawn from the starts of the scan, the same ones in each system.
        """
        scan, size = self.scan, sample_size(self.scan)
        numbers, first = np.unique(systems, return_index=True)
        is_new = np.array([number not in self._known for number in numbers.tolist()], bool)
        if not size or not is_new.any():
            return
        new = cells[first[is_new]]
        sides = [axis.values.size for axis in scan.axes if axis not in scan.parameters]
        chosen = np.random.default_rng(0).permutation(prod(sides) * scan.starts)[:size]
        *places, lanes = np.unravel_index(np.tile(chosen, len(new)), (*sides, scan.starts))
        along = iter(places)
        where = [0 * lanes if axis in scan.parameters else next(along) for axis in scan.axes]
        repeated = np.repeat(new, size)
        ends = self.judged(repeated, own_states(scan, repeated, where, lanes, tell=self._tell))
        closed = np.array([period_of(label) > 0 for label in ends.labels]) & (ends.status == OK)
        for i, number in enumerate(numbers[is_new].tolist()):
            some = np.flatnonzero(closed[i * size : (i + 1) * size]) + i * size
            system = self.system(new[i : i + 1], ends.states[some])
            system.add(ends.labels[some], ends.states[some], some)
            self._known[number] = self._cycles(new[i : i + 1], system.attractors)

    def _cycles(self, cell: np.ndarray, attractors: Sequence[Attractor]) -> list[Cycle]:
        """Return the cycles of attractors, with radii within which orbits come nearer."""
        cycles = list[Cycle]()
        for one in attractors:
            tree = one.tree(unit := self._amplitudes(cell, one.points))
            others = [a.points[:, : unit.size] for a in attractors if a is not one]
            gaps = [float(tree.query(points / unit)[0].min()) for points in others]
            radius = max(min([RADIUS, *(GUARD * gap for gap in gaps)]), 1e-12)
            # orbits that begin so far from points of the cycle in random directions must come
            # nearer: close to a saddle, its basin is narrow (4T,2 of Set 6 at 7.66 rad/s has
            # 0.0025 amplitudes)
            directions = np.random.default_rng(0).normal(size=(TRIALS, unit.size))
            directions *= unit / np.linalg.norm(directions, axis=1, keepdims=True)
            begin, cells = one.points[np.arange(TRIALS) % len(one.points)], np.repeat(cell, TRIALS)
            for _ in range(HALVINGS):
                starts = begin.copy()
                starts[:, : unit.size] += radius * directions
                if self.scene.grounded:
                    starts[:, 2:] = starts[:, :2]
                last = self.sections(cells, starts, RETURNS * len(one.points))[:, -1]
                steps = (last - begin)[:, : unit.size] / unit
                if (np.linalg.norm(steps, axis=1) < radius).all():
                    break
                radius *= 0.5
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
        most = self.scan.transient + self.scan.periods
        search = np.ascontiguousarray(rows), of_kernels, most
        arguments = self._parts, records_of(cells), np.ascontiguousarray(starts), search, drawn
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


def kernel_states(cells: np.ndarray, states: np.ndarray, scene: Scene) -> np.ndarray:
    """Convert states (n, components) of users to those of kernels, (n, 4): x1, v1, r, s."""
    return given_states(cells, Start(), dict(zip(scene.components, states.T, strict=True)), scene)


NUMBER = "number"  # the dimension that counts attractors


class AttractorTable:
    def __init__(
        self,
        ends: OrbitEnds,
        blocks: Iterable[tuple[Block, Mapping[str, np.ndarray]]],
        check: Callable[[], object] = lambda: None,
    ) -> None:
        """Group and number the ends of all orbits; `check` is called between systems."""
        self._ends, self._scan = ends, (scan := ends.scan)
        self._shape = tuple(axis.values.size for axis in scan.parameters)
        grid = np.ix_(*(axis.values for axis in scan.parameters)) if self._shape else ()
        names = (axis.name for axis in scan.parameters)
        self._cells = np.ravel(scan.system.cells(dict(zip(names, grid, strict=True))))
        labels = np.full((*scan.shape, scan.starts), "", object)
        states = np.full((*labels.shape, len(scan.system.scene.components)), np.nan)
        for block, arrays in blocks:  # the regime of a failed orbit is empty
            words = finals(arrays["label"].astype(object))
            labels[block.selection] = np.where(arrays["status"] == OK, words, "")
            states[block.selection] = arrays["end_state"]
        self._number(labels.ravel(), states.reshape(labels.size, -1), check)
        self._table = list(self._contents()) if self._count else []

    def joined(self) -> Table:
        table, size = self._scan.table, len(self._scan.system.scene.components)
        lengths = {NUMBER: self._count, "multiplier": size, "part": 2, "component": size}
        datasets = [*table.datasets.values(), *(entry for entry, _ in self._table)]
        return Table.of(datasets, {**table.length, **lengths}) if self._count else table

    def scales(self) -> list[Scale]:
        size = len(self._scan.system.scene.components)
        scales = {scale.name: scale for scale in (*state_scales(size), *self._scan.scales())}
        return [*scales.values(), Scale.counted(NUMBER, self._count, "number of an attractor")]

    def patched(self, block: Block, arrays: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        return {**arrays, ATTRACTOR: self._numbers[block.selection]}

    def pieces(self) -> Iterator[Piece]:
        yield from whole(self._table)

    def _number(self, labels: np.ndarray, states: np.ndarray, check: Callable[[], object]) -> None:
        scan, lanes = self._scan, np.arange(labels.size)
        systems = systems_of(scan, lanes // scan.starts)
        order = np.argsort(systems, kind="stable")
        edges = np.searchsorted(systems[order], np.arange(len(self._cells) + 1))
        numbering = Numbering(self._shape)
        for i in range(len(self._cells)):
            check()
            members, cell = order[edges[i] : edges[i + 1]], self._cells[i : i + 1]
            there = kernel_states(np.repeat(cell, members.size), states[members], scan.system.scene)
            system = self._ends.system(cell, there[labels[members] != ""])
            system.add(labels[members], there, members)
            if absent := numbering.absent(system.attractors):  # no orbit reaches them: one is sent
                cells, begin = np.repeat(cell, len(absent)), [one.state for one in absent.values()]
                ends = self._ends.judged(cells, np.array(begin))
                words = np.where(ends.status == OK, ends.labels, "")
                system.add(words, ends.states, ~np.array(list(absent)))
            numbering.give(system.attractors)
        self._rows = [(i, *row) for i, table in enumerate(numbering.table) for row in table.items()]
        self._count = max((number for _, number, _ in self._rows), default=-1) + 1
        numbers = np.full(labels.size, -1, np.int32)
        for _, number, attractor in self._rows:
            numbers[attractor.lanes[attractor.lanes >= 0]] = number
        self._numbers = numbers.reshape(*scan.shape, scan.starts)

    def _contents(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        scene, attractors = self._scan.system.scene, [attractor for *_, attractor in self._rows]
        systems = np.array([system for system, *_ in self._rows])
        numbers = np.array([number for _, number, _ in self._rows])
        where = (*np.unravel_index(systems, self._shape), numbers) if self._shape else (numbers,)
        dims = (*(axis.name for axis in self._scan.parameters), NUMBER)
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
        points = user_states(cells, states, scene)
        yield filled(entry, np.where(periods[:, np.newaxis] > 0, points, np.nan))
        size, closed = len(scene.components), np.flatnonzero(periods)
        multipliers = np.full((len(periods), size, 2), np.nan)
        if closed.size:
            evidence = self._ends.judged(cells[closed], states[closed]).evidence
            is_same = evidence[:, ev.CYCLE_PERIOD] == periods[closed]
            multipliers[closed[is_same]] = multipliers_of(evidence[is_same], size)[0]
        columns = (*dims, "multiplier", "part")
        entry = BY_NAME["multipliers"].dataset(columns, scene, prefix="attractor_")
        yield filled(entry, multipliers)
        # the largest energies, on irregular attractors those of one orbit from its start
        starts = states.copy()
        for i, one in enumerate(attractors):
            if not one.period and one.lanes[0] >= 0:
                place, lane = np.divmod(one.lanes[:1], self._scan.starts)
                at = np.unravel_index(place, self._scan.shape)
                starts[i] = own_states(self._scan, cells[i : i + 1], at, lane)[0]
        energies = np.empty((len(attractors), 2))
        for n in np.unique(periods).tolist():
            some = np.flatnonzero(periods == n)
            span = (0, n) if n else (self._scan.transient, self._scan.periods)
            energy = self._ends.energies.run(cells[some, np.newaxis], starts[some], *span).energy
            assert energy is not None
            energies[some] = energy[:, 0]
        for i, name in enumerate(("E1max", "E2max") if scene.damper else ("E1max",)):
            yield filled(BY_NAME[name].dataset(dims, scene, prefix="attractor_"), energies[:, i])
        counts = np.array([np.count_nonzero(one.lanes >= 0) for one in attractors])
        text = "share of the cells and starts that are drawn to the attractor"
        entry = Dataset.real("attractor_share", dims, "1", text)
        yield filled(entry, counts * prod(self._shape) / self._scan.lanes)
        text = "factor by which the distance that divides attractors may change without effect"
        entry = Dataset.real("attractor_margin", dims, "1", text)
        yield filled(entry, [one.margin for one in attractors])
