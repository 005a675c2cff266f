"""The record `modulation` of a free mass between rigid walls, beside the closed form."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.orbits.records import modulation_of

pytestmark = pytest.mark.kernels


def recorded(path, clearance, omega, start):
    """Return the arrays (omega, starts) of a scan of `vi-nes` over omega, by name."""
    request = {
        "system": "vi-nes",
        "set": {"C": clearance, "D": clearance},
        "vary": {"omega": {"values": list(omega)}},
        "start": start,
        "sampling": {"transient": 1500, "periods": 400},
        "record": {"want": ["modulation", "impacts"]},
    }
    nv.scan(request, to=path, quiet=True)
    with nv.read(path) as view:
        words = view.flags("capture")
        arrays = {name: view[name] for name in ("amplitude_min", "amplitude_max", "two_impacts")}
        captured = np.vectorize(words.get)(view["capture"])
        return arrays | {"rate": view["impact_rate"], "capture": captured}


def test_sustained_motion_is_that_of_the_closed_form(tmp_path):
    """Which starts all over reach, below resonance; the amplitude lies within 1 % of it."""
    omega = [0.95, 0.96, 0.97, 0.975]
    start = {"policy": "random", "count": 6, "seed": 1}
    arrays = recorded(tmp_path / "sustained.h5", 50.0, omega, start)
    assert (arrays["capture"] == "sustained_1_to_1").all()
    assert (arrays["two_impacts"] == 1.0).all()
    np.testing.assert_allclose(arrays["amplitude_min"], arrays["amplitude_max"], rtol=1e-6)
    response = nv.slow_manifold(nv.load_system("vi-nes", C=50.0, D=50.0)).response()
    there = np.isfinite(response.below)
    exact = np.interp(omega, response.below[there], response.amplitude[there])[:, np.newaxis]
    np.testing.assert_allclose(
        arrays["amplitude_max"], np.broadcast_to(exact, arrays["rate"].shape), rtol=0.01
    )


def test_beyond_the_best_clearance_there_is_no_sustained_motion(tmp_path):
    """Gamma = 0.4 > Gamma_opt = 0.339: without impacts, or strongly modulated."""
    omega = np.linspace(1.0, 1.02, 5)
    arrays = recorded(tmp_path / "wide.h5", 200.0, omega, {"policy": "up"})
    assert set(arrays["capture"].ravel()) == {"no_impacts", "strongly_modulated"}
    assert (arrays["rate"][2:] > 0.5).all()
    strong = arrays["capture"] == "strongly_modulated"
    assert (arrays["two_impacts"][strong] < 0.9).all()
    assert (arrays["amplitude_min"][strong] < 0.1 * arrays["amplitude_max"][strong]).all()
    still = ~strong
    np.testing.assert_allclose(
        arrays["amplitude_min"][still], arrays["amplitude_max"][still], rtol=1e-2
    )


def test_the_criterion_is_by_impacts_a_period():
    section = np.zeros((5, 1, 200, 4))
    counts = np.array(
        [[[0, 0, 0]], [[200, 197, 0]], [[200, 198, 0]], [[201, 201, 0]], [[400, 10, 0]]]
    )
    capture = modulation_of(section, np.ones((5, 1)), counts)["capture"]
    assert capture.ravel().tolist() == [0, 1, 2, 2, 3]
