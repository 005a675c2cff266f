"""The log of a search: every evaluation in order; those of one call of the objective are a block.

A search depends on its request alone: run again, it asks for the same designs in the same order.
So it is resumed by running it again, with results of saved blocks in place of those of the kernels.
"""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Blocks
from nlds_vines.tuning.objective import HOW, Objective, Trials, results_of
from nlds_vines.tuning.request import Tuning

STAGES: Mapping[str, int] = {"global": 0, "polish": 1, "robustness": 2, "surface": 3}
"""The parts of a search by name: the CF flags of the dataset `stage`."""


class Log:
    """All evaluations of a tuning, in order; searches reach the objective only through it."""

    def __init__(self, tuning: Tuning, store: Blocks, progress: Progress) -> None:
        """Begin with no evaluation."""
        self.tuning = tuning
        self.replayed = 0  # evaluations that an earlier run has saved
        self._objective = Objective(tuning, progress.wait)
        self._store, self._progress, self._calls = store, progress, 0
        self._blocks: list[np.ndarray] = []
        self._best = np.inf

    def evaluate(self, trials: Trials, stage: str, seed: int) -> np.ndarray:
        """Return the objective [J] of each trial (n,), infinite where inadmissible.

        Raises `interrupts.Stopped` when a signal has asked to stop.
        """
        asked, found = trials.table, self._results(self._objective, trials)
        marks = np.tile([STAGES[stage], seed], (len(asked), 1))
        self._blocks.append(np.column_stack([asked, found, marks]))
        self._show(found[:, 0], stage, seed)
        return found[:, 0]

    def judged(self, tuning: Tuning, points: np.ndarray, *, fresh: bool = False) -> np.ndarray:
        """Return the objectives (n,) of designs by another tuning, or by `fresh` draws; no search.

        Raises `interrupts.Stopped` when a signal has asked to stop.
        """
        objective = Objective(tuning, self._progress.wait, fresh=fresh)
        return np.array(
            [self._results(objective, Trials.at_rest(one))[0, 0] for one in points[:, None]]
        )

    def _results(self, objective: Objective, trials: Trials) -> np.ndarray:
        """Return the results of trials, which are a block from then on."""
        check()
        asked, key = trials.table, self._calls
        self._calls += 1
        block, began = self._store.load(key), time.monotonic()
        if block is None:
            found = objective.results(trials)
            arrays = {"asked": asked, "found": found}
            self._store.save(key, arrays, time.monotonic() - began)
            return found
        if not np.array_equal(block["asked"], asked):
            raise RequestError(f"{self._store.folder} does not fit this search: remove it")
        self.replayed += len(asked)
        return block["found"]

    def _show(self, objectives: np.ndarray, stage: str, seed: int) -> None:
        """Show the part of the search and the best objective so far beside the progress."""
        unit = self.tuning.unit
        if stage in ("global", "polish"):
            self._best = min(self._best, float(objectives.min()))
        self._progress.note(objectives.size, f"{stage}, seed {seed}, best {self._best:.5g} {unit}")

    def columns(self) -> dict[str, np.ndarray]:
        """Return everything evaluated so far, by column."""
        names = (*self.tuning.names, *HOW, *results_of(self.tuning), "stage", "seed")
        table = np.concatenate(self._blocks) if self._blocks else np.empty((0, len(names)))
        return dict(zip(names, table.T, strict=True))

    def designs(self, seed: int | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the designs of the searches: points [SI], objectives [J], rows in the log.

        Arguments: `seed` of one search; None for all of them.
        """
        columns = self.columns()
        wanted = columns["stage"] <= STAGES["polish"]
        if seed is not None:
            wanted &= columns["seed"] == seed
        rows = np.flatnonzero(wanted)
        points = np.column_stack([columns[name][rows] for name in self.tuning.names])
        return points, columns["objective"][rows], rows
