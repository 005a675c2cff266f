"""A response history from request to archive, and its orbits: systems under loads in cells.

Without axes it is computed damper by damper, with histories; a scan block by block.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.cli.running import RunOptions
from nlds_vines.kernels.cells import load_numbers as of_orbit
from nlds_vines.kernels.cells.load_numbers import Told
from nlds_vines.loads.request import HistoryRequest, axis_words, has, is_of_load
from nlds_vines.loads.result import HISTORIES
from nlds_vines.model.load_quantities import OF_LOADS, SHARES, WAYS
from nlds_vines.model.loads.loading import Cells, Loading, Struck
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
"""Orbits of a scan that are kept together."""

PIECE_BYTES = 1 << 26
"""Bytes of the loads of a piece of a scan, on each thread, if no two cases share theirs."""

EDGE_BYTES = 8 * 18
"""Bytes of a cell of a load: its coefficients, its edge and its jump."""

Made = Callable[[range, np.ndarray], list[Cells]]
"""Makes the loads of some lanes, whose cells may be so long (lanes,) [s]."""


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute a response history into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with all that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    size = BLOCK if request.vary else 1
    blocks = [range(i, min(i + size, request.cases)) for i in range(0, request.cases, size)]

    store = Blocks(output, request)
    store.keys = range(len(blocks))

    def work() -> Write:
        found = []
        with Progress(request.cases, "orbit", quiet=how.quiet) as progress:
            for number, cases in enumerate(blocks):
                orbits = partial(arrays_of, request, cases, progress.wait)
                found.append(store.piece(number, orbits))
                progress.note(len(cases), request.case(cases[0])[0].name)
        arrays = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
        return store.writer(*contents(request, arrays))

    store.carry_out(how, work)


def contents(
    request: HistoryRequest, found: Arrays
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive, and its datasets with the values that were found."""
    dampers = np.arange(len(request.systems), dtype=np.int32)
    scales = [Scale("damper", dampers, "1", "damper"), Scale("time", request.times, "s", "time")]
    scales += [Scale(one.name, one.values, *axis_words(request, one.name)) for one in request.vary]
    dims = ("damper", *(axis.name for axis in request.vary))
    table = {entry.name: (dims, entry.unit, entry.words) for entry in OF_LOADS}
    if not request.vary:
        table |= {name: ((*dims, "time"), *said) for name, said in HISTORIES.items()}
        whose = zip(WAYS, ("dashpot c1", "dashpot c2", "contacts"), strict=True)
        table |= {
            f"dissipated_{way}": ((*dims, "time"), "J", f"energy dissipated by {where} so far")
            for way, where in whose
        }
    shape = (len(request.systems), *request.shape)
    filled = [
        (
            Dataset.real(name, its, unit, words),
            found[name].reshape(*shape, *found[name].shape[1:]),
        )
        for name, (its, unit, words) in table.items()
        if np.isfinite(found[name]).any()
    ]
    names = np.array([system.name for system in request.systems], dtype=object)
    status = Dataset.code("status", dims, "how an orbit ended", STATUS_FLAGS)
    return scales, [
        *filled,
        (status, found["status"].reshape(shape)),
        (Dataset.text("system", ("damper",), "system"), names),
    ]


# ---- orbits --------------------------------------------------------------------------------------


def arrays_of(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of cases by name: arrays (cases, ...).

    They are the numbers of `OF_LOADS` and `status`, and without a scan the histories of
    `result.HISTORIES` and the dissipated energies; NaN if an orbit failed.  No number depends on
    the range that it is computed with.  `tell` is called while something is compiled.
    """
    each, history = math.prod(request.shape), not request.vary
    found = []
    for which, numbers in groupby(cases, lambda case: case // each):
        scan = _Scan(request, request.systems[which], [number % each for number in numbers])
        found.append(
            _flown(request, scan.scene, scan.cells, scan.starts, scan.loads, history, tell)
        )
    return {name: np.concatenate([one[name] for one in found]) for name in found[0]}


def numbers_of(
    request: HistoryRequest,
    system: System,
    grid: Mapping[str, np.ndarray],
    each: Sequence[Loading],
    tell: Tell | None = None,
) -> Arrays:
    """Return the numbers (n,) by name of a system under loads, watched as a `request`.

    Arguments: the `system`; a `grid` of parameters (n,) by name that it has in each case; the load
    of each; `tell` takes what is waited for.

    Those of `OF_LOADS`, `status`, and `violations`, how often the limit of a scene was passed.
    """
    cells, starts = _begun(request, system, grid, len(each))

    def loads(lanes: range, reach: np.ndarray) -> list[Cells]:
        made, found = dict[tuple[Any, ...], Cells](), []
        for i, most in zip(lanes, reach.tolist(), strict=True):
            load, struck = each[i], _struck(request, cells[i])
            key = id(load), struck, most
            if key not in made:
                made[key] = _in_cells(request, load, struck, most, history=False)
            found.append(made[key])
        return found

    return _flown(request, system.scene, cells, starts, loads, False, tell)


class _Scan:
    """Cases of a scan that are of one system, by their numbers among those of the system."""

    def __init__(self, request: HistoryRequest, system: System, numbers: Sequence[int]) -> None:
        """Take the parameters of all of them at once."""
        places = np.unravel_index(numbers, request.shape) if request.vary else ()
        values = {
            axis.name: axis.values[place] for axis, place in zip(request.vary, places, strict=True)
        }
        grid = {name: given for name, given in values.items() if has(system, name)}
        self._request, self.scene = request, system.scene
        self._of_load = {name: given for name, given in values.items() if is_of_load(name)}
        self.cells, self.starts = _begun(request, system, grid, len(numbers))

    def loads(self, lanes: range, reach: np.ndarray) -> list[Cells]:
        """Return the loads of some lanes; what several have in common is made once."""
        base, made, found = self._request.load, dict[tuple[Any, ...], Cells](), []
        for lane, most in zip(lanes, reach.tolist(), strict=True):
            numbers = {name: float(given[lane]) for name, given in self._of_load.items()}
            impulse = numbers.pop("impulse", base.impulse) * numbers.get("scale", base.scale)
            struck = _struck(self._request, self.cells[lane])
            key = *numbers.values(), struck, most
            if key not in made:
                load = base.with_({"impulse": 0.0, **numbers})
                made[key] = _in_cells(self._request, load, struck, most, not self._request.vary)
            found.append(_with_blow(made[key], impulse / struck.mass))
        return found


def _with_blow(cells: Cells, jump: float) -> Cells:
    """Return the cells with a jump of v1 [m/s] more at their beginning; they share their rows."""
    if jump == 0.0:
        return cells
    jumps = np.zeros(len(cells.edges)) if cells.jumps is None else cells.jumps.copy()
    jumps[0] += jump
    return Cells(cells.edges, cells.rows, jumps, cells.share)


def _in_cells(
    request: HistoryRequest, load: Loading, struck: Struck, reach: float, history: bool
) -> Cells:  # fmt: skip
    """Return the cells of a load, with edges at the states of a history and at `settle`."""
    marks = request.times[1:-1] if history else np.zeros(0)
    if request.settle:
        marks = np.append(marks, request.settle)
    return load.cells(struck, request.duration, reach, marks)


def _struck(request: HistoryRequest, cell: np.void) -> Struck:
    """Return what of a cell a load acts on."""
    if request.load.harmonic:
        return Struck(float(cell["m1"]), float(cell["P"]), float(cell["omega"]))
    return Struck(float(cell["m1"]))


def _begun(
    request: HistoryRequest, system: System, grid: Mapping[str, np.ndarray], count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells (n,) and the starts (n, 4) of so many cases of a system."""
    cells = np.broadcast_to(system.cells(grid), (count,)).copy()
    starts = np.zeros((count, 4))
    if request.state:
        for i in range(count):
            own = system.with_(**{name: float(given[i]) for name, given in grid.items()})
            starts[i] = _start(request, own)
    return cells, starts


def _start(request: HistoryRequest, system: System) -> np.ndarray:
    """Return the start (x1, v1, r, s) of a system."""
    return start_state(system, float(system.rest or 0.0), request.state or None)[:4]


@stoppable
def _flown(
    request: HistoryRequest, scene: Scene, cells: np.ndarray, starts: np.ndarray, loads: Made,
    history: bool, tell: Tell | None = None,
) -> Arrays:  # fmt: skip
    """Follow an orbit for each of the cells (lanes,) of a scene, and return what they tell.

    Its histories are told as well where `history`.
    """
    batch = LoadBatch(scene, request.load.shaken, request.tolerance, tell)
    reach, found = _rounded(batch.longest(cells)), dict[int, Arrays]()
    asked = of_orbit.Asked(np.array(SHARES), request.settle)

    def some(begin: int, end: int) -> None:
        check()
        own = slice(begin, end)
        made = loads(range(begin, end), reach[own])
        told = batch.run(cells[own], made, starts[own], asked, histories=history)
        numbers = _numbers(request, scene, cells[own], told)
        more = _histories(request, scene, cells[own], made, told) if history else {}
        found[begin] = {**numbers, **more}

    most = max(1, PIECE_BYTES // (EDGE_BYTES * request.windows * request.samples))
    in_pieces(some, len(cells), most=most)
    pieces = [found[begin] for begin in sorted(found)]
    return {name: np.concatenate([one[name] for one in pieces]) for name in pieces[0]}


def _rounded(reach: np.ndarray) -> np.ndarray:
    """Return lengths rounded down by an eighth or less, so that many systems share their loads."""
    mantissa, exponent = np.frexp(reach)
    return np.asarray(np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent))


# ---- results of orbits ---------------------------------------------------------------------------


def _numbers(
    request: HistoryRequest, scene: Scene, cells: np.ndarray, told: Told
) -> dict[str, np.ndarray]:
    """Return the numbers (lanes,) by name, status and violations; what there is not is NaN."""
    numbers, missing = told.numbers, np.full(len(cells), np.nan)
    column = numbers.T
    response = {
        name: values.max(axis=-1) if values.ndim > 1 else values
        for name, values in responses.arrays_of(told.response, scene, cells).items()
    }
    with np.errstate(divide="ignore", invalid="ignore"):
        period = 2 * math.pi / np.sqrt(cells["k1"] / cells["m1"])
        ratio = math.log(10.0) / (4 * math.pi * (column[of_orbit.FELL] / period))
        shares = [column[of_orbit.GONE + i] / column[of_orbit.CAME] for i in range(len(WAYS))]
    has = {"c1": True, "c2": scene.damper, "contact": bool(scene.walls)}
    every = {entry.name: response.get(entry.name, missing) for entry in OF_LOADS}
    every |= {
        f"last_{100 * share:g}": column[of_orbit.LAST_TIMES + i] for i, share in enumerate(SHARES)
    }
    every |= {
        f"share_{way}": share if has[way] else missing
        for way, share in zip(WAYS, shares, strict=True)
    }
    every |= {
        "damping_ratio": np.where(column[of_orbit.FELL] > 0.0, ratio, np.nan),
        "drift_max": response["x1_max"] if request.load.shaken else missing,
        "E1max": told.peak[:, 0],
        "E2max": told.peak[:, 1] if scene.damper else missing,
        "impact_count": column[of_orbit.IMPACTS],
        "energy_in": column[of_orbit.CAME],
        "balance": column[of_orbit.BALANCE],
        "x1_rms": column[of_orbit.RMS],
    }
    failed = told.status != OK
    every = {name: np.where(failed, np.nan, values) for name, values in every.items()}
    violation = np.zeros(len(cells)) if told.violation is None else told.violation[:, 2]
    return {**every, "status": told.status, "violations": violation}


def _histories(
    request: HistoryRequest, scene: Scene, cells: np.ndarray, loads: Sequence[Cells], told: Told
) -> dict[str, np.ndarray]:
    """Return states and energies (lanes, times) by name; NaN of what failed or is not there."""
    time = request.times
    places = np.array([np.searchsorted(load.edges, time * (1.0 - 1e-14)) for load in loads])
    lanes = np.arange(len(cells))[:, None]
    states, sums = told.states[lanes, places], told.sums[lanes, places]
    x1, v1, x2, v2 = np.moveaxis(states, -1, 0)
    p = {name: cells[name][:, None] for name in ("m1", "k1", "m2", "k2", "rest")}
    there = {"c1": True, "c2": scene.damper, "contact": bool(scene.walls)}
    nothing = np.full(x1.shape, np.nan)
    found = {
        "E1": 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2),
        "E2": nothing,
        "x1": x1,
        "x2": nothing,
        "work": told.numbers[:, of_orbit.START, None] + sums[..., 0],
        **{
            f"dissipated_{way}": sums[..., 1 + i] if there[way] else nothing
            for i, way in enumerate(WAYS)
        },
    }
    if scene.damper:
        found["x2"] = x2
        found["E2"] = 0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - p["rest"]) ** 2)
    failed = (told.status != OK)[:, None]
    return {name: np.where(failed, np.nan, values) for name, values in found.items()}
