"""The table of attractors in a scan's archive: a row for each number, at each parameter value.

How many attractors there are is known only when they have been learnt.  So their dimension,
`number`, and their datasets join those of the scan when the archive is made.  Cells whose attractor
the sample has missed are looked for then, too: it matters neither how a scan was cut into blocks
nor which of them were computed when.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.archives.archive import Piece, whole
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.bifurcation.attractors.attractor_assignment import systems_of
from nlds_vines.bifurcation.attractors.attractor_numbering import NOT_PERIODIC, Learnt
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.datasets import state_scales
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.model.labels import PERIODIC, finals
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.evidence import multipliers_of, points_of
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.orbits.status_words import OK

if TYPE_CHECKING:
    from nlds_vines.bifurcation.blocks import Block
    from nlds_vines.bifurcation.request import Scan

NUMBER = "number"
"""The dimension that counts attractors."""

_PREFIX = "attractor_"  # of the names of what scans record as well


class AttractorTable:
    """The attractors of a scan as datasets; shares are counted block by block."""

    def __init__(self, scan: Scan, found: Completed) -> None:
        """Take what is known of attractors when all cells of a scan have been followed."""
        self._scan, self._learnt, self._found = scan, found.learnt, found
        learnt = found.learnt
        self._counts = np.zeros((*systems_of(scan), learnt.count), np.int64)

    def joined(self) -> Table:
        """Return the datasets of the archive: those of the scan, and those of the attractors."""
        own, size = self._scan.table, len(self._scan.system.scene.components)
        if not self._learnt.count:
            return own
        lengths = {NUMBER: self._learnt.count, "multiplier": size, "part": 2, "component": size}
        return Table.of([*own.datasets.values(), *self._datasets()], {**own.length, **lengths})

    def scales(self) -> list[Scale]:
        """Return the dimensions of the archive with their values."""
        found = {
            scale.name: scale for scale in state_scales(len(self._scan.system.scene.components))
        }
        found |= {scale.name: scale for scale in self._scan.scales()}
        return [
            *found.values(),
            Scale.counted(NUMBER, self._learnt.count, "number of an attractor"),
        ]

    def patched(self, block: Block, arrays: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """Return the datasets of a block with the attractors that were found at last."""
        return self._found.patched(self._scan, block, arrays)

    def count(self, block: Block, attractor: np.ndarray) -> None:
        """Count the cells of each attractor in the results of a block, (cells, starts)."""
        own = self._scan.parameters
        places = [
            np.arange(first, stop) if axis in own else np.zeros(stop - first, np.int64)
            for axis, (first, stop) in zip(self._scan.axes, block.slices, strict=True)
        ]
        grids = np.broadcast_arrays(*np.ix_(*places, np.zeros(attractor.shape[-1], np.int64)))
        known = attractor >= 0
        where = [
            grid[known]
            for grid, axis in zip(grids[:-1], self._scan.axes, strict=True)
            if axis in own
        ]
        np.add.at(self._counts, (*where, attractor[known]), 1)

    def pieces(self) -> Iterator[Piece]:
        """Yield the datasets, each as one piece, when all blocks have been counted."""
        if self._learnt.count:
            values = self._values()
            yield from whole((entry, values[entry.name]) for entry in self._datasets())

    def _datasets(self) -> Iterator[Dataset]:
        """Yield the datasets of the attractors."""
        dims = (*(axis.name for axis in self._scan.parameters), NUMBER)
        scene = self._scan.system.scene
        text = "regime of the attractor; empty where it does not exist"
        yield Dataset.text("attractor_label", dims, text)
        text = "n of nT of the attractor; 0 where it is not periodic, -1 where it does not exist"
        yield Dataset.whole("attractor_period", dims, text, -1)
        if scene.walls:
            text = "impacts per nT of the attractor; -1 where it is not periodic"
            yield Dataset.whole("attractor_impacts", dims, text, -1)
        text = "a point of the attractor's section; NaN where it is not periodic"
        yield Dataset.real("attractor_point", (*dims, "component"), "m, m/s", text)
        yield BY_NAME["multipliers"].dataset((*dims, "multiplier", "part"), scene, prefix=_PREFIX)
        for name in ("E1max", "E2max") if scene.damper else ("E1max",):
            yield BY_NAME[name].dataset(dims, scene, prefix=_PREFIX)
        text = "share of the cells and starts that are drawn to the attractor"
        yield Dataset.real("attractor_share", dims, "1", text)

    def _values(self) -> dict[str, np.ndarray]:
        """Return the arrays by name."""
        learnt, scan = self._learnt, self._scan
        shape, size = systems_of(scan), len(scan.system.scene.components)
        where = (
            (*np.unravel_index(learnt.systems, shape), learnt.numbers)
            if shape
            else (learnt.numbers,)
        )

        def filled(values: np.ndarray, fill: object) -> np.ndarray:
            table = np.full((*shape, learnt.count, *values.shape[1:]), fill, values.dtype)
            table[where] = values
            return table

        periods = learnt.known.periods
        impacts = np.nan_to_num(learnt.evidence[:, ev.NEAR_IMPACTS : ev.FAR_IMPACTS + 1]).sum(
            axis=-1
        )
        share = self._counts * (self._counts.size // learnt.count or 1) / scan.lanes
        exists = filled(np.ones(len(periods), bool), False)
        return {
            "attractor_label": filled(learnt.labels.astype(object), ""),
            "attractor_period": filled(periods, -1),
            "attractor_impacts": filled(np.where(periods > 0, impacts, -1).astype(np.int64), -1),
            "attractor_point": filled(points_of(learnt.evidence, size, self._rest()), np.nan),
            "attractor_multipliers": filled(multipliers_of(learnt.evidence, size)[0], np.nan),
            "attractor_E1max": filled(learnt.energies[:, 0], np.nan),
            "attractor_E2max": filled(learnt.energies[:, 1], np.nan),
            "attractor_share": np.where(exists, share, np.nan),
        }

    def _rest(self) -> np.ndarray:
        """Return the rest offset of the spring [m] of the system of each row."""
        scan = self._scan
        grid = np.ix_(*(axis.values for axis in scan.parameters)) if scan.parameters else ()
        names = (axis.name for axis in scan.parameters)
        cells = scan.system.cells(dict(zip(names, grid, strict=True)))
        return cells["rest"].ravel()[self._learnt.systems]


# ---- attractors that the sample has missed -------------------------------------------------------


ARRIVAL = "arrival"


@dataclass(frozen=True, eq=False)
class Completed:
    """What is known of attractors when all cells have been followed.

    Attributes: `learnt`, all attractors; `lanes` (n,), ascending, the numbers in the scan of the
    orbits that have one of the new ones, with its number and the arrival there.
    """

    learnt: Learnt
    lanes: np.ndarray
    numbers: np.ndarray
    arrival: np.ndarray

    def patched(
        self, scan: Scan, block: Block, arrays: Mapping[str, np.ndarray]
    ) -> Mapping[str, np.ndarray]:
        """Return the datasets of a block with the attractors that were found at last."""
        own = _lanes_of(scan, block)
        there = np.isin(own, self.lanes)
        if not there.any():
            return arrays
        rows, found = np.searchsorted(self.lanes, own[there]), dict(arrays)
        for name, values in ((ATTRACTOR, self.numbers), (ARRIVAL, self.arrival)):
            found[name] = arrays[name].copy()
            found[name][there] = values[rows]
        return found


def completed(
    scan: Scan,
    learnt: Learnt,
    blocks: Iterable[tuple[Block, Mapping[str, np.ndarray]]],
    check: Callable[[], object],
) -> Completed:
    """Return the attractors of a scan, with those of cells that came to none of what was `learnt`.

    Arguments: the `blocks`, each with its datasets; `check` as `attractor_numbering.learn`.

    Cost: a plain verdict for each such cell whose regime is known.
    """
    left = [_left(scan, block, arrays) for block, arrays in blocks]
    lanes = np.sort(np.concatenate([np.zeros(0, np.int64), *left]))
    if not lanes.size:
        return Completed(learnt, lanes, lanes, lanes)
    computer = Computer(scan, helped=False)
    assert computer.attracted is not None
    cells, starts, places = computer.orbits(lanes)
    more = computer.attracted.more(learnt, cells[:, 0], starts, places, check)
    return Completed(more.learnt, lanes, more.numbers, more.arrival)


def _lanes_of(scan: Scan, block: Block) -> np.ndarray:
    """Return the numbers of the orbits of a block, cell after cell: rectangle + (starts,)."""
    sides = (np.arange(first, stop) for first, stop in block.slices)
    places = np.ravel_multi_index(np.ix_(*sides), scan.shape)
    return places[..., np.newaxis] * scan.starts + np.arange(scan.starts)


def _left(scan: Scan, block: Block, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the numbers of the orbits of a block that came to no known attractor, but to one."""
    left = (arrays[ATTRACTOR] < 0) & (arrays["status"] == OK)
    if not left.any():
        return np.zeros(0, np.int64)
    labels = finals(arrays["label"][left].astype(object))
    is_one = [word in NOT_PERIODIC or bool(PERIODIC.fullmatch(str(word))) for word in labels]
    return _lanes_of(scan, block)[left][np.array(is_one, bool)]
