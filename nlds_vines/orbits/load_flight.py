"""Orbits under loads in time: a force on the structure that is a polynomial in each of its cells.

`fly` records one orbit in full; `LoadBatch` follows many in one call of the kernels, each with its
response quantities.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from nlds_vines.errors import RequestError, choice
from nlds_vines.kernels.cells.load_numbers import (
    ORBIT_NUMBERS,
    Asked,
    LoadResults,
    Loads,
    fill_rates,
    fly_lanes,
)
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS, ROUNDED_UP, Load, fly_under, rate_under
from nlds_vines.kernels.motion.flight import ORDER, REACH
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers
from nlds_vines.model.catalog import as_system
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System, cell_type
from nlds_vines.orbits import responses
from nlds_vines.orbits.compilation import Compilation, Needed, notice
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.records import Violation
from nlds_vines.orbits.simulation import (
    IntegrationError,
    impacts_of,
    room_for_impacts,
    start_state,
)
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.progress import Tell

RECORDS = ("states", "work", "impacts", "energy", "response", "clearance")
"""The records of `fly`."""

LOAD, C1, C2, CONTACT = range(4)
"""Columns of `Flown.work`."""

_FLY = getattr(fly_under, "entry", fly_under)
_SUMS = getattr(sums_of, "entry", sums_of)


class InCells(Protocol):
    """A force on the structure in n cells.

    Attributes:
        edges: (n + 1,) times [s].
        rows: (n, 15) coefficients of the force [N], sum_k rows[j, k] x^k with x from 0 to 1 within
            cell j.
        jumps: (n + 1,) jumps of the structure's velocity at the edges [m/s], or None.
        share: 1; 0 if the ground moves.  Then `rows` are -m1 times the ground's acceleration and
            `jumps` minus those of its velocity; they act on both bodies, and positions are relative
            to the ground.
    """

    edges: np.ndarray
    rows: np.ndarray
    jumps: np.ndarray | None
    share: float


@dataclass(frozen=True)
class Flown:
    """An orbit under a load; attributes that were not recorded are None.

    Attributes:
        times: (n + 1,) edges of the load [s].
        state: the last state.
        states: (n + 1, components) at the edges, behind the jumps [m, m/s].
        work: (n + 1, 4) energies up to the edges [J]: input by force and jumps, dissipated by c1,
            c2 and contacts.
        impacts: one row of dtype `IMPACT` for each touch, in the time of the load.
        E1max, E2max: largest energies [J], exact in time.
        response: by name (`responses.quantities_of`); accelerations are absolute.
        clearance: smallest distance [m] of a pass that misses a wall; inf if none.
        violation: of a scene with a limit.
    """

    system: System
    times: np.ndarray
    state: np.ndarray
    states: np.ndarray | None = None
    work: np.ndarray | None = None
    impacts: np.ndarray | None = None
    E1max: float | None = None
    E2max: float | None = None
    response: Mapping[str, Any] | None = None
    clearance: float | None = None
    violation: Violation | None = None


def longest_cell(system: System) -> float:
    """Return the longest cell of a load [s]: 0.7 over a bound of the rates of the motion."""
    rate = float(rate_under(parts_of("exact", system.scene), system.cell))
    return REACH / rate if rate > 0.0 else math.inf


def fly(
    system: System | str,
    load: InCells,
    *,
    start: Sequence[float] | np.ndarray | None = None,
    record: Collection[str] = ("states", "impacts"),
    tolerance: float | str | None = None,
    contact_steps: float | None = None,
    nodes: int | None = None,
    quiet: bool = False,
) -> Flown:
    """Integrate a system under a load, from the first edge to the last.

    The harmonic force of the system does not act.  Flights are exact to round-off, and no impact is
    missed, as in `simulate`.

    Arguments:
        load: the force, in cells no longer than `longest_cell`.
        start: (x1, v1, x2, v2) before the first jump; at rest by default.
        record: words of `RECORDS`; "work" includes a response.
        system, tolerance, contact_steps, nodes, quiet: as of `simulate`.

    Raises `RequestError` for a wrong argument, `IntegrationError` if the integration fails.
    """
    system = as_system(system)
    for word in record:
        choice("record", word, RECORDS)
    in_cells = _checked(system, load)
    options = {"tolerance": tolerance, "contact_steps": contact_steps, "nodes": nodes}
    settings = chosen_settings("exact", {**options, "period_steps": None})
    parts = parts_of("exact", system.scene, settings)
    cell = system.cell
    begin = start_state(system, cell.rest, start)
    room = 64 + len(in_cells.edges)
    while True:
        state, buffers = begin.copy(), _buffers(system, record, len(in_cells.edges), room)
        needed = Needed(system.scene.key, "exact", tuple(record))
        with Compilation(needed, notice(quiet), helped=False).followed({_FLY: "orbit"}):
            code = fly_under(parts, cell, in_cells, state, buffers)
        if code != OK:
            raise IntegrationError.of(system, code)
        if buffers.impacts is None or buffers.impacts.filled[0] <= room:
            return _flown(system, in_cells, cell.rest, state, buffers)
        room = int(buffers.impacts.filled[0])


def _checked(system: System, load: InCells) -> Load:
    """Return a load as the kernels take it; `RequestError` if it is not valid."""
    edges, rows = (np.ascontiguousarray(a, dtype=float) for a in (load.edges, load.rows))
    n = len(edges) - 1
    jumps = np.zeros(n + 1) if load.jumps is None else np.ascontiguousarray(load.jumps, float)
    if n < 1 or rows.shape != (n, ORDER + 1) or jumps.shape != (n + 1,):
        raise RequestError(
            f"a load of {len(edges)} edges has rows {rows.shape} and jumps {jumps.shape}; "
            f"allowed: ({n}, {ORDER + 1}) and ({n + 1},), of one cell or more"
        )
    for name, values in (("edges", edges), ("rows", rows), ("jumps", jumps)):
        if not np.isfinite(values).all():
            raise RequestError(f"a load has {name} that are not finite")
    lengths, longest = np.diff(edges), longest_cell(system)
    if not (lengths > 0.0).all():
        raise RequestError(f"edge {int(np.argmin(lengths)) + 1} of a load is not behind the last")
    if lengths.max() > longest * ROUNDED_UP:
        raise RequestError(
            f"cell {int(np.argmax(lengths))} of a load lasts {lengths.max():.3g} s; of this system "
            f"allowed: up to {longest:.3g} s"
        )
    shaken = True if load.share == 0.0 else None
    return Load(edges, rows.ravel(), jumps, _SUMS(rows.ravel()), shaken)


def _buffers(system: System, record: Collection[str], edges: int, room: int) -> CellBuffers:
    """Return the buffers of a record, with room for so many impacts."""
    scene = system.scene
    summed = "response" in record or "work" in record
    return CellBuffers(
        section=np.empty((edges, len(scene.components))) if "states" in record else None,
        impacts=room_for_impacts(room) if "impacts" in record and scene.walls else None,
        peak=np.zeros(2) if "energy" in record else None,
        clearance=np.full(1, np.inf) if "clearance" in record and scene.walls else None,
        violation=None if scene.limit is None else np.zeros(3),
        response=np.full(RESPONSE_COLUMNS, np.nan) if summed else None,
        sums=np.empty((edges, EDGE_SUMS)) if "work" in record else None,
    )


def _flown(
    system: System, load: Load, rest: float, state: np.ndarray, buffers: CellBuffers
) -> Flown:
    """Return the records in the user's coordinates."""
    x1, v1, r, s = state[:4].tolist()
    damped, peak, response = system.scene.damper, buffers.peak, buffers.response
    limit = buffers.violation
    return Flown(
        system=system,
        times=load.edges,
        state=np.array([x1, v1, x1 - r + rest, v1 - s] if damped else [x1, v1]),
        states=buffers.section,
        work=None if buffers.sums is None else buffers.sums[:, :4],
        impacts=None if buffers.impacts is None else impacts_of(buffers.impacts, system.scene),
        E1max=None if peak is None else float(peak[0]),
        E2max=float(peak[1]) if peak is not None and damped else None,
        response=None if response is None else responses.values_of(response, system),
        clearance=None if buffers.clearance is None else float(buffers.clearance[0]),
        violation=None if limit is None else Violation(int(limit[2]), *limit[:2].tolist()),
    )


# ---- many orbits ----


class LoadBatch:
    """Integrates orbits of one scene under loads.

    Threads may call `longest` and `run` at the same time.
    """

    def __init__(
        self,
        scene: Scene,
        shaken: bool,
        tolerance: float | str | None = None,
        tell: Tell | None = None,
    ) -> None:
        """Prepare the constants, and compile the kernels unless the cache has them.

        Arguments: whether the loads shake the ground; the `tolerance` of contacts, as of
        `simulate`; `tell` receives messages about compiling.
        """
        self._scene, self._shaken = scene, True if shaken else None
        self._parts = parts_of("exact", scene, chosen_settings("exact", {"tolerance": tolerance}))
        needed = Needed(scene.key, "exact", ("response history",))
        kernels = dict.fromkeys((fly_lanes, fill_rates), "orbit")
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
    ) -> LoadResults:
        """Integrate one orbit for each cell, from the first edge of its load to the last.

        Arguments:
            cells: (orbits,) of the scene, as `System.cells` returns them.
            loads: one for each, in cells no longer than `longest`.
                Loads with the same `rows` are passed to the kernels once.
            starts: (orbits, 4) states x1, v1, r, s before the first jump; zeros at rest.
            asked: the levels of the response quantities.
            histories: whether the results include states and energies at all edges.

        Returns the results by orbit (`load_numbers.LoadResults`).
        """
        count, walls = len(cells), bool(self._scene.walls)
        edges = max((len(load.edges) for load in loads), default=0) if histories else 0
        shape = (count, edges) if histories else (0, 0)
        results = LoadResults(
            numbers=np.full((count, ORBIT_NUMBERS), np.nan),
            response=np.full((count, RESPONSE_COLUMNS), np.nan),
            peak=np.full((count, 2), np.nan),
            violation=None if self._scene.limit is None else np.zeros((count, 3)),
            impacts=room_for_impacts(0) if walls else None,
            states=np.full((*shape, 4), np.nan),
            sums=np.full((*shape, EDGE_SUMS), np.nan),
            status=np.zeros(count, np.int64),
        )
        fly_lanes(
            0, count, self._parts, cells.view(np.recarray), _flat(loads, self._shaken),
            np.ascontiguousarray(starts, dtype=float), asked, results,
        )  # fmt: skip
        return results


def _flat(loads: Sequence[InCells], shaken: bool | None) -> Loads:
    """Concatenate loads, those with the same rows once."""
    places: dict[int, int] = {}
    edges, rows, jumps = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    first, blow = np.zeros(len(loads), np.int64), np.zeros(len(loads), np.int64)
    end = jumped = 0
    for lane, load in enumerate(loads):
        count = len(load.edges)
        if id(load.rows) not in places:
            places[id(load.rows)] = end
            edges.append(load.edges)
            rows += [load.rows.ravel(), np.zeros(ORDER + 1)]
            end += count
        jumps.append(np.zeros(count) if load.jumps is None else load.jumps)
        first[lane], blow[lane], jumped = places[id(load.rows)], jumped, jumped + count
    after = first + np.array([len(load.edges) for load in loads], np.int64)
    flat = np.concatenate(rows)
    return Loads(
        np.concatenate(edges), flat, _SUMS(flat), np.concatenate(jumps), first, after, blow, shaken
    )
