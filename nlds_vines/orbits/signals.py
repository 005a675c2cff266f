"""Signals along an orbit: displacements, contact forces and energies as functions of its states.

States are rows (x1, v1, x2, v2) [m, m/s], or (x1, v1) without a damper, as in `Orbit.trajectory`;
those of a host are its `scene.components`.  A signal has one value per row.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, at, choice
from nlds_vines.model.host_system import Damper, HostSystem
from nlds_vines.model.parameters import LAWS, SIDES
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.responses import contact_forces, relative_displacement, wall_force


class Signal(NamedTuple):
    """A quantity along an orbit: its unit, its meaning, and the function of the states."""

    unit: str
    meaning: str
    of: Callable[[Any, np.ndarray], np.ndarray]


def energy_of_structure(system: System, states: np.ndarray) -> np.ndarray:
    """Return E1 = (m1 v1^2 + k1 x1^2) / 2 [J], equation (6)."""
    m1, k1, _ = system.structure
    return 0.5 * (m1 * states[:, 1] ** 2 + k1 * states[:, 0] ** 2)


def energy_of_damper(system: System, states: np.ndarray) -> np.ndarray:
    """Return E2 = (m2 v2^2 + k2 w^2) / 2 [J], equation (6)."""
    # w is the absolute displacement from rest, V + C for SSul, not the stretch of the spring
    p, w = system.parameters, states[:, 2] - system.rest
    return 0.5 * (p["m2"] * states[:, 3] ** 2 + p["k2"] * w**2)


SIGNALS: Mapping[str, Signal] = {
    "x": Signal("m", "displacement of the oscillator", lambda _, y: y[:, 0]),
    "v": Signal("m/s", "velocity of the oscillator", lambda _, y: y[:, 1]),
    "x1": Signal("m", "displacement of the structure", lambda _, y: y[:, 0]),
    "v1": Signal("m/s", "velocity of the structure", lambda _, y: y[:, 1]),
    "x2": Signal("m", "displacement of the damper", lambda _, y: y[:, 2]),
    "v2": Signal("m/s", "velocity of the damper", lambda _, y: y[:, 3]),
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


def signals_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of the signals of a scene: no x2 without a damper, for example."""
    without = {"x", "v", "x1", "v1", "x2", "v2"} - {*scene.components}
    if not scene.damper:
        without |= {"u", "E2"}
    if not scene.forces:
        without.add("force")
    return tuple(name for name in SIGNALS if name not in without)


def signal_of(system: System | HostSystem, name: object) -> Signal:
    """Return a signal by its name; `RequestError` if the system lacks it."""
    if isinstance(system, HostSystem):
        return _of_host(system, name)
    scene, chosen = system.scene, choice("signal", name, SIGNALS)
    if chosen not in signals_of(scene):
        raise RequestError(
            f"signal {chosen!r} ({SIGNALS[chosen].meaning}) does not exist in kind {scene.kind!r}; "
            f"allowed: {', '.join(signals_of(scene))}"
        )
    return SIGNALS[chosen]


def histories_of(
    system: System | HostSystem, displacements: Collection[str] = ()
) -> dict[str, Signal]:
    """Return the signals of an orbit's archive: the components of its states, then all others.

    The `displacements` of a host are among them if its coordinates are modes.
    """
    if not isinstance(system, HostSystem):
        wanted = (*system.scene.components, "force", "E1", "E2")
        return {name: SIGNALS[name] for name in signals_of(system.scene) if name in wanted}
    signals = {}
    for i, name in enumerate(system.scene.components):
        owner, key, unit = (name[2:], "v", "m/s") if i % 2 else (name, "x", "m")
        signals[f"{owner}.{key}"] = Signal(unit, f"{_WORDS[key]} of {owner}", partial(_column, i))
    names = [f"{name}.x" for name in displacements] + ["E1"]
    for damper in system.dampers:
        keys = {"stroke": True, "force": has_force(damper), "E2": damper.m is not None}
        names += [f"{damper.name}.{key}" for key, is_present in keys.items() if is_present]
    return signals | {name: signal_of(system, name) for name in names if name not in signals}


_WORDS = {
    "x": "displacement",
    "v": "velocity",
    "stroke": "displacement along the spring, positive toward its wall +,",
    "force": "contact force",
    "E2": "energy of the mass",
}


def has_force(damper: Damper) -> bool:
    """Return True if a wall of the damper has a law under which impacts take time."""
    return any(not LAWS[wall.law].instant for wall in damper.walls)


def _of_host(system: HostSystem, name: object) -> Signal:
    """Return the signal of a displacement `roof` or `roof.v`, of a damper `cell.force`, or E1."""
    text = str(name)
    if text == "E1":
        return Signal("J", "energy of the host", energy_of_host)
    owner, _, key = text.rpartition(".")
    owner, key = (owner, key) if owner else (text, "x")
    with at(f"signal {text!r}"):
        choice("quantity", key, _WORDS)
        words = f"{_WORDS[key]} of {owner}"
        if key in ("x", "v"):
            row, _ = system.displacement(owner)
            unit, part = ("m/s", 1) if key == "v" else ("m", 0)
            return Signal(unit, words, lambda _, y: displaced(row, y, part))
        dampers = {damper.name: damper for damper in system.dampers}
        damper = dampers[choice("damper", owner, dampers)]
    row = system.displacement(damper.stroke)[0]
    if key == "stroke":
        return Signal("m", words, lambda _, y: displaced(row, y, 0))
    if key == "force":
        return Signal("N", words, lambda _, y: _force_on(damper, row, y))
    return Signal("J", words, lambda system, y: _energy_of_mass(system, damper, y))


def _column(i: int, _: Any, states: np.ndarray) -> np.ndarray:
    return states[:, i]


def displaced(row: np.ndarray, states: np.ndarray, part: int) -> np.ndarray:
    """Return a displacement w X of states, by its `row` w, or with `part` 1 its rate."""
    total = np.zeros(states.shape[:-1])
    for i in np.flatnonzero(row):  # in one order, so that bits are the same on every processor
        total += row[i] * states[..., 2 * i + part]
    return total


def energy_of_host(system: HostSystem, states: np.ndarray) -> np.ndarray:
    """Return (V^T M V + X^T K X) / 2 [J], as `Orbit.E1max`."""
    total = np.zeros(len(states))
    for matrix, part in ((system.host.M, 1), (system.host.K, 0)):
        for i, j in zip(*np.nonzero(matrix), strict=True):
            total += 0.5 * matrix[i, j] * states[:, 2 * i + part] * states[:, 2 * j + part]
    return total


def _energy_of_mass(system: HostSystem, damper: Damper, states: np.ndarray) -> np.ndarray:
    """Return (m v^2 + k x^2) / 2 [J], as `Orbit.E2max`."""
    row, _ = system.displacement(damper.name)
    x, v = displaced(row, states, 0), displaced(row, states, 1)
    return 0.5 * (float(damper.m or 0.0) * v**2 + damper.k * x**2)


def _force_on(damper: Damper, row: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return the force [N] of a damper's walls on its mass, positive in the direction of x."""
    r, s = displaced(row, states, 0), displaced(row, states, 1)
    forces = [
        wall_force(LAWS[wall.law], wall.constants, (SIDES[wall.side], wall.gap), r, s)
        for wall in damper.walls
    ]
    return sum(forces, np.zeros(len(states)))
