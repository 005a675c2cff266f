"""Displacements, forces and energies along an orbit, as functions of its states.

States are rows (count, components) [m, m/s] of the components of `System.scene`, as in
`Orbit.trajectory`.  A system makes its signals and motions; here is what they consist of.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from nlds_vines.model.parameters import Law
from nlds_vines.model.scenes import Values


class Signal(NamedTuple):
    """A quantity along an orbit."""

    unit: str
    meaning: str
    symbol: str  # in LaTeX without dollar signs
    of: Callable[[np.ndarray], np.ndarray]  # its values (count,) in states
    owner: str = ""  # the degree of freedom or the damper that it is of, if the symbol is not


class SignalWords(NamedTuple):
    """Unit, meaning and symbol of a signal by the paper's symbols."""

    unit: str
    meaning: str
    symbol: str


SIGNALS: Mapping[str, SignalWords] = {
    "x": SignalWords("m", "displacement of the oscillator", "x"),
    "v": SignalWords("m/s", "velocity of the oscillator", "v"),
    "x1": SignalWords("m", "displacement of the structure", "x_1"),
    "v1": SignalWords("m/s", "velocity of the structure", "v_1"),
    "x2": SignalWords("m", "displacement of the damper", "x_2"),
    "v2": SignalWords("m/s", "velocity of the damper", "v_2"),
    "u": SignalWords("m", "relative displacement x2 - x1", "x_2-x_1"),
    "force": SignalWords("N", "contact force on the damper", "F"),
    "E1": SignalWords("J", "energy of the structure", "E_1"),
    "E2": SignalWords("J", "energy of the damper", "E_2"),
}
"""The signals of a structure with one damper, by name."""


def is_velocity(name: str) -> bool:
    """Return True if a recorded signal, by its name, is a velocity: v1, roof.v."""
    return name in ("v", "v1", "v2") or name.endswith(".v")


class Motion(NamedTuple):
    """A displacement w X along an orbit and its rate: the coordinates of a phase plane.

    Attributes:
        body: what moves: "structure", "damper", a degree of freedom, or a damper by its name.
        symbols: of displacement and rate, in LaTeX without dollar signs.
        row: w, of the displacements X of a state.
        owner: the body, if the symbols do not say it.
        walls: the places [m] of walls, and of a limit, by name.
        carrier: the row of the displacement that the walls move with; None if they stand still.
        component: the place in a state of a displacement that can be changed alone; None without.
        has_plane: whether there is a phase plane of it.
        shows_touches: whether its history marks the touches at its walls.
    """

    body: str
    symbols: tuple[str, str]
    row: np.ndarray
    owner: str = ""
    walls: Mapping[str, float] = MappingProxyType({})
    carrier: np.ndarray | None = None
    component: int | None = None
    has_plane: bool = True
    shows_touches: bool = False

    def of(self, states: np.ndarray, part: int = 0) -> np.ndarray:
        """Return the displacement along states (..., components), or with `part` 1 its rate."""
        return displaced(self.row, states, part)


class Motions(NamedTuple):
    """The motions that pictures show of a system.

    Attributes:
        bodies: displacements of the structure and of the damper, or those that were asked for.
        structure: those of the structure alone.
        dampers: the motion of each damper in its phase plane.
        strokes: the displacement along the spring of each damper, beside its walls.
    """

    bodies: tuple[Motion, ...]
    structure: tuple[Motion, ...]
    dampers: tuple[Motion, ...]
    strokes: tuple[Motion, ...]


def displaced(row: np.ndarray, states: np.ndarray, part: int) -> np.ndarray:
    """Return a displacement w X of states, by its `row` w, or with `part` 1 its rate."""
    total = np.zeros(states.shape[:-1])
    for i in np.flatnonzero(row):  # in one order, so that bits are the same on every processor
        total += row[i] * states[..., 2 * i + part]
    return total


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
