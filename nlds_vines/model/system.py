"""A system: one kind of damper on the primary structure, with all its parameters, validated.

`System.cells` returns the parameters as records for the kernels.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import RequestError, choice, number, shown, string, table, unknown
from nlds_vines.model.parameters import (
    CONSTANTS,
    CONTACT,
    DAMPING,
    DESCRIBED,
    HERTZ,
    LAWS,
    OSCILLATOR,
    PARAMETERS,
    SECOND,
    STRUCTURE,
    Law,
    hertz_stiffness,
)
from nlds_vines.model.ratios import (
    following,
    meant_by,
    of_parameters,
    ratios_in,
    still_set,
    without_ratios,
)
from nlds_vines.model.scenes import BASES, SCENES, Scene, Stroke

if TYPE_CHECKING:
    from nlds_vines.model.host import Host
    from nlds_vines.model.host_system import Damper, HostSystem

_FIELDS = {  # of a cell, by parameters that are copied; a single mass has names of its own
    **{name: name for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega")},
    **{"m": "m1", "k": "k1", "c": "c1"},
}

CELL = np.dtype(
    [
        (name, np.float64)
        for name in (*dict.fromkeys(_FIELDS.values()), "K", "near", "far", "rest", "limit")
    ]
)
"""The record of one cell of a scan under Hertz' law, as the kernels read it, in SI units.

Its fields are the parameters of equation (5); the contact stiffness K [N/m^1.5]; `near`, the
spring's shortening, and `far`, its lengthening [m], at which the walls are touched; the rest offset
`rest` [m]; `limit`, the shortening [m] that must not be reached. A field that the scene does not
have is 0, and no kernel reads it."""

_OF_LAWS = tuple(name for name in CONSTANTS if name != "K")
NEAR = "near_contact"  # the field for the constants of the near wall, if it has its own


def cell_type(scene: Scene) -> np.dtype:
    """Return the type of the records of a scene's cells: `CELL`, and the fields of other laws.

    These are the constants of the laws, nested in `NEAR` for a near wall of its own, and `load`.
    """
    has_others = bool(scene.walls) and (scene.laws != (HERTZ,) or bool(scene.optional))
    return _cell_type(scene.load is not None, scene.law_2 is not None, has_others)


@cache
def _cell_type(has_load: bool, has_second: bool, has_others: bool) -> np.dtype:
    constants: list[Any] = [(name, np.float64) for name in _OF_LAWS]
    others: list[Any] = [("load", np.float64)] * has_load
    others += [(NEAR, [("K", np.float64), *constants])] * has_second + constants * has_others
    # before those of CELL: Numba takes a record that begins like another one for a kind of it
    return np.dtype([*others, *((name, np.float64) for name in CELL.names or ())])


@dataclass(frozen=True, repr=False)
class System(Outlined):
    """A kind of damper with its parameters; checked when made, immutable afterwards.

    Parameters
    ----------
    kind : str
        A kind of system, such as "ssul"; see the page "Dampers and their parameters".
    parameters : mapping of str to float
        SI values by name, exactly those of the kind.  `K` may replace the seven constants of a
        Hertz contact, and a ratio (zeta1, zeta2, mass_ratio, f, f1, T1, omega_ratio,
        frequency_ratio) its parameter.
    name : str, optional
        The name in the catalog, or the path of a file; by default the kind.
    title : str, optional
        One line that describes it.
    sources, assumptions : mapping of str to str, optional
        By parameter, the source of its value, and what had to be assumed for it.
    law, law_2 : str, optional
        The contact law of all walls, by default "hertz", and that of a second wall with a law of
        its own, whose constants end in _2.
    fixed_ratios : mapping of str to float, optional
        The ratios that stay constant when the parameters of their unit change.

    Raises
    ------
    RequestError
        For an unknown kind or law, for a parameter that is missing or that the kind does not have,
        for a value that is not finite or out of its range, and for a text that an archive cannot
        hold.

    See Also
    --------
    load_system

    Examples
    --------
    >>> import nlds_vines as nv
    >>> structure = {"m1": 1000.0, "f1": 1.0, "zeta1": 0.02, "P": 800.0, "omega": 6.28}
    >>> system = nv.System("none", structure)
    >>> round(system.parameters["k1"], 1), round(system.period, 4)
    (39478.4, 1.0005)
    """

    kind: str
    parameters: Mapping[str, float]
    name: str = ""
    title: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)
    assumptions: Mapping[str, str] = field(default_factory=dict)
    law: str = HERTZ.name
    law_2: str = ""
    fixed_ratios: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        choice("kind", self.kind, SCENES)
        for key in ("parameters", "fixed_ratios"):
            table(key, getattr(self, key))
        check_law(self.kind, self.law, self.law_2)
        for key in ("name", "title"):
            string(key, getattr(self, key))
        for key in ("sources", "assumptions"):
            for name, text in table(key, getattr(self, key), PARAMETERS).items():
                string(f"{key}.{name}", text, lines=True)
        scene = SCENES[self.kind].under(self.law, self.law_2)
        follow = meant_by(scene, self.fixed_ratios)
        stated = {name: value for name, value in self.parameters.items() if name not in follow}
        values = _merge(scene, {}, {**self.fixed_ratios, **stated})
        for name, value in values.items():
            values[name] = number(name, value)
            PARAMETERS[name].check(values[name])
        object.__setattr__(self, "name", self.name or self.kind)
        self._set(
            parameters=values,
            fixed_ratios={**self.fixed_ratios, **_ratios_in(scene, self.parameters)},
            sources=self.sources,
            assumptions=self.assumptions,
        )

    def _set(self, **tables: Mapping[str, Any]) -> None:
        self.__dict__.update({k: MappingProxyType(dict(v)) for k, v in tables.items()})
        _ = self._cell  # which refuses parameters out of proportion

    @staticmethod
    def from_host(
        host: Host,
        dampers: Sequence[Damper] = (),
        *,
        omega: float | None = None,
        f: float | None = None,
        force: Mapping[str, float] | None = None,
        base: Mapping[str, Any] | None = None,
        name: str = "",
        title: str = "",
    ) -> HostSystem:
        """Return the system of a host with dampers.

        Parameters
        ----------
        host : Host
            A linear structure.
        dampers : sequence of Damper, optional
            The dampers that are attached to it.
        omega : float, optional
            Frequency [rad/s] of the force or of the ground's motion; a system for loads in time
            needs neither.
        f : float, optional
            The frequency in Hz, in place of omega.
        force : mapping of str to float, optional
            Amplitudes P [N] of the forces P cos(omega t) by degree of freedom.
        base : mapping, optional
            In its place, the motion of the ground: `acceleration`, its amplitude [m/s^2], and
            `influence`, by default "all", that of the host, or the displacements of degrees of
            freedom when the ground moves by 1.  States are then relative to the ground.
        name, title : str, optional
            A name, by default "host", and one line that describes the system.

        Returns
        -------
        HostSystem
            The system, of kind "host".

        Raises
        ------
        RequestError
            For an unknown degree of freedom, a name that stands twice, a degree of freedom that no
            mode moves, and unless a frequency and exactly one of `force` and `base` are given, or
            none.

        See Also
        --------
        Host, Damper, Wall

        Examples
        --------
        >>> import nlds_vines as nv
        >>> frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
        >>> cell = nv.Damper("cell", attached_to="roof", m=900.0, walls=[nv.Wall(0.05, K=1e8)])
        >>> system = nv.System.from_host(frame, [cell], force={"roof": 700.0}, omega=12.6)
        >>> system.scene.components[-2:]
        ('cell', 'v_cell')
        """
        from nlds_vines.model.host_system import system_from_host

        if f is not None:
            if omega is not None:
                raise RequestError("f beside omega: give one of them")
            omega = number("f", f) * (2 * pi)
        return system_from_host(host, dampers, force, base, omega, name, title)

    def refuse_corners(self, corners: Iterable[Mapping[str, float]]) -> None:
        """Accept any corner of a grid, as the range of one parameter depends on no other."""

    @property
    def drive(self) -> dict[str, float]:
        """The parameters of the force, or of the motion of the ground, by name."""
        names = ("omega", "P", "Y", *BASES)
        return {name: self.parameters[name] for name in names if name in self.parameters}

    @property
    def contact_in_words(self) -> dict[str, float]:
        """The constants of the contact by name, the stiffness K in place of moduli."""
        scene, constants = self.scene, dict[str, float]()
        if scene.law == HERTZ and scene.walls:
            constants["K"] = self.K
        for name in scene.contact(self.parameters):
            if name not in CONTACT:
                constants[name] = self.parameters[name]
        return constants

    @property
    def contact_laws(self) -> tuple[Law, ...]:
        """The laws of the walls."""
        return self.scene.laws

    def strokes(self, values: Mapping[str, Any], state: Mapping[str, Any]) -> list[Stroke]:
        """Return the stroke of the damper, or of a mass between walls, in states.

        `values` are parameters that differ from those of the system.  They and the components of
        the state are floats or arrays; a missing component is at rest.
        """
        scene, parameters = self.scene, {**self.parameters, **values}
        x1 = r = state.get(scene.components[0], 0.0)
        if scene.rest is not None:
            rest = scene.rest(parameters)
            r = x1 - (state.get("x2", rest) - rest)
        walls = []
        for sign, gap in ((1.0, scene.gap_near), (-1.0, scene.gap_far)):
            if gap is not None:
                walls.append((sign, gap(parameters)))
        return [Stroke(r, np.maximum(np.abs(r), np.abs(x1)), walls)]

    def alone(self) -> System:
        """Return the structure without its damper, under the same force."""
        scene = SCENES["none"]
        ratios = ratios_in(scene)
        values = {name: v for name, v in self.parameters.items() if name in scene.allowed}
        fixed = {name: v for name, v in self.fixed_ratios.items() if name in ratios}
        title = "Primary structure alone"
        return System("none", values, title=title, fixed_ratios=fixed)

    def displacements(
        self, names: Sequence[str] = (), records: Collection[str] = ("response",)
    ) -> tuple[str, ...]:
        """Return no names: the response of a kind is that of its own coordinates."""
        if len(names):
            raise RequestError(
                f"of = {shown(list(names))}: kind {self.kind!r} names no displacements; its "
                "response is x1_max, a1_max and others by the symbols of the paper"
            )
        return ()

    def heading(self) -> str:
        """Return its name and title."""
        return f"{self.name}: {self.title}" if self.title else self.name

    def outline(self) -> Rows:
        """Return its kind, its parameters and the names of assumed ones."""
        law = f", law {self.law!r}" if self.scene.walls else ""
        second = f", law_2 {self.law_2!r}" if self.law_2 else ""
        yield "kind", f"{self.kind!r} ({self.scene.meaning}){law}{second}"
        yield "parameters [SI]", numbers(self.parameters)
        if self.assumptions:
            yield "assumed", ", ".join(self.assumptions)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle with plain dictionaries: read-only mappings cannot be pickled."""
        values = (getattr(self, item.name) for item in fields(self))
        return System, tuple(dict(v) if isinstance(v, Mapping) else v for v in values)

    def to_table(self) -> dict[str, Any]:
        """Return the `[system]` table of a request file that describes exactly this system."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        plain = {key: dict(v) if isinstance(v, Mapping) else v for key, v in values.items()}
        plain["parameters"] = self.statements
        del plain["fixed_ratios"]
        if self.law == HERTZ.name:
            del plain["law"]
        return {key: value for key, value in plain.items() if value}

    @property
    def ratios(self) -> dict[str, float]:
        """The ratios and frequencies of the parameters, by name; those that are not defined lack.

        zeta1, zeta2, mass_ratio, frequency_ratio, omega_ratio [1], f, f1 [Hz], T1 [s].
        """
        return {**of_parameters(self.scene, self.parameters), **self.fixed_ratios}

    @property
    def statements(self) -> dict[str, float]:
        """The parameters as they were set: those that were set as a ratio, as that ratio."""
        ratios = list(self.fixed_ratios)
        names = dict(zip(meant_by(self.scene, ratios), ratios, strict=True))
        return {
            names.get(name, name): self.fixed_ratios.get(names.get(name, name), value)
            for name, value in self.parameters.items()
        }

    def following(self, names: Collection[str]) -> set[str]:
        """Return the parameters that, by a ratio that was set, change with those of `names`."""
        return following(self.scene, self.fixed_ratios, names)

    @cached_property
    def scene(self) -> Scene:
        """The parts of the system: rest position, walls, contact laws."""
        return SCENES[self.kind].under(self.law, self.law_2, self.parameters)

    @cached_property
    def cell(self) -> Any:
        """The record of dtype `CELL` with the numbers for the kernels, which only read it."""
        return np.atleast_1d(self.cells()).view(np.recarray)[0]

    @property
    def K(self) -> float:
        """Contact stiffness [N/m^1.5], as set or from equation (4).

        Raises
        ------
        RequestError
            For a kind without contact, and for a law without K.
        """
        if not self.scene.walls:
            raise RequestError(f"kind {self.kind!r} has no contact and so no stiffness K")
        if "K" not in self.scene.allowed:
            raise RequestError(f"law {self.law!r} has no stiffness K")
        is_nested = self.law_2 and self.scene.second == "far"
        return float((self._cell[NEAR] if is_nested else self._cell)["K"])

    @property
    def structure(self) -> tuple[float, float, float]:
        """Mass [kg], stiffness [N/m] and damping [N s/m] of the structure, or the oscillator."""
        names = STRUCTURE if "m1" in self.parameters else OSCILLATOR
        m1, k1, c1 = (self.parameters.get(name, 0.0) for name in names)
        return m1, k1, c1

    def contact(self, wall: str) -> dict[str, float]:
        """Return the constants of the contact at a wall, "near" or "far", without the suffix _2."""
        cell = self._cell[NEAR] if self.law_2 and wall == "near" else self._cell
        names = self.scene.law_at(wall).needed + self.scene.law_at(wall).optional
        return {name: float(cell[name]) for name in names if name in (cell.dtype.names or ())}

    @property
    def force(self) -> float:
        """Amplitude of the harmonic force [N], or of the force due to the ground's motion."""
        return float(self._cell["P"])

    @property
    def foot(self) -> complex | None:
        """Amplitude Y of the foot's motion y = Re(Y exp(i omega t)) [m]; None if it is at rest.

        Complex, since the force P cos(omega t) = k1 y + c1 dy/dt leads it.
        """
        if not self.scene.foot:
            return None
        _, k1, c1 = self.structure
        return self.force / complex(k1, c1 * self.parameters["omega"])

    @property
    def rest(self) -> float | None:
        """Offset x2 - x1 [m] at which the damper's spring rests; None without a damper."""
        return None if self.scene.rest is None else float(self.scene.rest(self.parameters))

    @property
    def period(self) -> float:
        """Forcing period T = 2 pi / omega [s]."""
        return 2 * pi / self.parameters["omega"]

    def with_(self, /, **overrides: float | str) -> System:
        """Replace parameters.

        A parameter that was set as a ratio stays at that ratio, unless it is overridden.  `K`
        replaces the seven contact constants, and all seven together replace `K`.  The source of a
        changed value becomes "set by the user", and its assumption is dropped.

        Parameters
        ----------
        **overrides
            Parameters by name in SI units, or ratios: zeta1, zeta2, mass_ratio, f [Hz], f1 [Hz],
            T1 [s], omega_ratio, frequency_ratio.  Also `law` and `law_2`, with the constants of the
            new law in place of those of the former.

        Returns
        -------
        System
            A new system.

        Raises
        ------
        RequestError
            As `System`, and for `K` beside a constant that it replaces.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> system = nv.load_system("ssul-set6").with_(f=1.0, mass_ratio=0.05)
        >>> round(system.parameters["omega"], 4), system.parameters["m2"]
        (6.2832, 50.0)
        """
        law: Any = overrides.pop("law", self.law)
        law_2: Any = overrides.pop("law_2", self.law_2)
        for key, name in (("law", law), ("law_2", law_2)):
            if not isinstance(name, str):
                raise unknown(key, name, LAWS)
        before: Mapping[str, float] = self.parameters
        if (law, law_2) != (self.law, self.law_2):
            check_law(self.kind, law, law_2)
            has_changed = {"": law != self.law, SECOND: law_2 != self.law_2}
            without_contact = self.scene.own_of(before)
            before = {
                name: value
                for name, value in before.items()
                if name in without_contact
                or not has_changed[SECOND if name.endswith(SECOND) else ""]
            }
        scene = SCENES[self.kind].under(law, law_2)
        merged = _merge(scene, before, overrides, self.fixed_ratios)
        for name in scene.under(law, law_2, merged).optional:
            if merged[name] == 0 and DAMPING in name:  # damping that damps nothing
                del merged[name]
        changed = []
        for name, value in merged.items():
            old = self.parameters.get(name)
            if value is not old:  # the others have been checked before
                merged[name] = number(name, value)
                PARAMETERS[name].check(merged[name])
                if value != old:
                    changed.append(name)
        system = object.__new__(type(self))
        system.__dict__.update(
            kind=self.kind, name=self.name, title=self.title, law=law, law_2=law_2
        )
        unchanged = merged.keys() - changed
        sources = {name: text for name, text in self.sources.items() if name in unchanged}
        stay = still_set(scene, self.fixed_ratios, overrides)
        system._set(
            parameters=merged,
            fixed_ratios=stay | _ratios_in(scene, overrides),
            sources=sources | dict.fromkeys(sorted(changed), "set by the user"),
            assumptions={n: text for n, text in self.assumptions.items() if n in unchanged},
        )
        return system

    def with_axes(self, names: Iterable[str]) -> System:
        """Return the system with these parameters in its scene, those that were optional at 0.

        One that varies is part of the scene even at the value 0, and no longer set as a ratio.
        """
        names = list(names)
        stay = still_set(self.scene, self.fixed_ratios, names)
        if stay != self.fixed_ratios:
            return replace(self, fixed_ratios=stay).with_axes(names)
        names = [name for name in names if name in self.scene.allowed]
        lacking = [name for name in names if name not in self.parameters]
        damping = [name for name in lacking if name.startswith(DAMPING)]
        # the ground's motion in place of a force changes a scene, too, and the other way round
        changing = self.scene.drives if self.scene.shaken else self.scene.drives[1:]
        drives = [name for name in lacking if name in changing]
        if not damping and len(drives) != 1:
            return self
        gone = self.scene.drives if drives else ()
        others = {name: value for name, value in self.parameters.items() if name not in gone}
        return replace(self, parameters={**others, **dict.fromkeys([*damping, *drives], 0.0)})

    def attributes(self, varied: Collection[str] = ()) -> dict[str, str | float]:
        """Return the attributes by which an archive describes the system [SI].

        A parameter that follows, by a ratio, from one of those `varied` is left out.
        """
        follow = following(self.scene, self.fixed_ratios, varied)
        values = self.parameters.items()
        return {
            "system": self.name,
            "kind": self.kind,
            **({"law": self.law} if self.law != HERTZ.name else {}),
            **({"law_2": self.law_2} if self.law_2 else {}),
            **{name: float(value) for name, value in values if name not in follow},
            **({"K": self.K} if "K" in self.scene.allowed else {}),
            **self.fixed_ratios,
            **{f"assumption_{name}": text for name, text in self.assumptions.items()},
        }

    def cells(self, grid: Mapping[str, Any] = MappingProxyType({})) -> np.ndarray:
        """Return the records of dtype `CELL` for the kernels, one for each point of a grid.

        `grid` holds varied parameters and ratios by name, arrays that broadcast together.  If the
        ground moves, P is the force that it exerts in each cell.  Raises `RequestError`, which
        names parameter and value, if one is not allowed.
        """
        if not grid:
            return self._cell.copy()
        varied = {name: np.asarray(values, dtype=np.float64) for name, values in grid.items()}
        values = _merge(self.scene, self.parameters, varied, self.fixed_ratios)
        for name, value in varied.items():  # the others were checked when the system was made
            DESCRIBED[name].check(value)
        shape = np.broadcast_shapes(*(array.shape for array in varied.values()))
        return _records(self.scene, values, shape)

    @cached_property
    def _cell(self) -> np.ndarray:
        return _records(self.scene, self.parameters, ())


def _records(scene: Scene, values: Mapping[str, Any], shape: tuple[int, ...]) -> np.ndarray:
    """Return the records (shape) of parameters that are floats or arrays."""
    cells = np.zeros(shape, cell_type(scene))
    for name, field_name in _FIELDS.items():
        if name in values:
            cells[field_name] = values[name]
    if "P" not in values:
        cells["P"] = _force(scene, values)
    for name, part in (
        ("near", scene.gap_near), ("far", scene.gap_far), ("rest", scene.rest),
        ("limit", scene.limit), ("load", scene.load),
    ):  # fmt: skip
        if part is not None:
            with np.errstate(over="ignore"):
                cells[name] = part(values)
            if not np.isfinite(cells[name]).all():
                raise RequestError(f"parameters out of proportion: {name} is not finite")
    # a damper is in one contact at a time
    if len(scene.walls) == 2 and np.any((room := cells["near"] + cells["far"]) < 0):
        raise RequestError(
            f"the walls are {float(np.min(room))!r} m apart: their distance must be >= 0"
        )
    if scene.limit is not None and np.any(cells["limit"] <= 0):
        raise RequestError(
            f"D = {float(np.min(values['D']))!r}: a damper of kind {scene.kind!r} would rest at or "
            "beyond its limit; D, or D + L, must be > 0"
        )
    for wall in scene.walls:
        ending, is_hertz = scene.ending(wall), scene.law_at(wall) == HERTZ
        constants = cells[NEAR] if scene.law_2 and wall == "near" else cells
        for name in ("K", *_OF_LAWS):
            if name + ending in values:
                constants[name] = values[name + ending]
        if is_hertz and scene.is_damped(wall):
            constants["exponent"] = 1.5
        if is_hertz and "K" + ending not in values:
            of_hertz = tuple(values[name] for name in CONTACT)
            is_one = all(isinstance(value, float) for value in of_hertz)
            stiffness = hertz_stiffness if is_one else hertz_stiffness.__wrapped__
            constants["K"] = stiffness(*of_hertz)
    return cells


def _force(scene: Scene, values: Mapping[str, Any]) -> Any:
    """Return the amplitude [N] of the force due to the ground's motion Y cos(omega t).

    Relative to the ground it is m Y omega^2.  In absolute coordinates spring and dashpot exert
    k1 y + c1 dy/dt: Y sqrt(k1^2 + (c1 omega)^2).  base_acceleration is Y omega^2.
    """
    omega = values["omega"]
    with np.errstate(all="ignore"):
        if not scene.absolute:
            if "base_acceleration" in values:
                return values["m"] * values["base_acceleration"]
            Y = values["Y"] if "Y" in values else values["base_displacement"]
            return values["m"] * Y * omega * omega
        name = next(name for name in BASES if name in values)
        if np.any((np.asarray(values["k1"]) == 0) & (np.asarray(values["c1"]) == 0)):
            raise RequestError(
                f"{name}: with k1 = 0 and c1 = 0 nothing joins the structure to the ground"
            )
        if "base_displacement" in values:
            Y = values["base_displacement"]
        else:
            Y = values["base_acceleration"] / (omega * omega)
        size_of_force = Y * modulus(values["k1"], values["c1"] * omega)
    if not np.all(np.isfinite(size_of_force)):
        raise RequestError(f"{name} out of proportion: the force on m1 is not finite")
    return size_of_force


def modulus(real: Any, imaginary: Any) -> np.ndarray:
    """Return sqrt(real^2 + imaginary^2) without overflow of the squares.

    NumPy's complex modulus, and so an archive, would depend on the processor.
    """
    one, other = np.abs(real), np.abs(imaginary)
    most = np.maximum(one, other)
    share = np.where((most > 0) & (most < np.inf), np.minimum(one, other) / most, 0.0)
    return most * np.sqrt(1 + share * share)


def check_law(kind: str, law: str, law_2: str) -> None:
    choice("law", law, LAWS)
    scene = SCENES[kind]
    if law != HERTZ.name and not scene.walls:
        raise RequestError(f"law = {law!r}: kind {kind!r} has no contact")
    if not isinstance(law_2, str) or law_2:
        choice("law_2", law_2, LAWS)
        if not scene.second:
            two = [name for name, other in SCENES.items() if other.second]
            raise RequestError(
                f"law_2 = {law_2!r}: kind {kind!r} has no second wall; of two walls: "
                f"{', '.join(two)}"
            )


def _named(scene: Scene) -> str:
    text = f"kind {scene.kind!r}" + (f" under law {scene.law.name!r}" * (scene.law != HERTZ))
    return text + (f" and law_2 {scene.law_2.name!r}" if scene.law_2 else "")


def refuse_contradiction(names: Collection[str]) -> None:
    beside = [name for name in CONTACT if name in names]
    if beside and "K" in names:
        raise RequestError(f"K beside {', '.join(beside)}: give K or the contact constants")


def refuse_foreign(scene: Scene, names: Iterable[str]) -> None:
    name = next((name for name in names if name not in scene.allowed), None)
    if name is None:
        return
    if name not in PARAMETERS:
        raise unknown("parameter", name, (*scene.allowed, *ratios_in(scene)))
    constant, key = name.removesuffix(SECOND), "law_2" if name.endswith(SECOND) else "law"
    laws = [law.name for law in LAWS.values() if constant in law.allowed]
    if laws and (scene.second if key == "law_2" else scene.walls):
        law: Law | None = scene.law_2 if key == "law_2" else scene.law
        present = f"{key} {law.name!r}" if law else f"without {key}, kind {scene.kind!r}"
        raise RequestError(
            f"{present} has no parameter {name!r} ({PARAMETERS[name].meaning}): {key} = "
            f"{' or '.join(map(repr, laws))} has it; allowed: {', '.join(scene.allowed)}"
        )
    raise RequestError(
        f"{_named(scene)} has no parameter {name!r} ({PARAMETERS[name].meaning}); "
        f"allowed: {', '.join(scene.allowed)}"
    )


def _ratios_in(scene: Scene, values: Mapping[str, Any]) -> dict[str, float]:
    """Return the ratios among `values` whose unit depends on parameters."""
    ratios = ratios_in(scene).items()
    return {name: number(name, values[name]) for name, r in ratios if r.needs and name in values}


def _merge(
    scene: Scene,
    before: Mapping[str, Any],
    changes: Mapping[str, Any],
    ratios: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, Any]:
    """Merge `changes`, ratios among them, into the parameters `before`, in the scene's order.

    A parameter that was set as one of `ratios` follows from the changed ones.
    """
    if isinstance(changes.get("P"), Mapping):  # P = { base_displacement = Y } means that parameter
        inner = table("P", changes["P"], BASES)
        if len(inner) != 1:
            raise RequestError(f"P = {shown(dict(inner))} must have one key, of {', '.join(BASES)}")
        (name,) = inner
        if name in changes:
            raise RequestError(f"{name} stands beside P = {{ {name} = ... }}: give it once")
        changes = {key: value for key, value in changes.items() if key != "P"} | dict(inner)
    changes = without_ratios(scene, before, changes, ratios)
    refuse_foreign(scene, changes)
    refuse_contradiction(changes)
    constants = [name for name in CONTACT if name in changes]
    merged: dict[str, Any] = {**before, **changes}
    if "K" in changes:
        merged = {name: value for name, value in merged.items() if name not in CONTACT}
    elif constants:
        merged.pop("K", None)
    drives = [name for name in scene.drives if name in changes]
    if len(drives) > 1:
        raise RequestError(f"{drives[0]} beside {drives[1]}: give one of {', '.join(scene.drives)}")
    if drives:
        merged = {k: v for k, v in merged.items() if k in drives or k not in scene.drives}
    names = scene.own_of(merged) + scene.contact(merged)
    missing = ", ".join(name for name in names if name not in merged)
    if missing and "K" in before:
        raise RequestError(
            f"{', '.join(constants)} given for a system whose K is given: "
            f"give also {missing}, or K instead"
        )
    if missing:
        if HERTZ in scene.laws and not {*CONTACT}.isdisjoint(missing.split(", ")):
            missing += f"; K may replace {CONTACT[0]} to {CONTACT[-1]}"
        raise RequestError(f"parameters of {_named(scene)} are missing: {missing}")
    return {name: merged[name] for name in names}


def system_in_words(system: System | HostSystem) -> str:
    """Return the title of a system; without one, its kind if its name is that of a file."""
    is_named = not (system.name == system.kind or system.name.endswith(".toml"))
    if system.title or is_named:
        return system.title or system.name
    if system.kind not in SCENES:
        return system.heading()
    names = {kind: re.split("[:,]", scene.meaning)[0] for kind, scene in SCENES.items()}
    name = names[system.kind]
    is_ambiguous = list(names.values()).count(name) > 1
    return name[:1].upper() + name[1:] + (f" ({system.kind})" if is_ambiguous else "")


def parameters_in_words(system: System, varied: Collection[str] = ()) -> str:
    varied = {*varied, *meant_by(system.scene, varied), *system.following(varied)}
    has_law = system.scene.walls and system.kind in SCENES  # each wall of a host has its own
    law = f" under {system.law}" if has_law else ""
    values = (
        f"{name} = {value:g}" for name, value in system.statements.items() if name not in varied
    )
    return f"{system.kind}{law}: {', '.join(values)}"
