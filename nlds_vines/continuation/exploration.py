"""All branches that start orbits lead to: their own, and those that leave at special points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from nlds_vines.continuation.arclength import (
    FIRST_STEP,
    LONGEST_STEP,
    Point,
    point_at_zero,
    point_of,
)
from nlds_vines.continuation.branch_arm import (
    MOST_POINTS,
    SAME_ORBIT,
    Arm,
    Bounds,
    at_value,
    end_beside,
    first_point,
    follow,
)
from nlds_vines.continuation.section_map import Cycle, SectionMap, bordered, closing
from nlds_vines.continuation.special_points import Special, doubled, other_branch
from nlds_vines.continuation.whole_branch import Piece, Switch, Track, made_now, packed, unpacked
from nlds_vines.runs.interrupts import check

EVERY = 16
"""Every so many points, a branch is compared with those that are known."""

ASIDE, FARTHEST = 1.0e-4, 0.2
"""How far beside a grazing of rigid bodies the other orbit is looked for, relative to the orbit and
the interval; and how far from it an orbit may be that counts as the other."""

KICKS, LIKELY = (1.0, 0.3, 3.0), 4
AHEAD = tuple(sign * 1.1**i for sign in (1.0, -1.0) for i in range(-40, 75))
"""Kicks that are tried, and how far ahead, in units of what an orbit beyond the grazing shows; and
how many of the places that an orbit nearly closes."""

SAME_POINT = 1.0e-8
"""Distance, relative to the orbit and to the parameter, of special points that are one."""

NEAR = 0.05
"""How near, relative to the orbit, a known branch is compared at all."""


@dataclass(frozen=True, eq=False)
class Seed:
    """A start orbit: its place (size + 1,), state and parameter, and its number of periods."""

    place: np.ndarray
    n: int


@dataclass(frozen=True)
class Search:
    """What is followed: `doublings` of the period one after another; the `longest` step; `unstable`
    points, one after another, behind a stable one."""

    doublings: int = 0
    longest: float = LONGEST_STEP
    unstable: int = MOST_POINTS


class Explorer:
    """Follows branches one after another; each is known to those that come later."""

    def __init__(
        self,
        section_map: SectionMap,
        bounds: Bounds,
        search: Search,
        piece: Piece = made_now,
    ) -> None:
        """Take the map, the interval, what is followed, and where tracks are saved."""
        self._map, self._bounds, self._search = section_map, bounds, search
        self._piece = piece
        self.tracks: list[Track] = []

    def run(self, seeds: Sequence[Seed]) -> list[Track]:
        """Follow the branches of all seeds, then those that leave them; return all tracks."""
        for seed in seeds:
            cycle = at_value(self._map, seed.place, seed.n, float(seed.place[-1]))
            if cycle is None or self.lies_on(cycle) is not None:
                continue
            self._keep(partial(self._both_ways, cycle))
        longest = max((track.n for track in self.tracks), default=1) * 2**self._search.doublings
        done = 0
        while done < len(self.tracks):
            for at in range(len(self.tracks[done].specials)):
                self._switch(done, at, longest)
            done += 1
        return self.tracks

    def _keep(self, make: Callable[[], Track | Switch]) -> Switch:
        """Add the next track, if there is one: that which an earlier run saved, or that made."""
        made = unpacked(self._piece(lambda: packed(make())))
        if isinstance(made, Switch):
            return made
        self._share_points(made)
        self.tracks.append(made)
        self._serve(made)
        return Switch.FOLLOWED

    def _both_ways(self, cycle: Cycle, grazing: Special | None = None) -> Track | Switch:
        """Follow a branch in both directions from an orbit, which may lie beside a `grazing`."""
        arms = []
        for sign in (1.0, -1.0):
            start = first_point(self._map, cycle, self._bounds, sign)
            if start is None:
                return Switch.FAILED
            arms.append(self._follow(start))
            if grazing is not None:
                end_beside(arms[-1], grazing)
            if arms[0].end == "closed":
                return Track(arms[0].points, arms[0].specials, ("closed", "closed"))
        return Track.joined(arms[1], arms[0])

    def _follow(self, start: Point, first: float = FIRST_STEP) -> Arm:
        """Follow one direction from a point on, the first step so long."""
        count = 0

        def followed(point: Point) -> bool:
            nonlocal count
            check()
            count += 1
            if count % EVERY:
                return False
            return self.lies_on(point_at_zero(self._map, point).cycle) is not None

        search = self._search
        return follow(
            self._map, start, self._bounds, followed=followed, first=first,
            longest=search.longest, unstable=search.unstable,
        )  # fmt: skip

    # ---- from a special point on ----

    def _switch(self, parent: int, at: int, longest: int) -> None:
        """Follow the branch that leaves another at a special point, if one is to be followed."""
        track = self.tracks[parent]
        kind = track.specials[at].kind
        if at in track.switches:
            return
        make: Callable[[int, int], Track | Switch]
        if kind == "PD" and 2 * track.n <= longest:
            make = self._from_doubling
        elif kind == "BP":
            make = self._from_branch_point
        elif kind == "GR" and "grazing" in track.ends:
            make = self._from_grazing
        else:
            return
        track.switches[at] = self._keep(partial(make, parent, at))

    def _from_grazing(self, parent: int, at: int) -> Track | Switch:
        """Follow the other orbit that grazes, of rigid bodies: without the impact, or with it.

        The map has no derivative there. So the orbit is looked for at places around, on both sides
        of the parameter.
        """
        grazing, outcome = self.tracks[parent].specials[at], Switch.FAILED
        point = grazing.point
        for place in places_around(self._map, point):
            value = float(place[-1])
            if not self._bounds.contains(value):
                continue
            cycle = at_value(self._map, place, point.cycle.n, value)
            if cycle is None or cycle.counts == point.cycle.counts:
                continue
            near = np.abs(cycle.place - point.cycle.place) * point.weights
            if near.max() >= FARTHEST:
                continue
            if self.lies_on(cycle) is None:
                return self._both_ways(cycle, grazing)
            outcome = Switch.KNOWN
        return outcome

    def _from_doubling(self, parent: int, at: int) -> Track | Switch:
        origin = self.tracks[parent].specials[at].point
        found = doubled(self._map, origin)
        if found is None:
            return Switch.FAILED
        if self.lies_on(found[0].cycle) is not None:
            return Switch.KNOWN
        start, far = found
        arm = self._follow(start, far)
        first = self._map.at(origin.cycle.place, start.cycle.n)
        if first is not None:  # the branch begins with the orbit that doubles
            begin = point_of(self._map, first, start.tangent, self._bounds.lengths)
            arm.points.insert(0, begin or Point(first, start.tangent, start.weights, 0.0))
            arm.specials = [replace(s, index=s.index + 1) for s in arm.specials]
        return Track(arm.points, arm.specials, ("shorter", arm.end), "PD", parent, at)

    def _from_branch_point(self, parent: int, at: int) -> Track | Switch:
        found = other_branch(self._map, self.tracks[parent].specials[at].point)
        if found is None:
            return Switch.FAILED
        if self.lies_on(found[0].cycle) is not None:
            return Switch.KNOWN
        arms, (start, far) = [], found
        for turned in (1.0, -1.0):
            point = Point(start.cycle, turned * start.tangent, start.weights, turned * start.border)
            arms.append(self._follow(point, far))
            if arms[0].end == "closed":
                ends = ("closed", "closed")
                return Track(arms[0].points, arms[0].specials, ends, "BP", parent, at)
        track = Track.joined(arms[1], arms[0])
        track.origin, track.parent, track.at = "BP", parent, at
        return track

    def _serve(self, track: Track) -> None:
        """Mark the period doublings from which a track comes, and in which it ends."""
        if track.origin != "PD":
            return
        parent = self.tracks[track.parent]
        if track.ends[1] == "shorter":
            last = track.points[-1]
            near = [
                (abs(special.value - last.value), i)
                for i, special in enumerate(parent.specials)
                if special.kind == "PD"
            ]
            if near and min(near)[0] < abs(track.points[-2].value - last.value) + SAME_ORBIT:
                parent.switches.setdefault(min(near)[1], Switch.KNOWN)

    def _share_points(self, track: Track) -> None:
        """Note the branch points, and rigid grazings, that a new track shares with others.

        Two branches meet there: when both are known, there is nothing more to follow.  A branch
        point gets the same, most exact orbit on both.
        """
        for i, mine in enumerate(track.specials):
            for other in self.tracks:
                for j, theirs in enumerate(other.specials):
                    if not _meet(self._map, (track, mine), (other, theirs)):
                        continue
                    if mine.kind == "BP":
                        best = min(mine, theirs, key=lambda special: special.residual)
                        track.specials[i] = mine = _located_as(mine, best)
                        other.specials[j] = _located_as(theirs, best)
                    track.switches[i] = Switch.KNOWN
                    if other.switches.get(j, Switch.FAILED) == Switch.FAILED:
                        other.switches[j] = Switch.KNOWN

    # ---- what is known ----

    def lies_on(self, cycle: Cycle) -> int | None:
        """Return the number of the track that an orbit belongs to; None if it is new.

        Newton's method takes the known branch to the orbit's parameter: the two are one if they
        agree to round-off, at whatever phase.
        """
        for number, track in enumerate(self.tracks):
            if track.n == cycle.n and any(self._is_one(cycle, p) for p in crossings(track, cycle)):
                return number
        return None

    def _is_one(self, cycle: Cycle, place: np.ndarray) -> bool:
        value = float(cycle.values[0])
        found = at_value(self._map, place, cycle.n, value)
        return found is not None and is_same(self._map, cycle, found)


def places_around(section_map: SectionMap, point: Point) -> Iterator[np.ndarray]:
    """Yield places (size + 1,) where the other orbit may be that grazes at a point.

    First the orbit's own state on both sides of the parameter, for an orbit without the impact.
    Then what an impact of a small speed adds to the orbit: each gives the same kick, and those of
    all periods add up to (I - M)^-1 times what one leaves at the end of its period. At which value
    of the parameter, is tried.
    """
    place, unit = point.cycle.place, 1.0 / point.weights[-1]
    for side in (1.0, -1.0):
        there = place.copy()
        there[-1] += side * ASIDE * unit
        yield there
    for side in (1.0, -1.0):
        way = side * ASIDE * point.tangent
        kicked = section_map.at(place + way, point.cycle.n)
        if kicked is None or kicked.counts == point.cycle.counts:
            continue
        size = len(place) - 1
        row = np.zeros((1, size + 1))
        row[0, size] = 1.0
        right = np.append(-kicked.gap, 0.0)
        found, _ = bordered(closing(point.cycle), np.zeros((1, size)), row, right)
        if found is None:
            continue
        kick = np.append(found[:-1], 0.0)
        for share in KICKS:
            tried = [place + share * (kick + ahead * way) for ahead in AHEAD]
            yield from _likely(section_map, tried, kicked)
        for share in KICKS:
            yield from (place + share * (kick + ahead * way) for ahead in AHEAD[::8])


def _likely(
    section_map: SectionMap, places: Sequence[np.ndarray], kicked: Cycle
) -> Iterator[np.ndarray]:
    """Yield those places, the best first, that an orbit with as many impacts nearly closes."""
    images = [section_map.at(place, kicked.n) for place in places]
    defects = [
        (cycle.defect, i)
        for i, cycle in enumerate(images)
        if cycle is not None and cycle.counts == kicked.counts
    ]
    for _, i in sorted(defects)[:LIKELY]:
        yield places[i]


def crossings(track: Track, cycle: Cycle) -> Iterator[np.ndarray]:
    """Yield the places, between neighboring points of a track, with an orbit's parameter.

    Only those near the orbit, at whatever phase of it.
    """
    values, value = track.values, float(cycle.values[0])
    found = (values[:-1] - value) * (values[1:] - value) <= 0.0
    size = cycle.state.size
    for i in np.flatnonzero(found):
        a, b = track.points[i], track.points[i + 1]
        step = b.value - a.value
        share = (value - a.value) / step if step else 0.0
        place = a.cycle.place + share * (b.cycle.place - a.cycle.place)
        off = np.abs(cycle.points[:, :size] - place[:-1]) * a.weights[:-1]
        if off.max(axis=1).min() < NEAR:
            yield place


def _meet(section_map: SectionMap, one: tuple[Track, Special], two: tuple[Track, Special]) -> bool:
    """Return True if two branches cross at special points, or graze there with other impacts."""
    (track, a), (other, b) = one, two
    if a.kind != b.kind or a.point.cycle.n != b.point.cycle.n or a.kind not in ("BP", "GR"):
        return False
    ends = "grazing" in track.ends and "grazing" in other.ends
    if a.kind == "GR" and (not ends or a.point.cycle.counts == b.point.cycle.counts):
        return False
    error = SAME_POINT + 4.0 * (a.residual + b.residual)
    width = SAME_POINT * abs(a.value) + 4.0 * (a.bracket + b.bracket)
    if abs(a.value - b.value) > width:
        return False
    return distance_of(section_map, a.point.cycle, b.point.cycle) < error


def _located_as(special: Special, best: Special) -> Special:
    """Return a special point of one branch with the orbit that another one has there."""
    point = replace(special.point, cycle=best.point.cycle)
    return replace(special, point=point, residual=best.residual, bracket=best.bracket)


def is_same(section_map: SectionMap, cycle: Cycle, other: Cycle) -> bool:
    """Tell whether two orbits of one parameter are one, at whatever phase."""
    return distance_of(section_map, cycle, other) < SAME_ORBIT


def distance_of(section_map: SectionMap, cycle: Cycle, other: Cycle) -> float:
    """Return the distance of two orbits, relative to their size, at the phase where it is least."""
    weights = section_map.weights(other, np.ones(len(other.values)))[: other.state.size]
    off = np.abs(cycle.points[:, : other.state.size] - other.state) * weights
    return float(off.max(axis=1).min())
