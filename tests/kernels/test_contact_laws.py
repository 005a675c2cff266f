"""Contact laws beside independent solutions: other solvers, closed forms, differences.

`followed` solves the equation of motion from touch to release to touch by DOP853 at 1e-13;
`piecewise` linear contacts by matrix exponentials. They share no formula with the kernels.
"""

import math

import numpy as np
import pytest
from laws_with_forces import LAWS, STEEP, power
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from support import BOTH, FULL, period_map

from nlds_vines import classify, load_system, simulate
from nlds_vines.kernels import variations
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import cell_of, flow_on
from nlds_vines.orbits.settings import Settings

pytestmark = pytest.mark.kernels

NOTED = (*BOTH, "energy")  # of each law, whatever a test looks at: one compilation
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
    orbit = simulate(system, 20, record=NOTED, tolerance=1e-12)
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
    orbit = simulate(system, 20, record=BOTH)
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
    orbit = simulate(system, 50_000, start=start, record=NOTED)
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
    orbit = simulate(system, 4, record=(*NOTED, "trajectory"), samples=20000)
    p, (x1, v1, x2, v2) = system.parameters, orbit.trajectory.T
    E1 = (0.5 * (p["m1"] * v1**2 + p["k1"] * x1**2)).max()
    E2 = (0.5 * (p["m2"] * v2**2 + p["k2"] * (x2 - system.rest) ** 2)).max()
    assert E1 <= orbit.E1max <= E1 * (1 + 1e-6)
    assert E2 <= orbit.E2max <= E2 * (1 + 1e-6)


def test_a_wall_pushes_again_before_the_mass_is_out():
    """A strong dashpot lets go early; the preload then brings the mass back: another impact."""
    p = {"m": 1.0, "k": 2.5, "c": 0.05, "C": -0.2, "P": 2.4, "omega": 0.6, "kc": 3.8, "cc": 11.0}
    system = System("oscillator", p, law="linear")
    orbit = simulate(system, 6, record=(*BOTH, "trajectory"), samples=4000)

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
    for options, bound in (({"method": "rk4"}, 1e-7), ({"tolerance": 1e-13}, 1e-13)):
        one = simulate(hertz, 20, record=FULL, **options)
        other = simulate(same, 20, record=NOTED, **options)
        scale = np.abs(one.section).max(0)
        np.testing.assert_allclose(one.section / scale, other.section / scale, rtol=0, atol=bound)
        np.testing.assert_allclose(one.impacts["force"], other.impacts["force"], rtol=100 * bound)


@pytest.mark.parametrize("n", [1.0, 1.2, 2.0, 3.0])
def test_fixed_steps_keep_their_order(n):
    law = LAWS[f"n = {n:g}"]
    system = load_system("ssul-set6", **law.given)
    exact = simulate(system, 2, record=NOTED, tolerance=1e-13).section
    coarse, fine = (
        np.abs(simulate(system, 2, record=NOTED, method="rk4", period_steps=N).section - exact)
        for N in (2048, 4096)
    )
    assert math.log2(coarse.max() / fine.max()) == pytest.approx(4.0, abs=0.8)


# ---- variations ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["damped", "hunt-crossley"])
def test_what_contacts_take_of_volumes_is_known(name):
    """The determinant of a period: that of the flight, and what contacts take.

    A dashpot takes cc / mu as long as it is pressed.
    """
    system = load_system("ssul-set6", **LAWS[name].given)
    p, run = system.parameters, simulate(system, 400, record=NOTED)
    mu = 1.0 / (1.0 / p["m1"] + 1.0 / p["m2"])
    free = -system.period * (p["c1"] / p["m1"] + p["c2"] / mu)
    x1, v1, x2, v2 = run.state
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    y = np.array([x1, v1, x1 - x2 + system.rest, v1 - v2])
    taken = variations.shrunk_in_contacts(flow.prepared.near, None, flow, y, 1)
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
    orbit = simulate(system, 1, start=start, record=(*NOTED, "trajectory"), samples=20000)
    x1, v1, x2, v2 = orbit.trajectory[:300].T
    inside = x1 - x2 + system.rest > gap
    p = system.parameters
    push = np.gradient(v2, system.period / 20000) * p["m2"]  # what moves the damper
    joint = p["k2"] * (x1 - x2 + system.rest) + p["c2"] * (v1 - v2)
    assert inside[:5].all()
    np.testing.assert_allclose((push - joint)[2:][inside[2:]], 0.0, atol=0.05)
