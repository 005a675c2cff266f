"""One orbit in Python: `simulate`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.block import RESOLUTION, cell_of, method_parts
from nlds_vines.errors import RequestError, choice, number, whole
from nlds_vines.kernels.lanes import run_cell
from nlds_vines.kernels.observe import Rows
from nlds_vines.kernels.orbit import SIZE
from nlds_vines.record import COMPONENTS, OK, STATUS, WANTS
from nlds_vines.scan import METHODS
from nlds_vines.system import System
from nlds_vines.wants import refuse_impossible

IMPACT = np.dtype(
    [
        ("wall", "U4"),
        ("touch", float),
        ("release", float),
        ("speed", float),
        ("force", float),
        ("depth", float),
    ]
)
"""A row of `Orbit.impacts`: near or far; times [s]; approach speed [m/s]; peak force [N]; [m]."""

RECORDS = tuple(want for want in WANTS if want != "regime")
"""What `simulate` can record."""


class IntegrationError(RuntimeError):
    """An orbit could not be followed to its end; the message names the remedy."""


@dataclass(frozen=True)
class Orbit:
    """What was recorded of an orbit; None for what was not asked for.

    Attributes:
        system: what was simulated.
        section: the state at t = T, 2T, ..., shape (periods, 4) = x1, v1, x2, v2 [m, m/s]
            ((periods, 2) without a damper), counted from the end of the transient.
        state: the last state.
        impacts: one row of dtype `IMPACT` for each touch; an impact that lasts beyond the end has
            release = NaN.  Time counts from the start of the transient.
        E1max, E2max: largest energies [J], eq. (6), exact in time.
        clearance: smallest distance [m] of an approach that did not become an impact; inf if none.
    """

    system: System
    state: np.ndarray
    section: np.ndarray | None = None
    impacts: np.ndarray | None = None
    E1max: float | None = None
    E2max: float | None = None
    clearance: float | None = None


def simulate(
    system: System,
    periods: int,
    *,
    start: Sequence[float] | None = None,
    transient: int = 0,
    method: str = "exact",
    record: Collection[str] | None = None,
    resolution: float | None = None,
    nodes: int | None = None,
) -> Orbit:
    """Follow one orbit over forcing periods and return what was recorded.

    Arguments:
        system: from `load_system`.
        periods: how many to record (>= 0), after `transient` unrecorded ones.
        start: (x1, v1, x2, v2) [m, m/s] at t = 0, by default at rest; without a damper (x1, v1).
            It may lie on a wall or inside a contact, which then is not counted as an impact.
        method: `exact` (exact flight, certified touch) or `rk4` (fixed steps, refined contacts).
        record: of section, impacts, energy, clearance; by default section and, if there are
            walls, impacts.
        resolution: of `exact`: Runge-Kutta steps of a contact that is stepped (28); of `rk4`:
            steps of a period (512), four times those of a free impact.
        nodes: collocation nodes of a short impact (12).

    Raises `RequestError` for a wrong argument, `IntegrationError` where the orbit ends early.
    Cost with the defaults: about 2 us a period for an SSul NES, once compiled.
    """
    scene = system.scene
    whole("periods", periods, 0)
    whole("transient", transient, 0)
    choice("method", method, METHODS)
    record = _checked_record(system, record)
    resolution = _checked_resolution(method, resolution)
    classical, damper, near, far, arc = method_parts(method, scene, nodes)
    cell = cell_of(system)
    width = 4 if scene.damper else 2
    section = np.empty((periods, width))
    energy = np.zeros(2) if "energy" in record else None
    clearance = np.full(1, np.inf) if "clearance" in record else None
    capacity = 16 + 4 * periods
    while True:
        state = _start_state(system, cell.rest, start)
        rows = _rows(capacity) if "impacts" in record else None
        if clearance is not None:
            clearance[0] = np.inf
        code = run_cell(
            classical,
            damper,
            near,
            far,
            arc,
            resolution,
            cell,
            state,
            section if "section" in record else None,
            None,
            rows,
            energy,
            clearance,
            transient,
            transient,
            periods,
        )
        if code != OK:
            status = STATUS[code]
            raise IntegrationError(f"{system.name}: {status.name}. {status.remedy}")
        if rows is None or rows.filled[0] <= capacity:
            break
        capacity = int(rows.filled[0])  # deterministic: the second run finds as many
    return Orbit(
        system=system,
        state=_user_state(system, cell.rest, state),
        section=section if "section" in record else None,
        impacts=None if rows is None else _impacts(rows),
        E1max=None if energy is None else float(energy[0]),
        E2max=None if energy is None or not scene.damper else float(energy[1]),
        clearance=None if clearance is None else float(clearance[0]),
    )


def _checked_record(system: System, record: Collection[str] | None) -> tuple[str, ...]:
    if record is None:
        return ("section", "impacts") if system.scene.walls else ("section",)
    if isinstance(record, str):
        record = (record,)
    for word in record:
        choice("record", word, RECORDS)
    refuse_impossible(tuple(record), system.scene)
    return tuple(record)


def _checked_resolution(method: str, resolution: float | None) -> float:
    if resolution is None:
        return RESOLUTION[method]
    found = number("resolution", resolution)
    if not 4 <= found <= 1e6:
        raise RequestError(f"resolution = {resolution!r}; allowed: 4 to 1e6")
    return found


def _rows(capacity: int) -> Rows:
    return Rows(np.empty((capacity, 6)), np.zeros(1, np.int64))


def _start_state(system: System, rest: float, start: Sequence[float] | None) -> np.ndarray:
    """Return the kernels' state (x1, v1, r, s, q, mode) of a start in the user's coordinates."""
    state = np.zeros(SIZE)
    if start is None:
        return state
    width = 4 if system.scene.damper else 2
    values = np.asarray(start, dtype=float)
    if values.shape != (width,) or not np.isfinite(values).all():
        names = ", ".join(COMPONENTS[:width])
        raise RequestError(f"start = {start!r}; allowed: {width} finite numbers {names}")
    state[:2] = values[:2]
    if system.scene.damper:
        state[2], state[3] = values[0] - (values[2] - rest), values[1] - values[3]
    return state


def _user_state(system: System, rest: float, state: np.ndarray) -> np.ndarray:
    """Return (x1, v1, x2, v2) of the kernels' state."""
    x1, v1, r, s = state[:4]
    if not system.scene.damper:
        return np.array([x1, v1])
    return np.array([x1, v1, x1 - r + rest, v1 - s])


def _impacts(rows: Rows) -> np.ndarray:
    found = rows.data[: rows.filled[0]]
    table = np.empty(len(found), IMPACT)
    table["wall"] = np.where(found[:, 0] == 0, "near", "far")
    for column, name in enumerate(("touch", "release", "speed", "force", "depth"), start=1):
        table[name] = found[:, column]
    return table
