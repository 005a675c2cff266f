"""The quantities of a response: names, units, and their values from the buffers of kernels.

Largest values are exact in time, not sampled; rms values and mean powers are integrals over time.
If the ground moves, x1 and v1 are relative to it and a1 is absolute; the absolute displacement
is a quantity of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.model.linear_response import alone, ground_amplitude
from nlds_vines.model.quantities import Quantity, stored_in
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import General, Preset, System

# distance from a rigid stop, relative to the stop's, within which a displacement is at it
AT_STOP = 1.0e-12

ENERGIES = tuple(entry.name for entry in stored_in("energy"))  # the largest, objectives too


def objectives_of(system: System, scene: Scene, name: str) -> dict[str, str]:
    """Return the objectives of a tuning by name, with their units.

    scene: of the system, or with other laws.  Of a host, they are energies and the quantities of
    the displacement in `name`.
    """
    if isinstance(system, General):
        return _objectives_of_host(system, name)
    every = (*stored_in("energy"), *quantities_of(scene))
    return {entry.name: entry.unit for entry in every if entry.has(scene)}


OF_ROWS: Mapping[str, str] = {"x_max": "m", "x_rms": "m", "a_max": "m/s^2"}
"""Quantities of a displacement of a host, with their units: the largest and the rms one, and the
largest absolute acceleration."""


def of_rows(system: General) -> dict[str, str]:
    """Return the quantities of a displacement; on moving ground also those of the absolute one."""
    absolute = {"x_abs_max": "m", "x_abs_rms": "m"} if system.scene.shaken else {}
    return {**OF_ROWS, **absolute}


IMPULSE = "impulse_max"  # of each damper of a host with rigid walls

INFINITE = ("a_max", "force_max")
"""Quantities of hosts that are infinite where a rigid wall acts."""


def _objectives_of_host(system: General, name: str) -> dict[str, str]:
    """Return energies, the largest impulses at rigid walls, and quantities of the row in `name`."""
    impulses = dict.fromkeys(impulses_of(system.scene), "N s")
    row = name.rpartition(".")[0]
    rows = (row,) if row and name not in impulses else system.host.dofs
    for one in rows:
        system.displacement(one)
    units = of_rows(system)
    quantities = {f"{one}.{quantity}": unit for one in rows for quantity, unit in units.items()}
    return {**dict.fromkeys(ENERGIES, "J"), **quantities, **impulses}


def impulses_of(scene: Scene) -> tuple[str, ...]:
    """Return the names `ball.impulse_max` of the dampers with rigid walls."""
    return tuple(f"{name}.{IMPULSE}" for name in scene.with_rigid_walls)


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    return tuple(entry for entry in stored_in("response") if entry.has(scene))


def arrays_of(filled: np.ndarray, scene: Scene, cells: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of a response by name, from rows `filled` (..., columns) by kernels.

    A reduction is 1 - q / (q of the structure alone), NaN if the latter is 0.
    """
    arrays: dict[str, np.ndarray] = {}
    reference = alone(cells, shaken=bool(scene.shaken)) if scene.damper else {}
    for entry in quantities_of(scene):
        if entry.dims:
            first = entry.column or 0
            values = filled[..., first : first + 2]
            values = values if len(scene.walls) > 1 else values.max(axis=-1)
        else:
            values = entry.from_buffer(filled)
        if entry.name == "transmissibility":
            with np.errstate(all="ignore"):  # NaN for a ground at rest
                values = values / (np.sqrt(0.5) * ground_amplitude(cells))
        if entry.name == ("stroke_max" if scene.damper else "x1_max"):
            # a touch is located to round-off, so a displacement that close to a stop is at it
            for wall in scene.walls:
                stop = np.abs(cells[wall])
                if scene.law_at(wall).instant:
                    values = np.where(np.abs(values - stop) <= AT_STOP * stop, stop, values)
        arrays[entry.name] = values
        if scene.damper and entry.reduced:
            with np.errstate(all="ignore"):
                arrays[f"{entry.name}_reduction"] = 1.0 - values / reference[entry.name]
    return arrays


def values_of(filled: np.ndarray, system: Preset) -> Mapping[str, Any]:
    """Return the response of one orbit by name: numbers, or arrays (2,) for two walls."""
    arrays = arrays_of(filled[np.newaxis], system.scene, np.atleast_1d(system.cells()))
    return MappingProxyType(
        {name: float(a[0]) if a.ndim == 1 else a[0] for name, a in arrays.items()}
    )
