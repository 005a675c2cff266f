"""The results of a tuning, read from its archive: the optima and their robustness."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite, nan

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import TUNING
from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import RequestError
from nlds_vines.orbits.records import OK
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.tuning.evaluations import STAGES
from nlds_vines.tuning.free_parameter import Free
from nlds_vines.tuning.objective import OF_DRAWS, impacts_of
from nlds_vines.tuning.optima import is_band, over_finer_bands
from nlds_vines.tuning.request import Tuning, load_tuning

_ON_BOUND = 1e-6  # of the range: so near to a bound a search is at it
_AT_BOUND = 1e-3  # of the range: an optimum that near to a bound is reported


@dataclass(frozen=True, repr=False)
class Optimum(Outlined):
    """One optimum: its parameters [SI], its objective, and that under perturbations.

    `robustness` holds the objective under each perturbation, `none` among them; `finer` is the
    objective with more values in each band, NaN where there is no band.  Where there are draws,
    `objective` is that over `Tuning.fresh_draws` draws that the search did not have, `searched` the
    one by which the design was chosen and which flatters it; `nominal` is that of the design as
    given, `mean` and `quantile` those over the draws of the search.  With walls, `impacts` counts
    those of the worst case: in each forcing period, or under the load.
    """

    parameters: Mapping[str, float]
    objective: float
    robustness: Mapping[str, float]
    finer: float = nan
    searched: float | None = None
    nominal: float | None = None
    mean: float | None = None
    quantile: float | None = None
    impacts: float = nan

    @property
    def worst(self) -> float:
        """The largest objective under any of the perturbations."""
        return max(self.robustness.values())

    @property
    def cause(self) -> str:
        """The perturbation with the largest objective."""
        return max(self.robustness, key=self.robustness.__getitem__)


@dataclass(frozen=True, repr=False)
class Tuned(Drawable):
    """The results of a tuning.

    `optima` are designs nearly as good as the best and apart from one another, the best first;
    empty where every design was inadmissible.  `spread` is the best objective of each seed;
    `evaluations` counts all designs evaluated, `refused` those whose orbits failed.
    """

    drawn_by = "nlds_vines.tuning.picture"

    tuning: Tuning
    optima: tuple[Optimum, ...]
    spread: Mapping[int, float]
    evaluations: int
    refused: int
    path: ArchivePath

    @property
    def request(self) -> Tuning:
        """The tuning, with which the same is computed again."""
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
        """The best design; `RequestError` where none was admissible."""
        if not self.optima:
            raise RequestError(f"{self.path}: every design was inadmissible; widen the bounds")
        return self.optima[0]

    @property
    def parameters(self) -> Mapping[str, float]:
        """The parameters of the best design [SI]."""
        return self.best.parameters

    @property
    def objective(self) -> float:
        """The objective of the best design, in `tuning.unit`."""
        return self.best.objective

    def lines(self) -> Iterator[str]:
        """Yield the report, a line at a time."""
        yield self.tuning.title
        if self.tuning.history is not None:
            yield from self.tuning.history.load.records_in_words(self.tuning.history.duration)
        if not self.optima:
            yield f"all {self.evaluations} designs were inadmissible"
            return
        yield f"{self.evaluations} designs, {self.refused} of them inadmissible"
        yield f"objective: {self.tuning.objective_in_words}"
        names, unit = self.tuning.names, self.tuning.unit
        heads = [f"{self.tuning.search.objective} [{unit}]"]
        heads += [f"finer [{unit}]"] if isfinite(self.best.finer) else []
        each = "impacts/T" if self.tuning.history is None else "impacts"
        heads += [each] * len(impacts_of(self.tuning))
        heads = [f"{head:>11}" for head in heads]
        yield "  ".join([*(f"{name:>10}" for name in names), *heads, f"disturbed [{unit}]"])
        for item in self.optima:
            values = [item.objective, *([item.finer] if isfinite(self.best.finer) else [])]
            values += [item.impacts] * len(impacts_of(self.tuning))
            columns = [f"{_told(one, item.parameters[one.name]):10.5g}" for one in self.tuning.free]
            columns += [f"{value:11.5g}" for value in values]
            yield "  ".join([*columns, f"{item.worst:.5g} ({item.cause})"])
        yield from self._remarks()

    def _remarks(self) -> Iterator[str]:
        """Yield remarks: draws, the spread over the seeds, inert parameters, optima at a bound."""
        if self.tuning.draws:
            best, what = self.best, ", ".join(one.words() for one in self.tuning.uncertain)
            yield (
                f"judged by the {self.tuning.judged}{f' of {what}' if what else ' of noise'}: "
                f"as given {best.nominal:.5g}, mean {best.mean:.5g}, "
                f"{100 * self.tuning.quantile:g} % quantile {best.quantile:.5g} {self.tuning.unit}"
            )
            yield (
                f"chosen by {best.searched:.5g} {self.tuning.unit}, which flatters: the table has "
                f"the {self.tuning.judged_by(self.tuning.fresh_draws)} that the search did not have"
            )
        if len(self.spread) > 1:
            low, middle, high = np.percentile(list(self.spread.values()), [0, 50, 100])
            yield (
                f"{len(self.spread)} seeds: best {low:.6g}, median {middle:.6g}, "
                f"worst {high:.6g} {self.tuning.unit}"
            )
        yield from self._of_bands()
        for item in self.tuning.free:
            value = self.parameters[item.name]
            if item.inert:
                yield f"{item.name} does not enter the dynamics: any value is as good"
            elif not _AT_BOUND < item.unit(np.asarray(value)) < 1 - _AT_BOUND:
                told = _told(item, value)
                yield f"{item.name} stands at its bound {told:.4g}: the optimum may lie beyond"

    def _of_bands(self) -> Iterator[str]:
        """Yield what the objective says of the ranges that it is the largest of."""
        finer = over_finer_bands(self.tuning)
        if finer is None:
            return
        for axis, more in zip(self.tuning.over, finer.over, strict=True):
            if not is_band(axis):
                continue
            found = f"the largest of {axis.values.size} values of {axis.name}"
            if isfinite(self.best.finer):
                yield f"{self.tuning.search.objective} is {found}; finer: of {more.values.size}"
            else:
                yield f"{found}; between them it may be larger"


def _told(free: Free, value: float) -> float:
    """Return the value of a design to print: that of a bound where a search has stopped at it."""
    place = float(free.unit(np.asarray(value)))
    if place < _ON_BOUND:
        return free.low
    return free.high if place > 1 - _ON_BOUND else value


def tuned(path: str | os.PathLike[str]) -> Tuned:
    """Return the results of a tuning, from its archive.

    Raises `RequestError` for any other file.
    """
    with read(path) as view:
        tuning = view.request(TUNING, load_tuning)
        seeds, best = view["search"].tolist(), view["search_best"].tolist()
        stage = view["stage"]
        refused = ~np.isfinite(view["objective"]) | (view["status"] != OK)
        return Tuned(
            tuning=tuning,
            optima=tuple(_optima(view, tuning)),
            spread=dict(zip(seeds, best, strict=True)),
            evaluations=int(stage.size),
            refused=int(np.count_nonzero(refused & (stage <= STAGES["polish"]))),
            path=ArchivePath.of(path),
        )


def _optima(view: ArchiveView, tuning: Tuning) -> Iterator[Optimum]:
    if "optimum_objective" not in view:
        return
    objective, causes = view["optimum_objective"], view["perturbation"].tolist()
    finer = view["optimum_finer"] if "optimum_finer" in view else np.full(objective.size, nan)
    rows = view["optimum_evaluation"]
    fresh = view["optimum_fresh" if tuning.draws else "optimum_objective"]
    drawn = {name: view[name][rows].tolist() for name in OF_DRAWS if tuning.draws}
    for name in impacts_of(tuning):
        drawn["impacts"] = view[name][rows].tolist()
    for i in range(objective.size):
        yield Optimum(
            parameters={name: float(view[f"optimum_{name}"][i]) for name in tuning.names},
            objective=float(fresh[i]),
            searched=float(objective[i]),
            robustness=dict(zip(causes, view["robustness"][i].tolist(), strict=True)),
            finer=float(finer[i]),
            **{name: values[i] for name, values in drawn.items()},
        )
