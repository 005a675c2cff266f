"""The objective of a design: in the worst of all cases, by default E1max; infinite if it fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nlds_vines.orbits.batch import Batch, Outcome
from nlds_vines.orbits.starts import random_states
from nlds_vines.runs.progress import Tell
from nlds_vines.tuning.request import STARTS, Tuning


@dataclass(frozen=True)
class Trials:
    """Designs to evaluate; the arrays have shape (n,), but for the points.

    Arguments: `points` (n, free parameters) in SI units; `detuning`, the factor on omega;
    `start`, 0 for rest and i for the i-th random start; `stretch`, the factor on the periods
    discarded and sampled.
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
"""The columns of the results of a trial: the objective in its worst case, infinite where the design
is inadmissible; E2max [J], status and number of that case."""


class Objective:
    """The objective of one tuning; what all designs share is prepared once."""

    def __init__(self, tuning: Tuning, tell: Tell | None = None) -> None:
        """Prepare for designs of `tuning`; `tell` takes what is waited for meanwhile."""
        self._tuning = tuning
        self._cases = tuning.cases()
        self._batch = Batch(
            tuning.system.scene, tell, float(tuning.tolerance), tuning.search.objective
        )
        generator = np.random.default_rng(tuning.search.seed)
        self._draws = generator.uniform(-1.0, 1.0, size=(STARTS, 4))

    def results(self, trials: Trials) -> np.ndarray:
        """Return `RESULTS` of each trial (n, 4): designs and cases of one length in one call.

        objective = max over the cases of E1max, or of what the search is told to make small.
        """
        cells, found = self._cells(trials), np.empty((len(trials.points), len(RESULTS)))
        starts = self._starts(cells, trials)
        for stretch in np.unique(trials.stretch):
            rows = trials.stretch == stretch
            periods = (round(n * stretch) for n in (self._tuning.transient, self._tuning.periods))
            found[rows] = worst(self._batch.run(cells[rows], starts[rows], *periods))
        return found

    def _cells(self, trials: Trials) -> np.ndarray:
        """Return the numbers for kernels, (trials, cases)."""
        grid = {name: values[np.newaxis, :] for name, values in self._cases.items()}
        for i, name in enumerate(self._tuning.names):
            grid[name] = trials.points[:, i, np.newaxis]
        grid["omega"] = grid["omega"] * trials.detuning[:, np.newaxis]
        return self._tuning.system.cells(grid)

    def _starts(self, cells: np.ndarray, trials: Trials) -> np.ndarray:
        """Return the start of each lane, (trials, cases, 4): zeros for rest."""
        starts = np.zeros((*cells.shape, 4))
        moved = np.flatnonzero(trials.start)
        if moved.size:
            drawn = random_states(cells[moved], self._draws, self._tuning.system.scene)
            which = trials.start[moved].astype(int) - 1
            starts[moved] = drawn[np.arange(moved.size), :, which]
        return starts


def worst(outcome: Outcome) -> np.ndarray:
    """Return `RESULTS` of designs from the lanes (designs, cases) of their cases."""
    value = np.where(outcome.inadmissible, np.inf, outcome.objective)
    case = value.argmax(axis=1)
    row = np.arange(len(case))
    objective = value[row, case]
    second = np.where(np.isfinite(objective), outcome.E2max[row, case], np.nan)
    return np.column_stack([objective, second, outcome.status[row, case], case])
