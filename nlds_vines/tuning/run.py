"""A tuning from request to archive: search, polish, perturb the optima, compute the surface.

The searches work in the unit cube that the bounds span; a design is a point in it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from nlds_vines.cli.running import RunOptions
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import CONTACT
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Blocks, Write
from nlds_vines.tuning.design_space import units_of, values_of
from nlds_vines.tuning.objective import Log, at_rest, over_finer_bands, perturbed
from nlds_vines.tuning.request import Search, Tuning, check_installed
from nlds_vines.tuning.result import contents, scales

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
    store = Blocks(output, tuning)

    def work() -> Write:
        search = tuning.search
        with Progress(tuning.most_evaluations, "design", quiet=how.quiet, at_most=True) as progress:
            log = Log(tuning, store, progress)
            spread = [_search(tuning, log, seed) for seed in search.all_seeds]
            points, values, rows = log.designs()
            chosen = _distinct(tuning, points, values, search.within)
            best, judged = points[chosen], {"search_best": np.array(spread)}
            tested = [log.evaluate(perturbed(tuning, p), "robustness", search.seed) for p in best]
            judged["robustness"] = np.array(tested)
            if chosen.size and tuning.surface is not None:
                (first, across), (second, up) = tuning.surface_values().items()
                points = np.tile(best[0], (up.size, 1))
                points[:, tuning.names.index(second)] = up
                rows_of_surface = []
                for value in across:
                    points[:, tuning.names.index(first)] = value
                    objectives = log.evaluate(at_rest(points), "surface", search.seed)
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


def _search(tuning: Tuning, log: Log, seed: int) -> float:
    """Search globally, then around the best designs; return the best objective."""

    def evaluate(stage: str) -> Evaluate:
        def objective(units: np.ndarray) -> np.ndarray:
            return log.evaluate(at_rest(values_of(tuning.free, units)), stage, seed)

        return objective

    search = tuning.search
    first = tuning.first_design
    if first is not None:
        first = np.clip(units_of(tuning.free, first[np.newaxis, :])[0], 0.0, 1.0)
    search_globally(evaluate("global"), len(tuning.free), search, seed, first)
    points, values, _ = log.designs(seed)
    for i in _distinct(tuning, points, values, PROMISING):
        start = units_of(tuning.free, points[i : i + 1])[0]
        polish(evaluate("polish"), np.clip(start, 0.0, 1.0), search.polish)
    return float(log.designs(seed)[1].min(initial=np.inf))


def _distinct(tuning: Tuning, points: np.ndarray, values: np.ndarray, within: float) -> np.ndarray:
    """Return the indices of good designs that differ in parameters that enter the dynamics."""
    active = [i for i, item in enumerate(tuning.free) if not item.inert]
    units = units_of(tuning.free, points)[:, active]
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
