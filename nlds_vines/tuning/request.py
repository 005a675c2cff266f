"""The request of a tuning: free parameters, objective, cases, search; read from its file."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, replace
from itertools import product
from math import pi, prod
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import TUNING, Value
from nlds_vines.engine.responses import objectives_of
from nlds_vines.engine.solver_settings import TOLERANCE, tolerance_setting
from nlds_vines.errors import MOST_CHARACTERS, RequestError, at, choice, shown, string
from nlds_vines.loads.datasets import names_of_numbers
from nlds_vines.loads.request import (
    LOAD,
    HistoryRequest,
    is_of_load,
    refuse_load_in_set,
)
from nlds_vines.model.axis import Axis
from nlds_vines.model.dampers import PLACE
from nlds_vines.model.loads.loading import ALL, NUMBERS, Loading
from nlds_vines.model.parameters import (
    DESCRIBED,
    LAWS,
    PARAMETERS,
    range_in_words,
    setting_in_words,
    symbol_of,
)
from nlds_vines.model.presets import refuse_foreign
from nlds_vines.model.quantities import BY_NAME, OF_KNOWN_GROUND, of_load, stored_in
from nlds_vines.model.ratios import axes_of_parameters, meant_by, refuse_twice
from nlds_vines.model.scenes import Scene
from nlds_vines.model.setting import (
    Check,
    Checked,
    Form,
    Merged,
    OneOf,
    Real,
    Request,
    Text,
    Whole,
    check_settings,
    checked_changes,
    entries,
    setting,
    settings_of,
    tables,
)
from nlds_vines.model.slow_manifold import free_mass_manifold
from nlds_vines.model.system import System
from nlds_vines.tuning.design_space import (
    DRAWS,
    FRESH_DRAWS,
    FRESH_UNDER_LOAD,
    MOST_DRAWS,
    USUAL,
    Free,
    Uncertain,
    tunable,
)

# forcing periods sampled by default: with walls, which cause motions of many periods; and without
# walls, when every period of the steady state is the same
SAMPLED, SAMPLED_FREE = 60, 2
OBJECTIVE, UNDER_LOAD = "E1max", "last_1"  # by default: of the steady state, and under a load
QUANTILE = 0.9  # the quantile of draws that is reported unless another one is the objective
LARGEST, MEAN, MEDIAN, EIGHTY_FOUR = "largest", "mean", "median", "84%"
OVER_RECORDS = (LARGEST, MEAN, MEDIAN, EIGHTY_FOUR)  # what judges a design under a suite
SEARCHES = ("de", "cma")  # differential evolution; CMA-ES, which needs the extra `cma`
MOST_LANES = 10**8  # the most orbits of one tuning: days of work on a large machine
STARTS = 4  # random ones of an optimum that is tested
TONE = "tone.omega"  # the frequency that a band means under a load with one tone [rad/s]


def _of_search(default: Any, check: Check, words: str, form: str = "", **options: Any) -> Any:
    return setting(default, check, "search", words, form, **options)


@dataclass(frozen=True)
class Search:
    method: str = _of_search(
        "de", OneOf(SEARCHES, "search method"),
        f"the global search: {' or '.join(f'`{name}`' for name in SEARCHES)}", "METHOD",
        option="--search",
    )  # fmt: skip
    objective: str = _of_search(
        OBJECTIVE, Text(),
        "the objective: `E1max`, `E2max`, a number of a [response](datasets.md) such as `a1_rms`; "
        "under a load, a number of [a response history](loads-in-time.md)", "NAME",
        usual=f"{OBJECTIVE}; under a load {UNDER_LOAD}",
    )  # fmt: skip
    population: int = _of_search(
        60, Whole(5, 10**5), "designs in a generation, all computed at once", "N"
    )
    generations: int = _of_search(
        80, Whole(1, 10**5), "at most: a search that has contracted stops before", "N"
    )
    polish: int = _of_search(
        150, Whole(0, 10**5), "evaluations of each local search that follows, at most", "N"
    )
    optima: int = _of_search(
        5, Whole(1, 50), "designs that are polished and returned, at most", "N"
    )
    within: float = _of_search(
        0.02, Real(0.0, 1.0, inside=True), "share by which a nearly equal design may be worse"
    )
    apart: float = _of_search(
        0.1, Real(0.0, 1.0, inside=True),
        "least distance between nearly equal designs, in the unit cube of the bounds",
    )  # fmt: skip
    seed: int = _of_search(
        0, Whole(0, 2**31), "of the first search: the same seed, the same bits", "N"
    )
    seeds: int = _of_search(1, Whole(1, 1000), "how many searches, each with the next seed", "N")
    records: str = _of_search(
        LARGEST, OneOf(OVER_RECORDS, "number over the records"),
        "the number over the records of a suite that judges a design: `largest`, `mean`, `median`, "
        "or the 84 % quantile `84%`", "WORD",
    )  # fmt: skip
    draws: int = _of_search(
        0, Whole(0, MOST_DRAWS), "draws of uncertain parameters and of noise that judge a design: "
        "a power of two", "N", usual=f"{DRAWS} if something is uncertain",
    )  # fmt: skip
    quantile: float | None = _of_search(
        None, Real(0.0, 1.0, inside=True), "quantile of the draws that is the objective", "SHARE",
        usual="their mean",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
        if self.draws == 1 or self.draws & (self.draws - 1):
            raise RequestError(f"draws = {self.draws} must be a power of two, 2 to {MOST_DRAWS}")

    @property
    def all_seeds(self) -> range:
        return range(self.seed, self.seed + self.seeds)


def check_installed(method: str) -> None:
    if method == "cma" and importlib.util.find_spec("cma") is None:
        raise RequestError(
            "search method 'cma' needs the package cma: pip install 'nlds-vines[cma]'; "
            "without it there is 'de'"
        )


@dataclass(frozen=True)
class Surface:
    parameters: tuple[str, str] = setting(
        MISSING, Checked(lambda value: _two_names(value), listed=True), "surface",
        "two free parameters over which the objective is computed, through the optimum", "A,B",
        option="--surface", usual="the first two",
    )  # fmt: skip
    size: int = setting(
        41, Whole(2, 10**4), "surface", "how many values of each", "N", option="--surface-size"
    )

    def __post_init__(self) -> None:
        check_settings(self)


def _two_names(names: object) -> tuple[str, str]:
    if not isinstance(names, list | tuple) or len(names) != 2:
        raise RequestError(f"parameters of the surface = {shown(names)} must be two names")
    return names[0], names[1]


@dataclass(frozen=True, repr=False)
class Tuning(Request):
    """The request of a tuning; checked when made, immutable afterwards.

    The objective of a design is E1max [J] after the transient, or the quantity that
    `search.objective` names, from rest.  With `over`, it is the largest value of all cases; with
    `uncertain`, the mean or a quantile of that over the draws.

    Parameters
    ----------
    title : str
        One line.
    system : System
        The system; the values of its free parameters are not used.
    free : tuple of Free
        One or more parameters of the damper, each with `name`, `low` and `high` in SI units.
    over : tuple of Axis, optional
        Other parameters and their values, such as omega for the peak over a band; under a load
        also its numbers (`impulse`, `friedlander.peak`).
    history : HistoryRequest, optional
        The load and its duration.  By default designs are judged by their steady state under the
        harmonic force.
    uncertain : tuple of Uncertain, optional
        Uncertain parameters and numbers of the load.
    places : mapping of str to list, optional
        Of a host, the places by damper's name among which the search chooses, by one search each:
        degrees of freedom, or pairs of them.
    surface : Surface, optional
        Two free parameters over which the objective is computed through the optimum.
    transient, periods : int, optional
        Forcing periods that are discarded and sampled.
    search : Search, optional
        Method, objective, population, seeds and draws of the search.
    tolerance : float or str, optional
        Of method exact, which all tunings use.

    Raises
    ------
    RequestError
        If a field is invalid, or the system refuses a value.

    See Also
    --------
    load_tuning, tune
    """

    content: ClassVar[str] = TUNING

    title: str
    system: System
    free: tuple[Free, ...]
    over: tuple[Axis, ...] = ()
    history: HistoryRequest | None = None
    uncertain: tuple[Uncertain, ...] = ()
    places: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    surface: Surface | None = None
    transient: int = setting(
        300, Whole(0), "sampling", "forcing periods that are discarded", "PERIODS"
    )
    periods: int = setting(
        SAMPLED, Whole(1), "sampling", "forcing periods that are sampled", "PERIODS",
        usual=f"{SAMPLED}; of a linear system {SAMPLED_FREE}",
    )  # fmt: skip
    search: Search = field(default_factory=Search)
    tolerance: float | str = tolerance_setting("sampling", TOLERANCE)

    def __post_init__(self) -> None:
        string("title", self.title)
        over = [axis.name for axis in self.over if not self._of_load(axis.name)]
        refuse_twice(self.system.scene, [*self.names, *over])
        system = self.system.with_axes([*over, *self.names])
        object.__setattr__(self, "system", system)
        if self.history is not None:
            systems = (system,)
            object.__setattr__(self, "history", replace(self.history, systems=systems))
        check_settings(self)
        self._check_names()
        self._check_corners()
        for name, candidates in self.places.items():
            with at(f"places of {name}"):
                if not isinstance(candidates, list | tuple) or not candidates:
                    raise RequestError(f"{shown(candidates)} must be a list of places")
        for layout in self.layouts:
            self.system.with_(**layout)
        if self.most_lanes > MOST_LANES:
            raise RequestError(
                f"the tuning may need {self.most_lanes} orbits; allowed: up to {MOST_LANES}"
            )

    @property
    def objectives(self) -> Mapping[str, str]:
        """The possible objectives by name, with their units."""
        return self._objectives_in(self.system.scene)

    def _objectives_in(self, scene: Scene) -> Mapping[str, str]:
        if self.history is None:
            return objectives_of(self.system, scene, self.search.objective)
        # contacts need walls, accelerations and contact forces a law under which impacts take time,
        # impulses one under which they do not, and the drift an acceleration of the ground
        excluded = {entry.name for entry in stored_in("response") if not entry.has(scene)}
        excluded |= {"damping_ratio", "balance", "drift_max"}
        if not scene.walls:
            excluded |= {"share_contact", "impact_count"}
        if self.history.load.shaken:
            excluded -= {"drift_max"}
        names = names_of_numbers(self.history)
        return {name: of_load(name).unit for name in names if name not in excluded}

    @property
    def unit(self) -> str:
        """The unit of the objective."""
        return self.objectives[self.search.objective]

    @property
    def objective_in_words(self) -> str:
        """The name of the objective and its meaning, with body and frame."""
        name = self.search.objective
        if self.history is not None:
            return f"{name}, {of_load(name).words}"
        if name not in BY_NAME:
            return name
        return f"{name}, {BY_NAME[name].words_in(self.system.scene)}"

    @property
    def draws(self) -> int:
        """Number of draws over which a design is judged; 0 for its nominal value."""
        return self.search.draws or (DRAWS if self.uncertain else 0)

    @property
    def fresh_draws(self) -> int:
        """Number of draws by which an optimum is judged again, if the search has draws."""
        least = FRESH_DRAWS if self.history is None else FRESH_UNDER_LOAD
        return max(least, self.draws)

    @property
    def quantile(self) -> float:
        """The quantile of the draws that is reported."""
        return self.search.quantile or QUANTILE

    @property
    def judged(self) -> str:
        """The number that judges a design, in words."""
        return self.judged_by(self.draws)

    def judged_by(self, draws: int) -> str:
        """Return in words the number that judges a design over so many draws."""
        name = self.search.objective
        worst = name if self.case_count == 1 else f"largest {name} of all cases"
        if self.has_number_over_records:
            words = "84 % quantile" if self.search.records == EIGHTY_FOUR else self.search.records
            worst = f"{words} of {name} over {self.record_count} records"
            if self.case_count > self.record_count:
                worst = f"largest of all cases, the {worst}"
        if not self.draws:
            return worst
        by = "mean" if self.search.quantile is None else f"{100 * self.quantile:g} % quantile"
        return f"{by} of {'the ' * (self.case_count > 1)}{worst} over {draws} draws"

    @property
    def first_design(self) -> np.ndarray | None:
        """A first design in closed form, SI values in the order of `free`; None if there is none.

        If only the two clearances of a free mass between two rigid walls are free, it is the best
        clearance of `model.slow_manifold`.
        """
        if set(self.names) != {"C", "D"}:
            return None
        try:
            system = self.system.with_(C=1.0, D=1.0)
            clearance = free_mass_manifold(system).best.clearance
        except RequestError:
            return None
        return np.array([clearance, clearance])

    @property
    def layouts(self) -> list[dict[str, Any]]:
        """The combinations of the places of dampers, as `System.with_` takes them."""
        names = [f"{name}.{PLACE}" for name in self.places]
        chosen = product(*self.places.values())
        return [dict(zip(names, one, strict=True)) for one in chosen]

    @property
    def layouts_in_words(self) -> list[str]:
        """The layouts, as cell1 on roof, cell2 on floor1."""

        def words(name: str, place: Any) -> str:
            where = place if isinstance(place, str) else "-".join(place)
            return f"{name.removesuffix(f'.{PLACE}')} on {where}"

        return [", ".join(words(*one) for one in layout.items()) for layout in self.layouts]

    def starts_inside(self) -> list[str]:
        """Return a line if designs start inside a wall."""
        return [] if self.history is None else self.history.starts_inside()

    def _check_names(self) -> None:
        scene, search, history, names = self.system.scene, self.search, self.history, self.names
        over, uncertain = [axis.name for axis in self.over], [one.name for one in self.uncertain]
        plain = search.objective.rpartition(".")[2]
        if self.history is not None and plain in OF_KNOWN_GROUND:
            raise RequestError(
                f"objective = {search.objective!r}: under a load the displacement of the ground is "
                "not known; displacements are relative to it"
            )
        if search.objective not in self.objectives:
            both, parameters = scene.law_2 is not None, self.system.parameters
            scenes = {law: scene.under(law, law if both else "", parameters) for law in LAWS}
            laws = [law for law in LAWS if search.objective in self._objectives_in(scenes[law])]
            if laws:
                raise RequestError(
                    f"objective {search.objective} does not exist under law "
                    f"{' and '.join(law.name for law in scene.laws)}; allowed: law "
                    f"{' or '.join(laws)}, or objective {', '.join(self.objectives)}"
                )
        choice("objective", search.objective, self.objectives)
        allowed = tunable(scene)
        if not names:
            raise RequestError(
                f"nothing is free; of kind {self.system.kind!r} can be: "
                f"{', '.join(allowed) or 'nothing, it has no damper'}"
            )
        for name in names:
            choice("free parameter", name, allowed)
        if all(parameter.inert for parameter in self.free):
            raise RequestError("V alone is free, and does not enter the dynamics: C does")
        for name in over:
            if name in (*names, *uncertain):
                role = "free" if name in names else "uncertain"
                raise RequestError(f"{name} is {role} and has values of its own: not both")
        if self.surface is not None:
            for name in self.surface.parameters:
                choice("parameter of the surface", name, names)
            if len(set(self.surface.parameters)) != 2:
                raise RequestError("a surface takes two different parameters")
        if history is not None:
            of_system = [name for name in (*over, *uncertain) if not is_of_load(name)]
            self.system.refuse_under(history.load, of_system)
        if search.draws and not (uncertain or (history is not None and history.load.noise)):
            raise RequestError(f"draws = {search.draws}: neither [uncertain] nor noise is given")
        if search.records != LARGEST and self.record_count == 1:
            raise RequestError(f"records = {search.records!r}: there is no suite of records")
        if search.quantile is not None and not self.draws:
            raise RequestError(f"quantile = {search.quantile}: of no draws; see [uncertain]")
        uncertain = [name for name in uncertain if not self._of_load(name)]
        _check_uncertain(self.system, uncertain, history)
        free = dict(zip(meant_by(scene, names), names, strict=True))
        for name, meant in zip(uncertain, meant_by(scene, uncertain), strict=True):
            if free.get(meant, name) != name:
                raise RequestError(
                    f"{name} is uncertain and {free[meant]} free: both say something of {meant}; "
                    f"give one of the two in both tables"
                )
        refuse_twice(scene, [*uncertain, *names, *self.system.fixed_ratios, *over])

    def _of_load(self, name: str) -> bool:
        return self.history is not None and is_of_load(name)

    def value(self, name: str) -> float:
        """Return the value [SI] of a parameter, or of a number of the load."""
        if self.history is not None and self._of_load(name):
            return self.history.load.number(name)
        return self.system.numbers[name]

    def _check_corners(self) -> None:
        """Check system and load at the corners of all intervals: what holds there holds inside."""
        ends = {item.name: np.array([item.low, item.high]) for item in self.free}
        ends |= {axis.name: axis.values[[0, -1]] for axis in self.over}
        for one in self.uncertain:
            low, high = ends.get(one.name, [self.value(one.name)] * 2)
            ends[one.name] = np.array([one.at(low, -one.reach), one.at(high, one.reach)])
        of_load = {name: ends.pop(name) for name in [*ends] if self._of_load(name)}
        corners = np.array(list(product(*ends.values()))).T
        grid = dict(zip(ends, corners, strict=True))
        self.system.cells(grid)  # which refuses values out of range
        if self.history is None:
            return
        period = self.system.shortest_natural_period(grid)
        load = self.history.load
        for axis in self.over:
            if axis.name in of_load:
                load.check_values(axis.name, axis.values)
        for one in self.uncertain:
            if one.name in of_load and load.is_whole(one.name):
                raise RequestError(f"{one.name} is a whole number, and cannot be uncertain")
        for values in product(*(both.tolist() for both in of_load.values())):
            changes = dict(zip(of_load, values, strict=True))
            changed = load.with_(changes)
            changed.check(self.history.duration, period)
            changed.redrawn(self.draws + self.fresh_draws)  # the last seed of its noise

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the free parameters."""
        return tuple(parameter.name for parameter in self.free)

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself: system, parameters, seed."""
        return {**self.system.attributes(self.names), "seed": self.search.seed}

    def cases(self) -> Mapping[str, np.ndarray]:
        """Return the values (cases,) of `over` in every combination; without a load, omega too.

        Under a suite each record is a case, and `load` is its number.
        """
        axes = {axis.name: axis.values for axis in self.over}
        if self.history is not None and self.history.load.suite:
            axes[LOAD] = np.arange(float(self.record_count))
        grids = np.meshgrid(*axes.values(), indexing="ij")
        cases = {name: grid.ravel() for name, grid in zip(axes, grids, strict=True)}
        if self.history is not None:
            return MappingProxyType(cases)
        value = np.array([self.value(self.frequency)])
        return MappingProxyType({self.frequency: np.repeat(value, self.case_count)} | cases)

    def surface_values(self) -> dict[str, np.ndarray]:
        """Return the values of the two parameters of the surface by name; empty without one."""
        if self.surface is None:
            return {}
        places = np.linspace(0.0, 1.0, self.surface.size)
        by_name = {item.name: item for item in self.free}
        return {name: by_name[name].value(places) for name in self.surface.parameters}

    @property
    def frequency(self) -> str:
        """The name of the forcing frequency: omega, or f or omega_ratio if that is set."""
        names = [*self.system.fixed_ratios, *(axis.name for axis in self.over)]
        names += [one.name for one in self.uncertain]
        return next((name for name in ("omega_ratio", "f") if name in names), "omega")

    @property
    def case_count(self) -> int:
        """Number of cases under which one design is judged."""
        return self.record_count * prod(axis.values.size for axis in self.over)

    @property
    def has_number_over_records(self) -> bool:
        """Whether a suite is judged by another number than its largest one."""
        return self.record_count > 1 and self.search.records != LARGEST

    @property
    def record_count(self) -> int:
        """Number of records of the suite; 1 without one."""
        return max(1, len(self.history.load.suite)) if self.history is not None else 1

    @property
    def most_evaluations(self) -> int:
        """The largest number of evaluations, perturbed designs included."""
        search = self.search
        globally = search.population * (search.generations + 1)
        locally = search.optima * search.polish
        robustness = search.optima * (1 + 2 + 2 * len(self.free) + STARTS + 1)
        surface = 0 if self.surface is None else self.surface.size**2
        searches = search.seeds * len(self.layouts)
        return searches * (globally + locally) + robustness + surface

    @property
    def most_lanes(self) -> int:
        """The largest number of orbits."""
        fresh = self.search.optima * (self.fresh_draws + 1) if self.draws else 0
        return self.case_count * (self.most_evaluations * (self.draws + 1) + fresh)

    def document(self) -> dict[str, Any]:
        """Return the complete tuning file of this request as nested tables."""
        document: dict[str, Any] = {
            "title": self.title,
            "system": self.system.to_table(),
            "free": {item.name: {"low": item.low, "high": item.high} for item in self.free},
            "over": {name: entry for axis in self.over for name, entry in axis.entry().items()},
            "sampling": entries(self.history or self, "sampling"),
            "search": entries(self.search, "search"),
        }
        if self.history is not None:
            document["load"] = self.history.load.to_table()
            document["start"] = entries(self.history, "start")
            if record := entries(self.history, "record"):
                document["record"] = record
        if self.uncertain:
            document["uncertain"] = {one.name: one.entry() for one in self.uncertain}
        if self.places:
            document["places"] = {name: list(these) for name, these in self.places.items()}
        if self.surface is not None:
            document["surface"] = entries(self.surface, "surface")
        return document


FORM = Form(
    "tuning",
    (Tuning, Search, Surface, HistoryRequest, Loading),
    names=("set", "free", "over", "uncertain"),
    whole=("places",),
    nested=(*ALL, "load"),
)

DEFAULT_SYSTEM = "ssul-set6"


def load_tuning(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | Tuning | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> Tuning:
    """Read and validate a tuning file.

    Parameters
    ----------
    source : path-like, str, mapping, System or Tuning, optional
        The path of a TOML file (`*.toml`), a catalog name, the document as nested tables, a system
        or a request; by default SSul Set 6.
    changes : mapping, optional
        A document of the same form that overrides the source entry by entry.  A parameter that it
        sets is no longer free.
    changes_from : str, optional
        The name of `changes` in messages.

    Returns
    -------
    Tuning
        The request.

    Raises
    ------
    RequestError
        One line that names place, key, value and what is allowed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> request = nv.load_tuning("tmd", {"over": {"omega": {"start": 5.0, "stop": 8.0, "num": 61}}})
    >>> request.names, request.case_count, request.judged
    (('k2', 'c2'), 61, 'largest E1max of all cases')
    """
    changes = checked_changes(changes, changes_from)
    if isinstance(source, Tuning) and not changes:
        return source
    request = FORM.read(DEFAULT_SYSTEM if source is None else source, changes, changes_from)
    refuse_load_in_set(request)
    system = request.any_system(DEFAULT_SYSTEM, needs_force=False)
    entries = _free(request, system.scene)
    varied = dict.fromkeys(entries, "free") | dict.fromkeys(request.table("over"), "over")
    system = request.as_set(system, varied)
    with at(request.place("free")):
        refuse_foreign(system.scene, [name for name in entries if name in PARAMETERS])
        for name in entries:
            choice("free parameter", name, tunable(system.scene))
        free = tuple(Free.of(n, entries[n]) for n in tunable(system.scene) if n in entries)
    with at(request.place("uncertain")):
        uncertain = tuple(Uncertain.of(*item) for item in request.table("uncertain").items())
    history, steady = _history(request, system)
    with at(request.place("uncertain")):
        of_system = [one.name for one in uncertain if history is None or not is_of_load(one.name)]
        _check_uncertain(system, of_system, history)
    axes = request.axes("over")
    if history is not None and not history.load.harmonic and len(history.load.tone) == 1:
        # an axis of the forcing frequency is that of the only tone
        axes = tuple(Axis(TONE, one.values) if one.name == "omega" else one for one in axes)
        axes = tuple(
            Axis(TONE, 2.0 * pi * one.values, one) if one.name == "f" else one for one in axes
        )
    with at(request.place("over")):
        refuse_twice(system.scene, [axis.name for axis in axes])
        of_load = tuple(axis for axis in axes if history is not None and is_of_load(axis.name))
        others = tuple(axis for axis in axes if axis not in of_load)
        changing = [one.name for one in free]
        for one in uncertain:
            if history is None or not is_of_load(one.name):
                changing.append(one.name)
        names = meant_by(system.scene, [*changing, *(axis.name for axis in others)])
        names += system.following(names)
        over = (*axes_of_parameters(others, system.scene, system.parameters, names), *of_load)
    default = {} if history is None else {"objective": UNDER_LOAD}
    with at(request.place("surface")):
        first = tuple(one.name for one in free if not one.inert)[:2]
        surface = {"parameters": first, **request.of(Surface)}
        grid = Surface(**surface) if request.table("surface") else None
    title = request.title("system", "set", "free", "over", "load", "start")
    if title is None:
        symbols = ", ".join(symbol_of(item.name) for item in free)
        stated = [axis.as_stated for axis in over if axis.as_stated.name in DESCRIBED]
        ranges = [range_in_words(axis.name, axis.values) for axis in stated]
        if history is not None:
            ranges.insert(0, history.load.words() or "a free decay")
        elif not {"omega", "omega_ratio"} & {axis.name for axis in over}:
            ranges.insert(0, setting_in_words("omega", system.parameters["omega"]))
        what = system.scene.meaning.split(":")[0]
        title = f"{what[:1].upper()}{what[1:]}: {symbols} tuned for {', '.join(ranges)}"
        title = title[:MOST_CHARACTERS]
    return request.make(
        Tuning, request.origin("over"), **steady, title=title, system=system, free=free, over=over,
        history=history, uncertain=uncertain, surface=grid, places=request.table("places"),
        search=Search(**default | request.of(Search)),
    )  # fmt: skip


def _check_uncertain(system: System, names: Sequence[str], history: HistoryRequest | None) -> None:
    """Refuse names of the system that have no value, and under a load those of its own force."""
    allowed = list(system.numbers)
    if history is not None:
        system.refuse_under(history.load, names)
        allowed = [name for name in allowed if _means_something(system, history, name)]
        allowed += NUMBERS
    for name in names:
        refuse_foreign(system.scene, [name] if name in PARAMETERS else [])
        choice("uncertain parameter", name, allowed)


def _means_something(system: System, history: HistoryRequest, name: str) -> bool:
    try:
        system.refuse_under(history.load, [name])
    except RequestError:
        return False
    return True


def _free(request: Merged, scene: Scene) -> dict[str, Any]:
    """Return the entries of [free], by default the `USUAL` parameters that the file does not set.

    A parameter that the changes set or vary, or free under another name, is no longer free.
    """
    (_, below), (_, above) = request.layers
    names = set(meant_by(scene, below.get("set", {})))
    entries = tables(
        below.get("free", {n: {} for n in USUAL if n in scene.parameter_names and n not in names})
    )
    free = tables(above.get("free", {}))
    stated = {*meant_by(scene, [*above.get("set", {}), *above.get("over", {})])}
    stated |= {*meant_by(scene, free)} - {*free}
    return {k: v for k, v in entries.items() if stated.isdisjoint(meant_by(scene, [k]))} | free


def _history(request: Merged, system: System) -> tuple[HistoryRequest | None, dict[str, Any]]:
    """Return the response history if there is a load or a start, else the settings without one."""
    loaded = bool(request.table("load") or request.table("start"))
    owner: type = HistoryRequest if loaded else Tuning
    keys = [entry.key for entry in settings_of(owner, "sampling").values()]
    for name in request.layers[1][1].get("sampling", {}):
        if name not in keys:
            why = "under a load" if loaded else "without [load] or [start]"
            with at(request.place("sampling")):
                raise RequestError(f"{name} is not used {why}; allowed: {', '.join(keys)}")
    if not loaded and (of := request.layers[1][1].get("record", {}).get("of")):
        with at(request.place("record")):
            raise RequestError(f"of = {shown(of)} is not used without [load] or [start]")
    if not loaded:
        with at(request.place("system")):
            system.refuse_without_force()
        periods = SAMPLED_FREE if system.scene.is_linear else SAMPLED
        return None, {"periods": periods} | request.of(Tuning)
    with at(request.place("load" if request.table("load") else "start")):
        load = Loading(**request.of(Loading))
        systems = (system,)
        return HistoryRequest("under a load", systems, load, **request.of(HistoryRequest)), {}
