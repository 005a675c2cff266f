"""The quantities of a response: names, units, and their values from the buffers of kernels.

Largest values are exact in time, not sampled; rms values and mean powers are integrals over time.
With a moving foot x1 is absolute, and x1 - y, the displacement from the foot, is a quantity too.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.linear_response import alone, foot_amplitude
from nlds_vines.model.parameters import Law
from nlds_vines.model.quantities import Quantity, stored_in
from nlds_vines.model.scenes import Scene, Values
from nlds_vines.model.system import System

# distance from a rigid stop, relative to the stop's, within which a displacement is at it
AT_STOP = 1.0e-12

ENERGIES = tuple(entry.name for entry in stored_in("energy"))  # the largest, objectives too


def objectives_of(scene: Scene) -> dict[str, str]:
    """Return the objectives of a tuning by name, with their units."""
    every = (*stored_in("energy"), *quantities_of(scene))
    return {entry.name: entry.unit for entry in every if entry.has(scene)}


OF_ROWS: Mapping[str, str] = {"x_max": "m", "x_rms": "m", "a_max": "m/s^2"}
"""Quantities of a displacement of a host, with their units: the largest and the rms one, and the
largest absolute acceleration."""


def host_objectives(system: HostSystem, name: str) -> dict[str, str]:
    """Return the objectives of a host's tuning: energies, and quantities of the row in a `name`."""
    row = name.rpartition(".")[0]
    rows = (row,) if row else system.host.dofs
    for one in rows:
        system.displacement(one)
    quantities = {f"{one}.{quantity}": unit for one in rows for quantity, unit in OF_ROWS.items()}
    return {**dict.fromkeys(ENERGIES, "J"), **quantities}


def moving(scene: Scene) -> dict[str, bool | None]:
    """Return whether the foot moves, or the ground that positions are relative to, or None."""
    return {"foot": True if scene.foot else None, "ground": True if scene.relative else None}


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    return tuple(entry for entry in stored_in("response") if entry.has(scene))


def arrays_of(filled: np.ndarray, scene: Scene, cells: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of a response by name, from rows `filled` (..., columns) by kernels.

    A reduction is 1 - q / (q of the structure alone), NaN if the latter is 0.
    """
    arrays: dict[str, np.ndarray] = {}
    reference = alone(cells) if scene.damper else {}
    for entry in quantities_of(scene):
        if entry.dims:
            first = entry.column or 0
            values = filled[..., first : first + 2]
            values = values if len(scene.walls) > 1 else values.max(axis=-1)
        else:
            values = entry.from_buffer(filled)
        if entry.name == "transmissibility":
            with np.errstate(all="ignore"):  # NaN for a foot at rest
                values = values / (np.sqrt(0.5) * foot_amplitude(cells))
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


def values_of(filled: np.ndarray, system: System) -> Mapping[str, Any]:
    """Return the response of one orbit by name: numbers, or arrays (2,) for two walls."""
    arrays = arrays_of(filled[np.newaxis], system.scene, np.atleast_1d(system.cells()))
    return MappingProxyType(
        {name: float(a[0]) if a.ndim == 1 else a[0] for name, a in arrays.items()}
    )


# ---- along an orbit, from states (count, components) ----


def relative_displacement(system: System, states: np.ndarray) -> np.ndarray:
    return states[:, 2] - states[:, 0]


def contact_forces(system: System, states: np.ndarray) -> dict[str, np.ndarray]:
    """Return the contact force on the damper [N] at each wall, by the name of the struck body.

    It is that of the law if the approach z > 0, F = K z^1.5 for Hertz (equations (2) and (3)),
    otherwise 0; positive toward +x2, as at the wall of an SSul.  The structure feels the opposite.
    """
    scene, p = system.scene, system.parameters
    if not scene.forces:
        return {}
    shortening, rate = states[:, 0], states[:, 1]
    if system.rest is not None:
        shortening = system.rest - relative_displacement(system, states)
        rate = states[:, 1] - states[:, 3]
    by_wall = {}
    for wall, gap, sign in (("near", scene.gap_near, 1.0), ("far", scene.gap_far, -1.0)):
        law = scene.law_at(wall)
        if gap is not None and not law.instant:
            place = sign, gap(p)
            by_wall[scene.struck[wall]] = wall_force(
                law, system.contact(wall), place, shortening, rate
            )
    return by_wall


def wall_force(
    law: Law, constants: Values, wall: tuple[float, float], r: np.ndarray, rate: np.ndarray
) -> np.ndarray:
    """Return the force [N] of a wall on a damper, positive toward +x2.

    wall: 1 if it is touched at r = gap, -1 if at -r = gap, and the gap [m]; r and its rate: the
    shortening of the spring [m, m/s].  Under a law whose impacts take no time the force is 0.
    """
    sign, gap = wall
    depth = np.maximum(sign * r - gap, 0.0)
    if law.force is None:
        return np.zeros(len(r))
    return sign * np.where(depth > 0.0, law.force(constants, depth, sign * rate), 0.0)


def harmonic_force(system: System, time: np.ndarray) -> np.ndarray:
    """Return the force P cos(omega t) on the structure [N] at times t [s]."""
    return system.force * np.cos(system.parameters["omega"] * time)
