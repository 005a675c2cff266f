"""The journal of a search: every evaluation in order, in parts beside the archive to be.

A search depends on its request alone: run again, it asks for the same designs in the same order.
So it is resumed by running it again, with values of the journal in place of those of the kernels.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.progress import Progress
from nlds_vines.tuning.objective import HOW, Objective, Trials, results_of
from nlds_vines.tuning.request import Tuning

FLUSH_EVERY = 1.0
"""Seconds of work between two writes to the disk, which a killed process may lose."""


@dataclass
class Journal(NumberedParts):
    """The evaluations of one tuning: rows of numbers, those asked for and then those found.

    `length` is the number of those on the disk; they took `seconds`, on up to `threads` threads.
    """

    request: Tuning
    length: int = 0
    seconds: float = 0.0
    threads: int = 1
    _known: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    _replayed: int = 0
    _parts: int = 0
    _waiting: list[np.ndarray] = field(default_factory=list)
    _flushed: float = 0.0

    def begin(self, threads: int) -> int:
        """Read the evaluations of an earlier run, up to the first part that does not verify.

        Arguments: `threads` of this run.  Returns the number of evaluations read.
        """
        found = list(self.parts_in_order())
        rows = [part.arrays["rows"] for part in found]
        self._known = np.concatenate(rows) if rows else np.empty((0, 0))
        self._parts, self.length = len(found), len(self._known)
        self.seconds = sum(part.made.seconds for part in found)
        self.threads = max([threads, *(part.made.threads for part in found)])
        self._flushed = time.monotonic()
        return self.length

    def recall(self, asked: np.ndarray) -> np.ndarray | None:
        """Return the results of an earlier run for these rows, which must be next in the journal.

        Returns None at the end of the journal.  Raises `RequestError` where other rows are next:
        then the search was not the same, and cannot be continued.
        """
        if self._replayed == len(self._known):
            return None
        rows = self._known[self._replayed : self._replayed + len(asked)]
        if rows.shape[0] != len(asked) or not np.array_equal(rows[:, : asked.shape[1]], asked):
            raise RequestError(f"{self.folder} does not fit this search: --overwrite begins anew")
        self._replayed += len(asked)
        return rows[:, asked.shape[1] :]

    def note(self, asked: np.ndarray, found: np.ndarray) -> None:
        """Add rows; they are written to the disk within `FLUSH_EVERY` seconds of work."""
        self._waiting.append(np.column_stack([asked, found]))
        if time.monotonic() - self._flushed > FLUSH_EVERY:
            self.flush()

    def flush(self) -> None:
        """Write the rows that wait to the disk."""
        if self._waiting:
            rows, spent = np.concatenate(self._waiting), time.monotonic() - self._flushed
            self.write_part(self._parts, {"rows": rows}, seconds=spent, threads=self.threads)
            self._waiting.clear()
            self.length += len(rows)
            self.seconds += spent
            self._parts += 1
        self._flushed = time.monotonic()


STAGES: Mapping[str, int] = {"global": 0, "polish": 1, "robustness": 2, "surface": 3}
"""The parts of a search by name: the CF flags of the dataset `stage`."""


class Log:
    """All evaluations of a tuning, in order; searches reach the objective only through it."""

    def __init__(self, tuning: Tuning, journal: Journal, progress: Progress, stop: Stop) -> None:
        """Begin with no evaluation; `stop` is checked before each."""
        self.tuning = tuning
        self._objective = Objective(tuning, progress.wait)
        self._journal, self._progress, self._stop = journal, progress, stop
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
        """Return the results of trials, which are in the journal from then on."""
        self._stop.check()
        asked = trials.table
        found = self._journal.recall(asked)
        if found is None:
            found = objective.results(trials)
            self._journal.note(asked, found)
        return found

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
