"""The Lyapunov spectrum of one orbit, against multipliers, divergence and finite differences."""

import numpy as np
import pytest

from nlds_vines import RequestError, classify, load_system, simulate
from nlds_vines.orbits import classification
from nlds_vines.orbits.classification import LyapunovSpectrum, lyapunov_spectrum

CHAOTIC = load_system("ssul-set6", omega=7.38)


@pytest.fixture(scope="module")
def regime():
    chaos = classify(CHAOTIC)
    assert chaos.label == "chaos"
    return chaos


def test_exponents_of_chaos_sum_up_to_the_divergence(regime):
    """The damping alone makes it: contacts of Hertz dissipate nothing."""
    spectrum, p = regime.lyapunov_spectrum(800), CHAOTIC.parameters
    exact = -(p["c1"] + p["c2"]) / p["m1"] - p["c2"] / p["m2"]
    assert spectrum.divergence == pytest.approx(exact, rel=1e-12)
    assert spectrum.exponents.sum() == pytest.approx(exact, rel=1e-9)
    assert (np.diff(spectrum.exponents) < 0.0).all()
    apart = abs(spectrum.exponents[0] - regime.lyapunov)  # from other pieces of the orbit
    assert apart < spectrum.widths[0] + regime.lyapunov_width
    assert spectrum.exponents[0] > spectrum.widths[0] > 0.0
    assert 1.0 < spectrum.dimension < 3.0


def test_exponents_of_a_periodic_orbit_are_those_of_its_multipliers():
    regime = classify("ssul-set6", omega=7.45)  # 3T,2
    spectrum = regime.lyapunov_spectrum(960)
    expected = np.log(np.abs(regime.multipliers)) / (regime.period * regime.system.period)
    off = np.abs(spectrum.running - expected).max(axis=1) * spectrum.times
    assert off.max() < 5.0  # running means converge as 1 / t
    assert (np.abs(spectrum.exponents - expected) < spectrum.widths + 1e-9).all()


def test_exponents_are_those_of_finite_differences(regime, monkeypatch):
    """Orthonormalized differences of orbits that begin nearby, period by period."""
    monkeypatch.setattr(classification, "ALIGNING", 0)
    count, p, state = 64, CHAOTIC.parameters, regime.state
    norms = np.sqrt([p["k1"], p["m1"] + p["m2"], p["k2"], p["m2"]])  # energies of x1, v1, r, s
    to_user = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, -1, 0], [0, 1, 0, -1.0]])
    step, basis, growth = 1e-6, np.eye(4), np.zeros(4)
    for _ in range(count):
        images = []
        for direction in (basis / norms[:, np.newaxis]).T:
            ends = [
                simulate(CHAOTIC, 0, transient=1, start=state + side * step * to_user @ direction)
                for side in (0.5, -0.5)
            ]
            images.append(to_user @ (ends[0].state - ends[1].state) / step)  # its own inverse
        basis, triangle = np.linalg.qr(norms[:, np.newaxis] * np.array(images).T)
        growth += np.log(np.abs(np.diag(triangle)))
        state = simulate(CHAOTIC, 0, transient=1, start=state).state
    spectrum = lyapunov_spectrum(CHAOTIC, regime.state, count)
    np.testing.assert_allclose(spectrum.exponents, growth / spectrum.times[-1], atol=2e-6)


def test_what_contacts_forget_decays_at_once():
    """An impact with e = 0 leaves fewer variations than there were."""
    vectors, logs = classification._orthonormalized(np.array([[3.0, 4.0], [6.0, 8.0]]))
    np.testing.assert_array_equal(vectors, [[0.6, 0.8], [0.0, 0.0]])
    np.testing.assert_array_equal(logs, [np.log(5.0), -np.inf])


def test_the_dimension_of_kaplan_and_yorke():
    def dimension(*values):
        return LyapunovSpectrum(np.array(values), *[np.zeros(1)] * 3, 0.0).dimension

    assert dimension(-0.1, -0.2) == 0.0
    assert dimension(0.3, -0.1, -0.4) == 2.5
    assert dimension(0.3, -0.2) == 2.0


def test_fewer_periods_than_batches_are_refused(regime):
    with pytest.raises(RequestError, match="periods = 15"):
        regime.lyapunov_spectrum(15)
