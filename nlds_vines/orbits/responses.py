"""What a record of the response holds: its quantities by name, with units, and how they are read.

All are of the sampled periods.  Largest values are exact in time, not sampled; rms values and mean
powers are integrals over time.  With a moving foot (`base_displacement`, `base_acceleration`) x1 is
absolute, and x1 - y, the displacement from the foot, is there too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.kernels.codes import OF_FORCES, OF_IMPULSES, POWERS
from nlds_vines.model.linear_response import alone, foot_amplitude
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System

AT_STOP = 1.0e-12
"""How far from a rigid stop a displacement is at it, relative to the stop's distance."""


@dataclass(frozen=True)
class Quantity:
    """One quantity of a response.

    Attributes:
        name: that of its dataset.
        unit: SI.
        meaning: in words.
        column: its place in the kernels' response; of what is stored for each wall, the first.
        walls: whether there is a number for each wall.
        reduced: whether it is compared with that of the structure alone.
    """

    name: str
    unit: str
    meaning: str
    column: int
    walls: bool = False
    reduced: bool = False


ENERGIES = {"E1max": "J", "E2max": "J"}
"""The largest energies, by name, with their unit: objectives beside those of a response."""


def objectives_of(scene: Scene) -> dict[str, str]:
    """Return the numbers that a tuning may make small, by name, with their unit.

    The largest energies, and what a response holds; of two walls the larger force or impulse.
    """
    energies = dict(list(ENERGIES.items())[: 2 if scene.damper else 1])
    return energies | {entry.name: entry.unit for entry in quantities_of(scene)}


def moving_foot(scene: Scene) -> bool | None:
    """Return what kernels ask of a scene: True where the structure's foot moves, otherwise None."""
    return True if scene.foot else None


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    """Return what a response of a scene holds, in the order of its datasets."""
    return (*_motions(scene), *_contacts(scene), *_powers(scene))


def _motions(scene: Scene) -> Iterator[Quantity]:
    """Yield largest and rms values of motions."""
    first, rate = scene.components[:2]
    yield from _pair("x1", "m", f"displacement {first} of the {scene.body}", 0, True)
    yield from _pair("v1", "m/s", f"velocity {rate} of the {scene.body}", 2, True)
    if not any(law.instant for law in scene.laws) or not scene.walls:
        text = f"acceleration of the {scene.body}, contacts included"
        yield from _pair("a1", "m/s^2", text, 4, True)
    if scene.damper:
        text = "stroke of the damper, x2 - x1 counted from where its spring rests"
        yield from _pair("stroke", "m", text, 6, False)
    if moving_foot(scene):
        text = "displacement of the structure from its foot, x1 - y"
        yield from _pair("foot", "m", text, 8, False)
        text = "transmissibility: rms of x1 by rms of the foot's displacement y"
        yield Quantity("transmissibility", "1", text, 1)


def _pair(name: str, unit: str, text: str, column: int, reduced: bool) -> Iterator[Quantity]:
    """Yield the largest and the rms value of one motion."""
    yield Quantity(f"{name}_max", unit, f"largest {text}", column, reduced=reduced)
    yield Quantity(f"{name}_rms", unit, f"rms of the {text}", column + 1, reduced=reduced)


def _contacts(scene: Scene) -> Iterator[Quantity]:
    """Yield the largest force of contacts that take time, and the largest impulse of others."""
    instant = [law.instant for law in scene.laws] if scene.walls else []
    if not all(instant):
        yield Quantity("force_max", "N", "largest contact force", OF_FORCES, walls=True)
    if any(instant):
        text = "largest impulse of an impact"
        yield Quantity("impulse_max", "N s", text, OF_IMPULSES, walls=True)


def _powers(scene: Scene) -> Iterator[Quantity]:
    """Yield mean powers: in = c1 + c2 + contacts, but for what the stored energy has changed."""
    names = ("c1", "c2") if scene.damper else ("c1",)
    for i, name in enumerate(names):
        text = f"mean power dissipated by the dashpot {name}"
        yield Quantity(f"power_{name}", "W", text, POWERS + i)
    if scene.walls:
        yield Quantity("power_contact", "W", "mean power dissipated by contacts", POWERS + 2)
    by = "the motion of the foot" if moving_foot(scene) else "the force"
    yield Quantity("power_in", "W", f"mean power put in by {by}", POWERS + 3)


def arrays_of(found: np.ndarray, scene: Scene, cells: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of a response by name, those of reductions among them.

    Arguments: `found` (..., columns), as kernels fill it; the `cells` (...) of the orbits.

    A reduction is 1 - q / q of the structure alone, NaN where nothing moves it.
    """
    arrays: dict[str, np.ndarray] = {}
    reference = alone(cells) if scene.damper else {}
    for entry in quantities_of(scene):
        last = entry.column + (2 if entry.walls else 1)
        values = found[..., entry.column : last]
        if not (entry.walls and len(scene.walls) > 1):
            values = values.max(axis=-1)
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


def values_of(found: np.ndarray, system: System) -> Mapping[str, Any]:
    """Return the response of one orbit by name: numbers, of two walls arrays (2,).

    Arguments: `found` (columns,), as kernels fill it; its `system`.
    """
    arrays = arrays_of(found[np.newaxis], system.scene, np.atleast_1d(system.cells()))
    return MappingProxyType(
        {name: float(a[0]) if a.ndim == 1 else a[0] for name, a in arrays.items()}
    )
