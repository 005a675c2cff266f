"""Nonlinear sinks: CPU time and error of a forcing period, with other solvers.

    python -m benchmarks.sinks
    python -m benchmarks.sinks --page docs/springs.md

Orbits begin where this package has settled them for 60 periods. The error is that of the state
after 20 periods beside an 80-bit integrator, `tests/twin_of_sinks.py`, relative to the largest
displacement and velocity. heyoka, where it is installed, and SciPy's DOP853 take the same
equations; heyoka calls Python at each impact. The last column is the time of this package over that
of heyoka at an equal error, interpolated between tolerances: 1e-9, or the least that both reach.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import nlds_vines as nv
from benchmarks.accuracy import SOLVERS, Point, cost, duration, parser_of, publish
from benchmarks.cases import spent
from nlds_vines.cli.terminal import table
from nlds_vines.model.system import General
from tests.twin_of_sinks import Twin, Wall

SETTLE, COMPARED = 60, 20  # periods
ERROR = 1e-9
TOLERANCES = (1e-6, 1e-9, 1e-12)
LISTED = 1e-9  # tolerance of the listed times and errors
REPEATS = 5

Follow = Callable[[int], np.ndarray]
"""periods -> x, then x' at their end."""


def systems() -> dict[str, Any]:
    """Return the sinks by name; the first two are Gendelman's, of a mass ratio of 0.05."""
    spring = nv.Spring(k3=0.05 * 4 / 3)
    frame = nv.shear_frame([1e4] * 5, [8e6 * 25 / 9] * 5, ratio=0.01)
    first = float(frame.frequencies[0])
    m = 1500.0
    sink = nv.Damper(
        "nes", frame.dofs[-1], m=m, c=0.03 * m * first, spring=nv.Spring(k3=m * first**2 / 0.05**2)
    )
    return {
        "cubic, 1:1": on_oscillator(0.2, 0.0, c=0.01, spring=spring),
        "cubic, strongly modulated": on_oscillator(0.35, 0.0, c=0.01, spring=spring),
        "bistable": on_oscillator(0.4, 0.005, k=-0.015, c=0.0025, spring=nv.Spring(k3=0.05)),
        "quintic": on_oscillator(0.4, 0.005, c=0.005, spring=nv.Spring(k5=0.05)),
        "frame of five storeys": nv.System.from_host(
            frame, [sink], force={frame.dofs[-1]: 2000.0}, omega=first
        ),
        "cubic between rigid walls": nv.load_system("nes-vibro-impact-cubic"),
    }


def on_oscillator(amplitude: float, ratio: float, **numbers: Any) -> Any:
    """Return x'' + 2 ratio x' + x = 0.05 amplitude cos t with a sink of 0.05 kg."""
    host = nv.Host([[1.0]], [[1.0]], [[2.0 * ratio]], dofs=["x"])
    sink = nv.Damper("nes", "x", m=0.05, **numbers)
    return nv.System.from_host(host, [sink], force={"x": 0.05 * amplitude}, omega=1.0)


class Equation:
    """M x'' + C x' + K x = F cos(omega t) - w (k2 r^2 + k3 r^3 + k5 r^5) with r = w x."""

    def __init__(self, system: General) -> None:
        host, (damper,) = system.host, system.dampers
        n = len(host.dofs)
        self.size = n + 1
        self.row = np.zeros(n + 1)
        self.row[host.dofs.index(damper.ends[0])] = 1.0
        self.row[n] = -1.0
        self.M, self.C, self.K = np.zeros((3, n + 1, n + 1))
        self.M[:n, :n], self.C[:n, :n], self.K[:n, :n] = host.M, host.C, host.K
        self.M[n, n] = damper.m
        self.C += damper.c * np.outer(self.row, self.row)
        self.K += damper.k * np.outer(self.row, self.row)
        self.F = np.zeros(n + 1)
        for name, force in system.force.items():
            self.F[host.dofs.index(name)] = force
        spring = damper.spring or nv.Spring(k3=0.0)
        self.powers = {2: spring.k2, 3: spring.k3, 5: spring.k5}
        self.walls = damper.walls
        self.omega, self.period = system.omega, system.period
        inverse = np.linalg.inv(self.M)
        self.stiffness, self.damping = inverse @ self.K, inverse @ self.C
        self.push, self.answer = inverse @ self.F, inverse @ self.row
        self.mu = 1.0 / float(self.row @ self.answer)

    def twin(self) -> Twin:
        walls = [
            Wall(0, 1 if wall.side == "+" else -1, wall.gap, wall.law, dict(wall.constants))
            for wall in self.walls
        ]
        coefficients = (self.powers[2], self.powers[3], self.powers[5])
        return Twin(self.M, self.C, self.K, self.F, self.omega, [self.row], [coefficients], walls)


def ours(system: General, start: np.ndarray, tolerance: float) -> Follow:
    interleaved = start.reshape(2, -1).T.ravel()

    def follow(periods: int) -> np.ndarray:
        orbit = nv.simulate(
            system, 1, transient=periods - 1, start=interleaved, tolerance=tolerance,
            record=["section"], quiet=True,
        )  # fmt: skip
        return orbit.state.reshape(-1, 2).T.ravel()

    return follow


def by_scipy(system: General, start: np.ndarray, tolerance: float) -> Follow | None:
    """Prepare DOP853; None beside walls."""
    equation = Equation(system)
    size, row = equation.size, equation.row
    if equation.walls:
        return None

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        r = row @ y[:size]
        force = sum(k * r**n for n, k in equation.powers.items() if k)
        a = equation.push * np.cos(equation.omega * t) - equation.answer * force
        a = a - equation.stiffness @ y[:size] - equation.damping @ y[size:]
        return np.concatenate([y[size:], a])

    def follow(periods: int) -> np.ndarray:
        times = (0.0, periods * equation.period)
        orbit = solve_ivp(rates, times, start, "DOP853", rtol=tolerance, atol=1e-3 * tolerance)
        end: np.ndarray = orbit.y[:, -1]
        return end

    return follow


def by_heyoka(system: General, start: np.ndarray, tolerance: float) -> Follow:
    """Prepare a Taylor integrator; a rigid impact is a terminal event that turns the speed."""
    import heyoka as hk

    equation = Equation(system)
    size, row = equation.size, equation.row
    x = hk.make_vars(*[f"x{i}" for i in range(size)])
    v = hk.make_vars(*[f"v{i}" for i in range(size)])
    r = hk.sum([float(w) * one for w, one in zip(row, x, strict=True) if w])
    square = r * r
    cube = square * r
    monomials = {2: square, 3: cube, 5: square * cube}
    force = hk.sum([float(k) * monomials[n] for n, k in equation.powers.items() if k])
    drive = hk.cos(equation.omega * hk.time)
    rates = [*zip(x, v, strict=True)]
    for i in range(size):
        terms = [-float(k) * one for k, one in zip(equation.stiffness[i], x, strict=True) if k]
        terms += [-float(c) * one for c, one in zip(equation.damping[i], v, strict=True) if c]
        if equation.push[i]:
            terms.append(float(equation.push[i]) * drive)
        if equation.answer[i]:
            terms.append(-float(equation.answer[i]) * force)
        rates.append((v[i], hk.sum(terms)))

    def rebound_by(e: float) -> Callable[..., bool]:
        def rebound(orbit: Any, _: int) -> bool:
            speed = row @ orbit.state[size:]
            orbit.state[size:] -= (1.0 + e) * equation.mu * speed * equation.answer
            return True

        return rebound

    events = []
    for wall in equation.walls:
        sign = 1.0 if wall.side == "+" else -1.0
        callback = rebound_by(wall.constants["e"])
        direction = hk.event_direction.positive
        events.append(
            hk.t_event(sign * r - wall.gap, callback=callback, direction=direction, cooldown=0.0)
        )
    how = {"t_events": events} if events else {}
    orbit = hk.taylor_adaptive(rates, [0.0] * (2 * size), tol=tolerance, **how)

    def follow(periods: int) -> np.ndarray:
        orbit.time, orbit.state[:] = 0.0, start
        orbit.propagate_until(periods * equation.period)
        end: np.ndarray = orbit.state.copy()
        return end

    return follow


def seconds_of(follow: Follow, periods: int) -> float:
    """Return the CPU time [s] of a period, least of `REPEATS`, without that of the call itself."""
    short = periods // 10
    follow(short)
    long_ones, short_ones = [], []
    for _ in range(REPEATS):
        long_ones.append(spent(partial(follow, periods)))
        short_ones.append(spent(partial(follow, short)))
    return (min(long_ones) - min(short_ones)) / (periods - short)


# name: how it is prepared, its package, the periods that are timed, its tolerances
PROGRAMS: dict[str, tuple[Callable[..., Follow | None], str, int, tuple[float, ...]]] = {
    "this package": (ours, "numba", 20000, TOLERANCES),
    "heyoka": (by_heyoka, "heyoka", 2000, TOLERANCES),
    "SciPy DOP853": (by_scipy, "scipy", 10, (LISTED,)),
}


def rows(names: list[str]) -> Iterator[tuple[str, ...]]:
    for title, system in systems().items():
        settled: Any = nv.simulate(system, 1, transient=SETTLE, quiet=True)
        start = settled.state.reshape(-1, 2).T.ravel()
        course = Equation(system).twin().follow(start, COMPARED)
        sizes = np.abs(course.sections.astype(float)).reshape(COMPARED, 2, -1).max(axis=(0, 2))
        scale = np.repeat(sizes, len(start) // 2)
        row = [title, f"{len(course.touches) / COMPARED:.2g}"]
        curves: dict[str, list[Point]] = {}
        for name in names:
            make, _, periods, tolerances = PROGRAMS[name]
            points, cell = [], ""
            for tolerance in tolerances:
                follow = make(system, start, tolerance)
                if follow is None:
                    continue
                error = float(np.abs((follow(COMPARED) - course.sections[-1]) / scale).max())
                seconds = seconds_of(follow, periods)
                points.append(Point(SOLVERS[0], tolerance, error, seconds))
                if tolerance == LISTED:
                    cell = f"{duration(seconds)} ({error:.0e})"
            row.append(cell)
            curves[name] = points
        if "heyoka" in curves:
            pair = [curves["this package"], curves["heyoka"]]
            reached = [min(point.error for point in points) for points in pair]
            mine, other = (cost(points, max(ERROR, *reached)) for points in pair)
            row.append(f"{mine / other:.2f}")
        yield tuple(row)


def report() -> Iterator[str]:
    names = [name for name, one in PROGRAMS.items() if find_spec(one[1])]
    head = ["sink", "impacts per period", *(f"{name} (error)" for name in names)]
    if "heyoka" in names:
        head.append("ratio")
    yield from table(head, rows(names), right=range(1, len(head)))


def main() -> None:
    parser = parser_of(__doc__)
    publish("python -m benchmarks.sinks", report(), parser.parse_args().page)


if __name__ == "__main__":
    main()
