"""Blows, kinks and starts that fall on a touch, beside DOP853, sent anew at each of them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from flights import fly, load_of_kernels, longest_cell
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from nlds_vines import load_system
from nlds_vines.kernels.cells.load_numbers import last_above
from nlds_vines.kernels.cells.load_orbit import buffers_for, fly_under
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.watch.observe import RELEASE, TOUCH
from nlds_vines.loads.request import load_response_history
from nlds_vines.loads.run import arrays_of
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.simulation import room_for_impacts

CHANGES = {
    "hertz": {"K": 1e7},
    "linear": {"law": "linear", "kc": 2e4, "cc": 0.0},
    "restitution": {"law": "restitution", "e": 0.6},
}
STIFF = {"hertz": (1e7, 1.5), "linear": (2e4, 1.0), "restitution": (0.0, 1.0)}  # K z^n
END = 0.25  # [s]


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
    first = flown(Twin(law), [(END, 50.0)], [1.0, 0.0]).impacts["touch"][0]
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
        y, _ = twin.follow(y, first, END, lambda _: -70.0, pressed)
        expected.append((len(twin.touches), y))
    for at in (first, np.nextafter(first, 0.0), np.nextafter(first, 1.0)):
        solution = flown(Twin(law), [(at, 50.0), (END, -70.0)], [1.0, blow, 0.0])
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
