"""The attractors of a system, or of one system after another along its parameters, each numbered.

They are those that a sample of starts ends on by plain verdicts.  Along a parameter, each attractor
is followed: an orbit begins on its point at the next value of the parameter, and the attractor on
which that ends has the same number there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from nlds_vines.bifurcation.attractors.attractor_matching import (
    SAME,
    Attractor,
    attractors_in,
    follow,
    is_periodic,
    known_of,
)
from nlds_vines.kernels.cells.cycles import Known
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import Parts
from nlds_vines.model.labels import finals, name_of
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.evidence import labels_from
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.runs.progress import Tell

NOT_PERIODIC = ("chaos", "quasiperiodic")
"""Final regimes that are an attractor by their label alone."""

TOGETHER = 500
"""Orbits that are judged in one call: about a second, and 80 MB of memory at most."""

WANT = ("regime",)
"""What the kernels of a verdict record."""

_OF_ITSELF = ("systems", "numbers", "labels", "evidence", "energies")
"""The arrays of what is learnt, beside those for the kernels."""


@dataclass(frozen=True, eq=False)
class Learnt:
    """The attractors of systems that stand in a row, a row of each array for each attractor.

    Attributes:
        systems: (m,) the number of the system, ascending.
        numbers: (m,) of the attractors: the same number is the same attractor of other systems.
        labels: (m,) the regimes, strings.
        evidence: (m, COLUMNS) of their verdicts, NaN for what is not periodic.
        energies: (m, 2) their largest E1 and E2 [J]: over the orbit, or over the sampled periods of
            the first orbit found of what is not periodic.
        known: what the kernels take of them; what is not periodic has no region.
    """

    systems: np.ndarray
    numbers: np.ndarray
    labels: np.ndarray
    evidence: np.ndarray
    energies: np.ndarray
    known: Known

    @property
    def count(self) -> int:
        """How many numbers there are: one more than the greatest."""
        return int(self.numbers.max(initial=-1)) + 1

    def rows_of(self, systems: np.ndarray) -> np.ndarray:
        """Return the first row of each of some systems, and the one after its last: (n, 2)."""
        sides = (np.searchsorted(self.systems, systems, side) for side in ("left", "right"))
        return np.stack(list(sides), axis=-1).astype(np.int64)

    def row_with(self, systems: np.ndarray, labels: np.ndarray) -> np.ndarray:
        """Return the rows (n,) of what is not periodic, by system and label; -1 for none."""
        rows = {
            (int(self.systems[i]), str(self.labels[i])): i
            for i in np.flatnonzero(np.isin(self.labels.astype(np.str_), NOT_PERIODIC))
        }
        pairs = zip(systems.tolist(), labels.tolist(), strict=True)
        return np.array([rows.get((system, str(label)), -1) for system, label in pairs], np.int64)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return all of it as arrays by name, to be stored."""
        own = {name: getattr(self, name) for name in _OF_ITSELF if name != "labels"}
        return own | {"labels": self.labels.astype(np.str_)} | self.known._asdict()

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Learnt:
        """Return what `arrays` has stored; KeyError or ValueError for anything else.

        Kernels get copies: arrays that cannot be written to are of another type, and would have
        them compiled again.
        """
        own = {name: arrays[name] for name in _OF_ITSELF}
        found = cls(**own, known=Known(**{name: arrays[name].copy() for name in Known._fields}))
        if len({len(array) for array in arrays.values()}) != 1:
            raise ValueError("its arrays are of different lengths")
        return found


@dataclass(frozen=True)
class Verdicts:
    """Plain verdicts of orbits (n,): how they ended, their evidence (n, COLUMNS), final regimes."""

    status: np.ndarray
    evidence: np.ndarray
    labels: np.ndarray


class Judge:
    """Plain verdicts on orbits of one scene, as a scan has them."""

    def __init__(
        self,
        wanted: Wanted,
        transient: int,
        periods: int,
        tell: Tell | None = None,
        *,
        helped: bool = True,
    ) -> None:
        """Take scene, method, effort and settings of what is `wanted`, and the forcing periods."""
        alone = replace(wanted, want=WANT)
        self._kernels = Kernels(alone, tell, helped=helped)
        self._of_energy = Kernels(replace(wanted, want=("energy",)), tell, helped=False)
        self._span = transient, periods
        self.scene: Scene = wanted.scene
        self.parts: Parts = parts_of(wanted.method, wanted.scene, wanted.settings)

    @property
    def most(self) -> int:
        """The forcing periods of an orbit: passed over and sampled."""
        return sum(self._span)

    def __call__(self, cells: np.ndarray, starts: np.ndarray) -> Verdicts:
        """Return the verdicts on orbits in `cells` (n,) from `starts` (n, 4)."""
        firsts = range(0, max(1, len(cells)), TOGETHER)
        some = [self._some(cells[i : i + TOGETHER], starts[i : i + TOGETHER]) for i in firsts]
        columns = ([getattr(one, name) for one in some] for name in vars(some[0]))
        return Verdicts(*map(np.concatenate, columns))

    def energies(self, cell: np.ndarray, start: np.ndarray, n: int) -> np.ndarray:
        """Return the largest E1 and E2 (2,) [J] of an orbit in a system, whose cell is (1,).

        Arguments: its `start` (4,); its period is `n` T, 0: it has none, and is looked at over the
        sampled periods.
        """
        span = (0, n) if n else self._span
        energy = self._of_energy.run(cell[:, np.newaxis], start[np.newaxis], *span).energy
        assert energy is not None
        return np.array(energy[0, 0])

    def _some(self, cells: np.ndarray, starts: np.ndarray) -> Verdicts:
        found = self._kernels.run(cells[:, np.newaxis], starts, *self._span)
        assert found.evidence is not None
        labels = labels_from(found.status, found.evidence, found.by_wall)
        return Verdicts(found.status[:, 0], found.evidence[:, 0], finals(labels)[:, 0])


class Found(NamedTuple):
    """An attractor of one system: its number, its label, and its orbit, None if not periodic.

    Then `start` (4,) is that of an orbit that comes to it.
    """

    number: int
    label: str
    orbit: Attractor | None
    start: np.ndarray


def learn(
    judge: Judge,
    cells: np.ndarray,
    starts: Callable[[np.ndarray], np.ndarray],
    check: Callable[[], object] = lambda: None,
) -> Learnt:
    """Return the attractors of systems along their parameters.

    Arguments: the `judge` of orbits; the `cells` of the systems, an axis for each parameter;
    `starts` returns the sample (n, 4) of one cell, given as an array (1,); `check` is called
    between systems, and what it raises ends the work.

    Cost: a plain verdict for each start of the sample in each system, and some hundred orbits of a
    few periods for each attractor.
    """
    flat, found, by_label = cells.ravel(), list[list[Found]](), dict[str, int]()
    verdicts = _samples(judge, flat, starts, check)
    used = 0
    for system, sample in enumerate(verdicts):
        check()
        before = _before(found, cells.shape, system)
        cell = flat[system : system + 1]
        seeds = seeds_of(cell, before, flat)
        own = judge(np.repeat(cell, len(seeds)), seeds) if len(seeds) else None
        rows = sample.evidence[sample.status == OK]
        if own is not None:
            rows = np.concatenate([own.evidence[own.status == OK], rows])
        orbits = attractors_in(judge.parts, cell[0], rows)
        labels = dict(not_periodic(sample, starts(cell)))
        if own is not None:
            labels = dict(not_periodic(own, seeds)) | labels
        came = came_to(judge.parts, cell, own, orbits, before)
        found.append(numbered(orbits, labels, came, by_label, used))
        used = max([used, *(entry.number + 1 for entry in found[-1])])
    return learnt_of(judge, flat, found)


def not_periodic(found: Verdicts, starts: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the labels of orbits that are not periodic, each with the first start (4,) to it."""
    for label in NOT_PERIODIC:
        places = np.flatnonzero(found.labels == label)
        if places.size:
            yield label, starts[places[0]]


def label_of(orbit: Attractor) -> str:
    """Return the label nT,k of a periodic attractor."""
    return name_of(orbit.periods, int(orbit.row[ev.NEAR_IMPACTS : ev.FAR_IMPACTS + 1].sum()))


def _samples(
    judge: Judge,
    flat: np.ndarray,
    starts: Callable[[np.ndarray], np.ndarray],
    check: Callable[[], object],
) -> Iterator[Verdicts]:
    """Yield the verdicts on the sample of each system; those of several are judged together."""
    size = len(starts(flat[:1]))
    some = max(1, TOGETHER // size)
    for first in range(0, len(flat), some):
        check()
        cells = flat[first : first + some]
        states = np.concatenate([starts(cells[i : i + 1]) for i in range(len(cells))])
        all_of = judge(np.repeat(cells, size), states)
        for i in range(len(cells)):
            own = slice(i * size, (i + 1) * size)
            yield Verdicts(all_of.status[own], all_of.evidence[own], all_of.labels[own])


def _before(
    found: Sequence[Sequence[Found]], shape: tuple[int, ...], system: int
) -> list[tuple[int, Found]]:
    """Return the periodic attractors of the systems one step before, each number once.

    With each of them comes the number of its system; the last parameter is stepped back first.
    """
    place, known = np.unravel_index(system, shape) if shape else (), dict[int, int]()
    entries = list[tuple[int, Found]]()
    for axis in reversed(range(len(shape))):
        if place[axis]:
            there = list(place)
            there[axis] -= 1
            other = int(np.ravel_multi_index(there, shape))
            for entry in found[other]:
                if entry.orbit is not None and known.setdefault(entry.number, other) == other:
                    entries.append((other, entry))
    return entries


def seeds_of(cell: np.ndarray, before: Sequence[tuple[int, Found]], flat: np.ndarray) -> np.ndarray:
    """Return the points (n, 4) of attractors of other systems as starts: x2 is carried over."""
    states = np.zeros((len(before), 4))
    for row, (other, entry) in zip(states, before, strict=True):
        row[:] = entry.start
        row[2] += cell["rest"][0] - flat["rest"][other]
    return states


def came_to(
    parts: Parts,
    cell: np.ndarray,
    own: Verdicts | None,
    orbits: Sequence[Attractor],
    before: Sequence[tuple[int, Found]],
) -> list[tuple[int, Found]]:
    """Return which of the `orbits`, by its place, each attractor of `before` has led to."""
    if own is None or not orbits:
        return []
    there = np.flatnonzero((own.status == OK) & is_periodic(own.evidence)).tolist()
    points = own.evidence[there, ev.POINT : ev.POINT + 4]
    rows = np.tile([0, len(orbits)], (len(there), 1))
    drawn = follow(parts, np.repeat(cell, len(there)), points, rows, known_of(orbits), SAME)
    pairs = zip(there, drawn.attractor.tolist(), strict=True)
    return [(place, before[i][1]) for i, place in pairs if place >= 0]


def numbered(
    orbits: Sequence[Attractor],
    labels: Mapping[str, np.ndarray],
    came: Sequence[tuple[int, Found]],
    by_label: dict[str, int],
    used: int,
) -> list[Found]:
    """Return the attractors of a system with their numbers, in their order.

    An attractor has the number of the one that leads to it; of several, of the first with its
    label, or else of the first.  Others have new numbers from `used` on, ordered by n and k of
    nT,k; then what is not periodic, by `labels` with a start to each, whose numbers are kept in
    `by_label`.
    """
    numbers: dict[int, int] = {}
    for same in (True, False):
        for place, old in came:
            fits = not same or label_of(orbits[place]) == old.label
            if fits and place not in numbers and old.number not in numbers.values():
                numbers[place] = old.number

    def order(place: int) -> tuple[int, float, int]:
        return (
            orbits[place].periods,
            orbits[place].row[ev.NEAR_IMPACTS : ev.FAR_IMPACTS + 1].sum(),
            place,
        )

    for place in sorted(set(range(len(orbits))) - numbers.keys(), key=order):
        numbers[place], used = used, used + 1
    found = [
        Found(numbers[i], label_of(orbit), orbit, orbit.point) for i, orbit in enumerate(orbits)
    ]
    for label in sorted(labels):
        if label not in by_label:
            by_label[label], used = used, used + 1
        found.append(Found(by_label[label], label, None, labels[label]))
    return sorted(found, key=lambda entry: entry.number)


def learnt_of(judge: Judge, flat: np.ndarray, found: Sequence[Sequence[Found]]) -> Learnt:
    """Return the attractors of all systems, whose cells are `flat`, as arrays."""
    rows = [(system, entry) for system, entries in enumerate(found) for entry in entries]
    nothing = np.full(ev.LENGTH_OF_ROW, np.nan)
    orbits = [entry.orbit for _, entry in rows]
    return Learnt(
        systems=np.array([system for system, _ in rows], np.int64),
        numbers=np.array([entry.number for _, entry in rows], np.int64),
        labels=np.array([entry.label for _, entry in rows], np.str_),
        evidence=np.array(
            [nothing if orbit is None else orbit.row for orbit in orbits], float
        ).reshape(-1, ev.LENGTH_OF_ROW),
        energies=np.array([_energies(judge, flat, *row) for row in rows], float).reshape(-1, 2),
        known=known_of(orbits),
    )


def _energies(judge: Judge, flat: np.ndarray, system: int, entry: Found) -> np.ndarray:
    """Return the largest energies (2,) of an attractor of a system."""
    periods = 0 if entry.orbit is None else entry.orbit.periods
    return judge.energies(flat[system : system + 1], entry.start, periods)
