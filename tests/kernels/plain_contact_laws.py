"""Contact laws without the compiler: orders of their steps, variations, laws that differ."""

import numpy as np
import pytest
from laws_with_forces import LAWS
from support import Approach, contact_parts, fitted_order, period_map

from nlds_vines import load_system, simulate
from nlds_vines.kernels.scene import power_wall_at
from nlds_vines.model.parameters import CONTACT
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import flow_on
from nlds_vines.orbits.settings import Settings


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
