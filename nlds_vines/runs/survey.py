"""A survey: rows of a table, measured task by task, each kept as soon as it is made.

All rows have the same columns, and each task makes some of them.  A run that is interrupted goes
on, with `resume`, at the first task that is not kept.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nlds_vines.archives import archive
from nlds_vines.archives.columns import DIMS, Row, table_of
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import attributes
from nlds_vines.errors import printable
from nlds_vines.runs import interrupts
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.manifest import SURVEY
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.partfile import Part
from nlds_vines.runs.progress import Progress
from nlds_vines.toml import toml_text


class Task(NamedTuple):
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

    def measure(self, index: int) -> Part:
        """Measure a task; return its part, once that survives a power cut."""
        began = time.monotonic()
        arrays = table_of(self.request.columns, self.request.tasks[index].rows())
        self.write_part(index, arrays, seconds=time.monotonic() - began)
        return self.verified(index)

    def store(self, parts: Sequence[Part]) -> None:
        """Write the archive of all tasks and let the parts go."""
        contents = [
            (column, np.concatenate([part.arrays[column.name] for part in parts]))
            for column in self.request.columns
        ]
        count = len(contents[0][1])
        rows = Scale(DIMS[0], np.arange(1, count + 1, dtype=np.int32), "1", "measurement")
        more = {
            "content": self.content,
            "survey": self.request.shape,
            "seconds": round(sum(part.made.seconds for part in parts), 3),
            **self.begun_by(),
        }
        attrs = attributes(self.request, more)
        table = Table.of(self.request.columns, {rows.name: count})
        pieces = archive.whole(contents)
        self.deliver(lambda path: archive.write(path, table, [rows], pieces, lambda: attrs))


def run(
    survey: Survey,
    output: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = True,
) -> None:
    """Do a survey into the archive `output`; `quiet` shows no progress.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, every finished task kept for `resume`, and
    `RequestError` where the archive cannot be written.
    """
    names = [task.name for task in survey.tasks]
    opened = SurveyRun.open(output, survey, resume=resume, overwrite=overwrite)
    with opened as journal, interrupts.stop_on_signals() as stop:
        if journal.complete:
            return
        kept = {i: part for i in range(len(names)) if (part := journal.part(i)) is not None}
        left = [index for index in range(len(names)) if index not in kept]
        for line in journal.discarded:
            print(printable(line), file=sys.stderr)
        try:
            with Progress(len(names), "task", done=len(kept), quiet=quiet) as progress:
                for index, following in zip(left, [*left[1:], None], strict=False):
                    stop.check()
                    kept[index] = journal.measure(index)
                    progress.note(1, "done" if following is None else f"next: {names[following]}")
            journal.store([kept[index] for index in range(len(names))])
        except (interrupts.Stopped, KeyboardInterrupt):
            raise Interrupted(
                f"interrupted: {len(kept)} of {len(names)} parts are kept in "
                f"{journal.folder}; the same command with --resume (in place of --overwrite) "
                "goes on from there",
                stop.status,
            ) from None
