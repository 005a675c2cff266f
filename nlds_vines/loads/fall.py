"""How the energy of one structure falls after a blow: its history, its last times, its dissipation.

The orbit is followed over windows of time as others are over forcing periods: without a force the
frequency means nothing but their length.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.kernels.scene.codes import OK
from nlds_vines.loads.request import Decay, mass_of, spring_of
from nlds_vines.model.system import System
from nlds_vines.orbits.signals import energy_of_damper, energy_of_structure
from nlds_vines.orbits.simulation import Orbit, simulate

SHARES = (0.01, 0.1, 0.5)
"""The shares of the largest E1 of which the last times are told."""

WAYS = ("c1", "c2", "contact")
"""Where the energy goes: the dashpots, and what contacts dissipate."""

CAPTURED = 1.99
"""Impacts in a natural period from which on the motion counts as captured in 1:1 resonance."""

ZOOM, LEVELS = 64, 4
"""Each level of a search for a last time divides an interval by so many; four reach round-off."""


@dataclass(frozen=True)
class Fall:
    """What becomes of one structure after the blow.

    Arrays over `time` (n,) [s]: energies E1, E2 [J], displacements x1, x2 [m]; over `ends` (m,)
    [s], ends of windows: `dissipated`, the energy [J] gone so far, by `WAYS`.  What there is not
    without a damper, or without walls, is NaN.  `last`: the last times [s] at which E1 exceeds
    `SHARES` of its largest value, NaN where it still does at the end; `numbers`: largest values by
    the names of a response, `impacts`, `captured` [s], `energy_in` [J], `damping_ratio`, `balance`;
    `status`: how the orbit ended, a code of `STATUS`; all else is NaN where it failed.
    """

    time: np.ndarray
    E1: np.ndarray
    E2: np.ndarray
    x1: np.ndarray
    x2: np.ndarray
    ends: np.ndarray
    dissipated: Mapping[str, np.ndarray]
    last: np.ndarray
    numbers: Mapping[str, float]
    status: int = OK


def fall_of(request: Decay, system: System, check: Callable[[], None] = lambda: None) -> Fall:
    """Return what becomes of a structure; `check` is called now and then, and may raise.

    Raises `IntegrationError` where the orbit ends early.

    The dissipated energies are sums of mean powers over windows times their length, integrals over
    the pieces of the motion that the kernels form; the last times are found to round-off within the
    sample interval in which E1 is last above a share.
    Cost: two runs over the windows, some 20 ms for a minute of the paper's structure.
    """
    length = request.duration / request.windows
    still = system.with_(omega=2 * math.pi / length)
    start = _start(request, still)
    walls, windows = bool(still.scene.walls), request.windows
    record = ["trajectory", "energy", "response", *(["impacts"] if walls else [])]

    def follow(begin: np.ndarray, periods: int, what: list[str], samples: int = 1) -> Orbit:
        check()
        return simulate(
            still, periods, start=begin, record=what, tolerance=request.tolerance,
            samples=samples, quiet=True,
        )  # fmt: skip

    whole = follow(start, windows, record, request.samples)
    assert whole.trajectory is not None
    states, time, ends = np.vstack([start, whole.trajectory]), request.times, request.ends
    E1 = energy_of_structure(still, states)
    begins = states[: -1 : request.samples]
    powers = [follow(begin, 1, ["response"]).response or {} for begin in begins]
    gone = {
        way: np.cumsum([of.get(f"power_{way}", math.nan) * length for of in powers]) for way in WAYS
    }
    most = max(E1[0], whole.E1max or 0.0)
    last = np.array([_last_above(still, request, states, time, share * most) for share in SHARES])
    damped, tenth = still.scene.damper, last[SHARES.index(0.1)]
    nothing = np.full(len(time), np.nan)
    touches = np.zeros(0) if whole.impacts is None else np.sort(whole.impacts["touch"])
    left = E1 + (_stored(still, states) if damped else 0.0)
    dissipated = sum(np.nan_to_num(energies) for energies in gone.values())
    missing = left[0] - left[request.samples :: request.samples] - dissipated
    free = ~_in_contact(ends, whole)
    found = whole.response or {}
    names = ("x1_max", "v1_max", "a1_max", "stroke_max", "force_max", "impulse_max")
    numbers = {name: float(np.max(found.get(name, math.nan))) for name in names}
    return Fall(
        time=time,
        E1=E1,
        E2=energy_of_damper(still, states) if damped else nothing,
        x1=states[:, 0],
        x2=states[:, 2] if damped else nothing,
        ends=ends,
        dissipated=gone,
        last=last,
        numbers={
            **numbers,
            "impacts": float(len(touches)),
            "captured": _captured(touches, _own_period(still)),
            "energy_in": float(E1[0]),
            "balance": float(np.max(np.abs(missing[free]), initial=0.0)) / float(E1[0]),
            "damping_ratio": math.log(10.0) / (4 * math.pi * tenth / _own_period(still)),
        },
    )


def _stored(system: System, states: np.ndarray) -> np.ndarray:
    """Return the energy [J] of the damper's motion and in its stretched spring.

    E2 is not that: it counts from the damper's place of rest (equation (6)).
    """
    p, stretch = system.parameters, states[:, 2] - states[:, 0] - (system.rest or 0.0)
    return np.asarray(0.5 * (p["m2"] * states[:, 3] ** 2 + p["k2"] * stretch**2))


def _in_contact(times: np.ndarray, orbit: Orbit) -> np.ndarray:
    """Return which times (m,) [s] lie within a contact, whose energy is neither body's."""
    if orbit.impacts is None or not len(orbit.impacts):
        return np.zeros(len(times), bool)
    touch, release = orbit.impacts["touch"], orbit.impacts["release"]
    within = (touch <= times[:, None]) & ~(release <= times[:, None])
    return np.asarray(within.any(axis=1))


def _own_period(system: System) -> float:
    """Return the natural period of the structure alone [s], undamped."""
    p = system.parameters
    return 2 * math.pi * math.sqrt(p[mass_of(system)] / p[spring_of(p)])


def _start(request: Decay, system: System) -> np.ndarray:
    """Return the state just after the blow, the damper where its spring rests."""
    velocity = request.impulse / system.parameters[mass_of(system)]
    damper = (system.rest or 0.0, 0.0) if system.scene.damper else ()
    return np.array([0.0, velocity, *damper])


def _last_above(
    system: System, request: Decay, states: np.ndarray, time: np.ndarray, level: float
) -> float:
    """Return the last time [s] at which E1 exceeds a level; NaN where it does at the end."""
    above = np.flatnonzero(energy_of_structure(system, states) > level)
    if above[-1] == len(states) - 1:
        return math.nan
    at, begin, width = states[above[-1]], float(time[above[-1]]), float(np.diff(time).max())
    for _ in range(LEVELS):
        near = system.with_(omega=2 * math.pi / width)
        orbit = simulate(
            near, 1, start=at, record=["trajectory"], tolerance=request.tolerance,
            samples=ZOOM, quiet=True,
        )  # fmt: skip
        assert orbit.trajectory is not None
        finer = np.vstack([at, orbit.trajectory])
        place = int(np.flatnonzero(energy_of_structure(near, finer) > level)[-1])
        if place == ZOOM:
            return begin + width
        at, begin, width = finer[place], begin + place * width / ZOOM, width / ZOOM
    return begin + width / 2


def _captured(touches: np.ndarray, period: float) -> float:
    """Return how long [s] the damper strikes twice in each natural period, from the first touch on.

    That is from the first touch until the first gap in which two impacts take more than a period
    by half a per cent: `CAPTURED`.
    """
    if len(touches) < 3:
        return 0.0
    slow = np.flatnonzero(touches[2:] - touches[:-2] > 2.0 / CAPTURED * period)
    end = touches[slow[0] + 1] if slow.size else touches[-1]
    return float(end - touches[0]) if not slow.size or slow[0] > 0 else 0.0
