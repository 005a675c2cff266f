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
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.cli.running import RunOptions
from nlds_vines.errors import RequestError
from nlds_vines.kernels.cells import load_numbers as of_orbit
from nlds_vines.kernels.cells.load_numbers import LoadResults
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS
from nlds_vines.loads.datasets import HOST_HISTORIES, IMPACT_COLUMNS, contents, owners_of
from nlds_vines.loads.request import HistoryRequest, is_of_load
from nlds_vines.model.loads.loading import Cells, Loading, Struck
from nlds_vines.model.parameters import SIDES
from nlds_vines.model.quantities import OF_HOSTS, OF_LOADS, SHARES, WAYS
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import General, Preset, System
from nlds_vines.orbits import responses
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.host_loads import (
    RUN_UNDER,
    LoadedOrbit,
    cells_of,
    combined,
    energies_at,
    follow_load,
    last_times,
    longest_cell,
)
from nlds_vines.orbits.host_orbits import HostOrbits, energies_of
from nlds_vines.orbits.kind_engine import start_state
from nlds_vines.orbits.load_flight import LoadBatch
from nlds_vines.orbits.records import OK
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.executors import in_pieces, use_threads
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.store import Arrays, Blocks, Write

BLOCK = 256
PIECE_BYTES = 1 << 26  # of loads in a thread's memory at once, if no two orbits share theirs
EDGE_BYTES = 8 * 18  # bytes of a cell of a load: its coefficients, its edge and its jump
ORBITS_AT_ONCE = 4  # orbits of hosts that a thread takes at a time
CELLS_OF_PIECE = 64  # cells of a load in which a history is followed again at once


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


def arrays_of(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of orbits by name: arrays (orbits, ...).

    These are the quantities of `datasets` and `status`, and without axes the histories, and the
    impacts of hosts after the number of their system; NaN if an orbit failed.
    """
    count = math.prod(request.shape)
    pieces = []
    for which, numbers in groupby(cases, lambda case: case // count):
        places = [number % count for number in numbers]
        values = request.values_at(np.unravel_index(places, request.shape)) if request.vary else {}
        arrays = numbers_of(request, request.systems[which], values, tell)
        if "touches" in arrays:
            arrays["touches"] = np.insert(arrays["touches"], 0, which, axis=1)
        pieces.append(arrays)
    return _joined(pieces)


def numbers_of(
    request: HistoryRequest, system: System, values: Mapping[str, np.ndarray], tell: Tell | None
) -> dict[str, np.ndarray]:
    """Return the quantities (n, ...) of a system under the load by name, without axes histories.

    The `values` (n,) are parameters, those that the system lacks left out; numbers of the load; and
    `draw`, by which the seeds of its noise advance.  Beside the quantities there are `status` and
    the `violations` of the scene's limit.
    """
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
    grid = {name: v for name, v in values.items() if system.takes(name)}
    fly: Any = _fly_hosts if isinstance(system, General) else _fly
    arrays: dict[str, np.ndarray] = fly(request, system, grid, each, not values, tell)
    return arrays


def _joined(pieces: Sequence[Arrays]) -> Arrays:
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


@stoppable
def _fly(
    request: HistoryRequest, system: Preset, grid: Mapping[str, np.ndarray],
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
            starts[i] = start_state(
                one, float(one.rest or 0.0), request.state[: len(scene.components)]
            )[:4]
    batch = LoadBatch(scene, request.load.shaken, request.tolerance, tell)
    # rounded down by up to an eighth, so that many systems share their loads
    mantissa, exponent = np.frexp(batch.longest(cells))
    reach = np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent)
    marks = np.array([request.settle]) if request.settle else np.zeros(0)  # further edges of cells
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
            loads.append(shared[key].struck(impulse / struck.mass))
        lanes = slice(begin, end)
        orbits = batch.run(cells[lanes], loads, starts[lanes], asked, histories=history)
        arrays = _numbers(request, scene, cells[lanes], orbits)
        if history:
            along = _Followed(batch, cells, each[0][0], struck, longest, loads[0], orbits)
            arrays |= _histories(request, scene, cells, orbits, *states_at(request.times, along))
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


class _Followed(NamedTuple):
    """An orbit that has been followed under a load."""

    batch: LoadBatch
    cells: np.ndarray  # (1,) of the scene
    load: Loading
    struck: Struck
    longest: float  # cell of the load [s]
    in_cells: Cells  # the load, with a blow at t = 0
    orbits: LoadResults  # its results, with states at the edges of `in_cells`


def states_at(times: np.ndarray, followed: _Followed) -> tuple[np.ndarray, np.ndarray]:
    """Return the states (1, times, 4) and the sums (1, times, `EDGE_SUMS`) of an orbit at times.

    Pieces of the orbit are followed again with the times as edges, each from a state of the orbit.
    So the orbit itself, and all its numbers, do not depend on the times, and no difference grows
    beyond round-off.
    """
    batch, cells, load, struck, longest, main, orbits = followed
    begins = np.arange(0, len(main.edges) - 1, CELLS_OF_PIECE)
    marks = np.append(times[1:-1], main.edges[begins[1:]])
    fine = load.cells(struck, float(main.edges[-1]), longest, marks)
    firsts = [int(np.abs(fine.edges - main.edges[k]).argmin()) for k in begins]
    ends = [*firsts[1:], len(fine.edges) - 1]
    states, sums = np.empty((len(fine.edges), 4)), np.empty((len(fine.edges), EDGE_SUMS))
    last = len(main.edges) - 1
    states[-1], sums[-1] = orbits.states[0, last], orbits.sums[0, last]
    pieces, starts = [], orbits.states[0, begins].copy()
    for first, end in zip(firsts, ends, strict=True):
        jumps = None
        if fine.jumps is not None:
            jumps = fine.jumps[first : end + 1].copy()
            jumps[[0, -1]] = 0.0  # states are those after the jump
        edges = fine.edges[first : end + 1]
        pieces.append(replace(fine, edges=edges, rows=fine.rows[first:end], jumps=jumps))
    x1, v1, x2, v2 = starts.T.copy()
    starts[:, 2:] = 0.0
    if batch.scene.damper:
        starts[:, 2], starts[:, 3] = x1 - x2 + float(cells["rest"][0]), v1 - v2
    nothing = of_orbit.Asked(np.zeros(0), 0.0)
    again = batch.run(np.repeat(cells, len(pieces)), pieces, starts, nothing, histories=True)
    for piece, (begin, first, end) in enumerate(zip(begins, firsts, ends, strict=True)):
        states[first:end] = again.states[piece, : end - first]
        sums[first:end] = orbits.sums[0, begin] + again.sums[piece, : end - first]
    places = np.searchsorted(fine.edges, times * (1.0 - 1e-14))
    return states[np.newaxis, places], sums[np.newaxis, places]


def _histories(
    request: HistoryRequest,
    scene: Scene,
    cells: np.ndarray,
    orbits: LoadResults,
    states: np.ndarray,
    sums: np.ndarray,
) -> dict[str, np.ndarray]:
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


# ---- hosts ---------------------------------------------------------------------------------------


@stoppable
def _fly_hosts(
    request: HistoryRequest, system: General, grid: Mapping[str, np.ndarray],
    each: Sequence[tuple[Loading, float]], history: bool, tell: Tell | None,
) -> Arrays:  # fmt: skip
    """Follow an orbit of a host under `each` load; return `OF_HOSTS`, and histories if asked.

    The `grid` (n,) has parameters of dampers, which are not checked, and factors on the host's
    `STIFFNESS`; `each` as of `_fly`.  With histories there are also `touches` (impacts, columns).
    """
    pieces, shared = dict[int, Arrays](), dict[tuple[int, float], Any]()
    marks = request.times[1:-1] if history else np.zeros(0)

    def fly(begin: int, end: int) -> None:
        for lane in range(begin, end):
            check()
            one = system.with_values(grid, (float(column[lane]) for column in grid.values()))
            load, impulse = each[lane]
            if load.acts or impulse:
                one = one.under(load)
            else:
                one = one.with_values(["ground.acceleration"], [-1.0])
            longest = longest_cell(one, request.duration)
            key = id(load), longest
            if key not in shared:
                shared[key] = cells_of(load, request.duration, longest, marks)
            cells, drives = shared[key]
            in_cells = cells.struck(impulse), drives
            pieces[lane] = _arrays_of_orbit(request, one, in_cells, history)

    needed = Needed("a host", "exact", ())
    with Compilation(needed, tell, helped=False).followed({RUN_UNDER: "orbit"}):
        in_pieces(fly, len(each), most=ORBITS_AT_ONCE)
    lanes = [pieces[lane] for lane in range(len(each))]
    return {name: np.concatenate([one[name] for one in lanes]) for name in lanes[0]}


def _arrays_of_orbit(
    request: HistoryRequest, system: General, cells: tuple[Cells, int], history: bool
) -> dict[str, np.ndarray]:
    owners, own = owners_of(request), [damper.name for damper in system.dampers]
    settings = chosen_settings("exact", {"tolerance": request.tolerance})
    orbits = HostOrbits(system, settings.stepped_to)
    shown = [name for name in owners["displacement"] if _has_displacement(system, name)]
    strokes = [damper.stroke for damper in system.dampers]
    start = orbits.start(request.state[: 2 * orbits.size] or None)
    orbit = follow_load(orbits, cells, start, [*shown, *strokes])
    arrays = _histories_of_host(owners, system, orbits, orbit)
    E1max, E2max = energies_of(orbit.records, system)
    arrays["E1max"] = np.array(E1max)
    levels = [share * E1max for share in SHARES]
    if orbit.status == OK:
        times = last_times(orbits, cells, orbit, levels)
    else:
        times = [np.nan] * len(levels)
    for share, time in zip(SHARES, times, strict=True):
        arrays[f"last_{100 * share:g}"] = np.array(time)
    for column, name in enumerate(responses.OF_ROWS):
        by_name = dict(zip(shown, orbit.response[: len(shown), column], strict=True))
        arrays[name] = np.array([by_name.get(one, np.nan) for one in owners["displacement"]])
    damper, force = orbit.impacts["damper"], orbit.impacts["force"]
    columns: dict[str, Any] = {
        "E2max": np.where([d.m is None for d in system.dampers], np.nan, E2max),
        "stroke_max": orbit.response[len(shown) :, 0],
        "force_max": [force[damper == name].max(initial=0.0) for name in own],
        "impulse_max": orbit.impulses,
        "impact_count": [np.count_nonzero(damper == name) for name in own],
    }
    for name, values in columns.items():
        by_damper = dict(zip(own, values, strict=True))
        arrays[name] = np.array([by_damper.get(one, np.nan) for one in owners["damper"]], float)
    if orbit.status != OK:
        arrays = {name: np.full_like(values, np.nan) for name, values in arrays.items()}
    if history:
        places = np.searchsorted(orbit.edges, request.times * (1.0 - 1e-14))
        arrays |= {name: arrays[name][..., places] for name in HOST_HISTORIES}
    else:
        arrays = {entry.name: arrays[entry.name] for entry in OF_HOSTS}
    arrays |= {"status": np.array(orbit.status, np.int8), "violations": np.zeros(())}
    arrays = {name: values[np.newaxis] for name, values in arrays.items()}
    if history:
        table = orbit.impacts
        columns = {name: table[name] for name in IMPACT_COLUMNS}
        columns["damper"] = [owners["damper"].index(name) for name in table["damper"]]
        columns["wall"] = [SIDES[side] for side in table["wall"]]
        arrays["touches"] = np.array([*columns.values()], float).T
    return arrays


def _histories_of_host(
    owners: Mapping[str, Sequence[str]], system: General, orbits: HostOrbits, orbit: LoadedOrbit
) -> dict[str, np.ndarray]:
    """Return the `HOST_HISTORIES` at the edges of cells, NaN of what a system does not have."""
    n, edges = len(orbits.modes), orbit.edges
    X, V, _ = np.moveaxis(orbit.section.reshape(-1, 3, orbits.size), 1, 0)
    energy, _ = energies_at(orbits, orbit.section)
    shown, dampers = owners["displacement"], owners["damper"]
    x, a = np.full((2, len(shown), len(edges)), np.nan)
    for i, name in enumerate(shown):
        if _has_displacement(system, name):
            row, moved = system.displacement(name)
            x[i] = combined(orbit.states[:, ::2], row)
            a[i] = combined(orbit.accelerations, row)
            if orbits.system.acceleration:
                a[i] += orbits.system.acceleration * moved * orbit.loads
    E2, stroke = np.full((2, len(dampers), len(edges)), np.nan)
    for k, (damper, row) in enumerate(zip(system.dampers, system.rows(), strict=True), n):
        i = dampers.index(damper.name)
        stroke[i] = combined(orbit.states[:, ::2], row)
        if damper.m is not None:  # dampers with a mass come first
            E2[i] = 0.5 * (damper.m * V[:, k] * V[:, k] + damper.k * X[:, k] * X[:, k])
    return {"E1": energy, "E2": E2, "x": x, "a": a, "stroke": stroke}


def _has_displacement(system: General, name: str) -> bool:
    """Return False for the mass of a damper that another system of the request has."""
    try:
        system.displacement(name)
    except RequestError:
        return False
    return True
