"""Motions of `twin_of_laws` over a short time, and what may be asked of them.

Where all forces are linear (flights, contacts on a spring and a dashpot, a damper that a wall has
let go) the motion is a Taylor series in time. A contact of elastic bodies is smooth in theta,
z = q^p and dt = p q^(p - 1) dtheta; there it is extrapolated from midpoint steps (Gragg, Bulirsch,
Stoer) to places through which a polynomial goes. Events are looked for between many samples, and
maxima closer and closer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

TERMS = 25  # of a Taylor series
SAMPLES = np.linspace(0.0, 1.0, 17)  # of a span
FITTED = (
    1.0 - np.cos(np.pi * np.arange(15) / 14.0)
) / 2.0  # places through which a step in theta goes
COLUMNS = (2, 4, 6, 8, 10, 12, 14, 16)  # midpoint steps of the extrapolation
ZOOMS = 5  # of the search for a maximum, by eight each
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
AT_NODES = np.vander((NODES + 1.0) / 2.0, TERMS, increasing=True)
FINE = 3e-15  # of a step in theta, as the last two extrapolations differ
LEAST = 1e-4  # of q, a step in theta that is as good as it gets
FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * FITTED - 1.0, 14))
X1, V1, X2, V2, COS, SIN, ONE = range(7)


class Law(NamedTuple):
    """Constants of a wall: force K z^n max(0, 1 + a s), or kc z + cc s, or -e times the speed."""

    name: str
    K: float = 0.0
    n: float = 1.5
    a: float = 0.0
    kc: float = 0.0
    cc: float = 0.0
    e: float = 0.0

    @property
    def elastic(self) -> bool:
        return self.name in ("hertz", "power")


@dataclass(frozen=True)
class Wall:
    """A wall that pushes g (u = x2 - x1, or the x of a single mass) back: z = sign (g - place)."""

    which: int  # 0 near, 1 far
    sign: float
    place: float
    law: Law


@dataclass(frozen=True)
class Model:
    """Equation (5): a structure, perhaps a damper, walls, a constant load, a limit of g."""

    m1: float
    k1: float
    c1: float
    P: float
    omega: float
    load: float = 0.0  # [m/s^2] on x1
    m2: float | None = None
    k2: float = 0.0
    c2: float = 0.0
    rest: float = 0.0
    walls: tuple[Wall, ...] = ()
    limit: float = -math.inf  # g must not fall below it
    decay: float = 0.0  # [1/s] of the force P cos: with it that is one part of a load

    @property
    def g(self) -> np.ndarray:
        """Return the row of g, which walls and limit bound, as a function of the state."""
        row = np.zeros(7)
        row[X1] = 1.0
        if self.m2 is not None:
            row[X1], row[X2] = -1.0, 1.0
        return row

    def depth(self, wall: Wall) -> np.ndarray:
        """Return z of a wall, as a function of the state."""
        row = wall.sign * self.g
        row[ONE] = -wall.sign * wall.place
        return row

    def speed(self, wall: Wall) -> np.ndarray:
        """Return dz/dt."""
        row, z = np.zeros(7), self.depth(wall)
        row[V1], row[V2] = z[X1], z[X2]
        return row

    def pushed(self, wall: Wall) -> np.ndarray:
        """Return the change of the derivatives by one newton of a wall."""
        column = np.zeros(7)
        if self.m2 is None:
            column[V1] = -wall.sign / self.m1
        else:
            column[V1], column[V2] = wall.sign / self.m1, -wall.sign / self.m2
        return column

    @property
    def free(self) -> np.ndarray:
        """Return the matrix of the motion without walls."""
        A = np.zeros((7, 7))
        A[X1, V1] = A[X2, V2] = 1.0
        A[V1, :2] = -self.k1 / self.m1, -self.c1 / self.m1
        A[V1, COS], A[V1, ONE] = self.P / self.m1, self.load
        A[COS, SIN], A[SIN, COS] = -self.omega, self.omega
        A[COS, COS] = A[SIN, SIN] = -self.decay
        if self.m2 is None:
            A[X2, V2] = 0.0
        else:
            spring = np.array([self.k2, self.c2, -self.k2, -self.c2, 0.0, 0.0, self.k2 * self.rest])
            A[V1] -= spring / self.m1
            A[V2] += spring / self.m2
        return A

    def energies(self, w: np.ndarray) -> tuple[Any, Any]:
        """Return E1 and E2 of states (..., 7)."""
        E1 = 0.5 * (self.m1 * w[..., V1] ** 2 + self.k1 * w[..., X1] ** 2)
        if self.m2 is None:
            return E1, 0.0 * E1
        return E1, 0.5 * (self.m2 * w[..., V2] ** 2 + self.k2 * (w[..., X2] - self.rest) ** 2)


# ---- spans ---------------------------------------------------------------------------------------


@dataclass
class Linear:
    """A motion with linear forces over a time h: the Taylor series of the state in x = t / h."""

    A: np.ndarray
    series: np.ndarray
    h: float
    force_row: np.ndarray  # the wall's force, a function of the state

    @classmethod
    def of(cls, A: np.ndarray, w: np.ndarray, h: float, force_row: np.ndarray) -> Linear:
        series = np.empty((TERMS, 7))
        series[0] = w
        for k in range(1, TERMS):
            series[k] = A @ series[k - 1] * (h / k)
        return cls(A, series, h, force_row)

    def states(self, xs: np.ndarray) -> np.ndarray:
        return np.vander(xs, TERMS, increasing=True) @ self.series

    def time(self, x: float) -> float:
        return x * self.h

    def rates(self, w: np.ndarray) -> np.ndarray:
        return w @ self.A.T

    def force(self, w: np.ndarray) -> Any:
        return w @ self.force_row

    def cut(self, x: float) -> Linear:
        return Linear(
            self.A, self.series * (x ** np.arange(TERMS))[:, None], x * self.h, self.force_row
        )

    def integral(self, function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return np.asarray(function(AT_NODES @ self.series)) @ WEIGHTS * (self.h / 2.0)


@dataclass
class Squeezed:
    """A step in theta of a contact of elastic bodies: a polynomial of (q, s, x1, v1, tau)."""

    contact: Contact
    fit: np.ndarray  # Chebyshev coefficients over the step
    h: float  # of theta
    part: float = 1.0  # of the step

    @classmethod
    def of(cls, contact: Contact, y: np.ndarray, h: float) -> Squeezed:
        """Return a step of h at most, in which extrapolations agree."""
        while True:
            with np.errstate(over="ignore", invalid="ignore"):  # then the step is too long
                rows, apart = contact.extrapolated(y, FITTED * h)
                fit, scale = FIT @ rows.T, float(np.abs(rows[:4]).max())
            off = max(apart, float(np.abs(fit[-2:, :4]).max()))
            if off <= FINE * scale or h < LEAST * max(abs(float(y[0])), 1e-6):
                return cls(contact, fit, h)
            h *= 0.6

    def at(self, x: Any) -> np.ndarray:
        t = 2.0 * self.part * np.asarray(x) - 1.0
        return np.moveaxis(np.polynomial.chebyshev.chebval(t, self.fit), 0, -1)

    def states(self, xs: np.ndarray) -> np.ndarray:
        return self.contact.states(self.at(xs))

    def time(self, x: float) -> float:
        return float(self.at(x)[4])

    def rates(self, w: np.ndarray) -> np.ndarray:
        model, wall = self.contact.model, self.contact.wall
        return w @ model.free.T + np.multiply.outer(self.force(w), model.pushed(wall))

    def force(self, w: np.ndarray) -> Any:
        model, wall = self.contact.model, self.contact.wall
        z, s = np.maximum(w @ model.depth(wall), 0.0), w @ model.speed(wall)
        return wall.law.K * z**wall.law.n * (1.0 + wall.law.a * s)

    def cut(self, x: float) -> Squeezed:
        return Squeezed(self.contact, self.fit, self.h, self.part * x)

    def integral(self, function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return an integral over time: dt = p q^(p - 1) dtheta."""
        y = self.at((NODES + 1.0) / 2.0)
        dt = self.contact.p * y[:, 0] ** (self.contact.p - 1)
        values = np.asarray(function(self.contact.states(y)))
        return values @ (WEIGHTS * dt) * (self.part * self.h / 2.0)


class Contact:
    """A contact of elastic bodies as a differential equation in theta."""

    def __init__(self, model: Model, wall: Wall, w: np.ndarray) -> None:
        """Take the state w (7,) at tau = 0."""
        self.model, self.wall, self.w = model, wall, w
        n = wall.law.n
        self.p = next((p for p in range(1, 7) if abs(p * n - round(p * n)) < 1e-12), 8)

    def states(self, y: np.ndarray) -> np.ndarray:
        """Return the states (..., 7) of (q, s, x1, v1, tau) (..., 5)."""
        q, s, x1, v1, tau = np.moveaxis(y, -1, 0)
        sign, one = self.wall.sign, np.ones_like(q)
        g, rate = self.wall.place + sign * q**self.p, sign * s
        left = np.exp(-self.model.decay * tau)
        c, d = left * np.cos(self.model.omega * tau), left * np.sin(self.model.omega * tau)
        phase = self.w[COS] * c - self.w[SIN] * d, self.w[SIN] * c + self.w[COS] * d
        if self.model.m2 is None:
            return np.stack([g, rate, 0 * one, 0 * one, *phase, one], -1)
        return np.stack([x1, v1, x1 + g, v1 + rate, *phase, one], -1)

    def power(self, q: np.ndarray) -> np.ndarray:
        """Return z^n, continued beyond z = 0 as smoothly as it goes."""
        whole = round(self.p * self.wall.law.n)
        if abs(whole - self.p * self.wall.law.n) < 1e-12:
            return q**whole
        return np.abs(q) ** (self.p * self.wall.law.n)

    def slope(self, y: np.ndarray) -> np.ndarray:
        """Return the derivatives by theta of (q, s, x1, v1, tau), a column for each state."""
        q, s, x1, v1, tau = y
        m, law, sign = self.model, self.wall.law, self.wall.sign
        phase = m.omega * tau
        drive = m.P * (self.w[COS] * np.cos(phase) - self.w[SIN] * np.sin(phase))
        drive = drive * np.exp(-m.decay * tau)
        force = law.K * self.power(q) * (1.0 + law.a * s)
        g, rate = self.wall.place + sign * q**self.p, sign * s
        if m.m2 is None:
            a1 = (drive - m.k1 * g - m.c1 * rate - sign * force) / m.m1 + m.load
            ds = sign * a1
        else:
            spring = m.k2 * (g - m.rest) + m.c2 * rate
            a1 = (drive - m.k1 * x1 - m.c1 * v1 + spring + sign * force) / m.m1 + m.load
            ds = sign * ((-spring - sign * force) / m.m2 - a1)
        # dt = p q^(p - 1) dtheta, so that dq = s dtheta
        weight = self.p * q ** (self.p - 1)
        return np.array([s, weight * ds, weight * v1, weight * a1, weight])

    def extrapolated(self, y: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, float]:
        """Return y (5,) after each of the steps h, a column each.

        And how far the last two extrapolations differ.
        """
        start = np.repeat(np.asarray(y)[:, None], len(h), axis=1)
        table: list[np.ndarray] = []
        first, apart = self.slope(start), math.inf
        for k, n in enumerate(COLUMNS):
            step = h / n
            before, now = start, start + step * first
            for _ in range(n - 1):
                before, now = now, before + 2.0 * step * self.slope(now)
            row = [(before + now + step * self.slope(now)) / 2.0 - start]
            for j in range(k):
                ratio = (n / COLUMNS[k - 1 - j]) ** 2
                row.append(row[j] + (row[j] - table[j]) / (ratio - 1.0))
            apart = float(np.abs((row[-1] - row[-2])[:4]).max()) if k else math.inf
            table = row
        return start + table[-1], apart


Span = Linear | Squeezed


def state(span: Span, x: float) -> np.ndarray:
    """Return the state at one place of a span."""
    return span.states(np.array([x]))[0]


def largest(span: Span, values: np.ndarray, function: Callable[[np.ndarray], Any], so_far: float):
    """Return the larger of `so_far` and the largest value of a function of states over a span."""
    top, xs = max(so_far, float(values.max())), SAMPLES
    for i in range(len(xs)):
        low, high = max(i - 1, 0), min(i + 1, len(xs) - 1)
        rise = values[i] - min(values[low], values[high])
        if values[i] < max(values[low], values[high]) or values[i] + rise <= so_far:
            continue
        a, b = xs[low], xs[high]
        for _ in range(ZOOMS):
            places = a + (b - a) * SAMPLES
            sampled = function(span.states(places))
            j = int(sampled.argmax())
            top, a, b = max(top, float(sampled[j])), places[max(j - 1, 0)], places[min(j + 1, 16)]
    return top


def root(span: Span, function: Callable[[np.ndarray], Any], low: float, high: float) -> float:
    """Return where a function of the state rises through zero between two places."""
    if function(state(span, low)) >= 0.0:
        return low
    return float(brentq(lambda x: float(function(state(span, x))), low, high, xtol=1e-16))


def first_rise(span: Span, row: np.ndarray, states: np.ndarray) -> float:
    """Return the first place at which a linear function of the state rises through 0, or inf.

    At the beginning of the span it counts as below zero. Between samples it may rise and fall.
    """
    values, rates, xs = states @ row, span.rates(states) @ row, SAMPLES
    values[0] = min(values[0], 0.0)
    for i in range(1, len(xs)):
        if values[i] > 0.0:
            low = xs[i - 1]
            if i == 1 and rates[0] < 0.0:  # it begins on zero, and comes back at once
                low = root(span, lambda w: span.rates(w) @ row, low, xs[1])
            return root(span, lambda w: w @ row, low, xs[i])
        if rates[i - 1] > 0.0 and rates[i] < 0.0:
            top = root(span, lambda w: -(span.rates(w) @ row), xs[i - 1], xs[i])
            if state(span, top) @ row > 0.0:
                return root(span, lambda w: w @ row, xs[i - 1], top)
    return math.inf
