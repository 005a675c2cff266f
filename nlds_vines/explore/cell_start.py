"""Where the orbit of a cell begins, in the user's coordinates.

Sweeps begin on the attractor of the cell before; it is known where its section was recorded.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from nlds_vines.bifurcation.beginning import begun
from nlds_vines.bifurcation.compute import STEP
from nlds_vines.explore.stored import Stored
from nlds_vines.model.parameters import INITIAL, component_of
from nlds_vines.model.system import System
from nlds_vines.orbits.starts import random_states, start_states


class CellStart(NamedTuple):
    """A start (x1, v1, x2, v2) [m, m/s], None for rest, and what it is, in words."""

    state: tuple[float, ...] | None
    words: str


def start_of(
    found: Stored,
    cell: tuple[int, int],
    start: int,
    system: System,
    moved: Mapping[str, float] | None = None,
) -> CellStart:
    """Return where the orbit number `start` of a cell begins, for a `system` like that cell's.

    Arguments: `moved`, the initial conditions that are other ones than those of the cell, by name.
    """
    scan = found.scan
    if scan.start.policy == "random":
        draws = start_states(scan.start)[start : start + 1]
        state = random_states(system.cells(), draws, system.scene)[0]
        return CellStart(_user(system, state), f"{found.starts[start]} (seed {scan.start.seed})")
    if scan.start.sweeps:
        return _swept(found, cell, start)
    values = {name: v for name, v in found.values_of(cell).items() if name in INITIAL}
    values |= moved or {}
    if not values and not scan.start.state and not scan.start.phase:
        return CellStart(None, "rest")
    initial = {component_of(name): np.array([value]) for name, value in values.items()}
    state = begun(scan, np.atleast_1d(system.cells()), initial)[0]
    words = ", ".join(f"{name} = {value:g}" for name, value in values.items())
    if moved:
        words = "the start of the sliders"
    return CellStart(_user(system, state), words or "the given state")


def _user(system: System, state: np.ndarray) -> tuple[float, ...]:
    """Return x1, v1, x2, v2 of a kernel's x1, v1, r, s."""
    x1, v1, r, s = state.tolist()
    if not system.scene.damper:
        return x1, v1
    return x1, v1, x1 - r + (system.rest or 0.0), v1 - s


def _swept(found: Stored, cell: tuple[int, int], start: int) -> CellStart:
    """Return the start of a sweep: the last recorded state of the cell before."""
    sweep, last = found.starts[start], len(found.scan.axes) - 1
    before = list(cell[: last + 1])
    before[last] -= STEP[sweep]
    if not 0 <= before[last] < found.scan.shape[last]:
        return CellStart(None, f"rest, the beginning of the sweep {sweep}")
    if "section" in found:
        state = found.arrays["section"][(*before, start, -1)]
        if np.isfinite(state).all():
            return CellStart(tuple(state.tolist()), f"the sweep {sweep}: the cell before")
    if "orbit_point" in found:
        state = found.arrays["orbit_point"][(*cell[: last + 1], start)]
        if np.isfinite(state).all():
            return CellStart(tuple(state.tolist()), f"the sweep {sweep}: a point of its orbit")
    return CellStart(None, f"rest: the archive does not hold the states of the sweep {sweep}")
