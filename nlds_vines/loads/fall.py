"""What becomes of one structure under a load: histories, last times, where the energy goes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.kernels.scene.codes import OK
from nlds_vines.loads.request import Decay, natural_period, struck
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.load_quantities import OF_LOADS, SHARES, WAYS
from nlds_vines.model.loads.loading import Cells, Loading
from nlds_vines.model.loads.series import polynomial
from nlds_vines.model.system import System
from nlds_vines.orbits.load_flight import C1, C2, CONTACT, LOAD, Flown, fly, longest_cell
from nlds_vines.orbits.signals import energy_of_damper, energy_of_structure

CAPTURED = 1.99
"""Impacts in a natural period, of two walls, from which on the motion counts as captured."""

ZOOM, LEVELS = 64, 2
"""Each level of a search for a last time divides a sample interval by so many."""

RECORD = ("states", "work", "impacts", "energy", "response")


@dataclass(frozen=True)
class Fall:
    """What becomes of one structure under a load.

    Arrays over `time` (n,) [s]: energies E1, E2 [J], displacements x1, x2 [m], `work`, the energy
    [J] that came in so far, and `dissipated`, what is gone so far, by `WAYS`.  What there is not
    without a damper, or without walls, is NaN.  `numbers`: those of `OF_LOADS`; `status`: how the
    orbit ended, a code of `STATUS`; all else is NaN where it failed.
    """

    time: np.ndarray
    E1: np.ndarray
    E2: np.ndarray
    x1: np.ndarray
    x2: np.ndarray
    work: np.ndarray
    dissipated: Mapping[str, np.ndarray]
    numbers: Mapping[str, float]
    status: int = OK

    @property
    def last(self) -> np.ndarray:
        """The last times (3,) [s] at which E1 exceeds `SHARES` of its largest; NaN: it does."""
        return np.array([self.numbers[f"last_{100 * share:g}"] for share in SHARES])


HISTORIES = {
    "E1": ("J", "energy of the structure"),
    "E2": ("J", "energy of the damper"),
    "x1": ("m", "displacement of the structure"),
    "x2": ("m", "displacement of the damper"),
    "work": ("J", "energy that came in so far, by the start and by the load"),
}
"""What is told over time, with its unit and its meaning."""


def failed(time: np.ndarray, status: int) -> Fall:
    """Return what is told of an orbit that ended early: nothing."""
    nothing = np.full(len(time), np.nan)
    return Fall(
        time=time,
        dissipated=dict.fromkeys(WAYS, nothing),
        numbers={entry.name: math.nan for entry in OF_LOADS},
        status=status,
        **dict.fromkeys(HISTORIES, nothing),
    )


def fall_of(request: Decay, system: System, load: Loading) -> Fall:
    """Return what becomes of a structure under a load.

    Raises `IntegrationError` where the orbit ends early.

    One exact flight has an edge at each time of the histories; work and dissipated energies are
    integrals over its pieces.  The last times are found to round-off, within the sample interval in
    which E1 is last above a share.
    Cost: some milliseconds for a minute of the paper's structure.
    """
    time = request.times
    cells = load.cells(struck(system), request.duration, longest_cell(system), time[1:-1])
    flown = flight(request, system, cells, request.state or None)
    assert flown.states is not None
    assert flown.work is not None
    places = np.searchsorted(cells.edges, time * (1.0 - 1e-14))
    states, work = flown.states[places], flown.work[places]
    E1, nothing = energy_of_structure(system, states), np.full(len(time), np.nan)
    damped, walls = system.scene.damper, bool(system.scene.walls)
    begin = energy_at_start(request, system)
    there = {"c1": True, "c2": damped, "contact": walls}
    dissipated = {
        way: work[:, column] if there[way] else nothing
        for way, column in zip(WAYS, (C1, C2, CONTACT), strict=True)
    }
    return Fall(
        time=time,
        E1=E1,
        E2=energy_of_damper(system, states) if damped else nothing,
        x1=states[:, 0],
        x2=states[:, 2] if damped else nothing,
        work=begin + work[:, LOAD],
        dissipated=dissipated,
        numbers=_numbers(request, system, cells, flown, begin, states, time),
    )


def flight(request: Decay, system: System, cells: Cells, start: Any) -> Flown:
    """Return the flight of a system through cells; every one records the same."""
    record = [word for word in RECORD if word != "impacts" or system.scene.walls]
    return fly(system, cells, start=start, record=record, tolerance=request.tolerance, quiet=True)


def states_of(flown: Flown) -> np.ndarray:
    """Return the states at the edges of a flight, which each of these records."""
    assert flown.states is not None
    return flown.states


def energy_at_start(request: Decay, system: System) -> float:
    """Return the energy [J] that a start has which is not at rest."""
    if not request.state:
        return 0.0
    state = np.array([request.state])
    return float(energy_of_structure(system, state)[0] + _stored(system, state)[0])


def _stored(system: System, states: np.ndarray) -> np.ndarray:
    """Return the energy [J] of the damper's motion and in its stretched spring.

    E2 is not that: it counts from the damper's place of rest (equation (6)).
    """
    if not system.scene.damper:
        return np.zeros(len(states))
    p, stretch = system.parameters, states[:, 2] - states[:, 0] - (system.rest or 0.0)
    return np.asarray(0.5 * (p["m2"] * states[:, 3] ** 2 + p["k2"] * stretch**2))


# ---- numbers -------------------------------------------------------------------------------------


def _numbers(
    request: Decay, system: System, cells: Cells, flown: Flown, begin: float,
    states: np.ndarray, time: np.ndarray,
) -> dict[str, float]:  # fmt: skip
    """Return all numbers of `OF_LOADS`; what there is not is NaN."""
    assert flown.states is not None
    assert flown.work is not None
    found = dict.fromkeys((entry.name for entry in OF_LOADS), math.nan)
    response = flown.response or {}
    found |= {name: float(np.max(response[name])) for name in found.keys() & response.keys()}
    most = flown.E1max or 0.0
    last = {share: _last_above(request, system, cells, flown, share * most) for share in SHARES}
    found |= {f"last_{100 * share:g}": when for share, when in last.items()}
    touches = np.zeros(0) if flown.impacts is None else np.sort(flown.impacts["touch"])
    period, came = natural_period(system), begin + flown.work[:, LOAD]
    E1 = energy_of_structure(system, states)
    fell = last[0.1] - float(time[E1.argmax()])
    gone = flown.work[:, C1] + flown.work[:, C2] + flown.work[:, CONTACT]
    left = energy_of_structure(system, flown.states) + _stored(system, flown.states)
    free, scale = ~_in_contact(cells.edges, flown), float(np.abs(came).max())
    ways = zip(WAYS, (C1, C2, CONTACT), strict=True)
    found |= {
        "E1max": most,
        "E2max": math.nan if flown.E2max is None else flown.E2max,
        "damping_ratio": math.log(10.0) / (4 * math.pi * fell / period) if fell > 0 else math.nan,
        "impacts": float(len(touches)) if system.scene.walls else math.nan,
        "energy_in": float(came[-1]),
        "balance": float(np.abs(came - left - gone)[free].max(initial=0.0)) / scale
        if scale
        else 0.0,
        **{f"share_{way}": float(flown.work[-1, c]) / float(came[-1]) for way, c in ways},
    }
    if not system.scene.damper:
        found |= {"share_c2": math.nan}
    if not system.scene.walls:
        found |= {"share_contact": math.nan}
    else:
        found |= captures(touches, len(system.scene.walls), period, request.duration)
    return found | (passages(states[:, 0], time, request.level) if request.level else {})


def _in_contact(times: np.ndarray, flown: Flown) -> np.ndarray:
    """Return which times (m,) [s] lie within a contact, whose energy is neither body's."""
    if flown.impacts is None or not len(flown.impacts):
        return np.zeros(len(times), bool)
    touch, release = flown.impacts["touch"], flown.impacts["release"]
    which = np.searchsorted(touch, times, side="right") - 1  # contacts follow one another
    return np.asarray((which >= 0) & ~(release[which] <= times))


def _last_above(request: Decay, system: System, cells: Cells, flown: Flown, level: float) -> float:
    """Return the last time [s] at which E1 exceeds a level; NaN where it does at the end.

    Within the interval between edges the motion is a Taylor polynomial, unless there is a contact:
    then it is followed again, between edges that are closer.
    """
    states = flown.states
    assert states is not None
    above = np.flatnonzero(energy_of_structure(system, states) > level)
    if not len(above) or above[-1] == len(states) - 1:
        return math.nan
    place = int(above[-1])
    begin, width = float(cells.edges[place]), float(cells.edges[place + 1] - cells.edges[place])
    at, row, touched = states[place], cells.rows[place], _has_contact(begin, width, flown)
    motion = None if touched else motion_in_cell(system, at, row, width, cells.share)
    low, high = 0.0, 1.0
    for _ in range(LEVELS):
        x = low + (high - low) * np.arange(ZOOM + 1) / ZOOM
        if motion is None:
            finer = _divided(row, width * (high - low), cells.share)
            passed = states_of(flight(request, system, finer, at))
        else:
            passed = np.add.reduce([c * (x**k)[:, None] for k, c in enumerate(motion)])
        energies = energy_of_structure(system, passed)
        place = int(np.flatnonzero(energies > level)[-1])
        if place == ZOOM:
            return begin + width * high
        if motion is None:
            at, row = passed[place], finer.rows[place]
        low, high = float(x[place]), float(x[place + 1])
    over, under = energies[place] - level, level - energies[place + 1]
    return begin + width * (low + (high - low) * float(over / (over + under)))


def motion_in_cell(
    system: System, state: np.ndarray, row: np.ndarray, width: float, share: float = 1.0
) -> list[np.ndarray]:
    """Return the Taylor coefficients of the state over a cell without contact, by x from 0 to 1.

    z' = A z + b f: (k + 1) z(k + 1) = width (A z(k) + b f(k)); f a force on m1, or with a `share`
    of 0 the same push on all masses.
    """
    flow, size = flow_matrix(system), len(state)
    A, mass = flow[:size, :size], system.structure[0]
    rest = np.array([0.0, 0.0, system.rest or 0.0, 0.0])[:size]
    found = [state - rest]
    for k, force in enumerate(row):
        push = np.zeros(size)
        push[1 if share else slice(1, None, 2)] = force / mass
        found.append(width * (A @ found[-1] + push) / (k + 1))
    found[0] = state
    return found


def _has_contact(begin: float, width: float, flown: Flown) -> bool:
    """Tell whether a contact lies in an interval, in part or as a whole."""
    if flown.impacts is None:
        return False
    touch, release = flown.impacts["touch"], flown.impacts["release"]
    return bool(((touch <= begin + width) & ~(release < begin)).any())


def _divided(row: np.ndarray, width: float, share: float) -> Cells:
    """Return `ZOOM` cells of one, which begin at 0."""
    x = np.arange(ZOOM) / ZOOM
    rows = polynomial(np.tile(row, (ZOOM, 1)), x, np.full(ZOOM, 1.0 / ZOOM))
    return Cells(np.linspace(0.0, width, ZOOM + 1), rows, None, share)


def captures(touches: np.ndarray, walls: int, period: float, duration: float) -> dict[str, float]:
    """Return how long 1:1 resonance lasts [s], when it begins and when it ends.

    It is the longest stretch in which one impact on each wall follows within a natural period,
    lengthened by half a per cent: `CAPTURED`.  It has no end where it lasts to that of the orbit.
    """
    longest = 2.0 / CAPTURED * period
    within = touches[walls:] - touches[:-walls] <= longest
    edges = np.flatnonzero(np.diff(np.concatenate([[False], within, [False]]).astype(int)))
    if not len(edges):
        return {"captured": 0.0, "capture": math.nan, "escape": math.nan}
    begins, ends = touches[edges[::2]], touches[edges[1::2] + walls - 1]
    i = int(np.argmax(ends - begins))
    lasts = ends[i] == touches[-1] and duration - ends[i] <= longest
    return {
        "captured": float(ends[i] - begins[i]),
        "capture": float(begins[i]),
        "escape": math.nan if lasts else float(ends[i]),
    }


def passages(x1: np.ndarray, time: np.ndarray, level: float) -> dict[str, float]:
    """Return when abs(x1) first exceeds a level, how often it does, and for which share of time.

    Between samples the displacement is a straight line.
    """
    over = np.abs(x1) - level
    up = np.flatnonzero((over[:-1] <= 0.0) & (over[1:] > 0.0))
    share = np.clip(over[:-1] / np.where(over[:-1] == over[1:], 1.0, over[:-1] - over[1:]), 0, 1)
    below = np.where(over[:-1] > 0, np.where(over[1:] > 0, 0.0, 1 - share),
                     np.where(over[1:] > 0, share, 1.0))  # fmt: skip
    steps = np.diff(time)
    first = math.nan
    if over[0] > 0.0:
        first = float(time[0])
    elif len(up):
        first = float(time[up[0]] + share[up[0]] * steps[up[0]])
    lasted = float(time[-1] - time[0])
    return {
        "first_passage": first,
        "crossings": len(up) / lasted,
        "above": 1.0 - float((below * steps).sum()) / lasted,
    }
