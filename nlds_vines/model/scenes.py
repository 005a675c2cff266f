"""The kinds of systems: parameters, rest position, walls and laws of each, and the table `SCENES`.

A new kind is an entry of that table.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.model.parameters import (
    DAMPER,
    DAMPING,
    FORCING,
    HERTZ,
    LAWS,
    OSCILLATOR,
    SECOND,
    STRUCTURE,
    Law,
    of_second,
)

Values = Mapping[str, Any]  # parameters in SI units; each a float, or an array if it varies

HOST = "host"  # the kind of systems with a `HostScene`
LONGEST_NAME = 16  # letters in `Scene.struck`, the width of a column in tables of impacts
MOVING = "+ground"  # the suffix of a kind in `Scene.key` if the ground moves
BASES = ("base_displacement", "base_acceleration")  # of the ground, in place of the force


class Stroke(NamedTuple):
    """The displacement r along a damper's spring in one or many states, and the damper's walls."""

    r: Any  # [m], positive toward the walls in the direction 1
    terms: Any  # the size of the terms whose sum is r [m], which tells its round-off
    walls: Sequence[tuple[float, Any]]  # direction, 1 or -1, and gap [m] of each


@dataclass(frozen=True)
class Scene:
    """One kind of system: its parameters, where the damper rests, its walls.

    With u = x2 - x1, the position of the damper relative to the structure, the damper's spring
    rests at u = `rest`, and r = `rest` - u is its shortening.  `rest`, the gaps and the limit are
    functions of the parameters by name (floats or arrays alike) that return meters, None for a part
    that the scene does not have.  Of a host they only say that there is a wall; gaps are those of
    its dampers.
    """

    kind: str
    meaning: str
    parameter_names: tuple[str, ...]  # without those of the contact
    rest: Callable[[Values], Any] | None = None  # u at which the spring rests
    gap_near: Callable[[Values], Any] | None = None  # r at touch of the wall that limits it above
    gap_far: Callable[[Values], Any] | None = None  # -r at touch of the wall that limits it below
    limit: Callable[[Values], Any] | None = None  # r without a wall; reaching it is a violation
    # positions u [m] of the lines in a picture, by name; of walls on the ground, positions x
    obstacle: Callable[[Values], Mapping[str, Any]] = lambda p: {}
    struck: Mapping[str, str] = field(  # the bodies that the walls belong to
        default_factory=lambda: {"near": "obstacle", "far": "obstacle"}
    )
    # constant force per mass [m/s^2] on the structure towards the near wall
    load: Callable[[Values], Any] | None = None
    # "Y" or one of `BASES`: the ground's motion, in place of the force.  Positions, velocities and
    # energies are relative to the ground, accelerations are absolute
    shaken: str = ""
    body: str = "structure"  # the forced body
    second: str = ""  # the wall, "near" or "far", that may have a law of its own, `law_2`
    law: Law = HERTZ
    law_2: Law | None = None
    optional: tuple[str, ...] = ()  # the optional parameters of the laws that are present
    # of the state, in the order of kernels and archives [m, m/s, m, m/s]
    components: tuple[str, ...] = ("x1", "v1", "x2", "v2")
    dampers: tuple[str, ...] = ()  # the names of several dampers; none of a single one
    with_rigid_walls: tuple[str, ...] = ()  # the names of a host's dampers that have rigid walls
    springs: tuple[str, ...] = ()  # the names of a host's dampers that have nonlinear springs
    # what the kernels of the scene offer
    # states under an accelerogram have the times of its samples, where kernels stop anyway
    has_times_of_records: bool = False
    unrecorded: tuple[str, ...] = ()  # records that they do not make
    may_be_empty: tuple[str, ...] = ()  # records of an orbit that need no walls
    methods: tuple[str, ...] = ("exact", "rk4")  # of integration
    fineness: tuple[str, ...] = ("tolerance", "nodes", "contact_steps", "period_steps")
    cost: int = 1  # of a forcing period, in those of one structure with one damper
    # whether numbers of its response have symbols, x1_max; otherwise owners, roof.x_max
    has_symbols: bool = True
    is_alone_known: bool = True  # whether the structure alone has a response in closed form
    is_volume_known: bool = True  # whether ln |det M| follows from the divergence alone

    def __post_init__(self) -> None:
        if max(map(len, self.struck.values())) > LONGEST_NAME:
            raise ValueError(
                f"scene {self.kind!r}: names of walls have {LONGEST_NAME} letters at most"
            )
        # nothing between two sections of a flight without walls is examined
        if self.limit is not None and not self.walls:
            raise ValueError(f"scene {self.kind!r} has a limit and no wall: nothing checks it")

    @property
    def damper(self) -> bool:
        return self.rest is not None

    @property
    def is_linear(self) -> bool:
        """Whether the equations of motion are linear: neither walls nor nonlinear springs."""
        return not self.walls and not self.springs

    @property
    def grounded(self) -> bool:
        """Whether the walls stand on the ground, and limit the structure itself."""
        return not self.damper and bool(self.walls)

    @property
    def forces(self) -> bool:
        """Whether there are contact forces: walls, and laws under which impacts take time."""
        return bool(self.walls) and not any(law.instant for law in self.laws)

    @cached_property
    def walls(self) -> tuple[str, ...]:
        gaps = {"near": self.gap_near, "far": self.gap_far}
        return tuple(name for name, gap in gaps.items() if gap is not None)

    @property
    def counted(self) -> tuple[str, ...]:
        """The names of the walls in tables of counts, where kinds have always two."""
        return ("near", "far")

    @property
    def counted_walls(self) -> int:
        return len(self.counted)

    def by_damper(self, by_wall: np.ndarray) -> np.ndarray:
        """Return counts (..., walls) by damper, if there are several, and by wall."""
        return by_wall

    @property
    def bodies_struck(self) -> tuple[str, ...]:
        return tuple(self.struck[wall] for wall in self.walls)

    @property
    def wall_words(self) -> tuple[str, ...]:
        """The words for the walls in the order of counts."""
        return self.bodies_struck

    @property
    def sides(self) -> tuple[str, str]:
        """The names in tables of impacts of the walls that limit r from above and from below."""
        return self.struck["near"], self.struck["far"]

    @property
    def dampers_and_walls(self) -> Mapping[str, tuple[str, str]]:
        """The damper of each wall and its name in tables of impacts, by the word for the wall."""
        return {word: ("", word) for word in self.wall_words}

    def touches_at(self, impacts: np.ndarray) -> dict[str, np.ndarray]:
        """Return which of the `impacts` (n,) are at each wall, by the word for the wall."""
        return {word: impacts["wall"] == word for word in self.wall_words}

    @property
    def laws(self) -> tuple[Law, ...]:
        return (self.law,) if self.law_2 is None else (self.law, self.law_2)

    def law_at(self, wall: str) -> Law:
        return self.law_2 if self.law_2 is not None and wall == self.second else self.law

    def ending(self, wall: str) -> str:
        """Return the suffix of the constants of a wall: "", or `SECOND` for a law of its own."""
        return SECOND if self.law_2 is not None and wall == self.second else ""

    def is_damped(self, wall: str) -> bool:
        return DAMPING + self.ending(wall) in self.optional

    def contact(self, names: Collection[str]) -> tuple[str, ...]:
        """Return the names of the contact's parameters; `names` chooses K or what it replaces."""
        if not self.walls:
            return ()
        law, second = self.law, self.law_2
        contact = law.needed if law.instead in names else law.constants
        contact += tuple(name for name in law.optional if name in names)
        if second is not None:
            contact += of_second(second.needed)
            contact += tuple(name for name in of_second(second.optional) if name in names)
        return contact

    @cached_property
    def drives(self) -> tuple[str, ...]:
        """The alternative parameters of the excitation, the default first: force or ground."""
        if "P" not in self.parameter_names:
            return ("Y", *BASES)
        return ("P", *BASES) if self.body == "structure" else ("P", "Y", *BASES)

    def own_of(self, names: Collection[str]) -> tuple[str, ...]:
        """Return the names of the parameters without the contact's; `names` chooses the drive."""
        usual = self.drives[0]
        drive = next((name for name in self.drives[::-1] if name in names), usual)
        return tuple(drive if name == usual else name for name in self.parameter_names)

    @cached_property
    def allowed(self) -> tuple[str, ...]:
        names = self.parameter_names + self.drives[1:]
        if self.walls:
            names += self.law.allowed
        if self.walls and self.law_2 is not None:
            names += of_second(self.law_2.needed + self.law_2.optional)
        return names

    @property
    def key(self) -> str:
        """A text that identifies the compiled kernels: the kind and the laws of its contacts.

        `scene_of` makes a scene of it with the same kernels, but not always with the same drive.
        """
        words = [self.kind + MOVING * bool(self.shaken)]
        if self.law != HERTZ or self.law_2 is not None or self.optional:
            words += [self.law.name, self.law_2.name if self.law_2 else ""]
            words += [name for name in self.optional if name.startswith(DAMPING)]
        return "/".join(words).rstrip("/")

    def under(self, law: str, law_2: str = "", names: Collection[str] = ()) -> Scene:
        """Return the scene with other laws, of `LAWS`, and the optional parts among parameters."""
        shaken = next((name for name in ("Y", *BASES) if name in names), "")
        possible: tuple[str, ...] = ()
        if self.walls:
            possible = LAWS[law].optional + (of_second(LAWS[law_2].optional) if law_2 else ())
        optional = tuple(name for name in possible if name in names)
        key = law, law_2, shaken, optional
        if key not in self._variants:
            changes: dict[str, Any] = {"shaken": shaken} if shaken or self.walls else {}
            if self.walls:
                second = LAWS[law_2] if law_2 else None
                changes |= {"law": LAWS[law], "law_2": second, "optional": optional}
            self._variants[key] = replace(self, **changes) if changes else self
        return self._variants[key]

    @cached_property
    def _variants(self) -> dict[tuple[Any, ...], Scene]:
        return {}


# ---- the kinds -----------------------------------------------------------------------------------

_PARTS = (*STRUCTURE, *DAMPER)

_KINDS = (
    # the primary structure alone (Figures 2, 3, 6, 7), with which every damper is compared
    Scene(
        kind="none",
        meaning="primary structure alone, without a damper",
        parameter_names=STRUCTURE + FORCING,
        components=("x1", "v1"),
    ),
    # Figures 3 to 7: the joint's force on the damper is -k2 u - c2 u'
    Scene(
        kind="tmd",
        meaning="tuned mass damper: linear, without contact",
        parameter_names=_PARTS + FORCING,
        rest=lambda p: 0.0,
    ),
    # Figure 1d: by equation (5) the spring acts on the damper with -k2 (u - V - C); by equation (3)
    # the contact is closed while z = V - u = r - C > 0, and pushes the damper in +x2
    Scene(
        kind="ssul",
        meaning="single-sided unilateral NES: one obstacle, free to move away from it",
        parameter_names=(*_PARTS, "C", "V", *FORCING),
        rest=lambda p: p["V"] + p["C"],
        gap_near=lambda p: p["C"],
        obstacle=lambda p: {"obstacle": p["V"]},
    ),
    # Figure 1a: the spring acts on the damper with -k2 (u - D).  The structure is touched at u = 0,
    # where the spring is shorter by r = D, and pushes the damper in +x2; the obstacle is touched at
    # u = D + C, where it is longer by -r = C, and pushes it in -x2.  Both obey equation (2)
    Scene(
        kind="ssbl",
        meaning="single-sided bilateral NES: strikes the structure and an obstacle",
        parameter_names=(*_PARTS, "C", "D", *FORCING),
        rest=lambda p: p["D"],
        gap_near=lambda p: p["D"],
        gap_far=lambda p: p["C"],
        obstacle=lambda p: {"structure": 0.0 * p["D"], "obstacle": p["D"] + p["C"]},
        struck={"near": "structure", "far": "obstacle"},
        second="near",
    ),
    # Figure 1b: as ssbl without impacts on the structure, which the design has to prevent
    Scene(
        kind="ssvi-b",
        meaning="single-sided NES: strikes an obstacle, must not reach the structure (x1 < x2)",
        parameter_names=(*_PARTS, "C", "D", *FORCING),
        rest=lambda p: p["D"],
        gap_far=lambda p: p["C"],
        limit=lambda p: p["D"],
        obstacle=lambda p: {"structure": 0.0 * p["D"], "obstacle": p["D"] + p["C"]},
    ),
    # Figure 1c: the damper may pass the structure by up to L, to the shortening r = D + L
    Scene(
        kind="ssvi-c",
        meaning="single-sided NES: strikes an obstacle, may pass the structure by L at most",
        parameter_names=(*_PARTS, "C", "D", "L", *FORCING),
        rest=lambda p: p["D"],
        gap_far=lambda p: p["C"],
        limit=lambda p: p["D"] + p["L"],
        obstacle=lambda p: {"limit": -p["L"], "obstacle": p["D"] + p["C"]},
    ),
    # m x'' + c x' + k x = P cos(omega t) for x < C.  If spring, dashpot and stop stand on a ground
    # that moves by Y cos(omega t), P = m Y omega^2
    Scene(
        kind="oscillator",
        meaning="impact oscillator: one mass with a stop",
        parameter_names=(*OSCILLATOR, "C", *FORCING),
        gap_near=lambda p: p["C"],
        struck={"near": "stop", "far": "stop"},
        obstacle=lambda p: {"stop": p["C"]},
        body="oscillator",
        components=("x", "v"),
    ),
    # -C_2 <= x <= C
    Scene(
        kind="oscillator-2",
        meaning="impact oscillator with a stop on either side",
        parameter_names=(*OSCILLATOR, "C", "C_2", *FORCING),
        gap_near=lambda p: p["C"],
        gap_far=lambda p: p["C_2"],
        struck={"near": "stop", "far": "second stop"},
        obstacle=lambda p: {"stop": p["C"], "second stop": -p["C_2"]},
        body="oscillator",
        second="far",
        components=("x", "v"),
    ),
    # x'' = -g + Y omega^2 cos(omega t) for the height x > 0 above a table that moves by
    # Y cos(omega t): the far wall, since it limits -x.  E1 is the energy m v^2 / 2
    Scene(
        kind="ball",
        meaning="a ball on a vibrating table",
        parameter_names=("m", "g", "Y", "omega"),
        gap_far=lambda p: 0.0 * p["m"],
        struck={"near": "table", "far": "table"},
        obstacle=lambda p: {"table": 0.0 * p["m"]},
        load=lambda p: -p["g"],
        body="ball",
        components=("x", "v"),
    ),
)

SCENES: Mapping[str, Scene] = {scene.kind: scene for scene in _KINDS}
"""All scenes by kind.  NES: nonlinear energy sink."""


BODIES: Mapping[str, str] = {**{scene.kind: scene.body for scene in _KINDS}, HOST: "host"}
"""The words for the forced body by kind, as archives name it."""


def scene_of(key: str) -> Scene:
    """Return a scene with the kernels that a `Scene.key` of one of the kinds identifies."""
    words = key.split("/")
    while len(words) < 3:  # without laws other than Hertz's
        words.append("")
    kind, law, law_2, *optional = words
    names = [*optional, *BASES[:1]] if kind.endswith(MOVING) else optional
    return SCENES[kind.removesuffix(MOVING)].under(law or HERTZ.name, law_2, names)


@dataclass(frozen=True)
class HostScene(Scene):
    """The scene of a host: its near walls are those on the sides "+" of all dampers."""

    of_walls: tuple[tuple[str, str], ...] = ()  # damper and side of each wall, as kernels have them
    settable: tuple[str, ...] = ()  # `General.allowed` without ratios
    has_symbols: bool = False
    has_times_of_records: bool = True
    unrecorded: tuple[str, ...] = ("peak", "clearance")
    may_be_empty: tuple[str, ...] = ("impacts",)
    methods: tuple[str, ...] = ("exact",)
    fineness: tuple[str, ...] = ("tolerance",)
    cost: int = 16
    is_alone_known: bool = False
    is_volume_known: bool = False

    @property
    def allowed(self) -> tuple[str, ...]:
        return self.settable

    @property
    def counted(self) -> tuple[str, ...]:
        return self.wall_words

    @property
    def wall_words(self) -> tuple[str, ...]:
        return tuple(f"{damper}{side}" for damper, side in self.of_walls)

    @property
    def sides(self) -> tuple[str, str]:
        return "+", "-"

    @property
    def dampers_and_walls(self) -> Mapping[str, tuple[str, str]]:
        return {f"{damper}{side}": (damper, side) for damper, side in self.of_walls}

    def touches_at(self, impacts: np.ndarray) -> dict[str, np.ndarray]:
        return {
            word: (impacts["damper"] == damper) & (impacts["wall"] == side)
            for word, (damper, side) in self.dampers_and_walls.items()
        }

    def by_damper(self, by_wall: np.ndarray) -> np.ndarray:
        """Return counts (..., walls) as (..., dampers, sides), 0 where a damper has no wall."""
        dampers = self.dampers or tuple(dict.fromkeys(name for name, _ in self.of_walls))
        table = np.zeros((*by_wall.shape[:-1], len(dampers), len(self.walls)), by_wall.dtype)
        for wall, (damper, side) in enumerate(self.of_walls):
            place = dampers.index(damper), self.bodies_struck.index(side)
            table[..., *place] = by_wall[..., wall]
        return table

    @property
    def key(self) -> str:
        return "a host"
