"""The tasks by the kind of their archives: what computes, reads, draws and repeats one."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from nlds_vines.archives.provenance import (
    CONTINUATION,
    PORTRAIT,
    RESPONSE_CURVES,
    RESPONSE_HISTORY,
    SCAN,
    TUNING,
)

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView


class Task(NamedTuple):
    """The folder of a task, whose words are those of every wing.

    Its `run` computes an archive, its `picture` has the `PICTURE` that draws one, its `command` the
    `Job` that does both.  `reads` is what of its `result` takes the path of an archive; empty where
    there is nothing.
    """

    folder: str
    reads: str = ""
    result: str = "result"
    draws: str = "picture"

    def part(self, word: str) -> Any:
        """Return the module of its folder that has this name."""
        return import_module(f"nlds_vines.{self.folder}.{word}")

    def read(self, path: Path) -> Any:
        """Return what an archive holds, as the function returns it that has computed it."""
        return getattr(self.part(self.result), self.reads)(path)

    @property
    def picture(self) -> Any:
        """What draws its archives, a `plotting.chosen_panels.Drawing`."""
        return self.part(self.draws).PICTURE


TASKS: Mapping[str, Task] = {
    SCAN: Task("bifurcation", "ScanArchive", draws="picture.drawing"),
    TUNING: Task("tuning", "tuned"),
    CONTINUATION: Task("continuation", "continued"),
    RESPONSE_CURVES: Task("bifurcation.response_curves", "curves_in"),
    RESPONSE_HISTORY: Task("loads", "histories_in"),
    PORTRAIT: Task("portrait", "portrait_in"),
}
"""A new kind of archive is a new entry."""

_ENSEMBLE = Task("transients", "ensemble_of", "ensemble")


def task_of(view: ArchiveView) -> Task | None:
    """Return the task of an open archive; of a scan of many starts in one cell, that of ensembles.

    None for an archive of anything else.
    """
    if view.content == SCAN and _ENSEMBLE.part("ensemble").is_ensemble(view):
        return _ENSEMBLE
    return TASKS.get(view.content)


def content_of(path: Path) -> str:
    """Return the kind of an archive; that of a scan where there is no file."""
    if not path.is_file():
        return SCAN
    from nlds_vines.archives.archive import read

    with read(path) as view:
        return view.content
