"""Orbits with contacts of every kind against an independent integrator (entries 18, 22 and 26)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import brentq

from benchmarks.extremes.cases import BOTH, METHODS, error_of, orbit_of, touching_state
from benchmarks.extremes.entry import Entry, Finding, within
from benchmarks.extremes.reference import follow
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import steady_state
from nlds_vines.model.system import System

RK4: dict[str, Any] = {"method": "rk4", "period_steps": 4096.0}

Cases = Mapping[str, tuple[System, np.ndarray | None, int]]
"""Orbits by name: system, start (None for rest), forcing periods."""


def _difference(
    system: System, periods: int, start: np.ndarray | None = None, **options: Any
) -> tuple[float, int]:
    """Return how far our orbit is from SciPy's, in its own scales, and the number of touches.

    Infinite where the touches differ in number.
    """
    course = follow(system, periods, start)
    orbit = orbit_of(system, periods, start=start, **options)
    assert orbit.impacts is not None
    if len(orbit.impacts) != len(course.touches):
        return math.inf, len(orbit.impacts)
    wrong = error_of(orbit.section, course.section, system.rest or 0.0)
    late = np.abs(orbit.impacts["touch"] - course.touches).max(initial=0.0) / system.period
    return max(wrong, float(late)), len(orbit.impacts)


def _worst(cases: Cases, **options: Any) -> Finding:
    """Return the finding of several orbits, named, by the exact method (or `options`)."""
    found = {
        name: _difference(system, periods, start, **options)
        for name, (system, start, periods) in cases.items()
    }
    worst = max(found, key=lambda name: found[name][0])
    touches = sum(count for _, count in found.values())
    words = (
        f"{len(found)} orbits with {touches} touches; the largest difference is "
        f"{found[worst][0]:.1e} ({worst})"
    )
    return within(found[worst][0], 1e-8, words)


def _orbits() -> Cases:
    return {
        "Set 6, 6.28 rad/s": (load_system("ssul-set6"), None, 20),
        "Set 6, 7.45 rad/s": (load_system("ssul-set6", omega=7.45), None, 10),
        "Set 1": (load_system("ssul-set1"), None, 15),
        "SSbl, 6.05 rad/s": (load_system("ssbl", omega=6.05), None, 15),
    }


def against_scipy() -> Finding:
    """Compare the default settings with SciPy before errors have grown."""
    return _worst(_orbits())


def rk4_against_scipy() -> Finding:
    """Compare rk4 at 4096 steps with SciPy before errors have grown."""
    return _worst(_orbits(), **RK4)


def chaos_by_statistics() -> Finding:
    """Compare impacts per period and mean square displacement of chaos by both methods."""
    system, batches, length = load_system("ssul-set6", m2=1e4), 16, 500
    numbers, ends = [], []
    for method in METHODS:
        orbit = simulate(system, batches * length, transient=600, record=BOTH, method=method)
        assert orbit.section is not None
        assert orbit.impacts is not None
        beats = np.floor(orbit.impacts["touch"] / system.period - 600.0).astype(int)
        rate = np.bincount(beats, minlength=batches * length)[: batches * length]
        ends.append(orbit.state)
        numbers.append(np.stack([rate, orbit.section[:, 0] ** 2]).reshape(2, batches, length))
    means = [values.mean(axis=2) for values in numbers]
    errors = [values.std(axis=1, ddof=1) / math.sqrt(batches) for values in means]
    apart = np.abs(means[0].mean(axis=1) - means[1].mean(axis=1)) / np.hypot(*errors)
    relative = np.max(errors[0] / means[0].mean(axis=1))
    forgotten = error_of(ends[1], ends[0], system.rest or 0.0) > 0.1
    words = (
        f"{means[0][0].mean():.4f} and {means[1][0].mean():.4f} impacts per period: both averages "
        f"agree within {apart.max():.1f} standard errors of at most {100 * relative:.1f} %"
    )
    return within(apart.max() if relative < 0.05 and forgotten else math.nan, 4.0, words)


def _near_touch() -> Cases:
    system, flat = load_system("ssul-set6"), load_system("ssul-set6", C=0.0)
    inside = touching_state(system, 0.1)
    inside[2] -= 2e-3
    resting = touching_state(system, 0.0)
    return {
        "in contact, closing": (system, inside, 8),
        "in contact, opening": (system, inside * [1.0, 1.0, 1.0, -1.0], 8),
        "at touch, closing": (system, touching_state(system, 0.5), 8),
        "at touch, opening": (system, touching_state(system, -0.5), 8),
        "at touch, at rest": (system, resting, 8),
        "at rest on the wall, C = 0": (flat, None, 8),
        "on the wall of SSbl": (load_system("ssbl", D=0.0), None, 3),
    }


def _preloaded() -> Cases:
    return {
        "C = -1e-9": (load_system("ssul-set6", C=-1e-9), None, 8),
        "C = -0.02": (load_system("ssul-set6", C=-0.02), None, 8),
        "C = -0.02, soft": (load_system("ssul-set6", C=-0.02, K=1e3), None, 10),
        "SSbl, C = -0.01": (load_system("ssbl", C=-0.01, D=0.02, K=1e5), None, 4),
        "SSbl, C = -D": (load_system("ssbl", C=-0.01, D=0.01, K=1e4), None, 4),
    }


def _both_walls() -> Cases:
    fast = np.array([0.0, 0.0, 0.0, 20.0])
    return {
        "20 m/s across 1 mm": (load_system("ssbl", C=5e-4, D=5e-4, K=1e9, omega=1e3), fast, 2),
        "0.2 mm apart": (load_system("ssbl", C=1e-4, D=1e-4), None, 2),
        "no room at all": (load_system("ssbl", C=0.0, D=0.0, K=1e5), None, 3),
    }


def starts_at_touch() -> Finding:
    """Begin inside contacts, on walls, and at rest on a wall without clearance."""
    return _touches_aside(_near_touch())


def preloaded() -> Finding:
    """Begin with the damper pressed onto its obstacle, or onto two."""
    return _touches_aside(_preloaded())


def both_walls() -> Finding:
    """Touch two walls within a cell of flight, and rattle between walls without room."""
    return _touches_aside(_both_walls())


def _touches_aside(cases: Cases) -> Finding:
    """Return the finding of several orbits by both methods: states alone.

    A contact that the start lies in or on is no touch to some and one to others.
    """
    errors = {}
    for name, (system, start, periods) in cases.items():
        section = follow(system, periods, start).section
        for method, options in (("exact", {}), ("rk4", RK4)):
            orbit = orbit_of(system, periods, start=start, **options)
            found = error_of(orbit.section, section, system.rest or 0.0)
            errors[f"{name}, {method}"] = found
    worst = max(errors, key=errors.__getitem__)
    words = f"{len(errors)} orbits by both methods: at most {errors[worst]:.1e} ({worst})"
    return within(errors[worst], 1e-8, words)


def pressed_for_long() -> Finding:
    """Let a small force shake a pressed damper for 1000 periods: a linear contact spring."""
    system = load_system("ssul-set6", C=-0.02, P=1e-6)
    p, depth = system.parameters, _pressed_depth(system)
    spring = 1.5 * system.K * math.sqrt(depth)
    start = touching_state(system, 0.0) - [0.0, 0.0, depth, 0.0]
    orbit = simulate(system, 3, start=start, transient=1000, record=BOTH)
    stiff = load_system("tmd", k2=p["k2"] + spring, c2=p["c2"], P=p["P"])
    expected = np.tile(steady_state(stiff) + start, (3, 1))
    wrong = error_of(orbit.section, expected, start[2])
    assert orbit.impacts is not None
    words = (
        f"pressed {1e3 * depth:.3g} mm deep for 1003 periods, {len(orbit.impacts)} touches, the "
        f"small motion is that of a spring of {spring:.4g} N/m to {wrong:.1e}"
    )
    return within(wrong if len(orbit.impacts) == 0 else math.nan, 1e-5, words)


def _pressed_depth(system: System) -> float:
    """Return the depth [m] at which the obstacle carries the damper's spring: k2 r = -K z^1.5."""
    p, K = system.parameters, system.K
    return float(brentq(lambda z: K * z**1.5 + p["k2"] * (z + p["C"]), 0.0, -p["C"], xtol=1e-18))


def any_stiffness() -> Finding:
    """Compare the methods with SciPy for contacts from rubber to beyond steel."""
    stiffness = (1e-6, 1.0, 1e3, 1e5, 1e7, 1e9)
    return _worst({f"K = {K:g}": (load_system("ssul-set6", K=K), None, 4) for K in stiffness})


def methods_on_steel() -> Finding:
    """Compare exact and rk4 where contacts are too short for SciPy to be trusted."""
    worst = 0.0
    for K in (1e10, 1e12, 1e14, 1e16):
        system = load_system("ssul-set6", K=K)
        one, other = orbit_of(system, 6), orbit_of(system, 6, method="rk4", period_steps=8192.0)
        assert one.impacts is not None
        assert other.impacts is not None
        alike = len(one.impacts) == len(other.impacts) > 0
        wrong = error_of(other.section, one.section, system.rest or 0.0)
        worst = max(worst, wrong if alike else math.inf)
    return within(worst, 1e-8, f"K from 1e10 to 1e16: they differ by {worst:.1e} after 6 periods")


_SCIPY = (
    "DOP853 at its finest tolerance, 3e-14, is good to about 1e-11 here; errors grow from impact "
    "to impact, which bounds the number of periods that can be compared."
)

ENTRIES = (
    Entry(
        18,
        "against SciPy",
        "Orbits with impacts agree with SciPy's DOP853, split by events, to 1e-8 with the default "
        "settings, touch by touch.",
        against_scipy,
        _SCIPY,
    ),
    Entry(
        18,
        "rk4 against SciPy",
        "So do those of rk4 at 4096 steps.",
        rk4_against_scipy,
        _SCIPY,
    ),
    Entry(
        18,
        "chaos by statistics",
        "Where errors grow exponentially the methods agree in averages, within 4 standard errors.",
        chaos_by_statistics,
        "A chaotic orbit itself is lost after some fifty periods by any method with 16 digits.",
    ),
    Entry(
        22,
        "starts at a wall",
        "An orbit may begin in contact or exactly at touch, moving or at rest, with C = 0 as well.",
        starts_at_touch,
    ),
    Entry(
        22,
        "preloaded",
        "With C < 0 the damper is pressed onto its obstacle, or onto two, and bounces rightly.",
        preloaded,
    ),
    Entry(
        22,
        "pressed for long",
        "A preloaded contact that never opens is followed for 1000 periods; its small motion is "
        "that of the linearised contact.",
        pressed_for_long,
        "The linearisation itself is good to the square of the motion.",
    ),
    Entry(
        22,
        "two walls at once",
        "Two walls touched within one step, or without room between them, are told apart.",
        both_walls,
    ),
    Entry(
        26,
        "any stiffness",
        "Contact stiffnesses from 1e-6 to 1e9 N/m^1.5 agree with SciPy to 1e-8.",
        any_stiffness,
        _SCIPY,
    ),
    Entry(
        26,
        "beyond steel",
        "From 1e10 to 1e16 N/m^1.5 exact and rk4, which share no formula in flight, agree to 1e-8.",
        methods_on_steel,
    ),
)
