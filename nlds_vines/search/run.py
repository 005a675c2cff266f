"""A tuning from its request to its archive: search, polish, disturb the winners, draw the grid."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from nlds_vines import archive, durable
from nlds_vines.engine import Interrupted, use_threads
from nlds_vines.parameters import CONTACT
from nlds_vines.provenance import attributes
from nlds_vines.search import layout
from nlds_vines.search.free import units_of, values_of
from nlds_vines.search.journal import Journal
from nlds_vines.search.log import Log
from nlds_vines.search.methods import Evaluate, polish, search_globally
from nlds_vines.search.objective import Trials
from nlds_vines.search.optima import distinct, perturbed
from nlds_vines.search.progress import Progress
from nlds_vines.search.request import Tuning

PROMISING = 0.25
"""How much worse than the best, relatively, a design may be that is worth a local search."""


def run(
    tuning: Tuning,
    output: Path,
    *,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = True,
) -> None:
    """Do a tuning into the archive `output`.

    `threads` None takes all processors.  Raises `Interrupted` on Ctrl-C, with every evaluation
    kept for `resume`, and `RequestError` where the archive cannot be had.
    """
    used, began = use_threads(threads), time.perf_counter()
    with Journal.open(output, tuning, resume=resume, overwrite=overwrite) as journal:
        if journal.complete:
            return
        known = journal.begin()
        for line in journal.discarded:
            print(line, file=sys.stderr)
        try:
            with Progress(tuning.most_evaluations, quiet) as progress:
                found = _findings(tuning, Log(tuning, journal, progress))
            spent = round(time.perf_counter() - began, 3)
            more = {"threads": used, "seconds": spent, "replayed": known}
            _store(tuning, found, journal, more)
        except KeyboardInterrupt:
            journal.flush()
            raise Interrupted(
                f"interrupted: {journal.length} evaluations are kept in {journal.folder}; "
                "the same command with --resume (in place of --overwrite) goes on from there"
            ) from None


def _findings(tuning: Tuning, log: Log) -> layout.Findings:
    """Search with every seed, and look at what was found from all sides."""
    spread = np.array([_search(tuning, log, seed) for seed in tuning.search.all_seeds])
    search = tuning.search
    points, values, rows = log.designs()
    chosen = _distinct(tuning, points, values, search.within)
    robustness = [
        log.evaluate(perturbed(tuning, point), "robustness", search.seed)
        for point in points[chosen]
    ]
    surface = _surface(tuning, log, points[chosen[0]]) if chosen.size else None
    width = len(perturbed(tuning, points[0]).start)
    return layout.Findings(
        columns=log.columns(),
        optima=rows[chosen],
        robustness=np.array(robustness).reshape(-1, width),
        surface=surface,
        spread=spread,
    )


def _search(tuning: Tuning, log: Log, seed: int) -> float:
    """Search globally, then around what was most promising; return the best objective [J]."""

    def evaluate(stage: str) -> Evaluate:
        def of(units: np.ndarray) -> np.ndarray:
            return log.evaluate(Trials.at_rest(values_of(tuning.free, units)), stage, seed)

        return of

    search = tuning.search
    search_globally(evaluate("global"), len(tuning.free), search, seed)
    points, values, _ = log.designs(seed)
    for i in _distinct(tuning, points, values, PROMISING):
        start = units_of(tuning.free, points[i : i + 1])[0]
        polish(evaluate("polish"), np.clip(start, 0.0, 1.0), search.polish)
    return float(log.designs(seed)[1].min(initial=np.inf))


def _distinct(tuning: Tuning, points: np.ndarray, values: np.ndarray, within: float) -> np.ndarray:
    """Return the indices of distinct good designs, told apart by what enters the dynamics."""
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


def _store(
    tuning: Tuning, found: layout.Findings, journal: Journal, more: Mapping[str, float]
) -> None:
    """Write the archive, put it in its place and let the journal go."""
    journal.flush()
    temporary = journal.folder / "archive.tmp"
    attrs = attributes(tuning, {"content": "tuning", **more})
    derived = ("K",) if set(CONTACT) & set(tuning.names) else ()
    for name in (*tuning.names, *derived):  # what is free has no value of its own
        attrs.pop(name, None)
    dims, contents = layout.scales(tuning, found), layout.contents(tuning, found)
    with durable.in_one_line(f"write {journal.path} (the journal is intact, use --resume)"):
        archive.write_arrays(temporary, attrs, dims, contents)
    journal.finish(temporary)
