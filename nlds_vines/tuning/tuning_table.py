"""The datasets of a tuning's archive: evaluations, optima and their robustness, a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.model.loads.loading import words_of_number
from nlds_vines.model.parameters import DESCRIBED, described
from nlds_vines.orbits.records import STATUS_FLAGS
from nlds_vines.tuning.evaluations import STAGES
from nlds_vines.tuning.objective import impacts_of
from nlds_vines.tuning.optima import perturbations
from nlds_vines.tuning.request import Tuning

Content = tuple[Dataset, np.ndarray]
"""A dataset's description and its values."""


@dataclass(frozen=True)
class Findings:
    """The results of a search.

    Arguments:
        columns: every evaluation, by column of the log.
        optima: rows of the near-equal optima in the log, the best first.
        robustness: objectives (optima, perturbations) [J].
        surface: (values of the first parameter, of the second, objectives [J]) or None.
        spread: the best objective of each seed [J].
        finer: objectives (optima,) over finer bands [J]; None where there is no band.
        fresh: objectives (optima,) by draws of which the search had none; None without draws.
    """

    columns: dict[str, np.ndarray]
    optima: np.ndarray
    robustness: np.ndarray
    surface: tuple[np.ndarray, np.ndarray, np.ndarray] | None
    spread: np.ndarray
    finer: np.ndarray | None = None
    fresh: np.ndarray | None = None


def scales(tuning: Tuning, found: Findings) -> list[Scale]:
    """Return the dimensions of the archive."""
    names = np.array(perturbations(tuning), dtype=np.str_)
    seeds = np.array(tuning.search.all_seeds, dtype=np.int64)
    dims = [
        Scale.counted("evaluation", len(found.columns["objective"]), "evaluation, in order"),
        Scale.counted(
            "case", tuning.case_count, "frequency and parameters a design is judged under"
        ),
        Scale("search", seeds, "1", "seed of a search"),
        Scale.counted("optimum", len(found.optima), "near-equal optimum, the best first"),
        Scale("perturbation", names, "1", "what disturbs an optimum"),
    ]
    if tuning.surface is not None and found.surface is not None:
        for name, values in zip(tuning.surface.parameters, found.surface, strict=False):
            dims.append(described(name).scale(values, "surface_"))
    return dims


def contents(tuning: Tuning, found: Findings) -> list[Content]:
    """Return the datasets of the archive with their values; those without values are left out."""
    possible = [
        *_evaluations(tuning, found),
        *_cases(tuning),
        *_optima(tuning, found),
        *_surface(tuning, found),
    ]
    return [(entry, values) for entry, values in possible if values.size]


def _evaluations(tuning: Tuning, found: Findings) -> list[Content]:
    """Return the log, one dataset for each column."""
    dims, columns, unit = ("evaluation",), found.columns, tuning.unit
    table = [described(name).dataset(dims) for name in tuning.names]
    if tuning.history is None:
        table += [
            Dataset.real("detuning", dims, "1", "factor on every omega"),
            Dataset.whole("random_start", dims, "random start; 0: from rest"),
            Dataset.real("stretch", dims, "1", "factor on all numbers of periods"),
        ]
    else:
        off = "factor on the structure's natural frequency, by its stiffness"
        table += [
            Dataset.real("detuning", dims, "1", off),
            Dataset.real("stretch", dims, "1", "factor on the load"),
        ]
    if tuning.draws:
        each = f"largest {tuning.search.objective} of all cases"
        share = f"{100 * tuning.quantile:g} % quantile"
        table += [
            Dataset.real("nominal", dims, unit, f"{each}, as given", np.inf),
            Dataset.real("mean", dims, unit, "mean of it over the draws", np.inf),
            Dataset.real("quantile", dims, unit, f"{share} of it over the draws", np.inf),
        ]
    table += [
        Dataset.real("objective", dims, unit, _objective(tuning), np.inf),
        Dataset.real("E2max", dims, "J", "the damper's energy in that case"),
        Dataset.whole("worst_case", dims, "number of that case"),
        *_impacts(tuning),
        Dataset.code("stage", dims, "part of the search", STAGES),
        Dataset("seed", dims, "int64", "1", "seed of the search", 0),
        Dataset.code("status", dims, "how its worst orbit ended", STATUS_FLAGS),
    ]
    return [(entry, columns[entry.name]) for entry in table]


def _objective(tuning: Tuning) -> str:
    """Return by what designs are judged, and what the objective is."""
    return f"{tuning.judged}: {tuning.objective_in_words}"


def _impacts(tuning: Tuning) -> list[Dataset]:
    """Return the dataset of the impacts in the worst case; none without walls."""
    each = "per forcing period" if tuning.history is None else "under the load"
    text = f"impacts {each} in that case, as given"
    return [Dataset.real(name, ("evaluation",), "1", text) for name in impacts_of(tuning)]


def _cases(tuning: Tuning) -> list[Content]:
    """Return the cases: omega, and the other parameters that take several values."""
    return [
        (_case(tuning, name), np.ascontiguousarray(values))
        for name, values in tuning.cases().items()
    ]


def _case(tuning: Tuning, name: str) -> Dataset:
    """Return the dataset of a parameter, or of a number of the load, that takes several values."""
    if name in DESCRIBED:
        return described(name).dataset(("case",), "case_")
    assert tuning.history is not None
    unit, words = words_of_number(tuning.history.load, name)
    return Dataset.real(f"case_{name}", ("case",), unit, words)


def _optima(tuning: Tuning, found: Findings) -> list[Content]:
    """Return the optima, their objectives under each perturbation, and the best of each seed."""
    columns, rows, dims = found.columns, found.optima, ("optimum",)
    row = Dataset("optimum_evaluation", dims, "int64", "1", "its place among the evaluations", 0)
    least, unit = tuning.judged, tuning.unit
    value = Dataset.real("optimum_objective", dims, unit, _objective(tuning), np.inf)
    both = (*dims, "perturbation")
    firm = Dataset.real("robustness", both, unit, f"{least} under a perturbation", np.inf)
    seeds = Dataset.real("search_best", ("search",), unit, "best objective found", np.inf)
    text = f"{least}, with more values in each band"
    finer = Dataset.real("optimum_finer", dims, unit, text, np.inf)
    text = f"{tuning.judged_by(tuning.fresh_draws)} that the search did not have"
    fresh = Dataset.real("optimum_fresh", dims, unit, text, np.inf)
    designs = [
        (described(name).dataset(dims, "optimum_"), columns[name][rows]) for name in tuning.names
    ]
    return [
        *designs,
        (value, columns["objective"][rows]),
        (row, rows),
        (firm, found.robustness),
        (seeds, found.spread),
        *([] if found.finer is None else [(finer, found.finer)]),
        *([] if found.fresh is None else [(fresh, found.fresh)]),
    ]


def _surface(tuning: Tuning, found: Findings) -> list[Content]:
    """Return the surface, where one was asked for."""
    if tuning.surface is None or found.surface is None:
        return []
    dims = tuple(f"surface_{name}" for name in tuning.surface.parameters)
    text = "objective over two parameters, the others as in the best optimum"
    return [(Dataset.real("surface", dims, tuning.unit, text, np.inf), found.surface[2])]
