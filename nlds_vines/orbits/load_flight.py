"""Orbits under a load: a force on the structure that is a polynomial in each of its cells."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from nlds_vines.errors import RequestError, choice
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS, TOLD, Load, fly_under, rate_under
from nlds_vines.kernels.motion.flight import ORDER, REACH
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers
from nlds_vines.model.catalog import as_system
from nlds_vines.model.system import System
from nlds_vines.orbits import responses
from nlds_vines.orbits.compilation import Compilation, Needed, notice
from nlds_vines.orbits.impact_rows import Violation
from nlds_vines.orbits.kernel_inputs import cell_of, parts_of
from nlds_vines.orbits.simulation import (
    IntegrationError,
    impacts_of,
    room_for_impacts,
    start_state,
)
from nlds_vines.orbits.solver_settings import chosen_settings

RECORDS = ("states", "work", "impacts", "energy", "response", "clearance")
"""What `fly` can record."""

LOAD, C1, C2, CONTACT = range(4)
"""Columns of `Flown.work`."""

_FLY = getattr(fly_under, "entry", fly_under)
_SUMS = getattr(sums_of, "entry", sums_of)


class InCells(Protocol):
    """A force on the structure, n cells long.

    Attributes: `edges` (n + 1,), when cells begin and end [s]; `rows` (n, 15), the coefficients of
    the force [N] by the place x in a cell, from 0 to 1: sum_k rows[j, k] x^k; `jumps` (n + 1,), by
    which the structure's velocity jumps at the edges [m/s], or None; `share`, 1, or 0 where the
    ground moves: `rows` are then -m1 times its acceleration, `jumps` those of its velocity
    backward; they act on both bodies, and all positions are counted from the ground.
    """

    edges: np.ndarray
    rows: np.ndarray
    jumps: np.ndarray | None
    share: float


@dataclass(frozen=True)
class Flown:
    """What was recorded of an orbit under a load; None for what was not wanted.

    Attributes:
        system: what was moved.
        times: (n + 1,) the edges of the load [s].
        state: the last state.
        states: (n + 1, components) the states at the edges, behind the jumps there [m, m/s].
        work: (n + 1, 4) energies up to the edges [J]: brought in by force and jumps, dissipated by
            c1, c2 and contacts.
        impacts: one row of dtype `IMPACT` for each touch, in the time of the load.
        E1max, E2max: largest energies [J], exact in time.
        response: largest and rms displacements, velocities and accelerations, forces and mean
            powers, by name (`responses.quantities_of`); accelerations are absolute.
        clearance: smallest distance [m] of an approach that did not become an impact; inf if none.
        violation: of a scene with a limit to keep.
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
    """Return how long a cell of a load may be [s]: 0.7 over a bound of the rates of the motion."""
    rate = float(rate_under(parts_of("exact", system.scene), cell_of(system)))
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
    """Follow a system under a load, from its first edge to its last.

    The load is all that acts on the structure: the harmonic force of the system is not in it.
    Flights are exact to round-off, as `simulate`'s are, and no impact is missed.

    Args:
        system: what is moved, or its name in the catalog.
        load: the force, in cells no longer than `longest_cell`.
        start: (x1, v1, x2, v2) before the first jump; at rest by default.
        record: words of `RECORDS`; "work" comes with a response.
        tolerance, contact_steps, nodes: as of `simulate`.
        quiet: whether not to say that something is compiled.

    Raises `RequestError` for a wrong argument, `IntegrationError` where the orbit ends early.
    """
    system = as_system(system)
    for word in record:
        choice("record", word, RECORDS)
    in_cells = _checked(system, load)
    options = {"tolerance": tolerance, "contact_steps": contact_steps, "nodes": nodes}
    settings = chosen_settings("exact", {**options, "period_steps": None})
    parts = parts_of("exact", system.scene, settings)
    cell = cell_of(system)
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
    """Return a load as the kernels take it; `RequestError` where it is none."""
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
    if lengths.max() > longest * TOLD:
        raise RequestError(
            f"cell {int(np.argmax(lengths))} of a load lasts {lengths.max():.3g} s; of this system "
            f"allowed: up to {longest:.3g} s"
        )
    shaken = True if load.share == 0.0 else None
    return Load(edges, rows.ravel(), jumps, _SUMS(rows.ravel()), shaken)


def _buffers(system: System, record: Collection[str], edges: int, room: int) -> CellBuffers:
    """Return what a record is filled into, with room for so many impacts."""
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
    """Return what was recorded, in the user's coordinates."""
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
