"""A host with dampers and walls between its degrees of freedom: the system of kind `host`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import RequestError, at, choice, number, shown, string, table, unknown
from nlds_vines.model.host import Host
from nlds_vines.model.parameters import DAMPING, HERTZ, LAWS, PARAMETERS, hertz_stiffness

GROUND = "ground"
SIDES = {"+": 1.0, "-": -1.0}


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
        if replaces and replaces not in values:
            values[replaces] = float(hertz_stiffness(*(values[name] for name in needed)))
        self.constants: Mapping[str, float] = MappingProxyType(values)

    @property
    def is_damped(self) -> bool:
        """Whether the contact dissipates by Hunt and Crossley's factor."""
        return self.constants.get(DAMPING, 0.0) > 0.0

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
    attached_to : str or (str, str)
        The degree of freedom that its mass hangs on; or two, the second of which may be "ground",
        of a damper without a mass of its own.
    m : float, optional
        Its mass [kg].
    k, c : float, optional
        Stiffness [N/m] and damping [N s/m] of its joint, by default 0.
    walls : sequence of Wall, optional
        One or two walls, by default none: a tuned mass damper.

    Raises
    ------
    RequestError
        For a mass that is missing or out of place, a negative value, and walls that overlap.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.Damper("cell", attached_to="roof", m=30.0, k=334.0, walls=[nv.Wall(0.05, K=3e7)]).m
    30.0
    """

    name: str
    attached_to: str | Sequence[str]
    m: float | None = None
    k: float = 0.0
    c: float = 0.0
    walls: Sequence[Wall] = ()

    def __post_init__(self) -> None:
        if not string("name", self.name) or "." in self.name:
            raise RequestError(f"name = {shown(self.name)} must be a text without a point")
        with at(f"damper {self.name!r}"):
            has_mass = isinstance(self.attached_to, str)
            if not has_mass and len(tuple(self.attached_to)) != 2:
                raise RequestError(
                    f"attached_to = {shown(self.attached_to)} must be a degree of freedom or two"
                )
            if has_mass == (self.m is None):
                raise RequestError(
                    "a mass m is missing" if has_mass else "has no mass m between two bodies"
                )
            if self.m is not None and number("m", self.m) <= 0:
                raise RequestError(f"m = {self.m:g} must be > 0 [kg]")
            for name in ("k", "c"):
                if number(name, getattr(self, name)) < 0:
                    raise RequestError(f"{name} = {getattr(self, name):g} must be >= 0")
            walls = tuple(self.walls)
            if not all(isinstance(wall, Wall) for wall in walls):
                raise RequestError(f"walls = {shown(self.walls)} must be a list of Wall")
            sides = [wall.side for wall in walls]
            if len(set(sides)) < len(sides):
                raise RequestError("two walls are on one side; allowed: one on each")
            if len(walls) == 2 and sum(wall.gap for wall in walls) < 0:
                overlap = -sum(wall.gap for wall in walls)
                raise RequestError(
                    f"its walls overlap by {overlap:g} m: the sum of their gaps must be >= 0"
                )
            self.__dict__["walls"] = walls


@dataclass(frozen=True, repr=False)
class HostScene(Outlined):
    """The names of the components of states."""

    components: tuple[str, ...]


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
    """

    host: Host
    dampers: tuple[Damper, ...]
    force: Mapping[str, float]
    acceleration: float
    omega: float

    kind = "host"
    name = "host"

    def heading(self) -> str:
        """Return the host's heading and the number of dampers."""
        return f"{self.host.heading()}, {len(self.dampers)} dampers"

    def outline(self) -> Rows:
        """Return the dampers, the force and the host's frequencies."""
        for damper in self.dampers:
            mass = "" if damper.m is None else f"m = {damper.m:.6g}, "
            place = damper.attached_to if damper.m else " and ".join(damper.attached_to)
            yield damper.name, f"{mass}k = {damper.k:.6g}, c = {damper.c:.6g}, on {place}"
        force = numbers(self.force) or f"ground {self.acceleration:.6g} m/s^2"
        yield "force", f"{force}; omega = {self.omega:.6g} rad/s"

    @property
    def period(self) -> float:
        """Forcing period T = 2 pi / omega [s]."""
        return 2 * pi / self.omega

    @cached_property
    def scene(self) -> HostScene:
        """The names of the components of states: of the host, then of the dampers' masses.

        Each name stands for a displacement, and v_name for its rate.  If the host was reduced or
        made from modes its coordinates are mode1, mode2 ...: `host.shape` leads to displacements.
        """
        count = len(self.host.inertia)
        is_plain = self.host.is_plain
        names = self.host.dofs if is_plain else [f"mode{i + 1}" for i in range(count)]
        masses = [damper.name for damper in self.dampers if damper.m is not None]
        return HostScene(tuple(part for name in (*names, *masses) for part in (name, f"v_{name}")))

    def rows(self) -> np.ndarray:
        """Return w of r = w X of each damper, (dampers, coordinates and masses)."""
        masses = [damper for damper in self.dampers if damper.m is not None]
        count = len(self.host.inertia)
        rows = np.zeros((len(self.dampers), count + len(masses)))
        for row, damper in zip(rows, self.dampers, strict=True):
            if isinstance(damper.attached_to, str):
                row[:count] = self.host.row(damper.attached_to)
                row[count + masses.index(damper)] = -1.0
            else:
                one, other = damper.attached_to
                row[:count] = self.host.row(one)
                if other != GROUND:
                    row[:count] -= self.host.row(other)
        return rows

    def push(self) -> np.ndarray:
        """Return the force [N] on each coordinate and mass at cos(omega t) = 1."""
        masses = [damper for damper in self.dampers if damper.m is not None]
        if self.force:
            on_host = sum(
                (P * self.host.row(dof) for dof, P in self.force.items()),
                np.zeros(len(self.host.inertia)),
            )
            return np.concatenate([on_host, np.zeros(len(masses))])
        on_masses = [
            -self.acceleration * float(damper.m or 0) * self.host.moved(str(damper.attached_to))
            for damper in masses
        ]
        return np.concatenate([-self.acceleration * self.host.inertia, on_masses])


def system_from_host(
    host: Host,
    dampers: Sequence[Damper],
    force: Mapping[str, float] | None,
    base: Mapping[str, Any] | None,
    omega: float,
) -> HostSystem:
    """Return the checked system; see `System.from_host`."""
    if not isinstance(host, Host):
        raise RequestError(f"host = {shown(host)} must be a Host")
    if number("omega", omega) <= 0:
        raise RequestError(f"omega = {omega:g} must be > 0 [rad/s]")
    if (force is None) == (base is None):
        raise RequestError("a system needs one of force and base")
    forces, acceleration = {}, 0.0
    if base is not None:
        table("base", base, ("influence", "acceleration"))
        choice("influence", base.get("influence", "all"), ("all",))
        acceleration = number("acceleration", base.get("acceleration"))
    else:
        for dof, P in table("force", force, host.dofs).items():
            forces[dof] = number(f"force.{dof}", P)
    names = list(host.dofs)
    # dampers with a mass come first, as the links of kernels do
    ordered = sorted(dampers, key=lambda damper: damper.m is None)
    for damper in ordered:
        if not isinstance(damper, Damper):
            raise RequestError(f"dampers = {shown(dampers)} must be a list of Damper")
        if damper.name in names:
            raise RequestError(f"damper {damper.name!r}: the name is taken")
        names.append(damper.name)
        with at(f"damper {damper.name!r}"):
            ends = damper.attached_to
            places = (ends,) if isinstance(ends, str) else tuple(ends)
            for i, place in enumerate(places):
                choice("attached_to", place, (*host.dofs, GROUND) if i else host.dofs)
                if place != GROUND and not np.any(host.row(place)):
                    raise RequestError(
                        f"no mode of the host moves {place!r}: keep more modes, or its static "
                        "response"
                    )
    return HostSystem(host, tuple(ordered), MappingProxyType(forces), acceleration, float(omega))
