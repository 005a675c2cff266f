"""Observed orders: fixed steps across contacts, one stepped contact, the short impact; states."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import beta
from support import (
    BOTH,
    Approach,
    Impact,
    contact_parts,
    counts_by_period,
    fitted_order,
    follow_ssbl,
    follow_ssul,
    linear_flow,
    references,
    system_of,
)

from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import Settings

FIXED = (1448.0, 2048.0, 2896.0, 4096.0, 5792.0, 8192.0)  # rk4 steps a period
RK4 = {"method": "rk4", "period_steps": 2048.0}
SET6 = references()["ssul-set6"].numbers
SOFT, STEEL = SET6["K"], references()["ssul-set6-steel"].numbers["K"]
APPROACH = Approach(speed=2.4, x1=0.011, v1=0.2, phase=1.0)


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("name", "periods", "most"),
    [
        ("ssul-set6", 5, 4.2),
        ("ssul-set6-omega7.45", 5, 4.2),
        ("ssul-set6-omega7.45", 20, 4.2),
        ("ssbl-omega6.05", 5, 4.2),
        ("ssbl-omega6.05", 20, 4.2),
        ("ssul-set6-steel", 20, 5.5),  # so small a part is of fourth order that the fifth shows
    ],
)
def test_fixed_steps_have_order_four_across_contacts(name, periods, most):
    reference = references()[name]
    sections = (
        follow_ssbl(reference.numbers, periods, "rk4", Settings.rk4(steps))[0]
        if "D" in reference.numbers
        else follow_ssul(reference.numbers, None, periods, method="rk4", period_steps=steps).section
        for steps in FIXED
    )
    errors = [np.abs(section[-1] - reference.states[periods - 1]).max() for section in sections]
    assert 3.8 <= fitted_order(errors, FIXED) <= most


def parts_of(K=SOFT, **changes):
    return contact_parts(**{**SET6, "near": SET6["C"], "K": K, **changes})


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("K", "rk4", "steps", "orders"),
    [
        (SOFT, None, (5, 6, 7, 8, 10), (13.5, 16.0)),
        (STEEL, None, (5, 6, 7, 8, 10), (13.5, 16.0)),
        (SOFT, True, (32, 48, 64, 96, 128), (3.8, 4.2)),
    ],
)
def test_the_order_of_a_stepped_contact(K, rk4, steps, orders):
    parts = parts_of(K)
    exact = APPROACH.step(parts, 200)
    runs = [APPROACH.step(parts, n, rk4) for n in steps]
    durations = [abs(run.duration / exact.duration - 1) for run in runs]
    differences = [run.difference(exact) for run in runs]
    for errors in (durations, differences):
        assert orders[0] <= fitted_order(errors, np.array(steps)) <= orders[1]
    n, bound = (24, 1e-12) if rk4 is None else (512, 1e-9)
    assert APPROACH.step(parts, n, rk4).difference(exact) <= bound


@pytest.mark.kernels
@pytest.mark.parametrize("K", [SOFT, STEEL])
def test_short_impact_converges_geometrically_to_the_stepped_contact(K):
    """Two methods without a formula in common."""
    parts, nodes = parts_of(K), np.arange(4, 12)
    exact = APPROACH.step(parts, 200)
    errors = [APPROACH.solve(parts, n).difference(exact) for n in nodes]
    factor = np.exp(-np.polyfit(nodes, np.log(errors), 1)[0])
    assert factor >= 5
    assert APPROACH.solve(parts, 24).difference(exact) <= 1e-12


# ---- the free Hertz impact and the rigid limit ---------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize("K", [1e3, SOFT, STEEL])
@pytest.mark.parametrize("speed", [1e-6, 0.01, 1.0, 30.0])
def test_free_hertz_impact(speed, K):
    """Without external forces momentum and energy are conserved."""
    parts = parts_of(K, k1=0.0, c1=0.0, k2=0.0, c2=0.0, P=0.0)
    m1, m2 = SET6["m1"], SET6["m2"]
    mu = m1 * m2 / (m1 + m2)
    depth = (5 * mu * speed**2 / (4 * K)) ** 0.4
    duration = 0.8 * beta(0.4, 0.5) * depth / speed
    common = -mu / m1 * speed  # v1 of the common motion, the structure being at rest at touch
    exact = Impact(speed, common * duration, 2 * common, duration, depth)
    approach = Approach(speed, 0.0, 0.0, 0.0)
    assert approach.step(parts, 72).difference(exact) <= 1e-13
    if duration < 0.15:  # longer is not short: stepped
        assert approach.solve(parts, 24).difference(exact) <= 1e-13


def rigid_state(numbers, touch, end):
    """Return (x1, v1, x2 - rest, v2) after one elastic impact near `touch`, before `end`."""
    flow, start = linear_flow(numbers), np.array([0.0, 0, 0, 0, 1, 0])

    def depth(t):
        x1, _, x2, *_ = expm(flow * t) @ start
        return x1 - x2 - numbers["C"]

    at = brentq(depth, touch - 0.02, touch + 0.02, xtol=1e-14)
    y = expm(flow * at) @ start
    m1, m2 = numbers["m1"], numbers["m2"]
    blow = 2 * (y[1] - y[3]) / (m1 + m2)
    y[1] -= m2 * blow
    y[3] += m1 * blow
    return (expm(flow * (end - at)) @ y)[:4]


def test_rigid_limit():
    """With K to infinity the state behind an impact tends to the elastic one as K^(-2/5)."""
    stiffness = SOFT * 10.0 ** np.arange(2, 11, 2)
    end, differences = 4 * np.pi / SET6["omega"], []
    for K in stiffness:
        orbit = follow_ssul({**SET6, "K": K}, None, 2)
        assert len(orbit.impacts) == 1
        state = orbit.section[-1] - [0, 0, SET6["V"] + SET6["C"], 0]
        rigid = rigid_state(SET6, orbit.impacts["touch"][0], end)
        differences.append(np.abs(state - rigid).max())
    assert fitted_order(differences, stiffness) == pytest.approx(0.4, abs=0.01)
    assert differences[-1] < 1e-4


SSBL = pytest.param("ssbl-omega6.05", 30, marks=pytest.mark.kernels)
SSUL = [(name, 100) for name in ("ssul-set6", "ssul-set6-omega7.45", "ssul-set6-steel")]


@pytest.mark.parametrize("method", ["exact", pytest.param("rk4", marks=pytest.mark.kernels)])
@pytest.mark.parametrize(("name", "periods"), [*SSUL, SSBL])
def test_reference_states(name, periods, method):
    """The largest error of each state is measured in the growth of an error by then."""
    bound, options = (1e-9, {}) if method == "exact" else (1e-8, RK4)
    reference = references()[name]
    system = system_of(reference.parameters["kind"], reference.numbers)
    orbit = simulate(system, periods, record=BOTH, **options)
    errors = np.abs(orbit.section - reference.states[:periods]).max(axis=1)
    assert (errors <= bound * reference.growth[:periods]).all()
    counts = counts_by_period(orbit.impacts["touch"], system.parameters["omega"], periods)
    np.testing.assert_array_equal(counts, reference.impacts[:periods])
    assert len(set(orbit.impacts["wall"])) == len(system.scene.walls)
