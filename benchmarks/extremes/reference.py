"""An integrator of others to judge by: SciPy's DOP853, split at every touch and release.

It solves equation (5) in its own variables and shares nothing with the kernels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.extremes.cases import rest_state
from nlds_vines.model.system import System

FINEST = 3e-14
"""The smallest relative tolerance that DOP853 takes without a warning is 2.2e-14."""


@dataclass(frozen=True)
class Course:
    """States at t = T, 2T, ..., shape (periods, 4), and the instants of touch [s]."""

    section: np.ndarray
    touches: np.ndarray


class Equations:
    """Equation (5) of one system with walls, as functions of time [s] and state."""

    def __init__(self, system: System) -> None:
        """Take the parameters of `system`."""
        cell, walls = system.cells(), system.scene.walls
        self.p, self.rest, self.K = system.parameters, float(cell["rest"]), float(cell["K"])
        self.near = float(cell["near"]) if "near" in walls else math.inf
        self.far = float(cell["far"]) if "far" in walls else math.inf

    def slope(self, t: float, y: np.ndarray) -> tuple[float, float, float, float]:
        """Return the derivatives of x1, v1, x2, v2."""
        p, (x1, v1, x2, v2) = self.p, y
        r = x1 - x2 + self.rest
        pull = p["k2"] * r + p["c2"] * (v1 - v2)
        pull += self.K * max(r - self.near, 0.0) ** 1.5 - self.K * max(-r - self.far, 0.0) ** 1.5
        alone = p["P"] * math.cos(p["omega"] * t) - p["k1"] * x1 - p["c1"] * v1
        return v1, (alone - pull) / p["m1"], v2, pull / p["m2"]

    def depth(self, t: float, y: np.ndarray) -> float:
        """Return the depth [m] in the nearer of the walls; negative where none is touched."""
        r = y[0] - y[2] + self.rest
        return max(r - self.near, -r - self.far)

    def closing(self, t: float, y: np.ndarray) -> bool:
        """Tell whether a state inside a wall, or on it, is a contact."""
        depth, r = self.depth(t, y), y[0] - y[2] + self.rest
        sign = 1.0 if r - self.near >= -r - self.far else -1.0
        _, a1, _, a2 = self.slope(t, y)
        speed, pressed = sign * (y[1] - y[3]), sign * (a1 - a2)
        return depth > 0.0 or (depth == 0.0 and (speed > 0.0 or (speed == 0.0 and pressed > 0.0)))


def follow(
    system: System, periods: int, start: np.ndarray | None = None, rtol: float = FINEST
) -> Course:
    """Follow an orbit from `start` (x1, v1, x2, v2), by default from rest.

    The absolute tolerance is `rtol` times the deflection P / k1, or 1 mm without a force.
    """
    model = Equations(system)

    def depth(t: float, y: np.ndarray) -> float:
        return model.depth(t, y)

    depth.terminal = True  # type: ignore[attr-defined]  # SciPy's way
    y = rest_state(system) if start is None else np.asarray(start, dtype=float)
    length = system.parameters["P"] / system.parameters["k1"] or 1e-3
    inside, section, touches = model.closing(0.0, y), np.empty((periods, 4)), []
    for n in range(periods):
        t, end = n * system.period, (n + 1) * system.period
        while t < end:
            depth.direction = -1.0 if inside else 1.0  # type: ignore[attr-defined]
            piece = solve_ivp(
                model.slope, (t, end), y, "DOP853", rtol=rtol, atol=rtol * length,
                events=depth,
            )  # fmt: skip
            t, y = float(piece.t[-1]), piece.y[:, -1]
            if piece.status == 1:
                inside = not inside
                if inside:
                    touches.append(t)
        section[n] = y
    return Course(section, np.array(touches))
