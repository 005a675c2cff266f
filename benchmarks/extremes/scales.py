"""Units, frequencies and motions from enormous to denormal (entries 7, 12 and 14)."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.extremes.cases import FULL, METHODS, amplitudes, error_of, shortening, status_of
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import response, steady_state
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import Orbit

FORCES = ("m1", "k1", "c1", "m2", "k2", "c2", "P", "K")
"""What carries the unit of force (or mass): a common factor changes no motion."""

RATES = {"omega": 1, "c1": 1, "c2": 1, "k1": 2, "k2": 2, "K": 2, "P": 2}
"""What carries the unit of time, and to which power."""


def scaled(system: System, power: int) -> System:
    """Return a system with masses, stiffnesses, dampings and forces times 2^power, K too."""
    known = {**system.parameters, "K": system.K}
    return system.with_(**{name: known[name] * 2.0**power for name in FORCES})


def quickened(system: System, power: int) -> System:
    """Return a system in which everything happens 2^power times as fast."""
    known = {**system.parameters, "K": system.K}
    return system.with_(**{n: known[n] * 2.0 ** (power * times) for n, times in RATES.items()})


def _differing(plain: Orbit, other: Orbit, energy: float, time: float) -> int:
    """Count the numbers of an orbit that are not those of a plain one, bit by bit.

    `energy` and `time` are the factors by which units of the other are larger.
    """
    assert plain.impacts is not None
    assert other.impacts is not None
    assert plain.section is not None
    assert other.section is not None
    speeds = np.array([1.0, 1.0 / time, 1.0, 1.0 / time])
    pairs = [
        (other.section, plain.section * speeds),
        (other.impacts["touch"], plain.impacts["touch"] * time),
        (other.impacts["release"], plain.impacts["release"] * time),
        (other.impacts["speed"], plain.impacts["speed"] / time),
        (other.impacts["depth"], plain.impacts["depth"]),
        (np.array([other.E1max, other.E2max]), np.array([plain.E1max, plain.E2max]) * energy),
        (np.array([other.clearance]), np.array([plain.clearance])),
    ]
    if len(plain.impacts) != len(other.impacts):
        return len(pairs)
    return sum(not np.array_equal(a, b) for a, b in pairs)


def scaling_of_forces(changed: Any = scaled) -> Finding:
    """Scale masses, stiffnesses, dampings and forces by powers of two; compare every bit.

    `changed` makes the other system, for a test that this can fail.
    """
    system, wrong, powers = load_system("ssul-set6"), 0, (-300, -40, -1, 3, 40, 300)
    for method in METHODS:
        plain = simulate(system, 30, record=FULL, method=method)
        for power in powers:
            other = simulate(changed(system, power), 30, record=FULL, method=method)
            wrong += _differing(plain, other, 2.0**power, 1.0)
    words = f"{len(powers)} powers from 2^-300 to 2^300, both methods: {wrong} results differ"
    return within(wrong, 0.0, words)


def scaling_of_time() -> Finding:
    """Let everything happen 2^k times as fast; compare every bit."""
    system, wrong, powers = load_system("ssul-set6"), 0, (-20, -3, 1, 20)
    for method in METHODS:
        plain = simulate(system, 30, record=FULL, method=method)
        for power in powers:
            other = simulate(quickened(system, power), 30, record=FULL, method=method)
            wrong += _differing(plain, other, 4.0**power, 2.0**-power)
    words = f"{len(powers)} powers from 2^-20 to 2^20, both methods: {wrong} results differ"
    return within(wrong, 0.0, words)


def _steadiness(system: System, transient: int, **options: Any) -> float:
    """Return how far an impact-free orbit is from the closed form, energies and misses too."""
    orbit = simulate(system, 2, transient=transient, record=FULL, **options)
    assert orbit.impacts is not None
    assert orbit.E1max is not None
    assert orbit.clearance is not None
    exact = np.tile(steady_state(system), (2, 1))
    known = response(system, np.array([system.parameters["omega"]]))
    miss = orbit.clearance - (system.parameters["C"] - shortening(system))
    wrong = error_of(orbit.section, exact, like=amplitudes(system))
    height = abs(orbit.E1max / float(known.E1max[0]) - 1.0)
    return max(wrong, height, abs(miss) / system.parameters["C"], float(len(orbit.impacts)))


def slow_forcing() -> Finding:
    """Force the damper once in hours: the steady state, and below that a status."""
    errors = [
        _steadiness(load_system("ssul-set6", omega=omega), transient)
        for omega, transient in ((1e-1, 8), (1e-2, 1), (1e-3, 1), (2e-4, 1))
    ]
    refused = [
        status_of(load_system("ssul-set6", omega=omega), 1, method=method)
        for omega in (1e-5, 1e-9, 1e-300)
        for method in METHODS
    ]
    hung = sum(name != "too_stiff" for name in refused)
    words = (
        f"from 0.1 to 2e-4 rad/s the steady state to {max(errors):.1e}; below 1e-5 rad/s "
        f"{len(refused) - hung} of {len(refused)} orbits end at once as too_stiff"
    )
    return within(max(errors) + hung, 1e-10, words)


def fast_forcing() -> Finding:
    """Force the damper up to a million times a second, on the steady motion."""
    errors = {}
    for omega in (1e2, 1e3, 1e4, 1e6):
        system = load_system("ssul-set6", omega=omega)
        for method in METHODS:
            start = steady_state(system)
            orbit = simulate(system, 200, start=start, record=FULL, method=method)
            assert orbit.impacts is not None
            expected = np.tile(start, (200, 1))
            wrong = np.abs(orbit.section - expected)[:, :2].max(axis=0)
            errors[omega, method] = float(np.max(wrong / np.hypot(start[0], start[1] / omega)))
    worst = max(errors.values())
    words = f"from 1e2 to 1e6 rad/s x1 stays within {worst:.1e} of its amplitude over 200 periods"
    return within(worst, 1e-6, words)


def _scaled_down(start: np.ndarray, force: float, factor: float) -> tuple[float, float, float]:
    """Return by how much states, energies and misses of a tiny motion fail to be scaled down."""
    system = load_system("ssul-set6", P=force)
    small = load_system("ssul-set6", P=force * factor)
    offset = np.array([0.0, 0.0, system.rest or 0.0, 0.0])
    big = simulate(system, 8, start=start + offset, record=FULL)
    tiny = simulate(small, 8, start=start * factor + offset, record=FULL)
    assert big.section is not None
    assert tiny.section is not None
    assert tiny.clearance is not None
    # x2 is measured from the fixed frame: beside its rest position a tiny motion is not seen
    wrong = error_of((tiny.section / factor)[:, :2], big.section[:, :2])
    energy = abs(float(tiny.E1max or 0.0) / factor / factor / float(big.E1max or 1.0) - 1.0)
    return wrong, energy, abs(tiny.clearance / system.parameters["C"] - 1.0)


def denormal_states() -> Finding:
    """Scale a motion without impacts down to denormal numbers; it stays the same motion."""
    start, force = np.array([0.001, 0.01, 0.0, -0.02]), 8.0
    errors: list[float] = []
    for exponent in (-100, -140):
        errors.extend(_scaled_down(start, force, 2.0 ** (3 * exponent))[:2])
        errors.append(_scaled_down(start, force, 2.0 ** (3 * exponent))[2])
    words = f"motions of 1e-93 and 1e-129 m: states, energies and misses to {max(errors):.1e}"
    return within(max(errors), 1e-12, words)


def denormal_forces() -> Finding:
    """Let forces be so small that energies underflow, or the motion itself: nothing is made up."""
    made_up, worst = 0.0, 0.0
    for force in (1e-150, 1e-160, 1e-170, 1e-300, 1e-310, 5e-324, 0.0):
        system = load_system("ssul-set6", P=force)
        for method in METHODS:
            orbit = simulate(system, 20, record=FULL, method=method)
            assert orbit.impacts is not None
            made_up += len(orbit.impacts)
            # E1max goes with the square of the force; 1.6e-3 J of 1 N is above any of these
            made_up += float(orbit.E1max or 0.0) > 1.6e-3 * force * force + 5e-324
            if force > 1e-300:
                assert orbit.clearance is not None
                worst = max(worst, abs(orbit.clearance / 0.06233 - 1.0))
    words = f"forces from 1e-150 N to denormal ones: {made_up:.0f} results exceed what is possible"
    return within(made_up + worst, 0.0, words)


ENTRIES = (
    Entry(
        7,
        "scaling of forces",
        "Masses, stiffnesses, K, dampings and forces times 2^k leave every bit of the motion.",
        scaling_of_forces,
    ),
    Entry(
        7,
        "scaling of time",
        "Everything 2^k times as fast leaves every bit of the motion, in its own units.",
        scaling_of_time,
    ),
    Entry(
        12,
        "slow forcing",
        "Down to 2e-4 rad/s the steady state is the closed form; below 1e-5 rad/s an orbit ends at "
        "once with the status too_stiff.",
        slow_forcing,
        "The motion's own rates set the cells of a period: 524288 of them are the budget, some "
        "tenths of a second. Precision is not what is short.",
    ),
    Entry(
        12,
        "fast forcing",
        "Up to 1e6 rad/s the steady state is the closed form.",
        fast_forcing,
        "The amplitude is P / (m1 omega^2), 8e-13 m at 1e6 rad/s, and rk4 errs at its own order.",
    ),
    Entry(
        14,
        "denormal states",
        "A motion without impacts scaled down to 1e-129 m stays the same motion.",
        denormal_states,
        "Positions in the fixed frame hold no digits of motions below 1e-17 of x2 = V + C.",
    ),
    Entry(
        14,
        "denormal forces",
        "Where energies or motions underflow they become zero: no energy, impact or near miss is "
        "made up.",
        denormal_forces,
        "Below 1e-154 N squares of the motion are denormal numbers: energies lose digits, then "
        "vanish.",
    ),
)
