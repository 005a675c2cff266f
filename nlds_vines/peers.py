"""What a user would try instead, for comparison: plain Runge-Kutta, and SciPy with events.

Both integrate eq. (5) in its own variables x1, v1, x2, v2 and share nothing with the kernels.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from nlds_vines._jit import jit
from nlds_vines.system import System


def constants(system: System) -> np.ndarray:
    """Return m1 k1 c1 m2 k2 c2 P omega K near far rest as an array, absent walls at infinity."""
    cell = np.atleast_1d(system.cells())[0]
    values = np.array([float(cell[name]) for name in cell.dtype.names])
    if "near" not in system.scene.walls:
        values[9] = np.inf
    if "far" not in system.scene.walls:
        values[10] = np.inf
    return values


@jit
def derivative(p, phase, x1, v1, x2, v2):
    """Return (dx1, dv1, dx2, dv2) of eq. (5); `p` from `constants`, `phase` = omega t."""
    r, s = x1 - x2 + p[11], v1 - v2
    pull = p[4] * r + p[5] * s
    near, far = r - p[9], -r - p[10]
    if near > 0.0:
        pull += p[8] * near * math.sqrt(near)
    if far > 0.0:
        pull -= p[8] * far * math.sqrt(far)
    return v1, (p[6] * math.cos(phase) - p[1] * x1 - p[2] * v1 - pull) / p[0], v2, pull / p[3]


@jit
def plain_runge_kutta(p, steps, periods, y):
    """Advance y = (x1, v1, x2, v2) in place by fixed steps that know nothing of contact."""
    h = 2.0 * math.pi / p[7] / steps
    turn = p[7] * h
    x1, v1, x2, v2 = y[0], y[1], y[2], y[3]
    for _ in range(periods):
        for j in range(steps):
            a1, b1, c1, d1 = derivative(p, turn * j, x1, v1, x2, v2)
            g = 0.5 * h
            a2, b2, c2, d2 = derivative(
                p, turn * (j + 0.5), x1 + g * a1, v1 + g * b1, x2 + g * c1, v2 + g * d1
            )
            a3, b3, c3, d3 = derivative(
                p, turn * (j + 0.5), x1 + g * a2, v1 + g * b2, x2 + g * c2, v2 + g * d2
            )
            a4, b4, c4, d4 = derivative(
                p, turn * (j + 1.0), x1 + h * a3, v1 + h * b3, x2 + h * c3, v2 + h * d3
            )
            x1 += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            v1 += h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
            x2 += h / 6.0 * (c1 + 2.0 * (c2 + c3) + c4)
            v2 += h / 6.0 * (d1 + 2.0 * (d2 + d3) + d4)
    y[0], y[1], y[2], y[3] = x1, v1, x2, v2


def scipy_with_events(
    system: System, periods: int, rtol: float, method: str = "DOP853"
) -> np.ndarray:
    """Return the state after some periods from rest by `solve_ivp`, split at touch and release.

    The way to use it well: each piece ends at an event on a wall, and the next begins there.
    """
    p = constants(system)

    def slope(t: float, y: np.ndarray) -> tuple[float, ...]:
        return derivative(p, p[7] * t, y[0], y[1], y[2], y[3])

    def depth(t: float, y: np.ndarray) -> float:
        r = y[0] - y[2] + p[11]
        return max(r - p[9], -r - p[10])

    depth.terminal = True  # type: ignore[attr-defined]  # SciPy's way
    event = depth if math.isfinite(min(p[9], p[10])) else None
    t, end, y = 0.0, periods * system.period, np.array([0.0, 0.0, p[11], 0.0])
    inside = depth(t, y) > 0.0
    while t < end:
        depth.direction = -1.0 if inside else 1.0  # type: ignore[attr-defined]
        piece = solve_ivp(slope, (t, end), y, method, rtol=rtol, atol=1e-3 * rtol, events=event)
        t, y, inside = float(piece.t[-1]), piece.y[:, -1], not inside
    return y
