"""Every kind under forces and on moving ground by SciPy's DOP853, in the inertial frame.

Written from the parameters alone. The unknowns are absolute positions, those of a ground that moves
and integrals; what is largest or last is searched for in the dense output, between its steps, too.
"""

import math

import numpy as np
from scipy.optimize import brentq, minimize_scalar

X1, V1, X2, V2, Y, W = range(6)


class Twin:
    """Equations of motion under a force, on a ground of a given acceleration, functions of time."""

    def __init__(self, system, force=lambda t: 0.0, ground=lambda t: 0.0):
        p = self.p = dict(system.parameters)
        self.kind, self.law, self.force, self.ground = system.kind, system.law, force, ground
        self.damped = "m2" in p
        self.m1, self.k1, self.c1 = (p.get(a, p.get(b, 0.0)) for a, b in zip(
            ("m1", "k1", "c1"), "mkc", strict=True))  # fmt: skip
        self.m2, self.k2, self.c2 = (p.get(name, 0.0) for name in ("m2", "k2", "c2"))
        self.rest = p["V"] + p["C"] if self.kind == "ssul" else p.get("D", 0.0)
        self.weight = p.get("g", 0.0) if self.kind == "ball" else 0.0
        walls = system.scene.walls
        self.constants = system.contact(walls[0]) if walls else {}
        self.rigid = "e" in self.constants
        self.exponent = 1.0 if "kc" in self.constants else self.constants.get("exponent", 1.5)

    def walls(self, x1, u):
        """Return (depth, sign) of each wall; the sign is of the force on what is struck."""
        p, kind = self.p, self.kind
        if kind == "ssul":
            return [(p["V"] - u, 1.0)]
        if kind == "ssbl":
            return [(-u, 1.0), (u - p["D"] - p["C"], -1.0)]
        if kind in ("ssvi-b", "ssvi-c"):
            return [(u - p["D"] - p["C"], -1.0)]
        if kind == "ball":
            return [(-x1, 1.0)]
        far = [(-x1 - p["C_2"], 1.0)] if kind == "oscillator-2" else []
        return [(x1 - p["C"], -1.0), *far] if kind.startswith("oscillator") else []

    def elastic(self, z):
        if self.rigid or z <= 0.0:
            return 0.0
        return self.constants.get("kc", self.constants.get("K")) * z**self.exponent

    def push(self, z, rate):
        """Return the force of a wall."""
        c, elastic = self.constants, self.elastic(z)
        if z <= 0.0:
            return 0.0
        if "kc" in c:
            whole = elastic + c["cc"] * rate
            return whole if self.law == "kelvin-voigt" else max(0.0, whole)
        return elastic * max(0.0, 1.0 + c.get("hunt_crossley", 0.0) * rate)

    def at(self, t, y):
        """Return (A1, A2, contact forces, power lost in contacts)."""
        x1, v1 = y[X1] - y[Y], y[V1] - y[W]
        u, s = y[X2] - y[X1], y[V2] - y[V1]
        on1, on2 = self.force(t) - self.k1 * x1 - self.c1 * v1 - self.m1 * self.weight, 0.0
        if self.damped:
            pull = self.k2 * (u - self.rest) + self.c2 * s
            on1, on2 = on1 + pull, -pull
        forces, lost, struck = [], 0.0, s if self.damped else v1
        for z, sign in self.walls(x1, u):
            push = self.push(z, -sign * struck)
            forces.append(push)
            lost += (push - self.elastic(z)) * -sign * struck
            on1, on2 = (on1 - sign * push, on2 + sign * push) if self.damped else (
                on1 + sign * push, 0.0)  # fmt: skip
        return on1 / self.m1, on2 / self.m2 if self.damped else 0.0, forces, lost

    def energies(self, y):
        """Return (E1, E2, all that is stored), velocities relative to the ground."""
        x1, v1, x2, v2 = y[X1] - y[Y], y[V1] - y[W], y[X2] - y[Y], y[V2] - y[W]
        e1 = 0.5 * (self.m1 * v1**2 + self.k1 * x1**2)
        e2 = 0.5 * (self.m2 * v2**2 + self.k2 * (x2 - self.rest) ** 2)
        joint = 0.5 * (self.m2 * v2**2 + self.k2 * (x2 - x1 - self.rest) ** 2)
        walls = self.walls(x1, x2 - x1)
        contacts = sum(self.elastic(z) * max(z, 0.0) / (self.exponent + 1.0) for z, _ in walls)
        return e1, e2, e1 + joint + contacts + self.m1 * self.weight * x1

    def integrands(self, a1, lost, t, y):
        """Return the rates of the unknowns behind the ground's velocity."""
        raise NotImplementedError

    def slopes(self, t, y):
        a1, a2, _, lost = self.at(t, y)
        return [y[V1], a1, y[V2], a2, y[W], self.ground(t), *self.integrands(a1, lost, t, y)]


class Course:
    """Solutions one after the other, and any size (t, y) of them."""

    def __init__(self, solutions):
        self.solutions = solutions
        self.times = [
            np.interp(np.linspace(0, 1, 8 * len(run.t)), np.linspace(0, 1, len(run.t)), run.t)
            for run in self.solutions
        ]
        self.states = [run.sol(t) for t, run in zip(self.times, self.solutions, strict=True)]

    def values(self, size):
        """Return a size (t, y) at the times of each solution."""
        return [
            np.array([size(t, y) for t, y in zip(times, states.T, strict=True)])
            for times, states in zip(self.times, self.states, strict=True)
        ]

    def largest(self, size):
        """Return the largest absolute value of a size and its time."""
        best = (-1.0, 0.0)
        for run, times, values in zip(
            self.solutions, self.times, map(np.abs, self.values(size)), strict=True
        ):
            i = int(values.argmax())
            best = max(best, (float(values[i]), float(times[i])))
            ends = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
            peak = minimize_scalar(
                lambda t, run=run: -abs(size(t, run.sol(t))), bounds=ends, method="bounded",
                options={"xatol": 1e-10},
            )  # fmt: skip
            best = max(best, (-float(peak.fun), float(peak.x)))
        return best

    def last_above(self, size, level):
        """Return the last time at which a size exceeds a level; NaN if it does at the end."""
        for run, times, values in zip(
            self.solutions[::-1], self.times[::-1], self.values(size)[::-1], strict=True
        ):
            above = np.flatnonzero(values > level)
            if above.size and above[-1] == len(values) - 1:
                return math.nan if run is self.solutions[-1] else float(times[-1])
            if above.size:
                ends = times[above[-1]], times[above[-1] + 1]
                return brentq(lambda t, run=run: size(t, run.sol(t)) - level, *ends, xtol=1e-13)
        return 0.0

    def state(self, t):
        run = next(run for run in self.solutions if t <= run.t[-1])
        return run.sol(t)
