"""Rigid bodies: closed forms of oscillators and of a bouncing ball, saltation, chatter, sticking.

Chatter is followed by a twin that takes every rebound, down to speeds of 1e-9: by the oscillator's
solution in closed form, low ones by its Taylor series at the stop.
"""

import math

import numpy as np
import pytest
from flights import flow_on
from rigid import CASES, RIGID, oscillator, start_of
from scipy.linalg import expm
from scipy.optimize import brentq
from support import BOTH, kernel_state, period_map

from nlds_vines import classify, load_system, simulate
from nlds_vines.kernels.numerics.matrices import eigenvalues
from nlds_vines.kernels.orbit import variations
from nlds_vines.model.system import System

pytestmark = pytest.mark.kernels

ORBITS = [(case, orbit) for case in CASES for orbit in case["orbits"]]
FLIPS = [(case, flip) for case in CASES for flip in case["flips"]]


def in_order(values):
    return sorted(np.asarray(values, complex), key=lambda z: (round(abs(z), 9), z.imag))


@pytest.mark.parametrize(
    ("case", "exact"), ORBITS, ids=[f"{case['omega']}-{case['e']}" for case, _ in ORBITS]
)
def test_orbits_in_closed_form(case, exact):
    system, n = oscillator(case, exact["A"]), case["n"]
    flow, at, points = flow_on(system), np.zeros(4), np.empty((n, 4))
    at[:2] = start_of(case, exact)
    counts, tangent = np.zeros(2, np.int64), np.zeros(16)
    residual, _, slowest = variations.polish(flow, at, points, counts, tangent)
    assert residual < 1e-13
    assert counts[0] == 1
    assert slowest == pytest.approx(exact["speed"], rel=1e-11)
    multipliers = eigenvalues(variations.matrix_of(tangent, 2)) @ [1, 1j]
    expected = in_order([complex(*pair) for pair in exact["multipliers"]])
    np.testing.assert_allclose(in_order(multipliers), expected, rtol=0, atol=1e-10)
    volume = np.exp(-system.parameters["c"] * n * system.period) * case["e"] ** 2
    assert multipliers.prod().real == pytest.approx(volume, rel=1e-11)


def test_labels_on_both_sides_of_a_period_doubling():
    case, exact = next(pair for pair in FLIPS if pair[0]["omega"] == 0.9 and pair[0]["e"] == 0.8)
    assert classify(oscillator(case, exact["A"] * 0.99)).label == "2T,2"
    assert classify(oscillator(case, exact["A"] * 1.01)).label == "T,1"


RIGID_CASES = {
    # system, periods from rest, periods followed
    "an impact a period": (load_system("ssul-set6", law="restitution", e=0.7), 20, 2),
    "elastic": (load_system("ssul-set6", law="restitution", e=1.0), 20, 2),
    "two walls": (load_system("ssbl", law="restitution", e=0.6), 20, 1),
    "it rests on the wall": (
        load_system("ssul-set6", law="restitution", e=0.3, C=-0.2, P=100.0), 20, 1
    ),
    "it rests for a while": (
        load_system("ssul-set6", law="restitution", e=0.4, C=-0.02, P=500.0), 20, 1
    ),
}  # fmt: skip


@pytest.mark.plain
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("case", RIGID_CASES)
def test_monodromy_is_the_derivative_of_the_flow(case, method):
    system, before, periods = RIGID_CASES[case]
    flow, y = flow_on(system, method), kernel_state(system, simulate(system, before).state)
    matrix = period_map(flow, y, periods)[1]
    difference, step = np.empty((4, 4)), 1e-8 if "rests on" in case else 1e-6
    for i in range(4):
        e = step * np.eye(4)[i]
        inside = y[2] + e[2] > flow.prepared.near.gap  # nothing is beyond the wall
        ahead, behind = (period_map(flow, y + sign * e, periods)[0] for sign in (1 - inside, -1))
        difference[:, i] = (ahead - behind) / (step * (2 - inside))
    if method == "rk4":  # its flights err by more than those of the variations
        np.testing.assert_allclose(matrix, difference, rtol=0, atol=1e-3 * np.abs(matrix).max())
    else:
        # falling back to the wall takes a time like the root of the way
        near = 2e-4 if "rests on" in case else 2e-5
        np.testing.assert_allclose(matrix, difference, rtol=0, atol=near * np.abs(matrix).max())


@pytest.mark.plain
@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
@pytest.mark.parametrize("e", [1.0, 0.6, 0.0])
def test_an_impact_keeps_momentum_and_takes_its_share_of_energy(name, e):
    """E gains -mu (1 - e^2) s^2 / 2, however often the walls are struck."""
    system = load_system(name, law="restitution", e=e)
    p, rows = system.parameters, simulate(system, 50).impacts
    rows = rows[np.isfinite(rows["release"]) & (rows["release"] == rows["touch"])]
    assert len(rows) > 20
    reduced = p["m1"] * p["m2"] / (p["m1"] + p["m2"])
    lost = reduced * (1 - e**2) * rows["speed"] ** 2 / 2
    # E2 has the damper's absolute displacement, which an impact does not change
    np.testing.assert_allclose(rows["gain1"] + rows["gain2"], -lost, rtol=0, atol=1e-12 * 200)
    assert (rows["force"] == np.inf).all()
    assert (rows["depth"] == 0.0).all()


@pytest.mark.parametrize(("k", "omega", "periods"), [(1.0, 1.0, 20_000), (100.0, 1.0, 2_000)])
def test_a_flight_between_elastic_impacts_drifts_by_1e_14_of_its_energy_a_radian(k, omega, periods):
    """As docs/how-it-works.md states."""
    numbers = {"m": 1.0, "k": k, "c": 0.0, "C": 0.5, "P": 0.0, "omega": omega, "e": 1.0}
    orbit = simulate(
        System("oscillator", numbers, law="restitution"), periods, start=(-0.7, 0.4), record=BOTH
    )
    x, v = orbit.section.T
    energy = (v**2 + k * x**2) / (0.4**2 + k * 0.7**2)
    assert len(orbit.impacts) > periods
    radians = math.sqrt(k) * periods * orbit.system.period
    assert np.abs(energy - 1.0).max() < 1e-14 * radians


class Twin:
    """An oscillator with a rigid stop at C, rebound by rebound."""

    def __init__(self, system):
        p = system.parameters
        self.p, (m, k, c) = p, system.structure
        self.half, self.w = c / m / 2, math.sqrt(k / m - (c / m / 2) ** 2)
        self.X = p["P"] / (k - m * p["omega"] ** 2 + 1j * p["omega"] * c)
        self.m, self.k, self.c = m, k, c

    def pressing(self, t, v=0.0):
        force = self.p["P"] * math.cos(self.p["omega"] * t)
        return (force - self.k * self.p["C"] - self.c * v) / self.m

    def motion(self, t0, x0, v0):
        """Return a function of times that gives (x, v)."""
        omega = self.p["omega"]

        def steady(t):
            turn = self.X * np.exp(1j * omega * t)
            return turn.real, (1j * omega * turn).real

        xs, vs = steady(t0)
        a = x0 - xs
        b = (v0 - vs + self.half * a) / self.w

        def at(t):
            s = np.asarray(t) - t0
            cosine, sine = np.cos(self.w * s), np.sin(self.w * s)
            fall = np.exp(-self.half * s)
            free = fall * (a * cosine + b * sine)
            speed = fall * self.w * (b * cosine - a * sine) - self.half * free
            xs, vs = steady(np.asarray(t))
            return free + xs, speed + vs

        return at

    def follow(self, start, end):
        """Return the state at `end`, the impacts down to speeds of 1e-9, and how often it stuck."""
        t, (x, v), C, stuck, impacts = 0.0, start, self.p["C"], 0, 0
        while True:
            brief = self.low_rebound(t, v) if x == C else None
            if brief is not None and t + brief[0] < end:
                t, v = t + brief[0], brief[1]
            else:
                at = self.motion(t, x, v)
                hit = self.next_hit(at, t + 1e-7 if x == C else t, end)
                if hit is None:
                    return at(end), impacts, stuck
                t, v = hit, float(at(hit)[1])
            impacts, x, v = impacts + 1, C, -self.p["e"] * v
            if abs(v) < 1e-9 and self.pressing(t) > 0:
                stuck += 1
                t, v = self.release(t, end), 0.0
                if t is None:
                    return (C, 0.0), impacts, stuck

    def low_rebound(self, t, v):
        """Return (time, speed) of the return to the stop that is left at t with v, None if unsure.

        By the Taylor series of the depth, as the closed form knows the depth no better than x: of a
        rebound with 1e-8 nothing would be left. Where the stop is pressed all along there is one.
        """
        brief = 2 * abs(v) / self.pressing(t) if v < 0 < self.pressing(t) else math.inf
        if brief > 0.05 or self.pressing(t + 2 * brief) < 0.5 * self.pressing(t):
            return None
        omega, drive = self.p["omega"], self.p["P"] / self.m * np.exp(1j * self.p["omega"] * t)
        slopes = [v, self.pressing(t, v)]  # derivatives of the depth, from the first on
        for _ in range(10):
            drive *= 1j * omega
            slopes.append(drive.real - (self.k * slopes[-2] + self.c * slopes[-1]) / self.m)
        speeds = [slope / math.factorial(i) for i, slope in enumerate(slopes)][::-1]
        depths = [slope / math.factorial(i + 1) for i, slope in enumerate(slopes)][::-1]
        time = brentq(lambda s: np.polyval(depths, s), 0.5 * brief, 2 * brief, xtol=1e-30)
        return time, float(np.polyval(speeds, time))

    def next_hit(self, at, first, end):
        """Return when the stop is reached, looking every 2e-3 s, or None before `end`."""
        C = self.p["C"]
        for begin in np.arange(first, end, 2.0):
            times = np.linspace(begin, min(begin + 2.0, end), 1001)
            above = np.flatnonzero(at(times)[0] > C)
            if len(above):
                low, high = times[max(above[0] - 1, 0)], times[above[0]]
                inside = above[0] > 0 and at(low)[0] < C
                return brentq(lambda t: at(t)[0] - C, low, high, xtol=1e-15) if inside else low
        return None

    def release(self, t, end):
        """Return when the stop would have to pull: P cos(omega t) = k C, or None before `end`."""
        omega = self.p["omega"]
        angle = math.acos(min(1.0, self.k * self.p["C"] / self.p["P"]))
        turns = math.ceil((omega * t - angle) / (2 * math.pi))
        time = (angle + 2 * math.pi * turns) / omega
        return time if time < end else None


def test_orbits_that_chatter_to_rest_are_those_of_a_twin():
    """From 300 random starts."""
    rng = np.random.default_rng(14)
    stuck = 0
    while stuck < 300:
        case = {"omega": rng.uniform(0.2, 0.6), "e": rng.uniform(0.05, 0.8)}
        system = oscillator(case, rng.uniform(1.5, 4.0))
        start = rng.uniform(-1, 0.95), rng.uniform(-1, 1)
        # a state that is not at rest on the stop: somewhere in the second period
        orbit = simulate(system, 2, start=start, record=["trajectory", "impacts"], samples=16)
        twin = Twin(system)
        free = np.flatnonzero(orbit.trajectory[16:, 0] < RIGID["d"] - 1e-3)
        row = 16 + free[-1]
        state, _, rests = twin.follow(start, orbit.time[row])
        if not rests:
            continue
        stuck += 1
        np.testing.assert_allclose(orbit.trajectory[row], state, rtol=0, atol=1e-11)


def test_a_mass_that_its_stop_holds_from_the_start_has_the_response_of_rest():
    """Pressed by k |C| = 0.6 N against a force of 0.3 N; its spring stays stretched by |C|."""
    system = load_system("impact-oscillator", C=-0.6, P=0.3, omega=4.0)
    for transient in (0, 3):
        orbit = simulate(system, 4, transient=transient, record=["response", "energy"])
        response = orbit.response
        assert (response["x1_max"], response["v1_max"], response["power_in"]) == (0.6, 0.0, 0.0)
        assert response["x1_rms"] == pytest.approx(0.6, rel=1e-14)
        assert orbit.E1max == pytest.approx(0.18, rel=1e-14)


def test_sticking_ends_where_the_stop_would_pull():
    system = oscillator({"omega": 0.5, "e": 0.0}, 4.0)
    rows = simulate(system, 3).impacts
    rests = rows[rows["release"] > rows["touch"]]
    p = system.parameters
    expected = math.acos(p["k"] * p["C"] / p["P"])
    np.testing.assert_allclose(np.cos(p["omega"] * rests["release"]), np.cos(expected), rtol=1e-10)


@pytest.mark.plain
@pytest.mark.parametrize("e", [0.0, 0.9])
def test_a_damper_pressed_to_the_wall_comes_to_rest_there(e):
    system = load_system("ssul-set6", law="restitution", e=e, C=-0.2, P=100.0)
    record = ["section", "impacts", "energy"]
    orbit = simulate(system, 6, record=record)
    x1, v1, x2, v2 = orbit.section.T
    np.testing.assert_allclose(x2 - x1, system.rest + 0.2, rtol=0, atol=1e-14)
    np.testing.assert_allclose(v2, v1, rtol=0, atol=1e-15)
    assert len(orbit.impacts) == 0  # it begins there
    # damper and structure are one mass
    p = system.parameters
    flow = np.array([[0.0, 1.0], [-p["k1"], -p["c1"]]])
    flow[1] /= p["m1"] + p["m2"]
    whole = np.zeros((4, 4))
    whole[:2, :2], whole[2, 3], whole[3, 2] = flow, -p["omega"], p["omega"]
    whole[1, 2] = p["P"] / (p["m1"] + p["m2"])
    after = expm(whole * system.period) @ [x1[-2], v1[-2], 1.0, 0.0]
    np.testing.assert_allclose([x1[-1], v1[-1]], after[:2], rtol=0, atol=1e-14)
    steady = simulate(system, 1, start=orbit.state, record=record)
    looked = simulate(system, 1, start=orbit.state, record=[*record, "trajectory"], samples=2048)
    energies = looked.trajectory[:, :2] ** 2 @ [p["k1"] / 2, p["m1"] / 2]
    assert steady.E1max == pytest.approx(np.max(energies), rel=1e-5)


@pytest.mark.plain
def test_growth_ends_where_variations_do():
    flow = flow_on(load_system("ssul-set6", law="restitution", e=0.3, C=-0.2, P=100.0))
    tangent, growth = np.zeros(16), np.zeros(4)
    variations.set_identity(tangent)
    tangent[2:4] = 0.0
    tangent[4:8] = 2 * tangent[:4]
    lost = variations.lost_of(flow)
    variations.orthonormalize(tangent, 4, growth, lost)
    assert growth[0] == 0.0
    assert growth[1] == -np.inf
    assert not tangent[4:8].any()


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
    """Gamma >= pi (1 - e) / (1 + e), and < sqrt(that^2 + (2 (1 + e^2) / (1 + e)^2)^2).

    With e = 0.15 and A = g = 1, where omega^2 is Gamma, from omega = 1.52383 to 1.67027.
    """
    born = np.pi * (1 - e) / (1 + e)
    doubles = math.hypot(born, 2 * (1 + e * e) / (1 + e) ** 2)
    assert e != 0.15 or np.sqrt([born, doubles]) == pytest.approx([1.52383, 1.67027], abs=5e-6)
    for gamma, stable in (
        (born * 0.98, False),
        (born * 1.0001, True),
        (doubles * 0.9999, True),
        (doubles * 1.0001, False),
    ):
        start = bounce(max(gamma, born), e, 30.0, 1)[0]
        regime = classify(ball(gamma, e), start=start)
        assert (regime.label == "T,1") is stable, gamma
        if stable:
            assert regime.multipliers.prod().real == pytest.approx(e**2, rel=1e-8)
    # at the doubling itself a multiplier is -1: its trace is -(1 + e^2)
    flow, y = flow_on(ball(doubles, e)), np.zeros(4)
    y[:2] = bounce(doubles, e, 30.0, 1)[0]
    _, matrix = period_map(flow, y)
    assert matrix[0, 0] + matrix[1, 1] == pytest.approx(-(1 + e**2), abs=1e-7)


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
    assert rested.all() or gamma > 1.2
    if rested.all():  # every impact ends in rest: all is forgotten, and no exponent is a number
        assert abs(regime.multipliers).max() == 0.0
        assert (regime.exponents == -np.inf).all()
        assert regime.lyapunov == -np.inf


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
