"""A system: a structure with dampers and what drives it. All that tasks ask of one.

A `Preset` is one of the paper's kinds, made of parameters by the paper's symbols; a `General`
system is any linear structure with any dampers.  Tasks, pictures and pages ask the methods of
`System`, which both implement, and never which of them they have.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from inspect import Signature, signature
from math import fsum, inf, pi, sqrt
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import (
    RequestError,
    at,
    by_dof_names,
    choice,
    number,
    shown,
    string,
    table,
    unknown,
)
from nlds_vines.model.dampers import (
    PLACE,
    RATIOS_OF_DAMPERS,
    SPRING_KEYS,
    Damper,
    all_are,
    check_places,
    damper_from,
    refuse_unbounded,
)
from nlds_vines.model.linear_response import (
    amplitudes,
    closed_form,
    energy_alone,
    harmonic_energy,
)
from nlds_vines.model.parameters import (
    CONTACT,
    DAMPING,
    DESCRIBED,
    FORCE,
    GROUND,
    HERTZ,
    INITIAL,
    LAWS,
    MOTIONS,
    OSCILLATOR,
    PARAMETERS,
    RATIOS,
    SECOND,
    SIDES,
    STRUCTURE,
    STRUCTURE_ITSELF,
    Law,
    flat,
    split_name,
)
from nlds_vines.model.presets import NEAR, check_law, merged_parameters, ratios_among, records_of
from nlds_vines.model.ratios import (
    following,
    meant_by,
    of_parameters,
    ratios_in,
    refuse_twice,
    still_set,
)
from nlds_vines.model.rests import Rest, rests_of, state_of_rest, usual_strokes
from nlds_vines.model.scenes import BASES, HOST, SCENES, HostScene, Scene, Stroke, Values
from nlds_vines.model.signals import (
    SIGNALS,
    Motion,
    Motions,
    Signal,
    SignalWords,
    displaced,
    wall_force,
)

if TYPE_CHECKING:
    from nlds_vines.model.host import Host  # with SciPy

BY_USER = "set by the user"
"""The source of a number that `with_` has changed."""

ALL = "all"  # of the influence of the ground: that of the host

NOT_GIVEN = "not given: there is no harmonic force"
"""The source of a force of 0 N, and of its frequency, in a system for loads in time."""


class System(Outlined):
    """A structure with its dampers; checked when made, immutable afterwards.

    Called, it makes a system of one of the paper's kinds.  `System.from_host` makes one of any
    linear structure with any number of dampers.

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
    name: str
    title: str
    sources: Mapping[str, str]
    assumptions: Mapping[str, str] = MappingProxyType({})
    class_name = "System"

    def __new__(cls, *args: Any, **kwargs: Any) -> System:
        return super().__new__(Preset if cls is System else cls)

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
    ) -> System:
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
            In its place, the motion of the ground: the amplitude of its `acceleration` [m/s^2] or
            of its `displacement` [m], and `influence`, by default "all", that of the host, or the
            displacements of degrees of freedom when the ground moves by 1.  States are then
            relative to the ground.
        name, title : str, optional
            A name, by default "host", and one line that describes the system.

        Returns
        -------
        System
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
        if f is not None:
            if omega is not None:
                raise RequestError("f beside omega: give one of them")
            omega = number("f", f) * (2 * pi)
        return system_from_host(host, dampers, force, base, omega, name, title)

    # ---- numbers by name ----

    parameters: Mapping[str, float]
    """The numbers by name [SI]: m1, C, omega of a preset, `cell.k`, `force.roof` of a host."""

    fixed_ratios: Mapping[str, float]
    """The ratios that stay constant when the parameters of their unit change."""

    @property
    def statements(self) -> Mapping[str, float]:
        """The parameters as they were set: those that were set as a ratio, as that ratio."""
        raise NotImplementedError

    @property
    def ratios(self) -> Mapping[str, float]:
        """The ratios and frequencies of the parameters, by name; those that are not defined lack.

        zeta1, zeta2, mass_ratio, frequency_ratio, omega_ratio [1], f, f1 [Hz], T1 [s].
        """
        raise NotImplementedError

    @property
    def numbers(self) -> Mapping[str, float]:
        """The numbers that have a value, by name: parameters, ratios, factors on matrices."""
        return {**self.ratios, **self.parameters}

    @property
    def drive(self) -> Mapping[str, float]:
        """The parameters of the force, or of the motion of the ground, by name."""
        raise NotImplementedError

    def takes(self, name: str) -> bool:
        """Return True if `with_` replaces a number of this name, a parameter or a ratio."""
        raise NotImplementedError

    def can_set(self, name: str, laws: Mapping[str, Law] = MappingProxyType({})) -> bool:
        """Return whether `[set]` changes a number of the system, or its law.

        `laws` are contact laws that `[set]` names, as "law" and "law_2".
        """
        return self.takes(name)

    def with_(self, /, **changes: Any) -> System:
        """Replace numbers.

        Parameters
        ----------
        **changes
            Of one of the paper's kinds: parameters by name in SI units, or ratios: zeta1, zeta2,
            mass_ratio, f [Hz], f1 [Hz], T1 [s], omega_ratio, frequency_ratio; also `law` and
            `law_2`, with the constants of the new law in place of those of the former.  `K`
            replaces the seven contact constants, and all seven together replace `K`.

            Of a host with dampers: `host.K`, `host.M`, `host.C`, factors on its matrices,
            `host.ratio`, and of a frame or a chain `floor2.k` and `floor2.m`; `cell1.m`, `cell1.k`,
            `cell1.c` of the damper cell1, `cell1.k3` of its spring, `cell1.f` [Hz] or
            `cell1.frequency_ratio` in place of k and `cell1.zeta` in place of c; `cell1.gap` and
            constants of all its walls, `cell1.gap+` of one, `cell1.attached_to`; `force.roof` and
            `ground`, which replace each other; `omega`, or `f` [Hz].  A table replaces the numbers
            of one owner: `cell1={"k": 300.0}`.

        Returns
        -------
        System
            A new system.  What was set as a ratio stays at that ratio, unless it is overridden; the
            source of a changed value becomes "set by the user".

        Raises
        ------
        RequestError
            For an unknown name, two names of one number, `K` beside a constant that it replaces,
            and a value out of range.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> system = nv.load_system("ssul-set6").with_(f=1.0, mass_ratio=0.05)
        >>> round(system.parameters["omega"], 4), system.parameters["m2"]
        (6.2832, 50.0)
        >>> frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
        >>> cell = nv.Damper("cell", attached_to="roof", m=900.0, walls=[nv.Wall(0.05, K=1e8)])
        >>> system = nv.System.from_host(frame, [cell], force={"roof": 700.0}, omega=12.6)
        >>> system.with_(**{"cell.gap": 0.02, "f": 2.0}).parameters["cell.gap"]
        0.02
        """
        raise NotImplementedError

    def with_axes(self, names: Iterable[str]) -> System:
        """Return the system with these parameters in its scene, those that were optional at 0.

        One that varies is part of the scene even at the value 0, and no longer set as a ratio.
        Raises `RequestError` for an unknown name, and if two mean one number.
        """
        raise NotImplementedError

    def following(self, names: Collection[str]) -> set[str]:
        """Return the parameters that change with those of `names`, as k2 by a ratio that was set.

        Of a host, these are gap+ and gap- with gap, k and c with the numbers that f and zeta need.
        """
        raise NotImplementedError

    def refuse_corners(self, corners: Iterable[Mapping[str, float]]) -> None:
        """Raise `RequestError` if a corner of a grid is not allowed, as if walls overlap."""
        raise NotImplementedError

    def refuse_under(
        self,
        load: Any,
        names: Collection[str],
        *,
        settle: float = 0.0,
    ) -> None:
        """Raise `RequestError` for what means nothing, or is not offered, under a load.

        `load` is a `Loading`, `names` are of parameters that vary, `settle` [s] is left out of rms
        values.  The system's own force is off under a load, unless that is
        harmonic.
        """
        raise NotImplementedError

    def refuse_without_force(self) -> None:
        """Raise `RequestError` if the system was made for loads in time, without a force."""
        raise NotImplementedError

    def changes_from(self, first: System) -> dict[str, Any]:
        """Return what `with_` changes of `first`, with the same parts, to get this system."""
        raise NotImplementedError

    def has_parts_of(self, first: System) -> bool:
        """Return True if `first.with_(**numbers)` can give this system: its parts are the same."""
        raise NotImplementedError

    def cells(self, grid: Mapping[str, Any] = ...) -> np.ndarray:
        """Return the records of parameters for the engine, one for each point of a grid.

        `grid` holds varied parameters and ratios by name, arrays that broadcast together.  Raises
        `RequestError`, which names parameter and value, if one is not allowed.
        """
        raise NotImplementedError

    # ---- parts ----

    @property
    def scene(self) -> Scene:
        """The parts of the system: names of its coordinates, walls, laws."""
        raise NotImplementedError

    @property
    def contact_laws(self) -> tuple[Law, ...]:
        """The laws of the walls."""
        raise NotImplementedError

    @property
    def period(self) -> float:
        """Forcing period T = 2 pi / omega [s]."""
        return 2 * pi / self.parameters["omega"]

    @property
    def natural_period(self) -> float:
        """The longest natural period of the undamped structure alone [s]; inf without a spring.

        A structure that is free to move has modes without deformation, which do not count.
        """
        raise NotImplementedError

    @property
    def stiffness(self) -> str:
        """The name of the stiffness of the structure: k1, k, or `host.K`, a factor on that."""
        raise NotImplementedError

    @property
    def natural_frequency(self) -> float:
        """The lowest natural frequency of the undamped structure alone [rad/s]; 0 if none."""
        return 2 * pi / self.natural_period

    @property
    def state_at_rest(self) -> tuple[float, ...]:
        """The values of the components of the state in which all springs rest.

        Of dampers with nonlinear springs it is a stable one of `rests`: r = 0 where that is stable,
        otherwise the well that is nearest to it with r > 0.
        """
        raise NotImplementedError

    @property
    def rests(self) -> tuple[Rest, ...]:
        """All states in which the system can rest, with their stability.

        Each has `strokes`, the r [m] of each damper by name, `is_stable`, whether it is a well of
        the potential energy, and its `state`.  Dampers without a nonlinear spring are at r = 0.
        Raises `RequestError` if several springs between degrees of freedom are nonlinear.
        """
        raise NotImplementedError

    @property
    def rest_in_words(self) -> str:
        """The start "rest" in words, "nes at r = 0.3162 m"; empty if all dampers are at r = 0."""
        raise NotImplementedError

    def shortest_natural_period(self, grid: Mapping[str, np.ndarray]) -> float:
        """Return the least `natural_period` [s] at points of a grid, as of `cells`."""
        raise NotImplementedError

    def alone(self) -> System:
        """Return the structure without its dampers, under the same force."""
        raise NotImplementedError

    def with_tuned_mass(self, shaken: bool) -> System:
        """Return the structure with a tuned mass damper of the same mass in place of its dampers.

        Its frequency and damping are those of G. B. Warburton (Earthquake Engineering and
        Structural Dynamics 10, 1982) for the least variance under white noise, of the ground's
        acceleration if it is `shaken`, or else of a force.  Raises `RequestError` if the system has
        no damper with a mass.
        """
        raise NotImplementedError

    def energy_alone(self, cells: np.ndarray) -> np.ndarray | None:
        """Return E1max [J] of the structure alone in `cells` in closed form; None without one."""
        raise NotImplementedError

    def steady_state(self, force: float, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the amplitudes of x1 [m] and the largest E1 [J] under a harmonic force.

        None without a closed form.
        """
        raise NotImplementedError

    def closed_form(self, load: Any) -> Mapping[str, float]:
        """Return the quantities of a response to a load that have a closed form, by name."""
        raise NotImplementedError

    def displacement(self, name: str) -> tuple[np.ndarray, float]:
        """Return the row of a displacement, and its value when the ground moves by 1.

        Raises `RequestError` for an unknown name, and always for one of the paper's kinds.
        """
        raise NotImplementedError

    def displacements(
        self, names: Sequence[str] = (), records: Collection[str] = ("response",)
    ) -> tuple[str, ...]:
        """Return the names of displacements whose response or amplitudes are recorded, checked.

        By default the degrees of freedom that dampers hang on; all of them if there are no dampers.
        None of one of the paper's kinds, whose response is x1_max and others by the paper's
        symbols.
        """
        raise NotImplementedError

    def strokes(self, values: Mapping[str, Any], state: Mapping[str, Any]) -> list[Stroke]:
        """Return the stroke of each damper, or of a mass between walls, in states.

        `values` are parameters that differ from those of the system.  They and the components of
        the state are floats or arrays; a missing component is at rest.
        """
        raise NotImplementedError

    @property
    def damper_names(self) -> tuple[str, ...]:
        """The names of the dampers; "damper" of one that has no name."""
        raise NotImplementedError

    @property
    def owning_dampers(self) -> tuple[str, ...]:
        """The dampers by whose name numbers are called, as `cell.k`; none of the paper's kinds."""
        return ()

    @property
    def chain(self) -> tuple[str, ...]:
        """The degrees of freedom, in order, whose displacements are the shape of the structure.

        None of a structure with one degree of freedom.
        """
        raise NotImplementedError

    @property
    def places(self) -> Mapping[str, float]:
        """The places [m] of walls and limits, and of the rest, by name."""
        raise NotImplementedError

    # ---- along an orbit: states (count, components), times (count,) [s] ----

    def shown(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        """Return the displacements that pictures show by name, checked; `of` if it names any.

        By default the degrees of freedom that dampers hang on; without dampers those that forces
        act on, and the last one that the ground moves if none does.  None of one of the paper's
        kinds, which has x1 and x2.
        """
        raise NotImplementedError

    def motions(self, of: Sequence[str] = ()) -> Motions:
        """Return the motions that pictures show; `of` as in `shown`."""
        raise NotImplementedError

    def signal(self, name: object) -> Signal:
        """Return a signal by its name; raise `RequestError` if the system lacks it."""
        raise NotImplementedError

    def usual_signals(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        """Return the names of the signals whose spectra are shown by default."""
        raise NotImplementedError

    def recorded_signals(self, names: Sequence[str]) -> dict[str, Signal]:
        """Return the signals whose spectra scans record, by default those of displacements.

        They are linear in the state and the same in all cells of a scan, as forces are not.
        Raises `RequestError` for others.
        """
        raise NotImplementedError

    def histories(self, of: Sequence[str] = ()) -> dict[str, Signal]:
        """Return the signals of an orbit's archive: the components of its states, then all others.

        The displacements `of` are among them if the coordinates are modes.
        """
        raise NotImplementedError

    @property
    def energy_signals(self) -> dict[str, str]:
        """The names of the signals that are energies, with the bodies that they are of."""
        raise NotImplementedError

    @property
    def force_signals(self) -> tuple[str, ...]:
        """The names of the signals that are contact forces."""
        raise NotImplementedError

    def contact_forces(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return contact forces (count,) [N] by the struck body, or by the damper of a host.

        They act on the damper and are positive in the direction of its displacement; the structure
        feels the opposite.
        """
        raise NotImplementedError

    def contact_columns(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return the contact forces by the names that they have as columns of a table."""
        raise NotImplementedError

    def harmonic_forces(self, time: np.ndarray) -> dict[str, np.ndarray]:
        """Return the harmonic forces (count,) [N] by name: "force", "force.roof" of a host."""
        raise NotImplementedError

    # ---- words ----

    def in_words(self) -> str:
        """Return the title; without one the name, unless it is the kind or that of a file."""
        is_named = not (self.name == self.kind or self.name.endswith(".toml"))
        return self.title or (self.name if is_named else self.parts_in_words())

    def parts_in_words(self) -> str:
        """Return the words for the structure and its dampers."""
        raise NotImplementedError

    def parameters_in_words(self, varied: Collection[str] = ()) -> str:
        """Return the kind and the parameters without those that change with `varied`."""
        raise NotImplementedError

    @property
    def contact_in_words(self) -> Mapping[str, float]:
        """The constants that all contacts share, by name, the stiffness K in place of moduli."""
        raise NotImplementedError

    @property
    def changed_by_user(self) -> tuple[str, ...]:
        """The names of the numbers that `with_` has changed."""
        return tuple(name for name, source in self.sources.items() if source == BY_USER)

    def attributes(self, varied: Collection[str] = ()) -> dict[str, str | float]:
        """Return the attributes by which an archive describes the system [SI].

        A parameter that changes with one of those `varied` is left out.
        """
        raise NotImplementedError

    def to_table(self) -> dict[str, Any]:
        """Return the `[system]` table of a request file that describes exactly this system."""
        raise NotImplementedError


# ---- the paper's kinds ---------------------------------------------------------------------------


def warburton(ratio: float, shaken: bool) -> tuple[float, float]:
    """Return frequency ratio and damping ratio of a tuned mass of a mass ratio, by Warburton."""
    if ratio >= 1.0:
        raise RequestError(f"a tuned mass of {ratio:g} of the structure's; allowed: below 1")
    if shaken:
        frequency = sqrt(1.0 - 0.5 * ratio) / (1.0 + ratio)
        square = ratio * (1.0 - 0.25 * ratio) / (4.0 * (1.0 + ratio) * (1.0 - 0.5 * ratio))
    else:
        frequency = sqrt(1.0 + 0.5 * ratio) / (1.0 + ratio)
        square = ratio * (1.0 + 0.75 * ratio) / (4.0 * (1.0 + ratio) * (1.0 + 0.5 * ratio))
    return frequency, sqrt(square)


@dataclass(frozen=True, repr=False)
class Preset(System):
    """A system of one of the paper's kinds, with its parameters; see `System`."""

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
        values = merged_parameters(scene, {}, {**self.fixed_ratios, **stated})
        for name, value in values.items():
            values[name] = number(name, value)
            PARAMETERS[name].check(values[name])
        object.__setattr__(self, "name", self.name or self.kind)
        self._set(
            parameters=values,
            fixed_ratios={**self.fixed_ratios, **ratios_among(scene, self.parameters)},
            sources=self.sources,
            assumptions=self.assumptions,
        )

    def _set(self, **tables: Mapping[str, Any]) -> None:
        self.__dict__.update({k: MappingProxyType(dict(v)) for k, v in tables.items()})
        _ = self._cell  # which refuses parameters out of proportion

    def takes(self, name: str) -> bool:
        return name in self.scene.allowed or name in ratios_in(self.scene)

    def can_set(self, name: str, laws: Mapping[str, Law] = MappingProxyType({})) -> bool:
        if self.takes(name):
            return True
        second = name.endswith(SECOND)
        law = laws.get("law_2" if second else "law")
        of_law = law is not None and name.removesuffix(SECOND) in law.allowed
        return bool(self.scene.walls) and (name in ("law", "law_2") or of_law)

    def refuse_corners(self, corners: Iterable[Mapping[str, float]]) -> None:
        """Accept any corner of a grid, as the range of one parameter depends on no other."""

    def refuse_under(
        self,
        load: Any,
        names: Collection[str],
        *,
        settle: float = 0.0,
    ) -> None:
        structure = self.scene.components[0]
        if load.on not in (None, structure):
            raise RequestError(
                f"on = {shown(load.on)}: kind {self.kind!r} takes forces on its structure, "
                f"{structure}"
            )
        if load.harmonic:
            self.refuse_without_force()
        if load.harmonic and self.scene.shaken:
            raise _moves_by_a_tone("harmonic")
        refuse_twice(self.scene, names)
        for name, meant in zip(names, meant_by(self.scene, names), strict=True):
            if meant in ("Y", *BASES):
                raise _moves_by_a_tone(name)
            if not load.harmonic and meant in ("P", "omega"):
                raise RequestError(
                    f"{name}: the harmonic force is off under a load, so that all orbits would be "
                    "equal; harmonic = true adds it"
                )

    def refuse_without_force(self) -> None:
        missing = ", ".join(n for n, source in self.sources.items() if source == NOT_GIVEN)
        if missing:
            raise RequestError(f"parameters of kind {self.kind!r} are missing: {missing}")

    def changes_from(self, first: System) -> dict[str, Any]:
        before = first.parameters
        return {name: v for name, v in self.parameters.items() if v != before.get(name)}

    def has_parts_of(self, first: System) -> bool:
        return isinstance(first, Preset) and self._parts == first._parts

    @property
    def _parts(self) -> tuple[str, str, str]:
        return self.kind, self.law, self.law_2

    @property
    def drive(self) -> dict[str, float]:
        names = ("omega", "P", "Y", *BASES)
        return {name: self.parameters[name] for name in names if name in self.parameters}

    @property
    def contact_in_words(self) -> dict[str, float]:
        scene, constants = self.scene, dict[str, float]()
        if scene.law == HERTZ and scene.walls:
            constants["K"] = self.K
        for name in scene.contact(self.parameters):
            if name not in CONTACT:
                constants[name] = self.parameters[name]
        return constants

    @property
    def contact_laws(self) -> tuple[Law, ...]:
        return self.scene.laws

    def strokes(self, values: Mapping[str, Any], state: Mapping[str, Any]) -> list[Stroke]:
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

    def shortest_natural_period(self, grid: Mapping[str, np.ndarray]) -> float:
        cells = self.cells(grid)
        with np.errstate(divide="ignore"):
            return 2.0 * pi * float(np.sqrt(np.min(cells["m1"] / cells["k1"])))

    def energy_alone(self, cells: np.ndarray) -> np.ndarray:
        return energy_alone(cells)

    def steady_state(self, force: float, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        if self.scene.walls or self.scene.shaken:
            return None
        m1, k1, _ = self.structure
        X1, _ = amplitudes(self.with_(P=force), omega)
        amplitude = np.abs(X1)
        return amplitude, harmonic_energy(m1, k1, omega, amplitude)

    def closed_form(self, load: Any) -> dict[str, float]:
        return closed_form(self, load)

    def alone(self) -> Preset:
        scene = SCENES["none"]
        ratios = ratios_in(scene)
        values = {name: v for name, v in self.parameters.items() if name in scene.allowed}
        fixed = {name: v for name, v in self.fixed_ratios.items() if name in ratios}
        title = "Primary structure alone"
        return Preset("none", values, title=title, fixed_ratios=fixed)

    def with_tuned_mass(self, shaken: bool) -> Preset:
        if not self.scene.damper or not self.parameters.get("m2"):
            raise RequestError(f"{self.name} has no damper whose mass a tuned mass could have")
        scene = SCENES["tmd"]
        ratios = ratios_in(scene)
        values = {name: v for name, v in self.parameters.items() if name in scene.allowed}
        fixed = {name: v for name, v in self.fixed_ratios.items() if name in ratios}
        m1, k1, m2 = values["m1"], values["k1"], values["m2"]
        tuning, zeta = warburton(m2 / m1, shaken)
        k2 = m2 * k1 / m1 * tuning * tuning
        values |= {"k2": k2, "c2": 2.0 * zeta * sqrt(k2 * m2)}
        for name in ("frequency_ratio", "zeta2"):
            fixed.pop(name, None)
        return Preset("tmd", values, title="Tuned mass damper (Warburton)", fixed_ratios=fixed)

    def displacements(
        self, names: Sequence[str] = (), records: Collection[str] = ("response",)
    ) -> tuple[str, ...]:
        """Return no names: the response of a kind is that of its own coordinates."""
        if len(names):
            raise self._without_names(names)
        return ()

    def displacement(self, name: str) -> NoReturn:
        raise self._without_names([name])

    def _without_names(self, names: Sequence[str]) -> RequestError:
        return RequestError(
            f"of = {shown(list(names))}: kind {self.kind!r} names no displacements; its "
            "response is x1_max, a1_max and others by the symbols of the paper"
        )

    @property
    def damper_names(self) -> tuple[str, ...]:
        return ("damper",) if self.scene.damper else ()

    @property
    def chain(self) -> tuple[str, ...]:
        return ()

    @property
    def places(self) -> Mapping[str, float]:
        return {**self.scene.obstacle(self.parameters), "rest": self.rest or 0.0}

    # ---- along an orbit ----

    def shown(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        if len(of):
            raise RequestError(
                f"of = {shown(list(of))} is for displacements of a host; kind {self.kind!r} has "
                f"{', '.join(self.scene.components)}"
            )
        return ()

    def motions(self, of: Sequence[str] = ()) -> Motions:
        scene = self.scene
        rows = np.eye(len(scene.components) // 2)
        walls = {name: float(u) for name, u in scene.obstacle(self.parameters).items()}
        index = "_1" if scene.damper or "x1" in scene.components else ""
        structure = Motion(
            scene.body,
            (f"x{index}", rf"\dot{{x}}{index}"),
            rows[0],
            walls=walls if scene.grounded else {},
            component=0,
        )
        if not scene.damper:
            return Motions((structure,), (structure,), (), ())
        symbols = "x_2", r"\dot{x}_2"
        damper = Motion("damper", symbols, rows[1], walls=walls, carrier=rows[0], component=2)
        symbols = SIGNALS["u"].symbol, ""
        stroke = Motion("damper", symbols, rows[1] - rows[0], walls=walls, has_plane=False)
        return Motions((structure, damper), (structure,), (damper,), (stroke,))

    def signal(self, name: object) -> Signal:
        chosen = choice("signal", name, SIGNALS)
        words = SIGNALS[chosen]
        if chosen not in self._signals:
            raise RequestError(
                f"signal {chosen!r} ({words.meaning}) does not exist in kind {self.kind!r}; "
                f"allowed: {', '.join(self._signals)}"
            )
        return Signal(words.unit, words.meaning, words.symbol, partial(_OF_STATES[chosen], self))

    @property
    def _signals(self) -> tuple[str, ...]:
        """The names of the signals of the scene: no x2 without a damper, for example."""
        missing = {"x", "v", "x1", "v1", "x2", "v2"} - {*self.scene.components}
        if not self.scene.damper:
            missing |= {"u", "E2"}
        if not self.scene.forces:
            missing.add("force")
        return tuple(name for name in SIGNALS if name not in missing)

    def usual_signals(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        return self.scene.components[-2:-1]

    def recorded_signals(self, names: Sequence[str]) -> dict[str, Signal]:
        allowed = (*self.scene.components, *(["u"] if self.scene.damper else []))
        usual = [name for name in ("x1", "u", "x") if name in allowed]
        chosen = [choice("signal", name, allowed) for name in names or usual]
        return {name: self.signal(name) for name in chosen}

    def histories(self, of: Sequence[str] = ()) -> dict[str, Signal]:
        recorded = (*self.scene.components, "force", "E1", "E2")
        return {name: self.signal(name) for name in self._signals if name in recorded}

    @property
    def energy_signals(self) -> dict[str, str]:
        of_structure = {"E1": self.scene.body}
        return of_structure | ({"E2": "damper"} if self.scene.damper else {})

    @property
    def force_signals(self) -> tuple[str, ...]:
        return ("force",) if self.scene.forces else ()

    def contact_forces(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return the contact force on the damper [N] at each wall, by the name of the struck body.

        It is that of the law if the approach z > 0, F = K z^1.5 for Hertz (equations (2) and (3)),
        otherwise 0; positive toward +x2, as at the wall of an SSul.  The structure feels the
        opposite.
        """
        scene = self.scene
        if not scene.forces:
            return {}
        shortening = states[:, 0]
        rate = states[:, 1]
        if self.rest is not None:
            shortening = self.rest - (states[:, 2] - states[:, 0])
            rate = states[:, 1] - states[:, 3]
        by_wall = {}
        for wall, gap, sign in (("near", scene.gap_near, 1.0), ("far", scene.gap_far, -1.0)):
            law = scene.law_at(wall)
            if gap is not None and not law.instant:
                place = sign, gap(self.parameters)
                force = wall_force(law, self.contact(wall), place, shortening, rate)
                by_wall[scene.struck[wall]] = force
        return by_wall

    def contact_columns(self, states: np.ndarray) -> dict[str, np.ndarray]:
        forces = [*self.contact_forces(states).values()]
        names = ("contact_near", "contact_far") if len(forces) == 2 else ("contact",)
        return dict(zip(names, forces, strict=False))

    def harmonic_forces(self, time: np.ndarray) -> dict[str, np.ndarray]:
        return {"force": self.force * np.cos(self.parameters["omega"] * time)}

    # ---- words ----

    def parts_in_words(self) -> str:
        names = {kind: re.split("[:,]", scene.meaning)[0] for kind, scene in SCENES.items()}
        name = names[self.kind]
        is_ambiguous = list(names.values()).count(name) > 1
        return name[:1].upper() + name[1:] + (f" ({self.kind})" if is_ambiguous else "")

    def parameters_in_words(self, varied: Collection[str] = ()) -> str:
        gone = {*varied, *meant_by(self.scene, varied), *self.following(varied)}
        law = f" under {self.law}" if self.scene.walls else ""
        stated = self.statements.items()
        values = ", ".join(f"{name} = {value:g}" for name, value in stated if name not in gone)
        return f"{self.kind}{law}: {values}"

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
        return Preset, tuple(dict(v) if isinstance(v, Mapping) else v for v in values)

    def to_table(self) -> dict[str, Any]:
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        plain = {key: dict(v) if isinstance(v, Mapping) else v for key, v in values.items()}
        plain["parameters"] = self.statements
        del plain["fixed_ratios"]
        if self.law == HERTZ.name:
            del plain["law"]
        return {key: value for key, value in plain.items() if value}

    @property
    def ratios(self) -> dict[str, float]:
        return {**of_parameters(self.scene, self.parameters), **self.fixed_ratios}

    @property
    def statements(self) -> dict[str, float]:
        ratios = list(self.fixed_ratios)
        ratio_of = dict(zip(meant_by(self.scene, ratios), ratios, strict=True))
        statements = {}
        for name, value in self.parameters.items():
            if name in ratio_of:
                ratio = ratio_of[name]
                statements[ratio] = self.fixed_ratios[ratio]
            else:
                statements[name] = value
        return statements

    def following(self, names: Collection[str]) -> set[str]:
        return following(self.scene, self.fixed_ratios, names)

    @cached_property
    def scene(self) -> Scene:
        return SCENES[self.kind].under(self.law, self.law_2, self.parameters)

    @cached_property
    def cell(self) -> Any:
        """The record of `presets.cell_type` for the kernels, which only read it."""
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
        """Amplitude P of the harmonic force P cos(omega t) on the structure [N].

        If the ground moves, it is minus the structure's mass times the ground's acceleration.
        """
        return float(self._cell["P"])

    @property
    def rest(self) -> float | None:
        """Offset x2 - x1 [m] at which the damper's spring rests; None without a damper."""
        return None if self.scene.rest is None else float(self.scene.rest(self.parameters))

    @property
    def natural_period(self) -> float:
        m1, k1, _ = self.structure
        return 2 * pi * sqrt(m1 / k1) if k1 > 0.0 else inf

    @property
    def stiffness(self) -> str:
        return "k1" if "k1" in self.parameters else "k"

    @property
    def state_at_rest(self) -> tuple[float, ...]:
        rest = self.rest or 0.0
        return tuple(rest if name == "x2" else 0.0 for name in self.scene.components)

    @property
    def rests(self) -> tuple[Rest, ...]:
        """The one state in which the springs rest."""
        strokes = dict.fromkeys(self.damper_names, 0.0)
        return (Rest(strokes, True, self.state_at_rest),)

    @property
    def rest_in_words(self) -> str:
        return ""

    def with_(self, /, **overrides: Any) -> Preset:
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
        merged = merged_parameters(scene, before, overrides, self.fixed_ratios)
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
            fixed_ratios=stay | ratios_among(scene, overrides),
            sources=sources | dict.fromkeys(sorted(changed), BY_USER),
            assumptions={n: text for n, text in self.assumptions.items() if n in unchanged},
        )
        return system

    def with_axes(self, names: Iterable[str]) -> Preset:
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
        """Return the records of `presets.cell_type` for the kernels, one for each point of a grid.

        `grid` holds varied parameters and ratios by name, arrays that broadcast together.  If the
        ground moves, P is as `force`.  Raises `RequestError`, which names parameter and value, if
        one is not allowed.
        """
        if not grid:
            return self._cell.copy()
        varied = {name: np.asarray(values, dtype=np.float64) for name, values in grid.items()}
        values = merged_parameters(self.scene, self.parameters, varied, self.fixed_ratios)
        for name, value in varied.items():  # the others were checked when the system was made
            DESCRIBED[name].check(value)
        shape = np.broadcast_shapes(*(array.shape for array in varied.values()))
        return records_of(self.scene, values, shape)

    @cached_property
    def _cell(self) -> np.ndarray:
        return records_of(self.scene, self.parameters, ())


def _moves_by_a_tone(name: str) -> RequestError:
    return RequestError(
        f"{name}: under a load the ground moves by a tone, [load.tone] with amplitude, omega and "
        'unit = "m/s^2"'
    )


def _energy_of_structure(system: Preset, states: np.ndarray) -> np.ndarray:
    """Return E1 = (m1 v1^2 + k1 x1^2) / 2 [J], equation (6)."""
    m1, k1, _ = system.structure
    return 0.5 * (m1 * states[:, 1] ** 2 + k1 * states[:, 0] ** 2)


def _energy_of_damper(system: Preset, states: np.ndarray) -> np.ndarray:
    """Return E2 = (m2 v2^2 + k2 w^2) / 2 [J], equation (6)."""
    # w is the absolute displacement from rest, V + C for SSul, not the stretch of the spring
    p, w = system.parameters, states[:, 2] - system.rest
    return 0.5 * (p["m2"] * states[:, 3] ** 2 + p["k2"] * w**2)


def _contact_force(system: Preset, states: np.ndarray) -> np.ndarray:
    return sum(system.contact_forces(states).values(), np.zeros(len(states)))


_OF_STATES: Mapping[str, Callable[[Preset, np.ndarray], np.ndarray]] = {
    "x": lambda _, states: states[:, 0],
    "v": lambda _, states: states[:, 1],
    "x1": lambda _, states: states[:, 0],
    "v1": lambda _, states: states[:, 1],
    "x2": lambda _, states: states[:, 2],
    "v2": lambda _, states: states[:, 3],
    "u": lambda _, states: states[:, 2] - states[:, 0],
    "force": _contact_force,
    "E1": _energy_of_structure,
    "E2": _energy_of_damper,
}
"""The values of each of `SIGNALS` in states."""


# ---- hosts with dampers --------------------------------------------------------------------------


def _zero(parameters: Values) -> float:
    return 0.0


_SIGNALS = {
    "x": SignalWords("m", "displacement", "x"),
    "v": SignalWords("m/s", "velocity", r"\dot{x}"),
    "stroke": SignalWords("m", "displacement along the spring, positive toward its wall +,", "r"),
    "force": SignalWords("N", "contact force", "F"),
    "E2": SignalWords("J", "energy of the mass", "E_2"),
}
"""The signals of degrees of freedom and dampers, by key."""


OF_DISPLACEMENTS = {"response", "modulation"}  # the records of displacements by name

NOTHING: Mapping[str, float] = MappingProxyType({})


def _is_of_own_force(name: str) -> bool:
    """Return True for a number of a host's harmonic force, which is off under a load."""
    return name in ("omega", "f") or _is_drive(name)


def _is_drive(name: str) -> bool:
    """Return True for an amplitude of a host's forces, or of the motion of its ground."""
    return name.startswith((f"{FORCE}.", f"{GROUND}."))


def _displaced(row: np.ndarray, part: int, states: np.ndarray) -> np.ndarray:
    return displaced(row, states, part)


def _component_of(place: int, states: np.ndarray) -> np.ndarray:
    return states[:, place]


@dataclass(frozen=True, eq=False, repr=False)
class General(System):
    """A host with dampers under a harmonic force or motion of the ground; `System.from_host`.

    Attributes
    ----------
    host : Host
        The linear structure.
    dampers : tuple of Damper
        The dampers.
    force : mapping of str to float
        Amplitudes P [N] of the forces P cos(omega t), by degree of freedom.
    ground : mapping of str to float
        In place of a force, what moves the ground: the amplitude of its `acceleration` [m/s^2] or
        of its `displacement` [m].
    omega : float
        Frequency [rad/s].
    name, title : str
        A name, by default "host", and one line that describes the system.
    sources : mapping of str to str
        By the name of a number, the source of its value if it is known.
    """

    host: Host
    dampers: tuple[Damper, ...]
    force: Mapping[str, float]
    ground: Mapping[str, float]
    omega: float
    name: str = "host"
    title: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)

    kind = HOST
    fixed_ratios = MappingProxyType[str, float]({})

    def heading(self) -> str:
        """Return the title, or the host's heading and the number of dampers."""
        count = len(self.dampers)
        return self.title or f"{self.host.heading()}, {count} damper{'s' * (count != 1)}"

    def outline(self) -> Rows:
        """Return the dampers, the force and the host's frequencies."""
        for damper in self.dampers:
            mass = "" if damper.m is None else f"m = {damper.m:.6g}, "
            place = " and ".join(damper.places)
            spring = "" if damper.spring is None else f"{numbers(damper.spring.statements)}, "
            of_joint = f"k = {damper.k:.6g}, {spring}c = {damper.c:.6g}"
            yield damper.name, f"{mass}{of_joint}, on {place}"
        force = numbers(self.force) or f"{numbers(self.ground)} of the ground"
        yield "force", f"{force}; omega = {self.omega:.6g} rad/s"
        if self.rest_in_words:
            yield "rest", self.rest_in_words

    def parts_in_words(self) -> str:
        return self.heading()

    def parameters_in_words(self, varied: Collection[str] = ()) -> str:
        gone = {*varied, *self.following(varied)}
        stated = self.statements.items()
        values = ", ".join(f"{name} = {value:g}" for name, value in stated if name not in gone)
        return f"{self.kind}: {values}"

    @property
    def natural_period(self) -> float:
        lowest = next((omega for omega in self.host.frequencies.tolist() if omega > 0.0), 0.0)
        return 2 * pi / lowest if lowest else inf

    @property
    def stiffness(self) -> str:
        return f"{STRUCTURE_ITSELF}.K"

    @cached_property
    def state_at_rest(self) -> tuple[float, ...]:
        return state_of_rest(self)

    @property
    def rests(self) -> tuple[Rest, ...]:
        return rests_of(self)

    @property
    def rest_in_words(self) -> str:
        try:
            strokes = usual_strokes(self)
        except RequestError:
            return "not computed, of several coupled nonlinear springs"
        named = zip(self.damper_names, strokes, strict=True)
        return ", ".join(f"{name} at r = {r:.4g} m" for name, r in named if r != 0.0)

    @property
    def masses(self) -> tuple[Damper, ...]:
        """The dampers that have a mass, which come first."""
        return tuple(damper for damper in self.dampers if damper.m is not None)

    @cached_property
    def scene(self) -> HostScene:
        """The walls, laws and components of the host with its dampers.

        Components of states are those of the host, then those of the dampers' masses.  Each name
        stands for a displacement, and v_name for its rate.  If the host was reduced or
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
            with_rigid_walls=tuple(
                dict.fromkeys(name for name, wall in walls if LAWS[wall.law].instant)
            ),
            of_walls=tuple((name, wall.side) for name, wall in walls),
            springs=tuple(damper.name for damper in self.dampers if damper.spring is not None),
            settable=tuple(name for name in self.allowed if name not in RATIOS),
            shaken="" if self.force else GROUND,
        )

    @property
    def statements(self) -> Mapping[str, float]:
        return self.parameters

    @property
    def ratios(self) -> Mapping[str, float]:
        return {"f": self.omega / (2 * pi)}

    def following(self, names: Collection[str]) -> set[str]:
        changed = {part for name in names if name not in INITIAL for part in self.parts(name)}
        of_damping = {f"{STRUCTURE_ITSELF}.C", f"{STRUCTURE_ITSELF}.ratio"}
        changes_frequencies = not changed.isdisjoint({*self.host.settable} - of_damping)
        for damper in self.dampers:
            prefix = f"{damper.name}."
            keys = [name.removeprefix(prefix) for name in changed if name.startswith(prefix)]
            if damper.frequency_ratio is not None and changes_frequencies:
                keys.append("k")
                changed.add(f"{prefix}k")
            changed |= {prefix + key for key in damper.following(keys)}
        return {name for name in self.parameters if not changed.isdisjoint(self.parts(name))}

    def with_axes(self, names: Iterable[str]) -> General:
        names = [name for name in names if name not in INITIAL]
        self.refuse_twice(names)
        drives = [name for name in names if _is_drive(name)]
        new = {name: 0.0 for name in drives if name not in self.parameters}
        unstated = self.host.unstated
        new |= {name: unstated[name] for name in names if name in unstated}
        return self.with_values(new, new.values()) if new else self

    def takes(self, name: str) -> bool:
        return name in self.allowed

    def refuse_under(
        self,
        load: Any,
        names: Collection[str],
        *,
        settle: float = 0.0,
    ) -> None:
        if load.harmonic:
            raise RequestError("harmonic: a host takes a tone, [load.tone] with amplitude, omega")
        if settle:
            raise RequestError(f"settle = {settle:g}: the rms of hosts is over all times")
        for name in names:
            if _is_of_own_force(name):
                raise RequestError(f"{name}: a system's own force is off under a load")
        self.refuse_twice(name for name in names if self.takes(name))
        if load.acts:
            self.under(load)

    def refuse_without_force(self) -> None:
        if not (self.force or self.acceleration):
            raise RequestError("a host without a force: give [system.force]")

    def refuse_corners(self, corners: Iterable[Mapping[str, float]]) -> None:
        for corner in corners:
            self.with_(**corner)

    @property
    def drive(self) -> dict[str, float]:
        amplitudes = [name for name in self.parameters if _is_drive(name)]
        return {name: self.parameters[name] for name in ("omega", *amplitudes)}

    @property
    def contact_in_words(self) -> dict[str, float]:
        """Return nothing: each wall has constants of its own."""
        return {}

    @property
    def contact_laws(self) -> tuple[Law, ...]:
        return tuple(LAWS[wall.law] for damper in self.dampers for wall in damper.walls)

    def strokes(self, values: Mapping[str, Any], state: Mapping[str, Any]) -> list[Stroke]:
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

    def shortest_natural_period(self, grid: Mapping[str, np.ndarray]) -> float:
        of_host = {name: np.ravel(grid[name]) for name in grid if name in self.host.settable}
        periods = [self.natural_period]
        for values in zip(*of_host.values(), strict=True):
            periods.append(self.with_values(of_host, map(float, values)).natural_period)
        return min(periods)

    def energy_alone(self, cells: np.ndarray) -> None:
        return None

    def steady_state(self, force: float, omega: np.ndarray) -> None:
        return None

    def closed_form(self, load: Any) -> dict[str, float]:
        return {}

    def alone(self) -> General:
        return replace(self, dampers=(), name="host", title="")

    def with_tuned_mass(self, shaken: bool) -> General:
        masses = [damper.m for damper in self.dampers if damper.m is not None]
        if not masses:
            raise RequestError(f"{self.name} has no damper whose mass a tuned mass could have")
        place = next(damper.places[0] for damper in self.dampers if damper.m is not None)
        m = fsum(masses)
        rates = self.host.frequencies
        first = int(np.flatnonzero(rates > 0.0)[0])
        shape = float(self.host.modes[self.host.dofs.index(place), first])
        tuning, zeta = warburton(m * shape * shape, shaken)
        rate = float(rates[first]) * tuning
        damper = Damper("tmd", place, m=m, k=m * rate * rate, c=2.0 * zeta * m * rate)
        return replace(self, dampers=(damper,), name="tmd", title="")

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
        self._refuse_unbounded(values)
        values = {"omega": np.asarray(self.omega), **values}
        shape = np.broadcast_shapes(*(array.shape for array in values.values()))
        cells = np.zeros(shape, [(name, np.float64) for name in values])
        for name, array in values.items():
            cells[name] = array
        return cells

    def _refuse_unbounded(self, values: Mapping[str, np.ndarray]) -> None:
        """Raise `RequestError` if in one of the cells a spring's energy has no lower bound."""
        for damper in self.dampers:
            coefficients = dict(zip(SPRING_KEYS, damper.coefficients, strict=True))
            of_spring: dict[str, Any] = {"k": damper.k, **coefficients}
            varied = [key for key in of_spring if f"{damper.name}.{key}" in values]
            if not varied:
                continue
            for key in ("f", "frequency_ratio"):
                if f"{damper.name}.{key}" in values:
                    of_spring["k"] = 0.0  # or more
            for key in varied:
                of_spring[key] = values[f"{damper.name}.{key}"]
            refuse_unbounded(damper.name, damper.spring is not None, *of_spring.values())

    @cached_property
    def parameters(self) -> Mapping[str, float]:  # type: ignore[override]  # of a preset a field
        """The numbers by name [SI]: floor2.k, cell1.k, cell1.gap, omega, and the amplitudes of what
        drives the host, force.roof, or ground.acceleration or ground.displacement.

        Of two walls with different numbers each has its own: cell1.gap+, cell1.gap-.  Those of the
        host are `Host.numbers`.
        """
        of_dampers = {
            f"{damper.name}.{key}": value
            for damper in self.dampers
            for key, value in damper.parameters.items()
        }
        forces = {f"{FORCE}.{dof}": P for dof, P in self.force.items()}
        motions = {f"{GROUND}.{key}": value for key, value in self.ground.items()}
        drive = forces or motions
        return MappingProxyType({**of_dampers, **self.host.numbers, **drive, "omega": self.omega})

    @property
    def numbers(self) -> Mapping[str, float]:
        return {**self.host.unstated, **self.ratios, **self.parameters}

    @cached_property
    def allowed(self) -> tuple[str, ...]:
        """The names of all numbers that `with_` replaces, and that an axis may have."""
        of_dampers = (f"{damper.name}.{k}" for damper in self.dampers for k in damper.allowed)
        forces = (f"{FORCE}.{dof}" for dof in self.host.places)
        motions = (f"{GROUND}.{key}" for key in MOTIONS)
        return (*of_dampers, *self.host.settable, *forces, *motions, "omega", "f")

    def parts(self, name: str) -> tuple[str, ...]:
        """Return the names of single numbers that a name means: gap+ and gap- for gap.

        Raises `RequestError` for a name that the system does not have.
        """
        if name in self.host.settable:
            return (name,)
        owner, key, side = split_name(name)
        damper = next((damper for damper in self.dampers if damper.name == owner), None)
        if owner == FORCE and key:
            choice("degree of freedom", key, self.host.places)
        elif owner == GROUND and key:
            with at(GROUND):
                choice("motion", key, MOTIONS)
        elif damper and key and key + side not in (*damper.allowed, PLACE):
            with at(f"damper {owner!r}"):
                keys = [key for key in damper.allowed if key[-1] not in SIDES]
                raise unknown("parameter", key + side, [*keys, PLACE])
        elif not (damper and key) and name not in ("omega", "f"):
            motions = [f"{GROUND}.{key}" for key in MOTIONS]
            raise unknown("parameter", name, dict.fromkeys([*self.parameters, *motions, "f"]))
        if damper is None or side:
            return ("omega",) if name == "f" else (name,)
        if key in RATIOS_OF_DAMPERS:
            return (f"{owner}.{RATIOS_OF_DAMPERS[key]}",)
        sides = (wall.side for wall in damper.walls if key in ("gap", *LAWS[wall.law].allowed))
        return tuple(name + wall for wall in sides) or (name,)

    def refuse_twice(self, names: Iterable[str]) -> None:
        """Raise `RequestError` for an unknown name, and if two of `names` mean one number."""
        names, first = [*names], dict[str, str]()
        for name in names:
            for part in self.parts(name):
                if first.setdefault(part, name) != name:
                    raise RequestError(f"{first[part]} beside {name}: give one of them")
        motions = [name for name in names if name.startswith(f"{GROUND}.")]
        others = (
            [name for name in names if _is_drive(name) and name != motions[0]] if motions else []
        )
        if others:
            raise RequestError(f"{motions[0]} beside {others[0]}: give one of them")

    def with_(self, /, **changes: Any) -> General:
        values = flat(changes)
        self.refuse_twice(values)
        for name in values:
            if not name.endswith(f".{PLACE}"):
                values[name] = number(name, values[name])
                DESCRIBED[name].check(values[name])
        system = self.with_values(values, values.values())
        check_places(self.host, system.dampers)
        changed = system.changes_from(self)
        unchanged = {n: text for n, text in self.sources.items() if n not in changed}
        return replace(system, sources={**unchanged, **dict.fromkeys(changed, BY_USER)})

    def changes_from(self, first: System) -> dict[str, Any]:
        before: dict[str, Any] = {**first.parameters}
        values: dict[str, Any] = {**self.parameters}
        if isinstance(first, General):
            before |= first._places
            values |= self._places
        return {name: value for name, value in values.items() if value != before.get(name)}

    @property
    def _places(self) -> dict[str, Any]:
        return {f"{damper.name}.{PLACE}": damper.attached_to for damper in self.dampers}

    def has_parts_of(self, first: System) -> bool:
        if not isinstance(first, General):
            return False
        try:
            changed = first.with_(**self.changes_from(first))
        except RequestError:  # of a number that `first` does not have
            return False
        return changed._without_sources == self._without_sources

    @property
    def _without_sources(self) -> dict[str, Any]:
        described = self.to_table()
        described.pop("sources", None)
        return described

    def with_values(self, names: Iterable[str], values: Iterable[Any]) -> General:
        """Return the system with other numbers by names that `refuse_twice` allows.

        Neither names nor ranges are checked: one call for each cell of a scan.
        """
        omega, forces, ground = self.omega, self.force, self.ground
        of_dampers: dict[str, dict[str, Any]] = {}
        of_host: dict[str, float] = {}
        settable = self.host.settable
        for name, value in zip(names, values, strict=True):
            owner, _, key = name.partition(".")
            if name in settable:
                of_host[name] = value
                continue
            if name in ("omega", "f"):
                omega = value if name == "omega" else value * (2 * pi)
            elif owner == GROUND:
                forces, ground = {}, {key: value}
            elif owner == FORCE:
                forces, ground = {**forces, key: value}, {}
            else:
                of_dampers.setdefault(owner, {})[key] = value
        host = self.host.with_numbers(of_host) if of_host else self.host
        dampers = []
        for damper in self.dampers:
            if damper.name in of_dampers:
                damper = damper.changed(of_dampers[damper.name])
            dampers.append(damper.tuned_to(host))
        return replace(
            self,
            host=host,
            dampers=tuple(dampers),
            force=MappingProxyType(dict(forces)),
            ground=MappingProxyType(dict(ground)),
            omega=omega,
        )

    def to_table(self) -> dict[str, Any]:
        from nlds_vines.model.host import table_of

        dampers = [
            {
                "name": damper.name,
                PLACE: list(damper.places) if damper.m is None else damper.places[0],
                **damper.statements,
                **({} if damper.spring is None else {"spring": damper.spring.statements}),
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
            drive["base"] = dict(self.ground)
        return {
            "kind": self.kind,
            **{key: getattr(self, key) for key in ("name", "title") if getattr(self, key)},
            "host": table_of(self.host),
            **({"dampers": dampers} if dampers else {}),
            "force": drive,
            **({"sources": dict(self.sources)} if self.sources else {}),
        }

    def __reduce__(self) -> tuple[Any, ...]:
        return general_from, (self.to_table(),)

    def attributes(self, varied: Collection[str] = ()) -> dict[str, str | float]:
        gone = self.following(varied)
        values = {name: value for name, value in self.parameters.items() if name not in gone}
        # wells move with all numbers but those of the drive
        is_rest_common = gone <= self.drive.keys()
        rest = self.rest_in_words if is_rest_common else ""
        return {
            "system": self.name,
            "kind": self.kind,
            "host": self.host.heading(),
            **values,
            **{f"{damper.name}.{PLACE}": " and ".join(damper.places) for damper in self.dampers},
            **({"rest": rest} if rest else {}),
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
        names = (names,) if isinstance(names, str) else tuple(names)
        if OF_DISPLACEMENTS.isdisjoint(records):
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

    @property
    def damper_names(self) -> tuple[str, ...]:
        return tuple(damper.name for damper in self.dampers)

    @property
    def owning_dampers(self) -> tuple[str, ...]:
        return self.damper_names

    @property
    def chain(self) -> tuple[str, ...]:
        """The degrees of freedom that the ground moves, thus no rotations of a beam, or else all.

        None of a structure with one degree of freedom.
        """
        return self._along_ground if len(self.host.dofs) > 1 else ()

    @property
    def _along_ground(self) -> tuple[str, ...]:
        pairs = zip(self.host.dofs, self.host.influence.tolist(), strict=True)
        return tuple(dof for dof, moved in pairs if moved) or self.host.dofs

    @property
    def places(self) -> Mapping[str, float]:
        walls = [(damper.name, wall) for damper in self.dampers for wall in damper.walls]
        return {f"{name}.gap{wall.side}": wall.gap for name, wall in walls}

    # ---- along an orbit ----

    def shown(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        usual = () if self.dampers else tuple(self.force) or self._along_ground[-1:]
        return self.displacements(of or usual)

    def motions(self, of: Sequence[str] = ()) -> Motions:
        bodies = []
        for name in self.shown(of):
            row, _ = self.displacement(name)
            symbols = "x", r"\dot{x}"
            bodies.append(Motion(name, symbols, row, name, component=self._component(row)))
        strokes = []
        for damper, row in zip(self.dampers, self.rows(), strict=True):
            stroke = Motion(
                damper.name,
                ("r", r"\dot{r}"),
                row,
                damper.name,
                walls={wall.side: SIDES[wall.side] * wall.gap for wall in damper.walls},
                component=self._component(row),
                shows_touches=True,
            )
            strokes.append(stroke)
        return Motions(tuple(bodies), tuple(bodies), tuple(strokes), tuple(strokes))

    def _component(self, row: np.ndarray) -> int | None:
        """Return the place in a state of the last body that a displacement w X depends on.

        None if it is no body but a mode.
        """
        bodies = np.flatnonzero(row).tolist()
        if not bodies:
            return None
        is_body = self.host.is_plain or bodies[-1] >= len(self.host.inertia)
        return 2 * bodies[-1] if is_body else None

    def signal(self, name: object) -> Signal:
        """Return the signal of a displacement `roof` or `roof.v`, of a damper `cell.force`, or E1.

        Raises `RequestError` for other names.
        """
        text = str(name)
        if text == "E1":
            return Signal("J", "energy of the host", "E_1", self._energy_of_host)
        owner, _, key = text.rpartition(".")
        if not owner:
            owner, key = text, "x"
        with at(f"signal {text!r}"):
            choice("quantity", key, _SIGNALS)
            unit, words, symbol = _SIGNALS[key]
            meaning = f"{words} of {owner}"
            if key in ("x", "v"):
                row, _ = self.displacement(owner)
                of_states = partial(_displaced, row, "xv".index(key))
                return Signal(unit, meaning, symbol, of_states, owner)
            dampers = {damper.name: damper for damper in self.dampers}
            damper = dampers[choice("damper", owner, dampers)]
        if key == "stroke":
            of_states = partial(_displaced, self.displacement(damper.stroke)[0], 0)
        elif key == "force":
            of_states = partial(self._force_on, damper)
        else:
            of_states = partial(self._energy_of_mass, damper)
        return Signal(unit, meaning, symbol, of_states, owner)

    def usual_signals(self, of: Sequence[str] = ()) -> tuple[str, ...]:
        return self.shown(of)

    def recorded_signals(self, names: Sequence[str]) -> dict[str, Signal]:
        signals = {name: self.signal(name) for name in names or self.usual_signals()}
        for name, signal in signals.items():
            if signal.unit not in ("m", "m/s"):
                raise RequestError(
                    f"signal {name!r} is {signal.meaning}; spectra of scans are of displacements "
                    "and velocities, as roof, roof-floor1, roof.v or cell.stroke"
                )
        return signals

    def histories(self, of: Sequence[str] = ()) -> dict[str, Signal]:
        signals = {}
        for i, name in enumerate(self.scene.components):
            key = "xv"[i % 2]
            owner = name if key == "x" else name.removeprefix("v_")
            unit, words, symbol = _SIGNALS[key]
            of_states = partial(_component_of, i)
            words = f"{words} of {owner}"
            signals[f"{owner}.{key}"] = Signal(unit, words, symbol, of_states, owner)
        names = [f"{name}.x" for name in self.shown(of)]
        names.append("E1")
        for damper in self.dampers:
            present = {"stroke": True, "force": damper.has_force, "E2": damper.m is not None}
            names += [f"{damper.name}.{key}" for key, is_there in present.items() if is_there]
        return signals | {name: self.signal(name) for name in names if name not in signals}

    @property
    def energy_signals(self) -> dict[str, str]:
        of_masses = {f"{damper.name}.E2": damper.name for damper in self.masses}
        return {"E1": self.scene.body, **of_masses}

    @property
    def force_signals(self) -> tuple[str, ...]:
        return tuple(f"{damper.name}.force" for damper in self.dampers if damper.has_force)

    def contact_forces(self, states: np.ndarray) -> dict[str, np.ndarray]:
        return {
            damper.name: self._force_on(damper, states)
            for damper in self.dampers
            if damper.has_force
        }

    def contact_columns(self, states: np.ndarray) -> dict[str, np.ndarray]:
        return {f"{name}.force": force for name, force in self.contact_forces(states).items()}

    def harmonic_forces(self, time: np.ndarray) -> dict[str, np.ndarray]:
        phase = np.cos(self.omega * time)
        return {f"{FORCE}.{dof}": P * phase for dof, P in self.force.items()}

    def _energy_of_host(self, states: np.ndarray) -> np.ndarray:
        """Return (V^T M V + X^T K X) / 2 [J], as `Orbit.E1max`."""
        total = np.zeros(len(states))
        for matrix, part in ((self.host.M, 1), (self.host.K, 0)):
            for i, j in zip(*np.nonzero(matrix), strict=True):
                total += 0.5 * matrix[i, j] * states[:, 2 * i + part] * states[:, 2 * j + part]
        return total

    def _energy_of_mass(self, damper: Damper, states: np.ndarray) -> np.ndarray:
        """Return (m v^2 + k x^2) / 2 [J], as `Orbit.E2max`; k r^2 / 2 + G(r) of its own spring."""
        row, _ = self.displacement(damper.name)
        x = displaced(row, states, 0)
        v = displaced(row, states, 1)
        kinetic = 0.5 * float(damper.m or 0.0) * v**2
        if damper.spring is None:
            return kinetic + 0.5 * damper.k * x**2
        stroke, _ = self.displacement(damper.stroke)
        r = displaced(stroke, states, 0)
        return kinetic + 0.5 * damper.k * r**2 + damper.spring.energy(r)

    def _force_on(self, damper: Damper, states: np.ndarray) -> np.ndarray:
        """Return the force [N] of a damper's walls on its mass, positive in the direction of x."""
        row, _ = self.displacement(damper.stroke)
        r = displaced(row, states, 0)
        s = displaced(row, states, 1)
        forces = [
            wall_force(LAWS[wall.law], wall.constants, (SIDES[wall.side], wall.gap), r, s)
            for wall in damper.walls
        ]
        return sum(forces, np.zeros(len(states)))

    # ---- forces and loads ----

    @property
    def acceleration(self) -> float:
        """The amplitude [m/s^2] of the ground's acceleration, -omega^2 times its displacement."""
        if "displacement" in self.ground:
            return -(self.omega**2) * self.ground["displacement"]
        return self.ground.get("acceleration", 0.0)

    @property
    def displacement_of_ground(self) -> float:
        """The amplitude [m] of the ground's displacement, -1/omega^2 times its acceleration."""
        if "acceleration" in self.ground:
            return -self.ground["acceleration"] / (self.omega * self.omega)
        return self.ground.get("displacement", 0.0)

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

    def under(self, load: Any) -> General:
        """Return the system under 1 N on each of the load's degrees of freedom times its factor.

        Under a motion of the ground, it is one by -1 m/s^2, as the load is minus its acceleration.
        Raises `RequestError` for degrees of freedom that are missing, out of place or unknown.
        """
        if load.shaken:
            if load.on is not None:
                raise RequestError("on: the loads move the ground, and no degree of freedom else")
            return self.with_values([f"{GROUND}.acceleration"], [-1.0])
        dofs, on = self.host.places, load.on
        if on is None:
            if len(dofs) > 1:
                names = ", ".join(dofs)
                raise RequestError(f"on is missing, the degree of freedom of the force: {names}")
            on = dofs[0]
        factors = {on: 1.0} if isinstance(on, str) else dict(on)
        for dof in factors:
            choice("degree of freedom in on", dof, dofs)
        return replace(self, force=MappingProxyType(factors), ground=NOTHING)


def _signature_of(form: type[System]) -> Signature:
    _, *parameters = signature(form.__init__).parameters.values()
    return Signature(parameters)


# inspect would show that of `System.__new__`, (*args, **kwargs)
for _class, _form in ((System, Preset), (Preset, Preset), (General, General)):
    setattr(_class, "__signature__", _signature_of(_form))  # noqa: B010  # no attribute by type


def system_from_host(
    host: Host,
    dampers: Sequence[Damper],
    force: Mapping[str, float] | None,
    base: Mapping[str, Any] | None,
    omega: float | None,
    name: str,
    title: str,
) -> General:
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
    forces, ground = {}, {}
    if base is not None:
        table("base", base, ("influence", *MOTIONS))
        influence = base.get("influence", ALL)
        if influence != ALL:
            influence = by_dof_names("influence", influence)
            host = with_influence(host, table("influence", influence))
        given = [key for key in MOTIONS if key in base]
        if len(given) != 1:
            raise RequestError(f"base needs one of {' and '.join(MOTIONS)}")
        ground[given[0]] = number(given[0], base[given[0]])
    else:
        for dof, P in table("force", by_dof_names("force", force)).items():
            choice("degree of freedom of the force", dof, host.places)
            forces[dof] = number(f"force.{dof}", P)
    if not all_are(Damper, dampers):
        raise RequestError(f"dampers = {shown(dampers)} must be a list of Damper")
    # dampers with a mass come first, as the links of kernels do
    tuned = [damper.tuned_to(host) for damper in dampers]
    ordered = tuple(sorted(tuned, key=lambda damper: damper.m is None))
    check_places(host, ordered)
    words = string("name", name) or HOST, string("title", title)
    drive = MappingProxyType(forces), MappingProxyType(ground)
    system = General(host, ordered, *drive, float(omega), *words)
    component, count = Counter(system.scene.components).most_common(1)[0]
    if count > 1:
        raise RequestError(f"{component!r} names two components of states: take another name")
    return system


def general_from(entry: Mapping[str, Any], name: str = "", *, needs_force: bool = True) -> General:
    """Return the system of a table `[system]` of kind "host", by default with a `name`."""
    from nlds_vines.model.host import host_from

    table("system", entry, GENERAL_KEYS)
    damper_entries, drive = entry.get("dampers", []), entry.get("force")
    if not isinstance(damper_entries, list):
        raise RequestError(f"dampers = {shown(damper_entries)} must be tables [[system.dampers]]")
    dampers = []
    for place, one in enumerate(damper_entries, start=1):
        with at(f"[[system.dampers]] {place}"):
            dampers.append(damper_from(one))
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
    system = system_from_host(host, dampers, forced, drive.get("base"), rate, *words)
    sources = dict(table("sources", entry.get("sources", {})))
    for key, text in sources.items():
        string(f"sources.{key}", text, lines=True)
    return replace(system, sources=sources)


GENERAL_KEYS = ("kind", "name", "title", "host", "dampers", "force", "sources")
FORCE_KEYS = ("at", "base", "omega", "f")
