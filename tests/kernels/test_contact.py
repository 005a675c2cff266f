"""Stepped contacts: errors within the tolerance, their doubt, limits that are passed inside.

Errors are relative to the scales of the contact, in units of the growth that an error has on its
way. Where the far wall lies beyond the limit (C < -D of the kinds ssvi-b and ssvi-c) the damper
breaks the limit while it is still in contact, and may lie beyond it all the time.
"""

import itertools
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from support import (
    BOTH,
    NOTHING,
    contact_parts,
    fitted_order,
    follow_contact,
    kernel_cell,
    references,
    side_of,
    system_of,
)
from twin import follow, model_of

from nlds_vines.engine.batch import WALLS
from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.events.contact import Steps, to_end
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.laws.hertz import FREE_THETA, LASTING
from nlds_vines.kernels.motion.flight import rate_of
from nlds_vines.kernels.motion.taylor import advance, defect_of, expand_contact, piece_of
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RELEASED, STOPPED
from nlds_vines.kernels.scene.drive import after, drive_now
from nlds_vines.kernels.scene.law import NEW, OLD
from nlds_vines.kernels.scene.scene import CellBuffers, Parts, Span, Step, accelerations_at
from nlds_vines.kernels.watch import observe
from nlds_vines.kernels.watch import touch as limit
from nlds_vines.kernels.watch.response import watch_piece
from nlds_vines.model.catalog import catalog

pytestmark = pytest.mark.kernels

SET6 = references()["ssul-set6"].numbers
FREE = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)
KINDS = ("any", "soft", "slow", "pressed", "forced", "inside")
TRUE = Steps(120.0, np.inf)
GROWING = Steps(30.0, np.inf)
SMALL = 1e-6  # of the changes by which growth is measured
WAY = (0.0, 0.15, 0.3, 0.5, 0.7, 0.87, 0.97)  # where it is measured


class End(NamedTuple):
    event: int
    q: float
    s: float
    x1: float
    v1: float
    elapsed: float
    depth: float


@dataclass(frozen=True)
class Contact:
    """A contact from its start to its release or to the section that cuts it."""

    parts: tuple
    phase: float
    start: tuple[float, float, float, float]  # q, s, x1, v1
    stop: float

    def follow(self, steps, begun=0.0, start=None, stop=None):
        """Follow it from a time and a state on; return its `End`, elapsed since its touch."""
        phase = self.phase + self.parts[0].omega * begun
        wave = float(np.cos(phase)), float(np.sin(phase))
        start, stop = tuple(start or self.start), self.stop if stop is None else stop
        side = side_of(self.parts, steps=steps)
        event, q, s, x1, v1, took, depth = follow_contact(side, wave, start, stop - begun)
        return End(event, q, s, x1, v1, begun + took, depth)

    def error(self, state, true):
        """Return the largest error of z, s, x1, v1, time and depth above round-off, in scales."""
        q, s = self.start[:2]
        deep = max(true.depth, q * q, true.q**2)
        fast = max(abs(s), self.parts[2].speed * deep**1.25)
        scales = np.array(
            [deep, fast, max(abs(true.x1), deep), max(abs(true.v1), fast), true.elapsed, deep]
        )
        a = np.array([state.q**2, *state[2:]])
        b = np.array([true.q**2, *true[2:]])
        # of some hundred steps, and of numbers that are larger than their scale
        impacts = true.elapsed / (LASTING * deep / fast)
        lost = 4e-15 * (1.0 + np.abs(b) / scales) * (1.0 + 3.0 * impacts)
        errors = np.abs(a - b) / scales
        return np.where(errors > lost, errors, 0.0).max()

    def growth(self, true):
        """Return the largest growth of an error in speed, depth or v1 from places on the way on."""
        most, wall = 1.0, self.parts[2]
        for share in WAY:
            begun = share * true.elapsed
            at = self.follow(GROWING, stop=begun) if begun else None
            if at is not None and at.event != STOPPED:
                continue
            q, s, x1, v1 = at[1:5] if at else self.start
            plain = self.follow(GROWING, begun, (q, s, x1, v1))
            reach = np.hypot(q**2.5, s / wall.speed)
            speed, deep = wall.speed * reach, reach**0.8
            for changed in (
                (q, s + SMALL * speed, x1, v1),
                (np.sqrt(q * q + SMALL * deep), s, x1, v1),
                (q, s, x1, v1 + SMALL * speed),
            ):
                moved = self.follow(GROWING, begun, changed)
                if not moved.event == plain.event == true.event:
                    return np.inf
                moved = moved._replace(depth=true.depth)
                most = max(most, self.error(moved, plain._replace(depth=true.depth)) / SMALL)
        return most


def drawn(kind, rng):
    factors = {name: 10 ** rng.uniform(-1, 1) for name in ("m1", "k1", "c1", "m2", "k2", "P")}
    numbers = {name: SET6[name] * factor for name, factor in factors.items()}
    numbers["c2"] = SET6["c2"] * 10 ** rng.uniform(-1, 2)
    numbers["K"], numbers["near"] = 10 ** rng.uniform(3, 12), SET6["C"]
    q, speed = 0.0, 10 ** rng.uniform(-2, 1)
    x1, v1 = rng.normal(0, (0.05, 0.3))
    periods = rng.choice([1.0, 1.0, rng.uniform(0, 1)])
    if kind == "soft":
        numbers["K"] = 10 ** rng.uniform(3, 6)
    if kind == "slow":
        speed = 10 ** rng.uniform(-8, -2)
    if kind == "forced":
        numbers["P"], speed = SET6["P"] * 10 ** rng.uniform(1, 4), 10 ** rng.uniform(-3, 1)
    if kind in ("pressed", "inside"):  # by the spring, or released by it
        numbers["K"], away = 10 ** rng.uniform(3, 9), 10 ** rng.uniform(-3, 0)
        numbers["near"] = -away if kind == "pressed" else rng.choice([-away, away])
        periods = rng.choice([3.0, 1.0, rng.uniform(0, 1)])
    if kind == "inside":
        q, speed = 10 ** rng.uniform(-3, -0.5), speed * rng.choice([-1, 1])
    parts = contact_parts(**{**SET6, **numbers})
    period = 2 * np.pi / SET6["omega"]
    return Contact(parts, rng.uniform(0, 2 * np.pi), (q, speed, x1, v1), periods * period)


@cache
def contacts(kind, count=80):
    """Return random contacts of a kind, with how they end and how errors grow."""
    rng, cases = np.random.default_rng([7, KINDS.index(kind)]), []
    for _ in range(count):
        one = drawn(kind, rng)
        true = one.follow(TRUE)
        cases.append((one, true, one.growth(true)))
    return cases


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_the_error_is_at_most_the_tolerance(kind, tolerance):
    """Of state, time and depth. Notices: fewer steps and no check, a share that does not end."""
    settings, worst = Settings(tolerance=tolerance), 0.0
    steps = Steps(settings.steps, settings.stepped_to)
    for one, true, growth in contacts(kind):
        state = one.follow(steps)
        assert state.event == true.event
        worst = max(worst, one.error(state, true) / growth)
    assert worst <= steps.tolerance


def test_steps_that_are_set_are_taken_as_they_are_and_not_checked():
    parts = contact_parts(**{**SET6, **FREE, "near": SET6["C"]})
    one = Contact(parts, 0.0, (0.0, 1.0, 0.0, 0.0), 1.0)
    errors = [one.error(one.follow(Steps(n, np.inf)), one.follow(TRUE)) for n in (3.0, 4.0)]
    assert errors[0] >= 1e-7
    assert errors[1] >= 3e-10
    assert Settings(contact_steps=18.7).stepped_to == np.inf


def doubted(one, steps):
    """Return the sum of the doubts of even steps, and the end, whatever is doubted."""
    ps, damper, wall = one.parts
    rate, side, elapsed, doubt = rate_of(ps, damper), side_of(one.parts), 0.0, 0.0
    phase, k = (float(np.cos(one.phase)), float(np.sin(one.phase))), side.k
    k[OLD : OLD + 4] = one.start
    while True:
        q, s = k[OLD], k[OLD + 1]
        y = k[OLD + 2], k[OLD + 3], wall.gap + q * q, s
        _, external = accelerations_at(side, ps, y, phase[0], 0.0)
        reach = np.hypot(q**2.5, s / wall.speed)
        span = min(reach**0.4, 2.0 * max(q, np.sqrt(abs(s) / rate)))
        square = wall.kappa * reach**1.2 + abs(external) + (rate * span) ** 2
        h = FREE_THETA / steps / np.sqrt(square)
        expand_contact(side, None, phase, h)
        while True:
            step, stopped = to_end(side, phase, one.stop - elapsed, h)
            if step.landing or k[NEW] > 0.0:
                break
            h *= 0.5
        fast = max(wall.speed * reach, abs(s))
        drive = drive_now(after(ps, phase, k[NEW + 4]))
        doubt += defect_of(side, drive, step.h, (fast, reach**0.8, reach**0.4))
        elapsed += k[NEW + 4]
        if step.landing or stopped:
            event = RELEASED if step.landing else STOPPED
            q = 0.0 if step.landing else k[NEW]
            return doubt, End(event, q, *k[NEW + 1 : NEW + 4], elapsed, 0.0)
        phase = after(ps, phase, k[NEW + 4])
        k[OLD : OLD + 4] = k[NEW : NEW + 4]


@pytest.mark.parametrize("steps", [3.0, 5.0, 8.0])
def test_the_doubt_is_never_below_a_third_of_the_error(steps):
    """And seldom above thirty times. Notices: the defect of one unknown left out."""
    ratios = []
    for kind in KINDS:
        for one, true, growth in contacts(kind)[:40]:
            if true.elapsed * rate_of(*one.parts[:2]) > 20 or not growth < 1e4:
                continue
            doubt, state = doubted(one, steps)
            error = one.error(state._replace(depth=true.depth), true)
            if 1e-13 < error < 0.1:
                ratios.append(doubt * growth / error)
    assert len(ratios) > 50
    assert min(ratios) >= 1 / 3
    assert np.median(ratios) <= 20


def test_the_doubt_has_the_order_of_the_error():
    """Notices: a defect that is not of the step's own polynomial."""
    parts = contact_parts(**{**SET6, "near": SET6["C"], "K": 1e6})
    one, steps = Contact(parts, 1.0, (0.0, 2.4, 0.011, 0.2), 10.0), np.array([5, 6, 7, 8, 10])
    assert fitted_order([doubted(one, n)[0] for n in steps], steps) == pytest.approx(14.0, abs=1.0)


SSBL = {**catalog()["ssbl"].parameters, "K": 32504566.49525256}
METHODS = {"exact": {}, "rk4": {"method": "rk4", "period_steps": 4096.0}}
FOLLOWED = 2

BREAKING = {
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
    numbers = {**SSBL, **BREAKING[name]}
    rows = follow(model_of(numbers, watched=True), (0.0, 0.0, numbers["D"], 0.0), FOLLOWED).contacts
    excursions = (rows[:, 0] == 0) & (rows[:, 4] > 1e-15)  # less is round-off
    return rows[excursions], rows[rows[:, 0] == 1]


BY_POWER = ("soft", "driven fast", "a limit beyond the structure")


@pytest.mark.parametrize(
    ("name", "method"),
    [
        *itertools.product(BREAKING, METHODS),
        *(pytest.param(name, "power", marks=pytest.mark.plain) for name in BY_POWER),
    ],
)
def test_violations_inside_contacts_as_the_twin_sees_them(name, method):
    """Number, first time and depth. Notices: contacts that are not watched, or counted anew."""
    numbers = {**SSBL, **BREAKING[name]}
    system = system_of("ssvi-c" if "L" in BREAKING[name] else "ssvi-b", numbers)
    if method == "power":
        system = system.with_(law="power", K=numbers["K"], exponent=1.5)
    orbit = simulate(system, FOLLOWED, record=BOTH, **METHODS.get(method, {}))
    beyond, _ = seen_by_twin(name)
    bound = 1e-6 if method == "rk4" else 1e-9
    assert orbit.violation.number == len(beyond)
    assert orbit.violation.time == pytest.approx(beyond[0, 1], rel=bound)
    assert orbit.violation.depth == pytest.approx(beyond[:, 4].max(), rel=bound)


def test_the_cases_are_what_they_say():
    shares = {}
    for name in BREAKING:
        beyond, pushes = seen_by_twin(name)
        first = beyond[0, 1]
        inside = (np.nan_to_num(pushes[:, 1]) < first) & ~(pushes[:, 2] <= first)
        shares[name] = bool(inside.any())
    outside = {"the wall at the limit", "the wall within the limit"} | {
        name for name in BREAKING if name.startswith("in flight")
    }
    assert {name for name, inside in shares.items() if not inside} == outside


def near_orbit(level, method, stops):
    """Return r at `stops` samples of each period, and (first time, depth, number) of violations."""
    cell = kernel_cell(**{**SSBL, "K": 1e6, "near": 0.02, "rest": 0.1, "limit": level})
    rk4 = None if method == "exact" else True
    parts = Parts(
        rk4, True, WALLS["hertz", False], None, None, None, None, make_arc(), 28.0, np.inf, 4096.0
    )
    state, section, violation = np.zeros(STATE_SIZE), np.zeros((FOLLOWED * stops, 4)), np.zeros(3)
    buffers = CellBuffers(section=section, violation=violation)
    assert run_cell(parts, cell, state, Span(0, FOLLOWED, stops), buffers) == OK
    r = section[:, 0] - section[:, 2] + 0.1
    return np.concatenate([[0.0], r]), violation


@pytest.mark.plain
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_a_limit_in_the_way_into_a_near_wall(method):
    """Deep contacts pass it, shallow ones do not: short impacts among them. No scene has this."""
    r, _ = near_orbit(0.01, method, 4096)
    for level in (0.01, 0.0202, 0.023, 0.03):
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


def note_limit_step(side, log, step, begun):
    piece, watch = piece_of(side, step.h), NOTHING._replace(limit_log=log)
    watch_piece(side.ps, side.damper, watch, piece, step.phase, begun, 1.0)


def free_step(level, q, s, h=1.0, begun=2.0, excess=None, sign=1.0):
    """Return the log of one step without forces and stiffness: r = 0.1 + z moves at the rate s."""
    parts = contact_parts(m1=1e3, m2=1.0, omega=1.0, K=1e-9, near=0.1, **FREE)
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


def test_one_step_notes_passages_excursions_and_a_far_wall():
    # the instant of a passage within a step
    log, z, _ = free_step(level=0.16, q=0.2, s=0.3)
    assert z > 0.06
    assert log[observe.NUMBER] == log[observe.BEYOND] == 1.0
    assert log[observe.FIRST_VIOLATION] == pytest.approx(12.0 + 0.02 / 0.3, rel=1e-12)
    assert log[observe.EXCESS] == pytest.approx(z - 0.06, rel=1e-12)
    # an excursion goes on and ends
    log, z, _ = free_step(level=0.11, q=0.2, s=0.3, excess=0.03)
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (0.0, 1.0)
    assert log[observe.EXCESS] == pytest.approx(z - 0.01, rel=1e-12)
    log, z, _ = free_step(level=0.13, q=0.2, s=-0.3, h=0.5, excess=0.01)
    assert z < 0.03
    assert (log[observe.NUMBER], log[observe.BEYOND]) == (0.0, 0.0)
    assert log[observe.EXCESS] == pytest.approx(0.01, rel=1e-12)
    # a far wall within the limit is not watched
    log, *_ = free_step(level=-0.1, q=0.2, s=-0.3, h=0.5, sign=-1.0)
    assert log[observe.NUMBER] == 0.0
    log, *_ = free_step(level=-0.13, q=0.2, s=-0.3, h=0.5, sign=-1.0)
    assert log[observe.NUMBER] == 1.0
    assert log[observe.FIRST_VIOLATION] == pytest.approx(12.0 + 0.01 / 0.3, rel=1e-12)


def turning_step(level, beyond=0.0):
    """Return the log of one step over the deepest point of a free impact, as deep behind it.

    And the depths at its beginning and at the deepest point; r = 0.1 + z.
    """
    bodies = {"m1": 1e3, "m2": 1.0, "omega": 1.0, "K": 1e6, "near": 0.1, **FREE}
    side, log = side_of(contact_parts(**bodies)), np.zeros(6)
    wall, k, z, deepest = side.wall, side.k, 0.0098, 0.01
    s = wall.speed * np.sqrt(deepest**2.5 - z**2.5)
    log[[observe.LIMIT, observe.ORIGIN, observe.FIRST_VIOLATION]] = level, 10.0, np.nan
    log[observe.BEYOND] = beyond
    k[OLD], k[OLD + 1] = np.sqrt(z), s
    low, high = 0.0, 2.0 / np.sqrt(wall.kappa * deepest**1.5)
    expand_contact(side, None, (1.0, 0.0), high)
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


START = (1.0, 0.0)
BODIES = {"m1": 1000.0, "m2": 60.0, "omega": 6.28, "K": 1e6, "near": 0.1}


def test_a_short_impact_is_trusted_only_where_its_energy_cannot_reach_the_limit():
    """Notices: short impacts taken though they may pass the limit; either wall."""
    side = side_of(contact_parts(**{**BODIES, **FREE}))
    depth = (1.0 / side.wall.speed) ** 0.8
    log = np.zeros(6)
    for part, expected in ((0.999, True), (1.001, False)):
        log[observe.LIMIT] = 0.1 + part * depth
        at_rest = 1.0, 0.0, side.damper.share
        assert limit.may_pass(side, log, START, 0.01, at_rest) == expected
        assert limit.may_pass(side, log, START, 0.01, (1.0, 0.0, 5.0))
    log[observe.LIMIT] = 0.09
    assert limit.may_pass(side, log, START, 0.01, (1e-9, 0.0, 0.0))
    far = side._replace(sign=-1.0)
    for level, expected in ((-0.11, True), (-0.1, False), (-0.05, False)):
        log[observe.LIMIT] = level
        assert limit.may_pass(far, log, START, 0.01, (1.0, 0.0, 0.0)) == expected
