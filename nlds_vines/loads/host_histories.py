"""Hosts under loads: the names and the datasets in their archives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError
from nlds_vines.loads.request import HistoryRequest
from nlds_vines.model.host_system import Damper, HostSystem
from nlds_vines.model.parameters import GROUND
from nlds_vines.model.quantities import OF_HOSTS
from nlds_vines.runs.store import Arrays

HOST_HISTORIES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "E1": ((), "J", "energy of the host, its velocity relative to the ground"),
    "E2": (("damper",), "J", "energy of the damper's mass, its velocity relative to the ground"),
    "x": (("displacement",), "m", "displacement, relative to the ground"),
    "a": (("displacement",), "m/s^2", "absolute acceleration"),
    "stroke": (("damper",), "m", "displacement along the spring, positive toward its wall +"),
}
IMPACT_COLUMNS = {
    "touch": ("s", "time of a touch"),
    "release": ("s", "time of the release"),
    "speed": ("m/s", "approach speed"),
    "force": ("N", "largest contact force, infinite at rigid walls"),
    "depth": ("m", "largest depth"),
    "damper": ("1", "number of the damper, from 0"),
    "wall": ("1", "side of its wall, 1 or -1"),
}


def displacements_of(request: HistoryRequest) -> tuple[str, ...]:
    """Return the displacements that a request reports: by default where dampers hang."""
    if request.of:
        return request.of
    ends = [damper.attached_to for system in request.systems for damper in system.dampers]
    names = [end if isinstance(end, str) else end[0] for end in ends]
    return tuple(dict.fromkeys(names or request.systems[0].host.dofs))


def dampers_of(request: HistoryRequest) -> tuple[str, ...]:
    return tuple(dict.fromkeys(one.name for system in request.systems for one in system.dampers))


def stroke_of(damper: Damper) -> str:
    """Return the name of the displacement along a damper's spring."""
    if isinstance(damper.attached_to, str):
        return f"{damper.attached_to}-{damper.name}"
    one, other = damper.attached_to
    return one if other == GROUND else f"{one}-{other}"


def has_displacement(system: HostSystem, name: str) -> bool:
    """Return False for the mass of a damper that another system of the request has."""
    try:
        system.displacement(name)
    except RequestError:
        return False
    return True


def names_of_numbers(request: HistoryRequest) -> dict[str, tuple[str, int | None]]:
    """Return the datasets and the places in them of all quantities: roof.x_max ..., by name."""
    owners = {"displacement": displacements_of(request), "damper": dampers_of(request)}
    names: dict[str, tuple[str, int | None]] = {}
    for entry in OF_HOSTS:
        if not entry.dims:
            names[entry.name] = entry.name, None
        for place, owner in enumerate(owners[entry.dims[0]] if entry.dims else ()):
            names[f"{owner}.{entry.name}"] = entry.name, place
    return names


def contents_of_hosts(
    request: HistoryRequest, arrays: Arrays, dims: tuple[str, ...]
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the further dimensions of an archive of hosts, and its datasets with their values.

    dims: those of a number, systems first.
    """
    shape = (len(request.systems), *request.shape)
    rows, dampers = displacements_of(request), dampers_of(request)
    scales = [Scale("displacement", np.array(rows, dtype=object), "1", "displacement")]
    if dampers:
        scales.append(Scale("damper", np.array(dampers, dtype=object), "1", "damper"))
    table = {q.name: (q.dims, q.unit, q.words) for q in OF_HOSTS}
    if not request.vary:
        table |= {
            name: ((*own, "time"), unit, words)
            for name, (own, unit, words) in HOST_HISTORIES.items()
        }
    datasets = []
    for name, (own, unit, words) in table.items():
        values = arrays[name].reshape(*shape, *arrays[name].shape[1:])
        if values.size:
            datasets.append((Dataset.real(name, (*dims, *own), unit, words), values))
    touches = arrays["touches"]
    if not request.vary and len(touches):
        scales.append(Scale.counted("impact", len(touches), "impact, of all systems", 1))
        columns = {"system": ("1", "number of the system, from 0"), **IMPACT_COLUMNS}
        datasets += [
            (Dataset.real(f"impact_{name}", ("impact",), *column), values)
            for (name, column), values in zip(columns.items(), touches.T, strict=True)
        ]
    return scales, datasets
