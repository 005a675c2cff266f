"""What a scene is made of: its parts, where the damper rests, where walls are touched."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from nlds_vines.model.parameters import DAMPING, HERTZ, LAWS, SECOND, Law, of_second

Values = Mapping[str, Any]
"""Parameters by name, in SI units; each a float, or an array where it varies."""

LONGEST_NAME = 16
"""The most letters of a name in `Scene.struck`: tables of impacts have a column so wide."""

FOOT = "+foot"
"""The ending of a kind in `Scene.key` where the foot of the structure moves."""

BASES = ("base_displacement", "base_acceleration")
"""The amplitudes of the ground's motion, of which one may be given in place of a force: [m],
[m/s^2]."""

_OBSTACLE = {"near": "obstacle", "far": "obstacle"}


@dataclass(frozen=True)
class Scene:
    """One kind of damper: its parameters, where it rests, its walls.

    With u = x2 - x1, the position of the damper relative to the structure, the damper's spring
    rests at u = `rest`, and r = `rest` - u is its shortening.  `rest`, the gaps and the limit are
    functions of the parameters by name (floats or arrays alike) that return meters.  Each is None
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
        obstacle: returns the positions u [m] of the lines that a picture shows, by name; of walls
            on the ground, those of x.
        struck: what the near and the far wall belong to, by wall.
        load: the constant force [N] on the structure towards the near wall; None for none.
        body: the word for the body that is forced.
        shaken: the name, "Y" or one of `BASES`, of what is given of the ground's motion in place of
            a force; "" where a force is given.
        second: the wall, "near" or "far", whose contact may have a law of its own; "" for none.
        law: the law of all contacts.
        law_2: the law of the second wall, if it is another, or has other constants.
        optional: the optional parameters of the laws that there are.
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
    load: Callable[[Values], Any] | None = None
    shaken: str = ""
    body: str = "structure"
    second: str = ""
    law: Law = HERTZ
    law_2: Law | None = None
    optional: tuple[str, ...] = ()
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
        """Whether there are contact forces: walls, and laws under which impacts take time."""
        return bool(self.walls) and not any(law.instant for law in self.laws)

    @property
    def walls(self) -> tuple[str, ...]:
        """The walls that exist, of "near" and "far"; empty for a scene without contact."""
        gaps = {"near": self.gap_near, "far": self.gap_far}
        return tuple(name for name, gap in gaps.items() if gap is not None)

    @property
    def bodies_struck(self) -> tuple[str, ...]:
        """The names of what the walls that exist belong to."""
        return tuple(self.struck[wall] for wall in self.walls)

    @property
    def laws(self) -> tuple[Law, ...]:
        """The laws of its contacts: one, or that of the second wall, too."""
        return (self.law,) if self.law_2 is None else (self.law, self.law_2)

    def law_at(self, wall: str) -> Law:
        """Return the law of a wall, "near" or "far"."""
        return self.law_2 if self.law_2 is not None and wall == self.second else self.law

    def ending(self, wall: str) -> str:
        """Return the ending of the names of a wall's constants: "", or that of the second."""
        return SECOND if self.law_2 is not None and wall == self.second else ""

    def is_damped(self, wall: str) -> bool:
        """Whether the law of a wall has Hunt and Crossley's damping."""
        return DAMPING + self.ending(wall) in self.optional

    def contact(self, given: Collection[str]) -> tuple[str, ...]:
        """Return the names of the contact's parameters that say all, in place of those `given`."""
        if not self.walls:
            return ()
        law, second = self.law, self.law_2
        names = law.needed if law.instead in given else law.constants
        names += tuple(name for name in law.optional if name in given)
        if second is not None:
            names += of_second(second.needed)
            names += tuple(name for name in of_second(second.optional) if name in given)
        return names

    @property
    def drives(self) -> tuple[str, ...]:
        """The names of what may drive it, of which one is given: the force, or the ground."""
        if "P" not in self.own:
            return ("Y", *BASES)
        return ("P", *BASES) if self.absolute else ("P", "Y", *BASES)

    @property
    def absolute(self) -> bool:
        """Whether positions are absolute where the ground moves, not counted from the ground."""
        return self.body == "structure"

    @property
    def foot(self) -> bool:
        """Whether the foot of spring and dashpot moves in the coordinates that are used."""
        return bool(self.shaken) and self.absolute

    @property
    def relative(self) -> bool:
        """Whether positions are counted from a ground that moves."""
        return bool(self.shaken) and not self.absolute

    def own_of(self, given: Collection[str]) -> tuple[str, ...]:
        """Return the names of the parameters beside the contact's: what drives is that given."""
        usual = self.drives[0]
        drive = next((name for name in self.drives[::-1] if name in given), usual)
        return tuple(drive if name == usual else name for name in self.own)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the needed parameters; `K` may replace the constants of a Hertz contact."""
        return self.own + self.contact(())

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names of all parameters that may be given, also `K` in place of others."""
        own = self.own + self.drives[1:]
        if not self.walls:
            return own
        second = self.law_2
        return (
            own
            + self.law.allowed
            + (() if second is None else of_second(second.needed + second.optional))
        )

    @property
    def key(self) -> str:
        """What kernels are compiled for, in a word: the kind, and what its contacts differ by."""
        words = [self.kind + FOOT * self.foot]
        if self.law != HERTZ or self.law_2 is not None or self.optional:
            words += [self.law.name, self.law_2.name if self.law_2 else ""]
            words += [name for name in self.optional if name.startswith(DAMPING)]
        return "/".join(words).rstrip("/")

    def under(self, law: str, law_2: str = "", given: Collection[str] = ()) -> Scene:
        """Return the scene whose contacts obey a law of `LAWS`; itself without contact.

        law_2: that of the second wall, if it has one of its own; given: the parameters there are.
        """
        shaken = next((name for name in ("Y", *BASES) if name in given), "")
        if not self.walls:
            return replace(self, shaken=shaken) if shaken else self
        law_of_second = LAWS[law_2] if law_2 else None
        found = replace(self, law=LAWS[law], law_2=law_of_second, shaken=shaken)
        known = [*found.law.optional, *of_second(found.law_2.optional if found.law_2 else ())]
        return replace(found, optional=tuple(name for name in known if name in given))
