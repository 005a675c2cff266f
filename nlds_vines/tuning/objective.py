"""The objective of a design: in the worst of all cases, by default E1max; infinite if it fails.

Where something is uncertain, or noise is drawn, it is the mean or a quantile of that over draws.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import ceil

import numpy as np

from nlds_vines.loads.request import is_of_load, spring_of
from nlds_vines.loads.run import numbers_of
from nlds_vines.model.loads.loading import Loading
from nlds_vines.orbits.batch import Batch, Outcome
from nlds_vines.orbits.starts import random_states
from nlds_vines.runs.progress import Tell
from nlds_vines.tuning.draws import FRESH_SEED, places_of
from nlds_vines.tuning.request import STARTS, Tuning


@dataclass(frozen=True)
class Trials:
    """Designs to evaluate; the arrays have shape (n,), but for the points.

    Arguments: `points` (n, free parameters) in SI units; `detuning`, the factor on omega, or under
    a load on the structure's natural frequency;
    `start`, 0 for rest and i for the i-th random start; `stretch`, the factor on the periods
    discarded and sampled, or on the load.
    """

    points: np.ndarray
    detuning: np.ndarray
    start: np.ndarray
    stretch: np.ndarray

    @classmethod
    def at_rest(cls, points: np.ndarray) -> Trials:
        """Return designs as they are, their orbits begun at rest."""
        one = np.ones(len(points))
        return cls(points, one, np.zeros(len(points)), one)

    @property
    def table(self) -> np.ndarray:
        """All arrays as columns, one row for each trial."""
        return np.column_stack([self.points, self.detuning, self.start, self.stretch])


HOW = ("detuning", "random_start", "stretch")
"""The columns of a trial's table beside its parameters."""

RESULTS = ("objective", "E2max", "status", "worst_case")
"""The columns of the results of a trial: the objective, infinite where the design is inadmissible;
E2max [J], status and number of its worst case."""

OF_DRAWS = ("nominal", "mean", "quantile")
"""The columns that follow where there are draws: the objective as given, and over the draws."""


def impacts_of(tuning: Tuning) -> tuple[str, ...]:
    """Return the name of the column of impacts in the worst case; none without walls."""
    if not tuning.system.scene.walls:
        return ()
    return ("impact_rate",) if tuning.history is None else ("impact_count",)


def results_of(tuning: Tuning) -> tuple[str, ...]:
    """Return the columns of the results of a tuning's trials."""
    return (*RESULTS, *(OF_DRAWS if tuning.draws else ()), *impacts_of(tuning))


class Objective:
    """The objective of one tuning; what all designs share is prepared once."""

    def __init__(self, tuning: Tuning, tell: Tell | None = None, *, fresh: bool = False) -> None:
        """Prepare for designs of `tuning`; `tell` takes what is waited for meanwhile.

        `fresh`: judge by `Tuning.fresh_draws` that share none with those of the search.
        """
        self._tuning, self._tell = tuning, tell
        self._cases = tuning.cases()
        draws, seed = tuning.draws, tuning.search.seed
        self._noise = np.arange(draws + 1)
        if fresh:
            seed += FRESH_SEED
            draws, self._noise = tuning.fresh_draws, np.arange(tuning.fresh_draws + 1)
            self._noise[1:] += tuning.draws
        self._places = places_of(tuning.uncertain, draws, seed)
        self._batch = (
            Batch(tuning.system.scene, tell, float(tuning.tolerance), tuning.search.objective)
            if tuning.history is None
            else None
        )
        generator = np.random.default_rng(tuning.search.seed)
        self._starts_drawn = generator.uniform(-1.0, 1.0, size=(STARTS, 4))

    def results(self, trials: Trials) -> np.ndarray:
        """Return `results_of` each trial (n, columns).

        objective = max over the cases of E1max, or of what the search is told to make small; of
        that the mean, or a quantile, over the draws.
        """
        grid, batch = self._grid(trials), self._batch
        if batch is None:
            outcome = outcome_under(self._tuning, grid, self._tell)
            return over_draws(worst(outcome), self._tuning.search.quantile, self._tuning.quantile)
        cells = self._tuning.system.cells(grid)
        found = np.empty((len(trials.points), len(results_of(self._tuning))))
        starts = self._starts(cells, trials)
        for stretch in np.unique(trials.stretch):
            rows = trials.stretch == stretch
            periods = (round(n * stretch) for n in (self._tuning.transient, self._tuning.periods))
            values = worst(batch.run(cells[rows], starts[rows], *periods))
            found[rows] = over_draws(values, self._tuning.search.quantile, self._tuning.quantile)
        return found

    def _grid(self, trials: Trials) -> dict[str, np.ndarray]:
        """Return what every orbit has, by name: (trials, draws, cases), the first draw as given."""
        tuning, grid = self._tuning, dict(self._cases)
        shape = len(trials.points), len(self._places), tuning.case_count
        for i, name in enumerate(tuning.names):
            grid[name] = trials.points[:, i, np.newaxis, np.newaxis]
        for i, one in enumerate(tuning.uncertain):
            given = grid.get(one.name, np.asarray(tuning.value(one.name)))
            grid[one.name] = one.at(given, self._places[:, i, np.newaxis])
        factor = trials.detuning[:, np.newaxis, np.newaxis]
        if tuning.history is None:
            grid[tuning.frequency] = grid[tuning.frequency] * factor
        else:
            spring = spring_of(tuning.system.parameters)
            stiffness = grid.get(spring, np.asarray(tuning.value(spring)))
            scale = grid.get("scale", np.asarray(tuning.value("scale")))
            grid[spring] = stiffness * (factor * factor)
            grid["scale"] = scale * trials.stretch[:, np.newaxis, np.newaxis]
            grid["draw"] = self._noise[:, np.newaxis]
        return {name: np.broadcast_to(values, shape) for name, values in grid.items()}

    def _starts(self, cells: np.ndarray, trials: Trials) -> np.ndarray:
        """Return the start of each lane, (trials, draws, cases, 4): zeros for rest."""
        starts = np.zeros((*cells.shape, 4))
        moved = np.flatnonzero(trials.start)
        if moved.size:
            drawn = random_states(cells[moved], self._starts_drawn, self._tuning.system.scene)
            which = trials.start[moved].astype(int) - 1
            starts[moved] = drawn[np.arange(moved.size), :, :, which]
        return starts


def worst(outcome: Outcome) -> np.ndarray:
    """Return `RESULTS` of the worst of the cases, along the last axis of an outcome.

    Shape (..., 4); with walls (..., 5), the last its impacts.
    """
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


def over_draws(found: np.ndarray, judge: float | None, told: float) -> np.ndarray:
    """Return the results (designs, columns) of `RESULTS` (designs, draws, 4), the first as given.

    Arguments: the quantile that is to `judge`, None for the mean; the one that is `told`.

    A quantile q is the least value that a share q of the draws does not exceed, so that it may be
    finite where some draws fail; a mean is not.  Energy, status, case and impacts are as given; the
    status that of a draw where this alone makes a design inadmissible.
    """
    given, values = found[:, 0], found[:, 1:, 0]
    if not values.shape[1]:
        return given
    share = judge or told
    mean = np.add.reduce(values, axis=1) / values.shape[1]
    quantile = np.sort(values, axis=1)[:, ceil(share * values.shape[1]) - 1]
    objective = mean if judge is None else quantile
    status = given[:, 2].copy()
    for i in np.flatnonzero(np.isinf(objective)):
        status[i] = found[i, np.isinf(found[i, :, 0]).argmax(), 2]
    rest = [given[:, 1], status, given[:, 3], given[:, 0], mean, quantile]
    return np.column_stack([objective, *rest, given[:, len(RESULTS) :]])


# ---- under a load --------------------------------------------------------------------------------


def outcome_under(
    tuning: Tuning, grid: Mapping[str, np.ndarray], tell: Tell | None = None
) -> Outcome:
    """Return the outcome of every orbit, in the shape of the grid.

    Arguments: the `grid` of parameters, numbers of the load and `draw`, by name, of one shape;
    `tell` takes what is waited for.

    What a number does not tell makes a design inadmissible: a last time that has not come.
    """
    history, shape = tuning.history, grid["draw"].shape
    assert history is not None
    lanes = {name: values.ravel() for name, values in grid.items()}
    draws = lanes.pop("draw").tolist()
    of_load = {name: lanes.pop(name).tolist() for name in [*lanes] if is_of_load(name)}

    @cache  # the orbits of one load share its cells
    def load_of(draw: int, *values: float) -> Loading:
        return history.load.redrawn(draw).with_(dict(zip(of_load, values, strict=True)))

    each = [
        load_of(draw, *(values[i] for values in of_load.values())) for i, draw in enumerate(draws)
    ]
    told = numbers_of(history, tuning.system, lanes, each, tell)
    found = {name: values.reshape(shape) for name, values in told.items()}
    value = found[tuning.search.objective]
    impacts = found["impact_count"] if tuning.system.scene.walls else None
    return Outcome(value, found["E2max"], found["status"], found["violations"], value, impacts)
