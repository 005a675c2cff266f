"""The named systems of other authors beside what is known of them in closed form."""

from math import hypot, isclose, pi, sqrt

import numpy as np
import pytest

from nlds_vines import RequestError, continue_branch, load_system, simulate, slow_manifold
from nlds_vines.continuation.branch_arm import at_value
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.model.catalog import catalog
from paper.linear import response


@pytest.mark.parametrize("name", catalog())
def test_every_value_has_a_source(name):
    system = catalog()[name]
    assert system.sources.keys() == system.parameters.keys()
    assert all(system.sources.values())


def orbit_near(system, start, n=1):
    """Return the nT orbit near a start (x1, v1, x2, v2), or (x, v)."""
    section_map, omega = SectionMap(system, ("omega",)), system.parameters["omega"]
    orbit = at_value(section_map, section_map.place_of(omega, start), n, omega)
    assert orbit is not None
    return orbit


# ---- a free mass in a cavity ---------------------------------------------------------------------


def largest_xi(manifold, omega):
    """Return the largest amplitude of the structure over the clearance at a frequency."""
    frequency, amplitude = manifold.response(20_000).outline
    there = np.isfinite(frequency)
    crossed = np.diff(np.sign(frequency[there] - omega)) != 0.0
    return float(amplitude[there][1:][crossed].max()) / manifold.clearance


def start_near(manifold, xi, r):
    """Return (x1, v1, x2, v2) at phase zero of the force: a cosine, and a triangle."""
    theta, share = float(manifold.theta(np.array(xi))), manifold.share
    lag = ((theta - 1.0) - 1j * manifold.rho * theta) / xi
    force = (1.0 - (1.0 - share) * r**2 + 2j * manifold.damping * r) * xi
    force -= 8.0 * share / pi**2 * r**2 * theta * lag
    ahead = float(np.angle(force))
    since = (np.angle(lag) - ahead + pi) % (2.0 * pi) - pi  # from the triangle's peak
    mass, speed = theta * (1.0 - 2.0 * abs(since) / pi), -2.0 * np.sign(since) * theta * r / pi
    structure = xi * np.cos(ahead), xi * r * np.sin(ahead)
    return tuple(manifold.clearance * value for value in (*structure, mass + 1.0, speed))


@pytest.mark.parametrize(("omega", "published"), [(0.95, 0.3238), (0.96, None), (0.975, 0.6416)])
def test_the_response_of_a_free_mass_lies_a_little_below_the_closed_form(omega, published):
    system = load_system("vi-nes", C=50.0, D=50.0, omega=omega)
    manifold = slow_manifold(system)
    xi = largest_xi(manifold, omega)
    assert published is None or isclose(xi, published, rel_tol=5e-4)
    cycle = orbit_near(system, start_near(manifold, xi, omega))
    assert (cycle.counts, cycle.unstable) == ((1, 1), 0)
    x1, v1, r, s = cycle.state
    start = (x1, v1, x1 - r + system.rest, v1 - s)
    seen = simulate(system, 1, start=start, record=("trajectory",), samples=256)
    assert 0.007 < 1.0 - np.abs(seen.trajectory[:, 0]).max() / 50.0 / xi < 0.009


def test_the_clearance_of_the_catalog_has_a_response():
    system, omega = load_system("vi-nes"), load_system("vi-nes").parameters["omega"]
    manifold = slow_manifold(system)
    assert manifold.mass == 1.0
    assert manifold.Gamma == pytest.approx(0.15)
    cycle = orbit_near(system, start_near(manifold, largest_xi(manifold, omega), omega))
    assert (cycle.counts, cycle.unstable) == ((1, 1), 0)


# ---- one body ------------------------------------------------------------------------------------


def test_the_oscillator_of_coco_grazes_where_its_free_amplitude_is_the_gap():
    system = load_system("impact-oscillator", P=0.1)  # at resonance P / (c omega) = 1
    free = response(system, np.array(1.0))
    assert float(free.shortening) == pytest.approx(system.parameters["C"], rel=1e-14)


def test_the_undamped_oscillator_strikes_its_stop_with_20_thirds():
    """Budd and Dux, C = 0: x = -cos(2 t) / 3 - 6 sin(t - pi / 4) between impacts pi apart."""
    start = -1.0 / 3.0 - 3.0 * sqrt(2.0), 3.0 * sqrt(2.0)  # at t = pi
    orbit = simulate(load_system("hard-oscillator"), 1, start=start)
    assert orbit.impacts["speed"].tolist() == pytest.approx([20.0 / 3.0], rel=1e-12)
    np.testing.assert_allclose(orbit.state, start, rtol=0, atol=1e-12)


def test_the_ball_of_the_catalog_bounces_once_a_period_and_its_entry_says_where():
    """From a fold at Gamma = pi (1 - e) / (1 + e) to a doubling."""
    system = load_system("bouncing-ball")
    p = system.parameters
    e, gamma = p["e"], p["Y"] * p["omega"] ** 2 / p["g"]
    fold = pi * (1.0 - e) / (1.0 + e)
    flip = hypot(fold, 2.0 * (1.0 + e**2) / (1.0 + e) ** 2)
    assert fold < gamma < flip
    assert f"{sqrt(fold):.5f} to {sqrt(flip):.5f}" in system.assumptions["e"]


@pytest.mark.parametrize(
    ("omega", "r", "n", "published"), [(3.7, 0.8, 2, 0.345147124453), (5.6, 0.7, 3, 0.122289075915)]
)
def test_the_folds_of_budd_and_dux(omega, r, n, published):
    """x'' + x = cos(omega t) with a rigid stop: one impact of speed V in n periods, closed form.

    Between impacts x = g cos(omega t) + A cos(t - t0) + B sin(t - t0).  An orbit closes where
    (sigma - a V)^2 + (b V)^2 = g^2, sigma being the clearance: its largest value is the fold.
    """
    g = 1.0 / (1.0 - omega**2)
    a, b = -(1.0 + r) / (2.0 * np.tan(pi * n / omega)), (1.0 - r) / (2.0 * omega)
    assert abs(g) * hypot(1.0, a / b) == pytest.approx(published, rel=2e-12)
    # an orbit beside the fold, at phase zero after its impact
    V = 0.98 * abs(g) * a / (b * hypot(a, b))
    root = sqrt(g**2 - (b * V) ** 2)
    phase = float(np.arctan2(-b * V / g, root / g)) % (2.0 * pi)
    since = (2.0 * pi - phase) / omega
    A, B = a * V, -0.5 * (1.0 + r) * V
    x = g + A * np.cos(since) + B * np.sin(since)
    start = x, -A * np.sin(since) + B * np.cos(since)
    system = load_system("hard-oscillator", omega=omega, e=r, C=A + root)
    bounds = (0.98 * published, 1.02 * published)
    points = continue_branch(system, "C", bounds, start, period=n, quiet=True).special_points
    assert np.abs(points.value[points.kind == "LP"] - published).min() < 1e-11


def test_a_start_from_which_no_orbit_closes_is_refused(tmp_path):
    system = load_system("hard-oscillator", omega=2.3, e=0.6, C=0.05)
    options = {"period": 1, "to": tmp_path / "none.h5", "quiet": True}
    with pytest.raises(RequestError, match="closed no periodic orbit from the start"):
        continue_branch(system, "C", (-0.3, 0.4), (0.0, -0.1), **options)
    assert not (tmp_path / "none.h5").exists()


def test_the_ball_of_siconos_bounces_as_published():
    """BouncingBallED.ref at 8.5 s: a ball dropped from 1 m with e = 0.9, after 44 impacts."""
    numbers = {"Y": 0.0, "g": 9.81, "e": 0.9, "omega": 2.0 * pi * 4.0 / 8.5}
    orbit = simulate(load_system("bouncing-ball", **numbers), 4, start=(1.0, 0.0))
    assert orbit.state[0] == pytest.approx(5.565550794e-06, rel=1e-7)
    assert orbit.state[1] == pytest.approx(-4.166519586e-02, rel=2e-9)
    fall = sqrt(2.0 / 9.81)  # flights last 2 e^i falls each
    flights = fall * (1.0 + 2.0 * np.cumsum(0.9 ** np.arange(1, 60)))
    last = int(np.searchsorted(flights, 8.5)) - 1
    speed, since = 0.9 ** (last + 2) * 9.81 * fall, 8.5 - flights[last]
    exact = speed * since - 0.5 * 9.81 * since**2, speed - 9.81 * since
    assert orbit.state == pytest.approx(exact, rel=1e-6)
    assert len(orbit.impacts) == last + 2


def test_the_oscillator_of_siconos_rebounds_as_published():
    """LinearOscillatorED.ref: a weight on a spring, pulled 1 m from a stop of e = 0.9."""
    stiffness, mass, weight = 100.0, 1e-3, 9.81e-3
    numbers = {"m": mass, "k": stiffness, "C": -weight / stiffness, "e": 0.9, "P": 0.0}
    system = load_system("hard-oscillator", **numbers, omega=100.0)
    impact = simulate(system, 4, start=(-1.0 - weight / stiffness, 0.0)).impacts[19]
    assert impact["touch"] == pytest.approx(0.1936844398238720, rel=1e-13)
    assert impact["speed"] == pytest.approx(42.72187248905225, rel=1e-12)
