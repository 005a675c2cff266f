"""A survey: rows of a table, measured task by task, each kept as soon as it is made.

All rows have the same columns, and each task makes some of them.  A run that is interrupted goes
on, with `resume`, at the first task that is not kept.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.provenance import Value
from nlds_vines.archives.record_columns import DIMS, Row, table_of
from nlds_vines.archives.toml import toml_text
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete
from nlds_vines.runs.manifest import SURVEY
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.partfile import Part
from nlds_vines.runs.progress import Progress


class Task(NamedTuple):
    """Some rows of the table that are measured together: `name` for people."""

    name: str
    rows: Callable[[], Sequence[Row]]


@dataclass(frozen=True)
class Survey:
    """What is measured: `document` says all that determines it.

    `shape` names the table, so that readers of an archive know what is in it.
    """

    content: ClassVar[str] = SURVEY

    title: str
    shape: str
    document: Mapping[str, Any]
    columns: tuple[Dataset, ...]
    tasks: tuple[Task, ...]

    def to_toml(self) -> str:
        """Return what is measured as TOML."""
        return toml_text({"title": self.title, "survey": self.shape, **self.document})

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside what is measured."""
        return {"survey": self.shape}

    @property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers, but for the machine."""
        return hashlib.sha256(
            toml_text({"survey": self.shape, **self.document}).encode()
        ).hexdigest()


@dataclass
class SurveyRun(NumberedParts):
    """A survey under way: one part for each task."""

    request: Survey

    def measure(self, index: int) -> Part:
        """Measure a task; return its part, once that survives a power cut."""
        began = time.monotonic()
        arrays = table_of(self.request.columns, self.request.tasks[index].rows())
        self.write_part(index, arrays, seconds=time.monotonic() - began)
        return self.verified(index)


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

    def work(folder: SurveyRun, progress: Progress, stop: Stop) -> Made:
        parts = []
        for index, following in enumerate((*names[1:], None)):
            stop.check()
            parts.append(folder.part(index) or folder.measure(index))
            progress.note(1, "done" if following is None else f"next: {following}")
        contents = [
            (column, np.concatenate([part.arrays[column.name] for part in parts]))
            for column in survey.columns
        ]
        numbers = np.arange(1, len(contents[0][1]) + 1, dtype=np.int32)
        rows = Scale(DIMS[0], numbers, "1", "measurement")
        return Made([rows], contents, {"seconds": round(sum(p.made.seconds for p in parts), 3)})

    complete(
        SurveyRun.open(output, survey, resume=resume, overwrite=overwrite),
        work,
        Progress(len(names), "task", quiet=quiet),
        lambda _: "the tasks that are complete are",
    )
