"""Periods that are copied are, to the last bit, those that would have been computed.

(Run by `contract/test_plain.py`: only plain Python can switch the repetition off.)
"""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.kernels.orbit import orbit, repetition
from nlds_vines.kernels.orbit.repetition import same_bits
from scans import computed, scan_of

WANT = ["section", "impacts", "energy", "peak", "clearance", "response", "impact_section"]
SCANS = {
    "one wall": ("ssul-set6", [6.05, 7.39]),  # 6.05: sections cut impacts; 7.39: irregular
    "two walls": ("ssbl", [5.2]),
    "irregular": ("vi-nes", [6.28]),
}


def never(reference, arc, watch, impacts, k, p, last, y):
    """Take no period for a repetition (arguments of `repetition.periods_to_run`)."""
    return last


@pytest.fixture
def lengths(monkeypatch):
    """Return a list that takes the length of each repetition."""
    noted, periods_to_run = [], orbit.periods_to_run

    def counted(reference, arc, watch, impacts, k, p, last, y):
        end = periods_to_run(reference, arc, watch, impacts, k, p, last, y)
        noted.extend([int(reference[repetition.AT.cycle])] if end < last else [])
        return end

    monkeypatch.setattr(orbit, "periods_to_run", counted)
    return noted


@pytest.mark.parametrize("case", SCANS)
def test_all_records_have_the_same_bits(case, lengths, monkeypatch):
    name, frequencies = SCANS[case]
    scan = scan_of(name, WANT, {"omega": frequencies}, transient=170, periods=43)
    copied = computed(scan)
    monkeypatch.setattr(orbit, "periods_to_run", never)
    run = computed(scan)
    assert bool(lengths) == (case != "irregular")
    assert copied.keys() == run.keys()
    for name, values in run.items():
        if "_rms" in name or name.startswith("power"):  # a product for a sum of equal terms
            margin = 1e-15 if name.endswith("reduction") else 0.0
            np.testing.assert_allclose(copied[name], values, rtol=1e-15, atol=margin)
        else:
            assert np.asarray(copied[name]).tobytes() == np.asarray(values).tobytes(), name


@pytest.mark.parametrize(
    ("omega", "periods"), [(6.05, 200), (6.2, 200)]
)  # 6.2: an impact is under way at the end
def test_rows_of_impacts_have_the_same_bits(omega, periods, lengths, monkeypatch):
    system = nv.load_system("ssul-set6").with_(omega=omega)
    copied = nv.simulate(system, periods, transient=7)
    monkeypatch.setattr(orbit, "periods_to_run", never)
    run = nv.simulate(system, periods, transient=7)
    assert lengths
    assert np.isnan(run.impacts["release"][-1]) == (omega == 6.2)
    assert copied.impacts.tobytes() == run.impacts.tobytes()
    assert copied.section.tobytes() == run.section.tobytes()
    assert copied.state.tobytes() == run.state.tobytes()


def test_zeros_of_either_sign_are_two_states():
    assert same_bits(1.5, 1.5)
    assert same_bits(np.nan, np.nan)
    assert same_bits(-0.0, -0.0)
    assert not same_bits(0.0, -0.0)
    assert not same_bits(1.0, np.nextafter(1.0, 2.0))
