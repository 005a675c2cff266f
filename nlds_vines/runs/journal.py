"""A run from its folder to its archive: work that can be stopped and resumed, then delivered.

What is kept along the way, and how it is found again, is the folder's; what is computed, a task's.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

import numpy as np

from nlds_vines.archives import archive
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import Value, attributes
from nlds_vines.errors import printable
from nlds_vines.runs import interrupts
from nlds_vines.runs.folder import RunFolder
from nlds_vines.runs.interrupts import Interrupted, Stop
from nlds_vines.runs.progress import Progress

Folder = TypeVar("Folder", bound=RunFolder)


class Made(NamedTuple):
    """What an archive is to hold.

    `scales`, its dimensions; `contents`, its datasets with their values, of which empty ones are
    left out; `spent`, attributes on what it took, as `threads` and `seconds`; `free`, names of
    parameters that have no value of their own in it.
    """

    scales: Sequence[Scale]
    contents: Sequence[tuple[Dataset, np.ndarray]]
    spent: Mapping[str, Value]
    free: Collection[str] = ()


def complete(
    folder: Folder,
    work: Callable[[Folder, Progress, Stop], Made],
    progress: Progress,
    kept: Callable[[Folder], str],
) -> None:
    """Do the `work` of a run whose folder is open, put its archive in place, remove the folder.

    Nothing is done where the archive is complete already.

    Arguments: `progress`, shown meanwhile; `kept` says, where the run is stopped, what of it is
    kept, as `3 curves are`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, and `RequestError` where the archive cannot
    be written; all that was kept is there for --resume.
    """
    with folder, interrupts.stop_on_signals() as stop:
        if folder.complete:
            return
        with resumable(folder, stop, lambda: kept(folder)):
            with progress:
                made = work(folder, progress, stop)
            tell_discarded(folder)
            _deliver(folder, made)


@contextmanager
def resumable(folder: RunFolder, stop: Stop, kept: Callable[[], str]) -> Iterator[None]:
    """If a run is stopped, raise `Interrupted`, which says what is `kept` and how to go on."""
    try:
        yield
    except (interrupts.Stopped, KeyboardInterrupt):
        if ArchivePath.of(folder.path).named is None:
            raise Interrupted(
                "interrupted: what was computed is lost, because no archive was named (to=)",
                stop.status,
            ) from None
        again = "" if folder.shard else " with --resume (in place of --overwrite)"
        raise Interrupted(
            f"interrupted: {kept()} kept in {folder.folder}; "
            f"the same command{again} goes on from there",
            stop.status,
        ) from None


def tell_discarded(folder: RunFolder) -> None:
    """Say, a line each and once, which parts did not verify and are computed again."""
    while folder.discarded:
        print(printable(folder.discarded.pop(0)), file=sys.stderr)


def _deliver(folder: RunFolder, made: Made) -> None:
    """Write the archive, put it in its place and remove the parts."""
    request = folder.request
    about = {**request.about, "content": request.content, **folder.begun_by(), **made.spent}
    attrs = attributes(request, about)
    for name in made.free:
        attrs.pop(name, None)
    contents = [(entry, values) for entry, values in made.contents if values.size]
    sizes = {scale.name: scale.values.size for scale in made.scales}
    table, pieces = Table.of((entry for entry, _ in contents), sizes), archive.whole(contents)
    folder.deliver(lambda path: archive.write(path, table, made.scales, pieces, lambda: attrs))
