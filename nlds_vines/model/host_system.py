"""A host with dampers and walls between its degrees of freedom: the system of kind `host`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import nan, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import (
    RequestError,
    at,
    by_dof_names,
    check_name,
    choice,
    dof_name,
    number,
    shown,
    string,
    table,
    unknown,
)
from nlds_vines.model.parameters import (
    DAMPING,
    DESCRIBED,
    FORCE,
    GROUND,
    HERTZ,
    INITIAL,
    LAWS,
    PARAMETERS,
    RATIOS,
    RESERVED,
    SIDES,
    Law,
    flat,
    hertz_stiffness,
    split_name,
)
from nlds_vines.model.ratios import RATIOS as PARAMETERS_BY_RATIO
from nlds_vines.model.ratios import Ratio, from_percentage, refuse_critical
from nlds_vines.model.scenes import HOST, LONGEST_NAME, Scene, Stroke, Values

if TYPE_CHECKING:
    from nlds_vines.model.host import Host  # with SciPy

ALL = "all"  # of the influence of the ground: that of the host
PLACE = "attached_to"  # the key of a damper's place, which is no number


def _are(kind: type, values: object) -> bool:
    return isinstance(values, Sequence) and all(isinstance(value, kind) for value in values)


class Wall:
    """A wall that limits how far a damper moves along its spring.

    Parameters
    ----------
    gap : float
        Distance [m] to go from the rest of the structure until the touch.
    side : str, optional
        "+": the wall is touched where the damper's spring is shortened by the gap, so that the
        degree of freedom has approached the mass from below; "-": where it is lengthened.
    law : str, optional
        The contact law, by default "hertz"; see the page "Contact laws".
    **constants : float
        The law's constants: K, or the seven of Hertz' law; exponent, hunt_crossley, kc, cc, e.

    Raises
    ------
    RequestError
        For an unknown side or law, and for a constant that is missing, foreign or out of range.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.Wall(0.05, law="restitution", e=0.7)
    Wall: gap 0.05 m, side '+', law 'restitution', e = 0.7
    """

    def __init__(
        self, gap: float, side: str = "+", law: str = HERTZ.name, **constants: float
    ) -> None:
        self.gap = number("gap", gap)
        self.side, self.law = choice("side", side, SIDES), choice("law", law, LAWS)
        allowed, needed = LAWS[law].allowed, LAWS[law].constants
        values = {name: number(name, value) for name, value in constants.items()}
        for name, value in values.items():
            if name not in allowed:
                raise unknown(f"constant of law {law!r}", name, allowed)
            PARAMETERS[name].check(value)
        replaces = LAWS[law].instead
        if replaces and replaces in values and set(needed) & values.keys():
            raise RequestError(f"{replaces} stands beside constants that it replaces")
        missing = [name for name in needed if name not in values]
        if missing and not (replaces and replaces in values):
            hint = f", or {replaces}" if replaces else ""
            raise RequestError(f"law {law!r} needs {', '.join(missing)}{hint}")
        self.statements: Mapping[str, float] = MappingProxyType({**values})
        if replaces and replaces not in values:
            values[replaces] = float(hertz_stiffness(*(values[name] for name in needed)))
        self.constants: Mapping[str, float] = MappingProxyType(values)

    @property
    def is_damped(self) -> bool:
        """Whether the contact dissipates by Hunt and Crossley's factor."""
        return self.constants.get(DAMPING, 0.0) > 0.0

    def changed(self, values: Mapping[str, float]) -> Wall:
        """Return the wall with the gap and those constants of its law that `values` has."""
        law = LAWS[self.law]
        constants = {name: value for name, value in values.items() if name in law.allowed}
        gone: tuple[str, ...] = ()
        if law.instead in constants:
            gone = law.constants
        elif not constants.keys().isdisjoint(law.constants):
            gone = (law.instead,)
        before = {name: value for name, value in self.statements.items() if name not in gone}
        return Wall(values.get("gap", self.gap), self.side, self.law, **{**before, **constants})

    def __repr__(self) -> str:
        constants = numbers(self.constants)
        return f"Wall: gap {self.gap:g} m, side {self.side!r}, law {self.law!r}, {constants}"


@dataclass(frozen=True)
class Damper:
    """A damper: a spring and a dashpot between a degree of freedom and a mass, and its walls.

    Parameters
    ----------
    name : str
        Its name.
    attached_to : str or int, or two of these
        The degree of freedom that its mass hangs on; or two, the second of which may be "ground",
        of a damper without a mass of its own.
    m : float, optional
        Its mass [kg].
    k, c : float, optional
        Stiffness [N/m] and damping [N s/m] of its joint, by default 0.
    walls : sequence of Wall, optional
        One or two walls, by default none: a tuned mass damper.
    f : float, optional
        In place of k, the frequency [Hz] of its mass on a structure at rest: k = (2 pi f)^2 m.
    zeta : float or str, optional
        In place of c, its damping ratio on a structure at rest, 0.1 or "10%", below 1:
        c = 2 zeta sqrt(k m).
    frequency_ratio : float, optional
        In place of k and f, its frequency over that of the lowest mode of the host alone that has
        one; `System.from_host` replaces it by f, as a host does not change.

    Raises
    ------
    RequestError
        For a mass that is missing or out of place, a negative value, two statements of k or of c,
        and walls that overlap.

    Notes
    -----
    What is stated as f or zeta stays, and k and c follow, if the mass changes.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.Damper("cell", attached_to="roof", m=30.0, k=334.0, walls=[nv.Wall(0.05, K=3e7)]).m
    30.0
    """

    name: str
    attached_to: str | int | Sequence[str | int]
    m: float | None = None
    k: float = 0.0
    c: float = 0.0
    walls: Sequence[Wall] = ()
    f: float | None = None
    zeta: float | str | None = None
    frequency_ratio: float | None = None

    def __post_init__(self) -> None:
        check_name("name", self.name)
        if self.name in RESERVED:
            raise RequestError(f"name = {shown(self.name)} has another meaning: take another one")
        if len(self.name) > LONGEST_NAME:
            raise RequestError(
                f"name = {shown(self.name)} has {len(self.name)} letters; allowed: {LONGEST_NAME}"
            )
        with at(f"damper {self.name!r}"):
            places = self.attached_to
            has_mass = not isinstance(places, list | tuple)
            labels = places if isinstance(places, list | tuple) else [places]
            ends = tuple(dof_name("attached_to", label) for label in labels)
            if not has_mass and (len(ends) != 2 or ends[0] == ends[1]):
                raise RequestError(
                    f"attached_to = {shown(self.attached_to)} must be a degree of freedom, or two "
                    "different ones"
                )
            self.__dict__["attached_to"] = ends[0] if has_mass else ends
            if has_mass == (self.m is None):
                raise RequestError(
                    "a mass m is missing" if has_mass else "has no mass m between two bodies"
                )
            for key in ("m", "k", "c") if has_mass else ("k", "c"):
                DESCRIBED[f"{self.name}.{key}"].check(number(key, getattr(self, key)))
            self._follow_ratios()
            if not _are(Wall, self.walls):
                raise RequestError(f"walls = {shown(self.walls)} must be a list of Wall")
            walls = tuple(self.walls)
            sides = [wall.side for wall in walls]
            if len(set(sides)) < len(sides):
                raise RequestError("two walls are on one side; allowed: one on each")
            if len(walls) == 2 and sum(wall.gap for wall in walls) < 0:
                overlap = -sum(wall.gap for wall in walls)
                raise RequestError(
                    f"its walls overlap by {overlap:g} m: the sum of their gaps must be >= 0"
                )
            self.__dict__["walls"] = walls

    def _follow_ratios(self) -> None:
        """Set k and c if they are stated as a frequency, or as a ratio."""
        stated = [key for key in _RATIOS_OF_DAMPERS if getattr(self, key) is not None]
        if stated and self.m is None:
            raise RequestError(f"{stated[0]} needs a mass m, which is missing")
        for key in stated:
            value = getattr(self, key)
            if key == "zeta":
                value = from_percentage(key, value)
            DESCRIBED[f"{self.name}.{key}"].check(number(key, value))
            if key == "zeta":
                refuse_critical(key, value)
            self.__dict__[key] = value
        for key in ("k", "c"):
            by_ratio = [ratio for ratio in stated if _RATIOS_OF_DAMPERS[ratio] == key]
            statements = [key, *by_ratio] if getattr(self, key) != 0 else by_ratio
            if len(statements) > 1:
                raise RequestError(f"{statements[0]} beside {statements[1]}: give one of them")
        values = {"m": float(self.m or 0.0), "k": float(self.k)}
        if self.f is not None:
            values["k"] = self.__dict__["k"] = _of("f1", "k").parameter(self.f, values)
        if self.frequency_ratio is not None:  # k is not known before the damper is on a host
            self.__dict__["k"] = nan
            self.__dict__["c"] = nan if self.zeta is not None else self.c
        elif self.zeta is not None:
            self.__dict__["c"] = float(_of("zeta", "c").parameter(self.zeta, values))

    def tuned_to(self, host: Host) -> Damper:
        """Return the damper with the frequency f [Hz] of its `frequency_ratio` on a host."""
        if self.frequency_ratio is None:
            return self
        with at(f"damper {self.name!r}"):
            f = frequency_by_ratio(self.frequency_ratio, host)
        c = 0.0 if self.zeta is not None else self.c
        return replace(self, k=0.0, c=c, f=f, frequency_ratio=None)

    @property
    def statements(self) -> dict[str, float]:
        """The numbers that determine m, k and c: f in place of k, zeta in place of c."""
        values = self.own
        for ratio, key in _RATIOS_OF_DAMPERS.items():
            if getattr(self, ratio) is not None:
                del values[key]
                values[ratio] = float(getattr(self, ratio))
        return values

    def following(self, keys: Collection[str]) -> set[str]:
        """Return those of k and c that change if the numbers of `keys` do, by f and zeta."""
        changed = {*keys}
        if self.f is not None and "m" in changed:
            changed.add("k")
        if self.zeta is not None and not changed.isdisjoint({"m", "k"}):
            changed.add("c")
        return changed - {*keys}

    @property
    def own(self) -> dict[str, float]:
        """Its numbers m, k and c, without a mass k and c."""
        values = {"k": float(self.k), "c": float(self.c)}
        return values if self.m is None else {"m": float(self.m), **values}

    @property
    def places(self) -> tuple[str, ...]:
        """The degree of freedom, or the two, that it is attached to."""
        ends = self.attached_to
        labels = ends if isinstance(ends, tuple) else (ends,)
        return tuple(str(label) for label in labels)

    @property
    def ends(self) -> tuple[str, ...]:
        """The two whose difference is r: a degree of freedom, and its own mass or another one."""
        return self.places if self.m is None else (*self.places, self.name)

    @property
    def stroke(self) -> str:
        """The name of the displacement r along its spring."""
        return "-".join(end for end in self.ends if end != GROUND)

    @property
    def parameters(self) -> dict[str, float]:
        """The numbers by key: m, k, c; gap and constants, those of one wall as gap+ and K-."""
        by_side = [(wall.side, {"gap": wall.gap, **wall.statements}) for wall in self.walls]
        values = self.own
        for key in dict.fromkeys(key for _, constants in by_side for key in constants):
            present = {key + side: c[key] for side, c in by_side if key in c}
            is_common = len(present) == len(by_side) and len({*present.values()}) == 1
            values |= {key: next(iter(present.values()))} if is_common else present
        return values

    @property
    def allowed(self) -> tuple[str, ...]:
        """The keys of `changed`: gap of all walls before gap+ of one."""
        of_walls = [
            (key, wall.side) for wall in self.walls for key in ("gap", *LAWS[wall.law].allowed)
        ]
        keys = dict.fromkeys(key for key, _ in of_walls)
        ratios = ("f", "zeta", "frequency_ratio") if self.m is not None else ()
        return (*self.own, *ratios, *keys, *(key + side for key, side in of_walls))

    def changed(self, values: Mapping[str, Any]) -> Damper:
        """Return the damper with other numbers by key, or `attached_to` another place."""
        of_damper = {}
        for key in ("m", "k", "c", "f", "zeta", PLACE):
            if key in values:
                of_damper[key] = values[key]
        unchanged = self.statements
        for ratio, key in (("f", "k"), ("zeta", "c")):
            if ratio in of_damper or key in of_damper:
                unchanged.pop(ratio, None)
                unchanged.pop(key, None)
        # k and c are computed again if they follow from a ratio
        statements = {"k": 0.0, "c": 0.0, "f": None, "zeta": None, **unchanged, **of_damper}
        walls = []
        for wall in self.walls:
            of_wall = {}
            for name, value in values.items():
                _, key, side = split_name(f".{name}")
                if name not in of_damper and side in ("", wall.side):
                    of_wall[key] = value
            with at(f"damper {self.name!r}"):
                walls.append(wall.changed(of_wall) if of_wall else wall)
        return replace(self, walls=tuple(walls), **statements)


_RATIOS_OF_DAMPERS = {"f": "k", "frequency_ratio": "k", "zeta": "c"}


def frequency_by_ratio(ratio: float, host: Host) -> float:
    """Return the frequency [Hz] of a ratio to that of the host's lowest mode that has one."""
    with at("frequency_ratio"):
        rates = host.frequencies[host.frequencies > 0]
        if rates.size == 0:
            raise RequestError("no mode of the host has a frequency: give f or k")
    return ratio * float(rates[0]) / (2 * pi)


def _of(name: str, gives: str) -> Ratio:
    """Return the ratio of an oscillator that stands for its k or c."""
    return next(one for one in PARAMETERS_BY_RATIO if (one.name, one.gives) == (name, gives))


@dataclass(frozen=True)
class HostScene(Scene):
    """The scene of a host: its near walls are those on the sides "+" of all dampers."""

    of_walls: tuple[tuple[str, str], ...] = ()  # damper and side of each wall, as kernels have them
    settable: tuple[str, ...] = ()  # `HostSystem.allowed` without ratios
    relative: bool = False
    unrecorded: tuple[str, ...] = (
        "modulation", "peak", "clearance", "spectrum", "lines", "broadband",
    )  # fmt: skip
    may_be_empty: tuple[str, ...] = ("impacts",)
    methods: tuple[str, ...] = ("exact",)
    fineness: tuple[str, ...] = ("tolerance",)
    cost: int = 16

    @property
    def allowed(self) -> tuple[str, ...]:
        return self.settable

    @property
    def counted(self) -> tuple[str, ...]:
        return self.wall_words

    @property
    def wall_words(self) -> tuple[str, ...]:
        return tuple(f"{damper}{side}" for damper, side in self.of_walls)

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


def _zero(parameters: Values) -> float:
    return 0.0


@dataclass(frozen=True, eq=False, repr=False)
class HostSystem(Outlined):
    """A host with dampers under a harmonic force or motion of the ground; `System.from_host`.

    Attributes
    ----------
    host : Host
        The linear structure.
    dampers : tuple of Damper
        The dampers.
    force : mapping of str to float
        Amplitudes P [N] of the forces P cos(omega t), by degree of freedom.
    acceleration : float
        In place of a force, the amplitude [m/s^2] of the ground's acceleration.
    omega : float
        Frequency [rad/s].
    name, title : str
        A name, by default "host", and one line that describes the system.
    """

    host: Host
    dampers: tuple[Damper, ...]
    force: Mapping[str, float]
    acceleration: float
    omega: float
    name: str = "host"
    title: str = ""

    kind = HOST
    rest = 0.0  # states count from the rest position
    fixed_ratios: ClassVar[Mapping[str, float]] = MappingProxyType({})

    def heading(self) -> str:
        """Return the title, or the host's heading and the number of dampers."""
        count = len(self.dampers)
        return self.title or f"{self.host.heading()}, {count} damper{'s' * (count != 1)}"

    def outline(self) -> Rows:
        """Return the dampers, the force and the host's frequencies."""
        for damper in self.dampers:
            mass = "" if damper.m is None else f"m = {damper.m:.6g}, "
            place = " and ".join(damper.places)
            yield damper.name, f"{mass}k = {damper.k:.6g}, c = {damper.c:.6g}, on {place}"
        force = numbers(self.force) or f"ground {self.acceleration:.6g} m/s^2"
        yield "force", f"{force}; omega = {self.omega:.6g} rad/s"

    @property
    def period(self) -> float:
        """Forcing period T = 2 pi / omega [s]."""
        return 2 * pi / self.omega

    @property
    def masses(self) -> tuple[Damper, ...]:
        """The dampers that have a mass, which come first."""
        return tuple(damper for damper in self.dampers if damper.m is not None)

    @cached_property
    def scene(self) -> HostScene:
        """The names of the components of states: of the host, then of the dampers' masses.

        Each name stands for a displacement, and v_name for its rate.  If the host was reduced or
        made from modes its coordinates are mode1, mode2 ...: `host.shape` leads to displacements.
        """
        names = self.host.coordinates
        masses = [damper.name for damper in self.masses]
        walls = [(damper.name, wall) for damper in self.dampers for wall in damper.walls]
        sides = {wall.side for _, wall in walls}
        several = len(self.dampers) > 1
        return HostScene(
            kind=self.kind,
            meaning="a host with dampers",
            parameter_names=tuple(self.parameters),
            rest=_zero if self.dampers else None,
            gap_near=_zero if "+" in sides else None,
            gap_far=_zero if "-" in sides else None,
            struck={"near": "+", "far": "-"},
            body="host",
            components=tuple(part for name in (*names, *masses) for part in (name, f"v_{name}")),
            dampers=tuple(damper.name for damper in self.dampers) if several else (),
            of_walls=tuple((name, wall.side) for name, wall in walls),
            settable=tuple(name for name in self.allowed if name not in RATIOS),
            relative=not self.force,
        )

    @property
    def statements(self) -> Mapping[str, float]:
        """The parameters; k and c of a damper also where it states f and zeta."""
        return self.parameters

    @property
    def ratios(self) -> Mapping[str, float]:
        """The frequency f [Hz], by name."""
        return {"f": self.omega / (2 * pi)}

    def following(self, names: Collection[str]) -> set[str]:
        """Return the parameters that change with those of `names`: gap+ and gap- with gap."""
        changed = {part for name in names if name not in INITIAL for part in self.parts(name)}
        for damper in self.dampers:
            prefix = f"{damper.name}."
            keys = [name.removeprefix(prefix) for name in changed if name.startswith(prefix)]
            changed |= {prefix + key for key in damper.following(keys)}
        return {name for name in self.parameters if not changed.isdisjoint(self.parts(name))}

    def with_axes(self, names: Iterable[str]) -> HostSystem:
        """Return the system under the force, or motion of the ground, that varies, if one does.

        Raises `RequestError` for an unknown name, and if two mean one number.
        """
        names = [name for name in names if name not in INITIAL]
        self.refuse_twice(names)
        drives = [name for name in names if name == GROUND or name.startswith(f"{FORCE}.")]
        new = [name for name in drives if name not in self.parameters]
        return self.with_values(new, [0.0] * len(new)) if new else self

    def refuse_corners(self, corners: Iterable[Mapping[str, float]]) -> None:
        """Raise `RequestError` if a corner of a grid is not allowed, as if walls overlap."""
        for corner in corners:
            self.with_(**corner)

    @property
    def drive(self) -> dict[str, float]:
        """The parameters of the force, or of the motion of the ground, by name."""
        names = [name for name in self.parameters if name in ("omega", GROUND)]
        names += [name for name in self.parameters if name.startswith(f"{FORCE}.")]
        return {name: self.parameters[name] for name in names}

    @property
    def contact_in_words(self) -> dict[str, float]:
        """Return nothing: each wall has constants of its own."""
        return {}

    @property
    def contact_laws(self) -> tuple[Law, ...]:
        """The laws of the walls."""
        return tuple(LAWS[wall.law] for damper in self.dampers for wall in damper.walls)

    def strokes(self, values: Mapping[str, Any], state: Mapping[str, Any]) -> list[Stroke]:
        """Return the strokes of the dampers in states, as `System.strokes` does."""
        zero, strokes = np.zeros(()), []
        places = [state.get(name, 0.0) for name in self.scene.components[::2]]
        for damper, row in zip(self.dampers, self.rows(), strict=True):
            terms = [weight * place for weight, place in zip(row, places, strict=True)]
            walls = []
            for wall in damper.walls:
                gap = values.get(f"{damper.name}.gap", wall.gap)
                gap = values.get(f"{damper.name}.gap{wall.side}", gap)
                walls.append((SIDES[wall.side], gap))
            strokes.append(Stroke(sum(terms, zero), sum(map(np.abs, terms), zero), walls))
        return strokes

    def alone(self) -> HostSystem:
        """Return the host without its dampers, under the same force."""
        return replace(self, dampers=(), name="host", title="")

    def cells(self, grid: Mapping[str, Any] = MappingProxyType({})) -> np.ndarray:
        """Return records of omega and of the varied parameters, one for each point of a grid.

        `grid` holds arrays by name that broadcast together; `with_values` takes the numbers of a
        record.  Raises `RequestError` for a value out of range.
        """
        values = {name: np.asarray(values, dtype=np.float64) for name, values in grid.items()}
        for name, array in values.items():
            if name not in DESCRIBED:
                raise unknown("parameter", name, self.allowed)
            DESCRIBED[name].check(array)
        values = {"omega": np.asarray(self.omega), **values}
        shape = np.broadcast_shapes(*(array.shape for array in values.values()))
        cells = np.zeros(shape, [(name, np.float64) for name in values])
        for name, array in values.items():
            cells[name] = array
        return cells

    @cached_property
    def parameters(self) -> Mapping[str, float]:
        """The numbers by name: cell1.k, cell1.gap, force.roof or ground, omega [SI].

        Of two walls with different numbers each has its own: cell1.gap+, cell1.gap-.
        """
        of_dampers = {
            f"{damper.name}.{key}": value
            for damper in self.dampers
            for key, value in damper.parameters.items()
        }
        forces = {f"{FORCE}.{dof}": P for dof, P in self.force.items()}
        drive = forces or {GROUND: self.acceleration}
        return MappingProxyType({**of_dampers, **drive, "omega": self.omega})

    @cached_property
    def allowed(self) -> tuple[str, ...]:
        """The names of all numbers that `with_` replaces, and that an axis may have."""
        of_dampers = (f"{damper.name}.{k}" for damper in self.dampers for k in damper.allowed)
        forces = (f"{FORCE}.{dof}" for dof in self.host.places)
        return (*of_dampers, *forces, GROUND, "omega", "f")

    def parts(self, name: str) -> tuple[str, ...]:
        """Return the names of single numbers that a name means: gap+ and gap- for gap.

        Raises `RequestError` for a name that the system does not have.
        """
        owner, key, side = split_name(name)
        damper = next((damper for damper in self.dampers if damper.name == owner), None)
        if owner == FORCE and key:
            choice("degree of freedom", key, self.host.places)
        elif damper and key and key + side not in (*damper.allowed, PLACE):
            with at(f"damper {owner!r}"):
                keys = [key for key in damper.allowed if key[-1] not in SIDES]
                raise unknown("parameter", key + side, [*keys, PLACE])
        elif not (damper and key) and name not in ("omega", "f", GROUND):
            raise unknown("parameter", name, dict.fromkeys([*self.parameters, GROUND, "f"]))
        if damper is None or side:
            return ("omega",) if name == "f" else (name,)
        if key in _RATIOS_OF_DAMPERS:
            return (f"{owner}.{_RATIOS_OF_DAMPERS[key]}",)
        sides = (wall.side for wall in damper.walls if key in ("gap", *LAWS[wall.law].allowed))
        return tuple(name + wall for wall in sides) or (name,)

    def refuse_twice(self, names: Iterable[str]) -> None:
        """Raise `RequestError` for an unknown name, and if two of `names` mean one number."""
        names, first = [*names], dict[str, str]()
        for name in names:
            for part in self.parts(name):
                if first.setdefault(part, name) != name:
                    raise RequestError(f"{first[part]} beside {name}: give one of them")
        forces = [name for name in names if name.startswith(f"{FORCE}.")]
        if forces and GROUND in names:
            raise RequestError(f"{GROUND} beside {forces[0]}: give one of them")

    def with_(self, /, **changes: Any) -> HostSystem:
        """Replace numbers, and places of dampers.

        Parameters
        ----------
        **changes
            By name, SI units: `cell1.m`, `cell1.k`, `cell1.c` of the damper cell1, `cell1.f` [Hz]
            or `cell1.frequency_ratio` in place of k and `cell1.zeta` in place of c; `cell1.gap` and
            constants of all its walls, `cell1.gap+` of one, `cell1.attached_to`; `force.roof` and
            `ground`, which replace each other; `omega`, or `f` [Hz].  A table replaces the numbers
            of one damper: `cell1={"k": 300.0}`.

        Returns
        -------
        HostSystem
            A new system; the host is the same object.

        Raises
        ------
        RequestError
            For an unknown name, two names of one number, and as `Damper` and `Wall`.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
        >>> cell = nv.Damper("cell", attached_to="roof", m=900.0, walls=[nv.Wall(0.05, K=1e8)])
        >>> system = nv.System.from_host(frame, [cell], force={"roof": 700.0}, omega=12.6)
        >>> system.with_(**{"cell.gap": 0.02, "f": 2.0}).parameters["cell.gap"]
        0.02
        """
        values = flat(changes)
        self.refuse_twice(values)
        for name in values:
            if not name.endswith(f".{PLACE}"):
                values[name] = number(name, values[name])
                DESCRIBED[name].check(values[name])
        system = self.with_values(values, values.values())
        check_places(self.host, system.dampers)
        return system

    def with_values(self, names: Iterable[str], values: Iterable[Any]) -> HostSystem:
        """Return the system with other numbers by names that `refuse_twice` allows.

        Neither names nor ranges are checked: one call for each cell of a scan.
        """
        omega, forces, acceleration = self.omega, self.force, self.acceleration
        of_dampers: dict[str, dict[str, Any]] = {}
        for name, value in zip(names, values, strict=True):
            owner, _, key = name.partition(".")
            if name in ("omega", "f"):
                omega = value if name == "omega" else value * (2 * pi)
            elif name == GROUND:
                forces, acceleration = {}, value
            elif owner == FORCE:
                forces, acceleration = {**forces, key: value}, 0.0
            elif key == "frequency_ratio":
                of_dampers.setdefault(owner, {})["f"] = frequency_by_ratio(value, self.host)
            else:
                of_dampers.setdefault(owner, {})[key] = value
        dampers = tuple(
            damper.changed(of_dampers[damper.name]) if damper.name in of_dampers else damper
            for damper in self.dampers
        )
        return replace(
            self,
            dampers=dampers,
            force=MappingProxyType(dict(forces)),
            acceleration=acceleration,
            omega=omega,
        )

    def to_table(self) -> dict[str, Any]:
        """Return the `[system]` table of a request file that describes exactly this system."""
        from nlds_vines.model.host import table_of

        dampers = [
            {
                "name": damper.name,
                PLACE: list(damper.places) if damper.m is None else damper.places[0],
                **damper.statements,
                "walls": [
                    {"gap": wall.gap, "side": wall.side, "law": wall.law, **wall.statements}
                    for wall in damper.walls
                ],
            }
            for damper in self.dampers
        ]
        drive: dict[str, Any] = {"omega": self.omega}
        if self.force:
            drive["at"] = dict(self.force)
        else:
            drive["base"] = {"acceleration": self.acceleration}
        return {
            "kind": self.kind,
            **{key: getattr(self, key) for key in ("name", "title") if getattr(self, key)},
            "host": table_of(self.host),
            **({"dampers": dampers} if dampers else {}),
            "force": drive,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        return host_system_from, (self.to_table(),)

    def attributes(self, varied: Collection[str] = ()) -> dict[str, str | float]:
        """Return the attributes by which an archive describes the system [SI], without `varied`."""
        gone = self.following(varied)
        values = {name: value for name, value in self.parameters.items() if name not in gone}
        return {
            "system": self.name,
            "kind": self.kind,
            "host": self.host.heading(),
            **values,
            **{f"{damper.name}.{PLACE}": " and ".join(damper.places) for damper in self.dampers},
            **{
                f"{damper.name}.law{wall.side}": wall.law
                for damper in self.dampers
                for wall in damper.walls
            },
        }

    def rows(self) -> np.ndarray:
        """Return w of r = w X of each damper, (dampers, coordinates and masses)."""
        rows = np.zeros((len(self.dampers), len(self.host.inertia) + len(self.masses)))
        for row, damper in zip(rows, self.dampers, strict=True):
            for place, sign in zip(damper.ends, (1.0, -1.0), strict=True):
                if place != GROUND:
                    row += sign * self._row(place)
        return rows

    def _row(self, name: str) -> np.ndarray:
        """Return the row of a degree of freedom or of a damper's mass."""
        count, masses = len(self.host.inertia), [damper.name for damper in self.masses]
        row = np.zeros(count + len(masses))
        if name in masses:
            row[count + masses.index(name)] = 1.0
        else:
            row[:count] = self.host.row(name)
        return row

    def displacements(
        self, names: Sequence[str] = (), records: Collection[str] = ("response",)
    ) -> tuple[str, ...]:
        """Return the names of displacements whose response is recorded, checked.

        By default the degrees of freedom that dampers hang on; all of them if there are no dampers.
        """
        names = (names,) if isinstance(names, str) else tuple(names)
        if "response" not in records:
            if names:
                raise RequestError(f"of = {shown(list(names))}: the response is not recorded")
            return ()
        for name in names:
            self.displacement(name)
        usual = [damper.places[0] for damper in self.dampers]
        return tuple(dict.fromkeys(names or usual or self.host.dofs))

    def displacement(self, name: str) -> tuple[np.ndarray, float]:
        """Return the row of a displacement, and its value when the ground moves by 1.

        It is that of a degree of freedom "roof", of a damper's mass "cell1", or a difference,
        "roof-floor2".  Raises `RequestError` for other names.
        """
        places = {damper.name: damper.places[0] for damper in self.masses}
        allowed = (*self.host.dofs, *places)
        if name not in allowed:
            for i in (i for i, letter in enumerate(name) if letter == "-"):
                if name[:i] in allowed and name[i + 1 :] in allowed:
                    row, moved = self.displacement(name[:i])
                    other, beside = self.displacement(name[i + 1 :])
                    return row - other, moved - beside
        choice("displacement", name, allowed)
        dof = self.host.dofs.index(places.get(name, name))
        return self._row(name), float(self.host.influence[dof])

    def push(self) -> np.ndarray:
        """Return the force [N] on each coordinate and mass at cos(omega t) = 1."""
        if self.force:
            push = np.zeros(len(self.host.inertia) + len(self.masses))
            for dof, P in self.force.items():
                push += P * self._row(dof)
            return push
        on_masses = [
            -self.acceleration * float(damper.m or 0) * self.displacement(damper.name)[1]
            for damper in self.masses
        ]
        return np.concatenate([-self.acceleration * self.host.inertia, on_masses])

    def under(self, load: Any) -> HostSystem:
        """Return the system under 1 N on each of the load's degrees of freedom times its factor.

        Under a motion of the ground, it is one by -1 m/s^2, as the load is minus its acceleration.
        Raises `RequestError` for degrees of freedom that are missing, out of place or unknown.
        """
        if load.shaken:
            if load.on is not None:
                raise RequestError("on: the loads move the ground, and no degree of freedom else")
            return replace(self, force=MappingProxyType({}), acceleration=-1.0)
        dofs, on = self.host.places, load.on
        if on is None:
            if len(dofs) > 1:
                names = ", ".join(dofs)
                raise RequestError(f"on is missing, the degree of freedom of the force: {names}")
            on = dofs[0]
        factors = {on: 1.0} if isinstance(on, str) else dict(on)
        for dof in factors:
            choice("degree of freedom in on", dof, dofs)
        return replace(self, force=MappingProxyType(factors), acceleration=0.0)


def system_from_host(
    host: Host,
    dampers: Sequence[Damper],
    force: Mapping[str, float] | None,
    base: Mapping[str, Any] | None,
    omega: float | None,
    name: str,
    title: str,
) -> HostSystem:
    """Return the checked system; see `System.from_host`."""
    from nlds_vines.model.host import Host, with_influence

    if not isinstance(host, Host):
        raise RequestError(f"host = {shown(host)} must be a Host")
    if force is None and base is None and omega is None:
        base, omega = {"acceleration": 0.0}, 1.0  # a system for loads in time
    if omega is None:
        raise RequestError("omega is missing, the frequency [rad/s]")
    PARAMETERS["omega"].check(number("omega", omega))
    if (force is None) == (base is None):
        raise RequestError("a system needs one of force and base")
    forces, acceleration = {}, 0.0
    if base is not None:
        table("base", base, ("influence", "acceleration"))
        influence = base.get("influence", ALL)
        if influence != ALL:
            influence = by_dof_names("influence", influence)
            host = with_influence(host, table("influence", influence))
        acceleration = number("acceleration", base.get("acceleration"))
    else:
        for dof, P in table("force", by_dof_names("force", force)).items():
            choice("degree of freedom of the force", dof, host.places)
            forces[dof] = number(f"force.{dof}", P)
    if not _are(Damper, dampers):
        raise RequestError(f"dampers = {shown(dampers)} must be a list of Damper")
    # dampers with a mass come first, as the links of kernels do
    tuned = [damper.tuned_to(host) for damper in dampers]
    ordered = tuple(sorted(tuned, key=lambda damper: damper.m is None))
    check_places(host, ordered)
    words = string("name", name) or HOST, string("title", title)
    system = HostSystem(host, ordered, MappingProxyType(forces), acceleration, float(omega), *words)
    component, count = Counter(system.scene.components).most_common(1)[0]
    if count > 1:
        raise RequestError(f"{component!r} names two components of states: take another name")
    return system


def host_system_from(
    entry: Mapping[str, Any], name: str = "", *, needs_force: bool = True
) -> HostSystem:
    """Return the system of a table `[system]` of kind "host", by default with a `name`."""
    from nlds_vines.model.host import host_from

    table("system", entry, HOST_SYSTEM_KEYS)
    damper_entries, drive = entry.get("dampers", []), entry.get("force")
    if not isinstance(damper_entries, list):
        raise RequestError(f"dampers = {shown(damper_entries)} must be tables [[system.dampers]]")
    dampers = []
    for place, one in enumerate(damper_entries, start=1):
        with at(f"[[system.dampers]] {place}"):
            dampers.append(_damper_from(one))
    if drive is None and needs_force:
        raise RequestError("force is missing: give [system.force] with omega, and at or base")
    if drive is None:
        drive = {"base": {"acceleration": 0.0}, "omega": 1.0}
    with at("[system.force]"):
        drive = table("force", drive, FORCE_KEYS)
        if ("omega" in drive) == ("f" in drive):
            raise RequestError("one of omega and f must be given")
        rate = number("f", drive["f"]) * (2 * pi) if "f" in drive else drive["omega"]
        forced = drive.get("at")
    used = [end for damper in dampers for end in damper.places if end != GROUND]
    used += forced if isinstance(forced, Mapping) else []
    with at("[system.host]"):
        host = host_from(table("host", entry.get("host", {})), [*dict.fromkeys(used)])
    words = entry.get("name", name), entry.get("title", "")
    return system_from_host(host, dampers, forced, drive.get("base"), rate, *words)


HOST_SYSTEM_KEYS = ("kind", "name", "title", "host", "dampers", "force")
FORCE_KEYS = ("at", "base", "omega", "f")
_OF_LAWS = tuple(dict.fromkeys(name for law in LAWS.values() for name in law.allowed))
_OF_DAMPERS = ("name", PLACE, "m", "k", "c", *_RATIOS_OF_DAMPERS)
DAMPER_KEYS = (*_OF_DAMPERS, "walls", "law", *_OF_LAWS)
WALL_KEYS = ("gap", "side", "law", *_OF_LAWS)


def _damper_from(entry: Any) -> Damper:
    """Return the damper of a table, whose law and constants are those of walls without others."""
    values = table("a damper", entry, DAMPER_KEYS, _OF_DAMPERS[:2])
    law, walls = values.get("law", HERTZ.name), values.get("walls", [])
    constants = {key: value for key, value in values.items() if key in _OF_LAWS}
    if not isinstance(walls, list):
        raise RequestError(f"walls = {shown(walls)} must be a list of tables")
    made = []
    for number_of_wall, wall in enumerate(walls, start=1):
        with at(f"wall {number_of_wall}"):
            entries = table("a wall", wall, WALL_KEYS, ["gap"])
            shared = constants if entries.get("law", law) == law else {}
            made.append(Wall(**{"law": law, **shared, **entries}))
    return Damper(**{key: values[key] for key in _OF_DAMPERS if key in values}, walls=made)


def check_places(host: Host, dampers: Sequence[Damper]) -> None:
    """Refuse a name that stands twice, and a place that the host does not have or that rests."""
    names = list(host.dofs)
    for damper in dampers:
        if damper.name in names:
            raise RequestError(f"damper {damper.name!r}: the name is taken")
        names.append(damper.name)
        with at(f"damper {damper.name!r}"):
            for i, place in enumerate(damper.places):
                choice("attached_to", place, (*host.places, GROUND) if i else host.places)
                if place != GROUND and not np.any(host.row(place)):
                    raise RequestError(
                        f"no mode of the host moves {place!r}: keep more modes, or its static "
                        "response"
                    )
