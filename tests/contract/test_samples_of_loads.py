"""Tables of samples under loads: sets of parameters and numbers of the load, one a row."""

import numpy as np
import pytest

import nlds_vines as nv

COLUMNS = {"k1": [3.8e4, 4.0e4], "impulse": [200.0, 400.0], "zeta1": [0.01, 0.03]}


def request_of(columns=COLUMNS, **changes):
    return nv.load_response_history(["none", "tmd"], {"samples": columns, **changes})


def test_each_case_has_the_parameters_and_the_load_of_its_row():
    request = request_of()
    assert (request.shape, request.cases) == ((2,), 4)
    for number in range(4):
        system, load = request.case(number)
        row = number % 2
        assert system.parameters["k1"] == COLUMNS["k1"][row]
        assert system.ratios["zeta1"] == pytest.approx(COLUMNS["zeta1"][row])
        assert load.impulse == COLUMNS["impulse"][row]
    again = nv.load_response_history(request.document())
    assert (again.hash, again.sampled) == (request.hash, request.sampled)
    assert request.hash != request_of({**COLUMNS, "impulse": [200.0, 401.0]}).hash


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"k1": [4e4, -1.0], "impulse": [1.0, 2.0]}, "k1 = -1.0"),
        ({"k3": [4e4], "impulse": [1.0]}, "k3"),
        ({"omega": [6.0], "impulse": [1.0]}, "the harmonic force is off"),
        ({"impulse": [1.0, float("nan")]}, "row 2: impulse = nan"),
    ],
)
def test_tables_that_do_not_fit_are_refused(columns, words, error_of):
    assert words in error_of(request_of, columns)


def test_a_table_beside_axes_is_refused(error_of):
    axes = {"impulse": {"values": [1.0, 2.0]}}
    assert "beside [vary]" in error_of(request_of, vary=axes)


@pytest.mark.kernels
def test_a_table_gives_the_peaks_of_single_histories():
    scan = nv.response_history(["none", "tmd"], samples=COLUMNS, duration=3.0, quiet=True)
    for row in range(2):
        values = {name: column[row] for name, column in COLUMNS.items() if name != "impulse"}
        systems = [nv.load_system(name, **values) for name in ("none", "tmd")]
        alone = nv.response_history(
            systems, impulse=COLUMNS["impulse"][row], duration=3.0, quiet=True
        )
        peaks = [one.numbers["E1max"] for one in alone.results.values()]
        assert scan["E1max"][:, row].tolist() == pytest.approx(peaks, rel=1e-12)
    with scan.path.read() as view:
        assert view.dims("E1max") == ("damper", "sample")
        assert view["damper"].tolist() == ["none", "tmd"]
        assert view["impulse"].tolist() == COLUMNS["impulse"]
    above, counted = scan.plot("E1max:exceedance,E1max").axes
    assert [axes.get_label() for axes in scan.plot().axes] == ["last_50:exceedance", "last_50"]
    assert np.array_equal(above.lines[0].get_ydata(), [1.0, 0.5])
    assert [stairs.get_data().values.sum() for stairs in counted.patches] == [1.0, 1.0]
    (axes,) = scan.plot("E1max:k1").axes
    for line, values in zip(axes.lines, scan["E1max"], strict=True):
        np.testing.assert_array_equal(line.get_xydata().T, [COLUMNS["k1"], values])
