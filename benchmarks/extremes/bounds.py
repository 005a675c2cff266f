"""Numbers beyond all bounds, and numbers that are none (entries 11, 15, 24 and 28)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from benchmarks.extremes.cases import (
    FULL,
    LINEAR,
    METHODS,
    energy_of,
    error_of,
    orbit_of,
    rest_state,
    rigid_state,
    status_of,
)
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import simulate
from nlds_vines.errors import RequestError
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import IntegrationError

NAMES = ("none", "tmd", "ssul-set6", "ssbl")
"""A named system of each kind of motion: no damper, no wall, one wall, two walls."""

BEYOND = (1e156, 1e200, 1e300, 1.7e308)


def overflow() -> Finding:
    """Force and start systems beyond all bounds: every orbit must end with a status."""
    ends: list[str] = []
    for name in NAMES:
        for method in METHODS:
            for size in BEYOND:
                forced = load_system(name, P=size)
                ends.append(status_of(forced, 3, method=method))
                ends.extend(_ends_of_starts(load_system(name), size, method))
    plain = ends.count("ok")
    words = f"{len(ends)} forces and starts from 1e156 to 1.7e308: {plain} passed for a result"
    return within(plain, 0.0, words)


def _ends_of_starts(system: System, size: float, method: str) -> Iterator[str]:
    """Yield how orbits end that start with one enormous number, of either sign."""
    rest = rest_state(system)
    for row in np.vstack([np.eye(len(rest)), -np.eye(len(rest))]):
        yield status_of(system, 3, start=rest + size * row, method=method)


def overflowing_energies() -> Finding:
    """Let states be harmless and their energies overflow: recorded energies are never infinite."""
    plain, start = load_system("none", P=0.0), np.array([0.0, 1e4])
    heavy = plain.with_(**{n: plain.parameters[n] * 2.0**1000 for n in ("m1", "k1", "c1")})
    wrong = 0
    for method in METHODS:
        wrong += status_of(heavy, 3, start=start, record=LINEAR, method=method) != "diverged"
        one, other = (
            simulate(system, 3, start=start, record=("section",), method=method).state
            for system in (plain, heavy)
        )
        wrong += not np.array_equal(one, other)
    words = f"a structure of 1e304 kg at 1e4 m/s, with energies and without: {wrong} ends are wrong"
    return within(wrong, 0.0, words)


UNBOUNDED = (1e30, 1e60, 1e100, 1e200, 1e300)
LEAST_RIGID = 6
"""Orbits, of two for each stiffness, that must run: a status alone shows no rigid impact."""


def rigid_beyond_numbers() -> Finding:
    """Raise the contact stiffness to the end of the numbers: the impact becomes the rigid one."""
    worst, ran = 0.0, 0
    for K in UNBOUNDED:
        system = load_system("ssul-set6", K=K)
        for method in METHODS:
            try:
                orbit = orbit_of(system, 2, method=method, **_fine(method))
            except IntegrationError:
                continue
            ran += 1
            worst = max(worst, error_of(orbit.state, rigid_state(system, 2), system.rest or 0.0))
    words = (
        f"K from 1e30 to 1e300: {ran} of {len(METHODS) * len(UNBOUNDED)} orbits ran (at least "
        f"{LEAST_RIGID} must), {worst:.1e} from the rigid impact; the others end with a status"
    )
    return within(worst if ran >= LEAST_RIGID else math.nan, 1e-9, words)


def _fine(method: str) -> dict[str, float]:
    return {} if method == "exact" else {"period_steps": 4096.0}


def enlarged(system: System, power: int) -> System:
    """Return a system in which all lengths are 4^power times as large; K is N/m^1.5."""
    known = {**system.parameters, "K": system.K * 2.0**-power}
    lengths = {name: known[name] * 4.0**power for name in ("P", "C", "V", "D") if name in known}
    return system.with_(K=known["K"], **lengths)


def lengths() -> Finding:
    """Let motions with impacts be of any size between underflow and overflow."""
    powers, ends = (-250, -200, -100, -10, 10, 100, 200, 240), []
    errors: dict[tuple[str, str, int], float] = {}
    for name in ("ssul-set6", "ssbl"):
        system = load_system(name)
        for method in METHODS:
            plain = orbit_of(system, 6, method=method)
            for power in powers:
                other = orbit_of(enlarged(system, power), 6, method=method)
                assert other.section is not None
                found = other.section * 0.25**power
                errors[name, method, power] = error_of(found, plain.section, system.rest or 0.0)
            ends.append(status_of(enlarged(system, 255), 6, method=method))
    wrong = sum(end != "diverged" for end in ends)
    worst = max(errors, key=errors.__getitem__)
    words = (
        f"4^-250 to 4^240 (1e-151 to 1e144) times as large: {errors[worst]:.1e} "
        f"({worst[0]}, {worst[1]}, 4^{worst[2]}); at 4^255 {len(ends) - wrong} of {len(ends)} "
        "orbits end as diverged"
    )
    return within(errors[worst] + wrong, 1e-11, words)


def refused_at_the_door() -> Finding:
    """Set every parameter of every kind to what it must not be; the refusal must name it."""
    missed, count = 0, 0
    for name in NAMES:
        system = load_system(name)
        for parameter in system.scene.allowed:
            for value in (math.nan, math.inf, -math.inf, *_outside(parameter)):
                count += 1
                missed += not _refused(system, parameter, value)
    for row in np.eye(4):
        for value in (math.nan, math.inf, -math.inf):
            count += 1
            missed += not _start_refused(np.where(row > 0.0, value, 0.0))
    return within(missed, 0.0, f"{count} bad numbers: {missed} were let in or not named")


def _outside(parameter: str) -> Iterator[float]:
    """Yield finite numbers that a parameter must not have."""
    rule = PARAMETERS[parameter]
    for value in (-1.0, -5e-324, 0.0, 2.0):
        if not rule.accepts(np.asarray(value)):
            yield value


def _refused(system: System, parameter: str, value: float) -> bool:
    try:
        system.with_(**{parameter: value})
    except RequestError as error:
        return parameter in str(error)
    return False


def _start_refused(start: np.ndarray) -> bool:
    try:
        simulate(load_system("ssul-set6"), 1, start=start)
    except RequestError as error:
        return "start" in str(error)
    return False


ORBITS = 60
DECADES = 60.0
LEAST = {"ran": ORBITS, "had impacts": 10}
"""Orbits of each method, of 3 `ORBITS`, that must show something: many are refused as too stiff."""

HEAVIEST = 20.0
"""Decades by which the ratio m2 / m1 may exceed that of the named dampers, 0.06."""


def _at_random(generator: np.random.Generator, name: str) -> tuple[System, np.ndarray]:
    """Return an unforced system and a start whose numbers lie anywhere within decades."""
    system = load_system(name, P=0.0)
    chosen = ["m1", "k1", "c1", "m2", "k2", "c2", "omega", *(["K"] if system.scene.walls else [])]
    reach = generator.choice([3.0, 12.0, DECADES])
    powers = dict(zip(chosen, generator.uniform(-reach, reach, len(chosen)), strict=True))
    powers["m2"] = min(powers["m2"], powers["m1"] + HEAVIEST)
    known = {**system.parameters, **({"K": system.K} if system.scene.walls else {})}
    changes = {n: known[n] * 10.0**power for n, power in powers.items()}
    sizes = 10.0 ** generator.uniform(-3.0, 3.0, 4)
    start = rest_state(system) + sizes * generator.choice([-1.0, 1.0], 4)
    return system.with_(**changes), start


def out_of_all_proportion() -> Finding:
    """Draw systems whose parameters have nothing to do with each other."""
    generator, wrong, rise = np.random.default_rng(24), 0, 0.0
    seen: Counter[tuple[str, str]] = Counter()
    for _ in range(ORBITS):
        for name in ("tmd", "ssul-set6", "ssbl"):
            system, start = _at_random(generator, name)
            record = FULL if system.scene.walls else LINEAR
            for method in METHODS:
                try:
                    orbit = simulate(system, 3, start=start, record=record, method=method)
                except IntegrationError:
                    continue
                seen[method, "ran"] += 1
                seen[method, "had impacts"] += orbit.impacts is not None and len(orbit.impacts) > 0
                gained = _gained(system, start, orbit.section)
                wrong += not math.isfinite(gained) or not math.isfinite(float(orbit.E1max or 0.0))
                rise = max(rise, gained)
    told = "; ".join(
        f"{method}: "
        + ", ".join(f"{seen[method, what]} {what} (at least {LEAST[what]} must)" for what in LEAST)
        for method in METHODS
    )
    words = (
        f"{3 * ORBITS} unforced orbits of random systems; {told}; the others ended with a status; "
        f"gained at most {rise:.1e} of their energy, {wrong} gave no numbers"
    )
    enough = all(seen[method, what] >= LEAST[what] for method in METHODS for what in LEAST)
    return within(rise + wrong if enough else math.nan, 1e-6, words)


def _gained(system: System, start: np.ndarray, section: np.ndarray | None) -> float:
    """Return the largest share of its first energy that an orbit gains."""
    assert section is not None
    energy = energy_of(system, np.vstack([start, section]))
    return float(np.max(energy / energy[0])) - 1.0


ENTRIES = (
    Entry(
        11,
        "overflow",
        "Forces and starts from 1e156 up end with a status, of every kind of damper and by both "
        "methods; nothing that overflowed passes for a result.",
        overflow,
        "States up to 1e150 are followed: their squares must still be numbers.",
    ),
    Entry(
        11,
        "overflowing energies",
        "Where energies overflow and states do not, an orbit whose energies are recorded ends as "
        "diverged; without them the states are right.",
        overflowing_energies,
    ),
    Entry(
        11,
        "rigid beyond numbers",
        "From K = 1e30 to 1e300 N/m^1.5 an impact is the rigid one, or the orbit ends with a "
        "status.",
        rigid_beyond_numbers,
        "What a contact leaves of its own goes with K^(-2/5): 4e-10 of the motion at K = 1e30.",
    ),
    Entry(
        15,
        "refused at the door",
        "NaN, infinity and values out of range are refused before anything is computed, and the "
        "message names the parameter.",
        refused_at_the_door,
    ),
    Entry(
        24,
        "out of all proportion",
        "Parameters up to 60 decades from sensible ones end with a status or a motion that gains "
        "no energy.",
        out_of_all_proportion,
        "m2 / m1 is drawn at most 20 decades above that of the named dampers: behind an impact "
        "v2 = v1 - s, which beyond loses its digits.",
    ),
    Entry(
        28,
        "any length",
        "Motions with impacts from 1e-151 to 1e144 times the usual size are the same motion; "
        "beyond, diverged.",
        lengths,
        "Contacts are stepped by powers of their depth, which round: it is not bit by bit.",
    ),
)
