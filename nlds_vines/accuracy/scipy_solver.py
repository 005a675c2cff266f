"""SciPy's `solve_ivp` with DOP853, as everybody would use it first: no event at touch or release.

It solves eq. (5) in its own variables x1, v1, x2, v2 and shares no formula with the kernels: the
solver that ours are compared with, and an independent witness of what is true.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from nlds_vines.accuracy.measured_cases import Course, SolverFailure
from nlds_vines.model.system import System

NAME = "SciPy DOP853"
SETTINGS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
"""Relative tolerances from coarse to fine."""

NUMBERS = ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "K", "near", "far", "rest")
BUDGET = 240_000  # values of eq. (5) in a forcing period, after which it gives up


def follow(
    system: System, periods: int, start: np.ndarray, rtol: float, longest: float = math.inf
) -> Course:
    """Follow an orbit from `start` (x1, v1, x2, v2) at t = 0; (x1, v1) without a damper.

    Steps are at most `longest` [s].  The absolute tolerance is `rtol` times the deflection P / k1,
    or 1 mm without a force.  Raises `SolverFailure` where the solver breaks down.
    """
    cell, walls, left = system.cells(), system.scene.walls, periods * BUDGET
    m1, k1, c1, m2, k2, c2, P, omega, K, near, far, rest = (float(cell[name]) for name in NUMBERS)
    near, far = near if "near" in walls else math.inf, far if "far" in walls else math.inf
    m2 = m2 or 1.0  # without a damper: a mass that nothing is joined to

    def slope(t: float, y: np.ndarray) -> tuple[float, float, float, float]:
        nonlocal left
        left -= 1
        if left < 0:
            raise SolverFailure(f"more than {BUDGET} evaluations a period up to t = {t:.6g} s")
        x1, v1, x2, v2 = y.tolist()
        r = x1 - x2 + rest
        pressed, pulled = max(r - near, 0.0), max(-r - far, 0.0)
        contact = K * (pressed * math.sqrt(pressed) - pulled * math.sqrt(pulled))
        joint = k2 * r + c2 * (v1 - v2) + contact
        return v1, (P * math.cos(omega * t) - k1 * x1 - c1 * v1 - joint) / m1, v2, joint / m2

    y, times = np.zeros(4), system.period * np.arange(1, periods + 1)
    y[: len(start)] = start
    try:
        with np.errstate(all="ignore"):
            found = solve_ivp(
                slope, (0.0, times[-1]), y, "DOP853", times,
                rtol=rtol, atol=rtol * (P / k1 or 1e-3), max_step=longest,
            )  # fmt: skip
    except (ArithmeticError, ValueError) as error:
        raise SolverFailure(f"{type(error).__name__}: {error}") from None
    if found.status < 0:
        raise SolverFailure(found.message)
    return Course(section=found.y.T[:, : len(start)], touches=None)
