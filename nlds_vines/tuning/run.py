"""A tuning from request to archive: search, polish, perturb the optima, compute the surface.

The searches work in the unit cube that the bounds span; a design is a point in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import ceil
from pathlib import Path

import numpy as np

from nlds_vines.engine.batch import Outcome
from nlds_vines.errors import RequestError
from nlds_vines.loads.datasets import names_of_numbers
from nlds_vines.loads.run import numbers_of
from nlds_vines.model.parameters import CONTACT, DESCRIBED
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore, Write
from nlds_vines.tuning.batch_of_designs import Batch
from nlds_vines.tuning.design_space import FRESH_SEED, places_of, units_of, values_of
from nlds_vines.tuning.request import MEAN, MEDIAN, STARTS, Search, Tuning, check_installed
from nlds_vines.tuning.result import (
    HOW,
    RESULTS,
    STAGES,
    contents,
    over_finer_bands,
    perturbations,
    results_of,
    scales,
)

Evaluate = Callable[[np.ndarray], np.ndarray]  # of points (n, parameters) in the unit cube

PROMISING = 0.25  # a local search starts where the objective exceeds the best by so much at most
_CONTRACTED = 1e-4  # spread of a generation's objectives relative to their mean that ends a search
_SIMPLEX = 0.03  # first steps of the local search, in the unit cube
_SMALLEST = 1e-5  # its last steps
_FIRST_STEP = 0.3  # of CMA-ES: standard deviation of its first generation
_INADMISSIBLE = 1e30  # in place of infinity, with which CMA-ES cannot compute


def run(tuning: Tuning, output: Path, how: RunOptions | None = None) -> None:
    """Search, test the optima, compute the surface through the best, and write the archive.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with all finished blocks saved.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    store = BlockStore(output, tuning)

    def work() -> Write:
        search = tuning.search
        with Progress(tuning.most_evaluations, "design", quiet=how.quiet, at_most=True) as progress:
            log = Log(tuning, store, progress)
            layouts = range(len(tuning.layouts))
            spread = [
                min(_search(tuning, log, seed, layout) for layout in layouts)
                for seed in search.all_seeds
            ]
            designs, values, rows = log.designs()
            chosen = _distinct(tuning, designs, values, search.within)
            best, judged = designs[chosen], {"search_best": np.array(spread)}
            tested = [log.evaluate(perturbed(tuning, d), "robustness", search.seed) for d in best]
            judged["robustness"] = np.array(tested)
            if chosen.size and tuning.surface is not None:
                (first, across), (second, up) = tuning.surface_values().items()
                trials = np.tile(best[0], (up.size, 1))
                trials[:, tuning.names.index(second)] = up
                rows_of_surface = []
                for value in across:
                    trials[:, tuning.names.index(first)] = value
                    objectives = log.evaluate(trials.copy(), "surface", search.seed)
                    rows_of_surface.append(objectives)
                judged["surface"] = np.array(rows_of_surface)
            columns, finer = log.columns(), over_finer_bands(tuning)
            if finer is not None:
                judged["optimum_finer"] = log.judged(finer, best)
            if tuning.draws:
                judged["optimum_fresh"] = log.judged(tuning, best, fresh=True)
        derived = ("K",) if set(CONTACT) & set(tuning.names) else ()
        free = (*tuning.names, *derived)  # the archive has no single value of a free parameter
        dims = scales(tuning, len(columns["objective"]), chosen.size)
        datasets = contents(tuning, columns, rows[chosen], judged)
        return store.writer(dims, datasets, free, replayed=log.replayed)

    store.carry_out(how, work)


def _search(tuning: Tuning, log: Log, seed: int, layout: int) -> float:
    """Search globally, then around the best designs; return the best objective."""

    def evaluate(stage: str) -> Evaluate:
        def objective(units: np.ndarray) -> np.ndarray:
            return log.evaluate(at_rest(values_of(tuning.free, units), layout), stage, seed)

        return objective

    search = tuning.search
    first = tuning.first_design
    if first is not None:
        first = np.clip(units_of(tuning.free, first[np.newaxis, :])[0], 0.0, 1.0)
    search_globally(evaluate("global"), len(tuning.free), search, seed, first)
    designs, values, _ = log.designs(seed, layout)
    for i in _distinct(tuning, designs, values, PROMISING):
        start = units_of(tuning.free, designs[i : i + 1])[0]
        polish(evaluate("polish"), np.clip(start, 0.0, 1.0), search.polish)
    return float(log.designs(seed, layout)[1].min(initial=np.inf))


def _distinct(tuning: Tuning, designs: np.ndarray, values: np.ndarray, within: float) -> np.ndarray:
    """Return the indices of good designs that differ in their layout or in the dynamics."""
    active = [i for i, item in enumerate(tuning.free) if not item.inert]
    layouts = designs[:, len(tuning.free) + HOW.index("layout")]
    units = np.column_stack([units_of(tuning.free, designs)[:, active], layouts])
    return distinct(units, values, within, tuning.search.apart, tuning.search.optima)


def distinct(
    units: np.ndarray, values: np.ndarray, within: float, apart: float, most: int
) -> np.ndarray:
    """Return the indices of good designs (n, parameters) of the unit cube, the best first.

    `within` is their largest relative excess over the best objective, `apart` their distance.
    """
    limit = values.min(initial=np.inf) * (1 + within)
    candidates = np.flatnonzero(np.isfinite(values) & (values <= limit))
    left = candidates[np.argsort(values[candidates], kind="stable")]
    chosen: list[int] = []
    while left.size and len(chosen) < most:
        chosen.append(int(left[0]))
        distance = np.linalg.norm(units[left] - units[left[0]], axis=1)
        left = left[distance >= apart]
    return np.array(chosen, dtype=int)


def search_globally(
    evaluate: Evaluate, dimension: int, search: Search, seed: int, first: np.ndarray | None = None
) -> None:
    """Run the global search of a request, by whole generations; the log has its evaluations.

    Differential evolution (best1bin; R. Storn and K. Price, J. Global Optim. 11, 1997) has a Latin
    hypercube (M. D. McKay et al., Technometrics 21, 1979) with the point `first` of the unit cube
    as its first generation; CMA-ES starts from that point.
    """
    from scipy.optimize import differential_evolution

    if search.method == "cma":
        _cma(evaluate, dimension, search, seed, first)
        return
    generator = np.random.default_rng(seed)
    population = latin_hypercube(search.population, dimension, generator)
    if first is not None:
        population[0] = first
    try:
        differential_evolution(
            lambda points: evaluate(np.ascontiguousarray(points.T)),
            bounds=[(0.0, 1.0)] * dimension, init=population, maxiter=search.generations,
            tol=_CONTRACTED, seed=generator, polish=False, vectorized=True, updating="deferred",
        )  # fmt: skip
    except RuntimeError as error:  # SciPy takes a ValueError of the objective for one of its own
        if isinstance(error.__cause__, RequestError):
            raise error.__cause__ from None
        raise


def latin_hypercube(count: int, dimension: int, generator: np.random.Generator) -> np.ndarray:
    """Return points (count, dimension) of the unit cube, one in each of `count` slices per axis."""
    order = np.stack([generator.permutation(count) for _ in range(dimension)], axis=1)
    return (order + generator.random((count, dimension))) / count


def _cma(
    evaluate: Evaluate, dimension: int, search: Search, seed: int, first: np.ndarray | None
) -> None:
    """Run CMA-ES with restarts from random points until the evaluations are used up.

    Source: N. Hansen and A. Ostermeier, Evolutionary Computation 9 (2001).
    """
    check_installed("cma")
    import cma

    generator = np.random.default_rng(seed)
    left = search.population * (search.generations + 1)
    while left >= search.population:
        number = int(generator.integers(1, 2**31))
        sizes = {"bounds": [0.0, 1.0], "popsize": search.population}
        options = {**sizes, "seed": number, "verbose": -9}
        start = generator.random(dimension) if first is None else first
        strategy, first = cma.CMAEvolutionStrategy(start, _FIRST_STEP, options), None
        while left >= search.population and not strategy.stop():
            points = np.array(strategy.ask())
            values = evaluate(np.clip(points, 0.0, 1.0))
            strategy.tell(list(points), np.minimum(values, _INADMISSIBLE).tolist())
            left -= search.population


def polish(evaluate: Evaluate, start: np.ndarray, most: int) -> None:
    """Search around a point of the unit cube by `most` evaluations, which the log has.

    Source: J. A. Nelder and R. Mead, A simplex method for function minimization, Computer J. 7
    (1965) 308-313, as SciPy implements it.
    """
    from scipy.optimize import minimize

    if most <= start.size:  # too few evaluations for the first simplex
        return
    steps = np.where(start + _SIMPLEX <= 1.0, _SIMPLEX, -_SIMPLEX)
    options = {"maxfev": most, "maxiter": most, "xatol": _SMALLEST, "fatol": 1e-9}
    minimize(
        lambda point: float(evaluate(point[np.newaxis, :])[0]),
        start,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * start.size,
        options={"initial_simplex": np.vstack([start, start + np.diag(steps)]), **options},
    )


# ---- objectives of designs -----------------------------------------------------------------------


def at_rest(points: np.ndarray, layout: int = 0) -> np.ndarray:
    """Return trials of designs (n, parameters) [SI] without a perturbation, one a row."""
    return np.column_stack([points, np.tile([layout, 1.0, 0.0, 1.0], (len(points), 1))])


class Objective:
    """The objective of one tuning; with `fresh`, over draws none of which the search has."""

    def __init__(self, tuning: Tuning, tell: Tell | None = None, *, fresh: bool = False) -> None:
        self._tuning, self._tell = tuning, tell
        placed = (tuning.system.with_(**one) for one in tuning.layouts if tuning.places)
        tunings = [replace(tuning, system=system, places={}) for system in placed]
        self._placed = [Objective(one, tell, fresh=fresh) for one in tunings]
        self._cases = tuning.cases()
        draws, seed = tuning.draws, tuning.search.seed
        if fresh:
            draws, seed = tuning.fresh_draws, seed + FRESH_SEED
        self._noise = np.arange(draws + 1)
        self._noise[1:] += tuning.draws * fresh
        self._places = places_of(tuning.uncertain, draws, seed)
        self._batch: Batch | None = None
        if tuning.history is None:
            objective = tuning.search.objective
            self._batch = Batch(tuning.system, objective, float(tuning.tolerance), tell)
            generator = np.random.default_rng(tuning.search.seed)
            drawn = generator.uniform(-1.0, 1.0, size=(STARTS, self._batch.start_size))
            self._starts_drawn = drawn

    def results(self, trials: np.ndarray) -> np.ndarray:
        """Return the results (n, columns) of trials (n, parameters + 4), as in `results_of`."""
        tuning = self._tuning
        if self._placed:  # the trials of one call have one layout
            return self._placed[int(trials[0, len(tuning.free)])].results(trials)
        grid = self._grid(trials)
        if self._batch is None:
            values = judged_cases(tuning, outcome_under(tuning, grid, self._tell))
            return over_draws(values, tuning.search.quantile, tuning.quantile)
        cells = tuning.system.cells(grid)
        results = np.empty((len(trials), len(results_of(tuning))))
        # all orbits of a trial from its start, those with equal numbers of periods at once
        start, stretches = trials[:, -2].astype(int), trials[:, -1]
        starts = np.zeros((*cells.shape, self._starts_drawn.shape[1]))
        moved = np.flatnonzero(start)
        if moved.size:
            drawn = self._batch.random_states(cells[moved], self._starts_drawn)
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
        *points, _, factor, _, stretch = trials.T[..., np.newaxis, np.newaxis]
        grid |= dict(zip(tuning.names, points, strict=True))
        for i, one in enumerate(tuning.uncertain):
            nominal = grid.get(one.name, np.asarray(tuning.value(one.name)))
            grid[one.name] = one.at(nominal, self._places[:, i, np.newaxis])
        if tuning.history is None:
            grid[tuning.frequency] = grid[tuning.frequency] * factor
        else:
            spring = tuning.system.stiffness
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


def judged_cases(tuning: Tuning, outcome: Outcome) -> np.ndarray:
    """Return `worst`, whose objective is the number over the records of a suite, if one is asked.

    The other columns are those of the worst record, also of one that failed.
    """
    results = worst(outcome)
    if not tuning.has_number_over_records:
        return results
    value = np.where(outcome.inadmissible, np.inf, outcome.objective)
    by_record = value.reshape(*value.shape[:-1], -1, tuning.record_count)
    results[..., 0] = over_records(by_record, tuning.search.records).max(axis=-1)
    return results


def over_records(values: np.ndarray, word: str) -> np.ndarray:
    """Return the number of `OVER_RECORDS` over the last axis; infinite values are the largest."""
    count = values.shape[-1]
    if word == MEAN:
        return np.add.reduce(values, axis=-1) / count
    ascending = np.sort(values, axis=-1)
    place = (0.5 if word == MEDIAN else 0.84) * (count - 1)
    below = ascending[..., int(place)]
    above = ascending[..., ceil(place)]
    with np.errstate(invalid="ignore"):
        between = below + (place - int(place)) * (above - below)
    return np.where(below == above, below, between)


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
    assert tuning.history is not None
    (system,) = tuning.history.systems
    orbits = {name: values.ravel() for name, values in grid.items()}
    arrays, shape = numbers_of(tuning.history, system, orbits, tell), grid["draw"].shape
    dataset, place = names_of_numbers(tuning.history)[tuning.search.objective]
    missing = np.full(grid["draw"].size, np.nan)
    value = arrays.get(dataset, missing)
    if dataset in arrays and place is not None:
        value = value[:, place]
    E2max = arrays.get("E2max", missing)
    if E2max.ndim > 1:  # of all dampers
        with np.errstate(invalid="ignore"):
            E2max = np.fmax.reduce(E2max, axis=1, initial=0.0)
    impacts = arrays.get("impact_count")
    if impacts is not None:
        has_failed = impacts.reshape(len(impacts), -1).min(axis=1) < 0
        total = np.maximum(impacts, 0).reshape(len(impacts), -1).sum(axis=1)
        impacts = np.where(has_failed, np.nan, total)
    if dataset == "impact_count":
        value = np.where(value < 0, np.nan, value)
    return Outcome(
        value.reshape(shape), E2max.reshape(shape), arrays["status"].reshape(shape),
        arrays["violations"].reshape(shape),
        impacts.reshape(shape) if impacts is not None and tuning.system.scene.walls else None,
    )  # fmt: skip


class Log:
    """All evaluations of a tuning, in order; searches reach the objective only through it.

    The evaluations of one call are a block on the disk.  A search depends on its request alone, so
    it is resumed by running it again: saved blocks then replace the kernels' results.
    """

    def __init__(self, tuning: Tuning, store: BlockStore, progress: Progress) -> None:
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

    def judged(self, tuning: Tuning, designs: np.ndarray, *, fresh: bool = False) -> np.ndarray:
        """Return objectives (n,) by another tuning, or by `fresh` draws, which are not logged."""
        objective = Objective(tuning, self._progress.wait, fresh=fresh)
        return np.array([self._results(objective, one)[0, 0] for one in designs[:, None]])

    def _results(self, objective: Objective, trials: np.ndarray) -> np.ndarray:
        check()
        key = self._calls
        self._calls += 1
        block, began = self._store.load(key), time.monotonic()
        if block is not None and not np.array_equal(block["asked"], trials):
            self._store.refuse(key, "it holds other designs")
            block = None
        if block is None:
            results = objective.results(trials)
            self._store.save(key, {"asked": trials, "found": results}, time.monotonic() - began)
            return results
        self.replayed += len(block["asked"])
        return block["found"]

    def columns(self) -> dict[str, np.ndarray]:
        names = (*self.tuning.names, *HOW, *results_of(self.tuning), "stage", "seed")
        table = np.concatenate(self._blocks) if self._blocks else np.empty((0, len(names)))
        return dict(zip(names, table.T, strict=True))

    def designs(
        self, seed: int | None = None, layout: int = 0
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return designs as trials, objectives and rows in the log, of a search or of all."""
        columns = self.columns()
        wanted = columns["stage"] <= STAGES["polish"]
        if seed is not None:
            wanted &= (columns["seed"] == seed) & (columns["layout"] == layout)
        rows = np.flatnonzero(wanted)
        designs = np.column_stack([columns[name][rows] for name in (*self.tuning.names, *HOW)])
        return designs, columns["objective"][rows], rows


def perturbed(tuning: Tuning, design: np.ndarray) -> np.ndarray:
    """Return the trials of a design under each perturbation; a band is shifted as a whole."""
    every, columns = perturbations(tuning), (*tuning.names, *HOW)
    trials = np.tile(design, (len(every), 1))
    for trial, one in zip(trials, every, strict=True):
        place = columns.index(one.column)
        trial[place] = one.value if one.column == "random_start" else trial[place] * one.value
    for i, name in enumerate(tuning.names):
        # within the range of the parameter, as Poisson's ratio up to 0.5
        trials[:, i] = np.clip(trials[:, i], DESCRIBED[name].low, DESCRIBED[name].high)
    return trials
