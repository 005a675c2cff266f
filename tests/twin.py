"""A deliberately plain integrator of equation (5), to judge the package by: no code in common.

Original variables, classical Runge-Kutta steps in time, every sign looked at in every step. Where
the distance to a wall or the spring's rate changes sign within a step, the step is halved until
nothing happens in it but at its very end; inside a contact it is also kept far below the Hertz
time scale. Slow, and wrong nowhere by more than a step's error.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

SHORTEST = 1.0e-10  # step [s] at which a touch, a release or a turn counts as located
STEPS = 2048  # of a period in flight
WITHIN = 160  # of a free impact


class Model(NamedTuple):
    """Parameters of equation (5): walls push while u = x2 - x1 lies below `low`, above `high`.

    With `K_low` = 0 the low wall does not push: what is seen there are violations of a limit.
    """

    m1: float
    k1: float
    c1: float
    m2: float
    k2: float
    c2: float
    P: float
    omega: float
    K: float
    rest: float
    low: float
    high: float
    K_low: float


@dataclass(frozen=True)
class Course:
    """What the twin saw.

    `contacts` has rows wall, touch, release, speed, depth (the release NaN while it lasts; a
    contact that the start lies in has touch = NaN); `misses` rows wall, time, z of approaches that
    turned back at z <= 0.
    """

    section: np.ndarray
    contacts: np.ndarray
    misses: np.ndarray
    E1max: float
    E2max: float
    E1max_inside: float  # the same, inside contacts alone
    E2max_inside: float
    energy: np.ndarray  # mechanical energy [J] at the sections, contact included

    @property
    def touches(self) -> np.ndarray:
        """The contacts that began with a touch."""
        return self.contacts[~np.isnan(self.contacts[:, 1])]


def model_of(parameters: dict[str, float], watched: bool = False) -> Model:
    """Return the model of an `ssul` (or, where D is given, an `ssbl`) damper with K given.

    `watched`: of an `ssvi-b` damper (or, where L is given, an `ssvi-c`).
    """
    p = parameters
    plain = [float(p[name]) for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "K")]
    K_low = 0.0 if watched else plain[-1]
    if "D" in p:
        low = -float(p["L"]) if watched and "L" in p else 0.0
        return Model(*plain, float(p["D"]), low, float(p["D"] + p["C"]), K_low)
    return Model(*plain, float(p["V"] + p["C"]), float(p["V"]), inf, K_low)


@njit(cache=True)
def slopes(p, t, y):
    x1, v1, x2, v2 = y
    u = x2 - x1
    force = -p.k2 * (u - p.rest) - p.c2 * (v2 - v1)
    if u < p.low:
        force += p.K_low * (p.low - u) * sqrt(p.low - u)
    if u > p.high:
        force -= p.K * (u - p.high) * sqrt(u - p.high)
    a1 = (p.P * cos(p.omega * t) - p.k1 * x1 - p.c1 * v1 - force) / p.m1
    return v1, a1, v2, force / p.m2


@njit(cache=True)
def moved(y, h, d):
    return y[0] + h * d[0], y[1] + h * d[1], y[2] + h * d[2], y[3] + h * d[3]


@njit(cache=True)
def stepped(p, t, h, y):
    a = slopes(p, t, y)
    b = slopes(p, t + 0.5 * h, moved(y, 0.5 * h, a))
    c = slopes(p, t + 0.5 * h, moved(y, 0.5 * h, b))
    d = slopes(p, t + h, moved(y, h, c))
    w = h / 6.0
    return (
        y[0] + w * (a[0] + 2.0 * (b[0] + c[0]) + d[0]),
        y[1] + w * (a[1] + 2.0 * (b[1] + c[1]) + d[1]),
        y[2] + w * (a[2] + 2.0 * (b[2] + c[2]) + d[2]),
        y[3] + w * (a[3] + 2.0 * (b[3] + c[3]) + d[3]),
    )


@njit(cache=True)
def depth_of(p, y):
    """Return the depths z at the low and the high wall, negative where there is no contact."""
    u = y[2] - y[0]
    return p.low - u, u - p.high


@njit(cache=True)
def eventful(p, y, w):
    """Tell whether a wall is crossed or the spring turns between two states."""
    a, b = depth_of(p, y)
    c, d = depth_of(p, w)
    turn = (y[1] - y[3] > 0.0) != (w[1] - w[3] > 0.0)
    return turn or (a > 0.0) != (c > 0.0) or (b > 0.0) != (d > 0.0)


@njit(cache=True)
def patience(p, y, within):
    """Return the longest step [s] allowed inside a contact.

    A fraction of the Hertz time scale, and of the time that the wall is away: z^(3/2) is not
    smooth there, and only steps that shrink towards it keep their order.
    """
    low, high = depth_of(p, y)
    z, K = (low, p.K_low) if low > high else (high, p.K)
    if z <= 0.0 or K == 0.0:
        return inf
    kappa = K * (1.0 / p.m1 + 1.0 / p.m2)
    speed = abs(y[1] - y[3])
    square = speed * speed + 0.8 * kappa * z * z * sqrt(z)
    hertz = 2.94 * (1.25 * square / kappa) ** 0.4 / sqrt(square)
    return min(hertz / within, SHORTEST + (0.2 * z / speed if speed > 0.0 else inf))


@njit(cache=True)
def energies(p, y):
    """Return E1, E2 of equation (6) and the whole mechanical energy [J]."""
    e1 = 0.5 * (p.m1 * y[1] ** 2 + p.k1 * y[0] ** 2)
    kinetic2 = 0.5 * p.m2 * y[3] ** 2
    e2 = kinetic2 + 0.5 * p.k2 * (y[2] - p.rest) ** 2
    whole = e1 + kinetic2 + 0.5 * p.k2 * (y[2] - y[0] - p.rest) ** 2
    low, high = depth_of(p, y)
    for z, K in ((low, p.K_low), (high, p.K)):
        if z > 0.0:
            whole += 0.4 * K * z * z * sqrt(z)
    return e1, e2, whole


@njit(cache=True)
def note(p, t, y, w, contacts, misses, filled):
    """Write down what happened at a wall between two states that lie close together."""
    zs, ws = depth_of(p, y), depth_of(p, w)
    for wall in range(2):
        toward = w[1] - w[3] if wall == 0 else w[3] - w[1]
        before = y[1] - y[3] if wall == 0 else y[3] - y[1]
        if ws[wall] > 0.0 and zs[wall] <= 0.0:
            row = contacts[filled[0]]
            row[0], row[1], row[2], row[3] = wall, t, np.nan, toward
            filled[0] += 1
        if ws[wall] > 0.0:
            contacts[filled[0] - 1, 4] = max(contacts[filled[0] - 1, 4], ws[wall])
        if ws[wall] <= 0.0 and zs[wall] > 0.0:
            contacts[filled[0] - 1, 2] = t
        apart = -inf < ws[wall] <= 0.0 and zs[wall] <= 0.0  # from a wall that exists
        if apart and before > 0.0 and toward <= 0.0:
            row = misses[filled[1]]
            row[0], row[1], row[2] = wall, t, ws[wall]
            filled[1] += 1


@njit(cache=True)
def pursue(p, y, periods, steps, within, section, energy, tops, contacts, misses, filled):
    period = 2.0 * pi / p.omega
    longest = period / steps
    for n in range(periods):
        t, h = 0.0, longest
        while t < period:
            h = min(h, longest, patience(p, y, within), period - t)
            w = stepped(p, n * period + t, h, y)
            if h > SHORTEST and eventful(p, y, w):
                h *= 0.5
                continue
            if eventful(p, y, w):
                if filled[0] == len(contacts) or filled[1] == len(misses):
                    return False
                note(p, n * period + t + h, y, w, contacts, misses, filled)
            elif filled[0] > 0 and max(depth_of(p, w)) > contacts[filled[0] - 1, 4]:
                contacts[filled[0] - 1, 4] = max(depth_of(p, w))
            t = period if h == period - t else t + h
            y = w
            e1, e2, whole = energies(p, y)
            tops[0], tops[1] = max(tops[0], e1), max(tops[1], e2)
            if max(depth_of(p, y)) > 0.0:
                tops[2], tops[3] = max(tops[2], e1), max(tops[3], e2)
            h *= 2.0
        section[n, 0], section[n, 1], section[n, 2], section[n, 3] = y[0], y[1], y[2], y[3]
        energy[n] = whole
    return True


def follow(
    p: Model, start, periods: int, *, steps: int = STEPS, within: int = WITHIN, most: int = 2000
) -> Course:
    """Follow an orbit from (x1, v1, x2, v2) at t = 0 for some forcing periods."""
    y = tuple(float(value) for value in start)
    section, energy = np.empty((periods, 4)), np.empty(periods)
    tops = np.array([*energies(p, y)[:2], 0.0, 0.0])
    contacts, misses = np.zeros((most, 5)), np.zeros((most, 3))
    filled = np.zeros(2, np.int64)
    depths = depth_of(p, y)
    if max(depths) > 0.0:
        contacts[0] = (0 if depths[0] > 0.0 else 1, np.nan, np.nan, np.nan, max(depths))
        filled[0] = 1
    assert pursue(p, y, periods, steps, within, section, energy, tops, contacts, misses, filled)
    return Course(section, contacts[: filled[0]], misses[: filled[1]], *tops, energy)
