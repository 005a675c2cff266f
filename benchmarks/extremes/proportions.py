"""Proportions: masses, dampings and forces from nothing to enormous (entries 13, 23 and 27)."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.extremes.cases import (
    LINEAR,
    METHODS,
    error_of,
    linear_sections,
    orbit_of,
    shortening,
    status_of,
)
from benchmarks.extremes.contacts import RK4
from benchmarks.extremes.entry import Entry, Finding, within
from benchmarks.extremes.reference import follow
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system


def mass_ratio() -> Finding:
    """Let the damper's mass vanish, and let it be ten times the structure's."""
    errors = {}
    for ratio in (1e-6, 1e-4, 1e-2, 1.0, 10.0):
        m2 = 1000.0 * ratio
        joint = {"k2": 669.0 * m2 / 60.0, "c2": 50.79 * m2 / 60.0}
        system = load_system("ssul-set6", m2=m2, K=1e6 * m2, **joint)
        system = system.with_(C=0.3 * shortening(system))
        course = follow(system, 4)
        for name, options in (("exact", {}), ("rk4", RK4)):
            orbit = orbit_of(system, 4, **options)
            assert orbit.impacts is not None
            alike = len(orbit.impacts) == len(course.touches) > 0
            wrong = error_of(orbit.section, course.section, system.rest or 0.0)
            errors[f"{ratio:g}, {name}"] = wrong if alike else math.inf
    worst = max(errors, key=errors.__getitem__)
    words = f"m2/m1 from 1e-6 to 10: at most {errors[worst]:.1e} from SciPy ({worst})"
    return within(errors[worst], 1e-8, words)


def vanishing_mass() -> Finding:
    """Let the mass vanish while spring and dashpot stay: the structure is left alone."""
    slopes, exact = [], linear_sections(load_system("none"), np.zeros(2), 10)
    for ratio in (1e-6, 1e-5, 1e-4):
        system = load_system("ssul-set6", m2=1000.0 * ratio)
        found = orbit_of(system, 10).section
        slopes.append(error_of(np.asarray(found)[:, :2], exact) / ratio)
    spread = max(slopes) / min(slopes) - 1.0
    words = f"the structure's motion moves by {slopes[0]:.2f} times the mass ratio, down to 1e-6"
    return within(spread, 0.05, words)


def tiny_and_huge_forces() -> Finding:
    """Force from 1e-9 to 1e9 N: linear below, SciPy's orbit above."""
    errors = {}
    for force in (1e-9, 1e-3, 1.0):
        system = load_system("ssul-set6", P=force)
        free = load_system("tmd", k2=system.parameters["k2"], c2=system.parameters["c2"], P=force)
        exact = linear_sections(free, np.zeros(4), 20)
        found = np.asarray(orbit_of(system, 20).section)
        errors[force] = error_of(found[:, :2], exact[:, :2])
    for force in (1e3, 1e6, 1e9):
        system = load_system("ssul-set6", P=force)
        course, orbit = follow(system, 4), orbit_of(system, 4)
        assert orbit.impacts is not None
        alike = len(orbit.impacts) == len(course.touches) > 0
        wrong = error_of(orbit.section, course.section, system.rest or 0.0)
        errors[force] = wrong if alike else math.inf
    worst = max(errors, key=errors.__getitem__)
    words = f"P from 1e-9 to 1e9 N: at most {errors[worst]:.1e} (P = {worst:g} N)"
    return within(errors[worst], 1e-8, words)


def no_damping() -> Finding:
    """Leave out the damping of structure, damper or both, with impacts, against SciPy."""
    errors = {}
    for c1, c2 in ((0.0, 0.0), (0.0, 50.79), (452.0, 0.0), (1e-300, 1e-300)):
        system = load_system("ssul-set6", c1=c1, c2=c2)
        course = follow(system, 8)
        for name, options in (("exact", {}), ("rk4", RK4)):
            found = orbit_of(system, 8, **options).section
            wrong = error_of(found, course.section, system.rest or 0.0)
            errors[f"c1 = {c1:g}, c2 = {c2:g}, {name}"] = wrong
    worst = max(errors, key=errors.__getitem__)
    return within(errors[worst], 1e-7, f"at most {errors[worst]:.1e} from SciPy ({worst})")


WELDED = 0.01
"""How constant c2 times the distance to the welded motion must be from c2 = 1e5 to 1e7 N s/m."""


def enormous_damping() -> Finding:
    """Raise the damping until the damper is welded to the structure, or the structure to ground."""
    errors, apart = [], []
    one = linear_sections(load_system("none", m1=1060.0), np.zeros(2), 10)
    for c2 in (1e3, 1e5, 1e7):
        system = load_system("tmd", c2=c2)
        found = np.asarray(simulate(system, 10, record=LINEAR).section)
        errors.append(error_of(found, linear_sections(system, np.zeros(4), 10, pieces=1024)))
        apart.append(error_of(found[:, :2], one) * c2)
    for c1 in (1e5, 1e8):
        system = load_system("tmd", c1=c1)
        found = np.asarray(simulate(system, 10, record=LINEAR).section)
        errors.append(error_of(found, linear_sections(system, np.zeros(4), 10, pieces=1024)))
    beyond = [{"c2": 1e9}, {"c2": 1e300}, {"c1": 1e300}, {"k2": 1e300}, {"m2": 1e-300}]
    refused = sum(
        status_of(load_system("tmd", **changes), 1, method=method) == "too_stiff"
        for changes in beyond
        for method in METHODS
    )
    words = (
        f"c up to 1e8 N s/m: {max(errors):.1e} from the matrix exponential; the welded motion but "
        f"for {apart[-2]:.1f} / c2 at c2 = 1e5 and {apart[-1]:.1f} / c2 at 1e7; {refused} of "
        f"{2 * len(beyond)} orbits beyond end as too_stiff"
    )
    missing = 2 * len(beyond) - refused
    welded = abs(apart[-1] / apart[-2] - 1.0) <= WELDED
    return within(max(errors) + missing if welded else math.nan, 1e-9, words)


def stiff_impacts() -> Finding:
    """Let a heavily damped damper be driven into its obstacle, against SciPy."""
    errors = {}
    for c2 in (1e3, 1e4):
        system = load_system("ssul-set6", c2=c2, C=1e-3, P=5000.0)
        course, orbit = follow(system, 3), orbit_of(system, 3)
        assert orbit.impacts is not None
        alike = len(orbit.impacts) == len(course.touches) > 0
        wrong = error_of(orbit.section, course.section, system.rest or 0.0)
        errors[c2] = wrong if alike else math.inf
    worst = max(errors.values())
    return within(worst, 1e-8, f"c2 = 1e3 and 1e4 N s/m with impacts: {worst:.1e} from SciPy")


ENTRIES = (
    Entry(
        13,
        "mass ratio",
        "With m2 / m1 from 1e-6 to 10 both methods agree with SciPy to 1e-8.",
        mass_ratio,
    ),
    Entry(
        13,
        "vanishing mass",
        "With m2 to zero the structure moves as if alone, in proportion to m2.",
        vanishing_mass,
    ),
    Entry(
        23,
        "no damping",
        "Damping that is zero or denormal, of either body, is no special case.",
        no_damping,
    ),
    Entry(
        23,
        "enormous damping",
        "Damping is followed exactly up to 1e7 N s/m between the bodies of the named dampers; what "
        "needs more cells than the budget ends as too_stiff.",
        enormous_damping,
        "Beyond the budget nothing new happens: the damper is welded to the structure but for "
        "a share that goes with 1 / c2, 3e-5 of the motion at 1e7 N s/m.",
    ),
    Entry(
        23,
        "damped impacts",
        "Heavily damped dampers driven into their obstacle agree with SciPy to 1e-8.",
        stiff_impacts,
    ),
    Entry(
        27,
        "tiny and huge forces",
        "From 1e-9 to 1e9 N motions are linear where they should be and agree with SciPy to 1e-8.",
        tiny_and_huge_forces,
    ),
)
