"""Response spectra of a record that others have published, beside the largest numbers here."""

import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from scipy.linalg import expm

import nlds_vines as nv
from nlds_vines.loads import response_spectrum

RECORD = Path(__file__).parent / "eqsig_motion.txt"
STEP, ZETA, G = 0.01, 0.05, 9.81
MOTION = {"file": str(RECORD), "dt": STEP, "unit": "m/s^2"}

SPECTRUM = {
    0.197472: 0.226874911, 0.286711: 0.213220885, 0.391194: 0.335769751, 0.501593: 0.392253197,
    0.604394: 0.411810516, 0.774959: 0.468541548, 0.877523: 0.483962279, 1.05737: 0.289696367,
    1.27408: 0.387232227, 1.5352: 0.191371052, 1.84984: 0.149200073,
    2.6858: 0.060381448, 3.89952: 0.038648321, 5.66173: 0.018137057,
}  # fmt: skip
"""Period [s] and spectral acceleration [g], (2 pi / T)^2 times the largest displacement relative to
the ground, of 5 % damping: test_motion_true_spectra_acc.csv of eqsig at the record's address."""


PERIODS = np.array(list(SPECTRUM))


def test_response_spectrum_is_the_published_one():
    """Within 0.02 % above 0.6 s, and 0.33 % below, where the published one is of few samples."""
    spectrum = nv.response_spectrum(MOTION, ZETA, PERIODS)
    off = np.abs(spectrum.pseudo_acceleration / G / np.array(list(SPECTRUM.values())) - 1.0)
    assert off.max() < 3.3e-3
    assert off[PERIODS > 0.6].max() < 2e-4
    values = np.loadtxt(RECORD)
    for i in (2, 8):
        largest = absolute_acceleration(values, 2.0 * np.pi / PERIODS[i])
        assert spectrum.absolute_acceleration[i] == pytest.approx(largest, rel=1e-6)


def test_oscillators_down_to_one_sample_step(monkeypatch):
    """Against 20 times as many places, and a record with further samples on its lines."""
    periods = [STEP, 1.7 * STEP, 0.05, 0.3, 2.0]
    spectrum = nv.response_spectrum(MOTION, ZETA, periods)
    times = STEP * np.arange(4682)
    instants = np.unique(np.concatenate([times, times[::3] + 0.3 * STEP]))[:-1]
    values = np.interp(instants, times, np.loadtxt(RECORD)[:4682])
    uneven = {"times": instants.tolist(), "values": values.tolist(), "unit": "m/s^2"}
    others = [nv.response_spectrum(uneven, ZETA, periods)]
    monkeypatch.setattr(response_spectrum, "SUBSTEPS", 20 * response_spectrum.SUBSTEPS)
    others.append(nv.response_spectrum(MOTION, ZETA, periods))
    for other in others:
        for name in ("displacement", "absolute_acceleration"):
            np.testing.assert_allclose(getattr(spectrum, name), getattr(other, name), rtol=1e-5)


def test_spectra_in_closed_form():
    """A step: 1 + exp(-pi zeta / sqrt(1 - zeta^2)); a pulse of half a period: twice its height."""
    step = {"times": [0.0, 0.01, 0.02, 3.0], "values": [2.0] * 4, "unit": "m/s^2", "uneven": True}
    for zeta in (0.0, 0.05, 0.3):
        spectrum = nv.response_spectrum(step, zeta, [0.5, 1.0])
        peak = 2.0 * (1.0 + math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2)))
        np.testing.assert_allclose(spectrum.pseudo_acceleration, peak, rtol=1e-4)
    pulse = {"times": [0.0, 0.1], "values": [1.0, 1.0], "unit": "g"}
    spectrum = nv.response_spectrum(pulse, 0.0, [10.0])  # an impulse: v = 0.1 g, x = v / omega
    speed = 9.80665 * 0.1
    assert spectrum.displacement[0] == pytest.approx(speed * 10.0 / (2 * math.pi), rel=1e-3)
    np.testing.assert_allclose(spectrum.pseudo_velocity, speed, rtol=1e-3)


def test_a_spectrum_is_drawn_and_tabled(tmp_path):
    spectrum = nv.response_spectrum(MOTION)
    assert spectrum.periods[[0, -1]].tolist() == pytest.approx([0.01, 5.0])
    (axes,) = spectrum.plot().axes
    pseudo, absolute = axes.get_lines()
    np.testing.assert_array_equal(pseudo.get_ydata(), spectrum.pseudo_acceleration)
    np.testing.assert_array_equal(absolute.get_ydata(), spectrum.absolute_acceleration)
    assert spectrum.plot(axes) is axes.figure
    assert list(spectrum.to_dataframe()["displacement"]) == spectrum.displacement.tolist()
    assert "peak 1.41" in repr(spectrum)
    spectrum.to_csv(tmp_path / "spectrum.csv")
    frame = pandas.read_csv(tmp_path / "spectrum.csv")
    pandas.testing.assert_frame_equal(frame, spectrum.to_dataframe(), rtol=1e-15)
    with pytest.raises(nv.RequestError, match="exists"):
        spectrum.to_csv(tmp_path / "spectrum.csv")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"record": {"times": [0, 1], "values": [0, 1], "unit": "N"}}, "force"),
        ({"record": "none.AT2"}, "none.AT2"),
        ({"zeta": 1.0}, "zeta"),
        ({"zeta": "x"}, "zeta"),
        ({"periods": [0.0]}, "periods"),
        ({"periods": [[1.0]]}, "periods"),
    ],
)
def test_faulty_spectra_get_one_line(changes, words, error_of):
    record = {"times": [0.0, 1.0], "values": [0.0, 1.0], "unit": "g"}
    assert words in error_of(nv.response_spectrum, **{"record": record, **changes})


@pytest.mark.kernels
def test_response_histories_have_the_spectrum_s_largest_numbers():
    omega = 2.0 * np.pi / PERIODS
    histories = nv.response_history(
        nv.load_system("none", m1=1.0, k1=1.0, zeta1=ZETA),
        load={"record": MOTION},
        vary={"k1": {"values": np.sort(omega**2).tolist()}},
        duration=55.0, quiet=True,
    )  # fmt: skip
    spectrum = nv.response_spectrum(MOTION, ZETA, PERIODS)
    for mine, other in (("x1_max", "displacement"), ("a1_max", "absolute_acceleration")):
        expected = getattr(spectrum, other)
        np.testing.assert_allclose(histories[mine][0, ::-1], expected, rtol=9e-6)


def absolute_acceleration(values, omega):
    """Return the largest absolute acceleration, by the matrix exponential over a line's parts."""
    parts = 40
    A = np.array([
        [0, 1, 0, 0], [-(omega**2), -2 * ZETA * omega, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0]
    ])  # fmt: skip
    step, state, most = expm(A * STEP / parts), np.zeros(4), 0.0
    for value, change in zip(values[:-1], np.diff(values) / STEP, strict=True):
        state[2:] = value, change
        for _ in range(parts):
            state = step @ state
            most = max(most, abs(omega**2 * state[0] + 2 * ZETA * omega * state[1]))
    return most
