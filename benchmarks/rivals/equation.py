"""Eq. (5) in its own variables x1, v1, x2, v2, as one would write it down: what every rival solves.

Shares no formula with the kernels. Walls are told apart by number: 0 near, 1 far.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numba
import numpy as np

from nlds_vines.model.system import System

jit: Any = partial(numba.njit, error_model="numpy", nogil=True, cache=True)
"""Numba's own: rivals compile their loops with it, and cannot link the package's inner kernels."""

CONSTANTS = (
    "m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "K", "near", "far", "rest", "limit",
)  # fmt: skip
ON_WALL = 1e-14  # depth [m] up to which a start counts as lying on a wall


def constants(system: System) -> np.ndarray:
    """Return the `CONSTANTS` as an array.

    Absent walls are at infinity. Without a damper there is a unit mass that nothing is joined to.
    """
    cell = np.atleast_1d(system.cells())[0]
    values = np.array([float(cell[name]) for name in CONSTANTS])
    if not system.scene.damper:
        values[3] = 1.0
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
def slope_into(p, t, y, dy):
    """Write the derivative of eq. (5) at time t and state y into dy, both of shape (4,).

    Raises FloatingPointError where it is not finite: some solvers would try on for ever.
    """
    dy[0], dy[1], dy[2], dy[3] = derivative(p, p[7] * t, y[0], y[1], y[2], y[3])
    if not math.isfinite(dy[0] + dy[1] + dy[2] + dy[3]):
        raise FloatingPointError("the state is no longer finite")


@jit
def slope(t, y, p):
    """Return the derivative of eq. (5) as an array of shape (4,); see `slope_into`."""
    dy = np.empty(4)
    slope_into(p, t, y, dy)
    return dy


@jit
def jacobian_into(p, y, J):
    """Write d(derivative)/dy of eq. (5) at state y into J, shape (4, 4), zero where it is zero."""
    r = y[0] - y[2] + p[11]
    near, far = r - p[9], -r - p[10]
    stiffness = p[4]  # of the joint, d(pull)/dr
    if near > 0.0:
        stiffness += 1.5 * p[8] * math.sqrt(near)
    if far > 0.0:
        stiffness += 1.5 * p[8] * math.sqrt(far)
    J[0, 1] = J[2, 3] = 1.0
    J[1, 0], J[1, 1] = -(p[1] + stiffness) / p[0], -(p[2] + p[5]) / p[0]
    J[1, 2], J[1, 3] = stiffness / p[0], p[5] / p[0]
    J[3, 0], J[3, 1] = stiffness / p[3], p[5] / p[3]
    J[3, 2], J[3, 3] = -stiffness / p[3], -p[5] / p[3]


@jit
def jacobian(t, y, p):
    """Return d(derivative)/dy of eq. (5), shape (4, 4)."""
    J = np.zeros((4, 4))
    jacobian_into(p, y, J)
    return J


@jit
def depth(p, wall, x1, x2):
    """Return how deep a wall is pressed in [m], negative where it is not touched."""
    r = x1 - x2 + p[11]
    return r - p[9] if wall == 0.0 else -r - p[10]


@jit
def closing(y):
    """Return v1 - v2 [m/s], at which the near wall is approached and the far wall left."""
    return y[1] - y[3]


@jit
def turns(p, before, after):
    """Tell whether the approach to a wall turned between two values of `closing`.

    Beyond the wall there, it was touched in between, though neither end need show it.
    """
    if before > 0.0 >= after:
        return p[9] < np.inf
    return before < 0.0 <= after and p[10] < np.inf


@jit
def turning(p, since, t, y):
    """Return what changes sign where `closing` does, but not again at the time `since` of a turn.

    As in `indicator`, it is divided by the time since then; NaN where there was none.
    """
    if math.isnan(since):
        return y[1] - y[3]
    passed = t - since
    if passed > 0.0:
        return (y[1] - y[3]) / passed
    _, near, _, far = derivative(p, p[7] * t, y[0], y[1], y[2], y[3])
    return near - far


@jit
def begin(p, y, watch):
    """Write into `watch` where an orbit begins: (inside a contact?, wall, since when on a wall).

    A start on a wall is inside where it moves into the wall; time is NaN where it is not on one.
    """
    wall = 0.0 if depth(p, 0.0, y[0], y[2]) >= depth(p, 1.0, y[0], y[2]) else 1.0
    z = depth(p, wall, y[0], y[2])
    speed = y[1] - y[3] if wall == 0.0 else y[3] - y[1]
    on_wall = abs(z) <= ON_WALL
    watch[0] = 1.0 if (speed > 0.0 if on_wall else z > 0.0) else 0.0
    watch[1] = wall
    watch[2] = 0.0 if on_wall else np.nan


@jit
def switch(p, t, y, watch):
    """Note in `watch` the touch or release at time t and state y: the other kind of piece begins.

    Returns whether it was a touch.
    """
    touched = watch[0] == 0.0
    if touched:
        deeper = depth(p, 0.0, y[0], y[2]) >= depth(p, 1.0, y[0], y[2])
        watch[1] = 0.0 if deeper else 1.0
    watch[0] = 1.0 if touched else 0.0
    watch[2] = t
    return touched


@jit
def indicator(p, watch, t, y):
    """Return what changes sign at the end of a piece: positive inside a contact, else negative.

    It is the depth of the contact or, in flight, of the wall that is nearest. A piece that began
    on a wall begins with depth 0, up to round-off, and its sign there means nothing; so the depth
    is divided by the time since then, which leaves its speed at the beginning and moves no other
    zero. No event is lost or found twice by a restart.
    """
    wall = watch[1]
    z = depth(p, wall, y[0], y[2])
    if watch[0] == 0.0:
        z = max(z, depth(p, 1.0 - wall, y[0], y[2]))
    if math.isnan(watch[2]):
        return z
    passed = t - watch[2]
    if passed > 0.0:
        return z / passed
    return y[1] - y[3] if wall == 0.0 else y[3] - y[1]
