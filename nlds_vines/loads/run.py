"""Response histories from request to archive: orbits of systems under loads in cells.

Without axes each damper is a block, with histories; a scan has blocks of `BLOCK` orbits.  The
orbits of a suite without axes are those of its records alone, to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np

from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.load_task import LoadOfOrbit, LoadTask
from nlds_vines.loads.datasets import SENSITIVE, contents, in_columns, owners_in, with_drift_ratios
from nlds_vines.loads.request import LOAD, HistoryRequest, is_of_load
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.quantities import HISTORIES, OF_LOADS_BY_NAME
from nlds_vines.model.system import System
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays, BlockStore, Write

BLOCK = 256


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute response histories into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with complete blocks saved.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    size = BLOCK if request.is_scan else 1
    blocks = [range(i, min(i + size, request.cases)) for i in range(0, request.cases, size)]

    store = BlockStore(output, request)
    store.keys = range(len(blocks))

    def work() -> Write:
        pieces = []
        with Progress(request.cases, "orbit", quiet=how.quiet) as progress:
            for number, cases in enumerate(blocks):
                compute = partial(arrays_of, request, cases, progress.wait)
                pieces.append(store.piece(number, compute))
                progress.note(len(cases), request.case(cases[0])[0].name)
        return store.writer(*contents(request, _joined(pieces)))

    store.carry_out(how, work)


def arrays_of(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of orbits by name: arrays (orbits, ...).

    These are the quantities of `datasets` and `status`, and without axes the histories, and the
    impacts after the number of their system, where kernels record them.  What only systems of other
    blocks have is missing.
    """
    count = math.prod(request.shape)
    pieces = []
    for which, numbers in groupby(cases, lambda case: case // count):
        places = [number % count for number in numbers]
        system = request.systems[which]
        if request.load.suite and not request.vary:
            pieces += [_numbers_under(request, system, place, tell) for place in places]
            continue
        values = request.values_at(np.unravel_index(places, request.shape)) if request.vary else {}
        arrays = numbers_of(request, system, values, tell)
        if not values:
            arrays[SENSITIVE] = _sensitivity(request, system, arrays, tell)
        if "touches" in arrays:
            arrays["touches"] = np.insert(arrays["touches"], 0, which, axis=1)
        pieces.append(arrays)
    return _joined(pieces)


def _numbers_under(
    request: HistoryRequest, system: System, place: int, tell: Tell | None
) -> dict[str, np.ndarray]:
    """Return the quantities (1, ...) under one record of a suite, as its own history has them.

    The cells of a history end at its times, so that the bits of a host's numbers depend on them.
    """
    alone = request.with_record(place)
    arrays = numbers_of(alone, system, {}, tell)
    arrays[SENSITIVE] = _sensitivity(alone, system, arrays, tell)
    return {name: arrays[name] for name in arrays if name not in ("touches", *HISTORIES)}


def _sensitivity(
    request: HistoryRequest, system: System, arrays: Arrays, tell: Tell | None
) -> np.ndarray:
    """Return [1] if loads that differ by `ROUND_OFF` give other numbers of impacts, or else [0].

    Without impacts it is [-1], and nothing is computed.
    """
    counts = arrays.get("impact_count", np.zeros(0))
    if not (counts > 0).any():
        return np.array([-1], np.int8)
    others = numbers_of(request.moved(), system, {}, tell)["impact_count"]
    return np.array([not np.array_equal(counts, others)], np.int8)


def numbers_of(
    request: HistoryRequest, system: System, values: Mapping[str, np.ndarray], tell: Tell | None
) -> dict[str, np.ndarray]:
    """Return the quantities (n, ...) that a system has under the load by name.

    The `values` (n,) are parameters, those that the system lacks left out; numbers of the load;
    `load`, the number of a record of the suite; and `draw`, by which the seeds of noise advance.
    Without values there are histories, too.
    Beside the quantities there are `status` and the `violations` of the scene's limit.
    """
    others = (LOAD, "draw")
    of_load = {name: v.tolist() for name, v in values.items() if is_of_load(name) or name in others}
    each: list[LoadOfOrbit] = []
    loads = dict[tuple[float, ...], Loading]()
    for lane in range(max((len(column) for column in values.values()), default=1)):
        changes = {name: column[lane] for name, column in of_load.items()}
        impulse = changes.pop("impulse", request.load.impulse)
        key = tuple(changes.values())
        if key not in loads:
            load = request.load
            if load.suite:
                load = load.member(int(changes.pop(LOAD)))
            draw = changes.pop("draw", 0)
            load = load.redrawn(draw) if draw and load.noise else load
            loads[key] = load.with_({"impulse": 0.0, **changes})
        each.append((loads[key], impulse * loads[key].scale))
    grid = {name: v for name, v in values.items() if system.takes(name)}
    task = LoadTask(
        duration=request.duration,
        times=request.times,
        has_histories=not values,
        shaken=request.load.shaken,
        state=request.state,
        settle=request.settle,
        tolerance=request.tolerance,
        of=owners_in(system, request)["displacement"],
    )
    arrays = engine_for(system).load(task, tell).run(grid, each)
    return dict(with_drift_ratios(request, in_columns(request, system, arrays)))


def _joined(pieces: Sequence[Arrays]) -> Arrays:
    """Return arrays of pieces one after another, filled where a piece does not have them."""
    joined = {}
    for name in dict.fromkeys(name for piece in pieces for name in piece):
        pattern = next(piece[name] for piece in pieces if name in piece)
        fill = OF_LOADS_BY_NAME[name].fill if name in OF_LOADS_BY_NAME else np.nan
        columns = []
        for piece in pieces:
            if name in piece:
                columns.append(piece[name])
            elif name != "touches":
                shape = (len(piece["status"]), *pattern.shape[1:])
                columns.append(np.full(shape, fill, pattern.dtype))
        joined[name] = np.concatenate(columns)
    return joined
