"""Every evaluation of a search: asked of the journal first, then of the kernels, and kept."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nlds_vines.interrupts import Stop
from nlds_vines.search.journal import Journal
from nlds_vines.search.objective import HOW, RESULTS, Objective, Trials
from nlds_vines.search.progress import Progress
from nlds_vines.search.request import Tuning

STAGES: Mapping[str, int] = {"global": 0, "polish": 1, "robustness": 2, "surface": 3}
"""The parts of a search by name: the CF flags of the dataset `stage`."""


class Log:
    """The only way from a search to the objective; nothing is evaluated that is not noted here."""

    def __init__(self, tuning: Tuning, journal: Journal, progress: Progress, stop: Stop) -> None:
        """Begin with nothing evaluated; whoever asks to stop is heard between two evaluations."""
        self.tuning = tuning
        self._objective = Objective(tuning)
        self._journal, self._progress, self._stop = journal, progress, stop
        self._blocks: list[np.ndarray] = []

    def evaluate(self, trials: Trials, stage: str, seed: int) -> np.ndarray:
        """Return the objective [J] of each trial (n,), infinite where inadmissible.

        Raises `interrupts.Stopped` where somebody has asked to stop.
        """
        self._stop.check()
        asked = trials.table
        found = self._journal.recall(asked)
        if found is None:
            found = self._objective.results(trials)
            self._journal.note(asked, found)
        marks = np.tile([STAGES[stage], seed], (len(asked), 1))
        self._blocks.append(np.column_stack([asked, found, marks]))
        self._progress.advance(found[:, 0], stage, seed)
        return found[:, 0]

    def columns(self) -> dict[str, np.ndarray]:
        """Return everything evaluated so far, by column."""
        names = (*self.tuning.names, *HOW, *RESULTS, "stage", "seed")
        table = np.concatenate(self._blocks) if self._blocks else np.empty((0, len(names)))
        return dict(zip(names, table.T, strict=True))

    def designs(self, seed: int | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what the searches looked at: points [SI], objectives [J], rows in the log.

        Arguments: `seed` of one search; None for all of them.
        """
        columns = self.columns()
        wanted = columns["stage"] <= STAGES["polish"]
        if seed is not None:
            wanted &= columns["seed"] == seed
        rows = np.flatnonzero(wanted)
        points = np.column_stack([columns[name][rows] for name in self.tuning.names])
        return points, columns["objective"][rows], rows
