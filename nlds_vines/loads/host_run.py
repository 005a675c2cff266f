"""Response histories of hosts: the arrays of an archive, an orbit at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.loads.host_histories import (
    HOST_HISTORIES,
    IMPACT_COLUMNS,
    dampers_of,
    displacements_of,
    has_displacement,
    names_of_numbers,
    stroke_of,
)
from nlds_vines.loads.request import HistoryRequest, has, is_of_load
from nlds_vines.model.host import Host, with_stiffness
from nlds_vines.model.host_system import SIDES, HostSystem
from nlds_vines.model.loads.loading import Cells, Loading
from nlds_vines.model.quantities import OF_HOSTS, SHARES
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.host_loads import (
    RUN_UNDER,
    LoadedOrbit,
    cells_of,
    combined,
    follow_load,
    longest_cell,
)
from nlds_vines.orbits.host_orbits import RESPONSE, HostOrbits, energies_of, response_of
from nlds_vines.orbits.records import OK
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Tell
from nlds_vines.runs.store import Arrays

ORBITS_AT_ONCE = 4  # orbits that a thread takes at a time


def arrays_of_hosts(request: HistoryRequest, cases: range, tell: Tell | None = None) -> Arrays:
    """Return the results of a range of orbits by name.

    They are arrays (orbits, ...) of `OF_HOSTS`, `status`, and without axes `HOST_HISTORIES`; and
    `touches` (impacts, 1 + len(IMPACT_COLUMNS)), which begin with the number of the orbit.
    """
    each = _fly(request, [request.case(case) for case in cases], not request.vary, tell)
    for case, arrays in zip(cases, each, strict=True):
        arrays["touches"] = np.insert(arrays["touches"], 0, case, axis=1)
    return {name: np.concatenate([one[name] for one in each]) for name in each[0]}


def numbers_of_hosts(
    request: HistoryRequest,
    system: HostSystem,
    values: Mapping[str, np.ndarray],
    tell: Tell | None,
) -> dict[str, np.ndarray]:
    """Return the quantities (n,) of a host by name: roof.x_max ..., as `run.numbers_of` does.

    The `values` (n,) are parameters of dampers, which are not checked, numbers of the load, `draw`,
    and factors on the host's `stiffness`.  `E2max` is that of all dampers, `impact_count` the sum.
    """
    lanes, loads = [], dict[tuple[float, ...], Loading]()
    own = [name for name in values if has(system, name)]
    numbers = [name for name in values if is_of_load(name) or name == "draw"]
    for lane in range(len(next(iter(values.values())))):
        one = system.with_values(own, (float(values[name][lane]) for name in own))
        if "stiffness" in values:
            one = replace(one, host=_stiffened(one.host, float(values["stiffness"][lane])))
        key = tuple(float(values[name][lane]) for name in numbers)
        if key not in loads:
            changes = dict(zip(numbers, key, strict=True))
            draw = int(changes.pop("draw", 0))
            load = request.load.redrawn(draw) if draw else request.load
            loads[key] = load.with_(changes)
        lanes.append((one, loads[key]))
    each = _fly(request, lanes, False, tell)
    arrays = {name: np.concatenate([one[name] for one in each]) for name in each[0]}
    flat = {
        name: arrays[dataset] if place is None else arrays[dataset][:, place]
        for name, (dataset, place) in names_of_numbers(request).items()
    }
    with np.errstate(invalid="ignore"):
        flat["E2max"] = np.fmax.reduce(arrays["E2max"], axis=1, initial=0.0)
        flat["impact_count"] = np.add.reduce(np.nan_to_num(arrays["impact_count"]), axis=1)
    return {**flat, "status": arrays["status"], "violations": np.zeros(len(lanes))}


@lru_cache(maxsize=16)
def _stiffened(host: Host, factor: float) -> Host:
    return host if factor == 1.0 else with_stiffness(host, factor)


@stoppable
def _fly(
    request: HistoryRequest,
    lanes: Sequence[tuple[HostSystem, Loading]],
    history: bool,
    tell: Tell | None,
) -> list[dict[str, np.ndarray]]:
    """Return the arrays of each system under its load."""
    pieces, shared = dict[int, dict[str, np.ndarray]](), dict[tuple[int, float], Any]()
    marks = request.times[1:-1]

    def fly(begin: int, end: int) -> None:
        for place in range(begin, end):
            check()
            system, load = lanes[place]
            longest = longest_cell(system, request.duration)
            key = id(load), longest
            if key not in shared:
                shared[key] = cells_of(load, request.duration, longest, marks)
            pieces[place] = _arrays_of_orbit(request, lanes[place], shared[key], history)

    needed = Needed("a host", "exact", ())
    with Compilation(needed, tell, helped=False).followed({RUN_UNDER: "orbit"}):
        in_pieces(fly, len(lanes), most=ORBITS_AT_ONCE)
    return [pieces[place] for place in range(len(lanes))]


def _arrays_of_orbit(
    request: HistoryRequest,
    case: tuple[HostSystem, Loading],
    cells: tuple[Cells, int],
    history: bool,
) -> dict[str, np.ndarray]:
    system, load = case
    still = replace(system, force=MappingProxyType({}), acceleration=-1.0)
    settings = chosen_settings("exact", {"tolerance": request.tolerance})
    orbits = HostOrbits(system.under(load) if load.acts else still, settings.stepped_to)
    shown = [name for name in displacements_of(request) if has_displacement(system, name)]
    names = [*shown, *(stroke_of(damper) for damper in system.dampers)]
    start = orbits.start(request.state[: 2 * orbits.size] or None)
    orbit = follow_load(orbits, cells, start, names)
    arrays = _histories(request, system, orbits, orbit)
    E1max, E2max = energies_of(orbit.records, system)
    response = response_of(orbit.records, request.duration)
    arrays |= {"E1max": np.array(E1max), **_last_times(orbit.edges, arrays["E1"], E1max)}
    for column, name in enumerate(RESPONSE):
        by_name = dict(zip(shown, response[: len(shown), column], strict=True))
        arrays[name] = np.array([by_name.get(one, np.nan) for one in displacements_of(request)])
    columns: dict[str, Any] = {
        "E2max": np.where([d.m is None for d in system.dampers], np.nan, E2max),
        "stroke_max": response[len(shown) :, 0],
        "force_max": [_largest_force(orbit.impacts, d.name) for d in system.dampers],
        "impact_count": [np.sum(orbit.impacts["damper"] == d.name) for d in system.dampers],
    }
    own = [damper.name for damper in system.dampers]
    for name, values in columns.items():
        by_damper = dict(zip(own, values, strict=True))
        arrays[name] = np.array([by_damper.get(one, np.nan) for one in dampers_of(request)], float)
    if orbit.status != OK:
        arrays = {name: np.full_like(values, np.nan) for name, values in arrays.items()}
    if not history:
        arrays = {entry.name: arrays[entry.name] for entry in OF_HOSTS}
    else:
        places = np.searchsorted(orbit.edges, request.times * (1.0 - 1e-14))
        arrays |= {name: arrays[name][..., places] for name in HOST_HISTORIES}
    arrays = {name: values[np.newaxis] for name, values in arrays.items()}
    dampers, touches = dampers_of(request), orbit.impacts
    rows = np.empty((len(touches), len(IMPACT_COLUMNS)))
    for column, name in enumerate(("touch", "release", "speed", "force", "depth")):
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


def _last_times(edges: np.ndarray, E1: np.ndarray, most: float) -> dict[str, np.ndarray]:
    """Return the last times at which E1 exceeds `SHARES` of its largest value, by name.

    Between two edges E1 is taken for a straight line; NaN if it exceeds the share at the end.
    """
    times = {}
    for share in SHARES:
        above, last = np.flatnonzero(share * most < E1), 0.0
        if above.size and (i := above[-1]) < len(E1) - 1:
            part = (E1[i] - share * most) / (E1[i] - E1[i + 1])
            last = edges[i] + (edges[i + 1] - edges[i]) * part
        elif above.size:
            last = np.nan
        times[f"last_{100 * share:g}"] = np.array(last)
    return times


def _largest_force(impacts: np.ndarray, damper: str) -> float:
    return float(impacts["force"][impacts["damper"] == damper].max(initial=0.0))
