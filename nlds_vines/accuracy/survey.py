"""A survey: many measurements, task by task, each kept as soon as it is made, in one archive.

What is measured is a table: rows with the same columns, each task some rows of it.  A run that is
interrupted goes on, with `resume`, at the first task that is not kept.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.accuracy.columns import DIMS, Row, table_of
from nlds_vines.archives import archive
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import attributes
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.errors import RequestError, printable
from nlds_vines.orbits.compilation import silent
from nlds_vines.runs import interrupts
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.manifest import SURVEY
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.progress import Progress
from nlds_vines.toml import toml_text


@dataclass(frozen=True)
class Task:
    """Some rows of the table that are measured together: `name` for people."""

    name: str
    rows: Callable[[], Sequence[Row]]


@dataclass(frozen=True)
class Survey:
    """What is measured: `about` says all that determines it, as a TOML document.

    `shape` names the table, so that readers of an archive know what is in it.
    """

    title: str
    shape: str
    about: Mapping[str, Any]
    columns: tuple[Dataset, ...]
    tasks: tuple[Task, ...]

    def to_toml(self) -> str:
        """Return what is measured as TOML."""
        return toml_text({"title": self.title, "survey": self.shape, **self.about})

    @property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers, but for the machine."""
        return hashlib.sha256(toml_text({"survey": self.shape, **self.about}).encode()).hexdigest()


@dataclass
class SurveyRun(NumberedParts):
    """A survey under way: one sealed part for each task."""

    content: ClassVar[str] = SURVEY

    request: Survey
    seconds: float = 0.0
    kept: dict[int, dict[str, np.ndarray]] = field(default_factory=dict)

    def recall(self) -> int:
        """Read what an earlier run left; returns how many tasks that is.

        What does not verify is removed, and measured again.
        """
        for index in range(len(self.request.tasks)):
            part = self.part(index)
            if part is not None:
                self.kept[index] = part.arrays
                self.seconds += part.made.seconds
        return len(self.kept)

    def abandon(self) -> None:
        """Leave nothing behind if nothing was measured."""
        if not self.kept:
            self._clear()

    def measure(self, index: int) -> dict[str, np.ndarray]:
        """Return the columns of a task, measured unless they are kept."""
        if index not in self.kept:
            began = time.monotonic()
            arrays = table_of(self.request.columns, self.request.tasks[index].rows())
            spent = time.monotonic() - began
            self.write_part(index, arrays, seconds=spent)
            self.kept[index] = arrays
            self.seconds += spent
        return self.kept[index]

    def store(self) -> None:
        """Write the archive of all tasks and let the parts go."""
        parts = [self.kept[index] for index in range(len(self.request.tasks))]
        contents = [
            (column, np.concatenate([part[column.name] for part in parts]))
            for column in self.request.columns
        ]
        count = len(contents[0][1])
        rows = Scale(DIMS[0], np.arange(1, count + 1, dtype=np.int32), "1", "measurement")
        more = {
            "content": self.content,
            "survey": self.request.shape,
            "seconds": round(self.seconds, 3),
            **self.begun_by(),
        }
        attrs = attributes(self.request, more)
        table = Table.of(self.request.columns, {rows.name: count})
        pieces = archive.whole(contents)
        self.deliver(lambda path: archive.write(path, table, [rows], pieces, lambda: attrs))


def run(survey: Survey, output: Path, how: RunOptions | None = None) -> None:
    """Do a survey into the archive `output`.

    Arguments: `how` the run goes, None for the defaults of `RunOptions`; there are no shards.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, every finished task kept for --resume, and
    `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    opened = SurveyRun.open(output, survey, resume=how.resume, overwrite=how.overwrite)
    with opened as journal, interrupts.stop_on_signals() as stop:
        if journal.complete:
            return
        known = journal.recall()
        for line in journal.discarded:
            print(printable(line), file=sys.stderr)
        try:
            _measure(journal, stop, known, how.quiet)
            journal.store()
        except RequestError:
            journal.abandon()
            raise
        except (interrupts.Stopped, KeyboardInterrupt):
            raise Interrupted(
                f"interrupted: {len(journal.kept)} of {len(survey.tasks)} parts are kept in "
                f"{journal.folder}; the same command with --resume (in place of --overwrite) "
                "goes on from there",
                stop.status,
            ) from None


def _measure(journal: SurveyRun, stop: interrupts.Stop, known: int, quiet: bool) -> None:
    """Measure what is not kept, task by task; the progress names the task that comes next."""
    tasks = journal.request.tasks
    left = [index for index in range(len(tasks)) if index not in journal.kept]
    with silent(quiet), Progress(len(tasks), "task", done=known, quiet=quiet) as progress:
        for index, following in zip_longest(left, left[1:]):
            stop.check()
            journal.measure(index)
            words = "done" if following is None else f"next: {tasks[following].name}"
            progress.note(1, words)
