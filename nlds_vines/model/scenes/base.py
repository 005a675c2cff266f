"""What a scene is made of: its parts, where the damper rests, where walls are touched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from nlds_vines.model.laws import HERTZ, LAWS, Law

Values = Mapping[str, Any]
"""Parameters by name, in SI units; each a float, or an array where it varies."""

LONGEST_NAME = 16
"""The most letters of a name in `Scene.struck`: tables of impacts have a column so wide."""

_OBSTACLE = {"near": "obstacle", "far": "obstacle"}


@dataclass(frozen=True)
class Scene:
    """One kind of damper: its parameters, where it rests, its walls.

    With u = x2 - x1, the position of the damper relative to the structure, the damper's spring
    rests at u = `rest`, and r = `rest` - u is its shortening.  `rest`, the gaps and the limit are
    functions of the parameters by name (floats or arrays alike) that return metres.  Each is None
    where the scene has no such part.

    Attributes:
        kind: the name in files, archives and Python.
        meaning: in words.
        own: the names of the parameters, without those of the contact.
        rest: u at which the spring rests; None without a damper.
        gap_near: r at which the wall is touched that pushes the damper in +x2.
        gap_far: -r at which the wall is touched that pushes the damper in -x2.
        limit: r that must not be reached although no wall is there; reaching it is reported as a
            violation and is no impact.
        obstacle: returns the positions u [m] of the lines that a picture shows, by name.
        struck: what the near and the far wall belong to, by wall.
        law: the law of all contacts.
        components: the names of a state's numbers, in the order of kernels and archives: two, or
            four with a damper [m, m/s, m, m/s].
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
    law: Law = HERTZ
    components: tuple[str, ...] = ("x1", "v1", "x2", "v2")

    def __post_init__(self) -> None:
        """Raise ValueError for a name of a wall that is too long, and for a limit without a wall.

        Flights without walls are computed from section to section: nothing between two sections is
        examined, and a violation of the limit would stay unseen.
        """
        if max(map(len, self.struck.values())) > LONGEST_NAME:
            raise ValueError(
                f"scene {self.kind!r}: names of walls have {LONGEST_NAME} letters at most"
            )
        if self.limit is not None and not self.walls:
            raise ValueError(f"scene {self.kind!r} has a limit and no wall: nothing checks it")

    @property
    def damper(self) -> bool:
        """Whether a damper is joined to the structure."""
        return self.rest is not None

    @property
    def grounded(self) -> bool:
        """Whether the walls stand on the ground, and limit the structure itself."""
        return not self.damper and bool(self.walls)

    @property
    def forces(self) -> bool:
        """Whether there are contact forces: walls, and a law under which impacts take time."""
        return bool(self.walls) and not self.law.instant

    @property
    def walls(self) -> tuple[str, ...]:
        """The walls that exist, of "near" and "far"; empty for a scene without contact."""
        gaps = {"near": self.gap_near, "far": self.gap_far}
        return tuple(name for name, gap in gaps.items() if gap is not None)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the needed parameters; `K` may replace the constants of a Hertz contact."""
        return self.own + (self.law.constants if self.walls else ())

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names of all parameters that may be given, also `K` in place of others."""
        return self.own + (self.law.allowed if self.walls else ())

    def under(self, law: str) -> Scene:
        """Return the scene whose contacts obey a law of `LAWS`; itself without contact."""
        same = law == self.law.name or not self.walls
        return self if same else replace(self, law=LAWS[law])
