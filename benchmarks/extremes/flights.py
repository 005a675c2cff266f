"""Motion without contact: it is known in closed form, whatever the numbers (entries 1, 10, 25)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.extremes.cases import (
    BOTH,
    FULL,
    LINEAR,
    error_of,
    linear_sections,
    order_of,
    shortening,
)
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import response, steady_state

START = np.array([0.01, -0.2, 0.03, 0.4])
MU = 60.0 * 1000.0 / 1060.0  # reduced mass of the named systems [kg]

DEGENERATE: dict[str, dict[str, float]] = {
    "as tabulated": {},
    "undamped": {"c1": 0.0, "c2": 0.0},
    "critically damped pair": {"k2": 215.0, "c2": 2.0 * math.sqrt(215.0 * MU)},
    "nearly critical pair": {"k2": 215.0, "c2": 2.0 * math.sqrt(215.0 * MU) * (1.0 + 1e-9)},
    "overdamped pair": {"k2": 215.0, "c2": 2000.0},
    "critically damped structure": {"c1": 2.0 * math.sqrt(3.95e4 * 1000.0)},
    "damper without a joint": {"k2": 0.0, "c2": 0.0},
    "damper without a spring": {"k2": 0.0},
    "structure without a spring": {"k1": 0.0, "c1": 0.0},
    "nothing but masses": {"k1": 0.0, "c1": 0.0, "k2": 0.0, "c2": 0.0},
}
"""Changes of the tuned mass damper that make eigenvectors meet or vanish."""


def against_the_exponential() -> Finding:
    """Compare every degenerate linear system with SciPy's matrix exponential over 20 periods."""
    errors = {}
    for name, changes in DEGENERATE.items():
        system = load_system("tmd", **changes)
        orbit = simulate(system, 20, start=START, record=LINEAR)
        errors[name] = error_of(orbit.section, linear_sections(system, START, 20))
    worst = max(errors, key=errors.__getitem__)
    words = f"{len(errors)} systems; the largest relative error is {errors[worst]:.1e} ({worst})"
    return within(errors[worst], 1e-12, words)


def order_of_fixed_steps() -> Finding:
    """Fit the order of rk4 without contact, from coarse steps down to round-off."""
    system = load_system("tmd")
    exact = linear_sections(system, START, 3)
    steps = [2.0**n for n in range(5, 16)]
    runs = (
        simulate(system, 3, start=START, record=LINEAR, method="rk4", period_steps=n) for n in steps
    )
    errors = [error_of(run.section, exact) for run in runs]
    seen = [(n, e) for n, e in zip(steps, errors, strict=True) if e > 1e-12]
    order = order_of([e for _, e in seen], [n for n, _ in seen])
    words = f"order {order:.2f} over {len(seen)} step sizes, {min(errors):.0e} at the finest"
    return within(max(abs(order - 4.0), 0.2 * min(errors) / 1e-12), 0.2, words)


def critical_contact() -> Finding:
    """Compare both methods where damper pairs are critical and impacts happen."""
    worst = 0.0
    for c2 in (2.0 * math.sqrt(669.0 * MU), 2.0 * math.sqrt(669.0 * MU) * (1.0 + 1e-12)):
        system = load_system("ssul-set6", c2=c2, P=2000.0)
        one = simulate(system, 20, record=BOTH)
        other = simulate(system, 20, record=BOTH, method="rk4", period_steps=4096.0)
        assert one.impacts is not None
        if len(one.impacts) == 0:
            return within(math.nan, 1e-8, "there was no impact to compare")
        worst = max(worst, error_of(other.section, one.section, system.rest or 0.0))
    return within(worst, 1e-8, f"exact and rk4 differ by {worst:.1e} after 20 periods with impacts")


def _resonant(**changes: float) -> Any:
    return load_system("none", **{"c1": 0.0, "k1": 1000.0, "omega": 1.0, **changes})


def resonance() -> Finding:
    """Hold resonance without damping against x1 = P t sin(omega t) / (2 m1 omega)."""
    system, periods = _resonant(), 10_000
    p = system.parameters
    orbit = simulate(system, periods, record=LINEAR)
    assert orbit.section is not None
    assert orbit.E1max is not None
    times = system.period * np.arange(1, periods + 1)
    speed = p["P"] / (2.0 * p["m1"])
    wrong = np.abs(orbit.section[:, 1] / (speed * times) - 1.0).max()
    lag = np.abs(orbit.section[:, 0]).max() / (speed * times[-1] / p["omega"])
    peak = _largest_energy(p, times[-1])
    height = abs(orbit.E1max / peak - 1.0)
    words = (
        f"over {periods} periods the speed errs by {wrong:.1e}, the phase by {lag:.1e} rad and "
        f"E1max = {orbit.E1max:.6g} J by {height:.1e}"
    )
    return within(max(wrong, lag, height), 1e-8, words)


def _largest_energy(p: Any, end: float) -> float:
    """Return the largest energy [J] up to a time [s] a whole number of periods at resonance.

    With a = omega t, E1 = (P/omega)^2 (a^2 + sin(a)^2 + a sin(2 a)) / (8 m1), growing throughout.
    """
    a = p["omega"] * end
    scale = (p["P"] / p["omega"]) ** 2 / (8.0 * p["m1"])
    return float(scale * (a * a + math.sin(a) ** 2 + a * math.sin(2.0 * a)))


def resonance_in_closed_form() -> Finding:
    """Ask the closed form for the amplitude at an undamped resonance and antiresonance."""
    alone = response(_resonant(), np.array([1.0]))
    absorber = load_system("tmd", c1=0.0, c2=0.0, k1=1000.0, k2=60.0, omega=1.0)
    still = response(absorber, np.array([1.0]))
    assert still.X2 is not None
    expected = -absorber.parameters["P"] / absorber.parameters["k2"]
    wrong = abs(still.X1[0]) + abs(still.X2[0] / expected - 1.0)
    wrong += 0.0 if np.isinf(alone.E1max[0]) else math.inf
    words = (
        f"at resonance E1max = {alone.E1max[0]}; an absorber tuned exactly leaves "
        f"X1 = {abs(still.X1[0]):g} m and X2 = {still.X2[0].real:.6g} m"
    )
    return within(wrong, 1e-14, words)


def soft_limit() -> Finding:
    """Let the contact stiffness go to nothing: what is left is the linear motion."""
    worst, touches = 0.0, 0
    for K in (1e-9, 1e-12, 1e-30, 1e-100):
        for C in (0.06233, 0.0, -0.02):
            system = load_system("ssul-set6", K=K, C=C)
            free = load_system("tmd", **{n: system.parameters[n] for n in ("k2", "c2")})
            expected = linear_sections(free, np.zeros(4), 20)
            orbit = simulate(system, 20, record=FULL)
            assert orbit.section is not None
            assert orbit.impacts is not None
            found = orbit.section - [0.0, 0.0, system.rest or 0.0, 0.0]
            worst = max(worst, error_of(found, expected))
            touches += len(orbit.impacts)
    words = f"K from 1e-9 to 1e-100: relative error {worst:.1e}, {touches} touches on the way"
    return within(worst if touches > 0 else math.nan, 1e-10, words)


def far_wall() -> Finding:
    """Let the clearance go to infinity: the steady state without impacts, energies included."""
    worst = 0.0
    for C in (1.0, 1e6, 1e12):
        system = load_system("ssul-set6", C=C, V=-C)  # x2 is then measured from its rest
        orbit = simulate(system, 3, transient=300, record=FULL)
        assert orbit.impacts is not None
        exact = np.tile(steady_state(system), (3, 1))
        known = response(system, np.array([system.parameters["omega"]]))
        height = abs(float(orbit.E1max or 0.0) / float(known.E1max[0]) - 1.0)
        miss = abs(float(orbit.clearance or 0.0) - (C - shortening(system))) / C
        worst = max(worst, error_of(orbit.section, exact), height, miss, len(orbit.impacts))
    return within(worst, 1e-10, f"states, E1max and the nearest miss err by {worst:.1e}")


ENTRIES = (
    Entry(
        1,
        "flight",
        "Without contact the exact method follows the matrix exponential to round-off, defective "
        "and degenerate systems included.",
        against_the_exponential,
    ),
    Entry(
        1,
        "order of rk4 in flight",
        "Without contact rk4 has order 4 within 0.2 down to round-off.",
        order_of_fixed_steps,
    ),
    Entry(
        1,
        "critical pair with impacts",
        "A critically damped damper pair is no special case where impacts happen either.",
        critical_contact,
    ),
    Entry(
        10,
        "soft limit",
        "With K to zero the motion tends to the linear one, however long the contacts become.",
        soft_limit,
        "K = 1e-6 N/m^1.5 is itself felt at 1e-9 of the motion; the check begins below that.",
    ),
    Entry(
        10,
        "distant wall",
        "With the clearance to infinity the steady state, its largest energy and the nearest miss "
        "are the closed forms.",
        far_wall,
    ),
    Entry(
        25,
        "resonance without damping",
        "At resonance without damping the motion grows as P t / (2 m1 omega): states and largest "
        "energies are right, though there is no steady state.",
        resonance,
        "What is growing has no steady-state maximum: E1max is that of the window sampled.",
    ),
    Entry(
        25,
        "resonance in closed form",
        "The closed form is infinite at an undamped resonance and finite at the antiresonance of "
        "an undamped absorber; it is never NaN.",
        resonance_in_closed_form,
    ),
)
