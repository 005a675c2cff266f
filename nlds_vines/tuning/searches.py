"""The searches: two global ones, by whole generations, and a local one.

All of them work in the unit cube that the bounds span; a design is a point in it.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.tuning.request import Search

Evaluate = Callable[[np.ndarray], np.ndarray]
"""The objective [J] (n,) of points (n, parameters) in the unit cube."""

_CONTRACTED = 1e-4  # spread of a generation's objectives relative to their mean: the search ends
_SIMPLEX = 0.03  # first steps of the local search, in the unit cube
_SMALLEST = 1e-5  # its last ones
_FIRST_STEP = 0.3  # of CMA-ES: standard deviation of its first generation
_INADMISSIBLE = 1e30  # J, in place of infinity, with which CMA-ES cannot compute


def search_globally(
    evaluate: Evaluate, dimension: int, search: Search, seed: int, first: np.ndarray | None = None
) -> None:
    """Run the global search of the request; its evaluations stand in the log.

    Arguments: `first`, a point of the unit cube that the search begins with, where one is known.

    Raises `RequestError` where it needs a package that is not installed.
    """
    run = {"de": _differential_evolution, "cma": _cma}[search.method]
    run(evaluate, dimension, search, seed, first)


def check_installed(method: str) -> None:
    """Raise `RequestError` where a search needs a package that is not installed."""
    if method == "cma" and importlib.util.find_spec("cma") is None:
        raise RequestError(
            "search method 'cma' needs the package cma: pip install 'nlds-vines[cma]'; "
            "without it there is 'de'"
        )


def polish(evaluate: Evaluate, start: np.ndarray, most: int) -> None:
    """Search around a point of the unit cube by Nelder and Mead's simplices (the paper's choice).

    It takes at most `most` evaluations, which stand in the log; the bounds hold.

    Source: F. Gao and L. Han, Implementing the Nelder-Mead simplex algorithm with adaptive
    parameters, Comput. Optim. Appl. 51 (2012), as SciPy has it.
    """
    from scipy.optimize import minimize

    if most <= start.size:  # too few evaluations for the first simplex
        return
    steps = np.where(start + _SIMPLEX <= 1.0, _SIMPLEX, -_SIMPLEX)
    minimize(
        lambda point: float(evaluate(point[np.newaxis, :])[0]),
        start,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * start.size,
        options={
            "initial_simplex": np.vstack([start, start + np.diag(steps)]),
            "maxfev": most,
            "maxiter": most,
            "xatol": _SMALLEST,
            "fatol": 1e-9,
        },
    )


def _differential_evolution(
    evaluate: Evaluate, dimension: int, search: Search, seed: int, first: np.ndarray | None
) -> None:
    """Run SciPy's differential evolution (best1bin), a generation at a time.

    Source: R. Storn and K. Price, Differential evolution, J. Global Optim. 11 (1997).
    """
    from scipy.optimize import differential_evolution

    generator = np.random.default_rng(seed)
    population = latin_hypercube(search.population, dimension, generator)
    if first is not None:
        population[0] = first
    try:
        differential_evolution(
            lambda points: evaluate(np.ascontiguousarray(points.T)),
            bounds=[(0.0, 1.0)] * dimension,
            init=population,
            maxiter=search.generations,
            tol=_CONTRACTED,
            seed=generator,
            polish=False,
            vectorized=True,
            updating="deferred",
        )
    except RuntimeError as error:  # SciPy takes a ValueError of the objective for one of its own
        if isinstance(error.__cause__, RequestError):
            raise error.__cause__ from None
        raise


def latin_hypercube(count: int, dimension: int, generator: np.random.Generator) -> np.ndarray:
    """Return points (count, dimension) in the unit cube: each of `count` slices holds one of them.

    Source: M. D. McKay et al., Technometrics 21 (1979).
    """
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
        options = {
            "bounds": [0.0, 1.0],
            "popsize": search.population,
            "seed": int(generator.integers(1, 2**31)),
            "verbose": -9,
        }
        start = generator.random(dimension) if first is None else first
        strategy, first = cma.CMAEvolutionStrategy(start, _FIRST_STEP, options), None
        while left >= search.population and not strategy.stop():
            points = np.array(strategy.ask())
            found = evaluate(np.clip(points, 0.0, 1.0))
            strategy.tell(list(points), np.minimum(found, _INADMISSIBLE).tolist())
            left -= search.population
