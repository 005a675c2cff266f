"""The datasets of response histories: quantities, histories, and the impacts of hosts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.loads.request import HistoryRequest, axis_words
from nlds_vines.model.axis import SAMPLE, sample_scale
from nlds_vines.model.quantities import OF_HOSTS, OF_LOADS, WAYS, Quantity
from nlds_vines.orbits.records import STATUS_FLAGS
from nlds_vines.runs.store import Arrays

# the dimensions of each history before the time, its unit and its meaning
HISTORIES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "E1": ((), "J", "energy of the structure, its velocity relative to the ground"),
    "E2": ((), "J", "energy of the damper, its velocity relative to the ground"),
    "x1": ((), "m", "displacement of the structure, relative to the ground"),
    "x2": ((), "m", "displacement of the damper, relative to the ground"),
    "work": ((), "J", "energy that came in so far, by the start and by the load"),
    **{
        f"dissipated_{k}": ((), "J", f"energy dissipated by {words} so far")
        for k, words in WAYS.items()
    },
}
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
    "impulse": ("N s", "largest impulse of a rigid wall, 0 of other walls"),
    "damper": ("1", "number of the damper, from 0"),
    "wall": ("1", "side of its wall, 1 or -1"),
}


def quantities_of(request: HistoryRequest) -> tuple[Quantity, ...]:
    return OF_HOSTS if request.has_hosts else OF_LOADS


def owners_of(request: HistoryRequest) -> dict[str, tuple[str, ...]]:
    """Return the displacements, by default where dampers hang, and the dampers of hosts."""
    if not request.has_hosts:
        return {}
    dampers = [damper for system in request.systems for damper in system.dampers]
    rows = request.of or [one.places[0] for one in dampers] or request.systems[0].host.dofs
    names = {"displacement": rows, "damper": [one.name for one in dampers]}
    return {dim: tuple(dict.fromkeys(each)) for dim, each in names.items()}


def names_of_numbers(request: HistoryRequest) -> dict[str, tuple[str, int | None]]:
    """Return the datasets and the places in them of all quantities, roof.x_max ..., by name."""
    names: dict[str, tuple[str, int | None]] = {}
    owners = owners_of(request)
    for entry in quantities_of(request):
        if not entry.dims:
            names[entry.name] = entry.name, None
        for place, owner in enumerate(owners[entry.dims[0]] if entry.dims else ()):
            names[f"{owner}.{entry.name}"] = entry.name, place
    return names


def contents(
    request: HistoryRequest, arrays: Arrays
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive, and its datasets with the values in `arrays`."""
    names = np.array([system.name for system in request.systems], dtype=object)
    first = "system" if request.has_hosts else "damper"
    scales = [Scale(first, names, "1", first), Scale("time", request.times, "s", "time")]
    if request.sampled is None:
        scales += [
            Scale(one.name, one.values, *axis_words(request, one.name)) for one in request.vary
        ]
    else:
        scales.append(sample_scale(request.sampled.count))
    for dim, owners in owners_of(request).items():
        scales.append(Scale(dim, np.array(owners, dtype=object), "1", dim))
    dims = (first, *(axis.name for axis in request.vary))
    table = {entry.name: (entry.dims, entry.unit, entry.words) for entry in quantities_of(request)}
    if not request.vary:
        histories = HOST_HISTORIES if request.has_hosts else HISTORIES
        table |= {name: ((*own, "time"), unit, of) for name, (own, unit, of) in histories.items()}
    shape, datasets = (len(request.systems), *request.shape), []
    for name, (own, unit, words) in table.items():
        if not np.isnan(arrays[name]).all():
            values = arrays[name].reshape(*shape, *arrays[name].shape[1:])
            datasets.append((Dataset.real(name, (*dims, *own), unit, words), values))
    if (touches := arrays.get("touches")) is not None and len(touches):
        scales.append(Scale.counted("impact", len(touches), "impact, of all systems", 1))
        columns = {"system": ("1", "number of the system, from 0"), **IMPACT_COLUMNS}
        datasets += [
            (Dataset.real(f"impact_{name}", ("impact",), *column), values)
            for (name, column), values in zip(columns.items(), touches.T, strict=True)
        ]
    status = Dataset.code("status", dims, "how an orbit ended", STATUS_FLAGS)
    datasets.append((status, arrays["status"].reshape(shape)))
    for name, values in request.columns.items() if request.sampled else ():
        datasets.append((Dataset.real(name, (SAMPLE,), *axis_words(request, name)), values))
    return scales, datasets
