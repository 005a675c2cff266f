"""Explain the borders between a scan's regimes by the special points on the branches beside them.

The orbit of the last cell of a label is followed along its branch to the next cell, and the orbit
of that cell back.  Either a special point of `ENDING` ends it on the way, or it is stable up to
there: then it is the orbit of the next cell, or the start has left its basin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.cli.terminal import table
from nlds_vines.continuation.branch_arm import at_value
from nlds_vines.continuation.exploration import is_same
from nlds_vines.continuation.result import Continued, map_of
from nlds_vines.continuation.run import orbits_in
from nlds_vines.continuation.special_points import doubling_near
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import final

ENDING = ("LP", "PD", "NS", "BP", "LIM")  # where a stable orbit ends or loses stability

# Largest relative difference between two values of one special point reached from both sides; a
# special point with a wider bracket counts as not located.
SAME = 1.0e-6


@dataclass(frozen=True)
class Walk:
    """The way of an orbit along its branch from its cell to the next."""

    # the located special points (kind, value), in the order of the walk
    events: tuple[tuple[str, float], ...]
    alive: bool  # whether the orbit is stable in the next cell
    label: str  # its label there; meaningless unless `alive`

    @property
    def is_explained(self) -> bool:
        """Whether the branch reaches the next cell, or a located special point ends the orbit."""
        return self.alive or any(kind in ENDING for kind, _ in self.events)


@dataclass(frozen=True)
class Border:
    """A border between two regimes of a scan."""

    low: float  # the parameter in the cells on its sides
    high: float
    before: str  # their labels
    after: str
    # the walks of the orbits before and after to the other cell; None if an orbit is not periodic,
    # or lies on no branch
    left: Walk | None
    right: Walk | None
    periodic: tuple[bool, bool]  # whether the orbits before and after are

    @property
    def is_explained(self) -> bool:
        """Whether a side is periodic, and the walk of every periodic side is explained."""
        sides = zip(self.periodic, (self.left, self.right), strict=True)
        return any(self.periodic) and all(
            walk is not None and walk.is_explained for periodic, walk in sides if periodic
        )

    @property
    def unfollowed(self) -> list[str]:
        """The labels whose periodic orbit lies on no branch."""
        sides = zip((self.before, self.after), self.periodic, (self.left, self.right), strict=True)
        return [label for label, periodic, walk in sides if periodic and walk is None]

    @property
    def events(self) -> tuple[tuple[str, float], ...]:
        """The special points (kind, value) of both sides, each once."""
        events: list[tuple[str, float]] = []
        for walk in (self.left, self.right):
            for kind, value in () if walk is None else walk.events:
                if all(abs(value - v) > SAME * abs(v) for k, v in events if k == kind):
                    events.append((kind, value))
        return tuple(sorted(events))

    @property
    def words(self) -> str:
        if not any(self.periodic):
            return "no periodic orbit on either side"
        if not self.is_explained and not self.unfollowed:
            return "not explained"
        if self.left is not None and self.left.alive and self.left.label == final(self.after):
            if final(self.before) == final(self.after):
                return "the same orbit: only the transient differs"
            return "the same orbit, stable all the way"
        sides = ((self.before, self.left, "ends"), (self.after, self.right, "begins"))
        reasons = [
            f"{final(label)} {verb}" if not walk.alive else f"{final(label)} is stable beyond it"
            for label, walk, verb in sides
            if walk is not None
        ]
        reasons += [f"the branch of {final(label)} was not followed" for label in self.unfollowed]
        return "; ".join(reasons)


def borders_of(result: Continued, scan: ArchiveView) -> list[Border]:
    """Return the label changes of a scan's first start within the interval of `result`.

    Raises `RequestError` for a scan along another parameter.
    """
    along, name = result.request.along, result.request.along.name
    if scan.axes != (name,):
        raise RequestError(f"{scan.path} varies {', '.join(scan.axes)}, not {name} alone")
    if "label" not in scan:
        return []
    labels, values = scan.take("label", start=0), scan[name]
    section_map = map_of(result.request)
    orbits = {orbit.value: orbit for orbit in orbits_in(scan, name, {}, starts=1)}
    inside = (values[:-1] >= along.low) & (values[1:] <= along.high)
    borders = []
    for i in np.flatnonzero(inside & (labels[1:] != labels[:-1])):
        low, high = float(values[i]), float(values[i + 1])
        walks: list[Walk | None] = []
        for here, there in ((low, high), (high, low)):
            cycle, orbit = None, orbits.get(here)
            if orbit is not None:
                place = section_map.place_of(here, orbit.state)
                cycle = at_value(section_map, place, orbit.period, here)
            # the branches through the orbit, and the segments in which they pass it
            passed = (
                (number, segment)
                for number, branch in enumerate(result.branches)
                if cycle is not None and branch.period == cycle.n
                for segment, other in result.cycles_at(section_map, branch, here)
                if is_same(section_map, cycle, other)
            )
            first = next(passed, None)
            walks.append(first and _walked(result, section_map, *first, here, there))
        before, after, (left, right) = str(labels[i]), str(labels[i + 1]), walks
        periodic = (low in orbits, high in orbits)
        borders.append(Border(low, high, before, after, left, right, periodic))
    return borders


def _walked(
    result: Continued,
    section_map: SectionMap,
    number: int,
    segment: int,
    value: float,
    until: float,
) -> Walk:
    """Follow a branch from a value of the parameter within a segment to the value `until`.

    The walk ends before it at a point of `ENDING`, or with the branch.
    """
    branch = result.branches[number]
    values, toward = branch.parameter, 1.0 if until > value else -1.0
    ahead = 1 if (values[segment + 1] - values[segment]) * toward > 0.0 else -1
    every = result.special_points
    rows = every[(every.branch == number) & (every.kind != "UZ")]
    events: list[tuple[str, float]] = []
    label = str(branch.labels[segment + (ahead > 0)])
    while 0 <= segment < len(values) - 1:
        for row in rows[rows.index == segment][::ahead]:
            if (row.value - value) * toward < 0.0 or (until - row.value) * toward < 0.0:
                continue
            if row.bracket <= SAME * abs(row.value):
                events.append((str(row.kind), float(row.value)))
            if row.kind in ENDING:
                return Walk(tuple(events), False, label)
        point = segment + 1 if ahead > 0 else segment
        label = str(branch.labels[point])
        if (until - values[point]) * toward <= 0.0:
            # a label changes only at a GR: take the side beyond the last event; without a located
            # GR, keep that of the point before
            if events:
                row = rows[rows.value == events[-1][1]][0]
                label = str(row.after if ahead > 0 else row.before)
            else:
                label = str(branch.labels[segment if ahead > 0 else segment + 1])
            return Walk(tuple(events), True, label)
        segment += ahead
    if branch.ends[ahead > 0] == "shorter":
        # the branch ended on the orbit of half its period: locate the period doubling there
        along, end = result.request.along, -1 if ahead > 0 else 0
        place = section_map.place_of(float(values[end]), branch.states[end].tolist())
        lengths = np.array([along.high - along.low])
        doubling = doubling_near(section_map, place, branch.period // 2, lengths)
        events += [] if doubling is None else [("PD", doubling.value)]
    return Walk(tuple(events), False, label)


# ---- as text ----


def report(result: Continued, scan: ArchiveView, borders: list[Border]) -> Iterator[str]:
    name = result.request.along.name
    if "label" not in scan:
        yield f"{scan.path} holds no label: to explain borders, scan with regime in --record."
        return
    if not borders:
        yield "The regime of the scan is the same in all cells of this interval: no borders."
        return
    explained = sum(border.is_explained for border in borders)
    neither = sum(not any(border.periodic) for border in borders)
    beside = sum(bool(border.unfollowed) for border in borders)
    missed = f"{beside} beside an orbit whose branch was not followed, " if beside else ""
    yield (
        f"{len(borders)} borders between regimes: {explained} explained, {neither} without a "
        f"periodic orbit on either side, {missed}"
        f"{len(borders) - explained - neither - beside} not explained."
    )
    if beside:
        yield (
            f"`--from {scan.path}` follows the branches of the periodic orbits of every regime "
            "of the scan."
        )
    yield ""
    rows = [
        [
            f"{border.low:.6g}", f"{border.high:.6g}", border.before, border.after,
            ", ".join(f"{kind} {value:.10g}" for kind, value in border.events), border.words,
        ]
        for border in borders
    ]  # fmt: skip
    yield from table([name, "to", "before", "after", "events", "what happens"], rows)
