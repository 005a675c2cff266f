"""A whole branch, both directions joined: its points in order, its special points, where it ends.

What is found of a track is kept in arrays, from which it is made again to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any

import numpy as np

from nlds_vines.continuation.arclength import Point
from nlds_vines.continuation.branch_arm import ENDS, Arm
from nlds_vines.continuation.section_map import Cycle
from nlds_vines.continuation.special_points import KINDS, Special
from nlds_vines.runs.store import Arrays


class Switch(IntEnum):
    """What became of the branch that leaves, or crosses, another one at a special point."""

    NONE = 0  # none was to be followed
    FOLLOWED = 1
    KNOWN = 2  # it had been followed already
    FAILED = 3  # it was looked for and not found


_ARRAYS = ("state", "values", "points", "matrix", "slopes", "multipliers")
_NUMBERS = ("defect", "span", "clearance", "slowest", "volume")


@dataclass
class Track:
    """One branch.

    Attributes:
        points: in order, the parameter falling at first from the start in the middle, if it has
            two directions.
        specials: in the same order.
        ends: why it ends, at its beginning and at its end (of `branch.ENDS`).
        origin: "start", or "PD" or "BP" of the branch number `parent`, at its special point
            number `at`; -1 for none.
        switches: the outcome of each switch that was due at a special point, by its number.
    """

    points: list[Point]
    specials: list[Special]
    ends: tuple[str, str]
    origin: str = "start"
    parent: int = -1
    at: int = -1
    switches: dict[int, Switch] = field(default_factory=dict)

    @classmethod
    def joined(cls, down: Arm, up: Arm, **origin: Any) -> Track:
        """Return the track of two directions from the same first point."""
        points = [*map(_turned, reversed(down.points[1:])), *up.points]
        before = len(down.points) - 1
        specials = [
            *(_turned_special(s, before - 1 - s.index) for s in reversed(down.specials)),
            *(replace(s, index=before + s.index) for s in up.specials),
        ]
        return cls(points, specials, (down.end, up.end), **origin)

    @property
    def n(self) -> int:
        """The number of forcing periods of its orbits."""
        return self.points[0].cycle.n

    @property
    def values(self) -> np.ndarray:
        """The parameter at its points (points,)."""
        return np.array([point.value for point in self.points])

    @property
    def places(self) -> np.ndarray:
        """States and parameter at its points (points, size + 1)."""
        return np.array([point.cycle.place for point in self.points])


def _turned(point: Point) -> Point:
    """Return a point of a branch that is followed the other way."""
    return Point(point.cycle, -point.tangent, point.weights, -point.border)


def _turned_special(special: Special, index: int) -> Special:
    return replace(
        special,
        point=_turned(special.point),
        before=special.after,
        after=special.before,
        index=index,
    )


# ---- a track in arrays ---------------------------------------------------------------------------


Piece = Callable[[Callable[[], Arrays]], Arrays]
"""Returns the arrays of the next track or curve: those saved by an earlier run, or made now."""


def made_now(make: Callable[[], Arrays]) -> Arrays:
    """Return what is made, and save nothing."""
    return make()


def packed(track: Track | Switch) -> Arrays:
    """Return a track as arrays by name, or why there is none."""
    if isinstance(track, Switch):
        return {"switch": np.array([track])}
    ends = [list(ENDS).index(end) for end in track.ends]
    origin = [("start", "PD", "BP").index(track.origin), track.parent, track.at]
    texts = [[s.before, s.after, s.wall] for s in track.specials]
    numbers = [[s.residual, s.bracket, KINDS.index(s.kind), s.index] for s in track.specials]
    return {
        "ends": np.array(ends),
        "origin": np.array(origin),
        "texts": np.array(texts, dtype="U16").reshape(-1, 3),
        "numbers": np.array(numbers, dtype=float).reshape(-1, 4),
        **_packed_points("point", track.points),
        **_packed_points("special", [s.point for s in track.specials]),
    }


def _packed_points(name: str, points: list[Point]) -> dict[str, np.ndarray]:
    if not points:
        return {}
    cycles = [point.cycle for point in points]
    found = {f"{name}_{key}": np.array([getattr(c, key) for c in cycles]) for key in _ARRAYS}
    return found | {
        f"{name}_counts": np.array([c.counts for c in cycles]),
        f"{name}_numbers": np.array([[getattr(c, key) for key in _NUMBERS] for c in cycles]),
        f"{name}_tangent": np.array([p.tangent for p in points]),
        f"{name}_weights": np.array([p.weights for p in points]),
        f"{name}_border": np.array([p.border for p in points]),
    }


def unpacked(arrays: Arrays) -> Track | Switch:
    """Return the track that arrays hold, or why there is none."""
    if "switch" in arrays:
        return Switch(int(arrays["switch"][0]))
    ends, words = arrays["ends"].tolist(), list(ENDS)
    origin, parent, at = arrays["origin"].tolist()
    specials = [
        Special(KINDS[int(kind)], point, before, after, residual, bracket, wall, int(index))
        for point, (residual, bracket, kind, index), (before, after, wall) in zip(
            _unpacked_points("special", arrays),
            arrays["numbers"].tolist(),
            arrays["texts"].tolist(),
            strict=True,
        )
    ]
    return Track(
        _unpacked_points("point", arrays), specials, (words[ends[0]], words[ends[1]]),
        ("start", "PD", "BP")[origin], parent, at,
    )  # fmt: skip


def _unpacked_points(name: str, arrays: Arrays) -> list[Point]:
    if f"{name}_border" not in arrays:
        return []
    found = []
    for i, border in enumerate(arrays[f"{name}_border"].tolist()):
        near, far = arrays[f"{name}_counts"][i].tolist()
        numbers = dict(zip(_NUMBERS, arrays[f"{name}_numbers"][i].tolist(), strict=True))
        rows = {key: arrays[f"{name}_{key}"][i] for key in _ARRAYS}
        cycle = Cycle(counts=(near, far), **rows, **numbers)
        tangent, weights = arrays[f"{name}_tangent"][i], arrays[f"{name}_weights"][i]
        found.append(Point(cycle, tangent, weights, border))
    return found
