"""Why a scan's regimes change: for every border of its labels, what happens to the orbits there.

From the last cell of a label, its orbit is followed along its branch towards the next cell, and
from that cell's orbit back.  Either a special point ends it on the way (it loses its stability, or
its number of impacts changes), or it lives on and is stable: then the start has left its basin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.cli.terminal import table
from nlds_vines.continuation.branch_arm import at_value
from nlds_vines.continuation.exploration import is_same
from nlds_vines.continuation.result import Branch, Continued, map_of
from nlds_vines.continuation.section_map import SectionMap, place_of
from nlds_vines.continuation.special_points import doubling_near
from nlds_vines.continuation.start_orbits import orbits_in
from nlds_vines.model.labels import final

ENDING = ("LP", "PD", "NS", "BP", "LIM")
"""Special points at which a stable orbit ends, or ceases to be stable."""

SAME = 1.0e-6
"""Relative difference of two values of a special point that is met from both sides; one whose
bracket is wider has not been located."""


@dataclass(frozen=True)
class Walk:
    """What happens to an orbit from its cell to the next.

    Attributes: the located special points on the way, as (kind, value), the last of them the one
    that ends it, if one does; whether it is `alive` and stable in the next cell; the `label` it
    has there.
    """

    events: tuple[tuple[str, float], ...]
    alive: bool
    label: str

    @property
    def known(self) -> bool:
        """Whether it is known: the branch was followed so far."""
        return self.alive or any(kind in ENDING for kind, _ in self.events)


@dataclass(frozen=True)
class Border:
    """A border between two regimes of a scan.

    Attributes:
        low, high: the parameter in the cells on its sides; before, after: their labels.
        left, right: what happens to the orbit of the cell before and of that after on the way to
            the other; None where that is no periodic orbit, or not found on a branch.
        periodic: whether the orbits before and after are periodic.
    """

    low: float
    high: float
    before: str
    after: str
    left: Walk | None
    right: Walk | None
    periodic: tuple[bool, bool]

    @property
    def explained(self) -> bool:
        """Whether one side at least is periodic, and what happens to each such side is known."""
        sides = zip(self.periodic, (self.left, self.right), strict=True)
        known = all(walk is not None and walk.known for periodic, walk in sides if periodic)
        return known and any(self.periodic)

    @property
    def unfollowed(self) -> list[str]:
        """The labels before and after whose periodic orbit lies on no branch."""
        sides = zip((self.before, self.after), self.periodic, (self.left, self.right), strict=True)
        return [label for label, periodic, walk in sides if periodic and walk is None]

    @property
    def events(self) -> tuple[tuple[str, float], ...]:
        """The special points (kind, value) on it, each once."""
        walks = [walk for walk in (self.left, self.right) if walk is not None]
        found: list[tuple[str, float]] = []
        for kind, value in (event for walk in walks for event in walk.events):
            known = (v for k, v in found if k == kind)
            if all(abs(value - v) > SAME * abs(v) for v in known):
                found.append((kind, value))
        return tuple(sorted(found))

    @property
    def words(self) -> str:
        """What makes it, in words."""
        if not any(self.periodic):
            return "no periodic orbit on either side"
        if not self.explained and not self.unfollowed:
            return "not explained"
        if self.left is not None and self.left.alive and self.left.label == final(self.after):
            if final(self.before) == final(self.after):
                return "the same orbit: only the way there differs"
            return "the same orbit, stable all the way"
        sides = ((self.before, self.left, "ends"), (self.after, self.right, "begins"))
        known = [
            f"{final(label)} {verb}" if not walk.alive else f"{final(label)} is stable beyond it"
            for label, walk, verb in sides
            if walk is not None
        ]
        others = [f"the branch of {final(label)} was not followed" for label in self.unfollowed]
        return "; ".join(known + others)


def borders_of(found: Continued, scan: ArchiveView) -> list[Border]:
    """Return the borders between the labels of a scan's first start, with what makes them."""
    name = found.request.along.name
    labels, values = scan.take("label", start=0), scan[name]
    section_map = map_of(found.request)
    orbits = {orbit.value: orbit for orbit in orbits_in(scan, name, {})}
    borders = []
    along = found.request.along
    inside = (values[:-1] >= along.low) & (values[1:] <= along.high)
    for i in np.flatnonzero(inside & (labels[1:] != labels[:-1])):
        sides: list[tuple[bool, Walk | None]] = []
        for here, there in ((i, i + 1), (i + 1, i)):
            orbit = orbits.get(float(values[here]))
            if orbit is None:
                sides.append((False, None))
                continue
            place = place_of(found.request.system, name, orbit.value, orbit.state)
            walk = walk_of(found, section_map, place, orbit.period, float(values[there]))
            sides.append((True, walk))
        (first, left), (second, right) = sides
        borders.append(
            Border(
                float(values[i]),
                float(values[i + 1]),
                str(labels[i]),
                str(labels[i + 1]),
                left,
                right,
                (first, second),
            )
        )
    return borders


def walk_of(
    found: Continued, section_map: SectionMap, place: np.ndarray, n: int, until: float
) -> Walk | None:
    """Follow the branch of an orbit to a value of the parameter, or until it is not stable.

    Arguments: the `place` (size + 1,) of the orbit, its n.  None where it is on no branch.
    """
    value = float(place[-1])
    for number, branch in enumerate(found.branches):
        if branch.period == n:
            for segment in _segments_of(found, section_map, branch, place):
                return _walked(found, section_map, number, segment, value, until)
    return None


def _segments_of(
    found: Continued, section_map: SectionMap, branch: Branch, place: np.ndarray
) -> Iterator[int]:
    """Yield the segment, between a point and the next, of a branch in which an orbit lies."""
    value = float(place[-1])
    cycle = at_value(section_map, place, branch.period, value)
    if cycle is None:
        return
    for segment, other in found.cycles_at(section_map, branch, value):
        if is_same(section_map, cycle, other):
            yield segment


def _walked(
    found: Continued,
    section_map: SectionMap,
    number: int,
    segment: int,
    value: float,
    until: float,
) -> Walk:
    """Walk along a branch from a value within a segment towards another value."""
    branch = found.branches[number]
    values, toward = branch.parameter, 1.0 if until > value else -1.0
    ahead = 1 if (values[segment + 1] - values[segment]) * toward > 0.0 else -1
    rows = found.special_points[found.special_points.branch == number]
    events: list[tuple[str, float]] = []
    label = str(branch.labels[segment + (ahead > 0)])
    while 0 <= segment < len(values) - 1:
        here = rows[rows.index == segment][::ahead]
        for row in here:
            if (row.value - value) * toward < 0.0 or (until - row.value) * toward < 0.0:
                continue
            if row.bracket <= SAME * abs(row.value):
                events.append((str(row.kind), float(row.value)))
            if row.kind in ENDING:
                return Walk(tuple(events), False, label)
        point = segment + 1 if ahead > 0 else segment
        label = str(branch.labels[point])
        if (until - values[point]) * toward <= 0.0:
            if events and events[-1][0] == "GR":
                label = _beyond(rows, events[-1], ahead)
            elif not any(kind == "GR" for kind, _ in events):
                label = str(branch.labels[segment if ahead > 0 else segment + 1])
            return Walk(tuple(events), True, label)
        segment += ahead
    if branch.ends[ahead > 0] == "shorter":
        doubling = _doubling_at(found, section_map, branch, -1 if ahead > 0 else 0)
        events += [] if doubling is None else [("PD", doubling)]
    return Walk(tuple(events), False, label)


def _doubling_at(
    found: Continued, section_map: SectionMap, branch: Branch, end: int
) -> float | None:
    """Return the parameter at which the orbit doubles whose half a branch becomes at an end."""
    name, value = found.request.along.name, float(branch.parameter[end])
    place = place_of(found.request.system, name, value, tuple(branch.states[end].tolist()))
    lengths = np.array([found.request.along.high - found.request.along.low])
    point = doubling_near(section_map, place, branch.period // 2, lengths)
    return None if point is None else point.value


def _beyond(rows: np.recarray, event: tuple[str, float], ahead: int) -> str:
    """Return the label behind a grazing, in the direction of a walk."""
    row = rows[rows.value == event[1]][0]
    return str(row.after if ahead > 0 else row.before)


# ---- as a page -----------------------------------------------------------------------------------


def report(found: Continued, scan: ArchiveView, borders: list[Border]) -> Iterator[str]:
    """Yield a page that explains every border of a scan, line by line, as Markdown."""
    name = found.request.along.name
    if not borders:
        yield "The regime of the scan is the same in all cells of this interval: no borders."
        return
    explained = sum(border.explained for border in borders)
    neither = sum(not any(border.periodic) for border in borders)
    beside = sum(bool(border.unfollowed) for border in borders)
    missed = f"{beside} beside an orbit whose branch was not followed, " if beside else ""
    yield (
        f"{len(borders)} borders between regimes: {explained} explained, {neither} without a "
        f"periodic orbit on either side, {missed}"
        f"{len(borders) - explained - neither - beside} not explained."
    )
    if beside:
        yield f"`--from {scan.path}` follows the branches of all orbits of the scan."
    yield ""
    rows = [
        [
            f"{border.low:.6g}", f"{border.high:.6g}", border.before, border.after,
            ", ".join(f"{kind} {value:.10g}" for kind, value in border.events), border.words,
        ]
        for border in borders
    ]  # fmt: skip
    yield from table([name, "to", "before", "after", "events", "what happens"], rows)
