"""Orbits under loads beside closed forms, 30 digits, and DOP853 that is sent anew at each event."""

import itertools
import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from flights import C1, C2, CONTACT, LOAD, fly, load_of_kernels, longest_cell
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support import references, system_of

from nlds_vines import load_system, simulate
from nlds_vines.kernels.cells.load_numbers import last_above
from nlds_vines.kernels.cells.load_orbit import buffers_for, fly_under
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.watch.observe import RELEASE, TOUCH
from nlds_vines.loads.request import load_response_history
from nlds_vines.loads.run import arrays_of
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.simulation import room_for_impacts

mpmath.mp.dps = 30
END = 3.0  # [s]


def cells(edges, coefficients):
    """Return a load whose force has Taylor `coefficients(t, h)` over the cell [t, t + h]."""
    edges = np.asarray(edges, float)
    rows = np.zeros((len(edges) - 1, 15))
    for j, (t, h) in enumerate(zip(edges, np.diff(edges), strict=False)):
        values = [float(c) for c in coefficients(t, h)]
        rows[j, : len(values)] = values
    return SimpleNamespace(edges=edges, rows=rows, jumps=None, share=1.0)


def waves(parts):
    """Return the coefficients of a sum of Re(a exp(rate t)), (a, rate) one of the `parts`."""

    def coefficients(t, h):
        t, h = mpmath.mpf(t), mpmath.mpf(h)
        terms = [[a * mpmath.exp(rate * t), rate * h] for a, rate in parts]
        return [mpmath.re(sum(a * x**k for a, x in terms)) / mpmath.factorial(k) for k in range(15)]

    return coefficients


def matrix_of(system):
    """Return (A, b) of y' = A y + b f, y = (x1, v1[, x2 - its rest, v2]) and f in N."""
    p = {name: mpmath.mpf(value) for name, value in system.parameters.items()}
    if not system.scene.damper:
        return mpmath.matrix([[0, 1], [-p["k1"] / p["m1"], -p["c1"] / p["m1"]]]), [0, 1 / p["m1"]]
    k2, c2, m1, m2 = p["k2"], p["c2"], p["m1"], p["m2"]
    rows = [
        [0, 1, 0, 0],
        [-(p["k1"] + k2) / m1, -(p["c1"] + c2) / m1, k2 / m1, c2 / m1],
        [0, 0, 0, 1],
        [k2 / m2, c2 / m2, -k2 / m2, -c2 / m2],
    ]
    return mpmath.matrix(rows), [0, 1 / m1, 0, 0]


def under_linear(system, y, S, z, time):
    """Return y after a time under the force z[0], where z' = S z: one matrix exponential."""
    A, b = matrix_of(system)
    n, m = A.rows, S.rows
    M = mpmath.zeros(n + m)
    M[:n, :n], M[n:, n:] = A, S
    for i in range(n):
        M[i, n] = b[i]
    w = mpmath.expm(M * mpmath.mpf(time), method="taylor") * mpmath.matrix([*y, *z])
    return [w[i] for i in range(n)], [w[n + i] for i in range(m)]


def under_any(system, force, time):
    """Return y after a time under any force, from rest, by quadrature of Duhamel's integral."""
    A, b = matrix_of(system)
    E, right = mpmath.eig(A)
    left = mpmath.inverse(right) * mpmath.matrix(b)
    T, states = mpmath.mpf(time), []
    pieces = [T * i / 8 for i in range(9)]
    for i in range(A.rows):
        part = mpmath.quad(lambda s: mpmath.exp(E[i] * (T - s)) * force(s), pieces)  # noqa: B023
        states.append(part * left[i])
    y = right * mpmath.matrix(states)
    return [mpmath.re(y[i]) for i in range(A.rows)]


def grid(system, *kinks, end=END):
    """Return edges up to `end` that are short enough, kinks among them."""
    h, places = longest_cell(system), sorted({0.0, *kinks, end})
    pieces = (
        np.linspace(a, b, max(1, math.ceil((b - a) / h)) + 1) for a, b in itertools.pairwise(places)
    )
    return np.unique(np.concatenate([*pieces]))


def agrees(system, load, expected):
    """Compare the last state with an expected one; both in scales of the motion."""
    flown = fly(system, load, record=("states", "work"))
    scale = np.abs(flown.states).max(axis=0)
    off = np.abs((flown.states[-1] - [float(x) for x in expected]) / scale)
    assert off.max() < 1e-11
    return flown


LINEAR = ("none", "tmd")


@pytest.mark.parametrize("name", LINEAR)
def test_a_half_sine(name):
    system, time = load_system(name), 0.4
    turn = math.pi / time
    pulse = waves([(-1000j, 1j * mpmath.mpf(turn))])
    load = cells(grid(system, time), lambda t, h: pulse(t, h) if t < time - 1e-9 else [0.0])
    size = len(fly(system, load).state)
    S = mpmath.matrix([[0, 1], [-(mpmath.mpf(turn) ** 2), 0]])
    y, _ = under_linear(system, [0] * size, S, [0, 1000 * mpmath.mpf(turn)], time)
    y, _ = under_linear(system, y, S, [0, 0], mpmath.mpf(END) - mpmath.mpf(time))
    agrees(system, load, y)


@pytest.mark.parametrize("name", LINEAR)
def test_a_friedlander_pulse(name):
    """P (1 - t / td) exp(-b t): of z = (f, exp(-b t)) with f' = -b f - P exp(-b t) / td."""
    system, P, td, b = load_system(name), 2000, mpmath.mpf(0.25), mpmath.mpf(3)

    def blast(t, h):
        t, h = mpmath.mpf(t), mpmath.mpf(h)
        terms = [mpmath.exp(-b * t) * (-b * h) ** k / mpmath.factorial(k) for k in range(15)]
        first = 1 - t / td
        return [P * (first * c - h / td * d) for c, d in zip(terms, [0, *terms], strict=False)]

    load = cells(grid(system), blast)
    size = len(fly(system, load).state)
    S = mpmath.matrix([[-b, -P / td], [0, -b]])
    y, _ = under_linear(system, [0] * size, S, [P, 1], END)
    agrees(system, load, y)


@pytest.mark.parametrize("degree", [1, 3])
@pytest.mark.parametrize("name", LINEAR)
def test_a_record(name, degree):
    """Samples 0.05 s apart with lines or cubics between them, as good as any force is."""
    system, rng = load_system(name), np.random.default_rng(5)
    edges = np.round(np.arange(0, 61) * 0.05, 12)
    rows = np.zeros((60, 15))
    rows[:, : degree + 1] = rng.normal(0, 500, (60, degree + 1))
    if degree == 1:  # without jumps
        values = rng.normal(0, 500, 61)
        rows[:, 0], rows[:, 1] = values[:-1], np.diff(values)
    load = SimpleNamespace(edges=edges, rows=rows, jumps=None, share=1.0)
    y = [mpmath.mpf(0)] * len(fly(system, load).state)
    S = mpmath.zeros(degree + 1)
    for k in range(degree):
        S[k, k + 1] = 1
    for row, a, b in zip(rows, edges, edges[1:], strict=False):
        h = mpmath.mpf(b) - mpmath.mpf(a)
        z = [mpmath.mpf(c) * mpmath.factorial(k) / h**k for k, c in enumerate(row[: degree + 1])]
        y, _ = under_linear(system, y, S, z, h)
    flown = agrees(system, load, y)
    assert flown.times[-1] == 3.0


@pytest.mark.parametrize("name", LINEAR)
def test_a_sweep(name):
    """The force P sin(a t + b t^2 / 2), from 4 to 6.5 rad/s, by Duhamel's integral."""
    system, P, a, b = load_system(name), 800, mpmath.mpf(4), mpmath.mpf(5) / 6

    def force(t):
        return P * mpmath.sin(a * t + b * t * t / 2)

    def sweep(t, h):
        # Taylor coefficients of cos and sin of a polynomial of degree two, by their equations
        t, h = mpmath.mpf(t), mpmath.mpf(h)
        one, two = (a + b * t) * h, b * h * h / 2
        start = a * t + b * t * t / 2
        c, s = [mpmath.cos(start)], [mpmath.sin(start)]
        for k in range(14):
            before = k - 1 >= 0
            c.append(-(one * s[k] + (2 * two * s[k - 1] if before else 0)) / (k + 1))
            s.append((one * c[k] + (2 * two * c[k - 1] if before else 0)) / (k + 1))
        return [P * x for x in s]

    edges = np.linspace(0.0, END, math.ceil(END / (0.5 * longest_cell(system))) + 1)
    agrees(system, cells(edges, sweep), under_any(system, force, END))


LAWS = {
    "hertz": {},
    "hunt-crossley": {"hunt_crossley": 0.2},
    "power": {"law": "power", "K": 3e6, "exponent": 1.3},
    "linear": {"law": "linear", "kc": 1e5, "cc": 100.0},
    "restitution": {"law": "restitution", "e": 0.7},
}


@pytest.mark.parametrize("law", LAWS)
def test_the_harmonic_force_as_a_load(law):
    """Every law and record: what `simulate` finds, which knows of no load."""
    system, periods = load_system("ssul-set6", **LAWS[law]), 4
    P, omega = system.parameters["P"], system.parameters["omega"]
    count = math.ceil(system.period / longest_cell(system))
    edges = np.linspace(0.0, periods * system.period, periods * count + 1)
    load = cells(edges, waves([(mpmath.mpf(P), 1j * mpmath.mpf(omega))]))
    record = ("impacts", "energy", "response", "clearance")
    simulated = simulate(system, periods, record=("section", *record), tolerance=1e-13, quiet=True)
    flight = fly(system, load, record=("states", "work", *record), tolerance=1e-13)
    assert np.abs(flight.states[count::count] - simulated.section).max() < 1e-11
    assert len(flight.impacts) == len(simulated.impacts) > 2
    for column in ("touch", "release", "speed", "depth"):
        assert flight.impacts[column] == pytest.approx(
            simulated.impacts[column], rel=1e-11, nan_ok=True
        )
    assert flight.E1max == pytest.approx(simulated.E1max, rel=1e-11)
    assert flight.E2max == pytest.approx(simulated.E2max, rel=1e-11)
    assert flight.clearance == pytest.approx(simulated.clearance, rel=1e-10)
    for name, value in flight.response.items():
        assert value == pytest.approx(simulated.response[name], rel=1e-9, abs=1e-14), name


def stored(system, states):
    """Return the energy [J] of both bodies and their springs."""
    p, (x1, v1, x2, v2) = system.parameters, states.T
    stretch = x2 - x1 - (system.rest or 0.0)
    return 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2 + p["m2"] * v2**2 + p["k2"] * stretch**2)


@pytest.mark.parametrize("law", LAWS)
def test_the_balance_of_energy(law):
    """What force and blows bring in is stored or dissipated, after each cell but in contacts."""
    system, rng = load_system("ssul-set6", **LAWS[law]), np.random.default_rng(3)
    edges = np.cumsum(np.concatenate([[1.5], rng.uniform(0.02, 0.08, 120)]))
    rows = np.zeros((120, 15))
    rows[:, :4] = rng.normal(0, 600, (120, 4))
    jumps = np.zeros(121)
    jumps[[0, 40, 41, 120]] = 0.6, -0.3, 0.2, 0.1
    load = SimpleNamespace(edges=edges, rows=rows, jumps=jumps, share=1.0)
    flown = fly(system, load, record=("states", "work", "impacts"), tolerance=1e-12)
    work = flown.work
    left = work[:, LOAD] - stored(system, flown.states) - work[:, [C1, C2, CONTACT]].sum(axis=1)
    touch, release = flown.impacts["touch"], flown.impacts["release"]
    inside = ((touch <= edges[:, None]) & ~(release < edges[:, None])).any(axis=1)
    assert len(touch) >= 2
    assert np.abs(left[~inside]).max() < 1e-11 * np.abs(work).max()
    assert work[0, LOAD] == pytest.approx(0.5 * 1000.0 * 0.6**2)
    assert (np.diff(work[:, [C1, C2]], axis=0) >= 0.0).all()


@pytest.mark.parametrize("law", LAWS)
def test_a_ground_that_moves(law):
    """Seen from it, or at rest, where its motion y is the force k1 y + c1 dy/dt on the structure.

    The acceleration a sin(w t) begins with the velocity -a / w, by a jump.
    """
    system = load_system("ssul-set6", **LAWS[law])
    p, a, w = system.parameters, 1.5, 7.0
    edges, rate = np.linspace(0.0, 3.0, 50), 1j * mpmath.mpf(w)
    shaken = cells(edges, waves([(mpmath.mpc(0, p["m1"] * a), rate)]))
    shaken.share, shaken.jumps = 0.0, np.zeros(50)
    shaken.jumps[0] = a / w
    still = cells(edges, waves([(mpmath.mpc(-p["c1"] * w, p["k1"]) * a / w**2, rate)]))
    record = ("states", "work", "impacts", "response", "energy")
    seen, expected = (fly(system, load, record=record, tolerance=1e-13) for load in (shaken, still))
    y, speed = -a / w**2 * np.sin(w * edges), -a / w * np.cos(w * edges)
    moved = np.column_stack([y, speed, y, speed])
    assert np.abs(seen.states + moved - expected.states).max() < 1e-11
    assert len(seen.impacts) == len(expected.impacts) >= 2
    for column in ("touch", "speed", "depth"):
        assert seen.impacts[column] == pytest.approx(expected.impacts[column], rel=1e-10)
    for name in ("stroke_max", "a1_max", "a1_rms", "force_max", "impulse_max", "power_c2"):
        if name in seen.response:
            assert seen.response[name] == pytest.approx(expected.response[name], rel=1e-9)
    gone = seen.work[:, [C1, C2, CONTACT]].sum(axis=1)
    left = seen.work[:, LOAD] - stored(system, seen.states) - gone
    touch, release = seen.impacts["touch"], seen.impacts["release"]
    inside = ((touch <= edges[:, None]) & ~(release < edges[:, None])).any(axis=1)
    assert np.abs(left[~inside]).max() < 1e-11 * np.abs(seen.work).max()
    x1, v1, x2, v2 = seen.states.T
    E1 = 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2)
    E2 = 0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - system.rest) ** 2)
    assert E1.max() <= seen.E1max * (1 + 1e-12) < 1.1 * E1.max()
    assert E2.max() <= seen.E2max * (1 + 1e-12) < 1.2 * E2.max()


def test_an_edge_changes_nothing_but_round_off():
    """A pulse cut into more cells, at any places, and the rest of an orbit from its middle."""
    system = load_system("ssul-set6")
    pulse = waves([(3000, mpmath.mpc(-2, 5))])
    coarse = np.linspace(0.0, 1.6, 23)
    fine = np.union1d(coarse, [0.0931, 0.5, 0.50001, 1.2])
    one, two = (fly(system, cells(edges, pulse), tolerance=1e-12) for edges in (coarse, fine))
    among = np.searchsorted(fine, coarse)
    assert np.abs(two.states[among] - one.states).max() < 1e-12
    assert two.impacts["touch"] == pytest.approx(one.impacts["touch"], abs=1e-12)
    later = cells(coarse[11:], pulse)
    rest = fly(system, later, start=one.states[11], tolerance=1e-12)
    assert np.abs(rest.states - one.states[11:]).max() < 1e-12


@pytest.mark.parametrize("stiffness", [{}, {"K": 3e5}], ids=["solved at once", "stepped"])
def test_no_unit_of_time_changes_an_orbit(stiffness):
    """Units of 2^60 and 2^-60 s: not a bit. Lengths and masses stay, forces go with the square."""
    numbers = {**references()["ssul-set6"].numbers, **stiffness}
    rng = np.random.default_rng(3)
    edges = np.cumsum(rng.uniform(0.02, 0.08, 120))
    rows, jumps = np.zeros((120, 15)), np.zeros(120)
    rows[:, :4] = rng.normal(0, 600, (120, 4))
    jumps[[0, 40, 41]] = 0.6, -0.3, 0.2

    def flown(unit):
        powers = {"k1": 2, "k2": 2, "K": 2, "P": 2, "c1": 1, "c2": 1, "omega": 1}
        system = system_of(
            "ssul", {name: v * unit ** -powers.get(name, 0) for name, v in numbers.items()}
        )
        load = SimpleNamespace(
            edges=unit * edges, rows=rows[1:] / unit**2, jumps=jumps / unit, share=1.0
        )
        flight = fly(system, load, record=("states", "impacts", "energy", "response"))
        states = flight.states * [1, unit, 1, unit]
        return states, flight.impacts["touch"] / unit, flight.response["a1_max"] * unit**2

    plain = flown(1.0)
    assert len(plain[1]) >= 5
    for unit in (2.0**60, 2.0**-60):
        for mine, there in zip(flown(unit), plain, strict=True):
            np.testing.assert_array_equal(mine, there)


CHANGES = {
    "hertz": {"K": 1e7},
    "linear": {"law": "linear", "kc": 2e4, "cc": 0.0},
    "restitution": {"law": "restitution", "e": 0.6},
}
STIFF = {"hertz": (1e7, 1.5), "linear": (2e4, 1.0), "restitution": (0.0, 1.0)}  # K z^n
LAST = 0.25  # [s]


class Twin:
    """A structure and a damper with one wall, y = (x1, v1, x2, v2), from event to event."""

    def __init__(self, law, **changes):
        self.system = load_system("ssul-set6", **CHANGES[law], **changes)
        self.law, self.p, self.touches = law, self.system.parameters, []
        self.gap = float(self.system.cell.near)

    def closing(self, y):
        """Return how far r = x1 - x2 + rest is beyond the wall, and its rate."""
        return y[0] - y[2] + self.system.rest - self.gap, y[1] - y[3]

    def rate(self, _, y, force, shaking, pressed):
        p, (z, s), (K, n) = self.p, self.closing(y), STIFF[self.law]
        push = p["k2"] * (z + self.gap) + p["c2"] * s
        if pressed and z > 0.0:
            push += K * z**n
        push_on_structure = force(_) - p["k1"] * y[0] - p["c1"] * y[1] - push
        return y[1], push_on_structure / p["m1"] - shaking, y[3], push / p["m2"] - shaking

    def solve(self, y, begin, end, force, shaking=0.0, pressed=False, events=None):
        return solve_ivp(
            self.rate, (begin, end), y, "DOP853", rtol=1e-12, atol=1e-14, events=events,
            args=(force, shaking, pressed),
        )  # fmt: skip

    def follow(self, y, begin, end, force, pressed=False):
        """Return the state at the end, and whether the wall is pressed there; note touches."""
        while begin < end:
            z, s = self.closing(y)
            if not pressed and abs(z) < 1e-11 and s > 0.0:
                self.touches.append(begin)
                if self.law == "restitution":
                    by = (1.0 + self.p["e"]) * s / (1.0 / self.p["m1"] + 1.0 / self.p["m2"])
                    y = y - np.array([0.0, by / self.p["m1"], 0.0, -by / self.p["m2"]])
                else:
                    pressed = True

            def crossing(_, y, *args):
                return self.closing(y)[0]

            crossing.terminal, crossing.direction = True, -1.0 if pressed else 1.0
            solution = self.solve(y, begin, end, force, pressed=pressed, events=crossing)
            begin, y = solution.t[-1], solution.y[:, -1]
            if solution.status == 1:
                pressed = False
        return y, pressed


def load_with(twin, pieces, jumps):
    """Return the load whose force is constant [N] between the times of `pieces`, with its jumps."""
    edges, rows, sizes = [0.0], [], [jumps[0]]
    for (end, force), jump in zip(pieces, jumps[1:], strict=True):
        count = math.ceil((end - edges[-1]) / longest_cell(twin.system))
        edges += np.linspace(edges[-1], end, count + 1)[1:].tolist()
        rows += count * [[force] + 14 * [0.0]]
        sizes += (count - 1) * [0.0] + [jump]
    return SimpleNamespace(
        edges=np.array(edges), rows=np.array(rows), jumps=np.array(sizes), share=1.0
    )


def flown(twin, pieces, jumps):
    return fly(twin.system, load_with(twin, pieces, jumps))


@pytest.mark.parametrize("blow", [0.5, -0.4, 0.0, -1.5])
@pytest.mark.parametrize("law", CHANGES)
def test_a_blow_or_a_kink_at_a_touch_makes_no_other_impact(law, blow):
    """The force changes there, too. Exactly at the touch, an ulp before it and an ulp after it."""
    first = flown(Twin(law), [(LAST, 50.0)], [1.0, 0.0]).impacts["touch"][0]
    expected = []  # the touch before the blow, or after it
    for late in (False, True):
        twin = Twin(law)
        start = np.array([0.0, 1.0, twin.system.rest, 0.0])
        y, pressed = twin.follow(start, 0.0, first * (1.0 + 1e-12) + 1e-13, lambda _: 50.0)
        if late:
            twin = Twin(law)
            solution = twin.solve(start, 0.0, first, lambda _: 50.0)
            y, pressed = solution.y[:, -1], False
        y = y + np.array([0.0, blow, 0.0, 0.0])
        y, _ = twin.follow(y, first, LAST, lambda _: -70.0, pressed)
        expected.append((len(twin.touches), y))
    for at in (first, np.nextafter(first, 0.0), np.nextafter(first, 1.0)):
        solution = flown(Twin(law), [(at, 50.0), (LAST, -70.0)], [1.0, blow, 0.0])
        assert len(solution.impacts) in [count for count, _ in expected]
        errors = [np.abs(solution.state - y).max() for count, y in expected
                  if count == len(solution.impacts)]  # fmt: skip
        assert min(errors) < 1e-8, (at, errors)


@pytest.mark.parametrize("law", ["hertz", "linear"])
def test_a_damper_that_rests_on_its_wall_is_pressed_by_and_by(law):
    """At C = 0 its relative acceleration begins at zero, under shaking and under a force."""
    ramp, end = 400.0, 0.12
    for pushes in (True, False):
        twin = Twin(law, C=0.0)
        count = math.ceil(end / longest_cell(twin.system))
        edges = np.linspace(0.0, end, count + 1)
        rows = np.zeros((count, 15))
        rows[:, 0] = ramp * edges[:-1] if pushes else -0.25 * twin.p["m1"]
        rows[:, 1] = ramp * np.diff(edges) if pushes else 0.0
        load = SimpleNamespace(edges=edges, rows=rows, jumps=None, share=1.0 if pushes else 0.0)
        flight = fly(twin.system, load)
        start = np.array([0.0, 0.0, twin.system.rest, 0.0])
        force = (lambda t: ramp * t) if pushes else (lambda _: 0.0)
        y = twin.solve(start, 0.0, end, force, 0.0 if pushes else 0.25, True).y[:, -1]
        np.testing.assert_allclose(flight.state, y, rtol=0, atol=1e-10)
        assert len(flight.impacts) == 1


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rigid_damper_that_rests_stays_until_the_wall_would_pull(e, sign):
    """One mass with the structure while it is pressed; shaken the other way it leaves at once."""
    system, end = load_system("ssul-set6", C=0.0, law="restitution", e=e), 0.12
    p, count = system.parameters, math.ceil(0.12 / longest_cell(system))
    rows = np.zeros((count, 15))
    rows[:, 0] = -sign * 0.25 * p["m1"]
    load = SimpleNamespace(edges=np.linspace(0.0, end, count + 1), rows=rows, jumps=None, share=0.0)
    flight = fly(system, load)

    def rate(_, y):
        if sign > 0.0:
            push_on_structure = -(p["k1"] * y[0] + p["c1"] * y[1]) / (p["m1"] + p["m2"]) - 0.25
            return y[1], push_on_structure, y[1], push_on_structure
        push = p["k2"] * (y[0] - y[2] + system.rest) + p["c2"] * (y[1] - y[3])
        push_on_structure = -(p["k1"] * y[0] + p["c1"] * y[1] + push) / p["m1"] + 0.25
        return y[1], push_on_structure, y[3], push / p["m2"] + 0.25

    start = [0.0, 0.0, system.rest, 0.0]
    y = solve_ivp(rate, (0.0, end), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    np.testing.assert_allclose(flight.state, y, rtol=0, atol=1e-11)
    assert len(flight.impacts) == 0


def test_two_walls_without_clearance_are_mirror_images():
    system, ends = load_system("ssbl", C=0.0, D=0.0), []
    count = math.ceil(0.12 / longest_cell(system))
    for sign in (1.0, -1.0):
        rows = np.zeros((count, 15))
        rows[:, 0] = sign * 0.25 * system.parameters["m1"]
        edges = np.linspace(0.0, 0.12, count + 1)
        load = SimpleNamespace(edges=edges, rows=rows, jumps=None, share=0.0)
        ends.append(sign * (fly(system, load).state - [0.0, 0.0, system.rest, 0.0]))
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-14)


def test_the_last_time_inside_a_contact_is_where_e1_falls_through_the_level():
    """A twentieth of the way from E1 at the touch to that at the release."""
    twin, end = Twin("hertz"), 0.11
    load = load_with(twin, [(end, 0.0)], [1.0, 0.0])
    checked, parts = load_of_kernels(load), parts_of("exact", twin.system.scene)
    cell, state = twin.system.cell, np.zeros(STATE_SIZE)
    buffers = buffers_for(room_for_impacts(0), None, len(load.edges), 9)
    assert fly_under(parts, cell, checked, state, buffers) == OK
    touch, release = buffers.impacts.data[0, [TOUCH, RELEASE]]

    start, p = np.array([0.0, 1.0, twin.system.rest, 0.0]), twin.p
    y, _ = twin.follow(start, 0.0, touch, lambda _: 0.0)
    run = solve_ivp(
        twin.rate, (touch, release), y, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True,
        args=(lambda _: 0.0, 0.0, True),
    )  # fmt: skip

    def energy(t):
        x1, v1 = run.sol(t)[:2]
        return 0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2)

    level = 0.95 * energy(touch) + 0.05 * energy(release)
    expected = brentq(lambda t: energy(t) - level, touch, release, xtol=1e-15)
    last, _, status = last_above(parts, cell, checked, level, buffers, len(load.edges) - 2)
    assert status == OK
    assert last == pytest.approx(expected, abs=1e-10)


def test_the_last_time_at_a_rigid_impact_is_that_of_the_touch():
    """A ball falls, and loses 91 % of its energy at once; E1 is largest where it begins."""
    request = load_response_history({
        "systems": ["bouncing-ball"], "load": {"impulse": 0.5}, "sampling": {"duration": 3.0},
    })  # fmt: skip
    arrays = arrays_of(request, range(1))
    assert [arrays[f"last_{share}"][0] for share in (50, 10, 1)] == [1.0, 1.0, 1.15]
