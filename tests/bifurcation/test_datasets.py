"""The table of what an archive holds: only what was asked for and can happen in the scene."""

import re

import numpy as np
import pytest

from nlds_vines.model.labels import FLAGS
from nlds_vines.orbits.records import NOT_COMPUTED, STATUS, WANTS
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


def test_without_walls_there_are_no_impacts_and_without_damper_no_second_energy():
    assert names("tmd", ["energy", "regime"]) == {
        *("E1max", "E2max", "reduction", "periodicity", "regime", "label", "status")
    }
    assert names("none", ["energy"]) == {"E1max", "status"}


def test_what_two_wants_share_is_there_once():
    assert list(scan(want=["impacts", "regime"]).table.datasets).count("impact_count") == 1


def test_dimensions_are_axes_start_and_tail():
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


def test_scales_agree_with_sizes_and_name_the_starts():
    request = scan(start={"policy": "random", "count": 3, "seed": 1})
    assert {scale.name: scale.values.size for scale in request.scales()} == request.table.length
    assert request.start.names == ("random 0", "random 1", "random 2")
    assert scan(want=["regime"], start={"policy": "down"}).start.names == ("down",)


def test_components_follow_the_scene():
    assert scan("none", ["section"]).system.scene.components == ("x1", "v1")
    assert scan().system.scene.components == ("x1", "v1", "x2", "v2")


def test_types_units_and_fills_are_those_of_the_contract():
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


def test_fill_values_say_that_nothing_was_computed():
    arrays = unfilled(scan())
    assert np.all(arrays["status"] == NOT_COMPUTED)
    assert arrays["status"].dtype == np.int8
    assert np.all(np.isnan(arrays["section"]))
    assert arrays["label"].tolist() == [[""]] * 3


def test_flags_are_words_that_cf_allows_in_the_order_of_their_codes():
    table = scan().table.datasets
    two_walls = scan("ssbl", ["impact_section", "modulation"]).table.datasets
    coded = [table[name] for name in ("regime", "status", "spectra_agree")]
    for dataset in (*coded, two_walls["impact_wall"], two_walls["capture"]):
        assert all(re.fullmatch(r"[A-Za-z0-9_.+@-]+", word) for word in dataset.flags)
    assert list(table["regime"].flags.items()) == list(zip(FLAGS, range(6), strict=True))
    assert table["section"].flags is None


def test_every_status_has_a_name_and_a_remedy():
    assert list(STATUS) == list(range(len(STATUS)))
    for status in STATUS.values():
        assert status.meaning.split(".")[0] == status.name
        assert status.remedy.endswith(".")
    assert "--resume" in STATUS[NOT_COMPUTED].meaning


def test_most_bytes_counts_every_number():
    request = scan(want=["section", "energy"])
    numbers = sum(array.nbytes for array in unfilled(request).values())
    assert request.table.most_bytes == numbers + 64 * sum(request.table.length.values())
