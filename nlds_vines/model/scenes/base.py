"""What a scene is: which parts it has, where they rest and where its walls stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nlds_vines.model.parameters import CONTACT

Values = Mapping[str, Any]
"""Parameters by name; each a float, or an array where it varies."""

_OBSTACLE = {"near": "obstacle", "far": "obstacle"}
LONGEST_NAME = 16
"""Most letters of what a wall belongs to: tables of impacts have room for so many."""


@dataclass(frozen=True)
class Scene:
    """One kind of damper: its parameters, its rest state and its walls.

    With u = x2 - x1 the damper's spring rests at u = `rest`; r = `rest` - u is its shortening.
    A wall that pushes the damper in +x2 is touched where r = `gap_near`, one that pushes it in
    -x2 where -r = `gap_far`.  Each of these is a function of the parameters by name (floats or
    arrays alike) that returns metres, and is None where there is no such part.

    A damper that must not reach something without a wall in between has a `limit`: the shortening
    r [m] that must not be reached; where it is, that is reported and is no impact.

    `obstacle` returns the positions u [m] of the lines that a picture shows, by name; `struck`
    says in words what the near and the far wall belong to.
    """

    kind: str
    meaning: str
    own: tuple[str, ...]
    rest: Callable[[Values], Any] | None = None
    gap_near: Callable[[Values], Any] | None = None
    gap_far: Callable[[Values], Any] | None = None
    limit: Callable[[Values], Any] | None = None
    obstacle: Callable[[Values], Mapping[str, Any]] = lambda p: {}
    struck: Mapping[str, str] = field(default_factory=lambda: _OBSTACLE)

    def __post_init__(self) -> None:
        """Refuse what would go wrong silently.

        A limit without a wall, which nobody would watch: flights without walls look at no instant
        between sections; and a name of a wall that would be cut off.
        """
        if max(map(len, self.struck.values())) > LONGEST_NAME:
            raise ValueError(
                f"scene {self.kind!r}: names of walls have {LONGEST_NAME} letters at most"
            )
        if self.limit is not None and not self.walls:
            raise ValueError(f"scene {self.kind!r} has a limit and no wall: nothing watches it")

    @property
    def damper(self) -> bool:
        """Whether a damper is joined to the structure."""
        return self.rest is not None

    @property
    def walls(self) -> tuple[str, ...]:
        """The walls that exist, of `near` and `far`; empty for a scene without contact."""
        gaps = {"near": self.gap_near, "far": self.gap_far}
        return tuple(name for name, gap in gaps.items() if gap is not None)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the parameters it needs; `K` may stand in place of the contact constants."""
        return self.own + (CONTACT if self.walls else ())

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names of all parameters that it understands, `K` included where there is contact."""
        return self.parameters + (("K",) if self.walls else ())
