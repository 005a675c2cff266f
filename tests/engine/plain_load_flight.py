"""Orbits under loads beside closed forms, 30 digits, and DOP853 that is sent anew at each event."""

import itertools
import math
from types import SimpleNamespace

import inertial
import mpmath
import numpy as np
import pytest
from flights import C1, C2, CONTACT, LOAD, fly, load_of_kernels, longest_cell
from inertial import V1, V2, X1, X2
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support import references, system_of

from nlds_vines import load_response_history, load_system, simulate
from nlds_vines.engine.batch import parts_of, room_for_impacts
from nlds_vines.kernels.cells.load_numbers import last_above
from nlds_vines.kernels.cells.load_orbit import buffers_for, fly_under
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.watch.observe import RELEASE, TOUCH
from nlds_vines.loads.run import arrays_of

mpmath.mp.dps = 30
END = 3.0  # [s]


def load_of(edges, rows, jumps=None, share=1.0):
    """Return a load of Taylor coefficients [N] of each cell, with its jumps at the edges [m/s]."""
    wide = np.zeros((len(rows), 15))
    wide[:, : rows.shape[1]] = rows
    return SimpleNamespace(edges=np.asarray(edges, float), rows=wide, jumps=jumps, share=share)


def cells(edges, force):
    """Return the load force(t) [N], a function of mpmath that is smooth within each cell."""
    rows = np.empty((len(edges) - 1, 15))
    for row, t, h in zip(rows, map(float, edges), np.diff(edges).tolist(), strict=False):
        terms = mpmath.taylor(force, t, 14, direction=1)
        row[:] = [float(c * mpmath.mpf(h) ** k) for k, c in enumerate(terms)]
    return load_of(edges, rows)


def grid(system, *kinks, end=END):
    """Return edges up to `end` that are short enough, kinks among them."""
    h, places = longest_cell(system), sorted({0.0, *kinks, end})
    pieces = (
        np.linspace(a, b, max(1, math.ceil((b - a) / h)) + 1) for a, b in itertools.pairwise(places)
    )
    return np.unique(np.concatenate([*pieces]))


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
    system, periods = load_system("ssul-set6", **LAWS[law]), 3
    P, omega = system.parameters["P"], system.parameters["omega"]
    count = math.ceil(system.period / longest_cell(system))
    edges = np.linspace(0.0, periods * system.period, periods * count + 1)
    load = cells(edges, lambda t: P * mpmath.cos(omega * t))
    record = ("impacts", "energy", "response", "clearance")
    simulated = simulate(system, periods, record=("section", *record), tolerance=1e-13, quiet=True)
    flight = fly(system, load, record=("states", "work", *record), tolerance=1e-13)
    assert np.abs(flight.states[count::count] - simulated.section).max() < 1e-11
    assert len(flight.impacts) == len(simulated.impacts) >= 2
    for column in ("touch", "release", "speed", "depth"):
        assert flight.impacts[column] == pytest.approx(
            simulated.impacts[column], rel=1e-11, nan_ok=True
        )
    assert flight.E1max == pytest.approx(simulated.E1max, rel=1e-11)
    assert flight.E2max == pytest.approx(simulated.E2max, rel=1e-11)
    assert flight.clearance == pytest.approx(simulated.clearance, rel=1e-10)
    for name, value in flight.response.items():
        assert value == pytest.approx(simulated.response[name], rel=1e-9, abs=1e-14), name


def unbalanced(flown, edges):
    """Return the largest energy that is missing after a cell, over the largest; not in contacts."""
    p, (x1, v1, x2, v2), work = flown.system.parameters, flown.states.T, flown.work
    stretch = x2 - x1 - flown.system.rest
    stored = p["m1"] * v1**2 + p["k1"] * x1**2 + p["m2"] * v2**2 + p["k2"] * stretch**2
    left = work[:, LOAD] - 0.5 * stored - work[:, [C1, C2, CONTACT]].sum(axis=1)
    touch, release = flown.impacts["touch"], flown.impacts["release"]
    inside = ((touch <= edges[:, None]) & ~(release < edges[:, None])).any(axis=1)
    return np.abs(left[~inside]).max() / np.abs(work).max()


@pytest.mark.parametrize("law", LAWS)
def test_the_balance_of_energy(law):
    system, rng = load_system("ssul-set6", **LAWS[law]), np.random.default_rng(3)
    edges = np.cumsum(np.concatenate([[1.5], rng.uniform(0.02, 0.08, 120)]))
    jumps = np.zeros(121)
    jumps[[0, 40, 41, 120]] = 0.6, -0.3, 0.2, 0.1
    load = load_of(edges, rng.normal(0, 600, (120, 4)), jumps)
    flown = fly(system, load, record=("states", "work", "impacts"), tolerance=1e-12)
    assert len(flown.impacts) >= 2
    assert unbalanced(flown, edges) < 1e-11
    assert flown.work[0, LOAD] == pytest.approx(0.5 * 1000.0 * 0.6**2)
    assert (np.diff(flown.work[:, [C1, C2]], axis=0) >= 0.0).all()


@pytest.mark.parametrize("law", LAWS)
def test_a_ground_that_moves(law):
    """Seen from it, or at rest, where its motion y is the force k1 y + c1 dy/dt on the structure.

    The acceleration a sin(w t) begins with the velocity -a / w, by a jump.
    """
    system = load_system("ssul-set6", **LAWS[law])
    p, a, w = system.parameters, 1.5, 7.0
    edges = np.linspace(0.0, 2.0, 33)
    shaken = cells(edges, lambda t: -p["m1"] * a * mpmath.sin(w * t))
    shaken.share, shaken.jumps = 0.0, np.zeros(33)
    shaken.jumps[0] = a / w

    def force(t):
        return -a / w**2 * (p["c1"] * w * mpmath.cos(w * t) + p["k1"] * mpmath.sin(w * t))

    still = cells(edges, force)
    record = ("states", "work", "impacts", "response")
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
    assert unbalanced(seen, edges) < 1e-11


def test_an_edge_changes_nothing_but_round_off():
    """A pulse cut into more cells, at any places, and the rest of an orbit from its middle."""
    system = load_system("ssul-set6")

    def pulse(t):
        return 3000 * mpmath.exp(-2 * t) * mpmath.cos(5 * t)

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
    rows, jumps = rng.normal(0, 600, (120, 4)), np.zeros(120)
    jumps[[0, 40, 41]] = 0.6, -0.3, 0.2

    def flown(unit):
        powers = {"k1": 2, "k2": 2, "K": 2, "P": 2, "c1": 1, "c2": 1, "omega": 1}
        system = system_of(
            "ssul", {name: v * unit ** -powers.get(name, 0) for name, v in numbers.items()}
        )
        load = load_of(unit * edges, rows[1:] / unit**2, jumps / unit)
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
LAST = 0.25  # [s]


class Twin(inertial.Twin):
    """A structure and a damper with one wall, from event to event."""

    def __init__(self, law, force, ground=lambda t: 0.0, **changes):
        self.system, self.touches = load_system("ssul-set6", **CHANGES[law], **changes), []
        super().__init__(self.system, force, ground)

    def start(self, v1):
        return np.array([0.0, v1, self.rest, 0.0, 0.0, 0.0])

    def integrands(self, *_):
        return []

    def solve(self, y, begin, end, **options):
        return solve_ivp(self.slopes, (begin, end), y, "DOP853", rtol=1e-12, atol=1e-14, **options)

    def follow(self, y, begin, end, pressed=False):
        """Return the state at the end, and whether the wall is pressed there; note touches."""

        def depth(_, y):
            return self.walls(y[X1], y[X2] - y[X1])[0][0]

        depth.terminal = True
        while begin < end:
            closing = y[V1] - y[V2]
            if not pressed and abs(depth(begin, y)) < 1e-11 and closing > 0.0:
                self.touches.append(begin)
                pressed = not self.rigid
                if self.rigid:
                    by = (1.0 + self.p["e"]) * closing / (1.0 / self.m1 + 1.0 / self.m2)
                    y = y - np.array([0.0, by / self.m1, 0.0, -by / self.m2, 0.0, 0.0])
            depth.direction = -1.0 if pressed else 1.0
            solution = self.solve(y, begin, end, events=depth)
            begin, y = solution.t[-1], solution.y[:, -1]
            pressed &= solution.status != 1
        return y, pressed


def load_with(twin, pieces, jumps):
    """Return the load whose force is constant [N] between the times of `pieces`, with its jumps."""
    edges, rows, sizes = [0.0], [], [jumps[0]]
    for (end, force), jump in zip(pieces, jumps[1:], strict=True):
        count = math.ceil((end - edges[-1]) / longest_cell(twin.system))
        edges += np.linspace(edges[-1], end, count + 1)[1:].tolist()
        rows += count * [[force]]
        sizes += (count - 1) * [0.0] + [jump]
    return load_of(edges, np.array(rows), np.array(sizes))


def steady(force):
    return lambda t: force


@pytest.mark.parametrize("blow", [0.5, -0.4, 0.0, -1.5])
@pytest.mark.parametrize("law", CHANGES)
def test_a_blow_or_a_kink_at_a_touch_makes_no_other_impact(law, blow):
    """The force changes there, too. Exactly at the touch, an ulp before it and an ulp after it."""
    twin = Twin(law, steady(50.0))
    first = fly(twin.system, load_with(twin, [(LAST, 50.0)], [1.0, 0.0])).impacts["touch"][0]
    expected = []  # the touch before the blow, or after it
    for late in (False, True):
        twin, pressed = Twin(law, steady(50.0)), False
        if late:
            y = twin.solve(twin.start(1.0), 0.0, first).y[:, -1]
        else:
            y, pressed = twin.follow(twin.start(1.0), 0.0, first * (1.0 + 1e-12) + 1e-13)
        y[V1] += blow
        twin.force = steady(-70.0)
        y, _ = twin.follow(y, first, LAST, pressed)
        expected.append((len(twin.touches), y[:4]))
    for at in (first, np.nextafter(first, 0.0), np.nextafter(first, 1.0)):
        pieces = load_with(twin, [(at, 50.0), (LAST, -70.0)], [1.0, blow, 0.0])
        solution = fly(twin.system, pieces)
        assert len(solution.impacts) in [count for count, _ in expected]
        errors = [np.abs(solution.state - y).max() for count, y in expected
                  if count == len(solution.impacts)]  # fmt: skip
        assert min(errors) < 1e-8, (at, errors)


def shaken_by(acceleration, system, end):
    """Return the load of a ground that begins to move the other way, evenly [m/s^2]."""
    edges = grid(system, end=end)
    return load_of(
        edges, np.full((len(edges) - 1, 1), acceleration * system.parameters["m1"]), share=0.0
    )


@pytest.mark.parametrize("law", ["hertz", "linear"])
def test_a_damper_that_rests_on_its_wall_is_pressed_by_and_by(law):
    """At C = 0 its relative acceleration begins at zero, under shaking and under a force."""
    ramp, end = 400.0, 0.12
    for pushes in (True, False):
        if pushes:
            twin = Twin(law, lambda t: ramp * t, C=0.0)
            edges = grid(twin.system, end=end)
            load = load_of(edges, np.stack([ramp * edges[:-1], ramp * np.diff(edges)], axis=1))
        else:
            twin = Twin(law, steady(0.0), steady(0.25), C=0.0)
            load = shaken_by(-0.25, twin.system, end)
        flight = fly(twin.system, load)
        x1, v1, x2, v2, y, w = twin.solve(twin.start(0.0), 0.0, end).y[:, -1]
        expected = [x1 - y, v1 - w, x2 - y, v2 - w]
        np.testing.assert_allclose(flight.state, expected, rtol=0, atol=1e-10)
        assert len(flight.impacts) == 1


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rigid_damper_that_rests_stays_until_the_wall_would_pull(e, sign):
    """One mass with the structure while it is pressed; shaken the other way it leaves at once."""
    system, end = load_system("ssul-set6", C=0.0, law="restitution", e=e), 0.12
    p, flight = system.parameters, fly(system, shaken_by(-0.25 * sign, system, end))

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
    for sign in (1.0, -1.0):
        state = fly(system, shaken_by(0.25 * sign, system, 0.12)).state
        ends.append(sign * (state - [0.0, 0.0, system.rest, 0.0]))
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-14)


def test_the_last_time_inside_a_contact_is_where_e1_falls_through_the_level():
    """A twentieth of the way from E1 at the touch to that at the release."""
    twin, end = Twin("hertz", steady(0.0)), 0.11
    load = load_with(twin, [(end, 0.0)], [1.0, 0.0])
    checked, parts = load_of_kernels(load), parts_of("exact", twin.system.scene)
    cell, state = twin.system.cell, np.zeros(STATE_SIZE)
    buffers = buffers_for(room_for_impacts(0), None, len(load.edges), 9)
    assert fly_under(parts, cell, checked, state, buffers) == OK
    touch, release = buffers.impacts.data[0, [TOUCH, RELEASE]]

    y, _ = twin.follow(twin.start(1.0), 0.0, touch)
    run = twin.solve(y, touch, release, dense_output=True)

    def energy(t):
        return twin.energies(run.sol(t))[0]

    level = 0.95 * energy(touch) + 0.05 * energy(release)
    expected = brentq(lambda t: energy(t) - level, touch, release, xtol=1e-15)
    last, _, status = last_above(parts, cell, checked, level, buffers, len(load.edges) - 2)
    assert status == OK
    assert last == pytest.approx(expected, abs=1e-10)


def test_the_last_time_at_a_rigid_impact_is_that_of_the_touch():
    """A ball falls, and loses 91 % of its energy at once; E1 is largest where it begins."""
    request = load_response_history({
        "systems": ["bouncing-ball"], "load": {"impulse": 0.5}, "sampling": {"duration": 2.0},
    })  # fmt: skip
    arrays = arrays_of(request, range(1))
    assert [arrays[f"last_{share}"][0] for share in (50, 10, 1)] == [1.0, 1.0, 1.15]
