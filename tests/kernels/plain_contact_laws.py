"""Contact laws without the compiler: orders of their steps, variations, laws that differ."""

import numpy as np
import pytest
from contact_laws import LAWS
from flights import flow_on
from support import Approach, contact_parts, differences, fitted_order, kernel_state, period_map

from nlds_vines import load_system, simulate
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.laws.power import Damping, power_wall_with, root_for
from nlds_vines.model.parameters import CONTACT
from nlds_vines.model.system import System


@pytest.mark.parametrize(("n", "a"), [(1.0, 0.0), (1.2, 0.0), (2.0, 0.0), (3.0, 0.0), (1.5, 0.3)])
def test_stepped_contacts_have_order_fourteen(n, a):
    """From touch to release, in any power, damped or not."""
    numbers = {**load_system("ssul-set6").parameters, "K": 1e7}
    ps, damper, _ = contact_parts(**{k: v for k, v in numbers.items() if k not in CONTACT})
    damping, switch = (Damping(1.0, a), True) if a > 0.0 else (None, None)
    kappa = 1e7 * damper.inv_mu
    wall = power_wall_with(root_for(n), 0.06, 1e7, n, damping, kappa, switch)
    approach = Approach(0.8, 0.01, 0.5, 0.7)
    # by n = 1 the motion is a sine, and four steps are as good as round-off
    steps = np.array({1.0: (1.5, 2, 2.5, 3), 2.0: (3, 4, 5, 6)}.get(n, (6, 8, 10, 12)))
    exact = approach.step((ps, damper, wall), 100)
    errors = [approach.step((ps, damper, wall), count).difference(exact) for count in steps]
    assert fitted_order(errors, steps) >= 12.5
    assert approach.step((ps, damper, wall), 40).difference(exact) <= 1e-12


@pytest.mark.parametrize("name", ["linear", "damped", "pulling", "n = 1.2", "hunt-crossley"])
def test_variations_are_the_derivative_of_the_flow(name):
    """Notices: a saltation that is missing, a stiffness or a drag that is not the law's."""
    system = load_system("ssul-set6", **LAWS[name].constants)
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    y = kernel_state(system, simulate(system, 3).state)
    _, matrix = period_map(flow, y)
    scales = np.array([0.1, 0.5, 0.3, 1.0])
    expected = differences(flow, y, 1e-6 * np.diag(scales)) / 1e-6 / scales[:, None]
    np.testing.assert_allclose(matrix * scales / scales[:, None], expected, rtol=0, atol=2e-7)


def test_laws_that_differ_by_fixed_steps():
    system = load_system("ssbl", law_2="linear", kc_2=1e6, cc_2=300.0)
    exact = simulate(system, 4).section
    fixed = simulate(system, 4, method="rk4", period_steps=8192).section
    np.testing.assert_allclose(fixed, exact, rtol=0, atol=1e-8)


def test_a_hertz_table_bounces_like_a_rigid_one_when_stiff():
    table = {"m": 1.0, "g": 9.81, "Y": 1.3 * 9.81 / 30.0**2, "omega": 30.0, "e": 1.0}
    rigid, start = System("ball", table, law="restitution"), (0.05, 0.2)
    soft = rigid.with_(law="hertz", K=1e14)
    linear = rigid.with_(law="linear", kc=1e14)
    a, b, c = (simulate(s, 3, start=start).section for s in (rigid, soft, linear))
    np.testing.assert_allclose(a, b, rtol=0, atol=2e-3)
    np.testing.assert_allclose(a, c, rtol=0, atol=1e-4)


TORN = {"k": 400, "c": 0, "C": 0.1, "P": 0, "omega": 2 * np.pi, "K": 1e4, "hunt_crossley": 3}
RELEASE = 0.0851896667814  # of the start (0, 3): the wall lets go at 0.06087, in 30 digits


def torn(**options):
    return simulate("impact-oscillator", 1, start=(0, 3), law="hertz", **TORN, **options)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_a_wall_lets_go_at_an_instant(tolerance):
    """Notices: a step across the kink of 1 + a dz/dt = 0."""
    impact = torn(record=("impacts",), tolerance=tolerance).impacts[0]
    assert abs(impact["release"] - RELEASE) <= tolerance * (RELEASE - impact["touch"]) + 1e-13


def test_fixed_steps_keep_their_order_where_a_wall_lets_go():
    errors = []
    for steps in (256, 512, 1024):
        orbit = torn(record=("impacts",), method="rk4", period_steps=steps)
        errors.append(abs(orbit.impacts[0]["release"] - RELEASE))
    assert fitted_order(errors, np.array([256, 512, 1024])) > 3.6


def test_sections_may_cut_what_is_let_go():
    many = torn(record=("impacts", "trajectory"), samples=60)
    inside = (many.time > 0.061) & (many.time < RELEASE) & (many.trajectory[:, 0] > 0.1)
    assert inside.any()
    assert many.impacts[0]["release"] == pytest.approx(RELEASE, rel=1e-9)
    x, v = many.trajectory[inside].T
    energy = 400 * x**2 + v**2  # no force but the spring's
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_a_contact_that_lets_go_has_dissipated_what_is_missing():
    orbit = torn(record=("impacts", "response", "section"), tolerance=1e-12)
    lost = 4.5 - 0.5 * (400 * orbit.state[0] ** 2 + orbit.state[1] ** 2)
    assert orbit.impacts["gain1"].sum() == pytest.approx(-lost, rel=1e-10)
    assert orbit.response["power_contact"] == pytest.approx(lost, rel=1e-10)  # in 1 s


@pytest.mark.parametrize(("C", "start"), [(0.1, (0.09, 1.5)), (-0.1, (-0.05, -0.5))])
def test_variations_where_a_wall_lets_go_or_pushes_again(C, start):
    """The force has no jump there, and so the variations have none."""
    changes = {**TORN, "C": C, "P": 60 if C > 0 else 0, "omega": 40.0}
    system = load_system("impact-oscillator", law="hertz", **changes)
    flow = flow_on(system, settings=Settings.of("exact", tolerance=1e-12))
    y, step = np.array([*start, *start]), 1e-6
    _, matrix = period_map(flow, y)
    expected = differences(flow, y, step * np.array([[1, 0, 1, 0], [0, 1, 0, 1]]))[:2] / step
    np.testing.assert_allclose(matrix[:2, :2], expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("n", [1.2, 2.2])
def test_without_damping_each_contact_keeps_the_energy_by_its_tolerance(n, tolerance):
    numbers = {"m": 1.0, "k": 1.0, "c": 0.0, "C": 0.1, "P": 0.0, "omega": 2.0, "K": 1e5}
    system = System("oscillator", {**numbers, "exponent": n}, law="power")
    orbit = simulate(system, 20, start=(0.0, 1.0), tolerance=tolerance)
    energy = 0.5 * (orbit.section**2).sum(axis=1)
    flying = orbit.section[:, 0] < 0.1
    contacts = len(orbit.impacts)
    assert contacts > 13
    assert flying.sum() > 10
    assert np.abs(energy[flying] / 0.5 - 1.0).max() <= contacts * tolerance
