"""What a record of the response holds: its quantities by name, with units, and how they are read.

All are of the sampled periods.  Largest values are exact in time, not sampled; rms values and mean
powers are integrals over time.  With a moving foot (`base_displacement`, `base_acceleration`) x1 is
absolute, and x1 - y, the displacement from the foot, is there too.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.model.linear_response import alone, foot_amplitude
from nlds_vines.model.quantities import Quantity, stored_in
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System

AT_STOP = 1.0e-12
"""How far from a rigid stop a displacement is at it, relative to the stop's distance."""


ENERGIES = tuple(entry.name for entry in stored_in("energy"))
"""The largest energies: objectives beside those of a response."""


def objectives_of(scene: Scene) -> dict[str, str]:
    """Return the numbers that a tuning may make small, by name, with their unit.

    The largest energies, and what a response holds; of two walls the larger force or impulse.
    """
    every = (*stored_in("energy"), *quantities_of(scene))
    return {entry.name: entry.unit for entry in every if entry.has(scene)}


def moving_foot(scene: Scene) -> bool | None:
    """Return what kernels ask of a scene: True where the structure's foot moves, otherwise None."""
    return True if scene.foot else None


def moving_ground(scene: Scene) -> bool | None:
    """Return True where positions count from a moving ground, otherwise None."""
    return True if scene.relative else None


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    """Return what a response of a scene holds, in the order of its datasets."""
    return tuple(entry for entry in stored_in("response") if entry.has(scene))


def arrays_of(filled: np.ndarray, scene: Scene, cells: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of a response by name, those of reductions among them.

    Arguments: `found` (..., columns), as kernels fill it; the `cells` (...) of the orbits.

    A reduction is 1 - q / q of the structure alone, NaN where nothing moves it.
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
            with np.errstate(all="ignore"):  # of a foot at rest: NaN
                values = values / (np.sqrt(0.5) * foot_amplitude(cells))
        if entry.name == ("stroke_max" if scene.damper else "x1_max"):
            values = _not_beyond(values, scene, cells)
        arrays[entry.name] = values
        if scene.damper and entry.reduced:
            with np.errstate(all="ignore"):
                arrays[f"{entry.name}_reduction"] = 1.0 - values / reference[entry.name]
    return arrays


def _not_beyond(largest: np.ndarray, scene: Scene, cells: np.ndarray) -> np.ndarray:
    """Return largest displacements (...) [m] that no round-off carries beyond a rigid stop.

    A touch is located to round-off, and what is within that of the stop is at it.
    """
    for wall in scene.walls:
        stop = np.abs(cells[wall])
        if scene.law_at(wall).instant:
            largest = np.where(np.abs(largest - stop) <= AT_STOP * stop, stop, largest)
    return largest


def values_of(filled: np.ndarray, system: System) -> Mapping[str, Any]:
    """Return the response of one orbit by name: numbers, of two walls arrays (2,).

    Arguments: `found` (columns,), as kernels fill it; its `system`.
    """
    arrays = arrays_of(filled[np.newaxis], system.scene, np.atleast_1d(system.cells()))
    return MappingProxyType(
        {name: float(a[0]) if a.ndim == 1 else a[0] for name, a in arrays.items()}
    )
