"""Contact laws beside independent solutions: the twin of laws, closed forms, differences."""

import math

import numpy as np
import pytest
from contact_laws import LAWS, STEEP
from flights import flow_on
from random_laws import model_of
from support import BOTH, kernel_state, period_map
from twin_of_laws import Law, Model, Wall, follow

from nlds_vines import classify, load_system, simulate
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.orbit import variations
from nlds_vines.model.system import System

pytestmark = pytest.mark.kernels

every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


@pytest.mark.plain
@every_law
def test_as_the_twin_finds_it(law):
    """Notices: a force, a release or a saltation that is not the law's."""
    system = load_system("ssul-set6", **law.constants)
    course = follow(model_of("ssul", system.parameters, law), (0, 0, system.rest, 0), 4)
    orbit = simulate(system, 4, record=BOTH, tolerance=1e-12)
    assert len(orbit.impacts) >= 3
    section, scale = np.array(course.states), np.abs(orbit.section).max(0)
    bound = 1e-11 if law in (LAWS["linear"], LAWS["pulling"]) else 1e-10
    np.testing.assert_allclose(orbit.section / scale, section / scale, rtol=0, atol=bound)
    over = ~np.isnan(orbit.impacts["release"])
    for name in ("depth", "force"):
        expected = np.array([getattr(hit, name) for hit in course.impacts])
        np.testing.assert_allclose(orbit.impacts[name][over], expected[over], rtol=1e-9)


def oscillator(numbers):
    """Return an oscillator with a linear stop, and the twin's model of it."""
    m, k, c, P, omega, C, kc, cc = (
        numbers[name] for name in ("m", "k", "c", "P", "omega", "C", "kc", "cc")
    )
    stop = Wall(0, 1.0, C, Law("linear", kc=kc, cc=cc))
    return System("oscillator", numbers, law="linear"), Model(m, k, c, P, omega, walls=(stop,))


@pytest.mark.plain
@pytest.mark.parametrize("cc", [0.0, 1.5])
def test_a_linear_stop(cc):
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.5, "P": 0.7, "omega": 1.3, "kc": 40.0, "cc": cc}
    system, model = oscillator(numbers)
    orbit, course = simulate(system, 20, record=BOTH), follow(model, (0, 0), 20)
    assert len(orbit.impacts) > 10
    np.testing.assert_allclose(orbit.section, course.states, rtol=0, atol=1e-12)


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
    """For 100,000 periods: the rounded numbers of a cell's matrix err the same way in every cell.

    The largest drift measured is 3.2e-10, without contacts.
    """
    p = {"m": 1.0, "k": 1.0, "c": 0.0, "C": 0.3, "P": 0.0, "omega": 1.1, "kc": 25.0, **changes}
    section = simulate(System("oscillator", p, law="linear"), 100_000, start=start).section
    x, v = np.vstack([start, section]).T
    twice = p["m"] * v**2 + p["k"] * x**2 + p["kc"] * np.maximum(x - p["C"], 0.0) ** 2
    assert (x > p["C"]).any() == (p["C"] < 3.0)  # sections inside contacts, too
    np.testing.assert_allclose(twice, twice[0], rtol=5e-10)


@pytest.mark.parametrize("law", ["linear", "kelvin-voigt"])
@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_an_undamped_damper_at_linear_walls_keeps_all_energy(name, law):
    system = load_system(name, law=law, kc=2e4, cc=0.0, c1=0.0, c2=0.0, P=0.0, omega=6.28)
    start = 0.1, 0.3, 0.2, -1.0
    orbit = simulate(system, 50_000, start=start, record=BOTH)
    p, (x1, v1, x2, v2) = system.parameters, np.vstack([start, orbit.section]).T
    r = x1 - x2 + system.rest
    cell = system.cell
    depth = np.maximum(r - cell.near, 0.0)
    if name == "ssbl":
        depth += np.maximum(-r - cell.far, 0.0)
    twice = p["m1"] * v1**2 + p["k1"] * x1**2 + p["m2"] * v2**2
    twice += p["k2"] * r**2 + p["kc"] * depth**2
    assert len(orbit.impacts) > 50_000
    np.testing.assert_allclose(twice, twice[0], rtol=5e-10)


@pytest.mark.plain
def test_a_wall_pushes_again_before_the_mass_is_out():
    """A strong dashpot lets go early; the preload then brings the mass back: another impact."""
    p = {"m": 1.0, "k": 2.5, "c": 0.05, "C": -0.2, "P": 2.4, "omega": 0.6, "kc": 3.8, "cc": 11.0}
    system, model = oscillator(p)
    orbit = simulate(system, 3, record=(*BOTH, "trajectory"), samples=1000)
    course = follow(model, (0, 0), 3)  # it rests on the stop at first: it is preloaded
    np.testing.assert_allclose(orbit.section, course.states, rtol=0, atol=1e-10)
    places = orbit.trajectory[(orbit.impacts["touch"] / system.period * 1000).astype(int), 0]
    assert (places > p["C"] + 1e-3).any()


@pytest.mark.plain
def test_the_power_three_halves_is_hertz():
    """To the tolerance; by rk4, whose steps differ in the units of a free contact, to its error."""
    hertz = load_system("ssul-set6", K=STEEP)
    same = hertz.with_(law="power", K=STEEP, exponent=1.5)
    for options, bound in (({"method": "rk4"}, 1e-7), ({"tolerance": 1e-13}, 1e-13)):
        one = simulate(hertz, 8, record=BOTH, **options)
        other = simulate(same, 8, record=BOTH, **options)
        scale = np.abs(one.section).max(0)
        np.testing.assert_allclose(one.section / scale, other.section / scale, rtol=0, atol=bound)
        np.testing.assert_allclose(one.impacts["force"], other.impacts["force"], rtol=100 * bound)


@pytest.mark.plain
@pytest.mark.parametrize("n", [1.0, 1.2, 2.0, 3.0])
def test_fixed_steps_keep_their_order(n):
    law = LAWS[f"n = {n:g}"]
    system = load_system("ssul-set6", **law.constants)
    exact = simulate(system, 2, record=BOTH, tolerance=1e-13).section
    coarse, fine = (
        np.abs(simulate(system, 2, record=BOTH, method="rk4", period_steps=N).section - exact)
        for N in (2048, 4096)
    )
    assert math.log2(coarse.max() / fine.max()) == pytest.approx(4.0, abs=0.8)


@pytest.mark.plain
@pytest.mark.parametrize("name", ["damped", "hunt-crossley"])
def test_what_contacts_take_of_volumes_is_known(name):
    """In the determinant of a period; a dashpot takes cc / mu as long as it is pressed."""
    system = load_system("ssul-set6", **LAWS[name].constants)
    p, run = system.parameters, simulate(system, 150, record=BOTH)
    mu = 1.0 / (1.0 / p["m1"] + 1.0 / p["m2"])
    free = -system.period * (p["c1"] / p["m1"] + p["c2"] / mu)
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    y = kernel_state(system, run.state)
    shrunk = variations.shrunk_in_contacts(flow, y, 1)
    if name == "damped":
        last = run.impacts[-2]
        assert shrunk == pytest.approx(-2000.0 / mu * (last["release"] - last["touch"]), rel=1e-9)
    _, matrix = period_map(flow, y)
    assert math.log(np.linalg.det(matrix)) == pytest.approx(free + shrunk, rel=1e-8)
    regime = classify(system, start=run.state, transient=10, periods=30, effort="quick")
    assert regime.label == "T,1"
    assert math.log(regime.multipliers.prod().real) == pytest.approx(free + shrunk, rel=1e-6)
