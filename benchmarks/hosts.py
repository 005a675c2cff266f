"""Frames of 1 to 20 storeys with a damper on the roof: CPU time of a period, and other solvers.

    python -m benchmarks.hosts
    python -m benchmarks.hosts --page docs/hosts.md

A flight has a wall that is never touched; the other orbits have one short Hertz impact per period.
SciPy's DOP853 stops at each touch and release; heyoka, where it is installed, does so too and
integrates contacts in a variable in which they are polynomial. All begin near the settled orbit.
The times are those of an error of 1e-8, interpolated between tolerances: that of the state after 20
periods beside this package at 1e-13, relative to the largest displacement and velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import nlds_vines as nv
from benchmarks.accuracy import SOLVERS, Point, cost, duration, parser_of, publish
from benchmarks.cases import HERTZ, NEAR, frame_of, spent
from nlds_vines.cli.terminal import table
from nlds_vines.model.system import General

STOREYS = (1, 5, 10, 20)
TOLERANCES, FINEST, ERROR = (1e-6, 1e-8, 1e-10, 1e-12), 1e-13, 1e-8
SETTLE, COMPARED = 400, 20  # periods
REPEATS = 3
STIFFNESS = HERTZ["K"]  # of the contact [N/m^1.5]
FAR = 50.0  # gap over the amplitude of the roof alone, of a wall that is never touched

Follow = Callable[[float, int], np.ndarray]
"""(tolerance, periods) -> the state x1, x2 ..., of the damper, v1, v2 ... at their end."""


class Equation:
    """M x'' + C x' + K x = F cos(omega t) - w f, with r = w x and f the force of the wall."""

    def __init__(self, system: General) -> None:
        host, damper = system.host, system.dampers[0]
        n = len(host.dofs)
        row = np.zeros(n + 1)
        row[n - 1], row[n] = 1.0, -1.0
        M, K, C = (np.zeros((n + 1, n + 1)) for _ in range(3))
        M[:n, :n], K[:n, :n], C[:n, :n] = host.M, host.K, host.C
        M[n, n] = damper.m
        K += damper.k * np.outer(row, row)
        C += damper.c * np.outer(row, row)
        self.size, self.row, self.inverse = n + 1, row, 1.0 / np.diag(M)
        self.stiffness, self.damping = self.inverse[:, None] * K, self.inverse[:, None] * C
        self.push = self.inverse * np.append(np.zeros(n - 1), [system.force["roof"], 0.0])
        self.answer = self.inverse * row
        self.gap, self.omega, self.period = damper.walls[0].gap, system.omega, system.period


def ours(system: General, start: np.ndarray) -> Follow:
    def follow(tolerance: float, periods: int) -> np.ndarray:
        orbit = nv.simulate(
            system, 1, transient=periods - 1, start=start.reshape(2, -1).T.ravel(),
            tolerance=tolerance, record=["section"], quiet=True,
        )  # fmt: skip
        return orbit.state.reshape(-1, 2).T.ravel()

    return follow


def by_scipy(system: General, start: np.ndarray) -> Follow:
    equation = Equation(system)
    size, row = equation.size, equation.row

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        z = max(row @ y[:size] - equation.gap, 0.0)
        a = equation.push * np.cos(equation.omega * t) - equation.answer * (STIFFNESS * z**1.5)
        return np.concatenate(
            [y[size:], a - equation.stiffness @ y[:size] - equation.damping @ y[size:]]
        )

    def distance(t: float, y: np.ndarray) -> float:
        return float(row @ y[:size] - equation.gap)

    distance.terminal = True  # type: ignore[attr-defined]  # SciPy's way

    def follow(rtol: float, periods: int) -> np.ndarray:
        t, y, end, inside = 0.0, start, periods * equation.period, False
        while t < end:
            distance.direction = -1.0 if inside else 1.0  # type: ignore[attr-defined]
            piece = solve_ivp(
                rates, (t, end), y, "DOP853", rtol=rtol, atol=1e-3 * rtol, events=distance
            )
            t, y = float(piece.t[-1]), piece.y[:, -1]
            inside ^= piece.status == 1
        return y

    return follow


def by_heyoka(system: General, start: np.ndarray) -> Follow:
    """Prepare two Taylor integrators; in contact z = w^2 and dt = 2 w dsigma."""
    import heyoka as hk

    equation = Equation(system)
    size, n = equation.size, equation.size - 1
    assert equation.row @ start[:size] < equation.gap  # it begins with a flight

    def event(zero: Any, direction: str) -> Any:
        return hk.t_event(zero, direction=getattr(hk.event_direction, direction), cooldown=0.0)

    def accelerations(x: list[Any], v: list[Any], time: Any) -> list[Any]:
        drive = hk.cos(equation.omega * time)
        rows = zip(equation.stiffness, equation.damping, equation.push, strict=True)
        return [
            hk.sum([
                *([float(push) * drive] if push else []),
                *(-float(k) * one for k, one in zip(K, x, strict=True) if k),
                *(-float(c) * one for c, one in zip(C, v, strict=True) if c),
            ])
            for K, C, push in rows
        ]  # fmt: skip

    @cache
    def flight(rtol: float) -> Any:
        x = hk.make_vars(*[f"x{i}" for i in range(size)])
        v = hk.make_vars(*[f"v{i}" for i in range(size)])
        rates = [*zip(x, v, strict=True), *zip(v, accelerations(x, v, hk.time), strict=True)]
        events = [event(x[n - 1] - x[n] - equation.gap, "positive")]
        return hk.taylor_adaptive(rates, [0.0] * (2 * size), tol=rtol, t_events=events)

    @cache
    def contact(rtol: float) -> Any:
        x, v = ([hk.make_vars(f"{name}{i}") for i in range(n)] for name in "xv")
        w, speed, passed = hk.make_vars("w", "speed", "passed")
        places, speeds = [*x, x[-1] - equation.gap - w * w], [*v, v[-1] - speed]
        a = accelerations(places, speeds, passed + hk.par[0])
        push = STIFFNESS * (w * w * w)
        a = [one - float(b) * push if b else one for one, b in zip(a, equation.answer, strict=True)]
        rate = 2.0 * w
        rates = [(one, rate * two) for one, two in zip([*x, *v], [*v, *a[:-1]], strict=True)]
        rates += [(w, speed), (speed, rate * (a[n - 1] - a[n])), (passed, rate)]
        events = [event(w, "negative"), event(passed - hk.par[1], "positive")]
        return hk.taylor_adaptive(
            rates, [0.0] * (2 * n + 3), pars=[0.0] * 2, tol=rtol, t_events=events
        )

    def follow(rtol: float, periods: int) -> np.ndarray:
        orbit, end = flight(rtol), periods * equation.period
        orbit.time, orbit.state[:] = 0.0, start
        while orbit.propagate_until(end)[0] != hk.taylor_outcome.time_limit:
            inner, t, y = contact(rtol), orbit.time, orbit.state.copy()
            inner.time = 0.0
            inner.state[:] = [*y[:n], *y[size:-1], 0.0, y[-2] - y[-1], 0.0]
            inner.pars[:] = t, end - t
            inner.propagate_until(1e300)
            x, v, (w, speed, passed) = np.split(inner.state, [n, 2 * n])
            orbit.state[:] = [*x, x[-1] - equation.gap - w * w, *v, v[-1] - speed]
            orbit.time = t + passed
            if passed >= end - t:
                break
        return orbit.state.copy()

    return follow


def seconds_of(follow: Callable[[int], object], periods: int) -> float:
    """Return the CPU time [s] of a period, least of `REPEATS`, without that of the call itself."""
    short = periods // 10
    follow(short)
    times = [spent(partial(follow, n)) for _ in range(REPEATS) for n in (periods, short)]
    return (min(times[::2]) - min(times[1::2])) / (periods - short)


# name: how it is prepared, its package, the periods that are timed
PROGRAMS = {
    "this package": (ours, "numba", 20000),
    "SciPy DOP853": (by_scipy, "scipy", 10),
    "heyoka": (by_heyoka, "heyoka", 200),
}


def rows(programs: list[tuple[Callable[..., Follow], str, int]]) -> Iterator[tuple[str, ...]]:
    for storeys in STOREYS:
        for gap in (FAR, NEAR):
            system = frame_of(storeys, gap)
            settled: Any = nv.simulate(system, COMPARED, transient=SETTLE, quiet=True)
            largest = np.abs(settled.section).reshape(COMPARED, -1, 2).max(axis=(0, 1))
            start = (1 + 1e-6) * settled.state.reshape(-1, 2).T.ravel()
            truth = ours(system, start)(FINEST, COMPARED)
            row = [
                str(storeys),
                f"{system.host.frequencies[-1] / system.omega:.1f}",
                f"{len(settled.impacts) / COMPARED:g}",
            ]
            for make, _, periods in programs:
                follow, points = make(system, start), []
                for rtol in TOLERANCES:
                    errors = (follow(rtol, COMPARED) - truth) / largest.repeat(storeys + 1)
                    seconds = seconds_of(partial(follow, rtol), periods)
                    points.append(Point(SOLVERS[0], rtol, float(np.abs(errors).max()), seconds))
                row.append(duration(cost(points, ERROR)))
            yield tuple(row)


def report() -> Iterator[str]:
    programs = {name: one for name, one in PROGRAMS.items() if find_spec(one[1])}
    head = ("storeys", "top mode / force", "impacts per period", *programs)
    yield from table(head, rows([*programs.values()]), right=range(len(head)))


def main() -> None:
    parser = parser_of(__doc__)
    publish("python -m benchmarks.hosts", report(), parser.parse_args().page)


if __name__ == "__main__":
    main()
