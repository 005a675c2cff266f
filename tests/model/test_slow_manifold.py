"""Closed forms of responses: the motion without contact, and the slow manifold of a free mass."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from support import amplitudes, linear_flow
from support import steady_state as expected_state

import nlds_vines as nv
from nlds_vines.bifurcation.picture.curves import draw_curves
from nlds_vines.bifurcation.response_curves import ResponseCurve, ResponseCurves, curves_from
from nlds_vines.model.catalog import load_system
from nlds_vines.model.linear_response import energy_alone, flow_matrix
from nlds_vines.tuning.request import load_tuning
from paper.linear import response, steady_state


def with_clearance(gap, **changes):
    return nv.load_system("vi-nes", C=gap, D=gap, **changes)


def test_the_best_clearance_is_the_published_one():
    """Weidemann, Bergman, Vakakis, Krack (2025): eps = 0.02, D = 0.001, e = 0.8."""
    manifold = nv.slow_manifold("vi-nes")
    best = manifold.best
    assert best.Gamma == pytest.approx(0.33866, abs=5e-6)
    assert best.xi == pytest.approx(0.5703, abs=5e-5)
    assert best.r == pytest.approx(0.98846, abs=5e-6)
    assert best.clearance == pytest.approx(0.33866 * 500.0, rel=2e-5)
    assert manifold.Gamma == pytest.approx(0.15)
    # the manifold ends where no motion is sustained
    manifold = nv.slow_manifold(nv.load_system("vi-nes"))
    rho = 2 / np.pi * 0.2 / 1.8
    assert manifold.least == pytest.approx(rho / np.sqrt(1 + rho**2), rel=1e-14)
    ends = manifold.theta(np.array([manifold.least * (1 + 1e-12), manifold.least * (1 - 1e-12)]))
    assert ends[0] == pytest.approx(1 / (1 + rho**2), rel=1e-5)
    assert np.isnan(ends[1])


def test_the_response_satisfies_the_balance_and_closes():
    """On the whole curve, Gamma is the system's own by the formula for it."""
    for gap in (50.0, 75.0, 150.0):
        manifold = nv.slow_manifold(with_clearance(gap))
        response = manifold.response()
        for frequency in (response.below, response.above):
            there = np.isfinite(frequency)
            xi, r = response.amplitude[there] / gap, frequency[there] / manifold.omega_joint
            assert manifold.gamma(xi, r) == pytest.approx(np.full(xi.size, gap / 500.0), rel=1e-8)
        assert response.below[-1] == pytest.approx(response.above[-1], abs=1e-5)
        assert (np.diff(response.amplitude) > 0).all()
    # beyond the best clearance there is none
    best = nv.slow_manifold(nv.load_system("vi-nes")).best.clearance
    assert nv.slow_manifold(with_clearance(0.999 * best)).response().amplitude.size
    assert not nv.slow_manifold(with_clearance(1.001 * best)).response().amplitude.size


@pytest.mark.parametrize("changes", [{}, {"m2": 2.0}, {"c1": 1e-9}, {"c1": 0.5}])
@pytest.mark.parametrize("e", [0.0, 0.1, 0.3, 0.42, 0.43, 0.5, 0.8, 0.99])
def test_the_best_clearance_is_the_largest_on_a_dense_grid(e, changes):
    """The formulas written out, over amplitudes that crowd at xi_min.

    With m2 = 2 kg, a changes its sign for small e: below, there is no phase resonance.
    """
    manifold = nv.slow_manifold(nv.load_system("vi-nes", e=e, **changes))
    rho, eps, D = manifold.rho, manifold.share, manifold.damping
    ends = manifold.least * (1 + np.geomspace(1e-15, 1, 20000))
    xi = np.append(ends, np.geomspace(2 * manifold.least, 10, 200000))
    root = np.sqrt(np.maximum((1 + rho**2) * xi**2 - rho**2, 0))
    theta = (1 + root) / (1 + rho**2)
    pull = 8 * eps / np.pi**2 * theta * (theta - 1 - 1j * rho * theta) / xi
    square = xi / ((1 - eps) * xi + pull.real)
    r = np.sqrt(np.where(square > 0, square, np.nan))
    Gamma = 2 * D / abs((1 - (1 - eps) * r**2 + 2j * D * r) * xi - r**2 * pull)
    best, top = manifold.best, np.nanargmax(Gamma)
    assert best.Gamma == pytest.approx(Gamma[top], rel=1e-7)
    assert best.xi == pytest.approx(xi[top], rel=1e-4)
    assert best.clearance == pytest.approx(best.Gamma * manifold.alone, rel=1e-14)


def free(e, c1=0.0):
    return nv.slow_manifold(nv.load_system("vi-nes", e=e, c1=c1))


def test_the_time_of_capture_without_damping_is_elementary(error_of):
    """Of s^2 = (1 + rho^2) xi^2 - rho^2 the integral of 2 s / (1 + s)^2 is a logarithm."""
    for e, xi in ((0.8, 0.5), (0.5, 2.0), (0.1, 10.0)):
        manifold = free(e)
        rho = manifold.rho
        s = np.sqrt((1 + rho**2) * xi**2 - rho**2)
        lasted = np.pi**2 * (1 + rho**2) / (4 * 0.02 * rho) * (np.log1p(s) + 1 / (1 + s) - 1)
        assert manifold.capture_time(xi) == pytest.approx(lasted, rel=1e-7)
    assert free(0.5, c1=0.01).capture_time(2.0) < free(0.5).capture_time(2.0)
    assert free(0.5).capture_time(free(0.5).least) == 0.0
    assert "for ever" in error_of(free(1.0).capture_time, 2.0)
    assert "xi_min = 0.2" in error_of(free(0.5).capture_time, 0.1)


@pytest.mark.kernels
@pytest.mark.parametrize(("c1", "xi"), [(0.0, 1.5), (0.0, 2.0), (0.002, 2.0)])
def test_a_struck_structure_leaves_the_resonance_when_the_manifold_says(c1, xi):
    """From a state on the manifold, at an impact, with e = 0.5: 1:1 motion is stable there.

    The last cycles last longer than the manifold has it, of whose end they know nothing.
    """
    manifold = free(0.5, c1=c1)
    gap, theta = manifold.clearance, float(manifold.theta(np.array(xi)))
    x1, speed = (theta - 1) * gap, 2 * theta / np.pi * gap
    start = [x1, -np.pi / 2 * manifold.rho * speed, x1 + 2 * gap * (1 - 1e-9), speed]
    system, lasts = nv.load_system("vi-nes", e=0.5, c1=c1), manifold.capture_time(xi)
    fall = nv.response_history(system, start={"state": start}, duration=500.0, quiet=True)["vi-nes"]
    impacts = nv.simulate(system.with_(P=0.0), periods=80, start=start, quiet=True).impacts
    ends = []  # of the stretch in which a wall is struck in each cycle
    for wall in np.unique(impacts["wall"]):
        touches = impacts["touch"][impacts["wall"] == wall]
        ends.append(touches[np.argmax(np.diff(touches) > 1.5 * 2 * np.pi)])
    assert 0.0 < min(ends) - impacts["touch"][0] - lasts < 15.0  # two cycles or so
    for share in (0.25, 0.5, 0.75):
        cycle = abs(fall.time - share * lasts) < np.pi
        there = abs(fall.x1[cycle]).max() / gap
        assert manifold.capture_time(there) == pytest.approx((1 - share) * lasts, abs=0.04 * lasts)


def test_without_loss_in_impacts_all_is_sustained_and_no_clearance_is_the_best(error_of):
    manifold = nv.slow_manifold(with_clearance(50.0, e=1.0))
    assert manifold.least == 0.0
    assert manifold.theta(np.array([0.25])) == pytest.approx([1.25])
    assert np.isfinite(manifold.response().amplitude).all()
    # and there is no best clearance
    for changes, words in (({"e": 1.0}, "e = 1: "), ({"c1": 0.0}, "c1 = 0")):
        manifold = nv.slow_manifold(nv.load_system("vi-nes", **changes))
        assert words in error_of(getattr, manifold, "best")


@pytest.mark.parametrize(
    ("system", "changes", "message"),
    [
        ("ssbl", {}, "this is 'ssbl' with 'hertz'"),
        ("tmd", {}, "this is 'tmd'"),
        ("vi-nes", {"k2": 1e-3}, "k2 = 0.001"),
        ("vi-nes", {"c2": 1e-3}, "c2 = 0.001"),
        ("vi-nes", {"C": 60.0}, "C = 60.0 and D = 75.0"),
        ("vi-nes", {"k1": 0.0}, "k1 = 0"),
        ("vi-nes", {"P": 0.0}, "P = 0"),
        ("vi-nes", {"base_acceleration": 1.0}, "base_acceleration"),
    ],
)
def test_other_systems_have_none_and_are_told_why(system, changes, message, error_of):
    line = error_of(nv.slow_manifold, nv.load_system(system, **changes))
    assert "slow manifold" in line
    assert message in line


def page(systems, **changes):
    figure = {"manifold": True, "reduction": False}
    return curves_from(None, {"systems": systems, "figure": figure} | changes, "")


def test_a_page_draws_the_closed_form_over_its_curve():
    vary = {"omega": {"start": 0.9, "stop": 1.1, "num": 5}}
    request = page([with_clearance(50.0)], vary=vary)
    curves = [ResponseCurve("", case, {"E1max": np.ones((5, 1))}) for case in request.cases]
    for log in (False, True):
        figure = draw_curves(ResponseCurves(None, replace(request, log=log), curves))
        drawn = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 100]
        assert len(drawn) == 1
        response = nv.slow_manifold(with_clearance(50.0)).response()
        top = np.nanmax(drawn[0].get_ydata())
        at_top = 0.5 * max(1.0, 0.98 * response.above[-1] ** 2) * response.amplitude[-1] ** 2
        assert top == pytest.approx(at_top, rel=1e-9)
        assert figure.axes[0].get_yscale() == ("log" if log else "linear")


@pytest.mark.parametrize(
    ("systems", "vary", "message"),
    [
        (["tmd"], {"omega": [5.0, 6.0]}, "no curve has walls"),
        (["ssbl"], {"omega": [5.0, 6.0]}, "free mass between two rigid"),
        (["vi-nes"], {"P": [1.0, 2.0]}, "omega; these are along P"),
    ],
)
def test_a_page_without_a_closed_form_is_refused(systems, vary, message, error_of):
    assert message in error_of(page, systems, vary=vary)


def test_a_tuning_of_both_clearances_begins_with_the_best_one():
    free = {name: {"low": 1.0, "high": 400.0} for name in ("C", "D")}
    design = load_tuning({"system": "vi-nes", "free": free}).first_design
    assert design == pytest.approx([169.3324, 169.3324], abs=1e-3)
    assert load_tuning({"system": "vi-nes", "free": {"C": free["C"]}}).first_design is None
    elastic = {"system": "vi-nes", "set": {"e": 1.0}, "free": free}
    assert load_tuning(elastic).first_design is None
    assert load_tuning({"system": "ssbl", "free": {"C": {}, "D": {}}}).first_design is None


OMEGA = np.array([0.5, 3.0, 6.28, 6.5, 9.0, 40.0])


@pytest.mark.parametrize("name", ["none", "tmd", "ssul-set6", "ssbl"])
def test_amplitudes_at_any_frequency_and_the_steady_state_that_returns_after_a_period(name):
    system = load_system(name)
    linear = response(system, OMEGA)
    for i, omega in enumerate(OMEGA):
        X = amplitudes({**system.parameters, "omega": omega})
        assert linear.X1[i] == pytest.approx(X[0], rel=1e-12)
        p, square = system.parameters, abs(X[0]) ** 2
        assert linear.E1max[i] == pytest.approx(max(p["k1"], p["m1"] * omega**2) * square / 2)
        if name == "none":
            assert linear.X2 is None
            assert linear.shortening[i] == 0.0
        else:
            assert linear.X2[i] == pytest.approx(X[1], rel=1e-12)
            assert linear.shortening[i] == pytest.approx(abs(X[0] - X[1]), rel=1e-12)
    state = steady_state(system)
    np.testing.assert_allclose(state, expected_state(system.parameters, system.rest or 0.0))
    if len(state) == 4:
        y = np.array([*state, 1.0, 0.0])
        y[2] -= system.rest
        flow = flow_matrix(system)
        np.testing.assert_allclose(flow, linear_flow(system.parameters), rtol=1e-14)
        np.testing.assert_allclose(expm(flow * system.period) @ y, y, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("C", "D"), [(0.02, 0.06), (0.06, 0.02), (0.06, 0.06)])
def test_the_nearer_wall_decides_whether_it_clears(C, D):
    system = load_system("ssbl", C=C, D=D)
    linear = response(system, np.linspace(1.0, 60.0, 600))
    expected = linear.shortening <= min(C, D)
    np.testing.assert_array_equal(linear.clears, expected)
    assert 0 < np.count_nonzero(expected) < expected.size
    assert response(load_system("tmd"), OMEGA).clears.all()


def test_a_resonance_without_damping_has_no_steady_state_and_the_structure_alone_is_the_reference():
    omega = 2.0
    system = load_system("none", c1=0.0, m1=1000.0, k1=4000.0)
    linear = response(system, np.array([omega, 2 * omega]))
    assert np.isinf(linear.X1[0])
    assert np.isfinite(linear.X1[1])
    silent = response(system.with_(P=0.0), np.array([omega]))
    assert silent.X1[0] == 0.0
    # the structure alone is the reference
    systems = [load_system("tmd", omega=omega) for omega in OMEGA]
    energy = energy_alone(np.array([system.cells() for system in systems]))
    np.testing.assert_allclose(energy.ravel(), response(load_system("none"), OMEGA).E1max)
