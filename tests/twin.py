"""An independent integrator of equation (5) in 80-bit arithmetic, to judge the package by.

Written from the equations alone, with nothing imported from the package: original variables, the
Taylor series of each motion to order `ORDER`, many orbits (lanes) side by side in arrays of
`numpy.longdouble`. A flight is a series in time. Inside a contact of depth z the force K z^(3/2)
has no series at z = 0; q = sqrt(z) has one in theta, dt = q dtheta, and so has everything else.
Steps are so short that the last term is `LAST` of the whole. In each, all turns of u = x2 - x1 are
located first: between them u is monotone, so that no touch and no passage of a limit is missed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

REAL = np.longdouble
ORDER = 26  # of the Taylor series
LAST = REAL(1e-21)  # share of the last term of a series
SAMPLES = 16  # pieces of a step in which a turn or a peak is looked for
FLAT = 1e-11  # error of the place of a turn or a peak in a step: its height errs by the square
KICK = REAL(1e-8)  # time [1/omega] by which a contact that begins without speed is begun later
MOST_STEPS = 100_000  # of an orbit
PI = 4 * np.arctan(REAL(1))
FLIGHT, LOW, HIGH = 0, 1, 2  # modes: in flight, in contact with a wall
X1, V1, U, W, T = range(5)  # rows of a step: x1, v1, u = x2 - x1, du/dt, time


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


@dataclass
class Course:
    """What the twin saw of one orbit.

    `contacts` has rows wall, touch, release, speed, depth (the release NaN while it lasts; a
    contact that the start lies in has touch = NaN); `misses` rows wall, time, z of approaches that
    turned back at z <= 0.
    """

    section: np.ndarray
    contacts: np.ndarray
    misses: np.ndarray
    E1max: float
    E2max: float

    @property
    def touches(self) -> np.ndarray:
        """The contacts that began with a touch."""
        return self.contacts[~np.isnan(self.contacts[:, 1])]


def model_of(parameters: dict[str, float], watched: bool = False) -> Model:
    """Return the model of parameters with K given, by which of them there are.

    That of an `ssul` damper has V, that of an `ssbl` damper D, that of the others no C. `watched`:
    an `ssvi-b` damper or, where L is given, an `ssvi-c`.
    """
    p = {name: REAL(value) for name, value in parameters.items()}
    zero, inf = REAL(0), REAL(np.inf)
    damper = [p.get("m2", REAL(1)), p.get("k2", zero), p.get("c2", zero)]
    plain = [p["m1"], p["k1"], p["c1"], *damper, p["P"], p["omega"], p.get("K", zero)]
    if "C" not in p:
        return Model(*plain, zero, -inf, inf, zero)
    K_low = zero if watched else plain[-1]
    if "D" in p:
        low = -p["L"] if watched and "L" in p else zero
        return Model(*plain, p["D"], low, p["D"] + p["C"], K_low)
    return Model(*plain, p["V"] + p["C"], p["V"], inf, K_low)


# ---- series --------------------------------------------------------------------------------------


def value(series: np.ndarray, x: Any) -> np.ndarray:
    """Return the value at x of a series of coefficients (ORDER + 1, lanes)."""
    total = np.zeros(np.broadcast_shapes(series[0].shape, np.shape(x)), REAL)
    for c in series[::-1]:
        total = total * x + c
    return total


def derivative(series: np.ndarray) -> np.ndarray:
    """Return the series of the derivative, of the same length."""
    rates = np.zeros_like(series)
    rates[:-1] = series[1:] * np.arange(1, len(series), dtype=REAL)[:, None]
    return rates


def root(function: Any, low: np.ndarray, high: np.ndarray, precise: float = 1e-18) -> np.ndarray:
    """Return where a function of lanes changes sign, within `precise` (Illinois method)."""
    f0, f1 = function(low), function(high)
    roots, done = high, np.zeros(len(high), bool)
    for _ in range(100):
        with np.errstate(invalid="ignore", divide="ignore"):
            x = low + (high - low) * f0 / (f0 - f1)
        x = np.where((x >= low) & (x <= high), x, (low + high) / 2)
        f = function(x)
        roots = np.where(done, roots, x)
        done |= (f == 0) | (np.minimum(x - low, high - x) <= precise)
        if done.all():
            break
        right = (f > 0) == (f1 > 0)
        f0, f1 = np.where(right, f0 / 2, f), np.where(right, f, f1 / 2)
        low, high = np.where(right, low, x), np.where(right, x, high)
    return roots


def flight_series(p: Model, y: np.ndarray) -> np.ndarray:
    """Return the series (5, ORDER + 1, lanes) in time of a flight from (x1, v1, u, w, t)."""
    series = np.zeros((5, ORDER + 1, y.shape[1]), REAL)
    x1, v1, u, w = y[:4]
    u = u - p.rest
    cosine, sine = np.cos(p.omega * y[T]), np.sin(p.omega * y[T])
    for k in range(ORDER + 1):
        series[:4, k] = x1, v1, u, w
        force = -p.k2 * u - p.c2 * w
        a1 = (p.P * cosine - p.k1 * x1 - p.c1 * v1 - force) / p.m1
        n = REAL(k + 1)
        x1, v1, u, w = v1 / n, a1 / n, w / n, (force / p.m2 - a1) / n
        cosine, sine = -p.omega * sine / n, p.omega * cosine / n
    series[U, 0] = y[U]
    series[T, 0], series[T, 1] = y[T], 1
    return series


def contact_series(p: Model, y: np.ndarray, q: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the series (6, ORDER + 1, lanes) in theta inside a contact, the last row q = sqrt(z).

    Depth z = low - u or u - high; s = dz/dt; dq/dtheta = s / 2 and dy/dtheta = q dy/dt.
    """
    lanes = y.shape[1]
    sign = np.where(high, REAL(1), REAL(-1))
    wall, K = np.where(high, p.high, p.low), np.where(high, p.K, p.K_low)
    roots, z = np.zeros((ORDER + 1, lanes), REAL), np.zeros((ORDER + 1, lanes), REAL)
    times = np.zeros((6, ORDER + 1, lanes), REAL)  # of q times: q, v1, a1, ds/dt, cos, sin
    s, x1, t = sign * y[W], y[X1], y[T]
    v1, cosine, sine = y[V1], np.cos(p.omega * t), np.sin(p.omega * t)
    series = np.zeros((6, ORDER + 1, lanes), REAL)
    for k in range(ORDER + 1):
        roots[k] = q
        z[k] = (roots[: k + 1] * roots[k::-1]).sum(0)
        cube = (roots[: k + 1] * z[k::-1]).sum(0)
        u = sign * z[k] + (wall if k == 0 else 0)
        series[:, k] = x1, v1, u, sign * s, t, q
        force = -p.k2 * (u - (p.rest if k == 0 else 0)) - p.c2 * sign * s - sign * K * cube
        a1 = (p.P * cosine - p.k1 * x1 - p.c1 * v1 - force) / p.m1
        times[:, k] = q, v1, a1, sign * (force / p.m2 - a1), cosine, sine
        _, dx, dv, ds, c, d = (times[:, : k + 1] * roots[k::-1]).sum(1) / REAL(k + 1)
        q, s, x1, v1, t = s / REAL(2 * (k + 1)), ds, dx, dv, q / REAL(k + 1)
        cosine, sine = -p.omega * d, p.omega * c
    return series


def length_of(p: Model, series: np.ndarray) -> np.ndarray:
    """Return the length of a step for which the last terms are `LAST` of the whole."""
    lasting = p.P / (p.m1 * p.omega**2) + REAL(1e-300)
    place = np.abs(series[X1, 0]) + np.abs(series[U, 0]) + lasting
    speed = np.abs(series[V1, 0]) + np.abs(series[W, 0]) + p.omega * lasting
    h = np.full(series.shape[2], REAL(np.inf))
    with np.errstate(divide="ignore"):
        for row, scale in ((X1, place), (V1, speed), (U, place), (W, speed)):
            for k in (ORDER - 1, ORDER):
                h = np.minimum(h, (LAST * scale / np.abs(series[row, k])) ** (REAL(1) / k))
        for c in series[T + 1 :]:  # q, where there is one, as exact as it is small
            for k in (ORDER - 1, ORDER):
                by_value = (LAST * np.abs(c[0] / c[k])) ** (REAL(1) / k)
                by_slope = (LAST * np.abs(c[1] / c[k])) ** (REAL(1) / (k - 1))
                h = np.fmin(h, np.fmax(by_value, by_slope))
    return h


# ---- many orbits ---------------------------------------------------------------------------------


@dataclass
class Lanes:
    """Orbits under way, each at its own time, with what is noted of them."""

    p: Model  # of arrays
    y: np.ndarray  # (5, lanes) x1, v1, u, w, and the time in the period
    periods: int
    noting: bool  # near misses, excursions beyond a limit and largest energies, too
    n: np.ndarray = field(init=False)  # periods done
    mode: np.ndarray = field(init=False)
    q: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        lanes = self.y.shape[1]
        p, (_, _, u, _, _) = self.p, self.y
        self.period = 2 * PI / p.omega
        self.n, self.steps = np.zeros((2, lanes), np.int64)
        self.mode = np.where((u < p.low) & (p.K_low > 0), LOW, np.where(u > p.high, HIGH, FLIGHT))
        depth = np.where(self.mode == LOW, p.low - u, u - p.high)
        self.q = np.where(self.mode == FLIGHT, REAL(0), np.sqrt(np.maximum(depth, 0)))
        self.section = np.zeros((lanes, self.periods, 4), REAL)
        self.tops = np.array(energies(p, self.y[:4]))
        self.contacts: list[list[list[Any]]] = [[] for _ in range(lanes)]
        self.misses: list[list[tuple[Any, ...]]] = [[] for _ in range(lanes)]
        self.open = np.full((2, lanes), -1)  # the row of the contact, or excursion, at each wall
        for wall, beyond in ((0, u < p.low), (1, u > p.high)):
            for i in np.flatnonzero(beyond):
                self.begin(i, wall, np.nan, np.nan, abs(u[i] - (p.high[i] if wall else p.low[i])))

    def begin(self, i: int, wall: int, time: Any, speed: Any, depth: Any = 0) -> None:
        """Begin the row of a contact or of an excursion beyond a limit."""
        self.open[wall, i] = len(self.contacts[i])
        self.contacts[i].append([wall, time, np.nan, speed, depth])

    def end(self, i: int, wall: int, time: Any) -> None:
        """Complete that row."""
        self.contacts[i][self.open[wall, i]][2] = time
        self.open[wall, i] = -1

    def deepen(self, i: int, wall: int, depth: Any) -> None:
        """Raise the greatest depth."""
        row = self.contacts[i][self.open[wall, i]]
        row[4] = max(row[4], depth)

    def step(self) -> bool:
        """Take one step of every orbit that is not at its end; tell whether there is one."""
        active = np.flatnonzero(self.n < self.periods)
        self.steps[active] += 1
        flying = self.mode[active] == FLIGHT
        if flying.any():
            self.fly(active[flying])
        if not flying.all():
            self.touch(active[~flying])
        return active.size > 0

    def fly(self, at: np.ndarray) -> None:
        """Take a step of the flights `at`."""
        p, left = Model(*(c[at] for c in self.p)), self.period[at] - self.y[T, at]
        series = flight_series(p, self.y[:, at])
        h = np.minimum(length_of(p, series), left)
        last = h == left
        series *= (h ** np.arange(ORDER + 1)[:, None])[None]
        places, turns = knots_of(series[W])
        u = value(series[U], places)
        # the first touch: u passes a wall between two knots
        end, met = np.ones(len(at), REAL), np.zeros(len(at), np.int64)
        for mode, wall, K, sign in ((LOW, p.low, p.K_low, -1), (HIGH, p.high, p.K, 1)):
            z = sign * (u - wall)
            z[0] = np.minimum(z[0], 0)
            # on the wall, moving or pressed into it
            drive = sign * np.where(series[W, 0] != 0, series[W, 0], series[W, 1])
            at_once = (K > 0) & (z[0] == 0) & (drive > 0)
            into = (z[:-1] <= 0) & (z[1:] > 0) & (K > 0)
            hit = np.flatnonzero(into.any(0) & ~at_once)
            if hit.size:
                first = into[:, hit].argmax(0)

                def excess(x, hit=hit, wall=wall, sign=sign):
                    return sign * (value(series[U][:, hit], x) - wall[hit])

                x = root(excess, places[first, hit], places[first + 1, hit])
                nearer = x < end[hit]
                end[hit[nearer]], met[hit[nearer]] = x[nearer], mode
            end[at_once], met[at_once] = 0, mode
        last &= met == FLIGHT
        y = np.array([value(c, end) for c in series])
        y[T, last] = self.period[at[last]]
        y[U] = np.where(met == LOW, p.low, np.where(met == HIGH, p.high, y[U]))
        if self.noting:
            self.note(at, p, series, places, u, end, turns, FLIGHT)
        self.y[:, at], self.mode[at], self.q[at] = y, met, 0
        for i in np.flatnonzero(met):
            lane = at[i]
            time = self.n[lane] * self.period[lane] + y[T, i]
            self.begin(lane, met[i] - LOW, time, abs(y[W, i]))
            if y[W, i] == 0:
                self.kick(lane)
        self.finish(at[last])

    def kick(self, i: int) -> None:
        """Let a contact begin that is only pressed, not moving: a moment later, by the flight."""
        p = Model(*(c[i : i + 1] for c in self.p))
        y = self.y[:, i : i + 1]
        series, moment = flight_series(p, y), KICK / p.omega
        wall = y[U].copy()
        self.y[:, i] = [value(c, moment)[0] for c in series]
        # without the wall's own size: the depth is what the series adds to it
        series[U, 0] = 0
        depth = np.abs(value(series[U], moment))
        self.y[U, i] = wall[0]
        self.q[i] = np.sqrt(depth)[0]

    def touch(self, at: np.ndarray) -> None:
        """Take a step of the contacts `at`."""
        p, high = Model(*(c[at] for c in self.p)), self.mode[at] == HIGH
        wall = np.where(high, p.high, p.low)
        series = contact_series(p, self.y[:, at], self.q[at], high)
        h = length_of(p, series)
        series *= (h ** np.arange(ORDER + 1)[:, None])[None]
        end, released = np.ones(len(at), REAL), np.zeros(len(at), bool)
        grid = np.linspace(REAL(0), REAL(1), SAMPLES + 1)[:, None] * np.ones(len(at), REAL)
        q = value(series[T + 1], grid)
        out = q[1:] <= 0
        free = np.flatnonzero(out.any(0))
        if free.size:
            first = out[:, free].argmax(0)
            low, high_end = grid[first, free], grid[first + 1, free]
            # at a touch q is zero too: the other root is that of q / theta
            touching = q[0, free] == 0
            s = np.where(touching, series[T + 1][1:, free], series[T + 1][:-1, free])
            end[free] = root(lambda x: value(s, x), low, high_end)
            released[free] = True
        t = value(series[T], end)
        late = np.flatnonzero(t >= self.period[at])
        if late.size:
            over = self.period[at[late]]
            end[late] = root(
                lambda x: value(series[T][:, late], x) - over, np.zeros(late.size, REAL), end[late]
            )
            released[late] = False
        y, q = np.array([value(c, end) for c in series[:5]]), value(series[T + 1], end)
        y[T, late] = self.period[at[late]]
        y[U] = np.where(released, wall, y[U])
        scaled = series * (end ** np.arange(ORDER + 1)[:, None])[None]
        places, turns = knots_of(scaled[W])
        u = value(scaled[U], places)
        # in a contact u turns where it is deepest
        for k, i in zip(*np.nonzero(turns), strict=True):
            if (u[k, i] > u[k - 1, i]) == high[i]:
                self.deepen(at[i], self.mode[at[i]] - LOW, abs(u[k, i] - wall[i]))
        if self.noting:
            self.note(at, p, scaled, places, u, np.ones(len(at), REAL), turns, self.mode[at])
        self.y[:, at], self.q[at] = y, np.where(released, 0, q)
        for i in np.flatnonzero(released):
            lane = at[i]
            time = self.n[lane] * self.period[lane] + y[T, i]
            self.end(lane, self.mode[lane] - LOW, time)
            self.mode[lane] = FLIGHT
        self.finish(at[late])

    def note(self, at, p, series, places, u, end, turns, mode) -> None:
        """Note near misses, excursions beyond a limit and energies of a step up to `end`.

        A wall that pushes is missed in flight alone, one that does not push in contacts, too.
        """
        mode = np.broadcast_to(mode, at.shape)
        time = self.n[at] * self.period[at]
        for k, i in zip(*np.nonzero(turns & (places <= end)), strict=True):
            wall = int(u[k, i] > u[k - 1, i])
            z = u[k, i] - p.high[i] if wall else p.low[i] - u[k, i]
            ghost = wall == 0 and p.K_low[i] == 0
            if np.isfinite(z) and z <= 0 and (ghost or mode[i] == FLIGHT):
                moment = time[i] + value(series[T][:, i : i + 1], places[k, i])[0]
                self.misses[at[i]].append((wall, moment, z))
        self.watch(at, p, series, places, u, end, time)
        self.note_energies(at, p, series, end)

    def watch(self, at, p, series, places, u, end, time) -> None:
        """Note excursions below a low wall that does not push."""
        ghosts = np.isfinite(p.low) & (p.K_low == 0)
        if not ghosts.any():
            return
        x = np.minimum(places, end)
        z = p.low - np.where(places <= end, u, value(series[U], end))
        for i in np.flatnonzero(ghosts & ((z > 0).any(0) | (self.open[0, at] >= 0))):
            lane = at[i]
            for k in range(1, len(x)):
                beyond = self.open[0, lane] >= 0
                if z[k, i] > 0 or beyond:
                    crossing = (z[k, i] > 0) != beyond
                    if crossing:
                        c = series[:, :, i : i + 1]
                        place = x[k, i : i + 1]
                        if (z[k - 1, i] > 0) != (z[k, i] > 0):

                            def excess(g, c=c, level=p.low[i]):
                                return level - value(c[U], g)

                            place = root(excess, x[k - 1, i : i + 1], place)
                        moment = time[i] + value(c[T], place)[0]
                        if beyond:
                            self.end(lane, 0, moment)
                        else:
                            self.begin(lane, 0, moment, -value(c[W], place)[0])
                    if z[k, i] > 0:
                        self.deepen(lane, 0, z[k, i])

    def note_energies(self, at, p, series, end) -> None:
        y = series[:4] * (end ** np.arange(ORDER + 1)[:, None])[None]
        grid = np.linspace(REAL(0), REAL(1), SAMPLES + 1)[:, None]
        states = np.array([value(c, grid) for c in y])
        rates = np.array([derivative(c) for c in y])
        slopes = np.array([value(c, grid) for c in rates])
        levels, powers = energies(p, states), powers_of(p, states, slopes)
        for body in range(2):
            e, d = levels[body], powers[body]
            top = e.max(0)
            may = (d[:-1] > 0) & (d[1:] < 0)
            rise = (d[:-1] - d[1:]) / SAMPLES  # twice what a power that falls on a line gives
            may &= e[:-1] + rise > self.tops[body, at]
            k, i = np.nonzero(may)
            if k.size:
                lane, here, rate = Model(*(c[i] for c in p)), y[:, :, i], rates[:, :, i]

                def power(x, lane=lane, here=here, rate=rate, body=body):
                    return powers_of(lane, at_place(here, x), at_place(rate, x))[body]

                x = root(power, grid[k, 0], grid[k + 1, 0], FLAT)
                np.maximum.at(top, i, energies(lane, at_place(here, x))[body])
            self.tops[body, at] = np.maximum(self.tops[body, at], top)

    def finish(self, at: np.ndarray) -> None:
        """Note the section of orbits at the end of a period, and begin the next."""
        x1, v1, u, w, _ = self.y[:, at]
        self.section[at, self.n[at]] = np.array([x1, v1, x1 + u, v1 + w]).T
        self.n[at] += 1
        self.y[T, at] = 0

    def course(self, i: int) -> Course:
        """Return the course of one orbit, as doubles."""
        contacts = np.array(self.contacts[i], float).reshape(-1, 5)
        misses = np.array(self.misses[i], float).reshape(-1, 3)
        tops = (float(top) for top in self.tops[:, i])
        return Course(self.section[i].astype(float), contacts, misses, *tops)


def at_place(series: np.ndarray, x: Any) -> np.ndarray:
    """Return the state at a place of a step."""
    return np.array([value(c, x) for c in series])


def knots_of(rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places of a step between which u, of this `rate`, is monotone, and which are turns."""
    lanes = rate.shape[1]
    grid = np.linspace(REAL(0), REAL(1), SAMPLES + 1)[:, None] * np.ones(lanes, REAL)
    w = value(rate, grid)
    turns = np.zeros((len(grid) * 2 - 1, lanes), bool)
    places = np.repeat(grid, 2, axis=0)[: len(turns)]
    change = ((w[:-1] > 0) & (w[1:] <= 0)) | ((w[:-1] < 0) & (w[1:] >= 0))
    k, i = np.nonzero(change)
    if k.size:
        series = rate[:, i]
        places[2 * k + 1, i] = root(lambda x: value(series, x), grid[k, i], grid[k + 1, i], FLAT)
        turns[2 * k + 1, i] = True
    return places, turns


def energies(p: Model, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return E1 and E2 [J] of equation (6)."""
    x1, v1, u, w = y
    x2, v2 = x1 + u - p.rest, v1 + w
    return (p.m1 * v1**2 + p.k1 * x1**2) / 2, (p.m2 * v2**2 + p.k2 * x2**2) / 2


def powers_of(p: Model, y: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of E1 and E2 by the place in a step."""
    x1, v1, u, w = y
    dx, dv, du, dw = rate
    x2, v2 = x1 + u - p.rest, v1 + w
    return p.m1 * v1 * dv + p.k1 * x1 * dx, p.m2 * v2 * (dv + dw) + p.k2 * x2 * (dx + du)


def lanes_of(models: Any, starts: Any, periods: int, noting: bool = True) -> Lanes:
    """Follow many orbits from (x1, v1, x2, v2) at t = 0 for some forcing periods."""
    p = Model(*(np.array(column, REAL) for column in zip(*models, strict=True)))
    x1, v1, x2, v2 = np.array(starts, REAL).T
    y = np.array([x1, v1, x2 - x1, v2 - v1, np.zeros_like(x1)])
    lanes = Lanes(p, y, periods, noting)
    while lanes.step():
        assert lanes.steps.max() < MOST_STEPS
    return lanes


def follow_all(models: Any, starts: Any, periods: int) -> list[Course]:
    """Return the courses of many orbits (see `lanes_of`)."""
    lanes = lanes_of(models, starts, periods)
    return [lanes.course(i) for i in range(len(lanes.n))]


def follow(p: Model, start: Any, periods: int) -> Course:
    """Return the course of one orbit."""
    return follow_all([p], [start], periods)[0]
