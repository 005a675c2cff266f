"""Spectra in archives: closed forms, Parseval, what tells periodic, quasiperiodic and chaotic."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.labels import KEPT
from nlds_vines.model.linear_response import response
from nlds_vines.orbits.spectrum import LINES

pytestmark = pytest.mark.kernels

ALL = ["spectrum", "lines", "broadband"]


def scanned(
    tmp_path, system, want, vary=None, sampling=None, spectrum=None, name="s.h5", **changes
):
    nv.scan(
        system,
        vary=vary or {"omega": {"values": [5.6, 6.28, 7.1]}},
        sampling={"transient": 400, "periods": 24} | (sampling or {}),
        record={"want": want},
        spectrum=spectrum or {},
        to=tmp_path / name,
        quiet=True,
        **changes,
    )
    return nv.read(tmp_path / name)


def test_a_sine_has_one_line_with_the_amplitude_and_phase_of_the_closed_form(tmp_path):
    with scanned(tmp_path, "none", ALL, sampling={"transient": 4000}) as view:
        exact = response(nv.load_system("none"), view["omega"]).X1
        assert list(view["signal"]) == ["x1"]
        assert view["line_period"].ravel().tolist() == [1, 1, 1]
        amplitude, phase = view["line_amplitude"][:, 0, 0], view["line_phase"][:, 0, 0]
        assert amplitude[:, 0] == pytest.approx(abs(exact), rel=1e-13)
        assert phase[:, 0] == pytest.approx(np.angle(exact), abs=1e-12)
        assert (amplitude[:, 1:] < 1e-13 * abs(exact)[:, np.newaxis]).all()
        spectrum = view["spectrum"][:, 0, 0]
        assert view["frequency"][24] == 1.0
        assert spectrum[:, 24] == pytest.approx(abs(exact), rel=1e-13)
        assert (view["broadband"] < 1e-20).all()
        assert set(view["spectral_label"].ravel().tolist()) == {"T"}


def test_a_disagreement_of_spectra_and_labels_is_told(tmp_path, answer):
    """An orbit that settles slowly: by its multipliers T,0, but its section does not recur yet."""
    options = ["--set", "c1=2", "--vary", "omega=6:6.3:2", "--transient", "20", "--periods", "120"]
    command = ["bifurcation", "--system", "none", *options, "--record", "regime,broadband"]
    report = answer(*command, "-o", tmp_path / "slow.h5").splitlines()
    lines = [line for line in report if line.startswith("spectra")]
    with nv.read(tmp_path / "slow.h5") as view:
        labels, spectral = view["label"].ravel(), view["spectral_label"].ravel()
        agree, words = view["spectra_agree"].ravel(), view.flags("spectra_agree")
    assert set(labels.tolist()) == {"T,0"}
    assert "T" not in spectral.tolist()
    judged = agree[spectral != "unclear"]
    assert {words[code] for code in judged.tolist()} == {"no"}
    (line,) = lines
    assert line.startswith(f"spectra disagree: {len(judged)} of {len(judged)} orbits: ")


def test_the_linear_damper_has_its_closed_form_in_both_signals(tmp_path):
    with scanned(tmp_path, "tmd", ["lines"], sampling={"transient": 4000}) as view:
        both = response(nv.load_system("tmd"), view["omega"])
        exact = np.stack([both.X1, both.X2 - both.X1], axis=1)
        assert view["line_amplitude"][:, 0, :, 0] == pytest.approx(abs(exact), rel=1e-12)
        assert view["line_phase"][:, 0, :, 0] == pytest.approx(np.angle(exact), abs=1e-11)
        assert view["line_amplitude"].shape[-1] == LINES
        assert "spectrum" not in view
        assert "broadband" not in view


def test_lines_of_a_subharmonic_orbit_make_it_again(tmp_path):
    """A 3T orbit is the sum of its recorded lines but for those beyond them."""
    system = nv.load_system("ssul-set6", omega=7.45)
    sampling = {"transient": 3000, "periods": 25}  # no multiple of 3
    with scanned(
        tmp_path, system, ["lines"], {"omega": {"values": [7.45]}}, sampling, {"samples": 256}
    ) as view:
        assert view["line_period"].item() == 3
        orbit = nv.simulate(system, 3, transient=3000, record=["trajectory"], samples=256)
        numbers = np.arange(1, LINES + 1)[:, np.newaxis]
        angle = numbers * system.parameters["omega"] * orbit.time / 3
        lines = view["line_amplitude"][0, 0, 0, :, np.newaxis]
        made = (lines * np.cos(angle + view["line_phase"][0, 0, 0, :, np.newaxis])).sum(axis=0)
        x1 = orbit.trajectory[:, 0]
        assert made == pytest.approx(x1 - x1.mean(), abs=3e-3 * np.ptp(x1))


def test_parseval_with_the_recorded_rms(tmp_path):
    spectrum = {"window": "rectangular", "samples": 512, "highest": 255.0, "signals": ["x1", "v1"]}
    want = ["response", "spectrum"]
    with scanned(tmp_path, "ssul-set6", want, spectrum=spectrum) as view:
        amplitude = view["spectrum"][:, 0]
        for i, (name, bound) in enumerate((("x1_rms", 1e-9), ("v1_rms", 1e-5))):
            squares = amplitude[:, i, 0] ** 2 + 0.5 * (amplitude[:, i, 1:] ** 2).sum(axis=1)
            assert squares == pytest.approx(view[name][:, 0] ** 2, rel=bound)
        assert view.units("spectrum") == "m, m/s"


def test_the_broadband_share_tells_periodic_quasiperiodic_and_chaotic_apart(tmp_path):
    vary = {"omega": {"values": [7.0, 7.38125, 7.3825, 7.385, 7.4175, 7.42, 7.45]}}
    sampling = {"transient": 1500, "periods": 240}
    with scanned(tmp_path, "ssul-set6", ["regime", "broadband"], vary, sampling) as view:
        labels, share = view["label"][:, 0], view["broadband"][:, 0].max(axis=1)
        chaos = share[labels == "chaos"]
        lines = share[labels == "quasiperiodic"]
        periodic = share[np.char.find(labels.astype(str), "T,") > 0]
        assert min(map(len, (chaos, lines, periodic))) >= 1
        assert periodic.max() < 1e-20
        assert lines.min() > 1e-9
        assert lines.max() < 2e-4
        assert chaos.min() > 2e-3


@pytest.mark.parametrize(("periods", "judged"), [(60, 0), (120, 4), (240, 4)])
def test_no_quasiperiodic_motion_is_called_broadband(tmp_path, periods, judged):
    """With 60 periods all four have shares above 1e-3, because their lines crowd."""
    vary = {"omega": {"values": [7.368, 7.416, 7.42, 7.423]}}
    sampling = {"transient": 1500, "periods": periods}
    with scanned(tmp_path, "ssul-set6", ["regime", "broadband"], vary, sampling) as view:
        assert set(view["label"].ravel().tolist()) == {"quasiperiodic"}
        assert "broadband" not in view["spectral_label"]
        assert KEPT["no"] not in view["spectra_agree"]
        assert np.count_nonzero(view["spectra_agree"] == KEPT["yes"]) == judged


def test_a_waterfall_shows_amplitudes_in_decades(tmp_path):
    with scanned(tmp_path, "tmd", ALL) as view:
        path = view.path
        amplitude = view["spectrum"][:, 0, 0, 1:]
    figure = nv.plot(path, "spectrum:x1,broadband:u,line_amplitude:x1")
    waterfall, broadband, lines = (axes for axes in figure.axes if axes.get_ylabel())
    (mesh,) = waterfall.collections
    values = np.asarray(mesh.get_array())
    assert values.shape == amplitude.T.shape
    assert values.max() == amplitude.max()
    assert mesh.norm.vmin == pytest.approx(1e-6 * amplitude.max())
    assert waterfall.get_ylabel() == r"spectrum of $x_1$, $\Omega/\omega$"
    assert broadband.get_ylabel() == "broadband share, $x_2-x_1$"
    assert lines.get_ylabel() == "amplitudes of lines, $x_1$ [m]"
    assert lines.get_yscale() == "log"


def test_a_failed_orbit_has_no_spectrum(tmp_path):
    vary = {"omega": {"values": [1e-7, 6.28]}}  # too stiff: millions of cells
    with scanned(tmp_path, "ssul-set6", ["impacts", *ALL], vary) as view:
        assert view["status"][0, 0] != 0
        assert np.isnan(view["spectrum"][0]).all()
        assert np.isnan(view["broadband"][0]).all()
        assert view["spectral_label"][0, 0] == ""
        assert np.isfinite(view["spectrum"][1]).all()
