"""Contact laws beside independent solutions: other solvers, closed forms, differences.

`followed` solves the equation of motion from touch to release to touch by DOP853 at 1e-13;
`piecewise` linear contacts by matrix exponentials. They share no formula with the kernels.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from support import Approach, contact_parts, fitted_order

from nlds_vines import classify, load_system, simulate
from nlds_vines.kernels import variations
from nlds_vines.kernels.codes import OK
from nlds_vines.kernels.scene import power_wall_at
from nlds_vines.model.parameters import CONTACT
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import cell_of, flow_on
from nlds_vines.orbits.settings import Settings

STEEP = 3e7  # K of the powers


@dataclass(frozen=True)
class Law:
    """Constants of a law, and its force [N] at a depth z [m] that grows with s [m/s]."""

    given: dict
    force: Callable[[float, float], float]


def power(n, K=STEEP, a=0.0):
    def force(z, s):
        return K * max(z, 0.0) ** n * max(0.0, 1.0 + a * s)

    return force


LAWS = {
    "linear": Law({"law": "linear", "kc": 3e6}, lambda z, s: 3e6 * z),
    "damped": Law(
        {"law": "linear", "kc": 3e6, "cc": 2000.0}, lambda z, s: max(0.0, 3e6 * z + 2000.0 * s)
    ),
    "pulling": Law(
        {"law": "kelvin-voigt", "kc": 3e6, "cc": 2000.0}, lambda z, s: 3e6 * z + 2000.0 * s
    ),
    "n = 1": Law({"law": "power", "K": 3e6, "exponent": 1.0}, power(1.0, 3e6)),
    "n = 1.2": Law({"law": "power", "K": 6e6, "exponent": 1.2}, power(1.2, 6e6)),
    "n = 1.37": Law({"law": "power", "K": 1e7, "exponent": 1.37}, power(1.37, 1e7)),
    "n = 2": Law({"law": "power", "K": 5e8, "exponent": 2.0}, power(2.0, 5e8)),
    "n = 3": Law({"law": "power", "K": 2e11, "exponent": 3.0}, power(3.0, 2e11)),
    "hunt-crossley": Law({"K": STEEP, "hunt_crossley": 0.2}, power(1.5, STEEP, 0.2)),
    "damped power": Law(
        {"law": "power", "K": 5e8, "exponent": 2.0, "hunt_crossley": 0.1}, power(2.0, 5e8, 0.1)
    ),
}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def rates(system, force):
    """Return the right side of eq. (5) in (x1, v1, r, s); with `force` [N] beyond the wall."""
    p, gap = system.parameters, system.scene.gap_near(system.parameters)

    def right(t, y, pressed):
        x1, v1, r, s = y
        push = force(r - gap, s) if pressed else 0.0
        own = p["P"] * math.cos(p["omega"] * t) - p["k1"] * x1 - p["c1"] * v1
        pull = p["k2"] * r + p["c2"] * s + push
        dv1 = (own - pull) / p["m1"]
        return [v1, dv1, s, dv1 - pull / p["m2"]]

    return right, gap


def at_wall(right, gap, t, near, y, pressed):
    """Return time and state at the wall, which the motion from y at t meets near an instant."""
    options = {"method": "DOP853", "args": (pressed,), "rtol": 1e-13, "atol": 1e-17}
    y = solve_ivp(right, (t, near), y, **options).y[:, -1]
    late = -(y[2] - gap) / y[3]
    slope = np.array(right(near, y, pressed))
    return near + late, y + late * slope


def followed(system, law, periods):
    """Return sections (periods, 4) from rest, and the greatest depths and forces of all impacts."""
    right, gap = rates(system, law.force)

    def depth(t, y, pressed):
        return y[2] - gap

    depth.terminal = True
    y, t, pressed, section, most = np.zeros(4), 0.0, False, [], []
    reached = np.zeros(2)  # since the touch
    for n in range(1, periods + 1):
        while t < n * system.period:
            depth.direction = -1.0 if pressed else 1.0
            found = solve_ivp(
                right, (t, n * system.period), y, "DOP853", events=depth, args=(pressed,),
                rtol=1e-13, atol=1e-17, max_step=system.period / 40, dense_output=pressed,
            )  # fmt: skip
            if pressed:
                dense = found.sol(np.linspace(t, found.t[-1], 4001))
                force = [law.force(r - gap, s) for r, s in dense[2:].T]
                reached = np.maximum(reached, (dense[2].max() - gap, max(force)))
                if found.status == 1:
                    most.append(reached)
                    reached = np.zeros(2)
            if found.status == 1:  # its place is that of an interpolation
                t, y = at_wall(right, gap, t, found.t[-1], y, pressed)
            else:
                t, y = found.t[-1], found.y[:, -1]
            pressed = pressed != (found.status == 1)
        section.append([y[0], y[1], y[0] - y[2] + system.rest, y[1] - y[3]])
    return np.array(section), np.array(most)


@every_law
def test_as_another_solver_finds_it(law):
    """Notices: a force, a release or a saltation that is not the law's."""
    system = load_system("ssul-set6", **law.given)
    section, most = followed(system, law, 20)
    record = ("section", "impacts", "energy")
    orbit = simulate(system, 20, record=record, tolerance=1e-12)
    scale = np.abs(section).max(0)
    # the solver's steps do not see where a force begins to be none, nor a power of z at its touch
    bound = 1e-11 if law in (LAWS["linear"], LAWS["pulling"]) else 1e-10
    np.testing.assert_allclose(orbit.section / scale, section / scale, rtol=0, atol=bound)
    whole = orbit.impacts[~np.isnan(orbit.impacts["release"])][: len(most)]
    np.testing.assert_allclose(whole["depth"], most[: len(whole), 0], rtol=1e-6)
    np.testing.assert_allclose(whole["force"], most[: len(whole), 1], rtol=1e-6)


# ---- linear contacts -----------------------------------------------------------------------------


def piecewise(p, periods):
    """Return the sections of an oscillator with a linear stop, by matrix exponentials.

    The force is max(0, kc z + cc v) for z > 0.
    """
    m, k, c, C, kc, cc = (p[name] for name in ("m", "k", "c", "C", "kc", "cc"))

    def flow(k, c, push):  # of (x, v, cos, sin, 1)
        A = np.zeros((5, 5))
        A[0, 1], A[1, :3], A[1, 4] = 1, np.array([-k, -c, p["P"]]) / m, push / m
        A[2, 3], A[3, 2] = -p["omega"], p["omega"]
        return A

    free, pressed = flow(k, c, 0.0), flow(k + kc, c + cc, kc * C)
    ends = {
        "flight": (free, lambda y: y[0] - C),
        "contact": (pressed, lambda y: -(kc * (y[0] - C) + cc * y[1])),
        "leaving": (free, lambda y: C - y[0]),
    }
    after = {"flight": "contact", "contact": "leaving", "leaving": "flight"}
    y, mode, found = np.array([0.0, 0.0, 1.0, 0.0, 1.0]), "flight", []
    for _ in range(periods):
        left = 2 * math.pi / p["omega"]
        while left > 0.0:
            A, end = ends[mode]
            small = 2e-3 * min(1.0, math.sqrt(k / (k + kc)) * 4)
            step, t, where = expm(A * small), 0.0, None
            z = y
            while t < left:
                z_next = step @ z
                if (t > 0.0 or end(z) < -1e-9) and end(z) <= 0.0 < end(z_next):
                    inside = z
                    where = t + brentq(
                        lambda h, A=A, end=end, inside=inside: end(expm(A * h) @ inside),
                        0.0, small, xtol=1e-16,
                    )  # fmt: skip
                    break
                z, t = z_next, t + small
            if where is None or where > left:
                y, left = expm(A * left) @ y, 0.0
            else:
                y, left, mode = expm(A * where) @ y, left - where, after[mode]
                if mode == "leaving" and cc == 0.0:
                    mode = "flight"
        y[2:4] = 1.0, 0.0
        found.append(y[:2])
    return np.array(found)


@pytest.mark.parametrize("cc", [0.0, 1.5])
def test_a_linear_stop_in_closed_form(cc):
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.5, "P": 0.7, "omega": 1.3, "kc": 40.0, "cc": cc}
    system = System("oscillator", numbers, law="linear")
    orbit = simulate(system, 20, record=("section", "impacts"))
    assert len(orbit.impacts) > 10
    np.testing.assert_allclose(orbit.section, piecewise(numbers, 20), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("start", "changes"),
    [
        ((-0.7, 0.6), {}),
        ((-0.7, 0.6), {"C": 3.0}),  # never touches the stop
        ((-0.7, 0.6), {"kc": 1e-3, "omega": 2.2}),
        ((-0.7, 0.6), {"kc": 1000.0, "omega": 0.7}),
        ((-0.31, 0.0), {"kc": 3e4}),
        ((-20.0, 0.0), {"m": 1.7, "k": 0.9}),
        ((0.0, 0.0), {"C": -0.2, "kc": 4.0}),  # preloaded: mostly in contact
        ((-0.7, 0.6), {"omega": 1.0, "C": 0.0, "kc": 3.0}),  # periodic: nothing is random
    ],
)
def test_an_undamped_linear_contact_keeps_all_energy(start, changes):
    """For 100,000 periods: round-off is as likely up as down."""
    p = {"m": 1.0, "k": 1.0, "c": 0.0, "C": 0.3, "P": 0.0, "omega": 1.1, "kc": 25.0, **changes}
    section = simulate(System("oscillator", p, law="linear"), 100_000, start=start).section
    x, v = np.vstack([start, section]).T
    twice = p["m"] * v**2 + p["k"] * x**2 + p["kc"] * np.maximum(x - p["C"], 0.0) ** 2
    assert (x > p["C"]).any() == (p["C"] < 3.0)  # sections inside contacts, too
    np.testing.assert_allclose(twice, twice[0], rtol=1e-12)


@pytest.mark.parametrize("law", ["linear", "kelvin-voigt"])
@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_an_undamped_damper_at_linear_walls_keeps_all_energy(name, law):
    system = load_system(name, law=law, kc=2e4, cc=0.0, c1=0.0, c2=0.0, P=0.0, omega=6.28)
    start = 0.1, 0.3, 0.2, -1.0
    orbit = simulate(system, 50_000, start=start)
    p, (x1, v1, x2, v2) = system.parameters, np.vstack([start, orbit.section]).T
    r = x1 - x2 + system.rest
    cell = cell_of(system)
    depth = np.maximum(r - cell.near, 0.0)
    if name == "ssbl":
        depth += np.maximum(-r - cell.far, 0.0)
    twice = p["m1"] * v1**2 + p["k1"] * x1**2 + p["m2"] * v2**2
    twice += p["k2"] * r**2 + p["kc"] * depth**2
    assert len(orbit.impacts) > 50_000
    np.testing.assert_allclose(twice, twice[0], rtol=1e-12)


def test_energies_of_a_damper_at_a_linear_wall():
    """The largest energies beside densely sampled ones."""
    system = load_system("ssul-set6", law="linear", kc=2e4, cc=50.0)
    orbit = simulate(system, 4, record=("section", "energy", "trajectory"), samples=20000)
    p, (x1, v1, x2, v2) = system.parameters, orbit.trajectory.T
    E1 = (0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2)).max()
    E2 = (0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - system.rest) ** 2)).max()
    assert E1 <= orbit.E1max <= E1 * (1 + 1e-6)
    assert E2 <= orbit.E2max <= E2 * (1 + 1e-6)


def test_a_wall_pushes_again_before_the_mass_is_out():
    """A strong dashpot lets go early; the preload then brings the mass back: another impact."""
    p = {"m": 1.0, "k": 2.5, "c": 0.05, "C": -0.2, "P": 2.4, "omega": 0.6, "kc": 3.8, "cc": 11.0}
    system = System("oscillator", p, law="linear")
    orbit = simulate(system, 6, record=("section", "impacts", "trajectory"), samples=4000)

    def right(t, y):
        z = y[0] - p["C"]
        push = max(0.0, p["kc"] * z + p["cc"] * y[1]) if z > 0.0 else 0.0
        return [y[1], p["P"] * math.cos(p["omega"] * t) - p["c"] * y[1] - p["k"] * y[0] - push]

    # rests on the stop at first: it is preloaded
    found = solve_ivp(
        right, (0.0, 6 * system.period), [0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-13,
        max_step=system.period / 4000, t_eval=system.period * np.arange(1, 7),
    )  # fmt: skip
    np.testing.assert_allclose(orbit.section, found.y.T, rtol=0, atol=1e-7)
    places = orbit.trajectory[(orbit.impacts["touch"] / system.period * 4000).astype(int), 0]
    assert (places > p["C"] + 1e-3).any()


# ---- powers --------------------------------------------------------------------------------------


def test_the_power_three_halves_is_hertz():
    """To the tolerance; by rk4, whose steps differ in the units of a free contact, to its error."""
    hertz = load_system("ssul-set6", K=STEEP)
    same = hertz.with_(law="power", K=STEEP, exponent=1.5)
    record = ("section", "impacts", "energy")
    for options, bound in (({"method": "rk4"}, 1e-7), ({"tolerance": 1e-13}, 1e-13)):
        one, other = (simulate(s, 20, record=record, **options) for s in (hertz, same))
        scale = np.abs(one.section).max(0)
        np.testing.assert_allclose(one.section / scale, other.section / scale, rtol=0, atol=bound)
        np.testing.assert_allclose(one.impacts["force"], other.impacts["force"], rtol=100 * bound)


@pytest.mark.parametrize("n", [1.0, 1.2, 2.0, 3.0])
def test_fixed_steps_keep_their_order(n):
    law = LAWS[f"n = {n:g}"]
    system = load_system("ssul-set6", **law.given)
    exact = simulate(system, 2, tolerance=1e-13).section
    coarse, fine = (
        np.abs(simulate(system, 2, method="rk4", period_steps=N).section - exact)
        for N in (2048, 4096)
    )
    assert math.log2(coarse.max() / fine.max()) == pytest.approx(4.0, abs=0.8)


@pytest.mark.parametrize(("n", "a"), [(1.0, 0.0), (1.2, 0.0), (2.0, 0.0), (3.0, 0.0), (1.5, 0.3)])
def test_stepped_contacts_have_order_eight(n, a):
    """From touch to release, in any power, damped or not."""
    numbers = {**load_system("ssul-set6").parameters, "K": 1e7}
    ps, damper, _ = contact_parts(**{k: v for k, v in numbers.items() if k not in CONTACT})
    wall = power_wall_at(0.06, 1e7, n, a if a > 0.0 else None, damper.inv_mu)
    approach = Approach(0.8, 0.01, 0.5, 0.7)
    # by n = 1 the motion is a sine, and twelve steps are as good as round-off
    steps = np.array([4, 5, 6, 8]) if n == 1.0 else np.array([12, 16, 20, 24, 32])
    exact = approach.step((ps, damper, wall), 300)
    errors = [approach.step((ps, damper, wall), count).difference(exact) for count in steps]
    assert fitted_order(errors, steps) >= 7.4
    assert approach.step((ps, damper, wall), 100).difference(exact) <= 1e-12


# ---- variations ----------------------------------------------------------------------------------


def period_map(flow, y):
    """Return the state a period after y (4,), and its derivative (4, 4)."""
    state, tangent = variations.new_state(), np.zeros(16)
    variations.place_state(flow, np.asarray(y, float), state)
    variations.set_identity(tangent)
    section = variations.no_section(flow.space)
    assert variations.advance(flow, section, 1, tangent, state) == OK
    return state[:4].copy(), tangent.reshape(4, 4).T.copy()


@pytest.mark.parametrize("name", ["linear", "damped", "pulling", "n = 1.2", "hunt-crossley"])
def test_variations_are_the_derivative_of_the_flow(name):
    """Notices: a saltation that is missing, a stiffness or a drag that is not the law's."""
    system = load_system("ssul-set6", **LAWS[name].given)
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    x1, v1, x2, v2 = simulate(system, 3).state
    y = np.array([x1, v1, x1 - x2 + system.rest, v1 - v2])
    _, found = period_map(flow, y)
    scales = np.array([0.1, 0.5, 0.3, 1.0])
    step, columns = 1e-6, []
    for i in range(4):
        e = step * scales[i] * np.eye(4)[i]
        columns.append((period_map(flow, y + e)[0] - period_map(flow, y - e)[0]) / (2 * step))
    expected = np.array(columns).T / scales[:, None]
    np.testing.assert_allclose(found * scales / scales[:, None], expected, rtol=0, atol=2e-7)


@pytest.mark.parametrize("name", ["damped", "hunt-crossley"])
def test_what_contacts_take_of_volumes_is_known(name):
    """The determinant of a period: that of the flight, and what contacts take.

    A dashpot takes cc / mu as long as it is pressed.
    """
    system = load_system("ssul-set6", **LAWS[name].given)
    p, run = system.parameters, simulate(system, 400, record=("section", "impacts"))
    mu = 1.0 / (1.0 / p["m1"] + 1.0 / p["m2"])
    free = -system.period * (p["c1"] / p["m1"] + p["c2"] / mu)
    x1, v1, x2, v2 = run.state
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    y = np.array([x1, v1, x1 - x2 + system.rest, v1 - v2])
    near = flow.prepared.near
    damping = None if name == "damped" else near.damping
    taken = variations.shrunk_in_contacts(near, None, damping, None, flow, y, 1)
    if name == "damped":
        last = run.impacts[-2]
        assert taken == pytest.approx(-2000.0 / mu * (last["release"] - last["touch"]), rel=1e-9)
    _, matrix = period_map(flow, y)
    assert math.log(np.linalg.det(matrix)) == pytest.approx(free + taken, rel=1e-8)
    regime = classify(system)
    assert regime.label == "T,1"
    assert math.log(regime.multipliers.prod().real) == pytest.approx(free + taken, rel=1e-6)


def test_a_damped_contact_never_attracts():
    """A damper that is torn off the wall by its spring feels no force as it leaves."""
    law = {"K": 1e6, "hunt_crossley": 5.0}
    system = load_system("ssul-set6", C=0.05, **law)
    # begun inside the contact, leaving faster than 1 / a
    depth, speed = 0.004, 1.0
    start = (0.0, 0.0, system.rest - 0.05 - depth, speed)
    _, gap = rates(system, power(1.5, 1e6, 5.0))
    orbit = simulate(system, 1, start=start, record=("section", "trajectory"), samples=20000)
    x1, v1, x2, v2 = orbit.trajectory[:300].T
    inside = x1 - x2 + system.rest > gap
    p = system.parameters
    push = np.gradient(v2, system.period / 20000) * p["m2"]  # what moves the damper
    joint = p["k2"] * (x1 - x2 + system.rest) + p["c2"] * (v1 - v2)
    assert inside[:5].all()
    np.testing.assert_allclose((push - joint)[2:][inside[2:]], 0.0, atol=0.05)


# ---- two walls, two stops, a base that moves -----------------------------------------------------


def test_each_wall_has_its_own_law():
    """The structure's contact as a power of 3/2 is that of Hertz; another changes the orbit."""
    plain = load_system("ssbl", K=STEEP)
    same = plain.with_(law_2="power", K_2=STEEP, exponent_2=1.5)
    rigid = plain.with_(law_2="restitution", e_2=1.0)
    stiff = plain.with_(law_2="hertz", K_2=1e16)
    record = ("section", "impacts")
    a, b, c, d = (
        simulate(s, 10, record=record, tolerance=1e-12) for s in (plain, same, rigid, stiff)
    )
    assert set(a.impacts["wall"]) == {"structure", "obstacle"}
    np.testing.assert_allclose(b.section, a.section, rtol=0, atol=1e-9)
    assert np.abs(c.section - a.section).max() > 1e-4
    np.testing.assert_allclose(c.section[:3], d.section[:3], rtol=0, atol=1e-5)
    of = c.impacts["wall"] == "structure"
    assert np.isinf(c.impacts["force"][of]).all()
    assert np.isfinite(c.impacts["force"][~of]).all()


def test_laws_that_differ_by_fixed_steps():
    system = load_system("ssbl", law_2="linear", kc_2=1e6, cc_2=300.0)
    exact = simulate(system, 4).section
    fixed = simulate(system, 4, method="rk4", period_steps=8192).section
    np.testing.assert_allclose(fixed, exact, rtol=0, atol=1e-8)


def test_the_second_stop_is_the_mirror_of_the_first():
    """Half a period later the force is the opposite: the mirror runs the mirrored orbit."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.4, "C_2": 0.5, "P": 0.7, "omega": 1.3}
    one = System(
        "oscillator-2", {**numbers, "e": 0.7, "kc_2": 50.0}, law="restitution", law_2="linear"
    )
    other = System(
        "oscillator-2", {**numbers, "C": 0.5, "C_2": 0.4, "kc": 50.0, "e_2": 0.7},
        law="linear", law_2="restitution",
    )  # fmt: skip
    record = ("section", "impacts", "trajectory")
    a = simulate(one, 40, start=(0.1, 0.2), record=record, samples=2)
    half = a.trajectory[0]  # the state at T / 2
    b = simulate(other, 39, start=-half, record=record, samples=2)
    assert set(a.impacts["wall"]) == {"stop", "second stop"}
    np.testing.assert_allclose(b.trajectory[1::2], -a.trajectory[2:-1:2], rtol=0, atol=1e-9)


def test_a_base_that_moves_is_a_force():
    numbers = {"m": 2.0, "k": 3.0, "c": 0.1, "C": 0.4, "omega": 1.3, "e": 0.7}
    shaken = System("oscillator", {**numbers, "Y": 0.2}, law="restitution")
    forced = System("oscillator", {**numbers, "P": 2.0 * 0.2 * 1.3**2}, law="restitution")
    np.testing.assert_allclose(
        simulate(shaken, 20).section, simulate(forced, 20).section, rtol=0, atol=1e-13
    )
    assert shaken.with_(P=1.0).parameters["P"] == 1.0


# ---- the bouncing ball ---------------------------------------------------------------------------

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
    found = []
    for phase in (math.asin(sine) + 2 * np.pi, np.pi - math.asin(sine)):
        since = n * T - phase / omega
        height = Y * math.cos(phase) + lift * since - 0.5 * G * since**2 - Y
        found.append((height, lift - G * since))
    return found


@pytest.mark.parametrize(("gamma", "e", "n"), [(1.2, 0.5, 1), (1.4, 0.5, 1), (2.4, 0.5, 2)])
def test_bouncing_orbits_in_closed_form(gamma, e, n):
    system = ball(gamma, e)
    for height, velocity in bounce(gamma, e, 30.0, n):
        orbit = simulate(system, n, start=(height, velocity), record=("section", "impacts"))
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
        record=("section", "impacts"),
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
    orbit = simulate(system, 40, start=(0.0, 0.0), record=("section", "impacts"))
    releases = orbit.impacts["release"]
    turns = (releases[~np.isnan(releases)] / system.period) % 1.0
    off = 1.0 - math.acos(1.0 / gamma) / (2 * np.pi)
    assert len(turns) > 10
    rested = np.abs(turns - off) < 1e-9
    assert rested.any()
    regime = classify(system, start=(0.0, 0.0))
    if rested.all():  # every impact ends in rest: all is forgotten in a period
        assert abs(regime.multipliers).max() == 0.0


def test_a_hertz_table_bounces_like_a_rigid_one_when_stiff():
    rigid, start = ball(1.3, 1.0), (0.05, 0.2)
    soft = rigid.with_(law="hertz", K=1e14)
    linear = rigid.with_(law="linear", kc=1e14)
    a, b, c = (simulate(s, 3, start=start).section for s in (rigid, soft, linear))
    np.testing.assert_allclose(a, b, rtol=0, atol=2e-3)
    np.testing.assert_allclose(a, c, rtol=0, atol=1e-4)


# ---- Budd and Dux: a hard impact oscillator without damping --------------------------------------


@pytest.mark.parametrize(
    ("omega", "e", "C", "speed"),
    [(2.0, 0.8, 0.0, 20 / 3), (2.0, 0.8, 0.1, 6.359595), (2.5, 0.6, 0.0, 0.700362)],
)
def test_a_hard_impact_oscillator(omega, e, C, speed):
    """Speed of impact of its T,1 orbit, from starts all over (Phil. Trans. A 347 (1994) 365)."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.0, "C": C, "P": 1.0, "omega": omega, "e": e}
    system = System("oscillator", numbers, law="restitution")
    found = []
    for seed in range(6):
        start = np.random.default_rng(seed).normal(size=2) - (3.0, 0.0)
        impacts = simulate(system, 400, start=start, record=("section", "impacts")).impacts
        found.append(impacts["speed"][-1])
    assert min(abs(np.array(found) - speed)) < 1e-5 * speed
