"""Trials of designs, their objective, the log of all trials, and perturbations of an optimum."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import ceil
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.loads.request import is_of_load
from nlds_vines.loads.run import numbers_of
from nlds_vines.model.axis import Axis
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.orbits.batch import Batch, Outcome
from nlds_vines.orbits.starts import random_states
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.store import Blocks
from nlds_vines.tuning.design_space import FRESH_SEED, places_of
from nlds_vines.tuning.request import DETUNING, SHIFT, SIZE, STARTS, STRETCH, TONE, Tuning

HOW = ("detuning", "random_start", "stretch")
"""The columns of a trial after its free parameters [SI].

detuning: a factor on omega; under a load, on the structure's natural frequency.  random_start: 0
for rest, i for the i-th random start.  stretch: a factor on the periods discarded and sampled;
under a load, on the load."""


RESULTS = ("objective", "E2max", "status", "worst_case")
"""The results of a trial: the objective, infinite for an inadmissible design; E2max [J], status and
number of its worst case."""

OF_DRAWS = ("nominal", "mean", "quantile")  # of the objective: the results of draws that follow
# the CF flags of the dataset `stage`
STAGES: Mapping[str, int] = {"global": 0, "polish": 1, "robustness": 2, "surface": 3}
BAND = 5  # values of a parameter from which on they stand for a range rather than for themselves
_FINER = 8  # intervals of a step of such a range, to judge an optimum between its values


def at_rest(points: np.ndarray) -> np.ndarray:
    """Return trials of designs (n, parameters) [SI] without a perturbation, one a row."""
    return np.column_stack([points, np.tile([1.0, 0.0, 1.0], (len(points), 1))])


def impacts_of(tuning: Tuning) -> tuple[str, ...]:
    """Return the name of the column of impacts in the worst case; none without walls."""
    if not tuning.system.scene.walls:
        return ()
    return ("impact_rate",) if tuning.history is None else ("impact_count",)


def results_of(tuning: Tuning) -> tuple[str, ...]:
    return (*RESULTS, *(OF_DRAWS if tuning.draws else ()), *impacts_of(tuning))


class Objective:
    """The objective of one tuning; with `fresh`, over draws none of which the search has."""

    def __init__(self, tuning: Tuning, tell: Tell | None = None, *, fresh: bool = False) -> None:
        self._tuning, self._tell = tuning, tell
        self._cases = tuning.cases()
        draws, seed = tuning.draws, tuning.search.seed
        if fresh:
            draws, seed = tuning.fresh_draws, seed + FRESH_SEED
        self._noise = np.arange(draws + 1)
        self._noise[1:] += tuning.draws * fresh
        self._places = places_of(tuning.uncertain, draws, seed)
        self._batch = None
        if tuning.history is None:
            scene, objective = tuning.system.scene, tuning.search.objective
            self._batch = Batch(scene, tell, float(tuning.tolerance), objective)
        generator = np.random.default_rng(tuning.search.seed)
        self._starts_drawn = generator.uniform(-1.0, 1.0, size=(STARTS, 4))

    def results(self, trials: np.ndarray) -> np.ndarray:
        """Return the results (n, columns) of trials (n, parameters + 3), as in `results_of`."""
        tuning, grid = self._tuning, self._grid(trials)
        if self._batch is None:
            values = worst(outcome_under(tuning, grid, self._tell))
            return over_draws(values, tuning.search.quantile, tuning.quantile)
        cells = tuning.system.cells(grid)
        results = np.empty((len(trials), len(results_of(tuning))))
        # all orbits of a trial from its start, those with equal numbers of periods at once
        start, stretches = trials[:, -2].astype(int), trials[:, -1]
        starts = np.zeros((*cells.shape, 4))
        moved = np.flatnonzero(start)
        if moved.size:
            drawn = random_states(cells[moved], self._starts_drawn, tuning.system.scene)
            starts[moved] = drawn[np.arange(moved.size), :, :, start[moved] - 1]
        for stretch in np.unique(stretches):
            rows = stretches == stretch
            periods = (round(n * stretch) for n in (tuning.transient, tuning.periods))
            values = worst(self._batch.run(cells[rows], starts[rows], *periods))
            results[rows] = over_draws(values, tuning.search.quantile, tuning.quantile)
        return results

    def _grid(self, trials: np.ndarray) -> dict[str, np.ndarray]:
        """Return the parameters of every orbit (trials, draws, cases); draw 0 is nominal."""
        tuning, grid = self._tuning, dict(self._cases)
        shape = len(trials), len(self._places), tuning.case_count
        *points, factor, _, stretch = trials.T[..., np.newaxis, np.newaxis]
        grid |= dict(zip(tuning.names, points, strict=True))
        for i, one in enumerate(tuning.uncertain):
            nominal = grid.get(one.name, np.asarray(tuning.value(one.name)))
            grid[one.name] = one.at(nominal, self._places[:, i, np.newaxis])
        if tuning.history is None:
            grid[tuning.frequency] = grid[tuning.frequency] * factor
        else:
            spring = "k1" if "k1" in tuning.system.parameters else "k"
            stiffness = grid.get(spring, np.asarray(tuning.value(spring)))
            scale = grid.get("scale", np.asarray(tuning.value("scale")))
            grid[spring] = stiffness * (factor * factor)
            grid["scale"] = scale * stretch
            grid["draw"] = self._noise[:, np.newaxis]
        return {name: np.broadcast_to(values, shape) for name, values in grid.items()}


def worst(outcome: Outcome) -> np.ndarray:
    """Return the `RESULTS`, with walls also the impacts, of the worst case along the last axis."""
    value = np.where(outcome.inadmissible, np.inf, outcome.objective)
    case = value.argmax(axis=-1)[..., np.newaxis]

    def of_case(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.take_along_axis(values, case, axis=-1)[..., 0])

    objective = of_case(value)
    second = np.where(np.isfinite(objective), of_case(outcome.E2max), np.nan)
    columns = [objective, second, of_case(outcome.status), case[..., 0]]
    if outcome.impacts is not None:
        columns.append(np.where(np.isfinite(objective), of_case(outcome.impacts), np.nan))
    return np.stack(columns, axis=-1)


def over_draws(results: np.ndarray, judge: float | None, reported: float) -> np.ndarray:
    """Reduce results (designs, draws, columns) over the draws, 0 nominal, to (designs, columns).

    The objective is the quantile `judge`, or the mean, and then `reported` is the other quantile.
    A quantile q, the least value that a share q of the draws does not exceed, may be finite
    although some draws fail; a mean is not.  E2max, status, case and impacts are nominal, but if
    the objective is infinite, the status is that of the first draw that failed.
    """
    nominal, values = results[:, 0], results[:, 1:, 0]
    if not values.shape[1]:
        return nominal
    share = judge or reported
    mean = np.add.reduce(values, axis=1) / values.shape[1]
    quantile = np.sort(values, axis=1)[:, ceil(share * values.shape[1]) - 1]
    objective = mean if judge is None else quantile
    status = nominal[:, 2].copy()
    for i in np.flatnonzero(np.isinf(objective)):
        status[i] = results[i, np.isinf(results[i, :, 0]).argmax(), 2]
    rest = [nominal[:, 1], status, nominal[:, 3], nominal[:, 0], mean, quantile]
    return np.column_stack([objective, *rest, nominal[:, len(RESULTS) :]])


def outcome_under(
    tuning: Tuning, grid: Mapping[str, np.ndarray], tell: Tell | None = None
) -> Outcome:
    """Return the outcomes under the load over a grid of parameters, numbers of the load, `draw`.

    A design whose objective is NaN, as a last time that has not come, is inadmissible.
    """
    history, shape = tuning.history, grid["draw"].shape
    assert history is not None
    orbits = {name: values.ravel() for name, values in grid.items()}
    draws = orbits.pop("draw").tolist()
    of_load = {name: orbits.pop(name).tolist() for name in [*orbits] if is_of_load(name)}

    @cache  # the orbits of one load share its cells
    def load_of(draw: int, *values: float) -> Loading:
        return history.load.redrawn(draw).with_(dict(zip(of_load, values, strict=True)))

    each = [
        load_of(draw, *(values[i] for values in of_load.values())) for i, draw in enumerate(draws)
    ]
    flat = numbers_of(history, tuning.system, orbits, each, tell)
    numbers = {name: values.reshape(shape) for name, values in flat.items()}
    value = numbers[tuning.search.objective]
    impacts = numbers["impact_count"] if tuning.system.scene.walls else None
    return Outcome(value, numbers["E2max"], numbers["status"], numbers["violations"], impacts)


class Log:
    """All evaluations of a tuning, in order; searches reach the objective only through it.

    The evaluations of one call are a block on the disk.  A search depends on its request alone, so
    it is resumed by running it again: saved blocks then replace the kernels' results.
    """

    def __init__(self, tuning: Tuning, store: Blocks, progress: Progress) -> None:
        self.tuning = tuning
        self.replayed = 0  # evaluations that an earlier run has saved
        self._objective = Objective(tuning, progress.wait)
        self._store, self._progress, self._calls = store, progress, 0
        self._blocks: list[np.ndarray] = []
        self._best = np.inf

    def evaluate(self, trials: np.ndarray, stage: str, seed: int) -> np.ndarray:
        """Return the objective (n,) of each trial, infinite for an inadmissible design."""
        results = self._results(self._objective, trials)
        marks = np.tile([STAGES[stage], seed], (len(results), 1))
        self._blocks.append(np.column_stack([trials, results, marks]))
        objectives, unit = results[:, 0], self.tuning.unit
        if stage in ("global", "polish"):
            self._best = min(self._best, float(objectives.min()))
        self._progress.note(objectives.size, f"{stage}, seed {seed}, best {self._best:.5g} {unit}")
        return objectives

    def judged(self, tuning: Tuning, points: np.ndarray, *, fresh: bool = False) -> np.ndarray:
        """Return objectives (n,) by another tuning, or by `fresh` draws, which are not logged."""
        objective = Objective(tuning, self._progress.wait, fresh=fresh)
        return np.array([self._results(objective, at_rest(one))[0, 0] for one in points[:, None]])

    def _results(self, objective: Objective, trials: np.ndarray) -> np.ndarray:
        check()
        key = self._calls
        self._calls += 1
        block, began = self._store.load(key), time.monotonic()
        if block is None:
            results = objective.results(trials)
            self._store.save(key, {"asked": trials, "found": results}, time.monotonic() - began)
            return results
        if not np.array_equal(block["asked"], trials):
            raise RequestError(f"{self._store.folder} does not fit this search: remove it")
        self.replayed += len(block["asked"])
        return block["found"]

    def columns(self) -> dict[str, np.ndarray]:
        names = (*self.tuning.names, *HOW, *results_of(self.tuning), "stage", "seed")
        table = np.concatenate(self._blocks) if self._blocks else np.empty((0, len(names)))
        return dict(zip(names, table.T, strict=True))

    def designs(self, seed: int | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points [SI], objectives and rows in the log of the designs of one or all seeds."""
        columns = self.columns()
        wanted = columns["stage"] <= STAGES["polish"]
        if seed is not None:
            wanted &= columns["seed"] == seed
        rows = np.flatnonzero(wanted)
        points = np.column_stack([columns[name][rows] for name in self.tuning.names])
        return points, columns["objective"][rows], rows


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


def perturbed(tuning: Tuning, point: np.ndarray) -> np.ndarray:
    """Return the trials of a design [SI] under each perturbation; a band is shifted as a whole."""
    every, columns = perturbations(tuning), (*tuning.names, *HOW)
    trials = at_rest(np.tile(point, (len(every), 1)))
    for trial, one in zip(trials, every, strict=True):
        place = columns.index(one.column)
        trial[place] = one.value if one.column == "random_start" else trial[place] * one.value
    for i, name in enumerate(tuning.names):
        # within the range of the parameter, as Poisson's ratio up to 0.5
        trials[:, i] = np.clip(trials[:, i], DESCRIBED[name].low, DESCRIBED[name].high)
    return trials
