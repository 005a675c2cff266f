"""A tuning from request to archive: search, polish, disturb the optima, compute the surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nlds_vines.cli.running import RunOptions
from nlds_vines.model.parameters import CONTACT
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Blocks, Write
from nlds_vines.tuning import tuning_table
from nlds_vines.tuning.evaluations import Log
from nlds_vines.tuning.free_parameter import units_of, values_of
from nlds_vines.tuning.objective import Trials
from nlds_vines.tuning.optima import distinct, over_finer_bands, perturbed
from nlds_vines.tuning.request import Tuning
from nlds_vines.tuning.searches import Evaluate, polish, search_globally

PROMISING = 0.25
"""How much worse than the best, relatively, a design may be from which a local search begins."""


def run(tuning: Tuning, output: Path, how: RunOptions | None = None) -> None:
    """Do a tuning into the archive `output`.

    Arguments: `how` the run goes, None for the defaults of `RunOptions`; there are no shards.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every evaluation kept for --resume,
    and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    store = Blocks(output, tuning)

    def work() -> Write:
        most = tuning.most_evaluations
        with Progress(most, "design", quiet=how.quiet, at_most=True) as progress:
            log = Log(tuning, store, progress)
            found = _findings(tuning, log)
        derived = ("K",) if set(CONTACT) & set(tuning.names) else ()
        free = (*tuning.names, *derived)  # what is free has no value of its own
        scales, contents = tuning_table.scales(tuning, found), tuning_table.contents(tuning, found)
        return store.writer(scales, contents, free, replayed=log.replayed)

    store.carry_out(how, work)


def _findings(tuning: Tuning, log: Log) -> tuning_table.Findings:
    """Search with every seed; disturb the optima, and compute the surface through the best."""
    spread = np.array([_search(tuning, log, seed) for seed in tuning.search.all_seeds])
    search = tuning.search
    points, values, rows = log.designs()
    chosen = _distinct(tuning, points, values, search.within)
    robustness = [
        log.evaluate(perturbed(tuning, point), "robustness", search.seed)
        for point in points[chosen]
    ]
    surface = _surface(tuning, log, points[chosen[0]]) if chosen.size else None
    finer = over_finer_bands(tuning) if chosen.size else None
    width = len(perturbed(tuning, points[0]).start)
    return tuning_table.Findings(
        columns=log.columns(),
        optima=rows[chosen],
        robustness=np.array(robustness).reshape(-1, width),
        surface=surface,
        spread=spread,
        finer=None if finer is None else log.judged(finer, points[chosen]),
        fresh=log.judged(tuning, points[chosen], fresh=True) if tuning.draws else None,
    )


def _search(tuning: Tuning, log: Log, seed: int) -> float:
    """Search globally, then around the best designs of it; return the best objective [J]."""

    def evaluate(stage: str) -> Evaluate:
        def of(units: np.ndarray) -> np.ndarray:
            return log.evaluate(Trials.at_rest(values_of(tuning.free, units)), stage, seed)

        return of

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
    counts = [i for i, parameter in enumerate(tuning.free) if not parameter.inert]
    units = units_of(tuning.free, points)[:, counts]
    return distinct(units, values, within, tuning.search.apart, tuning.search.optima)


def _surface(
    tuning: Tuning, log: Log, best: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Evaluate the grid through the best design, a row at a time; None where none is asked for."""
    if tuning.surface is None:
        return None
    first, second = (tuning.names.index(name) for name in tuning.surface.parameters)
    places = np.linspace(0.0, 1.0, tuning.surface.size)
    across, up = tuning.free[first].value(places), tuning.free[second].value(places)
    rows = []
    for value in across:
        points = np.tile(best, (up.size, 1))
        points[:, first], points[:, second] = value, up
        rows.append(log.evaluate(Trials.at_rest(points), "surface", tuning.search.seed))
    return across, up, np.array(rows)
