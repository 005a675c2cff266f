"""A tuning: which parameters of a damper are free, what is to be small, and how to search.

`load_tuning` reads one from TOML and checks it once; what comes out is sound.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import prod
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.archives.outline import Outlined
from nlds_vines.archives.provenance import Value
from nlds_vines.errors import RequestError, choice, number, string, typed, whole
from nlds_vines.model.axis import Axis
from nlds_vines.model.layers import request_hash
from nlds_vines.model.system import System
from nlds_vines.orbits.responses import objectives_of
from nlds_vines.orbits.settings import TOLERANCE, checked_tolerance
from nlds_vines.toml import toml_text
from nlds_vines.tuning.free_parameter import Free, tunable

SAMPLED, SAMPLED_FREE = 60, 2
"""Forcing periods sampled by default: with walls, where motions of many periods are common; without
any, where the steady state repeats itself in every period."""

OBJECTIVE = "E1max"
"""What is to be small by default."""

SEARCHES = ("de", "cma")
"""The global searches: differential evolution; CMA-ES, which needs the extra `cma`."""

MOST_LANES = 10**8
"""The most orbits of one tuning: days of work on a large machine."""

DETUNING, SHIFT, STARTS, STRETCH = 0.01, 0.02, 4, 5
"""The perturbations of an optimum: frequencies 1 % off, parameters 2 % off, this number of random
starts, and this multiple of the periods (which shows an orbit that had not settled, or is
irregular)."""

SAMPLING: Mapping[str, Callable[[object], Any]] = {
    "transient": lambda value: whole("transient", value, 0),
    "periods": lambda value: whole("periods", value, 1),
    "tolerance": checked_tolerance,
}
"""The checks of the table [sampling] of a tuning file, by key."""

SEARCH: Mapping[str, Callable[[object], Any]] = {
    "method": lambda value: choice("search method", value, SEARCHES),
    "objective": lambda value: string("objective", value),
    "population": lambda value: whole("population", value, 5, 10**5),
    "generations": lambda value: whole("generations", value, 1, 10**5),
    "polish": lambda value: whole("polish", value, 0, 10**5),
    "optima": lambda value: whole("optima", value, 1, 50),
    "within": lambda value: _fraction("within", value),
    "apart": lambda value: _fraction("apart", value),
    "seed": lambda value: whole("seed", value, 0, 2**31),
    "seeds": lambda value: whole("seeds", value, 1, 1000),
}
"""The checks of the table [search] of a tuning file, by key."""


def _fraction(what: str, value: object) -> float:
    found = number(what, value)
    if 0 < found < 1:
        return found
    raise RequestError(f"{what} = {found!r} must be between 0 and 1")


@dataclass(frozen=True)
class Search:
    """How to search; checked when made.

    Arguments:
        method: one of `SEARCHES`.
        objective: what is to be small, of `responses.objectives_of` the scene.
        population: designs in a generation, all computed at once.
        generations: the most there are of them; a search that has contracted stops before.
        polish: the most evaluations of each local search (Nelder-Mead) that follows.
        optima: the most designs that are polished, and that are returned.
        within: how much worse than the best a near-equal design may be.
        apart: how far from each other near-equal designs are at least, in the unit cube that the
            bounds span.
        seed, seeds: the search is repeated with so many seeds, from `seed` on.
    """

    method: str = "de"
    objective: str = OBJECTIVE
    population: int = 60
    generations: int = 80
    polish: int = 150
    optima: int = 5
    within: float = 0.02
    apart: float = 0.1
    seed: int = 0
    seeds: int = 1

    def __post_init__(self) -> None:
        """Check everything."""
        for name, check in SEARCH.items():
            object.__setattr__(self, name, check(getattr(self, name)))

    @property
    def all_seeds(self) -> range:
        """The seeds, one for each repetition."""
        return range(self.seed, self.seed + self.seeds)


@dataclass(frozen=True)
class Surface:
    """The grid of the objective over two free parameters, `size` values each."""

    parameters: tuple[str, str]
    size: int = 41

    def __post_init__(self) -> None:
        """Check the size; the tuning checks the parameters."""
        whole("size of the surface", self.size, 2, 10**4)


@typed
@dataclass(frozen=True, repr=False)
class Tuning(Outlined):
    """What to tune; checked when made, immutable afterwards.

    The objective of a design is E1max [J] after the transient, or another number that
    `search.objective` names, from rest; where `over` names parameters, the largest of all
    combinations of their values.

    Arguments:
        title: one line for people.
        system: the parameters that are not free.
        free: one or more parameters of the damper.
        over: other parameters and their values, such as omega for the peak over a band.
        surface: a grid to compute through the optimum, or None.
        transient, periods: forcing periods discarded (>= 0) and sampled (>= 1).
        tolerance: of method exact, which all tunings use: a number or one of `TOLERANCES`.
        search: how to search.

    Raises `RequestError` for anything else, and for a value that the system refuses.
    """

    title: str
    system: System
    free: tuple[Free, ...]
    over: tuple[Axis, ...] = ()
    surface: Surface | None = None
    transient: int = 300
    periods: int = SAMPLED
    search: Search = field(default_factory=Search)
    tolerance: float | str = TOLERANCE

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        system = self.system.with_axes(axis.name for axis in self.over)
        object.__setattr__(self, "system", system)
        for name, check in SAMPLING.items():
            object.__setattr__(self, name, check(getattr(self, name)))
        self._check_names()
        self._check_corners()
        if self.most_lanes > MOST_LANES:
            raise RequestError(
                f"the tuning may need {self.most_lanes} orbits; allowed: up to {MOST_LANES}"
            )

    @property
    def unit(self) -> str:
        """The unit of the objective."""
        return objectives_of(self.system.scene)[self.search.objective]

    def _check_names(self) -> None:
        choice("objective", self.search.objective, objectives_of(self.system.scene))
        allowed = tunable(self.system.scene)
        if not self.free:
            raise RequestError(
                f"nothing is free; of kind {self.system.kind!r} can be: "
                f"{', '.join(allowed) or 'nothing, it has no damper'}"
            )
        for name in self.names:
            choice("free parameter", name, allowed)
            if name in (axis.name for axis in self.over):
                raise RequestError(f"{name} is free and has values of its own: not both")
        if all(parameter.inert for parameter in self.free):
            raise RequestError("V alone is free, and does not enter the dynamics: C does")
        if self.surface is not None:
            for name in self.surface.parameters:
                choice("parameter of the surface", name, self.names)
            if len(set(self.surface.parameters)) != 2:
                raise RequestError("a surface takes two different parameters")

    def _check_corners(self) -> None:
        """Let the system check the corners of all intervals: what holds there holds inside."""
        ends = [(item.low, item.high) for item in self.free]
        ends += [tuple(axis.values[[0, -1]]) for axis in self.over]
        corners = np.array(list(product(*ends))).T
        names = (*self.names, *(axis.name for axis in self.over))
        self.system.cells(dict(zip(names, corners, strict=True)))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the free parameters."""
        return tuple(parameter.name for parameter in self.free)

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself: system, parameters, seed."""
        return {**self.system.attributes, "seed": self.search.seed}

    def cases(self) -> Mapping[str, np.ndarray]:
        """Return the values of `over` in every combination, omega always among them."""
        grids = np.meshgrid(*(axis.values for axis in self.over), indexing="ij")
        found = {axis.name: grid.ravel() for axis, grid in zip(self.over, grids, strict=True)}
        omega = np.array([self.system.parameters["omega"]])
        return MappingProxyType({"omega": np.repeat(omega, self.case_count)} | found)

    @property
    def case_count(self) -> int:
        """Number of orbits of one design."""
        return prod(axis.values.size for axis in self.over)

    @property
    def most_evaluations(self) -> int:
        """The most designs that will be evaluated, each perturbed one counted."""
        search = self.search
        globally = search.population * (search.generations + 1)
        locally = search.optima * search.polish
        robustness = search.optima * (1 + 2 + 2 * len(self.free) + STARTS + 1)
        surface = 0 if self.surface is None else self.surface.size**2
        return search.seeds * (globally + locally) + robustness + surface

    @property
    def most_lanes(self) -> int:
        """The most orbits that will be computed."""
        return self.most_evaluations * self.case_count

    def document(self) -> dict[str, Any]:
        """Return the tuning file that means exactly this tuning, complete, as nested tables."""
        found: dict[str, Any] = {
            "title": self.title,
            "system": self.system.to_table(),
            "free": {item.name: {"low": item.low, "high": item.high} for item in self.free},
            "over": {axis.name: {"values": axis.values.tolist()} for axis in self.over},
            "sampling": {name: getattr(self, name) for name in SAMPLING},
            "search": {name: getattr(self.search, name) for name in SEARCH},
        }
        if self.search.objective == OBJECTIVE:  # as tunings were before they had a choice
            del found["search"]["objective"]
        if self.surface is not None:
            size = self.surface.size
            found["surface"] = {"parameters": list(self.surface.parameters), "size": size}
        return found

    def to_toml(self) -> str:
        """Return the tuning as canonical TOML, which `load_tuning` reads back to an equal one."""
        return toml_text(self.document())

    @cached_property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers: the canonical TOML without titles and sources."""
        return request_hash(self.document())
