"""A slow and readable twin of every kind under every contact law, to judge the package by.

Written from the equations alone (eq. (5), the laws of `docs/dampers.md`), in original variables,
with nothing imported from the package. An orbit is put together of spans. Where all forces are
linear (flights, contacts on a spring and a dashpot, a damper that a wall has let go) a span is a
Taylor series in time. A contact of elastic bodies is smooth in theta, z = q^p and
dt = p q^(p - 1) dtheta; there it is extrapolated from midpoint steps (Gragg, Bulirsch, Stoer) to
places through which a polynomial goes. Events are looked for between many samples, and maxima
closer and closer.
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

    @property
    def constants(self) -> dict[str, Any]:
        """The law and its constants, by the names that a system has for them."""
        if not self.elastic:
            rigid = self.name == "restitution"
            return {"law": self.name} | ({"e": self.e} if rigid else {"kc": self.kc, "cc": self.cc})
        exponent = {"exponent": self.n} if self.name == "power" else {}
        damping = {"hunt_crossley": self.a} if self.a > 0.0 else {}
        return {"law": self.name, "K": self.K} | exponent | damping


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
        """Return y after each step h, a column each; how far the last extrapolations differ."""
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
    """Return where a linear function of the state first rises through 0, or inf.

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


# ---- orbits --------------------------------------------------------------------------------------


FLIGHT, SQUEEZED, PRESSED, LET_GO = range(4)  # what an orbit does; the last three at a wall


class ChatterError(Exception):
    """Rebounds come to rest, or a contact rests and takes endless steps: not for this twin."""


class Touch:
    """An impact: as `simulate` reports one, and a contact that the orbit begins in."""

    def __init__(self, wall: int, time: float, speed: float, energies: tuple[float, float]) -> None:
        self.wall, self.touch, self.speed = wall, time, speed
        self.release, self.depth, self.force = math.nan, 0.0, 0.0
        self.before, self.gains = energies, (math.nan, math.nan)


class Course:
    """One orbit, period by period; what is noted stands in its attributes.

    states: at all stops; impacts: of `Touch`; tops: largest E1, E2, |x1|, |v1|, |a1|, |u - rest|;
    integrals of x1^2, v1^2, a1^2, (u - rest)^2, (du/dt)^2, of what contacts take and of P cos v1;
    clearance; passages: of the limit (time, excess); lets_go: how often a damped wall has let go.
    """

    MOST, MOST_SPANS = 60, 5000  # impacts, and spans, of a period

    def __init__(self, model: Model, noting: bool = True) -> None:
        self.noting = noting
        self.model, self.mode, self.wall, self.open = model, FLIGHT, None, None
        self.states: list[np.ndarray] = []
        self.impacts: list[Touch] = []
        self.passages: list[list[float]] = []
        self.tops, self.forces = np.zeros(6), np.zeros(2)
        self.integrals, self.clearance = np.zeros(7), math.inf
        self.lets_go, self.pushes_again, self.beyond, self.worst = 0, 0, False, 0.0
        fastest = max(np.abs(np.linalg.eigvals(model.free)).max(), model.omega)
        self.h = 0.7 / float(fastest)

    def period(self, start: np.ndarray, index: int, stops: int) -> None:
        """Follow a period from a state (x1, v1[, x2, v2]) at its beginning, with stops in it."""
        T, w = 2.0 * math.pi / self.model.omega, np.zeros(7)
        w[: len(start)] = start
        w[COS], w[ONE] = 1.0, 1.0
        self.enter(w)
        count, spans, seen = len(self.impacts), 0, 0.0
        for k in range(stops):
            end = (k + 1) * T / stops
            while seen < end:
                w, took = self.advance(w, end - seen, index * T + seen)
                seen, spans = end if took >= end - seen else seen + took, spans + 1
                if len(self.impacts) - count > self.MOST or spans > self.MOST_SPANS:
                    raise ChatterError
            phase = 2.0 * math.pi * (k + 1) / stops
            w[COS], w[SIN] = math.cos(phase), math.sin(phase)
            self.states.append(w[: len(start)].copy())

    def enter(self, w: np.ndarray) -> None:
        """Begin at a state of which only its numbers tell what the orbit does there."""
        m, wall_before = self.model, self.wall
        self.mode, self.wall = FLIGHT, None
        self.tops[:2] = np.maximum(self.tops[:2], m.energies(w))
        for wall in m.walls:
            if w @ m.depth(wall) > 0.0 and wall.law.name != "restitution":
                self.wall, law = wall, wall.law
                force = w @ (law.kc * m.depth(wall) + law.cc * m.speed(wall))
                if law.elastic:
                    self.mode = SQUEEZED if 1.0 + law.a * (w @ m.speed(wall)) > 0.0 else LET_GO
                else:
                    pulls = law.name == "kelvin-voigt"
                    self.mode = PRESSED if pulls or force > 0.0 else LET_GO
        if wall_before is not self.wall:
            self.open = None

    def advance(self, w: np.ndarray, left: float, now: float) -> tuple[np.ndarray, float]:
        """Follow one span for the time `left` at most; return the state and the time it took."""
        if self.mode == SQUEEZED:
            return self.squeeze(w, left, now)
        m, wall = self.model, self.wall
        A, force_row = m.free, np.zeros(7)
        if self.mode == PRESSED:
            force_row = wall.law.kc * m.depth(wall) + wall.law.cc * m.speed(wall)
            A = A + np.outer(m.pushed(wall), force_row)
            fastest = float(np.abs(np.linalg.eigvals(A)).max())
        h = 0.7 / fastest if self.mode == PRESSED else self.h
        span = Linear.of(A, w, min(h, left), force_row)
        states = span.states(SAMPLES)
        place, what = math.inf, None
        for row, event in self.watched(force_row):
            x = first_rise(span, row, states)
            if x < place:
                place, what = x, event
        if what is not None:
            span = span.cut(place)
        self.note(span, now)
        w, took = state(span, 1.0), span.h
        if what is not None:
            self.happens(what, w, now + took)
        return w, took

    def watched(self, force_row: np.ndarray) -> list[tuple[np.ndarray, Any]]:
        """Return the functions whose rise through zero ends a linear span, with their events."""
        m, wall = self.model, self.wall
        if self.mode == FLIGHT:
            return [(m.depth(wall), wall) for wall in m.walls]
        out = -m.depth(wall)
        if self.mode == PRESSED:
            pulls = wall.law.name == "kelvin-voigt"
            return [(out, "release")] if pulls else [(-force_row, "lets go")]
        again = wall.law.kc * m.depth(wall) + wall.law.cc * m.speed(wall)
        if wall.law.elastic:
            again = wall.law.a * m.speed(wall)
            again[ONE] += 1.0
        return [(out, "out"), (again, "again")]

    def happens(self, what: Any, w: np.ndarray, now: float) -> None:
        """Go on in another mode."""
        m, wall = self.model, self.wall
        if isinstance(what, Wall):
            self.touch(what, w, now)
        elif what == "release" or (what == "out" and wall.law.elastic):
            self.leave(w, now)
        elif what == "lets go":  # the impact ends here, at a depth
            self.leave(w, now)
            if wall.law.cc > 0.0:
                self.mode, self.wall = LET_GO, wall
        elif what == "out":
            self.mode, self.wall = FLIGHT, None
        elif wall.law.elastic:
            self.pushes_again += 1
            self.mode = SQUEEZED
        else:
            self.open = Touch(wall.which, now, abs(w @ m.speed(wall)), m.energies(w))
            self.impacts.append(self.open)
            self.mode = PRESSED

    def touch(self, wall: Wall, w: np.ndarray, now: float) -> None:
        """Begin an impact; of rigid bodies it is over."""
        m, s = self.model, float(w @ self.model.speed(wall))
        self.open = Touch(wall.which, now, abs(s), m.energies(w))
        self.impacts.append(self.open)
        self.wall = wall
        if wall.law.name != "restitution":
            self.mode = SQUEEZED if wall.law.elastic else PRESSED
            return
        column = m.pushed(wall)
        impulse = (1.0 + wall.law.e) * s / -(m.speed(wall) @ column)
        w += impulse * column
        self.forces[wall.which] = max(self.forces[wall.which], impulse)
        if wall.law.e * s < 1e-4 * abs(m.free[[V1, V2]] @ w).max() / np.abs(m.free).max() ** 0.5:
            raise ChatterError
        self.leave(w, now)

    def leave(self, w: np.ndarray, now: float) -> None:
        """Complete the impact under way, and fly."""
        if self.open is not None:
            self.open.release = now
            after = self.model.energies(w)
            self.open.gains = tuple(b - a for a, b in zip(self.open.before, after, strict=True))
            self.open = None
        self.mode, self.wall = FLIGHT, None

    def squeeze(self, w: np.ndarray, left: float, now: float) -> tuple[np.ndarray, float]:
        """Follow a step of a contact of elastic bodies."""
        m, wall = self.model, self.wall
        contact, law = Contact(m, wall, w), wall.law
        z, s = max(float(w @ m.depth(wall)), 0.0), float(w @ m.speed(wall))
        if self.open is not None and now == self.open.touch:
            z = 0.0
        y = np.array([z ** (1.0 / contact.p), s, w[X1], w[V1], 0.0])
        span = Squeezed.of(contact, y, self.step_of(contact, y))
        place, what = math.inf, None
        for name, function in (
            ("leave", lambda x: -span.at(x)[..., 0]),
            ("time", lambda x: span.at(x)[..., 4] - left),
            ("lets go", lambda x: -1.0 - law.a * span.at(x)[..., 1]),
        ):  # fmt: skip
            beyond = np.flatnonzero(function(SAMPLES[1:]) > 0.0)
            if beyond.size:
                low, high = SAMPLES[beyond[0]], SAMPLES[beyond[0] + 1]
                if low == 0.0:
                    low = 1e-4 * high  # at a touch q is 0, too
                x = low if function(low) > 0.0 else float(brentq(function, low, high, xtol=1e-15))
                if x < place:
                    place, what = x, name
        if what is not None:
            span = span.cut(place)
        self.note(span, now)
        w, took = state(span, 1.0), span.time(1.0)
        if what == "leave":
            self.leave(w, now + took)
        elif what == "lets go":
            self.lets_go += 1
            self.mode = LET_GO
        return w, left if what == "time" else took

    def step_of(self, contact: Contact, y: np.ndarray) -> float:
        """Return a step of theta that is a part of the contact, and of all other motion."""
        law, m, p = self.wall.law, self.model, contact.p
        mass, power = 1.0 / -(m.speed(self.wall) @ m.pushed(self.wall)), law.n + 1.0
        z = y[0] ** p
        deep = (power * mass * y[1] ** 2 / (2.0 * law.K) + z**power) ** (1.0 / power)
        fast = max(abs(y[1]), math.sqrt(law.K * deep**power / mass))
        return min(0.4 * deep / fast, 0.4 * self.h) / (p * deep ** ((p - 1.0) / p))

    # ---- what is noted ---------------------------------------------------------------------------

    def note(self, span: Span, now: float) -> None:
        """Note a span."""
        if not self.noting:
            return
        m, states = self.model, span.states(SAMPLES)
        stroke = m.g.copy()
        stroke[ONE] = -m.rest
        quantities = (
            lambda w: m.energies(w)[0], lambda w: m.energies(w)[1], lambda w: np.abs(w[..., X1]),
            lambda w: np.abs(w[..., V1]), lambda w: np.abs(span.rates(w)[..., V1]),
            lambda w: np.abs(w @ stroke),
        )  # fmt: skip
        for i, function in enumerate(quantities):
            self.tops[i] = largest(span, function(states), function, self.tops[i])
        if self.wall is not None:
            wall = self.wall
            depth = m.depth(wall)
            force = largest(span, span.force(states), span.force, 0.0)
            self.forces[wall.which] = max(self.forces[wall.which], force)
            if self.open is not None:
                deepest = lambda w: w @ depth  # noqa: E731
                self.open.depth = largest(span, states @ depth, deepest, self.open.depth)
                self.open.force = max(self.open.force, force)
        else:
            for wall in m.walls:
                self.note_miss(span, states, m.depth(wall))
        self.note_limit(span, states, now)
        self.integrals += span.integral(
            lambda w: np.array(
                [
                    w[:, X1] ** 2,
                    w[:, V1] ** 2,
                    span.rates(w)[:, V1] ** 2,
                    (w @ stroke) ** 2,
                    (w[:, V2] - w[:, V1]) ** 2,
                    span.force(w) * (w @ m.speed(self.wall) if self.wall else 0.0),
                    m.P * w[:, COS] * w[:, V1],
                ]
            )
        )
        self.integrals[5] += self.stored(state(span, 0.0)) - self.stored(state(span, 1.0))

    def stored(self, w: np.ndarray) -> float:
        """Return the energy that the contact stores; what else it is given it takes.

        In closed form: the power K z^n dz/dt has no polynomial where a wall that let go comes back.
        """
        if self.wall is None:
            return 0.0
        law, z = self.wall.law, max(float(w @ self.model.depth(self.wall)), 0.0)
        return law.K * z ** (law.n + 1.0) / (law.n + 1.0) if law.elastic else law.kc * z * z / 2.0

    def note_miss(self, span: Span, states: np.ndarray, depth: np.ndarray) -> None:
        """Note an approach that turns back: where z has a maximum below zero."""
        rates = span.rates(states) @ depth
        for i in range(1, len(rates)):
            if rates[i - 1] > 0.0 and rates[i] <= 0.0:
                x = root(span, lambda w: -(span.rates(w) @ depth), SAMPLES[i - 1], SAMPLES[i])
                z = float(state(span, x) @ depth)
                if z < 0.0:
                    self.clearance = min(self.clearance, -z)

    def note_limit(self, span: Span, states: np.ndarray, now: float) -> None:
        """Note passages of the limit."""
        if self.model.limit == -math.inf:
            return
        row = -self.model.g
        row[ONE] = self.model.limit
        if not self.beyond:
            x = first_rise(span, row, states)
            if x < math.inf:
                self.passages.append([now + span.time(x), 0.0])
                self.beyond = True
        if self.beyond:
            top = largest(span, states @ row, lambda w: w @ row, self.worst)
            self.worst = top
            self.beyond = bool(state(span, 1.0) @ row > 0.0)


def follow(model: Model, start: Any, periods: int) -> Course:
    """Return the course of an orbit from a state (x1, v1[, x2, v2]), one stop a period."""
    course, at = Course(model), np.asarray(start, float)
    for n in range(periods):
        course.period(at, n, 1)
        at = course.states[-1]
    return course
