"""Branches through the start orbits, and the branches that leave these at special points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import IntEnum
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
    Arm,
    Bounds,
    at_value,
    end_beside,
    first_point,
    follow,
)
from nlds_vines.continuation.special_points import Special, doubled, other_branch
from nlds_vines.engine.section_map import SAME_ORBIT, Cycle, SectionMap, bordered
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.store import Arrays

EVERY = 16  # points after which a branch is compared again with those followed before

# Distance from a grazing of rigid bodies at which the other orbit is searched for, relative to the
# orbit and the interval; and the largest distance of an orbit that counts as the other.
ASIDE, FARTHEST = 1.0e-4, 0.2

# Trial kicks, in units of the kick of an orbit beyond the grazing; the number of trial places with
# the smallest closing error that are tried first; and trial distances along the tangent.
KICKS, LIKELY = (1.0, 0.3, 3.0), 4
AHEAD = tuple(sign * 1.1**i for sign in (1.0, -1.0) for i in range(-40, 75))

SAME_POINT = 1.0e-8  # distance of equal special points, relative to the orbit and to the parameter
NEAR = 0.05  # distance, relative to the orbit, within which a branch is compared with an orbit

# A start orbit: its place (size + 1,), state and parameter, and its number of periods.
Seed = tuple[np.ndarray, int]


class Switch(IntEnum):
    """The outcome of following the branch that leaves or crosses another at a special point."""

    NONE = 0  # not to be followed
    FOLLOWED = 1
    KNOWN = 2  # followed before
    FAILED = 3  # searched for and not located


def turned(point: Point) -> Point:
    return Point(point.cycle, -point.tangent, point.weights, -point.border)


@dataclass
class Track:
    """Both directions of a branch, saved as arrays, from which it is restored bit for bit."""

    points: list[Point]  # of two directions, the second one first, reversed
    specials: list[Special]  # in the same order
    ends: tuple[str, str]  # keys of `branch_arm.ENDS`
    origin: str = "start"  # or "PD", "BP"
    parent: int = -1  # the branch that it leaves, -1 for none
    at: int = -1  # the special point there
    switches: dict[int, Switch] = field(default_factory=dict)  # by the number of a special point

    @property
    def n(self) -> int:
        return self.points[0].cycle.n

    @property
    def values(self) -> np.ndarray:
        return np.array([point.value for point in self.points])


# ---- a track as arrays ----

_OF_CYCLE = [one.name for one in fields(Cycle) if one.name != "since"]  # that is 0
_OF_POINT = ("tangent", "weights", "border")
_OF_SPECIAL = [one.name for one in fields(Special) if one.name != "point"]
_OF_TRACK = ("origin", "parent", "at")

# Returns the arrays of the next track or curve: those of an earlier run, or the result of a call
# of its argument, which it saves.
Piece = Callable[[Callable[[], Arrays]], Arrays]


def packed(track: Track | Switch) -> Arrays:
    """Return a track, or the reason why there is none, as arrays by name."""
    if isinstance(track, Switch):
        return {"switch": np.array([track])}
    points = [*track.points, *(special.point for special in track.specials)]
    return {
        **{name: np.array([getattr(p.cycle, name) for p in points]) for name in _OF_CYCLE},
        **{name: np.array([getattr(p, name) for p in points]) for name in _OF_POINT},
        **{name: np.array([getattr(s, name) for s in track.specials]) for name in _OF_SPECIAL},
        **{name: np.array([getattr(track, name)]) for name in _OF_TRACK},
        "ends": np.array(track.ends),
    }


def unpacked(arrays: Arrays) -> Track | Switch:
    """Return the track, or the reason why there is none, from the arrays of `packed`."""
    if "switch" in arrays:
        return Switch(int(arrays["switch"][0]))
    rows = {name: [*a] if a.ndim > 1 else a.tolist() for name, a in arrays.items()}
    for name in ("counts", "shares"):
        rows[name] = [tuple(row.tolist()) for row in rows[name]]
    points = []
    for i in range(len(rows["border"])):
        cycle = Cycle(**{name: rows[name][i] for name in _OF_CYCLE})
        points.append(Point(cycle, *(rows[name][i] for name in _OF_POINT)))
    count = len(points) - len(rows["kind"])
    specials = [
        Special(point=point, **{name: rows[name][i] for name in _OF_SPECIAL})
        for i, point in enumerate(points[count:])
    ]
    first, last = rows["ends"]
    of_track = (rows[name][0] for name in _OF_TRACK)
    return Track(points[:count], specials, (first, last), *of_track)


# ---- following all branches ----


@dataclass
class Explorer:
    """Follows branches one after another; a branch ends where it meets one followed before."""

    section_map: SectionMap
    bounds: Bounds
    piece: Piece = lambda make: make()  # saves each track
    doublings: int = 0  # successive ones whose branches are followed
    longest: float = LONGEST_STEP  # step, weighted length
    unstable: int = MOST_POINTS  # the most successive unstable points
    most: int = MOST_POINTS  # points of a branch in one direction
    falls: bool = False  # whether the parameter falls along branches of start orbits
    tracks: list[Track] = field(default_factory=list)

    def run(self, seeds: Sequence[Seed]) -> list[Track]:
        """Follow the branches of all seeds, then those that leave them; return the tracks."""
        for place, n in seeds:
            cycle = at_value(self.section_map, place, n, float(place[-1]))
            cycle = None if cycle is None else self._of_least_period(cycle)
            if cycle is None or self.lies_on(cycle):
                continue
            self._keep(partial(self._both_ways, cycle))
        longest = max((track.n for track in self.tracks), default=1) * 2**self.doublings
        for number, track in enumerate(self.tracks):  # to which the branches that leave are added
            for at, special in enumerate(track.specials):
                make: Callable[[int, int], Track | Switch]
                if (special.kind == "PD" and 2 * track.n <= longest) or special.kind == "BP":
                    make = self._leaving
                elif special.kind == "GR" and "grazing" in track.ends:
                    make = self._from_grazing
                else:
                    continue
                if at not in track.switches:
                    track.switches[at] = self._keep(partial(make, number, at))
        return self.tracks

    def _keep(self, make: Callable[[], Track | Switch]) -> Switch:
        """Add the next track, saved by an earlier run or made now; return the outcome."""
        made = unpacked(self.piece(lambda: packed(make())))
        if isinstance(made, Switch):
            return made
        self._share_points(made)
        self.tracks.append(made)
        if made.origin == "PD" and made.ends[1] == "shorter":
            # the period doubling of the parent in which it ends needs not be followed again
            parent, (before, last) = self.tracks[made.parent], made.points[-2:]
            near = [
                (abs(special.value - last.value), i)
                for i, special in enumerate(parent.specials)
                if special.kind == "PD"
            ]
            if near and min(near)[0] < abs(before.value - last.value) + SAME_ORBIT:
                parent.switches.setdefault(min(near)[1], Switch.KNOWN)
        return Switch.FOLLOWED

    def _both_ways(self, cycle: Cycle, grazing: Special | None = None) -> Track | Switch:
        """Follow a branch in both directions from an orbit, which may lie beside a `grazing`."""
        signs = (-1.0, 1.0) if self.falls else (1.0, -1.0)
        starts = [first_point(self.section_map, cycle, self.bounds, sign) for sign in signs]
        return self._joined([start for start in starts if start is not None], grazing=grazing)

    def _joined(
        self, starts: list[Point], first: float = FIRST_STEP, grazing: Special | None = None
    ) -> Track | Switch:
        """Follow both directions of a branch from their first points, unless it is closed."""
        arms: list[Arm] = []
        for start in starts:
            arms.append(self._follow(start, first))
            if grazing is not None:
                end_beside(arms[-1], grazing)
            if arms[0].end == "closed":
                return Track(arms[0].points, arms[0].specials, ("closed", "closed"))
        if len(arms) < 2:
            return Switch.FAILED
        up, down = arms
        before = len(down.points) - 1
        specials = [
            replace(
                s, point=turned(s.point), before=s.after, after=s.before, index=before - 1 - s.index
            )
            for s in reversed(down.specials)
        ]
        specials += [replace(s, index=before + s.index) for s in up.specials]
        points = [*map(turned, reversed(down.points[1:])), *up.points]
        return Track(points, specials, (down.end, up.end))

    def _follow(self, start: Point, first: float = FIRST_STEP) -> Arm:
        """Follow one direction of a branch from a point, with a first step of length `first`."""
        count = 0

        def followed(point: Point) -> bool:
            nonlocal count
            check()
            count += 1
            return count % EVERY == 0 and self.lies_on(point_at_zero(self.section_map, point).cycle)

        return follow(
            self.section_map, start, self.bounds, followed=followed, first=first,
            longest=self.longest, unstable=self.unstable, most=self.most,
        )  # fmt: skip

    # ---- from a special point on ----

    def _from_grazing(self, parent: int, at: int) -> Track | Switch:
        """Follow the other branch at a grazing of rigid bodies: without the impact, or with it."""
        grazing, outcome = self.tracks[parent].specials[at], Switch.FAILED
        point = grazing.point
        # the map has no derivative at the grazing: places around it are tried
        for place in places_around(self.section_map, point):
            value = float(place[-1])
            if not self.bounds.contains(value):
                continue
            cycle = at_value(self.section_map, place, point.cycle.n, value)
            if cycle is None or cycle.counts == point.cycle.counts:
                continue
            near = np.abs(cycle.place - point.cycle.place) * point.weights
            if near.max() >= FARTHEST:
                continue
            cycle = self._of_least_period(cycle)
            if not self.lies_on(cycle):
                return self._both_ways(cycle, grazing)
            outcome = Switch.KNOWN
        return outcome

    def _leaving(self, parent: int, at: int) -> Track | Switch:
        """Follow the branch that leaves another at a period doubling or a branch point."""
        special = self.tracks[parent].specials[at]
        search = doubled if special.kind == "PD" else other_branch
        beside = search(self.section_map, special.point)
        if beside is None:
            return Switch.FAILED
        start, far = beside
        if self.lies_on(start.cycle):
            return Switch.KNOWN
        if special.kind == "BP":
            track = self._joined([start, turned(start)], far)
            if isinstance(track, Track):
                track.origin, track.parent, track.at = "BP", parent, at
            return track
        arm = self._follow(start, far)
        first = self.section_map.at(special.point.cycle.place, start.cycle.n)
        if first is not None:  # the branch begins with the orbit that doubles
            begin = point_of(self.section_map, first, start.tangent, self.bounds.lengths)
            arm.points.insert(0, begin or Point(first, start.tangent, start.weights, 0.0))
            arm.specials = [replace(s, index=s.index + 1) for s in arm.specials]
        return Track(arm.points, arm.specials, ("shorter", arm.end), "PD", parent, at)

    def _share_points(self, track: Track) -> None:
        """Mark as followed the points where a new track crosses another, or both graze."""
        for i, mine in enumerate(track.specials):
            for other in self.tracks:
                for j, theirs in enumerate(other.specials):
                    a, b = mine.point.cycle, theirs.point.cycle
                    if mine.kind != theirs.kind or a.n != b.n or mine.kind not in ("BP", "GR"):
                        continue
                    graze = "grazing" in track.ends and "grazing" in other.ends
                    if mine.kind == "GR" and (not graze or a.counts == b.counts):
                        continue
                    error = SAME_POINT + 4.0 * (mine.residual + theirs.residual)
                    width = SAME_POINT * abs(mine.value) + 4.0 * (mine.bracket + theirs.bracket)
                    if abs(mine.value - theirs.value) > width:
                        continue
                    if not distance_of(self.section_map, a, b) < error:
                        continue
                    if mine.kind == "BP":  # both get the more accurate orbit
                        best = min(mine, theirs, key=lambda special: special.residual)
                        mine, theirs = (
                            replace(
                                special, point=replace(special.point, cycle=best.point.cycle),
                                residual=best.residual, bracket=best.bracket,
                            )
                            for special in (mine, theirs)
                        )  # fmt: skip
                        track.specials[i], other.specials[j] = mine, theirs
                    track.switches[i] = Switch.KNOWN
                    if other.switches.get(j, Switch.FAILED) == Switch.FAILED:
                        other.switches[j] = Switch.KNOWN

    # ---- comparison with branches followed before ----

    def _of_least_period(self, cycle: Cycle) -> Cycle:
        """Return an orbit as one of its least period: of 3T as of T if its sections coincide."""
        size = cycle.state.size
        weights = self.section_map.weights(cycle, self.bounds.lengths)[:size]
        off = (np.abs(cycle.points[:, :size] - cycle.state) * weights).max(axis=1)
        for n in range(1, cycle.n):
            if cycle.n % n == 0 and off[n - 1] < SAME_ORBIT:
                shorter = at_value(self.section_map, cycle.place, n, float(cycle.values[0]))
                if shorter is not None:
                    return shorter
        return cycle

    def lies_on(self, cycle: Cycle) -> bool:
        """Return True if an orbit belongs to a track, brought to its parameter, at any phase."""
        value = float(cycle.values[0])
        for track in self.tracks:
            if track.n != cycle.n:
                continue
            for place in crossings(track, cycle):
                other = at_value(self.section_map, place, cycle.n, value)
                if other is not None and is_same(self.section_map, cycle, other):
                    return True
        return False


def places_around(section_map: SectionMap, point: Point) -> Iterator[np.ndarray]:
    """Yield trial places (size + 1,) of the other orbit that grazes at a point."""
    # the orbit itself on both sides of the parameter, for an orbit without the impact
    place, unit = point.cycle.place, 1.0 / point.weights[-1]
    for side in (1.0, -1.0):
        there = place.copy()
        there[-1] += side * ASIDE * unit
        yield there
    # the orbit changed by a soft impact per period: the equal kicks of all periods add up to
    # (I - M)^-1 times the change that one kick leaves at the end of its period
    for side in (1.0, -1.0):
        step = side * ASIDE * point.tangent
        kicked = section_map.at(place + step, point.cycle.n)
        if kicked is None or kicked.counts == point.cycle.counts:
            continue
        size = len(place) - 1
        right, row = np.append(-kicked.residual, 0.0), np.eye(size + 1)[-1:]
        solution, _ = bordered(point.cycle.closing, np.zeros((1, size)), row, right)
        if solution is None:
            continue
        kick = np.append(solution[:-1], 0.0)
        for share in KICKS:
            # those with the impacts of `kicked` and the smallest closing errors
            trials = [place + share * (kick + ahead * step) for ahead in AHEAD]
            images = [section_map.at(trial, kicked.n) for trial in trials]
            defects = [
                (cycle.defect, i)
                for i, cycle in enumerate(images)
                if cycle is not None and cycle.counts == kicked.counts
            ]
            yield from (trials[i] for _, i in sorted(defects)[:LIKELY])
        for share in KICKS:
            yield from (place + share * (kick + ahead * step) for ahead in AHEAD[::8])


def crossings(track: Track, cycle: Cycle) -> Iterator[np.ndarray]:
    """Interpolate a track to the parameter of an orbit; yield the places near it at any phase."""
    values, value = track.values, float(cycle.values[0])
    size = cycle.state.size
    for i in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0.0):
        a, b = track.points[i], track.points[i + 1]
        step = b.value - a.value
        share = (value - a.value) / step if step else 0.0
        place = a.cycle.place + share * (b.cycle.place - a.cycle.place)
        off = np.abs(cycle.points[:, :size] - place[:-1]) * a.weights[:-1]
        if off.max(axis=1).min() < NEAR:
            yield place


def is_same(section_map: SectionMap, cycle: Cycle, other: Cycle) -> bool:
    """Return True if two orbits at one value of the parameter are the same at any phase."""
    return distance_of(section_map, cycle, other) < SAME_ORBIT


def distance_of(section_map: SectionMap, cycle: Cycle, other: Cycle) -> float:
    """Return the smallest distance of two orbits over their phases, relative to their size."""
    weights = section_map.weights(other, np.ones(len(other.values)))[: other.state.size]
    off = np.abs(cycle.points[:, : other.state.size] - other.state) * weights
    return float(off.max(axis=1).min())
