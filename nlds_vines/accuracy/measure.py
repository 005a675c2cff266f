"""The reference orbit of a system, and error and CPU time of each method at each setting."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from nlds_vines.engine.batch import Kernels, Wanted
from nlds_vines.engine.classification import classify
from nlds_vines.engine.compilation import notice
from nlds_vines.engine.one_orbit import IntegrationError
from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.errors import RequestError
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.system import Preset

EXACT = tuple(float(f"1e-{k}") for k in range(3, 14))  # tolerances, from coarse to fine
RK4 = (64, 128, 256, 512, 1024, 2048, 4096, 8192)  # steps in a forcing period
SCIPY = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # relative tolerances of DOP853
FINEST: dict[str, Any] = {"nodes": 24, "contact_steps": 160.0}  # of `exact`: the reference
CONFIRMING: dict[str, Any] = {"method": "rk4", "period_steps": 16384.0}  # no formula in common
DISTURBANCE = 1e-8  # of the start [m, m/s], whose growth is measured
BELIEVED = 1e-8  # largest distance of reference and confirmation, in units of that growth
SECTION = ("section",)  # the record of all orbits, so that one set of kernels is compiled
REPEATS, SHORTEST, PATIENCE = 5, 0.05, 1.0  # runs to time, and how long they take [s]
BUDGET = 240_000  # evaluations of equation (5) in a forcing period, after which SciPy is stopped

Follow = Callable[[float, int, int], np.ndarray]
"""(setting, forcing periods, repeats) -> the last state of an orbit that starts at rest.

The orbit is computed from its start `repeats` times, for timing.
"""

Methods = Mapping[str, tuple[Sequence[float], Follow]]
"""The settings of each method, from coarse to fine, and the function that follows an orbit."""


class Reference(NamedTuple):
    system: Preset
    periods: int
    label: str  # the regime in which an orbit from rest ends
    state: np.ndarray  # its last state [m, m/s]
    uncertainty: float  # distance of the confirming method's state: the least measurable error
    growth: float  # factor, at least 1, by which a disturbance of the start grows


class Result(NamedTuple):
    method: str
    setting: float
    error: float = math.nan  # of the last state [m, m/s]
    seconds: float = math.nan  # CPU time of a forcing period, the mean over those of that orbit
    failure: str = ""  # why nothing was measured


def methods(system: Preset, peers: bool = True) -> Methods:
    """Return the methods: SciPy's with `peers`, and unless an impact takes no time."""
    walls, laws = system.scene.walls, system.scene.laws
    exact = EXACT if walls else EXACT[-1:]
    ours = {
        "exact": (exact, _ours(system, "exact", "tolerance")),
        "rk4": (RK4, _ours(system, "rk4", "period_steps")),
    }
    if not peers or (walls and any(law.instant for law in laws)):
        return ours
    return {**ours, "SciPy DOP853": (SCIPY, _scipy(system))}


def _ours(system: Preset, method: str, name: str) -> Follow:
    def follow(setting: float, periods: int, repeats: int = 1) -> np.ndarray:
        settings = chosen_settings(method, {name: float(setting)})
        wanted = Wanted(system.scene, SECTION, method, "standard", settings)
        kernels = Kernels(wanted, notice(), helped=False)
        cells, at_rest = np.full((repeats, 1), system.cells()), np.zeros((repeats, 4))
        sections, status = kernels.states(cells, at_rest, Span(0, periods, 1))
        if status[0, 0] != OK:
            raise IntegrationError.of(system, int(status[0, 0]))
        return np.asarray(sections[0, 0, -1])

    return follow


def _scipy(system: Preset) -> Follow:
    """Return SciPy's DOP853 as everybody would use it first: no event at touch or release."""
    right_side, stiffness = equation(system), system.structure[1]
    length = abs(system.force) / stiffness if stiffness else 0.0

    def follow(rtol: float, periods: int, repeats: int = 1) -> np.ndarray:
        left = repeats * periods * BUDGET

        def rates(t: float, y: np.ndarray) -> list[float]:
            nonlocal left
            left -= 1
            if left < 0:
                raise ArithmeticError(f"more than {BUDGET} evaluations a period, t = {t:.6g} s")
            return right_side(t, *y.tolist())

        y, times = rest_of(system), (periods * system.period,)
        atol = rtol * (length or 1e-3)
        for _ in range(repeats):
            with np.errstate(all="ignore"):
                run = solve_ivp(rates, (0.0, *times), y, "DOP853", times, rtol=rtol, atol=atol)
            if run.status < 0:
                raise ArithmeticError(run.message)
        return run.y[:, -1]

    return follow


def rest_of(system: Preset) -> np.ndarray:
    """Return the state at rest: x1, v1, x2, v2, or x, v without a damper."""
    return np.array(system.state_at_rest)


def equation(system: Preset) -> Callable[..., list[float]]:
    """Return the rates of equation (5), written from it alone: no formula of the kernels."""
    scene, cell = system.scene, system.cells()
    names = ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "rest")
    m1, k1, c1, m2, k2, c2, P, omega, rest = (float(cell[name]) for name in names)
    ground = P / m1 if scene.shaken else 0.0  # acceleration of both bodies, relative to it
    load = m1 * float(cell["load"]) if scene.load is not None else 0.0
    walls = [
        (1.0 if wall == "near" else -1.0, float(cell[wall]), scene.law_at(wall).force,
         system.contact(wall))
        for wall in scene.walls
    ]  # fmt: skip

    def contact(r: float, s: float) -> float:
        total = 0.0
        for sign, gap, force, constants in walls:
            if sign * r > gap and force is not None:
                z, rate = np.asarray(sign * r - gap), np.asarray(sign * s)
                total += sign * float(force(constants, z, rate))
        return total

    def with_damper(t: float, x1: float, v1: float, x2: float, v2: float) -> list[float]:
        r, s = x1 - x2 + rest, v1 - v2
        joint = k2 * r + c2 * s + contact(r, s)
        force = P * math.cos(omega * t) + load - k1 * x1 - c1 * v1 - joint
        return [v1, force / m1, v2, joint / m2 + ground * math.cos(omega * t)]

    def alone(t: float, x: float, v: float) -> list[float]:
        return [v, (P * math.cos(omega * t) + load - k1 * x - c1 * v - contact(x, v)) / m1]

    return with_damper if scene.damper else alone


def reference(system: Preset, periods: int) -> Reference:
    """Return the reference orbit of a system, from rest; `RequestError` if there is none.

    In long chaos two methods contradict each other by more than `BELIEVED` times the growth of a
    disturbance, and there is nothing to measure an error against.
    """
    try:
        state = simulate(system, periods, record=SECTION, **FINEST).state
        confirming = simulate(system, periods, record=SECTION, **CONFIRMING).state
        growth = 1.0
        for change in DISTURBANCE * np.eye(len(state)):
            start = rest_of(system) + change
            moved = simulate(system, periods, start=start, record=SECTION, **FINEST).state
            growth = max(growth, float(np.abs(moved - state).max()) / DISTURBANCE)
    except IntegrationError as error:
        raise RequestError(f"{system.name}: there is no reference: {error}") from None
    uncertainty = float(np.abs(state - confirming).max())
    if not uncertainty <= BELIEVED * growth:
        raise RequestError(
            f"{system.name}: exact and rk4 differ by {uncertainty:.1e} after {periods} periods (a "
            f"disturbance grows by {growth:.1e}): there is no reference; measure over fewer periods"
        )
    try:
        label = classify(system, quiet=True).label
    except IntegrationError:
        label = "unknown: it ends later on"
    return Reference(system, periods, label, state, uncertainty, growth)


def measured(truth: Reference, contenders: Methods) -> Iterator[Result]:
    """Yield the results of all methods, each from coarse to fine."""
    for method, (settings, follow) in contenders.items():
        for setting in settings:
            try:
                state = follow(setting, truth.periods, 1)
                error = float(np.abs(state - truth.state).max())
                if not math.isfinite(error):
                    raise ArithmeticError("the state is not finite")
                seconds = seconds_of(follow, setting, truth.periods)
            except (ArithmeticError, ValueError, IntegrationError) as failure:
                yield Result(method, setting, failure=str(failure))
            else:
                yield Result(method, setting, error, seconds)


def seconds_of(follow: Follow, setting: float, periods: int) -> float:
    """Return the CPU time of a forcing period [s]; whatever is compiled is compiled before.

    A short orbit is timed over repeats of its own periods: in a longer one the periods of a
    settled motion would repeat to the bit and be copied.
    """

    def spent(repeats: int) -> float:
        began = time.process_time()
        follow(setting, periods, repeats)
        return time.process_time() - began

    spent(1)
    repeats, first = 1, spent(1)
    if first < SHORTEST:  # spread the cost of a call
        repeats = 2 ** math.ceil(math.log2(min(SHORTEST / max(first, 1e-6), 1e4)))
        first = spent(repeats)
    times = [first, *(spent(repeats) for _ in range(REPEATS if first < PATIENCE else 0))]
    return statistics.median(times) / (repeats * periods)


def advised(results: Sequence[Result], want: float) -> Result | None:
    """Return the cheapest of our settings with an error of at most `want`, if there is one."""
    ours = (r for r in results if r.method in ("exact", "rk4") and r.error <= want)
    return min(ours, key=lambda result: result.seconds, default=None)
