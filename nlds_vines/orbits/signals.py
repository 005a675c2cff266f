"""Forces, energies and relative displacement from the states of an orbit.

States are rows (x1, v1, x2, v2) [m, m/s], or (x1, v1) without a damper, as in `Orbit.trajectory`;
every result has one value per row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, choice
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System


class Taper(NamedTuple):
    """A window function: its name in SciPy, and how many bins a line reaches to either side."""

    scipy: str
    reach: int


TAPERS: Mapping[str, Taper] = {"rectangular": Taper("boxcar", 0), "hann": Taper("hann", 1)}
"""The window functions.  Rectangular: a line on a bin fills that bin; one between two bins leaks
far.  Hann: a line on a bin fills three bins; one between two bins leaks little."""


class Signal(NamedTuple):
    """A quantity along an orbit: its unit, its meaning, and the function of the states."""

    unit: str
    meaning: str
    of: Callable[[System, np.ndarray], np.ndarray]


def relative_displacement(system: System, states: np.ndarray) -> np.ndarray:
    """Return u = x2 - x1 [m]."""
    return states[:, 2] - states[:, 0]


def contact_forces(system: System, states: np.ndarray) -> dict[str, np.ndarray]:
    """Return the contact force on the damper [N] at each wall, by the name of the struck body.

    It is that of the law if the approach z > 0, F = K z^1.5 for Hertz (equations (2) and (3)),
    otherwise 0.  It is positive toward +x2, as at the wall of an SSul, and negative at a far wall;
    the opposite force acts on the structure.  Empty for a scene without contact forces.
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
        if gap is not None and law.force is not None:
            approach = np.maximum(sign * shortening - gap(p), 0.0)
            force = law.force(system.contact(wall), approach, sign * rate)
            by_wall[scene.struck[wall]] = sign * np.where(approach > 0.0, force, 0.0)
    return by_wall


def harmonic_force(system: System, time: np.ndarray) -> np.ndarray:
    """Return the force P cos(omega t) on the structure [N] at times t [s]."""
    return system.force * np.cos(system.parameters["omega"] * time)


def energy_of_structure(system: System, states: np.ndarray) -> np.ndarray:
    """Return E1 = (m1 v1^2 + k1 x1^2) / 2 [J], equation (6)."""
    m1, k1, _ = system.structure
    return 0.5 * (m1 * states[:, 1] ** 2 + k1 * states[:, 0] ** 2)


def energy_of_damper(system: System, states: np.ndarray) -> np.ndarray:
    """Return E2 = (m2 v2^2 + k2 w^2) / 2 [J], equation (6).

    w is the damper's absolute displacement from its rest position, V + C for SSul, not the stretch
    of its spring.
    """
    p, w = system.parameters, states[:, 2] - system.rest
    return 0.5 * (p["m2"] * states[:, 3] ** 2 + p["k2"] * w**2)


def _component(column: int) -> Callable[[System, np.ndarray], np.ndarray]:
    return lambda system, states: states[:, column]


SIGNALS: Mapping[str, Signal] = {
    "x": Signal("m", "displacement of the oscillator", _component(0)),
    "v": Signal("m/s", "velocity of the oscillator", _component(1)),
    "x1": Signal("m", "displacement of the structure", _component(0)),
    "v1": Signal("m/s", "velocity of the structure", _component(1)),
    "x2": Signal("m", "displacement of the damper", _component(2)),
    "v2": Signal("m/s", "velocity of the damper", _component(3)),
    "u": Signal("m", "relative displacement x2 - x1", relative_displacement),
    "force": Signal(
        "N",
        "contact force on the damper",
        lambda system, y: sum(contact_forces(system, y).values(), np.zeros(len(y))),
    ),
    "E1": Signal("J", "energy of the structure", energy_of_structure),
    "E2": Signal("J", "energy of the damper", energy_of_damper),
}
"""All signals by name."""

_STATES = ("x", "v", "x1", "v1", "x2", "v2")
_OF_DAMPER = ("u", "E2")


def signals_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of the signals of a scene: no x2 without a damper, for example."""
    without = (() if scene.damper else _OF_DAMPER) + tuple(set(_STATES) - {*scene.components})
    if not scene.forces:
        without += ("force",)
    return tuple(name for name in SIGNALS if name not in without)


def checked_signal(name: object, scene: Scene) -> str:
    """Return the name of a signal, validated for a scene."""
    chosen = choice("signal", name, SIGNALS)
    if chosen not in signals_of(scene):
        raise RequestError(
            f"signal {chosen!r} ({SIGNALS[chosen].meaning}) does not exist in kind {scene.kind!r}; "
            f"allowed: {', '.join(signals_of(scene))}"
        )
    return chosen
