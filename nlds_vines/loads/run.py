"""Response histories from request to archive: orbits of systems under loads in cells.

Without axes each damper is a block, with histories; a scan has blocks of `BLOCK` orbits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.cli.running import RunOptions
from nlds_vines.kernels.cells import load_numbers as of_orbit
from nlds_vines.kernels.cells.load_numbers import LoadResults
from nlds_vines.loads.host_histories import contents_of_hosts
from nlds_vines.loads.host_run import arrays_of_hosts, numbers_of_hosts
from nlds_vines.loads.request import HistoryRequest, axis_words, has, is_of_load
from nlds_vines.loads.result import HISTORIES
from nlds_vines.model.axis import SAMPLE, sample_scale
from nlds_vines.model.catalog import AnySystem
from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.loads.loading import Cells, Loading, Struck
from nlds_vines.model.quantities import OF_LOADS, SHARES, WAYS
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits import responses
from nlds_vines.orbits.load_flight import LoadBatch
from nlds_vines.orbits.records import OK, STATUS_FLAGS
from nlds_vines.orbits.simulation import start_state
from nlds_vines.runs.executors import in_pieces, use_threads
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.store import Arrays, Blocks, Write

BLOCK = 256
PIECE_BYTES = 1 << 26  # of loads in a thread's memory at once, if no two orbits share theirs
EDGE_BYTES = 8 * 18  # bytes of a cell of a load: its coefficients, its edge and its jump


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute response histories into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with complete blocks saved.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    size = BLOCK if request.vary else 1
    blocks = [range(i, min(i + size, request.cases)) for i in range(0, request.cases, size)]

    store = Blocks(output, request)
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


def contents(
    request: HistoryRequest, arrays: Arrays
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive, and its datasets with the values in `arrays`."""
    names = np.array([system.name for system in request.systems], dtype=object)
    first = "system" if request.has_hosts else "damper"
    scales = [Scale(first, names, "1", first), Scale("time", request.times, "s", "time")]
    if request.sampled is None:
        scales += [
            Scale(one.name, one.values, *axis_words(request, one.name)) for one in request.vary
        ]
    else:
        scales.append(sample_scale(request.sampled.count))
    dims = (first, *(axis.name for axis in request.vary))
    shape = (len(request.systems), *request.shape)
    status = Dataset.code("status", dims, "how an orbit ended", STATUS_FLAGS)
    last = [(status, arrays["status"].reshape(shape))]
    for name, values in request.columns.items() if request.sampled else ():
        last.append((Dataset.real(name, (SAMPLE,), *axis_words(request, name)), values))
    if request.has_hosts:
        own, datasets = contents_of_hosts(request, arrays, dims)
        return [*scales, *own], [*datasets, *last]
    table = {entry.name: (dims, entry.unit, entry.words) for entry in OF_LOADS}
    if not request.vary:
        table |= {name: ((*dims, "time"), *words) for name, words in HISTORIES.items()}
    datasets = [
        (Dataset.real(name, of, unit, words), arrays[name].reshape(*shape, *arrays[name].shape[1:]))
        for name, (of, unit, words) in table.items()
        if np.isfinite(arrays[name]).any()
    ]
    return scales, [*datasets, *last]


def arrays_of(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of orbits by name: arrays (orbits, ...).

    These are the quantities of `OF_LOADS` and `status`, and without axes the histories of
    `result.HISTORIES` and the dissipated energies; NaN if an orbit failed.
    """
    if request.has_hosts:
        return arrays_of_hosts(request, cases, tell)
    count = math.prod(request.shape)
    pieces = []
    for which, numbers in groupby(cases, lambda case: case // count):
        places = [number % count for number in numbers]
        values = request.values_at(np.unravel_index(places, request.shape)) if request.vary else {}
        pieces.append(numbers_of(request, request.systems[which], values, tell))
    return _joined(pieces)


def numbers_of(
    request: HistoryRequest, system: AnySystem, values: Mapping[str, np.ndarray], tell: Tell | None
) -> Arrays:
    """Return the quantities (n,) of a system under the load by name, and histories without axes.

    The `values` (n,) are parameters, those that the system lacks left out; numbers of the load; and
    `draw`, by which the seeds of its noise advance.  Beside the quantities of `OF_LOADS` there are
    `status` and the `violations` of the scene's limit.
    """
    if isinstance(system, HostSystem):
        return numbers_of_hosts(request, system, values, tell)
    grid = {name: column for name, column in values.items() if has(system, name)}
    of_load = {name: v.tolist() for name, v in values.items() if is_of_load(name) or name == "draw"}
    each, loads = [], dict[tuple[float, ...], Loading]()
    for lane in range(max((len(column) for column in values.values()), default=1)):
        changes = {name: column[lane] for name, column in of_load.items()}
        impulse, key = changes.pop("impulse", request.load.impulse), tuple(changes.values())
        if key not in loads:
            draw = changes.pop("draw", 0)
            load = request.load.redrawn(draw) if draw else request.load
            loads[key] = load.with_({"impulse": 0.0, **changes})
        each.append((loads[key], impulse * loads[key].scale))
    return _fly(request, system, grid, each, not values, tell)


def _joined(pieces: Sequence[Arrays]) -> Arrays:
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


@stoppable
def _fly(
    request: HistoryRequest, system: System, grid: Mapping[str, np.ndarray],
    each: Sequence[tuple[Loading, float]], history: bool, tell: Tell | None,
) -> Arrays:  # fmt: skip
    """Follow an orbit of a system under `each` load; return quantities, and histories if asked.

    Each load is given without its impulse at t = 0, and with the size [N s] of that: lanes whose
    loads differ in the impulse alone share the rows of their cells.
    """
    scene, count = system.scene, len(each)
    cells, starts = np.broadcast_to(system.cells(grid), (count,)).copy(), np.zeros((count, 4))
    if request.state:
        for i in range(count):
            one = system.with_(**{name: float(column[i]) for name, column in grid.items()})
            starts[i] = start_state(one, float(one.rest or 0.0), request.state)[:4]
    batch = LoadBatch(scene, request.load.shaken, request.tolerance, tell)
    # rounded down by up to an eighth, so that many systems share their loads
    mantissa, exponent = np.frexp(batch.longest(cells))
    reach = np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent)
    marks = request.times[1:-1] if history else np.zeros(0)  # further edges of cells
    if request.settle:
        marks = np.append(marks, request.settle)
    pieces, asked = dict[int, Arrays](), of_orbit.Asked(np.array(SHARES), request.settle)

    def fly(begin: int, end: int) -> None:
        check()
        shared, loads = dict[tuple[Any, ...], Cells](), []
        for lane in range(begin, end):
            (load, impulse), cell, longest = each[lane], cells[lane], float(reach[lane])
            force = (float(cell["P"]), float(cell["omega"])) if load.harmonic else ()
            struck = Struck(float(cell["m1"]), *force)
            key = id(load), struck, longest
            if key not in shared:
                shared[key] = load.cells(struck, request.duration, longest, marks)
            in_cells = shared[key]
            if jump := impulse / struck.mass:
                old = in_cells.jumps
                jumps = np.zeros(len(in_cells.edges)) if old is None else old.copy()
                jumps[0] += jump
                in_cells = replace(in_cells, jumps=jumps)
            loads.append(in_cells)
        lanes = slice(begin, end)
        orbits = batch.run(cells[lanes], loads, starts[lanes], asked, histories=history)
        arrays = _numbers(request, scene, cells[lanes], orbits)
        if history:
            arrays |= _histories(request, scene, cells[lanes], loads, orbits)
        pieces[begin] = arrays

    most = max(1, PIECE_BYTES // (EDGE_BYTES * request.windows * request.samples))
    in_pieces(fly, count, most=most)
    return _joined([pieces[begin] for begin in sorted(pieces)])


def _numbers(
    request: HistoryRequest, scene: Scene, cells: np.ndarray, orbits: LoadResults
) -> dict[str, np.ndarray]:
    column, missing = orbits.numbers.T, np.full(len(cells), np.nan)
    response = {
        name: values.max(axis=-1) if values.ndim > 1 else values
        for name, values in responses.arrays_of(orbits.response, scene, cells).items()
    }
    fall = column[of_orbit.DECAY_TIME]  # [s], from the largest E1 to a tenth of it
    with np.errstate(divide="ignore", invalid="ignore"):
        period = 2 * math.pi / np.sqrt(cells["k1"] / cells["m1"])
        ratio = math.log(10.0) / (4 * math.pi * (fall / period))
        shares = [
            column[of_orbit.DISSIPATED + i] / column[of_orbit.ENERGY_IN] for i in range(len(WAYS))
        ]
    has = {"c1": True, "c2": scene.damper, "contact": bool(scene.walls)}
    quantities = {
        **{entry.name: response.get(entry.name, missing) for entry in OF_LOADS},
        **{
            f"last_{100 * share:g}": column[of_orbit.LAST_TIMES + i]
            for i, share in enumerate(SHARES)
        },
        **{
            f"share_{sink}": share if has[sink] else missing
            for sink, share in zip(WAYS, shares, strict=True)
        },
        "damping_ratio": np.where(fall > 0.0, ratio, np.nan),
        "drift_max": response["x1_max"] if request.load.shaken else missing,
        "shear_max": cells["k1"] * response["x1_max"],
        "E1max": orbits.peak[:, 0],
        "E2max": orbits.peak[:, 1] if scene.damper else missing,
        "impact_count": column[of_orbit.IMPACTS],
        "energy_in": column[of_orbit.ENERGY_IN],
        "balance": column[of_orbit.BALANCE],
        "x1_rms": column[of_orbit.RMS],
    }
    failed = orbits.status != OK
    quantities = {name: np.where(failed, np.nan, values) for name, values in quantities.items()}
    violations = np.zeros(len(cells)) if orbits.violation is None else orbits.violation[:, 2]
    return {**quantities, "status": orbits.status, "violations": violations}


def _histories(
    request: HistoryRequest,
    scene: Scene,
    cells: np.ndarray,
    loads: Sequence[Cells],
    orbits: LoadResults,
) -> dict[str, np.ndarray]:
    time = request.times
    places = np.array([np.searchsorted(load.edges, time * (1.0 - 1e-14)) for load in loads])
    lanes = np.arange(len(cells))[:, None]
    states, sums = orbits.states[lanes, places], orbits.sums[lanes, places]
    x1, v1, x2, v2 = np.moveaxis(states, -1, 0)
    p = {name: cells[name][:, None] for name in ("m1", "k1", "m2", "k2", "rest")}
    has = {"c1": True, "c2": scene.damper, "contact": bool(scene.walls)}
    missing = np.full(x1.shape, np.nan)
    histories = {
        "E1": 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2),
        "E2": missing,
        "x1": x1,
        "x2": missing,
        "work": orbits.numbers[:, of_orbit.START, None] + sums[..., 0],
        **{
            f"dissipated_{sink}": sums[..., 1 + i] if has[sink] else missing
            for i, sink in enumerate(WAYS)
        },
    }
    if scene.damper:
        histories["x2"] = x2
        histories["E2"] = 0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - p["rest"]) ** 2)
    failed = (orbits.status != OK)[:, None]
    return {name: np.where(failed, np.nan, values) for name, values in histories.items()}
