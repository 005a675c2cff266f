"""What an archive holds, what labels of several starts mean, and for how long chaos was watched."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.dataset import Dataset
from nlds_vines.bifurcation.picture.choices import check_show, in_legend, quantities, usual_show
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.engine.batch import agreement
from nlds_vines.engine.records import NOT_COMPUTED, STATUS, WANTS
from nlds_vines.engine.solver_settings import EFFORTS, most_watched
from nlds_vines.engine.spectrum import LINES, spectral_label, spectrum_of
from nlds_vines.model.labels import (
    FLAGS,
    KEPT,
    by_frequency,
    coexisting,
    finals,
    least_lifetime,
    most_frequent,
    share_of,
)
from nlds_vines.scans.run_report import Report
from scans import scan_of, unfilled


def scan(system="ssul-set6", want=WANTS, start="rest", vary=None):
    return scan_of(system, want, vary, start, transient=1, periods=4)


@pytest.mark.parametrize(
    ("system", "want", "expected"),
    [
        ("ssul-set6", "section", "section"),
        ("ssul-set6", "impacts", "impact_count impact_rate periodicity"),
        ("ssul-set6", "energy", "E1max E2max reduction"),
        ("ssul-set6", "regime", "periodicity impact_count impact_rate regime label"),
        ("ssul-set6", "clearance", "clearance"),
        ("ssul-set6", "impacts regime", "impact_count impact_rate periodicity regime label"),
        ("tmd", "energy regime", "E1max E2max reduction periodicity regime label"),
        ("none", "energy", "E1max"),
    ],
)
def test_each_want_brings_the_datasets_that_its_scene_can_have(system, want, expected):
    datasets = scan(system, want.split()).table.datasets
    assert sorted(datasets) == sorted([*expected.split(), "status"])


def test_dimensions_are_axes_start_and_tail_and_scales_agree_with_them():
    assert scan("none", ["section"]).system.scene.components == ("x1", "v1")
    assert scan().system.scene.components == ("x1", "v1", "x2", "v2")
    vary = {"omega": {"values": [5.0, 6.0]}, "P": {"values": [1.0, 2.0, 3.0]}}
    request = scan(vary=vary, start={"policy": "random", "count": 5, "seed": 1})
    by_name = request.table.datasets
    assert by_name["section"].dims == ("omega", "P", "start", "forcing_period", "component")
    assert by_name["section"].tail == ("forcing_period", "component")
    assert by_name["label"].dims == ("omega", "P", "start")
    lengths = request.table.length
    axes = {"omega": 2, "P": 3, "start": 5}
    of_state = dict.fromkeys(("component", "multiplier", "exponent"), 4)
    of_spectra = {"signal": 2, "frequency": 33, "line": 24}
    assert lengths == axes | of_state | of_spectra | {"forcing_period": 4, "impact": 16, "part": 2}
    assert "part" not in scan(want=["section"]).table.length
    assert scan("ssbl", ["impacts"]).table.length["wall"] == 2
    request = scan(start={"policy": "random", "count": 3, "seed": 1})
    assert {scale.name: scale.values.size for scale in request.scales()} == request.table.length
    assert request.start.names == ("random 0", "random 1", "random 2")
    assert scan(want=["regime"], start={"policy": "down"}).start.names == ("down",)


def test_types_units_fills_and_flags_are_those_of_the_contract():
    table = scan().table.datasets
    whole = ("periodicity", "impact_count", "settling", "attractor", "arrival", "line_period")
    assert {name: dataset.dtype for name, dataset in table.items()} == {
        **dict.fromkeys(table, "float64"),
        **dict.fromkeys(whole, "int32"),
        **dict.fromkeys(("regime", "status", "spectra_agree"), "int8"),
        **dict.fromkeys(("label", "spectral_label"), "str"),
    }
    energies = {"E1max", "E2max", "E1peak", "E2peak"}
    assert {name for name in table if table[name].units == "J"} == energies
    assert table["clearance"].units == "m"
    assert table["section"].units == "m, m/s"
    assert all(dataset.units and dataset.long_name for dataset in table.values())
    # fill values say that nothing was computed
    arrays = unfilled(scan())
    assert np.all(arrays["status"] == NOT_COMPUTED)
    assert arrays["status"].dtype == np.int8
    assert np.all(np.isnan(arrays["section"]))
    assert arrays["label"].tolist() == [[""]] * 3
    # flags are words that CF allows, in the order of their codes
    two_walls = scan("ssbl", ["impact_section", "modulation"]).table.datasets
    coded = [table[name] for name in ("regime", "status", "spectra_agree")]
    for dataset in (*coded, two_walls["impact_wall"], two_walls["capture"]):
        assert all(re.fullmatch(r"[A-Za-z0-9_.+@-]+", word) for word in dataset.flags)
    assert list(table["regime"].flags.items()) == list(zip(FLAGS, range(6), strict=True))
    assert table["section"].flags is None
    # the most bytes count every number
    request = scan(want=["section", "energy"])
    numbers = sum(array.nbytes for array in unfilled(request).values())
    assert request.table.most_bytes == numbers + 64 * sum(request.table.length.values())


def test_every_status_has_a_name_and_a_remedy():
    assert list(STATUS) == list(range(len(STATUS)))
    for status in STATUS.values():
        assert status.meaning.split(".")[0] == status.name
        assert status.remedy.endswith(".")
    assert "--resume" in STATUS[NOT_COMPUTED].meaning


def test_a_scan_knows_how_long_it_watches_and_tells_it_of_chaos_alone():
    assert most_watched(600, 120, "quick") == 720
    assert most_watched(600, 120, "standard") == 720 + 3000
    assert most_watched(0, 1, "thorough") == 1 + sum(EFFORTS["thorough"])
    # in the summary
    report = Report(watched=3720)
    report.labels.update(["T,1", "3T,2"])
    assert report.remarks() == []
    report.labels.update(["chaos"])
    (line,) = report.remarks()
    assert "watched for 3720 periods" in line
    assert "1242 periods or more" in line
    # in a legend
    sampling = {"sampling": {"transient": 300, "effort": "thorough"}}
    archive = SimpleNamespace(request=lambda content, load: load(None, sampling))
    assert in_legend("chaos", archive) == f"chaos (for {300 + 120 + 51_000} T)"
    assert in_legend("3T,2", archive) == "3T,2"
    assert in_legend("chaos → T,0", archive) == "chaos → T,0"
    # the bound is that of the exponential law
    least = least_lifetime(3720)
    assert np.exp(-3720 / least) == pytest.approx(0.05, rel=1e-12)
    assert least_lifetime(3720, 0.5) > least


LATE = "transient chaos to T,0"
CELLS = np.array(
    [
        ["T,1", "T,1", "T,1", "T,1"],
        ["T,0", "2T,1", "T,0", LATE],
        [LATE, LATE, "T,0", "chaos"],
        ["chaos", "chaos", "T,0", "undetermined"],
        ["undetermined", "failed", "undetermined", "undetermined"],
        ["2T,1", "T,0", "quasiperiodic", "3T,2"],
    ],
    dtype=object,
)


def test_starts_of_a_cell_are_shared_out_counted_and_stood_for():
    # a transient ends where it says
    assert finals(CELLS)[2].tolist() == ["T,0", "T,0", "T,0", "chaos"]
    # shares count final regimes, or the way there
    np.testing.assert_allclose(share_of(CELLS, "T,0"), [0, 0.75, 0.75, 0.25, 0, 0.25])
    np.testing.assert_allclose(share_of(CELLS, LATE), [0, 0.25, 0.5, 0, 0, 0])
    assert share_of(CELLS, "9T,9").max() == 0
    # coexisting regimes are counted, and gaps in knowledge are not
    # in the third cell chaos may be the transient of the others
    assert coexisting(CELLS).tolist() == [1, 2, 1, 2, 0, 4]
    # the most frequent regime stands for a cell
    labels = most_frequent(CELLS).tolist()
    assert labels[:5] == ["T,1", "T,0", LATE, "chaos", "undetermined"]
    assert labels[5] == "T,0"  # all four once: the one most frequent elsewhere
    # of equally many a known one does
    cells = np.array([["undetermined", "3T,2"], ["undetermined", "undetermined"]], dtype=object)
    assert most_frequent(cells).tolist() == ["3T,2", "undetermined"]
    # any shape and order of starts
    grid = CELLS.reshape(2, 3, 4)
    assert most_frequent(grid).shape == coexisting(grid).shape == share_of(grid, "T,1").shape
    turned = grid[..., ::-1]
    assert most_frequent(turned).tolist() == most_frequent(grid).tolist()
    assert coexisting(turned).tolist() == coexisting(grid).tolist()
    assert by_frequency(grid)[0] == ("T,0", 5)


RANGE = np.linspace(5.0, 8.0, 9)


def known(*names):
    """Quantities of these names, as a scan of two parameters records them."""
    dims = ("omega", "P", "start")
    return quantities([Dataset(name, dims, "float64", "1", name, np.nan) for name in names], ())


def test_what_a_map_shows_unasked():
    assert usual_show(known("E1max"), True) == "regimes"
    assert usual_show(known("impact_rate", "E2max"), False) == "E2max"
    assert usual_show(known("status"), False) is None


@pytest.mark.parametrize(
    ("show", "axes", "starts", "labeled", "message"),
    [
        ("shares", 1, 4, True, "vary two parameters"),
        ("regime", 2, 4, True, "did you mean 'regimes'"),
        ("share:", 2, 4, True, "share:LABEL"),
        ("lyapunov", 2, 4, True, "not recorded"),
        ("regimes", 2, 4, False, "scan with regime in --record"),
        ("shares", 2, 1, True, "several starts"),
        ("share:T,0", 2, 1, True, "several starts"),
        ("coexisting", 2, 1, True, "several starts"),
    ],
)
def test_what_cannot_be_shown_is_refused(show, axes, starts, labeled, message, error_of):
    for possible in ("regimes", "coexisting", "shares", "share:T,0", "E1max"):
        check_show(possible, [RANGE, RANGE], 4, known("E1max"), True)
    line = error_of(check_show, show, [RANGE] * axes, starts, known("E1max"), labeled)
    assert message in line


def test_verdicts_and_spectra_agree_where_both_can_tell():
    codes = {name: FLAGS[name] for name in ("periodic", "quasiperiodic", "chaotic", "undetermined")}
    rows = [
        ("periodic", 1, "T", "yes"),
        ("periodic", 3, "3T", "yes"),
        ("periodic", 3, "T", "no"),
        ("periodic", 40, "lines", "no"),
        ("periodic", 40, "unclear", ""),
        ("periodic", 41, "lines", ""),  # longer than a third of the 120 periods
        ("periodic", 41, "broadband", ""),
        ("quasiperiodic", 0, "lines", "yes"),
        ("quasiperiodic", 0, "broadband", "no"),
        ("chaotic", 0, "broadband", "yes"),
        ("chaotic", 0, "3T", "no"),
        ("undetermined", 0, "lines", ""),
        ("chaotic", 0, "", ""),
    ]
    regime, period, spectral, expected = (np.array(column) for column in zip(*rows, strict=True))
    agreed = agreement(np.array([codes[word] for word in regime]), period, spectral, 120)
    assert agreed.tolist() == [KEPT.get(word, -1) for word in expected]
    # the words for what a spectrum says
    shares = (1e-5, 5e-4, 1e-2)
    assert [spectral_label(1, 0.0, 60), spectral_label(3, 1e-2, 60)] == ["T", "3T"]
    assert [spectral_label(0, s, 120) for s in shares] == ["lines", "unclear", "broadband"]
    assert {spectral_label(0, s, 119) for s in shares} == {"unclear"}
    # lines anywhere leave no background, and noise does
    time = np.arange(240 * 64) / 64
    lines = np.cos(2 * np.pi * time) + 0.3 * np.cos(2 * np.pi * 0.6180339 * time + 1.0)
    assert spectrum_of(lines, 64, 1.0, window="hann").background_share(961) < 1e-5
    noise = np.random.default_rng(1).normal(size=time.size)
    assert 0.5 < spectrum_of(noise, 64, 1.0, window="hann").background_share(961) < 0.9
    assert spectrum_of(0.0 * time, 64, 1.0, window="hann").background_share(961) == 0.0


def test_a_scan_without_spectra_keeps_its_hash_and_one_with_them_its_file():
    plain = load_scan("ssul-set6")
    assert "spectrum" not in plain.document()
    changed = {"record": {"want": ["lines"]}, "spectrum": {"signals": ["u"], "samples": 128}}
    scan = load_scan("ssul-set6", changed)
    assert load_scan(scan.document()) == scan
    assert scan.table.shape("line_amplitude") == (1201, 1, 1, LINES)
    bare = load_scan("none", {"record": {"want": ["lines"]}, "set": {}})
    assert tuple(bare.spectral.signals) == ("x1",)


@pytest.mark.kernels
def test_parts_are_taken_by_the_values_of_dimensions(tmp_path, error_of):
    vary = {"omega": [5.0, 6.0, 7.0]}
    how = {"vary": vary, "start": "both", "record": ["section", "energy"], "quiet": True}
    how["sampling"] = {"transient": 3, "periods": 2}
    scan = nv.scan("ssul-set6", **how)
    stored = nv.scan("ssul-set6", to=tmp_path / "a.h5", **how)
    for one in (scan, stored):
        part = one.sel(omega=6.4, start="down")
        assert part["E1max"] == one["E1max"][1, 1]
        assert (part["section"] == one["section"][1, 1]).all()
    assert scan.sel(start="up")["E1max"].shape == (3,)
    assert scan.sel().keys() == scan.sel(omega=5.0).keys()
    assert "omega = 8 lies outside 5 to 7" in error_of(scan.sel, omega=8.0)
    assert "'sideways'; allowed: up, down" in error_of(scan.sel, start="sideways")
    assert "unknown dimension" in error_of(scan.sel, P=1.0)
    orbit = scan.orbit(omega=6.4, start="down", quiet=True)
    assert (orbit.section == scan["section"][1, 1]).all()
