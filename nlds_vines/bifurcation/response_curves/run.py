"""Response curves from request to archive: the datasets of all cases, with a dimension `case`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import CurveRequest
from nlds_vines.bifurcation.run import Computer
from nlds_vines.cli.running import RunOptions
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Arrays, Blocks, Write

CASE, WALL = "case", "wall"


def run(
    request: CurveRequest,
    output: Path,
    how: RunOptions | None = None,
    cached: dict[str, Arrays] | None = None,
) -> None:
    """Compute response curves into the archive `output`, case by case; with --resume, saved cases
    are reused.

    `cached` maps the hash of a scan to its arrays. Scans in it are not computed; this run adds the
    arrays of all others.
    """
    how = RunOptions() if how is None else how
    cached = {} if cached is None else cached
    use_threads(how.threads)
    store = Blocks(output, request)
    store.keys = range(len(request.cases))

    def work() -> Write:
        results = []
        with Progress(request.lanes, "orbit", quiet=how.quiet) as progress:
            for i, case in enumerate(request.cases):
                compute = partial(_compute, case.scan, progress)
                if (arrays := cached.get(case.scan.hash)) is None:
                    arrays = cached[case.scan.hash] = store.piece(i, compute)
                results.append(arrays)
                progress.note(case.scan.lanes, f"case {i + 1} of {len(request.cases)}")
        return store.writer(scales_of(request), contents(request, results))

    store.carry_out(how, work)


def _compute(scan: Scan, progress: Progress) -> Arrays:
    computer, blocks = Computer(scan, tell=progress.wait), []
    for block in blocks_of(scan):
        check()
        blocks.append(computer.block(block))
    arrays = {name: np.concatenate([block[name] for block in blocks]) for name in datasets_of(scan)}
    return {name: a.astype(str) if a.dtype == object else a for name, a in arrays.items()}


def datasets_of(scan: Scan) -> dict[str, Dataset]:
    """Return the datasets of a scan with one value for each orbit, or for each wall, by name."""
    datasets = scan.table.datasets.items()
    return {name: entry for name, entry in datasets if set(entry.tail) <= {WALL}}


def scales_of(request: CurveRequest) -> list[Scale]:
    starts = np.array(request.cases[0].scan.start.names, dtype=np.str_)
    return [
        Scale(CASE, np.array(request.names), "1", "damper, or the structure alone"),
        PARAMETERS[request.axis].scale(request.values),
        Scale("start", starts, "1", "start of the orbit"),
        Scale(WALL, np.array(["near", "far"]), "1", "wall that is struck"),
    ]


def contents(
    request: CurveRequest, results: Sequence[Mapping[str, np.ndarray]]
) -> list[tuple[Dataset, np.ndarray]]:
    """Return the datasets of the archive with their values.

    `results` are the arrays (n, starts) or (n, starts, walls) of every case, by name.  Where a case
    lacks a quantity, or its second wall, the values are the fill value.
    """
    damped_first = sorted(request.cases, key=lambda case: not case.scan.system.scene.damper)
    table: dict[str, Dataset] = {}
    for case in damped_first:
        for name, entry in datasets_of(case.scan).items():
            if name not in table or len(entry.dims) > len(table[name].dims):
                table[name] = entry
    size = {request.axis: request.values.size, "start": request.cases[0].scan.starts, WALL: 2}
    along = []
    for name, entry in table.items():
        shape = [len(results), *(size[dim] for dim in entry.dims)]
        kind = object if entry.dtype == "str" else entry.dtype
        values = np.full(shape, entry.fill, dtype=kind)
        for i, arrays in enumerate(results):
            if name in arrays:
                of_one_wall = arrays[name].ndim < values.ndim - 1
                values[i][(..., 0) if of_one_wall else ...] = arrays[name]
        along.append((replace(entry, dims=(CASE, *entry.dims)), values))
    systems = [case.scan.system for case in request.cases]
    names = np.array([one.name for one in systems], dtype=object)
    kinds = np.array([one.kind for one in systems], dtype=object)
    fixed = [
        (PARAMETERS[name].dataset((CASE,)), values)
        for name in PARAMETERS
        if name != request.axis
        and not np.isnan(
            values := np.array([one.parameters.get(name, np.nan) for one in systems])
        ).all()
    ]
    return [
        *along,
        (Dataset.text("system", (CASE,), "name of the system"), names),
        (Dataset.text("kind", (CASE,), "kind of damper"), kinds),
        *fixed,
    ]
