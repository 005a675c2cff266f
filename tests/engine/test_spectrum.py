"""Spectra and Lyapunov spectra of one orbit, against lines, noise, multipliers and differences."""

from dataclasses import replace

import numpy as np
import pytest
from support import FULL, amplitudes

import nlds_vines as nv
from nlds_vines import classify, load_system, simulate
from nlds_vines.engine import classification
from nlds_vines.engine.classification import LyapunovSpectrum, lyapunov_spectrum
from nlds_vines.engine.spectrum import NEIGHBORS, TAPERS, spectrum_of

SAMPLES, PERIODS, OMEGA = 64, 24, 7.4
TIME = np.arange(1, SAMPLES * PERIODS + 1) / SAMPLES  # in forcing periods, as of a trajectory


def wave(order, amplitude=1.0, phase=0.3):
    return amplitude * np.cos(2 * np.pi * order * TIME + phase)


def of(values, **options):
    return spectrum_of(values, SAMPLES, OMEGA, **options)


def noise(seed=1, count=TIME.size):
    return np.random.default_rng(seed).normal(size=count)


@pytest.mark.parametrize("window", TAPERS)
def test_a_line_has_its_amplitude_at_its_frequency(window):
    spectrum = of(5.0 + wave(1, 0.25) + wave(1 / 3, 2.0) + wave(7, 0.01), window=window)
    assert spectrum.resolution == 1 / PERIODS
    for order, amplitude in ((0, 5.0), (1 / 3, 2.0), (1, 0.25), (7, 0.01)):
        (place,) = np.flatnonzero(np.isclose(spectrum.order, order))
        assert spectrum.amplitude[place] == pytest.approx(amplitude, rel=1e-12)
        assert spectrum.frequency[place] == pytest.approx(order * OMEGA)


def test_lines_of_an_orbit_do_not_leak_and_one_between_bins_less_far_with_hann():
    spectrum = of(sum(wave(k / 3, 1 / k, k) for k in range(1, 40)))
    beside = np.ones(spectrum.order.size, bool)
    beside[:: PERIODS // 3] = False
    assert spectrum.amplitude[beside].max() < 1e-12
    assert spectrum.amplitude[~beside][1:40].min() > 0.02
    values = wave(2 + 0.5 / PERIODS)
    far = {window: of(values, window=window).amplitude[200:400].max() for window in TAPERS}
    assert far["hann"] < 1e-4 < 1e-3 < far["rectangular"]


def test_decibels_the_nyquist_frequency_and_a_constant():
    spectrum = of(wave(1, 0.02))
    assert spectrum.decibels()[PERIODS] == pytest.approx(20 * np.log10(0.02))
    # the Nyquist frequency counts once
    spectrum = of(np.where(np.arange(TIME.size) % 2, 1.0, -1.0))
    assert spectrum.amplitude[-1] == pytest.approx(1.0)
    assert spectrum.power.sum() == pytest.approx(1.0)
    # a constant has no spectrum
    spectrum = of(np.full(TIME.size, 0.1))
    assert spectrum.amplitude[0] == pytest.approx(0.1)
    assert not spectrum.power.any()
    assert spectrum.broadband_share() == spectrum.bins_holding() == 0
    assert np.isneginf(spectrum.decibels()[1:]).all()


@pytest.mark.parametrize("samples", [64, 65])
def test_the_power_is_the_variance(samples):
    values = noise(count=samples * 9)
    spectrum = spectrum_of(values, samples, OMEGA)
    assert spectrum.power.sum() == pytest.approx(values.var(), rel=1e-12)
    tapered = spectrum_of(values, samples, OMEGA, window="hann")
    weights = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(values.size) / values.size)
    weighted = (weights * (values - values.mean())) ** 2
    assert tapered.power.sum() == pytest.approx(weighted.sum() / (weights**2).sum(), rel=1e-12)


@pytest.mark.parametrize("window", TAPERS)
@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_the_lines_of_an_orbit_are_not_broadband(window, n):
    spectrum = of(3.0 + sum(wave(k / n, 0.5**k, k) for k in range(1, 9)), window=window)
    assert spectrum.broadband_share(n) < 1e-24
    if n > 1:
        assert spectrum.broadband_share() > 0.1  # subharmonics are no harmonics of the force
    assert spectrum.broadband_share() == spectrum.broadband_share(1)


@pytest.mark.parametrize(("window", "width"), [("rectangular", 1), ("hann", 3)])
def test_noise_is_broadband_but_for_what_falls_on_the_comb_also_beside_lines(window, width):
    spectrum = of(noise() + 100.0, window=window)
    for n in (1, 2, 4):
        assert spectrum.broadband_share(n) == pytest.approx(1 - n * width / PERIODS, abs=0.04)
    spectrum = of(wave(1, 1.0) + 0.1 * noise(), window=window)
    expected = 0.01 / 0.51 * (1 - width / PERIODS)
    assert spectrum.broadband_share(1) == pytest.approx(expected, rel=0.15)


def test_folded_harmonics_stay_on_a_comb_that_suits_the_periods(error_of):
    assert of(wave(1) + wave(SAMPLES + 1 / 3) + wave(5 * SAMPLES - 2)).broadband_share(3) < 1e-20
    for n in (5, 24, -1):
        assert f"n = {n}" in error_of(of(wave(1)).broadband_share, n)
    assert "n = 6 does not suit" in error_of(of(wave(1), window="hann").broadband_share, 6)
    # few bins hold a line, and many a noise
    assert of(wave(1) + wave(2 / 3)).bins_holding(0.99) == 2
    assert of(wave(1), window="hann").bins_holding(1.0) >= 3
    assert of(noise()).bins_holding(0.9) > TIME.size / 8


@pytest.mark.parametrize(
    ("values", "window", "words"),
    [
        (np.ones(65), "hann", "no whole number of periods"),
        (np.ones((64, 2)), "hann", "(64, 2)"),
        (np.full(64, np.nan), "hann", "finite"),
        (np.ones(64), "kaiser", "'kaiser'"),
    ],
)
def test_wrong_values_are_refused(values, window, words, error_of):
    assert words in error_of(of, values, window=window)


@pytest.fixture(scope="module")
def orbits():
    """Return orbits with K = 2.5e7: 3T,3, chaos, and a transient that became T,0."""
    record = ["trajectory", "impacts"]
    options = {"K": 2.5e7, "transient": 4000, "record": record, "samples": 256}
    return {w: nv.simulate("ssul-set6", 180, omega=w, **options) for w in (7.375, 7.4, 7.575)}


@pytest.mark.parametrize("signal", ["x1", "v1", "x2", "v2", "u", "force", "E1", "E2"])
@pytest.mark.parametrize("window", TAPERS)
def test_a_periodic_orbit_is_not_broadband_and_a_chaotic_one_is(orbits, signal, window):
    spectra = {omega: nv.spectrum(orbit, signal, window=window) for omega, orbit in orbits.items()}
    for periodic in (7.375, 7.575):
        assert spectra[periodic].broadband_share(3) < 1e-12
    assert spectra[7.4].broadband_share(3) > (0.7 if signal == "force" else 1e-4)


@pytest.mark.kernels
def test_the_spectrum_of_a_simple_orbit_is_its_transfer_function():
    orbit = nv.simulate("none", 4, transient=300, record=["trajectory"], samples=32)
    spectrum = nv.spectrum(orbit, "x1")
    expected = abs(amplitudes(orbit.system.parameters)[0])
    assert spectrum.amplitude[4] == pytest.approx(expected, rel=1e-9)
    about = spectrum.samples, spectrum.periods, spectrum.unit, spectrum.quantity
    assert about == (32, 4, "m", "x1")


def test_the_contact_force_agrees_with_the_impacts(orbits):
    orbit = orbits[7.375]
    system = orbit.system
    (force,) = system.contact_forces(orbit.trajectory).values()
    peaks = orbit.impacts["force"]
    assert force.min() == 0.0
    assert 0.9 * peaks.max() < force.max() <= peaks.max() * (1 + 1e-9)
    time, impacts = orbit.time[:, np.newaxis], orbit.impacts
    closed = ((time > impacts["touch"]) & (time < impacts["release"])).any(axis=1)
    assert (force[~closed] == 0).all()
    assert (force[closed] > 0).all()


def test_walls_push_the_damper_away_from_themselves():
    system = nv.load_system("ssbl", C=0.4, D=0.1, K=1e6)
    states = np.zeros((3, 4))
    states[:, 2] = -0.01, 0.2, 0.52  # at the structure, free, at the obstacle
    force = system.contact_forces(states)
    np.testing.assert_allclose(force["structure"], [1e6 * 0.01**1.5, 0, 0], rtol=1e-12)
    np.testing.assert_allclose(force["obstacle"], [0, 0, -1e6 * 0.02**1.5], rtol=1e-12)
    both = system.signal("force").of(states)
    np.testing.assert_array_equal(both, force["structure"] + force["obstacle"])


@pytest.mark.kernels
def test_the_energies_are_those_that_are_recorded(orbits):
    system, states = orbits[7.375].system, orbits[7.375].trajectory
    # the maxima exact in time are those of the samples, but for what lies between two samples
    exact = nv.simulate(system, 180, transient=4000, record=FULL)
    for name, highest in (("E1", exact.E1max), ("E2", exact.E2max)):
        assert 0.99 * highest < system.signal(name).of(states).max() <= highest * (1 + 1e-9)


@pytest.mark.kernels
def test_an_orbit_without_trajectory_or_signal_is_refused(error_of):
    bare = nv.simulate("none", 2)
    short = nv.simulate("none", 1, record=["trajectory"], samples=1)
    for orbit, signal, words in (
        (bare, "x1", "no trajectory"),
        (bare, "x2", "does not exist in kind 'none'"),
        (bare, "x3", "'x3'"),
        (short, "x1", "one state"),
    ):
        assert words in error_of(nv.spectrum, orbit, signal)


@pytest.mark.parametrize("bins", [100, 400])
def test_the_background_is_the_median_around_each_bin_and_knows_no_mean(bins):
    """White noise and a line, bin by bin; the first bin, the mean's, is of no account."""
    spectrum = of(noise() + wave(2, 0.5), window="hann")
    power = spectrum.power[1:bins]
    mirrored = [*power[NEIGHBORS:0:-1], *power, *power[-2 : -NEIGHBORS - 2 : -1]]
    around = [np.median(mirrored[k : k + 2 * NEIGHBORS + 1]) for k in range(power.size)]
    share = sum(map(min, power, around)) / sum(power)
    assert 0.05 < share < 0.95
    for mean in (0.0, 1e6):
        other = replace(spectrum, power=np.array([mean, *spectrum.power[1:]]))
        assert other.background_share(bins) == pytest.approx(share, rel=1e-12)


CHAOTIC = load_system("ssul-set6", omega=7.38)


@pytest.fixture(scope="module")
def regime():
    return classify(CHAOTIC)


def test_exponents_of_chaos_sum_up_to_the_divergence_of_enough_periods(regime, error_of):
    """The damping alone makes it: contacts of Hertz dissipate nothing."""
    assert regime.label == "chaos"
    spectrum, p = regime.lyapunov_spectrum(800), CHAOTIC.parameters
    exact = -(p["c1"] + p["c2"]) / p["m1"] - p["c2"] / p["m2"]
    assert spectrum.divergence == pytest.approx(exact, rel=1e-12)
    assert spectrum.exponents.sum() == pytest.approx(exact, rel=1e-9)
    assert (np.diff(spectrum.exponents) < 0.0).all()
    apart = abs(spectrum.exponents[0] - regime.lyapunov)  # from other pieces of the orbit
    assert apart < spectrum.widths[0] + regime.lyapunov_width
    assert spectrum.exponents[0] > spectrum.widths[0] > 0.0
    assert 1.0 < spectrum.dimension < 3.0
    assert "periods = 15" in error_of(regime.lyapunov_spectrum, 15)


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


def test_the_dimension_of_kaplan_and_yorke_and_what_contacts_forget():
    def dimension(*values):
        return LyapunovSpectrum(np.array(values), *[np.zeros(1)] * 3, 0.0).dimension

    assert dimension(-0.1, -0.2) == 0.0
    assert dimension(0.3, -0.1, -0.4) == 2.5
    assert dimension(0.3, -0.2) == 2.0
    # an impact with e = 0 leaves fewer variations than there were
    vectors, logs = classification._orthonormalized(np.array([[3.0, 4.0], [6.0, 8.0]]))
    np.testing.assert_array_equal(vectors, [[0.6, 0.8], [0.0, 0.0]])
    np.testing.assert_array_equal(logs, [np.log(5.0), -np.inf])


def test_any_values_along_a_trajectory_have_a_spectrum(error_of):
    """And the period by recurrence, of a section or of a trajectory alone."""
    system = nv.load_system("ssul-set6", omega=5.5)
    record = ("trajectory", "impacts")
    orbit = nv.simulate(system, 8, transient=200, samples=64, record=record, quiet=True)
    states = orbit.trajectory
    own = nv.spectrum(orbit, states[:, 2] - states[:, 0])
    np.testing.assert_array_equal(own.amplitude, nv.spectrum(orbit, "u").amplitude)
    assert orbit.recurrence == 1
    assert "the trajectory 512 times" in error_of(nv.spectrum, orbit, states[1:, 0])
    assert "signal" in error_of(nv.spectrum, orbit, [None])
    bare = replace(orbit, trajectory=None, time=None)
    with pytest.raises(nv.RequestError, match="holds no section"):
        _ = bare.recurrence
    assert replace(bare, section=states[63::64]).recurrence == 1
