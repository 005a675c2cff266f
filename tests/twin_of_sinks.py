"""A slow and readable twin of nonlinear sinks on a host, in 80-bit arithmetic.

Written from the equations alone, with nothing imported from the package: the displacements x of
the host and of the masses,

    M x'' + C x' + K x = F cos(omega t) - sum over links of w (k2 r^2 + k3 r^3 + k5 r^5 + pushes)

with r = w x, as Taylor series of order `ORDER` in time, in `numpy.longdouble`. Cauchy's products
give the powers of r, the recursion of z^n the force of an elastic wall. That has no series where
the depth z is 0: the first and the last `KICK` of a contact are taken by quadrature along the
motion without the force, whose error is below round-off. Roots of events are enclosed by bounds of
the second derivative, so that no touch is missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

REAL = np.longdouble
ORDER = 28  # of the Taylor series
LAST = REAL(1e-21)  # share of the last term of a series
KICK = REAL(1e-4)  # share of a contact that is taken at once; the error is its square to the n + 1
SLOWEST = REAL(1e-13)  # speed of a rebound [m/s] below which a body that is pressed stays
MOST_STEPS = 200_000
MOST_HALVINGS = 60  # of an interval in which an event is looked for
PLACES, WEIGHTS = np.polynomial.legendre.leggauss(24)
PLACES, WEIGHTS = (0.5 * (PLACES + 1.0)).astype(REAL), (0.5 * WEIGHTS).astype(REAL)
GRADE = 4  # power of the places of a quadrature: smooth for z^n of any n >= 1
FREE, PUSHES, OFF, HELD = range(4)  # states of a wall; OFF: it would pull, and does not


class Wall(NamedTuple):
    """A wall that is touched where sign r = gap; constants by the names of the laws' pages."""

    link: int
    sign: int
    gap: float
    law: str
    constants: dict[str, float]

    @property
    def is_elastic(self) -> bool:
        return self.law in ("hertz", "power")

    @property
    def exponent(self) -> Any:
        return REAL(self.constants.get("exponent", 1.5))

    def of(self, name: str) -> Any:
        return REAL(self.constants.get(name, 0.0))


class Touch(NamedTuple):
    wall: int
    time: float
    speed: float


class Course(NamedTuple):
    sections: np.ndarray  # (periods, 2 size): x and x' at the ends of periods
    touches: list[Touch]


def value(c: Any, t: Any) -> Any:
    """Return a polynomial, coefficients by ascending powers in the first axis, at t."""
    total = c[-1]
    for n in range(len(c) - 2, -1, -1):
        total = total * t + c[n]
    return total


def first_rise(c: Any, end: Any) -> Any:
    """Return the first t in (0, end] where the polynomial rises through 0; None if it does not.

    It begins at or below 0. An interval is left out if its ends and a bound of
    the second derivative prove that the polynomial stays below 0, and halved if they do not.
    """
    powers = np.arange(len(c))
    slopes = (c * powers)[1:]
    bends = np.abs((slopes * powers[:-1])[1:])
    pending = [(REAL(0.0), end, 0)]
    while pending:
        low, high, depth = pending.pop()
        length = high - low
        bend = value(bends, high)
        left, right = value(c, low), value(c, high)
        if max(left, right) + length * length / 8 * bend < 0:
            continue
        slope = value(slopes, low)
        if slope + bend * length < 0 and left <= 0:
            continue
        if slope - bend * length > 0:
            if right <= 0:
                continue
            for _ in range(80):
                middle = (low + high) / 2
                if value(c, middle) > 0:
                    high = middle
                else:
                    low = middle
            return high
        if depth == MOST_HALVINGS:
            continue
        middle = (low + high) / 2
        pending += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return None


class Twin:
    """The equations of a system, and one orbit at a time.

    M, C, K: (size, size); F: (size,); links: (links, size) rows w; springs: (k2, k3, k5) of each
    link. All in SI units.
    """

    def __init__(
        self, M: Any, C: Any, K: Any, F: Any, omega: float, links: Any,
        springs: Sequence[tuple[float, float, float]], walls: Sequence[Wall],
    ) -> None:  # fmt: skip
        self.C, self.K, self.F = (np.asarray(one, REAL) for one in (C, K, F))
        self.inverse = inverted(np.asarray(M, REAL))
        self.links = np.asarray(links, REAL)
        self.k2, self.k3, self.k5 = np.array(springs, REAL).T
        self.omega = REAL(omega)
        self.walls = list(walls)
        self.answers = self.links @ self.inverse  # accelerations by a unit force along r
        self.stiffness, self.damping = self.inverse @ self.K, self.inverse @ self.C
        self.push = self.inverse @ self.F

    def follow(self, start: Any, periods: int) -> Course:
        """Return the course from x and x' (2 size,) at time 0 on."""
        size = len(self.F)
        self.x, self.v = np.array(start[:size], REAL), np.array(start[size:], REAL)
        self.time = REAL(0.0)
        self.modes = [FREE] * len(self.walls)
        self.kicks = [REAL(0.0)] * len(self.walls)
        touches: list[Touch] = []
        sections = []
        for period in range(1, periods + 1):
            end = 2 * PI * period / self.omega
            steps = 0
            while self.time < end:
                self.step(end, touches)
                steps += 1
                assert steps < MOST_STEPS
            sections.append(np.concatenate([self.x, self.v]))
        return Course(np.array(sections), touches)

    # ---- the series of a motion ------------------------------------------------------------------

    def expand(self, modes: Sequence[int]) -> tuple[Any, Any, Any]:
        """Return the series of x, of x' and of the forces (walls) that hold bodies."""
        N, links = ORDER, len(self.links)
        X, V = np.zeros((2, N + 1, len(self.x)), REAL)
        X[0], V[0] = self.x, self.v
        R, S, R2, R3, R4, R5 = np.zeros((6, N + 1, links), REAL)
        pushing = [i for i, mode in enumerate(modes) if mode == PUSHES]
        held = [i for i, mode in enumerate(modes) if mode == HELD]
        Z, Q, P = np.zeros((3, N + 1, len(self.walls)), REAL)
        holding = np.zeros((N + 1, len(self.walls)), REAL)
        phase = self.omega * self.time
        turn = [np.cos(phase), -np.sin(phase), -np.cos(phase), np.sin(phase)]
        factor = REAL(1.0)  # omega^n / n!
        for n in range(N):
            R[n], S[n] = self.links @ X[n], self.links @ V[n]
            R2[n] = (R[: n + 1] * R[n::-1]).sum(axis=0)
            R3[n] = (R[: n + 1] * R2[n::-1]).sum(axis=0)
            R4[n] = (R2[: n + 1] * R2[n::-1]).sum(axis=0)
            R5[n] = (R[: n + 1] * R4[n::-1]).sum(axis=0)
            force = self.k2 * R2[n] + self.k3 * R3[n] + self.k5 * R5[n]
            for i in pushing:
                wall = self.walls[i]
                Z[n, i] = wall.sign * R[n, wall.link] - (wall.gap if n == 0 else 0)
                Q[n, i] = wall.sign * S[n, wall.link]
                force[wall.link] += wall.sign * push_term(wall, Z[:, i], Q[:, i], P[:, i], n)
            A = self.push * (turn[n % 4] * factor) - self.stiffness @ X[n] - self.damping @ V[n]
            A -= force @ self.answers
            if held:
                rows = np.array([self.links[self.walls[i].link] for i in held])
                answers = np.array([self.answers[self.walls[i].link] for i in held])
                needed = solved(rows @ answers.T, rows @ A)
                A -= needed @ answers
                for one, i in zip(needed, held, strict=True):
                    holding[n, i] = self.walls[i].sign * one
            factor *= self.omega / (n + 1)
            X[n + 1], V[n + 1] = V[n] / (n + 1), A / (n + 1)
        return X, V, holding

    def length_of(self, X: Any, V: Any) -> Any:
        """Return the length of a step whose last terms are LAST of the motion."""
        tallest, fastest = np.abs(X[0]).max(), np.abs(V[0]).max()
        tallest = max(tallest, fastest / (20 * self.omega))
        fastest = max(fastest, self.omega * tallest)
        length = REAL(0.25) * PI / self.omega
        for n in (ORDER - 1, ORDER):
            for series, scale in ((X, tallest), (V, fastest)):
                last = np.abs(series[n]).max()
                if last > 0:
                    length = min(length, (LAST * scale / last) ** (REAL(1.0) / n))
        return length

    # ---- one step --------------------------------------------------------------------------------

    def step(self, end: Any, touches: list[Touch]) -> None:
        """Take one step, or what happens at once: a kick, the end of a contact."""
        for i, mode in enumerate(self.modes):
            if mode == PUSHES and self.walls[i].is_elastic and self.leave(i, end):
                return
        X, V, holding = self.expand(self.modes)
        h = min(self.length_of(X, V), end - self.time)
        happens = None
        for i, (wall, mode) in enumerate(zip(self.walls, self.modes, strict=True)):
            row = self.links[wall.link]
            depth, rate = wall.sign * (X @ row), wall.sign * (V @ row)
            depth[0] -= wall.gap
            for what, series in events_of(wall, mode, depth, rate, holding[:, i]):
                series[0] = min(series[0], REAL(0.0))  # it began there: more is round-off
                at = first_rise(series, h)
                if at is not None and what == "nearly out":
                    h, happens = at / 2, None
                elif at is not None:
                    h, happens = at, (what, i)
        self.x, self.v = value(X, h), value(V, h)
        self.time = end if h == end - self.time else self.time + h
        if happens is not None:
            self.act(*happens, end, touches)

    def act(self, what: str, i: int, end: Any, touches: list[Touch]) -> None:
        wall = self.walls[i]
        row = self.links[wall.link]
        speed = wall.sign * (row @ self.v)
        if what == "touched":
            touches.append(Touch(i, float(self.time), float(speed)))
            if wall.law == "restitution":
                self.rebound(i, speed)
            elif wall.is_elastic:
                self.begin(i, speed, end)
            else:
                self.modes[i] = PUSHES
        elif what == "out":
            self.modes[i] = FREE
        else:
            self.modes[i] = {"off": OFF, "on": PUSHES, "let go": FREE}[what]

    def rebound(self, i: int, speed: Any) -> None:
        """Apply Newton's law with momentum kept by walls that hold others; hold what is pressed."""
        wall = self.walls[i]
        active = [i, *(j for j, mode in enumerate(self.modes) if mode == HELD)]
        rows = np.array([self.links[self.walls[j].link] for j in active])
        answers = np.array([self.answers[self.walls[j].link] for j in active])
        change = np.zeros(len(active), REAL)
        change[0] = -(1 + wall.of("e")) * wall.sign * speed
        self.v = self.v + solved(rows @ answers.T, change) @ answers
        if wall.of("e") * speed < SLOWEST:
            modes = list(self.modes)
            modes[i] = HELD
            _, _, holding = self.expand(modes)
            if holding[0, i] > 0:
                self.modes = modes

    def begin(self, i: int, speed: Any, end: Any) -> None:
        """Take the first part of an elastic contact at once."""
        wall = self.walls[i]
        mu = 1 / (self.links[wall.link] @ self.answers[wall.link])
        n = wall.exponent
        depth = ((n + 1) * mu * speed * speed / (2 * wall.of("K"))) ** (1 / (n + 1))
        self.kicks[i] = KICK * depth / speed
        took = min(self.kicks[i], end - self.time)
        self.kick(i, took, PLACES**GRADE, GRADE * PLACES ** (GRADE - 1) * WEIGHTS)
        self.modes[i] = PUSHES

    def leave(self, i: int, end: Any) -> bool:
        """Take the last part of an elastic contact at once, if it has come; tell whether."""
        wall = self.walls[i]
        row = self.links[wall.link]
        if not wall.sign * (row @ self.v) < 0:
            return False
        depth = wall.sign * (row @ self.x) - wall.gap
        if not depth < -2 * wall.sign * (row @ self.v) * self.kicks[i]:
            return False
        modes = list(self.modes)
        modes[i] = FREE
        X, _, _ = self.expand(modes)
        depths = wall.sign * (X @ row)
        depths[0] -= wall.gap
        took = first_rise(-depths, self.kicks[i])
        if took is None or self.time + took > end:
            return False
        self.modes = modes
        self.kick(i, took, 1 - PLACES**GRADE, GRADE * PLACES ** (GRADE - 1) * WEIGHTS)
        return True

    def kick(self, i: int, time: Any, places: Any, weights: Any) -> None:
        """Move without the force of wall i, and add its impulse along that motion."""
        wall = self.walls[i]
        modes = list(self.modes)
        modes[i] = FREE
        row = self.links[wall.link]
        X, V, _ = self.expand(modes)
        impulse = moment = REAL(0.0)
        for place, weight in zip(places, weights, strict=True):
            z = wall.sign * (row @ value(X, place * time)) - wall.gap
            s = wall.sign * (row @ value(V, place * time))
            force = wall.of("K") * max(z, REAL(0.0)) ** wall.exponent
            force *= max(1 + wall.of("hunt_crossley") * s, REAL(0.0))
            impulse += weight * time * force
            moment += weight * time * (1 - place) * time * force
        answer = wall.sign * self.answers[wall.link]
        self.x = value(X, time) - moment * answer
        self.v = value(V, time) - impulse * answer
        self.time = self.time + time


def push_term(wall: Wall, z: Any, s: Any, power: Any, n: int) -> Any:
    """Return coefficient n of the force of a wall by the series of the depth and its rate."""
    if not wall.is_elastic:
        return wall.of("kc") * z[n] + wall.of("cc") * s[n]
    exponent = wall.exponent
    if n == 0:
        power[0] = z[0] ** exponent
    else:
        k = np.arange(1, n + 1)
        power[n] = ((k * exponent - (n - k)) * z[1 : n + 1] * power[n - 1 :: -1][:n]).sum()
        power[n] /= n * z[0]
    damped = (power[: n + 1] * s[n::-1][: n + 1]).sum()
    return wall.of("K") * (power[n] + wall.of("hunt_crossley") * damped)


def events_of(wall: Wall, mode: int, depth: Any, rate: Any, holding: Any) -> list[tuple[str, Any]]:
    """Return what may happen at a wall, and the series that rises through 0 then."""
    if wall.is_elastic:
        margin = wall.of("hunt_crossley") * rate
        margin[0] += 1
    else:
        margin = wall.of("kc") * depth + wall.of("cc") * rate
    if mode == FREE:
        return [("touched", depth)]
    if mode == HELD:
        return [("let go", -holding[:ORDER])]
    if mode == OFF:
        return [("out", -depth), ("on", margin)]
    switches = [("off", -margin)] if wall.law == "linear" or wall.of("hunt_crossley") > 0 else []
    return [*switches, ("nearly out" if wall.is_elastic else "out", -depth)]


PI = 4 * np.arctan(REAL(1))


def solved(matrix: Any, right: Any) -> Any:
    """Return the solution of a linear system by Gauss' elimination with pivots."""
    a, b = np.array(matrix, REAL), np.array(right, REAL)
    n = len(a)
    for k in range(n):
        pivot = k + int(np.abs(a[k:, k]).argmax())
        a[[k, pivot]], b[[k, pivot]] = a[[pivot, k]], b[[pivot, k]]
        for i in range(k + 1, n):
            share = a[i, k] / a[k, k]
            a[i] -= share * a[k]
            b[i] = b[i] - share * b[k]
    for k in range(n - 1, -1, -1):
        b[k] = (b[k] - a[k, k + 1 :] @ b[k + 1 :]) / a[k, k]
    return b


def inverted(matrix: Any) -> Any:
    return solved(matrix, np.eye(len(matrix)))
