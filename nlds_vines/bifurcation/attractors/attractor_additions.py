"""Attractors that a sample of starts has missed, learnt from the orbits that came to none.

They get numbers as those of the sample do: along a parameter an attractor has the number of the one
that leads to it, from the value before or the value after.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
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
from nlds_vines.bifurcation.attractors.attractor_numbering import (
    Found,
    Judge,
    Learnt,
    Verdicts,
    came_to,
    learnt_of,
    not_periodic,
    numbered,
    seeds_of,
)
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK


class Left(NamedTuple):
    """Orbits that came to no known attractor: cells (n,), starts (n, 4), systems (n,)."""

    cells: np.ndarray
    starts: np.ndarray
    systems: np.ndarray


class Additions(NamedTuple):
    """What more is known.

    Fields: `learnt`, with the new attractors; of each orbit that was left, (n,), the number of its
    attractor, -1 for none, and its arrival.
    """

    learnt: Learnt
    numbers: np.ndarray
    arrival: np.ndarray


def added(
    judge: Judge,
    systems: np.ndarray,
    learnt: Learnt,
    left: Left,
    check: Callable[[], object] = lambda: None,
) -> Additions:
    """Return the attractors of orbits that are `left`, beside those that are known.

    Arguments: the `judge` of orbits; the cells of all `systems`, an axis for each parameter; what
    was `learnt` from a sample; `check` is called between systems, and what it raises ends the work.

    It depends on these orbits alone, in their order.  Cost: a plain verdict for each of them.
    """
    flat, there = systems.ravel(), judge(left.cells, left.starts)
    found: list[list[Found]] = [[] for _ in flat]
    numbers, arrival = np.full((2, len(left.systems)), -1)
    by_label, used = _by_label(learnt), learnt.count
    for system in np.unique(left.systems).tolist():
        check()
        own, cell = np.flatnonzero(left.systems == system), flat[system : system + 1]
        verdicts = Verdicts(there.status[own], there.evidence[own], there.labels[own])
        orbits = attractors_in(judge.parts, cell[0], verdicts.evidence[verdicts.status == OK])
        known = _known_in(learnt, system)
        came = _same(judge, cell, orbits, known)
        beside = _beside(learnt, found, systems.shape, system)
        came += _came_from_beside(judge, flat, system, orbits, beside)
        labels = dict(not_periodic(verdicts, left.starts[own]))
        entries = numbered(orbits, labels, came, by_label, used)
        used = max([used, *(entry.number + 1 for entry in entries)])
        numbers[own], arrival[own] = _followed(judge, cell, left.starts[own], verdicts, entries)
        there_already = {old.number for old in known}
        found[system] = [entry for entry in entries if entry.number not in there_already]
    return Additions(_merged(learnt, learnt_of(judge, flat, found)), numbers, arrival)


def _by_label(learnt: Learnt) -> dict[str, int]:
    """Return the numbers of what is not periodic, by label."""
    rows = np.flatnonzero(learnt.known.periods <= 0)
    return {str(learnt.labels[row]): int(learnt.numbers[row]) for row in rows}


def _known_in(learnt: Learnt, system: int) -> list[Found]:
    """Return the periodic attractors that are known of a system."""
    rows = np.flatnonzero((learnt.systems == system) & (learnt.known.periods > 0))
    return [
        Found(int(learnt.numbers[i]), str(learnt.labels[i]), None, learnt.known.points[i])
        for i in rows
    ]


def _same(
    judge: Judge, cell: np.ndarray, orbits: Sequence[Attractor], known: Sequence[Found]
) -> list[tuple[int, Found]]:
    """Return which of the orbits, by its place, are known attractors of the same system."""
    if not orbits or not known:
        return []
    points, cells = np.array([old.start for old in known]), np.repeat(cell, len(known))
    rows = np.tile([0, len(orbits)], (len(known), 1))
    drawn = follow(judge.parts, cells, points, rows, known_of(orbits), SAME).attractor.tolist()
    return [(place, old) for place, old in zip(drawn, known, strict=True) if place >= 0]


def _beside(
    learnt: Learnt, found: Sequence[Sequence[Found]], shape: tuple[int, ...], system: int
) -> list[tuple[int, Found]]:
    """Return the periodic attractors of the systems one step away that are not known in a system.

    With each of them comes the number of its system; the last parameter is stepped first, and first
    back.  Each number comes once.
    """
    taken = {old.number for old in _known_in(learnt, system)}
    entries = list[tuple[int, Found]]()
    for other in _neighbors(shape, system):
        new = [entry for entry in found[other] if entry.orbit is not None]
        for entry in (*_known_in(learnt, other), *new):
            if entry.number not in taken:
                taken.add(entry.number)
                entries.append((other, entry))
    return entries


def _neighbors(shape: tuple[int, ...], system: int) -> Iterator[int]:
    """Yield the numbers of the systems one step away along each parameter."""
    place = np.unravel_index(system, shape) if shape else ()
    for axis in reversed(range(len(shape))):
        for step in (-1, 1):
            there = [int(i) for i in place]
            there[axis] += step
            if 0 <= there[axis] < shape[axis]:
                yield int(np.ravel_multi_index(there, shape))


def _came_from_beside(
    judge: Judge,
    flat: np.ndarray,
    system: int,
    orbits: Sequence[Attractor],
    beside: Sequence[tuple[int, Found]],
) -> list[tuple[int, Found]]:
    """Return which of the orbits, by its place, each attractor of a system beside leads to."""
    if not orbits or not beside:
        return []
    cell = flat[system : system + 1]
    seeds = seeds_of(cell, beside, flat)
    return came_to(judge.parts, cell, judge(np.repeat(cell, len(seeds)), seeds), orbits, beside)


def _followed(
    judge: Judge,
    cell: np.ndarray,
    starts: np.ndarray,
    verdicts: Verdicts,
    entries: Sequence[Found],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (n,) of the attractors of orbits in one system, and the arrivals (n,)."""
    numbers, arrival = np.full((2, len(starts)), -1)
    of_label = {entry.label: entry.number for entry in entries if entry.orbit is None}
    for label, number in of_label.items():
        numbers[verdicts.labels == label] = number
    periodic = [entry for entry in entries if entry.orbit is not None]
    closed = np.flatnonzero((verdicts.status == OK) & is_periodic(verdicts.evidence))
    if not periodic or not closed.size:
        return numbers, arrival
    known, own = (
        known_of(entry.orbit for entry in periodic),
        np.append([entry.number for entry in periodic], -1),
    )
    cells, rows = np.repeat(cell, closed.size), np.tile([0, len(periodic)], (closed.size, 1))
    points = verdicts.evidence[closed, ev.POINT : ev.POINT + 4]
    ends = follow(judge.parts, cells, points, rows, known, SAME).attractor
    drawn = follow(judge.parts, cells, starts[closed], rows, known, judge.most)
    numbers[closed] = own[ends]
    arrival[closed] = np.where((drawn.attractor == ends) & (ends >= 0), drawn.arrival, -1)
    return numbers, arrival


def _merged(learnt: Learnt, more: Learnt) -> Learnt:
    """Return what is known with more of it, by system and number."""
    arrays, other = learnt.arrays(), more.arrays()
    both = {name: np.concatenate([arrays[name], other[name]]) for name in arrays}
    order = np.lexsort((both["numbers"], both["systems"]))
    return Learnt.of({name: array[order] for name, array in both.items()})
