"""Special points a second time, by shooting with SciPy.

The equation of motion is that of `benchmarks.boundary_values`, written anew from the paper in plain
NumPy; orbit and monodromy matrix are integrated by DOP853 piece by piece, from touch to release to
touch, so that every piece is smooth. At two places beside a point the orbit is closed by Newton's
method, and its test function is computed; a straight line through both tells where it vanishes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.boundary_values import Motion, crossing

BESIDE = 1.0e-7
"""How far beside a point orbits are closed, relative to the number that is held there."""

CLOSED, MOST = 1.0e-10, 8
"""Step of Newton's method, relative, that is the last; and most of them."""

STEPS = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
"""The settings of SciPy's integrator."""


class Orbit(NamedTuple):
    """A special point: its kind, n, and omega [rad/s] with the state x1, v1, x2, v2 at phase 0."""

    kind: str
    n: int
    omega: float
    state: np.ndarray


def shot(motion: Motion, state: np.ndarray, omega: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return state (4,) and monodromy matrix (4, 4) after n periods."""
    s, y = 0.0, np.concatenate((state, np.eye(4).ravel()))
    closed = bool(motion.depth(state) > 0.0)
    while s < n:
        event = crossing(motion, -1.0 if closed else 1.0, ends=True)

        def rate(s: float, y: np.ndarray, closed: bool = closed) -> np.ndarray:
            columns = y[4:].reshape(4, 4)
            here = y[:4, np.newaxis]
            vectors = motion.vector_rate(here, columns, omega, closed).ravel()
            return np.concatenate((motion.rate(np.asarray(s), y[:4], omega, closed), vectors))

        run = solve_ivp(rate, (s, float(n)), y, events=event, **STEPS)
        s, y = float(run.t[-1]), run.y[:, -1]
        closed = closed != bool(run.t_events[0].size)
    return y[:4], y[4:].reshape(4, 4)


def test_of(kind: str, matrix: np.ndarray) -> float:
    """Return the test function of a kind: it vanishes at a point of that kind."""
    if kind in ("LP", "PD"):
        return float(np.linalg.det(matrix + (1.0 if kind == "PD" else -1.0) * np.eye(4)))
    mu = np.linalg.eigvals(matrix)
    pairs = mu[mu.imag > 0.0]
    return float(np.abs(pairs[np.abs(np.abs(pairs) - 1.0).argmin()]) - 1.0)


def closed_at(
    motion: Motion, place: np.ndarray, n: int, fixed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return state and omega (5,) of the nT orbit near a place, one of them held; its matrix."""
    free = [i for i in range(5) if i != fixed]
    for _ in range(MOST):
        end, matrix = shot(motion, place[:4], place[4], n)
        jacobian = np.column_stack((matrix - np.eye(4), np.zeros(4)))
        if fixed != 4:
            step = 1.0e-7 * place[4]
            jacobian[:, 4] = (shot(motion, place[:4], place[4] + step, n)[0] - end) / step
        change = np.linalg.solve(jacobian[:, free], place[:4] - end)
        place = place.copy()
        place[free] += change
        if np.abs(change).max() <= CLOSED * np.abs(place[:4]).max():
            return place, shot(motion, place[:4], place[4], n)[1]
    raise ArithmeticError(f"no orbit {n}T is closed near {place[4]!r} rad/s")


def again(motion: Motion, orbit: Orbit) -> float:
    """Return omega [rad/s] of a special point by shooting.

    At a fold the component of the state that changes most is held in place of omega.
    """
    place, fixed = np.append(orbit.state, orbit.omega), 4
    if orbit.kind == "LP":
        _, _, vectors = np.linalg.svd(
            shot(motion, orbit.state, orbit.omega, orbit.n)[1] - np.eye(4)
        )
        fixed = int(np.abs(vectors[-1] / np.abs(orbit.state)).argmax())
    sides = []
    for side in (-1.0, 1.0):
        beside = place.copy()
        beside[fixed] *= 1.0 + side * BESIDE
        closed, matrix = closed_at(motion, beside, orbit.n, fixed)
        sides.append((test_of(orbit.kind, matrix), closed))
    (low, a), (high, b) = sides
    return float((a - low / (high - low) * (b - a))[4])
