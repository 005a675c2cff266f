"""A continuation from request to archive; each complete branch or curve is a block."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from pathlib import Path

from nlds_vines.cli.running import RunOptions
from nlds_vines.continuation.branch_arm import Bounds
from nlds_vines.continuation.branch_table import (
    Tables,
    curve_datasets,
    curve_scales,
    curves_through,
    datasets_of,
    scales_of,
    tables_of,
)
from nlds_vines.continuation.exploration import Explorer, Piece, Search, made_now
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.result import map_of
from nlds_vines.continuation.start_orbits import seeds_of
from nlds_vines.errors import RequestError
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.store import Arrays, Blocks, Write


def compute(request: Continuation, piece: Piece = made_now, tell: Tell | None = None) -> Tables:
    """Follow all branches and curves of a continuation and return their tables.

    `piece` saves each of them; `tell` receives messages about compiling.
    """
    along, section_map = request.along, map_of(request)
    search = Search(request.doublings, request.step, request.unstable)
    explorer = Explorer(section_map, Bounds(along.low, along.high), search, piece)
    seeds = seeds_of(request, tell)
    section_map.compile(tell)
    tracks = explorer.run(seeds)
    if not tracks:
        raise RequestError(
            "Newton's method closed no periodic orbit from the start: give a nearer state"
        )
    tables = tables_of(request, section_map, tracks)
    if request.plane is None:
        return tables
    specials = [special for track in tracks for special in track.specials]
    return tables | curves_through(request, specials, piece)


def run(request: Continuation, output: Path, how: RunOptions | None = None) -> None:
    """Compute a continuation into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with complete branches saved for --resume,
    and `RequestError` if there is no periodic start orbit.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    store, numbers = Blocks(output, request), count()

    def work() -> Write:
        with Progress(None, "curve", quiet=how.quiet) as progress:

            def piece(make: Callable[[], Arrays]) -> Arrays:
                arrays = store.piece(next(numbers), make)
                progress.note(1, f"{max(map(len, arrays.values()))} points in the last one")
                return arrays

            tables = compute(request, piece, progress.wait)
        entries, scales = datasets_of(request), scales_of(request, tables)
        if request.plane is not None:
            entries, scales = [*entries, *curve_datasets(request)], [*scales, *curve_scales(tables)]
        contents = [
            (entry, tables[entry.name]) for entry in entries if tables.get(entry.name) is not None
        ]
        return store.writer(scales, contents, [item.name for item in request.free])

    store.carry_out(how, work)
