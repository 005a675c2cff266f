"""A slow and readable twin of every kind under every contact law, to judge the package by.

Written from the equations alone (eq. (5), the laws of `docs/dampers.md`), in original variables,
with nothing imported from the package. An orbit is put together of the spans of `twin_spans`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq
from twin_spans import (
    COS,
    ONE,
    SAMPLES,
    SIN,
    V1,
    V2,
    X1,
    Contact,
    Linear,
    Model,
    Span,
    Squeezed,
    Wall,
    first_rise,
    largest,
    root,
    state,
)

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
