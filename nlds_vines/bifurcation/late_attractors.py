"""The cells of a finished scan whose attractor the sample has missed, with the attractors of these.

They are looked for when all blocks are there, so that it matters neither how a scan was cut into
blocks nor which of them were computed when.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.bifurcation.attractors.attractor_numbering import NOT_PERIODIC, Learnt
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.model.coexistence import finals
from nlds_vines.model.labels import PERIODIC
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.orbits.status_words import OK

if TYPE_CHECKING:
    from nlds_vines.bifurcation.blocks import Block
    from nlds_vines.bifurcation.request import Scan

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
