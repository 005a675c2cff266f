"""Orbits of hosts under loads in time: forces on degrees of freedom, or motion of the ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.kernels.hosts.host_load import HostLoad, run_host_under
from nlds_vines.kernels.motion.flight import REACH
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.loads.loading import Cells, Loading, Struck
from nlds_vines.orbits.host_orbits import HostOrbits

NEGLIGIBLE = 1e-18  # of a load's coefficients, relative to the largest one: beyond its degree
RUN_UNDER: Any = getattr(run_host_under, "entry", run_host_under)


class LoadedOrbit(NamedTuple):
    """An orbit under a load."""

    status: int
    edges: np.ndarray  # (n,) times [s]
    section: np.ndarray  # (n, 3 size) X, X' and X'' by mode and mass
    states: np.ndarray  # (n, components) [m, m/s]
    accelerations: np.ndarray  # (n, coordinates and masses) relative to the ground [m/s^2]
    loads: np.ndarray  # (n,) the force on a dof of factor 1 [N], or minus the ground's acceleration
    impacts: np.ndarray  # of dtype `records.HOST_IMPACT`
    records: Any  # `HostRecords`: largest energies and the response of displacements


def longest_cell(system: HostSystem, duration: float) -> float:
    """Return the longest cell of a load on a host [s].

    It is `REACH` at the rate of the second slowest motion; the kernels halve it for faster ones.
    """
    own = [damper.k / damper.m for damper in system.dampers if damper.m]
    rates = np.sort(np.concatenate([system.host.frequencies[:2], np.sqrt(own)]))
    rates = rates[rates > 0.0]
    if not rates.size:
        return duration
    # rounded down by up to an eighth: eigenvalues by LAPACK differ in their last bits, and many
    # systems share their loads
    mantissa, exponent = np.frexp(REACH / min(rates[min(1, rates.size - 1)], 2.0 * rates[0]))
    return float(np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent))


def cells_of(
    load: Loading, duration: float, longest: float, marks: np.ndarray
) -> tuple[Cells, int]:
    """Return a load in cells, with edges at `marks` [s], and the number of its drives."""
    cells = load.cells(Struck(1.0), duration, longest, marks)
    sizes = np.abs(cells.rows).max(axis=0)
    degree = int(np.flatnonzero(sizes > NEGLIGIBLE * sizes.max())[-1]) if sizes.any() else 0
    return cells, max(2, 2 * (degree // 2 + 1))


def follow_load(
    orbits: HostOrbits, in_cells: tuple[Cells, int], state: np.ndarray, names: Sequence[str] = ()
) -> LoadedOrbit:
    """Integrate an orbit of a system `under` a load from a kernels' state on, which is advanced.

    names: displacements whose largest values are recorded.
    """
    (cells, drives), size, start = in_cells, orbits.size, state.copy()
    orbits.body = orbits.body._replace(drives=drives, paces=np.zeros(drives))
    edges, jumps = cells.edges, cells.jumps
    rows = np.zeros((len(cells.rows), max(drives, cells.rows.shape[1])))
    rows[:, : cells.rows.shape[1]] = cells.rows
    rows = np.ascontiguousarray(rows[:, :drives])
    load = HostLoad(edges, rows.ravel(), np.zeros(len(edges)) if jumps is None else jumps)
    section, room = np.zeros((len(edges), 3 * size)), 1024
    while True:
        records = orbits.records(True, names)
        impacts, how = orbits.room_for(room), (orbits.body, orbits.walls, orbits.contacts())
        code = run_host_under(*how, load, state, section, impacts, records)
        if code != OK or impacts.filled[0] <= room:
            break
        room, state[:] = int(impacts.filled[0]), start
    accelerations = np.hstack([section[:, 2 * size :]] * 2)
    return LoadedOrbit(
        code,
        edges,
        section,
        orbits.states(section[:, : 2 * size]),
        orbits.states(accelerations)[:, ::2],
        np.append(rows[:, 0], rows[-1].sum()),
        orbits.table_of(impacts),
        records,
    )


def combined(values: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Return the sums (n,) of `values` (n, m) times a row (m,), each in one order."""
    total = np.zeros(len(values))
    for k in np.flatnonzero(row):
        total += values[:, k] * row[k]
    return total
