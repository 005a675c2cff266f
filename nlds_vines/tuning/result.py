"""The results of a tuning: columns of its log, datasets of its archive, and its reader `Tuned`."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives.archive import ArchivePath, read
from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.provenance import TUNING
from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.engine.records import OK, STATUS_FLAGS
from nlds_vines.engine.responses import INFINITE, impulses_of
from nlds_vines.errors import RequestError
from nlds_vines.loads.request import LOAD
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.tuning.design_space import Free
from nlds_vines.tuning.request import STARTS, TONE, Tuning, load_tuning

HOW = ("layout", "detuning", "random_start", "stretch")
"""The columns of a trial after its free parameters [SI].

layout: its number in `Tuning.layouts`.  detuning: a factor on omega; under a load, on the
structure's natural frequency.  random_start: 0 for rest, i for the i-th random start.  stretch: a
factor on the periods discarded and sampled; under a load, on the load."""

RESULTS = ("objective", "E2max", "status", "worst_case")
"""The results of a trial: the objective, infinite for an inadmissible design; E2max [J], status and
number of its worst case."""

OF_DRAWS = ("nominal", "mean", "quantile")  # of the objective: the results of draws that follow
# the CF flags of the dataset `stage`
STAGES: Mapping[str, int] = {"global": 0, "polish": 1, "robustness": 2, "surface": 3}
# perturbations: shares of frequencies, parameters and sizes of loads, and so many times the periods
# (which reveals an orbit that is irregular or had not settled)
DETUNING, SHIFT, SIZE, STRETCH = 0.01, 0.02, 0.1, 5
BAND = 5  # values of a parameter from which on they stand for a range rather than for themselves
_FINER = 8  # intervals of a step of such a range, to judge an optimum between its values
_ON_BOUND = 1e-6  # of the range: a search that stops so near to a bound has reached it
_AT_BOUND = 1e-3  # of the range: an optimum so near to a bound is reported


def impacts_of(tuning: Tuning) -> tuple[str, ...]:
    """Return the name of the column of impacts in the worst case; none without walls."""
    if not tuning.system.scene.walls:
        return ()
    return ("impact_rate",) if tuning.history is None else ("impact_count",)


def results_of(tuning: Tuning) -> tuple[str, ...]:
    return (*RESULTS, *(OF_DRAWS if tuning.draws else ()), *impacts_of(tuning))


def is_band(axis: Axis) -> bool:
    return axis.name in (*DESCRIBED, TONE) and axis.values.size >= BAND


def over_finer_bands(tuning: Tuning) -> Tuning | None:
    """Return a tuning with finer bands, to judge designs by; None without a band."""

    def finer(axis: Axis) -> Axis:
        places = np.arange(axis.values.size)
        between = np.linspace(0, places[-1], _FINER * places[-1] + 1)
        return Axis(axis.name, np.interp(between, places, axis.values))

    if not any(map(is_band, tuning.over)):
        return None
    over = tuple(finer(axis) if is_band(axis) else axis for axis in tuning.over)
    # only its objective is used, so its search is the smallest allowed one
    least = replace(tuning.search, population=5, generations=1, polish=0, seeds=1, optima=1)
    return replace(tuning, over=over, surface=None, search=least)


class Perturbation(NamedTuple):
    words: str
    column: str  # of the trial
    value: float  # the factor on that column; the number of a `random_start`


def perturbations(tuning: Tuning) -> list[Perturbation]:
    """Return the perturbations under which an optimum is tested; the first is none."""

    def both(words: str, column: str, share: float) -> list[Perturbation]:
        return [Perturbation(f"{words} {s:+.0%}", column, 1.0 + s) for s in (-share, share)]

    none = Perturbation("none", "stretch", 1.0)
    shifted = [one for name in tuning.names for one in both(name, name, SHIFT)]
    if tuning.history is not None:
        detuned = both("natural frequency", "detuning", DETUNING)
        return [none, *detuned, *both("load", "stretch", SIZE), *shifted]
    starts = [Perturbation(f"random start {i}", "random_start", i) for i in range(1, STARTS + 1)]
    longer = Perturbation(f"{STRETCH} x the periods", "stretch", STRETCH)
    return [none, *both("omega", "detuning", DETUNING), longer, *shifted, *starts]


def scales(tuning: Tuning, evaluations: int, optima: int) -> list[Scale]:
    names = np.array([one.words for one in perturbations(tuning)], dtype=np.str_)
    seeds = np.array(tuning.search.all_seeds, dtype=np.int64)
    grid = tuning.surface_values() if optima else {}
    return [
        Scale.counted("evaluation", evaluations, "evaluation, in order"),
        Scale.counted("case", tuning.case_count, "case under which each design is judged"),
        Scale("search", seeds, "1", "seed of a search"),
        Scale.counted("optimum", optima, "near-equal optimum, the best first"),
        Scale("perturbation", names, "1", "perturbation of an optimum"),
        *(DESCRIBED[name].scale(values, "surface_") for name, values in grid.items()),
    ]


def contents(
    tuning: Tuning,
    columns: Mapping[str, np.ndarray],
    optima: np.ndarray,
    judged: Mapping[str, np.ndarray],
) -> list[tuple[Dataset, np.ndarray]]:
    """Return the datasets of the archive with their values; those without values are left out.

    Arguments: the `columns` of the log, its rows with the `optima`, and further objectives.
    """
    dims, unit, is_steady = ("evaluation",), tuning.unit, tuning.history is None
    judged_in_words = f"{tuning.judged}: {tuning.objective_in_words}"
    off = "factor on the structure's natural frequency, by its stiffness"
    stretch = "factor on all numbers of periods" if is_steady else "factor on the load"
    table = [DESCRIBED[name].dataset(dims) for name in tuning.names]
    table += [Dataset.real("detuning", dims, "1", "factor on every omega" if is_steady else off)]
    table += [Dataset.whole("random_start", dims, "random start; 0: from rest")] * is_steady
    table += [Dataset.real("stretch", dims, "1", stretch)]
    if tuning.draws:
        largest = f"largest {tuning.search.objective} of all cases"
        share = f"{100 * tuning.quantile:g} % quantile"
        table += [
            Dataset.real("nominal", dims, unit, f"{largest}, nominal", np.inf),
            Dataset.real("mean", dims, unit, "mean of it over the draws", np.inf),
            Dataset.real("quantile", dims, unit, f"{share} of it over the draws", np.inf),
        ]
    impacts = "per forcing period" if is_steady else "under the load"
    impacts = f"impacts {impacts} in that case, nominal"
    table += [
        Dataset.real("objective", dims, unit, judged_in_words, np.inf),
        Dataset.real("E2max", dims, "J", "the damper's energy in that case"),
        Dataset.whole("worst_case", dims, "number of that case"),
        *(Dataset.real(name, dims, "1", impacts) for name in impacts_of(tuning)),
        Dataset.code("stage", dims, "stage of the search", STAGES),
        Dataset("seed", dims, "int64", "1", "seed of the search", 0),
        *([_layout(tuning, "layout", dims)] if tuning.places else []),
        Dataset.code("status", dims, "how its worst orbit ended", STATUS_FLAGS),
    ]
    datasets = [(entry, columns[entry.name]) for entry in table]
    for name, values in tuning.cases().items():
        if name in DESCRIBED:
            entry = DESCRIBED[name].dataset(("case",), "case_")
        elif name == LOAD:
            entry = Dataset.whole(f"case_{name}", ("case",), "number of the record, from 0")
        else:
            assert tuning.history is not None
            of_load = tuning.history.load.words_of_number(name)
            entry = Dataset.real(f"case_{name}", ("case",), *of_load)
        datasets.append((entry, np.ascontiguousarray(values)))
    dims, grid = ("optimum",), () if tuning.surface is None else tuning.surface.parameters
    for name in tuning.names:
        datasets.append((DESCRIBED[name].dataset(dims, "optimum_"), columns[name][optima]))
    if tuning.places:
        datasets.append((_layout(tuning, "optimum_layout", dims), columns["layout"][optima]))
    place = Dataset("optimum_evaluation", dims, "int64", "1", "its place among the evaluations", 0)
    datasets.append((place, optima))
    again = f"{tuning.judged_by(tuning.fresh_draws)} that the search did not have"
    objectives = {"optimum_objective": columns["objective"][optima], **judged}
    for name, dimensions, words in (
        ("optimum_objective", dims, judged_in_words),
        ("robustness", (*dims, "perturbation"), f"{tuning.judged} under a perturbation"),
        ("search_best", ("search",), "best objective of a search"),
        ("optimum_finer", dims, f"{tuning.judged}, with more values in each band"),
        ("optimum_fresh", dims, again),
        ("surface", tuple(f"surface_{name}" for name in grid),
         "objective over two parameters, the others as in the best optimum"),
    ):  # fmt: skip
        if name in objectives:
            entry = Dataset.real(name, dimensions, unit, words, np.inf)
            datasets.append((entry, objectives[name]))
    return [(entry, values) for entry, values in datasets if values.size]


def _layout(tuning: Tuning, name: str, dims: tuple[str, ...]) -> Dataset:
    flags = {words.replace(" ", "_"): i for i, words in enumerate(tuning.layouts_in_words)}
    return Dataset.code(name, dims, "places of the dampers", flags)


@dataclass(frozen=True, repr=False)
class Optimum(Outlined):
    parameters: Mapping[str, float]  # [SI]
    objective: float  # with draws, over `Tuning.fresh_draws` that the search did not have
    robustness: Mapping[str, float]  # by perturbation, of which the worst one is the `cause`
    finer: float = nan  # the objective with more values in each band
    searched: float | None = None  # the objective that chose it; with draws, this flatters it
    nominal: float | None = None  # without draws of uncertain parameters
    mean: float | None = None  # over the draws of the search
    quantile: float | None = None  # over the draws of the search
    impacts: float = nan  # with walls, of the worst case: per forcing period, or under the load
    places: Mapping[str, Any] = field(
        default_factory=dict
    )  # cell1.attached_to, as `with_` takes it

    @property
    def cause(self) -> str:
        return max(self.robustness, key=self.robustness.__getitem__)

    @property
    def worst(self) -> float:
        return self.robustness[self.cause]


@dataclass(frozen=True, repr=False)
class Tuned(Drawable):
    """The results of a tuning, as `tune` and `open_archive` return them.

    Attributes
    ----------
    tuning : Tuning
        The request; `request` is the same.
    optima : tuple of Optimum
        Designs nearly as good as the best and apart from one another, the best first; empty if
        every design was inadmissible.  Each has `parameters`, `objective`, `robustness`, `impacts`.
    spread : dict of int to float
        The best objective of each seed.
    evaluations : int
        Number of designs evaluated.
    refused : int
        Number of designs that were inadmissible: an orbit failed or broke a constraint, or the
        objective is infinite.
    path : path-like
        The archive.
    failed : int
        Number of designs of which an orbit failed.

    See Also
    --------
    tune
    """

    drawn_by = "nlds_vines.tuning.picture"

    tuning: Tuning
    optima: tuple[Optimum, ...]
    spread: Mapping[int, float]
    evaluations: int
    refused: int
    path: ArchivePath
    failed: int = 0

    @property
    def request(self) -> Tuning:
        """The same as `tuning`."""
        return self.tuning

    def heading(self) -> str:
        """Return the title."""
        return self.tuning.title

    def outline(self) -> Rows:
        """Return the best design, and how many were evaluated."""
        if self.optima:
            unit = self.tuning.unit
            best = f"{numbers(self.parameters)}; {self.objective:.6g} {unit}"
            yield "best", f"{best}, disturbed {self.best.worst:.6g} {unit} ({self.best.cause})"
        counts = f"{self.evaluations}, {self.refused} of them inadmissible"
        yield "designs", f"{counts}; {len(self.optima)} optima"
        yield "archive", str(self.path)

    @property
    def best(self) -> Optimum:
        """The best design.

        Raises
        ------
        RequestError
            If no design was admissible.
        """
        if not self.optima:
            raise RequestError(f"{self.path}: {self._none_admissible()}")
        return self.optima[0]

    @property
    def parameters(self) -> Mapping[str, float]:
        """The free parameters of the best design by name [SI]."""
        return self.best.parameters

    @property
    def objective(self) -> float:
        """The objective of the best design, in the unit `tuning.unit`."""
        return self.best.objective

    def _none_admissible(self) -> str:
        """Return in one line that no design is admissible, and why if the objective tells."""
        tuning, text = self.tuning, f"all {self.evaluations} designs were inadmissible"
        name, rigid = tuning.search.objective, tuning.system.scene.with_rigid_walls
        if name.rpartition(".")[2] in INFINITE and rigid and self.failed < self.evaluations:
            finite = ", ".join(impulses_of(tuning.system.scene))
            return f"{text}: {name} is infinite where a rigid wall acts; {finite} is finite"
        return f"{text}; widen the bounds"

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report."""
        tuning = self.tuning
        yield tuning.title
        if tuning.history is not None:
            yield from tuning.history.load.records_in_words(tuning.history.duration)
        if not self.optima:
            yield self._none_admissible()
            return
        yield f"{self.evaluations} designs, {self.refused} of them inadmissible"
        yield f"objective: {tuning.objective_in_words}"
        has_finer, has_impacts = isfinite(self.best.finer), bool(impacts_of(tuning))
        each = "impacts/T" if tuning.history is None else "impacts"
        heads = [f"{tuning.search.objective} [{tuning.unit}]"]
        heads += [f"finer [{tuning.unit}]"] * has_finer + [each] * has_impacts
        heads = [f"{head:>11}" for head in heads]
        yield "  ".join([*(f"{n:>10}" for n in tuning.names), *heads, f"disturbed [{tuning.unit}]"])
        for item in self.optima:
            values = [item.objective, *[item.finer] * has_finer, *[item.impacts] * has_impacts]
            columns = [f"{_at_bound(one, item.parameters[one.name]):10.5g}" for one in tuning.free]
            columns += [f"{value:11.5g}" for value in values]
            where = tuning.layouts_in_words[tuning.layouts.index({**item.places})]
            yield "  ".join([*columns, f"{item.worst:.5g} ({item.cause})", where]).rstrip()
        # remarks on draws, seeds and bands, on inert parameters and optima at a bound
        best, unit = self.best, tuning.unit
        if tuning.draws:
            what = ", ".join(one.words() for one in tuning.uncertain) or "noise"
            yield (
                f"judged by the {tuning.judged} of {what}: "
                f"as given {best.nominal:.5g}, mean {best.mean:.5g}, "
                f"{100 * tuning.quantile:g} % quantile {best.quantile:.5g} {unit}"
            )
            yield (
                f"chosen by {best.searched:.5g} {unit}, which flatters: the table has "
                f"the {tuning.judged_by(tuning.fresh_draws)} that the search did not have"
            )
        if len(self.spread) > 1:
            low, middle, high = np.percentile(list(self.spread.values()), [0, 50, 100])
            yield (
                f"{len(self.spread)} seeds: best {low:.6g}, median {middle:.6g}, "
                f"worst {high:.6g} {unit}"
            )
        finer = over_finer_bands(tuning)
        for axis, finer_axis in zip(tuning.over, finer.over if finer else tuning.over, strict=True):
            largest = f"the largest of {axis.values.size} values of {axis.as_stated.name}"
            if is_band(axis) and isfinite(best.finer):
                yield f"{tuning.search.objective} is {largest}; finer: of {finer_axis.values.size}"
            elif is_band(axis):
                yield f"{largest}; between them it may be larger"
        for one in tuning.free:
            value = self.parameters[one.name]
            if one.inert:
                yield f"{one.name} does not enter the dynamics: any value is as good"
            elif not _AT_BOUND < one.unit(np.asarray(value)) < 1 - _AT_BOUND:
                at = f"{_at_bound(one, value):.4g}"
                yield f"{one.name} stands at its bound {at}: the optimum may lie beyond"


def _at_bound(free: Free, value: float) -> float:
    """Return the bound at which a search has stopped, or the value if it has not."""
    place = float(free.unit(np.asarray(value)))
    if place < _ON_BOUND:
        return free.low
    return free.high if place > 1 - _ON_BOUND else value


def tuned(path: str | os.PathLike[str]) -> Tuned:
    with read(path) as view:
        tuning = view.request(TUNING, load_tuning)
        stage, optima = view["stage"], list[Optimum]()
        refused = ~np.isfinite(view["objective"]) | (view["status"] != OK)
        if "optimum_objective" in view:  # some design was admissible
            causes, rows = view["perturbation"].tolist(), view["optimum_evaluation"]
            columns = {name: view[name][rows] for name in OF_DRAWS if tuning.draws}
            for name in impacts_of(tuning):
                columns["impacts"] = view[name][rows]
            columns["searched"] = view["optimum_objective"]
            columns["objective"] = view["optimum_fresh" if tuning.draws else "optimum_objective"]
            if "optimum_finer" in view:
                columns["finer"] = view["optimum_finer"]
            placed = view["optimum_layout"] if tuning.places else np.zeros(len(rows), int)
            optima = [
                Optimum(
                    parameters={name: float(view[f"optimum_{name}"][i]) for name in tuning.names},
                    robustness=dict(zip(causes, robustness, strict=True)),
                    places=tuning.layouts[placed[i]],
                    **{name: float(values[i]) for name, values in columns.items()},
                )
                for i, robustness in enumerate(view["robustness"].tolist())
            ]
        return Tuned(
            tuning=tuning,
            optima=tuple(optima),
            spread=dict(zip(view["search"].tolist(), view["search_best"].tolist(), strict=True)),
            evaluations=int(stage.size),
            refused=int(np.count_nonzero(refused & (stage <= STAGES["polish"]))),
            path=ArchivePath.of(path),
            failed=int(np.count_nonzero(view["status"] != OK)),
        )
