"""The request of response histories: systems, a load, a duration, axes of a scan."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise, product
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import RESPONSE_HISTORY, Value
from nlds_vines.engine.solver_settings import tolerance_setting
from nlds_vines.engine.starts import starts_inside
from nlds_vines.errors import (
    MOST_CHARACTERS,
    RequestError,
    at,
    checked_names,
    choice,
    from_text,
    number,
    shown,
    string,
)
from nlds_vines.loads.scaling import scaled
from nlds_vines.model.axis import SAMPLE, Axis, Samples
from nlds_vines.model.catalog import any_system, any_system_from, told_apart
from nlds_vines.model.loads.loading import ALL, NUMBERS, OPTIONS, Loading, of_load
from nlds_vines.model.parameters import DESCRIBED, LAWS, flat
from nlds_vines.model.setting import (
    Checked,
    Form,
    Merged,
    Real,
    Request,
    Whole,
    check_settings,
    checked_changes,
    entries,
    is_given,
    setting,
)
from nlds_vines.model.system import System

TOLERANCE = 1e-10  # of contacts by default: finer than in scans, as the energy balance sees each
MOST_STATES = 10**7
MOST_CASES = 10**7
ROUND_OFF = 1e-12  # relative change of loads and start that a predictable history does not show
LOAD = "load"  # the dimension of the records of a suite
_LAWS = ("law", "law_2")  # keys of [set] that are no parameters


def _state(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple | np.ndarray):
        raise RequestError(f"state = {shown(value)} must be a list of numbers")
    numbers = (from_text(float, "state", one) if isinstance(one, str) else one for one in value)
    return tuple(number("state", one) for one in numbers)


ALONE, TUNED_MASS = "alone", "tmd"  # systems that may stand beside each design


def _beside(value: object) -> tuple[str, ...]:
    names = checked_names("beside", value)
    for name in names:
        choice("beside", name, (ALONE, TUNED_MASS))
    return names


@dataclass(frozen=True)
class Beside:
    """The systems that are computed beside those of a request, which then has them all."""

    beside: tuple[str, ...] = setting(
        (), Checked(_beside, listed=True), "record",
        "what is compared with each system that has dampers: `alone`, its structure without them; "
        "`tmd`, its structure with a tuned mass damper of the same mass", "NAME,...",
        usual="a single host: alone",
    )  # fmt: skip

    def of(self, systems: tuple[System, ...], load: Loading) -> tuple[System, ...]:
        """Return the systems with those beside them: structures first, then tuned masses."""
        designs = [system for system in systems if system.damper_names]
        structures: list[System] = []
        masses: list[System] = []
        for system in designs if ALONE in self.beside else ():
            structures.append(_named(system.alone(), "none", [*systems, *structures]))
        for system in designs if TUNED_MASS in self.beside else ():
            tuned = system.with_tuned_mass(load.shaken)
            masses.append(_named(tuned, TUNED_MASS, [*systems, *masses]))
        return (*_different(structures, systems), *_different(masses, systems), *systems)


def _named(system: Any, name: str, others: Sequence[System]) -> System:
    """Return a system by a name that no other one has, or the other one if it is the same."""
    for other in others:
        if _content(other) == _content(system):
            return other
    taken = [other.name for other in others]
    number = 1
    unique = name
    while unique in taken:
        number += 1
        unique = f"{name} {number}"
    renamed: System = replace(system, name=unique)
    return renamed


def _content(system: System) -> Any:
    """Return what a system is apart from its name and its texts."""
    texts = ("name", "title", "sources", "assumptions")
    return {key: value for key, value in system.to_table().items() if key not in texts}


def _different(systems: Sequence[System], others: Sequence[System]) -> list[System]:
    """Return systems once each, without those among the others."""
    different: list[System] = []
    for system in systems:
        if not any(system is one for one in (*others, *different)):
            different.append(system)
    return different


def _heights(value: object) -> float | tuple[float, ...] | Mapping[str, float]:
    """Return heights of storeys [m]: one for all, one for each from below, or by displacement."""
    if isinstance(value, Mapping):
        return {string("heights", key): _height(one) for key, one in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        if isinstance(value, list) and not value:
            raise RequestError("heights = [] must have a height for each storey")
        heights = tuple(_height(one) for one in value)
        return heights[0] if len(heights) == 1 else heights
    return _height(value)


def _height(value: object) -> float:
    height = from_text(float, "heights", value) if isinstance(value, str) else value
    return Real(0.0, 1e6, inside=True)("heights", height)


@dataclass(frozen=True, repr=False)
class HistoryRequest(Request):
    """A load on one or several systems, for a duration; validated when it is made.

    Parameters
    ----------
    title : str
        One line.
    systems : tuple of System
        Structures with their dampers, of the paper's kinds and general ones.
    load : Loading
        The loads; the harmonic force acts only if `load.harmonic`.  With `load.suite` there are
        orbits under each of its records.
    vary : tuple of Axis, optional
        Up to two parameters, or numbers of the load (`impulse`, `scale`, `friedlander.peak`), with
        their values: a scan, which has no histories; with `sampled` the numbers of samples.
    state : tuple of float, optional
        The state x1, v1, x2, v2 at t = 0 [m, m/s], before any impulse; by default at rest.
    duration : float, optional
        Length of the histories [s].
    samples : int, optional
        States in each natural period of the structure.
    of : tuple of str, optional
        Displacements whose response is reported of the systems that have them, as `simulate` takes
        them.
    heights : float, sequence of float or mapping of str to float, optional
        Heights of the storeys [m]: one for all, one for each degree of freedom of the first host
        from below, or by displacement such as "roof-floor2".  Then drift ratios are reported.
    settle : float, optional
        Time [s] that the rms of x1 leaves out.
    tolerance : float or str, optional
        Tolerance of contacts, as in `simulate`.
    sampled : Samples, optional
        A table of parameters and numbers of the load, one set a row, in place of `vary`.

    Raises
    ------
    RequestError
        If a value is out of range or contradicts another.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> request = nv.load_response_history("tmd", {"load": {"impulse": 300.0}})
    >>> request.duration, request.load.words()
    (60.0, 'a blow of 300 N s')
    """

    content: ClassVar[str] = RESPONSE_HISTORY

    title: str
    systems: tuple[Any, ...]
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
    of: tuple[str, ...] = setting(
        (), Checked(partial(checked_names, "of"), listed=True), "record",
        "displacements of a host whose response is reported: a degree of freedom `roof`, a "
        "damper's mass `cell`, a difference `roof-floor2`", "ROW,...", usual="where dampers hang",
    )  # fmt: skip
    heights: Any = setting(
        (), Checked(_heights, listed=True), "record",
        "heights of a host's storeys [m], for drift ratios: one for all, one for each degree of "
        "freedom from below, or a table by displacement, `{ floor1 = 4.0, \"roof-floor1\" = 3.5 }`",
        "M,M,...", usual="no drift ratios",
    )  # fmt: skip
    settle: float = setting(
        0.0, Real(0.0, 1e9), "sampling", "time that the rms of x1 leaves out [s]", "SECONDS",
    )  # fmt: skip
    tolerance: float | str = tolerance_setting("sampling", TOLERANCE)
    sampled: Samples | None = None

    def __post_init__(self) -> None:
        string("title", self.title)
        if self.sampled is not None:
            rows = np.arange(1.0, self.sampled.count + 1.0)
            object.__setattr__(self, "vary", (Axis(SAMPLE, rows),))
        check_settings(self)
        object.__setattr__(self, "load", scaled(self.load))
        if not self.systems:
            raise RequestError("no system is named; allowed: one or more systems")
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
        # axes that a system or the load has, and not too many orbits
        if len(self.vary) > 2:
            raise RequestError(f"{len(self.vary)} parameters vary; allowed: one or two")
        if self.cases > MOST_CASES:
            raise RequestError(f"{self.cases} systems and loads; allowed: up to {MOST_CASES}")
        columns = self.columns
        parameters = [name for name in columns if not is_of_load(name)]
        for name in parameters:
            if not any(system.takes(name) for system in self.systems):
                self.systems[0].with_(**{name: 1.0})  # raises the error that lists the names
        for system in self.systems:
            system.refuse_under(self.load, parameters, settle=self.settle)
            if self.sampled is not None:
                system.cells({k: v for k, v in columns.items() if system.takes(k)})
        object.__setattr__(self, "heights", self._storeys())
        for name in (*self.of, *self.heights):
            self._check_displacement(name)
        for name, values in columns.items():
            if is_of_load(name):
                self.load.check_values(name, values)
        # what acts at the corners of the grid acts inside
        shape = (len(self.systems), *self.shape)
        records = [range(len(self.load.suite))] if self.load.suite else []
        ends_of_axes = ((0, axis.values.size - 1) for axis in self.vary)
        ends = product(range(len(self.systems)), *records, *ends_of_axes)
        corners = [self.case(int(np.ravel_multi_index(place, shape))) for place in ends]
        if not all(load.acts for _, load in corners) and not self.state:
            kinds = ", ".join((*NUMBERS, "harmonic", *ALL))
            raise RequestError(f"[load] is empty and no start is given; allowed: {kinds}")
        for system, load in corners:
            load.check(self.duration, system.natural_period)
        if self.state:
            self._check_state()

    def _storeys(self) -> Any:
        """Return the heights [m] by the displacement that is the drift of each storey, or ()."""
        stated = self.heights
        if isinstance(stated, Mapping) or stated == ():
            return stated or ()
        hosts = [one for one in self.systems if one.displacements()]
        if not hosts:
            raise RequestError("heights: no system has storeys; allowed: beside a host")
        dofs = hosts[0].chain or hosts[0].displacements()
        above = [f"{upper}-{lower}" for lower, upper in pairwise(dofs)]
        names = [dofs[0], *above]
        heights = stated if isinstance(stated, tuple) else (stated,) * len(names)
        if len(heights) != len(names):
            raise RequestError(f"{len(heights)} heights for {len(names)} degrees of freedom")
        return dict(zip(names, heights, strict=True))

    def _check_displacement(self, name: str) -> None:
        """Refuse a displacement that no system has."""
        refusal: RequestError | None = None
        for system in self.systems:
            try:
                system.displacements([name])
                return
            except RequestError as error:
                if refusal is None or system.displacements():
                    refusal = error
        assert refusal is not None
        raise refusal

    def _check_state(self) -> None:
        """Refuse a state that is not that of the largest system.

        The state of a structure without dampers begins that of one with them.
        """
        each = [system.scene.components for system in self.systems]
        largest = max(each, key=len)
        for system, components in zip(self.systems, each, strict=True):
            if len(self.state) != len(largest) or components != largest[: len(components)]:
                raise RequestError(
                    f"state = {list(self.state)} of {system.name} must be {', '.join(components)}"
                )

    @property
    def words(self) -> tuple[str, ...]:
        """The words for each system in reports and pictures, all different."""
        return told_apart(self.systems)

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """The values of all that varies by name: those of each axis, or the columns of samples."""
        if self.sampled is not None:
            return self.sampled.columns
        return {axis.name: axis.values for axis in self.vary}

    def values_at(self, places: Sequence[Any]) -> dict[str, Any]:
        """Return the values of varied parameters, by name, at a place on each dimension.

        The dimensions are those of `shape`; of a suite there is the number of the record, `load`.
        """
        found: dict[str, Any] = {}
        if self.load.suite:
            found[LOAD] = places[0]
            places = places[1:]
        if self.sampled is not None:
            places = [places[0]] * len(self.columns)
        for (name, values), place in zip(self.columns.items(), places, strict=True):
            found[name] = values[place]
        return found

    @property
    def is_scan(self) -> bool:
        """Whether there are several orbits of each system, and so no histories."""
        return bool(self.vary or self.load.suite)

    def moved(self) -> HistoryRequest:
        """Return the request with all loads and the start larger by `ROUND_OFF` of themselves."""
        factor = 1.0 + ROUND_OFF
        load = self.load.with_({"scale": self.load.scale * factor})
        state = tuple(one * factor for one in self.state)
        return replace(self, load=load, state=state)

    def with_record(self, place: int) -> HistoryRequest:
        """Return the request of one record of the suite alone, by its place."""
        return replace(self, load=self.load.member(place))

    def starts_inside(self) -> list[str]:
        """Return a line for each system that starts inside a wall."""
        lines = []
        for system in self.systems:
            places = {k: v for k, v in self.columns.items() if system.takes(k)}
            if self.sampled is None:
                grid = np.meshgrid(*places.values(), indexing="ij", sparse=True)
                places = dict(zip(places, grid, strict=True))
            state = dict(zip(system.scene.components, self.state, strict=False))
            shape = np.broadcast_shapes(*(values.shape for values in places.values()))
            inside = starts_inside(system, places, state, shape)
            lines += [f"{system.name}: {line}" for line in inside]
        return lines

    def case(self, number: int) -> tuple[Any, Loading]:
        """Return the system and the load of an orbit, by its number: systems, then axes."""
        which, *places = np.unravel_index(number, (len(self.systems), *self.shape))
        values = {k: float(v) for k, v in self.values_at(places).items()}
        system, load = self.systems[which], self.load
        if self.load.suite:
            load = load.member(int(values.pop(LOAD)))
        of_system = {name: value for name, value in values.items() if system.takes(name)}
        of_load = {name: value for name, value in values.items() if is_of_load(name)}
        return system.with_(**of_system) if of_system else system, load.with_(of_load)

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions of results after `system`: `load` of a suite, then the axes."""
        axes = tuple(axis.name for axis in self.vary)
        return (LOAD, *axes) if self.load.suite else axes

    @property
    def shape(self) -> tuple[int, ...]:
        """The size of each dimension after `system`."""
        sizes = tuple(axis.values.size for axis in self.vary)
        return (len(self.load.suite), *sizes) if self.load.suite else sizes

    @property
    def cases(self) -> int:
        """The number of orbits."""
        return len(self.systems) * math.prod(self.shape)

    @property
    def windows(self) -> int:
        """The number of natural periods of the first structure in the duration, at least 1."""
        period = self.systems[0].natural_period
        return max(1, round(self.duration / period)) if math.isfinite(period) else 1

    @cached_property
    def times(self) -> np.ndarray:
        """The times of a history [s], of a record those where kernels stop anyway."""
        if self.load.record and any(one.scene.has_times_of_records for one in self.systems):
            # a record's samples are edges of cells, and with other times there were twice as many
            times, longest = (
                self.load.record[0].times,
                self.duration / (self.windows * self.samples),
            )
            step = (times[-1] - times[0]) / (len(times) - 1)
            step *= math.floor(longest / step) or 1.0 / math.ceil(step / longest)
            return np.append(np.arange(0.0, self.duration * (1.0 - 1e-9), step), self.duration)
        return np.linspace(0.0, self.duration, self.windows * self.samples + 1)

    @property
    def about(self) -> dict[str, Value]:
        """Further attributes of its archive."""
        about = {"content": self.content, "load": self.load.words()}
        return {**about, "duration": self.duration}

    def document(self) -> dict[str, Any]:
        """Return the complete request file as nested tables."""
        document = {
            "title": self.title,
            "systems": [system.to_table() for system in self.systems],
            "vary": {axis.name: {"values": axis.values.tolist()} for axis in self.vary},
            "samples": {},
            "load": self.load.to_table(),
            "start": entries(self, "start"),
            "record": entries(self, "record"),
            "sampling": entries(self, "sampling"),
        }
        if self.sampled is not None:
            document |= {"vary": {}, "samples": self.sampled.document()}
        return {key: value for key, value in document.items() if value}


def refuse_load_in_set(request: Merged) -> None:
    for place, layer in request.layers:
        for name in layer.get("set", {}):
            if name in OPTIONS or name.partition(".")[0] in ALL:
                with at(f"{place}: [set]"):
                    raise of_load(name)


def load_table(load: Any) -> Any:
    """Return the table of a load that is given as a path, a folder, or a list of these.

    Several records, and those of a folder, are a suite; a table is returned as it is.
    """
    if isinstance(load, str | os.PathLike):
        path = os.fspath(load)
        return {"suite": [path]} if os.path.isdir(path) else {"record": path}
    if isinstance(load, list | tuple):
        return {"suite": [os.fspath(one) if isinstance(one, os.PathLike) else one for one in load]}
    return load


def is_of_load(name: str) -> bool:
    return name in NUMBERS or (name.partition(".")[0] in ALL and name not in DESCRIBED)


def axis_words(request: HistoryRequest, name: str) -> tuple[str, str]:
    if name in DESCRIBED:
        return DESCRIBED[name].unit, DESCRIBED[name].meaning
    return request.load.words_of_number(name)


FORM = Form(
    "response history",
    (HistoryRequest, Loading, Beside),
    whole=("vary", "samples"),
    lists=("systems",),
    nested=(*ALL, "load"),
    sources="a path, a name, a System, a list of these, a table or a HistoryRequest",
)

USUAL = ("none", "tmd", "ssbl", "ssul-set6")  # the structure alone and with the paper's dampers
Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | HistoryRequest | None


def load_response_history(
    source: Source = None, changes: Mapping[str, Any] | None = None, changes_from: str = "changes"
) -> HistoryRequest:
    """Return the validated request of response histories.

    Parameters
    ----------
    source : optional
        Path of a TOML file, a system or its name, a list of these, the document in a file as
        nested tables, a `HistoryRequest`, or None for the paper's structure alone and with its
        dampers.
    changes : mapping, optional
        A document of the same form that overrides `source` entry by entry.
    changes_from : str, optional
        Name of `changes` in messages.

    Returns
    -------
    HistoryRequest
        The request, as `response_history` takes it.

    Raises
    ------
    RequestError
        One line that names place, key, value and allowed values.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> request = nv.load_response_history(["none", "tmd"], {"load": {"impulse": 300.0}})
    >>> [system.name for system in request.systems]
    ['none', 'tmd']
    """
    changes = checked_changes(changes, changes_from)
    if isinstance(source, HistoryRequest) and not changes:
        return source
    form: Any = USUAL if source is None else source
    if isinstance(form, Sequence) and not isinstance(form, str):
        form = {"systems": list(form)}
    request = FORM.read(form, changes, changes_from)
    sampled = request.samples()
    refuse_load_in_set(request)
    systems = _systems(request, sampled)
    axes, one = request.axes("vary") if sampled is None else (), systems[0]
    with at(request.place("load")):
        load = scaled(Loading(**request.of(Loading)))
    beside = Beside(**request.of(Beside))
    if beside.beside:
        with at(request.place("record", "beside")):
            systems = beside.of(systems, load)
    elif len(systems) == 1 and one.owning_dampers and not (axes or sampled):
        systems = Beside((ALONE,)).of(systems, load)
    title = request.title("systems", "system", "set", "load", "vary", "samples", "start")
    if not title:
        names = [axis.name for axis in axes] if sampled is None else [*sampled.names]
        over = f", by {' and '.join(names)}" if names else ""
        if sampled is not None:
            over = f", {sampled.count} samples of {', '.join(names)}"
        words = "Blows" if any(map(is_of_load, names)) else "Free decay"
        if load != Loading():
            words = load.words()
        names_of_systems = ", ".join(told_apart(systems))
        title = f"{words[0].upper()}{words[1:]}: {names_of_systems}{over}"[:MOST_CHARACTERS]
    return request.make(
        HistoryRequest, request.origin("load"), **request.of(HistoryRequest), title=title,
        systems=systems, load=load, vary=axes, sampled=sampled,
    )  # fmt: skip


def _systems(request: Merged, sampled: Samples | None) -> tuple[System, ...]:
    """Return the systems; `[set]` changes those that have the parameter."""
    listed = request.document.get("systems")
    if not is_given(listed) or (request.is_changed("system") and not request.is_changed("systems")):
        systems = [request.any_system(needs_force=False)]
    else:
        with at(request.origin("systems")):
            if not isinstance(listed, list | tuple):
                raise RequestError(f"systems = {shown(listed)} must be a list of systems")
            systems = [
                (any_system if isinstance(one, str) else any_system_from)(one, needs_force=False)
                for one in listed
            ]
    settings = [flat(layer.get("set", {})) for _, layer in request.layers]
    named = {key: str(one[key]) for one in settings for key in _LAWS if key in one}
    laws = {key: LAWS[law] for key, law in named.items() if law in LAWS}

    def takes(system: System, name: str) -> bool:
        return system.can_set(name, laws)

    for place, layer in request.layers:
        for name, value in flat(layer.get("set", {})).items():
            if not any(takes(system, name) for system in systems):
                with at(f"{place}: [set]"):
                    systems[0].with_(**{name: value})  # raises the error that lists the names
    varied = dict.fromkeys(request.table("vary"), "vary")
    if sampled is not None:
        varied = dict.fromkeys(sampled.names, "samples")
    return tuple(request.as_set(system, varied, takes) for system in systems)
