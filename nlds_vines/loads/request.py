"""The request of a response history: dampers on a structure, a load, and a duration."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import RESPONSE_HISTORY, Value
from nlds_vines.errors import MOST_CHARACTERS, RequestError, at, from_text, number, shown, string
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import as_system, load_system, system_from
from nlds_vines.model.load_quantities import OF_LOADS
from nlds_vines.model.loads.loading import ALL, NUMBERS, Loading, Struck, words_of_number
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.ratios import meant_by, ratios_in, refuse_twice
from nlds_vines.model.scenes import Scene
from nlds_vines.model.setting import (
    Checked,
    Form,
    Merged,
    Real,
    Request,
    Whole,
    check_settings,
    entries,
    setting,
)
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.solver_settings import tolerance_setting
from nlds_vines.orbits.starts import starts_inside

TOLERANCE = 1e-10
"""Of contacts, by default: finer than that of scans, as the energy balance shows each of them."""

MOST_STATES = 10**7
"""States of a history: as many as a portrait may have."""

MOST_CASES = 10**7
"""Systems and loads of a scan: days of work."""

FORCES = ("P", "base_displacement", "base_acceleration")
"""The parameters of the harmonic force, which is off unless the load has it."""


def _state(value: object) -> tuple[float, ...]:
    """Return a state at t = 0."""
    if not isinstance(value, list | tuple | np.ndarray):
        raise RequestError(f"state = {shown(value)} must be a list of numbers")
    read = (from_text(float, "state", one) if isinstance(one, str) else one for one in value)
    return tuple(number("state", one) for one in read)


@dataclass(frozen=True, repr=False)
class HistoryRequest(Request):
    """What acts on which structures, and how long; checked when made, immutable afterwards.

    Arguments:
        title: one line for people.
        systems: one or more.
        load: what acts; the harmonic force is off unless `load.harmonic`.
        vary: up to two parameters or numbers of the load (`impulse`, `scale`, `friedlander.peak`)
            and their values: a scan, in which histories are not kept.

    and what the fields say of themselves.  Raises `RequestError` for anything else.
    """

    content: ClassVar[str] = RESPONSE_HISTORY

    title: str
    systems: tuple[System, ...]
    load: Loading = field(default_factory=Loading)
    vary: tuple[Axis, ...] = ()
    state: tuple[float, ...] = setting(
        (), Checked(_state, listed=True), "start",
        "x1, v1, x2, v2 at t = 0, before any blow [m, m/s]", "X1,V1,...", option="--start",
        usual="at rest",
    )  # fmt: skip
    duration: float = setting(
        60.0, Real(1e-6, 1e9), "sampling", "of the response history [s]", "SECONDS"
    )
    samples: int = setting(
        64, Whole(8, 10**5), "sampling", "states in each natural period of the structure"
    )
    settle: float = setting(
        0.0, Real(0.0, 1e9), "sampling",
        "time that the rms of x1 leaves out [s]", "SECONDS",
    )  # fmt: skip
    tolerance: float | str = tolerance_setting("sampling", TOLERANCE)

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        check_settings(self)
        if not self.systems:
            raise RequestError("no damper is named; allowed: one or more systems")
        names = [system.name for system in self.systems]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise RequestError(f"{twice} stands twice: give one of them another name")
        if self.windows * self.samples > MOST_STATES:
            raise RequestError(
                f"{self.windows} natural periods with {self.samples} states each; allowed: "
                f"{MOST_STATES} states"
            )
        if self.settle >= self.duration:
            raise RequestError(
                f"settle = {self.settle:g} s must be below the duration, {self.duration:g} s"
            )
        self._check_axes()
        corners = self._corners()
        if not all(load.acts for _, load in corners) and not self.state:
            kinds = ", ".join((*NUMBERS, "harmonic", *ALL))
            raise RequestError(f"[load] is empty and no start is given; allowed: {kinds}")
        for system, load in corners:
            load.check(self.duration, natural_period(system))
        for system in self.systems:
            if self.state and len(self.state) != len(system.scene.components):
                components = ", ".join(system.scene.components)
                raise RequestError(
                    f"state = {list(self.state)} of {system.name} must be {components}"
                )

    def _check_axes(self) -> None:
        """Refuse axes that nothing has, and more than can be drawn or computed."""
        if len(self.vary) > 2:
            raise RequestError(f"{len(self.vary)} parameters vary; allowed: one or two")
        if self.cases > MOST_CASES:
            raise RequestError(f"{self.cases} systems and loads; allowed: up to {MOST_CASES}")
        names = [axis.name for axis in self.vary]
        of_systems = [name for name in names if not is_of_load(name)]
        for name in of_systems:
            if not any(has(system, name) for system in self.systems):
                self.systems[0].with_(**{name: 1.0})  # which says what is allowed
        for system in self.systems:
            refuse_twice(system.scene, of_systems)
            refuse_without_effect(system.scene, self.load, of_systems)
        for axis in self.vary:
            if is_of_load(axis.name):
                self.load.check_values(axis.name, axis.values)

    def _corners(self) -> list[tuple[System, Loading]]:
        """Return each system with its load at the ends of all axes."""
        shape = (len(self.systems), *self.shape)
        ends = product(range(len(self.systems)), *((0, size - 1) for size in self.shape))
        return [self.case(int(np.ravel_multi_index(place, shape))) for place in ends]

    def starts_inside(self) -> list[str]:
        """Return a line on starts inside a wall for each damper that has any."""
        found = []
        for system in self.systems:
            axes = [axis for axis in self.vary if has(system, axis.name)]
            grid = np.meshgrid(*(axis.values for axis in axes), indexing="ij", sparse=True)
            places = dict(zip((axis.name for axis in axes), grid, strict=True))
            state = dict(zip(system.scene.components, self.state, strict=False))
            parameters, shape = {**system.parameters, **places}, tuple(a.values.size for a in axes)
            lines = starts_inside(system.scene, parameters, state, shape)
            found += [f"{system.name}: {line}" for line in lines]
        return found

    def case(self, number: int) -> tuple[System, Loading]:
        """Return the system and the load of a case, counted through the systems, then the axes.

        A parameter that a system does not have is left out.
        """
        which, *places = np.unravel_index(number, (len(self.systems), *self.shape))
        values = {
            axis.name: float(axis.values[place])
            for axis, place in zip(self.vary, places, strict=True)
        }
        system = self.systems[which]
        own = {name: value for name, value in values.items() if has(system, name)}
        return (
            system.with_(**own) if own else system,
            self.load.with_({name: value for name, value in values.items() if is_of_load(name)}),
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(axis.values.size for axis in self.vary)

    @property
    def cases(self) -> int:
        """How many orbits there are."""
        return len(self.systems) * math.prod(self.shape)

    @property
    def windows(self) -> int:
        """How many natural periods of the first structure the duration has, at least one."""
        period = natural_period(self.systems[0])
        return max(1, round(self.duration / period)) if math.isfinite(period) else 1

    @property
    def times(self) -> np.ndarray:
        """The times (windows samples + 1,) [s] of a history, from 0 on."""
        return np.linspace(0.0, self.duration, self.windows * self.samples + 1)

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself."""
        return {"load": self.load.words(), "duration": self.duration}

    def document(self) -> dict[str, Any]:
        """Return the complete request file of this response history, as nested tables."""
        found = {
            "title": self.title,
            "systems": [system.to_table() for system in self.systems],
            "vary": {axis.name: {"values": axis.values.tolist()} for axis in self.vary},
            "load": self.load.to_table(),
            "start": entries(self, "start"),
            "sampling": entries(self, "sampling"),
        }
        return {key: value for key, value in found.items() if value}


def refuse_without_effect(scene: Scene, load: Loading, names: Collection[str]) -> None:
    """Raise `RequestError` for the first of `names` that says something of a force that is off."""
    for name, meant in zip(names, meant_by(scene, names), strict=True):
        if not load.harmonic and meant in (*FORCES, "omega"):
            raise RequestError(
                f"{name}: the harmonic force is off under a load, so that all orbits would be "
                "equal; harmonic = true adds it"
            )


def has(system: System, name: str) -> bool:
    """Return True if a system has a parameter, or a ratio, of this name."""
    return name in system.scene.allowed or name in ratios_in(system.scene)


def is_of_load(name: str) -> bool:
    """Tell whether the name of an axis is that of a number of the load."""
    return name in NUMBERS or "." in name


_NEVER = ("damping_ratio", "balance")
"""Numbers that no tuning makes small."""

_OF_CONTACTS = ("share_contact", "force_max", "impulse_max", "impact_count")


def objectives_of_loads(scene: Scene, shaken: bool) -> dict[str, str]:
    """Return the numbers that a tuning of a damper under a load may minimize, with their units.

    shaken: whether the load is an acceleration of the ground.
    """
    contacts = () if scene.walls else _OF_CONTACTS
    never = (*_NEVER, *contacts, *(() if shaken else ("drift_max",)))
    return {entry.name: entry.unit for entry in OF_LOADS if entry.name not in never}


def axis_words(request: HistoryRequest, name: str) -> tuple[str, str]:
    """Return the unit and the meaning of an axis."""
    if name in DESCRIBED:
        return DESCRIBED[name].unit, DESCRIBED[name].meaning
    return words_of_number(request.load, name)


def mass_of(system: System) -> str:
    """Return the name of the mass that is struck."""
    return "m1" if "m1" in system.parameters else "m"


def spring_of(parameters: Any) -> str:
    """Return the name of the spring that holds it."""
    return "k1" if "k1" in parameters else "k"


def natural_period(system: System) -> float:
    """Return the natural period of the structure alone [s], undamped; infinite without a spring."""
    p = system.parameters
    mass, spring = p[mass_of(system)], p.get(spring_of(p), 0.0)
    return 2 * math.pi * math.sqrt(mass / spring) if spring > 0.0 else math.inf


def struck(system: System) -> Struck:
    """Return what of a system a load acts on."""
    p = system.parameters
    return Struck(p[mass_of(system)], system.force, p["omega"])


FORM = Form(
    "response history",
    (HistoryRequest, Loading),
    whole=("vary",),
    lists=("systems",),
    nested=ALL,
    sources="a path, a name, a System, a list of these, a table or a HistoryRequest",
)
"""The tables and keys of the request file of a response history."""

USUAL = ("none", "tmd", "ssbl", "ssul-set6")
"""The systems that are compared by default: the structure alone, and the paper's dampers."""

Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | HistoryRequest | None
"""What may stand for a response history: systems or their names, a file, the document in one."""


def load_response_history(
    source: Source = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> HistoryRequest:
    """Return the response history that a source means, validated throughout.

    Arguments:
        source: path of a TOML file, a system or its name, a list of these, the document in a file
            as nested tables, a `HistoryRequest`, or None for the paper's dampers.
        changes: a document of the same form that overrides it entry by entry; `changes_from` names
            it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, HistoryRequest) and not changes:
        return source
    given: Any = USUAL if source is None else source
    if isinstance(given, Sequence) and not isinstance(given, str):
        given = {"systems": list(given)}
    request = FORM.read(given, changes, changes_from)
    systems, axes = _systems(request), request.axes("vary")
    with at(request.place("load")):
        load = Loading(**request.of(Loading))
    title = request.title("systems", "system", "set", "load", "vary", "start")
    return request.make(
        HistoryRequest,
        request.origin("load"),
        **request.of(HistoryRequest),
        title=title or _title(load, systems, axes),
        systems=systems,
        load=load,
        vary=axes,
    )


def _systems(request: Merged) -> tuple[System, ...]:
    """Return the systems with what is set; a parameter is set for those that have it."""
    listed = request.document.get("systems")
    if not listed or (request.is_changed("system") and not request.is_changed("systems")):
        systems = [request.system()]
    else:
        with at(request.origin("systems")):
            if not isinstance(listed, list | tuple):
                raise RequestError(f"systems = {shown(listed)} must be a list of systems")
            systems = [_system(one) for one in listed]
    for place, layer in request.layers:
        for name, value in layer.get("set", {}).items():
            if not any(_takes(system, name) for system in systems):
                with at(f"{place}: [set]"):
                    systems[0].with_(**{name: value})  # which says what is allowed
    varied = dict.fromkeys(request.table("vary"), "vary")
    return tuple(request.as_set(system, varied, _takes) for system in systems)


def _system(source: Any) -> System:
    if isinstance(source, str) and source.endswith(".toml"):
        return as_system(source)
    return load_system(source) if isinstance(source, str) else system_from(source)


def _takes(system: System, name: str) -> bool:
    return has(system, name) or (name in ("law", "law_2") and bool(system.scene.walls))


def _title(load: Loading, systems: Sequence[System], axes: Sequence[Axis]) -> str:
    """Return a title made of the load, the systems and what varies."""
    acts = "" if load == Loading() else load.words()
    varies = any(is_of_load(axis.name) for axis in axes)
    acts = acts[:1].upper() + acts[1:] if acts else "Blows" if varies else "Free decay"
    over = f", by {' and '.join(axis.name for axis in axes)}" if axes else ""
    return f"{acts}: {', '.join(map(system_in_words, systems))}{over}"[:MOST_CHARACTERS]
