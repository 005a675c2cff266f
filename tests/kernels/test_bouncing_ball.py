"""The bouncing ball, and a hard impact oscillator without damping, beside closed forms."""

import math

import numpy as np
import pytest
from flights import flow_on
from support import BOTH, period_map

from nlds_vines import classify, simulate
from nlds_vines.model.system import System

pytestmark = pytest.mark.kernels

G = 9.81


def ball(gamma, e, omega=30.0):
    """Return a ball on a table whose greatest acceleration is gamma g."""
    numbers = {"m": 1.0, "g": G, "Y": gamma * G / omega**2, "omega": omega, "e": e}
    return System("ball", numbers, law="restitution")


def bounce(gamma, e, omega, n):
    """Return the section points (height, velocity) of both nT,1 orbits, in closed form.

    The ball flies with g n T / 2 from impact to impact; there the table moves with
    (1 - e) / (1 + e) of it.
    """
    T, Y = 2 * np.pi / omega, gamma * G / omega**2
    lift = 0.5 * G * n * T
    sine = -(1 - e) / (1 + e) * lift / (Y * omega)
    orbits = []
    for phase in (math.asin(sine) + 2 * np.pi, np.pi - math.asin(sine)):
        since = n * T - phase / omega
        height = Y * math.cos(phase) + lift * since - 0.5 * G * since**2 - Y
        orbits.append((height, lift - G * since))
    return orbits


@pytest.mark.parametrize(("gamma", "e", "n"), [(1.2, 0.5, 1), (1.4, 0.5, 1), (2.4, 0.5, 2)])
def test_bouncing_orbits_in_closed_form(gamma, e, n):
    system = ball(gamma, e)
    for height, velocity in bounce(gamma, e, 30.0, n):
        orbit = simulate(system, n, start=(height, velocity), record=BOTH)
        assert len(orbit.impacts) == 1
        np.testing.assert_allclose(orbit.state, (height, velocity), rtol=0, atol=1e-12)
        speed = G * n * system.period / (1 + e)
        assert orbit.impacts["speed"][0] == pytest.approx(speed, rel=1e-12)


@pytest.mark.parametrize("e", [0.15, 0.5, 0.8])
def test_a_bouncing_orbit_is_born_and_doubles_where_the_textbook_says(e):
    """Gamma >= pi (1 - e) / (1 + e), and < sqrt(that^2 + (2 (1 + e^2) / (1 + e)^2)^2)."""
    born = np.pi * (1 - e) / (1 + e)
    doubles = math.hypot(born, 2 * (1 + e * e) / (1 + e) ** 2)
    for gamma, stable in (
        (born * 1.0001, True),
        (doubles * 0.9999, True),
        (doubles * 1.0001, False),
    ):
        start = bounce(gamma, e, 30.0, 1)[0]
        regime = classify(ball(gamma, e), start=start)
        assert (regime.label == "T,1") is stable, gamma
        if stable:
            assert regime.multipliers.prod().real == pytest.approx(e**2, rel=1e-8)
    # at the doubling itself a multiplier is -1: its trace is -(1 + e^2)
    flow, y = flow_on(ball(doubles, e)), np.zeros(4)
    y[:2] = bounce(doubles, e, 30.0, 1)[0]
    _, matrix = period_map(flow, y)
    assert matrix[0, 0] + matrix[1, 1] == pytest.approx(-(1 + e**2), abs=1e-7)


@pytest.mark.parametrize(
    ("omega", "label"), [(1.51, False), (1.5239, True), (1.6702, True), (1.6704, False)]
)
def test_the_range_of_one_bounce_a_period(omega, label):
    """r = 0.15, A = g = 1: omega = 1.52383 and 1.67027."""
    system = System(
        "ball", {"m": 1.0, "g": 1.0, "Y": 1.0, "omega": omega, "e": 0.15}, law="restitution"
    )
    gamma = omega**2
    start = (1.0, 0.0)
    if gamma > np.pi * 0.85 / 1.15:
        T, sine = 2 * np.pi / omega, -0.85 / 1.15 * np.pi / gamma
        since = T - (math.asin(sine) + 2 * np.pi) / omega
        start = (
            math.cos(math.asin(sine)) + 0.5 * T * since - 0.5 * since**2 - 1.0,
            0.5 * T - since,
        )
    assert (classify(system, start=start).label == "T,1") is label


def test_a_ball_comes_to_rest_on_a_table_that_stands_still():
    """Dropped with speed v, it bounces for 2 v e / (g (1 - e)), a geometric series."""
    e, height = 0.6, 0.3
    numbers = {"m": 1.0, "g": G, "Y": 0.0, "omega": 1.0, "e": e}
    orbit = simulate(
        System("ball", numbers, law="restitution"), 1, start=(height, 0.0),
        record=BOTH,
    )  # fmt: skip
    v = math.sqrt(2 * G * height)
    touches = orbit.impacts["touch"]
    expected = v / G + 2 * v / G * np.cumsum(np.append(0.0, e ** np.arange(1, len(touches))))
    np.testing.assert_allclose(touches, expected, rtol=1e-12)
    rest = v / G + 2 * v / G * e / (1 - e)
    assert 0.0 <= rest - touches[-1] < 1e-4
    assert np.isnan(orbit.impacts["release"][-1])  # it rests
    assert (orbit.state == 0.0).all()


@pytest.mark.parametrize("gamma", [1.2, 2.0, 3.5])
def test_an_inelastic_ball_takes_off_where_the_table_falls_faster(gamma):
    """With e = 0 it rests until cos(omega t) = 1 / Gamma: the set of chattering orbits."""
    system = ball(gamma, 0.0)
    orbit = simulate(system, 40, start=(0.0, 0.0), record=BOTH)
    releases = orbit.impacts["release"]
    turns = (releases[~np.isnan(releases)] / system.period) % 1.0
    off = 1.0 - math.acos(1.0 / gamma) / (2 * np.pi)
    assert len(turns) > 10
    rested = np.abs(turns - off) < 1e-9
    assert rested.any()
    regime = classify(system, start=(0.0, 0.0))
    if rested.all():  # every impact ends in rest: all is forgotten in a period
        assert abs(regime.multipliers).max() == 0.0


@pytest.mark.parametrize("gamma", [3.3, 3.7, 3.7235])
def test_an_inelastic_ball_that_is_left_at_once_forgets_its_speed_alone(gamma):
    """Its acceleration a at the touch points away: the impact maps (0, v') to (0, a t')."""
    regime = classify(ball(gamma, 0.0), start=(0.0, 0.0))
    assert regime.label == "T,1"
    mu = 1.0 - math.sqrt(gamma**2 - math.pi**2)
    np.testing.assert_allclose(regime.multipliers, [mu, 0.0], rtol=0, atol=1e-9)
    exponent = math.log(abs(mu)) / ball(gamma, 0.0).period
    np.testing.assert_allclose(regime.exponents, [exponent, -np.inf], rtol=1e-6)
    assert regime.lyapunov == regime.exponents[0]


def test_where_all_is_forgotten_no_exponent_is_a_number():
    """The ball rests in each period."""
    regime = classify(ball(1.2, 0.0), start=(0.0, 0.0))
    assert (regime.exponents == -np.inf).all()
    assert regime.lyapunov == -np.inf


# ---- Budd and Dux: a hard impact oscillator without damping --------------------------------------


@pytest.mark.parametrize(
    ("omega", "e", "C", "speed"),
    [(2.0, 0.8, 0.0, 20 / 3), (2.0, 0.8, 0.1, 6.359595), (2.5, 0.6, 0.0, 0.700362)],
)
def test_a_hard_impact_oscillator(omega, e, C, speed):
    """Speed of impact of its T,1 orbit, from starts all over (Phil. Trans. A 347 (1994) 365)."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.0, "C": C, "P": 1.0, "omega": omega, "e": e}
    system = System("oscillator", numbers, law="restitution")
    orbits = []
    for seed in range(6):
        start = np.random.default_rng(seed).normal(size=2) - (3.0, 0.0)
        impacts = simulate(system, 400, start=start, record=BOTH).impacts
        orbits.append(impacts["speed"][-1])
    assert min(abs(np.array(orbits) - speed)) < 1e-5 * speed
