"""A response against an independent solver, closed forms and the balance of power."""

import numpy as np
import pytest
from inertial import V1, V2, X1, X2, Course, Twin, W, Y
from scipy.integrate import solve_ivp
from support import NOTHING

from nlds_vines import System, load_system, simulate
from nlds_vines.kernels.events.contact import contact
from nlds_vines.kernels.laws import hertz
from paper.linear import response, steady_state

FINE = {"nodes": 24, "contact_steps": 48.0}


def displacement_of_ground(p):
    """Return the ground's displacement at t = 0, where it is at rest."""
    if "base_acceleration" in p:
        return -p["base_acceleration"] / p["omega"] ** 2
    return p.get("base_displacement", p.get("Y", 0.0))


class Responding(Twin):
    """A twin under a harmonic force or on moving ground, with sums of a response."""

    def __init__(self, system):
        p, omega = system.parameters, system.parameters["omega"]
        self.omega, self.moved = omega, displacement_of_ground(p)
        super().__init__(
            system,
            force=lambda t: p.get("P", 0.0) * np.cos(omega * t),
            ground=lambda t: -(omega**2) * self.moved * np.cos(omega * t),
        )

    def begun(self, state):
        """Return the first unknowns from the user's state, relative to the ground at t = 0."""
        x1, v1, x2, v2 = (*state, 0.0, 0.0)[:4]
        return np.array([x1 + self.moved, v1, x2 + self.moved, v2, self.moved, 0.0])

    def integrands(self, a1, lost, t, y):
        x1, v1 = y[X1] - y[Y], y[V1] - y[W]
        r, s = self.rest - y[X2] + y[X1], y[V1] - y[V2]
        into = self.force(t) * v1 - self.ground(t) * (self.m1 * v1 + self.m2 * (y[V2] - y[W]))
        return [x1**2, v1**2, a1**2, r**2, y[X1] ** 2, self.c1 * v1**2, self.c2 * s**2, lost, into]

    def response(self, start, periods):
        """Return the response of so many periods from the user's state."""
        until = periods * 2 * np.pi / self.omega
        run = solve_ivp(
            self.slopes, (0, until), np.concatenate([self.begun(start), np.zeros(9)]), "DOP853",
            rtol=1e-12, atol=1e-13, max_step=until / periods / 150, dense_output=True,
        )  # fmt: skip
        assert run.success, run.message  # where a force jumps, it may get stuck
        course, means = Course([run]), run.y[W + 1 :, -1] / until
        names = ("x1", "v1", "a1", "stroke", "x1_abs")
        numbers = {f"{name}_rms": np.sqrt(mean) for name, mean in zip(names, means, strict=False)}
        numbers |= {f"power_{k}": means[5 + i] for i, k in enumerate(("c1", "c2", "contact", "in"))}
        sizes = {
            "x1": lambda t, y: y[X1] - y[Y], "v1": lambda t, y: y[V1] - y[W],
            "a1": lambda t, y: self.at(t, y)[0], "stroke": lambda t, y: y[X2] - y[X1] - self.rest,
            "x1_abs": lambda t, y: y[X1],
        }  # fmt: skip
        numbers |= {f"{name}_max": course.largest(size)[0] for name, size in sizes.items()}
        forces = [
            course.largest(lambda t, y, i=i: self.at(t, y)[2][i])[0]
            for i in range(len(self.walls(0.0, 0.0)))
        ]
        return numbers | {"force_max": np.array(forces)}


BASE = {"base_acceleration": 1.5}
CASES = {
    "power": ("ssbl", {"law": "power", "K": 5e5, "exponent": 1.2}, "rk4"),
    "linear": ("ssbl", {"law": "linear", "kc": 2e5, "cc": 300.0}, "rk4"),
    "oscillator": ("bilinear-oscillator", {}, "exact"),
    "shaken": ("bilinear-oscillator", {"Y": 0.3}, "exact"),
    "shaken rk4": ("bilinear-oscillator", {"Y": 0.3}, "rk4"),
    "accelerated": ("bilinear-oscillator", {"base_acceleration": 0.3}, "exact"),
    "set 6": ("ssul-set6", {"base_acceleration": 1.5}, "exact"),
    "set 6 by displacement": ("ssul-set6", {"base_displacement": 0.03}, "exact"),
    "set 6 rk4": ("ssul-set6", {"base_acceleration": 1.5}, "rk4"),
    "two walls": ("ssbl", {"base_acceleration": 1.5}, "exact"),
    "linear walls": ("ssbl", {"law": "linear", "kc": 2e5, "cc": 300.0, **BASE}, "exact"),
    "power walls": ("ssbl", {"law": "power", "K": 5e5, "exponent": 1.2, **BASE}, "exact"),
}
"""Name of the catalog, changes and method; `plain_laws.py` has all others under a force."""


@pytest.mark.parametrize("case", CASES)
def test_a_response_is_that_of_an_independent_solver(case):
    name, changes, method = CASES[case]
    system = load_system(name, **changes)
    # (the orbit itself must not have time to differ)
    fine = FINE if method == "exact" else {"period_steps": 2048.0}
    start = simulate(system, 0, transient=3).state
    orbit = simulate(system, 1, start=start, method=method, record=("response",), **fine).response
    expected = Responding(system).response(start, 1)
    compared = orbit.keys() & expected.keys()
    assert len(compared) >= 8
    for key in compared:
        value, wanted = orbit[key], np.atleast_1d(expected[key])
        wanted = wanted if np.ndim(value) else wanted.max(keepdims=True)
        least = 1e-3 * abs(orbit["power_in"]) if "power" in key else 0.0
        assert np.abs(value - wanted).max() <= 1e-7 * max(np.abs(wanted).max(), least), key


def energy(system, state):
    """Return the energy stored [J], in contacts and against a weight, too."""
    twin = Responding(system)
    return twin.energies(twin.begun(state))[2]


SOFT = {"law": "power", "K": 2e6, "exponent": 1.5, "hunt_crossley": 0.3}
BALANCED = {
    "none": ("none", {}, 1e-13),
    "tmd": ("tmd", {}, 1e-13),
    "linear": ("ssul-set6", {"law": "linear", "kc": 2e6, "cc": 300.0}, 1e-13),
    "kelvin-voigt": ("ssul-set6", {"law": "kelvin-voigt", "kc": 2e6, "cc": 300.0}, 1e-13),
    "ssul": ("ssul-set6", {}, 1e-11),
    "ssul soft": ("ssul-set6", {"K": 2e5}, 1e-11),
    "ssbl": ("ssbl", {}, 1e-11),
    "hunt-crossley": ("ssul-set6", SOFT, 1e-11),
    "shaken": ("ssul-set6", BASE, 1e-11),
    "shaken tmd": ("tmd", {"base_displacement": 0.01}, 1e-13),
    "shaken sticking": ("ssbl", {"law": "restitution", "e": 0.0, **BASE}, 1e-13),
    "restitution": ("ssul-set6", {"law": "restitution", "e": 0.6}, 1e-13),
    "sticking": ("ssbl", {"law": "restitution", "e": 0.0}, 1e-13),
    "oscillator": ("impact-oscillator", {}, 1e-13),
    "ball": ("bouncing-ball", {}, 1e-12),
    "ssvi-b": ("ssvi-b", {}, 1e-11),
}
"""Name, changes, and the share of the power that comes in by which the balance may fail: round-off
where all is linear or at once, the tolerance of contacts elsewhere."""


@pytest.mark.parametrize("case", BALANCED)
def test_the_balance_of_power_closes(case):
    name, changes, precise = BALANCED[case]
    if name == "ssvi-b":
        system = System("ssvi-b", dict(load_system("ssbl").parameters))
    else:
        system = load_system(name, **changes)
    start = simulate(system, 0, transient=4, **FINE).state
    orbit = simulate(system, 5, transient=4, record=("response",), **FINE)
    response, lasting = orbit.response, 5 * system.period
    gone = response["power_c1"] + response.get("power_c2", 0.0) + response.get("power_contact", 0.0)
    gain = (energy(system, orbit.state) - energy(system, start)) / lasting
    scale = abs(response["power_in"]) + gone + abs(gain)
    assert response["power_in"] - gone == pytest.approx(gain, abs=precise * scale)
    if case in ("hunt-crossley", "linear", "restitution"):
        assert response["power_contact"] > 0.01 * response["power_in"]


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("none", {}),
        ("none", {"base_displacement": 0.01}),
        ("none", {"base_acceleration": 0.5}),
        ("tmd", {}),
        ("tmd", {"base_displacement": 0.01}),
        ("tmd", {"base_acceleration": 0.5}),
    ],
)
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_the_steady_state_without_contact_is_a_closed_form(name, changes, method):
    system = load_system(name, **changes)
    omega, start = system.parameters["omega"], steady_state(system)
    options = {"method": method} | ({"period_steps": 2048.0} if method == "rk4" else {})
    orbit = simulate(system, 1, start=start, record=("response",), **options).response
    form = response(system, np.array([omega]))
    X1, Y = complex(form.X1[0]), displacement_of_ground(system.parameters)
    sizes = {"x1": abs(X1), "v1": omega * abs(X1), "a1": omega**2 * abs(X1 + Y)}
    relative = [X1]
    if form.X2 is not None:
        relative.append(complex(form.X2[0]))
        sizes["stroke"] = abs(relative[1] - X1)
    if Y:
        sizes["x1_abs"] = abs(X1 + Y)
        assert orbit["transmissibility"] == pytest.approx(abs(X1 + Y) / abs(Y), rel=1e-10)
    precise = 1e-12 if method == "exact" else 1e-9
    for key, size in sizes.items():
        assert orbit[f"{key}_max"] == pytest.approx(size, rel=precise)
        assert orbit[f"{key}_rms"] == pytest.approx(size / np.sqrt(2), rel=precise)
    c1, masses = system.structure[2], (system.structure[0], system.parameters.get("m2"))
    forces = [system.force, 0.0]
    if Y:
        forces = [omega**2 * Y * m for m in masses if m]
    into = sum((F * X * 1j * omega).real / 2 for F, X in zip(forces, relative, strict=False))
    assert orbit["power_in"] == pytest.approx(into, rel=10 * precise)
    assert orbit["power_c1"] == pytest.approx(c1 * omega**2 * abs(X1) ** 2 / 2, rel=precise)


def test_largest_forces_and_impulses_are_those_of_the_impacts():
    system = load_system("ssul-set6", law="restitution", e=0.6)
    orbit = simulate(system, 20, transient=4, record=("response", "impacts"))
    assert not {"force_max", "a1_max", "a1_rms"} & orbit.response.keys()
    p = system.parameters
    mu = p["m1"] * p["m2"] / (p["m1"] + p["m2"])
    fastest = orbit.impacts["speed"].max()
    assert orbit.response["impulse_max"] == pytest.approx(1.6 * mu * fastest, rel=1e-12)
    orbit = simulate(load_system("ssul-set6"), 20, transient=4, record=("response", "impacts"))
    greatest = orbit.impacts["force"].max()
    assert orbit.response["force_max"] == pytest.approx(greatest, rel=1e-8)


def test_nothing_that_is_recorded_beside_changes_a_response_or_the_orbit():
    records = [("section",), ("section", "response"), ("section", "response", "energy", "impacts")]
    alone, together, more = (simulate("ssbl", 6, record=record) for record in records)
    assert np.array_equal(alone.section, together.section)
    for name, value in together.response.items():
        assert np.array_equal(value, more.response[name]), name


@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_an_impact_that_is_known_adds_what_it_adds_when_stepped(name, monkeypatch):
    system, record = load_system(name, base_displacement=0.03), ("response", "section")
    recalled = simulate(system, 6, transient=2, record=record)
    called = []

    def anew(side, tally, phase, now, after):
        called.append(now)
        contact(side, NOTHING._replace(tally=tally), phase, now, np.inf)

    monkeypatch.setattr(hertz, "tally_inside", anew)
    stepped = simulate(system, 6, transient=2, record=record)
    assert len(called) >= 3
    assert np.array_equal(recalled.section, stepped.section)
    for key, value in recalled.response.items():
        assert value == pytest.approx(stepped.response[key], rel=1e-12), key
