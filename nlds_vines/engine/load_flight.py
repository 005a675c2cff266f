"""Orbits of one structure with one damper or none under loads in time.

A load is a force on the structure, a polynomial in each of its cells.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.batch import parts_of, room_for_impacts, start_state
from nlds_vines.engine.compilation import Compilation, Needed
from nlds_vines.engine.load_task import LoadOfOrbit, LoadTask
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.kernels.cells import load_numbers as of_orbit
from nlds_vines.kernels.cells.load_numbers import (
    ORBIT_NUMBERS,
    Asked,
    LoadResults,
    Loads,
    fill_rates,
    fly_orbits,
)
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS
from nlds_vines.kernels.motion.flight import ORDER, REACH
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.watch.observe import (
    IMPACT_DEPTH,
    IMPACT_FORCE,
    RELEASE,
    SPEED,
    TOUCH,
    WALL,
    Impacts,
)
from nlds_vines.model.loads.loading import Cells, Loading, Struck
from nlds_vines.model.parameters import SIDES
from nlds_vines.model.presets import NEAR, cell_type
from nlds_vines.model.quantities import OF_LOADS_BY_NAME, SHARES, TOUCH_COLUMNS, WAYS
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import Preset
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Tell

_SUMS = getattr(sums_of, "entry", sums_of)

PIECE_BYTES = 1 << 26  # of loads in a thread's memory at once, if no two orbits share theirs
EDGE_BYTES = 8 * 18  # bytes of a cell of a load: its coefficients, its edge and its jump
CELLS_OF_PIECE = 64  # cells of a load in which a history is followed again at once
ROOM = 1024  # for the impacts of a history at first


class InCells(Protocol):
    """A force on the structure in n cells.

    In cell j it is sum_k rows[j, k] x^k with x from 0 to 1.  If the ground moves, `rows` are -m1
    times its acceleration and `jumps` minus those of its velocity; they act on both bodies, and
    positions are relative to the ground.
    """

    edges: np.ndarray  # (n + 1,) times [s]
    rows: np.ndarray  # (n, 15) coefficients of the force [N]
    jumps: np.ndarray | None  # (n + 1,) of the structure's velocity at the edges [m/s]
    share: float  # 1; 0 if the ground moves


class LoadBatch:
    """Integrates orbits of one scene under loads, in any number of threads at a time."""

    def __init__(
        self,
        scene: Scene,
        shaken: bool,
        tolerance: float | str | None = None,
        tell: Tell | None = None,
    ) -> None:
        """Prepare the constants, and compile the kernels unless the cache has them."""
        self.scene, self._shaken = scene, True if shaken else None
        self._parts = parts_of("exact", scene, chosen_settings("exact", {"tolerance": tolerance}))
        needed = Needed(scene.key, "exact", ("response history",))
        kernels = dict.fromkeys((fly_orbits, fill_rates), "orbit")
        with Compilation(needed, tell, helped=False).followed(kernels):
            nothing = np.zeros(0, cell_type(scene))
            self.longest(nothing)
            self.run(nothing, [], np.zeros((0, 4)), Asked(np.zeros(3), 0.0))

    def longest(self, cells: np.ndarray) -> np.ndarray:
        """Return the longest cell of a load [s] for each of the cells (orbits,) of the scene."""
        rates = np.zeros(len(cells))
        fill_rates(self._parts, cells.view(np.recarray), rates)
        with np.errstate(divide="ignore"):
            return REACH / rates

    def run(
        self,
        cells: np.ndarray,
        loads: Sequence[InCells],
        starts: np.ndarray,
        asked: Asked,
        histories: bool = False,
        room: int = 0,
    ) -> LoadResults:
        """Integrate one orbit for each of the `cells` (orbits,), from the first edge of its load.

        Arguments: `loads` in cells no longer than `longest`; `starts` (orbits, 4), x1, v1, r, s
        before the first jump; the levels of the response quantities that are `asked`, if any;
        `histories`, whether the results include states and energies at all edges; `room` for
        impacts of the first orbit.
        """
        count, walls = len(cells), bool(self.scene.walls)
        edges = max((len(load.edges) for load in loads), default=0) if histories else 0
        shape = (count, edges) if histories else (0, 0)
        results = LoadResults(
            numbers=np.full((count, ORBIT_NUMBERS), np.nan),
            response=np.full((count, RESPONSE_COLUMNS), np.nan),
            peak=np.full((count, 2), np.nan),
            violation=None if self.scene.limit is None else np.zeros((count, 3)),
            impacts=room_for_impacts(room) if walls else None,
            states=np.full((*shape, 4), np.nan),
            sums=np.full((*shape, EDGE_SUMS), np.nan),
            status=np.zeros(count, np.int64),
        )
        # all loads after one another, those with the same rows once
        places: dict[int, int] = {}
        times, rows, jumps = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
        first, blow = np.zeros(count, np.int64), np.zeros(count, np.int64)
        end = jumped = 0
        for i, load in enumerate(loads):
            edges = len(load.edges)
            if id(load.rows) not in places:
                places[id(load.rows)] = end
                times.append(load.edges)
                rows += [load.rows.ravel(), np.zeros(ORDER + 1)]
                end += edges
            jumps.append(np.zeros(edges) if load.jumps is None else load.jumps)
            first[i], blow[i], jumped = places[id(load.rows)], jumped, jumped + edges
        after = first + np.array([len(load.edges) for load in loads], np.int64)
        flat = np.concatenate(rows)
        together = Loads(
            np.concatenate(times), flat, _SUMS(flat), np.concatenate(jumps), first, after, blow,
            self._shaken,
        )  # fmt: skip
        begun = np.ascontiguousarray(starts, dtype=float)
        records = cells.view(np.recarray)
        fly_orbits(0, count, self._parts, records, together, begun, asked, results)
        return results


class KindLoads:
    """The kernels for orbits of one of the paper's kinds; see `load_task.LoadRunner`."""

    def __init__(self, system: Preset, task: LoadTask, tell: Tell | None = None) -> None:
        self.system = system
        self._task = task
        self._tell = tell

    @property
    def names(self) -> frozenset[str]:
        scene = self.system.scene
        names = {f"last_{100 * share:g}" for share in SHARES}
        names |= {"damping_ratio", "shear_max", "E1max", "energy_in", "balance", "x1_rms"}
        names |= {f"share_{sink}" for sink in self._sinks}
        names |= OF_LOADS_BY_NAME.keys() & {entry.name for entry in responses.quantities_of(scene)}
        if scene.damper:
            names.add("E2max")
        if scene.walls:
            names.add("impact_count")
        if self._task.has_histories:
            names |= {"E1", "x1", "work"}
            names |= {f"dissipated_{sink}" for sink in self._sinks}
            names |= {"x2", "E2"} if scene.damper else set()
        return frozenset(names)

    @stoppable
    def run(
        self, grid: Mapping[str, np.ndarray], loads: Sequence[LoadOfOrbit]
    ) -> dict[str, np.ndarray]:
        task = self._task
        count = len(loads)
        cells = np.broadcast_to(self.system.cells(grid), (count,)).copy()
        starts = self._starts(grid, count)
        batch = LoadBatch(self.system.scene, task.shaken, task.tolerance, self._tell)
        # rounded down by up to an eighth, so that many systems share their loads
        mantissa, exponent = np.frexp(batch.longest(cells))
        reach = np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent)
        marks = np.array([task.settle]) if task.settle else np.zeros(0)  # further edges of cells
        asked = of_orbit.Asked(np.array(SHARES), task.settle)
        pieces = dict[int, dict[str, np.ndarray]]()

        def fly(begin: int, end: int) -> None:
            check()
            shared = dict[tuple[Any, ...], Cells]()
            in_cells = []
            for lane in range(begin, end):
                load, impulse = loads[lane]
                cell = cells[lane]
                longest = float(reach[lane])
                force = (float(cell["P"]), float(cell["omega"])) if load.harmonic else ()
                struck = Struck(float(cell["m1"]), *force)
                key = id(load), struck, longest
                if key not in shared:
                    shared[key] = load.cells(struck, task.duration, longest, marks)
                in_cells.append(shared[key].struck(impulse / struck.mass))
            lanes = slice(begin, end)
            asked_for = cells[lanes], in_cells, starts[lanes], asked, task.has_histories
            orbits = batch.run(*asked_for, room=ROOM if task.has_histories else 0)
            arrays = self._numbers(cells[lanes], orbits)
            if task.has_histories:
                impacts = orbits.impacts
                if impacts is not None and impacts.filled[0] > len(impacts.data):
                    # the same orbit has the same number of impacts
                    orbits = batch.run(*asked_for, room=int(impacts.filled[0]))
                load, _ = loads[0]
                followed = Followed(batch, cells, load, struck, longest, in_cells[0], orbits)
                arrays |= self._histories(cells, orbits, *states_at(task.times, followed))
                if orbits.impacts is not None:
                    arrays["touches"] = self._touches(cells[0], orbits.impacts)
            pieces[begin] = arrays

        most = max(1, PIECE_BYTES // (EDGE_BYTES * max(1, len(task.times) - 1)))
        in_pieces(fly, count, most=most)
        in_order = [pieces[begin] for begin in sorted(pieces)]
        return {name: np.concatenate([one[name] for one in in_order]) for name in in_order[0]}

    def _starts(self, grid: Mapping[str, np.ndarray], count: int) -> np.ndarray:
        """Return the states x1, v1, r, s (count, 4) before the first jumps."""
        starts = np.zeros((count, 4))
        if self._task.state:
            state = self._task.state[: len(self.system.scene.components)]
            for i in range(count):
                changes = {name: float(column[i]) for name, column in grid.items()}
                one = self.system.with_(**changes)
                starts[i] = start_state(one, float(one.rest or 0.0), state)[:4]
        return starts

    @property
    def _sinks(self) -> dict[str, int]:
        """The places in `WAYS` of what dissipates energy in the scene, by name."""
        has = {"c1": True, "c2": self.system.scene.damper, "contact": bool(self.system.scene.walls)}
        return {sink: place for place, sink in enumerate(WAYS) if has[sink]}

    def _numbers(self, cells: np.ndarray, orbits: LoadResults) -> dict[str, np.ndarray]:
        scene = self.system.scene
        column = orbits.numbers.T
        quantities = {
            f"last_{100 * share:g}": column[of_orbit.LAST_TIMES + i]
            for i, share in enumerate(SHARES)
        }
        for name, values in responses.arrays_of(orbits.response, scene, cells).items():
            if name in OF_LOADS_BY_NAME:
                quantities[name] = values.max(axis=-1) if values.ndim > 1 else values
        fall = column[of_orbit.DECAY_TIME]  # [s], from the largest E1 to a tenth of it
        energy_in = column[of_orbit.ENERGY_IN]
        with np.errstate(divide="ignore", invalid="ignore"):
            period = 2 * math.pi / np.sqrt(cells["k1"] / cells["m1"])
            ratio = math.log(10.0) / (4 * math.pi * (fall / period))
            for sink, place in self._sinks.items():
                quantities[f"share_{sink}"] = column[of_orbit.DISSIPATED + place] / energy_in
        quantities["damping_ratio"] = np.where(fall > 0.0, ratio, np.nan)
        quantities["shear_max"] = cells["k1"] * quantities["x1_max"]
        quantities["E1max"] = orbits.peak[:, 0]
        if scene.damper:
            quantities["E2max"] = orbits.peak[:, 1]
        quantities["energy_in"] = energy_in
        quantities["balance"] = column[of_orbit.BALANCE]
        quantities["x1_rms"] = column[of_orbit.RMS]
        failed = orbits.status != OK
        arrays = {name: np.where(failed, np.nan, values) for name, values in quantities.items()}
        if scene.walls:
            arrays["impact_count"] = np.where(failed, -1, column[of_orbit.IMPACTS]).astype(np.int32)
        for name, values in arrays.items():
            if OF_LOADS_BY_NAME[name].dims:
                arrays[name] = values[:, np.newaxis]  # of the only damper
        arrays["status"] = orbits.status
        violation = orbits.violation
        arrays["violations"] = np.zeros(len(cells)) if violation is None else violation[:, 2]
        return arrays

    def _touches(self, cell: np.void, impacts: Impacts) -> np.ndarray:
        """Return the impacts (impacts, columns) of an orbit, in the columns of `TOUCH_COLUMNS`."""
        scene = self.system.scene
        rows = impacts.data[: impacts.filled[0]]
        columns = {
            "touch": rows[:, TOUCH],
            "release": rows[:, RELEASE],
            "speed": rows[:, SPEED],
            "force": rows[:, IMPACT_FORCE].copy(),
            "depth": rows[:, IMPACT_DEPTH],
            "impulse": np.zeros(len(rows)),
            "damper": np.zeros(len(rows)),
            "wall": np.where(rows[:, WALL] == 0, SIDES["+"], SIDES["-"]),
        }
        m1 = float(cell["m1"])
        mass = m1
        if scene.damper:
            m2 = float(cell["m2"])
            mass = m1 * m2 / (m1 + m2)
        for code, wall in enumerate(("near", "far")):
            if wall in scene.walls and scene.law_at(wall).instant:
                at_wall = rows[:, WALL] == code
                has_own_law = scene.law_2 is not None and wall == "near"
                constants = cell[NEAR] if has_own_law else cell
                restitution = float(constants["e"])
                speeds = rows[at_wall, SPEED]
                columns["impulse"][at_wall] = (1.0 + restitution) * mass * speeds
                columns["force"][at_wall] = np.inf
        return np.array([columns[name] for name in TOUCH_COLUMNS]).T

    def _histories(
        self, cells: np.ndarray, orbits: LoadResults, states: np.ndarray, sums: np.ndarray
    ) -> dict[str, np.ndarray]:
        x1, v1, x2, v2 = np.moveaxis(states, -1, 0)
        p = {name: cells[name][:, None] for name in ("m1", "k1", "m2", "k2", "rest")}
        histories = {
            "E1": 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2),
            "x1": x1,
            "work": orbits.numbers[:, of_orbit.START, None] + sums[..., 0],
        }
        for sink, place in self._sinks.items():
            histories[f"dissipated_{sink}"] = sums[..., 1 + place]
        if self.system.scene.damper:
            histories["x2"] = x2
            histories["E2"] = 0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - p["rest"]) ** 2)
        failed = (orbits.status != OK)[:, None]
        arrays = {name: np.where(failed, np.nan, values) for name, values in histories.items()}
        if "E2" in arrays:
            arrays["E2"] = arrays["E2"][:, np.newaxis]  # of the only damper
        return arrays


class Followed(NamedTuple):
    """An orbit that has been followed under a load."""

    batch: LoadBatch
    cells: np.ndarray  # (1,) of the scene
    load: Loading
    struck: Struck
    longest: float  # cell of the load [s]
    in_cells: Cells  # the load, with a blow at t = 0
    orbits: LoadResults  # its results, with states at the edges of `in_cells`


def states_at(times: np.ndarray, followed: Followed) -> tuple[np.ndarray, np.ndarray]:
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
