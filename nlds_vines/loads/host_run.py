"""Response histories of hosts: the arrays of an archive, an orbit at a time."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from nlds_vines.loads.host_histories import (
    HOST_HISTORIES,
    IMPACT_COLUMNS,
    dampers_of,
    displacements_of,
    has_displacement,
)
from nlds_vines.loads.request import HistoryRequest
from nlds_vines.model.host_system import SIDES, HostSystem
from nlds_vines.model.quantities import OF_HOSTS, SHARES
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.host_loads import RUN_UNDER, LoadedOrbit, cells_of, combined, follow_load
from nlds_vines.orbits.host_orbits import HostOrbits
from nlds_vines.orbits.records import OK
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Tell
from nlds_vines.runs.store import Arrays

ORBITS_AT_ONCE = 4  # orbits that a thread takes at a time


@stoppable
def arrays_of_hosts(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of orbits by name.

    They are arrays (orbits, ...) of `OF_HOSTS`, `status`, and without axes `HOST_HISTORIES`; and
    `touches` (impacts, 1 + len(IMPACT_COLUMNS)), which begin with the number of the orbit.
    """
    pieces = dict[int, Arrays]()

    def fly(begin: int, end: int) -> None:
        for place in range(begin, end):
            check()
            pieces[place] = _arrays_of_orbit(request, cases[place])

    with Compilation(Needed("a host", "exact", ()), tell, helped=False).followed(
        {RUN_UNDER: "orbit"}
    ):
        in_pieces(fly, len(cases), most=ORBITS_AT_ONCE)
    each = [pieces[place] for place in range(len(cases))]
    return {name: np.concatenate([one[name] for one in each]) for name in each[0]}


def _arrays_of_orbit(request: HistoryRequest, case: int) -> dict[str, np.ndarray]:
    system, load = request.case(case)
    still = replace(system, force=MappingProxyType({}), acceleration=-1.0)
    settings = chosen_settings("exact", {"tolerance": request.tolerance})
    orbits = HostOrbits(system.under(load) if load.acts else still, settings.stepped_to)
    cells = cells_of(system, load, request.duration, request.times[1:-1])
    orbit = follow_load(orbits, cells, orbits.start(request.state[: 2 * orbits.size] or None))
    arrays = _histories(request, system, orbits, orbit)
    arrays |= _quantities(request, system, orbit, arrays)
    if orbit.status != OK:
        arrays = {name: np.full_like(values, np.nan) for name, values in arrays.items()}
    if request.vary:
        arrays = {entry.name: arrays[entry.name] for entry in OF_HOSTS}
    else:
        places = np.searchsorted(orbit.edges, request.times * (1.0 - 1e-14))
        arrays |= {name: arrays[name][..., places] for name in HOST_HISTORIES}
    arrays = {name: values[np.newaxis] for name, values in arrays.items()}
    dampers, touches = dampers_of(request), orbit.impacts
    rows = np.empty((len(touches), 1 + len(IMPACT_COLUMNS)))
    rows[:, 0] = case
    for column, name in enumerate(("touch", "release", "speed", "force", "depth"), 1):
        rows[:, column] = touches[name]
    rows[:, -2] = [dampers.index(name) for name in touches["damper"]]
    rows[:, -1] = [SIDES[side] for side in touches["wall"]]
    return {**arrays, "touches": rows, "status": np.array([orbit.status], dtype=np.int8)}


def _histories(
    request: HistoryRequest, system: HostSystem, orbits: HostOrbits, orbit: LoadedOrbit
) -> dict[str, np.ndarray]:
    """Return the `HOST_HISTORIES` at the edges of cells, NaN of what a system does not have."""
    n, size = len(orbits.modes), orbits.size
    X, V, _ = np.moveaxis(orbit.section.reshape(-1, 3, size), 1, 0)
    energy, edges = np.zeros(len(X)), orbit.edges
    for k in range(n):
        energy += 0.5 * (V[:, k] * V[:, k] + orbits.body.squares[k] * X[:, k] * X[:, k])
    shown, dampers = displacements_of(request), dampers_of(request)
    x, a = np.full((2, len(shown), len(edges)), np.nan)
    for i, name in enumerate(shown):
        if has_displacement(system, name):
            row, moved = system.displacement(name)
            x[i] = combined(orbit.states[:, ::2], row)
            a[i] = combined(orbit.accelerations, row)
            if orbits.system.acceleration:
                a[i] += orbits.system.acceleration * moved * orbit.loads
    E2, stroke = np.full((2, len(dampers), len(edges)), np.nan)
    masses, rows = [one for one in system.dampers if one.m is not None], system.rows()
    for damper, row in zip(system.dampers, rows, strict=True):
        i = dampers.index(damper.name)
        stroke[i] = combined(orbit.states[:, ::2], row)
        if damper.m is not None:
            k = n + masses.index(damper)
            E2[i] = 0.5 * (damper.m * V[:, k] * V[:, k] + damper.k * X[:, k] * X[:, k])
    return {"E1": energy, "E2": E2, "x": x, "a": a, "stroke": stroke}


def _quantities(
    request: HistoryRequest, system: HostSystem, orbit: LoadedOrbit, histories: Arrays
) -> dict[str, np.ndarray]:
    """Return the arrays of `OF_HOSTS`."""
    edges, E1 = orbit.edges, histories["E1"]
    arrays = {"E1max": E1.max(), "E2max": histories["E2"].max(axis=-1)}
    arrays["x_max"], arrays["a_max"] = (np.abs(histories[k]).max(axis=-1) for k in "xa")
    arrays["stroke_max"] = np.abs(histories["stroke"]).max(axis=-1)
    squares = np.diff(edges) * (histories["x"][:, 1:] ** 2 + histories["x"][:, :-1] ** 2)
    arrays["x_rms"] = np.sqrt(0.5 * squares.sum(axis=-1) / edges[-1])
    for share in SHARES:
        least = share * arrays["E1max"]
        above, last = np.flatnonzero(least < E1), 0.0
        if above.size and (i := above[-1]) < len(E1) - 1:  # on a line between two edges
            last = edges[i] + (edges[i + 1] - edges[i]) * (E1[i] - least) / (E1[i] - E1[i + 1])
        elif above.size:
            last = np.nan
        arrays[f"last_{100 * share:g}"] = np.array(last)
    dampers, names = dampers_of(request), [one.name for one in system.dampers]
    count, force = np.full((2, len(dampers)), np.nan)
    for i, name in enumerate(dampers):
        if name in names:
            own = orbit.impacts[orbit.impacts["damper"] == name]
            count[i], force[i] = len(own), own["force"].max(initial=0.0)
    return {**arrays, "impact_count": count, "force_max": force}
