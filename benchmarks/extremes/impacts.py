"""Single impacts and their limits: Hertz's law, the rigid wall, grazing (entries 2, 3, 8 and 9)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.special import beta

from benchmarks.extremes.cases import (
    BOTH,
    FINE,
    METHODS,
    error_of,
    orbit_of,
    order_of,
    rigid_state,
    shortening,
    stored_state,
    touching_state,
)
from benchmarks.extremes.entry import Entry, Finding, within
from benchmarks.extremes.reference import follow
from nlds_vines import simulate
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import steady_state
from nlds_vines.model.system import System

DURATION = 0.8 * float(beta(0.4, 0.5))  # of a free impact, in units of depth / speed: 2.9433


def order_across_contacts() -> Finding:
    """Fit the order of rk4 over orbits with impacts, Set 6, against stored states."""
    steps = [1448.0, 2048.0, 2896.0, 4096.0, 5792.0, 8192.0]
    orders = []
    for omega in (6.28, 7.45):
        system = load_system("ssul-set6", omega=omega)
        exact = stored_state(system, 5)
        runs = (orbit_of(system, 5, method="rk4", period_steps=n).state for n in steps)
        orders.append(order_of([error_of(run, exact) for run in runs], steps))
    worst = max(abs(order - 4.0) for order in orders)
    words = " and ".join(f"{order:.2f}" for order in orders)
    return within(worst, 0.2, f"orders {words} over orbits of stored digits")


def order_of_stepped_contacts() -> Finding:
    """Fit the order of the exact method in its number of steps, through contacts it steps.

    No digits are stored of such an orbit: a refinement stands for the truth, if SciPy confirms it.
    """
    system = load_system("ssul-set6", K=1e6)
    exact, steps = orbit_of(system, 3, **FINE), [5.0, 6.0, 7.0, 8.0, 10.0, 12.0]
    assert exact.impacts is not None
    confirmed = error_of(follow(system, 3).section[-1], exact.state)
    runs = [orbit_of(system, 3, contact_steps=n) for n in steps]
    order = order_of([error_of(run.state, exact.state) for run in runs], steps)
    enough = len(exact.impacts) > 0 and confirmed <= 1e-9
    words = (
        f"order {order:.1f} over {len(exact.impacts)} stepped contacts, against a refinement that "
        f"SciPy confirms to {confirmed:.0e}"
    )
    return within(max(14.0 - order, 0.0) if enough else math.nan, 0.4, words)


def nodes_of_short_impacts() -> Finding:
    """Fit how fast the nodes of a short impact make the exact method converge to stored states."""
    system, nodes = load_system("ssul-set6"), [5, 6, 7, 8, 9, 10, 11, 12, 13]
    exact = stored_state(system, 5)
    runs = (orbit_of(system, 5, nodes=n, contact_steps=200.0) for n in nodes)
    errors = [error_of(run.state, exact) for run in runs]
    factor = math.exp(-float(np.polyfit(nodes, np.log(errors), 1)[0]))
    words = f"each node divides the error by {factor:.1f}; 12 nodes leave {errors[-2]:.1e}"
    return within(4.0 / factor, 1.0, words)


def _free(K: float, speed: float) -> tuple[System, float, float, float]:
    """Return a system of masses alone about to touch, and its reduced mass, depth and duration."""
    system = load_system("ssul-set6")
    m1, m2 = system.parameters["m1"], system.parameters["m2"]
    mu = m1 * m2 / (m1 + m2)
    depth = (5.0 * mu * speed**2 / (4.0 * K)) ** 0.4
    lasting = DURATION * depth / speed
    nothing = {"k1": 0.0, "c1": 0.0, "k2": 0.0, "c2": 0.0, "P": 0.0}
    return system.with_(K=K, omega=2.0 * math.pi / (3.0 * lasting), **nothing), mu, depth, lasting


def hertz_impact() -> Finding:
    """Compare depth, force, duration and release of free impacts with their closed forms."""
    worst, count = 0.0, 0
    for method, options in (("exact", {}), ("rk4", {"period_steps": 4096.0})):
        for K in (1e-6, 1.0, 1e6, 1e11, 1e16):
            for speed in (1e-6, 1e-2, 1.0, 30.0):
                system, mu, depth, lasting = _free(K, speed)
                start = touching_state(system, speed)
                orbit = orbit_of(system, 1, start=start, method=method, **options)
                assert orbit.impacts is not None
                if len(orbit.impacts) != 1:
                    return within(math.nan, 1e-10, f"{len(orbit.impacts)} impacts, not one")
                hit = orbit.impacts[0]
                share = mu / system.parameters["m1"]
                ratios = (
                    hit["depth"] / depth,
                    hit["force"] / (K * depth**1.5),
                    (hit["release"] - hit["touch"]) / lasting,
                    orbit.state[1] / (-2.0 * share * speed),
                )
                worst = max(worst, *(abs(ratio - 1.0) for ratio in ratios))
                count += 1
    words = f"{count} impacts, K from 1e-6 to 1e16, 1e-6 to 30 m/s: relative error {worst:.1e}"
    return within(worst, 1e-10, words)


def rigid_limit() -> Finding:
    """Let K go to infinity: the elastic impact, approached as K^(-2/5)."""
    stiffness, differences = [10.0**n for n in range(9, 18, 2)], []
    for K in stiffness:
        system = load_system("ssul-set6", K=K)
        orbit = orbit_of(system, 2)
        differences.append(float(np.abs(orbit.state - rigid_state(system, 2)).max()))
    slope = -order_of(differences, stiffness)
    words = f"the slope is {slope:.3f}; at K = 1e17 the states differ by {differences[-1]:.1e}"
    return within(abs(slope + 0.4), 0.01, words)


def _grazing(shift: float) -> tuple[System, np.ndarray]:
    """Return a system whose steady motion turns at the wall but for a relative `shift`."""
    system = load_system("ssul-set6", omega=9.0)
    clear = system.with_(C=shortening(system) * (1.0 + shift))
    return clear, steady_state(clear)


SHIFTS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)


def _touches(shift: float, periods: int, **options: Any) -> np.ndarray:
    """Return the instants of touch [s] of a motion that would turn at the wall."""
    system, start = _grazing(shift)
    orbit = simulate(system, periods, start=start, record=BOTH, **options)
    assert orbit.impacts is not None
    return orbit.impacts["touch"]


def _wrong_touches(shifts: tuple[float, ...], **options: Any) -> int:
    """Count the motions that touch where they clear the wall, or not exactly once where not."""
    cleared = sum(len(_touches(shift, 20, **options)) > 0 for shift in shifts)
    touched = sum(len(_touches(-shift, 1, **options)) != 1 for shift in shifts)
    return cleared + touched


def grazing() -> Finding:
    """Graze the wall from either side, down to 1e-11 of the clearance."""
    wrong = _wrong_touches(SHIFTS)
    words = (
        f"{2 * len(SHIFTS)} motions that turn at C (1 +- 1e-3 ... 1e-11): {wrong} judged wrongly"
    )
    return within(wrong, 0.0, words)


def grazing_by_rk4() -> Finding:
    """Graze the wall by fixed steps, as finely as these resolve a turn."""
    wrong = _wrong_touches(SHIFTS[:4], method="rk4", period_steps=4096.0)
    words = f"{2 * len(SHIFTS[:4])} motions down to C (1 +- 1e-9): {wrong} judged wrongly"
    return within(wrong, 0.0, words)


def grazing_exactly() -> Finding:
    """Let the motion turn on the wall itself: the orbit stays the same whatever is called a touch.

    A touch at the turn has the speed of rounding errors; what it does to the motion is as small.
    """
    worst = 0.0
    for method in METHODS:
        system, start = _grazing(0.0)
        orbit = simulate(
            system, 20, start=start, record=BOTH, method=method,
            period_steps=None if method == "exact" else 4096.0,
        )  # fmt: skip
        worst = max(worst, error_of(orbit.state, start, system.rest or 0.0))
    return within(worst, 1e-6, f"after 20 such turns both methods are {worst:.1e} off at most")


ENTRIES = (
    Entry(
        2,
        "order across contacts",
        "rk4 cuts its steps at touch and release and keeps order 4 within 0.2 across contacts.",
        order_across_contacts,
        "A fixed step that knows nothing of touches caps near order 2.5.",
    ),
    Entry(
        2,
        "order of stepped contacts",
        "Contacts that the exact method steps are of order 14 or higher in their number.",
        order_of_stepped_contacts,
        "Contacts softer than K = 1e5 N/m^1.5 are stepped finer than asked: other rates set the "
        "step.",
    ),
    Entry(
        2,
        "nodes of short impacts",
        "Each node of a short impact divides its error by 4 or more.",
        nodes_of_short_impacts,
    ),
    Entry(
        3,
        "Hertz impact",
        "A free impact has the depth (5 mu v^2 / 4 K)^(2/5), lasts 2.9433 depth / v and is "
        "elastic, to 1e-10, by both methods.",
        hertz_impact,
    ),
    Entry(
        8,
        "grazing",
        "Where the motion would turn at C (1 +- 1e-9) no touch is missed, none is doubled and none "
        "invented; the search ends.",
        grazing,
        "Below 1e-13 of the clearance the turn itself is a matter of round-off.",
    ),
    Entry(
        8,
        "grazing by rk4",
        "rk4 at 4096 steps tells a touch from a miss down to C (1 +- 1e-9).",
        grazing_by_rk4,
        "A turn is known as well as the steps resolve the motion: about 1e-11 here.",
    ),
    Entry(
        8,
        "grazing exactly",
        "A motion that turns on the wall itself stays what it is, touch or no touch.",
        grazing_exactly,
        "Whether it touches is decided by the last bit and means nothing; both answers are right.",
    ),
    Entry(
        9,
        "rigid limit",
        "With K to infinity the state behind an impact tends to the elastic one as K^(-2/5).",
        rigid_limit,
    ),
)
