"""What several checks need: systems with some numbers changed, closed forms, observed orders."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.linalg import expm

from benchmarks.accuracy.cases import stored_section
from benchmarks.stiffness.rigid import Rigid
from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.errors import RequestError
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import flow_matrix, response
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import IntegrationError, Orbit, simulate
from nlds_vines.orbits.status_words import STATUS

BOTH = ("section", "impacts")
"""What most checks record where there are walls; one compilation serves them all."""

FULL = (*BOTH, "energy", "clearance")
"""The same with what is exact in time."""

LINEAR = ("section", "energy")
"""What is recorded of a scene without walls."""

FINE = {"nodes": 24, "contact_steps": 200.0}
"""Settings of the exact method at which its own errors lie below round-off."""

METHODS = ("exact", "rk4")


def undamped(name: str, **changes: float) -> System:
    """Return a named system without damping and without force, some parameters replaced."""
    return load_system(name, **{"c1": 0.0, "c2": 0.0, "P": 0.0, **changes})


def rest_state(system: System) -> np.ndarray:
    """Return the state (x1, v1, x2, v2) [m, m/s] at rest; (x1, v1) without a damper."""
    return np.zeros(2) if system.rest is None else np.array([0.0, 0.0, system.rest, 0.0])


def touching_state(system: System, speed: float) -> np.ndarray:
    """Return the state of a damper that touches the near wall with an approach speed [m/s].

    The structure stands at its rest position.
    """
    assert system.rest is not None
    return np.array([0.0, 0.0, system.rest - float(system.cells()["near"]), -speed])


def linear_sections(
    system: System, start: np.ndarray, periods: int, pieces: int = 64
) -> np.ndarray:
    """Return the states at t = T, 2T, ... without contact, by the matrix exponential of SciPy.

    Shape (periods, 4), or (periods, 2) without a damper; a period is crossed in `pieces`.
    """
    width, rest = len(start), system.rest or 0.0
    y = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    y[:width] = start
    y[2] -= rest
    piece = expm(flow_matrix(system) * system.period / pieces)
    found = np.empty((periods, width))
    for n in range(periods):
        for _ in range(pieces):
            y = piece @ y
        y[4:] = 1.0, 0.0
        found[n] = y[:width]
    if width == 4:
        found[:, 2] += rest
    return found


def shortening(system: System) -> float:
    """Return the amplitude [m] of the spring's shortening in the steady motion without contact."""
    return float(response(system, np.array([system.parameters["omega"]])).shortening[0])


def amplitudes(system: System) -> np.ndarray:
    """Return the amplitudes of x1, v1, x2, v2 in the steady motion without contact."""
    omega = system.parameters["omega"]
    found = response(system, np.array([omega]))
    sizes = [abs(X[0]) for X in (found.X1, found.X2) if X is not None]
    return np.array([size * rate for size in sizes for rate in (1.0, omega)])


def error_of(found: Any, exact: Any, offset: float = 0.0, like: np.ndarray | None = None) -> float:
    """Return the largest error of states (..., 4), positions and speeds each by their own scale.

    Arguments: states of the structure alone are (..., 2); `offset` is subtracted from x2 before
    its scale is taken: what does not move is no scale; `like`, states of the motion that give the
    scales, by default those of `exact`.  Infinite where it is no number: the largest of several
    errors would pass over NaN.
    """
    moving = np.atleast_2d(exact if like is None else like).copy()
    moving[:, 2:3] -= offset
    scales = [np.abs(moving[:, i::2]).max() for i in (0, 1)]
    wrong = np.abs(np.atleast_2d(found) - np.atleast_2d(exact))
    error = float(np.max([wrong[:, i::2].max() / scale for i, scale in enumerate(scales)]))
    return math.inf if math.isnan(error) else error


def order_of(errors: Iterable[float], steps: Sequence[float]) -> float:
    """Return the order p of errors ~ steps^-p by least squares."""
    return -float(np.polyfit(np.log(steps), np.log(list(errors)), 1)[0])


def status_of(system: System, periods: int, **options: Any) -> str:
    """Return how an orbit ends: the name of its status."""
    try:
        simulate(system, periods, **options)
    except IntegrationError as error:
        return next(status.name for status in STATUS.values() if status.remedy in str(error))
    return "ok"


def energy_of(system: System, states: np.ndarray) -> np.ndarray:
    """Return the mechanical energy [J] of states (..., 4), contact included.

    Both masses, both springs and the Hertz energy (2/5) K z^(5/2) of every wall.
    """
    p, cell = system.parameters, system.cells()
    x1, v1, x2, v2 = np.moveaxis(np.asarray(states), -1, 0)
    r = x1 - x2 + system.rest
    twice = p["m1"] * v1**2 + p["m2"] * v2**2 + p["k1"] * x1**2 + p["k2"] * r**2
    found = twice / 2
    for wall, side in (("near", r), ("far", -r)):
        if wall in system.scene.walls:
            found = found + 0.4 * cell["K"] * np.maximum(side - cell[wall], 0.0) ** 2.5
    return found


def stored_state(system: System, periods: int) -> np.ndarray:
    """Return the state (4,) [m, m/s] that an orbit from rest has after some periods.

    Found beforehand to 25 digits by two methods in quadruple precision, `data/reference`.
    Raises `RequestError` where none is stored.
    """
    found = stored_section(Case.of(system, periods))
    if found is None:
        omega = system.parameters["omega"]
        raise RequestError(f"{system.name} at omega = {omega:g}: no state is stored")
    return np.asarray(found[-1])


def rigid_state(system: System, periods: int) -> np.ndarray:
    """Return the state (4,) [m, m/s] that an orbit from rest has with rigid elastic walls."""
    return Rigid(Case.of(system, periods)).state()


def orbit_of(system: System, periods: int, **options: Any) -> Orbit:
    """Follow an orbit and record section and impacts, or what the scene has of these."""
    record = BOTH if system.scene.walls else LINEAR
    return simulate(system, periods, **{"record": record, **options})
