"""What an archive holds: only what was asked for and can happen; for how long chaos was watched."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from nlds_vines.bifurcation.picture.choices import in_legend
from nlds_vines.bifurcation.run import Report
from nlds_vines.model.labels import FLAGS, least_lifetime
from nlds_vines.orbits.records import NOT_COMPUTED, STATUS, WANTS
from nlds_vines.orbits.solver_settings import EFFORTS, most_watched
from scans import scan_of, unfilled


def scan(system="ssul-set6", want=WANTS, start="rest", vary=None):
    return scan_of(system, want, vary, start, transient=1, periods=4)


def names(*args, **keywords):
    return set(scan(*args, **keywords).table.datasets)


@pytest.mark.parametrize(
    ("want", "expected"),
    [
        ("section", {"section"}),
        ("impacts", {"impact_count", "impact_rate", "periodicity"}),
        ("energy", {"E1max", "E2max", "reduction"}),
        ("regime", {"periodicity", "impact_count", "regime", "label"}),
        ("clearance", {"clearance"}),
    ],
)
def test_each_want_brings_its_datasets_and_status_alone(want, expected):
    assert names(want=[want]) == expected | {"status"}


def test_each_scene_has_the_datasets_and_components_that_it_can():
    assert names("tmd", ["energy", "regime"]) == {
        *("E1max", "E2max", "reduction", "periodicity", "regime", "label", "status")
    }
    assert names("none", ["energy"]) == {"E1max", "status"}
    assert list(scan(want=["impacts", "regime"]).table.datasets).count("impact_count") == 1
    assert scan("none", ["section"]).system.scene.components == ("x1", "v1")
    assert scan().system.scene.components == ("x1", "v1", "x2", "v2")


def test_dimensions_are_axes_start_and_tail_and_scales_agree_with_them():
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
    types = {name: dataset.dtype for name, dataset in table.items()}
    assert types == {
        **dict.fromkeys(table, "float64"),
        **dict.fromkeys(
            ("periodicity", "impact_count", "settling", "attractor", "arrival"), "int32"
        ),
        "line_period": "int32",
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


def test_a_scan_knows_how_long_it_watches():
    assert most_watched(600, 120, "quick") == 720
    assert most_watched(600, 120, "standard") == 720 + 3000
    assert most_watched(0, 1, "thorough") == 1 + sum(EFFORTS["thorough"])


def test_the_bound_is_that_of_the_exponential_law():
    """Chaos of that mean lifetime survives so long in one case of twenty."""
    least = least_lifetime(3720)
    assert np.exp(-3720 / least) == pytest.approx(0.05, rel=1e-12)
    lifetimes = np.random.default_rng(1).exponential(least, 200_000)
    assert (lifetimes > 3720).mean() == pytest.approx(0.05, abs=0.002)
    assert least_lifetime(3720, 0.5) > least


def test_only_of_chaos_the_summary_says_how_long_it_was_watched(tmp_path):
    report = Report(tmp_path / "a.h5", watched=3720)
    report.tally.labels.update(["T,1", "3T,2"])
    assert report.remarks() == []
    report.tally.labels.update(["chaos"])
    (line,) = report.remarks()
    assert "watched for 3720 periods" in line
    assert "1242 periods or more" in line


def test_only_chaos_has_a_time_in_a_legend():
    sampling = {"sampling": {"transient": 300, "effort": "thorough"}}
    archive = SimpleNamespace(request=lambda content, load: load(None, sampling))
    assert in_legend("chaos", archive) == f"chaos (for {300 + 120 + 51_000} T)"
    assert in_legend("3T,2", archive) == "3T,2"
    assert in_legend("chaos → T,0", archive) == "chaos → T,0"
