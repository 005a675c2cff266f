"""The attractors of a scan whose orbits have all been followed: numbers, and a table of them.

The table has a row for each number at each value of the parameters.  It depends on the results
alone: neither on how a scan was cut into blocks, nor on which of them were computed when.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive import Piece, whole
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.bifurcation.attractor_ends import kernel_states, systems_of
from nlds_vines.bifurcation.attractors import Attractor, Numbering, System, impacts_of, seed_of
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.datasets import state_scales
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.model.labels import finals
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.batch import multipliers_of
from nlds_vines.orbits.records import ATTRACTOR, OK
from nlds_vines.orbits.starts import user_states

if TYPE_CHECKING:
    from nlds_vines.bifurcation.blocks import Block
    from nlds_vines.bifurcation.request import Scan

NUMBER = "number"
"""The dimension that counts attractors."""


class AttractorTable:
    """The attractors of a scan as datasets."""

    def __init__(
        self,
        scan: Scan,
        blocks: Iterable[tuple[Block, Mapping[str, np.ndarray]]],
        check: Callable[[], object] = lambda: None,
    ) -> None:
        """Group and number the ends of all orbits.

        Arguments: all `blocks`, each with its datasets; `check` is called between systems, and what
        it raises ends the work.
        """
        self._scan, self._computer = scan, Computer(scan, helped=False)
        self._shape = tuple(axis.values.size for axis in scan.parameters)
        grid = np.ix_(*(axis.values for axis in scan.parameters)) if self._shape else ()
        names = (axis.name for axis in scan.parameters)
        self._cells = np.ravel(scan.system.cells(dict(zip(names, grid, strict=True))))
        self._number(*self._collected(blocks), check)
        self._table = list(self._contents()) if self._count else []

    def joined(self) -> Table:
        """Return the datasets of the archive: those of the scan, and those of the attractors."""
        scan, size = self._scan.table, len(self._scan.system.scene.components)
        if not self._count:
            return scan
        lengths = {NUMBER: self._count, "multiplier": size, "part": 2, "component": size}
        datasets = [*scan.datasets.values(), *(entry for entry, _ in self._table)]
        return Table.of(datasets, {**scan.length, **lengths})

    def scales(self) -> list[Scale]:
        """Return the dimensions of the archive with their values."""
        size = len(self._scan.system.scene.components)
        scales = {scale.name: scale for scale in (*state_scales(size), *self._scan.scales())}
        return [*scales.values(), Scale.counted(NUMBER, self._count, "number of an attractor")]

    def patched(self, block: Block, arrays: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """Return the datasets of a block with the numbers of its attractors."""
        return {**arrays, ATTRACTOR: self._numbers[block.selection]}

    def pieces(self) -> Iterator[Piece]:
        """Yield the datasets of the attractors, each as one piece."""
        yield from whole(self._table)

    def _collected(
        self, blocks: Iterable[tuple[Block, Mapping[str, np.ndarray]]]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the final regimes and the end states (components) of all orbits, in their order.

        The regime is empty where an orbit failed.
        """
        scan = self._scan
        labels = np.full((*scan.shape, scan.starts), "", object)
        states = np.full((*labels.shape, len(scan.system.scene.components)), np.nan)
        for block, arrays in blocks:
            words = finals(arrays["label"].astype(object))
            labels[block.selection] = np.where(arrays["status"] == OK, words, "")
            states[block.selection] = arrays["end_state"]
        return labels.ravel(), states.reshape(labels.size, -1)

    def _number(self, labels: np.ndarray, states: np.ndarray, check: Callable[[], object]) -> None:
        """Group the ends of all orbits, and number the attractors along the parameters."""
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
            self._carry(system, cell, numbering)
            numbering.give(system.attractors)
        self._rows = [(i, *row) for i, table in enumerate(numbering.table) for row in table.items()]
        self._count = max((number for _, number, _ in self._rows), default=-1) + 1
        numbers = np.full(labels.size, -1, np.int32)
        for _, number, attractor in self._rows:
            numbers[attractor.lanes[attractor.lanes >= 0]] = number
        self._numbers = numbers.reshape(*scan.shape, scan.starts)

    def _carry(self, system: System, cell: np.ndarray, numbering: Numbering) -> None:
        """Follow an orbit of each neighboring attractor to which no orbit of the system comes."""
        absent = numbering.absent(system.attractors)
        if absent:
            cells, states = np.repeat(cell, len(absent)), [one.state for one in absent.values()]
            ends, seeds = self._ends.judged(cells, np.array(states)), map(seed_of, absent)
            labels = np.where(ends.status == OK, ends.labels, "")
            system.add(labels, ends.states, np.array(list(seeds)))

    @property
    def _ends(self):
        assert self._computer.ends is not None
        return self._computer.ends

    def _contents(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        """Yield the datasets of the attractors with their arrays."""
        scene, attractors = self._scan.system.scene, [attractor for *_, attractor in self._rows]
        systems = np.array([system for system, *_ in self._rows])
        numbers = np.array([number for _, number, _ in self._rows])
        where = (*np.unravel_index(systems, self._shape), numbers) if self._shape else (numbers,)
        dims = (*(axis.name for axis in self._scan.parameters), NUMBER)
        cells, states = self._cells[systems], np.array([one.state for one in attractors])
        periods = np.array([attractor.period for attractor in attractors])

        def filled(entry: Dataset, values: Any) -> tuple[Dataset, np.ndarray]:
            values = np.asarray(values, object if entry.dtype == "str" else None)
            table = np.full(
                (*self._shape, self._count, *values.shape[1:]), entry.fill, values.dtype
            )
            table[where] = values
            return entry, table

        labels = [attractor.label for attractor in attractors]
        text = "regime of the attractor; empty where it does not exist"
        yield filled(Dataset.text("attractor_label", dims, text), labels)
        text = "n of nT of the attractor; 0 where it is not periodic, -1 where it does not exist"
        yield filled(Dataset.whole("attractor_period", dims, text, -1), periods)
        if scene.walls:
            text = "impacts per nT of the attractor; -1 where it is not periodic"
            entry = Dataset.whole("attractor_impacts", dims, text, -1)
            yield filled(entry, [impacts_of(label) for label in labels])
        text = "a point of the attractor's section; NaN where it is not periodic"
        entry = Dataset.real("attractor_point", (*dims, "component"), "m, m/s", text)
        points = user_states(cells, states, scene)
        yield filled(entry, np.where(periods[:, np.newaxis] > 0, points, np.nan))
        dims_of_multipliers = (*dims, "multiplier", "part")
        entry = BY_NAME["multipliers"].dataset(dims_of_multipliers, scene, prefix="attractor_")
        yield filled(entry, self._multipliers(periods, cells, states))
        energies = self._energies(attractors, cells, states)
        for i, name in enumerate(("E1max", "E2max") if scene.damper else ("E1max",)):
            yield filled(BY_NAME[name].dataset(dims, scene, prefix="attractor_"), energies[:, i])
        counts = np.array([np.count_nonzero(one.lanes >= 0) for one in attractors])
        text = "share of the cells and starts that are drawn to the attractor"
        entry = Dataset.real("attractor_share", dims, "1", text)
        yield filled(entry, counts * prod(self._shape) / self._scan.lanes)
        text = "factor by which the distance that divides attractors may change without effect"
        entry = Dataset.real("attractor_margin", dims, "1", text)
        yield filled(entry, [one.margin for one in attractors])

    def _multipliers(
        self, periods: np.ndarray, cells: np.ndarray, states: np.ndarray
    ) -> np.ndarray:
        """Return the Floquet multipliers (n, size, 2) of attractors, NaN where not periodic."""
        size = len(self._scan.system.scene.components)
        multipliers, closed = np.full((len(periods), size, 2), np.nan), np.flatnonzero(periods)
        if closed.size:
            evidence = self._ends.judged(cells[closed], states[closed]).evidence
            is_same = evidence[:, ev.CYCLE_PERIOD] == periods[closed]
            multipliers[closed[is_same]] = multipliers_of(evidence[is_same], size)[0]
        return multipliers

    def _energies(
        self, attractors: list[Attractor], cells: np.ndarray, states: np.ndarray
    ) -> np.ndarray:
        """Return the largest energies (n, 2) of attractors.

        Of one that is not periodic they are those of its first orbit.
        """
        starts, periods = states.copy(), np.array([one.period for one in attractors])
        for i, one in enumerate(attractors):
            if not one.period and one.lanes[0] >= 0:
                starts[i] = self._computer.orbits(one.lanes[:1])[1][0]
        energies = np.empty((len(attractors), 2))
        for n in np.unique(periods).tolist():
            some = np.flatnonzero(periods == n)
            energies[some] = self._ends.energies(cells[some], starts[some], n)
        return energies
