"""What conserves, what dissipates, what runs backwards (entries 4, 5, 6 and 29)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.extremes.cases import (
    BOTH,
    LINEAR,
    energy_of,
    error_of,
    orbit_of,
    order_of,
    undamped,
)
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.system import System

SAMPLES = 1 << 17  # of a period in which powers are integrated
PERIODS = 5
PUSHED = 0.3  # [m/s] speed of the structure at the start of the free motions below
CONSERVING: dict[str, Any] = {"nodes": 20, "contact_steps": 60.0}
"""Settings at which contacts of every kind lose nothing."""


def _powers(system: System, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return the power [W] of force and dashpots at some states."""
    p, (_, v1, _, v2) = system.parameters, states.T
    drive = p["P"] * np.cos(p["omega"] * times) * v1
    return drive - p["c1"] * v1**2 - p["c2"] * (v1 - v2) ** 2


def ledger(system: System, energies: Any) -> np.ndarray:
    """Return what is missing in the ledger of an orbit from rest, by way of computing it.

    Arguments: `energies`, the mechanical energy [J] after `PERIODS` periods, by any method.
    The work of the force and what the dashpots took are Simpson's sums over a dense trajectory of
    the exact method, in which every contact is stepped.  Relative to all the power that flowed.
    """
    dense = simulate(system, PERIODS, record=("trajectory", "impacts"), samples=SAMPLES)
    assert dense.trajectory is not None
    assert dense.time is not None
    first = np.array([[0.0, 0.0, system.rest, 0.0]])
    power = _powers(system, np.append(0.0, dense.time), np.vstack([first, dense.trajectory]))
    weights = np.full(len(power), 2.0)
    weights[1::2], weights[[0, -1]] = 4.0, 1.0
    weights *= system.period / SAMPLES / 3.0
    work, scale = float(weights @ power), float(weights @ np.abs(power))
    start = float(energy_of(system, first)[0])
    return np.abs(np.asarray(energies) - start - work) / scale


def _last_energies(system: System, settings: list[dict[str, Any]]) -> list[float]:
    runs = (orbit_of(system, PERIODS, **options) for options in settings)
    return [float(energy_of(system, run.section)[-1]) for run in runs if run.section is not None]


def exact_ledger() -> Finding:
    """Close the ledger of the exact method with its default settings, short and soft contacts."""
    missing = {}
    for K in (1e4, 1e6, 3.25e7, 1e12):
        system = load_system("ssul-set6", K=K)
        missing[K] = float(ledger(system, _last_energies(system, [{}]))[0])
    worst = max(missing, key=missing.__getitem__)
    words = f"K from 1e4 to 1e12: what is missing is {missing[worst]:.1e} of what flowed"
    return within(missing[worst], 1e-8, words)


def order_of_the_ledger() -> Finding:
    """Close the ledger of rk4, step by step: what is missing goes down with order four."""
    system, steps = load_system("ssul-set6"), [256.0, 512.0, 1024.0, 2048.0, 4096.0]
    settings = [{"method": "rk4", "period_steps": n} for n in steps]
    missing = ledger(system, _last_energies(system, settings))
    order = order_of(missing, steps)
    words = f"from {missing[0]:.1e} to {missing[-1]:.1e}, order {order:.2f}"
    return within(max(4.0 - order, 0.0) if missing[-1] < 1e-8 else math.nan, 0.3, words)


def _drift(system: System, start: np.ndarray, periods: int, **options: Any) -> tuple[float, int]:
    """Return the largest change of energy, relative to it, and the number of impacts."""
    orbit = orbit_of(system, periods, start=start, **options)
    assert orbit.section is not None
    energy = energy_of(system, np.vstack([start, orbit.section]))
    impacts = 0 if orbit.impacts is None else len(orbit.impacts)
    return float(np.abs(energy / energy[0] - 1.0).max()), impacts


def _pushed(system: System) -> np.ndarray:
    return np.array([0.0, PUSHED, system.rest, 0.0])


def conserved_in_flight() -> Finding:
    """Let a damper without walls swing for 1e5 periods."""
    system = undamped("tmd")
    drift, _ = _drift(system, _pushed(system), 100_000)
    return within(drift, 1e-9, f"over 1e5 periods the energy moves by {drift:.1e} of itself")


def conserved_in_short_impacts() -> Finding:
    """Let dampers strike steel for 1e5 periods with the default settings."""
    worst, count = 0.0, 0
    for K in (1e12, 1e16):
        system = undamped("ssul-set6", K=K)
        drift, impacts = _drift(system, _pushed(system), 100_000)
        worst, count = max(worst, drift), count + impacts
    words = f"over 1e5 periods and {count} impacts the energy moves by {worst:.1e} of itself"
    return within(worst if count > 0 else math.nan, 1e-9, words)


def conserved_in_all_contacts() -> Finding:
    """Let dampers strike soft and hard walls for 1e5 periods with the finer settings."""
    drifts, counts = {}, 0
    for K in (1e3, 1e6, 3.25e7, 1e9):
        system = undamped("ssul-set6", K=K)
        drifts[K], impacts = _drift(system, _pushed(system), 100_000, **CONSERVING)
        counts += impacts
    worst = max(drifts, key=drifts.__getitem__)
    words = f"over 1e5 periods and {counts} contacts at most {drifts[worst]:.1e} (K = {worst:g})"
    return within(drifts[worst], 1e-9, words)


def conserved_by_default() -> Finding:
    """Measure what the default settings lose in 1e5 periods of long and slow contacts."""
    drifts = {}
    for K in (1e5, 1e6, 3.25e7, 1e9, 1e10):
        system = undamped("ssul-set6", K=K)
        drifts[K], _ = _drift(system, _pushed(system), 100_000)
    words = ", ".join(f"{drift:.1e} at K = {K:g}" for K, drift in drifts.items())
    return within(max(drifts.values()), 1e-6, f"over 1e5 periods the energy moves by {words}")


def conserved_by_rk4() -> Finding:
    """Fit the order with which rk4 loses energy."""
    system, steps = undamped("ssul-set6"), [256.0, 512.0, 1024.0, 2048.0]
    start = _pushed(system)
    drifts = [_drift(system, start, 300, method="rk4", period_steps=n)[0] for n in steps]
    order = order_of(drifts, steps)
    words = f"over 300 periods from {drifts[0]:.1e} to {drifts[-1]:.1e}, order {order:.1f}"
    return within(4.0 - order, 0.2, words)


def _reversed(states: np.ndarray) -> np.ndarray:
    return np.asarray(states) * [1.0, -1.0, 1.0, -1.0]


def _return_error(system: System, start: np.ndarray, periods: int, **options: Any) -> float:
    """Return how far an orbit misses its start when it is run there and back.

    The force is even in time about every section, so that it does not spoil the reversal.
    """
    there = orbit_of(system, periods, start=start, **options)
    back = orbit_of(system, periods, start=_reversed(there.state), **options)
    return error_of(_reversed(back.state), start, system.rest or 0.0, there.section)


def reversal_in_flight() -> Finding:
    """Run an undamped forced motion there and back."""
    system = undamped("tmd", P=800.0)
    wrong = _return_error(system, np.array([0.01, -0.2, 0.03, 0.4]), 1000)
    return within(wrong, 1e-9, f"after 1000 periods there and 1000 back {wrong:.1e} is left over")


REGULAR = {
    "short impacts": {"K": 1e12},
    "as tabulated": {},
    "soft contacts": {"K": 1e4},
    "preloaded": {"C": -0.001, "K": 1e4},
}
"""Undamped motions that neighbours leave slowly: nothing amplifies a rounding error."""


def reversal_with_impacts() -> Finding:
    """Run undamped motions with impacts there and back."""
    errors = {}
    for name, changes in REGULAR.items():
        system = undamped("ssul-set6", **changes)
        start = np.array([0.0, 0.02, system.rest, 0.6])
        errors[name] = _return_error(system, start, 100, **CONSERVING)
    worst = max(errors, key=errors.__getitem__)
    words = (
        f"after 100 periods there and 100 back at most {errors[worst]:.1e} is left over ({worst})"
    )
    return within(errors[worst], 1e-9, words)


def _fall(rise: float) -> str:
    """Return in words by how much an energy rises at most, or falls at least."""
    if rise > 0.0:
        return f"the energy rises by at most {rise:.1e} of itself"
    return f"the energy falls by at least {-rise:.1e} of itself"


def never_rises() -> Finding:
    """Follow damped motions without a force: the energy never rises, by any method."""
    rises = -math.inf
    for name, changes in (
        ("ssul-set6", {}), ("ssul-set6", {"C": -0.01}), ("ssul-set6", {"c2": 0.0, "K": 1e4}),
        ("ssul-set6", {"c1": 0.0, "c2": 1e-3}),
    ):  # fmt: skip
        system = load_system(name, P=0.0, **changes)
        for method in ("exact", "rk4"):
            start = np.array([0.02, 0.5, system.rest, -0.4])
            states = simulate(system, 60, start=start, record=BOTH, method=method).section
            assert states is not None
            energy = energy_of(system, np.vstack([start, states]))
            rises = max(rises, float(np.max(energy[1:] / energy[:-1])) - 1.0)
    return within(rises, 1e-10, f"from section to section {_fall(rises)}")


def never_rises_in_flight() -> Finding:
    """Follow a free, hardly damped motion of the damper without walls for 1e4 periods."""
    system = load_system("tmd", P=0.0, c1=1e-6, c2=0.0)
    start = np.array([0.02, 0.5, 0.0, -0.4])
    states = simulate(system, 10_000, start=start, record=LINEAR).section
    assert states is not None
    energy = energy_of(system, np.vstack([start, states]))
    rise = float(np.max(energy[1:] / energy[:-1])) - 1.0
    return within(rise, 1e-13, f"in each of 1e4 periods {_fall(rise)}")


_LIMIT = (
    "A contact may err by the tolerance, and so may its energy: `contact_steps=60` and `nodes=20` "
    "bring any contact to round-off."
)

ENTRIES = (
    Entry(
        4,
        "energy ledger",
        "Energy gained is work done less what the dashpots took, to 1e-8, with the default "
        "settings.",
        exact_ledger,
    ),
    Entry(
        4,
        "ledger of rk4",
        "Of rk4 what is missing in the ledger goes down at order 4 and below 1e-8.",
        order_of_the_ledger,
    ),
    Entry(
        5,
        "conservation in flight",
        "Undamped and unforced, 1e5 periods without contact move the energy by less than 1e-9.",
        conserved_in_flight,
    ),
    Entry(
        5,
        "conservation on steel",
        "Undamped and unforced, 1e5 periods of short impacts move the energy by less than 1e-9, "
        "with the default settings.",
        conserved_in_short_impacts,
    ),
    Entry(
        5,
        "conservation in any contact",
        "Undamped and unforced, 1e5 periods of soft and hard contacts move the energy by less "
        "than 1e-9 with 20 nodes and 60 steps.",
        conserved_in_all_contacts,
    ),
    Entry(
        5,
        "conservation by default",
        "With the default settings 1e5 periods of slow and soft contacts move the energy by less "
        "than 1e-6.",
        conserved_by_default,
        _LIMIT,
    ),
    Entry(
        5,
        "conservation by rk4",
        "rk4 loses energy at order 4 or higher.",
        conserved_by_rk4,
        "The classical method damps: by about (omega h)^5 a period, whatever the physics says.",
    ),
    Entry(
        6,
        "reversal in flight",
        "An undamped forced motion without contact, run back, returns to 1e-9.",
        reversal_in_flight,
    ),
    Entry(
        6,
        "reversal with impacts",
        "An undamped regular motion with impacts, run back, returns to 1e-9 with 20 nodes and 60 "
        "steps.",
        reversal_with_impacts,
        "The defaults are good to 1e-10 an impact and return to about 1e-7. Irregular motions "
        "amplify the last bit: no method with 16 digits returns from them.",
    ),
    Entry(
        29,
        "damped energy",
        "Without a force, damped motions never gain energy, by any method.",
        never_rises,
        "Where a dashpot takes less than the settings' error of a contact, only the latter shows.",
    ),
    Entry(
        29,
        "damped energy in flight",
        "Without a force, a flight gains no more than round-off.",
        never_rises_in_flight,
    ),
)
