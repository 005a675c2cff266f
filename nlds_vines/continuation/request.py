"""The request of a continuation: the free parameter, the start orbits, the limits of the search."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from nlds_vines.archives.provenance import CONTINUATION, Value
from nlds_vines.continuation.branch_panels import monitored_quantities
from nlds_vines.engine.solver_settings import TOLERANCES, tolerance_setting
from nlds_vines.errors import RequestError, at, checked_state, choice, number, shown, string, table
from nlds_vines.model.axis import Interval
from nlds_vines.model.labels import PERIODIC, TRANSIENT
from nlds_vines.model.parameters import symbol_of
from nlds_vines.model.ratios import meant_by, ratios_in
from nlds_vines.model.setting import (
    Checked,
    Document,
    Form,
    OneOf,
    Real,
    Request,
    Text,
    Whole,
    check_settings,
    checked_changes,
    entries,
    setting,
)
from nlds_vines.model.system import System

# The start orbits: that from rest, those of random starts, one of these with a label, or orbits of
# the request.
POLICIES = ("rest", "random", "label", "orbits")

STARTS = 100  # default number of random starts
PERIODS = Whole(1, 10**6)  # check of the number of forcing periods of a start orbit
MOST_ORBITS = 10_000  # in a request
FUNCTION = "function"  # in a file, the value of a monitor that is a function of Python


@dataclass(frozen=True)
class Orbit:
    """A start orbit: a state in the user's coordinates, the parameter's value, n of nT."""

    state: tuple[float, ...]
    value: float
    period: int


@dataclass(frozen=True)
class Begin:
    """The start orbits of branches, validated; `states`, `values`, `periods` of policy "orbits"."""

    policy: str = setting(
        "rest", OneOf(POLICIES), "start", "`rest`, `random`, `label` or `orbits`",
        replaces=("label", "states", "values", "periods"),
    )  # fmt: skip
    label: str = setting(
        "", Text(), "start", "for `label`: the regime to begin with",
        replaces=("policy", "states", "values", "periods"),
    )  # fmt: skip
    count: int = setting(STARTS, Whole(1, 10**6), "start", "random starts", "N", option="--starts")
    seed: int = setting(0, Whole(0, 2**63 - 1), "start", "that random starts are drawn by", "N")
    states: tuple[tuple[float, ...], ...] = setting(
        (), Checked(lambda value: tuple(map(checked_state, _listed("states", value)))), "start",
        "for `orbits`: a state of each", replaces=("policy", "label", "values", "periods"),
    )  # fmt: skip
    values: tuple[float, ...] = setting(
        (), Checked(lambda value: tuple(number("value", v) for v in _listed("values", value))),
        "start", "for `orbits`: the value of the parameter",
    )  # fmt: skip
    periods: tuple[int, ...] = setting(
        (), Checked(lambda value: tuple(PERIODS("period", n) for n in _listed("periods", value))),
        "start", "for `orbits`: n of each",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
        if (self.policy == "label") != bool(self.label):
            raise RequestError("label belongs to policy 'label': give both or neither")
        if self.label and not PERIODIC.fullmatch(self.label.removeprefix(TRANSIENT)):
            raise RequestError(
                f"start {shown(self.label)} must be rest, random, an archive FILE.h5 or the label "
                "of a periodic orbit, such as 3T,3"
            )
        if len({len(self.states), len(self.values), len(self.periods)}) != 1:
            raise RequestError("states, values and periods must be as many")
        if (self.policy == "orbits") != bool(self.states):
            raise RequestError("orbits belong to policy 'orbits': give both or neither")
        if len(self.states) > MOST_ORBITS:
            raise RequestError(f"{len(self.states)} start orbits; allowed: up to {MOST_ORBITS}")

    @property
    def orbits(self) -> tuple[Orbit, ...]:
        return tuple(map(Orbit, self.states, self.values, self.periods))


@dataclass(frozen=True)
class Monitored:
    """A quantity and the values at which it is located; without values, a function of Python."""

    name: str
    values: tuple[float, ...] = ()

    @property
    def is_function(self) -> bool:
        return not self.values

    @property
    def dataset(self) -> str:  # of a function
        return f"monitor_{self.name}"

    @property
    def entry(self) -> Any:
        """Its value in the table [monitors]."""
        if self.is_function:
            return FUNCTION
        return self.values[0] if len(self.values) == 1 else list(self.values)

    @classmethod
    def of(cls, name: str, entry: object, quantities: Collection[str]) -> Monitored:
        """Return the monitor of an entry of [monitors]: a number, a list of numbers, "function"."""
        if entry == FUNCTION:
            if not name.isidentifier() or name in quantities:
                raise RequestError(
                    f"{name} is no name for a function: it must be an identifier, and no quantity"
                )
            return cls(name)
        choice("quantity", name, quantities)
        values = entry if isinstance(entry, list | tuple) else [entry]
        numbers = tuple(number(name, value) for value in values)
        if not numbers or len({*numbers}) < len(numbers):
            raise RequestError(f"{name} = {shown(entry)} must be different numbers")
        return cls(name, numbers)


def _listed(key: str, value: object) -> list[Any] | tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise RequestError(f"{key} = {shown(value)} must be a list")
    return value


@dataclass(frozen=True, repr=False)
class Continuation(Request):
    """The request of a continuation, validated and immutable; `load_continuation` makes it.

    Attributes
    ----------
    title : str
        One line.
    system : System
        The parameters that are not free.
    along : Interval
        The free parameter with its interval.
    begin : Begin
        The start orbits.
    doublings, step, unstable, points, tori, tolerance
        Limits of the search, as in `continue_branch`.
    plane : Interval, optional
        A second free parameter, for curves of special points.
    monitors : tuple of Monitored
        The quantities with the values at which they are located.
    functions : mapping of str to callable
        The monitors that are functions of Python, by name; a file holds their names alone.

    Raises
    ------
    RequestError
        If a value is wrong, or not allowed for the system.
    """

    content: ClassVar[str] = CONTINUATION

    title: str
    system: System
    along: Interval
    begin: Begin = field(default_factory=Begin)
    doublings: int = setting(
        0, Whole(0, 10), "search", "period doublings, one after another, that are followed", "N"
    )
    step: float = setting(
        0.02, Real(1e-6, 1.0), "search",
        "the longest along a branch, relative to the orbit and the interval together", "LENGTH",
    )  # fmt: skip
    unstable: int = setting(
        3000, Whole(1, 10**5), "search", "ends a branch: unstable points, one after another", "N"
    )
    points: int | None = setting(
        None, Whole(2, 10**6), "search", "the most of a branch or a curve in one direction", "N",
        usual="3000 of a branch, 400 of a curve",
    )  # fmt: skip
    tori: int = setting(
        0, Whole(0, 10_000), "search",
        "cells of a scan beside each NS that follows its torus", "N",
    )  # fmt: skip
    tolerance: float | str = tolerance_setting("search", TOLERANCES["fine"])
    plane: Interval | None = None
    monitors: tuple[Monitored, ...] = ()
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        string("title", self.title)
        check_settings(self)
        system = self.system.with_axes([item.name for item in self.free])
        object.__setattr__(self, "system", system)
        for item in self.free:
            if item.name not in self.system.scene.allowed:
                raise RequestError(
                    f"{item.name} is no parameter of kind {self.system.kind!r}: "
                    f"{', '.join(self.system.scene.allowed)}"
                )
            for value in (item.low, item.high):
                self.system.with_(**{item.name: value})
        if self.plane is not None and self.plane.name == self.along.name:
            raise RequestError(f"{self.plane.name} is free already: the second must be another")
        if self.plane is not None:
            second = self.own(self.plane.name)
            if second is None or not self.plane.low <= second <= self.plane.high:
                raise RequestError(
                    f"{self.plane.name} from {self.plane.low!r} to {self.plane.high!r} must hold "
                    f"the system's own value, {second!r}: curves begin there"
                )
        size = len(self.system.scene.components)
        for orbit in self.begin.orbits:
            if len(orbit.state) != size:
                names = ", ".join(self.system.scene.components)
                raise RequestError(f"state = {list(orbit.state)}; allowed: {size} numbers {names}")
            if not self.along.low <= orbit.value <= self.along.high:
                raise RequestError(
                    f"a start orbit at {self.along.name} = {orbit.value!r}, outside "
                    f"{self.along.low!r} to {self.along.high!r}"
                )

    @property
    def free(self) -> tuple[Interval, ...]:
        """The free parameters: one, or two."""
        return (self.along,) if self.plane is None else (self.along, self.plane)

    @property
    def value(self) -> float:
        """The value of the parameter at which start orbits are searched for."""
        own = self.own(self.along.name)
        return self.along.low if own is None else self.along.nearest(own)

    def own(self, name: str) -> float | None:
        """Return the system's own value of a parameter, if it has one; that of gap+ may be gap."""
        values = self.system.parameters
        return values.get(name, values.get(name.rstrip("+-")))

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of the archive beside the request itself."""
        varied = [item.name for item in self.free]
        return {**self.system.attributes(varied), "along": self.along.name}

    def document(self) -> dict[str, Any]:
        """Return the complete request as nested tables of a TOML file."""
        begin: dict[str, Any] = {"policy": self.begin.policy}
        if self.begin.policy in ("random", "label"):
            begin |= {"count": self.begin.count, "seed": self.begin.seed}
        if self.begin.label:
            begin["label"] = self.begin.label
        if self.begin.orbits:
            begin["states"] = [list(state) for state in self.begin.states]
            begin |= {"values": list(self.begin.values), "periods": list(self.begin.periods)}
        return {
            "title": self.title,
            "system": self.system.to_table(),
            "along": self.along.entry(),
            "start": begin,
            "search": entries(self, "search"),
            **({} if self.plane is None else {"plane": self.plane.entry()}),
            **({"monitors": self._monitor_entries} if self.monitors else {}),
        }

    @property
    def _monitor_entries(self) -> dict[str, Any]:
        return {one.name: one.entry for one in self.monitors}


FORM = Form("continuation", (Begin, Continuation), whole=("along", "plane", "monitors"))
DEFAULT_SYSTEM, DEFAULT_ALONG = "ssul-set6", Interval("omega", 5.0, 9.0)


def load_continuation(
    source: str | os.PathLike[str] | Document | System | Continuation | None = None,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> Continuation:
    """Return the request of a continuation from a file or a system, validated.

    Parameters
    ----------
    source : path-like, str, dict, System or Continuation, optional
        Path of a TOML file (ending in `.toml`), name of the catalog, nested tables, a system, or a
        request; by default SSul Set 6.
    changes : dict, optional
        Nested tables of the same form that override it entry by entry.
    changes_from : str
        Name of the changes in messages of errors.

    Returns
    -------
    Continuation
        The request.

    Raises
    ------
    RequestError
        One line with place, key, value and what is allowed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> request = nv.load_continuation("tmd", {"along": {"omega": {"start": 6, "stop": 7}}})
    >>> request.along.low, request.begin.policy
    (6.0, 'rest')
    """
    changes = checked_changes(changes, changes_from)
    if isinstance(source, Continuation) and not changes:
        return source
    request = FORM.read(DEFAULT_SYSTEM if source is None else source, changes, changes_from)
    system: Any = request.as_set(request.any_system(DEFAULT_SYSTEM))
    names = meant_by(system.scene, [n for key in ("along", "plane") for n in request.table(key)])
    free, intervals = [*names, *system.following(names)], dict[str, Interval]()
    for key in ("along", "plane"):
        if table_of_one := request.table(key):
            with at(request.place(key)):
                intervals[key] = interval_in(table_of_one, system, free)
                if key == "plane" and intervals[key].falls:  # its curves have no direction
                    raise RequestError(f"{intervals[key].heading()}: the first must be the lesser")
    along = intervals.get("along", DEFAULT_ALONG)
    title = request.title("system", "set", "along", "plane")
    if title is None:
        varied = [item.name for item in (along, *intervals.values())]
        bare = system.with_axes(dict.fromkeys(varied))  # without a force, if the ground's varies
        words = [bare.in_words(), *request.set_in_words(bare, varied)]
        title = f"{', '.join(words)}: branches along {symbol_of((along.stated or along).name)}"
    monitors = []
    with at(request.place("monitors")):
        for name, entry in request.table("monitors").items():
            monitors.append(Monitored.of(name, entry, monitored_quantities(system.scene)))
    # a label, or orbits, without a policy imply it
    start = request.of(Begin)
    policy = "orbits" if start.get("states") else "label" if start.get("label") else "rest"
    with at(request.place("start")):
        begin = Begin(**{"policy": policy} | start)
    return request.make(
        Continuation,
        request.origin("along"),
        **request.of(Continuation),
        title=title,
        system=system,
        along=along,
        begin=begin,
        plane=intervals.get("plane"),
        monitors=tuple(monitors),
    )


def interval_in(entries: Document, system: System, free: Collection[str] = ()) -> Interval:
    """Return the interval of a table of one parameter, or of a ratio in its place, such as f [Hz].

    If start > stop, the branches run from start to stop.

    Raises `RequestError` for a wrong table, and if the unit of a ratio depends on a `free` one.
    """
    if len(entries) != 1:
        raise RequestError(f"{', '.join(entries)} given; allowed: one parameter")
    ((name, entry),) = entries.items()
    bounds = table(name, entry, ("start", "stop"))
    if bounds.keys() != {"start", "stop"}:
        raise RequestError(f"{name} = {shown(dict(bounds))} must hold start and stop")
    start, stop = (number(f"{end} of {name}", bounds[end]) for end in ("start", "stop"))
    if start == stop:
        raise RequestError(f"{name} from {start!r} to {stop!r}: the ends must differ")
    stated = Interval(name, min(start, stop), max(start, stop), falls=start > stop)
    ratio = ratios_in(system.scene).get(name)
    if ratio is None:
        return stated
    both = next((need for need in ratio.needs if need in free), None)
    if both is not None:
        raise RequestError(f"{name} follows from {both}, which is free, too: give {ratio.gives}")
    first, last = (float(ratio.parameter(value, system.parameters)) for value in (start, stop))
    low, high = min(first, last), max(first, last)
    if ratio.needs:  # what else is set decides how the ratio and the parameter go together
        return Interval(ratio.gives, low, high, falls=first > last)
    return Interval(ratio.gives, low, high, stated, falls=first > last)
