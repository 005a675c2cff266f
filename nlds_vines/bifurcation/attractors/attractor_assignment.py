"""The record `attractor` of a scan: attractors are learnt, then cells are followed to them."""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.bifurcation.attractors.attractor_additions import Additions, Left, added
from nlds_vines.bifurcation.attractors.attractor_matching import SAME, follow, is_periodic
from nlds_vines.bifurcation.attractors.attractor_numbering import Judge, Learnt, learn
from nlds_vines.bifurcation.cell_start import begun
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.orbits.batch import Wanted
from nlds_vines.orbits.starts import Start, random_states, start_states
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan

SAMPLE, LEAST = 1000, 100
"""Orbits from which attractors are learnt: so many in all, and so many at each system at least."""

_GOLDEN = (0.6180339887498949,), (0.7548776662466927, 0.5698402909980532)
"""Steps of the additive sequences in one and in two dimensions that fill a box most evenly: the
powers of 1 / g with g^2 = g + 1 and g^3 = g + 1."""


def systems_of(scan: Scan) -> tuple[int, ...]:
    """Return the lengths of the parameters of a scan; () for one system."""
    return tuple(axis.values.size for axis in scan.parameters)


def sample_size(scan: Scan) -> int:
    """Return from how many orbits the attractors of each system are learnt."""
    count = max(LEAST, SAMPLE // prod(systems_of(scan)))
    sides = _sides(scan)
    if sides:
        return min(count, prod(sides))
    return count if scan.start.policy == "random" else 1


def learning_orbits(scan: Scan) -> int:
    """Return from how many orbits the attractors of all systems are learnt."""
    return prod(systems_of(scan)) * sample_size(scan)


def _sides(scan: Scan) -> tuple[int, ...]:
    """Return the lengths of the axes of initial conditions."""
    own = scan.parameters
    return tuple(axis.values.size for axis in scan.axes if axis not in own)


def sampled_places(sides: tuple[int, ...], count: int) -> tuple[np.ndarray, ...]:
    """Return `count` places (count,) along each of one or two axes, spread evenly over their box.

    Where the box has no more places than that, they are all of them.
    """
    if prod(sides) <= count:
        return tuple(np.unravel_index(np.arange(prod(sides)), sides))
    k = np.arange(count)
    shares = ((0.5 + step * k) % 1.0 for step in _GOLDEN[len(sides) - 1])
    return tuple((share * n).astype(np.int64) for share, n in zip(shares, sides, strict=True))


class Attracted:
    """Follows the cells of one scan to the attractors that it learns before."""

    def __init__(self, scan: Scan, wanted: Wanted, tell: Tell | None, *, helped: bool) -> None:
        """Prepare for a scan; arguments as those of `compute.Computer`."""
        self._scan, self._learnt, self._tell = scan, None, tell
        self._judge = Judge(wanted, scan.transient, scan.periods, tell, helped=helped)
        count = sample_size(scan)
        self._places = sampled_places(_sides(scan), count) if _sides(scan) else ()
        more = Start("random", max(count, scan.starts), scan.start.seed)
        self._draws = start_states(more)[:count] if scan.start.policy == "random" else None

    _learnt: Learnt | None

    @property
    def learnt(self) -> Learnt:
        """The attractors, learnt now unless they are known."""
        return self.learn()

    def in_words(self) -> str:
        """Return in words what is learnt, and from how many orbits."""
        return f"learning the attractors, from {learning_orbits(self._scan)} orbits"

    def know(self, learnt: Learnt) -> None:
        """Take what was learnt before."""
        self._learnt = learnt

    def learn(self, check: Callable[[], object] = lambda: None) -> Learnt:
        """Learn the attractors, unless they are known; `check` as `attractor_numbering.learn`."""
        if self._learnt is None:
            self._learnt = learn(self._judge, self._cells(), self._sample, check)
        return self._learnt

    def more(
        self,
        learnt: Learnt,
        cells: np.ndarray,
        starts: np.ndarray,
        places: np.ndarray,
        check: Callable[[], object],
    ) -> Additions:
        """Return the attractors of orbits that came to none of those `learnt`, beside these.

        Arguments: `cells`, `starts` and `places` as `arrays` takes them; `check` as `learn`.
        """
        left = Left(cells, starts, self._systems(places))
        return added(self._judge, self._cells(), learnt, left, check)

    def _cells(self) -> np.ndarray:
        """Return the cells of all systems, an axis for each parameter."""
        scan, shape = self._scan, systems_of(self._scan)
        names = (axis.name for axis in scan.parameters)
        grid = np.ix_(*(axis.values for axis in scan.parameters)) if shape else ()
        return scan.system.cells(dict(zip(names, grid, strict=True))).reshape(shape)

    def _sample(self, cell: np.ndarray) -> np.ndarray:
        """Return the sample of starts (n, 4) in a system, whose cell is an array (1,)."""
        scene = self._scan.system.scene
        if self._draws is not None:
            return random_states(cell, self._draws, scene)[0]
        places = iter(self._places)
        own = self._scan.parameters
        zeros = np.zeros(len(self._places[0]) if self._places else 1, np.int64)
        where = [zeros if axis in own else next(places) for axis in self._scan.axes]
        cells = np.repeat(cell, len(zeros))
        return begun(self._scan, cells, self._scan.initial(where), self._tell)

    def arrays(
        self, cells: np.ndarray, starts: np.ndarray, places: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return attractor, arrival, label and status of orbits, (n, 1) each, by name.

        Arguments: `cells` (n,) and `starts` (n, 4); the `places` (n,) of their cells in the scan.
        """
        learnt, systems = self.learnt, self._systems(places)
        rows, known = learnt.rows_of(systems), learnt.known
        drawn = follow(self._judge.parts, cells, starts, rows, known, self._judge.most)
        row, status = drawn.attractor.copy(), drawn.status.copy()
        labels = np.full(len(cells), "failed", object)
        labels[row >= 0] = learnt.labels[row[row >= 0]]
        left = np.flatnonzero((row < 0) & (status == OK))
        if left.size:
            found = self._judge(cells[left], starts[left])
            status[left], labels[left] = found.status, found.labels
            row[left] = learnt.row_with(systems[left], found.labels)
            late = (found.status == OK) & is_periodic(found.evidence)
            late, points = left[late], found.evidence[late, ev.POINT : ev.POINT + 4]
            more = follow(self._judge.parts, cells[late], points, rows[late], known, SAME)
            row[late] = more.attractor
        numbers = np.append(learnt.numbers, -1)  # the last for the row -1
        return {
            "attractor": numbers[row][:, np.newaxis],
            "arrival": drawn.arrival[:, np.newaxis],
            "label": labels[:, np.newaxis],
            "status": status[:, np.newaxis],
        }

    def _systems(self, places: np.ndarray) -> np.ndarray:
        """Return the numbers (n,) of the systems of cells, given by their places in the scan."""
        where, own = np.unravel_index(places, self._scan.shape), self._scan.parameters
        chosen = [at for at, axis in zip(where, self._scan.axes, strict=True) if axis in own]
        if not chosen:
            return np.zeros(len(places), np.int64)
        return np.ravel_multi_index(tuple(chosen), systems_of(self._scan))
