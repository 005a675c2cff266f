"""Special points of a branch, found a second time: as boundary value problems, by SciPy.

    python -m benchmarks.boundary_values    print the table

`nlds_vines.continuation` finds folds, period doublings and torus points by a section map, exact
flight and its own matrix of derivatives.  Here the equation of motion is written anew, from
equations (3) and (5) of the paper alone, in plain NumPy, with the contact as a term of the force,
and `scipy.integrate.solve_bvp` solves for orbit, vector and parameter at one time:

    y' = T f(y, s)        y(s0 + 1) = y(s0)
    v' = T Df(y) v        v(s0 + 1) = e^(i theta) v(s0)        |v(s0)| = 1

over s = t / T.  A fold (LP) has theta = 0, a period doubling (PD) theta = pi; with both v is real.
At a torus point (NS) v = a + i b, theta is unknown too, and a phase of v is fixed.

Across a touch Df(y) has the root of the depth, which no mesh over a whole period resolves to 1e-9:
the nodes that SciPy adds there are so close that round-off is all that is left.  The period
therefore begins at a touch s0, and consists of a contact and a flight of unknown lengths, solved
side by side over sigma from 0 to 1.  A piece's time runs as sigma^2 (3 - 2 sigma): what grows as
the root of time after a touch, or before a release, is smooth in sigma.

The contact is soft, and lasts for a good part of the period.  The first guess is off on purpose:
parameter and state of the orbit are changed, and its vector is computed anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_bvp, solve_ivp

from nlds_vines.cli.terminal import table
from nlds_vines.continuation.command import continue_branch
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import Preset

SOFT = load_system("ssul-set6", K=2.0e4, c2=5.0)
"""A soft contact [N/m^1.5] and little damping [N s/m]: all three kinds lie on one branch of T."""

BETWEEN = (4.0, 9.0)  # rad/s
OFF_VALUE, OFF_STATE, OFF_ANGLE = 1.0e-3, 1.0e-2, 1.0e-2  # of the first guess, relative
BESIDE = 1.0e-7  # how far beside a doubling orbits are shot, relative to omega
TOLERANCE = 1.0e-9  # of the residual, relative to 1 + |y'|, root mean square in each interval
MOST_NODES, NODES = 200_000, 201
SIDE = 1.0e-7  # m: how far a contact may be on the wrong side of its touch by round-off
STEPS: dict[str, Any] = {"method": "DOP853", "rtol": 1e-8, "atol": 1e-10, "max_step": 0.01}
KINDS = ("LP", "PD", "NS")


class Point(NamedTuple):
    """A special point: its kind, parameter [rad/s] and state x1, v1, x2, v2 at phase zero."""

    kind: str
    omega: float
    state: np.ndarray


@dataclass(frozen=True)
class Motion:
    """The equation of motion of the SSul NES, equation (5), SI units; closed where in contact."""

    m1: float
    k1: float
    c1: float
    m2: float
    k2: float
    c2: float
    C: float
    V: float
    P: float
    K: float

    @classmethod
    def of(cls, system: Preset) -> Motion:
        numbers = {**system.parameters, "K": system.K}
        return cls(**{field.name: float(numbers[field.name]) for field in fields(cls)})

    def depth(self, y: np.ndarray) -> np.ndarray:
        """Return z = V - (x2 - x1) of states y (4, ...), equation (3) [m]."""
        return self.V - (y[2] - y[0])

    def rate(self, s: np.ndarray, y: np.ndarray, omega: float, closed: bool) -> np.ndarray:
        """Return dy/ds (4, ...) at states y (4, ...), s = t / T."""
        x1, v1, x2, v2 = y
        damper = -self.k2 * (x2 - x1 - self.V - self.C) - self.c2 * (v2 - v1)
        if closed:
            damper = damper + self.K * np.maximum(self.depth(y), 0.0) ** 1.5
        forcing = self.P * np.cos(2.0 * np.pi * s)
        first = (forcing - self.k1 * x1 - self.c1 * v1 - damper) / self.m1
        return 2.0 * np.pi / omega * np.array([v1, first, v2, damper / self.m2])

    def vector_rate(self, y: np.ndarray, v: np.ndarray, omega: float, closed: bool) -> np.ndarray:
        """Return dv/ds (4, ...) of vectors v (4, ...) along the states y (4, ...)."""
        stiffness: float | np.ndarray = self.k2
        if closed:
            stiffness = self.k2 + 1.5 * self.K * np.sqrt(np.maximum(self.depth(y), 0.0))
        damper = -stiffness * (v[2] - v[0]) - self.c2 * (v[3] - v[1])
        first = (-self.k1 * v[0] - self.c1 * v[1] - damper) / self.m1
        return 2.0 * np.pi / omega * np.array([v[1], first, v[3], damper / self.m2])


# ---- the first guess ----


class Guess(NamedTuple):
    """What `solve_bvp` starts from: states with vectors of contact and flight, each (8 or 12,
    nodes), and the unknown parameters omega, touch, length of the contact, for NS theta."""

    contact: np.ndarray
    flight: np.ndarray
    parameters: np.ndarray


def stretched(sigma: np.ndarray) -> np.ndarray:
    """Return the share of a piece's time that has passed at sigma."""
    return sigma * sigma * (3.0 - 2.0 * sigma)


def guess(motion: Motion, point: Point, sigma: np.ndarray) -> Guess:
    """Return a first guess at nodes sigma: the motion from a state that is off, at a parameter
    that is off, from its first touch on, for a period, with a vector of its own matrix."""
    omega = point.omega * (1.0 + OFF_VALUE)
    touch, state = first_touch(motion, point.state * (1.0 + OFF_STATE), omega)

    def with_matrix(s: float, y: np.ndarray) -> np.ndarray:
        columns = y[4:].reshape(4, 4)
        vectors = [motion.vector_rate(y[:4], v, omega, True) for v in columns]
        return np.concatenate((motion.rate(np.asarray(s), y[:4], omega, True), *vectors))

    run = solve_ivp(
        with_matrix, (touch, touch + 1.0), np.concatenate((state, np.eye(4).ravel())),
        events=crossing(motion, -1.0, ends=False), dense_output=True, **STEPS,
    )  # fmt: skip
    length = float(run.t_events[0][0]) - touch
    vector, growth, theta = vector_of(run.y[4:, -1].reshape(4, 4).T, point.kind)

    def along(s: np.ndarray) -> np.ndarray:
        solution = run.sol(s)
        v = np.einsum("jin,j->in", solution[4:].reshape(4, 4, -1), vector) * growth ** (touch - s)
        return np.vstack(
            (solution[:4], v.real, v.imag) if point.kind == "NS" else (solution[:4], v)
        )

    share = stretched(sigma)
    unknown = [omega, touch, length, theta * (1.0 + OFF_ANGLE)]
    return Guess(
        along(touch + length * share),
        along(touch + length + (1.0 - length) * share),
        np.array(unknown if point.kind == "NS" else unknown[:3]),
    )


def crossing(motion: Motion, direction: float, ends: bool) -> Callable[[float, np.ndarray], float]:
    """Return the depth as an event of `solve_ivp`, which ends a piece or does not.

    A touch has the direction 1, a release -1.
    """

    def depth(s: float, y: np.ndarray) -> float:
        return float(motion.depth(y[:4]))

    depth.direction = direction  # type: ignore[attr-defined]
    depth.terminal = ends  # type: ignore[attr-defined]
    return depth


def first_touch(motion: Motion, state: np.ndarray, omega: float) -> tuple[float, np.ndarray]:
    """Return s and state of the first touch of a motion that begins with `state` at s = 0."""
    run = solve_ivp(
        lambda s, y: motion.rate(np.asarray(s), y, omega, True), (0.0, 2.0), state,
        events=crossing(motion, 1.0, ends=True), **STEPS,
    )  # fmt: skip
    return float(run.t[-1]), run.y[:, -1]


def vector_of(matrix: np.ndarray, kind: str) -> tuple[np.ndarray, float, float]:
    """Return the eigenvector (4,) that a kind asks for, the modulus and angle of its multiplier.

    It is that whose multiplier is nearest to 1 (LP), to -1 (PD), to the unit circle (NS).
    """
    mu, vectors = np.linalg.eig(matrix)
    if kind == "NS":
        i = int(np.argmin(np.where(mu.imag > 0.0, np.abs(np.abs(mu) - 1.0), np.inf)))
        return vectors[:, i], float(np.abs(mu[i])), float(np.angle(mu[i]))
    i = int(np.argmin(np.abs(mu - (1.0 if kind == "LP" else -1.0))))
    vector = vectors[:, i].real
    return vector / np.linalg.norm(vector), 1.0, 0.0


# ---- the boundary value problem ----


@dataclass(frozen=True)
class Problem:
    """Equations and conditions of one kind, contact and flight side by side."""

    motion: Motion
    kind: str
    reference: np.ndarray  # (4,), orthogonal to a complex vector's imaginary part at the touch

    def rate(self, sigma: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the derivatives by sigma of contact and flight, (16 or 24, nodes)."""
        contact, flight = np.split(y, 2)
        share, speed = stretched(sigma), 6.0 * sigma * (1.0 - sigma)
        touch, length = p[1], p[2]
        one = self._piece(touch + length * share, contact, p[0], True)
        two = self._piece(touch + length + (1.0 - length) * share, flight, p[0], False)
        return speed * np.concatenate((length * one, (1.0 - length) * two))

    def _piece(self, s: np.ndarray, y: np.ndarray, omega: float, closed: bool) -> np.ndarray:
        vectors = [
            self.motion.vector_rate(y[:4], y[i : i + 4], omega, closed) for i in range(4, len(y), 4)
        ]
        return np.concatenate((self.motion.rate(s, y[:4], omega, closed), *vectors))

    def conditions(self, a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the residuals of both pieces' ends (16 or 24,) at sigma = 0 and 1: as many
        numbers as there are states and parameters."""
        (touch, behind), (release, end) = np.split(a, 2), np.split(b, 2)
        walls = self.motion.depth(np.array([touch, release]).T)
        length = touch[4:] @ touch[4:] - 1.0
        rows = [behind - release, end[:4] - touch[:4], walls, [length]]
        if self.kind != "NS":
            sign = {"LP": 1.0, "PD": -1.0}[self.kind]
            return np.concatenate((*rows, end[4:] - sign * touch[4:]))
        before, after = touch[4:8] + 1j * touch[8:], end[4:8] + 1j * end[8:]
        off = after - np.exp(1j * p[3]) * before
        return np.concatenate((*rows, off.real, off.imag, [self.reference @ touch[8:]]))


class Solved(NamedTuple):
    """A solution of `solve_bvp`."""

    omega: float  # [rad/s]
    first: float  # omega of the first guess
    theta: float  # angle of the multiplier
    residual: float  # the largest
    nodes: int
    seconds: float  # of CPU time


def solve(motion: Motion, point: Point, tolerance: float = TOLERANCE) -> Solved:
    """Solve the boundary value problem of a special point, from a guess beside it."""
    began = process_time()
    sigma = np.linspace(0.0, 1.0, NODES)
    start = guess(motion, point, sigma)
    problem = Problem(motion, point.kind, start.contact[4:8, 0])
    solution = solve_bvp(
        problem.rate, problem.conditions, sigma, np.vstack((start.contact, start.flight)),
        start.parameters, tol=tolerance, bc_tol=tolerance, max_nodes=MOST_NODES,
    )  # fmt: skip
    if not solution.success:
        raise ArithmeticError(f"{point.kind} near {point.omega:.6f}: {solution.message}")
    check_sides(motion, solution.y)
    theta = {"LP": 0.0, "PD": np.pi}.get(point.kind, float(solution.p[-1]))
    return Solved(
        float(solution.p[0]),
        float(start.parameters[0]),
        theta,
        float(np.max(solution.rms_residuals)),
        len(solution.x),
        process_time() - began,
    )


def check_sides(motion: Motion, y: np.ndarray) -> None:
    """Raise an error unless the depth is positive in contact, and negative in flight."""
    contact, flight = np.split(y, 2)
    if np.min(motion.depth(contact)) < -SIDE or np.max(motion.depth(flight)) > SIDE:
        raise ArithmeticError("the orbit has another number of contacts")


# ---- period doublings a third time, by shooting ----


def shot(motion: Motion, state: np.ndarray, omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Return state (4,) and monodromy matrix (4, 4) after a period, by SciPy's DOP853.

    The period is integrated from touch to release to touch, so that every piece is smooth.
    """
    s, y = 0.0, np.concatenate((state, np.eye(4).ravel()))
    closed = bool(motion.depth(state) > 0.0)
    while s < 1.0:
        event = crossing(motion, -1.0 if closed else 1.0, ends=True)

        def rate(s: float, y: np.ndarray, closed: bool = closed) -> np.ndarray:
            columns, here = y[4:].reshape(4, 4), y[:4, np.newaxis]
            vectors = motion.vector_rate(here, columns, omega, closed).ravel()
            return np.concatenate((motion.rate(np.asarray(s), y[:4], omega, closed), vectors))

        run = solve_ivp(rate, (s, 1.0), y, "DOP853", events=event, rtol=1e-12, atol=1e-14)
        s, y = float(run.t[-1]), run.y[:, -1]
        closed = closed != bool(run.t_events[0].size)
    return y[:4], y[4:].reshape(4, 4)


def doubling_by_shooting(motion: Motion, omega: float, state: np.ndarray) -> float:
    """Return omega [rad/s] of a period doubling near a given one.

    On both sides of it Newton's method closes the orbit.  A straight line through det(M + 1)
    there tells where it vanishes.
    """
    places = omega * (1.0 + np.array([-BESIDE, BESIDE]))
    tests = []
    for place in places:
        for _ in range(8):
            end, matrix = shot(motion, state, place)
            change = np.linalg.solve(matrix - np.eye(4), state - end)
            state = state + change
            if np.abs(change).max() <= 1e-10 * np.abs(state).max():
                break
        else:
            raise ArithmeticError(f"no orbit is closed near {place!r} rad/s")
        tests.append(np.linalg.det(shot(motion, state, place)[1] + np.eye(4)))
    return float(places[0] - tests[0] / np.diff(tests)[0] * np.diff(places)[0])


# ---- the table ----


def own_points() -> tuple[list[Point], float]:
    """Return the special points that the continuation finds, and its CPU time once compiled."""
    for _ in range(2):
        began = process_time()
        path = continue_branch(SOFT, "omega", BETWEEN)
        seconds = process_time() - began
    points = [Point(s.kind, s.value, s.state) for s in path.special_points if s.kind in KINDS]
    return points, seconds


def page() -> Iterator[str]:
    motion, (points, seconds) = Motion.of(SOFT), own_points()
    rows = []
    for point in points:
        solved = solve(motion, point)
        rows.append((
            point.kind, f"{point.omega:.12f}", f"{solved.omega:.12f}",
            f"{solved.omega - point.omega:+.1e}", f"{solved.first - point.omega:+.1e}",
            f"{solved.theta:.6f}", f"{solved.residual:.1e}", f"{solved.nodes}",
            f"{solved.seconds:.2f} s",
        ))  # fmt: skip
    heads = (
        "kind", "omega here", "by solve_bvp", "difference", "first guess, difference", "theta",
        "rms residual", "nodes", "CPU time",
    )  # fmt: skip
    yield from table(heads, rows, right=range(1, len(heads)))
    yield ""
    yield f"The whole branch with all its points took {seconds:.2f} s of CPU time here, compiled."


if __name__ == "__main__":
    print("\n".join(page()))
