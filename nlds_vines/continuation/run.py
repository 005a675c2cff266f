"""A continuation from request to archive, branch by branch: each is kept when it is complete."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from nlds_vines.archives.provenance import Value
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.continuation.branch_arm import Bounds
from nlds_vines.continuation.branch_table import Tables, datasets_of, scales_of, tables_of
from nlds_vines.continuation.exploration import Explorer, Search
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.result import map_of
from nlds_vines.continuation.special_curve_table import curve_datasets, curve_scales, curves_through
from nlds_vines.continuation.start_orbits import seeds_of
from nlds_vines.continuation.whole_branch import Arrays
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete, tell_discarded
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.progress import Progress, Tell


@dataclass
class TrackFolder(NumberedParts):
    """The tracks of a continuation under way, in the order in which they are found."""

    request: Continuation
    _there: int = 0
    _read: int = 0
    _stored: float = field(default_factory=time.monotonic)

    def begin(self) -> int:
        """Count the tracks of an earlier run, up to the first that does not verify; return it."""
        self._there = sum(1 for _ in self.parts_in_order())
        return self._there

    def recall(self) -> Arrays | None:
        """Return the next arrays of an earlier run; None where there are no more."""
        if self._read == self._there:
            return None
        self._read += 1
        return self.verified(self._read - 1).arrays

    def keep(self, arrays: Arrays) -> None:
        """Store the arrays of a new track or curve."""
        now = time.monotonic()
        self.write_part(self._there, arrays, seconds=now - self._stored)
        self._there, self._read, self._stored = self._there + 1, self._read + 1, now


def compute(
    request: Continuation,
    *,
    recall: Callable[[], Arrays | None] = lambda: None,
    keep: Callable[[Arrays], None] = lambda arrays: None,
    check: Callable[[], None] = lambda: None,
    tell: Tell | None = None,
) -> Tables:
    """Follow all branches and curves of a continuation and return what is kept of them.

    Arguments: `recall` and `keep`, see `Explorer`; `check` is called between two points, and may
    raise; `tell` takes what is waited for where something is compiled.
    """
    along, section_map = request.along, map_of(request)
    search = Search(request.doublings, request.step, request.unstable)
    explorer = Explorer(section_map, Bounds(along.low, along.high), search, recall, keep, check)
    seeds = seeds_of(request, tell)
    with section_map.compilation(tell):
        tracks = explorer.run(seeds)
        tables = tables_of(request, section_map, tracks)
        if request.plane is None:
            return tables
        specials = [special for track in tracks for special in track.specials]
        return tables | curves_through(request, specials, recall, keep, check)


def run(request: Continuation, output: Path, how: RunOptions | None = None) -> None:
    """Do a continuation into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every branch kept for --resume, and
    `RequestError` where there is no periodic orbit to begin with.
    """
    how = RunOptions() if how is None else how
    threads, began = use_threads(how.threads), time.monotonic()

    def work(folder: TrackFolder, progress: Progress, stop: Stop) -> Made:
        known = folder.begin()
        tell_discarded(folder)
        tables = _followed(request, folder, progress, stop)
        seconds = round(time.monotonic() - began, 3)
        return _made(request, tables, {"threads": threads, "seconds": seconds, "replayed": known})

    complete(
        TrackFolder.open(output, request, resume=how.resume, overwrite=how.overwrite),
        work,
        Progress(None, "curve", quiet=how.quiet),
        lambda _: "the branches that are complete are",
    )


def _followed(request: Continuation, folder: TrackFolder, progress: Progress, stop: Stop) -> Tables:
    count = 0

    def keep(arrays: Arrays) -> None:
        nonlocal count
        folder.keep(arrays)
        count += 1
        progress.note(1, f"{max(map(len, arrays.values()))} points in the last one")

    return compute(request, recall=folder.recall, keep=keep, check=stop.check, tell=progress.wait)


def _made(request: Continuation, tables: Tables, spent: Mapping[str, Value]) -> Made:
    """Return what the archive of these tables holds."""
    entries, scales = datasets_of(request), scales_of(request, tables)
    if request.plane is not None:
        entries, scales = [*entries, *curve_datasets(request)], [*scales, *curve_scales(tables)]
    contents = [
        (entry, tables[entry.name]) for entry in entries if tables.get(entry.name) is not None
    ]
    return Made(scales, contents, spent, [item.name for item in request.free])
