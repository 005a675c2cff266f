"""A response against an independent solver, closed forms and the balance of power, kernels plain.

The solver is SciPy's DOP853, with integrals among its unknowns; what is largest is searched for in
its dense output.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from support import NOTHING

from nlds_vines.kernels.events.contact import contact
from nlds_vines.kernels.laws import hertz
from nlds_vines.model.catalog import load_system
from nlds_vines.model.linear_response import response, steady_state
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import simulate

FINE = {"nodes": 24, "contact_steps": 48.0}
NAMES = ("x1", "v1", "a1", "stroke")


class Twin:
    """The equation of motion with its walls and its foot, written from the parameters alone."""

    def __init__(self, system):
        cell, p = system.cells(), system.parameters
        self.system, self.law = system, system.law
        self.m1, self.k1, self.c1 = system.structure
        damped = system.scene.damper
        self.m2, self.k2, self.c2 = (
            (float(cell[n]) for n in ("m2", "k2", "c2")) if damped else [0] * 3
        )
        self.P, self.omega, self.rest = float(cell["P"]), p["omega"], system.rest or 0.0
        self.damped, self.Y = damped, system.foot
        self.shaken = p.get("Y", 0.0) * p["omega"] ** 2  # of a ground from which x1 counts
        walls = system.scene.walls
        self.near = float(cell["near"]) if "near" in walls else np.inf
        self.far = float(cell["far"]) if "far" in walls else np.inf
        self.constants = system.contact(walls[0]) if walls else {}

    def elastic(self, z):
        c = self.constants
        if z <= 0:
            return 0.0
        return c["kc"] * z if "kc" in c else c["K"] * z ** c.get("exponent", 1.5)

    def force(self, z, s):
        c, elastic = self.constants, self.elastic(z)
        if z <= 0:
            return 0.0
        if "kc" in c:
            whole = elastic + c["cc"] * s
            return whole if self.law == "kelvin-voigt" else max(0.0, whole)
        return elastic * max(0.0, 1 + c.get("hunt_crossley", 0.0) * s)

    def ground(self, t):
        turn = np.exp(1j * self.omega * t)
        return (self.Y * turn).real, (1j * self.omega * self.Y * turn).real

    def at(self, t, y):
        """Return (a1, ds/dt, near and far force, power lost there, x1 - y, its rate, power)."""
        x1, v1, r, s = y[:4]
        near, far = self.force(r - self.near, s), self.force(-r - self.far, -s)
        lost = (near - self.elastic(r - self.near)) * s - (far - self.elastic(-r - self.far)) * s
        pull = near - far + self.k2 * r + self.c2 * s
        if self.Y is None:
            gone, rate, load = x1, v1, self.P * np.cos(self.omega * t)
            into = load * v1
        else:
            y0, y1 = self.ground(t)
            gone, rate, load = x1 - y0, v1 - y1, 0.0
            into = -(self.k1 * gone + self.c1 * rate) * y1
        a1 = (load - self.k1 * gone - self.c1 * rate - pull) / self.m1
        ds = a1 - pull / self.m2 if self.damped else a1
        return a1, ds, near, far, lost, gone, rate, into

    def absolute(self, t, y):
        """Return the absolute acceleration: the ground moves by Y cos(omega t)."""
        return self.at(t, y)[0] - self.shaken * np.cos(self.omega * t)

    def slopes(self, t, y):
        x1, v1, r, s = y[:4]
        a1, ds, _, _, lost, gone, rate, into = self.at(t, y)
        works = [x1**2, v1**2, self.absolute(t, y) ** 2, r**2, s**2, gone**2, rate**2, lost, into]
        return [v1, a1, s, ds, *works]

    def response(self, start, periods):
        """Return the response of so many periods from the kernels' state (x1, v1, r, s)."""
        until = periods * 2 * np.pi / self.omega
        y0 = np.concatenate([start, np.zeros(9)])
        run = solve_ivp(
            self.slopes, (0, until), y0, "DOP853", rtol=1e-12, atol=1e-13,
            max_step=until / periods / 600, dense_output=True,
        )  # fmt: skip
        assert run.success, run.message  # where a force jumps, it may get stuck
        sums = run.y[4:, -1]
        numbers = dict(zip([f"{n}_rms" for n in NAMES], np.sqrt(sums[:4] / until), strict=True))
        numbers["drift_rms"] = np.sqrt(sums[5] / until)
        numbers["power_c1"] = self.c1 * sums[6] / until
        numbers["power_c2"] = self.c2 * sums[4] / until
        numbers["power_contact"], numbers["power_in"] = sums[7:9] / until
        sizes = {
            "x1_max": lambda t, y: abs(y[0]), "v1_max": lambda t, y: abs(y[1]),
            "stroke_max": lambda t, y: abs(y[2]), "drift_max": lambda t, y: abs(self.at(t, y)[5]),
            "a1_max": lambda t, y: abs(self.absolute(t, y)),
        }  # fmt: skip
        numbers |= {name: largest(run, size) for name, size in sizes.items()}
        forces = [largest(run, lambda t, y, i=i: self.at(t, y)[i]) for i in (2, 3)]
        return numbers | {"force_max": forces}


def largest(run, size):
    values = np.array([size(t, y) for t, y in zip(run.t, run.y.T, strict=True)])
    top = values.max()
    for i in range(1, len(values) - 1):
        if values[i] > 0.9 * top and values[i] >= max(values[i - 1], values[i + 1]):
            ends, options = (run.t[i - 1], run.t[i + 1]), {"xatol": 1e-11}
            peak = minimize_scalar(
                lambda t: -size(t, run.sol(t)), bounds=ends, method="bounded", options=options
            )
            top = max(top, -peak.fun)
    return top


def kernel_state(system, state):
    """Return (x1, v1, r, s) of a state in the user's coordinates."""
    if not system.scene.damper:
        x1, v1 = state
        return np.array([x1, v1, x1, v1])
    x1, v1, x2, v2 = state
    return np.array([x1, v1, x1 - x2 + system.rest, v1 - v2])


CASES = {
    "none": ("none", {}, "exact"),
    "tmd": ("tmd", {}, "exact"),
    "ssul": ("ssul-set6", {}, "exact"),
    "ssul soft": ("ssul-set6", {"K": 2e5}, "exact"),
    "ssbl": ("ssbl", {}, "exact"),
    "hunt-crossley": (
        "ssul-set6",
        {"law": "power", "K": 2e6, "exponent": 1.5, "hunt_crossley": 0.3},
        "exact",
    ),
    "power": ("ssbl", {"law": "power", "K": 5e5, "exponent": 1.2}, "rk4"),
    "linear": ("ssul-set6", {"law": "linear", "kc": 2e6, "cc": 300.0}, "exact"),
    "linear ssbl": ("ssbl", {"law": "linear", "kc": 2e5, "cc": 300.0}, "rk4"),
    "kelvin-voigt": ("ssul-set6", {"law": "kelvin-voigt", "kc": 2e6, "cc": 300.0}, "exact"),
    "oscillator": ("bilinear-oscillator", {}, "exact"),
    "shaken oscillator": ("bilinear-oscillator", {"Y": 0.3}, "exact"),
    "shaken oscillator rk4": ("bilinear-oscillator", {"Y": 0.3}, "rk4"),
    "foot": ("ssul-set6", {"base_acceleration": 1.5}, "exact"),
    "foot rk4": ("tmd", {"base_displacement": 0.01}, "rk4"),
}
"""Name of the catalog, changes and method."""


@pytest.mark.parametrize("case", CASES)
def test_a_response_is_that_of_an_independent_solver(case):
    name, changes, method = CASES[case]
    system = load_system(name, **changes)
    # (a short run of many periods: the orbit itself must not have time to differ)
    fine = FINE if method == "exact" else {"period_steps": 2048.0}
    start = simulate(system, 0, transient=3).state
    orbit = simulate(system, 2, start=start, method=method, record=("response",), **fine).response
    expected = Twin(system).response(kernel_state(system, start), 2)
    seen = 0
    for key, value in orbit.items():
        if key in expected:
            wanted = np.atleast_1d(expected[key])
            wanted = wanted if np.ndim(value) else wanted.max(keepdims=True)
            scale = max(
                np.abs(wanted).max(), 1e-3 * abs(orbit["power_in"]) if "power" in key else 0
            )
            assert np.abs(value - wanted).max() <= 1e-7 * scale, key
            seen += 1
    assert seen >= 8


def energy(system, state):
    """Return the energy stored [J], in contacts and against a weight, too."""
    twin = Twin(system)
    x1, v1, r, s = kernel_state(system, state)
    stored = twin.k1 * x1**2 + twin.m1 * v1**2
    if twin.Y is not None:
        y0 = twin.ground(0.0)[0]
        stored += twin.k1 * ((x1 - y0) ** 2 - x1**2)
    if twin.damped:
        stored += twin.k2 * r**2 + twin.m2 * (v1 - s) ** 2
    load = system.scene.load
    weight = 0.0 if load is None else twin.m1 * load(system.parameters) * x1
    power = 1.0 if "kc" in twin.constants else twin.constants.get("exponent", 1.5)
    for z in (r - twin.near, -r - twin.far):
        if z > 0.0 and twin.constants and "e" not in twin.constants:
            stored += 2.0 * twin.elastic(z) * z / (power + 1.0)
    return 0.5 * stored - weight


BALANCED = {
    **{case: (*CASES[case], 1e-13) for case in ("none", "tmd", "linear", "kelvin-voigt")},
    **{
        case: (*CASES[case], 1e-11)
        for case in ("ssul", "ssul soft", "ssbl", "hunt-crossley", "foot")
    },
    "foot tmd": ("tmd", {"base_displacement": 0.01}, "exact", 1e-13),
    "restitution": ("ssul-set6", {"law": "restitution", "e": 0.6}, "exact", 1e-13),
    "sticking": ("ssbl", {"law": "restitution", "e": 0.0}, "exact", 1e-13),
    "oscillator": ("impact-oscillator", {}, "exact", 1e-13),
    "ball": ("bouncing-ball", {}, "exact", 1e-12),
    "ssvi-b": ("ssvi-b", {}, "exact", 1e-11),
}
"""As `CASES`, with the share of the power that comes in by which the balance may fail: round-off
where all is linear or at once, the tolerance of contacts elsewhere."""


@pytest.mark.parametrize("case", BALANCED)
def test_the_balance_of_power_closes(case):
    name, changes, method, precise = BALANCED[case]
    if name == "ssvi-b":
        system = System("ssvi-b", dict(load_system("ssbl").parameters))
    else:
        system = load_system(name, **changes)
    start = simulate(system, 0, transient=4, method=method, **FINE).state
    orbit = simulate(system, 5, transient=4, method=method, record=("response",), **FINE)
    response, lasting = orbit.response, 5 * system.period
    gone = response["power_c1"] + response.get("power_c2", 0.0) + response.get("power_contact", 0.0)
    gain = (energy(system, orbit.state) - energy(system, start)) / lasting
    scale = abs(response["power_in"]) + gone + abs(gain)
    assert response["power_in"] - gone == pytest.approx(gain, abs=precise * scale)
    if case in ("hunt-crossley", "linear", "restitution"):
        assert response["power_contact"] > 0.01 * response["power_in"]


@pytest.mark.parametrize(
    ("name", "changes"), [("none", {}), ("tmd", {}), ("tmd", {"base_displacement": 0.01})]
)
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_the_steady_state_without_contact_is_a_closed_form(name, changes, method):
    system = load_system(name, **changes)
    omega, start = system.parameters["omega"], steady_state(system)
    options = {"method": method} | ({"period_steps": 2048.0} if method == "rk4" else {})
    orbit = simulate(system, 1, start=start, record=("response",), **options).response
    form = response(system, np.array([omega]))
    X1, Y = complex(form.X1[0]), system.foot or 0.0
    sizes = {"x1": abs(X1), "v1": omega * abs(X1), "a1": omega**2 * abs(X1)}
    if form.X2 is not None:
        sizes["stroke"] = abs(complex(form.X2[0]) - X1)
    if Y:
        sizes["drift"] = abs(X1 - Y)
        assert orbit["transmissibility"] == pytest.approx(abs(X1 / Y), rel=1e-10)
    precise = 1e-12 if method == "exact" else 1e-9
    for key, size in sizes.items():
        assert orbit[f"{key}_max"] == pytest.approx(size, rel=precise)
        assert orbit[f"{key}_rms"] == pytest.approx(size / np.sqrt(2), rel=precise)
    c1 = system.structure[2]
    into = (system.force * X1 * 1j * omega).real / 2
    lost = c1 * omega**2 * abs(X1 - Y) ** 2 / 2
    if Y:  # the foot's own force and velocity
        k = complex(system.structure[1], c1 * omega)
        into = (k * (Y - X1) * np.conj(1j * omega * Y)).real / 2
    assert orbit["power_in"] == pytest.approx(into, rel=10 * precise)
    assert orbit["power_c1"] == pytest.approx(lost, rel=precise)


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
    system, both = load_system("ssbl"), ("section", "response")
    alone = simulate(system, 6, record=("section",))
    together = simulate(system, 6, record=both)
    assert np.array_equal(alone.section, together.section)
    energies = simulate(system, 6, record=(*both, "energy", "impacts"))
    for name, value in together.response.items():
        assert np.array_equal(value, energies.response[name]), name


@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_an_impact_that_is_known_adds_what_it_adds_when_stepped(name, monkeypatch):
    system, record = load_system(name, base_displacement=0.02), ("response", "section")
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
