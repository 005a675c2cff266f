"""Dampers on a host: `Damper`, its `Wall`s and its `Spring`, and all from tables of a file."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import nan, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.representation import numbers
from nlds_vines.errors import (
    RequestError,
    at,
    check_name,
    choice,
    dof_name,
    number,
    shown,
    table,
    unknown,
)
from nlds_vines.model.parameters import (
    DAMPING,
    DESCRIBED,
    GROUND,
    HERTZ,
    LAWS,
    PARAMETERS,
    RESERVED,
    SIDES,
    hertz_stiffness,
    split_name,
)
from nlds_vines.model.ratios import RATIOS as PARAMETERS_BY_RATIO
from nlds_vines.model.ratios import Ratio, from_percentage, refuse_critical
from nlds_vines.model.scenes import LONGEST_NAME

if TYPE_CHECKING:
    from nlds_vines.model.host import Host  # with SciPy

PLACE = "attached_to"  # the key of a damper's place, which is no number


def all_are(kind: type, values: object) -> bool:
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


@dataclass(frozen=True, init=False, repr=False)
class Spring:
    """What a damper's spring adds to its linear force: a polynomial in the displacement r.

    The force of the whole spring is k r + k2 r^2 + k3 r^3 + k5 r^5 with the k of its damper, and r
    is positive where the spring is shortened, as at a `Wall` on side "+".

    Parameters
    ----------
    k2, k3, k5 : float, optional
        Coefficients [N/m^2, N/m^3, N/m^5] of either sign; at least one of them, which may be 0.
        Those that are given are parameters of the damper: `nes.k3`.
    **others
        Any other name is refused.

    Raises
    ------
    RequestError
        If no coefficient is given, or one that is not finite, and for another power of r: |r|^n
        of any n is the force of a wall under the law "power".

    See Also
    --------
    Damper, Wall

    Notes
    -----
    k2 alone, and negative coefficients of the highest power, are refused with the damper: the
    energy k r^2 / 2 + k2 r^3 / 3 + k3 r^4 / 4 + k5 r^6 / 6 must have a lower bound.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.Spring(k3=1e5)
    Spring: k3 = 100000
    """

    k2: float
    k3: float
    k5: float
    given: tuple[str, ...]

    def __init__(
        self,
        k2: float | None = None,
        k3: float | None = None,
        k5: float | None = None,
        **others: object,
    ) -> None:
        if others:
            raise RequestError(
                f"{next(iter(others))} is no coefficient of a spring; allowed: "
                f"{', '.join(SPRING_KEYS)}. A force K |r|^n with another n is that of two walls "
                'with gap 0 under law = "power"'
            )
        values = {"k2": k2, "k3": k3, "k5": k5}
        given = tuple(key for key, value in values.items() if value is not None)
        if not given:
            raise RequestError(f"a spring needs a coefficient: {', '.join(SPRING_KEYS)}")
        for key, value in values.items():
            self.__dict__[key] = 0.0 if value is None else number(key, value)
        self.__dict__["given"] = given

    @property
    def statements(self) -> dict[str, float]:
        """The coefficients that were given, by name."""
        return {key: getattr(self, key) for key in self.given}

    def changed(self, values: Mapping[str, float]) -> Spring:
        """Return the spring with other values of coefficients that were given."""
        return Spring(**{key: values.get(key, value) for key, value in self.statements.items()})

    def force(self, r: Any) -> Any:
        """Return k2 r^2 + k3 r^3 + k5 r^5 [N], without k r."""
        square = r * r
        return square * (self.k2 + r * (self.k3 + square * self.k5))

    def slope(self, r: Any) -> Any:
        """Return the derivative of `force`, 2 k2 r + 3 k3 r^2 + 5 k5 r^4 [N/m]."""
        square = r * r
        return r * (2.0 * self.k2 + r * (3.0 * self.k3 + 5.0 * square * self.k5))

    def energy(self, r: Any) -> Any:
        """Return the potential of `force`, k2 r^3 / 3 + k3 r^4 / 4 + k5 r^6 / 6 [J]."""
        square = r * r
        return r * square * (self.k2 / 3.0 + r * (self.k3 / 4.0 + square * self.k5 / 6.0))

    def __repr__(self) -> str:
        return f"Spring: {numbers(self.statements)}"


SPRING_KEYS = ("k2", "k3", "k5")


def has_lower_bound(k: Any, k2: Any, k3: Any, k5: Any) -> Any:
    """Return True if the energy k r^2 / 2 + k2 r^3 / 3 + k3 r^4 / 4 + k5 r^6 / 6 is bounded below.

    The sign of the highest even power decides; without r^4 and r^6, a cubic term has no bound.
    """
    k, k2, k3, k5 = np.broadcast_arrays(k, k2, k3, k5)
    is_convex = (k2 == 0.0) & (k >= 0.0)
    without_sixth = (k3 > 0.0) | ((k3 == 0.0) & is_convex)
    return (k5 > 0.0) | ((k5 == 0.0) & without_sixth)


def refuse_unbounded(name: str, has_spring: bool, k: Any, k2: Any, k3: Any, k5: Any) -> None:
    """Raise `RequestError` if the energy of a damper's spring has no lower bound; also of arrays.

    Without a nonlinear spring it is k >= 0 that is needed.
    """
    if not has_spring:
        replace(DESCRIBED[f"{name}.k"], low=0.0).check(k)
        return
    coefficients = np.broadcast_arrays(k, k2, k3, k5)
    wrong = ~np.atleast_1d(has_lower_bound(*coefficients))
    if np.any(wrong):
        first = [float(np.atleast_1d(values)[wrong].flat[0]) for values in coefficients]
        stated = numbers(dict(zip(("k", *SPRING_KEYS), first, strict=True)))
        raise RequestError(
            f"{stated} are not allowed: the energy of the spring of {name}, "
            "k r^2/2 + k2 r^3/3 + k3 r^4/4 + k5 r^6/6, must have a lower bound: k5 > 0; or k5 = 0 "
            "and k3 > 0; or k >= 0 alone"
        )


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
        Stiffness [N/m] and damping [N s/m] of its joint, by default 0.  k may be negative beside
        a `spring` with k3 > 0 or k5 > 0: such a damper is bistable.
    walls : sequence of Wall, optional
        One or two walls, by default none: a tuned mass damper.
    f : float, optional
        In place of k, the frequency [Hz] of its mass on a structure at rest: k = (2 pi f)^2 m.
    zeta : float or str, optional
        In place of c, its damping ratio on a structure at rest, 0.1 or "10%", below 1:
        c = 2 zeta sqrt(k m).
    frequency_ratio : float, optional
        In place of k and f, its frequency over that of the lowest mode of the host alone that has
        one; k is known once the damper is on a host, `System.from_host`.
    spring : Spring, optional
        Nonlinear terms of its spring, by default none.

    Raises
    ------
    RequestError
        For a mass that is missing or out of place, a negative value, two statements of k or of c,
        walls that overlap, and a spring whose energy has no lower bound.

    Notes
    -----
    What is stated as f, zeta or frequency_ratio stays, and k and c follow, if the mass changes, or
    the host.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.Damper("cell", attached_to="roof", m=30.0, k=334.0, walls=[nv.Wall(0.05, K=3e7)]).m
    30.0
    >>> nv.Damper("nes", attached_to="roof", m=30.0, k=-20.0, spring=nv.Spring(k3=1e5)).spring
    Spring: k3 = 100000
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
    spring: Spring | None = None

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
            if not isinstance(self.spring, Spring | None):
                raise RequestError(f"spring = {shown(self.spring)} must be a Spring")
            self._follow_ratios()
            self._check_energy()
            if not all_are(Wall, self.walls):
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
        stated = [key for key in RATIOS_OF_DAMPERS if getattr(self, key) is not None]
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
            by_ratio = [ratio for ratio in stated if RATIOS_OF_DAMPERS[ratio] == key]
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

    def _check_energy(self) -> None:
        """Refuse a spring whose energy has no lower bound."""
        # a k by a frequency ratio, which is >= 0, is not known yet
        k = 0.0 if self.frequency_ratio is not None else float(self.k)
        refuse_unbounded(self.name, self.spring is not None, k, *self.coefficients)

    def tuned_to(self, host: Host) -> Damper:
        """Return the damper with the k, and the c by zeta, of its `frequency_ratio` on a host."""
        if self.frequency_ratio is None:
            return self
        with at(f"damper {self.name!r}: frequency_ratio"):
            rates = host.frequencies[host.frequencies > 0]
            if rates.size == 0:
                raise RequestError("no mode of the host has a frequency: give f or k")
        f = self.frequency_ratio * float(rates[0]) / (2 * pi)
        c = 0.0 if self.zeta is not None else self.c
        tuned = replace(self, k=0.0, c=c)
        by_frequency = replace(self, k=0.0, c=c, f=f, frequency_ratio=None)
        tuned.__dict__["k"] = by_frequency.k
        tuned.__dict__["c"] = by_frequency.c
        return tuned

    @property
    def statements(self) -> dict[str, float]:
        """The numbers that determine m, k and c: f in place of k, zeta in place of c."""
        values = self.own
        for ratio, key in RATIOS_OF_DAMPERS.items():
            if getattr(self, ratio) is not None:
                del values[key]
                values[ratio] = float(getattr(self, ratio))
        return values

    def following(self, keys: Collection[str]) -> set[str]:
        """Return those of k and c that change if the numbers of `keys` do, by f and zeta."""
        changed = {*keys}
        has_frequency = self.f is not None or self.frequency_ratio is not None
        if has_frequency and "m" in changed:
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
    def coefficients(self) -> tuple[float, float, float]:
        """k2, k3 and k5 [N/m^2, N/m^3, N/m^5] of its spring; 0 without one."""
        if self.spring is None:
            return 0.0, 0.0, 0.0
        return self.spring.k2, self.spring.k3, self.spring.k5

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
    def has_force(self) -> bool:
        """Whether a wall has a law under which impacts take time."""
        return any(not LAWS[wall.law].instant for wall in self.walls)

    @property
    def stroke(self) -> str:
        """The name of the displacement r along its spring."""
        return "-".join(end for end in self.ends if end != GROUND)

    @property
    def parameters(self) -> dict[str, float]:
        """The numbers by key: m, k, c; k3; gap and constants, those of one wall as gap+ and K-."""
        by_side = [(wall.side, {"gap": wall.gap, **wall.statements}) for wall in self.walls]
        values = self.own
        if self.spring is not None:
            values |= self.spring.statements
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
        of_spring = () if self.spring is None else self.spring.given
        return (*self.own, *ratios, *of_spring, *keys, *(key + side for key, side in of_walls))

    def changed(self, values: Mapping[str, Any]) -> Damper:
        """Return the damper with other numbers by key, or `attached_to` another place."""
        of_damper = {}
        for key in ("m", "k", "c", *RATIOS_OF_DAMPERS, PLACE):
            if key in values:
                of_damper[key] = values[key]
        unchanged = self.statements
        for statements_of_one in (("k", "f", "frequency_ratio"), ("c", "zeta")):
            if not of_damper.keys().isdisjoint(statements_of_one):
                for key in statements_of_one:
                    unchanged.pop(key, None)
        # k and c are computed again if they follow from a ratio
        none_stated = {"k": 0.0, "c": 0.0, **dict.fromkeys(RATIOS_OF_DAMPERS)}
        statements = {**none_stated, **unchanged, **of_damper}
        walls = []
        for wall in self.walls:
            of_wall = {}
            for name, value in values.items():
                _, key, side = split_name(f".{name}")
                if name not in (*of_damper, *SPRING_KEYS) and side in ("", wall.side):
                    of_wall[key] = value
            with at(f"damper {self.name!r}"):
                walls.append(wall.changed(of_wall) if of_wall else wall)
        spring = self.spring
        if spring is not None and not values.keys().isdisjoint(spring.given):
            with at(f"damper {self.name!r}"):
                spring = spring.changed(values)
        return replace(self, walls=tuple(walls), spring=spring, **statements)


RATIOS_OF_DAMPERS = {"f": "k", "frequency_ratio": "k", "zeta": "c"}


def _of(name: str, gives: str) -> Ratio:
    """Return the ratio of an oscillator that stands for its k or c."""
    return next(one for one in PARAMETERS_BY_RATIO if (one.name, one.gives) == (name, gives))


_OF_LAWS = tuple(dict.fromkeys(name for law in LAWS.values() for name in law.allowed))
_OF_DAMPERS = ("name", PLACE, "m", "k", "c", *RATIOS_OF_DAMPERS)
DAMPER_KEYS = (*_OF_DAMPERS, "spring", "walls", "law", *_OF_LAWS)
WALL_KEYS = ("gap", "side", "law", *_OF_LAWS)


def damper_from(entry: Any) -> Damper:
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
    spring = None
    if "spring" in values:
        with at("spring"):
            spring = Spring(**table("a spring", values["spring"]))
    of_damper = {key: values[key] for key in _OF_DAMPERS if key in values}
    return Damper(**of_damper, walls=made, spring=spring)


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
