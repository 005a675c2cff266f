"""A continuation: which parameter is free, where branches begin, which others are followed.

`load_continuation` reads one from TOML and checks it once; what comes out is sound.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.archives.outline import Outlined
from nlds_vines.archives.provenance import Value
from nlds_vines.errors import RequestError, choice, number, shown, string, typed, whole
from nlds_vines.model.layers import request_hash
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.system import System
from nlds_vines.orbits.labels import PERIODIC, TRANSIENT
from nlds_vines.orbits.settings import TOLERANCES, checked_tolerance
from nlds_vines.toml import toml_text

POLICIES = ("rest", "random", "label", "orbits")
"""Where branches may begin: the orbit from rest; the orbits of random starts; one of these with a
label; given orbits."""

STARTS = 100
"""Random starts, by default."""

MOST_ORBITS = 10_000
"""Start orbits that may be given."""

SEARCH: Mapping[str, Callable[[object], Any]] = {
    "doublings": lambda value: whole("doublings", value, 0, 10),
    "step": lambda value: _step(value),
    "unstable": lambda value: whole("unstable", value, 1, 10**5),
    "tolerance": checked_tolerance,
}
"""The checks of the table [search] of a continuation file, by key."""


def _step(value: object) -> float:
    found = number("step", value)
    if 1e-6 <= found <= 1.0:
        return found
    raise RequestError(f"step = {found!r}; allowed: 1e-6 to 1")


@dataclass(frozen=True)
class Interval:
    """A parameter and the interval in which it is free; `RequestError` unless low < high."""

    name: str
    low: float
    high: float

    def __post_init__(self) -> None:
        """Check everything; integers become floats."""
        choice("parameter", self.name, PARAMETERS)
        for end in ("low", "high"):
            value = number(f"{end} of {self.name}", getattr(self, end))
            PARAMETERS[self.name].check(np.asarray(value))
            object.__setattr__(self, end, value)
        if not self.low < self.high:
            raise RequestError(
                f"{self.name} from {self.low!r} to {self.high!r}: the first must be the lesser"
            )

    def nearest(self, value: float) -> float:
        """Return a value if it lies in the interval, otherwise the nearest end."""
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Orbit:
    """A start orbit: a state of it in the user's coordinates, the parameter, its periods n."""

    state: tuple[float, ...]
    value: float
    period: int


@dataclass(frozen=True)
class Begin:
    """Where branches begin; checked when made.

    Arguments:
        policy: of `POLICIES`.
        label: of the orbit that is looked for among random starts, "3T,3".
        count, seed: of random starts.
        orbits: given ones.
    """

    policy: str = "rest"
    label: str = ""
    count: int = STARTS
    seed: int = 0
    orbits: tuple[Orbit, ...] = ()

    def __post_init__(self) -> None:
        """Check everything."""
        choice("policy", self.policy, POLICIES)
        string("label", self.label)
        whole("count", self.count, 1, 10**6)
        whole("seed", self.seed, 0, 2**63 - 1)
        if (self.policy == "label") != bool(self.label):
            raise RequestError("label belongs to policy 'label': give both or neither")
        if self.label and not PERIODIC.fullmatch(self.label.removeprefix(TRANSIENT)):
            raise RequestError(
                f"start {shown(self.label)} must be rest, random, an archive FILE.h5 or the label "
                "of a periodic orbit, such as 3T,3"
            )
        if (self.policy == "orbits") != bool(self.orbits):
            raise RequestError("orbits belong to policy 'orbits': give both or neither")
        if len(self.orbits) > MOST_ORBITS:
            raise RequestError(f"{len(self.orbits)} start orbits; allowed: up to {MOST_ORBITS}")


@typed
@dataclass(frozen=True, repr=False)
class Continuation(Outlined):
    """What to follow; checked when made, immutable afterwards.

    Arguments:
        title: one line for people.
        system: the parameters that are not free.
        along: the free parameter and its interval.
        begin: where branches begin.
        doublings: how many period doublings, one after another, are followed to their branches.
        step: the longest step, relative to the orbit and the interval together.
        unstable: the most points, one after another, that are followed where orbits are unstable.
        tolerance: of method exact: a number or one of `TOLERANCES`.
        plane: a second free parameter, for curves of special points; None for none.

    Raises `RequestError` for anything else, and for a value that the system refuses.
    """

    title: str
    system: System
    along: Interval
    begin: Begin = field(default_factory=Begin)
    doublings: int = 0
    step: float = 0.02
    unstable: int = 3000
    tolerance: float | str = TOLERANCES["fine"]
    plane: Interval | None = None

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        for name, check in SEARCH.items():
            object.__setattr__(self, name, check(getattr(self, name)))
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
            own = self.system.parameters.get(self.plane.name)
            if own is None or not self.plane.low <= own <= self.plane.high:
                raise RequestError(
                    f"{self.plane.name} from {self.plane.low!r} to {self.plane.high!r} must hold "
                    f"the system's own value, {own!r}: curves begin there"
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
        """The value of the parameter at which start orbits are looked for."""
        return self.along.nearest(self.system.parameters.get(self.along.name, self.along.low))

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself."""
        return {**self.system.attributes, "along": self.along.name}

    def document(self) -> dict[str, Any]:
        """Return the file that means exactly this continuation, complete, as nested tables."""
        begin: dict[str, Any] = {"policy": self.begin.policy}
        if self.begin.policy in ("random", "label"):
            begin |= {"count": self.begin.count, "seed": self.begin.seed}
        if self.begin.label:
            begin["label"] = self.begin.label
        if self.begin.orbits:
            begin["states"] = [list(orbit.state) for orbit in self.begin.orbits]
            begin["values"] = [orbit.value for orbit in self.begin.orbits]
            begin["periods"] = [orbit.period for orbit in self.begin.orbits]
        found = {
            "title": self.title,
            "system": self.system.to_table(),
            "along": _table(self.along),
            "start": begin,
            "search": {name: getattr(self, name) for name in SEARCH},
        }
        return found if self.plane is None else {**found, "plane": _table(self.plane)}

    def to_toml(self) -> str:
        """Return it as canonical TOML, which `load_continuation` reads back to an equal one."""
        return toml_text(self.document())

    @cached_property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers: the canonical TOML without titles and sources."""
        return request_hash(self.document())


def _table(item: Interval) -> dict[str, dict[str, float]]:
    return {item.name: {"start": item.low, "stop": item.high}}
