"""Error against run time of this package and of those solvers of others that are installed.

    python -m benchmarks.accuracy                        five systems
    python -m benchmarks.accuracy ssul-set6 tmd          some of them
    python -m benchmarks.accuracy --page docs/accuracy.md

Measured are SciPy, and heyoka, diffrax and numbalsoda where they are installed (the extra `peers`).
Each solves equation (5) in x1, v1, x2, v2 and shares no formula with the kernels. `events` means
that every contact is split off at touch and release. The error is that of the state after 20
forcing periods, in m and m/s, against stored digits or a closed form; where neither exists, against
a refinement. The time is the processor's for a forcing period from there on, once all is compiled.
"""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from benchmarks.cases import spent
from nlds_vines import load_system, simulate
from nlds_vines.cli.terminal import table
from nlds_vines.engine.batch import Kernels, Wanted
from nlds_vines.engine.kind_engine import start_state
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.system import Preset
from paper.linear import response, steady_state

PERIODS = 20
LONGEST, OFF = 64, 1e-9  # periods of a timed orbit, and how far off it begins, relative
SHORTEST = 0.05  # [s] of a run that is timed
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
LISTED = TOLERANCES[1:4]  # in the table of settings; costs are interpolated between all
FINEST: dict[str, Any] = {"nodes": 24, "contact_steps": 160.0}
STATES = Path(__file__).parents[1] / "data" / "reference" / "states.json"
STEEL = 2.1e11  # Young's modulus [Pa]
NEAR_GRAZING = 1e-6  # share of the clearance by which the steady state would pass the wall
FAR_AWAY = 1e300  # fictitious time that no contact reaches
RELEASE, MOMENT = -1, -2  # outcomes of heyoka in a contact: its first event, its second


class Case(NamedTuple):
    """An orbit: its system, its start (x1, v1, x2, v2) and its true state after `PERIODS`."""

    name: str
    system: Preset
    start: np.ndarray
    truth: np.ndarray


def cases() -> Iterator[Case]:
    """Yield a soft contact, steel, two walls, a steady state that hardly touches, and no wall."""
    stored = json.loads(STATES.read_text(encoding="utf-8"))["cases"]
    soft = load_system("ssul-set6", omega=6.28)
    for name, key, system in (
        ("ssul-set6", "ssul-set6", soft),
        ("steel", "ssul-set6-steel", soft.with_(E2=STEEL)),
        ("ssbl", "ssbl-omega6.05", load_system("ssbl", omega=6.05)),
    ):
        digits = stored[key]["states"][str(PERIODS)]["y"]
        yield Case(name, system, rest_state(system), np.array([float(text) for text in digits]))
    near = grazing(soft.with_(omega=9.0), -NEAR_GRAZING)
    start = steady_state(near)
    yield Case("near-grazing", near, start, simulate(near, PERIODS, start=start, **FINEST).state)
    tmd = load_system("tmd", omega=6.28)
    yield Case("tmd", tmd, rest_state(tmd), linear_sections(tmd, rest_state(tmd), PERIODS)[-1])


def rest_state(system: Preset) -> np.ndarray:
    """Return the state at rest: (x1, v1, x2, v2), or (x1, v1) without a damper."""
    return np.zeros(2) if system.rest is None else np.array([0.0, 0.0, system.rest, 0.0])


def grazing(system: Preset, shift: float) -> Preset:
    """Return a system whose steady state clears its wall by `shift` of the clearance."""
    amplitude = response(system, np.array([system.parameters["omega"]])).shortening[0]
    return system.with_(C=float(amplitude) * (1.0 + shift))


def linear_sections(
    system: Preset, start: np.ndarray, periods: int, pieces: int = 64
) -> np.ndarray:
    """Return the states at t = T, 2T, ... without contact, by SciPy's matrix exponential.

    Shape (periods, 4), or (periods, 2) without a damper; a period is crossed in `pieces`.
    """
    y = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    y[: len(start)] = start
    rest = np.array([0.0, 0.0, system.rest or 0.0, 0.0])[: len(start)]
    y[: len(start)] -= rest
    piece = expm(flow_matrix(system) * system.period / pieces)
    section = np.empty((periods, len(start)))
    for n in range(periods):
        for _ in range(pieces):
            y = piece @ y
        y[4:] = 1.0, 0.0
        section[n] = y[: len(start)] + rest
    return section


# ---- solvers -------------------------------------------------------------------------------------

Follow = Callable[[float, int], np.ndarray]
"""(setting, forcing periods) -> the state at the end. Raises an exception if the solver fails."""


class Solver(NamedTuple):
    """A way of solving equation (5): `prepare` takes a system and a start."""

    name: str
    setting: str
    settings: Sequence[float]
    prepare: Callable[[Preset, np.ndarray], Follow]
    package: str = "scipy"


@numba.njit(error_model="numpy", cache=True)
def rates_of(p, t, x1, v1, x2, v2):
    """Return the derivatives of x1, v1, x2, v2; `p` as in `Equation`."""
    r = x1 - x2 + p[9]
    pressed, pulled = max(r - p[10], 0.0), max(-r - p[11], 0.0)
    pull = p[4] * r + p[5] * (v1 - v2)
    pull += p[8] * (pressed * math.sqrt(pressed) - pulled * math.sqrt(pulled))
    return v1, (p[6] * math.cos(p[7] * t) - p[1] * x1 - p[2] * v1 - pull) / p[0], v2, pull / p[3]


class Equation:
    """Equation (5) of a system with a damper; absent walls are infinitely far away."""

    def __init__(self, system: Preset) -> None:
        """Collect m1, k1, c1, m2, k2, c2, P, omega, K, the offset at rest and both gaps."""
        cell, walls = system.cells(), system.scene.walls
        names = ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "K", "rest")
        numbers = [float(cell[name]) for name in names]
        numbers += [float(cell[wall]) if wall in walls else math.inf for wall in ("near", "far")]
        self.numbers, self.array = numbers, np.array(numbers)
        self.length = numbers[6] / numbers[1] or 1e-3  # [m] that absolute tolerances refer to

    def rates(self, t: float, y: np.ndarray) -> tuple[float, ...]:
        return rates_of(self.array, t, *y.tolist())

    def depth(self, y: np.ndarray) -> float:
        """Return the depth [m] in the nearer wall, negative if none is touched."""
        rest, near, far = self.numbers[9:]
        r = y[0] - y[2] + rest
        return max(r - near, -r - far)

    def is_closing(self, t: float, y: np.ndarray) -> bool:
        """Return True if a state in a wall or on it begins a contact."""
        rest, near, far = self.numbers[9:]
        r = y[0] - y[2] + rest
        sign = 1.0 if r - near >= -r - far else -1.0
        _, a1, _, a2 = self.rates(t, y)
        motion = (self.depth(y), sign * (y[1] - y[3]), sign * (a1 - a2))
        return next((value > 0.0 for value in motion if value != 0.0), False)


def ours(method: str, system: Preset, start: np.ndarray) -> Follow:
    """Prepare a method of this package.

    Orbits that are timed begin `OFF` the given start and last `LONGEST` periods: the periods of a
    settled motion would repeat to the bit and be copied.
    """
    name = "tolerance" if method == "exact" else "period_steps"
    first = start_state(system, system.cell.rest, start)[:4]

    def follow(setting: float, periods: int) -> np.ndarray:
        settings = chosen_settings(method, {name: setting})
        kernels = Kernels(Wanted(system.scene, ("section",), method, "standard", settings))
        orbits, begin = max(1, periods // LONGEST), (1.0 + OFF * (periods > PERIODS)) * first
        cells, starts = np.full((orbits, 1), system.cells()), np.tile(begin, (orbits, 1))
        sections, status = kernels.states(cells, starts, Span(0, min(periods, LONGEST), 1))
        if status[0, 0] != OK:
            raise ArithmeticError(f"status {status[0, 0]}")
        return np.asarray(sections[0, 0, -1])

    return follow


@numba.njit(error_model="numpy", cache=True)
def runge_kutta(p, h, count, y):
    """Return the state after `count` classical Runge-Kutta steps, which ignore the walls."""
    a, b, c, d = y[0], y[1], y[2], y[3]
    for n in range(count):
        t, g = n * h, 0.5 * h
        ka, kb, kc, kd = rates_of(p, t, a, b, c, d)
        la, lb, lc, ld = rates_of(p, t + g, a + g * ka, b + g * kb, c + g * kc, d + g * kd)
        ma, mb, mc, md = rates_of(p, t + g, a + g * la, b + g * lb, c + g * lc, d + g * ld)
        na, nb, nc, nd = rates_of(p, t + h, a + h * ma, b + h * mb, c + h * mc, d + h * md)
        a += h / 6.0 * (ka + 2.0 * (la + ma) + na)
        b += h / 6.0 * (kb + 2.0 * (lb + mb) + nb)
        c += h / 6.0 * (kc + 2.0 * (lc + mc) + nc)
        d += h / 6.0 * (kd + 2.0 * (ld + md) + nd)
    return np.array([a, b, c, d])


def naive(system: Preset, start: np.ndarray) -> Follow:
    """Prepare the classical Runge-Kutta method with fixed steps, as one writes it first."""
    numbers = Equation(system).array

    def follow(steps: float, periods: int) -> np.ndarray:
        return runge_kutta(numbers, system.period / steps, periods * int(steps), start)

    return follow


def scipy_plain(method: str, system: Preset, start: np.ndarray) -> Follow:
    """Prepare a solver of SciPy, called once, without events."""
    equation = Equation(system)

    def follow(rtol: float, periods: int) -> np.ndarray:
        end, atol = periods * system.period, rtol * equation.length
        run = solve_ivp(equation.rates, (0.0, end), start, method, (end,), rtol=rtol, atol=atol)
        if run.status < 0:
            raise ArithmeticError(run.message)
        return run.y[:, -1]

    return follow


def scipy_orbit(
    system: Preset, start: np.ndarray, rtol: float, periods: int, method: str = "DOP853"
) -> tuple[np.ndarray, list[float]]:
    """Return states at t = T, 2T, ... and times of touch; contacts are split off by events."""
    equation = Equation(system)

    def depth(t: float, y: np.ndarray) -> float:
        return equation.depth(y)

    depth.terminal = True  # type: ignore[attr-defined]  # SciPy's way
    y, touches, section = start, [], np.empty((periods, 4))
    inside = equation.is_closing(0.0, y)
    for n in range(periods):
        t, end = n * system.period, (n + 1) * system.period
        while t < end:
            depth.direction = -1.0 if inside else 1.0  # type: ignore[attr-defined]
            piece = solve_ivp(
                equation.rates, (t, end), y, method, rtol=rtol, atol=rtol * equation.length,
                events=depth,
            )  # fmt: skip
            if piece.status < 0:
                raise ArithmeticError(piece.message)
            t, y = float(piece.t[-1]), piece.y[:, -1]
            if piece.status == 1:
                inside = not inside
                touches += [t] if inside else []
        section[n] = y
    return section, touches


def scipy_events(system: Preset, start: np.ndarray) -> Follow:
    """Prepare SciPy's DOP853, split at each touch and release."""
    return lambda rtol, periods: scipy_orbit(system, start, rtol, periods)[0][-1]


def numbalsoda_plain(method: str, system: Preset, start: np.ndarray) -> Follow:
    """Prepare a solver of numbalsoda, with a compiled right-hand side."""
    import numbalsoda

    data, solve = Equation(system).array, getattr(numbalsoda, method)

    def rates(t, y, dy, numbers):
        p = numba.carray(numbers, (12,))
        dy[0], dy[1], dy[2], dy[3] = rates_of(p, t, y[0], y[1], y[2], y[3])

    compiled = numba.cfunc(numbalsoda.lsoda_sig)(rates)

    def follow(rtol: float, periods: int) -> np.ndarray:
        times = system.period * np.arange(periods + 1)
        states, well = solve(compiled.address, start, times, data, rtol, 1e-3 * rtol, 10**6)
        if not well:
            raise ArithmeticError(f"{method} gave up")
        return states[-1]

    return follow


def diffrax_plain(method: str, system: Preset, start: np.ndarray) -> Follow:
    """Prepare a solver of diffrax: an orbit is one compiled program in double precision."""
    import diffrax
    import jax
    import jax.numpy as jnp

    m1, k1, c1, m2, k2, c2, P, omega, K, rest, near, far = Equation(system).numbers

    def rates(t: Any, y: Any, args: Any) -> Any:
        x1, v1, x2, v2 = y
        r = x1 - x2 + rest
        pull = k2 * r + c2 * (v1 - v2)
        for sign, gap in ((1.0, near), (-1.0, far)):
            if math.isfinite(gap):
                z = jnp.maximum(sign * r - gap, 0.0)
                pull = pull + sign * K * z * jnp.sqrt(z)
        force = P * jnp.cos(omega * t) - k1 * x1 - c1 * v1 - pull
        return jnp.stack([v1, force / m1, v2, pull / m2])

    @partial(jax.jit, static_argnums=1)
    def orbit(rtol: Any, periods: int) -> Any:
        control = diffrax.PIDController(rtol=rtol, atol=1e-3 * rtol)

        def period(y: Any, _: Any) -> Any:
            run = diffrax.diffeqsolve(
                diffrax.ODETerm(rates), getattr(diffrax, method)(), 0.0, system.period, None, y,
                saveat=diffrax.SaveAt(t1=True), stepsize_controller=control, max_steps=10**6,
                adjoint=diffrax.ForwardMode(),
            )  # fmt: skip
            return run.ys[0], None

        return jax.lax.scan(period, jnp.asarray(start), None, length=periods)[0]

    def follow(rtol: float, periods: int) -> np.ndarray:
        with jax.enable_x64(True):
            return np.asarray(orbit(rtol, periods))

    return follow


def heyoka_events(system: Preset, start: np.ndarray) -> Follow:
    """Prepare heyoka's Taylor integrators, one for flight and one for contacts with each wall.

    A Taylor series has no terms for z^1.5 at z = 0. With z = w^2 and dt = 2 w dsigma a contact is
    polynomial: dw/dsigma = dz/dt, and z^1.5 = w^3.
    """
    import heyoka as hk

    m1, k1, c1, m2, k2, c2, P, omega, K, rest, near, far = Equation(system).numbers
    assert Equation(system).depth(start) < 0.0  # it begins with a flight
    gaps = [(s, gap) for s, gap in ((1.0, near), (-1.0, far)) if math.isfinite(gap)]

    def event(zero: Any, direction: str) -> Any:
        return hk.t_event(zero, direction=getattr(hk.event_direction, direction), cooldown=0.0)

    @cache
    def flight(tolerance: float) -> Any:
        x1, v1, x2, v2 = hk.make_vars("x1", "v1", "x2", "v2")
        r = x1 - x2 + rest
        pull = k2 * r + c2 * (v1 - v2)
        force = P * hk.cos(omega * hk.time) - k1 * x1 - c1 * v1 - pull
        rates = [(x1, v1), (v1, force / m1), (x2, v2), (v2, pull / m2)]
        events = [event(s * r - gap, "positive") for s, gap in gaps]
        return hk.taylor_adaptive(rates, [0.0] * 4, tol=tolerance, t_events=events)

    @cache
    def contact(tolerance: float, sign: float, gap: float) -> Any:
        """Make the integrator of x1, v1, w, dz/dt and the time since touch, which is `par[0]`."""
        x1, v1, w, speed, passed = hk.make_vars("x1", "v1", "w", "speed", "passed")
        pull = sign * (k2 * (gap + w * w) + c2 * speed + K * (w * w * w))
        a1 = (P * hk.cos(omega * (passed + hk.par[0])) - k1 * x1 - c1 * v1 - pull) / m1
        rate, a2 = 2.0 * w, pull / m2
        rates = [
            (x1, rate * v1), (v1, rate * a1), (w, speed), (speed, rate * (sign * (a1 - a2))),
            (passed, rate),
        ]  # fmt: skip
        events = [event(w, "negative"), event(passed - hk.par[1], "positive")]
        return hk.taylor_adaptive(rates, [0.0] * 5, pars=[0.0] * 2, tol=tolerance, t_events=events)

    def follow(tolerance: float, periods: int) -> np.ndarray:
        orbit, end = flight(tolerance), periods * system.period
        orbit.time, orbit.state[:] = 0.0, start
        while True:
            outcome = orbit.propagate_until(end)[0]
            if outcome == hk.taylor_outcome.time_limit:
                return orbit.state.copy()
            if not -len(gaps) <= int(outcome) < 0:
                raise ArithmeticError(f"in flight: {outcome}")
            sign, gap = gaps[-1 - int(outcome)]
            inner, t = contact(tolerance, sign, gap), orbit.time
            x1, v1, _, v2 = orbit.state.tolist()
            inner.time, inner.state[:] = 0.0, (x1, v1, 0.0, sign * (v1 - v2), 0.0)
            inner.pars[:] = t, end - t
            outcome = int(inner.propagate_until(FAR_AWAY)[0])
            x1, v1, w, speed, passed = inner.state.tolist()
            orbit.state[:] = x1, v1, x1 + rest - sign * (gap + w * w), v1 - sign * speed
            if outcome == MOMENT:
                return orbit.state.copy()
            if outcome != RELEASE:
                raise ArithmeticError(f"in a contact: {outcome}")
            orbit.time = t + passed

    return follow


SOLVERS = (
    Solver("exact", "tolerance", (1e-4, 1e-6, 1e-8, 1e-9, 1e-11, 1e-12), partial(ours, "exact")),
    Solver("rk4", "steps", (128.0, 512.0, 2048.0), partial(ours, "rk4")),
    Solver("naive RK4", "steps", (4096.0, 65536.0), naive),
    Solver("heyoka Taylor, events", "rtol", (*TOLERANCES, 1e-14), heyoka_events, "heyoka"),
    Solver(
        "numbalsoda DOP853", "rtol", TOLERANCES, partial(numbalsoda_plain, "dop853"), "numbalsoda"
    ),
    Solver(
        "numbalsoda LSODA", "rtol", TOLERANCES, partial(numbalsoda_plain, "lsoda"), "numbalsoda"
    ),
    Solver("diffrax Tsit5", "rtol", TOLERANCES, partial(diffrax_plain, "Tsit5"), "diffrax"),
    Solver("diffrax Dopri8", "rtol", TOLERANCES, partial(diffrax_plain, "Dopri8"), "diffrax"),
    Solver("SciPy DOP853, events", "rtol", TOLERANCES, scipy_events),
    Solver("SciPy DOP853", "rtol", TOLERANCES, partial(scipy_plain, "DOP853")),
    Solver("SciPy LSODA", "rtol", TOLERANCES, partial(scipy_plain, "LSODA")),
    Solver("SciPy Radau", "rtol", TOLERANCES[:4], partial(scipy_plain, "Radau")),
)


# ---- measurement ---------------------------------------------------------------------------------


class Point(NamedTuple):
    """A solver at a setting on a case: error of the last state, CPU time [s] of a period."""

    solver: Solver
    setting: float
    error: float
    seconds: float


def points_of(case: Case, solver: Solver) -> Iterator[Point]:
    """Measure a solver at all its settings; a setting at which it fails has an infinite error."""
    from_start = solver.prepare(case.system, case.start)
    settled = solver.prepare(case.system, case.truth)
    for setting in solver.settings:
        try:
            error = float(np.abs(from_start(setting, PERIODS) - case.truth).max())
            yield Point(solver, setting, error, seconds_of(partial(settled, setting)))
        except ArithmeticError:
            yield Point(solver, setting, math.inf, math.inf)


def seconds_of(follow: Callable[[int], object]) -> float:
    """Return the CPU time [s] of a forcing period, in a run that takes `SHORTEST` or longer.

    Each number of periods is followed once beforehand: what it compiles is compiled then.
    """
    periods = PERIODS
    while True:
        follow(periods)
        seconds = spent(partial(follow, periods))
        if seconds >= SHORTEST:
            return seconds / periods
        periods *= 2 ** math.ceil(math.log2(1.2 * SHORTEST / max(seconds, SHORTEST / 1000)))


def cost(points: Sequence[Point], error: float) -> float:
    """Return the CPU time of an error, interpolated between settings; infinite if out of reach."""
    best: list[tuple[float, float]] = []  # ever smaller errors, by ever longer times
    for point in sorted(points, key=lambda point: point.seconds):
        if math.isfinite(point.error) and (not best or point.error < best[-1][0]):
            best.append((max(point.error, 1e-17), point.seconds))
    if not best or best[-1][0] > error:
        return math.inf
    errors, seconds = np.log(np.array(best)).T
    return float(np.exp(np.interp(-math.log(error), -errors, seconds)))


def words(solver: Solver, setting: float) -> str:
    """Return a setting as the tables name it."""
    if solver.setting == "steps":
        return f"{setting:g} steps"
    default = " (default)" if solver.name == "exact" and setting == 1e-9 else ""
    return f"{solver.setting} {setting:.0e}{default}"


def duration(seconds: float) -> str:
    """Return a time with three digits and its unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def report(names: Sequence[str]) -> Iterator[str]:
    """Yield both tables: settings on the first case, and costs at 1e-9 beside `exact`."""
    solvers = [solver for solver in SOLVERS if find_spec(solver.package)]
    chosen = [case for case in cases() if not names or case.name in names]
    curves = {c.name: {s.name: [*points_of(c, s)] for s in solvers} for c in chosen}
    yield f"{chosen[0].name}: error of the state after {PERIODS} periods."
    yield ""
    rows = [
        (p.solver.name, words(p.solver, p.setting), f"{p.error:.1e}", duration(p.seconds))
        for points in curves[chosen[0].name].values()
        for p in points
        if p.solver.setting != "rtol" or p.setting in LISTED
    ]
    yield from table(("method", "setting", "error", "CPU per period"), rows, right=(2, 3))
    yield ""
    yield "Cost of an error of 1e-9, in units of that of `exact`; blank: no setting reaches it."
    yield ""
    costs = {
        solver.name: [cost(c[solver.name], 1e-9) / cost(c["exact"], 1e-9) for c in curves.values()]
        for solver in solvers
    }
    ratios = (
        (name, *(f"{ratio:.3g}" if math.isfinite(ratio) else "" for ratio in row))
        for name, row in costs.items()
    )
    yield from table(("", *curves), ratios, right=range(1, len(curves) + 1))


def parser_of(description: str | None) -> argparse.ArgumentParser:
    """Return the parser of a command whose tables can be written into a page."""
    parser = argparse.ArgumentParser(description=description)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--page", type=Path, metavar="FILE.md", help="write the tables into it")
    return parser


def publish(command: str, lines: Iterable[str], page: Path | None) -> None:
    """Print lines, and write them between `<!-- COMMAND -->` and `<!-- end -->` of a page, if any.

    Raises `ValueError` unless the page has these marks once.
    """
    body = "".join(f"{line}\n" for line in lines)
    print(body, end="")
    if page is None:
        return
    begin, end = f"<!-- {command} -->\n", "<!-- end -->"
    text = page.read_text(encoding="utf-8")
    if text.count(begin) != 1:
        raise ValueError(f"{page} must have the line {begin.strip()!r} once")
    pattern = re.compile(re.escape(begin) + r".*?" + re.escape(end), re.DOTALL)
    page.write_text(pattern.sub(lambda _: f"{begin}\n{body}\n{end}", text), encoding="utf-8")


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of a case; all by default")
    options = parser.parse_args()
    publish("python -m benchmarks.accuracy", report(options.names), options.page)


if __name__ == "__main__":
    main()
