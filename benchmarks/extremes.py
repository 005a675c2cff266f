"""Ten extremes: how far the program is from the truth where numbers are extreme, and its bound.

    python -m benchmarks.extremes
    python -m benchmarks.extremes --page docs/accuracy.md

Each function measures one number, the same in every run, against a closed form, SciPy, a law of
nature, or another run in other units. A count of errors has the bound 0. Errors of states are
relative to the size of the motion. NaN passes no bound.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import beta

from benchmarks.accuracy import grazing as clear_by
from benchmarks.accuracy import linear_sections, parser_of, publish, rest_state, scipy_orbit
from nlds_vines import load_system, simulate
from nlds_vines.cli.terminal import table
from nlds_vines.engine.one_orbit import IntegrationError
from nlds_vines.model.system import Preset
from paper.linear import response, steady_state

BOTH = ("section", "impacts")
FULL = (*BOTH, "energy", "clearance")
METHODS: dict[str, dict[str, Any]] = {
    "exact": {"method": "exact"},
    "rk4": {"method": "rk4", "period_steps": 4096.0},
}
DURATION = 0.8 * float(beta(0.4, 0.5))
"""Duration of a free Hertz impact in units of depth / approach speed: 2.9433."""
SCIPY_TOLERANCE = 3e-14  # DOP853 takes 2.2e-14 and more without a warning


def error_of(states: Any, truth: Any, offset: float = 0.0, like: Any = None) -> float:
    """Return the largest error of states (..., 4), positions and speeds each by their own scale.

    The scales are those of `like`, by default of `truth`; `offset` is subtracted from x2 first,
    as what does not move is no scale. Infinite if the error is NaN.
    """
    moving = np.atleast_2d(truth if like is None else like).copy()
    moving[:, 2:3] -= offset
    scales = [np.abs(moving[:, i::2]).max() for i in (0, 1)]
    wrong = np.abs(np.atleast_2d(states) - np.atleast_2d(truth))
    error = float(np.max([wrong[:, i::2].max() / scale for i, scale in enumerate(scales)]))
    return math.inf if math.isnan(error) else error


def energy_of(system: Preset, states: Any) -> np.ndarray:
    """Return the mechanical energy [J] of states (..., 4), with (2/5) K z^(5/2) of each wall."""
    p, cell = system.parameters, system.cells()
    x1, v1, x2, v2 = np.moveaxis(np.asarray(states), -1, 0)
    r = x1 - x2 + system.rest
    energy = (p["m1"] * v1**2 + p["m2"] * v2**2 + p["k1"] * x1**2 + p["k2"] * r**2) / 2
    for wall, side in (("near", r), ("far", -r)):
        if wall in system.scene.walls:
            energy = energy + 0.4 * cell["K"] * np.maximum(side - cell[wall], 0.0) ** 2.5
    return energy


def is_refused(system: Preset, periods: int = 1, **options: Any) -> bool:
    try:
        simulate(system, periods, **options)
    except IntegrationError:
        return True
    return False


def stiff() -> float:
    """Free impacts from K = 1e6 to 1e16 N/m^1.5, 1e-6 to 30 m/s, against Hertz's closed form."""
    plain, worst = load_system("ssul-set6"), 0.0
    m1, m2 = plain.parameters["m1"], plain.parameters["m2"]
    mu = m1 * m2 / (m1 + m2)
    for K in (1e6, 1e11, 1e16):
        for speed in (1e-6, 1e-2, 1.0, 30.0):
            depth = (5.0 * mu * speed**2 / (4.0 * K)) ** 0.4
            lasting = DURATION * depth / speed
            nothing = {"k1": 0.0, "c1": 0.0, "k2": 0.0, "c2": 0.0, "P": 0.0}
            system = plain.with_(K=K, omega=2.0 * math.pi / (3.0 * lasting), **nothing)
            start = rest_state(system) - [0.0, 0.0, float(system.cells()["near"]), speed]
            for options in METHODS.values():
                orbit = simulate(system, 1, start=start, record=BOTH, **options)
                if orbit.impacts is None or len(orbit.impacts) != 1:
                    return math.nan
                hit = orbit.impacts[0]
                ratios = (
                    hit["depth"] / depth,
                    hit["force"] / (K * depth**1.5),
                    (hit["release"] - hit["touch"]) / lasting,
                    orbit.state[1] / (-2.0 * mu / m1 * speed),
                )
                worst = max(worst, *(abs(ratio - 1.0) for ratio in ratios))
    return worst


def soft() -> float:
    """Stiffness down to 1e-100 N/m^1.5 against the linear motion of the matrix exponential."""
    worst, touches = 0.0, 0
    for K in (1e-9, 1e-30, 1e-100):
        for C in (0.06233, 0.0, -0.02):
            system = load_system("ssul-set6", K=K, C=C)
            free = load_system("tmd", **{n: system.parameters[n] for n in ("k2", "c2")})
            orbit = simulate(system, 20, record=FULL)
            assert orbit.section is not None
            assert orbit.impacts is not None
            section = orbit.section - [0.0, 0.0, system.rest or 0.0, 0.0]
            worst = max(worst, error_of(section, linear_sections(free, np.zeros(4), 20)))
            touches += len(orbit.impacts)
    return worst if touches else math.nan


def grazing() -> float:
    """Touches missed or invented where the motion turns at C (1 +- 1e-3 ... 1e-11)."""
    wrong, system = 0, load_system("ssul-set6", omega=9.0)
    for shift in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        for sign, periods, touches in ((1.0, 20, 0), (-1.0, 1, 1)):
            near = clear_by(system, sign * shift)
            orbit = simulate(near, periods, start=steady_state(near), record=BOTH)
            assert orbit.impacts is not None
            wrong += len(orbit.impacts) != touches
    return float(wrong)


def undamped() -> float:
    """Change of the energy over 1e5 periods of impacts on steel, without damping and force."""
    worst = 0.0
    for K in (1e12, 1e16):
        system = load_system("ssul-set6", K=K, c1=0.0, c2=0.0, P=0.0)
        start = np.array([0.0, 0.3, system.rest or 0.0, 0.0])
        orbit = simulate(system, 100_000, start=start, record=BOTH)
        assert orbit.section is not None
        if orbit.impacts is None or len(orbit.impacts) < 1000:
            return math.nan
        energy = energy_of(system, np.vstack([start, orbit.section]))
        worst = max(worst, float(np.abs(energy / energy[0] - 1.0).max()))
    return worst


def mass_ratio() -> float:
    """Mass ratios m2 / m1 from 1e-6 to 10, both methods, against SciPy split by events."""
    worst = 0.0
    for ratio in (1e-6, 1e-4, 1e-2, 1.0, 10.0):
        m2 = 1000.0 * ratio
        joint = {"k2": 669.0 * m2 / 60.0, "c2": 50.79 * m2 / 60.0}
        system = load_system("ssul-set6", m2=m2, K=1e6 * m2, **joint)
        system = clear_by(system, -0.7)  # the wall is at 0.3 of the amplitude without it
        section, touches = scipy_orbit(system, rest_state(system), SCIPY_TOLERANCE, 4)
        for options in METHODS.values():
            orbit = simulate(system, 4, record=BOTH, **options)
            if orbit.impacts is None or not len(orbit.impacts) == len(touches) > 0:
                return math.inf
            worst = max(worst, error_of(orbit.section, section, system.rest or 0.0))
    return worst


def slow() -> float:
    """Forcing down to 2e-4 rad/s against the closed form; 1e-5 rad/s and less is refused."""
    worst = 0.0
    for omega, transient in ((1e-1, 8), (1e-2, 1), (1e-3, 1), (2e-4, 1)):
        system = load_system("ssul-set6", omega=omega)
        orbit = simulate(system, 2, transient=transient, record=FULL)
        truth = response(system, np.array([omega]))
        sizes = [abs(X[0]) for X in (truth.X1, truth.X2) if X is not None]
        like = np.array([size * rate for size in sizes for rate in (1.0, omega)])
        states = error_of(orbit.section, np.tile(steady_state(system), (2, 1)), like=like)
        height = abs(float(orbit.E1max or 0.0) / float(truth.E1max[0]) - 1.0)
        worst = max(worst, states, height)
    beyond = (load_system("ssul-set6", omega=omega) for omega in (1e-5, 1e-9, 1e-300))
    accepted = sum(not is_refused(s, method=method) for s in beyond for method in METHODS)
    return worst + accepted


def fast() -> float:
    """Forcing up to 1e6 rad/s: 200 periods of the steady motion against the closed form."""
    worst = 0.0
    for omega in (1e2, 1e3, 1e4, 1e6):
        system = load_system("ssul-set6", omega=omega)
        start = steady_state(system)
        for method in METHODS:
            section = simulate(system, 200, start=start, record=FULL, method=method).section
            wrong = np.abs(np.asarray(section) - start)[:, :2].max(axis=0)
            worst = max(worst, float(np.max(wrong / np.hypot(start[0], start[1] / omega))))
    return worst


def restitution() -> float:
    """Impacts with e = 0 and e = 1 on a stop, against the closed form of a free oscillator."""
    worst = 0.0
    for e, C in ((0.0, -0.5), (0.0, 0.1), (0.0, 0.99), (1.0, 0.0), (1.0, 0.1), (1.0, 0.99)):
        numbers = {"m": 2.0, "k": 2.0, "c": 0.0, "P": 0.0, "omega": 2.0, "C": C, "e": e}
        system = Preset("oscillator", numbers, law="restitution")
        x0, v0 = C - 0.1, 1.0  # x = A sin(t + a) up to the touch, as k / m = 1
        speed = math.sqrt(x0**2 + v0**2 - C**2)
        touch = math.atan2(C, speed) - math.atan2(x0, v0)
        orbit = simulate(system, 1, start=np.array([x0, v0]), record=BOTH)
        if orbit.impacts is None or len(orbit.impacts) < 1:
            return math.nan
        left, v = system.period - touch, -e * speed
        truth = (C * math.cos(left) + v * math.sin(left), v * math.cos(left) - C * math.sin(left))
        if e == 0.0 and C < 0.0:
            truth = (C, 0.0)  # the spring presses the mass onto the stop
        late = abs(float(orbit.impacts["touch"][0]) - touch)
        worst = max(worst, late, float(np.abs(orbit.state - truth).max()))
    return worst


def overflow() -> float:
    """Orbits under forces and from starts of 1e156 to 1.7e308 that end without a status."""
    passed = 0
    for name in ("none", "tmd", "ssul-set6", "ssbl"):
        system = load_system(name)
        rest = rest_state(system)
        rows = np.vstack([np.eye(len(rest)), -np.eye(len(rest))])
        for method in METHODS:
            for size in (1e156, 1e200, 1e300, 1.7e308):
                passed += not is_refused(load_system(name, P=size), 3, method=method)
                starts = (rest + size * row for row in rows)
                passed += sum(not is_refused(system, 3, start=s, method=method) for s in starts)
    return float(passed)


def tiny() -> float:
    """A motion of 1e-93 m and of 1e-129 m beside the same motion of usual size; its energies."""
    start, worst = np.array([0.001, 0.01, 0.0, -0.02]), 0.0
    for factor in (2.0**-300, 2.0**-420):
        system, small = (load_system("ssul-set6", P=8.0 * f) for f in (1.0, factor))
        rest = rest_state(system)
        big = simulate(system, 8, start=start + rest, record=FULL)
        other = simulate(small, 8, start=start * factor + rest, record=FULL)
        assert big.section is not None
        assert other.section is not None
        # x2 is measured from the fixed frame: beside its rest position a tiny motion is lost
        states = error_of((other.section / factor)[:, :2], big.section[:, :2])
        energy = float(other.E1max or 0.0) / factor / factor / float(big.E1max or 1.0)
        worst = max(worst, states, abs(energy - 1.0))
    return worst


class Extreme(NamedTuple):
    """A number and the bound that it must not exceed."""

    name: str
    measure: Callable[[], float]
    bound: float


EXTREMES = (
    Extreme("stiff", stiff, 1e-10),
    Extreme("soft", soft, 1e-10),
    Extreme("grazing", grazing, 0.0),
    Extreme("undamped", undamped, 1e-9),
    Extreme("mass ratio", mass_ratio, 1e-8),
    Extreme("slow", slow, 1e-10),
    Extreme("fast", fast, 1e-6),
    Extreme("e = 0 and 1", restitution, 1e-12),
    Extreme("overflow", overflow, 0.0),
    Extreme("tiny states", tiny, 1e-12),
)


def main() -> int:
    """Measure, print, and write the table into a page if asked to; 1 if a bound is exceeded."""
    page, rows = parser_of(__doc__).parse_args().page, []
    for name, measure, bound in EXTREMES:
        value, text = measure(), (measure.__doc__ or "").strip().rstrip(".")
        rows.append((name, text, f"{value:.2g}", f"{bound:g}", "" if value <= bound else "broken"))
    lines = table(("", "compared", "value", "bound", ""), rows, right=(2, 3))
    publish("python -m benchmarks.extremes", lines, page)
    return int(any(row[-1] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
