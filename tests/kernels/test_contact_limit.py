"""A limit of the spring's shortening inside contacts: against the twin, and against samples.

Where the far wall lies beyond the limit (C < -D of the kinds ssvi-b and ssvi-c) the damper breaks
the limit while it is still in contact, and may lie beyond it all the time.
"""

from functools import cache

import numpy as np
import pytest
from support import BOTH, NOTHING, contact_parts, kernel_cell, side_of, system_of
from twin import follow, model_of

from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.motion.taylor import advance, expand_contact, piece_of
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.law import NEW, OLD
from nlds_vines.kernels.scene.scene import CellBuffers, Parts, Span, Step
from nlds_vines.kernels.watch import observe
from nlds_vines.kernels.watch import touch as limit
from nlds_vines.kernels.watch.response import watch_piece
from nlds_vines.model.catalog import catalog
from nlds_vines.orbits.kernel_inputs import WALLS
from nlds_vines.orbits.simulation import simulate

SSBL = {**catalog()["ssbl"].parameters, "K": 32504566.49525256}
METHODS = {"exact": {}, "rk4": {"method": "rk4", "period_steps": 4096.0}}
PERIODS = 2

CASES = {
    "pressed out once for all": {"C": -0.08},
    "overdamped": {"C": -0.08, "c2": 2e4},
    "soft": {"C": -0.061, "K": 1e4},
    "pressed in deeper than the limit, most of the time": {"C": -0.0601, "k2": 2e4, "K": 1e6},
    "steel": {"C": -0.0605, "k2": 2e4, "K": 1e10},
    "the wall at the limit": {"C": -0.06, "k2": 2e4, "K": 1e6},
    "the wall within the limit": {"C": -0.05, "k2": 2e4, "K": 1e6},
    "a limit beyond the structure": {"C": -0.0701, "L": 0.01, "k2": 2e4, "K": 1e6},
    "in contact all the time": {"C": -0.3, "P": 400.0, "k2": 2e4, "K": 1e5},
    "in flight, after a contact in the same period": {"C": 0.05},
    "driven fast": {"C": -0.0601, "k2": 2e4, "K": 1e6, "omega": 40.0},
}


@cache
def seen_by_twin(name):
    """Return the twin's contacts: excursions beyond the limit (wall 0), and pushes."""
    numbers = {**SSBL, **CASES[name]}
    rows = follow(model_of(numbers, watched=True), (0.0, 0.0, numbers["D"], 0.0), PERIODS).contacts
    excursions = (rows[:, 0] == 0) & (rows[:, 4] > 1e-15)  # less is round-off
    return rows[excursions], rows[rows[:, 0] == 1]


@pytest.mark.kernels
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", CASES)
def test_violations_inside_contacts_as_the_twin_sees_them(name, method):
    """Number, first time and depth. Notices: contacts that are not watched, or counted anew."""
    numbers = {**SSBL, **CASES[name]}
    kind = "ssvi-c" if "L" in CASES[name] else "ssvi-b"
    orbit = simulate(system_of(kind, numbers), PERIODS, record=BOTH, **METHODS[method])
    beyond, _ = seen_by_twin(name)
    bound = 1e-9 if method == "exact" else 1e-6
    assert orbit.violation.number == len(beyond)
    assert orbit.violation.time == pytest.approx(beyond[0, 1], rel=bound)
    assert orbit.violation.depth == pytest.approx(beyond[:, 4].max(), rel=bound)


@pytest.mark.plain
@pytest.mark.kernels
@pytest.mark.parametrize("name", ["soft", "driven fast", "a limit beyond the structure"])
def test_a_power_law_without_damping_breaks_the_limit_as_hertz_does(name):
    """K z^1.5 by another law, whose walls have no damping: the twin sees the same."""
    kind = "ssvi-c" if "L" in CASES[name] else "ssvi-b"
    numbers = {**SSBL, **CASES[name]}
    system = system_of(kind, numbers).with_(law="power", K=numbers["K"], exponent=1.5)
    orbit = simulate(system, PERIODS, record=BOTH)
    beyond, _ = seen_by_twin(name)
    assert orbit.violation.number == len(beyond)
    assert orbit.violation.time == pytest.approx(beyond[0, 1], rel=1e-9)
    assert orbit.violation.depth == pytest.approx(beyond[:, 4].max(), rel=1e-9)


def test_the_cases_are_what_they_say():
    shares = {}
    for name in CASES:
        beyond, pushes = seen_by_twin(name)
        first = beyond[0, 1]
        inside = (np.nan_to_num(pushes[:, 1]) < first) & ~(pushes[:, 2] <= first)
        shares[name] = bool(inside.any())
    outside = {"the wall at the limit", "the wall within the limit"} | {
        name for name in CASES if name.startswith("in flight")
    }
    assert {name for name, inside in shares.items() if not inside} == outside


# ---- a limit behind a near wall ------------------------------------------------------------------


def near_orbit(level, method, stops, K=1e6, start=0.0):
    """Return r at `stops` samples of each period, and (first time, depth, number) of violations."""
    numbers = {**SSBL, "K": K}
    cell = kernel_cell(**{**numbers, "near": 0.02, "rest": 0.1, "limit": level})
    rk4 = None if method == "exact" else True
    parts = Parts(
        rk4, True, WALLS["hertz", False], None, None, None, make_arc(), 28.0, np.inf, 4096.0
    )
    state, section, violation = np.zeros(STATE_SIZE), np.zeros((PERIODS * stops, 4)), np.zeros(3)
    state[3] = start
    buffers = CellBuffers(section=section, violation=violation)
    assert run_cell(parts, cell, state, Span(0, PERIODS, stops), buffers) == OK
    r = section[:, 0] - section[:, 2] + 0.1
    return np.concatenate([[0.0], r]), violation


@pytest.mark.plain
@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("level", [0.01, 0.0202, 0.023, 0.03])
def test_a_limit_in_the_way_into_a_near_wall(level, method):
    """Deep contacts pass it, shallow ones do not: short impacts among them. No scene has this."""
    r, _ = near_orbit(level, method, 4096)
    time, depth, number = near_orbit(level, method, 1)[1]
    beyond = r > level
    passages = np.flatnonzero(~beyond[:-1] & beyond[1:])
    assert number == len(passages)
    assert (number > 0) == (level < 0.03)
    if number:
        tick = 2 * np.pi / SSBL["omega"] / 4096
        assert passages[0] * tick <= time * (1 + 1e-9)
        assert time <= (passages[0] + 1) * tick
        assert depth == pytest.approx(r.max() - level, rel=1e-5)
    else:
        assert depth == 0.0


# ---- one step ------------------------------------------------------------------------------------


def note_limit_step(side, log, step, begun):
    """Note in the log the limit over a step."""
    piece, watch = piece_of(side, step.h), NOTHING._replace(limit_log=log)
    watch_piece(side.ps, side.damper, watch, piece, step.phase, begun, 1.0)


def free_step(level, q, s, h=1.0, begun=2.0, excess=None, sign=1.0):
    """Return the log of one step of a damper without forces in a wall without stiffness.

    r = 0.1 + z then moves at the rate s, so that z = q^2 + s t.
    """
    parts = contact_parts(
        m1=1e3, k1=0.0, c1=0.0, m2=1.0, k2=0.0, c2=0.0, P=0.0, omega=1.0, K=1e-9, near=0.1
    )
    side, log = side_of(parts, rate=1.0, sign=sign), np.zeros(6)
    k, step = side.k, Step((1.0, 0.0), False, h)
    log[[observe.LIMIT, observe.ORIGIN, observe.FIRST_VIOLATION]] = level, 10.0, np.nan
    if excess is not None:  # beyond the limit already
        log[observe.BEYOND], log[observe.EXCESS] = 1.0, excess
    k[OLD], k[OLD + 1] = q, s
    expand_contact(side, None, step.phase, h)
    advance(side, None, step)
    note_limit_step(side, log, step, begun)
    return log, k[NEW] ** 2, k[NEW + 4]


@pytest.mark.kernels
def test_the_instant_of_a_passage_within_a_step():
    log, z, _ = free_step(level=0.16, q=0.2, s=0.3)
    assert z > 0.06
    assert log[observe.NUMBER] == log[observe.BEYOND] == 1.0
    assert log[observe.FIRST_VIOLATION] == pytest.approx(12.0 + 0.02 / 0.3, rel=1e-12)
    assert log[observe.EXCESS] == pytest.approx(z - 0.06, rel=1e-12)


@pytest.mark.kernels
def test_an_excursion_goes_on_and_ends():
    log, z, _ = free_step(level=0.11, q=0.2, s=0.3, excess=0.03)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (0.0, 1.0)
    assert log[observe.EXCESS] == pytest.approx(z - 0.01, rel=1e-12)
    log, z, _ = free_step(level=0.13, q=0.2, s=-0.3, h=0.5, excess=0.01)
    assert z < 0.03
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (0.0, 0.0)
    assert log[observe.EXCESS] == pytest.approx(0.01, rel=1e-12)


@pytest.mark.kernels
def test_a_far_wall_within_the_limit_is_not_watched():
    log, *_ = free_step(level=-0.1, q=0.2, s=-0.3, h=0.5, sign=-1.0)
    assert log[observe.NUMBER] == 0.0
    log, *_ = free_step(level=-0.13, q=0.2, s=-0.3, h=0.5, sign=-1.0)
    assert log[observe.NUMBER] == 1.0
    assert log[observe.FIRST_VIOLATION] == pytest.approx(12.0 + 0.01 / 0.3, rel=1e-12)


def turning_step(level, beyond=0.0, share=0.02, K=1e6):
    """Return the log of one step over the deepest point of a free impact, as deep behind it.

    And the depths at its beginning and at the deepest point; r = 0.1 + z.
    """
    free = {
        "m1": 1e3,
        "k1": 0.0,
        "c1": 0.0,
        "m2": 1.0,
        "k2": 0.0,
        "c2": 0.0,
        "P": 0.0,
        "omega": 1.0,
    }
    side, log = side_of(contact_parts(**free, K=K, near=0.1)), np.zeros(6)
    wall, k = side.wall, side.k
    deepest = 0.01
    z = (1.0 - share) * deepest
    s = wall.speed * np.sqrt(deepest**2.5 - z**2.5)
    log[[observe.LIMIT, observe.ORIGIN, observe.FIRST_VIOLATION]] = level, 10.0, np.nan
    log[observe.BEYOND] = beyond
    k[OLD], k[OLD + 1] = np.sqrt(z), s
    expand_contact(side, None, (1.0, 0.0), 2.0 / np.sqrt(wall.kappa * deepest**1.5))
    low, high = 0.0, 2.0 / np.sqrt(wall.kappa * deepest**1.5)
    for _ in range(60):  # the step after which s = -s
        h = 0.5 * (low + high)
        advance(side, None, Step((1.0, 0.0), False, h))
        low, high = (h, high) if k[NEW + 1] > -s and k[NEW] > 0.0 else (low, h)
    step = Step((1.0, 0.0), False, h)
    advance(side, None, step)
    end = k[NEW : NEW + 5].copy()
    note_limit_step(side, log, step, 0.0)
    np.testing.assert_array_equal(k[NEW : NEW + 5], end)
    return log, z, deepest


@pytest.mark.kernels
def test_a_passage_and_a_return_within_one_step():
    """Both ends are within the limit. Notices: a bound left out, a step taken for monotone."""
    _, z, deepest = turning_step(1.0)
    for part in (0.01, 0.5, 0.99, 0.9999):
        level = 0.1 + z + part * (deepest - z)
        log, *_ = turning_step(level)
        assert (log[observe.NUMBER], log[observe.BEYOND]) == (1.0, 0.0)
        assert log[observe.EXCESS] == pytest.approx(0.1 + deepest - level, abs=1e-11 * deepest)
        assert log[observe.FIRST_VIOLATION] > 10.0
    log, *_ = turning_step(0.1 + deepest * (1 + 1e-7))
    assert log[observe.NUMBER] == log[observe.EXCESS] == 0.0
    log, *_ = turning_step(0.05, beyond=1.0)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (0.0, 1.0)
    assert log[observe.EXCESS] == pytest.approx(0.05 + deepest, rel=1e-9)


# ---- a short impact ------------------------------------------------------------------------------

NO_FORCES = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)
PHASE = (1.0, 0.0)
BODIES = {"m1": 1000.0, "m2": 60.0, "omega": 6.28, "K": 1e6, "near": 0.1}


@pytest.mark.kernels
def test_a_short_impact_is_trusted_only_where_its_energy_cannot_reach_the_limit():
    """Notices: short impacts taken though they may pass the limit; either wall."""
    side = side_of(contact_parts(**{**BODIES, **NO_FORCES}))
    depth = (1.0 / side.wall.speed) ** 0.8
    log = np.zeros(6)
    for part, expected in ((0.999, True), (1.001, False)):
        log[observe.LIMIT] = 0.1 + part * depth
        at_rest = limit.may_pass(side, log, PHASE, 0.01, (1.0, 0.0, side.damper.share))
        assert at_rest == expected
        moving = limit.may_pass(side, log, PHASE, 0.01, (1.0, 0.0, 5.0))
        assert moving
    log[observe.LIMIT] = 0.09
    assert limit.may_pass(side, log, PHASE, 0.01, (1e-9, 0.0, 0.0))
    for level, expected in ((-0.11, True), (-0.1, False), (-0.05, False)):
        log[observe.LIMIT] = level
        assert (
            limit.may_pass(side._replace(sign=-1.0), log, PHASE, 0.01, (1.0, 0.0, 0.0)) == expected
        )
